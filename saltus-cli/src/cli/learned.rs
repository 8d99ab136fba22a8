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
    /// What `seed`, or without one the best seed, learnt by the file at `path`.
    pub(super) fn load(path: &Path, seed: Option<u64>) -> Result<Learned, CliError> {
        input::note(path);
        input::spared()?;
        let name = path.display().to_string();
        let file = PolicyFile::load(path)?;
        let settings = file.settings(&name)?;
        let Some(held) = file.held(&settings, seed) else {
            let seeds = file.tables.iter().map(|held| held.seed.to_string());
            let allowed = format!("one of {}", seeds.collect::<Vec<_>>().join(", "));
            let given = seed.unwrap_or_default();
            return Err(CliError::flag("--policy-seed", given, allowed));
        };
        let table = settings.table(&held.values);
        Ok(Learned {
            seed: held.seed,
            table: table.map_err(|error| CliError::content(&name, error))?,
            settings,
        })
    }

    /// The robot that learnt it.
    pub(super) fn robot(&self) -> &Robot {
        &self.settings.plant.robot
    }
}
