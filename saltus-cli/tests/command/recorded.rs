//! `--mcap`: motions as MCAP files, and what is refused.

use std::collections::BTreeMap;

use saltus::telemetry::{Event, read};

use crate::common::Folder;

/// Messages of each topic of a file.
fn topics(folder: &Folder, name: &str) -> BTreeMap<String, usize> {
    let bytes = std::fs::read(folder.path(name)).unwrap();
    let mut topics = BTreeMap::new();
    let visit = &mut |event: Event<'_>| {
        if let Event::Message { channel, .. } = event {
            *topics.entry(channel.topic.clone()).or_default() += 1;
        }
        Ok(())
    };
    read(bytes.as_slice(), visit).unwrap();
    topics
}

const RUN: &str = "run fixed --seconds 0.5";

#[test]
fn commands_write_what_moves() {
    let folder = Folder::new("mcap");
    let motion = ["/tf", "/joint_states", "/imu", "/leg", "/ground_reaction"];
    let check = |line: &str, code: i32, more: &[&str]| {
        let recorded = || {
            folder.done(&format!("{line} --mcap a.mcap"), code);
            std::fs::read(folder.path("a.mcap")).unwrap()
        };
        assert!(recorded() == recorded(), "{line}: the bytes differ");
        let topics = topics(&folder, "a.mcap");
        for topic in motion.iter().chain(more) {
            assert!(topics.contains_key(*topic), "{line}: {topic}: {topics:?}");
        }
        assert_eq!(topics["/robot_description"], 1);
        assert_eq!(topics["/tf"], topics["/joint_states"]);
    };
    check(
        "simulate --omega 5 --alpha-f -0.1",
        0,
        &["/course", "/events"],
    );
    check(
        "simulate --omega 5 --alpha-f -0.1 --robot spring-hopper",
        0,
        &[],
    );
    check(RUN, 0, &["/measured", "/course", "/events"]);
    check(&format!("{RUN} --robot rats-planar"), 1, &["/measured"]);
    let course = concat!(env!("CARGO_MANIFEST_DIR"), "/../saltus/examples/box.toml");
    let verify = format!("verify {course} --samples 2 --share 0 --clearance 0");
    check(&verify, 0, &["/course", "/events"]);
}

#[test]
fn a_run_is_diagnosed_as_its_telemetry_is() {
    let folder = Folder::new("mcap-run");
    let line = "run fixed --seconds 3 --disturb torque=5@0.5:0.7s";
    folder.done(&format!("{line} --telemetry csv --mcap run.mcap"), 0);
    std::fs::create_dir(folder.path("mcap")).unwrap();
    folder.write("mcap/robot.toml", folder.read("csv/robot.toml"));
    let manifest = folder
        .read("csv/experiment.toml")
        .replace("run.csv", "run.mcap");
    folder.write("mcap/experiment.toml", manifest);
    std::fs::copy(folder.path("run.mcap"), folder.path("mcap/run.mcap")).unwrap();
    let [csv, mcap] = ["csv", "mcap"].map(|name| {
        let found = saltus::experiment::Folder::open(folder.path(name)).unwrap();
        format!("{:?}", found.experiment).replace(".mcap", ".csv")
    });
    assert!(csv == mcap, "the data differ");
}

#[test]
fn bad_requests_leave_no_file() {
    let folder = Folder::new("mcap-bad");
    let cases: [(&str, &[&str]); 8] = [
        (
            "simulate --omega 5 --alpha-f 0 --mcap a.csv",
            &["--mcap", "a.csv", ".mcap"],
        ),
        (
            "simulate --omega 4:5:2 --alpha-f 0 --mcap a.mcap",
            &["--mcap", "one jump, not 2"],
        ),
        (
            "simulate --omega 5 --alpha-f 0 --mcap no/a.mcap",
            &["no/a.mcap: cannot be written"],
        ),
        (
            "run closed-loop --mcap no/a.mcap --seconds 1",
            &["no/a.mcap: cannot be written"],
        ),
        (
            "run closed-loop --mcap a.mcap --out a.mcap --format csv --seconds 1",
            &["--out", "another file"],
        ),
        (
            "run closed-loop --mcap a.mcap --robots 3",
            &["--mcap", "--robots"],
        ),
        ("diagnose d --mcap", &["--mcap"]),
        ("export urdf --robot nobody", &["nobody"]),
    ];
    for (line, words) in cases {
        let words_of: Vec<&str> = line.split(' ').collect();
        let ran = folder.run(&words_of);
        let said = &ran.err;
        assert_eq!(ran.code, Some(2), "{line}: {said}");
        for word in words {
            assert!(said.contains(word), "{line}: {said}");
        }
        assert_eq!(folder.names(), Vec::<String>::new(), "{line}");
    }
}

#[test]
fn a_robot_is_exported_as_urdf() {
    let folder = Folder::new("urdf");
    let shown = folder.done("export urdf --robot rats-boom", 0);
    assert_eq!(
        folder.done("export urdf --robot rats-boom --out boom.urdf", 0),
        ""
    );
    assert_eq!(folder.read("boom.urdf"), shown);
    assert!(shown.contains("<robot name=\"rats-boom\">"), "{shown}");
    assert_eq!(shown.matches("type=\"prismatic\"").count(), 5);
}
