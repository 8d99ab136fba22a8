//! `saltus diagnose`: what measured data say is wrong with the simulation.

mod inject;
mod report;

use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;
use saltus::diagnosis::{self, Diagnosis, Kind, Settings, Sort};
use saltus::experiment::{self, Folder};

use self::inject::InjectFlags;
use self::report::Report;
use super::Status;
use super::common::OutputFlags;
use crate::error::CliError;
use crate::output::Format;
use crate::progress::Progress;

/// Say what measured data show to be wrong with the simulation, why, and what knowing it is worth
#[derive(Args, Debug)]
#[command(after_help = "`saltus diagnose --help` explains data and output.", after_long_help = LONG_HELP)]
pub(crate) struct Diagnose {
    /// Data folders of one kind: an experiment.toml and a CSV file for each run
    #[arg(value_name = "FOLDER", required_unless_present = "inject", conflicts_with = "inject")]
    folders: Vec<PathBuf>,

    /// Robot that the operator believes was measured, in place of the folder's: a built-in one or a TOML file
    #[arg(long, value_name = "NAME|FILE", help_heading = "Robot and output")]
    robot: Option<String>,

    /// Override a parameter of the robot by its dotted key; may be repeated
    #[arg(long = "set", value_name = "KEY=VALUE", help_heading = "Robot and output")]
    overrides: Vec<String>,

    /// How often data without an effect may be said to have one
    #[arg(long, value_name = "SHARE", value_parser = level, default_value = "0.05", help_heading = "What is claimed")]
    false_alarms: f64,

    /// Most effects that are looked for at the same time
    #[arg(long, value_name = "COUNT", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=6))]
    #[arg(help_heading = "What is claimed")]
    most: u8,

    /// Seed of what is drawn by chance
    #[arg(long, value_name = "NUMBER", default_value_t = 1, help_heading = "What is claimed")]
    seed: u64,

    #[command(flatten)]
    inject: InjectFlags,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus diagnose logs/monday
  saltus diagnose hopper/static hopper/dynamic-1 --format json
  saltus diagnose --inject coulomb-friction=25 --out synthetic
  saltus diagnose --inject encoder-scale=wheel_angle_rad:1.02 --inject axle-friction=0.3 --kind jump --out both

With --inject there is nothing to diagnose: data are made with effects hidden in them, in the folder --out, and the report says \
what they are; the folder does not. CAUSE is an id, VALUE its parameter in the unit of its name, several with commas; of a sensor \
COLUMN:VALUE. A CAUSE that the kind does not have is answered with a list of those that it has.";

fn level(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x <= 0.5 => Ok(x),
        _ => Err("a share above 0, at most 0.5".into()),
    }
}

/// Data with their model, and what was found.
struct Found {
    folder: Folder,
    robot: Option<Robot>,
    kind: Box<dyn Kind>,
    diagnosis: Diagnosis,
    settings: Settings,
}

impl Diagnose {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        if self.inject.is_set() {
            return self.inject.run(&self);
        }
        let folder = {
            let progress = Progress::new("rows", 0);
            experiment::read_all(&self.folders, &|n| progress.advance(n))?
        };
        let robot = self.robot_of(&folder)?;
        let kind = diagnosis::kinds::build(&folder.experiment, robot.as_ref())
            .map_err(|error| unusable(&folder, error.to_string()))?;
        let settings = Settings {
            false_alarms: self.false_alarms,
            most: usize::from(self.most),
            seed: self.seed,
            ..Settings::default()
        };
        let progress = Progress::new("fits", 0);
        let diagnosis = diagnosis::diagnose(kind.as_ref(), &settings, &|_| progress.advance(1));
        drop(progress);
        let Some(diagnosis) = diagnosis else {
            return Err(unusable(
                &folder,
                "the model has no such motion: is it the robot that was measured?".into(),
            ));
        };
        let found = Found { folder, robot, kind, diagnosis, settings };
        let report = Report::of(&found);
        let text = match self.output.format() {
            Format::Text => report.text(),
            Format::Json => crate::output::json(&report.json()),
            Format::Csv => report.csv(),
        };
        self.output.write_report(text)?;
        Ok(if found.diagnosis.findings.is_empty() && found.diagnosis.unknown.is_none() {
            Status::Done
        } else {
            Status::No
        })
    }

    /// The robot that was measured, as the flags or else the folder say; none where the kind is about none.
    fn robot_of(&self, folder: &Folder) -> Result<Option<Robot>, CliError> {
        let needs = matches!(folder.experiment.kind, Sort::Bench | Sort::Hop | Sort::Jump | Sort::Outcomes);
        let name = match (&self.robot, &folder.robot) {
            (Some(name), _) => name.clone(),
            (None, Some(name)) => beside(&folder.path, name),
            (None, None) if needs => {
                return Err(CliError::Missing { flag: "--robot", allowed: "the robot that was measured" });
            }
            (None, None) => return Ok(None),
        };
        Ok(Some(saltus::resolve(&name, &self.overrides)?))
    }
}

fn unusable(folder: &Folder, reason: String) -> CliError {
    CliError::Content { file: folder.path.display().to_string(), reason }
}

/// A built-in robot's name, or the path of a file beside the data.
pub(super) fn beside(folder: &Path, name: &str) -> String {
    if saltus::Robot::builtin_names().any(|known| known == name) {
        return name.to_owned();
    }
    folder.join(name).display().to_string()
}
