//! Files of the official Python writers (`tests/mcap/fixtures.py`; mcap 1.6.0, mcap-ros2-support 0.6.0,
//! rosbags 0.11.9), our own, and damaged ones.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path as FilePath;
use std::time::{Duration, Instant};

use proptest::prelude::*;
use saltus_telemetry::message::{self, Joints};
use saltus_telemetry::{
    Channel, Definition, Encoder, Error, Event, Field, Path, Schema, Writer, read,
};

const FILES: [&str; 6] = [
    "none.mcap",
    "zstd.mcap",
    "lz4.mcap",
    "unindexed.mcap",
    "rosbag2.mcap",
    "rosbag2_zstd.mcap",
];

/// Time of the first measurement in them (ns), and from a measurement to the log (ns).
const START: u64 = 1_700_000_000_000_000_000;
const LATE: u64 = 3_000_000;

fn file(name: &str) -> Vec<u8> {
    let folder = FilePath::new(env!("CARGO_MANIFEST_DIR")).join("tests/files");
    fs::read(folder.join(name)).expect("a file of the tests")
}

/// The numbers to which `path` leads, with the times (ns) of the log.
fn numbers(bytes: &[u8], path: &str) -> Result<Vec<(u64, f64)>, Error> {
    let path: Path = path.parse()?;
    let mut found = Vec::new();
    read(bytes, &mut |event| {
        if let Event::Message {
            channel,
            log_time,
            data,
        } = event
            && channel.topic == path.topic
        {
            found.push((log_time, number(channel, &path.fields, data)?));
        }
        Ok(())
    })?;
    Ok(found)
}

fn number(channel: &Channel, path: &[Field], data: &[u8]) -> Result<f64, Error> {
    let mut out = [f64::NAN];
    channel.layout()?.select(&[path])?.find(data, &mut out)?;
    Ok(out[0])
}

#[test]
fn files_of_others_have_the_numbers_that_were_written() {
    for name in FILES {
        let bytes = file(name);
        let check = |path: &str, every: u64, of: &dyn Fn(f64) -> f64| {
            let found = numbers(&bytes, path).expect(name);
            let expected: Vec<(u64, f64)> = (0..40)
                .step_by(usize::try_from(every).expect("a small number"))
                .map(|k| (START + LATE + k * 1_000_000, of(k as f64)))
                .collect();
            assert_eq!(found.len(), expected.len(), "{name}: {path}");
            for ((at, x), (time, y)) in found.into_iter().zip(expected) {
                // Python's sine and Rust's may differ in the last bit.
                assert!(
                    at == time && (x - y).abs() <= 1e-15,
                    "{name}: {path}: {x} {y}"
                );
            }
        };
        check("/imu.angular_velocity.y", 1, &|k| 5.0 * (0.01 * k).cos());
        check("/imu.linear_acceleration.x", 1, &|_| 0.25);
        check("/imu.linear_acceleration_covariance[0]", 1, &|_| -1.0);
        check("/imu.header.stamp.nanosec", 1, &|k| 1e6 * k);
        check("/joint_states.position[leg1]", 2, &|k| {
            0.001 * (0.3 * k).sin()
        });
        check("/joint_states.position[0]", 2, &|_| 1.5);
        check("/joint_states.effort[leg1]", 2, &|_| 3.5);
        let valve = numbers(&bytes, "/valve.data").expect(name);
        let at = |k: u64| START + LATE + k * 1_000_000;
        assert_eq!(valve, [(at(10), 1.0), (at(20), 0.0)], "{name}");
    }
}

#[test]
fn an_element_that_is_not_there_is_no_number() {
    let found = numbers(&file("none.mcap"), "/joint_states.position[elbow]").expect("a file");
    assert!(found.len() == 20 && found.iter().all(|(_, x)| x.is_nan()));
    let found = numbers(&file("none.mcap"), "/joint_states.velocity[0]").expect("a file");
    assert!(found.iter().all(|(_, x)| x.is_nan()));
}

/// A file with `count` messages of joints and events.
fn written(count: u64) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut writer = Writer::new(&mut bytes, "test").expect("a writer");
    let joints = writer
        .channel("/joint_states", &Definition::JOINT_STATE)
        .expect("a channel");
    let own = Definition::own("saltus_msgs/msg/Own", [("uint8", "a"), ("float64", "b_m")]);
    let own = writer.channel("/own", &own).expect("a channel");
    writer
        .attach("robot.toml", "application/toml", b"name = \"x\"")
        .expect("an attachment");
    let about = BTreeMap::from([("seed".to_owned(), "7".to_owned())]);
    writer.metadata("about", about).expect("metadata");
    let mut encoder = Encoder::new();
    for k in 0..count {
        let x = k as f64;
        let state = Joints {
            names: &["a", "bc"],
            position: &[x, -x],
            velocity: &[0.5 * x, f64::NAN],
            effort: &[],
        };
        message::joint_state(&mut encoder, 1000 * k, &state);
        writer
            .write(joints, 1000 * k, encoder.bytes())
            .expect("a message");
        encoder.clear().u8(7).f64(x.sqrt());
        writer
            .write(own, 1000 * k, encoder.bytes())
            .expect("a message");
    }
    writer.finish().expect("an end");
    bytes
}

#[test]
fn what_is_written_is_read_back_and_the_bytes_are_the_same_again() {
    // More than one chunk of 1 MiB.
    let bytes = written(10_000);
    assert!(bytes == written(10_000));
    assert!(bytes.len() > 3 << 19, "{}", bytes.len());
    let found = numbers(&bytes, "/joint_states.position[bc]").expect("our file");
    let expected: Vec<(u64, f64)> = (0..10_000).map(|k| (1000 * k, -(k as f64))).collect();
    assert_eq!(found, expected);
    let found = numbers(&bytes, "/own.b_m").expect("our file");
    assert!(
        found
            .iter()
            .all(|(ns, x)| *x == (*ns as f64 / 1000.0).sqrt())
    );
    let mut more = Vec::new();
    let visit = &mut |event: Event<'_>| {
        match event {
            Event::Attachment { name, data } => more.push((name, data.to_vec())),
            Event::Metadata { name, values } => {
                more.push((name, values["seed"].clone().into_bytes()));
            }
            Event::Message { .. } => {}
        }
        Ok(())
    };
    read(bytes.as_slice(), visit).expect("our file");
    let toml = b"name = \"x\"".to_vec();
    assert_eq!(
        more,
        [("robot.toml".into(), toml), ("about".into(), b"7".to_vec())]
    );
}

#[test]
fn a_file_that_is_cut_off_gives_what_is_whole() {
    for name in FILES {
        let bytes = file(name);
        let mut most = 0;
        for end in (0..bytes.len()).step_by(97) {
            let mut count = 0;
            let ended = read(&bytes[..end], &mut |event| {
                count += usize::from(matches!(event, Event::Message { .. }));
                Ok(())
            });
            match ended {
                Ok(()) => assert_eq!(count, 62, "{name}: all messages came before byte {end}"),
                Err(Error::NotMcap { .. }) => assert!(end < 8),
                Err(error) => assert!(matches!(error, Error::Truncated), "{name}: {error}"),
            }
            assert!(count >= most, "{name}");
            most = count;
        }
        assert!(most >= 40, "{name}");
    }
}

#[test]
fn other_files_are_told_by_what_they_are() {
    let check = |bytes: &[u8], said: &str| {
        let error = read(bytes, &mut |_| Ok(())).expect_err(said).to_string();
        assert!(error.contains(said), "{error}");
    };
    check(b"", "it is empty");
    check(b"SQLite format 3\0 and more", "ros2 bag convert");
    check(b"\x28\xb5\x2f\xfd and more", "zstd -d");
    check(b"#ROSBAG V2.0\n and more", "mcap convert");
    check(b"time_s,x_m\n0,1\n", "it begins with \"time_s,x\"");
    check(&file("none.mcap")[..5], "it is cut off");
    check(&file("none.mcap")[..100], "ends in the middle of a record");
    let mut flipped = file("zstd.mcap");
    let middle = flipped.len() / 3;
    flipped[middle] ^= 0x10;
    check(&flipped, "is damaged");
}

#[test]
fn other_encodings_are_refused_by_name() {
    let bytes = file("none.mcap");
    let replaced = |from: &[u8], to: &[u8]| {
        let mut bytes = bytes.clone();
        // Without checksums, which no longer hold.
        for k in 0..bytes.len() - from.len() {
            if &bytes[k..k + from.len()] == from {
                bytes[k..k + from.len()].copy_from_slice(to);
            }
        }
        bytes
    };
    let channel = Channel {
        id: 1,
        topic: "/imu".into(),
        encoding: "cdr".into(),
        schema: Some(std::rc::Rc::new(saltus_telemetry::FileSchema {
            name: "sensor_msgs/msg/Imu".into(),
            encoding: "ros2idl".into(),
            text: String::new(),
        })),
    };
    let error = channel.layout().expect_err("another encoding").to_string();
    assert!(
        error.contains("ros2idl") && error.contains("/imu"),
        "{error}"
    );
    let json = Channel {
        encoding: "json".into(),
        schema: None,
        ..channel
    };
    let error = json.layout().expect_err("another encoding").to_string();
    assert!(error.contains("json"), "{error}");
    // A checksum says that a file was changed.
    let changed = replaced(b"ros2msg", b"ros2idl");
    let error = read(changed.as_slice(), &mut |_| Ok(())).expect_err("a checksum");
    assert!(error.to_string().contains("checksum"), "{error}");
}

#[test]
fn paths_that_lead_to_no_number_say_what_is_there() {
    let check = |path: &str, said: &str| {
        let error = numbers(&file("none.mcap"), path)
            .expect_err(path)
            .to_string();
        assert!(error.contains(said), "{error}");
    };
    check("/imu.angular_rate.y", "its fields are header, orientation");
    check("/imu.angular_velocity", "its fields are x, y, z");
    check("/imu.header.frame_id", "is a text and no number");
    check("/imu.angular_velocity.y.z", "has no fields");
    check("/imu.orientation_covariance", "say which element");
    check("/imu.orientation_covariance[9]", "has the elements 0 to 8");
    check("/imu.angular_velocity[0].x", "is not a list");
    check(
        "/imu.orientation_covariance[knee]",
        "a list of texts called name",
    );
}

/// Reads all that can be read: every number of every message that the definitions of the file name.
fn read_all(bytes: &[u8]) -> usize {
    let mut count = 0;
    let mut selections = BTreeMap::new();
    // How it ends does not matter.
    let _ = read(bytes, &mut |event| {
        let Event::Message { channel, data, .. } = event else {
            return Ok(());
        };
        count += 1;
        let selection = selections.entry(channel.id).or_insert_with(|| {
            let schema = channel.layout().ok()?;
            let own = schema
                .numbers()
                .into_iter()
                .map(|name| vec![Field::named(name)]);
            let known = [
                "/j.position[leg1]",
                "/j.angular_velocity.y",
                "/j.header.stamp.sec",
            ];
            let known = known.map(|text| text.parse::<Path>().expect("a path").fields);
            let all: Vec<Vec<Field>> = own.chain(known).collect();
            let fits = |path: &&Vec<Field>| schema.select(&[path]).is_ok();
            let paths: Vec<&[Field]> = all.iter().filter(fits).map(Vec::as_slice).collect();
            Some((schema.select(&paths).ok()?, paths.len()))
        });
        if let Some((selection, wanted)) = selection {
            let _ = selection.find(data, &mut vec![f64::NAN; *wanted]);
        }
        Ok(())
    });
    count
}

/// Sets the checksums of chunks and of the data to 0, which is none.
fn without_checksums(bytes: &mut [u8]) {
    // Magic bytes, then records: opcode, length, contents.
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 9) {
        let opcode = head[0];
        let length: [u8; 8] = head[1..].try_into().expect("8 bytes");
        let length = usize::try_from(u64::from_le_bytes(length)).expect("a length");
        // Of a chunk it follows two times and a size.
        let checksum = match opcode {
            6 => Some(at + 9 + 24),
            15 => Some(at + 9),
            _ => None,
        };
        if let Some(place) = checksum.and_then(|at| bytes.get_mut(at..at + 4)) {
            place.fill(0);
        }
        at += 9 + length;
        if opcode == 15 {
            break;
        }
    }
}

#[test]
fn damaged_files_give_an_error_or_numbers_and_end() {
    // A fixed generator: the files are the same each time.
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % below as u64).expect("below a usize")
    };
    let started = Instant::now();
    let mut messages = 0;
    let rounds = std::env::var("SALTUS_MCAP_CASES").ok();
    let rounds = rounds.and_then(|text| text.parse().ok()).unwrap_or(600);
    for round in 0..rounds {
        let mut bytes = file(FILES[round % FILES.len()]);
        if round % 2 == 1 {
            without_checksums(&mut bytes);
        }
        for _ in 0..=random(8) {
            if bytes.is_empty() {
                break;
            }
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] = u8::try_from(random(256)).expect("a byte"),
                1 => bytes.truncate(at.max(9)),
                2 => {
                    let end = (at + random(64)).min(bytes.len());
                    bytes.drain(at..end);
                }
                _ => {
                    let copied = bytes[at..(at + random(64)).min(bytes.len())].to_vec();
                    let to = random(bytes.len());
                    bytes.splice(to..to, copied);
                }
            }
        }
        messages += read_all(&bytes);
    }
    assert!(messages > 1000, "some of it is read: {messages}");
    // Some 40 µs each in a debug build, 10 ms where a chunk claims to be long.
    let most = Duration::from_millis(100) * u32::try_from(rounds).expect("fewer files");
    assert!(started.elapsed() < most, "{:?}", started.elapsed());
}

/// Checksums keep most damage from the messages: here it gets there.
#[test]
fn messages_with_wrong_bytes_are_refused_or_read() {
    let mut refused = 0;
    let visit = &mut |event: Event<'_>| {
        if let Event::Message { channel, data, .. } = event
            && channel.topic == "/joint_states"
        {
            let path: Path = "/joint_states.effort[leg1]".parse()?;
            let selection = channel.layout()?.select(&[&path.fields])?;
            for at in 0..data.len() {
                for byte in [0, 1, 0x7f, 0xff] {
                    let mut wrong = data.to_vec();
                    wrong[at] = byte;
                    refused += usize::from(selection.find(&wrong, &mut [0.0]).is_err());
                    wrong.truncate(at);
                    assert!(selection.find(&wrong, &mut [0.0]).is_err(), "{at} bytes");
                }
            }
        }
        Ok(())
    };
    read(file("none.mcap").as_slice(), visit).expect("a file");
    assert!(refused > 1000, "{refused}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any text is a definition or is refused, and any bytes are a message of it or are refused.
    #[test]
    fn no_definition_and_no_message_breaks_the_reader(
        words in prop::collection::vec(
            prop::sample::select(vec![
                "float64", "string", "uint8[]", "T", "p/T", "p/U", "x", "y", "name", "string[]", "[", "=3",
                "\n", "===\nMSG: p/U\n", "float64[3]", "int32[<=2]", "p/U[]", "#", "bool", "wstring",
            ]),
            0..40,
        ),
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let text = words.join(" ");
        if let Ok(schema) = Schema::parse("p/msg/T", &text) {
            let names: Vec<Vec<Field>> = schema.numbers().iter().map(|n| vec![Field::named(n)]).collect();
            let paths: Vec<&[Field]> = names.iter().map(Vec::as_slice).collect();
            if let Ok(selection) = schema.select(&paths) {
                let mut head = vec![0, 1, 0, 0];
                head.extend(&bytes);
                let _ = selection.find(&head, &mut vec![0.0; paths.len()]);
                let _ = selection.find(&bytes, &mut vec![0.0; paths.len()]);
            }
        }
        let mut whole = b"\x89MCAP0\r\n".to_vec();
        whole.extend(&bytes);
        read_all(&whole);
    }

    /// What is encoded is found again, wherever it stands.
    #[test]
    fn encoded_numbers_are_found(
        before in prop::collection::vec(any::<u8>(), 0..9),
        text in "[a-z]{0,9}",
        list in prop::collection::vec(any::<f64>(), 1..9),
        last in any::<u32>(),
    ) {
        let schema = Schema::parse("p/msg/T", "uint8[] a\nstring s\nfloat64[] list\nuint32 last\n").expect("a definition");
        let mut encoder = Encoder::new();
        encoder.length(before.len());
        for x in &before {
            encoder.u8(*x);
        }
        encoder.string(&text).sequence(&list).u32(last);
        let end = list.len() - 1;
        let paths = [format!("/t.list[{end}]"), "/t.last".to_owned()];
        let paths = paths.map(|path| path.parse::<Path>().expect("a path").fields);
        let selection = schema.select(&[&paths[0], &paths[1]]).expect("numbers");
        let mut out = [0.0; 2];
        selection.find(encoder.bytes(), &mut out).expect("a message");
        prop_assert_eq!(out[0].to_bits(), list[end].to_bits());
        prop_assert_eq!(out[1], f64::from(last));
    }
}
