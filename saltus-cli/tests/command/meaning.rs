//! One word, one quantity: distances and approach rates mean the same in every command and in the
//! exported C.

use std::process::Command;

use crate::common::{Folder, rows};
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// The exported files in `folder/out` with `main` in C, run with `words`; none where there is no
/// compiler.
fn run_c(folder: &Folder, out: &str, main: &str, words: &[&str]) -> Option<String> {
    run_with(folder, &format!("{out}/saltus_controller.c"), main, words)
}

/// The same with the exported source `source`.
pub(crate) fn run_with(
    folder: &Folder,
    source: &str,
    main: &str,
    words: &[&str],
) -> Option<String> {
    let (out, _) = source.split_once('/').unwrap();
    let there = Command::new("cc")
        .arg("--version")
        .output()
        .is_ok_and(|said| said.status.success());
    if !there {
        eprintln!("skipped: there is no C compiler here");
        return None;
    }
    folder.write("main.c", main);
    let program = folder.path("main");
    let made = Command::new("cc")
        .args(["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wshadow"])
        .arg("-Werror")
        .arg(format!("-I{}", folder.path(out).display()))
        .args([folder.path("main.c"), folder.path(source)])
        .args(["-lm".as_ref(), "-o".as_ref(), program.as_os_str()])
        .output()
        .unwrap();
    assert!(
        made.status.success(),
        "{}",
        String::from_utf8_lossy(&made.stderr)
    );
    let run = Command::new(&program).args(words).output().unwrap();
    assert!(run.status.success(), "{:?}", run.status);
    Some(String::from_utf8(run.stdout).unwrap())
}

/// Prints the firing angle for the rate, distance and landing height that it is given.
const ANGLE: &str = r#"
#include <stdio.h>
#include <stdlib.h>
#include "saltus_controller.h"
int main(int count, char **words) {
    saltus_real angle;
    if (count != 4 || saltus_self_test() != 0) return 1;
    int status = saltus_firing_angle(strtof(words[1], NULL), strtof(words[2], NULL), strtof(words[3], NULL), &angle);
    if (status != SALTUS_OK) return 2;
    printf("%.9g\n", (double)angle);
    return 0;
}
"#;

#[test]
fn a_distance_ends_where_the_wheel_touches_in_every_command() {
    let folder = Folder::new("one-distance");
    folder.write(
        "course.toml",
        "approach_rate_rad_s = 5\ntarget_x_m = 0.8\n[limits]\nvalve_open_s = [0.1, 0.1]\n",
    );
    let table = json(&folder.done("table --omega 5 --distance 0.8 --format json", 0));
    let angle = table["rows"][0]["alpha_f_rad"].as_f64().unwrap();
    assert_eq!(table["landing_height_m"], 0.24);
    let jump = json(&folder.done(
        &format!("simulate --omega 5 --alpha-f {angle} --format json"),
        0,
    ));
    assert!(
        (jump["jumps"][0]["land_rs_m"].as_f64().unwrap() - 0.8).abs() < 1e-8,
        "{jump}"
    );
    let map = json(&folder.done(&format!("map --omega 5 --alpha-f {angle} --format json"), 0));
    assert!(
        (map["spots"][0]["distance_m"].as_f64().unwrap() - 0.8).abs() < 1e-8,
        "{map}"
    );
    let law = json(&folder.done("law --omega 4.999,5.001 --distance 0.8 --format json", 0));
    let at = |key: &str| law["laws"][0][key].as_f64().unwrap();
    assert!(
        (at("slope_s") * 5.0 + at("intercept_rad") - angle).abs() < 1e-6,
        "{law}"
    );
    // A law for one rate lands there in the multi-body simulation.
    let line =
        format!("verify --law=0,{angle} --omega 5 --distance 0.8 --samples 0 --tolerance 1mm");
    assert!(folder.done(&line, 0).contains("PASS"));
    // The thesis' reading is another jump, and stays an option.
    let thesis = json(&folder.done(
        "table --omega 5 --distance 0.8 --landing-height 0 --format json",
        0,
    ));
    assert!(
        (thesis["rows"][0]["alpha_f_rad"].as_f64().unwrap() + 0.1696).abs() < 1e-4,
        "{thesis}"
    );
}

#[test]
fn every_output_names_the_landing_height_and_the_start() {
    let folder = Folder::new("named");
    for line in [
        "table --omega 5 --distance 0.6",
        "law --omega 4:6:3 --distance 0.6",
        "map --omega 5 --alpha-f 0",
        "export c --distance 0.6 --out c",
        "export rust --distance 0.6",
    ] {
        let wheel = folder.done(line, 0);
        assert!(
            wheel.contains("where the wheel touches") && wheel.contains("at the firing angle"),
            "{wheel}"
        );
        let other = folder.done(
            &format!("{line} --landing-height 10cm --start-lean -0.3"),
            0,
        );
        assert!(
            other.contains("centre is 0.1 m above the foothold"),
            "{other}"
        );
        assert!(
            other.contains("start lean") && other.contains("-0.3 rad"),
            "{other}"
        );
    }
    for line in [
        "table --omega 4:6:3 --distance 0.6",
        "law --omega 4:6:3 --distance 0.6",
        "map --omega 4:6:3 --alpha-f -0.1:0.1:3",
    ] {
        folder.done(&format!("{line} --plot a.svg"), 0);
        assert!(
            folder.read("a.svg").contains("landing height 0.24 m"),
            "{line}"
        );
    }
    let wrong = folder.run(&[
        "table",
        "--omega",
        "5",
        "--distance",
        "1",
        "--landing-height",
        "ground",
    ]);
    assert!(
        wrong.code == Some(2) && wrong.err.contains("or `wheel`"),
        "{wrong:?}"
    );
}

#[test]
fn the_exported_c_answers_as_the_table_does() {
    let folder = Folder::new("c-and-table");
    for options in [
        "",
        " --landing-height 0",
        " --start-lean -0.5",
        " --robot rats-boom",
    ] {
        folder.noted(
            &format!("export c --distance 0.4:0.8:9 --tolerance 1mm --out c{options}"),
            0,
        );
        for (rate, distance) in [("5", "0.8"), ("4.1", "0.6"), ("3.3", "0.47")] {
            let (header, table) = rows(&folder.noted(
                &format!("table --omega {rate} --distance {distance} --format csv{options}"),
                0,
            ));
            let column = |name: &str| {
                table[0][header.iter().position(|h| h == name).unwrap()]
                    .parse::<f64>()
                    .unwrap()
            };
            let height = if options.contains("height") {
                "0"
            } else {
                "0.24"
            };
            let Some(said) = run_c(&folder, "c", ANGLE, &[rate, distance, height]) else {
                return;
            };
            let angle: f64 = said.trim().parse().unwrap();
            // A millimetre of landing at the table's own slope.
            let off = (angle - column("alpha_f_rad")) * column("distance_by_alpha_f_m_per_rad");
            assert!(
                off.abs() < 1e-3,
                "{options} {rate} {distance}: {angle} {off}"
            );
        }
    }
}

#[test]
fn one_distance_keeps_the_tolerance_or_is_closed() {
    let folder = Folder::new("one-distance-tolerance");
    let said = folder.done(
        "export rust --distance 0.8 --landing-height 0 --tolerance 1mm",
        0,
    );
    let lands = said
        .split_once("what is fired lands within ")
        .unwrap()
        .1
        .split_once(" mm")
        .unwrap()
        .0;
    assert!(lands.parse::<f64>().unwrap() <= 1.0, "{said}");
    let none = folder.done("export rust --distance 0.8 --tolerance 1e-9", 1);
    assert!(
        none.contains("no cell of the firing curve is open")
            && none.contains("the best cell misses by"),
        "{none}"
    );
}

/// The command of docs/controller.md that writes into `out`, and the page's program `number`.
fn documented(out: &str, number: usize) -> (String, String) {
    let page = std::fs::read_to_string(
        std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/controller.md"),
    )
    .unwrap();
    let command = page.lines().find_map(|line| {
        line.trim()
            .strip_prefix("saltus ")
            .filter(|rest| rest.starts_with("export ") && rest.ends_with(&format!("--out {out}")))
    });
    let program = page.split("```c\n").nth(1 + number).unwrap();
    let program = program.split_once("```").unwrap().0;
    (command.unwrap().to_owned(), program.to_owned())
}

#[test]
fn the_running_program_in_the_documentation_runs() {
    let folder = Folder::new("documented-running");
    let (export, program) = documented("running", 1);
    for real in ["float", "double"] {
        let said = folder.done(&format!("{export} --real {real}"), 0);
        assert!(said.contains("running robot rats-run"), "{said}");
        for file in ["saltus_running.h", "saltus_running.c", "running_tables.h"] {
            let text = folder.read(&format!("running/{file}"));
            assert!(said.lines().all(|line| text.contains(line)), "{file}");
            assert!(!text.contains('@'), "{file} has a place not filled");
        }
        let Some(said) = run_with(&folder, "running/saltus_running.c", &program, &[]) else {
            return;
        };
        // Leg 3 at rest, then each next one as it comes by.
        let legs: Vec<&str> = said.lines().map(|line| &line[..6]).collect();
        let should = ["leg 3:", "leg 4:", "leg 0:", "leg 1:", "leg 2:", "leg 3:"];
        assert_eq!(legs, should);
    }
}

#[test]
fn the_program_in_the_documentation_runs() {
    let folder = Folder::new("documented-c");
    let (export, program) = documented("firmware", 0);
    folder.done(&export, 0);
    let Some(said) = run_c(&folder, "firmware", &program, &[]) else {
        return;
    };
    let angle =
        json(&folder.done("table --omega 5 --distance 0.6 --format json", 0))["rows"][0]["alpha_f_rad"]
            .as_f64()
            .unwrap();
    assert!(
        said.starts_with(&format!("angle {angle:.3} rad\nfire at ")),
        "{said}"
    );
    assert!(
        said.ends_with("roll on, ask again at the next touch-down\n"),
        "{said}"
    );
}

/// Fired at the angle that `table` gives, a jump of `simulate` lands where the table says, as high,
/// with every term that a flight has.
#[test]
fn simulate_flies_what_table_plans() {
    let folder = Folder::new("simulate-table");
    for setting in [
        "leg.picked_up_mass_kg=0.3",
        "environment.drag_per_m=0.1",
        "environment.gravity_m_s2=7",
    ] {
        let planned = folder.done(
            &format!("table --omega 5 --distance 0.6 --format json --set {setting}"),
            0,
        );
        let cell = &json(&planned)["rows"][0];
        let number = |of: &Value, key: &str| of[key].as_f64().unwrap();
        let angle = number(cell, "alpha_f_rad");
        let flown = folder.done(
            &format!("simulate --omega 5 --alpha-f {angle} --format json --set {setting}"),
            0,
        );
        let jump = &json(&flown)["jumps"][0];
        for (said, flown) in [("land_m", "land_rs_m"), ("apex_m", "apex_m")] {
            let off = number(cell, said) - number(jump, flown);
            assert!(off.abs() < 1e-8, "{setting}: {said} is off by {off} m");
        }
    }
}
