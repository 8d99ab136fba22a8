//! The laboratory: what it hides can be seen, and follows from the seed.

use saltus_diagnosis::{Experiment, Sort, Terms, kinds, meaning, named};
use saltus_robot::Robot;
use saltus_tests::lab::{Case, SORTS, Size, causes_of, exact, kinds_of, make, outside};

/// Every column has as many values as there are rows, time increases, and every value is a number;
/// only what is noted by hand, without noise, may be there at the start alone.
fn check_form(case: &Case) {
    let experiment = &case.experiment;
    assert!(!experiment.runs.is_empty());
    assert_eq!(experiment.columns.len(), experiment.noise.len());
    assert_eq!(experiment.columns.len(), experiment.resolution.len());
    for run in &experiment.runs {
        assert!(
            run.time.windows(2).all(|pair| pair[0] < pair[1]),
            "{}",
            run.name
        );
        assert_eq!(run.values.len(), experiment.columns.len());
        for (k, values) in run.values.iter().enumerate() {
            assert_eq!(values.len(), run.time.len());
            let known = values.partition_point(|value| value.is_finite());
            let is_noted = experiment.noise[k].is_none() && experiment.resolution[k].is_none();
            let least = if is_noted { 1 } else { values.len() };
            assert!(known >= least, "{} {}", run.name, experiment.columns[k]);
            assert!(values[known..].iter().all(|value| value.is_nan()));
        }
    }
}

fn check_sizes(kind: Sort, ids: &[&str], seed: u64) {
    for id in ids {
        // What the runs that gave the strength leave open; a foot that slips at all slips by some, and
        // a leg that meets its spring late may meet it or not.
        let is_sudden = *id == "foot-slip" || (kind == Sort::TankLeg && *id == "return-spring");
        let (least, most) = if is_sudden { (3.0, 4.0) } else { (5.0, 2.5) };
        let clear = make(kind, &[(id, Size::Clear)], seed);
        check_form(&clear);
        assert_eq!(clear.truth[0].id, *id);
        assert!(
            clear.truth[0].sigmas >= least,
            "{kind:?} {id}: {}",
            clear.truth[0].sigmas
        );
        if *id != "gas-type" {
            let subtle = make(kind, &[(id, Size::Subtle)], seed).truth[0].sigmas;
            assert!((1.7..most).contains(&subtle), "{kind:?} {id}: {subtle}");
        }
    }
}

#[test]
#[ignore = "nightly: 7 s"]
fn every_effect_on_a_bench_shows() {
    check_sizes(Sort::Bench, causes_of(Sort::Bench), 1);
    check_sizes(Sort::Bench, outside(Sort::Bench), 2);
}

#[test]
fn every_effect_on_a_part_shows() {
    for kind in [Sort::Flight, Sort::Stroke, Sort::Slide, Sort::Vessel] {
        for seed in 0..3 {
            check_sizes(kind, causes_of(kind), seed);
            check_sizes(kind, outside(kind), seed);
        }
    }
}

/// A few of each.
#[test]
#[ignore = "nightly: 9 s"]
fn effects_on_a_robot_show() {
    check_sizes(
        Sort::Jump,
        &["inertia", "foot-slip", "ground-compliance"],
        1,
    );
    check_sizes(Sort::Hop, &["valve-delay", "chamber-leak"], 1);
    check_sizes(Sort::Outcomes, &["air-drag"], 1);
}

#[test]
#[ignore = "nightly: 200 s"]
fn every_effect_on_a_robot_shows() {
    for kind in [Sort::Hop, Sort::Jump, Sort::Outcomes] {
        for seed in 0..2 {
            check_sizes(kind, causes_of(kind), seed);
            check_sizes(kind, outside(kind), seed);
        }
    }
}

/// Some of gas, legs and sensors, and one that nobody lists.
#[test]
#[ignore = "nightly: 23 s"]
fn effects_on_a_tank_leg_show() {
    let ids = [
        "tube",
        "series-spring",
        "return-spring",
        "sensor-delay",
        "smooth-floor",
    ];
    check_sizes(Sort::TankLeg, &ids, 1);
}

#[test]
#[ignore = "nightly: 200 s"]
fn every_effect_on_a_tank_leg_shows() {
    for seed in 0..3 {
        check_sizes(Sort::TankLeg, causes_of(Sort::TankLeg), seed);
        check_sizes(Sort::TankLeg, outside(Sort::TankLeg), seed);
    }
}

/// What two models of the same robot make of it, with equations and integrators of their own: root
/// mean squares of their differences in standard deviations of a reading, by channel. From when
/// the muscles are vented on, they need not agree: what that lets through, the operator does not know.
#[test]
fn two_models_of_a_tank_leg_agree() {
    const VENTED: f64 = 0.29;
    for seed in 1..=4 {
        let experiment = exact(Sort::TankLeg, seed);
        let kind = kinds::build(&experiment, None).expect("a good experiment");
        let off = Terms::off(kind.causes());
        let mut squares = vec![(0.0, 0.0); kind.channels().len()];
        for (run, log) in kind.logs().iter().enumerate() {
            let unknowns: Vec<f64> = kind.unknowns(run).iter().map(|u| u.neutral).collect();
            let predicted = kind.predict(run, &off, &unknowns).expect("a jump");
            let rows = log.readings.iter().zip(&predicted);
            for (reading, predicted) in rows.filter(|(reading, _)| reading.time < VENTED) {
                let sigma = kind.channels()[reading.channel].noise;
                let (sum, count) = &mut squares[reading.channel];
                *sum += ((reading.value - predicted) / sigma).powi(2);
                *count += 1.0;
            }
        }
        for (channel, (sum, count)) in kind.channels().iter().zip(squares) {
            // What steps of 2 ms leave out.
            let rms: f64 = f64::sqrt(sum / count);
            assert!(rms < 0.15, "seed {seed}, {}: {rms} σ", channel.name);
        }
    }
}

/// The same, with empty cells where both have them.
fn same(a: &Experiment, b: &Experiment) -> bool {
    format!("{a:?}") == format!("{b:?}")
}

#[test]
fn all_follows_from_the_seed_on_a_bench_and_in_a_flight() {
    check_seeds(&[Sort::Bench, Sort::Flight]);
}

#[test]
#[ignore = "nightly: 39 s"]
fn all_follows_from_the_seed() {
    check_seeds(&SORTS);
}

fn check_seeds(kinds: &[Sort]) {
    for &kind in kinds {
        let id = causes_of(kind)[0];
        let [a, b, c] = [4, 4, 5].map(|seed| make(kind, &[(id, Size::Subtle)], seed));
        assert!(
            same(&a.experiment, &b.experiment) && a.truth == b.truth,
            "{kind:?}"
        );
        assert!(!same(&a.experiment, &c.experiment), "{kind:?}");
        // No effect, and two: the second is what it is alone.
        let none = make(kind, &[], 4);
        check_form(&none);
        assert!(none.truth.is_empty());
        let other = causes_of(kind)[1];
        let both = make(kind, &[(other, Size::Subtle), (id, Size::Subtle)], 4);
        check_form(&both);
        assert_eq!(both.truth.len(), 2);
        // Which flights there are depends on what is to show in them.
        if kind != Sort::Flight {
            assert_eq!(both.truth[1], a.truth[0], "{kind:?}");
        }
    }
}

#[test]
fn every_named_cause_shows_somewhere() {
    for (id, _) in named() {
        assert!(!kinds_of(id).is_empty(), "{id}");
    }
    for kind in SORTS {
        assert!(
            causes_of(kind).iter().all(|id| meaning(id).is_some()),
            "{kind:?}"
        );
        assert!(
            outside(kind).iter().all(|id| meaning(id).is_none()),
            "{kind:?}"
        );
    }
}

#[test]
fn every_cause_on_the_list_of_a_kind_has_a_sentence() {
    for sort in SORTS {
        let case = make(sort, &[], 1);
        let robot = case.robot.as_deref().and_then(Robot::builtin);
        let kind = kinds::build(&case.experiment, robot.as_ref()).expect("a good experiment");
        for cause in &kind.causes()[..kind.listed()] {
            assert!(meaning(cause.id).is_some(), "{sort:?} {}", cause.id);
        }
    }
}
