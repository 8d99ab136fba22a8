//! Synthetic jumps: a robot of five links that fires all its muscles at once, from a crouch.

use crate::layout::{Draw, Layout, count, round};
use crate::spec::{Instrument, Source, Synthesis, noisy};

use super::flight::REST;

/// Time (s) between rows, and how long a run is.
const ROW: f64 = 2e-3;
const LENGTH: f64 = 0.5;
/// When (s) all muscles are vented.
const EXHAUST: f64 = 0.3;

/// A column as it is: what was asked for, or how the robot stands at the start.
const fn exact(column: &'static str) -> Instrument {
    noisy(column, 0.0)
}

pub(super) const SYNTHESIS: Synthesis = Synthesis {
    instruments: &[
        exact("valve_knee_right"),
        exact("valve_hip_right"),
        exact("valve_hip_left"),
        exact("valve_knee_left"),
        exact("knee_right_angle_rad"),
        exact("hip_right_angle_rad"),
        exact("hip_left_angle_rad"),
        exact("knee_left_angle_rad"),
        exact("torso_y_m"),
        exact("torso_angle_rad"),
        noisy("tank_pressure_gauge_pa", 1e3),
        noisy("knee_right_pressure_gauge_pa", 1e3),
        noisy("hip_right_pressure_gauge_pa", 1e3),
        noisy("hip_left_pressure_gauge_pa", 1e3),
        noisy("knee_left_pressure_gauge_pa", 1e3),
        noisy("com_y_m", 2e-3),
    ],
    without_boom: None,
    runs: 4,
    lay_out,
    source: Source::Model,
};

/// What the operator believes: numbers, lists and names.
const NUMBERS: [(&str, f64); 19] = [
    ("tank_volume_m3", 1.5e-3),
    ("gas_temperature_k", 293.15),
    ("gas_constant_j_kg_k", 287.05),
    ("tube_length_m", 1.5),
    ("tube_diameter_m", 4e-3),
    ("tube_roughness_m", 1e-5),
    ("valve_time_constant_s", 1e-3),
    ("valve_exhaust_s", EXHAUST),
    ("link_radius_m", 0.02),
    ("knee_pulley_radius_m", 0.045),
    ("hip_pulley_radius_m", 0.045),
    ("tendon_stiffness_n_m", 12e3),
    ("knee_spring_nm_rad", 2.0),
    ("hip_spring_nm_rad", 2.5),
    ("knee_spring_from_rad", 0.0),
    ("hip_spring_from_rad", 0.15),
    ("joint_damping_nm_s_rad", 0.03),
    ("muscle_force_per_kpa_n", 1.95),
    ("muscle_slope_per_kpa_n_cm", 0.35),
];
const LISTS: [(&str, &[f64]); 4] = [
    ("link_mass_kg", &[0.3, 0.5, 1.0, 0.5, 0.3]),
    ("link_length_m", &[0.55; 5]),
    ("muscle_volume_coefficients", &[4.2e-5]),
    (
        "muscle_x0_coefficients_cm",
        &[3.0, 0.075, -4.9e-4, 1.4e-6, -1.5e-9],
    ),
];
const NAMES: [(&str, &[&str]); 2] = [
    (
        "actuators",
        &["knee_right", "hip_right", "hip_left", "knee_left"],
    ),
    (
        "link_names",
        &[
            "shank_right",
            "thigh_right",
            "torso",
            "thigh_left",
            "shank_left",
        ],
    ),
];

/// The table `[rig]` among the settings of a run.
fn rig() -> Vec<(String, f64)> {
    let numbers = NUMBERS
        .iter()
        .map(|(key, value)| ((*key).to_owned(), *value));
    let lists = LISTS.iter().flat_map(|(key, values)| {
        let item = move |(k, value): (usize, &f64)| (format!("{key}.{}", k + 1), *value);
        values.iter().enumerate().map(item)
    });
    let names = NAMES.iter().flat_map(|(key, names)| {
        let item = move |(k, name): (usize, &&str)| (format!("{key}.{name}"), (k + 1) as f64);
        names.iter().enumerate().map(item)
    });
    numbers.chain(lists).chain(names).collect()
}

/// Adds jumps from a crouch, each with its own pressure of the tank and opening of the valves.
fn lay_out(layout: &mut Layout, runs: usize, draw: &mut Draw) {
    let rig = rig();
    for _ in 0..runs {
        let tank = round(draw.stepped(350e3, 550e3, 5e3));
        let opening = round(draw.stepped(0.05, 0.12, 0.01));
        let (knee, hip) = (
            round(draw.stepped(2.6, 2.8, 1e-3)),
            round(draw.stepped(-2.55, -2.4, 1e-3)),
        );
        let mut settings: Vec<(&str, f64)> = rig
            .iter()
            .map(|(key, value)| (key.as_str(), *value))
            .collect();
        settings.push(("supply_pressure_gauge_pa", tank));
        layout.add(&settings, count(LENGTH, ROW), ROW, vec![tank, 0.0, 0.0]);
        let columns = layout.experiment.columns.clone();
        let Some(run) = layout.experiment.runs.last_mut() else {
            continue;
        };
        for (name, values) in columns.iter().zip(&mut run.values) {
            for (value, t) in values.iter_mut().zip(&run.time) {
                let stands = |x: f64| if *t < REST { x } else { f64::NAN };
                *value = match name.as_str() {
                    name if name.starts_with("valve_") => f64::from(u8::from(*t < opening)),
                    "torso_y_m" | "torso_angle_rad" => stands(0.0),
                    name if name.starts_with("knee") && name.ends_with("angle_rad") => stands(knee),
                    name if name.starts_with("hip") && name.ends_with("angle_rad") => stands(hip),
                    "tank_pressure_gauge_pa" => tank,
                    _ => 0.0,
                };
            }
        }
    }
}
