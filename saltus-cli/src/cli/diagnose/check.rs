//! Whether the evidence of an answer holds: the same diagnosis of the same data, compared.
//!
//! Processors round differently, and fits end a little elsewhere. Readings that were changed by 2e-14 of
//! themselves moved no odds by more than 5e-4 nats (10 sets of data, 2 changes of each: benchtop
//! firings, hops, jumps, pendulum, slide, vessel, arm, ball).

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use saltus::{Robot, experiment};
use serde_json::{Value, json};

use super::evidence::{Answer, Data, Evidence, Found, Set};
use super::{Diagnose, studied};
use crate::cli::Status;
use crate::cli::common::read_folders;
use crate::error::CliError;
use crate::output::{self, Format, digits};

/// Difference (nats) of a set's odds that is allowed: 100 times what rounding does, and a twentieth of
/// the odds beyond which a cause is claimed.
const NEAR: f64 = 0.05;
/// The part of how far a set is behind the best that is allowed, too: its fit ends where the loss falls by
/// 1e-4 of itself.
const PART: f64 = 1e-3;
/// How far (nats) behind the best a set need not be in both: 1000 to 1.
const BEHIND: f64 = 6.9;
/// Difference of a parameter that is allowed, in its standard errors: nobody reads more digits.
const OF_ERROR: f64 = 0.1;
/// The same of a number without one, as a part of it.
const OF_NUMBER: f64 = 0.01;

/// Facts by what they are about.
type Facts<T> = BTreeMap<String, T>;

/// How evidence compares.
#[derive(Default)]
struct Outcome {
    /// What is not as the evidence has it, each in a sentence.
    differences: Vec<String>,
    /// How the sets compare, if they were weighed.
    sets: Option<Sets>,
    notes: Vec<String>,
}

/// How sets compare.
#[derive(Default)]
struct Sets {
    count: usize,
    agreeing: usize,
    /// Greatest difference (nats) of the odds of a set that is in both.
    greatest: f64,
    differences: Vec<String>,
}

/// Computes the evidence in the file at `path` again, and says whether it is the same.
pub(super) fn run(asked: Diagnose, path: &Path) -> Result<Status, CliError> {
    let format = asked.output.format();
    if format == Format::Csv {
        let allowed = "text or json, beside --check";
        return Err(CliError::flag("--format", "csv", allowed));
    }
    let stated = Evidence::load(path)?;
    let named = asked.robot.name().map(str::to_owned);
    let asked = stated.options.clone().put_into(asked, path)?;
    let (count, given) = (stated.data.len(), asked.folders.len());
    if count != given {
        let allowed = format!("evidence of as many folders as are given ({given}), not of {count}");
        return Err(CliError::flag("--check", path.display(), allowed));
    }
    let outcome = outcome(&stated, &asked, named)?;
    let text = match format {
        Format::Json => output::json(&outcome.json(path)),
        _ => outcome.text(path),
    };
    asked.output.write_report(text)?;
    Ok(Status::of(outcome.differences.is_empty()))
}

/// Compares data and robot, and where these are the same the diagnosis.
fn outcome(
    stated: &Evidence,
    asked: &Diagnose,
    named: Option<String>,
) -> Result<Outcome, CliError> {
    let mut outcome = Outcome::default();
    let version = env!("CARGO_PKG_VERSION");
    if stated.saltus_version != version {
        let own = &stated.saltus_version;
        outcome.notes.push(format!(
            "the evidence is of Saltus {own}, and this is {version}"
        ));
    }
    let data = Data::of(&asked.folders)?;
    outcome.differences = files(&stated.data, &data);
    if !outcome.differences.is_empty() {
        return Ok(outcome);
    }
    let folder = read_folders(&asked.folders)?;
    let robot = asked.robot_of(&folder)?;
    let differs = other_robot(stated, robot.as_ref());
    if let (Some(name), Some(differs)) = (named, &differs) {
        let allowed = format!("the robot of the evidence ({differs})");
        return Err(CliError::flag("--robot", name, allowed));
    }
    outcome.differences.extend(differs);
    if !outcome.differences.is_empty() {
        return Ok(outcome);
    }
    experiment::plausible(&folder, robot.as_ref())?;
    let settings = folder.settings(&asked.claims.settings()?);
    let study = studied(&folder, robot.as_ref(), &settings)?;
    let here = Evidence::of(asked, (&folder, data), robot.as_ref(), &study);
    outcome.differences = answers(&stated.answer, &here.answer);
    let mut sets = Sets::of(&stated.sets, &here.sets);
    outcome.differences.append(&mut sets.differences);
    outcome.sets = Some(sets);
    Ok(outcome)
}

/// Files that are not as the evidence has them, each with its path in a sentence.
fn files(stated: &[Data], here: &[Data]) -> Vec<String> {
    let shown = |hash: &String| format!("SHA-256 {}…", hash.chars().take(16).collect::<String>());
    let of = |(stated, here): (&Data, &Data)| {
        let differing = differing(&stated.sha256, &here.sha256, PartialEq::eq, shown);
        let path = |it: String| Path::new(&here.folder).join(it).display().to_string();
        differing.into_iter().map(path).collect::<Vec<_>>()
    };
    stated.iter().zip(here).flat_map(of).collect()
}

/// That the robot is not the one of the evidence, if it is another.
fn other_robot(stated: &Evidence, here: Option<&Robot>) -> Option<String> {
    let hash = here.map(saltus::export::fingerprint);
    (hash != stated.robot_sha256).then(|| {
        let shown = |name: Option<&str>, hash: &Option<String>| match (name, hash) {
            (Some(name), Some(hash)) => format!("{name} ({hash})"),
            _ => "none".into(),
        };
        format!(
            "robot {} here, {} in the evidence",
            shown(here.map(|robot| &robot.name[..]), &hash),
            shown(stated.robot.as_deref(), &stated.robot_sha256)
        )
    })
}

/// What is not the same in two answers.
fn answers(stated: &Answer, here: &Answer) -> Vec<String> {
    let words = differing(&words(stated), &words(here), PartialEq::eq, |it| {
        if it.is_empty() {
            "none".into()
        } else {
            it.clone()
        }
    });
    if !words.is_empty() {
        return words;
    }
    let is_near = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).abs() <= a.1;
    differing(&numbers(stated), &numbers(here), is_near, |x| {
        digits(x.0, 6)
    })
}

/// What an answer says in words.
fn words(answer: &Answer) -> Facts<String> {
    let titles: Vec<String> = answer.causes.iter().map(Found::title).collect();
    let mut all = Facts::from([
        ("causes".to_owned(), titles.join(", ")),
        ("unknown".to_owned(), answer.unknown.to_string()),
    ]);
    for cause in &answer.causes {
        let mut rivals = cause.rivals.clone();
        rivals.sort();
        let title = cause.title();
        all.insert(format!("rivals of {title}"), rivals.join(", "));
        all.insert(
            format!("{title} is identifiable"),
            cause.identifiable.to_string(),
        );
    }
    all
}

/// Numbers of an answer, each with the difference that is allowed.
fn numbers(answer: &Answer) -> Facts<(f64, f64)> {
    let mut all = Facts::new();
    for (channel, noise) in &answer.noise {
        let parts = [
            ("of_stated", noise.of_stated),
            ("follows", noise.follows),
            ("model_error_sigma", noise.model_error_sigma),
        ];
        for (key, x) in parts {
            all.insert(
                format!("noise.{channel}.{key}"),
                (x, OF_NUMBER * x.abs().max(1.0)),
            );
        }
    }
    for cause in &answer.causes {
        let title = cause.title();
        for (name, value) in &cause.parameters {
            let error = cause.standard_errors.get(name).copied().flatten();
            let [low, high] = cause.intervals_95.get(name).copied().unwrap_or_default();
            let parts = [
                ("", *value),
                (", standard error", error),
                (", 95 % from", low),
                (", 95 % to", high),
            ];
            for (of, x) in parts {
                if let Some(x) = x {
                    let allowed = error.map_or(OF_NUMBER * x.abs(), |error| OF_ERROR * error);
                    all.insert(format!("{title}: {name}{of}"), (x, allowed));
                }
            }
        }
    }
    all
}

/// What is not the same in two lists of facts, each in a sentence.
fn differing<T>(
    stated: &Facts<T>,
    here: &Facts<T>,
    is_same: impl Fn(&T, &T) -> bool,
    shown: impl Fn(&T) -> String,
) -> Vec<String> {
    let keys: BTreeSet<&String> = stated.keys().chain(here.keys()).collect();
    let of = |key: &String| {
        let (there, here) = (stated.get(key), here.get(key));
        let is_same = there
            .zip(here)
            .is_some_and(|(there, here)| is_same(there, here));
        let shown = |it: Option<&T>| it.map_or("nothing".into(), &shown);
        (!is_same).then(|| {
            format!(
                "{key}: {} here, {} in the evidence",
                shown(here),
                shown(there)
            )
        })
    };
    keys.into_iter().filter_map(of).collect()
}

impl Sets {
    fn of(stated: &[Set], here: &[Set]) -> Sets {
        let best = stated
            .iter()
            .map(Set::best)
            .fold(f64::NEG_INFINITY, f64::max);
        let competes = |set: &Set| set.is_answer || set.best() > best - BEHIND;
        let mut all = Sets {
            count: stated.len(),
            ..Sets::default()
        };
        for set in stated {
            let Some(own) = here.iter().find(|own| own.is_same(set)) else {
                if competes(set) {
                    all.differences
                        .push(format!("set {}: is not found here", set.title()));
                }
                continue;
            };
            all.compare(set, own, NEAR + PART * (best - set.best()).max(0.0));
        }
        let new = here
            .iter()
            .filter(|own| !stated.iter().any(|set| set.is_same(own)));
        let new = new.filter(|own| competes(own));
        all.differences
            .extend(new.map(|own| format!("set {}: is not in the evidence", own.title())));
        all
    }

    fn compare(&mut self, stated: &Set, here: &Set, allowed: f64) {
        let pairs = [
            ("log_odds", stated.log_odds, here.log_odds),
            (
                "log_odds_unlisted",
                stated.log_odds_unlisted,
                here.log_odds_unlisted,
            ),
        ];
        let before = self.differences.len();
        let title = stated.title();
        for (key, there, here) in pairs {
            let off = (there - here).abs();
            self.greatest = self.greatest.max(off);
            if off > allowed {
                self.differences.push(format!(
                    "set {title}: {key} {} here, {} in the evidence (allowed: {} apart)",
                    digits(here, 6),
                    digits(there, 6),
                    digits(allowed, 2)
                ));
            }
        }
        if stated.is_answer != here.is_answer {
            let not = if here.is_answer { "" } else { "not " };
            self.differences
                .push(format!("set {title}: is {not}the answer here"));
        }
        self.agreeing += usize::from(self.differences.len() == before);
    }

    /// In a sentence.
    fn line(&self) -> String {
        let Sets {
            count,
            agreeing,
            greatest,
            ..
        } = self;
        let greatest = digits(*greatest, 2);
        format!("{agreeing} of {count} sets agree; the greatest difference is {greatest} nats.")
    }
}

impl Outcome {
    /// For people.
    fn text(&self, path: &Path) -> String {
        let file = path.display();
        let head = if self.differences.is_empty() {
            format!("The evidence of {file} holds: data, answer and sets of causes are the same.")
        } else {
            format!("The evidence of {file} does not hold:")
        };
        let sets = self.sets.as_ref().map_or(
            "The diagnosis was not made again: its input is another.".to_owned(),
            Sets::line,
        );
        let differences = self.differences.iter().map(|it| format!("  {it}"));
        let notes = self.notes.iter().map(|note| format!("note: {note}"));
        let lines = [head]
            .into_iter()
            .chain(differences)
            .chain([sets])
            .chain(notes);
        lines.map(|line| line + "\n").collect()
    }

    /// For programs.
    fn json(&self, path: &Path) -> Value {
        let sets = self.sets.as_ref().map(|sets| {
            json!({
                "count": sets.count,
                "agreeing": sets.agreeing,
                "log_odds_differ_by": sets.greatest,
            })
        });
        json!({
            "command": "diagnose",
            "check": path.display().to_string(),
            "holds": self.differences.is_empty(),
            "differences": self.differences,
            "sets": sets,
            "notes": self.notes,
        })
    }
}
