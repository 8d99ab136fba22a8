//! What is verified, once it was read.

use saltus::Robot;
use saltus::on_plant::OnPlant;
use saltus::planner::{Corrected, Planner};
use saltus::verify::{Plant, Subject};

use crate::error::CliError;

/// What is verified.
pub(super) struct Loaded {
    /// What it is called.
    pub(super) title: String,
    pub(super) subject: Subject,
    /// What says where its jumps land.
    pub(super) planner: Planner<Corrected>,
    /// Whether it was made for the robot that jumps.
    pub(super) for_plant: bool,
}

/// Answers for `robot` that hold on `plant`.
pub(super) fn on_plant(robot: &Robot, plant: &Plant) -> Result<OnPlant, CliError> {
    let plant = plant.robot();
    OnPlant::new(robot, plant).map_err(|error| CliError::content(&plant.name, error))
}
