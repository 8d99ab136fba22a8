//! What is verified: a plan, a table or a law.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;
use saltus::on_plant::{OnPlant, for_crossing, planar};
use saltus::planner::course::Standing;
use saltus::planner::{Corrected, CrossingAnswer, Planner};
use saltus::robust::{self, Robust, RobustError};
use saltus::verify::{Plant, Rule, Steering, Subject, Verification};

use crate::cli::target::{Block, block};
use crate::cli::terms::{TermFlags, Terms};
use crate::error::{CliError, cut};
use crate::input;
use crate::output::{digits, file_name};
use crate::quantity;
use crate::range::{Values, rates};

/// Flags that say what is verified.
#[derive(Args, Debug)]
#[command(next_help_heading = "What is verified")]
pub(crate) struct SubjectFlags {
    /// Course (.toml), whose plan is made first, or table (.csv)
    #[arg(
        value_name = "COURSE.toml|TABLE.csv",
        required_unless_present = "law",
        conflicts_with = "law"
    )]
    pub(super) file: Option<PathBuf>,

    /// Plan for the robot that jumps, as `saltus plan --plant` does, in place of the one planned for
    #[arg(long)]
    pub(super) correct: bool,

    /// Law α_f = A ω + B: A (s) and B (rad)
    #[arg(long, value_name = "A,B", value_parser = line, allow_hyphen_values = true, requires = "omega")]
    pub(super) law: Option<(f64, f64)>,

    /// Approach rates ω (rad/s) of a law, or of a table in place of its own
    #[arg(long, value_name = "RATES", value_parser = rates, allow_hyphen_values = true)]
    pub(super) omega: Option<Values>,

    /// Distance (m) that the law is for, or the one of the table's distances to verify
    #[arg(long, value_name = "LENGTH", value_parser = quantity::distance, allow_hyphen_values = true)]
    pub(super) distance: Option<f64>,

    /// Box in the way of a law or a table (m): its front edge's distance from the foot, its width,
    /// its height
    #[arg(long, value_name = "FRONT,WIDTH,HEIGHT", value_parser = block, allow_hyphen_values = true)]
    obstacle: Option<Block>,

    #[command(flatten)]
    pub(super) terms: TermFlags,
}

impl SubjectFlags {
    /// The name of the file; empty without one.
    pub(super) fn file(&self) -> String {
        let file = self.file.as_deref().unwrap_or(Path::new(""));
        file.display().to_string()
    }

    /// `title` with the name of the file instead of its path.
    pub(super) fn short(&self, title: &str) -> String {
        match &self.file {
            Some(path) => title.replace(&path.display().to_string(), &file_name(path)),
            None => title.into(),
        }
    }
}

/// What is verified.
pub(super) struct Loaded {
    /// What it is called.
    pub(super) title: String,
    pub(super) subject: Subject,
    /// What says where its jumps land.
    pub(super) planner: Planner<Corrected>,
    /// Whether it was made for the robot that jumps.
    pub(super) for_plant: bool,
}

/// Answers for `robot` that hold on `plant`.
pub(super) fn on_plant(robot: &Robot, plant: &Plant) -> Result<OnPlant, CliError> {
    let plant = plant.robot();
    OnPlant::new(robot, plant).map_err(|error| CliError::content(&plant.name, error))
}

/// A law, for the rates that the flags name.
pub(super) fn law(
    flags: &SubjectFlags,
    slope: f64,
    intercept: f64,
    robot: Robot,
) -> Result<Loaded, CliError> {
    let rates = flags
        .omega
        .as_ref()
        .map(|rates| rates.to_vec())
        .unwrap_or_default();
    let sign = if intercept < 0.0 { '−' } else { '+' };
    let formula = format!(
        "{} s · ω {sign} {} rad",
        digits(slope, 5),
        digits(intercept.abs(), 5)
    );
    let steering = Steering::Law { slope, intercept };
    for &rate in &rates {
        let angle = steering.angle(rate);
        if angle.abs() >= std::f64::consts::FRAC_PI_2 {
            let allowed = format!(
                "one whose angles are between -pi/2 and pi/2 rad; at {rate} rad/s it is {}",
                digits(angle, 4)
            );
            return Err(CliError::flag(
                "--law",
                format!("{slope},{intercept}"),
                allowed,
            ));
        }
    }
    let terms = flags.terms.of(&robot);
    let title = format!("the law α_f = {formula}, {}", terms.landing_title());
    let rule = rule(flags, &terms, steering, rates, flags.distance);
    Ok(Loaded {
        title,
        subject: Subject::Rule(rule),
        planner: planar(robot),
        for_plant: false,
    })
}

pub(super) fn rule(
    flags: &SubjectFlags,
    terms: &Terms,
    steering: Steering,
    rates: Vec<f64>,
    distance: Option<f64>,
) -> Rule {
    Rule {
        steering,
        rates,
        distance,
        landing_height: terms.landing_height,
        valve_open: terms.valve_open,
        start_lean: terms.start_lean,
        obstacles: flags.obstacle.iter().map(Block::ends).collect(),
    }
}

/// The plan of a course; a corrected one with margins for the runs `margins`.
pub(super) fn plan(
    flags: &SubjectFlags,
    path: &Path,
    robot: Robot,
    plant: &Plant,
    margins: Option<&Verification>,
) -> Result<Option<Loaded>, CliError> {
    let alone = [
        ("--omega", flags.omega.is_some()),
        ("--distance", flags.distance.is_some()),
        ("--obstacle", flags.obstacle.is_some()),
        ("--landing-height", flags.terms.landing_height.is_some()),
        ("--valve-open", flags.terms.valve_open.is_some()),
        ("--start-lean", flags.terms.start_lean.is_some()),
    ];
    CliError::unused(&alone, "left out where a course says what is to be done")?;
    let crossing = input::course(path)?;
    let file = path.display().to_string();
    let on_plant = flags.correct.then(|| on_plant(&robot, plant)).transpose()?;
    let go_on = |_: &Standing| ControlFlow::Continue(());
    let content = |error: RobustError| CliError::content(&file, error);
    let crossed = match on_plant.as_ref().zip(margins) {
        Some((on_plant, runs)) => {
            let robust = robust::plan(&robot, on_plant, &crossing, runs, &go_on);
            match robust.map_err(content)? {
                Robust::Plan { held, .. } => held.crossed,
                Robust::None(crossed) => crossed,
            }
        }
        None => for_crossing(robot, on_plant.as_ref(), &crossing, &go_on)
            .map_err(|error| content(error.into()))?,
    };
    let CrossingAnswer::Plan(plan) = crossed.answer else {
        return Ok(None);
    };
    let corrected = if flags.correct { "corrected " } else { "" };
    Ok(Some(Loaded {
        title: format!("the {corrected}plan for {file}"),
        subject: Subject::plan(crossing, plan),
        planner: crossed.planner,
        for_plant: flags.correct,
    }))
}

/// Parser of a flag.
fn line(text: &str) -> Result<(f64, f64), String> {
    let refused = || {
        format!(
            "{:?} must be a slope (s) and an intercept (rad), as in -0.146,0.704",
            cut(text)
        )
    };
    let (slope, intercept) = text.split_once(',').ok_or_else(refused)?;
    let number = |part: &str| {
        part.trim()
            .parse::<f64>()
            .ok()
            .filter(|x| x.abs() <= 1e3)
            .ok_or_else(refused)
    };
    Ok((number(slope)?, number(intercept)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_are_two_numbers() {
        assert_eq!(line("-0.146,0.704"), Ok((-0.146, 0.704)));
        for text in ["", "1", "a,b", "1,nan", "1,2,3", "1e9,0"] {
            assert!(line(text).is_err(), "{text}");
        }
    }
}
