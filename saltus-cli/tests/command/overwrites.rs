//! What a command reads it does not overwrite, and what killed runs leave goes.

use crate::common::Folder;

const COURSE: &str = "approach_rate_rad_s = 5\ntarget_x_m = 0.8\n";
const BATCH: &str = "omega0_rad_s,phi0_rad,alpha_f_rad,valve_open_s\n5,-0.1,-0.1,0.1\n";

/// Runs `line`, which must be refused because of `flag`, and leave every file of the folder as it
/// is.
#[track_caller]
fn refused(folder: &Folder, line: &str, flag: &str) {
    let before = contents(folder, ".");
    let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(2), "{line}: {}", run.out);
    assert!(
        run.err.contains(flag) && run.err.contains("must be another file than"),
        "{line}: {}",
        run.err
    );
    assert_eq!(run.out, "", "{line}");
    assert_eq!(contents(folder, "."), before, "{line}");
}

/// Names and contents of all files below a folder.
fn contents(folder: &Folder, below: &str) -> Vec<(String, Vec<u8>)> {
    let mut all = Vec::new();
    for name in folder.names_in(below) {
        let name = format!("{below}/{name}");
        if folder.path(&name).symlink_metadata().unwrap().is_dir() {
            all.extend(contents(folder, &name));
        } else {
            all.push((
                name.clone(),
                std::fs::read(folder.path(&name)).unwrap_or_default(),
            ));
        }
    }
    all
}

#[test]
fn no_command_overwrites_what_it_reads() {
    let folder = Folder::new("overwrites");
    folder.write("c.toml", COURSE);
    folder.write("jumps.csv", BATCH);
    folder.write("robot.toml", saltus::Robot::rats_planar().to_toml());
    folder.write("drawn.svg", COURSE);
    std::fs::create_dir(folder.path("in")).unwrap();
    folder.done("inject --kind bench --runs 3 --out d", 0);
    let cases = [
        ("plan c.toml --format text --out c.toml", "--out c.toml"),
        ("plan c.toml --format text --out ./in/../c.toml", "--out"),
        ("plan drawn.svg --plot drawn.svg", "--plot"),
        (
            "verify c.toml --samples 0 --format text --out c.toml",
            "--out",
        ),
        ("simulate --batch jumps.csv --out jumps.csv", "--out"),
        (
            "table --omega 5 --distance 0.6 --robot robot.toml --format text --out robot.toml",
            "--out",
        ),
        ("export mjcf --robot robot.toml --out robot.toml", "--out"),
        ("export urdf --robot robot.toml --out robot.toml", "--out"),
        ("fit d --robot-out d/experiment.toml", "--robot-out"),
        ("fit d --out d/run-01.csv", "--out"),
        ("diagnose d --out d/run-02.csv", "--out"),
        ("diagnose d --format text --out d/experiment.toml", "--out"),
    ];
    for (line, flag) in cases {
        refused(&folder, line, flag);
    }
    // In a data folder there is place for what is new.
    folder.done("diagnose d --out d/report.txt", 0);
    folder.done("diagnose d --out d/report.txt", 0);
}

#[test]
fn a_corrected_robot_does_not_overwrite_the_data() {
    let folder = Folder::new("overwrites-extend");
    folder.done("inject coulomb-friction=25 --runs 3 --out d", 0);
    refused(
        &folder,
        "diagnose d --most 1 --extend d/experiment.toml",
        "--extend",
    );
    refused(
        &folder,
        "diagnose d --most 1 --extend r.toml --format text --out r.toml",
        "--extend",
    );
}

#[test]
#[cfg(unix)]
fn links_are_seen_through() {
    let folder = Folder::new("overwrites-links");
    folder.write("c.toml", COURSE);
    std::os::unix::fs::symlink("c.toml", folder.path("soft.json")).unwrap();
    std::fs::hard_link(folder.path("c.toml"), folder.path("hard.json")).unwrap();
    std::os::unix::fs::symlink(".", folder.path("here")).unwrap();
    std::fs::hard_link(folder.path("c.toml"), folder.path("page.html")).unwrap();
    refused(
        &folder,
        "verify c.toml --samples 0 --animate page.html",
        "--animate",
    );
    for name in ["soft.json", "hard.json", "here/soft.json", "here/hard.json"] {
        refused(&folder, &format!("plan c.toml --out {name}"), "--out");
        refused(
            &folder,
            &format!("plan {name} --format text --out c.toml"),
            "--out",
        );
    }
}

#[test]
#[cfg(unix)]
fn two_outputs_are_two_files() {
    let folder = Folder::new("overwrites-two");
    folder.write("c.toml", COURSE);
    folder.write("a.svg", "an older one");
    std::fs::hard_link(folder.path("a.svg"), folder.path("b.txt")).unwrap();
    refused(
        &folder,
        "plan c.toml --plot a.svg --format text --out a.svg",
        "--plot",
    );
    refused(&folder, "plan c.toml --plot a.svg --out b.txt", "--plot");
    // No file of both is there yet.
    refused(
        &folder,
        "plan c.toml --plot new.svg --format text --out ./new.svg",
        "--plot",
    );
}

/// A process that has ended, and one that has not.
#[test]
#[cfg(target_os = "linux")]
fn what_a_killed_run_left_goes() {
    let folder = Folder::new("overwrites-swept");
    let mut ended = std::process::Command::new("true").spawn().unwrap();
    ended.wait().unwrap();
    let (gone, lives) = (
        format!(".saltus-{}-0.tmp", ended.id()),
        format!(".saltus-{}-0.tmp", std::process::id()),
    );
    folder.write(&gone, "half of a report");
    folder.write(&lives, "half of a report");
    folder.write(".saltus-notes.tmp", "not one of these");
    folder.done("table --omega 5 --distance 0.6 --out t.csv", 0);
    assert_eq!(
        folder.names(),
        [lives, ".saltus-notes.tmp".into(), "t.csv".into()]
    );
    // A folder for data that a killed run has begun.
    std::fs::create_dir_all(folder.path(&format!("d/{gone}/runs"))).unwrap();
    folder.write(&format!("d/{gone}/runs/run-01.csv"), "half of a run");
    folder.done("inject --kind flight --out d", 0);
    assert!(
        folder
            .names_in("d")
            .iter()
            .all(|name| !name.starts_with('.')),
        "{:?}",
        folder.names_in("d")
    );
    assert!(folder.names_in("d").contains(&"experiment.toml".to_owned()));
}

#[test]
fn data_are_written_whole_or_not_at_all() {
    let folder = Folder::new("overwrites-whole");
    // The folder of a run is a file: a run cannot be written.
    folder.write("d", "a file");
    let run = folder.run(&["inject", "--kind", "flight", "--out", "d/data"]);
    assert_eq!(run.code, Some(2), "{}", run.out);
    assert_eq!(folder.names(), ["d"]);
}

#[test]
fn a_course_is_read_from_standard_input() {
    use std::io::Write;
    use std::process::{Command, Stdio};
    let mut run = Command::new(env!("CARGO_BIN_EXE_saltus"))
        .args(["plan", "-", "--format", "json"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    run.stdin
        .take()
        .unwrap()
        .write_all(COURSE.as_bytes())
        .unwrap();
    let output = run.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(0));
    assert!(
        String::from_utf8(output.stdout)
            .unwrap()
            .contains("\"jumps\"")
    );
}

#[test]
fn endings_that_stand_for_no_format_are_refused() {
    let folder = Folder::new("overwrites-endings");
    let run = folder.run(&[
        "table",
        "--omega",
        "5",
        "--distance",
        "0.6",
        "--out",
        "x.xlsx",
    ]);
    assert_eq!(run.code, Some(2));
    assert!(
        run.err
            .contains("--out x.xlsx: must be a name that ends in .json, .csv, .txt, .md"),
        "{}",
        run.err
    );
    for out in ["x", "x.txt", "x.csv", "x.xlsx --format csv"] {
        folder.done(&format!("table --omega 5 --distance 0.6 --out {out}"), 0);
    }
}
