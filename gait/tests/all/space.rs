//! A robot in space: what its symmetry and its laws of conservation say, and the runs of chapter 7 of the thesis.

use saltus_gait::GaitError;
use std::f64::consts::TAU;

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use proptest::prelude::*;
use saltus_controller::ball::{Rotation, Tracker};
use saltus_gait::space::{
    Ball, DrawnBalls, Facing, Gait, Knows, Roll, Rolled, Stable, Start, Steered, Thrown,
    drawn_ball, roll,
};
use saltus_robot::Robot;
use saltus_robot::space::{Directions, discs, rests};
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
    // When a leg leaves the ground hangs on round-off: several steps.
    let mut travels = Vec::new();
    for step in [4e-4, 4.5e-4, 5e-4, 5.5e-4, 6e-4] {
        let mut setup = Roll::new(twelve(&[]), 5.0);
        setup.stepping = Stepping::Fixed(step);
        let mut aside = 0.0_f64;
        let rolled = roll(&setup, |ball| {
            if ball.place[0] < 5.0 {
                aside = aside.max(ball.place[1].abs());
            }
            true
        })?;
        assert!(aside < 1e-3 && rolled.left.is_none(), "{rolled:?}");
        travels.push(rolled.travel);
    }
    travels.sort_by(f64::total_cmp);
    // Least and greatest of 20 runs in steps of 0.5 ms (docs/space.md).
    assert!((16.4..21.0).contains(&travels[2]), "{travels:?}");
    // Independent: nothing.
    let weak = go(&["leg.force_n=100"], 5.0, Start::default())?;
    assert!(weak.travel < 0.7 && weak.firings < 10, "{weak:?}");
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
    // Thesis 7.3 in words. Independent, on softer ground: out of the plane after 1.2 s, and never.
    let rolled = go(
        &[],
        5.0,
        Start {
            roll: 0.01,
            ..Start::default()
        },
    )?;
    let left = rolled.left.expect("it leaves its plane");
    assert!((0.5..5.0).contains(&left.time), "{left:?}");
    let yaw = 0.01;
    let turned = go(
        &[],
        3.0,
        Start {
            yaw,
            ..Start::default()
        },
    )?;
    assert!(turned.left.is_none(), "{turned:?}");
    // It runs along its own heading.
    assert!(turned.aside < 1e-3, "{turned:?}");
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
#[ignore = "nightly: 6 s"]
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
    let closed = |it: &mut Roll| {
        if let Gait::Disc(fires) = &mut it.gait {
            fires.valve_open = -1.0;
        }
    };
    says(refused(&closed), "valve opening");
}

/// The plane of the first way from the first rest.
fn first_facing() -> Facing {
    let directions = Directions::Dodecahedron.vectors();
    Facing::all(&rests(&directions)[0], &discs(&directions))[0].clone()
}

proptest! {
    #[test]
    fn a_tracker_sees_how_the_plane_lies(
        turn in -20.0_f64..20.0,
        roll in -1.4_f64..1.4,
        heading in -3.1_f64..3.1,
        spin in prop::array::uniform3(-10.0_f64..10.0),
    ) {
        // Upright with its first station down, turned about the disc's axis, rolled about the heading, turned to it.
        let facing = first_facing();
        let disc = facing.disc();
        let body = Matrix3::from_columns(&[
            Vector3::from(disc.ahead),
            Vector3::from(disc.axis),
            -Vector3::from(disc.first),
        ]);
        let about = |axis: Vector3<f64>, angle: f64| UnitQuaternion::new(axis * angle);
        let upright = UnitQuaternion::from_matrix(&body.transpose());
        let attitude = about(Vector3::z(), heading) * about(Vector3::x(), roll) * about(Vector3::y(), turn) * upright;
        let ahead = about(Vector3::z(), heading) * Vector3::x();
        let axis = attitude * Vector3::from(disc.axis);
        let mut tracker = Tracker::new(facing.plane(), -0.3);
        let q = Rotation([attitude.w, attitude.i, attitude.j, attitude.k]);
        let (lying, entered) = tracker.look(&q, &spin);
        prop_assert!(entered);
        let spin = Vector3::from(spin);
        let near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        prop_assert!(near(lying.roll, roll) && near(lying.heading, heading), "{lying:?}");
        prop_assert!(near(lying.roll_rate, spin.dot(&ahead)) && near(lying.rate, spin.dot(&axis)));
        let station = tracker.station().expect("stations");
        let off = (turn - station.angle - lying.lean) / TAU;
        prop_assert!((off - off.round()).abs() < 1e-9, "{lying:?}");
        prop_assert!(lying.lean > -0.3 - 1e-9 && lying.lean < 0.82, "{lying:?}");
    }
}

#[test]
fn a_tracker_counts_stations_both_ways() {
    let facing = first_facing();
    let disc = facing.disc();
    let axis = Vector3::from(disc.axis);
    let body =
        Matrix3::from_columns(&[Vector3::from(disc.ahead), axis, -Vector3::from(disc.first)]);
    let upright = UnitQuaternion::from_matrix(&body.transpose());
    let mut tracker = Tracker::new(facing.plane(), -0.3);
    let mut passed = Vec::new();
    let there = (0..2000).map(|k| 0.01 * f64::from(k));
    let back = (0..2000).rev().map(|k| 0.01 * f64::from(k));
    for turn in there.chain(back) {
        let attitude = UnitQuaternion::new(Vector3::y() * turn) * upright;
        tracker.look(
            &Rotation([attitude.w, attitude.i, attitude.j, attitude.k]),
            &[0.0; 3],
        );
        passed.push(tracker.passed());
    }
    assert_eq!(passed[0], passed[3999]);
    // 20 rad: three turns of six stations and one or two of the next.
    assert!(
        (19..=20).contains(&(passed[1999] - passed[0])),
        "{passed:?}"
    );
    assert!(passed.windows(2).all(|pair| (pair[1] - pair[0]).abs() <= 1));
}

/// How far the attitude by its sensors is from the truth (rad rms, and about the vertical at the end), over a stable run.
fn lost(robot: Robot, seconds: f64) -> Result<(f64, f64), GaitError> {
    let mut setup = Roll::new(robot, seconds);
    setup.gait = Gait::Stable(Stable::default());
    setup.knows = Knows::Sensors(7);
    setup.stepping = Stepping::Fixed(1e-3);
    let (mut sum, mut count, mut heading) = (0.0, 0.0, 0.0);
    roll(&setup, |ball| {
        let Some(estimate) = ball.estimate else {
            return false;
        };
        let [_, x, y, z] = estimate.attitude.after(&Rotation(ball.attitude).back()).0;
        sum += 4.0 * (x * x + y * y);
        heading = 2.0 * z;
        count += 1.0;
        true
    })?;
    Ok(((sum / f64::max(count, 1.0)).sqrt(), heading))
}

#[test]
fn it_knows_its_attitude_by_its_sensors() -> Result<(), GaitError> {
    let (level, heading) = lost(twelve(&[]), 8.0)?;
    assert!(
        level < 1_f64.to_radians() && heading.abs() < 1_f64.to_radians(),
        "{level} {heading}"
    );
    // Without noise, on fine converters, what is left is of the feet.
    let quiet = twelve(&["sensors.gyro_noise_rad_s=0", "sensors.converter_bits=24"]);
    let (level, heading) = lost(quiet, 8.0)?;
    assert!(
        level < 0.5_f64.to_radians() && heading.abs() < 0.01,
        "{level} {heading}"
    );
    Ok(())
}

/// How far (m) eight drawn robots come in 10 s in all, until they lean by half a radian.
fn together(stable: &Stable) -> Result<f64, GaitError> {
    let mut travel = 0.0;
    for k in 0..8 {
        let robot = drawn_ball(&twelve(&[]), &DrawnBalls::default(), 5, k)?;
        let mut setup = Roll::new(robot, 10.0);
        setup.gait = Gait::Stable(stable.clone());
        setup.stepping = Stepping::Fixed(1e-3);
        travel += roll(&setup, |ball| ball.rolling.roll.abs() < 0.5)?.travel;
    }
    Ok(travel)
}

#[test]
fn twins_keep_a_ball_in_its_plane() -> Result<(), GaitError> {
    let stable = Stable::default();
    let kept = together(&stable)?;
    let mut blind = stable.clone();
    let s = &mut blind.steer;
    (s.roll, s.roll_rate, s.heading, s.heading_rate) = (0.0, 0.0, 0.0, 0.0);
    (s.aside, s.aside_rate, s.sum) = (0.0, 0.0, 0.0);
    let blind = together(&blind)?;
    assert!(kept > 2.0 * blind, "{kept} m against {blind} m");
    // The wrong way round they throw it over.
    let mut wrong = stable;
    (wrong.steer.roll, wrong.steer.roll_rate) = (-wrong.steer.roll, -wrong.steer.roll_rate);
    let wrong = together(&wrong)?;
    assert!(kept > 2.0 * wrong, "{kept} m against {wrong} m");
    Ok(())
}

#[test]
fn drawn_balls_are_the_same_for_any_number_and_refused_by_name() -> Result<(), GaitError> {
    let robot = twelve(&[]);
    let draw = DrawnBalls::default();
    let ball = drawn_ball(&robot, &draw, 3, 5)?;
    assert_eq!(ball, drawn_ball(&robot, &draw, 3, 5)?);
    assert_ne!(ball, drawn_ball(&robot, &draw, 3, 6)?);
    let center = ball.space.as_ref().expect("in space").center;
    assert!(center.iter().map(|x| x * x).sum::<f64>() <= 1e-6);
    assert!((0.6..=1.2).contains(&ball.ground.static_friction));
    let wild = DrawnBalls {
        force: f64::NAN,
        ..draw
    };
    let error = drawn_ball(&robot, &wild, 3, 0)
        .expect_err("refused")
        .to_string();
    assert!(
        error.contains("scatter of forces") && error.contains("from 0 to 0.5"),
        "{error}"
    );
    Ok(())
}

/// A disc of two radii that rolls down a slope without firing: about each foot by the conservation of energy, onto the next
/// one by that of angular momentum about it.
#[test]
fn unfired_it_rolls_down_a_slope_as_the_closed_form_says() -> Result<(), GaitError> {
    let slope = 0.25_f64;
    let robot = twelve(&[
        &format!("ground.slope_deg={}", -slope.to_degrees()),
        "ground.static_friction=50",
        "ground.kinetic_friction=50",
        "foot.radius_mm=0",
    ]);
    let mut rig = Rig::new(&robot, &[])?;
    rig.mechanism.material.compliance = None;
    let facing = first_facing();
    let disc = facing.disc();
    let (lean, rate) = (0.1, 3.0);
    // The first station's leg down along the slope's normal, turned by the lean.
    let body = Matrix3::from_columns(&[
        Vector3::from(disc.ahead),
        Vector3::from(disc.axis),
        -Vector3::from(disc.first),
    ]);
    let attitude = UnitQuaternion::new(Vector3::y() * (slope + lean))
        * UnitQuaternion::from_matrix(&body.transpose());
    let mut q = vec![0.0; rig.mechanism.tree.coordinates()];
    q[3..7].copy_from_slice(&[attitude.w, attitude.i, attitude.j, attitude.k]);
    let foot = attitude * Vector3::from(disc.first) * 0.24;
    q[..3].copy_from_slice((-foot).as_slice());
    let mut v = vec![0.0; rig.mechanism.tree.velocities()];
    let spin = Vector3::y() * rate;
    v[..3].copy_from_slice(spin.cross(&-foot).as_slice());
    v[3..6].copy_from_slice(spin.as_slice());
    let settings = Settings {
        stepping: Stepping::Adaptive,
        accounts: true,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    // Energies between impacts, each once.
    let mut seen: Vec<f64> = Vec::new();
    for k in 1..2000 {
        sim.run(1e-3 * f64::from(k), &[])?;
        let ledger = sim.ledger();
        let energy = ledger.kinetic + ledger.potential;
        if seen.last().is_none_or(|last| (energy - last).abs() > 1e-6) {
            seen.push(energy);
        }
        if seen.len() > 9 {
            break;
        }
    }
    let (mass, inertia, gravity) = (
        robot.body.mass,
        0.08390313333333332,
        robot.environment.gravity,
    );
    let weight = mass * gravity;
    let (sine, cosine) = slope.sin_cos();
    let stations = &disc.stations;
    let (mut x, mut theta, mut omega) = (0.0, lean, rate);
    let mut expected = Vec::new();
    for k in 0..9 {
        let (here, next) = (&stations[k % 6], &stations[(k + 1) % 6]);
        let (a, b) = (0.24 * here.reach, 0.24 * next.reach);
        let gap = (next.angle - here.angle).rem_euclid(TAU);
        let height = |x: f64, theta: f64| a * theta.cos() * cosine - (x + a * theta.sin()) * sine;
        let about = inertia + mass * a * a;
        expected.push(0.5 * about * omega * omega + weight * height(x, theta));
        // a cos θ = b cos(gap − θ): the foot of the next station is on the slope.
        let at = (a - b * gap.cos()).atan2(b * gap.sin());
        let squared = omega * omega + 2.0 * weight * (height(x, theta) - height(x, at)) / about;
        let before = squared.sqrt();
        omega = before * (inertia + mass * a * b * gap.cos()) / (inertia + mass * b * b);
        x += a * at.sin() + b * (gap - at).sin();
        theta = at - gap;
    }
    // Where heights count from is open.
    let offset = seen[0] - expected[0];
    for (seen, expected) in seen.iter().zip(&expected) {
        assert!((seen - offset - expected).abs() < 1e-6, "{seen} {expected}");
    }
    assert!(seen.len() > 6, "{seen:?}");
    Ok(())
}

/// A ball by its sensors, led along `path` from `start`, until it has come to its end.
fn led(path: &[[f64; 2]], start: Start, k: usize, seconds: f64) -> Result<Ball, GaitError> {
    let robot = drawn_ball(&twelve(&[]), &DrawnBalls::default(), 5, k)?;
    let mut setup = Roll::new(robot, seconds);
    setup.gait = Gait::Steered(Steered::new(path.to_vec()));
    setup.knows = Knows::Sensors(5 + k as u64);
    setup.stepping = Stepping::Fixed(1e-3);
    setup.start = start;
    let mut last = None;
    roll(&setup, |ball| {
        last = Some(ball.clone());
        ball.led.reached < path.len()
    })?;
    Ok(last.expect("at least a cycle"))
}

#[test]
fn a_ball_is_led_around_a_corner() -> Result<(), GaitError> {
    for (k, side) in [(0, 4.0), (1, -4.0)] {
        let path = [[4.0, 0.0], [4.0, side]];
        let ball = led(&path, Start::default(), k, 60.0)?;
        assert_eq!(ball.led.reached, 2, "{ball:?}");
        let [x, y, _] = ball.place;
        assert!((x - 4.0).hypot(y - side) < 1.0, "{ball:?}");
    }
    Ok(())
}

#[test]
fn thrown_down_it_goes_on_where_its_path_leads() -> Result<(), GaitError> {
    for k in 0..4 {
        let thrown = Some(Thrown::drawn(5, k, 5.0));
        let start = Start {
            thrown,
            ..Start::default()
        };
        let ball = led(&[[5.0, 0.0]], start, k, 40.0)?;
        assert_eq!(ball.led.reached, 1, "{ball:?}");
        assert!(ball.place[0] > 4.0 && ball.place[1].abs() < 1.0, "{ball:?}");
    }
    Ok(())
}

/// Any attitude is as likely as any other: the mean of each axis' components vanishes, that of their squares is a third.
#[test]
fn balls_are_thrown_at_any_attitude() {
    let count = 4000;
    let (mut mean, mut square, mut most) = (Vector3::zeros(), Vector3::zeros(), 0.0_f64);
    for k in 0..count {
        let Thrown { attitude, spin } = Thrown::drawn(3, k, 2.0);
        let [w, x, y, z] = attitude;
        let turn = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(w, x, y, z));
        let axis = turn * Vector3::x();
        mean += axis / count as f64;
        square += axis.component_mul(&axis) / count as f64;
        most = most.max(Vector3::from(spin).norm());
    }
    // Four standard errors: 0.0091 and 0.0047.
    assert!(mean.amax() < 0.037, "{mean}");
    assert!(
        (square - Vector3::repeat(1.0 / 3.0)).amax() < 0.019,
        "{square}"
    );
    assert!((1.95..=2.0).contains(&most), "{most}");
}

#[test]
fn what_is_no_path_is_refused() {
    let paths: [&[[f64; 2]]; 4] = [
        &[],
        &[[f64::NAN, 1.0]],
        &[[1.0, 0.0], [1.0, 0.0]],
        &[[0.0, 0.0]],
    ];
    for path in paths {
        let mut setup = Roll::new(twelve(&[]), 1.0);
        setup.gait = Gait::Steered(Steered::new(path.to_vec()));
        let Err(GaitError::Input { name, .. }) = roll(&setup, |_| true) else {
            panic!("{path:?}");
        };
        assert!(name.contains("path"), "{name}");
    }
    let mut setup = Roll::new(twelve(&[]), 1.0);
    setup.start.thrown = Some(Thrown {
        attitude: [0.0; 4],
        spin: [0.0; 3],
    });
    assert!(roll(&setup, |_| true).is_err());
}

/// Forces on feet, told every cycle or every fifth one, are those of one and the same run, and over a run by sensors they bear
/// the weight.
#[test]
fn forces_on_feet_bear_the_weight() -> Result<(), GaitError> {
    let told = |every: u64| -> Result<(Vec<Ball>, [f64; 3]), GaitError> {
        let mut setup = Roll::new(twelve(&[]), 2.0);
        setup.gait = Gait::Stable(Stable::default());
        setup.knows = Knows::Sensors(1);
        setup.forces_every = every;
        let (mut balls, mut sum) = (Vec::new(), [0.0; 3]);
        roll(&setup, |ball| {
            for (leg, force) in &ball.forces {
                assert!(*leg < 12 && force[0].hypot(force[1]) <= force[2] * (1.0 + 1e-6) + 1e-9);
                for k in 0..3 {
                    sum[k] += force[k] * every as f64 * 1e-3;
                }
            }
            let mut ball = ball.clone();
            ball.forces.clear();
            balls.push(ball);
            true
        })?;
        Ok((balls, sum))
    };
    let ((none, nothing), (each, all), (fifth, mean)) = (told(0)?, told(1)?, told(5)?);
    assert!(none == each && none == fifth, "asking changes the run");
    assert_eq!(nothing, [0.0; 3]);
    // 3.6 kg; it comes to 1.1 m/s, and falls and rises by less than 1 m/s.
    let weight = 3.6 * 9.80665 * 2.0;
    for sum in [all, mean] {
        assert!(
            (sum[2] - weight).abs() < 3.6 && (0.0..3.6 * 2.5).contains(&sum[0]),
            "{sum:?}"
        );
    }
    assert!(
        (0..3).all(|k| (all[k] - mean[k]).abs() < 1e-9),
        "{all:?} {mean:?}"
    );
    Ok(())
}
