//! Score test: what each cause promises by the model linearised at a fit, and what the best of all
//! promises by chance.

use rand_pcg::Pcg64;

use crate::evidence::Evidence;
use crate::fit::Fit;
use crate::parallel;
use crate::policy::POLICY;
use crate::statistics::percentile;
use crate::tangent::{Direction, Tangent};

/// The gain beyond chance that the best of all causes reaches in data without an effect, in the
/// part of cases that the false-alarm rate allows.
pub(crate) fn threshold(evidence: &Evidence, tangent: &Tangent, random: &mut Pcg64) -> f64 {
    let settings = evidence.settings;
    let draws: Vec<Vec<f64>> = (0..settings.draws)
        .map(|_| tangent.chance(evidence.kind, random))
        .collect();
    let mut best = parallel::map(draws.len(), |k| best_score(evidence, tangent, &draws[k]));
    best.sort_by(f64::total_cmp);
    let level = settings.false_alarms * (1.0 - POLICY.unknown_share);
    percentile(&best, 1.0 - level)
}

/// Greatest gain beyond chance that the linearised model promises of `residuals`.
fn best_score(evidence: &Evidence, tangent: &Tangent, residuals: &[f64]) -> f64 {
    let of = |d: &Direction| evidence.gain_beyond_chance(d.cause, d.gain(residuals));
    let scores = tangent.candidates.iter().map(of);
    scores.fold(f64::NEG_INFINITY, f64::max)
}

/// Whether the score of some cause comes near to the threshold.
pub(crate) fn may_pass(evidence: &Evidence, tangent: &Tangent, base: &Fit, threshold: f64) -> bool {
    Tangent::residuals(evidence.kind, base).is_none_or(|residuals| {
        best_score(evidence, tangent, &residuals) > POLICY.score_of_threshold * threshold
    })
}

/// Causes whose score is more than chance gives often and not far behind the best: only of these a
/// fit is made.
pub(crate) fn promising(evidence: &Evidence, tangent: &Tangent, residuals: &[f64]) -> Vec<usize> {
    let scores = scores(tangent, residuals);
    let best = scores.first().map_or(0.0, |s| s.1);
    // The score of a cause that cannot be reached in small steps is rough.
    let is_apart = |cause: usize| evidence.kind.causes()[cause].is_apart();
    let is_promising = |rank: usize, (cause, score): (usize, f64)| {
        let is_among_few = rank < POLICY.most_fitted && score > POLICY.score_of_few * best;
        let is_near = score > POLICY.score_of_any * best;
        let may_be_better = is_apart(cause) && score > POLICY.score_of_apart * best;
        score > POLICY.least_score && (is_among_few || is_near || may_be_better)
    };
    let mut all: Vec<usize> = scores
        .iter()
        .enumerate()
        .filter(|(rank, score)| is_promising(*rank, **score))
        .map(|(_, score)| score.0)
        .collect();
    all.sort_unstable();
    all
}

/// Each cause with the greatest score of its directions, the best first.
fn scores(tangent: &Tangent, residuals: &[f64]) -> Vec<(usize, f64)> {
    let mut scores: Vec<(usize, f64)> = Vec::new();
    for direction in &tangent.candidates {
        let score = direction.gain(residuals);
        match scores
            .iter_mut()
            .find(|(cause, _)| *cause == direction.cause)
        {
            Some(known) => known.1 = known.1.max(score),
            None => scores.push((direction.cause, score)),
        }
    }
    scores.sort_by(|a, b| b.1.total_cmp(&a.1));
    scores
}
