//! Answers that hold on another robot: `--plant`.

use serde_json::Value;

use crate::common::{Folder, rows};

/// A low box on the way of one jump.
const COURSE: &str = "approach_rate_rad_s = 5.5
goal_from_x_m = 0.7
goal_to_x_m = 1.0
friction_coefficient = 0.8
clearance_m = 0.01
[[obstacle]]
front_x_m = 0.33
width_m = 0.21
height_m = 0.15
";

#[track_caller]
fn refused(folder: &Folder, line: &str, parts: &[&str]) {
    let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(2), "{line}: {} {}", run.out, run.err);
    for part in parts {
        assert!(run.err.contains(part), "{line}: {part:?} in {}", run.err);
    }
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Every angle of the table lands within its bound on the plant, flown by another command.
#[test]
fn a_table_holds_on_its_plant_and_only_there() {
    let folder = Folder::new("plant-table");
    folder.done(
        "table --omega 3.5:6:6 --distance 0.6 --plant rats-boom --out table.csv",
        0,
    );
    let report = folder.done(
        "verify table.csv --plant rats-boom --samples 0 --tolerance 1mm --format json",
        0,
    );
    let group = &json(&report)["groups"][0];
    assert!(group["miss_greatest_m"].as_f64().unwrap() < 3e-4, "{group}");
    refused(
        &folder,
        "verify table.csv",
        &["table.csv:2", "rats-boom", "rats-planar", "--plant"],
    );
    refused(
        &folder,
        "verify table.csv --plant rats-boom --plant-set boom.mass_kg=0.6",
        &["made to hold on the robot rats-boom", "--plant-set"],
    );
}

/// A plant that is the robot changes nothing, bit for bit.
#[test]
fn on_itself_a_table_is_as_without() {
    let folder = Folder::new("plant-itself");
    let line = "table --omega 4:6:3 --distance 0.6,0.7 --firing-angles=-0.4:0.4 --format csv";
    let (header, plain) = rows(&folder.done(line, 0));
    let (there, on_plant) = rows(&folder.done(&format!("{line} --plant rats-planar"), 0));
    assert_eq!(there[header.len()..], ["plant", "plant_sha256"]);
    let angle = header.iter().position(|h| h == "alpha_f_rad").unwrap();
    for (a, b) in plain.iter().zip(&on_plant) {
        assert_eq!(a[angle], b[angle]);
    }
}

#[test]
fn a_plan_holds_on_its_plant() {
    let folder = Folder::new("plant-plan");
    folder.write("course.toml", COURSE);
    let plan = json(&folder.done("plan course.toml --plant rats-boom --format json", 0));
    assert_eq!(plan["status"], "holds-on-the-plant");
    assert_eq!(plan["plant"], "rats-boom");
    let jumps = plan["correction"]["simulated_jumps"].as_u64().unwrap();
    assert!((2..=12).contains(&jumps), "{plan}");
    // The planar plan does not hold there; the corrected one does, on any ground that it allows.
    let verify = "verify course.toml --plant rats-boom --samples 0 --friction 0.5:1:3";
    let planar = folder.done(verify, 1);
    assert!(planar.contains("--correct"), "{planar}");
    let corrected = folder.done(&format!("{verify} --correct --tolerance 1mm"), 0);
    assert!(corrected.contains("3 of 3 jumps pass"), "{corrected}");
    let picture = "plan course.toml --plant rats-boom --plot plan.svg";
    assert!(folder.done(picture, 0).contains("holds on rats-boom"));
}

/// With margins from the scatter of the simulation it holds as often as asked, on draws that the
/// margins do not come from; without them it does not.
#[test]
#[ignore = "nightly: 14 s"]
fn a_plan_holds_for_a_share_of_drawn_jumps() {
    let folder = Folder::new("plant-share");
    folder.write("course.toml", COURSE);
    let line = "plan course.toml --plant rats-boom --share 0.9 --samples 100 --format json";
    let plan = json(&folder.done(line, 0));
    let hold = &plan["hold"];
    assert!(hold["share"].as_f64().unwrap() >= 0.84, "{hold}");
    assert_eq!(hold["is_enough"], true);
    let margin = hold["clearance_margin_m"].as_f64().unwrap();
    assert!((1e-3..0.03).contains(&margin), "{hold}");
    // Another command draws errors of its own around such a plan, and around one without margins.
    let verify = "verify course.toml --plant rats-boom --correct --seed 7";
    assert!(folder.done(verify, 1).contains("clearance: with errors"));
    folder.done(&format!("{verify} --share 0.9"), 0);
}

/// On slippery ground the plan of most clearance slips; where that is forbidden, no foot of drawn
/// jumps needs more friction than there is, and the plan differs.
#[test]
#[ignore = "nightly: 14 s"]
fn slip_is_forbidden_where_it_is_asked() {
    let folder = Folder::new("plant-no-slip");
    let limited = |friction: &str| COURSE.replace("coefficient = 0.8", friction);
    folder.write("course.toml", COURSE);
    folder.write("grippy.toml", limited("coefficient = 0.43"));
    folder.write("smooth.toml", limited("coefficient = 0.1"));
    let line =
        "plan course.toml --plant rats-boom --share 0.8 --samples 40 --friction 0.43 --format json";
    let may = json(&folder.done(line, 0));
    let must_not = json(&folder.done(&line.replace("course", "grippy"), 0));
    let needed = |plan: &Value| {
        let checks = plan["checks"].as_array().unwrap();
        let of = checks
            .iter()
            .find(|c| c["what"] == "friction needed")
            .unwrap();
        (
            of["value"].as_f64().unwrap(),
            of["greatest"].as_f64().unwrap(),
        )
    };
    assert!(needed(&may).0 > needed(&must_not).0, "{may}");
    let (needed, allowed) = needed(&must_not);
    assert!(needed <= allowed + 1e-5 && allowed <= 0.43, "{must_not}");
    // Less than any stance needs.
    let text = folder.done(
        "plan smooth.toml --plant rats-boom --share 0.8 --samples 40",
        1,
    );
    assert!(text.contains("infeasible on rats-boom"), "{text}");
}

/// A box that leaves no room for margins: the best there is, and what blocks more.
#[test]
#[ignore = "nightly: 14 s"]
fn a_share_that_cannot_be_had_is_said() {
    let folder = Folder::new("plant-no-share");
    folder.write(
        "high.toml",
        COURSE.replace("height_m = 0.15", "height_m = 0.188"),
    );
    let line = "plan high.toml --plant rats-boom --share 0.99 --samples 60";
    let text = folder.done(line, 1);
    for words in [
        "best that was found",
        "99 % asked for",
        "missed most often: clearance",
        "lower",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    refused(
        &folder,
        "plan high.toml --share 1.1",
        &["--share", "0 to 1"],
    );
    refused(&folder, "plan high.toml --samples 50", &["--share"]);
}

#[test]
fn laws_and_maps_are_of_the_plant() {
    let folder = Folder::new("plant-law");
    let law = "law --omega 4:6:5 --distance 0.7 --format json";
    let here = json(&folder.done(law, 0));
    let there = json(&folder.done(&format!("{law} --plant rats-boom"), 0));
    let slope = |law: &Value| law["laws"][0]["slope_s"].as_f64().unwrap();
    assert!((slope(&here) - slope(&there)).abs() > 1e-3);
    assert!(there["correction"]["miss_greatest_m"].as_f64().unwrap() < 1e-3);
    let map = "map --omega 5 --alpha-f 0:0.7:2 --plant rats-boom --format csv";
    let (header, spots) = rows(&folder.done(map, 0));
    let column = |name: &str| header.iter().position(|h| h == name).unwrap();
    let distance: f64 = spots[0][column("distance_m")].parse().unwrap();
    // 6 cm less than the planar model's.
    assert!((0.75..0.85).contains(&distance), "{distance}");
    // The next leg would stand in the ground.
    assert_eq!(spots[1][column("outcome")], "not-computed");
}

/// On one ground the plan is made for it: there it lands where it says, though its foot slips.
#[test]
#[ignore = "nightly: 14 s"]
fn a_plan_is_for_the_ground_that_is_given() {
    let folder = Folder::new("plant-ground");
    folder.write(
        "course.toml",
        COURSE.replace("friction_coefficient", "# friction_coefficient"),
    );
    let flags = "--plant rats-boom --share 0.8 --samples 40 --friction 0.35";
    let plan = json(&folder.done(&format!("plan course.toml {flags} --format json"), 0));
    let lands = &plan["hold"]["landings"][0];
    let planned = plan["jumps"][0]["land_x_m"].as_f64().unwrap();
    assert_eq!(lands["friction"], 0.35);
    assert!(
        (lands["land_x_m"].as_f64().unwrap() - planned).abs() < 1e-5,
        "{plan}"
    );
    assert!(
        plan["jumps"][0]["friction_needed"].as_f64().unwrap() < 0.36,
        "{plan}"
    );
    folder.done(
        &format!("verify course.toml --correct {flags} --tolerance 20mm"),
        0,
    );
}

/// A limit of friction that the plan just meets is met, whatever its last digit.
#[test]
fn a_limit_of_friction_is_no_matter_of_rounding() {
    let folder = Folder::new("plant-friction");
    for friction in [0.41, 0.43, 0.46] {
        let limited = COURSE.lines().filter(|line| !line.starts_with("friction"));
        let text: Vec<&str> = limited.collect();
        let text = format!("friction_coefficient = {friction}\n{}", text.join("\n"));
        folder.write("course.toml", text);
        let said = folder.done("plan course.toml --plant rats-boom", 0);
        assert!(said.contains("holds on rats-boom"), "{friction}: {said}");
    }
}

#[test]
fn a_plant_that_cannot_jump_is_said_to() {
    let folder = Folder::new("plant-weak");
    folder.write("course.toml", COURSE);
    let weak = "--plant rats-boom --plant-set leg.coulomb_friction_n=500";
    refused(
        &folder,
        &format!("plan course.toml {weak}"),
        &["jump 1", "rats-boom does not fly"],
    );
    let law = folder.done(&format!("law --omega 3:6:4 --distance 0.6 {weak}"), 1);
    assert!(law.contains("does not take off"), "{law}");
}

#[test]
fn a_plant_that_answers_cannot_hold_on_is_refused() {
    let folder = Folder::new("plant-refused");
    folder.write("course.toml", COURSE);
    refused(
        &folder,
        "plan course.toml --plant rats-boom --plant-set body.wheel_radius_m=0.25",
        &["rats-boom", "body.wheel_radius_m = 0.25", "0.24"],
    );
    refused(
        &folder,
        "table --omega 5 --distance 0.5 --plant spring-hopper --plant-set body.wheel_radius_m=0.24",
        &["leg.kind", "valve"],
    );
    refused(
        &folder,
        "verify course.toml --plant rats-boom --plant-set body.wheel_radius_m=0.25",
        &["rats-boom", "body.wheel_radius_m = 0.25", "0.24"],
    );
    refused(
        &folder,
        "plan course.toml --plant rats-boom --out nowhere/plan.json",
        &["nowhere/plan.json", "its folder is not there"],
    );
    refused(
        &folder,
        "plan course.toml --plant nobody",
        &["nobody", "rats-boom"],
    );
    refused(
        &folder,
        "verify --law=-0.146,0.704 --distance 1 --omega 4:6:3 --correct",
        &["--correct", "no course"],
    );
}

/// From the log of a heavier robot to a plan that passes on it; the truth is known here.
#[test]
#[ignore = "nightly: 14 s"]
fn a_log_becomes_a_plan_that_passes() {
    let folder = Folder::new("plant-replan");
    folder.write("course.toml", COURSE.replace("0.15\n", "0.12\n").as_str());
    folder.done("inject mass=3.1 --kind jump --runs 6 --out monday", 0);
    let report = folder.done(
        "diagnose monday --replan course.toml --plant rats-boom --plant-set \
         body.mass_kg=3.1 --format json",
        1,
    );
    let replan = &json(&report)["replan"];
    let passed = |plan: &str| replan[plan]["runs_passed"].as_u64().unwrap();
    assert!(
        passed("believed") < 30 && passed("measured") > 170,
        "{replan}"
    );
    assert_eq!(replan["plant"], "rats-boom");
    for (flags, parts) in [
        ("--replan none.toml", ["none.toml", ""]),
        ("--replan monday/experiment.toml", ["kind", "unknown key"]),
        (
            "--replan course.toml --plant rats-boom --plant-set body.wheel_radius_m=0.2",
            ["rats-boom", "0.24"],
        ),
        ("--replan course.toml --plant nobody", ["nobody", ""]),
        ("--plant rats-boom", ["--replan", ""]),
    ] {
        refused(&folder, &format!("diagnose monday {flags}"), &parts);
    }
    let ball = format!(
        "diagnose {}/../tests/reference/ball-drops/tennis-ball --replan course.toml",
        env!("CARGO_MANIFEST_DIR")
    );
    refused(&folder, &ball, &["--replan", "no robot"]);
}

/// Tables for a controller name the robot that they hold on; on the planar one they are those
/// without a plant.
#[test]
fn exported_tables_hold_on_their_plant() {
    let folder = Folder::new("plant-export");
    let line = "export c --distance 0.5:0.7:3 --omega 4:5:3 --out";
    let plain = folder.done(&format!("{line} plain"), 0);
    let same = folder.done(&format!("{line} same --plant rats-planar"), 0);
    let without = |text: &str| {
        let own = |line: &&str| !line.contains("They hold on the robot rats-planar");
        text.lines().filter(own).collect::<Vec<_>>().join("\n")
    };
    assert_eq!(without(&same), without(&plain));
    assert_eq!(same.lines().count(), plain.lines().count() + 1);
    for file in ["saltus_controller.c", "saltus_controller.h"] {
        let [same, plain] = ["same", "plain"].map(|at| folder.read(&format!("{at}/{file}")));
        assert_eq!(without(&same), without(&plain), "{file}");
    }
    let boom = folder.done(&format!("{line} boom --plant rats-boom"), 0);
    let held = boom
        .lines()
        .find(|line| line.starts_with("They hold on the robot rats-boom"));
    let miss: f64 = held
        .and_then(|line| {
            line.rsplit("within ")
                .next()?
                .strip_suffix(" mm.")?
                .parse()
                .ok()
        })
        .expect("how far they miss");
    assert!(miss < 0.5, "{boom}");
    refused(
        &folder,
        &format!("{line} none --plant rats-boom --plant-set body.wheel_radius_m=0.2"),
        &["body.wheel_radius_m = 0.2", "0.24"],
    );
    assert!(!folder.names().contains(&"none".to_owned()));
}
