//! Valves at 1 kHz: the simulated experiments of the thesis.
//!
//! Source: thesis 6.2.1 and 6.3.1.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::error::require;
use crate::senses::{LONG_AGO, SEEN};
use crate::surroundings::Surroundings;
use crate::world::Motion;
use crate::{Command, GaitError};

use super::plant::{Body, End, Ledger, Plant};
use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};
use super::reward::Reward;

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
        let names = (0..plant.robot.body.legs).map(|leg| format!("leg {leg}"));
        Ok(Legs {
            ready: plant.ready()?,
            reward,
            steps,
            observed: vec![
                Axis::new("wheel_angle", "rad", -PI, PI),
                Axis::new("wheel_rate", "rad_s", -60.0, 60.0),
                Axis::new("pivot_angle", "rad", -PI, PI),
                Axis::new("pivot_rate", "rad_s", -60.0, 60.0),
                Axis::new("extension", "m", 0.0, 1.0),
                Axis::new("pressure", "Pa", 0.0, 1e8),
                Axis::new("since_fired", "s", 0.0, LONG_AGO),
                Axis::new("time", "s", 0.0, 1e4),
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
        let first = self.plant.obstacles.first();
        let pitch_half = PI / f64::from(self.plant.robot.body.legs);
        let stands = self.plant.robot.body.radius * pitch_half.cos();
        Ok(Box::new(OnLegs {
            observation: body.truth(),
            body,
            ledger: Ledger::new(self.reward.clone()),
            period: self.plant.sensors().period,
            left: self.steps,
            top: first.map(|o| [o.front, o.front + o.length, o.height + stands]),
        }))
    }
}

struct OnLegs {
    body: Body,
    ledger: Ledger,
    period: f64,
    observation: [f64; SEEN],
    left: usize,
    /// Where the box begins and ends, and the height of the axle of a robot that stands on two legs there.
    top: Option<[f64; 3]>,
}

impl Episode for OnLegs {
    fn observation(&self) -> &[f64] {
        &self.observation
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let choice = act.choice(1 + self.body.legs())?;
        self.ledger.require_open()?;
        self.body.go_on(Command::Hold(choice.checked_sub(1)))?;
        self.left -= 1;
        let motion = self.body.motion();
        self.observation = self.body.truth();
        let end = if self.is_on_the_box(&motion) {
            End::Arrived
        } else if self.left == 0 {
            End::Late
        } else {
            End::Open
        };
        let step = (motion.rate, self.period);
        Ok(self.ledger.close(&self.body, step, end))
    }

    fn outcome(&self) -> Outcome {
        self.body.outcome(self.ledger.arrived())
    }
}

impl OnLegs {
    /// Whether a foot is on the box, and the axle over it, as high as on two legs.
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
