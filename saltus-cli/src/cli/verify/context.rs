//! What a verification's report is about.

use saltus::planner::{Corrected, Planner};
use saltus::verify::{Plant, Subject, Verification};

/// What was verified, and how.
pub(super) struct Context<'a> {
    pub(super) planner: &'a Planner<Corrected>,
    pub(super) plant: &'a Plant,
    /// What the subject is called.
    pub(super) title: &'a str,
    pub(super) subject: &'a Subject,
    /// Whether it was made for the robot that jumps.
    pub(super) for_plant: bool,
    pub(super) how: &'a Verification,
}
