//! The hopper's equations against finite differences, its bounds against what it can do, and its
//! small courses.

use proptest::prelude::*;
use saltus_planner::course::{
    Answer, Course, Edge, Jump, Jumper, Leap, Limit, Obstacle, Push, Relief, Settings, Side, Slope,
    Span, plan,
};
use saltus_tests::parkour::{Hopper, Takeoff};

fn edge(x: f64, top: f64, side: Side) -> Edge {
    Edge {
        x,
        top,
        obstacle: 0,
        side,
    }
}

/// Over a box, onto it, and down from it.
fn leaps() -> [Leap; 4] {
    let (front, back) = (edge(0.35, 0.12, Side::Front), edge(0.45, 0.12, Side::Back));
    [
        Leap {
            jump: 0,
            from: 0.0,
            to: 0.0,
            on: [None; 2],
            edges: vec![],
            beside: vec![],
            push: Push::Any,
        },
        Leap {
            jump: 0,
            from: 0.0,
            to: 0.0,
            on: [None; 2],
            edges: vec![front, back],
            beside: vec![],
            push: Push::Any,
        },
        Leap {
            jump: 0,
            from: 0.0,
            to: 0.12,
            on: [None; 2],
            edges: vec![front],
            beside: vec![],
            push: Push::Any,
        },
        Leap {
            jump: 0,
            from: 0.12,
            to: 0.0,
            on: [None; 2],
            edges: vec![back],
            beside: vec![],
            push: Push::Any,
        },
    ]
}

/// Landing, cost and margins, as plain numbers.
fn outcome(hopper: &Hopper, leap: &Leap, at: [f64; 3]) -> Vec<Slope> {
    let mut margins = Vec::new();
    let [foot, distance, angle] = std::array::from_fn(|i| Slope::variable(at[i], i));
    let flight = hopper.fly(leap, foot, [distance, angle], &mut margins);
    [flight.landing, flight.cost]
        .into_iter()
        .chain(margins.into_iter().map(|m| m.value))
        .collect()
}

fn allowed(hopper: &Hopper, leap: &Leap, at: [f64; 3]) -> Option<f64> {
    let outcome = outcome(hopper, leap, at);
    outcome[2..]
        .iter()
        .all(|m| m.value >= 0.0)
        .then(|| outcome[1].value)
}

#[test]
fn derivatives_agree_with_central_differences() {
    let (hopper, at) = (Hopper::default(), [0.05, 0.62, 1.2]);
    for leap in leaps() {
        let exact = outcome(&hopper, &leap, at);
        for i in 0..3 {
            let shifted = |h: f64| {
                let mut x = at;
                x[i] += h;
                outcome(&hopper, &leap, x)
            };
            let (after, before) = (shifted(1e-6), shifted(-1e-6));
            for ((e, a), b) in exact.iter().zip(&after).zip(&before) {
                let difference = (a.value - b.value) / 2e-6;
                // Truncation 1e-12 times third derivatives, round-off 1e-16/1e-6.
                assert!(
                    (e.slope[i] - difference).abs() < 1e-8 * (1.0 + difference.abs()),
                    "{leap:?} {i}"
                );
            }
        }
    }
}

#[test]
fn the_flight_is_the_parabola_of_its_launch() {
    let hopper = Hopper::default();
    for leap in leaps() {
        let jump = Jump {
            leap: leap.clone(),
            foot: 0.0,
            landing: 0.7,
            decisions: [0.7, 1.25],
            deviation: 0.0,
        };
        let Takeoff {
            flight_time: t,
            speed: v,
            angle,
        } = hopper.launch(&jump);
        let x = hopper.leg * angle.cos() + hopper.foot[0] + v * angle.cos() * t;
        let z = leap.from + hopper.leg * angle.sin() + hopper.foot[1] + v * angle.sin() * t
            - hopper.gravity / 2.0 * t * t;
        // Round-off.
        assert!(
            (x - 0.7).abs() < 1e-14 && (z - leap.to).abs() < 1e-14,
            "{leap:?}: {x} {z}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: proptest::test_runner::RngSeed::Fixed(7), failure_persistence: None, cases: 4000, max_global_rejects: 20_000, ..ProptestConfig::default() })]

    /// No allowed jump is cheaper than its envelope, or outside of it.
    #[test]
    fn the_envelope_bounds_every_allowed_jump(
        which in 0_usize..4, foot in -0.3..0.34_f64, distance in 0.05..1.2_f64, angle in 1.1345..1.4835_f64,
        before in 0.0..0.2_f64, after in 0.0..0.2_f64, less in 0.0..0.3_f64, more in 0.0..0.3_f64,
    ) {
        let (hopper, leap) = (Hopper::default(), leaps()[which].clone());
        let foot = if which == 3 { 0.38 + 0.1 * foot } else { foot };
        let landing = foot + distance;
        let ends = match which { 0 => Span::ALL, 2 => Span::new(0.36, 0.44), _ => Span::new(0.46, 9.0) };
        prop_assume!(landing >= ends.low && landing <= ends.high);
        if let Some(cost) = allowed(&hopper, &leap, [foot, distance, angle]) {
            let feet = Span::new(foot - before, foot + after.min(leap.edges.first().map_or(9.0, |e| (e.x - foot).max(0.0))));
            let landings = Span::new(landing - before, landing + after).meet(ends);
            let reach = Span::new(distance - less, distance + more);
            let envelope = hopper.envelope(&leap, feet, landings, reach).expect("this jump");
            // Round-off of roots.
            prop_assert!(envelope.reach().low <= distance + 1e-9 && envelope.reach().high >= distance - 1e-9);
            let bound = envelope.at(envelope.reach().clamp(distance));
            prop_assert!(bound <= cost + 1e-9, "{bound} > {cost}");
        }
    }

    /// Aiming gives the fastest of all allowed jumps between two places.
    #[test]
    fn aiming_is_fastest(which in 0_usize..4, foot in -0.3..0.3_f64, distance in 0.05..1.0_f64, angle in 1.1345..1.4835_f64) {
        let (hopper, leap) = (Hopper::default(), leaps()[which].clone());
        let foot = if which == 3 { 0.38 + 0.1 * foot } else { foot };
        if let Some(cost) = allowed(&hopper, &leap, [foot, distance, angle]) {
            let [_, aimed] = hopper.aim(&leap, foot, foot + distance);
            let outcome = outcome(&hopper, &leap, [foot, distance, aimed]);
            prop_assert!(outcome[1].value <= cost + 1e-12);
            // Round-off of roots.
            prop_assert!(outcome[2..].iter().all(|m| m.value >= -1e-12), "{outcome:?}");
        }
    }
}

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
    let [give] = relief.gives[..] else {
        panic!("{relief:?}")
    };
    assert_eq!((give.limit, give.jump), (Limit::Goal, 1));
    // 1e-6: what the gives are rounded to, with room.
    let near = Course {
        goal: Span::point(2.0 + give.amount - 1e-6),
        ..course(2, 2.0)
    };
    assert!(matches!(answer(&near), Answer::Plan(_)), "{give:?}");
    let short = Course {
        goal: Span::point(2.0 + give.amount + 1e-4),
        ..course(2, 2.0)
    };
    assert!(matches!(answer(&short), Answer::Infeasible(_)));
}

#[test]
fn a_box_too_high_has_to_sink() {
    let tall = |height| Course {
        obstacles: vec![Obstacle {
            center: 0.4,
            width: 0.1,
            height,
        }],
        ..course(1, 0.75)
    };
    let relief = relief(&tall(0.4));
    assert!(
        relief
            .gives
            .iter()
            .all(|g| matches!(g.limit, Limit::Edge { obstacle: 0, .. } | Limit::Goal)),
        "{relief:?}"
    );
    assert!(relief.total > 0.01 && relief.total < 0.4, "{relief:?}");
    assert!(matches!(answer(&tall(0.05)), Answer::Plan(_)));
}

#[test]
fn a_goal_where_nothing_may_land_moves_out_of_there() {
    let blocked = Course {
        no_landing: vec![Span::new(0.6, 0.75)],
        ..course(1, 0.7)
    };
    let relief = relief(&blocked);
    let [give] = relief.gives[..] else {
        panic!("{relief:?}")
    };
    // To the end of the area, to what the gives are rounded to.
    assert!(
        give.limit == Limit::Goal && (give.amount - 0.05).abs() < 1e-6,
        "{give:?}"
    );
}

#[test]
fn a_zone_is_reached_where_it_costs_least() {
    let zone = Course {
        goal: Span::new(0.5, 0.7),
        ..course(1, 0.0)
    };
    let Answer::Plan(plan) = answer(&zone) else {
        panic!()
    };
    // A flat jump takes longer the further it goes; 1e-9 is the solver's.
    assert!((plan.jumps[0].landing - 0.5).abs() < 1e-9, "{plan:?}");
}

#[test]
fn the_same_course_gives_the_same_plan() {
    let boxes = vec![Obstacle {
        center: 0.9,
        width: 0.2,
        height: 0.1,
    }];
    let course = Course {
        obstacles: boxes,
        ..course(3, 1.9)
    };
    assert_eq!(answer(&course), answer(&course));
}
