//! At which lean a leg fires, and for how long.

use crate::real::tanh;
use crate::{Axis, Real};

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
    /// A table over what the robot does as a leg enters the zone.
    Policy(Policy<'a, R>),
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

/// A table of firing angles and valve opening times over the rate at which a leg enters the zone:
/// straight lines between its nodes, level beyond them. It has a row for each number of legs that have
/// come into the zone since the start, of which the last holds from then on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Policy<'a, R> {
    /// Rates (rad/s).
    pub rates: Axis<R>,
    /// Rows: with one the table is over the rate alone.
    pub rows: usize,
    /// Firing angle (rad) and valve opening time (s) at each rate, row after row.
    pub nodes: &'a [[R; 2]],
}

/// A lean (rad) that no leg in the zone has.
pub(super) const NEVER: f64 = core::f64::consts::PI;

impl<R: Real> Law<'_, R> {
    /// Firing angle (rad) and valve opening time (s) at `time` (s) since the start and the rate
    /// `rate` (rad/s); a policy looks at the rate `entry` (rad/s) at which the leg entered the zone and
    /// at how many legs have `passed` into it since the start. What is not a number, and a law without
    /// knots, fires never: π and 0.
    #[inline]
    pub fn at(&self, time: R, rate: R, entry: R, passed: i32) -> [R; 2] {
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
            Law::Policy(policy) => policy.at(entry, passed).unwrap_or(never),
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

impl<R: Real> Policy<'_, R> {
    #[inline]
    fn at(&self, entry: R, passed: i32) -> Option<[R; 2]> {
        if !entry.is_finite() {
            return None;
        }
        let inside = entry.greater(self.rates.first).lesser(self.rates.last);
        let spot = self.rates.locate(inside).ok()?;
        let row = (passed.max(0).unsigned_abs() as usize).min(self.rows.saturating_sub(1));
        let cell = row.wrapping_mul(self.rates.count).wrapping_add(spot.cell);
        let (from, to) = (self.nodes.get(cell)?, self.nodes.get(cell.wrapping_add(1))?);
        let mix = |k: usize| from[k] + spot.part * (to[k] - from[k]);
        Some([mix(0), mix(1)])
    }
}
