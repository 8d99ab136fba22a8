//! Sensed boxes: learned tables, and what is refused.

use saltus_gait::{Draw, GaitError, Sensed, Smooth};

use crate::robot;

fn few() -> Sensed {
    Sensed {
        robot: robot("rats-run"),
        draw: Draw::default(),
        heights: vec![0.05, 0.1],
        length: 0.21,
        fronts: [1.0, 4.0],
        room: 2.6,
        law: Smooth::QUICK,
        runs: 12,
        rounds: 2,
        seed: 3,
    }
}

#[test]
fn tables_and_trials_are_the_same_on_any_number_of_threads() -> Result<(), GaitError> {
    let sensed = few();
    let one = sensed.plan(1, |_| ())?;
    let two = sensed.plan(2, |_| ())?;
    assert_eq!(one, two);
    assert_eq!(one.len(), 2);
    assert!(
        one[0].cells != one[1].cells,
        "a higher box has a table of its own"
    );
    let tried = |threads| sensed.try_on(&one[0], 3, 70, threads);
    let (a, b) = (tried(1)?, tried(2)?);
    assert_eq!(format!("{a:?}"), format!("{b:?}"));
    assert!(a.iter().all(|faced| (1.0..=4.0).contains(&faced.front)));
    assert!(
        a.iter()
            .all(|faced| !faced.cleared || faced.clearance > 0.0)
    );
    Ok(())
}

#[test]
fn what_cannot_be_is_refused() {
    let check = |sensed: &Sensed, said: &str| {
        let error = sensed.plan(1, |_| ()).expect_err(said).to_string();
        assert!(error.contains(said), "{error}");
    };
    check(
        &Sensed {
            fronts: [0.1, 2.0],
            ..few()
        },
        "front of the obstacle",
    );
    check(
        &Sensed {
            fronts: [2.0, 1.0],
            ..few()
        },
        "farthest front",
    );
    check(
        &Sensed {
            heights: vec![],
            ..few()
        },
        "heights",
    );
    check(
        &Sensed {
            heights: vec![-0.1],
            ..few()
        },
        "height of the obstacle",
    );
    check(
        &Sensed {
            room: -1.0,
            ..few()
        },
        "room to run up",
    );
    check(&Sensed { rounds: 0, ..few() }, "rounds");
    check(
        &Sensed {
            robot: robot("rats-planar"),
            ..few()
        },
        "boom",
    );
}
