//! Guards and mode changes: what ends a mode, and which mode follows.

use saltus_pneumatics::{Chamber, Flow};

use super::contact::{Axle, Foot};
use super::guard::{Guard, Guards, TINY};
use super::machine::{LEAN, LEG};
use super::run::{Look, Run, Slide, State};

/// Most events of one jump: with more it counts as stuck.
const EVENTS: usize = 300;

impl Run<'_> {
    /// Replaces `guards` by those of the mode at `s`.
    pub(super) fn guard(&self, s: &State, look: &Look, guards: &mut Guards) {
        guards.clear();
        self.guard_foot(s, look, guards);
        self.guard_axle(s, look, guards);
        if self.mode.leg != Slide::Latched {
            self.guard_leg(s, look, guards);
            self.guard_drive(s, guards);
        }
    }

    fn guard_foot(&self, s: &State, look: &Look, guards: &mut Guards) {
        let machine = &self.rig.machine;
        if self.mode.foot == Foot::Flies {
            if self.touches_down {
                guards.push((Guard::Land, machine.contact(&s.q, &s.v).0));
            }
            return;
        }
        let [normal, along] = look.answer.ground;
        guards.push((Guard::Lift, normal));
        let moves = matches!(self.mode.leg, Slide::Moves(_));
        if self.rig.massless && moves && machine.floor.soft.is_none() {
            // A drive that is off gives 0, which is none.
            guards.push((Guard::Slack, look.answer.push - 2.0 * TINY));
        }
        let standing = machine.floor.friction.0;
        match self.mode.foot {
            Foot::Stands if standing.is_finite() => {
                guards.push((Guard::Slip, standing * normal - along.abs()));
            }
            Foot::Slips(way) => {
                let (_, [_, speed], _) = machine.contact(&s.q, &s.v);
                guards.push((Guard::Grip, way * speed));
            }
            _ => {}
        }
    }

    fn guard_axle(&self, s: &State, look: &Look, guards: &mut Guards) {
        let friction = self.rig.machine.axle_friction;
        match self.mode.axle {
            Axle::Held => guards.push((Guard::Turn, friction - look.answer.brake.abs())),
            Axle::Turns(way) if friction > 0.0 => guards.push((Guard::Brake, way * s.v[LEAN])),
            Axle::Turns(_) => {}
        }
    }

    fn guard_leg(&self, s: &State, look: &Look, guards: &mut Guards) {
        let (d, stroke) = (s.q[LEG], self.rig.leg.stroke);
        match self.mode.leg {
            Slide::Latched => {}
            Slide::Held => {
                if d < stroke {
                    guards.push((Guard::Extend, look.dry - look.answer.hold));
                }
                if d > 0.0 && !(self.rig.machine.is_bench() && d >= stroke) {
                    guards.push((Guard::Retract, look.dry + look.answer.hold));
                }
            }
            Slide::Moves(way) => {
                guards.push(if way > 0.0 {
                    (Guard::Stroke, stroke - d)
                } else {
                    (Guard::Stop, d)
                });
                guards.push((Guard::Halt, way * s.v[LEG]));
            }
        }
    }

    fn guard_drive(&self, s: &State, guards: &mut Guards) {
        let d = s.q[LEG];
        let side = |is_past: bool, at: f64| if is_past { d - at } else { at - d };
        if let Some(piece) = &self.mode.piece {
            let (above, below) = piece.guards(s.gas[0]);
            guards.push((Guard::Above, -above));
            guards.push((Guard::Below, -below));
        }
        if let Some(port) = self.rig.leg.chamber().and_then(Chamber::port) {
            guards.push((Guard::Port, side(self.mode.port_open, port)));
        }
        if let Some(start) = self.rig.leg.cushion_start() {
            guards.push((Guard::Cushion, side(self.mode.switches.cushioned, start)));
        }
    }

    /// Changes the mode as the event of `guard` asks. None after the most events that a jump may
    /// have.
    pub(super) fn happen(&mut self, guard: Guard, look: &Look) -> Option<()> {
        self.events += 1;
        if self.events > EVENTS {
            return None;
        }
        match guard {
            Guard::Lift | Guard::Slack => self.leave(),
            Guard::Land => self.land()?,
            Guard::Slip => self.mode.foot = Foot::Slips(-look.answer.ground[1].signum()),
            Guard::Grip => self.mode.foot = Foot::Stands,
            Guard::Extend => {
                self.slide(1.0);
                self.course.breaks_away.get_or_insert(self.state.time);
            }
            Guard::Retract => self.slide(-1.0),
            Guard::Halt => {
                self.state.v[LEG] = 0.0;
                self.mode.leg = Slide::Held;
            }
            Guard::Turn => self.mode.axle = Axle::Turns(look.answer.brake.signum()),
            Guard::Brake => {
                self.state.v[LEAN] = 0.0;
                self.mode.axle = Axle::Held;
            }
            Guard::Stroke => {
                self.stop(self.rig.leg.stroke)?;
                if self.mode.foot != Foot::Flies && !self.rig.machine.floor.pushes_on() {
                    self.leave();
                }
            }
            Guard::Stop => self.stop(0.0)?,
            Guard::Above => self.renew(1.0),
            Guard::Below => self.fall_below(),
            Guard::Cushion => self.mode.switches.cushioned ^= true,
            Guard::Port => {
                self.mode.port_open = !self.mode.port_open;
                self.renew(0.0);
            }
        }
        Some(())
    }

    /// The foot leaves the ground; a leg without mass then stays as it is.
    fn leave(&mut self) {
        self.mode.foot = Foot::Flies;
        self.course.leaves = Some(self.state.time);
        if self.rig.massless && !self.rig.machine.is_bench() {
            self.mode.leg = Slide::Latched;
            self.state.v[LEG] = 0.0;
            self.record();
        }
    }

    /// The foot comes down; a leg that is out is pushed in by the impulse.
    fn land(&mut self) -> Option<()> {
        let machine = &self.rig.machine;
        self.course.lands.get_or_insert(self.state.time);
        let is_home = self.mode.leg == Slide::Latched
            || (self.mode.leg == Slide::Held && self.state.q[LEG] <= 0.0);
        let (v, foot) = machine.touched_down(
            &self.state.q,
            &self.state.v,
            is_home,
            self.rig.others.at(self.state.time).0,
        )?;
        self.state.v = v;
        self.mode.foot = foot;
        if !is_home {
            self.slide(if v[LEG] < 0.0 { -1.0 } else { 1.0 });
        }
        self.mode.axle = machine.axle_at(v[LEAN]);
        Some(())
    }

    /// The leg begins to move this way.
    fn slide(&mut self, way: f64) {
        self.mode.leg = Slide::Moves(way);
        self.mode.fed = false;
    }

    /// The leg reaches the end of its stroke at the extension `at` (m), and is stopped by an
    /// impulse.
    fn stop(&mut self, at: f64) -> Option<()> {
        self.state.q[LEG] = at;
        self.state.v = self.rig.machine.stop_leg(&self.state.q, &self.state.v)?;
        self.state.v[LEG] = 0.0;
        self.mode.leg = Slide::Held;
        self.mode.axle = self.rig.machine.axle_at(self.state.v[LEAN]);
        Some(())
    }

    /// The pressure falls below the present piece of the gas law.
    fn fall_below(&mut self) {
        let was_full = self
            .mode
            .piece
            .is_some_and(|p| p.flow == Flow::FillBalanced);
        self.renew(-1.0);
        let returns = self.gas(&self.state).is_some_and(|gas| gas.rate[0] > 0.0);
        self.mode.fed = was_full && returns && self.mode.leg == Slide::Held;
    }
}
