//! Every promising cause beside a model, fitted.

use saltus_numeric::parallel;

use crate::evidence::Evidence;
use crate::finding::Candidate;
use crate::fit::{self, Fit};
use crate::policy::POLICY;
use crate::stages::screen;
use crate::tangent::Tangent;

/// Every promising cause that `base` does not have, fitted beside it; the best first.
pub(crate) fn candidates(
    evidence: &Evidence,
    base: &Fit,
    tangent: Option<&Tangent>,
) -> Vec<Candidate> {
    evidence.known_candidates(base, || fit_all(evidence, base, tangent))
}

/// The same, with the model linearised at `base` for it.
pub(crate) fn candidates_beside(evidence: &Evidence, base: &Fit) -> Vec<Candidate> {
    let tangent = Tangent::new(evidence.kind, base, true);
    candidates(evidence, base, tangent.as_ref())
}

fn fit_all(evidence: &Evidence, base: &Fit, tangent: Option<&Tangent>) -> Vec<Candidate> {
    let promising = match tangent.zip(Tangent::residuals(evidence.kind, base)) {
        Some((tangent, residuals)) if !screen::is_far_off(evidence, base) => {
            let mut all = screen::promising(evidence, base, tangent, &residuals);
            // Beside causes that explain most, scores are good enough.
            if base.causes.is_empty() {
                all.extend(&evidence.hints);
            }
            all.sort_unstable();
            all.dedup();
            all
        }
        _ => evidence.absent(base),
    };
    // Causes with many starts take long, and are given up early where others explain far more.
    let (far, near): (Vec<usize>, Vec<usize>) = promising
        .into_iter()
        .partition(|cause| evidence.kind.causes()[*cause].is_apart());
    let mut fitted = fit_each(evidence, base, &near, 0.0);
    let best = fitted.iter().map(|c| c.gain).fold(0.0, f64::max);
    fitted.extend(fit_each(evidence, base, &far, POLICY.gain_of_far * best));
    let by_gain = |a: &Candidate, b: &Candidate| {
        let gain = |c| evidence.penalised_gain(c, 1.0);
        gain(b).total_cmp(&gain(a))
    };
    fitted.sort_by(by_gain);
    if is_misled(evidence, &fitted) {
        look_far(evidence, base, &mut fitted);
        fitted.sort_by(by_gain);
    }
    fitted
}

/// Whether small steps have not led to what explains the data: the best candidate leaves more than
/// noise, and one of the best has gone as far as physics allows.
fn is_misled(evidence: &Evidence, fitted: &[Candidate]) -> bool {
    fitted.first().is_some_and(|best| {
        let mut near = fitted
            .iter()
            .filter(|c| c.gain >= POLICY.gain_at_bound * best.gain);
        near.any(|c| evidence.is_at_bound(&c.fit, c.cause))
            && evidence.inflation(&best.fit) > POLICY.correlated_inflation
    })
}

/// Replaces or adds in `fitted` every listed cause that explains more when its fit starts from
/// values over its whole range.
pub(crate) fn look_far(evidence: &Evidence, base: &Fit, fitted: &mut Vec<Candidate>) {
    let absent = evidence.absent(base);
    let found = parallel::map(absent.len(), |k| {
        let id = evidence.kind.causes()[absent[k]].id;
        evidence.says(&format!("{}: all of {id}", base.causes.len() + 1));
        let fit = fit::fit_far(evidence.kind, base, absent[k], &evidence.runs)?;
        (fit.loss < base.loss).then(|| Candidate::new(evidence.kind, absent[k], base, fit))
    });
    for far in found.into_iter().flatten() {
        match fitted.iter_mut().find(|near| near.cause == far.cause) {
            Some(near) if near.gain < far.gain => *near = far,
            Some(_) => {}
            None => fitted.push(far),
        }
    }
}

/// `base` with each of `causes` that gains `enough` in the first steps of its fit.
fn fit_each(evidence: &Evidence, base: &Fit, causes: &[usize], enough: f64) -> Vec<Candidate> {
    let fitted = parallel::map(causes.len(), |k| {
        let id = evidence.kind.causes()[causes[k]].id;
        evidence.says(&format!("{}: {id}", base.causes.len() + 1));
        let fit = fit::fit_if(evidence.kind, base, causes[k], &evidence.runs, enough)?;
        let candidate = Candidate::new(evidence.kind, causes[k], base, fit);
        (candidate.gain > 0.0).then_some(candidate)
    });
    fitted.into_iter().flatten().collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::toy::{Toy, sum, wave};

    #[test]
    fn each_gains_the_square_of_its_part() {
        let slanted = sum(&[(0.6, &wave(1)), (0.8, &wave(2))]);
        let toy = Toy::new(
            &sum(&[(9.0, &wave(0)), (20.0, &wave(1))]),
            vec![wave(0), wave(1), slanted],
        );
        let settings = Settings::default();
        let found = candidates_beside(&toy.evidence(&settings), &toy.before());
        let known = [(1, 400.0, 20.0), (2, 144.0, 12.0), (0, 81.0, 9.0)];
        assert_eq!(found.len(), 3);
        for (c, (cause, gain, value)) in found.iter().zip(known) {
            assert_eq!(c.cause, cause);
            assert!((c.gain - gain).abs() < 1e-3, "{} {gain}", c.gain);
            assert!((c.fit.terms.get(cause, 0) - value).abs() < 1e-3);
        }
    }

    /// A cause of which more is known to be unusual comes after one that explains somewhat less.
    #[test]
    fn what_is_unusual_comes_later() {
        let toy = Toy::new(
            &sum(&[(10.0, &wave(0)), (9.9, &wave(1))]),
            vec![wave(0), wave(1)],
        )
        .with(0, |cause| *cause = cause.clone().usual(2.5, "test"));
        let settings = Settings::default();
        let found = candidates_beside(&toy.evidence(&settings), &toy.before());
        // Penalty (10/2.5)² = 16 against a lead of 2.
        assert_eq!(found.iter().map(|c| c.cause).collect::<Vec<_>>(), [1, 0]);
    }

    /// A bound cuts the way to the better side; values over the whole range do not help, and the
    /// candidate stays at its bound.
    #[test]
    fn a_bound_holds_a_candidate() {
        let toy = Toy::new(&sum(&[(30.0, &wave(0))]), vec![wave(0)])
            .with(0, |cause| cause.parameters[0].bounds = (0.0, 12.0));
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let found = candidates_beside(&evidence, &toy.before());
        let value = found[0].fit.terms.get(0, 0);
        assert_eq!(value, 12.0);
        // 30² − 18².
        assert!((found[0].gain - 576.0).abs() < 1e-6);
        assert!(evidence.is_at_bound(&found[0].fit, 0));
    }
}
