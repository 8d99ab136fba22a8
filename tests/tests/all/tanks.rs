//! Robots that carry their gas: tank, tube, and valves that move in time, in both models.

use proptest::prelude::*;
use saltus_lagrangian::{Batch, FINE, Launch, LiftOff, Outcome, Stance};
use saltus_numeric::Dual;
use saltus_robot::{Robot, Tank, Term, Tube, resolve};
use saltus_sim_check::{Happening, Plan, Report, Rig, Settings, Sim, Stepping};
use saltus_tests::robots::{Kind, cases, jump, ordinary, stroke_time};

fn stance(robot: &Robot) -> Stance<f64> {
    Stance::new(robot, |_, x| x)
}

fn rats(set: &[&str]) -> Robot {
    let set: Vec<String> = set.iter().map(ToString::to_string).collect();
    resolve("rats-planar", &set).expect("a legal robot")
}

/// Everything at once, of an ordinary size.
const ALL: &[&str] = &[
    "tank.volume_l=0.15",
    "tank.wall_resistance_k_per_w=2",
    "leg.tube.length_m=0.4",
    "leg.tube.diameter_mm=4",
    "leg.tube.roughness_mm=0.01",
    "leg.valve_time_constant_ms=1.5",
    "leg.valve_closing_delay_ms=14",
];

/// A pneumatic robot, and of what it may have beyond a plain supply any part or all, from as small as
/// its chamber to far larger.
fn carrying() -> impl Strategy<Value = Robot> {
    let size = || -1.0..4.0_f64;
    let parts = (
        prop::option::weighted(0.8, (size(), 0..4_u8)),
        prop::option::weighted(0.6, (-2.0..1.5_f64, 0.3..3.0_f64, 0.0..0.05_f64)),
        prop::option::weighted(0.5, -3.0..-0.5_f64),
        prop::option::weighted(0.5, 0.0..2.0_f64),
    );
    (ordinary(Kind::Pneumatic), parts).prop_map(|(mut robot, (tank, tube, spool, closing))| {
        let (time, stroke) = (stroke_time(&robot), robot.leg.stroke);
        let delay = robot.leg.delay;
        let cylinder = robot.leg.cylinder_mut().expect("pneumatic");
        let area = 0.25 * std::f64::consts::PI * cylinder.bore * cylinder.bore;
        let chamber = cylinder.dead_volume + area * stroke;
        cylinder.tube = tube.map(|(length, width, rough)| {
            // About as wide as the valve's hole, and of any length up to 30 times the stroke.
            let diameter = 2.0 * width * cylinder.orifice_radius;
            Tube {
                length: 10_f64.powf(length) * stroke,
                diameter,
                roughness: rough * diameter,
            }
        });
        cylinder.spool_time = spool.map_or(0.0, |x| 10_f64.powf(x) * time);
        let (supply, kelvin) = (cylinder.supply.0, cylinder.temperature);
        robot.leg.closing_delay = closing.map(|x| x * (delay + 0.1 * time));
        robot.tank = tank.map(|(size, wall)| {
            let volume = 10_f64.powf(size) * chamber;
            let pressure = supply + robot.environment.ambient.0;
            // Warms up in about the time of a stroke.
            let natural = time * kelvin / (pressure * volume);
            Tank {
                volume,
                wall_resistance: match wall {
                    0 => 0.0,
                    1 => natural,
                    2 => 100.0 * natural,
                    _ => f64::INFINITY,
                },
            }
        });
        robot
    })
}

fn bits(end: &LiftOff) -> Vec<u64> {
    let [x, y] = end.axle;
    let [vx, vy] = end.axle_rates;
    let numbers = [
        end.time,
        end.lean,
        end.rate,
        end.extension,
        end.extension_rate,
        end.pressure,
    ];
    let all = numbers.into_iter().chain([x, y, vx, vy]);
    all.map(f64::to_bits).collect()
}

proptest! {
    #![proptest_config(cases(300))]

    /// A jump that cannot be integrated says so; of 300 no more than a few do.
    #[test]
    fn mass_and_energy_of_the_gas_are_conserved((robot, launch) in jump(carrying())) {
        let stance = stance(&robot).with_tolerance(FINE);
        let Some(full) = stance.full_tank() else { return Ok(()) };
        let Ok(Some((_, drawn))) = stance.jump_from(&launch, &full) else { return Ok(()) };
        let [mass, energy] = drawn.residuals;
        prop_assert!(mass.abs() < 1e-9 && energy.abs() < 1e-9, "{mass:e} {energy:e}");
        prop_assert!(drawn.tank.pressure <= full.pressure * (1.0 + 1e-12), "{drawn:?}");
        prop_assert!(drawn.mass >= -1e-12 * full.pressure, "{drawn:?}");
    }

    #[test]
    fn a_tube_of_no_length_and_an_infinite_tank_change_no_bit((robot, launch) in jump(ordinary(Kind::Pneumatic))) {
        let mut same = robot.clone();
        same.tank = Some(Tank { volume: f64::INFINITY, wall_resistance: 1.0 });
        same.leg.closing_delay = Some(same.leg.delay);
        let cylinder = same.leg.cylinder_mut().expect("pneumatic");
        cylinder.tube = Some(Tube { length: 0.0, diameter: 0.01, roughness: 0.0 });
        let ends = [&robot, &same].map(|robot| stance(robot).jump(&launch).map(|end| bits(&end)));
        let mut without = robot.clone();
        without.leg.closing_delay = None;
        let [a, b] = ends;
        prop_assert_eq!(a.is_ok(), b.is_ok());
        if let (Ok(a), Ok(b)) = (a, b) {
            // A closing delay is added in another order: to round-off.
            let near = |(a, b): (&u64, &u64)| {
                let (a, b) = (f64::from_bits(*a), f64::from_bits(*b));
                (a - b).abs() <= 1e-9 * (a.abs() + 1.0)
            };
            prop_assert!(a.iter().zip(&b).all(near), "{a:?} {b:?}");
        }
        same.leg.closing_delay = None;
        let a = stance(&without).jump(&launch).map(|end| bits(&end));
        let b = stance(&same).jump(&launch).map(|end| bits(&end));
        prop_assert_eq!(a.ok(), b.ok());
        let a = Batch::new(&without, FINE).jumps(&[launch])[0].clone().map(|end| bits(&end));
        let b = Batch::new(&same, FINE).jumps(&[launch])[0].clone().map(|end| bits(&end));
        prop_assert_eq!(a.ok(), b.ok());
    }
}

/// Of random robots nearly all can be integrated, so that the laws above are held against most.
#[test]
fn nearly_every_robot_that_carries_its_gas_can_be_integrated() {
    use proptest::strategy::ValueTree;
    use proptest::test_runner::TestRunner;
    let mut runner = TestRunner::new(cases(1));
    let strategy = jump(carrying());
    let (mut jumps, mut wrong) = (0, Vec::new());
    for _ in 0..300 {
        let (robot, launch) = strategy.new_tree(&mut runner).expect("a robot").current();
        match stance(&robot).jump(&launch) {
            Ok(end) => jumps += usize::from(end.outcome.is_jump()),
            Err(error) => wrong.push(error.to_string()),
        }
    }
    assert!(wrong.len() <= 6, "{} of 300: {wrong:#?}", wrong.len());
    assert!(jumps > 100, "{jumps} jumps");
}

fn simulated(robot: &Robot, launch: &Launch, stepping: Stepping) -> Report {
    let plan = Plan {
        sample: 0.05,
        settings: Settings {
            stepping,
            ..Settings::default()
        },
        ..Plan::default()
    };
    let launch = saltus_sim_check::Launch { ..*launch };
    Rig::new(robot, &[])
        .and_then(|rig| rig.jump(&launch, &plan))
        .expect("a motion")
}

const LAUNCHES: [Launch; 3] = [
    Launch {
        rate: 5.0,
        lean: -0.1,
        firing_angle: -0.1,
        valve_open: 0.1,
    },
    Launch {
        rate: 4.0,
        lean: -0.3,
        firing_angle: -0.1,
        valve_open: 0.06,
    },
    Launch {
        rate: 0.0,
        lean: 0.02,
        firing_angle: 0.02,
        valve_open: 0.035,
    },
];

/// The legs there have a millionth of the robot's mass.
const NEAR: f64 = 5e-6;

#[test]
fn stance_and_multi_body_simulation_agree() {
    let parts: Vec<Vec<&str>> = vec![
        vec![ALL[0]],
        vec![ALL[0], ALL[1]],
        vec![ALL[0], "tank.wall_resistance_k_per_w=0"],
        vec![ALL[2], ALL[3]],
        vec![ALL[2], ALL[3], ALL[4]],
        vec![ALL[5]],
        vec![ALL[6]],
        ALL.to_vec(),
        [
            ALL,
            &["leg.leak_area_mm2=0.3", "leg.supply_droop_pa_s_per_kg=2e6"],
        ]
        .concat(),
        [
            ALL,
            &[
                "leg.polytropic_exponent=1.2",
                "leg.exhaust_port.position_mm=40",
                "leg.exhaust_port.area_mm2=5",
            ],
        ]
        .concat(),
    ];
    let plain = rats(&[]);
    for set in parts {
        let robot = rats(&set);
        let mut shows = 0.0_f64;
        for launch in &LAUNCHES {
            let planar = stance(&robot).jump(launch).expect("a stance");
            let before = stance(&plain).jump(launch).expect("a stance");
            let report = simulated(&robot, launch, Stepping::Adaptive);
            let found = report.lift_off.expect("a lift-off");
            assert_eq!(planar.outcome, found.outcome, "{set:?} {launch:?}");
            // Where the foot of the planar model would have to be pulled, the simulation lets go.
            let (_, contact) = stance(&robot).contact(launch).expect("a stance");
            assert!(
                contact.least_normal > 0.0,
                "{set:?} {launch:?}: {contact:?}"
            );
            for (what, a, b, old) in [
                ("time", planar.time, found.time, before.time),
                ("lean", planar.lean, found.lean, before.lean),
                ("rate", planar.rate, found.rate, before.rate),
                (
                    "extension",
                    planar.extension,
                    found.extension,
                    before.extension,
                ),
                (
                    "speed ahead",
                    planar.axle_rates[0],
                    found.axle_rates[0],
                    before.axle_rates[0],
                ),
                (
                    "speed up",
                    planar.axle_rates[1],
                    found.axle_rates[1],
                    before.axle_rates[1],
                ),
                (
                    "pressure",
                    planar.pressure / 1e6,
                    found.pressure / 1e6,
                    before.pressure / 1e6,
                ),
            ] {
                assert!(
                    (a - b).abs() < NEAR * (1.0 + a.abs()),
                    "{set:?} {launch:?} {what}: {a} {b}"
                );
                shows = shows.max((a - old).abs());
            }
        }
        assert!(shows > 1e-3, "{set:?} shows by {shows:e}");
    }
}

#[test]
fn fixed_steps_come_near_the_adaptive_ones() {
    let robot = rats(ALL);
    for launch in &LAUNCHES {
        let exact = simulated(&robot, launch, Stepping::Adaptive);
        let fixed = simulated(&robot, launch, Stepping::Fixed(1e-3));
        // As without a tank: a step is 1 ms long.
        let plain = rats(&[]);
        let usual = simulated(&plain, launch, Stepping::Adaptive).apex
            - simulated(&plain, launch, Stepping::Fixed(1e-3)).apex;
        let off = exact.apex - fixed.apex;
        assert!(
            off.abs() < 1e-3 + 2.0 * usual.abs(),
            "{launch:?}: {off} m, without {usual} m"
        );
    }
}

/// Gas in tank and chambers, and what left them, as the accounts of the legs say.
#[test]
fn the_simulation_loses_no_gas() {
    let robot = rats(ALL);
    let rig = Rig::new(&robot, &[]).expect("a rig");
    for stepping in [Stepping::Adaptive, Stepping::USUAL] {
        let (q, v) = rig.stand(-0.1, 5.0).expect("stands");
        let settings = Settings {
            stepping,
            accounts: true,
            ..Settings::default()
        };
        let mut sim = Sim::new(&rig.mechanism, &q, &v, settings).expect("a start");
        let gas = |sim: &Sim<'_>| sim.gas().expect("a tank");
        let (before, full) = (gas(&sim), sim.tank().expect("a tank"));
        sim.fire(0, 0.05).expect("a command");
        sim.run(0.1, &[]).expect("a motion");
        let events = sim.events().iter();
        assert!(
            events
                .into_iter()
                .any(|e| matches!(e.what, Happening::LiftOff(0, _)))
        );
        let released: f64 = (0..5).map(|leg| sim.account(leg).released).sum();
        let left = gas(&sim) + released;
        assert!(
            (left - before).abs() < 1e-9 * before,
            "{stepping:?}: {before} {left}"
        );
        let now = sim.tank().expect("a tank");
        assert!(
            now[0] < 0.9 * full[0] && now[1] < full[1] - 3.0,
            "{now:?} of {full:?}"
        );
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let robot = rats(
        &[
            ALL,
            &["leg.leak_area_mm2=0.3", "leg.supply_droop_pa_s_per_kg=2e6"],
        ]
        .concat(),
    );
    let terms = [
        Term::TankVolume,
        Term::SpoolTime,
        Term::ClosingDelay,
        Term::Delay,
        Term::Supply,
        Term::Bore,
        Term::DeadVolume,
        Term::Temperature,
        Term::DischargeCoefficient,
        Term::SupplyDroop,
        Term::LeakArea,
    ];
    let launch = Launch {
        valve_open: 0.02,
        ..LAUNCHES[0]
    };
    for term in terms {
        let lift = |other: Term, x: f64| {
            if other == term {
                Dual::<2>::variable(x, 0)
            } else {
                Dual {
                    value: x,
                    slope: [0.0; 2],
                }
            }
        };
        let constant = |x: f64| Dual::<2> {
            value: x,
            slope: [0.0; 2],
        };
        let lifted = Launch {
            rate: constant(launch.rate),
            lean: constant(launch.lean),
            firing_angle: constant(launch.firing_angle),
            valve_open: constant(launch.valve_open),
        };
        let end = Stance::<Dual<2>>::new(&robot, lift)
            .jump(&lifted)
            .expect("a stance");
        assert!(end.outcome != Outcome::NoBreakAway);
        let value = term.of(&robot).expect("it has it");
        let at = |x: f64| {
            let mut moved = robot.clone();
            term.set(&mut moved, x);
            stance(&moved).jump(&launch).expect("a stance")
        };
        let h = 3e-4 * value;
        let (up, down) = (at(value + h), at(value - h));
        for (what, found, a, b) in [
            ("time", end.time.slope[0], up.time, down.time),
            (
                "speed",
                end.extension_rate.slope[0],
                up.extension_rate,
                down.extension_rate,
            ),
            ("lean", end.lean.slope[0], up.lean, down.lean),
        ] {
            let wanted = (a - b) / (2.0 * h);
            // Relative to a change of the number by itself. Steps over the kink where flows choke are
            // right to about 1e-10, which differences divide by h; and they are good to h².
            let off = (found - wanted).abs() * value;
            // The friction of the tube depends on pressure and temperature a little.
            let is_rough = matches!(term, Term::Supply | Term::Temperature);
            let close = if is_rough { 1e-4 } else { 1e-5 };
            assert!(
                off < close * (1.0 + wanted.abs() * value),
                "{term:?} {what}: {found} {wanted}"
            );
        }
    }
}

/// The muscle of `GTDynamics`' jumping robot in the leg of `rats-planar`, with more.
fn muscle(more: &[&str]) -> Robot {
    const LEG: &str = "leg={kind='muscle', gas='air', stroke_m=0.06, valve_delay_ms=10, \
        viscous_friction_n_s_per_m=5, coulomb_friction_n=5, dead_volume_cm3=42.43, \
        supply_pressure_gauge_pa=448159, discharge_coefficient=0.54, orifice_radius_mm=1.5, \
        gas_temperature_k=296.15, muscle={force_n_per_pa=1.966409e-3, slope_n_per_pa_m=0.035541599, \
        free_contraction_m=[0.0305583930, 7.58361626e-7, -4.91579771e-12, 1.42792618e-17, \
        -1.54817477e-23]}}";
    rats(&[&[LEG], more].concat())
}

#[test]
fn a_muscle_is_the_same_in_both_models_and_loses_no_energy() {
    for more in [
        vec!["leg.muscle.lever=1"],
        vec!["leg.muscle.tendon_stiffness_n_per_m=4000"],
        vec![
            "tank.volume_l=1.475",
            "leg.muscle.tendon_stiffness_n_per_m=8200",
            "leg.muscle.lever=0.8",
        ],
        [
            vec![
                "tank.volume_l=0.5",
                "leg.muscle.tendon_stiffness_n_per_m=4000",
            ],
            ALL[1..].to_vec(),
        ]
        .concat(),
    ] {
        let robot = muscle(&more);
        for launch in [
            Launch::at_firing(5.0, -0.1, 0.2),
            Launch::at_firing(0.0, 0.02, 0.1),
        ] {
            let stance = stance(&robot);
            let planar = stance.jump(&launch).expect("a stance");
            let found = simulated(&robot, &launch, Stepping::Adaptive)
                .lift_off
                .expect("a lift-off");
            assert_eq!(planar.outcome, Outcome::Stroke, "{more:?}");
            assert_eq!(planar.outcome, found.outcome, "{more:?}");
            for (what, a, b) in [
                ("time", planar.time, found.time),
                ("lean", planar.lean, found.lean),
                ("speed ahead", planar.axle_rates[0], found.axle_rates[0]),
                ("speed up", planar.axle_rates[1], found.axle_rates[1]),
                ("pressure", planar.pressure / 1e6, found.pressure / 1e6),
            ] {
                assert!(
                    (a - b).abs() < NEAR * (1.0 + a.abs()),
                    "{more:?} {what}: {a} {b}"
                );
            }
            if let Some(full) = stance.full_tank() {
                let drawn = stance
                    .jump_from(&launch, &full)
                    .expect("a stance")
                    .expect("a tank");
                let [mass, energy] = drawn.1.residuals;
                assert!(
                    mass.abs() < 1e-12 && energy.abs() < 1e-9,
                    "{mass:e} {energy:e}"
                );
            }
        }
    }
    // The pull through a tendon of no compliance, and what a lever does to it.
    let apex = |more: &[&str]| {
        let end = stance(&muscle(more))
            .jump(&Launch::at_firing(0.0, 0.02, 0.2))
            .expect("a stance");
        end.axle_rates[1]
    };
    let rigid = apex(&[]);
    let stiff = apex(&["leg.muscle.tendon_stiffness_n_per_m=1e9"]);
    assert!((rigid - stiff).abs() < 1e-5, "{rigid} {stiff}");
    assert!(apex(&["leg.muscle.tendon_stiffness_n_per_m=4000"]) < rigid - 0.1);
}

/// The laws that a plan needs: derivatives of a muscle's jump.
#[test]
fn derivatives_of_a_muscle_are_those_of_differences() {
    let robot = muscle(&[
        "tank.volume_l=0.5",
        "leg.muscle.tendon_stiffness_n_per_m=4000",
    ]);
    let launch = Launch::at_firing(4.0, -0.1, 0.2);
    for term in [
        Term::MuscleForce,
        Term::MuscleSlope,
        Term::MuscleLever,
        Term::TendonStiffness,
        Term::DeadVolume,
    ] {
        let lift = |other: Term, x: f64| {
            if other == term {
                Dual::<2>::variable(x, 0)
            } else {
                Dual {
                    value: x,
                    slope: [0.0; 2],
                }
            }
        };
        let constant = |x: f64| Dual::<2> {
            value: x,
            slope: [0.0; 2],
        };
        let lifted = Launch {
            rate: constant(launch.rate),
            lean: constant(launch.lean),
            firing_angle: constant(launch.firing_angle),
            valve_open: constant(launch.valve_open),
        };
        let found = Stance::<Dual<2>>::new(&robot, lift)
            .jump(&lifted)
            .expect("a stance")
            .extension_rate
            .slope[0];
        let value = term.of(&robot).expect("it has it");
        let at = |x: f64| {
            let mut moved = robot.clone();
            term.set(&mut moved, x);
            stance(&moved)
                .jump(&launch)
                .expect("a stance")
                .extension_rate
        };
        let h = 3e-4 * value;
        let wanted = (at(value + h) - at(value - h)) / (2.0 * h);
        let off = (found - wanted).abs() * value;
        assert!(
            off < 1e-5 * (1.0 + wanted.abs() * value),
            "{term:?}: {found} {wanted}"
        );
    }
}
