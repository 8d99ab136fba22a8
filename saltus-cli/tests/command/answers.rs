//! Answers of a diagnosis where data cannot tell, where the noise is misstated, and what it says to
//! do next.

use crate::common::Folder;
use serde_json::Value;

fn document(folder: &Folder, line: &str, code: i32) -> Value {
    serde_json::from_str(&folder.done(&format!("{line} --format json"), code)).unwrap()
}

/// Hides `inject`, which holds the machine still, and checks that it is among causes that are not
/// identifiable.
#[track_caller]
fn held(test: &str, inject: &str, id: &str, measure: &str) {
    let folder = Folder::new(test);
    folder.done(&format!("inject {inject} --out d"), 0);
    let text = folder.done("diagnose d", 1);
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(text.starts_with("Not identifiable: "), "{text}");
    assert!(
        text.contains(measure) && text.contains("at least"),
        "{text}"
    );
    let document = document(&folder, "diagnose d", 1);
    let [cause] = &document["causes"].as_array().unwrap()[..] else {
        panic!("{document}")
    };
    assert_eq!(cause["identifiable"], false);
    let rivals = cause["rivals"].as_array().unwrap();
    assert!(!rivals.is_empty(), "{cause}");
    let others = rivals
        .iter()
        .chain(cause["less_likely"].as_array().unwrap());
    assert!(
        std::iter::once(&cause["id"])
            .chain(others)
            .any(|found| found == id),
        "{cause}"
    );
    let steps = document["next_steps"].as_array().unwrap();
    assert!(
        steps
            .iter()
            .any(|step| step["what"].as_str().unwrap().contains(measure)),
        "{steps:?}"
    );
}

#[test]
fn a_mass_that_dry_friction_holds_tells_not_how_strong_it_is() {
    held(
        "answers-slide",
        "coulomb-friction=25 --kind slide",
        "coulomb-friction",
        "a larger force",
    );
}

#[test]
fn a_leg_that_does_not_extend_tells_not_what_holds_it() {
    held(
        "answers-bench",
        "coulomb-friction=200 --kind bench --runs 3",
        "coulomb-friction",
        "a higher supply pressure",
    );
}

#[test]
fn friction_that_lets_the_mass_slip_is_found() {
    let folder = Folder::new("answers-slips");
    folder.done("inject coulomb-friction=5 --kind slide --out d", 0);
    let document = document(&folder, "diagnose d", 1);
    let cause = &document["causes"][0];
    assert_eq!(
        (&cause["id"], &cause["identifiable"]),
        (&"coulomb-friction".into(), &true.into()),
        "{cause}"
    );
    let found = cause["parameters"]["coulomb_friction_n"].as_f64().unwrap();
    assert!((found - 5.0).abs() < 0.05, "{found}");
}

/// The data of `inject` with the noise of `column` stated as `stated`: what is said of it, and of
/// what is wrong.
#[track_caller]
fn misstated(folder: &Folder, inject: &str, column: &str, stated: &str) -> Value {
    folder.done(&format!("inject {inject} --out d"), 0);
    let manifest = folder.read("d/experiment.toml");
    let line = |line: &str| {
        if line.starts_with(&format!("{column} = ")) {
            format!("{column} = {stated}")
        } else {
            line.to_owned()
        }
    };
    folder.write(
        "d/experiment.toml",
        manifest.lines().map(line).collect::<Vec<_>>().join("\n"),
    );
    let text = folder.done("diagnose d --most 1", 1);
    assert!(
        text.contains(&format!("The stated noise of {column}")),
        "{text}"
    );
    document(folder, "diagnose d --most 1", 1)
}

#[test]
#[ignore = "nightly: 4 s"]
fn noise_that_is_stated_far_too_large_hides_nothing() {
    for (k, (inject, id)) in [
        (
            "coulomb-friction=50 --kind bench --runs 3",
            "coulomb-friction",
        ),
        ("air-drag=0.05 --kind flight", "air-drag"),
        ("viscous-friction=20 --kind stroke", "viscous-friction"),
        ("coulomb-friction=1 --kind slide", "coulomb-friction"),
    ]
    .into_iter()
    .enumerate()
    {
        let folder = Folder::new(&format!("answers-noise-{k}"));
        folder.done(&format!("inject {inject} --out probe"), 0);
        let manifest = folder.read("probe/experiment.toml");
        // Every column in turn.
        let noise = manifest.split("[noise]\n").nth(1).unwrap();
        for line in noise.lines().take_while(|line| line.contains(" = ")) {
            let column = line.split(" = ").next().unwrap();
            let stated: f64 = line.split(" = ").nth(1).unwrap().parse().unwrap();
            std::fs::remove_dir_all(folder.path("d")).ok();
            let told = misstated(&folder, inject, column, &format!("{:?}", 1e5 * stated));
            let cause = &told["causes"][0];
            let named = std::iter::once(&cause["id"]).chain(cause["rivals"].as_array().unwrap());
            assert!(
                named.into_iter().any(|found| found == id),
                "{inject} {column}: {cause}"
            );
            let wrong = &told["misstated_noise"][0];
            assert_eq!(wrong["column"], *column);
            // Up to third differences that the motion has too.
            let seen = wrong["seen"].as_f64().unwrap();
            assert!(
                seen > 0.5 * stated && seen < 20.0 * stated,
                "{inject} {column}: {seen} {stated}"
            );
        }
    }
}

#[test]
fn noise_that_is_stated_far_too_small_is_said() {
    let folder = Folder::new("answers-small");
    let told = misstated(
        &folder,
        "coulomb-friction=25 --kind bench --runs 3",
        "position_m",
        "1e-9",
    );
    assert_eq!(told["causes"][0]["id"], "coulomb-friction");
    let wrong = &told["misstated_noise"][0];
    assert!(
        (wrong["seen"].as_f64().unwrap() / 1e-4 - 1.0).abs() < 0.2,
        "{wrong}"
    );
}

#[test]
fn noise_that_is_right_is_not_said_to_be_wrong() {
    let folder = Folder::new("answers-right");
    for kind in [
        "bench --runs 3",
        "flight",
        "slide",
        "stroke",
        "vessel",
        "hop --runs 3",
        "outcomes --runs 20",
    ] {
        let name = kind.split(' ').next().unwrap();
        folder.done(&format!("inject --kind {kind} --out {name}"), 0);
        let told = document(&folder, &format!("diagnose {name} --most 1"), 0);
        assert_eq!(told["misstated_noise"], Value::Array(Vec::new()), "{kind}");
    }
}

#[test]
fn a_diagnosis_ends_with_what_to_do() {
    let folder = Folder::new("answers-steps");
    folder.done(
        "inject coulomb-friction=25 --kind bench --runs 3 --out my-data",
        0,
    );
    let text = folder.done("diagnose my-data --most 1 --report page.html", 1);
    let (_, steps) = text.split_once("What to do next\n").unwrap();
    assert!(
        steps.contains("     saltus diagnose my-data --extend corrected.toml\n"),
        "{steps}"
    );
    assert!(
        steps.contains("saltus table ") && steps.contains("--robot corrected.toml"),
        "{steps}"
    );
    let page = folder.read("page.html");
    assert!(
        page.contains("What to do next")
            && page.contains("saltus diagnose my-data --extend corrected.toml")
    );
    // The command does what it says.
    folder.done("diagnose my-data --most 1 --extend corrected.toml", 1);
    folder.done("table --omega 5 --distance 0.6 --robot corrected.toml", 0);
}

#[test]
fn what_the_planner_leaves_out_is_named() {
    let folder = Folder::new("answers-planner");
    folder.done("inject axle-friction=0.3 --kind jump --runs 2 --out d", 0);
    let text = folder.done("diagnose d --most 1 --extend r.toml", 1);
    assert!(
        text.contains("the planner has no term for body.axle_friction_n_m"),
        "{text}"
    );
    let (_, steps) = text.split_once("What to do next\n").unwrap();
    assert!(
        steps.contains("saltus verify COURSE.toml --plant r.toml"),
        "{steps}"
    );
    let run = folder.run(&[
        "table",
        "--omega",
        "5",
        "--distance",
        "0.6",
        "--robot",
        "r.toml",
    ]);
    assert!(
        run.err.contains("leaves out body.axle_friction_n_m"),
        "{}",
        run.err
    );
}

#[test]
fn numbers_are_for_people() {
    let folder = Folder::new("answers-numbers");
    folder.done("inject --kind flight --out d", 0);
    for text in [
        folder.done("diagnose d", 0),
        folder.done("diagnose d --report page.html", 0),
        folder.read("page.html"),
    ] {
        assert!(
            !text.contains("NaN")
                && !text.contains(" inf")
                && !text.contains("-0 ")
                && !text.contains("e-1"),
            "{text}"
        );
    }
}

/// A printed chamber that leaks: no single opening describes how its pressure falls.
#[test]
#[ignore = "nightly: 9 s"]
fn what_a_cause_leaves_of_a_real_chamber_is_said() {
    let folder = Folder::new("answers-left");
    let chambers = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/reference/air-chambers"
    );
    let text = folder.done(&format!("diagnose {chambers}"), 1);
    assert!(
        text.contains("What is left in ultimaker-020.pressure is not noise"),
        "{text}"
    );
    let document = document(&folder, &format!("diagnose {chambers}"), 1);
    let [leak, unknown] = &document["causes"].as_array().unwrap()[..] else {
        panic!("{document}");
    };
    assert_eq!(leak["id"], "chamber-leak");
    assert_eq!(unknown["id"], "unknown");
    assert_eq!(unknown["channel"], "ultimaker-020.pressure_pa");
    assert!(unknown["rms"].as_f64().unwrap() > 5e3, "{unknown}");
}
