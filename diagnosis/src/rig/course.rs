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
    /// When (s) the foot of a robot that starts in the air first comes down.
    pub lands: Option<f64>,
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
    /// Travel of the axle (m), on a boom along its arc, and its rate. The foot is at 0.
    pub travel: (f64, f64),
    /// Where the boom is, if there is one.
    pub boom: Option<BoomPose>,
    /// Height of the axle (m), and its rate.
    pub height: (f64, f64),
    /// Extension of the leg (m), and its rate.
    pub extension: (f64, f64),
    /// Pressure in the chamber (Pa), and its rate.
    pub pressure: (f64, f64),
}

/// Where a boom is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BoomPose {
    /// Radius angle ψ (rad), and its rate (rad/s). The foot is at 0.
    pub turn: (f64, f64),
    /// Pivot angle θ at its base (rad), and its rate (rad/s).
    pub pivot: (f64, f64),
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
        let turn = of(TURN);
        Pose {
            lean: of(LEAN),
            travel: self
                .boom
                .map_or(turn, |length| (length * turn.0, length * turn.1)),
            boom: self.boom.map(|_| BoomPose {
                turn,
                pivot: of(PIVOT),
            }),
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

#[cfg(test)]
mod tests {
    use super::*;

    const G: f64 = 9.81;
    /// A throw: rise and forward speed (m/s) of an axle at height `RADIUS` (m).
    const UP: f64 = 3.0;
    const FORWARD: f64 = 1.5;
    const RADIUS: f64 = 0.24;

    /// A flight from 0.1 s on, in knots 50 ms apart, over which the axle turns the foot at 2 rad/s;
    /// it ends just below the height at which it began.
    fn thrown() -> Course {
        let knot = |k: i32| {
            let t = f64::from(k) * 0.05;
            let (mut q, mut v) = (Coordinates::zeros(), Coordinates::zeros());
            (q[LEAN], v[LEAN]) = (2.0 * t, 2.0);
            (q[TURN], v[TURN]) = (FORWARD * t, FORWARD);
            Knot {
                time: 0.1 + t,
                q,
                v,
                height: (RADIUS + UP * t - 0.5 * G * t * t, UP - G * t),
                pressure: (1e5, 0.0),
            }
        };
        Course {
            knots: (0..=13).map(knot).collect(),
            radius: RADIUS,
            leaves: Some(0.1),
            ..Course::default()
        }
    }

    #[test]
    fn apex_and_landing_of_a_throw_are_in_closed_form() {
        let (apex, landing) = thrown().apex_and_landing().expect("it lands");
        assert!((apex - RADIUS - 0.5 * UP * UP / G).abs() < 1e-12, "{apex}");
        assert!(
            (landing - 2.0 * UP / G * FORWARD).abs() < 1e-12,
            "{landing}"
        );
        // On a boom the travel is an arc.
        let course = Course {
            boom: Some(1.2),
            ..thrown()
        };
        let (_, arc) = course.apex_and_landing().expect("it lands");
        assert!((arc - 1.2 * landing).abs() < 1e-12, "{arc}");
    }

    #[test]
    fn between_knots_a_parabola_is_exact_wherever_the_search_begins() {
        let course = thrown();
        for k in 0..600 {
            let t = f64::from(k) * 1e-3;
            let mut places = [0, 7, 99];
            for place in &mut places {
                let pose = course.at(0.1 + t, place);
                let height = RADIUS + UP * t - 0.5 * G * t * t;
                assert!((pose.height.0 - height).abs() < 1e-12, "{t}: {pose:?}");
                assert!(
                    (pose.height.1 - (UP - G * t)).abs() < 1e-10,
                    "{t}: {pose:?}"
                );
                assert!((pose.lean.0 - 2.0 * t).abs() < 1e-12, "{t}: {pose:?}");
            }
        }
    }

    #[test]
    fn before_the_start_it_moves_on_and_after_the_end_it_stays() {
        let course = thrown();
        let early = course.at(0.0, &mut 0);
        assert!((early.lean.0 + 0.2).abs() < 1e-12, "{early:?}");
        assert!((early.height.0 - (RADIUS - 0.1 * UP)).abs() < 1e-12);
        let last = course.knots.last().expect("knots");
        assert!((course.at(99.0, &mut 0).height.0 - last.height.0).abs() < 1e-12);
    }
}
