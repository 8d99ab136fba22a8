//! The small quadratic programs of a firing: one or two decisions under linear constraints, solved
//! exactly.
//!
//! The objective is strictly convex, so that there is one optimum, and it is the optimum under at
//! most two of the constraints alone: its active set. These sets are enumerated, most of them
//! without a look.
//!
//! **Why it is right.** Let y be the optimum under the first i − 1 constraints. If y keeps
//! constraint i, it is the optimum under the first i. If not, the optimum z under the first i lies
//! on the border of i: else the straight way from z to y, along which the objective falls and the
//! first i − 1 hold, would go on inside i for a while, and z would not be best. So i is active, and
//! the other that may be is found on its line, an interval that each earlier constraint cuts once.
//!
//! **How much work it is.** Each of m constraints is looked at once and, if it is violated, each
//! earlier one cuts its line once: at most m looks and m (m − 1)/2 cuts ([`most_cuts`]), whatever
//! the numbers. With one decision it is m cuts.

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
/// [`Reason::Infeasible`] if none keeps them all, to round-off; [`Reason::SensorInvalid`] if h is
/// not positive or a number is not finite.
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
/// [`Reason::Infeasible`] if none keeps them all, to round-off; [`Reason::SensorInvalid`] if H is
/// not positive definite or a number is not finite.
#[inline]
pub fn two<R: Real>(h: [R; 3], g: [R; 2], constraints: &[HalfPlane<R>]) -> Result<[R; 2], Reason> {
    let [h11, h12, h22] = h;
    let (product, square) = (h11 * h22, h12 * h12);
    let determinant = product - square;
    // Below this, the difference is round-off.
    let doubt = R::ROUND_OFF * R::of(0.0625) * product;
    if !(h11.is_positive() && determinant > doubt && determinant.is_finite()) {
        return Err(Reason::SensorInvalid);
    }
    // H⁻¹ a, but for the determinant.
    let inverse = |a: [R; 2]| [h22 * a[0] - h12 * a[1], h11 * a[1] - h12 * a[0]];
    let [p, q] = inverse(g);
    let free = [-p / determinant, -q / determinant];
    if !(free[0].is_finite() && free[1].is_finite()) {
        return Err(Reason::SensorInvalid);
    }
    let mut best = free;
    for (i, c) in constraints.iter().enumerate() {
        let (p, q) = (c.normal[0] * best[0], c.normal[1] * best[1]);
        let size = c.bound.magnitude() + p.magnitude() + q.magnitude();
        if !size.is_finite() {
            return Err(Reason::SensorInvalid);
        }
        if (p + q) - c.bound <= R::ROUND_OFF * size {
            continue;
        }
        best = on_border(
            c,
            inverse(c.normal),
            free,
            constraints.get(..i).unwrap_or(&[]),
        )?;
    }
    if best[0].is_finite() && best[1].is_finite() {
        Ok(best)
    } else {
        Err(Reason::SensorInvalid)
    }
}

/// The best point of the border of `c` that keeps the `earlier` constraints; `way` is H⁻¹ a but for
/// a factor.
///
/// Along the border the objective is a parabola about where `way` from the `free` optimum meets it.
#[inline]
fn on_border<R: Real>(
    c: &HalfPlane<R>,
    way: [R; 2],
    free: [R; 2],
    earlier: &[HalfPlane<R>],
) -> Result<[R; 2], Reason> {
    let normal = c.normal;
    let square = normal[0] * way[0] + normal[1] * way[1];
    // Nothing but the bound is left of a constraint without a normal, and it is violated.
    if !square.is_positive() {
        return Err(Reason::Infeasible);
    }
    let lever = ((normal[0] * free[0] + normal[1] * free[1]) - c.bound) / square;
    let foot = [free[0] - lever * way[0], free[1] - lever * way[1]];
    let mut line = Interval::all();
    for other in earlier {
        let (u, v) = (other.normal[1] * normal[0], other.normal[0] * normal[1]);
        let (p, q) = (other.normal[0] * foot[0], other.normal[1] * foot[1]);
        let size = other.bound.magnitude() + p.magnitude() + q.magnitude();
        // The two products nearly cancel where the lines are parallel.
        let doubt = R::ROUND_OFF * u.magnitude();
        line.cut(u - v, other.bound - (p + q), doubt, size)?;
    }
    let t = line.nearest(R::ZERO)?;
    Ok([foot[0] - t * normal[1], foot[1] + t * normal[0]])
}

/// An interval of a line that constraints cut shorter.
struct Interval<R> {
    low: R,
    high: R,
}

impl<R: Real> Interval<R> {
    #[inline]
    fn all() -> Interval<R> {
        Interval {
            low: -R::GREATEST,
            high: R::GREATEST,
        }
    }

    /// Keeps where slope · t ≤ room; a slope within `doubt` is none. `size` is that of the numbers
    /// whose difference `room` is.
    #[inline]
    fn cut(&mut self, slope: R, room: R, doubt: R, size: R) -> Result<(), Reason> {
        if slope.magnitude() <= doubt {
            return if room < -(R::ROUND_OFF * size) {
                Err(Reason::Infeasible)
            } else {
                Ok(())
            };
        }
        let end = room / slope;
        // Without branches, which nothing could predict.
        let upper = slope.is_positive();
        let (high, low) = (self.high.lesser(end), self.low.greater(end));
        self.high = if upper { high } else { self.high };
        self.low = if upper { self.low } else { low };
        Ok(())
    }

    /// The point nearest to `t`.
    #[inline]
    fn nearest(&self, t: R) -> Result<R, Reason> {
        // Where an end is missing, the size is infinite and the interval not empty.
        let size = self.low.magnitude() + self.high.magnitude();
        if self.low - self.high > R::ROUND_OFF * size {
            return Err(Reason::Infeasible);
        }
        let t = t.lesser(self.high).greater(self.low);
        if t.is_finite() {
            Ok(t)
        } else {
            Err(Reason::SensorInvalid)
        }
    }
}
