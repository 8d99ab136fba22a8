//! rats-twelve out of a run over a box, or onto it: seeks how its twins jump, and tries it on 100 other robots.
//!
//! ```text
//! cd studies && cargo run --release --bin over_box -- 0.21 2.2 2.2 16 3 100
//! cd studies && cargo run --release --bin over_box -- 0.12 2.2 2.2 16 3 100 onto
//! ```
//!
//! Height (m) of the box, its nearest and farthest front (m), robots to seek on, generations, and other robots; where nothing
//! is given, 0.21 2.2 2.2 2 1 20. It is 0.21 m long, 4 m with `onto`.

use saltus_gait::Obstacle;
use saltus_numeric::parallel::available;
use saltus_studies::jumps_in_space::{Over, Passed};

/// A count given as a number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn count(x: f64) -> usize {
    x.round() as usize
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut words: Vec<String> = std::env::args().skip(1).collect();
    let is_onto = words.pop_if(|word| word == "onto").is_some();
    let numbers: Vec<f64> = words.iter().map(|x| x.parse()).collect::<Result<_, _>>()?;
    let [height, front, farthest, robots, generations, others] = match numbers[..] {
        [] => [0.21, 2.2, 2.2, 2.0, 1.0, 20.0],
        [a, b, c, d, e, f] => [a, b, c, d, e, f],
        _ => return Err("give six numbers".into()),
    };
    let robot = saltus_robot::resolve("rats-twelve", &[])?;
    let obstacle = Obstacle {
        front,
        length: if is_onto { 4.0 } else { 0.21 },
        height,
    };
    let over = if is_onto {
        Over::onto(&robot, obstacle, farthest, available())?
    } else {
        Over::new(&robot, obstacle, farthest, available())?
    };
    let sought = (count(robots), count(generations));
    let leap = over.plan(sought, available(), |k, best, _| eprintln!("{k} {best:.4}"))?;
    let passed = over.try_on(&leap, (count(others), 1001), available())?;
    let did = |what: fn(&Passed) -> bool| passed.iter().filter(|it| what(it)).count();
    println!(
        "{} cleared, {} went on, {} did not jump, of {}; {leap:.4?}",
        did(|it| it.cleared),
        did(|it| it.ran_on),
        did(|it| it.jumped.is_none()),
        passed.len()
    );
    Ok(())
}
