//! The best firing sequence from rest over 1.6 m, found by search on one robot, beside the smooth law
//! as found for many robots and as optimised for this one, and beside the best policy.
//!
//! ```text
//! cd studies && cargo run --release --bin sequence -- 5 30
//! ```
//!
//! Drawn robots after `rats-run` itself, and generations of each search: 0 and 2 where nothing is
//! given.

use saltus_gait::{
    Draw, Footfall, Program, Row, Run, Search, Setup, Smooth, drawn_robot, run, search,
};
use saltus_numeric::parallel::available;
use saltus_robot::Robot;
use saltus_studies::laws::{BOUNDS, smooth as law};
use saltus_studies::optimal::{Quest, optimal};

/// Seed of the drawn robots: those on which the smooth law is scored.
const HELD_OUT: u64 = 200;
const DISTANCE: f64 = 1.6;
/// Firings of a sequence.
const FIRINGS: usize = 10;
/// Levels of the best policy.
const LEVELS: usize = 2;

/// A run that ends where the distance is reached.
struct Until(f64);

impl Run for Until {
    fn row(&mut self, row: &Row<'_>) {
        self.0 = row.axle[0];
    }
    fn footfall(&mut self, _: &Footfall) {}
    fn goes_on(&mut self) -> bool {
        self.0 < DISTANCE
    }
}

fn setup(robot: &Robot, program: Program) -> Setup {
    let mut setup = Setup::new(robot.clone(), program, 2.5);
    setup.zone = -0.3;
    setup
}

/// Time (s) to the distance; beyond any, the more the less far it came, where it never does.
fn time(setup: &Setup) -> f64 {
    run(setup, &mut Until(0.0)).map_or(f64::INFINITY, |s| {
        let short = DISTANCE - s.travel.clamp(0.0, DISTANCE);
        s.time_to_1_6_m.unwrap_or(3.0 + short)
    })
}

/// Firings in order; after them the smooth law goes on.
fn fires(robot: &Robot, x: &[f64]) -> Setup {
    let mut setup = setup(robot, Smooth::QUICK.program());
    setup.first = (0..x.len() / 2).map(|k| [x[2 * k], x[2 * k + 1]]).collect();
    setup
}

/// The best of a search for `generations` from `start`, and its time (s).
fn sought(
    start: Vec<f64>,
    bounds: Vec<[f64; 2]>,
    spread: f64,
    generations: usize,
    time: impl Fn(&[f64]) -> f64 + Sync,
) -> (Vec<f64>, f64) {
    let settings = Search {
        bounds,
        start,
        spread,
        candidates: 40,
        best: 8,
        generations,
        seed: 1,
    };
    let (x, best) = search(&settings, available(), |x| -time(x), |_, _, _| ());
    (x, -best)
}

/// The best sequence: from the middle of what there is, and from the firings of the best policy.
fn sequence(robot: &Robot, policy: &[[f64; 2]], generations: usize) -> (Vec<f64>, f64) {
    let bounds = vec![[[-0.3, 0.9], [0.0, 0.1]]; FIRINGS].concat();
    let plain = [0.3, 0.05].repeat(FIRINGS);
    let mut from_policy = plain.clone();
    for (x, firing) in from_policy.chunks_mut(2).zip(policy) {
        x.copy_from_slice(firing);
    }
    let of = |x: &[f64]| time(&fires(robot, x));
    let one = sought(plain, bounds.clone(), 0.4, generations, of);
    let other = sought(from_policy, bounds, 0.1, generations, of);
    if one.1 < other.1 { one } else { other }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, usual| {
        arguments
            .get(k)
            .map_or(Ok(usual), |text| text.parse::<usize>())
    };
    let (robots, generations) = (number(0, 0)?, number(1, 2)?);
    let base = saltus_robot::resolve("rats-run", &[])?;
    let mut all = vec![("rats-run".to_owned(), base.clone())];
    for k in 0..robots {
        let robot = drawn_robot(&base, &Draw::default(), HELD_OUT, k)?;
        all.push((format!("robot {k}"), robot));
    }
    println!("robot, friction: best sequence, smooth, smooth of this robot, policy (s)");
    let mut excess = Vec::new();
    let mut laws = Vec::new();
    for (name, robot) in all {
        let smooth = setup(&robot, Smooth::QUICK.program());
        let quest = Quest {
            distance: DISTANCE,
            levels: LEVELS,
        };
        let policy = optimal(&smooth, quest, available(), |_, _| ()).ok();
        let firings = policy.as_ref().map_or(&[][..], |policy| &policy.sequence);
        let (best, least) = sequence(&robot, firings, generations);
        let start = [Smooth::QUICK.firing_angle, Smooth::QUICK.valve_open].concat();
        let of = |x: &[f64]| time(&setup(&robot, law(x).program()));
        let own = sought(start, BOUNDS.to_vec(), 0.15, generations, of);
        let [smooth, own_time] = [time(&smooth), own.1];
        let policy = policy.map_or(f64::NAN, |policy| policy.time);
        let friction = robot.ground.static_friction;
        println!("{name}, {friction:.3}: {least:.3}, {smooth:.3}, {own_time:.3}, {policy:.3}");
        println!("  firings {:.3?}", &best[..8]);
        excess.push(own_time / least - 1.0);
        laws.push(smooth / least - 1.0);
    }
    for (name, over) in [("of many robots", laws), ("of each robot", excess)] {
        let most = over.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        println!(
            "smooth law {name} over the best sequence: at most {:.1} %",
            100.0 * most
        );
    }
    Ok(())
}
