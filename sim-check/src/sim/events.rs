//! What happens at an event.

use saltus_pneumatics::{MEGA, Piece};

use super::guards::Guard;
use super::{BACK_AGAIN, BURST, BURST_SPAN, CHATTER, Event, Happening, Sim, Stepping};
use crate::SimError;
use crate::complementarity::{Bounds, Grip};
use crate::machine::{Owner, Rows, STANDING};
use crate::mode::{ContactMode, JointMode, Stop};

impl Sim<'_> {
    /// Lets the event of `guard` happen; the watch that it was, if it was one.
    pub(super) fn happen(&mut self, guard: Guard) -> Result<Option<usize>, SimError> {
        self.count(guard)?;
        let pair = |sim: &Self, c: usize| sim.machine.pairs[c];
        match guard {
            Guard::Watch(i) => return Ok(Some(i)),
            Guard::Touch(c) => {
                let (p, s) = pair(self, c);
                self.log(Happening::TouchDown(p, s));
                self.mode.contacts[c].closed = true;
                self.together.clear();
                self.join(c);
                let restitution = self.machine.mechanism.material.restitution;
                self.impact(Some(Owner::Normal(c)), restitution)?;
                self.together.clear();
                self.settle(None)?;
            }
            Guard::Lift(c) => {
                self.open(c);
                self.settle(Some(guard))?;
            }
            Guard::Slack(leg) => {
                self.pick_up_leg(leg);
                self.settle(None)?;
            }
            Guard::SlipStart(c, axis) => {
                let (p, s) = pair(self, c);
                self.log(Happening::Slip(p, s, axis));
                self.let_slip(c, axis);
                self.settle(Some(guard))?;
            }
            Guard::SlipEnd(..) | Guard::Redundant => self.settle(None)?,
            Guard::Release(body) => {
                self.release(body);
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
                // Its damper makes the leg's force jump.
                self.settle(None)?;
            }
            Guard::Port(leg) => {
                self.log(Happening::Switch(leg));
                self.mode.legs[leg].port_open ^= true;
                self.renew_piece(leg, 0.0);
            }
        }
        Ok(None)
    }

    /// Lets a joint that was held move.
    fn release(&mut self, body: usize) {
        self.log(Happening::BreakAway(body));
        let pull = self.machine.force_of(Owner::Joint(body)).first();
        // Off a stop, whatever round-off leaves of what held it there.
        let sign = match self.mode.joints[body] {
            JointMode::Held(Stop::Low) => 1.0,
            JointMode::Held(Stop::High) => -1.0,
            _ => -pull.map_or(0.0, |pull| pull.signum()),
        };
        self.mode.joints[body] = self.moving(body, sign);
    }

    /// Counts events, which must not go on without time.
    pub(super) fn count(&mut self, guard: Guard) -> Result<(), SimError> {
        if self.time - self.burst.0 > BURST_SPAN {
            self.burst = (self.time, 0);
        }
        self.burst.1 += 1;
        self.machine.standing = if self.burst.1 > BACK_AGAIN {
            CHATTER
        } else {
            STANDING
        };
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

    pub(super) fn log(&mut self, what: Happening) {
        self.events.push(Event {
            time: self.time,
            what,
        });
    }

    /// Opens contact `c`. A leg without mass has nowhere to go without it: it stays as it is.
    pub(super) fn open(&mut self, c: usize) {
        let (point, surface) = self.machine.pairs[c];
        self.log(Happening::LiftOff(point, surface));
        self.mode.contacts[c] = ContactMode::OPEN;
        let mechanism = self.machine.mechanism;
        if let Some((stiffness, _)) = mechanism.material.compliance {
            // A damped spring lets go before it is slack; what is left in it stays in the ground.
            self.machine.place(&self.y);
            let depth = self.machine.lie(c).gap.min(0.0);
            self.impacts += 0.5 * stiffness * depth * depth;
        }
        let body = mechanism.points[point].body;
        if mechanism
            .legs
            .iter()
            .any(|leg| leg.body == body && leg.massless)
        {
            self.set_joint_speed(body, 0.0);
            self.mode.joints[body] = JointMode::Latched;
            self.machine.weld(&self.mode, &self.y);
        }
    }

    /// Opens the contacts of leg `leg`, which has no mass: it stays as it is.
    pub(super) fn pick_up_leg(&mut self, leg: usize) {
        let mechanism = self.machine.mechanism;
        let body = mechanism.legs[leg].body;
        for c in 0..self.mode.contacts.len() {
            if self.mode.contacts[c].closed
                && mechanism.points[self.machine.pairs[c].0].body == body
            {
                self.open(c);
            }
        }
    }

    /// Picks up the legs without mass that have nothing to push with, as the machine last saw them;
    /// whether there were any.
    pub(super) fn pick_up_slack_legs(&mut self) -> bool {
        let is_slack = |leg: usize| {
            self.machine.is_prop(leg, &self.mode)
                && self.machine.pushes[leg] <= self.machine.nothing
        };
        let props: Vec<usize> = (0..self.mode.legs.len())
            .filter(|&leg| is_slack(leg))
            .collect();
        for &leg in &props {
            self.pick_up_leg(leg);
        }
        !props.is_empty()
    }

    /// Lets a standing contact slip against the force that held it.
    pub(super) fn let_slip(&mut self, c: usize, axis: usize) {
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
    pub(super) fn moving(&self, body: usize, sign: f64) -> JointMode {
        let mechanism = self.machine.mechanism;
        let dry = match mechanism.leg_of(body) {
            Some(leg) => mechanism.legs[leg].leg.has_dry_friction(),
            None => mechanism.joints[body].friction > 0.0,
        };
        if dry {
            JointMode::Sliding(sign)
        } else {
            JointMode::Free
        }
    }

    pub(super) fn set_joint_speed(&mut self, body: usize, speed: f64) {
        let k = self.layout.coordinates + self.machine.mechanism.tree.velocity_of(body);
        self.y[k] = speed;
    }

    pub(super) fn reach_stop(&mut self, body: usize, stop: Stop) -> Result<(), SimError> {
        let x = self.y[self.machine.mechanism.tree.coordinate_of(body)];
        self.put_to_rest(body, stop);
        let at = self.y[self.machine.mechanism.tree.coordinate_of(body)];
        let reach = self.together(x - at);
        // Of legs that are each other's mirror image the first would else meet its stop alone.
        for other in 0..self.mode.joints.len() {
            if let Some(stop) = self.meets_stop(other, reach) {
                self.log(Happening::EndStop(other));
                self.put_to_rest(other, stop);
            }
        }
        let before = self.impacts;
        self.impact(Some(Owner::Joint(body)), 0.0)?;
        self.stops += self.impacts - before;
        self.settle(None)
    }

    /// Puts the joint of `body` at its stop.
    fn put_to_rest(&mut self, body: usize, stop: Stop) {
        let (low, high) = self.machine.mechanism.stops(body);
        self.y[self.machine.mechanism.tree.coordinate_of(body)] =
            if stop == Stop::Low { low } else { high };
        self.mode.joints[body] = JointMode::Held(stop);
        if stop == Stop::High {
            self.pick_up(body);
        }
    }

    /// The stop that the joint of `body` meets now, within `reach` (m), faster than what rests.
    fn meets_stop(&self, body: usize, reach: f64) -> Option<Stop> {
        let JointMode::Sliding(_) = self.mode.joints[body] else {
            return None;
        };
        if !self.machine.moves(body) {
            return None;
        }
        let (low, high) = self.machine.stops(body);
        let x = self.y[self.machine.mechanism.tree.coordinate_of(body)];
        let speed = self.machine.joint_speed(&self.y, body);
        let slow = self.settings.rest_speed;
        if (x - low).abs() <= reach && speed < -slow {
            Some(Stop::Low)
        } else if (high - x).abs() <= reach && speed > slow {
            Some(Stop::High)
        } else {
            None
        }
    }

    /// The foot of a leg that is stopped in its stroke leaves soft ground that it cannot slip on:
    /// the spring is slack within a fraction of a millisecond, but friction without a limit would
    /// meanwhile hold on to the foot and turn the robot about it.
    fn pick_up(&mut self, body: usize) {
        let mechanism = self.machine.mechanism;
        let sticks = self
            .machine
            .friction()
            .iter()
            .any(|(standing, ..)| standing.is_infinite());
        if mechanism.material.compliance.is_none() || !sticks {
            return;
        }
        for c in 0..self.mode.contacts.len() {
            let (point, _) = self.machine.pairs[c];
            if self.mode.contacts[c].closed && mechanism.points[point].body == body {
                self.open(c);
            }
        }
    }

    /// Where the joint of `body`, which stands, is held.
    pub(super) fn stop_of(&self, body: usize) -> Stop {
        let (low, high) = self.machine.mechanism.stops(body);
        let x = self.y[self.machine.mechanism.tree.coordinate_of(body)];
        // What a step cannot tell from being there is there.
        let near = match self.settings.stepping {
            Stepping::Adaptive => 0.0,
            Stepping::Fixed(h) => self.gentle(h),
        };
        if x <= low + near {
            Stop::Low
        } else if x >= high - near {
            Stop::High
        } else {
            Stop::Between
        }
    }

    /// The valve of `leg` opens or closes, its latch is let go or caught.
    pub(super) fn switch_valve(&mut self, leg: usize, on: bool) -> Result<(), SimError> {
        self.log(Happening::Valve(leg, on));
        let body = self.machine.mechanism.legs[leg].body;
        if let Some(feed) = &self.machine.mechanism.legs[leg].leg.feed {
            let state = &mut self.mode.legs[leg];
            let now = self.y[self.layout.clock()];
            state.spool = state.spool.turned(feed, state.energized, now);
        }
        self.mode.legs[leg].energized = on;
        self.renew_piece(leg, 0.0);
        // A leg without mass that was picked up stays as it is when its valve closes.
        if on && self.mode.joints[body] == JointMode::Latched {
            self.mode.joints[body] = JointMode::Held(self.stop_of(body));
            self.machine.weld(&self.mode, &self.y);
        }
        self.settle(None)
    }

    /// Puts the chamber of `leg` on the piece of its law that holds now, or just above or below
    /// where `side` is ±1.
    pub(super) fn renew_piece(&mut self, leg: usize, side: f64) {
        self.put_on_piece(leg, self.pressure(leg), side);
    }

    /// The same for a chamber at the pressure `pressure` (Pa).
    pub(super) fn put_on_piece(&mut self, leg: usize, pressure: f64, side: f64) {
        let Some(chamber) = self.machine.mechanism.legs[leg].leg.chamber() else {
            return;
        };
        let mode = &mut self.mode.legs[leg];
        let at = self.layout.gas() + leg;
        if self.machine.mechanism.legs[leg].leg.feed.is_some() {
            self.y[at] = pressure / MEGA;
            return;
        }
        let piece = Piece::new(chamber, mode.energized, pressure, side, mode.port_open);
        // Round-off leaves it on either side of the edge that it has crossed.
        let (from, to) = (piece.low.min(piece.high), piece.low.max(piece.high));
        let u = chamber.variable(piece.flow, pressure);
        self.y[at] = if side == 0.0 { u } else { u.clamp(from, to) };
        mode.piece = Some(piece);
    }

    pub(super) fn cross_edge(&mut self, leg: usize, side: f64) {
        self.log(Happening::Switch(leg));
        self.renew_piece(leg, side);
    }

    /// Impacts slower than this (m/s) do not rebound: in fixed steps not those either whose flight
    /// would be within a step.
    pub(super) fn rest_speed(&self) -> f64 {
        match self.settings.stepping {
            Stepping::Adaptive => self.settings.rest_speed,
            Stepping::Fixed(h) => self
                .settings
                .rest_speed
                .max(h * self.machine.mechanism.gravity.norm()),
        }
    }

    /// Takes out, by impulses, what velocity there is into contacts and stops; the new contact, if
    /// any, rebounds.
    pub(super) fn impact(&mut self, hit: Option<Owner>, restitution: f64) -> Result<(), SimError> {
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
                Bounds::Friction {
                    normal: None,
                    limit,
                    ..
                } => limit == f64::INFINITY && w.abs() > STANDING,
                Bounds::Friction { .. } => false,
            }
        });
        if !approaching {
            return Ok(());
        }
        for r in 0..self.machine.problem.rows {
            let owner = self.machine.owners[r];
            let hits = hit == Some(owner) || self.together.contains(&owner);
            if matches!(owner, Owner::Normal(_)) && hits {
                let w = self.machine.problem.b[r];
                if w < -self.rest_speed() {
                    self.machine.problem.b[r] += restitution * w;
                }
            }
        }
        let problem = &mut self.machine.problem;
        let is_solved = match self.settings.stepping {
            Stepping::Adaptive => problem.resolve(),
            Stepping::Fixed(_) => problem.resolve_step(),
        };
        if !is_solved {
            return Err(self.inconsistent());
        }
        self.capture(hit);
        self.machine.jump(&mut self.y);
        let after = self.pose().kinetic_energy(&self.machine.mechanism.tree);
        self.impacts += before - after;
        Ok(())
    }

    /// Way (m) to a contact or a stop that is met at the instant of another: twice as far as that one is past it, and in
    /// fixed steps what a step's errors leave.
    fn together(&self, past: f64) -> f64 {
        let errors = match self.settings.stepping {
            Stepping::Adaptive => 1e-13,
            Stepping::Fixed(_) => 1e-9,
        };
        2.0 * past.abs() + errors
    }

    /// Where contact `c` closes more slowly than the rest speed: closes those that are as slow and
    /// as good as closed. Where it is faster: those that close at the same instant, as two feet of a robot that is
    /// its own mirror image do. One after the other, the first would take the whole impact.
    fn join(&mut self, c: usize) {
        let slow = self.settings.rest_speed;
        if self.machine.mechanism.material.compliance.is_some() || !self.touching {
            return;
        }
        self.machine.place(&self.y);
        let closing = self.machine.lie(c);
        let is_fast = closing.speeds.x < -slow;
        let reach = self.together(closing.gap);
        for other in 0..self.mode.contacts.len() {
            let lies = self.machine.lie(other);
            let speed = lies.speeds.x;
            let near = if is_fast {
                lies.gap <= reach && speed < -slow
            } else {
                lies.gap <= self.settings.penetration && speed.abs() < slow
            };
            if near && !self.mode.contacts[other].closed {
                let (p, s) = self.machine.pairs[other];
                self.log(Happening::TouchDown(p, s));
                self.mode.contacts[other].closed = true;
                if is_fast {
                    self.together.push(Owner::Normal(other));
                }
            }
        }
    }

    /// Keeps what touches together in a slow impact.
    ///
    /// A body that rocks flat hits with one corner and lifts another ever more slowly, infinitely
    /// often in a finite time; so do legs at their stops, which hit each other through the wheel. So
    /// where the corner or the leg that hits is slower than the rest speed, those that it would lift
    /// more slowly than that stay where they are.
    fn capture(&mut self, hit: Option<Owner>) {
        let (machine, slow) = (&mut self.machine, self.settings.rest_speed);
        let hits_slowly =
            |r: usize| Some(machine.owners[r]) == hit && machine.problem.b[r].abs() <= slow;
        if !(0..machine.problem.rows).any(hits_slowly) {
            return;
        }
        let plain = machine.problem.clone();
        for e in &mut machine.problem.elements {
            let motion = plain.motion[e.row];
            let lifts = match (machine.owners[e.row], e.bounds) {
                (Owner::Tangent(..), _) => false,
                (_, Bounds::Between(0.0, _)) => (0.0..slow).contains(&motion),
                _ => (0.0..slow).contains(&-motion),
            };
            if lifts {
                (e.bounds, e.grip) = (
                    Bounds::Between(f64::NEG_INFINITY, f64::INFINITY),
                    Grip::Held,
                );
            }
        }
        if !machine.problem.resolve() {
            machine.problem = plain;
        }
    }
}
