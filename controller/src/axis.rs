//! Evenly spaced nodes.

use crate::{Real, Reason};

/// Evenly spaced nodes, at least two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis<R> {
    /// The first node.
    pub first: R,
    /// The last node, above the first.
    pub last: R,
    /// Cells in a unit: one over the nodes' spacing.
    pub per_unit: R,
    /// How many nodes, ≥ 2.
    pub count: usize,
}

/// Where a value lies between nodes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spot<R> {
    /// The node before it.
    pub(crate) cell: usize,
    /// How far it is from there to the next, 0 to 1.
    pub(crate) part: R,
}

impl<R: Real> Axis<R> {
    /// `count` nodes from `first` to `last`.
    pub fn new(first: R, last: R, count: usize) -> Axis<R> {
        Axis {
            first,
            last,
            per_unit: R::of_index(count.saturating_sub(1)) / (last - first),
            count,
        }
    }

    /// The node `index`.
    #[inline]
    pub fn node(&self, index: usize) -> R {
        if index.wrapping_add(1) == self.count {
            self.last
        } else {
            self.first + R::of_index(index) / self.per_unit
        }
    }

    /// Where `x` lies.
    ///
    /// # Errors
    /// [`Reason::SensorInvalid`] for what is no finite number, [`Reason::OutOfTable`] beyond the
    /// ends.
    #[inline]
    pub(crate) fn locate(&self, x: R) -> Result<Spot<R>, Reason> {
        if !x.within(self.first, self.last) || self.count < 2 {
            return Err(if x.is_finite() {
                Reason::OutOfTable
            } else {
                Reason::SensorInvalid
            });
        }
        let (cell, part) = ((x - self.first) * self.per_unit).split(self.count - 2);
        Ok(Spot { cell, part })
    }
}

/// Weights of the cubic at `t`, from 0 to 1 through a cell: of the difference of the values at its
/// ends, and of the scaled slopes there.
#[inline]
pub(crate) fn hermite<R: Real>(t: R) -> [R; 3] {
    let (s, rest) = (t * t, R::ONE - t);
    let rise = s * (R::of(3.0) - (t + t));
    [rise, (t * rest) * rest, -(s * rest)]
}

/// As [`hermite`], for the slope by t.
#[inline]
pub(crate) fn hermite_slope<R: Real>(t: R) -> [R; 3] {
    let three = R::of(3.0);
    let rise = (t - t * t) * R::of(6.0);
    let end = t * (three * t - R::of(2.0));
    [rise, (end - (t + t)) + R::ONE, end]
}

/// The cubic between the values `low` and `high`, each with its scaled slope, by the weights of
/// [`hermite`].
#[inline]
pub(crate) fn cubic<R: Real>([rise, first, second]: [R; 3], low: (R, R), high: (R, R)) -> R {
    (low.0 + rise * (high.0 - low.0)) + (first * low.1 + second * high.1)
}

/// Its slope by t, by the weights of [`hermite_slope`].
#[inline]
pub(crate) fn cubic_slope<R: Real>([rise, first, second]: [R; 3], low: (R, R), high: (R, R)) -> R {
    rise * (high.0 - low.0) + (first * low.1 + second * high.1)
}
