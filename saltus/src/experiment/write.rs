//! An experiment as a data folder.

use std::fmt::Write as _;
use std::fs;
use std::io::{self, BufWriter, Write};
use std::path::Path;

use super::error::{Error, one_line, shown};
use super::manifest::{NAME, within};
use super::mcap;
use super::mechanism;
use super::{Experiment, Run};
use crate::origin::Origin;
use crate::temporary::{self, Temporary};
use saltus_diagnosis::spec::{self, Form, Setting, Spec};

/// Writes `experiment` into a folder that is new or empty, so that [`read`](super::read()) gives it
/// back; the times of a run then count from its first row.
///
/// All is written within the folder under a temporary name and then moved into its place,
/// `experiment.toml` last: where writing fails, the folder is as it was. Where the valve switches
/// between two rows, a row is put in that has the command alone.
///
/// # Errors
/// [`Error`] where the folder is not empty or cannot be written, or where the experiment has what
/// files cannot say: a run without a file name of its own, columns of unequal length, a number that
/// is not finite.
pub fn write(folder: &Path, experiment: &Experiment, robot: Option<&str>) -> Result<(), Error> {
    let origin = Origin {
        command: "",
        seed: None,
        robot: None,
    };
    write_from(folder, experiment, robot, &[], &origin)
}

/// As [`write()`], with `more` files that go with it, name and contents; a run whose file ends in
/// `.mcap` becomes an MCAP file, which says the `origin` of the data.
///
/// # Errors
/// As [`write()`]; a run of such a name without the feature `telemetry`.
pub fn write_from(
    folder: &Path,
    experiment: &Experiment,
    robot: Option<&str>,
    more: &[(&str, String)],
    origin: &Origin<'_>,
) -> Result<(), Error> {
    let spec = experiment.kind.spec();
    for run in &experiment.runs {
        writable(run, experiment, spec)
            .map_err(|reason| Error::content(one_line(&run.name), reason))?;
    }
    let is_new = !folder.exists();
    let written = fs::create_dir_all(folder)
        .map_err(|error| Error::write(folder, error))
        .and_then(|()| {
            temporary::sweep(folder);
            let mut entries = fs::read_dir(folder).map_err(|error| Error::write(folder, error))?;
            if entries.next().is_some() {
                return Err(Error::content(
                    shown(folder),
                    "is not empty: data go into a new or an empty folder",
                ));
            }
            let staged =
                Temporary::folder_in(folder).map_err(|error| Error::write(folder, error))?;
            let runs = experiment.runs.iter().map(|run| run.name.as_str());
            let described = experiment
                .mechanism
                .iter()
                .map(|machine| machine.name.as_str());
            let names: Vec<&str> = more
                .iter()
                .map(|(name, _)| *name)
                .chain(described)
                .chain(runs)
                .chain([NAME])
                .collect();
            fill(staged.path(), (experiment, robot), (more, origin), spec)
                .and_then(|()| publish(staged.path(), folder, &names))
        });
    if written.is_err() && is_new {
        // Only an empty folder goes.
        let _ = fs::remove_dir(folder);
    }
    written
}

/// Writes all files into `folder`.
fn fill(
    folder: &Path,
    (experiment, robot): (&Experiment, Option<&str>),
    (more, origin): (&[(&str, String)], &Origin<'_>),
    spec: &Spec,
) -> Result<(), Error> {
    for (name, text) in more {
        whole(&folder.join(name), |out| out.write_all(text.as_bytes()))?;
    }
    for run in &experiment.runs {
        let path = folder.join(&run.name);
        let is_mcap = path
            .extension()
            .is_some_and(|end| end.eq_ignore_ascii_case("mcap"));
        whole(&path, |out| {
            if is_mcap {
                let rows = cells(run, spec).map(|(time, values)| {
                    let time_of_row = spec.timed.then_some(time);
                    (time, time_of_row.into_iter().chain(values).collect())
                });
                mcap::write(out, &names(experiment, spec), rows, origin)
            } else {
                rows(out, run, experiment, spec)
            }
        })?;
    }
    if let Some(machine) = &experiment.mechanism {
        let text = mechanism::written(machine);
        whole(&folder.join(&machine.name), |out| {
            out.write_all(text.as_bytes())
        })?;
    }
    whole(&folder.join(NAME), |out| {
        out.write_all(manifest(experiment, robot, spec).as_bytes())
    })
}

/// Moves files of these names from one folder to another.
fn publish(from: &Path, to: &Path, names: &[&str]) -> Result<(), Error> {
    for name in names {
        let place = to.join(name);
        let parent = place.parent().unwrap_or(to);
        fs::create_dir_all(parent)
            .and_then(|()| fs::rename(from.join(name), &place))
            .map_err(|error| Error::write(&place, error))?;
    }
    Ok(())
}

/// Why a run cannot be written.
fn writable(run: &Run, experiment: &Experiment, spec: &Spec) -> Result<(), &'static str> {
    let finite = |numbers: &[f64]| numbers.iter().all(|number| number.is_finite());
    if within(&run.name).is_none_or(|path| path != run.name || path == NAME) {
        return Err("must be the name of a file within the folder");
    }
    if experiment
        .runs
        .iter()
        .filter(|other| other.name == run.name)
        .count()
        > 1
    {
        return Err("is the name of two runs");
    }
    if run.values.len() != experiment.columns.len()
        || run
            .values
            .iter()
            .any(|column| column.len() != run.time.len())
    {
        return Err("has columns of unequal length");
    }
    if !finite(&run.time) || run.values.iter().flatten().any(|value| value.is_infinite()) {
        return Err("has a number that is not finite");
    }
    if spec.valve && run.valve.is_none() {
        return Err("has no opening of the valve");
    }
    Ok(())
}

/// The text of `experiment.toml`.
pub(super) fn manifest(experiment: &Experiment, robot: Option<&str>, spec: &Spec) -> String {
    let quoted = |text: &str| toml::Value::String(text.into()).to_string();
    let mut text = format!("kind = {}\n", quoted(spec.id));
    // Writing into a string does not fail.
    let _ = robot.map(|robot| writeln!(text, "robot = {}", quoted(robot)));
    for (table, sizes) in [
        ("noise", &experiment.noise),
        ("resolution", &experiment.resolution),
    ] {
        let known = experiment
            .columns
            .iter()
            .zip(sizes)
            .filter_map(|(column, size)| Some((column, (*size)?)));
        for (i, (column, size)) in known.enumerate() {
            let head = if i == 0 {
                format!("\n[{table}]\n")
            } else {
                String::new()
            };
            let _ = writeln!(text, "{head}{column} = {size:?}");
        }
    }
    let is_of_rig = |key: &str| spec.rig.iter().any(|setting| setting.stands_under(key));
    let has_rig = |run: &&Run| run.settings.keys().any(|key| is_of_rig(key));
    if let Some(run) = experiment.runs.first().filter(has_rig) {
        text.push_str("\n[rig]\n");
        set(&mut text, run, is_of_rig, spec);
    }
    if let Some(machine) = &experiment.mechanism {
        let _ = writeln!(text, "\n[rig]\nchain = {}", quoted(&machine.name));
    }
    for run in &experiment.runs {
        let _ = writeln!(text, "\n[[run]]\nfile = {}", quoted(&run.name));
        set(&mut text, run, |key| !is_of_rig(key), spec);
    }
    text
}

/// Adds the settings of a run whose key `is_meant`.
fn set(text: &mut String, run: &Run, is_meant: impl Fn(&str) -> bool, spec: &Spec) {
    let mut lists: Vec<&str> = Vec::new();
    for (key, value) in run.settings.iter().filter(|(key, _)| is_meant(key)) {
        let mut known = spec.settings.iter().chain(spec.rig);
        let setting = known.find(|setting| setting.stands_under(key));
        let (key, value) = match setting {
            None => (key.as_str(), format!("{value:?}")),
            Some(one) if matches!(one.form, Form::One | Form::Word) => {
                (one.key, one.written(*value))
            }
            Some(list) if lists.contains(&list.key) => continue,
            Some(list) => {
                lists.push(list.key);
                (list.key, items(run, list))
            }
        };
        // Writing into a string does not fail.
        let _ = writeln!(text, "{key} = {value}");
    }
}

/// A list of numbers or names, as it stands in a file.
fn items(run: &Run, setting: &Setting) -> String {
    let list: Vec<toml::Value> = if setting.form == Form::Names {
        let names = spec::named(&run.settings, setting.key);
        names.into_iter().map(toml::Value::String).collect()
    } else {
        let numbers = spec::listed(&run.settings, setting.key);
        numbers.into_iter().map(toml::Value::Float).collect()
    };
    toml::Value::Array(list).to_string()
}

/// Header and rows of a run. Numbers have the digits that give them back.
fn rows(out: &mut dyn Write, run: &Run, experiment: &Experiment, spec: &Spec) -> io::Result<()> {
    writeln!(out, "{}", names(experiment, spec).join(","))?;
    for (time, values) in cells(run, spec) {
        let valve = spec.valve.then(|| format!("{}", values[0]));
        let measured = &values[usize::from(spec.valve)..];
        let cell = |value: &f64| {
            if value.is_nan() {
                String::new()
            } else {
                format!("{value:?}")
            }
        };
        let time = spec.timed.then(|| format!("{time:?}"));
        let all = time.into_iter().chain(valve);
        let all: Vec<String> = all.chain(measured.iter().map(cell)).collect();
        writeln!(out, "{}", all.join(","))?;
    }
    Ok(())
}

/// Names of the columns.
fn names<'e>(experiment: &'e Experiment, spec: &Spec) -> Vec<&'e str> {
    let mut names: Vec<&str> = Vec::new();
    names.extend(spec.timed.then_some("time_s"));
    names.extend(spec.valve.then_some("valve"));
    names.extend(experiment.columns.iter().map(String::as_str));
    names
}

/// Every row with its time (s): the valve, where there is one, and what was measured, NaN where
/// nothing was.
fn cells<'r>(run: &'r Run, spec: &Spec) -> impl Iterator<Item = (f64, Vec<f64>)> + use<'r> {
    let (open, closed) = run.valve.unwrap_or((f64::INFINITY, None));
    let closed = closed.unwrap_or(f64::INFINITY);
    let has_valve = spec.valve;
    instants(run, spec, [open, closed])
        .into_iter()
        .map(move |(time, row)| {
            let valve = f64::from(u8::from(time >= open && time < closed));
            let value = |column: &Vec<f64>| row.map_or(f64::NAN, |row| column[row]);
            let valve = has_valve.then_some(valve).into_iter();
            (time, valve.chain(run.values.iter().map(value)).collect())
        })
}

/// Times (s) of all rows in order, each with its row; those at which the valve switches are among
/// them.
fn instants(run: &Run, spec: &Spec, switches: [f64; 2]) -> Vec<(f64, Option<usize>)> {
    let mut instants: Vec<(f64, Option<usize>)> =
        run.time.iter().copied().zip((0..).map(Some)).collect();
    for switch in switches
        .into_iter()
        .filter(|switch| spec.valve && switch.is_finite())
    {
        let place = instants.partition_point(|(time, _)| *time < switch);
        if instants.get(place).is_none_or(|(time, _)| *time != switch) {
            instants.insert(place, (switch, None));
        }
    }
    instants
}

/// Writes the file at `path`, whose folder is made.
fn whole(path: &Path, fill: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), Error> {
    let write = || {
        if let Some(parent) = path.parent() {
            fs::create_dir_all(parent)?;
        }
        let mut out = BufWriter::new(fs::File::create(path)?);
        fill(&mut out).and_then(|()| out.flush())
    };
    write().map_err(|error| Error::write(path, error))
}
