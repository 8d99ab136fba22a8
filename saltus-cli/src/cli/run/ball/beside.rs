//! What is written of the run of a ball beside its report: the page, the recording and the folder of telemetry.

use std::path::{Path, PathBuf};

use saltus::gait::space::{Ball, Gait, Measured, Roll};
use saltus::recording::{Error, Origin, Recording, Rolling};

use super::film::{About, Film};
use super::{header, write};
use crate::cli::recorded::{command, unrecorded};
use crate::cli::run::rows::Rows;
use crate::cli::run::telemetry::{Telemetry, settings_in_space};
use crate::error::CliError;
use crate::output::{Files, Stream, full};

/// Where it is to go, each where it is asked for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places<'a> {
    /// The page.
    pub(super) animate: Option<&'a Path>,
    /// The recording.
    pub(super) mcap: Option<&'a Path>,
    /// The folder of telemetry.
    pub(super) telemetry: Option<&'a Path>,
}

/// What was asked for, filled as the run goes.
#[derive(Debug, Default)]
pub(super) struct Beside {
    film: Option<(PathBuf, Film)>,
    recorder: Option<Recorder>,
    log: Option<Log>,
    line: Option<f64>,
    seed: u64,
}

/// A recording on its way to a file.
#[derive(Debug)]
struct Recorder {
    path: PathBuf,
    rolling: Rolling<Stream>,
    /// What went wrong first.
    failed: Option<Error>,
}

/// A folder of telemetry that is filled.
#[derive(Debug)]
struct Log {
    folder: Telemetry,
    /// Every cycle, and what is measured in it.
    rows: [Rows; 2],
    measured: Measured,
}

/// What is said of the run at its end.
#[derive(Clone, Debug)]
pub(super) struct Said<'a> {
    pub(super) title: String,
    pub(super) ended: String,
    /// Whether it came to the end.
    pub(super) rolled: bool,
    /// The name of its gait.
    pub(super) gait: &'a str,
}

impl Beside {
    /// What goes to `places` of the run `setup`, which is told how often they need the forces on the feet. `seed` is that of
    /// the noise.
    pub(super) fn open(
        places: Places<'_>,
        seed: u64,
        setup: &mut Roll,
    ) -> Result<Beside, CliError> {
        let line = match &setup.gait {
            Gait::Stable(stable) => Some(stable.line),
            Gait::Disc(_) | Gait::Steered(_) => None,
        };
        let film = places
            .animate
            .map(|path| (path.to_owned(), Film::new(setup)));
        if let Some((_, film)) = &film {
            setup.forces_every = film.every();
        }
        if places.mcap.is_some() {
            setup.forces_every = 1;
        }
        let recorder = places.mcap.map(|path| Recorder::open(path, seed, setup));
        let log = places.telemetry.map(|folder| Log::open(folder, setup));
        Ok(Beside {
            film,
            recorder: recorder.transpose()?,
            log: log.transpose()?,
            line,
            seed,
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
        if let Some(log) = &mut self.log {
            log.push(ball);
        }
    }

    /// Whether the files still take what comes.
    pub(super) fn is_open(&self) -> bool {
        let recorder = self.recorder.as_ref();
        let mut rows = self.log.iter().flat_map(|log| &log.rows);
        recorder.is_none_or(|recorder| recorder.failed.is_none()) && rows.all(Rows::is_open)
    }

    /// Puts the page and the recording of the run `setup` into `files`, and fills the folder of telemetry.
    pub(super) fn add_to(
        self,
        files: &mut Files,
        setup: &Roll,
        said: Said<'_>,
    ) -> Result<(), CliError> {
        let gait = said.gait;
        if let Some((path, film)) = self.film {
            let about = About {
                title: said.title,
                ended: said.ended,
                rolled: said.rolled,
                line: self.line,
                path: match &setup.gait {
                    Gait::Steered(steered) => Some(steered.path.clone()),
                    Gait::Stable(_) | Gait::Disc(_) => None,
                },
            };
            let html = film.page(&setup.robot, &about);
            files.add("--animate", &path, html.into_bytes());
        }
        if let Some(recorder) = self.recorder {
            files.written(recorder.finish()?)?;
            files.check()?;
        }
        if let Some(log) = self.log {
            let settings = settings_in_space(setup, gait, self.seed);
            log.folder
                .publish_in_space(log.rows, &setup.robot, settings)?;
        }
        Ok(())
    }
}

impl Log {
    fn open(folder: &Path, setup: &Roll) -> Result<Log, CliError> {
        let folder = Telemetry::open(folder)?;
        let measured = Measured::new(setup.robot.body.legs as usize);
        let columns = measured.columns().join(",");
        Ok(Log {
            rows: folder.rows_in_space(header(&setup.robot), columns)?,
            folder,
            measured,
        })
    }

    fn push(&mut self, ball: &Ball) {
        let [cycles, measured] = &mut self.rows;
        cycles.line(|text| write(ball, text));
        let row = self.measured.row(ball);
        measured.line(|text| {
            for (k, x) in row.iter().enumerate() {
                if k > 0 {
                    text.push(',');
                }
                // What is not measured is an empty cell.
                if x.is_finite() {
                    text.push_str(&full(*x));
                }
            }
        });
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
