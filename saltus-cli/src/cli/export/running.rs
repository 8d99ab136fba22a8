//! `saltus export c --gait`: what decides on a running robot.

use clap::builder::PossibleValue;
use clap::{Args, ValueEnum};
use saltus::Robot;
use saltus::export::{CFiles, Number};
use saltus::gait::space::{Stable, Steered};
use saltus::gait::{Program, Setup};

use crate::cli::common::note_valve;
use crate::cli::refused::refused;
use crate::cli::run::{Kind, LawFlags};
use crate::error::CliError;

/// A gait that a robot's own processor knows.
#[derive(Clone, Copy, Debug)]
struct Flashed(Kind);

impl ValueEnum for Flashed {
    fn value_variants<'a>() -> &'a [Flashed] {
        &[
            Flashed(Kind::Fixed),
            Flashed(Kind::OpenLoop),
            Flashed(Kind::ClosedLoop),
            Flashed(Kind::Curve),
            Flashed(Kind::Smooth),
            Flashed(Kind::Speed),
            Flashed(Kind::DiscStable),
            Flashed(Kind::Steer),
        ]
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        self.0.to_possible_value()
    }
}

/// How a robot runs.
#[derive(Args, Debug)]
#[command(next_help_heading = "Gait")]
pub(super) struct RunningFlags {
    /// Write what decides on a running robot, in place of tables of jumps; of `speed` saltus_runner_demand sets the speed
    #[arg(long, value_enum, value_name = "GAIT", conflicts_with_all = ["distance", "omega", "alpha_f", "landing_height",
        "start_lean", "valve_range", "newton", "extra_delay", "tolerance", "plant",
        "plant_overrides"])]
    gait: Option<Flashed>,

    #[command(flatten)]
    law: LawFlags,
}

impl RunningFlags {
    /// What is written for a ball, if one is asked for; its valves' times are its gait's own, without `valve_open`.
    pub(super) fn ball<R: Number>(
        &self,
        robot: impl FnOnce() -> Result<Robot, CliError>,
        valve_open: Option<f64>,
    ) -> Result<Option<CFiles>, CliError> {
        let Some(Flashed(gait @ (Kind::DiscStable | Kind::Steer))) = self.gait else {
            return Ok(None);
        };
        self.law.meant(Some(gait), valve_open.is_some())?;
        let robot = robot()?;
        let written = if gait == Kind::Steer {
            CFiles::steered::<R>(&robot, &Steered::towards(0.0))
        } else {
            CFiles::stable::<R>(&robot, &Stable::default())
        };
        let wrong = |error| CliError::content(&robot.name, error);
        written.map(Some).map_err(wrong)
    }

    /// What is written for a robot whose valve opens for `valve_open` (s), if a gait is asked for; speeds
    /// are measured on so many `threads`.
    pub(super) fn written<R: Number>(
        &self,
        robot: impl FnOnce() -> Result<Robot, CliError>,
        valve_open: Option<f64>,
        threads: usize,
    ) -> Result<Option<CFiles>, CliError> {
        let gait = self.gait.map(|gait| gait.0);
        self.law
            .meant(gait, gait.is_some() && valve_open.is_some())?;
        let Some(gait) = gait else {
            return Ok(None);
        };
        let robot = robot()?;
        note_valve(&robot, valve_open.map(|_| "--valve-open"));
        let (program, zone) = self.law.found(gait, &robot, threads)?;
        let mut setup = match program {
            Program::Curve(law) if gait == Kind::Speed => {
                Setup::holding(&robot, law, &[], 1.0).map_err(|error| refused(error, &robot))?
            }
            program => Setup::new(robot, program, 1.0),
        };
        setup.zone = zone;
        setup.taps = self.law.taps();
        setup.valve_open = valve_open.unwrap_or(setup.valve_open);
        let written = CFiles::running::<R>(&setup).map(Some);
        written.map_err(|error| CliError::content(&setup.robot.name, error))
    }
}
