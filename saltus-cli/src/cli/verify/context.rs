//! What a verification's report is about.

use saltus::planner::{Corrected, Planner};
use saltus::verify::{Plant, Subject, Verification};

/// What was verified, and how.
pub(super) struct Context<'a> {
    pub(super) planner: &'a Planner<Corrected>,
    pub(super) plant: &'a Plant,
    /// What the subject is called.
    pub(super) title: &'a str,
    /// Its name in titles of drawings, without the folder of its file.
    pub(super) short_title: String,
    pub(super) subject: &'a Subject,
    /// Whether it was made for the robot that jumps.
    pub(super) for_plant: bool,
    pub(super) how: &'a Verification,
}

impl Context<'_> {
    /// How far (m) a landing may be from where it is wanted.
    pub(super) fn tolerance(&self) -> f64 {
        self.how.tolerance(self.plant.robot().body.radius)
    }
}
