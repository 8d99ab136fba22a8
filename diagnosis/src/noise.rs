//! How much a reading scatters, and readings out of columns.

use saltus_numeric::statistics::median;

use crate::experiment::{Experiment, Run};
use crate::finding::Diagnosis;
use crate::kind::{Channel, Data, Kind, Log, Reading};

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
                    (
                        if seen > 1.5 * quantised {
                            seen
                        } else {
                            quantised
                        },
                        seen <= 1.5 * quantised,
                    )
                }
                (None, None) => (estimate(experiment, k, 1), false),
            };
            Channel {
                name: experiment.columns[k].clone(),
                noise,
                step: step.unwrap_or(0.0),
                is_given,
            }
        })
        .collect()
}

/// Rows between which counts are compared: of a column that moves by half a count a row, each one
/// differs from the next, without noise.
const STRIDES: [usize; 3] = [1, 2, 3];

/// A stated noise that is far from the scatter of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct Misstated {
    /// The column.
    pub column: String,
    /// One standard deviation as it is stated (the column's unit).
    pub stated: f64,
    /// One standard deviation as the data show it (the column's unit).
    pub seen: f64,
}

/// Ratio of stated to seen scatter from which on the statement is not believed: a filter of the
/// instrument, and the wish to be on the safe side, make less of it.
const FAR: f64 = 10.0;
/// Scatter in terms of a column's span below which models of machines are not compared with data.
const FINE: f64 = 5e-4;

/// Takes the scatter of the data in place of each noise that is stated far larger, and says where:
/// a diagnosis by such a noise would explain everything. The rows of outcomes do not
/// follow each other: [`misstated`] tells of those, once a model is fitted.
pub fn disbelieve(experiment: &mut Experiment) -> Vec<Misstated> {
    if !experiment.kind.spec().timed {
        return Vec::new();
    }
    let mut all = Vec::new();
    for k in 0..experiment.columns.len() {
        let Some(stated) = experiment.noise[k] else {
            continue;
        };
        let seen = STRIDES.map(|stride| roughness(experiment, k, stride));
        let seen = seen.into_iter().flatten().reduce(f64::max);
        let fine = FINE * span(experiment, k);
        let Some(seen) = seen.filter(|seen| stated > FAR * seen.max(fine)) else {
            continue;
        };
        experiment.noise[k] = (seen < fine).then_some(fine);
        all.push(Misstated {
            column: experiment.columns[k].clone(),
            stated,
            seen: seen.max(fine),
        });
    }
    all
}

/// Channels of `kind`, which is of `experiment`, whose stated noise is far from the noise that a
/// diagnosis found.
pub fn misstated(experiment: &Experiment, kind: &dyn Kind, found: &Diagnosis) -> Vec<Misstated> {
    /// Ratio from which on it is said.
    const SAID: f64 = 2.0;
    /// Readings that tell a scatter.
    const LEAST: f64 = 12.0;
    let mut counts = vec![0.0; kind.channels().len()];
    for reading in kind.logs().iter().flat_map(|log| &log.readings) {
        counts[reading.channel] += reading.weight;
    }
    let of = |(c, channel): (usize, &Channel)| {
        let stated = experiment.noise[experiment.column(&channel.name)?]?;
        let ratio = found.fitness.1.noise[c];
        let is_far = !(1.0 / SAID..=SAID).contains(&ratio);
        let is_told = channel.is_given && counts[c] > LEAST && found.fitness.1.is_noise[c];
        (is_far && is_told).then(|| Misstated {
            column: channel.name.clone(),
            stated,
            seen: ratio * channel.noise,
        })
    };
    kind.channels().iter().enumerate().filter_map(of).collect()
}

/// Greatest less least value of a column.
fn span(experiment: &Experiment, column: usize) -> f64 {
    let values = || {
        experiment
            .runs
            .iter()
            .flat_map(|run| &run.values[column])
            .filter(|v| v.is_finite())
    };
    values().fold(f64::NEG_INFINITY, |a, b| a.max(*b))
        - values().fold(f64::INFINITY, |a, b| a.min(*b))
}

/// Scatter by third differences, as in [`estimate`], of the rows in which the column changes; none
/// where it never does.
fn roughness(experiment: &Experiment, column: usize, stride: usize) -> Option<f64> {
    let mut all = third_differences(experiment, column, stride);
    all.retain(|x| *x > 0.0);
    (!all.is_empty()).then(|| median(&mut all) / THIRD)
}

/// What the median of third differences is of independent readings with a standard deviation of 1:
/// Σ of the squares of 1, 3, 3, 1 is 20, and the median of |x| is 0.6745 of a standard deviation.
const THIRD: f64 = 0.674_489_75 * 4.472_135_954_999_58;

/// Sizes of third differences of readings `stride` rows apart, of all runs.
fn third_differences(experiment: &Experiment, column: usize, stride: usize) -> Vec<f64> {
    let third = |w: &[f64]| (w[3 * stride] - 3.0 * w[2 * stride] + 3.0 * w[stride] - w[0]).abs();
    let of = |run: &Run| -> Vec<f64> {
        let values: Vec<f64> = run.values[column]
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        values.windows(3 * stride + 1).map(third).collect()
    };
    experiment.runs.iter().flat_map(of).collect()
}

/// Standard deviation of what changes from one reading to the one `stride` later: from third
/// differences, which a smooth course does not have, and their median, which outliers do not move.
/// Never below what the values' own digits are worth.
fn estimate(experiment: &Experiment, column: usize, stride: usize) -> f64 {
    let mut count: f64 = f64::INFINITY;
    for run in &experiment.runs {
        let values: Vec<f64> = run.values[column]
            .iter()
            .copied()
            .filter(|v| v.is_finite())
            .collect();
        for w in values.windows(2) {
            let change = (w[1] - w[0]).abs();
            if change > 0.0 {
                count = count.min(change);
            }
        }
    }
    let seen = median(&mut third_differences(experiment, column, stride)) / THIRD;
    // A quantised column that mostly stands still shows no differences: its step does.
    let least = if count.is_finite() {
        count / 12f64.sqrt()
    } else {
        0.0
    };
    let span = span(experiment, column).max(f64::MIN_POSITIVE);
    if seen > 0.0 {
        seen.max(1e-9 * span)
    } else {
        least.max(1e-6 * span)
    }
}

/// How many readings a spell of equal counts weighs as where the column passes through the count: the errors of
/// rounding then lie on both sides of zero. A spell at which the column turns back or stands has one error of
/// rounding, and weighs as one reading.
const PASSED: f64 = 2.0;
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
        let same = values[start..]
            .iter()
            .take_while(|v| **v == values[start])
            .count()
            .max(1);
        let around = [start.checked_sub(1), Some(start + same)];
        let [before, after] = around.map(|at| values.get(at?).map(|v| *v > values[start]));
        let is_passed = before
            .zip(after)
            .is_some_and(|(before, after)| before != after);
        let worth = if is_passed { PASSED } else { 1.0 };
        weights[start..start + same].fill((worth / same as f64).min(1.0));
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
            weights(&run.values[k], is_bare && experiment.kind.spec().timed)
        })
        .collect();
    let mut readings = Vec::with_capacity(run.time.len() * indices.len());
    for (row, &time) in run.time.iter().enumerate() {
        for (channel, &k) in indices.iter().enumerate() {
            let value = run.values[k][row];
            if value.is_finite() {
                readings.push(Reading {
                    channel,
                    time,
                    value,
                    weight: weights[channel][row],
                });
            }
        }
    }
    Log {
        name: run.name.clone(),
        readings,
    }
}

impl Data {
    /// The channels and runs of the columns `indices`, as yet without causes.
    pub(crate) fn of(experiment: &Experiment, indices: &[usize]) -> Data {
        let logged = |run| log(experiment, run, indices);
        Data {
            channels: channels(experiment, indices),
            logs: experiment.runs.iter().map(logged).collect(),
            ..Data::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;
    use crate::experiment::Sort;
    use crate::toy;

    /// 2000 rows of a slow wave, with noise of a size.
    fn wave(noise: f64) -> Experiment {
        let mut random = Pcg64::new(3, 3);
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 1e-3).collect();
        let mut draw = || -> f64 { StandardNormal.sample(&mut random) };
        let values = time.iter().map(|t| (5.0 * t).sin() + noise * draw());
        let columns = [("angle_rad", values.collect())];
        toy::measured(Sort::Pendulum, &[], &time, &columns)
    }

    fn noise_of(experiment: &Experiment) -> f64 {
        channels(experiment, &[0])[0].noise
    }

    #[test]
    fn what_nobody_states_is_estimated() {
        for noise in [1e-4, 1e-2, 0.3] {
            let mut data = wave(noise);
            data.noise[0] = None;
            let found = noise_of(&data);
            assert!((found / noise - 1.0).abs() < 0.1, "{noise}: {found}");
        }
    }

    #[test]
    fn a_count_has_the_noise_of_its_step() {
        let step = 0.01;
        let mut data = wave(0.0);
        for value in &mut data.runs[0].values[0] {
            *value = (*value / step).round() * step;
        }
        (data.noise[0], data.resolution[0]) = (None, Some(step));
        assert_eq!(noise_of(&data), step / 12f64.sqrt());
        // With noise that is stated, both.
        data.noise[0] = Some(0.02);
        assert_eq!(noise_of(&data), f64::hypot(0.02, step / 12f64.sqrt()));
    }

    #[test]
    fn a_noise_stated_far_too_large_is_not_believed() {
        let mut data = wave(1e-2);
        data.noise[0] = Some(FAR * 0.8e-2);
        assert_eq!(disbelieve(&mut data), []);
        data.noise[0] = Some(FAR * 2e-2);
        let said = disbelieve(&mut data);
        assert_eq!(said.len(), 1);
        assert_eq!(
            (said[0].column.as_str(), said[0].stated),
            ("angle_rad", FAR * 2e-2)
        );
        assert!((said[0].seen / 1e-2 - 1.0).abs() < 0.1, "{}", said[0].seen);
        assert_eq!(data.noise[0], None);
    }

    /// A spell of equal counts weighs as two readings where the column passes, as one where it turns back or stands.
    #[test]
    fn repeated_counts_count_together() {
        let values = [1.0, 1.0, 2.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0, 2.0, 2.0];
        let weights = weights(&values, true);
        let of = |rows: std::ops::Range<usize>| weights[rows].iter().sum::<f64>();
        let sums = [of(0..2), of(2..6), of(6..9), of(9..11)];
        for (sum, right) in sums.into_iter().zip([1.0, PASSED, 1.0, 1.0]) {
            assert!((sum - right).abs() < 1e-12, "{weights:?}");
        }
        assert_eq!(super::weights(&[1.0, 2.0, 3.0], true), [1.0; 3]);
    }

    #[test]
    fn an_empty_cell_is_no_reading() {
        let mut data = wave(1e-2);
        data.runs[0].values[0][7] = f64::NAN;
        let log = log(&data, &data.runs[0], &[0]);
        assert_eq!(log.readings.len(), 1999);
        assert!(
            log.readings
                .iter()
                .all(|r| r.value.is_finite() && r.time != 7e-3)
        );
    }
}
