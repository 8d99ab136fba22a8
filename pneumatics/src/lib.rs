//! The force of a leg: orifice, valve and chamber of a pneumatic cylinder, and the other drives a
//! leg can have.
//!
//! Everything is generic over [`Scalar`](saltus_numeric::Scalar): one jump, a jump with its
//! derivatives, or several jumps at a time. Pressures are absolute, in pascals.
//!
//! Source: thesis §4.3; the exact reading is in the reference model (`docs/model.md`).

mod chamber;
mod leg;
mod orifice;
mod piece;
mod table;

pub use chamber::{Chamber, Flow, GasState, MEGA, Valve, ValveLaw};
pub use leg::{Drive, Force, Leg, Switches};
pub use orifice::OrificeLaw;
pub use piece::Piece;
pub use table::ForceSurface;
