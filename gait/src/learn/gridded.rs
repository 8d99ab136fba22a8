//! A few values in place of all: what a table can choose from.

use crate::GaitError;
use crate::error::refused;

use super::process::{Act, Actions, Axis, Environment, Episode, Outcome, Step};

/// An environment whose actions are values, of which some are choices.
pub struct Gridded {
    inner: Box<dyn Environment>,
    actions: Actions,
    choices: Vec<Vec<f64>>,
}

impl Gridded {
    /// So many values on each axis of the actions of `inner`, from the least to the greatest, and every one with
    /// every other.
    ///
    /// # Errors
    /// [`GaitError::Input`] for choices in place of values, and for another number of counts than of axes.
    pub fn new(inner: Box<dyn Environment>, counts: &[usize]) -> Result<Gridded, GaitError> {
        let axes = match inner.actions() {
            Actions::Values(axes) if axes.len() == counts.len() => axes.clone(),
            _ => {
                let given = counts.len() as f64;
                return Err(refused("axes of the actions", given, "as the task has"));
            }
        };
        let mut choices = vec![Vec::new()];
        for (axis, count) in axes.iter().zip(counts) {
            let step = (axis.high - axis.low) / (count.saturating_sub(1)).max(1) as f64;
            let longer = |before: &Vec<f64>| {
                let before = before.clone();
                (0..*count).map(move |k| [&before[..], &[axis.low + step * k as f64]].concat())
            };
            choices = choices.iter().flat_map(longer).collect();
        }
        let name = |values: &Vec<f64>| {
            let parts = axes.iter().zip(values);
            let parts = parts.map(|(axis, x)| format!("{} {x:.3} {}", axis.name, axis.unit));
            parts.collect::<Vec<_>>().join(", ")
        };
        Ok(Gridded {
            actions: Actions::Choices(choices.iter().map(name).collect()),
            inner,
            choices,
        })
    }

    /// The values of each choice.
    pub fn choices(&self) -> &[Vec<f64>] {
        &self.choices
    }
}

impl Environment for Gridded {
    fn observed(&self) -> &[Axis] {
        self.inner.observed()
    }

    fn actions(&self) -> &Actions {
        &self.actions
    }

    fn start(&self, seed: u64) -> Result<Box<dyn Episode>, GaitError> {
        Ok(Box::new(OnGrid {
            inner: self.inner.start(seed)?,
            choices: self.choices.clone(),
        }))
    }
}

struct OnGrid {
    inner: Box<dyn Episode>,
    choices: Vec<Vec<f64>>,
}

impl Episode for OnGrid {
    fn observation(&self) -> &[f64] {
        self.inner.observation()
    }

    fn step(&mut self, act: Act<'_>) -> Result<Step, GaitError> {
        let choice = act.choice(self.choices.len())?;
        self.inner.step(Act::Values(&self.choices[choice]))
    }

    fn outcome(&self) -> Outcome {
        self.inner.outcome()
    }
}
