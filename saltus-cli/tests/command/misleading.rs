//! Data that can be read but are not what they claim to be: no cause is named with confidence.

use std::process::Command;

use crate::common::Folder;
use serde_json::Value;

/// A run: names of the columns, and rows.
type Table = (Vec<String>, Vec<Vec<f64>>);

fn table(text: &str) -> Table {
    let mut lines = text.lines();
    let names = lines
        .next()
        .unwrap()
        .split(',')
        .map(str::to_owned)
        .collect();
    (
        names,
        lines
            .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
            .collect(),
    )
}

fn text((names, rows): &Table) -> String {
    let rows = rows
        .iter()
        .map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
    std::iter::once(names.join(","))
        .chain(rows)
        .collect::<Vec<_>>()
        .join("\n")
        + "\n"
}

/// Makes data of `kind` without an effect, spoils each run, and diagnoses them: only `unknown` may
/// be said.
#[track_caller]
fn check(name: &str, kind: &str, spoil: impl Fn(&mut Table)) {
    names_nothing(&spoiled(name, kind, spoil), name);
}

/// The same, where it shows before anything is fitted that the data cannot be meant so.
#[track_caller]
fn refused(name: &str, kind: &str, spoil: impl Fn(&mut Table)) {
    let run = spoiled(name, kind, spoil).run(&["diagnose", "data"]);
    assert!(
        run.code == Some(2) && run.err.ends_with("?\n"),
        "{name}: {}{}",
        run.out,
        run.err
    );
}

fn spoiled(name: &str, kind: &str, spoil: impl Fn(&mut Table)) -> Folder {
    let folder = Folder::new(&format!("misleading-{name}"));
    folder.done(&format!("inject --kind {kind} --out data"), 0);
    for file in folder
        .names_in("data")
        .iter()
        .filter(|file| file.starts_with("run"))
    {
        let mut run = table(&folder.read(&format!("data/{file}")));
        spoil(&mut run);
        folder.write(&format!("data/{file}"), text(&run));
    }
    folder
}

#[track_caller]
fn names_nothing(folder: &Folder, name: &str) {
    let run = folder.run(&["diagnose", "data", "--format", "json"]);
    assert!(
        run.code == Some(0) || run.code == Some(1),
        "{name}: {}",
        run.err
    );
    let said: Value = serde_json::from_str(&run.out).unwrap();
    let causes = said["causes"].as_array().unwrap();
    assert!(
        causes.iter().all(|cause| cause["id"] == "unknown"),
        "{name}: {causes:?}"
    );
}

fn column(run: &Table, name: &str) -> usize {
    run.0.iter().position(|column| column == name).unwrap()
}

fn change(name: &'static str, to: impl Fn(f64) -> f64) -> impl Fn(&mut Table) {
    move |run| {
        let k = column(run, name);
        run.1.iter_mut().for_each(|row| row[k] = to(row[k]));
    }
}

fn swap(a: &'static str, b: &'static str) -> impl Fn(&mut Table) {
    move |run| {
        let (a, b) = (column(run, a), column(run, b));
        run.1.iter_mut().for_each(|row| row.swap(a, b));
    }
}

/// The rows in another order, at the old times.
fn reorder(order: impl Fn(usize, usize) -> usize) -> impl Fn(&mut Table) {
    move |run| {
        let rows = run.1.clone();
        for (k, row) in run.1.iter_mut().enumerate() {
            row[1..].copy_from_slice(&rows[order(k, rows.len())][1..]);
        }
    }
}

/// Steps of 7 through a run whose length 7 does not divide reach every row.
fn shuffled(k: usize, n: usize) -> usize {
    let step = if n.is_multiple_of(7) { 11 } else { 7 };
    k * step % n
}

#[test]
fn firings_that_are_none_name_no_cause() {
    let bench = "bench --runs 4";
    check("inverted", bench, change("valve", |open| 1.0 - open));
    refused("backwards", bench, reorder(|k, n| n - 1 - k));
    refused("flipped", bench, change("position_m", |x| -x));
}

#[test]
fn flights_that_are_none_name_no_cause() {
    refused("millimetres", "flight", change("y_m", |y| 1000.0 * y));
    refused("upside-down", "flight", change("y_m", |y| -y));
    check("sideways", "flight", swap("x_m", "y_m"));
    check("shuffled", "flight", reorder(shuffled));
}

#[test]
#[ignore = "nightly: 6 s"]
fn parts_that_are_none_name_no_cause() {
    refused("kilonewtons", "stroke", change("force_n", |f| 1e-3 * f));
    refused("pulled", "stroke", change("force_n", |f| -f));
    check("against", "slide", change("force_n", |f| -f));
    check("mixed", "slide", reorder(shuffled));
    check("filling", "vessel", reorder(|k, n| n - 1 - k));
    check("scattered", "vessel", reorder(shuffled));
}

/// The runs of other settings under each run's name.
#[test]
fn runs_that_are_mixed_up_name_no_cause() {
    let folder = Folder::new("misleading-mixed-up");
    folder.done("inject --kind bench --runs 4 --out data", 0);
    let files: Vec<String> = folder
        .names_in("data")
        .into_iter()
        .filter(|name| name.starts_with("run"))
        .collect();
    let runs: Vec<String> = files
        .iter()
        .map(|file| folder.read(&format!("data/{file}")))
        .collect();
    for (k, file) in files.iter().enumerate() {
        folder.write(&format!("data/{file}"), &runs[(k + 1) % runs.len()]);
    }
    names_nothing(&folder, "mixed up");
}

#[test]
fn another_robot_is_refused_or_unknown() {
    let folder = Folder::new("misleading-robot");
    folder.done("inject --kind hop --runs 2 --out data", 0);
    let manifest = folder.read("data/experiment.toml");
    folder.write(
        "data/experiment.toml",
        manifest.replace("\"rats-boom\"", "\"rats-planar\""),
    );
    let run = folder.run(&["diagnose", "data"]);
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert!(
        run.err
            .contains("rats-planar has no boom, whose pivot_angle_rad the data have"),
        "{}",
        run.err
    );
}

/// One processor says what all say.
#[test]
#[cfg(target_os = "linux")]
fn the_answer_does_not_depend_on_the_number_of_threads() {
    let folder = Folder::new("misleading-threads");
    folder.done("inject coulomb-friction=25 --runs 3 --out data", 0);
    let words = ["diagnose", "data", "--format", "json", "--most", "1"];
    let alone = Command::new("taskset")
        .args(["-c", "0", env!("CARGO_BIN_EXE_saltus")])
        .args(words)
        .current_dir(folder.path("."))
        .output();
    // Where there is no taskset, or processor 0 is not ours, nothing can be compared.
    let Some(alone) = alone.ok().filter(|run| run.status.code() == Some(1)) else {
        return;
    };
    assert_eq!(
        String::from_utf8(alone.stdout).unwrap(),
        folder.run(&words).out
    );
}

/// Data of each kind as if they were of the next one, and of others with columns alike.
#[test]
fn a_kind_that_is_none_is_named_with_the_right_one() {
    let folder = Folder::new("misleading-kind");
    let kinds = [
        "bench", "hop", "jump", "flight", "outcomes", "stroke", "slide", "vessel", "pendulum",
        "tank-leg", "walk", "machine",
    ];
    for kind in kinds {
        folder.done(&format!("inject --kind {kind} --runs 2 --out {kind}"), 0);
    }
    let nexts = kinds.iter().zip(kinds.iter().cycle().skip(1));
    let alike = [
        ("jump", "hop"),
        ("stroke", "slide"),
        ("machine", "pendulum"),
        ("pendulum", "machine"),
    ];
    let pairs = nexts.map(|(kind, next)| (*kind, *next)).chain(alike);
    for (kind, said) in pairs {
        let path = format!("{kind}/experiment.toml");
        let manifest = folder.read(&path);
        folder.write(
            &path,
            manifest.replace(&format!("kind = \"{kind}\""), &format!("kind = \"{said}\"")),
        );
        let run = folder.run(&["diagnose", kind, "--most", "1"]);
        let all = format!("{} {}", run.err, run.out);
        let all = all.split_whitespace().collect::<Vec<_>>().join(" ");
        let words = format!("those of kind {kind}, and not of {said}: is kind right?");
        assert!(all.contains(&words), "{kind} as {said}: {all}");
        folder.write(&path, manifest);
    }
}

/// Of data of a kind, spoiled, what a diagnosis says, with the exit code and in one line.
fn said(name: &str, kind: &str, spoil: impl Fn(&mut Table)) -> (Option<i32>, String) {
    told(&spoiled(name, kind, spoil))
}

fn told(folder: &Folder) -> (Option<i32>, String) {
    let run = folder.run(&["diagnose", "data"]);
    let all = format!("{} {}", run.err, run.out);
    (
        run.code,
        all.split_whitespace().collect::<Vec<_>>().join(" "),
    )
}

/// A clock in other units makes a search long, and what it finds nonsense.
#[test]
fn a_clock_in_other_units_is_asked_about() {
    for (kind, factor, unit) in [
        ("flight", 1e3, "is it in ms?"),
        ("flight", 60.0, "is it in frames of a camera?"),
        ("slide", 1e3, "is it in ms?"),
        ("pendulum", 1e3, "is it in ms?"),
        ("machine", 1e3, "time_s in ms"),
        ("vessel", 1e3, "time_s in ms"),
        ("vessel", 1.0 / 60.0, "time_s in min"),
    ] {
        // Short enough that a run may last so long.
        let spoil = |run: &mut Table| {
            run.1.truncate(150);
            run.1.iter_mut().for_each(|row| row[0] *= factor);
        };
        let name = format!("clock-{kind}-{factor:.0}");
        let (code, text) = said(&name, &format!("{kind} --runs 2"), spoil);
        assert!(code == Some(2) && text.contains(unit), "{name}: {text}");
    }
    // The longest run of a part that is simulated.
    let late = |run: &mut Table| run.1.iter_mut().for_each(|row| row[0] *= 1e3);
    let (code, text) = said("clock-long", "pendulum --runs 2", late);
    assert!(code == Some(2) && text.contains("is it in ms?"), "{text}");
}

/// A reading far outside, at the same row of each run, is a slip of the instrument: no noise, nothing
/// unknown.
#[test]
fn outliers_are_named() {
    for (kind, column, off) in [("pendulum", "angle_rad", 0.5), ("flight", "y_m", 1.0)] {
        let spoil = |run: &mut Table| {
            let k = run.0.iter().position(|name| name == column).unwrap();
            run.1[30][k] += off;
        };
        let (code, text) = said(
            &format!("outlier-{kind}"),
            &format!("{kind} --runs 4"),
            spoil,
        );
        assert_eq!(code, Some(0), "{text}");
        let words = "but for 4 readings that are outliers. Outliers, which are alone and hardly count: \
            run-01.csv, row 31: ";
        assert!(text.contains(words), "{text}");
    }
}

/// What explains data as well is named, each sensor for itself, with what is known of it.
#[test]
fn a_mass_and_scales_of_sensors_are_named_together() {
    for (share, words) in [
        (
            "1.2",
            [
                "encoder-scale of force_n would explain the data as well, and is less likely by what \
                    is known: gain would be 1.2, 4 standard deviations from 1",
                "encoder-scale of position_m would explain the data as well, and is less likely",
            ],
        ),
        (
            "1.02",
            [
                "or else encoder-scale of force_n or encoder-scale of position_m",
                "It could as well be encoder-scale of force_n gain = 1.0",
            ],
        ),
    ] {
        let hidden = format!("slide mass={share} coulomb-friction=0.8 --runs 4 --seed 3");
        let (_, text) = said(&format!("scales-{share}"), &hidden, |_| ());
        assert!(text.contains("Found: "), "{text}");
        for words in words {
            assert!(text.contains(words), "{share}: {words}: {text}");
        }
    }
}

/// Whatever cause an estimate is of, one that equals a slip of unit is a step to take.
#[test]
fn a_wrong_unit_is_the_next_step() {
    for (kind, words) in [
        (
            "bench mass=load_factor:0.45359237 --runs 4",
            "load_factor of mass is 0.453",
        ),
        (
            "slide mass=0.224809 --runs 4",
            "gain of encoder-scale of force_n is 0.2248",
        ),
    ] {
        let (code, text) = said(&format!("unit-{}", &kind[..5]), kind, |_| ());
        let step = format!("Look for a wrong unit: {words}");
        assert!(code == Some(1) && text.contains(&step), "{text}");
        assert!(!text.contains("Nothing needs to be corrected"), "{text}");
    }
}

/// What is unknown is what is left without the term that describes it.
#[test]
fn an_unknown_effect_is_more_than_noise() {
    let folder = Folder::new("misleading-unknown");
    let hidden = "acceleration across the path, c v=0.1";
    let run = folder.run(&["inject", hidden, "--kind", "flight", "--out", "data"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    let run = folder.run(&["diagnose", "data", "--format", "json"]);
    let said: Value = serde_json::from_str(&run.out).unwrap();
    let unknown = &said["causes"].as_array().unwrap()[0];
    assert!(!unknown["term"].is_null(), "{unknown}");
    // The noise of both columns is 5 mm.
    assert!(unknown["rms"].as_f64().unwrap() > 0.01, "{unknown}");
}

#[test]
fn what_each_run_tells_for_itself_is_not_judged() {
    let (code, text) = said("own-vessel", "vessel --runs 3", |_| ());
    let words = "Estimated in each run, and so not judged: discharge_coefficient (";
    assert!(code == Some(0) && text.contains(words), "{text}");
}

/// Two runs that count the same tell it once; no robot has a term without a name.
#[test]
fn what_is_counted_twice_tells_it_once() {
    let folder = Folder::new("misleading-twice");
    folder.done("inject --kind hop --runs 3 --out data", 0);
    let manifest = folder.read("data/experiment.toml");
    let (_, first) = manifest.split_once("[[run]]").unwrap();
    let own = first.split("[[run]]").next().unwrap();
    let again = own.replace("run-01", "run-04");
    folder.write(
        "data/experiment.toml",
        format!("{manifest}\n[[run]]{again}"),
    );
    folder.write("data/run-04.csv", folder.read("data/run-01.csv"));
    let (_, text) = told(&folder);
    let words = "note: run-04.csv: its contents are those of run-01.csv: it is left out";
    assert!(text.contains(words) && text.contains("3 runs,"), "{text}");
    let hidden = "valve that opens over a time=0.03";
    let run = folder.run(&["inject", hidden, "--kind", "hop", "--out", "more"]);
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert!(run.err.contains("have no such effect"), "{}", run.err);
}
