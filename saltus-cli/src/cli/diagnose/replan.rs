//! `saltus diagnose --replan`: the plan before and after the diagnosis, flown on the robot that jumps.

use saltus::Robot;
use saltus::planner::Crossing;
use saltus::replan::replan;
use saltus::verify::{Group, Verdict, Verification};
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
    plans: Vec<(&'static str, Option<Verdict>)>,
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
            tolerance: Some(f64::INFINITY),
            share: 0.95,
            ..Verification::default()
        };
        let mut all = Replan {
            course,
            jumper: jumper.name.clone(),
            plans: Vec::new(),
        };
        for (name, robot) in ["believed", "measured"].into_iter().zip(robots) {
            let Some(robot) = robot else { continue };
            let plan = replan(robot, jumper, &crossing, &how);
            let plan = plan.map_err(|error| CliError::content(&all.course, error))?;
            all.plans.push((name, plan));
            progress.advance(1);
        }
        Ok(all)
    }

    /// What the plans come to: a sentence, then one for each.
    pub(super) fn lines(&self) -> Vec<String> {
        let mm = |x: Option<f64>| x.map_or("–".into(), |x| digits(1e3 * x, 3));
        let line = |(name, plan): &(&str, Option<Verdict>)| match drawn(plan.as_ref()) {
            None => format!("as {name}: no plan crosses the course"),
            Some((runs, missed)) => format!(
                "as {name}: {} of {} runs pass; landings {} ± {} mm off the plan{}",
                runs.runs_passed,
                runs.runs,
                mm(runs.land_error.mean),
                mm(runs.land_error.deviation),
                missed.map_or(String::new(), |it| format!("; missed most: {it}"))
            ),
        };
        let (course, jumper) = (&self.course, &self.jumper);
        let head = format!("Plans for {course}, flown on {jumper} with errors that made neither:");
        let lines = self.plans.iter().map(line);
        std::iter::once(head).chain(lines).collect()
    }

    pub(super) fn json(&self) -> Value {
        let mut all = json!({ "course": self.course, "plant": self.jumper });
        for (name, plan) in &self.plans {
            all[*name] = drawn(plan.as_ref()).map_or(Value::Null, |(runs, missed)| {
                json!({
                    "runs": runs.runs,
                    "runs_passed": runs.runs_passed,
                    "land_error_mean_m": runs.land_error.mean,
                    "land_error_sd_m": runs.land_error.deviation,
                    "missed_most": missed,
                })
            });
        }
        all
    }
}

/// The runs with errors drawn, and the demand that they miss most often.
fn drawn(verdict: Option<&Verdict>) -> Option<(&Group, Option<&'static str>)> {
    let verdict = verdict?;
    let missed = verdict.failures.iter().find(|failure| failure.errors);
    Some((verdict.all(true)?, missed.map(|it| it.demand.name())))
}
