//! Which causes are at work: added one at a time while the data ask for them, on data left out.

use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::fit::{Fit, Mask, fit, score};
use crate::kind::{Kind, Reading};

/// How a diagnosis decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Stated rate of false alarms: how often data without an effect may be said to have one.
    pub false_alarms: f64,
    /// Most causes at work at the same time.
    pub most: usize,
    /// Parts into which one run is cut where there are no others to be left out.
    pub blocks: usize,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { false_alarms: 0.05, most: 3, blocks: 5 }
    }
}

/// A candidate that was tried.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Index of the cause.
    pub cause: usize,
    /// By how much the loss falls with it, in units that are worth one each for white noise.
    pub gain: f64,
    /// The same on data left out.
    pub held_out: f64,
    /// The model with it.
    pub fit: Fit,
}

/// A cause that was found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// Index of the cause.
    pub cause: usize,
    /// Indices of those that the data cannot tell from it.
    pub rivals: Vec<usize>,
    /// What its parameters would be, and theirs, each as if it were the cause.
    pub candidates: Vec<Candidate>,
}

/// What the data say.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// Every cause alone, the best first.
    pub tried: Vec<Candidate>,
    /// The causes, the most telling first.
    pub findings: Vec<Finding>,
    /// Whether what is left is not noise, and no candidate explains it.
    pub unknown: bool,
    /// The model as it is.
    pub before: Fit,
    /// The model with all findings.
    pub after: Fit,
    /// By how much more than white noise the residuals weigh: variance times correlation time, at least 1.
    pub inflation: f64,
    /// Root mean square of the residuals on data left out, before and after, for each channel, in its unit.
    pub held_out: Vec<(f64, f64)>,
}

/// Readings that are left out together.
struct Fold {
    train: Mask,
    test: Mask,
    /// Whether the unknowns of the tested run have to be estimated from it.
    own_start: bool,
    runs: Vec<usize>,
}

/// Says what is wrong with the model of an experiment; none where the model has no answer at its first guesses.
pub fn diagnose(kind: &dyn Kind, settings: &Settings) -> Option<Diagnosis> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    let all: Mask = kind.logs().iter().map(|log| vec![true; log.readings.len()]).collect();
    let folds = folds(kind, settings);
    let before = fit(kind, &[], &runs, &all, None)?;
    let mut current = before.clone();
    let inflation = excess(kind, &richest(kind, &before, &runs, &all, settings));
    let mut findings = Vec::new();
    let mut tried = Vec::new();
    while findings.len() < settings.most {
        let mut candidates = candidates(kind, &current, &runs, &all);
        for candidate in &mut candidates {
            candidate.gain /= inflation;
        }
        if findings.is_empty() {
            tried.clone_from(&candidates);
        }
        let freedom = |c: &Candidate| kind.causes()[c.cause].parameters.len();
        let count = candidates.len();
        let threshold = |c: &Candidate| quantile(freedom(c), 1.0 - settings.false_alarms / count as f64);
        let Some(best) = candidates.first_mut() else { break };
        if best.gain < threshold(best) {
            break;
        }
        best.held_out = held_out_gain(kind, &current, &best.fit, &folds).map_or(f64::NAN, |g| g / inflation);
        if best.held_out.is_nan() || best.held_out <= 0.0 {
            break;
        }
        let best = &candidates[0];
        // A factor of e² in likelihood, with two units for each parameter more.
        let worth = |c: &Candidate| c.gain - 2.0 * freedom(c) as f64;
        let rivals: Vec<usize> = candidates[1..]
            .iter()
            .filter(|c| worth(c) > worth(best) - 4.0 && c.gain >= threshold(c))
            .map(|c| c.cause)
            .collect();
        current = best.fit.clone();
        let cause = best.cause;
        candidates.retain(|c| c.cause == cause || rivals.contains(&c.cause));
        findings.push(Finding { cause, rivals, candidates });
    }
    let unknown = is_unexplained(kind, &before, &current, settings);
    let held_out = held_out_rms(kind, &before, &current, &folds);
    Some(Diagnosis { tried, findings, unknown, before, after: current, inflation, held_out })
}

/// Every cause that is not yet on, with it switched on; the best first.
fn candidates(kind: &dyn Kind, current: &Fit, runs: &[usize], all: &Mask) -> Vec<Candidate> {
    let mut candidates: Vec<Candidate> = (0..kind.causes().len())
        .filter(|c| !current.causes.contains(c))
        .filter_map(|cause| {
            let on: Vec<usize> = current.causes.iter().copied().chain([cause]).collect();
            let fit = fit(kind, &on, runs, all, Some(current))?;
            Some(Candidate { cause, gain: current.loss - fit.loss, held_out: f64::NAN, fit })
        })
        .collect();
    candidates.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    candidates
}

/// The model with as many causes as may be found, each the one that explains most: what it leaves is what a unit of loss is measured by.
fn richest(kind: &dyn Kind, before: &Fit, runs: &[usize], all: &Mask, settings: &Settings) -> Fit {
    let mut current = before.clone();
    for _ in 0..settings.most {
        let Some(best) = candidates(kind, &current, runs, all).into_iter().next() else { break };
        if best.fit.loss > 0.97 * current.loss {
            break;
        }
        current = best.fit;
    }
    current
}

/// χ² of so much freedom that is exceeded with the rest of `probability`.
fn quantile(freedom: usize, probability: f64) -> f64 {
    ChiSquared::new(freedom as f64).map_or(f64::INFINITY, |d| d.inverse_cdf(probability))
}

/// Every run left out once, or where there is one run, every block of it.
fn folds(kind: &dyn Kind, settings: &Settings) -> Vec<Fold> {
    let logs = kind.logs();
    let mask = |counts: &dyn Fn(usize, usize) -> bool| -> Mask {
        logs.iter()
            .enumerate()
            .map(|(run, log)| (0..log.readings.len()).map(|i| counts(run, i)).collect())
            .collect()
    };
    if logs.len() > 1 {
        let most = logs.len().min(10);
        return (0..most)
            .map(|fold| Fold {
                train: mask(&|run, _| run % most != fold),
                test: mask(&|run, _| run % most == fold),
                own_start: true,
                runs: (0..logs.len()).filter(|run| run % most == fold).collect(),
            })
            .collect();
    }
    let n = logs.first().map_or(0, |log| log.readings.len()).max(1);
    (0..settings.blocks)
        .map(|fold| {
            let inside = move |i: usize| i * settings.blocks / n == fold;
            Fold {
                train: mask(&|_, i| !inside(i)),
                test: mask(&|_, i| inside(i)),
                own_start: false,
                runs: vec![0],
            }
        })
        .collect()
}

/// The models refitted without each fold: the loss on it, without and with.
fn held_out_gain(kind: &dyn Kind, without: &Fit, with: &Fit, folds: &[Fold]) -> Option<f64> {
    let loss = |model: &Fit, fold: &Fold| {
        let train: Vec<usize> = (0..kind.logs().len())
            .filter(|run| !fold.own_start || !fold.runs.contains(run))
            .collect();
        let fitted = fit(kind, &model.causes, &train, &fold.train, Some(model))?;
        score(kind, &fitted, &fold.runs, &fold.test, fold.own_start)
    };
    folds.iter().map(|fold| Some(loss(without, fold)? - loss(with, fold)?)).sum()
}

/// Root mean square on data left out for each channel, before and after.
fn held_out_rms(kind: &dyn Kind, before: &Fit, after: &Fit, folds: &[Fold]) -> Vec<(f64, f64)> {
    let squares = |model: &Fit| -> Vec<(f64, usize)> {
        let mut sums = vec![(0.0, 0); kind.channels().len()];
        for fold in folds {
            let train: Vec<usize> = (0..kind.logs().len())
                .filter(|run| !fold.own_start || !fold.runs.contains(run))
                .collect();
            let Some(mut fitted) = fit(kind, &model.causes, &train, &fold.train, Some(model)) else { continue };
            if fold.own_start {
                crate::fit::refit_unknowns(kind, &mut fitted, &fold.runs, &fold.test);
            }
            for &run in &fold.runs {
                let Some(predicted) = kind.predict(run, &fitted.terms, &fitted.unknowns[run]) else { continue };
                let rows = kind.logs()[run].readings.iter().zip(&predicted).zip(&fold.test[run]);
                for ((reading, value), _) in rows.filter(|(_, counts)| **counts) {
                    let sum = &mut sums[reading.channel];
                    sum.0 += (reading.value - value).powi(2);
                    sum.1 += 1;
                }
            }
        }
        sums
    };
    let rms = |(sum, n): (f64, usize)| (sum / n.max(1) as f64).sqrt();
    squares(before).into_iter().zip(squares(after)).map(|(a, b)| (rms(a), rms(b))).collect()
}

/// Residuals of a run in standard deviations, channel by channel.
fn by_channel(kind: &dyn Kind, model: &Fit, run: usize) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new(); kind.channels().len()];
    if let Some(predicted) = kind.predict(run, &model.terms, &model.unknowns[run]) {
        for (reading, value) in kind.logs()[run].readings.iter().zip(&predicted) {
            let Reading { channel, value: measured, .. } = *reading;
            all[channel].push((measured - value) / kind.channels()[channel].noise);
        }
    }
    all
}

/// By how much more the residuals weigh than white noise of their standard deviation would: the greatest over channels of variance times
/// correlation time, at least 1.
fn excess(kind: &dyn Kind, model: &Fit) -> f64 {
    let runs = kind.logs().len();
    let series: Vec<Vec<Vec<f64>>> = (0..runs).map(|run| by_channel(kind, model, run)).collect();
    (0..kind.channels().len())
        .map(|channel| {
            let all: Vec<&Vec<f64>> = series.iter().map(|run| &run[channel]).collect();
            let n: usize = all.iter().map(|s| s.len()).sum();
            if n < 8 {
                return 1.0;
            }
            let clip = |x: f64| x.clamp(-1e3, 1e3);
            let covariance = |lag: usize| -> f64 {
                let sum: f64 = all
                    .iter()
                    .flat_map(|s| s.iter().zip(s.iter().skip(lag)))
                    .map(|(a, b)| clip(*a) * clip(*b))
                    .sum();
                sum / n as f64
            };
            let variance = covariance(0);
            let mut time = 1.0;
            let longest = all.iter().map(|s| s.len()).max().unwrap_or(0) / 3;
            for lag in 1..longest {
                let part = covariance(lag) / variance.max(1e-300);
                // Below what chance gives the tail says nothing.
                if part < 2.0 / (n as f64).sqrt() {
                    break;
                }
                time += 2.0 * part;
            }
            variance.max(1.0) * time
        })
        .fold(1.0, f64::max)
}

/// Whether most of what was wrong is left.
fn is_unexplained(kind: &dyn Kind, before: &Fit, after: &Fit, settings: &Settings) -> bool {
    let n: usize = kind.logs().iter().map(|log| log.readings.len()).sum();
    let limit = quantile(n, 1.0 - settings.false_alarms / 10.0);
    // The loss of pure noise is about n; what is far beyond it is not noise.
    if after.loss < limit * 1.1 {
        return false;
    }
    let excess = |fit: &Fit| (fit.loss - n as f64).max(0.0);
    excess(after) > 0.3 * excess(before)
}
