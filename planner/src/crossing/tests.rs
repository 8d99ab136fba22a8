//! The box jump of the thesis, and what happens when it cannot be.

use std::time::Instant;

use saltus_robot::Robot;

use super::*;
use crate::course::Obstacle;

/// The robot stands half a metre before the 21 cm box of thesis §5.2.3.
fn box_jump() -> Crossing {
    Crossing {
        course: Course {
            id: "box".into(),
            start: 0.0,
            start_height: 0.0,
            jumps: 1,
            goal: Span::new(0.7, 1.1),
            obstacles: vec![Obstacle { center: 0.45, width: 0.21, height: 0.21 }],
            no_landing: vec![],
        },
        rates: vec![5.0],
        start_lean: None,
        firing_angles: Span::new(-0.6, 0.8),
        valve_open: Span::new(0.02, 0.1),
        zones: vec![],
        target: 0.9,
        roll: 0.0,
        clearance: 0.02,
        edge_margin: 0.0,
        leg_out: 0.0,
        friction: None,
        sigmas: 0.0,
        deviation_weight: 100.0,
        effort_weight: 1.0,
    }
}

#[test]
fn box_jump_is_planned() {
    let planner = Planner::new(Robot::rats_planar());
    let crossing = box_jump();
    let start = Instant::now();
    let answer = planner.cross(&crossing).expect("a legal crossing");
    println!("{:?}", start.elapsed());
    let CrossingAnswer::Plan(plan) = answer else { panic!("{answer:?}") };
    println!("{plan:#?}");
    assert!(plan.is_verified(), "{:#?}", plan.checks);
}
#[test]
fn scan() {
    let planner = Planner::new(Robot::rats_planar());
    for rate in [4.0, 5.0, 5.5, 6.0] {
        for center in [0.40, 0.42, 0.44, 0.46, 0.48, 0.5] {
            let mut c = box_jump();
            c.rates = vec![rate];
            c.clearance = 0.0;
            c.course.goal = Span::new(0.7, 1.4);
            c.course.obstacles[0].center = center;
            let start = Instant::now();
            let a = planner.cross(&c).expect("a legal crossing");
            let t = start.elapsed();
            match a {
                CrossingAnswer::Plan(p) => println!("{rate} {center} {:?} {:?} {:?} {t:?} fails {:?}", p.search.jumps[0].decisions, p.jumps[0].landing, p.search.report.iterations, p.checks.iter().filter(|c| !c.holds()).collect::<Vec<_>>()),
                CrossingAnswer::Infeasible(r) => println!("{rate} {center} infeasible {:?} {t:?}", r.gives),
                CrossingAnswer::Undecided { nodes } => println!("{rate} {center} undecided {nodes}"),
            }
        }
    }
}
