//! A laboratory: synthetic measurements with an effect hidden in them, for tests of a diagnosis.
//!
//! Its small simulators have equations of their own and share nothing with the models of the crate
//! `diagnosis` but the type of the data; robots are simulated by `sim-check`, with the effect in
//! their robot file. The operator knows nothing of it.
//!
//! How strong an effect is, is counted in σ: the greatest difference that it alone makes to any
//! reading, from the same start and with the same commands, over one standard deviation (noise and
//! steps) of that column.

mod bench;
mod dial;
mod draw;
mod flight;
mod motion;
mod pendulum;
mod rig;
pub mod running;
mod sensing;
mod slide;
mod stroke;
mod tank_leg;
mod vessel;

use std::borrow::Cow;
use std::collections::BTreeMap;

use saltus_diagnosis::{Experiment, Run, Sort};

use self::dial::{Dial, Hidden};
use self::draw::Draw;
use self::sensing::{Column, Noise, Seen, sense};

/// An experiment, what its operator believes, and what is true.
#[derive(Clone, Debug)]
pub struct Case {
    /// What was measured.
    pub experiment: Experiment,
    /// The built-in robot that the operator believes was measured; none where no robot is in it.
    pub robot: Option<String>,
    /// What was hidden.
    pub truth: Vec<Effect>,
}

/// A hidden effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Id of the cause, or of an effect of [`outside`].
    pub id: &'static str,
    /// Its true numbers: keys of the robot file with the values of the true robot, or a column with
    /// its gain, offset, …
    pub parameters: Vec<(Cow<'static, str>, f64)>,
    /// How many σ it alone makes in the most affected reading.
    pub sigmas: f64,
}

/// How strong an effect is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Size {
    /// From 6 to 12 σ, and at least 5.
    Clear,
    /// About 2 σ.
    Subtle,
    /// From 15 to 30 σ.
    Large,
    /// From 100 to 1,000 σ, or as far as physics goes.
    Huge,
}

/// Noise and model discrepancy of the data; by default the noise is white and as stated, and there
/// is no discrepancy.
#[derive(Clone, Copy, Debug)]
pub struct Rough {
    /// Standard deviation (σ) of a process in every column that no cause explains, of which one half
    /// of the variance is common to the runs.
    pub discrepancy: f64,
    /// Form of that process.
    pub form: Form,
    /// Lag-1 autocorrelation of the noise from row to row, in [0, 1).
    pub autocorrelation: f64,
    /// Standard deviation of the noise as stated over its true one, > 0.
    pub stated: f64,
    /// Span of each column over its noise, in place of the noise and the steps of its sensor.
    pub precision: Option<f64>,
    /// Which draw of the noise it is.
    pub draw: u64,
}

impl Default for Rough {
    fn default() -> Rough {
        Rough {
            discrepancy: 0.0,
            form: Form::Smooth,
            autocorrelation: 0.0,
            stated: 1.0,
            precision: None,
            draw: 1,
        }
    }
}

/// Form of a model discrepancy in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A smooth random process.
    Smooth,
    /// A step at each event that dies away: at the valve's commands, or else at the first row.
    Event,
}

/// Every kind that [`make`] can make; [`running`] makes logs of kind run.
pub const SORTS: [Sort; 10] = [
    Sort::Bench,
    Sort::Hop,
    Sort::Jump,
    Sort::Flight,
    Sort::Outcomes,
    Sort::Stroke,
    Sort::Slide,
    Sort::Vessel,
    Sort::Pendulum,
    Sort::TankLeg,
];

/// Ids of the causes that show in an experiment of `kind`.
///
/// `gas-type` has one strength only, whatever the size that is asked for.
pub fn causes_of(kind: Sort) -> &'static [&'static str] {
    match kind {
        Sort::Bench => bench::CAUSES,
        Sort::Hop => rig::HOP_CAUSES,
        Sort::Jump => rig::JUMP_CAUSES,
        Sort::Outcomes => rig::OUTCOMES_CAUSES,
        Sort::Flight => flight::CAUSES,
        Sort::Stroke => stroke::CAUSES,
        Sort::Slide => slide::CAUSES,
        Sort::Vessel => vessel::CAUSES,
        Sort::Pendulum => pendulum::CAUSES,
        Sort::TankLeg => tank_leg::CAUSES,
        Sort::Run | Sort::Walk | Sort::Machine => &[],
    }
}

/// Kinds of experiment in which the cause `id` shows.
pub fn kinds_of(id: &str) -> Vec<Sort> {
    SORTS
        .into_iter()
        .filter(|kind| causes_of(*kind).contains(&id))
        .collect()
}

/// Effects that no listed cause explains, by kind.
pub const OUTSIDE: [(Sort, &[&str]); 10] = [
    (Sort::Bench, bench::OUTSIDE),
    (Sort::Hop, rig::HOP_OUTSIDE),
    (Sort::Jump, rig::JUMP_OUTSIDE),
    (Sort::Flight, flight::OUTSIDE),
    (Sort::Outcomes, rig::OUTCOMES_OUTSIDE),
    (Sort::Stroke, stroke::OUTSIDE),
    (Sort::Slide, slide::OUTSIDE),
    (Sort::Vessel, vessel::OUTSIDE),
    (Sort::Pendulum, pendulum::OUTSIDE),
    (Sort::TankLeg, tank_leg::OUTSIDE),
];

/// Ids of the effects on an experiment of `kind` that no listed cause explains.
pub fn outside(kind: Sort) -> &'static [&'static str] {
    OUTSIDE
        .iter()
        .find(|(of, _)| *of == kind)
        .map_or(&[], |(_, ids)| ids)
}

/// An experiment of `kind` with these effects `hidden` in it; all of it follows from `seed`.
///
/// An effect of one sensor is on a column of the seed's choice; where an effect may go either way,
/// the seed says which. A run that an effect keeps from being one, as a jump that does not lift
/// off, is left out.
///
/// # Panics
/// For an id that is neither in [`causes_of`] nor in [`outside`] of this kind.
pub fn make(kind: Sort, hidden: &[(&str, Size)], seed: u64) -> Case {
    make_rough(kind, hidden, &Rough::default(), seed)
}

/// An experiment in which nothing is hidden, without noise; what it has is known all the same.
///
/// # Panics
/// For a kind that is not in [`SORTS`].
pub fn exact(kind: Sort, seed: u64) -> Experiment {
    let world = world(kind, &[], seed);
    let still: Vec<Column> = world
        .columns()
        .iter()
        .map(|column| Column::noisy(column.name, 0.0))
        .collect();
    let logs = Neutral::of(&*world, None).logs;
    let read = measured(kind, &still, logs, 0.0, &mut Draw::new(seed, 1));
    Experiment {
        noise: noise(world.columns()),
        ..read
    }
}

/// An experiment as of [`make`], with noise and discrepancy as `rough` has them.
///
/// # Panics
/// As [`make`].
pub fn make_rough(kind: Sort, hidden: &[(&str, Size)], rough: &Rough, seed: u64) -> Case {
    let ids: Vec<&str> = hidden.iter().map(|(id, _)| *id).collect();
    let world = world(kind, &ids, seed);
    let neutral = Neutral::of(&*world, rough.precision);
    let columns = neutral.columns.clone();
    let mut all = Hidden::default();
    let mut truth = Vec::new();
    for &(id, size) in hidden {
        let known = causes_of(kind)
            .iter()
            .chain(outside(kind))
            .find(|known| **known == id);
        let id = *known.unwrap_or_else(|| panic!("{id} is no effect on {kind:?}"));
        // The same effect, whatever is hidden beside it.
        let mut draw = Draw::new(
            seed,
            id.bytes()
                .fold(1, |hash: u64, b| hash.wrapping_mul(31) + u64::from(b)),
        );
        let dials = dials(&*world, &neutral, id, &mut draw);
        let wanted = match size {
            Size::Clear => draw.scale(6.0, 12.0),
            Size::Subtle => 2.0,
            Size::Large => draw.scale(15.0, 30.0),
            Size::Huge => draw.scale(100.0, 1000.0),
        };
        let (strength, sigmas) = neutral.strength(&*world, &dials, wanted);
        let effect = Hidden::of(&dials, strength);
        truth.push(Effect {
            id,
            parameters: effect.all().to_vec(),
            sigmas,
        });
        all.add(&effect);
    }
    let mut logs = if hidden.is_empty() {
        neutral.logs
    } else {
        observe(&*world, &neutral.runs, &all)
    };
    if rough.discrepancy > 0.0 {
        roughen(&columns, &mut logs, rough, &mut Draw::new(seed, 2));
    }
    let noise = &mut Draw::new(seed, rough.draw);
    let mut experiment = measured(kind, &columns, logs, rough.autocorrelation, noise);
    for stated in experiment.noise.iter_mut().flatten() {
        *stated *= rough.stated;
    }
    Case {
        experiment,
        robot: world.robot().map(str::to_owned),
        truth,
    }
}

/// Something that is measured: what its runs are without noise.
trait World {
    /// The measured columns.
    fn columns(&self) -> &[Column];

    /// How many runs there are.
    fn runs(&self) -> usize;

    /// What `hidden` makes of each of `runs`; none where that is no run. Sensors are perfect.
    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>>;

    /// The numbers that the effect `id` changes, if it is not one of a sensor.
    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>>;

    /// Columns whose sensors may be wrong in the way `id`.
    fn sensed(&self, _id: &str) -> Vec<&'static str> {
        self.columns().iter().map(|column| column.name).collect()
    }

    /// The robot that the operator believes in.
    fn robot(&self) -> Option<&'static str> {
        None
    }

    /// Runs that are enough to find how strong an effect is.
    fn enough(&self) -> usize {
        4
    }
}

/// A run without noise.
#[derive(Clone, Debug, Default)]
struct Exact {
    settings: BTreeMap<String, f64>,
    valve: Option<(f64, Option<f64>)>,
    time: Vec<f64>,
    values: Vec<Vec<f64>>,
}

fn world(kind: Sort, ids: &[&str], seed: u64) -> Box<dyn World> {
    let mut draw = Draw::new(seed, 0);
    match kind {
        Sort::Bench => Box::new(bench::Bench::new(&mut draw)),
        Sort::Hop => Box::new(rig::Hops::new(&mut draw)),
        Sort::Jump => Box::new(rig::Jumps::new(&mut draw)),
        Sort::Outcomes => Box::new(rig::Outcomes::new(&mut draw)),
        Sort::Flight => Box::new(flight::Flights::new(ids, &mut draw)),
        Sort::Stroke => Box::new(stroke::Strokes::new(&mut draw)),
        Sort::Slide => Box::new(slide::Slides::new(&mut draw)),
        Sort::Vessel => Box::new(vessel::Vessels::new(ids, &mut draw)),
        Sort::Pendulum => Box::new(pendulum::Pendulums::new(&mut draw)),
        Sort::TankLeg => Box::new(tank_leg::TankLegs::new(&mut draw)),
        Sort::Run => panic!("lab::running makes logs of kind run"),
        Sort::Walk | Sort::Machine => panic!("the laboratory has no {kind:?}"),
    }
}

/// What the world would show with these sensors.
fn observe(world: &dyn World, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
    let mut logs = world.logs(runs, hidden);
    for log in logs.iter_mut().flatten() {
        for (column, values) in world.columns().iter().zip(&mut log.values) {
            sense(column.name, &log.time, values, hidden);
        }
    }
    logs
}

/// Adds the discrepancy of `rough` to every column. A run of one row has no course in time, and
/// stays.
fn roughen(columns: &[Column], logs: &mut [Option<Exact>], rough: &Rough, draw: &mut Draw) {
    for (k, column) in columns.iter().enumerate() {
        let shared = rough.form.process(draw);
        for log in logs.iter_mut().flatten() {
            let own = rough.form.process(draw);
            let [first, .., last] = log.time[..] else {
                continue;
            };
            let part = |t: f64| (t - first) / (last - first).max(1e-9);
            let events = log.valve.map_or([0.0; 2], |(on, off)| {
                [part(on), off.map_or(f64::INFINITY, part)]
            });
            let each = rough.discrepancy * column.sigma() * f64::sqrt(0.5);
            for (t, value) in log.time.iter().zip(&mut log.values[k]) {
                let t = part(*t);
                let past = events.into_iter().filter(|event| *event <= t);
                let since = t - past.fold(f64::NEG_INFINITY, f64::max);
                *value += each * (shared(t, since) + own(t, since));
            }
        }
    }
}

impl Form {
    /// A draw of the process, with a variance of 1: its value at a part of the run, 0 to 1, of which
    /// so much passed since the last event; an infinite part before the first one.
    fn process(self, draw: &mut Draw) -> Box<dyn Fn(f64, f64) -> f64> {
        match self {
            Form::Smooth => {
                let smooth = Smooth::new(draw);
                Box::new(move |part, _| smooth.at(part))
            }
            Form::Event => {
                let step = draw.normal(1.0);
                Box::new(move |_, since| step * (-since / 0.1).exp())
            }
        }
    }
}

/// A draw of a Gaussian process with mean 0, variance 1 and the covariance exp(−Δ²/2ℓ²), ℓ a
/// quarter of a run (Rahimi and Recht's random features, 2007).
struct Smooth([(f64, f64); 40]);

impl Smooth {
    fn new(draw: &mut Draw) -> Smooth {
        Smooth([(); 40].map(|()| {
            (
                draw.normal(1.0 / 0.25),
                draw.between(0.0, std::f64::consts::TAU),
            )
        }))
    }

    /// At a part of the run, 0 to 1.
    fn at(&self, part: f64) -> f64 {
        let waves = self
            .0
            .iter()
            .map(|(rate, phase)| (rate * part + phase).cos());
        waves.sum::<f64>() * (2.0 / self.0.len() as f64).sqrt()
    }
}

/// The numbers that the effect `id` changes.
fn dials(world: &dyn World, neutral: &Neutral, id: &str, draw: &mut Draw) -> Vec<Dial> {
    if let Some(dials) = world.dials(id, draw) {
        return dials;
    }
    let of = world.sensed(id);
    assert!(!of.is_empty(), "{id} is on no column of this experiment");
    let name = draw.one(&of);
    let index = neutral
        .columns
        .iter()
        .position(|column| column.name == name)
        .unwrap_or(0);
    let column = &neutral.columns[index];
    let logs = || neutral.logs.iter().flatten();
    let range = range(&neutral.logs, index);
    let ends =
        |row: fn(&[f64]) -> Option<&f64>| logs().filter_map(move |log| row(&log.time)).copied();
    let last = ends(<[f64]>::last).fold(f64::NEG_INFINITY, f64::max);
    let length = (last - ends(<[f64]>::first).fold(f64::INFINITY, f64::min)).max(1e-3);
    let seen = Seen {
        column,
        range,
        length,
        delay: 0.1 * length,
    };
    sensing::dials(id, &seen, draw).unwrap_or_else(|| panic!("{id} has no simulator"))
}

/// Least and greatest value of a column.
fn range(logs: &[Option<Exact>], column: usize) -> (f64, f64) {
    let values = logs.iter().flatten().flat_map(|log| &log.values[column]);
    let known = values.copied().filter(|x| x.is_finite());
    known.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
        (low.min(x), high.max(x))
    })
}

/// The world with nothing hidden, and its columns as they are read.
struct Neutral {
    runs: Vec<usize>,
    logs: Vec<Option<Exact>>,
    columns: Vec<Column>,
}

impl Neutral {
    fn of(world: &dyn World, precision: Option<f64>) -> Neutral {
        let runs: Vec<usize> = (0..world.runs()).collect();
        let logs = observe(world, &runs, &Hidden::default());
        let mut columns = world.columns().to_vec();
        for (k, column) in columns.iter_mut().enumerate() {
            let (low, high) = range(&logs, k);
            if let Some(precision) = precision.filter(|_| column.sigma() > 0.0) {
                *column = Column::noisy(column.name, (high - low) / precision);
            }
        }
        Neutral {
            runs,
            logs,
            columns,
        }
    }

    /// The strength at which `dials` make about `wanted` σ, and how many they make; the greatest
    /// strength where that is not enough.
    ///
    /// Some of the runs tell the strength, all of them the σ.
    fn strength(&self, world: &dyn World, dials: &[Dial], wanted: f64) -> (f64, f64) {
        let every = self.runs.len().div_ceil(world.enough()).max(1);
        let some: Vec<usize> = self.runs.iter().copied().step_by(every).collect();
        let sigmas = |runs: &[usize], s: f64| {
            let logs = observe(world, runs, &Hidden::of(dials, s));
            let pairs = runs
                .iter()
                .zip(&logs)
                .map(|(run, log)| (self.logs[*run].as_ref(), log.as_ref()));
            greatest(&self.columns, pairs)
        };
        if dials.iter().all(|dial| dial.at(0.5) == dial.at(1.0)) {
            return (1.0, sigmas(&self.runs, 1.0));
        }
        let s = solved(wanted, |s| sigmas(&some, s));
        let full = sigmas(&self.runs, s);
        // The runs left out may show more of it than the others, which matters for a subtle effect.
        if full < 1.1 * wanted || (wanted > 5.0 && full < 2.0 * wanted) {
            return (s, full);
        }
        let less = solved(wanted, |x| {
            if x == 1.0 {
                full
            } else {
                sigmas(&self.runs, x * s)
            }
        }) * s;
        (less, sigmas(&self.runs, less))
    }
}

/// Where in (0, 1] `of` comes to `wanted`, to a twentieth; 1 where it stays below. It is small at
/// small numbers.
fn solved(wanted: f64, of: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = ((0.0, 0.0), (1.0, of(1.0)));
    if high.1 <= wanted {
        return 1.0;
    }
    for _ in 0..16 {
        let middle = if low.0 == 0.0 && high.1.is_infinite() {
            0.4 * high.0
        } else if low.0 == 0.0 {
            // As if it were linear.
            (high.0 * wanted / high.1).clamp(0.05 * high.0, 0.7 * high.0)
        } else if low.1 > 0.0 && high.1.is_finite() {
            let part = (wanted / low.1).ln() / (high.1 / low.1).ln();
            low.0 * (high.0 / low.0).powf(part.clamp(0.05, 0.95))
        } else {
            (low.0 * high.0).sqrt()
        };
        let found = of(middle);
        if (found / wanted - 1.0).abs() < 0.05 {
            return middle;
        }
        if found > wanted {
            high = (middle, found);
        } else {
            low = (middle, found);
        }
    }
    high.0
}

/// The greatest difference in σ between logs of the same runs, over the rows that both have;
/// infinite where there are none.
fn greatest<'a>(
    columns: &[Column],
    pairs: impl Iterator<Item = (Option<&'a Exact>, Option<&'a Exact>)>,
) -> f64 {
    let mut most = f64::NEG_INFINITY;
    for (a, b) in pairs {
        let (Some(a), Some(b)) = (a, b) else { continue };
        for (k, column) in columns.iter().enumerate() {
            let differences = a.values[k]
                .iter()
                .zip(&b.values[k])
                .map(|(a, b)| (a - b).abs());
            let difference = differences.filter(|d| d.is_finite()).fold(0.0, f64::max);
            most = most.max(difference / column.sigma());
        }
    }
    if most < 0.0 { f64::INFINITY } else { most }
}

/// The experiment as its operator has it, with noise of this lag-1 autocorrelation.
fn measured(
    kind: Sort,
    columns: &[Column],
    logs: Vec<Option<Exact>>,
    autocorrelation: f64,
    draw: &mut Draw,
) -> Experiment {
    let mut runs: Vec<Run> = Vec::new();
    for log in logs.into_iter().flatten() {
        let read = |(column, values): (&Column, &Vec<f64>)| {
            let mut noise = Noise::new(column, autocorrelation);
            values
                .iter()
                .map(|value| column.read(*value, noise.next(draw)))
                .collect()
        };
        let values: Vec<Vec<f64>> = columns.iter().zip(&log.values).map(read).collect();
        match runs.first_mut() {
            // One run of many rows.
            Some(run) if kind == Sort::Outcomes => {
                run.time.push(run.time.len() as f64);
                for (all, new) in run.values.iter_mut().zip(values) {
                    all.extend(new);
                }
            }
            _ => {
                let name = format!("run-{:02}.csv", runs.len() + 1);
                runs.push(Run {
                    name,
                    settings: log.settings,
                    valve: log.valve,
                    time: log.time,
                    values,
                });
            }
        }
    }
    Experiment {
        kind,
        mechanism: None,
        columns: columns
            .iter()
            .map(|column| column.name.to_owned())
            .collect(),
        noise: noise(columns),
        resolution: columns
            .iter()
            .map(|column| some(column.resolution))
            .collect(),
        runs,
    }
}

/// What the operator knows of noise.
fn noise(columns: &[Column]) -> Vec<Option<f64>> {
    columns.iter().map(|column| some(column.noise)).collect()
}

fn some(x: f64) -> Option<f64> {
    (x > 0.0).then_some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean square and correlation over a quarter of a run are those of the process.
    #[test]
    fn a_discrepancy_has_its_variance_and_its_length() {
        const DRAWS: usize = 4000;
        let mut draw = Draw::new(1, 1);
        let (mut square, mut product) = (0.0, 0.0);
        for _ in 0..DRAWS {
            let process = Smooth::new(&mut draw);
            square += process.at(0.3).powi(2) / DRAWS as f64;
            product += process.at(0.3) * process.at(0.55) / DRAWS as f64;
        }
        // Four standard deviations of these means.
        assert!((square - 1.0).abs() < 0.09, "{square}");
        assert!((product - f64::exp(-0.5)).abs() < 0.08, "{product}");
    }
}
