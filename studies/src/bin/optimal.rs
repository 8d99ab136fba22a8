//! The best policy over the strides of `rats-run`, flown with sensors, and on drawn robots beside the
//! smooth law.
//!
//! ```text
//! cd studies && cargo run --release --bin optimal -- 4 1.6 0.9 100
//! ```
//!
//! Levels of refinement, distance (m), friction along the travel, drawn robots: 2, 1.6, 0.9 and 2
//! where nothing is given.

use saltus_gait::{Draw, Footfall, GaitError, Row, Run, Setup, Smooth, drawn_robot, run};
use saltus_numeric::parallel::{available, map_on};
use saltus_studies::optimal::{Quest, Table, flown, optimal};

/// Seed of the drawn robots: those on which the smooth law is scored.
const HELD_OUT: u64 = 200;
/// Noises with which the table is flown.
const NOISES: u64 = 20;

/// Ends a run at a distance (m), and keeps the time (s).
struct To(f64, Option<f64>);

impl Run for To {
    fn row(&mut self, row: &Row<'_>) {
        if row.axle[0] >= self.0 {
            self.1.get_or_insert(row.time);
        }
    }
    fn footfall(&mut self, _: &Footfall) {}
    fn goes_on(&mut self) -> bool {
        self.1.is_none()
    }
}

/// Time (s) to the distance by `table`, or without one by the program of `setup`; infinite where it never comes there.
fn time(setup: &Setup, table: Option<&Table>, distance: f64) -> Result<f64, GaitError> {
    let arrived = if let Some(table) = table {
        flown(setup, table, distance)?
    } else {
        let mut to = To(distance, None);
        run(setup, &mut to)?;
        to.1
    };
    Ok(arrived.unwrap_or(f64::INFINITY))
}

/// All times, rising.
fn sorted(times: Vec<Result<f64, GaitError>>) -> Result<Vec<f64>, GaitError> {
    let mut times = times.into_iter().collect::<Result<Vec<_>, _>>()?;
    times.sort_by(f64::total_cmp);
    Ok(times)
}

fn drawn(
    name: &str,
    of: &Setup,
    table: Option<&Table>,
    (distance, robots): (f64, usize),
) -> Result<(), GaitError> {
    let one = |k: usize| {
        let setup = Setup {
            robot: drawn_robot(&of.robot, &Draw::default(), HELD_OUT, k)?,
            seed: of.seed + k as u64,
            ..of.clone()
        };
        time(&setup, table, distance)
    };
    let times = sorted(map_on(available(), robots, one))?;
    let arrived = times.iter().filter(|time| time.is_finite()).count();
    println!(
        "{name}: {arrived} of {robots} drawn robots arrive; median {:.3} s, least {:.3} s",
        times[robots / 2],
        times[0]
    );
    Ok(())
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let given =
        |k: usize, usual: &'static str| arguments.get(k).map_or(usual, String::as_str).to_owned();
    let levels: usize = given(0, "2").parse()?;
    let (distance, friction): (f64, f64) = (given(1, "1.6").parse()?, given(2, "0.9").parse()?);
    let robots: usize = given(3, "2").parse()?;
    let mut robot = saltus_robot::resolve("rats-run", &[])?;
    robot.ground.static_friction = friction;
    robot.ground.kinetic_friction = friction;
    let program = Smooth::QUICK.program();
    let mut smooth = Setup::new(robot, program, 2.0 + 2.0 * distance);
    smooth.zone = -0.3;
    let quest = Quest { distance, levels };
    let found = optimal(&smooth, quest, available(), |_, _| ())?;
    for level in &found.levels {
        println!(
            "{} cells, {} choices: {:.4} s, Bellman residual {:.1e} s after {} sweeps",
            level.cells, level.choices, level.value, level.residual, level.sweeps
        );
    }
    println!(
        "fastest firings met: {:.3} s with {:.3?}",
        found.sequence_time, found.sequence
    );
    let laws = [("table", Some(&found.table)), ("smooth", None)];
    for (name, table) in laws {
        let one = |seed| {
            let setup = Setup {
                seed,
                ..smooth.clone()
            };
            time(&setup, table, distance)
        };
        let times = sorted((1..=NOISES).map(one).collect())?;
        let (least, most) = (times[0], times[times.len() - 1]);
        println!(
            "{name}: flown in {least:.3} to {most:.3} s, median {:.3} s",
            times[times.len() / 2]
        );
    }
    println!("predicted: {:.3} s", found.time);
    for (name, table) in laws {
        drawn(name, &smooth, table, (distance, robots))?;
    }
    Ok(())
}
