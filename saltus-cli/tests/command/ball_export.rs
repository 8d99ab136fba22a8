//! `saltus export gait disc-stable`: the controller of a robot in space, in C.

use std::fmt::Write as _;
use std::io::Write as _;
use std::process::{Command, Stdio};

use saltus::gait::space::{
    Facing, Flashed, Gait, Hearing, Knows, Roll, Stable, Start, Steered, roll,
};
use saltus::robot::space::{discs, rests};
use saltus::sim_check::Stepping;

use crate::common::Folder;
use crate::meaning::run_with;

const PROGRAM: &str = include_str!("../../../controller/examples/ball.c");

/// A run in plane `plane`, or in any that is open, from the first rest: its sensors, of which the first 100 cycles are at rest, and what fired when.
fn driven(gait: Gait, plane: Option<usize>) -> (String, Vec<(usize, u32)>) {
    let robot = saltus::resolve("rats-twelve", &[]).unwrap();
    let directions = robot.space.as_ref().unwrap().directions.vectors();
    let ways = Facing::all(&rests(&directions)[0], &discs(&directions));
    let flashed = Flashed::new(&robot, &Stable::default()).unwrap();
    let way = plane.map_or(0, |plane| {
        let axis = flashed.planes[plane].axes[0];
        let is_its = |way: &Facing| way.plane().axis == axis;
        ways.iter().position(is_its).unwrap()
    });
    let mut setup = Roll::new(robot, 3.0);
    (setup.gait, setup.knows) = (gait, Knows::Sensors(1));
    setup.stepping = Stepping::Fixed(1e-3);
    setup.start = Start {
        way,
        ..Start::default()
    };
    let (mut text, mut fired, mut cycle) = (String::new(), Vec::new(), 0);
    let mut hearing: Option<Hearing> = None;
    roll(&setup, |ball| {
        let rests = if hearing.is_none() { 100 } else { 0 };
        let ears = hearing.get_or_insert_with(|| Hearing::new(&setup.robot, ball.attitude, 1));
        for _ in 0..=rests {
            let r = ears.read(ball.attitude, ball.velocity, ball.touching);
            let axes = [
                r.fine_gyro,
                r.coarse_gyro,
                r.fine_accelerometer,
                r.coarse_accelerometer,
            ];
            for count in axes.iter().flatten() {
                let _ = write!(text, "{count} ");
            }
            let _ = writeln!(text, "{}", r.touching);
            cycle += 1;
        }
        fired.extend(ball.fired.iter().map(|firing| (cycle - 1, firing.leg)));
        true
    })
    .unwrap();
    (text, fired)
}

#[test]
fn the_loop_in_c_fires_as_the_simulated_ball() {
    let folder = Folder::new("ball-export");
    let path = vec![[10.0, 0.0], [10.0, 10.0], [0.0, 10.0], [0.0, 0.0]];
    let gaits = [
        ("disc-stable", Gait::Stable(Stable::default())),
        ("steer", Gait::Steered(Steered::new(path))),
    ];
    for (real, (name, gait)) in ["float", "double"]
        .iter()
        .flat_map(|real| gaits.iter().map(move |gait| (real, gait)))
    {
        let line = format!("export gait {name} --robot rats-twelve --out ball --real {real}");
        let said = folder.done(&line, 0);
        assert!(said.contains("ball rats-twelve"), "{said}");
        for file in ["saltus_ball.h", "saltus_ball.c", "ball_tables.h"] {
            let text = folder.read(&format!("ball/{file}"));
            assert!(said.lines().all(|line| text.contains(line)), "{file}");
            assert!(!text.contains('@'), "{file} has a place not filled");
        }
        // Without input it says nothing; then which plane it takes is asked for.
        let ask = PROGRAM.replace(
            "if (!read_sensors(&readings)) return 1;",
            "if (!read_sensors(&readings)) return 0;",
        );
        let Some(said) = run_with(&folder, "ball/saltus_ball.c", &ask, &[]) else {
            return;
        };
        assert_eq!(said, "");
        let heard = |text: &str| -> Vec<String> {
            let mut program = Command::new(folder.path("main"))
                .stdin(Stdio::piped())
                .stdout(Stdio::piped())
                .spawn()
                .unwrap();
            let mut stdin = program.stdin.take().unwrap();
            stdin.write_all(text.as_bytes()).unwrap();
            drop(stdin);
            let said = program.wait_with_output().unwrap().stdout;
            String::from_utf8(said)
                .unwrap()
                .lines()
                .map(str::to_owned)
                .collect()
        };
        // All ways from this rest begin alike: at rest it does not matter which is simulated.
        let (at_rest, _) = driven(gait.clone(), None);
        let chosen = heard(&at_rest)[0].clone();
        let plane = chosen.split(' ').nth(1).unwrap().parse().unwrap();
        let (sensors, fired) = driven(gait.clone(), Some(plane));
        let said = heard(&sensors);
        assert_eq!(said[0], chosen);
        // Its noise is another draw, so that the instants differ by a few cycles, and corrections by which there are.
        let first: Vec<(usize, u32)> = said[1..]
            .iter()
            .map(|line| {
                let mut words = line.split(' ');
                let cycle = words.next().unwrap().parse().unwrap();
                (cycle, words.nth(1).unwrap().parse().unwrap())
            })
            .collect();
        assert!(first.len() >= 10 && fired.len() >= 10, "{said:?} {fired:?}");
        // A pilot waits until it has lain still for long enough, which begins sooner where it is not simulated.
        for (k, (ours, theirs)) in first.iter().zip(&fired).take(8).enumerate() {
            let most = if k == 0 && *name == "steer" { 110 } else { 10 };
            assert!(
                ours.1 == theirs.1 && ours.0.abs_diff(theirs.0) < most,
                "{name}, {real}: {first:?} {fired:?}"
            );
        }
    }
}

#[test]
fn the_files_are_the_same_each_time_and_no_angle_has_more_than_twelve_places() {
    let folder = Folder::new("ball-export-twice");
    for out in ["one", "two"] {
        folder.done(
            &format!("export gait disc-stable --real double --out {out}"),
            0,
        );
    }
    for file in ["saltus_ball.h", "saltus_ball.c", "ball_tables.h"] {
        assert_eq!(
            folder.read(&format!("one/{file}")),
            folder.read(&format!("two/{file}"))
        );
    }
    let tables = folder.read("one/ball_tables.h");
    let angles: Vec<&str> = tables
        .lines()
        .filter_map(|line| line.strip_prefix("    {{"))
        .filter_map(|line| {
            line.split_once("}, ")
                .map(|(_, angle)| angle.trim_end_matches("},"))
        })
        .filter(|angle| !angle.contains(','))
        .collect();
    // Fifteen planes, two ways, six stations.
    assert_eq!(angles.len(), 180);
    for angle in angles {
        let places = angle.split_once('.').unwrap().1.len();
        assert!(places <= 12, "{angle}");
    }
}
