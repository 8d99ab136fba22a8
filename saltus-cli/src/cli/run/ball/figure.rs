//! The run of a ball from above, and how it lies over time.

use std::f64::consts::PI;

use saltus::gait::space::{Ball, Gait, Roll};

use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREY, RED};
use crate::plot::sheet::{Panel, Sheet};

/// Points that are drawn of a run, and the time (s) over which its speed is a mean: it changes with every step.
const POINTS: f64 = 1000.0;
const SPAN: f64 = 0.5;

/// Some cycles of a run.
#[derive(Clone, Debug)]
pub(super) struct Track {
    every: f64,
    rows: Vec<Row>,
    way: f64,
    place: [f64; 2],
}

#[derive(Clone, Copy, Debug)]
struct Row {
    time: f64,
    place: [f64; 3],
    /// Way over the ground (m) since the start.
    way: f64,
    roll: f64,
    heading: f64,
    estimated: Option<[f64; 3]>,
}

impl Track {
    /// That of a run of so many `seconds`.
    pub(super) fn new(seconds: f64) -> Track {
        Track {
            every: seconds / POINTS,
            rows: Vec::new(),
            way: 0.0,
            place: [0.0; 2],
        }
    }

    pub(super) fn push(&mut self, ball: &Ball) {
        let [x, y, _] = ball.place;
        self.way += (x - self.place[0]).hypot(y - self.place[1]);
        self.place = [x, y];
        if self.rows.len() as f64 * self.every > ball.time {
            return;
        }
        self.rows.push(Row {
            time: ball.time,
            place: ball.place,
            way: self.way,
            roll: ball.rolling.roll,
            heading: ball.rolling.heading,
            estimated: ball.estimate.map(|estimate| estimate.place),
        });
    }
}

impl Track {
    /// Speed over the ground (m/s) over time (s): the mean over [`SPAN`].
    fn speeds(&self) -> Vec<(f64, f64)> {
        let later = |a: &Row| self.rows.partition_point(|b| b.time < a.time + SPAN);
        let pairs = self
            .rows
            .iter()
            .filter_map(|a| Some((a, self.rows.get(later(a))?)));
        let speed = |(a, b): (&Row, &Row)| {
            let time = b.time - a.time;
            (0.5 * (a.time + b.time), (b.way - a.way) / time)
        };
        pairs.map(speed).collect()
    }
}

/// The track from above with what it follows, its roll, its heading and its speed.
pub(super) fn drawing(setup: &Roll, title: String, track: &Track) -> Sheet {
    let line = |label: Option<&str>, color, mark, points: Vec<(f64, f64)>| Line {
        label: label.map(Into::into),
        points,
        color,
        mark,
    };
    let places = |of: &dyn Fn(&Row) -> Option<[f64; 3]>| -> Vec<(f64, f64)> {
        let all = track.rows.iter().filter_map(of);
        all.map(|[x, y, _]| (x, y)).collect()
    };
    let mut above = vec![line(
        Some("track"),
        BLUE,
        Mark::Solid,
        places(&|row| Some(row.place)),
    )];
    let estimated = places(&|row| row.estimated);
    if !estimated.is_empty() {
        above.push(line(Some("estimate"), RED, Mark::Dashed, estimated));
    }
    let farthest = track
        .rows
        .iter()
        .map(|row| row.place[0].hypot(row.place[1]));
    let farthest = farthest.fold(1.0, f64::max);
    let followed = followed(&setup.gait, farthest);
    if !followed.is_empty() {
        above.push(line(Some("to follow"), GREY, Mark::Dashed, followed));
    }
    let over_time = |title: &str, y, points: Vec<(f64, f64)>| Panel {
        title: title.into(),
        x: "time (s)",
        y,
        // The heading is cut where it goes from half a turn to the left to half a turn to the right.
        lines: points
            .chunk_by(|a, b| (a.1 - b.1).abs() < PI)
            .map(|part| line(None, BLUE, Mark::Solid, part.to_vec()))
            .collect(),
        ..Panel::default()
    };
    let each = |of: &dyn Fn(&Row) -> f64| -> Vec<(f64, f64)> {
        track.rows.iter().map(|row| (row.time, of(row))).collect()
    };
    let panels = vec![
        Panel {
            title: "From above".into(),
            x: "along the first heading (m)",
            y: "to its left (m)",
            lines: above,
            least: Some([[0.0, 1.0], [-0.5, 0.5]]),
            ..Panel::default()
        },
        over_time(
            "Roll of its disc, to the right",
            "roll (rad)",
            each(&|row| row.roll),
        ),
        over_time("Heading", "heading (rad)", each(&|row| row.heading)),
        over_time(
            "Speed over the ground, mean over 0.5 s",
            "speed (m/s)",
            track.speeds(),
        ),
    ];
    Sheet {
        title,
        panels,
        ..Sheet::default()
    }
}

/// The line or path of `gait`, so far (m) as a robot came.
fn followed(gait: &Gait, farthest: f64) -> Vec<(f64, f64)> {
    let origin = (0.0, 0.0);
    match gait {
        Gait::Disc(_) => Vec::new(),
        // A line of another heading begins where the robot has turned to it.
        Gait::Stable(stable) if stable.line != 0.0 => Vec::new(),
        Gait::Stable(_) => vec![origin, (farthest, 0.0)],
        Gait::Steered(steered) => {
            let all = steered.path.iter().map(|[x, y]| {
                // A line without an end is drawn as far as the robot came.
                let far = x.hypot(*y);
                let part = if steered.path.len() == 1 {
                    (farthest / far).min(1.0)
                } else {
                    1.0
                };
                (part * x, part * y)
            });
            std::iter::once(origin).chain(all).collect()
        }
    }
}
