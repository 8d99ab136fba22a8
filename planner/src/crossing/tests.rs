//! The box jump of the thesis, and what happens when it cannot be.

use saltus_robot::Robot;

use super::*;
use crate::course::{Obstacle, Side};

/// The 21 cm box of thesis §5.2.3, its middle `center` (m) before the foot.
fn box_jump(center: f64, rate: f64) -> Crossing {
    let course = Course {
        id: "box".into(),
        start: 0.0,
        start_height: 0.0,
        jumps: 1,
        goal: Span::new(0.7, 1.1),
        obstacles: vec![Obstacle { center, width: 0.21, height: 0.21 }],
        no_landing: vec![],
    };
    Crossing::new(course, rate)
}

fn planned(crossing: &Crossing) -> CrossingPlan {
    match Planner::new(Robot::rats_planar()).cross(crossing).expect("a legal crossing") {
        CrossingAnswer::Plan(plan) => plan,
        answer => panic!("{answer:?}"),
    }
}

#[test]
fn boxes_are_cleared_and_the_full_model_agrees() {
    for (center, rate) in [(0.42, 5.0), (0.46, 5.0), (0.4, 5.5), (0.48, 5.5), (0.44, 6.0), (0.5, 6.0)] {
        let plan = planned(&box_jump(center, rate));
        assert!(plan.is_verified(), "{center} m at {rate} rad/s: {:#?}", plan.checks);
        assert!(plan.checks.iter().any(|c| c.what.starts_with("clearance of obstacle 1")));
    }
}

#[test]
fn no_sampled_jump_is_cheaper_than_the_plan() {
    let crossing = box_jump(0.46, 5.0);
    let plan = planned(&crossing);
    let planner = Planner::new(Robot::rats_planar());
    let solid = Solid::block([0.355, 0.0], [0.565, 0.21]).expect("a box");
    let mut tried = 0;
    for i in 0..60 {
        for j in 0..40 {
            let launch = Launch::at_firing(5.0, -0.1 + 0.004 * f64::from(i), 0.03 + 0.0005 * f64::from(j));
            let jump = planner.jump(&launch).expect("a legal launch");
            let Some(landing) = jump.distance(0.24) else { continue };
            let flight = jump.flight.expect("it lands");
            let gap = clearance(&flight, &crossing, 0.24, jump.stance.reach, &solid, 0.24).expect("it lands");
            if gap >= 0.0 && (0.7..=1.1).contains(&landing) {
                tried += 1;
                let cost = 100.0 * (landing - crossing.target).powi(2) + launch.valve_open.powi(2);
                // The solver stops where a step promises less than 1e-7.
                assert!(cost >= plan.search.cost - 1e-6, "{launch:?}: {cost} < {}", plan.search.cost);
            }
        }
    }
    assert!(tried > 100, "{tried}");
}

#[test]
fn derivatives_of_landing_and_margins_match_differences() {
    let mut crossing = box_jump(0.46, 5.0);
    crossing.friction = Some(0.8);
    crossing.leg_out = 0.01;
    let planner = Planner::new(Robot::rats_planar());
    let roller = Roller::new(&planner, &crossing);
    let edge = |x, side| course::Edge { x, top: 0.21, obstacle: 0, side };
    let edges = vec![edge(0.355, Side::Front), edge(0.565, Side::Back)];
    let leap = Leap { jump: 0, from: 0.0, to: 0.0, edges };
    let fly = |x: [f64; 3]| {
        let mut margins = Vec::new();
        let [foot, angle, open] = std::array::from_fn(|i| Slope::variable(x[i], i));
        let flight = roller.fly(&leap, foot, [angle, open], &mut margins);
        let mut all = vec![flight.landing, flight.cost];
        all.extend(margins.iter().map(|m| m.value));
        all
    };
    let at = [0.01, 0.02, 0.045];
    let exact = fly(at);
    assert_eq!(exact.len(), 5);
    for (i, h) in [1e-4, 1e-4, 1e-5].into_iter().enumerate() {
        let shifted = |h: f64| {
            let mut x = at;
            x[i] += h;
            fly(x)
        };
        for ((value, up), down) in exact.iter().zip(shifted(h)).zip(shifted(-h)) {
            let difference = (up.value - down.value) / (2.0 * h);
            // Central differences err by h² times the third derivative, and by the jump's 1e-9 over h.
            let allowed = 2e-4 * value.slope[i].abs().max(1.0);
            assert!((value.slope[i] - difference).abs() < allowed, "{i}: {value:?}, {difference}");
        }
    }
}

#[test]
fn friction_and_margins_hold() {
    let mut crossing = box_jump(0.46, 5.0);
    crossing.sigmas = 2.0;
    crossing.clearance = 0.005;
    let free = planned(&crossing);
    assert!(free.is_verified(), "{:#?}", free.checks);
    let needed = free.jumps[0].friction_needed;
    crossing.friction = Some(1.02 * needed);
    assert!(planned(&crossing).is_verified());
    // Half of what the jump over this box needs is not enough for any.
    crossing.friction = Some(0.5 * needed);
    let answer = Planner::new(Robot::rats_planar()).cross(&crossing).expect("a legal crossing");
    assert!(!matches!(answer, CrossingAnswer::Plan(_)), "{answer:?}");
}

#[test]
fn two_jumps_land_where_they_may() {
    let mut crossing = box_jump(1.2, 5.0);
    crossing.course.jumps = 2;
    crossing.course.goal = Span::new(1.5, 1.7);
    crossing.course.no_landing = vec![Span::new(0.5, 0.7)];
    crossing.zones = vec![Some(Span::new(0.6, 0.8)), None];
    crossing.target = 1.6;
    let plan = planned(&crossing);
    assert!(plan.is_verified(), "{:#?}", plan.checks);
    let first = plan.jumps[0].landing[0];
    assert!((0.7 - 1e-6..=0.8 + 1e-6).contains(&first), "{first}");
    assert_eq!(plan.jumps[1].foot[0], first);
}

#[test]
fn a_box_too_far_is_answered_with_the_nearest_course() {
    let answer = Planner::new(Robot::rats_planar()).cross(&box_jump(0.46, 4.0)).expect("a legal crossing");
    let CrossingAnswer::Infeasible(relief) = answer else { panic!("{answer:?}") };
    assert!(relief.total > 0.01 && relief.total < 0.05, "{relief:?}");
    // With the box lower by what is said, and a little, there is a plan.
    let mut lower = box_jump(0.46, 4.0);
    lower.course.obstacles[0].height -= 1.05 * relief.total;
    assert!(planned(&lower).is_verified());
}

#[test]
fn nobody_jumps_through_a_wall() {
    let planner = Planner::new(Robot::rats_planar());
    for height in [0.5, 1.0, 2.0] {
        let mut wall = box_jump(0.46, 5.0);
        wall.course.obstacles[0].height = height;
        let answer = planner.cross(&wall).expect("a legal crossing");
        let CrossingAnswer::Infeasible(relief) = answer else { panic!("{answer:?}") };
        // The highest box that this robot clears is between 0.21 m and 0.3 m high; before a wall that would have to sink
        // by more than 0.35 m it is nearer to move the goal to this side.
        let sinks = height - 0.3..height - 0.15;
        assert!(sinks.contains(&relief.total) || (0.3..0.4).contains(&relief.total), "{height}: {relief:?}");
    }
}

#[test]
fn bad_crossings_are_refused() {
    let planner = Planner::new(Robot::rats_planar());
    let check = |spoil: fn(&mut Crossing), message: &str| {
        let mut crossing = box_jump(0.46, 5.0);
        spoil(&mut crossing);
        let error = planner.cross(&crossing).expect_err(message);
        assert_eq!(error.to_string(), message);
    };
    let counts = "must be 1, or as many as there are jumps";
    check(|c| c.rates.clear(), &format!("approach_rate_rad_s (count) = 0: {counts}"));
    check(|c| c.rates.push(4.0), &format!("approach_rate_rad_s (count) = 2: {counts}"));
    check(|c| c.zones = vec![None; 2], "land (count) = 2: must be at most one for each jump");
    check(|c| c.rates = vec![-1.0], "approach_rate_rad_s = -1: must be from 0 to 1000 rad/s");
    check(
        |c| c.firing_angles.high = -1.0,
        "firing_angle_rad = -1: must be above its least value, below pi/2 rad",
    );
    check(|c| c.valve_open.low = 0.0, "valve_open_s = 0: must be above 0, to 1000 s");
    check(|c| c.friction = Some(f64::NAN), "friction_coefficient = NaN: must be 0 or above");
    check(|c| c.target = f64::INFINITY, "target_x_m = inf: must be from -10000 to 10000 m");
    check(
        |c| c.zones = vec![Some(Span::new(1.0, 0.5))],
        "land.to_x_m = 0.5: must be finite and not before its from_x_m",
    );
    check(|c| c.course.jumps = 0, "course `box`: jumps = 0, allowed: 1 to 12");
}
