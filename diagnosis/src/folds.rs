//! Data left out in turn.

use crate::fit::Mask;
use crate::kind::Kind;
use crate::settings::Settings;

/// Readings that are left out together.
pub(crate) struct Fold {
    /// Runs that are left out whole; none where a block of the only run is.
    pub runs: Vec<usize>,
    /// What is fitted to, and what is predicted, where it is a block.
    pub masks: Option<(Mask, Mask)>,
}

/// Every run left out once, ten at most together with others; or where there is one run, every
/// block of it.
pub(crate) fn folds(kind: &dyn Kind, settings: &Settings) -> Vec<Fold> {
    let logs = kind.logs();
    if logs.len() > 1 {
        let most = logs.len().min(10);
        return (0..most)
            .map(|fold| Fold {
                runs: (0..logs.len()).filter(|run| run % most == fold).collect(),
                masks: None,
            })
            .collect();
    }
    let n = logs.first().map_or(0, |log| log.readings.len()).max(1);
    (0..settings.blocks)
        .map(|fold| {
            let inside: Vec<bool> = (0..n).map(|i| i * settings.blocks / n == fold).collect();
            let outside = inside.iter().map(|x| !x).collect();
            Fold {
                runs: Vec::new(),
                masks: Some((Some(vec![outside]), Some(vec![inside]))),
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
