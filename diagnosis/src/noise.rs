//! How much a reading scatters, and readings out of columns.

use crate::experiment::{Experiment, Run, Sort};
use crate::kind::{Channel, Log, Reading};

/// The channels of the columns `indices`: noise and quantisation as given, or from the data.
pub(crate) fn channels(experiment: &Experiment, indices: &[usize]) -> Vec<Channel> {
    indices
        .iter()
        .map(|&k| {
            let (given, step) = (experiment.noise[k], experiment.resolution[k]);
            let quantised = step.unwrap_or(0.0) / 12f64.sqrt();
            let (noise, is_given) = match (given, step) {
                (Some(noise), _) => (noise.hypot(quantised), true),
                (None, Some(_)) => {
                    // What the count does not explain.
                    let seen = STRIDES.map(|stride| estimate(experiment, k, stride));
                    let seen = seen.into_iter().fold(f64::INFINITY, f64::min);
                    (if seen > 1.5 * quantised { seen } else { quantised }, seen <= 1.5 * quantised)
                }
                (None, None) => (estimate(experiment, k, 1), false),
            };
            Channel { name: experiment.columns[k].clone(), noise, step: step.unwrap_or(0.0), is_given }
        })
        .collect()
}

/// Rows between which counts are compared: of a column that moves by half a count a row, each one differs from the next, without noise.
const STRIDES: [usize; 3] = [1, 2, 3];

/// Standard deviation of what changes from one reading to the one `stride` later: from third differences, which a smooth course does not have, and
/// their median, which outliers do not move. Never below what the values' own digits are worth.
fn estimate(experiment: &Experiment, column: usize, stride: usize) -> f64 {
    let mut differences = Vec::new();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut count: f64 = f64::INFINITY;
    for run in &experiment.runs {
        let values: Vec<f64> = run.values[column].iter().copied().filter(|v| v.is_finite()).collect();
        for w in values.windows(2) {
            let change = (w[1] - w[0]).abs();
            if change > 0.0 {
                count = count.min(change);
            }
        }
        for v in &values {
            (low, high) = (low.min(*v), high.max(*v));
        }
        let third = |w: &[f64]| (w[3 * stride] - 3.0 * w[2 * stride] + 3.0 * w[stride] - w[0]).abs();
        differences.extend(values.windows(3 * stride + 1).map(third));
    }
    // Σ of the squares of 1, 3, 3, 1 is 20; the median of |x| is 0.6745 of a standard deviation.
    let seen = median(&mut differences) / (0.674_489_75 * 20f64.sqrt());
    // A quantised column that mostly stands still shows no differences: its step does.
    let least = if count.is_finite() { count / 12f64.sqrt() } else { 0.0 };
    let span = (high - low).max(f64::MIN_POSITIVE);
    if seen > 0.0 { seen.max(1e-9 * span) } else { least.max(1e-6 * span) }
}

/// The median; 0 of nothing.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Readings of a quantised channel that say the same one after the other count as so many in all.
const REPEATED: f64 = 2.0;
/// Noise in terms of the step from which on it makes the error of every reading another one.
const DITHER: f64 = 0.15;

/// How much each row of a column counts.
fn weights(values: &[f64], is_quantised: bool) -> Vec<f64> {
    let mut weights = vec![1.0; values.len()];
    if !is_quantised {
        return weights;
    }
    let mut start = 0;
    while start < values.len() {
        let same = values[start..].iter().take_while(|v| **v == values[start]).count().max(1);
        weights[start..start + same].fill((REPEATED / same as f64).min(1.0));
        start += same;
    }
    weights
}

/// The readings of run `run` of an experiment, of the columns `indices`, in the order of time.
pub(crate) fn log(experiment: &Experiment, run: &Run, indices: &[usize]) -> Log {
    let weights: Vec<Vec<f64>> = indices
        .iter()
        .map(|&k| {
            let is_bare = experiment.resolution[k]
                .is_some_and(|step| experiment.noise[k].unwrap_or(0.0) < DITHER * step);
            weights(&run.values[k], is_bare && experiment.kind != Sort::Outcomes)
        })
        .collect();
    let mut readings = Vec::with_capacity(run.time.len() * indices.len());
    for (row, &time) in run.time.iter().enumerate() {
        for (channel, &k) in indices.iter().enumerate() {
            let value = run.values[k][row];
            if value.is_finite() {
                readings.push(Reading { channel, time, value, weight: weights[channel][row] });
            }
        }
    }
    Log { name: run.name.clone(), readings }
}
