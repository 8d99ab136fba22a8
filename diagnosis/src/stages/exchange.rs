//! Exchange: what was the best cause alone need not be the best in company.

use crate::evidence::Evidence;
use crate::fit::Fit;
use crate::policy::POLICY;
use crate::stages::candidates::candidates_beside;

/// `model` with each of its causes, where there are two or more, replaced by one that explains the
/// data better beside the others.
pub(crate) fn exchange(evidence: &Evidence, mut model: Fit, inflation: f64) -> Fit {
    if model.causes.len() < 2 {
        return model;
    }
    for cause in model.causes.clone() {
        if let Some(better) = better(evidence, &model, cause, inflation) {
            model = better;
        }
    }
    model
}

fn better(evidence: &Evidence, model: &Fit, cause: usize, inflation: f64) -> Option<Fit> {
    let base = evidence.without(model, cause)?;
    let candidates = candidates_beside(evidence, &base);
    let gain = |c| evidence.penalised_gain(c, inflation);
    let own = gain(candidates.iter().find(|c| c.cause == cause)?);
    let best = candidates.first()?;
    let is_better = best.cause != cause && gain(best) > own + POLICY.rival_loss;
    is_better.then(|| best.fit.clone())
}
