//! Why a data folder could not be read or written: one sentence, which begins with the place.

use std::path::Path;

pub(super) use crate::input::{cut, one_line};

/// Bad data, or a place that could not be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A key of `experiment.toml`, or its value.
    #[error(transparent)]
    Key(#[from] saltus_robot::RobotError),
    /// A value that is not what it should be.
    #[error("{place}: {name} = {value}: must be {allowed}")]
    Value {
        /// File and line.
        place: String,
        /// Column or key.
        name: String,
        /// The value as written; a long one is cut.
        value: String,
        /// What is allowed.
        allowed: String,
    },
    /// A key or column that this kind of experiment does not know.
    #[error("{place}: unknown {what} {name}; the nearest known {what} is {nearest}")]
    Unknown {
        /// File and line.
        place: String,
        /// `key` or `column`.
        what: &'static str,
        /// As written; a long one is cut.
        name: String,
        /// The known one with the fewest edits to it.
        nearest: String,
    },
    /// A key or column that must be there.
    #[error("{place}: missing {what} {name}")]
    Missing {
        /// File and line.
        place: String,
        /// `key` or `column`.
        what: &'static str,
        /// Its name, or those of which one must be there.
        name: String,
    },
    /// The same run twice.
    #[error("{place}: duplicate run: {reason}")]
    Duplicate {
        /// File, and line where there is one.
        place: String,
        /// What makes it one.
        reason: String,
    },
    /// A sensor or a clock that cannot have measured what the file says.
    #[error("{place}: {name} {symptom}")]
    Signal {
        /// File, and line where there is one.
        place: String,
        /// Column.
        name: String,
        /// What it does.
        symptom: String,
    },
    /// Folders or runs that are not of one experiment.
    #[error(
        "{place}: {what} = {value} differs from {other} of {of}: only what was done alike goes \
         into one experiment"
    )]
    Differs {
        /// File or folder.
        place: String,
        /// What differs.
        what: &'static str,
        /// Here.
        value: String,
        /// There.
        other: String,
        /// Where.
        of: String,
    },
    /// A file or folder that is not what it should be.
    #[error("{place}: {reason}")]
    Content {
        /// File or folder, with the line where there is one.
        place: String,
        /// What is wrong, and what is expected.
        reason: String,
    },
    /// The same, of data that are probably of another kind than their folder says.
    #[error("{error}; {other}")]
    Kind {
        /// What is not as that kind has it.
        error: Box<Error>,
        /// Which kinds the columns fit.
        other: String,
    },
    /// A file that the system does not let us read.
    #[error("{place}: cannot be read: {source}")]
    Read {
        /// The file.
        place: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// A file that the system does not let us write.
    #[error("{place}: cannot be written: {source}")]
    Write {
        /// The file.
        place: String,
        /// What the system says.
        source: std::io::Error,
    },
}

impl Error {
    pub(super) fn content(place: impl Into<String>, reason: impl Into<String>) -> Error {
        Error::Content {
            place: place.into(),
            reason: reason.into(),
        }
    }

    pub(super) fn value(
        place: String,
        name: &str,
        value: &str,
        allowed: impl Into<String>,
    ) -> Error {
        Error::Value {
            place,
            name: name.into(),
            value: cut(value),
            allowed: allowed.into(),
        }
    }

    pub(super) fn missing(place: String, what: &'static str, name: impl Into<String>) -> Error {
        Error::Missing {
            place,
            what,
            name: name.into(),
        }
    }

    pub(super) fn signal(
        place: impl Into<String>,
        name: &str,
        symptom: impl Into<String>,
    ) -> Error {
        Error::Signal {
            place: place.into(),
            name: name.into(),
            symptom: symptom.into(),
        }
    }

    /// `name` among no `known`.
    pub(super) fn unknown(place: String, what: &'static str, name: &str, known: &[&str]) -> Error {
        let start: String = name.chars().take(64).collect();
        let nearest = known
            .iter()
            .min_by_key(|known| strsim::levenshtein(known, &start));
        Error::Unknown {
            place,
            what,
            name: cut(name),
            nearest: nearest.map_or("none", |known| *known).into(),
        }
    }

    pub(super) fn read(path: &Path, source: std::io::Error) -> Error {
        Error::Read {
            place: shown(path),
            source,
        }
    }

    pub(super) fn write(path: &Path, source: std::io::Error) -> Error {
        Error::Write {
            place: shown(path),
            source,
        }
    }
}

/// A path as messages name it.
pub(super) fn shown(path: &Path) -> String {
    one_line(&path.display().to_string())
}
