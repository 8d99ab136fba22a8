//! Two causes at a time: a gain and an offset may nearly cancel, and then neither explains much
//! alone.

use crate::evidence::Evidence;
use crate::fit::Fit;
use crate::fitness;
use crate::parallel;
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
    if base.causes.len() + 2 > evidence.settings.most {
        return None;
    }
    let misfit = fitness::excess(evidence.kind, base);
    let least = POLICY.pair_gain.max(POLICY.pair_part * misfit);
    let pairs = by_score(evidence, tangent, base);
    let before = evidence.held_out_loss(base)?;
    // What small steps promise, bounds may forbid.
    let promising = pairs.into_iter().take_while(|pair| pair.gain > least);
    promising.take(POLICY.pairs_fitted).find_map(|pair| {
        let both = evidence.with_pair(base, pair.causes)?;
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
    let parameters = 2.0 * (evidence.degrees_of(&pair) - evidence.degrees_of(found));
    let gain = (found.loss - pair.loss) / inflation - parameters;
    (gain >= POLICY.rival_loss).then_some(pair)
}
