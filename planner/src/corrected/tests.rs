//! One robot's planar model, corrected to be another's.

use super::*;
use crate::course::{Course, Obstacle};
use crate::{Crossing, CrossingAnswer, TableRequest};

/// Heavier, with a weaker leg: it lands decimetres away.
fn other() -> Robot {
    let mut robot = Robot::rats_planar();
    robot.body.mass *= 1.1;
    robot.leg.coulomb_friction += 5.0;
    robot
}

const RANGE: LaunchRange = LaunchRange {
    rates: Span {
        low: 3.0,
        high: 6.0,
    },
    firing_angles: Span {
        low: -0.3,
        high: 0.4,
    },
    valve_open: Span {
        low: 0.02,
        high: 0.1,
    },
};

fn corrected() -> Planner<Corrected> {
    Planner::by(Corrected::new(
        Planar::new(Robot::rats_planar()),
        RANGE,
        0.0,
    ))
}

fn request() -> TableRequest {
    let rates: Vec<f64> = (0..=12).map(|k| 3.0 + 0.25 * f64::from(k)).collect();
    TableRequest {
        targets: (0..=7).map(|k| 0.3 + 0.1 * f64::from(k)).collect(),
        firing_angles: (-0.3, 0.4),
        sensitivities: false,
        ..TableRequest::distance(0.5).rates(rates)
    }
}

fn launches(planner: &Planner<Corrected>) -> Result<Vec<Launch>, crate::TableError> {
    let table = planner.table(&request())?;
    let entries = table.cells.iter().flat_map(|cell| &cell.entries);
    Ok(entries.map(|entry| entry.jump.launch).collect())
}

const EFFORT: Effort = Effort {
    bound: 2e-4,
    round: 10,
    jumps: 100,
    every: false,
};

#[test]
fn a_table_corrected_holds_for_the_other_robot() {
    let (mut planner, truth) = (corrected(), Planar::new(other()));
    let found = planner.correct(&truth, &EFFORT, launches).expect("legal");
    assert!(found.miss <= EFFORT.bound && !found.is_exact, "{found:?}");
    assert!(found.jumps <= 60, "{found:?}");
    let table = planner.table(&request()).expect("legal");
    let theirs = Planner::by(truth).table(&request()).expect("legal");
    let mut cells = 0;
    for (ours, theirs) in table.cells.iter().zip(&theirs.cells) {
        // At the end of the reach one of the two may have none.
        let (Some(ours), Some(_)) = (ours.entries.first(), theirs.entries.first()) else {
            continue;
        };
        let truth = Planner::new(other());
        let flown = truth.jump(&ours.jump.launch).expect("legal");
        let landing = flown.distance(0.0).expect("a landing");
        assert!((landing - ours.value).abs() < 5e-4, "{landing} {ours:?}");
        let apex = flown.apex().expect("a flight") - ours.jump.apex().expect("a flight");
        assert!(apex.abs() < 5e-4, "{apex}");
        cells += 1;
    }
    assert!(cells > 70, "{cells}");
}

#[test]
fn where_nothing_differs_nothing_changes() {
    let mut planner = corrected();
    let truth = Planar::new(Robot::rats_planar());
    let found = planner.correct(&truth, &EFFORT, launches).expect("legal");
    assert!(
        found.is_exact && found.jumps <= 2 * EFFORT.round,
        "{found:?}"
    );
    let planar = Planner::new(Robot::rats_planar());
    let (a, b) = (
        planner.table(&request()).expect("legal"),
        planar.table(&request()).expect("legal"),
    );
    for (a, b) in a.cells.iter().zip(&b.cells) {
        assert_eq!(a.entries.len(), b.entries.len());
        for (a, b) in a.entries.iter().zip(&b.entries) {
            assert_eq!((a.jump.launch, a.value), (b.jump.launch, b.value));
        }
    }
}

fn box_jump() -> Crossing {
    let course = Course {
        id: "box".into(),
        start: 0.0,
        start_height: 0.0,
        jumps: 2,
        goal: Span::new(1.4, 1.8),
        obstacles: vec![Obstacle {
            center: 0.435,
            width: 0.21,
            height: 0.21,
        }],
        no_landing: vec![],
    };
    Crossing {
        friction: Some(0.8),
        ..Crossing::new(course, 5.5)
    }
}

#[test]
fn a_plan_corrected_is_a_plan_of_the_other_robot() {
    let crossing = box_jump();
    let range = LaunchRange {
        rates: Span::point(5.5),
        firing_angles: crossing.firing_angles,
        valve_open: crossing.valve_open,
    };
    let model = Corrected::new(Planar::new(Robot::rats_planar()), range, 0.0);
    let mut planner = Planner::by(model);
    let effort = Effort {
        bound: 1e-5,
        round: 2,
        jumps: 20,
        every: true,
    };
    let plan = |planner: &Planner<Corrected>| {
        let answer = planner.cross(&crossing)?;
        Ok::<_, crate::CrossingError>(crossing.launches(&answer))
    };
    let truth = Planar::new(other());
    let found = planner.correct(&truth, &effort, plan).expect("legal");
    assert!(found.miss <= 1e-5 && found.jumps <= 12, "{found:?}");
    let CrossingAnswer::Plan(ours) = planner.cross(&crossing).expect("legal") else {
        panic!("no plan");
    };
    assert!(ours.holds(), "{:#?}", ours.checks);
    let CrossingAnswer::Plan(theirs) = Planner::by(truth).cross(&crossing).expect("legal") else {
        panic!("no plan");
    };
    for (ours, theirs) in ours.jumps.iter().zip(&theirs.jumps) {
        let off = ours.landing[0] - theirs.landing[0];
        assert!(
            off.abs() < 2e-3,
            "{} {}",
            ours.landing[0],
            theirs.landing[0]
        );
        let flown = Planner::new(other())
            .jump(&ours.jump.launch)
            .expect("legal");
        let height = 0.24 + ours.landing[1] - ours.foot[1];
        let landing = ours.foot[0] + flown.distance(height).expect("a landing");
        assert!(
            (landing - ours.landing[0]).abs() < 2e-5,
            "{landing} {ours:?}"
        );
    }
}

#[test]
fn derivatives_are_those_of_the_corrected_jumps() {
    let (mut planner, truth) = (corrected(), Planar::new(other()));
    planner.correct(&truth, &EFFORT, launches).expect("legal");
    let at = |rate: f64, angle: f64| {
        let jump = planner
            .jump(&Launch::at_firing(rate, angle, 0.1))
            .expect("legal");
        [
            jump.distance(0.1).expect("a landing"),
            jump.apex().expect("a flight"),
        ]
    };
    for (rate, angle) in [(3.3, 0.1), (4.5, -0.1), (5.7, 0.02)] {
        let launch = Launch::at_firing(rate, angle, 0.1);
        let jump = planner.sensitive_jump(&launch).expect("legal");
        let duals = [
            jump.distance(0.1).expect("a landing"),
            jump.apex().expect("a flight"),
        ];
        let h = 1e-4;
        let (a, b) = (at(rate - h, angle), at(rate + h, angle));
        let (c, d) = (at(rate, angle - h), at(rate, angle + h));
        for k in 0..2 {
            let chords = [(b[k] - a[k]) / (2.0 * h), (d[k] - c[k]) / (2.0 * h)];
            for (slope, chord) in duals[k].slope.iter().zip(chords) {
                let close = 1e-3 * (0.1 + chord.abs());
                assert!((slope - chord).abs() < close, "{k}: {slope} {chord}");
            }
        }
    }
}
