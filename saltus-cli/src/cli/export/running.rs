//! `saltus export gait`: what decides on a running robot.

use std::ffi::OsString;

use clap::{Args, Subcommand};
use saltus::export::{CFiles, Number};
use saltus::gait::space::{Stable, Steered};

use super::{Real, Written};
use crate::cli::Status;
use crate::cli::common::{OutFolder, RobotFlags};
use crate::cli::refused::refused;
use crate::cli::run::{Law, Senses, refused_gait};
use crate::cli::with::With;
use crate::error::CliError;

/// Write what decides on a robot that runs or rolls as C99, headers and a source
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus export gait --help` explains the files.",
    after_long_help = HELP,
    subcommand_value_name = "GAIT",
    subcommand_help_heading = "Gaits"
)]
pub(super) struct OfGait {
    #[command(subcommand)]
    gait: With<Flashed, GaitFlags>,
}

/// A gait that a robot's own processor knows.
#[derive(Debug, Subcommand)]
enum Flashed {
    #[command(flatten)]
    Law(With<Law, Senses>),
    /// A speed is held, which saltus_runner_demand sets: the speed of each firing angle is measured first
    Speed(Senses),
    /// A robot in space rolls in one plane, by its sensors
    DiscStable,
    /// A robot in space follows a path
    Steer,
}

#[derive(Args, Debug)]
#[command(after_help = "`saltus export gait --help` explains the files.")]
struct GaitFlags {
    #[command(flatten)]
    real: Real,

    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    out: OutFolder,
}

const HELP: &str = "\
Examples:
  saltus export gait closed-loop --out firmware/src
  saltus export gait curve --knots 0:0.35:40ms,13.3:-0.1:40ms --real double --out firmware/src
  saltus export gait disc-stable --robot rats-twelve --out firmware/src

The files are saltus_running.h, saltus_running.c and running_tables.h; of a robot in space saltus_ball.h, saltus_ball.c and ball_tables.h. \
What is printed also heads them. C99, IEEE 754, no allocation; compile with -ffp-contract=off (or -std=c99), link with -lm.

saltus_runner_step says each cycle whether a leg fires, from the counts of encoder and gyros, and saltus_rear_leg on which two \
feet the robot stands. running_tables.h has the constants: law, zone, legs, and what a count is, from the robot's [sensors]. \
The valve opens for 40 ms unless --valve-open says otherwise. docs/controller.md has a program.

With disc-stable, of rats-twelve unless --robot names another, saltus_estimator_take makes attitude, rates and way of a robot in space of its gyros, accelerometers and foot \
switches, and saltus_balancer_step says each cycle which legs fire. ball_tables.h has the constants: ball_senses, ball_balance, and all \
planes in which the robot can roll, ball_planes. With steer also ball_lead, for saltus_pilot_start and saltus_pilot_step, \
which lead along a path. Angles of stations are rounded to 1e-12 rad, so that the files are the same on every \
machine. controller/examples/ball.c is a control loop.";

/// That the words of a line name no gait that can be exported.
pub(crate) fn without_gait(words: &[OsString]) -> Option<CliError> {
    let [export, gait, word, ..] = words else {
        return None;
    };
    let all = Flashed::augment_subcommands(clap::Command::new("gait"));
    let is_asked = export == "export" && gait == "gait";
    is_asked.then(|| {
        refused_gait(
            ("export gait", &all),
            word,
            "export gait closed-loop --out DIR",
        )
    })?
}

impl OfGait {
    pub(super) fn run(self) -> Result<Status, CliError> {
        self.gait.flags.out.ready()?;
        self.gait.flags.real.write(&self)
    }
}

impl Written for OfGait {
    fn write<R: Number>(&self) -> Result<Status, CliError> {
        let With { of, flags, .. } = &self.gait;
        let written = match of {
            Flashed::Law(With {
                of, flags: senses, ..
            }) => running::<R>(of, senses, flags)?,
            Flashed::Speed(senses) => running::<R>(&Law::Speed(Vec::new()), senses, flags)?,
            Flashed::DiscStable | Flashed::Steer => {
                let robot = flags.robot.any_robot_or("rats-twelve")?;
                let written = match of {
                    Flashed::Steer => CFiles::steered::<R>(&robot, &Steered::towards(0.0)),
                    _ => CFiles::stable::<R>(&robot, &Stable::default()),
                };
                written.map_err(|error| CliError::content(&robot.name, error))?
            }
        };
        flags.out.write(written.files, &written.about)?;
        Ok(Status::Done)
    }
}

/// The files of a robot in its plane.
fn running<R: Number>(law: &Law, senses: &Senses, flags: &GaitFlags) -> Result<CFiles, CliError> {
    let robot = flags.robot.robot_or("rats-run")?;
    let setup = law.setup(robot, senses, 1.0)?;
    let written = CFiles::running::<R>(&setup);
    written.map_err(|error| refused(error, &setup.robot, law.angles()))
}
