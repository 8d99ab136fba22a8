//! What every stage of a diagnosis works on: the data with their model, and how well models fit
//! them.

use std::sync::{Mutex, PoisonError};

use saltus_numeric::parallel;
use saltus_numeric::statistics::rms;

use crate::discrepancy::Discrepancy;
use crate::finding::Candidate;
use crate::fit::{self, Fit};
use crate::fitness;
use crate::folds::{Fold, folds};
use crate::gain::{self, Score};
use crate::kind::Kind;
use crate::policy::POLICY;
use crate::settings::Settings;
use crate::statistics::chi_square;

/// Results of models, by their causes: the stages ask for the same models again.
struct Memo<T>(Mutex<Vec<(Vec<usize>, T)>>);

impl<T: Clone> Memo<T> {
    fn new() -> Memo<T> {
        Memo(Mutex::new(Vec::new()))
    }

    /// The result of the model with `causes`, computed by `make` where it is not known.
    fn get(&self, causes: &[usize], make: impl FnOnce() -> Option<T>) -> Option<T> {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = all().iter().find(|k| k.0 == causes).map(|k| k.1.clone());
        known.or_else(|| {
            let made = make()?;
            all().push((causes.to_vec(), made.clone()));
            Some(made)
        })
    }
}

/// An experiment under diagnosis.
pub(crate) struct Evidence<'a> {
    /// The data and their model.
    pub(crate) kind: &'a dyn Kind,
    pub(crate) settings: &'a Settings,
    progress: &'a (dyn Fn(&str) + Sync),
    /// Whether the observed scatter has taken the place of the stated noise.
    pub(crate) is_rescaled: bool,
    /// Causes that told much in an earlier search, and are fitted whatever their scores.
    pub(crate) hints: Vec<usize>,
    /// Indices of all runs.
    pub(crate) runs: Vec<usize>,
    folds: Vec<Fold>,
    /// The model's own error.
    pub(crate) discrepancy: Discrepancy,
    /// Number of readings.
    readings: usize,
    scores: Memo<Vec<Score>>,
    candidates: Memo<Vec<Candidate>>,
}

impl<'a> Evidence<'a> {
    pub(crate) fn new(
        kind: &'a dyn Kind,
        settings: &'a Settings,
        progress: &'a (dyn Fn(&str) + Sync),
        is_rescaled: bool,
    ) -> Evidence<'a> {
        Evidence {
            kind,
            settings,
            progress,
            is_rescaled,
            hints: Vec::new(),
            runs: (0..kind.logs().len()).collect(),
            folds: folds(kind, settings),
            discrepancy: Discrepancy::new(kind),
            readings: kind.logs().iter().map(|log| log.readings.len()).sum(),
            scores: Memo::new(),
            candidates: Memo::new(),
        }
    }

    /// Says what is being done.
    pub(crate) fn says(&self, what: &str) {
        (self.progress)(what);
    }

    /// How many causes may be at work at a time.
    pub(crate) fn most(&self) -> usize {
        self.settings.most.unwrap_or(self.kind.most())
    }

    /// Whether the machine has so many parts that the model as it is lacks several causes at once.
    pub(crate) fn lacks_several(&self) -> bool {
        self.most() > POLICY.many_causes
    }

    /// Listed causes that `model` does not have.
    pub(crate) fn absent(&self, model: &Fit) -> Vec<usize> {
        (self.kind.common()..self.kind.listed())
            .filter(|cause| !model.causes.contains(cause))
            .collect()
    }

    /// Degrees of freedom of a cause.
    pub(crate) fn degrees(&self, cause: usize) -> usize {
        self.kind.causes()[cause].parameters.len()
    }

    /// Degrees of freedom of the causes of a model.
    pub(crate) fn degrees_of(&self, model: &Fit) -> f64 {
        let each = model.causes.iter().map(|cause| self.degrees(*cause) as f64);
        each.sum()
    }

    /// Gain that chance gives one more cause with a probability of 0.1 %.
    pub(crate) fn gain_by_chance(&self, cause: usize) -> f64 {
        chi_square(self.degrees(cause), POLICY.chance_quantile)
    }

    /// Gain beyond chance: what makes causes with more and fewer parameters comparable.
    pub(crate) fn gain_beyond_chance(&self, cause: usize, gain: f64) -> f64 {
        gain - self.gain_by_chance(cause)
    }

    /// Prior penalty of a candidate, by what is known of its parameters.
    pub(crate) fn prior_penalty(&self, candidate: &Candidate) -> f64 {
        let cause = &self.kind.causes()[candidate.cause];
        cause.penalty(candidate.fit.terms.of(candidate.cause))
    }

    /// Whether a candidate contradicts what is known.
    pub(crate) fn contradicts(&self, candidate: &Candidate) -> bool {
        let cause = &self.kind.causes()[candidate.cause];
        cause.contradicts(candidate.fit.terms.of(candidate.cause))
    }

    /// Gain less the cost of the parameters (Akaike's criterion) and the prior penalty.
    pub(crate) fn penalised_gain(&self, candidate: &Candidate, inflation: f64) -> f64 {
        let parameters = self.degrees(candidate.cause) as f64;
        candidate.gain / inflation - 2.0 * parameters - self.prior_penalty(candidate)
    }

    /// Variance inflation of what `model` leaves.
    pub(crate) fn inflation(&self, model: &Fit) -> f64 {
        fitness::inflation(self.kind, model)
    }

    /// Variance inflation by which the difference in loss of two models is judged: that of the
    /// residuals, or what the model's own error does where the two differ, whichever is more.
    pub(crate) fn inflation_between(&self, a: &Fit, b: &Fit, inflation: f64) -> f64 {
        let (a, b) = (self.predicted(a), self.predicted(b));
        let difference: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
        let of_all = difference.len() == self.readings;
        let of_model = if of_all {
            self.discrepancy.inflation(&difference)
        } else {
            1.0
        };
        inflation.max(of_model)
    }

    /// What a model says of every reading (σ).
    fn predicted(&self, model: &Fit) -> Vec<f64> {
        let of = |run: &usize| {
            let unknowns = &model.unknowns[*run];
            fit::predicted(self.kind, *run, &model.terms, unknowns).unwrap_or_default()
        };
        self.runs.iter().flat_map(of).collect()
    }

    /// By how much the loss falls from `before` to `after` in units of what it is worth: that of each
    /// channel by the variance inflation of what `after` leaves there, `least` at least. So it is in
    /// an F test: what `before` leaves has the effect in it.
    pub(crate) fn judged_gain(&self, before: &Fit, after: &Fit, least: f64) -> f64 {
        let losses = [before, after].map(|model| {
            let mut losses = vec![0.0; self.kind.channels().len()];
            for (run, log) in self.kind.logs().iter().enumerate() {
                let unknowns = &model.unknowns[run];
                let residuals = fit::residuals(self.kind, run, &model.terms, unknowns);
                for (reading, r) in log.readings.iter().zip(residuals.unwrap_or_default()) {
                    losses[reading.channel] += fit::huber(r);
                }
            }
            losses
        });
        let inflations = fitness::inflations(self.kind, after);
        let each = losses[0].iter().zip(&losses[1]).zip(inflations);
        each.map(|((before, after), inflation)| (before - after) / inflation.max(least))
            .sum()
    }

    /// Whether residuals with this variance inflation are correlated, so that runs must be
    /// compared and not readings.
    pub(crate) fn is_correlated(&self, inflation: f64) -> bool {
        self.is_rescaled || inflation > POLICY.correlated_inflation
    }

    /// Whether whole runs are left out in turn, each of which tells of the others.
    pub(crate) fn has_runs(&self) -> bool {
        self.folds.len() > 1 && self.folds.iter().all(|fold| fold.masks.is_none())
    }

    /// Whether a parameter of `cause` has gone as far as physics allows.
    pub(crate) fn is_at_bound(&self, model: &Fit, cause: usize) -> bool {
        let parameters = self.kind.causes()[cause].parameters.iter().enumerate();
        parameters.into_iter().any(|(p, parameter)| {
            let x = model.terms.get(cause, p);
            let ends = [parameter.bounds.0, parameter.bounds.1];
            ends.iter()
                .any(|end| *end != parameter.neutral && (x - end).abs() < 1e-6 * parameter.scale)
        })
    }

    /// Least root mean square change of readings (σ) for which `cause` is reported, beside so many
    /// others: those never have quite the form of their terms.
    pub(crate) fn least_effect(&self, cause: usize, others: usize) -> f64 {
        let least = self.kind.least_effect(cause);
        if others > 0 {
            least.max(self.kind.trust())
        } else {
            least
        }
    }

    /// By how many σ the predictions of two models differ: in each run the greatest difference that
    /// lasts for several readings of a channel, root mean square over the runs.
    pub(crate) fn effect(&self, a: &Fit, b: &Fit) -> f64 {
        let worst = parallel::map(self.runs.len(), |run| self.effect_in(run, a, b));
        rms(&worst)
    }

    fn effect_in(&self, run: usize, a: &Fit, b: &Fit) -> f64 {
        let of = |model: &Fit| {
            fit::predicted(self.kind, run, &model.terms, &model.unknowns[run]).unwrap_or_default()
        };
        let differences = of(a)
            .iter()
            .zip(of(b))
            .map(|(a, b)| a - b)
            .collect::<Vec<_>>();
        self.lasting(run, &differences)
    }

    /// The same of a change of all readings (σ), run by run.
    pub(crate) fn effect_of(&self, change: &[f64]) -> f64 {
        let mut rest = change;
        let runs = self.kind.logs().iter().enumerate();
        let of = runs.map(|(run, log)| {
            let (here, after) = rest.split_at(log.readings.len());
            rest = after;
            self.lasting(run, here)
        });
        rms(&of.collect::<Vec<_>>())
    }

    /// The greatest of `differences` of a run that lasts for several readings of a channel.
    fn lasting(&self, run: usize, differences: &[f64]) -> f64 {
        let mut of_channel = vec![Vec::new(); self.kind.channels().len()];
        for (reading, difference) in self.kind.logs()[run].readings.iter().zip(differences) {
            of_channel[reading.channel].push(difference.abs());
        }
        let lasting = |values: &Vec<f64>| {
            let least = |window: &[f64]| window.iter().copied().fold(f64::INFINITY, f64::min);
            let length = POLICY.lasting_readings.min(values.len().div_ceil(8).max(1));
            values.windows(length).map(least).fold(0.0, f64::max)
        };
        of_channel.iter().map(lasting).fold(0.0, f64::max)
    }

    /// What a model predicts of data left out, fold by fold.
    pub(crate) fn held_out(&self, model: &Fit) -> Option<Vec<Score>> {
        self.scores.get(&model.causes, || {
            gain::held_out(self.kind, model, &self.folds)
        })
    }

    /// Its losses there.
    pub(crate) fn held_out_losses(&self, model: &Fit) -> Option<Vec<f64>> {
        let scores = self.held_out(model)?;
        Some(scores.iter().map(|score| score.loss).collect())
    }

    /// Their sum.
    pub(crate) fn held_out_loss(&self, model: &Fit) -> Option<f64> {
        Some(self.held_out_losses(model)?.iter().sum())
    }

    /// Candidates beside `base`, computed by `make` where they are not known.
    pub(crate) fn known_candidates(
        &self,
        base: &Fit,
        make: impl FnOnce() -> Vec<Candidate>,
    ) -> Vec<Candidate> {
        self.candidates
            .get(&base.causes, || Some(make()))
            .unwrap_or_default()
    }

    /// `model` without one of its causes, fitted again.
    pub(crate) fn without(&self, model: &Fit, cause: usize) -> Option<Fit> {
        /// Steps of the fit, which starts where it will nearly end.
        const STEPS: usize = 40;
        let mut base = model.clone();
        base.causes.retain(|c| *c != cause);
        for (p, parameter) in self.kind.causes()[cause].parameters.iter().enumerate() {
            base.terms.set(cause, p, parameter.neutral);
        }
        fit::refit(self.kind, base, &self.runs, &None, STEPS)
    }

    /// A candidate that is chosen: where several causes are lacking, its fit ended roughly, and is gone on with.
    pub(crate) fn settled(&self, mut candidate: Candidate) -> Candidate {
        let again = || {
            fit::refit(
                self.kind,
                candidate.fit.clone(),
                &self.runs,
                &None,
                fit::STEPS,
            )
        };
        if let Some(fit) = self.lacks_several().then(again).flatten() {
            candidate.gain += candidate.fit.loss - fit.loss;
            candidate.fit = fit;
        }
        candidate
    }

    /// `base` with `cause`.
    pub(crate) fn with(&self, base: &Fit, cause: usize) -> Option<Fit> {
        fit::fit_with(self.kind, base, cause, &self.runs)
    }

    /// `base` with two causes.
    pub(crate) fn with_pair(&self, base: &Fit, (a, b): (usize, usize)) -> Option<Fit> {
        self.with(&self.with(base, a)?, b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{READINGS, RUNS, Toy, sum, wave};

    /// A step of 2 σ over half of each run is an effect of 2; a spike of one reading is none.
    #[test]
    fn an_effect_is_what_lasts() {
        let half = |i: usize| {
            if i % READINGS < READINGS / 2 {
                2.0
            } else {
                0.0
            }
        };
        let spike = |i: usize| if i % READINGS == 7 { 50.0 } else { 0.0 };
        let column = |of: &dyn Fn(usize) -> f64| (0..RUNS * READINGS).map(of).collect::<Vec<_>>();
        let columns = vec![column(&half), column(&spike)];
        let toy = Toy::new(&sum(&[(1.0, &columns[0]), (1.0, &columns[1])]), columns);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let effect = |cause| evidence.effect(&toy.before(), &toy.fitted(&[cause]));
        // A robust fit is not quite what least squares gives: the loss of large residuals is cut.
        assert!((effect(0) - 2.0).abs() < 0.3, "{}", effect(0));
        assert!(effect(1) < 1e-6, "{}", effect(1));
    }

    /// Of an orthonormal column the other folds tell the parameter, and it is off by the part of the
    /// effect that lies in the fold.
    #[test]
    fn data_left_out_are_predicted_by_the_others() {
        let toy = Toy::new(&sum(&[(20.0, &wave(0))]), vec![wave(0)]);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let before = evidence.held_out_loss(&toy.before()).expect("a loss");
        let after = evidence.held_out_loss(&toy.fitted(&[0])).expect("a loss");
        assert!(
            (before - 400.0).abs() < 1e-6 && after < 1e-3,
            "{before} {after}"
        );
    }

    #[test]
    fn a_model_without_a_cause_is_fitted_again() {
        let slanted = sum(&[(0.6, &wave(0)), (0.8, &wave(1))]);
        let toy = Toy::new(&sum(&[(10.0, &slanted)]), vec![wave(0), slanted]);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let both = toy.fitted(&[1, 0]);
        let one = evidence.without(&both, 1).expect("a fit");
        assert_eq!(one.causes, [0]);
        assert!((one.terms.get(0, 0) - 6.0).abs() < 1e-3 && one.terms.get(1, 0) == 0.0);
        assert!((one.loss - 64.0).abs() < 1e-3);
    }
}
