//! Running robots: a controller in the loop of the multi-body simulation.
//!
//! What decides is [`saltus_controller::run`], the code that is flashed; here it meets the robot.
//! [`Setup`] says which robot runs how; [`run`] runs it, and gives every cycle to a closure.

mod box_table;
mod cast;
mod crossing;
mod drawn;
mod error;
mod law;
pub mod learn;
mod learnt;
mod logged;
mod run;
mod search;
mod sensed;
mod senses;
mod sensors;
pub mod space;
mod speed;
mod surroundings;
mod world;

pub use box_table::{BoxTable, Choice};
pub use cast::instruments;
pub use crossing::{Crossed, Crossing, CrossingPlan};
pub use drawn::{Draw, Ensemble, drawn_robot};
pub use error::GaitError;
pub use law::{Centre, Lines, Program, Smooth};
pub use learnt::{Decides, Learnt};
pub use logged::{Logged, Logger};
pub use run::{Ending, Footfall, Obstacle, Row, Run, Setup, Summary, run};
pub use search::{Search, search};
pub use sensed::{Faced, Sensed};
pub use sensors::{Ranging, Sensing};
pub use speed::speed_law;
pub use surroundings::{Disturbance, Surroundings, What, When};
pub use world::{Command, Cycle, Output, World};
