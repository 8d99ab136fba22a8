//! What a user may choose about a diagnosis.

use crate::known::Known;

/// What a user may choose about a diagnosis; its own numbers are in [`Policy`](crate::Policy).
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Most causes at work at the same time.
    pub most: Option<usize>,
    /// Blocks into which a single run is cut, to be left out one at a time.
    pub blocks: usize,
    /// Draws of noise by which is told what an experiment can tell.
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
            most: None,
            blocks: 5,
            draws: 300,
            discrepancy: None,
            known: Vec::new(),
            seed: 1,
        }
    }
}
