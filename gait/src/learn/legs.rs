//! Valves at 1 kHz: the simulated experiments of the thesis.
//!
//! Source: thesis 6.2.1 and 6.3.1.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::GaitError;
use crate::error::require;
use crate::surroundings::Surroundings;

use super::plant::{Body, Motion, Plant, wrapped};
use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
use super::reward::{Reward, Stepped};

/// Rate (rad/s) below which a robot counts as standing when its time is over.
const STANDS: f64 = 0.5;

/// Each cycle of the sensors one valve is open, or none. From rest, for so many steps; with boxes on the
/// way the episode ends on the first of them.
pub struct Legs {
    plant: Plant,
    ready: Option<Arc<Surroundings>>,
    reward: Reward,
    steps: usize,
    observed: Vec<Axis>,
    actions: Actions,
}

impl Legs {
    /// `plant`, rewarded by `reward`, for so many `steps`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run, and for no steps.
    pub fn new(plant: Plant, reward: Reward, steps: usize) -> Result<Legs, GaitError> {
        require(steps > 0, "steps of an episode", steps as f64, "1 or more")?;
        let axis = |name, unit, low, high| Axis {
            name,
            unit,
            low,
            high,
        };
        let names = (0..plant.robot.body.legs).map(|leg| format!("leg {leg}"));
        Ok(Legs {
            ready: plant.ready()?,
            reward,
            steps,
            observed: vec![
                axis("wheel_angle", "rad", -PI, PI),
                axis("wheel_rate", "rad_s", -60.0, 60.0),
                axis("pivot_angle", "rad", -PI, PI),
                axis("pivot_rate", "rad_s", -60.0, 60.0),
            ],
            actions: Actions::Choices(std::iter::once("none".into()).chain(names).collect()),
            plant,
        })
    }
}

impl Environment for Legs {
    fn observed(&self) -> &[Axis] {
        &self.observed
    }

    fn actions(&self) -> &Actions {
        &self.actions
    }

    fn start(&self, seed: u64) -> Result<Box<dyn Episode>, GaitError> {
        let body = self.plant.start(self.ready.as_ref(), seed)?;
        let motion = body.motion();
        let first = self.plant.obstacles.first();
        Ok(Box::new(OnLegs {
            observation: seen(&motion),
            body,
            reward: self.reward.clone(),
            period: self.plant.sensors().period,
            left: self.steps,
            gas: 0.0,
            arrived: None,
            top: first.map(|o| [o.front, o.front + o.length, o.height]),
        }))
    }
}

struct OnLegs {
    body: Body,
    reward: Reward,
    period: f64,
    observation: [f64; 4],
    left: usize,
    gas: f64,
    arrived: Option<f64>,
    /// Where the box begins and ends, and how high it is.
    top: Option<[f64; 3]>,
}

fn seen(motion: &Motion) -> [f64; 4] {
    let [angle, rate] = motion.pivot;
    [wrapped(motion.lean), motion.rate, angle, rate]
}

impl Episode for OnLegs {
    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let choice = act.choice(1 + self.body.legs())?;
        require(
            self.left > 0,
            "steps left",
            0.0,
            "1 or more: the episode is over",
        )?;
        self.body.open(choice.checked_sub(1))?;
        self.body.go_on()?;
        self.left -= 1;
        let motion = self.body.motion();
        self.observation = seen(&motion);
        let gas = if self.reward.needs_gas() {
            self.body.gas()
        } else {
            0.0
        };
        let arrived = self.is_on_the_box(&motion);
        if arrived {
            self.arrived = Some(motion.time);
            self.left = 0;
        }
        let over = self.left == 0;
        let reward = self.reward.of(&Stepped {
            rate: motion.rate,
            speed: motion.axle_rates[0],
            seconds: self.period,
            gas: gas - self.gas,
            arrived,
            stalled: over && !arrived && motion.rate.abs() < STANDS,
        });
        self.gas = gas;
        Ok(Step {
            reward,
            terminated: arrived,
            truncated: over && !arrived,
        })
    }

    fn outcome(&self) -> Outcome {
        self.body.outcome(self.arrived)
    }
}

impl OnLegs {
    /// Whether a foot stands on the box, and the axle is over it.
    fn is_on_the_box(&mut self, motion: &Motion) -> bool {
        let [travel, up] = motion.axle;
        let over = |[front, back, height]: [f64; 3]| (front..back).contains(&travel) && up > height;
        self.top.is_some_and(over)
            && self.body.with(|world| {
                let contacts = world.sim().contacts();
                contacts.iter().any(|contact| contact.surface > 0)
            })
    }
}
