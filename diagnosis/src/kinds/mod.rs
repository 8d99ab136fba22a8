//! The kinds of experiments. Each has a file of its own, with its [`Spec`]; beside it a
//! new one takes two lines here, and one of [`Sort`].

mod bench;
mod flight;
mod hop;
mod input;
mod jump;
mod machine;
mod outcomes;
mod pendulum;
mod robot;
mod run;
mod slide;
mod stroke;
mod tank_leg;
mod vessel;
mod walk;

pub use flight::Flights;
pub use machine::Motions;
pub use pendulum::Pendulums;
pub use robot::Firings;
pub use run::Strides;
pub use slide::Slides;
pub use stroke::Strokes;
pub use tank_leg::Flights as TankLegs;
pub use vessel::Vessels;

use saltus_robot::Robot;

use crate::experiment::{Experiment, Sort};
use crate::kind::{Cause, Kind, Parameter, Terms};
pub use crate::spec::Problem;
use crate::spec::Spec;

/// The registry: each kind with its file.
macro_rules! kinds {
    ($($name:ident: $file:ident;)+) => {
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
    Bench: bench;
    Hop: hop;
    Jump: jump;
    Flight: flight;
    Outcomes: outcomes;
    Stroke: stroke;
    Slide: slide;
    Vessel: vessel;
    Pendulum: pendulum;
    Run: run;
    TankLeg: tank_leg;
    Walk: walk;
    Machine: machine;
}

impl Sort {
    /// The kind that files and the command line call `id`.
    pub fn named(id: &str) -> Option<Sort> {
        Sort::ALL.into_iter().find(|sort| sort.spec().id == id)
    }
}

/// The model of an experiment, of `robot` where it is one with a robot.
///
/// # Errors
/// [`Problem`] where data and robot do not go together.
pub fn build(experiment: &Experiment, robot: Option<&Robot>) -> Result<Box<dyn Kind>, Problem> {
    (experiment.kind.spec().model)(experiment, robot)
}

/// Causes, each with the effect that it has in the model of its kind.
#[derive(Clone, Debug)]
struct Causes<E> {
    effects: Vec<E>,
    list: Vec<Cause>,
}

impl<E: Copy + PartialEq> Causes<E> {
    fn new(all: impl IntoIterator<Item = (E, Cause)>) -> Causes<E> {
        let (effects, list) = all.into_iter().unzip();
        Causes { effects, list }
    }

    /// Parameter `p` of an effect; none where the experiment has no such cause.
    fn get(&self, effect: E, p: usize, terms: &Terms) -> Option<f64> {
        let cause = self.effects.iter().position(|own| *own == effect)?;
        Some(terms.get(cause, p))
    }

    /// The first parameter of an effect; `none` where the experiment has no such cause.
    fn or(&self, effect: E, none: f64, terms: &Terms) -> f64 {
        self.get(effect, 0, terms).unwrap_or(none)
    }
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
    let mut cause = simple(id, name, neutral, bounds, scale, starts);
    cause.column = Some(column.into());
    if id == "encoder-scale" {
        cause = cause.usual(0.05, "sensors are calibrated");
    }
    cause
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
