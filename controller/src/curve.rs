//! Firing angles over approach rate, for one distance.

use crate::axis::{Spot, cubic, hermite};
use crate::{Axis, Real, Reason};

/// Firing angles α_f over approach rate for one distance, between nodes by a cubic.
///
/// As [`FiringTable`](crate::FiringTable), with one axis.
#[derive(Clone, Copy, Debug)]
pub struct FiringCurve<'a, R> {
    /// Approach rates ω (rad/s).
    pub rates: Axis<R>,
    /// The distance (m) that it was made for.
    pub distance: R,
    /// At each node: α_f (rad), and its slope by ω times the spacing.
    pub nodes: &'a [[R; 2]],
    /// For each cell: 1 if all of it can be reached, else 0.
    pub open: &'a [u8],
}

impl<R: Real> FiringCurve<'_, R> {
    /// α_f (rad) at the approach rate `rate` (rad/s) for its distance, which `distance` (m) must
    /// be.
    ///
    /// # Errors
    /// As [`FiringTable::firing_angle`](crate::FiringTable::firing_angle); another distance is
    /// [`Reason::OutOfTable`].
    #[inline]
    pub fn firing_angle(&self, rate: R, distance: R) -> Result<R, Reason> {
        let i = self.rates.locate(rate)?;
        self.check(distance)?;
        let [(a, a_s), (b, b_s)] = self.cell(i)?;
        Ok(cubic(hermite(i.part), (a, a_s), (b, b_s)))
    }

    /// α_f (rad) at both ends of the cell `cell`; none where it is closed.
    ///
    /// # Errors
    /// As [`firing_angle`](Self::firing_angle).
    pub(crate) fn ends(&self, cell: usize, distance: R) -> Result<Option<[R; 2]>, Reason> {
        self.check(distance)?;
        match self.cell(Spot {
            cell,
            part: R::ZERO,
        }) {
            Ok([(a, _), (b, _)]) => Ok(Some([a, b])),
            Err(Reason::Infeasible) => Ok(None),
            Err(reason) => Err(reason),
        }
    }

    fn check(&self, distance: R) -> Result<(), Reason> {
        if distance == self.distance {
            Ok(())
        } else {
            Err(if distance.is_finite() {
                Reason::OutOfTable
            } else {
                Reason::SensorInvalid
            })
        }
    }

    /// Value and slope at both ends of an open cell.
    #[inline]
    fn cell(&self, i: Spot<R>) -> Result<[(R, R); 2], Reason> {
        match self.open.get(i.cell) {
            Some(1) => {}
            Some(_) => return Err(Reason::Infeasible),
            None => return Err(Reason::OutOfTable),
        }
        let at = |k: usize| {
            self.nodes
                .get(k)
                .map(|[value, slope]| (*value, *slope))
                .ok_or(Reason::OutOfTable)
        };
        Ok([at(i.cell)?, at(i.cell.wrapping_add(1))?])
    }
}
