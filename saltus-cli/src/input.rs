//! What a command reads, and which files these are: none of them may be overwritten.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use saltus::planner::Crossing;

use crate::error::CliError;

/// The files that were read.
static READ: Mutex<Vec<Identity>> = Mutex::new(Vec::new());

/// Which file a path leads to, whatever links and folders it goes through.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Identity {
    place: PathBuf,
    /// Device and number on it, where the file is there and the system has such numbers.
    node: Option<(u64, u64)>,
}

impl Identity {
    /// That of the file at `path`, which need not be there; none of a device or a pipe.
    pub(crate) fn of(path: &Path) -> Option<Identity> {
        let there = std::fs::metadata(path).ok();
        if there.as_ref().is_some_and(|it| !it.is_file()) {
            return None;
        }
        let place = path.canonicalize().unwrap_or_else(|_| {
            let folder = path
                .parent()
                .filter(|folder| !folder.as_os_str().is_empty());
            let folder = folder
                .unwrap_or(Path::new("."))
                .canonicalize()
                .unwrap_or_default();
            folder.join(path.file_name().unwrap_or_default())
        });
        Some(Identity {
            place,
            node: there.as_ref().and_then(node),
        })
    }

    /// Whether both are one file.
    pub(crate) fn is_same(&self, other: &Identity) -> bool {
        self.place == other.place || (self.node.is_some() && self.node == other.node)
    }
}

#[cfg(unix)]
#[allow(clippy::unnecessary_wraps)] // Other systems have none.
fn node(there: &std::fs::Metadata) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    Some((there.dev(), there.ino()))
}

#[cfg(not(unix))]
fn node(_: &std::fs::Metadata) -> Option<(u64, u64)> {
    None
}

/// Notes that the command reads the file at `path`.
pub(crate) fn note(path: &Path) {
    READ.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .extend(Identity::of(path));
}

/// Whether the command has read this file.
pub(crate) fn is_read(file: &Identity) -> bool {
    READ.lock()
        .unwrap_or_else(PoisonError::into_inner)
        .iter()
        .any(|read| read.is_same(file))
}

/// The bytes of the file at `path`, which may have `limit_mib` MiB at most; `-` is standard input.
pub(crate) fn bytes(path: &Path, limit_mib: u64) -> Result<Vec<u8>, CliError> {
    note(path);
    Ok(saltus::input::bytes(path, limit_mib)?)
}

/// The course in the file at `path`.
pub(crate) fn course(path: &Path) -> Result<Crossing, CliError> {
    note(path);
    Ok(saltus::course::load(path)?)
}
