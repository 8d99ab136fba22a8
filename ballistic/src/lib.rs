//! Flight of the wheel's centre after lift-off: apex, landing, clearance over obstacles.
//!
//! * [`Flight`]: the parabola in closed form, for plain numbers, duals and SIMD lanes.
//!
//! The plane is that of the motion: x forward, y up, SI units. The ground is at y = 0 unless said otherwise.

#![cfg_attr(test, allow(clippy::unwrap_used))]

#[cfg(test)]
mod check;
mod error;
mod flight;

pub use error::FlightError;
pub use flight::Flight;
