//! What `saltus verify` judges, and what it says of what fails.

use crate::common::{Folder, rows};
use serde_json::Value;

/// A jump to a goal that begins where a ditch ends.
const DITCH: &str = "\
approach_rate_rad_s = 5.0
goal_from_x_m = 0.865
goal_to_x_m = 1.1
target_x_m = 0.87
margin_sigmas = 0
edge_margin_m = 0
[[avoid]]
from_x_m = 0.70
to_x_m = 0.865
";

/// Over a box that the plan clears by no more than it has to.
const BOX: &str = "\
approach_rate_rad_s = 5.5
goal_from_x_m = 0.8
goal_to_x_m = 1.0
clearance_m = 0.01
margin_sigmas = 0
[[obstacle]]
front_x_m = 0.33
width_m = 0.21
height_m = 0.21
";

/// Two jumps, the first into a zone of its own, over a box each.
const TWO: &str = "\
jumps = 2
approach_rate_rad_s = 5.0
target_x_m = 1.75
goal_from_x_m = 1.6
goal_to_x_m = 1.9
margin_sigmas = 0
[[obstacle]]
front_x_m = 0.4
width_m = 0.05
height_m = 0.1
[[land]]
jump = 1
from_x_m = 0.75
to_x_m = 1.0
[[avoid]]
from_x_m = 1.1
to_x_m = 1.3
";

fn folder(name: &str) -> Folder {
    let folder = Folder::new(&format!("verify-{name}"));
    folder.write("ditch.toml", DITCH);
    folder.write("box.toml", BOX);
    folder.write("two.toml", TWO);
    folder
}

fn json(folder: &Folder, line: &str, code: i32) -> Value {
    serde_json::from_str(&folder.done(&format!("{line} --format json"), code)).unwrap()
}

fn number(row: &Value, key: &str) -> f64 {
    row[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} of {row}"))
}

#[test]
fn a_jump_into_a_ditch_fails() {
    let folder = folder("ditch");
    let report = json(&folder, "verify ditch.toml --robot rats-boom", 1);
    let rows = report["rows"].as_array().unwrap();
    let in_ditch = |row: &&Value| (0.70..0.865 - 1e-5).contains(&number(row, "land_x_m"));
    assert_eq!(
        (rows.len(), rows.iter().filter(in_ditch).count()),
        (101, 87)
    );
    for row in rows {
        let lands_well = !in_ditch(&row);
        for key in ["avoid_holds", "goal_holds"] {
            assert_eq!(row[key], lands_well, "{key}: {row}");
        }
        assert!(lands_well || row["passes"] == false);
        let margin = number(row, "land_x_m") - 0.865;
        for key in ["avoid_margin_m", "goal_margin_m"] {
            assert!((number(row, key) - margin).abs() < 1e-12, "{key}: {row}");
        }
    }
    let first = &report["failures"][0];
    assert_eq!(
        (&first["demand"], &first["jump"], &first["errors"]),
        (&"avoid".into(), &1.into(), &false.into())
    );
}

#[test]
fn the_clearance_of_the_course_is_demanded_and_may_be_asked_for_otherwise() {
    let folder = folder("clearance");
    let report = json(&folder, "verify box.toml", 1);
    let rows = report["rows"].as_array().unwrap();
    let (near, far): (Vec<_>, Vec<_>) = rows
        .iter()
        .partition(|row| number(row, "clearance_m") < 0.01 - 1e-5);
    assert!(
        near.len() > 20 && far.len() > 20,
        "{} {}",
        near.len(),
        far.len()
    );
    assert!(
        near.iter()
            .all(|row| row["passes"] == false && row["clearance_holds"] == false)
    );
    assert!(far.iter().all(|row| row["clearance_holds"] == true));
    assert!(
        near[0]["reason"]
            .as_str()
            .unwrap()
            .contains("from obstacle 1, 10 mm are demanded")
    );
    assert_eq!(
        json(&folder, "verify box.toml --clearance 0", 0)["passes"],
        true
    );
}

#[test]
fn a_jump_starts_where_the_one_before_landed() {
    let folder = folder("chain");
    for (flag, chained) in [("", true), ("--restart", false)] {
        let line = format!(
            "verify two.toml --samples 6 --plant rats-boom --tolerance 0.3 --share 0 {flag}"
        );
        let report: Value = serde_json::from_str(
            &folder
                .run(
                    &format!("{line} --format json")
                        .split_whitespace()
                        .collect::<Vec<_>>(),
                )
                .out,
        )
        .unwrap();
        let rows = report["rows"].as_array().unwrap();
        assert_eq!(rows.len(), 14);
        let mut moved = 0;
        for run in rows.chunks(2) {
            assert_eq!(
                (&run[0]["run"], &run[1]["jump"]),
                (&run[1]["run"], &2.into())
            );
            assert_eq!(run[0]["foot_x_m"], 0.0);
            if run[1]["outcome"] == "not-started" {
                continue;
            }
            let start = if chained {
                &run[0]["land_x_m"]
            } else {
                &run[0]["land_planned_x_m"]
            };
            assert_eq!(&run[1]["foot_x_m"], start);
            // Places are along the course.
            assert!(number(&run[1], "land_x_m") > 1.3, "{run:?}");
            moved += usize::from(
                (number(&run[1], "foot_x_m") - number(&run[1], "foot_planned_x_m")).abs() > 0.02,
            );
        }
        assert_eq!(moved > 3, chained, "{rows:?}");
        let starts = if chained {
            "where the jump before lands"
        } else {
            "at the planned footholds"
        };
        assert_eq!(report["starts"], starts);
    }
}

#[test]
fn a_run_ends_in_a_ditch_and_the_jumps_after_it_are_not_started() {
    let folder = folder("ends");
    // The boom makes the first jump land 50 to 80 mm short.
    folder.write(
        "ends.toml",
        format!("{TWO}[[avoid]]\nfrom_x_m = 0.5\nto_x_m = 0.9\n"),
    );
    let report = json(&folder, "verify ends.toml --samples 0 --plant rats-boom", 1);
    let rows = report["rows"].as_array().unwrap();
    assert_eq!(
        (&rows[0]["avoid_holds"], &rows[1]["outcome"]),
        (&false.into(), &"not-started".into())
    );
    assert_eq!(
        (&rows[1]["passes"], &rows[1]["land_x_m"]),
        (&false.into(), &Value::Null)
    );
    assert_eq!(report["groups"][0]["not_started"], 1);
    let text = folder.done("verify ends.toml --samples 0 --plant rats-boom", 1);
    assert!(text.contains("1 are not started"), "{text}");
    let report = json(
        &folder,
        "verify ends.toml --samples 0 --plant rats-boom --restart",
        1,
    );
    assert_eq!(report["rows"][1]["outcome"], "landed");
}

#[test]
fn a_failure_says_which_demand_by_how_much_how_often_and_what_to_do() {
    let folder = folder("why");
    let text = folder.done("verify box.toml --plant rats-boom --samples 20", 1);
    for words in [
        "FAIL: 0 of 1 jumps without errors pass",
        "tolerance: without errors, 1 of 1: lands 60.1 mm short of the wanted place, 48 mm are \
         allowed (--tolerance)",
        "clearance: without errors, 1 of 1: touches obstacle 1 by 7.3",
        "clearance: with errors, 20 of 20, at worst: touches obstacle 1 by",
        "rats-boom jumps, which has a boom that rats-planar has not",
        "verify --correct",
    ] {
        assert!(text.contains(words), "{words}\n{text}");
    }
    let report = json(
        &folder,
        "verify box.toml --plant-set body.mass_kg=3 --samples 0",
        1,
    );
    assert!(
        report["advice"][0].as_str().unwrap().contains("--set"),
        "{report}"
    );
    folder.done(
        "verify box.toml --plant rats-boom --samples 2 --animate page.html",
        1,
    );
    let page = folder.read("page.html");
    assert!(page.contains(
        "lands 60.1 mm short of the wanted place, 48 mm are allowed; touches obstacle 1 by 7.3"
    ));
    assert!(
        page.contains("[\"obstacle\",0]"),
        "what is touched is marked"
    );
}

#[test]
fn a_jump_that_cannot_be_simulated_is_a_failed_jump() {
    let folder = folder("stops");
    // Errors two hundred times the robot's: some jumps would start with a foot in the ground.
    let line = "verify --law=0,0.5 --omega 4 --samples 30 --tolerance 1 --share 0 \
                --set errors.firing_angle_rad=0.6";
    let report = json(&folder, line, 0);
    let failed: Vec<&Value> = report["rows"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|row| row["outcome"] == "simulation-failed")
        .collect();
    assert!(!failed.is_empty(), "{report}");
    assert!(
        failed
            .iter()
            .all(|row| row["passes"] == false && row["land_x_m"].is_null())
    );
    assert!(
        failed[0]["reason"]
            .as_str()
            .unwrap()
            .contains("the simulation stops: ")
    );
    let (header, csv) = rows(&folder.done(&format!("{line} --format csv"), 0));
    assert_eq!((header.last().unwrap().as_str(), csv.len()), ("reason", 31));
    let text = folder.done(line, 0);
    assert!(
        text.contains("cannot be simulated") && text.contains("the simulation stops"),
        "{text}"
    );
    folder.done(&format!("{line} --plot a.svg --animate a.html"), 0);
}

/// What a landing may be off follows the size of the wheel; a failure names the flag that says otherwise.
#[test]
fn the_tolerance_follows_the_wheel_unless_a_flag_gives_it() {
    let folder = Folder::new("verify-tolerance");
    let robot = "name = \"small\"\nenvironment = { gravity_m_s2 = 9.8, ambient_pressure_kpa = 101.325 }\n\
        [body]\nmass_kg = 0.1\ninertia_kg_m2 = 3e-5\nwheel_radius_mm = 30\nlegs = 4\n[leg]\nkind = \
        \"spring\"\nstroke_mm = 15\nrelease_delay_ms = 3\nviscous_friction_n_s_per_m = 0\n\
        coulomb_friction_n = 0\nstiffness_n_per_m = 1500\ncompression_mm = 20\n";
    folder.write("small.toml", robot);
    // It lands at 0.48 m, 40 mm off.
    let line = "verify --law=0,0.2 --omega 12 --distance 0.44 --robot small.toml --samples 0";
    let text = folder.done(line, 1);
    assert!(
        text.contains("lands 40.1 mm beyond the wanted place, 6 mm are allowed (--tolerance)"),
        "{text}"
    );
    assert!(
        text.contains(
            "landings within 0.006 m of where they are wanted (a fifth of the wheel's radius)"
        ),
        "{text}"
    );
    assert_eq!(json(&folder, line, 1)["tolerance_m"], 0.006);
    let text = folder.done(&format!("{line} --tolerance 0.05"), 0);
    assert!(!text.contains("radius)"), "{text}");
}

/// The document of a course without a plan has the keys of every other one.
#[test]
fn a_course_without_a_plan_has_the_keys_of_every_verification() {
    let folder = folder("keys");
    folder.write(
        "none.toml",
        "approach_rate_rad_s = 5\ngoal_from_x_m = 1.6\ngoal_to_x_m = 1.9\n",
    );
    let keys = |line: &str, code| -> Vec<String> {
        let document = json(&folder, line, code);
        document.as_object().unwrap().keys().cloned().collect()
    };
    assert_eq!(
        keys("verify none.toml", 1),
        keys("verify box.toml --samples 0 --clearance 0", 0)
    );
}

#[test]
fn reports_hold_no_round_off_and_no_number_that_is_none() {
    let folder = folder("digits");
    for line in [
        "verify ditch.toml --robot rats-boom --samples 3",
        "verify box.toml --samples 3 --clearance 0 --friction 0.2,1",
        "verify --law=-0.06,0.27 --omega 3:5:3 --samples 2",
        "verify --law=0,0 --omega 7 --samples 2",
        "simulate --omega 7 --alpha-f 0",
    ] {
        let text = folder.run(&line.split_whitespace().collect::<Vec<_>>()).out;
        assert!(!text.is_empty(), "{line}");
        let is_noise = |word: &str| {
            let exponent = word
                .split_once("e-")
                .and_then(|(_, power)| power.parse::<u32>().ok());
            word.contains("NaN") || word.contains("inf") || exponent.is_some_and(|power| power > 9)
        };
        // Energy is balanced to round-off, and says so.
        let lines = text.lines().filter(|line| !line.contains("energy ledger"));
        let noise: Vec<&str> = lines
            .flat_map(str::split_whitespace)
            .filter(|word| is_noise(word))
            .collect();
        assert!(noise.is_empty(), "{line}: {noise:?}\n{text}");
    }
}

#[test]
fn a_law_has_no_jump_numbers_and_no_course() {
    let folder = folder("law");
    let line = "verify --law=-0.06,0.27 --omega 3:5:3 --samples 2 --tolerance 1";
    let report = json(&folder, line, 0);
    let rows = report["rows"].as_array().unwrap();
    assert!(
        rows.iter()
            .all(|row| row["jump"].is_null() && row["goal_holds"].is_null())
    );
    let runs: Vec<u64> = rows
        .iter()
        .map(|row| row["run"].as_u64().unwrap())
        .collect();
    assert_eq!(runs, [1, 2, 3, 4, 5]);
    let run = folder.run(&["verify", "--law=0,0", "--omega", "4", "--restart"]);
    assert_eq!(run.code, Some(2));
    assert!(
        run.err
            .contains("--restart: must be left out where there is no course"),
        "{}",
        run.err
    );
}

#[test]
fn a_course_is_drawn_as_a_course_and_a_failure_is_seen() {
    let folder = folder("plot");
    folder.done(
        "verify two.toml --samples 3 --clearance 0 --share 0 --plot two.svg --animate two.html",
        0,
    );
    let svg = folder.read("two.svg");
    for words in [
        "PASS",
        "band: tolerance",
        "strip: the goal",
        "pale strip",
        "pit: where no jump may land",
    ] {
        assert!(svg.contains(words), "{words}");
    }
    folder.done(
        "verify two.toml --samples 3 --plant rats-boom --plot boom.svg",
        1,
    );
    assert!(folder.read("boom.svg").contains("FAIL"));
    let page = folder.read("two.html");
    let scene = page
        .split_once("id=\"scene\">")
        .unwrap()
        .1
        .split_once("</script>")
        .unwrap()
        .0;
    let scene: Value = serde_json::from_str(scene).unwrap();
    assert_eq!(
        (scene["avoid"][0].clone(), scene["zones"][0]["name"].clone()),
        (serde_json::json!([1.1, 1.3]), "land 1".into())
    );
    let jumps = scene["jumps"].as_array().unwrap();
    assert_eq!(
        (
            &jumps[0]["next"],
            jumps[0]["others"].as_array().unwrap().len()
        ),
        (&1.into(), 1)
    );
    assert_eq!(jumps[0]["land_m"], jumps[1]["foothold_m"][0]);
}

#[test]
fn no_two_paths_of_a_drawing_have_one_name() {
    let folder = folder("names");
    for line in [
        "verify two.toml --friction 0.6,1 --samples 0",
        "verify --law=0,0 --omega 4:5:3 --friction 0.6,1 --samples 0",
    ] {
        folder.run(
            &format!("{line} --plot a.svg")
                .split_whitespace()
                .collect::<Vec<_>>(),
        );
        let svg = folder.read("a.svg");
        let mut names: Vec<&str> = svg
            .lines()
            .filter(|line| line.starts_with("simulated, "))
            .collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert!(count >= 2 && names.len() == count, "{line}: {names:?}");
    }
}

#[test]
fn a_box_that_is_landed_on_must_not_be_touched_before() {
    use saltus::verify::{Demand, Demands, Plant, Route, Stage, Starts};
    let robot = saltus::Robot::rats_planar();
    let (planner, radius) = (saltus::Planner::new(robot.clone()), robot.body.radius);
    let launch = saltus::Launch {
        rate: 5.0,
        lean: -0.3,
        firing_angle: -0.3,
        valve_open: 0.1,
    };
    let top = 0.1;
    let jump = planner.jump(&launch).unwrap();
    let place = jump.distance(radius + top).unwrap();
    let plant = Plant::new(robot, 1e-8);
    let fly = |front: f64| {
        let stage = Stage {
            launch,
            foot: [0.0, 0.0],
            landing_height: radius + top,
            surface: Some(top),
            apex: jump.apex().unwrap(),
            landing: place,
            wanted: place,
        };
        let demands = Demands {
            obstacles: vec![[front, place + 1.0, top]],
            clearance: 0.02,
            ..Demands::within(0.01)
        };
        let mut attempts = plant.run(
            &Route {
                stages: vec![stage],
                demands,
            },
            &[],
            Starts::Chained,
        );
        attempts.pop().unwrap()
    };
    // Where the box begins behind the rise, the landing itself is no touch, whatever clearance is
    // demanded.
    let clear = fly(0.6 * place);
    assert!(clear.passes(), "{:?}", clear.reasons());
    assert_eq!(clear.clearance, None);
    // Where it begins before, the wheel rises into its corner, in the stance or after it.
    let touched = fly(0.15);
    let touches = |demand| {
        touched
            .judgement(demand)
            .is_some_and(|j| !j.holds() && j.item == Some(0))
    };
    assert!(
        [Demand::Clearance, Demand::Stance].into_iter().any(touches),
        "{:?}",
        touched.judgements
    );
    assert_eq!(touched.clearance.map(|gap| gap < -1e-3), Some(true));
    assert!(
        touched.landing().is_some(),
        "it lands on the box all the same"
    );
}

#[test]
fn the_box_that_the_robot_stands_on_has_no_clearance() {
    let folder = folder("stand");
    // From one box over a ditch onto another.
    folder.write(
        "boxes.toml",
        "approach_rate_rad_s = 5.0\nstart_height_m = 0.1\ntarget_x_m = 0.95\ngoal_from_x_m = 0.8\n\
         [[obstacle]]\nfront_x_m = -0.3\nwidth_m = 0.4\nheight_m = 0.1\n\
         [[obstacle]]\nfront_x_m = 0.6\nwidth_m = 1.0\nheight_m = 0.1\n",
    );
    let report = json(&folder, "verify boxes.toml --samples 5 --share 0", 0);
    for row in report["rows"].as_array().unwrap() {
        assert_eq!(row["clearance_m"], Value::Null, "{row}");
    }
}
