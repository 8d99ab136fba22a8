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
    #[error("with drag nothing is known of the time {time} s before lift-off")]
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
    #[error("the flight was followed down to {lowest} m, not to {height} m")]
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
    /// The wheel does not come down to the terrain.
    #[error(
        "the wheel's centre, {gap} m from the terrain at lift-off, never comes down to its radius \
         of {radius} m"
    )]
    NeverLands {
        /// Distance of the wheel's centre from the terrain at lift-off (m), negative below it.
        gap: f64,
        /// The wheel's radius (m).
        radius: f64,
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
    /// Too few vertices for a shape.
    #[error("{count} vertices where at least {least} are needed")]
    FewVertices {
        /// How many there are.
        count: usize,
        /// How many there must be.
        least: usize,
    },
    /// A vertex that is nowhere.
    #[error("vertex {vertex} at ({}, {}) m is not at a finite place", at[0], at[1])]
    VertexNotFinite {
        /// Its number, from 0.
        vertex: usize,
        /// Its coordinates (m).
        at: [f64; 2],
    },
    /// An edge without length.
    #[error("vertex {vertex} at ({}, {}) m is there twice in a row", at[0], at[1])]
    VertexRepeated {
        /// Number of the first of the two, from 0.
        vertex: usize,
        /// Its coordinates (m).
        at: [f64; 2],
    },
    /// A polygon that crosses, touches or folds back over itself.
    #[error("edges {first} and {second} meet elsewhere than at a common end")]
    EdgesCross {
        /// Number of an edge, that of its first vertex.
        first: usize,
        /// Number of the other edge.
        second: usize,
    },
    /// A terrain that overhangs.
    #[error("the terrain runs back at vertex {vertex}, ({}, {}) m", at[0], at[1])]
    TerrainRunsBack {
        /// Number of the vertex that it runs back from, from 0.
        vertex: usize,
        /// Its coordinates (m).
        at: [f64; 2],
    },
    /// A slope that is a wall or an overhang.
    #[error("a slope of {angle} rad is not between level and upright")]
    TooSteep {
        /// Its angle above the level (rad).
        angle: f64,
    },
}
