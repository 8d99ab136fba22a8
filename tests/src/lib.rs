//! What the tests across crates share: reference data, random robots, an independent integrator, a
//! laboratory.
//!
//! The tests themselves are in `tests/`, one file a subject.

pub mod controlled;
pub mod known;
pub mod lab;
pub mod oracle;
pub mod reference;
pub mod robots;
pub mod verdict;

/// The Rust of the documents.
#[cfg(doctest)]
mod documents {
    #[doc = include_str!("../../README.md")]
    struct Readme;
    #[doc = include_str!("../../docs/start.md")]
    struct Start;
}
