//! What learns meets what is learnt: the meaning of Gymnasium.

use crate::GaitError;
use crate::error::refused;

/// A quantity that is observed or chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Its name.
    pub name: &'static str,
    /// Its unit, as it stands in the names of columns.
    pub unit: &'static str,
    /// Least value.
    pub low: f64,
    /// Greatest value.
    pub high: f64,
}

impl Axis {
    /// The quantity `name` in `unit`, from `low` to `high`.
    pub const fn new(name: &'static str, unit: &'static str, low: f64, high: f64) -> Axis {
        Axis {
            name,
            unit,
            low,
            high,
        }
    }
}

/// What can be done in a step.
#[derive(Clone, Debug, PartialEq)]
pub enum Actions {
    /// One of several.
    Choices(Vec<String>),
    /// A number on each axis.
    Values(Vec<Axis>),
}

impl Actions {
    /// How many choices there are; none where numbers are chosen.
    pub fn choices(&self) -> Option<usize> {
        match self {
            Actions::Choices(names) => Some(names.len()),
            Actions::Values(_) => None,
        }
    }
}

/// What is done in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Act<'a> {
    /// The choice of this number.
    Choice(usize),
    /// These values.
    Values(&'a [f64]),
}

impl Act<'_> {
    /// The number of the choice, one of `count`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for another choice, and for values.
    pub fn choice(&self, count: usize) -> Result<usize, GaitError> {
        let allowed = || format!("a whole number from 0 to {}", count - 1);
        match *self {
            Act::Choice(choice) if choice < count => Ok(choice),
            Act::Choice(choice) => Err(refused("action", choice as f64, allowed())),
            Act::Values(values) => {
                let first = values.first().copied().unwrap_or(f64::NAN);
                Err(refused("action", first, allowed()))
            }
        }
    }
}

/// What came of a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The reward.
    pub reward: f64,
    /// Whether the task is over: no reward can follow.
    pub terminated: bool,
    /// Whether the time is over, in the middle of the task.
    pub truncated: bool,
}

impl Step {
    /// Whether the episode is over.
    pub fn is_over(&self) -> bool {
        self.terminated || self.truncated
    }
}

/// What an episode came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Outcome {
    /// How long it was (s).
    pub time: f64,
    /// Angle through which the wheel has turned forwards (rad).
    pub angle: f64,
    /// Travel (m).
    pub travel: f64,
    /// When the goal was reached (s).
    pub arrived: Option<f64>,
    /// Gas from the supply (kg).
    pub gas: f64,
    /// Firings.
    pub firings: usize,
    /// Whether it ended where the motion of rigid bodies could not be computed further.
    pub broken: bool,
}

/// A robot with a task.
pub trait Environment: Send + Sync {
    /// What is observed.
    fn observed(&self) -> &[Axis];
    /// What can be done.
    fn actions(&self) -> &Actions;
    /// The beginning of an episode, the same for the same seed.
    ///
    /// # Errors
    /// [`GaitError`] for a robot or a start that cannot be.
    fn start(&self, seed: u64) -> Result<Box<dyn Episode>, GaitError>;
}

/// An episode in its course.
pub trait Episode: Send {
    /// What is observed now, in the order of [`Environment::observed`].
    fn observation(&self) -> &[f64];
    /// Does something, and goes on by a step.
    ///
    /// # Errors
    /// [`GaitError::Input`] for what is not in the space of the actions, or after the end;
    /// [`GaitError::Sim`] where the motion cannot go on.
    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError>;
    /// What it has come to.
    fn outcome(&self) -> Outcome;
}
