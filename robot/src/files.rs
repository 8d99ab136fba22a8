//! Where text comes from: files on the disk, and those built in.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::RobotError;

/// Built-in robots: name and robot file.
pub(crate) const ROBOTS: [(&str, &str); 6] = [
    ("rats-planar", include_str!("../robots/rats-planar.toml")),
    ("rats-boom", include_str!("../robots/rats-boom.toml")),
    ("rats-run", include_str!("../robots/rats-run.toml")),
    ("rats-twelve", include_str!("../robots/rats-twelve.toml")),
    (
        "spring-hopper",
        include_str!("../robots/spring-hopper.toml"),
    ),
    ("table-hopper", include_str!("../robots/table-hopper.toml")),
];

/// Files that built-in robots name.
const TABLES: [(&str, &str); 1] = [(
    "table-hopper-force.csv",
    include_str!("../robots/table-hopper-force.csv"),
)];

/// Greatest size of a file (MiB): some hundred thousand rows of a force table.
const LIMIT_MIB: u64 = 4;

/// The files that a robot file may name.
#[derive(Clone, Copy)]
pub(crate) struct Files<'a> {
    pub(crate) place: Place<'a>,
    /// Told of each file before it is read.
    pub(crate) opened: &'a dyn Fn(&Path),
}

/// Where they are.
#[derive(Clone, Copy)]
pub(crate) enum Place<'a> {
    /// Below a folder.
    Folder(&'a Path),
    /// Built in, or below the working folder, where an override may name one.
    BuiltIn,
}

impl Files<'_> {
    /// The text of `file`, and what messages call it.
    pub(crate) fn read(self, file: &str) -> Result<(String, String), RobotError> {
        let path = match self.place {
            Place::Folder(folder) => folder.join(file),
            Place::BuiltIn => match TABLES.iter().find(|(name, _)| *name == file) {
                Some((name, text)) => return Ok((format!("robots/{name}"), (*text).into())),
                None => file.into(),
            },
        };
        (self.opened)(&path);
        Ok((path.display().to_string(), read_text(&path)?))
    }
}

/// The text of the file at `path`.
pub(crate) fn read_text(path: &Path) -> Result<String, RobotError> {
    let file = || path.display().to_string();
    let mut bytes = Vec::new();
    let limit = LIMIT_MIB << 20;
    // One byte more than the limit tells a file at the limit from a larger or an endless one.
    File::open(path)
        .and_then(|opened| opened.take(limit + 1).read_to_end(&mut bytes))
        .map_err(|source| RobotError::Unreadable {
            file: file(),
            source,
        })?;
    if bytes.len() as u64 > limit {
        return Err(RobotError::TooLarge {
            file: file(),
            limit_mib: LIMIT_MIB,
        });
    }
    String::from_utf8(bytes).map_err(|error| RobotError::NotText {
        file: file(),
        offset: error.utf8_error().valid_up_to(),
    })
}
