//! A ball with legs all around, which rolls as a disc on those near one plane through its middle.
//!
//! [`AtRest`] says how it lies at first. An [`Estimator`] makes attitude, rates and way of what gyros, accelerometers and foot switches say; a [`Tracker`] says
//! how the plane lies and which station is in the active zone; a [`Balancer`] fires the station on the ground, and by the
//! difference between twins keeps the plane upright and its course.
//!
//! Axes of the world: x along the first heading, y to its left, z up. Rolls are right-handed about the heading, to the
//! right; headings about the vertical, to the left.
//!
//! Source: thesis 7.2, 7.3 and 8.3.1.

mod balance;
mod estimate;
mod pilot;
mod plane;
mod rest;
mod rotation;

pub use balance::{Balance, Balancer, Firing, Sight, Steer};
pub use estimate::{Estimate, Estimator, Feet, Filter, Inertial, Scales};
pub use pilot::{Lead, Pilot, View};
pub use plane::{Lying, Plane, Station, Tracker};
pub use rest::{AtRest, Unsettled};
pub use rotation::Rotation;
