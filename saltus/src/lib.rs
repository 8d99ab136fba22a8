//! Saltus plans the jumps of legged robots and checks its own plans.
//!
//! This is the front door: what a program needs of the crates behind it. A jump of the thesis' robot that rolls at 5 rad/s
//! onto its leg and fires it 0.1 rad before the upright:
//!
//! ```
//! use saltus::{Launch, Robot, Stance, flight_of};
//!
//! let robot = Robot::rats_planar();
//! let lift_off = Stance::<f64>::new(&robot, |_, x| x).jump(&Launch::at_firing(5.0, -0.1, 0.1))?;
//! let flight = flight_of(&lift_off, &robot);
//! assert!(flight.apex_height() > 0.57 && flight.range_to_height(0.0)? > 0.9);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The `saltus` command does the same from a shell: `saltus simulate --omega 5 --alpha-f -0.1`.

pub use saltus_ballistic as ballistic;
pub use saltus_lagrangian as lagrangian;
pub use saltus_planner as planner;
pub use saltus_pneumatics as pneumatics;
pub use saltus_robot as robot;

pub use saltus_ballistic::{Flight, FlightError};
pub use saltus_lagrangian::{Launch, LiftOff, Outcome, Stance, StanceError, Trace};
pub use saltus_robot::{Robot, RobotError, resolve};

/// The flight in vacuum that a lift-off begins.
pub fn flight_of(lift_off: &LiftOff, robot: &Robot) -> Flight<f64> {
    let ((x, y), (vx, vy)) = (lift_off.position(), lift_off.velocity());
    Flight { x, y, vx, vy, gravity: robot.environment.gravity }
}
