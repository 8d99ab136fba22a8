//! The robot that learns, in its surroundings, and an episode's motion of it.

use std::sync::Arc;

use rand_pcg::Pcg64;
use saltus_robot::{Robot, Sensors};
use saltus_sim_check::{Rig, SimError, Stepping, Surface};
use self_cell::self_cell;

use crate::error::require;
use crate::run::Obstacle;
use crate::senses::{SEEN, truth};
use crate::surroundings::{Disturbance, Surroundings};
use crate::world::Motion;
use crate::{Command, Draw, GaitError, World, drawn_robot};

use super::process::{Outcome, Step};
use super::reward::{Reward, Stepped};

/// Rate (rad/s) below which a robot counts as standing when its time is over.
const STANDS: f64 = 0.5;

/// Which robot learns, and where.
#[derive(Clone, Debug)]
pub struct Plant {
    /// The robot.
    pub robot: Robot,
    /// How each episode's robot is drawn around it; none: it is the robot itself.
    pub draw: Option<Draw>,
    /// What disturbs.
    pub disturbances: Vec<Disturbance>,
    /// Boxes on the ground.
    pub obstacles: Vec<Obstacle>,
    /// The leg behind the two on which it starts; none: drawn for each episode.
    pub rear: Option<usize>,
}

impl Plant {
    /// `robot` alone on level ground, on its first two legs.
    pub fn new(robot: Robot) -> Plant {
        Plant {
            robot,
            draw: None,
            disturbances: Vec::new(),
            obstacles: Vec::new(),
            rear: Some(0),
        }
    }

    pub(super) fn sensors(&self) -> Sensors {
        self.robot.sensors.unwrap_or_default()
    }

    fn surroundings(&self, robot: &Robot) -> Result<Surroundings, GaitError> {
        let plain = Rig::new(robot, &[])?;
        let across = |o: &Obstacle| plain.box_across(o.front, o.length, o.height);
        self.obstacles
            .iter()
            .try_for_each(|o| o.check(robot.body.radius))?;
        let boxes: Vec<Surface> = self.obstacles.iter().map(across).collect();
        Surroundings::new(robot, &boxes, &self.disturbances)
    }

    /// What every episode has in common, where no robot is drawn.
    pub(super) fn ready(&self) -> Result<Option<Arc<Surroundings>>, GaitError> {
        match self.draw {
            Some(_) => Ok(None),
            None => Ok(Some(Arc::new(self.surroundings(&self.robot)?))),
        }
    }

    /// The robot at rest, at the begin of the episode of `seed`.
    pub(super) fn start(
        &self,
        ready: Option<&Arc<Surroundings>>,
        seed: u64,
    ) -> Result<Body, GaitError> {
        let surroundings = match (ready, &self.draw) {
            (Some(ready), _) => Arc::clone(ready),
            (None, Some(draw)) => {
                let robot = drawn_robot(&self.robot, draw, seed, 0)?;
                Arc::new(self.surroundings(&robot)?)
            }
            (None, None) => Arc::new(self.surroundings(&self.robot)?),
        };
        let legs = self.robot.body.legs as usize;
        let mut random = Pcg64::new(u128::from(seed), 0x1ea7);
        let rear = match self.rear {
            Some(rear) => rear % legs,
            None => super::tabular::below(legs, &mut random),
        };
        Body::new(surroundings, self.sensors(), rear, random)
    }
}

self_cell!(
    /// A world and what it is in.
    struct Held {
        owner: Arc<Surroundings>,
        #[covariant]
        dependent: World,
    }
);

/// A robot in motion.
pub(super) struct Body {
    held: Held,
    legs: usize,
    /// Lean and travel at the start.
    start: [f64; 2],
    /// The leg whose valve is commanded to be open.
    open: Option<usize>,
    firings: usize,
    /// When each leg was last fired (s).
    fired: Vec<f64>,
    /// Whether its contacts have no solution.
    broken: bool,
}

impl Body {
    fn new(
        surroundings: Arc<Surroundings>,
        sensors: Sensors,
        rear: usize,
        random: Pcg64,
    ) -> Result<Body, GaitError> {
        let q = surroundings.rig.rest(rear)?;
        let v = vec![0.0; surroundings.rig.mechanism.tree.velocities()];
        let legs = surroundings.rig.mechanism.legs.len();
        let held = Held::try_new(surroundings, |surroundings| {
            World::new(surroundings, sensors, Stepping::USUAL, (&q, &v), random)
        })?;
        let mut body = Body {
            held,
            legs,
            start: [0.0; 2],
            open: None,
            firings: 0,
            fired: vec![f64::NEG_INFINITY; legs],
            broken: false,
        };
        let motion = body.motion();
        body.start = [motion.lean, motion.axle[0]];
        Ok(body)
    }

    pub(super) fn legs(&self) -> usize {
        self.legs
    }

    pub(super) fn motion(&self) -> Motion {
        self.held.borrow_dependent().motion()
    }

    /// Goes on by a cycle of the sensors, at whose begin the valves are commanded.
    pub(super) fn go_on(&mut self, command: Command) -> Result<(), GaitError> {
        match command {
            Command::Nothing => {}
            Command::Fire(leg, _) => self.note(Some(leg)),
            Command::Hold(leg) => {
                if std::mem::replace(&mut self.open, leg) != leg {
                    self.note(leg);
                }
            }
        }
        let gone = self.held.with_dependent_mut(|_, world| {
            world.command(command)?;
            world.go_on(|_| ())
        });
        match gone {
            // What a learner tries may be a motion without a solution: then its episode ends there.
            Err(GaitError::Sim(
                SimError::Inconsistent { .. }
                | SimError::TooManyEvents { .. }
                | SimError::Diverged { .. },
            )) => self.broken = true,
            other => other?,
        }
        Ok(())
    }

    fn note(&mut self, fired: Option<usize>) {
        if let Some(leg) = fired {
            self.firings += 1;
            self.fired[leg] = self.held.borrow_dependent().looked_at().time();
        }
    }

    /// What no sensor says.
    pub(super) fn truth(&self) -> [f64; SEEN] {
        truth(self.held.borrow_dependent(), &self.fired)
    }

    /// Whether its motion cannot go on.
    pub(super) fn is_broken(&self) -> bool {
        self.broken
    }

    /// Does something with the world.
    pub(super) fn with<T>(&mut self, act: impl FnOnce(&mut World<'_>) -> T) -> T {
        self.held.with_dependent_mut(|_, world| act(world))
    }

    /// Gas from the supply so far (kg).
    pub(super) fn gas(&self) -> f64 {
        let sim = self.held.borrow_dependent().looked_at();
        (0..self.legs).map(|leg| sim.account(leg).supplied).sum()
    }

    /// Angle (rad) and travel (m) since the start.
    pub(super) fn since_start(&self, motion: &Motion) -> [f64; 2] {
        [motion.lean - self.start[0], motion.axle[0] - self.start[1]]
    }

    pub(super) fn outcome(&self, arrived: Option<f64>) -> Outcome {
        let motion = self.motion();
        let [angle, travel] = self.since_start(&motion);
        Outcome {
            time: motion.time,
            angle,
            travel,
            arrived,
            gas: self.gas(),
            firings: self.firings,
            broken: self.broken,
        }
    }
}

/// How a step ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum End {
    /// The episode goes on.
    Open,
    /// At the goal.
    Arrived,
    /// Where the robot stands.
    Stalled,
    /// The time is over.
    Late,
}

/// What an episode has come to, and what its steps are worth.
pub(super) struct Ledger {
    reward: Reward,
    gas: f64,
    travel: f64,
    arrived: Option<f64>,
    over: bool,
}

impl Ledger {
    pub(super) fn new(reward: Reward) -> Ledger {
        Ledger {
            reward,
            gas: 0.0,
            travel: 0.0,
            arrived: None,
            over: false,
        }
    }

    /// When the goal was reached (s).
    pub(super) fn arrived(&self) -> Option<f64> {
        self.arrived
    }

    /// An error after the end of the episode.
    pub(super) fn require_open(&self) -> Result<(), GaitError> {
        let allowed = "1 or more: the episode is over";
        require(!self.over, "steps left", 0.0, allowed)
    }

    /// Closes a step of so many `seconds`; `rate` is that of the wheel (rad/s) as it is rewarded.
    pub(super) fn close(&mut self, body: &Body, (rate, seconds): (f64, f64), end: End) -> Step {
        let motion = body.motion();
        let [_, travel] = body.since_start(&motion);
        let gas = if self.reward.needs_gas() {
            body.gas()
        } else {
            0.0
        };
        self.over = end != End::Open || body.is_broken();
        if end == End::Arrived {
            self.arrived = Some(motion.time);
        }
        let ends_standing = end == End::Late && motion.rate.abs() < STANDS;
        let reward = self.reward.of(&Stepped {
            rate,
            speed: motion.axle_rates[0],
            way: travel - self.travel,
            seconds,
            gas: gas - self.gas,
            arrived: end == End::Arrived,
            stalled: end == End::Stalled || ends_standing,
        });
        (self.gas, self.travel) = (gas, travel);
        let terminated = matches!(end, End::Arrived | End::Stalled);
        Step {
            reward,
            terminated,
            truncated: self.over && !terminated,
        }
    }
}
