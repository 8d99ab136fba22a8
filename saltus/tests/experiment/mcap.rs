//! Runs in MCAP files: ours, and those of others by a mapping of topics to columns.

use std::path::{Path, PathBuf};

use saltus::experiment::{Experiment, Sort, read, write};
use saltus::inject::{Request, make};
use saltus::telemetry::message::{self, Imu, Joints};
use saltus::telemetry::{Definition, Encoder, Topic, Writer};
use saltus::{Robot, resolve};

use crate::folder::Folder;

/// Start of the clock of the files here (ns), and how much later the log is (ns).
const START: u64 = 1_700_000_000_000_000_000;
const LATE: u64 = 3_000_000;

/// Files of the official writers.
fn files() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../telemetry/tests/files")
}

/// Synthetic data of a kind, whose runs have files that end so.
fn made(kind: Sort, end: &str) -> (Experiment, Option<Robot>) {
    let robot = kind.spec().robot.map(|name| resolve(name, &[]).unwrap());
    let request = Request {
        kind,
        robot: robot.as_ref(),
        effects: &[],
        seed: 3,
        runs: Some(4),
        asked: &[],
    };
    let mut experiment = make(&request).unwrap().experiment;
    for run in &mut experiment.runs {
        run.name = run.name.replace(".csv", end);
    }
    (experiment, robot)
}

#[test]
fn a_file_of_ours_says_what_the_csv_file_says() {
    for kind in [
        Sort::Bench,
        Sort::Flight,
        Sort::Outcomes,
        Sort::Vessel,
        Sort::Stroke,
    ] {
        let folder = Folder::new(&format!("mcap-{}", kind.spec().id));
        for (place, end) in [("csv", ".csv"), ("mcap", ".mcap"), ("again", ".mcap")] {
            let (experiment, robot) = made(kind, end);
            let name = robot.as_ref().map(|robot| robot.name.as_str());
            write(&folder.path(place), &experiment, name).unwrap();
        }
        let [csv, mcap] = ["csv", "mcap"].map(|place| read(&folder.path(place), &|_| ()).unwrap());
        assert_eq!(mcap.notes, csv.notes, "{kind:?}");
        let mut experiment = mcap.experiment;
        for run in &mut experiment.runs {
            run.name = run.name.replace(".mcap", ".csv");
        }
        // Numbers to the bit, with those that are none.
        assert_eq!(format!("{experiment:?}"), format!("{:?}", csv.experiment));
        for name in folder.names_in("mcap") {
            let [one, other] = ["mcap", "again"]
                .map(|place| std::fs::read(folder.path(&format!("{place}/{name}"))).unwrap());
            assert_eq!(one, other, "{name}");
        }
    }
}

/// A writer of messages at times (ms) of a robot's clock, into the file `name` of a folder.
struct Bag {
    writer: Writer<Vec<u8>>,
    encoder: Encoder,
}

impl Bag {
    fn new() -> Bag {
        Bag {
            writer: Writer::new(Vec::new(), "test").unwrap(),
            encoder: Encoder::new(),
        }
    }

    fn topic(&mut self, topic: &str, definition: &Definition) -> Topic {
        self.writer.channel(topic, definition).unwrap()
    }

    fn send(&mut self, topic: Topic, ms: f64) {
        let ns = at(ms) + LATE;
        self.writer.write(topic, ns, self.encoder.bytes()).unwrap();
    }

    fn joint(&mut self, topic: Topic, ms: f64, position: f64) {
        let joints = Joints {
            names: &["other", "piston"],
            position: &[9.0, position],
            ..Joints::default()
        };
        message::joint_state(&mut self.encoder, at(ms), &joints);
        self.send(topic, ms);
    }

    fn done(self, folder: &Folder, name: &str) {
        folder.write(name, self.writer.finish().unwrap());
    }
}

/// The time (ns) of the header of a message at so many ms.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn at(ms: f64) -> u64 {
    START + (1e6 * ms).round() as u64
}

/// A slide whose force comes every 2 ms and whose position every 3 ms, 1 ms late.
fn slide(folder: &Folder, keys: &str) {
    let mut bag = Bag::new();
    let joints = bag.topic("/joint_states", &Definition::JOINT_STATE);
    let force = bag.topic("/force", &Definition::WRENCH);
    for k in 0..30 {
        let ms = 2.0 * f64::from(k);
        message::wrench(&mut bag.encoder, at(ms), "", [0.1 * ms + 1.0, 0.0, 0.0]);
        bag.send(force, ms);
    }
    for k in 0..20 {
        let ms = 1.0 + 3.0 * f64::from(k);
        bag.joint(joints, ms, 0.01 * ms);
    }
    bag.done(folder, "a.mcap");
    folder.write(
        "experiment.toml",
        format!("kind = \"slide\"\n[[run]]\nfile = \"a.mcap\"\n{keys}\n"),
    );
}

const SLIDE: &str = "columns = { force_n = \"/force.wrench.force.x\", \
    position_m = \"/joint_states.position[piston]\" }";

#[test]
fn slower_topics_are_interpolated_to_the_fastest() {
    let folder = Folder::new("mcap-slide");
    slide(&folder, SLIDE);
    let found = read(&folder.path("."), &|_| ()).unwrap();
    let run = &found.experiment.runs[0];
    assert_eq!(run.time.len(), 30);
    let of = |column: &str| {
        let k = found
            .experiment
            .columns
            .iter()
            .position(|c| c == column)
            .unwrap();
        &run.values[k]
    };
    for (k, time) in run.time.iter().enumerate() {
        let ms = 2.0 * k as f64;
        assert!((1e3 * time - ms).abs() < 1e-9);
        assert_eq!(of("force_n")[k], 0.1 * ms + 1.0);
        let x = of("position_m")[k];
        // Before the first message there is none.
        assert!(
            if k == 0 {
                x.is_nan()
            } else {
                (x - 0.01 * ms).abs() < 1e-12
            },
            "{k}: {x}"
        );
    }
    let said = "a.mcap: /joint_states is interpolated to the times of /force, in ";
    assert!(
        found.notes.iter().any(|note| note.starts_with(said)),
        "{:?}",
        found.notes
    );
}

#[test]
fn units_clocks_and_parts_are_those_that_are_asked_for() {
    let folder = Folder::new("mcap-units");
    let in_mm = SLIDE.replace("position_m", "position_mm");
    slide(
        &folder,
        &format!("{in_mm}\nclock = \"log\"\nvalid_from_s = 1700000000.013"),
    );
    let found = read(&folder.path("."), &|_| ()).unwrap();
    let run = &found.experiment.runs[0];
    // The log is 3 ms late: 1 ms + 3 ms to 58 ms + 3 ms.
    assert_eq!(run.time.len(), 25);
    let position = &run.values[found
        .experiment
        .columns
        .iter()
        .position(|c| c == "position_m")
        .unwrap()];
    assert!(
        (position[0] - 1e-3 * 0.01 * 10.0).abs() < 1e-12,
        "{}",
        position[0]
    );
    // A mapping of all runs.
    slide(&folder, "");
    let text = folder
        .read("experiment.toml")
        .replace("[[run]]", &format!("{SLIDE}\n[[run]]"));
    folder.write("experiment.toml", text);
    assert_eq!(read(&folder.path("."), &|_| ()).unwrap().rows, 30);
}

/// A bench whose valve is told only when it switches, between two rows.
fn bench(folder: &Folder) {
    let mut bag = Bag::new();
    let joints = bag.topic("/joint_states", &Definition::JOINT_STATE);
    let valve = bag.topic(
        "/valve",
        &Definition::own("std_msgs/msg/Bool", [("bool", "data")]),
    );
    for k in 0..40 {
        let ms = f64::from(k);
        bag.joint(joints, ms, 1e-4 * (ms - 10.0).max(0.0));
    }
    for (ms, x) in [(5.25, 1), (20.5, 1), (30.0, 0)] {
        bag.encoder.clear().u8(x);
        bag.send(valve, ms);
    }
    bag.done(folder, "a.mcap");
    folder.write(
        "experiment.toml",
        "kind = \"bench\"\nrobot = \"rats-planar\"\n[[run]]\nfile = \"a.mcap\"\nload_mass_kg = 2.5\n\
         supply_pressure_gauge_pa = 827000\ncolumns = { valve = \"/valve.data\", position_m = \
         \"/joint_states.position[piston]\" }\n",
    );
}

#[test]
fn a_valve_holds_its_value_and_switches_at_its_own_time() {
    let folder = Folder::new("mcap-valve");
    bench(&folder);
    let found = read(&folder.path("."), &|_| ()).unwrap();
    let (open, shut) = found.experiment.runs[0].valve.unwrap();
    assert_eq!((open, shut), (0.00525, Some(0.03)));
    let said = "a.mcap: times are those of the log, as messages on /valve have no header";
    assert!(
        found.notes.iter().any(|note| note == said),
        "{:?}",
        found.notes
    );
}

#[test]
fn what_a_file_lacks_is_said_with_what_it_has() {
    let folder = Folder::new("mcap-lacks");
    let check = |keys: &str, said: &[&str]| {
        slide(&folder, keys);
        let error = read(&folder.path("."), &|_| ()).unwrap_err().to_string();
        for words in said {
            assert!(error.contains(words), "{keys}: {error}");
        }
    };
    let both = |position: &str| SLIDE.replace("/joint_states.position[piston]", position);
    check(
        "",
        &[
            "a.mcap: has no topic /measured",
            "columns = {",
            "/force (geometry_msgs/msg/WrenchStamped, 30)",
        ],
    );
    check(
        &both("/joint.position[piston]"),
        &[
            "column position_m: no message on /joint;",
            "/joint_states (sensor_msgs",
        ],
    );
    check(
        &both("/joint_states.positions[0]"),
        &["positions[0]", "its fields are header, name, position"],
    );
    check(
        &both("/joint_states"),
        &["experiment.toml:4", "must be a topic and fields"],
    );
    check(
        &SLIDE.replace("force_n", "farce_n"),
        &["unknown column farce_n", "force_n"],
    );
    check(
        &SLIDE.replace("force_n", "time_s"),
        &["columns.time_s", "see clock"],
    );
    check(
        &format!("{SLIDE}\nclock = \"sun\""),
        &["clock", "\"header\" or \"log\""],
    );
    let words = ["experiment.toml:2", "clock: must stand beside columns"];
    check("clock = \"log\"", &words);
    check(&both("/joint_states.position[elbow]"), &["position_m"]);
    let folder = Folder::new("mcap-clock");
    bench(&folder);
    let text = folder.read("experiment.toml") + "clock = \"header\"\n";
    folder.write("experiment.toml", text);
    let error = read(&folder.path("."), &|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("messages on /valve have no header"),
        "{error}"
    );
}

#[test]
fn damaged_and_foreign_files_are_told_by_name() {
    let folder = Folder::new("mcap-damaged");
    slide(&folder, SLIDE);
    let whole = std::fs::read(folder.path("a.mcap")).unwrap();
    let check = |bytes: &[u8], said: &str| {
        folder.write("a.mcap", bytes);
        let error = read(&folder.path("."), &|_| ()).unwrap_err().to_string();
        assert!(
            error.contains("a.mcap: ") && error.contains(said),
            "{error}"
        );
    };
    check(b"time_s,force_n,position_m\n", "is no MCAP file");
    check(b"SQLite format 3\0", "ros2 bag convert");
    check(&whole[..200], "is cut off");
    let mut flipped = whole.clone();
    flipped[2000] ^= 1;
    check(&flipped, "is damaged");
    let idl = files().join("foreign/ros2idl.mcap");
    std::fs::copy(idl, folder.path("a.mcap")).unwrap();
    let keys = SLIDE.replace("/force.wrench.force.x", "/valve.data");
    let text = format!("kind = \"slide\"\n[[run]]\nfile = \"a.mcap\"\n{keys}\n");
    folder.write("experiment.toml", text);
    let error = read(&folder.path("."), &|_| ()).unwrap_err().to_string();
    assert!(
        error.contains("a.mcap: /valve: ") && error.contains("\"ros2idl\""),
        "{error}"
    );
}

/// Bytes changed, left out and put in, with the checksums left out so that the damage gets through.
#[test]
fn no_damage_breaks_the_reader() {
    let folder = Folder::new("mcap-mutated");
    slide(&folder, SLIDE);
    let whole = std::fs::read(folder.path("a.mcap")).unwrap();
    let official = std::fs::read(files().join("unindexed.mcap")).unwrap();
    let mut state = 0x1234_5678_9abc_def1_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state).unwrap() % below
    };
    let mut read_well = 0;
    for round in 0..200 {
        let mut bytes = if round % 2 == 0 {
            whole.clone()
        } else {
            official.clone()
        };
        // No checksum of the data section, whose end says it, and none of the chunk: it follows
        // opcode, length, two times and a size.
        let end = bytes
            .windows(9)
            .position(|b| b == [15, 4, 0, 0, 0, 0, 0, 0, 0]);
        bytes[end.unwrap() + 9..][..4].fill(0);
        if round % 2 == 0 {
            let chunk = bytes.iter().position(|b| *b == 6).unwrap();
            bytes[chunk + 33..][..4].fill(0);
        }
        for _ in 0..=random(3) {
            let at = 100 + random(bytes.len() - 200);
            bytes[at] = u8::try_from(random(256)).unwrap();
        }
        folder.write("a.mcap", &bytes);
        let keys = if round % 2 == 0 {
            SLIDE.to_owned()
        } else {
            "columns = { force_n = \"/imu.angular_velocity.y\", position_m = \
             \"/joint_states.position[leg1]\" }"
                .to_owned()
        };
        let text = format!("kind = \"slide\"\n[[run]]\nfile = \"a.mcap\"\n{keys}\n");
        folder.write("experiment.toml", text);
        match read(&folder.path("."), &|_| ()) {
            Ok(_) => read_well += 1,
            Err(error) => assert!(error.to_string().contains("a.mcap"), "{error}"),
        }
    }
    assert!(read_well > 20, "{read_well}");
}

#[test]
fn of_a_file_that_is_cut_off_what_is_whole_is_read() {
    let folder = Folder::new("mcap-cut");
    let mut bag = Bag::new();
    let imu = bag.topic("/imu", &Definition::IMU);
    // Chunks of 1 MiB: more than three of them.
    for k in 0..10_000 {
        let said = Imu {
            angular_velocity: [0.0, 1e-4 * f64::from(k), 0.0],
            linear_acceleration: Some([0.5 * f64::from(k), 0.0, 0.0]),
            ..Imu::default()
        };
        message::imu(&mut bag.encoder, at(f64::from(k)), "", &said);
        bag.send(imu, f64::from(k));
    }
    let bytes = bag.writer.finish().unwrap();
    folder.write("a.mcap", &bytes[..bytes.len() / 2]);
    folder.write(
        "experiment.toml",
        "kind = \"slide\"\n[[run]]\nfile = \"a.mcap\"\ncolumns = { force_n = \
         \"/imu.linear_acceleration.x\", position_m = \"/imu.angular_velocity.y\" }\n",
    );
    let found = read(&folder.path("."), &|_| ()).unwrap();
    let said = "a.mcap: is cut off: ";
    assert!(
        found.notes.iter().any(|note| note.starts_with(said)),
        "{:?}",
        found.notes
    );
    assert!(found.rows > 2000 && found.rows < 5000, "{}", found.rows);
}

#[test]
fn files_of_the_official_writers_are_experiments() {
    let files = files();
    let folder = Folder::new("mcap-official");
    let mut all = Vec::new();
    for name in [
        "none",
        "zstd",
        "lz4",
        "unindexed",
        "rosbag2",
        "rosbag2_zstd",
    ] {
        std::fs::copy(files.join(format!("{name}.mcap")), folder.path("a.mcap")).unwrap();
        folder.write(
            "experiment.toml",
            "kind = \"slide\"\n[[run]]\nfile = \"a.mcap\"\ncolumns = { force_n = \
             \"/imu.angular_velocity.y\", position_m = \"/joint_states.position[leg1]\" }\n",
        );
        let found = read(&folder.path("."), &|_| ()).unwrap();
        all.push((name, format!("{:?}", found.experiment)));
    }
    assert!(
        all.iter().all(|(_, data)| *data == all[0].1),
        "{:?}",
        all.iter().map(|a| a.0).collect::<Vec<_>>()
    );
}
