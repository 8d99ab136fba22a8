//! The flight of a jump, of whatever model.

use saltus_ballistic::{Disc, DragFlight, Flight, FlightError, Obstacle, SampledFlight};
use saltus_numeric::Single;

/// The flight of the wheel's centre from lift-off, where t = 0.
#[derive(Clone, Debug, PartialEq)]
pub enum JumpFlight<S = f64> {
    /// By its formula, as the planar model flies.
    Exact(DragFlight<S>),
    /// Through samples of a simulation, or of a corrected flight.
    Sampled(SampledFlight<S>),
}

use JumpFlight::{Exact, Sampled};

/// The same of either flight.
macro_rules! either {
    ($of:expr, $flight:ident => $answer:expr) => {
        match $of {
            Exact($flight) => $answer,
            Sampled($flight) => $answer,
        }
    };
}

impl<S: Single> JumpFlight<S> {
    /// Position (m) and velocity (m/s) of the wheel's centre at time `t` (s) after lift-off.
    pub fn motion(&self, t: S) -> [[S; 2]; 2] {
        either!(self, flight => flight.motion(t))
    }

    /// Greatest height (m) of the wheel's centre from lift-off on.
    pub fn apex_height(&self) -> S {
        either!(self, flight => flight.apex_height())
    }

    /// Time (s) from lift-off until the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// [`FlightError`] where it does not.
    pub fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        either!(self, flight => flight.time_to_height(height))
    }

    /// Forward position (m) at which the wheel's centre comes down to `height` (m).
    ///
    /// # Errors
    /// [`FlightError`] where it does not.
    pub fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        either!(self, flight => flight.range_to_height(height))
    }

    /// Least clearance (m) of `disc` over `obstacle` from time `from` to `to` (s) after lift-off.
    ///
    /// # Errors
    /// [`FlightError`] for a span that is none, or a flight that is none.
    pub fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<S, FlightError> {
        either!(self, flight => flight.clearance(disc, obstacle, from, to))
    }

    /// The same flight from a place `by` (m) farther along.
    #[must_use]
    pub fn shifted(&self, by: S) -> Self {
        match self {
            Exact(flight) => Exact(flight.shifted(by)),
            Sampled(flight) => Sampled(flight.shifted(by)),
        }
    }

    /// Whether it is a parabola under the robot's gravity.
    pub fn is_parabola(&self) -> bool {
        matches!(self, Exact(flight) if flight.drag.value() == 0.0)
    }

    /// A parabola near it, for rough looks: of the same lift-off, and the same apex or, where air
    /// drags, a higher one.
    pub fn parabola(&self) -> Flight<f64> {
        either!(self, flight => flight.parabola())
    }

    /// Distance (m) that the wheel's centre keeps until it is down at `height` (m) from the upper
    /// corner (m) of a wall without thickness; negative where it passes below the corner. None
    /// where there is no closed form: [`clearance`](JumpFlight::clearance) has one.
    pub fn over_corner(&self, corner: [f64; 2], height: S) -> Option<S> {
        match self {
            Exact(flight) => flight.over_corner(corner, height),
            Sampled(_) => None,
        }
    }
}
