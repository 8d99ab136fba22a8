//! What the planner asks of a robot.

use saltus_numeric::Dual;

use super::{Envelope, Span};

/// Which edge of an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The one met first.
    Front,
    /// The one passed last.
    Back,
}

/// A corner that a jump may have to clear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Position (m).
    pub x: f64,
    /// Height (m).
    pub top: f64,
    /// Index of its obstacle in the course.
    pub obstacle: usize,
    /// Which edge of it.
    pub side: Side,
}

/// One jump of a choice: from a ground to a ground, over the edges between.
#[derive(Clone, Debug, PartialEq)]
pub struct Leap {
    /// Index of the jump in the course.
    pub jump: usize,
    /// Height of the foothold (m).
    pub from: f64,
    /// Height of the surface to land on (m).
    pub to: f64,
    /// Edges between foothold and landing, in the order of the travel.
    pub edges: Vec<Edge>,
}

/// What a margin is about.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// Clearance (m) over an edge of an obstacle.
    Edge {
        /// Index of the obstacle in the course.
        obstacle: usize,
        /// Which edge of it.
        side: Side,
    },
    /// Distance (m) of the landing from the beginning or the end of the ground chosen for it.
    Landing(Side),
    /// Distance (m) of the last landing from the goal.
    Goal,
    /// A limit of the robot itself.
    Robot(&'static str),
}

/// How far a limit is from being violated; ≥ 0 where it holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Margin<S> {
    /// What it is about.
    pub limit: Limit,
    /// Amount, in the limit's unit.
    pub value: S,
}

/// What a jump comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight<S> {
    /// Where it lands (m along the course).
    pub landing: S,
    /// What it costs; the plan has the least sum. Never below the [`Envelope`].
    pub cost: S,
    /// Standard deviation of the landing (m), ≥ 0.
    pub deviation: S,
}

/// A foothold and the two decisions of a jump, as directions of derivatives: foothold 0, decisions 1 and 2.
pub type Slope = Dual<3>;

/// A robot that jumps from a foothold with two decisions.
pub trait Jumper {
    /// The allowed values of the decisions of jump number `jump`; both spans have a width.
    fn decisions(&self, jump: usize) -> [Span; 2];

    /// Flies a jump, and adds its margins to `margins`: as many and in the same order for a given leap.
    ///
    /// A jump that does not reach the surface gives a landing or a cost that is not finite.
    fn fly(
        &self,
        leap: &Leap,
        foot: Slope,
        decisions: [Slope; 2],
        margins: &mut Vec<Margin<Slope>>,
    ) -> Flight<Slope>;

    /// The best known decisions for a jump from `foot` to `landing` (m): where the solver starts, and already the
    /// answer where the jumper can solve this in closed form.
    fn aim(&self, leap: &Leap, foot: f64, landing: f64) -> [f64; 2];

    /// A convex function of the distance from foothold to landing that no allowed jump from within `feet` to within
    /// `landings` over a distance in `reach` undercuts in cost; none if there is no such jump.
    fn envelope(&self, leap: &Leap, feet: Span, landings: Span, reach: Span) -> Option<Envelope>;

    /// Least distance (m) of a landing from an obstacle's edge, ≥ 0.
    fn edge_margin(&self) -> f64;

    /// Distance (m) from the landing before jump number `jump` to its foothold; not asked for jump 0.
    fn roll(&self, _jump: usize) -> f64 {
        0.0
    }
}
