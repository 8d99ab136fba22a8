//! One decision a stride: at which lean the next leg fires, and for how long.
//!
//! Source: thesis 8.3.2, which recommends to learn firing angles in place of legs.

use std::collections::VecDeque;
use std::f64::consts::TAU;
use std::sync::Arc;

use saltus_controller::run::Signals;
use saltus_robot::Sensors;

use crate::GaitError;
use crate::cast::instruments;
use crate::error::{refused, require};
use crate::surroundings::Surroundings;

use super::plant::{Body, Plant};
use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
use super::reward::{Reward, Stepped};
use super::zone::{TAPS, Task};

/// Rate (rad/s) below which, and time (s) after which a robot has stalled.
const STALLS: (f64, f64) = (0.5, 0.4);
/// Time (s) over which the encoder of the boom gives a speed.
const SPEED_OVER: f64 = 0.02;
/// Longest opening of the valve (s).
const LONGEST: f64 = 0.1;

/// Each time another leg enters the active zone the learner says at which lean it fires, and how long its valve is
/// open. The robot observes by its encoders and its filtered gyro.
pub struct Stride {
    plant: Plant,
    ready: Option<Arc<Surroundings>>,
    reward: Reward,
    task: Task,
    observed: Vec<Axis>,
    actions: Actions,
}

impl Stride {
    /// `plant`, rewarded by `reward`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run, and for times that are not above 0.
    pub fn new(plant: Plant, reward: Reward, task: Task) -> Result<Stride, GaitError> {
        task.check()?;
        let pitch = TAU / f64::from(plant.robot.body.legs);
        let axis = |name, unit, low, high| Axis {
            name,
            unit,
            low,
            high,
        };
        Ok(Stride {
            ready: plant.ready()?,
            reward,
            task,
            observed: vec![
                axis("wheel_rate", "rad_s", -60.0, 60.0),
                axis("lean", "rad", -TAU, TAU),
                axis("speed", "m_s", -20.0, 20.0),
                axis("pivot_angle", "rad", -1.0, 1.0),
            ],
            actions: Actions::Values(vec![
                axis("firing_angle", "rad", task.zone, task.zone + pitch),
                axis("valve_open", "s", 0.0, LONGEST),
            ]),
            plant,
        })
    }
}

impl Environment for Stride {
    fn observed(&self) -> &[Axis] {
        &self.observed
    }

    fn actions(&self) -> &Actions {
        &self.actions
    }

    fn start(&self, seed: u64) -> Result<Box<dyn Episode>, GaitError> {
        let body = self.plant.start(self.ready.as_ref(), seed)?;
        let sensors = self.plant.sensors();
        let pitch = TAU / body.legs() as f64;
        let mut episode = InStride {
            body,
            signals: Signals::new(instruments(&sensors), &TAPS),
            sensors,
            reach: self.plant.robot.boom.map_or(0.0, |boom| boom.length),
            reward: self.reward.clone(),
            task: self.task,
            pitch,
            observation: [0.0; 4],
            wheel: 0.0,
            travelled: VecDeque::new(),
            stands: 0.0,
            gas: 0.0,
            arrived: None,
            over: false,
        };
        episode.sense();
        Ok(Box::new(episode))
    }
}

struct InStride {
    body: Body,
    signals: Signals<'static, f64>,
    sensors: Sensors,
    /// Length of the boom (m).
    reach: f64,
    reward: Reward,
    task: Task,
    pitch: f64,
    observation: [f64; 4],
    /// Lean of leg 0 by the encoder (rad), counted on.
    wheel: f64,
    /// Travel by the boom's encoder (m), of the last cycles.
    travelled: VecDeque<f64>,
    /// How long it has stood (s).
    stands: f64,
    gas: f64,
    arrived: Option<f64>,
    over: bool,
}

impl InStride {
    fn sense(&mut self) {
        let readings = self.body.with(|world| world.read().readings);
        let turn = |count: i32, of: f64| TAU * f64::from(count) / of.round();
        self.wheel = turn(readings.wheel, self.sensors.wheel_counts);
        let rate = self.signals.rate(&readings);
        let travel = self.reach * turn(readings.radius, self.sensors.radius_counts);
        self.travelled.push_back(travel);
        let span = SPEED_OVER / self.sensors.period;
        while self.travelled.len() as f64 > span + 1.0 {
            self.travelled.pop_front();
        }
        let cycles = (self.travelled.len() - 1).max(1) as f64;
        let first = self.travelled.front().copied().unwrap_or(travel);
        let speed = (travel - first) / (cycles * self.sensors.period);
        let lean = self.wheel - self.passed() * self.pitch;
        let pivot = turn(readings.pivot, self.sensors.pivot_counts);
        self.observation = [rate, lean, speed, pivot];
    }

    /// How many legs have entered the zone.
    fn passed(&self) -> f64 {
        ((self.wheel - self.task.zone) / self.pitch).floor()
    }

    /// The leg in the zone.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn leg(&self) -> usize {
        let legs = self.body.legs();
        self.passed().rem_euclid(legs as f64) as usize % legs
    }
}

impl Episode for InStride {
    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let Act::Values(&[angle, opening]) = act else {
            return Err(refused(
                "action",
                f64::NAN,
                "a firing angle and a valve opening time",
            ));
        };
        let zone = self.task.zone..=self.task.zone + self.pitch;
        let allowed = format!(
            "from {:.4} to {:.4} rad, the active zone",
            zone.start(),
            zone.end()
        );
        require(zone.contains(&angle), "firing angle (rad)", angle, allowed)?;
        let allowed = format!("from 0 to {LONGEST} s");
        require(
            (0.0..=LONGEST).contains(&opening),
            "valve opening time (s)",
            opening,
            allowed,
        )?;
        require(
            !self.over,
            "steps left",
            0.0,
            "1 or more: the episode is over",
        )?;
        let (passed, leg, began) = (self.passed(), self.leg(), self.body.motion().time);
        let mut waits = opening > 0.0;
        loop {
            let fires = waits && self.observation[1] >= angle;
            waits &= !fires;
            self.body.fire(fires.then_some((leg, opening)))?;
            self.sense();
            let still = self.observation[0].abs() < STALLS.0;
            self.stands = if still {
                self.stands + self.sensors.period
            } else {
                0.0
            };
            let motion = self.body.motion();
            let [_, travel] = self.body.since_start(&motion);
            let arrived = travel >= self.task.goal;
            let late = motion.time >= self.task.seconds - 1e-9;
            let stalled = self.stands >= STALLS.1;
            if arrived || late || stalled || self.passed() != passed {
                if arrived {
                    self.arrived = Some(motion.time);
                }
                self.over = arrived || late || stalled;
                let gas = self.body.gas();
                let reward = self.reward.of(&Stepped {
                    rate: motion.rate,
                    speed: motion.axle_rates[0],
                    seconds: motion.time - began,
                    gas: gas - self.gas,
                    arrived,
                    stalled: stalled && !arrived,
                });
                self.gas = gas;
                return Ok(Step {
                    reward,
                    terminated: arrived || stalled,
                    truncated: late && !arrived && !stalled,
                });
            }
        }
    }

    fn outcome(&self) -> Outcome {
        self.body.outcome(self.arrived)
    }
}
