//! The rolling disc that is kept in its plane.

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_controller::ball::{Balance, Steer};
use saltus_robot::Robot;

use crate::GaitError;
use crate::error::require;

/// How a robot is kept in its plane, along a line.
#[derive(Clone, Debug, PartialEq)]
pub struct Stable {
    /// Leans at which single legs and twins fire (rad).
    pub angles: [f64; 2],
    /// Valve opening times (s) of single legs and twins.
    pub opens: [f64; 2],
    /// By how much longer (s) their valves open for each rad/s below `rate`.
    pub by_rate: [f64; 2],
    /// Rate (rad/s) to hold.
    pub rate: f64,
    /// Valve opening times (s) from rest.
    pub first: [f64; 2],
    /// What the twins do.
    pub steer: Steer<f64>,
    /// The heading of the line (rad), to the left of the first heading; it begins where the robot has turned to it.
    pub line: f64,
    /// What twins do on top.
    pub extra: Option<Extra>,
}

impl Stable {
    /// The controller's constants for `robot`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for numbers that cannot be.
    pub(super) fn balance(&self, robot: &Robot) -> Result<Balance<f64>, GaitError> {
        let Stable {
            angles,
            opens,
            by_rate,
            rate,
            first,
            steer,
            line,
            extra: _,
        } = self.clone();
        let steered = [
            steer.roll,
            steer.roll_rate,
            steer.heading,
            steer.heading_rate,
            steer.aside,
            steer.aside_rate,
        ];
        let finite = [by_rate[0], by_rate[1], rate, line, steer.sum];
        for x in angles.into_iter().chain(steered).chain(finite) {
            let allowed = "a finite number";
            require(x.is_finite(), "numbers of a stable gait", x, allowed)?;
        }
        for open in opens.into_iter().chain(first).chain([steer.most]) {
            let sound = (0.0..=1.0).contains(&open);
            require(sound, "valve opening time (s)", open, "from 0 to 1 s")?;
        }
        Ok(Balance {
            period: robot.sensors.unwrap_or_default().period,
            zone: ZONE,
            angles,
            opens,
            by_rate,
            rate,
            first,
            slow: SLOW,
            stall: STALL,
            least: LEAST,
            steer: Steer {
                lead: robot.leg.delay,
                ..steer
            },
        })
    }
}

/// How fast (rad/s) the course is turned to the line.
const SLEW: f64 = 0.1;

/// The course: first it turns, then there is a line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Course {
    line: f64,
    /// The course now (rad).
    now: f64,
    /// Where the line begins (m); none while it turns.
    start: Option<[f64; 2]>,
}

impl Course {
    /// To the line of `stable`, from the first heading.
    pub(super) fn new(stable: &Stable) -> Course {
        Course {
            line: stable.line,
            now: 0.0,
            start: None,
        }
    }

    /// The course (rad) a cycle of `period` (s) later, at `place` (m).
    pub(super) fn turn(&mut self, period: f64, place: &[f64; 3]) -> f64 {
        let most = SLEW * period;
        self.now += (self.line - self.now).clamp(-most, most);
        if self.start.is_none() && (self.line - self.now).abs() <= most {
            self.start = Some([place[0], place[1]]);
        }
        self.now
    }

    /// How far (m) `place` is to the left of the line, and the rate of that (m/s) at `velocity`.
    pub(super) fn aside(&self, place: &[f64; 3], velocity: &[f64; 3]) -> [f64; 2] {
        let (sine, cosine) = self.now.sin_cos();
        let across = |x: f64, y: f64| cosine * y - sine * x;
        let far = |[x, y]: [f64; 2]| across(place[0] - x, place[1] - y);
        [
            self.start.map_or(0.0, far),
            across(velocity[0], velocity[1]),
        ]
    }
}

/// What twins do on top of all feedback, to find out what it does: drawn anew for each station.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extra {
    /// Greatest difference (s).
    pub most: f64,
    /// Seed.
    pub seed: u64,
}

impl Extra {
    /// By how much longer (s) the right twin's valve opens at the station that came as number `passed`.
    pub(super) fn at(&self, passed: i32) -> f64 {
        let number = u128::from(passed.unsigned_abs());
        let mut random = Pcg64::new(u128::from(self.seed), 2 * number + 1);
        let unit = Uniform::new_inclusive(-1.0, 1.0).map(|uniform| uniform.sample(&mut random));
        self.most * unit.unwrap_or(0.0)
    }
}

/// Lean (rad) at which a station enters the active zone.
const ZONE: f64 = -0.3;
/// Rate (rad/s) below which it sets out, and for how long (s) it may stand.
const SLOW: f64 = 1.0;
const STALL: f64 = 0.3;
/// Shortest valve opening (s).
const LEAST: f64 = 0.0005;

impl Default for Stable {
    /// For `rats-twelve`, by search among drawn robots with sensors.
    fn default() -> Stable {
        Stable {
            angles: [0.46617, 0.31153],
            opens: [0.01194, 0.00591],
            by_rate: [0.00458, 0.00258],
            rate: 5.29089,
            first: [0.02926, 0.00989],
            steer: Steer {
                roll: 0.00704,
                roll_rate: 0.0039,
                heading: -0.00231,
                heading_rate: 0.00074,
                aside: -0.001,
                aside_rate: -0.00105,
                sum: 0.00025,
                most: 0.00419,
                lead: 0.0,
                from: 0.37116,
                rest: 0.01728,
            },
            line: 0.0,
            extra: None,
        }
    }
}
