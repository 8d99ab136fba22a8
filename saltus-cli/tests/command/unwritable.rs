//! Every command refuses an output that cannot be written before it works.

use std::collections::BTreeSet;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::Folder;
use crate::golden;

/// Each command with work that takes minutes, or with an input that is not there: a refusal that
/// names the output comes before both.
const LONG: &[(&str, &str)] = &[
    ("simulate", "--omega 0:10:1000 --alpha-f -1:1:1000"),
    ("table", "--omega 3:6:1000 --distance 0.3:1:1000"),
    ("law", "--omega 3:6:1000 --distance 0.3:1:1000"),
    (
        "map",
        "--omega 3:6:1000 --alpha-f -1:1:1000 --plant rats-boom",
    ),
    ("plan", "nowhere.toml"),
    ("verify", "nowhere.toml"),
    ("run smooth", "--seconds 1000 --exact"),
    ("run fixed", "--seconds 1000 --exact"),
    ("run fixed", "--seconds 1000 --robots 1000 --exact"),
    ("run disc-stable", "--robot rats-twelve --seconds 60"),
    (
        "run disc-stable",
        "--robot rats-twelve --seconds 60 --robots 1000",
    ),
    (
        "filling",
        "--omega 4.5 --alpha-f -0.1 --set tank.volume_l=5000",
    ),
    ("jump", "--obstacle 0.21x0.21@1.3"),
    ("jump", "--obstacle 0.21x0.21@1:6"),
    ("learn", "run-legs"),
    ("diagnose", "nowhere"),
    ("design", "nowhere.toml"),
    ("inject", "--kind tank-leg"),
    ("fit", "nowhere"),
    ("export c", "--distance 0.3:0.8:1000 --omega 3:6:1000"),
    ("export rust", "--distance 0.3:0.8:1000 --omega 3:6:1000"),
    ("export policy", "nowhere.json"),
    ("export gait speed", "--robot nowhere.toml"),
    ("export mjcf", "--robot nowhere.toml"),
    ("export urdf", "--robot nowhere.toml"),
];

/// Flags with a file or a folder that is read.
const READ: &[&str] = &[
    "--robot",
    "--plant",
    "--batch",
    "--path",
    "--believed",
    "--resume",
    "--replan",
    "--law",
    "--check",
];

/// What is said of a file whose folder is not there.
const NO_FOLDER: &str =
    "cannot be written: its folder is not there, and is made only where a command fills a folder";

/// Time in which a refusal has to come on a machine with other work: it takes milliseconds.
const LIMIT: Duration = Duration::from_secs(20);

/// The flags that name a file or a folder which `saltus COMMAND` writes, each with the word of its
/// help for the value: `FILE.svg|FILE.png`.
fn outputs(command: &str) -> Vec<(String, String)> {
    let help = Folder::new(&format!("unwritable-help-{}", command.replace(' ', "-")))
        .done(&format!("{command} --help"), 0);
    let flags = help.lines().filter_map(|line| {
        let (_, rest) = line.split_once("--").filter(|(before, _)| {
            before.trim().is_empty() || before.trim_start().starts_with('-')
        })?;
        let (flag, value) = rest.split_once(" <")?;
        let value = value.strip_suffix('>')?;
        let is_file = value
            .split(['|', '.'])
            .any(|it| ["FILE", "DIR", "FOLDER"].contains(&it));
        is_file.then(|| (format!("--{flag}"), value.to_owned()))
    });
    flags
        .filter(|(flag, _)| !READ.contains(&flag.as_str()))
        .collect()
}

/// Places for a value of this kind that cannot be written.
fn places(value: &str) -> Vec<String> {
    let mut places = Vec::new();
    if ["DIR", "FOLDER"].contains(&value) {
        places.push("file/below".to_owned());
    } else {
        let ending = value.split(['|', '.']).nth(1).unwrap_or("json");
        places.push(format!("nowhere/a.{ending}"));
        places.push(format!("folder.{ending}"));
    }
    // Not even root writes there.
    if cfg!(target_os = "linux") {
        let ending = value.split(['|', '.']).nth(1).unwrap_or("json");
        places.push(format!("/proc/a.{ending}"));
    }
    places
}

/// Runs `line`, which must be refused: whether because of `place`, or of flags that do not go together.
#[track_caller]
fn refused(folder: &Folder, line: &str, place: &str) -> bool {
    let before = folder.names();
    let start = Instant::now();
    let [out, err] = ["out.log", "err.log"].map(|name| folder.path(name));
    let mut child = Command::new(env!("CARGO_BIN_EXE_saltus"))
        .args(line.split_whitespace())
        .current_dir(folder.path("."))
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&out).unwrap())
        .stderr(std::fs::File::create(&err).unwrap())
        .spawn()
        .unwrap();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        if start.elapsed() > LIMIT {
            child.kill().unwrap();
            child.wait().unwrap();
            panic!("{line}: works before it looks at {place}");
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    let [out, err] = [out, err].map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(path).unwrap();
        text
    });
    assert_eq!(status.code(), Some(2), "{line}: {out}{err}");
    if place.starts_with("nowhere/") && !err.contains("cannot be used with") {
        assert!(err.contains(NO_FOLDER), "{line}: {err}");
    }
    let is_named = err.contains(place)
        && (err.contains("cannot be written") || err.contains("must be another file than"));
    // Flags that do not go together are no outputs.
    assert!(
        is_named || err.contains("cannot be used with"),
        "{line}: {err}"
    );
    assert_eq!(out, "", "{line}");
    assert_eq!(folder.names(), before, "{line}");
    is_named
}

#[test]
fn every_command_refuses_an_output_that_cannot_be_written_before_it_works() {
    let folder = Folder::new("unwritable");
    folder.write("file", "");
    for ending in ["json", "svg", "html", "mcap", "toml"] {
        std::fs::create_dir(folder.path(&format!("folder.{ending}"))).unwrap();
    }
    let mut waiting = BTreeSet::new();
    let mut named = BTreeSet::new();
    for (command, work) in LONG {
        for (flag, value) in outputs(command) {
            for place in places(&value) {
                let line = format!("{command} {work} {flag} {place}");
                let line = match *command {
                    "export c" | "export gait speed" | "export policy" if flag != "--out" => {
                        line + " --out made"
                    }
                    _ => line,
                };
                waiting.insert(format!("{command} {flag} {place}"));
                if refused(&folder, &line, &place) {
                    named.insert(format!("{command} {flag} {place}"));
                }
            }
        }
    }
    assert_eq!(waiting, named);
}

/// A folder that a command fills is made, with those that it is in; a word of the command's help has it.
#[test]
fn every_folder_that_a_command_fills_is_made() {
    let folder = Folder::new("unwritable-made");
    let quick = [
        ("inject", "--runs 3"),
        ("run closed-loop", "--seconds 0.2"),
        ("run fixed", "--seconds 0.2"),
        ("run smooth", "--seconds 0.2"),
        ("run disc-stable", "--seconds 0.2"),
        ("export c", "--distance 0.5:0.6:2 --omega 4.5:5.5:3"),
        ("export rust", "--distance 0.5:0.6:2 --omega 4.5:5.5:3"),
        ("export gait speed", ""),
    ];
    let mut tried = BTreeSet::new();
    for (command, _) in LONG {
        for (flag, value) in outputs(command) {
            if !["DIR", "FOLDER"].contains(&value.as_str()) || *command == "export policy" {
                continue;
            }
            if !tried.insert((*command, flag.clone())) {
                continue;
            }
            let (_, work) = quick
                .iter()
                .find(|(known, _)| known == command)
                .unwrap_or_else(|| panic!("{command} {flag}"));
            let made = format!("{}/in/its", command.replace(' ', "-"));
            let line = format!("{command} {work} {flag} {made}");
            let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
            assert!(matches!(run.code, Some(0 | 1)), "{line}: {}", run.err);
            assert!(!folder.names_in(&made).is_empty(), "{line}");
        }
    }
    assert!(tried.len() > 5, "{tried:?}");
}

/// Nor does one work before it looks whether an output is a file that it reads.
#[test]
fn every_command_refuses_to_overwrite_what_it_reads_before_it_works() {
    let folder = Folder::new("unwritable-read");
    for (name, robot) in [("plane", "rats-run"), ("space", "rats-twelve")] {
        let robot = saltus::robot::resolve(robot, &[]).unwrap();
        folder.write(&format!("{name}.toml"), robot.to_toml());
    }
    folder.write("c.toml", "approach_rate_rad_s = 5\ntarget_x_m = 0.8\n");
    for (command, work) in LONG {
        let (work, file) = match *command {
            // A tank is no robot that runs.
            "filling" | "fit" | "learn" | "diagnose" | "design" | "inject" | "export policy" => {
                continue;
            }
            "export mjcf" | "export urdf" => ("", "plane.toml"),
            "plan" => ("c.toml", "plane.toml"),
            "verify" => ("c.toml --samples 100000", "plane.toml"),
            _ if work.contains("rats-twelve") => (*work, "space.toml"),
            _ => (*work, "plane.toml"),
        };
        let work = work.replace("--robot rats-twelve", "");
        let format = if command.starts_with("export") {
            ""
        } else {
            "--format text"
        };
        if command.starts_with("export") && !["export mjcf", "export urdf"].contains(command) {
            continue;
        }
        let line = format!("{command} {work} --robot {file} {format} --out {file}");
        assert!(refused(&folder, &line, file), "{line}");
    }
}

/// No command with an output is left out above.
#[test]
fn every_command_with_an_output_is_tried() {
    let folder = Folder::new("unwritable-all");
    let tried: BTreeSet<&str> = LONG.iter().map(|(command, _)| *command).collect();
    for name in golden::commands(&folder.done("--help", 0)) {
        let help = folder.done(&format!("{name} --help"), 0);
        let below = golden::commands(&help);
        for command in if below.is_empty() {
            vec![name]
        } else {
            below.iter().map(|it| format!("{name} {it}")).collect()
        } {
            let is_tried = tried.contains(command.as_str());
            assert_eq!(is_tried, !outputs(&command).is_empty(), "{command}");
        }
    }
}
