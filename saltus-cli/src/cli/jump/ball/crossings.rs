//! The report of robots that ran up to a box, and jumped over it or onto it.

use std::fmt::Write as _;

use saltus::gait::Obstacle;
use saltus::gait::space::jump::{Leap, ON, Passed, SPEED};
use saltus::running::Share;
use serde_json::{Value, json};

use crate::cli::run::{in_words, share};
use crate::output::{Cell, Table, digits};

/// Robots that ran up to a box.
pub(super) struct Crossings<'a> {
    pub(super) name: &'a str,
    pub(super) obstacle: Obstacle,
    pub(super) is_onto: bool,
    pub(super) farthest: f64,
    pub(super) leap: &'a Leap,
    pub(super) tried: &'a [Passed],
}

impl Crossings<'_> {
    pub(super) fn share(&self, did: impl Fn(&Passed) -> bool) -> Share {
        Share {
            count: self.tried.iter().filter(|it| did(it)).count(),
            of: self.tried.len(),
        }
    }

    pub(super) fn text(&self) -> String {
        let Obstacle {
            front,
            length,
            height,
        } = self.obstacle;
        let [height, length, front, farthest] =
            [height, length, front, self.farthest].map(|x| digits(x, 4));
        let fronts = if front == farthest {
            front
        } else {
            format!("{front} to {farthest}")
        };
        let way = if self.is_onto { "onto" } else { "over" };
        let mut text = format!(
            "{}: out of a run {way} a box {height} m high and {length} m long, its front {fronts} m from the middle at rest\n",
            self.name,
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        let leap = self.leap;
        let short = |x: f64| digits(x, 3);
        line(
            "first push",
            format!("so that twins come down {} m before it", short(leap.aim)),
        );
        line("rate of the run-up", format!("{} rad/s", short(leap.rate)));
        let [earlier, later] = leap.by_speed.map(short);
        line(
            "twins jump",
            format!(
                "from {} m before it on, for {} ms",
                short(leap.from),
                short(1e3 * leap.open)
            ),
        );
        line(
            "at a lean of",
            format!(
                "{} rad, and {} rad more for each m nearer",
                short(leap.lean),
                short(leap.nearer)
            ),
        );
        line(
            &format!("for each m/s above {SPEED}"),
            format!("{earlier} m earlier, {later} rad more"),
        );
        let cleared = if self.is_onto {
            "came onto it"
        } else {
            "cleared"
        };
        line(cleared, in_words(&self.share(|it| it.cleared)));
        line(
            "did not jump",
            in_words(&self.share(|it| it.jumped.is_none())),
        );
        let on = digits(ON, 3);
        line(
            &format!("went on for {on} m"),
            in_words(&self.share(|it| it.ran_on)),
        );
        let mut apexes: Vec<f64> = self.tried.iter().map(|it| it.apex).collect();
        let apex = saltus::numeric::statistics::median(&mut apexes);
        line("median of the height", format!("{} m", digits(apex, 3)));
        text
    }

    pub(super) fn table(&self) -> Table {
        let mut table = Table::new(&[
            "robot",
            "front_m",
            "first_valve_open_s",
            "jumped_at_m",
            "speed_m_s",
            "clearance_m",
            "apex_m",
            "cleared",
            "ran_on",
        ]);
        for (k, it) in self.tried.iter().enumerate() {
            table.push(vec![
                Cell::Count(k),
                it.front.into(),
                it.first.into(),
                it.jumped.into(),
                it.speed.into(),
                it.clearance.into(),
                it.apex.into(),
                Cell::Flag(it.cleared),
                Cell::Flag(it.ran_on),
            ]);
        }
        table
    }

    pub(super) fn json(&self, seed: u64) -> Value {
        let Obstacle {
            front,
            length,
            height,
        } = self.obstacle;
        let leap = self.leap;
        json!({
            "command": "jump",
            "robot": self.name,
            "onto": self.is_onto,
            "obstacle": {"height_m": height, "length_m": length, "fronts_m": [front, self.farthest]},
            "aim_m": leap.aim,
            "from_m": leap.from,
            "lean_rad": leap.lean,
            "lean_by_distance_rad_m": leap.nearer,
            "valve_open_s": leap.open,
            "from_by_speed_s": leap.by_speed[0],
            "lean_by_speed_rad_s_m": leap.by_speed[1],
            "rate_rad_s": leap.rate,
            "cleared": share(&self.share(|it| it.cleared)),
            "ran_on": share(&self.share(|it| it.ran_on)),
            "robots": self.table().json(),
            "seed": seed,
        })
    }
}
