//! Motions as MCAP files: `--mcap FILE`.

use std::path::{Path, PathBuf};

use clap::Args;
use saltus::Robot;
use saltus::recording::{Error, Origin, Recording};
use saltus::telemetry;

use crate::error::CliError;
use crate::output::reachable;
use crate::session;

/// A file beside the report: the flag that names it, its path and its contents.
pub(crate) type Beside<'a> = (&'static str, &'a Path, Vec<u8>);

/// Where a motion goes as MCAP.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct McapOption {
    /// Write the motion as an MCAP file, for Foxglove, PlotJuggler, rerun and ROS 2
    #[arg(long, value_name = "FILE.mcap", value_parser = file, help_heading = "Robot and output")]
    mcap: Option<PathBuf>,
}

impl McapOption {
    /// The file, if one is asked for.
    pub(crate) fn path(&self) -> Option<&Path> {
        self.mcap.as_deref()
    }

    /// Refuses a file that cannot be written, before long work.
    pub(crate) fn ready(&self) -> Result<(), CliError> {
        reachable("--mcap", self.path())
    }

    /// What `fill` records of `robot`, if a file is asked for: flag, file and bytes.
    pub(crate) fn recorded(
        &self,
        robot: &Robot,
        seed: Option<u64>,
        fill: impl FnOnce(&mut Recording<Vec<u8>>) -> Result<(), Error>,
    ) -> Result<Option<Beside<'_>>, CliError> {
        let Some(path) = self.path() else {
            return Ok(None);
        };
        let command = command();
        let origin = Origin {
            command: &command,
            seed,
            robot: Some(robot),
        };
        let record = || {
            let mut recording = Recording::new(Vec::new(), &origin)?;
            recording.robot(robot)?;
            fill(&mut recording)?;
            recording.finish()
        };
        let bytes = record().map_err(|error| unrecorded(path, error))?;
        Ok(Some(("--mcap", path, bytes)))
    }
}

/// Why nothing was recorded in the file at `path`.
pub(crate) fn unrecorded(path: &Path, error: Error) -> CliError {
    match error {
        Error::File(telemetry::Error::Io(source)) => CliError::write(path, source),
        other => CliError::content(path.display(), other),
    }
}

/// The command line.
pub(crate) fn command() -> String {
    let words = session::with(|session| session.words.join(" "));
    format!("saltus {words}")
}

/// Parser of a flag.
fn file(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_log = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("mcap"));
    if is_log {
        Ok(path)
    } else {
        Err("the name must end in .mcap".into())
    }
}
