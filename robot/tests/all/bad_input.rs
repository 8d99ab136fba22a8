//! Robot files, overrides and force tables that are wrong, and what each is told.

use std::fs;
use std::path::{Path, PathBuf};

use saltus_robot::{Robot, resolve};

/// A sound robot file whose lines the messages below count.
const SOUND: &str = r#"name = "hopper"
[body]
mass_kg = 2.75
inertia_kg_m2 = 0.0792
wheel_radius_m = 0.24
legs = 5
[leg]
kind = "pneumatic"
stroke_m = 0.06
valve_delay_ms = 10
viscous_friction_n_s_per_m = 5.2843
coulomb_friction_n = 9.7003
bore_mm = 19.05
dead_volume_m3 = 5.4e-6
supply_pressure_gauge_psi = 120
discharge_coefficient = 0.5378
orifice_radius_mm = 1.0215
gas = "air"
gas_temperature_k = 293.15
[leg.cushion]
length_mm = 4
stiffness_n_per_m = 1e4
damping_n_s_per_m = 30
[environment]
gravity_m_s2 = 9.80665
ambient_pressure_pa = 101325
"#;

/// What is said of `text` as `hopper.toml`.
fn complaint(text: &str) -> String {
    match Robot::parse(text, "hopper.toml", Path::new(".")) {
        Ok(robot) => panic!("accepted:\n{text}\n{robot:?}"),
        Err(error) => error.to_string(),
    }
}

/// That a message is `expected`, or begins so if `expected` ends with `…`.
#[track_caller]
fn says(message: &str, expected: &str) {
    match expected.strip_suffix('…') {
        Some(beginning) => assert!(message.starts_with(beginning), "{message}"),
        None => assert_eq!(message, expected),
    }
}

/// The sound file with `line` in place of `old`.
#[track_caller]
fn check(old: &str, line: &str, expected: &str) {
    assert!(SOUND.contains(old), "{old} is not in the sound file");
    says(&complaint(&SOUND.replacen(old, line, 1)), expected);
}

#[test]
fn the_sound_file_is_sound() {
    let robot = Robot::parse(SOUND, "hopper.toml", Path::new(".")).expect("sound");
    assert_eq!(robot.leg.cushion.map(|cushion| cushion.length), Some(0.004));
}

#[test]
fn numbers_outside_their_domains() {
    check(
        "bore_mm = 19.05",
        "bore_mm = -3",
        "hopper.toml:13: leg.bore_mm = -3: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= 0",
        "hopper.toml:3: body.mass_kg = 0: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= nan",
        "hopper.toml:3: body.mass_kg = nan: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= inf",
        "hopper.toml:3: body.mass_kg = inf: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= 1e400",
        "hopper.toml:3: body.mass_kg = 1e400: must be a finite number > 0",
    );
    check(
        "= 0.24",
        "= -0.0",
        "hopper.toml:5: body.wheel_radius_m = -0.0: must be a finite number > 0",
    );
    check(
        "= 19.05",
        "= 1e-400",
        "hopper.toml:13: leg.bore_mm = 1e-400: must be a finite number > 0",
    );
    check(
        "= 0.0792",
        "= -1",
        "hopper.toml:4: body.inertia_kg_m2 = -1: must be a finite number ≥ 0",
    );
    check(
        "delay_ms = 10",
        "delay_ms = -1",
        "hopper.toml:10: leg.valve_delay_ms = -1: must be a finite number ≥ 0",
    );
    check(
        "= 120",
        "= -1",
        "hopper.toml:15: leg.supply_pressure_gauge_psi = -1: must be a gauge pressure ≥ 0 and \
         ≤ 1450380 psi (1e10 Pa)",
    );
    check(
        "= 0.5378",
        "= 1.1",
        "hopper.toml:16: leg.discharge_coefficient = 1.1: must be a finite number > 0 and ≤ 1",
    );
    check(
        "gauge_psi = 120",
        "absolute_pa = 100000",
        "hopper.toml:15: leg.supply_pressure_absolute_pa = 100000: must be an absolute pressure \
         ≥ 101325 Pa and ≤ 1e10 Pa",
    );
    check(
        "gauge_psi = 120",
        "absolute_psi = 14",
        "hopper.toml:15: leg.supply_pressure_absolute_psi = 14: must be an absolute pressure \
         ≥ 14.6959 psi (101325 Pa) and ≤ 1450380 psi (1e10 Pa)",
    );
    check(
        "= 120",
        "= \"120 psi\"",
        "hopper.toml:15: leg.supply_pressure_gauge_psi = \"120 psi\": must be a gauge pressure ≥ 0 \
         and ≤ 1450380 psi (1e10 Pa)",
    );
    check(
        "= 120",
        "= 1e308",
        "hopper.toml:15: leg.supply_pressure_gauge_psi = 1e308: must be a gauge pressure ≥ 0 and \
         ≤ 1450380 psi (1e10 Pa)",
    );
}

#[test]
fn numbers_that_do_not_fit_together() {
    check(
        "length_mm = 4",
        "length_mm = 60",
        "hopper.toml:21: leg.cushion.length_mm = 60: must be a finite number > 0 and < 60 mm",
    );
    check(
        "[leg.cushion]",
        "exhaust_port = { position_m = 0.06, area_mm2 = 3 }\n[leg.cushion]",
        "hopper.toml:20: leg.exhaust_port.position_m = 0.06: must be a finite number > 0 and < \
         0.06 m",
    );
    check(
        "[leg.cushion]",
        "polytropic_exponent = 1.5\n[leg.cushion]",
        "hopper.toml:20: leg.polytropic_exponent = 1.5: must be a finite number ≥ 1 and ≤ 1.4",
    );
    check(
        "gas = \"air\"",
        "gas = \"co2\"\npolytropic_exponent = 1.35",
        "hopper.toml:19: leg.polytropic_exponent = 1.35: must be a finite number ≥ 1 and ≤ 1.289",
    );
}

/// `line` added to the body (from line 7), the leg (from line 20) or the file (from line 27) of the
/// sound file.
#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn keys_of_a_rig() {
    let body = |line: &str, expected: &str| check("[leg]", &format!("{line}\n[leg]"), expected);
    body(
        "imbalance_mm = -1",
        "hopper.toml:7: body.imbalance_mm = -1: must be a finite number ≥ 0",
    );
    body(
        "imbalance_angle_deg = inf",
        "hopper.toml:7: body.imbalance_angle_deg = inf: must be a finite number",
    );
    body(
        "axle_friction_n_m = -1",
        "hopper.toml:7: body.axle_friction_n_m = -1: must be a finite number ≥ 0",
    );

    let leg = |line: &str, expected: &str| {
        check("[leg.cushion]", &format!("{line}\n[leg.cushion]"), expected);
    };
    leg(
        "center_m = -0.1",
        "hopper.toml:20: leg.center_m = -0.1: must be a finite number ≥ 0",
    );
    leg(
        "rod_length_m = -0.1",
        "hopper.toml:20: leg.rod_length_m = -0.1: must be a finite number ≥ 0",
    );
    leg(
        "rod_radius_mm = nan",
        "hopper.toml:20: leg.rod_radius_mm = nan: must be a finite number ≥ 0",
    );
    leg(
        "mass_kg = 0.05",
        "hopper.toml:7: missing key leg.center_m or center_mm or center_cm or center_in or center_ft",
    );
    leg(
        "mass_g = 550\ncenter_m = 0.1",
        "hopper.toml:20: leg.mass_g = 550: must be a finite number ≥ 0 and < 550 g, for all \
         legs to have less than body.mass",
    );
    // 0.0792/(5 · 1²) = 0.01584 kg at 1 m.
    leg(
        "mass_kg = 0.4\ncenter_m = 1",
        "hopper.toml:20: leg.mass_kg = 0.4: must be a finite number ≥ 0 and < 0.01584 kg, for all \
         legs to have less than body.inertia",
    );

    let rig =
        |lines: &str, expected: &str| says(&complaint(&format!("{SOUND}{lines}\n")), expected);
    rig(
        "boom = 3",
        "hopper.toml:27: unknown key environment.boom; the keys allowed there are …",
    );
    rig(
        "[boom]\nlength_m = 2",
        "hopper.toml:27: missing key boom.mass_kg or mass_g or mass_lb",
    );
    rig(
        "[boom]\nmass_kg = 1",
        "hopper.toml:27: missing key boom.length_m or length_mm or length_cm or length_in or length_ft",
    );
    rig(
        "[boom]\nmass_kg = -1",
        "hopper.toml:28: boom.mass_kg = -1: must be a finite number ≥ 0",
    );
    rig(
        "[boom]\nmass_kg = 1\nlength_m = 0",
        "hopper.toml:29: boom.length_m = 0: must be a finite number > 0",
    );
    let boom = "[boom]\nmass_kg = 0.5\nlength_m = 2";
    rig(
        &format!("{boom}\nradius_mm = -5"),
        "hopper.toml:30: boom.radius_mm = -5: must be a finite number ≥ 0",
    );
    rig(
        &format!("{boom}\nbending_stiffness_n_m_per_rad = 0"),
        "hopper.toml:30: boom.bending_stiffness_n_m_per_rad = 0: must be a finite number > 0",
    );
    rig(
        &format!("{boom}\ncounterweight = {{ mass_kg = 1, distance_m = 0 }}"),
        "hopper.toml:30: boom.counterweight.distance_m = 0: must be a finite number > 0",
    );
    rig(
        &format!("{boom}\ncounterweight = {{ distance_m = 1 }}"),
        "hopper.toml:30: missing key boom.counterweight.mass_kg or mass_g or mass_lb",
    );
    // (2.75 + 0.5/2) · 2/0.5 = 12 kg balance robot and boom.
    rig(
        &format!("{boom}\ncounterweight = {{ mass_kg = 12.5, distance_m = 0.5 }}"),
        "hopper.toml:30: boom.counterweight.mass_kg = 12.5: must be a finite number ≥ 0 and ≤ 12 \
         kg, which balances robot and boom",
    );

    rig(
        "[foot]\nradius_mm = -1",
        "hopper.toml:28: foot.radius_mm = -1: must be a finite number ≥ 0",
    );
    rig(
        "[foot]\nlength_mm = 1",
        "hopper.toml:28: unknown key foot.length_mm; the keys allowed there are …",
    );

    let ground = |line: &str, allowed: &str| {
        rig(
            &format!("[ground]\n{line}"),
            &format!("hopper.toml:28: ground.{line}: must be a finite number {allowed}"),
        );
    };
    for bad in ["-1", "-inf", "nan", "1e400"] {
        ground(&format!("static_friction = {bad}"), "≥ 0, or inf");
        ground(&format!("kinetic_friction = {bad}"), "≥ 0, or inf");
    }
    ground("across_friction = inf", "≥ 0");
    ground("restitution = 1", "≥ 0 and < 1");
    ground("restitution = -0.1", "≥ 0 and < 1");
    ground("stiffness_n_per_m = 0", "> 0");
    ground("damping_n_s_per_m = -1", "≥ 0");
    ground("slope_deg = 45", "> -45 deg and < 45 deg");
}

/// `lines` added at the end of the sound file, from line 27.
#[test]
fn keys_of_a_running_robot() {
    let rig =
        |lines: &str, expected: &str| says(&complaint(&format!("{SOUND}{lines}\n")), expected);
    rig(
        "[struts]",
        "hopper.toml:27: missing key struts.distance_m or distance_mm or distance_cm or distance_in or distance_ft",
    );
    rig(
        "[struts]\ndistance_m = 0.25",
        "hopper.toml:28: struts.distance_m = 0.25: must be a finite number > 0 and ≤ 0.24 m, which \
         is body.wheel_radius",
    );
    rig(
        "[struts]\ndistance_m = 0.14\nradius_mm = -5",
        "hopper.toml:29: struts.radius_mm = -5: must be a finite number ≥ 0",
    );
    let sensors = |line: &str, allowed: &str| {
        rig(
            &format!("[sensors]\n{line}"),
            &format!("hopper.toml:28: sensors.{line}: must be a {allowed}"),
        );
    };
    sensors("wheel_counts = 0", "whole number ≥ 1 and ≤ 1e6");
    sensors("radius_counts = 1e10", "whole number ≥ 1 and ≤ 1e6");
    sensors("fine_gyro_range_deg_s = -573", "finite number > 0");
    sensors("gyro_noise_rad_s = -0.1", "finite number ≥ 0");
    sensors("gyro_bias_rad_s = inf", "finite number");
    sensors("coarse_accelerometer_range_g = 0", "finite number > 0");
    sensors("accelerometer_bias_g = nan", "finite number");
    for bad in ["3", "25", "16.5"] {
        sensors(
            &format!("converter_bits = {bad}"),
            "whole number ≥ 4 and ≤ 24",
        );
    }
    for bad in ["-1", "0.5", "2"] {
        sensors(
            &format!("output_delay_cycles = {bad}"),
            "whole number ≥ 0 and ≤ 1",
        );
    }
    sensors("period_s = 1", "finite number > 0 and ≤ 0.1 s");
    sensors("range_period_ms = 0", "finite number > 0");
    rig(
        "[sensors]\nconvertor_bits = 16",
        "hopper.toml:28: unknown key sensors.convertor_bits; the nearest known key is \
         sensors.converter_bits",
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn values_of_the_wrong_type() {
    check(
        "= 2.75",
        "= \"2.75\"",
        "hopper.toml:3: body.mass_kg = \"2.75\": must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= true",
        "hopper.toml:3: body.mass_kg = true: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= [2.75]",
        "hopper.toml:3: body.mass_kg = [2.75]: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= 1979-05-27",
        "hopper.toml:3: body.mass_kg = 1979-05-27: must be a finite number > 0",
    );
    check(
        "= 2.75",
        "= { x = 1 }",
        "hopper.toml:3: body.mass_kg = { x = 1 }: must be a finite number > 0",
    );
    check(
        "legs = 5",
        "legs = 0",
        "hopper.toml:6: body.legs = 0: must be a whole number ≥ 1",
    );
    check(
        "legs = 5",
        "legs = 2.5",
        "hopper.toml:6: body.legs = 2.5: must be a whole number ≥ 1",
    );
    check(
        "legs = 5",
        "legs = -1",
        "hopper.toml:6: body.legs = -1: must be a whole number ≥ 1",
    );
    check(
        "legs = 5",
        "legs = 4294967296",
        "hopper.toml:6: body.legs = 4294967296: must be a whole number ≥ 1",
    );
    check(
        "\"hopper\"",
        "5",
        "hopper.toml:1: name = 5: must be text in quotes, not empty",
    );
    check(
        "\"hopper\"",
        "\"\"",
        "hopper.toml:1: name = \"\": must be text in quotes, not empty",
    );
    check(
        "\"pneumatic\"",
        "\"piston\"",
        "hopper.toml:8: leg.kind = \"piston\": must be pneumatic, muscle, spring, constant or table",
    );
    check(
        "\"air\"",
        "\"xenon\"",
        "hopper.toml:18: leg.gas = \"xenon\": must be air, nitrogen, oxygen, argon, helium, \
         hydrogen, carbon dioxide, co2, methane, or a table of heat_ratio with \
         constant_j_per_kg_k or molar_mass_g_mol",
    );
    check(
        "\"air\"",
        "{ heat_ratio = 1, constant_j_per_kg_k = 287 }",
        "hopper.toml:18: leg.gas.heat_ratio = 1: must be a ratio of heat capacities > 1 and \
         ≤ 1.67",
    );
    check(
        "\"air\"",
        "{ heat_ratio = 1.4, molar_mass_kg_mol = 28.96 }",
        "hopper.toml:18: leg.gas.molar_mass_kg_mol = 28.96: must be a molar mass > 0 and ≤ 1 \
         kg/mol, not g/mol",
    );
    check(
        "\"air\"",
        "{ heat_ratio = 1.4, molar_mass_g_mol = 2896 }",
        "hopper.toml:18: leg.gas.molar_mass_g_mol = 2896: must be a molar mass > 0 and ≤ 1000 g/mol",
    );
    check(
        "\"air\"",
        "{ heat_ratio = 1.4, molar_mass_g_mol = 28.96, constant_j_per_kg_k = 287 }",
        "hopper.toml:18: leg.gas.molar_mass_g_mol is already given as \
         leg.gas.constant_j_per_kg_k; give one of them",
    );
    check(
        "\"air\"",
        "{ heat_ratio = 1.4 }",
        "hopper.toml:18: missing key leg.gas.constant_j_per_kg_k or molar_mass_kg_mol or \
         molar_mass_g_mol",
    );
    check(
        "[body]",
        "[errors]\nrate_rad_s = -1\n[body]",
        "hopper.toml:3: errors.rate_rad_s = -1: must be a finite number ≥ 0",
    );
    check(
        "[body]",
        "errors = 3\n[body]",
        "hopper.toml:2: errors = 3: must be a table",
    );
    check(
        "[environment]",
        "[[environment]]",
        "hopper.toml:24: environment = [[environment]]: must be a table",
    );
}

#[test]
#[expect(clippy::too_many_lines, reason = "a list of cases")]
fn keys_unknown_missing_or_twice() {
    check(
        "mass_kg",
        "mas_kg",
        "hopper.toml:3: unknown key body.mas_kg; the nearest known key is body.mass_kg",
    );
    check(
        "mass_kg",
        "mass_oz",
        "hopper.toml:3: unknown key body.mass_oz; the nearest known key is body.mass_kg",
    );
    check(
        "[body]",
        "[bodi]",
        "hopper.toml:2: unknown key bodi; the nearest known key is body",
    );
    check(
        "[leg.cushion]",
        "[cushion]",
        "hopper.toml:20: unknown key cushion; the keys allowed there are name, …",
    );
    check(
        "mass_kg",
        "\"mass kg\" = 1\nmass_kg",
        "hopper.toml:3: unknown key body.\"mass kg\"; the nearest known key is body.mass_kg",
    );
    check(
        "valve_delay_ms",
        "release_delay_ms",
        "hopper.toml:10: unknown key leg.release_delay_ms; the nearest known key is \
         leg.valve_delay_ms",
    );
    check(
        "damping_n_s_per_m = 30",
        "damping_n_s_per_m = 30\nsize = 3",
        "hopper.toml:24: unknown key leg.cushion.size; the keys allowed there are …",
    );
    check(
        "name = \"hopper\"",
        "",
        "hopper.toml: missing key name: text in quotes, not empty",
    );
    check(
        "mass_kg = 2.75",
        "",
        "hopper.toml:2: missing key body.mass_kg or mass_g or mass_lb",
    );
    check(
        "legs = 5",
        "",
        "hopper.toml:2: missing key body.legs: a whole number ≥ 1",
    );
    check(
        "kind = \"pneumatic\"",
        "",
        "hopper.toml:7: missing key leg.kind: pneumatic, muscle, spring, constant or table",
    );
    check(
        "stroke_m = 0.06",
        "",
        "hopper.toml:7: missing key leg.stroke_m or stroke_mm or stroke_cm or stroke_in or stroke_ft",
    );
    check(
        "length_mm = 4",
        "",
        "hopper.toml:20: missing key leg.cushion.length_m or length_mm or length_cm or length_in or length_ft",
    );
    check(
        "ambient_pressure_pa = 101325",
        "",
        "hopper.toml:24: missing key environment.ambient_pressure_pa or ambient_pressure_kpa or \
         ambient_pressure_bar or ambient_pressure_psi",
    );
    check(
        "bore_mm = 19.05",
        "bore_mm = 19.05\nbore_m = 0.01905",
        "hopper.toml:14: leg.bore_m is already given as leg.bore_mm; give one of them",
    );
    check(
        "[leg.cushion]",
        "supply_pressure_absolute_pa = 9e5\n[leg.cushion]",
        "hopper.toml:20: leg.supply_pressure_absolute_pa is already given as \
         leg.supply_pressure_gauge_psi; give one of them",
    );
    check(
        "mass_kg = 2.75",
        "mass_kg = 2.75\nmass_kg = 2.75",
        "hopper.toml:4: not TOML: duplicate key",
    );
    check("[leg]", "[body]", "hopper.toml:7: not TOML: duplicate key");
}

#[test]
fn text_that_is_not_toml() {
    let check = |text: &str, expected: &str| assert_eq!(complaint(text), expected);
    check(
        "",
        "hopper.toml: missing key name: text in quotes, not empty",
    );
    check(
        "# nothing\n",
        "hopper.toml: missing key name: text in quotes, not empty",
    );

    // What follows is in the words of the `toml` crate.
    let check = |text: &str, place: &str| {
        let complaint = complaint(text);
        assert!(
            complaint.starts_with(&format!("{place}: not TOML: ")),
            "{complaint}"
        );
    };
    check("name\n", "hopper.toml:1");
    check("name = \"hopper\n", "hopper.toml:1");
    check("name = hopper\n", "hopper.toml:1");
    check("name = 'h'\n\n[body\n", "hopper.toml:3");
    check("name = 'h'\nmass = 1,5\n", "hopper.toml:2");
    check("{}", "hopper.toml:1");
    check("\0\u{1}\u{7f}", "hopper.toml:1");
    // Nested so deeply that a recursive reader would run out of stack.
    check(
        &format!("{} = 1", "a.".repeat(100_000) + "a"),
        "hopper.toml",
    );
    check(&format!("[{}]", "a.".repeat(100_000) + "a"), "hopper.toml");
    check(&format!("a = {}", "[".repeat(100_000)), "hopper.toml:1");
    check(&format!("a = {}", "{a=".repeat(100_000)), "hopper.toml:1");
    check(&"[".repeat(100_000), "hopper.toml:1");
}

#[test]
fn long_values_and_keys_are_cut() {
    let long = "x".repeat(1 << 20);
    let key = complaint(&format!("{long} = 1\n"));
    says(
        &key,
        &format!(
            "hopper.toml:1: unknown key {}…; the keys allowed there are name, …",
            "x".repeat(40)
        ),
    );
    let value = complaint(&SOUND.replacen("2.75", &format!("\"{long}\""), 1));
    assert_eq!(
        value,
        format!(
            "hopper.toml:3: body.mass_kg = \"{}…: must be a finite number > 0",
            "x".repeat(39)
        )
    );
}

/// `rats-planar` with `overrides`.
#[track_caller]
fn check_set(overrides: &[&str], expected: &str) {
    let overrides: Vec<String> = overrides.iter().map(|&text| text.into()).collect();
    match resolve("rats-planar", &overrides) {
        Ok(robot) => panic!("accepted: {overrides:?}\n{robot:?}"),
        Err(error) => says(&error.to_string(), expected),
    }
}

#[test]
fn overrides() {
    check_set(
        &["leg.foo=1"],
        "--set leg.foo=1: unknown key leg.foo; the keys allowed there are …",
    );
    check_set(
        &["leg.boer_mm=1"],
        "--set leg.boer_mm=1: unknown key leg.boer_mm; the nearest known key is leg.bore_mm",
    );
    check_set(
        &["mass_kg=1"],
        "--set mass_kg=1: unknown key mass_kg; the keys allowed there are …",
    );
    check_set(
        &["leg.bore_mm=-3"],
        "--set leg.bore_mm=-3: leg.bore_mm = -3: must be a finite number > 0",
    );
    check_set(
        &["leg.bore_mm=wide"],
        "--set leg.bore_mm=wide: leg.bore_mm = wide: must be a finite number > 0",
    );
    check_set(
        &["leg.bore_mm="],
        "--set leg.bore_mm=: leg.bore_mm = : must be a finite number > 0",
    );
    check_set(
        &["leg.bore_mm=1 2"],
        "--set leg.bore_mm=1 2: leg.bore_mm = 1 2: must be a finite number > 0",
    );
    check_set(
        &["body.legs=2.5"],
        "--set body.legs=2.5: body.legs = 2.5: must be a whole number ≥ 1",
    );
    check_set(
        &["leg.return_spring.stiffness_n_per_m=50"],
        "--set leg.return_spring.stiffness_n_per_m=50: missing key leg.return_spring.preload_n",
    );
    check_set(
        &["leg.gas.heat_ratio=1.3"],
        "--set leg.gas.heat_ratio=1.3: leg.gas = \"air\": must be a table",
    );
    check_set(&["leg=3"], "--set leg=3: leg = 3: must be a table");
    check_set(
        &["leg.cushion=soft"],
        "--set leg.cushion=soft: leg.cushion = soft: must be a table",
    );
    check_set(
        &["leg.cushion={length_mm=1, length_m=1, stiffness_n_per_m=1, damping_n_s_per_m=1}"],
        "--set leg.cushion={length_mm=1, length_m=1, stiffness_n_per_m=1, damping_n_s_per_m=1}: \
         leg.cushion.length_mm is already given as leg.cushion.length_m; give one of them",
    );
    check_set(
        &["leg.kind=spring"],
        "robots/rats-planar.toml:15: unknown key leg.valve_delay_ms; the nearest known key is \
         leg.release_delay_ms",
    );
    let not_an_override = "must be KEY=VALUE with a dotted key, as in leg.stroke_m=0.05";
    for text in [
        "leg.bore_mm",
        "",
        "=",
        "=3",
        "leg..bore_mm=3",
        ".=3",
        "leg bore=3",
        "a\nb=3",
        "[leg]\nbore_mm=3",
    ] {
        check_set(&[text], &format!("--set {text}: {not_an_override}"));
    }
}

/// A folder of its own below the system's temporary one, removed when dropped.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("saltus-robot-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).expect("a writable temporary folder");
        Folder(path)
    }

    fn write(&self, name: &str, bytes: &[u8]) -> String {
        let path = self.0.join(name);
        fs::write(&path, bytes).expect("a writable temporary folder");
        path.display().to_string()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What stays behind harms nobody.
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn complaint_about(path: &str) -> String {
    resolve(path, &[]).expect_err("a bad file").to_string()
}

#[test]
fn files_that_are_no_robot_files() {
    let folder = Folder::new("files");
    let no_robot = "no such robot or file; built in are rats-planar, rats-boom, rats-run, rats-twelve, \
                    spring-hopper, table-hopper";
    assert_eq!(complaint_about("ratz"), format!("ratz: {no_robot}"));
    assert_eq!(complaint_about(""), format!(": {no_robot}"));
    let missing = folder.0.join("missing.toml").display().to_string();
    assert_eq!(complaint_about(&missing), format!("{missing}: {no_robot}"));
    let directory = folder.0.display().to_string();
    assert!(complaint_about(&directory).starts_with(&format!("{directory}: cannot be read: ")));
    let empty = folder.write("empty.toml", b"");
    assert_eq!(
        complaint_about(&empty),
        format!("{empty}: missing key name: text in quotes, not empty")
    );
    let binary = folder.write("binary.toml", b"name = \"\xff\xfe\"");
    assert_eq!(
        complaint_about(&binary),
        format!("{binary}: byte 8 is not UTF-8 text")
    );
    let huge = folder.write("huge.toml", &vec![b'\n'; (4 << 20) + 1]);
    assert_eq!(
        complaint_about(&huge),
        format!("{huge}: larger than 4 MiB, the most a robot file or force table may have")
    );
    let large = folder.write("large.toml", &vec![b'\n'; 4 << 20]);
    assert_eq!(
        complaint_about(&large),
        format!("{large}: missing key name: text in quotes, not empty")
    );
}

/// A robot with a force table; `leg.file` and `leg.table` are left to add.
const TABLE_LEG: &str = r#"name = "hopper"
body = { mass_kg = 1, inertia_kg_m2 = 0.01, wheel_radius_m = 0.2, legs = 3 }
environment = { gravity_m_s2 = 9.81, ambient_pressure_kpa = 101 }
[leg]
kind = "table"
stroke_mm = 50
release_delay_ms = 2
viscous_friction_n_s_per_m = 0
coulomb_friction_n = 0
"#;

#[test]
fn force_tables_in_csv_files() {
    let folder = Folder::new("csv");
    let check = |csv: &str, expected: &str| {
        let file = folder.write("force.csv", csv.as_bytes());
        let robot = folder.write(
            "hopper.toml",
            format!("{TABLE_LEG}file = \"force.csv\"\n").as_bytes(),
        );
        assert_eq!(
            complaint_about(&robot),
            expected.replace("force.csv", &file)
        );
    };
    let columns = "must be extension_m,speed_m_s,force_n";
    let extensions = "must be at least 2 finite numbers, strictly increasing from 0 to at least \
        0.05 m, the stroke";
    let speeds = "must be at least 2 finite numbers, strictly increasing from 0";
    let header = "extension_m,speed_m_s,force_n\n";
    check("", &format!("force.csv:1: columns : {columns}"));
    check(
        "a,b,c\n1,2,3\n",
        &format!("force.csv:1: columns a,b,c: {columns}"),
    );
    check(
        "extension_m,speed_m_s,force_n,extra\n",
        &format!("force.csv:1: columns extension_m,speed_m_s,force_n,extra: {columns}"),
    );
    check(
        "extension_m,speed_m_s,force_n,force_n\n",
        &format!("force.csv:1: columns extension_m,speed_m_s,force_n,force_n: {columns}"),
    );
    check(
        header,
        &format!("force.csv: extension_m = []: {extensions}"),
    );
    check(
        &format!("{header}0,0,1\n0,1,2\n"),
        &format!("force.csv: extension_m = [0.0]: {extensions}"),
    );
    check(
        &format!("{header}0,0,1\n0,1,2\n0.04,0,3\n0.04,1,4\n"),
        &format!("force.csv: extension_m = [0.0, 0.04]: {extensions}"),
    );
    check(
        &format!("{header}0.01,0,1\n0.01,1,2\n0.05,0,3\n0.05,1,4\n"),
        &format!("force.csv: extension_m = [0.01, 0.05]: {extensions}"),
    );
    check(
        &format!("{header}0,0,1\n0.05,0,2\n"),
        &format!("force.csv: speed_m_s = [0.0]: {speeds}"),
    );
    check(
        &format!("{header}0,0,1\n0,1,2\n0.05,0,3\n"),
        "force.csv: extension 0.05 m, speed 1 m/s: must be given; the grid has each extension at \
         each speed",
    );
    check(
        &format!("{header}0,0,1\n0,1,2\n0.05,0,3\n# twice\n0.05,0,4\n"),
        "force.csv:6: extension 0.05 m, speed 0 m/s: must be given once; line 4 has it too",
    );
    check(
        &format!("{header}0,0,fast\n"),
        "force.csv:2: force_n = fast: must be a finite number",
    );
    check(
        &format!("{header}0,0,1\nnan,0,1\n"),
        "force.csv:3: extension_m = nan: must be a finite number",
    );
    check(
        &format!("{header}0,inf,1\n"),
        "force.csv:2: speed_m_s = inf: must be a finite number",
    );
    check(
        &format!("{header}0,0,\n"),
        "force.csv:2: force_n = : must be a finite number",
    );
    check(
        &format!("{header}0,0,1\n0,1\n"),
        "force.csv:3: row = 0,1: must be 3 cells",
    );
}

#[test]
fn force_tables_in_the_robot_file() {
    let check = |table: &str, expected: &str| {
        says(&complaint(&format!("{TABLE_LEG}{table}")), expected);
    };
    let sound = "extensions_m = [0, 0.05]\nspeeds_m_s = [0, 1]\nforces_n = [[1, 2], [3, 4]]\n";
    Robot::parse(
        &format!("{TABLE_LEG}[leg.table]\n{sound}"),
        "hopper.toml",
        Path::new("."),
    )
    .expect("sound");

    let forces = "must be a list of 2 lists, one for each extension, of 2 finite numbers, one for \
        each speed";
    check("", "hopper.toml:4: missing key leg.file or table");
    check(
        "file = 3\n",
        "hopper.toml:10: leg.file = 3: must be text in quotes, not empty",
    );
    check(
        "table = 3\n",
        "hopper.toml:10: leg.table = 3: must be a table",
    );
    check(
        "fiel = 'force.csv'\n",
        "hopper.toml:10: unknown key leg.fiel; the nearest known key is leg.file",
    );
    check(
        &format!("file = \"force.csv\"\n[leg.table]\n{sound}"),
        "hopper.toml:11: leg.table is already given as leg.file; give one of them",
    );
    check(
        "[leg.table]\n",
        "hopper.toml:10: missing key leg.table.extensions_m: at least 2 finite numbers, \
         strictly increasing from 0 to at least 0.05 m, the stroke",
    );
    check(
        "[leg.table]\nextensions_m = [0, 0.02, 0.01, 0.05]\n",
        "hopper.toml:11: leg.table.extensions_m = [0, 0.02, 0.01, 0.05]: must be at least 2 \
         finite numbers, strictly increasing from 0 to at least 0.05 m, the stroke",
    );
    check(
        &format!("[leg.table]\n{}", sound.replace("[0, 1]", "[0, 1, 1]")),
        "hopper.toml:12: leg.table.speeds_m_s = [0, 1, 1]: must be at least 2 finite numbers, \
         strictly increasing from 0",
    );
    check(
        &format!("[leg.table]\n{}", sound.replace("[0, 1]", "[0, nan]")),
        "hopper.toml:12: leg.table.speeds_m_s = [0, nan]: must be at least 2 finite numbers, \
         strictly increasing from 0",
    );
    for wrong in [
        "3",
        "[]",
        "[[1, 2]]",
        "[[1, 2], [3]]",
        "[[1, 2], [3, inf]]",
        "[[1, 2], [3, \"4\"]]",
        "[1, 2, 3, 4]",
    ] {
        check(
            &format!("[leg.table]\n{}", sound.replace("[[1, 2], [3, 4]]", wrong)),
            &format!("hopper.toml:13: leg.table.forces_n = {wrong}: {forces}"),
        );
    }
    let missing = complaint(&format!("{TABLE_LEG}file = \"no-such.csv\"\n"));
    assert!(
        missing.starts_with("./no-such.csv: cannot be read: "),
        "{missing}"
    );
}

/// A tank, a tube and the lags of a valve.
#[test]
fn what_a_robot_carries_its_gas_in() {
    let refused = |set: &[&str], expected: &str| check_set(set, expected);
    refused(
        &["tank.volume_l=0"],
        "--set tank.volume_l=0: tank.volume_l = 0: must be a finite number > 0, or inf",
    );
    refused(
        &["tank.volume_l=-1"],
        "--set tank.volume_l=-1: tank.volume_l = -1: must be a finite number > 0, or inf",
    );
    refused(
        &["tank.volume_m3=nan"],
        "--set tank.volume_m3=nan: tank.volume_m3 = nan: must be a finite number > 0, or inf",
    );
    refused(
        &["tank.wall_resistance_k_per_w=1"],
        "--set tank.wall_resistance_k_per_w=1: missing key tank.volume_m3 or volume_cm3 or volume_l",
    );
    refused(
        &["tank.volume_l=1", "tank.wall_resistance_k_per_w=-1"],
        "--set tank.wall_resistance_k_per_w=-1: tank.wall_resistance_k_per_w = -1: must be a finite \
         number ≥ 0, or inf",
    );
    refused(
        &["leg.tube={length_m=1, diameter_mm=0}"],
        "--set leg.tube={length_m=1, diameter_mm=0}: leg.tube.diameter_mm = 0: must be a finite \
         number > 0",
    );
    refused(
        &["leg.tube={length_m=-1, diameter_mm=4}"],
        "--set leg.tube={length_m=-1, diameter_mm=4}: leg.tube.length_m = -1: must be a finite \
         number ≥ 0",
    );
    refused(
        &["leg.tube={length_m=1, diameter_mm=4, roughness_mm=1}"],
        "--set leg.tube={length_m=1, diameter_mm=4, roughness_mm=1}: leg.tube.roughness_mm = 1: \
         must be a finite number ≥ 0 and ≤ 0.2 mm, a twentieth of its diameter",
    );
    refused(
        &["leg.valve_closing_delay_ms=-1"],
        "--set leg.valve_closing_delay_ms=-1: leg.valve_closing_delay_ms = -1: must be a finite \
         number ≥ 0",
    );
    refused(
        &["leg.valve_time_constant_ms=nan"],
        "--set leg.valve_time_constant_ms=nan: leg.valve_time_constant_ms = nan: must be a finite \
         number ≥ 0",
    );
    // A tank is filled to the leg's supply pressure.
    check(
        "supply_pressure_gauge_psi = 120",
        "supply_pressure_absolute_pa = 9e4",
        "hopper.toml:15: leg.supply_pressure_absolute_pa = 9e4: must be an absolute pressure ≥ 101325 Pa \
         and ≤ 1e10 Pa",
    );
    let error = resolve("spring-hopper", &["tank.volume_l=1".into()]).expect_err("no gas");
    assert_eq!(
        error.to_string(),
        "--set tank.volume_l=1: tank = a table: must be left out for a leg whose leg.kind is not \
         \"pneumatic\" or \"muscle\": it uses no gas"
    );
}

/// A leg with a muscle, as `docs/robots.md` has it.
#[test]
fn what_is_no_muscle() {
    let readme = include_str!("../../robots/README.md");
    let examples = readme.split("```toml\n").skip(1);
    let mut texts = examples.filter_map(|rest| rest.split("```").next());
    let sound = texts
        .find(|text| text.contains("kind = \"muscle\""))
        .expect("it is there");
    let robot = Robot::parse(sound, "leg.toml", Path::new(".")).expect("sound");
    let again = Robot::parse(&robot.to_toml(), "leg.toml", Path::new("."));
    assert_eq!(again.expect("sound"), robot);
    // It has no bore that its orifice could be wider than.
    assert_eq!(robot.implausible(), []);
    let refused = |old: &str, new: &str, expected: &str| {
        assert!(sound.contains(old), "{old}");
        let said = complaint(&sound.replacen(old, new, 1)).replace("hopper.toml", "leg.toml");
        assert!(said.contains(expected), "{said}");
    };
    refused(
        "force_n_per_pa = 1.966e-3",
        "force_n_per_pa = 0",
        "leg.muscle.force_n_per_pa = 0: must be a finite number > 0",
    );
    refused(
        "slope_n_per_pa_m = 0.03554",
        "slope_n_per_pa_m = 0.2",
        "3 times the force over the free contraction: a muscle does not push",
    );
    refused(
        "free_contraction_m = [0.0305584,",
        "free_contraction_m = [-0.0305584,",
        "leg.muscle.free_contraction_m = [-0.0305584, 7.58362e-7, -4.9158e-12, 1.…: must be a list of \
         five finite numbers, of which the first, the free contraction without pressure, is > 0",
    );
    refused(
        "free_contraction_m = [0.0305584,",
        "free_contraction_m = [",
        "must be a list of five finite numbers",
    );
    refused(
        "lever = 1 ",
        "lever = nan ",
        "leg.muscle.lever = nan: must be a finite number > 0",
    );
    refused(
        "tendon_stiffness_n_per_m = 4000",
        "tendon_stiffness_n_per_m = 0",
        "leg.muscle.tendon_stiffness_n_per_m = 0: must be a finite number > 0, or inf",
    );
    refused(
        "dead_volume_cm3 = 42.43",
        "bore_mm = 20\ndead_volume_cm3 = 42.43",
        "unknown key leg.bore_mm",
    );
    refused("[leg.muscle]", "[leg.muscles]", "unknown key leg.muscles");
}
