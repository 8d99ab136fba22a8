//! The result of a run: states at knots, and what sensors would read between them.

use saltus_numeric::hermite;
use saltus_numeric::root::bisect;

use super::machine::{Coordinates, LEAN, LEG, PIVOT, TURN};

/// The motion of a robot from its start.
#[derive(Clone, Debug, Default)]
pub struct Course {
    pub(super) knots: Vec<Knot>,
    /// Length of the boom (m), if there is one.
    pub(super) boom: Option<f64>,
    /// Height of the axle on a retracted, upright leg (m).
    pub(super) radius: f64,
    /// When (s) the leg begins to move.
    pub breaks_away: Option<f64>,
    /// When (s) the foot leaves the ground.
    pub leaves: Option<f64>,
}

/// A state on a course.
#[derive(Clone, Copy, Debug)]
pub(super) struct Knot {
    pub(super) time: f64,
    pub(super) q: Coordinates,
    pub(super) v: Coordinates,
    pub(super) height: (f64, f64),
    pub(super) pressure: (f64, f64),
}

/// What sensors without error would read.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Lean φ of the leg (rad), and its rate (rad/s).
    pub lean: (f64, f64),
    /// Pivot angle θ of the boom at its base (rad), and its rate; height of the axle (m) without a
    /// boom.
    pub pivot: (f64, f64),
    /// Radius angle ψ (rad), and its rate; travel of the axle (m) without a boom. The foot is at 0.
    pub turn: (f64, f64),
    /// Height of the axle (m), and its rate.
    pub height: (f64, f64),
    /// Extension of the leg (m), and its rate.
    pub extension: (f64, f64),
    /// Pressure in the chamber (Pa), and its rate.
    pub pressure: (f64, f64),
}

impl Course {
    /// The pose at `time` (s). Before the start it moves on at the first rates; after the end it is
    /// the last pose. The search begins at the knot `place`, which becomes the one found.
    pub fn at(&self, time: f64, place: &mut usize) -> Pose {
        let knots = &self.knots;
        if *place + 1 >= knots.len() || knots[*place].time > time {
            *place = 0;
        }
        while *place + 2 < knots.len() && knots[*place + 1].time < time {
            *place += 1;
        }
        let (a, b) = (&knots[*place], &knots[(*place + 1).min(knots.len() - 1)]);
        let h = b.time - a.time;
        let s = if h > 0.0 {
            ((time - a.time) / h).clamp(0.0, 1.0)
        } else {
            1.0
        };
        let early = (time - a.time).min(0.0);
        let at = |a: (f64, f64), b| {
            let (value, slope) = hermite(a, b, h, s);
            (value + if early < 0.0 { a.1 * early } else { 0.0 }, slope)
        };
        let of = |k: usize| at((a.q[k], a.v[k]), (b.q[k], b.v[k]));
        Pose {
            lean: of(LEAN),
            pivot: of(PIVOT),
            turn: of(TURN),
            height: at(a.height, b.height),
            extension: of(LEG),
            pressure: at(a.pressure, b.pressure),
        }
    }

    pub(super) fn apex_and_landing(&self) -> Option<(f64, f64)> {
        // Before, the axle rises and sinks on its way over the foot.
        let flight = &self.knots[self.knots.partition_point(|k| Some(k.time) < self.leaves)..];
        let apex = flight
            .windows(2)
            .find(|w| w[0].height.1 > 0.0 && w[1].height.1 <= 0.0);
        let top = match apex {
            Some([a, b]) => {
                let h = b.time - a.time;
                let s = root(|s| hermite(a.height, b.height, h, s).1);
                hermite(a.height, b.height, h, s).0
            }
            _ => flight.iter().map(|k| k.height.0).fold(0.0, f64::max),
        };
        let [.., a, b] = &self.knots[..] else {
            return None;
        };
        let h = b.time - a.time;
        let s = root(|s| hermite(a.height, b.height, h, s).0 - self.radius);
        let turn = hermite((a.q[TURN], a.v[TURN]), (b.q[TURN], b.v[TURN]), h, s).0;
        Some((top, turn * self.boom.unwrap_or(1.0)))
    }
}

/// Root of a function that falls through 0 on [0, 1].
fn root(f: impl Fn(f64) -> f64) -> f64 {
    let (a, b) = bisect(0.0, 1.0, 60, |s| f(s) > 0.0);
    0.5 * (a + b)
}
