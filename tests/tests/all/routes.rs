//! One jump by several routes through the code: closed forms, step by step, eight at a time, with
//! derivatives.

use proptest::prelude::*;
use saltus_lagrangian::{Batch, FINE, Launch, LiftOff, Outcome, Stance, StanceError};
use saltus_numeric::{Dual, Scalar, Single, Width};
use saltus_planner::PLANNING_TOLERANCE;
use saltus_robot::terms::Plane;
use saltus_robot::{Drive, Robot, Term};
use saltus_tests::robots::{
    Kind, any_launch, any_ordinary, cases, jump, launch, on_boom, ordinary, stroke_time,
};

fn stance(robot: &Robot) -> Stance<f64> {
    Stance::new(robot, |_, x| x)
}

/// What a stance gives, with about how large each number is.
fn numbers<S: Single>(robot: &Robot, end: &LiftOff<S>) -> [(&'static str, S, f64); 6] {
    let time = stroke_time(robot);
    let swing = (robot.environment.gravity / robot.body.radius).sqrt();
    [
        ("time", end.time, time),
        ("lean", end.lean, 1.0),
        ("rate", end.rate, swing),
        ("extension", end.extension, robot.leg.stroke),
        (
            "extension rate",
            end.extension_rate,
            robot.leg.stroke / time,
        ),
        ("pressure", end.pressure, robot.environment.ambient.0),
    ]
}

/// `a` and `b` are the same end, but for `error` of each number.
fn agree(robot: &Robot, a: &LiftOff, b: &LiftOff, error: f64) -> Result<(), TestCaseError> {
    prop_assert_eq!(a.outcome, b.outcome, "{:?} {:?}", a, b);
    for ((name, x, size), (_, y, _)) in numbers(robot, a).into_iter().zip(numbers(robot, b)) {
        prop_assert!(
            (x - y).abs() <= error * (size + y.abs()),
            "{}: {} {}",
            name,
            x,
            y
        );
    }
    Ok(())
}

/// The same answer to the bit, or the same error; numbers that are none are alike.
fn same(
    a: &Result<LiftOff, StanceError>,
    b: &Result<LiftOff, StanceError>,
) -> Result<(), TestCaseError> {
    prop_assert_eq!(format!("{a:?}"), format!("{b:?}"));
    Ok(())
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn closed_forms_are_the_steps((robot, launch) in jump(any_ordinary())) {
        let stance = stance(&robot);
        let (jump, trace) = (stance.jump(&launch).expect("a stance"), stance.trace(&launch).expect("a stance"));
        // Both are right to ten digits at this tolerance; a hundredth of it is left to the least
        // robots.
        agree(&robot, &jump, &trace.lift_off, 1e-9)?;
    }

    #[test]
    fn a_dual_has_the_value_of_a_plain_number((robot, launch) in jump(any_ordinary())) {
        let plain = stance(&robot).jump(&launch).expect("a stance");
        let dual = with_derivative(&robot, &launch, Direction::Rate).expect("a stance");
        prop_assert_eq!(plain.outcome, dual.outcome);
        for ((name, x, _), (_, y, _)) in numbers(&robot, &plain).into_iter().zip(numbers(&robot, &dual)) {
            // The same operations in the same order: the same bits.
            prop_assert_eq!(x.to_bits(), y.value.to_bits(), "{}: {} {}", name, x, y.value);
        }
    }

    #[test]
    fn eight_at_a_time_is_one_at_a_time(
        (robot, launches) in prop_oneof![3 => ordinary(Kind::Plain).boxed(), 1 => any_ordinary().boxed()]
            .prop_flat_map(|robot| {
                let some = prop_oneof![9 => launch(&robot).boxed(), 1 => any_launch().boxed()];
                (Just(robot), prop::collection::vec(some, 1..30))
            }),
    ) {
        for (tolerance, error) in [(FINE, 1e-9), (PLANNING_TOLERANCE, 1e-6)] {
            let batch = Batch::new(&robot, tolerance);
            for (end, launch) in batch.jumps(&launches).iter().zip(&launches) {
                match (end, batch.stance().jump(launch)) {
                    // Steps of another length: within the tolerance a step, over some tens of
                    // steps.
                    (Ok(end), Ok(alone)) => agree(&robot, end, &alone, error)?,
                    (end, alone) => same(end, &alone)?,
                }
            }
        }
    }

    #[test]
    fn company_does_not_matter(
        (robot, launches) in ordinary(Kind::Plain).prop_flat_map(|robot| {
            let some = launch(&robot);
            (Just(robot), prop::collection::vec(some, 1..30))
        }),
        from in any::<prop::sample::Index>(),
    ) {
        let batch = Batch::new(&robot, PLANNING_TOLERANCE);
        let together = batch.jumps(&launches);
        let reversed: Vec<Launch> = launches.iter().rev().copied().collect();
        for (a, b) in together.iter().zip(batch.jumps(&reversed).iter().rev()) {
            same(a, b)?;
        }
        let from = from.index(launches.len());
        for (a, b) in together[from..].iter().zip(&batch.jumps(&launches[from..])) {
            same(a, b)?;
        }
        same(&together[from], &batch.jumps(&launches[from..=from])[0])?;
    }
}

proptest! {
    #![proptest_config(cases(60))]

    /// Registers of other widths give the same bits, and a processor without fused multiply-add
    /// flies each jump by itself.
    #[test]
    fn the_width_of_registers_does_not_matter(
        (robot, launches) in ordinary(Kind::Plain).prop_flat_map(|robot| {
            let some = launch(&robot);
            (Just(robot), prop::collection::vec(some, 1..30))
        }),
    ) {
        let batch = |width| Batch::new(&robot, PLANNING_TOLERANCE).with_width(width);
        let here = Width::ALL.into_iter().filter(|width| width.is_here());
        let [one_by_one, fused] = [false, true].map(|fuses| {
            let widths = here.clone().filter(|width| width.fuses() == fuses);
            widths.map(|width| batch(width).jumps(&launches)).collect::<Vec<_>>()
        });
        for ends in fused.windows(2) {
            for (a, b) in ends[0].iter().zip(&ends[1]) {
                same(a, b)?;
            }
        }
        for ends in one_by_one {
            for (end, launch) in ends.iter().zip(&launches) {
                same(end, &batch(Width::Base).stance().jump(launch))?;
            }
        }
    }
}

/// What a jump is differentiated by.
#[derive(Clone, Copy, Debug)]
enum Direction {
    Term(Term),
    Rate,
    Lean,
    FiringAngle,
    ValveOpen,
}

/// The launch, and the terms that a stance carries derivatives by: those of the planar model but the
/// constants of the gas, and drag, which the flight has.
fn directions() -> Vec<Direction> {
    let is_carried = |term: &Term| {
        let spec = term.spec();
        let has_equation = !matches!(spec.section(), "errors" | "leg.gas");
        has_equation && spec.plane == Plane::In && *term != Term::Drag
    };
    let terms = Term::ALL.iter().copied().filter(is_carried);
    let launch = [
        Direction::Rate,
        Direction::Lean,
        Direction::FiringAngle,
        Direction::ValveOpen,
    ];
    terms.map(Direction::Term).chain(launch).collect()
}

fn with_derivative(
    robot: &Robot,
    launch: &Launch,
    by: Direction,
) -> Result<LiftOff<Dual<2>>, StanceError> {
    let lift = |term: Term, x: f64| match by {
        Direction::Term(other) if other == term => Dual::variable(x, 0),
        _ => Dual::of(x),
    };
    let mut lifted = Launch {
        rate: Dual::of(launch.rate),
        lean: Dual::of(launch.lean),
        firing_angle: Dual::of(launch.firing_angle),
        valve_open: Dual::of(launch.valve_open),
    };
    match by {
        Direction::Term(_) => {}
        Direction::Rate => lifted.rate = Dual::variable(launch.rate, 0),
        Direction::Lean => lifted.lean = Dual::variable(launch.lean, 0),
        Direction::FiringAngle => lifted.firing_angle = Dual::variable(launch.firing_angle, 0),
        Direction::ValveOpen => lifted.valve_open = Dual::variable(launch.valve_open, 0),
    }
    Stance::<Dual<2>>::new(robot, lift).jump(&lifted)
}

/// `robot` and `launch` with the number of a direction changed by `change`.
fn moved(robot: &Robot, launch: &Launch, by: Direction, change: f64) -> (Robot, Launch) {
    let (mut robot, mut launch) = (robot.clone(), *launch);
    match by {
        Direction::Rate => launch.rate += change,
        Direction::Lean => launch.lean += change,
        Direction::FiringAngle => launch.firing_angle += change,
        Direction::ValveOpen => launch.valve_open += change,
        Direction::Term(term) => {
            if let Some(x) = term.of(&robot) {
                term.set(&mut robot, x + change);
            }
        }
    }
    (robot, launch)
}

/// How far the number of a direction may be moved for a difference; none where it is at the edge of
/// its domain.
fn width(robot: &Robot, launch: &Launch, by: Direction) -> Option<f64> {
    let swing = (robot.environment.gravity / robot.body.radius).sqrt();
    let (x, size) = match by {
        Direction::Rate => (launch.rate, swing),
        Direction::Lean | Direction::FiringAngle => return Some(1e-3),
        Direction::ValveOpen => (launch.valve_open, stroke_time(robot)),
        Direction::Term(term) => {
            let x = term.of(robot)?;
            if let (Term::Stroke, Drive::Table(table)) = (term, &robot.leg.drive) {
                // Beyond its last extension a table goes on with a kink.
                table.extensions.last().filter(|last| **last > 1.002 * x)?;
            }
            (x, x)
        }
    };
    (x > 2e-3 * size).then_some(1e-3 * size)
}

/// Every derivative of the jump is that of differences, to `digits` of the number.
fn check_derivatives(robot: &Robot, launch: &Launch, digits: f64) -> Result<(), TestCaseError> {
    // What a looser tolerance changes is a bound on what is wrong with an end.
    let rough = stance(robot)
        .with_tolerance(10.0 * FINE)
        .jump(launch)
        .expect("a stance");
    for by in directions() {
        let Some(h) = width(robot, launch, by) else {
            continue;
        };
        let dual = with_derivative(robot, launch, by).expect("a stance");
        let wide = check_derivative(robot, launch, by, &dual, &rough, h, digits);
        // A kink within the difference, such as a flow that turns subsonic, is outside a narrow one.
        if wide.is_err() {
            check_derivative(robot, launch, by, &dual, &rough, h / 32.0, digits)?;
        }
    }
    Ok(())
}

/// The derivative `dual` of the jump in one direction is that of a difference of `h` to each side;
/// `rough` is the jump to a looser tolerance.
fn check_derivative(
    robot: &Robot,
    launch: &Launch,
    by: Direction,
    dual: &LiftOff<Dual<2>>,
    rough: &LiftOff,
    h: f64,
    digits: f64,
) -> Result<(), TestCaseError> {
    let ends = [h, -h, 0.5 * h, -0.5 * h].map(|change| {
        let (robot, launch) = moved(robot, launch, by, change);
        stance(&robot).jump(&launch).expect("a stance")
    });
    // Across a change of outcome, and where a robot is fired or without force at once on one side
    // only, there is no derivative.
    let is_pivoting = dual.time_fire.value > 0.0;
    let is_extending = dual.extension.value > 0.0;
    let differs = |end: &LiftOff| {
        end.outcome != dual.outcome
            || (end.time_fire > 0.0) != is_pivoting
            || (end.extension > 0.0) != is_extending
    };
    if ends.iter().any(differs) {
        return Ok(());
    }
    let rows = ends.map(|end| numbers(robot, &end));
    for (k, (name, exact, size)) in numbers(robot, dual).into_iter().enumerate() {
        let difference = |a: usize, h: f64| (rows[a][k].1 - rows[a + 1][k].1) / (2.0 * h);
        let (coarse, fine) = (difference(0, h), difference(2, 0.5 * h));
        // Richardson's step leaves h⁴; how far the two differences are apart tells how much that
        // is, and whether a kink (a valve that closes just then) lies between.
        let best = fine + (fine - coarse) / 3.0;
        let noise = (numbers(robot, rough)[k].1 - exact.value).abs() / h;
        let scale = best.abs() + 1e-3 * (size + exact.value.abs()) / h;
        let allowed = noise + 0.1 * (fine - coarse).abs() + digits * scale;
        let slope = exact.slope[0];
        prop_assert!(
            (slope - best).abs() <= allowed,
            "{name} along {by:?}: {slope} not {best} ± {allowed:e}, {:?}",
            dual.outcome,
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn every_derivative_is_that_of_differences((robot, launch) in jump(any_ordinary())) {
        let dual = with_derivative(&robot, &launch, Direction::Rate).expect("a stance");
        // Where the ground lets go early, or the robot stalls, there is no jump to differentiate.
        prop_assume!(dual.outcome.is_jump());
        // The steps serve the state; its derivatives ride along, and lose some digits where a leg
        // without friction bounces on its gas. Where it is out of force only as the pressure comes
        // down to the ambient one, the orifice's law has the infinite slope of a square root, and
        // two digits are left.
        let gauge = (dual.pressure.value / robot.environment.ambient.0 - 1.0).abs();
        let at_root = dual.outcome == Outcome::Force && gauge < 1e-3;
        check_derivatives(&robot, &launch, if at_root { 1e-2 } else { 1e-4 })?;
    }
}

proptest! {
    #![proptest_config(cases(100))]

    #[test]
    fn on_a_boom_all_routes_are_one((robot, launch) in jump(on_boom(any_ordinary()))) {
        let plain = stance(&robot).jump(&launch).expect("a stance");
        // The tolerances of the tests above.
        agree(&robot, &plain, &stance(&robot).trace(&launch).expect("a stance").lift_off, 1e-9)?;
        for end in Batch::new(&robot, FINE).jumps(&[launch; 9]) {
            agree(&robot, &end.expect("a stance"), &plain, 1e-9)?;
        }
        let dual = with_derivative(&robot, &launch, Direction::Rate).expect("a stance");
        for ((name, x, _), (_, y, _)) in numbers(&robot, &plain).into_iter().zip(numbers(&robot, &dual)) {
            prop_assert_eq!(x.to_bits(), y.value.to_bits(), "{}: {} {}", name, x, y.value);
        }
        if plain.outcome.is_jump() {
            let gauge = (plain.pressure / robot.environment.ambient.0 - 1.0).abs();
            let at_root = plain.outcome == Outcome::Force && gauge < 1e-3;
            check_derivatives(&robot, &launch, if at_root { 1e-2 } else { 1e-4 })?;
        }
    }
}

#[test]
fn every_derivative_of_the_built_in_robots() {
    for name in Robot::builtin_names() {
        let robot = Robot::builtin(name).expect("built in");
        for (rate, lean, angle, valve_open) in [
            (3.0, -0.25, -0.1, 0.1),
            (4.0, -0.3, -0.15, 0.03),
            (5.0, -0.1, -0.1, 0.1),
            (2.0, 0.1, 0.2, 0.05),
        ] {
            let launch = Launch {
                rate,
                lean,
                firing_angle: angle,
                valve_open,
            };
            // Round-off of 1e-11 over the width of 1e-3.
            check_derivatives(&robot, &launch, 1e-7)
                .unwrap_or_else(|error| panic!("{name}, {launch:?}: {error}"));
        }
    }
}

#[test]
fn a_constant_has_no_derivative() {
    let robot = Robot::rats_planar();
    let stance: Stance<Dual<2>> = Stance::new(&robot, |_, x| Dual::of(x));
    let of = Dual::of;
    let launch = Launch {
        rate: of(5.0),
        lean: of(-0.3),
        firing_angle: of(-0.1),
        valve_open: of(0.1),
    };
    let end = stance.jump(&launch).expect("a stance");
    assert!(
        numbers(&robot, &end)
            .iter()
            .all(|(_, x, _)| x.slope == [0.0; 2]),
        "{end:?}"
    );
}
