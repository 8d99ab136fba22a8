//! How well a ball knows its motion by its sensors.

use saltus::gait::space::{Ball, FALLS};
use saltus_controller::ball::Rotation;

/// What its sensors make of a run, against the truth.
///
/// A touch-down counts as found at the first cycle at which the foot's switch is pressed, if that is at most 2 ms later. A foot
/// that is off the ground again before a cycle comes is not found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// Times that a foot came onto the ground.
    pub touch_downs: usize,
    /// How many of them were found within 1 ms, and within 2 ms.
    pub found: [usize; 2],
    /// Sums of squares of the errors of the attitude (rad²) while it rolled: in the plane, about the level axis across its
    /// heading; of roll, about its heading; of heading, about the vertical.
    pub squares: [f64; 3],
    /// Cycles in which it rolled: its disc leaned by less than [`FALLS`], and it had not fallen before.
    pub cycles: usize,
    /// How far (rad) the heading that it believes is to the left of the true one, now.
    pub heading: f64,
    /// Greatest of these, either way (rad).
    pub most_heading: f64,
    /// Touch-downs that are waited for: each foot, and when (s).
    waiting: Vec<(usize, f64)>,
    fell: bool,
}

/// Within which times (s) a contact is found, and what round-off may add.
const FOUND: [f64; 2] = [1e-3, 2e-3];
const ROUND_OFF: f64 = 1e-9;

impl Known {
    /// Takes a cycle into account.
    pub fn take(&mut self, ball: &Ball) {
        self.find(ball);
        self.fell |= ball.rolling.roll.abs() > FALLS;
        let Some(estimate) = ball.estimate else {
            return;
        };
        // By which small rotation of the world what it believes is off.
        let [w, x, y, z] = estimate.attitude.after(&Rotation(ball.attitude).back()).0;
        let off = [x, y, z].map(|part| 2.0 * part * w.signum());
        self.heading = off[2];
        self.most_heading = self.most_heading.max(off[2].abs());
        if self.fell {
            return;
        }
        let (sine, cosine) = ball.rolling.heading.sin_cos();
        let errors = [
            cosine * off[1] - sine * off[0],
            cosine * off[0] + sine * off[1],
            off[2],
        ];
        for (sum, error) in self.squares.iter_mut().zip(errors) {
            *sum += error * error;
        }
        self.cycles += 1;
    }

    fn find(&mut self, ball: &Ball) {
        self.touch_downs += ball.touched.len();
        self.waiting.extend(&ball.touched);
        let (found, now) = (&mut self.found, ball.time + ROUND_OFF);
        self.waiting.retain(|(leg, when)| {
            let is_pressed = ball.touching >> leg & 1 == 1;
            for (count, within) in found.iter_mut().zip(FOUND) {
                *count += usize::from(is_pressed && now - ROUND_OFF - when <= within + ROUND_OFF);
            }
            !is_pressed && now - when < FOUND[1]
        });
    }

    /// Adds the figures of another ball, whose heading is that of the latest.
    pub fn add(&mut self, other: &Known) {
        self.touch_downs += other.touch_downs;
        self.cycles += other.cycles;
        for k in 0..2 {
            self.found[k] += other.found[k];
        }
        for (sum, more) in self.squares.iter_mut().zip(other.squares) {
            *sum += more;
        }
        self.heading = other.heading;
        self.most_heading = self.most_heading.max(other.most_heading);
    }

    /// Root mean squares (rad) of the errors while it rolled: in the plane, of roll, of heading.
    pub fn rms(&self) -> [f64; 3] {
        let count = self.cycles.max(1) as f64;
        self.squares.map(|sum| (sum / count).sqrt())
    }
}
