//! One jump by several routes through the code: closed forms, step by step, eight at a time, with
//! derivatives.

use proptest::prelude::*;
use saltus_lagrangian::{Batch, FINE, Launch, LiftOff, Outcome, Stance, StanceError};
use saltus_numeric::{Dual, Scalar, Single, Width};
use saltus_planner::PLANNING_TOLERANCE;
use saltus_robot::{Drive, GaugePressure, Parameter, Robot};
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
        let dual = with_derivatives(&robot, &launch).expect("a stance");
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

/// One function on the way that is not inlined is compiled for the base: its multiply-adds are
/// calls, and a jump takes forty times as long.
#[test]
fn lanes_are_faster_than_jumps_one_by_one() {
    if !Width::best().fuses() {
        return;
    }
    let robot = Robot::rats_planar();
    let batch = Batch::new(&robot, PLANNING_TOLERANCE);
    let at = |i: i32| Launch::at_firing(3.0 + 0.003 * f64::from(i), -0.1, 0.1);
    let launches: Vec<Launch> = (0..1000).map(at).collect();
    let least = |work: &dyn Fn() -> usize| {
        let time = |_| {
            let start = std::time::Instant::now();
            assert_eq!(std::hint::black_box(work()), launches.len());
            start.elapsed().as_secs_f64()
        };
        (0..7).map(time).fold(f64::INFINITY, f64::min)
    };
    let together = least(&|| batch.jumps(&launches).len());
    let one_by_one = least(&|| {
        launches
            .iter()
            .map(|launch| batch.stance().jump(launch))
            .collect::<Vec<_>>()
            .len()
    });
    assert!(
        together < one_by_one,
        "{together} s, one by one {one_by_one} s"
    );
}

/// Directions: every parameter, then ω_0, φ_0, α_f, t_v.
const DIRECTIONS: usize = Parameter::ALL.len() + 4;
const LAUNCH: usize = Parameter::ALL.len();

fn with_derivatives(
    robot: &Robot,
    launch: &Launch,
) -> Result<LiftOff<Dual<DIRECTIONS>>, StanceError> {
    let lift = |parameter: Parameter, x: f64| {
        let direction = Parameter::ALL
            .iter()
            .position(|p| *p == parameter)
            .expect("every parameter");
        Dual::variable(x, direction)
    };
    let launch = Launch {
        rate: Dual::variable(launch.rate, LAUNCH),
        lean: Dual::variable(launch.lean, LAUNCH + 1),
        firing_angle: Dual::variable(launch.firing_angle, LAUNCH + 2),
        valve_open: Dual::variable(launch.valve_open, LAUNCH + 3),
    };
    Stance::new(robot, lift).jump(&launch)
}

/// `robot` and `launch` with the number of direction `i` changed by `change`.
fn moved(robot: &Robot, launch: &Launch, i: usize, change: f64) -> (Robot, Launch) {
    let (mut robot, mut launch) = (robot.clone(), *launch);
    let ambient = robot.environment.ambient;
    match i.checked_sub(LAUNCH) {
        Some(0) => launch.rate += change,
        Some(1) => launch.lean += change,
        Some(2) => launch.firing_angle += change,
        Some(_) => launch.valve_open += change,
        None => {
            let (body, leg) = (&mut robot.body, &mut robot.leg);
            match (Parameter::ALL[i], &mut leg.drive) {
                (Parameter::Mass, _) => body.mass += change,
                (Parameter::Inertia, _) => body.inertia += change,
                (Parameter::Radius, _) => body.radius += change,
                (Parameter::Gravity, _) => robot.environment.gravity += change,
                (Parameter::Stroke, _) => {
                    leg.stroke += change;
                }
                (Parameter::Delay, _) => leg.delay += change,
                (Parameter::ViscousFriction, _) => leg.viscous_friction += change,
                (Parameter::CoulombFriction, _) => leg.coulomb_friction += change,
                (Parameter::Supply, Drive::Pneumatic(c)) => {
                    c.supply = GaugePressure(c.supply.absolute(ambient).0 + change - ambient.0);
                }
                (Parameter::DeadVolume, Drive::Pneumatic(c)) => c.dead_volume += change,
                (Parameter::ValveArea, Drive::Pneumatic(c)) => {
                    let area = c.valve_area();
                    c.orifice_radius *= ((area + change) / area).sqrt();
                }
                _ => {}
            }
        }
    }
    (robot, launch)
}

/// The number of direction `i` and how far it may be moved for a difference; none where it is at
/// the edge of its domain.
fn width(robot: &Robot, launch: &Launch, i: usize) -> Option<f64> {
    let swing = (robot.environment.gravity / robot.body.radius).sqrt();
    let (x, size) = match i.checked_sub(LAUNCH) {
        Some(0) => (launch.rate, swing),
        Some(1 | 2) => return Some(1e-3),
        Some(_) => (launch.valve_open, stroke_time(robot)),
        None => {
            let x = Parameter::ALL[i].of(robot)?;
            if let (Parameter::Stroke, Drive::Table(table)) = (Parameter::ALL[i], &robot.leg.drive)
            {
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
    let dual = with_derivatives(robot, launch).expect("a stance");
    // What a looser tolerance changes is a bound on what is wrong with an end.
    let rough = stance(robot)
        .with_tolerance(10.0 * FINE)
        .jump(launch)
        .expect("a stance");
    for i in 0..DIRECTIONS {
        let Some(h) = width(robot, launch, i) else {
            continue;
        };
        let ends = [h, -h, 0.5 * h, -0.5 * h].map(|change| {
            let (robot, launch) = moved(robot, launch, i, change);
            stance(&robot).jump(&launch).expect("a stance")
        });
        // Across a change of outcome, and where a robot is fired or without force at once on one
        // side only, there is no derivative.
        let is_pivoting = dual.time_fire.value > 0.0;
        let is_extending = dual.extension.value > 0.0;
        let differs = |end: &LiftOff| {
            end.outcome != dual.outcome
                || (end.time_fire > 0.0) != is_pivoting
                || (end.extension > 0.0) != is_extending
        };
        if ends.iter().any(differs) {
            continue;
        }
        let rows = ends.map(|end| numbers(robot, &end));
        for (k, (name, exact, size)) in numbers(robot, &dual).into_iter().enumerate() {
            let difference = |a: usize, h: f64| (rows[a][k].1 - rows[a + 1][k].1) / (2.0 * h);
            let (coarse, fine) = (difference(0, h), difference(2, 0.5 * h));
            // Richardson's step leaves h⁴; how far the two differences are apart tells how much
            // that is, and whether a kink (a valve that closes just then) lies between.
            let best = fine + (fine - coarse) / 3.0;
            let noise = (numbers(robot, &rough)[k].1 - exact.value).abs() / h;
            let scale = best.abs() + 1e-3 * (size + exact.value.abs()) / h;
            let allowed = noise + 0.1 * (fine - coarse).abs() + digits * scale;
            prop_assert!(
                (exact.slope[i] - best).abs() <= allowed,
                "{} along {}: {} not {} ± {:e}, {:?}",
                name,
                i,
                exact.slope[i],
                best,
                allowed,
                dual.outcome,
            );
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn every_derivative_is_that_of_differences((robot, launch) in jump(any_ordinary())) {
        let dual = with_derivatives(&robot, &launch).expect("a stance");
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
        let dual = with_derivatives(&robot, &launch).expect("a stance");
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
    let stance: Stance<Dual<1>> = Stance::new(&robot, |_, x| Dual::of(x));
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
            .all(|(_, x, _)| x.slope == [0.0]),
        "{end:?}"
    );
}
