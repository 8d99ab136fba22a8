//! The report of a jump from rest to a place.

use std::fmt::Write as _;

use saltus::gait::Obstacle;
use saltus::gait::space::jump::{Cycle, Flown, JumpPlan, Standing, landed};
use serde_json::{Value, json};

use super::{AFTER, NEAR, Nearby, short};
use crate::cli::run::{in_words, share};
use crate::output::{Cell, Table, digits};

/// Speed (m/s) below which a robot rests.
const RESTS: f64 = 0.01;

/// A jump to a place.
pub(super) struct Answer<'a> {
    pub(super) name: &'a str,
    pub(super) rest: usize,
    pub(super) standing: &'a Standing,
    pub(super) target: [f64; 2],
    pub(super) plan: &'a JumpPlan,
    pub(super) whole: Flown,
    pub(super) near: Nearby,
}

impl Answer<'_> {
    pub(super) fn text(&self) -> String {
        let [x, y] = self.target.map(short);
        let feet: Vec<String> = self
            .standing
            .rest
            .legs
            .iter()
            .map(ToString::to_string)
            .collect();
        let feet = feet.join(", ");
        let mut text = format!(
            "{}: a jump from rest {} on feet {feet} to ({x}, {y}) m\n",
            self.name, self.rest
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        if let Some(obstacle) = &self.standing.obstacle {
            line("before", a_box(obstacle));
        }
        for (k, command) in self.plan.jump.commands.iter().enumerate() {
            let name = format!("firing {}", k + 1);
            let at = digits(1e3 * command.at, 4);
            let open = digits(1e3 * command.open, 4);
            line(
                &name,
                format!(
                    "leg {} at {at} ms, valve open for at most {open} ms",
                    command.leg
                ),
            );
        }
        for (name, touch) in [
            ("lands by the model", self.plan.modelled),
            ("lands in the simulation", self.plan.flown.touch),
        ] {
            let what = touch.map_or_else(
                || "it does not come off the ground".into(),
                |touch| {
                    let [x, y, _] = touch.place.map(short);
                    let time = digits(touch.time, 4);
                    let apex = digits(touch.apex, 4);
                    format!("({x}, {y}) m after {time} s, at most {apex} m high")
                },
            );
            line(name, what);
        }
        line("then", self.after());
        let off = digits(100.0 * self.plan.off, 2);
        let off = format!("robots land {off} cm off it in the mean");
        let reach = if self.plan.is_reached() {
            format!("yes: {off}")
        } else {
            let nearest = match landed(&self.plan.flown) {
                Some([x, y]) => format!("({}, {}) m", short(x), short(y)),
                None => "where it stands".into(),
            };
            format!("no: {off}; this robot lands at {nearest}")
        };
        line("in reach", reach);
        let near = format!("within {} cm", digits(100.0 * NEAR, 3));
        line(
            &near,
            format!("{}, other robots", in_words(&self.near.near)),
        );
        if let Some(stay) = &self.near.stay {
            line("and stay on the box", in_words(stay));
        }
        text
    }

    /// What it does after the landing, in words.
    fn after(&self) -> String {
        let [x, y, _] = self.whole.rests.map(short);
        if self.whole.speed < RESTS {
            format!("it comes to rest at ({x}, {y}) m")
        } else {
            let speed = digits(self.whole.speed, 3);
            format!("after {AFTER} s it is at ({x}, {y}) m and moves at {speed} m/s")
        }
    }

    pub(super) fn json(&self, seed: u64) -> Value {
        json!({
            "command": "jump",
            "robot": self.name,
            "rest": self.rest,
            "feet": self.standing.rest.legs,
            "obstacle": self.standing.obstacle.as_ref().map(numbers),
            "target_m": self.target,
            "firings": self.plan.jump.commands.iter().map(|command| json!({
                "leg": command.leg, "at_s": command.at, "valve_open_s": command.open,
            })).collect::<Vec<_>>(),
            "aim_m": self.plan.jump.guide.as_ref().map(|guide| guide.aim),
            "modelled_m": self.plan.modelled.map(|touch| touch.place),
            "landed_m": self.plan.flown.touch.map(|touch| touch.place),
            "landed_s": self.plan.flown.touch.map(|touch| touch.time),
            "apex_m": self.plan.flown.touch.map(|touch| touch.apex),
            "miss_m": finite(self.plan.miss),
            "is_reached": self.plan.is_reached(),
            "mean_off_m": self.plan.off,
            "in_the_end_m": self.whole.rests,
            "speed_in_the_end_m_s": self.whole.speed,
            "clearance_m": finite(self.plan.flown.clearance),
            "within_10_cm": share(&self.near.near),
            "stay_on_the_box": self.near.stay.as_ref().map(share),
            "seed": seed,
        })
    }
}

/// A box as JSON has it.
pub(super) fn numbers(obstacle: &Obstacle) -> Value {
    json!({
        "height_m": obstacle.height, "length_m": obstacle.length, "front_m": obstacle.front,
    })
}

/// A box in words.
pub(super) fn a_box(obstacle: &Obstacle) -> String {
    let [height, length, front] =
        [obstacle.height, obstacle.length, obstacle.front].map(|x| digits(x, 4));
    format!("a box {height} m high and {length} m long, its front at {front} m")
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// The cycles of a jump.
pub(super) fn rows(cycles: &[Cycle]) -> Table {
    let mut table = Table::new(&[
        "time_s",
        "x_m",
        "y_m",
        "z_m",
        "quaternion_w",
        "quaternion_x",
        "quaternion_y",
        "quaternion_z",
        "vx_m_s",
        "vy_m_s",
        "vz_m_s",
        "spin_x_rad_s",
        "spin_y_rad_s",
        "spin_z_rad_s",
        "feet_on_ground",
    ]);
    for cycle in cycles {
        let moves = cycle.velocity.iter().chain(&cycle.spin);
        let numbers = cycle.place.iter().chain(&cycle.attitude).chain(moves);
        let mut row: Vec<Cell> = vec![cycle.time.into()];
        row.extend(numbers.map(|x| Cell::from(*x)));
        row.push(Cell::Count(cycle.touching.count_ones() as usize));
        table.push(row);
    }
    table
}
