//! How much of the time of learning is the learners': the same random actions with and without a table that learns from them.
//!
//! ```text
//! cd studies && cargo run --release --bin learning_overhead -- 100 5
//! ```
//!
//! Episodes of 1000 steps of `run-legs` in a round, and rounds, in which all take turns; 2 and 2 where nothing is given. Times
//! are medians.

use std::time::Instant;

use saltus_gait::GaitError;
use saltus_gait::learn::{
    Act, Algorithm, Bins, Environment, Legs, Plant, Rates, Reward, Schedule, Term, Training, train,
};

const STEPS: usize = 1000;

/// Seconds for episodes of random actions, without anything that learns.
fn alone(environment: &dyn Environment, episodes: usize) -> Result<f64, GaitError> {
    let begin = Instant::now();
    for episode in 0..episodes {
        let mut running = environment.start(Training::start_of((1, episode)))?;
        let mut word = episode as u64;
        loop {
            word = word.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let choice = usize::try_from((word >> 33) % 6).unwrap_or(0);
            if running.step(Act::Choice(choice))?.is_over() {
                break;
            }
        }
    }
    Ok(begin.elapsed().as_secs_f64())
}

/// The same with a table: every action is random, and learnt from.
fn learnt(
    environment: &dyn Environment,
    algorithm: Algorithm,
    episodes: usize,
) -> Result<f64, GaitError> {
    let training = Training {
        environment,
        bins: Bins::of_table_6_1(),
        algorithm,
        rates: Rates {
            alpha: 0.3,
            gamma: 1.0,
            lambda: 0.9,
        },
        schedule: Schedule {
            epsilon: 1.0,
            decay: 1.0,
            episodes,
        },
    };
    let mut table = training.table()?;
    let begin = Instant::now();
    train(&training, &mut table, (1, 0), |_, _, _| true)?;
    Ok(begin.elapsed().as_secs_f64())
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .map(|it| it.parse())
        .collect::<Result<_, _>>()?;
    let (episodes, rounds) = match given[..] {
        [episodes, rounds] => (episodes, rounds),
        _ => (2, 2),
    };
    let robot = saltus_robot::resolve("rats-run", &[])?;
    let reward = Reward(vec![(Term::Threshold(2.0), 1.0)]);
    let environment = Legs::new(Plant::new(robot), reward, STEPS)?;
    let mut times = vec![Vec::new(); 1 + Algorithm::ALL.len()];
    for _ in 0..rounds {
        times[0].push(alone(&environment, episodes)?);
        for (k, algorithm) in Algorithm::ALL.into_iter().enumerate() {
            times[1 + k].push(learnt(&environment, algorithm, episodes)?);
        }
    }
    let medians: Vec<f64> = times.into_iter().map(median).collect();
    let steps = (episodes * STEPS) as f64;
    println!(
        "simulation alone: {:.2} us a step",
        1e6 * medians[0] / steps
    );
    for (algorithm, time) in Algorithm::ALL.into_iter().zip(&medians[1..]) {
        println!(
            "{}: {:.2} us a step, {:+.1} %",
            algorithm.name(),
            1e6 * time / steps,
            100.0 * (time / medians[0] - 1.0)
        );
    }
    Ok(())
}
