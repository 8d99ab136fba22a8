//! Whether `saltus design` says how often an effect is named: plans drawn at random, what
//! is predicted of some of their effects, and what diagnoses of hidden ones say.
//!
//!     cd studies && cargo run --release --bin power [plans=40] [effects=4] [seed=1]
//!
//! With nothing given there are two plans of one effect each, of flights.

use std::time::Instant;

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus::Robot;
use saltus::experiment::Plan;
use saltus::inject::{self, Effect, Request};
use saltus_diagnosis::{Power, Settings, diagnose, kinds};
use saltus_tests::verdict;

/// Kinds of the plans in turn, with the fewest and the most runs.
const KINDS: [(&str, &str, usize, usize); 6] = [
    ("flight", "", 2, 8),
    ("outcomes", "rats-boom", 15, 50),
    ("jump", "rats-boom", 2, 6),
    ("stroke", "", 3, 8),
    ("outcomes", "spring-hopper", 15, 50),
    ("bench", "rats-planar", 4, 12),
];

/// Bounds of the predicted shares that are compared together.
const BINS: [(f64, f64); 4] = [(0.0, 0.4), (0.4, 0.7), (0.7, 0.95), (0.95, 1.01)];

fn number(name: &str, default: usize) -> usize {
    let given = |a: String| a.strip_prefix(&format!("{name}=")).map(str::to_owned);
    let text = std::env::args().find_map(given);
    text.map_or(default, |x| x.parse().expect("a number"))
}

fn below(count: usize, random: &mut Pcg64) -> usize {
    Uniform::new(0, count).expect("some").sample(random)
}

/// What is predicted of one effect, and whether a diagnosis names it.
struct Compared {
    predicted: f64,
    is_named: bool,
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let is_short = std::env::args().len() == 1;
    let plans = number("plans", if is_short { 2 } else { 40 });
    let effects = number("effects", if is_short { 1 } else { 4 });
    let mut random = Pcg64::new(number("seed", 1) as u128, 5);
    let mut all = Vec::new();
    for k in 0..plans {
        let (kind, robot, fewest, most) = KINDS[if is_short { 0 } else { k % KINDS.len() }];
        let runs = fewest + below(most - fewest + 1, &mut random);
        let mut text = format!("kind = \"{kind}\"\nruns = {runs}\n");
        if !robot.is_empty() {
            text = format!("{text}robot = \"{robot}\"\n");
        }
        let plan = Plan::parse(&text, "plan")?;
        let robot = Robot::builtin(robot).filter(|_| !robot.is_empty());
        let start = Instant::now();
        let told = saltus::power::told(&plan, robot.as_ref(), &[], &Settings::default(), &|_| ())?;
        println!(
            "plan {k}: {runs} of {kind}, {} effects, {:.1} s",
            told.effects.len(),
            start.elapsed().as_secs_f64()
        );
        for _ in 0..effects {
            let power = &told.effects[below(told.effects.len(), &mut random)];
            let seed = 1000 + all.len() as u64;
            all.push(compare(&plan, robot.as_ref(), power, runs, seed)?);
        }
    }
    report(&all);
    Ok(())
}

/// Hides an effect in data of the plan, and looks whether a diagnosis names it.
fn compare(
    plan: &Plan,
    robot: Option<&Robot>,
    power: &Power,
    runs: usize,
    seed: u64,
) -> Result<Compared, Box<dyn std::error::Error>> {
    let name = power.column.clone().unwrap_or(power.values[0].0.clone());
    let effect = Effect {
        id: power.id.to_owned(),
        name: Some(name),
        values: power.values.iter().map(|value| value.1).collect(),
    };
    let made = inject::make(&Request {
        kind: plan.kind,
        robot,
        effects: std::slice::from_ref(&effect),
        seed,
        runs: Some(runs),
        asked: &[],
    })?;
    let kind = kinds::build(&made.experiment, robot)?;
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ());
    let said = found.as_ref().map_or_else(Vec::new, verdict::sets);
    let is_named = said.iter().any(|set| set.contains(&power.id));
    println!(
        "  {} {effect} ({:.1} σ): predicted {:.2}, {:?}; said {said:?}",
        if is_named { "named  " } else { "missed " },
        power.visible,
        power.named,
        power.others
    );
    Ok(Compared {
        predicted: power.named,
        is_named,
    })
}

fn report(all: &[Compared]) {
    println!("\n| predicted | effects | mean predicted | named |");
    println!("| --- | --- | --- | --- |");
    let line = |(low, high): (f64, f64)| {
        let here: Vec<&Compared> = all
            .iter()
            .filter(|c| (low..high).contains(&c.predicted))
            .collect();
        if !here.is_empty() {
            let n = here.len() as f64;
            let predicted = here.iter().map(|c| c.predicted).sum::<f64>() / n;
            let named = here.iter().filter(|c| c.is_named).count() as f64 / n;
            println!(
                "| {:.0} to {:.0} % | {} | {:.1} % | {:.1} % |",
                100.0 * low,
                100.0 * f64::min(high, 1.0),
                here.len(),
                100.0 * predicted,
                100.0 * named
            );
        }
    };
    BINS.into_iter().for_each(line);
    line((0.0, 1.01));
}
