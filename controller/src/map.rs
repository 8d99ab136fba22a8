//! Lift-off over approach rate and firing angle.

use crate::axis::{cubic, cubic_slope, hermite, hermite_slope};
use crate::table::{along, corners};
use crate::{Axis, LiftOff, Real, Reason};

/// Numbers at a node of a [`LiftOffMap`].
pub const MAP_NODE: usize = 20;

/// Where and how fast the wheel's centre lifts off, over approach rate and firing angle, between nodes by bicubics.
#[derive(Clone, Copy, Debug)]
pub struct LiftOffMap<'a, R> {
    /// Approach rates ω (rad/s).
    pub rates: Axis<R>,
    /// Firing angles α_f (rad).
    pub angles: Axis<R>,
    /// At each node, angles within rates: for each of x, y (m), v_x, v_y (m/s) its value, its slope by ω and by α_f and its mixed
    /// derivative, each times the spacing; then the derivatives of these four by the valve opening time (m/s, m/s²).
    pub nodes: &'a [[R; MAP_NODE]],
    /// For each cell, angles within rates: 1 if all of it jumps, else 0.
    pub open: &'a [u8],
}

impl<R: Real> LiftOffMap<'_, R> {
    /// The lift-off of a robot that comes at `rate` (rad/s) and is fired at `angle` (rad), with its derivatives.
    ///
    /// # Errors
    /// As [`FiringTable::firing_angle`](crate::FiringTable::firing_angle).
    #[inline]
    pub fn at(&self, rate: R, angle: R) -> Result<LiftOff<R>, Reason> {
        let (i, j) = (self.rates.locate(rate)?, self.angles.locate(angle)?);
        let [a, b, c, d] = corners(self.nodes, self.open, &self.angles, i, j)?;
        let (u, v, w) = (hermite(i.part), hermite(j.part), hermite_slope(j.part));
        let one = |k: usize| {
            let (low, high) = (along(u, &part(a, k), &part(c, k)), along(u, &part(b, k), &part(d, k)));
            (cubic(v, low, high), cubic_slope(w, low, high) * self.angles.per_unit)
        };
        let [(x, x_a), (y, y_a), (vx, vx_a), (vy, vy_a)] = [one(0), one(4), one(8), one(12)];
        let ([a, e, k, o], [b, f, l, p]) = (part(a, 16), part(b, 16));
        let ([c, g, m, q], [d, h, n, r]) = (part(c, 16), part(d, 16));
        let flat = |a: R, b: R, c: R, d: R| {
            let (low, high) = (a + i.part * (c - a), b + i.part * (d - b));
            low + j.part * (high - low)
        };
        Ok(LiftOff {
            state: [x, y, vx, vy],
            by_angle: [x_a, y_a, vx_a, vy_a],
            by_valve: [flat(a, b, c, d), flat(e, f, g, h), flat(k, l, m, n), flat(o, p, q, r)],
        })
    }
}

/// Four of a node's numbers, from `k` ≤ 16 on.
#[inline]
fn part<R: Real>(node: &[R; MAP_NODE], k: usize) -> [R; 4] {
    match node.get(k..) {
        Some([p, q, r, s, ..]) => [*p, *q, *r, *s],
        _ => [R::ZERO; 4],
    }
}
