//! What a user may choose about a diagnosis.

/// What a user may choose about a diagnosis; its own numbers are in [`Policy`](crate::Policy).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// False-alarm rate: in what part of data without an effect an effect may be reported.
    pub false_alarms: f64,
    /// Most causes at work at the same time.
    pub most: usize,
    /// Blocks into which a single run is cut, to be left out one at a time.
    pub blocks: usize,
    /// Sets of noise that are drawn to find a threshold.
    pub draws: usize,
    /// Seed of all random draws.
    pub seed: u64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            false_alarms: 0.05,
            most: 3,
            blocks: 5,
            draws: 300,
            seed: 1,
        }
    }
}
