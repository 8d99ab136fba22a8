//! Files and folders under a temporary name, which a run that is killed leaves and the next one
//! removes.

use std::fs::{self, DirBuilder, OpenOptions};
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

/// A file or a folder that is removed unless it was renamed.
#[derive(Debug)]
pub struct Temporary(PathBuf);

impl Temporary {
    /// An empty file in the folder of `place`.
    ///
    /// # Errors
    /// What the system says where it cannot be made.
    pub fn beside(place: &Path) -> Result<Temporary> {
        Temporary::make(folder_of(place), |path| {
            OpenOptions::new()
                .write(true)
                .create_new(true)
                .open(path)
                .map(|_| ())
        })
    }

    /// An empty folder in `folder`.
    ///
    /// # Errors
    /// What the system says where it cannot be made.
    pub fn folder_in(folder: &Path) -> Result<Temporary> {
        Temporary::make(folder, |path| DirBuilder::new().create(path))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    fn make(folder: &Path, create: impl Fn(&Path) -> Result<()>) -> Result<Temporary> {
        sweep(folder);
        let mut last = Error::from(ErrorKind::AlreadyExists);
        for attempt in 0..100 {
            let path = folder.join(format!(".saltus-{}-{attempt}.tmp", std::process::id()));
            match create(&path) {
                Ok(()) => return Ok(Temporary(path)),
                Err(error) if error.kind() == ErrorKind::AlreadyExists => last = error,
                Err(error) => return Err(error),
            }
        }
        Err(last)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        remove(&self.0);
    }
}

/// Removes from `folder` what runs that are gone have left in it.
pub fn sweep(folder: &Path) {
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let process = name.to_str().and_then(process_of);
        if process.is_some_and(|process| is_gone(process, &entry)) {
            remove(&entry.path());
        }
    }
}

/// The folder that `place` is in.
fn folder_of(place: &Path) -> &Path {
    place.parent().unwrap_or(Path::new(""))
}

/// The process whose temporary file has this name: `.saltus-PROCESS-ATTEMPT.tmp`.
fn process_of(name: &str) -> Option<u32> {
    let (process, attempt) = name
        .strip_prefix(".saltus-")?
        .strip_suffix(".tmp")?
        .split_once('-')?;
    attempt.parse::<u32>().ok()?;
    process.parse().ok()
}

/// Whether a process has ended that wrote `entry`: where the system does not tell, whether it has
/// not written for a day.
fn is_gone(process: u32, entry: &fs::DirEntry) -> bool {
    const DAY: u64 = 86_400;
    let processes = Path::new("/proc");
    if processes.join("self").exists() {
        return !processes.join(process.to_string()).exists();
    }
    let changed = entry.metadata().and_then(|it| it.modified()).ok();
    changed
        .and_then(|at| at.elapsed().ok())
        .is_some_and(|age| age.as_secs() > DAY)
}

/// Removes a file or a folder; after a rename there is nothing to remove.
fn remove(path: &Path) {
    let _ = fs::remove_file(path).or_else(|_| fs::remove_dir_all(path));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_of_temporary_files_name_a_process() {
        let check =
            |name: &str, process: Option<u32>| assert_eq!(process_of(name), process, "{name}");
        check(".saltus-17-0.tmp", Some(17));
        for name in [
            "saltus-17-0.tmp",
            ".saltus-17.tmp",
            ".saltus-x-0.tmp",
            ".saltus-17-0.tmp.csv",
            ".saltus--0.tmp",
        ] {
            check(name, None);
        }
    }
}
