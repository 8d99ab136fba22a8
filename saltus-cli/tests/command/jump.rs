//! `saltus jump`: what it answers and what it refuses.

use serde_json::Value;

use crate::common::Folder;

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
