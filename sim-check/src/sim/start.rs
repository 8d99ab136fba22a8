//! Where a motion starts.

use saltus_pneumatics::Piece;

use super::{Settings, Sim, Stepping};
use crate::SimError;
use crate::error::{length, not_negative, positive, require};
use crate::feeding::{put_gas, put_tank};
use crate::machine::{Layout, STANDING};
use crate::mechanism::Mechanism;
use crate::mode::{ContactMode, JointMode, LegMode, Mode, Spool};
use crate::tree::{Joint, Tree};

/// A leg at the start of a motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LegStart {
    /// Chamber pressure (Pa, absolute), > 0; of no meaning for a leg without a chamber.
    pub pressure: f64,
    /// From when and until when (s) its valve is open, the drive's delay included; from before 0:
    /// it is open at the start. None, or until before 0: it is at rest.
    pub valve: Option<[f64; 2]>,
}

impl Sim<'_> {
    /// Puts the legs where a motion has brought them, before it is decided who holds and who moves.
    pub(super) fn start_legs(&mut self, legs: &[LegStart]) -> Result<(), SimError> {
        let mechanism = self.machine.mechanism;
        length("legs at the start", legs.len(), mechanism.legs.len())?;
        for (i, (part, start)) in mechanism.legs.iter().zip(legs).enumerate() {
            positive("chamber pressure at the start (Pa)", start.pressure)?;
            let extension = self.y[mechanism.tree.coordinate_of(part.body)];
            let chamber = part.leg.chamber();
            let is_past = |place: Option<f64>| place.is_some_and(|place| extension > place);
            let is_open = self.schedule(i, start.valve)?;
            let mode = &mut self.mode.legs[i];
            mode.cushioned = is_past(part.leg.cushion_start());
            mode.port_open = is_past(chamber.and_then(saltus_pneumatics::Chamber::port));
            mode.energized = is_open;
            self.put_on_piece(i, start.pressure, 0.0);
            if let Some(feed) = &part.leg.feed {
                let held = feed.at_pressure(start.pressure, extension);
                put_gas(self.layout, feed, i, held, &mut self.y);
                self.mode.legs[i].spool = Spool::default();
                if is_open {
                    // As long ago as it takes to be open.
                    self.mode.legs[i].spool = Spool::default().turned(feed, true, f64::MAX);
                }
            }
            if !part.massless {
                let speed = self.machine.joint_speed(&self.y, part.body);
                self.mode.joints[part.body] = if speed.abs() > STANDING {
                    self.moving(part.body, speed.signum())
                } else {
                    JointMode::Held(self.stop_of(part.body))
                };
            }
        }
        let later = |a: &(f64, usize, bool), b: &(f64, usize, bool)| {
            b.0.total_cmp(&a.0).then(a.2.cmp(&b.2))
        };
        self.commands.sort_by(later);
        self.machine.weld(&self.mode, &self.y);
        Ok(())
    }

    /// Puts down when the valve of leg `leg` opens and closes; whether it is open at the start.
    fn schedule(&mut self, leg: usize, valve: Option<[f64; 2]>) -> Result<bool, SimError> {
        let Some([from, until]) = valve.filter(|[_, until]| *until > 0.0) else {
            return Ok(false);
        };
        let is_sound = from < until && until.is_finite();
        let allowed = "after it opens, and finite";
        require(is_sound, "when a valve closes (s)", until, allowed)?;
        self.commands.push((until, leg, false));
        if from > 0.0 {
            self.commands.push((from, leg, true));
        }
        Ok(from <= 0.0)
    }

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
        if let Some(feed) = &part.leg.feed {
            let extension = y[mechanism.tree.coordinate_of(part.body)];
            put_gas(layout, feed, i, feed.at_rest(extension), y);
            put_tank(layout, feed, feed.full(), y);
        }
        let plain = part.leg.chamber().filter(|_| part.leg.feed.is_none());
        let piece = plain.map(|chamber| {
            let piece = Piece::new(chamber, false, chamber.ambient, 0.0, false);
            y[layout.gas() + i] = chamber.variable(piece.flow, chamber.ambient);
            piece
        });
        legs.push(LegMode {
            energized: false,
            cushioned: false,
            port_open: false,
            piece,
            spool: Spool::default(),
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
    length("coordinates", q.len(), tree.coordinates())?;
    length("velocities", v.len(), tree.velocities())?;
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
