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

/// How long the leg pushes, where that makes the results of a jump kink or leap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Push {
    /// As the decisions say.
    #[default]
    Any,
    /// To the end of the stance, whatever longer a decision says.
    Whole,
    /// Not to the end of the stance.
    Part,
    /// Not even until the leg has moved to its stop: its force falls to nothing before.
    Short,
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
    /// Indices of the obstacles that foothold and landing are on; none for the ground itself.
    pub on: [Option<usize>; 2],
    /// Edges between foothold and landing, in the order of the travel.
    pub edges: Vec<Edge>,
    /// Sides of obstacles beside the ground of the foothold that rise above it and are within the
    /// jumper's [`girth`](Jumper::girth).
    pub beside: Vec<Edge>,
    /// Which of the jumps over it are meant.
    pub push: Push,
}

impl Leap {
    /// Whether an edge is of the obstacle that is landed on.
    pub fn lands_on(&self, edge: &Edge) -> bool {
        self.on[1] == Some(edge.obstacle)
    }
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
    /// Distance (m) of the standing jumper from the side of an obstacle beside its foothold.
    Stance {
        /// Index of the obstacle in the course.
        obstacle: usize,
        /// Which side of it.
        side: Side,
    },
    /// Distance (m) of the landing from the beginning or the end of the ground chosen for it.
    Landing(Side),
    /// Distance (m) of the last landing from the goal.
    Goal,
    /// A limit of the robot itself.
    Robot(&'static str),
}

impl Limit {
    /// Index of the obstacle that it is about.
    pub fn obstacle(&self) -> Option<usize> {
        match self {
            Limit::Edge { obstacle, .. } | Limit::Stance { obstacle, .. } => Some(*obstacle),
            _ => None,
        }
    }
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
}

/// What a jump is about, without its derivatives and up to the solver's last word.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sketch {
    /// Decisions.
    pub decisions: [f64; 2],
    /// What it costs.
    pub cost: f64,
}

/// A foothold and the two decisions of a jump, as directions of derivatives: foothold 0, decisions
/// 1 and 2.
pub type Slope = Dual<3>;

/// A robot that jumps from a foothold with two decisions.
pub trait Jumper {
    /// The allowed values of the decisions of jump number `jump`; both spans have a width.
    fn decisions(&self, jump: usize) -> [Span; 2];

    /// Flies a jump, and adds its margins to `margins`: as many and in the same order for a given
    /// leap.
    ///
    /// A jump that does not reach the surface gives a landing or a cost that is not finite.
    fn fly(
        &self,
        leap: &Leap,
        foot: Slope,
        decisions: [Slope; 2],
        margins: &mut Vec<Margin<Slope>>,
    ) -> Flight<Slope>;

    /// Standard deviation (m) of the landing of a jump with these decisions, ≥ 0, wherever its
    /// foothold is.
    fn deviation(&self, _leap: &Leap, _decisions: [f64; 2]) -> f64 {
        0.0
    }

    /// How a jump with these decisions pushes.
    fn push(&self, _leap: &Leap, _decisions: [f64; 2]) -> Push {
        Push::Any
    }

    /// Where jump number `jump` has to land (m), beside the course's own limits.
    fn window(&self, _jump: usize) -> Span {
        Span::ALL
    }

    /// The best known decisions for a jump from `foot` to `landing` (m): where the solver starts,
    /// and already the answer where the jumper can solve this in closed form.
    fn aim(&self, leap: &Leap, foot: f64, landing: f64) -> [f64; 2];

    /// The cheapest jump from `foot` to `landing` (m) whose landing has a standard deviation of at
    /// most `scatter` (m), roughly; none if there is none, or if the jumper makes no sketches.
    fn sketch(&self, _leap: &Leap, _foot: f64, _landing: f64, _scatter: f64) -> Option<Sketch> {
        None
    }

    /// Decisions all over what is allowed for a jump over `leap`, at which the jumper flies: where the
    /// solver may start for the nearest course.
    fn spread(&self, _leap: &Leap) -> Vec<[f64; 2]> {
        Vec::new()
    }

    /// A convex function of the distance from foothold to landing that no allowed jump from within
    /// `feet` to within `landings` over a distance in `reach` undercuts in cost; none if there is
    /// no such jump.
    fn envelope(&self, leap: &Leap, feet: Span, landings: Span, reach: Span) -> Option<Envelope>;

    /// Least distance (m), ≥ 0, of a landing from an obstacle that rises by `rise` (m) above its
    /// surface; where `rise` is 0, from the edge of the obstacle that is landed on.
    fn edge_margin(&self, rise: f64) -> f64;

    /// Least distance (m), ≥ 0, of a landing from a no-landing area and from the ends of a goal
    /// that is a zone.
    fn zone_margin(&self) -> f64 {
        0.0
    }

    /// Where in the goal (m) the last jump should land; the solver starts from jumps of even
    /// distances to there.
    fn target(&self, goal: Span) -> f64 {
        f64::midpoint(goal.low, goal.high)
    }

    /// How near (m) an obstacle has to be for the jumper to touch it where it stands, ≥ 0.
    fn girth(&self) -> f64 {
        0.0
    }

    /// Distance (m) from the landing before jump number `jump` to its foothold; not asked for
    /// jump 0.
    fn roll(&self, _jump: usize) -> f64 {
        0.0
    }
}
