//! Which of the thesis' explanations of what tables did not learn holds (6.4): on `run-legs`, coarse steps, no pivot, no piston.
//! SARSA(λ) with tile coding sees more of the robot, one number after the other.
//!
//! ```text
//! cd studies && cargo run --release --bin seen_states -- 30 500
//! ```
//!
//! Seeds and episodes; 2 and 3 where nothing is given. Rates and tilings were chosen on seeds 1001 to 1006.

use std::io::Write;

use saltus::gait::learn::{Algorithm, Bin, Bins, Reward, Term, Traces};
use saltus::learning::{Method, Task, interquartile, learn};
use saltus::numeric::parallel::available;

type Failed = Box<dyn std::error::Error>;

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
        let mut settings = Task::RunLegs.settings(robot, Method::Values(Algorithm::SarsaLambda));
        settings.reward = Reward(vec![(Term::Rate, 1.0)]);
        settings.rates.alpha = 0.1;
        settings.rates.gamma = 0.995;
        settings.rates.lambda = 0.95;
        settings.rates.traces = Traces::Replacing;
        settings.schedule.decay = 0.99;
        settings.schedule.episodes = episodes;
        if !seen.is_empty() {
            let bins = SEEN.iter().enumerate().map(|(axis, (_, bin))| {
                let count = if seen.contains(&axis) { bin.count } else { 1 };
                Bin { count, ..*bin }
            });
            settings.bins = Bins::new(bins.collect())?.tiled(8)?;
        }
        let learnt = learn(&settings, (1, seeds), None, available(), &|| true)?;
        let angles: Vec<f64> = learnt
            .pupils
            .iter()
            .map(|it| it.score.outcome.angle)
            .collect();
        let waits = learnt.pupils.iter();
        let waits: Vec<f64> = waits
            .filter_map(|it| settings.episodes_to_90_percent(&it.curve))
            .map(|count| count as f64)
            .collect();
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
            settings.bins.states(),
            said(&angles, 2),
            angles.iter().copied().fold(f64::MIN, f64::max),
            said(&waits, 0)
        );
        std::io::stdout().flush()?;
    }
    Ok(())
}
