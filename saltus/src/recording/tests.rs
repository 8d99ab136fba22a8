//! What stands in a recording, read back by the library.

use saltus_robot::Robot;
use saltus_sim_check::{Plan, Report, Rig};
use saltus_telemetry::{Event, Path, read};

use super::*;
use crate::Launch;

fn recorded(robot: &Robot) -> (Report, Vec<u8>) {
    let launch = Launch::at_firing(5.0, -0.1, 0.1);
    let report = Rig::new(robot, &[])
        .unwrap()
        .jump(&launch, &Plan::default());
    let report = report.unwrap();
    let mut bytes = Vec::new();
    let origin = Origin {
        command: "test",
        seed: Some(7),
        robot: Some(robot),
    };
    let mut recording = Recording::new(&mut bytes, &origin).unwrap();
    recording.robot(robot).unwrap();
    let block = Block {
        front: 0.3,
        back: 0.5,
        top: 0.1,
    };
    recording.course(&[block]).unwrap();
    let flown = Flown {
        valve_open: 0.1,
        ..Flown::default()
    };
    recording.jump(&report, &flown).unwrap();
    recording.finish().unwrap();
    (report, bytes)
}

/// The numbers to which `path` leads, with the times (ns) of their messages.
fn numbers(bytes: &[u8], path: &str) -> Vec<(u64, f64)> {
    let path: Path = path.parse().unwrap();
    let mut found = Vec::new();
    let visit = &mut |event: Event<'_>| {
        if let Event::Message {
            channel,
            log_time,
            data,
        } = event
            && channel.topic == path.topic
        {
            let mut out = [f64::NAN];
            channel
                .layout()?
                .select(&[&path.fields])?
                .find(data, &mut out)?;
            found.push((log_time, out[0]));
        }
        Ok(())
    };
    read(bytes, visit).unwrap();
    found
}

#[test]
fn a_jump_is_recorded_to_the_bit() {
    for name in ["rats-planar", "rats-boom", "spring-hopper"] {
        let robot = saltus_robot::resolve(name, &[]).unwrap();
        let rig = Rig::new(&robot, &[]).unwrap();
        let (report, bytes) = recorded(&robot);
        assert_eq!(bytes, recorded(&robot).1, "{name}: the same bytes");
        let check = |path: &str, of: &dyn Fn(&saltus_sim_check::Sample) -> f64| {
            let found = numbers(&bytes, path);
            assert_eq!(found.len(), report.samples.len(), "{path}");
            for ((ns, x), sample) in found.iter().zip(&report.samples) {
                assert_eq!(*ns, nanoseconds(sample.time));
                assert_eq!(x.to_bits(), of(sample).to_bits(), "{name}: {path}");
            }
        };
        check("/joint_states.position[wheel]", &|s| s.lean);
        check("/joint_states.position[leg_0]", &|s| s.extension);
        check("/leg.extension_m[0]", &|s| s.extension);
        check("/joint_states.velocity[wheel]", &|s| {
            s.velocities[rig.lean_velocity()]
        });
        check("/imu.header.stamp.nanosec", &|s| nanoseconds(s.time) as f64);
        if name == "rats-planar" {
            check("/leg.pressure_pa[0]", &|s| s.pressure);
            check("/tf.transforms[1].transform.translation.z", &|s| s.axle[1]);
        }
        assert_eq!(numbers(&bytes, "/course.markers[1].scale.z"), [(0, 0.1)]);
        let forces = numbers(&bytes, "/ground_reaction.wrench.force.z");
        let lift_off = report.lift_off.unwrap().time;
        let standing = report.samples.iter().filter(|s| s.time < lift_off);
        assert_eq!(forces.len(), standing.count(), "{name}");
        assert!(forces.iter().any(|(_, force)| *force > 10.0));
    }
}

#[test]
fn the_robot_and_where_it_comes_from_are_in_the_file() {
    let robot = Robot::rats_planar();
    let (_, bytes) = recorded(&robot);
    let (mut attached, mut about) = (None, None);
    let visit = &mut |event: Event<'_>| {
        match event {
            Event::Attachment { name, data } if name == "robot.toml" => {
                attached = Some(String::from_utf8_lossy(data).into_owned());
            }
            Event::Metadata { values, .. } => about = Some(values),
            _ => {}
        }
        Ok(())
    };
    read(bytes.as_slice(), visit).unwrap();
    assert_eq!(attached, Some(robot.to_toml()));
    let about = about.unwrap();
    assert_eq!(about["seed"], "7");
    assert_eq!(about["command"], "test");
    assert_eq!(about["robot_sha256"].len(), 64);
}
