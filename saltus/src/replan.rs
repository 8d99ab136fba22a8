//! What knowing a robot is worth on a course: the plan that holds on it, flown on another robot.
//!
//! ```
//! use saltus::{Robot, replan::replan, resolve, verify::Verification};
//!
//! let measured = resolve("rats-planar", &["body.mass_kg=2.9".into()])?;
//! let course = "approach_rate_rad_s = 5\ngoal_from_x_m = 0.78\ngoal_to_x_m = 0.82";
//! let crossing = saltus::course::parse(course, "goal.toml")?;
//! let how = Verification { samples: 40, share: 0.95, ..Verification::default() };
//! let fly = |robot| replan(robot, &measured, &crossing, &how);
//! let [before, after] = [fly(&Robot::rats_planar())?, fly(&measured)?].map(Option::unwrap);
//! let passed = |verdict: saltus::verify::Verdict| verdict.all(true).map(|runs| runs.runs_passed);
//! assert!(passed(before) < passed(after));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::ops::ControlFlow;

use saltus_planner::{Crossing, CrossingAnswer};
use saltus_robot::Robot;

use crate::on_plant::OnPlant;
use crate::robust::{self, ACCURACY, Robust, RobustError};
use crate::verify::{Plant, Subject, Verdict, Verification};

/// The plan for `crossing` that holds in the share of `how` on `robot`, or else most often, flown on
/// `jumper` as `how` says; none where no plan crosses it.
///
/// # Errors
/// [`RobustError`] for a robot without bodies, or a course outside its domain.
pub fn replan(
    robot: &Robot,
    jumper: &Robot,
    crossing: &Crossing,
    how: &Verification,
) -> Result<Option<Verdict>, RobustError> {
    let mut planning = how.clone();
    // The draws that judge a plan are others.
    planning.seed ^= 0x9a1a;
    let itself = OnPlant::new(robot, robot)?;
    let go_on = |_: &_| ControlFlow::Continue(());
    let crossed = match robust::plan(robot, &itself, crossing, &planning, &go_on)? {
        Robust::Plan { held, .. } => held.crossed,
        Robust::None(crossed) => crossed,
    };
    let CrossingAnswer::Plan(plan) = crossed.answer else {
        return Ok(None);
    };
    let subject = Subject::plan(crossing.clone(), plan);
    let trials = how.trials(&subject, &crossed.planner, jumper.body.radius)?;
    let outcomes = how.fly(&Plant::new(jumper.clone(), ACCURACY), &trials, &|| ());
    Ok(Some(Verdict::of(&outcomes, how.share)))
}
