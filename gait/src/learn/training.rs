//! Episodes of learning, and episodes that score what was learnt.

use rand_pcg::Pcg64;

use crate::GaitError;
use crate::error::ensure;

use super::bins::Bins;
use super::process::{Act, Environment, Outcome};
use super::tabular::{Algorithm, Rates, Seen, Tabular};

/// How exploration fades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Share of random actions in the first episode.
    pub epsilon: f64,
    /// Factor from one episode to the next.
    pub decay: f64,
    /// Episodes.
    pub episodes: usize,
}

impl Schedule {
    /// Share of random actions in an episode.
    fn share(&self, episode: usize) -> f64 {
        let exponent = i32::try_from(episode).unwrap_or(i32::MAX);
        self.epsilon * self.decay.powi(exponent)
    }
}

/// What is trained, and how.
#[derive(Clone)]
pub struct Training<'e> {
    /// The robot with its task.
    pub environment: &'e dyn Environment,
    /// Its states.
    pub bins: Bins,
    /// What learns.
    pub algorithm: Algorithm,
    /// Its numbers.
    pub rates: Rates,
    /// How it explores, and how long.
    pub schedule: Schedule,
}

/// What an episode came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// Sum of the rewards.
    pub total: f64,
    /// Steps.
    pub steps: usize,
    /// Steps with a number outside the range of the states.
    pub outside: usize,
    /// The robot's motion.
    pub outcome: Outcome,
}

impl Training<'_> {
    /// How many choices there are.
    fn check(&self) -> Result<usize, GaitError> {
        let Schedule {
            epsilon,
            decay,
            episodes,
        } = self.schedule;
        let unit = |x: f64| (0.0..=1.0).contains(&x);
        let observed = self.environment.observed().len();
        let axes = self.bins.axes().len();
        ensure! {
            "epsilon", epsilon, unit(epsilon) => "from 0 to 1";
            "decay of epsilon", decay, unit(decay) => "from 0 to 1";
            "episodes", episodes as f64, episodes > 0 => "1 or more";
            "axes of the states", axes as f64, axes == observed
                => format!("{observed}, as is observed");
        }
        let choices = self.environment.actions().choices();
        choices.ok_or_else(|| crate::error::refused("actions", f64::NAN, "choices, for a table"))
    }

    /// The seed with which the environment starts an episode of a learner's seed.
    pub fn start_of((seed, episode): (u64, usize)) -> u64 {
        seed.wrapping_mul(0x9e37_79b9_7f4a_7c15)
            .wrapping_add(episode as u64)
    }

    /// The table before learning.
    ///
    /// # Errors
    /// [`GaitError::Input`] for numbers that cannot be.
    pub fn table(&self) -> Result<Tabular, GaitError> {
        let actions = self.check()?;
        Tabular::new(self.algorithm, self.rates, (self.bins.states(), actions))
    }
}

/// Learns on `table`, from episode `from` on, with `seed`; each episode's score is given to `scored`, which says
/// whether it goes on.
///
/// The same seed gives the same table to the bit, in one go or in several: what is random in an episode
/// depends on the seed and the episode's number alone.
///
/// # Errors
/// [`GaitError`] for numbers that cannot be, and for a motion that cannot go on.
pub fn train(
    training: &Training<'_>,
    table: &mut Tabular,
    (seed, from): (u64, usize),
    mut scored: impl FnMut(usize, &Score, &Tabular) -> bool,
) -> Result<(), GaitError> {
    training.check()?;
    for episode in from..training.schedule.episodes {
        let epsilon = training.schedule.share(episode);
        let score = one(training, table, (seed, episode), Some(epsilon))?;
        if !scored(episode, &score, table) {
            break;
        }
    }
    Ok(())
}

/// An episode without exploration or learning: in each state the best action, of equal ones the first.
///
/// # Errors
/// As [`train`].
pub fn greedy(
    training: &Training<'_>,
    table: &Tabular,
    seed: (u64, usize),
) -> Result<Score, GaitError> {
    one(training, &mut table.clone(), seed, None)
}

/// An episode, with learning where there is an ε.
fn one(
    training: &Training<'_>,
    table: &mut Tabular,
    (seed, episode): (u64, usize),
    epsilon: Option<f64>,
) -> Result<Score, GaitError> {
    let mut random = Pcg64::new(u128::from(seed), 2 * episode as u128);
    let start = Training::start_of((seed, episode));
    let mut running = training.environment.start(start)?;
    let mut choose = |table: &Tabular, state: usize| match epsilon {
        Some(share) => table.choose(state, share, &mut random),
        None => table.best(state),
    };
    let mut score = Score::default();
    table.begin();
    let (mut state, outside) = training.bins.state_of(running.observation());
    score.outside += usize::from(outside);
    let mut action = choose(table, state);
    loop {
        let step = running.step(Act::Choice(action))?;
        score.total += step.reward;
        score.steps += 1;
        let (next, outside) = training.bins.state_of(running.observation());
        score.outside += usize::from(outside);
        let after = choose(table, next);
        if epsilon.is_some() {
            table.learn(&Seen {
                state,
                action,
                reward: step.reward,
                next: (!step.terminated).then_some((next, after)),
            });
        }
        (state, action) = (next, after);
        if step.is_over() {
            score.outcome = running.outcome();
            return Ok(score);
        }
    }
}
