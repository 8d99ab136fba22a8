//! A constant in a log's clock changes nothing: the same bytes are answered.

use std::fmt::Write as _;

use crate::common::Folder;

/// Offsets (ps): trimmed logs, triggers, minutes, Unix time.
const OFFSETS: [i128; 6] = [
    -1_000_000_000_000_000,
    -50_000_000_000,
    200_000_000_000,
    5_000_000_000_000,
    1_000_000_000_000_000,
    1_700_000_000_000_000_000_000,
];

/// A decimal number of seconds as picoseconds.
fn picoseconds(text: &str) -> i128 {
    let (sign, size) = text.strip_prefix('-').map_or((1, text), |size| (-1, size));
    let (whole, part) = size.split_once('.').unwrap_or((size, ""));
    sign * format!("{whole}{part:0<12}").parse::<i128>().unwrap()
}

fn seconds(picoseconds: i128) -> String {
    let sign = if picoseconds < 0 { "-" } else { "" };
    let size = picoseconds.abs();
    format!(
        "{sign}{}.{:012}",
        size / 1_000_000_000_000,
        size % 1_000_000_000_000
    )
}

/// The run with `offset` added to each time.
fn moved(run: &str, offset: i128) -> String {
    let (header, rows) = run.split_once('\n').unwrap();
    let mut text = format!("{header}\n");
    for row in rows.lines() {
        let (time, rest) = row.split_once(',').unwrap();
        writeln!(text, "{},{rest}", seconds(picoseconds(time) + offset)).unwrap();
    }
    text
}

/// Copies `data` to `moved`, each run on a clock of its own, the first `offset` away; times of
/// `experiment.toml` with it.
fn copy(folder: &Folder, offset: i128) {
    let _ = std::fs::remove_dir_all(folder.path("moved"));
    std::fs::create_dir(folder.path("moved")).unwrap();
    let mut k = 0;
    let mut by = || {
        k += 1;
        offset * k
    };
    for name in folder
        .names_in("data")
        .into_iter()
        .filter(|name| name != "experiment.toml")
    {
        let text = folder.read(&format!("data/{name}"));
        let text = if name.starts_with("run") {
            moved(&text, by())
        } else {
            text
        };
        folder.write(&format!("moved/{name}"), text);
    }
    k = 0;
    let mut by = 0;
    let mut toml = String::new();
    for line in folder.read("data/experiment.toml").lines() {
        if line == "[[run]]" {
            k += 1;
            by = offset * k;
        }
        match line.split_once(" = ") {
            Some((key @ ("valid_from_s" | "valid_to_s" | "release_s"), time)) => {
                writeln!(toml, "{key} = {}", seconds(picoseconds(time) + by)).unwrap();
            }
            _ => writeln!(toml, "{line}").unwrap(),
        }
    }
    folder.write("moved/experiment.toml", toml);
}

/// What `command` says of `data` and of the same on other clocks, so many of them.
#[track_caller]
fn check(folder: &Folder, command: &[&str], clocks: usize) {
    let said = |name: &str| {
        let run = folder.run(&[&[command[0], name], &command[1..]].concat());
        assert!(
            run.code == Some(0) || run.code == Some(1),
            "{command:?}: {}",
            run.err
        );
        // The folder's own name is in the commands of the next steps.
        (
            run.code,
            run.out.replace(
                &format!("saltus diagnose {name} "),
                "saltus diagnose FOLDER ",
            ),
        )
    };
    let expected = said("data");
    for offset in OFFSETS.into_iter().rev().take(clocks) {
        copy(folder, offset);
        assert_eq!(
            said("moved"),
            expected,
            "{command:?} with {} s more",
            seconds(offset)
        );
    }
}

/// What is read of data of `kind`, with `more` of its last run, is the same for every clock; and so
/// is the answer, for so many clocks.
#[track_caller]
fn kind(kind: &str, effect: &str, more: &str, clocks: usize) {
    let folder = Folder::new(&format!("clock-{kind}-{}", more.len()));
    folder.done(
        &format!("inject {effect} --kind {kind} --runs 2 --out data"),
        0,
    );
    let toml = folder.read("data/experiment.toml");
    folder.write("data/experiment.toml", toml + more);
    let read = |name: &str| {
        let data = saltus::experiment::read(&folder.path(name), &|_| ()).unwrap();
        (data.experiment, data.hash, data.notes)
    };
    let expected = read("data");
    for offset in OFFSETS {
        copy(&folder, offset);
        assert_eq!(
            read("moved"),
            expected,
            "{kind} with {} s more",
            seconds(offset)
        );
    }
    check(
        &folder,
        &["diagnose", "--most", "1", "--format", "json"],
        clocks,
    );
}

#[test]
fn of_the_bench() {
    let folder = Folder::new("clock-bench");
    folder.done("inject viscous-friction=25 --runs 2 --out data", 0);
    check(&folder, &["diagnose", "--most", "1", "--format", "json"], 6);
    check(&folder, &["diagnose", "--most", "1"], 1);
    check(
        &folder,
        &[
            "fit",
            "--parameters",
            "leg.viscous_friction_n_s_per_m,leg.valve_delay_s",
        ],
        2,
    );
    let late = "valid_from_s = 0.03\nvalid_to_s = 0.12\n";
    kind("bench", "viscous-friction=25", late, 1);
}

#[test]
#[ignore = "nightly: 18 s"]
fn of_hops_and_jumps() {
    kind("hop", "coulomb-friction=25", "", 1);
    kind(
        "jump",
        "mass=9",
        "valid_from_s = 0.004\nvalid_to_s = 0.3\n",
        1,
    );
}

#[test]
fn of_parts() {
    kind("flight", "air-drag=0.05", "valid_from_s = 0.02\n", 6);
    kind("stroke", "seal-friction=1e-5", "", 2);
    kind("slide", "coulomb-friction=0.5", "", 2);
    kind("vessel", "heat-transfer=0.13", "", 6);
    kind("vessel", "heat-transfer=0.13", "release_s = 0.0\n", 1);
}

/// What the friction of the leg is found to be in `data`, and its standard error.
#[track_caller]
fn friction(folder: &Folder, data: &str) -> [f64; 2] {
    let run = folder.run(&["diagnose", data, "--most", "1", "--format", "json"]);
    let said: serde_json::Value = serde_json::from_str(&run.out).unwrap();
    let cause = &said["causes"][0];
    assert_eq!(
        (cause["id"].as_str(), run.code),
        (Some("viscous-friction"), Some(1)),
        "{}",
        run.err
    );
    ["parameters", "standard_errors"].map(|key| {
        cause[key]["leg.viscous_friction_n_s_per_m"]
            .as_f64()
            .unwrap()
    })
}

/// A valve that opens before the first valid row has opened all the same, and rest does not blur
/// what is found.
#[test]
fn a_firing_is_found_wherever_the_log_begins_and_ends() {
    let folder = Folder::new("clock-rest");
    folder.done("inject viscous-friction=25 --runs 2 --out data", 0);
    let [expected, error] = friction(&folder, "data");
    let toml = folder.read("data/experiment.toml");
    folder.write(
        "data/experiment.toml",
        toml.replace("load_mass", "valid_from_s = 0.03\nload_mass"),
    );
    let [found, _] = friction(&folder, "data");
    assert!((found - expected).abs() < 2.0 * error, "{found}");

    folder.write("data/experiment.toml", toml);
    let chance = |k: u32| (f64::from(k) * 12.9898).sin();
    for name in ["data/run-01.csv", "data/run-02.csv"] {
        let text = folder.read(name);
        let (header, rows) = text.split_once('\n').unwrap();
        let last: Vec<f64> = rows
            .lines()
            .last()
            .unwrap()
            .split(',')
            .map(|cell| cell.parse().unwrap())
            .collect();
        // The noise of the last row is not that of the rest.
        let level = rows
            .lines()
            .rev()
            .take(20)
            .map(|row| row.rsplit(',').next().unwrap().parse::<f64>().unwrap())
            .sum::<f64>()
            / 20.0;
        let mut long = format!("{header}\n");
        for k in 0..5000 {
            writeln!(
                long,
                "{:.3},0,{:.6},{:.1}",
                f64::from(k) * 1e-3 - 5.0,
                1e-4 * chance(k),
                101_325.0 + 2e3 * chance(k + 1)
            )
            .unwrap();
        }
        long.push_str(rows);
        for k in 1..=20_000 {
            let (x, p) = (0.06 + 1e-4 * chance(k), level + 2e3 * chance(k + 1));
            writeln!(long, "{:.3},1,{x:.6},{p:.1}", last[0] + f64::from(k) * 1e-3).unwrap();
        }
        folder.write(name, long);
    }
    let read = saltus::experiment::read(&folder.path("data"), &|_| ()).unwrap();
    // The firing is whole, and there is hardly more.
    let steps = |time: &[f64]| {
        time.windows(2)
            .filter(|pair| pair[1] - pair[0] < 1.5e-3)
            .count()
    };
    assert!(
        read.experiment
            .runs
            .iter()
            .all(|run| steps(&run.time) > 60 && run.time.len() < 250)
    );
    assert_eq!(read.notes.len(), 1, "{:?}", read.notes);
    let [found, with_rest] = friction(&folder, "data");
    assert!(
        (found - expected).abs() < 2.0 * error && with_rest < 1.1 * error,
        "{found} ± {with_rest}, {error}"
    );
}
