//! What the tests across crates share: reference data, random robots, an independent integrator.
//!
//! The tests themselves are in `tests/`, one file a subject.

pub mod oracle;
pub mod reference;
pub mod robots;
