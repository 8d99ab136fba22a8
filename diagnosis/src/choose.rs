//! Which causes are at work: added one at a time while the data ask for them, on data left out.

use std::sync::{Mutex, PoisonError};

use rand_pcg::Pcg64;
use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

use crate::finding::{Candidate, Diagnosis, Finding, report};
use crate::fit::{self, Fit};
use crate::fitness::{self, Fitness};
use crate::folds::{Fold, folds};
use crate::gain::{self, Score};
use crate::kind::Kind;
use crate::next::{self, NextExperiment};
use crate::parallel;
use crate::tangent::Tangent;
use crate::view::View;

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
        Settings {
            false_alarms: 0.05,
            most: 3,
            blocks: 5,
            draws: 300,
            seed: 1,
        }
    }
}

/// Of the false alarms, the part that may be an unknown effect.
const UNKNOWN_PART: f64 = 0.2;
/// Difference in loss below which data do not tell two causes apart: 7 to 1 in likelihood.
const RIVAL: f64 = 4.0;
/// Rivals of a cause that are named with it.
const RIVALS: usize = 2;
/// Inflation above which the noise is not what the data say it is: runs are then what is compared,
/// and not readings.
const WANDERS: f64 = 2.0;
/// Part of the best explanation's gain from which on another is among the best.
const AMONG_THE_BEST: f64 = 0.9;
/// Where it is not, the part of what is wrong that each cause must explain.
const SHARE: f64 = 0.2;
/// Part of what is wrong that may be left because a cause has somewhat another form than its term.
const SAME_FORM: f64 = 0.03;
/// Of the best gain, the part below which a cause is no rival.
const LITTLE: f64 = 0.3;
/// Part of what is wrong that the causes found must explain, where something is left that they do
/// not.
const EXPLAINED: f64 = 0.8;

/// Says what is wrong with the model of an experiment; `progress` is told what is being done. None
/// where the model has no answer at its first guesses.
///
/// Where even the richest model, or one term without an id, leaves much more than the noise that is
/// stated, the instruments wander, or something is at work that no cause explains: the search is
/// then done again with the scatter that is seen.
pub fn diagnose(
    kind: &dyn Kind,
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Option<Diagnosis> {
    progress("fitting the model as it is");
    let view = View::new(kind);
    let kind: &dyn Kind = &view;
    let mut search = Search::new(kind, settings, progress);
    let before = fit::fit_none(kind, &search.runs)?;
    let chosen = search.forward(&before)?;
    let rescaled = view.rescaled(&chosen.richest).filter(|_| {
        search
            .describe(&before)
            .is_none_or(|term| view.rescaled(&term.fit).is_some())
    });
    if let Some(seen) = &rescaled {
        let mut search = Search {
            wanders: true,
            ..Search::new(seen, settings, progress)
        };
        let before = fit::fit_none(seen, &search.runs)?;
        let chosen = search.forward(&before)?;
        // What scatters one by one is no fault of the model: jumps of a robot are never quite the
        // same.
        let judged: &dyn Kind = if fitness::is_white(seen, &chosen.model) {
            seen
        } else {
            kind
        };
        let mut diagnosis = search.conclude(judged, before, chosen);
        for (gain, channel) in diagnosis.gains.iter_mut().zip(kind.channels()) {
            gain.noise = channel.noise;
        }
        return Some(diagnosis);
    }
    Some(search.conclude(kind, before, chosen))
}

/// What adding causes came to.
struct Chosen {
    model: Fit,
    richest: Fit,
    tried: Vec<Candidate>,
    /// Two causes at a time with what they gain together, as far as small changes tell it; the best
    /// first.
    pairs: Vec<(f64, (usize, usize))>,
    inflation: f64,
}

struct Search<'a> {
    kind: &'a dyn Kind,
    settings: &'a Settings,
    progress: &'a (dyn Fn(&str) + Sync),
    /// Whether the readings are known to scatter more than was stated.
    wanders: bool,
    runs: Vec<usize>,
    random: Pcg64,
    scores: Mutex<Scores>,
    fitted: Mutex<Fitted>,
}

/// Causes of models, with what they say of data left out.
type Scores = Vec<(Vec<usize>, Vec<Score>)>;
/// Causes of models, with every further one as a candidate.
type Fitted = Vec<(Vec<usize>, Vec<Candidate>)>;

fn losses(scores: &[Score]) -> Vec<f64> {
    scores.iter().map(|s| s.loss).collect()
}

impl<'a> Search<'a> {
    fn new(
        kind: &'a dyn Kind,
        settings: &'a Settings,
        progress: &'a (dyn Fn(&str) + Sync),
    ) -> Search<'a> {
        let runs = (0..kind.logs().len()).collect();
        Search {
            kind,
            settings,
            progress,
            wanders: false,
            runs,
            random: Pcg64::new(u128::from(settings.seed), 7),
            scores: Mutex::default(),
            fitted: Mutex::default(),
        }
    }

    /// What is to be said; `stated` is the experiment with the noise that its readings are judged
    /// by.
    fn conclude(mut self, stated: &dyn Kind, before: Fit, chosen: Chosen) -> Diagnosis {
        let Chosen {
            model: mut after,
            mut tried,
            pairs,
            mut inflation,
            ..
        } = chosen;
        if let Some(better) = self.better_pair(&before, &after, &pairs) {
            (after, inflation) = (better.model, better.inflation);
        }
        self.improve(&mut after, inflation);
        self.drop_needless(&mut after, inflation);
        let fitness_before = self.fitness(stated, &before);
        let mut fitness_after = if after.causes.is_empty() {
            fitness_before.clone()
        } else {
            self.fitness(stated, &after)
        };
        let mut unknown = fitness_after.unknown(stated, &after);
        let left = fitness_after.squares / fitness_before.squares.max(1e-12);
        // One run does not tell what returns; and a term of somewhat another form may be the same
        // cause.
        if left < if self.runs.len() == 1 { 0.5 } else { SAME_FORM } && !after.causes.is_empty() {
            unknown = None;
        }
        if fitness_after.is_gross && (after.causes.is_empty() || left > 1.0 - EXPLAINED) {
            unknown = fitness_after.worst(stated, &after);
        }
        let is_bent = left > 1.0 - EXPLAINED || (left > SAME_FORM && self.is_at_a_bound(&after));
        if unknown.is_some() && !after.causes.is_empty() && is_bent {
            // Listed causes bent to something else are worse than none.
            after = before.clone();
            fitness_after = fitness_before.clone();
            unknown = fitness_after.unknown(stated, &after).or(unknown);
            inflation = fitness::inflation(self.kind, &after);
        }
        // A term without a name that explains clearly more than the causes that were found: they
        // were not the cause.
        let alone = if before.causes == after.causes && unknown.is_none() {
            None
        } else {
            self.describe(&before)
        };
        // Of several that explain no more than it does by itself, too.
        let margin = if after.causes.len() > 1 {
            RIVAL
        } else {
            -2.0 * RIVAL
        };
        let is_better = |c: &Candidate| c.fit.loss < after.loss + margin * inflation;
        let (mut term, mut unlisted) = (None, None);
        match alone {
            Some(alone) if after.causes.is_empty() => term = Some(alone),
            // Not where the readings wander: what then explains a little more may be theirs.
            Some(alone) if !self.wanders && is_better(&alone) => {
                after = before.clone();
                fitness_after = fitness_before.clone();
                unknown = fitness_after.worst(stated, &after);
                inflation = fitness::inflation(self.kind, &alone.fit);
                term = Some(alone);
            }
            _ if unknown.is_some() => term = self.describe(&after),
            Some(alone)
                if after.causes.len() == 1 && self.is_as_good(&alone, &after, inflation) =>
            {
                unlisted = Some(alone);
            }
            _ => {}
        }
        (self.progress)("what else could be");
        let mut findings = self.findings(&after, inflation, Some((&before, &tried)));
        if findings.len() > 1
            && findings.iter().any(|finding| !finding.is_identifiable)
            && let Some(one) = self.one_for_all(&before, &after, &mut tried, inflation)
        {
            after = one;
            fitness_after = self.fitness(stated, &after);
            unknown = fitness_after.unknown(stated, &after);
            findings = self.findings(&after, inflation, Some((&before, &tried)));
        }
        if let ([finding], Some(unlisted)) = (&mut findings[..], unlisted) {
            // With it three are named at most.
            finding.less_likely.splice(
                0..0,
                finding.rivals.drain(finding.rivals.len().min(RIVALS - 1)..),
            );
            finding.unlisted = Some(unlisted);
            finding.next = self.next(finding);
        }
        if let [finding] = &findings[..]
            && !finding.is_identifiable
        {
            for rival in &finding.rivals {
                tried.retain(|known| known.cause != rival.cause);
                tried.push(Candidate {
                    reported: Vec::new(),
                    ..rival.clone()
                });
            }
        }
        (self.progress)("data left out");
        let folds = folds(self.kind, self.settings);
        let scores =
            [&before, &after].map(|model| self.held_out(model, &folds).unwrap_or_default());
        let gains = gain::gains(self.kind, &scores[0], &scores[1], self.settings);
        let fitness = (fitness_before, fitness_after);
        Diagnosis {
            findings,
            unknown,
            term,
            tried,
            before,
            after,
            fitness,
            inflation,
            gains,
        }
    }

    /// Whether a parameter of a cause has gone as far as physics lets it.
    fn is_at_a_bound(&self, model: &Fit) -> bool {
        model
            .causes
            .iter()
            .any(|cause| self.goes_to_a_bound(model, *cause))
    }

    fn goes_to_a_bound(&self, model: &Fit, cause: usize) -> bool {
        self.kind.causes()[cause]
            .parameters
            .iter()
            .enumerate()
            .any(|(p, parameter)| {
                let x = model.terms.get(cause, p);
                let ends = [parameter.bounds.0, parameter.bounds.1];
                ends.iter().any(|end| {
                    *end != parameter.neutral && (x - end).abs() < 1e-6 * parameter.scale
                })
            })
    }

    /// Whether a term without an id explains the data about as well as the one cause of `model`.
    fn is_as_good(&self, term: &Candidate, model: &Fit, inflation: f64) -> bool {
        let parameters =
            2.0 * self.freedom(term.cause) as f64 - 2.0 * self.freedom(model.causes[0]) as f64;
        (term.fit.loss - model.loss + parameters) / inflation < RIVAL
    }

    fn freedom(&self, cause: usize) -> usize {
        self.kind.causes()[cause].parameters.len()
    }

    /// How telling a gain is: beyond what a thousandth of chance gains give with as many
    /// parameters.
    fn telling(&self, cause: usize, gain: f64) -> f64 {
        gain - quantile(self.freedom(cause), 0.999)
    }

    /// How much it is against a candidate that its effect is greater than is usual.
    fn surprise(&self, candidate: &Candidate) -> f64 {
        let cause = &self.kind.causes()[candidate.cause];
        let off = candidate.fit.terms.get(candidate.cause, 0) - cause.parameters[0].neutral;
        cause.usual.map_or(0.0, |usual| (off / usual).powi(2))
    }

    /// What a candidate is worth beside others: its gain, less what its parameters and its being a
    /// surprise cost.
    fn worth(&self, candidate: &Candidate, inflation: f64) -> f64 {
        let parameters = self.freedom(candidate.cause) as f64;
        candidate.gain / inflation - 2.0 * parameters - self.surprise(candidate)
    }

    /// Adds causes while they tell.
    fn forward(&mut self, before: &Fit) -> Option<Chosen> {
        let mut current = before.clone();
        let (mut tried, mut pairs) = (Vec::new(), Vec::new());
        let mut steps: Vec<(Fit, f64, f64)> = Vec::new();
        while current.causes.len() < self.settings.most {
            let Some(tangent) = Tangent::new(self.kind, &current, true) else {
                // As it is, a model that does not move says nothing; one with causes goes no
                // further.
                if steps.is_empty() {
                    return None;
                }
                break;
            };
            let threshold = self.threshold(&tangent);
            if !steps.is_empty() && !self.may_tell(&tangent, &current, threshold) {
                break;
            }
            let candidates = self.candidates(&current, Some(&tangent));
            if steps.is_empty() {
                tried.clone_from(&candidates);
                pairs = self.pairs(&tangent, &current);
            }
            let telling = |c: &&Candidate| self.telling(c.cause, c.gain) > threshold;
            let single = if candidates.iter().any(|c| telling(&c)) {
                self.best_on_data_left_out(&current, candidates)
            } else {
                None
            };
            let Some(best) = single else {
                let Some(pair) = self.best_pair(&tangent, &current) else {
                    break;
                };
                steps.push((pair.clone(), current.loss - pair.loss, threshold));
                current = pair;
                continue;
            };
            // What explains it best is too small to be told from faults of the model; what explains
            // less of it is no better.
            if self.effect(&current, &best.fit) < self.least_effect(best.cause, steps.len()) {
                break;
            }
            let needed =
                threshold + quantile(self.freedom(best.cause), 0.999) + self.surprise(&best);
            steps.push((best.fit.clone(), best.gain, needed));
            current = best.fit;
        }
        // What a unit of loss is worth is told by what the richest model leaves: about 1 if that is
        // noise. If it is not, the readings wander, and a further cause has to stand out from how
        // the model before it wanders.
        let richest = fitness::inflation(self.kind, &current);
        let wanders = self.wanders || richest > WANDERS;
        let mut model = before.clone();
        for (fit, gain, needed) in steps {
            let is_first = model.causes.is_empty();
            let inflation = if wanders && !is_first {
                fitness::inflation(self.kind, &model)
            } else {
                richest
            };
            let least = if wanders {
                SHARE * fitness::excess(self.kind, &model)
            } else {
                0.0
            };
            // How they wander is itself known poorly.
            let doubt = fit
                .causes
                .last()
                .map_or(0.0, |cause| quantile(self.freedom(*cause), 0.999));
            let needed = if wanders {
                needed.max(0.0) + doubt
            } else {
                needed
            };
            if gain / inflation < needed || gain < least {
                break;
            }
            model = fit;
        }
        let inflation = if wanders {
            fitness::inflation(self.kind, &model)
        } else {
            richest
        };
        Some(Chosen {
            model,
            richest: current,
            tried,
            pairs,
            inflation,
        })
    }

    /// One cause, wherever in its range, that explains the data as well as the several of `model`;
    /// then `tried` has all over their ranges.
    fn one_for_all(
        &self,
        before: &Fit,
        model: &Fit,
        tried: &mut Vec<Candidate>,
        inflation: f64,
    ) -> Option<Fit> {
        let mut far = tried.clone();
        self.look_far(before, &mut far);
        let best = far
            .iter()
            .min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss))?;
        let one = best.fit.clone();
        (one.loss < model.loss + RIVAL * inflation).then(|| {
            *tried = far;
            one
        })
    }

    /// Whether some candidate may come to the threshold, as far as its tangent tells it.
    fn may_tell(&self, tangent: &Tangent, current: &Fit, threshold: f64) -> bool {
        let Some(residuals) = Tangent::residuals(self.kind, current) else {
            return true;
        };
        tangent
            .candidates
            .iter()
            .any(|d| self.telling(d.cause, d.gain(&residuals)) > 0.5 * threshold)
    }

    /// Every two causes that can be reached in small steps, with what they gain together as far as
    /// those tell it; the best first.
    fn pairs(&self, tangent: &Tangent, current: &Fit) -> Vec<(f64, (usize, usize))> {
        let residuals = Tangent::residuals(self.kind, current).unwrap_or_default();
        tangent.best_pairs(&residuals, |cause| !self.kind.causes()[cause].is_apart())
    }

    /// Two causes, and what is found beside them, that explain the data better than several that
    /// were found one by one: what is best alone may be neither of them.
    fn better_pair(
        &mut self,
        before: &Fit,
        found: &Fit,
        pairs: &[(f64, (usize, usize))],
    ) -> Option<Chosen> {
        /// Pairs that are tried.
        const MOST: usize = 3;
        if found.causes.len() < 2 {
            return None;
        }
        let is_found =
            |(a, b): (usize, usize)| found.causes.contains(&a) && found.causes.contains(&b);
        let ahead: Vec<(usize, usize)> = pairs
            .iter()
            .map(|p| p.1)
            .take_while(|pair| !is_found(*pair))
            .take(MOST)
            .collect();
        let fitted = parallel::map(ahead.len(), |k| {
            let first = fit::fit_with(self.kind, before, ahead[k].0, &self.runs)?;
            fit::fit_with(self.kind, &first, ahead[k].1, &self.runs)
        });
        let pair = fitted
            .into_iter()
            .flatten()
            .min_by(|a, b| a.loss.total_cmp(&b.loss))?;
        let inflation = [found, &pair].map(|model| fitness::inflation(self.kind, model));
        let inflation = inflation[0].min(inflation[1]);
        let freedom = |model: &Fit| {
            model
                .causes
                .iter()
                .map(|c| self.freedom(*c) as f64)
                .sum::<f64>()
        };
        let gain = (found.loss - pair.loss) / inflation - 2.0 * (freedom(&pair) - freedom(found));
        if gain < RIVAL {
            None
        } else {
            self.forward(&pair)
        }
    }

    /// Two causes that together explain much of what is wrong, where neither does by itself: a gain
    /// and an offset that nearly cancel.
    fn best_pair(&self, tangent: &Tangent, current: &Fit) -> Option<Fit> {
        /// Loss that they must explain, far beyond what the best of all pairs does by chance.
        const LEAST: f64 = 60.0;
        /// Part of all that is wrong.
        const PART: f64 = 0.3;
        /// Pairs that are tried.
        const MOST: usize = 6;
        if current.causes.len() + 2 > self.settings.most {
            return None;
        }
        let least = LEAST.max(PART * fitness::excess(self.kind, current));
        let pairs = self.pairs(tangent, current);
        let folds = folds(self.kind, self.settings);
        let sum = |model: &Fit| Some(losses(&self.held_out(model, &folds)?).iter().sum::<f64>());
        let before = sum(current)?;
        // What small steps promise, bounds may forbid.
        pairs
            .into_iter()
            .take_while(|(gain, _)| *gain > least)
            .take(MOST)
            .find_map(|(_, pair)| {
                let first = fit::fit_with(self.kind, current, pair.0, &self.runs)?;
                let both = fit::fit_with(self.kind, &first, pair.1, &self.runs)?;
                let is_better = current.loss - both.loss > least && sum(&both)? < before;
                (is_better && self.effect(current, &both) >= self.kind.trust()).then_some(both)
            })
    }

    /// What the most telling of all candidates reaches by chance in the stated part of cases.
    fn threshold(&mut self, tangent: &Tangent) -> f64 {
        let draws: Vec<Vec<f64>> = (0..self.settings.draws)
            .map(|_| tangent.chance(self.kind, &mut self.random))
            .collect();
        let mut most: Vec<f64> = parallel::map(draws.len(), |k| {
            let of = |d: &crate::tangent::Direction| self.telling(d.cause, d.gain(&draws[k]));
            tangent
                .candidates
                .iter()
                .map(of)
                .fold(f64::NEG_INFINITY, f64::max)
        });
        most.sort_by(f64::total_cmp);
        let level = self.settings.false_alarms * (1.0 - UNKNOWN_PART);
        percentile(&most, 1.0 - level)
    }

    /// Every cause that is not yet on, with it switched on; the best first. Of those that a tangent
    /// shows to gain next to nothing, or much less than many others, no fit is made.
    fn candidates(&self, base: &Fit, tangent: Option<&Tangent>) -> Vec<Candidate> {
        let known = |fitted: &Fitted| {
            fitted
                .iter()
                .find(|f| f.0 == base.causes)
                .map(|f| f.1.clone())
        };
        if let Some(all) = known(&self.fitted.lock().unwrap_or_else(PoisonError::into_inner)) {
            return all;
        }
        let all = self.fit_candidates(base, tangent);
        self.fitted
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push((base.causes.clone(), all.clone()));
        all
    }

    fn fit_candidates(&self, base: &Fit, tangent: Option<&Tangent>) -> Vec<Candidate> {
        let off: Vec<usize> = match tangent.zip(Tangent::residuals(self.kind, base)) {
            Some((tangent, residuals)) => self.promising(tangent, &residuals),
            None => (0..self.kind.listed())
                .filter(|c| !base.causes.contains(c))
                .collect(),
        };
        // Those with many starts take long, and are given up early where others explain far more.
        let (far, near): (Vec<usize>, Vec<usize>) = off
            .into_iter()
            .partition(|cause| self.kind.causes()[*cause].is_apart());
        let mut fitted = self.fit_each(base, &near, 0.0);
        let best = fitted.iter().map(|c| c.gain).fold(0.0, f64::max);
        fitted.extend(self.fit_each(base, &far, LITTLE * best));
        let by_worth =
            |a: &Candidate, b: &Candidate| self.worth(b, 1.0).total_cmp(&self.worth(a, 1.0));
        fitted.sort_by(by_worth);
        // The best leaves more than noise, and one of the best goes as far as physics lets it:
        // small steps have not led to what explains the data.
        let is_lost = |best: &Candidate| {
            let mut bound = fitted
                .iter()
                .filter(|c| c.gain >= AMONG_THE_BEST * best.gain);
            bound.any(|c| self.goes_to_a_bound(&c.fit, c.cause))
                && fitness::inflation(self.kind, &best.fit) > WANDERS
        };
        if fitted.first().is_some_and(is_lost) {
            self.look_far(base, &mut fitted);
            fitted.sort_by(by_worth);
        }
        fitted
    }

    /// Adds to `fitted` every listed cause that explains more when its search starts from all over
    /// its range.
    fn look_far(&self, base: &Fit, fitted: &mut Vec<Candidate>) {
        let off: Vec<usize> = (0..self.kind.listed())
            .filter(|c| !base.causes.contains(c))
            .collect();
        let found = parallel::map(off.len(), |k| {
            (self.progress)(&format!(
                "{}: all of {}",
                base.causes.len() + 1,
                self.kind.causes()[off[k]].id
            ));
            fit::fit_far(self.kind, base, off[k], &self.runs)
        });
        for (&cause, fit) in off.iter().zip(found) {
            let Some(fit) = fit.filter(|fit| fit.loss < base.loss) else {
                continue;
            };
            let far = Candidate {
                cause,
                gain: base.loss - fit.loss,
                fit,
                reported: Vec::new(),
            };
            match fitted.iter_mut().find(|near| near.cause == cause) {
                Some(near) if near.gain < far.gain => *near = far,
                Some(_) => {}
                None => fitted.push(far),
            }
        }
    }

    /// `base` with each of `causes` that gains `enough` in its first steps.
    fn fit_each(&self, base: &Fit, causes: &[usize], enough: f64) -> Vec<Candidate> {
        let fitted = parallel::map(causes.len(), |k| {
            let cause = causes[k];
            (self.progress)(&format!(
                "{}: {}",
                base.causes.len() + 1,
                self.kind.causes()[cause].id
            ));
            let fit = fit::fit_if(self.kind, base, cause, &self.runs, enough)?;
            let gain = base.loss - fit.loss;
            (gain > 0.0).then_some(Candidate {
                cause,
                gain,
                fit,
                reported: Vec::new(),
            })
        });
        fitted.into_iter().flatten().collect()
    }

    /// Causes whose gain, as far as small changes tell it, is more than nothing and not far behind
    /// the best.
    fn promising(&self, tangent: &Tangent, residuals: &[f64]) -> Vec<usize> {
        /// So many are looked at.
        const MOST: usize = 14;
        /// A gain that chance gives often.
        const NOTHING: f64 = 4.0;
        let mut gains: Vec<(usize, f64)> = Vec::new();
        for direction in &tangent.candidates {
            let gain = direction.gain(residuals);
            match gains
                .iter_mut()
                .find(|(cause, _)| *cause == direction.cause)
            {
                Some(known) => known.1 = known.1.max(gain),
                None => gains.push((direction.cause, gain)),
            }
        }
        gains.sort_by(|a, b| b.1.total_cmp(&a.1));
        let best = gains.first().map_or(0.0, |g| g.1);
        // What cannot be reached in small steps is not told by them either.
        let is_apart = |cause: usize| self.kind.causes()[cause].is_apart();
        let near = |k: usize, (cause, gain): (usize, f64)| {
            let matters = k < MOST && gain > 0.03 * best;
            gain > NOTHING
                && (matters || gain > 0.6 * best || (is_apart(cause) && gain > 0.1 * best))
        };
        let mut all: Vec<usize> = gains
            .iter()
            .enumerate()
            .filter(|(k, g)| near(*k, **g))
            .map(|(_, g)| g.0)
            .collect();
        all.sort_unstable();
        all
    }

    /// By how many standard deviations two models differ in a run at most, for several readings of
    /// a channel (an event that comes a little later changes one): root mean square over the runs.
    fn effect(&self, a: &Fit, b: &Fit) -> f64 {
        /// So many.
        const LASTS: usize = 5;
        let of = |model: &Fit, run: usize| {
            fit::predicted(self.kind, run, &model.terms, &model.unknowns[run]).unwrap_or_default()
        };
        let worst = parallel::map(self.runs.len(), |run| {
            let (a, b) = (of(a, run), of(b, run));
            let differences = self.kind.logs()[run].readings.iter().zip(a.iter().zip(&b));
            let mut of_channel = vec![Vec::new(); self.kind.channels().len()];
            for (reading, (a, b)) in differences {
                of_channel[reading.channel].push((a - b).abs());
            }
            let lasting = |values: &Vec<f64>| {
                let least = |window: &[f64]| window.iter().copied().fold(f64::INFINITY, f64::min);
                values
                    .windows(LASTS.min(values.len().div_ceil(8).max(1)))
                    .map(least)
                    .fold(0.0, f64::max)
            };
            of_channel.iter().map(lasting).fold(0.0, f64::max)
        });
        (worst.iter().map(|x| x * x).sum::<f64>() / worst.len().max(1) as f64).sqrt()
    }

    /// Of the candidates that gain about as much as the first, the one that predicts data left out
    /// best; none if none predicts them better than the model without.
    fn best_on_data_left_out(
        &self,
        current: &Fit,
        candidates: Vec<Candidate>,
    ) -> Option<Candidate> {
        let first = candidates.first()?;
        let wanders = self.wanders || fitness::inflation(self.kind, &first.fit) > WANDERS;
        let behind = if wanders {
            0.5 * first.gain
        } else {
            RIVAL.max(0.02 * first.gain)
        };
        let least = first.gain - behind;
        let folds = folds(self.kind, self.settings);
        let losses = losses(&self.held_out(current, &folds)?);
        let mut near: Vec<(Candidate, Vec<f64>, f64)> = candidates
            .into_iter()
            .filter(|c| c.gain > least)
            .take(4)
            .filter_map(|candidate| {
                let with = crate::choose::losses(&self.held_out(&candidate.fit, &folds)?);
                let held_out: f64 = losses.iter().zip(&with).map(|(a, b)| a - b).sum();
                (held_out > 0.0).then_some((candidate, with, held_out))
            })
            .collect();
        // A surprise counts here too.
        near.sort_by(|a, b| (b.2 - self.surprise(&b.0)).total_cmp(&(a.2 - self.surprise(&a.0))));
        if wanders && !near.is_empty() {
            let best = near[0].1.clone();
            near.retain(|n| !is_worse(&n.1, &best));
            near.sort_by(|a, b| self.surprise(&a.0).total_cmp(&self.surprise(&b.0)));
        }
        near.into_iter().next().map(|(candidate, ..)| candidate)
    }

    /// What a model says of data left out; kept, as the same model is asked for again.
    fn held_out(&self, model: &Fit, folds: &[Fold]) -> Option<Vec<Score>> {
        let key = model.causes.clone();
        let known = |scores: &Mutex<Scores>| {
            scores
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .iter()
                .find(|s| s.0 == key)
                .map(|s| s.1.clone())
        };
        if let Some(scores) = known(&self.scores) {
            return Some(scores);
        }
        let scores = gain::held_out(self.kind, model, folds)?;
        self.scores
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .push((key, scores.clone()));
        Some(scores)
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

    /// With two causes or more, tries every other in the place of each: what was best alone need
    /// not be best in company.
    fn improve(&mut self, model: &mut Fit, inflation: f64) {
        if model.causes.len() < 2 {
            return;
        }
        for cause in model.causes.clone() {
            let Some(base) = self.without(model, cause) else {
                continue;
            };
            let tangent = Tangent::new(self.kind, &base, true);
            let candidates = self.candidates(&base, tangent.as_ref());
            let own = candidates
                .iter()
                .find(|c| c.cause == cause)
                .map(|c| self.worth(c, inflation));
            if let (Some(best), Some(own)) = (candidates.first(), own)
                && best.cause != cause
                && self.worth(best, inflation) > own + RIVAL
            {
                *model = best.fit.clone();
            }
        }
    }

    /// By how much `cause` must change readings beside so many others: those are never quite of the
    /// form of their terms.
    fn least_effect(&self, cause: usize, others: usize) -> f64 {
        let least = self.kind.least_effect(cause);
        if others > 0 {
            least.max(self.kind.trust())
        } else {
            least
        }
    }

    /// Takes out causes that the others have made needless.
    fn drop_needless(&self, model: &mut Fit, inflation: f64) {
        let mut k = 0;
        while model.causes.len() > 1 && k < model.causes.len() {
            let cause = model.causes[k];
            match self.without(model, cause) {
                Some(base)
                    if (base.loss - model.loss) / inflation
                        < quantile(self.freedom(cause), 0.999)
                        || self.effect(&base, model) < self.least_effect(cause, 1) =>
                {
                    *model = base;
                    k = 0;
                }
                _ => k += 1,
            }
        }
    }

    fn fitness(&mut self, stated: &dyn Kind, model: &Fit) -> Fitness {
        let level = self.settings.false_alarms * UNKNOWN_PART;
        fitness::fitness(stated, model, self.settings.draws, level, &mut self.random)
    }

    /// The term without a name that explains most of what `base` leaves, if it predicts data left
    /// out better.
    fn describe(&self, base: &Fit) -> Option<Candidate> {
        let terms: Vec<usize> = (self.kind.listed()..self.kind.causes().len()).collect();
        let fitted = parallel::map(terms.len(), |k| {
            let fit = fit::fit_with(self.kind, base, terms[k], &self.runs)?;
            Some(Candidate {
                cause: terms[k],
                gain: base.loss - fit.loss,
                fit,
                reported: Vec::new(),
            })
        });
        let mut best = fitted
            .into_iter()
            .flatten()
            .max_by(|a, b| a.gain.total_cmp(&b.gain))?;
        let folds = folds(self.kind, self.settings);
        let sum = |model: &Fit| {
            self.held_out(model, &folds)
                .map(|s| losses(&s).iter().sum::<f64>())
        };
        let inflation = fitness::inflation(self.kind, &best.fit);
        if sum(base)? - sum(&best.fit)? < quantile(1, 0.999) * inflation {
            return None;
        }
        report(self.kind, &mut best, inflation, false);
        Some(best)
    }

    /// The experiment that would tell the rivals of a finding apart.
    fn next(&self, finding: &Finding) -> Option<NextExperiment> {
        let others = finding
            .rivals
            .iter()
            .chain(&finding.less_likely)
            .chain(&finding.unlisted);
        let rivals: Vec<(usize, &Fit)> = std::iter::once(&finding.best)
            .chain(others)
            .map(|c| (c.cause, &c.fit))
            .collect();
        if rivals.len() < 2 {
            return None;
        }
        next::next(self.kind, &rivals, &self.kind.proposals())
    }

    /// What is to be said of each cause of the model.
    fn findings(
        &self,
        model: &Fit,
        inflation: f64,
        first: Option<(&Fit, &[Candidate])>,
    ) -> Vec<Finding> {
        let folds = folds(self.kind, self.settings);
        let with = self.held_out(model, &folds).map(|scores| losses(&scores));
        let mut all: Vec<Finding> = model
            .causes
            .iter()
            .filter_map(|&cause| {
                let (base, mut candidates) = match first {
                    // Alone it was found among all of them.
                    Some((before, tried)) if model.causes.len() == 1 => {
                        (before.clone(), tried.to_vec())
                    }
                    _ => {
                        let base = self.without(model, cause)?;
                        let tangent = Tangent::new(self.kind, &base, true);
                        let candidates = self.candidates(&base, tangent.as_ref());
                        (base, candidates)
                    }
                };
                let gain = base.loss - model.loss;
                let fit = model.clone();
                let mut best = Candidate {
                    cause,
                    gain,
                    fit,
                    reported: Vec::new(),
                };
                let told = report(self.kind, &mut best, inflation, true);
                if told.is_open {
                    // Others that hold the machine as well need not lie at the end of small steps.
                    self.look_far(&base, &mut candidates);
                }
                let worth = self.worth(&best, 1.0);
                let id = self.kind.causes()[cause].id;
                let with = with.as_ref();
                candidates.retain(|c| {
                    if (self.wanders || inflation > WANDERS)
                        && c.cause != cause
                        && c.gain > 0.5 * gain
                    {
                        let there = self.held_out(&c.fit, &folds).map(|scores| losses(&scores));
                        let is_alike = |a: Vec<f64>| with.is_some_and(|b| !is_worse(&a, b));
                        return self.kind.causes()[c.cause].id != id && there.is_some_and(is_alike);
                    }
                    // Without what speaks against a surprise: the data alone.
                    let other = &self.kind.causes()[c.cause];
                    let cost = 2.0 * (other.parameters.len() as f64 - self.freedom(cause) as f64);
                    let behind = (gain - c.gain + cost) / inflation;
                    let known = (worth - self.worth(c, 1.0)) / inflation;
                    let alike = (gain - c.gain).abs() < 1e-3 * gain.abs() + 0.5;
                    c.cause != cause
                        && other.id != id
                        && (alike || (behind < RIVAL && known < 30.0 * RIVAL))
                });
                let mut seen = vec![id];
                candidates.retain(|c| {
                    let id = self.kind.causes()[c.cause].id;
                    let is_new = !seen.contains(&id);
                    seen.push(id);
                    is_new
                });
                let cost = |c: &Candidate| 2.0 * self.freedom(c.cause) as f64 - c.gain;
                candidates.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
                for rival in &mut candidates {
                    // Where the data tell nothing but how strong an effect is at least, that is
                    // what is of interest.
                    report(self.kind, rival, inflation, told.is_open);
                }
                let without = self.held_out(&base, &folds).map(|scores| losses(&scores));
                let held_out = match (without, with) {
                    (Some(a), Some(b)) => a.iter().zip(b).map(|(a, b)| a - b).sum(),
                    _ => f64::NAN,
                };
                let less_likely = candidates.split_off(candidates.len().min(RIVALS));
                let mut finding = Finding {
                    best,
                    rivals: candidates,
                    less_likely,
                    unlisted: None,
                    held_out,
                    undetermined: told.undetermined,
                    is_identifiable: !told.is_open,
                    next: None,
                };
                finding.next = self.next(&finding);
                Some(finding)
            })
            .collect();
        all.sort_by(|a, b| b.best.gain.total_cmp(&a.best.gain));
        all
    }
}

/// Whether `a` is worse than `b`, loss of fold by fold of data left out, by more than the folds
/// scatter (Student's t, 2.5 %).
fn is_worse(a: &[f64], b: &[f64]) -> bool {
    let n = a.len() as f64;
    let mean = a.iter().zip(b).map(|(a, b)| a - b).sum::<f64>() / n;
    let square = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - b - mean).powi(2))
        .sum::<f64>()
        / (n - 1.0).max(1.0);
    let limit = StudentsT::new(0.0, 1.0, (n - 1.0).max(1.0))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
    mean > limit * (square / n).sqrt()
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
