//! Where a motion starts.

use saltus_pneumatics::Piece;

use super::{Settings, Sim, Stepping};
use crate::SimError;
use crate::machine::Layout;
use crate::mechanism::Mechanism;
use crate::mode::{ContactMode, JointMode, LegMode, Mode};

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
    let pairs = mechanism.points.len() * mechanism.surfaces.len();
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
    let tree = &mechanism.tree;
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
    let wrong = |name: &str, value, allowed| {
        Err(SimError::Input {
            name: name.into(),
            value,
            allowed,
        })
    };
    for (name, list) in [("coordinate", q), ("velocity", v)] {
        if let Some(x) = list.iter().find(|x| x.is_nan() || x.abs() >= 1e9) {
            return wrong(name, *x, "a finite number below 1e9");
        }
    }
    let positive = [
        ("tolerance", settings.tolerance),
        ("longest step (s)", settings.longest_step),
    ];
    if let Some((name, value)) = positive
        .into_iter()
        .find(|(_, x)| !(*x > 0.0 && x.is_finite()))
    {
        return wrong(name, value, "a finite number > 0");
    }
    if let Stepping::Fixed(h) = settings.stepping
        && !(h > 0.0 && h <= Stepping::LONGEST)
    {
        return wrong("fixed step (s)", h, "above 0, at most 0.1");
    }
    let not_negative = [
        ("rest speed (m/s)", settings.rest_speed),
        ("penetration (m)", settings.penetration),
    ];
    if let Some((name, value)) = not_negative
        .into_iter()
        .find(|(_, x)| !(*x >= 0.0 && x.is_finite()))
    {
        return wrong(name, value, "a finite number ≥ 0");
    }
    let is_free = |i: usize| tree.bodies()[i].joint == crate::tree::Joint::Free;
    for i in (0..tree.bodies().len()).filter(|&i| is_free(i)) {
        let iq = tree.coordinate_of(i);
        let length = q[iq + 3..iq + 7].iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs() > 1e-3 {
            return wrong("quaternion's length", length, "1 to within 1e-3");
        }
    }
    mechanism.check(q)?;
    for (i, body) in tree
        .bodies()
        .iter()
        .enumerate()
        .filter(|(i, _)| !is_free(*i))
    {
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
