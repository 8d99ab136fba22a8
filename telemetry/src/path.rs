//! Paths to numbers in messages, such as `/joint_states.position[leg_1]`.

use std::fmt;
use std::str::FromStr;

use crate::Error;

/// Where a number is: a topic, and fields of its messages.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Path {
    /// The topic.
    pub topic: String,
    /// The field, a field of that, and so on; at least one.
    pub fields: Vec<Field>,
}

/// A field, or an element of one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Field {
    /// Its name.
    pub name: String,
    /// Which element of it, if it has several.
    pub index: Option<Index>,
}

/// Which element of a list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Index {
    /// Counted from 0.
    Number(usize),
    /// Where this text stands in the list `name` beside it, as in `sensor_msgs/msg/JointState`.
    Name(String),
}

impl Field {
    /// The field `name`, which is no list.
    pub fn named(name: &str) -> Field {
        Field {
            name: name.into(),
            index: None,
        }
    }
}

impl FromStr for Path {
    type Err = Error;

    fn from_str(text: &str) -> Result<Path, Error> {
        const ALLOWED: &str = "must be a topic and fields, as in /imu.angular_velocity.y or \
            /joint_states.position[leg_1]";
        let refused = || Error::Path {
            path: text.into(),
            reason: ALLOWED.into(),
        };
        let (topic, rest) = text.split_once('.').ok_or_else(refused)?;
        if topic.is_empty() || topic.contains(['[', ']', ' ']) {
            return Err(refused());
        }
        let fields: Option<Vec<Field>> = parts(rest).into_iter().map(field).collect();
        let fields = fields.ok_or_else(refused)?;
        Ok(Path {
            topic: topic.into(),
            fields,
        })
    }
}

/// What stands between the points that are in no brackets.
fn parts(text: &str) -> Vec<&str> {
    let (mut parts, mut start, mut inside) = (Vec::new(), 0, false);
    for (at, c) in text.char_indices() {
        match c {
            '[' => inside = true,
            ']' => inside = false,
            '.' if !inside => {
                parts.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

fn field(text: &str) -> Option<Field> {
    let (name, index) = match text.split_once('[') {
        None => (text, None),
        Some((name, rest)) => (name, Some(index(rest.strip_suffix(']')?)?)),
    };
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    (!name.is_empty() && name.chars().all(is_name)).then(|| Field {
        name: name.into(),
        index,
    })
}

fn index(text: &str) -> Option<Index> {
    if text.is_empty() || text.contains(['[', ']']) {
        return None;
    }
    if text.bytes().all(|c| c.is_ascii_digit()) {
        return text.parse().ok().map(Index::Number);
    }
    Some(Index::Name(text.into()))
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.topic)?;
        for field in &self.fields {
            write!(f, ".{field}")?;
        }
        Ok(())
    }
}

impl fmt::Display for Field {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.index {
            None => f.write_str(&self.name),
            Some(Index::Number(index)) => write!(f, "{}[{index}]", self.name),
            Some(Index::Name(index)) => write!(f, "{}[{index}]", self.name),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_read_and_written() {
        for text in [
            "/imu.angular_velocity.y",
            "/joint_states.position[leg_1]",
            "/a/b.x[3].y",
            "/joint_states.position[arm.left joint]",
        ] {
            let path: Path = text.parse().expect(text);
            assert_eq!(path.to_string(), text);
        }
        let wrong = [
            "",
            "/imu",
            ".x",
            "/imu.",
            "/imu.x[",
            "/imu.x[]",
            "/imu.x]",
            "/imu.x[1][2]",
            "/imu.a b",
            "/imu..x",
            "/i[0].x",
        ];
        for text in wrong {
            let error = text.parse::<Path>().expect_err(text).to_string();
            assert!(error.contains("must be a topic and fields"), "{error}");
        }
    }
}
