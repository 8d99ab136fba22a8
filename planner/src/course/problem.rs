//! The jumps of one choice as a nonlinear program in their decisions.

use std::cell::RefCell;
use std::rc::Rc;

use saltus_numeric::Scalar;

use super::jumper::Slope;
use super::sqp::{Evaluation, Nlp};
use super::{Course, Flight, Jumper, Leap, Limit, Margin, Push, Side, Span};

/// Where each jump of a course is to take off and to land.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    /// Jump after jump.
    pub(super) leaps: Vec<Leap>,
    /// Where each of them lands (m).
    pub(super) windows: Vec<Span>,
    /// Indices of the grounds that they land on.
    pub(super) grounds: Vec<usize>,
}

impl Choice {
    /// The same with the pushes of these decisions.
    pub(super) fn pushed(&self, jumper: &dyn Jumper, decisions: &[f64]) -> Choice {
        let mut choice = self.clone();
        for (leap, x) in choice.leaps.iter_mut().zip(decisions.chunks_exact(2)) {
            leap.push = jumper.push(leap, [x[0], x[1]]);
        }
        choice
    }
}

/// The program of a choice: two variables a jump, the footholds follow.
///
/// Rows: the goal if it is exact, then jump after jump the jumper's margins and the landing's
/// distances from the ends of its window.
pub(super) struct Problem<'a> {
    pub(super) jumper: &'a dyn Jumper,
    pub(super) course: &'a Course,
    pub(super) choice: &'a Choice,
    /// Standard deviations that a landing keeps from the ends of its window.
    sigmas: f64,
    /// For each jump what was kept last, the latest first.
    known: Rc<RefCell<Vec<Vec<Keep>>>>,
}

/// What a landing keeps from the ends of its window near some decisions, to first order.
#[derive(Clone, Copy, Debug)]
struct Keep {
    /// How the jump pushes, and how high it lands above its foothold (m).
    push: Push,
    rise: f64,
    /// Decisions for which it is exact.
    at: [f64; 2],
    /// What is kept there (m).
    value: f64,
    /// Its change with each decision.
    slope: [f64; 2],
}

impl Keep {
    /// What is kept (m) with the decisions `x`, with its derivatives.
    fn of(&self, x: [f64; 2]) -> Slope {
        let part = |i: usize| {
            (Slope::variable(x[i], i + 1) - Slope::of(self.at[i])) * Slope::of(self.slope[i])
        };
        Slope::of(self.value) + part(0) + part(1)
    }
}

/// Part of a decision's range over which the slope of what is kept is taken.
const DIFFERENCE: f64 = 1e-3;

/// Part of a decision's range, and of a metre, within which what is kept is linear: farther than the
/// solver goes for the differences that stand for second derivatives.
const LINEAR: f64 = 2e-7;

/// How much is remembered for each jump.
const REMEMBERED: usize = 4;

impl<'a> Problem<'a> {
    pub(super) fn new(
        jumper: &'a dyn Jumper,
        course: &'a Course,
        choice: &'a Choice,
        sigmas: f64,
    ) -> Self {
        Problem {
            jumper,
            course,
            choice,
            sigmas,
            known: Rc::new(RefCell::new(vec![Vec::new(); choice.leaps.len()])),
        }
    }

    /// The same program for the leaps of another choice.
    pub(super) fn over<'b>(&self, choice: &'b Choice) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem {
            choice,
            known: self.known.clone(),
            ..*self
        }
    }

    /// What the landing of a jump with these decisions keeps from the ends of its window (m).
    fn keep(&self, leap: &Leap, x: [f64; 2]) -> Slope {
        if self.sigmas == 0.0 || self.ends_exactly(leap.jump) {
            return Slope::of(0.0);
        }
        let (rise, bounds) = (leap.to - leap.from, self.jumper.decisions(leap.jump));
        let is_near = |keep: &&Keep| {
            let near = |i: usize| (x[i] - keep.at[i]).abs() <= LINEAR * bounds[i].width();
            let is_alike = keep.push == leap.push && (keep.rise - rise).abs() <= LINEAR;
            is_alike && near(0) && near(1)
        };
        let mut known = self.known.borrow_mut();
        let known = &mut known[leap.jump];
        if let Some(keep) = known.iter().find(is_near) {
            return keep.of(x);
        }
        let kept = |x: [f64; 2]| self.sigmas * self.jumper.deviation(leap, x);
        let value = kept(x);
        let slope = std::array::from_fn(|i| {
            let inwards = if x[i] > f64::midpoint(bounds[i].low, bounds[i].high) {
                -DIFFERENCE
            } else {
                DIFFERENCE
            };
            let mut moved = x;
            moved[i] += inwards * bounds[i].width();
            let step = moved[i] - x[i];
            if step == 0.0 {
                0.0
            } else {
                (kept(moved) - value) / step
            }
        });
        let keep = Keep {
            push: leap.push,
            rise,
            at: x,
            value,
            slope,
        };
        known.insert(0, keep);
        known.truncate(REMEMBERED);
        keep.of(x)
    }

    /// Flies jump number `jump`; `margins` gets all its margins.
    pub(super) fn fly(
        &self,
        jump: usize,
        foot: f64,
        x: [f64; 2],
        margins: &mut Vec<Margin<Slope>>,
    ) -> Flight<Slope> {
        margins.clear();
        let decisions = [Slope::variable(x[0], 1), Slope::variable(x[1], 2)];
        let leap = &self.choice.leaps[jump];
        let flight = self
            .jumper
            .fly(leap, Slope::variable(foot, 0), decisions, margins);
        let Span { low, high } = self.choice.windows[jump];
        if self.is_exact(jump) {
            margins.push(Margin {
                limit: Limit::Goal,
                value: flight.landing - Slope::of(low),
            });
        } else {
            let keep = self.keep(leap, x);
            let (after, before) = (
                flight.landing - Slope::of(low) - keep,
                Slope::of(high) - flight.landing - keep,
            );
            margins.push(Margin {
                limit: Limit::Landing(Side::Front),
                value: after,
            });
            margins.push(Margin {
                limit: Limit::Landing(Side::Back),
                value: before,
            });
        }
        flight
    }

    /// Foothold (m) of a jump after a landing.
    pub(super) fn foothold(&self, jump: usize, landing: f64) -> f64 {
        if jump == 0 {
            self.course.start
        } else {
            landing + self.jumper.roll(jump)
        }
    }

    /// Jump and limit of each row.
    pub(super) fn rows(&self, x: &[f64]) -> Vec<(usize, Limit)> {
        let (mut rows, mut margins, mut landing) = (Vec::new(), Vec::new(), self.course.start);
        for (jump, decisions) in x.chunks_exact(2).enumerate() {
            let foot = self.foothold(jump, landing);
            landing = self
                .fly(jump, foot, [decisions[0], decisions[1]], &mut margins)
                .landing
                .value;
            rows.extend(margins.iter().map(|m| (jump, m.limit)));
        }
        let goal = if self.equalities() == 1 {
            rows.pop()
        } else {
            None
        };
        goal.into_iter().chain(rows).collect()
    }

    /// Whether a jump is for a goal that is one exact place, from which it keeps nothing.
    fn ends_exactly(&self, jump: usize) -> bool {
        jump + 1 == self.course.jumps && self.course.goal.width() == 0.0
    }

    /// Whether the goal is a row, and not the window of the landing.
    fn is_exact(&self, jump: usize) -> bool {
        self.ends_exactly(jump) && self.choice.windows[jump].width() == 0.0
    }
}

impl Nlp for Problem<'_> {
    fn bounds(&self) -> Vec<Span> {
        (0..self.choice.leaps.len())
            .flat_map(|jump| self.jumper.decisions(jump))
            .collect()
    }

    fn equalities(&self) -> usize {
        usize::from(self.is_exact(self.choice.windows.len() - 1))
    }

    fn evaluate(&self, x: &[f64], at: &mut Evaluation) {
        let n = x.len();
        at.cost = 0.0;
        at.gradient.clear();
        at.gradient.resize(n, 0.0);
        at.values.clear();
        at.jacobian.clear();
        // The goal's row goes first and is known last.
        at.values.resize(self.equalities(), 0.0);
        at.jacobian.resize(self.equalities() * n, 0.0);
        let (mut margins, mut landing) = (Vec::with_capacity(16), self.course.start);
        // Derivatives of the foothold by all decisions.
        let mut foot_slope = vec![0.0; n];
        for (jump, decisions) in x.chunks_exact(2).enumerate() {
            let foot = self.foothold(jump, landing);
            let flight = self.fly(jump, foot, [decisions[0], decisions[1]], &mut margins);
            let spread = |slope: &[f64; 3], row: &mut [f64]| {
                row.iter_mut()
                    .zip(&foot_slope)
                    .for_each(|(r, f)| *r += slope[0] * f);
                row[2 * jump] += slope[1];
                row[2 * jump + 1] += slope[2];
            };
            at.cost += flight.cost.value;
            spread(&flight.cost.slope, &mut at.gradient);
            for margin in &margins {
                if margin.limit == Limit::Goal {
                    at.values[0] = margin.value.value;
                    spread(&margin.value.slope, &mut at.jacobian[..n]);
                } else {
                    at.values.push(margin.value.value);
                    let start = at.jacobian.len();
                    at.jacobian.resize(start + n, 0.0);
                    spread(&margin.value.slope, &mut at.jacobian[start..]);
                }
            }
            let mut next = vec![0.0; n];
            spread(&flight.landing.slope, &mut next);
            foot_slope = next;
            landing = flight.landing.value;
        }
    }
}
