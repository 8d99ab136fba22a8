//! The small quadratic programs of a firing: one or two decisions under linear constraints, solved exactly.
//!
//! The objective is strictly convex, so that there is one optimum, and it is the optimum under at most two of the constraints alone: its
//! active set. These sets are enumerated, most of them without a look.
//!
//! **Why it is right.** Let y be the optimum under the first i − 1 constraints. If y keeps constraint i, it is the optimum under the
//! first i. If not, the optimum z under the first i lies on the border of i: else the straight way from z to y, along which the objective falls and
//! the first i − 1 hold, would go on inside i for a while, and z would not be best. So i is active, and the other that may be is
//! found on its line, an interval that each earlier constraint cuts once.
//!
//! **How much work it is.** Each of m constraints is looked at once and, if it is violated, each earlier one cuts its line once: at most
//! m looks and m (m − 1)/2 cuts ([`most_cuts`]), whatever the numbers. With one decision it is m cuts.

use crate::{Real, Reason};

/// a · x ≤ b for two decisions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfPlane<R> {
    /// a.
    pub normal: [R; 2],
    /// b.
    pub bound: R,
}

/// a x ≤ b for one decision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfLine<R> {
    /// a.
    pub slope: R,
    /// b.
    pub bound: R,
}

/// Most cuts that [`two`] makes for `constraints` of them.
#[must_use]
pub const fn most_cuts(constraints: usize) -> usize {
    constraints.saturating_mul(constraints.saturating_sub(1)) / 2
}

/// The x that minimises ½ h x² + g x under `constraints`.
///
/// # Errors
/// [`Reason::Infeasible`] if none keeps them all, to round-off; [`Reason::SensorInvalid`] if h is not positive or a number is not finite.
#[inline]
pub fn one<R: Real>(h: R, g: R, constraints: &[HalfLine<R>]) -> Result<R, Reason> {
    let free = -g / h;
    if !h.is_positive() || !free.is_finite() {
        return Err(Reason::SensorInvalid);
    }
    let mut line = Interval::all();
    for c in constraints {
        if !(c.slope.is_finite() && c.bound.is_finite()) {
            return Err(Reason::SensorInvalid);
        }
        line.cut(c.slope, c.bound, R::ZERO, c.bound.magnitude())?;
    }
    line.nearest(free)
}

/// The x that minimises ½ xᵀ H x + gᵀ x under `constraints`; `h` holds H₁₁, H₁₂ and H₂₂.
///
/// # Errors
/// [`Reason::Infeasible`] if none keeps them all, to round-off; [`Reason::SensorInvalid`] if H is not positive definite or a number
/// is not finite.
#[inline]
pub fn two<R: Real>(h: [R; 3], g: [R; 2], constraints: &[HalfPlane<R>]) -> Result<[R; 2], Reason> {
    // H = L Lᵀ; in y = Lᵀ x the objective is the squared distance from −L⁻¹ g.
    let [h11, h12, h22] = h;
    if !(h11.is_positive() && h11.is_finite() && h22.is_finite()) {
        return Err(Reason::SensorInvalid);
    }
    let i11 = R::ONE / h11.sqrt();
    let l21 = h12 * i11;
    let rest = h22 - l21 * l21;
    if !(rest > R::ROUND_OFF * h22) {
        return Err(Reason::SensorInvalid);
    }
    let i22 = R::ONE / rest.sqrt();
    let turn = |a: [R; 2]| {
        let first = a[0] * i11;
        [first, (a[1] - l21 * first) * i22]
    };
    let free = turn([-g[0], -g[1]]);
    if !(free[0].is_finite() && free[1].is_finite()) {
        return Err(Reason::SensorInvalid);
    }
    let mut best = free;
    for (i, c) in constraints.iter().enumerate() {
        let normal = turn(c.normal);
        if !(normal[0].is_finite() && normal[1].is_finite() && c.bound.is_finite()) {
            return Err(Reason::SensorInvalid);
        }
        let (p, q) = (normal[0] * best[0], normal[1] * best[1]);
        let size = c.bound.magnitude() + p.magnitude() + q.magnitude();
        if (p + q) - c.bound <= R::ROUND_OFF * size {
            continue;
        }
        best = on_border(normal, c.bound, free, constraints.get(..i).unwrap_or(&[]), turn)?;
    }
    let second = best[1] * i22;
    let x = [(best[0] - l21 * second) * i11, second];
    if x[0].is_finite() && x[1].is_finite() { Ok(x) } else { Err(Reason::SensorInvalid) }
}

/// The point of the line normal · y = bound nearest to `free` that keeps the `earlier` constraints.
#[inline]
fn on_border<R: Real>(
    normal: [R; 2],
    bound: R,
    free: [R; 2],
    earlier: &[HalfPlane<R>],
    turn: impl Fn([R; 2]) -> [R; 2],
) -> Result<[R; 2], Reason> {
    let square = normal[0] * normal[0] + normal[1] * normal[1];
    // Nothing but the bound is left of a constraint without a normal, and it is violated.
    if !square.is_positive() {
        return Err(Reason::Infeasible);
    }
    let lever = ((normal[0] * free[0] + normal[1] * free[1]) - bound) / square;
    let foot = [free[0] - lever * normal[0], free[1] - lever * normal[1]];
    let mut line = Interval::all();
    for c in earlier {
        let other = turn(c.normal);
        let slope = other[1] * normal[0] - other[0] * normal[1];
        let (p, q) = (other[0] * foot[0], other[1] * foot[1]);
        let size = c.bound.magnitude() + p.magnitude() + q.magnitude();
        // Two products nearly cancel where the lines are parallel.
        let doubt = R::ROUND_OFF * ((other[1] * normal[0]).magnitude() + (other[0] * normal[1]).magnitude());
        line.cut(slope, c.bound - (p + q), doubt, size)?;
    }
    let t = line.nearest(R::ZERO)?;
    Ok([foot[0] - t * normal[1], foot[1] + t * normal[0]])
}

/// An interval of a line that constraints cut shorter.
struct Interval<R> {
    low: R,
    high: R,
    bounded: [bool; 2],
}

impl<R: Real> Interval<R> {
    #[inline]
    fn all() -> Interval<R> {
        Interval { low: R::ZERO, high: R::ZERO, bounded: [false; 2] }
    }

    /// Keeps where slope · t ≤ room; a slope within `doubt` is none. `size` is that of the numbers whose difference `room` is.
    #[inline]
    fn cut(&mut self, slope: R, room: R, doubt: R, size: R) -> Result<(), Reason> {
        if slope.magnitude() <= doubt {
            return if room < -(R::ROUND_OFF * size) { Err(Reason::Infeasible) } else { Ok(()) };
        }
        let end = room / slope;
        if slope > R::ZERO {
            if !self.bounded[1] || end < self.high {
                self.high = end;
            }
            self.bounded[1] = true;
        } else {
            if !self.bounded[0] || end > self.low {
                self.low = end;
            }
            self.bounded[0] = true;
        }
        Ok(())
    }

    /// The point nearest to `t`.
    #[inline]
    fn nearest(&self, t: R) -> Result<R, Reason> {
        let [from_below, from_above] = self.bounded;
        if from_below && from_above {
            let size = self.low.magnitude() + self.high.magnitude();
            if self.low - self.high > R::ROUND_OFF * size {
                return Err(Reason::Infeasible);
            }
        }
        let mut t = t;
        if from_above && t > self.high {
            t = self.high;
        }
        if from_below && t < self.low {
            t = self.low;
        }
        if t.is_finite() { Ok(t) } else { Err(Reason::SensorInvalid) }
    }
}
