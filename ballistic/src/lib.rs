//! Flight of the wheel's centre after lift-off: apex, landing, clearance over obstacles.
//!
//! * [`Flight`]: the parabola in closed form, for plain numbers, duals and SIMD lanes.
//! * [`DragFlight`]: the same with air drag, off at 0.
//! * [`SampledFlight`]: a flight that another simulation has computed.
//! * [`Obstacle`] and [`Disc`]: what it must clear, and what must stay clear.
//!
//! A question without an answer says why: [`FlightError`]. Every answer carries exact derivatives
//! where it is asked in [`Dual`](saltus_numeric::Dual) numbers; decisions, such as which side is
//! nearest, are made on the values.
//!
//! The plane is that of the motion: x forward, y up, SI units. The ground is at y = 0 unless said
//! otherwise.

#![cfg_attr(test, allow(clippy::unwrap_used))]

#[cfg(test)]
mod check;
mod clearance;
mod drag;
mod error;
mod flight;
mod obstacle;
mod path;
mod polynomial;
mod sampled;
mod state;

pub use clearance::{Disc, ExtendedLeg};
pub use drag::DragFlight;
pub use error::FlightError;
pub use flight::Flight;
pub use obstacle::Obstacle;
pub use sampled::{FlightSample, SampledFlight};
