//! How legs that were fired go out and come home, as they are believed to.

use std::collections::BTreeMap;

use super::cutter::{AROUND, Cutter};
use super::out::{Fired, Out, STEP};
use super::track::{Firing, Track, Window};
use crate::rig::Others;

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
