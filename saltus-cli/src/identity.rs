//! Which file is which, whatever it is called.

use std::path::{Path, PathBuf};

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
