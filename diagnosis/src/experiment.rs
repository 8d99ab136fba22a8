//! Measured data in memory.

use std::collections::BTreeMap;

use crate::mechanism::Mechanism;

/// A kind of experiment: what was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sort {
    /// One cylinder upright, fired once from rest under a dead load.
    Bench,
    /// The robot at rest, upright on one leg, fired once.
    Hop,
    /// From just after touch-down of the jumping leg, through the flight.
    Jump,
    /// A body in free flight or fall, or a robot in flight at the end of a boom.
    Flight,
    /// One row a jump: what was asked for and where it went.
    Outcomes,
    /// A piston moved slowly back and forth under regulated pressure.
    Stroke,
    /// A mass on a guide, driven by a measured force.
    Slide,
    /// A vessel filling or discharging through an orifice.
    Vessel,
    /// A part, or the robot with its legs retracted, swinging about a fixed axis.
    Pendulum,
    /// The robot runs: many strides, every leg.
    Run,
    /// Legs driven by pneumatic muscles from a tank of the robot's own.
    TankLeg,
    /// A walker with two straight legs.
    Walk,
    /// A machine that a file describes.
    Machine,
}

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
    /// The machine that was measured, where a file describes it.
    pub mechanism: Option<Mechanism>,
    /// The runs.
    pub runs: Vec<Run>,
}

impl Experiment {
    /// Index of the column `name`, if it is there.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column == name)
    }
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
