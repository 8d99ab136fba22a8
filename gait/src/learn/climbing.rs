//! A table of choices that is changed at random, and kept where the episode is no worse.
//!
//! It needs no value of a step, and so finds what comes late and seldom. Source: Mitchell, Holland and Forrest,
//! "When will a genetic algorithm outperform hill climbing?", 1993 (random-mutation hill climbing).

use rand_pcg::Pcg64;

use crate::GaitError;
use crate::error::require;

use super::tabular::{Tabular, below, unit};
use super::training::{Score, Training, greedy};

/// Climbs on `table`, from episode `from` on, with `seed`, and gives each episode's score to `scored`, which says whether
/// it goes on. The first episode has a choice drawn for every state; each later one draws that of a share ε of the
/// states anew. `best` is the greatest sum of rewards before episode `from`.
///
/// The same seed gives the same table to the bit, in one go or in several.
///
/// # Errors
/// As [`train`](super::train), and [`GaitError::Input`] for several tilings.
pub fn hill_climb(
    training: &Training<'_>,
    table: &mut Tabular,
    (seed, from): (u64, usize),
    mut best: f64,
    mut scored: impl FnMut(usize, &Score) -> bool,
) -> Result<(), GaitError> {
    let tilings = training.bins.tilings();
    let allowed = "1, for choices without values";
    require(tilings == 1, "tilings", tilings as f64, allowed)?;
    let actions = training.check()?;
    let states = training.bins.states();
    for episode in from..training.schedule.episodes {
        let mut random = Pcg64::new(u128::from(seed), 2 * episode as u128);
        let share = if episode == 0 {
            1.0
        } else {
            training.schedule.share(episode)
        };
        let mut tried = table.clone();
        for state in 0..states {
            if unit(&mut random) < share {
                tried.prefer(state, below(actions, &mut random));
            }
        }
        let score = greedy(training, &tried, (seed, episode))?;
        if score.total >= best {
            best = score.total;
            *table = tried;
        }
        if !scored(episode, &score) {
            break;
        }
    }
    Ok(())
}
