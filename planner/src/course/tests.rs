//! The hopper on small courses, and what happens where there is no plan.

use super::*;
use crate::parkour::Hopper;

fn course(jumps: usize, goal: f64) -> Course {
    let (obstacles, no_landing) = (Vec::new(), Vec::new());
    Course {
        id: "test".into(),
        start: 0.0,
        start_height: 0.0,
        jumps,
        goal: Span::point(goal),
        obstacles,
        no_landing,
    }
}

fn answer(course: &Course) -> Answer {
    plan(&Hopper::default(), course, &Settings::default()).expect("a good course")
}

fn relief(course: &Course) -> Relief {
    match answer(course) {
        Answer::Infeasible(relief) => relief,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_goal_too_far_moves_back_to_the_longest_jumps() {
    let relief = relief(&course(2, 2.0));
    let [give] = relief.gives[..] else { panic!("{relief:?}") };
    assert_eq!((give.limit, give.jump), (Limit::Goal, 1));
    // 1e-6: what the gives are rounded to, with room.
    let near = Course { goal: Span::point(2.0 + give.amount - 1e-6), ..course(2, 2.0) };
    assert!(matches!(answer(&near), Answer::Plan(_)), "{give:?}");
    let short = Course { goal: Span::point(2.0 + give.amount + 1e-4), ..course(2, 2.0) };
    assert!(matches!(answer(&short), Answer::Infeasible(_)));
}

#[test]
fn a_box_too_high_has_to_sink() {
    let tall =
        |height| Course { obstacles: vec![Obstacle { center: 0.4, width: 0.1, height }], ..course(1, 0.75) };
    let relief = relief(&tall(0.4));
    assert!(
        relief.gives.iter().all(|g| matches!(g.limit, Limit::Edge { obstacle: 0, .. } | Limit::Goal)),
        "{relief:?}"
    );
    assert!(relief.total > 0.01 && relief.total < 0.4, "{relief:?}");
    assert!(matches!(answer(&tall(0.05)), Answer::Plan(_)));
}

#[test]
fn a_goal_where_nothing_may_land_moves_out_of_there() {
    let blocked = Course { no_landing: vec![Span::new(0.6, 0.75)], ..course(1, 0.7) };
    let relief = relief(&blocked);
    let [give] = relief.gives[..] else { panic!("{relief:?}") };
    // To the end of the area, to what the gives are rounded to.
    assert!(give.limit == Limit::Goal && (give.amount - 0.05).abs() < 1e-6, "{give:?}");
}

#[test]
fn a_zone_is_reached_where_it_costs_least() {
    let zone = Course { goal: Span::new(0.5, 0.7), ..course(1, 0.0) };
    let Answer::Plan(plan) = answer(&zone) else { panic!() };
    // A flat jump takes longer the further it goes; 1e-9 is the solver's.
    assert!((plan.jumps[0].landing - 0.5).abs() < 1e-9, "{plan:?}");
}

#[test]
fn bad_values_are_named() {
    let check = |course: Course, key: &str| {
        let error = plan(&Hopper::default(), &course, &Settings::default()).expect_err(key).to_string();
        assert!(error.contains("`test`") && error.contains(key) && error.contains("allowed"), "{error}");
    };
    let box_of = |width, height| Obstacle { center: 1.0, width, height };
    check(course(0, 1.0), "jumps = 0");
    check(course(1_000_000, 1.0), "jumps = 1000000");
    check(course(2, f64::NAN), "goal_x_m = NaN");
    check(Course { start: f64::INFINITY, ..course(2, 1.0) }, "start_x_m = inf");
    check(Course { start_height: -0.1, ..course(2, 1.0) }, "start_height_m = -0.1");
    check(Course { goal: Span::new(1.0, 0.5), ..course(2, 1.0) }, "goal_x_m");
    check(Course { obstacles: vec![box_of(-0.2, 0.1)], ..course(2, 1.0) }, "obstacles[0].width_m = -0.2");
    check(Course { obstacles: vec![box_of(0.2, f64::NAN)], ..course(2, 1.0) }, "obstacles[0].height_m = NaN");
    check(Course { obstacles: vec![box_of(0.2, 0.1); 2], ..course(2, 1.0) }, "obstacles[0] and obstacles[1]");
    check(Course { no_landing: vec![Span::new(1.0, 1.0)], ..course(2, 1.0) }, "no_landing[0].width_m = 0");
}

#[test]
fn the_same_course_gives_the_same_plan() {
    let boxes = vec![Obstacle { center: 0.9, width: 0.2, height: 0.1 }];
    let course = Course { obstacles: boxes, ..course(3, 1.9) };
    assert_eq!(answer(&course), answer(&course));
}
