//! Robots that learn to run: the experiments of chapter 6 of the thesis, over many seeds.
//!
//! [`Task::settings`] has what the thesis says of each. [`learn`] trains one table for each seed; [`Learnt`]
//! has their curves and scores, and [`PolicyFile`] the table as a file.

mod file;
mod summary;

pub use file::{PolicyError, PolicyFile};
pub use summary::{Interval, interquartile};

use saltus_gait::learn::{
    Algorithm, Bins, Environment, Legs, Outcome, Plant, Rates, Reward, Schedule, Score, Tabular,
    Task as Course, Term, Traces, Training, Zone, greedy, train,
};
use saltus_gait::{GaitError, Obstacle};
use saltus_numeric::parallel;
use saltus_robot::Robot;

/// What is to be learnt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Which valve to open, each millisecond: thesis 6.3.1.
    RunLegs,
    /// The same before a box: thesis 6.3.1.
    Climb,
    /// Whether the leg in the active zone fires, by what the robot measures: thesis 6.3.2.
    RunZone,
}

/// The box of the thesis (m).
const BOX: Obstacle = Obstacle {
    front: 0.5,
    length: 0.21,
    height: 0.21,
};

impl Task {
    /// Every task.
    pub const ALL: [Task; 3] = [Task::RunLegs, Task::Climb, Task::RunZone];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Task::RunLegs => "run-legs",
            Task::Climb => "climb",
            Task::RunZone => "run-zone",
        }
    }

    /// The algorithm of the thesis.
    pub fn algorithm(self) -> Algorithm {
        match self {
            Task::RunLegs | Task::Climb => Algorithm::Q,
            Task::RunZone => Algorithm::SarsaLambda,
        }
    }

    /// The settings of the thesis, for `robot`: tables 6.1 to 6.4 as printed.
    pub fn settings(self, robot: Robot, algorithm: Algorithm) -> Settings {
        let traces = algorithm.has_traces();
        let mut plant = Plant::new(robot);
        let decay = if traces { 0.95 } else { 0.99 };
        let (reward, episodes, steps) = match self {
            Task::RunLegs => (
                vec![(Term::Threshold(2.0), 1.0)],
                if traces { 100 } else { 1000 },
                1000,
            ),
            Task::Climb => (vec![(Term::Travel, 1.0), (Term::Arrival, 1e4)], 500, 2000),
            Task::RunZone => (vec![(Term::Rate, 1.0)], 40, 360),
        };
        match self {
            Task::RunLegs => {}
            Task::Climb => plant.obstacles = vec![BOX],
            // Thesis 6.3.2: pulses of 1 ms did not move the valves.
            Task::RunZone => plant.robot.leg.least_pulse = plant.robot.leg.least_pulse.max(0.005),
        }
        Settings {
            task: self,
            plant,
            algorithm,
            rates: Rates {
                alpha: if traces { 0.8 } else { 1.0 },
                gamma: 0.3,
                lambda: 0.9,
                traces: Traces::Accumulating,
            },
            schedule: Schedule {
                epsilon: if self == Task::RunZone { 0.95 } else { 1.0 },
                decay,
                episodes,
            },
            bins: match self {
                Task::RunLegs | Task::Climb => Bins::of_table_6_1(),
                Task::RunZone => Bins::of_table_6_3(),
            },
            reward: Reward(reward),
            steps,
        }
    }
}

/// What learns what, and how.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The task.
    pub task: Task,
    /// The robot and what is around it.
    pub plant: Plant,
    /// What learns.
    pub algorithm: Algorithm,
    /// Its numbers.
    pub rates: Rates,
    /// How it explores, and how long.
    pub schedule: Schedule,
    /// The states.
    pub bins: Bins,
    /// What is rewarded.
    pub reward: Reward,
    /// Steps of an episode at most.
    pub steps: usize,
}

impl Settings {
    /// Its robot with its task.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run.
    pub fn environment(&self) -> Result<Box<dyn Environment>, GaitError> {
        let (plant, reward) = (self.plant.clone(), self.reward.clone());
        Ok(match self.task {
            Task::RunLegs | Task::Climb => Box::new(Legs::new(plant, reward, self.steps)?),
            Task::RunZone => {
                let usual = Course::default();
                let seconds = self.steps as f64 * usual.period;
                Box::new(Zone::new(plant, reward, Course { seconds, ..usual })?)
            }
        })
    }

    fn training<'e>(&self, environment: &'e dyn Environment) -> Training<'e> {
        Training {
            environment,
            bins: self.bins.clone(),
            algorithm: self.algorithm,
            rates: self.rates,
            schedule: self.schedule,
        }
    }

    /// How far an episode came: the angle (rad) for `run-legs`, the travel (m) for the others.
    pub fn way(&self, outcome: &Outcome) -> f64 {
        match self.task {
            Task::RunLegs => outcome.angle,
            Task::Climb | Task::RunZone => outcome.travel,
        }
    }

    /// Episodes until the mean [`way`](Settings::way) of ten has 90 % of that of the last tenth of `curve`; none for a
    /// robot that did not learn to run.
    pub fn episodes_to_90_percent(&self, curve: &[Score]) -> Option<usize> {
        let ways: Vec<f64> = curve.iter().map(|it| self.way(&it.outcome)).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
        let last = mean(&ways[ways.len() - ways.len().div_ceil(10)..]);
        if last < MOVES {
            return None;
        }
        let width = SMOOTH.min(ways.len().max(1));
        let mut means = ways.windows(width).map(mean);
        means
            .position(|level| level >= LEARNT * last)
            .map(|first| first + width)
    }

    /// What an episode is judged by, the more the better: the angle (rad) for `run-legs`, the time left (s) for
    /// the others, with the travel (m) where the goal was not reached.
    pub fn figure(&self, outcome: &Outcome) -> f64 {
        match self.task {
            Task::RunLegs => outcome.angle,
            Task::Climb | Task::RunZone => match outcome.arrived {
                Some(time) => 100.0 - time,
                None => outcome.travel,
            },
        }
    }
}

/// Episodes over which a score is a mean.
const SMOOTH: usize = 10;
/// Share of the final score that counts as learnt.
const LEARNT: f64 = 0.9;
/// Angle (rad) or travel (m) above which a robot has moved at all.
const MOVES: f64 = 0.1;

/// What one seed learnt.
#[derive(Clone, Debug)]
pub struct Pupil {
    /// Its seed.
    pub seed: u64,
    /// The score of every episode.
    pub curve: Vec<Score>,
    /// What it came to without exploration.
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

/// Episode of the trials without exploration: one that no training has.
const TRIAL: usize = 1 << 40;

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
    let environment = settings.environment()?;
    let training = settings.training(environment.as_ref());
    let one = |k: usize| {
        let seed = first.wrapping_add(k as u64);
        let mut table = training.table()?;
        let mut curve = Vec::new();
        if let Some(held) = before.and_then(|file| file.tables.get(k)) {
            table = table.with_values(held.values.clone())?;
            curve.clone_from(&held.curve);
        }
        let from = curve.len();
        train(&training, &mut table, (seed, from), |_, score, _| {
            curve.push(*score);
            goes_on()
        })?;
        let score = greedy(&training, &table, (seed, TRIAL))?;
        Ok(Pupil {
            seed,
            curve,
            score,
            table,
        })
    };
    let pupils: Result<Vec<_>, GaitError> =
        parallel::map_on(threads, seeds, one).into_iter().collect();
    Ok(Learnt { pupils: pupils? })
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
