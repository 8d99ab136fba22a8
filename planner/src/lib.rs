//! Firing tables, linear laws, feasibility maps and the QP over obstacles.

mod jump;

pub use jump::{Jump, PLANNING_TOLERANCE, Planner, SensitiveJump, Sensitivity};
