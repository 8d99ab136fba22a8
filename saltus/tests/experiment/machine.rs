//! The file that describes a machine.

use saltus::experiment::{Sort, read, write};
use saltus_diagnosis::kinds;
use saltus_diagnosis::mechanism::{Inertia, Law, Mechanism, Shows, Side, Way};

use crate::folder::Folder;

const ROWS: &str = "time_s,hip_rad,foot_y_m,hip_nm\n0,0.5,0.1,0\n0.1,0.49,0.2,0\n0.2,0.46,0.1,0\n\
                    0.3,0.41,0.2,0\n0.4,0.34,0.1,0\n0.5,0.26,0.2,1\n0.6,0.17,0.1,1\n\
                    0.7,0.08,0.2,1\n0.8,-0.02,0.1,1\n0.9,-0.12,0.2,1\n1,-0.21,0.1,0\n";
const MANIFEST: &str =
    "kind = \"machine\"\n[rig]\nchain = \"leg.toml\"\n[[run]]\nfile = \"a.csv\"\n";

/// Every key of a description: a slider, and a leg on it.
const LEG: &str = r#"gravity_m_s2 = 9.8
[[link]]
name = "leg"
parent = "slider"
joint = "turns"
joint_name = "hip"
positive = "back"
at_mm = [100, 0]
angle_deg = 180
mass_g = 700
centre_mm = [0, 45]
inertia_kg_m2 = 3e-3
coulomb_friction_n_m = 0.01
viscous_friction_n_m_s_per_rad = 0.002
[[link]]
name = "slider"
parent = "ground"
joint = "slides"
along = [3, 4]
mass_kg = 0
coulomb_friction_n = 1
viscous_friction_n_s_per_m = 2
counterweight_kg = 1.5
counterweight_at_m = [0, 0.2]
[[spring]]
joint = "leg"
stiffness_n_m_per_rad = 2
from_deg = 90
acts = "above"
[[spring]]
joint = "slider"
at_mm = [0, 10, 30]
force_n = [5, 0, -20]
[[drive]]
column = "hip_nm"
joint = "leg"
[[measured]]
column = "hip_rad"
link = "leg"
shows = "joint"
[[measured]]
column = "foot_y_m"
link = "leg"
shows = "y"
at_m = [0, 0.28]
"#;

fn folder(name: &str, leg: &str) -> Folder {
    let data = Folder::new(name);
    data.write("experiment.toml", MANIFEST);
    data.write("leg.toml", leg);
    data.write("a.csv", ROWS);
    data
}

fn described(name: &str, leg: &str) -> Mechanism {
    let found = read(&folder(name, leg).path("."), &|_| ()).unwrap();
    assert_eq!((found.experiment.kind, found.robot), (Sort::Machine, None));
    found.experiment.mechanism.unwrap()
}

#[test]
fn every_key_is_read() {
    let machine = described("machine-keys", LEG);
    assert_eq!((machine.name.as_str(), machine.gravity), ("leg.toml", 9.8));
    // Each link comes after the one that carries it.
    let [slider, leg] = &machine.links[..] else {
        panic!("{machine:?}")
    };
    assert_eq!(
        (slider.name.as_str(), slider.joint.parent),
        ("slider", None)
    );
    assert_eq!(slider.joint.way, Way::Slides([0.6, 0.8]));
    assert_eq!((slider.joint.friction, slider.joint.damping), (1.0, 2.0));
    let weight = slider.counterweight.as_ref().unwrap();
    assert_eq!((weight.mass, weight.at), (1.5, [0.0, 0.2]));
    assert_eq!((leg.name.as_str(), leg.joint.name.as_str()), ("leg", "hip"));
    assert_eq!(
        (leg.joint.parent, leg.joint.way),
        (Some(0), Way::Turns { back: true })
    );
    assert_eq!(
        (leg.joint.at, leg.joint.angle),
        ([0.1, 0.0], std::f64::consts::PI)
    );
    assert_eq!((leg.mass, leg.center), (0.7, [0.0, 0.045]));
    assert_eq!(leg.inertia, Inertia::Center(3e-3));
    assert_eq!((leg.joint.friction, leg.joint.damping), (0.01, 0.002));
    let law = Law::Linear {
        stiffness: 2.0,
        from: std::f64::consts::FRAC_PI_2,
        side: Side::Above,
    };
    assert_eq!(
        (machine.springs[0].joint, &machine.springs[0].law),
        (1, &law)
    );
    let law = Law::Table(vec![[0.0, 5.0], [0.01, 0.0], [0.03, -20.0]]);
    assert_eq!(
        (machine.springs[1].joint, &machine.springs[1].law),
        (0, &law)
    );
    assert_eq!(
        (machine.drives[0].column.as_str(), machine.drives[0].joint),
        ("hip_nm", 1)
    );
    let shows = Shows::Place {
        link: 1,
        at: [0.0, 0.28],
        axis: 1,
    };
    assert_eq!(
        (machine.gauges[0].shows, machine.gauges[1].shows),
        (Shows::Coordinate(1), shows)
    );
}

#[test]
fn what_is_written_is_read_again() {
    let found = read(&folder("machine-from", LEG).path("."), &|_| ()).unwrap();
    let copy = Folder::new("machine-to");
    write(&copy.path("data"), &found.experiment, None).unwrap();
    let again = read(&copy.path("data"), &|_| ()).unwrap();
    assert_eq!(again.experiment, found.experiment);
}

/// The answer is that of the data and of the machine.
#[test]
fn another_machine_has_another_hash() {
    let hash = |name, leg: &str| read(&folder(name, leg).path("."), &|_| ()).unwrap().hash;
    let same = hash("machine-hash-a", LEG);
    assert_eq!(same, hash("machine-hash-b", LEG));
    assert_ne!(
        same,
        hash(
            "machine-hash-c",
            &LEG.replace("mass_g = 700", "mass_g = 701")
        )
    );
}

/// [`LEG`] with one thing of it changed.
fn change(from: &str, to: &str) -> String {
    assert!(LEG.contains(from), "{from}");
    LEG.replacen(from, to, 1)
}

/// That each description is refused in the words beside it.
fn assert_refused(name: &str, cases: impl IntoIterator<Item = (String, &'static str)>) {
    for (leg, expected) in cases {
        let data = folder(name, &leg);
        let error = read(&data.path("."), &|_| ()).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

#[test]
fn links_that_are_no_chain_are_named() {
    let link = |k: usize, parent: &str| {
        format!(
            "[[link]]\nname = \"l{k}\"\nparent = \"{parent}\"\njoint = \"turns\"\nmass_kg = 1\n"
        )
    };
    let many: String = (0..13).map(|k| link(k, "ground")).collect();
    let round = link(1, "l2") + &link(2, "l1") + &link(0, "ground");
    let nowhere = link(1, "l2") + &link(2, "l1");
    assert_refused(
        "machine-no-chain",
        [
            (
                change("parent = \"slider\"", "parent = \"slidr\""),
                "leg.toml:4: link 1.parent = \"slidr\": must be the link that carries it, or the ground: \
             one of ground, slider",
            ),
            (
                round,
                "leg.toml:1: link 1.parent = \"l2\": must be a link that does not hang on this one: l1 on l2 on l1 goes round in a circle",
            ),
            (nowhere, "leg.toml: no link hangs on the ground"),
            (many, ": [[link]] = 13 tables: must be at most 12 tables"),
            (
                change("mass_g = 700", ""),
                "leg.toml:2: missing key link 1.mass_kg",
            ),
            (
                change("mass_g = 700", "mass_g = 0"),
                "leg.toml:2: mass_kg of link \"leg\" = 0: must be above 0, as it carries no link",
            ),
            (
                change("mass_g = 700", "mass_g = -1"),
                "leg.toml:10: link 1.mass_g = -1: must be a mass ≥ 0",
            ),
        ],
    );
}

#[test]
fn what_a_description_says_wrong_is_named() {
    assert_refused(
        "machine-wrong",
        [
            (
                change("joint = \"leg\"\nstiffness", "joint = \"knee\"\nstiffness"),
                "spring 1.joint = \"knee\": must be",
            ),
            (
                change("[0, 10, 30]", "[0, 30, 10]"),
                "leg.toml:30: at of the spring in slider = [0.0, 0.03, 0.01] with 3 of force: must be two \
             places at least, which rise, with a number for each",
            ),
            (
                change("name = \"slider\"", "name = \"leg\""),
                "leg.toml:16: link 2.name = \"leg\": must be a name in quotes that no other link has",
            ),
            (
                change("joint = \"turns\"", "joint = \"hinge\""),
                "leg.toml:5: link 1.joint = \"hinge\": must be \"turns\" or \"slides\"",
            ),
            (change("along = [3, 4]", ""), "missing key link 2.along"),
            (
                change("centre_mm = [0, 45]", "centre_mm = 45"),
                "leg.toml:11: link 1.centre_mm = 45: must be a list of two numbers",
            ),
            (
                change("column = \"hip_nm\"", "column = \"hip_volt\""),
                ": drive 1.column = \"hip_volt\": must be the name of a column in SI, which ends with _nm",
            ),
            (
                change("shows = \"joint\"", "shows = \"rate\""),
                ": measured 1.shows = \"rate\": must be \"joint\", \"angle\", \"x\" or \"y\"",
            ),
            (
                change("coulomb_friction_n_m", "coulomb_friction_nm"),
                ": unknown key link 1.coulomb_friction_nm; the nearest known key is \
             link 1.coulomb_friction_n_m",
            ),
            (
                change("[[measured]]", "[[mesured]]"),
                ": unknown key mesured; the nearest known key is measured",
            ),
        ],
    );
}

#[test]
fn a_machine_needs_its_file_and_its_columns() {
    let data = folder("machine-file", LEG);
    data.write(
        "experiment.toml",
        MANIFEST.replace("leg.toml", "../leg.toml"),
    );
    let error = read(&data.path("."), &|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("rig.chain = \"../leg.toml\": must be the name of a file in this folder"),
        "{error}"
    );
    data.write("experiment.toml", MANIFEST.replace("leg.toml", "arm.toml"));
    let error = read(&data.path("."), &|_| ()).unwrap_err().to_string();
    assert!(error.contains("arm.toml"), "{error}");
    data.write(
        "experiment.toml",
        MANIFEST.replace("[rig]\nchain = \"leg.toml\"\n", ""),
    );
    let error = read(&data.path("."), &|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("missing key rig: a table [rig] with chain"),
        "{error}"
    );
    let other = folder("machine-column", &LEG.replace("foot_y_m", "toe_y_m"));
    let found = read(&other.path("."), &|_| ()).unwrap();
    let error = kinds::build(&found.experiment, None)
        .err()
        .unwrap()
        .to_string();
    assert!(
        error.contains("column toe_y_m is missing or empty in the runs: leg.toml names it"),
        "{error}"
    );
}

/// A real leg (tests/reference/compass-leg): both frictions of its joint, and the inertia that nobody
/// states, are near to those published.
#[test]
fn a_leg_that_was_measured_has_its_published_friction() {
    let data = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/reference/compass-leg"
    );
    let found = read(std::path::Path::new(data), &|_| ()).unwrap();
    let kind = kinds::build(&found.experiment, None).unwrap();
    let of = |id: &str| {
        kind.causes()
            .iter()
            .position(|cause| cause.id == id)
            .unwrap()
    };
    let causes = [of("coulomb-friction"), of("viscous-friction")];
    let told = saltus_diagnosis::estimate(kind.as_ref(), &causes).unwrap();
    // What the fit leaves is far more than the encoder's counts, and standard errors are too small.
    for (own, published) in told.parameters.iter().zip([5.45e-3, 1.40e-3]) {
        let apart = (own.value / published - 1.0).abs();
        assert!(apart < 0.2, "{own:?} {published}");
    }
    let about_hip = told.after.terms.get(0, 0) + 0.7 * 0.0448 * 0.0448;
    assert!((about_hip / 4.32e-3 - 1.0).abs() < 0.02, "{about_hip}");
    // 1°; without friction 14°.
    let left = &told.residuals[0];
    assert!(
        left.after.to_degrees() < 1.5 && left.before > 0.2,
        "{left:?}"
    );
}
