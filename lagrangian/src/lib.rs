//! Stance: the thesis' (α, d) dynamics on one foot, from touch-down to lift-off.
//!
//! [`Stance`] is the model of a robot, [`Launch`] what a jump is given, [`LiftOff`] how it ends:
//!
//! ```
//! use saltus_lagrangian::{Launch, Outcome, Stance};
//! use saltus_robot::Robot;
//!
//! let stance = Stance::<f64>::new(&Robot::rats_planar(), |_, x| x);
//! let end = stance.jump(&Launch::at_firing(5.0, -0.1, 0.1))?;
//! assert_eq!(end.outcome, Outcome::Stroke);
//! # Ok::<(), saltus_lagrangian::StanceError>(())
//! ```
//!
//! Angles are leans from the ground's normal, forward positive (φ = π/2 − α); the loaded foot is
//! the origin.

mod advance;
mod batch;
mod contact;
mod error;
mod fed;
mod jump;
mod numbers;
mod observer;
mod pendulum;
mod phase;
mod stance;
mod trace;

pub use batch::Batch;
pub use contact::Contact;
pub use error::StanceError;
pub use fed::{Drawn, FromTank, TankState};
pub use saltus_robot::{Launch, LiftOff, Outcome};
pub use stance::{FINE, Reaction, Stance};
pub use trace::{EnergyLedger, Sample, Trace};
