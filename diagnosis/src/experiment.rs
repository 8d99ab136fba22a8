//! Measured data in memory.

use std::collections::BTreeMap;

pub use crate::kinds::Sort;

/// Runs of one kind, with what is known of their noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// What was done.
    pub kind: Sort,
    /// Names of the measured columns, without the time and the valve; each ends with its unit.
    pub columns: Vec<String>,
    /// One standard deviation of each column's noise, where known.
    pub noise: Vec<Option<f64>>,
    /// Step of each column that is quantised, where known.
    pub resolution: Vec<Option<f64>>,
    /// The runs.
    pub runs: Vec<Run>,
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Run {
    /// Its file.
    pub name: String,
    /// What the operator set, by its key.
    pub settings: BTreeMap<String, f64>,
    /// When (s) the valve's command turned to 1, and when it turned back to 0 if it did.
    pub valve: Option<(f64, Option<f64>)>,
    /// Time (s) of each row, strictly increasing; for [`Sort::Outcomes`] the number of the row.
    pub time: Vec<f64>,
    /// For each of [`Experiment::columns`] a value for each row; NaN where a cell is empty.
    pub values: Vec<Vec<f64>>,
}
