//! Which of the thesis' explanations of what tables did not learn holds (6.4): on `run-legs`, coarse steps, no pivot, no piston.
//! SARSA(λ) with tile coding sees more of the robot, one number after the other.
//!
//! ```text
//! cd studies && cargo run --release --bin seen_states -- 30 500
//! ```
//!
//! Seeds and episodes; 2 and 3 where nothing is given. Rates and tilings were chosen on seeds 1001 to 1006.

use std::io::Write;

use saltus::gait::GaitError;
use saltus::gait::learn::{Algorithm, Bin, Reward, Score, Term};
use saltus::learning::{Task, interquartile};
use saltus::numeric::parallel::{available, map_on};
use saltus_studies::tiles::{Tiled, Tiles};

type Failed = Box<dyn std::error::Error>;

/// Episode of the trial without exploration: one that no training has.
const TRIAL: usize = 1 << 40;

/// Of each number that is observed: the steps where it is seen.
const SEEN: [(&str, Bin); 8] = {
    const fn bin(from: f64, to: f64, count: usize) -> Bin {
        Bin { from, to, count }
    }
    [
        (
            "angle",
            bin(-std::f64::consts::PI, std::f64::consts::PI, 10),
        ),
        ("rate", bin(-10.0, 21.0, 10)),
        ("pivot", bin(-0.1, 0.1, 4)),
        ("pivot rate", bin(-1.0, 1.0, 4)),
        ("extension", bin(0.0, 0.06, 3)),
        ("pressure", bin(1e5, 9.3e5, 3)),
        ("time since firing", bin(0.0, 0.1, 4)),
        ("time", bin(0.0, 1.0, 1)),
    ]
};

fn main() -> Result<(), Failed> {
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .map(|it| it.parse())
        .collect::<Result<_, _>>()?;
    let [seeds, episodes] = match given[..] {
        [seeds, episodes] => [seeds, episodes],
        _ => [2, 3],
    };
    println!(
        "| seen | states | angle in 1 s (rad) | best | episodes to 90 % |\n| --- | --- | --- | --- | --- |"
    );
    // Which numbers are seen; none: table 6.1 as it is.
    let rows: [&[usize]; 8] = [
        &[],
        &[0, 1],
        &[0, 1, 2],
        &[0, 1, 3],
        &[0, 1, 4],
        &[0, 1, 5],
        &[0, 1, 6],
        &[0, 1, 3, 4, 5],
    ];
    for seen in rows {
        let robot = saltus::resolve("rats-run", &[])?;
        let mut settings = Task::RunLegs.settings(robot, Algorithm::SarsaLambda);
        settings.reward = Reward(vec![(Term::Rate, 1.0)]);
        settings.rates.alpha = 0.1;
        settings.rates.gamma = 0.995;
        settings.rates.lambda = 0.95;
        settings.schedule.decay = 0.99;
        settings.schedule.episodes = episodes;
        let bins = SEEN.iter().enumerate().map(|(axis, (_, bin))| {
            let count = if seen.contains(&axis) { bin.count } else { 1 };
            Bin { count, ..*bin }
        });
        let tiles = if seen.is_empty() {
            Tiles::new(settings.bins.axes().to_vec(), 1)
        } else {
            Tiles::new(bins.collect(), 8)
        };
        let one = |k: usize| -> Result<(f64, Option<usize>), GaitError> {
            let (environment, seed) = (settings.environment()?, k as u64 + 1);
            let mut tiled = Tiled::new(environment.as_ref(), &tiles, settings.rates);
            let curve = tiled.learn(&settings.schedule, seed)?.into_iter();
            let curve = curve.map(|outcome| Score {
                outcome,
                ..Score::default()
            });
            let curve: Vec<Score> = curve.collect();
            let angle = tiled.trial((seed, TRIAL))?.angle;
            Ok((angle, settings.episodes_to_90_percent(&curve)))
        };
        let learnt = map_on(available(), seeds, one)
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?;
        let angles: Vec<f64> = learnt.iter().map(|it| it.0).collect();
        let waits = learnt.iter().filter_map(|it| it.1);
        let waits: Vec<f64> = waits.map(|count| count as f64).collect();
        let said = |values: &[f64], digits: usize| {
            interquartile(values).map_or("–".into(), |it| {
                let [low, high] = it.interval;
                format!("{:.digits$} [{low:.digits$} {high:.digits$}]", it.value)
            })
        };
        let names: Vec<&str> = seen.iter().map(|axis| SEEN[*axis].0).collect();
        let name = if names.is_empty() {
            "table 6.1".into()
        } else {
            format!("8 tilings of {}", names.join(", "))
        };
        println!(
            "| {name} | {} | {} | {:.2} | {} |",
            tiles.states(),
            said(&angles, 2),
            angles.iter().copied().fold(f64::MIN, f64::max),
            said(&waits, 0)
        );
        std::io::stdout().flush()?;
    }
    Ok(())
}
