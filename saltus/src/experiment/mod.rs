//! Data folders: measured runs with an `experiment.toml` that says what was done.
//!
//! [`read`] checks what a person or a logger can have got wrong, and says where; what it lets
//! through can be trusted to be numbers of the right size, in order. What is odd and usable becomes
//! a note.
//!
//! ```no_run
//! let folder = saltus::experiment::Folder::open("drops/tennis-ball")?;
//! for note in &folder.notes {
//!     eprintln!("{note}");
//! }
//! println!("{} runs, {} rows", folder.experiment.runs.len(), folder.rows);
//! # Ok::<(), saltus::experiment::Error>(())
//! ```

mod channel;
mod clock;
mod digest;
mod error;
mod header;
mod idle;
mod instant;
mod join;
mod lines;
mod manifest;
#[cfg(feature = "telemetry")]
mod mcap;
#[cfg(not(feature = "telemetry"))]
#[path = "without_mcap.rs"]
mod mcap;
mod mechanism;
mod misfit;
mod plan;
mod run;
mod thin;
mod valve;
mod write;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use digest::digests;
pub use error::Error;
pub use join::read_all;
pub use plan::{Plan, PlanError};
use saltus_diagnosis::plausible::implausible;
pub use saltus_diagnosis::{Experiment, Known, Run, Sort};
use saltus_robot::{Robot, RobotError};
pub use write::{write, write_from};

use error::{one_line, shown};
use lines::Hash;
use manifest::Manifest;
use run::Reading;

/// Most rows that are kept of all runs: 20 MB a column or so. Where there are more than 500 runs,
/// each keeps fewer.
const MOST_ROWS_OF_ALL: usize = 2_000_000;

/// Most notes that are kept of a folder: nobody reads more.
const MOST_NOTES: usize = 100;

/// What was read of a data folder, or of several.
#[derive(Clone, Debug, PartialEq)]
pub struct Folder {
    /// The runs.
    pub experiment: Experiment,
    /// The robot as the file names it: a built-in one's name, or a path that is relative to the
    /// folder.
    pub robot: Option<String>,
    /// What is known of parameters apart from the data.
    pub known: Vec<Known>,
    /// The folder; of several, the first.
    pub path: PathBuf,
    /// 64-bit hash of what `experiment.toml` and the rows say, in hexadecimal: which data these
    /// are, whatever the zero of their clock.
    pub hash: String,
    /// What was thinned or left out, or looks odd; each names a run, and a line where there is one.
    pub notes: Vec<String>,
    /// Rows that were read, kept or not.
    pub rows: usize,
    /// Each run by its contents.
    hashes: BTreeMap<Hash, String>,
}

impl Folder {
    /// Reads a data folder: [`read`] without progress.
    ///
    /// # Errors
    /// As [`read`].
    pub fn open(path: impl AsRef<Path>) -> Result<Folder, Error> {
        read(path.as_ref(), &|_| ())
    }

    /// The robot that was measured as [`saltus_robot::resolve`] takes it: a built-in one's name, or
    /// the path of a file beside the data.
    pub fn robot_name(&self) -> Option<String> {
        let name = self.robot.as_ref()?;
        if Robot::builtin_names().any(|known| known == name) {
            return Some(name.clone());
        }
        Some(self.path.join(name).display().to_string())
    }

    /// The robot that was measured; none where the kind is about none.
    ///
    /// # Errors
    /// [`RobotError`] where it cannot be read.
    pub fn robot(&self) -> Result<Option<Robot>, RobotError> {
        let name = self.robot_name();
        name.map(|name| saltus_robot::resolve(&name, &[]))
            .transpose()
    }
}

/// Reads a data folder.
///
/// Of a run at most 4000 rows are kept, every k-th of a longer one; [`Run::valve`] comes from all
/// of them. Times count from the first row, to the picosecond. Where a bench mostly rests before
/// and after its firing, that rest is thinned and the firing is kept whole; rest after the landing
/// of a hop or jump is left out. Rows outside the part that the operator calls valid are left out.
/// Memory does not grow with the length of the files.
///
/// `progress` is called now and then with the number of rows read since.
///
/// # Errors
/// [`Error`] where anything is not as it must be; its text names the file and the line.
pub fn read(folder: &Path, progress: &dyn Fn(usize)) -> Result<Folder, Error> {
    let bytes = manifest::bytes(folder)?;
    let other = misfit::other_kinds(&bytes, folder);
    match (as_it_says(folder, &bytes, progress), other) {
        (Ok(mut found), Some(other)) => {
            found.notes.push(other);
            Ok(found)
        }
        (Err(error), Some(other)) => Err(Error::Kind {
            error: Box::new(error),
            other,
        }),
        (found, None) => found,
    }
}

/// The folder as its file, of these bytes, says it is.
fn as_it_says(folder: &Path, bytes: &[u8], progress: &dyn Fn(usize)) -> Result<Folder, Error> {
    let manifest = manifest::parse(bytes, folder)?;
    present(folder, &manifest)?;
    let most = (MOST_ROWS_OF_ALL / manifest.runs.len()).min(manifest.spec.most_rows);
    let mut hashes = BTreeMap::new();
    let mut readings: Vec<Reading> = Vec::new();
    for listed in &manifest.runs {
        let reading = run::read(folder, listed, &manifest, most, progress)?;
        same_columns(folder, readings.first(), &reading)?;
        if let Some(other) = hashes.insert(reading.hash, listed.file.clone()) {
            let reason = format!("its contents are those of {}", one_line(&other));
            // Two runs without noise may read the same in counts, which tell it once.
            let has_steps = |column: &&'static str| manifest.resolution.contains_key(*column);
            if let Some(before) = readings.last_mut()
                && reading.columns.iter().all(has_steps)
            {
                let file = one_line(&listed.file);
                before
                    .notes
                    .push(format!("{file}: {reason}: it is left out"));
                continue;
            }
            return Err(Error::Duplicate {
                place: shown(&folder.join(&listed.file)),
                reason,
            });
        }
        readings.push(reading);
    }
    scaled(folder, &manifest, &readings)?;
    Ok(gathered(folder, manifest, readings, hashes))
}

/// The files of a data folder: `experiment.toml`, and the runs that it lists where it can be read.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let listed = manifest::bytes(folder).and_then(|bytes| manifest::parse(&bytes, folder));
    let (described, runs) = listed.map_or((None, Vec::new()), |m| (m.mechanism, m.runs));
    let names = [manifest::NAME.to_owned()]
        .into_iter()
        .chain(described.map(|own| own.file))
        .chain(runs.into_iter().map(|run| run.file));
    names.map(|name| folder.join(name)).collect()
}

/// Refuses a folder of which a file is missing, before any is read.
fn present(folder: &Path, manifest: &Manifest) -> Result<(), Error> {
    for listed in &manifest.runs {
        let path = folder.join(&listed.file);
        if !path.exists() {
            return Err(Error::content(
                shown(&path),
                format!("is listed in {} and is not there", manifest::NAME),
            ));
        }
    }
    Ok(())
}

fn same_columns(folder: &Path, first: Option<&Reading>, reading: &Reading) -> Result<(), Error> {
    let Some(first) = first.filter(|first| first.columns != reading.columns) else {
        return Ok(());
    };
    Err(Error::Differs {
        place: format!("{}:1", shown(&folder.join(&reading.run.name))),
        what: "columns",
        value: reading.columns.join(" "),
        other: first.columns.join(" "),
        of: one_line(&first.run.name),
    })
}

/// Refuses a channel that in no run gets as far as it must in the right unit.
fn scaled(folder: &Path, manifest: &Manifest, readings: &[Reading]) -> Result<(), Error> {
    for (i, column) in readings
        .first()
        .map(|first| &first.columns[..])
        .unwrap_or_default()
        .iter()
        .enumerate()
    {
        let largest = readings
            .iter()
            .map(|reading| reading.largest[i])
            .fold(0.0, f64::max);
        let scale = manifest
            .spec
            .channel(column)
            .map_or(0.0, |channel| channel.scale);
        if largest < scale {
            // Only a pressure has a scale.
            let symptom = format!(
                "never exceeds {largest} in any run: it must be in Pa, not kPa, bar or psi"
            );
            return Err(Error::signal(shown(folder), column, symptom));
        }
    }
    Ok(())
}

fn gathered(
    path: &Path,
    manifest: Manifest,
    mut readings: Vec<Reading>,
    hashes: BTreeMap<Hash, String>,
) -> Folder {
    let (columns, empty) = columns(&mut readings);
    let mut notes = odd(&manifest, &columns);
    notes.extend(empty);
    notes.extend(readings.iter().flat_map(|reading| reading.notes.clone()));
    notes.extend(shared(&readings));
    notes.extend(unlisted(path, &manifest));
    let more = notes.len().saturating_sub(MOST_NOTES);
    notes.truncate(MOST_NOTES);
    notes.extend((more > 0).then(|| format!("{}: {more} more notes of its runs", manifest::NAME)));
    let rows = readings.iter().map(|reading| reading.rows).sum();
    let parts: Vec<Hash> = readings.iter().map(|reading| reading.hash).collect();
    let runs = readings.into_iter().map(|reading| reading.run).collect();
    let of_each = |sizes: &BTreeMap<String, f64>| {
        columns
            .iter()
            .map(|name| sizes.get(name).copied())
            .collect()
    };
    let (noise, resolution) = (of_each(&manifest.noise), of_each(&manifest.resolution));
    let experiment = Experiment {
        kind: manifest.spec.sort,
        noise,
        resolution,
        columns,
        mechanism: manifest.mechanism.as_ref().map(|own| own.mechanism.clone()),
        runs,
    };
    let mut hash = Hash::default();
    hash.add(write::manifest(&experiment, manifest.robot.as_deref(), manifest.spec).as_bytes());
    if let Some(described) = &manifest.mechanism {
        hash.add(described.text.as_bytes());
    }
    for part in parts {
        hash.join(part);
    }
    Folder {
        experiment,
        // What `[rig]` describes is no robot.
        robot: manifest
            .robot
            .filter(|_| manifest.rig.is_empty() && manifest.mechanism.is_none()),
        known: manifest.known,
        path: path.into(),
        hash: hash.hex(),
        notes,
        rows,
        hashes,
    }
}

/// The columns of the runs without those that are empty in all of them, and notes of these.
fn columns(readings: &mut [Reading]) -> (Vec<String>, Vec<String>) {
    let names = readings
        .first()
        .map(|first| first.columns.clone())
        .unwrap_or_default();
    let is_filled = |i: &usize| readings.iter().any(|reading| reading.filled[*i] > 0);
    let (filled, empty): (Vec<usize>, Vec<usize>) = (0..names.len()).partition(is_filled);
    for reading in readings {
        let mut column = 0..;
        reading
            .run
            .values
            .retain(|_| column.next().is_some_and(|i| filled.contains(&i)));
    }
    let note = |i: usize| {
        format!(
            "{}: {} is empty in all runs and is not used",
            manifest::NAME,
            names[i]
        )
    };
    (
        filled.into_iter().map(|i| names[i].to_owned()).collect(),
        empty.into_iter().map(note).collect(),
    )
}

/// Notes that runs share: each once, of the first run that has it.
fn shared(readings: &[Reading]) -> Vec<String> {
    let mut about: Vec<(&str, String, usize)> = Vec::new();
    for reading in readings {
        for (what, text) in &reading.shared {
            match about.iter_mut().find(|(known, ..)| known == what) {
                Some((.., more)) => *more += 1,
                None => about.push((what, format!("{}: {text}", one_line(&reading.run.name)), 0)),
            }
        }
    }
    let note = |(_, text, more): (&str, String, usize)| match more {
        0 => text,
        1 => format!("{text}; 1 more run is treated alike"),
        _ => format!("{text}; {more} more runs are treated alike"),
    };
    about.into_iter().map(note).collect()
}

/// Notes of what `experiment.toml` says and nothing needs.
fn odd(manifest: &Manifest, columns: &[String]) -> Vec<String> {
    let file = manifest::NAME;
    let robot = manifest.robot.as_ref().filter(|_| !manifest.needs_robot);
    let mut notes: Vec<String> = robot
        .map(|_| {
            format!(
                "{file}: robot is not used for the kind {}",
                manifest.spec.id
            )
        })
        .into_iter()
        .collect();
    for (table, sizes) in [
        ("noise", &manifest.noise),
        ("resolution", &manifest.resolution),
    ] {
        let unused = sizes.keys().filter(|name| !columns.contains(name));
        notes.extend(
            unused
                .map(|name| format!("{file}: {table}.{name} is not used: no run has that column")),
        );
    }
    notes
}

/// Notes of CSV and MCAP files in the folder that are no runs.
fn unlisted(folder: &Path, manifest: &Manifest) -> Vec<String> {
    let listed: std::collections::BTreeSet<&str> =
        manifest.runs.iter().map(|run| run.file.as_str()).collect();
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter_map(|entry| entry.file_name().into_string().ok());
    let is_run = |name: &str| {
        let end = Path::new(name).extension();
        end.is_some_and(|end| end.eq_ignore_ascii_case("csv") || end.eq_ignore_ascii_case("mcap"))
    };
    let mut others: Vec<String> = names
        .filter(|name| is_run(name) && !listed.contains(name.as_str()))
        .map(|name| one_line(&name))
        .collect();
    others.sort();
    // A folder full of them is told by a few.
    let more = others.len().saturating_sub(3);
    others.truncate(3);
    let mut notes: Vec<String> = others
        .iter()
        .map(|name| format!("{name}: not read, as {} does not list it", manifest::NAME))
        .collect();
    if more > 0 {
        notes.push(format!(
            "{}: {more} more CSV or MCAP files are not listed",
            manifest::NAME
        ));
    }
    notes
}

/// Refuses data whose sizes are far from what `robot`, believed to be the one that was measured,
/// and the runs allow: another unit, or the sign turned round.
///
/// # Errors
/// [`Error::Signal`], with the unit that would explain the size.
pub fn plausible(folder: &Folder, robot: Option<&Robot>) -> Result<(), Error> {
    implausible(&folder.experiment, robot).map_or(Ok(()), |found| {
        Err(Error::signal(
            one_line(&found.run),
            &found.name,
            found.symptom,
        ))
    })
}
