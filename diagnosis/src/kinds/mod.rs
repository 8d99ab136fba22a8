//! The kinds of experiments. Each has a file of its own, with its [`Spec`]; its line here is all
//! else that a new one takes.

mod robot;

pub use flight::Flights;
pub use pendulum::Pendulums;
pub use robot::Firings;
pub use slide::Slides;
pub use stroke::Strokes;
pub use vessel::Vessels;

use saltus_robot::Robot;

use crate::experiment::Experiment;
use crate::kind::{Cause, Kind, Parameter};
use crate::spec::Spec;

/// The kinds, each with its name in the program and its file.
macro_rules! kinds {
    ($($(#[$about:meta])+ $name:ident: $file:ident;)+) => {
        $(mod $file;)+

        /// A kind of experiment: what was done.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
        pub enum Sort {
            $($(#[$about])+ $name,)+
        }

        impl Sort {
            /// All kinds, in the order of messages.
            pub const ALL: [Sort; [$(Sort::$name),+].len()] = [$(Sort::$name),+];

            /// What it says of itself.
            pub fn spec(self) -> &'static Spec {
                match self {
                    $(Sort::$name => const { &$file::SPEC },)+
                }
            }
        }
    };
}

kinds! {
    /// One cylinder upright, fired once from rest under a dead load.
    Bench: bench;
    /// The robot at rest, upright on one leg, fired once.
    Hop: hop;
    /// From just after touch-down of the jumping leg, through the flight.
    Jump: jump;
    /// A body in free flight or fall, or a robot in flight at the end of a boom.
    Flight: flight;
    /// One row a jump: what was asked for and where it went.
    Outcomes: outcomes;
    /// A piston moved slowly back and forth under regulated pressure.
    Stroke: stroke;
    /// A mass on a guide, driven by a measured force.
    Slide: slide;
    /// A vessel filling or discharging through an orifice.
    Vessel: vessel;
    /// A part, or the robot with its legs retracted, swinging about a fixed axis.
    Pendulum: pendulum;
}

impl Sort {
    /// The kind that files and the command line call `id`.
    pub fn named(id: &str) -> Option<Sort> {
        Sort::ALL.into_iter().find(|sort| sort.spec().id == id)
    }
}

/// Why an experiment has no model.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Problem {
    /// The kind is about a robot.
    #[error("data of this kind need the robot that was measured")]
    NoRobot,
    /// The bench fires a pneumatic leg.
    #[error("the leg of robot {robot} is not pneumatic, which data of kind bench need")]
    NotPneumatic {
        /// Its name.
        robot: String,
    },
    /// A column is about a boom.
    #[error(
        "robot {robot} has no boom, whose {column} the data have: is it the robot that was \
         measured? Of a robot without a boom x_m and y_m of the axle may be given, beside \
         wheel_angle_rad and wheel_rate_rad_s"
    )]
    NoBoom {
        /// Its name.
        robot: String,
        /// The column.
        column: String,
    },
}

/// The model of an experiment, of `robot` where it is one with a robot.
///
/// # Errors
/// [`Problem`] where data and robot do not go together.
pub fn build(experiment: &Experiment, robot: Option<&Robot>) -> Result<Box<dyn Kind>, Problem> {
    (experiment.kind.spec().model)(experiment, robot)
}

/// A cause with one parameter.
fn simple(
    id: &'static str,
    name: &str,
    neutral: f64,
    bounds: (f64, f64),
    scale: f64,
    starts: &[f64],
) -> Cause {
    Cause::one(
        id,
        Parameter {
            name: name.into(),
            neutral,
            bounds,
            scale,
            starts: starts.to_vec(),
        },
    )
}

/// The error of a column.
fn sensor(
    id: &'static str,
    column: &str,
    name: &str,
    neutral: f64,
    bounds: (f64, f64),
    scale: f64,
    starts: &[f64],
) -> Cause {
    let usual = (id == "encoder-scale").then_some(0.05);
    Cause {
        column: Some(column.into()),
        usual,
        ..simple(id, name, neutral, bounds, scale, starts)
    }
}

/// An unknown of a run, free but for `bounds`.
fn unknown(name: &str, neutral: f64, bounds: (f64, f64), scale: f64) -> Parameter {
    Parameter {
        name: name.into(),
        neutral,
        bounds,
        scale,
        starts: Vec::new(),
    }
}

/// Any number.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
