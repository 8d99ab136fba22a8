//! Messages of joints and of an inertial sensor, written and read: `mcap_speed [MESSAGES [FOLDER]]`.
//!
//! Prints MB/s of writing to a file, of copying that file by the system, and of reading two numbers
//! of every message of it.

use std::error::Error;
use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
use std::path::PathBuf;
use std::time::Instant;

use saltus_telemetry::message::{self, Imu, Joints};
use saltus_telemetry::{Definition, Encoder, Event, Path, Selection, Writer, read};

const NAMES: [&str; 8] = [
    "boom_turn",
    "boom",
    "wheel",
    "leg_0",
    "leg_1",
    "leg_2",
    "leg_3",
    "leg_4",
];

fn main() -> Result<(), Box<dyn Error>> {
    let mut words = std::env::args().skip(1);
    let messages: u64 = words.next().map_or(Ok(20_000), |text| text.parse())?;
    let folder = words.next().map_or_else(std::env::temp_dir, PathBuf::from);
    let place = folder.join(format!("saltus-speed-{}.mcap", std::process::id()));
    let copy = place.with_extension("copy");
    let measured = measure(messages, &place, &copy);
    for file in [&place, &copy] {
        // One may not be there.
        let _ = fs::remove_file(file);
    }
    measured
}

fn measure(messages: u64, place: &PathBuf, copy: &PathBuf) -> Result<(), Box<dyn Error>> {
    let started = Instant::now();
    write(messages, place)?;
    let wrote = started.elapsed().as_secs_f64();
    let size = fs::metadata(place)?.len() as f64 / 1e6;
    let started = Instant::now();
    fs::copy(place, copy)?;
    File::open(copy)?.sync_all()?;
    let copied = started.elapsed().as_secs_f64();
    let started = Instant::now();
    let sum = sum(place)?;
    let read = started.elapsed().as_secs_f64();
    println!("{messages} messages, {size:.1} MB; sum of two numbers of each {sum:.6}");
    for (what, seconds) in [("write", wrote), ("copy", copied), ("read", read)] {
        println!("{what:6} {seconds:7.3} s  {:7.0} MB/s", size / seconds);
    }
    Ok(())
}

/// Writes so many messages, in turn of joints and of a sensor, to the disk.
fn write(messages: u64, place: &PathBuf) -> Result<(), Box<dyn Error>> {
    let out = BufWriter::with_capacity(1 << 20, File::create(place)?);
    let mut writer = Writer::new(out, "mcap_speed")?;
    let joints = writer.channel("/joint_states", &Definition::JOINT_STATE)?;
    let imu = writer.channel("/imu", &Definition::IMU)?;
    let mut encoder = Encoder::new();
    for k in 0..messages {
        let (ns, x) = (k / 2 * 1_000_000, k as f64);
        let list = [x, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        if k % 2 == 0 {
            let state = Joints {
                names: &NAMES,
                position: &list,
                velocity: &list,
                effort: &[],
            };
            message::joint_state(&mut encoder, ns, &state);
            writer.write(joints, ns, encoder.bytes())?;
        } else {
            let said = Imu {
                angular_velocity: [0.0, x, 0.0],
                ..Imu::default()
            };
            message::imu(&mut encoder, ns, "wheel", &said);
            writer.write(imu, ns, encoder.bytes())?;
        }
    }
    let mut out = writer.finish()?;
    out.flush()?;
    out.get_ref().sync_all()?;
    Ok(())
}

/// The sum of two numbers of every message.
fn sum(place: &PathBuf) -> Result<f64, Box<dyn Error>> {
    let paths = [
        [
            "/joint_states.position[boom_turn]",
            "/joint_states.velocity[leg_4]",
        ],
        ["/imu.angular_velocity.y", "/imu.orientation.w"],
    ];
    let mut selections: [Option<Selection>; 2] = [None, None];
    let mut sum = 0.0;
    let file = BufReader::with_capacity(1 << 20, File::open(place)?);
    read(file, &mut |event| {
        if let Event::Message { channel, data, .. } = event {
            let which = usize::from(channel.topic == "/imu");
            if selections[which].is_none() {
                let [one, other] = paths[which].map(str::parse::<Path>);
                let (one, other) = (one?, other?);
                let found = channel.layout()?.select(&[&one.fields, &other.fields])?;
                selections[which] = Some(found);
            }
            if let Some(selection) = &selections[which] {
                let mut found = [0.0; 2];
                selection.find(data, &mut found)?;
                sum += found[0] + found[1];
            }
        }
        Ok(())
    })?;
    Ok(sum)
}
