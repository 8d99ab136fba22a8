//! A ball that follows a path, by planes that it chooses as it lies.

use saltus_controller::ball::Lead;
use saltus_robot::Robot;

use super::balance::Stable;
use crate::GaitError;
use crate::error::ensure;

/// How a ball follows a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Steered {
    /// How it rolls, and is kept in its plane.
    pub stable: Stable,
    /// The points (m) of the path, which begins at the origin: along the first heading, to its left.
    pub path: Vec<[f64; 2]>,
    /// How far ahead (m) on the path the place is to which it turns.
    pub ahead: f64,
    /// How fast (rad/s) its course is turned.
    pub slew: f64,
    /// Roll (rad) from which on no leg fires until it lies still.
    pub tips: f64,
    /// Way aside (m) of its path from which on it takes no plane that leads farther away.
    pub astray: f64,
    /// How far (rad) the way to go may come off its heading before it stops, to choose another plane.
    pub turn: f64,
    /// How near (m) it must come to a point of its path.
    pub near: f64,
}

/// Valve opening time (s) of twins from rest: a ball sets out from any of its stations.
const TWINS: f64 = 0.027;
/// Spin (rad/s) below which a ball lies still, and for how long (s).
const STILL: f64 = 0.3;
const RESTS: f64 = 0.3;
/// For how long (s) no station may come before it tries another plane.
const PATIENCE: f64 = 2.0;

impl Steered {
    /// Shortest way (m) from a point of a path to the next, and from its start to the first.
    pub const LEAST_APART: f64 = 0.1;

    /// Along `path`; the numbers are for `rats-twelve`, by trials with drawn robots.
    pub fn new(path: Vec<[f64; 2]>) -> Steered {
        let mut stable = Stable::default();
        stable.first[1] = TWINS;
        Steered {
            stable,
            path,
            ahead: 2.0,
            slew: 0.1,
            tips: 0.35,
            astray: 0.5,
            turn: 0.7,
            near: 0.5,
        }
    }

    /// Straight on, to the left of the first heading by `heading` (rad).
    pub fn towards(heading: f64) -> Steered {
        let (y, x) = heading.sin_cos();
        Steered::new(vec![[MOST * x, MOST * y]])
    }

    /// How far (m) `place` is off the path by which it has come to `reached` of its points: off the piece that ends at the
    /// next of them or, while it turns the corner, the one before.
    pub fn off(&self, place: [f64; 3], reached: usize) -> f64 {
        let point = |k: usize| k.checked_sub(1).map_or([0.0; 2], |k| self.path[k]);
        let off = |k: usize| {
            let (from, to) = (point(k), point(k + 1));
            let (x, y) = (to[0] - from[0], to[1] - from[1]);
            let (a, b) = (place[0] - from[0], place[1] - from[1]);
            let part = ((a * x + b * y) / (x * x + y * y)).clamp(0.0, 1.0);
            (a - part * x).hypot(b - part * y)
        };
        let pieces = reached.saturating_sub(1)..(reached + 1).min(self.path.len());
        pieces.map(off).fold(f64::INFINITY, f64::min)
    }

    /// The controller's constants for `robot`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for numbers that cannot be, and a path without a way: no points, or two in the same place.
    pub fn lead(&self, robot: &Robot) -> Result<Lead<f64>, GaitError> {
        let lead = Lead {
            balance: self.stable.balance(robot)?,
            ahead: self.ahead,
            slew: self.slew,
            tips: self.tips,
            astray: self.astray,
            turn: self.turn,
            near: self.near,
            still: STILL,
            rests: RESTS,
            patience: PATIENCE,
        };
        let numbers = [
            ("way ahead (m)", lead.ahead),
            ("turn of the course (rad/s)", lead.slew),
            ("greatest roll (rad)", lead.tips),
            ("greatest way aside (m)", lead.astray),
            ("greatest way off the heading (rad)", lead.turn),
            ("distance from a point of the path (m)", lead.near),
        ];
        for (name, x) in numbers {
            ensure! { name, x, x > 0.0 && x <= 1e3 => "above 0, at most 1000"; }
        }
        self.check_path()?;
        Ok(lead)
    }

    fn check_path(&self) -> Result<(), GaitError> {
        let points = self.path.len();
        ensure! { "points of the path", points as f64, points > 0 => "1 or more"; }
        let mut before = [0.0; 2];
        for (k, point) in self.path.iter().enumerate() {
            for x in *point {
                let name = format!("point {} of the path (m)", k + 1);
                ensure! { &name, x, x.abs() <= MOST => "from -100000 to 100000 m"; }
            }
            let apart = (point[0] - before[0]).hypot(point[1] - before[1]);
            let name = format!("distance (m) from point {k} of the path to point {}", k + 1);
            ensure! { &name, apart, apart >= Steered::LEAST_APART => "0.1 m or more"; }
            before = *point;
        }
        Ok(())
    }
}

/// Farthest that a path leads (m).
const MOST: f64 = 1e5;
