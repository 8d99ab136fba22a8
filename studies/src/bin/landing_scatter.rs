//! Three legs accelerate and the fourth jumps: how far the landings of drawn robots scatter under the
//! thesis' law α_f = −0.1 s ω + 0.46 rad, a constant angle, and a line sought for 1 m (5.2.3).
//!
//! ```text
//! cd studies && cargo run --release --bin landing_scatter -- 120 40 100
//! ```
//!
//! Supply pressure (psi), robots on which constant and line are sought, others that are scored; 120
//! 2 4 where nothing is given. A distance goes from the foot that jumps to the axle at the landing.

use saltus_controller::run::Leap;
use saltus_gait::{Draw, Footfall, GaitError, Program, Row, Run, Setup, drawn_robot, run};
use saltus_numeric::parallel::{available, map_on};
use saltus_robot::Robot;

/// Firing angles (rad) and valve opening times (s) of the first three legs: those that `saltus jump`
/// finds for the box of 21 cm at 1.3 m and 160 psi, where the second one already jumps over the box.
const FIRST: [[f64; 2]; 3] = [[0.0425, 0.0535], [0.3330, 0.0572], [-0.0477, 0.0556]];
/// A (s) and B (rad) of the thesis.
const THESIS: [f64; 2] = [-0.1, 0.46];
/// The distance that is sought (m).
const WANTED: f64 = 1.0;
/// Seeds of the robots that are sought on, and of those that are scored.
const SEEDS: [u64; 2] = [300, 400];

/// A count given as a number.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn count(x: f64) -> usize {
    x.round() as usize
}

/// Where the jump began, and how far away it ended.
#[derive(Default)]
struct Jumped {
    firings: usize,
    /// When the jump was fired (s), where its foot stands (m), and the filtered rate then (rad/s).
    from: Option<(f64, f64)>,
    rate: f64,
    distance: Option<f64>,
}

impl Run for Jumped {
    fn row(&mut self, row: &Row<'_>) {
        if row.action.leg.is_some() {
            self.firings += 1;
            if self.firings == FIRST.len() + 1 {
                let foot = row.axle[0] - 0.24 * row.action.lean.sin();
                self.from = Some((row.time, foot));
                self.rate = row.action.rate;
            }
        }
    }

    fn footfall(&mut self, footfall: &Footfall) {
        if let Some((time, foot)) = self.from
            // Within 0.15 s the leg that fires still stands.
            && footfall.time > time + 0.15
        {
            self.distance.get_or_insert(footfall.travel - foot);
        }
    }

    fn goes_on(&mut self) -> bool {
        self.distance.is_none()
    }
}

/// Distances (m) and rates at the firing (rad/s) of `robots` drawn with `seed` that jump by the line [A, B].
fn distances(
    robot: &Robot,
    robots: usize,
    seed: u64,
    line: [f64; 2],
) -> Result<Vec<[f64; 2]>, GaitError> {
    let one = |k: usize| {
        let setup = Setup {
            seed: seed + k as u64,
            zone: -0.3,
            first: FIRST.to_vec(),
            leap: Some(Leap {
                after: 3,
                slope: line[0],
                level: line[1],
                least: -0.3,
                most: 0.6,
                valve_open: 0.1,
                shock: 10024,
            }),
            ..Setup::new(
                drawn_robot(robot, &Draw::default(), seed, k)?,
                Program::Fixed { firing_angle: 0.1 },
                3.0,
            )
        };
        let mut jumped = Jumped::default();
        run(&setup, &mut jumped)?;
        Ok(jumped.distance.map(|distance| [distance, jumped.rate]))
    };
    let all: Vec<Option<[f64; 2]>> = map_on(available(), robots, one)
        .into_iter()
        .collect::<Result<_, GaitError>>()?;
    Ok(all.into_iter().flatten().collect())
}

/// Mean, standard deviation, and root of the mean square off [`WANTED`] (m).
fn scatter(all: &[[f64; 2]]) -> [f64; 3] {
    let n = all.len() as f64;
    let mean = all.iter().map(|x| x[0]).sum::<f64>() / n;
    let off = |from: f64| (all.iter().map(|x| (x[0] - from).powi(2)).sum::<f64>() / n).sqrt();
    [mean, off(mean), off(WANTED)]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let numbers: Vec<f64> = std::env::args()
        .skip(1)
        .map(|x| x.parse())
        .collect::<Result<_, _>>()?;
    let [psi, sought, scored] = match numbers[..] {
        [] => [120.0, 2.0, 4.0],
        [a, b, c] => [a, b, c],
        _ => return Err("give three numbers".into()),
    };
    let robot = saltus_robot::resolve(
        "rats-run",
        &[format!("leg.supply_pressure_gauge_psi={psi}")],
    )?;
    let best = |slopes: &[f64]| -> Result<[f64; 2], GaitError> {
        let mut best = ([0.0, 0.0], f64::INFINITY);
        for slope in slopes {
            for k in 0..9 {
                // The angle at 6 rad/s, about the middle of the rates, from −0.3 to 0.3 rad.
                let line = [*slope, -0.3 + 0.075 * f64::from(k) - 6.0 * slope];
                let all = distances(&robot, count(sought), SEEDS[0], line)?;
                let [_, _, off] = scatter(&all);
                if off < best.1 {
                    best = (line, off);
                }
            }
        }
        Ok(best.0)
    };
    for (name, line) in [
        ("thesis", THESIS),
        ("constant", best(&[0.0])?),
        ("line", best(&[-0.15, -0.1, -0.05, 0.05])?),
    ] {
        let all = distances(&robot, count(scored), SEEDS[1], line)?;
        let [mean, deviation, off] = scatter(&all);
        let mut rates: Vec<f64> = all.iter().map(|x| x[1]).collect();
        rates.sort_by(f64::total_cmp);
        let part = |k: usize| rates[(rates.len() * k / 100).min(rates.len() - 1)];
        println!(
            "{name}: α_f = {:.3} s ω + {:.3} rad: {} land, {mean:.3} m, standard deviation \
             {deviation:.3} m, {off:.3} m off 1 m (root mean square); rates {:.1}, {:.1}, {:.1} \
             rad/s (5 %, half, 95 %)",
            line[0],
            line[1],
            all.len(),
            part(5),
            part(50),
            part(95),
        );
    }
    Ok(())
}
