//! How legs that were fired go out and come home, as they are believed to.

use std::collections::BTreeMap;

use saltus_robot::Robot;

use super::cutter::{AROUND, Cutter};
use super::track::{Firing, Track, Window};
use crate::rig::{Flight, Others, Rig, Start};

/// A leg that is home by the model may be late by this factor.
const LATE: f64 = 1.2;
/// Time (s) between extensions, and their number.
const STEP: f64 = 2e-3;
const STEPS: u32 = 300;

/// A leg that is fired once, as it is believed to move.
#[derive(Clone, Debug)]
pub(super) struct Out {
    /// How long (s) it is out after its valve shut; infinite where nothing pulls it in.
    after: f64,
    /// Its extension (m) from the command on, a step from each to the next.
    extensions: Vec<f64>,
}

/// The state in which a leg is fired.
#[derive(Clone, Copy, Debug)]
struct Fired {
    /// Lean (rad) of the leg, and its rate (rad/s).
    lean: f64,
    rate: f64,
    /// Height (m) of its foot above the ground.
    above: f64,
}

impl Fired {
    /// In whole steps, with the valve's opening time (0.5 ms).
    fn key(&self, firing: Firing) -> [i64; 4] {
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
    fn new(robot: &Robot, state: &Fired, opening: f64) -> Out {
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

impl Cutter<'_> {
    /// How the leg of `firing` moves: as it is believed to from the state that the robot has as its
    /// valve opens. The faster the wheel turns, the later a leg comes home; the spin may hold it out.
    fn out(&mut self, track: &Track<'_>, firing: Firing) -> &Out {
        let state = self.state(track, firing);
        let key = state.key(firing);
        let robot = self.robot;
        self.out
            .entry(key)
            .or_insert_with(|| Out::new(robot, &state, firing.shut - firing.open))
    }

    /// The state (rounded) in which a leg is fired.
    fn state(&self, track: &Track<'_>, firing: Firing) -> Fired {
        let at = track.row(firing.open).min(track.time.len() - 1);
        let early = track.row(firing.open - AROUND);
        let late = track.row(firing.open + AROUND).min(track.time.len() - 1);
        let over = (track.time[late] - track.time[early]).max(1e-9);
        let slope = |column: &[f64]| (column[late] - column[early]) / over;
        let round = |x: f64, step: f64| (x / step).round() * step;
        let lean = self.lean(track, at, firing.leg);
        let lowest =
            self.robot.foot.radius + (self.robot.body.radius - self.robot.foot.radius) * lean.cos();
        Fired {
            lean: round(lean, 0.05),
            rate: round(slope(&track.wheel), 0.5),
            above: round((track.height[at] - lowest).clamp(0.0, 0.5), 2e-3),
        }
    }

    /// What the legs but that of firing `k` add to the wheel's moment of inertia in a stride.
    pub(super) fn others(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        k: usize,
        window: &Window,
    ) -> Others {
        let (start, end) = (track.time[window.from], track.time[window.to]);
        let body = self.robot.leg.body;
        let mut inertia = Vec::new();
        let mut time = start;
        while time < end + STEP {
            let mut latest: BTreeMap<usize, Firing> = BTreeMap::new();
            let earlier = firings
                .iter()
                .filter(|f| f.open <= time && f.leg != firings[k].leg);
            latest.extend(earlier.map(|f| (f.leg, *f)));
            let mut sum = 0.0;
            for firing in latest.values() {
                let out = &self.out(track, *firing).extensions;
                // An index.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let place = ((time - firing.open) / STEP) as usize;
                let d = out.get(place).or(out.last()).copied().unwrap_or(0.0);
                sum += body.mass * ((body.center + d).powi(2) - body.center.powi(2));
            }
            inertia.push(sum);
            time += STEP;
        }
        Others {
            step: STEP,
            inertia,
        }
    }

    /// How far (m) each leg may be out at `time`.
    pub(super) fn extensions(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        time: f64,
    ) -> Vec<f64> {
        let mut all = vec![0.0; self.robot.body.legs as usize];
        for firing in firings.iter().filter(|f| f.open <= time) {
            let is_out = time < firing.shut + self.out(track, *firing).after;
            if is_out {
                all[firing.leg] = self.robot.leg.stroke;
            }
        }
        all
    }
}
