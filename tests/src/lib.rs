//! What the tests across crates share: reference data, random robots, an independent integrator, a
//! laboratory.
//!
//! The tests themselves are in `tests/`, one file a subject.

pub mod controlled;
pub mod lab;
pub mod oracle;
pub mod reference;
pub mod robots;
pub mod verdict;
