//! A hidden effect is found, nothing is found where nothing is hidden, and what is not on the list
//! is not given a name of it.
//!
//! A quick sample of what the study `campaign` does at length.

use saltus_diagnosis::{Diagnosis, Kind, Settings, Sort, diagnose, kinds};
use saltus_robot::Robot;
use saltus_tests::lab::{self, Case, Size};
use saltus_tests::verdict;

fn diagnosed(sort: Sort, hidden: &[(&str, Size)], seed: u64) -> (Case, Box<dyn Kind>, Diagnosis) {
    let case = lab::make(sort, hidden, seed);
    let robot = case.robot.as_deref().and_then(Robot::builtin);
    let kind = kinds::build(&case.experiment, robot.as_ref()).expect("a model of the data");
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ()).expect("a motion");
    (case, kind, found)
}

/// Finds effects of size `size`, each named alone or with two rivals at most.
fn finds(sort: Sort, hidden: &[(&str, Size)], seed: u64) {
    let (case, _, found) = diagnosed(sort, hidden, seed);
    let said = verdict::say(&found);
    assert!(
        verdict::names(&found, &case.truth),
        "{sort:?} {hidden:?}: {said}"
    );
}

#[test]
fn nothing_is_found_in_parts_where_nothing_is_hidden() {
    for sort in [
        Sort::Bench,
        Sort::Flight,
        Sort::Stroke,
        Sort::Slide,
        Sort::Vessel,
    ] {
        // At one seed in twenty chance may look like an effect; not at this one.
        finds(sort, &[], 62);
    }
}

#[test]
#[ignore = "nightly: 8 s"]
fn nothing_is_found_in_jumps_where_nothing_is_hidden() {
    for sort in [Sort::Hop, Sort::Outcomes, Sort::TankLeg] {
        finds(sort, &[], 62);
    }
}

#[test]
fn a_clear_effect_on_the_bench() {
    for id in ["valve-delay", "dead-volume", "heat-transfer"] {
        finds(Sort::Bench, &[(id, Size::Clear)], 42);
    }
}

#[test]
#[ignore = "nightly: 33 s"]
fn a_clear_effect_in_hops_and_jumps() {
    finds(Sort::Hop, &[("viscous-friction", Size::Clear)], 43);
    finds(Sort::Hop, &[("boom-flex", Size::Clear)], 43);
    finds(Sort::Jump, &[("across-friction", Size::Clear)], 43);
}

/// Two numbers a jump.
#[test]
#[ignore = "nightly: 27 s"]
fn a_clear_effect_in_outcomes() {
    finds(Sort::Outcomes, &[("axle-friction", Size::Clear)], 43);
}

/// The robot already moves at the first row of its log.
#[test]
#[ignore = "nightly: 18 s"]
fn a_late_sensor_in_jumps() {
    finds(Sort::Jump, &[("sensor-delay", Size::Clear)], 501);
}

/// Where nobody says how much a column scatters, the runs that are as they should be tell it.
#[test]
fn a_part_of_one_run_where_the_noise_is_not_told() {
    let mut case = lab::make(Sort::Stroke, &[("saturation", Size::Large)], 3002);
    case.experiment.noise.fill(None);
    let kind = kinds::build(&case.experiment, None).expect("a model of the data");
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ()).expect("an answer");
    assert!(
        found.unknown.is_some() && found.findings.is_empty(),
        "{}",
        verdict::say(&found)
    );
}

#[test]
fn a_clear_effect_in_flights_and_parts() {
    for (sort, id) in [
        (Sort::Flight, "air-drag"),
        (Sort::Flight, "counterweight"),
        (Sort::Stroke, "seal-friction"),
        (Sort::Stroke, "return-spring"),
        (Sort::Slide, "coulomb-friction"),
        (Sort::Slide, "directional-friction"),
        (Sort::Vessel, "gas-type"),
    ] {
        finds(sort, &[(id, Size::Clear)], 44);
    }
}

/// Gas and legs of a robot that nothing of the diagnosis has simulated.
#[test]
#[ignore = "nightly: 20 s"]
fn a_clear_effect_in_jumps_from_a_tank() {
    for id in ["tank", "tube", "series-spring"] {
        finds(Sort::TankLeg, &[(id, Size::Clear)], 44);
    }
}

#[test]
#[ignore = "nightly: 10 s"]
fn two_effects_at_once() {
    finds(
        Sort::Stroke,
        &[
            ("seal-friction", Size::Clear),
            ("sensor-offset", Size::Clear),
        ],
        45,
    );
    finds(
        Sort::Bench,
        &[
            ("valve-delay", Size::Clear),
            ("viscous-friction", Size::Clear),
        ],
        45,
    );
}

#[test]
fn what_is_not_on_the_list_is_unknown() {
    for (sort, id) in [
        (Sort::Flight, "ripple"),
        (Sort::Flight, "gear-ripple"),
        (Sort::Stroke, "position-friction"),
        (Sort::Vessel, "clogging"),
        (Sort::Bench, "ripple"),
    ] {
        let (_, _, found) = diagnosed(sort, &[(id, Size::Large)], 46);
        assert!(
            found.unknown.is_some(),
            "{sort:?} {id}: {}",
            verdict::say(&found)
        );
    }
}
