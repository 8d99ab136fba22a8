//! What a diagnosis says of real data, in each of its forms.

use std::path::Path;

use crate::common::Folder;
use serde_json::Value;

/// A ball that was dropped.
pub(crate) fn ball(name: &str) -> String {
    let drops = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/reference/ball-drops");
    drops.join(name).display().to_string()
}

#[test]
fn light_balls_are_braked_by_the_air_and_heavy_ones_are_not_said_to_be() {
    let folder = Folder::new("balls");
    for name in [
        "tennis-ball",
        "orange-whiffle-ball",
        "whiffle-ball-1",
        "green-basketball",
    ] {
        let text = folder.done(&format!("diagnose {}", ball(name)), 1);
        assert!(text.starts_with("Found: air-drag"), "{name}: {text}");
    }
    // What is left of them is four times the noise, and smooth.
    for name in ["bowling-ball", "baseball"] {
        let text = folder.done(&format!("diagnose {}", ball(name)), 1);
        assert!(text.starts_with("Unknown: "), "{name}: {text}");
    }
}

#[test]
fn a_ball_is_braked_by_the_air() {
    let folder = Folder::new("diagnose-text");
    let text = folder.done(&format!("diagnose {}", ball("tennis-ball")), 1);
    assert!(
        text.starts_with("Found: air-drag (the air brakes the body)"),
        "{text}"
    );
    assert!(
        text.contains("drag_coefficient") && text.contains("flight") && text.contains("± "),
        "{text}"
    );
    assert!(text.contains("in about 1 % of cases"), "{text}");
    assert!(text.contains("\nWhat to do next\n"), "{text}");
}

/// Gravity or a wrong ruler would explain the fall as well; nobody believes in them.
#[test]
fn what_everybody_knows_leaves_the_air_alone() {
    let folder = Folder::new("diagnose-known");
    for name in ["tennis-ball", "green-basketball", "whiffle-ball-1"] {
        let text = folder.done(&format!("diagnose {} --format json", ball(name)), 1);
        let document: Value = serde_json::from_str(&text).unwrap();
        let causes = document["causes"].as_array().unwrap();
        let ids: Vec<&Value> = causes.iter().map(|cause| &cause["id"]).collect();
        assert_eq!(ids, ["air-drag", "unknown"], "{name}");
        let rivals = causes[0]["rivals"].as_array().unwrap();
        assert!(rivals.iter().all(|rival| rival == "unknown"), "{name}");
        if name == "green-basketball" {
            let against = causes[0]["contradicting"].as_array().unwrap();
            let ids: Vec<&str> = against.iter().map(|c| c["id"].as_str().unwrap()).collect();
            assert_eq!(ids, ["encoder-scale", "gravity"], "{name}");
            let away = &against[1]["deviations"][0]["standard_deviations_away"];
            assert!(away.as_f64().unwrap() > 50.0, "{name}");
        }
    }
}

/// A user who knows less gets the rival back, from a flag or from the folder.
#[test]
fn what_a_user_knows_takes_the_place_of_common_sense() {
    let folder = Folder::new("diagnose-told");
    let text = folder.done(
        &format!(
            "diagnose {} --known gravity=9.81±2",
            ball("green-basketball")
        ),
        1,
    );
    assert!(text.starts_with("Found: gravity"), "{text}");
    let own = |file: &str| std::fs::read_to_string(Path::new(&ball("green-basketball")).join(file));
    std::fs::create_dir(folder.path("data")).unwrap();
    for drop in ["drop-1.csv", "drop-2.csv"] {
        folder.write(&format!("data/{drop}"), own(drop).unwrap());
    }
    let stated = |known: &str| {
        let text = own("experiment.toml").unwrap();
        folder.write(
            "data/experiment.toml",
            format!("{text}\n[known]\n{known}\n"),
        );
    };
    let refused = || {
        let run = folder.run(&["diagnose", "data"]);
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""));
        run.err
    };
    stated("gravity_m_s2 = [9.81, 2]");
    let told = folder.done("diagnose data", 1);
    assert!(told.starts_with("Found: gravity"), "{told}");
    for (known, said) in [
        ("gravity_m_s2 = 9.81", "known.gravity_m_s2"),
        ("gravity_m_s2 = [9.81, 0]", "standard deviation, above 0"),
        (
            "gravity_m_s2 = [9.81, -0.02]",
            "standard deviation, above 0",
        ),
        ("gravity_m_s2 = [nan, 0.02]", "standard deviation, above 0"),
        ("gravity_m_s2 = [-9.81, 0.02]", "must be from 0.1 to 40"),
        ("gravty_m_s2 = [9.81, 0.02]", "the nearest is gravity_m_s2"),
        ("y_m.gaim = [1, 0.01]", "the nearest is y_m.gain"),
    ] {
        stated(known);
        let error = refused();
        assert!(error.contains(said), "{known}: {error}");
    }
    // Of another kind of experiment.
    stated("bore_m = [0.02, 1e-5]");
    let noted = folder.done("diagnose data", 1);
    assert!(noted.contains("known bore_m is not used"), "{noted}");
}

#[test]
fn a_document_has_the_documented_keys() {
    let folder = Folder::new("diagnose-json");
    let text = folder.done(
        &format!("diagnose {} --format json", ball("tennis-ball")),
        1,
    );
    let document: Value = serde_json::from_str(&text).unwrap();
    let cause = &document["causes"][0];
    assert_eq!(cause["id"], "air-drag");
    assert!(cause["rivals"].is_array() && cause["candidates"].is_array());
    assert!(cause["parameters"]["drag_coefficient"].as_f64().unwrap() > 0.0);
    assert!(
        cause["standard_errors"]["drag_coefficient"]
            .as_f64()
            .unwrap()
            > 0.0
    );
    let [low, high] = [0, 1].map(|k| {
        cause["intervals_95"]["drag_coefficient"][k]
            .as_f64()
            .unwrap()
    });
    let value = cause["parameters"]["drag_coefficient"].as_f64().unwrap();
    assert!(low < value && value < high, "{low} {value} {high}");
    let gain = &document["gain"]["y_m"];
    for key in [
        "rms_before",
        "rms_after",
        "noise",
        "ratio_low",
        "ratio_high",
    ] {
        assert!(gain[key].as_f64().unwrap() > 0.0, "{key}");
    }
    for when in ["before", "after"] {
        let residual = &document["residuals"][when][0];
        assert_eq!(
            (residual["channel"].as_str(), residual["phase"].as_str()),
            (Some("y_m"), Some("flight"))
        );
        let sigma = residual["rms"].as_f64().unwrap() / residual["rms_sigma"].as_f64().unwrap();
        // The noise of experiment.toml.
        assert!((sigma - 0.04).abs() < 1e-12, "{sigma}");
        for key in [
            "readings",
            "mean",
            "mean_sigma",
            "lag_1_correlation",
            "p_level",
            "p_whiteness",
            "p_runs",
        ] {
            assert!(residual[key].is_number(), "{key}");
        }
        assert!(residual["is_noise"].is_boolean() && residual["correlation_with"].is_object());
    }
    let tried = document["tried"].as_array().unwrap();
    assert!(
        tried
            .iter()
            .any(|c| c["id"] == "air-drag" && c["log_odds"].as_f64().unwrap() > 10.0)
    );
    assert!(document["noise"]["y_m"]["of_stated"].as_f64().unwrap() > 0.0);
    assert!(
        document
            .as_object()
            .unwrap()
            .contains_key("next_experiment")
    );
    assert_eq!(document["data"]["runs"], 2);
}

#[test]
fn a_page_needs_nothing_else() {
    let folder = Folder::new("diagnose-page");
    folder.write("page.html", "an older one");
    let printed = folder.done(
        &format!(
            "diagnose {} --report page.html --out told.txt",
            ball("tennis-ball")
        ),
        1,
    );
    assert_eq!(printed, "");
    // Nothing temporary is left.
    assert_eq!(folder.names(), ["page.html", "told.txt"]);
    let page = folder.read("page.html");
    assert!(page.starts_with("<!DOCTYPE html>") && page.ends_with("</html>\n"));
    let bare = page.replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
    for outside in [
        "http", "src=", "href=", "url(", "@import", "<script", "<link",
    ] {
        assert!(!bare.contains(outside), "{outside}");
    }
    assert!(!bare.contains("NaN"), "a number that is none");
    assert_eq!(page.matches("<svg").count(), page.matches("</svg>").count());
    for said in [
        "air-drag",
        "drag_coefficient",
        "drop-1.csv",
        "with the causes found",
        env!("CARGO_PKG_VERSION"),
    ] {
        assert!(page.contains(said), "{said}");
    }
}

#[test]
fn a_file_that_cannot_be_written_leaves_no_other() {
    let folder = Folder::new("diagnose-atomic");
    let ball = ball("tennis-ball");
    let run = folder.run(&[
        "diagnose",
        &ball,
        "--report",
        "page.html",
        "--out",
        "no/such/folder.txt",
    ]);
    assert_eq!(run.code, Some(2), "{}", run.err);
    assert!(folder.names().is_empty());
}

#[test]
fn bad_flags_are_refused() {
    let folder = Folder::new("diagnose-flags");
    let ball = ball("tennis-ball");
    for words in [
        vec!["diagnose"],
        vec!["diagnose", "no-such-folder"],
        vec!["diagnose", &ball, "--report", "page.pdf"],
        vec!["diagnose", &ball, "--most", "7"],
        vec!["diagnose", &ball, "--model-error", "-1"],
        vec!["diagnose", &ball, "--model-error", "nan"],
        vec!["diagnose", &ball, "--effect", "mass=3"],
        vec!["diagnose", &ball, "--kind", "hop"],
        vec!["diagnose", "--inject", "none", "--out", "new"],
        vec!["diagnose", &ball, "--extend", "nowhere/robot.toml"],
        vec!["diagnose", &ball, "--known", "body.mass_g=3300+/-10"],
        vec![
            "diagnose",
            &ball,
            "--known",
            "gravity=9.8±1",
            "--known",
            "gravity=9.6±1",
        ],
        vec!["diagnose", &ball, "--known", "gravity=9.81"],
        vec!["diagnose", &ball, "--known", "gravity=9.81±0"],
        vec!["diagnose", &ball, "--known", "gravity=9.81+-inf"],
        vec!["diagnose", &ball, "--known", "=9.81±1"],
        vec!["diagnose", &ball, "--known", "gravty=9.81±0.02"],
        vec![
            "diagnose",
            &ball,
            "--known",
            "mass=2±1",
            "--known",
            "gravity=-9.81±0.02",
        ],
        vec![
            "diagnose",
            &ball,
            "--report",
            "same.html",
            "--out",
            "same.html",
        ],
    ] {
        let run = folder.run(&words);
        assert_eq!(run.code, Some(2), "{words:?}");
        assert!(
            run.err.starts_with("error: ") && run.out.is_empty(),
            "{words:?}: {}",
            run.err
        );
    }
    assert!(folder.names().is_empty());
}
