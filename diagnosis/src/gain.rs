//! What an extension is worth on data that were not used for it.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::percentile;

use crate::fit::{self, Fit};
use crate::folds::Fold;
use crate::kind::{Kind, Terms};
use crate::settings::Settings;

/// Held-out gain of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    /// Name of the channel.
    pub channel: String,
    /// Root mean square of what is predicted wrongly of data left out, before and after (the
    /// channel's unit).
    pub rms: (f64, f64),
    /// The same of the noise.
    pub noise: f64,
    /// 95 % interval of `rms` after over before, by drawing runs again.
    pub ratio: (f64, f64),
}

/// What a model says of the data of a fold that it was not fitted to.
#[derive(Clone, Debug)]
pub(crate) struct Score {
    /// Loss.
    pub loss: f64,
    /// Sum of squares (the channel's unit) and count of each channel.
    squares: Vec<(f64, f64)>,
}

/// A model fitted without a fold, with the unknowns of what was left out fitted to it.
fn without(kind: &dyn Kind, model: &Fit, fold: &Fold) -> Option<Fit> {
    /// It starts where it will nearly end.
    const STEPS: usize = 2;
    match &fold.masks {
        None => {
            let train: Vec<usize> = (0..kind.logs().len())
                .filter(|run| !fold.runs.contains(run))
                .collect();
            let fitted = fit::refit(kind, model.clone(), &train, &None, STEPS)?;
            fit::refit_unknowns(kind, &fitted, &fold.runs, &None)
        }
        Some((train, _)) => fit::refit(kind, model.clone(), &fold.runs, train, 8 * STEPS),
    }
}

fn score(kind: &dyn Kind, model: &Fit, fold: &Fold) -> Option<Score> {
    of_fitted(kind, &without(kind, model, fold)?, fold)
}

/// Score of a fold, by a model whose unknowns were fitted to that fold.
fn of_fitted(kind: &dyn Kind, fitted: &Fit, fold: &Fold) -> Option<Score> {
    let mask = fold.masks.as_ref().and_then(|(_, test)| test.as_ref());
    let mut score = Score {
        loss: 0.0,
        squares: vec![(0.0, 0.0); kind.channels().len()],
    };
    for &run in &fold.runs {
        let residuals = fit::residuals(kind, run, &fitted.terms, &fitted.unknowns[run])?;
        for (i, (reading, r)) in kind.logs()[run].readings.iter().zip(residuals).enumerate() {
            if mask.is_none_or(|m| m[run][i]) {
                score.loss += fit::huber(r);
                let sum = &mut score.squares[reading.channel];
                sum.0 += (r * fit::scatter(kind, reading)).powi(2);
                sum.1 += 1.0;
            }
        }
    }
    Some(score)
}

/// What a model says of what is left out, fold by fold.
pub(crate) fn held_out(kind: &dyn Kind, model: &Fit, folds: &[Fold]) -> Option<Vec<Score>> {
    parallel::map(folds.len(), |k| score(kind, model, &folds[k]))
        .into_iter()
        .collect()
}

/// Residuals of each channel (root mean square, the channel's unit) with these parameters, which may come
/// from other data. The unknowns of each run are fitted. None if the model has no answer.
pub fn left(kind: &dyn Kind, terms: &Terms) -> Option<Vec<f64>> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    let model = Fit {
        terms: terms.clone(),
        ..Fit::first(kind)
    };
    let whole = Fold { runs, masks: None };
    let model = fit::refit_unknowns(kind, &model, &whole.runs, &None)?;
    let squares = of_fitted(kind, &model, &whole)?.squares;
    Some(
        squares
            .into_iter()
            .map(|(sum, n)| (sum / f64::max(n, 1.0)).sqrt())
            .collect(),
    )
}

/// Held-out gain of every channel, from the scores of the model before and after.
pub(crate) fn gains(
    kind: &dyn Kind,
    before: &[Score],
    after: &[Score],
    settings: &Settings,
) -> Vec<Gain> {
    let folds = before.len().min(after.len());
    let rms = |scores: &[Score], channel: usize, draw: &[usize]| {
        let add = |(s, n): (f64, f64), &k: &usize| {
            let (square, count) = scores[k].squares[channel];
            (s + square, n + count)
        };
        let (sum, n) = draw.iter().fold((0.0, 0.0), add);
        (sum / f64::max(n, 1.0)).sqrt()
    };
    let all: Vec<usize> = (0..folds).collect();
    let mut random = Pcg64::new(u128::from(settings.seed), 11);
    let draws: Vec<Vec<usize>> = match Uniform::new(0, folds.max(1)) {
        Ok(uniform) if folds > 0 => (0..500)
            .map(|_| all.iter().map(|_| uniform.sample(&mut random)).collect())
            .collect(),
        _ => Vec::new(),
    };
    kind.channels()
        .iter()
        .enumerate()
        .map(|(c, channel)| {
            let mut ratios: Vec<f64> = draws
                .iter()
                .map(|d| rms(after, c, d) / rms(before, c, d).max(f64::MIN_POSITIVE))
                .collect();
            ratios.sort_by(f64::total_cmp);
            Gain {
                channel: channel.name.clone(),
                rms: (rms(before, c, &all), rms(after, c, &all)),
                noise: channel.noise,
                ratio: (percentile(&ratios, 0.025), percentile(&ratios, 0.975)),
            }
        })
        .collect()
}
