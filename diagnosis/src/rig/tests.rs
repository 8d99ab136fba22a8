use super::fed::Gas;
use super::run::{FINE, State};
use super::*;

/// What fills and empties the chamber, from next to nothing to more than the valve lets in.
const CHAMBERS: &[&[&str]] = &[
    &[],
    &["leg.leak_area_mm2=1e-7"],
    &["leg.leak_area_mm2=1e-6"],
    &["leg.leak_area_mm2=2e-5"],
    &["leg.leak_area_mm2=1e-3"],
    &["leg.leak_area_mm2=0.0554"],
    &["leg.leak_area_mm2=0.5"],
    &["leg.leak_area_mm2=3"],
    &["leg.leak_area_mm2=10"],
    &["leg.supply_droop_pa_s_per_kg=1e5"],
    &["leg.supply_droop_pa_s_per_kg=3.5e6"],
    &["leg.supply_droop_pa_s_per_kg=1.2e8"],
    &["leg.supply_droop_pa_s_per_kg=3e6", "leg.leak_area_mm2=0.05"],
    &["leg.supply_droop_pa_s_per_kg=1e8", "leg.leak_area_mm2=1"],
    &["leg.discharge_coefficient=0.05"],
    &["leg.discharge_coefficient=0.95"],
    &["leg.discharge_coefficient=0.25", "leg.leak_area_mm2=0.5"],
    &[
        "leg.exhaust_port.position_mm=30",
        "leg.exhaust_port.area_mm2=6",
    ],
    &[
        "leg.exhaust_port.position_mm=30",
        "leg.exhaust_port.area_mm2=0.1",
        "leg.leak_area_mm2=0.1",
    ],
    &["leg.dead_volume_cm3=1", "leg.leak_area_mm2=0.1"],
    &["leg.dead_volume_cm3=40", "leg.leak_area_mm2=0.1"],
    &["leg.gas=co2", "leg.leak_area_mm2=0.1"],
    &["leg.coulomb_friction_n=200", "leg.leak_area_mm2=0.2"],
    &["leg.supply_pressure_gauge_psi=7", "leg.leak_area_mm2=0.2"],
];
/// Loads (kg), two that the leg lifts and one that it does not, and when (s) the valve is shut.
const FIRINGS: [(f64, f64); 4] = [(1.0, 1e6), (3.0, 0.08), (60.0, 0.1), (60.0, 1e6)];

fn robot(name: &str, terms: &[&str]) -> Robot {
    let overrides: Vec<String> = terms.iter().map(ToString::to_string).collect();
    saltus_robot::resolve(name, &overrides).expect("sound")
}

/// Pressure (Pa) and extension (m) every 0.2 ms up to 0.2 s, with steps of at most `rests` (s)
/// while the rod rests.
fn firing(rig: &Rig, shut: f64, rests: f64) -> Vec<(f64, f64)> {
    let course = rig
        .jump_in_steps(Start::Rest, 0.0, shut, Some(0.2), rests)
        .expect("a motion");
    let mut place = 0;
    let at = |k: u32| {
        let pose = course.at(f64::from(k) * 2e-4, &mut place);
        (pose.pressure.0, pose.extension.0)
    };
    (0..=1000).map(at).collect()
}

/// A log's pressure scatters by a thousandth of it, and what is fitted are differences of a
/// thousandth of that.
#[track_caller]
fn check(name: &str, terms: &[&str], extra: Extra) {
    let robot = robot(name, terms);
    for (load, shut) in FIRINGS {
        let rig = Rig::bench(&robot, load).with(extra);
        let (long, short) = (firing(&rig, shut, LONG), firing(&rig, shut, FINE / 10.0));
        for (k, ((p, d), (q, e))) in long.iter().zip(&short).enumerate() {
            assert!(
                (p - q).abs() <= 1e-6 * q,
                "{name} {terms:?}, {load} kg, row {k}: {p} Pa, {q} Pa"
            );
            assert!(
                (d - e).abs() < 1e-9,
                "{name} {terms:?}, {load} kg, row {k}: {d} m, {e} m"
            );
        }
    }
}

#[test]
fn long_steps_of_a_rod_at_rest_are_as_true_as_short_ones() {
    for terms in CHAMBERS {
        check("rats-boom", terms, Extra::default());
    }
    for name in ["rats-planar", "spring-hopper", "table-hopper"] {
        check(name, &[], Extra::default());
    }
    let leak_along = Extra {
        leak_along: 1e-5,
        ..Extra::default()
    };
    check("rats-boom", &[], leak_along);
    let opening = Extra {
        opening: 0.007,
        ..Extra::default()
    };
    check("rats-boom", &["leg.leak_area_mm2=0.1"], opening);
}

/// Steps of Runge and Kutta so small that they are true from where flows begin with infinite slope
/// and where they are stiff.
#[test]
fn the_gas_behind_a_held_leg_is_that_of_tiny_steps() {
    for terms in CHAMBERS {
        let rig = Rig::bench(&robot("rats-boom", terms), 60.0);
        let mut run = Run::new(&rig, Start::Rest).expect("a start");
        run.mode.leg = Slide::Held;
        run.switch(true);
        let rate = |u: f64| {
            let gas = Gas::new(u, 0.0, 0.0, 0.0);
            let gas = run.gas(&State { gas, ..run.state }).expect("a chamber");
            gas.rate[0]
        };
        let (mut u, h) = (run.state.gas[0], 5e-8);
        for k in 0..60_000 {
            // Of most chambers this is before the flow turns subsonic, which ends the piece of the
            // law.
            if k % 10_000 == 0 {
                let found = run.held_gas(f64::from(k) * h).expect("gas")[0];
                assert!(
                    (found - u).abs() <= 2e-8 * u,
                    "{terms:?} after {k}: {found}, {u}"
                );
            }
            let a = rate(u);
            let b = rate(u + 0.5 * h * a);
            let c = rate(u + 0.5 * h * b);
            u += h / 6.0 * (a + 2.0 * (b + c) + rate(u + h * c));
        }
    }
}

/// Nothing happens in it, whatever the chamber leaks.
#[test]
fn a_rest_of_20_s_costs_hardly_more_than_none() {
    for terms in CHAMBERS {
        let robot = robot("rats-boom", terms);
        for (load, shut) in FIRINGS {
            let rig = Rig::bench(&robot, load);
            let knots = |until| {
                rig.jump(Start::Rest, 0.0, shut, Some(until))
                    .expect("a motion")
                    .knots
                    .len()
            };
            let (brief, long) = (knots(1.0), knots(21.0));
            assert!(
                long < brief + 40,
                "{terms:?}, {load} kg: {brief} and {long} knots"
            );
        }
    }
}
