//! A TOML document as a tree that remembers where each value was written, and overrides
//! applied to it.

use std::collections::BTreeMap;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeInteger, DeTable, DeValue};

use crate::{Place, RobotError};

/// A table.
pub(crate) type Table = BTreeMap<String, Node>;

/// A value and where it was written.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub(crate) place: Place,
    /// The value as written; a long one is cut.
    pub(crate) source: String,
    pub(crate) value: Value,
}

/// What files may hold.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Text(String),
    /// A decimal literal, integer or not, without separators; unrounded until its unit is known.
    Number(String),
    Array(Vec<Node>),
    Table(Table),
    /// A boolean or a date, which no key takes.
    Other,
}

/// The document `text`, in which messages call the file `file`.
pub(crate) fn parse(text: &str, file: &str) -> Result<Node, RobotError> {
    let lines = Lines::new(text, file);
    let table = DeTable::parse(text).map_err(|error| RobotError::NotToml {
        place: error
            .span()
            .map_or(lines.whole_file(), |span| lines.place(span.start)),
        reason: one_line(error.message()),
    })?;
    let value = Spanned::new(table.span(), DeValue::Table(table.into_inner()));
    let root = node(value, text, &|offset| lines.place(offset));
    Ok(Node {
        place: lines.whole_file(),
        ..root
    })
}

/// Sets in `document` what the `index`-th override `text`, `KEY=VALUE`, says. A value that is not
/// TOML is a bare string.
pub(crate) fn set(document: &mut Node, index: usize, text: &str) -> Result<(), RobotError> {
    let not_an_override = || RobotError::NotAnOverride { text: text.into() };
    let (key, literal) = text.split_once('=').ok_or_else(not_an_override)?;
    let path = dotted_key(key).ok_or_else(not_an_override)?;
    let place = Place::Override {
        index,
        text: text.into(),
    };
    let literal = literal.trim();
    let new = match DeValue::parse(literal) {
        Ok(value) => node(value, literal, &|_| place.clone()),
        Err(_) => Node {
            place: place.clone(),
            source: cut(literal),
            value: Value::Text(literal.into()),
        },
    };

    let mut at = document;
    for (depth, key) in path.iter().enumerate() {
        let Value::Table(table) = &mut at.value else {
            let (key, value) = (join("", &path[..depth]), at.source.clone());
            return Err(RobotError::NotAllowed {
                place,
                key,
                value,
                allowed: "a table".into(),
            });
        };
        at = table.entry(key.clone()).or_insert_with(|| Node {
            place: place.clone(),
            source: String::new(),
            value: Value::Table(Table::new()),
        });
    }
    *at = new;
    Ok(())
}

/// `path` with `keys` appended, dotted; a key that is not bare is quoted.
pub(crate) fn join(path: &str, keys: &[impl AsRef<str>]) -> String {
    let path = Some(path.to_owned()).filter(|path| !path.is_empty());
    let keys = keys.iter().map(|key| shown(key.as_ref()));
    path.into_iter().chain(keys).collect::<Vec<_>>().join(".")
}

fn shown(key: &str) -> String {
    let is_bare = !key.is_empty()
        && key
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if is_bare {
        cut(key)
    } else {
        format!("{:?}", cut(key))
    }
}

/// The keys of a dotted key; none if it is not one.
fn dotted_key(text: &str) -> Option<Vec<String>> {
    if text.chars().any(char::is_control) {
        return None;
    }
    let document = format!("{text} = 0");
    let mut table = DeTable::parse(&document).ok()?.into_inner();
    let mut path = Vec::new();
    while let Some((key, value)) = table.into_iter().next() {
        path.push(key.into_inner().into_owned());
        match value.into_inner() {
            DeValue::Table(inner) => table = inner,
            _ => return Some(path),
        }
    }
    None
}

/// Turns offsets into places.
struct Lines {
    file: Arc<str>,
    /// Offset of each line's first byte.
    starts: Vec<usize>,
}

impl Lines {
    fn new(text: &str, file: &str) -> Lines {
        let starts = std::iter::once(0)
            .chain(text.match_indices('\n').map(|(at, _)| at + 1))
            .collect();
        Lines {
            file: file.into(),
            starts,
        }
    }

    fn place(&self, offset: usize) -> Place {
        let line = self.starts.partition_point(|&start| start <= offset) as u64;
        Place::File {
            file: self.file.clone(),
            line: Some(line),
        }
    }

    fn whole_file(&self) -> Place {
        Place::File {
            file: self.file.clone(),
            line: None,
        }
    }
}

/// The tree of `value`, a part of `text`, whose offsets stand at `place`.
fn node(value: Spanned<DeValue<'_>>, text: &str, place: &impl Fn(usize) -> Place) -> Node {
    let span = value.span();
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(integer) => Value::Number(decimal(&integer)),
        DeValue::Float(float) => Value::Number(float.as_str().into()),
        DeValue::Array(array) => Value::Array(
            array
                .into_iter()
                .map(|value| node(value, text, place))
                .collect(),
        ),
        DeValue::Table(table) => Value::Table(
            table
                .into_iter()
                .map(|(key, value)| (key.into_inner().into_owned(), node(value, text, place)))
                .collect(),
        ),
        DeValue::Boolean(_) | DeValue::Datetime(_) => Value::Other,
    };
    Node {
        place: place(span.start),
        source: cut(text.get(span).unwrap_or_default()),
        value,
    }
}

/// A decimal literal for `integer`, which TOML also writes in other bases; one too large for any
/// number stands for the largest.
fn decimal(integer: &DeInteger<'_>) -> String {
    match integer.radix() {
        10 => integer.as_str().into(),
        radix => i128::from_str_radix(integer.as_str(), radix)
            .map_or("1e999".into(), |value| value.to_string()),
    }
}

/// `text` on one line, cut after 40 characters.
pub(crate) fn cut(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}…", one_line(&text[..end])),
        None => one_line(text),
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}
