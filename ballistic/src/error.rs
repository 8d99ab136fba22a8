//! What can be wrong with a question about a flight.

use thiserror::Error;

/// Why a question about a flight has no answer.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FlightError {
    /// The flight stays below the height at which it should land.
    #[error("landing height {height} m is above the apex at {apex} m")]
    AboveApex {
        /// The height asked for (m).
        height: f64,
        /// Greatest height of the wheel's centre from lift-off on (m).
        apex: f64,
    },
    /// Nothing pulls the wheel down.
    #[error("without gravity the wheel rises at {speed} m/s and never comes down to {height} m")]
    NoGravity {
        /// The height asked for (m).
        height: f64,
        /// Vertical speed at lift-off (m/s).
        speed: f64,
    },
    /// The lift-off state, the gravity or the height is infinite or not a number.
    #[error("lift-off at ({x}, {y}) m with ({vx}, {vy}) m/s under {gravity} m/s² gives no finite flight")]
    NotFinite {
        /// Forward position at lift-off (m).
        x: f64,
        /// Height at lift-off (m).
        y: f64,
        /// Forward speed at lift-off (m/s).
        vx: f64,
        /// Vertical speed at lift-off (m/s).
        vy: f64,
        /// Gravity (m/s²).
        gravity: f64,
    },
}
