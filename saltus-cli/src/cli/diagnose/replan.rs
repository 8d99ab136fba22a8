//! `saltus diagnose --replan`: the plan before and after the diagnosis, flown on the robot that jumps.

use saltus::Robot;
use saltus::planner::Crossing;
use saltus::replan::{Replanned, replan};
use saltus::verify::{Demand, Verification};
use serde_json::{Value, json};

use crate::error::CliError;
use crate::output::digits;
use crate::progress::Progress;

/// A course and its file.
pub(super) type Course = (String, Crossing);

/// The plans, flown: for the robot as believed and, where the diagnosis found another, as measured.
pub(super) struct Replan {
    course: String,
    /// Name of the robot that jumped.
    jumper: String,
    plans: Vec<(&'static str, Option<Replanned>)>,
}

impl Replan {
    /// The plans of a course for `robots`, as believed and as measured, flown on `jumper`.
    pub(super) fn new(
        (course, crossing): Course,
        robots: [Option<&Robot>; 2],
        jumper: &Robot,
        seed: u64,
    ) -> Result<Replan, CliError> {
        let progress = Progress::new("plans", robots.len());
        let how = Verification {
            samples: 200,
            seed,
            tolerance: f64::INFINITY,
            share: 0.95,
            ..Verification::default()
        };
        let mut plans = Vec::new();
        for (name, robot) in ["believed", "measured"].into_iter().zip(robots) {
            let plan = robot.map(|robot| replan(robot, jumper, &crossing, &how));
            let plan = plan.transpose();
            let plan = plan.map_err(|error| CliError::content(&course, error))?;
            plans.extend(plan.map(|plan| (name, plan)));
            progress.advance(1);
        }
        let jumper = jumper.name.clone();
        Ok(Replan {
            course,
            jumper,
            plans,
        })
    }

    /// What the plans come to: a sentence, then one for each.
    pub(super) fn lines(&self) -> Vec<String> {
        let mm = |x: Option<f64>| x.map_or("–".into(), |x| digits(1e3 * x, 3));
        let line = |(name, plan): &(&str, Option<Replanned>)| match plan {
            None => format!("as {name}: no plan crosses the course"),
            Some(Replanned { runs, missed }) => format!(
                "as {name}: {} of {} runs pass; landings {} ± {} mm off the plan{}",
                runs.runs_passed,
                runs.runs,
                mm(runs.land_error.mean),
                mm(runs.land_error.deviation),
                missed.map_or(String::new(), |it| format!("; missed most: {}", it.name()))
            ),
        };
        let (course, jumper) = (&self.course, &self.jumper);
        let head = format!("Plans for {course}, flown on {jumper} with errors that made neither:");
        std::iter::once(head)
            .chain(self.plans.iter().map(line))
            .collect()
    }

    pub(super) fn json(&self) -> Value {
        let mut all = json!({ "course": self.course, "plant": self.jumper });
        for (name, plan) in &self.plans {
            all[*name] = plan
                .as_ref()
                .map_or(Value::Null, |Replanned { runs, missed }| {
                    json!({
                        "runs": runs.runs,
                        "runs_passed": runs.runs_passed,
                        "land_error_mean_m": runs.land_error.mean,
                        "land_error_sd_m": runs.land_error.deviation,
                        "missed_most": missed.map(Demand::name),
                    })
                });
        }
        all
    }
}
