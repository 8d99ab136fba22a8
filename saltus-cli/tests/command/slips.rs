//! Slips of unit in robots and flags, and what is found in data that equals one.

use crate::common::Folder;
use serde_json::Value;

const TABLE: [&str; 5] = ["table", "--omega", "5", "--distance", "0.6"];

#[test]
fn a_robot_that_looks_wrong_is_warned_of_once() {
    let folder = Folder::new("slips-robot");
    let check = |set: &str, words: &str| {
        let run = folder.run(&[&TABLE[..], &["--set", set]].concat());
        assert_ne!(run.code, Some(2), "{set}: {}", run.err);
        assert_eq!(
            run.err.matches("warning: ").count(),
            1,
            "{set}: {}",
            run.err
        );
        assert!(run.err.contains(words), "{set}: {}", run.err);
    };
    check(
        "leg.stroke_m=5",
        "leg.stroke_m = 5 is longer than the wheel is wide (0.48 m): is it in cm or mm?",
    );
    check(
        "body.inertia_kg_m2=13000",
        "body.inertia_kg_m2 = 13000 is more than that of all mass on the rim",
    );
    check(
        "leg.supply_pressure_gauge_psi=1e6",
        "leg.supply_pressure_gauge_pa",
    );
    // A command that takes the robot twice says it once.
    let run = folder.run(&[
        "verify",
        "--law=-0.06,0.2",
        "--omega",
        "5",
        "--distance",
        "0.6",
        "--samples",
        "0",
        "--set",
        "body.mass_kg=2000",
    ]);
    assert_eq!(run.err.matches("warning: ").count(), 1, "{}", run.err);
}

#[test]
fn robots_without_a_slip_are_not_warned_of() {
    let folder = Folder::new("slips-none");
    // A note speaks of what the planar model leaves out of the whole robots; rats-twelve has no table.
    let notes = [
        (
            "rats-boom",
            "leg.mass_kg (legs that move in the wheel), boom.length_m (the arc of the boom)",
        ),
        (
            "rats-run",
            "leg.mass_kg (legs that move in the wheel), foot.radius_m, ground.static_friction, \
             boom.length_m (the arc of the boom)",
        ),
    ];
    for name in saltus::Robot::builtin_names().filter(|name| *name != "rats-twelve") {
        let note = notes.iter().find(|(robot, _)| *robot == name);
        let note = note.map_or_else(String::new, |(_, keys)| {
            format!(
                "note: robot {name}: the planar model of this command leaves out {keys}; `saltus verify` \
                 simulates it\n"
            )
        });
        let said = folder.run(&[&TABLE[..], &["--robot", name]].concat()).err;
        assert_eq!(said, note, "{name}");
    }
}

#[test]
fn terms_that_the_planar_model_leaves_out_are_named() {
    let folder = Folder::new("slips-planar");
    let words = [
        &TABLE[..],
        &[
            "--robot",
            "rats-boom",
            "--set",
            "body.axle_friction_n_m=0.3",
        ],
    ]
    .concat();
    let run = folder.run(&words);
    assert_eq!(run.code, Some(0));
    assert!(
        run.err.contains("leaves out body.axle_friction_n_m"),
        "{}",
        run.err
    );
}

#[test]
fn a_wheel_has_so_many_legs() {
    let folder = Folder::new("slips-legs");
    let run = folder.run(&[&TABLE[..], &["--set", "body.legs=1000000000"]].concat());
    assert_eq!(run.code, Some(2));
    assert!(
        run.err
            .contains("body.legs = 1000000000: must be a whole number from 1 to 1000"),
        "{}",
        run.err
    );
}

#[test]
fn a_name_of_several_lines_is_one_title() {
    let folder = Folder::new("slips-name");
    let robot = saltus::Robot {
        name: "two\nlines\tand more".into(),
        ..saltus::Robot::rats_planar()
    };
    folder.write("r.toml", robot.to_toml());
    let json = folder.done(
        "table --omega 5 --distance 0.6 --robot r.toml --format json",
        0,
    );
    let json: Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["robot"], "two lines and more");
}

#[test]
fn flags_are_answered_in_plain_words() {
    let folder = Folder::new("slips-flags");
    let run = folder.run(&[&TABLE[..], &["--threads", "0"]].concat());
    assert!(
        run.err.contains("must be a whole number, 1 or more"),
        "{}",
        run.err
    );
    let run = folder.run(&["table", "--omega", "5", "--distance", "3yd"]);
    assert!(
        run.err.contains("one of the units m, mm, cm, in, ft"),
        "{}",
        run.err
    );
    // Rounded: 24 times 0.0254 is not quite 0.6096.
    let inches = folder.done("table --omega 5 --distance 24in", 0);
    assert_eq!(inches, folder.done("table --omega 5 --distance 0.6096", 0));
}

/// Hides `inject`, and checks that text, page and document say `words` of what is found.
#[track_caller]
fn told(test: &str, inject: &str, words: &str) {
    let folder = Folder::new(test);
    folder.done(&format!("inject {inject} --out d"), 0);
    let text = folder.done("diagnose d --most 1 --report page.html", 1);
    assert!(text.contains(words), "{text}");
    assert!(folder.read("page.html").contains(words));
    let json = folder.done("diagnose d --most 1 --format json", 1);
    let json: Value = serde_json::from_str(&json).unwrap();
    let cause = &json["causes"][0];
    let candidates = std::iter::once(cause).chain(cause["candidates"].as_array().unwrap());
    let slips: Vec<String> = candidates
        .flat_map(|c| c["slips"].as_object().unwrap().values())
        .map(Value::to_string)
        .collect();
    assert!(slips.iter().any(|slip| slip.contains(words)), "{slips:?}");
}

#[test]
fn an_atmosphere_is_named() {
    told(
        "slips-atmosphere",
        "supply-pressure=-101325 --runs 5",
        "is the pressure absolute instead of gauge?",
    );
}

#[test]
fn a_pound_is_named() {
    told(
        "slips-pound",
        "mass=load_factor:0.45359237 --runs 5",
        "that is lb for kg",
    );
}

#[test]
fn what_the_robot_has_is_not_hidden() {
    let folder = Folder::new("slips-inject");
    let words = [
        "inject",
        "chamber-leak=1e-7",
        "--set",
        "leg.leak_area_m2=1e-7",
        "--out",
        "d",
    ];
    let run = folder.run(&words);
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert!(run.err.contains("nothing is hidden"), "{}", run.err);
    assert!(folder.names().is_empty());
}
