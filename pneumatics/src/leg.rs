//! The axial force of a leg, whatever drives it.

use std::sync::Arc;

use saltus_numeric::{Scalar, Single};
use saltus_robot::{Robot, Term};

use crate::chamber::Chamber;
use crate::contractor::Contractor;
use crate::feed::Feed;
use crate::table::ForceSurface;

/// A leg: its drive and everything that resists it.
#[derive(Clone, Debug)]
pub struct Leg<S> {
    /// Greatest extension (m).
    pub stroke: S,
    /// From the command to the first flow or force (s).
    pub delay: S,
    /// From the end of the command to the end of the flow (s), where it is not the same.
    closing_delay: Option<S>,
    /// How the gas comes to the chamber, where that takes more than a supply that never changes and a
    /// valve at the chamber that switches at once.
    pub feed: Option<Feed<S>>,
    /// Shortest command that the valve follows (s).
    least_pulse: S,
    /// What pushes.
    pub drive: Drive<S>,
    /// β (N s/m).
    viscous: S,
    /// F_f (N).
    coulomb: S,
    /// Seal friction for each pascal of gauge pressure (N/Pa).
    seal: S,
    /// Return spring (N/m, N).
    spring: Option<(S, S)>,
    /// End-stop cushion.
    cushion: Option<Cushion<S>>,
    /// See [`Leg::is_plain`].
    plain: bool,
}

/// End-stop cushion: where it begins (m), its stiffness (N/m) and damping (N s/m).
#[derive(Clone, Copy, Debug)]
struct Cushion<S> {
    start: S,
    stiffness: S,
    damping: S,
}

/// What pushes the leg out.
#[derive(Clone, Debug)]
pub enum Drive<S> {
    /// A chamber under pressure.
    Pneumatic(Chamber<S>),
    /// A muscle under pressure, with the ambient one (Pa).
    Muscle(Box<Contractor<S>>, S),
    /// A spring released from compression: stiffness (N/m), compression at d = 0 (m).
    Spring(S, S),
    /// A constant force (N).
    Constant(S),
    /// A measured force over extension and speed.
    Table(Arc<ForceSurface>),
}

/// An axial force (N) and how it changes.
#[derive(Clone, Copy, Debug)]
pub struct Force<S> {
    /// The force F on the wheel (N); positive pushes it away from the foot.
    pub value: S,
    /// ∂F/∂d (N/m).
    pub wrt_extension: S,
    /// ∂F/∂ḋ (N s/m).
    pub wrt_speed: S,
    /// ∂F/∂P (m²).
    pub wrt_pressure: S,
}

/// What switches the force of a leg on and off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// The drive pushes: the valve is open, or the latch is off.
    pub energized: bool,
    /// The leg is inside its end-stop cushion.
    pub cushioned: bool,
}

impl<S: Scalar> Leg<S> {
    /// The leg of `robot`; `lift` turns the value of a term into a number of the wanted kind.
    pub fn new(robot: &Robot, lift: impl Fn(Term, f64) -> S + Copy) -> Leg<S> {
        use saltus_robot::Drive as Kind;
        let leg = &robot.leg;
        let stroke = lift(Term::Stroke, leg.stroke);
        let travel = travel_time(robot, lift);
        let after_travel = |delay: S| travel.map_or(delay, |travel| delay + travel);
        let feed = leg.cylinder().and_then(|c| Feed::new(robot, c, lift));
        Leg {
            plain: feed.is_none() && is_plain(robot),
            stroke,
            delay: after_travel(lift(Term::Delay, leg.delay)),
            closing_delay: leg
                .closing_delay
                .map(|delay| after_travel(lift(Term::ClosingDelay, delay))),
            feed,
            least_pulse: lift(Term::LeastPulse, leg.least_pulse),
            drive: match &leg.drive {
                Kind::Pneumatic(c) => match Contractor::new(robot, c, lift) {
                    Some(muscle) => Drive::Muscle(
                        Box::new(muscle),
                        lift(Term::Ambient, robot.environment.ambient.0),
                    ),
                    None => Drive::Pneumatic(Chamber::new(robot, c, lift)),
                },
                Kind::Spring {
                    stiffness,
                    compression,
                } => Drive::Spring(
                    lift(Term::SpringStiffness, *stiffness),
                    lift(Term::Compression, *compression),
                ),
                Kind::Constant { force } => Drive::Constant(lift(Term::Force, *force)),
                Kind::Table(table) => Drive::Table(Arc::new(ForceSurface::new(table))),
            },
            viscous: lift(Term::ViscousFriction, leg.viscous_friction),
            coulomb: lift(Term::CoulombFriction, leg.coulomb_friction),
            seal: lift(
                Term::SealFriction,
                leg.cylinder().map_or(0.0, |c| c.seal_friction),
            ),
            spring: leg.return_spring.map(|spring| {
                (
                    lift(Term::ReturnStiffness, spring.stiffness),
                    lift(Term::ReturnPreload, spring.preload),
                )
            }),
            cushion: leg.cushion.map(|c| Cushion {
                start: stroke - lift(Term::CushionLength, c.length),
                stiffness: lift(Term::CushionStiffness, c.stiffness),
                damping: lift(Term::CushionDamping, c.damping),
            }),
        }
    }

    /// Whether the drive is switched off again a valve opening time after it was switched on: all
    /// but a released spring, which is not caught again.
    ///
    /// Source: docs/model.md, "The valve opening time".
    pub fn has_valve(&self) -> bool {
        !matches!(self.drive, Drive::Spring(..))
    }

    /// Time (s) from a command to the drive's answer: to switch on, or off.
    pub fn delay(&self, on: bool) -> S {
        let closing = self.closing_delay.filter(|_| !on);
        closing.unwrap_or(self.delay)
    }

    /// When (s) the drive begins and ends to push for a command at the time `at` (s) of the valve
    /// opening time `opening` (s); none: it does not end. A command shorter than the valve's least
    /// pulse is one of no time.
    ///
    /// Source: thesis 6.3.2, in which pulses of 1 ms did not move the valves.
    #[inline(always)]
    pub fn answers(&self, at: S, opening: S) -> (S, Option<S>) {
        let begins = at + self.delay;
        let is_ignored = opening.less(self.least_pulse);
        let ends = || match self.closing_delay {
            None => begins + S::select(is_ignored, || S::of(0.0), || opening),
            // A valve that closes faster than it opens may not come to open.
            Some(delay) => S::select(is_ignored, || begins, || (at + opening + delay).max(begins)),
        };
        (begins, self.has_valve().then(ends))
    }

    /// Whether the leg is a pneumatic one without optional terms, so that its force is
    /// [`plain_force`](Self::plain_force).
    pub fn is_plain(&self) -> bool {
        self.plain
    }

    /// The chamber, if the leg is pneumatic.
    #[inline(always)]
    pub fn chamber(&self) -> Option<&Chamber<S>> {
        match &self.drive {
            Drive::Pneumatic(chamber) => Some(chamber),
            _ => None,
        }
    }

    /// Force (N) of a plain pneumatic leg that extends at `speed` (m/s) under pressure `p` (Pa):
    /// the terms that no option switches.
    ///
    /// F = (P − P_a) A − β ḋ − F_f
    #[inline(always)]
    pub fn plain_force(&self, chamber: &Chamber<S>, speed: S, p: S) -> Force<S> {
        let push = (p - chamber.ambient).mul_add(chamber.area, -self.coulomb);
        Force {
            value: (-self.viscous).mul_add(speed, push),
            wrt_extension: S::of(0.0),
            wrt_speed: -self.viscous,
            wrt_pressure: chamber.area,
        }
    }

    /// The force of the drive alone, before friction and springs, times speed is the power (W) that
    /// it gives.
    ///
    /// Friction, springs and cushion take `drive_force − force` times speed.
    #[inline(always)]
    pub fn plain_drive_force(&self, chamber: &Chamber<S>, p: S) -> S {
        (p - chamber.ambient) * chamber.area
    }
}

/// Terms of a leg that a plain one may have: those of [`Leg::plain_force`], of [`Leg::answers`] and of the
/// valve's law in the chamber, those that no stance in the plane contains, and those of a [`Feed`], which a
/// plain leg does not have.
const PLAIN: [Term; 24] = [
    Term::Stroke,
    Term::Delay,
    Term::ClosingDelay,
    Term::LeastPulse,
    Term::ViscousFriction,
    Term::CoulombFriction,
    Term::HeatRatio,
    Term::GasConstant,
    Term::Bore,
    Term::DeadVolume,
    Term::Supply,
    Term::DischargeCoefficient,
    Term::OrificeRadius,
    Term::Temperature,
    Term::PolytropicExponent,
    Term::RodLength,
    Term::RodRadius,
    Term::LegCenter,
    Term::LegMass,
    Term::PickedUp,
    Term::SpoolTime,
    Term::TubeLength,
    Term::TubeDiameter,
    Term::TubeRoughness,
];

/// Whether the leg of `robot` is a piston all of whose terms but those of [`PLAIN`] are off. A term that
/// is new is none of these.
fn is_plain(robot: &Robot) -> bool {
    let is_off = |term: &Term| match term.of(robot) {
        None => true,
        Some(value) => term.off(robot) == Some(value),
    };
    let of_the_leg = |term: &&Term| term.spec().section().starts_with("leg");
    let mut others = Term::ALL
        .iter()
        .filter(of_the_leg)
        .filter(|term| !PLAIN.contains(term));
    robot.leg.cylinder().is_some_and(|c| c.muscle.is_none()) && others.all(is_off)
}

/// Time (s) that a pressure wave takes through the tube of the leg of `robot`: its length over
/// √(κ R T); none without a tube.
fn travel_time<S: Scalar>(robot: &Robot, lift: impl Fn(Term, f64) -> S) -> Option<S> {
    let cylinder = robot.leg.cylinder()?;
    let tube = cylinder.tube.filter(|tube| tube.length > 0.0)?;
    let square = S::of(cylinder.gas.heat_ratio * cylinder.gas.constant)
        * lift(Term::Temperature, cylinder.temperature);
    Some(lift(Term::TubeLength, tube.length) / square.sqrt())
}

impl<S: Single> Leg<S> {
    /// The extension (m) at which the cushion begins.
    pub fn cushion_start(&self) -> Option<S> {
        self.cushion.map(|c| c.start)
    }

    /// Force of the drive alone (N), with its derivatives.
    #[inline(always)]
    pub fn drive_force(&self, switches: Switches, d: S, speed: S, p: S) -> Force<S> {
        let zero = S::of(0.0);
        let on = |f: S| if switches.energized { f } else { zero };
        let constant = |value: S| Force {
            value,
            wrt_extension: zero,
            wrt_speed: zero,
            wrt_pressure: zero,
        };
        match &self.drive {
            Drive::Pneumatic(chamber) => Force {
                wrt_pressure: chamber.area,
                ..constant(self.plain_drive_force(chamber, p))
            },
            Drive::Muscle(muscle, ambient) => {
                let [value, wrt_extension, wrt_pressure] = muscle.at(d, p - *ambient).force;
                Force {
                    wrt_extension,
                    wrt_pressure,
                    ..constant(value)
                }
            }
            // Not cut off at 0, where the stance ends: so the event is one of a smooth function.
            Drive::Spring(stiffness, compression) => Force {
                wrt_extension: on(-*stiffness),
                ..constant(on(*stiffness * (*compression - d)))
            },
            Drive::Constant(force) => constant(on(*force)),
            Drive::Table(surface) => {
                let (value, wrt_extension, wrt_speed) = surface.force(d, speed);
                Force {
                    wrt_extension: on(wrt_extension),
                    wrt_speed: on(wrt_speed),
                    ..constant(on(value))
                }
            }
        }
    }

    /// Force (N), ≤ 0, by which [`drive_force`](Self::drive_force) pulls at extension `d` (m) where
    /// a spring is past its free length. The spring is slack there: a model that goes on past the
    /// end of the push takes this off.
    pub fn slack_pull(&self, switches: Switches, d: S) -> S {
        match self.drive {
            Drive::Spring(stiffness, compression)
                if switches.energized && d.value() > compression.value() =>
            {
                stiffness * (compression - d)
            }
            _ => S::of(0.0),
        }
    }

    /// Force (N) by which the return spring and the spring of the cushion set themselves against extension at `d` (m).
    pub fn spring_pull(&self, switches: Switches, d: S) -> S {
        let zero = S::of(0.0);
        let spring = self
            .spring
            .map_or(zero, |(stiffness, preload)| stiffness.mul_add(d, preload));
        let cushion = self.cushion.filter(|_| switches.cushioned);
        spring + cushion.map_or(zero, |c| c.stiffness * (d - c.start))
    }

    /// Energy (J) in the return spring and the spring of the cushion at extension `d` (m), 0 at no extension.
    pub fn spring_energy(&self, d: S) -> S {
        let zero = S::of(0.0);
        let half = S::of(0.5);
        let spring = self.spring.map_or(zero, |(stiffness, preload)| {
            (half * stiffness).mul_add(d, preload) * d
        });
        let pressed = |c: &Cushion<S>| (d - c.start).max(zero);
        spring
            + self
                .cushion
                .map_or(zero, |c| half * c.stiffness * pressed(&c) * pressed(&c))
    }

    /// Whether dry friction ever sets itself against motion: that of the rod, or of the seal under
    /// pressure.
    pub fn has_dry_friction(&self) -> bool {
        self.coulomb.value() > 0.0 || self.seal.value() > 0.0
    }

    /// What dry friction (N) sets against motion at the chamber pressure `p` (Pa): that of the rod,
    /// and of the seal.
    pub fn dry_friction(&self, p: S) -> S {
        match self.chamber() {
            Some(chamber) => self.seal.mul_add((p - chamber.ambient).abs(), self.coulomb),
            None => self.coulomb,
        }
    }

    /// Force F (N) on the wheel of a leg at extension `d` (m) that extends at `speed` (m/s) ≥ 0
    /// under the chamber pressure `p` (Pa; ignored by the drives that have none).
    ///
    /// F = drive − β ḋ − F_f − seal (P − P_a) − (k d + preload) − cushion
    ///
    /// Source: docs/model.md, "Force of the leg"; the optional terms as in the robot file.
    #[inline(always)]
    pub fn force(&self, switches: Switches, d: S, speed: S, p: S) -> Force<S> {
        let mut f = self.drive_force(switches, d, speed, p);
        f.value = f.value - self.viscous.mul_add(speed, self.coulomb);
        f.wrt_speed = f.wrt_speed - self.viscous;
        if let Some(chamber) = self.chamber()
            && self.seal.value() > 0.0
        {
            let gauge = p - chamber.ambient;
            let sign = if gauge.value() < 0.0 {
                -self.seal
            } else {
                self.seal
            };
            f.value = f.value - sign * gauge;
            f.wrt_pressure = f.wrt_pressure - sign;
        }
        if let Some((stiffness, preload)) = self.spring {
            f.value = f.value - stiffness.mul_add(d, preload);
            f.wrt_extension = f.wrt_extension - stiffness;
        }
        if let (true, Some(c)) = (switches.cushioned, self.cushion) {
            f.value = f.value - c.stiffness * (d - c.start) - c.damping * speed;
            f.wrt_extension = f.wrt_extension - c.stiffness;
            f.wrt_speed = f.wrt_speed - c.damping;
        }
        f
    }
}
