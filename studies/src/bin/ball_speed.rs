//! How long a time step of a robot in space takes: the one side of `tests/mujoco/run.py ball_speed`.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_speed -- rats-twelve STATES.csv 1e-3 0.2
//! ```
//!
//! From each state of a file that the study `ball_touch_downs` wrote, the simulation goes on for a while (0.2 s) in steps of
//! fixed length (1e-3 s). The answer is the time of a step (µs) and the feet on the ground (mean); of each state the fastest of
//! three runs counts. Without a file it is a ball at rest.

use std::path::Path;

use saltus_robot::Robot;
use saltus_robot::space::rests;
use saltus_sim_check::{LegStart, Rig, Settings, Sim, Stepping};

type Error = Box<dyn std::error::Error>;

/// Runs of each state.
const RUNS: usize = 3;

struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    legs: Vec<LegStart>,
}

/// The states in the text of a file, of a robot with so many coordinates and velocities.
fn states(text: &str, (coordinates, velocities): (usize, usize)) -> Result<Vec<State>, Error> {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').skip(1).collect();
        let moving = cells.iter().take(coordinates + velocities);
        let moving: Vec<f64> = moving
            .map(|cell| cell.parse())
            .collect::<Result<_, std::num::ParseFloatError>>()?;
        let leg = |cells: &[&str]| {
            let valve = match cells {
                [from, until] if !from.is_empty() => Some([from.parse()?, until.parse()?]),
                _ => None,
            };
            Ok(LegStart {
                pressure: 101_325.0,
                valve,
            })
        };
        let legs = cells[coordinates + velocities..].chunks(2).map(leg);
        Ok(State {
            q: moving[..coordinates].to_vec(),
            v: moving[coordinates..].to_vec(),
            legs: legs.collect::<Result<_, Error>>()?,
        })
    };
    text.lines().skip(1).map(row).collect()
}

/// A ball that lies still.
fn at_rest(robot: &Robot, rig: &Rig) -> Result<State, Error> {
    let space = robot.space.as_ref().ok_or("a robot in space")?;
    let directions = space.directions.vectors();
    let leg = LegStart {
        pressure: 101_325.0,
        valve: None,
    };
    Ok(State {
        q: rig.stand_on(&rests(&directions)[0], &directions[0])?,
        v: vec![0.0; rig.mechanism.tree.velocities()],
        legs: vec![leg; directions.len()],
    })
}

/// The time (s) of all steps of `step` (s) up to `seconds`, and over these the sum of the feet on the ground.
fn timed(rig: &Rig, state: &State, (step, seconds): (f64, f64)) -> Result<[f64; 2], Error> {
    let settings = Settings {
        stepping: Stepping::Fixed(step),
        most_steps: usize::MAX,
        ..Settings::default()
    };
    let mut sim = Sim::in_motion(&rig.mechanism, &state.q, &state.v, &state.legs, settings)?;
    // A length of time over a step is a count.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let steps = (seconds / step).round() as u32;
    let begin = worked()?;
    for k in 1..=steps {
        sim.run(f64::from(k) * step, &[])?;
        sim.drain_events();
    }
    let spent = worked()? - begin;
    let mut sim = Sim::in_motion(&rig.mechanism, &state.q, &state.v, &state.legs, settings)?;
    let mut feet = 0;
    for k in 1..=steps {
        sim.run(f64::from(k) * step, &[])?;
        let gaps = rig.foot_gaps(sim.coordinates());
        feet += gaps.iter().filter(|gap| **gap <= 0.0).count();
    }
    Ok([spent, feet as f64])
}

/// Time (s) that the processor has worked for this thread (Linux).
fn worked() -> Result<f64, Error> {
    let all = std::fs::read_to_string("/proc/thread-self/schedstat")?;
    let first = all.split_whitespace().next().ok_or("schedstat is empty")?;
    Ok(1e-9 * first.parse::<f64>()?)
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let word = |k: usize, usual: &str| arguments.get(k).map_or(usual.into(), String::clone);
    let name = word(0, "rats-twelve");
    let (step, seconds): (f64, f64) = (word(2, "1e-3").parse()?, word(3, "0.2").parse()?);
    let robot = match Robot::builtin(&name) {
        Some(robot) => robot,
        None => Robot::load(Path::new(&name))?,
    };
    let rig = Rig::new(&robot, &[])?;
    let tree = &rig.mechanism.tree;
    let all = match arguments.get(1) {
        Some(path) => {
            let sizes = (tree.coordinates(), tree.velocities());
            states(&std::fs::read_to_string(path)?, sizes)?
        }
        None => vec![at_rest(&robot, &rig)?],
    };
    let (mut spent, mut feet) = (0.0, 0.0);
    for state in &all {
        let mut least = f64::INFINITY;
        for _ in 0..RUNS {
            let [time, touching] = timed(&rig, state, (step, seconds))?;
            least = least.min(time);
            feet += touching / RUNS as f64;
        }
        spent += least;
    }
    let steps = all.len() as f64 * (seconds / step).round();
    println!("{:.4} {:.4}", 1e6 * spent / steps, feet / steps);
    Ok(())
}
