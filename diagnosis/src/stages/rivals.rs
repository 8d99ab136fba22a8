//! Rivals: for each cause found, those that the data cannot tell from it.

use crate::evidence::Evidence;
use crate::finding::{Candidate, Finding};
use crate::fit::Fit;
use crate::next::{self, NextExperiment};
use crate::policy::POLICY;
use crate::report::report;
use crate::stages::candidates::{candidates_beside, look_far};
use crate::statistics::is_worse;

/// One finding for each cause of `model`, the one with the greatest gain first. `tried` are the
/// causes alone beside `before`.
pub(crate) fn findings(
    evidence: &Evidence,
    model: &Fit,
    inflation: f64,
    before: &Fit,
    tried: &[Candidate],
) -> Vec<Finding> {
    let of = |&cause: &usize| {
        // Alone it was found among all of them.
        let (base, candidates) = if model.causes.len() == 1 {
            (before.clone(), tried.to_vec())
        } else {
            let base = evidence.without(model, cause)?;
            let candidates = candidates_beside(evidence, &base);
            (base, candidates)
        };
        let best = Candidate::new(evidence.kind, cause, &base, model.clone());
        Some(finding(evidence, best, &base, candidates, inflation))
    };
    let mut all: Vec<Finding> = model.causes.iter().filter_map(of).collect();
    all.sort_by(|a, b| b.best.gain.total_cmp(&a.best.gain));
    all
}

fn finding(
    evidence: &Evidence,
    mut best: Candidate,
    base: &Fit,
    mut candidates: Vec<Candidate>,
    inflation: f64,
) -> Finding {
    let known = report(evidence.kind, &mut best, inflation, true);
    if known.is_unlimited {
        // Others that hold the machine as well need not lie at the end of small steps.
        look_far(evidence, base, &mut candidates);
    }
    let all = rivals(evidence, &best, candidates, inflation);
    // Where all contradict what is known, none does so more than the others.
    let (contradicting, mut rivals): (Vec<_>, Vec<_>) = all
        .into_iter()
        .partition(|rival| evidence.contradicts(rival) && !evidence.contradicts(&best));
    for rival in &mut rivals {
        // Where the data tell only how strong an effect is at least, that is what is of interest.
        report(evidence.kind, rival, inflation, known.is_unlimited);
    }
    let losses = |model| evidence.held_out_losses(model);
    let held_out = match (losses(base), losses(&best.fit)) {
        (Some(a), Some(b)) => a.iter().zip(&b).map(|(a, b)| a - b).sum(),
        _ => f64::NAN,
    };
    let less_likely = rivals.split_off(rivals.len().min(POLICY.most_rivals));
    let mut finding = Finding {
        best,
        rivals,
        less_likely,
        contradicting,
        unlisted: None,
        held_out,
        undetermined: known.undetermined,
        is_identifiable: !known.is_unlimited,
        next: None,
    };
    finding.next = next(evidence, &finding);
    finding
}

/// Of `candidates` those that the data cannot tell from `best`, one for each id, the nearest first.
fn rivals(
    evidence: &Evidence,
    best: &Candidate,
    candidates: Vec<Candidate>,
    inflation: f64,
) -> Vec<Candidate> {
    let mut rivals = candidates;
    rivals.retain(|c| c.cause != best.cause && is_rival(evidence, best, c, inflation));
    let mut seen = vec![best.id];
    rivals.retain(|c| {
        let is_new = !seen.contains(&c.id);
        seen.push(c.id);
        is_new
    });
    let cost = |c: &Candidate| 2.0 * evidence.degrees(c.cause) as f64 - c.gain;
    rivals.sort_by(|a, b| cost(a).total_cmp(&cost(b)));
    rivals
}

/// Whether the data cannot tell `other` from `best`.
fn is_rival(evidence: &Evidence, best: &Candidate, other: &Candidate, inflation: f64) -> bool {
    if evidence.is_correlated(inflation) && other.gain > POLICY.rival_part_correlated * best.gain {
        // Runs are compared, and not readings.
        let losses = |model| evidence.held_out_losses(model);
        return match (losses(&other.fit), losses(&best.fit)) {
            (Some(a), Some(b)) => !is_worse(&a, &b),
            _ => false,
        };
    }
    let inflation = evidence.inflation_between(&best.fit, &other.fit, inflation);
    // The data alone: without the prior penalty.
    let degrees = |c: &Candidate| evidence.degrees(c.cause) as f64;
    let parameters = 2.0 * (degrees(other) - degrees(best));
    let lead = best.gain - other.gain;
    let behind = (lead + parameters) / inflation;
    lead.abs() < POLICY.equal_gain * best.gain.abs() + 0.5 || behind < POLICY.rival_loss
}

/// The experiment that would tell a finding and its rivals apart.
pub(crate) fn next(evidence: &Evidence, finding: &Finding) -> Option<NextExperiment> {
    let others = finding
        .rivals
        .iter()
        .chain(&finding.less_likely)
        .chain(&finding.unlisted);
    let all: Vec<(usize, &Fit)> = std::iter::once(&finding.best)
        .chain(others)
        .map(|c| (c.cause, &c.fit))
        .collect();
    if all.len() < 2 {
        return None;
    }
    next::next(evidence.kind, &all, &evidence.kind.proposals())
}

/// One cause, wherever in its range, that explains the data as well as the several of `model`; then
/// `tried` has all causes over their ranges.
pub(crate) fn one_for_all(
    evidence: &Evidence,
    before: &Fit,
    model: &Fit,
    tried: &mut Vec<Candidate>,
    inflation: f64,
) -> Option<Fit> {
    let mut far = tried.clone();
    look_far(evidence, before, &mut far);
    let best = far
        .iter()
        .min_by(|a, b| a.fit.loss.total_cmp(&b.fit.loss))?;
    let one = best.fit.clone();
    let inflation = evidence.inflation_between(&one, model, inflation);
    (one.loss < model.loss + POLICY.rival_loss * inflation).then(|| {
        *tried = far;
        one
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::toy::{Toy, sum, wave};

    /// A column at angle δ to the effect explains cos²δ of it: the data tell the two apart where
    /// they lose more than 4 by it.
    fn toy(size: f64, angles: &[f64]) -> Toy {
        let mut columns = vec![wave(0)];
        for (k, angle) in angles.iter().enumerate() {
            let (sin, cos) = angle.sin_cos();
            columns.push(sum(&[(cos, &wave(0)), (sin, &wave(k + 1))]));
        }
        Toy::new(&sum(&[(size, &wave(0))]), columns)
    }

    fn found(toy: &Toy) -> Finding {
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let before = toy.before();
        let tried = candidates_beside(&evidence, &before);
        let mut all = findings(&evidence, &toy.fitted(&[0]), 1.0, &before, &tried);
        assert_eq!(all.len(), 1);
        all.remove(0)
    }

    /// Losses 400 sin²δ: 3.9 and 4.1.
    #[test]
    fn the_limit_is_a_likelihood_ratio_of_seven() {
        let angle = |loss: f64| (loss / 400.0).sqrt().asin();
        let finding = found(&toy(20.0, &[angle(3.9), angle(4.1), angle(30.0)]));
        let named: Vec<usize> = finding.rivals.iter().map(|r| r.cause).collect();
        assert_eq!(named, [1]);
        assert!((finding.best.gain - 400.0).abs() < 1e-6);
        assert!((finding.rivals[0].gain - 396.1).abs() < 1e-2);
        assert!(finding.is_identifiable && finding.less_likely.is_empty());
    }

    #[test]
    fn two_are_named_and_the_others_are_less_likely() {
        let finding = found(&toy(20.0, &[0.08, 0.02, 0.04, 0.06]));
        let causes = |all: &[Candidate]| all.iter().map(|r| r.cause).collect::<Vec<_>>();
        assert_eq!(causes(&finding.rivals), [2, 3]);
        assert_eq!(causes(&finding.less_likely), [4, 1]);
    }

    /// What is known of a cause tells it from one that explains the data as well.
    #[test]
    fn a_rival_that_contradicts_what_is_known_is_set_apart() {
        let toy = toy(20.0, &[0.02, 0.04]).with(1, |c| *c = c.clone().usual(1.0, "test"));
        let finding = found(&toy);
        let causes = |all: &[Candidate]| all.iter().map(|r| r.cause).collect::<Vec<_>>();
        assert_eq!(causes(&finding.rivals), [2]);
        assert_eq!(causes(&finding.contradicting), [1]);
        let away = finding.contradicting[0].deviations[0].size();
        assert!((away - 20.0).abs() < 0.1, "{away}");
    }

    #[test]
    fn a_cause_is_no_rival_of_its_own_id() {
        let toy = toy(20.0, &[0.02]).with(1, |cause| cause.id = "a");
        assert!(found(&toy).rivals.is_empty());
    }

    /// One column that is the sum of two explains what both do.
    #[test]
    fn one_stands_for_all() {
        let both = sum(&[(0.6, &wave(0)), (0.8, &wave(1))]);
        let toy = Toy::new(&sum(&[(15.0, &both)]), vec![wave(0), wave(1), both]);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let before = toy.before();
        let mut tried = candidates_beside(&evidence, &before);
        let one = one_for_all(&evidence, &before, &toy.fitted(&[0, 1]), &mut tried, 1.0);
        assert_eq!(one.expect("one").causes, [2]);
    }
}
