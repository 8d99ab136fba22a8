//! Steps of fixed length.

use saltus_numeric::root::past_root;
use saltus_pneumatics::{Chamber, Feed, Held, Leg, MEGA, Piece};

use super::guards::Guard;
use super::{Happening, Sim, Watch};
use crate::SimError;
use crate::complementarity::Grip;
use crate::feeding::{self, Line, gas_of, put_gas, put_tank, tank_of};
use crate::gas::{Gas, Path};
use crate::machine::{Layout, Owner, STANDING};
use crate::mode::{JointMode, Stop};
use crate::spatial::Vec3;

/// Room for fixed steps, and what one hands to the next.
#[derive(Clone, Debug)]
pub(super) struct Fixed {
    /// Step (s).
    h: f64,
    /// When the present step ends (s), and into how many parts events have cut it.
    end: f64,
    cuts: usize,
    /// Mean acceleration of the last part, all velocities; none after a jump.
    acceleration: Vec<f64>,
    is_known: bool,
    /// How long that part was (s).
    span: f64,
    /// That of the part being tried.
    next_acceleration: Vec<f64>,
    middle: Vec<f64>,
    /// The chambers' pieces at the start.
    pieces: Vec<Option<Piece<f64>>>,
    /// Mean velocities, and the rates of the coordinates.
    mean: Vec<f64>,
    rates: Vec<f64>,
    /// Watches at the start.
    watched: Vec<f64>,
    /// What the gas of each leg has moved in the step: [`Line::moved`], [`Gas::moved`].
    moved: Vec<[f64; 3]>,
    /// The ground's impulses (N s) on points since they were asked for, where somebody asks.
    pub(super) impulses: Option<Vec<(usize, Vec3)>>,
}

/// Events that may cut a step; later ones happen at its end.
const CUTS: usize = 8;
/// Part of the ambient pressure by which that of a chamber at rest may differ.
const RESTS: f64 = 1e-9;
/// Contacts that part more slowly (m/s) stay closed: it may be what is left of a step's error.
const PARTING: f64 = 1e-6;
/// A coordinate or velocity beyond this diverges.
const BOUND: f64 = 1e9;

impl Fixed {
    pub(super) fn new(h: f64, layout: Layout) -> Fixed {
        Fixed {
            h,
            end: 0.0,
            cuts: 0,
            acceleration: vec![0.0; layout.velocities],
            is_known: false,
            span: 0.0,
            next_acceleration: vec![0.0; layout.velocities],
            middle: vec![0.0; layout.size()],
            pieces: vec![None; layout.legs],
            mean: vec![0.0; layout.velocities],
            rates: vec![0.0; layout.coordinates],
            watched: Vec::new(),
            moved: vec![[0.0; 3]; layout.legs],
            impulses: None,
        }
    }

    /// Forgets the acceleration, which has jumped.
    pub(super) fn forget(&mut self) {
        self.is_known = false;
    }
}

impl Sim<'_> {
    /// One fixed step, or the part of one that ends at an event, which then happens.
    pub(super) fn advance_fixed(
        &mut self,
        fixed: &mut Fixed,
        until: f64,
        watches: &[Watch<'_>],
    ) -> Result<Option<usize>, SimError> {
        let sliver = 1e-9 * fixed.h;
        if fixed.end <= self.time + sliver {
            (fixed.end, fixed.cuts) = (self.time + fixed.h, 0);
        }
        let stop = self.commands.last().map_or(until, |c| c.0.min(until));
        // A step that would leave a sliver takes it along.
        let is_stop = stop <= fixed.end + sliver;
        let end = if is_stop { stop } else { fixed.end };
        let h = end - self.time;
        self.steps += 1;
        fixed
            .pieces
            .iter_mut()
            .zip(&self.mode.legs)
            .for_each(|(kept, leg)| *kept = leg.piece);
        fixed.watched.clear();
        let (q, v) = (self.layout.q(&self.y), self.layout.v(&self.y));
        fixed
            .watched
            .extend(watches.iter().map(|watch| watch(self.time, q, v)));
        self.try_fixed(fixed, h)?;
        let found = self.first_crossed(fixed, h, watches)?;
        let Some((guard, at)) = found else {
            self.accept_fixed(fixed, h);
            self.time = end;
            return Ok(None);
        };
        if at > 0.0 {
            self.accept_fixed(fixed, at);
            self.time = if at < h { self.time + at } else { end };
        } else {
            self.restore(fixed);
        }
        fixed.cuts += 1;
        if !matches!(guard, Guard::Watch(_)) {
            fixed.is_known = false;
        }
        self.happen(guard)
    }

    /// Puts the chambers back on the pieces of the start.
    fn restore(&mut self, fixed: &Fixed) {
        fixed
            .pieces
            .iter()
            .zip(&mut self.mode.legs)
            .for_each(|(kept, leg)| leg.piece = *kept);
    }

    /// Steps by `h` into `next`, and leaves the machine half way.
    fn try_fixed(&mut self, fixed: &mut Fixed, h: f64) -> Result<(), SimError> {
        // In a short part an impulse is a great acceleration, which tells nothing of a longer one.
        fixed.is_known &= fixed.span >= 0.5 * h;
        if !fixed.is_known {
            fixed.acceleration.fill(0.0);
        }
        let mut folds = true;
        // Joints that turn back and legs that are let go of change who takes part, each once; so do
        // joints that rested.
        for _ in 0..3 + 2 * self.mode.joints.len() {
            self.restore(fixed);
            self.go_half_way(fixed, h);
            self.evaluations += 1;
            let (machine, mode) = (&mut self.machine, &self.mode);
            let way = (&fixed.middle[..], &fixed.acceleration[..]);
            machine.assemble_step(&self.y, way, mode, h, folds);
            if !machine.sound {
                return Err(SimError::Diverged {
                    time: self.time,
                    step: h,
                });
            }
            if self.pick_up_slack_legs() {
                fixed.acceleration.fill(0.0);
                fixed.is_known = false;
                continue;
            }
            let machine = &mut self.machine;
            if machine.problem.rows > 0 && !machine.problem.resolve_step() {
                return Err(self.inconsistent());
            }
            machine.step_acceleration(h, &mut fixed.next_acceleration);
            if folds && !machine.stay(&self.mode, h) {
                folds = false;
                continue;
            }
            if self.revise(fixed, h) {
                fixed.acceleration.fill(0.0);
                fixed.is_known = false;
                continue;
            }
            if fixed.is_known {
                break;
            }
            fixed.acceleration.copy_from_slice(&fixed.next_acceleration);
            (fixed.is_known, fixed.span) = (true, h);
        }
        self.finish_step(fixed, h)
    }

    /// The state in the middle of the step, the gas there included.
    fn go_half_way(&mut self, fixed: &mut Fixed, h: f64) {
        let layout = self.layout;
        let tree = &self.machine.mechanism.tree;
        let (q, v) = (layout.q(&self.y), layout.v(&self.y));
        for (k, a) in fixed.acceleration.iter().enumerate() {
            fixed.mean[k] = v[k] + 0.25 * h * a;
            fixed.middle[layout.coordinates + k] = v[k] + 0.5 * h * a;
        }
        tree.coordinate_rates(q, &fixed.mean, &mut fixed.rates);
        for (i, rate) in fixed.rates.iter().enumerate() {
            fixed.middle[i] = q[i] + 0.5 * h * rate;
        }
        fixed.moved.fill([0.0; 3]);
        if layout.fed {
            let acceleration = std::mem::take(&mut fixed.acceleration);
            let gas = layout.gas()..layout.works();
            fixed.middle[gas.clone()].copy_from_slice(&self.y[gas]);
            let (middle, moved) = (&mut fixed.middle, &mut fixed.moved);
            self.feed((middle, moved), &acceleration, (0.0, 0.5 * h));
            fixed.acceleration = acceleration;
            return;
        }
        for leg in 0..layout.legs {
            let at = layout.gas() + leg;
            fixed.middle[at] = self.y[at];
            let path = self.path_of(leg, &fixed.acceleration);
            fixed.middle[at] = self.fill(leg, (self.y[at], &mut fixed.moved[leg]), &path, 0.5 * h);
        }
    }

    /// How leg `leg` moves from the start of the step.
    fn path_of(&self, leg: usize, acceleration: &[f64]) -> Path {
        let tree = &self.machine.mechanism.tree;
        let body = self.machine.mechanism.legs[leg].body;
        let k = tree.velocity_of(body);
        Path {
            extension: self.y[tree.coordinate_of(body)],
            speed: self.y[self.layout.coordinates + k],
            acceleration: acceleration[k],
        }
    }

    /// u of the chamber of `leg`, now `u`, after `h` of `path`; its piece moves along, and what its gas
    /// moves is added to `moved`.
    fn fill(&mut self, leg: usize, (u, moved): (f64, &mut [f64; 3]), path: &Path, h: f64) -> f64 {
        let part = &self.machine.mechanism.legs[leg];
        let state = &mut self.mode.legs[leg];
        let (Some(chamber), Some(piece)) = (part.leg.chamber(), state.piece) else {
            return u;
        };
        if self.mode.joints[part.body] == JointMode::Latched {
            return u;
        }
        let mut gas = Gas {
            piece,
            u,
            energized: state.energized,
            port_open: state.port_open,
            moved: self.layout.account(leg).map(|_| *moved),
        };
        let is_still = !gas.energized && path.speed == 0.0 && path.acceleration == 0.0;
        if is_still && self.at_rest[leg] == u {
            return u;
        }
        gas.advance(chamber, path, h);
        if is_still && (gas.u - u).abs() <= f64::EPSILON * u {
            self.at_rest[leg] = gas.u;
        }
        state.piece = Some(gas.piece);
        *moved = gas.moved.unwrap_or(*moved);
        gas.u
    }

    /// Puts into the accounts at the end of the step what the gas of the legs has moved, which the
    /// rates in the middle of a step tell roughly alone: the gas goes on in sub-steps.
    fn account_gas(&mut self, fixed: &Fixed) {
        let layout = self.layout;
        for (leg, moved) in fixed.moved.iter().enumerate() {
            let part = &self.machine.mechanism.legs[leg].leg;
            let Some(at) = layout.account(leg) else {
                continue;
            };
            let at = layout.works() + at;
            let per_mass = part.chamber().map_or(1.0, Chamber::pressure_per_mass);
            self.next[at + 2] = self.y[at + 2] + per_mass * moved[0];
            self.next[at + 3] = self.y[at + 3] + per_mass * moved[1];
            self.next[at + 4] = self.y[at + 4] + moved[2];
        }
    }

    /// Goes on with the gas of fed legs in a state, and with what it moves, from `from` into the step
    /// for `h` (s).
    fn feed(
        &self,
        (to, moved): (&mut [f64], &mut [[f64; 3]]),
        acceleration: &[f64],
        (from, h): (f64, f64),
    ) {
        let (layout, mechanism) = (self.layout, self.machine.mechanism);
        let Some(shared) = mechanism.feed() else {
            return;
        };
        let now = to[layout.clock()];
        let legs: Vec<(usize, &Feed<f64>, Path)> = (0..layout.legs)
            .filter_map(|leg| {
                let feed = mechanism.legs[leg].leg.feed.as_ref()?;
                let path = self.path_of(leg, acceleration).from(from);
                self.flows(leg, feed, &path, to)
                    .then_some((leg, feed, path))
            })
            .collect();
        let openings: Vec<_> = legs
            .iter()
            .map(|&(leg, feed, _)| {
                let state = &self.mode.legs[leg];
                move |t: f64| state.spool.opening(feed, state.energized, now + t)
            })
            .collect();
        let mut lines: Vec<Line<'_>> = legs
            .iter()
            .zip(&openings)
            .map(|(&(leg, feed, path), opening)| Line {
                feed,
                held: gas_of(layout, feed, leg, to),
                path,
                opening,
                port_open: self.mode.legs[leg].port_open,
                moved: moved[leg],
            })
            .collect();
        let mut tank = tank_of(layout, shared, to);
        if lines.is_empty() {
            tank = shared.tank_after(tank, [0.0; 2], h);
        }
        feeding::advance(&mut lines, &mut tank, h);
        let after: Vec<(Held<f64>, [f64; 3])> =
            lines.iter().map(|line| (line.held, line.moved)).collect();
        for (&(leg, feed, _), (held, gone)) in legs.iter().zip(after) {
            put_gas(layout, feed, leg, held, to);
            moved[leg] = gone;
        }
        put_tank(layout, shared, tank, to);
        to[layout.clock()] = now + h;
    }

    /// Whether gas flows to or from the chamber of leg `leg`: not where it rests at ambient pressure,
    /// or is as it was left in the air.
    fn flows(&self, leg: usize, feed: &Feed<f64>, path: &Path, y: &[f64]) -> bool {
        let state = &self.mode.legs[leg];
        if state
            .spool
            .moves(feed, state.energized, y[self.layout.clock()])
        {
            return true;
        }
        let body = self.machine.mechanism.legs[leg].body;
        let is_still = path.speed == 0.0 && path.acceleration == 0.0;
        let gauge = y[self.layout.gas() + leg] * MEGA / feed.at_rest(path.extension).pressure - 1.0;
        let rests = is_still && gauge.abs() < RESTS;
        self.mode.joints[body] != JointMode::Latched && !rests
    }

    /// Changes what the tried step shows to be wrong about who takes part; whether anything was.
    fn revise(&mut self, fixed: &Fixed, h: f64) -> bool {
        let mut is_wrong = false;
        for i in 0..self.machine.problem.elements.len() {
            let e = self.machine.problem.elements[i];
            if let Owner::Normal(c) = self.machine.owners[e.row]
                && self.machine.problem.lets_go(&e, PARTING)
                && self.is_massless(c)
            {
                // Off the ground, a leg without mass stays where it is.
                self.open(c);
                is_wrong = true;
            }
        }
        for body in 0..self.mode.joints.len() {
            if let JointMode::Sliding(sign) = self.mode.joints[body]
                && self.machine.moves(body)
            {
                let k = self.machine.mechanism.tree.velocity_of(body);
                let after = self.layout.v(&self.y)[k] + h * fixed.next_acceleration[k];
                if sign * after < -STANDING {
                    self.mode.joints[body] = JointMode::Held(self.stop_of(body));
                    is_wrong = true;
                }
            }
        }
        is_wrong
    }

    /// Whether contact `c` is of a leg without mass.
    fn is_massless(&self, c: usize) -> bool {
        let mechanism = self.machine.mechanism;
        let body = mechanism.points[self.machine.pairs[c].0].body;
        mechanism
            .legs
            .iter()
            .any(|leg| leg.body == body && leg.massless)
    }

    /// `next` at the end of the step.
    fn finish_step(&mut self, fixed: &mut Fixed, h: f64) -> Result<(), SimError> {
        let layout = self.layout;
        for (k, a) in fixed.next_acceleration.iter().enumerate() {
            let before = self.y[layout.coordinates + k];
            fixed.mean[k] = before + 0.5 * h * a;
            self.next[layout.coordinates + k] = before + h * a;
        }
        let tree = &self.machine.mechanism.tree;
        tree.coordinate_rates(layout.q(&fixed.middle), &fixed.mean, &mut fixed.rates);
        for (i, rate) in fixed.rates.iter().enumerate() {
            self.next[i] = self.y[i] + h * rate;
        }
        if layout.fed {
            let mut next = std::mem::take(&mut self.next);
            let gas = layout.gas()..layout.works();
            next[gas.clone()].copy_from_slice(&fixed.middle[gas]);
            let to = (&mut next[..], &mut fixed.moved[..]);
            self.feed(to, &fixed.next_acceleration, (0.5 * h, 0.5 * h));
            self.next = next;
        } else {
            for leg in 0..layout.legs {
                let path = self.path_of(leg, &fixed.next_acceleration).from(0.5 * h);
                let at = layout.gas() + leg;
                let from = (fixed.middle[at], &mut fixed.moved[leg]);
                self.next[at] = self.fill(leg, from, &path, 0.5 * h);
            }
        }
        let works = layout.works();
        self.next[works..].copy_from_slice(&self.y[works..]);
        self.machine.step_works(h, &mut self.next[works..]);
        self.account_gas(fixed);
        let is_sound = self.next.iter().all(|x| x.abs() < BOUND);
        if is_sound {
            Ok(())
        } else {
            Err(SimError::Diverged {
                time: self.time,
                step: h,
            })
        }
    }

    /// The guard that is crossed first within the step of `h`, and when; `next` is left there.
    fn first_crossed(
        &mut self,
        fixed: &mut Fixed,
        h: f64,
        watches: &[Watch<'_>],
    ) -> Result<Option<(Guard, f64)>, SimError> {
        let mut guards = std::mem::take(&mut self.guards);
        guards.clear();
        self.crossed(fixed, h, watches, &mut guards);
        let mut first: Option<(Guard, f64)> = None;
        let mut tried = h;
        for &(guard, after) in &guards {
            let is_cut = fixed.cuts < CUTS || matches!(guard, Guard::Watch(_));
            let at = if is_cut && self.is_gentle(fixed, guard, after, watches) {
                0.0
            } else if is_cut {
                self.when(fixed, guard, (h, after), watches)?
            } else {
                h
            };
            tried = at;
            if first.is_none_or(|(_, earliest)| at < earliest) {
                first = Some((guard, at));
            }
        }
        self.guards = guards;
        if let Some((_, at)) = first
            && at > 0.0
            && at != tried
        {
            self.try_fixed(fixed, at)?;
        }
        Ok(first)
    }

    /// Whether a contact or a stop that is `after` (m or rad) away at the end of the step is all but
    /// met from the start: then it takes part in the whole step, which is not cut. What rests would
    /// else be cut into ever smaller pieces.
    fn is_gentle(
        &mut self,
        fixed: &Fixed,
        guard: Guard,
        after: f64,
        watches: &[Watch<'_>],
    ) -> bool {
        let slack = self.gentle(fixed.h);
        if after < -slack || !matches!(guard, Guard::Touch(_) | Guard::Stop(..)) {
            return false;
        }
        self.guard_before(fixed, guard, watches) < slack
    }

    /// How far (m or rad) from its contact something that rests may be: twice what it falls in a
    /// step of `h` (s).
    pub(super) fn gentle(&self, h: f64) -> f64 {
        h * h * self.machine.mechanism.gravity.norm()
    }

    /// A guard's value at the start of the step.
    fn guard_before(&mut self, fixed: &Fixed, guard: Guard, watches: &[Watch<'_>]) -> f64 {
        let end = std::mem::take(&mut self.next);
        self.next.clone_from(&self.y);
        let before = self.fixed_guard(fixed, guard, 0.0, watches);
        self.next = end;
        before
    }

    /// The guards that are below 0 at the end of the step of `h`, with their values there.
    fn crossed(
        &mut self,
        fixed: &Fixed,
        h: f64,
        watches: &[Watch<'_>],
        guards: &mut Vec<(Guard, f64)>,
    ) {
        let mut is_touching = false;
        if self.touching {
            for c in 0..self.mode.contacts.len() {
                // From the middle, where the machine is; then at the end itself.
                is_touching |= !self.mode.contacts[c].closed && self.machine.gap(c, 0.5 * h) < 0.0;
            }
        }
        if is_touching {
            for c in 0..self.mode.contacts.len() {
                let guard = Guard::Touch(c);
                if !self.mode.contacts[c].closed {
                    let after = self.fixed_guard(fixed, guard, h, watches);
                    if after < 0.0 && after < self.gap_before(c) {
                        guards.push((guard, after));
                    }
                }
            }
        }
        for body in 0..self.mode.joints.len() {
            if !self.machine.moves(body) || self.mode.joints[body] == JointMode::Latched {
                continue;
            }
            for guard in self.position_guards(body).into_iter().flatten() {
                let after = self.fixed_guard(fixed, guard, h, watches);
                if after < 0.0 && !self.leaves(body, guard) {
                    guards.push((guard, after));
                }
            }
        }
        for i in 0..watches.len() {
            let after = self.fixed_guard(fixed, Guard::Watch(i), h, watches);
            if after < 0.0 || after.is_nan() {
                guards.push((Guard::Watch(i), after));
            }
        }
    }

    /// Whether at `next` the joint of `body` moves away from the stop of `guard`.
    fn leaves(&self, body: usize, guard: Guard) -> bool {
        let speed = self.machine.joint_speed(&self.next, body);
        match guard {
            Guard::Stop(_, Stop::Low) => speed >= 0.0,
            Guard::Stop(..) => speed <= 0.0,
            _ => false,
        }
    }

    fn gap_before(&mut self, c: usize) -> f64 {
        self.machine.place(&self.y);
        self.machine.gap(c, 0.0)
    }

    /// What the joint of `body` can come to: stops, cushion, port.
    fn position_guards(&self, body: usize) -> [Option<Guard>; 4] {
        let (low, high) = self.machine.stops(body);
        let held = |stop| self.mode.joints[body] == JointMode::Held(stop);
        let stop = |x: f64, stop| (x.is_finite() && !held(stop)).then_some(Guard::Stop(body, stop));
        let leg = self.machine.leg_of(body);
        let part = leg.map(|i| &self.machine.mechanism.legs[i].leg);
        let cushion = part
            .and_then(Leg::cushion_start)
            .and(leg)
            .map(Guard::Cushion);
        let port = part
            .and_then(Leg::chamber)
            .and_then(Chamber::port)
            .and(leg)
            .map(Guard::Port);
        [stop(low, Stop::Low), stop(high, Stop::High), cushion, port]
    }

    /// A guard's value at `next`, `h` into the step.
    fn fixed_guard(&mut self, fixed: &Fixed, guard: Guard, h: f64, watches: &[Watch<'_>]) -> f64 {
        let tree = &self.machine.mechanism.tree;
        let x = |body: usize| self.next[tree.coordinate_of(body)];
        let leg = |i: usize| &self.machine.mechanism.legs[i];
        let side = |is_on: bool, distance: f64| if is_on { distance } else { -distance };
        match guard {
            Guard::Stop(body, Stop::Low) => x(body) - self.machine.stops(body).0,
            Guard::Stop(body, _) => self.machine.stops(body).1 - x(body),
            Guard::Cushion(i) => {
                let start = leg(i).leg.cushion_start().unwrap_or(f64::NAN);
                side(self.mode.legs[i].cushioned, x(leg(i).body) - start)
            }
            Guard::Port(i) => {
                let port = leg(i)
                    .leg
                    .chamber()
                    .and_then(Chamber::port)
                    .unwrap_or(f64::NAN);
                side(self.mode.legs[i].port_open, x(leg(i).body) - port)
            }
            Guard::Touch(c) => {
                self.machine.place(&self.next);
                self.machine.gap(c, 0.0)
            }
            Guard::Watch(i) if h > 0.0 => watches[i](
                self.time + h,
                self.layout.q(&self.next),
                self.layout.v(&self.next),
            ),
            Guard::Watch(i) => fixed.watched[i],
            _ => f64::NAN,
        }
    }

    /// When, within the step of `h`, a guard that is `after` at its end comes to 0; just past it.
    fn when(
        &mut self,
        fixed: &mut Fixed,
        guard: Guard,
        (h, after): (f64, f64),
        watches: &[Watch<'_>],
    ) -> Result<f64, SimError> {
        let before = self.guard_before(fixed, guard, watches);
        if before <= 0.0 || before.is_nan() || after.is_nan() {
            return Ok(0.0);
        }
        let mut failed = None;
        let mut tried = h;
        let at = past_root((0.0, before), (h, after), 1e-8 * h, |s| {
            tried = s;
            match self.try_fixed(fixed, s) {
                Ok(()) => self.fixed_guard(fixed, guard, s, watches),
                Err(error) => {
                    failed = Some(error);
                    0.0
                }
            }
        });
        if let Some(error) = failed {
            return Err(error);
        }
        if tried != at {
            self.try_fixed(fixed, at)?;
        }
        Ok(at)
    }

    /// Takes over the step of `h` that was tried.
    fn accept_fixed(&mut self, fixed: &mut Fixed, h: f64) {
        if let Some(impulses) = &mut fixed.impulses {
            self.machine.tell_impulses(impulses);
        }
        std::mem::swap(&mut self.y, &mut self.next);
        // `next` is now the state before.
        let clear = self.gentle(fixed.h);
        self.adopt_step(h, clear);
        let slack = 0.01 * h * h;
        self.machine.correct_step(&mut self.y, slack);
        self.machine
            .mechanism
            .tree
            .normalize(&mut self.y[..self.layout.coordinates]);
        std::mem::swap(&mut fixed.acceleration, &mut fixed.next_acceleration);
        fixed.span = h;
        fixed.is_known &= h >= 0.5 * fixed.h;
    }

    /// Takes over who held and who moved in the step of `h`. A rigid contact that parts no faster
    /// than what rests, and by less than `clear` (m), stays closed.
    fn adopt_step(&mut self, h: f64, clear: f64) {
        for i in 0..self.machine.problem.elements.len() {
            let e = self.machine.problem.elements[i];
            match self.machine.owners[e.row] {
                Owner::Normal(c) => {
                    if !self.mode.contacts[c].closed || !self.machine.problem.lets_go(&e, PARTING) {
                        continue;
                    }
                    let is_compliant = self.machine.mechanism.material.compliance.is_some();
                    let least = if is_compliant { 0.0 } else { clear };
                    let is_fast = self.machine.problem.motion[e.row] > self.rest_speed();
                    if (is_fast && !is_compliant) || self.machine.gap(c, 0.5 * h) > least {
                        self.open(c);
                    }
                }
                Owner::Tangent(c, axis) => self.adopt_grip(c, axis, e.grip),
                Owner::Joint(body) => self.adopt_joint(body, e.grip),
            }
        }
        self.adopt_rest();
    }

    /// Joints that the step has left out rest where they are held.
    fn adopt_rest(&mut self) {
        for i in 0..self.machine.folded.joints.len() {
            let body = self.machine.folded.joints[i].0;
            if let JointMode::Held(_) = self.mode.joints[body] {
                let stop = self.stop_of(body);
                self.mode.joints[body] = JointMode::Held(stop);
                self.machine.put_at_stop(&mut self.y, body, stop);
            }
        }
    }

    fn adopt_joint(&mut self, body: usize, grip: Grip) {
        let k = self.layout.coordinates + self.machine.mechanism.tree.velocity_of(body);
        let stood = self.next[k].abs() <= STANDING;
        match grip {
            Grip::Held => {
                let stop = self.stop_of(body);
                if !stood {
                    self.log(Happening::Halt(body));
                }
                self.mode.joints[body] = JointMode::Held(stop);
                self.machine.put_at_stop(&mut self.y, body, stop);
            }
            grip => {
                if stood {
                    self.log(Happening::BreakAway(body));
                }
                self.mode.joints[body] =
                    self.moving(body, if grip == Grip::High { -1.0 } else { 1.0 });
            }
        }
    }
}
