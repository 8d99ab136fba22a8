//! Courses of the one-leg hopper from JSON files.

use std::collections::HashSet;
use std::path::Path;

use saltus_planner::course::{Course, MAX_JUMPS, Obstacle, Span};
use serde_json::Value;

use crate::input::{self, InputError, cut};

/// Greatest size of a file (MiB).
const LIMIT_MIB: u64 = 16;
/// Greatest magnitude of a length (m).
const LENGTH: f64 = 1e4;

/// The courses in the file at `path`; `-` is standard input.
///
/// # Errors
/// [`InputError`] where the file cannot be read or holds no courses; it names the key, the value
/// and what is allowed.
pub fn load(path: impl AsRef<Path>) -> Result<Vec<Course>, InputError> {
    let path = path.as_ref();
    parse(&input::text(path, LIMIT_MIB)?, &path.display().to_string())
}

/// The courses that `text` holds; messages call it `file`.
///
/// # Errors
/// [`InputError`] where it holds none.
pub fn parse(text: &str, file: &str) -> Result<Vec<Course>, InputError> {
    let document: Value = serde_json::from_str(text)
        .map_err(|error| InputError::content(file, format!("not JSON: {error}")))?;
    let root = Node {
        file,
        path: String::new(),
        value: &document,
    };
    let courses = root
        .list("instances")?
        .into_iter()
        .map(|node| course(&node))
        .collect::<Result<Vec<_>, _>>()?;
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

fn course(node: &Node) -> Result<Course, InputError> {
    let goal = node.length("goal_x_m")?;
    let obstacles = node.list("obstacles")?;
    let no_landing = node.list("no_landing")?;
    Ok(Course {
        id: node.word("id")?,
        start: node.length("start_x_m")?,
        start_height: node.number("start_height_m", "a height from 0 to 10000 m", |x| {
            (0.0..=LENGTH).contains(&x)
        })?,
        jumps: node.count("jumps")?,
        goal: Span::point(goal),
        obstacles: obstacles.iter().map(obstacle).collect::<Result<_, _>>()?,
        no_landing: no_landing.iter().map(area).collect::<Result<_, _>>()?,
    })
}

fn obstacle(node: &Node) -> Result<Obstacle, InputError> {
    Ok(Obstacle {
        center: node.length("center_x_m")?,
        width: node.size("width_m")?,
        height: node.size("height_m")?,
    })
}

fn area(node: &Node) -> Result<Span, InputError> {
    let (center, half) = (node.length("center_x_m")?, node.size("width_m")? / 2.0);
    Ok(Span::new(center - half, center + half))
}

/// A value in the document, and where it is.
struct Node<'a> {
    file: &'a str,
    path: String,
    value: &'a Value,
}

impl<'a> Node<'a> {
    fn refused(&self, allowed: &str) -> InputError {
        let value = cut(&self.value.to_string());
        InputError::content(
            self.file,
            format!("{} = {value}: must be {allowed}", self.path),
        )
    }

    fn member(&self, key: &str) -> Result<Node<'a>, InputError> {
        let path = if self.path.is_empty() {
            key.to_owned()
        } else {
            format!("{}.{key}", self.path)
        };
        match self.value.as_object() {
            None if self.path.is_empty() => Err(InputError::content(
                self.file,
                "must be an object with instances",
            )),
            None => Err(self.refused("an object")),
            Some(object) => match object.get(key) {
                Some(value) => Ok(Node {
                    file: self.file,
                    path,
                    value,
                }),
                None => Err(InputError::content(
                    self.file,
                    format!("missing key {path}"),
                )),
            },
        }
    }

    fn list(&self, key: &str) -> Result<Vec<Node<'a>>, InputError> {
        let list = self.member(key)?;
        let items = list
            .value
            .as_array()
            .ok_or_else(|| list.refused("a list"))?;
        let item = |(i, value)| Node {
            file: list.file,
            path: format!("{} {}", list.path, i + 1),
            value,
        };
        Ok(items.iter().enumerate().map(item).collect())
    }

    fn number(&self, key: &str, allowed: &str, legal: fn(f64) -> bool) -> Result<f64, InputError> {
        let node = self.member(key)?;
        node.value
            .as_f64()
            .filter(|x| legal(*x))
            .ok_or_else(|| node.refused(allowed))
    }

    fn length(&self, key: &str) -> Result<f64, InputError> {
        self.number(key, "a length from -10000 to 10000 m", |x| {
            x.abs() <= LENGTH
        })
    }

    fn size(&self, key: &str) -> Result<f64, InputError> {
        self.number(key, "a length above 0 and up to 10000 m", |x| {
            x > 0.0 && x <= LENGTH
        })
    }

    fn count(&self, key: &str) -> Result<usize, InputError> {
        let node = self.member(key)?;
        let count = node
            .value
            .as_u64()
            .and_then(|count| usize::try_from(count).ok());
        count
            .filter(|count| (1..=MAX_JUMPS).contains(count))
            .ok_or_else(|| node.refused(&format!("a whole number from 1 to {MAX_JUMPS}")))
    }

    fn word(&self, key: &str) -> Result<String, InputError> {
        let node = self.member(key)?;
        let word = node
            .value
            .as_str()
            .filter(|word| !word.is_empty() && !word.chars().any(char::is_control));
        word.map(str::to_owned)
            .ok_or_else(|| node.refused("a name"))
    }
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
            "instances 1.obstacles 1.center_x_m = \"x\": must be a length",
        );
        check(
            "\"height_m\": 0.1",
            "\"height_m\": -1",
            "instances 1.obstacles 1.height_m = -1: must be a length above 0",
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
