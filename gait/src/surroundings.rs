//! What changes during a run: slope, pushes, supply, friction.

use std::sync::OnceLock;

use saltus_robot::{Drive, GaugePressure, Robot};
use saltus_sim_check::{Mechanism, Rig, SimError, Surface};

use crate::GaitError;
use crate::error::ensure;

/// A disturbance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disturbance {
    /// When it is there.
    pub when: When,
    /// What it is.
    pub what: What,
}

/// From when to when, or from where to where, a disturbance is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// From and until a time (s).
    Time(f64, f64),
    /// From and to a travel (m) of the axle.
    Place(f64, f64),
}

/// What a disturbance does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum What {
    /// Tilts the ground with all that is bolted to it (rad), uphill positive.
    Slope(f64),
    /// Pushes the boom's end, or the axle, along the travel (N).
    Force(f64),
    /// Turns the wheel against the boom (N m), forwards positive.
    Torque(f64),
    /// Supply pressure above ambient (Pa).
    Supply(f64),
    /// Friction coefficient along the travel.
    Friction(f64),
}

/// Most disturbances of a run: any of them may be there together.
pub(crate) const MOST: usize = 10;

/// A rig in all the surroundings that it meets, each made when it is first met.
#[derive(Debug)]
pub struct Surroundings {
    /// The robot's rig, without disturbances.
    pub rig: Rig,
    robot: Robot,
    obstacles: Vec<Surface>,
    disturbances: Vec<Disturbance>,
    variants: Vec<OnceLock<Box<Mechanism>>>,
}

impl Surroundings {
    /// `robot` among `obstacles`, disturbed by `disturbances`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for disturbances that cannot be or are too many, [`GaitError::Sim`] for a
    /// robot that is no rig.
    pub fn new(
        robot: &Robot,
        obstacles: &[Surface],
        disturbances: &[Disturbance],
    ) -> Result<Surroundings, GaitError> {
        let count = disturbances.len();
        ensure! { "disturbances", count as f64, count <= MOST => format!("at most {MOST}"); }
        disturbances.iter().try_for_each(|d| d.check(robot))?;
        let mut variants = Vec::new();
        variants.resize_with(1 << count, OnceLock::new);
        Ok(Surroundings {
            rig: Rig::new(robot, obstacles)?,
            robot: robot.clone(),
            obstacles: obstacles.to_vec(),
            disturbances: disturbances.to_vec(),
            variants,
        })
    }

    /// What may disturb.
    pub(crate) fn disturbances(&self) -> &[Disturbance] {
        &self.disturbances
    }

    /// Which disturbances are there at `time` (s) and `travel` (m): a bit for each.
    pub(crate) fn present(&self, time: f64, travel: f64) -> usize {
        let is_there = |d: &Disturbance| match d.when {
            When::Time(from, until) => (from..until).contains(&time),
            When::Place(from, to) => (from..to).contains(&travel),
        };
        let bits = self.disturbances.iter().enumerate();
        bits.map(|(k, d)| usize::from(is_there(d)) << k).sum()
    }

    /// The mechanism under the disturbances `present`.
    pub(crate) fn mechanism(&self, present: usize) -> Result<&Mechanism, SimError> {
        let cell = &self.variants[present];
        if cell.get().is_none() {
            let made = self.make(present)?;
            return Ok(cell.get_or_init(|| Box::new(made)));
        }
        Ok(cell.get().map_or(&self.rig.mechanism, |made| made))
    }

    fn make(&self, present: usize) -> Result<Mechanism, SimError> {
        let mut robot = self.robot.clone();
        let there = || {
            let all = self.disturbances.iter().enumerate();
            all.filter(move |(k, _)| present >> k & 1 == 1)
                .map(|(_, d)| d.what)
        };
        for what in there() {
            match what {
                What::Slope(angle) => robot.ground.tilt += angle,
                What::Supply(pressure) => {
                    if let Drive::Pneumatic(cylinder) = &mut robot.leg.drive {
                        cylinder.supply = GaugePressure(pressure);
                    }
                }
                What::Friction(coefficient) => {
                    robot.ground.static_friction = coefficient;
                    robot.ground.kinetic_friction = robot.ground.kinetic_friction.min(coefficient);
                }
                What::Force(_) | What::Torque(_) => {}
            }
        }
        let rig = Rig::new(&robot, &self.obstacles)?;
        let mut mechanism = rig.mechanism.clone();
        let mut forces = vec![0.0; mechanism.tree.velocities()];
        for what in there() {
            match what {
                What::Force(force) => forces[0] += force * rig.boom.unwrap_or(1.0),
                What::Torque(torque) => forces[rig.lean_velocity()] += torque,
                _ => {}
            }
        }
        if forces.iter().any(|force| *force != 0.0) {
            mechanism.forces = forces;
        }
        Ok(mechanism)
    }
}

impl Disturbance {
    fn check(&self, robot: &Robot) -> Result<(), GaitError> {
        let (from, until) = match self.when {
            When::Time(from, until) | When::Place(from, until) => (from, until),
        };
        ensure! {
            "end of a disturbance", until, from < until && !from.is_nan()
                => format!("a number above its begin, {from}");
        }
        match self.what {
            What::Slope(angle) => {
                let total = robot.ground.tilt + angle;
                ensure! { "slope (rad)", angle, total.abs() < 0.7 => "between -0.7 and 0.7"; }
            }
            What::Force(force) => {
                ensure! { "force on the boom (N)", force, force.abs() < 1e4 => "below 10000 N"; }
            }
            What::Torque(torque) => ensure! {
                "torque on the wheel (N m)", torque, torque.abs() < 1e4 => "below 10000 N m";
            },
            What::Supply(pressure) => ensure! {
                "supply pressure (Pa)", pressure, robot.leg.cylinder().is_some()
                    => "that of a pneumatic leg";
                "supply pressure above ambient (Pa)", pressure, (0.0..=1e8).contains(&pressure)
                    => "from 0 to 1e8 Pa";
            },
            What::Friction(friction) => {
                ensure! { "friction coefficient", friction, friction >= 0.0 => "a number ≥ 0"; }
            }
        }
        Ok(())
    }
}
