//! What to do after a diagnosis.

use std::path::Path;

use saltus::Robot;
use saltus::diagnosis::{Candidate, Finding, Reported};
use saltus::robot::Term;
use serde_json::{Value, json};

use super::words::{estimate, slip_of};
use super::{Diagnose, Found};
use crate::cli::common::left_out_words;
use crate::cli::moved::quoted;
use crate::output::{digits, unit};

/// A step: what to do, and the command that does it.
pub(super) struct Step {
    pub(super) what: String,
    pub(super) command: Option<String>,
}

/// Name of the corrected robot's file where the user has named none.
const CORRECTED: &str = "corrected.toml";

impl Step {
    fn new(what: impl Into<String>) -> Step {
        Step {
            what: what.into(),
            command: None,
        }
    }

    fn by(what: impl Into<String>, command: String) -> Step {
        Step {
            what: what.into(),
            command: Some(command),
        }
    }

    pub(super) fn json(&self) -> Value {
        json!({ "what": self.what, "command": self.command })
    }
}

/// `saltus diagnose` of the same data and the same robot, with `more` flags.
fn again(asked: &Diagnose, more: &str) -> String {
    let folders = asked.folders.iter();
    let folders = folders.map(|folder| quoted(&folder.display().to_string()));
    let robot = asked.robot.name().into_iter();
    let robot = robot.map(|name| format!("--robot {}", quoted(name)));
    let overrides = asked.robot.overrides().iter();
    let overrides = overrides.map(|text| format!("--set {}", quoted(text)));
    let words: Vec<String> = folders.chain(robot).chain(overrides).collect();
    format!("saltus diagnose {} {more}", words.join(" "))
}

/// Keys of the corrected robot that the planar model of the planner leaves out.
pub(super) fn left_out(found: &Found<'_>) -> Vec<String> {
    found
        .extended
        .as_ref()
        .map_or(Vec::new(), Robot::beyond_the_plane)
}

/// Of these the keys that the diagnosis changed.
pub(super) fn newly_left_out(found: &Found<'_>) -> Vec<String> {
    let value = |robot: Option<&Robot>, key: &String| {
        let robot = robot?;
        let term = Term::ALL.iter().find(|term| term.key(robot) == *key)?;
        term.of(robot)
    };
    let (before, after) = (found.robot.as_ref(), found.extended.as_ref());
    let mut keys = left_out(found);
    keys.retain(|key| value(before, key) != value(after, key));
    keys
}

/// What to do, in order.
pub(super) fn steps(found: &Found<'_>) -> Vec<Step> {
    let mut all: Vec<Step> = Vec::new();
    for wrong in &found.misstated {
        let seen = digits(wrong.seen, 2);
        all.push(Step::new(format!(
            "In experiment.toml, state the noise that {} has: about {seen} {}.",
            wrong.column,
            unit(&wrong.column)
        )));
    }
    for finding in &found.diagnosis.findings {
        all.extend(wrong_units(found, finding));
        all.extend(tell_apart(found, finding));
        all.extend(correct_sensor(found, finding));
    }
    if found.diagnosis.unknown.is_some() {
        let what = "Look at the charts of the runs: where and when the simulation is off tells \
            what is missing in it.";
        all.push(Step::by(what, again(found.asked, "--report page.html")));
    }
    all.extend(correct_robot(found));
    if all.is_empty() {
        let is_sound = found.diagnosis.findings.is_empty();
        all.push(Step::new(match &found.robot {
            Some(_) if is_sound => "Nothing needs to be corrected: plan with this robot.",
            None if is_sound => "Nothing needs to be corrected.",
            _ => {
                "Compute with these numbers in place of what was believed. Measure new runs: what \
                 was found should be found again, as large."
            }
        }));
    }
    all
}

/// What equals a slip of unit, of a finding or of what explains the data as well.
fn wrong_units(found: &Found<'_>, finding: &Finding) -> Vec<Step> {
    let all = std::iter::once(&finding.best).chain(&finding.rivals);
    let of = |candidate: &Candidate| {
        let of = |(k, r): (usize, &Reported)| {
            let slip = slip_of(found.kind.as_ref(), candidate, k)?;
            let (title, value) = (candidate.title(), digits(r.value, 5));
            let what = format!(
                "Look for a wrong unit: {} of {title} is {value}, and {slip}.",
                r.name
            );
            Some(Step::new(what))
        };
        let reported = candidate.reported.iter().enumerate();
        reported.filter_map(of).collect::<Vec<_>>()
    };
    all.chain(&finding.contradicting).flat_map(of).collect()
}

/// What to measure where rivals are left.
fn tell_apart(found: &Found<'_>, finding: &Finding) -> Option<Step> {
    let kind = found.kind.as_ref();
    let all = std::iter::once(&finding.best).chain(&finding.rivals);
    let mut names: Vec<String> = all.map(Candidate::title).collect();
    names.extend(
        finding
            .unlisted
            .as_ref()
            .map(|_| "something that is not on the list".to_owned()),
    );
    let names = names.join(" or ");
    if !finding.is_identifiable {
        return Some(Step::new(format!(
            "To see whether it is {names}, and how strong, measure {}.",
            kind.stronger()
        )));
    }
    let alone = finding.rivals.is_empty() && finding.unlisted.is_none();
    (!alone).then(|| match &finding.next {
        Some(next) => Step::new(format!("To see whether it is {names}, {}.", next.what)),
        None => Step::new(format!(
            "To see whether it is {names}, measure under other conditions."
        )),
    })
}

/// What to do about a sensor.
fn correct_sensor(found: &Found<'_>, finding: &Finding) -> Option<Step> {
    let cause = &found.kind.causes()[finding.best.cause];
    let column = cause.column.as_ref()?;
    let Reported {
        name, value, error, ..
    } = finding.best.reported.first()?;
    let said = estimate(*value, *error, unit(name));
    let wrong = match cause.id {
        "encoder-scale" => format!("its readings are {said} times the truth"),
        "sensor-offset" => format!("its readings are {said} too large"),
        "sensor-delay" => format!("its readings are {said} late"),
        _ => return None,
    };
    Some(Step::new(format!(
        "Correct the sensor of {column}, or its column in the logs: {wrong}."
    )))
}

/// What to do with the corrected robot.
fn correct_robot(found: &Found<'_>) -> Vec<Step> {
    if found.extended.is_none() {
        return Vec::new();
    }
    let file = found
        .asked
        .extend
        .as_deref()
        .unwrap_or(Path::new(CORRECTED));
    let file = quoted(&file.display().to_string());
    let mut all = Vec::new();
    if found.asked.extend.is_none() {
        let what = "Write the robot with what was found; every command takes it.";
        all.push(Step::by(
            what,
            again(found.asked, &format!("--extend {file}")),
        ));
    }
    let left_out = left_out_words(&newly_left_out(found));
    if left_out.is_empty() {
        let distance = found.worth.as_ref().map_or(0.6, |worth| worth.distance);
        // On a boom the planar model alone is off by centimetres.
        let whole = found
            .robot
            .as_ref()
            .is_some_and(|robot| robot.boom.is_some());
        let plant = if whole {
            format!(" --plant {file}")
        } else {
            String::new()
        };
        let table =
            format!("saltus table --omega 3:6:7 --distance {distance} --robot {file}{plant}");
        all.push(Step::by(
            "Make tables and plans with the corrected robot.",
            table,
        ));
    } else {
        let what = format!(
            "The planner has no term for {left_out}; `saltus verify` has. Fly a plan with the \
             corrected robot to see what it changes."
        );
        all.push(Step::by(
            what,
            format!("saltus verify COURSE.toml --plant {file}"),
        ));
    }
    let data = "Measure new runs and diagnose them with the corrected robot: nothing should be \
        wrong then.";
    all.push(Step::by(
        data,
        format!("saltus diagnose NEW_RUNS --robot {file}"),
    ));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_as_a_shell_needs() {
        assert_eq!(quoted("logs/monday-2"), "logs/monday-2");
        assert_eq!(quoted("my logs"), "'my logs'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
    }
}
