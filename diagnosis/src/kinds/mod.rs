//! The kinds of experiments.

pub mod flight;
pub mod slide;
pub mod stroke;
pub mod vessel;

use crate::kind::{Cause, Parameter};

/// A cause with one parameter.
fn simple(
    id: &'static str,
    name: &'static str,
    neutral: f64,
    bounds: (f64, f64),
    scale: f64,
    starts: &[f64],
) -> Cause {
    Cause { id, parameters: vec![Parameter { name, neutral, bounds, scale, starts: starts.to_vec() }] }
}

/// An unknown of a run, free but for `bounds`.
fn unknown(name: &'static str, neutral: f64, bounds: (f64, f64), scale: f64) -> Parameter {
    Parameter { name, neutral, bounds, scale, starts: Vec::new() }
}

/// Any number.
const FREE: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
