//! Which causes are at work: added one at a time while the data ask for them, on data left out.

use nalgebra::DMatrix;
use rand_pcg::Pcg64;
use statrs::distribution::{ChiSquared, ContinuousCDF};

use crate::fit::{self, Fit, Mask};
use crate::fitness::{self, Fitness};
use crate::gain::{self, Gain};
use crate::kind::Kind;
use crate::parallel;
use crate::tangent::Tangent;

/// How a diagnosis decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Stated rate of false alarms: how often data without an effect may be said to have one.
    pub false_alarms: f64,
    /// Most causes at work at the same time.
    pub most: usize,
    /// Parts into which one run is cut where there are no others to be left out.
    pub blocks: usize,
    /// Sets of readings drawn by chance, to tell what chance alone does.
    pub draws: usize,
    /// Seed of what is drawn.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { false_alarms: 0.05, most: 3, blocks: 5, draws: 300, seed: 1 }
    }
}

/// Of the false alarms, the part that may be an unknown effect.
const UNKNOWN_PART: f64 = 0.2;
/// An effect that changes no reading by so many standard deviations is left alone: the model itself is not truer than that.
const LEAST_EFFECT: f64 = 0.5;
/// Difference in loss below which data do not tell two causes apart: 20 to 1 in likelihood.
const RIVAL: f64 = 6.0;
/// Part of what is wrong that the causes found must explain, where something is left that they do not.
const EXPLAINED: f64 = 0.9;

/// A cause as a candidate, fitted with those before it.
#[derive(Clone, Debug)]
pub struct Candidate {
    /// Index of the cause.
    pub cause: usize,
    /// By how much the loss falls with it, where white noise would make it fall by about one for each parameter.
    pub gain: f64,
    /// The model with it.
    pub fit: Fit,
    /// Its parameters as they are reported: name, value, standard error.
    pub reported: Vec<(String, f64, f64)>,
}

/// A cause that was found.
#[derive(Clone, Debug)]
pub struct Finding {
    /// The cause in the model.
    pub best: Candidate,
    /// Those that the data cannot tell from it, each in its place.
    pub rivals: Vec<Candidate>,
    /// By how much the loss of data left out falls with it.
    pub held_out: f64,
    /// A direction of its parameters that the data do not tell, as the part of each.
    pub undetermined: Option<Vec<f64>>,
}

/// What the data say.
#[derive(Clone, Debug)]
pub struct Diagnosis {
    /// The causes, the most telling first.
    pub findings: Vec<Finding>,
    /// Something that is wrong beyond them.
    pub unknown: Option<fitness::Unknown>,
    /// Every cause alone, the best first.
    pub tried: Vec<Candidate>,
    /// The model as it is.
    pub before: Fit,
    /// The model with all findings.
    pub after: Fit,
    /// How well they fit.
    pub fitness: (Fitness, Fitness),
    /// By how much more than white noise the residuals weigh: variance times correlation time, at least 1.
    pub inflation: f64,
    /// Held-out gain of each channel.
    pub gains: Vec<Gain>,
}

/// Says what is wrong with the model of an experiment; `progress` is told what is being done. None where the model has no answer at its
/// first guesses.
pub fn diagnose(kind: &dyn Kind, settings: &Settings, progress: &(dyn Fn(&str) + Sync)) -> Option<Diagnosis> {
    let runs: Vec<usize> = (0..kind.logs().len()).collect();
    progress("fitting the model as it is");
    let before = fit::fit_none(kind, &runs)?;
    let mut search = Search { kind, settings, progress, runs, random: Pcg64::new(u128::from(settings.seed), 7) };
    let (chosen, tried, inflation) = search.forward(&before)?;
    let mut after = chosen;
    search.improve(&mut after, inflation);
    search.drop_needless(&mut after, &before, inflation);
    let fitness_before = search.fitness(&before);
    let mut fitness_after = if after.causes.is_empty() { fitness_before.clone() } else { search.fitness(&after) };
    let mut unknown = fitness_after.unknown(kind, &after);
    let left = fitness_after.excess / fitness_before.excess.max(1e-12);
    if unknown.is_some() && !after.causes.is_empty() && left > 1.0 - EXPLAINED && fitness_after.is_sure {
        // Several listed causes bent to something else are worse than none.
        after = before.clone();
        fitness_after = fitness_before.clone();
        unknown = fitness_after.unknown(kind, &after).or(unknown);
    }
    progress("what else could be");
    let findings = search.findings(&after, inflation);
    progress("data left out");
    let gains = gain::gains(kind, &before, &after, &folds(kind, settings), settings);
    Some(Diagnosis {
        findings,
        unknown,
        tried,
        before,
        after,
        fitness: (fitness_before, fitness_after),
        inflation,
        gains,
    })
}

struct Search<'a> {
    kind: &'a dyn Kind,
    settings: &'a Settings,
    progress: &'a (dyn Fn(&str) + Sync),
    runs: Vec<usize>,
    random: Pcg64,
}

impl Search<'_> {
    fn freedom(&self, cause: usize) -> usize {
        self.kind.causes()[cause].parameters.len()
    }

    /// How telling a gain is: beyond what a thousandth of chance gains give with as many parameters.
    fn telling(&self, cause: usize, gain: f64) -> f64 {
        gain - quantile(self.freedom(cause), 0.999)
    }

    /// What a candidate is worth beside others: its gain, less what its parameters and its being a surprise cost.
    fn worth(&self, candidate: &Candidate, inflation: f64) -> f64 {
        let cause = &self.kind.causes()[candidate.cause];
        let off = candidate.fit.terms.get(candidate.cause, 0) - cause.parameters[0].neutral;
        let surprise = cause.usual.map_or(0.0, |usual| 2.0 * (off / usual).powi(2).ln_1p());
        candidate.gain / inflation - 2.0 * cause.parameters.len() as f64 - surprise
    }

    /// Adds causes while they tell; the model, every cause alone, and the inflation.
    fn forward(&mut self, before: &Fit) -> Option<(Fit, Vec<Candidate>, f64)> {
        let mut current = before.clone();
        let mut tried = Vec::new();
        let mut steps: Vec<(Fit, f64, f64)> = Vec::new();
        while steps.len() < self.settings.most {
            let tangent = Tangent::new(self.kind, &current, true)?;
            let threshold = self.threshold(&tangent);
            let candidates = self.candidates(&current, Some(&tangent));
            if steps.is_empty() {
                tried.clone_from(&candidates);
            }
            let telling = |c: &&Candidate| self.telling(c.cause, c.gain) > threshold;
            if !candidates.iter().any(|c| telling(&c)) {
                break;
            }
            let Some(best) = self.best_on_data_left_out(&current, candidates) else { break };
            let freedom = quantile(self.freedom(best.cause), 0.999);
            steps.push((best.fit.clone(), best.gain, threshold + freedom));
            current = best.fit;
        }
        // What a unit of loss is worth is told by what the richest model leaves.
        let inflation = fitness::inflation(self.kind, &current);
        let kept = steps.iter().take_while(|(_, gain, needed)| gain / inflation > *needed).count();
        let model = if kept == 0 { before.clone() } else { steps[kept - 1].0.clone() };
        Some((model, tried, inflation))
    }

    /// What the most telling of all candidates reaches by chance in the stated part of cases.
    fn threshold(&mut self, tangent: &Tangent) -> f64 {
        let mut most: Vec<f64> = (0..self.settings.draws)
            .map(|_| {
                let drawn = tangent.chance(self.kind, &mut self.random);
                let of = |d: &crate::tangent::Direction| self.telling(d.cause, d.gain(&drawn));
                tangent.candidates.iter().map(of).fold(f64::NEG_INFINITY, f64::max)
            })
            .collect();
        most.sort_by(f64::total_cmp);
        let level = self.settings.false_alarms * (1.0 - UNKNOWN_PART);
        percentile(&most, 1.0 - level)
    }

    /// Every cause that is not yet on, with it switched on; the best first. Where a tangent shows that a cause could gain next to
    /// nothing, it is not fitted.
    fn candidates(&self, base: &Fit, tangent: Option<&Tangent>) -> Vec<Candidate> {
        let off: Vec<usize> = (0..self.kind.causes().len()).filter(|c| !base.causes.contains(c)).collect();
        let residuals = tangent.and_then(|_| Tangent::residuals(self.kind, base));
        let fitted = parallel::map(off.len(), |k| {
            let cause = off[k];
            let spec = &self.kind.causes()[cause];
            (self.progress)(&format!("{}: {}", base.causes.len() + 1, spec.id));
            if let (Some(tangent), Some(residuals)) = (tangent, &residuals)
                && !spec.is_apart()
            {
                let direction = tangent.candidates.iter().find(|d| d.cause == cause)?;
                if direction.gain(residuals) < 4.0 {
                    return None;
                }
            }
            let fit = fit::fit_with(self.kind, base, cause, &self.runs)?;
            let gain = base.loss - fit.loss;
            Some(Candidate { cause, gain, fit, reported: Vec::new() })
        });
        let mut all: Vec<Candidate> =
            fitted.into_iter().flatten().filter(|c| self.effect(base, &c.fit) >= LEAST_EFFECT).collect();
        all.sort_by(|a, b| self.worth(b, 1.0).total_cmp(&self.worth(a, 1.0)));
        all
    }

    /// By how many standard deviations two models differ at most.
    fn effect(&self, a: &Fit, b: &Fit) -> f64 {
        let of = |model: &Fit, run: usize| {
            fit::predicted(self.kind, run, &model.terms, &model.unknowns[run]).unwrap_or_default()
        };
        let worst = parallel::map(self.runs.len(), |run| {
            let (a, b) = (of(a, run), of(b, run));
            a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        });
        worst.into_iter().fold(0.0, f64::max)
    }

    /// Of the candidates that gain about as much as the first, the one that predicts data left out best; none if none predicts them
    /// better than the model without.
    fn best_on_data_left_out(&self, current: &Fit, candidates: Vec<Candidate>) -> Option<Candidate> {
        let first = candidates.first()?.gain;
        let near: Vec<Candidate> =
            candidates.into_iter().filter(|c| c.gain > first - RIVAL.max(0.02 * first)).take(4).collect();
        let folds = folds(self.kind, self.settings);
        let losses = gain::held_out(self.kind, current, &folds)?;
        let mut best: Option<(f64, Candidate)> = None;
        for candidate in near {
            let Some(with) = gain::held_out(self.kind, &candidate.fit, &folds) else { continue };
            let held_out: f64 = losses.iter().zip(&with).map(|(a, b)| a - b).sum();
            // A surprise counts here too.
            let surprise = candidate.gain - 2.0 * self.freedom(candidate.cause) as f64 - self.worth(&candidate, 1.0);
            let worth = held_out - surprise;
            if held_out > 0.0 && best.as_ref().is_none_or(|(b, _)| worth > *b) {
                best = Some((worth, candidate));
            }
        }
        best.map(|(_, candidate)| candidate)
    }

    /// `model` without one of its causes, fitted again.
    fn without(&self, model: &Fit, cause: usize) -> Option<Fit> {
        let mut base = model.clone();
        base.causes.retain(|c| *c != cause);
        for (p, parameter) in self.kind.causes()[cause].parameters.iter().enumerate() {
            base.terms.set(cause, p, parameter.neutral);
        }
        fit::refit(self.kind, base, &self.runs, &None, 40)
    }

    /// With two causes or more, tries every other in the place of each: what was best alone need not be best in company.
    fn improve(&mut self, model: &mut Fit, inflation: f64) {
        if model.causes.len() < 2 {
            return;
        }
        for cause in model.causes.clone() {
            let Some(base) = self.without(model, cause) else { continue };
            let tangent = Tangent::new(self.kind, &base, true);
            let candidates = self.candidates(&base, tangent.as_ref());
            let own = candidates.iter().find(|c| c.cause == cause).map(|c| self.worth(c, inflation));
            if let (Some(best), Some(own)) = (candidates.first(), own)
                && best.cause != cause
                && self.worth(best, inflation) > own + RIVAL
            {
                *model = best.fit.clone();
            }
        }
    }

    /// Takes out causes that the others have made needless.
    fn drop_needless(&self, model: &mut Fit, before: &Fit, inflation: f64) {
        let mut k = 0;
        while model.causes.len() > 1 && k < model.causes.len() {
            let cause = model.causes[k];
            match self.without(model, cause) {
                Some(base)
                    if (base.loss - model.loss) / inflation < quantile(self.freedom(cause), 0.999)
                        || self.effect(&base, model) < LEAST_EFFECT =>
                {
                    *model = base;
                    k = 0;
                }
                _ => k += 1,
            }
        }
        let _ = before;
    }

    fn fitness(&mut self, model: &Fit) -> Fitness {
        let level = self.settings.false_alarms * UNKNOWN_PART;
        fitness::fitness(self.kind, model, self.settings.draws, level, &mut self.random)
    }

    /// What is to be said of each cause of the model.
    fn findings(&self, model: &Fit, inflation: f64) -> Vec<Finding> {
        let folds = folds(self.kind, self.settings);
        let with = gain::held_out(self.kind, model, &folds);
        let mut all: Vec<Finding> = model
            .causes
            .iter()
            .filter_map(|&cause| {
                let base = self.without(model, cause)?;
                let tangent = Tangent::new(self.kind, &base, true);
                let mut candidates = self.candidates(&base, tangent.as_ref());
                let gain = base.loss - model.loss;
                let fit = model.clone();
                let mut best = Candidate { cause, gain, fit, reported: Vec::new() };
                let worth = self.worth(&best, 1.0);
                let id = self.kind.causes()[cause].id;
                candidates.retain(|c| {
                    // Without what speaks against a surprise: the data alone.
                    let other = &self.kind.causes()[c.cause];
                    let cost = 2.0 * (other.parameters.len() as f64 - self.freedom(cause) as f64);
                    let behind = (gain - c.gain + cost) / inflation;
                    let known = (worth - self.worth(c, 1.0)) / inflation;
                    let alike = (gain - c.gain).abs() < 1e-3 * gain.abs() + 0.5;
                    c.cause != cause && other.id != id && (alike || (behind < RIVAL && known < 3.0 * RIVAL))
                });
                let mut seen = vec![id];
                candidates.retain(|c| {
                    let id = self.kind.causes()[c.cause].id;
                    let is_new = !seen.contains(&id);
                    seen.push(id);
                    is_new
                });
                let undetermined = report(self.kind, &mut best, inflation);
                for rival in &mut candidates {
                    report(self.kind, rival, inflation);
                }
                let without = gain::held_out(self.kind, &base, &folds);
                let held_out = match (without, &with) {
                    (Some(a), Some(b)) => a.iter().zip(b).map(|(a, b)| a - b).sum(),
                    _ => f64::NAN,
                };
                Some(Finding { best, rivals: candidates, held_out, undetermined })
            })
            .collect();
        all.sort_by(|a, b| b.best.gain.total_cmp(&a.best.gain));
        all
    }
}

/// Fills in what is reported of a candidate's cause, with standard errors by first differences of what is reported; a direction of its
/// parameters that the data do not tell, if there is one.
fn report(kind: &dyn Kind, candidate: &mut Candidate, inflation: f64) -> Option<Vec<f64>> {
    let (fit, cause) = (&candidate.fit, candidate.cause);
    let parameters = &kind.causes()[cause].parameters;
    let tangent = Tangent::new(kind, fit, false);
    let offset: usize =
        fit.causes.iter().take_while(|c| **c != cause).map(|c| kind.causes()[*c].parameters.len()).sum();
    let n = parameters.len();
    let whole = tangent.as_ref().map(Tangent::covariance);
    let covariance = whole.as_ref().map_or_else(
        || DMatrix::from_element(n, n, f64::NAN),
        |(c, ..)| c.view((offset, offset), (n, n)).into_owned() * inflation,
    );
    let values = fit.terms.of(cause).to_vec();
    let reported = kind.report(cause, &values);
    let slopes: Vec<Vec<f64>> = (0..n)
        .map(|p| {
            let mut moved = values.clone();
            let step = 1e-4 * parameters[p].scale;
            moved[p] += step;
            let there = kind.report(cause, &moved);
            reported.iter().zip(&there).map(|(a, b)| (b.1 - a.1) / step * parameters[p].scale).collect()
        })
        .collect();
    candidate.reported = reported
        .into_iter()
        .enumerate()
        .map(|(k, (name, value))| {
            let mut variance = 0.0;
            for i in 0..n {
                for j in 0..n {
                    variance += slopes[i][k] * slopes[j][k] * covariance[(i, j)];
                }
            }
            (name, value, variance.max(0.0).sqrt())
        })
        .collect();
    whole.and_then(|(_, least, direction)| {
        (least < 1e-6 && n > 1).then(|| direction[offset..offset + n].to_vec())
    })
}

/// χ² of so much freedom that is exceeded with the rest of `probability`.
fn quantile(freedom: usize, probability: f64) -> f64 {
    ChiSquared::new(freedom as f64).map_or(f64::INFINITY, |d| d.inverse_cdf(probability))
}

/// The value below which so large a part of the sorted values is.
pub(crate) fn percentile(sorted: &[f64], part: f64) -> f64 {
    if sorted.is_empty() {
        return f64::INFINITY;
    }
    // An index.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let k = (part * sorted.len() as f64).ceil() as usize;
    sorted[k.clamp(1, sorted.len()) - 1]
}

/// Readings that are left out together.
pub(crate) struct Fold {
    /// Runs that are left out whole; none where a block of the only run is.
    pub runs: Vec<usize>,
    /// What is fitted to, and what is predicted, where it is a block.
    pub masks: Option<(Mask, Mask)>,
}

/// Every run left out once, ten at most together with others; or where there is one run, every block of it.
pub(crate) fn folds(kind: &dyn Kind, settings: &Settings) -> Vec<Fold> {
    let logs = kind.logs();
    if logs.len() > 1 {
        let most = logs.len().min(10);
        return (0..most)
            .map(|fold| Fold { runs: (0..logs.len()).filter(|run| run % most == fold).collect(), masks: None })
            .collect();
    }
    let n = logs.first().map_or(0, |log| log.readings.len()).max(1);
    (0..settings.blocks)
        .map(|fold| {
            let inside: Vec<bool> = (0..n).map(|i| i * settings.blocks / n == fold).collect();
            let outside = inside.iter().map(|x| !x).collect();
            Fold { runs: Vec::new(), masks: Some((Some(vec![outside]), Some(vec![inside]))) }
        })
        .collect()
}
