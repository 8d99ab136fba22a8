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
mod windows;

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
use crate::kind::{Cause, Data, Kind, Parameter, Terms};
use crate::sensor::Fault;
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
    let whole = (experiment.kind.spec().model)(experiment, robot)?;
    if !matches!(experiment.kind, Sort::Pendulum | Sort::Machine) {
        return Ok(whole);
    }
    Ok(Box::new(windows::Restarting {
        whole,
        experiment: experiment.clone(),
        robot: robot.cloned(),
    }))
}

/// The effect of each cause in the model of its kind; none for faults of sensors, which the engine
/// applies.
#[derive(Clone, Debug)]
struct Causes<E>(Vec<Option<E>>);

impl<E: Copy + PartialEq> Causes<E> {
    /// Puts causes, the listed ones and the terms without a name, into `data`.
    fn of(
        data: &mut Data,
        listed: Vec<(Option<E>, Cause)>,
        terms: Vec<(Option<E>, Cause)>,
    ) -> Causes<E> {
        data.listed = listed.len();
        let (effects, causes) = listed.into_iter().chain(terms).unzip();
        data.causes = causes;
        Causes(effects)
    }

    /// Parameter `p` of an effect; none where the experiment has no such cause.
    fn get(&self, effect: E, p: usize, terms: &Terms) -> Option<f64> {
        let cause = self.0.iter().position(|own| *own == Some(effect))?;
        Some(terms.get(cause, p))
    }

    /// The first parameter of an effect; `none` where the experiment has no such cause.
    fn or(&self, effect: E, none: f64, terms: &Terms) -> f64 {
        self.get(effect, 0, terms).unwrap_or(none)
    }

    /// Dry friction (N): the mean of both directions, and by how much friction forward exceeds that mean.
    /// The cause `both` adds the same friction to each direction, the cause `each` its own.
    fn friction(&self, both: E, each: E, terms: &Terms) -> [f64; 2] {
        let [forward, back] = [0, 1].map(|p| self.get(each, p, terms).unwrap_or(0.0));
        let mean = self.or(both, 0.0, terms) + 0.5 * (forward + back);
        [mean, 0.5 * (forward - back)]
    }
}

/// A table of causes: a row for each, of what it does and what it is.
macro_rules! causes {
    ($($effect:expr => $cause:expr;)+) => { vec![$((Some($effect), $cause)),+] };
}
use causes;

/// Causes that are faults of sensors.
fn faults<E>(causes: impl IntoIterator<Item = Cause>) -> impl Iterator<Item = (Option<E>, Cause)> {
    causes.into_iter().map(|cause| (None, cause))
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
    Cause::one(id, unknown(name, neutral, bounds, scale).starting(starts))
}

/// A cause with one parameter that is 0 where it is off, and is at most `most`.
fn amount(id: &'static str, name: &str, most: f64, scale: f64, starts: &[f64]) -> Cause {
    simple(id, name, 0.0, (0.0, most), scale, starts)
}

/// Dry friction that differs by direction, in terms of `same`: the cause of dry friction that does not.
fn directional(same: &Cause) -> Cause {
    let of = |way: &str| {
        let own = &same.parameters[0];
        let name = own.name.replace("friction_", &format!("friction_{way}_"));
        Parameter {
            name,
            ..own.clone()
        }
    };
    Cause::several("directional-friction", vec![of("forward"), of("back")])
}

/// A cause that multiplies a number of the machine.
fn share(id: &'static str, name: &str, scale: f64) -> Cause {
    simple(id, name, 1.0, (0.05, 20.0), scale, &[0.8, 1.25])
}

/// A column that is off by a number of this unit.
fn offset(column: &str, unit: &str, bounds: (f64, f64), scale: f64) -> Cause {
    let name = format!("offset_{unit}");
    simple("sensor-offset", &name, 0.0, bounds, scale, &[]).of_column(column, Fault::Offset)
}

/// A column that reads too much or too little in proportion.
fn gain(column: &str) -> Cause {
    let gain = simple("encoder-scale", "gain", 1.0, (0.2, 5.0), 0.01, &[]);
    gain.of_column(column, Fault::Gain)
        .usual(0.05, "sensors are calibrated")
}

/// A column that is late, by `most` (s) at most.
fn delay(column: &str, most: f64, scale: f64) -> Cause {
    amount("sensor-delay", "delay_s", most, scale, &[]).of_column(column, Fault::Delay)
}

/// An unknown of a run, free but for `bounds`.
fn unknown(name: &str, neutral: f64, bounds: (f64, f64), scale: f64) -> Parameter {
    Parameter::new(name, neutral, bounds, scale)
}

/// The rate after a step of h (s) of what has this inertia (kg or kg m²): the middle of the step
/// gives the force or torque `push`, and dry friction takes the rate that remains and no more.
/// `brakes` are the coefficients of dry and viscous friction and of drag.
fn braked(rate: f64, push: f64, [dry, viscous, drag]: [f64; 3], inertia: f64, h: f64) -> f64 {
    // What brakes in proportion to the rate does so without end, and never turns it round.
    let brake = h * (viscous + drag * rate.abs()) / inertia;
    let left = (-brake).exp();
    let mean = if brake > 1e-6 {
        (1.0 - left) / brake
    } else {
        1.0
    };
    let free = left * rate + mean * h * push / inertia;
    free.signum() * (free.abs() - h * dry / inertia).max(0.0)
}

/// Any number.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit;
    use crate::layout::{Draw, Layout};
    use crate::spec::Source;

    /// Readings that a sensor with one fault makes, exact but for that.
    fn read(layout: &Layout, kind: &dyn Kind, cause: usize, size: f64) -> Experiment {
        let mut terms = Terms::off(kind.causes());
        terms.set(cause, 0, size);
        let mut read = layout.experiment.clone();
        for (run, unknowns) in layout.unknowns.iter().enumerate() {
            let values = kind.predict(run, &terms, unknowns).expect("a motion");
            let mut rows = vec![0; kind.channels().len()];
            for (reading, value) in kind.logs()[run].readings.iter().zip(values) {
                let column = layout.column(&kind.channels()[reading.channel].name);
                read.runs[run].values[column][rows[reading.channel]] = value;
                rows[reading.channel] += 1;
            }
        }
        read
    }

    /// Whoever corrects a column by what is said of its sensor, whether it is predicted or drives the
    /// model, has data of which nothing is wrong.
    #[test]
    fn a_column_corrected_by_its_fault_is_right() {
        let mut tried = 0;
        let modelled = |sort: &Sort| matches!(sort.spec().synthesis.source, Source::Model);
        for sort in Sort::ALL.into_iter().filter(modelled) {
            let layout = Layout::new(sort, false, Some(2), &mut Draw::new(5));
            let robot = sort
                .spec()
                .robot
                .map(|name| saltus_robot::resolve(name, &[]));
            let robot = robot.transpose().expect("built in");
            let kind = build(&layout.experiment, robot.as_ref()).expect("a model");
            for (k, cause) in kind.causes().iter().enumerate() {
                let (Some(column), Some(fault)) = (&cause.column, cause.fault) else {
                    continue;
                };
                let parameter = &cause.parameters[0];
                let size = match fault {
                    Fault::Gain => 1.1,
                    Fault::Offset => 20.0 * parameter.scale,
                    // A column that is late is not corrected row by row.
                    Fault::Delay | Fault::Held => continue,
                };
                let mut data = read(&layout, kind.as_ref(), k, size);
                let sensor = crate::sensor::Sensor::default().with(fault, size);
                let column = data.column(column).expect("a column");
                for run in &mut data.runs {
                    for value in &mut run.values[column] {
                        *value = sensor.truth(*value);
                    }
                }
                let again = build(&data, robot.as_ref()).expect("a model");
                let fit = fit::fit_none(again.as_ref(), &[0, 1]).expect("a fit");
                let readings: usize = again.logs().iter().map(|log| log.readings.len()).sum();
                let left = (fit.loss / readings as f64).sqrt();
                assert!(left < 0.05, "{sort:?}, {}: {left} of the noise", cause.id);
                tried += 1;
            }
        }
        assert!(tried > 20, "{tried} faults");
    }
}
