//! What a command reads, and which files these are: none of them may be overwritten.

use std::path::Path;

use saltus::course;
use saltus::planner::Crossing;

use crate::error::CliError;
use crate::identity::Identity;
use crate::output;
use crate::session;

/// Notes that the command reads the file at `path`.
pub(crate) fn note(path: &Path) {
    session::with(|session| session.read.extend(Identity::of(path)));
}

/// Whether the command has read this file.
pub(crate) fn is_read(file: &Identity) -> bool {
    session::with(|session| session.read.iter().any(|read| read.is_same(file)))
}

/// Refuses an output that is one of the files read so far, before long work.
pub(crate) fn spared() -> Result<(), CliError> {
    let outputs = session::with(|session| session.outputs.clone());
    match outputs.into_iter().find(|(_, _, place)| is_read(place)) {
        Some((flag, path, _)) => Err(output::overwrites(
            flag,
            &path,
            "those that this command reads",
        )),
        None => Ok(()),
    }
}

/// The bytes of the file at `path`, which may have `limit_mib` MiB at most; `-` is standard input.
pub(crate) fn bytes(path: &Path, limit_mib: u64) -> Result<Vec<u8>, CliError> {
    if let Some(text) = given(path) {
        return Ok(text.into_bytes());
    }
    note(path);
    spared()?;
    Ok(saltus::input::bytes(path, limit_mib)?)
}

/// The course in the file at `path`; numbers out of their usual range are warned of.
pub(crate) fn course(path: &Path) -> Result<Crossing, CliError> {
    let text = if let Some(text) = given(path) {
        text
    } else {
        note(path);
        spared()?;
        saltus::input::text(path, course::LIMIT_MIB)?
    };
    let (crossing, warnings) = course::read(&text, &path.display().to_string())?;
    for warning in warnings {
        output::message(&format!("warning: {warning}"));
    }
    Ok(crossing)
}

/// What another program gave in the place of this file.
fn given(path: &Path) -> Option<String> {
    session::file(path.to_str()?)
}
