//! A planner for tables that hold on another robot.

use saltus_lagrangian::Launch;
use saltus_planner::{Corrected, Correction, Planner};
use saltus_robot::Robot;

use super::layout::{Flown, Layout};
use super::request::{ExportError, Request, spread};
use super::tables::check;
use crate::on_plant::{OnPlant, for_launches, planar};

/// Launches along either side of the lift-off map, at which the plant may be flown.
const ALONG: usize = 25;

/// How far the plant's tables may go beyond those of the planar model: a part of the rates, firing
/// angles (rad), and landings (m) beyond the distances asked for. A jump that goes much farther has
/// another course, such as a leg that leaves the ground early, and would spoil what is learnt.
const MORE_RATE: f64 = 0.02;
const MORE_ANGLE: f64 = 0.05;
const MORE_DISTANCE: f64 = 0.05;

/// A planner for `robot` whose jumps, over all launches that the tables of `request` are about, are
/// those of the plant; and how it was corrected.
///
/// # Errors
/// As [`Tables::new`](super::Tables::new).
pub fn planner(
    robot: Robot,
    plant: &OnPlant,
    request: &Request,
) -> Result<(Planner<Corrected>, Correction), ExportError> {
    let flat = planar(robot.clone());
    check(&flat, request)?;
    let layout = Layout::new::<f64>(&flat, request)?;
    let flown = Flown {
        planner: &flat,
        start: layout.start,
        valve_open: request.valve_open,
    };
    let ((slow, fast, _), (back, forth)) = (layout.rates, layout.angles);
    let rates = spread((slow * (1.0 - MORE_RATE), fast * (1.0 + MORE_RATE), ALONG));
    let angles = spread((back - MORE_ANGLE, forth + MORE_ANGLE, ALONG));
    let height = request.landing_height(&flat);
    let (near, far, _) = request.distances;
    let is_near = |landing: &f64| (near - MORE_DISTANCE..=far + MORE_DISTANCE).contains(landing);
    let mut launches: Vec<Launch> = Vec::new();
    for (rate, angle) in rates
        .iter()
        .flat_map(|rate| angles.iter().map(move |angle| (*rate, *angle)))
    {
        let launch = flown.launch(rate, angle);
        let landing = flat.jump(&launch)?.distance(height);
        launches.extend(landing.filter(is_near).map(|_| launch));
    }
    Ok(for_launches(robot, plant, &launches, height)?)
}
