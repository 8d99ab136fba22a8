//! Steps under error control, each ending on the first event within it.

use saltus_numeric::dop853::step_factor;
use saltus_numeric::root::past_root;

use super::guards::{Guard, trails};
use super::{BACK_AGAIN, HAIR, JUST_LEFT, Sim, Watch};
use crate::SimError;

/// Times that a step is halved in search of where a force comes and goes.
const HALVINGS: u32 = 6;

impl Sim<'_> {
    /// One step, or the part of one that ends at an event, which then happens.
    pub(super) fn advance(
        &mut self,
        until: f64,
        watches: &[Watch<'_>],
    ) -> Result<Option<usize>, SimError> {
        if self.steps >= self.settings.most_steps {
            return Err(SimError::TooManySteps {
                time: self.time,
                limit: self.settings.most_steps,
            });
        }
        let stop = self.commands.last().map_or(until, |c| c.0.min(until));
        let room = stop - self.time;
        self.start_step();
        // A foot that leaves and is back by round-off, again and again, is given a hair to leave by.
        let hair = if self.burst.1 > BACK_AGAIN { HAIR } else { 0.0 };
        self.floors.clear();
        self.floors.extend((0..self.mode.contacts.len()).map(|c| {
            let gap = self.machine.lie(c).gap;
            if gap < JUST_LEFT { gap - hair } else { 0.0 }
        }));
        let before = self.guard_values(self.time, watches, false);
        let (h, after) = self.controlled_step(room, watches)?;
        self.steps += 1;
        let first = after
            .iter()
            .find(|(_, value)| *value < 0.0 || value.is_nan())
            .copied();
        let Some((guard, _)) = first else {
            self.accept(self.time + h, h == room, stop);
            return Ok(None);
        };
        let (guard, h) = self.locate(guard, h, &before, watches);
        self.accept(self.time + h, false, stop);
        // The projection has left its own impulses where the event looks for forces.
        self.machine.look(&self.y, &self.mode);
        self.happen(guard)
    }

    /// The longest step within the tolerance and `room` (s), into `next`, and the guards at its
    /// end.
    fn controlled_step(
        &mut self,
        room: f64,
        watches: &[Watch<'_>],
    ) -> Result<(f64, Vec<(Guard, f64)>), SimError> {
        let mut h = self.step.min(self.settings.longest_step);
        // A step that would leave a sliver takes it along.
        if room < h * (1.0 + 1e-9) {
            h = room;
        }
        let mut halvings = 0;
        let mut whole = 0.0_f64;
        loop {
            self.machine.least_hold = f64::INFINITY;
            let error = self.try_step(h);
            if error.is_nan() || error > 1.0 {
                self.step = h * step_factor(error);
                if self.step < 1e-15 * (1.0 + self.time.abs()) {
                    return Err(SimError::Stuck {
                        time: self.time,
                        step: self.step,
                    });
                }
                h = self.step;
                continue;
            }
            let after = self.guard_values(self.time + h, watches, true);
            // A force that is gone only for a part of the step: a shorter step ends there.
            let dips = self.machine.least_hold < -self.machine.nothing
                && after.iter().all(|(_, value)| *value >= 0.0);
            if dips && halvings < HALVINGS {
                whole = whole.max(h);
                (h, halvings) = (0.5 * h, halvings + 1);
                continue;
            }
            self.step = (h * step_factor(error)).max(self.step.min(h));
            if h < room {
                self.step = (h * step_factor(error)).max(whole);
            }
            return Ok((h, after));
        }
    }

    /// The derivative at the start of a step.
    pub(super) fn start_step(&mut self) {
        self.evaluations += 1;
        self.machine
            .derivative(&self.y, &self.mode, self.stages.start());
    }

    /// Steps by `h` into `next`; the error.
    pub(super) fn try_step(&mut self, h: f64) -> f64 {
        let (machine, mode) = (&mut self.machine, &self.mode);
        // What is kept account of must be as good as the motion.
        let checked = if self.layout.accounts > 0 {
            self.layout.size()
        } else {
            self.layout.works()
        };
        self.evaluations += 11;
        let f = |y: &[f64], dy: &mut [f64]| machine.derivative(y, mode, dy);
        self.stages.step(
            f,
            &self.y,
            h,
            (checked, self.settings.tolerance),
            &mut self.next,
        )
    }

    pub(super) fn accept(&mut self, time: f64, is_stop: bool, stop: f64) {
        std::mem::swap(&mut self.y, &mut self.next);
        self.machine
            .mechanism
            .tree
            .normalize(&mut self.y[..self.layout.coordinates]);
        self.time = if is_stop { stop } else { time };
        // Twice what is needed where the machine is already there; it is one evaluation of twelve.
        self.machine.look(&self.y, &self.mode);
        self.machine.project(&mut self.y, &self.mode);
    }

    /// The first guard that is violated on the way to `h`, and when: `next` is left there.
    pub(super) fn locate(
        &mut self,
        mut guard: Guard,
        mut h: f64,
        before: &[(Guard, f64)],
        watches: &[Watch<'_>],
    ) -> (Guard, f64) {
        loop {
            h = self.root(guard, h, before, watches);
            // Another may have come first.
            let values = self.guard_values(self.time + h, watches, true);
            let other = values
                .iter()
                .find(|(g, value)| *value < 0.0 && *g != guard && !trails(*g, before));
            match other {
                Some(&(other, _)) if h > 0.0 => {
                    let earlier = self.root(other, h, before, watches);
                    if earlier >= h {
                        return (guard, h);
                    }
                    (guard, h) = (other, earlier);
                    self.try_step(h);
                    let values = self.guard_values(self.time + h, watches, true);
                    if values.iter().all(|(g, value)| *value >= 0.0 || *g == guard) {
                        return (guard, h);
                    }
                }
                _ => return (guard, h),
            }
        }
    }

    /// When, within the step of `h`, `guard` comes to 0; just past it. `next` is left there.
    pub(super) fn root(
        &mut self,
        guard: Guard,
        h: f64,
        before: &[(Guard, f64)],
        watches: &[Watch<'_>],
    ) -> f64 {
        let value = |sim: &mut Self, s: f64| {
            sim.try_step(s);
            let values = sim.guard_values(sim.time + s, watches, true);
            values
                .iter()
                .find(|(g, _)| *g == guard)
                .map_or(f64::NAN, |v| v.1)
        };
        let start = before
            .iter()
            .find(|(g, _)| *g == guard)
            .map_or(f64::NAN, |v| v.1);
        let (mut a, mut fa) = (0.0, start);
        let (mut b, mut fb) = (h, value(self, h));
        // A guard that starts at 0 and comes back has its root inside: look for where it is well
        // above 0.
        if fa <= 0.0 || fa.is_nan() {
            let mut s = h;
            for _ in 0..24 {
                s *= 0.5;
                let f = value(self, s);
                if f > 0.0 {
                    (a, fa) = (s, f);
                    break;
                }
                (b, fb) = (s, f);
            }
            if fa <= 0.0 || fa.is_nan() {
                value(self, b);
                return b;
            }
        }
        // To round-off, or where that would not be seen: but a foot that comes to stand must have
        // come to.
        let finest = 2.0 * f64::EPSILON * (self.time.abs() + h);
        let resolution = match guard {
            Guard::SlipEnd(..) => finest,
            _ => finest.max(1e-3 * self.settings.tolerance * h),
        };
        let b = past_root((a, fa), (b, fb), resolution, |s| value(self, s));
        value(self, b);
        b
    }
}
