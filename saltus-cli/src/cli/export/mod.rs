//! `saltus export`: a robot, or what it is to do, as other programs take it.

mod policy;
mod running;
mod tables;

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use saltus::sim_check;

use super::Status;
use super::common::RobotFlags;
use crate::error::CliError;
use crate::output::{Files, reachable};

/// Write the robot for another program: a controller in C or Rust, a MuJoCo model, or URDF
#[derive(Args, Debug)]
pub(crate) struct Export {
    #[command(subcommand)]
    target: Target,
}

#[derive(Debug, Subcommand)]
enum Target {
    C(tables::C),
    Rust(tables::Rust),
    Policy(policy::Policy),
    Mjcf(Mjcf),
    Urdf(Urdf),
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

/// Write the robot as URDF, for RViz, Foxglove, Drake, Pinocchio and others
#[derive(Args, Debug)]
#[command(after_help = "`saltus export urdf --help` explains the file.", after_long_help = URDF_HELP)]
struct Urdf {
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

const URDF_HELP: &str = "\
Examples:
  saltus export urdf --robot rats-boom --out rats-boom.urdf
  python -m mujoco.viewer --mjcf=rats-boom.urdf

The file has the bodies of the multi-body simulation, in SI units and radians: a link and a joint for each, and a \
fixed link foot_K at the tip of each leg. Joints are those of `saltus export mjcf`, in the order and with the signs of \
the simulation's coordinates: travel and height of the axle (m), or boom_turn and boom (rad; and its bend), then wheel \
(the lean, rad), then leg_0 to leg_N (extension, m). Masses, moments of inertia, damping and dry friction are there.

URDF has no drives, no ground, no springs and no latches. A comment at the head of the file lists what of this robot \
is missing. docs/viewers.md shows the file in viewers, and says why robots are not read from URDF.";

impl Export {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        match self.target {
            Target::C(command) => command.run(),
            Target::Rust(command) => command.run(),
            Target::Policy(command) => command.run(),
            Target::Mjcf(command) => {
                file_ready(command.out.as_deref())?;
                let text = sim_check::mjcf(&command.robot.any_robot()?)?;
                written(text, command.out.as_deref())
            }
            Target::Urdf(command) => {
                file_ready(command.out.as_deref())?;
                let text = sim_check::urdf(&command.robot.any_robot()?)?;
                written(text, command.out.as_deref())
            }
        }
    }
}

/// Refuses a file `out` that cannot be written, before long work.
fn file_ready(out: Option<&Path>) -> Result<(), CliError> {
    let file = out.filter(|out| *out != Path::new("-"));
    reachable("--out", file)
}

/// Writes `text` to the file `out`, or to the screen.
fn written(text: String, out: Option<&Path>) -> Result<Status, CliError> {
    let mut files = Files::default();
    files.report(out, text);
    files.write()?;
    Ok(Status::Done)
}
