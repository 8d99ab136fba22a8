//! Data left out in turn.

use crate::fit::Mask;
use crate::kind::{Kind, Log};
use crate::settings::Settings;

/// Readings that are left out together.
#[derive(Clone)]
pub(crate) struct Fold {
    /// Runs that are left out whole, or of which a block is.
    pub runs: Vec<usize>,
    /// What is fitted to, and what is predicted, where it is a block.
    pub masks: Option<(Mask, Mask)>,
}

/// Every run left out once with those of its group, ten groups at most together with others; or where there is one run, or each is
/// of a machine of its own, every block of each.
pub(crate) fn folds(kind: &dyn Kind, settings: &Settings) -> Vec<Fold> {
    let logs = kind.logs();
    let mut groups: Vec<usize> = (0..logs.len()).map(|run| kind.group(run)).collect();
    groups.dedup();
    if groups.len() > 1 && !kind.is_apart() {
        let most = groups.len().min(10);
        let fold_of = |run: usize| groups.iter().position(|own| *own == kind.group(run));
        let in_fold = |run: &usize, fold| fold_of(*run).is_some_and(|place| place % most == fold);
        return (0..most)
            .map(|fold| Fold {
                runs: (0..logs.len()).filter(|run| in_fold(run, fold)).collect(),
                masks: None,
            })
            .collect();
    }
    (0..settings.blocks)
        .map(|fold| {
            let inside_of = |log: &Log| -> Vec<bool> {
                let n = log.readings.len().max(1);
                (0..n).map(|i| i * settings.blocks / n == fold).collect()
            };
            let inside: Vec<Vec<bool>> = logs.iter().map(inside_of).collect();
            let outside = inside.iter().map(|of| of.iter().map(|x| !x).collect());
            Fold {
                runs: (0..logs.len()).collect(),
                masks: Some((Some(outside.collect()), Some(inside))),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::toy::{self, ALL, Toy};

    #[test]
    fn every_run_is_left_out_once() {
        let toy = Toy::new(&toy::noise(1), vec![toy::wave(0)]);
        let folds = folds(&toy, &Settings::default());
        let mut left_out: Vec<usize> = folds.iter().flat_map(|fold| fold.runs.clone()).collect();
        left_out.sort_unstable();
        assert_eq!(left_out, (0..toy::RUNS).collect::<Vec<_>>());
    }

    #[test]
    fn of_one_run_every_reading_is_predicted_once_by_a_fit_without_it() {
        let toy = Toy::new(&toy::noise(1), vec![toy::wave(0)]).in_one_run();
        let settings = Settings::default();
        let folds = folds(&toy, &settings);
        assert_eq!(folds.len(), settings.blocks);
        let mut seen = vec![0; ALL];
        for fold in folds {
            let (fitted, predicted) = fold.masks.expect("blocks");
            let [fitted, predicted] =
                [fitted, predicted].map(|mask| mask.expect("a mask").remove(0));
            for i in 0..ALL {
                assert_ne!(fitted[i], predicted[i]);
                seen[i] += usize::from(predicted[i]);
            }
        }
        assert!(seen.iter().all(|&times| times == 1));
    }
}
