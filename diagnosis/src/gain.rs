//! What an extension is worth on data that were not used for it.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;

use crate::choose::{Fold, Settings, percentile};
use crate::fit::{self, Fit};
use crate::kind::Kind;
use crate::parallel;

/// Held-out gain of a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Gain {
    /// Name of the channel.
    pub channel: String,
    /// Root mean square of what is predicted wrongly of data left out, before and after (the channel's unit).
    pub rms: (f64, f64),
    /// The same of the noise.
    pub noise: f64,
    /// 95 % interval of `rms` after over before, by drawing runs again.
    pub ratio: (f64, f64),
}

/// A model fitted without a fold, with the unknowns of what was left out fitted to it.
fn without(kind: &dyn Kind, model: &Fit, fold: &Fold) -> Option<Fit> {
    /// It starts where it will nearly end.
    const STEPS: usize = 4;
    match &fold.masks {
        None => {
            let train: Vec<usize> = (0..kind.logs().len()).filter(|run| !fold.runs.contains(run)).collect();
            let fitted = fit::refit(kind, model.clone(), &train, &None, STEPS)?;
            fit::refit_unknowns(kind, &fitted, &fold.runs, &None)
        }
        Some((train, _)) => fit::refit(kind, model.clone(), &[0], train, 4 * STEPS),
    }
}

/// Loss of what is left out, fold by fold.
pub(crate) fn held_out(kind: &dyn Kind, model: &Fit, folds: &[Fold]) -> Option<Vec<f64>> {
    let losses = parallel::map(folds.len(), |k| {
        let fitted = without(kind, model, &folds[k])?;
        match &folds[k].masks {
            None => fit::score(kind, &fitted, &folds[k].runs, &None),
            Some((_, test)) => fit::score(kind, &fitted, &[0], test),
        }
    });
    losses.into_iter().collect()
}

/// Sums of squares and counts of what is left out: for each fold and channel.
fn squares(kind: &dyn Kind, model: &Fit, folds: &[Fold]) -> Vec<Vec<(f64, f64)>> {
    parallel::map(folds.len(), |k| {
        let mut sums = vec![(0.0, 0.0); kind.channels().len()];
        let Some(fitted) = without(kind, model, &folds[k]) else { return sums };
        let (runs, mask) = match &folds[k].masks {
            None => (folds[k].runs.clone(), &None),
            Some((_, test)) => (vec![0], test),
        };
        for run in runs {
            let Some(residuals) = fit::residuals(kind, run, &fitted.terms, &fitted.unknowns[run]) else { continue };
            for (i, (reading, r)) in kind.logs()[run].readings.iter().zip(residuals).enumerate() {
                if mask.as_ref().is_none_or(|m| m[run][i]) {
                    let sum = &mut sums[reading.channel];
                    sum.0 += (r * fit::scatter(kind, reading)).powi(2);
                    sum.1 += 1.0;
                }
            }
        }
        sums
    })
}

/// Held-out gain of every channel.
pub(crate) fn gains(
    kind: &dyn Kind,
    before: &Fit,
    after: &Fit,
    folds: &[Fold],
    settings: &Settings,
) -> Vec<Gain> {
    let b = squares(kind, before, folds);
    let a = if after.causes.is_empty() { b.clone() } else { squares(kind, after, folds) };
    let rms = |sums: &[Vec<(f64, f64)>], channel: usize, draw: &[usize]| {
        let (sum, n) = draw.iter().fold((0.0, 0.0), |(s, n), &k| (s + sums[k][channel].0, n + sums[k][channel].1));
        (sum / f64::max(n, 1.0)).sqrt()
    };
    let all: Vec<usize> = (0..folds.len()).collect();
    let mut random = Pcg64::new(u128::from(settings.seed), 11);
    let draws: Vec<Vec<usize>> = match Uniform::new(0, folds.len().max(1)) {
        Ok(uniform) => {
            (0..500).map(|_| all.iter().map(|_| uniform.sample(&mut random)).collect()).collect()
        }
        Err(_) => Vec::new(),
    };
    kind.channels()
        .iter()
        .enumerate()
        .map(|(c, channel)| {
            let mut ratios: Vec<f64> =
                draws.iter().map(|d| rms(&a, c, d) / rms(&b, c, d).max(f64::MIN_POSITIVE)).collect();
            ratios.sort_by(f64::total_cmp);
            Gain {
                channel: channel.name.clone(),
                rms: (rms(&b, c, &all), rms(&a, c, &all)),
                noise: channel.noise,
                ratio: (percentile(&ratios, 0.025), percentile(&ratios, 0.975)),
            }
        })
        .collect()
}
