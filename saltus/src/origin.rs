//! Where data come from: what files of motions and measurements say of it.

use saltus_robot::Robot;

/// Where the data of a file come from.
#[derive(Clone, Copy, Debug)]
pub struct Origin<'a> {
    /// What was asked for.
    pub command: &'a str,
    /// Seed of all that was drawn, if anything was.
    pub seed: Option<u64>,
    /// The robot that is recorded, if one is: its file is attached.
    pub robot: Option<&'a Robot>,
}
