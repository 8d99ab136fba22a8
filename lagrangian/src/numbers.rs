//! The kinds of number that a stance is computed in. Each is compiled once, here, and not again in
//! every crate that asks for a jump.

use saltus_numeric::Dual;

use crate::observer::Unobserved;
use crate::{Contact, Launch, LiftOff, Sample, Stance, StanceError, Trace};

macro_rules! jumps_in {
    ($($number:ty),*) => {$(
        impl Stance<$number> {
            /// One stance, from `launch` to its end.
            ///
            /// Pivoting and filling go by closed forms where these are exact to round-off, the
            /// extension by an eighth-order method with events on its steps.
            ///
            /// Source: thesis §5.2, docs/model.md, "One jump, phase by phase".
            ///
            /// # Errors
            /// [`StanceError::Input`] for an input outside its domain; [`StanceError::StepTooSmall`],
            /// [`StanceError::TooManySteps`] or [`StanceError::TooLong`] where the leg's parameters
            /// allow no solution.
            pub fn jump(&self, launch: &Launch<$number>) -> Result<LiftOff<$number>, StanceError> {
                self.run(launch, &mut Unobserved)
            }
        }
    )*};
}

macro_rules! watched_in {
    ($($number:ty),*) => {$(
        impl Stance<$number> {
            /// One stance with its contact; every phase is stepped through, closed forms left
            /// aside.
            ///
            /// Extremes are looked for at the ends of the integration's steps and, by the slopes
            /// there, between them. Not promised: an extreme that comes and goes within a step,
            /// which [`Stance::trace`] sees.
            ///
            /// # Errors
            /// As [`Stance::jump`].
            pub fn contact(
                &self,
                launch: &Launch<$number>,
            ) -> Result<(LiftOff<$number>, Contact<$number>), StanceError> {
                self.with_contact(launch)
            }
        }
    )*};
}

impl Stance<f64> {
    /// One stance with its course, contact and energy; every phase is stepped through, closed forms
    /// left aside.
    ///
    /// # Errors
    /// As [`Stance::jump`].
    pub fn trace(&self, launch: &Launch) -> Result<Trace, StanceError> {
        self.recorded(launch)
    }
}

impl Stance<Dual<2>> {
    /// The course of one stance, with every phase stepped through: a few samples for each step of the
    /// integration.
    ///
    /// # Errors
    /// As [`Stance::jump`].
    pub fn way(&self, launch: &Launch<Dual<2>>) -> Result<Vec<Sample<Dual<2>>>, StanceError> {
        self.passed(launch)
    }
}

// A robot in plain numbers; by firing angle and valve opening; by rate, firing angle, valve opening
// and one term of the robot.
jumps_in!(f64, Dual<2>, Dual<4>);
watched_in!(f64, Dual<2>);
