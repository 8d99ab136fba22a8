//! A linear law: what a controller can carry in two numbers.

use crate::{Real, Reason};

/// α_f = A ω + B for one distance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law<R> {
    /// A (s).
    pub slope: R,
    /// B (rad).
    pub intercept: R,
    /// Least approach rate ω (rad/s) for which it holds.
    pub least_rate: R,
    /// Greatest approach rate ω (rad/s) for which it holds.
    pub greatest_rate: R,
    /// The distance (m) that it was made for.
    pub distance: R,
}

impl<R: Real> Law<R> {
    /// α_f (rad) at the approach rate `rate` (rad/s) for its distance, which `distance` (m) must be.
    ///
    /// # Errors
    /// [`Reason::SensorInvalid`] for what is no finite number, [`Reason::OutOfTable`] for other rates and distances.
    #[inline]
    pub fn firing_angle(&self, rate: R, distance: R) -> Result<R, Reason> {
        if !(rate.is_finite() && distance.is_finite()) {
            return Err(Reason::SensorInvalid);
        }
        if !rate.within(self.least_rate, self.greatest_rate) || distance != self.distance {
            return Err(Reason::OutOfTable);
        }
        Ok(self.slope * rate + self.intercept)
    }
}
