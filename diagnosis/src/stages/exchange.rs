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
