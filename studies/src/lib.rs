//! What several studies share.

pub mod half_turn;
pub mod jumps_in_space;

use saltus_gait::GaitError;

/// An error unless `holds`.
fn require(
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
fn refused(name: &str, value: f64, allowed: impl Into<String>) -> GaitError {
    GaitError::Input {
        name: name.into(),
        value,
        allowed: allowed.into(),
    }
}
