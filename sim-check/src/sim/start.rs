//! Where a motion starts.

use saltus_pneumatics::Piece;

use super::{Settings, Sim, Stepping};
use crate::SimError;
use crate::error::{not_negative, positive, require};
use crate::machine::Layout;
use crate::mechanism::Mechanism;
use crate::mode::{ContactMode, JointMode, LegMode, Mode};
use crate::tree::{Joint, Tree};

impl Sim<'_> {
    /// Closes what touches at the start.
    pub(super) fn begin(&mut self) -> Result<(), SimError> {
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
}

/// The mode of a mechanism that stands as `y` says: legs latched, chambers at ambient pressure.
pub(super) fn first_mode(mechanism: &Mechanism, y: &mut [f64], layout: Layout) -> Mode {
    let mut joints: Vec<JointMode> = mechanism
        .joints
        .iter()
        .map(|parts| {
            if parts.friction > 0.0 {
                JointMode::Sliding(1.0)
            } else {
                JointMode::Free
            }
        })
        .collect();
    let mut legs = Vec::new();
    for (i, part) in mechanism.legs.iter().enumerate() {
        joints[part.body] = JointMode::Latched;
        let piece = part.leg.chamber().map(|chamber| {
            let piece = Piece::new(chamber, false, chamber.ambient, 0.0, false);
            y[layout.gas() + i] = chamber.variable(piece.flow, chamber.ambient);
            piece
        });
        legs.push(LegMode {
            energized: false,
            cushioned: false,
            port_open: false,
            piece,
        });
    }
    let pairs = mechanism.pairs().count();
    Mode {
        joints,
        contacts: vec![ContactMode::OPEN; pairs],
        legs,
    }
}

pub(super) fn check_start(
    mechanism: &Mechanism,
    q: &[f64],
    v: &[f64],
    settings: &Settings,
) -> Result<(), SimError> {
    check_state(&mechanism.tree, q, v)?;
    settings.check()?;
    check_quaternions(&mechanism.tree, q)?;
    mechanism.check(q)?;
    let tree = &mechanism.tree;
    let bodies = tree.bodies().iter().enumerate();
    for (i, body) in bodies.filter(|(_, body)| body.joint != Joint::Free) {
        let (x, (low, high)) = (q[tree.coordinate_of(i)], mechanism.stops(i));
        if x < low || x > high {
            return Err(SimError::BeyondStop {
                body: body.name.clone(),
                value: x,
                low,
                high,
            });
        }
    }
    Ok(())
}

fn check_state(tree: &Tree, q: &[f64], v: &[f64]) -> Result<(), SimError> {
    for (name, given, wanted) in [
        ("coordinates", q.len(), tree.coordinates()),
        ("velocities", v.len(), tree.velocities()),
    ] {
        if given != wanted {
            return Err(SimError::Length {
                name,
                given,
                wanted,
            });
        }
    }
    for (name, list) in [("coordinate", q), ("velocity", v)] {
        for x in list {
            require(x.abs() < 1e9, name, *x, "a finite number below 1e9")?;
        }
    }
    Ok(())
}

fn check_quaternions(tree: &Tree, q: &[f64]) -> Result<(), SimError> {
    let bodies = tree.bodies().iter().enumerate();
    for (i, _) in bodies.filter(|(_, body)| body.joint == Joint::Free) {
        let iq = tree.coordinate_of(i);
        let length = q[iq + 3..iq + 7].iter().map(|x| x * x).sum::<f64>().sqrt();
        let is_unit = (length - 1.0).abs() <= 1e-3;
        require(is_unit, "quaternion's length", length, "1 to within 1e-3")?;
    }
    Ok(())
}

impl Settings {
    fn check(&self) -> Result<(), SimError> {
        positive("tolerance", self.tolerance)?;
        positive("longest step (s)", self.longest_step)?;
        if let Stepping::Fixed(h) = self.stepping {
            let is_sound = h > 0.0 && h <= Stepping::LONGEST;
            require(is_sound, "fixed step (s)", h, "above 0, at most 0.1")?;
        }
        not_negative("rest speed (m/s)", self.rest_speed)?;
        not_negative("penetration (m)", self.penetration)
    }
}
