//! Exchange: what was the best cause alone need not be the best in company.

use saltus_numeric::parallel;

use crate::evidence::Evidence;
use crate::finding::Candidate;
use crate::fit::Fit;
use crate::fitness;
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
    let mut candidates = candidates_beside(evidence, &base).into_iter();
    // Fitted anew it may have stopped short of where it is.
    let own = Candidate::new(evidence.kind, cause, &base, model.clone());
    let best = candidates.next()?;
    let inflation = evidence.inflation_between(&own.fit, &best.fit, inflation);
    let gain = |c| evidence.penalised_gain(c, inflation);
    let is_better = best.cause != cause && gain(&best) > gain(&own) + POLICY.rival_loss;
    is_better.then(|| evidence.settled(best).fit)
}

/// `model` with one of its causes replaced by two, where residuals are correlated and there is room
/// for one more; none where that does not explain clearly more and predict left-out data better.
///
/// Two small effects may look like one that is neither of them, and each alone beside it explains
/// little.
pub(crate) fn one_for_two(evidence: &Evidence, model: &Fit, inflation: f64) -> Option<Fit> {
    let count = model.causes.len();
    // Of more causes, none stands for the two alone.
    if !evidence.is_correlated(inflation) || count != 2 || evidence.most() < 3 {
        return None;
    }
    let best = model
        .causes
        .iter()
        .filter_map(|cause| best_pair(evidence, &evidence.without(model, *cause)?))
        .min_by(|a, b| a.loss.total_cmp(&b.loss))?;
    let gain = model.loss - best.loss;
    let needed = 2.0 * evidence.gain_by_chance(*best.causes.last()?);
    let inflation = evidence.inflation_between(model, &best, inflation);
    let is_better = gain / inflation > needed
        && gain > POLICY.share_correlated * fitness::excess(evidence.kind, model)
        && evidence.held_out_loss(&best)? < evidence.held_out_loss(model)?;
    is_better.then_some(best)
}

/// `base` with the two of its best candidates that explain most together.
fn best_pair(evidence: &Evidence, base: &Fit) -> Option<Fit> {
    let mut near = candidates_beside(evidence, base);
    let most = near.iter().map(|c| c.gain).fold(0.0, f64::max);
    near.retain(|c| c.gain > POLICY.gain_of_far * most);
    near.truncate(POLICY.most_compared);
    let pairs: Vec<(usize, usize)> = (0..near.len())
        .flat_map(|a| (a + 1..near.len()).map(move |b| (a, b)))
        .collect();
    let fitted = parallel::map(pairs.len(), |k| {
        let (a, b) = pairs[k];
        evidence.with(&near[a].fit, near[b].cause)
    });
    let fitted = fitted.into_iter().flatten();
    fitted.min_by(|a, b| a.loss.total_cmp(&b.loss))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;
    use crate::toy::{Toy, noise, sum, wave};

    /// Alone, the tilted column explains most; beside the first wave, the second does.
    fn toy() -> Toy {
        let data = sum(&[(20.0, &wave(0)), (20.0, &wave(1)), (1.0, &noise(1))]);
        let tilted = sum(&[(0.6, &wave(0)), (0.6, &wave(1)), (0.529, &wave(2))]);
        Toy::new(&data, vec![tilted, wave(0), wave(1)])
    }

    #[test]
    fn the_best_alone_gives_way_to_the_best_in_company() {
        let toy = toy();
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let found = exchange(&evidence, toy.fitted(&[0, 1]), 1.0);
        let mut causes = found.causes.clone();
        causes.sort_unstable();
        assert_eq!(causes, [1, 2]);
        assert!((found.loss - toy.fitted(&[1, 2]).loss).abs() < 0.1);
    }

    /// The tilted column stands for the first two waves, and leaves a wave of 13 readings; one of the
    /// two in its place explains less than it does.
    #[test]
    fn two_take_the_place_of_one() {
        let waves = [wave(0), wave(1), wave(3)];
        let data = sum(&[
            (40.0, &waves[0]),
            (40.0, &waves[1]),
            (30.0, &waves[2]),
            (1.0, &noise(2)),
        ]);
        let tilted = sum(&[(0.65, &waves[0]), (0.65, &waves[1]), (0.39, &wave(60))]);
        let [first, second, fourth] = waves;
        let toy = Toy::new(&data, vec![tilted, first, second, fourth]);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let found = toy.fitted(&[0, 3]);
        let inflation = evidence.inflation(&found);
        let better = one_for_two(&evidence, &found, inflation).expect("two for one");
        let mut causes = better.causes.clone();
        causes.sort_unstable();
        assert_eq!(causes, [1, 2, 3]);
        // Readings that do not wander have no need of it, and three causes no room.
        assert!(one_for_two(&evidence, &found, 1.0).is_none());
        assert!(one_for_two(&evidence, &better, inflation).is_none());
    }

    #[test]
    fn the_best_stays_and_one_alone_too() {
        let toy = toy();
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        for causes in [&[1, 2][..], &[0]] {
            assert_eq!(exchange(&evidence, toy.fitted(causes), 1.0).causes, causes);
        }
    }
}
