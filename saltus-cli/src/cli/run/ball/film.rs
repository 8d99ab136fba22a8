//! What a page that plays the run of a ball shows, frame by frame.

use saltus::gait::space::{Ball, Gait, Roll};
use saltus::robot::space::Factors;
use serde_json::{Value, json};

use crate::animation::{ball_page, packed, sizes};

/// What a page says of its run.
#[derive(Clone, Debug)]
pub(super) struct About {
    pub(super) title: String,
    pub(super) ended: String,
    /// Whether it came to the end.
    pub(super) rolled: bool,
}

/// Most frames of a page: 200 in a second of the longest one.
const MOST: u64 = 12_000;

/// The frames: each list has a number, or several, of each.
#[derive(Clone, Debug)]
pub(super) struct Film {
    /// Cycles from a frame to the next.
    every: u64,
    cycle: u64,
    times: Vec<f64>,
    places: Vec<f64>,
    attitudes: Vec<f64>,
    estimated_places: Vec<f64>,
    estimated_attitudes: Vec<f64>,
    columns: [Vec<f64>; 5],
    /// For each leg.
    extensions: Vec<f64>,
    /// For each leg, along the world's axes.
    forces: Vec<f64>,
    touching: Vec<u8>,
    /// Since when (s) the disc has which axis, in the body's axes.
    axes: Vec<(f64, [f64; 3])>,
    /// Heading (rad) of the line that it follows, if it follows one.
    line: Option<f64>,
    /// A place of that line, (m) along the first heading and to its left.
    on_line: Option<[f64; 2]>,
    /// When and how long (s) which leg is fired.
    firings: Vec<(f64, f64, u32)>,
    /// When which foot comes down.
    touch_downs: Vec<(f64, usize)>,
    /// Feet on the ground in the last cycle.
    stood: u64,
}

/// Names of the columns.
const NAMES: [&str; 5] = [
    "lean_rad",
    "rate_rad_s",
    "roll_rad",
    "heading_rad",
    "aside_m",
];

impl Film {
    pub(super) fn new(setup: &Roll) -> Film {
        let period = setup.robot.sensors.unwrap_or_default().period;
        // At most 60 s of cycles.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let cycles = (setup.seconds / period).ceil() as u64;
        Film {
            every: cycles.div_ceil(MOST).max(1),
            cycle: 0,
            times: Vec::new(),
            places: Vec::new(),
            attitudes: Vec::new(),
            estimated_places: Vec::new(),
            estimated_attitudes: Vec::new(),
            columns: Default::default(),
            extensions: Vec::new(),
            forces: Vec::new(),
            touching: Vec::new(),
            axes: Vec::new(),
            line: match &setup.gait {
                Gait::Stable(stable) => Some(stable.line),
                Gait::Disc(_) | Gait::Steered(_) => None,
            },
            on_line: None,
            firings: Vec::new(),
            touch_downs: Vec::new(),
            stood: u64::MAX,
        }
    }

    /// Cycles from a frame to the next: in the first of them it needs the forces on the feet.
    pub(super) fn every(&self) -> u64 {
        self.every
    }

    pub(super) fn push(&mut self, ball: &Ball) {
        for firing in &ball.fired {
            self.firings.push((ball.time, firing.open, firing.leg));
        }
        let came_down = ball.touching & !self.stood;
        self.stood = ball.touching;
        for leg in (0..ball.extensions.len()).filter(|leg| came_down >> leg & 1 == 1) {
            self.touch_downs.push((ball.time, leg));
        }
        if self.axes.last().is_none_or(|(_, axis)| *axis != ball.axis) {
            self.axes.push((ball.time, ball.axis));
        }
        if let (None, Some(line), true) = (self.on_line, self.line, ball.aside != 0.0) {
            let ([x, y, _], (sine, cosine)) = (ball.place, line.sin_cos());
            self.on_line = Some([x + ball.aside * sine, y - ball.aside * cosine]);
        }
        if self.cycle.is_multiple_of(self.every) {
            self.frame(ball);
        }
        self.cycle += 1;
    }

    fn frame(&mut self, ball: &Ball) {
        self.times.push(ball.time);
        self.places.extend(ball.place);
        self.attitudes.extend(ball.attitude);
        if let Some(estimate) = &ball.estimate {
            self.estimated_places.extend(estimate.place);
            self.estimated_attitudes.extend(estimate.attitude.0);
        }
        let l = &ball.rolling;
        let numbers = [l.lean, l.rate, l.roll, l.heading, ball.aside];
        for (column, number) in self.columns.iter_mut().zip(numbers) {
            column.push(number);
        }
        self.extensions.extend(&ball.extensions);
        for leg in 0..ball.extensions.len() {
            self.forces.extend(force_on(&ball.forces, leg));
            self.touching.push(u8::from(ball.touching >> leg & 1 == 1));
        }
    }

    /// The page that plays it.
    pub(super) fn page(self, setup: &Roll, about: &About) -> String {
        let robot = &setup.robot;
        let path = match &setup.gait {
            Gait::Steered(steered) => Some(&steered.path),
            Gait::Stable(_) | Gait::Disc(_) => None,
        };
        let [_, rod] = sizes(robot);
        let space = robot.space.as_ref();
        let factors = space.map(|space| space.legs.as_slice()).unwrap_or_default();
        let legs = robot.body.legs as usize;
        let delay = |leg: usize| {
            let own = factors.get(leg).copied().unwrap_or_else(Factors::default);
            own.delay * robot.leg.delay
        };
        let most = |numbers: &[f64]| numbers.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let columns = NAMES.iter().zip(&self.columns);
        let columns: serde_json::Map<String, Value> = columns
            .map(|(name, column)| ((*name).to_owned(), packed::floats(column)))
            .collect();
        ball_page(json!({
            "robot": robot.name,
            "title": about.title,
            "ended": about.ended,
            "rolled": about.rolled,
            "line_rad": self.line,
            "on_line_m": self.on_line,
            "path_m": path,
            "radius_m": robot.body.radius,
            "rod_length_m": rod,
            "rod_radius_m": robot.leg.body.radius,
            "foot_radius_m": robot.foot.radius,
            "stroke_m": robot.leg.stroke,
            "slope_rad": robot.ground.slope,
            "directions": space.map(|space| space.directions.vectors()),
            "valve_delay_s": (0..legs).map(delay).collect::<Vec<f64>>(),
            "axes": self.axes,
            "firings": self.firings,
            "touch_downs": self.touch_downs,
            "frames": self.times.len(),
            "time_s": packed::floats(&self.times),
            "place_m": packed::floats(&self.places),
            "attitude": packed::shares(&self.attitudes, 1.0),
            "estimated_place_m": packed::floats(&self.estimated_places),
            "estimated_attitude": packed::shares(&self.estimated_attitudes, 1.0),
            "extension_m": packed::shares(&self.extensions, most(&self.extensions)),
            "force_n": packed::shares(&self.forces, most(&self.forces)),
            "touching": packed::bytes(&self.touching),
            "columns": columns,
        }))
    }
}

/// The sum of the ground's forces (N) on leg `leg`, along the world's axes.
fn force_on(forces: &[(usize, [f64; 3])], leg: usize) -> [f64; 3] {
    let of_leg = forces.iter().filter(|(of, _)| *of == leg);
    of_leg.fold([0.0; 3], |sum, (_, force)| {
        std::array::from_fn(|k| sum[k] + force[k])
    })
}

#[cfg(test)]
mod tests;
