//! Forward selection: causes are added one at a time while data left out ask for them.

use rand_pcg::Pcg64;

use crate::evidence::Evidence;
use crate::finding::Candidate;
use crate::fit::Fit;
use crate::fitness;
use crate::policy::POLICY;
use crate::stages::candidates::candidates;
use crate::stages::{pairs, screen};
use crate::statistics::is_worse;
use crate::tangent::{Pair, Tangent};

/// What forward selection came to.
pub(crate) struct Added {
    /// The model with the causes that are accepted.
    pub(crate) model: Fit,
    /// The model with every cause that was tried on the way.
    pub(crate) richest: Fit,
    /// Every cause alone, the best first.
    pub(crate) tried: Vec<Candidate>,
    /// Every two causes, the most promising first.
    pub(crate) pairs: Vec<Pair>,
    /// Variance inflation by which further gains are judged.
    pub(crate) inflation: f64,
}

/// A model on the way to the richest one.
struct Step {
    fit: Fit,
    /// Gain over the model before.
    gain: f64,
    /// Gain, less the variance inflation, that makes it accepted.
    needed: f64,
    /// Variance inflation by the model's own error.
    inflation: f64,
    /// Whether the cause contradicts what is known.
    contradicts: bool,
}

/// Adds causes to `before`; none where its model does not answer.
pub(crate) fn forward(evidence: &Evidence, before: &Fit, random: &mut Pcg64) -> Option<Added> {
    let mut path = Path {
        current: before.clone(),
        steps: Vec::new(),
        tried: Vec::new(),
        pairs: Vec::new(),
    };
    while path.current.causes.len() < evidence.most() {
        let Some(tangent) = Tangent::new(evidence.kind, &path.current, true) else {
            // As it is, a model that does not move says nothing; one with causes goes no further.
            if path.steps.is_empty() {
                return None;
            }
            break;
        };
        let Some(step) = path.next(evidence, &tangent, random) else {
            break;
        };
        path.current = step.fit.clone();
        path.steps.push(step);
    }
    let (model, inflation) = accepted(evidence, before, &path);
    Some(Added {
        model,
        richest: path.current,
        tried: path.tried,
        pairs: path.pairs,
        inflation,
    })
}

/// The way from a model to the richest one.
struct Path {
    current: Fit,
    steps: Vec<Step>,
    tried: Vec<Candidate>,
    pairs: Vec<Pair>,
}

impl Path {
    /// One more cause, or two; none where nothing passes.
    fn next(&mut self, evidence: &Evidence, tangent: &Tangent, random: &mut Pcg64) -> Option<Step> {
        let threshold = screen::threshold(evidence, tangent, random);
        let is_first = self.steps.is_empty();
        if !is_first && !screen::may_pass(evidence, tangent, &self.current, threshold) {
            return None;
        }
        let candidates = candidates(evidence, &self.current, Some(tangent));
        if is_first {
            self.tried.clone_from(&candidates);
            self.pairs = pairs::by_score(evidence, tangent, &self.current);
        }
        let inflation = |fit: &Fit| evidence.inflation_between(&self.current, fit, 1.0);
        let passes = |c: &Candidate| {
            evidence.gain_beyond_chance(c.cause, c.gain / inflation(&c.fit)) > threshold
        };
        let best = if candidates.iter().any(passes) {
            best_held_out(evidence, &self.current, candidates)
        } else {
            None
        };
        let Some(best) = best else {
            let pair = pairs::add(evidence, tangent, &self.current)?;
            return Some(Step {
                gain: self.current.loss - pair.loss,
                needed: threshold,
                inflation: inflation(&pair),
                fit: pair,
                contradicts: false,
            });
        };
        let best = evidence.settled(best);
        // The best cause may be within the model's own error. Weaker ones are too then: stop.
        let least = evidence.least_effect(best.cause, self.steps.len());
        (evidence.effect(&self.current, &best.fit) >= least).then(|| Step {
            gain: best.gain,
            needed: threshold + evidence.gain_by_chance(best.cause) + evidence.prior_penalty(&best),
            inflation: inflation(&best.fit),
            contradicts: evidence.contradicts(&best),
            fit: best.fit,
        })
    }
}

/// The last step of which all up to it gain what they need; with the variance inflation by which
/// further gains are judged.
///
/// What a unit of loss is worth is told by what the richest model leaves: about 1 where that is
/// noise. Where it is correlated, a further cause has to stand out from what the model before it
/// leaves.
fn accepted(evidence: &Evidence, before: &Fit, path: &Path) -> (Fit, f64) {
    let richest = evidence.inflation(&path.current);
    let is_correlated = evidence.is_correlated(richest);
    let mut model = before;
    for step in &path.steps {
        // What contradicts what is known has to stand out as it always had.
        let by_runs = is_correlated && evidence.has_runs() && !step.contradicts;
        let gain = if by_runs && evidence.lacks_several() && !model.causes.is_empty() {
            evidence.judged_gain(model, &step.fit, step.inflation)
        } else if is_correlated && !model.causes.is_empty() {
            step.gain / evidence.inflation(model).max(step.inflation)
        } else {
            step.gain / richest.max(step.inflation)
        };
        let (mut needed, mut least) = (step.needed, 0.0);
        if is_correlated {
            // The inflation is itself known poorly.
            let doubt = step.fit.causes.last();
            needed = needed.max(0.0) + doubt.map_or(0.0, |cause| evidence.gain_by_chance(*cause));
            least = POLICY.share_correlated * fitness::excess(evidence.kind, model);
        }
        let is_chance =
            gain < needed && !(by_runs && predicts_far_better(evidence, model, &step.fit));
        if is_chance || step.gain < least {
            break;
        }
        model = &step.fit;
    }
    let inflation = if is_correlated {
        evidence.inflation(model)
    } else {
        richest
    };
    (model.clone(), inflation)
}

/// Whether `fit` predicts data left out far better than `model`, run by run: what `model` leaves is
/// then the cause that it lacks, and no measure of chance. Not of a cause of a sensor: what a sensor
/// does wrong can take the shape of much that a model lacks.
pub(crate) fn predicts_far_better(evidence: &Evidence, model: &Fit, fit: &Fit) -> bool {
    let mut more = fit.causes.iter().filter(|c| !model.causes.contains(c));
    if more.any(|cause| evidence.kind.causes()[*cause].column.is_some()) {
        return false;
    }
    let losses = |of: &Fit| evidence.held_out_losses(of).unwrap_or_default();
    let (before, after) = (losses(model), losses(fit));
    let better = after.iter().zip(&before).filter(|(a, b)| a < b).count();
    let folds = before.len();
    folds > 1 && 3 * better >= 2 * folds && ratio(&before, &after) < POLICY.far_better
}

/// Loss on data left out, after over before: the geometric mean over the folds.
fn ratio(before: &[f64], after: &[f64]) -> f64 {
    let logs = after.iter().zip(before).map(|(a, b)| (a / b).ln());
    (logs.sum::<f64>() / before.len().max(1) as f64).exp()
}

/// A candidate by what it predicts of data left out.
struct HeldOut {
    candidate: Candidate,
    losses: Vec<f64>,
    /// Gain over the model without it, less the prior penalty.
    gain: f64,
}

/// Of the candidates whose gain is near to that of the first, the one that predicts data left out
/// best; none where none predicts them better than the model without.
fn best_held_out(
    evidence: &Evidence,
    current: &Fit,
    candidates: Vec<Candidate>,
) -> Option<Candidate> {
    let first = candidates.first()?;
    let is_correlated = evidence.is_correlated(evidence.inflation(&first.fit));
    let behind = if is_correlated {
        POLICY.behind_part_correlated * first.gain
    } else {
        POLICY.rival_loss.max(POLICY.behind_part * first.gain)
    };
    let least = first.gain - behind;
    let without = evidence.held_out_losses(current)?;
    let compared = candidates.into_iter().filter(|c| c.gain > least);
    let mut all: Vec<HeldOut> = compared
        .take(POLICY.most_compared)
        .filter_map(|candidate| {
            let losses = evidence.held_out_losses(&candidate.fit)?;
            let whole: f64 = without.iter().sum();
            // Where what is left is no noise, a run that the others do not tell may be predicted
            // worse by a better model: each run counts by how much better it is.
            let (gain, least) = if is_correlated && evidence.has_runs() {
                (
                    whole * (1.0 - ratio(&without, &losses)),
                    whole * POLICY.least_part_held_out,
                )
            } else {
                (whole - losses.iter().sum::<f64>(), 0.0)
            };
            (gain > least).then(|| HeldOut {
                gain: gain - evidence.prior_penalty(&candidate),
                losses,
                candidate,
            })
        })
        .collect();
    // What contradicts what is known is the last resort.
    let contradicts = |c: &HeldOut| evidence.contradicts(&c.candidate);
    if is_correlated && !all.iter().all(contradicts) {
        all.retain(|c| !contradicts(c));
    }
    all.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    if is_correlated && !all.is_empty() {
        // Of those that are not worse, the least surprising.
        let best = all[0].losses.clone();
        all.retain(|c| !is_worse(&c.losses, &best));
        let penalty = |c: &HeldOut| evidence.prior_penalty(&c.candidate);
        all.sort_by(|a, b| penalty(a).total_cmp(&penalty(b)));
    }
    all.into_iter().next().map(|c| c.candidate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::toy::{ALL, READINGS, Toy, noise, sum, wave};

    fn added(toy: &Toy) -> Added {
        let settings = Settings::default();
        let mut random = Pcg64::new(1, 1);
        forward(&toy.evidence(&settings), &toy.before(), &mut random).expect("an answer")
    }

    #[test]
    fn two_effects_are_found_the_greater_first() {
        let data = sum(&[(12.0, &wave(3)), (25.0, &wave(1)), (1.0, &noise(1))]);
        let toy = Toy::new(&data, (0..6).map(wave).collect());
        let found = added(&toy);
        assert_eq!(found.model.causes, [1, 3]);
        for (cause, size) in [(1, 25.0), (3, 12.0)] {
            // Known to one.
            assert!((found.model.terms.get(cause, 0) - size).abs() < 3.0);
        }
        assert_eq!(found.tried[0].cause, 1);
        assert!(found.inflation < 1.3, "{}", found.inflation);
    }

    /// A shift of all readings by 0.3 σ is 6 in terms of a unit column: far beyond noise, and within
    /// the error of a model that is off by 0.4 σ. A shift of 3 σ is beyond both.
    #[test]
    fn what_the_model_may_be_off_by_is_no_cause() {
        let shift = vec![1.0 / (ALL as f64).sqrt(); ALL];
        for (size, discrepancy, causes) in [(6.0, 0.0, 1), (6.0, 0.4, 0), (60.0, 0.4, 1)] {
            let data = sum(&[(size, &shift), (1.0, &noise(3))]);
            let toy = Toy::new(&data, vec![shift.clone(), wave(5)]);
            let found = added(&toy.with_discrepancy(discrepancy)).model.causes;
            assert_eq!(found.len(), causes, "{size} {discrepancy}");
        }
    }

    /// Noise is an effect in 4 % of cases; 10 of 100 are a fault.
    #[test]
    fn noise_has_no_cause() {
        let columns = || (0..6).map(wave).collect();
        let alarms = (0..100)
            .filter(|seed| {
                let found = added(&Toy::new(&noise(*seed), columns()));
                !found.model.causes.is_empty()
            })
            .count();
        assert!(alarms < 10, "{alarms}");
    }

    /// An effect of 12 in 400 readings changes none by more than 0.85 σ: a model that is off by 1 σ
    /// may not report it.
    #[test]
    fn what_is_less_than_the_error_of_the_model_is_no_cause() {
        let data = sum(&[(12.0, &wave(1)), (1.0, &noise(4))]);
        let columns: Vec<Vec<f64>> = (0..4).map(wave).collect();
        assert_eq!(added(&Toy::new(&data, columns.clone())).model.causes, [1]);
        let poor = Toy::new(&data, columns).with_model_error(1.0);
        assert!(added(&poor).model.causes.is_empty());
    }

    /// An offset in one run of eight: the mean of all explains some of it, and predicts each of the
    /// other runs worse than nothing does.
    #[test]
    fn what_does_not_predict_other_runs_is_no_cause() {
        let one_run: Vec<f64> = (0..ALL)
            .map(|i| f64::from(u8::from(i < READINGS)))
            .collect();
        let data = sum(&[(2.8, &one_run), (1.0, &noise(5))]);
        let found = added(&Toy::new(&data, vec![vec![1.0; ALL]]));
        assert!(found.tried[0].gain > 40.0 && found.model.causes.is_empty());
    }
}
