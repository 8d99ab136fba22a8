//! What a folder of telemetry says of its run: `experiment.toml` and `settings.toml`.

use std::fmt::Write as _;

use saltus::Robot;
use saltus::gait::{Logger, instruments};
use saltus::robot::Drive;

use super::report::Report;
use super::telemetry::{ROBOT, ROWS};
use crate::output::full;

/// The text of `experiment.toml`: what an operator knows who believes that `believed` runs.
pub(super) fn manifest(report: &Report<'_>, believed: &Robot) -> String {
    let robot = &report.setup.robot;
    let mut text = format!(
        "# {}\nkind = \"run\"\nrobot = \"{ROBOT}\"\n",
        report.title().replace(['\n', '\r'], " ")
    );
    let columns = Logger::new(robot).columns();
    let (mut noise, mut resolution) = (String::new(), String::new());
    for column in &columns {
        let (sigma, count) = Logger::errors(robot, column);
        for (lines, size) in [(&mut noise, sigma), (&mut resolution, count)] {
            if let Some(size) = size {
                // Writing to a string does not fail.
                let _ = writeln!(lines, "{column} = {}", float(size));
            }
        }
    }
    for (table, lines) in [("noise", noise), ("resolution", resolution)] {
        if !lines.is_empty() {
            let _ = write!(text, "[{table}]\n{lines}");
        }
    }
    let _ = write!(text, "[[run]]\nfile = \"{ROWS}\"\n");
    if let Drive::Pneumatic(cylinder) = &believed.leg.drive {
        let supply = float(cylinder.supply.0);
        let _ = writeln!(text, "supply_pressure_gauge_pa = {supply}");
    }
    text
}

/// The text of `settings.toml`: how the run was set, and the size of each count of `cycles.csv`.
pub(super) fn settings(report: &Report<'_>) -> String {
    let setup = report.setup;
    let sensors = setup.sensors();
    let one = instruments(&sensors);
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut text = String::new();
    let mut key = |name: &str, value: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name} = {value}");
    };
    key("gait", quoted(&report.run.gait));
    key("backwards", (!setup.forwards).to_string());
    key("zone_rad", float(setup.zone));
    let taps: Vec<String> = setup.taps.iter().map(|tap| float(*tap)).collect();
    key("taps", format!("[{}]", taps.join(", ")));
    key("period_s", float(sensors.period));
    key("seed", setup.seed.to_string());
    let disturbed = report
        .run
        .plane
        .disturb
        .iter()
        .map(|typed| quoted(&typed.text));
    let disturbed: Vec<String> = disturbed.collect();
    key("disturbances", format!("[{}]", disturbed.join(", ")));
    key("[one_count]\nwheel_encoder_rad", float(one.wheel));
    key("radius_encoder_rad", float(one.radius));
    key("pivot_encoder_rad", float(one.pivot));
    key("fine_gyro_rad_s", float(one.fine_gyro));
    key("coarse_gyro_rad_s", float(one.coarse_gyro));
    key("fine_accelerometer_m_s2", float(one.fine_accelerometer));
    let ratio = sensors.coarse_accelerometer_range / sensors.fine_accelerometer_range;
    key(
        "coarse_accelerometer_m_s2",
        float(one.fine_accelerometer * ratio),
    );
    text
}

/// A number as TOML has one that is no whole one.
fn float(x: f64) -> String {
    let text = full(x);
    if text.contains(['.', 'e']) {
        text
    } else {
        text + ".0"
    }
}
