//! What the command keeps of a run as it goes, in a memory that does not grow with it.

use std::collections::VecDeque;

use saltus::gait::{Footfall, Logger, Obstacle, Row, Run, Setup};
use saltus::recording::Running;

use super::held::Held;
use super::recorder::Recorder;
use super::rows::{Columns, Rows};
use super::telemetry::Telemetry;
use crate::cli::film::Film;
use crate::interrupt::Interrupt;
use crate::output::Stream;
use crate::progress::Progress;

/// A leg is out beyond this extension (m).
pub(super) const OUT: f64 = 1e-3;
/// Time (s) over which the speed is a mean, as in the library's summary.
const MEAN: f64 = 0.15;
/// Most points of a line of a plot.
const MOST_POINTS: usize = 4000;

/// Follows a run.
#[derive(Debug)]
pub(super) struct Follower<'a> {
    pub(super) kept: Kept,
    pub(super) line: Option<Thinned>,
    pub(super) last: Option<Last>,
    pub(super) stalls: Stalls,
    /// Commanded speeds.
    pub(super) held: Vec<Held>,
    /// Boxes on the way.
    pub(super) boxes: Vec<OnTheWay>,
    /// Touch-downs of legs that were still out.
    pub(super) out_at_touch_down: usize,
    interrupt: &'a Interrupt,
    progress: &'a Progress,
    speed: Speed,
    told: f64,
}

/// What is written of a run.
#[derive(Debug, Default)]
pub(super) struct Kept {
    pub(super) rows: Option<Rows>,
    pub(super) telemetry: Option<(Telemetry, Logger)>,
    pub(super) film: Option<Film>,
    pub(super) recorder: Option<Recorder<Running<Stream>>>,
}

/// The last cycle.
#[derive(Clone, Debug)]
pub(super) struct Last {
    pub(super) time: f64,
    pub(super) leg: u32,
    pub(super) lean: f64,
    pub(super) rate: f64,
    /// None where no leg was to fire.
    pub(super) firing_angle: Option<f64>,
    pub(super) extensions: Vec<f64>,
}

/// How often it stood still, and since when and where the first time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Stalls {
    pub(super) count: usize,
    pub(super) first: Option<[f64; 2]>,
    now: bool,
}

/// A box, and what the axle did above it.
#[derive(Clone, Debug)]
pub(super) struct OnTheWay {
    pub(super) obstacle: Obstacle,
    /// A wheel's radius (m).
    radius: f64,
    /// When the axle was first above it (s), and its greatest height there (m).
    pub(super) over: Option<[f64; 2]>,
    /// When the axle was a radius behind it (s).
    pub(super) passed: Option<f64>,
}

impl OnTheWay {
    pub(super) fn all(setup: &Setup) -> Vec<OnTheWay> {
        let one = |obstacle: &Obstacle| OnTheWay {
            obstacle: *obstacle,
            radius: setup.robot.body.radius,
            over: None,
            passed: None,
        };
        setup.obstacles.iter().map(one).collect()
    }

    fn note(&mut self, row: &Row<'_>) {
        let [travel, up] = row.axle;
        let back = self.obstacle.front + self.obstacle.length;
        if (self.obstacle.front..=back).contains(&travel) {
            let [_, highest] = self.over.get_or_insert([row.time, up]);
            *highest = highest.max(up);
        }
        if travel >= back + self.radius {
            self.passed.get_or_insert(row.time);
        }
    }
}

/// The speed (m/s) as a mean.
#[derive(Clone, Debug)]
pub(super) struct Speed {
    travels: VecDeque<f64>,
    window: usize,
    span: f64,
}

impl Speed {
    pub(super) fn new(period: f64) -> Speed {
        // A window of whole cycles, at least one; a period is above 0.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let window = ((MEAN / period).round() as usize).max(1);
        Speed {
            travels: VecDeque::new(),
            window,
            span: window as f64 * period,
        }
    }

    fn at(&mut self, travel: f64) -> f64 {
        if self.travels.len() > self.window {
            self.travels.pop_front();
        }
        self.travels.push_back(travel);
        (travel - self.travels[0]) / self.span
    }
}

/// Some of the cycles, evenly spaced: time (s), wheel angle (rad), rate (rad/s), firing angle (rad, NaN
/// where no leg was to fire), speed (m/s).
#[derive(Clone, Debug)]
pub(super) struct Thinned {
    pub(super) points: Vec<[f64; 5]>,
    every: usize,
    cycle: usize,
}

impl Thinned {
    pub(super) fn new() -> Thinned {
        Thinned {
            points: Vec::new(),
            every: 1,
            cycle: 0,
        }
    }

    fn push(&mut self, point: [f64; 5]) {
        if self.cycle.is_multiple_of(self.every) {
            if self.points.len() == MOST_POINTS {
                let mut k = 0;
                self.points.retain(|_| {
                    k += 1;
                    k % 2 == 1
                });
                self.every *= 2;
            }
            if self.cycle.is_multiple_of(self.every) {
                self.points.push(point);
            }
        }
        self.cycle += 1;
    }
}

impl<'a> Follower<'a> {
    pub(super) fn new(
        period: f64,
        interrupt: &'a Interrupt,
        progress: &'a Progress,
    ) -> Follower<'a> {
        Follower {
            kept: Kept::default(),
            line: None,
            last: None,
            stalls: Stalls::default(),
            held: Vec::new(),
            boxes: Vec::new(),
            out_at_touch_down: 0,
            interrupt,
            progress,
            speed: Speed::new(period),
            told: 0.0,
        }
    }

    /// Hands over what was written.
    pub(super) fn kept(&mut self) -> Kept {
        std::mem::take(&mut self.kept)
    }

    fn look(&mut self, row: &Row<'_>) {
        let action = &row.action;
        let last = self.last.get_or_insert_with(|| Last {
            time: 0.0,
            leg: 0,
            lean: 0.0,
            rate: 0.0,
            firing_angle: None,
            extensions: row.extensions.to_vec(),
        });
        last.extensions.copy_from_slice(row.extensions);
        last.time = row.time;
        last.leg = action.in_zone;
        last.lean = action.lean;
        last.rate = action.rate;
        last.firing_angle = row.firing_angle();
        if row.stands && !self.stalls.now {
            self.stalls.count += 1;
            self.stalls.first.get_or_insert([row.time, row.axle[0]]);
        }
        self.stalls.now = row.stands;
    }
}

impl Run for Follower<'_> {
    fn row(&mut self, row: &Row<'_>) {
        self.look(row);
        let (time, travel) = (row.time, row.axle[0]);
        let speed = self.speed.at(travel);
        self.held
            .iter_mut()
            .for_each(|held| held.note(time, travel));
        self.boxes.iter_mut().for_each(|it| it.note(row));
        if let Some(rows) = &mut self.kept.rows {
            rows.line(|line| Columns::Motion.write(row, line));
        }
        if let Some((telemetry, logger)) = &mut self.kept.telemetry {
            telemetry.cycle(|line| Columns::Telemetry.write(row, line));
            logger.log(row, |time, values| telemetry.measured(time, values));
        }
        if let Some(line) = &mut self.line {
            let action = &row.action;
            let angle = row.firing_angle().unwrap_or(f64::NAN);
            line.push([row.time, row.lean, action.rate, angle, speed]);
        }
        if let Some(film) = &mut self.kept.film {
            film.push(row, speed);
        }
        if let Some(recorder) = &mut self.kept.recorder {
            recorder.add(|running| running.row(row));
        }
        if row.time >= self.told + 1.0 {
            self.told += 1.0;
            self.progress.advance(1);
        }
    }

    fn footfall(&mut self, footfall: &Footfall) {
        let extensions = self.last.as_ref().map(|last| &last.extensions);
        let extension = extensions.and_then(|all| all.get(footfall.leg));
        self.out_at_touch_down += usize::from(extension.is_some_and(|x| *x > OUT));
        if let Some(film) = &mut self.kept.film {
            film.touch_down(footfall);
        }
        if let Some(recorder) = &mut self.kept.recorder {
            recorder.add(|running| running.footfall(footfall));
        }
    }

    fn asks_contacts(&mut self, _: f64) -> bool {
        self.kept.recorder.is_some() || self.kept.film.as_ref().is_some_and(Film::is_due)
    }

    fn goes_on(&mut self) -> bool {
        let kept = &self.kept;
        let telemetry = kept.telemetry.as_ref().map(|(telemetry, _)| telemetry);
        !self.interrupt.came()
            && kept.rows.as_ref().is_none_or(Rows::is_open)
            && telemetry.is_none_or(Telemetry::is_open)
            && kept.recorder.as_ref().is_none_or(Recorder::is_open)
    }
}
