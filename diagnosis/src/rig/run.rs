//! The motion, step by step: each mode in fixed steps, of which the last ends on the event.

use saltus_pneumatics::{Flow, MEGA, Piece, Switches};

use super::contact::{Answer, Axle, Foot, Modes};
use super::course::{Course, Knot};
use super::fed::{self, Gas};
use super::guard::{Guard, Guards, TINY};
use super::machine::{Coordinates, LEAN, LEG, Machine};
use super::{Rig, Start};

/// Step sizes (s): on soft ground, while the chamber fills, while the leg moves, before it is
/// fired, and in flight. With them the error of a jump is below 1e-6 rad.
const SOFT: f64 = 2.5e-4;
const FILLING: f64 = 3e-3;
pub(super) const FINE: f64 = 1e-3;
const COARSE: f64 = 6e-3;
const FLIGHT: f64 = 1.2e-2;
/// Difference between the inner stages of a step, relative to the gas, above which the step is
/// halved while the leg moves.
const GAS_ERROR: f64 = 3e-4;
/// Error allowed, relative to the pressure, of the cubic between the ends of a step while the rod
/// rests on the bench.
const CUBIC: f64 = 1e-7;
/// Longest and shortest step (s) on the bench.
pub(super) const LONG: f64 = 1.0;
const BRIEF: f64 = 1e-6;

/// What the leg does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Slide {
    /// It has not been fired.
    Latched,
    Held,
    Moves(f64),
}

#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    pub(super) time: f64,
    pub(super) q: Coordinates,
    pub(super) v: Coordinates,
    pub(super) gas: Gas,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Mode {
    pub(super) foot: Foot,
    pub(super) axle: Axle,
    pub(super) leg: Slide,
    /// Whether the drive is on, and whether the leg is in its cushion.
    pub(super) switches: Switches,
    /// When (s) the valve was switched, and how far that of a leg that is fed was open then.
    pub(super) opens: f64,
    pub(super) opening: f64,
    pub(super) port_open: bool,
    pub(super) piece: Option<Piece<f64>>,
    /// The valve supplies a full chamber with what its leak loses, so that the pressure stays.
    pub(super) fed: bool,
}

impl Mode {
    /// The mode before the leg is fired.
    fn new(foot: Foot, axle: Axle, piece: Option<Piece<f64>>) -> Mode {
        Mode {
            foot,
            axle,
            leg: Slide::Latched,
            switches: Switches {
                energized: false,
                cushioned: false,
            },
            opens: 0.0,
            opening: 0.0,
            port_open: false,
            piece,
            fed: false,
        }
    }
}

/// The equations evaluated at a state.
pub(super) struct Look {
    /// Accelerations and forces.
    pub(super) answer: Answer,
    /// Rate of the gas.
    pub(super) rate: Gas,
    /// Dry friction (N) of the leg.
    pub(super) dry: f64,
}

/// A step up to its end, or to the event within it.
struct Step {
    /// Its length (s).
    h: f64,
    next: State,
    last: Look,
    hit: Option<Guard>,
}

pub(super) struct Run<'a> {
    pub(super) rig: &'a Rig,
    /// Longest step (s) while the rod rests on the bench.
    pub(super) rests: f64,
    /// Next step (s) there.
    stride: f64,
    pub(super) state: State,
    pub(super) mode: Mode,
    pub(super) course: Course,
    pub(super) events: usize,
    pub(super) landed: bool,
    /// Whether a foot in the air touches down where it comes to the ground.
    pub(super) touches_down: bool,
}

impl<'a> Run<'a> {
    pub(super) fn new(rig: &'a Rig, start: Start) -> Option<Run<'a>> {
        let machine = &rig.machine;
        let (q, v) = match start {
            Start::Rolling { lean, rate } => machine.stand(lean, rate)?,
            Start::Flying(flight) => Machine::aloft(&flight),
            Start::Rest => machine.stand(0.0, 0.0)?,
        };
        let rate = v[LEAN];
        let lands = matches!(start, Start::Flying(_));
        let (piece, gas) = match (&rig.leg.feed, rig.leg.chamber()) {
            (Some(feed), _) => (None, fed::at_rest(feed)),
            (None, Some(chamber)) => {
                let piece = Piece::new(chamber, false, chamber.ambient, 0.0, false);
                let variable = chamber.variable(piece.flow, chamber.ambient);
                (Some(piece), Gas::new(variable, 0.0, 0.0, 0.0))
            }
            (None, None) => (None, Gas::zeros()),
        };
        let foot = if machine.is_bench() || lands {
            Foot::Flies
        } else {
            Foot::Stands
        };
        let mut run = Run {
            rig,
            rests: LONG,
            stride: FINE,
            state: State {
                time: 0.0,
                q,
                v,
                gas,
            },
            mode: Mode::new(foot, machine.axle_at(rate), piece),
            course: Course {
                boom: machine.boom,
                radius: machine.radius,
                ..Course::default()
            },
            events: 0,
            landed: false,
            touches_down: lands,
        };
        run.record();
        Some(run)
    }

    pub(super) fn record(&mut self) {
        let State { q, v, .. } = self.state;
        let height = self.rig.machine.height(&q, &v);
        let pressure = self.gas(&self.state).map_or((0.0, 0.0), |gas| gas.pressure);
        self.course.knots.push(Knot {
            time: self.state.time,
            q,
            v,
            height,
            pressure,
        });
    }

    pub(super) fn switch(&mut self, energized: bool) {
        if let Some(feed) = &self.rig.leg.feed {
            self.mode.opening = self.command().opening(feed, self.state.time);
        }
        self.mode.switches.energized = energized;
        self.mode.opens = self.state.time;
        self.renew(0.0);
        self.record();
    }

    fn usual_step(&self) -> f64 {
        let opening = self.rig.extra.opening;
        if self.mode.switches.energized && self.state.time < self.mode.opens + opening {
            return (0.25 * opening).clamp(FINE / 16.0, FINE);
        }
        if self.mode.foot != Foot::Flies && self.rig.machine.floor.soft.is_some() {
            return SOFT.min(self.rig.machine.soft_step());
        }
        match self.mode.leg {
            Slide::Latched => COARSE,
            Slide::Held if self.rig.machine.is_bench() => self.stride.min(self.rests),
            Slide::Held if self.mode.foot == Foot::Flies => {
                let is_balanced = |piece: Piece<f64>| piece.flow == Flow::ExhaustBalanced;
                let is_fed = self.rig.leg.feed.is_some();
                let is_empty = !is_fed && self.mode.piece.is_none_or(is_balanced);
                if is_empty { FLIGHT } else { FLIGHT / 3.0 }
            }
            Slide::Held => FILLING,
            Slide::Moves(_) => FINE,
        }
    }

    /// Goes on until the time `end` (s), or if `lands`, until the landing.
    pub(super) fn go(&mut self, end: f64, lands: bool) -> Option<()> {
        let mut known = None;
        let (mut before, mut after) = (Guards::new(), Guards::new());
        while self.state.time < end - 1e-12 && !self.landed {
            let first = match known.take() {
                Some(look) => look,
                None => self.look(&self.state)?,
            };
            self.guard(&self.state, &first, &mut before);
            let broken = |(guard, x): &&(Guard, f64)| guard.is_of_forces() && *x < -TINY;
            if let Some(&(guard, _)) = before.iter().find(broken) {
                self.happen(guard, &first)?;
                continue;
            }
            let (h, next) = self.advance(&first, end - self.state.time)?;
            let step = self.cut(&first, h, next, &before, &mut after)?;
            self.arrive(&step)?;
            if lands && self.mode.foot == Foot::Flies {
                let (height, rate) = self.rig.machine.height(&self.state.q, &self.state.v);
                self.landed = height < self.rig.machine.radius && rate < 0.0;
            }
            if self.state.q[LEAN].abs() > 3.0 && self.mode.foot != Foot::Flies {
                // Fallen over.
                return None;
            }
            known = step.hit.is_none().then_some(step.last);
        }
        Some(())
    }

    /// A step of at most `most` (s) without regard to events: its length (s) and its end.
    fn advance(&mut self, first: &Look, most: f64) -> Option<(f64, State)> {
        let mut h = self
            .usual_step()
            .min(self.rig.machine.longest_step())
            .min(most);
        let mut next = self.step(first, h)?;
        if self.rests() {
            loop {
                let part = self.bend(&next.0)? / CUBIC;
                let longer = 0.8 / part.powf(0.25);
                self.stride = (h * longer.clamp(0.02, 5.0)).clamp(BRIEF, LONG);
                if part <= 1.0 || h <= BRIEF {
                    break;
                }
                h = self.stride;
                next = self.step(first, h)?;
            }
        }
        // A small chamber that is nearly in balance follows faster than the usual step does.
        while matches!(self.mode.leg, Slide::Moves(_)) && next.1 > GAS_ERROR && h > FINE / 16.0 {
            h *= 0.5;
            next = self.step(first, h)?;
        }
        Some((h, next.0))
    }

    /// Cuts the step of `h` (s) to `next` off at the earliest event within it.
    fn cut(
        &self,
        first: &Look,
        h: f64,
        next: State,
        before: &Guards,
        after: &mut Guards,
    ) -> Option<Step> {
        let last = self.look(&next)?;
        self.guard(&next, &last, after);
        let mut step = Step {
            h,
            next,
            last,
            hit: None,
        };
        while let Some(k) =
            (0..after.len()).find(|&k| after[k].1 < 0.0 && Some(after[k].0) != step.hit)
        {
            let guard = after[k].0;
            if before[k].1 < 0.0 && !guard.is_of_forces() && after[k].1 >= before[k].1 {
                after[k].1 = 0.0;
                continue;
            }
            let ends = (before[k].1.max(0.0), after[k].1);
            let earlier = self.locate(first, k, ends, step.h)?;
            if step.hit.is_some() && earlier >= step.h * (1.0 - 1e-9) {
                // At the same instant: one after the other.
                after[k].1 = 0.0;
                continue;
            }
            let next = self.step(first, earlier)?.0;
            step = Step {
                h: earlier,
                next,
                last: self.look(&next)?,
                hit: Some(guard),
            };
            self.guard(&next, &step.last, after);
        }
        Some(step)
    }

    /// Moves to the end of a step, and changes the mode if an event ended it.
    fn arrive(&mut self, step: &Step) -> Option<()> {
        self.state = step.next;
        if step.h > 0.0 {
            self.record();
        }
        if let Some(guard) = step.hit {
            self.happen(guard, &step.last)?;
            // Rates may be others from here on.
            self.record();
        }
        Some(())
    }

    /// Length (s) of the step at whose end guard number `k` is 0: regula falsi (Illinois).
    fn locate(&self, first: &Look, k: usize, ends: (f64, f64), h: f64) -> Option<f64> {
        let (mut a, mut b, mut fa, mut fb) = (0.0, h, ends.0, ends.1);
        if fa == 0.0 {
            return Some(0.0);
        }
        let size = fa.abs().max(fb.abs());
        let mut guards = Guards::new();
        for _ in 0..40 {
            let c = (a * fb - b * fa) / (fb - fa);
            let state = self.step(first, c)?.0;
            let there = self.look(&state)?;
            self.guard(&state, &there, &mut guards);
            let fc = guards.get(k)?.1;
            if fc.abs() <= 1e-10 * size || b - a < 1e-13 {
                return Some(c);
            }
            if fc * fb < 0.0 {
                (a, fa) = (b, fb);
            } else {
                fa *= 0.5;
            }
            (b, fb) = (c, fc);
            if a > b {
                std::mem::swap(&mut a, &mut b);
                std::mem::swap(&mut fa, &mut fb);
            }
        }
        Some(b)
    }

    /// A step of `h` (s) by the classical Runge–Kutta method, whose first stage is given. Also the
    /// difference between its inner stages, relative to the gas.
    fn step(&self, first: &Look, h: f64) -> Option<(State, f64)> {
        let s = &self.state;
        if self.rests() {
            let next = State {
                time: s.time + h,
                gas: self.held_gas(h)?,
                ..*s
            };
            return Some((next, 0.0));
        }
        let at = |v: &Coordinates, k: &Look, h: f64| State {
            time: s.time + h,
            q: s.q + v * h,
            v: s.v + k.answer.acceleration * h,
            gas: s.gas + k.rate * h,
        };
        let a = first;
        let s2 = at(&s.v, a, 0.5 * h);
        let b = self.look(&s2)?;
        let s3 = at(&s2.v, &b, 0.5 * h);
        let c = self.look(&s3)?;
        let s4 = at(&s3.v, &c, h);
        let d = self.look(&s4)?;
        let w = h / 6.0;
        let gas = match self.mode.leg {
            // Held, it does not move what is around it, and may be as stiff as it likes.
            Slide::Held => self.held_gas(h)?,
            _ => s.gas + (a.rate + (b.rate + c.rate) * 2.0 + d.rate) * w,
        };
        let next = State {
            time: s.time + h,
            q: s.q + (s.v + (s2.v + s3.v) * 2.0 + s4.v) * w,
            v: s.v
                + (a.answer.acceleration
                    + (b.answer.acceleration + c.answer.acceleration) * 2.0
                    + d.answer.acceleration)
                    * w,
            gas,
        };
        let is_finite = next.q.iter().chain(next.v.iter()).all(|x| x.is_finite());
        let error =
            |i: usize| h * (c.rate[i] - b.rate[i]).abs() / next.gas[i].abs().max(f64::MIN_POSITIVE);
        let has_gas = self.mode.piece.is_some() || self.rig.leg.feed.is_some();
        (is_finite && (next.gas[0] > 0.0 || !has_gas)).then_some((next, error(0).max(error(1))))
    }

    /// Force (N) along the leg without dry friction, and that friction.
    fn push(&self, s: &State, pressure: f64) -> (f64, f64) {
        let leg = &self.rig.leg;
        let d = s.q[LEG];
        let switches = self.mode.switches;
        let extra = &self.rig.extra;
        let dry = leg.dry_friction(pressure);
        let speed = s.v[LEG];
        let force = leg.force(switches, d, speed, pressure).value - leg.slack_pull(switches, d);
        let push = force + dry - extra.quadratic * speed.abs() * speed;
        (push, (dry + extra.tightening * d).max(0.0))
    }

    /// Evaluates the equations at `s`.
    fn look(&self, s: &State) -> Option<Look> {
        let (pressure, rate) = match self.mode.leg {
            Slide::Latched => (0.0, Gas::zeros()),
            // Its gas goes on apart, and may be stiff.
            Slide::Held if self.rig.leg.feed.is_some() => (s.gas[0] * MEGA, Gas::zeros()),
            _ => self
                .gas(s)
                .map_or((0.0, Gas::zeros()), |gas| (gas.pressure.0, gas.rate)),
        };
        let (push, dry) = match self.mode.leg {
            Slide::Latched => (0.0, 0.0),
            _ => self.push(s, pressure),
        };
        let (force, is_leg_held) = match self.mode.leg {
            Slide::Moves(way) => (push - way * dry, false),
            _ => (push, true),
        };
        let modes = Modes {
            foot: self.mode.foot,
            axle: self.mode.axle,
            is_leg_held,
            others: self.rig.others.at(s.time),
        };
        let answer = self.rig.machine.solve(&s.q, &s.v, force, modes)?;
        Some(Look { answer, rate, dry })
    }
}
