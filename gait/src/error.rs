//! What can be wrong with a run.

use saltus_controller::run::Unsure;
use saltus_numeric::plain;
use saltus_sim_check::SimError;

/// A run that cannot be, or that cannot go on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GaitError {
    /// A number is outside its domain.
    #[error("{name} = {}: must be {allowed}", plain(*value))]
    Input {
        /// What was given, with its unit.
        name: String,
        /// Its value.
        value: f64,
        /// What is allowed.
        allowed: String,
    },
    /// The robot cannot tell on which feet it stands.
    #[error(
        "the robot cannot tell on which two feet it stands: {}", match .0 {
            Unsure::AskLater => "too few readings",
            Unsure::Moving => "a gyro says that the wheel turns by more than 0.8 rad/s, or the mean of the fine \
             accelerometer differs from gravity by more than 15 %",
            Unsure::Between => "gravity lies between two poses of rest",
            Unsure::Saturated => "the fine accelerometer is at the end of its range",
        }
    )]
    Unsure(Unsure),
    /// The simulation cannot begin, or cannot go on.
    #[error(transparent)]
    Sim(#[from] SimError),
}

/// An error unless `holds`.
pub(crate) fn require(
    holds: bool,
    name: &str,
    value: f64,
    allowed: impl Into<String>,
) -> Result<(), GaitError> {
    if holds {
        return Ok(());
    }
    Err(refused(name, value, allowed))
}

/// The error of a number that is outside its domain.
pub(crate) fn refused(name: &str, value: f64, allowed: impl Into<String>) -> GaitError {
    GaitError::Input {
        name: name.into(),
        value,
        allowed: allowed.into(),
    }
}

/// Returns the error of the first number that is not allowed. Each has a row: name, value, whether
/// it is allowed, and what is.
macro_rules! ensure {
    ($($name:expr, $value:expr, $holds:expr => $allowed:expr;)+) => {{
        $($crate::error::require($holds, $name, $value, $allowed)?;)+
    }};
}
pub(crate) use ensure;
