//! A robot in space: what its symmetry and its laws of conservation say, and the runs of chapter 7 of the thesis.

use saltus_gait::GaitError;
use saltus_gait::space::{Ball, Roll, Rolled, Start, roll};
use saltus_robot::Robot;
use saltus_sim_check::{Rig, Settings, Sim, Stepping};

fn twelve(overrides: &[&str]) -> Robot {
    let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
    saltus_robot::resolve("rats-twelve", &overrides).expect("a sound robot")
}

/// Runs the thesis' law for `seconds` from `start`.
fn go(overrides: &[&str], seconds: f64, start: Start) -> Result<Rolled, GaitError> {
    let mut setup = Roll::new(twelve(overrides), seconds);
    setup.start = start;
    setup.stepping = Stepping::Fixed(5e-4);
    roll(&setup, |_| true)
}

#[test]
fn undisturbed_it_runs_straight() -> Result<(), GaitError> {
    // Independent: 11 to 18 m.
    let far = go(&[], 5.0, Start::default())?;
    assert!((11.0..19.0).contains(&far.travel), "{far:?}");
    assert!(far.aside < 1e-6 && far.left.is_none(), "{far:?}");
    // Independent: nothing.
    let weak = go(&["leg.force_n=100"], 5.0, Start::default())?;
    assert!(weak.travel < 0.7 && weak.firings < 5, "{weak:?}");
    Ok(())
}

/// Feet of rubber: what a step's error leaves unexplained falls with the square of the step.
#[test]
fn the_ledger_closes_as_steps_get_shorter() -> Result<(), GaitError> {
    let residual = |step: f64| -> Result<f64, GaitError> {
        let mut setup = Roll::new(twelve(&[]), 0.6);
        setup.stepping = Stepping::Fixed(step);
        Ok(roll(&setup, |_| true)?.residual.abs())
    };
    let (coarse, fine) = (residual(5e-4)?, residual(6.25e-5)?);
    assert!(coarse < 1.0 && fine < coarse / 20.0, "{coarse} J, {fine} J");
    Ok(())
}

#[test]
fn what_is_off_its_plane_leaves_it_but_a_heading_does_not_matter() -> Result<(), GaitError> {
    // Thesis 7.3 in words. Independent: out of the plane after 1.2 s, and never.
    let rolled = go(
        &[],
        5.0,
        Start {
            roll: 0.01,
            ..Start::default()
        },
    )?;
    let left = rolled.left.expect("it leaves its plane");
    assert!((0.9..1.8).contains(&left.time), "{left:?}");
    let turned = go(
        &[],
        5.0,
        Start {
            yaw: 0.01,
            ..Start::default()
        },
    )?;
    assert!(turned.left.is_none(), "{turned:?}");
    // It runs along its own heading.
    let aside = turned.travel * 0.01_f64.tan();
    assert!((turned.aside - aside).abs() < 1e-6, "{turned:?}");
    // A centre of mass aside, and legs that differ.
    for overrides in [
        "body.center_of_mass_mm=[0.2,0.2,0.2]",
        "legs.force_factors=[1.05,0.97,1,1.02,0.96,1,1.01,0.98,1.04,1,0.95,1.03]",
    ] {
        let rolled = go(&[overrides], 5.0, Start::default())?;
        assert!(rolled.left.is_some(), "{overrides}: {rolled:?}");
    }
    Ok(())
}

#[test]
fn all_starts_that_a_rotation_makes_one_are_one() -> Result<(), GaitError> {
    // Twenty rests with six ways each; a leg is behind in three of them, twins in the others.
    let mut seen: Vec<Vec<Ball>> = Vec::new();
    for rest in 0..20 {
        for way in 0..6 {
            let mut setup = Roll::new(twelve(&[]), 0.5);
            setup.start = Start {
                rest,
                way,
                ..Start::default()
            };
            let mut balls = Vec::new();
            roll(&setup, |ball| {
                balls.push(ball.clone());
                true
            })?;
            let last = balls.last().expect("cycles");
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
            let same = |other: &Vec<Ball>| {
                let other = other.last().expect("cycles");
                near(&last.place, &other.place)
                    && near(&last.velocity, &other.velocity)
                    && near(&last.spin, &other.spin)
            };
            if !seen.iter().any(same) {
                seen.push(balls);
            }
        }
    }
    assert_eq!(seen.len(), 2);
    // With a leg behind it has made a stride; twins lean by less than the law fires at rest.
    let place = |balls: &Vec<Ball>| balls.last().expect("cycles").place;
    let far = seen.iter().filter(|balls| place(balls)[0] > 0.3).count();
    assert_eq!(far, 1);
    assert!(seen.iter().all(|balls| place(balls)[1].abs() < 1e-9));
    Ok(())
}

#[test]
fn in_flight_its_legs_move_its_momenta_do_not() -> Result<(), GaitError> {
    let robot = twelve(&[]);
    let mut rig = Rig::new(&robot, &[])?;
    rig.mechanism.surfaces.clear();
    rig.mechanism.gravity.fill(0.0);
    let tree = &rig.mechanism.tree;
    let mut q = vec![0.0; tree.coordinates()];
    q[3] = 1.0;
    let mut v = vec![0.0; tree.velocities()];
    v[..6].copy_from_slice(&[0.3, -0.2, 0.5, 4.0, -7.0, 5.0]);
    let settings = Settings {
        stepping: Stepping::Adaptive,
        tolerance: 1e-13,
        accounts: true,
        most_steps: usize::MAX,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    sim.release_legs()?;
    let start = (sim.ledger(), sim.pose().momentum(tree));
    for leg in 0..12 {
        sim.run(0.3 * f64::from(u8::try_from(leg).expect("small")), &[])?;
        sim.fire(leg, 0.04)?;
    }
    sim.run(10.0, &[])?;
    let (linear, angular) = sim.pose().momentum(tree);
    assert!((linear - start.1.0).norm() < 1e-9, "{linear}");
    let turned = (angular - start.1.1).norm();
    assert!(turned < 1e-8 * angular.norm(), "{turned}");
    let ledger = sim.ledger();
    assert!(ledger.drive > 50.0, "its legs moved: {ledger:?}");
    let left = ledger.residual(&start.0);
    assert!(left.abs() < 1e-9 * ledger.drive, "{left}");
    Ok(())
}

#[test]
fn what_is_no_roll_is_refused() {
    let planar = saltus_robot::resolve("rats-run", &[]).expect("sound");
    let refused = |change: &dyn Fn(&mut Roll)| {
        let mut setup = Roll::new(twelve(&[]), 1.0);
        change(&mut setup);
        roll(&setup, |_| true).expect_err("refused").to_string()
    };
    let says = |error: String, part: &str| assert!(error.contains(part), "{error}");
    says(
        refused(&|it| it.robot = planar.clone()),
        "body.shape = \"sphere\"",
    );
    says(refused(&|it| it.start.rest = 20), "below 20");
    says(refused(&|it| it.start.way = 6), "below 6");
    says(refused(&|it| it.start.roll = f64::NAN), "roll (rad)");
    says(refused(&|it| it.seconds = 0.0), "time (s)");
    says(refused(&|it| it.valve_open = -1.0), "valve opening");
}
