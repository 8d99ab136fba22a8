//! What is written of the run of a ball beside its report: the page, the recording and the folder of telemetry.

use std::path::PathBuf;

use saltus::gait::space::{Ball, Measured, Roll};
use saltus::recording::Rolling;

use super::film::{About, Film};
use super::{header, write};
use crate::cli::run::RunFlags;
use crate::cli::run::recorder::Recorder;
use crate::cli::run::telemetry::Telemetry;
use crate::error::CliError;
use crate::output::{Files, Stream};

/// What was asked for, filled as the run goes.
#[derive(Debug)]
pub(super) struct Beside {
    film: Option<(PathBuf, Film)>,
    recorder: Option<Recorder<Rolling<Stream>>>,
    telemetry: Option<(Telemetry, Measured)>,
}

impl Beside {
    /// What `run` asks for of the run `setup`, which is told how often the forces on the feet are needed.
    pub(super) fn open(run: &RunFlags, setup: &mut Roll) -> Result<Beside, CliError> {
        let film = run.animate.clone().map(|path| (path, Film::new(setup)));
        if let Some((_, film)) = &film {
            setup.forces_every = film.every();
        }
        if run.mcap.path().is_some() {
            setup.forces_every = 1;
        }
        let (setup, robot) = (&*setup, &setup.robot);
        let recorder = run.mcap.path().map(|path| {
            let begin = |recording| Rolling::new(recording, setup);
            Recorder::open(path, (robot, run.seed), begin)
        });
        let telemetry = run.telemetry.as_deref().map(|folder| {
            let measured = Measured::new(robot.body.legs as usize);
            let columns = measured.columns().join(",");
            let telemetry = Telemetry::open(folder, header(robot), columns);
            telemetry.map(|telemetry| (telemetry, measured))
        });
        Ok(Beside {
            film,
            recorder: recorder.transpose()?,
            telemetry: telemetry.transpose()?,
        })
    }

    /// Takes a cycle.
    pub(super) fn push(&mut self, ball: &Ball) {
        if let Some((_, film)) = &mut self.film {
            film.push(ball);
        }
        if let Some(recorder) = &mut self.recorder {
            recorder.add(|rolling| rolling.row(ball));
        }
        if let Some((telemetry, measured)) = &mut self.telemetry {
            telemetry.cycle(|line| write(ball, line));
            telemetry.measured(ball.time, &measured.row(ball)[1..]);
        }
    }

    /// Whether the files still take what comes.
    pub(super) fn is_open(&self) -> bool {
        let telemetry = self.telemetry.as_ref().map(|(telemetry, _)| telemetry);
        self.recorder.as_ref().is_none_or(Recorder::is_open)
            && telemetry.is_none_or(Telemetry::is_open)
    }

    /// Puts the page and the recording of the run `setup` into `files`, and fills the folder of telemetry.
    pub(super) fn add_to(
        self,
        files: &mut Files,
        setup: &Roll,
        about: &About,
    ) -> Result<(), CliError> {
        if let Some((path, film)) = self.film {
            let html = film.page(setup, about);
            files.add("--animate", &path, html.into_bytes());
        }
        if let Some(recorder) = self.recorder {
            files.written(recorder.finish(Rolling::finish)?)?;
            files.check()?;
        }
        if let Some((telemetry, _)) = self.telemetry {
            telemetry.publish(&setup.robot, [])?;
        }
        Ok(())
    }
}
