//! Saltus plans the jumps of legged robots and checks its own plans.
//!
//! This is the front door: what a program needs of the crates behind it. A jump of the thesis'
//! robot that rolls at 5 rad/s onto its leg and fires it 0.1 rad before the upright:
//!
//! ```
//! use saltus::{Launch, Planner, Robot};
//!
//! let planner = Planner::new(Robot::rats_planar());
//! let jump = planner.jump(&Launch::at_firing(5.0, -0.1, 0.1))?;
//! assert!(jump.apex().is_some_and(|apex| (apex - 0.556).abs() < 1e-3));
//! assert!(jump.distance(0.0).is_some_and(|distance| (distance - 0.907).abs() < 1e-3));
//! # Ok::<(), saltus::StanceError>(())
//! ```
//!
//! The `saltus` command does the same from a shell: `saltus simulate --omega 5 --alpha-f -0.1`.
//!
//! # More programs
//!
//! A firing table:
#![doc = concat!("```\n", include_str!("../examples/table.rs"), "```")]
//!
//! The plan of a course, verified:
#![doc = concat!("```\n", include_str!("../examples/verify_a_course.rs"), "```")]
//!
//! Measured data, diagnosed:
#![doc = concat!("```\n", include_str!("../examples/diagnose_a_folder.rs"), "```")]
//!
//! A controller of one's own, in the loop:
#![doc = concat!("```\n", include_str!("../examples/own_controller.rs"), "```")]
//!
//! Tables for a controller, as C:
#![doc = concat!("```\n", include_str!("../examples/export_tables.rs"), "```")]
//!
//! # Features
//!
//! `telemetry` (off by default, it brings 17 packages): motions are written as MCAP files and runs
//! are read from them.
#![cfg_attr(test, allow(clippy::unwrap_used))]

pub mod chart;
pub mod course;
pub mod experiment;
pub mod export;
pub mod filling;
pub mod fit;
pub mod inject;
pub mod input;
pub mod learning;
pub mod on_plant;
pub mod origin;
pub mod power;
#[cfg(feature = "telemetry")]
pub mod recording;
pub mod replan;
pub mod robust;
pub mod running;
pub mod simulated;
pub mod study;
pub mod temporary;
pub mod usual;
pub mod verify;

pub use saltus_ballistic as ballistic;
pub use saltus_controller as controller;
pub use saltus_diagnosis as diagnosis;
pub use saltus_gait as gait;
pub use saltus_lagrangian as lagrangian;
pub use saltus_numeric as numeric;
pub use saltus_planner as planner;
pub use saltus_pneumatics as pneumatics;
pub use saltus_robot as robot;
pub use saltus_sim_check as sim_check;
#[cfg(feature = "telemetry")]
pub use saltus_telemetry as telemetry;

pub use saltus_ballistic::{DragFlight, Flight, FlightError};
pub use saltus_lagrangian::{Launch, LiftOff, Outcome, Stance, StanceError, Trace};
pub use saltus_planner::{Jump, Planner};
pub use saltus_robot::{Robot, RobotError, resolve};
