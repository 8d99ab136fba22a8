//! `saltus run` with a robot in space.

use serde_json::Value;

use crate::common::{Folder, rows};

fn answer(folder: &Folder, line: &str, code: i32) -> Value {
    serde_json::from_str(&folder.done(&format!("{line} --format json"), code)).unwrap()
}

#[test]
fn the_thesis_disc_runs_straight_in_its_plane() {
    let folder = Folder::new("ball-disc");
    let all = answer(
        &folder,
        "run --robot rats-twelve --gait disc --seconds 3",
        0,
    );
    assert_eq!(all["by_sensors"], false);
    assert!(all["travel_m"].as_f64().unwrap() > 3.0, "{all}");
    assert!(all["most_aside_m"].as_f64().unwrap() < 1e-3, "{all}");
    // Too weak a leg does not get it going.
    let weak = "run --robot rats-twelve --gait disc --seconds 2 --set leg.force_n=60";
    let all = answer(&folder, weak, 0);
    assert!(all["travel_m"].as_f64().unwrap() < 0.7, "{all}");
}

#[test]
fn rows_hold_unit_quaternions_and_what_the_sensors_make_of_them() {
    let folder = Folder::new("ball-rows");
    let (header, all) = rows(&folder.done("run --robot rats-twelve --seconds 1 --format csv", 0));
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let (w, e) = (column("quaternion_w"), column("estimated_quaternion_w"));
    assert_eq!(all.len(), 1001);
    for row in &all {
        let number = |k: usize| row[k].parse::<f64>().unwrap();
        let dot = |a: usize, b: usize| (0..4).map(|k| number(a + k) * number(b + k)).sum::<f64>();
        assert!((dot(w, w) - 1.0).abs() < 1e-9 && (dot(e, e) - 1.0).abs() < 1e-9);
        // It knows its attitude to within 2°.
        assert!(
            dot(w, e).abs() > (0.5 * 2_f64.to_radians()).cos(),
            "{row:?}"
        );
    }
    let (fired, open) = (column("fired_leg"), column("valve_open_s"));
    assert!(
        all.iter()
            .all(|row| row[fired].is_empty() == row[open].is_empty())
    );
    assert!(all.iter().any(|row| !row[fired].is_empty()));
}

#[test]
fn drawn_balls_are_the_same_for_any_number_of_threads() {
    let folder = Folder::new("ball-robots");
    let line = "run --robot rats-twelve --seconds 3 --robots 5 --seed 2";
    for format in ["text", "json", "csv"] {
        let one = folder.done(&format!("{line} --format {format} --threads 1"), 0);
        let more = folder.done(&format!("{line} --format {format} --threads 3"), 0);
        assert_eq!(one, more, "{format}");
    }
    let all = answer(&folder, line, 0);
    assert_eq!(all["runs"].as_array().unwrap().len(), 5);
    assert_eq!(all["rolled_to_the_end"]["of"], 5);
}

#[test]
fn a_fall_is_an_answer() {
    let folder = Folder::new("ball-fall");
    // So far off its middle that no twins hold it.
    let line = "run --robot rats-twelve --seconds 20 --set body.center_of_mass_mm=[20,20,20]";
    let all = answer(&folder, line, 1);
    let ending = all["ending"].as_str().unwrap();
    assert!(["fell", "stands"].contains(&ending), "{all}");
    let text = folder.done(line, 1);
    assert!(text.contains(ending) && text.contains(" s"), "{text}");
}

/// Words after `saltus run`, and what the message must contain.
const CASES: &[(&str, &[&str])] = &[
    ("--gait disc", &["--gait disc", "a robot in space"]),
    ("--heading 10deg", &["--heading", "a robot in space"]),
    ("--truth", &["--truth", "a robot in space"]),
    (
        "--robot rats-twelve --gait fixed",
        &["--gait fixed", "disc or disc-stable"],
    ),
    (
        "--robot rats-twelve --gait disc --heading 1",
        &["--heading", "--gait disc-stable, not disc"],
    ),
    (
        "--robot rats-twelve --zone 0",
        &["--zone", "--gait disc, not disc-stable"],
    ),
    (
        "--robot rats-twelve --heading nan",
        &["--heading", "an angle"],
    ),
    (
        "--robot rats-twelve --speed 0:1",
        &["--speed", "a robot in its plane"],
    ),
    (
        "--robot rats-twelve --disturb torque=5@1:2s",
        &["--disturb", "a robot in its plane"],
    ),
    (
        "--robot rats-twelve --analyse",
        &["--analyse", "a robot in its plane"],
    ),
    (
        "--robot rats-twelve --animate x.html",
        &["--animate", "a robot in its plane"],
    ),
    (
        "--robot rats-twelve --mcap x.mcap",
        &["--mcap", "a robot in its plane"],
    ),
    (
        "--robot rats-twelve --telemetry x",
        &["--telemetry", "a robot in its plane"],
    ),
    (
        "--robot rats-twelve --gait disc --valve-open 3",
        &["--valve-open", "from 0 to 1 s"],
    ),
    (
        "--robot rats-twelve --gait disc --from 0.9",
        &["--from, --to", "in the active zone"],
    ),
];

#[test]
fn what_a_ball_does_not_do_is_refused_by_name() {
    let folder = Folder::new("ball-refused");
    for (line, parts) in CASES {
        let words = format!("run {line} --seconds 1");
        let run = folder.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        for part in *parts {
            assert!(run.err.contains(part), "{line}: {}", run.err);
        }
        assert!(run.out.is_empty(), "{line}");
    }
    assert!(std::fs::read_dir(folder.path("")).unwrap().next().is_none());
}
