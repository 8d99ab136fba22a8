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
/// gives the force or torque `push`. `brakes` are the coefficients of dry and viscous friction and of drag.
/// Dry friction changes its sign in the step in which the rate does, when the rate is 0, or holds it there:
/// a friction of one sign over that step would leave an error of the rate for the rest of the run.
fn braked(rate: f64, push: f64, [dry, viscous, drag]: [f64; 3], inertia: f64, h: f64) -> f64 {
    // What brakes in proportion to the rate, by its size at the start (1/s).
    let fading = (viscous + drag * rate.abs()) / inertia;
    // ∫ e^(-fading t) over t.
    let mean = |t: f64| {
        if fading * t > 1e-6 {
            -(-fading * t).exp_m1() / fading
        } else {
            t
        }
    };
    let from_rest = |t: f64| push.signum() * (push.abs() - dry).max(0.0) / inertia * mean(t);
    if rate == 0.0 {
        return from_rest(h);
    }
    let gain = (push - rate.signum() * dry) / inertia;
    let next = rate * (1.0 - fading * mean(h)) + gain * mean(h);
    if next * rate > 0.0 {
        return next;
    }
    // e^(-fading t) where rate is 0.
    let until = if fading * rate.abs() > 1e-6 * gain.abs() {
        (-fading * rate / gain).ln_1p().abs() / fading
    } else {
        -rate / gain
    };
    from_rest((h - until).max(0.0))
}

/// Any number.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    use crate::experiment::Run;
    use crate::fit;
    use crate::layout::{Draw, Layout, SUPPLY, round};
    use crate::sensor::Sensor;

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

    /// Rows by which a late sensor is late.
    const LATE: f64 = 3.0;

    /// Time (s) from row to row.
    fn row_step(run: &Run) -> f64 {
        run.time.get(1).map_or(1.0, |next| next - run.time[0])
    }

    /// Kinds whose motions take long to fit.
    const SLOW: [Sort; 3] = [Sort::Hop, Sort::Jump, Sort::TankLeg];

    /// A kind with its robots: hops and jumps on a boom and without.
    fn cases(sort: Sort) -> Vec<(Sort, Option<Robot>)> {
        let names = match sort {
            Sort::Hop | Sort::Jump => vec![Some("rats-boom"), Some("rats-planar")],
            _ => vec![sort.spec().robot],
        };
        let robot = |name| saltus_robot::resolve(name, &[]).expect("built in");
        let robots = names.into_iter().map(|name| name.map(robot));
        robots.map(|robot| (sort, robot)).collect()
    }

    /// Two runs, whose rows are equally far apart; of outcomes eight rows, a run each.
    fn laid_out(sort: Sort, robot: Option<&Robot>) -> Layout {
        let runs = if sort == Sort::Outcomes { 1 } else { 2 };
        let mut layout = Layout::of((sort, robot), false, Some(runs), &mut Draw::new(5));
        let columns = layout.experiment.columns.len();
        let step = row_step(&layout.experiment.runs[0]);
        for k in 0..runs {
            let late = 0.01 * k as f64;
            let valve = (0.1, 0.17 + late);
            match sort {
                Sort::Hop => layout.put(k, SUPPLY, valve, vec![vec![0.0; 350]; columns]),
                Sort::Jump => {
                    layout.put(k, SUPPLY, valve, vec![vec![0.0; 400]; columns]);
                    let on_boom = robot.is_some_and(|robot| robot.boom.is_some());
                    layout.unknowns[k] = vec![-0.3 - late, 4.5];
                    // The side on which the gyro feels the turn of the boom.
                    layout.unknowns[k].extend(on_boom.then_some(1.0));
                }
                _ => {
                    let time = &mut layout.experiment.runs[k].time;
                    for (row, time) in time.iter_mut().enumerate() {
                        *time = round(row as f64 * step);
                    }
                }
            }
        }
        if sort == Sort::Outcomes {
            let run = layout.experiment.runs.remove(0);
            for k in 0..8 {
                let mut run = run.clone();
                let asked = [
                    4.0 + 0.2 * f64::from(k),
                    0.02 * f64::from(k),
                    0.08,
                    0.0,
                    0.0,
                ];
                run.values = asked.map(|value| vec![value]).to_vec();
                layout.experiment.runs.push(run);
            }
            layout.unknowns = vec![Vec::new(); 8];
        }
        layout
    }

    /// The experiment with a column corrected by the fault of its sensor. A column that is late by whole
    /// rows is moved by them, and the last rows, which then lack it, are left out.
    fn corrected(read: &Experiment, column: usize, sensor: &Sensor) -> Experiment {
        let mut data = read.clone();
        for run in &mut data.runs {
            let late = (sensor.delay + sensor.held) / row_step(run);
            // A number of rows.
            #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
            let late = late.round() as usize;
            let rows = run.time.len() - late;
            run.values[column].rotate_left(late);
            for value in &mut run.values[column] {
                *value = sensor.truth(*value);
            }
            run.time.truncate(rows);
            run.values.iter_mut().for_each(|own| own.truncate(rows));
        }
        data
    }

    /// Root mean square residual (standard deviations of the noise) of the model without a cause.
    fn residual(data: &Experiment, robot: Option<&Robot>) -> f64 {
        let kind = build(data, robot).expect("a model");
        let runs: Vec<usize> = (0..kind.logs().len()).collect();
        let fit = fit::fit_none(kind.as_ref(), &runs).expect("a fit");
        let readings: usize = kind.logs().iter().map(|log| log.readings.len()).sum();
        (fit.loss / readings as f64).sqrt()
    }

    /// Data of `sorts` with each fault of each sensor, and corrected by it; counts of the faults.
    fn check_corrections(sorts: impl Iterator<Item = Sort>) -> BTreeMap<String, usize> {
        let mut tried = BTreeMap::new();
        for (sort, robot) in sorts.flat_map(cases) {
            let robot = robot.as_ref();
            let layout = laid_out(sort, robot);
            let kind = build(&layout.experiment, robot).expect("a model");
            for (k, cause) in kind.causes().iter().enumerate() {
                let (Some(name), Some(fault)) = (&cause.column, cause.fault) else {
                    continue;
                };
                let size = match fault {
                    Fault::Gain => 1.1,
                    Fault::Offset => 20.0 * cause.parameters[0].scale,
                    Fault::Delay | Fault::Held => LATE * row_step(&layout.experiment.runs[0]),
                };
                let wrong = read(&layout, kind.as_ref(), k, size);
                let column = wrong.column(name).expect("a column");
                let sensor = Sensor::default().with(fault, size);
                let before = residual(&wrong, robot);
                let after = residual(&corrected(&wrong, column, &sensor), robot);
                let case = format!("{sort:?}, {} of {name}: {before}, {after} σ", cause.id);
                // The start of a flight, which is estimated, takes the place of some faults.
                assert!(before > 0.3 || sort == Sort::Flight, "{case}");
                // A late pressure of a leg with a tank loses the last rows of all columns.
                assert!(after < 0.02, "{case}");
                *tried.entry(format!("{fault:?}")).or_insert(0) += 1;
            }
        }
        tried
    }

    /// Whoever corrects a column by what is said of its sensor, whether it is predicted or drives the
    /// model, has data of which nothing is wrong. Runs are logs of many strides, each a jump.
    #[test]
    fn a_column_corrected_by_its_fault_is_right() {
        let is_quick = |sort: &Sort| !SLOW.contains(sort) && *sort != Sort::Run;
        let tried = check_corrections(Sort::ALL.into_iter().filter(is_quick));
        assert!(tried.values().all(|count| *count > 15), "{tried:?}");
    }

    #[test]
    #[ignore = "nightly: 3 s"]
    fn a_column_of_a_robot_corrected_by_its_fault_is_right() {
        let tried = check_corrections(SLOW.into_iter());
        assert_eq!(tried["Held"], 8, "{tried:?}");
        assert!(tried.values().all(|count| *count > 7), "{tried:?}");
    }
}
