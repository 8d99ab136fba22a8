//! What keeps a stance from being computed at all.

use saltus_numeric::plain;

/// A stance that could not be integrated. An outcome without lift-off is not an error: see
/// [`Outcome`](crate::Outcome).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StanceError {
    /// An input is outside its domain.
    #[error("{name} = {}: must be {allowed}", plain(*value))]
    Input {
        /// What was given, with its unit.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// The error control asks for steps below round-off: the model is stiffer there than the method
    /// can follow.
    #[error(
        "the step at {time} s fell below {step} s: the leg's parameters make the stance too stiff \
         to integrate"
    )]
    StepTooSmall {
        /// Time in the stance (s).
        time: f64,
        /// The step (s).
        step: f64,
    },
    /// The leg's parameters make the stance so stiff that no end was in sight.
    #[error(
        "{steps} steps came no further than {time} s: the leg's parameters make the stance too \
         stiff to integrate"
    )]
    TooManySteps {
        /// Time in the stance (s).
        time: f64,
        /// Steps taken.
        steps: u32,
    },
    /// A simulation in place of the planar model cannot make this jump.
    #[error("{reason}")]
    Simulation {
        /// What it says.
        reason: String,
    },
    /// The stance lasts longer than any jump.
    #[error("no lift-off within {time:.3} s")]
    TooLong {
        /// Time in the stance (s).
        time: f64,
    },
}
