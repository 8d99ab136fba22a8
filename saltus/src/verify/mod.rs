//! Verification: planned jumps in the multi-body simulation, with foot slip, a boom, and everything
//! else that the plan leaves out.
//!
//! ```
//! use saltus::verify::{Plant, Task};
//! use saltus::{Launch, Planner, Robot};
//!
//! let launch = Launch::at_firing(5.0, -0.1, 0.1);
//! let planned = Planner::new(Robot::rats_planar()).jump(&launch)?;
//! let plant = Plant::new(saltus::resolve("rats-boom", &[])?, 1e-8);
//! let flown = plant.fly(&Task { launch, landing_height: 0.0, obstacles: Vec::new(), leg_out: 0.0 })?;
//! // What the boom costs.
//! let error = flown.landing.unwrap_or(f64::NAN) - planned.distance(0.0).unwrap_or(f64::NAN);
//! assert!(error.abs() > 0.02 && error.abs() < 0.10, "{error}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A plan of several jumps is a [`Route`]: [`Plant::run`] flies it, each jump from where the one
//! before landed, and judges every jump by every [`Demand`] of its course.

use saltus_lagrangian::Launch;
use saltus_robot::{Drive, Errors, Robot};
use saltus_sim_check::{End, Report, Rig, SimError};

mod demand;
mod path;
mod route;
mod subject;
mod trial;
mod verdict;

use path::Path;

pub use demand::{Demand, Demands, Judgement, ROUND_OFF};
pub use path::Clearance;
pub use route::{Attempt, Flight, Route, Stage, Starts};
pub use subject::{Rule, Steering, Subject};
pub use trial::{Outcome, RunJump, Trial, TrialError, Verification};
pub use verdict::{Failure, Group, Spread, Verdict};

/// A robot to verify on.
#[derive(Clone, Debug)]
pub struct Plant {
    robot: Robot,
    tolerance: f64,
}

/// A jump to be verified.
#[derive(Clone, Debug, PartialEq)]
pub struct Task {
    /// How it starts, and what it is commanded.
    pub launch: Launch,
    /// Height (m) of the axle above the foothold at which it lands.
    pub landing_height: f64,
    /// Boxes in the way: front, back and top (m from the foothold).
    pub obstacles: Vec<[f64; 3]>,
    /// Time (s) after lift-off during which the fired leg is still out and has to stay clear too.
    pub leg_out: f64,
}

/// By how much the robot differs from the one that was planned for, and its start from what was
/// measured.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Disturbance {
    /// Added to the approach rate (rad/s).
    pub rate: f64,
    /// Added to the firing angle (rad).
    pub firing_angle: f64,
    /// Added to the valve opening time (s); the sum is 0 at least.
    pub valve_open: f64,
    /// Added to the supply pressure (Pa) of a pneumatic leg; the sum is that of the surroundings at
    /// least.
    pub supply: f64,
}

/// How a jump went.
#[derive(Clone, Debug)]
pub struct Flown {
    /// Greatest height (m) of the axle above the foothold; none where it did not take off.
    pub apex: Option<f64>,
    /// Travel (m) from the foothold to the landing; none where it does not get there.
    pub landing: Option<f64>,
    /// Least distances (m) between the wheel and each obstacle.
    pub clearances: Vec<Clearance>,
    /// Everything else.
    pub report: Report,
}

impl Flown {
    /// How it ended, in a word.
    pub fn outcome(&self) -> &'static str {
        match self.report.end {
            End::Landed => "landed",
            End::NoLiftOff => "no-lift-off",
            End::Stalled => "stalled",
            End::EarlyLiftOff => "early-lift-off",
        }
    }

    /// Net way (m) that the foot slipped along the travel until lift-off, forward positive; 0 if it
    /// never slipped.
    pub fn slip(&self) -> f64 {
        self.report.slips_at.map_or(0.0, |_| self.report.slipped[0])
    }
}

impl Disturbance {
    /// The one that comes of `normal`, four independent standard normal numbers, for `errors`.
    pub fn drawn(errors: &Errors, normal: [f64; 4]) -> Disturbance {
        Disturbance {
            rate: errors.rate * normal[0],
            firing_angle: errors.firing_angle * normal[1],
            valve_open: errors.valve_open * normal[2],
            supply: errors.supply * normal[3],
        }
    }
}

impl Plant {
    /// `robot` as bodies in space, integrated with an error `tolerance` for each step.
    pub fn new(robot: Robot, tolerance: f64) -> Plant {
        Plant { robot, tolerance }
    }

    /// The robot.
    pub fn robot(&self) -> &Robot {
        &self.robot
    }

    /// The rig that jumps.
    ///
    /// # Errors
    /// [`SimError`] for a robot whose parts cannot be bodies.
    pub fn rig(&self) -> Result<Rig, SimError> {
        Rig::new(&self.robot, &[])
    }

    /// On ground of this coefficient of friction along the travel, standing and slipping.
    pub fn on_friction(&self, coefficient: f64) -> Plant {
        let mut plant = self.clone();
        plant.robot.ground.static_friction = coefficient;
        plant.robot.ground.kinetic_friction = coefficient;
        plant
    }

    /// With its supply pressure changed as `disturbance` says, and `task` as it then really is.
    pub fn disturbed(&self, task: &Task, disturbance: &Disturbance) -> (Plant, Task) {
        let (mut plant, mut task) = (self.clone(), task.clone());
        if let Drive::Pneumatic(cylinder) = &mut plant.robot.leg.drive {
            cylinder.supply.0 = (cylinder.supply.0 + disturbance.supply).max(0.0);
        }
        let launch = &mut task.launch;
        // A stance that starts at its firing angle keeps doing so.
        if launch.lean == launch.firing_angle {
            launch.lean += disturbance.firing_angle;
        }
        launch.firing_angle += disturbance.firing_angle;
        launch.rate = (launch.rate + disturbance.rate).max(0.0);
        launch.valve_open = (launch.valve_open + disturbance.valve_open).max(0.0);
        (plant, task)
    }

    /// Simulates a jump.
    ///
    /// # Errors
    /// [`SimError`] for a robot, a start or a command that cannot be, or a motion that cannot go
    /// on.
    pub fn fly(&self, task: &Task) -> Result<Flown, SimError> {
        use saltus_sim_check::{Plan, Settings};
        let settings = Settings {
            tolerance: self.tolerance,
            ..Settings::default()
        };
        let plan = Plan {
            settings,
            landing_height: task.landing_height,
            ..Plan::default()
        };
        let report = self.rig()?.jump(&task.launch, &plan)?;
        let number = |x: f64| x.is_finite().then_some(x);
        let landing = number(report.landing_at);
        let height = landing.map(|_| task.landing_height);
        let path = Path::new(&report, self.robot.body.radius, height, task.leg_out);
        let unknown = Clearance {
            stance: f64::NAN,
            flight: None,
        };
        let clearance = |solid| path.as_ref()?.clearance(solid);
        let clearances = task.obstacles.iter();
        let clearances = clearances
            .map(|solid| clearance(solid).unwrap_or(unknown))
            .collect();
        Ok(Flown {
            apex: number(report.apex),
            landing,
            clearances,
            report,
        })
    }
}
