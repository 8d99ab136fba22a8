//! Unknown effects: whether what the causes leave is noise, and the term without a name that
//! describes it best.

use rand_pcg::Pcg64;
use saltus_numeric::parallel;

use crate::evidence::Evidence;
use crate::finding::Candidate;
use crate::fit::Fit;
use crate::fitness::{self, Fitness, Unknown};
use crate::kind::Kind;
use crate::policy::POLICY;
use crate::report::report;
use crate::statistics::chi_square;

/// A model with what it leaves.
pub(crate) struct Judged {
    /// The model; the one without a cause where its causes are not believed.
    pub(crate) model: Fit,
    pub(crate) inflation: f64,
    pub(crate) fitness: Fitness,
    /// What is left that is not noise.
    pub(crate) unknown: Option<Unknown>,
    /// The term without a name that describes it.
    pub(crate) term: Option<Candidate>,
    /// A term without a name that explains the data as well as the one cause.
    pub(crate) unlisted: Option<Candidate>,
}

/// The model without a cause, with how well it fits.
pub(crate) struct Before<'a> {
    pub(crate) model: &'a Fit,
    pub(crate) fitness: &'a Fitness,
    /// The experiment with the noise that its residuals are judged by.
    pub(crate) stated: &'a dyn Kind,
}

/// How well `model` fits; the part of the false-alarm rate for unknown effects is its level.
pub(crate) fn fitness(
    evidence: &Evidence,
    stated: &dyn Kind,
    model: &Fit,
    random: &mut Pcg64,
) -> Fitness {
    let level = evidence.settings.false_alarms * POLICY.unknown_share;
    fitness::fitness(stated, model, evidence.settings.draws, level, random)
}

/// Judges what `model` leaves, beside what the model without a cause leaves.
pub(crate) fn judge(
    evidence: &Evidence,
    before: &Before,
    model: Fit,
    inflation: f64,
    random: &mut Pcg64,
) -> Judged {
    let fitness = if model.causes.is_empty() {
        before.fitness.clone()
    } else {
        fitness(evidence, before.stated, &model, random)
    };
    let mut judged = Judged {
        unknown: fitness.unknown(before.stated, &model),
        model,
        inflation,
        fitness,
        term: None,
        unlisted: None,
    };
    judged.weigh(evidence, before);
    judged.describe(evidence, before);
    judged
}

impl Judged {
    /// Whether what is left is a fault of the form of a term, something unknown beside the causes,
    /// or shows that the causes are not at work.
    fn weigh(&mut self, evidence: &Evidence, before: &Before) {
        let left = self.fitness.squares / before.fitness.squares.max(1e-12);
        let has_causes = !self.model.causes.is_empty();
        // One run does not tell what repeats.
        let form_error = if evidence.runs.len() == 1 {
            POLICY.form_error_of_one_run
        } else {
            POLICY.form_error
        };
        if left < form_error && has_causes {
            self.unknown = None;
        }
        let explains_little = left > 1.0 - POLICY.explained;
        if self.fitness.is_gross && (!has_causes || explains_little) {
            self.unknown = self.fitness.worst(before.stated, &self.model);
        }
        let mut causes = self.model.causes.iter();
        let is_bent = explains_little
            || (left > POLICY.form_error
                && causes.any(|cause| evidence.is_at_bound(&self.model, *cause)));
        if self.unknown.is_some() && has_causes && is_bent {
            // Listed causes bent to something else are worse than none.
            self.go_back(before);
            let unknown = self.fitness.unknown(before.stated, &self.model);
            self.unknown = unknown.or(self.unknown.take());
            self.inflation = evidence.inflation(&self.model);
        }
    }

    fn go_back(&mut self, before: &Before) {
        self.model = before.model.clone();
        self.fitness = before.fitness.clone();
    }

    /// Finds the term without a name for what is left; it takes the place of the causes where it
    /// explains clearly more than they do.
    fn describe(&mut self, evidence: &Evidence, before: &Before) {
        let is_as_believed = self.model.causes.is_empty() && self.unknown.is_none();
        let alone = if is_as_believed {
            None
        } else {
            describe(evidence, before.model)
        };
        match alone {
            Some(alone) if self.model.causes.is_empty() => self.term = Some(alone),
            Some(alone) if self.is_better(evidence, &alone) => {
                self.go_back(before);
                self.unknown = self.fitness.worst(before.stated, &self.model);
                self.inflation = evidence.inflation(&alone.fit);
                self.term = Some(alone);
            }
            _ if self.unknown.is_some() => self.term = describe(evidence, &self.model),
            Some(alone) if self.is_as_good(evidence, &alone) => self.unlisted = Some(alone),
            _ => {}
        }
    }

    /// Whether a term alone explains clearly more than the one cause, or no less than several.
    fn is_better(&self, evidence: &Evidence, term: &Candidate) -> bool {
        let margin = if self.model.causes.len() > 1 {
            POLICY.rival_loss
        } else {
            -2.0 * POLICY.rival_loss
        };
        // Not where instruments drift: what then explains a little more may be theirs.
        let inflation = evidence.inflation_between(&term.fit, &self.model, self.inflation);
        !evidence.is_rescaled && term.fit.loss < self.model.loss + margin * inflation
    }

    /// Whether a term explains the data about as well as the one cause.
    fn is_as_good(&self, evidence: &Evidence, term: &Candidate) -> bool {
        let [cause] = self.model.causes[..] else {
            return false;
        };
        let degrees = |cause| 2.0 * evidence.degrees(cause) as f64;
        let parameters = degrees(term.cause) - degrees(cause);
        let inflation = evidence.inflation_between(&term.fit, &self.model, self.inflation);
        let behind = (term.fit.loss - self.model.loss + parameters) / inflation;
        behind + evidence.prior_penalty(term) < POLICY.rival_loss
    }
}

/// The term without a name that explains most of what `base` leaves; none where it does not predict
/// data left out better.
pub(crate) fn describe(evidence: &Evidence, base: &Fit) -> Option<Candidate> {
    let kind = evidence.kind;
    let terms: Vec<usize> = (kind.listed()..kind.causes().len()).collect();
    let fitted = parallel::map(terms.len(), |k| {
        let fit = evidence.with(base, terms[k])?;
        Some(Candidate::new(kind, terms[k], base, fit))
    });
    let mut best = fitted
        .into_iter()
        .flatten()
        .max_by(|a, b| a.gain.total_cmp(&b.gain))?;
    let inflation = evidence.inflation_between(base, &best.fit, evidence.inflation(&best.fit));
    let gain = evidence.held_out_loss(base)? - evidence.held_out_loss(&best.fit)?;
    if gain < chi_square(1, POLICY.chance_quantile) * inflation {
        return None;
    }
    report(kind, &mut best, inflation, false);
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::toy::{Toy, noise, sum, wave};

    fn judged(toy: &Toy, causes: &[usize]) -> Judged {
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let mut random = Pcg64::new(1, 1);
        let model = toy.before();
        let before = Before {
            fitness: &fitness(&evidence, toy, &model, &mut random),
            model: &model,
            stated: toy,
        };
        let fit = toy.fitted(causes);
        judge(&evidence, &before, fit, 1.0, &mut random)
    }

    /// Noise is called unknown in 1 % of cases; 5 of 40 are a fault.
    #[test]
    fn noise_is_nothing_unknown() {
        let alarms = (0..40)
            .filter(|seed| {
                judged(&Toy::new(&noise(*seed), vec![wave(0)]), &[])
                    .unknown
                    .is_some()
            })
            .count();
        assert!(alarms < 5, "{alarms}");
    }

    #[test]
    fn what_no_cause_explains_is_unknown_and_described() {
        let data = sum(&[(40.0, &wave(5)), (1.0, &noise(1))]);
        let toy = Toy::new(&data, vec![wave(0), wave(5)]).with_a_term();
        let found = judged(&toy, &[]);
        let unknown = found.unknown.expect("unknown");
        assert_eq!(unknown.channel, "y_m");
        let term = found.term.expect("a term");
        assert!(term.cause == 1 && (term.reported[0].value - 40.0).abs() < 3.0);
    }

    /// A cause that was bent to something else is not reported: what has the form of the unnamed
    /// term explains clearly more.
    #[test]
    fn a_term_that_explains_more_takes_the_place_of_a_cause() {
        let data = sum(&[(40.0, &wave(5)), (1.0, &noise(2))]);
        let near = sum(&[(0.9, &wave(5)), (0.436, &wave(1))]);
        let found = judged(&Toy::new(&data, vec![near, wave(5)]).with_a_term(), &[0]);
        assert!(found.model.causes.is_empty() && found.unknown.is_some());
        assert_eq!(found.term.expect("a term").cause, 1);
    }

    /// The cause and the term have nearly the same form: the cause is found, and may be the term.
    #[test]
    fn a_term_that_explains_as_much_is_a_rival() {
        let data = sum(&[(40.0, &wave(5)), (1.0, &noise(3))]);
        let near = sum(&[(0.999, &wave(5)), (0.0447, &wave(1))]);
        let found = judged(&Toy::new(&data, vec![wave(5), near]).with_a_term(), &[0]);
        assert_eq!(found.model.causes, [0]);
        assert!(found.unknown.is_none() && found.unlisted.is_some());
    }
}
