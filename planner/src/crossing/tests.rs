//! The box jump of the thesis, and what happens when it cannot be.

use saltus_ballistic::Obstacle as Solid;
use saltus_lagrangian::Launch;
use saltus_robot::Robot;

use super::check::{box_distance, clearance};
use super::roller::NEAR;
use super::*;
use crate::course::{Course, Give, Jumper, Leap, Obstacle, Push, Side, Slope};

/// The 21 cm box of thesis §5.2.3, its middle `center` (m) before the foot.
fn box_jump(center: f64, rate: f64) -> Crossing {
    let course = Course {
        id: "box".into(),
        start: 0.0,
        start_height: 0.0,
        jumps: 1,
        goal: Span::new(0.7, 1.1),
        obstacles: vec![Obstacle {
            center,
            width: 0.21,
            height: 0.21,
        }],
        no_landing: vec![],
    };
    Crossing::new(course, rate)
}

fn planned(crossing: &Crossing) -> CrossingPlan {
    match Planner::new(Robot::rats_planar())
        .cross(crossing)
        .expect("a legal crossing")
    {
        CrossingAnswer::Plan(plan) => plan,
        answer => panic!("{answer:?}"),
    }
}

#[test]
fn boxes_are_cleared_and_the_full_model_agrees() {
    for (center, rate) in [
        (0.42, 5.0),
        (0.46, 5.0),
        (0.4, 5.5),
        (0.48, 5.5),
        (0.44, 6.0),
        (0.5, 6.0),
    ] {
        let plan = planned(&box_jump(center, rate));
        assert!(
            plan.holds(),
            "{center} m at {rate} rad/s: {:#?}",
            plan.checks
        );
        assert!(
            plan.checks
                .iter()
                .any(|c| c.what.starts_with("clearance of obstacle 1"))
        );
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
            let launch = Launch::at_firing(
                5.0,
                -0.1 + 0.004 * f64::from(i),
                0.03 + 0.0005 * f64::from(j),
            );
            let jump = planner.jump(&launch).expect("a legal launch");
            let Some(landing) = jump.distance(0.24) else {
                continue;
            };
            let flight = jump.flight.expect("it lands");
            let gap = clearance(
                &flight,
                &crossing,
                0.24,
                0.24 + jump.stance.extension,
                &solid,
                0.24,
            )
            .expect("it lands");
            if gap >= 0.0 && (0.7..=1.1).contains(&landing) {
                tried += 1;
                let cost = 100.0 * (landing - crossing.target).powi(2) + launch.valve_open.powi(2);
                // The solver stops where a step promises less than 1e-7.
                assert!(
                    cost >= plan.search.cost - 1e-6,
                    "{launch:?}: {cost} < {}",
                    plan.search.cost
                );
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
    let edge = |x, side| course::Edge {
        x,
        top: 0.21,
        obstacle: 0,
        side,
    };
    let edges = vec![edge(0.355, Side::Front), edge(0.565, Side::Back)];
    let beside = vec![edge(0.21, Side::Front)];
    let leap = Leap {
        jump: 0,
        from: 0.0,
        to: 0.0,
        on: [None; 2],
        edges,
        beside,
        push: Push::Any,
    };
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
    assert_eq!(exact.len(), 6);
    for (i, h) in [1e-4, 1e-4, 1e-5].into_iter().enumerate() {
        let shifted = |h: f64| {
            let mut x = at;
            x[i] += h;
            fly(x)
        };
        for ((value, up), down) in exact.iter().zip(shifted(h)).zip(shifted(-h)) {
            let difference = (up.value - down.value) / (2.0 * h);
            // Central differences err by h² times the third derivative, and by the jump's 1e-9 over
            // h.
            let allowed = 2e-4 * value.slope[i].abs().max(1.0);
            assert!(
                (value.slope[i] - difference).abs() < allowed,
                "{i}: {value:?}, {difference}"
            );
        }
    }
}

#[test]
fn friction_and_margins_hold() {
    let mut crossing = box_jump(0.46, 5.0);
    crossing.sigmas = 2.0;
    crossing.clearance = 0.005;
    let free = planned(&crossing);
    assert!(free.holds(), "{:#?}", free.checks);
    let needed = free.jumps[0].friction_needed;
    crossing.friction = Some(1.02 * needed);
    assert!(planned(&crossing).holds());
    // Half of what the jump over this box needs is not enough for any.
    crossing.friction = Some(0.5 * needed);
    let answer = Planner::new(Robot::rats_planar())
        .cross(&crossing)
        .expect("a legal crossing");
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
    assert!(plan.holds(), "{:#?}", plan.checks);
    let first = plan.jumps[0].landing[0];
    assert!((0.7 - 1e-6..=0.8 + 1e-6).contains(&first), "{first}");
    assert_eq!(plan.jumps[1].foot[0], first);
}

/// `crossing` with what has to give moved by as much, and by a little more.
fn given(crossing: &Crossing, gives: &[Give]) -> Crossing {
    let mut nearer = crossing.clone();
    let (course, little) = (&mut nearer.course, 2e-4);
    for give in gives {
        match give.limit {
            Limit::Edge { obstacle, .. } | Limit::Stance { obstacle, .. } => {
                course.obstacles[obstacle].height -= give.amount + little;
            }
            Limit::Goal if give.amount < 0.0 => course.goal.low += give.amount - little,
            Limit::Goal => course.goal.high += give.amount + little,
            limit => panic!("{limit:?}"),
        }
    }
    course.obstacles.retain(|o| o.height > 0.0);
    nearer
}

#[test]
#[ignore = "nightly: 13 s"]
fn the_nearest_course_has_a_plan() {
    let planner = Planner::new(Robot::rats_planar());
    let mut infeasible = 0;
    for (center, height, rate) in boxes_and_rates() {
        let mut crossing = box_jump(center, rate);
        crossing.course.obstacles[0].height = height;
        let CrossingAnswer::Infeasible { relief, .. } =
            planner.cross(&crossing).expect("a legal crossing")
        else {
            continue;
        };
        infeasible += 1;
        assert!(!relief.gives.is_empty(), "{crossing:?}");
        match planner
            .cross(&given(&crossing, &relief.gives))
            .expect("a legal crossing")
        {
            CrossingAnswer::Plan(plan) => {
                assert!(
                    plan.holds(),
                    "{center} {height} {rate}: {relief:?} {:#?}",
                    plan.checks
                );
            }
            answer => panic!("{center} {height} {rate}: {relief:?} {answer:?}"),
        }
    }
    assert!(infeasible > 20, "{infeasible}");
}

/// Places and heights of boxes, and approach rates.
fn boxes_and_rates() -> impl Iterator<Item = (f64, f64, f64)> {
    let heights = |rate, center| [0.05, 0.15, 0.25, 0.35].map(move |height| (center, height, rate));
    let centers = move |rate| {
        [0.205, 0.3, 0.42, 0.46, 0.55]
            .into_iter()
            .flat_map(move |c| heights(rate, c))
    };
    [4.0, 5.0, 6.0].into_iter().flat_map(centers)
}

#[test]
fn the_wheel_s_way_beside_a_box_is_that_of_the_stance() {
    let planner = Planner::new(Robot::rats_planar());
    let crossing = box_jump(0.5, 5.0);
    let roller = Roller::new(&planner, &crossing);
    for (x, top, angle) in [(0.14, 0.05, -0.2), (0.17, 0.1, 0.0), (0.19, 0.15, 0.1)] {
        let beside = vec![course::Edge {
            x,
            top,
            obstacle: 0,
            side: Side::Front,
        }];
        let leap = Leap {
            jump: 0,
            from: 0.0,
            to: 0.0,
            on: [None; 2],
            edges: vec![],
            beside,
            push: Push::Any,
        };
        let gap = |angle: f64| {
            let mut margins = Vec::new();
            let decisions = [Slope::variable(angle, 1), Slope::variable(0.1, 2)];
            roller.fly(&leap, Slope::variable(0.0, 0), decisions, &mut margins);
            margins
                .into_iter()
                .find(|m| matches!(m.limit, Limit::Stance { .. }))
                .expect("a limit")
                .value
        };
        // The stance's own fine steps, without derivatives and without anything between them.
        let trace = planner
            .stance()
            .trace(&crossing.launch(0, [angle, 0.1]))
            .expect("a stance");
        let radius = planner.robot().body.radius;
        let far = Span::new(x, x + 10.0);
        let seen = trace.samples.iter().map(|s| {
            let reach = radius + s.extension;
            box_distance([reach * s.lean.sin(), reach * s.lean.cos()], far, top) - radius
        });
        let (found, seen) = (gap(angle), seen.fold(f64::INFINITY, f64::min));
        assert!(
            seen < NEAR && (found.value - seen).abs() < 2e-5,
            "{x}: {} {seen}",
            found.value
        );
        let step = 1e-5;
        let slope = (gap(angle + step).value - gap(angle - step).value) / (2.0 * step);
        assert!(
            (found.slope[1] - slope).abs() < 1e-3 * (1.0 + slope.abs()),
            "{x}: {found:?} {slope}"
        );
    }
}

#[test]
fn nobody_jumps_through_a_wall() {
    let planner = Planner::new(Robot::rats_planar());
    for height in [0.5, 1.0, 2.0] {
        let mut wall = box_jump(0.46, 5.0);
        wall.course.obstacles[0].height = height;
        let answer = planner.cross(&wall).expect("a legal crossing");
        let CrossingAnswer::Infeasible { relief, .. } = answer else {
            panic!("{answer:?}")
        };
        // The highest box that this robot clears is between 0.21 m and 0.3 m high; before a wall of
        // which both edges would have to sink by more than 0.3 m it is nearer to move the goal to
        // this side, where the wheel's rim stays clear.
        let most = relief
            .gives
            .iter()
            .map(|give| give.amount.abs())
            .fold(0.0, f64::max);
        let sinks = height - 0.3..height - 0.15;
        assert!(
            sinks.contains(&most) || (0.5..0.7).contains(&most),
            "{height}: {relief:?}"
        );
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
    check(
        |c| c.rates.clear(),
        &format!("approach_rate_rad_s (count) = 0: {counts}"),
    );
    check(
        |c| c.rates.push(4.0),
        &format!("approach_rate_rad_s (count) = 2: {counts}"),
    );
    check(
        |c| c.zones = vec![None; 2],
        "land (count) = 2: must be at most one for each jump",
    );
    check(
        |c| c.rates = vec![-1.0],
        "approach_rate_rad_s = -1: must be from 0 to 1000 rad/s",
    );
    check(
        |c| c.firing_angles.high = -1.0,
        "firing_angle_rad = -1: must be above its least value, below pi/2 rad",
    );
    check(
        |c| c.valve_open.low = 0.0,
        "valve_open_s = 0: must be above 0, to 10 s",
    );
    check(
        |c| c.friction = Some(f64::NAN),
        "friction_coefficient = NaN: must be 0 or above",
    );
    check(
        |c| c.target = f64::INFINITY,
        "target_x_m = inf: must be from -10000 to 10000 m",
    );
    check(
        |c| c.zones = vec![Some(Span::new(1.0, 0.5))],
        "land.to_x_m = 0.5: must be finite and not before its from_x_m",
    );
    check(
        |c| c.course.jumps = 0,
        "course `box`: jumps = 0, allowed: 1 to 12",
    );
}

/// Numbers from 0 to 1, always the same.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// A course of `jumps` jumps of about 0.6 m over low boxes, with a ditch before the goal.
fn random_course(random: &mut Random, jumps: usize) -> Crossing {
    let length = 0.6 * jumps as f64;
    let boxes = 1 + jumps / 2;
    let obstacles = (0..boxes).map(|i| {
        let center = length * (i as f64 + random.between(0.35, 0.65)) / boxes as f64;
        Obstacle {
            center,
            width: random.between(0.03, 0.12),
            height: random.between(0.03, 0.15),
        }
    });
    let course = Course {
        id: "random".into(),
        start: 0.0,
        start_height: 0.0,
        jumps,
        goal: Span::new(length - 0.15, length + 0.25),
        obstacles: obstacles.collect(),
        no_landing: vec![Span::new(length - 0.35, length - 0.2)],
    };
    Crossing {
        clearance: 0.01,
        ..Crossing::new(course, random.between(4.5, 6.0))
    }
}

#[test]
#[ignore = "nightly: 20 s"]
fn the_search_finds_what_trying_every_sequence_of_grounds_finds() {
    let planner = Planner::new(Robot::rats_planar());
    let mut random = Random(1);
    let (mut plans, mut none) = (0, 0);
    for number in 0..6 {
        let crossing = random_course(&mut random, 1 + number % 3);
        let settings = settings(&crossing);
        let all = course::exhaustive::least_cost(
            &Roller::new(&planner, &crossing),
            &crossing.course,
            &settings,
        );
        match (all, planner.cross(&crossing).expect("a legal crossing")) {
            (Some(least), CrossingAnswer::Plan(plan)) => {
                plans += 1;
                // The gap, and where both stop.
                assert!(
                    plan.search.cost <= least + 6e-5,
                    "{number}: {} {least}",
                    plan.search.cost
                );
                assert!(
                    plan.search.bound <= least + 6e-5,
                    "{number}: {} {least}",
                    plan.search.bound
                );
                assert!(plan.holds(), "{number}: {:#?}", plan.checks);
            }
            (None, _) => none += 1,
            (Some(least), answer) => panic!("{number}: {least}, {answer:?}"),
        }
    }
    assert!(plans >= 4 && plans + none == 6, "{plans} {none}");
}

#[test]
fn twelve_jumps_are_planned_within_the_limits_and_the_gap_is_stated() {
    let planner = Planner::new(Robot::rats_planar());
    let crossing = random_course(&mut Random(3), 12);
    let CrossingAnswer::Plan(plan) = planner.cross(&crossing).expect("a legal crossing") else {
        panic!()
    };
    assert!(plan.holds(), "{:#?}", plan.checks);
    let search = &plan.search;
    assert!(
        search.bound <= search.cost && 12 * search.solves <= WORK + 12,
        "{search:?}"
    );
    assert!(
        search.complete || search.cost - search.bound > 5e-5,
        "{search:?}"
    );
}

#[test]
fn a_search_that_is_stopped_gives_the_best_plan_so_far() {
    let planner = Planner::new(Robot::rats_planar());
    let crossing = random_course(&mut Random(3), 6);
    let stop = |standing: &course::Standing| {
        if standing.gap.is_finite() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let answer = planner
        .cross_watched(&crossing, &stop)
        .expect("a legal crossing");
    let CrossingAnswer::Plan(plan) = answer else {
        panic!("{answer:?}")
    };
    assert!(
        !plan.search.complete && plan.search.bound < plan.search.cost,
        "{:?}",
        plan.search
    );
}

#[test]
fn a_landing_keeps_from_the_ends_of_its_ground_by_default() {
    // The target is in the ditch: the plan would land on its edge.
    let mut ditch = box_jump(2.0, 5.0);
    ditch.course.obstacles.clear();
    ditch.course.goal = Span::new(0.3, 1.2);
    ditch.course.no_landing = vec![Span::new(0.7, 0.9)];
    ditch.target = 0.8;
    let plan = planned(&ditch);
    let (landing, deviation) = (plan.jumps[0].landing[0], plan.jumps[0].deviation);
    let away = (landing - 0.7).abs().min((landing - 0.9).abs());
    assert!(
        deviation > 0.0 && away >= EDGE_MARGIN + MARGIN_SIGMAS * deviation - 1e-6,
        "{landing} {deviation}"
    );
    let mut robot = Robot::rats_planar();
    robot.errors = saltus_robot::Errors::default();
    let CrossingAnswer::Plan(plan) = Planner::new(robot).cross(&ditch).expect("a legal crossing")
    else {
        panic!()
    };
    let landing = plan.jumps[0].landing[0];
    assert!(
        (landing - 0.7).abs().min((landing - 0.9).abs()) >= EDGE_MARGIN - 1e-6,
        "{landing}"
    );
}

#[test]
fn a_wall_beside_the_landing_is_not_touched() {
    // What was planned once: a landing at the foot of a wall ten metres high, with the wheel in it.
    let mut wall = box_jump(0.505, 5.0);
    wall.course.goal = Span::new(-1e4, 1e4);
    wall.target = 0.8;
    wall.course.obstacles[0].height = 10.0;
    let answer = Planner::new(Robot::rats_planar())
        .cross(&wall)
        .expect("a legal crossing");
    match answer {
        CrossingAnswer::Plan(plan) => {
            assert!(
                plan.holds() && plan.jumps[0].landing[0] <= 0.4 - 0.24,
                "{:#?}",
                plan.checks
            );
        }
        CrossingAnswer::Infeasible { .. } => {}
        CrossingAnswer::Undecided { .. } => panic!("{answer:?}"),
    }
    // One under the wheel at the start is the reason that is given.
    let mut under = box_jump(0.205, 5.0);
    under.course.obstacles[0].height = 0.1;
    let answer = Planner::new(Robot::rats_planar())
        .cross(&under)
        .expect("a legal crossing");
    let CrossingAnswer::Infeasible { relief, .. } = answer else {
        panic!("{answer:?}")
    };
    assert!(
        relief
            .gives
            .iter()
            .any(|g| matches!(g.limit, Limit::Stance { obstacle: 0, .. })),
        "{relief:?}"
    );
}

#[test]
fn a_goal_for_two_jumps_is_said_to_take_two() {
    let mut far = box_jump(0.5, 5.0);
    far.course.obstacles.clear();
    far.course.goal = Span::new(1.6, 1.9);
    far.target = 1.7;
    let answer = Planner::new(Robot::rats_planar())
        .cross(&far)
        .expect("a legal crossing");
    let CrossingAnswer::Infeasible { relief, jumps } = answer else {
        panic!("{answer:?}")
    };
    assert_eq!(jumps, Some(2), "{relief:?}");
    far.course.jumps = 2;
    assert!(planned(&far).holds());
}

#[test]
fn a_wish_does_not_make_a_goal_infeasible() {
    // Each of these goals is reached from open ground, wherever in it or beside it the landing
    // should be.
    for rate in [3.5, 4.0, 5.0, 6.0] {
        for i in 0..4 {
            for target in [0.3, 0.6, 0.9, 1.2] {
                let mut open = box_jump(0.5, rate);
                open.course.obstacles.clear();
                open.course.goal =
                    Span::new(0.33 + 0.12 * f64::from(i), 0.53 + 0.12 * f64::from(i));
                open.target = target;
                assert!(
                    planned(&open).holds(),
                    "{rate} rad/s, {:?}, {target} m",
                    open.course.goal
                );
            }
        }
    }
}

#[test]
fn a_friction_that_the_first_try_exceeds_is_kept() {
    let mut ditch = box_jump(0.5, 4.0);
    ditch.course.obstacles.clear();
    ditch.course.goal = Span::new(0.515, 0.565);
    ditch.course.no_landing = vec![Span::new(0.49, 0.54)];
    (ditch.target, ditch.sigmas, ditch.friction) = (0.54, 0.0, Some(0.8));
    assert!(planned(&ditch).holds());
}

#[test]
fn an_exact_goal_keeps_no_margin() {
    let mut point = box_jump(0.5, 5.0);
    point.course.obstacles.clear();
    point.course.goal = Span::point(0.9);
    point.target = 0.9;
    let plan = planned(&point);
    assert!(
        plan.holds() && (plan.jumps[0].landing[0] - 0.9).abs() < 1e-6,
        "{:?}",
        plan.jumps
    );
    point.course.goal = Span::point(1.2);
    let answer = Planner::new(Robot::rats_planar())
        .cross(&point)
        .expect("a legal crossing");
    let CrossingAnswer::Infeasible { relief, .. } = answer else {
        panic!("{answer:?}")
    };
    assert!(
        relief.gives.len() == 1 && relief.gives[0].amount < 0.0,
        "{relief:?}"
    );
}

#[test]
fn a_roll_stays_on_the_box_that_was_landed_on() {
    let mut narrow = box_jump(0.605, 4.5);
    narrow.course.obstacles[0] = Obstacle {
        center: 0.65,
        width: 0.3,
        height: 0.1,
    };
    narrow.course.jumps = 2;
    narrow.course.goal = Span::new(-1e4, 1e4);
    (narrow.roll, narrow.target, narrow.sigmas) = (0.1, 1.5, 0.0);
    let plan = planned(&narrow);
    let [foot, height] = plan.jumps[1].foot;
    assert!(
        height == 0.0 || (0.5..=0.8).contains(&foot),
        "{:?}",
        plan.jumps[1]
    );
    narrow.zones = vec![Some(Span::new(0.5, 0.8))];
    let [foot, height] = planned(&narrow).jumps[1].foot;
    assert!(
        height == 0.1 && (0.5..=0.8).contains(&foot),
        "{foot} {height}"
    );
}
