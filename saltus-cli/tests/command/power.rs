//! What an experiment can tell before it is done.

use crate::common::{Folder, rows};
use serde_json::Value;

const JUMPS: &str = "kind = \"outcomes\"\nrobot = \"rats-planar\"\n[[jump]]\n\
                     approach_rate_rad_s = 4.5\nfiring_angle_rad = 0.05\nvalve_open_s = 0.08\n";

fn told(folder: &Folder, plan: &str, flags: &str) -> Value {
    std::fs::write(folder.path("plan.toml"), plan).unwrap();
    let line = format!("design plan.toml --format json {flags}");
    serde_json::from_str(&folder.done(&line, 0)).unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

/// Readings four times as many show an effect by twice as many standard deviations, and so does an
/// effect twice as large.
#[test]
fn what_is_seen_grows_with_the_readings_and_the_effect() {
    let folder = Folder::new("power-grows");
    let seen = |repeat: usize, drag: f64| {
        let plan = format!("{JUMPS}repeat = {repeat}\n");
        let json = told(
            &folder,
            &plan,
            &format!("--effect air-drag={drag} --model-error 0"),
        );
        assert_eq!(json["runs"], repeat);
        number(&json["effects"][0]["seen_by_sigmas"])
    };
    let once = seen(5, 0.01);
    assert!((seen(20, 0.01) / once - 2.0).abs() < 0.05);
    assert!((seen(5, 0.02) / once - 2.0).abs() < 0.05);
}

/// Gravity and the scale of the height do the same to a flight.
#[test]
fn rivals_are_named_before_the_experiment() {
    let folder = Folder::new("power-rivals");
    let json = told(&folder, "kind = \"flight\"\nruns = 6\n", "");
    let effects = json["effects"].as_array().unwrap();
    let gravity = effects.iter().rfind(|e| e["id"] == "gravity").unwrap();
    assert!((number(&gravity["seen_by_sigmas"]) - 12.0).abs() < 0.1);
    assert!(number(&gravity["named"]) > 0.95 && number(&gravity["alone"]) < 0.05);
    assert!(number(&gravity["others"]["encoder-scale"]) > 0.95);
    // A ruler known to a hundredth of what it would take is no rival.
    let known = told(
        &folder,
        "kind = \"flight\"\nruns = 6\n",
        "--effect gravity=9.85 --known y_m.gain=1±0.00003",
    );
    assert!(number(&known["effects"][0]["alone"]) > 0.95, "{known}");
}

#[test]
#[ignore = "nightly: 5 s"]
fn proposed_jumps_tell_more() {
    let folder = Folder::new("power-proposed");
    let effects = "--effect air-drag=0.02 --effect imbalance=0.002,1.57";
    let json = told(
        &folder,
        &format!("{JUMPS}repeat = 6\n"),
        &format!("{effects} --propose 6"),
    );
    let proposed = &json["proposed"];
    assert_eq!(proposed["jumps"].as_array().unwrap().len(), 6);
    let mean = |effects: &Value| {
        let all = effects.as_array().unwrap();
        all.iter().map(|e| number(&e["alone"])).sum::<f64>() / all.len() as f64
    };
    // Beyond the scatter of a mean of two shares of 300 experiments, twice.
    assert!(
        mean(&proposed["effects"]) > mean(&json["effects"]) + 0.05,
        "{json}"
    );
    let text = folder.done(&format!("design plan.toml {effects} --propose 6"), 0);
    assert!(text.contains("tell the effects apart best"), "{text}");
    let csv = folder.done(&format!("design plan.toml {effects} --format csv"), 0);
    let (header, rows) = rows(&csv);
    assert_eq!(header[0], "cause");
    // A row for each parameter.
    assert_eq!(rows.len(), 3, "{csv}");
}

#[test]
fn plans_that_are_none_are_refused() {
    let folder = Folder::new("power-refused");
    let refuses = |plan: &str, flags: &str, says: &[&str]| {
        std::fs::write(folder.path("plan.toml"), plan).unwrap();
        let line = format!("design plan.toml {flags}");
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{plan}: {run:?}");
        for word in says {
            assert!(run.err.contains(word), "{plan} {flags}: {}", run.err);
        }
    };
    refuses("", "", &["plan.toml", "kind"]);
    refuses("kind = \"leap\"", "", &["kind", "leap"]);
    refuses("kind = \"flight\"\nrun = 3", "", &["run"]);
    refuses("kind = \"flight\"\nruns = 0", "", &["runs", "0"]);
    refuses("kind = \"flight\"\nruns = 100000", "", &["runs"]);
    refuses("kind = \"outcomes\"\nrobot = \"nobody\"", "", &["nobody"]);
    refuses("kind = \"flight\"\n[noise]\ny_m = -1", "", &["noise", "-1"]);
    refuses(
        "kind = \"flight\"\n[[jump]]\napproach_rate_rad_s = 4",
        "",
        &["jump"],
    );
    refuses(&format!("{JUMPS}repeat = 0\n"), "", &["repeat"]);
    refuses(&format!("{JUMPS}repeat = 501\n"), "", &["repeat"]);
    refuses(&JUMPS.replace("0.08", "nan"), "", &["valve_open", "nan"]);
    refuses(
        &format!("{JUMPS}supply_pressure_gauge_psi = 80\n"),
        "",
        &["supply_pressure_gauge"],
    );
    refuses(JUMPS, "--effect air-drag", &["air-drag"]);
    refuses(JUMPS, "--effect wind=3", &["wind"]);
    refuses(JUMPS, "--effect air-drag=-3", &["air-drag", "-3"]);
    refuses("kind = \"flight\"", "--propose 4", &["--propose", "flight"]);
    refuses(JUMPS, "--propose 0", &["--propose"]);
}
