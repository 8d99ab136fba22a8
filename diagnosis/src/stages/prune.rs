//! Backward elimination: causes that the others have made needless are taken out.

use crate::evidence::Evidence;
use crate::fit::Fit;
use crate::stages::add::predicts_far_better;

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
    let between = evidence.inflation_between(base, model, inflation);
    let is_chance = (base.loss - model.loss) / between < evidence.gain_by_chance(cause);
    let is_told = || {
        evidence.is_correlated(inflation)
            && evidence.has_runs()
            && predicts_far_better(evidence, base, model)
    };
    (is_chance && !is_told()) || evidence.effect(base, model) < evidence.least_effect(cause, 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kind::Cause;
    use crate::settings::Settings;
    use crate::toy::{Toy, noise, sum, wave};

    #[test]
    fn a_cause_whose_work_others_do_is_taken_out() {
        let data = sum(&[(20.0, &wave(0)), (20.0, &wave(1)), (1.0, &noise(1))]);
        let tilted = sum(&[(0.7, &wave(0)), (0.7, &wave(1)), (0.14, &wave(2))]);
        let toy = Toy::new(&data, vec![tilted, wave(0), wave(1)]);
        let settings = Settings::default();
        let evidence = toy.evidence(&settings);
        let found = prune(&evidence, toy.fitted(&[0, 1, 2]), 1.0);
        assert_eq!(found.causes, [1, 2]);
        // Each of them explains far more than chance.
        assert_eq!(prune(&evidence, found.clone(), 1.0).causes, [1, 2]);
        // Where a unit of loss is worth a thousandth, runs that are left out decide, but not about
        // sensors, of which one is enough.
        assert_eq!(prune(&evidence, found.clone(), 1000.0).causes, [1, 2]);
        let of_sensor = |cause: &mut Cause| cause.column = Some("y".into());
        let toy = toy.with(1, of_sensor).with(2, of_sensor);
        assert_eq!(
            prune(&toy.evidence(&settings), found, 1000.0).causes.len(),
            1
        );
    }

    /// A gain of 10.83 is what chance exceeds once in a thousand times.
    #[test]
    fn the_limit_is_a_thousandth() {
        for (size, left) in [(3.2, 1), (3.4, 2)] {
            let toy = Toy::new(
                &sum(&[(30.0, &wave(0)), (size, &wave(1))]),
                vec![wave(0), wave(1)],
            );
            let settings = Settings::default();
            let found = prune(&toy.evidence(&settings), toy.fitted(&[0, 1]), 1.0);
            assert_eq!(found.causes.len(), left, "{size}");
        }
    }
}
