//! A run as a page to watch.

use saltus::gait::Ending;
use serde_json::json;

use super::film::Film;
use super::report::{Report, joined};
use crate::animation::{run_page, sizes};

/// The page.
pub(super) fn html(report: &Report<'_>, film: Film) -> String {
    let robot = &report.setup.robot;
    let [hub, rod] = sizes(robot);
    let scene = json!({
        "robot": robot.name,
        "title": report.title(),
        "ended": report.ending(),
        "ran": report.summary.ending == Ending::Ran,
        "wheel_radius_m": robot.body.radius,
        "hub_radius_m": hub,
        "rod_length_m": rod,
        "stroke_m": robot.leg.stroke,
        "slope_rad": robot.ground.slope,
        "ambient_pa": robot.environment.ambient.0,
        "has_gas": robot.leg.cylinder().is_some(),
        "zone_rad": report.setup.zone,
        "forwards": report.setup.forwards,
        "disturbances": report.disturbances.iter().map(|d| d.text.as_str()).collect::<Vec<_>>(),
    });
    run_page(joined([scene, film.value()]))
}
