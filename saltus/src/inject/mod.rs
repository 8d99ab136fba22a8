//! Synthetic data with hidden effects: what `saltus diagnose` can be tried on before there are
//! measurements.
//!
//! Hops, jumps, outcomes and runs are motions of the multi-body simulation; the other kinds are what the
//! model of their kind says of rows that are laid out here. Noise and counts are those of real
//! instruments, and the experiment says them.
//!
//! ```
//! use saltus::Robot;
//! use saltus::experiment::Sort;
//! use saltus::inject::{Effect, Request, make};
//!
//! let robot = Robot::rats_planar();
//! let effects: Vec<Effect> = vec!["coulomb-friction=25".parse()?];
//! let made = make(&Request { kind: Sort::Bench, robot: Some(&robot), effects: &effects, seed: 1, runs: Some(3), asked: &[] })?;
//! assert_eq!(made.experiment.runs.len(), 3);
//! assert_eq!(made.truth[0].parameters, [("leg.coulomb_friction_n".to_owned(), 25.0)]);
//! # Ok::<(), saltus::inject::Error>(())
//! ```

mod effect;
mod firing;
mod running;

use saltus_diagnosis::kinds::{self, Problem};
use saltus_diagnosis::layout::{Draw, Layout};
use saltus_diagnosis::spec::Source;
use saltus_diagnosis::{Experiment, Kind, Sort, Terms};
use saltus_robot::Robot;

pub use effect::Effect;

/// What data are wanted.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// Of which kind.
    pub kind: Sort,
    /// The robot that the operator believes in; the kinds bench to outcomes need one.
    pub robot: Option<&'a Robot>,
    /// What is hidden in them.
    pub effects: &'a [Effect],
    /// Seed of all that is drawn.
    pub seed: u64,
    /// How many runs (of outcomes: rows), ≥ 1; none: as many as is usual.
    pub runs: Option<usize>,
    /// What is asked of each jump, of the kinds jump and outcomes; empty: drawn.
    pub asked: &'a [Asked],
}

/// What is asked of a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Approach rate (rad/s) at the firing angle.
    pub rate: f64,
    /// Firing angle (rad).
    pub firing_angle: f64,
    /// Valve opening time (s).
    pub valve_open: f64,
    /// Gauge pressure of the supply (Pa); none: the robot's.
    pub supply: Option<f64>,
}

/// Data, and what is hidden in them.
#[derive(Clone, Debug)]
pub struct Made {
    /// The data.
    pub experiment: Experiment,
    /// The effects, in the order of the request.
    pub truth: Vec<Truth>,
}

/// An effect that is hidden in data.
#[derive(Clone, Debug, PartialEq)]
pub struct Truth {
    /// Its id.
    pub id: &'static str,
    /// The column that it is about, if it is about one.
    pub column: Option<String>,
    /// Its parameters: names and values.
    pub parameters: Vec<(String, f64)>,
}

impl Truth {
    /// What it is, and where: the column or the part of the machine that it is about. Another form of
    /// an effect of one part is the same.
    fn place(&self) -> (&str, Option<&String>, Option<&str>) {
        let name = self
            .parameters
            .first()
            .and_then(|(name, _)| name.split_once('.'));
        (self.id, self.column.as_ref(), name.map(|(part, _)| part))
    }
}

/// Why there are no such data.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// Words that are no effect.
    #[error(
        "{text:?} is no effect: must be CAUSE=VALUE or CAUSE=NAME:VALUE; several values with commas"
    )]
    Words {
        /// The words.
        text: String,
    },
    /// The kind has no such cause.
    #[error("{effect}: data of kind {kind} have no such effect; known are\n{known}")]
    Cause {
        /// The effect as it was asked for.
        effect: String,
        /// The kind's name.
        kind: &'static str,
        /// Every cause with its parameters.
        known: String,
    },
    /// A value that the effect cannot have.
    #[error("{effect}: must be {allowed}")]
    Value {
        /// The effect as it was asked for.
        effect: String,
        /// What is allowed.
        allowed: String,
    },
    /// One effect twice.
    #[error("{effect}: is asked for twice")]
    Twice {
        /// The effect as it was asked for.
        effect: String,
    },
    /// A robot that does not do what is measured.
    #[error(
        "with these effects the robot makes {made} of {wanted} motions: at least {least} must be \
         there to measure"
    )]
    NoMotion {
        /// Motions that there are.
        made: usize,
        /// Motions that were wanted.
        wanted: usize,
        /// Fewest.
        least: usize,
    },
    /// A robot that runs without an instrument of its height.
    #[error(
        "data of kind run need the height of the axle, which only the pivot of a boom measures, and {robot} \
         has no boom: take a robot with one, as rats-run, or another kind, as jump"
    )]
    NoBoom {
        /// The robot's name.
        robot: String,
    },
    /// Kind and robot do not go together.
    #[error(transparent)]
    Robot(#[from] Problem),
}

/// Every effect that data of `kind` can have, one a line: how it is asked for, its values without
/// it, and their range.
///
/// # Errors
/// [`Error`] where kind and robot do not go together.
pub fn known(kind: Sort, robot: Option<&Robot>) -> Result<String, Error> {
    let mut layout = Layout::of((kind, robot), true, Some(1), &mut Draw::new(0));
    if let (Sort::Run, Some(robot)) = (kind, robot) {
        running::fill(&mut layout, robot, robot, 0)?;
    }
    Ok(effect::known(
        kinds::build(&layout.experiment, robot)?.as_ref(),
        kind,
    ))
}

/// Data with hidden effects; the same for the same request.
///
/// # Errors
/// [`Error`] for an effect that the kind does not have, or under which there is no motion to
/// measure.
pub fn make(request: &Request<'_>) -> Result<Made, Error> {
    let &Request {
        kind,
        robot,
        effects,
        seed,
        runs,
        asked,
    } = request;
    let mut draw = Draw::new(seed);
    let on_boom = effects.iter().any(|effect| effect.id == "counterweight");
    let runs = runs.or(Some(asked.len()).filter(|count| *count > 0));
    let mut layout = Layout::of((kind, robot), on_boom, runs, &mut draw);
    if let (Sort::Run, Some(robot)) = (kind, robot) {
        // Which strides there are says a run without an effect.
        running::fill(&mut layout, robot, robot, seed)?;
    }
    let model = kinds::build(&layout.experiment, robot)?;
    let mut terms = Terms::off(model.causes());
    let mut truth: Vec<Truth> = Vec::new();
    for asked in effects {
        let known = || known(kind, robot).unwrap_or_default();
        let (cause, values) = effect::resolve(model.as_ref(), asked, kind, known)?;
        for (p, value) in values.iter().enumerate() {
            terms.set(cause, p, *value);
        }
        let spec = &model.causes()[cause];
        let found = Truth {
            id: spec.id,
            column: spec.column.clone(),
            parameters: model.causes()[cause].report(&values),
        };
        if truth.iter().any(|other| other.place() == found.place()) {
            return Err(Error::Twice {
                effect: asked.to_string(),
            });
        }
        truth.push(found);
    }
    match kind.spec().synthesis.source {
        Source::Robot if kind == Sort::Run => {
            let robot = robot.ok_or(Problem::NoRobot)?;
            let hidden = model.robot(&terms).ok_or(Problem::NoRobot)?;
            running::fill(&mut layout, robot, &hidden, seed)?;
            let sensor = |column: &str| firing::sensor(model.as_ref(), column, &terms);
            running::sensed(&mut layout.experiment, sensor);
            return Ok(Made {
                experiment: layout.experiment,
                truth,
            });
        }
        Source::Robot => {
            let robot = robot.ok_or(Problem::NoRobot)?;
            firing::fill(&mut layout, robot, &terms, asked, &mut draw)?;
        }
        Source::Model => predicted(&mut layout, model.as_ref(), &terms)?,
    }
    layout.read(&mut draw);
    Ok(Made {
        experiment: layout.experiment,
        truth,
    })
}

/// The cause of `kind`, data of `sort`, that an effect asks for, and the values of its parameters as
/// the model takes them.
///
/// # Errors
/// [`Error`] for an effect that the kind does not have.
pub(crate) fn effect_of(
    kind: &dyn Kind,
    asked: &Effect,
    sort: Sort,
    robot: Option<&Robot>,
) -> Result<(usize, Vec<f64>), Error> {
    let known = || known(sort, robot).unwrap_or_default();
    effect::resolve(kind, asked, sort, known)
}

/// Fills the measured columns of every run with what the model says.
fn predicted(layout: &mut Layout, model: &dyn Kind, terms: &Terms) -> Result<(), Error> {
    let wanted = layout.experiment.runs.len();
    for run in 0..wanted {
        let values = model.predict(run, terms, &layout.unknowns[run]);
        let values = values.ok_or(Error::NoMotion {
            made: run,
            wanted,
            least: wanted,
        })?;
        let mut rows = vec![0; model.channels().len()];
        for (reading, value) in model.logs()[run].readings.iter().zip(values) {
            let column = layout.column(&model.channels()[reading.channel].name);
            layout.experiment.runs[run].values[column][rows[reading.channel]] = value;
            rows[reading.channel] += 1;
        }
    }
    Ok(())
}
