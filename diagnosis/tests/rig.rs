//! The fast model of a jump against the multi-body simulation, for every term of a robot file.

use saltus_diagnosis::rig::{Rig, Start};
use saltus_sim_check as sim_check;

/// Terms, one set a robot, and how far the models may be apart (rad, m). Both are exact to their
/// tolerances; what is larger is the error of the fast model's steps where something is stiff.
const TERMS: &[(&[&str], f64)] = &[
    (&[], 1e-6),
    (&["leg.supply_pressure_gauge_psi=100"], 1e-6),
    (&["leg.supply_droop_pa_s_per_kg=1e7"], 1e-6),
    (&["leg.valve_delay_ms=14"], 1e-6),
    (&["leg.discharge_coefficient=0.4"], 1e-6),
    (&["leg.leak_area_mm2=0.5"], 1e-6),
    (&["leg.dead_volume_cm3=9"], 1e-6),
    (&["leg.viscous_friction_n_s_per_m=20"], 1e-6),
    (&["leg.coulomb_friction_n=25"], 1e-6),
    (&["leg.seal_friction_n_per_pa=3e-5"], 1e-6),
    (
        &[
            "leg.return_spring.stiffness_n_per_m=200",
            "leg.return_spring.preload_n=4",
        ],
        1e-6,
    ),
    (&["leg.gas=co2"], 1e-6),
    (
        &[
            "leg.exhaust_port.position_mm=45",
            "leg.exhaust_port.area_mm2=20",
        ],
        1e-6,
    ),
    (&["leg.polytropic_exponent=1.1"], 1e-6),
    (&["body.mass_kg=3.2"], 1e-6),
    (&["body.inertia_kg_m2=0.1"], 1e-6),
    (
        &["body.imbalance_mm=8", "body.imbalance_angle_deg=60"],
        1e-6,
    ),
    (&["boom.mass_kg=0.8"], 1e-6),
    (&["boom.bending_stiffness_n_m_per_rad=430"], 1e-5),
    (&["body.axle_friction_n_m=0.2"], 1e-5),
    (&["ground.static_friction=0.35"], 1e-5),
    (
        &[
            "ground.static_friction=0.35",
            "ground.kinetic_friction=0.28",
        ],
        1e-5,
    ),
    (&["ground.across_friction=0.3"], 2e-5),
    (&["foot.radius_m=0.02"], 1e-5),
    (&["ground.slope_deg=3"], 1e-6),
    (&["environment.drag_per_m=0.1"], 1e-6),
    (&["environment.gravity_m_s2=8"], 2e-6),
    (
        &[
            "boom.counterweight.mass_kg=1",
            "boom.counterweight.distance_m=0.7",
        ],
        1e-6,
    ),
];

/// Start lean (rad), rate (rad/s), firing angle (rad) and valve opening (s).
const LAUNCHES: [[f64; 4]; 2] = [[-0.35, 4.5, -0.05, 0.08], [-0.3, 5.5, 0.15, 0.05]];

#[test]
fn every_term_does_what_it_does_in_the_multi_body_simulation() {
    for (terms, tolerance) in TERMS {
        let overrides: Vec<String> = terms.iter().map(ToString::to_string).collect();
        let robot = saltus_robot::resolve("rats-boom", &overrides).expect("sound");
        let (fast, whole) = (
            Rig::new(&robot),
            sim_check::Rig::new(&robot, &[]).expect("a rig"),
        );
        let arm = robot.boom.expect("a boom").length;
        for [lean, rate, firing_angle, valve_open] in LAUNCHES {
            let plan = sim_check::Plan {
                sample: 4e-3,
                ..sim_check::Plan::default()
            };
            let launch = sim_check::Launch {
                lean,
                rate,
                firing_angle,
                valve_open,
            };
            let report = whole.jump(&launch, &plan).expect("a motion");
            let lift_off = report.lift_off.expect("lifts off");
            let fire = lift_off.time_fire;
            let end = report.samples.last().expect("samples").time;
            let start = Start::Rolling { lean, rate };
            let course = fast
                .jump(start, fire, fire + valve_open, Some(end))
                .expect("a motion");
            let leaves = course.leaves.expect("leaves");
            assert!(
                (leaves - lift_off.time).abs() < *tolerance,
                "{terms:?}: leaves {leaves}"
            );
            let mut place = 0;
            for sample in report.samples.iter().filter(|s| s.time > 0.0) {
                let pose = course.at(sample.time, &mut place);
                let off = (pose.lean.0 - sample.lean)
                    .abs()
                    .max((pose.height.0 - sample.axle[1]).abs())
                    .max((pose.turn.0 * arm - sample.axle[0]).abs());
                assert!(
                    off < *tolerance,
                    "{terms:?}: off by {off} at {} s",
                    sample.time
                );
            }
        }
    }
}

/// Also where the axle passes over the foot before it is fired off it, and where the leg fires late
/// and low.
#[test]
fn an_outcome_is_the_apex_and_the_landing_of_the_flight() {
    let robot = saltus_robot::resolve("rats-boom", &[]).expect("sound");
    let (fast, whole) = (
        Rig::new(&robot),
        sim_check::Rig::new(&robot, &[]).expect("a rig"),
    );
    for [lean, rate, valve_open] in [
        [-0.25, 4.0, 0.08],
        [-0.054, 6.0, 0.083],
        [-0.017, 3.05, 0.071],
        [0.1, 5.0, 0.05],
        [0.3, 3.5, 0.04],
    ] {
        let launch = sim_check::Launch {
            lean,
            rate,
            firing_angle: lean,
            valve_open,
        };
        let plan = sim_check::Plan {
            landing_height: robot.body.radius,
            ..sim_check::Plan::default()
        };
        let report = whole.jump(&launch, &plan).expect("a motion");
        let (apex, landing) = fast.outcome(lean, rate, valve_open).expect("a jump");
        assert!(
            (apex - report.apex).abs() < 2e-6,
            "{lean} {rate}: apex {apex} m, {} m",
            report.apex
        );
        let there = report.landing_at;
        assert!(
            (landing - there).abs() < 5e-6,
            "{lean} {rate}: landing {landing} m, {there} m"
        );
    }
}

/// Whatever drives the leg: a spring is not caught again, and where a motor is switched off within
/// the stroke the foot leaves.
#[test]
fn every_kind_of_leg_jumps_as_in_the_multi_body_simulation() {
    for name in ["spring-hopper", "table-hopper", "rats-planar"] {
        let mut robot = saltus_robot::resolve(name, &[]).expect("sound");
        robot.boom = saltus_robot::resolve("rats-boom", &[]).expect("sound").boom;
        let (fast, whole) = (
            Rig::new(&robot),
            sim_check::Rig::new(&robot, &[]).expect("a rig"),
        );
        for valve_open in [0.02, 0.03, 0.1] {
            let (lean, rate) = (-0.1, 3.5);
            let launch = sim_check::Launch {
                lean,
                rate,
                firing_angle: lean,
                valve_open,
            };
            let plan = sim_check::Plan {
                landing_height: robot.body.radius,
                ..sim_check::Plan::default()
            };
            let report = whole.jump(&launch, &plan).expect("a motion");
            let (apex, landing) = fast.outcome(lean, rate, valve_open).expect("a jump");
            assert!(
                (apex - report.apex).abs() < 2e-6,
                "{name} {valve_open}: apex {apex} m, {} m",
                report.apex
            );
            let there = report.landing_at;
            assert!(
                (landing - there).abs() < 5e-6,
                "{name} {valve_open}: landing {landing} m, {there} m"
            );
        }
    }
}
