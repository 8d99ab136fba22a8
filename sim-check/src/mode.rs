//! The discrete part of a state: what holds, slides, is open, is switched on.

use saltus_pneumatics::{Feed, Piece};

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
    /// The chamber's piece, for a pneumatic leg that is not fed.
    pub piece: Option<Piece<f64>>,
    /// The valve's spool, for one that is.
    pub spool: Spool,
}

/// Since when (s) a spool goes where its valve sends it, and from which opening.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Spool {
    since: f64,
    from: f64,
}

impl Spool {
    /// Time constants after which a spool counts as shut.
    const SHUT: f64 = 40.0;

    /// How far the valve is open at `time` (s), sent `open` or shut.
    pub(crate) fn opening(&self, feed: &Feed<f64>, open: bool, time: f64) -> f64 {
        feed.opening(self.from, open, time - self.since)
    }

    /// Whether gas may come from the tank at `time` (s).
    pub(crate) fn moves(&self, feed: &Feed<f64>, open: bool, time: f64) -> bool {
        open || (self.from > 0.0 && time - self.since < Spool::SHUT * feed.spool_time())
    }

    /// Sent the other way at `time` (s), where it was sent `open` or shut.
    pub(crate) fn turned(&self, feed: &Feed<f64>, open: bool, time: f64) -> Spool {
        Spool {
            since: time,
            from: self.opening(feed, open, time),
        }
    }
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
