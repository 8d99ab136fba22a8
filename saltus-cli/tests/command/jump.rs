//! `saltus jump`: what it answers and what it refuses.

use serde_json::Value;

use crate::common::{Folder, rows};

/// A low box, and a search that is quick.
const LOW: &str = "--obstacle 0.03x0.1@0.9 --legs 1 --sought-on 2 --generations 2 --robots 6";

#[test]
#[ignore = "nightly: 7 s"]
fn the_answer_is_the_same_on_any_number_of_threads() {
    let folder = Folder::new("jump-low");
    let on = |threads: u32| {
        let line = format!("jump {LOW} --format json --threads {threads}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert!(matches!(run.code, Some(0 | 1)), "{}", run.err);
        run.out
    };
    let (one, two) = (on(1), on(2));
    assert_eq!(one, two);
    let json: Value = serde_json::from_str(&one).unwrap();
    let number = |key: &str| json[key].as_f64().unwrap();
    assert_eq!(number("robots"), 6.0);
    assert!((number("cleared_share") - number("cleared") / 6.0).abs() < 1e-15);
    let clearance = &json["clearance_m"];
    assert!(clearance["5_percent"].as_f64() <= clearance["median"].as_f64());
}

/// Boxes that are sensed, and a table that is quickly made.
const SENSED: &str = "--obstacle 0.04x0.1@1:3 --runs 15 --rounds 1 --robots 3";

#[test]
fn a_sensed_box_is_answered_the_same_on_any_number_of_threads() {
    let folder = Folder::new("jump-sensed");
    let on = |threads: u32| {
        let line = format!("jump {SENSED} --format json --threads {threads}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert!(matches!(run.code, Some(0 | 1)), "{}", run.err);
        (run.out, run.code)
    };
    let ((one, code), two) = (on(1), on(2));
    assert_eq!((&one, code), (&two.0, two.1));
    let json: Value = serde_json::from_str(&one).unwrap();
    let number = |key: &str| json[key].as_f64().unwrap();
    assert_eq!(json["obstacle"]["fronts_m"], serde_json::json!([1.0, 3.0]));
    assert_eq!(number("robots"), 3.0);
    assert!((number("cleared_share") - number("cleared") / 3.0).abs() < 1e-15);
    assert!(number("run_on") <= number("cleared"));
    assert_eq!(code, Some(i32::from(number("cleared_share") < 0.95)));
    assert!(number("nearer_height_m") <= 0.04);
}

#[test]
fn bad_input_is_named() {
    let folder = Folder::new("jump-bad");
    for (line, said) in [
        ("jump", "--obstacle"),
        ("jump --obstacle 0.21@1", "HEIGHTxLENGTH@FRONT"),
        ("jump --obstacle 0x0.2@1", "height"),
        ("jump --obstacle 0.2x0.2@-1", "front"),
        ("jump --obstacle nanx0.2@1", "height"),
        (
            "jump --obstacle 0.1x0.2@0.1",
            "from 0.24 m, the robot's radius",
        ),
        ("jump --obstacle 0.1x0.2@1 --legs 0", "--legs"),
        ("jump --obstacle 0.1x0.2@3:2", "at least the nearest, 3 m"),
        ("jump --obstacle 0.1x0.2@1:x", "farthest front"),
        (
            "jump --obstacle 0.1x0.2@0.1:2",
            "from 0.24 m, the robot's radius",
        ),
        ("jump --obstacle 0.1x0.2@1 --room 2", "FROM:TO"),
        ("jump --obstacle 0.1x0.2@1:2 --legs 2", "--legs"),
        ("jump --obstacle 0.1x0.2@1:2 --room 9", "from 0 to 5 m"),
        ("jump --obstacle 0.1x0.2@1:2 --runs 0", "--runs"),
        ("jump --obstacle 0.1x0.2@1:2 --plot a.svg", "--plot"),
        ("jump --obstacle 0.1x0.2@1 --plot a.svg", "--plot"),
        ("jump --obstacle 0.1x0.2@1:2 --robot rats-planar", "boom"),
        ("jump --obstacle 0.1x0.2@1 --format csv", "text or json"),
        (
            "jump --obstacle 0.1x0.2@1 --robot spring-hopper",
            "pneumatic",
        ),
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        assert!(run.err.contains(said), "{line}: {}", run.err);
    }
}

/// A jump in space whose search is quick.
const TO: &str = "jump --robot rats-twelve --target 0.3,-0.2 --sought-on 4 --robots 10";

#[test]
fn a_jump_in_space_lands_near_its_target() {
    let folder = Folder::new("jump-to");
    let on = |threads: u32| folder.done(&format!("{TO} --format json --threads {threads}"), 0);
    let one = on(1);
    assert_eq!(one, on(2));
    let json: Value = serde_json::from_str(&one).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let (x, y) = (number(&json["landed_m"][0]), number(&json["landed_m"][1]));
    let miss = (x - 0.3).hypot(y + 0.2);
    assert!(
        (number(&json["miss_m"]) - miss).abs() < 1e-12 && miss < 0.05,
        "{json}"
    );
    assert_eq!(json["is_reached"], true);
    assert_eq!(json["within_10_cm"]["of"], 10);
    // It lands from above, once it has left the ground, and its rows end where it rests.
    assert!(number(&json["apex_m"]) > number(&json["landed_m"][2]));
    let (header, rows) = rows(&folder.done(&format!("{TO} --format csv"), 0));
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let last = rows.last().unwrap();
    for (k, name) in ["x_m", "y_m", "z_m"].into_iter().enumerate() {
        let there: f64 = last[column(name)].parse().unwrap();
        assert!((there - number(&json["in_the_end_m"][k])).abs() < 1e-12);
    }
    assert!(rows.iter().any(|row| row[column("feet_on_ground")] == "0"));
    // A heading with a distance is a target, too.
    let ahead = "jump --robot rats-twelve --heading 90deg --distance 0.2 --sought-on 2 --robots 1 --format json";
    let words: Vec<&str> = ahead.split_whitespace().collect();
    let json: Value = serde_json::from_str(&folder.run(&words).out).unwrap();
    assert!(number(&json["target_m"][0]).abs() < 1e-12);
    assert_eq!(json["target_m"][1], 0.2);
}

#[test]
fn a_ball_jumps_onto_a_box_from_rest() {
    let folder = Folder::new("jump-onto");
    let line = "jump --robot rats-twelve --target 0.55,0 --obstacle 0.08x1.5@0.28 --sought-on 4 --robots 10 --format json";
    let words: Vec<&str> = line.split_whitespace().collect();
    let run = folder.run(&words);
    assert!(matches!(run.code, Some(0 | 1)), "{}", run.err);
    let json: Value = serde_json::from_str(&run.out).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    assert_eq!(json["obstacle"]["height_m"], 0.08);
    assert!(number(&json["clearance_m"]) > 0.0, "{json}");
    // It stands 0.19 m high, and more on the box.
    let [landed, stands] = ["landed_m", "in_the_end_m"].map(|key| number(&json[key][2]));
    assert!(landed > 0.26 && stands > 0.26, "{json}");
    let [near, stay] = ["within_10_cm", "stay_on_the_box"].map(|key| number(&json[key]["count"]));
    assert!(near >= 3.0 && stay >= 3.0 && stay <= near, "{json}");
}

#[test]
#[ignore = "nightly: 6 s"]
fn a_ball_jumps_onto_a_box_out_of_a_run() {
    let folder = Folder::new("jump-run-onto");
    let line = "jump --robot rats-twelve --obstacle 0.08x4@2.2 --onto --sought-on 2 --generations 1 --robots 4 --format csv";
    let words: Vec<&str> = line.split_whitespace().collect();
    let run = folder.run(&words);
    assert!(matches!(run.code, Some(0 | 1)), "{}", run.err);
    let (header, rows) = rows(&run.out);
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let up = rows.iter().filter(|row| row[column("cleared")] == "true");
    assert!(up.count() >= 2, "{rows:?}");
}

#[test]
fn a_place_out_of_reach_has_a_nearest_one() {
    let folder = Folder::new("jump-far");
    let text = folder.done(
        "jump --robot rats-twelve --target 3,0 --sought-on 2 --robots 2",
        1,
    );
    assert!(
        text.contains("cm off it in the mean; this robot lands at (0."),
        "{text}"
    );
    assert!(text.contains("0 of 2"), "{text}");
}

#[test]
#[ignore = "nightly: 8 s"]
fn a_map_has_places_near_and_far() {
    let folder = Folder::new("jump-map");
    let line =
        "jump --robot rats-twelve --map 0.45 --sought-on 2 --robots 2 --format csv --plot map.svg";
    let words: Vec<&str> = line.split_whitespace().collect();
    let run = folder.run(&words);
    assert!(matches!(run.code, Some(0 | 1)), "{}", run.err);
    let (header, rows) = rows(&run.out);
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    let number = |row: &[String], name: &str| row[column(name)].parse::<f64>().unwrap();
    for row in &rows {
        let far = number(row, "x_m").hypot(number(row, "y_m"));
        // The farthest landing of any legs is 0.8 m away.
        assert!(
            far < 0.85 || row[column("is_reached")] == "false",
            "{row:?}"
        );
        assert_eq!(
            row[column("within_10_cm")].is_empty(),
            row[column("is_reached")] == "false"
        );
    }
    assert!(rows.iter().any(|row| row[column("is_reached")] == "true"));
    assert!(rows.iter().any(|row| row[column("is_reached")] == "false"));
    assert!(folder.read("map.svg").contains("out of reach"));
}

#[test]
#[ignore = "nightly: 6 s"]
fn a_ball_jumps_over_a_box_out_of_a_run() {
    let folder = Folder::new("jump-ball-box");
    let line = "jump --robot rats-twelve --obstacle 0.15x0.1@2.2 --sought-on 2 --generations 1 --robots 4 --format csv";
    let words: Vec<&str> = line.split_whitespace().collect();
    let run = folder.run(&words);
    assert!(matches!(run.code, Some(0 | 1)), "{}", run.err);
    let (header, rows) = rows(&run.out);
    let column = |name: &str| header.iter().position(|column| column == name).unwrap();
    assert_eq!(rows.len(), 4);
    for row in &rows {
        if row[column("cleared")] == "true" {
            let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
            assert!(
                number("clearance_m") > 0.0 && number("jumped_at_m") > 0.0,
                "{row:?}"
            );
            assert!(number("apex_m") > 0.15 + 0.2, "{row:?}");
        }
    }
    assert!(
        rows.iter()
            .filter(|row| row[column("cleared")] == "true")
            .count()
            >= 2,
        "{rows:?}"
    );
}

#[test]
fn bad_input_of_a_ball_is_named_and_leaves_no_file() {
    let folder = Folder::new("jump-ball-bad");
    for (line, said) in [
        ("", "--target is missing"),
        ("--target nan,0", "-100 to 100 m"),
        ("--target 0,inf", "-100 to 100 m"),
        ("--target 0.3", "X,Y"),
        ("--target 0.3,0 --rest 20", "--rest 20: must be below 20"),
        ("--target 0.3,0 --map 0.1", "--map"),
        ("--target 0.5,0 --obstacle 0.1x1@0.3:0.5", "with one FRONT"),
        ("--target 0.5,0 --obstacle 0.1x1@0.2", "around the robot"),
        ("--target 0.5,0 --onto", "--onto"),
        ("--target 0.5,0 --obstacle 0.1x3@1 --onto", "--onto"),
        ("--obstacle 0.1x1@2 --onto", "from 2.48 m"),
        ("--target 0.3,0 --generations 3", "--generations"),
        ("--target 0.3,0 --legs 2", "--legs"),
        ("--target 0.3,0 --room 1", "--room"),
        ("--target 0.3,0 --plot a.svg", "--map"),
        ("--heading 1", "--distance"),
        ("--heading 700deg --distance 1", "from -pi to pi"),
        ("--map 0", "above 0"),
        ("--map -0.1", "--map"),
        ("--map 1mm", "not so fine"),
        ("--obstacle 0.1x0.1@0.2", "around the robot"),
        ("--obstacle -0.1x0.1@2", "height"),
        ("--obstacle 0.1x0x@2", "length"),
        ("--obstacle 0.1x0.1@2 --rest 1", "--rest"),
        ("--target 0.3,0 --set ground.slope_deg=5", "slope"),
    ] {
        let line = format!("jump --robot rats-twelve {line} --out answer.json");
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        assert!(run.err.contains(said), "{line}: {}", run.err);
        assert!(!folder.path("answer.json").exists(), "{line}");
    }
    // These are for a robot in space.
    for flag in ["--target 0.3,0", "--map 0.2", "--rest 1", "--onto"] {
        let line = format!("jump --obstacle 0.1x0.1@1 {flag}");
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        assert!(run.err.contains("a robot in space"), "{line}: {}", run.err);
    }
}
