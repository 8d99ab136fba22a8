//! The keys of a robot file that describe a rig: the mass of its legs, their feet, the ground and
//! the boom.

use std::f64::consts::FRAC_PI_4;

use crate::domain::Domain;
use crate::section::Section;
use crate::units::{ANGLE, ANGULAR_STIFFNESS, DAMPING, LENGTH, MASS, NUMBER, STIFFNESS};
use crate::{Body, Boom, Counterweight, Foot, Ground, LegBody, RobotError};

const POSITIVE: Domain = Domain::POSITIVE;
const NON_NEGATIVE: Domain = Domain::NON_NEGATIVE;

/// The moving part of the leg `s`; the legs must leave some mass and inertia of `body` to the
/// wheel.
pub(crate) fn leg_body(s: &mut Section, body: &Body) -> LegBody {
    let length = s
        .optional("rod_length", LENGTH, NON_NEGATIVE)
        .unwrap_or(0.0);
    let radius = s
        .optional("rod_radius", LENGTH, NON_NEGATIVE)
        .unwrap_or(0.0);
    let at_rest = s.optional("center", LENGTH, NON_NEGATIVE);
    let shape = LegBody {
        mass: 1.0,
        center: at_rest.unwrap_or(0.0),
        length,
        radius,
    };
    let mass = s
        .optional("mass", MASS, leg_mass(body, &shape))
        .unwrap_or(0.0);
    let center = match at_rest {
        None if mass > 0.0 => s.number("center", LENGTH, NON_NEGATIVE),
        center => center.unwrap_or(0.0),
    };
    LegBody {
        mass,
        center,
        length,
        radius,
    }
}

/// The masses (kg) that legs of the shape of `unit`, a leg of 1 kg, may have on `body`.
fn leg_mass(body: &Body, unit: &LegBody) -> Domain {
    let legs = f64::from(body.legs);
    let (by_mass, by_inertia) = (
        body.mass / legs,
        body.inertia / (legs * unit.inertia_about_axle()),
    );
    // Legs without inertia (0/0) bound nothing.
    let (most, reason) = if by_inertia <= by_mass {
        (by_inertia, ", for all legs to have less than body.inertia")
    } else {
        (by_mass, ", for all legs to have less than body.mass")
    };
    let domain = if most > 0.0 {
        NON_NEGATIVE.below(most)
    } else {
        NON_NEGATIVE.up_to(0.0)
    };
    domain.because(reason)
}

/// The boom of a robot of mass `mass` (kg), which a counterweight must not outweigh.
pub(crate) fn boom(mut s: Section, robot: f64) -> Result<Boom, RobotError> {
    let mass = s.number("mass", MASS, NON_NEGATIVE);
    let length = s.number("length", LENGTH, POSITIVE);
    let boom = Boom {
        mass,
        length,
        radius: s.optional("radius", LENGTH, NON_NEGATIVE).unwrap_or(0.0),
        counterweight: s.optional_table("counterweight", |s| {
            counterweight(s, (robot + 0.5 * mass) * length)
        }),
        flex: s.optional("bending_stiffness", ANGULAR_STIFFNESS, POSITIVE),
    };
    s.finish(boom)
}

/// A counterweight to a moment `moment` (kg m) about the base.
fn counterweight(mut s: Section, moment: f64) -> Result<Counterweight, RobotError> {
    let distance = s.number("distance", LENGTH, POSITIVE);
    let balance = NON_NEGATIVE
        .up_to(moment / distance)
        .because(", which balances robot and boom");
    let counterweight = Counterweight {
        mass: s.number("mass", MASS, balance),
        distance,
    };
    s.finish(counterweight)
}

pub(crate) fn foot(mut s: Section) -> Result<Foot, RobotError> {
    let foot = Foot {
        radius: s.optional("radius", LENGTH, NON_NEGATIVE).unwrap_or(0.0),
    };
    s.finish(foot)
}

pub(crate) fn ground(mut s: Section) -> Result<Ground, RobotError> {
    let plain = Ground::default();
    let or_infinite = NON_NEGATIVE.or_infinite();
    let static_friction = s
        .optional("static_friction", NUMBER, or_infinite)
        .unwrap_or(plain.static_friction);
    let ground = Ground {
        static_friction,
        kinetic_friction: s
            .optional("kinetic_friction", NUMBER, or_infinite)
            .unwrap_or(static_friction),
        across_friction: s
            .optional("across_friction", NUMBER, NON_NEGATIVE)
            .unwrap_or(plain.across_friction),
        restitution: s
            .optional("restitution", NUMBER, NON_NEGATIVE.below(1.0))
            .unwrap_or(plain.restitution),
        stiffness: s.optional("stiffness", STIFFNESS, POSITIVE),
        damping: s
            .optional("damping", DAMPING, NON_NEGATIVE)
            .unwrap_or(plain.damping),
        slope: s
            .optional("slope", ANGLE, Domain::above(-FRAC_PI_4).below(FRAC_PI_4))
            .unwrap_or(plain.slope),
    };
    s.finish(ground)
}
