//! Lift-off over approach rate and firing angle.

use crate::axis::{cubic, cubic_slope, hermite, hermite_slope};
use crate::table::corners;
use crate::{Axis, LiftOff, Real, Reason};

/// Numbers at a node of a [`LiftOffMap`].
pub const MAP_NODE: usize = 20;

/// Where and how fast the wheel's centre lifts off, over approach rate and firing angle, between
/// nodes by bicubics.
#[derive(Clone, Copy, Debug)]
pub struct LiftOffMap<'a, R> {
    /// Approach rates ω (rad/s).
    pub rates: Axis<R>,
    /// Firing angles α_f (rad).
    pub angles: Axis<R>,
    /// At each node, angles within rates: x, y (m), v_x, v_y (m/s); their slopes by ω; by α_f;
    /// their mixed derivatives, each times the spacing; then the derivatives of the four by the
    /// valve opening time (m/s, m/s²).
    pub nodes: &'a [[R; MAP_NODE]],
    /// For each cell, angles within rates: 1 if all of it jumps, else 0.
    pub open: &'a [u8],
}

impl<R: Real> LiftOffMap<'_, R> {
    /// The lift-off of a robot that comes at `rate` (rad/s) and is fired at `angle` (rad), with its
    /// derivatives.
    ///
    /// # Errors
    /// As [`FiringTable::firing_angle`](crate::FiringTable::firing_angle).
    #[inline]
    pub fn at(&self, rate: R, angle: R) -> Result<LiftOff<R>, Reason> {
        let (i, j) = (self.rates.locate(rate)?, self.angles.locate(angle)?);
        let [a, b, c, d] = corners(self.nodes, self.open, &self.angles, i, j)?;
        let (u, v, w) = (hermite(i.part), hermite(j.part), hermite_slope(j.part));
        // Four quantities side by side, as registers hold them.
        let along = |p: &[R; MAP_NODE], q: &[R; MAP_NODE], k: usize| {
            four(
                part(p, k),
                part(q, k),
                part(p, k + 4),
                part(q, k + 4),
                |p, q, p_s, q_s| cubic(u, (p, p_s), (q, q_s)),
            )
        };
        let (low, low_slope) = (along(a, c, 0), along(a, c, 8));
        let (high, high_slope) = (along(b, d, 0), along(b, d, 8));
        let state = four(low, low_slope, high, high_slope, |p, p_t, q, q_t| {
            cubic(v, (p, p_t), (q, q_t))
        });
        let by_angle = four(low, low_slope, high, high_slope, |p, p_t, q, q_t| {
            cubic_slope(w, (p, p_t), (q, q_t)) * self.angles.per_unit
        });
        let by_valve = four(
            part(a, 16),
            part(b, 16),
            part(c, 16),
            part(d, 16),
            |a, b, c, d| {
                let (low, high) = (a + i.part * (c - a), b + i.part * (d - b));
                low + j.part * (high - low)
            },
        );
        Ok(LiftOff {
            state,
            by_angle,
            by_valve,
        })
    }
}

/// `f` of the first of each, of the second, and so on.
#[inline]
fn four<R: Real>(
    a: [R; 4],
    b: [R; 4],
    c: [R; 4],
    d: [R; 4],
    f: impl Fn(R, R, R, R) -> R,
) -> [R; 4] {
    [
        f(a[0], b[0], c[0], d[0]),
        f(a[1], b[1], c[1], d[1]),
        f(a[2], b[2], c[2], d[2]),
        f(a[3], b[3], c[3], d[3]),
    ]
}

/// Four of a node's numbers, from `k` ≤ 16 on.
#[inline]
fn part<R: Real>(node: &[R; MAP_NODE], k: usize) -> [R; 4] {
    match node.get(k..) {
        Some([p, q, r, s, ..]) => [*p, *q, *r, *s],
        _ => [R::ZERO; 4],
    }
}
