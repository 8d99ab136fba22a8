//! Flight without air: the parabola and what follows from it in closed form.

use saltus_numeric::{Scalar, Single};

use crate::FlightError;
use crate::polynomial::Polynomial;

/// A flight in vacuum, given by the state of the wheel's centre at lift-off, where t = 0.
///
/// ```
/// use saltus_ballistic::{Flight, FlightError};
/// let flight = Flight { x: 0.0, y: 0.3, vx: 2.0, vy: 2.8, gravity: 9.80665 };
/// assert!((flight.apex_height() - 0.69973).abs() < 1e-5);
/// assert!((flight.range_to_height(0.24)? - 1.18344).abs() < 1e-5);
/// let error = flight.time_to_height(0.9).unwrap_err();
/// assert!(error.to_string().starts_with("landing height 0.9 m is above the apex at 0.699"));
/// # Ok::<(), FlightError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flight<S> {
    /// Forward position at lift-off (m).
    pub x: S,
    /// Height at lift-off (m).
    pub y: S,
    /// Forward speed at lift-off (m/s).
    pub vx: S,
    /// Vertical speed at lift-off, upward positive (m/s).
    pub vy: S,
    /// Gravity g (m/s²), ≥ 0.
    pub gravity: S,
}

impl<S: Scalar> Flight<S> {
    /// Position [x, y] (m) of the wheel's centre at time `t` (s) after lift-off.
    #[inline]
    pub fn position(&self, t: S) -> [S; 2] {
        let mean_vy = (self.gravity * S::of(-0.5)).mul_add(t, self.vy);
        [self.vx.mul_add(t, self.x), mean_vy.mul_add(t, self.y)]
    }

    /// Velocity [v_x, v_y] (m/s) of the wheel's centre at time `t` (s) after lift-off.
    #[inline]
    pub fn velocity(&self, t: S) -> [S; 2] {
        [self.vx, (-self.gravity).mul_add(t, self.vy)]
    }

    /// Greatest height (m) of the wheel's centre from lift-off on: y + max(v_y, 0)²/(2g).
    ///
    /// Infinite where the wheel rises without gravity.
    ///
    /// Source: docs/model.md, phase 5, the apex.
    #[inline]
    pub fn apex_height(&self) -> S {
        let rise = || (self.vy * self.vy / (self.gravity + self.gravity)) + self.y;
        S::select(S::of(0.0).less(self.vy), rise, || self.y)
    }

    /// Time (s) from lift-off to the greatest height: max(v_y, 0)/g.
    ///
    /// Infinite where the wheel rises without gravity.
    #[inline]
    pub fn apex_time(&self) -> S {
        S::select(
            S::of(0.0).less(self.vy),
            || self.vy / self.gravity,
            || S::of(0.0),
        )
    }

    /// The later root t (s) of y + v_y t − g t²/2 = `height` (m), free of cancellation; not a
    /// number where the parabola does not reach that height.
    ///
    /// For lanes and hot loops: [`time_to_height`](Flight::time_to_height) is the same with its
    /// reasons. It may be negative: then the wheel passed that height before lift-off only.
    #[inline]
    pub fn descent_time(&self, height: S) -> S {
        let above = self.y - height;
        let twice_above = above + above;
        let speed = self.vy.mul_add(self.vy, twice_above * self.gravity).sqrt();
        S::select(
            self.vy.less(S::of(0.0)),
            || twice_above / (speed - self.vy),
            || (speed + self.vy) / self.gravity,
        )
    }
}

impl<S: Single> Flight<S> {
    /// Time (s) from lift-off until the wheel's centre comes down to `height` (m).
    ///
    /// The later root of y + v_y t − g t²/2 = `height`.
    ///
    /// Source: docs/model.md, phase 5; thesis §5.2.2.
    ///
    /// # Errors
    /// [`FlightError::AboveApex`] if that height is never reached, [`FlightError::NoGravity`] if
    /// nothing brings the wheel down to it, [`FlightError::NotFinite`] or
    /// [`FlightError::HeightNotFinite`] if a number is infinite or not one.
    #[inline]
    pub fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        let time = self.descent_time(height);
        // False where the time is not a number, too.
        if time.value() >= 0.0 && time.value() < f64::INFINITY {
            Ok(time)
        } else {
            self.never_at(height)
        }
    }

    /// Forward position (m) at which the wheel's centre comes down to `height` (m).
    ///
    /// Source: docs/model.md, phase 5, the distance to a landing height.
    ///
    /// # Errors
    /// As [`time_to_height`](Flight::time_to_height).
    #[inline]
    pub fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        Ok(self.vx.mul_add(self.time_to_height(height)?, self.x))
    }

    /// Least distance (m) from the wheel's centre to `point` (m) from time `from` to `to` (s) after
    /// lift-off, with its exact derivatives: a corner that the wheel passes, at a tenth of the
    /// price of [`clearance`](Flight::clearance).
    ///
    /// The squared distance is a quartic in time; its minima are among the roots of its derivative
    /// and the ends.
    pub fn distance_to_point(&self, point: [f64; 2], from: S, to: S) -> S {
        let Flight {
            x,
            y,
            vx,
            vy,
            gravity,
        } = self.values();
        let (x, y) = (x - point[0], y - point[1]);
        let slope = Polynomial([
            x * vx + y * vy,
            vx * vx + vy * vy - gravity * y,
            -1.5 * gravity * vy,
            0.5 * gravity * gravity,
            0.0,
        ]);
        let squared = |t: S| {
            let [x, y] = self.position(t);
            let (x, y) = (x - S::of(point[0]), y - S::of(point[1]));
            x * x + y * y
        };
        let roots = slope.roots(from.value(), to.value());
        // At an inner minimum the time counts as constant: the distance does not change with it.
        let inner = roots.as_slice().iter().map(|&t| S::of(t));
        let nearer = |a: S, b: S| if b.value() < a.value() { b } else { a };
        inner
            .map(&squared)
            .fold(nearer(squared(from), squared(to)), nearer)
            .sqrt()
    }

    /// The flight without its derivatives.
    pub(crate) fn values(&self) -> Flight<f64> {
        Flight {
            x: self.x.value(),
            y: self.y.value(),
            vx: self.vx.value(),
            vy: self.vy.value(),
            gravity: self.gravity.value(),
        }
    }

    /// Refuses a state that is infinite or not a number.
    pub(crate) fn check_finite(&self) -> Result<(), FlightError> {
        let Flight {
            x,
            y,
            vx,
            vy,
            gravity,
        } = self.values();
        let finite = [x, y, vx, vy, gravity]
            .iter()
            .all(|number| number.is_finite());
        if finite {
            Ok(())
        } else {
            Err(FlightError::NotFinite {
                x,
                y,
                vx,
                vy,
                gravity,
            })
        }
    }

    /// Why the wheel does not come down to `height`; the apex time if it does, and only round-off
    /// says no.
    #[cold]
    fn never_at(&self, height: S) -> Result<S, FlightError> {
        self.check_finite()?;
        let (height, apex) = (height.value(), self.apex_height().value());
        if !height.is_finite() {
            Err(FlightError::HeightNotFinite { height })
        } else if height > apex {
            Err(FlightError::AboveApex { height, apex })
        } else if self.gravity.value() == 0.0 {
            Err(FlightError::NoGravity {
                height,
                speed: self.vy.value(),
            })
        } else {
            Ok(self.apex_time())
        }
    }
}

#[cfg(test)]
mod tests;
