//! Onto the box of the thesis without values: a sequence of valves, forty steps of 50 ms, is changed at random and kept where
//! the reward is no less. In `climb`, no table of values makes a policy of what exploring robots do.
//!
//! ```text
//! cd studies && cargo run --release --bin hill_climbing -- 30 500
//! ```
//!
//! Seeds and episodes; 2 and 3 where nothing is given. The share that is drawn anew was chosen on other seeds, of which 30 of
//! 30 climb.

use saltus::gait::GaitError;
use saltus::gait::learn::{Algorithm, Bin, Bins, Outcome};
use saltus::learning::{Task, interquartile};
use saltus::numeric::parallel::{available, map_on};
use saltus_studies::climbing::{by_choices, hill_climb};

/// Share of the choices that are drawn anew in an episode.
const SHARE: f64 = 0.3;
/// Episode of the trial: one that no training has.
const TRIAL: usize = 1 << 40;

/// What one seed learnt.
struct Climbed {
    choices: Vec<usize>,
    outcome: Outcome,
    /// Episode in which it first stood on the box, from 1.
    first: Option<usize>,
    /// Episodes in which the motion of rigid bodies could not be computed to the end.
    broken: usize,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<usize> = std::env::args()
        .skip(1)
        .map(|it| it.parse())
        .collect::<Result<_, _>>()?;
    let [seeds, episodes] = match given[..] {
        [seeds, episodes] => [seeds, episodes],
        _ => [2, 3],
    };
    let robot = saltus::resolve("rats-run", &[])?;
    let settings = Task::Climb.settings(robot, Algorithm::Q);
    // Of what is observed the time alone, which is the last.
    let axes = Bins::of_table_6_1().axes().to_vec();
    let last = axes.len() - 1;
    let axes = axes.into_iter().enumerate().map(|(axis, bin)| {
        let count = if axis == last { 40 } else { 1 };
        Bin { count, ..bin }
    });
    let bins = Bins::new(axes.collect())?;
    let one = |k: usize| -> Result<Climbed, GaitError> {
        let (environment, seed) = (settings.environment()?, k as u64 + 1);
        let (mut first, mut broken, mut episode) = (None, 0, 0);
        let scored = |_: f64, outcome: &Outcome| {
            episode += 1;
            first = first.or(outcome.arrived.map(|_| episode));
            broken += usize::from(outcome.broken);
        };
        let choices = hill_climb(environment.as_ref(), &bins, (SHARE, episodes), seed, scored)?;
        let (_, outcome) = by_choices(environment.as_ref(), &bins, &choices, (seed, TRIAL))?;
        Ok(Climbed {
            choices,
            outcome,
            first,
            broken,
        })
    };
    let all = map_on(available(), seeds, one)
        .into_iter()
        .collect::<Result<Vec<_>, _>>()?;
    let times: Vec<f64> = all.iter().filter_map(|it| it.outcome.arrived).collect();
    println!("{} of {seeds} stand on the box", times.len());
    if let Some(it) = interquartile(&times) {
        let [low, high] = it.interval;
        println!("at {:.2} s [{low:.2} {high:.2}]", it.value);
    }
    let mut first: Vec<usize> = all.iter().filter_map(|it| it.first).collect();
    first.sort_unstable();
    if let (Some(least), Some(most)) = (first.first(), first.last()) {
        let middle = first[first.len() / 2];
        println!("for the first time after {least} to {most} episodes, {middle} in the middle");
    }
    let broken: usize = all.iter().map(|it| it.broken).sum();
    println!("broken: {broken} of {} episodes", seeds * episodes);
    if let Some(best) = all.iter().find(|it| it.outcome.arrived.is_some()) {
        let valves: String = best.choices.iter().map(usize::to_string).collect();
        println!("valves of one, for each 50 ms: {valves}");
    }
    Ok(())
}
