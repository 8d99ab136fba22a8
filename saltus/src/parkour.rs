//! Courses of the one-leg hopper from JSON files.

use std::collections::HashSet;
use std::path::Path;

use saltus_planner::course::{Course, MAX_JUMPS, Obstacle, Span};
use saltus_robot::RobotError;
use saltus_robot::domain::Domain;
use saltus_robot::section::Section;
use saltus_robot::units::LENGTH;

use crate::course::{ANYWHERE, PLACE};
use crate::input::{self, InputError, cut};

/// Greatest size of a file (MiB).
const LIMIT_MIB: u64 = 16;
const HEIGHT: Domain = Domain::NON_NEGATIVE.up_to(ANYWHERE.high).called("a height");
const SIZE: Domain = Domain::POSITIVE.up_to(ANYWHERE.high).called("a length");

/// The courses in the file at `path`; `-` is standard input.
///
/// # Errors
/// [`InputError`] where the file cannot be read or holds no courses; it names the key, the value
/// and what is allowed.
pub fn load(path: impl AsRef<Path>) -> Result<Vec<Course>, InputError> {
    let path = path.as_ref();
    parse(&input::text(path, LIMIT_MIB)?, &path.display().to_string())
}

/// The courses that `text` holds; messages call it `file`. Keys that no course has are left unread.
///
/// # Errors
/// [`InputError`] where it holds none.
pub fn parse(text: &str, file: &str) -> Result<Vec<Course>, InputError> {
    let mut root = Section::json(text, file)?;
    let instances = list(&mut root, "instances");
    root.stop_at_problem()?;
    let courses: Vec<Course> = instances
        .into_iter()
        .map(course)
        .collect::<Result<_, _>>()?;
    if courses.is_empty() {
        return Err(InputError::content(
            file,
            "instances is empty: at least one course is needed",
        ));
    }
    let mut known = HashSet::new();
    match courses
        .iter()
        .find(|course| !known.insert(course.id.as_str()))
    {
        Some(twice) => Err(InputError::content(
            file,
            format!("id {:?} is there twice", cut(&twice.id)),
        )),
        None => Ok(courses),
    }
}

fn course(mut s: Section) -> Result<Course, RobotError> {
    let goal = s.number("goal_x", LENGTH, PLACE);
    let (obstacles, no_landing) = (list(&mut s, "obstacles"), list(&mut s, "no_landing"));
    let name = |text: &str| {
        let is_name = !text.is_empty() && !text.chars().any(char::is_control);
        is_name.then(|| text.to_owned())
    };
    let course = Course {
        id: s
            .text_as("id", "a name in quotes", name)
            .unwrap_or_default(),
        start: s.number("start_x", LENGTH, PLACE),
        start_height: s.number("start_height", LENGTH, HEIGHT),
        jumps: s.count_to("jumps", MAX_JUMPS).unwrap_or_else(|| {
            s.missing(&["jumps"], "a whole number");
            1
        }),
        goal: Span::point(goal),
        obstacles: obstacles
            .into_iter()
            .map(obstacle)
            .collect::<Result<_, _>>()?,
        no_landing: no_landing.into_iter().map(area).collect::<Result<_, _>>()?,
    };
    s.stop_at_problem().map(|()| course)
}

fn obstacle(mut s: Section) -> Result<Obstacle, RobotError> {
    let obstacle = Obstacle {
        center: s.number("center_x", LENGTH, PLACE),
        width: s.number("width", LENGTH, SIZE),
        height: s.number("height", LENGTH, SIZE),
    };
    s.stop_at_problem().map(|()| obstacle)
}

fn area(mut s: Section) -> Result<Span, RobotError> {
    let center = s.number("center_x", LENGTH, PLACE);
    let half = s.number("width", LENGTH, SIZE) / 2.0;
    s.stop_at_problem()
        .map(|()| Span::new(center - half, center + half))
}

/// The tables of the list `key`, which must be there.
fn list(s: &mut Section, key: &str) -> Vec<Section> {
    if !s.has(key) {
        s.missing(&[key], "a list");
    }
    s.tables(key, usize::MAX)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const GOOD: &str = r#"{"instances": [{"id": "a", "start_x_m": 0, "start_height_m": 0, "jumps": 2, "goal_x_m": 1.2,
        "obstacles": [{"center_x_m": 0.6, "width_m": 0.1, "height_m": 0.1}],
        "no_landing": [{"center_x_m": 0.2, "width_m": 0.1}], "published": null}]}"#;

    #[test]
    fn a_course_is_read() {
        let courses = parse(GOOD, "a.json").unwrap();
        assert_eq!(
            courses[0].obstacles,
            [Obstacle {
                center: 0.6,
                width: 0.1,
                height: 0.1
            }]
        );
        assert_eq!((courses[0].jumps, courses[0].goal), (2, Span::point(1.2)));
    }

    #[test]
    fn wrong_files_are_refused_with_their_place() {
        let check = |from: &str, to: &str, message: &str| {
            let text = GOOD.replace(from, to);
            assert_ne!(text, GOOD, "{from}");
            let error = parse(&text, "a.json").unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        check(
            "\"jumps\": 2",
            "\"jumps\": 2.5",
            "a.json: instances 1.jumps = 2.5: must be a whole number from 1 to",
        );
        check(
            "\"jumps\": 2",
            "\"jumps\": 99",
            "instances 1.jumps = 99: must be a whole number",
        );
        check("\"jumps\": 2,", "", "a.json: missing key instances 1.jumps");
        check(
            "\"id\": \"a\"",
            "\"id\": 3",
            "instances 1.id = 3: must be a name",
        );
        check(
            "0.6,",
            "\"x\",",
            "instances 1.obstacles 1.center_x_m = \"x\": must be a finite number",
        );
        check(
            "\"height_m\": 0.1",
            "\"height_m\": -1",
            "instances 1.obstacles 1.height_m = -1: must be a length > 0",
        );
        check("1.2", "1e999", "not JSON");
        check("null}]}", "null}", "not JSON");
        check("instances", "plans", "missing key instances");
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused(text in ".{0,300}") {
            let _ = parse(&text, "a.json");
        }

        #[test]
        fn damaged_files_are_read_or_refused(at in 0..GOOD.len(), byte in any::<u8>()) {
            let mut bytes = GOOD.as_bytes().to_vec();
            bytes[at] = byte;
            let _ = parse(&String::from_utf8_lossy(&bytes), "a.json");
        }
    }
}
