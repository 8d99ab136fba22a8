//! What a diagnosis is worth on a course: the plan for the robot as believed and the one for the
//! robot as measured, both flown on the robot that jumps.
//!
//! ```
//! use saltus::planner::course::Standing;
//! use saltus::replan::{Replanned, replan};
//! use saltus::{Robot, resolve};
//! use std::ops::ControlFlow;
//!
//! let believed = Robot::rats_planar();
//! let measured = resolve("rats-planar", &["body.mass_kg=2.9".into()])?;
//! let course = "approach_rate_rad_s = 5\ngoal_from_x_m = 0.78\ngoal_to_x_m = 0.82";
//! let crossing = saltus::course::parse(course, "goal.toml")?;
//! let how = saltus::replan::held_out(40, 1);
//! let go_on = |_: &Standing| ControlFlow::Continue(());
//! let fly = |robot| replan(robot, &measured, &crossing, &how, &go_on, &|| ());
//! let passes = |it: Replanned| it.drawn().map_or(0, |runs| runs.runs_passed);
//! assert!(passes(fly(&believed)?) < passes(fly(&measured)?));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use saltus_planner::course::Watch;
use saltus_planner::{Corrected, Crossing, CrossingAnswer, Planner};
use saltus_robot::Robot;

use crate::on_plant::{Crossed, OnPlant, PlantError};
use crate::robust::{self, Robust, RobustError};
use crate::verify::{Group, Outcome, Plant, Starts, Subject, TrialError, Verdict, Verification};

/// Error that the simulation makes in each step, relative to 1 + |y|.
const ACCURACY: f64 = 1e-9;

/// Share of jumps that a plan is made to hold for, on the robot that it is made for.
const SHARE: f64 = 0.95;

/// Added to the seed for the draws that make a plan: those that judge it are others.
const PLANNING: u64 = 0x9a1a;

/// Why a plan cannot be made or flown.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReplanError {
    /// The robot has no bodies.
    #[error(transparent)]
    Plant(#[from] PlantError),
    /// The course.
    #[error(transparent)]
    Robust(#[from] RobustError),
    /// A jump of the plan.
    #[error(transparent)]
    Trial(#[from] TrialError),
}

/// A plan, flown on the robot that jumps.
#[derive(Debug)]
pub struct Flown {
    /// The planner that made it.
    pub planner: Planner<Corrected>,
    /// The plan.
    pub subject: Subject,
    /// The robot that jumped.
    pub plant: Plant,
    /// Its runs.
    pub outcomes: Vec<Outcome>,
    /// What they come to.
    pub verdict: Verdict,
}

/// What the plan for a robot comes to.
#[derive(Debug)]
pub enum Replanned {
    /// It was flown.
    Flown(Box<Flown>),
    /// No plan crosses the course on that robot.
    NoPlan(Box<CrossingAnswer>),
}

impl Replanned {
    /// The runs with errors drawn, on all grounds together; none without a plan.
    pub fn drawn(&self) -> Option<&Group> {
        let Replanned::Flown(flown) = self else {
            return None;
        };
        let mut groups = flown.verdict.groups.iter().filter(|group| group.errors);
        groups.next_back()
    }
}

/// Runs that judge a plan: so many with errors drawn, on the robot's own ground.
pub fn held_out(samples: usize, seed: u64) -> Verification {
    Verification {
        samples,
        scatter: 1.0,
        seed,
        frictions: vec![None],
        starts: Starts::Chained,
        tolerance: f64::INFINITY,
        clearance: None,
        share: SHARE,
        threads: std::thread::available_parallelism().map_or(1, usize::from),
    }
}

/// The plan for `crossing` that holds most often on `robot`, flown on `jumper` as `how` says;
/// `watch` is told how far each search is, and `advance` of each run.
///
/// # Errors
/// [`ReplanError`] for a robot without bodies, or a course outside its domain.
pub fn replan(
    robot: &Robot,
    jumper: &Robot,
    crossing: &Crossing,
    how: &Verification,
    watch: &Watch<'_>,
    advance: &(dyn Fn() + Sync),
) -> Result<Replanned, ReplanError> {
    let planning = Verification {
        seed: how.seed ^ PLANNING,
        ..how.clone()
    };
    let itself = OnPlant::new(robot, robot)?;
    let crossed = match robust::plan(robot, &itself, crossing, &planning, watch)? {
        Robust::Plan { held, .. } => held.crossed,
        Robust::None(crossed) => crossed,
    };
    let Crossed {
        planner, answer, ..
    } = crossed;
    let CrossingAnswer::Plan(plan) = answer else {
        return Ok(Replanned::NoPlan(Box::new(answer)));
    };
    let subject = Subject::plan(crossing.clone(), plan);
    let plant = Plant::new(jumper.clone(), ACCURACY);
    let trials = how.trials(&subject, &planner, jumper.body.radius)?;
    let outcomes = how.fly(&plant, &trials, advance);
    let verdict = Verdict::of(&outcomes, how.share);
    Ok(Replanned::Flown(Box::new(Flown {
        planner,
        subject,
        plant,
        outcomes,
        verdict,
    })))
}
