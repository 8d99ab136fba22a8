//! The rolling disc that is kept in its plane.

use saltus_controller::ball::{Balance, Steer};
use saltus_robot::Robot;

use crate::GaitError;
use crate::error::ensure;

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
}

impl Stable {
    /// The controller's constants for `robot`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for numbers that cannot be.
    pub fn balance(&self, robot: &Robot) -> Result<Balance<f64>, GaitError> {
        let Stable {
            angles,
            opens,
            by_rate,
            rate,
            first,
            steer,
            line,
        } = self.clone();
        let steered = [
            steer.roll,
            steer.roll_rate,
            steer.heading,
            steer.heading_rate,
            steer.aside,
            steer.aside_rate,
            steer.sum,
            steer.from,
            steer.rest,
        ];
        let finite = [by_rate[0], by_rate[1], rate, line];
        for x in angles.into_iter().chain(steered).chain(finite) {
            ensure! { "numbers of a stable gait", x, x.is_finite() => "a finite number"; }
        }
        for open in opens.into_iter().chain(first).chain([steer.most]) {
            let sound = (0.0..=1.0).contains(&open);
            ensure! { "valve opening time (s)", open, sound => "from 0 to 1 s"; }
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
            lead: robot.leg.delay,
            steer,
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
    /// To a line of this heading (rad), from the first heading.
    pub(super) fn new(line: f64) -> Course {
        Course {
            line,
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
                from: 0.37116,
                rest: 0.01728,
            },
            line: 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_turns_slowly_and_its_line_begins_there() {
        for line in [0.5, -0.3] {
            let mut course = Course::new(line);
            let mut turned = 0.0;
            for k in 0..10_000 {
                let time = 1e-3 * f64::from(k);
                let next = course.turn(1e-3, &[time, 0.0, 0.2]);
                assert!((next - turned).abs() <= SLEW * 1e-3 + 1e-12);
                if (next - line).abs() > 1e-3 {
                    assert_eq!(course.aside(&[time, 0.0, 0.2], &[1.0, 0.0, 0.0])[0], 0.0);
                }
                turned = next;
            }
            assert!((turned - line).abs() < 1e-12);
            // The line begins after |line|/0.1 s, so many metres ahead; a metre farther on is on it, and left of it is left.
            let start = 10.0 * line.abs();
            let (sine, cosine) = line.sin_cos();
            let at = |far: f64, left: f64| {
                [
                    start + far * cosine - left * sine,
                    far * sine + left * cosine,
                    0.2,
                ]
            };
            let [aside, rate] = course.aside(&at(1.0, 0.4), &[-sine, cosine, 0.0]);
            assert!(
                (aside - 0.4).abs() < 2e-3 && (rate - 1.0).abs() < 1e-12,
                "{aside} {rate}"
            );
        }
    }
}
