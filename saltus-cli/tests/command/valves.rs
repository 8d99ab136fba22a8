//! Legs with a valve opening time and legs without: a plan is what the simulation flies, whatever
//! drives the leg.

use crate::common::{Folder, rows};

const COURSE: &str = "approach_rate_rad_s = 4.0\ntarget_x_m = 0.5\n";

const CONSTANT: &str = r#"
name = "constant leg"
body = { mass_kg = 1.2, inertia_kg_m2 = 0.02, wheel_radius_m = 0.18, legs = 3 }
environment = { gravity_m_s2 = 9.80665, ambient_pressure_kpa = 101.325 }

[leg]
kind = "constant"
stroke_mm = 80
release_delay_ms = 4
viscous_friction_n_s_per_m = 1.5
coulomb_friction_n = 3
force_n = 150
"#;

/// The greatest size of the numbers in these columns of a CSV report.
fn greatest(csv: &str, columns: &[&str]) -> f64 {
    let (header, rows) = rows(csv);
    let at = |name: &str| header.iter().position(|column| column == name).unwrap();
    let number = |row: &Vec<String>, name: &str| row[at(name)].parse::<f64>().unwrap().abs();
    columns
        .iter()
        .flat_map(|name| rows.iter().map(move |row| number(row, name)))
        .fold(0.0, f64::max)
}

#[test]
fn a_spring_is_not_caught_again() {
    let folder = Folder::new("springs");
    folder.write("course.toml", COURSE);
    let verified = folder.done(
        "verify course.toml --robot spring-hopper --samples 0 --format csv",
        0,
    );
    // The two models agree to 7e-6; the robot rises by a metre and lands after half of one.
    assert!(
        greatest(&verified, &["apex_error_m", "land_error_m"]) < 1e-5,
        "{verified}"
    );
    let law = "verify --law=-0.059648,0.10897 --omega 4 --distance 0.4 --robot spring-hopper \
        --samples 0 --format csv";
    let without = folder.run(&law.split(' ').collect::<Vec<_>>());
    for time in ["0.005", "0.02", "0.1"] {
        let words: Vec<&str> = law.split(' ').chain(["--valve-open", time]).collect();
        let with = folder.run(&words);
        assert_eq!(
            (with.code, &with.out),
            (without.code, &without.out),
            "{time}"
        );
        assert_eq!(
            with.err,
            "note: the leg of spring-hopper has no valve: --valve-open has no effect\n"
        );
    }
}

#[test]
fn no_valve_time_is_shown_for_a_leg_without_a_valve() {
    let folder = Folder::new("no-valve");
    folder.write("course.toml", COURSE);
    let commands = [
        "plan course.toml --plot plan.svg",
        "simulate --omega 4 --alpha-f -0.1",
        "simulate --omega 4 --alpha-f -0.2:0:3",
        "table --omega 4 --distance 0.5",
        "law --omega 3:5:3 --distance 0.5",
        "verify course.toml --samples 0",
    ];
    for command in commands {
        let text = folder.done(&format!("{command} --robot spring-hopper"), 0);
        assert!(!text.contains("valve"), "{command}: {text}");
    }
    assert!(!folder.read("plan.svg").contains("valve"));
    for command in [commands[0], commands[1], commands[5]] {
        let csv = folder.done(&format!("{command} --robot spring-hopper --format csv"), 0);
        let (header, rows) = rows(&csv);
        let at = header
            .iter()
            .position(|name| name == "valve_open_s")
            .unwrap();
        assert!(rows.iter().all(|row| row[at].is_empty()), "{csv}");
    }
    // It is no decision either, and costs nothing: 20 ms would cost 4e-4.
    let plan = folder.done("plan course.toml --robot spring-hopper --format json", 0);
    let plan: serde_json::Value = serde_json::from_str(&plan).unwrap();
    assert!(
        plan["jumps"][0]["valve_open_s"].is_null() && plan["cost"].as_f64().unwrap() < 1e-6,
        "{plan}"
    );
}

/// A drive that is switched off before the end of the stroke drops to 0: the foot leaves there in
/// both models.
#[test]
fn a_drive_that_ends_before_the_stroke_is_a_lift_off() {
    let folder = Folder::new("switched-off");
    folder.write("constant.toml", CONSTANT);
    let smooth =
        "constant.toml --set leg.coulomb_friction_n=0 --set leg.viscous_friction_n_s_per_m=0";
    for robot in ["table-hopper", "constant.toml", smooth] {
        for time in ["0.01", "0.02", "0.03", "0.035", "0.1"] {
            let command = format!(
                "verify --law=-0.06,0.27 --omega 3:5:3 --distance 0.4 --valve-open {time} \
                 --samples 0 --tolerance 1 --format csv --robot {robot}"
            );
            let verified = folder.done(&command, 0);
            assert!(
                greatest(&verified, &["apex_error_m", "land_error_m"]) < 1e-5,
                "{robot} {time}: {verified}"
            );
        }
    }
}
