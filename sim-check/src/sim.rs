//! A motion through its events: touch-down and lift-off, slip and stick, end stops, valves.

use saltus_numeric::dop853::step_factor;
use saltus_pneumatics::Piece;

use crate::SimError;
use crate::complementarity::{Bounds, Grip};
use crate::machine::{
    CONTACT_LOSS, DRAG_LOSS, DRIVE, JOINT_LOSS, Layout, Machine, Owner, Rows, STANDING, WORKS,
};
use crate::mechanism::Mechanism;
use crate::mode::{ContactMode, JointMode, LegMode, Mode, Stop};
use crate::spatial::Vec3;
use crate::step::Stages;
use crate::tree::Pose;

/// How a motion is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Error allowed in each step, relative to 1 + |y| for every coordinate, velocity and pressure variable; > 0.
    pub tolerance: f64,
    /// Longest step (s), > 0: an event that comes and goes within one step is not seen.
    pub longest_step: f64,
    /// Impacts slower than this (m/s) do not rebound, ≥ 0: else a ball that comes to rest bounces for ever.
    pub rest_speed: f64,
    /// How deep a start may be inside a surface (m), ≥ 0; it then counts as touching.
    pub penetration: f64,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { tolerance: 1e-10, longest_step: 0.01, rest_speed: 1e-3, penetration: 1e-9 }
    }
}

/// Why a motion paused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pause {
    /// The time was reached.
    Time,
    /// The watch of this number came to 0 from above.
    Watch(usize),
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When (s).
    pub time: f64,
    /// What.
    pub what: Happening,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// A point touches a surface (their numbers).
    TouchDown(usize, usize),
    /// A point leaves a surface.
    LiftOff(usize, usize),
    /// A standing point begins to slip.
    Slip(usize, usize),
    /// A slipping point comes to stand.
    Stick(usize, usize),
    /// The joint of a body reaches an end stop.
    EndStop(usize),
    /// The joint of a body, held before, begins to move.
    BreakAway(usize),
    /// The joint of a body comes to rest.
    Halt(usize),
    /// The valve of a leg opens or its latch is let go (true), or it closes.
    Valve(usize, bool),
    /// A switch inside a leg: the orifice law's pieces, cushion, port.
    Switch(usize),
}

/// A contact at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Number of the point.
    pub point: usize,
    /// Number of the surface.
    pub surface: usize,
    /// Where (m).
    pub place: Vec3,
    /// The surface's force on the point (N), world axes.
    pub force: Vec3,
    /// Its parts along the normal, the travel and across it (N).
    pub parts: Vec3,
    /// Slip velocity along the travel and across it (m/s).
    pub slip: [f64; 2],
}

/// Work and energy since the start (J): `drive` + Δ`springs` … closes with what is in the bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Kinetic energy of the bodies.
    pub kinetic: f64,
    /// Potential energy of their weight, 0 at height 0.
    pub potential: f64,
    /// Energy in the springs of joints and compliant contacts.
    pub springs: f64,
    /// Work of the drives so far.
    pub drive: f64,
    /// Lost so far in joints and legs, dry friction, dampers and the legs' own springs among them.
    pub joints: f64,
    /// Lost so far where feet slip, and in the ground's dampers.
    pub contacts: f64,
    /// Lost so far to the air.
    pub drag: f64,
    /// Lost so far in impacts.
    pub impacts: f64,
}

impl Ledger {
    /// What, between `start` and `self`, no entry explains (J).
    pub fn residual(&self, start: &Ledger) -> f64 {
        let stored = |l: &Ledger| l.kinetic + l.potential + l.springs;
        let lost = |l: &Ledger| l.joints + l.contacts + l.drag + l.impacts - l.drive;
        stored(self) - stored(start) + lost(self) - lost(start)
    }
}

/// What a guard watches.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Guard {
    Touch(usize),
    Lift(usize),
    SlipStart(usize, usize),
    SlipEnd(usize, usize),
    Redundant,
    Release(usize),
    Halt(usize),
    Stop(usize, Stop),
    Edge(usize, f64),
    Cushion(usize),
    Port(usize),
    Watch(usize),
}

/// A function that pauses a motion where it comes to 0 from above, of time (s), coordinates and velocities.
pub type Watch<'w> = &'w dyn Fn(f64, &[f64], &[f64]) -> f64;

/// A mechanism in motion.
pub struct Sim<'a> {
    machine: Machine<'a>,
    settings: Settings,
    layout: Layout,
    time: f64,
    y: Vec<f64>,
    mode: Mode,
    stages: Stages,
    step: f64,
    /// Commands to come: time, leg, on or off; latest first.
    commands: Vec<(f64, usize, bool)>,
    events: Vec<Event>,
    impacts: f64,
    touching: bool,
    steps: usize,
    evaluations: usize,
    next: Vec<f64>,
    guards: Vec<(Guard, f64)>,
    /// Events since time moved on.
    burst: (f64, usize),
}

/// Events that may happen within [`BURST_SPAN`] seconds before a motion counts as stuck in them.
const BURST: usize = 2000;
const BURST_SPAN: f64 = 1e-3;

impl<'a> Sim<'a> {
    /// `mechanism` at coordinates `q` and velocities `v`, its legs' valves at rest and unfired legs latched where they are.
    ///
    /// Points within `settings.penetration` of a surface touch it. Velocities into what touches are taken as they are: an impact
    /// takes them out at once.
    ///
    /// # Errors
    /// [`SimError`] for a mechanism or a start that cannot be.
    pub fn new(
        mechanism: &'a Mechanism,
        q: &[f64],
        v: &[f64],
        settings: Settings,
    ) -> Result<Sim<'a>, SimError> {
        let mut machine = Machine::new(mechanism);
        let layout = machine.layout;
        check_start(mechanism, q, v, &settings)?;
        let mut y = vec![0.0; layout.size()];
        y[..layout.coordinates].copy_from_slice(q);
        y[layout.coordinates..layout.gas()].copy_from_slice(v);
        mechanism.tree.normalize(&mut y[..layout.coordinates]);
        let mode = first_mode(mechanism, &mut y, layout);
        machine.weld(&mode, &y);
        let stages = Stages::new(layout.size());
        let mut sim = Sim {
            next: y.clone(),
            machine,
            settings,
            layout,
            time: 0.0,
            y,
            mode,
            stages,
            step: 1e-4,
            commands: Vec::new(),
            events: Vec::new(),
            impacts: 0.0,
            touching: true,
            steps: 0,
            evaluations: 0,
            guards: Vec::new(),
            burst: (0.0, 0),
        };
        sim.begin()?;
        Ok(sim)
    }

    /// Closes what touches at the start.
    fn begin(&mut self) -> Result<(), SimError> {
        self.machine.place(&self.y);
        let allowed = self.settings.penetration;
        for c in 0..self.mode.contacts.len() {
            let touch = self.machine.lie(c);
            let (point, surface) = self.machine.pairs[c];
            let mechanism = self.machine.mechanism;
            let resting = mechanism.material.compliance.is_some();
            if touch.gap < -allowed && !resting {
                return Err(SimError::Penetration {
                    point: mechanism.points[point].name.clone(),
                    surface: mechanism.surfaces[surface].name().into(),
                    depth: -touch.gap,
                    allowed,
                });
            }
            self.mode.contacts[c].closed = touch.gap <= allowed;
        }
        self.impact(None, 0.0)?;
        self.settle(None)
    }

    /// Time (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Coordinates q.
    pub fn coordinates(&self) -> &[f64] {
        self.layout.q(&self.y)
    }

    /// Velocities v.
    pub fn velocities(&self) -> &[f64] {
        self.layout.v(&self.y)
    }

    /// What has happened so far.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Steps taken and derivatives evaluated so far.
    pub fn effort(&self) -> (usize, usize) {
        (self.steps, self.evaluations)
    }

    /// Where every body is.
    pub fn pose(&self) -> Pose {
        let mut pose = Pose::default();
        pose.set(&self.machine.mechanism.tree, self.coordinates(), self.velocities());
        pose
    }

    /// Chamber pressure (Pa) of leg `leg`; 0 for one without a chamber.
    pub fn pressure(&self, leg: usize) -> f64 {
        let mode = &self.mode.legs[leg];
        let part = &self.machine.mechanism.legs[leg];
        match (part.leg.chamber(), &mode.piece) {
            (Some(chamber), Some(piece)) => chamber.pressure(piece.flow, self.y[self.layout.gas() + leg]),
            _ => 0.0,
        }
    }

    /// The contacts that are closed, with their forces.
    pub fn contacts(&mut self) -> Vec<Contact> {
        self.machine.look(&self.y, &self.mode);
        self.machine.touches.iter().map(|touch| self.contact(touch)).collect()
    }

    fn contact(&self, touch: &crate::machine::Touch) -> Contact {
        let c = touch.contact;
        let normal = touch.spring.map_or_else(|| self.machine.normal_force(c), |f| f.max(0.0));
        let mut parts = Vec3::new(normal, 0.0, 0.0);
        for (axis, (standing, slipping, width)) in self.machine.axes().into_iter().enumerate() {
            if standing == 0.0 {
                continue;
            }
            match self.mode.contacts[c].grips[axis] {
                Grip::Held => {
                    for (k, force) in self.machine.force_of(Owner::Tangent(c, axis)).iter().enumerate() {
                        parts[1 + axis + k] = *force;
                    }
                }
                Grip::Low => parts[1 + axis] = -slipping * normal,
                Grip::High => parts[1 + axis] = slipping * normal,
                Grip::Along(d) => {
                    let speed = touch.speeds.y.hypot(touch.speeds.z);
                    let way =
                        if speed > STANDING { [touch.speeds.y / speed, touch.speeds.z / speed] } else { d };
                    for k in 0..width {
                        parts[1 + k] = -slipping * normal * way[k];
                    }
                }
            }
        }
        let (point, surface) = self.machine.pairs[c];
        Contact {
            point,
            surface,
            place: touch.place,
            force: touch.normal * parts.x + touch.along * parts.y + touch.across * parts.z,
            parts,
            slip: [touch.speeds.y, touch.speeds.z],
        }
    }

    /// The force (N or N m) that holds the joint of `body`, 0 where it moves.
    pub fn joint_reaction(&mut self, body: usize) -> f64 {
        self.machine.look(&self.y, &self.mode);
        self.machine.force_of(Owner::Joint(body)).first().copied().unwrap_or(0.0)
    }

    /// Work and energy.
    pub fn ledger(&self) -> Ledger {
        let mechanism = self.machine.mechanism;
        let pose = self.pose();
        let works = &self.y[self.layout.works()..self.layout.works() + WORKS];
        let mut springs = 0.0;
        for (body, parts) in mechanism.joints.iter().enumerate() {
            if parts.spring.0 > 0.0 {
                let x = self.y[mechanism.tree.coordinate_of(body)] - parts.spring.1;
                springs += 0.5 * parts.spring.0 * x * x;
            }
        }
        if let Some((stiffness, _)) = mechanism.material.compliance {
            let closed = self.mode.contacts.iter().enumerate().filter(|(_, c)| c.closed);
            springs += closed
                .map(|(c, _)| {
                    let (p, s) = self.machine.pairs[c];
                    let point = &mechanism.points[p];
                    let center = pose.frames[point.body].point(&point.center);
                    let gap = mechanism.surfaces[s].proximity(&center).distance - point.radius;
                    0.5 * stiffness * gap * gap
                })
                .sum::<f64>();
        }
        Ledger {
            kinetic: pose.kinetic_energy(&mechanism.tree),
            potential: pose.potential_energy(&mechanism.tree, &mechanism.gravity),
            springs,
            drive: works[DRIVE],
            joints: works[JOINT_LOSS],
            contacts: works[CONTACT_LOSS],
            drag: works[DRAG_LOSS],
            impacts: self.impacts,
        }
    }

    /// Commands leg `leg` now, for `opening` seconds from when its drive answers, after its delay.
    ///
    /// # Errors
    /// [`SimError::Input`] for a leg that is not there, or an opening time that is not a finite number ≥ 0.
    pub fn fire(&mut self, leg: usize, opening: f64) -> Result<(), SimError> {
        let legs = self.layout.legs;
        if leg >= legs {
            return Err(SimError::Input {
                name: "leg".into(),
                value: leg as f64,
                allowed: "the number of a leg",
            });
        }
        if !(opening >= 0.0 && opening.is_finite()) {
            let name = "valve opening time (s)".into();
            return Err(SimError::Input { name, value: opening, allowed: "a finite number ≥ 0" });
        }
        let delay = self.machine.mechanism.legs[leg].leg.delay;
        self.commands.extend([(self.time + delay, leg, true), (self.time + delay + opening, leg, false)]);
        self.commands.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
        Ok(())
    }

    /// Goes on until `until` (s), or until a watch comes to 0 from above, whichever is first.
    ///
    /// # Errors
    /// [`SimError`] where the motion cannot go on.
    pub fn run(&mut self, until: f64, watches: &[Watch<'_>]) -> Result<Pause, SimError> {
        if until.is_nan() {
            return Err(SimError::Input {
                name: "time to run until (s)".into(),
                value: until,
                allowed: "a number",
            });
        }
        loop {
            if let Some(pause) = self.run_eventwise(until, watches)? {
                return Ok(pause);
            }
        }
    }

    /// As [`run`](Self::run), but comes back with none after each event of the mechanism's own.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_eventwise(&mut self, until: f64, watches: &[Watch<'_>]) -> Result<Option<Pause>, SimError> {
        while self.time < until {
            let events = self.events.len();
            if let Some(&(at, leg, on)) = self.commands.last()
                && at <= self.time
            {
                self.commands.pop();
                self.switch_valve(leg, on)?;
            } else if let Some(watch) = self.advance(until, watches)? {
                return Ok(Some(Pause::Watch(watch)));
            }
            if self.events.len() > events {
                return Ok(None);
            }
        }
        Ok(Some(Pause::Time))
    }

    /// From now on nothing that is in the air touches anything: a flight goes on as if there were no ground.
    pub fn stop_touching(&mut self) {
        self.touching = false;
    }

    /// One step, or the part of one that ends at an event, which then happens.
    fn advance(&mut self, until: f64, watches: &[Watch<'_>]) -> Result<Option<usize>, SimError> {
        let stop = self.commands.last().map_or(until, |c| c.0.min(until));
        let room = stop - self.time;
        self.start_step();
        let before = self.guard_values(self.time, watches, false);
        let mut h = self.step.min(self.settings.longest_step);
        // A step that would leave a sliver takes it along.
        if room < h * (1.0 + 1e-9) {
            h = room;
        }
        loop {
            let error = self.try_step(h);
            if error <= 1.0 {
                self.step = (h * step_factor(error)).max(self.step.min(h));
                if h < room {
                    self.step = h * step_factor(error);
                }
                break;
            }
            self.step = h * step_factor(error);
            if self.step < 1e-15 * (1.0 + self.time.abs()) {
                return Err(SimError::Stuck { time: self.time, step: self.step });
            }
            h = self.step;
        }
        self.steps += 1;
        let after = self.guard_values(self.time + h, watches, true);
        let first = after.iter().find(|(_, value)| *value < 0.0 || value.is_nan()).copied();
        let Some((guard, _)) = first else {
            self.accept(self.time + h, h == room, stop);
            return Ok(None);
        };
        let (guard, h) = self.locate(guard, h, &before, watches);
        self.accept(self.time + h, false, stop);
        self.happen(guard)
    }

    /// The derivative at the start of a step.
    fn start_step(&mut self) {
        self.evaluations += 1;
        self.machine.derivative(&self.y, &self.mode, self.stages.start());
    }

    /// Steps by `h` into `next`; the error.
    fn try_step(&mut self, h: f64) -> f64 {
        let (machine, mode) = (&mut self.machine, &self.mode);
        let checked = self.layout.works();
        self.evaluations += 11;
        let f = |y: &[f64], dy: &mut [f64]| machine.derivative(y, mode, dy);
        self.stages.step(f, &self.y, h, (checked, self.settings.tolerance), &mut self.next)
    }

    fn accept(&mut self, time: f64, is_stop: bool, stop: f64) {
        std::mem::swap(&mut self.y, &mut self.next);
        self.machine.mechanism.tree.normalize(&mut self.y[..self.layout.coordinates]);
        self.time = if is_stop { stop } else { time };
        // Twice what is needed where the machine is already there; it is one evaluation of twelve.
        self.machine.look(&self.y, &self.mode);
        self.machine.project(&mut self.y, &self.mode);
    }

    /// The first guard that is violated on the way to `h`, and when: `next` is left there.
    fn locate(
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
            let other = values.iter().find(|(g, value)| *value < 0.0 && *g != guard && !trails(*g, before));
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
    fn root(&mut self, guard: Guard, h: f64, before: &[(Guard, f64)], watches: &[Watch<'_>]) -> f64 {
        let value = |sim: &mut Self, s: f64| {
            sim.try_step(s);
            let values = sim.guard_values(sim.time + s, watches, true);
            values.iter().find(|(g, _)| *g == guard).map_or(f64::NAN, |v| v.1)
        };
        let start = before.iter().find(|(g, _)| *g == guard).map_or(f64::NAN, |v| v.1);
        let (mut a, mut fa) = (0.0, start);
        let (mut b, mut fb) = (h, value(self, h));
        // A guard that starts at 0 and comes back has its root inside: look for where it is well above 0.
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
        // Illinois, which keeps the bracket, with bisection where it is slow.
        let resolution = 2.0 * f64::EPSILON * (self.time.abs() + h);
        let mut side = 0;
        for i in 0..80 {
            if b - a <= resolution || fb == 0.0 {
                break;
            }
            let mut s = (a * fb - b * fa) / (fb - fa);
            if i % 8 == 7 || !(s > a && s < b) {
                s = 0.5 * (a + b);
            }
            let f = value(self, s);
            if f > 0.0 {
                (a, fa) = (s, f);
                if side == 1 {
                    fb *= 0.5;
                }
                side = 1;
            } else {
                (b, fb) = (s, f);
                if side == -1 {
                    fa *= 0.5;
                }
                side = -1;
            }
        }
        value(self, b);
        b
    }

    /// Every guard's value: above 0 while it holds. At the start of a step, or at `next`.
    fn guard_values(&mut self, time: f64, watches: &[Watch<'_>], at_next: bool) -> Vec<(Guard, f64)> {
        let mut guards = std::mem::take(&mut self.guards);
        guards.clear();
        let y = if at_next { &self.next } else { &self.y };
        self.evaluations += 1;
        self.machine.look(y, &self.mode);
        if !self.machine.sound {
            guards.push((Guard::Redundant, f64::NAN));
        }
        contact_guards(&self.machine, &self.mode, self.touching, &mut guards);
        joint_guards(&self.machine, &self.mode, y, &mut guards);
        leg_guards(&self.machine, &self.mode, y, &mut guards);
        for (i, watch) in watches.iter().enumerate() {
            guards.push((Guard::Watch(i), watch(time, self.layout.q(y), self.layout.v(y))));
        }
        if self.machine.redundant {
            // The forces are one choice of many: what counts is whether any choice obeys the laws.
            let is_force = |g: &Guard| {
                matches!(g, Guard::Lift(_) | Guard::SlipStart(..) | Guard::Release(_) | Guard::Redundant)
            };
            let broken = guards.iter().any(|(g, value)| is_force(g) && *value < 0.0);
            guards.retain(|(g, _)| !is_force(g));
            let y = if at_next { self.next.clone() } else { self.y.clone() };
            let holds = !broken || self.would_hold(&y);
            guards.push((Guard::Redundant, if holds { 1.0 } else { -1.0 }));
        }
        let copy = guards.clone();
        self.guards = guards;
        copy
    }

    /// Whether the mode is the one that the laws give at `y`.
    fn would_hold(&mut self, y: &[f64]) -> bool {
        self.machine.assemble(y, &self.mode, Rows::Candidates);
        if !self.machine.problem.resolve() {
            return false;
        }
        let machine = &self.machine;
        machine.problem.elements.iter().all(|e| {
            let holds = e.grip == Grip::Held || machine.problem.stands(e);
            holds
                == match machine.owners[e.row] {
                    Owner::Normal(c) => self.mode.contacts[c].closed,
                    Owner::Tangent(c, axis) => self.mode.contacts[c].grips[axis] == Grip::Held,
                    Owner::Joint(body) => matches!(self.mode.joints[body], JointMode::Held(_)),
                }
        })
    }

    /// Lets the event of `guard` happen; the watch that it was, if it was one.
    fn happen(&mut self, guard: Guard) -> Result<Option<usize>, SimError> {
        self.count(guard)?;
        let pair = |sim: &Self, c: usize| sim.machine.pairs[c];
        match guard {
            Guard::Watch(i) => return Ok(Some(i)),
            Guard::Touch(c) => {
                let (p, s) = pair(self, c);
                self.log(Happening::TouchDown(p, s));
                self.mode.contacts[c].closed = true;
                self.impact(Some(c), self.machine.mechanism.material.restitution)?;
                self.settle(None)?;
            }
            Guard::Lift(c) => {
                self.open(c);
                self.settle(Some(guard))?;
            }
            Guard::SlipStart(c, axis) => {
                let (p, s) = pair(self, c);
                self.log(Happening::Slip(p, s));
                self.let_slip(c, axis);
                self.settle(Some(guard))?;
            }
            Guard::SlipEnd(..) | Guard::Redundant => self.settle(None)?,
            Guard::Release(body) => {
                self.log(Happening::BreakAway(body));
                let pull = self.machine.force_of(Owner::Joint(body)).first().copied().unwrap_or(0.0);
                self.mode.joints[body] = self.moving(body, -pull.signum());
                self.settle(Some(guard))?;
            }
            Guard::Halt(body) => {
                self.log(Happening::Halt(body));
                self.set_joint_speed(body, 0.0);
                self.settle(None)?;
            }
            Guard::Stop(body, stop) => {
                self.log(Happening::EndStop(body));
                self.reach_stop(body, stop)?;
            }
            Guard::Edge(leg, side) => self.cross_edge(leg, side),
            Guard::Cushion(leg) => {
                self.log(Happening::Switch(leg));
                self.mode.legs[leg].cushioned ^= true;
            }
            Guard::Port(leg) => {
                self.log(Happening::Switch(leg));
                self.mode.legs[leg].port_open ^= true;
                self.renew_piece(leg, 0.0);
            }
        }
        Ok(None)
    }

    /// Counts events, which must not go on without time.
    fn count(&mut self, guard: Guard) -> Result<(), SimError> {
        if self.time - self.burst.0 > BURST_SPAN {
            self.burst = (self.time, 0);
        }
        self.burst.1 += 1;
        if self.burst.1 > BURST {
            return Err(SimError::TooManyEvents {
                time: self.time,
                limit: BURST,
                span: BURST_SPAN,
                last: format!("{guard:?}"),
            });
        }
        Ok(())
    }

    fn log(&mut self, what: Happening) {
        self.events.push(Event { time: self.time, what });
    }

    /// Opens contact `c`. A leg without mass has nowhere to go without it: it stays as it is.
    fn open(&mut self, c: usize) {
        let (point, surface) = self.machine.pairs[c];
        self.log(Happening::LiftOff(point, surface));
        self.mode.contacts[c] = ContactMode::OPEN;
        let mechanism = self.machine.mechanism;
        let body = mechanism.points[point].body;
        if mechanism.legs.iter().any(|leg| leg.body == body && leg.massless) {
            self.set_joint_speed(body, 0.0);
            self.mode.joints[body] = JointMode::Latched;
            self.machine.weld(&self.mode, &self.y);
        }
    }

    /// Lets a standing contact slip against the force that held it.
    fn let_slip(&mut self, c: usize, axis: usize) {
        let force = self.machine.force_of(Owner::Tangent(c, axis)).to_vec();
        self.mode.contacts[c].grips[axis] = match force[..] {
            [f] if f > 0.0 => Grip::High,
            [_] => Grip::Low,
            [a, b] => {
                let size = a.hypot(b);
                Grip::Along([-a / size, -b / size])
            }
            _ => Grip::Held,
        };
    }

    /// The mode of a joint that moves in the direction `sign`.
    fn moving(&self, body: usize, sign: f64) -> JointMode {
        let mechanism = self.machine.mechanism;
        let dry = match mechanism.leg_of(body) {
            Some(_) => true,
            None => mechanism.joints[body].friction > 0.0,
        };
        if dry { JointMode::Sliding(sign) } else { JointMode::Free }
    }

    fn set_joint_speed(&mut self, body: usize, speed: f64) {
        let k = self.layout.coordinates + self.machine.mechanism.tree.velocity_of(body);
        self.y[k] = speed;
    }

    fn reach_stop(&mut self, body: usize, stop: Stop) -> Result<(), SimError> {
        let (low, high) = self.machine.mechanism.stops(body);
        self.y[self.machine.mechanism.tree.coordinate_of(body)] = if stop == Stop::Low { low } else { high };
        self.mode.joints[body] = JointMode::Held(stop);
        self.impact(None, 0.0)?;
        self.settle(None)
    }

    /// The valve of `leg` opens or closes, its latch is let go or caught.
    fn switch_valve(&mut self, leg: usize, on: bool) -> Result<(), SimError> {
        self.log(Happening::Valve(leg, on));
        let body = self.machine.mechanism.legs[leg].body;
        self.mode.legs[leg].energized = on;
        self.renew_piece(leg, 0.0);
        if self.mode.joints[body] == JointMode::Latched {
            let (low, high) = self.machine.mechanism.stops(body);
            let d = self.y[self.machine.mechanism.tree.coordinate_of(body)];
            let stop = if d <= low {
                Stop::Low
            } else if d >= high {
                Stop::High
            } else {
                Stop::Between
            };
            self.mode.joints[body] = JointMode::Held(stop);
            self.machine.weld(&self.mode, &self.y);
        }
        self.settle(None)
    }

    /// Puts the chamber of `leg` on the piece of its law that holds now, or just above or below where `side` is ±1.
    fn renew_piece(&mut self, leg: usize, side: f64) {
        let Some(chamber) = self.machine.mechanism.legs[leg].leg.chamber() else { return };
        let mode = &mut self.mode.legs[leg];
        let at = self.layout.gas() + leg;
        let pressure = mode.piece.map_or(chamber.ambient, |piece| chamber.pressure(piece.flow, self.y[at]));
        let piece = Piece::new(chamber, mode.energized, pressure, side, mode.port_open);
        self.y[at] = chamber.variable(piece.flow, pressure);
        mode.piece = Some(piece);
    }

    fn cross_edge(&mut self, leg: usize, side: f64) {
        self.log(Happening::Switch(leg));
        self.renew_piece(leg, side);
    }

    /// Takes out, by impulses, what velocity there is into contacts and stops; the new contact, if any, rebounds.
    fn impact(&mut self, hit: Option<usize>, restitution: f64) -> Result<(), SimError> {
        let before = self.pose().kinetic_energy(&self.machine.mechanism.tree);
        self.machine.assemble(&self.y, &self.mode, Rows::Impact);
        if self.machine.problem.rows == 0 {
            return Ok(());
        }
        let approaching = self.machine.problem.elements.iter().any(|e| {
            let w = self.machine.problem.b[e.row];
            match e.bounds {
                Bounds::Between(0.0, _) => w < -STANDING,
                Bounds::Between(..) => w > STANDING,
                Bounds::Friction { .. } => false,
            }
        });
        if !approaching {
            return Ok(());
        }
        for r in 0..self.machine.problem.rows {
            if let Owner::Normal(c) = self.machine.owners[r]
                && (hit == Some(c))
            {
                let w = self.machine.problem.b[r];
                if w < -self.settings.rest_speed {
                    self.machine.problem.b[r] += restitution * w;
                }
            }
        }
        if !self.machine.problem.resolve() {
            return Err(SimError::Inconsistent { time: self.time });
        }
        self.machine.jump(&mut self.y);
        let after = self.pose().kinetic_energy(&self.machine.mechanism.tree);
        self.impacts += before - after;
        Ok(())
    }

    /// Decides who holds and who moves, from the laws at the present state. What `forced` has just let go stays so.
    fn settle(&mut self, forced: Option<Guard>) -> Result<(), SimError> {
        self.part();
        self.free_joints(forced);
        self.orient(forced);
        self.machine.assemble(&self.y, &self.mode, Rows::Candidates);
        if let Some(guard) = forced {
            self.keep_forced(guard);
        }
        if !self.machine.problem.resolve() {
            return Err(SimError::Inconsistent { time: self.time });
        }
        let before = self.mode.clone();
        let logged = self.events.len();
        // Where forces are one choice of many, one at its bound says nothing: what stands, holds.
        self.adopt(true);
        self.machine.look(&self.y, &self.mode);
        if !self.machine.redundant {
            self.mode = before;
            self.events.truncate(logged);
            self.machine.weld(&self.mode, &self.y);
            self.machine.assemble(&self.y, &self.mode, Rows::Candidates);
            if let Some(guard) = forced {
                self.keep_forced(guard);
            }
            self.machine.problem.resolve();
            self.adopt(false);
            self.machine.look(&self.y, &self.mode);
        }
        if !self.machine.sound {
            return Err(SimError::Stuck { time: self.time, step: 0.0 });
        }
        Ok(())
    }

    /// Opens the rigid contacts that move apart.
    fn part(&mut self) {
        self.machine.place(&self.y);
        if self.machine.mechanism.material.compliance.is_some() {
            return;
        }
        for c in 0..self.mode.contacts.len() {
            if self.mode.contacts[c].closed && self.machine.lie(c).speeds.x > STANDING {
                self.open(c);
            }
        }
    }

    /// Sets joints that move to moving.
    fn free_joints(&mut self, forced: Option<Guard>) {
        for body in 0..self.mode.joints.len() {
            let speed = match self.machine.mechanism.tree.bodies()[body].joint {
                crate::tree::Joint::Free => continue,
                _ => self.machine.joint_speed(&self.y, body),
            };
            match self.mode.joints[body] {
                JointMode::Latched => {}
                _ if forced == Some(Guard::Release(body)) => {}
                JointMode::Held(_) | JointMode::Sliding(_) if speed.abs() > STANDING => {
                    self.mode.joints[body] = self.moving(body, speed.signum());
                }
                _ => {}
            }
        }
    }

    /// Points the slip of contacts that slip along their velocity.
    fn orient(&mut self, forced: Option<Guard>) {
        self.machine.place(&self.y);
        for c in 0..self.mode.contacts.len() {
            if !self.mode.contacts[c].closed {
                continue;
            }
            let touch = self.machine.lie(c);
            for (axis, (standing, _, width)) in self.machine.axes().into_iter().enumerate() {
                if standing == 0.0 || forced == Some(Guard::SlipStart(c, axis)) {
                    continue;
                }
                let v = [touch.speeds[1 + axis], if width == 2 { touch.speeds.z } else { 0.0 }];
                let speed = v[0].hypot(v[1]);
                if speed > STANDING {
                    self.mode.contacts[c].grips[axis] = match width {
                        2 => Grip::Along([v[0] / speed, v[1] / speed]),
                        _ if v[0] > 0.0 => Grip::Low,
                        _ => Grip::High,
                    };
                }
            }
        }
    }

    /// Sets the constraint that has just been let go to going, so that round-off does not catch it again.
    fn keep_forced(&mut self, guard: Guard) {
        let owner = match guard {
            Guard::SlipStart(c, axis) => Owner::Tangent(c, axis),
            Guard::Release(body) => Owner::Joint(body),
            _ => return,
        };
        let machine = &mut self.machine;
        let grip = match guard {
            Guard::SlipStart(c, axis) => self.mode.contacts[c].grips[axis],
            Guard::Release(body) => match self.mode.joints[body] {
                JointMode::Sliding(sign) if sign < 0.0 => Grip::High,
                _ => Grip::Low,
            },
            _ => return,
        };
        for e in &mut machine.problem.elements {
            if machine.owners[e.row] == owner {
                e.grip = grip;
            }
        }
    }

    /// Takes over the grips that the laws gave.
    fn adopt(&mut self, what_stands_holds: bool) {
        for i in 0..self.machine.problem.elements.len() {
            let mut e = self.machine.problem.elements[i];
            if what_stands_holds && self.machine.problem.stands(&e) {
                e.grip = Grip::Held;
            }
            match self.machine.owners[e.row] {
                Owner::Normal(c) => {
                    if e.grip != Grip::Held && self.mode.contacts[c].closed {
                        self.open(c);
                    }
                }
                Owner::Tangent(c, axis) => self.adopt_grip(c, axis, e.grip),
                Owner::Joint(body) => {
                    self.mode.joints[body] = match e.grip {
                        Grip::Held => JointMode::Held(self.stop_of(body)),
                        Grip::High => self.moving(body, -1.0),
                        _ => self.moving(body, 1.0),
                    };
                }
            }
        }
    }

    fn adopt_grip(&mut self, c: usize, axis: usize, grip: Grip) {
        let before = self.mode.contacts[c].grips[axis];
        let (p, s) = self.machine.pairs[c];
        if self.mode.contacts[c].closed {
            match (before == Grip::Held, grip == Grip::Held) {
                (false, true) => self.log(Happening::Stick(p, s)),
                (true, false) => self.log(Happening::Slip(p, s)),
                _ => {}
            }
        }
        self.mode.contacts[c].grips[axis] = grip;
    }

    /// Where the joint of `body`, which stands, is held.
    fn stop_of(&self, body: usize) -> Stop {
        let (low, high) = self.machine.mechanism.stops(body);
        let x = self.y[self.machine.mechanism.tree.coordinate_of(body)];
        if x <= low {
            Stop::Low
        } else if x >= high {
            Stop::High
        } else {
            Stop::Between
        }
    }
}

/// Whether a guard was violated, by round-off, before the step.
fn trails(guard: Guard, before: &[(Guard, f64)]) -> bool {
    before.iter().any(|(g, value)| *g == guard && *value < 0.0)
}

fn contact_guards(machine: &Machine<'_>, mode: &Mode, touching: bool, guards: &mut Vec<(Guard, f64)>) {
    for c in 0..mode.contacts.len() {
        if touching && !mode.contacts[c].closed {
            guards.push((Guard::Touch(c), machine.lie(c).gap));
        }
    }
    for touch in &machine.touches {
        let c = touch.contact;
        let normal = touch.spring.unwrap_or_else(|| machine.normal_force(c));
        guards.push((Guard::Lift(c), normal));
        for (axis, (standing, _, width)) in machine.axes().into_iter().enumerate() {
            if standing == 0.0 {
                continue;
            }
            match mode.contacts[c].grips[axis] {
                Grip::Held if standing.is_finite() => {
                    let force = machine.force_of(Owner::Tangent(c, axis));
                    let size = force.iter().map(|f| f * f).sum::<f64>().sqrt();
                    guards.push((Guard::SlipStart(c, axis), standing * normal - size));
                }
                Grip::Held => {}
                Grip::Low => guards.push((Guard::SlipEnd(c, axis), touch.speeds[1 + axis])),
                Grip::High => guards.push((Guard::SlipEnd(c, axis), -touch.speeds[1 + axis])),
                Grip::Along(d) => {
                    let ahead = touch.speeds.y * d[0] + if width == 2 { touch.speeds.z * d[1] } else { 0.0 };
                    guards.push((Guard::SlipEnd(c, axis), ahead));
                }
            }
        }
    }
}

fn joint_guards(machine: &Machine<'_>, mode: &Mode, y: &[f64], guards: &mut Vec<(Guard, f64)>) {
    for (body, joint) in mode.joints.iter().enumerate() {
        match *joint {
            JointMode::Latched => continue,
            JointMode::Held(stop) => {
                let hold = machine.force_of(Owner::Joint(body)).first().copied().unwrap_or(0.0);
                let dry = machine.dry_friction(body);
                let room = match stop {
                    Stop::Low => hold + dry,
                    Stop::High => dry - hold,
                    Stop::Between => dry - hold.abs(),
                };
                guards.push((Guard::Release(body), room));
                continue;
            }
            JointMode::Sliding(sign) => {
                guards.push((Guard::Halt(body), sign * machine.joint_speed(y, body)));
            }
            JointMode::Free => {}
        }
        let (low, high) = machine.mechanism.stops(body);
        let x = y[machine.mechanism.tree.coordinate_of(body)];
        if low.is_finite() {
            guards.push((Guard::Stop(body, Stop::Low), x - low));
        }
        if high.is_finite() {
            guards.push((Guard::Stop(body, Stop::High), high - x));
        }
    }
}

fn leg_guards(machine: &Machine<'_>, mode: &Mode, y: &[f64], guards: &mut Vec<(Guard, f64)>) {
    for (i, leg) in mode.legs.iter().enumerate() {
        let part = &machine.mechanism.legs[i];
        if let Some(piece) = &leg.piece {
            let (above, below) = piece.guards(y[machine.layout.gas() + i]);
            guards.push((Guard::Edge(i, 1.0), -above));
            guards.push((Guard::Edge(i, -1.0), -below));
        }
        if mode.joints[part.body] == JointMode::Latched {
            continue;
        }
        let d = y[machine.mechanism.tree.coordinate_of(part.body)];
        let side = |on: bool, position: f64| if on { d - position } else { position - d };
        if let Some(start) = part.leg.cushion_start() {
            guards.push((Guard::Cushion(i), side(leg.cushioned, start)));
        }
        if let Some(port) = part.leg.chamber().and_then(saltus_pneumatics::Chamber::port) {
            guards.push((Guard::Port(i), side(leg.port_open, port)));
        }
    }
}

/// The mode of a mechanism that stands as `y` says: legs latched, chambers at ambient pressure.
fn first_mode(mechanism: &Mechanism, y: &mut [f64], layout: Layout) -> Mode {
    let mut joints: Vec<JointMode> = mechanism
        .joints
        .iter()
        .map(|parts| if parts.friction > 0.0 { JointMode::Sliding(1.0) } else { JointMode::Free })
        .collect();
    let mut legs = Vec::new();
    for (i, part) in mechanism.legs.iter().enumerate() {
        joints[part.body] = JointMode::Latched;
        let piece = part.leg.chamber().map(|chamber| {
            let piece = Piece::new(chamber, false, chamber.ambient, 0.0, false);
            y[layout.gas() + i] = chamber.variable(piece.flow, chamber.ambient);
            piece
        });
        legs.push(LegMode { energized: false, cushioned: false, port_open: false, piece });
    }
    let pairs = mechanism.points.len() * mechanism.surfaces.len();
    Mode { joints, contacts: vec![ContactMode::OPEN; pairs], legs }
}

fn check_start(mechanism: &Mechanism, q: &[f64], v: &[f64], settings: &Settings) -> Result<(), SimError> {
    let tree = &mechanism.tree;
    for (name, given, wanted) in
        [("coordinates", q.len(), tree.coordinates()), ("velocities", v.len(), tree.velocities())]
    {
        if given != wanted {
            return Err(SimError::Length { name, given, wanted });
        }
    }
    let wrong = |name: &str, value, allowed| Err(SimError::Input { name: name.into(), value, allowed });
    for (name, list) in [("coordinate", q), ("velocity", v)] {
        if let Some(x) = list.iter().find(|x| x.is_nan() || x.abs() >= 1e9) {
            return wrong(name, *x, "a finite number below 1e9");
        }
    }
    let positive = [("tolerance", settings.tolerance), ("longest step (s)", settings.longest_step)];
    if let Some((name, value)) = positive.into_iter().find(|(_, x)| !(*x > 0.0 && x.is_finite())) {
        return wrong(name, value, "a finite number > 0");
    }
    let not_negative = [("rest speed (m/s)", settings.rest_speed), ("penetration (m)", settings.penetration)];
    if let Some((name, value)) = not_negative.into_iter().find(|(_, x)| !(*x >= 0.0 && x.is_finite())) {
        return wrong(name, value, "a finite number ≥ 0");
    }
    mechanism.check(q)?;
    for (i, body) in tree.bodies().iter().enumerate() {
        if body.joint == crate::tree::Joint::Free {
            let iq = tree.coordinate_of(i);
            let length = q[iq + 3..iq + 7].iter().map(|x| x * x).sum::<f64>().sqrt();
            if (length - 1.0).abs() > 1e-3 {
                return wrong("quaternion's length", length, "1 to within 1e-3");
            }
            continue;
        }
        let (x, (low, high)) = (q[tree.coordinate_of(i)], mechanism.stops(i));
        if x < low || x > high {
            return Err(SimError::BeyondStop { body: body.name.clone(), value: x, low, high });
        }
    }
    Ok(())
}
