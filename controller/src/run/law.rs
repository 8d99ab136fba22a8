//! At which lean a leg fires, and for how long.

use crate::Real;
use crate::real::tanh;

/// A firing law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law<'a, R> {
    /// α_f(t) = A tanh(B t − C) + D over the time (s) since the start.
    ///
    /// Source: thesis 5.1.3, open loop.
    OverTime {
        /// A (rad).
        amplitude: R,
        /// B (1/s).
        slope: R,
        /// C.
        shift: R,
        /// D (rad).
        level: R,
        /// Valve opening time t_v (s).
        valve_open: R,
    },
    /// Straight lines between knots over the rate ω, and level beyond the first and the last. Two
    /// knots at one rate are a jump, whose upper side holds at that rate.
    ///
    /// One knot is a fixed firing angle, two are the closed loop of one line, three or four that of
    /// two lines; a smooth curve is many.
    ///
    /// Source: thesis 5.1.2, 5.1.3.
    Lines(&'a [Knot<R>]),
}

/// A knot of a law of lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot<R> {
    /// Rate ω (rad/s), not below that of the knot before.
    pub rate: R,
    /// Firing angle α_f (rad).
    pub firing_angle: R,
    /// Valve opening time t_v (s).
    pub valve_open: R,
}

/// A lean (rad) that no leg in the zone has.
pub(super) const NEVER: f64 = core::f64::consts::PI;

impl<R: Real> Law<'_, R> {
    /// Firing angle (rad) and valve opening time (s) at `time` (s) since the start and the rate
    /// `rate` (rad/s). What is not a number, and a law without knots, fires never: π and 0.
    #[inline]
    pub fn at(&self, time: R, rate: R) -> [R; 2] {
        let never = [R::of(NEVER), R::ZERO];
        match self {
            Law::OverTime {
                amplitude,
                slope,
                shift,
                level,
                valve_open,
            } => {
                let angle = *amplitude * tanh(*slope * time - *shift) + *level;
                [angle, *valve_open]
            }
            Law::Lines(knots) => between(knots, rate).unwrap_or(never),
        }
    }
}

/// The lines through `knots` at `rate`.
#[inline]
fn between<R: Real>(knots: &[Knot<R>], rate: R) -> Option<[R; 2]> {
    let (first, last) = (knots.first()?, knots.last()?);
    if !rate.is_finite() {
        return None;
    }
    if rate >= last.rate {
        return Some([last.firing_angle, last.valve_open]);
    }
    if rate < first.rate {
        return Some([first.firing_angle, first.valve_open]);
    }
    let mut before = first;
    for next in knots {
        if next.rate > rate {
            let part = (rate - before.rate) / (next.rate - before.rate);
            let mix = |a: R, b: R| a + part * (b - a);
            return Some([
                mix(before.firing_angle, next.firing_angle),
                mix(before.valve_open, next.valve_open),
            ]);
        }
        before = next;
    }
    None
}
