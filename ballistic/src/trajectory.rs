//! What a planner asks of a flight, whatever computes it.

use std::fmt::Debug;

use saltus_numeric::Single;

use crate::{Clearance, Disc, DragFlight, Flight, FlightError, Obstacle, SampledFlight};

/// A flight of the wheel's centre from lift-off, where t = 0: in closed form, through air, or as
/// another simulation gave it.
pub trait Trajectory<S: Single>: Clone + Debug + Send + Sync {
    /// Position (m) and velocity (m/s) of the wheel's centre at time `t` (s) after lift-off.
    fn motion(&self, t: S) -> [[S; 2]; 2];

    /// Greatest height (m) of the wheel's centre from lift-off on.
    fn apex_height(&self) -> S;

    /// Time (s) from lift-off until the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// [`FlightError`] where it does not.
    fn time_to_height(&self, height: S) -> Result<S, FlightError>;

    /// Forward position (m) at which the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// [`FlightError`] where it does not.
    fn range_to_height(&self, height: S) -> Result<S, FlightError>;

    /// Least clearance of `disc` over `obstacle` from time `from` to `to` (s) after lift-off.
    ///
    /// # Errors
    /// [`FlightError`] for a span that is none, or a flight that is none.
    fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<Clearance<S>, FlightError>;

    /// The same flight from a place `by` (m) farther along.
    #[must_use]
    fn shifted(&self, by: S) -> Self;

    /// Whether it is a parabola under the robot's gravity.
    fn is_parabola(&self) -> bool {
        false
    }

    /// A parabola near it, for rough looks: of the same lift-off, and the same apex or, where air
    /// drags, a higher one.
    fn parabola(&self) -> Flight<f64>;

    /// Distance (m) that the wheel's centre keeps until it is down at `height` (m) from the upper
    /// corner (m) of a wall without thickness; negative where it passes below the corner. None
    /// where there is no closed form: [`clearance`](Trajectory::clearance) has one.
    fn over_corner(&self, _corner: [f64; 2], _height: S) -> Option<S> {
        None
    }
}

impl<S: Single> Trajectory<S> for DragFlight<S> {
    fn motion(&self, t: S) -> [[S; 2]; 2] {
        [self.position(t), self.velocity(t)]
    }

    fn apex_height(&self) -> S {
        self.apex_height()
    }

    fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        self.time_to_height(height)
    }

    fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        self.range_to_height(height)
    }

    fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<Clearance<S>, FlightError> {
        self.clearance(disc, obstacle, from, to)
    }

    fn shifted(&self, by: S) -> Self {
        let mut along = *self;
        along.vacuum.x = along.vacuum.x + by;
        along
    }

    fn is_parabola(&self) -> bool {
        self.drag.value() == 0.0
    }

    fn parabola(&self) -> Flight<f64> {
        self.vacuum.values()
    }

    fn over_corner(&self, corner: [f64; 2], height: S) -> Option<S> {
        if self.drag.value() != 0.0 {
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
}

impl<S: Single> Trajectory<S> for SampledFlight<S> {
    fn motion(&self, t: S) -> [[S; 2]; 2] {
        self.motion(t)
    }

    fn apex_height(&self) -> S {
        self.apex_height()
    }

    fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        self.time_to_height(height)
    }

    fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        Ok(self.position(self.time_to_height(height)?)[0])
    }

    fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<Clearance<S>, FlightError> {
        self.clearance(disc, obstacle, from, to)
    }

    fn shifted(&self, by: S) -> Self {
        self.shifted(by)
    }

    fn parabola(&self) -> Flight<f64> {
        self.parabola()
    }
}
