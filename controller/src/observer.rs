//! Lean and rate from an encoder's counts.

use crate::real::sine;
use crate::{Real, Sensed};

/// Lean and rate of a wheel that pivots on its foot, from readings of its lean: the pendulum's
/// motion, corrected by each reading.
///
/// A fading-memory filter: both poles of its error are at `memory`, so that a reading's weight
/// falls by this factor with each further one.
///
/// Source: Morrison, Introduction to Sequential Smoothing and Prediction, 1969, chapter 13 (degree
/// 1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer<R> {
    /// What it holds true now.
    pub sensed: Sensed<R>,
    /// Time (s) between readings, > 0.
    pub period: R,
    /// c (1/s²): a lean φ accelerates by c sin φ.
    pub pendulum: R,
    /// θ, from 0 (believes each reading) to below 1 (believes the motion).
    pub memory: R,
}

impl<R: Real> Observer<R> {
    /// Goes on by one period, to the reading `lean` (rad); a reading that is no finite number only
    /// lets time pass.
    #[inline]
    pub fn update(&mut self, lean: R) {
        let Sensed { lean: before, rate } = self.sensed;
        let acceleration = self.pendulum * sine(before);
        let step = self.period * acceleration;
        let predicted = before + self.period * (rate + R::of(0.5) * step);
        let next = rate + step;
        let off = if lean.is_finite() {
            lean - predicted
        } else {
            R::ZERO
        };
        let fresh = R::ONE - self.memory;
        self.sensed = Sensed {
            lean: predicted + (R::ONE - self.memory * self.memory) * off,
            rate: next + fresh * fresh * off / self.period,
        };
    }
}
