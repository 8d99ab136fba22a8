//! The discrete part of a state: what holds, slides, is open, is switched on.

use saltus_pneumatics::Piece;

use crate::complementarity::Grip;

/// What the joint of a body does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum JointMode {
    /// Stays where it is, whatever pulls.
    Latched,
    /// Moves, without dry friction.
    Free,
    /// Moves against dry friction: 1 up, −1 down.
    Sliding(f64),
    /// Held by a stop, dry friction or both.
    Held(Stop),
}

/// Where a joint is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Stop {
    Low,
    High,
    Between,
}

/// What a pair of a point and a surface does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ContactMode {
    pub closed: bool,
    /// Along and across the travel; under a friction cone the first is both.
    pub grips: [Grip; 2],
}

impl ContactMode {
    pub(crate) const OPEN: ContactMode = ContactMode {
        closed: false,
        grips: [Grip::Held; 2],
    };
}

/// What a leg's drive does.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LegMode {
    pub energized: bool,
    pub cushioned: bool,
    pub port_open: bool,
    /// The chamber's piece, for a pneumatic leg.
    pub piece: Option<Piece<f64>>,
}

/// The discrete part of a state.
#[derive(Clone, Debug)]
pub(crate) struct Mode {
    /// For each body.
    pub joints: Vec<JointMode>,
    /// For each pair of a point and a surface.
    pub contacts: Vec<ContactMode>,
    pub legs: Vec<LegMode>,
}

impl Mode {
    pub(crate) fn latched(&self) -> Vec<bool> {
        self.joints
            .iter()
            .map(|j| *j == JointMode::Latched)
            .collect()
    }
}
