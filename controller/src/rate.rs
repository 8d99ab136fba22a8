//! Approach rates: where they count, and how a reading is brought there.

use crate::real::cosine;
use crate::{Controller, Real, Reason, Sensed};

/// Approach rates: which ones the tables were made for, and at which lean they count.
///
/// Rule and map are over the rate at one lean, the reference: a reading is brought there by the
/// energy of its pivoting, whatever lean it was taken at. The approach rates that a program gives
/// and is given count at the firing angle, or at the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates<R> {
    /// Least approach rate (rad/s) that was asked for at export.
    pub least: R,
    /// Greatest approach rate (rad/s) that was.
    pub greatest: R,
    /// Lean (rad) at which the rates of rule and map count.
    pub reference_lean: R,
    /// Whether approach rates count at the firing angle; else at the reference lean, where the
    /// stance then starts.
    pub at_firing: bool,
}

/// Evaluations at most that an angle takes which is its own rate's.
const STEPS: usize = 8;

impl<R: Real> Controller<'_, R> {
    /// The rate (rad/s) that a robot, sensed on its foot, has at `lean` (rad), or had there: by the
    /// energy of its pivoting.
    ///
    /// # Errors
    /// [`Reason::SensorInvalid`] for a lean beyond the horizontal or a number that is not finite;
    /// [`Reason::Infeasible`] for a robot that rolls backwards or does not get there.
    #[inline]
    pub fn rate_at(&self, sensed: &Sensed<R>, lean: R) -> Result<R, Reason> {
        let horizontal = R::of(1.5707964);
        let upright = |x: R| x.within(-horizontal, horizontal);
        if !(upright(sensed.lean) && upright(lean) && sensed.rate.is_finite()) {
            return Err(Reason::SensorInvalid);
        }
        let square = self.square(sensed.rate, sensed.lean, lean);
        if !(sensed.rate.is_positive() && square.is_positive()) {
            return Err(Reason::Infeasible);
        }
        if square.is_finite() {
            Ok(square.sqrt())
        } else {
            Err(Reason::OutOfTable)
        }
    }

    /// The firing angle (rad) whose own approach rate is `rate` (rad/s), which counts at the firing
    /// angle.
    ///
    /// Among the rule's cells the one that holds it is found, and between its ends the line; from
    /// there by secants on the angle, which changes the rate at the reference, which changes the
    /// angle.
    #[inline(never)]
    pub(crate) fn angle_at_firing(&self, rate: R, distance: R, height: R) -> Result<R, Reason> {
        if !rate.within(self.rates.least, self.rates.greatest) {
            return Err(if rate.is_finite() {
                Reason::OutOfTable
            } else {
                Reason::SensorInvalid
            });
        }
        let next =
            |angle: R| self.angle_at_reference(self.reference_rate(rate, angle), distance, height);
        let mut before = self.between_ends(rate, distance)?;
        let mut angle = next(before)?;
        let mut gap_before = angle - before;
        for _ in 1..STEPS {
            let gap = next(angle)? - angle;
            if gap.magnitude() <= R::ROUND_OFF {
                return Ok(angle);
            }
            let slope = (gap - gap_before) / (angle - before);
            (before, gap_before) = (angle, gap);
            angle = angle - gap / slope;
        }
        Err(Reason::Infeasible)
    }

    /// The rate (rad/s) at the reference lean of a robot that is fired at `angle` (rad) with the
    /// approach rate `rate` (rad/s).
    #[inline]
    pub(crate) fn reference_rate(&self, rate: R, angle: R) -> R {
        if self.rates.at_firing {
            self.square(rate, angle, self.rates.reference_lean).sqrt()
        } else {
            rate
        }
    }

    /// The angle (rad) on the line between the ends of the rule's first open cell that holds `rate`
    /// (rad/s) at the firing angle.
    fn between_ends(&self, rate: R, distance: R) -> Result<R, Reason> {
        let (axis, cells) = self.rule.cells();
        let at_firing = |k: usize, angle: R| {
            let square = self.square(axis.node(k), self.rates.reference_lean, angle);
            if square.is_positive() {
                square.sqrt()
            } else {
                R::ZERO
            }
        };
        for cell in 0..cells {
            let Some([a, b]) = self.rule.ends(cell, distance)? else {
                continue;
            };
            let (low, high) = (at_firing(cell, a), at_firing(cell.wrapping_add(1), b));
            if rate.within(low, high) && low < high {
                return Ok(a + (rate - low) / (high - low) * (b - a));
            }
        }
        Err(Reason::Infeasible)
    }

    /// The square of the rate (rad/s) at the lean `to` (rad) of a robot that has `rate` at the lean
    /// `from`: ω² + 2 c (cos from − cos to).
    #[inline]
    fn square(&self, rate: R, from: R, to: R) -> R {
        let c = self.robot.pendulum;
        rate * rate + (c + c) * (cosine(from) - cosine(to))
    }
}
