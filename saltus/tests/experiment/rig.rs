//! The table `[rig]`: what the operator believes of the machine.

use saltus::experiment::{Sort, read};

use crate::folder::Folder;

const ROWS: &str = "time_s,angle_rad\n0,0.5\n0.1,0.49\n0.2,0.46\n0.3,0.41\n0.4,0.34\n0.5,0.26\n\
                    0.6,0.17\n0.7,0.08\n0.8,-0.02\n0.9,-0.12\n1,-0.21\n";
const PART: &str = "[rig]\nmass_g = 700\ncentre_from_axle_m = 0.0448\n";

fn folder(name: &str, manifest: &str) -> Folder {
    let data = Folder::new(name);
    data.write("experiment.toml", manifest);
    data.write("a.csv", ROWS);
    data
}

#[test]
fn every_run_has_the_rig_among_its_settings() {
    let manifest =
        format!("kind = \"pendulum\"\nrobot = \"some-leg\"\n{PART}[[run]]\nfile = \"a.csv\"\n");
    let found = read(&folder("rig-part", &manifest).path("."), &|_| ()).unwrap();
    assert_eq!(found.experiment.kind, Sort::Pendulum);
    let settings = &found.experiment.runs[0].settings;
    assert_eq!(settings["mass_kg"], 0.7);
    assert_eq!(settings["centre_from_axle_m"], 0.0448);
    // What the rig describes is no robot, and a note says so.
    assert_eq!(found.robot, None);
    assert!(
        found.notes[0].contains("robot is not used"),
        "{:?}",
        found.notes
    );
}

#[test]
fn a_robot_swings_about_a_named_axis() {
    for (axis, value) in [("\"axle\"", 0.0), ("\"foot\"", -1.0), ("0.12", 0.12)] {
        let manifest = format!(
            "kind = \"pendulum\"\nrobot = \"rats-planar\"\n[[run]]\nfile = \"a.csv\"\naxis = {axis}\n"
        );
        let found = read(&folder("rig-robot", &manifest).path("."), &|_| ()).unwrap();
        assert_eq!(found.experiment.runs[0].settings["axis"], value);
        assert_eq!(found.robot.as_deref(), Some("rats-planar"));
    }
}

#[test]
fn what_is_wrong_is_named() {
    let run = "[[run]]\nfile = \"a.csv\"\n";
    let cases = [
        (
            format!("kind = \"pendulum\"\n{run}"),
            ": missing key rig: a table with mass_kg, centre_from_axle_m; or robot: a robot's name",
        ),
        (
            format!("kind = \"pendulum\"\n[rig]\nmass_kg = 1\n{run}"),
            ":2: missing key rig.centre_from_axle_m",
        ),
        (
            format!("kind = \"pendulum\"\n[rig]\nmass_kg = -1\ncentre_from_axle_m = 0.1\n{run}"),
            ":3: rig.mass_kg = -1: must be a mass > 0 and ≤ 1000 kg",
        ),
        (
            format!("kind = \"pendulum\"\n[rig]\nmas_kg = 1\n{run}"),
            ":3: unknown key rig.mas_kg; the nearest known key is rig.mass_kg",
        ),
        (
            format!("kind = \"slide\"\n[rig]\nmass_kg = 1\n{run}"),
            ":2: rig = [rig]: must be left out: the kind slide has none",
        ),
        (
            format!("kind = \"pendulum\"\nrobot = \"rats-planar\"\n{run}axis = \"toe\"\n"),
            ":5: run 1.axis = \"toe\": must be \"axle\", \"foot\" or a distance in m from the axle \
             > 0 and ≤ 100",
        ),
    ];
    for (manifest, expected) in cases {
        let data = folder("rig-wrong", &manifest);
        let error = read(&data.path("."), &|_| ()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}
