//! The model's named terms: off they are not there, on they act as named, and as an independent
//! integrator has them.

use proptest::prelude::*;
use saltus_ballistic::{DragFlight, Flight};
use saltus_lagrangian::{Batch, Launch, LiftOff, Outcome, Stance};
use saltus_robot::{Cushion, Cylinder, Drive, ExhaustPort, Gas, ReturnSpring, Robot};
use saltus_tests::oracle::solve_twice;
use saltus_tests::robots::{Kind, any_ordinary, cases, jump, on_boom, ordinary, stroke_time};

fn stance(robot: &Robot) -> Stance<f64> {
    Stance::new(robot, |_, x| x)
}

/// The thesis' robot with something changed.
fn rats(change: impl FnOnce(&mut Robot)) -> Robot {
    let mut robot = Robot::rats_planar();
    change(&mut robot);
    robot
}

fn cylinder(robot: &mut Robot) -> &mut Cylinder {
    let Drive::Pneumatic(cylinder) = &mut robot.leg.drive else {
        unreachable!("rats-planar is pneumatic")
    };
    cylinder
}

fn hop(robot: &Robot) -> LiftOff {
    stance(robot)
        .jump(&Launch::at_firing(0.0, 0.0, 0.1))
        .expect("a stance")
}

fn apex(robot: &Robot) -> f64 {
    let end = hop(robot);
    assert!(end.outcome.is_jump());
    end.axle[1] + end.axle_rates[1].powi(2) / (2.0 * robot.environment.gravity)
}

/// The stance of `robot` after `launch` is what the oracle finds.
fn check_stance(robot: &Robot, launch: &Launch) -> Result<(), TestCaseError> {
    // Ten thousand steps a stroke: then the fourth-order method is right to about 1e-9, kinks
    // within a step included.
    let step = 1e-4 * stroke_time(robot);
    let (expected, moved) = solve_twice(robot, launch, step);
    let trace = stance(robot).trace(launch).expect("a stance");
    let end = stance(robot).jump(launch).expect("a stance");
    prop_assert_eq!(
        end.outcome.name(),
        expected.outcome,
        "{:?} {:?}",
        end,
        expected
    );
    prop_assert!(
        (end.time_fire - expected.time_fire).abs() < 1e-8
            || end.time_fire.is_nan() && expected.time_fire.is_nan()
    );
    let swing = (robot.environment.gravity / robot.body.radius).sqrt();
    let (time, stroke) = (stroke_time(robot), robot.leg.stroke);
    let ledger = trace.energy;
    let work = robot.body.mass * robot.environment.gravity * stroke;
    let found = [
        ("time", end.time, time),
        ("lean", end.lean, 1.0),
        ("rate", end.rate, swing),
        ("extension", end.extension, stroke),
        ("extension rate", end.extension_rate, stroke / time),
        ("pressure", end.pressure, robot.environment.ambient.0),
        ("work of the drive", ledger.drive, work),
        ("losses", ledger.losses, work),
    ];
    for (((name, found, size), expected), moved) in
        found.into_iter().zip(expected.numbers()).zip(moved)
    {
        // By how much the oracle's number moved when its steps were halved bounds what is wrong
        // with it where the model is smooth; a kink within a step costs it an order or two, so a
        // few times that. 1e-8 of the number is what is asked of the product.
        let allowed = 4.0 * moved + 1e-8 * (expected.abs() + size);
        prop_assert!(
            (found - expected).abs() <= allowed,
            "{name}: {found} not {expected} ± {allowed:e}"
        );
    }
    Ok(())
}

proptest! {
    #![proptest_config(cases(20))]

    #[test]
    fn a_stance_is_what_an_independent_integrator_finds((robot, launch) in jump(any_ordinary())) {
        check_stance(&robot, &launch)?;
    }

    #[test]
    fn on_a_boom_too((robot, launch) in jump(on_boom(any_ordinary()))) {
        check_stance(&robot, &launch)?;
    }
}

proptest! {
    #![proptest_config(cases(120))]

    #[test]
    #[ignore = "nightly: 11 s"]
    fn stances_of_many_robots_are_what_an_independent_integrator_finds(
        (robot, launch) in jump(any_ordinary()),
    ) {
        check_stance(&robot, &launch)?;
    }

    #[test]
    #[ignore = "nightly: 11 s"]
    fn stances_of_many_robots_on_a_boom_too((robot, launch) in jump(on_boom(any_ordinary()))) {
        check_stance(&robot, &launch)?;
    }

    #[test]
    fn a_term_of_no_strength_changes_nothing((robot, launch) in jump(ordinary(Kind::Plain))) {
        let plain = stance(&robot).jump(&launch).expect("a stance");
        let length = 0.3 * robot.leg.stroke;
        let mut idle = robot.clone();
        idle.leg.return_spring = Some(ReturnSpring { stiffness: 0.0, preload: 0.0 });
        idle.leg.cushion = Some(Cushion { length, stiffness: 0.0, damping: 0.0 });
        let Drive::Pneumatic(c) = &mut idle.leg.drive else { unreachable!() };
        c.polytropic_exponent = Some(c.gas.heat_ratio);
        c.exhaust_port = Some(ExhaustPort { position: length, area: 1e-30 });
        let other = stance(&idle).jump(&launch).expect("a stance");
        prop_assert_eq!(plain.outcome, other.outcome);
        for (x, y) in [
            (plain.time, other.time),
            (plain.lean, other.lean),
            (plain.rate, other.rate),
            (plain.extension, other.extension),
            (plain.extension_rate, other.extension_rate),
            (plain.pressure, other.pressure),
        ] {
            // Steps end where a term switches, so they are others: the error control's 1e-12 over
            // some tens of steps.
            prop_assert!((x - y).abs() <= 1e-9 * (x.abs() + 1e-3), "{x} {y}");
        }
    }
}

/// Terms of strength 0 are off: the base model to the bit. A leg that the code does not take for
/// plain, but whose terms come to nothing, goes by the general equations: the base model to
/// round-off.
#[test]
fn off_is_the_base_model_to_the_bit() {
    for rate in [3.0, 4.5, 6.0] {
        for angle in [-0.25, -0.1, 0.05] {
            let launch = Launch {
                rate,
                lean: -0.35,
                firing_angle: angle,
                valve_open: 0.04,
            };
            let lift_off = |robot: &Robot| stance(robot).trace(&launch).expect("a stance").lift_off;
            let base = lift_off(&Robot::rats_planar());
            let explicit = rats(|robot| {
                robot.environment.drag = 0.0;
                let c = cylinder(robot);
                (c.supply_droop, c.leak_area, c.seal_friction) = (0.0, 0.0, 0.0);
                c.polytropic_exponent = Some(c.gas.heat_ratio);
            });
            assert_eq!(base, lift_off(&explicit));
            let general = rats(|robot| {
                robot.leg.return_spring = Some(ReturnSpring {
                    stiffness: 0.0,
                    preload: 0.0,
                });
            });
            // The general equations add the same numbers in another order: a few roundings over
            // some tens of steps.
            let (a, b) = (lift_off(&general), base);
            assert_eq!(a.outcome, b.outcome);
            for (x, y) in [
                (a.time, b.time),
                (a.lean, b.lean),
                (a.rate, b.rate),
                (a.pressure, b.pressure),
            ] {
                assert!((x - y).abs() <= 1e-13 * y.abs(), "{x} {y}");
            }
        }
    }
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn each_term_acts_as_it_is_named() {
    let base = apex(&Robot::rats_planar());
    let lower: [(&str, Robot); 11] = [
        ("leak", rats(|r| cylinder(r).leak_area = 1e-7)),
        ("droop", rats(|r| cylinder(r).supply_droop = 1e6)),
        ("seal friction", rats(|r| cylinder(r).seal_friction = 1e-5)),
        (
            "return spring",
            rats(|r| {
                r.leg.return_spring = Some(ReturnSpring {
                    stiffness: 50.0,
                    preload: 0.0,
                });
            }),
        ),
        (
            "preload",
            rats(|r| {
                r.leg.return_spring = Some(ReturnSpring {
                    stiffness: 0.0,
                    preload: 2.0,
                });
            }),
        ),
        (
            "exhaust port",
            rats(|r| {
                cylinder(r).exhaust_port = Some(ExhaustPort {
                    position: 0.05,
                    area: 2e-5,
                });
            }),
        ),
        (
            "cushion",
            rats(|r| {
                r.leg.cushion = Some(Cushion {
                    length: 4e-3,
                    stiffness: 1e4,
                    damping: 0.0,
                });
            }),
        ),
        (
            "damping",
            rats(|r| {
                r.leg.cushion = Some(Cushion {
                    length: 4e-3,
                    stiffness: 0.0,
                    damping: 30.0,
                });
            }),
        ),
        ("viscous friction", rats(|r| r.leg.viscous_friction += 1.0)),
        ("Coulomb friction", rats(|r| r.leg.coulomb_friction += 1.0)),
        // More molar mass: a slower flow, and a lower κ.
        ("carbon dioxide", rats(|r| cylinder(r).gas = Gas::CO2)),
    ];
    for (name, robot) in lower {
        let apex = apex(&robot);
        assert!(apex < base - 1e-4, "{name}: {apex} m, {base} m without");
    }
    // Less molar mass than air.
    assert!(apex(&rats(|r| cylinder(r).gas = Gas::NITROGEN)) > base);
    // The wall takes heat: the chamber fills more slowly, but its gas cools less as it expands, so
    // that either may win.
    let breaks_away = |robot: &Robot| {
        let trace = stance(robot)
            .trace(&Launch::at_firing(0.0, 0.0, 0.1))
            .expect("a stance");
        trace
            .samples
            .iter()
            .rfind(|sample| sample.extension == 0.0)
            .map(|sample| sample.time)
    };
    let cooled = rats(|r| cylinder(r).polytropic_exponent = Some(1.2));
    assert!(breaks_away(&cooled) > breaks_away(&Robot::rats_planar()));
    // A delay shifts an upright hop and changes nothing else.
    let (now, later) = (
        hop(&Robot::rats_planar()),
        hop(&rats(|r| r.leg.delay += 0.01)),
    );
    assert!(
        (later.time - now.time - 0.01).abs() < 1e-12
            && (later.extension_rate - now.extension_rate).abs() < 1e-9
    );
}

/// A valve follows a command of its least pulse, and none that is shorter (thesis 6.3.2).
#[test]
fn a_command_shorter_than_the_least_pulse_does_nothing() {
    let slow = rats(|r| r.leg.least_pulse = 0.03);
    let launch = |valve_open| Launch {
        lean: -0.3,
        ..Launch::at_firing(4.5, -0.1, valve_open)
    };
    let jump = |robot: &Robot, t_v: f64| stance(robot).jump(&launch(t_v)).expect("a stance");
    assert_eq!(jump(&slow, 0.03), jump(&Robot::rats_planar(), 0.03));
    assert_eq!(jump(&slow, 0.0299).outcome, Outcome::NoBreakAway);
    assert!(jump(&Robot::rats_planar(), 0.0299).outcome.is_jump());
    let lanes = Batch::new(&slow, 1e-12).jumps(&[launch(0.03), launch(0.0299)]);
    let outcomes: Vec<bool> = lanes
        .into_iter()
        .map(|end| end.expect("a stance").outcome.is_jump())
        .collect();
    assert_eq!(outcomes, [true, false]);
}

#[test]
fn drag_shortens_and_lowers_a_flight() {
    let robot = Robot::rats_planar();
    let end = stance(&robot)
        .jump(&Launch::at_firing(5.0, -0.1, 0.1))
        .expect("a stance");
    let ([x, y], [vx, vy]) = (end.axle, end.axle_rates);
    let vacuum = Flight {
        x,
        y,
        vx,
        vy,
        gravity: robot.environment.gravity,
    };
    let drag = |drag| DragFlight { vacuum, drag };
    let range = |flight: DragFlight<f64>| flight.range_to_height(0.0).expect("it lands");
    assert_eq!(
        range(drag(0.0)).to_bits(),
        vacuum.range_to_height(0.0).expect("it lands").to_bits()
    );
    assert!(range(drag(0.05)) < range(drag(0.01)) && range(drag(0.01)) < range(drag(0.0)));
    assert!(drag(0.01).apex_height() < vacuum.apex_height());
    // Against steps of 10 µs: second order leaves 1e-9.
    let (c, h) = (0.05, 1e-5);
    let (mut p, mut v) = ([x, y], [vx, vy]);
    let acceleration = |v: [f64; 2]| {
        let speed = v[0].hypot(v[1]);
        [
            -c * speed * v[0],
            -c * speed * v[1] - robot.environment.gravity,
        ]
    };
    loop {
        let a = acceleration(v);
        let middle = [v[0] + 0.5 * h * a[0], v[1] + 0.5 * h * a[1]];
        let a = acceleration(middle);
        let next = [p[0] + h * middle[0], p[1] + h * middle[1]];
        if next[1] < 0.0 {
            let share = p[1] / (p[1] - next[1]);
            p[0] += share * (next[0] - p[0]);
            break;
        }
        (p, v) = (next, [v[0] + h * a[0], v[1] + h * a[1]]);
    }
    assert!(
        (range(drag(c)) - p[0]).abs() < 1e-7,
        "{} {}",
        range(drag(c)),
        p[0]
    );
}

#[test]
fn a_leg_without_a_chamber_shows_the_ambient_pressure() {
    let robot = Robot::builtin("spring-hopper").expect("built in");
    let mut robot = robot;
    robot.environment.ambient.0 = 9e4;
    let end = stance(&robot)
        .jump(&Launch::at_firing(2.0, 0.0, 0.1))
        .expect("a stance");
    assert_eq!(end.pressure, 9e4);
}
