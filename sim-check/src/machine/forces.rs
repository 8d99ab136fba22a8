//! Applied forces: joints, legs, drag.

use saltus_pneumatics::{Chamber, MEGA, Place, Switches};

use super::{ACCOUNT, DRAG_LOSS, DRIVE, JOINT_LOSS, Machine, OUTSIDE};
use crate::feeding::{gas_of, tank_of};
use crate::mode::{JointMode, Mode};

impl Machine<'_> {
    /// Forces in joints and legs, and what they do.
    pub(super) fn apply_joints(&mut self, y: &[f64], mode: &Mode) {
        self.stiffness.fill(0.0);
        self.damping.fill(0.0);
        for body in 0..self.dof.len() {
            let Some(k) = self.dof[body] else { continue };
            let parts = &self.mechanism.joints[body];
            if mode.joints[body] == JointMode::Latched {
                continue;
            }
            let speed = self.v[k];
            let mut force = -parts.damping * speed;
            if let JointMode::Sliding(sign) = mode.joints[body] {
                force -= sign * parts.friction;
            }
            self.powers[JOINT_LOSS] -= force * speed;
            if parts.spring.0 > 0.0 {
                // A spring keeps its energy: it is not a loss.
                let x = y[self.mechanism.tree.coordinate_of(body)];
                force -= parts.spring.0 * (x - parts.spring.1);
            }
            self.free[k] += force;
            self.stiffness[k] = parts.spring.0;
            self.damping[k] = parts.damping;
        }
        if !self.mechanism.forces.is_empty() {
            for (k, &full) in self.welded.velocities.iter().enumerate() {
                let force = self.mechanism.forces[full];
                self.free[k] += force;
                self.powers[OUTSIDE] += force * self.v[k];
            }
        }
        self.drawn = [0.0; 2];
        for i in 0..self.mechanism.legs.len() {
            self.apply_leg(i, y, mode);
        }
        self.apply_tank(y);
    }

    pub(super) fn apply_leg(&mut self, i: usize, y: &[f64], mode: &Mode) {
        let part = &self.mechanism.legs[i];
        let (leg, state) = (&part.leg, &mode.legs[i]);
        let d = y[self.mechanism.tree.coordinate_of(part.body)];
        let speed = self.dof[part.body].map_or(0.0, |k| self.v[k]);
        let u = y[self.layout.gas() + i];
        let is_latched = mode.joints[part.body] == JointMode::Latched;
        self.feed_leg(i, y, mode, (d, speed));
        (self.gas_rates[i], self.pressures[i]) = match (leg.chamber(), &state.piece) {
            _ if leg.feed.is_some() => (self.gas_rates[i], u * MEGA),
            // Before it is fired nothing flows; once a leg without mass has been picked up, nothing
            // depends on its gas.
            (Some(chamber), Some(piece)) if is_latched => (0.0, chamber.pressure(piece.flow, u)),
            (Some(chamber), Some(piece)) => {
                let (gas, rate) = piece.gas(chamber, u, d, speed);
                (rate, gas.pressure)
            }
            _ => (0.0, 0.0),
        };
        let (Some(k), false) = (self.dof[part.body], is_latched) else {
            self.pushes[i] = f64::NAN;
            return;
        };
        let switches = Switches {
            energized: state.energized,
            cushioned: state.cushioned,
        };
        let slack = leg.slack_pull(switches, d);
        let drive = leg.drive_force(switches, d, speed, self.pressures[i]).value - slack;
        let dry = leg.dry_friction(self.pressures[i]);
        let force = leg.force(switches, d, speed, self.pressures[i]);
        self.stiffness[k] -= force.wrt_extension.min(0.0);
        self.damping[k] -= force.wrt_speed.min(0.0);
        // The leg's own law is that of an extending one: dry friction is put right for the others.
        let without = force.value - slack + dry;
        let force = match mode.joints[part.body] {
            JointMode::Sliding(sign) => without - sign * dry,
            _ => without,
        };
        self.powers[DRIVE] += drive * speed;
        // Springs keep their energy: it is not a loss.
        let lost = (drive - force - leg.spring_pull(switches, d)) * speed;
        self.powers[JOINT_LOSS] += lost;
        if let Some(at) = self.layout.account(i) {
            let (supplied, released, pushed) = match (leg.chamber(), &state.piece) {
                _ if leg.feed.is_some() => (
                    self.powers[at + 2],
                    self.powers[at + 3],
                    self.powers[at + 4],
                ),
                (Some(chamber), Some(piece)) => {
                    let flows = piece.mass_flows(chamber, u, d, speed);
                    let [supplied, released] = flows.map(|flow| flow * chamber.pressure_per_mass());
                    (supplied, released, self.pressures[i] * chamber.area * speed)
                }
                _ => (0.0, 0.0, 0.0),
            };
            let rates = [drive * speed, lost, supplied, released, pushed];
            self.powers[at..at + ACCOUNT].copy_from_slice(&rates);
        }
        self.pushes[i] = force;
        self.free[k] += force;
    }

    /// Puts down what the gas of leg `i` does, if it is fed, at its extension (m) and speed (m/s).
    fn feed_leg(&mut self, i: usize, y: &[f64], mode: &Mode, (extension, speed): (f64, f64)) {
        let (layout, part) = (self.layout, &self.mechanism.legs[i]);
        let Some(feed) = part.leg.feed.as_ref() else {
            return;
        };
        self.gas_rates[i] = 0.0;
        self.gas_rates[layout.legs + i] = 0.0;
        let state = &mode.legs[i];
        let is_still = mode.joints[part.body] == JointMode::Latched;
        if is_still && !state.spool.moves(feed, state.energized, y[layout.clock()]) {
            return;
        }
        let place = Place {
            extension,
            speed,
            opening: state
                .spool
                .opening(feed, state.energized, y[layout.clock()]),
            port_open: state.port_open,
        };
        let (tank, held) = (tank_of(layout, feed, y), gas_of(layout, feed, i, y));
        let rates = feed.rates(tank, held, &place);
        self.gas_rates[i] = rates.held.pressure / MEGA;
        self.gas_rates[layout.legs + i] = rates.held.mass / feed.mass_units()[0];
        for (all, one) in self.drawn.iter_mut().zip(rates.drawn) {
            *all += one;
        }
        if let Some(at) = layout.account(i) {
            let per_mass = part.leg.chamber().map_or(1.0, Chamber::pressure_per_mass);
            let masses = [rates.drawn[0] * per_mass, rates.vented[0] * per_mass];
            self.powers[at + 2..at + 4].copy_from_slice(&masses);
            self.powers[at + 4] = rates.work;
        }
    }

    /// Rates of the tank that feeds the legs, and of the time.
    fn apply_tank(&mut self, y: &[f64]) {
        let layout = self.layout;
        let Some(feed) = self.mechanism.feed() else {
            return;
        };
        let (rates, _) = feed.tank_rates(tank_of(layout, feed, y), self.drawn);
        let at = layout.tank() - layout.gas();
        self.gas_rates[at] = rates.pressure / MEGA;
        self.gas_rates[at + 1] = rates.mass / feed.mass_units()[1];
        self.gas_rates[at + 2] = 1.0;
    }

    pub(super) fn apply_drag(&mut self) {
        let Some(drag) = self.mechanism.drag else {
            return;
        };
        let (Some(body), placement) = self.welded.home[drag.body] else {
            return;
        };
        let at = self.pose.frames[body].then(&placement).position;
        let velocity = self.pose.velocities[body].at(&at);
        let force = velocity * (-drag.coefficient * velocity.norm());
        self.powers[DRAG_LOSS] -= force.dot(&velocity);
        for k in self.welded.tree.path(body) {
            self.free[k] += self.pose.axes[k].at(&at).dot(&force);
        }
    }

    /// Dry friction (N or N m) in the joint of `body`, at the present pressure.
    pub(crate) fn dry_friction(&self, body: usize) -> f64 {
        match self.leg_of[body] {
            Some(i) => self.mechanism.legs[i].leg.dry_friction(self.pressures[i]),
            None => self.mechanism.joints[body].friction,
        }
    }
}
