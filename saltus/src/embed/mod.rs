//! The planner's answers as tables for a controller: built, measured against the planner, and written as C or Rust.
//!
//! ```
//! use saltus::controller::{Sensed, Task};
//! use saltus::embed::{Request, Tables};
//! use saltus::{Planner, Robot};
//!
//! let planner = Planner::new(Robot::rats_planar());
//! let request = Request { distances: (0.5, 0.7, 3), rates: (4.0, 5.0, 3), angles: 5, ..Request::default() };
//! let tables = Tables::<f32>::new(&planner, &request)?;
//! let task = Task { distance: 0.6, landing_height: 0.0, obstacle: None, guess: None };
//! let decision = tables.controller().decide(&Sensed { lean: -0.5, rate: 4.5 }, &task)?;
//! assert!((decision.firing_angle - -0.1303).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod c;
mod numbers;
mod rust;
mod tables;
mod vectors;

pub use numbers::Number;
pub use tables::{EmbedError, Misses, Request, Tables};
