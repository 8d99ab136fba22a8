//! The jumps of one choice as a nonlinear program in their decisions.

use saltus_numeric::Scalar;

use super::jumper::Slope;
use super::sqp::{Evaluation, Nlp};
use super::{Flight, Jumper, Leap, Limit, Margin, Side, Span};

/// Where each jump of a course is to take off and to land.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    /// Jump after jump.
    pub(super) leaps: Vec<Leap>,
    /// Where each of them lands (m).
    pub(super) windows: Vec<Span>,
}

/// The program of a choice: two variables a jump, the footholds follow.
///
/// Rows: the goal if it is exact, then jump after jump the jumper's margins and the landing's distances from the ends of
/// its window.
pub(super) struct Problem<'a, J> {
    pub(super) jumper: &'a J,
    /// First foothold (m).
    pub(super) start: f64,
    pub(super) choice: &'a Choice,
    /// Standard deviations that a landing keeps from the ends of its window.
    pub(super) sigmas: f64,
}

impl<J: Jumper> Problem<'_, J> {
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
        let flight = self.jumper.fly(leap, Slope::variable(foot, 0), decisions, margins);
        let Span { low, high } = self.choice.windows[jump];
        if self.is_exact(jump) {
            margins.push(Margin { limit: Limit::Goal, value: flight.landing - Slope::of(low) });
        } else {
            let keep = flight.deviation * Slope::of(self.sigmas);
            let (after, before) =
                (flight.landing - Slope::of(low) - keep, Slope::of(high) - flight.landing - keep);
            margins.push(Margin { limit: Limit::Landing(Side::Front), value: after });
            margins.push(Margin { limit: Limit::Landing(Side::Back), value: before });
        }
        flight
    }

    /// Foothold (m) of a jump after a landing.
    pub(super) fn foothold(&self, jump: usize, landing: f64) -> f64 {
        if jump == 0 { self.start } else { landing + self.jumper.roll(jump) }
    }

    /// Jump and limit of each row.
    pub(super) fn rows(&self, x: &[f64]) -> Vec<(usize, Limit)> {
        let (mut rows, mut margins, mut landing) = (Vec::new(), Vec::new(), self.start);
        for (jump, decisions) in x.chunks_exact(2).enumerate() {
            let foot = self.foothold(jump, landing);
            landing = self.fly(jump, foot, [decisions[0], decisions[1]], &mut margins).landing.value;
            rows.extend(margins.iter().map(|m| (jump, m.limit)));
        }
        let goal = if self.equalities() == 1 { rows.pop() } else { None };
        goal.into_iter().chain(rows).collect()
    }

    /// Whether a jump has to land in one exact place.
    fn is_exact(&self, jump: usize) -> bool {
        jump + 1 == self.choice.windows.len() && self.choice.windows[jump].width() == 0.0
    }
}

impl<J: Jumper> Nlp for Problem<'_, J> {
    fn bounds(&self) -> Vec<Span> {
        (0..self.choice.leaps.len()).flat_map(|jump| self.jumper.decisions(jump)).collect()
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
        let (mut margins, mut landing) = (Vec::with_capacity(16), self.start);
        // Derivatives of the foothold by all decisions.
        let mut foot_slope = vec![0.0; n];
        for (jump, decisions) in x.chunks_exact(2).enumerate() {
            let foot = self.foothold(jump, landing);
            let flight = self.fly(jump, foot, [decisions[0], decisions[1]], &mut margins);
            let spread = |slope: &[f64; 3], row: &mut [f64]| {
                row.iter_mut().zip(&foot_slope).for_each(|(r, f)| *r += slope[0] * f);
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
