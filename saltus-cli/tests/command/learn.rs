//! `saltus learn`: what it answers, goes on from and refuses.

use serde_json::Value;

use crate::common::{Folder, rows};

/// A task that is quick.
const QUICK: &str = "learn run-zone --seeds 3 --episodes 4";

fn json(text: &str) -> Value {
    serde_json::from_str(text).expect("JSON")
}

#[test]
fn the_answer_is_the_same_on_any_number_of_threads() {
    let folder = Folder::new("learn-threads");
    let on = |threads: u32| folder.done(&format!("{QUICK} --format json --threads {threads}"), 0);
    let one = on(1);
    assert_eq!(one, on(2));
    let answer = json(&one);
    assert_eq!(answer["rows"].as_array().map(Vec::len), Some(3));
    assert_eq!(answer["curve"].as_array().map(Vec::len), Some(4));
    let learnt = &answer["score"]["learnt"];
    let value = learnt["mean_of_middle_half"].as_f64().unwrap();
    let [low, high] = [0, 1].map(|k| learnt["interval_95"][k].as_f64().unwrap());
    assert!(low <= value && value <= high);
}

#[test]
fn learning_is_resumed_without_loss() {
    let folder = Folder::new("learn-resumed");
    folder.done(&format!("{QUICK} --out whole.json"), 0);
    folder.done("learn run-zone --seeds 3 --episodes 2 --out part.json", 0);
    folder.done(&format!("{QUICK} --resume part.json --out part.json"), 0);
    assert_eq!(folder.read("whole.json"), folder.read("part.json"));
}

#[test]
fn a_row_tells_of_each_seed() {
    let folder = Folder::new("learn-rows");
    let (header, rows) = rows(&folder.done(
        "learn run-legs --seeds 2 --seed 9 --episodes 2 --steps 50 --format csv",
        0,
    ));
    assert_eq!(header[..3], ["seed", "episodes", "reward"]);
    assert_eq!([&rows[0][0], &rows[1][0], &rows[0][1]], ["9", "10", "2"]);
    // It rocks on its two legs: a robot that learnt nothing is an answer.
    assert_eq!(rows[0][5], "");
    let text = folder.done(
        "learn climb --seeds 2 --episodes 1 --steps 20 --plot climb.svg",
        0,
    );
    assert!(text.contains("reach the goal"), "{text}");
    assert!(folder.read("climb.svg").contains("travel in the episode"));
}

#[test]
fn bad_input_is_named() {
    let folder = Folder::new("learn-bad");
    folder.done(&format!("{QUICK} --out policy.json"), 0);
    let whole = folder.read("policy.json");
    folder.write("short.json", &whole[..whole.len() / 2]);
    folder.write(
        "changed.json",
        whole.replacen("\"gamma\": 0.3", "\"gamma\": 0.4", 1),
    );
    folder.write("empty.json", "{}");
    for (line, said) in [
        ("learn", "<TASK>"),
        ("learn jump", "run-legs"),
        ("learn run-zone --alpha 1.1", "from 0 to 1"),
        ("learn run-zone --epsilon nan", "from 0 to 1"),
        ("learn run-zone --gamma -0.1", "from 0 to 1"),
        ("learn run-zone --episodes 0", "--episodes"),
        ("learn run-zone --seeds 0", "--seeds"),
        ("learn run-zone --steps 0", "--steps"),
        ("learn run-zone --reward rate", "TERM=COEFFICIENT"),
        ("learn run-zone --reward pace=1", "threshold:RATE"),
        ("learn run-zone --reward rate=nan", "from -1e9 to 1e9"),
        ("learn run-zone --algorithm ppo", "q-lambda"),
        ("learn run-zone --robot spring-hopper --draw", "pneumatic"),
        (
            "learn run-zone --out no/policy.json",
            "its folder is not there",
        ),
        ("learn run-zone --resume none.json", "none.json"),
        ("learn run-zone --resume empty.json", "checksum: is missing"),
        (
            "learn run-zone --seeds 3 --resume short.json",
            "short.json: JSON",
        ),
        (
            "learn run-zone --seeds 3 --resume changed.json",
            "damaged or changed",
        ),
        (
            "learn run-zone --resume policy.json",
            "seeds = 3: must be 30",
        ),
        (
            "learn run-zone --seeds 3 --seed 2 --resume policy.json",
            "seed = 1: must be 2",
        ),
        (
            "learn run-zone --seeds 3 --alpha 0.5 --resume policy.json",
            "alpha = 0.8: must be 0.5",
        ),
        ("learn run-legs --seeds 3 --resume policy.json", "must be"),
        (
            "learn run-zone --seeds 3 --set body.mass_kg=3 --resume policy.json",
            "robot_toml",
        ),
    ] {
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        assert!(run.err.contains(said), "{line}: {}", run.err);
        assert!(run.out.is_empty());
    }
}
