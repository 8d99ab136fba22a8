//! Robots that the laboratory does not have: without a boom, with a tank, on a slope, with a round foot and
//! with heavy legs. Data are of the multi-body simulation.

use saltus::inject::{Effect, Request, make};
use saltus_diagnosis::{Diagnosis, Settings, Sort, diagnose, kinds};
use saltus_robot::{Robot, resolve};
use saltus_tests::verdict;

/// A robot beside `rats-boom`: what it is called here, the robot that it is a variant of, what differs.
const VARIANTS: [(&str, &str, &[&str]); 6] = [
    ("without a boom", "rats-planar", &[]),
    (
        "with a tank",
        "rats-boom",
        &["tank.volume_l=0.3", "tank.wall_resistance_k_per_w=5"],
    ),
    ("on a slope", "rats-boom", &["ground.slope_rad=0.05"]),
    ("with a round foot", "rats-boom", &["foot.radius_mm=20"]),
    (
        "with heavy legs",
        "rats-boom",
        &["leg.mass_kg=0.15", "leg.center_m=0.19"],
    ),
    (
        "without a boom, with heavy legs, on a slope",
        "rats-planar",
        &[
            "leg.mass_kg=0.15",
            "leg.center_m=0.19",
            "ground.slope_rad=-0.04",
        ],
    ),
];

/// Effects that are hidden, beside none; none of them is another's rival by nature.
const EFFECTS: [&str; 3] = ["", "valve-delay=0.006", "mass=2.9"];

fn diagnosed(sort: Sort, robot: &Robot, effect: &str, seed: u64) -> Option<Diagnosis> {
    let effects: Vec<Effect> = effect
        .split_terminator(' ')
        .map(|effect| effect.parse().expect("an effect"))
        .collect();
    let made = make(&Request {
        kind: sort,
        robot: Some(robot),
        effects: &effects,
        seed,
        runs: None,
        asked: &[],
    });
    let data = made.expect("data").experiment;
    let kind = kinds::build(&data, Some(robot)).expect("a model of the data");
    diagnose(kind.as_ref(), &Settings::default(), &|_| ())
}

/// Of each variant, in hops and jumps: nothing is said where nothing is hidden, and what is hidden is named,
/// alone or with two rivals.
#[test]
#[ignore = "nightly: 6 min"]
fn robots_of_every_shape_are_diagnosed() {
    let mut wrong = Vec::new();
    for (k, (name, base, overrides)) in VARIANTS.iter().enumerate() {
        let overrides: Vec<String> = overrides.iter().map(|&key| key.to_owned()).collect();
        let robot = resolve(base, &overrides).expect("a robot");
        for sort in [Sort::Hop, Sort::Jump] {
            for effect in EFFECTS {
                let found = diagnosed(sort, &robot, effect, 90 + k as u64);
                let found = found.expect("an answer");
                let id = effect.split('=').next().unwrap_or_default();
                let sets = verdict::sets(&found);
                let is_right = match &sets[..] {
                    [] => id.is_empty(),
                    [set] => set.len() <= 3 && set.contains(&id),
                    _ => false,
                } && found.unknown.is_none();
                let line = format!("{name}, {sort:?} {effect}: {}", verdict::say(&found));
                println!("{line}");
                wrong.extend((!is_right).then_some(line));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
