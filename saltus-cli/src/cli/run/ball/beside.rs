//! What is written of the run of a ball beside its report: the page and the recording.

use std::path::{Path, PathBuf};

use saltus::gait::space::{Ball, Gait, Roll};
use saltus::recording::{Error, Origin, Recording, Rolling};

use super::film::{About, Film};
use crate::cli::recorded::{command, unrecorded};
use crate::error::CliError;
use crate::output::{Files, Stream};

/// What was asked for, filled as the run goes.
#[derive(Debug, Default)]
pub(super) struct Beside {
    film: Option<(PathBuf, Film)>,
    recorder: Option<Recorder>,
    line: Option<f64>,
}

/// A recording on its way to a file.
#[derive(Debug)]
struct Recorder {
    path: PathBuf,
    rolling: Rolling<Stream>,
    /// What went wrong first.
    failed: Option<Error>,
}

impl Beside {
    /// The page at `animate` and the recording at `mcap`, where they are asked for, of the run `setup`: it is told how often
    /// they need the forces on the feet. `seed` is that of the noise.
    pub(super) fn open(
        animate: Option<&Path>,
        mcap: Option<&Path>,
        seed: u64,
        setup: &mut Roll,
    ) -> Result<Beside, CliError> {
        let line = match &setup.gait {
            Gait::Stable(stable) => Some(stable.line),
            Gait::Disc(_) => None,
        };
        let film = animate.map(|path| (path.to_owned(), Film::new(setup)));
        if let Some((_, film)) = &film {
            setup.forces_every = film.every();
        }
        if mcap.is_some() {
            setup.forces_every = 1;
        }
        let recorder = mcap.map(|path| Recorder::open(path, seed, setup));
        Ok(Beside {
            film,
            recorder: recorder.transpose()?,
            line,
        })
    }

    /// Takes a cycle.
    pub(super) fn push(&mut self, ball: &Ball) {
        if let Some((_, film)) = &mut self.film {
            film.push(ball, self.line);
        }
        if let Some(recorder) = self.recorder.as_mut().filter(|it| it.failed.is_none()) {
            recorder.failed = recorder.rolling.row(ball).err();
        }
    }

    /// Whether the files still take what comes.
    pub(super) fn is_open(&self) -> bool {
        let recorder = self.recorder.as_ref();
        recorder.is_none_or(|recorder| recorder.failed.is_none())
    }

    /// Puts what it has into `files`; the page says of the run of `setup` what its title and its end are, and whether it
    /// came to the end.
    pub(super) fn add_to(
        self,
        files: &mut Files,
        setup: &Roll,
        (title, ended, rolled): (String, String, bool),
    ) -> Result<(), CliError> {
        if let Some((path, film)) = self.film {
            let about = About {
                title,
                ended,
                rolled,
                line: self.line,
            };
            let html = film.page(&setup.robot, &about);
            files.add("--animate", &path, html.into_bytes());
        }
        if let Some(recorder) = self.recorder {
            files.written(recorder.finish()?)?;
        }
        Ok(())
    }
}

impl Recorder {
    fn open(path: &Path, seed: u64, setup: &Roll) -> Result<Recorder, CliError> {
        let stream = Stream::open("--mcap", path)?;
        let command = command();
        let origin = Origin {
            command: &command,
            seed: Some(seed),
            robot: Some(&setup.robot),
        };
        let rolling =
            Recording::new(stream, &origin).and_then(|recording| Rolling::new(recording, setup));
        Ok(Recorder {
            path: path.into(),
            rolling: rolling.map_err(|error| unrecorded(path, error))?,
            failed: None,
        })
    }

    /// The file to publish.
    fn finish(self) -> Result<Stream, CliError> {
        let finished = self.failed.map_or_else(|| self.rolling.finish(), Err);
        finished.map_err(|error| unrecorded(&self.path, error))
    }
}
