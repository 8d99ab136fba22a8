//! Score test: what each cause promises by the model linearised at a fit, and what the best of all
//! promises by chance.

use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_numeric::statistics::percentile;

use crate::evidence::Evidence;
use crate::fit::Fit;
use crate::fitness;
use crate::policy::POLICY;
use crate::tangent::{Direction, Tangent};

/// The gain beyond chance that the best of all causes reaches in data without an effect, in the
/// part of cases that the false-alarm rate allows.
///
/// Chance is noise and the model's own error.
pub(crate) fn threshold(evidence: &Evidence, tangent: &Tangent, random: &mut Pcg64) -> f64 {
    let settings = evidence.settings;
    let draws: Vec<Vec<f64>> = (0..settings.draws)
        .map(|_| tangent.drawn(evidence.kind, random))
        .collect();
    let mut best = parallel::map(draws.len(), |k| best_score(evidence, tangent, &draws[k]));
    best.sort_by(f64::total_cmp);
    let level = settings.false_alarms * (1.0 - POLICY.unknown_share);
    percentile(&best, 1.0 - level)
}

/// Greatest score beyond chance that the linearised model gives to `residuals`.
fn best_score(evidence: &Evidence, tangent: &Tangent, residuals: &[f64]) -> f64 {
    let of = |d: &Direction| evidence.gain_beyond_chance(d.cause, d.score(residuals));
    let scores = tangent.candidates.iter().map(of);
    scores.fold(f64::NEG_INFINITY, f64::max)
}

/// Whether the score of some cause comes near to the threshold.
pub(crate) fn may_pass(evidence: &Evidence, tangent: &Tangent, base: &Fit, threshold: f64) -> bool {
    Tangent::residuals(evidence.kind, base).is_none_or(|residuals| {
        best_score(evidence, tangent, &residuals) > POLICY.score_of_threshold * threshold
    })
}

/// Whether `base` is so far from the readings that slopes there do not tell what a cause can do:
/// every one is then fitted.
pub(crate) fn is_far_off(evidence: &Evidence, base: &Fit) -> bool {
    let scatter = fitness::scatter(evidence.kind, base);
    scatter.iter().any(|sigmas| *sigmas > POLICY.far_off)
}

/// Causes whose score is more than chance gives often and not far behind the best: only of these a
/// fit is made.
pub(crate) fn promising(
    evidence: &Evidence,
    base: &Fit,
    tangent: &Tangent,
    residuals: &[f64],
) -> Vec<usize> {
    let scores = scores(tangent, residuals);
    // Of a machine with many parts most causes are far behind beside others.
    let of_few = if evidence.lacks_several() && !base.causes.is_empty() {
        POLICY.score_of_few_of_many
    } else {
        POLICY.score_of_few
    };
    let best = scores.first().map_or(0.0, |s| s.1);
    // The score of a cause that cannot be reached in small steps is rough.
    let is_apart = |cause: usize| evidence.kind.causes()[cause].is_apart();
    let is_promising = |rank: usize, (cause, score): (usize, f64)| {
        let is_among_few = rank < POLICY.most_fitted && score > of_few * best;
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

#[cfg(test)]
mod tests {
    use statrs::distribution::{ChiSquared, ContinuousCDF};

    use super::*;
    use crate::settings::Settings;
    use crate::statistics::chi_square;
    use crate::toy::{ALL, Toy, noise, sum, wave};

    /// The score of a direction is the square of the residuals' part of it.
    #[test]
    fn a_score_is_the_square_of_a_projection() {
        let toy = Toy::new(
            &sum(&[(7.0, &wave(1)), (3.0, &wave(2))]),
            vec![wave(0), wave(1), sum(&[(4.0, &wave(1)), (3.0, &wave(2))])],
        );
        let before = toy.before();
        let tangent = Tangent::new(&toy, &before, true).expect("a tangent");
        let residuals = Tangent::residuals(&toy, &before).expect("residuals");
        let found = scores(&tangent, &residuals);
        // Part of (7, 3) along (4, 3)/5, and along (1, 0).
        let known = [(2, 7.4 * 7.4), (1, 49.0), (0, 0.0)];
        for ((cause, score), (known_cause, known)) in found.into_iter().zip(known) {
            assert!(
                cause == known_cause && (score - known).abs() < 1e-6,
                "{cause} {score}"
            );
        }
    }

    /// Of ten independent directions the best gain by chance is the greatest of ten χ² with one
    /// degree of freedom.
    #[test]
    fn the_threshold_is_the_quantile_of_the_greatest_of_ten() {
        let toy = Toy::new(&[0.0; ALL], (0..10).map(wave).collect());
        let settings = Settings {
            draws: 20_000,
            ..Settings::default()
        };
        let evidence = toy.evidence(&settings);
        let tangent = Tangent::new(&toy, &toy.before(), true).expect("a tangent");
        let found = threshold(&evidence, &tangent, &mut Pcg64::new(1, 1));
        let level = settings.false_alarms * (1.0 - POLICY.unknown_share);
        let one = (1.0 - level).powf(0.1);
        let known = ChiSquared::new(1.0).expect("χ²").inverse_cdf(one) - chi_square(1, 0.999);
        // 20,000 draws tell this quantile to 0.1.
        assert!((found - known).abs() < 0.3, "{found} {known}");
    }

    /// What is near to the best is fitted; what chance gives, or a thousandth of the best, is not.
    #[test]
    fn only_what_promises_something_is_fitted() {
        let parts = [
            (30.0, wave(0)),
            (20.0, wave(1)),
            (5.0, wave(2)),
            (1.5, wave(3)),
        ];
        let parts: Vec<(f64, &[f64])> = parts.iter().map(|(c, v)| (*c, v.as_slice())).collect();
        let toy = Toy::new(&sum(&parts), (0..5).map(wave).collect());
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let tangent = Tangent::new(&toy, &toy.before(), true).expect("a tangent");
        let residuals = Tangent::residuals(&toy, &toy.before()).expect("residuals");
        // 25 is less than 3 % of 900.
        assert_eq!(
            promising(&evidence, &toy.before(), &tangent, &residuals),
            [0, 1]
        );
        assert!(may_pass(&evidence, &tangent, &toy.before(), 100.0));
        assert!(!may_pass(&evidence, &tangent, &toy.before(), 2000.0));
        let noise = Toy::new(&noise(1), vec![wave(0)]);
        let tangent = Tangent::new(&noise, &noise.before(), true).expect("a tangent");
        let small = sum(&[(1.9, &wave(0))]);
        let before = noise.before();
        assert!(promising(&noise.evidence(&settings), &before, &tangent, &small).is_empty());
    }
}
