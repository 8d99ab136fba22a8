//! Files that appear whole or not at all.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::error::CliError;

/// What a command writes once everything is computed.
#[derive(Debug, Default)]
pub(crate) struct Files {
    files: Vec<(PathBuf, Vec<u8>)>,
    screen: Option<String>,
}

impl Files {
    /// Adds a file.
    pub(crate) fn add(&mut self, path: &Path, bytes: Vec<u8>) {
        self.files.push((path.into(), bytes));
    }

    /// Adds the report: a file, or the screen without one.
    pub(crate) fn report(&mut self, path: Option<&Path>, text: String) {
        match path {
            Some(path) if path != Path::new("-") => self.add(path, text.into_bytes()),
            _ => self.screen = Some(text),
        }
    }

    /// Writes all files under temporary names beside their places, then renames them, then prints.
    ///
    /// Whatever fails, no file is there in part.
    pub(crate) fn write(self) -> Result<(), CliError> {
        let staged =
            self.files.iter().map(|(path, bytes)| Staged::new(path, bytes)).collect::<Result<Vec<_>, _>>()?;
        for file in staged {
            file.publish()?;
        }
        match self.screen {
            Some(text) => print(&text),
            None => Ok(()),
        }
    }
}

/// Prints `text`; that nobody reads on is no error.
pub(crate) fn print(text: &str) -> Result<(), CliError> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::write(Path::new("standard output"), error))
        }
        _ => Ok(()),
    }
}

/// A file written but not yet in its place.
#[derive(Debug)]
enum Staged {
    /// Under a temporary name.
    Beside { temporary: Temporary, place: PathBuf },
    /// A device or a pipe, which takes the bytes as they are.
    Device { place: PathBuf, bytes: Vec<u8> },
}

impl Staged {
    fn new(path: &Path, bytes: &[u8]) -> Result<Staged, CliError> {
        let failed = |error| CliError::write(path, error);
        // Through a symbolic link, the file that it leads to is replaced.
        let place = fs::canonicalize(path).unwrap_or_else(|_| path.into());
        let there = fs::metadata(&place).ok();
        if there.as_ref().is_some_and(fs::Metadata::is_dir) || path.file_name().is_none() {
            return Err(failed(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        if there.as_ref().is_some_and(|it| !it.is_file()) {
            return Ok(Staged::Device { place, bytes: bytes.into() });
        }
        let temporary = Temporary::beside(&place).map_err(failed)?;
        fs::write(&temporary.0, bytes).map_err(failed)?;
        if let Some(it) = there {
            fs::set_permissions(&temporary.0, it.permissions()).map_err(failed)?;
        }
        Ok(Staged::Beside { temporary, place })
    }

    fn publish(self) -> Result<(), CliError> {
        match self {
            Staged::Beside { temporary, place } => {
                fs::rename(&temporary.0, &place).map_err(|error| CliError::write(&place, error))
            }
            Staged::Device { place, bytes } => fs::OpenOptions::new()
                .write(true)
                .open(&place)
                .and_then(|mut device| device.write_all(&bytes))
                .map_err(|error| CliError::write(&place, error)),
        }
    }
}

/// A file that is removed unless it was renamed.
#[derive(Debug)]
struct Temporary(PathBuf);

impl Temporary {
    fn beside(place: &Path) -> io::Result<Temporary> {
        let mut last = io::Error::from(io::ErrorKind::AlreadyExists);
        for attempt in 0..100 {
            let temporary = place.with_file_name(format!(".saltus-{}-{attempt}.tmp", std::process::id()));
            match fs::OpenOptions::new().write(true).create_new(true).open(&temporary) {
                Ok(_) => return Ok(Temporary(temporary)),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => last = error,
                Err(error) => return Err(error),
            }
        }
        Err(last)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        // After the rename there is nothing to remove.
        let _ = fs::remove_file(&self.0);
    }
}
