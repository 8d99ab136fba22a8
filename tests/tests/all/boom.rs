//! The boom as a term of the planar model: mass and weight at the axle.

use std::fmt::Debug;

use saltus_lagrangian::{Launch, Stance};
use saltus_planner::Planner;
use saltus_robot::{Boom, Counterweight, Drive, Robot};
use saltus_tests::oracle::solve_twice;

fn rats_boom() -> Robot {
    Robot::builtin("rats-boom").expect("built in")
}

fn stance(robot: &Robot) -> Stance<f64> {
    Stance::new(robot, |_, x| x)
}

/// A boom of `mass` (kg).
fn boom(mass: f64) -> Boom {
    Boom {
        mass,
        length: 2.12,
        radius: 0.015,
        ..Boom::default()
    }
}

/// docs/model.md, "The boom": 2.917 kg of inertia but 3.0 kg of weight; flight falls at 10.1 m/s².
#[test]
fn the_axle_of_rats_boom() {
    let robot = rats_boom();
    assert!((robot.axle_mass() - (2.75 + 0.5 / 3.0)).abs() < 1e-15);
    assert!((robot.axle_mass() * robot.axle_gravity() - 3.0 * 9.80665).abs() < 1e-13);
    assert!((robot.axle_gravity() - 10.1).abs() < 0.05);
}

#[test]
fn a_counterweight_takes_weight_and_adds_inertia() {
    let mut robot = rats_boom();
    let with = |mass: f64, distance: f64| {
        let mut robot = rats_boom();
        robot.boom = Some(Boom {
            counterweight: Some(Counterweight { mass, distance }),
            ..boom(0.5)
        });
        robot
    };
    // A quarter of the length behind the base: a sixteenth of the inertia, a quarter of the weight.
    let quarter = with(2.0, 0.53);
    assert!((quarter.axle_mass() - robot.axle_mass() - 2.0 / 16.0).abs() < 1e-14);
    let weight = |robot: &Robot| robot.axle_mass() * robot.axle_gravity();
    assert!((weight(&robot) - weight(&quarter) - 0.5 * 9.80665).abs() < 1e-13);
    // What balances robot and boom leaves nothing to fall, and never less.
    for distance in [0.1, 0.3, 0.7, 1.1] {
        let balanced = with(3.0 * 2.12 / distance, distance);
        assert!(
            (0.0..1e-14).contains(&balanced.axle_gravity()),
            "{distance}"
        );
    }
    robot.boom = None;
    assert_eq!((robot.axle_mass(), robot.axle_gravity()), (2.75, 9.80665));
}

/// A boom of no mass is no boom, to the bit.
#[test]
fn a_boom_of_no_mass_is_rats_planar() {
    let planar = Robot::rats_planar();
    let mut idle = planar.clone();
    idle.boom = Some(boom(0.0));
    let planners = [planar, idle].map(Planner::new);
    // As text, in which a NaN, as of a leg that was not fired, is like another.
    let same = |a: &dyn Debug, b: &dyn Debug| assert_eq!(format!("{a:?}"), format!("{b:?}"));
    for (rate, angle, valve_open) in [
        (5.0, -0.1, 0.1),
        (3.0, -0.2, 0.03),
        (0.0, 0.0, 0.05),
        (6.2, 0.3, 0.1),
    ] {
        let launch = Launch {
            rate,
            lean: f64::min(angle, -0.05),
            firing_angle: angle,
            valve_open,
        };
        let [a, b] = planners
            .each_ref()
            .map(|planner| planner.jump(&launch).expect("a stance"));
        same(&a, &b);
        let [a, b] = planners
            .each_ref()
            .map(|p| p.stance().trace(&launch).expect("a stance"));
        same(&a, &b);
        let [a, b] = planners
            .each_ref()
            .map(|p| p.jumps(&[launch; 9]).remove(8).expect("a stance"));
        same(&a, &b);
    }
}

/// An upright push by a constant force F over a stroke s, without friction, is uniform
/// acceleration: it lifts off at ẏ² = 2 s (F/M − W/M), and rises by M ẏ²/(2 W), W being what hangs
/// on the axle and M what moves with it.
#[test]
fn an_upright_push_in_closed_form() {
    let (force, stroke) = (200.0, 0.06);
    let mut robot = rats_boom();
    (robot.leg.viscous_friction, robot.leg.coulomb_friction) = (0.0, 0.0);
    robot.leg.drive = Drive::Constant { force };
    robot.boom = Some(Boom {
        counterweight: Some(Counterweight {
            mass: 0.8,
            distance: 0.6,
        }),
        ..boom(0.5)
    });
    let (mass, weight) = (
        2.75 + 0.5 / 3.0 + 0.8 * 0.6 * 0.6 / (2.12 * 2.12),
        9.80665 * (2.75 + 0.25 - 0.8 * 0.6 / 2.12),
    );
    let launch = Launch::at_firing(0.0, 0.0, 1.0);
    let jump = Planner::new(robot.clone()).jump(&launch).expect("a stance");
    let speed = (2.0 * stroke * (force - weight) / mass).sqrt();
    // Planning keeps nine digits.
    assert!(
        (jump.stance.extension_rate - speed).abs() < 1e-8,
        "{}",
        jump.stance.extension_rate
    );
    let apex = 0.24 + stroke + mass * speed * speed / (2.0 * weight);
    assert!((jump.apex().expect("a hop") - apex).abs() < 1e-8);
    // At rest the foot carries the weight, and the ledger closes with the boom's energy in it.
    let trace = stance(&robot).trace(&launch).expect("a stance");
    assert!((trace.samples[0].reaction.normal - weight).abs() < 1e-12);
    assert!((trace.energy.drive - force * stroke).abs() < 1e-9);
    assert!((trace.energy.kinetic - 0.5 * mass * speed * speed).abs() < 1e-9);
    assert!((trace.energy.potential - weight * stroke).abs() < 1e-9);
    assert!(trace.energy.residual().abs() < 1e-9);
}

/// Figure 5.2 with the boom as it is: hops from rest on one upright leg, as an independent
/// integrator has them. The figure's axis runs from 0.04 to 0.16 rad and its text sees no gain past
/// 55 ms; half of the boom's mass weighs, so that the hops stay 3 % below those with a third of it
/// in weight and inertia alike (0.042 to 0.158 rad).
#[test]
fn figure_5_2_with_the_boom() {
    let planner = Planner::new(rats_boom());
    let robot = planner.robot();
    let pivot = |height: f64, speed: f64| {
        let (mass, weight) = (2.75 + 0.5 / 3.0, 9.80665 * (2.75 + 0.5 / 2.0));
        ((height + mass * speed * speed / (2.0 * weight) - 0.24) / 2.12).asin()
    };
    let hop = |milliseconds: f64| {
        let launch = Launch::at_firing(0.0, 0.0, 1e-3 * milliseconds);
        let apex = planner
            .jump(&launch)
            .expect("a stance")
            .apex()
            .expect("a hop");
        let (end, _) = solve_twice(robot, &launch, 2e-5);
        let (found, expected) = (
            ((apex - 0.24) / 2.12).asin(),
            pivot(0.24 + end.extension, end.extension_rate),
        );
        // Planning keeps nine digits, the oracle at its 3,000 steps a stroke as many.
        assert!(
            (found - expected).abs() < 1e-8,
            "{milliseconds} ms: {found}, not {expected}"
        );
        found
    };
    // Read as the figure is, to a thousandth.
    for (milliseconds, read) in [(20.0, 0.041), (30.0, 0.085), (40.0, 0.131), (55.0, 0.154)] {
        assert!((hop(milliseconds) - read).abs() < 5e-4, "{milliseconds} ms");
    }
    assert!((hop(55.0) - hop(100.0)).abs() < 1e-9);
}
