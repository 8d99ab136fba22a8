//! Small sets that were diagnosed wrongly once, each made with a simulator of its own
//! (`tests/reference/cases`), with the right answers.

use crate::common::Folder;
use serde_json::Value;

fn case(name: &str) -> String {
    format!(
        "{}/../tests/reference/cases/{name}",
        env!("CARGO_MANIFEST_DIR")
    )
}

fn diagnosed(name: &str, code: i32) -> Value {
    let folder = Folder::new(&format!("cases-{name}"));
    let text = folder.done(&format!("diagnose {} --format json", case(name)), code);
    serde_json::from_str(&text).unwrap()
}

fn ids(document: &Value) -> Vec<&str> {
    let causes = document["causes"].as_array().unwrap();
    causes.iter().map(|c| c["id"].as_str().unwrap()).collect()
}

/// The gyro of a robot without a boom, and instruments that are as precise as they are stated.
#[test]
fn nothing_is_wrong_where_nothing_is_hidden() {
    for name in ["gyro-without-boom", "precise-bench", "precise-vessel"] {
        let document = diagnosed(name, 0);
        assert_eq!(
            document["misstated_noise"],
            Value::Array(Vec::new()),
            "{name}"
        );
    }
}

/// The motor's torque is 1.1 times its reading.
#[test]
fn a_scale_is_that_of_the_sensor() {
    let document = diagnosed("torque-scale", 1);
    assert_eq!(ids(&document), ["encoder-scale"]);
    let gain = document["causes"][0]["parameters"]["gain"]
        .as_f64()
        .unwrap();
    assert!((gain - 1.0 / 1.1).abs() < 5e-4, "{gain}");
}

/// A mass swings on a spring of 5 N/m that nobody told of: 600 σ.
#[test]
fn an_effect_of_hundreds_of_deviations_is_found() {
    let document = diagnosed("slide-on-spring", 1);
    assert_eq!(ids(&document), ["return-spring"]);
    let stiffness = document["causes"][0]["parameters"]["stiffness_n_per_m"].as_f64();
    assert!((stiffness.unwrap() - 5.0).abs() < 2e-3, "{stiffness:?}");
}

/// A spool of 5 ms behind a delay of 10 ms, believed to have the delay alone.
#[test]
fn a_slow_spool_is_named_or_unknown() {
    let document = diagnosed("slow-spool", 1);
    let names = &document["causes"].as_array().unwrap()[0]["parameters"];
    let is_spool = names.get("leg.valve_time_constant_s").is_some();
    assert!(
        is_spool || ids(&document).contains(&"unknown"),
        "{document}"
    );
}
