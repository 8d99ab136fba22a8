//! What a motion tells: contacts, reactions, work and energy.

use saltus_pneumatics::MEGA;

use super::Sim;
use crate::complementarity::Grip;
use crate::feeding::{gas_of, tank_of};
use crate::machine::{
    ACCOUNT, CONTACT_LOSS, DRAG_LOSS, DRIVE, JOINT_LOSS, OUTSIDE, Owner, STANDING, Touch, WORKS,
};
use crate::spatial::Vec3;
use crate::tree::Pose;

impl Sim<'_> {
    /// Where every body is.
    pub fn pose(&self) -> Pose {
        let mut pose = Pose::default();
        pose.set(
            &self.machine.mechanism.tree,
            self.coordinates(),
            self.velocities(),
        );
        pose
    }

    /// Chamber pressure (Pa) of leg `leg`; 0 for one without a chamber.
    pub fn pressure(&self, leg: usize) -> f64 {
        let mode = &self.mode.legs[leg];
        let part = &self.machine.mechanism.legs[leg];
        match (part.leg.chamber(), &mode.piece) {
            _ if part.leg.feed.is_some() => self.y[self.layout.gas() + leg] * MEGA,
            (Some(chamber), Some(piece)) => {
                chamber.pressure(piece.flow, self.y[self.layout.gas() + leg])
            }
            _ => 0.0,
        }
    }

    /// Pressure (Pa, absolute) and temperature (K) of the gas in the tank; none for legs that are not
    /// fed from one.
    pub fn tank(&self) -> Option<[f64; 2]> {
        let feed = self.machine.mechanism.feed()?;
        feed.tank?;
        let tank = tank_of(self.layout, feed, &self.y);
        Some([tank.pressure, feed.tank_temperature(tank)])
    }

    /// Gas (kg) in the tank and in all chambers with their tubes; none for legs that are not fed.
    pub fn gas(&self) -> Option<f64> {
        let feed = self.machine.mechanism.feed()?;
        let legs = self.machine.mechanism.legs.iter().enumerate();
        let held = legs.filter_map(|(leg, part)| {
            let feed = part.leg.feed.as_ref()?;
            Some(gas_of(self.layout, feed, leg, &self.y).mass)
        });
        Some(tank_of(self.layout, feed, &self.y).mass + held.sum::<f64>())
    }

    /// The contacts that are closed, with their forces.
    pub fn contacts(&mut self) -> Vec<Contact> {
        self.machine.look(&self.y, &self.mode);
        self.machine
            .touches
            .iter()
            .map(|touch| self.contact(touch))
            .collect()
    }

    /// From now on fixed steps keep the ground's impulses on points for [`impulses`](Self::impulses).
    pub fn keep_impulses(&mut self) {
        if let Some(fixed) = &mut self.fixed {
            fixed.impulses.get_or_insert_default();
        }
    }

    /// The ground's impulses (N s, world axes) on points, each with its point, in the fixed steps since the last call; none
    /// where the steps have no fixed length, or nobody [asked](Self::keep_impulses) for them.
    ///
    /// Over the time they are the mean forces. [`contacts`](Self::contacts) has the forces that would hold the present state:
    /// of several feet that hold a fixed step's motion against each other these can be far greater.
    pub fn impulses(&mut self) -> Option<Vec<(usize, Vec3)>> {
        let fixed = self.fixed.as_mut()?;
        fixed.impulses.as_mut().map(std::mem::take)
    }

    pub(super) fn contact(&self, touch: &Touch) -> Contact {
        let c = touch.contact;
        let normal = touch
            .spring
            .map_or_else(|| self.machine.normal_force(c), |f| f.max(0.0));
        let mut parts = Vec3::new(normal, 0.0, 0.0);
        for (axis, (standing, slipping, width)) in self.machine.friction().into_iter().enumerate() {
            if standing == 0.0 {
                continue;
            }
            match self.mode.contacts[c].grips[axis] {
                Grip::Held => {
                    for (k, force) in self
                        .machine
                        .force_of(Owner::Tangent(c, axis))
                        .iter()
                        .enumerate()
                    {
                        parts[1 + axis + k] = *force;
                    }
                }
                Grip::Low => parts[1 + axis] = -slipping * normal,
                Grip::High => parts[1 + axis] = slipping * normal,
                Grip::Along(d) => {
                    let speed = touch.speeds.y.hypot(touch.speeds.z);
                    let way = if speed > STANDING {
                        [touch.speeds.y / speed, touch.speeds.z / speed]
                    } else {
                        d
                    };
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
            force: touch.normal * parts.x + touch.along * parts.y + touch.across * parts.z,
            parts,
            slip: [touch.speeds.y, touch.speeds.z],
        }
    }

    /// The force (N or N m) that holds the joint of `body`, 0 where it moves.
    pub fn joint_reaction(&mut self, body: usize) -> f64 {
        self.machine.look(&self.y, &self.mode);
        self.machine.first_force_of(Owner::Joint(body))
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
        for part in &mechanism.legs {
            let extension = self.y[mechanism.tree.coordinate_of(part.body)];
            springs += part.leg.spring_energy(extension);
        }
        if let Some((stiffness, _)) = mechanism.material.compliance {
            let closed = self
                .mode
                .contacts
                .iter()
                .enumerate()
                .filter(|(_, c)| c.closed);
            springs += closed
                .map(|(c, _)| {
                    let (p, s) = self.machine.pairs[c];
                    let point = &mechanism.points[p];
                    let center = pose.frames[point.body].point(&point.center);
                    let gap = mechanism.surfaces[s].proximity(&center).distance - point.radius;
                    let depth = gap.min(0.0);
                    0.5 * stiffness * depth * depth
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
            outside: works[OUTSIDE],
            impacts: self.impacts,
            stops: self.stops,
            approximate: self.machine.problem.approximate,
        }
    }

    /// What leg `leg` has done so far; all 0 where [`Settings::accounts`](super::Settings) is off.
    pub fn account(&self, leg: usize) -> Account {
        let Some(at) = self.layout.account(leg) else {
            return Account::default();
        };
        let at = self.layout.works() + at;
        let chamber = self.machine.mechanism.legs[leg].leg.chamber();
        let per_mass = chamber.map_or(1.0, saltus_pneumatics::Chamber::pressure_per_mass);
        let [drive, lost, supplied, released, pushed] = self.y[at..at + ACCOUNT] else {
            return Account::default();
        };
        Account {
            drive,
            lost,
            supplied: supplied / per_mass,
            released: released / per_mass,
            pushed,
        }
    }

    /// What is in the chamber of leg `leg`, P V (J); 0 for a leg without a chamber.
    pub fn stored_gas(&self, leg: usize) -> f64 {
        let part = &self.machine.mechanism.legs[leg];
        let extension = self.y[self.machine.mechanism.tree.coordinate_of(part.body)];
        let feed = part.leg.feed.as_ref();
        let plain = || part.leg.chamber().map(|c| c.volume(extension));
        let volume = feed
            .map(|feed| feed.volume_at(extension, self.pressure(leg)))
            .or_else(plain);
        volume.map_or(0.0, |volume| self.pressure(leg) * volume)
    }
}

/// A contact at an instant.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// Number of the point.
    pub point: usize,
    /// Number of the surface.
    pub surface: usize,
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
    /// Energy in the springs of joints, legs and compliant contacts.
    pub springs: f64,
    /// Work of the drives so far.
    pub drive: f64,
    /// Lost so far in joints and legs: in dry friction and dampers.
    pub joints: f64,
    /// Lost so far where feet slip, and in the ground's dampers.
    pub contacts: f64,
    /// Lost so far to the air.
    pub drag: f64,
    /// Work so far of what pushes from outside.
    pub outside: f64,
    /// Lost so far in impacts.
    pub impacts: f64,
    /// Of `impacts`, what was lost where a joint met its stop.
    pub stops: f64,
    /// Fixed steps so far whose contact forces obey the laws only nearly: to 1 mm/s, and to 1e-4 of the greatest force.
    pub approximate: usize,
}

/// What a leg has done since the start.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Account {
    /// Work of its drive (J), of the gauge pressure in a pneumatic leg.
    pub drive: f64,
    /// Lost in it (J): in friction and dampers.
    pub lost: f64,
    /// Gas (kg) from the supply.
    pub supplied: f64,
    /// Gas (kg) to the surroundings, less what came back from them.
    pub released: f64,
    /// Work ∫P dV (J) of its gas, at the absolute pressure.
    pub pushed: f64,
}

impl Ledger {
    /// What, between `start` and `self`, no entry explains (J).
    pub fn residual(&self, start: &Ledger) -> f64 {
        let stored = |l: &Ledger| l.kinetic + l.potential + l.springs;
        let lost = |l: &Ledger| l.joints + l.contacts + l.drag + l.impacts - l.drive - l.outside;
        stored(self) - stored(start) + lost(self) - lost(start)
    }
}
