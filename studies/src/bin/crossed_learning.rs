//! Which reading of table 6.2 learns: four algorithms, two readings of its columns, two rewards, with and without the
//! valve's delay, on `run-legs`; then the algorithms under each other's schedules of exploration.
//!
//! ```text
//! cd studies && cargo run --release --bin crossed_learning -- 30 1000
//! ```
//!
//! Seeds and episodes; 2 and 3 where nothing is given. With 30 and 1000 it takes about 200 minutes of one core, and
//! prints each row as soon as it is there; `broken` counts the episodes in which the motion of rigid bodies could not be
//! computed to the end. A third and fourth number are the first row, from 0, and how many.

use std::io::Write;

use saltus::gait::learn::{Algorithm, Reward, Term};
use saltus::learning::{Interval, Learnt, PolicyFile, Settings, Task, interquartile, learn};
use saltus::numeric::parallel::available;
use saltus::robot::Robot;

/// Episodes that the thesis gives traces.
const TRACES: usize = 100;
/// Angle (rad) in 1 s above which a robot runs at all.
const RUNS: f64 = 1.0;

/// A row of the table.
#[derive(Clone, Copy)]
struct Crossed {
    algorithm: Algorithm,
    /// Whether α and γ are as printed, or interchanged.
    printed: bool,
    /// Whether the reward is ±1 at 2 rad/s, or the rate.
    threshold: bool,
    delay: bool,
    decay: f64,
}

fn rows() -> Vec<Crossed> {
    let usual = |algorithm: Algorithm| if algorithm.has_traces() { 0.95 } else { 0.99 };
    let mut rows = Vec::new();
    for delay in [true, false] {
        for printed in [true, false] {
            for threshold in [true, false] {
                rows.extend(Algorithm::ALL.map(|algorithm| Crossed {
                    algorithm,
                    printed,
                    threshold,
                    delay,
                    decay: usual(algorithm),
                }));
            }
        }
    }
    for threshold in [true, false] {
        rows.extend(Algorithm::ALL.map(|algorithm| Crossed {
            algorithm,
            printed: false,
            threshold,
            delay: true,
            decay: if algorithm.has_traces() { 0.99 } else { 0.95 },
        }));
    }
    rows
}

impl Crossed {
    fn settings(&self, robot: &Robot) -> Settings {
        let mut robot = robot.clone();
        if !self.delay {
            robot.leg.delay = 0.0;
        }
        let mut settings = Task::RunLegs.settings(robot, self.algorithm);
        if !self.printed {
            let rates = &mut settings.rates;
            (rates.alpha, rates.gamma) = (rates.gamma, rates.alpha);
        }
        if !self.threshold {
            settings.reward = Reward(vec![(Term::Rate, 1.0)]);
        }
        settings.schedule.decay = self.decay;
        settings
    }
}

fn said(interval: Option<Interval>) -> String {
    interval.map_or("–".into(), |it| {
        let [low, high] = it.interval;
        format!("{:.2} [{low:.2} {high:.2}]", it.value)
    })
}

fn angles(learnt: &Learnt) -> Vec<f64> {
    let scores = learnt.pupils.iter().map(|pupil| pupil.score.outcome.angle);
    scores.collect()
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .map(|it| it.parse())
        .collect::<Result<_, _>>()?;
    let [seeds, episodes] = match given[..] {
        [seeds, episodes, ..] => [seeds, episodes],
        _ => [2, 3],
    };
    let (first, count) = (
        given.get(2).copied().unwrap_or(0),
        given.get(3).copied().unwrap_or(usize::MAX),
    );
    let robot = saltus::resolve("rats-run", &[])?;
    println!(
        "Angle (rad) in 1 s without exploration; episodes to 90 % of the last tenth's angle.\n"
    );
    println!(
        "| row | algorithm | alpha, gamma | reward | delay (ms) | decay | {TRACES} episodes | {episodes} episodes | best | run | episodes to 90 % | broken |"
    );
    println!("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |");
    for (number, row) in rows().into_iter().enumerate().skip(first).take(count) {
        let mut settings = row.settings(&robot);
        settings.schedule.episodes = TRACES.min(episodes);
        let early = learn(&settings, (1, seeds), None, available(), &|| true)?;
        let file = PolicyFile::of(&settings, &early);
        settings.schedule.episodes = episodes;
        let learnt = learn(&settings, (1, seeds), Some(&file), available(), &|| true)?;
        let late = angles(&learnt);
        let waits = learnt.pupils.iter();
        let waits = waits.filter_map(|pupil| settings.episodes_to_90_percent(&pupil.curve));
        let waits: Vec<f64> = waits.map(|count| count as f64).collect();
        let curves = learnt.pupils.iter().flat_map(|pupil| &pupil.curve);
        let broken = curves.filter(|score| score.outcome.broken).count();
        println!(
            "| {number} | {} | {}, {} | {} | {} | {} | {} | {} | {:.2} | {} of {seeds} | {} | {broken} |",
            row.algorithm.name(),
            settings.rates.alpha,
            settings.rates.gamma,
            if row.threshold {
                "±1 at 2 rad/s"
            } else {
                "rate"
            },
            1e3 * settings.plant.robot.leg.delay,
            row.decay,
            said(interquartile(&angles(&early))),
            said(interquartile(&late)),
            late.iter().copied().fold(f64::MIN, f64::max),
            late.iter().filter(|angle| **angle > RUNS).count(),
            said(interquartile(&waits)),
        );
        std::io::stdout().flush()?;
    }
    Ok(())
}
