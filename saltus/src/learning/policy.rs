//! What a table that was learnt does.

use saltus_gait::learn::{Bin, Score, Tabular, Task as Course, greedy};
use saltus_gait::{Decides, GaitError, Learnt};

use super::{Settings, Task};

impl Settings {
    /// The table of these `values`, by state and then action.
    ///
    /// # Errors
    /// [`GaitError`] for another number of values than the settings have.
    pub fn table(&self, values: &[f64]) -> Result<Tabular, GaitError> {
        let environment = self.chosen()?;
        let table = self.training(environment.as_ref()).table()?;
        table.with_values(values.to_vec())
    }

    /// What a robot runs by: in each state the action of the greatest value, of equal ones the first.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run.
    pub fn policy(&self, table: &Tabular) -> Result<Learnt, GaitError> {
        // A task has at most 255 choices.
        let choice = |state: usize| u8::try_from(table.best(state)).unwrap_or(u8::MAX);
        let decides = match self.task {
            Task::RunLegs | Task::Climb => Decides::Legs,
            Task::RunZone => Decides::Zone {
                period: Course::default().period,
            },
            Task::RunStride | Task::JumpStride => Decides::Stride {
                firings: self
                    .grid()?
                    .choices()
                    .iter()
                    .map(|it| [it[0], it[1]])
                    .collect(),
                front: self.plant.obstacles.first().map(|it| it.front),
            },
        };
        Ok(Learnt {
            axes: self.bins.axes().iter().map(Bin::steps).collect(),
            choices: (0..self.bins.states()).map(choice).collect(),
            decides,
        })
    }

    /// An episode by `table` without exploration; what is drawn in it is drawn by `seed`.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run, and for a motion that cannot go on.
    pub fn trial(&self, table: &Tabular, seed: (u64, usize)) -> Result<Score, GaitError> {
        let environment = self.chosen()?;
        greedy(&self.training(environment.as_ref()), table, seed)
    }
}
