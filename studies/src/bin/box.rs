//! Seeks the firings that take rats-run from rest over a box, and tries them on 100 other robots.
//!
//! ```text
//! cd studies && cargo run --release --bin box -- 1.3 0.21 160 3 12 16
//! ```
//!
//! Front (m) and height (m) of the box, supply pressure (psi), legs that accelerate, robots to seek
//! on, generations; where nothing is given, 1.3 0.16 120 3 2 1.

use saltus_gait::{Crossing, Draw, Obstacle};
use saltus_numeric::parallel::available;

/// A count given as a number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn count(x: f64) -> usize {
    x.round() as usize
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse())
        .collect::<Result<_, _>>()?;
    let [front, height, psi, firings, robots, generations] = match numbers[..] {
        [] => [1.3, 0.16, 120.0, 3.0, 2.0, 1.0],
        [a, b, c, d, e, f] => [a, b, c, d, e, f],
        _ => return Err("give six numbers".into()),
    };
    let robot = saltus_robot::resolve(
        "rats-run",
        &[format!("leg.supply_pressure_gauge_psi={psi}")],
    )?;
    for by_rate in [true, false] {
        let crossing = Crossing {
            robot: robot.clone(),
            draw: Draw::default(),
            obstacle: Obstacle {
                front,
                length: 0.21,
                height,
            },
            firings: count(firings),
            by_rate,
            sought_on: count(robots),
            generations: count(generations),
            seed: 100,
        };
        let plan = crossing.plan(available(), |k, best| eprintln!("{k} {best:.4}"))?;
        let tried = crossing.try_on(&plan, 100, 200, available())?;
        let cleared = tried.iter().filter(|c| c.cleared).count();
        let mut clearances: Vec<f64> = tried.iter().map(|c| c.clearance).collect();
        clearances.sort_by(f64::total_cmp);
        println!(
            "by rate {by_rate}: {cleared} of 100 cleared, clearance 5 % {:.3}, median {:.3} m; {plan:.4?}",
            clearances[5], clearances[50]
        );
    }
    Ok(())
}
