//! Firing angles over approach rate and distance.

use crate::axis::{Spot, cubic, hermite};
use crate::{Axis, Real, Reason};

/// Firing angles α_f over approach rate and distance, between nodes by a bicubic.
///
/// At export the slopes are those of the exact planner, limited so that the cubic along either axis
/// rises or falls wherever its nodes do.
///
/// Source: Fritsch and Carlson, Monotone piecewise cubic interpolation, SIAM J. Numer. Anal. 17
/// (1980).
#[derive(Clone, Copy, Debug)]
pub struct FiringTable<'a, R> {
    /// Approach rates ω (rad/s).
    pub rates: Axis<R>,
    /// Distances (m).
    pub distances: Axis<R>,
    /// At each node, distances within rates: α_f (rad), its slope by ω and by distance and its
    /// mixed derivative, each times the spacing.
    pub nodes: &'a [[R; 4]],
    /// For each cell, distances within rates: 1 if all of it can be reached, else 0.
    pub open: &'a [u8],
}

impl<R: Real> FiringTable<'_, R> {
    /// α_f (rad) at which a robot that comes at `rate` (rad/s) lands at `distance` (m).
    ///
    /// # Errors
    /// [`Reason::SensorInvalid`] for what is no finite number, [`Reason::OutOfTable`] beyond its
    /// ends, [`Reason::Infeasible`] in a cell of which some part cannot be reached.
    #[inline]
    pub fn firing_angle(&self, rate: R, distance: R) -> Result<R, Reason> {
        let (i, j) = (self.rates.locate(rate)?, self.distances.locate(distance)?);
        corners(self.nodes, self.open, &self.distances, i, j)
            .map(|four| bicubic(four, i.part, j.part))
    }

    /// α_f (rad) for `distance` (m) at both ends of the cell `cell` of rates; none where it is
    /// closed.
    ///
    /// # Errors
    /// As [`firing_angle`](Self::firing_angle).
    pub(crate) fn ends(&self, cell: usize, distance: R) -> Result<Option<[R; 2]>, Reason> {
        let j = self.distances.locate(distance)?;
        let v = hermite(j.part);
        match corners(
            self.nodes,
            self.open,
            &self.distances,
            Spot {
                cell,
                part: R::ZERO,
            },
            j,
        ) {
            Ok([a, b, c, d]) => Ok(Some([along(v, a, b).0, along(v, c, d).0])),
            Err(Reason::Infeasible) => Ok(None),
            Err(reason) => Err(reason),
        }
    }
}

/// The four nodes of an open cell: at (i, j), (i, j + 1), (i + 1, j), (i + 1, j + 1).
#[inline]
pub(crate) fn corners<'n, R: Real, const N: usize>(
    nodes: &'n [[R; N]],
    open: &[u8],
    inner: &Axis<R>,
    i: Spot<R>,
    j: Spot<R>,
) -> Result<[&'n [R; N]; 4], Reason> {
    // Wrapping, for tables whose sizes are not what they say.
    let cell = i
        .cell
        .wrapping_mul(inner.count.wrapping_sub(1))
        .wrapping_add(j.cell);
    match open.get(cell) {
        Some(1) => {}
        Some(_) => return Err(Reason::Infeasible),
        None => return Err(Reason::OutOfTable),
    }
    let first = i.cell.wrapping_mul(inner.count).wrapping_add(j.cell);
    let second = first.wrapping_add(inner.count);
    let at = |k: usize| nodes.get(k).ok_or(Reason::OutOfTable);
    Ok([
        at(first)?,
        at(first.wrapping_add(1))?,
        at(second)?,
        at(second.wrapping_add(1))?,
    ])
}

/// The bicubic of four corners at (`s`, `t`): along the inner axis first, which a distance is known
/// for before the rate is.
#[inline]
fn bicubic<R: Real>([a, b, c, d]: [&[R; 4]; 4], s: R, t: R) -> R {
    let (u, v) = (hermite(s), hermite(t));
    cubic(u, along(v, a, b), along(v, c, d))
}

/// Value and slope by the outer axis, at a place along the inner between two nodes.
#[inline]
fn along<R: Real>(v: [R; 3], p: &[R; 4], q: &[R; 4]) -> (R, R) {
    let ([p, p_s, p_t, p_st], [q, q_s, q_t, q_st]) = (*p, *q);
    (
        cubic(v, (p, p_t), (q, q_t)),
        cubic(v, (p_s, p_st), (q_s, q_st)),
    )
}
