//! What a model leaves of the data, channel by channel and phase by phase, and whether that is
//! noise.

use saltus_numeric::statistics::mean;
use statrs::distribution::{ChiSquared, ContinuousCDF, FisherSnedecor, Normal};

use crate::finding::{Fitness, Unknown};
use crate::fit::{self, Fit, parameters_of};
use crate::kind::Kind;
use crate::likelihood::counts;
use crate::policy::POLICY;

/// Phase of a run whose kind has none.
const WHOLE: &str = "all";

/// Step of a quantised channel, in terms of its noise, above which rounding itself makes neighbours
/// and runs alike or not: then their likeness is not tested.
const COARSE: f64 = 2.0;

/// A reading beside what a model says of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Index of the run.
    pub run: usize,
    /// Index of the channel.
    pub channel: usize,
    /// Phase of the run.
    pub phase: &'static str,
    /// When (s).
    pub time: f64,
    /// What was measured, in the channel's unit.
    pub measured: f64,
    /// What the model says, in the channel's unit.
    pub predicted: f64,
    /// Measured less predicted, in standard deviations of the channel's noise.
    pub residual: f64,
    /// How much the reading counts, in (0, 1].
    pub weight: f64,
}

/// Residuals of one channel in one phase, of all runs.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseResidual {
    /// Index of the channel.
    pub channel: usize,
    /// The phase.
    pub phase: &'static str,
    /// How many readings.
    pub count: usize,
    /// Mean, in standard deviations.
    pub mean: f64,
    /// Root mean square, in standard deviations.
    pub rms: f64,
    /// Standard deviation of the noise, in the channel's unit.
    pub noise: f64,
    /// Correlation of each residual with the next of its run.
    pub lag: f64,
    /// Correlation of the runs' means with each condition that differs between runs.
    pub conditions: Vec<(String, f64)>,
    /// How likely noise is so large.
    pub level: f64,
    /// How likely noise is so smooth; NaN of few readings, or where they are rounded coarsely.
    pub whiteness: f64,
    /// How likely the means of the runs of noise differ so much; NaN of one run, or where they are
    /// rounded coarsely.
    pub runs: f64,
    /// Words for what tells that it is not noise; empty where it is. Whether a channel is noise is
    /// what [`Fitness`] says; these say where and in which way it is not.
    pub faults: Vec<&'static str>,
}

impl PhaseResidual {
    /// Mean in the channel's unit.
    pub fn mean_in_unit(&self) -> f64 {
        self.mean * self.noise
    }

    /// Root mean square in the channel's unit.
    pub fn rms_in_unit(&self) -> f64 {
        self.rms * self.noise
    }

    /// Whether it is noise.
    pub fn is_noise(&self) -> bool {
        self.faults.is_empty()
    }

    /// Words for the tests that noise fails with chance `level`; three tests share it.
    fn failed(&self, level: f64) -> Vec<&'static str> {
        let tests = [
            (self.level, "large"),
            (self.whiteness, "smooth"),
            (self.runs, "differs by run"),
        ];
        tests
            .into_iter()
            .filter(|(p, _)| *p < level / 3.0)
            .map(|(_, word)| word)
            .collect()
    }
}

/// Every reading beside what `model` says of it; runs of which it says nothing are left out.
pub fn points(kind: &dyn Kind, model: &Fit) -> Vec<Point> {
    (0..kind.logs().len())
        .filter_map(|run| points_of(kind, model, run))
        .flatten()
        .collect()
}

fn points_of(kind: &dyn Kind, model: &Fit, run: usize) -> Option<Vec<Point>> {
    let unknowns = model.unknowns.get(run)?;
    let predicted = kind.predict(run, &model.terms, unknowns)?;
    let phases = kind.phases(run, &model.terms, unknowns);
    let point = |(reading, predicted): (&crate::kind::Reading, f64)| Point {
        run,
        channel: reading.channel,
        phase: phases
            .iter()
            .rev()
            .find(|(_, from)| *from <= reading.time)
            .map_or(
                // Before the first phase is the first.
                phases.first().map_or(WHOLE, |(name, _)| name),
                |(name, _)| name,
            ),
        time: reading.time,
        measured: reading.value,
        predicted,
        residual: (reading.value - predicted) / kind.channels()[reading.channel].noise,
        weight: reading.weight,
    };
    Some(
        kind.logs()[run]
            .readings
            .iter()
            .zip(predicted)
            .map(point)
            .filter(|p| p.residual.is_finite())
            .collect(),
    )
}

/// Readings that are alone and farther from `model`, whose fitness is `fitness`, than noise is: they are slips
/// of the instrument, and hardly count.
pub fn outliers(kind: &dyn Kind, model: &Fit, fitness: &Fitness) -> Vec<Point> {
    let mut all = points(kind, model);
    all.sort_by_key(|point| (point.run, point.channel));
    let mut found = Vec::new();
    for series in all.chunk_by(|a, b| (a.run, a.channel) == (b.run, b.channel)) {
        let noise = fitness.noise[series[0].channel];
        let left: Vec<f64> = series.iter().map(|point| point.residual / noise).collect();
        let counts = counts(&left, 1.0);
        let is_out = |k: &usize| counts[*k] < 1.0 && left[*k].abs() > POLICY.contradiction;
        found.extend((0..series.len()).filter(is_out).map(|k| series[k]));
    }
    found
}

/// Residuals of `model`, whose fitness is `fitness`, by channel and phase; `conditions` are the
/// settings of each run that residuals may go with.
pub fn residuals(
    kind: &dyn Kind,
    model: &Fit,
    fitness: &Fitness,
    conditions: &[Vec<(String, f64)>],
) -> Vec<PhaseResidual> {
    let points = points(kind, model);
    // What was fitted took as many degrees of freedom from the readings, evenly.
    let shared = parameters_of(kind, &model.causes).len();
    let fitted = shared + model.unknowns.iter().map(Vec::len).sum::<usize>();
    let free = (1.0 - fitted as f64 / points.len().max(1) as f64).max(0.1);
    let mut all = Vec::new();
    for (channel, about) in kind.channels().iter().enumerate() {
        let mut phases: Vec<(&'static str, Vec<&Point>)> = Vec::new();
        for point in points.iter().filter(|p| p.channel == channel) {
            match phases.iter_mut().find(|(name, _)| *name == point.phase) {
                Some((_, these)) => these.push(point),
                None => phases.push((point.phase, vec![point])),
            }
        }
        for (phase, these) in phases {
            let mut found = summary(&these, free, conditions);
            (found.channel, found.phase, found.noise) = (channel, phase, about.noise);
            if about.step > COARSE * about.noise {
                (found.whiteness, found.runs) = (f64::NAN, f64::NAN);
            }
            all.push(found);
        }
    }
    find_faults(&mut all, fitness);
    all
}

/// Where `model` is most off in a channel.
pub(crate) fn worst(kind: &dyn Kind, model: &Fit, channel: usize) -> Option<Unknown> {
    let mut parts: Vec<Part> = Vec::new();
    for run in 0..kind.logs().len() {
        add_parts(&mut parts, kind, model, run, channel)?;
    }
    let mean = |part: &Part| part.squares / part.count;
    let part = parts
        .into_iter()
        .max_by(|a, b| mean(a).total_cmp(&mean(b)))?;
    let channel = &kind.channels()[channel];
    Some(Unknown {
        channel: channel.name.clone(),
        rms: mean(&part).sqrt() * channel.noise,
        phase: part.name,
    })
}

/// Residuals of a channel in a phase of all runs.
struct Part {
    name: String,
    /// Sum of their squares (σ²).
    squares: f64,
    count: f64,
}

/// Adds the residuals of a channel in a run to the parts of their phases.
fn add_parts(
    parts: &mut Vec<Part>,
    kind: &dyn Kind,
    model: &Fit,
    run: usize,
    channel: usize,
) -> Option<()> {
    let (unknowns, readings) = (&model.unknowns[run], &kind.logs()[run].readings);
    let residuals = fit::residuals(kind, run, &model.terms, unknowns)?;
    let phases = kind.phases(run, &model.terms, unknowns);
    let (first, last) = (readings.first()?.time, readings.last()?.time);
    let third = |time: f64| {
        let third = 3.0 * (time - first) / (last - first).max(f64::MIN_POSITIVE);
        ["first third", "second third", "last third"]
            [usize::from(third >= 1.0) + usize::from(third >= 2.0)]
    };
    for (reading, r) in readings.iter().zip(residuals) {
        if reading.channel != channel {
            continue;
        }
        let mut begun = phases.iter().rev().filter(|(_, at)| *at <= reading.time);
        let name = begun.next().map_or_else(|| third(reading.time), |p| p.0);
        let square = (r / reading.weight.sqrt()).powi(2);
        match parts.iter_mut().find(|p| p.name == name) {
            Some(part) => (part.squares, part.count) = (part.squares + square, part.count + 1.0),
            None => parts.push(Part {
                name: name.to_owned(),
                squares: square,
                count: 1.0,
            }),
        }
    }
    Some(())
}

/// Says of each channel that is not noise where and in which way it is not.
fn find_faults(all: &mut [PhaseResidual], fitness: &Fitness) {
    /// How often a word may be said of noise.
    const WORDS: f64 = 0.05;
    let level = WORDS / all.len().max(1) as f64;
    for (channel, is_noise) in fitness.is_noise.iter().enumerate() {
        let these = || (0..all.len()).filter(|k| all[*k].channel == channel);
        let mut faults: Vec<(usize, Vec<&str>)> = these()
            .map(|k| (k, all[k].failed(level)))
            .filter(|(_, words)| !is_noise && !words.is_empty())
            .collect();
        if !is_noise && faults.is_empty() {
            // A pattern that goes through the phases: it is where they are largest.
            let largest = these().max_by(|a, b| all[*a].rms.total_cmp(&all[*b].rms));
            faults.extend(largest.map(|k| (k, vec!["pattern"])));
        }
        for (k, words) in faults {
            all[k].faults = words;
        }
    }
}

/// Of the residuals of one channel and phase, in the order of runs; `free` is the part of them that
/// is not fitted away.
fn summary(points: &[&Point], free: f64, conditions: &[Vec<(String, f64)>]) -> PhaseResidual {
    let runs: Vec<&[&Point]> = points.chunk_by(|a, b| a.run == b.run).collect();
    let weights: f64 = points.iter().map(|p| p.weight).sum();
    let sum: f64 = points.iter().map(|p| p.weight * p.residual).sum();
    let squares: f64 = points.iter().map(|p| p.weight * p.residual.powi(2)).sum();
    let (lag, whiteness) = neighbours(&runs);
    PhaseResidual {
        channel: 0,
        phase: WHOLE,
        count: points.len(),
        mean: sum / weights,
        rms: (squares / weights).sqrt(),
        noise: 1.0,
        lag,
        conditions: correlations(&runs, conditions),
        level: ChiSquared::new((weights * free).max(1e-3)).map_or(f64::NAN, |d| d.sf(squares)),
        whiteness,
        runs: runs_alike(&runs, lag),
        faults: Vec::new(),
    }
}

/// Correlation of each residual with the next of its run, and how likely noise has so much.
///
/// Only residuals that follow each other too closely count: what a fit takes away makes them
/// alternate.
fn neighbours(runs: &[&[&Point]]) -> (f64, f64) {
    let (mut above, mut below, mut pairs) = (0.0, 0.0, 0.0_f64);
    for pair in runs.iter().flat_map(|run| run.windows(2)) {
        let weight = pair[0].weight.min(pair[1].weight);
        above += weight * pair[0].residual * pair[1].residual;
        below += weight * 0.5 * (pair[0].residual.powi(2) + pair[1].residual.powi(2));
        pairs += weight;
    }
    if pairs < 3.0 || below <= 0.0 {
        return (f64::NAN, f64::NAN);
    }
    let lag = above / below;
    (lag, Normal::standard().sf(lag * pairs.sqrt()))
}

/// How likely runs of noise differ so much in their means: F test, with the scatter within runs
/// grown by its correlation `lag`.
fn runs_alike(runs: &[&[&Point]], lag: f64) -> f64 {
    let k = runs.len() as f64;
    let n: f64 = runs.iter().map(|run| run.len() as f64).sum();
    if runs.len() < 2 || n - k < 2.0 {
        return f64::NAN;
    }
    let values: Vec<Vec<f64>> = runs
        .iter()
        .map(|run| run.iter().map(|p| p.residual).collect())
        .collect();
    let whole = values.iter().flatten().sum::<f64>() / n;
    let (mut between, mut within) = (0.0, 0.0);
    for run in &values {
        let own = mean(run);
        between += run.len() as f64 * (own - whole).powi(2);
        within += run.iter().map(|r| (r - own).powi(2)).sum::<f64>();
    }
    let correlation = if lag > 0.0 { lag.min(0.99) } else { 0.0 };
    let grown = within / (n - k) * (1.0 + correlation) / (1.0 - correlation);
    let ratio = between / (k - 1.0) / grown.max(1e-300);
    FisherSnedecor::new(k - 1.0, n - k).map_or(f64::NAN, |f| f.sf(ratio))
}

/// Correlation of the runs' means with each condition that differs between them, of three runs or
/// more.
fn correlations(runs: &[&[&Point]], conditions: &[Vec<(String, f64)>]) -> Vec<(String, f64)> {
    let mut names: Vec<&String> = Vec::new();
    for (name, _) in runs
        .iter()
        .filter_map(|run| conditions.get(run[0].run))
        .flatten()
    {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let of = |name: &String| {
        let pairs: Vec<(f64, f64)> = runs
            .iter()
            .filter_map(|run| {
                let (_, value) = conditions
                    .get(run[0].run)?
                    .iter()
                    .find(|(n, _)| n == name)?;
                Some((
                    *value,
                    mean(&run.iter().map(|p| p.residual).collect::<Vec<_>>()),
                ))
            })
            .collect();
        correlation(&pairs).map(|c| (name.clone(), c))
    };
    names.into_iter().filter_map(of).collect()
}

/// Pearson's; none of fewer than three pairs, or where one side does not differ.
fn correlation(pairs: &[(f64, f64)]) -> Option<f64> {
    let (xs, ys): (Vec<f64>, Vec<f64>) = pairs.iter().copied().unzip();
    let (x, y) = (mean(&xs), mean(&ys));
    let sum = |f: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(a, b)| f(a - x, b - y)).sum::<f64>();
    let (xx, yy, xy) = (sum(&|a, _| a * a), sum(&|_, b| b * b), sum(&|a, b| a * b));
    let differs = xx.sqrt() > 1e-9 * x.abs().max(1e-12) && yy > 0.0;
    (pairs.len() > 2 && differs).then(|| xy / (xx * yy).sqrt())
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;

    const LEVEL: f64 = 0.01;

    /// Runs of 50 residuals: noise, and for each run and time something more.
    fn drawn(runs: usize, seed: u128, more: impl Fn(usize, f64) -> f64) -> PhaseResidual {
        let mut random = Pcg64::new(seed, 3);
        let mut points = Vec::new();
        for run in 0..runs {
            for i in 0..50 {
                let noise: f64 = StandardNormal.sample(&mut random);
                let time = f64::from(i) / 50.0;
                let residual = noise + more(run, time);
                points.push(Point {
                    run,
                    channel: 0,
                    phase: WHOLE,
                    time,
                    measured: residual,
                    predicted: 0.0,
                    residual,
                    weight: 1.0,
                });
            }
        }
        let conditions: Vec<_> = (0..runs)
            .map(|run| {
                vec![
                    ("load_kg".to_owned(), run as f64),
                    ("bore_m".to_owned(), 0.1),
                ]
            })
            .collect();
        summary(&points.iter().collect::<Vec<_>>(), 1.0, &conditions)
    }

    #[test]
    fn noise_is_noise() {
        // At a level of 1 % four of 200 or fewer but once in twenty times: ten are a fault.
        let denied = (0..200)
            .filter(|seed| !drawn(4, *seed, |_, _| 0.0).failed(LEVEL).is_empty())
            .count();
        assert!(denied < 10, "{denied}");
    }

    #[test]
    fn a_level_is_seen() {
        let found = drawn(4, 1, |_, time| if time > 0.9 { 4.0 } else { 0.0 });
        assert!(found.failed(LEVEL).contains(&"large"), "{found:?}");
    }

    #[test]
    fn what_is_smooth_is_seen() {
        let found = drawn(4, 2, |_, time| (6.0 * time).sin());
        assert!(
            found.failed(LEVEL).contains(&"smooth") && found.lag > 0.2,
            "{found:?}"
        );
        // What returns in every run does not differ between them.
        assert!(found.runs > 0.05, "{found:?}");
    }

    #[test]
    fn what_grows_with_a_condition_is_seen() {
        let found = drawn(6, 3, |run, _| 0.4 * run as f64 - 1.0);
        assert!(found.failed(LEVEL).contains(&"differs by run"), "{found:?}");
        assert_eq!(
            found.conditions.len(),
            1,
            "a bore that is the same in all runs explains nothing"
        );
        assert!(found.conditions[0].1 > 0.95, "{found:?}");
    }

    #[test]
    fn one_run_does_not_differ_from_others() {
        let found = drawn(1, 4, |_, _| 0.0);
        assert!(found.runs.is_nan() && found.conditions.is_empty());
        assert!((found.rms - 1.0).abs() < 0.3 && found.count == 50);
    }
}
