//! A run as an MCAP file, written as it goes.

use std::path::{Path, PathBuf};

use saltus::Robot;
use saltus::recording::{Error, Origin, Recording};

use crate::cli::recorded::{command, unrecorded};
use crate::error::CliError;
use crate::output::Stream;

/// A run on its way to a file, as a recording `R`.
#[derive(Debug)]
pub(super) struct Recorder<R> {
    path: PathBuf,
    recording: R,
    /// What went wrong first.
    failed: Option<Error>,
}

impl<R> Recorder<R> {
    /// A recording of `robot`, as `begin` begins it, in the file at `path`. `seed` is that of all that is drawn.
    pub(super) fn open(
        path: &Path,
        (robot, seed): (&Robot, u64),
        begin: impl FnOnce(Recording<Stream>) -> Result<R, Error>,
    ) -> Result<Recorder<R>, CliError> {
        let stream = Stream::open("--mcap", path)?;
        let command = command();
        let origin = Origin {
            command: &command,
            seed: Some(seed),
            robot: Some(robot),
        };
        let recording = Recording::new(stream, &origin).and_then(begin);
        Ok(Recorder {
            path: path.into(),
            recording: recording.map_err(|error| unrecorded(path, error))?,
            failed: None,
        })
    }

    /// Whether the file still takes what comes.
    pub(super) fn is_open(&self) -> bool {
        self.failed.is_none()
    }

    /// Adds what `add` writes.
    pub(super) fn add(&mut self, add: impl FnOnce(&mut R) -> Result<(), Error>) {
        if self.failed.is_none() {
            self.failed = add(&mut self.recording).err();
        }
    }

    /// The file to publish, once `finish` has ended the recording.
    pub(super) fn finish(
        self,
        finish: impl FnOnce(R) -> Result<Stream, Error>,
    ) -> Result<Stream, CliError> {
        let finished = self.failed.map_or_else(|| finish(self.recording), Err);
        finished.map_err(|error| unrecorded(&self.path, error))
    }
}
