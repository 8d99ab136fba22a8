//! One decision a stride: at which lean the next leg fires, and for how long.
//!
//! Source: thesis 8.3.2, which recommends to learn firing angles in place of legs.

use std::f64::consts::TAU;
use std::sync::Arc;

use crate::GaitError;
use crate::error::{ensure, refused};
use crate::senses::Senses;
use crate::surroundings::Surroundings;

use super::plant::{Body, End, Ledger, Plant};
use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
use super::reward::Reward;
use super::zone::Task;

/// Rate (rad/s) below which, and time (s) after which a robot has stalled.
const STALLS: (f64, f64) = (0.5, 0.4);
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
        ensure! { "steps of an episode", strides as f64, strides > 0 => "1 or more"; }
        let pitch = TAU / f64::from(plant.robot.body.legs);
        let mut observed = vec![
            Axis::new("wheel_rate", "rad_s", -60.0, 60.0),
            Axis::new("lean", "rad", task.zone, task.zone + pitch),
            Axis::new("speed", "m_s", -20.0, 20.0),
            Axis::new("pivot_angle", "rad", -1.0, 1.0),
        ];
        if !plant.obstacles.is_empty() {
            observed.push(Axis::new("box_distance", "m", -1e3, 1e3));
        }
        Ok(Stride {
            ready: plant.ready()?,
            reward,
            task,
            strides,
            observed,
            actions: Actions::Values(vec![
                Axis::new("firing_angle", "rad", task.zone, task.zone + pitch),
                Axis::new("valve_open", "s", 0.0, LONGEST),
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
        let mut episode = InStride {
            senses: Senses::new(&self.plant.robot, self.task.zone),
            period: self.plant.sensors().period,
            pitch: TAU / body.legs() as f64,
            body,
            ledger: Ledger::new(self.reward.clone()),
            task: self.task,
            left: self.strides,
            front: self.plant.obstacles.first().map(|o| o.front),
            observation: Vec::new(),
            stands: 0.0,
        };
        episode.sense();
        Ok(Box::new(episode))
    }
}

struct InStride {
    body: Body,
    senses: Senses,
    period: f64,
    pitch: f64,
    ledger: Ledger,
    task: Task,
    /// Strides left.
    left: usize,
    /// Where the box begins (m).
    front: Option<f64>,
    observation: Vec<f64>,
    /// How long it has stood (s).
    stands: f64,
}

impl InStride {
    fn sense(&mut self) {
        let readings = self.body.with(|world| world.read().readings);
        self.senses.take(&readings);
        self.senses.in_stride(self.front, &mut self.observation);
    }

    /// The firing angle (rad) and the valve opening time (s) of an action.
    fn asked(&self, act: Act<'_>) -> Result<(f64, f64), GaitError> {
        let Act::Values(&[angle, opening]) = act else {
            let wanted = "a firing angle and a valve opening time";
            return Err(refused("action", f64::NAN, wanted));
        };
        let [from, to] = [self.task.zone, self.task.zone + self.pitch];
        ensure! {
            "firing angle (rad)", angle, (from..=to).contains(&angle)
                => format!("from {from:.4} to {to:.4} rad, the active zone");
            "valve opening time (s)", opening, (0.0..=LONGEST).contains(&opening)
                => format!("from 0 to {LONGEST} s");
        }
        Ok((angle, opening))
    }

    /// Reads the sensors after a cycle, and says whether the episode is over.
    fn goes_on(&mut self) -> End {
        self.sense();
        let still = self.senses.rate().abs() < STALLS.0;
        self.stands = if still {
            self.stands + self.period
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
}

impl Episode for InStride {
    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let (angle, opening) = self.asked(act)?;
        self.ledger.require_open()?;
        let (passed, leg) = (self.senses.passed(), self.senses.leg());
        let began = self.body.motion().time;
        let mut waits = opening > 0.0;
        loop {
            let fires = waits && self.senses.lean() >= angle;
            waits &= !fires;
            self.body.go_on(fires.then_some((leg, opening)).into())?;
            let end = self.goes_on();
            let entered = self.senses.passed() != passed;
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
