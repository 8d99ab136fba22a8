//! One decision at 200 Hz: whether the leg in the active zone fires. The stand-in for the thesis' robot.
//!
//! Source: thesis 6.3.2.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::error::require;
use crate::senses::Senses;
use crate::surroundings::Surroundings;
use crate::{Command, GaitError};

use super::plant::{Body, End, Ledger, Plant};
use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
use super::reward::Reward;

/// What the robot measures is what the learner sees: the wheel's encoder and the filtered gyro.
pub struct Zone {
    plant: Plant,
    ready: Option<Arc<Surroundings>>,
    reward: Reward,
    task: Task,
    observed: Vec<Axis>,
    actions: Actions,
}

/// What of a [`Zone`] may differ from the thesis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Task {
    /// Time between two decisions (s).
    pub period: f64,
    /// Most time (s).
    pub seconds: f64,
    /// Travel (m) that is the goal.
    pub goal: f64,
    /// Where the active zone begins (rad).
    pub zone: f64,
}

impl Task {
    pub(super) fn check(&self) -> Result<(), GaitError> {
        let named = [
            ("time between two decisions (s)", self.period),
            ("time of an episode (s)", self.seconds),
            ("goal (m)", self.goal),
        ];
        named.into_iter().try_for_each(|(name, value)| {
            let sound = value > 0.0 && value <= 1e3;
            require(sound, name, value, "above 0, at most 1000")
        })
    }
}

impl Default for Task {
    fn default() -> Task {
        Task {
            period: 0.005,
            seconds: 1.8,
            goal: 1.6,
            zone: -0.3,
        }
    }
}

impl Zone {
    /// `plant`, rewarded by `reward`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run, and for times that are not above 0.
    pub fn new(plant: Plant, reward: Reward, task: Task) -> Result<Zone, GaitError> {
        task.check()?;
        Ok(Zone {
            ready: plant.ready()?,
            reward,
            task,
            observed: vec![
                Axis::new("wheel_angle", "rad", -PI, PI),
                Axis::new("wheel_rate", "rad_s", -60.0, 60.0),
            ],
            actions: Actions::Choices(vec!["none".into(), "the leg in the active zone".into()]),
            plant,
        })
    }
}

/// The whole number nearest to `x`, from 1.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn count(x: f64) -> usize {
    (x.round() as usize).max(1)
}

impl Environment for Zone {
    fn observed(&self) -> &[Axis] {
        &self.observed
    }

    fn actions(&self) -> &Actions {
        &self.actions
    }

    fn start(&self, seed: u64) -> Result<Box<dyn Episode>, GaitError> {
        let body = self.plant.start(self.ready.as_ref(), seed)?;
        let period = self.plant.sensors().period;
        let mut episode = InZone {
            body,
            senses: Senses::new(&self.plant.robot, self.task.zone),
            ledger: Ledger::new(self.reward.clone()),
            observation: [0.0; 2],
            period,
            cycles: count(self.task.period / period),
            left: count(self.task.seconds / self.task.period),
            goal: self.task.goal,
        };
        episode.sense();
        Ok(Box::new(episode))
    }
}

struct InZone {
    body: Body,
    senses: Senses,
    ledger: Ledger,
    observation: [f64; 2],
    period: f64,
    cycles: usize,
    left: usize,
    goal: f64,
}

impl InZone {
    fn sense(&mut self) {
        let readings = self.body.with(|world| world.read().readings);
        self.senses.take(&readings);
        self.observation = self.senses.in_zone();
    }
}

impl Episode for InZone {
    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let fires = act.choice(2)? == 1;
        self.ledger.require_open()?;
        let leg = fires.then(|| self.senses.leg());
        for _ in 0..self.cycles {
            self.body.go_on(Command::Hold(leg))?;
            if self.body.is_broken() {
                break;
            }
            self.sense();
        }
        self.left -= 1;
        let [_, travel] = self.body.since_start(&self.body.motion());
        let end = if travel >= self.goal {
            End::Arrived
        } else if self.left == 0 {
            End::Late
        } else {
            End::Open
        };
        let seconds = self.cycles as f64 * self.period;
        let step = (self.observation[1], seconds);
        Ok(self.ledger.close(&self.body, step, end))
    }

    fn outcome(&self) -> Outcome {
        self.body.outcome(self.ledger.arrived())
    }
}
