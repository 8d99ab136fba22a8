//! The best policy over the strides of `rats-run`, flown with sensors, and on drawn robots beside the
//! smooth law.
//!
//! ```text
//! cd studies && cargo run --release --bin optimal -- 4 1.6 0.9 100
//! ```
//!
//! Levels of refinement, distance (m), friction along the travel, drawn robots: 2, 1.6, 0.9 and 2
//! where nothing is given.

use saltus_gait::{Draw, Ensemble, GaitError, Program, Quest, Setup, Smooth, optimal, run};
use saltus_numeric::parallel::available;
use saltus_robot::Robot;

/// Seed of the drawn robots: those on which the smooth law is scored.
const HELD_OUT: u64 = 200;
/// Noises with which the table is flown.
const NOISES: u64 = 20;

fn setup(robot: &Robot, program: Program, distance: f64) -> Setup {
    let mut setup = Setup::new(robot.clone(), program, 2.0 + 2.0 * distance);
    setup.zone = -0.3;
    setup.mark = distance;
    setup
}

/// Times (s) to the distance under each noise, rising; infinite where it never comes there.
fn flown(of: &Setup) -> Result<Vec<f64>, GaitError> {
    let one = |seed| {
        let setup = Setup { seed, ..of.clone() };
        run(&setup, &mut ()).map(|s| s.time_to_mark.unwrap_or(f64::INFINITY))
    };
    let mut times = (1..=NOISES).map(one).collect::<Result<Vec<_>, _>>()?;
    times.sort_by(f64::total_cmp);
    Ok(times)
}

fn drawn(name: &str, of: Setup, robots: usize) -> Result<(), GaitError> {
    let ensemble = Ensemble {
        setup: of,
        draw: Draw::default(),
        robots,
        seed: HELD_OUT,
    };
    let all = ensemble.run(available(), &|| ())?;
    let times = all.iter().map(|s| s.time_to_mark.unwrap_or(f64::INFINITY));
    let mut times: Vec<f64> = times.collect();
    times.sort_by(f64::total_cmp);
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
    let smooth = setup(&robot, Smooth::QUICK.program(), distance);
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
    let table = setup(&robot, Program::Policy(found.table.clone()), distance);
    for (name, setup) in [("table", &table), ("smooth", &smooth)] {
        let times = flown(setup)?;
        let (least, most) = (times[0], times[times.len() - 1]);
        println!(
            "{name}: flown in {least:.3} to {most:.3} s, median {:.3} s",
            times[times.len() / 2]
        );
    }
    println!("predicted: {:.3} s", found.time);
    drawn("table", table, robots)?;
    drawn("smooth", smooth, robots)?;
    Ok(())
}
