//! A run as a folder of measured data of kind `run`: `experiment.toml`, the robot as it is believed,
//! `run.csv` with what is measured; beside it every cycle, and how the run was set.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use saltus::Robot;
use saltus::gait::space::{Gait, Knows, Roll};
use saltus::gait::{Logger, instruments};
use saltus::robot::Drive;
use saltus::temporary::{self, Temporary};

use super::report::Report;
use super::rows::Rows;
use crate::error::CliError;
use crate::output::{Files, full};

const ROWS: &str = "run.csv";
const CYCLES: &str = "cycles.csv";
const SETTINGS: &str = "settings.toml";
const ROBOT: &str = "robot.toml";
const MANIFEST: &str = "experiment.toml";

/// A folder that is filled; it is as it was where the run does not come to its end.
#[derive(Debug)]
pub(super) struct Telemetry {
    folder: PathBuf,
    /// Whether it was made for this.
    is_new: bool,
    staged: Option<Temporary>,
    /// Every cycle, and what is measured in it.
    rows: Vec<Rows>,
}

impl Telemetry {
    /// Opens `folder`, new or empty, for rows under these headers.
    pub(super) fn open(
        folder: &Path,
        cycles: String,
        measured: String,
    ) -> Result<Telemetry, CliError> {
        let failed = |error| CliError::write(folder, error);
        let is_new = !folder.exists();
        fs::create_dir_all(folder).map_err(failed)?;
        let mut telemetry = Telemetry {
            folder: folder.into(),
            is_new,
            staged: None,
            rows: Vec::new(),
        };
        temporary::sweep(folder);
        if fs::read_dir(folder).map_err(failed)?.next().is_some() {
            let allowed = "a new or an empty folder";
            return Err(CliError::flag("--telemetry", folder.display(), allowed));
        }
        let staged = Temporary::folder_in(folder).map_err(failed)?;
        for (name, header) in [(CYCLES, cycles), (ROWS, measured)] {
            let file = staged.path().join(name);
            let rows = Rows::open("--telemetry", Some(&file), header)?;
            telemetry.rows.push(rows);
        }
        telemetry.staged = Some(staged);
        Ok(telemetry)
    }

    /// Adds the line of a cycle that `write` makes.
    pub(super) fn cycle(&mut self, write: impl FnOnce(&mut String)) {
        self.rows[0].line(write);
    }

    /// Adds what is measured at a time (s).
    pub(super) fn measured(&mut self, time: f64, values: &[f64]) {
        self.rows[1].measured(time, values);
    }

    /// Whether its files still take what comes.
    pub(super) fn is_open(&self) -> bool {
        self.rows.iter().all(Rows::is_open)
    }

    /// Puts all files in their place, the manifest last: without one, nothing reads the data. They name `robot`, which need not
    /// be the one that ran.
    pub(super) fn publish(
        mut self,
        robot: &Robot,
        settings: String,
        manifest: Option<String>,
    ) -> Result<(), CliError> {
        let Some(staged) = self.staged.take() else {
            return Ok(());
        };
        let mut files = Files::default();
        for rows in self.rows.drain(..) {
            if let Some(stream) = rows.finish()? {
                files.written(stream)?;
            }
        }
        let mut names = vec![ROWS, CYCLES];
        let texts = [(ROBOT, robot.to_toml()), (SETTINGS, settings)];
        let manifest = manifest.map(|text| (MANIFEST, text));
        for (name, text) in texts.into_iter().chain(manifest) {
            files.add("--telemetry", &staged.path().join(name), text.into_bytes());
            names.push(name);
        }
        files.write()?;
        for name in names {
            let place = self.folder.join(name);
            fs::rename(staged.path().join(name), &place)
                .map_err(|error| CliError::write(&place, error))?;
        }
        self.is_new = false;
        Ok(())
    }
}

impl Drop for Telemetry {
    fn drop(&mut self) {
        self.rows.clear();
        self.staged = None;
        if self.is_new {
            // Only an empty folder goes.
            let _ = fs::remove_dir(&self.folder);
        }
    }
}

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

/// The text of `settings.toml` of a robot in space: how the run was set.
pub(super) fn settings_in_space(setup: &Roll, gait: &str, seed: u64) -> String {
    let mut text = String::new();
    let mut key = |name: &str, value: String| {
        // Writing to a string does not fail.
        let _ = writeln!(text, "{name} = {value}");
    };
    key("gait", serde_json::Value::from(gait).to_string());
    key("by_sensors", (setup.knows != Knows::Truth).to_string());
    match &setup.gait {
        Gait::Stable(stable) => key("line_rad", float(stable.line)),
        Gait::Steered(steered) => {
            let points = steered.path.iter();
            let points: Vec<String> = points
                .map(|[x, y]| format!("[{}, {}]", float(*x), float(*y)))
                .collect();
            key("path_m", format!("[{}]", points.join(", ")));
        }
        Gait::Disc(fires) => {
            key("zone_rad", float(fires.zone));
            key("valve_open_s", float(fires.valve_open));
        }
    }
    let period = setup.robot.sensors.unwrap_or_default().period;
    key("period_s", float(period));
    key("seed", seed.to_string());
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
