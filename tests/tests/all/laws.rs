//! Laws of mechanics that every robot obeys, whatever its parameters.

use std::f64::consts::FRAC_PI_2;

use proptest::prelude::*;
use saltus_lagrangian::{FINE, Launch, LiftOff, Outcome, Sample, Stance};
use saltus_robot::{Drive, GaugePressure, Robot, Term};
use saltus_tests::oracle::held_normal;
use saltus_tests::robots::{Kind, any_ordinary, cases, jump, launch, ordinary, stroke_time};

fn stance(robot: &Robot) -> Stance<f64> {
    Stance::new(robot, |_, x| x)
}

/// Greatest height (m) that the wheel's centre comes to in a hop; where the leg only lifts it for a
/// while, that height.
fn apex(robot: &Robot, end: &LiftOff) -> f64 {
    let rise = end.axle_rates[1].max(0.0).powi(2) / (2.0 * robot.environment.gravity);
    end.axle[1] + if end.outcome.is_jump() { rise } else { 0.0 }
}

/// The same robot in other units of length, mass and time: every number times its dimension.
fn in_units(robot: &Robot, length: f64, mass: f64, time: f64) -> Robot {
    let mut scaled = robot.clone();
    for term in Term::ALL {
        let [m, l, t] = term.spec().quantity.dimension;
        if let Some(x) = term.of(robot) {
            term.set(
                &mut scaled,
                x * mass.powi(m) * length.powi(l) * time.powi(t),
            );
        }
    }
    if let Drive::Table(table) = &mut scaled.leg.drive {
        let force = mass * length / (time * time);
        table.extensions.iter_mut().for_each(|d| *d *= length);
        table.speeds.iter_mut().for_each(|v| *v *= length / time);
        table.forces.iter_mut().for_each(|f| *f *= force);
    }
    scaled
}

/// Weights of the closed Newton–Cotes rule on nine points, exact to degree 9.
const NEWTON_COTES: [f64; 9] = [
    989.0, 5888.0, -928.0, 10496.0, -4540.0, 10496.0, -928.0, 5888.0, 989.0,
];

/// A spring leg without losses.
fn lossless(mut robot: Robot) -> Robot {
    robot.leg.viscous_friction = 0.0;
    robot.leg.coulomb_friction = 0.0;
    robot.leg.return_spring = None;
    robot.leg.cushion = None;
    robot
}

proptest! {
    #![proptest_config(cases(300))]

    #[test]
    fn the_energy_ledger_closes((robot, launch) in jump(any_ordinary())) {
        let Ok(trace) = stance(&robot).trace(&launch) else { return Err(TestCaseError::fail("no stance")) };
        let ledger = trace.energy;
        // What is asked for: 1e-9 of the work done, by the drive or, while the leg is held, by the
        // weight.
        let work = ledger.drive.abs() + ledger.losses.abs() + ledger.potential.abs() + ledger.kinetic.abs();
        prop_assert!(ledger.residual().abs() <= 1e-9 * work, "{:e} of {:?}", ledger.residual(), ledger);
        prop_assert!(ledger.losses >= -1e-9 * work || robot.leg.return_spring.is_some(), "{:?}", ledger);
    }

    #[test]
    fn a_lossless_spring_keeps_the_energy((robot, launch) in jump(ordinary(Kind::Spring).prop_map(lossless))) {
        let Drive::Spring { stiffness, compression } = robot.leg.drive else { unreachable!() };
        let trace = stance(&robot).trace(&launch).expect("a stance");
        let (m, i) = (robot.body.mass, robot.body.inertia);
        let parts = |s: &Sample| {
            let reach = robot.body.radius + s.extension;
            let left = compression - s.extension;
            [
                0.5 * (i + m * reach * reach) * s.rate * s.rate,
                0.5 * m * s.extension_rate * s.extension_rate,
                m * robot.environment.gravity * reach * s.lean.cos(),
                0.5 * stiffness * left * left,
            ]
        };
        let Some(first) = trace.samples.first().map(parts) else { return Ok(()) };
        let start: f64 = first.iter().sum();
        for sample in &trace.samples {
            let now: f64 = parts(sample).iter().sum();
            // The tolerance of 1e-12 a step is relative to 1 + |state|; the least robots are a
            // thousandth of that.
            prop_assert!((now - start).abs() <= 1e-9 * start, "{:e} at {:?}", now - start, sample);
        }
    }

    #[test]
    fn only_the_weight_changes_the_angular_momentum((robot, launch) in jump(any_ordinary())) {
        // A leg's force has no moment about the foot: d/dt (I + m R²) ω = m g R sin φ, with any
        // leg.
        let trace = stance(&robot).trace(&launch).expect("a stance");
        let (m, g) = (robot.body.mass, robot.environment.gravity);
        let reach = |s: &Sample| robot.body.radius + s.extension;
        let momentum = |s: &Sample| (robot.body.inertia + m * reach(s) * reach(s)) * s.rate;
        let moment = |s: &Sample| m * g * reach(s) * s.lean.sin();
        let size = m * (g * robot.body.radius.powi(3)).sqrt();
        // Each integration step comes as eight equal parts.
        for step in (0..trace.samples.len().saturating_sub(1)).step_by(8) {
            let parts = &trace.samples[step..=step + 8];
            let length = parts[8].time - parts[0].time;
            let impulse: f64 = parts.iter().zip(NEWTON_COTES).map(|(s, weight)| weight * moment(s)).sum::<f64>()
                * length
                / NEWTON_COTES.iter().sum::<f64>();
            let change = momentum(&parts[8]) - momentum(&parts[0]);
            // The error control's 1e-12 a step, on momenta whose squares and products count a few
            // times over.
            prop_assert!((change - impulse).abs() <= 1e-10 * size, "{change} {impulse}");
        }
    }

    #[test]
    fn without_gravity_a_robot_at_rest_only_rises((mut robot, launch) in jump(any_ordinary())) {
        // Without weight any motion around the foot takes the robot off the ground; from rest it
        // goes straight out.
        robot.environment.gravity = 0.0;
        let launch = Launch { rate: 0.0, firing_angle: launch.lean, ..launch };
        let trace = stance(&robot).trace(&launch).expect("a stance");
        for sample in &trace.samples {
            prop_assert!(sample.lean == launch.lean && sample.rate == 0.0, "{sample:?}");
        }
    }

    #[test]
    fn the_ground_bears_the_leg_and_its_turning((robot, launch) in jump(ordinary(Kind::Spring).prop_map(lossless))) {
        let Drive::Spring { stiffness, compression } = robot.leg.drive else { unreachable!() };
        let trace = stance(&robot).trace(&launch).expect("a stance");
        let (m, i, g) = (robot.body.mass, robot.body.inertia, robot.environment.gravity);
        let contact = trace.contact;
        for s in &trace.samples {
            let reach = robot.body.radius + s.extension;
            let (sin, cos) = s.lean.sin_cos();
            let turning = m * reach * (g * sin - 2.0 * s.rate * s.extension_rate) / (i + m * reach * reach);
            // The leg's force, or that of the end stop while it is held, along the leg; −I φ̈/R
            // across it.
            let along = if s.extension > 0.0 {
                stiffness * (compression - s.extension)
            } else {
                m * (g * cos - s.rate * s.rate * reach)
            };
            let across = -i * turning / reach;
            let (normal, friction) = (along * cos - across * sin, along * sin + across * cos);
            let size = m * g + stiffness * compression;
            // A handful of roundings of the forces at work.
            let is_first = s.extension == 0.0 && s.reaction.normal > normal + 1e-9 * size;
            prop_assert!(is_first || (s.reaction.normal - normal).abs() <= 1e-12 * size, "{s:?}: {normal}");
            prop_assert!(is_first || (s.reaction.friction - friction).abs() <= 1e-12 * size, "{s:?}: {friction}");
            prop_assert!(contact.least_normal <= s.reaction.normal);
            prop_assert!(contact.friction_needed >= s.reaction.demand());
        }
    }

    #[test]
    fn without_leg_force_the_pendulum_keeps_its_energy((mut robot, launch) in jump(any_ordinary())) {
        // A delay that no stance outlasts: the leg never pushes.
        robot.leg.delay = 1e3;
        let trace = stance(&robot).trace(&launch);
        let Ok(trace) = trace else { return Ok(()) };
        let (m, i, r, g) =
            (robot.body.mass, robot.body.inertia, robot.body.radius, robot.environment.gravity);
        let energy = |lean: f64, rate: f64| 0.5 * (i + m * r * r) * rate * rate + m * g * r * lean.cos();
        let start = energy(launch.lean, launch.rate);
        for sample in &trace.samples {
            let now = energy(sample.lean, sample.rate);
            // Falling over takes up to some hundred steps of 1e-12 each.
            prop_assert!((now - start).abs() <= 1e-10 * (m * g * r), "{start} {now}");
        }
        prop_assert!(!trace.lift_off.outcome.is_jump());
    }

    #[test]
    fn the_mirror_image_of_a_stance_is_one(robot in any_ordinary(), lean in 0.0..1.5, late in any::<bool>(), open in 0.0..4.0) {
        // From rest, fired at once: a launch cannot go backwards, but it can lean either way. A
        // long delay lets the robot fall far.
        let mut robot = robot;
        if late {
            robot.leg.delay = 0.5 * (robot.body.radius / robot.environment.gravity).sqrt();
        }
        let open = open * stroke_time(&robot);
        let end = |lean: f64| stance(&robot).jump(&Launch::at_firing(0.0, lean, open)).expect("a stance");
        let (ahead, behind) = (end(lean), end(-lean));
        prop_assert_eq!(ahead.outcome, behind.outcome);
        // The same operations on numbers of the other sign: the same to the bit.
        let mirrored = LiftOff {
            lean: -behind.lean,
            rate: -behind.rate,
            axle: [-behind.axle[0], behind.axle[1]],
            axle_rates: [-behind.axle_rates[0], behind.axle_rates[1]],
            ..behind
        };
        prop_assert_eq!(format!("{ahead:?}").replace("-0.0,", "0.0,"), format!("{mirrored:?}").replace("-0.0,", "0.0,"));
    }

    #[test]
    fn units_do_not_matter(
        (robot, launch) in jump(any_ordinary()),
        length in 0.3..3.0,
        mass in 0.3..3.0,
        time in 0.3..3.0,
    ) {
        let scaled_robot = in_units(&robot, length, mass, time);
        let scaled = Launch { rate: launch.rate / time, valve_open: launch.valve_open * time, ..launch };
        let (a, b) = (
            stance(&robot).jump(&launch).expect("a stance"),
            stance(&scaled_robot).jump(&scaled).expect("a stance"),
        );
        prop_assert_eq!(a.outcome, b.outcome);
        let pressure = mass / (length * time * time);
        for (name, x, y, scale) in [
            ("time", a.time * time, b.time, time * stroke_time(&robot)),
            ("lean", a.lean, b.lean, 1.0),
            ("rate", a.rate / time, b.rate, (robot.environment.gravity / robot.body.radius).sqrt() / time),
            ("extension", a.extension * length, b.extension, robot.leg.stroke * length),
            ("speed", a.extension_rate * length / time, b.extension_rate,
                robot.leg.stroke / stroke_time(&robot) * length / time),
            ("pressure", a.pressure * pressure, b.pressure, a.pressure * pressure),
        ] {
            if name == "pressure" && !matches!(robot.leg.drive, Drive::Pneumatic(_)) {
                continue;
            }
            // The error control is relative to 1 + |state| in SI, so the steps differ; both are
            // right to nine digits.
            prop_assert!((x - y).abs() <= 1e-8 * (y.abs() + scale), "{name}: {x} {y}");
        }
    }

    #[test]
    fn more_pressure_never_lowers_an_upright_hop(
        robot in prop_oneof![ordinary(Kind::Plain), ordinary(Kind::Pneumatic)],
        open in 0.2..4.0,
        more in 1.0..2.0,
    ) {
        let open = open * stroke_time(&robot);
        let hop = |supply: f64| {
            let mut robot = robot.clone();
            if let Drive::Pneumatic(cylinder) = &mut robot.leg.drive {
                cylinder.supply = GaugePressure(cylinder.supply.0 * supply);
            }
            let end = stance(&robot).jump(&Launch::at_firing(0.0, 0.0, open)).expect("a stance");
            let starves = end.outcome == Outcome::Force && end.time < robot.leg.delay + open;
            (apex(&robot, &end), starves)
        };
        let ((low, starves), (high, starves_too)) = (hop(1.0), hop(more));
        // A leg that outruns its valve, so that its force falls to 0 while that is open, bounces on
        // its gas: the law is about legs that push.
        prop_assume!(!starves && !starves_too);
        // Each is right to ten digits.
        prop_assert!(high >= low - 1e-9 * low, "{low} {high}");
    }

    #[test]
    fn a_longer_opening_never_lowers_an_upright_hop_and_saturates(robot in any_ordinary(), open in 0.05..4.0, more in 1.0..3.0) {
        let open = open * stroke_time(&robot);
        let hop = |open: f64| stance(&robot).jump(&Launch::at_firing(0.0, 0.0, open)).expect("a stance");
        let (short, long) = (hop(open), hop(open * more));
        // Each is right to ten digits.
        prop_assert!(apex(&robot, &long) >= apex(&robot, &short) * (1.0 - 1e-9), "{:?} {:?}", short, long);
        if short.outcome.is_jump() && short.time < robot.leg.delay + open {
            // The leg was off the ground before the valve closed: nothing is left to change but the
            // steps' lengths.
            prop_assert_eq!(short.outcome, long.outcome);
            prop_assert!((apex(&robot, &short) - apex(&robot, &long)).abs() <= 1e-9 * apex(&robot, &long));
            prop_assert!((short.time - long.time).abs() <= 1e-9 * long.time);
        }
    }

    #[test]
    fn an_early_lift_off_is_where_the_ground_would_have_to_pull(
        (robot, launch) in any_ordinary().prop_flat_map(|robot| { let l = launch(&robot); (Just(robot), l) }),
        faster in 0.8..2.0,
    ) {
        let launch = Launch { rate: launch.rate * faster, firing_angle: launch.lean.max(launch.firing_angle), ..launch };
        let end = stance(&robot).jump(&launch).expect("a stance");
        let (m, i, r, g) =
            (robot.body.mass, robot.body.inertia, robot.body.radius, robot.environment.gravity);
        let stiffness = m * g * r / (i + m * r * r);
        // The pendulum's rate at each lean, by its energy.
        let rate = |lean: f64| {
            (launch.rate * launch.rate + 2.0 * stiffness * (launch.lean.cos() - lean.cos())).max(0.0).sqrt()
        };
        // Densely between the start and the firing, which every stance that does not stall comes
        // through.
        let samples = (0..=1000).map(|k| launch.lean + (launch.firing_angle - launch.lean) * f64::from(k) / 1000.0);
        let pulled = samples.into_iter().find(|&lean| held_normal(&robot, lean, rate(lean)) < -1e-9);
        match (pulled, end.outcome) {
            (Some(lean), outcome) => {
                prop_assert!(matches!(outcome, Outcome::EarlyLiftOff | Outcome::Stall), "{outcome:?} past {lean}");
                prop_assert!(end.lean <= lean + 1e-9);
            }
            (None, Outcome::EarlyLiftOff) => {
                let normal = held_normal(&robot, end.lean, end.rate);
                // At the start it may be anything below 0; else the end is on the event.
                prop_assert!(normal.abs() <= 1e-8 || end.time == 0.0 && normal < 0.0, "{normal} at {end:?}");
            }
            _ => {}
        }
        prop_assert!(end.lean.abs() <= FRAC_PI_2 + 1e-9 || end.outcome == Outcome::FallBack, "{end:?}");
    }
}

#[test]
fn a_trace_has_a_tolerance_of_its_own() {
    // The ledger closes because the quadrature follows the steps: it does so at the planner's
    // tolerance too.
    let robot = Robot::rats_planar();
    for tolerance in [FINE, 1e-9] {
        let stance = stance(&robot).with_tolerance(tolerance);
        let ledger = stance
            .trace(&Launch::at_firing(5.0, -0.1, 0.1))
            .expect("a stance")
            .energy;
        assert!(
            ledger.residual().abs() <= 1e-8 * ledger.drive,
            "{tolerance}: {ledger:?}"
        );
    }
}
