//! What a gait is worth: rolling without drive, strides and periodic gaits, basins, energy, and the
//! frontier of speed against gas.

mod chart;
pub mod passive;
pub mod periodic;
pub mod stride;
