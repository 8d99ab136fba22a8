//! `saltus export`: a robot, or what it is to do, as other programs take it.

mod policy;
pub(crate) mod running;
mod tables;

use clap::{Args, Subcommand, ValueEnum};
use saltus::Robot;
use saltus::export::Number;
use saltus::sim_check::{self, SimError};

use super::Status;
use super::common::{OutFile, RobotFlags};
use crate::error::CliError;

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
    Gait(running::OfGait),
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

    #[command(flatten)]
    out: OutFile,
}

/// Write the robot as URDF, for RViz, Foxglove, Drake, Pinocchio and others
#[derive(Args, Debug)]
#[command(after_help = "`saltus export urdf --help` explains the file.", after_long_help = URDF_HELP)]
struct Urdf {
    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    out: OutFile,
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

/// Numbers of a controller.
#[derive(Args, Clone, Copy, Debug)]
struct Real {
    /// Numbers to compute with
    #[arg(long, value_enum, default_value_t = RealType::Float)]
    real: RealType,
}

/// Which numbers a controller computes with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum RealType {
    /// 32 bits: float, f32.
    Float,
    /// 64 bits: double, f64.
    Double,
}

/// What is written in a controller's numbers.
trait Written {
    fn write<R: Number>(&self) -> Result<Status, CliError>;
}

impl Real {
    fn write(self, what: &impl Written) -> Result<Status, CliError> {
        match self.real {
            RealType::Float => what.write::<f32>(),
            RealType::Double => what.write::<f64>(),
        }
    }
}

impl Export {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        match self.target {
            Target::C(command) => command.run(),
            Target::Rust(command) => command.run(),
            Target::Gait(command) => command.run(),
            Target::Policy(command) => command.run(),
            Target::Mjcf(Mjcf { robot, out }) => written(&robot, &out, sim_check::mjcf),
            Target::Urdf(Urdf { robot, out }) => written(&robot, &out, sim_check::urdf),
        }
    }
}

/// Writes a robot as `write` does.
fn written(
    robot: &RobotFlags,
    out: &OutFile,
    write: fn(&Robot) -> Result<String, SimError>,
) -> Result<Status, CliError> {
    out.ready()?;
    out.write(write(&robot.any_robot()?)?)?;
    Ok(Status::Done)
}
