//! What a kind of experiment has to say for itself: what was measured, what is not known, what
//! could be wrong.

use std::f64::consts::PI;

use saltus_robot::Robot;

use crate::prior::Prior;
use crate::sensor::{Fault, Sensor};

/// A measured column.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name, which ends with its unit.
    pub name: String,
    /// Standard deviation of a reading (its unit), of noise and quantisation together; > 0.
    pub noise: f64,
    /// Step of a quantised column, or 0.
    pub step: f64,
    /// Whether the noise was given, and not estimated from the data.
    pub is_given: bool,
}

/// One measured number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Index of its channel.
    pub channel: usize,
    /// When (s).
    pub time: f64,
    /// In the channel's unit.
    pub value: f64,
    /// How much it counts, in (0, 1]: of a quantised channel that stands still, each repetition
    /// tells little more.
    pub weight: f64,
}

/// One run.
#[derive(Clone, Debug, PartialEq)]
pub struct Log {
    /// Its file.
    pub name: String,
    /// What was measured, in the order of time.
    pub readings: Vec<Reading>,
}

impl Log {
    /// The readings of a channel.
    pub fn of(&self, channel: usize) -> impl Iterator<Item = &Reading> {
        self.readings.iter().filter(move |r| r.channel == channel)
    }
}

/// A number that is estimated.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Its name, which ends with its unit; where there is one, the key of the robot file.
    pub name: String,
    /// Its value in the model as it is; for an unknown of a run, a first guess.
    pub neutral: f64,
    /// Least and greatest that physics allows. Where `neutral` is outside them, the effect is off
    /// there, and cannot be reached in small steps.
    pub bounds: (f64, f64),
    /// A change that matters.
    pub scale: f64,
    /// Where its search starts, beside `neutral`.
    pub starts: Vec<f64>,
}

impl Parameter {
    /// One whose search starts at its neutral value.
    pub fn new(name: &str, neutral: f64, bounds: (f64, f64), scale: f64) -> Parameter {
        Parameter {
            name: name.into(),
            neutral,
            bounds,
            scale,
            starts: Vec::new(),
        }
    }

    /// With more starts of its search.
    pub fn starting(self, starts: &[f64]) -> Parameter {
        Parameter {
            starts: starts.to_vec(),
            ..self
        }
    }
}

/// A named effect that may be at work: a term of the model, off where each parameter is neutral.
#[derive(Clone, Debug, PartialEq)]
pub struct Cause {
    /// Its id.
    pub id: &'static str,
    /// The measured column that it is about, if it is about one.
    pub column: Option<String>,
    /// In which way the sensor of that column is off, if that is what it is.
    pub fault: Option<Fault>,
    /// What is estimated.
    pub parameters: Vec<Parameter>,
    /// What is known of it apart from the data: indices of what is reported, each with what is
    /// known of that.
    pub priors: Vec<(usize, Prior)>,
    /// How its parameters are reported.
    pub form: Form,
}

/// How the parameters of a cause are reported, in the terms of a robot file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Form {
    /// As they are.
    Direct,
    /// The first one's inverse in its place, of this name.
    Inverse(String),
    /// Two components, forwards and along the leg, as a distance and an angle of these names.
    Polar([String; 2]),
}

impl Cause {
    /// A cause with one parameter.
    pub fn one(id: &'static str, parameter: Parameter) -> Cause {
        Cause::several(id, vec![parameter])
    }

    /// A cause with several parameters, reported as they are.
    pub fn several(id: &'static str, parameters: Vec<Parameter>) -> Cause {
        Cause {
            id,
            column: None,
            fault: None,
            parameters,
            priors: Vec::new(),
            form: Form::Direct,
        }
    }

    /// With what common sense knows of its first parameter: its value in the model as it is, with a
    /// standard deviation.
    pub(crate) fn usual(mut self, error: f64, why: &'static str) -> Cause {
        let value = self.parameters[0].neutral;
        self.priors = vec![(0, Prior::common(value, error, why))];
        self
    }

    /// As a fault of the sensor of a column.
    pub(crate) fn of_column(mut self, column: &str, fault: Fault) -> Cause {
        self.column = Some(column.into());
        self.fault = Some(fault);
        self
    }

    /// What is reported where its parameters are `values`: names and values, in the units of a
    /// robot file.
    pub fn report(&self, values: &[f64]) -> Vec<(String, f64)> {
        let names = self.parameters.iter().map(|p| p.name.clone());
        let mut all: Vec<(String, f64)> = names.zip(values.iter().copied()).collect();
        match &self.form {
            Form::Direct => {}
            Form::Inverse(name) => all[0] = (name.clone(), 1.0 / values[0]),
            Form::Polar([distance, angle]) => {
                all = vec![
                    (distance.clone(), values[0].hypot(values[1])),
                    (angle.clone(), values[0].atan2(values[1])),
                ];
            }
        }
        all
    }

    /// The values of its parameters where `reported` is reported.
    pub fn taken(&self, reported: &[f64]) -> Vec<f64> {
        let mut values = reported.to_vec();
        match self.form {
            Form::Direct => {}
            Form::Inverse(_) => values[0] = 1.0 / reported[0],
            Form::Polar(_) => {
                let (sin, cos) = reported[1].sin_cos();
                values = vec![reported[0] * sin, reported[0] * cos];
            }
        }
        values
    }

    /// Least and greatest of what is reported.
    pub fn ranges(&self) -> Vec<(f64, f64)> {
        if let Form::Polar(_) = self.form {
            let highest = self.parameters.iter().map(|p| p.bounds.1);
            let most = highest.fold(f64::INFINITY, f64::min);
            return vec![(0.0, most), (-PI, PI)];
        }
        let at = |end: fn((f64, f64)) -> f64| {
            let ends: Vec<f64> = self.parameters.iter().map(|p| end(p.bounds)).collect();
            self.report(&ends).into_iter().map(|reported| reported.1)
        };
        at(|bounds| bounds.0)
            .zip(at(|bounds| bounds.1))
            .map(|(a, b)| (a.min(b), a.max(b)))
            .collect()
    }

    /// Where its search starts, beside where its parameters are neutral.
    pub(crate) fn starts(&self) -> Vec<Vec<f64>> {
        let most = self
            .parameters
            .iter()
            .map(|p| p.starts.len())
            .max()
            .unwrap_or(0);
        let of = |k: usize| {
            let value = |p: &Parameter| {
                let start = p.starts.get(k).or(p.starts.last());
                start.copied().unwrap_or(p.neutral)
            };
            self.parameters.iter().map(value).collect()
        };
        (0..most).map(of).collect()
    }

    /// Whether the effect cannot be reached in small steps from none.
    pub(crate) fn is_apart(&self) -> bool {
        self.parameters
            .iter()
            .any(|p| p.neutral < p.bounds.0 || p.neutral > p.bounds.1)
    }

    /// Values over the whole range of each parameter in turn, rising, the others as near to neutral as
    /// physics lets them: half a decade from one to the next, on both sides.
    pub(crate) fn ladders(&self) -> Vec<Vec<Vec<f64>>> {
        /// Rungs, in half decades of the change that matters.
        const RUNGS: std::ops::Range<i32> = -3..16;
        let parameters = self.parameters.iter();
        let rest: Vec<f64> = parameters
            .map(|p| p.neutral.clamp(p.bounds.0, p.bounds.1))
            .collect();
        let ladder = |(k, p): (usize, &Parameter)| {
            let rung = |n: i32| p.scale * 10_f64.powf(0.5 * f64::from(n));
            let below = RUNGS.rev().map(|n| p.neutral - rung(n));
            let above = RUNGS.map(|n| p.neutral + rung(n));
            let values = below.chain(above);
            let legal = values.filter(|x| (p.bounds.0..=p.bounds.1).contains(x));
            let with = |value| {
                let mut rungs = rest.clone();
                rungs[k] = value;
                rungs
            };
            legal.map(with).collect()
        };
        self.parameters.iter().enumerate().map(ladder).collect()
    }
}

/// Values of the parameters of every cause.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms(Vec<Vec<f64>>);

impl Terms {
    /// All off.
    pub fn off(causes: &[Cause]) -> Terms {
        Terms(
            causes
                .iter()
                .map(|c| c.parameters.iter().map(|p| p.neutral).collect())
                .collect(),
        )
    }

    /// Parameter `parameter` of cause `cause`.
    pub fn get(&self, cause: usize, parameter: usize) -> f64 {
        self.0[cause][parameter]
    }

    /// Parameters of cause `cause`.
    pub fn of(&self, cause: usize) -> &[f64] {
        &self.0[cause]
    }

    /// Those of all causes in turn.
    pub(crate) fn all(&self) -> impl Iterator<Item = &f64> {
        self.0.iter().flatten()
    }

    /// Sets one.
    pub fn set(&mut self, cause: usize, parameter: usize, value: f64) {
        self.0[cause][parameter] = value;
    }
}

/// The measurements of an experiment, and what could be wrong.
#[derive(Clone, Debug, Default)]
pub struct Data {
    /// What was measured.
    pub channels: Vec<Channel>,
    /// The runs.
    pub logs: Vec<Log>,
    /// What could be wrong.
    pub causes: Vec<Cause>,
    /// How many of the causes, the first ones, are none: what nobody knows of the machine, and is
    /// the same in all runs. Their parameters are part of every model.
    pub common: usize,
    /// How many of the causes have an id; those after them are terms that describe what no listed
    /// cause explains.
    pub listed: usize,
    /// What of the data is used, and what is not.
    pub notes: Vec<String>,
}

impl Data {
    /// The instrument of a column with the terms on.
    pub fn sensor(&self, column: &str, terms: &Terms) -> Sensor {
        let causes = self.causes.iter().enumerate();
        let of = |(k, cause): (usize, &Cause)| {
            let (fault, own) = (cause.fault?, cause.column.as_deref()?);
            is_of(column, own).then(|| (fault, terms.get(k, 0)))
        };
        causes
            .filter_map(of)
            .fold(Sensor::default(), |sensor, (fault, size)| {
                sensor.with(fault, size)
            })
    }
}

/// Whether `column` is the one of a sensor: runs of machines that have nothing in common have columns
/// of their own.
pub(crate) fn is_of(column: &str, own: &str) -> bool {
    column
        .strip_suffix(own)
        .is_some_and(|rest| rest.is_empty() || rest.ends_with('.'))
}

/// A question to the model of a run: the true values behind its readings.
pub struct Asked<'a> {
    /// The run.
    pub run: usize,
    /// The terms that are on.
    pub terms: &'a Terms,
    /// The unknowns of the run, in the units of their names.
    pub unknowns: &'a [f64],
    /// The instrument of each channel.
    pub sensors: Vec<Sensor>,
    /// Time (s) of the true value behind each reading.
    pub times: Vec<f64>,
}

impl<'a> Asked<'a> {
    /// Run, terms and unknowns.
    pub fn parts(&self) -> (usize, &'a Terms, &'a [f64]) {
        (self.run, self.terms, self.unknowns)
    }

    fn of(data: &Data, run: usize, terms: &'a Terms, unknowns: &'a [f64]) -> Asked<'a> {
        let channels = data.channels.iter();
        let sensors: Vec<Sensor> = channels.map(|it| data.sensor(&it.name, terms)).collect();
        let readings = &data.logs[run].readings;
        let first = readings.first().map_or(0.0, |reading| reading.time);
        let shows = |it: &Reading| sensors[it.channel].shows(it.time, first);
        Asked {
            run,
            terms,
            unknowns,
            times: readings.iter().map(shows).collect(),
            sensors,
        }
    }
}

/// An experiment that was not done: one run of it, and which of its causes are those of the
/// experiment that was.
pub struct Proposal {
    /// What to do, at which settings, in words with units.
    pub what: String,
    /// The experiment, without readings that mean anything.
    pub kind: Box<dyn Kind>,
}

/// An experiment of a kind: its data, and the model of them.
pub trait Kind: Sync {
    /// Its measurements, and what could be wrong; the next six are parts of this.
    fn data(&self) -> &Data;

    /// The kind that this one looks at its own way, which answers what this one does not.
    fn inner(&self) -> Option<&dyn Kind> {
        None
    }

    /// See [`Data::channels`].
    fn channels(&self) -> &[Channel] {
        &self.data().channels
    }

    /// See [`Data::logs`].
    fn logs(&self) -> &[Log] {
        &self.data().logs
    }

    /// See [`Data::causes`].
    fn causes(&self) -> &[Cause] {
        &self.data().causes
    }

    /// See [`Data::common`].
    fn common(&self) -> usize {
        self.data().common
    }

    /// See [`Data::listed`].
    fn listed(&self) -> usize {
        self.data().listed
    }

    /// See [`Data::notes`].
    fn notes(&self) -> Vec<String> {
        self.data().notes.clone()
    }

    /// What is not known of a run, its start above all.
    fn unknowns(&self, run: usize) -> Vec<Parameter>;

    /// How many causes may be at work at a time, where nobody says.
    fn most(&self) -> usize {
        self.inner().map_or(3, Kind::most)
    }

    /// Whether each run is of a machine of its own, so that none of them tells of another: blocks of
    /// each are then left out, and not whole runs.
    fn is_apart(&self) -> bool {
        self.inner().is_some_and(Kind::is_apart)
    }

    /// Which runs belong together, as parts of one: they are left out together.
    fn group(&self, run: usize) -> usize {
        self.inner().map_or(run, |kind| kind.group(run))
    }

    /// Standard deviation of the model's own error, in standard deviations of a reading: a smooth
    /// process in time, which is part of the noise.
    fn discrepancy(&self) -> f64 {
        self.inner().map_or(0.1, Kind::discrepancy)
    }

    /// Standard deviation of the model's own error of each channel (σ of a reading).
    fn amplitudes(&self) -> Vec<f64> {
        vec![self.discrepancy(); self.channels().len()]
    }

    /// What the model says of each reading of a run; none where it has no answer.
    fn predict(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Option<Vec<f64>> {
        let data = self.data();
        let asked = Asked::of(data, run, terms, unknowns);
        let truths = self.truths(&asked)?;
        let readings = data.logs[run].readings.iter().zip(truths);
        let read = readings.map(|(it, truth)| asked.sensors[it.channel].reading(truth));
        let all: Vec<f64> = read.collect();
        all.iter().all(|x| x.is_finite()).then_some(all)
    }

    /// The truth behind each reading of a run, at the times that are asked; none where the model has
    /// no answer.
    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        self.inner()?.truths(asked)
    }

    /// The same experiment with each run cut into so many windows, each with a start of its own; none where
    /// a run cannot begin anywhere.
    fn windows(&self, count: usize) -> Option<Box<dyn Kind>> {
        self.inner()?.windows(count)
    }

    /// What noise of measured inputs does to the prediction of a run, drawn by `normal`; none where
    /// no input is measured.
    fn input_noise(&self, run: usize, normal: &mut dyn FnMut() -> f64) -> Option<Vec<f64>> {
        self.inner()?.input_noise(run, normal)
    }

    /// Phases of a run: their names, and when (s) each begins.
    fn phases(&self, run: usize, terms: &Terms, unknowns: &[f64]) -> Vec<(&'static str, f64)> {
        let of = |kind: &dyn Kind| kind.phases(run, terms, unknowns);
        self.inner().map_or_else(Vec::new, of)
    }

    /// The robot with the terms on, where the experiment is of a robot.
    fn robot(&self, terms: &Terms) -> Option<Robot> {
        self.inner()?.robot(terms)
    }

    /// What to measure where these data hardly show an effect, so that they show it more.
    fn stronger(&self) -> String {
        let said = self.inner().map(Kind::stronger);
        said.unwrap_or_else(|| "runs in which it shows more".into())
    }

    /// Experiments that were not done and could tell causes apart.
    fn proposals(&self) -> Vec<Proposal> {
        self.inner().map_or_else(Vec::new, Kind::proposals)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parameter(bounds: (f64, f64), neutral: f64) -> Parameter {
        Parameter {
            name: "x_m".into(),
            neutral,
            bounds,
            scale: 1e-3,
            starts: Vec::new(),
        }
    }

    #[test]
    fn what_is_reported_is_taken_back() {
        let two = || vec![parameter((1e-3, 2.0), 0.5), parameter((-1.0, 1.0), 0.0)];
        let forms = [
            Form::Direct,
            Form::Inverse("inverse".into()),
            Form::Polar(["distance".into(), "angle".into()]),
        ];
        for form in forms {
            let cause = Cause {
                form,
                ..Cause::several("a", two())
            };
            for values in [[0.3, 0.4], [1.5, -0.9], [0.002, 0.0]] {
                let reported: Vec<f64> = cause.report(&values).into_iter().map(|r| r.1).collect();
                for (back, value) in cause.taken(&reported).iter().zip(values) {
                    assert!((back - value).abs() < 1e-12, "{:?} {values:?}", cause.form);
                }
            }
        }
    }

    #[test]
    fn ranges_are_those_of_what_is_reported() {
        let parameters = vec![parameter((0.5, 2.0), 1.0), parameter((-1.0, 1.0), 0.0)];
        let of = |form| {
            let cause = Cause::several("a", parameters.clone());
            Cause { form, ..cause }.ranges()
        };
        assert_eq!(of(Form::Direct), [(0.5, 2.0), (-1.0, 1.0)]);
        assert_eq!(of(Form::Inverse("i".into())), [(0.5, 2.0), (-1.0, 1.0)]);
        // A circle within both bounds.
        let polar = Form::Polar(["distance".into(), "angle".into()]);
        assert_eq!(of(polar), [(0.0, 1.0), (-PI, PI)]);
    }

    #[test]
    fn a_ladder_stays_within_bounds_and_reaches_them() {
        let cause = Cause::several(
            "a",
            vec![parameter((0.0, 5.0), 0.0), parameter((-1e-2, 1.0), 0.5)],
        );
        let rungs = cause.ladders().concat();
        for rung in &rungs {
            for (x, p) in rung.iter().zip(&cause.parameters) {
                assert!((p.bounds.0..=p.bounds.1).contains(x), "{rung:?}");
            }
            let moved = rung
                .iter()
                .zip(&cause.parameters)
                .filter(|(x, p)| **x != p.neutral);
            assert_eq!(moved.count(), 1, "{rung:?}");
        }
        let most = rungs.iter().map(|rung| rung[0]).fold(0.0, f64::max);
        assert!(most > 5.0 / 10f64.sqrt() && !cause.is_apart());
        assert!(Cause::one("b", parameter((1.0, 2.0), 0.0)).is_apart());
    }
}
