//! Files that appear whole or not at all.

use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use saltus::temporary::Temporary;

use crate::error::CliError;
use crate::identity::Identity;
use crate::input;
use crate::session::{self, Screen};

/// A file to write.
#[derive(Debug)]
struct Output {
    /// The flag that names it.
    flag: &'static str,
    path: PathBuf,
    content: Content,
}

/// What is to be in a file.
#[derive(Debug)]
enum Content {
    Bytes(Vec<u8>),
    /// It was written as it came.
    Written(Staged),
}

/// What a command writes once everything is computed.
#[derive(Debug, Default)]
pub(crate) struct Files {
    files: Vec<Output>,
    screen: Option<String>,
}

impl Files {
    /// Adds a file, which `flag` names.
    pub(crate) fn add(&mut self, flag: &'static str, path: &Path, bytes: Vec<u8>) {
        self.files.push(Output {
            flag,
            path: path.into(),
            content: Content::Bytes(bytes),
        });
    }

    /// Adds places that are going to be written, each with the flag that names it, to be checked.
    pub(crate) fn extend<'a>(
        &mut self,
        places: impl IntoIterator<Item = (&'static str, &'a Path)>,
    ) {
        for (flag, path) in places {
            self.add(flag, path, Vec::new());
        }
    }

    /// Adds a file that was written as it came.
    pub(crate) fn written(&mut self, stream: Stream) -> Result<(), CliError> {
        let Stream {
            flag,
            path,
            staged,
            mut writer,
        } = stream;
        writer
            .flush()
            .map_err(|error| CliError::write(&path, error))?;
        let content = Content::Written(staged);
        self.files.push(Output {
            flag,
            path,
            content,
        });
        Ok(())
    }

    /// Adds the report: a file, or the screen without one.
    pub(crate) fn report(&mut self, path: Option<&Path>, text: String) {
        match path {
            Some(path) if path != Path::new("-") => self.add("--out", path, text.into_bytes()),
            _ => self.screen = Some(text),
        }
    }

    /// Writes all files under temporary names beside their places, then renames them, then prints.
    ///
    /// Whatever fails, no file is there in part; no file that the command has read is overwritten,
    /// none is written twice, and none appears after the command was stopped.
    pub(crate) fn write(self) -> Result<(), CliError> {
        self.check()?;
        let staged = self
            .files
            .into_iter()
            .map(|out| match out.content {
                Content::Bytes(bytes) => Staged::new(&out.path, &bytes),
                Content::Written(staged) => Ok(staged),
            })
            .collect::<Result<Vec<_>, _>>()?;
        session::obey(session::stop().as_ref());
        for file in staged {
            file.publish()?;
        }
        match self.screen {
            Some(text) => print(&text),
            None => Ok(()),
        }
    }

    /// Refuses a file that the command has read, and one that two flags name.
    pub(crate) fn check(&self) -> Result<(), CliError> {
        let mut before: Vec<(&Output, Identity)> = Vec::new();
        for out in &self.files {
            let Some(place) = Identity::of(&out.path) else {
                continue;
            };
            if input::is_read(&place) {
                return Err(overwrites(
                    out.flag,
                    &out.path,
                    "those that this command reads",
                ));
            }
            if let Some((other, _)) = before.iter().find(|(_, known)| known.is_same(&place)) {
                return Err(overwrites(other.flag, &other.path, out.flag));
            }
            before.push((out, place));
        }
        Ok(())
    }
}

/// That `flag` names a file which is not its own.
pub(crate) fn overwrites(flag: &'static str, path: &Path, other: &str) -> CliError {
    CliError::flag(flag, path.display(), format!("another file than {other}"))
}

/// Refuses a file that cannot be written, before long work: its folder is not there or is read-only, the
/// path is a folder, or another flag names it. What is read later must be another file
/// ([`input::spared`]).
pub(crate) fn reachable(flag: &'static str, path: Option<&Path>) -> Result<(), CliError> {
    let Some(path) = path else {
        return Ok(());
    };
    if let Some(place) = Identity::of(path) {
        if input::is_read(&place) {
            return Err(overwrites(flag, path, "those that this command reads"));
        }
        let other = session::with(|session| {
            let known = session
                .outputs
                .iter()
                .find(|(_, _, known)| known.is_same(&place));
            let other = known.map(|(other, _, _)| *other);
            session.outputs.push((flag, path.into(), place));
            other
        });
        if let Some(other) = other.filter(|other| *other != flag) {
            return Err(overwrites(flag, path, other));
        }
    }
    let folder = path.parent().filter(|it| !it.as_os_str().is_empty());
    if !folder.is_none_or(Path::is_dir) {
        return Err(CliError::write(path, no_folder()));
    }
    // The temporary file is removed at once.
    Staged::new(path, &[]).map(drop)
}

/// That the folder of a file is not there: a command makes the folders that it fills, and no others, so
/// that a misspelt path is seen.
fn no_folder() -> io::Error {
    let text = "its folder is not there, and is made only where a command fills a folder";
    io::Error::new(io::ErrorKind::NotFound, text)
}

/// Refuses a folder that cannot be made or written into, before long work.
pub(crate) fn reachable_folder(path: &Path) -> Result<(), CliError> {
    let failed = |error| CliError::write(path, error);
    let there = path
        .ancestors()
        .map(|it| {
            if it.as_os_str().is_empty() {
                Path::new(".")
            } else {
                it
            }
        })
        .find(|it| it.exists());
    let there = there.unwrap_or(Path::new("."));
    if !there.is_dir() {
        return Err(failed(io::Error::from(io::ErrorKind::NotADirectory)));
    }
    Temporary::folder_in(there).map(drop).map_err(failed)
}

/// Prints `text`; that nobody reads on is no error.
pub(crate) fn print(text: &str) -> Result<(), CliError> {
    match Screen
        .write_all(text.as_bytes())
        .and_then(|()| Screen.flush())
    {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(CliError::write(Path::new("standard output"), error))
        }
        _ => Ok(()),
    }
}

/// A file that is written as its contents come, and appears when it is whole.
#[derive(Debug)]
pub(crate) struct Stream {
    flag: &'static str,
    path: PathBuf,
    staged: Staged,
    writer: BufWriter<fs::File>,
}

impl Stream {
    /// Opens the file at `path`, which `flag` names, under a temporary name; a device or a pipe at
    /// once.
    pub(crate) fn open(flag: &'static str, path: &Path) -> Result<Stream, CliError> {
        let failed = |error| CliError::write(path, error);
        let staged = Staged::new(path, &[])?;
        let file = match &staged {
            Staged::Beside { temporary, .. } => temporary.path(),
            Staged::Device { place, .. } => place,
        };
        let opened = fs::OpenOptions::new().write(true).open(file);
        Ok(Stream {
            flag,
            path: path.into(),
            writer: BufWriter::new(opened.map_err(failed)?),
            staged,
        })
    }

    /// Where it is going to be.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.writer.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// A file written but not yet in its place.
#[derive(Debug)]
enum Staged {
    /// Under a temporary name.
    Beside {
        temporary: Temporary,
        place: PathBuf,
    },
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
            return Ok(Staged::Device {
                place,
                bytes: bytes.into(),
            });
        }
        let temporary = Temporary::beside(&place).map_err(failed)?;
        fs::write(temporary.path(), bytes).map_err(failed)?;
        if let Some(it) = there {
            fs::set_permissions(temporary.path(), it.permissions()).map_err(failed)?;
        }
        Ok(Staged::Beside { temporary, place })
    }

    fn publish(self) -> Result<(), CliError> {
        match self {
            Staged::Beside { temporary, place } => {
                fs::rename(temporary.path(), &place).map_err(|error| CliError::write(&place, error))
            }
            Staged::Device { place, bytes } => fs::OpenOptions::new()
                .write(true)
                .open(&place)
                .and_then(|mut device| device.write_all(&bytes))
                .map_err(|error| CliError::write(&place, error)),
        }
    }
}
