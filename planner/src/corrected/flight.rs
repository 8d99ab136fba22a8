//! A flight of the planar model, or one that was corrected.

use saltus_ballistic::{
    Clearance, Disc, DragFlight, Flight, FlightError, Obstacle, SampledFlight, Trajectory,
};
use saltus_numeric::Single;

/// The flight of a [`Corrected`](super::Corrected) model.
#[derive(Clone, Debug)]
pub enum CorrectedFlight<S> {
    /// Nothing corrects it: that of the planar model.
    Planar(DragFlight<S>),
    /// Corrected.
    Corrected(SampledFlight<S>),
}

use CorrectedFlight::{Corrected, Planar};

impl<S: Single> Trajectory<S> for CorrectedFlight<S> {
    fn motion(&self, t: S) -> [[S; 2]; 2] {
        match self {
            Planar(flight) => Trajectory::motion(flight, t),
            Corrected(flight) => flight.motion(t),
        }
    }

    fn apex_height(&self) -> S {
        match self {
            Planar(flight) => flight.apex_height(),
            Corrected(flight) => flight.apex_height(),
        }
    }

    fn time_to_height(&self, height: S) -> Result<S, FlightError> {
        match self {
            Planar(flight) => flight.time_to_height(height),
            Corrected(flight) => flight.time_to_height(height),
        }
    }

    fn range_to_height(&self, height: S) -> Result<S, FlightError> {
        match self {
            Planar(flight) => flight.range_to_height(height),
            Corrected(flight) => Trajectory::range_to_height(flight, height),
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
            Planar(flight) => flight.clearance(disc, obstacle, from, to),
            Corrected(flight) => flight.clearance(disc, obstacle, from, to),
        }
    }

    fn shifted(&self, by: S) -> Self {
        match self {
            Planar(flight) => Planar(flight.shifted(by)),
            Corrected(flight) => Corrected(flight.shifted(by)),
        }
    }

    fn is_parabola(&self) -> bool {
        match self {
            Planar(flight) => flight.is_parabola(),
            Corrected(flight) => flight.is_parabola(),
        }
    }

    fn parabola(&self) -> Flight<f64> {
        match self {
            Planar(flight) => flight.parabola(),
            Corrected(flight) => flight.parabola(),
        }
    }

    fn over_corner(&self, corner: [f64; 2], height: S) -> Option<S> {
        match self {
            Planar(flight) => flight.over_corner(corner, height),
            Corrected(flight) => flight.over_corner(corner, height),
        }
    }
}
