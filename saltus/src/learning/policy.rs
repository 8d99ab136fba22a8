//! What was learnt, and what it does.

use saltus_gait::learn::{Act, Actions, Environment, Score, Tabular, Training, greedy};
use saltus_gait::learn::{Bin, Task as Course};
use saltus_gait::{Decides, GaitError, Learnt, Program, Smooth};

use super::{Method, Settings, Task};

/// What a robot does.
#[derive(Clone, Debug)]
pub enum Policy {
    /// In each state the action of the greatest value.
    Table(Tabular),
    /// Firing angles by a law.
    Law(Smooth),
}

impl Policy {
    /// Its numbers: the values by state and then action, or the six parameters of the law.
    pub fn values(&self) -> Vec<f64> {
        match self {
            Policy::Table(table) => table.values().to_vec(),
            Policy::Law(law) => [law.firing_angle, law.valve_open].concat(),
        }
    }

    /// The policy of these `values`, learnt under `settings`.
    ///
    /// # Errors
    /// [`GaitError`] for another number of values than the settings have.
    pub fn of(settings: &Settings, values: &[f64]) -> Result<Policy, GaitError> {
        Ok(match settings.method {
            Method::Values(_) | Method::HillClimbing => {
                let environment = settings.chosen()?;
                let training = settings.training(environment.as_ref());
                Policy::Table(training.table()?.with_values(values.to_vec())?)
            }
            Method::Bayes | Method::Evolution => Policy::Law(Smooth::from(values)),
        })
    }

    /// What a robot runs by, in the task of `settings`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a table of several tilings, which is no table of choices.
    pub fn program(&self, settings: &Settings) -> Result<Program, GaitError> {
        match self {
            Policy::Law(law) => Ok(law.program()),
            Policy::Table(table) => Ok(Program::Learnt(Policy::learnt(table, settings)?)),
        }
    }

    /// The choices of a table.
    fn learnt(table: &Tabular, settings: &Settings) -> Result<Learnt, GaitError> {
        let bins = &settings.bins;
        let tilings = bins.tilings();
        if tilings > 1 {
            return Err(GaitError::Input {
                name: "tilings".into(),
                value: tilings as f64,
                allowed: "1, for a table of choices".into(),
            });
        }
        // A task has at most 255 choices.
        let choice = |state: usize| u8::try_from(table.best(&[state])).unwrap_or(u8::MAX);
        let decides = match settings.task {
            Task::RunLegs | Task::Climb => Decides::Legs,
            Task::RunZone => Decides::Zone {
                period: Course::default().period,
            },
            Task::RunStride | Task::JumpStride => Decides::Stride {
                firings: settings
                    .grid()?
                    .choices()
                    .iter()
                    .map(|it| [it[0], it[1]])
                    .collect(),
                front: settings.plant.obstacles.first().map(|it| it.front),
            },
        };
        Ok(Learnt {
            axes: bins.axes().iter().map(Bin::steps).collect(),
            choices: (0..bins.states()).map(choice).collect(),
            decides,
        })
    }

    /// An episode of the task of `settings` without exploration; what is drawn in it is drawn by `seed`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run, and for a motion that cannot go on.
    pub fn trial(&self, settings: &Settings, seed: (u64, usize)) -> Result<Score, GaitError> {
        match self {
            Policy::Table(table) => {
                let environment = settings.chosen()?;
                greedy(&settings.training(environment.as_ref()), table, seed)
            }
            Policy::Law(law) => {
                let environment = settings.environment()?;
                by_law(environment.as_ref(), law, Training::start_of(seed))
            }
        }
    }
}

/// The error of a policy in a task that has no part for it.
fn no_part(name: &str, allowed: &str) -> GaitError {
    GaitError::Input {
        name: name.into(),
        value: f64::NAN,
        allowed: allowed.into(),
    }
}

/// An episode in which each stride is fired by `law`.
pub(super) fn by_law(
    environment: &dyn Environment,
    law: &Smooth,
    seed: u64,
) -> Result<Score, GaitError> {
    let mut running = environment.start(seed)?;
    let mut score = Score::default();
    let Actions::Values(axes) = environment.actions() else {
        return Err(no_part("a law", "run in a task whose actions are numbers"));
    };
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
