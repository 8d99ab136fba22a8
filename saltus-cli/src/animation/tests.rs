//! Scenes of simulated jumps; `tests/animation/check` looks at their pages in a browser.

use std::path::PathBuf;

use saltus::sim_check::{Plan, Rig};
use saltus::{Launch, Planner, Robot};

use super::{Jump, Obstacle, Scene, page};

/// Where the pages for the browser go.
const PAGES: &str = "SALTUS_PAGES";

fn launch(firing_angle: f64) -> Launch {
    Launch {
        rate: 5.0,
        lean: -0.4,
        firing_angle,
        valve_open: 0.1,
    }
}

/// A jump of `robot` at `firing_angle` (rad), planned without slip and simulated with the friction
/// of its ground.
fn jump(robot: &Robot, firing_angle: f64) -> Jump {
    let rig = Rig::new(robot, &[]).unwrap();
    let radius = robot.body.radius;
    // On a slope, about where the ground is high enough.
    let height = radius + 0.7 * robot.ground.slope.tan();
    let plan = Plan {
        sample: 2e-3,
        landing_height: height,
        ..Plan::default()
    };
    let command = saltus::sim_check::Launch {
        rate: 5.0,
        lean: -0.4,
        firing_angle,
        valve_open: 0.1,
    };
    let report = rig.jump(&command, &plan).unwrap();
    let planner = Planner::new(robot.clone());
    let planned = planner.jump(&launch(firing_angle)).unwrap();
    let trace = planner.stance().trace(&launch(firing_angle)).unwrap();
    let stance = trace.samples.iter().map(|s| {
        let reach = radius + s.extension;
        [reach * s.lean.sin(), reach * s.lean.cos()]
    });
    let flight = planned.exact_flight().unwrap();
    let end = flight.time_to_height(height).unwrap();
    let path = stance
        .chain(flight.samples(0.0, end, 100).map(|(_, x, y)| [x, y]))
        .collect();
    let asked = Jump {
        name: format!("fired at {firing_angle} rad"),
        verdict: String::new(),
        passed: report.slips_at.is_none(),
        planned: path,
        planned_apex_m: flight.apex_height(),
        planned_land_m: planned.distance(height).unwrap(),
        ..Jump::default()
    };
    let mut jump = Jump::of(&rig, &report, height, asked);
    jump.verdict = format!(
        "lands {:+.1} mm from where it was planned",
        (jump.land_m - jump.planned_land_m) * 1e3
    );
    jump
}

fn slippery() -> Robot {
    let mut robot = Robot::rats_planar();
    (robot.ground.static_friction, robot.ground.kinetic_friction) = (0.25, 0.2);
    robot
}

fn over_a_box() -> Scene {
    let robot = slippery();
    let obstacle = Obstacle {
        from_x_m: 0.35,
        to_x_m: 0.5,
        top_m: 0.15,
    };
    let jumps = [-0.1, 0.05, 0.25].map(|angle| jump(&robot, angle)).into();
    Scene::of(
        &robot,
        "Three jumps over a box of 0.15 m".into(),
        vec![obstacle],
        jumps,
    )
}

fn on_the_boom() -> Scene {
    let robot = Robot::builtin("rats-boom").unwrap();
    Scene::of(
        &robot,
        "One jump on the boom".into(),
        vec![],
        vec![jump(&robot, -0.1)],
    )
}

/// Up a slope, with names that would end the script or become elements.
fn hostile() -> Scene {
    let mut robot = slippery();
    robot.ground.slope = 0.1;
    robot.name = "<b>robot</b>\u{2028}&amp;".into();
    let mut jump = jump(&robot, 0.0);
    jump.name = "</script><script>alert(1)</script>".into();
    jump.verdict = "<!-- <img src=x onerror=alert(1)>".into();
    Scene::of(
        &robot,
        "@SCENE@ \"'><svg onload=alert(1)>".into(),
        vec![],
        vec![jump],
    )
}

fn data(page: &str) -> serde_json::Value {
    let (_, rest) = page
        .split_once("<script type=\"application/json\" id=\"scene\">")
        .unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

#[test]
fn a_jump_begins_at_the_foothold_and_ends_at_its_landing() {
    let jump = jump(&Robot::rats_planar(), -0.1);
    let (first, last) = (&jump.frames[0], &jump.frames[jump.frames.len() - 1]);
    // The frames are of the simulation, which starts on the foot and measures the landing itself;
    // the end is extrapolated over less than a sample of 2 ms, so misses by g/2 · (2 ms)².
    assert!(
        first.foot_m.iter().all(|x| x.abs() < 1e-12) && first.touching && first.force_n[1] > 0.0
    );
    assert!((last.axle_m[1] - 0.24).abs() < 1e-12 && (last.axle_m[0] - jump.land_m).abs() < 1e-4);
    assert!(!last.touching && last.force_n == [0.0; 2]);
    let named: Vec<&str> = jump
        .events
        .iter()
        .map(|event| event.what.as_str())
        .collect();
    assert_eq!(named, ["fire", "lift-off", "apex", "landing"]);
    // Two derivations of one jump: the planned path is the simulated one.
    assert!(
        (jump.land_m - jump.planned_land_m).abs() < 1e-4
            && (jump.apex_m - jump.planned_apex_m).abs() < 1e-4
    );
}

#[test]
fn a_foot_that_slips_says_when_and_how_far() {
    let jump = jump(&slippery(), 0.25);
    assert!(jump.events.iter().any(|event| event.what == "slip"));
    let slipped = jump.frames.last().unwrap().slip_m;
    let standing = jump.frames.iter().rfind(|frame| frame.touching).unwrap();
    // The foot is a point: what it slipped is where it is. Trapezia over 2 ms.
    assert!(slipped.abs() > 1e-3 && (slipped - standing.foot_m[0]).abs() < 0.02 * slipped.abs());
}

#[test]
fn the_force_of_a_slope_leans_with_it() {
    let scene = hostile();
    let frame = &scene.jumps[0].frames[0];
    let (sin, cos) = scene.slope_rad.sin_cos();
    let [x, y] = frame.force_n;
    // Within the cone of μ = 0.25 about the slope's normal.
    assert!((x * cos + y * sin).abs() <= 0.25 * (y * cos - x * sin) + 1e-9);
}

#[test]
fn the_page_holds_its_scene_and_no_markup_of_it() {
    let scene = hostile();
    let page = page(&scene);
    assert!(
        !page.contains("alert(1)</script>") && !page.contains("<img") && !page.contains("<!-- <")
    );
    assert!(!page.contains('\u{2028}'));
    let data = data(&page);
    assert_eq!(data["robot"], scene.robot.as_str());
    assert_eq!(data["title"], scene.title.as_str());
    assert_eq!(data["jumps"][0]["name"], scene.jumps[0].name.as_str());
}

#[test]
fn numbers_have_six_digits_and_none_is_null() {
    let mut scene = on_the_boom();
    scene.jumps[0].land_m = f64::NAN;
    scene.hub_radius_m = 0.123_456_789;
    scene.slope_rad = 1e-17;
    let page = page(&scene);
    let data = data(&page);
    assert_eq!(data["hub_radius_m"], 0.123_457);
    assert_eq!(data["slope_rad"], 0);
    assert!(data["jumps"][0]["land_m"].is_null());
    // 300 kB is what a page of a jump of 1 s at 2 ms may be.
    assert!(page.len() < 300_000, "{} bytes", page.len());
}

#[test]
fn the_page_asks_for_nothing() {
    let page = page(&on_the_boom());
    let links = page.match_indices("http").filter(|(at, _)| {
        let rest = &page[*at..];
        rest.starts_with("http:") || rest.starts_with("https:")
    });
    let outside: Vec<_> = links
        .filter(|(at, _)| !page[*at..].starts_with("http://www.w3.org/2000/svg"))
        .collect();
    assert!(outside.is_empty() && !page.contains("@import") && !page.contains("url("));
    assert!(page.contains("default-src 'none'"));
}

/// Writes the pages that `tests/animation/check` looks at into the folder that the environment
/// names.
#[test]
#[ignore = "nightly: 1 s, section browser, which names a folder"]
fn pages_for_the_browser() {
    let folder = PathBuf::from(std::env::var(PAGES).unwrap());
    for (name, scene) in [
        ("box", over_a_box()),
        ("boom", on_the_boom()),
        ("hostile", hostile()),
    ] {
        std::fs::write(folder.join(format!("{name}.html")), page(&scene)).unwrap();
    }
}
