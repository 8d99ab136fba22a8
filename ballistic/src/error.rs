//! What can be wrong with a question about a flight.

use saltus_numeric::plain;
use thiserror::Error;

/// Why a question about a flight has no answer.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum FlightError {
    /// The flight stays below the height at which it should land.
    #[error("landing height {} m is above the apex at {} m", plain(*height), plain(*apex))]
    AboveApex {
        /// The height asked for (m).
        height: f64,
        /// Greatest height of the wheel's centre from lift-off on (m).
        apex: f64,
    },
    /// Nothing pulls the wheel down.
    #[error(
        "without gravity the wheel rises at {} m/s and never comes down to {} m",
        plain(*speed),
        plain(*height)
    )]
    NoGravity {
        /// The height asked for (m).
        height: f64,
        /// Vertical speed at lift-off (m/s).
        speed: f64,
    },
    /// The lift-off state or the gravity is infinite or not a number.
    #[error(
        "lift-off at ({x}, {y}) m with ({vx}, {vy}) m/s under {gravity} m/s² gives no finite flight"
    )]
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
    /// A drag that is negative, infinite or not a number.
    #[error("a drag of {drag} 1/m is not a finite number ≥ 0")]
    BadDrag {
        /// Drag per mass c (1/m).
        drag: f64,
    },
    /// A time at which a flight with drag was not yet under way.
    #[error("with drag nothing is known of the time {} s before lift-off", plain(*time))]
    BeforeLiftOff {
        /// Time (s) after lift-off, < 0.
        time: f64,
    },
    /// Samples that make no flight.
    #[error("{samples} samples make no flight: two or more are needed, finite, at rising times")]
    BadSamples {
        /// How many there are.
        samples: usize,
    },
    /// A sampled flight ends above the height asked for.
    #[error("the flight was followed down to {} m, not to {} m", plain(*lowest), plain(*height))]
    BelowSamples {
        /// The height asked for (m).
        height: f64,
        /// Where the samples end (m).
        lowest: f64,
    },
    /// A height that is infinite or not a number.
    #[error("{height} m is no height to come down to")]
    HeightNotFinite {
        /// The height asked for (m).
        height: f64,
    },
    /// A span of time that ends before it starts, or does not end.
    #[error("there is no time from {from} s to {to} s")]
    EmptySpan {
        /// Start (s).
        from: f64,
        /// End (s).
        to: f64,
    },
    /// A box without an inside.
    #[error("a box from ({}, {}) to ({}, {}) m has no inside", low[0], low[1], high[0], high[1])]
    EmptyBox {
        /// Its lower left corner (m).
        low: [f64; 2],
        /// Its upper right corner (m).
        high: [f64; 2],
    },
}
