//! A robot as a robot file.

use std::fmt::{self, Formatter};

use crate::in_space;
use crate::terms::{FREE_CONTRACTION, SECTIONS};
use crate::{Drive, ForceTable, Robot, Term};

impl Robot {
    /// The robot file, in SI units, that [`Robot::parse`] reads as this very robot, to the last
    /// bit.
    ///
    /// Effects that are off are left out, and a force table is written into the file, so that it
    /// stands alone. A value outside its domain is written as it is, for the reader to refuse.
    ///
    /// # Example
    /// ```
    /// # use std::path::Path;
    /// use saltus_robot::Robot;
    /// let mut robot = Robot::rats_planar();
    /// robot.body.mass = 3.0;
    /// assert_eq!(Robot::parse(&robot.to_toml(), "heavy.toml", Path::new("."))?, robot);
    /// # Ok::<(), saltus_robot::RobotError>(())
    /// ```
    pub fn to_toml(&self) -> String {
        RobotFile(self).to_string()
    }
}

/// A robot whose display is its file.
struct RobotFile<'a>(&'a Robot);

impl fmt::Display for RobotFile<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        writeln!(f, "name = {}", quoted(&self.0.name))?;
        SECTIONS
            .iter()
            .try_for_each(|section| write_section(f, section, self.0))
    }
}

/// Writes the table `name`, unless nothing of it is there or on.
fn write_section(f: &mut Formatter<'_>, name: &str, robot: &Robot) -> fmt::Result {
    let first = match name {
        "body" => robot.space.as_ref().map_or_else(
            || format!("legs = {}\n", robot.body.legs),
            in_space::body_lines,
        ),
        "leg" => format!("kind = {}\n", quoted(kind(&robot.leg.drive))),
        "leg.muscle" => muscle_line(robot),
        _ => String::new(),
    };
    let terms = Term::ALL
        .iter()
        .filter(|term| term.spec().section() == name);
    let lines: String = terms.filter_map(|term| line(*term, robot)).collect();
    // Sensors that are all as by default are there nevertheless.
    let stands = name == "sensors" && robot.sensors.is_some();
    if stands || !first.is_empty() || !lines.is_empty() {
        write!(f, "\n[{name}]\n{first}{lines}")?;
    }
    if let ("body", Some(space)) = (name, &robot.space) {
        return in_space::write_legs(f, space);
    }
    match &robot.leg.drive {
        Drive::Table(table) if name == "leg" => write_table(f, table),
        _ => Ok(()),
    }
}

/// The line of `term`; none where it is off.
fn line(term: Term, robot: &Robot) -> Option<String> {
    let value = term.of(robot)?;
    if term.off(robot) == Some(value) {
        return None;
    }
    let unit = term.spec().quantity.units[0].0;
    Some(format!("{}{unit} = {value:?}\n", term.stem(robot)))
}

/// The coefficients of a muscle's free contraction.
fn muscle_line(robot: &Robot) -> String {
    let muscle = robot.leg.cylinder().and_then(|cylinder| cylinder.muscle);
    muscle.map_or_else(String::new, |muscle| {
        format!("{FREE_CONTRACTION} = {:?}\n", muscle.free_contraction)
    })
}

/// The kind of a leg in a file.
fn kind(drive: &Drive) -> &'static str {
    match drive {
        Drive::Pneumatic(cylinder) if cylinder.muscle.is_some() => "muscle",
        Drive::Pneumatic(_) => "pneumatic",
        Drive::Spring { .. } => "spring",
        Drive::Constant { .. } => "constant",
        Drive::Table(_) => "table",
    }
}

fn write_table(f: &mut Formatter<'_>, table: &ForceTable) -> fmt::Result {
    writeln!(f, "\n[leg.table]")?;
    writeln!(f, "extensions_m = {:?}", table.extensions)?;
    writeln!(f, "speeds_m_s = {:?}", table.speeds)?;
    writeln!(f, "forces_n = [")?;
    // No speeds make no table; the reader says so.
    for row in table.forces.chunks(table.speeds.len().max(1)) {
        writeln!(f, "    {row:?},")?;
    }
    writeln!(f, "]")
}

/// `text` as a TOML string.
fn quoted(text: &str) -> toml::Value {
    toml::Value::String(text.into())
}
