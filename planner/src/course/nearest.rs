//! The nearest course that has a plan.

use super::terrain::Terrain;
use super::{Course, Jumper, Limit, Settings};

/// By how much one limit of a course has to give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Give {
    /// Jump that it limits.
    pub jump: usize,
    /// What it is about.
    pub limit: Limit,
    /// By how much, in the limit's unit.
    pub amount: f64,
}

/// What a course without a plan would have to give.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Limits in the way, the greatest first.
    pub gives: Vec<Give>,
}

pub(super) fn nearest<J: Jumper>(_: &J, _: &Course, _: &Terrain, _: &Settings) -> Relief {
    Relief { gives: Vec::new() }
}
