//! Logs of running robots, and what the diagnosis says of each: how often it names what is hidden,
//! and how often it raises a false alarm.
//!
//!     cd studies && cargo run --release --bin strides [what=none,effects] [first=1] [seeds=1] [cause=ID] [seconds=6] [threads=1]
//!
//! With nothing given it is one log without an effect.

use std::collections::BTreeMap;
use std::time::Instant;

use saltus_diagnosis::{Diagnosis, Kind, Settings, diagnose, kinds};
use saltus_numeric::parallel;
use saltus_tests::lab::running::{self, Trial};
use saltus_tests::verdict;

fn option(name: &str) -> Option<String> {
    std::env::args().find_map(|a| a.strip_prefix(&format!("{name}=")).map(str::to_owned))
}

fn number(name: &str, default: u64) -> u64 {
    option(name).and_then(|x| x.parse().ok()).unwrap_or(default)
}

fn lists(name: &str, value: &str, default: &str) -> bool {
    let list = option(name).unwrap_or_else(|| default.into());
    list.split(',').any(|x| x == value || x == "all")
}

/// What a diagnosis is worth.
fn judged(found: &Diagnosis, hidden: Option<&str>) -> &'static str {
    let sets = verdict::sets(found);
    match hidden {
        None if sets.is_empty() && found.unknown.is_none() => "right",
        None => "FALSE ALARM",
        Some(id) => match &sets[..] {
            [] if found.unknown.is_some() => "unknown",
            [] => "abstained",
            [set] if set[..] == [id] => "named",
            [set] if set.contains(&id) => "in rivals",
            several if several.iter().any(|set| set.contains(&id)) => "named, with another",
            _ => "WRONG",
        },
    }
}

fn one(hidden: Option<&str>, seed: u64, seconds: f64) -> Option<(&'static str, String)> {
    let trial = running::make(hidden, seconds, seed)?;
    let start = Instant::now();
    let Trial {
        experiment,
        believed,
        gait,
        hidden: change,
    } = &trial;
    let kind = match kinds::build(experiment, Some(believed)) {
        Ok(kind) => kind,
        Err(error) => return Some(("too few strides", format!("{gait}: {error}"))),
    };
    let found = diagnose(kind.as_ref(), &Settings::default(), &|_| ());
    let took = start.elapsed().as_secs_f64();
    let strides = kind.logs().len();
    let (verdict, said) = match &found {
        Some(found) => (judged(found, hidden), verdict::say(found)),
        None => ("no motion", String::new()),
    };
    if option("look").is_some()
        && let Some(found) = &found
    {
        look(kind.as_ref(), found);
    }
    let notes = kind.notes().join("; ");
    let fit = found.as_ref().map_or(f64::NAN, |f| f.before.loss);
    Some((
        verdict,
        format!(
            "{gait}, {change}, {strides} strides, {took:.1} s, loss {fit:.3}: {said} [{notes}]"
        ),
    ))
}

/// Prints what the model without a cause leaves of each stride, in standard deviations.
fn look(kind: &dyn Kind, found: &Diagnosis) {
    for (run, log) in kind.logs().iter().enumerate() {
        let Some(said) = kind.predict(run, &found.before.terms, &found.before.unknowns[run]) else {
            continue;
        };
        let rms = |channel: usize| {
            let left: Vec<f64> = log
                .readings
                .iter()
                .zip(&said)
                .filter(|(reading, _)| reading.channel == channel)
                .map(|(reading, said)| (reading.value - said) / kind.channels()[channel].noise)
                .collect();
            let mean = left.iter().map(|x| x * x).sum::<f64>() / left.len().max(1) as f64;
            format!("{:.2}", mean.sqrt())
        };
        let all: Vec<String> = (0..kind.channels().len()).map(rms).collect();
        let phases = kind.phases(run, &found.before.terms, &found.before.unknowns[run]);
        println!(
            "{}: {} readings, rms {} {:.3?} {:?}",
            log.name,
            log.readings.len(),
            all.join(" "),
            found.before.unknowns[run],
            phases
        );
    }
}

fn main() {
    let (first, seeds) = (number("first", 1), number("seeds", 1));
    let seconds = number("seconds", 6) as f64;
    let threads = usize::try_from(number("threads", 1)).unwrap_or(1);
    let mut all: Vec<(Option<&'static str>, u64)> = Vec::new();
    for seed in first..first + seeds {
        if lists("what", "none", "none") {
            all.push((None, seed));
        }
        if lists("what", "effects", "none") {
            let is_asked = |id: &&str| lists("cause", id, "all");
            all.extend(
                running::causes()
                    .filter(is_asked)
                    .map(|id| (Some(id), seed)),
            );
        }
    }
    let answers = parallel::map_on(threads, all.len(), |k| {
        let (hidden, seed) = all[k];
        let answer = one(hidden, seed, seconds);
        let (verdict, words) = answer.unwrap_or(("does not run", String::new()));
        println!(
            "{verdict:12} {} seed {seed}: {words}",
            hidden.unwrap_or("none")
        );
        verdict
    });
    let mut table: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for ((hidden, _), verdict) in all.iter().zip(answers) {
        *table
            .entry((hidden.unwrap_or("none"), verdict))
            .or_default() += 1;
    }
    for ((hidden, verdict), count) in table {
        println!("| {hidden} | {verdict} | {count} |");
    }
}
