//! Which reader a subject has.

use std::path::Path;

use saltus::Planner;

use super::subject::{self, SubjectFlags, Titled};
use super::table_file;
use crate::cli::common::note_valve;
use crate::error::CliError;

/// What the flags name; none for a course that no plan crosses.
pub(super) fn load(flags: &SubjectFlags, planner: &Planner) -> Result<Option<Titled>, CliError> {
    note_valve(planner.robot(), flags.valve_open.map(|_| "--valve-open"));
    match (&flags.file, flags.law) {
        (Some(file), None) => match ending(file).as_deref() {
            Some("csv") => table_file::load(flags, file, planner).map(Some),
            None | Some("toml") => subject::plan(flags, file, planner),
            Some(_) => Err(CliError::content(
                file.display(),
                "verify reads a course (.toml) or a table that `saltus table` wrote as CSV \
                     (.csv)",
            )),
        },
        (_, Some((slope, intercept))) => subject::law(flags, slope, intercept, planner).map(Some),
        _ => Err(CliError::Missing {
            flag: "COURSE.toml",
            allowed: "or TABLE.csv, or --law",
        }),
    }
}

/// How a file's name ends, in small letters.
fn ending(file: &Path) -> Option<String> {
    Some(file.extension()?.to_str()?.to_ascii_lowercase())
}
