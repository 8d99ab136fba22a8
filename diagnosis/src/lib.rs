//! What measured data say is wrong with a simulation: which named cause, how surely, and what
//! knowing it is worth.
//!
//! An [`Experiment`] of some [`Kind`] has its data and the model of them, with every [`Cause`] that
//! could be at work as a term that is off. [`diagnose`] weighs sets of them by how probable the data
//! are with each.

mod between;
mod diagnose;
mod discrepancy;
mod estimate;
mod experiment;
mod finding;
mod fit;
mod folds;
mod gain;
mod identifiability;
mod kind;
pub mod kinds;
mod known;
pub mod layout;
mod likelihood;
mod machine;
pub mod mechanism;
mod named;
mod next;
mod noise;
pub mod plausible;
mod policy;
mod power;
mod prior;
mod profile;
mod recent;
mod report;
mod residuals;
pub mod rig;
mod search;
mod sensor;
mod series;
mod settings;
pub mod spec;
mod stage;
mod statistics;
mod tangent;
#[cfg(test)]
mod toy;
mod view;

pub use diagnose::diagnose;
pub use estimate::{Combination, Estimate, Estimated, Residual, Undetermined, estimate};
pub use experiment::{Experiment, Run, Sort};
pub use finding::{Alone, Candidate, Competitor, Diagnosis, Finding, Fitness, Reported, Unknown};
pub use fit::Fit;
pub use gain::{Gain, left};
pub use kind::{Asked, Cause, Channel, Data, Form, Kind, Log, Parameter, Proposal, Reading, Terms};
pub use known::{Deviation, Known, KnownError, check_known};
pub use named::{meaning, named};
pub use next::NextExperiment;
pub use noise::{Misstated, disbelieve, misstated};
pub use policy::{POLICY, Policy};
pub use power::{Power, Shown, power, shown, visible, visible_by_each};
pub use prior::{Prior, Source};
pub use profile::Interval;
pub use residuals::{PhaseResidual, Point, outliers, points, residuals};
pub use sensor::{Fault, Sensor};
pub use settings::Settings;
pub use stage::Stage;
