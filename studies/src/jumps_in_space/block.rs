//! A box that lies across the way of a robot, and is wider than it.

use saltus_gait::{GaitError, Obstacle};
use saltus_robot::Robot;
use saltus_sim_check::{Rig, Sim, Surface, Vec3};

use super::hull::{self, Flat};
use crate::require;

/// Half its width (m).
const WIDE: f64 = 10.0;

/// Refuses a box that cannot be, or that would be where `robot` stands.
pub(super) fn check(obstacle: &Obstacle, robot: &Robot) -> Result<(), GaitError> {
    let sizes = [
        ("obstacle's height (m)", obstacle.height),
        ("obstacle's length (m)", obstacle.length),
    ];
    for (name, x) in sizes {
        require(x > 0.0 && x <= 10.0, name, x, "above 0, at most 10 m")?;
    }
    let (front, least) = (obstacle.front, robot.body.radius);
    let allowed = format!("from {least}, a leg's length, to 100 m: nearer it is around the robot");
    let sound = (least..=100.0).contains(&front);
    require(sound, "obstacle's front (m)", front, allowed)
}

/// What of it can be touched.
pub(super) fn surface(obstacle: &Obstacle) -> Surface {
    Surface::Block {
        low: Vec3::new(obstacle.front, -WIDE, 0.0),
        high: Vec3::new(back(obstacle), WIDE, obstacle.height),
    }
}

/// Where its back is (m).
pub(super) fn back(obstacle: &Obstacle) -> f64 {
    obstacle.front + obstacle.length
}

/// Whether a place `x` (m) along the way is on it.
pub(super) fn is_on(obstacle: &Obstacle, x: f64) -> bool {
    (obstacle.front..=back(obstacle)).contains(&x)
}

/// Distance (m) between it and the hull of `places`, seen along it; negative where they overlap.
pub(super) fn gap(obstacle: &Obstacle, places: &[Flat]) -> f64 {
    let Obstacle { front, height, .. } = *obstacle;
    let back = back(obstacle);
    let block = [[front, 0.0], [back, 0.0], [back, height], [front, height]];
    hull::gap(&hull::hull(places), &block)
}

/// Distance (m) between it and the hull of the robot's feet, seen along the box; negative where they overlap, infinite where
/// the robot of `rig` is far from it.
pub(super) fn clearance(obstacle: &Obstacle, rig: &Rig, sim: &Sim<'_>) -> f64 {
    let (x, reach) = (sim.coordinates()[0], 2.0 * rig.radius);
    if x < obstacle.front - reach || x > back(obstacle) + reach {
        return f64::INFINITY;
    }
    let pose = sim.pose();
    let feet = &rig.mechanism.points[..rig.legs.len()];
    let place = |point: &saltus_sim_check::ContactPoint| {
        let center = pose.frames[point.body].point(&point.center);
        [center.x, center.z]
    };
    let places: Vec<Flat> = feet.iter().map(place).collect();
    gap(obstacle, &places) - feet[0].radius
}
