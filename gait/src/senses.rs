//! What a robot that learns, or has learnt, knows of its motion.

use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};

use saltus_controller::run::{Readings, Signals};
use saltus_robot::{Robot, Sensors};

use crate::World;
use crate::cast::instruments;

/// Weights of the rate's filter, as of `saltus run`.
const TAPS: [f64; 5] = [0.2; 5];
/// Time (s) over which the encoder of the boom gives a speed.
const SPEED_OVER: f64 = 0.02;
/// Time (s) since a firing from which on it does not matter.
pub(crate) const LONG_AGO: f64 = 1.0;

/// How many numbers [`truth`] has.
pub(crate) const SEEN: usize = 8;

/// An angle from -π to π.
pub(crate) fn wrapped(angle: f64) -> f64 {
    let turned = (angle + PI).rem_euclid(TAU) - PI;
    // Where round-off makes a whole turn of a little less than nothing.
    if turned < PI { turned } else { -PI }
}

/// What its sensors say.
#[derive(Clone, Debug)]
pub(crate) struct Senses {
    signals: Signals<'static, f64>,
    sensors: Sensors,
    /// Length of the boom (m).
    reach: f64,
    /// Where the active zone begins (rad).
    zone: f64,
    pitch: f64,
    legs: usize,
    /// Lean of leg 0 by the encoder (rad), counted on.
    wheel: f64,
    /// Filtered rate of the wheel (rad/s).
    rate: f64,
    pivot: f64,
    /// Travel by the boom's encoder (m), of the last cycles.
    travelled: VecDeque<f64>,
}

impl Senses {
    /// The senses of `robot`, whose active zone begins at `zone` (rad).
    pub(crate) fn new(robot: &Robot, zone: f64) -> Senses {
        let sensors = robot.sensors.unwrap_or_default();
        Senses {
            signals: Signals::new(instruments(&sensors), &TAPS),
            sensors,
            reach: robot.boom.map_or(0.0, |boom| boom.length),
            zone,
            pitch: TAU / f64::from(robot.body.legs),
            legs: robot.body.legs as usize,
            wheel: 0.0,
            rate: 0.0,
            pivot: 0.0,
            travelled: VecDeque::new(),
        }
    }

    /// Takes what the sensors say in a cycle.
    pub(crate) fn take(&mut self, readings: &Readings) {
        let turn = |count: i32, of: f64| TAU * f64::from(count) / of.round();
        self.wheel = turn(readings.wheel, self.sensors.wheel_counts);
        self.rate = self.signals.rate(readings);
        self.pivot = turn(readings.pivot, self.sensors.pivot_counts);
        let travel = self.reach * turn(readings.radius, self.sensors.radius_counts);
        self.travelled.push_back(travel);
        let span = SPEED_OVER / self.sensors.period;
        while self.travelled.len() as f64 > span + 1.0 {
            self.travelled.pop_front();
        }
    }

    pub(crate) fn rate(&self) -> f64 {
        self.rate
    }

    /// How many legs have entered the zone.
    pub(crate) fn passed(&self) -> f64 {
        ((self.wheel - self.zone) / self.pitch).floor()
    }

    /// The leg in the zone, which is as wide as the pitch: leg k leans by the lean of leg 0 less k pitches.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    pub(crate) fn leg(&self) -> usize {
        self.passed().rem_euclid(self.legs as f64) as usize % self.legs
    }

    /// Its lean (rad).
    pub(crate) fn lean(&self) -> f64 {
        self.wheel - self.passed() * self.pitch
    }

    /// Angle and rate of the wheel: what decides in `run-zone`.
    pub(crate) fn in_zone(&self) -> [f64; 2] {
        [wrapped(self.wheel), self.rate]
    }

    /// Rate, lean, speed, pivot angle, and the distance of the box that begins at `front` (m): what decides in a stride.
    pub(crate) fn in_stride(&self, front: Option<f64>, seen: &mut Vec<f64>) {
        let travel = self.travelled.back().copied().unwrap_or(0.0);
        let first = self.travelled.front().copied().unwrap_or(travel);
        let cycles = self.travelled.len().saturating_sub(1).max(1) as f64;
        let speed = (travel - first) / (cycles * self.sensors.period);
        seen.clear();
        seen.extend([self.rate, self.lean(), speed, self.pivot]);
        seen.extend(front.map(|front| front - travel));
    }
}

/// What no sensor says, and the simulation does: angles and rates of wheel and pivot (of a robot without a boom height
/// and its rate); extension, pressure and time since it was `fired` (s) of the leg that is nearest to upright below;
/// time (s).
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
pub(crate) fn truth(world: &World<'_>, fired: &[f64]) -> [f64; SEEN] {
    let motion = world.motion();
    let [angle, rate] = motion.pivot;
    let legs = fired.len() as f64;
    let leg = (motion.lean / (TAU / legs)).round().rem_euclid(legs) as usize % fired.len();
    let (rig, sim) = (world.rig(), world.looked_at());
    [
        wrapped(motion.lean),
        motion.rate,
        angle,
        rate,
        sim.coordinates()[rig.extension_coordinate(leg)],
        sim.pressure(leg),
        (motion.time - fired[leg]).min(LONG_AGO),
        motion.time,
    ]
}
