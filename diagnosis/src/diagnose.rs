//! A diagnosis from its data to its answer: the stages in turn.

use rand_pcg::Pcg64;

use crate::evidence::Evidence;
use crate::finding::{Alone, Candidate, Diagnosis, Finding, Reported};
use crate::fit::{self, Fit};
use crate::fitness;
use crate::gain::{self, Gain};
use crate::kind::Kind;
use crate::policy::POLICY;
use crate::report;
use crate::settings::Settings;
use crate::stages::add::{self, Added};
use crate::stages::exchange::{exchange, one_for_two};
use crate::stages::prune::prune;
use crate::stages::unknown::{self, Before, Judged};
use crate::stages::{pairs, rivals, small};
use crate::view::View;

/// Which causes make the model of an experiment wrong; `progress` is told what is being done. None
/// where the model has no answer at its first guesses.
///
/// If even the richest model, or one term without a name, leaves much more than the stated noise,
/// the instruments drift, or something is at work that no cause explains. The search is then done
/// again with the observed scatter in place of the stated noise.
pub fn diagnose(
    kind: &dyn Kind,
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Option<Diagnosis> {
    progress("fitting the model as it is");
    let view = View::new(kind, settings);
    let stated = Search::new(&view, settings, progress, None)?;
    let Some(seen) = stated.rescaled(&view) else {
        return Some(stated.conclude(&view));
    };
    let search = Search::new(&seen, settings, progress, Some(stated.told()))?;
    // Readings that scatter independently are no fault of the model: jumps of a robot are never
    // quite the same.
    let judged_by = if fitness::is_white(&seen, &search.added.model) {
        &seen
    } else {
        &view
    };
    let mut diagnosis = search.conclude(judged_by);
    for (gain, channel) in diagnosis.gains.iter_mut().zip(view.channels()) {
        gain.noise = channel.noise;
    }
    Some(diagnosis)
}

/// A search after forward selection.
struct Search<'a> {
    evidence: Evidence<'a>,
    before: Fit,
    added: Added,
    random: Pcg64,
}

impl<'a> Search<'a> {
    fn new(
        kind: &'a dyn Kind,
        settings: &'a Settings,
        progress: &'a (dyn Fn(&str) + Sync),
        told: Option<Vec<usize>>,
    ) -> Option<Search<'a>> {
        let mut evidence = Evidence::new(kind, settings, progress, told.is_some());
        evidence.hints = told.unwrap_or_default();
        let mut random = Pcg64::new(u128::from(settings.seed), 7);
        let before = fit::fit_none(kind, &evidence.runs)?;
        let added = add::forward(&evidence, &before, &mut random)?;
        Some(Search {
            evidence,
            before,
            added,
            random,
        })
    }

    /// Causes that alone told much, or were found on the way.
    fn told(&self) -> Vec<usize> {
        let tried = &self.added.tried;
        let best = tried.iter().map(|c| c.gain).fold(0.0, f64::max);
        let much = tried.iter().filter(|c| c.gain > POLICY.gain_of_far * best);
        let mut all: Vec<usize> = much.map(|c| c.cause).collect();
        all.extend(&self.added.richest.causes);
        all
    }

    /// The experiment with the observed scatter; none where that is about the stated noise.
    fn rescaled<'k>(&self, view: &View<'k>) -> Option<View<'k>> {
        let seen = view.rescaled(&self.added.richest)?;
        // A term without a name may explain what the causes leave.
        unknown::describe(&self.evidence, &self.before)
            .is_none_or(|term| view.rescaled(&term.fit).is_some())
            .then_some(seen)
    }

    /// The answer; `stated` is the experiment with the noise that its residuals are judged by.
    fn conclude(mut self, stated: &dyn Kind) -> Diagnosis {
        let (model, inflation) = self.refined();
        let fitness_before =
            unknown::fitness(&self.evidence, stated, &self.before, &mut self.random);
        let before = Before {
            model: &self.before,
            fitness: &fitness_before,
            stated,
        };
        let mut judged =
            unknown::judge(&self.evidence, &before, model, inflation, &mut self.random);
        self.evidence.says("what else could be");
        let mut tried = std::mem::take(&mut self.added.tried);
        let findings = self.findings(stated, &mut judged, &mut tried);
        let small = if findings.is_empty() && judged.unknown.is_none() {
            small::small(&self.evidence, &self.before, &tried)
        } else {
            None
        };
        let left = (!findings.is_empty() && judged.unknown.is_none() && judged.fitness.is_gross)
            .then(|| judged.fitness.worst(stated, &judged.model))
            .flatten();
        self.evidence.says("data left out");
        Diagnosis {
            findings,
            left,
            common: self.common(&judged),
            alone: self.alone(&judged.model, &tried),
            unknown: judged.unknown,
            small,
            term: judged.term,
            tried,
            gains: self.gains(&judged.model),
            before: self.before,
            after: judged.model,
            fitness: (fitness_before, judged.fitness),
            inflation: judged.inflation,
        }
    }

    /// The causes that were added, compared with pairs, exchanged and pruned; with the variance
    /// inflation by which further gains are judged.
    fn refined(&mut self) -> (Fit, f64) {
        let (evidence, added) = (&self.evidence, &self.added);
        let (mut model, mut inflation) = (added.model.clone(), added.inflation);
        if let Some(pair) = pairs::better(evidence, &self.before, &model, &added.pairs)
            && let Some(better) = add::forward(evidence, &pair, &mut self.random)
        {
            (model, inflation) = (better.model, better.inflation);
        }
        model = exchange(evidence, model, inflation);
        if let Some(better) = one_for_two(evidence, &model, inflation) {
            inflation = evidence.inflation(&better);
            model = better;
        }
        (prune(evidence, model, inflation), inflation)
    }

    /// A finding for each cause; one for all where the data do not limit several.
    fn findings(
        &mut self,
        stated: &dyn Kind,
        judged: &mut Judged,
        tried: &mut Vec<Candidate>,
    ) -> Vec<Finding> {
        let (evidence, before) = (&self.evidence, &self.before);
        let of = |model: &Fit, tried: &[Candidate]| {
            rivals::findings(evidence, model, judged.inflation, before, tried)
        };
        let mut findings = of(&judged.model, tried);
        if findings.len() > 1
            && findings.iter().any(|finding| !finding.is_identifiable)
            && let Some(one) =
                rivals::one_for_all(evidence, before, &judged.model, tried, judged.inflation)
        {
            judged.fitness = unknown::fitness(evidence, stated, &one, &mut self.random);
            judged.unknown = judged.fitness.unknown(stated, &one);
            findings = of(&one, tried);
            judged.model = one;
        }
        let [finding] = &mut findings[..] else {
            return findings;
        };
        if let Some(unlisted) = judged.unlisted.take() {
            // With it three are named at most.
            let named = finding.rivals.len().min(POLICY.most_rivals - 1);
            finding
                .less_likely
                .splice(0..0, finding.rivals.drain(named..));
            finding.unlisted = Some(unlisted);
            finding.next = rivals::next(evidence, finding);
        }
        if !finding.is_identifiable {
            for rival in &finding.rivals {
                tried.retain(|known| known.cause != rival.cause);
                tried.push(Candidate {
                    reported: Vec::new(),
                    ..rival.clone()
                });
            }
        }
        findings
    }

    /// What nobody knows of the machine, as `judged` has it.
    fn common(&self, judged: &Judged) -> Vec<Reported> {
        let (kind, before) = (self.evidence.kind, &self.before);
        let of = |cause| {
            let mut one = Candidate::new(kind, cause, before, judged.model.clone());
            report::report(kind, &mut one, judged.inflation, false);
            one.reported
        };
        (0..kind.common()).flat_map(of).collect()
    }

    /// Of several causes, the best alone.
    fn alone(&self, after: &Fit, tried: &[Candidate]) -> Option<Alone> {
        let cause = tried.first().filter(|_| after.causes.len() > 1)?.clone();
        let gains = self.gains(&cause.fit);
        Some(Alone {
            rms: gains.into_iter().map(|gain| gain.rms.1).collect(),
            cause,
        })
    }

    /// What the causes are worth on data left out, channel by channel.
    fn gains(&self, after: &Fit) -> Vec<Gain> {
        let evidence = &self.evidence;
        let scores =
            [&self.before, after].map(|model| evidence.held_out(model).unwrap_or_default());
        gain::gains(evidence.kind, &scores[0], &scores[1], evidence.settings)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{Toy, noise, sum, wave};

    /// A cause explains nearly all; what is left beside it is ten standard deviations of the noise.
    #[test]
    fn much_that_a_cause_leaves_is_said_though_it_is_a_small_part() {
        let found = |left: f64| {
            let data = sum(&[(2000.0, &wave(0)), (left, &wave(5)), (1.0, &noise(1))]);
            let toy = Toy::new(&data, vec![wave(0), wave(9)]);
            diagnose(&toy, &Settings::default(), &|_| {}).expect("an answer")
        };
        let much = found(200.0);
        assert_eq!((much.findings.len(), &much.unknown), (1, &None));
        let left = much.left.expect("much is left");
        assert_eq!(left.channel, "y_m");
        assert!((left.rms - 10.0).abs() < 2.0, "{left:?}");
        assert_eq!(found(0.0).left, None);
    }
}
