//! The evidence of an answer as a file: what was read and asked for, and every set of causes that
//! competed, with how probable the data are with it.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use saltus::Robot;
use saltus::diagnosis::{
    Candidate, Channel, Competitor, Diagnosis, Finding, Kind, Known, Reported,
};
use saltus::experiment::{Folder, digests};
use saltus::export::fingerprint;
use saltus::study::Study;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::{Claims, Diagnose, MOST, knowledge, sigmas};
use crate::cli::common::Seed;
use crate::error::{CliError, cut};
use crate::input;

/// Version of the format.
const FORMAT: u64 = 1;
/// Greatest size of a file (MiB): a thousand sets of six causes have 1 MiB.
const LIMIT_MIB: u64 = 64;
/// What such a file is.
const WANTED: &str = "a file that `saltus diagnose --evidence` wrote is wanted";

/// The evidence of an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Evidence {
    #[serde(rename = "evidence_format")]
    format: u64,
    pub(super) saltus_version: String,
    pub(super) data: Vec<Data>,
    pub(super) kind: String,
    pub(super) robot: Option<String>,
    pub(super) robot_sha256: Option<String>,
    pub(super) options: Options,
    pub(super) answer: Answer,
    /// The most probable first.
    pub(super) sets: Vec<Set>,
}

/// A data folder.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Data {
    pub(super) folder: String,
    /// SHA-256 by name.
    pub(super) sha256: BTreeMap<String, String>,
}

/// The flags that decide an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Options {
    robot: Option<String>,
    set: Vec<String>,
    model_error: Option<f64>,
    known: Vec<String>,
    most: Option<u8>,
    seed: u64,
}

/// The answer in short.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Answer {
    pub(super) causes: Vec<Found>,
    /// Whether something is left that no listed cause explains.
    pub(super) unknown: bool,
    /// By channel.
    pub(super) noise: BTreeMap<String, Noise>,
}

/// A cause that was found. Numbers that are none are absent.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Found {
    pub(super) id: String,
    pub(super) column: Option<String>,
    pub(super) parameters: BTreeMap<String, Option<f64>>,
    pub(super) standard_errors: BTreeMap<String, Option<f64>>,
    pub(super) intervals_95: BTreeMap<String, [Option<f64>; 2]>,
    pub(super) rivals: Vec<String>,
    pub(super) identifiable: bool,
}

/// Noise and model error of a channel.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Noise {
    pub(super) of_stated: f64,
    pub(super) follows: f64,
    pub(super) model_error_sigma: f64,
}

/// A set of causes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Set {
    causes: Vec<Member>,
    /// Logarithms (natural) of the odds for it, beside the model as it is.
    pub(super) log_odds: f64,
    pub(super) log_odds_unlisted: f64,
    pub(super) is_answer: bool,
}

/// A cause of a set.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Member {
    id: String,
    column: Option<String>,
    parameters: BTreeMap<String, Option<f64>>,
}

impl Evidence {
    /// That of `study`, which is `asked` for a `folder` with these `data`.
    pub(super) fn of(
        asked: &Diagnose,
        (folder, data): (&Folder, Vec<Data>),
        robot: Option<&Robot>,
        study: &Study,
    ) -> Evidence {
        let (kind, diagnosis) = (study.kind.as_ref(), &study.diagnosis);
        let sets = diagnosis.sets.iter().map(|set| Set::of(kind, set));
        Evidence {
            format: FORMAT,
            saltus_version: env!("CARGO_PKG_VERSION").into(),
            data,
            kind: folder.experiment.kind.spec().id.into(),
            robot: robot.map(|robot| robot.name.clone()),
            robot_sha256: robot.map(fingerprint),
            options: Options::of(asked),
            answer: Answer::of(kind, diagnosis),
            sets: sets.collect(),
        }
    }

    /// Reads the file at `path`.
    pub(super) fn load(path: &Path) -> Result<Evidence, CliError> {
        let bytes = input::bytes(path, LIMIT_MIB)?;
        let wrong = |reason: String| CliError::content(path.display(), reason);
        let unread = |error: serde_json::Error| wrong(format!("{error}; {WANTED}"));
        let document: Value = serde_json::from_slice(&bytes).map_err(unread)?;
        match &document["evidence_format"] {
            Value::Null => return Err(wrong(format!("evidence_format is missing; {WANTED}"))),
            format if *format != FORMAT => {
                let format = cut(&format.to_string());
                let reason = format!("evidence_format = {format}: must be {FORMAT}");
                return Err(wrong(reason));
            }
            _ => {}
        }
        // From the text, so that errors have lines.
        serde_json::from_slice(&bytes).map_err(unread)
    }

    /// The document.
    pub(super) fn json(&self) -> Value {
        serde_json::to_value(self).unwrap_or_default()
    }
}

impl Data {
    /// The files of data folders.
    pub(super) fn of(folders: &[PathBuf]) -> Result<Vec<Data>, CliError> {
        let one = |folder: &PathBuf| {
            Ok(Data {
                folder: folder.display().to_string(),
                sha256: digests(folder)?,
            })
        };
        folders.iter().map(one).collect()
    }
}

impl Options {
    fn of(asked: &Diagnose) -> Options {
        let claims = &asked.claims;
        let known = |it: &Known| format!("{}={}±{}", it.name, it.value, it.error);
        Options {
            robot: asked.robot.name().map(str::to_owned),
            set: asked.robot.overrides().to_vec(),
            model_error: claims.model_error,
            known: claims.known.iter().map(known).collect(),
            most: claims.most,
            seed: claims.seed.seed,
        }
    }

    /// `asked` with these options, of the file at `path`; with its own robot if it names one.
    pub(super) fn put_into(self, asked: Diagnose, path: &Path) -> Result<Diagnose, CliError> {
        let wrong = |key: &str, value: String, rule: String| {
            let reason = format!("options.{key} = {value}: {rule}");
            CliError::content(path.display(), reason)
        };
        let known = |it: &String| knowledge(it).map_err(|rule| wrong("known", cut(it), rule));
        if let Some(x) = self.model_error {
            let rule = |allowed| wrong("model_error", x.to_string(), format!("must be {allowed}"));
            sigmas(&x.to_string()).map_err(rule)?;
        }
        if let Some(most) = self.most.filter(|most| !(1..=MOST).contains(most)) {
            let rule = format!("must be from 1 to {MOST}");
            return Err(wrong("most", most.to_string(), rule));
        }
        Ok(Diagnose {
            claims: Claims {
                model_error: self.model_error,
                known: self.known.iter().map(known).collect::<Result<_, _>>()?,
                most: self.most,
                seed: Seed { seed: self.seed },
            },
            robot: asked.robot.or(self.robot, self.set),
            ..asked
        })
    }
}

impl Answer {
    fn of(kind: &dyn Kind, diagnosis: &Diagnosis) -> Answer {
        let left = &diagnosis.fitness.1;
        let noise = |(c, channel): (usize, &Channel)| {
            let noise = Noise {
                of_stated: left.noise[c],
                follows: left.follows[c],
                model_error_sigma: left.own_error[c],
            };
            (channel.name.clone(), noise)
        };
        Answer {
            causes: diagnosis.findings.iter().map(Found::of).collect(),
            unknown: diagnosis.unknown.is_some(),
            noise: kind.channels().iter().enumerate().map(noise).collect(),
        }
    }
}

impl Found {
    fn of(finding: &Finding) -> Found {
        let best = &finding.best;
        let named = |of: fn(&Reported) -> f64| {
            let entry = |r: &Reported| (r.name.clone(), finite(of(r)));
            best.reported.iter().map(entry).collect()
        };
        let interval = |r: &Reported| {
            let interval = r.interval?;
            Some((r.name.clone(), [interval.low, interval.high]))
        };
        let unlisted = finding.unlisted.as_ref().map(|_| "unknown".to_owned());
        Found {
            id: best.id.into(),
            column: best.column.clone(),
            parameters: named(|r| r.value),
            standard_errors: named(|r| r.error),
            intervals_95: best.reported.iter().filter_map(interval).collect(),
            rivals: finding
                .rivals
                .iter()
                .map(Candidate::title)
                .chain(unlisted)
                .collect(),
            identifiable: finding.is_identifiable,
        }
    }

    /// Its id, with the column that it is about.
    pub(super) fn title(&self) -> String {
        title(&self.id, self.column.as_deref())
    }
}

impl Set {
    fn of(kind: &dyn Kind, set: &Competitor) -> Set {
        let member = |cause: &usize| {
            let (spec, values) = (&kind.causes()[*cause], set.terms.of(*cause));
            let values = spec.report(values).into_iter();
            Member {
                id: spec.id.into(),
                column: spec.column.clone(),
                parameters: values.map(|(name, x)| (name, finite(x))).collect(),
            }
        };
        Set {
            causes: set.causes.iter().map(member).collect(),
            log_odds: set.log_odds,
            log_odds_unlisted: set.log_odds_unlisted,
            is_answer: set.is_answer,
        }
    }

    /// The greater of the two.
    pub(super) fn best(&self) -> f64 {
        self.log_odds.max(self.log_odds_unlisted)
    }

    /// Whether both have the same causes, in the same form.
    pub(super) fn is_same(&self, other: &Set) -> bool {
        let is_same = |(a, b): (&Member, &Member)| {
            (&a.id, &a.column) == (&b.id, &b.column) && a.parameters.keys().eq(b.parameters.keys())
        };
        self.causes.len() == other.causes.len()
            && self.causes.iter().zip(&other.causes).all(is_same)
    }

    /// Its causes in words.
    pub(super) fn title(&self) -> String {
        let one = |member: &Member| title(&member.id, member.column.as_deref());
        let all: Vec<String> = self.causes.iter().map(one).collect();
        if all.is_empty() {
            "no cause".into()
        } else {
            all.join(" + ")
        }
    }
}

fn title(id: &str, column: Option<&str>) -> String {
    column.map_or(id.to_owned(), |column| format!("{id} of {column}"))
}

fn finite(x: f64) -> Option<f64> {
    Some(x).filter(|x| x.is_finite())
}
