//! When valves close while legs push: by where the robot would land.

use nalgebra::{UnitQuaternion, Vector3};
use saltus_robot::Robot;

type Vec3 = Vector3<f64>;

/// Closes valves, a cycle at a time.
///
/// From the velocity and how it grows, each cycle finds where the robot would land if all valves closed now, after their
/// delay: a parabola down to `height`. A valve closes once more push of its leg would bring the landing no nearer to the aim.
#[derive(Clone, Debug, PartialEq)]
pub struct Guide {
    /// Where to land (m).
    pub aim: [f64; 2],
    /// Height (m) of where the legs meet at the landing.
    pub height: f64,
    gravity: f64,
    period: f64,
    directions: Vec<Vec3>,
    delays: Vec<f64>,
    /// Velocities (m/s) of the last cycles, the newest first.
    before: Vec<Vec3>,
}

/// What a robot knows of its motion in a cycle.
#[derive(Clone, Copy, Debug)]
pub(super) struct Known {
    pub(super) attitude: UnitQuaternion<f64>,
    pub(super) place: Vec3,
    pub(super) velocity: Vec3,
}

/// Cycles over which the growth of the velocity is taken.
const SPAN: usize = 2;
/// How long (s) a leg must have pushed before its valve may close.
const SETTLES: f64 = 2.5e-3;

impl Guide {
    /// For `robot`, to land at `aim` (m) with its legs meeting `height` (m) up.
    pub fn new(robot: &Robot, aim: [f64; 2], height: f64) -> Guide {
        let directions = robot.space.as_ref().map(|it| it.directions.vectors());
        let directions: Vec<Vec3> = directions
            .unwrap_or_default()
            .into_iter()
            .map(Vec3::from)
            .collect();
        Guide {
            aim,
            height,
            gravity: robot.environment.gravity,
            period: robot.sensors.unwrap_or_default().period,
            // It knows what its file says, not what this leg is like.
            delays: vec![robot.leg.delay; directions.len()],
            directions,
            before: Vec::new(),
        }
    }

    /// Its cycle (s).
    pub(super) fn period(&self) -> f64 {
        self.period
    }

    /// A cycle at the time `now` (s): whether the valve of each of `legs`, commanded at that time (s), closes.
    pub(super) fn closes(&mut self, now: f64, known: &Known, legs: &[(usize, f64)]) -> Vec<bool> {
        let slower = self.before.last().copied();
        self.before.insert(0, known.velocity);
        self.before.truncate(SPAN);
        let (Some(slower), true) = (slower, self.before.len() == SPAN) else {
            return vec![false; legs.len()];
        };
        let growth = (known.velocity - slower) / (SPAN as f64 * self.period);
        let of = |&(leg, at): &(usize, f64)| {
            let delay = self.delays[leg];
            if now < at + delay + SETTLES {
                return false;
            }
            let velocity = known.velocity + growth * delay;
            let place = known.place + known.velocity * delay + growth * (0.5 * delay * delay);
            let Some(flight) = self.flight(place.z, velocity.z) else {
                return false;
            };
            let up = -(known.attitude * self.directions[leg]);
            let longer = flight / (self.gravity * flight - velocity.z).max(1e-9);
            let mut left = 0.0;
            for k in 0..2 {
                let lands = place[k] + velocity[k] * flight;
                left += (self.aim[k] - lands) * (flight * up[k] + velocity[k] * longer * up.z);
            }
            left <= 0.0
        };
        legs.iter().map(of).collect()
    }

    /// How long (s) a flight is that begins `z` (m) up and rises at `speed` (m/s); none: it does not come so high.
    fn flight(&self, z: f64, speed: f64) -> Option<f64> {
        let square = speed * speed + 2.0 * self.gravity * (z - self.height);
        (square >= 0.0 && speed > 0.0).then(|| (speed + square.sqrt()) / self.gravity)
    }
}
