//! Backward elimination: causes that the others have made needless are taken out.

use crate::evidence::Evidence;
use crate::fit::Fit;

/// `model` without the causes that explain no more than chance, or do less than the error of the
/// model, beside the others.
pub(crate) fn prune(evidence: &Evidence, mut model: Fit, inflation: f64) -> Fit {
    let mut k = 0;
    while model.causes.len() > 1 && k < model.causes.len() {
        let cause = model.causes[k];
        let without = evidence.without(&model, cause);
        match without.filter(|base| is_needless(evidence, base, &model, cause, inflation)) {
            Some(base) => (model, k) = (base, 0),
            None => k += 1,
        }
    }
    model
}

/// Whether `base` does as well as `model`, which has `cause` too.
fn is_needless(evidence: &Evidence, base: &Fit, model: &Fit, cause: usize, inflation: f64) -> bool {
    (base.loss - model.loss) / inflation < evidence.gain_by_chance(cause)
        || evidence.effect(base, model) < evidence.least_effect(cause, 1)
}
