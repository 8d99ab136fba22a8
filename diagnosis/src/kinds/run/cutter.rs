//! Strides are found: where each begins and ends, or why it cannot be read.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use saltus_robot::Robot;

use super::out::Out;
use super::track::{Firing, MARGIN, Track, Window, measured};
use super::unfit::Unfit;
use crate::experiment::{Experiment, Run, Sort};
use crate::noise;
use crate::spec::Problem;

/// Least time (s) of a stride after its command: the valve's delay, and some extension.
const SEEN: f64 = 0.04;
/// Longest stride (s) after its command, and before it.
const LONGEST: f64 = 0.6;
const BEFORE: f64 = 0.3;
/// Time (s) about a firing that says which way the wheel turns.
pub(super) const AROUND: f64 = 0.01;
/// Height (m) that counts as none, whatever the instruments.
const NEAR: f64 = 2e-3;

/// What is believed of the robot, and what its instruments can tell.
pub(super) struct Cutter<'a> {
    pub(super) experiment: &'a Experiment,
    pub(super) robot: &'a Robot,
    /// The columns of the wheel's angle, and of the pivot or the height.
    pub(super) wheel: usize,
    pub(super) above: usize,
    /// Length of the boom (m), where it is the pivot.
    pub(super) arm: Option<f64>,
    /// Height (m) that counts as none.
    pub(super) near: f64,
    /// For each state in which a leg is fired how it goes out and comes home.
    pub(super) out: BTreeMap<[i64; 4], Out>,
}

impl<'a> Cutter<'a> {
    pub(super) fn new(experiment: &'a Experiment, robot: &'a Robot) -> Result<Cutter<'a>, Problem> {
        let column = |name: &str| experiment.columns.iter().position(|own| own == name);
        let none = || Problem::NoHeight;
        let wheel = column("wheel_angle_rad").ok_or_else(none)?;
        let pivot = column("pivot_angle_rad");
        if let (Some(_), None) = (pivot, robot.boom) {
            return Err(Problem::NoBoom {
                robot: robot.name.clone(),
                column: "pivot_angle_rad".into(),
            });
        }
        let above = pivot.or(column("y_m")).ok_or_else(none)?;
        let arm = robot
            .boom
            .filter(|_| pivot.is_some())
            .map(|boom| boom.length);
        let noise = noise::channels(experiment, &[above])[0].noise * arm.unwrap_or(1.0);
        Ok(Cutter {
            experiment,
            robot,
            wheel,
            above,
            arm,
            near: NEAR + 2.0 * noise,
            out: BTreeMap::new(),
        })
    }

    /// The strides of all runs as an experiment of kind jump.
    pub(super) fn experiment(&self, runs: Vec<Run>) -> Experiment {
        let own = self.experiment;
        let of = |all: &[Option<f64>]| measured(own).map(|k| all[k]).collect();
        Experiment {
            kind: Sort::Jump,
            mechanism: None,
            columns: measured(own).map(|k| own.columns[k].clone()).collect(),
            noise: of(&own.noise),
            resolution: of(&own.resolution),
            runs,
        }
    }

    /// What is measured in `run`.
    ///
    /// # Errors
    /// [`Problem::Wraps`] where the wheel's angle begins anew.
    pub(super) fn track(&self, run: &Run) -> Result<Track<'a>, Problem> {
        let mut track = Track {
            experiment: self.experiment,
            time: Vec::new(),
            wheel: Vec::new(),
            height: Vec::new(),
        };
        let mut last: Option<(f64, f64)> = None;
        for (row, &time) in run.time.iter().enumerate() {
            let wheel = run.values[self.wheel][row];
            if wheel.is_nan() {
                continue;
            }
            // Faster than any wheel turns.
            let most = PI.max(100.0 * last.map_or(0.0, |(before, _)| time - before));
            if let Some((_, before)) = last.filter(|(_, w)| (wheel - w).abs() > most) {
                return Err(Problem::Wraps {
                    run: run.name.clone(),
                    time,
                    before,
                    after: wheel,
                });
            }
            last = Some((time, wheel));
            let height = self.height(run.values[self.above][row]);
            if height.is_finite() {
                track.time.push(time);
                track.wheel.push(wheel);
                track.height.push(height);
            }
        }
        Ok(track)
    }

    /// Height (m) of the axle.
    pub(super) fn height(&self, measured: f64) -> f64 {
        match self.arm {
            Some(arm) => self.robot.body.radius + arm * measured.sin(),
            None => measured,
        }
    }

    pub(super) fn pitch(&self) -> f64 {
        TAU / f64::from(self.robot.body.legs)
    }

    /// Lean (rad) of `leg` in a row, within half a turn.
    pub(super) fn lean(&self, track: &Track<'_>, row: usize, leg: usize) -> f64 {
        let lean = track.wheel[row] - leg as f64 * self.pitch();
        lean - TAU * (lean / TAU).round()
    }

    /// Height (m) of the foot of `leg` above the ground in a row, the leg out by `d` (m).
    pub(super) fn clearance(&self, track: &Track<'_>, row: usize, leg: usize, d: f64) -> f64 {
        let foot = self.robot.foot.radius;
        let length = self.robot.body.radius - foot + d;
        track.height[row] - length * self.lean(track, row, leg).cos() - foot
    }
}

impl Cutter<'_> {
    /// The stride of firing `k`. `drift` is the lean at which legs fire, as the wheel's encoder has
    /// it: it may drift by more than half a turn where its scale is wrong.
    pub(super) fn stride(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        k: usize,
        drift: &mut f64,
    ) -> Result<Window, Unfit> {
        let firing = firings[k];
        let at = track.row(firing.open);
        let (early, late) = (
            track.row(firing.open - AROUND),
            track.row(firing.open + AROUND),
        );
        if early == 0 || late + 1 >= track.time.len() {
            return Err(Unfit::Cut);
        }
        let leg = firing.leg;
        let turned = track.wheel[at] - leg as f64 * self.pitch() - *drift;
        let base = leg as f64 * self.pitch() + TAU * (turned / TAU).round();
        *drift = track.wheel[at] - base;
        if track.wheel[late] <= track.wheel[early] {
            return Err(Unfit::Backwards);
        }
        if self.extensions(track, &firings[..k], firing.open)[leg] > 0.0 {
            return Err(Unfit::NotHome);
        }
        let clear = self.clear(track, &firings[..k], leg, (at, firing))?;
        let (from, air) = self.begin(track, leg, clear, (at, firing))?;
        let to = self.end(track, firings, leg, (at, firing))?;
        Ok(Window {
            from,
            to,
            base,
            air,
        })
    }

    /// The first row before the firing from which on no other foot can be on the ground, and the leg
    /// itself is home.
    fn clear(
        &mut self,
        track: &Track<'_>,
        before: &[Firing],
        leg: usize,
        (at, firing): (usize, Firing),
    ) -> Result<usize, Unfit> {
        let mut first = at;
        if let Some(why) = self.other(track, before, leg, at) {
            return Err(why);
        }
        while first > 0 && track.time[first - 1] > firing.open - BEFORE {
            let row = first - 1;
            let is_home = self.extensions(track, before, track.time[row])[leg] == 0.0;
            if !is_home || self.other(track, before, leg, row).is_some() {
                return Ok(track.row(track.time[first] + MARGIN).min(at));
            }
            first = row;
        }
        if first == 0 {
            Err(Unfit::Cut)
        } else {
            Ok(first)
        }
    }

    /// Why a leg other than `leg` may be on the ground in a row.
    fn other(
        &mut self,
        track: &Track<'_>,
        before: &[Firing],
        leg: usize,
        row: usize,
    ) -> Option<Unfit> {
        let extensions = self.extensions(track, before, track.time[row]);
        let legs = 0..extensions.len();
        let mut others = legs.filter(|other| *other != leg);
        let touches = |other: usize, d: f64| {
            self.lean(track, row, other).abs() < 0.5 * PI
                && self.clearance(track, row, other, d) < self.near
        };
        others.find_map(|other| {
            if touches(other, 0.0) {
                Some(Unfit::TwoFeet)
            } else if extensions[other] > 0.0 && touches(other, extensions[other]) {
                Some(Unfit::OtherOut)
            } else {
                None
            }
        })
    }

    /// The last row before another foot comes down.
    fn end(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        leg: usize,
        (at, firing): (usize, Firing),
    ) -> Result<usize, Unfit> {
        let again = firings
            .iter()
            .find(|f| f.leg == leg && f.open > firing.open);
        let latest = again
            .map_or(f64::INFINITY, |f| f.open)
            .min(firing.open + LONGEST);
        let mut end = at;
        loop {
            end += 1;
            if end >= track.time.len() {
                return Err(Unfit::Cut);
            }
            let falls = self.clearance(track, end, leg, 0.0) < -2.0 * self.near;
            if track.time[end] >= latest || falls || self.other(track, firings, leg, end).is_some()
            {
                break;
            }
        }
        let last = track.row(track.time[end] - MARGIN);
        if track.time[last] < firing.open + SEEN {
            return Err(Unfit::Short);
        }
        // A leg that pushes in the air tells little of what drives it.
        let stroke = self.robot.leg.stroke;
        let moves = track.row(firing.open + self.robot.leg.delay);
        let deepest = (moves..=last).map(|row| self.clearance(track, row, leg, stroke));
        if deepest.fold(f64::INFINITY, f64::min) > -self.near {
            return Err(Unfit::Misses);
        }
        Ok(last)
    }
}
