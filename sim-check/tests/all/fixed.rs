//! Fixed steps: their order, their robustness, their errors.

use nalgebra::Matrix3;
use saltus_robot::Robot;
use saltus_robot::space::rests;
use saltus_sim_check::{
    Body, ContactPoint, Drag, End, Friction, Joint, Launch, Mechanism, Outcome, Placement, Plan,
    Rig, Settings, Sim, SimError, Stepping, Surface, Tree, Vec3,
};

const G: f64 = 9.80665;
const LAUNCH: Launch = Launch {
    rate: 3.0,
    lean: 0.0,
    firing_angle: 0.15,
    valve_open: 0.04,
};

fn fixed(h: f64) -> Settings {
    Settings {
        stepping: Stepping::Fixed(h),
        ..Settings::default()
    }
}

fn slider(axis: Vec3) -> Result<Mechanism, SimError> {
    let mut tree = Tree::default();
    tree.add(Body {
        name: "slider".into(),
        parent: None,
        joint: Joint::Prismatic(axis),
        placement: Placement::identity(),
        mass: 0.3,
        center: Vec3::zeros(),
        inertia: Matrix3::zeros(),
    })?;
    Ok(Mechanism::new(tree, Vec3::new(0.0, 0.0, -G)))
}

#[test]
fn landings_converge_in_second_order() -> Result<(), SimError> {
    for name in ["rats-boom", "rats-planar"] {
        let rig = Rig::new(&Robot::builtin(name).expect("it is built in"), &[])?;
        let jump = |settings| {
            rig.jump(
                &LAUNCH,
                &Plan {
                    sample: 0.01,
                    settings,
                    ..Plan::default()
                },
            )
        };
        let limit = jump(Settings::default())?;
        // Thrice what they are, for the events of other launches lie elsewhere in their steps.
        for (h, landing, time) in [
            (4e-3, 4e-3, 1.5e-4),
            (1e-3, 3e-4, 1.5e-5),
            (1e-4, 3e-6, 1.5e-7),
        ] {
            let report = jump(fixed(h))?;
            assert_eq!(report.end, End::Landed);
            let (found, wanted) = (
                report.lift_off.expect("it landed"),
                limit.lift_off.expect("it landed"),
            );
            assert!(
                (report.landing - limit.landing).abs() < landing,
                "{name} {h}: {}",
                report.landing
            );
            assert!(
                (report.apex - limit.apex).abs() < landing,
                "{name} {h}: {}",
                report.apex
            );
            assert!(
                (found.time - wanted.time).abs() < time,
                "{name} {h}: {}",
                found.time
            );
            assert_eq!(found.outcome, Outcome::Stroke);
        }
    }
    Ok(())
}

#[test]
fn steps_that_are_none_are_errors() -> Result<(), SimError> {
    let rig = Rig::new(&Robot::rats_planar(), &[])?;
    for h in [0.0, -1e-3, f64::NAN, f64::INFINITY, 1.0] {
        let error = rig.jump(
            &LAUNCH,
            &Plan {
                settings: fixed(h),
                ..Plan::default()
            },
        );
        assert!(
            matches!(&error, Err(SimError::Input { name, .. }) if name.contains("fixed step")),
            "{h}"
        );
    }
    Ok(())
}

#[test]
fn what_diverges_is_an_error() -> Result<(), SimError> {
    // Drag that would turn the motion round a thousand times within a step.
    let mut mechanism = slider(Vec3::x())?;
    mechanism.drag = Some(Drag {
        body: 0,
        coefficient: 1e3,
    });
    let mut sim = Sim::new(&mechanism, &[0.0], &[100.0], fixed(0.1))?;
    assert!(matches!(sim.run(10.0, &[]), Err(SimError::Diverged { .. })));
    Ok(())
}

#[test]
fn a_bouncing_ball_comes_to_rest() -> Result<(), SimError> {
    let mut mechanism = slider(Vec3::z())?;
    let point = ContactPoint {
        name: "ball".into(),
        body: 0,
        center: Vec3::zeros(),
        radius: 0.05,
        bar: None,
    };
    mechanism.points.push(point);
    mechanism.surfaces.push(Surface::ground(0.0));
    mechanism.material.restitution = 0.5;
    let mut sim = Sim::new(&mechanism, &[0.55], &[0.0], fixed(1e-3))?;
    // It falls for √(2 h/g), flies e times as long after the first bounce, and after infinitely
    // many rests at 0.96 s.
    let drop = (2.0 * 0.5 / G).sqrt();
    sim.run(1.5 * drop, &[])?;
    let (speed, time) = (0.5 * G * drop, 0.5 * drop);
    let wanted = 0.05 + speed * time - 0.5 * G * time * time;
    // Parabolas are followed exactly, and the bounce is located to 1e-8 of a step.
    assert!(
        (sim.coordinates()[0] - wanted).abs() < 1e-9,
        "{} {wanted}",
        sim.coordinates()[0]
    );
    sim.run(1.5, &[])?;
    assert!(
        (sim.coordinates()[0] - 0.05).abs() < 1e-6,
        "{}",
        sim.coordinates()[0]
    );
    assert!(sim.velocities()[0].abs() < 1e-9);
    Ok(())
}

#[test]
fn stops_and_dry_friction_hold() -> Result<(), SimError> {
    let mut mechanism = slider(Vec3::x())?;
    mechanism.joints[0].friction = 0.7;
    let mut sim = Sim::new(&mechanism, &[0.0], &[2.0], fixed(1e-3))?;
    sim.run(3.0, &[])?;
    let way = 0.5 * 0.3 * 4.0 / 0.7;
    // It stops within a step, so at most v h/2 = a h²/2 off.
    assert!(
        (sim.coordinates()[0] - way).abs() < 2e-6,
        "{}",
        sim.coordinates()[0] - way
    );
    assert_eq!(sim.velocities()[0], 0.0);
    let mut mechanism = slider(Vec3::z())?;
    mechanism.joints[0].stops = (0.0, 0.2);
    let mut sim = Sim::new(&mechanism, &[0.0], &[3.0], fixed(1e-3))?;
    let start = sim.ledger();
    sim.run(1.0, &[])?;
    assert!(sim.coordinates()[0].abs() < 1e-15 && sim.velocities()[0] == 0.0);
    // Free fall is a parabola, which the midpoint rule follows exactly.
    assert!(
        sim.ledger().residual(&start).abs() < 1e-6,
        "{}",
        sim.ledger().residual(&start)
    );
    Ok(())
}

/// A block of 5 kg on four corners on a slope (rad).
fn block(slope: f64, friction: f64) -> Result<(Mechanism, Vec<f64>), SimError> {
    let mut tree = Tree::default();
    tree.add(Body {
        name: "block".into(),
        parent: None,
        joint: Joint::Free,
        placement: Placement::identity(),
        mass: 5.0,
        center: Vec3::zeros(),
        inertia: Matrix3::from_diagonal(&Vec3::new(0.05, 0.08, 0.1)),
    })?;
    let mut mechanism = Mechanism::new(tree, Vec3::new(0.0, 0.0, -G));
    for (x, y) in [(0.2, 0.15), (0.2, -0.15), (-0.2, 0.15), (-0.2, -0.15)] {
        let center = Vec3::new(x, y, -0.1);
        mechanism.points.push(ContactPoint {
            name: "corner".into(),
            body: 0,
            center,
            radius: 0.0,
            bar: None,
        });
    }
    mechanism.surfaces.push(Surface::ground(slope));
    mechanism.material.friction = Friction::Cone {
        standing: friction,
        slipping: friction,
    };
    let (s, c) = (0.5 * slope).sin_cos();
    Ok((
        mechanism,
        vec![-0.1 * slope.sin(), 0.0, 0.1 * slope.cos(), c, 0.0, -s, 0.0],
    ))
}

#[test]
fn a_block_stands_below_the_friction_angle_and_slides_above() -> Result<(), SimError> {
    let (mechanism, q) = block(0.3, 0.35)?;
    let mut sim = Sim::new(&mechanism, &q, &[0.0; 6], fixed(1e-3))?;
    sim.run(2.0, &[])?;
    let moved = (0..3)
        .map(|k| (sim.coordinates()[k] - q[k]).powi(2))
        .sum::<f64>()
        .sqrt();
    assert!(moved < 1e-9, "{moved}");
    let (slope, friction) = (0.5_f64, 0.2);
    let (mechanism, q) = block(slope, friction)?;
    let mut sim = Sim::new(&mechanism, &q, &[0.0; 6], fixed(1e-3))?;
    sim.run(1.0, &[])?;
    let down = -(sim.velocities()[0] * slope.cos() + sim.velocities()[2] * slope.sin());
    assert!(
        (down - G * (slope.sin() - friction * slope.cos())).abs() < 1e-8,
        "{down}"
    );
    Ok(())
}

#[test]
fn a_stiff_ground_and_a_tiny_chamber_are_no_trouble() -> Result<(), Box<dyn std::error::Error>> {
    let rigid = Rig::new(&Robot::rats_planar(), &[])?.jump(&LAUNCH, &Plan::default())?;
    // With friction that cannot be infinite: a foot that the end stop pulls up would stick to the
    // last.
    let stiff = [
        "stiffness_n_per_m=1e7",
        "damping_n_s_per_m=2e3",
        "static_friction=1.0",
        "kinetic_friction=1.0",
    ]
    .map(|key| format!("ground.{key}"));
    let rig = Rig::new(&saltus_robot::resolve("rats-planar", &stiff)?, &[])?;
    let report = rig.jump(
        &LAUNCH,
        &Plan {
            settings: fixed(1e-3),
            ..Plan::default()
        },
    )?;
    assert!(
        (report.landing - rigid.landing).abs() < 1e-2,
        "{} {}",
        report.landing,
        rigid.landing
    );
    let tiny = saltus_robot::resolve("rats-boom", &["leg.dead_volume_m3=1e-9".into()])?;
    let rig = Rig::new(&tiny, &[])?;
    for h in [4e-3, 1e-3, 2.5e-4] {
        let report = rig.jump(
            &LAUNCH,
            &Plan {
                settings: fixed(h),
                ..Plan::default()
            },
        )?;
        for sample in &report.samples {
            // Gauge 120 psi is 928,697 Pa absolute.
            assert!(
                (1e3..=928_700.0).contains(&sample.pressure),
                "{h} {} {}",
                sample.time,
                sample.pressure
            );
        }
        let limit = rig.jump(&LAUNCH, &Plan::default())?;
        assert!(
            (report.landing - limit.landing).abs() < 1e-2,
            "{h}: {} {}",
            report.landing,
            limit.landing
        );
    }
    Ok(())
}

/// Momentum is what weight and the ground's impulses have made of it: with three feet that hold each other, a leg that fires,
/// a hop and a landing.
#[test]
fn impulses_of_the_ground_are_what_changes_the_momentum() -> Result<(), SimError> {
    let robot = Robot::builtin("rats-twelve").expect("it is built in");
    let directions = robot
        .space
        .as_ref()
        .expect("it is in space")
        .directions
        .vectors();
    let rest = &rests(&directions)[0];
    let rig = Rig::new(&robot, &[])?;
    let q = rig.stand_on(rest, &[1.0, 0.0, 0.0])?;
    let v = vec![0.0; rig.mechanism.tree.velocities()];
    let mass: f64 = rig
        .mechanism
        .tree
        .bodies()
        .iter()
        .map(|body| body.mass)
        .sum();
    // Legs that slide while the ball turns change the mass matrix within a step: 3.3e-6 N s at 1 ms.
    for (h, tolerance) in [(1e-3, 2e-5), (2.5e-4, 2e-5)] {
        let mut sim = Sim::new(&rig.mechanism, &q, &v, fixed(h))?;
        sim.release_legs()?;
        sim.keep_impulses();
        sim.fire(rest.legs[0], 0.05)?;
        let (mut pushed, mut greatest, mut flew) = (Vec3::zeros(), 0.0_f64, false);
        let mut worst = 0.0_f64;
        for k in 1..=400 {
            sim.run(1e-3 * f64::from(k), &[])?;
            let impulses = sim.impulses().expect("they are kept");
            flew |= impulses.is_empty() && k > 20;
            for (point, impulse) in impulses {
                assert!(point < 12, "a foot");
                // Within the cone of friction 1.
                assert!(impulse.x.hypot(impulse.y) <= impulse.z * (1.0 + 1e-6) + 1e-12);
                greatest = greatest.max(impulse.z / 1e-3);
                pushed += impulse;
            }
            let weight = Vec3::new(0.0, 0.0, -mass * G * sim.time());
            let (linear, _) = sim.pose().momentum(&rig.mechanism.tree);
            worst = worst.max((linear - pushed - weight).norm());
        }
        // A leg that leans by 37° pushes with 250 N less its spring; no foot bears a multiple of that.
        assert!(flew && (150.0..750.0).contains(&greatest), "{greatest} N");
        assert!(worst < tolerance, "{worst} N s");
    }
    Ok(())
}
