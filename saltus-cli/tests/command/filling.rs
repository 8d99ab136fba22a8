//! `saltus filling`: what it answers and what it refuses.

use serde_json::Value;

use crate::common::{Folder, Run};

const JUMP: &str = "--omega 4.5 --alpha-f -0.1";

fn run(folder: &Folder, more: &str) -> Run {
    let line = format!("filling {JUMP} {more}");
    folder.run(&line.split_whitespace().collect::<Vec<_>>())
}

fn answer(folder: &Folder, more: &str) -> Value {
    let run = run(folder, &format!("{more} --format json"));
    assert_eq!(run.code, Some(0), "{}", run.err);
    serde_json::from_str(&run.out).unwrap()
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key} of {of}"))
}

#[test]
fn a_tank_empties_jump_after_jump() {
    let folder = Folder::new("filling");
    let found = answer(&folder, "--set tank.volume_l=0.2");
    let rows = found["rows"].as_array().unwrap();
    assert_eq!(found["jumps"], rows.len() - 1);
    assert_eq!(found["end"], "too-low");
    let counting: f64 = rows[..rows.len() - 1]
        .iter()
        .map(|row| number(row, "distance_m"))
        .sum();
    assert!((counting - number(&found, "distance_m")).abs() < 1e-12);
    for pair in rows.windows(2) {
        let [before, after] = [0, 1].map(|k| number(&pair[k], "tank_pressure_pa"));
        assert!(after < before, "{after} after {before}");
        // Of an adiabatic tank P/m^κ stays: so does the gas that is left.
        assert!(number(&pair[1], "tank_temperature_k") < number(&pair[0], "tank_temperature_k"));
    }
    let used: f64 = rows.iter().map(|row| number(row, "gas_kg")).sum();
    let (filled, left) = (number(&found, "gas_kg"), number(&found, "gas_left_pa"));
    let in_tank = left * 0.2e-3 / (287.05 * number(&found, "gas_left_k"));
    assert!(
        (filled - used - in_tank).abs() < 1e-9 * filled,
        "{filled} {used} {in_tank}"
    );
    let isentrope = (in_tank / filled).powf(1.4);
    let fallen = left / number(&rows[0], "tank_pressure_pa");
    // Steps are right to some 1e-9 each, of which a filling takes a thousand.
    assert!((fallen - isentrope).abs() < 1e-7, "{fallen} {isentrope}");
    // The first one is the jump of a full tank.
    let simulated = format!("simulate {JUMP} --set tank.volume_l=0.2 --format json");
    let simulated = folder.run(&simulated.split_whitespace().collect::<Vec<_>>());
    let simulated: Value = serde_json::from_str(&simulated.out).unwrap();
    let apex = number(&simulated["jumps"][0], "apex_m");
    assert!((apex - number(&rows[0], "apex_m")).abs() < 1e-7);
}

#[test]
fn warm_walls_large_tanks_and_low_boxes_carry_further() {
    let folder = Folder::new("filling-more");
    let jumps = |more: &str| number(&answer(&folder, more), "jumps");
    let plain = jumps("--set tank.volume_l=0.2");
    assert!(plain > 2.0, "{plain}");
    assert!(jumps("--set tank.volume_l=0.4") > plain);
    assert!(jumps("--set tank.volume_l=0.2 --set tank.wall_resistance_k_per_w=0") > plain);
    let slow = "--set tank.volume_l=0.2 --set tank.wall_resistance_k_per_w=5";
    assert!(jumps(&format!("{slow} --pause 100")) > jumps(&format!("{slow} --pause 0")));
    let high = answer(&folder, "--set tank.volume_l=0.2 --clear 10cm");
    assert!(number(&high, "jumps") < plain);
    assert_eq!(high["end"], "too-low");
    let least = high["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["counts"] == true);
    assert!(
        least
            .map(|row| number(row, "clear_m"))
            .fold(f64::INFINITY, f64::min)
            >= 0.1
    );
    // Of CO2 at the same pressure the tank holds more kilograms.
    let co2 = answer(&folder, "--set tank.volume_l=0.2 --set leg.gas=co2");
    let air = answer(&folder, "--set tank.volume_l=0.2");
    let ratio = number(&co2, "gas_kg") / number(&air, "gas_kg");
    // Its gas constant is the molar one over its molar mass.
    let constant = 8.314_462_618 / 0.044_009_5;
    assert!((ratio - 287.05 / constant).abs() < 1e-12, "{ratio}");
}

#[test]
fn a_plot_is_drawn_and_no_jump_is_a_no() {
    let folder = Folder::new("filling-plot");
    let drawn = run(&folder, "--set tank.volume_l=0.2 --plot filling.svg");
    assert_eq!(drawn.code, Some(0), "{}", drawn.err);
    let svg = std::fs::read_to_string(folder.path("filling.svg")).unwrap();
    for word in [
        "pressure above ambient (bar)",
        "apex of the wheel",
        "distance of all jumps",
    ] {
        assert!(svg.contains(word), "{word}");
    }
    let none = run(&folder, "--set tank.volume_l=0.2 --clear 5");
    assert_eq!(none.code, Some(1), "{}", none.err);
    assert!(
        none.out.contains("0 jumps") && none.out.contains("does not clear 5 m"),
        "{}",
        none.out
    );
}

#[test]
fn bad_input_is_named() {
    let folder = Folder::new("filling-bad");
    for (more, said) in [
        ("", "tank.volume: must be given, and finite"),
        (
            "--set tank.volume_l=inf",
            "tank.volume: must be given, and finite",
        ),
        (
            "--robot spring-hopper",
            "leg.kind: must be \"pneumatic\" or \"muscle\"",
        ),
        (
            "--set tank.volume_l=0",
            "tank.volume_l = 0: must be a finite number > 0",
        ),
        (
            "--set tank.volume_l=nan",
            "tank.volume_l = nan: must be a finite number > 0",
        ),
        (
            "--set tank.volume_l=1 --set leg.supply_pressure_absolute_pa=9e4",
            "leg.supply_pressure_absolute_pa",
        ),
        (
            "--set tank.volume_l=1 --set leg.tube.length_m=1 --set leg.tube.diameter_mm=0",
            "leg.tube.diameter_mm = 0: must be a finite number > 0",
        ),
        ("--set tank.volume_l=1 --pause -1", "--pause"),
        (
            "--set tank.volume_l=0.2 --valve-open 100",
            "at which the valve is shut",
        ),
        ("--set tank.volume_l=1 --clear nan", "--clear"),
    ] {
        let run = run(&folder, more);
        assert_eq!(run.code, Some(2), "{more}: {}", run.out);
        assert!(run.err.contains(said), "{more}: {}", run.err);
    }
}

/// Where a tank is not in the equations, it is not left out in silence.
#[test]
fn commands_that_have_no_tank_refuse_it() {
    let folder = Folder::new("filling-refused");
    let disturbed = [
        "run",
        "closed-loop",
        "--seconds",
        "1",
        "--disturb",
        "supply=80psi@0.1:0.2s",
        "--set",
        "tank.volume_l=2",
    ];
    let run = folder.run(&disturbed);
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert!(run.err.contains("of a robot without a tank"), "{}", run.err);
}
