//! Firing tables, linear laws, feasibility maps and the QP over obstacles.

mod corrected;
pub mod course;
mod crossing;
mod flight;
mod jump;
mod law;
mod map;
mod model;
mod planar;
mod planner;
mod proxy;
mod table;

pub use corrected::{Corrected, Correction, Effort, LaunchRange};
pub use crossing::{
    Check, Crossing, CrossingAnswer, CrossingError, CrossingPlan, EDGE_MARGIN, MARGIN_SIGMAS,
    PlannedJump,
};
pub use flight::JumpFlight;
pub use jump::{Jump, Sensitivity};
pub use law::{Law, LawPoint};
pub use map::{Map, MapRequest, Spot, SpotResult};
pub use model::{Instant, JumpModel, Steered, Traced, spare_of, widen};
pub use planar::{PLANNING_TOLERANCE, Planar, flight_after};
pub use planner::Planner;
pub use table::{
    Cell, Entry, FIRING_ANGLES, Measure, Nearest, Roots, Table, TableError, TableRequest,
};
