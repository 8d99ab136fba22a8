//! Logs of runs in which nothing is wrong, stride by stride.

use saltus_diagnosis::{Settings, diagnose, kinds};
use saltus_tests::lab::running;

/// What is wrong in the log of `seed`, which is of a gait that begins with `gait`: nothing.
fn is_sound(gait: &str, seed: u64) {
    let trial = running::make(None, 8.0, seed).expect("a robot that runs");
    assert!(trial.gait.starts_with(gait), "{}", trial.gait);
    let kind = kinds::build(&trial.experiment, Some(&trial.believed)).expect("strides");
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ()).expect("motions");
    let named: Vec<&str> = found.findings.iter().map(|f| f.best.id).collect();
    assert!(named.is_empty(), "{gait}: {named:?}");
    assert_eq!(found.unknown, None, "{gait}");
    let notes = kind.notes().join("; ");
    assert!(
        notes.contains("firings are used") && notes.contains("firings left out"),
        "{notes}"
    );
}

/// The wheel turns so fast at the end that spin holds legs out; those strides are left out.
#[test]
fn nothing_is_wrong_with_a_robot_that_speeds_up() {
    is_sound("sparing", 103);
}

#[test]
#[ignore = "nightly: 9 s"]
fn nothing_is_wrong_with_a_robot_under_a_closed_loop() {
    is_sound("closed loop", 8);
}

#[test]
#[ignore = "nightly: 9 s"]
fn nothing_is_wrong_with_a_robot_that_was_pushed() {
    is_sound("fixed", 106);
}
