//! Synthetic data: what is hidden is found, and `fit` gives it back; what cannot be hidden is
//! refused.

use crate::common::{Folder, rows};
use serde_json::Value;

/// Ids that a diagnosis of `data` names, each with its rivals.
fn found(folder: &Folder, data: &str, code: i32) -> Vec<Vec<String>> {
    let json: Value =
        serde_json::from_str(&folder.done(&format!("diagnose {data} --format json"), code))
            .unwrap();
    let word = |value: &Value| value.as_str().unwrap().to_owned();
    let ids = |cause: &Value| {
        let rivals = cause["rivals"].as_array().unwrap().iter().map(word);
        std::iter::once(word(&cause["id"])).chain(rivals).collect()
    };
    json["causes"].as_array().unwrap().iter().map(ids).collect()
}

/// Hides `inject`, whose cause is `id`, and looks for it.
#[track_caller]
fn check(test: &str, inject: &str, id: &str) {
    let folder = Folder::new(test);
    let told = folder.done(&format!("inject {inject} --out data"), 0);
    assert!(told.contains(&format!("Hidden: {id}")), "{told}");
    let causes = found(&folder, "data --most 1", 1);
    assert_eq!(causes.len(), 1, "{causes:?}");
    assert!(causes[0].iter().any(|found| found == id), "{causes:?}");
    // The truth is not among the data.
    for name in folder.names_in("data") {
        assert!(!folder.read(&format!("data/{name}")).contains(id), "{name}");
    }
}

/// Without a boom nothing measures a run's height: the refusal says so, and which robots to take.
#[test]
fn a_run_of_a_robot_without_a_boom_is_refused() {
    let folder = Folder::new("inject-no-boom");
    let before = folder.names();
    for robot in ["rats-planar", "spring-hopper"] {
        let line = format!("inject --kind run --robot {robot} --out data");
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{robot}");
        let why = "which only the pivot of a boom measures, and";
        assert!(
            run.err.contains(why) && run.err.contains(robot),
            "{}",
            run.err
        );
        assert!(
            run.err.contains("take a robot with one, as rats-run"),
            "{}",
            run.err
        );
        assert_eq!(folder.names(), before);
    }
}

#[test]
fn friction_on_the_bench_is_found() {
    check(
        "inject-bench",
        "coulomb-friction=25 --runs 5",
        "coulomb-friction",
    );
}

#[test]
fn drag_of_a_flight_is_found() {
    check("inject-flight", "air-drag=0.05 --kind flight", "air-drag");
}

#[test]
fn a_heavy_wheel_is_found_in_jumps() {
    check("inject-jump", "mass=3.4 --kind jump --runs 2", "mass");
}

/// Robots that carry their gas, or feed their legs through tubes.
#[test]
#[ignore = "nightly: 6 s"]
fn what_feeds_a_leg_is_found() {
    let folder = Folder::new("inject-fed");
    let tank = "--robot rats-boom --set tank.volume_l=0.3";
    let tube = "--robot rats-boom --set leg.tube.length_m=0.5 --set leg.tube.diameter_mm=4";
    for (robot, kind, hidden) in [
        (tank, "hop", "tank=8e-5"),
        (tube, "bench", "tube=1.2,0.004"),
    ] {
        let id = hidden.split('=').next().unwrap();
        let line = format!("inject {hidden} --kind {kind} {robot} --runs 4 --out {id}");
        folder.done(&line, 0);
        let causes = found(&folder, &format!("{id} {robot} --most 1"), 1);
        assert_eq!(causes.len(), 1, "{causes:?}");
        assert!(causes[0].iter().any(|found| found == id), "{causes:?}");
    }
}

/// What a muscle has in series is looked for where there is a muscle.
#[test]
fn a_tendon_is_a_cause_of_muscles_alone() {
    let folder = Folder::new("inject-tendon");
    let page = include_str!("../../../robots/README.md");
    let mut examples = page
        .split("```toml\n")
        .filter_map(|rest| rest.split("```").next());
    let muscle = examples.find(|text| text.contains("kind = \"muscle\""));
    folder.write("muscle.toml", muscle.unwrap());
    let hide = |robot: &str| {
        let line = format!("inject series-spring=2000 --robot {robot} --runs 1 --out data");
        folder.run(&line.split(' ').collect::<Vec<_>>()).code
    };
    assert_eq!(hide("rats-boom"), Some(2));
    assert_eq!(hide("muscle.toml"), Some(0));
}

/// Its strides empty one tank, and are fitted one by one.
#[test]
fn a_run_of_a_robot_with_a_tank_is_refused() {
    let folder = Folder::new("inject-tank-run");
    folder.done("run smooth --seconds 3 --telemetry logs", 0);
    let said = folder.run(&["diagnose", "logs", "--set", "tank.volume_l=0.3"]);
    assert_eq!(said.code, Some(2), "{}{}", said.out, said.err);
    assert!(said.err.contains("tank.volume"), "{}", said.err);
}

/// What is without a limit unless it is hidden can be hidden alone.
#[test]
fn slip_on_smooth_ground_is_hidden() {
    let folder = Folder::new("inject-slip");
    let line = "inject foot-slip=0.45 --kind outcomes --robot rats-planar --runs 3 --out d";
    let told = folder.done(line, 0);
    assert!(told.contains("static_friction = 0.45"), "{told}");
}

#[test]
fn nothing_is_found_where_nothing_is_hidden() {
    let folder = Folder::new("inject-none");
    for kind in [
        "bench --runs 4",
        "flight",
        "slide",
        "stroke",
        "vessel",
        "outcomes --runs 20",
    ] {
        let name = kind.split(' ').next().unwrap();
        let told = folder.done(&format!("inject --kind {kind} --out {name}"), 0);
        assert!(told.contains("Nothing is hidden"), "{told}");
        assert_eq!(found(&folder, name, 0), Vec::<Vec<String>>::new(), "{kind}");
    }
}

#[test]
fn the_same_seed_makes_the_same_data() {
    let folder = Folder::new("inject-seed");
    let make = |out: &str, seed: u32| {
        folder.done(
            &format!("inject --kind hop --runs 1 --seed {seed} --out {out}"),
            0,
        );
        folder.read(&format!("{out}/run-01.csv"))
    };
    assert_eq!(make("a", 3), make("b", 3));
    assert_ne!(make("c", 4), folder.read("a/run-01.csv"));
}

/// A robot with overrides goes with the data, and the operator goes on to believe in it.
#[test]
fn a_robot_of_its_own_goes_with_the_data() {
    let folder = Folder::new("inject-robot");
    folder.done(
        "inject dead-volume=0.00001 --set leg.stroke_m=0.05 --runs 2 --out data",
        0,
    );
    assert!(
        folder
            .read("data/experiment.toml")
            .contains("robot = \"robot.toml\"")
    );
    let robot = folder.read("data/robot.toml");
    assert!(
        robot.contains("stroke_m = 0.05") && robot.contains("5.4e-6"),
        "{robot}"
    );
}

#[test]
fn the_truth_has_three_formats() {
    let folder = Folder::new("inject-formats");
    let line = "inject sensor-offset=position_m:0.002 \
        exhaust-port=0.03,0.00002 --runs 2";
    let json: Value =
        serde_json::from_str(&folder.done(&format!("{line} --out a --format json"), 0)).unwrap();
    assert_eq!(json["causes"][0]["column"], "position_m");
    assert_eq!(
        json["causes"][1]["parameters"]["leg.exhaust_port.area_m2"],
        2e-5
    );
    let (header, lines) = rows(&folder.done(&format!("{line} --out b --format csv"), 0));
    assert_eq!(header, ["cause", "column", "parameter", "value"]);
    assert_eq!(
        lines[0],
        ["sensor-offset", "position_m", "offset_m", "0.002"]
    );
    assert_eq!(lines.len(), 3);
}

#[test]
fn what_cannot_be_hidden_is_refused() {
    let folder = Folder::new("inject-bad");
    let cases: &[(&str, &[&str])] = &[
        ("mass=1.1", &["--out <FOLDER>"]),
        (
            "gremlins=1 --out a",
            &[
                "gremlins=1",
                "kind bench",
                "coulomb-friction=leg.coulomb_friction_n",
                "9.7003",
            ],
        ),
        ("foot-slip=0.5 --out a", &["foot-slip", "kind bench"]),
        ("air-drag --out a", &["air-drag", "CAUSE=VALUE"]),
        ("coulomb-friction=much --out a", &["CAUSE=VALUE"]),
        (
            "coulomb-friction=-5 --out a",
            &["leg.coulomb_friction_n from 0 to 1000", "-5"],
        ),
        ("coulomb-friction=1,2 --out a", &["at most 1"]),
        ("exhaust-port=0.03 --out a", &["leg.exhaust_port.area_m2"]),
        (
            "encoder-scale=1.1 --out a",
            &["encoder-scale=position_m:gain"],
        ),
        (
            "encoder-scale=y_m:1.1 --out a",
            &["encoder-scale=position_m:gain"],
        ),
        ("none --out a", &["none", "CAUSE=VALUE"]),
        ("mass=1.1 mass=1.2 --out a", &["twice"]),
        ("--kind toss --out a", &["invalid value 'toss'", "vessel"]),
        ("--runs 0 --out a", &["--runs"]),
        (
            "valve-discharge=0.02 --kind jump --runs 1 --out a",
            &["the robot makes 0 of 1 motions"],
        ),
        ("", &["--out <FOLDER>"]),
    ];
    for (line, words) in cases {
        let line = format!("inject {line}");
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        for word in *words {
            assert!(run.err.contains(word), "{line}: {}", run.err);
        }
        assert_eq!(folder.names(), Vec::<String>::new(), "{line}");
    }
}

#[test]
fn a_fit_gives_back_what_was_hidden() {
    let folder = Folder::new("fit");
    folder.done(
        "inject valve-discharge=0.45 coulomb-friction=15 --runs 5 --out data",
        0,
    );
    let text = folder.done("fit data --robot-out fitted.toml", 0);
    assert!(
        text.contains("leg.discharge_coefficient") && text.contains("pressure_pa"),
        "{text}"
    );
    let json: Value = serde_json::from_str(&folder.done("fit data --format json", 0)).unwrap();
    let of = |i: usize, key: &str| json["parameters"][i][key].as_f64().unwrap();
    assert!((of(0, "value") - 0.45).abs() < 3.0 * of(0, "standard_error"));
    assert!((of(3, "value") - 15.0).abs() < 3.0 * of(3, "standard_error"));
    let robot = folder.read("fitted.toml");
    assert!(
        robot.starts_with("# Fitted by `saltus fit` to data, data ") && !robot.contains("/tmp"),
        "{robot}"
    );
    // The fitted robot explains the data.
    assert_eq!(
        folder
            .run(&["diagnose", "data", "--robot", "fitted.toml"])
            .code,
        Some(0)
    );
    let both = "fit data --parameters leg.discharge_coefficient,leg.orifice_radius_m";
    let text = folder.done(both, 1);
    let words = "only leg.discharge_coefficient · leg.orifice_radius_m² is determined";
    assert!(text.contains(words), "{text}");
    let (_, lines) = rows(&folder.done(&format!("{both} --format csv"), 1));
    assert_eq!((lines.len(), lines[0][3].as_str()), (3, ""));
}

#[test]
fn a_fit_of_other_data_is_refused() {
    let folder = Folder::new("fit-bad");
    folder.done("inject --kind flight --out flight", 0);
    folder.done("inject --runs 2 --out bench", 0);
    let cases: &[(&str, &[&str])] = &[
        ("", &["<FOLDER"]),
        ("nowhere", &["nowhere"]),
        ("flight --robot rats-planar", &["flight", "kind bench"]),
        (
            "bench --parameters leg.bore_m",
            &["leg.bore_m", "leg.orifice_radius_m"],
        ),
        (
            "bench --parameters leg.dead_volume_m3,leg.dead_volume_m3",
            &["each once"],
        ),
        ("bench --robot spring-hopper", &["not pneumatic"]),
        ("bench --out a --robot-out a", &["--robot-out"]),
    ];
    for (line, words) in cases {
        let line = format!("fit {line}");
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        for word in *words {
            assert!(run.err.contains(word), "{line}: {}", run.err);
        }
    }
    assert_eq!(folder.names(), ["bench", "flight"]);
}

/// Injects data without an effect, of which nothing is found wrong.
#[track_caller]
fn is_well(folder: &Folder, kind: &str, robot: &str, runs: usize) {
    let data = format!("{kind}-{}", robot.replace([' ', '=', '.'], "-"));
    folder.done(
        &format!("inject --kind {kind} --robot {robot} --runs {runs} --out {data}"),
        0,
    );
    let told = folder.run(&["diagnose", &data, "--most", "1"]);
    assert_eq!(told.code, Some(0), "{data}: {}{}", told.out, told.err);
}

/// Of robots without a boom the axle's place is measured, and the supply is the robot's own.
#[test]
fn robots_without_a_boom_hop_and_jump() {
    let folder = Folder::new("inject-free");
    is_well(
        &folder,
        "hop",
        "rats-planar --set leg.supply_pressure_gauge_psi=60",
        3,
    );
    is_well(&folder, "jump", "table-hopper", 2);
    let data = folder
        .names()
        .into_iter()
        .find(|name| name.starts_with("hop"))
        .unwrap();
    let header = folder.read(&format!("{data}/run-01.csv"));
    assert_eq!(header.lines().next(), Some("time_s,valve,y_m"));
    let manifest = folder.read(&format!("{data}/experiment.toml"));
    let supplies = manifest
        .lines()
        .filter_map(|line| line.strip_prefix("supply_pressure_gauge_pa = "));
    for supply in supplies {
        let psi = supply.parse::<f64>().unwrap() / 6_894.757;
        assert!((39.9..60.1).contains(&psi), "{psi}");
    }
}

#[test]
#[ignore = "nightly: 20 s"]
fn nothing_is_wrong_with_data_of_any_robot() {
    let folder = Folder::new("inject-any");
    let robots = [
        "rats-boom",
        "rats-planar",
        "rats-run",
        "spring-hopper",
        "table-hopper",
    ];
    let own = [
        "rats-planar --set tank.volume_l=0.3",
        "rats-planar --set foot.radius_mm=10",
        "rats-boom --set ground.slope_deg=3",
    ];
    for robot in robots.iter().chain(&own) {
        for (kind, runs) in [("hop", 4), ("jump", 4), ("outcomes", 20)] {
            is_well(&folder, kind, robot, runs);
        }
        if !robot.contains("hopper") {
            is_well(&folder, "bench", robot, 4);
        }
    }
}
