//! The numbers that Saltus computes with, the step they go through, and what every crate needs of
//! numerical methods.
//!
//! * [`Scalar`]: what the equations of motion are written in, once; `f64` for one jump, [`Dual`]
//!   for a jump with its exact derivatives, [`Lanes`] for several jumps side by side in SIMD
//!   registers, whose [`Width`] is chosen where the program runs.
//! * [`refused!`]: numbers held against what they may be.
//! * [`dop853`]: one step of the Runge–Kutta method of order 8 that all of them are integrated
//!   with, and the choice of the independent variable that turns it into an exact event locator.
//! * Of plain numbers: [`root`] has roots and extremes without derivatives, [`hermite`] the cubic
//!   through values and slopes, [`statistics`] means, quantiles and the least-squares line.
//! * [`plain`]: numbers without round-off, for messages.
//! * [`parallel`]: work shared among threads.

pub mod dop853;
mod dual;
mod hermite;
mod lanes;
pub mod parallel;
mod plain;
mod refused;
pub mod root;
mod scalar;
pub mod statistics;
mod width;

pub use dual::Dual;
pub use hermite::hermite;
pub use lanes::{LANES, Lanes};
pub use plain::plain;
pub use scalar::{Scalar, Single};
pub use width::Width;
