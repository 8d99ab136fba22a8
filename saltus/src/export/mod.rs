//! The planner's answers as tables for a controller: built, measured against the planner, and
//! written as C or Rust; and what decides on a running robot or a ball, in C.
//!
//! ```
//! use saltus::controller::{Sensed, Task};
//! use saltus::export::{Request, Tables};
//! use saltus::{Planner, Robot};
//!
//! let planner = Planner::new(Robot::rats_planar());
//! let request = Request { distances: (0.5, 0.7, 3), rates: (4.0, 5.0, 3), angles: 5, ..Request::default() };
//! let tables = Tables::<f32>::new(&planner, &request)?;
//! let task = Task { distance: 0.6, landing_height: tables.controller().robot.landing_height, obstacle: None, guess: None };
//! let decision = tables.controller().decide(&Sensed { lean: -0.3, rate: 4.8 }, &task)?;
//! assert!(decision.approach_rate > 4.0 && decision.approach_rate < 4.8);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ball;
mod c;
mod files;
mod layout;
mod learnt;
mod numbers;
mod plant;
mod request;
mod running;
mod rust;
mod tables;
mod vectors;

pub use files::CFiles;
pub use learnt::LearntTable;
pub use numbers::Number;
pub use plant::planner;
pub use request::{ExportError, Request};
pub use tables::{Confirmed, Misses, Tables, fingerprint};
