//! A plan file: an experiment that is not done yet.

use std::collections::BTreeMap;
use std::path::Path;

use saltus_diagnosis::{Experiment, Known, Sort};
use saltus_robot::domain::Domain;
use saltus_robot::units::{ANGLE, ANGULAR_RATE, PRESSURE, TIME};
use saltus_robot::{Robot, RobotError};

use super::manifest::{self, known, sizes};
use crate::inject::{self, Asked, Request};
use crate::input::{InputError, text};
use saltus_robot::section::Section;

/// Most runs, or jumps, of a plan.
const MOST: usize = 500;

/// An experiment that is planned.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Its kind.
    pub kind: Sort,
    /// The robot that the operator believes in, as the file names it.
    pub robot: Option<String>,
    /// What is known apart from the data.
    pub known: Vec<Known>,
    /// What is asked of each jump; empty: drawn as is usual.
    pub jumps: Vec<Asked>,
    /// How many runs (of outcomes: jumps); none: as many as is usual, or as are listed.
    pub runs: Option<usize>,
    noise: BTreeMap<String, f64>,
    resolution: BTreeMap<String, f64>,
}

/// Why a plan cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    /// The file.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A key of it.
    #[error(transparent)]
    Key(#[from] RobotError),
    /// What it says.
    #[error(transparent)]
    Content(#[from] super::Error),
}

impl Plan {
    /// The plan in the file at `path`.
    ///
    /// # Errors
    /// [`PlanError`] for a file that cannot be read, and for a key or a value that is not allowed.
    pub fn open(path: &Path) -> Result<Plan, PlanError> {
        Plan::parse(&text(path, 8)?, &path.display().to_string())
    }

    /// The plan of `text`, which errors call `file`.
    ///
    /// # Errors
    /// As [`Plan::open`].
    pub fn parse(text: &str, file: &str) -> Result<Plan, PlanError> {
        let mut root = Section::file(text, file)?;
        root.check_keys(&[
            "kind",
            "robot",
            "noise",
            "resolution",
            "known",
            "runs",
            "jump",
        ])?;
        let spec = manifest::kind(&mut root)?;
        let has_jumps = matches!(spec.sort, Sort::Jump | Sort::Outcomes);
        if !has_jumps {
            let allowed = "left out: only the kinds jump and outcomes have [[jump]]";
            root.refuse_key("jump", allowed);
        }
        let (runs, tables) = (root.count_to("runs", MOST), root.tables("jump", MOST));
        if runs.is_some() && !tables.is_empty() {
            root.refuse_key("runs", "left out where [[jump]] lists them");
        }
        let plan = Plan {
            kind: spec.sort,
            robot: root.has("robot").then(|| root.text("robot")),
            known: known(&mut root),
            noise: sizes(&mut root, "noise", spec),
            resolution: sizes(&mut root, "resolution", spec),
            jumps: Vec::new(),
            runs,
        };
        let place = root.place().to_string();
        let plan = root.finish(plan)?;
        let mut jumps = Vec::new();
        for table in tables {
            let (asked, count) = jump(table, spec.sort == Sort::Jump)?;
            jumps.extend(std::iter::repeat_n(asked, count));
        }
        if jumps.len() > MOST {
            let reason = format!("{} jumps, at most {MOST} are allowed", jumps.len());
            return Err(InputError::content(place, reason).into());
        }
        Ok(Plan { jumps, ..plan })
    }

    /// The experiment as it could turn out for the robot that the operator believes in.
    ///
    /// # Errors
    /// [`inject::Error`] where kind and robot do not go together, or there is no motion.
    pub fn experiment(
        &self,
        robot: Option<&Robot>,
        seed: u64,
    ) -> Result<Experiment, inject::Error> {
        self.asking(&self.jumps, robot, seed)
    }

    /// The same with these jumps in the place of the plan's.
    pub(crate) fn asking(
        &self,
        asked: &[Asked],
        robot: Option<&Robot>,
        seed: u64,
    ) -> Result<Experiment, inject::Error> {
        let made = inject::make(&Request {
            kind: self.kind,
            robot,
            effects: &[],
            seed,
            runs: self.runs.filter(|_| asked.is_empty()),
            asked,
        })?;
        let mut experiment = made.experiment;
        for (column, name) in experiment.columns.iter().enumerate() {
            let told = |sizes: &BTreeMap<String, f64>| sizes.get(name).copied();
            let (noise, resolution) = (told(&self.noise), told(&self.resolution));
            if noise.is_some() || resolution.is_some() {
                (experiment.noise[column], experiment.resolution[column]) = (noise, resolution);
            }
        }
        Ok(experiment)
    }
}

/// A jump that is planned, and how often.
fn jump(mut s: Section, supplied: bool) -> Result<(Asked, usize), RobotError> {
    let lean = Domain::above(-1.5).below(1.5);
    let asked = Asked {
        rate: s.number(
            "approach_rate",
            ANGULAR_RATE,
            Domain::NON_NEGATIVE.up_to(1e3),
        ),
        firing_angle: s.number("firing_angle", ANGLE, lean),
        valve_open: s.number("valve_open", TIME, Domain::POSITIVE.up_to(10.0)),
        supply: if supplied {
            s.optional("supply_pressure_gauge", PRESSURE, Domain::POSITIVE)
        } else {
            None
        },
    };
    let count = s.count_to("repeat", MOST).unwrap_or(1);
    s.finish((asked, count))
}
