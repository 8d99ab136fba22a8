//! Jumps of a robot in space: from rest on its feet to a place, and out of a run, over a box or onto it.
//!
//! A jump is planned with a model of its own ([`Stance`]) and verified in the multi-body simulation ([`fly`]).
//!
//! Source: thesis 8.3.2, which leaves jumps in space to the future.

mod block;
mod fly;
mod guide;
mod hull;
mod leaper;
mod over;
mod plan;
mod reach;
mod run_up;
mod stance;
mod standing;
#[cfg(test)]
mod tests;

pub use fly::{Cycle, Flown, Jump, fly};
pub use guide::Guide;
pub use leaper::{Leap, SPEED};
pub use over::{ON, Over, Passed};
pub use plan::{JumpPlan, Planner, REACHED, landed};
pub use reach::Spot;
pub use stance::Stance;
pub use standing::Standing;

/// A leg to fire.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Which.
    pub leg: usize,
    /// When (s).
    pub at: f64,
    /// For how long its valve opens (s).
    pub open: f64,
}

/// How a robot leaves the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lift {
    /// When (s).
    pub time: f64,
    /// Where its legs meet (m).
    pub place: [f64; 3],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Spin (rad/s), the world's axes.
    pub spin: [f64; 3],
}

/// How it comes down: the first foot on the ground.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// When (s).
    pub time: f64,
    /// Where its legs meet (m).
    pub place: [f64; 3],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Spin (rad/s), the world's axes.
    pub spin: [f64; 3],
    /// Greatest height (m) of that place on the way.
    pub apex: f64,
}
