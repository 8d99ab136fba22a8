//! Where a stride begins: on its foot, or in the air before that comes down.

use super::cutter::Cutter;
use super::track::{Firing, MARGIN, Track, Window};
use super::unfit::Unfit;
use crate::experiment::Run;

/// Longest flight (s) with which a stride begins, and the shortest, of so many rows at least.
const FLIES: f64 = 0.05;
const LEAST_FLIGHT: f64 = 0.01;
const LEAST_ROWS: usize = 3;
/// Least time (s) for which a foot stands before its leg is fired, in a stride that begins on it.
const STANDS: f64 = 0.03;
/// Greatest centripetal acceleration of the axle, in terms of gravity along the leg, at which a foot
/// surely stays on the ground: it leaves at 1.
const STAYS: f64 = 0.8;

impl Cutter<'_> {
    /// The row in which a stride begins, and the row up to which the robot is in the air where it
    /// begins there; else it stands.
    pub(super) fn begin(
        &self,
        track: &Track<'_>,
        leg: usize,
        clear: usize,
        (at, firing): (usize, Firing),
    ) -> Result<(usize, Option<usize>), Unfit> {
        let above = |row: usize| self.clearance(track, row, leg, 0.0);
        let flies = |row: usize| above(row) > self.near;
        // The last row in the air before the leg comes down, or before it moves.
        let mut last = at;
        while last > clear && !flies(last) {
            last -= 1;
        }
        let mut first = last;
        while first > clear && flies(first - 1) && track.time[last] - track.time[first] < FLIES {
            first -= 1;
        }
        let is_long = |first: usize| {
            last >= first + LEAST_ROWS && track.time[last] - track.time[first] > LEAST_FLIGHT
        };
        if flies(last) && is_long(first) {
            // Not just after it has left the ground.
            let left = first > clear && !flies(first - 1);
            let first = if left {
                track.row(track.time[first] + MARGIN)
            } else {
                first
            };
            if is_long(first) {
                return Ok((first, Some(last)));
            }
        }
        if flies(at) {
            return Err(Unfit::InTheAir);
        }
        let (touch, down) = if flies(last) {
            let first = last + 1;
            let crossing = self.crossing(track, leg, first);
            (first, crossing.unwrap_or(track.time[first]) + MARGIN)
        } else {
            (clear, track.time[clear])
        };
        let row = track.row(down).max(touch);
        if above(row.min(at)).abs() > self.near || self.lean(track, at, leg).abs() > 1.2 {
            return Err(Unfit::InTheAir);
        }
        if track.time[row] > firing.open - STANDS {
            return Err(Unfit::InTheAir);
        }
        if !self.stays(track, leg, row) {
            return Err(Unfit::Hops);
        }
        Ok((row, None))
    }

    /// Whether the foot of `leg` stays on the ground as the axle rolls over it from a row on: whether
    /// gravity holds the axle on its circle.
    fn stays(&self, track: &Track<'_>, leg: usize, row: usize) -> bool {
        let later = track
            .row(track.time[row] + STANDS)
            .min(track.time.len() - 1);
        let rate = (track.wheel[later] - track.wheel[row]) / (track.time[later] - track.time[row]);
        let held = self.robot.axle_gravity() * self.lean(track, row, leg).cos();
        rate.powi(2) * self.robot.body.radius < STAYS * held
    }

    /// What a window that begins in the air is guessed to begin with: lean and its rate, pivot (or
    /// height) and its rate, rate of the radius angle (or the travel).
    pub(super) fn guess(&self, track: &Track<'_>, run: &Run, window: &Window) -> Option<[f64; 5]> {
        let last = window.air?;
        let start = track.time[window.from];
        let times = start..=track.time[last];
        let column = |name: &str| {
            let k = self.experiment.column(name)?;
            let rows = run.time.iter().zip(&run.values[k]);
            let all: Vec<(f64, f64)> = rows
                .filter(|(t, x)| times.contains(*t) && x.is_finite())
                .map(|(t, x)| (t - start, *x))
                .collect();
            Some(all)
        };
        let line = |points: &[(f64, f64)]| saltus_numeric::statistics::line(points);
        let (rate, wheel) = line(&column("wheel_angle_rad")?)?;
        let name = self.experiment.columns[self.above].as_str();
        // Without the fall, it is a line.
        let fall = 0.5 * self.robot.axle_gravity() / self.arm.unwrap_or(1.0);
        let mut pivot = column(name)?;
        for (t, x) in &mut pivot {
            *x += fall * *t * *t;
        }
        let (climb, above) = line(&pivot)?;
        let reach = self.robot.boom.map_or(1.0, |boom| boom.length);
        let turn = column("radius_angle_rad").or_else(|| column("x_m"));
        let turn = turn.and_then(|points| Some(line(&points)?.0));
        let turn = turn.unwrap_or(rate * self.robot.body.radius / reach);
        Some([wheel - window.base, rate, above, climb, turn])
    }

    /// When (s) a leg that comes down, and is near the ground from row `first` on, is there: where
    /// a line through its last heights comes to 0.
    fn crossing(&self, track: &Track<'_>, leg: usize, first: usize) -> Option<f64> {
        let above: Vec<(f64, f64)> = (0..first)
            .rev()
            .map(|row| (track.time[row], self.clearance(track, row, leg, 0.0)))
            .take_while(|(_, height)| *height > 0.0 && *height < 10.0 * self.near)
            .take(40)
            .collect();
        if above.len() < 3 {
            return None;
        }
        let (slope, level) = saltus_numeric::statistics::line(&above)?;
        let crossing = -level / slope;
        let late = crossing - track.time[first];
        (slope < 0.0 && (-0.01..0.03).contains(&late)).then_some(crossing)
    }
}
