//! Firing tables, linear laws, feasibility maps and the QP over obstacles.

pub mod course;
mod crossing;
mod jump;
mod law;
mod map;
pub mod parallel;
pub mod parkour;
mod proxy;
mod table;

pub use crossing::{
    Check, Crossing, CrossingAnswer, CrossingError, CrossingPlan, EDGE_MARGIN, MARGIN_SIGMAS,
    PlannedJump,
};
pub use jump::{Jump, PLANNING_TOLERANCE, Planner, SensitiveJump, Sensitivity};
pub use law::{Law, LawPoint, line};
pub use map::{Map, MapRequest, Spot, SpotResult};
pub use table::{
    Cell, Entry, FIRING_ANGLES, Measure, Nearest, Roots, Table, TableError, TableRequest,
};
