//! Files that a person wrote: what can be wrong with them, and how they are read.

use std::fs::File;
use std::io::{Read, stdin};
use std::path::{Path, PathBuf};

use saltus_robot::RobotError;

/// Why a file could not be used. Every message begins with the file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InputError {
    /// A key of a TOML file, or its value.
    #[error(transparent)]
    Key(#[from] RobotError),
    /// A file that is not what it should be.
    #[error("{file}: {reason}")]
    Content {
        /// The file, with the line where there is one.
        file: String,
        /// What is wrong, and what is expected.
        reason: String,
    },
    /// A file that the system does not let us read.
    #[error("{}: cannot be read: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
}

impl InputError {
    /// `file` is not what it should be.
    #[allow(clippy::needless_pass_by_value)] // A reference shows itself just as well.
    pub fn content(file: impl ToString, reason: impl ToString) -> InputError {
        InputError::Content {
            file: file.to_string(),
            reason: reason.to_string(),
        }
    }
}

/// The bytes of the file at `path`, which may have `limit_mib` MiB at most; `-` is standard input.
///
/// # Errors
/// [`InputError`] for a file that cannot be read, or is larger.
pub fn bytes(path: &Path, limit_mib: u64) -> Result<Vec<u8>, InputError> {
    let limit = limit_mib << 20;
    let mut bytes = Vec::new();
    // One byte more than the limit tells a file at the limit from a larger or an endless one.
    let read = if path == Path::new("-") {
        stdin().lock().take(limit + 1).read_to_end(&mut bytes)
    } else {
        File::open(path).and_then(|file| file.take(limit + 1).read_to_end(&mut bytes))
    };
    read.map_err(|source| InputError::Read {
        file: path.into(),
        source,
    })?;
    if bytes.len() as u64 > limit {
        let reason = format!("larger than {limit_mib} MiB, the most it may have");
        return Err(InputError::content(path.display(), reason));
    }
    Ok(bytes)
}

/// The same as text.
///
/// # Errors
/// [`InputError`] as [`bytes`], and where it is not UTF-8.
pub fn text(path: &Path, limit_mib: u64) -> Result<String, InputError> {
    String::from_utf8(bytes(path, limit_mib)?).map_err(|error| {
        let offset = error.utf8_error().valid_up_to();
        InputError::content(path.display(), format!("byte {offset} is not UTF-8 text"))
    })
}

/// `text` on one line, cut after 40 characters: a value as messages quote it.
pub fn cut(text: &str) -> String {
    let line = one_line(&text.chars().take(40).collect::<String>());
    if text.chars().nth(40).is_some() {
        format!("{line}…")
    } else {
        line
    }
}

/// `text` with a mark for each character that would break the line.
pub(crate) fn one_line(text: &str) -> String {
    text.chars()
        .map(|c| if c.is_control() { '␀' } else { c })
        .collect()
}
