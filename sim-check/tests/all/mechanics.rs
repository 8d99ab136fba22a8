//! Mechanics against closed forms and invariants.

use nalgebra::{Matrix3, UnitQuaternion};
use saltus_sim_check::{
    ContactPoint, Friction, Happening, Joint, Mechanism, Settings, Sim, SimError, Surface, Tree,
    Vec3,
};

use crate::bodies::{G, body, diagonal, down, free_body, spinning};

/// Arithmetic–geometric mean.
fn agm(mut a: f64, mut b: f64) -> f64 {
    while (a - b).abs() > 1e-16 * a {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    a
}

#[test]
fn a_pendulum_swings_in_the_time_of_the_elliptic_integral() -> Result<(), SimError> {
    let (length, mass, amplitude) = (0.7, 1.3, 2.5_f64);
    let mut tree = Tree::default();
    tree.add(body(
        "bob",
        None,
        Joint::Revolute(Vec3::y()),
        Vec3::zeros(),
        mass,
        Vec3::new(0.0, 0.0, -length),
        Matrix3::zeros(),
    ))?;
    let mechanism = Mechanism::new(tree, down());
    let mut sim = Sim::new(&mechanism, &[amplitude], &[0.0], Settings::default())?;
    let start = sim.ledger();
    // T = 2π √(l/g) / agm(1, cos(θ/2)).
    let period =
        2.0 * std::f64::consts::PI * (length / G).sqrt() / agm(1.0, (amplitude / 2.0).cos());
    sim.run(10.0 * period, &[])?;
    assert!(
        (sim.coordinates()[0] - amplitude).abs() < 1e-9,
        "{}",
        sim.coordinates()[0] - amplitude
    );
    assert!(sim.ledger().residual(&start).abs() < 1e-9 * start.potential.abs());
    Ok(())
}

#[test]
fn a_double_pendulum_is_lagranges_and_keeps_its_energy() -> Result<(), SimError> {
    let mut tree = Tree::default();
    let upper = body(
        "upper",
        None,
        Joint::Revolute(Vec3::y()),
        Vec3::zeros(),
        1.0,
        Vec3::new(0.0, 0.0, -1.0),
        Matrix3::zeros(),
    );
    let upper = tree.add(upper)?;
    let at = Vec3::new(0.0, 0.0, -1.0);
    tree.add(body(
        "lower",
        Some(upper),
        Joint::Revolute(Vec3::y()),
        at,
        0.5,
        Vec3::new(0.0, 0.0, -0.8),
        Matrix3::zeros(),
    ))?;
    let mechanism = Mechanism::new(tree, down());
    let settings = Settings {
        tolerance: 1e-12,
        ..Settings::default()
    };
    let mut sim = Sim::new(&mechanism, &[2.0, 0.5], &[0.0, 0.0], settings)?;
    let start = sim.ledger();
    sim.run(3.0, &[])?;
    assert!(sim.ledger().residual(&start).abs() < 1e-9 * start.potential.abs());
    // Lagrange's equations of the textbook, in absolute angles, by classical Runge–Kutta with small
    // steps.
    let (m1, m2, l1, l2) = (1.0, 0.5, 1.0, 0.8);
    let f = |s: [f64; 4]| {
        let [a, b, u, w] = s;
        let d = a - b;
        let den = m1 + m2 * d.sin().powi(2);
        let du = (m2 * G * b.sin() * d.cos()
            - m2 * d.sin() * (l1 * u * u * d.cos() + l2 * w * w)
            - (m1 + m2) * G * a.sin())
            / (l1 * den);
        let dw = ((m1 + m2) * (l1 * u * u * d.sin() - G * b.sin() + G * a.sin() * d.cos())
            + m2 * l2 * w * w * d.sin() * d.cos())
            / (l2 * den);
        [u, w, du, dw]
    };
    let mut s: [f64; 4] = [2.0, 2.5, 0.0, 0.0];
    let n = 100_000;
    let h = 3.0 / f64::from(n);
    let add =
        |s: [f64; 4], k: [f64; 4], h: f64| std::array::from_fn::<f64, 4, _>(|i| s[i] + h * k[i]);
    for _ in 0..n {
        let k1 = f(s);
        let k2 = f(add(s, k1, h / 2.0));
        let k3 = f(add(s, k2, h / 2.0));
        let k4 = f(add(s, k3, h));
        s = std::array::from_fn(|i| s[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    let q = sim.coordinates();
    assert!(
        (q[0] - s[0]).abs() < 1e-9 && (q[0] + q[1] - s[1]).abs() < 1e-9,
        "{} {}",
        q[0] - s[0],
        q[0] + q[1] - s[1]
    );
    Ok(())
}

#[test]
fn a_free_body_keeps_energy_and_momentum_for_five_seconds() -> Result<(), SimError> {
    let mechanism = free_body(12)?;
    let (q, v) = spinning(12);
    let mut sim = Sim::new(&mechanism, &q, &v, Settings::default())?;
    let (start, (linear, angular)) = (sim.ledger(), sim.pose().momentum(&mechanism.tree));
    sim.run(5.0, &[])?;
    let (end, (linear_5, angular_5)) = (sim.ledger(), sim.pose().momentum(&mechanism.tree));
    let scale = start.kinetic;
    let mass = 2.5 + 12.0 * 0.05;
    println!(
        "energy {:.1e}, angular momentum {:.1e}, effort {:?}",
        end.residual(&start) / scale,
        (angular_5 - angular).norm() / angular.norm(),
        sim.effort()
    );
    assert!(end.residual(&start).abs() < 1e-9 * scale);
    assert!((angular_5 - angular).norm() < 1e-9 * angular.norm());
    assert!((linear_5 - linear - down() * mass * 5.0).norm() < 1e-9 * linear_5.norm());
    Ok(())
}

#[test]
fn a_top_spins_as_its_three_integrals_say() -> Result<(), SimError> {
    // A heavy symmetric top on a fixed point: two revolutes and its spin.
    let mut tree = Tree::default();
    let none = || (0.0, Vec3::zeros(), Matrix3::zeros());
    let (m, c, i) = none();
    let a = tree.add(body(
        "precession",
        None,
        Joint::Revolute(Vec3::z()),
        Vec3::zeros(),
        m,
        c,
        i,
    ))?;
    let b = tree.add(body(
        "nutation",
        Some(a),
        Joint::Revolute(Vec3::x()),
        Vec3::zeros(),
        m,
        c,
        i,
    ))?;
    let (mass, height, across, along) = (0.4, 0.06, 8e-4, 3e-4);
    tree.add(body(
        "top",
        Some(b),
        Joint::Revolute(Vec3::z()),
        Vec3::zeros(),
        mass,
        Vec3::new(0.0, 0.0, height),
        diagonal(across, across, along),
    ))?;
    let mechanism = Mechanism::new(tree, down());
    let settings = Settings {
        tolerance: 1e-12,
        ..Settings::default()
    };
    let (tilt, spin) = (0.5, 120.0);
    let mut sim = Sim::new(&mechanism, &[0.0, tilt, 0.0], &[0.0, 0.0, spin], settings)?;
    let energy = sim.ledger();
    let about_foot = across + mass * height * height;
    let integrals = |q: &[f64], v: &[f64]| {
        let (theta, precession) = (q[1], v[0]);
        let own = along * (v[2] + precession * theta.cos());
        (
            own,
            about_foot * precession * theta.sin().powi(2) + own * theta.cos(),
        )
    };
    let (own, vertical) = integrals(sim.coordinates(), sim.velocities());
    let mut greatest: f64 = 0.0;
    for k in 1..=400 {
        sim.run(0.005 * f64::from(k), &[])?;
        let (o, z) = integrals(sim.coordinates(), sim.velocities());
        assert!((o - own).abs() < 1e-9 * own && (z - vertical).abs() < 1e-9 * vertical);
        greatest = greatest.max(sim.coordinates()[1]);
    }
    assert!(sim.ledger().residual(&energy).abs() < 1e-9 * energy.kinetic);
    // It nutates between its start and the other root of the cubic f(u) = (1 − u²)(2E' − 2mgh u)/A
    // − ((L_z − L u)/A)².
    let f = |u: f64| {
        let e = mass * G * height * tilt.cos();
        (1.0 - u * u) * 2.0 * (e - mass * G * height * u) / about_foot
            - ((vertical - own * u) / about_foot).powi(2)
    };
    let (mut low, mut high) = (-1.0, tilt.cos() - 1e-6);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if f(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    // Sampling every 5 ms misses the turning point by a little.
    assert!(
        greatest <= high.acos() + 1e-9 && greatest > high.acos() - 1e-3,
        "{greatest} {}",
        high.acos()
    );
    Ok(())
}

#[test]
fn a_free_rigid_body_turns_as_euler_says() -> Result<(), SimError> {
    // A symmetric body: its axis goes around the angular momentum at L/I.
    let mut tree = Tree::default();
    tree.add(body(
        "disc",
        None,
        Joint::Free,
        Vec3::zeros(),
        1.0,
        Vec3::zeros(),
        diagonal(0.01, 0.01, 0.018),
    ))?;
    let mechanism = Mechanism::new(tree, Vec3::zeros());
    let mut sim = Sim::new(
        &mechanism,
        &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        &[0.0, 0.0, 0.0, 1.0, 0.0, 8.0],
        Settings::default(),
    )?;
    let momentum = Vec3::new(0.01, 0.0, 0.144);
    let time = 3.0;
    sim.run(time, &[])?;
    let axis = nalgebra::Unit::new_normalize(momentum);
    let expected =
        UnitQuaternion::from_axis_angle(&axis, momentum.norm() / 0.01 * time) * Vec3::z();
    let found = sim.pose().frames[0].rotation * Vec3::z();
    assert!(
        (found - expected).norm() < 1e-9,
        "{}",
        (found - expected).norm()
    );
    Ok(())
}

#[test]
fn a_slider_meets_its_end_stop_and_stays() -> Result<(), SimError> {
    // Thrown up against a stop, which takes its speed, it falls back onto the other.
    let mut tree = Tree::default();
    tree.add(body(
        "slider",
        None,
        Joint::Prismatic(Vec3::z()),
        Vec3::zeros(),
        0.3,
        Vec3::zeros(),
        Matrix3::zeros(),
    ))?;
    let mut mechanism = Mechanism::new(tree, down());
    mechanism.joints[0].stops = (0.0, 0.2);
    let speed = 3.0_f64;
    let mut sim = Sim::new(&mechanism, &[0.0], &[speed], Settings::default())?;
    let start = sim.ledger();
    sim.run(1.0, &[])?;
    let up = (speed - (speed * speed - 2.0 * G * 0.2).sqrt()) / G;
    let down = (2.0 * 0.2 / G).sqrt();
    let times: Vec<f64> = sim
        .events()
        .iter()
        .filter(|e| e.what == Happening::EndStop(0))
        .map(|e| e.time)
        .collect();
    assert_eq!(times.len(), 2, "{:?}", sim.events());
    assert!(
        (times[0] - up).abs() < 1e-9 && (times[1] - up - down).abs() < 1e-9,
        "{times:?}"
    );
    assert_eq!((sim.coordinates()[0], sim.velocities()[0]), (0.0, 0.0));
    assert!(sim.ledger().residual(&start).abs() < 1e-9 * start.kinetic);
    assert!((sim.joint_reaction(0) - 0.3 * G).abs() < 1e-12);
    Ok(())
}

#[test]
fn dry_friction_stops_a_slider_where_its_work_says() -> Result<(), SimError> {
    let mut tree = Tree::default();
    tree.add(body(
        "slider",
        None,
        Joint::Prismatic(Vec3::x()),
        Vec3::zeros(),
        0.3,
        Vec3::zeros(),
        Matrix3::zeros(),
    ))?;
    let mut mechanism = Mechanism::new(tree, down());
    mechanism.joints[0].friction = 0.7;
    let mut sim = Sim::new(&mechanism, &[0.0], &[2.0], Settings::default())?;
    sim.run(10.0, &[])?;
    let way = 0.5 * 0.3 * 4.0 / 0.7;
    assert!((sim.coordinates()[0] - way).abs() < 1e-9 && sim.velocities()[0] == 0.0);
    Ok(())
}

/// A block of 0.4 × 0.3 × 0.2 m and 5 kg with eight corners, flat on a slope (rad) under
/// `friction`.
fn block(slope: f64, friction: f64) -> Result<(Mechanism, Vec<f64>), SimError> {
    let half = Vec3::new(0.2, 0.15, 0.1);
    let mut tree = Tree::default();
    let inertia = |a: f64, b: f64| 5.0 / 3.0 * (a * a + b * b);
    let moments = diagonal(
        inertia(half.y, half.z),
        inertia(half.x, half.z),
        inertia(half.x, half.y),
    );
    tree.add(body(
        "block",
        None,
        Joint::Free,
        Vec3::zeros(),
        5.0,
        Vec3::zeros(),
        moments,
    ))?;
    let mut mechanism = Mechanism::new(tree, down());
    for k in 0..8 {
        let sign = |bit: usize| if k >> bit & 1 == 0 { -1.0 } else { 1.0 };
        let center = half.component_mul(&Vec3::new(sign(0), sign(1), sign(2)));
        mechanism.points.push(ContactPoint {
            name: format!("corner {k}"),
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
    let turn = UnitQuaternion::from_axis_angle(&Vec3::y_axis(), -slope);
    let at = turn * Vec3::new(0.0, 0.0, half.z);
    let q = vec![at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k];
    Ok((mechanism, q))
}

#[test]
fn a_block_below_the_friction_angle_does_not_creep() -> Result<(), SimError> {
    let (mechanism, q) = block(0.3, 0.35)?;
    let mut sim = Sim::new(&mechanism, &q, &[0.0; 6], Settings::default())?;
    sim.run(10.0, &[])?;
    let moved = (0..3)
        .map(|k| (sim.coordinates()[k] - q[k]).powi(2))
        .sum::<f64>()
        .sqrt();
    println!("creep in 10 s: {moved:.1e} m, effort {:?}", sim.effort());
    assert!(moved < 1e-9);
    Ok(())
}

#[test]
fn a_block_above_the_friction_angle_slides_as_newton_says() -> Result<(), SimError> {
    let (slope, friction) = (0.5_f64, 0.2);
    let (mechanism, q) = block(slope, friction)?;
    let mut sim = Sim::new(&mechanism, &q, &[0.0; 6], Settings::default())?;
    sim.run(2.0, &[])?;
    let down = -(sim.velocities()[0] * slope.cos() + sim.velocities()[2] * slope.sin());
    let acceleration = G * (slope.sin() - friction * slope.cos());
    println!("acceleration off by {:.1e} m/s²", down / 2.0 - acceleration);
    assert!((down / 2.0 - acceleration).abs() < 1e-8);
    Ok(())
}

/// A sphere of `radius` (m) that touches a slope (rad), with moment of inertia ⅖ m r².
fn sphere(radius: f64, slope: f64, friction: f64, restitution: f64) -> Result<Mechanism, SimError> {
    let mass = 0.6;
    let moment = 0.4 * mass * radius * radius;
    let mut tree = Tree::default();
    tree.add(body(
        "sphere",
        None,
        Joint::Free,
        Vec3::zeros(),
        mass,
        Vec3::zeros(),
        diagonal(moment, moment, moment),
    ))?;
    let mut mechanism = Mechanism::new(tree, down());
    mechanism.points.push(ContactPoint {
        name: "sphere".into(),
        body: 0,
        center: Vec3::zeros(),
        radius,
        bar: None,
    });
    mechanism.surfaces.push(Surface::ground(slope));
    mechanism.material.friction = Friction::Cone {
        standing: friction,
        slipping: friction,
    };
    mechanism.material.restitution = restitution;
    Ok(mechanism)
}

#[test]
fn a_sliding_sphere_comes_to_roll() -> Result<(), SimError> {
    let (radius, friction, speed) = (0.11, 0.2, 3.0);
    let mechanism = sphere(radius, 0.0, friction, 0.0)?;
    let direction = Vec3::new(0.6, 0.8, 0.0);
    let v = [speed * direction.x, speed * direction.y, 0.0, 0.0, 0.0, 0.0];
    let mut sim = Sim::new(
        &mechanism,
        &[0.0, 0.0, radius, 1.0, 0.0, 0.0, 0.0],
        &v,
        Settings::default(),
    )?;
    let start = sim.ledger();
    sim.run(2.0, &[])?;
    let sticks = sim
        .events()
        .iter()
        .find(|e| matches!(e.what, Happening::Stick(..)))
        .map_or(f64::NAN, |e| e.time);
    let rolling = sim.velocities()[0].hypot(sim.velocities()[1]);
    println!(
        "rolls after {:.1e} s too much, {:.1e} m/s too fast",
        sticks - 2.0 * speed / (7.0 * friction * G),
        rolling - 5.0 * speed / 7.0
    );
    assert!((sticks - 2.0 * speed / (7.0 * friction * G)).abs() < 1e-6);
    assert!((rolling - 5.0 * speed / 7.0).abs() < 1e-6);
    assert!(sim.ledger().residual(&start).abs() < 1e-9 * start.kinetic);
    Ok(())
}

#[test]
fn a_sphere_rolls_down_a_slope() -> Result<(), SimError> {
    let (radius, slope) = (0.11, 0.3_f64);
    let mechanism = sphere(radius, slope, 1.0, 0.0)?;
    let at = [
        -radius * slope.sin(),
        0.0,
        radius * slope.cos(),
        1.0,
        0.0,
        0.0,
        0.0,
    ];
    let mut sim = Sim::new(&mechanism, &at, &[0.0; 6], Settings::default())?;
    sim.run(1.5, &[])?;
    let down = -(sim.velocities()[0] * slope.cos() + sim.velocities()[2] * slope.sin());
    let wanted = 5.0 / 7.0 * G * slope.sin() * 1.5;
    println!("rolls {:.1e} m/s too fast", down - wanted);
    assert!((down - wanted).abs() < 1e-6);
    Ok(())
}

#[test]
fn a_ball_bounces_to_e_squared_of_its_height() -> Result<(), SimError> {
    let (radius, e, drop) = (0.05, 0.85, 1.0);
    let mechanism = sphere(radius, 0.0, 0.3, e)?;
    let mut sim = Sim::new(
        &mechanism,
        &[0.0, 0.0, radius + drop, 1.0, 0.0, 0.0, 0.0],
        &[0.0; 6],
        Settings::default(),
    )?;
    let mut wanted = drop;
    let rising = |_: f64, _: &[f64], v: &[f64]| v[2];
    // The first watch is at the drop itself.
    sim.run(0.1, &[])?;
    for bounce in 1..=10 {
        let before = sim.events().len();
        while sim.events().len() == before {
            sim.run(sim.time() + 0.01, &[])?;
        }
        sim.run(sim.time() + 10.0, &[&rising])?;
        wanted *= e * e;
        let height = sim.coordinates()[2] - radius;
        assert!(
            (height - wanted).abs() < 1e-6 * drop,
            "bounce {bounce}: {height} {wanted}"
        );
    }
    Ok(())
}

/// What a gyro on the wheel of a raised boom says is the wheel's angular velocity along its axle.
#[test]
fn a_gyro_on_a_raised_boom_feels_the_turn() {
    let robot = saltus_robot::resolve("rats-boom", &[]).expect("built in");
    let rig = saltus_sim_check::Rig::new(&robot, &[]).expect("a rig");
    let tree = &rig.mechanism.tree;
    let (mut q, mut v) = (vec![0.0; tree.coordinates()], vec![0.0; tree.velocities()]);
    (q[1], v[0], v[1]) = (0.3, 1.2, -0.4);
    v[rig.lean_velocity()] = 5.0;
    let mut pose = saltus_sim_check::Pose::default();
    pose.set(tree, &q, &v);
    let frame = &pose.frames[rig.wheel];
    let axle = frame.point(&Vec3::y()) - frame.point(&Vec3::zeros());
    let felt = pose.velocities[rig.wheel].angular.dot(&axle);
    assert!((rig.spin(&q, &v) - felt).abs() < 1e-14, "{felt}");
    assert!((felt - 5.0).abs() > 0.3, "the turn is felt: {felt}");
}
