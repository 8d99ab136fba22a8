//! Who holds and who moves after an event, by the laws at the instant.

use super::guards::Guard;
use super::{Happening, Sim, Stepping};
use crate::SimError;
use crate::complementarity::Grip;
use crate::machine::{Owner, Rows};
use crate::mode::JointMode;

impl Sim<'_> {
    /// Decides who holds and who moves, from the laws at the present state. What `forced` has just
    /// let go stays so.
    pub(super) fn settle(&mut self, forced: Option<Guard>) -> Result<(), SimError> {
        self.machine.assemble(&self.y, &self.mode, Rows::Holding);
        self.pick_up_slack_legs();
        if self.settings.stepping != Stepping::Adaptive {
            // What does not part at once, the next step's impulses decide.
            self.part(self.rest_speed());
            return Ok(());
        }
        self.part(self.machine.standing);
        self.free_joints(forced);
        self.orient(forced);
        self.machine.assemble(&self.y, &self.mode, Rows::Candidates);
        if let Some(guard) = forced {
            self.keep_forced(guard);
        }
        if !self.machine.problem.resolve() {
            if self.stop_pulling() {
                return self.settle(None);
            }
            return Err(self.inconsistent());
        }
        self.machine.problem.hold_what_stands();
        self.adopt();
        self.machine.look(&self.y, &self.mode);
        if !self.machine.sound {
            return Err(SimError::Stuck {
                time: self.time,
                step: 0.0,
            });
        }
        // One that has just been freed too.
        if self.pick_up_slack_legs() {
            self.settle(None)
        } else {
            Ok(())
        }
    }

    /// Opens the contacts that do not slip, whatever it takes, and where the ground would have to
    /// pull for that; whether there were any.
    ///
    /// With friction that has no limit nothing lies between holding a foot and letting it go: a
    /// foot that can only be held by pulling leaves.
    fn stop_pulling(&mut self) -> bool {
        let machine = &mut self.machine;
        if !machine
            .friction()
            .iter()
            .any(|(standing, ..)| standing.is_infinite())
        {
            return false;
        }
        machine.assemble(&self.y, &self.mode, Rows::Candidates);
        machine.problem.solve();
        let pulled: Vec<usize> = (0..self.mode.contacts.len())
            .filter(|&c| self.mode.contacts[c].closed && machine.normal_force(c) < 0.0)
            .collect();
        for &c in &pulled {
            self.open(c);
        }
        !pulled.is_empty()
    }

    /// Opens the rigid contacts that move apart faster than `speed` (m/s).
    pub(super) fn part(&mut self, speed: f64) {
        self.machine.place(&self.y);
        if self.machine.mechanism.material.compliance.is_some() {
            return;
        }
        for c in 0..self.mode.contacts.len() {
            if self.mode.contacts[c].closed && self.machine.lie(c).speeds.x > speed {
                self.open(c);
            }
        }
    }

    /// Sets joints that move to moving.
    pub(super) fn free_joints(&mut self, forced: Option<Guard>) {
        for body in 0..self.mode.joints.len() {
            let speed = match self.machine.mechanism.tree.bodies()[body].joint {
                crate::tree::Joint::Free => continue,
                _ => self.machine.joint_speed(&self.y, body),
            };
            match self.mode.joints[body] {
                JointMode::Latched => {}
                _ if forced == Some(Guard::Release(body)) => {}
                JointMode::Held(_) | JointMode::Sliding(_)
                    if speed.abs() > self.machine.standing =>
                {
                    self.mode.joints[body] = self.moving(body, speed.signum());
                }
                _ => {}
            }
        }
    }

    /// Points the slip of contacts that slip along their velocity.
    pub(super) fn orient(&mut self, forced: Option<Guard>) {
        self.machine.place(&self.y);
        for c in 0..self.mode.contacts.len() {
            if !self.mode.contacts[c].closed {
                continue;
            }
            let touch = self.machine.lie(c);
            for (axis, (standing, _, width)) in self.machine.friction().into_iter().enumerate() {
                if standing == 0.0 || forced == Some(Guard::SlipStart(c, axis)) {
                    continue;
                }
                let v = [
                    touch.speeds[1 + axis],
                    if width == 2 { touch.speeds.z } else { 0.0 },
                ];
                let speed = v[0].hypot(v[1]);
                if speed > self.machine.standing {
                    self.mode.contacts[c].grips[axis] = match width {
                        2 => Grip::Along([v[0] / speed, v[1] / speed]),
                        _ if v[0] > 0.0 => Grip::Low,
                        _ => Grip::High,
                    };
                }
            }
        }
    }

    /// Sets the constraint that has just been let go to going, so that round-off does not catch it
    /// again.
    pub(super) fn keep_forced(&mut self, guard: Guard) {
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
    pub(super) fn adopt(&mut self) {
        for i in 0..self.machine.problem.elements.len() {
            let e = self.machine.problem.elements[i];
            match self.machine.owners[e.row] {
                Owner::Normal(c) => {
                    if e.grip != Grip::Held && self.mode.contacts[c].closed {
                        self.open(c);
                    }
                }
                Owner::Tangent(c, axis) => self.adopt_grip(c, axis, e.grip),
                Owner::Joint(body) => {
                    let held = matches!(self.mode.joints[body], JointMode::Held(_));
                    if held && e.grip != Grip::Held {
                        self.log(Happening::BreakAway(body));
                    }
                    self.mode.joints[body] = match e.grip {
                        Grip::Held => JointMode::Held(self.stop_of(body)),
                        Grip::High => self.moving(body, -1.0),
                        _ => self.moving(body, 1.0),
                    };
                }
            }
        }
    }

    pub(super) fn adopt_grip(&mut self, c: usize, axis: usize, grip: Grip) {
        let before = self.mode.contacts[c].grips[axis];
        let (p, s) = self.machine.pairs[c];
        if self.mode.contacts[c].closed {
            match (before == Grip::Held, grip == Grip::Held) {
                (false, true) => self.log(Happening::Stick(p, s)),
                (true, false) => self.log(Happening::Slip(p, s, axis)),
                _ => {}
            }
        }
        self.mode.contacts[c].grips[axis] = grip;
    }
}
