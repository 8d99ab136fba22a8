//! The built-in robots: what they hold, and that they can jump.

use std::path::Path;

use saltus_robot::{
    AbsolutePressure, Body, Boom, Cylinder, Drive, Environment, Foot, ForceTable, Gas,
    GaugePressure, Ground, Leg, LegBody, ReturnSpring, Robot, Sensors, Struts, resolve,
};

/// The nominal robot of docs/model.md, number for number: thesis, tables 4.1 and 4.2.
#[test]
fn rats_planar_is_the_nominal_robot() {
    let robot = Robot::rats_planar();
    assert_eq!(robot.name, "rats-planar");
    let body = Body {
        mass: 2.75,
        inertia: 0.0792,
        radius: 0.24,
        legs: 5,
        ..Body::default()
    };
    assert_eq!(robot.body, body);
    assert_eq!(
        (robot.boom, robot.foot, robot.ground),
        (None, Foot::default(), Ground::default())
    );
    assert_eq!(
        robot.leg,
        Leg {
            stroke: 0.06,
            delay: 0.010,
            viscous_friction: 5.2843,
            coulomb_friction: 9.7003,
            drive: Drive::Pneumatic(Cylinder {
                bore: 0.01905,
                dead_volume: 5.4e-6,
                supply: GaugePressure(120.0 * 6_894.757_293_168),
                discharge_coefficient: 0.5378,
                orifice_radius: 1.0215e-3,
                gas: Gas::AIR,
                temperature: 293.15,
                ..Cylinder::default()
            }),
            ..Leg::default()
        }
    );
    assert_eq!(
        robot.environment,
        Environment {
            gravity: 9.80665,
            ambient: AbsolutePressure(101_325.0),
            drag: 0.0
        }
    );
}

/// The robot on its boom (docs/model.md, "The boom"): rats-planar with the masses and shapes of its
/// parts.
#[test]
fn rats_boom_is_the_full_rig() {
    let robot = Robot::builtin("rats-boom").expect("built in");
    let rod = LegBody {
        mass: 0.05,
        center: 0.19,
        length: 0.1,
        radius: 0.007,
    };
    assert_eq!(robot.leg.body, rod);
    let boom = Boom {
        mass: 0.5,
        length: 2.12,
        radius: 0.015,
        counterweight: None,
        flex: None,
        flex_time: 0.0,
    };
    assert_eq!(robot.boom, Some(boom));

    // The totals in the file are the sums of the parts to the last digit written there.
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-13, "{a} {b}");
    close(robot.wheel_mass(), 2.5);
    close(robot.wheel_inertia(), 0.072);
    close(0.072, 0.5 * 2.5 * robot.body.radius * robot.body.radius);
    close(
        rod.inertia(),
        0.05 * (3.0 * 0.007 * 0.007 + 0.1 * 0.1) / 12.0,
    );
    close(rod.center + 0.5 * rod.length, robot.body.radius);

    let planar = Robot::rats_planar();
    let mut rest = robot;
    rest.name.clone_from(&planar.name);
    (rest.boom, rest.leg.body, rest.body.inertia) = (None, planar.leg.body, planar.body.inertia);
    assert_eq!(rest, planar);
}

/// The robot that runs: rats-boom with what the comments of rats-run.toml name, and nothing else.
#[test]
fn rats_run_is_rats_boom_that_runs() {
    let boom = Robot::builtin("rats-boom").expect("built in");
    let robot = Robot::builtin("rats-run").expect("built in");
    let spring = robot.leg.return_spring.expect("a spring");
    let half_way = spring.preload + spring.stiffness * 0.5 * robot.leg.stroke;
    // Table 4.2 has 9.7003 N; the file splits 9.7 N.
    let sum = robot.leg.coulomb_friction + half_way;
    assert!((sum - boom.leg.coulomb_friction).abs() < 1e-3, "{sum}");

    let mut expected = boom;
    expected.name = "rats-run".into();
    expected.leg.coulomb_friction = 3.0;
    expected.leg.return_spring = Some(ReturnSpring {
        stiffness: 60.0,
        preload: 4.9,
    });
    expected.struts = Some(Struts {
        distance: 0.14,
        radius: 0.005,
    });
    expected.foot = Foot { radius: 0.007 };
    expected.ground = Ground {
        static_friction: 0.9,
        kinetic_friction: 0.9,
        across_friction: 0.1,
        ..Ground::default()
    };
    expected.sensors = Some(Sensors {
        gyro_noise: 0.1,
        accelerometer_radius: 0.05,
        range_noise: 0.01,
        ..Sensors::default()
    });
    assert_eq!(robot, expected);
}

/// The derivations in the comments of rats-planar.toml.
#[test]
fn rats_planar_errors_follow_from_its_sensors() {
    let uniform = |step: f64| step / 12.0_f64.sqrt();
    let errors = Robot::rats_planar().errors;
    let (encoder, loop_time) = (uniform(std::f64::consts::TAU / 800.0), 1e-3);
    // The file states three digits.
    let check = |stated: f64, derived: f64| {
        assert!((stated / derived - 1.0).abs() < 5e-3, "{stated} {derived}");
    };
    check(errors.rate, 2.0_f64.sqrt() * encoder / 0.05);
    check(errors.firing_angle, encoder.hypot(uniform(5.0 * loop_time)));
    check(errors.valve_open, uniform(loop_time));
    assert_eq!(errors.supply, 2.0 * 6_894.757_293_168);
}

/// Force (N) on the wheel at the beginning of the stroke, with the valve long open.
fn starting_force(leg: &Leg) -> f64 {
    let drive = match &leg.drive {
        Drive::Pneumatic(c) => c.supply.0 * std::f64::consts::PI * (c.bore / 2.0).powi(2),
        Drive::Spring {
            stiffness,
            compression,
        } => stiffness * compression,
        Drive::Constant { force } => *force,
        Drive::Table(table) => table.forces[0],
    };
    drive - leg.coulomb_friction
}

#[test]
fn every_built_in_robot_can_jump() {
    assert!(Robot::builtin_names().count() >= 3);
    for name in Robot::builtin_names() {
        let robot = Robot::builtin(name).expect("built in");
        assert_eq!(robot.name, name);
        let weight = robot.body.mass * robot.environment.gravity;
        assert!(starting_force(&robot.leg) > 2.0 * weight, "{name}");
    }
    assert_eq!(Robot::builtin("rats"), None);
}

/// The files on the disk, with the files that they name, are the ones built in.
#[test]
fn built_in_robots_are_the_files_in_robots() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../robots");
    for name in Robot::builtin_names() {
        let path = folder.join(name).with_extension("toml");
        assert_eq!(
            Robot::load(&path).expect("in the repository"),
            Robot::builtin(name).expect("built in")
        );
        assert_eq!(
            resolve(name, &[]).expect("built in"),
            Robot::builtin(name).expect("built in")
        );
    }
}

#[test]
fn the_table_hopper_has_its_csv_file() {
    let Drive::Table(ForceTable {
        extensions,
        speeds,
        forces,
    }) = Robot::builtin("table-hopper").expect("built in").leg.drive
    else {
        panic!("a force table");
    };
    assert_eq!(extensions, [0.0, 0.01, 0.02, 0.03, 0.04, 0.05]);
    assert_eq!(speeds, [0.0, 1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_eq!(forces.len(), 36);
    assert_eq!((forces[0], forces[1], forces[6]), (161.5, 131.5, 179.7));
}
