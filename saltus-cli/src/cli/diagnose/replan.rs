//! `saltus diagnose --replan`: the plan for the robot as believed beside that for the robot as
//! measured, both flown on the robot that jumps.

use std::fmt::Write;
use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use saltus::chart::escaped;
use saltus::planner::Crossing;
use saltus::planner::course::Standing;
use saltus::replan::{Replanned, held_out, replan};
use saltus::verify::{Group, Verification};
use saltus::{Robot, study::Study};
use serde_json::{Map, Value, json};

use super::words::grid;
use crate::cli::common::robot;
use crate::cli::verify::{animation, context::Context};
use crate::error::CliError;
use crate::input;
use crate::output::digits;
use crate::progress::Progress;

/// What is planned anew.
#[derive(Args, Debug)]
#[command(next_help_heading = "What it is worth")]
pub(super) struct ReplanFlags {
    /// Course to plan for the robot as believed and for the robot as measured: says how many jumps
    /// of each plan pass
    #[arg(long, value_name = "COURSE.toml")]
    replan: Option<PathBuf>,

    /// Robot that jumps both plans: a built-in one or a TOML file [default: the robot as measured]
    #[arg(long, value_name = "NAME|FILE", requires = "replan")]
    plant: Option<String>,

    /// Override a parameter of the robot that jumps; may be repeated
    #[arg(long = "plant-set", value_name = "KEY=VALUE", requires = "plant")]
    plant_overrides: Vec<String>,

    /// Runs of each plan with errors drawn from the robot's [errors]
    #[arg(long, value_name = "COUNT", default_value_t = 200, value_parser = clap::value_parser!(u32).range(20..=100_000), requires = "replan")]
    samples: u32,
}

/// What `--replan` asks for, read before the diagnosis, which takes time.
pub(super) struct Asked {
    file: String,
    crossing: Crossing,
    plant: Option<Robot>,
    how: Verification,
}

/// The plans, flown.
pub(super) struct Replan {
    file: String,
    /// Name of the robot that jumped.
    jumper: String,
    how: Verification,
    /// The plan for each robot: as believed and, where the diagnosis found another, as measured.
    plans: Vec<(&'static str, Replanned)>,
}

impl ReplanFlags {
    /// Whether a course is to be planned anew.
    pub(super) fn is_set(&self) -> bool {
        self.replan.is_some()
    }

    /// What is asked for; none without the flag. `believed` is the robot of the data.
    pub(super) fn asked(
        &self,
        believed: Option<&Robot>,
        seed: u64,
    ) -> Result<Option<Asked>, CliError> {
        let Some(file) = &self.replan else {
            return Ok(None);
        };
        let Some(believed) = believed else {
            let allowed = "left out: data of this kind are of no robot";
            return Err(CliError::flag("--replan", file.display(), allowed));
        };
        let crossing = input::course(file)?;
        let plant = self
            .plant
            .as_ref()
            .map(|name| robot(name, &self.plant_overrides))
            .transpose()?;
        if let Some(plant) = &plant
            && plant.body.radius != believed.body.radius
        {
            let allowed = format!(
                "a robot with the wheel of {}, whose radius is {} m: footholds count from it",
                believed.name, believed.body.radius
            );
            let radius = format!("{} ({} m)", plant.name, plant.body.radius);
            return Err(CliError::flag("--plant", radius, allowed));
        }
        Ok(Some(Asked {
            file: file.display().to_string(),
            crossing,
            plant,
            how: held_out(self.samples as usize, seed),
        }))
    }
}

impl Asked {
    /// The plans for `believed` and for the robot that `study` extended.
    pub(super) fn replan(self, believed: &Robot, study: &Study) -> Result<Replan, CliError> {
        let measured = study.extended();
        let jumper = self.plant.or_else(|| measured.clone());
        let jumper = jumper.unwrap_or_else(|| believed.clone());
        let robots = [
            ("as believed", Some(believed)),
            ("as measured", measured.as_ref()),
        ];
        let robots: Vec<_> = robots
            .into_iter()
            .filter_map(|(n, r)| Some((n, r?)))
            .collect();
        let progress = Progress::new("runs", self.how.samples * robots.len());
        let watch = |_: &Standing| ControlFlow::Continue(());
        let mut plans = Vec::new();
        for (name, robot) in robots {
            let advance = || progress.advance(1);
            let plan = replan(robot, &jumper, &self.crossing, &self.how, &watch, &advance);
            plans.push((name, plan.map_err(|e| CliError::content(&self.file, e))?));
        }
        Ok(Replan {
            file: self.file,
            jumper: jumper.name,
            how: self.how,
            plans,
        })
    }
}

impl Replan {
    /// What the plans come to, as a sentence.
    pub(super) fn headline(&self) -> String {
        let only = if self.plans.len() == 1 {
            " Nothing was found that is a property of the robot, so that there is one plan."
        } else {
            ""
        };
        format!(
            "Plans for {}, flown on {} with errors drawn, {} runs each, none of which made the \
             plan.{only}",
            self.file, self.jumper, self.how.samples
        )
    }

    /// A header, and a line for each plan.
    pub(super) fn lines(&self) -> Vec<Vec<String>> {
        let header = [
            "plan of the robot",
            "runs that pass",
            "landing error",
            "missed most often",
        ];
        let line = |(name, plan): &(&str, Replanned)| {
            let mut line = vec![(*name).to_owned()];
            line.extend(match plan.drawn() {
                Some(drawn) => [passed(drawn), landing(drawn), missed(plan)],
                None => ["no plan crosses the course".into(), "–".into(), "–".into()],
            });
            line
        };
        let header = header.map(str::to_owned).to_vec();
        std::iter::once(header)
            .chain(self.plans.iter().map(line))
            .collect()
    }

    pub(super) fn text(&self) -> String {
        grid(&self.lines(), 1)
    }

    /// The plans as they jump, each a page in the page.
    pub(super) fn films(&self) -> Result<String, CliError> {
        let mut out = String::new();
        for (name, plan) in &self.plans {
            let Replanned::Flown(flown) = plan else {
                continue;
            };
            let title = format!("the plan of the robot {name} for {}", self.file);
            let scene = Context {
                planner: &flown.planner,
                plant: &flown.plant,
                title: &title,
                subject: &flown.subject,
                for_plant: true,
                how: &self.how,
                step_cost: None,
            };
            let page = animation::html(&flown.outcomes, &scene)
                .map_err(|error| CliError::content(&self.jumper, error))?;
            // Writing to a string does not fail.
            let _ = writeln!(
                out,
                "<h3>{}</h3>\n<iframe class=\"film\" sandbox=\"allow-scripts\" title=\"{}\" \
                 srcdoc=\"{}\"></iframe>",
                escaped(&title),
                escaped(&title),
                escaped(&page)
            );
        }
        Ok(out)
    }

    pub(super) fn json(&self) -> Value {
        let one = |(name, plan): &(&str, Replanned)| {
            let value = plan.drawn().map_or(json!({ "plan": false }), |drawn| {
                json!({
                    "plan": true,
                    "runs": drawn.runs,
                    "runs_passed": drawn.runs_passed,
                    "land_error_mean_m": drawn.land_error.mean,
                    "land_error_sd_m": drawn.land_error.deviation,
                    "missed_most": missed(plan),
                })
            });
            (name.replace("as ", ""), value)
        };
        let mut all: Map<String, Value> = self.plans.iter().map(one).collect();
        all.insert("course".into(), json!(self.file));
        all.insert("plant".into(), json!(self.jumper));
        Value::Object(all)
    }
}

fn passed(drawn: &Group) -> String {
    let share = 100.0 * drawn.runs_passed as f64 / drawn.runs.max(1) as f64;
    format!(
        "{} of {} ({} %)",
        drawn.runs_passed,
        drawn.runs,
        digits(share, 3)
    )
}

/// Mean and standard deviation of where jumps land, less where the plan lands.
fn landing(drawn: &Group) -> String {
    let mm = |x: Option<f64>| x.map_or("–".into(), |x| digits(1e3 * x, 3));
    let spread = &drawn.land_error;
    format!("{} ± {} mm", mm(spread.mean), mm(spread.deviation))
}

fn missed(plan: &Replanned) -> String {
    let Replanned::Flown(flown) = plan else {
        return String::new();
    };
    let mut drawn = flown.verdict.failures.iter().filter(|f| f.errors);
    drawn
        .next()
        .map_or("–".into(), |f| f.demand.name().to_owned())
}
