//! How a ball lies before it rolls: gravity says which way is up.

use super::estimate::{Inertial, Scales};
use super::rotation::Rotation;
use crate::Real;

/// Why a ball cannot tell how it lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Unsettled {
    /// Too few readings yet.
    AskLater = 1,
    /// It turns, or something shakes it: no direction of gravity.
    Moving = 2,
    /// An accelerometer is at its end.
    Saturated = 3,
}

/// The mean of a ball's accelerometers at rest.
///
/// Source: thesis 8.3.1, by which it has no heading from outside: where it looks first is as good as any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AtRest {
    sums: [i32; 3],
    count: i32,
    /// Greatest reading of a fine gyro, in counts of either sign.
    fastest: i32,
    is_saturated: bool,
}

/// Least readings for a mean.
const NEEDED: i32 = 100;
/// Most readings in a mean: sums of as many counts of 24 bits do not overflow.
const MOST: i32 = 250;
/// Rate (rad/s) above which it moves: more than gyros with the thesis' noise say at rest.
const MOVING: f64 = 0.8;
/// Part of gravity by which the mean's length may be off.
const SHAKEN: f64 = 0.15;

impl AtRest {
    /// Without readings.
    pub const fn new() -> AtRest {
        AtRest {
            sums: [0; 3],
            count: 0,
            fastest: 0,
            is_saturated: false,
        }
    }

    /// Takes a cycle's readings, of sensors with these `scales`; beyond 250, no more.
    #[inline]
    pub fn take<R: Real>(&mut self, scales: &Scales<R>, readings: &Inertial) {
        if self.count >= MOST {
            return;
        }
        let limit = scales.limit;
        for k in 0..3 {
            let reading = readings.fine_accelerometer[k];
            self.is_saturated |= reading >= limit || reading <= limit.wrapping_neg();
            self.sums[k] = self.sums[k].wrapping_add(reading);
            let turns = readings.fine_gyro[k];
            let turns = if turns < 0 {
                turns.wrapping_neg()
            } else {
                turns
            };
            self.fastest = self.fastest.max(turns);
        }
        self.count += 1;
    }

    /// Its attitude, where gravity is `gravity` (m/s²): upright by gravity, along any heading.
    ///
    /// # Errors
    /// [`Unsettled`].
    pub fn attitude<R: Real>(
        &self,
        scales: &Scales<R>,
        gravity: R,
    ) -> Result<Rotation<R>, Unsettled> {
        if self.count < NEEDED {
            return Err(Unsettled::AskLater);
        }
        if self.is_saturated {
            return Err(Unsettled::Saturated);
        }
        if R::of_count(self.fastest) * scales.fine_gyro > R::of(MOVING) {
            return Err(Unsettled::Moving);
        }
        let count = scales.fine_accelerometer / R::of_count(self.count);
        let [x, y, z] = self.sums.map(|sum| R::of_count(sum) * count);
        let length = (x * x + y * y + z * z).sqrt();
        let off = R::of(SHAKEN) * gravity;
        if !(length - gravity).within(-off, off) {
            return Err(Unsettled::Moving);
        }
        // The shortest turn from up in the body's axes to the world's; with its head down, half a turn about x before.
        if z >= R::ZERO {
            return Ok(Rotation([length + z, y, -x, R::ZERO]).unit());
        }
        let half_turn = Rotation([R::ZERO, R::ONE, R::ZERO, R::ZERO]);
        let rest = Rotation([length - z, -y, -x, R::ZERO]);
        Ok(rest.after(&half_turn).unit())
    }
}

impl Default for AtRest {
    fn default() -> AtRest {
        AtRest::new()
    }
}
