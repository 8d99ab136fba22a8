//! Courses of the rolling robot from TOML files, in any of the units that robot files may use.

use std::f64::consts::FRAC_PI_2;
use std::path::Path;

use saltus_planner::Crossing;
use saltus_planner::course::{Course, MAX_JUMPS, Obstacle, Span};
use saltus_robot::domain::Domain;
use saltus_robot::section::{Number, Section};
use saltus_robot::units::{ANGLE, ANGULAR_RATE, LENGTH, NUMBER, TIME};

use crate::input::{self, InputError};
use crate::usual;

/// Greatest size of a file (MiB).
pub const LIMIT_MIB: u64 = 4;
/// Most obstacles, and most no-landing areas.
const MOST: usize = 64;
/// Places (m) that the planner takes.
pub const ANYWHERE: Span = Span::new(-1e4, 1e4);

const PLACE: Domain = Domain::at_least(ANYWHERE.low).up_to(ANYWHERE.high);
const SIZE: Domain = Domain::NON_NEGATIVE.up_to(1e3);
const EXTENT: Domain = Domain::POSITIVE.up_to(1e3);
const LEAN: Domain = Domain::above(-FRAC_PI_2).below(FRAC_PI_2);
/// Opening times (s) of a valve.
const OPENING: Domain = Domain::POSITIVE.up_to(10.0);
const FACTOR: Domain = Domain::NON_NEGATIVE.up_to(1e4);

/// The course in the file at `path`; `-` is standard input.
///
/// # Errors
/// [`InputError`] where the file cannot be read or is no course; it names the line, the key, the
/// value and what is allowed.
pub fn load(path: impl AsRef<Path>) -> Result<Crossing, InputError> {
    let path = path.as_ref();
    parse(&input::text(path, LIMIT_MIB)?, &path.display().to_string())
}

/// The course that `text` describes; messages call it `file`.
///
/// # Errors
/// [`InputError`] where it is no course.
pub fn parse(text: &str, file: &str) -> Result<Crossing, InputError> {
    read(text, file).map(|(crossing, _)| crossing)
}

/// The course that `text` describes, and a warning for each number out of its [usual] range; messages
/// call it `file`.
///
/// # Errors
/// [`InputError`] if it is no course.
pub fn read(text: &str, file: &str) -> Result<(Crossing, Vec<String>), InputError> {
    let mut root = Section::file(text, file)?;
    refuse_unsupported(&mut root);
    let jumps = root.count_to("jumps", MAX_JUMPS).unwrap_or(1);
    let start = root.optional("start_x", LENGTH, PLACE).unwrap_or(0.0);
    let start_height = root.optional("start_height", LENGTH, SIZE).unwrap_or(0.0);
    let (from, to) = (
        root.optional("goal_from_x", LENGTH, PLACE),
        root.optional("goal_to_x", LENGTH, PLACE),
    );
    let goal = Span::new(from.unwrap_or(ANYWHERE.low), to.unwrap_or(ANYWHERE.high));
    let target = root.optional("target_x", LENGTH, PLACE);
    let course = Course {
        id: file.into(),
        start,
        start_height,
        jumps,
        goal,
        obstacles: vec![],
        no_landing: vec![],
    };
    let mut crossing = Crossing::new(course, 0.0);
    numbers(&mut root, &mut crossing);
    let mut warnings = unusual(&root);
    let place = root.place().clone();
    let [obstacle, land, avoid] = [("obstacle", MOST), ("land", jumps), ("avoid", MOST)]
        .map(|(key, most)| root.tables(key, most));
    root.finish(())?;

    if goal.is_empty() {
        return Err(InputError::content(
            place,
            "goal_to_x_m must not be before goal_from_x_m",
        ));
    }
    crossing.target = match (target, from, to) {
        (Some(target), ..) => target,
        (None, Some(from), Some(to)) => f64::midpoint(from, to),
        _ => {
            let reason = "missing key target_x_m, or both goal_from_x_m and goal_to_x_m";
            return Err(InputError::content(place, reason));
        }
    };
    crossing.course.obstacles = obstacles(obstacle, &mut warnings)?;
    crossing.zones = zones(land, jumps, &mut warnings)?;
    let avoid = avoid.into_iter().map(|area| zone(area, &mut warnings));
    crossing.course.no_landing = avoid.collect::<Result<_, _>>()?;
    Ok((crossing, warnings))
}

/// Where the last jump has to land (m), if the course does not say so by a goal and its cost counts the
/// distance from the target.
pub fn demanded_target(crossing: &Crossing) -> Option<f64> {
    let goal = crossing.course.goal;
    let is_open = goal.low <= ANYWHERE.low && goal.high >= ANYWHERE.high;
    (is_open && crossing.deviation_weight > 0.0).then_some(crossing.target)
}

/// Beginnings of keys for what a course cannot have, and what to do.
const UNSUPPORTED: [(&[&str], &str); 3] = [
    (
        &["ceiling", "roof", "overhang"],
        "left out: a course has no ceilings. The top of the wheel is at apex_m of `saltus plan` plus the \
         wheel's radius; later firing angles, a higher lower end of firing_angle_rad, make lower jumps",
    ),
    (
        &["slope", "ramp", "incline"],
        "left out: the ground of a course is level, and [[obstacle]] boxes that touch make a stair. On a tilted \
         floor, `saltus verify --plant-set ground.tilt_deg=2` flies what was planned for a level one",
    ),
    (
        &["gap", "ditch", "pit"],
        "left out: ground on which no jump may land is [[avoid]] with from_x_m and to_x_m",
    ),
];

fn refuse_unsupported(root: &mut Section) {
    for key in root.keys() {
        let is_of = |(words, _): &&(&[&str], _)| words.iter().any(|word| key.starts_with(word));
        if let Some((_, advice)) = UNSUPPORTED.iter().find(is_of) {
            root.refuse_key(&key, advice);
        }
    }
}

/// A warning for each number that was read and is out of its usual range.
fn unusual(section: &Section) -> Vec<String> {
    let numbers = section.numbers_read().iter();
    let warning = |it: &Number| {
        let written = format!("{}: {} = {}", it.place, it.name, it.source);
        usual::of_key(&it.stem)?.warning(&written, &it.source, it.value)
    };
    numbers.filter_map(warning).collect()
}

/// Reads how the course is to be crossed into `crossing`, whose numbers stand for keys that are not
/// given.
fn numbers(root: &mut Section, crossing: &mut Crossing) {
    let span = |(low, high): (f64, f64)| Span::new(low, high);
    let rate = Domain::NON_NEGATIVE.up_to(1e3);
    crossing.rates = root.numbers("approach_rate", ANGULAR_RATE, rate, crossing.course.jumps);
    crossing.start_lean = root.optional("start_lean", ANGLE, LEAN);
    crossing.firing_angles = root
        .span("firing_angle", ANGLE, LEAN)
        .map_or(crossing.firing_angles, span);
    crossing.valve_open = root
        .span("valve_open", TIME, OPENING)
        .map_or(crossing.valve_open, span);
    crossing.friction = root.optional("friction_coefficient", NUMBER, FACTOR);
    let numbers = [
        ("roll", LENGTH, SIZE, &mut crossing.roll),
        ("clearance", LENGTH, SIZE, &mut crossing.clearance),
        ("edge_margin", LENGTH, SIZE, &mut crossing.edge_margin),
        ("leg_out", TIME, SIZE, &mut crossing.leg_out),
        ("margin_sigmas", NUMBER, FACTOR, &mut crossing.sigmas),
        (
            "deviation_weight",
            NUMBER,
            FACTOR,
            &mut crossing.deviation_weight,
        ),
        ("effort_weight", NUMBER, FACTOR, &mut crossing.effort_weight),
    ];
    for (stem, quantity, domain, number) in numbers {
        *number = root.optional(stem, quantity, domain).unwrap_or(*number);
    }
}

fn obstacles(
    sections: Vec<Section>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Obstacle>, InputError> {
    let mut obstacles: Vec<Obstacle> = Vec::with_capacity(sections.len());
    for mut section in sections {
        let front = section.number("front_x", LENGTH, PLACE);
        let width = section.number("width", LENGTH, EXTENT);
        let height = section.number("height", LENGTH, EXTENT);
        warnings.extend(unusual(&section));
        let place = section.place().clone();
        section.finish(())?;
        let obstacle = Obstacle {
            center: front + width / 2.0,
            width,
            height,
        };
        let meets = |other: &Obstacle| {
            let both = other.span().meet(obstacle.span());
            // Boxes that touch are two steps of a stair.
            both.width() > 1e-9
        };
        if let Some(other) = obstacles.iter().position(meets) {
            let (this, other) = (obstacles.len() + 1, other + 1);
            let reason = format!(
                "obstacles must not overlap: obstacle {this} is in the place of obstacle {other}"
            );
            return Err(InputError::content(place, reason));
        }
        obstacles.push(obstacle);
    }
    Ok(obstacles)
}

/// Where each jump has to land.
fn zones(
    sections: Vec<Section>,
    jumps: usize,
    warnings: &mut Vec<String>,
) -> Result<Vec<Option<Span>>, InputError> {
    let mut zones = vec![None; jumps];
    for (i, mut section) in sections.into_iter().enumerate() {
        let jump = section.count_to("jump", jumps).unwrap_or(i + 1);
        let place = section.place().clone();
        let span = zone(section, warnings)?;
        if zones[jump - 1].replace(span).is_some() {
            return Err(InputError::content(
                place,
                format!("land {}: jump {jump} has a zone already", i + 1),
            ));
        }
    }
    Ok(zones)
}

fn zone(mut section: Section, warnings: &mut Vec<String>) -> Result<Span, InputError> {
    let (from, to) = (
        section.number("from_x", LENGTH, PLACE),
        section.number("to_x", LENGTH, PLACE),
    );
    warnings.extend(unusual(&section));
    let place = section.place().clone();
    section.finish(())?;
    if from < to {
        Ok(Span::new(from, to))
    } else {
        Err(InputError::content(place, "to_x_m must be beyond from_x_m"))
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
    #[expect(clippy::too_many_lines, reason = "a list of cases")]
    fn wrong_courses_are_refused_with_their_place() {
        let check = |from: &str, to: &str, message: &str| {
            let text = GOOD.replacen(from, to, 1);
            assert_ne!(text, GOOD, "{from}");
            let error = parse(&text, "a.toml").unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        check(
            "jumps = 2",
            "jumps = 2.5",
            "a.toml:1: jumps = 2.5: must be a whole number from 1 to 12",
        );
        check(
            "jumps = 2",
            "jumps = 0",
            "a.toml:1: jumps = 0: must be a whole number",
        );
        check(
            "jumps",
            "jump",
            "a.toml:1: unknown key jump; the nearest known key is jumps",
        );
        check(
            "[5, 4.5]",
            "[5, nan]",
            "a.toml:2: approach_rate_rad_s item 2 = nan: must be a finite number ≥ 0 and ≤ 1000 \
             rad/s",
        );
        check(
            "[5, 4.5]",
            "[]",
            "a.toml:2: approach_rate_rad_s = []: must be one number, or a list of 2; this list \
             has 0",
        );
        check(
            "[5, 4.5]",
            "[3, 6, 4, 5]",
            "must be one number, or a list of 2; this list has 4",
        );
        check(
            "jumps = 2",
            "jumps = 3",
            "must be one number, or a list of 3; this list has 2",
        );
        check(
            "approach_rate_rad_s = [5, 4.5]\n",
            "",
            "a.toml: missing key approach_rate_rad_s or",
        );
        check(
            "[0.02, 0.1]",
            "[0.1, 0.02]",
            "valve_open_s = [0.1, 0.02]: must be a list of two numbers, the lower first",
        );
        check(
            "[0.02, 0.1]",
            "[20, 100]",
            "valve_open_s item 1 = 20: must be a finite number > 0 and ≤ 10 s",
        );
        check(
            "[0.02, 0.1]",
            "[0.1]",
            "must be a list of two numbers, the lower first; this list has 1",
        );
        check(
            "[0.02, 0.1]",
            "\"long\"",
            "valve_open_s = \"long\": must be a list of two numbers",
        );
        check(
            "goal_to_x_m = 1.4",
            "goal_to_x_m = 0.4",
            "goal_to_x_m must not be before goal_from_x_m",
        );
        check("goal_to_x_m = 1.4\n", "", "missing key target_x_m, or both");
        check(
            "width_m = 0.05",
            "width_m = -1",
            "a.toml:8: obstacle 1.width_m = -1: must be a finite number > 0 and ≤ 1000 m",
        );
        check(
            "width_m = 0.05\n",
            "",
            "a.toml:6: missing key obstacle 1.width_m or width_mm",
        );
        check(
            "height_m = 0.1",
            "hight_m = 0.1",
            "a.toml:9: unknown key obstacle 1.hight_m; the nearest known key is obstacle \
             1.height_m",
        );
        check(
            "[[land]]",
            "[[land]]\njump = 3",
            "land 1.jump = 3: must be a whole number from 1 to 2",
        );
        check(
            "[[land]]",
            "[[land]]\nfrom_x_m = 0\nto_x_m = 1\n[[land]]\nfrom_x_m = 0\nto_x_m = 1\n[[land]]",
            "[[land]] = 3 tables: must be at most 2 tables",
        );
        check(
            "to_x_m = 0.8",
            "to_x_m = 0.2",
            "a.toml:10: to_x_m must be beyond from_x_m",
        );
        check(
            "front_x_m = 0.4",
            "x_m = 0.4",
            "a.toml:7: unknown key obstacle 1.x_m; the keys allowed there are front_x_m, width_m, \
             height_m",
        );
        check(
            "[[avoid]]",
            "[[ceiling]]\nheight_m = 1\n[[avoid]]",
            "ceiling = [[ceiling]]: must be left out: a course has no ceilings",
        );
        check(
            "jumps = 2",
            "jumps = 2\nslope_deg = 5",
            "a.toml:2: slope_deg = 5: must be left out: the ground of a course is level",
        );
        check("[[obstacle]]", "[obstacle]", "obstacle = ");
        check(
            "[[avoid]]",
            "[[obstacle]]\nfront_x_m = 0.42\nwidth_m = 1\nheight_m = 1\n[[avoid]]",
            "must not overlap: obstacle 2 is in the place of obstacle 1",
        );
        check("jumps = 2", "jumps = = 2", "a.toml:1: not TOML");
    }

    #[test]
    fn a_course_takes_the_units_of_robot_files() {
        let text = GOOD
            .replace("width_m = 0.05", "width_mm = 50")
            .replace("height_m = 0.1", "height_cm = 10")
            .replace(
                "approach_rate_rad_s = [5, 4.5]",
                "approach_rate_deg_s = [286.47889756541161, 257.83100780887045]",
            )
            .replace("valve_open_s = [0.02, 0.1]", "valve_open_ms = [20, 100]");
        let (crossing, plain) = (
            parse(&text, "a.toml").unwrap(),
            parse(GOOD, "a.toml").unwrap(),
        );
        assert!(
            crossing
                .rates
                .iter()
                .zip(&plain.rates)
                .all(|(a, b)| (a - b).abs() < 1e-12)
        );
        assert_eq!(
            Crossing {
                rates: plain.rates.clone(),
                ..crossing
            },
            plain
        );
        let twice = GOOD.replace("width_m = 0.05", "width_m = 0.05\nwidth_mm = 50");
        let error = parse(&twice, "a.toml").unwrap_err().to_string();
        assert!(
            error.contains("obstacle 1.width_mm is already given as obstacle 1.width_m"),
            "{error}"
        );
    }

    #[test]
    fn numbers_out_of_their_usual_range_are_warned_of_where_they_stand() {
        let check = |from: &str, to: &str, warning: &str| {
            let (_, warnings) = read(&GOOD.replacen(from, to, 1), "a.toml").unwrap();
            assert_eq!(warnings, [warning]);
        };
        assert_eq!(read(GOOD, "a.toml").unwrap().1, [""; 0]);
        check(
            "[5, 4.5]",
            "[5, 400]",
            "a.toml:2: approach_rate_rad_s item 2 = 400: the model is for 0 to 30 rad/s; is it in \
             deg/s?",
        );
        check(
            "height_m = 0.1",
            "height_mm = 100000",
            "a.toml:9: obstacle 1.height_mm = 100000: the model is for 0 to 10 m",
        );
        check(
            "height_m = 0.1",
            "height_m = 100",
            "a.toml:9: obstacle 1.height_m = 100: the model is for 0 to 10 m; is it in mm?",
        );
        check(
            "to_x_m = 1\n",
            "to_x_m = 1000\n",
            "a.toml:15: avoid 1.to_x_m = 1000: the model is for -100 to 100 m; is it in mm?",
        );
        check(
            "jumps = 2",
            "margin_sigmas = 20\njumps = 2",
            "a.toml:1: margin_sigmas = 20: the model is for 0 to 6",
        );
    }

    /// What a course demands is a target alone, if its cost counts.
    #[test]
    fn a_target_is_demanded_if_no_goal_is_given() {
        let target = |text: &str| demanded_target(&parse(text, "a.toml").unwrap());
        let course = "approach_rate_rad_s = 5\ntarget_x_m = 4\n";
        assert_eq!(target(course), Some(4.0));
        for more in [
            "goal_from_x_m = 0",
            "goal_to_x_m = 5",
            "deviation_weight = 0",
        ] {
            assert_eq!(target(&format!("{course}{more}")), None, "{more}");
        }
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
