//! Courses as a user writes them, and what `saltus plan` answers.

use std::process::{Command, Stdio};

use crate::common::Folder;

fn json(folder: &Folder, line: &str, code: i32) -> serde_json::Value {
    serde_json::from_str(&folder.done(line, code)).unwrap()
}

#[test]
fn lists_of_the_wrong_length_are_refused() {
    let folder = Folder::new("course-lists");
    let check = |jumps: usize, rates: &str, counts: &str| {
        folder.write(
            "c.toml",
            format!("jumps = {jumps}\ntarget_x_m = 1.6\napproach_rate_rad_s = {rates}\n"),
        );
        for command in ["plan", "verify"] {
            let run = folder.run(&[command, "c.toml"]);
            assert_eq!(run.code, Some(2), "{}", run.out);
            let wanted = format!("c.toml:3: approach_rate_rad_s = {rates}: must be {counts}");
            assert!(run.err.contains(&wanted), "{}", run.err);
        }
    };
    check(3, "[3, 6]", "one number, or a list of 3; this list has 2");
    check(
        2,
        "[3, 6, 4, 5]",
        "one number, or a list of 2; this list has 4",
    );
}

#[test]
fn keys_in_other_units_and_misspelt_keys() {
    let folder = Folder::new("course-units");
    let course = "approach_rate_rad_s = 5\ngoal_from_x_m = 0.7\ngoal_to_x_m = 1.1\n[[obstacle]]\n";
    folder.write(
        "m.toml",
        format!("{course}front_x_m = 0.4\nwidth_m = 0.05\nheight_m = 0.1\n"),
    );
    folder.write(
        "mm.toml",
        format!("{course}front_x_cm = 40\nwidth_mm = 50\nheight_cm = 10\n"),
    );
    let plan = |file: &str| folder.done(&format!("plan {file} --format csv"), 0);
    assert_eq!(plan("m.toml"), plan("mm.toml"));
    folder.write(
        "typo.toml",
        format!("{course}front_x_m = 0.4\nwidth_m = 0.05\nhight_m = 0.1\n"),
    );
    let run = folder.run(&["plan", "typo.toml"]);
    assert_eq!(run.code, Some(2));
    let wanted =
        "typo.toml:7: unknown key obstacle 1.hight_m; the nearest known key is obstacle 1.height_m";
    assert!(run.err.contains(wanted), "{}", run.err);
}

#[test]
fn no_plan_lands_on_the_last_millimetre_and_says_how_far_off_its_target_it_is() {
    let folder = Folder::new("course-margin");
    let course =
        "approach_rate_rad_s = 5\ntarget_x_m = 0.8\n[[avoid]]\nfrom_x_m = 0.7\nto_x_m = 0.9\n";
    folder.write("ditch.toml", course);
    let plan = json(&folder, "plan ditch.toml --format json", 1);
    assert_eq!(plan["status"], "misses-the-target");
    let jump = &plan["jumps"][0];
    let number = |key: &str| jump[key].as_f64().unwrap();
    let (landing, deviation) = (number("land_x_m"), number("land_sd_m"));
    assert!(
        (landing - 0.7).abs().min((landing - 0.9).abs()) > 2.0 * deviation + 0.004,
        "{landing}"
    );
    assert!((number("off_target_m") - (landing - 0.8)).abs() < 1e-12);
    let text = folder.done("plan ditch.toml", 1);
    for words in [
        "the target at 0.8 m; no goal zone is given",
        "Between the landing and the target lies avoid area 1; the landing must be within 48 mm",
    ] {
        assert!(text.contains(words), "{text}");
    }
    folder.done("plan ditch.toml --plot plan.svg", 1);
    assert!(folder.read("plan.svg").contains("the target at 0.8 m"));
    folder.write("any.toml", format!("goal_to_x_m = 2\n{course}"));
    let text = folder.done("plan any.toml", 0);
    assert!(
        text.contains("holds in the planar model (`saltus verify` flies it)"),
        "{text}"
    );
}

/// A target that no jump reaches is an answer of no, of `plan` and of `verify`; a goal, or no weight, says
/// that another place will do.
#[test]
fn a_target_out_of_reach_is_missed() {
    let folder = Folder::new("course-target");
    let far = "approach_rate_rad_s = 5\ntarget_x_m = 4\n";
    folder.write("far.toml", far);
    let plan = json(&folder, "plan far.toml --format json", 1);
    assert_eq!(plan["status"], "misses-the-target");
    let text = folder.done("plan far.toml", 1);
    for words in [
        "rats-planar: plan for far.toml: misses the target\n",
        "3.06 m short of the target at 4 m",
        "Try jumps = 5.",
        "If another place will do, give the goal",
    ] {
        assert!(text.contains(words), "{text}");
    }
    assert!(!text.contains("another unit"), "{text}");
    let run = folder.run(&["plan", "far.toml", "--format", "csv"]);
    assert!(run.err.contains("misses the target"), "{}", run.err);
    let text = folder.done("verify far.toml --samples 0", 1);
    assert!(
        text.contains("short of the wanted place, 48 mm are allowed (--tolerance)"),
        "{text}"
    );
    folder.write("five.toml", format!("jumps = 5\n{far}"));
    folder.done("plan five.toml", 0);
    for more in ["goal_from_x_m = 0", "deviation_weight = 0"] {
        folder.write("any.toml", format!("{more}\n{far}"));
        folder.done("plan any.toml", 0);
        folder.done("verify any.toml --samples 0", 0);
    }
    folder.write("cm.toml", far.replace("= 4", "= 90"));
    let text = folder.done("plan cm.toml", 1);
    assert!(text.contains("Is target_x_m in another unit"), "{text}");
}

#[test]
fn what_cannot_be_is_infeasible_and_says_what_would_do() {
    let folder = Folder::new("course-infeasible");
    let check = |course: &str, words: &[&str]| {
        folder.write("c.toml", course);
        let text = folder.done("plan c.toml", 1);
        assert!(text.contains(": infeasible\n"), "{text}");
        assert!(words.iter().all(|word| text.contains(word)), "{text}");
        text
    };
    let wall = "approach_rate_rad_s = 5\ntarget_x_m = 0.8\ngoal_from_x_m = \
        0.6\n[[obstacle]]\nfront_x_m = 0.4\nwidth_m = 0.05\nheight_m = 10\n";
    // Of what would have to be otherwise, a goal in front of the wall is the nearest.
    check(
        wall,
        &[
            "the goal would have to begin at",
            "or nearer, in front of obstacle 1, 10 m high (it begins at 0.6 m)",
        ],
    );
    let far = "approach_rate_rad_s = 5\ngoal_from_x_m = 1.6\ngoal_to_x_m = 1.9\n";
    check(
        far,
        &[
            "one jump is not enough: the goal would have to begin at",
            "Try jumps = 2.",
        ],
    );
    folder.write("two.toml", format!("jumps = 2\n{far}"));
    folder.done("plan two.toml", 0);
    // A table without rows says why on standard error.
    folder.write("c.toml", far);
    let run = folder.run(&["plan", "c.toml", "--format", "csv"]);
    assert!(
        run.err.contains("infeasible") && run.err.contains("Try jumps = 2."),
        "{}",
        run.err
    );
    assert_eq!((run.code, run.out.lines().count()), (Some(1), 1));
    assert_eq!(
        json(&folder, "plan c.toml --format json", 1)["complete"],
        true
    );
    let under = "approach_rate_rad_s = 5\ntarget_x_m = 0.8\ngoal_from_x_m = \
        0.6\n[[obstacle]]\nfront_x_m = 0.1\nwidth_m = 0.2\nheight_m = 0.1\n";
    check(
        under,
        &["obstacle 1 is under the wheel where jump 1 starts"],
    );
}

#[test]
fn a_ten_metre_wall_is_not_landed_in() {
    let folder = Folder::new("course-wall");
    folder.write(
        "wall.toml",
        "approach_rate_rad_s = 5\ntarget_x_m = 0.8\n[[obstacle]]\nfront_x_m = 0.4\nwidth_m = \
         0.05\nheight_m = 10\n",
    );
    let plan: serde_json::Value =
        serde_json::from_str(&folder.run(&["plan", "wall.toml", "--format", "json"]).out).unwrap();
    match plan["status"].as_str().unwrap() {
        "infeasible" => {}
        // Short of the wall, with the wheel clear of it.
        "misses-the-target" => {
            assert!(plan["jumps"][0]["land_x_m"].as_f64().unwrap() < 0.16);
        }
        status => panic!("{status}"),
    }
}

/// Six boxes and twelve jumps.
fn long_course() -> String {
    let boxes = (0..6).map(|i| {
        let front = 0.5 + 1.2 * f64::from(i);
        format!(
            "[[obstacle]]\nfront_x_m = {front}\nwidth_m = 0.1\nheight_m = {}\n",
            0.06 + 0.01 * f64::from(i)
        )
    });
    let head = "jumps = 12\napproach_rate_rad_s = 5\ngoal_from_x_m = 7.0\ngoal_to_x_m = \
        7.6\nclearance_m = 0.01\n";
    boxes.fold(head.to_owned(), |text, it| text + &it)
}

#[test]
fn twelve_jumps_are_planned() {
    let folder = Folder::new("course-long");
    folder.write("long.toml", long_course());
    let plan = json(&folder, "plan long.toml --format json", 0);
    assert_eq!(plan["jumps"].as_array().unwrap().len(), 12);
    assert!(plan["bound"].as_f64().unwrap() <= plan["cost"].as_f64().unwrap());
}

#[test]
#[cfg(unix)]
fn ctrl_c_gives_the_best_plan_so_far() {
    let folder = Folder::new("course-ctrl-c");
    folder.write("long.toml", long_course());
    let child = Command::new(env!("CARGO_BIN_EXE_saltus"))
        .args(["plan", "long.toml", "--format", "json"])
        .current_dir(folder.path("."))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    // Long enough for the command to listen, too short for the search.
    std::thread::sleep(std::time::Duration::from_millis(400));
    let killed = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    let output = child.wait_with_output().unwrap();
    let plan: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert!(killed.success());
    assert_eq!(
        (output.status.code(), plan["interrupted"].as_bool()),
        (Some(1), Some(true)),
        "{plan}"
    );
    assert!(
        plan["status"] == "undecided" || plan["complete"] == false,
        "{plan}"
    );
}

#[test]
fn slips_of_unit_are_refused_or_asked_about() {
    let folder = Folder::new("course-slips");
    let course = "approach_rate_rad_s = 5\ngoal_from_x_m = 0.7\n";
    folder.write(
        "ms.toml",
        format!("{course}target_x_m = 0.9\nvalve_open_s = [20, 100]\n"),
    );
    let run = folder.run(&["plan", "ms.toml"]);
    assert_eq!(run.code, Some(2));
    assert!(
        run.err.contains(
            "ms.toml:4: valve_open_s item 1 = 20: must be a finite number > 0 and ≤ 10 s"
        ),
        "{}",
        run.err
    );
    folder.write("mm.toml", format!("{course}target_x_m = 900\n"));
    let run = folder.run(&["plan", "mm.toml"]);
    let text = run.out;
    assert_eq!(run.code, Some(0));
    assert_eq!(
        run.err,
        "warning: mm.toml:3: target_x_m = 900: the model is for -100 to 100 m; is it in mm?\n"
    );
    assert!(text.contains("Is target_x_m in another unit"), "{text}");
    folder.write(
        "exact.toml",
        "approach_rate_rad_s = 5\ngoal_from_x_m = 0.9\ngoal_to_x_m = 0.9\n",
    );
    let text = folder.done("plan exact.toml", 0);
    assert!(
        text.contains("on the target at 0.9 m") && !text.contains("e-1"),
        "{text}"
    );
}
