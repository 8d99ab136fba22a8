//! At which instant to open the valve.

use crate::real::sine;
use crate::{Real, Reason};

/// When to command the valve, counted from the reading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Timing<R> {
    /// Not within this control period, but after this time (s).
    Wait(R),
    /// Within this control period, this long (s) after the reading.
    Fire(R),
    /// The instant has passed by this time (s); the caller decides whether a late jump is better
    /// than none.
    Late(R),
}

/// Time (s) in which a wheel that pivots on its foot goes from `lean` (rad) at `rate` (rad/s) on to
/// `angle` (rad); negative where it is past.
///
/// At constant acceleration c sin φ, `pendulum` being c (1/s²). That is exact to third order in the
/// time, and asked anew at every reading.
///
/// # Errors
/// [`Reason::Infeasible`] if it comes to rest before.
#[inline]
pub(crate) fn time_to<R: Real>(lean: R, rate: R, pendulum: R, angle: R) -> Result<R, Reason> {
    if !rate.is_positive() {
        return Err(Reason::Infeasible);
    }
    let (way, acceleration) = (angle - lean, pendulum * sine(lean));
    let square = rate * rate + (acceleration + acceleration) * way;
    if !square.is_at_least_zero() {
        return Err(Reason::Infeasible);
    }
    Ok((way + way) / (rate + square.sqrt()))
}
