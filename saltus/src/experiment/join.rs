//! Several folders as one experiment.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::error::{Error, shown};
use super::lines::Hash;
use super::{Experiment, Folder, read};

/// Reads several folders of one kind, with the same columns and the same robot, as one experiment;
/// each run's name then begins with its folder's.
///
/// `progress` is called now and then with the number of rows read since.
///
/// # Errors
/// As [`read`], and [`Error::Differs`] where the folders are not of one experiment.
pub fn read_all(folders: &[PathBuf], progress: &dyn Fn(usize)) -> Result<Folder, Error> {
    let [first, more @ ..] = folders else {
        return Err(Error::content("data", "no folder is given"));
    };
    once(folders)?;
    let mut joined = read(first, progress)?;
    if more.is_empty() {
        return Ok(joined);
    }
    let names = names(folders);
    prefix(&mut joined, &names[0]);
    let mut hash = Hash::default();
    hash.add(joined.hash.as_bytes());
    for (path, name) in more.iter().zip(&names[1..]) {
        let mut folder = read(path, progress)?;
        prefix(&mut folder, name);
        hash.add(folder.hash.as_bytes());
        append(&mut joined, folder)?;
    }
    joined.hash = hash.hex();
    Ok(joined)
}

/// Refuses a folder that is given twice.
fn once(folders: &[PathBuf]) -> Result<(), Error> {
    let mut seen = BTreeSet::new();
    let again = folders
        .iter()
        .find(|path| !seen.insert(path.canonicalize().unwrap_or_else(|_| (*path).clone())));
    again.map_or(Ok(()), |path| {
        Err(Error::Duplicate {
            place: shown(path),
            reason: "the folder is given twice".into(),
        })
    })
}

/// What runs of each folder are called by: its last name, or all of it where that is not its own.
fn names(folders: &[PathBuf]) -> Vec<String> {
    let last = |path: &Path| {
        let whole = path.canonicalize().unwrap_or_else(|_| path.into());
        whole
            .file_name()
            .map_or_else(|| shown(path), |name| shown(name.as_ref()))
    };
    let short: Vec<String> = folders.iter().map(|path| last(path)).collect();
    let distinct = short.iter().collect::<BTreeSet<_>>().len() == short.len();
    if distinct {
        short
    } else {
        folders.iter().map(|path| shown(path)).collect()
    }
}

fn prefix(folder: &mut Folder, name: &str) {
    for run in &mut folder.experiment.runs {
        run.name = format!("{name}/{}", run.name);
    }
    for run in folder.hashes.values_mut() {
        *run = format!("{name}/{run}");
    }
    for note in &mut folder.notes {
        *note = format!("{name}/{note}");
    }
}

fn append(joined: &mut Folder, folder: Folder) -> Result<(), Error> {
    alike(joined, &folder)?;
    distinct(&mut joined.hashes, &folder)?;
    let columns = joined.experiment.columns.clone();
    let (to, from) = (&mut joined.experiment, folder.experiment);
    for (what, to, from) in [
        ("noise", &mut to.noise, from.noise),
        ("resolution", &mut to.resolution, from.resolution),
    ] {
        for ((column, to), from) in columns.iter().zip(to).zip(from) {
            if *to != from {
                // A fit that trusts a column too little loses less than one that trusts it too
                // much.
                *to = to.iter().copied().chain(from).reduce(f64::max);
                let size = to.unwrap_or(f64::NAN);
                let place = shown(&folder.path);
                joined.notes.push(format!(
                    "{place}: its {what} of {column} is another: {size} is taken for all"
                ));
            }
        }
    }
    to.runs.extend(from.runs);
    let place = shown(&folder.path);
    for known in folder.known {
        match joined.known.iter().find(|own| own.name == known.name) {
            None => joined.known.push(known),
            Some(own) if *own == known => {}
            Some(own) => joined.notes.push(format!(
                "{place}: what it knows of {} is another: {} ± {} is taken for all",
                own.name, own.value, own.error
            )),
        }
    }
    joined.notes.extend(folder.notes);
    joined.rows += folder.rows;
    Ok(())
}

/// Refuses a folder of another experiment.
fn alike(joined: &Folder, folder: &Folder) -> Result<(), Error> {
    let id = |experiment: &Experiment| experiment.kind.spec().id.to_owned();
    let robot = |folder: &Folder| folder.robot.clone().unwrap_or_else(|| "none".into());
    let columns = |folder: &Folder| folder.experiment.columns.join(" ");
    let chain = |folder: &Folder| {
        let machine = folder.experiment.mechanism.as_ref();
        machine.map_or_else(|| "none".into(), |own| own.name.clone())
    };
    let (a, b) = (joined, folder);
    let differing = [
        (
            "kind",
            id(&b.experiment),
            id(&a.experiment),
            a.experiment.kind != b.experiment.kind,
        ),
        ("robot", robot(b), robot(a), robot_file(a) != robot_file(b)),
        (
            "chain",
            chain(b),
            chain(a),
            a.experiment.mechanism != b.experiment.mechanism,
        ),
        (
            "columns",
            columns(b),
            columns(a),
            a.experiment.columns != b.experiment.columns,
        ),
    ];
    let first = differing.into_iter().find(|(.., differs)| *differs);
    first.map_or(Ok(()), |(what, value, other, _)| {
        Err(Error::Differs {
            place: shown(&b.path),
            what,
            value,
            other,
            of: shown(&a.path),
        })
    })
}

/// What a folder's robot means: a file seen from the folder, or a name.
fn robot_file(folder: &Folder) -> Option<PathBuf> {
    let robot = folder.robot.as_ref()?;
    Some(
        folder
            .path
            .join(robot)
            .canonicalize()
            .unwrap_or_else(|_| robot.into()),
    )
}

/// Refuses runs that are there already.
fn distinct(hashes: &mut BTreeMap<Hash, String>, folder: &Folder) -> Result<(), Error> {
    for (hash, name) in &folder.hashes {
        if let Some(other) = hashes.insert(*hash, name.clone()) {
            let reason = format!("{name} has the same contents as {other}");
            return Err(Error::Duplicate {
                place: shown(&folder.path),
                reason,
            });
        }
    }
    Ok(())
}
