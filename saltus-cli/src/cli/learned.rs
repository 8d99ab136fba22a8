//! What was learnt, from its file.

use std::path::Path;

use saltus::Robot;
use saltus::gait::learn::Tabular;
use saltus::learning::{PolicyFile, Settings};

use crate::error::CliError;
use crate::input;

/// What one seed learnt.
pub(super) struct Learned {
    pub(super) settings: Settings,
    pub(super) table: Tabular,
    pub(super) seed: u64,
}

impl Learned {
    /// What the best seed learnt by the file at `path`.
    pub(super) fn load(path: &Path) -> Result<Learned, CliError> {
        input::note(path);
        input::spared()?;
        let name = path.display().to_string();
        let file = PolicyFile::load(path)?;
        let held = file.held();
        let held = held.ok_or_else(|| CliError::content(&name, "no seed learnt anything"))?;
        let table = file.settings.table(&held.values);
        Ok(Learned {
            seed: held.seed,
            table: table.map_err(|error| CliError::content(&name, error))?,
            settings: file.settings,
        })
    }

    /// The robot that learnt it.
    pub(super) fn robot(&self) -> &Robot {
        &self.settings.plant.robot
    }
}
