//! A machine in a plane as its operator describes it: links that hang on each other, what is in their
//! joints, what drives them, and what is measured.
//!
//! Places are forward and up (m). Angles count from up to forward (rad). The frame of a link is where
//! its joint is.

use std::fmt;

/// A machine: links, each after the one that carries it.
#[derive(Clone, Debug, PartialEq)]
pub struct Mechanism {
    /// What messages call it.
    pub name: String,
    /// Acceleration of gravity (m/s²), downwards, ≥ 0.
    pub gravity: f64,
    /// The links, one coordinate each.
    pub links: Vec<Link>,
    /// Springs in joints.
    pub springs: Vec<Spring>,
    /// Measured torques and forces that act on joints.
    pub drives: Vec<Drive>,
    /// What else is measured.
    pub gauges: Vec<Gauge>,
}

/// A link.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Its name.
    pub name: String,
    /// The joint that carries it.
    pub joint: Joint,
    /// Mass (kg), ≥ 0.
    pub mass: f64,
    /// Centre of mass (m) in its frame.
    pub center: [f64; 2],
    /// Moment of inertia.
    pub inertia: Inertia,
    /// What hangs on it by a counterweight.
    pub counterweight: Option<Counterweight>,
}

/// Moment of inertia (kg m²) of a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Inertia {
    /// About its centre of mass, ≥ 0.
    Center(f64),
    /// Nobody knows it: it follows from the data.
    Unknown,
}

/// A joint: where it is on the link that carries it, and how it moves.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name.
    pub name: String,
    /// Index of the link that carries it; none: the ground.
    pub parent: Option<usize>,
    /// How it moves.
    pub way: Way,
    /// Where it is (m) in the parent's frame.
    pub at: [f64; 2],
    /// Angle (rad) of the link's frame from its parent's where its coordinate is 0.
    pub angle: f64,
    /// Dry friction (N m or N), ≥ 0.
    pub friction: f64,
    /// Damping (N m s/rad or N s/m), ≥ 0.
    pub damping: f64,
}

impl Joint {
    /// One that turns forward, without friction.
    pub(crate) fn turning(name: &str, parent: Option<usize>, at: [f64; 2]) -> Joint {
        Joint {
            name: name.into(),
            parent,
            way: Way::Turns { back: false },
            at,
            angle: 0.0,
            friction: 0.0,
            damping: 0.0,
        }
    }
}

/// How a joint moves as its coordinate grows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// It turns forward, or back.
    Turns {
        /// Whether it turns back.
        back: bool,
    },
    /// It slides along a unit vector of the joint's frame.
    Slides([f64; 2]),
}

/// A mass that hangs on a link beside a counterweight, as on a boom: it has inertia, and less weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Counterweight {
    /// What it is called.
    pub name: String,
    /// Where (m) in the link's frame.
    pub at: [f64; 2],
    /// Mass (kg) as it is believed, weight and inertia alike, ≥ 0.
    pub mass: f64,
}

/// A spring in a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Spring {
    /// Index of the link whose joint it is in.
    pub joint: usize,
    /// Its torque or force.
    pub law: Law,
}

/// Torque or force of a spring over the coordinate of its joint.
#[derive(Clone, Debug, PartialEq)]
pub enum Law {
    /// In proportion to how far the coordinate is beyond a place, towards it.
    Linear {
        /// Stiffness (N m/rad or N/m), ≥ 0.
        stiffness: f64,
        /// The place (rad or m).
        from: f64,
        /// On which side it acts.
        side: Side,
    },
    /// Between places that rise, in the direction of the coordinate (rad or m; N m or N).
    Table(Vec<[f64; 2]>),
}

/// On which side of its place a spring acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// On both.
    Both,
    /// Where the coordinate is above it.
    Above,
    /// Where the coordinate is below it.
    Below,
}

/// A measured torque or force on a joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Drive {
    /// Its column.
    pub column: String,
    /// Index of the link whose joint it acts on.
    pub joint: usize,
}

/// A measured column.
#[derive(Clone, Debug, PartialEq)]
pub struct Gauge {
    /// Its name.
    pub column: String,
    /// What it shows.
    pub shows: Shows,
}

/// What a column shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shows {
    /// The coordinate of the joint of the link with this index.
    Coordinate(usize),
    /// The angle (rad) of a link from the world's axes.
    Angle {
        /// Index of the link.
        link: usize,
        /// Whether it counts back.
        back: bool,
    },
    /// A point of a link.
    Place {
        /// Index of the link.
        link: usize,
        /// The point (m) in the link's frame.
        at: [f64; 2],
        /// 0: how far forward; 1: how high.
        axis: usize,
    },
}

impl Law {
    /// Torque or force at a coordinate.
    pub fn at(&self, q: f64) -> f64 {
        match self {
            Law::Linear {
                stiffness,
                from,
                side,
            } => {
                let beyond = q - from;
                let acts = match side {
                    Side::Both => true,
                    Side::Above => beyond > 0.0,
                    Side::Below => beyond < 0.0,
                };
                if acts { -stiffness * beyond } else { 0.0 }
            }
            Law::Table(points) => {
                let after = points.partition_point(|p| p[0] <= q);
                let after = after.clamp(1, points.len() - 1);
                let ([a, b], [c, d]) = (points[after - 1], points[after]);
                b + (d - b) * (q - a) / (c - a)
            }
        }
    }
}

impl Joint {
    /// Whether it turns.
    pub fn turns(&self) -> bool {
        matches!(self.way, Way::Turns { .. })
    }
}

impl Mechanism {
    /// The links from `link` to the ground.
    pub fn to_ground(&self, link: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(link), |k| self.links[*k].joint.parent)
    }

    /// Whether link `outer` is `link`, or hangs on it.
    pub fn carries(&self, link: usize, outer: usize) -> bool {
        self.to_ground(outer).any(|k| k == link)
    }
}

impl fmt::Display for Side {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Side::Both => "both",
            Side::Above => "above",
            Side::Below => "below",
        })
    }
}
