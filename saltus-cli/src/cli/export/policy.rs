//! `saltus export policy`: what was learnt, for a controller.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use saltus::export::{LearntTable, Number, Running};
use saltus::gait::Setup;
use saltus::gait::learn::Task;
use saltus::learning;

use super::tables::identifier;
use super::{Real, RealType};
use crate::cli::Status;
use crate::cli::common::OutFolder;
use crate::cli::learned::Learned;
use crate::error::CliError;

/// Write what `saltus learn` learnt as a table in C99 or Rust
#[derive(Args, Debug)]
#[command(after_help = "`saltus export policy --help` explains the files.", after_long_help = HELP)]
pub(super) struct Policy {
    /// What `saltus learn --out` wrote as JSON
    #[arg(value_name = "POLICY.json")]
    learnt: PathBuf,

    /// The language
    #[arg(long = "as", value_enum, default_value_t = Language::C)]
    language: Language,

    #[command(flatten)]
    real: Real,

    /// Name of the constant in Rust [default: POLICY]
    #[arg(long, value_name = "NAME", value_parser = identifier)]
    name: Option<String>,

    #[command(flatten)]
    out: OutFolder,
}

const HELP: &str = "\
Examples:
  saltus export policy policy.json --out firmware/src
  saltus export policy policy.json --as rust --real double --name RUN_ZONE --out src

A table becomes saltus_policy.h, which has the choice in each state and the function that finds it, or policy.rs, a constant for the crate \
saltus-controller. What is observed, in which units, and what the choices are stands at the head; it is printed, too. The choice is the action of the \
greatest value, of equal ones the first: what `saltus learn` scores and `saltus run --policy` runs, to the bit with --real double.

A law (run-stride by bayes or cma-es) becomes the files of `saltus export c --gait`, for C alone.

A table of several tilings cannot be written: exit code 2.";

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Language {
    /// C99
    C,
    /// Rust
    Rust,
}

impl Policy {
    pub(super) fn run(self) -> Result<Status, CliError> {
        if let (Some(name), Language::C) = (&self.name, self.language) {
            let allowed = "left out with --as c, which has no constant to name";
            return Err(CliError::flag("--name", name, allowed));
        }
        self.out.ready()?;
        match self.real.real {
            RealType::Float => self.write::<f32>(),
            RealType::Double => self.write::<f64>(),
        }
    }

    fn write<R: Number>(&self) -> Result<Status, CliError> {
        let name = self.learnt.display().to_string();
        let learned = Learned::load(&self.learnt)?;
        let wrong = |error| CliError::content(&name, error);
        let table = LearntTable::new(&learned.policy, &learned.settings, learned.seed);
        let (texts, about) = match table.map_err(wrong)? {
            Some(table) => {
                let text = match self.language {
                    Language::C => ("saltus_policy.h", table.c::<R>()),
                    Language::Rust => (
                        "policy.rs",
                        table.rust::<R>(self.name.as_deref().unwrap_or("POLICY")),
                    ),
                };
                (vec![text], table.about)
            }
            None if self.language == Language::Rust => {
                let allowed = "c for a law, which is no table";
                return Err(CliError::flag("--as", "rust", allowed));
            }
            None => {
                let running = law::<R>(&learned.policy, &learned.settings).map_err(wrong)?;
                (running.files.to_vec(), running.about)
            }
        };
        self.out.write(texts, &about)?;
        Ok(Status::Done)
    }
}

/// What runs by a law.
fn law<R: Number>(
    policy: &learning::Policy,
    settings: &learning::Settings,
) -> Result<Running, saltus::gait::GaitError> {
    let robot = settings.plant.robot.clone();
    let mut setup = Setup::new(robot, policy.program(settings)?, 1.0);
    setup.zone = Task::default().zone;
    Running::new::<R>(&setup)
}
