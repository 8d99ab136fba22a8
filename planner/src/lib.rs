//! Firing tables, linear laws, feasibility maps and the QP over obstacles.

pub mod course;
pub mod parkour;
