//! What a gait is worth: strides and periodic gaits, which starts lead to running, where energy goes,
//! and the frontier of speed against gas.

pub mod basin;
pub mod branch;
mod chart;
pub mod energy;
pub mod frontier;
pub mod periodic;
mod report;
pub mod stride;

pub use report::{Effort, Report, report};
