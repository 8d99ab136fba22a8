//! Courses of the rolling robot from TOML files.

use std::path::Path;

use saltus::planner::course::{Course, MAX_JUMPS, Obstacle, Span};
use saltus::planner::{Crossing, FIRING_ANGLES};

use crate::error::CliError;
use crate::input;
use crate::quantity::Quantity;
use crate::section::Section;

/// Greatest size of a file (MiB).
const LIMIT_MIB: u64 = 4;
/// Most obstacles, and most zones of a kind.
const MOST: usize = 64;
/// Places (m) that the planner takes.
pub(super) const ANYWHERE: Span = Span::new(-1e4, 1e4);

/// The course in the file at `path`.
pub(in crate::cli) fn load(path: &Path) -> Result<Crossing, CliError> {
    parse(&input::text(path, LIMIT_MIB)?, &path.display().to_string())
}

/// The course that `text` describes; messages call it `file`.
pub(super) fn parse(text: &str, file: &str) -> Result<Crossing, CliError> {
    let mut root = Section::file(text, file)?;
    let jumps = root.count("jumps", MAX_JUMPS)?.unwrap_or(1);
    let start = root.number("start_x_m", &Quantity::PLACE)?.unwrap_or(0.0);
    let start_height = root.number("start_height_m", &Quantity::SIZE)?.unwrap_or(0.0);
    let rates = root.numbers("approach_rate_rad_s", &Quantity::RATE)?;
    let (goal, target) = goal(&mut root)?;
    let firing_angles = root.span("firing_angle_rad", &Quantity::ANGLE)?.unwrap_or(FIRING_ANGLES);
    let valve_open = root.span("valve_open_s", &Quantity::OPEN)?.unwrap_or((0.02, 0.1));
    let mut size = |key| Ok::<f64, CliError>(root.number(key, &Quantity::SIZE)?.unwrap_or(0.0));
    let [roll, clearance, edge_margin] = [size("roll_m")?, size("clearance_m")?, size("edge_margin_m")?];
    let mut factor =
        |key, default| Ok::<f64, CliError>(root.number(key, &Quantity::FACTOR)?.unwrap_or(default));
    let (sigmas, deviation_weight, effort_weight) =
        (factor("margin_sigmas", 0.0)?, factor("deviation_weight", 100.0)?, factor("effort_weight", 1.0)?);
    let crossing = Crossing {
        rates,
        start_lean: root.number("start_lean_rad", &Quantity::ANGLE)?,
        firing_angles: Span::new(firing_angles.0, firing_angles.1),
        valve_open: Span::new(valve_open.0, valve_open.1),
        zones: zones(&mut root, jumps)?,
        target,
        roll,
        clearance,
        edge_margin,
        leg_out: root.number("leg_out_s", &Quantity::TIME)?.unwrap_or(0.0),
        friction: root.number("friction_coefficient", &Quantity::FACTOR)?,
        sigmas,
        deviation_weight,
        effort_weight,
        course: Course {
            id: file.into(),
            start,
            start_height,
            jumps,
            goal,
            obstacles: obstacles(&mut root)?,
            no_landing: avoid(&mut root)?,
        },
    };
    root.finish()?;
    Ok(crossing)
}

/// Where the last jump may land, and where it should.
fn goal(root: &mut Section) -> Result<(Span, f64), CliError> {
    let from = root.number("goal_from_x_m", &Quantity::PLACE)?;
    let to = root.number("goal_to_x_m", &Quantity::PLACE)?;
    let target = root.number("target_x_m", &Quantity::PLACE)?;
    let goal = Span::new(from.unwrap_or(ANYWHERE.low), to.unwrap_or(ANYWHERE.high));
    if goal.is_empty() {
        return Err(root.wrong("goal_to_x_m must not be before goal_from_x_m"));
    }
    match (target, from, to) {
        (Some(target), ..) => Ok((goal, target)),
        (None, Some(from), Some(to)) => Ok((goal, f64::midpoint(from, to))),
        _ => Err(root.wrong("missing key target_x_m, or both goal_from_x_m and goal_to_x_m")),
    }
}

fn obstacles(root: &mut Section) -> Result<Vec<Obstacle>, CliError> {
    let sections = limited(root, "obstacle")?;
    let mut obstacles: Vec<Obstacle> = Vec::with_capacity(sections.len());
    for mut section in sections {
        let front = section.required("front_x_m", &Quantity::PLACE)?;
        let width = section.required("width_m", &Quantity::EXTENT)?;
        let height = section.required("height_m", &Quantity::EXTENT)?;
        let obstacle = Obstacle { center: front + width / 2.0, width, height };
        let meets = |other: &Obstacle| {
            let both = other.span().meet(obstacle.span());
            // Boxes that touch are two steps of a stair.
            both.width() > 1e-9
        };
        if let Some(other) = obstacles.iter().position(meets) {
            return Err(section.wrong(&format!(
                "obstacles must not overlap: this is in the place of number {}",
                other + 1
            )));
        }
        obstacles.push(obstacle);
        section.finish()?;
    }
    Ok(obstacles)
}

/// Where no jump may land.
fn avoid(root: &mut Section) -> Result<Vec<Span>, CliError> {
    let span = |mut section: Section| {
        let span = zone(&mut section)?;
        section.finish()?;
        Ok(span)
    };
    limited(root, "avoid")?.into_iter().map(span).collect()
}

/// Where each jump has to land.
fn zones(root: &mut Section, jumps: usize) -> Result<Vec<Option<Span>>, CliError> {
    let mut zones = vec![None; jumps];
    for (i, mut section) in limited(root, "land")?.into_iter().enumerate() {
        let jump = section.count("jump", jumps)?.unwrap_or(i + 1);
        let span = zone(&mut section)?;
        match zones.get_mut(jump - 1) {
            Some(place @ None) => *place = Some(span),
            Some(Some(_)) => return Err(section.wrong(&format!("jump {jump} has a zone already"))),
            None => return Err(section.wrong(&format!("there is no jump {jump}: jumps = {jumps}"))),
        }
        section.finish()?;
    }
    Ok(zones)
}

fn zone(section: &mut Section) -> Result<Span, CliError> {
    let from = section.required("from_x_m", &Quantity::PLACE)?;
    let to = section.required("to_x_m", &Quantity::PLACE)?;
    if from < to { Ok(Span::new(from, to)) } else { Err(section.wrong("to_x_m must be beyond from_x_m")) }
}

fn limited<'a>(root: &mut Section<'a>, key: &'static str) -> Result<Vec<Section<'a>>, CliError> {
    let sections = root.tables(key)?;
    match sections.len() {
        0..=MOST => Ok(sections),
        count => Err(root.wrong(&format!("{count} tables [[{key}]]: at most {MOST} are allowed"))),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const GOOD: &str = "\
jumps = 2
approach_rate_rad_s = [5, 4.5]
goal_from_x_m = 1.0
goal_to_x_m = 1.4
valve_open_s = [0.02, 0.1]
[[obstacle]]
front_x_m = 0.4
width_m = 0.05
height_m = 0.1
[[land]]
from_x_m = 0.5
to_x_m = 0.8
[[avoid]]
from_x_m = 0.9
to_x_m = 1
";

    #[test]
    fn a_course_is_read() {
        let crossing = parse(GOOD, "a.toml").unwrap();
        assert_eq!((crossing.course.jumps, crossing.target), (2, 1.2));
        assert_eq!(crossing.rates, [5.0, 4.5]);
        assert_eq!(crossing.zones, [Some(Span::new(0.5, 0.8)), None]);
        assert_eq!(crossing.course.no_landing, [Span::new(0.9, 1.0)]);
        assert!((crossing.course.obstacles[0].center - 0.425).abs() < 1e-15);
    }

    #[test]
    fn wrong_courses_are_refused_with_their_place() {
        let check = |from: &str, to: &str, message: &str| {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD, "{from}");
            let error = parse(&text, "a.toml").unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        check("jumps = 2", "jumps = 2.5", "a.toml:1: jumps = 2.5: must be a whole number from 1 to");
        check("jumps = 2", "jumps = 0", "a.toml:1: jumps = 0: must be a whole number");
        check("jumps", "jump", "a.toml:1: unknown key jump: known are jumps, start_x_m,");
        check(
            "[5, 4.5]",
            "[5, nan]",
            "a.toml:2: approach_rate_rad_s[1] = nan: must be a number from 0 to 1000 rad/s",
        );
        check("[5, 4.5]", "[]", "a.toml:2: approach_rate_rad_s = []: must be at least one number");
        check("approach_rate_rad_s = [5, 4.5]\n", "", "a.toml:1: missing key approach_rate_rad_s");
        check(
            "[0.02, 0.1]",
            "[0.1, 0.02]",
            "valve_open_s = [0.1, 0.02]: must be a list of two numbers, the lower first",
        );
        check("[0.02, 0.1]", "\"long\"", "valve_open_s = \"long\": must be a list of two numbers");
        check("goal_to_x_m = 1.4", "goal_to_x_m = 0.4", "goal_to_x_m must not be before goal_from_x_m");
        check("goal_to_x_m = 1.4\n", "", "missing key target_x_m, or both");
        check(
            "width_m = 0.05",
            "width_m = -1",
            "a.toml:8: obstacle[0].width_m = -1: must be a length above 0",
        );
        check("width_m = 0.05\n", "", "a.toml:6: missing key obstacle[0].width_m");
        check(
            "height_m = 0.1",
            "height_m = 0.1\ncolour = 1",
            "a.toml:10: unknown key obstacle[0].colour: known are front_x_m",
        );
        check("[[land]]", "[[land]]\njump = 3", "land[0].jump = 3: must be a whole number from 1 to 2");
        check("to_x_m = 0.8", "to_x_m = 0.2", "a.toml:10: to_x_m must be beyond from_x_m");
        check("[[obstacle]]", "[obstacle]", "obstacle = ");
        check(
            "[[avoid]]",
            "[[obstacle]]\nfront_x_m = 0.42\nwidth_m = 1\nheight_m = 1\n[[avoid]]",
            "must not overlap: this is in the place of number 1",
        );
        check("jumps = 2", "jumps = = 2", "a.toml:1: not TOML");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in ".{0,300}") {
            let _ = parse(&text, "a.toml");
        }

        #[test]
        fn damaged_files_are_read_or_refused(at in 0..GOOD.len(), byte in any::<u8>()) {
            let mut bytes = GOOD.as_bytes().to_vec();
            bytes[at] = byte;
            let _ = parse(&String::from_utf8_lossy(&bytes), "a.toml");
        }
    }
}
