//! The controller by its public interface.

#![allow(clippy::cast_possible_truncation)]

mod ahead;
mod ball;
mod flight;
mod fuzz;
mod qp;
#[rustfmt::skip]
#[path = "../../examples/rats_planar/tables.rs"]
mod rats_planar;
mod running;
mod tables;
