//! A measured torque or force that drives a model.

use saltus_numeric::hermite;

use crate::experiment::Run;
use crate::sensor::Sensor;

/// A measured course, linear between its rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Input {
    /// When (s) each value was measured.
    pub(super) time: Vec<f64>,
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

    /// The truth at `time` (s) that `sensor` has measured, on the line between two rows. The
    /// search begins at row `at`, which becomes the row before that time.
    pub(super) fn truth(&self, time: f64, sensor: &Sensor, at: &mut usize) -> f64 {
        let Some((a, b, share)) = self.rows(sensor.shown(time), at) else {
            return 0.0;
        };
        sensor.truth(self.values[a] + share * (self.values[b] - self.values[a]))
    }

    /// The same on a cubic through four rows (Catmull and Rom).
    pub(super) fn smooth(&self, time: f64, sensor: &Sensor, at: &mut usize) -> f64 {
        let Some((a, b, share)) = self.rows(sensor.shown(time), at) else {
            return 0.0;
        };
        let width = self.time[b] - self.time[a];
        let slope = |i: usize| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(self.time.len() - 1));
            let passed = (self.time[after] - self.time[before]).max(f64::MIN_POSITIVE);
            width * (self.values[after] - self.values[before]) / passed
        };
        let [a, b] = [a, b].map(|i| (self.values[i], slope(i)));
        sensor.truth(hermite(a, b, 1.0, share).0)
    }

    /// The rows about `time`, and how far it is from the first to the second.
    fn rows(&self, time: f64, at: &mut usize) -> Option<(usize, usize, f64)> {
        let last = self.time.len().checked_sub(1)?;
        while *at < last && self.time[*at + 1] <= time {
            *at += 1;
        }
        let (a, b) = (*at, (*at + 1).min(last));
        let width = (self.time[b] - self.time[a]).max(f64::MIN_POSITIVE);
        Some((a, b, ((time - self.time[a]) / width).clamp(0.0, 1.0)))
    }
}
