//! Reading and writing what a robot file has of a robot in space: the shape of its body, and where its legs point.

use std::fmt::{self, Formatter, Write};

use crate::document::{Node, Value};
use crate::domain::Domain;
use crate::reading::terms;
use crate::section::Section;
use crate::space::{Directions, Factors, MOST, dot, minus, norm, rests};
use crate::units::{INERTIA, LENGTH, NUMBER};
use crate::{Robot, RobotError, Space};

/// How far from 1 the length of a direction may be.
const NEAR: f64 = 1e-3;
/// Part of a moment of inertia that is round-off.
const ROUND_OFF: f64 = 1e-9;

/// Reads the tables of the body and of the legs' directions.
pub(crate) fn read(
    mut body: Section,
    mut legs: Section,
    robot: &mut Robot,
) -> Result<(), RobotError> {
    let mut space = Space {
        directions: directions(&mut legs, robot.foot.radius),
        ..Space::default()
    };
    let count = space.directions.vectors().len();
    space.legs = factors(&mut legs, count);
    legs.finish(())?;

    // Six numbers, or one for all axes.
    let inertia = body.numbers("inertia", INERTIA, Domain::FINITE, 6);
    space.inertia = match inertia[..] {
        [all] => [all, all, all, 0.0, 0.0, 0.0],
        [xx, yy, zz, xy, xz, yz] => [xx, yy, zz, xy, xz, yz],
        _ => [f64::NAN; 6],
    };
    space.center = body.array("center_of_mass", LENGTH).unwrap_or_default();
    robot.body.legs = u32::try_from(count).unwrap_or(u32::MAX);
    robot.body.inertia = space.inertia[..3].iter().sum::<f64>() / 3.0;
    let (moments, place) = (space.inertia, body.place().clone());
    robot.space = Some(space);
    terms(&mut body, "body", robot);
    body.finish(())?;
    if moments[..3].iter().all(|x| *x > 0.0) {
        return Ok(());
    }
    Err(RobotError::NotAllowed {
        place,
        key: "body.inertia".into(),
        value: format!("{moments:?} kg m²"),
        allowed: "moments of inertia (xx, yy, zz) above 0".into(),
    })
}

/// Refuses the table `s` for a robot in space.
pub(crate) fn refuse(s: &Section, robot: &Robot) -> Result<(), RobotError> {
    if robot.space.is_none() {
        return Ok(());
    }
    Err(RobotError::NotAllowed {
        place: s.place().clone(),
        key: s.path().into(),
        value: "a table".into(),
        allowed: "left out for a robot in space: body.shape = \"sphere\"".into(),
    })
}

/// Refuses a robot whose legs leave its body no inertia, and one that would not stand; `place` finds its keys.
pub(crate) fn check(robot: &Robot, place: &crate::Place) -> Result<(), RobotError> {
    let Some(space) = &robot.space else {
        return Ok(());
    };
    let refuse = |key: &str, value: String, allowed: &str| RobotError::NotAllowed {
        place: place.clone(),
        key: key.into(),
        value,
        allowed: allowed.into(),
    };
    let core = robot.core(space, 0.0);
    // The legs' masses are the same, so their centre is the mean.
    let directions = space.directions.vectors();
    let share = |k: usize| {
        let legs: f64 = directions.iter().map(|leg| leg[k]).sum();
        let moment =
            core.mass * space.center[k] + robot.leg.body.mass * robot.leg.body.center * legs;
        moment / robot.body.mass
    };
    let center: [f64; 3] = std::array::from_fn(share);
    let rests = rests(&directions);
    let is_inside =
        |rest: &crate::space::Rest| dot(&center, &rest.down) < rest.height * robot.body.radius;
    if rests.len() < 4 || !rests.iter().all(is_inside) {
        let allowed = "within the feet, so that the robot stands on some of them";
        return Err(refuse(
            "body.center_of_mass",
            format!("{:?} m, with the legs {center:?} m", space.center),
            allowed,
        ));
    }
    if !is_of_a_body(&core.inertia) {
        let allowed = "that of a body: about its centre of mass (body.center_of_mass) and without the legs, each moment has to be \
                       above 0, and at most the sum of the two others about the principal axes";
        return Err(refuse(
            "body.inertia",
            format!("{:?}", space.inertia),
            allowed,
        ));
    }
    Ok(())
}

/// Whether a body can have these moments of inertia: those of its mass along each axis, half the trace less the
/// moment, are none below 0.
fn is_of_a_body(inertia: &[[f64; 3]; 3]) -> bool {
    let trace = inertia[0][0] + inertia[1][1] + inertia[2][2];
    let slack = ROUND_OFF * trace;
    let along = |i: usize, j: usize| {
        let half = if i == j { 0.5 * trace + slack } else { 0.0 };
        half - inertia[i][j]
    };
    // Sylvester's criterion.
    let second = along(0, 0) * along(1, 1) - along(0, 1) * along(1, 0);
    let minor = |i: usize, j: usize, k: usize, l: usize| {
        along(1, i) * along(2, j) - along(1, k) * along(2, l)
    };
    let third = along(0, 0) * minor(1, 2, 2, 1) - along(0, 1) * minor(0, 2, 2, 0)
        + along(0, 2) * minor(0, 1, 1, 0);
    trace > 0.0 && along(0, 0) >= 0.0 && second >= 0.0 && third >= 0.0
}

/// Where the legs point.
fn directions(legs: &mut Section, foot: f64) -> Directions {
    const NAMES: &str = "cube, octahedron, dodecahedron, icosahedron, or a list of unit vectors";
    if !legs.has("directions") {
        legs.missing(&["directions"], NAMES);
        return Directions::default();
    }
    if let Some(place) = legs.word("directions", &Directions::NAMED) {
        return Directions::named(place);
    }
    let read = |value: &Value| match value {
        Value::Array(items) => listed(items, foot),
        _ => Err(NAMES.into()),
    };
    let listed = legs.read_as("directions", read);
    listed.map_or(Directions::default(), Directions::List)
}

/// The unit vectors of a list.
fn listed(items: &[Node], foot: f64) -> Result<Vec<[f64; 3]>, String> {
    let count = items.len();
    if !(4..=MOST).contains(&count) {
        return Err(format!(
            "from 4 to {MOST} unit vectors; this list has {count}"
        ));
    }
    let mut all: Vec<[f64; 3]> = Vec::new();
    for (i, item) in items.iter().enumerate() {
        let name = i + 1;
        let vector = vector(&item.value)
            .ok_or_else(|| format!("a list of unit vectors [x, y, z]; item {name} is none"))?;
        let length = norm(&vector);
        if (length - 1.0).abs() > NEAR {
            return Err(format!(
                "a list of unit vectors; the length of item {name} is {length}"
            ));
        }
        // What is 1 but for round-off stays as it is, to the bit.
        let exact = (length - 1.0).abs() <= 4.0 * f64::EPSILON;
        let unit = if exact {
            vector
        } else {
            vector.map(|x| x / length)
        };
        let near = |other: &[f64; 3]| norm(&minus(other, &unit)) <= NEAR + 2.0 * foot;
        if let Some(other) = all.iter().position(near) {
            return Err(format!(
                "legs that do not touch; items {} and {name} do",
                other + 1
            ));
        }
        all.push(unit);
    }
    let found = rests(&all).len();
    if found < 4 {
        return Err("legs on which the robot can stand, all around it".into());
    }
    Ok(all)
}

/// A list of three finite numbers.
fn vector(value: &Value) -> Option<[f64; 3]> {
    let Value::Array(items) = value else {
        return None;
    };
    let number = |node: &Node| match &node.value {
        Value::Number(literal) => NUMBER.units[0].1.si(literal),
        _ => f64::NAN,
    };
    let numbers: Vec<f64> = items.iter().map(number).collect();
    let vector: [f64; 3] = numbers.try_into().ok()?;
    vector.iter().all(|x| x.is_finite()).then_some(vector)
}

/// How the legs differ; none where nothing is said.
fn factors(legs: &mut Section, count: usize) -> Vec<Factors> {
    let mut all = vec![Factors::default(); count];
    let mut differ = false;
    let mut read = |stem: &str, domain: Domain, set: fn(&mut Factors, f64)| {
        if !legs.has(stem) {
            return;
        }
        differ = true;
        let numbers = legs.numbers(stem, NUMBER, domain, count);
        for (k, leg) in all.iter_mut().enumerate() {
            let x = numbers.get(k).or(numbers.first());
            set(leg, x.copied().unwrap_or(f64::NAN));
        }
    };
    let most = 100.0;
    read("force_factors", Domain::POSITIVE.up_to(most), |leg, x| {
        leg.force = x;
    });
    read(
        "delay_factors",
        Domain::NON_NEGATIVE.up_to(most),
        |leg, x| leg.delay = x,
    );
    read(
        "friction_factors",
        Domain::NON_NEGATIVE.up_to(most),
        |leg, x| {
            leg.friction = x;
        },
    );
    if differ { all } else { Vec::new() }
}

/// The first lines of the table of the body.
pub(crate) fn body_lines(space: &Space) -> String {
    let mut text = String::from("shape = \"sphere\"\n");
    // Writing to a string does not fail.
    let _ = writeln!(text, "inertia_kg_m2 = {:?}", space.inertia);
    if space.center != [0.0; 3] {
        let _ = writeln!(text, "center_of_mass_m = {:?}", space.center);
    }
    text
}

/// Writes the table of the legs' directions.
pub(crate) fn write_legs(f: &mut Formatter<'_>, space: &Space) -> fmt::Result {
    writeln!(f, "\n[legs]")?;
    if let Some(name) = space.directions.name() {
        writeln!(f, "directions = \"{name}\"")?;
    } else {
        writeln!(f, "directions = [")?;
        for vector in space.directions.vectors() {
            writeln!(f, "    {vector:?},")?;
        }
        writeln!(f, "]")?;
    }
    if space.legs.is_empty() {
        return Ok(());
    }
    let list = |of: fn(&Factors) -> f64| space.legs.iter().map(of).collect::<Vec<f64>>();
    writeln!(f, "force_factors = {:?}", list(|leg| leg.force))?;
    writeln!(f, "delay_factors = {:?}", list(|leg| leg.delay))?;
    writeln!(f, "friction_factors = {:?}", list(|leg| leg.friction))
}
