//! A measured torque or force that drives a model.

use crate::experiment::Run;
use crate::sensor::Sensor;

/// A measured course, linear between its rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Input {
    /// When (s) each value was measured.
    time: Vec<f64>,
    /// In the column's unit.
    pub(super) values: Vec<f64>,
}

impl Input {
    /// That of a column of a run; 0 where there is none.
    pub(super) fn of(run: &Run, column: Option<usize>) -> Input {
        let Some(column) = column else {
            return Input::default();
        };
        let rows = run
            .time
            .iter()
            .copied()
            .zip(run.values[column].iter().copied());
        let (time, values) = rows.filter(|(_, value)| value.is_finite()).unzip();
        Input { time, values }
    }

    /// The truth at `time` (s) that `sensor` has measured; `at` as in [`at`](Input::at).
    pub(super) fn truth(&self, time: f64, sensor: &Sensor, at: &mut usize) -> f64 {
        if self.time.is_empty() {
            return 0.0;
        }
        sensor.truth(self.at(sensor.shown(time), at))
    }

    /// Its value at `time`, on the line between two rows; `at` is the last row before it, from which
    /// the search goes on.
    pub(super) fn at(&self, time: f64, at: &mut usize) -> f64 {
        let Some(last) = self.time.len().checked_sub(1) else {
            return 0.0;
        };
        while *at < last && self.time[*at + 1] <= time {
            *at += 1;
        }
        let (a, b) = (*at, (*at + 1).min(last));
        let width = self.time[b] - self.time[a];
        let share = if width > 0.0 {
            ((time - self.time[a]) / width).clamp(0.0, 1.0)
        } else {
            0.0
        };
        self.values[a] + share * (self.values[b] - self.values[a])
    }
}
