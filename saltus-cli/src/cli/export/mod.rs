//! `saltus export`: a robot, or what it is to do, as other programs take it.

mod running;
mod tables;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use saltus::sim_check;

use super::Status;
use super::common::RobotFlags;
use crate::error::CliError;
use crate::output::Files;

/// Write the robot for another program: a controller in C or Rust, or a MuJoCo model
#[derive(Args, Debug)]
pub(crate) struct Export {
    #[command(subcommand)]
    target: Target,
}

#[derive(Debug, Subcommand)]
enum Target {
    C(tables::C),
    Rust(tables::Rust),
    Mjcf(Mjcf),
}

/// Write the robot as MJCF, the model files of the simulator MuJoCo
#[derive(Args, Debug)]
#[command(after_help = "`saltus export mjcf --help` explains the file.", after_long_help = MJCF_HELP)]
struct Mjcf {
    #[command(flatten)]
    robot: RobotFlags,

    /// Write to this file instead of standard output
    #[arg(long, short, value_name = "FILE", help_heading = "Robot and output")]
    out: Option<PathBuf>,
}

const MJCF_HELP: &str = "\
Examples:
  saltus export mjcf --robot rats-boom --out rats-boom.xml
  saltus export mjcf --robot rats-boom --set ground.static_friction=0.8 > slippery.xml
  python -m mujoco.viewer --mjcf=rats-boom.xml

The file has the bodies of the multi-body simulation, in SI units and radians: the wheel, free in its \
plane or at the end of its boom, its legs on slides with end stops, viscous and Coulomb friction, and the \
ground with the feet's friction. Coordinates are those of the simulation: travel and height of the axle (m), \
or turn and pivot of the boom (rad; and its bend), then the lean (rad), then each leg's extension (m).

Names: joints travel, height, or boom_turn, boom; wheel (the lean), leg_0 to leg_N; motors leg_K, whose \
control is the force of the drive (N); equalities latch_K, which hold a leg retracted until made inactive; \
sensors JOINT_position, JOINT_velocity, axle_position, axle_velocity, axle_gyro, foot_K_force; keyframe stand.

The gas in the legs is not in the file: MuJoCo has no such law, and the motor's force is set by its user. \
A comment at the head of the file lists what else of this robot MuJoCo does not express.";

impl Export {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        match self.target {
            Target::C(command) => command.run(),
            Target::Rust(command) => command.run(),
            Target::Mjcf(command) => command.run(),
        }
    }
}

impl Mjcf {
    fn run(self) -> Result<Status, CliError> {
        let model = sim_check::mjcf(&self.robot.robot()?)?;
        let mut files = Files::default();
        files.report(self.out.as_deref(), model);
        files.write()?;
        Ok(Status::Done)
    }
}
