//! What a user may choose about a diagnosis.

use crate::known::Known;

/// What a user may choose about a diagnosis; its own numbers are in [`Policy`](crate::Policy).
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// False-alarm rate: in what part of data without an effect an effect may be reported.
    pub false_alarms: f64,
    /// Most causes at work at the same time.
    pub most: Option<usize>,
    /// Blocks into which a single run is cut, to be left out one at a time.
    pub blocks: usize,
    /// Sets of noise that are drawn to find a threshold.
    pub draws: usize,
    /// Standard deviation of the model's own error, in standard deviations of a reading; none: as the
    /// kind of experiment has it.
    pub discrepancy: Option<f64>,
    /// What is known apart from the data; of a parameter that the kind does not have, it does
    /// nothing.
    pub known: Vec<Known>,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            false_alarms: 0.05,
            most: None,
            blocks: 5,
            draws: 300,
            discrepancy: None,
            known: Vec::new(),
            seed: 1,
        }
    }
}
