//! A run as a folder of measured data of kind `run`: `experiment.toml`, the robot as it is believed,
//! `run.csv` with what is measured; beside it every cycle, and how the run was set.

use std::fs;
use std::path::{Path, PathBuf};

use saltus::Robot;
use saltus::temporary::{self, Temporary};

use super::rows::Rows;
use crate::error::CliError;
use crate::output::Files;

pub(super) const ROWS: &str = "run.csv";
const CYCLES: &str = "cycles.csv";
pub(super) const SETTINGS: &str = "settings.toml";
pub(super) const ROBOT: &str = "robot.toml";
pub(super) const MANIFEST: &str = "experiment.toml";

/// A folder that is filled; it is as it was where the run does not come to its end.
#[derive(Debug)]
pub(super) struct Telemetry {
    folder: PathBuf,
    /// Whether it was made for this.
    is_new: bool,
    staged: Option<Temporary>,
    /// Every cycle, and what is measured in it.
    rows: Vec<Rows>,
}

impl Telemetry {
    /// Opens `folder`, new or empty, for rows under these headers.
    pub(super) fn open(
        folder: &Path,
        cycles: String,
        measured: String,
    ) -> Result<Telemetry, CliError> {
        let failed = |error| CliError::write(folder, error);
        let is_new = !folder.exists();
        fs::create_dir_all(folder).map_err(failed)?;
        let mut telemetry = Telemetry {
            folder: folder.into(),
            is_new,
            staged: None,
            rows: Vec::new(),
        };
        temporary::sweep(folder);
        if fs::read_dir(folder).map_err(failed)?.next().is_some() {
            let allowed = "a new or an empty folder";
            return Err(CliError::flag("--telemetry", folder.display(), allowed));
        }
        let staged = Temporary::folder_in(folder).map_err(failed)?;
        for (name, header) in [(CYCLES, cycles), (ROWS, measured)] {
            let file = staged.path().join(name);
            let rows = Rows::open("--telemetry", Some(&file), header)?;
            telemetry.rows.push(rows);
        }
        telemetry.staged = Some(staged);
        Ok(telemetry)
    }

    /// Adds the line of a cycle that `write` makes.
    pub(super) fn cycle(&mut self, write: impl FnOnce(&mut String)) {
        self.rows[0].line(write);
    }

    /// Adds what is measured at a time (s).
    pub(super) fn measured(&mut self, time: f64, values: &[f64]) {
        self.rows[1].measured(time, values);
    }

    /// Whether its files still take what comes.
    pub(super) fn is_open(&self) -> bool {
        self.rows.iter().all(Rows::is_open)
    }

    /// Puts all files in their place, with the robot, which need not be the one that ran, and `more`: the manifest last, as nothing
    /// reads the data without one.
    pub(super) fn publish<const N: usize>(
        mut self,
        robot: &Robot,
        more: [(&'static str, String); N],
    ) -> Result<(), CliError> {
        let Some(staged) = self.staged.take() else {
            return Ok(());
        };
        let mut files = Files::default();
        for rows in self.rows.drain(..) {
            if let Some(stream) = rows.finish()? {
                files.written(stream)?;
            }
        }
        let mut names = vec![ROWS, CYCLES];
        for (name, text) in [(ROBOT, robot.to_toml())].into_iter().chain(more) {
            files.add("--telemetry", &staged.path().join(name), text.into_bytes());
            names.push(name);
        }
        files.write()?;
        for name in names {
            let place = self.folder.join(name);
            fs::rename(staged.path().join(name), &place)
                .map_err(|error| CliError::write(&place, error))?;
        }
        self.is_new = false;
        Ok(())
    }
}

impl Drop for Telemetry {
    fn drop(&mut self) {
        self.rows.clear();
        self.staged = None;
        if self.is_new {
            // Only an empty folder goes.
            let _ = fs::remove_dir(&self.folder);
        }
    }
}
