//! The numbers that Saltus computes with, and the step they go through.
//!
//! * [`Scalar`]: what the equations of motion are written in, once; `f64` for one jump, [`Dual`]
//!   for a jump with its exact derivatives, [`Lanes`] for several jumps side by side in SIMD
//!   registers, whose [`Width`] is chosen where the program runs.
//! * [`dop853`]: one step of the Runge–Kutta method of order 8 that all of them are integrated
//!   with, and the choice of the independent variable that turns it into an exact event locator.

pub mod dop853;
mod dual;
mod lanes;
mod scalar;
mod width;

pub use dual::Dual;
pub use lanes::{LANES, Lanes};
pub use scalar::{Scalar, Single};
pub use width::Width;
