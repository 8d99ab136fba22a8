//! Reading a robot file: its tables, and in each of them the terms of the table of terms.
//!
//! The document itself serves as the file's struct. With serde, each quantity would be one optional
//! field for each of its units, and a value's line would be lost to the checks that come after.

use crate::document::{Node, Value};
use crate::domain::Domain;
use crate::files::Files;
use crate::in_space;
use crate::reading::terms;
use crate::section::Section;
use crate::table::{force_table, numbers};
use crate::terms::FREE_CONTRACTION;
use crate::{Boom, Cylinder, Drive, ForceTable, Gas, Muscle, Robot, RobotError, Sensors, Term};

/// The robot that `document` describes; files that it names are found in `files`.
pub(crate) fn robot(document: Node, files: Files) -> Result<Robot, RobotError> {
    let mut s = Section::new(String::new(), document)?;
    let mut robot = Robot {
        name: s.text("name"),
        ..Robot::default()
    };
    let (body, mut leg, environment) = (s.table("body"), s.table("leg"), s.table("environment"));
    for part in ["errors", "foot"] {
        s.optional_table(part, |s| table(s, part, &mut robot));
    }
    s.optional_table("sensors", |s| {
        robot.sensors = Some(Sensors::default());
        table(s, "sensors", &mut robot)
    });
    // What may stand there depends on the body.
    let (boom, struts) = (s.optional_table("boom", Ok), s.optional_table("struts", Ok));
    let (legs, ground) = (s.optional_table("legs", Ok), s.optional_table("ground", Ok));
    let tank = s.optional_table("tank", Ok);
    s.finish(())?;
    let place = body.place().clone();

    table(environment, "environment", &mut robot)?;
    body_and_legs(body, legs, &mut robot)?;
    if let Some(s) = ground {
        table(s, "ground", &mut robot)?;
    }
    robot.leg.drive = drive(&mut leg)?;
    read_leg(leg, &mut robot, files)?;
    if let Some(s) = tank {
        read_tank(s, &mut robot)?;
    }
    if let Some(mut s) = boom {
        in_space::refuse(&s, &robot)?;
        robot.boom = Some(Boom::default());
        terms(&mut s, "boom", &mut robot);
        s.optional_table("counterweight", |s| {
            table(s, "boom.counterweight", &mut robot)
        });
        s.finish(())?;
    }
    if let Some(s) = struts {
        in_space::refuse(&s, &robot)?;
        table(s, "struts", &mut robot)?;
    }
    in_space::check(&robot, &place)?;
    Ok(robot)
}

/// Reads the tables of the body and of the legs' directions.
fn body_and_legs(
    mut body: Section,
    legs: Option<Section>,
    robot: &mut Robot,
) -> Result<(), RobotError> {
    let shapes = [("wheel", false), ("sphere", true)];
    let is_sphere = body.has("shape") && body.choice("shape", &shapes, "wheel or sphere");
    body.stop_at_problem()?;
    if is_sphere {
        let legs = legs.unwrap_or_else(|| body.beside("legs"));
        return in_space::read(body, legs, robot);
    }
    robot.body.legs = body.count("legs");
    if let Some(mut legs) = legs {
        let allowed = "left out for a wheel, whose legs are evenly spaced: body.legs";
        legs.refuse_key("directions", allowed);
        legs.finish(())?;
    }
    table(body, "body", robot)
}

/// Reads the table `path` of `robot`, which has nothing but terms.
fn table(mut s: Section, path: &str, robot: &mut Robot) -> Result<(), RobotError> {
    terms(&mut s, path, robot);
    s.finish(())
}

/// What pushes the leg `s`, with its numbers still unknown.
fn drive(s: &mut Section) -> Result<Drive, RobotError> {
    let kinds = [
        ("pneumatic", 0),
        ("spring", 1),
        ("constant", 2),
        ("table", 3),
        ("muscle", 4),
    ];
    let allowed = "pneumatic, muscle, spring, constant or table";
    let kind = s.choice("kind", &kinds, allowed);
    // Without its kind, nobody knows the leg's keys.
    s.stop_at_problem()?;
    Ok(match kind {
        0 => Drive::Pneumatic(Cylinder::default()),
        1 => Drive::Spring {
            stiffness: 0.0,
            compression: 0.0,
        },
        2 => Drive::Constant { force: 0.0 },
        4 => Drive::Pneumatic(Cylinder {
            muscle: Some(Muscle::default()),
            ..Cylinder::default()
        }),
        _ => Drive::Table(ForceTable::default()),
    })
}

fn read_leg(mut s: Section, robot: &mut Robot, files: Files) -> Result<(), RobotError> {
    // The exponent of a chamber is at most that of its gas.
    if robot.leg.cylinder().is_some() {
        gas(&mut s, robot);
    }
    let length = Term::LegCenter.spec().quantity;
    let has_center = s.gives("center", length);
    terms(&mut s, "leg", robot);
    if robot.leg.body.mass > 0.0 && !has_center {
        s.number("center", length, Domain::FINITE);
    }
    for part in ["return_spring", "cushion"] {
        s.optional_table(part, |s| table(s, &format!("leg.{part}"), robot));
    }
    match &mut robot.leg.drive {
        Drive::Pneumatic(_) => {
            if robot.leg.cylinder().is_some_and(|c| c.muscle.is_some()) {
                let mut muscle = s.table("muscle");
                // A misspelt key is named before the one that it leaves missing.
                s.check_keys(&["tube"])?;
                s.stop_at_problem()?;
                free_contraction(&mut muscle, robot);
                table(muscle, "leg.muscle", robot)?;
            } else {
                s.optional_table("exhaust_port", |s| table(s, "leg.exhaust_port", robot));
            }
            s.optional_table("tube", |s| table(s, "leg.tube", robot));
        }
        Drive::Table(table) => *table = force_table(&mut s, robot.leg.stroke, files),
        _ => {}
    }
    s.finish(())
}

/// Reads the coefficients of a muscle's free contraction.
fn free_contraction(s: &mut Section, robot: &mut Robot) {
    let allowed = "a list of five finite numbers, of which the first, the free contraction without \
                   pressure, is > 0";
    let read = |value: &Value| {
        let numbers: [f64; 5] = numbers(value)?.try_into().ok()?;
        (numbers[0] > 0.0).then_some(numbers)
    };
    let found = s.value(FREE_CONTRACTION, allowed, read);
    if let Some(muscle) = robot.leg.cylinder_mut().and_then(|c| c.muscle.as_mut()) {
        muscle.free_contraction = found.unwrap_or_default();
    }
}

/// Reads the tank, which only legs that work by gas have.
fn read_tank(s: Section, robot: &mut Robot) -> Result<(), RobotError> {
    if robot.leg.cylinder().is_none() {
        return Err(RobotError::NotAllowed {
            place: s.place().clone(),
            key: "tank".into(),
            value: "a table".into(),
            allowed: "left out for a leg whose leg.kind is not \"pneumatic\" or \"muscle\": it uses no gas".into(),
        });
    }
    let place = s.place().clone();
    table(s, "tank", robot)?;
    let scaled = robot.space.as_ref().and_then(|space| {
        let mut legs = space.legs.iter();
        legs.find(|leg| leg.force.to_bits() != 1.0_f64.to_bits())
    });
    match scaled {
        None => Ok(()),
        Some(leg) => Err(RobotError::NotAllowed {
            place,
            key: "legs.force".into(),
            value: leg.force.to_string(),
            allowed: "1 for legs that one tank feeds: they have one supply pressure".into(),
        }),
    }
}

/// Reads a gas by name, or a table of its constants.
fn gas(s: &mut Section, robot: &mut Robot) {
    if s.is_table("gas") {
        s.optional_table("gas", |s| table(s, "leg.gas", robot));
        return;
    }
    let names = Gas::NAMED.map(|(name, _)| name).join(", ");
    let allowed =
        format!("{names}, or a table of heat_ratio with constant_j_per_kg_k or molar_mass_g_mol");
    let gas = s.choice("gas", &Gas::NAMED, &allowed);
    if let Some(cylinder) = robot.leg.cylinder_mut() {
        cylinder.gas = gas;
    }
}
