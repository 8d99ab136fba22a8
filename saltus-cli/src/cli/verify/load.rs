//! What is verified, from a course, a table or a law.

use std::path::Path;

use saltus::Robot;
use saltus::verify::{Plant, Verification};

use super::subject::{self, Loaded, SubjectFlags};
use super::table_file;
use crate::error::CliError;

/// What the flags name, for `robot`; none for a course that no plan crosses. A corrected plan has
/// margins for the runs `margins`.
pub(super) fn load(
    flags: &SubjectFlags,
    robot: Robot,
    plant: &Plant,
    margins: Option<&Verification>,
) -> Result<Option<Loaded>, CliError> {
    flags.terms.note_valve(&robot);
    let ending = flags.file.as_deref().and_then(ending);
    let is_course = flags.file.is_some() && matches!(ending.as_deref(), None | Some("toml"));
    if flags.correct && !is_course {
        let allowed = "left out where there is no course";
        return Err(CliError::flag("--correct", "", allowed));
    }
    match (&flags.file, flags.law) {
        (Some(file), None) => match ending.as_deref() {
            Some("csv") => table_file::load(flags, file, robot, plant).map(Some),
            None | Some("toml") => subject::plan(flags, file, robot, plant, margins),
            Some(_) => Err(CliError::content(
                file.display(),
                "verify reads a course (.toml) or a table that `saltus table` wrote as CSV \
                     (.csv)",
            )),
        },
        (_, Some((slope, intercept))) => subject::law(flags, slope, intercept, robot).map(Some),
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
