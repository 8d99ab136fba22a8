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
