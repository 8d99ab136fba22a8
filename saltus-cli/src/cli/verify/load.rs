//! Which reader a subject has.

use std::path::Path;

use saltus::Robot;
use saltus::on_plant::OnPlant;
use saltus::planner::{Corrected, CorrectedFlight, Planner};
use saltus::verify::{Plant, Subject};

use super::subject::{self, SubjectFlags};
use super::table_file;
use crate::cli::common::note_valve;
use crate::error::CliError;

/// What is verified.
pub(super) struct Loaded {
    /// What it is called.
    pub(super) title: String,
    pub(super) subject: Subject<CorrectedFlight<f64>>,
    /// What says where its jumps land.
    pub(super) planner: Planner<Corrected>,
    /// Whether it was made for the robot that jumps.
    pub(super) for_plant: bool,
}

/// What the flags name, for `robot`; none for a course that no plan crosses.
pub(super) fn load(
    flags: &SubjectFlags,
    robot: Robot,
    plant: &Plant,
) -> Result<Option<Loaded>, CliError> {
    note_valve(&robot, flags.valve_open.map(|_| "--valve-open"));
    let ending = flags.file.as_deref().and_then(ending);
    let is_course = flags.file.is_some() && matches!(ending.as_deref(), None | Some("toml"));
    if flags.correct && !is_course {
        let allowed = "left out where there is no course";
        return Err(CliError::flag("--correct", "", allowed));
    }
    match (&flags.file, flags.law) {
        (Some(file), None) => match ending.as_deref() {
            Some("csv") => table_file::load(flags, file, robot, plant).map(Some),
            None | Some("toml") => subject::plan(flags, file, robot, plant),
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

/// Answers for `robot` that hold on `plant`.
pub(super) fn on_plant(robot: &Robot, plant: &Plant) -> Result<OnPlant, CliError> {
    let plant = plant.robot();
    OnPlant::new(robot, plant).map_err(|error| CliError::content(&plant.name, error))
}

/// How a file's name ends, in small letters.
fn ending(file: &Path) -> Option<String> {
    Some(file.extension()?.to_str()?.to_ascii_lowercase())
}
