//! The planner on a robot: what runs at 1 kHz, from tables that `saltus export` writes.
//!
//! A [`Controller`] is data: a firing [`Rule`] (table or curve), a [`LiftOffMap`] and the
//! [`Robot`]'s few constants, all `const`. [`Controller::decide`] says when to open the valve and
//! for how long, [`Controller::take_off`] from which touch-down to jump over an obstacle ahead;
//! [`qp`] is the small quadratic program behind the first. [`Rates`] says what an approach rate is.
//!
//! Every answer is a value or a [`Reason`]. Nothing allocates, panics, or loops more often than a
//! constant says, whatever bits are given. Numbers are `f32` or `f64`; only +, −, ×, ÷ and √ are
//! used, each correctly rounded everywhere, so that the C of `saltus export c` gives the same bits
//! on every machine that has IEEE 754 and does not contract products and sums.
//!
//! ```
//! use saltus_controller::{Axis, Reason, FiringTable};
//!
//! // α_f = 0.6 − 0.1 ω + 0.5 D over ω from 3 to 5 rad/s and D from 0.4 to 0.8 m: each node has value and scaled slopes.
//! let nodes = [[0.5, -0.2, 0.2, 0.0], [0.7, -0.2, 0.2, 0.0], [0.3, -0.2, 0.2, 0.0], [0.5, -0.2, 0.2, 0.0]];
//! let table: FiringTable<'_, f32> = FiringTable {
//!     rates: Axis::new(3.0, 5.0, 2),
//!     distances: Axis::new(0.4, 0.8, 2),
//!     nodes: &nodes,
//!     open: &[1],
//! };
//! assert_eq!(table.firing_angle(4.0, 0.6), Ok(0.5));
//! assert_eq!(table.firing_angle(5.1, 0.6), Err(Reason::OutOfTable));
//! assert_eq!(table.firing_angle(f32::NAN, 0.6), Err(Reason::SensorInvalid));
//! ```

#![no_std]
#![forbid(unsafe_code)]

mod axis;
pub mod ball;
pub mod c_source;
mod curve;
mod decide;
mod flight;
mod map;
mod observer;
pub mod qp;
mod rate;
mod real;
mod reason;
pub mod run;
mod table;
mod take_off;
mod timing;

pub use axis::Axis;
pub use curve::FiringCurve;
pub use decide::{Controller, Decision, Guess, Limits, Obstacle, Robot, Rule, Sensed, Task};
pub use flight::{LiftOff, Linear};
pub use map::{LiftOffMap, MAP_NODE};
pub use observer::Observer;
pub use rate::Rates;
pub use real::Real;
pub use reason::Reason;
pub use table::FiringTable;
pub use take_off::{Approach, Input, MOST_TOUCH_DOWNS, NoTakeOff, TakeOff};
pub use timing::Timing;
