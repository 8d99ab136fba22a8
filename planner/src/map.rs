//! Feasibility maps: what a robot can do, over approach rate and firing angle.

use saltus_lagrangian::{Launch, Outcome, StanceError};
use saltus_numeric::parallel::in_chunks;

use crate::model::JumpModel;
use crate::planner::Planner;
use crate::table::TableError;

/// Launches that are computed side by side.
const LAUNCHES: usize = 256;

/// What a map asks for.
#[derive(Clone, Debug)]
pub struct MapRequest {
    /// Approach rates ω (rad/s).
    pub rates: Vec<f64>,
    /// Firing angles α_f (rad).
    pub firing_angles: Vec<f64>,
    /// Valve opening time t_v (s).
    pub valve_open: f64,
    /// Lean at the start (rad); none: the stance starts at its firing angle.
    pub start_lean: Option<f64>,
    /// Height (m) of the wheel's centre at the landing.
    pub landing_height: f64,
    /// Whether to give the friction that each stance needs, which takes some ten times as long.
    pub friction: bool,
    /// Threads to work with, ≥ 1. The result does not depend on it.
    pub threads: usize,
}

/// What is reachable: one spot for each approach rate and, within, each firing angle.
#[derive(Clone, Debug)]
pub struct Map {
    /// The spots, firing angles within rates.
    pub spots: Vec<Spot>,
}

/// One launch and what comes of it.
#[derive(Clone, Debug)]
pub struct Spot {
    /// The launch.
    pub launch: Launch,
    /// What comes of it.
    pub result: Result<SpotResult, StanceError>,
}

/// What comes of a launch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotResult {
    /// How the stance ends.
    pub outcome: Outcome,
    /// Distance (m) from the foot to the landing; none without one.
    pub distance: Option<f64>,
    /// Greatest height (m); none without a flight.
    pub apex: Option<f64>,
    /// The friction coefficient that keeps the foot still, infinite where the foot would leave the
    /// ground; none if not asked for.
    pub friction_needed: Option<f64>,
}

impl Planner<dyn JumpModel> {
    /// The map of `request`.
    ///
    /// # Errors
    /// [`TableError`] if an axis is empty or there are no threads; a single launch outside its
    /// domain, or that cannot be computed, has its error at its spot.
    pub fn map(&self, request: &MapRequest) -> Result<Map, TableError> {
        for (name, axis) in [
            ("approach rates (rad/s)", &request.rates),
            ("firing angles (rad)", &request.firing_angles),
        ] {
            if axis.is_empty() {
                return Err(TableError::Empty { name });
            }
        }
        if request.threads == 0 {
            return Err(TableError::Input {
                name: "threads",
                value: 0.0,
                allowed: "at least 1",
            });
        }
        let launches: Vec<Launch> = request
            .rates
            .iter()
            .flat_map(|&rate| {
                request
                    .firing_angles
                    .iter()
                    .map(move |&firing_angle| Launch {
                        rate,
                        lean: request.start_lean.unwrap_or(firing_angle),
                        firing_angle,
                        valve_open: request.valve_open,
                    })
            })
            .collect();
        let parts = in_chunks(&launches, LAUNCHES, request.threads, |launches| {
            self.spots(request, launches)
        });
        Ok(Map {
            spots: parts.into_iter().flatten().collect(),
        })
    }

    fn spots(&self, request: &MapRequest, launches: &[Launch]) -> Vec<Spot> {
        let needed = |launch: &Launch| Some(self.model().traced(launch).ok()?.friction_needed);
        self.jumps(launches)
            .into_iter()
            .zip(launches)
            .map(|(jump, launch)| Spot {
                launch: *launch,
                result: jump.map(|jump| SpotResult {
                    outcome: jump.stance.outcome,
                    distance: jump.distance(request.landing_height),
                    apex: jump.apex(),
                    friction_needed: request.friction.then(|| needed(launch)).flatten(),
                }),
            })
            .collect()
    }
}
