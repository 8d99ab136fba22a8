//! Telemetry of a run, and what `saltus diagnose` says of it: kind run.

use serde_json::Value;

use crate::common::{Folder, rows};

/// A run from rest, of which the first strides are jumps.
const RUN: &str = "run smooth --seconds 3 --telemetry logs --format json";

/// What is said of `logs`, in which something is wrong or nothing.
fn diagnosis(folder: &Folder, is_wrong: bool) -> Value {
    let code = i32::from(is_wrong);
    serde_json::from_str(&folder.done("diagnose logs --format json", code)).unwrap()
}

#[test]
#[ignore = "nightly: 6 s"]
fn nothing_is_wrong_with_the_robot_that_ran() {
    let folder = Folder::new("strides-none");
    folder.done(RUN, 0);
    let said = folder.run(&["diagnose", "logs"]);
    assert_eq!(said.code, Some(0), "{}{}", said.out, said.err);
    let text = said.out + &said.err;
    for words in ["strides of", "firings are used", "firings left out"] {
        assert!(text.contains(words), "{words}: {text}");
    }
    let causes = diagnosis(&folder, false)["causes"].clone();
    assert_eq!(causes, Value::Array(Vec::new()));
}

/// The robot that ran has a heavier wheel than the one that the folder names.
#[test]
#[ignore = "nightly: 7 s"]
fn a_robot_that_is_not_the_believed_one_is_found_out() {
    let folder = Folder::new("strides-mass");
    folder.done(
        &format!("{RUN} --set body.inertia_kg_m2=0.1 --believed rats-run"),
        0,
    );
    let said = diagnosis(&folder, true);
    let causes = said["causes"].as_array().unwrap();
    let named = |id: &str| {
        causes.iter().any(|cause| {
            let rivals = cause["rivals"].as_array().unwrap();
            cause["id"] == id || rivals.iter().any(|rival| rival == id)
        })
    };
    assert!(named("inertia"), "{said}");
}

/// Changes `logs/run.csv`.
fn spoil(folder: &Folder, change: impl Fn(&mut Vec<String>, &mut Vec<Vec<String>>)) {
    let text = std::fs::read_to_string(folder.path("logs/run.csv")).unwrap();
    let (mut header, mut cells) = rows(&text);
    change(&mut header, &mut cells);
    let lines = std::iter::once(&header).chain(&cells);
    let lines: Vec<String> = lines.map(|cells| cells.join(",")).collect();
    folder.write("logs/run.csv", &(lines.join("\n") + "\n"));
}

/// What spoils header and cells of a log.
type Change = dyn Fn(&mut Vec<String>, &mut Vec<Vec<String>>);

#[test]
fn what_is_no_run_is_named() {
    let check = |name: &str, change: &Change, words: &[&str]| {
        let folder = Folder::new(&format!("strides-{name}"));
        folder.done("run smooth --seconds 1.7 --telemetry logs --format json", 0);
        spoil(&folder, change);
        let run = folder.run(&["diagnose", "logs"]);
        assert_eq!(run.code, Some(2), "{name}: {}", run.out);
        for word in words {
            assert!(run.err.contains(word), "{name}: {}", run.err);
        }
    };
    check(
        "missing",
        &|header, cells| {
            header.remove(5);
            for row in cells {
                row.remove(5);
            }
        },
        &["rats-run has 5 legs", "valve_5 is missing"],
    );
    check(
        "many",
        &|header, cells| {
            header.push("valve_6".into());
            for row in cells {
                row.push("0".into());
            }
        },
        &["rats-run has 5 legs", "valve_6 is one too many"],
    );
    check(
        "never",
        &|_, cells| {
            for row in cells {
                row[1..6].fill("0".into());
            }
        },
        &[
            "run.csv: valve_1 to valve_5 never turn from 0 to 1",
            "no leg is fired",
        ],
    );
    check(
        "half",
        &|_, cells| cells[300][2] = "0.5".into(),
        &["valve_2 is 0.5 at 0.", "must be 0 or 1"],
    );
    check(
        "wraps",
        &|_, cells| {
            for row in cells {
                if let Ok(angle) = row[6].parse::<f64>() {
                    row[6] = angle.rem_euclid(0.7 * std::f64::consts::TAU).to_string();
                }
            }
        },
        &[
            "wheel_angle_rad jumps from 4.",
            "must count on through every turn",
        ],
    );
    check(
        "few",
        &|_, cells| cells.truncate(1550),
        &["firings can be read as jumps: must be 4 at least; left out are"],
    );
    check(
        "height",
        &|header, _| header[8] = "pivot".into(),
        &["pivot"],
    );
}

#[test]
#[ignore = "nightly: 22 s"]
fn synthetic_runs_have_the_effect_that_is_asked_for() {
    let folder = Folder::new("strides-inject");
    let text = folder.done(
        "inject encoder-scale=wheel_rate_rad_s:1.1 --kind run --out logs",
        0,
    );
    assert!(
        text.contains("Hidden: encoder-scale of wheel_rate_rad_s"),
        "{text}"
    );
    let said = diagnosis(&folder, true);
    let causes = said["causes"].as_array().unwrap();
    assert!(
        causes.iter().any(|cause| cause["id"] == "encoder-scale"),
        "{said}"
    );
}

#[test]
fn another_robot_is_believed_only_with_as_many_legs() {
    let folder = Folder::new("strides-believed");
    let run = folder.run(
        &"run fixed --seconds 0.1 --telemetry logs --believed spring-hopper"
            .split(' ')
            .collect::<Vec<_>>(),
    );
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert!(run.err.contains("--believed spring-hopper"), "{}", run.err);
    assert!(!folder.path("logs").exists());
}
