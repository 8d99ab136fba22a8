//! A table of choices that is changed at random, and kept where the episode is no worse.
//!
//! It needs no value of a step, and so finds what comes late and seldom. Source: Mitchell, Holland and Forrest,
//! "When will a genetic algorithm outperform hill climbing?", 1993 (random-mutation hill climbing).

use rand_pcg::Pcg64;
use saltus_gait::GaitError;
use saltus_gait::learn::{Act, Bins, Environment, Outcome, Training};

use crate::{below, require, unit};

/// Climbs for so many `episodes` with `seed`, and gives each episode's sum of rewards and outcome to `scored`: the choice
/// in each state. The first episode has a choice drawn for every state; each later one draws that of this `share` of the
/// states anew.
///
/// # Errors
/// [`GaitError`] for an environment whose actions are no choices, and for a motion that cannot go on.
pub fn hill_climb(
    environment: &dyn Environment,
    bins: &Bins,
    (share, episodes): (f64, usize),
    seed: u64,
    mut scored: impl FnMut(f64, &Outcome),
) -> Result<Vec<usize>, GaitError> {
    let actions = environment.actions().choices().unwrap_or(0);
    require(actions > 0, "choices", actions as f64, "1 or more")?;
    let mut choices = vec![0; bins.states()];
    let mut best = f64::NEG_INFINITY;
    for episode in 0..episodes {
        let mut random = Pcg64::new(u128::from(seed), 2 * episode as u128);
        let share = if episode == 0 { 1.0 } else { share };
        let mut tried = choices.clone();
        for choice in &mut tried {
            if unit(&mut random) < share {
                *choice = below(actions, &mut random);
            }
        }
        let (total, outcome) = by_choices(environment, bins, &tried, (seed, episode))?;
        if total >= best {
            (best, choices) = (total, tried);
        }
        scored(total, &outcome);
    }
    Ok(choices)
}

/// The sum of the rewards of an episode by `choices`, and what it came to.
///
/// # Errors
/// [`GaitError`] for a motion that cannot go on.
pub fn by_choices(
    environment: &dyn Environment,
    bins: &Bins,
    choices: &[usize],
    seed: (u64, usize),
) -> Result<(f64, Outcome), GaitError> {
    let mut running = environment.start(Training::start_of(seed))?;
    let mut total = 0.0;
    loop {
        let (state, _) = bins.state_of(running.observation());
        let step = running.step(Act::Choice(choices[state]))?;
        total += step.reward;
        if step.is_over() {
            return Ok((total, running.outcome()));
        }
    }
}

#[cfg(test)]
mod tests {
    use saltus_gait::learn::{Actions, Axis, Bin, Episode, Step};

    use super::*;

    /// Twelve locks in a row, each opened by one of four actions; any other ends the episode.
    struct Locks(Vec<Axis>, Actions);

    struct AtLock([f64; 1], usize);

    impl Environment for Locks {
        fn observed(&self) -> &[Axis] {
            &self.0
        }

        fn actions(&self) -> &Actions {
            &self.1
        }

        fn start(&self, _: u64) -> Result<Box<dyn Episode>, GaitError> {
            Ok(Box::new(AtLock([0.0], 0)))
        }
    }

    impl Episode for AtLock {
        fn observation(&self) -> &[f64] {
            &self.0
        }

        fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
            let opens = act.choice(4)? == (3 * self.1 + 1) % 4;
            self.1 += usize::from(opens);
            self.0 = [self.1 as f64];
            Ok(Step {
                reward: f64::from(u8::from(opens)),
                terminated: !opens || self.1 == 12,
                truncated: false,
            })
        }

        fn outcome(&self) -> Outcome {
            Outcome::default()
        }
    }

    #[test]
    fn all_locks_are_opened() -> Result<(), GaitError> {
        let names = ["a", "b", "c", "d"].map(String::from).to_vec();
        let axis = Axis::new("lock", "", 0.0, 13.0);
        let locks = Locks(vec![axis], Actions::Choices(names));
        let bins = Bins::new(vec![Bin {
            from: -0.5,
            to: 12.5,
            count: 13,
        }])?;
        for seed in 0..5 {
            let mut totals = Vec::new();
            let choices = hill_climb(&locks, &bins, (0.1, 1500), seed, |total, _| {
                totals.push(total);
            })?;
            assert_eq!(by_choices(&locks, &bins, &choices, (seed, 0))?.0, 12.0);
            // The first choices are drawn: a lock opens once in four.
            assert!(totals[0] < 6.0, "{totals:?}");
        }
        Ok(())
    }
}
