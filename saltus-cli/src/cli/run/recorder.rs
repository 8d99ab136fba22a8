//! A run as an MCAP file, written as it goes.

use std::path::{Path, PathBuf};

use saltus::gait::{Footfall, Row, Setup};
use saltus::recording::{Error, Origin, Recording, Running};

use crate::cli::recorded::{command, unrecorded};
use crate::error::CliError;
use crate::output::Stream;

/// A run on its way to a file.
#[derive(Debug)]
pub(super) struct Recorder {
    path: PathBuf,
    running: Running<Stream>,
    /// What went wrong first.
    failed: Option<Error>,
}

impl Recorder {
    pub(super) fn open(path: &Path, setup: &Setup) -> Result<Recorder, CliError> {
        let stream = Stream::open("--mcap", path)?;
        let command = command();
        let origin = Origin {
            command: &command,
            seed: Some(setup.seed),
            robot: Some(&setup.robot),
        };
        let running =
            Recording::new(stream, &origin).and_then(|recording| Running::new(recording, setup));
        Ok(Recorder {
            path: path.into(),
            running: running.map_err(|error| unrecorded(path, error))?,
            failed: None,
        })
    }

    /// Whether the file still takes what comes.
    pub(super) fn is_open(&self) -> bool {
        self.failed.is_none()
    }

    pub(super) fn row(&mut self, row: &Row<'_>) {
        if self.failed.is_none() {
            self.failed = self.running.row(row).err();
        }
    }

    pub(super) fn footfall(&mut self, footfall: &Footfall) {
        if self.failed.is_none() {
            self.failed = self.running.footfall(footfall).err();
        }
    }

    /// The file to publish.
    pub(super) fn finish(self) -> Result<Stream, CliError> {
        let Recorder {
            path,
            running,
            failed,
        } = self;
        let finished = failed.map_or_else(|| running.finish(), Err);
        finished.map_err(|error| unrecorded(&path, error))
    }
}
