//! What a page that plays a run shows, frame by frame.

use saltus::gait::{Footfall, Output, Row, Setup};
use saltus::sim_check::Contact;
use serde_json::{Value, json};

use crate::animation::{run_page, sizes};

/// What a page says of its run.
#[derive(Clone, Debug)]
pub(crate) struct About<'a> {
    pub(crate) title: String,
    pub(crate) ended: String,
    /// Whether it ran to the end.
    pub(crate) ran: bool,
    pub(crate) disturbances: Vec<&'a str>,
}

/// Most frames of a page.
const MOST: u64 = 6000;

/// What the page shows, a number for each frame and leg.
#[derive(Clone, Debug)]
pub(crate) struct Film {
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
    /// The openings of valves: each output, and its leg.
    openings: Vec<(Output, usize)>,
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
    pub(crate) fn new(setup: &Setup) -> Film {
        let legs = setup.robot.body.legs as usize;
        // At most 60 s of cycles.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cycles = (setup.seconds / setup.sensors().period).ceil() as u64;
        Film {
            legs,
            delay: setup.robot.leg.opening_delay(),
            every: cycles.div_ceil(MOST).max(1),
            cycle: 0,
            times: Vec::new(),
            columns: Default::default(),
            zone_legs: Vec::new(),
            extensions: vec![Vec::new(); legs],
            pressures: vec![Vec::new(); legs],
            forces: vec![Vec::new(); legs],
            openings: Vec::new(),
            touch_downs: Vec::new(),
        }
    }

    /// Whether the next row becomes a frame.
    pub(crate) fn is_due(&self) -> bool {
        self.cycle.is_multiple_of(self.every)
    }

    pub(crate) fn push(&mut self, row: &Row<'_>, speed: f64) {
        let action = &row.action;
        for (leg, output) in row.outputs.iter().enumerate() {
            let mut own = self.openings.iter_mut().rev().filter(|it| it.1 == leg);
            match own.next() {
                Some((last, _)) if last.on == output.on => *last = *output,
                _ if output.on.is_finite() => self.openings.push((*output, leg)),
                _ => {}
            }
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
                row.firing_angle().unwrap_or(f64::NAN),
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

    pub(crate) fn touch_down(&mut self, footfall: &Footfall) {
        self.touch_downs.push((footfall.time, footfall.leg));
    }

    /// The page that plays it.
    pub(crate) fn page(self, setup: &Setup, about: &About<'_>) -> String {
        let robot = &setup.robot;
        let [hub, rod] = sizes(robot);
        let mut scene = self.value();
        let more = json!({
            "robot": robot.name,
            "title": about.title,
            "ended": about.ended,
            "ran": about.ran,
            "wheel_radius_m": robot.body.radius,
            "hub_radius_m": hub,
            "rod_length_m": rod,
            "stroke_m": robot.leg.stroke,
            "slope_rad": robot.ground.slope,
            "ambient_pa": robot.environment.ambient.0,
            "has_gas": robot.leg.cylinder().is_some(),
            "zone_rad": setup.zone,
            "forwards": setup.forwards,
            "disturbances": about.disturbances,
        });
        if let (Value::Object(scene), Value::Object(more)) = (&mut scene, more) {
            scene.extend(more);
        }
        run_page(scene)
    }

    /// The frames, as the page's script reads them.
    fn value(self) -> Value {
        let end = self.times.last().copied().unwrap_or(0.0);
        // A valve that is still held open is open to the end.
        let open = |(output, leg): &(Output, usize)| {
            let off = if output.off.is_finite() {
                output.off
            } else {
                end.max(output.on)
            };
            (output.on, off - output.on, *leg)
        };
        let firings: Vec<_> = self.openings.iter().map(open).collect();
        let mut value = json!({
            "legs": self.legs,
            "valve_delay_s": self.delay,
            "time_s": self.times,
            "zone_leg": self.zone_legs,
            "extension_m": self.extensions,
            "pressure_pa": self.pressures,
            "force_n": self.forces,
            "firings": firings,
            "touch_downs": self.touch_downs,
        });
        for (name, column) in NAMES.iter().zip(self.columns) {
            value[*name] = Value::from(column);
        }
        value
    }
}

/// The sum of the ground's forces (N) on leg `leg` along the travel and up.
fn force_on(contacts: &[Contact], leg: usize) -> [f64; 2] {
    let of_leg = contacts.iter().filter(|contact| contact.point == leg);
    of_leg.fold([0.0; 2], |sum, contact| {
        [sum[0] + contact.parts.y, sum[1] + contact.parts.x]
    })
}
