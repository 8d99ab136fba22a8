//! `saltus export policy`: what was learnt, for a controller.

use std::path::PathBuf;

use clap::Args;
use saltus::export::{LearntTable, Number, Running};
use saltus::gait::Setup;
use saltus::gait::learn::Task;
use saltus::learning;

use super::tables::RealType;
use crate::cli::Status;
use crate::cli::common::seed;
use crate::cli::learned::Learned;
use crate::error::CliError;
use crate::output::{Files, reachable_folder};

/// Write what `saltus learn` learnt as a table in C99
#[derive(Args, Debug)]
#[command(after_help = "`saltus export policy --help` explains the files.", after_long_help = HELP)]
pub(super) struct Policy {
    /// What `saltus learn --out` wrote as JSON
    #[arg(value_name = "POLICY.json")]
    learnt: PathBuf,

    /// The seed whose policy is written [default: the one that did best]
    #[arg(long = "policy-seed", value_name = "SEED", value_parser = seed)]
    seed: Option<u64>,

    /// Numbers to compute with
    #[arg(long, value_enum, default_value_t = RealType::Float)]
    real: RealType,

    /// Write the files into this folder, which is made if it is not there
    #[arg(long, short, value_name = "DIR", help_heading = "Robot and output")]
    out: PathBuf,
}

const HELP: &str = "\
Examples:
  saltus export policy policy.json --out firmware/src

A table becomes saltus_policy.h, which has the choice in each state and the function that finds it. What is observed, in which units, and what the \
choices are stands at the head; it is printed, too. The choice is the action of the greatest value, of equal ones the first: what `saltus learn` \
scores and `saltus run --policy` runs, to the bit with --real double.

A law (run-stride by bayes or cma-es) becomes the files of `saltus export c --gait`.

A table of several tilings cannot be written: exit code 2.";

impl Policy {
    pub(super) fn run(self) -> Result<Status, CliError> {
        if self.out.exists() && !self.out.is_dir() {
            let allowed = "a folder, into which the files are written";
            return Err(CliError::flag("--out", self.out.display(), allowed));
        }
        reachable_folder(&self.out)?;
        match self.real {
            RealType::Float => self.write::<f32>(),
            RealType::Double => self.write::<f64>(),
        }
    }

    fn write<R: Number>(&self) -> Result<Status, CliError> {
        let name = self.learnt.display().to_string();
        let learned = Learned::load(&self.learnt, self.seed)?;
        let wrong = |error| CliError::content(&name, error);
        let table = LearntTable::new(&learned.policy, &learned.settings, learned.seed);
        let (texts, about) = match table.map_err(wrong)? {
            Some(table) => (vec![("saltus_policy.h", table.c::<R>())], table.about),
            None => {
                let running = law::<R>(&learned.policy, &learned.settings).map_err(wrong)?;
                (running.files.to_vec(), running.about)
            }
        };
        std::fs::create_dir_all(&self.out).map_err(|error| CliError::write(&self.out, error))?;
        let mut files = Files::default();
        for (name, text) in texts {
            files.add("--out", &self.out.join(name), text.into_bytes());
        }
        files.report(None, about.join("\n") + "\n");
        files.write()?;
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
