//! Which two feet stand: the wheel's encoder is relative, gravity is not.

use crate::Real;
use crate::real::{cosine, sine};
use crate::run::runner::{LEGS, count};
use crate::run::{Readings, Signals};

/// Why a robot cannot tell on which feet it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Unsure {
    /// Too few readings yet.
    AskLater = 1,
    /// The wheel turns, or something shakes it: no direction of gravity.
    Moving = 2,
    /// The direction of gravity lies between two poses of rest, or the robot has fewer than 3 legs
    /// or more than 12.
    Between = 3,
    /// The accelerometer is at its end.
    Saturated = 4,
}

/// The mean of the accelerometer at rest.
///
/// A wheel of n legs rests on two neighbours in n poses, 2π/n apart; a slope turns gravity in all of
/// them alike. Nothing but the pose itself is taken from the accelerometer: at rest its lean is known
/// exactly.
///
/// Source: thesis 5.1.4.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing<R> {
    sums: [i32; 2],
    count: i32,
    fastest: R,
    is_saturated: bool,
}

/// Least readings for a mean.
const NEEDED: i32 = 100;
/// Most readings in a mean: sums of as many counts of 24 bits do not overflow.
const MOST: i32 = 250;
/// Rate (rad/s) above which the wheel moves: eight times what a noisy gyro says at rest.
const MOVING: f64 = 0.8;
/// Part of gravity by which the mean's length may be off.
const SHAKEN: f64 = 0.15;
/// How far (rad) gravity may lie from a pose: past it, the next pose is nearly as near.
const NEAR: f64 = 0.45;
/// The same where legs are closer, as a part of half the angle from pose to pose.
const NEAR_PART: f64 = 0.8;

impl<R: Real> Standing<R> {
    /// Without readings.
    pub fn new() -> Standing<R> {
        Standing {
            sums: [0; 2],
            count: 0,
            fastest: R::ZERO,
            is_saturated: false,
        }
    }

    /// Takes a cycle's readings; beyond 250, no more.
    #[inline]
    pub fn take(&mut self, signals: &Signals<'_, R>, readings: &Readings) {
        if self.count >= MOST {
            return;
        }
        let limit = signals.instruments().accelerometer_limit;
        for k in 0..2 {
            let reading = readings.fine_accelerometer[k];
            self.is_saturated |= reading >= limit || reading <= limit.wrapping_neg();
            self.sums[k] = self.sums[k].wrapping_add(reading);
        }
        self.fastest = self.fastest.greater(signals.gyro(readings).magnitude());
        self.count = self.count.wrapping_add(1);
    }

    /// The rear one of the two legs that stand, of `legs` (3 to 12), where gravity is `gravity` (m/s²).
    ///
    /// # Errors
    /// [`Unsure`].
    pub fn rear_leg(&self, signals: &Signals<'_, R>, legs: u32, gravity: R) -> Result<u32, Unsure> {
        if self.count < NEEDED {
            return Err(Unsure::AskLater);
        }
        if self.is_saturated {
            return Err(Unsure::Saturated);
        }
        if self.fastest > R::of(MOVING) {
            return Err(Unsure::Moving);
        }
        let scale = signals.instruments().fine_accelerometer / R::of_count(self.count);
        let [forward, up] = self.sums.map(|sum| R::of_count(sum) * scale);
        let length = (forward * forward + up * up).sqrt();
        let off = R::of(SHAKEN) * gravity;
        if !(length - gravity).within(-off, off) {
            return Err(Unsure::Moving);
        }
        if !LEGS.contains(&legs) {
            return Err(Unsure::Between);
        }
        // A unit vector up, in the wheel's axes, turns backwards as the wheel leans forwards.
        let (mut best, mut most) = (0, -R::of(2.0));
        let half = R::of(core::f64::consts::PI) / count(legs);
        let (mut s, mut c) = (sine_of(half), cosine_of(half));
        let (turn_s, turn_c) = (sine_of(half + half), cosine_of(half + half));
        for leg in 0..legs {
            let along = (up * c - forward * s) / length;
            if along > most {
                (best, most) = (leg, along);
            }
            (s, c) = (s * turn_c + c * turn_s, c * turn_c - s * turn_s);
        }
        let near = (half * R::of(NEAR_PART)).lesser(R::of(NEAR));
        if most >= cosine_of(near) {
            Ok(best)
        } else {
            Err(Unsure::Between)
        }
    }
}

impl<R: Real> Default for Standing<R> {
    fn default() -> Standing<R> {
        Standing::new()
    }
}

/// sin x for 0 ≤ x ≤ 2.2, by the half angle.
fn sine_of<R: Real>(x: R) -> R {
    let half = x * R::of(0.5);
    R::of(2.0) * sine(half) * cosine(half)
}

/// cos x for 0 ≤ x ≤ 2.2, by the half angle.
fn cosine_of<R: Real>(x: R) -> R {
    let s = sine(x * R::of(0.5));
    R::ONE - R::of(2.0) * s * s
}
