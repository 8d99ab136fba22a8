//! `saltus export policy`: what was learnt, for a controller.

use std::path::PathBuf;

use clap::Args;
use saltus::export::{LearntTable, Number};

use super::{Real, Written};
use crate::cli::Status;
use crate::cli::common::OutFolder;
use crate::cli::learned::Learned;
use crate::error::CliError;

/// Write what `saltus learn` learnt as a table in C99
#[derive(Args, Debug)]
#[command(after_help = "`saltus export policy --help` explains the files.", after_long_help = HELP)]
pub(super) struct Policy {
    /// What `saltus learn --out` wrote as JSON
    #[arg(value_name = "POLICY.json")]
    learnt: PathBuf,

    #[command(flatten)]
    real: Real,

    #[command(flatten)]
    out: OutFolder,
}

const HELP: &str = "\
Examples:
  saltus export policy policy.json --out firmware/src

A table becomes saltus_policy.h, which has the choice in each state and the function that finds it. What is observed, in which units, and what the \
choices are stands at the head; it is printed, too. The choice is the action of the greatest value, of equal ones the first: what `saltus learn` \
scores and `saltus run policy` runs, to the bit with --real double.";

impl Policy {
    pub(super) fn run(self) -> Result<Status, CliError> {
        self.out.ready()?;
        self.real.write(&self)
    }
}

impl Written for Policy {
    fn write<R: Number>(&self) -> Result<Status, CliError> {
        let name = self.learnt.display().to_string();
        let learned = Learned::load(&self.learnt)?;
        let table = LearntTable::new(&learned.table, &learned.settings, learned.seed)
            .map_err(|error| CliError::content(&name, error))?;
        self.out
            .write([("saltus_policy.h", table.c::<R>())], &table.about)?;
        Ok(Status::Done)
    }
}
