//! The force of a leg: orifice, valve and chamber of a pneumatic cylinder, and the other drives a
//! leg can have.
//!
//! Everything is generic over [`Scalar`](saltus_numeric::Scalar): one jump, a jump with its
//! derivatives, or several jumps at a time. Pressures are absolute, in pascals.
//!
//! Source: thesis §4.3; the exact reading is in the reference model (`docs/model.md`).

mod chamber;
mod contractor;
mod feed;
mod leg;
mod muscle;
mod orifice;
mod piece;
mod supply;
mod table;

pub use chamber::{Chamber, Flow, GasState, MEGA, Valve, ValveLaw};
pub use contractor::{Contracted, Contractor};
pub use feed::{Feed, FeedRates, Held, Place, TankModel};
pub use leg::{Drive, Force, Leg, Switches};
pub use muscle::{Inflated, Muscle};
pub use orifice::OrificeLaw;
pub use piece::Piece;
pub use supply::{Line, Opening, Passage, Stock, Store, Supply, Wall};
pub use table::ForceSurface;
