//! The jumps of one choice as a nonlinear program in their decisions.

use saltus_numeric::Scalar;

use super::jumper::Slope;
use super::sqp::{self, Evaluation, Nlp};
use super::{Course, Flight, Jumper, Leap, Limit, Margin, Side, Span};

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
    keeps: Vec<Keep>,
}

/// What a landing keeps from the ends of its window, as a linear function of its jump's decisions.
#[derive(Clone, Copy, Debug, Default)]
struct Keep {
    /// Decisions for which it is exact.
    at: [f64; 2],
    /// What is kept there (m).
    value: f64,
    /// Its change with each decision.
    slope: [f64; 2],
}

impl Keep {
    /// What is kept (m) with the decisions `x`, with its derivatives.
    fn of(&self, x: [Slope; 2]) -> Slope {
        let part = |i: usize| (x[i] - Slope::of(self.at[i])) * Slope::of(self.slope[i]);
        Slope::of(self.value) + part(0) + part(1)
    }
}

/// Most times that a program is solved until its landings keep what their deviations ask for.
const ROUNDS: usize = 12;

/// After so many, what is kept no longer changes with the decisions, and only grows from one
/// solution to the next: where the cost hardly says which of several jumps to take, it could go to
/// and fro between theirs.
const LINEAR_ROUNDS: usize = 4;

/// Halvings of the way between a solution that keeps enough and one beyond it that does not.
const HALVINGS: usize = 12;

/// Part of a decision's range over which the slope of what is kept is taken.
const DIFFERENCE: f64 = 1e-3;

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
            keeps: vec![Keep::default(); choice.leaps.len()],
        }
    }

    /// The same program for the leaps of another choice.
    pub(super) fn over<'b>(&self, choice: &'b Choice) -> Problem<'b>
    where
        'a: 'b,
    {
        Problem {
            choice,
            keeps: self.keeps.clone(),
            ..*self
        }
    }

    /// Takes what the landing of a jump keeps from the deviation of the jump with these decisions.
    pub(super) fn keep_for(&mut self, jump: usize, at: [f64; 2]) {
        self.keeps[jump] = self.constant_keep(&self.choice.leaps[jump], at);
    }

    fn constant_keep(&self, leap: &Leap, at: [f64; 2]) -> Keep {
        Keep {
            at,
            value: self.kept(leap, at),
            slope: [0.0; 2],
        }
    }

    /// What the landing of a jump with these decisions has to keep (m).
    fn kept(&self, leap: &Leap, decisions: [f64; 2]) -> f64 {
        if self.sigmas == 0.0 || self.ends_exactly(leap.jump) {
            return 0.0;
        }
        self.sigmas * self.jumper.deviation(leap, decisions)
    }

    /// The same with its slope.
    fn linear_keep(&self, leap: &Leap, at: [f64; 2]) -> Keep {
        let value = self.kept(leap, at);
        let bounds = self.jumper.decisions(leap.jump);
        let slope = std::array::from_fn(|i| {
            let towards = if at[i] > f64::midpoint(bounds[i].low, bounds[i].high) {
                -DIFFERENCE
            } else {
                DIFFERENCE
            };
            let step = towards * bounds[i].width();
            let mut moved = at;
            moved[i] += step;
            if self.sigmas > 0.0 && step != 0.0 {
                (self.kept(leap, moved) - value) / step
            } else {
                0.0
            }
        });
        Keep { at, value, slope }
    }

    /// Takes what landings keep from the jumps over `leaps` with the decisions `x`, with its slope
    /// in the first rounds; by how much (m) it was greater or less than the program had it, at
    /// most, and by how much greater. In later rounds it is more than that by as much, and by
    /// `spare` (m), so that the next solution keeps enough.
    fn keep(&mut self, leaps: &[Leap], x: &[f64], round: usize, spare: f64) -> [f64; 2] {
        let (mut change, mut growth) = (0.0_f64, 0.0_f64);
        for (jump, leap) in leaps.iter().enumerate() {
            let at = [x[2 * jump], x[2 * jump + 1]];
            let before = self.keeps[jump].of(at.map(Slope::of)).value;
            let is_linear = round < LINEAR_ROUNDS;
            let kept = if is_linear {
                self.linear_keep(leap, at)
            } else {
                self.constant_keep(leap, at)
            };
            let grown = kept.value - before;
            growth = growth.max(grown);
            change = change.max(if is_linear { grown.abs() } else { grown });
            let value = if grown > 0.0 {
                kept.value + grown + spare
            } else {
                before
            };
            self.keeps[jump] = if round <= LINEAR_ROUNDS {
                kept
            } else {
                Keep { value, ..kept }
            };
        }
        [change, growth]
    }

    /// Solves the program from `x`, whose first variables are the decisions, again and again until
    /// its landings keep what the answer's deviations ask for. A deviation costs far more than a
    /// jump, and so it is not asked for at every step of the solver but once for each solution,
    /// with its slope. `choice` gives the jumps of a solution, and `cost` what it costs, if it is
    /// one.
    ///
    /// Where the deviation leaps, a solution may be on the wrong side: the way back to the best one
    /// is halved then.
    pub(super) fn settle(
        &mut self,
        x: &[f64],
        solver: &sqp::Settings,
        choice: impl Fn(&Self, &[f64]) -> Choice,
        solve: impl Fn(&Self, &[f64]) -> sqp::Report,
        cost: impl Fn(&mut Self, &[f64]) -> Option<f64>,
    ) -> sqp::Report {
        self.keep(&choice(self, x).leaps, x, 0, 0.0);
        let mut report = solve(self, x);
        let (mut best, mut beyond): (Option<sqp::Report>, Option<sqp::Report>) = (None, None);
        for round in 1..=ROUNDS {
            let leaps = choice(self, &report.x).leaps;
            let [change, growth] = self.keep(&leaps, &report.x, round, solver.feasibility);
            let is_cheaper = best.as_ref().is_none_or(|best| report.cost < best.cost);
            if is_cheaper && report.violation <= solver.feasibility {
                let place = if growth <= solver.feasibility {
                    &mut best
                } else {
                    &mut beyond
                };
                *place = Some(report.clone());
            }
            // A program that has no solution after a second try hardly gets one by what is kept.
            let is_lost = round > 1 && report.violation > solver.feasibility;
            if change <= solver.feasibility || round == ROUNDS || is_lost {
                report.violation = report.violation.max(growth);
                break;
            }
            report = solve(self, &report.x);
        }
        let Some(mut best) = best else { return report };
        let Some(beyond) = beyond.filter(|beyond| beyond.cost < best.cost) else {
            return best;
        };
        let mut end = beyond.x;
        for _ in 0..HALVINGS {
            let middle: Vec<f64> = best
                .x
                .iter()
                .zip(&end)
                .map(|(a, b)| f64::midpoint(*a, *b))
                .collect();
            match cost(self, &middle).filter(|cost| *cost < best.cost) {
                Some(cost) => {
                    best.x = middle;
                    best.cost = cost;
                }
                None => end = middle,
            }
        }
        best
    }

    /// What the jumps with the decisions `x` cost, if every row holds but for `tolerance` with what
    /// their own deviations ask for.
    pub(super) fn cost_where_it_holds(&mut self, x: &[f64], tolerance: f64) -> Option<f64> {
        for (jump, decisions) in x.chunks_exact(2).enumerate() {
            self.keep_for(jump, [decisions[0], decisions[1]]);
        }
        let mut at = Evaluation::default();
        self.evaluate(x, &mut at);
        let (exact, above) = at.values.split_at(self.equalities());
        let holds = exact.iter().all(|value| value.abs() <= tolerance)
            && above.iter().all(|value| *value >= -tolerance);
        (holds && at.cost.is_finite()).then_some(at.cost)
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
            let keep = self.keeps[jump].of(decisions);
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
