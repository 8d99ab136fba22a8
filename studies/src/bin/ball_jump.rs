//! Jumps of rats-twelve from rest to a place, or onto a box, or to all places that it can reach: firings, and how many of 100
//! other robots (50 for each place of a map) land within 10 cm, without having touched the box, and stay on it.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_jump -- 0.3,0.2
//! cd studies && cargo run --release --bin ball_jump -- 0.55,0 0.12,1.5,0.28
//! cd studies && cargo run --release --bin ball_jump -- map 0.2
//! ```
//!
//! The place (m), ahead and to the left of where its legs meet; height, length and front (m) of a box. Or the distance (m)
//! between places of a map. Where nothing is given, a few places with few robots.

type Failed = Box<dyn std::error::Error>;
use saltus_gait::Obstacle;
use saltus_gait::space::DrawnBalls;
use saltus_numeric::parallel::{available, map_on};
use saltus_studies::jumps_in_space::{Flown, JumpPlan, Planner, Standing, landed};

/// How near (m) a robot has to land.
const NEAR: f64 = 0.1;
/// How much lower (m) than it stands a robot on a box may be that is still moving on it.
const LOWER: f64 = 0.01;
/// For how long (s) a robot that lands on a box is followed.
const AFTER: f64 = 3.0;
/// Seed of the other robots.
const OTHERS: u64 = 1 + (1 << 32);

/// How many of `robots` others land near `target` that jump as `plan` says; how many of these stay on the box, if it is on one.
fn nearby(
    planner: &Planner,
    plan: &JumpPlan,
    target: [f64; 2],
    robots: usize,
) -> Result<(usize, Option<usize>), Failed> {
    let standing = planner.standing();
    let floor = standing.floor(target[0]);
    let after = if floor > 0.0 { AFTER } else { 0.0 };
    let all = map_on(available(), robots, |k| {
        planner.other(plan, (OTHERS, k), after)
    });
    let mut near: Vec<Flown> = all.into_iter().collect::<Result<_, _>>()?;
    let off = |[x, y]: [f64; 2]| (x - target[0]).hypot(y - target[1]);
    near.retain(|it| it.clearance > 0.0 && landed(it).is_some_and(|at| off(at) <= NEAR));
    let least = floor + standing.place[2] - LOWER;
    let stay = || near.iter().filter(|it| it.rests[2] > least).count();
    Ok((near.len(), (floor > 0.0).then(stay)))
}

/// Prints the jump to `target`.
fn told(
    planner: &Planner,
    plan: &JumpPlan,
    target: [f64; 2],
    robots: usize,
) -> Result<(), Failed> {
    let (near, stay) = nearby(planner, plan, target, robots)?;
    let stay = stay.map_or(String::new(), |stay| stay.to_string());
    let apex = plan.flown.touch.map_or(0.0, |touch| touch.apex);
    let firings: Vec<String> = (plan.jump.commands.iter())
        .map(|it| format!("{}@{:.0}:{:.1}", it.leg, it.at * 1e3, it.open * 1e3))
        .collect();
    println!(
        "{:.3},{:.3},{},{:.4},{:.4},{near},{robots},{stay},{apex:.4},{}",
        target[0],
        target[1],
        plan.is_reached(),
        plan.off,
        plan.miss,
        firings.join(" ")
    );
    Ok(())
}

/// `N` numbers with commas between them.
fn numbers<const N: usize>(word: &str) -> Result<[f64; N], Failed> {
    let all: Vec<f64> = word.split(',').map(str::parse).collect::<Result<_, _>>()?;
    let all = all.try_into();
    all.map_err(|_| format!("{word}: give {N} numbers with commas between them").into())
}

fn main() -> Result<(), Failed> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let mut standing = Standing::on(&robot, 0)?;
    let is_map = words.first().is_some_and(|word| word == "map");
    if let (Some(sizes), false) = (words.get(1), is_map) {
        let [height, length, front] = numbers(sizes)?;
        let obstacle = Obstacle {
            front,
            length,
            height,
        };
        standing = standing.before(obstacle, &robot)?;
    }
    let draw = DrawnBalls::around(&robot);
    let planner = Planner::new(&robot, standing, &draw, (16, 1), available())?;
    println!(
        "x_m,y_m,is_reached,mean_off_m,miss_m,within_10_cm,of,stay_on_the_box,apex_m,firings (leg@ms:ms)"
    );
    if is_map {
        let spacing: f64 = words.get(1).map_or(Ok(0.2), |word| word.parse())?;
        for spot in planner.reach(spacing, available())? {
            told(&planner, &spot.plan, spot.target, 50)?;
        }
        return Ok(());
    }
    let (targets, robots) = match words.first() {
        Some(place) => (vec![numbers(place)?], 100),
        None => (vec![[0.15, 0.0], [0.37, 0.14], [0.6, 0.0], [0.9, 0.0]], 20),
    };
    for target in targets {
        let plan = planner.to(target, available())?;
        told(&planner, &plan, target, robots)?;
    }
    Ok(())
}
