//! What can be wrong with a robot file, or another file read as one, and where.

use std::fmt;
use std::sync::Arc;

/// Where a value was written.
///
/// Later places win: an override over the file, a later override over an earlier one.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Place {
    /// In a file.
    File {
        /// The file, as the user named it.
        file: Arc<str>,
        /// Line, from 1; none where the file as a whole is meant.
        line: Option<u64>,
    },
    /// In an override `--set key=value`.
    Override {
        /// Its position among the overrides, from 0.
        index: usize,
        /// What follows `--set`.
        text: Arc<str>,
    },
}

impl Place {
    /// Whether both were written in the one file or the one override.
    pub(crate) fn same_source(&self, other: &Place) -> bool {
        match (self, other) {
            (Place::File { file: a, .. }, Place::File { file: b, .. }) => a == b,
            (Place::Override { index: a, .. }, Place::Override { index: b, .. }) => a == b,
            _ => false,
        }
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Place::File {
                file,
                line: Some(line),
            } => write!(f, "{file}:{line}"),
            Place::File { file, line: None } => f.write_str(file),
            Place::Override { text, .. } => write!(f, "--set {text}"),
        }
    }
}

/// Why a robot, or another file read by [`Section`](crate::section::Section), could not be read.
/// Every message names the place, the key or column, the value and what is allowed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobotError {
    /// A value of the wrong type or outside its domain.
    #[error("{place}: {key} = {value}: must be {allowed}")]
    NotAllowed {
        /// Where it stands.
        place: Place,
        /// Dotted key, or column.
        key: String,
        /// The value as written; a long one is cut.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A key that the file does not have here.
    #[error("{place}: unknown key {key}; {}", instead(nearest.as_deref(), allowed))]
    UnknownKey {
        /// Where it stands.
        place: Place,
        /// Dotted key.
        key: String,
        /// The dotted key that is likely meant; none if each known key differs in more than a third of its
        /// characters.
        nearest: Option<String>,
        /// Keys that its table may have, each in one of its units.
        allowed: Vec<String>,
    },
    /// A key that must be there.
    #[error("{place}: missing key {}{}", spelled(keys), behind_colon(allowed))]
    MissingKey {
        /// Where its table begins.
        place: Place,
        /// Dotted key, in each unit that it may be given in.
        keys: Vec<String>,
        /// What it may be; empty for numbers, whose units say so.
        allowed: String,
    },
    /// One quantity in two units, or in two ways.
    #[error("{place}: {key} is already given as {other}; give one of them")]
    GivenTwice {
        /// Where the second stands.
        place: Place,
        /// Dotted key of the second.
        key: String,
        /// Dotted key of the first.
        other: String,
    },
    /// Not TOML at all.
    #[error("{place}: not TOML: {reason}")]
    NotToml {
        /// Where the parser stopped.
        place: Place,
        /// What it says.
        reason: String,
    },
    /// An override that is not a dotted key, `=` and a value.
    #[error("--set {text}: must be KEY=VALUE with a dotted key, as in leg.stroke_m=0.05")]
    NotAnOverride {
        /// What follows `--set`.
        text: String,
    },
    /// A CSV file with other columns than a force table has.
    #[error("{place}: columns {found}: must be {allowed}")]
    WrongColumns {
        /// The file.
        place: Place,
        /// Its header.
        found: String,
        /// The columns of a force table.
        allowed: String,
    },
    /// A CSV file whose rows cannot be read.
    #[error("{place}: not a table: {source}")]
    NotCsv {
        /// The row.
        place: Place,
        /// What the parser says.
        source: csv::Error,
    },
    /// A grid point of a force table with two rows.
    #[error(
        "{place}: extension {extension} m, speed {speed} m/s: must be given once; line {first} \
         has it too"
    )]
    GridPointTwice {
        /// The second row.
        place: Place,
        /// Extension (m).
        extension: f64,
        /// Speed (m/s).
        speed: f64,
        /// Line of the first row.
        first: u64,
    },
    /// A grid point of a force table without a row.
    #[error(
        "{place}: extension {extension} m, speed {speed} m/s: must be given; the grid has each \
         extension at each speed"
    )]
    GridPointMissing {
        /// The file.
        place: Place,
        /// Extension (m).
        extension: f64,
        /// Speed (m/s).
        speed: f64,
    },
    /// A name that is neither a built-in robot nor a file.
    #[error("{name}: no such robot or file; built in are {}", built_in.join(", "))]
    UnknownRobot {
        /// The name.
        name: String,
        /// Names of the built-in robots.
        built_in: Vec<&'static str>,
    },
    /// A file that the system does not let us read.
    #[error("{file}: cannot be read: {source}")]
    Unreadable {
        /// The file.
        file: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file too large to be a robot's.
    #[error("{file}: larger than {limit_mib} MiB, the most a robot file or force table may have")]
    TooLarge {
        /// The file.
        file: String,
        /// Greatest size (MiB).
        limit_mib: u64,
    },
    /// A file that is not text.
    #[error("{file}: byte {offset} is not UTF-8 text")]
    NotText {
        /// The file.
        file: String,
        /// Bytes before the first wrong one.
        offset: usize,
    },
}

/// What to write instead of an unknown key.
fn instead(nearest: Option<&str>, allowed: &[String]) -> String {
    match nearest {
        Some(nearest) => format!("the nearest known key is {nearest}"),
        None => format!("the keys allowed there are {}", allowed.join(", ")),
    }
}

/// Spellings of one key: the first in full, of the others what is behind the last dot.
fn spelled(keys: &[String]) -> String {
    let (first, others) = keys
        .split_first()
        .map_or(("", keys), |(first, others)| (first.as_str(), others));
    let short = others
        .iter()
        .map(|key| key.rsplit('.').next().unwrap_or(key));
    std::iter::once(first)
        .chain(short)
        .collect::<Vec<_>>()
        .join(" or ")
}

/// `text` behind a colon, where there is any.
fn behind_colon(text: &str) -> String {
    if text.is_empty() {
        String::new()
    } else {
        format!(": {text}")
    }
}
