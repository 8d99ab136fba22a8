//! How one leg that was fired goes out and comes home, as it is believed to.

use saltus_robot::Robot;

use super::track::Firing;
use crate::rig::{Flight, Rig, Start};

/// A leg that is home by the model may be late by this factor.
const LATE: f64 = 1.2;
/// Time (s) between extensions, and their number.
pub(super) const STEP: f64 = 2e-3;
const STEPS: u32 = 300;

/// A leg that is fired once, as it is believed to move.
#[derive(Clone, Debug)]
pub(super) struct Out {
    /// How long (s) it is out after its valve shut; infinite where nothing pulls it in.
    pub(super) after: f64,
    /// Its extension (m) from the command on, a step from each to the next.
    pub(super) extensions: Vec<f64>,
}

/// The state in which a leg is fired.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fired {
    /// Lean (rad) of the leg, and its rate (rad/s).
    pub(super) lean: f64,
    pub(super) rate: f64,
    /// Height (m) of its foot above the ground.
    pub(super) above: f64,
}

impl Fired {
    /// In whole steps, with the valve's opening time (0.5 ms).
    pub(super) fn key(&self, firing: Firing) -> [i64; 4] {
        let opening = firing.shut - firing.open;
        // Whole numbers.
        #[allow(clippy::cast_possible_truncation)]
        let whole = |x: f64, step: f64| (x / step).round() as i64;
        [
            whole(self.lean, 0.05),
            whole(self.rate, 0.5),
            whole(self.above, 2e-3),
            whole(opening.max(0.0), 5e-4),
        ]
    }

    /// The start of the motion of `robot`.
    fn start(&self, robot: &Robot) -> Start {
        let foot = robot.foot.radius;
        let height = foot + (robot.body.radius - foot) * self.lean.cos() + self.above;
        let (pivot, turn_rate) = match robot.boom {
            Some(boom) => (
                ((height - robot.body.radius) / boom.length).asin(),
                self.rate * robot.body.radius / boom.length,
            ),
            None => (height, self.rate * robot.body.radius),
        };
        Start::Flying(Flight {
            lean: (self.lean, self.rate),
            pivot: (pivot, 0.0),
            turn_rate,
        })
    }
}

impl Out {
    pub(super) fn new(robot: &Robot, state: &Fired, opening: f64) -> Out {
        let times = (0..STEPS).map(|n| STEP * f64::from(n));
        let until = STEP * f64::from(STEPS);
        // With gravity it would fall back onto the one foot that there is.
        let mut floats = robot.clone();
        floats.environment.gravity = 0.0;
        let course = Rig::new(&floats).jump(state.start(robot), 0.0, opening, Some(until));
        let extensions: Vec<f64> = course.map_or_else(Vec::new, |course| {
            let mut place = 0;
            times
                .map(|time| course.at(time, &mut place).extension.0)
                .collect()
        });
        let last_out = extensions
            .iter()
            .rposition(|d| *d > 1e-4 * robot.leg.stroke);
        let after = match last_out {
            Some(last) if last + 1 < extensions.len() => {
                LATE * (STEP * last as f64 - opening).max(0.0)
            }
            None if !extensions.is_empty() => 0.0,
            _ => f64::INFINITY,
        };
        Out { after, extensions }
    }
}
