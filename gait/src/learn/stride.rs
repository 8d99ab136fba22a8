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

use super::plant::{Body, End, Ledger, Plant};
use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
use super::reward::Reward;
use super::zone::{TAPS, Task};

/// Rate (rad/s) below which, and time (s) after which a robot has stalled.
const STALLS: (f64, f64) = (0.5, 0.4);
/// Time (s) over which the encoder of the boom gives a speed.
const SPEED_OVER: f64 = 0.02;
/// Longest opening of the valve (s).
const LONGEST: f64 = 0.1;

/// Each time another leg enters the active zone the learner says at which lean it fires, and how long its valve is
/// open. The robot observes by its encoders and its filtered gyro; of a box on its way it knows where it is.
pub struct Stride {
    plant: Plant,
    ready: Option<Arc<Surroundings>>,
    reward: Reward,
    task: Task,
    strides: usize,
    observed: Vec<Axis>,
    actions: Actions,
}

impl Stride {
    /// `plant`, rewarded by `reward`, for so many `strides` at most.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run, for times that are not above 0, and for no strides.
    pub fn new(
        plant: Plant,
        reward: Reward,
        task: Task,
        strides: usize,
    ) -> Result<Stride, GaitError> {
        task.check()?;
        let count = strides as f64;
        require(strides > 0, "steps of an episode", count, "1 or more")?;
        let pitch = TAU / f64::from(plant.robot.body.legs);
        let axis = |name, unit, low, high| Axis {
            name,
            unit,
            low,
            high,
        };
        let mut observed = vec![
            axis("wheel_rate", "rad_s", -60.0, 60.0),
            axis("lean", "rad", task.zone, task.zone + pitch),
            axis("speed", "m_s", -20.0, 20.0),
            axis("pivot_angle", "rad", -1.0, 1.0),
        ];
        if !plant.obstacles.is_empty() {
            observed.push(axis("box_distance", "m", -1e3, 1e3));
        }
        Ok(Stride {
            ready: plant.ready()?,
            reward,
            task,
            strides,
            observed,
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
            ledger: Ledger::new(self.reward.clone()),
            task: self.task,
            pitch,
            left: self.strides,
            front: self.plant.obstacles.first().map(|o| o.front),
            observation: Vec::new(),
            wheel: 0.0,
            travelled: VecDeque::new(),
            stands: 0.0,
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
    ledger: Ledger,
    task: Task,
    pitch: f64,
    /// Strides left.
    left: usize,
    /// Where the box begins (m).
    front: Option<f64>,
    observation: Vec<f64>,
    /// Lean of leg 0 by the encoder (rad), counted on.
    wheel: f64,
    /// Travel by the boom's encoder (m), of the last cycles.
    travelled: VecDeque<f64>,
    /// How long it has stood (s).
    stands: f64,
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
        self.observation.clear();
        self.observation.extend([rate, lean, speed, pivot]);
        self.observation
            .extend(self.front.map(|front| front - travel));
    }

    /// The firing angle (rad) and the valve opening time (s) of an action.
    fn asked(&self, act: Act<'_>) -> Result<(f64, f64), GaitError> {
        let Act::Values(&[angle, opening]) = act else {
            let wanted = "a firing angle and a valve opening time";
            return Err(refused("action", f64::NAN, wanted));
        };
        let [from, to] = [self.task.zone, self.task.zone + self.pitch];
        let allowed = format!("from {from:.4} to {to:.4} rad, the active zone");
        let inside = (from..=to).contains(&angle);
        require(inside, "firing angle (rad)", angle, allowed)?;
        let allowed = format!("from 0 to {LONGEST} s");
        let sound = (0.0..=LONGEST).contains(&opening);
        require(sound, "valve opening time (s)", opening, allowed)?;
        Ok((angle, opening))
    }

    /// Reads the sensors after a cycle, and says whether the episode is over.
    fn goes_on(&mut self) -> End {
        self.sense();
        let still = self.observation[0].abs() < STALLS.0;
        self.stands = if still {
            self.stands + self.sensors.period
        } else {
            0.0
        };
        let motion = self.body.motion();
        let [_, travel] = self.body.since_start(&motion);
        if travel >= self.task.goal {
            End::Arrived
        } else if self.stands >= STALLS.1 {
            End::Stalled
        } else if motion.time >= self.task.seconds - 1e-9 {
            End::Late
        } else {
            End::Open
        }
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
        let (angle, opening) = self.asked(act)?;
        self.ledger.require_open()?;
        let (passed, leg, began) = (self.passed(), self.leg(), self.body.motion().time);
        let mut waits = opening > 0.0;
        loop {
            let fires = waits && self.observation[1] >= angle;
            waits &= !fires;
            self.body.go_on(fires.then_some((leg, opening)))?;
            let end = self.goes_on();
            let entered = self.passed() != passed;
            if end != End::Open || self.body.is_broken() || entered {
                self.left -= 1;
                let end = match end {
                    End::Open if self.left == 0 => End::Late,
                    end => end,
                };
                let motion = self.body.motion();
                let step = (motion.rate, motion.time - began);
                return Ok(self.ledger.close(&self.body, step, end));
            }
        }
    }

    fn outcome(&self) -> Outcome {
        self.body.outcome(self.ledger.arrived())
    }
}
