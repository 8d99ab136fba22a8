//! Tables as files: they say what they were made for, are held to it, and are read back; plots of
//! them say what they show.

use crate::common::{Folder, rows};

/// The cell of the first row under a name.
fn cell(text: &str, name: &str) -> String {
    let (header, rows) = rows(text);
    rows[0][header.iter().position(|h| h == name).unwrap()].clone()
}

/// `text` without the columns of these names.
fn without(text: &str, names: &[&str]) -> String {
    let (header, rows) = rows(text);
    let kept: Vec<usize> = (0..header.len())
        .filter(|&i| !names.contains(&header[i].as_str()))
        .collect();
    let line = |row: &Vec<String>| {
        kept.iter()
            .map(|&i| row[i].clone())
            .collect::<Vec<_>>()
            .join(",")
            + "\n"
    };
    std::iter::once(&header).chain(&rows).map(line).collect()
}

#[track_caller]
fn refused(folder: &Folder, line: &str, parts: &[&str]) {
    let run = folder.run(&line.split_whitespace().collect::<Vec<_>>());
    assert_eq!(run.code, Some(2), "{line}: {} {}", run.out, run.err);
    for part in parts {
        assert!(
            run.err.contains(part),
            "{line}: {part:?} is not in {}",
            run.err
        );
    }
}

#[test]
fn a_table_says_what_it_was_made_for() {
    let folder = Folder::new("table-says");
    let text = folder.done(
        "table --omega 4:6:3 --distance 0.6 --landing-height 0.2 --valve-open 50ms --format csv",
        0,
    );
    assert_eq!(
        (cell(&text, "robot"), cell(&text, "saltus_version")),
        ("rats-planar".into(), env!("CARGO_PKG_VERSION").into())
    );
    assert_eq!(
        (cell(&text, "landing_height_m"), cell(&text, "valve_open_s")),
        ("0.20000000000000001".into(), "0.050000000000000003".into())
    );
    assert_eq!(cell(&text, "start_lean_rad"), cell(&text, "alpha_f_rad"));
    assert_eq!(cell(&text, "robot_sha256").len(), 16);
    let law = folder.done(
        "law --omega 4:6:3 --distance 0.6 --start-lean -0.4 --format csv",
        0,
    );
    assert_eq!(
        (cell(&law, "start_lean_rad"), cell(&law, "robot")),
        ("-0.40000000000000002".into(), "rats-planar".into())
    );
    let json = folder.done("map --omega 4 --alpha-f 0 --format json", 0);
    assert!(
        json.contains("\"robot_sha256\"") && json.contains("\"start_lean_rad\": \"firing\""),
        "{json}"
    );
    // A name with commas and quotes is one cell.
    let odd = folder.done(
        "table --omega 5 --distance 0.6 --set name=\"a,b\" --format csv",
        0,
    );
    assert!(odd.contains("\"a,b\""), "{odd}");
}

#[test]
fn a_table_is_verified_as_it_was_made() {
    let folder = Folder::new("table-made");
    for options in [
        "--landing-height 0.2",
        "--start-lean -0.5",
        "--valve-open 30ms",
        "--robot rats-boom --landing-height 0",
    ] {
        folder.noted(
            &format!("table --omega 3:6:4 --distance 0.4 {options} --out table.csv"),
            0,
        );
        let robot = if options.contains("boom") {
            " --robot rats-boom"
        } else {
            ""
        };
        let said = folder.done(
            &format!("verify table.csv --samples 0 --tolerance 2cm{robot}"),
            0,
        );
        assert!(said.contains("PASS"), "{options}: {said}");
    }
    folder.done(
        "table --omega 3:6:4 --distance 0.4 --landing-height 0.2 --start-lean -0.5 --out table.csv",
        0,
    );
    refused(
        &folder,
        "verify table.csv --landing-height wheel",
        &["--landing-height", "must be left out: table.csv says"],
    );
    refused(
        &folder,
        "verify table.csv --start-lean firing",
        &["--start-lean", "must be left out"],
    );
    refused(
        &folder,
        "verify table.csv --valve-open 0.05",
        &["--valve-open", "must be left out"],
    );
    refused(
        &folder,
        "verify table.csv --robot rats-boom",
        &[
            "table.csv:2: made for the robot rats-planar",
            "give --robot rats-planar",
        ],
    );
    refused(
        &folder,
        "verify table.csv --set body.mass_kg=2.6",
        &["with other parameters"],
    );
}

#[test]
fn a_row_that_does_not_land_where_it_says_is_refused() {
    let folder = Folder::new("table-replay");
    let text = folder.done("table --omega 3:6:4 --distance 0.6 --format csv", 0);
    let angle = cell(&text, "alpha_f_rad");
    // The first row fires somewhat later.
    folder.write("late.csv", text.replace(&angle, "0.1"));
    refused(
        &folder,
        "verify late.csv --samples 0",
        &["late.csv:2: land_m = 0.", "lands, which is at 0.7"],
    );
    // A table that does not say what it was made for.
    folder.write("bare.csv", without(&text, &["landing_height_m"]));
    refused(&folder, "verify bare.csv", &["no column landing_height_m"]);
    let height = cell(&text, "landing_height_m");
    folder.write("empty.csv", text.replacen(&format!(",{height},"), ",,", 1));
    refused(
        &folder,
        "verify empty.csv",
        &["empty.csv:2: landing_height_m", "a number"],
    );
    for file in ["tj.json", "table.txt"] {
        folder.write(file, "{}");
        refused(
            &folder,
            &format!("verify {file}"),
            &[file, "reads a course (.toml) or a table"],
        );
    }
}

#[test]
fn a_batch_reads_what_a_table_writes() {
    let folder = Folder::new("table-batch");
    folder.done(
        "table --omega 3:6:4 --distance 0.6,4 --landing-height 0 --out table.csv",
        1,
    );
    let (header, jumps) = rows(&folder.done("simulate --batch table.csv --format csv", 0));
    let column = header.iter().position(|h| h == "land_0_m").unwrap();
    assert_eq!(jumps.len(), 4);
    for jump in jumps {
        assert!(
            (jump[column].parse::<f64>().unwrap() - 0.6).abs() < 1e-7,
            "{jump:?}"
        );
    }
}

#[test]
fn a_robot_that_jumps_too_low_is_not_said_not_to_jump() {
    let folder = Folder::new("no-landing");
    let text = folder.done(
        "table --omega 3 --distance 0.6 --landing-height 5 --format csv",
        1,
    );
    assert_eq!(cell(&text, "status"), "no-landing");
    let none = folder.done("table --omega 9 --distance 0.6 --format csv", 1);
    assert_eq!(cell(&none, "status"), "no-jump");
    let law = folder.done(
        "law --omega 3:6:3 --distance 0.6 --landing-height 5 --format csv",
        1,
    );
    assert_eq!(cell(&law, "status"), "no-landing");
    assert!(
        folder
            .done("law --omega 3:6:3 --distance 0.6 --landing-height 5", 1)
            .contains("takes off")
    );
    assert!(
        folder
            .done("law --omega 9:9.1:2 --distance 0.6", 1)
            .contains("no-jump")
    );
    let map = folder.done(
        "map --omega 3 --alpha-f 0 --landing-height 5 --format csv",
        1,
    );
    assert_eq!(cell(&map, "outcome"), "no-landing");
    let jump = folder.done("simulate --omega 3 --alpha-f 0 --set leg.stroke_m=0.001", 0);
    assert!(!jump.contains("no-jump"), "{jump}");
}

#[test]
fn plots_say_why_they_are_empty_and_what_their_lines_are() {
    let folder = Folder::new("table-plots");
    let svg = |line: &str, code: i32| {
        folder.done(&format!("{line} --plot a.svg"), code);
        folder.read("a.svg")
    };
    assert!(
        svg("table --omega 3:6:3 --distance 4", 1)
            .contains("No angle reaches any distance asked for; the nearest is")
    );
    assert!(
        svg("table --omega 3:6:3 --distance 0.6 --landing-height 5", 1)
            .contains("never comes down to the landing height")
    );
    assert!(svg("law --omega 3:6:3 --distance 4", 1).contains("infeasible: no rate reaches it"));
    assert!(
        svg("map --omega 3:4:3 --alpha-f 0:0.1:3 --landing-height 5", 1).contains("9 no-landing")
    );
    assert!(svg("table --omega 3:6:4 --distance 0.8", 0).contains("thin: the late one"));
    assert!(!svg("table --omega 6:6.1:2 --distance 0.3", 0).contains("thin: the late one"));
    // A level on its line and on the scale beside.
    assert!(
        svg("map --omega 3:6:9 --alpha-f -0.3:0.3:9", 0)
            .matches("\n0.6\n")
            .count()
            >= 2
    );
    let regions = svg("map --omega 2:6:13 --alpha-f -0.5:0.7:13", 0);
    assert!(
        regions.contains("border of stroke and no-landing"),
        "the apex has two regions"
    );
}
