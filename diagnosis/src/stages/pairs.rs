//! Two causes at a time: a gain and an offset may nearly cancel, and then neither explains much
//! alone.

use saltus_numeric::parallel;

use crate::evidence::Evidence;
use crate::fit::Fit;
use crate::fitness;
use crate::policy::POLICY;
use crate::tangent::{Pair, Tangent};

/// Every two causes that can be reached in small steps, with the gain that the linearised model
/// promises; the best first.
pub(crate) fn by_score(evidence: &Evidence, tangent: &Tangent, base: &Fit) -> Vec<Pair> {
    let residuals = Tangent::residuals(evidence.kind, base).unwrap_or_default();
    tangent.best_pairs(&residuals, |cause| {
        !evidence.kind.causes()[cause].is_apart()
    })
}

/// `base` with two causes that together explain much of the misfit and predict left-out data
/// better; none where there are none, or no room for two.
pub(crate) fn add(evidence: &Evidence, tangent: &Tangent, base: &Fit) -> Option<Fit> {
    if base.causes.len() + 2 > evidence.most() {
        return None;
    }
    let misfit = fitness::excess(evidence.kind, base);
    let least = |inflation: f64| (POLICY.pair_gain * inflation).max(POLICY.pair_part * misfit);
    let pairs = by_score(evidence, tangent, base);
    let before = evidence.held_out_loss(base)?;
    // What small steps promise, bounds may forbid.
    let promising = pairs.into_iter().take_while(|pair| pair.gain > least(1.0));
    promising.take(POLICY.pairs_fitted).find_map(|pair| {
        let both = evidence.with_pair(base, pair.causes)?;
        let least = least(evidence.inflation_between(base, &both, 1.0));
        let is_better = base.loss - both.loss > least && evidence.held_out_loss(&both)? < before;
        (is_better && evidence.effect(base, &both) >= evidence.kind.trust()).then_some(both)
    })
}

/// Two causes that explain the data better than those of `found`, which were found one by one: the
/// best alone may be neither of the two.
pub(crate) fn better(
    evidence: &Evidence,
    before: &Fit,
    found: &Fit,
    pairs: &[Pair],
) -> Option<Fit> {
    if found.causes.len() < 2 {
        return None;
    }
    let is_found = |pair: &Pair| {
        let (a, b) = pair.causes;
        found.causes.contains(&a) && found.causes.contains(&b)
    };
    let ahead: Vec<&Pair> = pairs
        .iter()
        .take_while(|pair| !is_found(pair))
        .take(POLICY.pairs_compared)
        .collect();
    let fitted = parallel::map(ahead.len(), |k| evidence.with_pair(before, ahead[k].causes));
    let pair = fitted
        .into_iter()
        .flatten()
        .min_by(|a, b| a.loss.total_cmp(&b.loss))?;
    let inflation = evidence.inflation(found).min(evidence.inflation(&pair));
    let inflation = evidence.inflation_between(found, &pair, inflation);
    let parameters = 2.0 * (evidence.degrees_of(&pair) - evidence.degrees_of(found));
    let gain = (found.loss - pair.loss) / inflation - parameters;
    (gain >= POLICY.rival_loss).then_some(pair)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Kind;
    use crate::settings::Settings;
    use crate::toy::{Toy, noise, sum, wave};

    /// a and b = cos δ a + sin δ n nearly cancel: of n alone, each explains sin²δ, both all of it.
    fn nearly_cancelling(size: f64, seed: u128) -> Toy {
        let (sin, cos) = 0.1_f64.sin_cos();
        let b = sum(&[(cos, &wave(0)), (sin, &wave(1))]);
        let data = sum(&[(size, &wave(1)), (1.0, &noise(seed))]);
        Toy::new(&data, vec![wave(0), b, wave(2)])
    }

    #[test]
    fn two_that_nearly_cancel_are_found_together() {
        let toy = nearly_cancelling(25.0, 1);
        let settings = Settings::default();
        let (evidence, before) = (toy.evidence(&settings), toy.before());
        let tangent = Tangent::new(&toy, &before, true).expect("a tangent");
        let best = &by_score(&evidence, &tangent, &before)[0];
        let part = |k: usize| {
            let readings = toy.logs().iter().flat_map(|log| &log.readings);
            readings.zip(wave(k)).map(|(r, w)| r.value * w).sum::<f64>()
        };
        let known = part(0).powi(2) + part(1).powi(2);
        assert_eq!(best.causes, (0, 1));
        // Outliers beyond 3 σ count less.
        assert!(
            (best.gain / known - 1.0).abs() < 0.1,
            "{} {known}",
            best.gain
        );
        let found = add(&evidence, &tangent, &before).expect("a pair");
        assert_eq!(found.causes, [0, 1]);
        let value = found.terms.get(1, 0) * 0.1_f64.sin();
        assert!((value - 25.0).abs() < 3.0, "{value}");
    }

    #[test]
    fn what_chance_may_give_a_pair_is_not_enough() {
        let toy = nearly_cancelling(6.0, 2);
        let settings = Settings::default();
        let (evidence, before) = (toy.evidence(&settings), toy.before());
        let tangent = Tangent::new(&toy, &before, true).expect("a tangent");
        assert!(add(&evidence, &tangent, &before).is_none());
        let full = toy.fitted(&[0, 2]);
        let tangent = Tangent::new(&toy, &full, true).expect("a tangent");
        assert!(add(&evidence, &tangent, &full).is_none(), "no room for two");
    }

    /// The best alone, a + b, takes a place that two others deserve.
    #[test]
    fn a_pair_replaces_what_was_found_one_by_one() {
        let data = sum(&[(20.0, &wave(0)), (20.0, &wave(1)), (1.0, &noise(3))]);
        let tilted = sum(&[(0.7, &wave(0)), (0.7, &wave(1)), (0.14, &wave(2))]);
        let toy = Toy::new(&data, vec![tilted, wave(0), wave(1)]);
        let settings = Settings::default();
        let (evidence, before) = (toy.evidence(&settings), toy.before());
        let tangent = Tangent::new(&toy, &before, true).expect("a tangent");
        let pairs = by_score(&evidence, &tangent, &before);
        let found = better(&evidence, &before, &toy.fitted(&[0, 1]), &pairs);
        let both = toy.fitted(&[1, 2]);
        let lead = toy.fitted(&[0, 1]).loss - both.loss;
        match found {
            Some(pair) => assert!(pair.causes == [1, 2] && lead >= 4.0, "{lead}"),
            None => assert!(lead < 4.0, "{lead}"),
        }
        assert!(better(&evidence, &before, &both, &pairs).is_none());
        assert!(better(&evidence, &before, &toy.fitted(&[0]), &pairs).is_none());
    }
}
