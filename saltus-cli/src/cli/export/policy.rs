//! `saltus export policy`: what was learnt, for a controller.

use std::path::PathBuf;

use clap::Args;
use saltus::export::{LearntTable, Number};

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
scores and `saltus run --policy` runs, to the bit with --real double.";

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
        let table = LearntTable::new(&learned.table, &learned.settings, learned.seed)
            .map_err(|error| CliError::content(&name, error))?;
        std::fs::create_dir_all(&self.out).map_err(|error| CliError::write(&self.out, error))?;
        let mut files = Files::default();
        let header = self.out.join("saltus_policy.h");
        files.add("--out", &header, table.c::<R>().into_bytes());
        files.report(None, table.about.join("\n") + "\n");
        files.write()?;
        Ok(Status::Done)
    }
}
