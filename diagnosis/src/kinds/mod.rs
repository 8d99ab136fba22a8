//! The kinds of experiments.

mod flight;
mod robot;
mod slide;
mod stroke;
mod vessel;

pub use flight::Flights;
pub use robot::Firings;
pub use slide::Slides;
pub use stroke::Strokes;
pub use vessel::Vessels;

use saltus_robot::Robot;

use crate::experiment::{Experiment, Sort};
use crate::kind::{Cause, Kind, Parameter};

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
    Ok(match experiment.kind {
        Sort::Bench | Sort::Hop | Sort::Jump | Sort::Outcomes => {
            Box::new(Firings::new(experiment, robot.ok_or(Problem::NoRobot)?)?)
        }
        Sort::Flight => Box::new(Flights::new(
            experiment,
            robot.map_or(9.80665, |r| r.environment.gravity),
        )),
        Sort::Stroke => Box::new(Strokes::new(experiment)),
        Sort::Slide => Box::new(Slides::new(experiment)),
        Sort::Vessel => Box::new(Vessels::new(experiment)),
    })
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
