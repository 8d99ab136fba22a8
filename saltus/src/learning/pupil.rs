//! Seeds that learn, each alone.

use saltus_gait::GaitError;
use saltus_gait::learn::{Score, Tabular, greedy, train};
use saltus_numeric::parallel;

use super::{PolicyFile, Settings, Task};

/// What one seed learnt.
#[derive(Clone, Debug)]
pub struct Pupil {
    /// Its seed.
    pub seed: u64,
    /// The score of every episode.
    pub curve: Vec<Score>,
    /// What it came to without exploration: of several trials the one in the middle.
    pub score: Score,
    /// Its table.
    pub table: Tabular,
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

/// Learns with `seeds` seeds from `first` on, on so many `threads`: the same for any number of them. `goes_on` is asked
/// after each episode, and ends all where it says so; then the tables are those of the episodes done.
///
/// `before` has the tables and the number of episodes from which it goes on.
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
        let environment = settings.chosen()?;
        let training = settings.training(environment.as_ref());
        let mut table = training.table()?;
        let mut curve = Vec::new();
        if let Some(held) = before.and_then(|file| file.tables.get(k)) {
            table = table.with_values(held.values.clone())?;
            curve.clone_from(&held.curve);
        }
        train(&training, &mut table, (seed, curve.len()), |_, score, _| {
            curve.push(*score);
            goes_on()
        })?;
        let trial = |k| greedy(&training, &table, (seed, TRIAL + k));
        Ok(Pupil {
            seed,
            score: settings.middle(trial)?,
            curve,
            table,
        })
    };
    let pupils: Result<Vec<_>, GaitError> =
        parallel::map_on(threads, seeds, one).into_iter().collect();
    Ok(Learnt { pupils: pupils? })
}

impl Settings {
    /// Of several trials the one in the middle: a single one may be lucky.
    fn middle(
        &self,
        trial: impl Fn(usize) -> Result<Score, GaitError>,
    ) -> Result<Score, GaitError> {
        let sure = matches!(self.task, Task::RunLegs | Task::Climb) && self.plant.draw.is_none();
        let count = if sure { 1 } else { TRIALS };
        let mut scores = (0..count).map(trial).collect::<Result<Vec<_>, _>>()?;
        let figure = |score: &Score| self.figure(&score.outcome);
        scores.sort_by(|a, b| figure(a).total_cmp(&figure(b)));
        Ok(scores[count / 2])
    }
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
