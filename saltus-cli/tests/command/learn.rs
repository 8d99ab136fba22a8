//! `saltus learn`: what it answers, goes on from and refuses.

use serde_json::Value;

use crate::ball::recorded;
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
    // Settings and seeds are those of the file.
    let more = "learn run-zone --episodes 4 --resume part.json --out part.json";
    folder.done(more, 0);
    assert_eq!(folder.read("whole.json"), folder.read("part.json"));
}

#[test]
fn settings_of_ones_own_are_resumed_without_loss() {
    let folder = Folder::new("learn-resumed-settings");
    for (name, how, few) in [
        ("strides", "run-stride --algorithm q-lambda --seeds 2", 4),
        (
            "disturbed",
            "run-zone --seeds 1 --disturb torque=-5@0.5:0.7s --disturb friction=0.5@0.2:0.9m --draw",
            3,
        ),
        (
            "states",
            "run-zone --state wheel_rate=-5:20:7 --reward travel=1 --seeds 2",
            2,
        ),
    ] {
        let part = format!("{name}.json");
        let task = how.split(' ').next().unwrap();
        folder.done(&format!("learn {how} --episodes 9 --out whole.json"), 0);
        folder.done(&format!("learn {how} --episodes {few} --out {part}"), 0);
        folder.done(
            &format!("learn {task} --episodes 9 --resume {part} --out {part}"),
            0,
        );
        assert_eq!(folder.read("whole.json"), folder.read(&part), "{name}");
    }
}

#[test]
fn firing_angles_are_learnt() {
    let folder = Folder::new("learn-strides");
    let answer = json(&folder.done("learn run-stride --seeds 3 --episodes 150 --format json", 0));
    assert_eq!(answer["algorithm"], "q");
    // The least time known is 1.376 s.
    let time = answer["time_to_the_goal_s"]["mean_of_middle_half"]
        .as_f64()
        .unwrap();
    assert!((1.37..1.7).contains(&time), "{time}");
}

/// Rows, telemetry, recording and page say in each cycle what the valves do that a policy holds open.
#[test]
fn valves_that_a_policy_holds_are_open_in_every_log() {
    let folder = Folder::new("learn-valves");
    folder.done(&format!("{QUICK} --out zone.json"), 0);
    let line = "run policy zone.json --seconds 2 --out rows.csv --telemetry logs --mcap run.mcap";
    folder.run(&line.split(' ').collect::<Vec<_>>());
    let (header, cycles) = rows(&folder.read("rows.csv"));
    let (measured, logged) = rows(&folder.read("logs/run.csv"));
    let at = |header: &[String], name: &str| header.iter().position(|it| it == name).unwrap();
    let bytes = std::fs::read(folder.path("run.mcap")).unwrap();
    let topics: Vec<String> = (0..5)
        .map(|leg| format!("/leg.valve_open[{leg}]"))
        .collect();
    let recording = recorded(&bytes, &topics);
    let mut longest = 0;
    for (leg, topic) in topics.iter().enumerate() {
        let open = at(&header, &format!("valve_open_{leg}_s"));
        let valve = at(&measured, &format!("valve_{}", leg + 1));
        let open: Vec<bool> = cycles.iter().map(|row| row[open] != "0").collect();
        let valve: Vec<bool> = logged.iter().map(|row| row[valve] == "1").collect();
        let topic: Vec<bool> = recording[topic].iter().map(|x| *x == 1.0).collect();
        assert!(open == valve && open == topic, "leg {leg}");
        let held = open.split(|is_open| !is_open).map(<[bool]>::len);
        longest = held.fold(longest, usize::max);
    }
    // A decision is one of 5 cycles, and a leg is pushed for longer than that.
    assert!(longest > 5, "{longest} cycles");
    let (fired, time) = (at(&header, "fired_leg"), at(&header, "valve_open_s"));
    let mut of_firings = cycles.iter().filter(|row| !row[fired].is_empty());
    assert!(of_firings.all(|row| row[time].is_empty()));
}

#[test]
fn what_was_learnt_runs_again() {
    let folder = Folder::new("learn-run");
    let learnt = folder.done(
        "learn run-stride --seeds 2 --episodes 150 --out strides.json",
        0,
    );
    assert!(learnt.is_empty(), "{learnt}");
    let answer = json(&folder.read("strides.json"));
    let best = answer["best_seed"].as_u64().unwrap();
    let rows = answer["rows"].as_array().unwrap();
    let row = rows
        .iter()
        .find(|row| row["seed"].as_u64() == Some(best))
        .unwrap();
    let learnt = row["arrived_s"].as_f64().unwrap();
    let ran = json(&folder.done("run policy strides.json --seconds 2 --format json", 0));
    let time = ran["time_to_1_6_m_s"].as_f64().unwrap();
    // Noise is other noise.
    assert!((time / learnt - 1.0).abs() < 0.05, "{time} {learnt}");

    folder.done("learn run-zone --seeds 2 --episodes 4 --out zone.json", 0);
    let text = folder.done("run policy zone.json --seconds 1 --animate run.html", 0);
    assert!(
        text.contains("run-zone by sarsa-lambda, as seed "),
        "{text}"
    );
    assert!(folder.read("run.html").contains("run-zone by sarsa-lambda"));
    let disturbed =
        "learn run-zone --seeds 1 --episodes 2 --disturb slope=2@0:1s --out tilted.json";
    folder.done(disturbed, 0);
    let tilted = json(&folder.read("tilted.json"))["policy"]["disturbances"][0].clone();
    assert_eq!(
        (&tilted["what"], &tilted["to_s"]),
        (&"slope_rad".into(), &1.0.into())
    );
    folder.done("run policy tilted.json --seconds 0.5", 0);
    let drawn = folder.done("run policy strides.json --seconds 2 --robots 3", 0);
    assert!(drawn.contains("3 drawn robots"), "{drawn}");
    let heavier = folder.done(
        "run policy strides.json --set body.mass_kg=3 --seconds 2",
        0,
    );
    assert!(heavier.contains("rats-run: run-stride by q"), "{heavier}");
}

#[test]
fn a_learnt_table_is_exported() {
    let folder = Folder::new("learn-export");
    folder.done("learn run-zone --seeds 2 --episodes 6 --out zone.json", 0);
    let about = folder.done("export policy zone.json --out c --real double", 0);
    assert!(
        about.contains("wheel_angle (rad), wheel_rate (rad/s)"),
        "{about}"
    );
    assert!(about.contains("Asked each 5 ms"), "{about}");
    let header = folder.read("c/saltus_policy.h");
    assert!(header.contains("saltus_policy_choices[961]") && header.contains("typedef double"));
    folder.done(
        "learn run-stride --algorithm q --seeds 1 --episodes 3 --out q.json",
        0,
    );
    folder.done("export policy q.json --out strides", 0);
    assert!(
        folder
            .read("strides/saltus_policy.h")
            .contains("saltus_policy_firings[18][2]")
    );
    // The choices in the file are those of the values: where nothing was learnt, the first.
    let policy = json(&folder.read("zone.json"))["policy"].clone();
    let best = json(&folder.read("zone.json"))["best_seed"].clone();
    let tables = policy["tables"].as_array().unwrap();
    let table = tables.iter().find(|table| table["seed"] == best).unwrap();
    let mut values = vec![0.0; 961 * 2];
    for pair in table["values"].as_array().unwrap() {
        let place = usize::try_from(pair[0].as_u64().unwrap()).unwrap();
        values[place] = pair[1].as_f64().unwrap();
    }
    let begin = header
        .split("saltus_policy_choices[961] = {")
        .nth(1)
        .unwrap();
    let listed = begin.split('}').next().unwrap();
    let choices: Vec<&str> = listed
        .split(',')
        .map(str::trim)
        .filter(|it| !it.is_empty())
        .collect();
    assert_eq!(choices.len(), 961);
    for (pair, choice) in values.chunks(2).zip(choices) {
        assert_eq!(choice, if pair[1] > pair[0] { "1" } else { "0" });
    }
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

/// What is refused, and what is said of it.
const REFUSED: &[(&str, &str)] = &[
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
    (
        "learn run-zone --disturb wind=3@0:1s",
        "slope, force, torque",
    ),
    (
        "learn run-zone --state pace=0:1:2",
        "wheel_angle, wheel_rate",
    ),
    (
        "learn run-zone --state wheel_rate=0:1",
        "NAME=FROM:TO:COUNT",
    ),
    ("learn run-zone --state wheel_rate=1:0:5", "above 1"),
    ("learn run-zone --state wheel_rate=0:1:0", "from 1 to 65535"),
    (
        "learn run-zone --state wheel_rate=0:1:60000 --state wheel_angle=0:1:60000",
        "at most",
    ),
    ("run policy none.json", "none.json"),
    ("run policy short.json", "short.json: JSON"),
    (
        "run fixed --policy policy.json",
        "saltus run policy policy.json\n",
    ),
    (
        "run policy policy.json --set body.legs=7",
        "body.legs = 7: must be 5",
    ),
    ("export policy empty.json --out c", "policy: is missing"),
    (
        "export policy policy.json --out empty.json",
        "cannot be written",
    ),
    ("export policy policy.json", "--out"),
    ("learn run-zone --robot spring-hopper --draw", "pneumatic"),
    (
        "learn run-zone --out no/policy.json",
        "its folder is not there",
    ),
    ("learn run-zone --resume none.json", "none.json"),
    ("learn run-zone --resume empty.json", "policy: is missing"),
    ("learn run-zone --resume short.json", "short.json: JSON"),
    (
        "learn run-zone --seeds 4 --resume policy.json",
        "--seeds <COUNT>",
    ),
    (
        "learn run-zone --seed 2 --resume policy.json",
        "--seed <SEED>",
    ),
    (
        "learn run-zone --alpha 0.5 --resume policy.json",
        "--alpha <NUMBER>",
    ),
    (
        "learn run-legs --resume policy.json",
        "run-legs: must be run-zone, which policy.json",
    ),
    (
        "learn run-zone --episodes 4 --resume policy.json",
        "above 4, the episodes in policy.json",
    ),
    ("learn climb --seed 1.5", "a whole number from 0 to"),
    (
        "learn run-zone --algorithm q --lambda 0.5",
        "which has no traces",
    ),
    (
        "learn run-zone --set body.mass_kg=3 --resume policy.json",
        "--set",
    ),
];

#[test]
fn bad_input_is_named() {
    let folder = Folder::new("learn-bad");
    folder.done(&format!("{QUICK} --out policy.json"), 0);
    let whole = folder.read("policy.json");
    folder.write("short.json", &whole[..whole.len() / 2]);
    folder.write("empty.json", "{}");
    for (line, said) in REFUSED {
        let words: Vec<&str> = line.split_whitespace().collect();
        let run = folder.run(&words);
        assert_eq!(run.code, Some(2), "{line}: {}", run.err);
        assert!(run.err.contains(said), "{line}: {}", run.err);
        assert!(run.out.is_empty());
    }
}
