//! The flight of a jump, of whatever model.

use saltus_ballistic::{
    Clearance, Disc, DragFlight, Flight, FlightError, Obstacle, SampledFlight, Trajectory,
};
use saltus_numeric::Single;

/// The flight of a jump.
#[derive(Clone, Debug, PartialEq)]
pub enum JumpFlight<S = f64> {
    /// By its formula, as the planar model flies.
    Exact(DragFlight<S>),
    /// Through samples of a simulation, or of a corrected flight.
    Sampled(SampledFlight<S>),
}

use JumpFlight::{Exact, Sampled};

impl<S: Single> Trajectory<S> for JumpFlight<S> {
    fn motion(&self, t: S) -> [[S; 2]; 2] {
        match self {
            Exact(flight) => Trajectory::motion(flight, t),
            Sampled(flight) => flight.motion(t),
        }
    }

    fn apex_height(&self) -> S {
        match self {
            Exact(flight) => flight.apex_height(),
            Sampled(flight) => flight.apex_height(),
        }
    }

    fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        match self {
            Exact(flight) => flight.time_to_height(height),
            Sampled(flight) => flight.time_to_height(height),
        }
    }

    fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        match self {
            Exact(flight) => flight.range_to_height(height),
            Sampled(flight) => Trajectory::range_to_height(flight, height),
        }
    }

    fn clearance(
        &self,
        disc: &Disc<S>,
        obstacle: &Obstacle,
        from: S,
        to: S,
    ) -> Result<Clearance<S>, FlightError> {
        match self {
            Exact(flight) => flight.clearance(disc, obstacle, from, to),
            Sampled(flight) => flight.clearance(disc, obstacle, from, to),
        }
    }

    fn shifted(&self, by: S) -> Self {
        match self {
            Exact(flight) => Exact(flight.shifted(by)),
            Sampled(flight) => Sampled(flight.shifted(by)),
        }
    }

    fn is_parabola(&self) -> bool {
        match self {
            Exact(flight) => flight.is_parabola(),
            Sampled(flight) => flight.is_parabola(),
        }
    }

    fn parabola(&self) -> Flight<f64> {
        match self {
            Exact(flight) => flight.parabola(),
            Sampled(flight) => flight.parabola(),
        }
    }

    fn over_corner(&self, corner: [f64; 2], height: S) -> Option<S> {
        match self {
            Exact(flight) => flight.over_corner(corner, height),
            Sampled(flight) => flight.over_corner(corner, height),
        }
    }
}
