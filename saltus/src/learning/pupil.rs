//! Seeds that learn, each alone.

use saltus_gait::learn::{Bayes, Evolution, Learner, Score, Training, greedy, hill_climb, train};
use saltus_gait::{GaitError, Smooth};
use saltus_numeric::parallel;

use super::policy::by_law;
use super::{Method, Policy, PolicyFile, Settings, Task};

/// What one seed learnt.
#[derive(Clone, Debug)]
pub struct Pupil {
    /// Its seed.
    pub seed: u64,
    /// The score of every episode.
    pub curve: Vec<Score>,
    /// What it came to without exploration: of several trials the one in the middle.
    pub score: Score,
    /// What it does.
    pub policy: Policy,
}

/// What all seeds learnt.
#[derive(Clone, Debug)]
pub struct Learnt {
    /// Each seed, in order.
    pub pupils: Vec<Pupil>,
}

/// Episode of the first trial without exploration: one that no training has.
const TRIAL: usize = 1 << 40;
/// Trials where something is drawn in an episode: noise, or a robot. An odd number, as the one in the middle counts.
const TRIALS: usize = 5;
/// Where a law is begun, as a part of each parameter's range, and how far CMA-ES looks at first.
const MIDDLE: [f64; 6] = [0.5; 6];
const SPREAD: f64 = 0.2;

/// Learns with `seeds` seeds from `first` on, on so many `threads`: the same for any number of them. `goes_on` is asked
/// after each episode, and ends all where it says so; then the policies are those of the episodes done.
///
/// `before` has the policies and the number of episodes from which it goes on.
///
/// # Errors
/// [`GaitError`] for numbers that cannot be, and for a motion that cannot go on.
pub fn learn(
    settings: &Settings,
    (first, seeds): (u64, usize),
    before: Option<&PolicyFile>,
    threads: usize,
    goes_on: &(impl Fn() -> bool + Sync),
) -> Result<Learnt, GaitError> {
    let one = |k: usize| {
        let seed = first.wrapping_add(k as u64);
        let held = before.and_then(|file| file.tables.get(k));
        let past = held.map(|held| (&held.values[..], &held.curve[..]));
        match settings.method {
            Method::Values(_) | Method::HillClimbing => by_table(settings, seed, past, goes_on),
            Method::Bayes => {
                let mut learner = Bayes::new(MIDDLE.to_vec(), seed);
                by_tries(settings, seed, past, &mut learner, goes_on)
            }
            Method::Evolution => {
                let mut learner = Evolution::new(MIDDLE.to_vec(), SPREAD, seed);
                by_tries(settings, seed, past, &mut learner, goes_on)
            }
        }
    };
    let pupils: Result<Vec<_>, GaitError> =
        parallel::map_on(threads, seeds, one).into_iter().collect();
    Ok(Learnt { pupils: pupils? })
}

/// Values and curve of the episodes before.
type Past<'p> = Option<(&'p [f64], &'p [Score])>;

fn by_table(
    settings: &Settings,
    seed: u64,
    past: Past<'_>,
    goes_on: &impl Fn() -> bool,
) -> Result<Pupil, GaitError> {
    let environment = settings.chosen()?;
    let training = settings.training(environment.as_ref());
    let mut table = training.table()?;
    let mut curve = Vec::new();
    if let Some((values, before)) = past {
        table = table.with_values(values.to_vec())?;
        curve = before.to_vec();
    }
    let from = (seed, curve.len());
    let best = curve.iter().map(|score| score.total);
    let best = best.fold(f64::NEG_INFINITY, f64::max);
    let mut scored = |score: &Score| {
        curve.push(*score);
        goes_on()
    };
    if settings.method.has_values() {
        train(&training, &mut table, from, |_, score, _| scored(score))?;
    } else {
        hill_climb(&training, &mut table, from, best, |_, score| scored(score))?;
    }
    let trial = |k| greedy(&training, &table, (seed, TRIAL + k));
    Ok(Pupil {
        seed,
        score: middle(settings, trial)?,
        curve,
        policy: Policy::Table(table),
    })
}

fn by_tries(
    settings: &Settings,
    seed: u64,
    past: Past<'_>,
    learner: &mut dyn Learner,
    goes_on: &impl Fn() -> bool,
) -> Result<Pupil, GaitError> {
    let environment = settings.environment()?;
    let run = |x: &[f64], episode: usize| {
        let law = Smooth::within_bounds(x);
        by_law(
            environment.as_ref(),
            &law,
            Training::start_of((seed, episode)),
        )
    };
    let mut curve = past.map_or_else(Vec::new, |(_, curve)| curve.to_vec());
    // What it asked before, it asks again.
    for score in &curve {
        let x = learner.ask();
        learner.tell(&x, score.total);
    }
    for episode in curve.len()..settings.schedule.episodes {
        let x = learner.ask();
        let score = run(&x, episode)?;
        learner.tell(&x, score.total);
        curve.push(score);
        if !goes_on() {
            break;
        }
    }
    let best = learner.best();
    Ok(Pupil {
        seed,
        score: middle(settings, |k| run(&best, TRIAL + k))?,
        curve,
        policy: Policy::Law(Smooth::within_bounds(&best)),
    })
}

/// Of several trials the one in the middle: a single one may be lucky.
fn middle(
    settings: &Settings,
    trial: impl Fn(usize) -> Result<Score, GaitError>,
) -> Result<Score, GaitError> {
    let sure =
        matches!(settings.task, Task::RunLegs | Task::Climb) && settings.plant.draw.is_none();
    let count = if sure { 1 } else { TRIALS };
    let mut scores = (0..count).map(trial).collect::<Result<Vec<_>, _>>()?;
    let figure = |score: &Score| settings.figure(&score.outcome);
    scores.sort_by(|a, b| figure(a).total_cmp(&figure(b)));
    Ok(scores[count / 2])
}

impl Learnt {
    /// The one that did best without exploration, the first of several.
    pub fn best(&self, settings: &Settings) -> Option<&Pupil> {
        let figure = |pupil: &Pupil| settings.figure(&pupil.score.outcome);
        self.pupils.iter().reduce(|best, pupil| {
            if figure(pupil) > figure(best) {
                pupil
            } else {
                best
            }
        })
    }

    /// Those that reached the goal without exploration.
    pub fn arrived(&self) -> usize {
        let scores = self.pupils.iter().map(|pupil| pupil.score.outcome);
        scores.filter(|outcome| outcome.arrived.is_some()).count()
    }
}
