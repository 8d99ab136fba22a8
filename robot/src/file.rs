//! The robot file: its keys, and the robot that they describe.
//!
//! The document itself serves as the file's struct. With serde, each quantity would be one optional
//! field for each of its units, and a value's line would be lost to the checks that come after.

use crate::document::Node;
use crate::domain::Domain;
use crate::files::Files;
use crate::rig::{boom, foot, ground, leg_body};
use crate::section::Section;
use crate::table::force_table;
use crate::units::{
    ACCELERATION, ANGLE, ANGULAR_RATE, AREA, DAMPING, FORCE, FORCE_PER_PRESSURE, GAS_CONSTANT,
    INERTIA, LENGTH, MASS, NUMBER, PER_LENGTH, PRESSURE, PRESSURE_PER_FLOW, STIFFNESS, TEMPERATURE,
    TIME, TORQUE, VOLUME,
};
use crate::{
    AbsolutePressure, Body, Cushion, Cylinder, Drive, Environment, Errors, ExhaustPort, Gas,
    GaugePressure, Leg, ReturnSpring, Robot, RobotError,
};

const POSITIVE: Domain = Domain::POSITIVE;
const NON_NEGATIVE: Domain = Domain::NON_NEGATIVE;

/// The robot that `document` describes; files that it names are found in `files`.
pub(crate) fn robot(document: Node, files: Files) -> Result<Robot, RobotError> {
    let mut s = Section::new(String::new(), document)?;
    let name = s.text("name");
    let (body_table, leg_table, environment_table) =
        (s.table("body"), s.table("leg"), s.table("environment"));
    let errors = s.optional_table("errors", errors);
    let (foot, ground) = (
        s.optional_table("foot", foot),
        s.optional_table("ground", ground),
    );
    // What may stand there depends on the body.
    let boom_table = s.optional_table("boom", Ok);
    s.finish(())?;

    let environment = environment(environment_table)?;
    let body = body(body_table)?;
    Ok(Robot {
        name,
        body,
        leg: leg(leg_table, &body, environment.ambient, files)?,
        boom: boom_table.map(|s| boom(s, body.mass)).transpose()?,
        foot: foot.unwrap_or_default(),
        ground: ground.unwrap_or_default(),
        environment,
        errors: errors.unwrap_or_default(),
    })
}

fn body(mut s: Section) -> Result<Body, RobotError> {
    let body = Body {
        mass: s.number("mass", MASS, POSITIVE),
        inertia: s.number("inertia", INERTIA, NON_NEGATIVE),
        radius: s.number("wheel_radius", LENGTH, POSITIVE),
        legs: s.count("legs"),
        imbalance: s.optional("imbalance", LENGTH, NON_NEGATIVE).unwrap_or(0.0),
        imbalance_angle: s
            .optional("imbalance_angle", ANGLE, Domain::FINITE)
            .unwrap_or(0.0),
        axle_friction: s
            .optional("axle_friction", TORQUE, NON_NEGATIVE)
            .unwrap_or(0.0),
    };
    s.finish(body)
}

fn environment(mut s: Section) -> Result<Environment, RobotError> {
    let environment = Environment {
        gravity: s.number("gravity", ACCELERATION, NON_NEGATIVE),
        ambient: AbsolutePressure(s.number("ambient_pressure", PRESSURE, POSITIVE)),
        drag: s.optional("drag", PER_LENGTH, NON_NEGATIVE).unwrap_or(0.0),
    };
    s.finish(environment)
}

fn errors(mut s: Section) -> Result<Errors, RobotError> {
    let errors = Errors {
        rate: s
            .optional("rate", ANGULAR_RATE, NON_NEGATIVE)
            .unwrap_or(0.0),
        firing_angle: s
            .optional("firing_angle", ANGLE, NON_NEGATIVE)
            .unwrap_or(0.0),
        valve_open: s.optional("valve_open", TIME, NON_NEGATIVE).unwrap_or(0.0),
        supply: s
            .optional("supply_pressure", PRESSURE, NON_NEGATIVE)
            .unwrap_or(0.0),
    };
    s.finish(errors)
}

/// What a leg's `kind` names.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Pneumatic,
    Spring,
    Constant,
    Table,
}

const KINDS: [(&str, Kind); 4] = [
    ("pneumatic", Kind::Pneumatic),
    ("spring", Kind::Spring),
    ("constant", Kind::Constant),
    ("table", Kind::Table),
];

fn leg(
    mut s: Section,
    body: &Body,
    ambient: AbsolutePressure,
    files: Files,
) -> Result<Leg, RobotError> {
    let kind = s.choice("kind", &KINDS, "pneumatic, spring, constant or table");
    // Without its kind, nobody knows the leg's keys.
    s.stop_at_problem()?;
    let delay = if kind == Kind::Pneumatic {
        "valve_delay"
    } else {
        "release_delay"
    };
    let stroke = s.number("stroke", LENGTH, POSITIVE);
    let leg = Leg {
        stroke,
        delay: s.number(delay, TIME, NON_NEGATIVE),
        viscous_friction: s.number("viscous_friction", DAMPING, NON_NEGATIVE),
        coulomb_friction: s.number("coulomb_friction", FORCE, NON_NEGATIVE),
        return_spring: s.optional_table("return_spring", return_spring),
        cushion: s.optional_table("cushion", |s| cushion(s, stroke)),
        drive: match kind {
            Kind::Pneumatic => Drive::Pneumatic(cylinder(&mut s, stroke, ambient)),
            Kind::Spring => Drive::Spring {
                stiffness: s.number("stiffness", STIFFNESS, POSITIVE),
                compression: s.number("compression", LENGTH, POSITIVE),
            },
            Kind::Constant => Drive::Constant {
                force: s.number("force", FORCE, POSITIVE),
            },
            Kind::Table => Drive::Table(force_table(&mut s, stroke, files)),
        },
        body: leg_body(&mut s, body),
    };
    s.finish(leg)
}

fn return_spring(mut s: Section) -> Result<ReturnSpring, RobotError> {
    let spring = ReturnSpring {
        stiffness: s.number("stiffness", STIFFNESS, NON_NEGATIVE),
        preload: s.number("preload", FORCE, NON_NEGATIVE),
    };
    s.finish(spring)
}

fn cushion(mut s: Section, stroke: f64) -> Result<Cushion, RobotError> {
    let cushion = Cushion {
        length: s.number("length", LENGTH, POSITIVE.below(stroke)),
        stiffness: s.number("stiffness", STIFFNESS, NON_NEGATIVE),
        damping: s.number("damping", DAMPING, NON_NEGATIVE),
    };
    s.finish(cushion)
}

fn cylinder(s: &mut Section, stroke: f64, ambient: AbsolutePressure) -> Cylinder {
    let gas = gas(s);
    let polytropic = Domain::at_least(1.0).up_to(gas.heat_ratio);
    Cylinder {
        bore: s.number("bore", LENGTH, POSITIVE),
        dead_volume: s.number("dead_volume", VOLUME, POSITIVE),
        supply: supply(s, ambient),
        discharge_coefficient: s.number("discharge_coefficient", NUMBER, POSITIVE.up_to(1.0)),
        orifice_radius: s.number("orifice_radius", LENGTH, POSITIVE),
        gas,
        temperature: s.number("gas_temperature", TEMPERATURE, POSITIVE),
        supply_droop: s
            .optional("supply_droop", PRESSURE_PER_FLOW, NON_NEGATIVE)
            .unwrap_or(0.0),
        leak_area: s.optional("leak_area", AREA, NON_NEGATIVE).unwrap_or(0.0),
        exhaust_port: s.optional_table("exhaust_port", |s| exhaust_port(s, stroke)),
        polytropic_exponent: s.optional("polytropic_exponent", NUMBER, polytropic),
        seal_friction: s
            .optional("seal_friction", FORCE_PER_PRESSURE, NON_NEGATIVE)
            .unwrap_or(0.0),
    }
}

/// The supply pressure above ambient, however it is given.
fn supply(s: &mut Section, ambient: AbsolutePressure) -> GaugePressure {
    let gauge = ("supply_pressure_gauge", NON_NEGATIVE);
    let absolute = ("supply_pressure_absolute", Domain::at_least(ambient.0));
    match s.one_of(&[gauge, absolute], PRESSURE) {
        (0, pressure) => GaugePressure(pressure),
        (_, pressure) => AbsolutePressure(pressure).gauge(ambient),
    }
}

const GASES: [(&str, Gas); 3] = [
    ("air", Gas::AIR),
    ("co2", Gas::CO2),
    ("nitrogen", Gas::NITROGEN),
];

/// A gas by name, or a table of its constants.
fn gas(s: &mut Section) -> Gas {
    if s.is_table("gas") {
        return s.optional_table("gas", gas_constants).unwrap_or(Gas::AIR);
    }
    s.choice(
        "gas",
        &GASES,
        "air, co2, nitrogen or a table of heat_ratio and constant_j_per_kg_k",
    )
}

fn gas_constants(mut s: Section) -> Result<Gas, RobotError> {
    let gas = Gas {
        heat_ratio: s.number("heat_ratio", NUMBER, Domain::above(1.0)),
        constant: s.number("constant", GAS_CONSTANT, POSITIVE),
    };
    s.finish(gas)
}

fn exhaust_port(mut s: Section, stroke: f64) -> Result<ExhaustPort, RobotError> {
    let port = ExhaustPort {
        position: s.number("position", LENGTH, POSITIVE.below(stroke)),
        area: s.number("area", AREA, POSITIVE),
    };
    s.finish(port)
}
