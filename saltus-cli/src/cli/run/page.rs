//! A run as a page to watch.

use saltus::gait::{Ending, Footfall, Row, Setup};
use serde_json::{Value, json};

use super::follow::force_on;
use super::report::Report;
use crate::animation::run_page;

/// Most frames of a page.
const MOST: u64 = 6000;

/// What the page shows, a number for each frame and leg.
#[derive(Clone, Debug)]
pub(super) struct Film {
    legs: usize,
    delay: f64,
    /// Cycles from a frame to the next.
    every: u64,
    cycle: u64,
    times: Vec<f64>,
    columns: [Vec<f64>; 8],
    zone_legs: Vec<u32>,
    extensions: Vec<Vec<f64>>,
    pressures: Vec<Vec<f64>>,
    forces: Vec<Vec<[f64; 2]>>,
    /// When and how long (s) which leg is fired.
    firings: Vec<(f64, f64, u32)>,
    /// When which foot comes down.
    touch_downs: Vec<(f64, usize)>,
}

/// Names of the columns.
const NAMES: [&str; 8] = [
    "x_m",
    "y_m",
    "angle_rad",
    "rate_rad_s",
    "filtered_rad_s",
    "zone_lean_rad",
    "firing_angle_rad",
    "speed_m_s",
];

impl Film {
    pub(super) fn new(setup: &Setup) -> Film {
        let legs = setup.robot.body.legs as usize;
        // At most 60 s of cycles.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cycles = (setup.seconds / setup.sensors().period).ceil() as u64;
        Film {
            legs,
            delay: setup.robot.leg.delay,
            every: cycles.div_ceil(MOST).max(1),
            cycle: 0,
            times: Vec::new(),
            columns: Default::default(),
            zone_legs: Vec::new(),
            extensions: vec![Vec::new(); legs],
            pressures: vec![Vec::new(); legs],
            forces: vec![Vec::new(); legs],
            firings: Vec::new(),
            touch_downs: Vec::new(),
        }
    }

    /// Whether the next row becomes a frame.
    pub(super) fn is_due(&self) -> bool {
        self.cycle.is_multiple_of(self.every)
    }

    pub(super) fn push(&mut self, row: &Row<'_>, speed: f64) {
        let action = &row.action;
        if let Some(leg) = action.leg {
            self.firings.push((row.time, action.valve_open, leg));
        }
        if self.is_due() {
            self.times.push(row.time);
            let numbers = [
                row.axle[0],
                row.axle[1],
                row.lean,
                row.rate,
                action.rate,
                action.lean,
                action.firing_angle,
                speed,
            ];
            for (column, number) in self.columns.iter_mut().zip(numbers) {
                column.push(number);
            }
            self.zone_legs.push(action.in_zone);
            for leg in 0..self.legs {
                self.extensions[leg].push(row.extensions[leg]);
                self.pressures[leg].push(row.pressures[leg]);
                self.forces[leg].push(force_on(row.contacts, leg));
            }
        }
        self.cycle += 1;
    }

    pub(super) fn touch_down(&mut self, footfall: &Footfall) {
        self.touch_downs.push((footfall.time, footfall.leg));
    }
}

/// The page.
pub(super) fn html(report: &Report<'_>, film: Film) -> String {
    let robot = &report.setup.robot;
    let [hub, rod] = crate::animation::sizes(robot);
    let mut scene = json!({
        "robot": robot.name,
        "title": report.title(),
        "ended": report.ending(),
        "ran": report.summary.ending == Ending::Ran,
        "wheel_radius_m": robot.body.radius,
        "hub_radius_m": hub,
        "rod_length_m": rod,
        "stroke_m": robot.leg.stroke,
        "legs": film.legs,
        "slope_rad": robot.ground.slope,
        "ambient_pa": robot.environment.ambient.0,
        "has_gas": robot.leg.cylinder().is_some(),
        "zone_rad": report.setup.zone,
        "forwards": report.setup.forwards,
        "valve_delay_s": film.delay,
        "disturbances": report.disturbances.iter().map(|d| d.text.as_str()).collect::<Vec<_>>(),
        "time_s": film.times,
        "zone_leg": film.zone_legs,
        "extension_m": film.extensions,
        "pressure_pa": film.pressures,
        "force_n": film.forces,
        "firings": film.firings,
        "touch_downs": film.touch_downs,
    });
    for (name, column) in NAMES.iter().zip(film.columns) {
        scene[*name] = Value::from(column);
    }
    run_page(scene)
}
