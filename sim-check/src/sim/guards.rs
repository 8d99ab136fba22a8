//! What ends a smooth phase: functions that are above 0 while it lasts.

use super::{HAIR, Sim, Watch};
use crate::complementarity::Grip;
use crate::machine::{Machine, Owner, Rows};
use crate::mode::{JointMode, Mode, Stop};

impl Sim<'_> {
    /// Every guard's value: above 0 while it holds. At the start of a step, or at `next`.
    pub(super) fn guard_values(
        &mut self,
        time: f64,
        watches: &[Watch<'_>],
        at_next: bool,
    ) -> Vec<(Guard, f64)> {
        let mut guards = std::mem::take(&mut self.guards);
        guards.clear();
        let y = if at_next { &self.next } else { &self.y };
        self.evaluations += 1;
        self.machine.look(y, &self.mode);
        if !self.machine.sound {
            guards.push((Guard::Redundant, f64::NAN));
        }
        let floors = self.touching.then_some(&self.floors[..]);
        contact_guards(&self.machine, &self.mode, floors, &mut guards);
        joint_guards(&self.machine, &self.mode, y, &mut guards);
        leg_guards(&self.machine, &self.mode, y, &mut guards);
        for (i, watch) in watches.iter().enumerate() {
            guards.push((
                Guard::Watch(i),
                watch(time, self.layout.q(y), self.layout.v(y)),
            ));
        }
        if self.machine.redundant {
            // The forces are one choice of many: what counts is whether any choice obeys the laws.
            let is_force = |g: &Guard| {
                matches!(
                    g,
                    Guard::Lift(_) | Guard::SlipStart(..) | Guard::Release(_) | Guard::Redundant
                )
            };
            let broken = guards.iter().any(|(g, value)| is_force(g) && *value < 0.0);
            guards.retain(|(g, _)| !is_force(g));
            let y = if at_next {
                self.next.clone()
            } else {
                self.y.clone()
            };
            let holds = !broken || self.would_hold(&y);
            guards.push((Guard::Redundant, if holds { 1.0 } else { -1.0 }));
        }
        let copy = guards.clone();
        self.guards = guards;
        copy
    }

    /// Whether the mode is the one that the laws give at `y`.
    pub(super) fn would_hold(&mut self, y: &[f64]) -> bool {
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
}

/// What a guard watches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Guard {
    Touch(usize),
    Lift(usize),
    /// The moving leg of this number, without mass and with its foot on rigid ground, has nothing
    /// to push with.
    Slack(usize),
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

/// Whether a guard was violated, by round-off, before the step.
pub(super) fn trails(guard: Guard, before: &[(Guard, f64)]) -> bool {
    before.iter().any(|(g, value)| *g == guard && *value < 0.0)
}

pub(super) fn contact_guards(
    machine: &Machine<'_>,
    mode: &Mode,
    floors: Option<&[f64]>,
    guards: &mut Vec<(Guard, f64)>,
) {
    for (c, floor) in floors.unwrap_or_default().iter().enumerate() {
        if !mode.contacts[c].closed {
            guards.push((Guard::Touch(c), machine.lie(c).gap - floor));
        }
    }
    for touch in &machine.touches {
        let c = touch.contact;
        let normal = touch.spring.unwrap_or_else(|| machine.normal_force(c));
        guards.push((Guard::Lift(c), normal));
        for (axis, (standing, _, width)) in machine.friction().into_iter().enumerate() {
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
                    let ahead = touch.speeds.y * d[0]
                        + if width == 2 {
                            touch.speeds.z * d[1]
                        } else {
                            0.0
                        };
                    guards.push((Guard::SlipEnd(c, axis), ahead));
                }
            }
        }
    }
}

pub(super) fn joint_guards(
    machine: &Machine<'_>,
    mode: &Mode,
    y: &[f64],
    guards: &mut Vec<(Guard, f64)>,
) {
    for (body, joint) in mode.joints.iter().enumerate() {
        match *joint {
            JointMode::Latched => continue,
            JointMode::Held(stop) => {
                let hold = machine.first_force_of(Owner::Joint(body));
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
            guards.push((Guard::Stop(body, Stop::Low), x - low + HAIR));
        }
        if high.is_finite() {
            guards.push((Guard::Stop(body, Stop::High), high - x + HAIR));
        }
    }
}

pub(super) fn leg_guards(
    machine: &Machine<'_>,
    mode: &Mode,
    y: &[f64],
    guards: &mut Vec<(Guard, f64)>,
) {
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
        if machine.is_prop(i, mode) {
            guards.push((Guard::Slack(i), machine.pushes[i] - machine.nothing));
        }
        let d = y[machine.mechanism.tree.coordinate_of(part.body)];
        let side = |on: bool, position: f64| if on { d - position } else { position - d };
        if let Some(start) = part.leg.cushion_start() {
            guards.push((Guard::Cushion(i), side(leg.cushioned, start)));
        }
        if let Some(port) = part
            .leg
            .chamber()
            .and_then(saltus_pneumatics::Chamber::port)
        {
            guards.push((Guard::Port(i), side(leg.port_open, port)));
        }
    }
}
