//! Flight through air: the drag −c |v| v as a named term on top of the parabola.
//!
//! There is no closed form. The path is integrated by DOP853 over time, and an event (the apex, a
//! height) is located to round-off as a root of the step that contains it: the step's length is
//! what is solved for, so nothing is interpolated. Height as the independent variable (Hénon's
//! trick) would do the same but for the apex, where it stands still.

mod track;

use saltus_numeric::Single;

use crate::clearance::{check_span, clearance};
use crate::{Disc, Flight, FlightError, Obstacle};
use track::{Node, Track};

/// A flight with the drag −c |v| v per mass.
///
/// Without drag (c = 0) every answer is that of the [`Flight`] in vacuum, bit for bit. Derivatives
/// along c are then missing; a small c > 0 has them.
///
/// ```
/// use saltus_ballistic::{DragFlight, Flight, FlightError};
/// let vacuum = Flight { x: 0.0, y: 0.3, vx: 2.0, vy: 2.8, gravity: 9.80665 };
/// let flight = DragFlight { vacuum, drag: 0.02 };
/// assert!(flight.range_to_height(0.24)? < vacuum.range_to_height(0.24)?);
/// assert_eq!(DragFlight { vacuum, drag: 0.0 }.apex_height(), vacuum.apex_height());
/// # Ok::<(), FlightError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DragFlight<S> {
    /// The same lift-off without air.
    pub vacuum: Flight<S>,
    /// Drag per mass c (1/m), ≥ 0; 0 is off.
    pub drag: S,
}

impl<S: Single> DragFlight<S> {
    /// Position [x, y] (m) of the wheel's centre at time `t` (s) after lift-off; not a number for t
    /// < 0 if there is drag.
    pub fn position(&self, t: S) -> [S; 2] {
        self.motion(t)[0]
    }

    /// Velocity [v_x, v_y] (m/s) of the wheel's centre at time `t` (s) after lift-off; not a number
    /// for t < 0 if there is drag.
    pub fn velocity(&self, t: S) -> [S; 2] {
        self.motion(t)[1]
    }

    /// Position and velocity, as [`position`](DragFlight::position) and
    /// [`velocity`](DragFlight::velocity).
    pub fn motion(&self, t: S) -> [[S; 2]; 2] {
        if self.is_vacuum() {
            [self.vacuum.position(t), self.vacuum.velocity(t)]
        } else {
            let node = Track::new(self, t.value()).node(t);
            [node.position(), node.velocity()]
        }
    }

    /// The same flight from a place `by` (m) farther along.
    #[must_use]
    pub fn shifted(&self, by: S) -> Self {
        let mut along = *self;
        along.vacuum.x = along.vacuum.x + by;
        along
    }

    /// The flight without air and without derivatives.
    pub fn parabola(&self) -> Flight<f64> {
        self.vacuum.values()
    }

    /// Distance (m) that the wheel's centre keeps until it is down at `height` (m) from the upper
    /// corner (m) of a wall without thickness; negative where it passes below the corner. None
    /// with drag.
    pub fn over_corner(&self, corner: [f64; 2], height: S) -> Option<S> {
        if !self.is_vacuum() {
            return None;
        }
        let vacuum = &self.vacuum;
        let landing = vacuum.time_to_height(height).ok()?;
        let distance = vacuum.distance_to_point(corner, S::of(0.0), landing);
        let passing = (corner[0] - vacuum.x.value()) / vacuum.vx.value();
        let is_below = (0.0..=landing.value()).contains(&passing)
            && vacuum.position(S::of(passing))[1].value() < corner[1];
        Some(if is_below { -distance } else { distance })
    }

    /// Greatest height (m) of the wheel's centre from lift-off on; infinite where it rises without
    /// gravity.
    pub fn apex_height(&self) -> S {
        self.apex()
            .map_or_else(|| self.vacuum.apex_height(), |apex| apex.position()[1])
    }

    /// Time (s) from lift-off to the greatest height; infinite where the wheel rises without
    /// gravity.
    pub fn apex_time(&self) -> S {
        self.apex()
            .map_or_else(|| self.vacuum.apex_time(), |apex| apex.time)
    }

    /// Time (s) from lift-off until the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// As [`Flight::time_to_height`]; [`FlightError::BadDrag`].
    pub fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        if self.is_vacuum() {
            self.vacuum.time_to_height(height)
        } else {
            Ok(self.descent(height)?.time)
        }
    }

    /// Forward position (m) at which the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// As [`time_to_height`](DragFlight::time_to_height).
    pub fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        if self.is_vacuum() {
            self.vacuum.range_to_height(height)
        } else {
            Ok(self.descent(height)?.position()[0])
        }
    }

    /// Least clearance (m) of `disc` over `obstacle` from time `from` to `to` (s) after lift-off, as
    /// [`Flight::clearance`].
    ///
    /// Accurate to 1e-8 m: to that the path is approximated by parabolas in the search for minima.
    /// Each is then settled on the path itself, so that only two minima closer than that can be
    /// taken for each other, or one shallower be missed.
    ///
    /// # Errors
    /// As [`Flight::clearance`]; [`FlightError::BadDrag`], [`FlightError::BeforeLiftOff`].
    pub fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<S, FlightError> {
        if self.is_vacuum() {
            return self.vacuum.clearance(disc, obstacle, from, to);
        }
        self.check()?;
        check_span(from, to)?;
        if from.value() < 0.0 {
            return Err(FlightError::BeforeLiftOff { time: from.value() });
        }
        let track = Track::new(self, to.value());
        Ok(clearance(&track, disc, obstacle, [from, to]))
    }

    /// Points (t, x, y) of the path at `count` evenly spaced times from `from` to `to` (s), both
    /// included: for plots.
    pub fn samples(
        &self,
        from: f64,
        to: f64,
        count: usize,
    ) -> impl Iterator<Item = (f64, f64, f64)> {
        let flight = DragFlight {
            vacuum: self.vacuum.values(),
            drag: self.drag.value(),
        };
        let track = (!self.is_vacuum()).then(|| Track::new(&flight, to));
        times(from, to, count).map(move |t| {
            let [x, y] = track
                .as_ref()
                .map_or_else(|| flight.position(t), |track| track.node(t).position());
            (t, x, y)
        })
    }

    /// Whether the drag is off.
    fn is_vacuum(&self) -> bool {
        self.drag.value() == 0.0
    }

    /// Refuses numbers that no flight has.
    fn check(&self) -> Result<(), FlightError> {
        let drag = self.drag.value();
        if drag >= 0.0 && drag.is_finite() {
            self.vacuum.check_finite()
        } else {
            Err(FlightError::BadDrag { drag })
        }
    }

    /// The apex, if drag has a part in it: none where the wheel does not rise, or rises without
    /// gravity.
    fn apex(&self) -> Option<Node<S>> {
        let rises = self.vacuum.vy.value() > 0.0 && self.vacuum.gravity.value() > 0.0;
        (rises && !self.is_vacuum()).then(|| {
            self.first_below(self.lift_off(), |node| {
                [node.velocity()[1], node.acceleration(self)[1]]
            })
        })
    }

    /// The state in which the wheel's centre comes down to `height`.
    fn descent(&self, height: S) -> Result<Node<S>, FlightError> {
        self.check()?;
        let Flight {
            x,
            y,
            vx,
            vy,
            gravity,
        } = self.vacuum.values();
        if !height.value().is_finite() {
            return Err(FlightError::HeightNotFinite {
                height: height.value(),
            });
        }
        let top = self.apex().unwrap_or_else(|| self.lift_off());
        let apex = self.apex_height().value();
        if height.value() > apex {
            return Err(FlightError::AboveApex {
                height: height.value(),
                apex,
            });
        }
        if gravity == 0.0 && vy >= 0.0 {
            return Err(FlightError::NoGravity {
                height: height.value(),
                speed: vy,
            });
        }
        let node = self.first_below(top, |node| {
            [node.position()[1] - height, node.velocity()[1]]
        });
        // Speeds near the greatest numbers overflow.
        let finite = node.time.value().is_finite();
        if finite {
            Ok(node)
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
}

/// `count` evenly spaced times from `from` to `to`, both included.
fn times(from: f64, to: f64, count: usize) -> impl Iterator<Item = f64> {
    let last = count.saturating_sub(1).max(1) as f64;
    (0..count).map(move |i| {
        let share = i as f64 / last;
        from * (1.0 - share) + to * share
    })
}

#[cfg(test)]
mod tests;
