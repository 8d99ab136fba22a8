//! What several studies share.

pub mod analysis;
pub mod climbing;
pub mod few;
pub mod half_turn;
pub mod jumps_in_space;
pub mod laws;
pub mod optimal;
pub mod tiles;

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_gait::GaitError;

/// An error unless `holds`.
pub(crate) fn require(
    holds: bool,
    name: &str,
    value: f64,
    allowed: impl Into<String>,
) -> Result<(), GaitError> {
    if holds {
        return Ok(());
    }
    Err(refused(name, value, allowed))
}

/// The error of a number that is outside its domain.
fn refused(name: &str, value: f64, allowed: impl Into<String>) -> GaitError {
    GaitError::Input {
        name: name.into(),
        value,
        allowed: allowed.into(),
    }
}

/// `x` as a whole number within the range of one.
#[allow(clippy::cast_possible_truncation)]
pub(crate) fn whole(x: f64) -> i32 {
    x.round() as i32
}

/// A number from 0 to 1, without 1.
pub(crate) fn unit(random: &mut Pcg64) -> f64 {
    Uniform::new(0.0, 1.0).map_or(0.0, |uniform| uniform.sample(random))
}

/// A whole number below `count`.
pub(crate) fn below(count: usize, random: &mut Pcg64) -> usize {
    Uniform::new(0, count).map_or(0, |uniform| uniform.sample(random))
}
