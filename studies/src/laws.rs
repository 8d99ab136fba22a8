//! The smooth law as six numbers that are sought, in the task of a learner.

use saltus::learning::Settings;
use saltus_gait::learn::{Act, Actions, Environment, Score, Training};
use saltus_gait::{GaitError, Smooth};
use saltus_numeric::parallel::map_on;

use crate::few::{Bayes, Learner as _};

/// Least and greatest value of each parameter of the smooth law, in order.
pub const BOUNDS: [[f64; 2]; 6] = [
    [0.1, 0.6],
    [-0.3, 0.4],
    [2.0, 20.0],
    [0.02, 0.1],
    [0.02, 0.1],
    [2.0, 20.0],
];

/// The law of the six parameters `x` in order; those that are not there are 0.
pub fn smooth(x: &[f64]) -> Smooth {
    let at = |k: usize| x.get(k).copied().unwrap_or(0.0);
    Smooth {
        firing_angle: [at(0), at(1), at(2)],
        valve_open: [at(3), at(4), at(5)],
    }
}

/// The law whose parameters are at these parts, from 0 to 1, of their [`BOUNDS`].
pub fn within_bounds(parts: &[f64]) -> Smooth {
    let scaled = parts.iter().zip(BOUNDS);
    let scaled: Vec<f64> = scaled
        .map(|(x, [low, high])| low + x * (high - low))
        .collect();
    smooth(&scaled)
}

/// A law that one seed sought.
#[derive(Clone, Copy, Debug)]
pub struct Sought {
    /// The law.
    pub law: Smooth,
    /// What it came to: of several trials the one in the middle.
    pub score: Score,
}

/// Episode of the first trial: one that no search has. And trials; an odd number, as the one in the middle counts.
const TRIAL: usize = 1 << 40;
const TRIALS: usize = 5;

/// Seeks a law by Bayesian optimisation with `seeds` seeds from 1 on, a try for each episode of `settings`, from the middle
/// of the [`BOUNDS`]; the same on any number of `threads`.
///
/// # Errors
/// [`GaitError`] for a robot that cannot run, and for a motion that cannot go on.
pub fn seek(settings: &Settings, seeds: usize, threads: usize) -> Result<Vec<Sought>, GaitError> {
    let one = |k: usize| {
        let seed = k as u64 + 1;
        let environment = settings.environment()?;
        let run = |law: &Smooth, episode| by_law(environment.as_ref(), law, (seed, episode));
        let mut learner = Bayes::new(vec![0.5; BOUNDS.len()], seed);
        for episode in 0..settings.schedule.episodes {
            let x = learner.ask();
            learner.tell(&x, run(&within_bounds(&x), episode)?.total);
        }
        let law = within_bounds(&learner.best());
        let mut scores = (0..TRIALS)
            .map(|k| run(&law, TRIAL + k))
            .collect::<Result<Vec<_>, _>>()?;
        let figure = |score: &Score| settings.figure(&score.outcome);
        scores.sort_by(|a, b| figure(a).total_cmp(&figure(b)));
        let score = scores[TRIALS / 2];
        Ok(Sought { law, score })
    };
    map_on(threads, seeds, one).into_iter().collect()
}

/// An episode in which each stride is fired by `law`.
///
/// # Errors
/// [`GaitError::Input`] for a task whose actions are no numbers; others where the motion cannot go on.
pub fn by_law(
    environment: &dyn Environment,
    law: &Smooth,
    seed: (u64, usize),
) -> Result<Score, GaitError> {
    let Actions::Values(axes) = environment.actions() else {
        return Err(GaitError::Input {
            name: "a law".into(),
            value: f64::NAN,
            allowed: "run in a task whose actions are numbers".into(),
        });
    };
    let mut running = environment.start(Training::start_of(seed))?;
    let mut score = Score::default();
    loop {
        let rate = running.observation().first().copied().unwrap_or(0.0);
        let mut firing = law.at(rate);
        for (x, axis) in firing.iter_mut().zip(axes) {
            *x = x.clamp(axis.low, axis.high);
        }
        let step = running.step(Act::Values(&firing))?;
        score.total += step.reward;
        score.steps += 1;
        if step.is_over() {
            score.outcome = running.outcome();
            return Ok(score);
        }
    }
}
