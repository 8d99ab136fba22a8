//! `saltus run`: what it answers, in which form, and what it refuses.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use serde_json::Value;

use crate::common::{Folder, rows};

/// A run that goes on after its push.
const PUSHED: &str = "run fixed --seconds 3 --disturb torque=5@0.5:0.7s";

fn json(folder: &Folder, line: &str, code: i32) -> Value {
    serde_json::from_str(&folder.done(&format!("{line} --format json"), code)).unwrap()
}

fn number(value: &Value, key: &str) -> f64 {
    value[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key}: {value}"))
}

/// The thesis' first mode (5.1.2): from rest it fires once and stalls; after a push it runs.
#[test]
fn the_fixed_gait_stalls_from_rest_and_runs_after_a_push() {
    let folder = Folder::new("run-fixed");
    let stalled = json(&folder, "run fixed --seconds 3", 1);
    assert_eq!(stalled["ending"]["how"], "stalled");
    assert!(
        stalled["ending"]["reason"]
            .as_str()
            .unwrap()
            .contains("has fired already"),
        "{stalled}"
    );
    // It rocks for a second or two, less than two strides from where it began.
    let since = stalled["ending"]["since_s"].as_f64().unwrap();
    let at = stalled["ending"]["at_m"].as_f64().unwrap();
    assert!(
        since > 0.5 && since < 2.5 && at > 0.1 && at < 0.6,
        "{stalled}"
    );
    let text = folder.done("run fixed --seconds 3", 1);
    assert!(text.contains("stalled: stands still since"), "{text}");

    let ran = json(&folder, PUSHED, 0);
    assert_eq!(ran["ending"]["how"], "ran");
    // Bouncing is at 1.8 m/s, running at 3.5: both travel over 3 m in the 2.3 s after the push.
    assert!(number(&ran, "travel_m") > 3.0, "{ran}");
    assert!(number(&ran["ledger_j"], "outside") > 1.0, "{ran}");
}

#[test]
fn energies_close_where_every_event_is_located() {
    let folder = Folder::new("run-exact");
    let run = json(&folder, &format!("{PUSHED} --exact"), 0);
    assert_eq!(run["step_s"], Value::Null);
    let ledger = &run["ledger_j"];
    // The integrator keeps 1e-10 of a step; some thousand steps of some joules.
    for key in ["residual", "gas_residual"] {
        assert!(number(ledger, key).abs() < 1e-8, "{key}: {ledger}");
    }
    let work: f64 = run["leg_work_j"]
        .as_array()
        .unwrap()
        .iter()
        .map(|work| work.as_f64().unwrap())
        .sum();
    assert!((work - number(ledger, "drives")).abs() < 1e-9, "{run}");
    // Gas that went through the valves for some 12 openings of 40 ms: tenths of a gram each.
    let (gas, travel) = (number(&run, "gas_kg"), number(&run, "travel_m"));
    assert!(gas > 2e-4 && gas < 5e-3, "{gas}");
    assert!((number(&run, "gas_kg_per_m") - gas / travel).abs() < 1e-12);
    // R T ln(p/p_a) of air at 20 °C and 120 psi.
    let exergy = number(&run, "exergy_j_per_m") / number(&run, "gas_kg_per_m");
    assert!((exergy - 186_427.0).abs() < 1.0, "{exergy}");
}

/// The wheel is its own mirror image on level ground; sensors draw other noise.
#[test]
fn backwards_is_the_mirror_of_forwards() {
    let folder = Folder::new("run-backwards");
    let quiet = "--set sensors.gyro_noise_rad_s=0 --seconds 1";
    let ahead = json(&folder, &format!("run fixed {quiet}"), 0);
    let back = json(
        &folder,
        &format!("run fixed --direction backwards {quiet}"),
        0,
    );
    let (a, b) = (number(&ahead, "travel_m"), number(&back, "travel_m"));
    // Encoders round down, which a mirror does not: a count is 8 mrad, some mm of travel.
    assert!((a + b).abs() < 0.02 && a > 0.1, "{a} {b}");
    // One convention of signs: a robot that travels backwards has a speed below 0.
    for key in ["travel_m", "mean_speed_m_s", "top_speed_m_s"] {
        let (a, b) = (number(&ahead, key), number(&back, key));
        assert!(a > 0.0 && b < 0.0, "{key}: {a} {b}");
    }
    let line = "run smooth --direction backwards --seconds 2 --robots 3 --seed 200 --format json";
    let many: Value = serde_json::from_str(&folder.done(line, 0)).unwrap();
    let speeds = &many["speed_of_runners_m_s"];
    let [least, greatest] = ["least", "greatest"].map(|key| number(speeds, key));
    assert!(greatest < least && least < -1.5, "{many}");
    let of_runs = many["runs"].as_array().unwrap();
    let is_signed =
        |run: &Value| number(run, "mean_speed_m_s") < 0.0 && number(run, "speed_at_end_m_s") < 0.0;
    assert!(of_runs.iter().all(is_signed), "{many}");
}

/// A leg touches down once, however often its foot rattles where it stands.
#[test]
fn touch_downs_are_those_of_legs_in_any_step() {
    let folder = Folder::new("run-touch-downs");
    let line = "run fixed --seconds 4 --disturb torque=5@0.5:0.7s";
    let steps = ["", " --step 0.5ms", " --exact"];
    let counts = steps.map(|step| {
        let run = json(&folder, &format!("{line}{step}"), 0);
        assert!(
            number(&run, "touch_downs") <= 1.5 * number(&run, "firings"),
            "{run}"
        );
        number(&run, "touch_downs")
    });
    assert!(
        counts.iter().all(|count| (count - counts[0]).abs() <= 1.0),
        "{counts:?}"
    );
}

/// What a run does not come to has not disturbed it.
#[test]
fn only_what_was_there_disturbs() {
    let folder = Folder::new("run-disturbed");
    let line = "run fixed --seconds 1 --disturb torque=5@0.5:0.7s --disturb force=1@2:3s --disturb slope=3@50:60m";
    let run = json(&folder, line, 0);
    assert_eq!(
        run["disturbances"],
        serde_json::json!(["torque=5@0.5:0.7s"])
    );
    let not_met = serde_json::json!(["force=1@2:3s", "slope=3@50:60m"]);
    assert_eq!(run["disturbances_not_met"], not_met);
    let text = folder.done(line, 0);
    for words in [
        "  disturbed by       torque=5@0.5:0.7s\n",
        "  not disturbed by   force=1@2:3s: the run ends before it, at 1 s\n",
        "  not disturbed by   slope=3@50:60m: the robot does not come there\n",
    ] {
        assert!(text.contains(words), "{text}");
    }
    let many = folder.done(&format!("{line} --robots 2"), 0);
    assert!(
        many.contains("not disturbed by         force=1@2:3s"),
        "{many}"
    );
    let csv = folder.run(
        &format!("{line} --format csv")
            .split(' ')
            .collect::<Vec<_>>(),
    );
    assert!(
        csv.err.contains("not disturbed by force=1@2:3s"),
        "{}",
        csv.err
    );
}

/// Legs that are closer lean less; a smooth law starts each of these robots, and so do lines.
#[test]
fn robots_with_many_legs_start() {
    let folder = Folder::new("run-legs");
    for legs in [5, 6, 7, 8, 10, 12] {
        for gait in ["smooth", "smooth --aim sparing"] {
            let run = json(
                &folder,
                &format!("run {gait} --set body.legs={legs} --seconds 3"),
                0,
            );
            assert!(number(&run, "travel_m") > 2.0, "{legs}: {run}");
        }
        let first = "run closed-loop --seconds 0.1 --format csv";
        let (header, rows_of) = rows(&folder.done(&format!("{first} --set body.legs={legs}"), 0));
        let lean = header.iter().position(|it| it == "lean_rad").unwrap();
        // The leg in the zone is the rear one, half a pitch behind the upright.
        let lean = rows_of[0][lean].parse::<f64>().unwrap();
        let half = std::f64::consts::PI / f64::from(legs);
        assert!((lean - half).abs() < 0.01, "{legs}: {lean}");
    }
}

/// Nothing moves a robot that never fires: no number of its report is round-off.
#[test]
fn what_stands_has_no_speed() {
    let folder = Folder::new("run-stands");
    let text = folder.done("run fixed --valve-open 0 --seconds 2", 1);
    let numbers = text.lines().filter(|line| !line.contains("unexplained"));
    assert!(numbers.clone().count() > 10);
    for line in numbers {
        assert!(!line.contains("e-"), "{line}");
    }
}

/// Rows stream; what the summary says is in them.
#[test]
fn csv_has_a_row_a_cycle() {
    let folder = Folder::new("run-csv");
    let (header, rows_of) = rows(&folder.done(&format!("{PUSHED} --format csv"), 0));
    let expected = "time_s,x_m,height_m,vx_m_s,vz_m_s,wheel_angle_rad,wheel_rate_rad_s,leg_in_zone,\
                    lean_rad,filtered_rate_rad_s,firing_angle_rad,fired_leg,valve_open_s,stalled,\
                    extension_0_m,extension_1_m,extension_2_m,extension_3_m,extension_4_m,\
                    pressure_0_pa,pressure_1_pa,pressure_2_pa,pressure_3_pa,pressure_4_pa,\
                    valve_open_0_s,valve_open_1_s,valve_open_2_s,valve_open_3_s,valve_open_4_s";
    assert_eq!(header.join(","), expected);
    assert_eq!(rows_of.len(), 3000);
    let column = |name: &str| header.iter().position(|it| it == name).unwrap();
    let (fired, open, time, lean, angle) = (
        column("fired_leg"),
        column("valve_open_s"),
        column("time_s"),
        column("lean_rad"),
        column("firing_angle_rad"),
    );
    let mut firings = 0;
    for (k, row) in rows_of.iter().enumerate() {
        assert_eq!(row.len(), header.len());
        let value = |at: usize| row[at].parse::<f64>().unwrap();
        assert!((value(time) - 1e-3 * k as f64).abs() < 1e-9);
        assert_eq!(row[fired].is_empty(), row[open].is_empty());
        if !row[fired].is_empty() {
            firings += 1;
            assert!(value(lean) >= value(angle), "{row:?}");
        }
    }
    let run = json(&folder, PUSHED, 0);
    assert_eq!(run["firings"], firings);
    // The same in a file, which says what it is by its name.
    folder.done(&format!("{PUSHED} --out run.csv"), 0);
    let text = std::fs::read_to_string(folder.path("run.csv")).unwrap();
    assert_eq!(rows(&text).1, rows_of);
    let stalled = folder.run(
        &"run fixed --seconds 3 --format csv --out s.csv"
            .split(' ')
            .collect::<Vec<_>>(),
    );
    assert_eq!(stalled.code, Some(1));
    assert!(stalled.err.contains("the robot stalled"), "{}", stalled.err);
    assert!(folder.path("s.csv").exists());
}

/// A run of a day ends when nobody reads its rows any more.
#[test]
fn rows_stream_and_stop_with_their_reader() {
    let folder = Folder::new("run-stream");
    let line = format!(
        "{} --seconds 86400 --format csv",
        PUSHED.replace(" --seconds 3", "")
    );
    let mut child = Command::new(env!("CARGO_BIN_EXE_saltus"))
        .args(line.split(' '))
        .current_dir(folder.path("."))
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut reader = BufReader::new(child.stdout.take().unwrap());
    for _ in 0..2000 {
        let mut text = String::new();
        assert!(reader.read_line(&mut text).unwrap() > 100, "{text}");
    }
    drop(reader);
    assert_eq!(child.wait().unwrap().code(), Some(0));
}

#[test]
fn telemetry_is_a_folder_with_readings() {
    let folder = Folder::new("run-telemetry");
    let line = "run fixed --seconds 0.5 --taps 0.5,0.5 --telemetry logs --out run.csv";
    folder.done(line, 0);
    let mut names: Vec<String> = std::fs::read_dir(folder.path("logs"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "cycles.csv",
            "experiment.toml",
            "robot.toml",
            "run.csv",
            "settings.toml"
        ]
    );
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let (header, logged) = rows(&read("logs/cycles.csv"));
    let (plain, motion) = rows(&read("run.csv"));
    assert_eq!(header[..plain.len()], plain[..]);
    assert_eq!((logged.len(), motion.len()), (500, 500));
    assert!(
        logged
            .iter()
            .zip(&motion)
            .all(|(a, b)| a[..b.len()] == b[..])
    );
    assert_eq!(header.len() - plain.len(), 9);
    // A count of the wheel's encoder is 2π/800, and the wheel starts at 36° on its rear leg.
    let wheel = header
        .iter()
        .position(|it| it == "wheel_encoder_counts")
        .unwrap();
    assert_eq!(logged[0][wheel], "80");
    let (columns, measured) = rows(&read("logs/run.csv"));
    let boom = "pivot_angle_rad,radius_angle_rad";
    let valves = "valve_1,valve_2,valve_3,valve_4,valve_5";
    assert_eq!(
        columns.join(","),
        format!("time_s,{valves},wheel_angle_rad,wheel_rate_rad_s,{boom}")
    );
    let angle: f64 = measured[0][6].parse().unwrap();
    assert!((angle - 36f64.to_radians()).abs() < 1e-12, "{angle}");
    let texts = read("logs/experiment.toml") + &read("logs/settings.toml");
    for key in [
        "kind = \"run\"",
        "file = \"run.csv\"",
        "supply_pressure_gauge_pa = 827370.",
        "pivot_angle_rad = 0.003926",
        "taps = [0.5, 0.5]",
        "period_s = 0.001",
    ] {
        assert!(texts.contains(key), "{texts}");
    }
    // The robot runs again as it is written.
    let again = json(
        &folder,
        "run fixed --seconds 0.5 --taps 0.5,0.5 --robot logs/robot.toml",
        0,
    );
    let first = json(&folder, "run fixed --seconds 0.5 --taps 0.5,0.5", 0);
    assert_eq!(again["travel_m"], first["travel_m"]);
}

/// Looking changes nothing, and the same command gives the same bytes.
#[test]
fn what_is_written_beside_changes_no_number() {
    let folder = Folder::new("run-beside");
    let alone = folder.done(PUSHED, 0);
    let beside = "--animate run.html --plot run.svg --telemetry logs";
    assert_eq!(folder.done(&format!("{PUSHED} {beside}"), 0), alone);
    let page = std::fs::read_to_string(folder.path("run.html")).unwrap();
    assert!(
        page.contains("\"firings\":") && !page.contains("@STYLE@") && !page.contains("@SCENE@")
    );
    let plot = std::fs::read_to_string(folder.path("run.svg")).unwrap();
    // The thesis' axes of figure 5.3.
    for words in [
        "wheel angle (rad)",
        "rate (rad/s)",
        "α_f (rad)",
        "speed (m/s)",
        "150",
        "−50",
    ] {
        assert!(plot.contains(words), "{words}");
    }
    let exact = "run fixed --seconds 1 --exact";
    let alone = folder.done(exact, 0);
    assert_eq!(folder.done(&format!("{exact} --animate e.html"), 0), alone);
}

#[test]
fn drawn_robots_are_the_same_for_any_number_of_threads() {
    let folder = Folder::new("run-robots");
    let line = "run closed-loop --seconds 2 --robots 6 --seed 3";
    for format in ["text", "json", "csv"] {
        let one = folder.done(&format!("{line} --format {format} --threads 1"), 0);
        for threads in [2, 5] {
            let more = folder.done(&format!("{line} --format {format} --threads {threads}"), 0);
            assert_eq!(one, more, "{format}, {threads} threads");
        }
    }
    let all: Value =
        serde_json::from_str(&folder.done(&format!("{line} --format json"), 0)).unwrap();
    assert_eq!(all["runs"].as_array().unwrap().len(), 6);
    for (k, least) in [(0, 1.5), (1, 2.5)] {
        let share = &all["running"][k];
        assert_eq!(number(share, "from_m_s"), least);
        let over = all["runs"].as_array().unwrap().iter();
        let over = over
            .filter(|run| number(run, "mean_speed_m_s") > least)
            .count();
        assert_eq!(share["count"], over);
        let [low, high] = [0, 1].map(|end| share["interval_95"][end].as_f64().unwrap());
        let value = number(share, "share");
        assert!(low <= value && value <= high && low < high);
    }
    // Robot k does not depend on how many there are.
    let (_, six) = rows(&folder.done(&format!("{line} --format csv"), 0));
    let (_, two) = rows(&folder.done(
        "run closed-loop --seconds 2 --robots 2 --seed 3 --format csv",
        0,
    ));
    assert_eq!(six[..2], two[..]);
}

/// What each flag does to a gait, in the firing angle of the first cycle.
#[test]
fn gaits_fire_where_their_flags_say() {
    let folder = Folder::new("run-gaits");
    let check = |flags: &str, angle: f64, open: f64| {
        let line =
            format!("run {flags} --seconds 0.002 --set sensors.gyro_noise_rad_s=0 --format csv");
        let (header, rows_of) = rows(&folder.done(&line, 0));
        let column = |name: &str| header.iter().position(|it| it == name).unwrap();
        let value = |name: &str| rows_of[0][column(name)].parse::<f64>().unwrap();
        assert!(
            (value("firing_angle_rad") - angle).abs() < 1e-4,
            "{flags}: {rows_of:?}"
        );
        assert!((value("valve_open_s") - open).abs() < 1e-12, "{flags}");
    };
    check("fixed", 0.1, 0.04);
    check("fixed --alpha-f 6deg --valve-open 30ms", 0.10472, 0.03);
    // 0.175 (1 + tanh 3) of a change of 0.35 is yet to come.
    check("open-loop --centre printed", 0.349_133, 0.04);
    check("open-loop", 0.349_999, 0.04);
    check(
        "open-loop --from 0.4 --to 0.1 --steepness 1 --shift 0 --centre printed",
        0.25,
        0.04,
    );
    check("closed-loop --from 0.3", 0.3, 0.04);
    check("closed-loop --lines one", 0.35, 0.04);
    check("curve --knots 0:0.2:35ms,10:0:40ms", 0.2, 0.035);
}

/// A law of the search starts by itself and gets fast; a demanded speed is held, and turned round.
#[test]
fn smooth_laws_start_and_speeds_are_held() {
    let folder = Folder::new("smooth-and-speed");
    let smooth = json(&folder, "run smooth --seconds 5", 0);
    assert!(number(&smooth, "time_to_1_6_m_s") < 2.0, "{smooth}");
    let held = json(&folder, "run speed --speed 0:2 --seconds 10", 0);
    let speed = number(&held, "mean_speed_last_4_s_m_s");
    assert!((speed - 2.0).abs() < 0.1, "{speed}");
    let turned = json(&folder, "run speed --speed 0:1.5,4:-1.5 --seconds 14", 0);
    let speed = number(&turned, "mean_speed_last_4_s_m_s");
    assert!((speed + 1.5).abs() < 0.1, "{speed}");
    // Below the speeds of the measured firing angles later ones hold it, which is worth no warning; above them none does.
    let words = |line: &str| folder.run(&line.split(' ').collect::<Vec<_>>());
    let slow = words("run speed --speed 0:0.8 --seconds 12 --format json");
    assert_eq!(slow.err, "");
    let slow: Value = serde_json::from_str(&slow.out).unwrap();
    let speed = number(&slow["demanded"][0], "mean_of_second_half_m_s");
    assert!((speed - 0.8).abs() < 0.05, "{speed}");
    let fast = words("run speed --speed 0:6 --seconds 1 --format json");
    assert!(
        fast.err.contains("--speed 0:6: the robot was measured"),
        "{}",
        fast.err
    );
}

/// Words after `saltus run`, and what the message must contain.
const CASES: &[(&str, &[&str])] = &[
    (
        "jog",
        &[
            "run jog: must be a gait",
            "fixed, open-loop, closed-loop, curve",
        ],
    ),
    (
        "fixed --firing-angle 1.4",
        &[
            "--firing-angle (firing angle (rad) = 1.4)",
            "active zone, from 0 to below 1.2566 rad",
            "--zone moves it",
        ],
    ),
    (
        "fixed --firing-angle -0.1",
        &["--firing-angle (firing angle (rad) = -0.1)", "active zone"],
    ),
    ("closed-loop --zone 0", &["--to", "= -0.1)", "active zone"]),
    (
        "closed-loop --first-slope -1",
        &["--first-slope, --switch (firing angle (rad) = -4.65)"],
    ),
    (
        "closed-loop --zone 1",
        &["--zone", "= 1)", "from -0.6283 to 0.6283 rad"],
    ),
    (
        "closed-loop --switch 14",
        &["--switch 14", "below --top-rate, 13.3 rad/s"],
    ),
    ("closed-loop --top-rate 0", &["--top-rate", "above 0 rad/s"]),
    (
        "closed-loop --firing-angle 0.1",
        &["unexpected argument '--firing-angle'"],
    ),
    ("fixed --lines two", &["unexpected argument '--lines'"]),
    (
        "closed-loop --lines one --switch 3",
        &["--switch", "--lines two or jump, not one"],
    ),
    ("curve", &["--knots <RATE:ANGLE:TIME,…>"]),
    ("curve --knots 0:0.1", &["RATE:ANGLE:TIME"]),
    (
        "curve --knots 5:0.1:40ms,4:0.1:40ms",
        &["rate 4 rad/s must not be below the one before it, 5 rad/s"],
    ),
    ("curve --knots 5:0.1:2s", &["2 s must be from 0 to 1 s"]),
    (
        "curve --knots 5:0.1:40ms --valve-open 40ms",
        &["unexpected argument '--valve-open'"],
    ),
    ("speed", &["--speed <TIME:SPEED,…>"]),
    ("speed --speed 1.5", &["TIME:SPEED"]),
    (
        "speed --speed 4:1,2:3",
        &["time 2 s must be after the one before it, 4 s"],
    ),
    ("speed --speed 0:11", &["a speed from -10 to 10 m/s"]),
    (
        "speed --speed 0:1 --direction backwards",
        &["unexpected argument '--direction'"],
    ),
    ("--speed 0:1", &["run --speed: must be a gait"]),
    (
        "--gait speed --speed 0:1",
        &["saltus run speed --speed 0:1 --seconds 0.1"],
    ),
    (
        "speed --speed 0:1 --aim quick",
        &["unexpected argument '--aim'"],
    ),
    (
        "smooth --valve-open 40ms",
        &["unexpected argument '--valve-open'"],
    ),
    (
        "closed-loop --valve-open 2s",
        &["--valve-open", "= 2)", "from 0 to 1 s"],
    ),
    ("closed-loop --valve-open -1", &["--valve-open", "\"-1\""]),
    (
        "closed-loop --seconds 0",
        &["--seconds", "above 0 and up to 100000 s"],
    ),
    (
        "closed-loop --seconds 1e6",
        &["--seconds", "above 0 and up to 100000 s"],
    ),
    ("closed-loop --step 1", &["--step", "0.000001 to 0.1 s"]),
    (
        "closed-loop --step 1ms --exact",
        &["cannot be used with '--exact'"],
    ),
    (
        "closed-loop --taps 1,-1",
        &["--taps", "sum 0 must be a number other than 0"],
    ),
    ("closed-loop --taps ,", &["--taps", "must be a number"]),
    (
        "closed-loop --taps 1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1,1",
        &["17 weights are too many: at most 16"],
    ),
    (
        "closed-loop --disturb wind=3@0:1s",
        &["\"wind\" must be one of slope, force, torque, supply, friction"],
    ),
    (
        "closed-loop --disturb slope=50@0:1s",
        &["slope \"50\"", "from -40.11 to 40.11 deg", "deg, rad"],
    ),
    (
        "closed-loop --disturb slope=3@1:0s",
        &["\"1:0s\"", "TO above FROM"],
    ),
    ("closed-loop --disturb slope=3@1:2", &["FROM:TO in s or m"]),
    ("closed-loop --disturb slope=3", &["WHAT=VALUE@FROM:TO"]),
    (
        "closed-loop --disturb friction=-1@0:1s",
        &["friction \"-1\"", "from 0 to 10000"],
    ),
    (
        "closed-loop --disturb slope=39@0:1s --set ground.tilt_deg=5",
        &["--disturb slope=39@0:1s", "ground.tilt_deg"],
    ),
    (
        "closed-loop --disturb supply=100@0:1s --robot spring-hopper",
        &["--disturb supply=100@0:1s", "pneumatic"],
    ),
    (
        "closed-loop --set body.legs=2",
        &["body.legs = 2: must be from 3 to 12"],
    ),
    (
        "closed-loop --set body.legs=13",
        &["body.legs = 13: must be from 3 to 12"],
    ),
    (
        "closed-loop --set sensors.fine_gyro_range_deg_s=0",
        &["sensors.fine_gyro_range_deg_s = 0", "> 0"],
    ),
    (
        "closed-loop --set sensors.period_ms=0",
        &["sensors.period_ms = 0", "> 0"],
    ),
    (
        "closed-loop --set sensors.accelerometer_bias_m_s2=9",
        &[
            "cannot tell on which two feet it stands",
            "differs from gravity",
        ],
    ),
    (
        "closed-loop --set ground.slope_deg=30",
        &[
            "cannot tell on which two feet it stands",
            "between two poses",
        ],
    ),
    ("closed-loop --robots 0", &["--robots", "from 1 to 100000"]),
    (
        "closed-loop --robots 3 --plot x.svg",
        &["--robots", "cannot be used with '--plot"],
    ),
    (
        "closed-loop --robots 3 --robot spring-hopper",
        &["--robots", "pneumatic legs"],
    ),
    ("closed-loop --drawn-across 0.02", &["--robots <COUNT>"]),
    (
        "closed-loop --animate x.html --seconds 61",
        &["--animate", "--seconds 60 at most, not 61"],
    ),
    ("closed-loop --animate x.txt", &["--animate", ".html"]),
    (
        "closed-loop --telemetry full",
        &["--telemetry full", "a new or an empty folder"],
    ),
    ("closed-loop --out x.pdf", &["--out x.pdf", ".csv"]),
    (
        "closed-loop --out nowhere/x.csv",
        &["nowhere/x.csv", "its folder is not there"],
    ),
    (
        "closed-loop --animate nowhere/x.html",
        &["nowhere/x.html", "its folder is not there"],
    ),
    (
        "closed-loop --plot a.svg --out a.svg --format json",
        &["--plot a.svg", "another file than --out"],
    ),
    (
        "closed-loop --robot robot.toml --out robot.toml --format csv",
        &[
            "--out robot.toml",
            "another file than those that this command reads",
        ],
    ),
];

#[test]
fn bad_input_is_named_and_leaves_no_file() {
    let folder = Folder::new("run-bad");
    std::fs::create_dir(folder.path("full")).unwrap();
    folder.write("full/a", "");
    folder.write("robot.toml", include_str!("../../../robots/rats-run.toml"));
    let listed = || {
        let mut names: Vec<_> = std::fs::read_dir(folder.path("."))
            .unwrap()
            .map(|entry| entry.unwrap().file_name())
            .collect();
        names.sort();
        names
    };
    let before = listed();
    for (words, expected) in CASES {
        let line = format!("run {words} --seconds 0.1");
        let line = if words.contains("--seconds") {
            format!("run {words}")
        } else {
            line
        };
        let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
        assert_eq!(run.code, Some(2), "{words}: {}{}", run.out, run.err);
        for part in *expected {
            assert!(run.err.contains(part), "{words}: {} lacks {part}", run.err);
        }
        assert_eq!(run.out, "", "{words}");
        assert_eq!(listed(), before, "{words}");
    }
}

/// A motion that cannot go on ends a run that has written rows: no file, no folder is left.
#[test]
fn a_run_that_cannot_go_on_leaves_nothing() {
    let folder = Folder::new("run-broken");
    folder.write("old.csv", "as it was\n");
    let line = "run fixed --seconds 3 --disturb torque=9999@0.1:3s --step 0.02 \
                --out old.csv --telemetry logs --plot p.svg --animate a.html";
    let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(2), "{}{}", run.out, run.err);
    assert!(run.err.contains("rats-run: "), "{}", run.err);
    assert_eq!(
        std::fs::read_to_string(folder.path("old.csv")).unwrap(),
        "as it was\n"
    );
    let names: Vec<_> = std::fs::read_dir(folder.path(".")).unwrap().collect();
    assert_eq!(names.len(), 1, "{names:?}");
}
