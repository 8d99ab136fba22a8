//! The evidence of an answer: written, computed again, compared.

use serde_json::{Value, json};

use crate::common::Folder;
use crate::diagnose::ball;

/// A folder with drops of a basket ball, `data`, and the evidence of their answer: `air-drag`, and
/// something unknown.
fn with_evidence(name: &str) -> (Folder, Value) {
    let folder = Folder::new(&format!("evidence-{name}"));
    std::fs::create_dir(folder.path("data")).unwrap();
    for entry in std::fs::read_dir(ball("green-basketball")).unwrap() {
        let path = entry.unwrap().path();
        let to = folder.path("data").join(path.file_name().unwrap());
        std::fs::copy(path, to).unwrap();
    }
    let line = "diagnose data --most 2 --known gravity=9.81±0.02 --evidence e.json";
    folder.done(line, 1);
    let evidence = std::fs::read_to_string(folder.path("e.json")).unwrap();
    (folder, serde_json::from_str(&evidence).unwrap())
}

/// What a check of `evidence` says that must not hold.
#[track_caller]
fn unheld(folder: &Folder, evidence: &Value) -> String {
    folder.write("other.json", evidence.to_string());
    folder.done("diagnose data --check other.json", 1)
}

/// Adds `by` to the odds of the `k`-th set.
fn add(evidence: &mut Value, k: usize, by: f64) {
    let odds = &mut evidence["sets"][k]["log_odds"];
    *odds = json!(odds.as_f64().unwrap() + by);
}

/// A change of evidence, and what is said of it.
type Changed = (fn(&mut Value), &'static str);

#[test]
fn evidence_holds_for_its_data_and_for_no_others() {
    let (folder, evidence) = with_evidence("data");
    assert_eq!(evidence["data"][0]["sha256"].as_object().unwrap().len(), 3);
    let document = folder.done("diagnose data --check e.json --format json", 0);
    let document: Value = serde_json::from_str(&document).unwrap();
    let sets = evidence["sets"].as_array().unwrap().len();
    let all = json!({ "count": sets, "agreeing": sets, "log_odds_differ_by": 0.0 });
    assert_eq!(
        (&document["holds"], &document["sets"]),
        (&json!(true), &all)
    );
    let path = folder.path("data/drop-2.csv");
    let mut bytes = std::fs::read(&path).unwrap();
    let last = bytes.iter().rposition(u8::is_ascii_digit).unwrap();
    bytes[last] ^= 1;
    std::fs::write(path, bytes).unwrap();
    let text = folder.done("diagnose data --check e.json", 1);
    assert!(
        text.contains("  data/drop-2.csv: SHA-256 ") && !text.contains("drop-1.csv"),
        "{text}"
    );
}

/// What another processor rounds otherwise is the same; what another diagnosis says is not.
#[test]
fn a_check_names_what_is_not_the_same() {
    let (folder, evidence) = with_evidence("changed");
    let mut near = evidence.clone();
    add(&mut near, 0, 0.04);
    near["saltus_version"] = json!("0.0.1");
    folder.write("near.json", near.to_string());
    let text = folder.done("diagnose data --check near.json", 0);
    assert!(
        text.contains("the greatest difference is 0.04 nats."),
        "{text}"
    );
    assert!(
        text.contains("note: the evidence is of Saltus 0.0.1"),
        "{text}"
    );
    let changes: [Changed; 7] = [
        (|it| add(it, 0, 0.06), "set air-drag: log_odds "),
        (|it| add(it, 1, 1.0), "set no cause: log_odds "),
        (
            |it| drop(it["sets"].as_array_mut().unwrap().remove(0)),
            "set air-drag: is not in the evidence",
        ),
        (
            |it| it["answer"]["causes"][0]["rivals"] = json!(["gravity"]),
            "rivals of air-drag: unknown here, gravity in the evidence",
        ),
        (
            |it| it["answer"]["causes"] = json!([]),
            "causes: air-drag here, none in the evidence",
        ),
        (
            |it| it["answer"]["causes"][0]["parameters"]["drag_coefficient"] = json!(0.125),
            "air-drag: drag_coefficient: 0.119",
        ),
        (|it| it["robot_sha256"] = json!("00"), "robot none here"),
    ];
    for (change, said) in changes {
        let mut other = evidence.clone();
        change(&mut other);
        let text = unheld(&folder, &other);
        assert!(text.contains(said), "{said}: {text}");
    }
}

#[test]
fn what_is_no_evidence_is_refused() {
    let (folder, evidence) = with_evidence("refused");
    let refused = |line: &str, said: &str| {
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!((run.code, run.out.as_str()), (Some(2), ""), "{line}");
        assert!(run.err.contains(said), "{said}: {}", run.err);
    };
    let changes: [Changed; 6] = [
        (
            |it| it["evidence_format"] = json!(2),
            "evidence_format = 2: must be 1",
        ),
        (|it| *it = json!([]), "evidence_format is missing"),
        (|it| it["set"] = json!(1), "unknown field `set`"),
        (
            |it| drop(it.as_object_mut().unwrap().remove("sets")),
            "missing field `sets`",
        ),
        (
            |it| it["options"]["most"] = json!(7),
            "options.most = 7: must be from 1 to 6",
        ),
        (
            |it| it["options"]["known"] = json!(["gravity"]),
            "options.known = gravity: must be NAME=VALUE±SD",
        ),
    ];
    for (change, said) in changes {
        let mut other = evidence.clone();
        change(&mut other);
        folder.write("other.json", other.to_string());
        refused("diagnose data --check other.json", said);
    }
    folder.write("other.json", &evidence.to_string()[..40]);
    refused(
        "diagnose data --check other.json",
        "other.json: EOF while parsing",
    );
    let check = "diagnose data --check e.json";
    refused(&format!("{check} --most 2"), "cannot be used with");
    refused(
        &format!("{check} --format csv"),
        "--format csv: must be text or json",
    );
    refused(
        &format!("{check} --robot rats-run"),
        "must be the robot of the evidence",
    );
    refused(
        "diagnose data data --check e.json",
        "evidence of as many folders as are given",
    );
}
