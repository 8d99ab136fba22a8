//! Learns what each leg does before boxes that a range sensor sees, and tries it on 100 other robots.
//!
//! ```text
//! cd studies && cargo run --release --bin sensed_box -- 120 1 6 2.6 1500 6 0.08 0.1 0.12
//! ```
//!
//! Supply pressure (psi), nearest and farthest front of the box (m), room to run up (m), runs in each
//! round, rounds; then heights of the boxes (m), 21 cm long. Where nothing is given, 120 1 6 2.6 20 1 0.1,
//! on 4 robots.

use saltus_gait::{Draw, Sensed, Smooth};
use saltus_numeric::parallel::available;

/// A count given as a number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn count(x: f64) -> usize {
    x.round() as usize
}

/// Seed of `saltus jump`: the robots of the trial are not those of the table.
const SEED: u64 = 1;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse())
        .collect::<Result<_, _>>()?;
    let (numbers, robots) = if numbers.is_empty() {
        (vec![120.0, 1.0, 6.0, 2.6, 20.0, 1.0, 0.1], 4)
    } else {
        (numbers, 100)
    };
    let [psi, from, to, room, runs, rounds, heights @ ..] = &numbers[..] else {
        return Err("give six numbers, and heights".into());
    };
    let sensed = Sensed {
        robot: saltus_robot::resolve(
            "rats-run",
            &[format!("leg.supply_pressure_gauge_psi={psi}")],
        )?,
        draw: Draw::default(),
        heights: heights.to_vec(),
        length: 0.21,
        fronts: [*from, *to],
        room: *room,
        law: Smooth::QUICK,
        runs: count(*runs),
        rounds: count(*rounds),
        seed: SEED,
    };
    let tables = sensed.plan(available(), |round| eprintln!("round {round}"))?;
    for table in &tables {
        let all = sensed.try_on(table, robots, SEED + (1 << 32), available())?;
        let cleared = all.iter().filter(|f| f.cleared).count();
        let on = all.iter().filter(|f| f.cleared && f.speed_after > 1.0);
        println!(
            "{psi} psi, {} m: {cleared} of {robots} cleared (expected {:.3}), of which {} run on",
            table.height,
            table.expected,
            on.count()
        );
        let misses = all.iter().filter(|f| !f.cleared);
        let misses: Vec<String> = misses
            .map(|f| format!("{:.2} m by {:.3}", f.front, f.clearance))
            .collect();
        println!("  not cleared, front and clearance: {}", misses.join(", "));
    }
    Ok(())
}
