//! `saltus run` with a robot in space.

use std::collections::BTreeMap;

use saltus::telemetry::{Event, Path, read};
use serde_json::Value;

use crate::common::{Folder, rows};

fn answer(folder: &Folder, line: &str, code: i32) -> Value {
    serde_json::from_str(&folder.done(&format!("{line} --format json"), code)).unwrap()
}

#[test]
fn the_thesis_disc_runs_straight_in_its_plane() {
    let folder = Folder::new("ball-disc");
    let all = answer(&folder, "run disc --robot rats-twelve --seconds 3", 0);
    assert_eq!(all["by_sensors"], false);
    assert!(all["travel_m"].as_f64().unwrap() > 3.0, "{all}");
    assert!(all["most_aside_m"].as_f64().unwrap() < 1e-3, "{all}");
    // Too weak a leg does not get it going.
    let weak = "run disc --robot rats-twelve --seconds 2 --set leg.force_n=60";
    let all = answer(&folder, weak, 1);
    assert!(all["travel_m"].as_f64().unwrap() < 0.7, "{all}");
    assert_eq!(all["ending"], "stands");
}

#[test]
fn rows_hold_unit_quaternions_and_what_the_sensors_make_of_them() {
    let folder = Folder::new("ball-rows");
    let (header, all) = rows(&folder.done(
        "run disc-stable --robot rats-twelve --seconds 1 --format csv",
        0,
    ));
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
    let line = "run disc-stable --robot rats-twelve --seconds 3 --robots 5 --seed 2";
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
    let line =
        "run disc-stable --robot rats-twelve --seconds 20 --set body.center_of_mass_mm=[20,20,20]";
    let all = answer(&folder, line, 1);
    let ending = all["ending"].as_str().unwrap();
    assert!(["fell", "stands"].contains(&ending), "{all}");
    let text = folder.done(line, 1);
    assert!(text.contains(ending) && text.contains(" s"), "{text}");
}

/// A square of 3 m, and back.
const SQUARE: &str = "x_m,y_m\n3,0\n3,3\n0,3\n0,0\n";

#[test]
fn a_ball_follows_a_path_and_ends_where_it_ends() {
    let folder = Folder::new("ball-path");
    folder.write("square.csv", SQUARE);
    let line = "run steer --robot rats-twelve --path square.csv --seconds 90";
    let all = answer(&folder, line, 0);
    assert_eq!(all["gait"], "steer");
    assert_eq!(all["ending"], "arrived");
    assert_eq!(all["points_reached"], 4);
    let time = all["time_s"].as_f64().unwrap();
    let place = |k: usize| all["place_m"][k].as_f64().unwrap();
    // It comes to within half a metre of the last point by its own reckoning, and it turns three times.
    assert!(place(0).hypot(place(1)) < 1.0, "{all}");
    assert!(time > 8.0 && time < 90.0 && all["way_m"].as_f64().unwrap() > 10.0);
    assert!(all["set_out"].as_u64().unwrap() > 1, "{all}");
    // Cut short, it says how far it came.
    let text = folder.done(
        "run steer --robot rats-twelve --path square.csv --seconds 2",
        1,
    );
    assert!(text.contains("of 4 points reached"), "{text}");
    let drawn = "run steer --robot rats-twelve --path square.csv --seconds 3 --robots 3";
    let one = folder.done(&format!("{drawn} --threads 1"), 0);
    assert_eq!(one, folder.done(&format!("{drawn} --threads 2"), 0));
    assert!(one.contains("came to its path's end   0 of 3"), "{one}");
}

#[test]
fn a_ball_that_is_thrown_down_runs_again() {
    let folder = Folder::new("ball-recover");
    let line = "run recover --robot rats-twelve --seconds 10";
    let mut places = Vec::new();
    for seed in 1..=2 {
        let all = answer(&folder, &format!("{line} --seed {seed}"), 0);
        assert!(all["rolled_a_turn_s"].as_f64().unwrap() > 0.5, "{all}");
        places.push(all["place_m"].clone());
    }
    // Each seed throws it otherwise.
    assert!(places[0] != places[1]);
    let text = folder.done("run recover --robot rats-twelve --seconds 0.3", 1);
    assert!(text.contains("does not run again in 0.3 s"), "{text}");
}

#[test]
fn a_plot_of_a_ball_shows_its_track() {
    let folder = Folder::new("ball-plot");
    folder.write("square.csv", SQUARE);
    for line in [
        "disc",
        "disc-stable --heading 20deg",
        "steer",
        "steer --path square.csv",
    ] {
        let line = format!("run {line} --robot rats-twelve --seconds 0.5 --plot track.svg");
        folder.run(&line.split(' ').collect::<Vec<_>>());
        let svg = folder.read("track.svg");
        assert!(svg.contains("From above") && !svg.contains("NaN"), "{line}");
        // A line of another heading begins where the robot has turned to it.
        let is_followed = line.contains("steer");
        assert_eq!(svg.contains("to follow"), is_followed, "{line}");
        std::fs::remove_file(folder.path("track.svg")).unwrap();
    }
}

/// Looking changes nothing, and the same command gives the same bytes.
#[test]
fn a_page_and_a_recording_change_no_number() {
    let folder = Folder::new("ball-beside");
    for line in [
        "run disc-stable --robot rats-twelve --seconds 2 --format csv",
        "run disc --robot rats-twelve --seconds 2 --format csv",
        "run disc-stable --robot rats-twelve --seconds 2 --step 0.5ms --format csv",
    ] {
        let alone = folder.done(line, 0);
        let files = || {
            let beside = format!("{line} --animate run.html --mcap run.mcap");
            assert!(folder.done(&beside, 0) == alone, "{line}");
            ["run.html", "run.mcap"].map(|name| std::fs::read(folder.path(name)).unwrap())
        };
        assert!(files() == files(), "{line}");
    }
}

/// The numbers to which each of `paths` leads in a recording.
pub(crate) fn recorded(bytes: &[u8], paths: &[String]) -> BTreeMap<String, Vec<f64>> {
    let all: Vec<(String, Path)> = paths
        .iter()
        .map(|path| (path.clone(), path.parse().unwrap()))
        .collect();
    let mut found: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let visit = &mut |event: Event<'_>| {
        if let Event::Message { channel, data, .. } = event {
            for (name, path) in all.iter().filter(|(_, path)| path.topic == channel.topic) {
                let mut out = [f64::NAN];
                channel
                    .layout()?
                    .select(&[&path.fields])?
                    .find(data, &mut out)?;
                found.entry(name.clone()).or_default().push(out[0]);
            }
        }
        Ok(())
    };
    read(bytes, visit).unwrap();
    found
}

#[test]
fn a_recording_has_the_numbers_of_the_rows() {
    let folder = Folder::new("ball-mcap");
    let line = "run disc-stable --robot rats-twelve --seconds 1.5 --format csv --mcap run.mcap";
    let (header, all) = rows(&folder.done(line, 0));
    let column = |name: &str| -> Vec<f64> {
        let at = header.iter().position(|column| column == name).unwrap();
        all.iter().map(|row| row[at].parse().unwrap()).collect()
    };
    let mut pairs = vec![("time_s".to_owned(), "/measured.time_s".to_owned())];
    let mut pair = |name: &str, path: &str| pairs.push((name.into(), path.into()));
    for (k, axis) in ["x", "y", "z"].iter().enumerate() {
        pair(
            &format!("estimated_{axis}_m"),
            &format!("/estimate.place_m[{k}]"),
        );
    }
    for (k, axis) in ["w", "x", "y", "z"].iter().enumerate() {
        pair(
            &format!("estimated_quaternion_{axis}"),
            &format!("/estimate.quaternion_wxyz[{k}]"),
        );
    }
    for name in [
        "lean_rad",
        "rate_rad_s",
        "roll_rad",
        "roll_rate_rad_s",
        "heading_rad",
    ] {
        pair(name, &format!("/disc.{name}"));
    }
    pair("stations_passed", "/disc.stations_passed");
    for leg in 0..12 {
        pair(
            &format!("extension_{leg}_m"),
            &format!("/leg.extension_m[{leg}]"),
        );
        pair(
            &format!("extension_{leg}_m"),
            &format!("/joint_states.position[leg_{leg}]"),
        );
    }
    let bytes = std::fs::read(folder.path("run.mcap")).unwrap();
    let paths: Vec<String> = pairs.iter().map(|(_, path)| path.clone()).collect();
    let found = recorded(&bytes, &paths);
    for (name, path) in &pairs {
        let (a, b) = (&found[path], column(name));
        assert_eq!(a.len(), b.len(), "{path}");
        let same = |(a, b): (&f64, &f64)| a.to_bits() == b.to_bits();
        assert!(a.iter().zip(&b).all(same), "{path}");
    }
    // Of the messages on /tf that of the robot comes first in each cycle, then that of its estimate.
    let transform = "/tf.transforms[0].transform";
    for (name, part) in [
        ("x_m", "translation.x"),
        ("y_m", "translation.y"),
        ("z_m", "translation.z"),
        ("quaternion_w", "rotation.w"),
        ("quaternion_x", "rotation.x"),
        ("quaternion_y", "rotation.y"),
        ("quaternion_z", "rotation.z"),
    ] {
        let path = format!("{transform}.{part}");
        let found = recorded(&bytes, std::slice::from_ref(&path));
        let (truth, estimate) = (column(name), column(&format!("estimated_{name}")));
        let pairs = found[&path].chunks_exact(2);
        assert_eq!(pairs.len(), truth.len());
        for (k, pair) in pairs.enumerate() {
            assert_eq!(pair, [truth[k], estimate[k]], "{name}");
        }
    }
    let feet: Vec<String> = (1..=12)
        .map(|leg| format!("/measured.contact_{leg}"))
        .collect();
    let feet = recorded(&bytes, &feet);
    let down = |k: usize| feet.values().map(|foot| foot[k]).sum::<f64>();
    assert!((0..all.len()).all(|k| down(k) == column("feet_on_ground")[k]));
}

#[test]
fn telemetry_of_a_ball_is_a_folder_with_readings() {
    let folder = Folder::new("ball-telemetry");
    let line = "run disc-stable --robot rats-twelve --heading 10deg --seconds 0.5 --seed 4 --format csv --mcap run.mcap";
    let alone = folder.done(line, 0);
    assert!(folder.done(&format!("{line} --telemetry logs"), 0) == alone);
    assert!(folder.read("logs/cycles.csv") == alone);
    let (header, all) = rows(&folder.read("logs/run.csv"));
    assert_eq!(header.len(), 1 + 6 + 12 + 12);
    let bytes = std::fs::read(folder.path("run.mcap")).unwrap();
    for (k, name) in header.iter().enumerate() {
        let path = format!("/measured.{name}");
        let found = &recorded(&bytes, std::slice::from_ref(&path))[&path];
        let wanted = all.iter().map(|row| row[k].parse::<f64>().unwrap());
        assert!(found.iter().copied().eq(wanted), "{name}");
    }
    // At rest it feels its weight, and in its first hop, from 0.1 s on, nothing: the fine accelerometer counts 0.6 mm/s².
    let feels = |row: usize| {
        let parts = (4..7).map(|k| all[row][k].parse::<f64>().unwrap().powi(2));
        parts.sum::<f64>().sqrt()
    };
    assert!((feels(0) - 9.80665).abs() < 0.01 && feels(200) < 0.01);
    let again = "run disc-stable --robot logs/robot.toml --heading 10deg --seconds 0.5 --seed 4 --format csv";
    assert!(folder.done(again, 0) == alone);
    let run = folder.run(&["diagnose", "logs"]);
    assert_eq!(run.code, Some(2), "{}", run.err);
    let run = folder.run(
        &"run disc-stable --robot rats-twelve --telemetry logs"
            .split(' ')
            .collect::<Vec<_>>(),
    );
    assert_eq!(run.code, Some(2));
    assert!(run.err.contains("a new or an empty folder"), "{}", run.err);
}

/// What the valves are commanded is what the rows say is fired.
#[test]
fn a_recording_has_the_valves() {
    let folder = Folder::new("ball-mcap-valves");
    let line = "run disc --robot rats-twelve --seconds 2 --format csv --mcap run.mcap";
    let (header, all) = rows(&folder.done(line, 0));
    let at = |name: &str| header.iter().position(|column| column == name).unwrap();
    let (fired, twin, open) = (at("fired_leg"), at("fired_twin"), at("valve_open_s"));
    let bytes = std::fs::read(folder.path("run.mcap")).unwrap();
    let mut paths: Vec<String> = (0..12)
        .map(|leg| format!("/leg.valve_open[{leg}]"))
        .collect();
    paths.push("/measured.rate_x_rad_s".into());
    let found = recorded(&bytes, &paths);
    let mut commanded = 0;
    for leg in 0..12 {
        let mut until = f64::NEG_INFINITY;
        for (k, row) in all.iter().enumerate() {
            let time: f64 = row[0].parse().unwrap();
            if [fired, twin].iter().any(|c| row[*c] == leg.to_string()) {
                until = until.max(time + row[open].parse::<f64>().unwrap());
                commanded += 1;
            }
            let is_open = found[&format!("/leg.valve_open[{leg}]")][k];
            assert_eq!(is_open == 1.0, time < until, "leg {leg} at {time} s");
        }
    }
    assert!(commanded > 0);
    // A robot that knows the truth has no use for sensors.
    assert!(found["/measured.rate_x_rad_s"].iter().all(|x| x.is_nan()));
}

/// Words after `saltus run`, and what the message must contain.
const CASES: &[(&str, &[&str])] = &[
    (
        "disc --robot rats-run",
        &["rats-run", "sphere for the gait disc"],
    ),
    (
        "fixed --heading 10deg",
        &["unexpected argument '--heading'"],
    ),
    ("fixed --truth", &["unexpected argument '--truth'"]),
    (
        "fixed --robot rats-twelve",
        &["rats-twelve", "wheel for the gait fixed"],
    ),
    (
        "disc --robot rats-twelve --heading 1",
        &["unexpected argument '--heading'"],
    ),
    (
        "disc-stable --robot rats-twelve --zone 0",
        &["unexpected argument '--zone'"],
    ),
    (
        "disc-stable --robot rats-twelve --heading nan",
        &["--heading", "an angle"],
    ),
    (
        "disc-stable --robot rats-twelve --heading 181deg",
        &["--heading", "181deg", "from -pi to pi rad"],
    ),
    (
        "steer --robot rats-boom --path p.csv",
        &["rats-boom", "sphere for the gait steer"],
    ),
    ("steer --robot rats-twelve --path no.csv", &["no.csv"]),
    (
        "disc --robot rats-twelve --path p.csv",
        &["unexpected argument '--path'"],
    ),
    (
        "steer --robot rats-twelve --path p.csv --heading 1",
        &["--path", "--heading"],
    ),
    (
        "steer --robot rats-twelve --zone 0",
        &["unexpected argument '--zone'"],
    ),
    (
        "disc-stable --robot rats-twelve --speed 0:1",
        &["unexpected argument '--speed'"],
    ),
    (
        "disc-stable --robot rats-twelve --disturb torque=5@1:2s",
        &["unexpected argument '--disturb'"],
    ),
    (
        "disc-stable --robot rats-twelve --bears 3",
        &["--bears", "--bin bears steer 40"],
    ),
    (
        "disc-stable --robot rats-twelve --animate x.txt",
        &["--animate", "the name must end in .html"],
    ),
    (
        "disc-stable --robot rats-twelve --animate x.html --seconds 61",
        &["--animate", "--seconds 60 at most, not 61"],
    ),
    (
        "disc-stable --robot rats-twelve --animate no/x.html",
        &["no/x.html: cannot be written"],
    ),
    (
        "disc-stable --robot rats-twelve --animate x.html --out x.html --format json",
        &["--animate", "another file than --out"],
    ),
    (
        "disc-stable --robot rats-twelve --animate x.html --robots 3",
        &["--animate", "--robots"],
    ),
    (
        "disc-stable --robot rats-twelve --mcap x.csv",
        &["--mcap", ".mcap"],
    ),
    (
        "disc-stable --robot rats-twelve --mcap no/x.mcap",
        &["no/x.mcap: cannot be written"],
    ),
    (
        "disc-stable --robot rats-twelve --mcap x.mcap --out x.mcap --format csv",
        &["--mcap", "another file than --out"],
    ),
    (
        "disc-stable --robot rats-twelve --mcap x.mcap --robots 3",
        &["--mcap", "--robots"],
    ),
    (
        "disc-stable --robot rats-twelve --mcap x.mcap --set legs.directions=[[1,0,0],[0,1,0],[0,0,1],[-1,0,0]]",
        &["legs.directions"],
    ),
    (
        "disc-stable --robot rats-twelve --telemetry x --believed rats-run",
        &["unexpected argument '--believed'"],
    ),
    (
        "disc-stable --robot rats-twelve --telemetry x --robots 3",
        &["--telemetry", "--robots"],
    ),
    (
        "disc --robot rats-twelve --telemetry x --valve-open 3",
        &["--valve-open", "from 0 to 1 s"],
    ),
    (
        "disc --robot rats-twelve --valve-open 3",
        &["--valve-open", "from 0 to 1 s"],
    ),
    (
        "disc --robot rats-twelve --from 0.9",
        &["--from, --to", "in the active zone"],
    ),
];

#[test]
fn what_a_ball_does_not_do_is_refused_by_name() {
    let folder = Folder::new("ball-refused");
    for (line, parts) in CASES {
        let given = if line.contains("--seconds") {
            ""
        } else {
            " --seconds 1"
        };
        let words = format!("run {line}{given}");
        let run = folder.run(&words.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        for part in *parts {
            assert!(run.err.contains(part), "{line}: {}", run.err);
        }
        assert!(run.out.is_empty(), "{line}");
    }
    assert!(std::fs::read_dir(folder.path("")).unwrap().next().is_none());
}
