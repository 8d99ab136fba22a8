//! Running: which leg fires when, at 1 kHz.
//!
//! The leg whose lean lies in the *active zone* [z₀, z₀ + 2π/n) fires once it leans at least α_f,
//! once for each entry into the zone. A [`Law`] says α_f and how long the valve opens; a [`Signals`]
//! makes lean and rate of what counters and converters say; [`Standing`] finds out at rest which two
//! feet stand. [`Runner`] is all of them. [`Choices`] is a table that a robot has learnt.
//!
//! Source: thesis 5.1.1 to 5.1.4.

mod ahead;
mod choices;
mod law;
mod runner;
mod signals;
mod standing;

pub use ahead::Ahead;
pub use choices::{Choices, Steps};
pub use law::{Knot, Law};
pub use runner::{Action, Gait, Hold, Leap, Runner, Stall};
pub use signals::{Instruments, MOST_TAPS, Readings, Signals};
pub use standing::{Standing, Unsure};
