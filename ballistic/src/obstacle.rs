//! Obstacles: boxes with level and upright sides, and signed distances to them.

use saltus_numeric::{Scalar, Single};

use crate::FlightError;
use crate::path::Arc;
use crate::polynomial::Polynomial;
use crate::state::State;

/// A solid box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    low: [f64; 2],
    high: [f64; 2],
}

/// Part of a box that is nearest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Feature {
    /// The side that crosses this axis.
    Side {
        axis: usize,
        /// Where it crosses the axis (m).
        at: f64,
        /// 1 if the box is below, −1 if it is above.
        out: f64,
    },
    /// A corner (m).
    Corner([f64; 2]),
}

/// A signed distance to a feature and its change along a path.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap<S> {
    /// Distance (m), negative inside the box.
    pub(crate) value: S,
    /// Its derivative in time (m/s).
    pub(crate) rate: S,
    /// Its second derivative in time (m/s²).
    pub(crate) bend: S,
}

impl Obstacle {
    /// The box from `low` to `high`, its lower left and upper right corners [x, y] (m).
    ///
    /// # Errors
    /// [`FlightError::EmptyBox`] unless `low` < `high` in both coordinates, finite.
    pub fn block(low: [f64; 2], high: [f64; 2]) -> Result<Self, FlightError> {
        let finite = [low, high]
            .as_flattened()
            .iter()
            .all(|number| number.is_finite());
        if finite && low[0] < high[0] && low[1] < high[1] {
            Ok(Obstacle { low, high })
        } else {
            Err(FlightError::EmptyBox { low, high })
        }
    }

    /// Forward position (m) of the side that is furthest ahead.
    pub fn back(&self) -> f64 {
        self.high[0]
    }

    /// Bottom, back, top and front.
    pub(crate) fn sides(&self) -> [Feature; 4] {
        let side = |axis: usize, out: f64| Feature::Side {
            axis,
            at: if out > 0.0 {
                self.high[axis]
            } else {
                self.low[axis]
            },
            out,
        };
        [side(1, -1.0), side(0, 1.0), side(1, 1.0), side(0, -1.0)]
    }

    pub(crate) fn corners(&self) -> [Feature; 4] {
        let ([left, bottom], [right, top]) = (self.low, self.high);
        [[left, bottom], [right, bottom], [right, top], [left, top]].map(Feature::Corner)
    }

    /// The feature nearest to `point` and the signed distance to it (m).
    pub(crate) fn nearest(&self, point: [f64; 2]) -> (Feature, f64) {
        // Of the two sides across an axis the nearer one; inside the box both are behind.
        let across = |axis: usize| {
            let (before, behind) = (self.low[axis] - point[axis], point[axis] - self.high[axis]);
            let (at, out, gap) = if before > behind {
                (self.low[axis], -1.0, before)
            } else {
                (self.high[axis], 1.0, behind)
            };
            (Feature::Side { axis, at, out }, at, gap)
        };
        let [(side, x, ahead), (level, y, above)] = [across(0), across(1)];
        if ahead > 0.0 && above > 0.0 {
            (Feature::Corner([x, y]), ahead.hypot(above))
        } else if ahead > above {
            (side, ahead)
        } else {
            (level, above)
        }
    }
}

impl Feature {
    /// The signed distance at a path's `state`; from a corner it is positive.
    pub(crate) fn gap<S: Single>(&self, state: &State<S>) -> Gap<S> {
        match *self {
            Feature::Side { axis, at, out } => {
                let out = S::of(out);
                Gap {
                    value: (state.position[axis] - S::of(at)) * out,
                    rate: state.velocity[axis] * out,
                    bend: state.acceleration[axis] * out,
                }
            }
            Feature::Corner(corner) => {
                let offset = [0, 1].map(|axis| state.position[axis] - S::of(corner[axis]));
                let value = product(offset, offset).sqrt();
                let rate = product(offset, state.velocity) / value;
                let squared = product(state.velocity, state.velocity);
                let bend = (squared + product(offset, state.acceleration) - rate * rate) / value;
                Gap { value, rate, bend }
            }
        }
    }

    /// Over an arc's own time: the signed distance to a side's line, the squared one to a corner.
    pub(crate) fn distance(&self, arc: &Arc) -> Polynomial {
        let seen =
            |axis: usize, from: f64| [arc.x, arc.y][axis] - Polynomial::quadratic(from, 0.0, 0.0);
        match *self {
            Feature::Side { axis, at, out } => seen(axis, at).scaled(out),
            Feature::Corner([x, y]) => {
                let (x, y) = (seen(0, x), seen(1, y));
                x * x + y * y
            }
        }
    }
}

/// a · b.
fn product<S: Scalar>(a: [S; 2], b: [S; 2]) -> S {
    a[0].mul_add(b[0], a[1] * b[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_without_an_inside_is_refused() {
        assert_eq!(
            Obstacle::block([0.0, 0.0], [1.0, 0.0])
                .unwrap_err()
                .to_string(),
            "a box from (0, 0) to (1, 0) m has no inside"
        );
    }

    #[test]
    fn signed_distances() {
        let square = Obstacle::block([0.0, 0.0], [2.0, 2.0]).unwrap();
        let check = |point: [f64; 2], expected: f64| {
            let gap = square.nearest(point).1;
            assert!((gap - expected).abs() < 1e-15, "{gap}, not {expected}");
        };
        check([5.0, 6.0], 5.0);
        check([-3.0, -4.0], 5.0);
        check([1.0, 3.0], 1.0);
        check([-0.5, 1.0], 0.5);
        check([1.0, 1.5], -0.5);
        check([0.25, 1.0], -0.25);
        check([2.0, 2.0], 0.0);
    }
}
