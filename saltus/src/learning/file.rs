//! What was learnt, as a file: the settings, the table and the curve of each seed.

use std::path::Path;

use saltus_gait::learn::{Algorithm, Bin, Bins, Outcome, Rates, Reward, Score, Term};
use saltus_gait::{Disturbance, Draw, What, When};
use saltus_robot::Robot;
use serde_json::{Map, Value, json};

use super::{Learnt, Settings, Task};
use crate::input::{self, InputError};

/// The value of a key of an object, of which it is taken; the error of `$wrong` names the key.
macro_rules! take {
    ($object:ident, $key:literal, $wrong:expr) => {
        serde_json::from_value($object.remove($key).unwrap_or_default())
            .map_err(|error| $wrong($key, error.to_string()))?
    };
}

/// Greatest size of a file (MiB).
const LIMIT_MIB: u64 = 1024;

/// A file that is no policy, or not the one that is meant.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PolicyError {
    /// It cannot be read.
    #[error(transparent)]
    Input(#[from] InputError),
    /// It is no file of `saltus learn`.
    #[error("{file}: {key}: {reason}; a file that `saltus learn --out` wrote as JSON is wanted")]
    Content {
        /// The file.
        file: String,
        /// What in it.
        key: String,
        /// What is wrong with it.
        reason: String,
    },
}

impl PolicyError {
    /// What is wrong with a key of `file`.
    fn content(file: &str) -> impl Fn(&str, String) -> PolicyError {
        |key, reason| PolicyError::Content {
            file: file.into(),
            key: key.into(),
            reason,
        }
    }
}

/// What one seed learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Its seed.
    pub seed: u64,
    /// Its table, by state and then action.
    pub values: Vec<f64>,
    /// The score of every episode.
    pub curve: Vec<Score>,
    /// What it came to without exploration.
    pub score: Score,
}

/// A file of what was learnt.
#[derive(Clone, Debug)]
pub struct PolicyFile {
    /// How it was learnt.
    pub settings: Settings,
    /// What each seed learnt.
    pub tables: Vec<Held>,
}

impl Settings {
    /// The settings as they stand in a file.
    fn head(&self) -> Map<String, Value> {
        let states: Vec<Value> = self
            .bins
            .axes()
            .iter()
            .map(|bin| json!({ "from": bin.from, "to": bin.to, "steps": bin.count }))
            .collect();
        let reward: Vec<(String, f64)> = self
            .reward
            .0
            .iter()
            .map(|(term, by)| (term.to_string(), *by))
            .collect();
        let head = json!({
            "saltus_version": env!("CARGO_PKG_VERSION"),
            "task": self.task.name(),
            "robot": self.plant.robot.name,
            "robot_toml": self.plant.robot.to_toml(),
            "draws_robots": self.plant.draw.is_some(),
            "disturbances": self.plant.disturbances.iter().map(disturbance_json).collect::<Vec<_>>(),
            "algorithm": self.algorithm.name(),
            "alpha": self.rates.alpha,
            "gamma": self.rates.gamma,
            "lambda": self.rates.lambda,
            "epsilon": self.schedule.epsilon,
            "decay": self.schedule.decay,
            "reward": reward,
            "steps": self.steps,
            "states": states,
        });
        match head {
            Value::Object(head) => head,
            _ => Map::new(),
        }
    }
}

impl PolicyFile {
    /// What `learnt` came to under `settings`.
    pub fn of(settings: &Settings, learnt: &Learnt) -> PolicyFile {
        let tables = learnt.pupils.iter().map(|pupil| Held {
            seed: pupil.seed,
            values: pupil.table.values().to_vec(),
            curve: pupil.curve.clone(),
            score: pupil.score,
        });
        PolicyFile {
            settings: settings.clone(),
            tables: tables.collect(),
        }
    }

    /// The document. Values of 0 are left out.
    pub fn json(&self) -> Value {
        let tables: Vec<Value> = self.tables.iter().map(table_json).collect();
        let mut document = self.settings.head();
        document.insert("tables".into(), Value::Array(tables));
        Value::Object(document)
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`PolicyError`] for what is no such file.
    pub fn load(path: &Path) -> Result<PolicyFile, PolicyError> {
        PolicyFile::parse(&input::text(path, LIMIT_MIB)?, &path.display().to_string())
    }

    /// Reads `text`; messages call it `file`.
    ///
    /// # Errors
    /// As [`load`](PolicyFile::load).
    pub fn parse(text: &str, file: &str) -> Result<PolicyFile, PolicyError> {
        let wrong = PolicyError::content(file);
        let document: Value =
            serde_json::from_str(text).map_err(|error| wrong("JSON", error.to_string()))?;
        // The report of the command has it beside what it says.
        let policy = document.get("policy").cloned().unwrap_or(document);
        let Value::Object(mut document) = policy else {
            return Err(wrong("JSON", "is no object".into()));
        };
        if !document.contains_key("tables") {
            return Err(wrong("policy", "is missing".into()));
        }
        let tables: Vec<Map<String, Value>> = take!(document, "tables", wrong);
        let one = |(k, table)| {
            held(table).map_err(|(key, reason)| wrong(&format!("tables[{k}].{key}"), reason))
        };
        let tables = tables.into_iter().enumerate().map(one);
        Ok(PolicyFile {
            tables: tables.collect::<Result<_, _>>()?,
            settings: Settings::parse(document, file)?,
        })
    }

    /// What the seed that did best learnt.
    pub fn held(&self) -> Option<&Held> {
        let figure = |held: &Held| self.settings.figure(&held.score.outcome);
        let better = |best, held| {
            if figure(held) > figure(best) {
                held
            } else {
                best
            }
        };
        self.tables.iter().reduce(better)
    }
}

impl Settings {
    /// The settings that stand in the `head` of a file; messages call it `file`.
    fn parse(mut head: Map<String, Value>, file: &str) -> Result<Settings, PolicyError> {
        let wrong = PolicyError::content(file);
        let unknown = |key: &str, name: &str| wrong(key, format!("there is no {name:?}"));
        let name: String = take!(head, "task", wrong);
        let task = Task::ALL.into_iter().find(|it| it.name() == name);
        let task = task.ok_or_else(|| unknown("task", &name))?;
        let name: String = take!(head, "algorithm", wrong);
        let algorithm = Algorithm::ALL.into_iter().find(|it| it.name() == name);
        let algorithm = algorithm.ok_or_else(|| unknown("algorithm", &name))?;
        let robot: String = take!(head, "robot_toml", wrong);
        let robot = Robot::parse(&robot, file, Path::new("."));
        let robot = robot.map_err(|error| wrong("robot_toml", error.to_string()))?;
        let mut settings = task.settings(robot, algorithm);
        let states: Vec<Map<String, Value>> = take!(head, "states", wrong);
        let bin = |mut it: Map<String, Value>| -> Result<Bin, PolicyError> {
            Ok(Bin {
                from: take!(it, "from", wrong),
                to: take!(it, "to", wrong),
                count: take!(it, "steps", wrong),
            })
        };
        let states = states.into_iter().map(bin).collect::<Result<_, _>>()?;
        let bins = Bins::new(states);
        settings.bins = bins.map_err(|error| wrong("states", error.to_string()))?;
        let reward: Vec<(String, f64)> = take!(head, "reward", wrong);
        let term = |(name, by): (String, f64)| match Term::written(&name) {
            Some(term) => Ok((term, by)),
            None => Err(unknown("reward", &name)),
        };
        settings.reward = Reward(reward.into_iter().map(term).collect::<Result<_, _>>()?);
        settings.steps = take!(head, "steps", wrong);
        settings.rates = Rates {
            alpha: take!(head, "alpha", wrong),
            gamma: take!(head, "gamma", wrong),
            lambda: take!(head, "lambda", wrong),
        };
        settings.schedule.epsilon = take!(head, "epsilon", wrong);
        settings.schedule.decay = take!(head, "decay", wrong);
        let disturbances: Vec<Map<String, Value>> = take!(head, "disturbances", wrong);
        let disturbances = disturbances.into_iter().map(|it| disturbance(it, &wrong));
        settings.plant.disturbances = disturbances.collect::<Result<_, _>>()?;
        let draws: bool = take!(head, "draws_robots", wrong);
        settings.plant.draw = draws.then(|| Draw::around(&settings.plant.robot));
        Ok(settings)
    }
}

/// A name in a file, and what it makes of a number.
type Named = (&'static str, fn(f64) -> What);

/// What a disturbance does, by its name in a file.
const WHATS: [Named; 5] = [
    ("slope_rad", What::Slope),
    ("force_n", What::Force),
    ("torque_n_m", What::Torque),
    ("supply_pa", What::Supply),
    ("friction", What::Friction),
];

fn disturbance_json(it: &Disturbance) -> Value {
    let (What::Slope(value)
    | What::Force(value)
    | What::Torque(value)
    | What::Supply(value)
    | What::Friction(value)) = it.what;
    let of = WHATS.iter().find(|(_, make)| make(value) == it.what);
    let what = of.map(|(name, _)| name);
    match it.when {
        When::Time(from, to) => json!({ "what": what, "value": value, "from_s": from, "to_s": to }),
        When::Place(from, to) => {
            json!({ "what": what, "value": value, "from_m": from, "to_m": to })
        }
    }
}

fn disturbance(
    mut it: Map<String, Value>,
    wrong: &impl Fn(&str, String) -> PolicyError,
) -> Result<Disturbance, PolicyError> {
    let name: String = take!(it, "what", wrong);
    let known = WHATS.iter().find(|(known, _)| *known == name);
    let (_, make) = known.ok_or_else(|| wrong("what", format!("there is no {name:?}")))?;
    Ok(Disturbance {
        what: make(take!(it, "value", wrong)),
        when: if it.contains_key("from_s") {
            When::Time(take!(it, "from_s", wrong), take!(it, "to_s", wrong))
        } else {
            When::Place(take!(it, "from_m", wrong), take!(it, "to_m", wrong))
        },
    })
}

/// A score in a file: sum of the rewards, steps, steps outside; time, angle, travel, arrival, gas, firings, and whether it
/// is broken.
type Row = (
    f64,
    usize,
    usize,
    f64,
    f64,
    f64,
    Option<f64>,
    f64,
    usize,
    bool,
);

fn table_json(held: &Held) -> Value {
    let values = held.values.iter().enumerate();
    let values: Vec<(usize, f64)> = values
        .filter(|(_, value)| **value != 0.0)
        .map(|(place, value)| (place, *value))
        .collect();
    let curve: Vec<Row> = held.curve.iter().map(row).collect();
    json!({ "seed": held.seed, "table_size": held.values.len(), "values": values, "curve": curve,
        "score": row(&held.score) })
}

/// What one seed learnt; the error names a key of `table` and what is wrong with it.
fn held(mut table: Map<String, Value>) -> Result<Held, (String, String)> {
    let wrong = |key: &str, reason: String| (key.to_owned(), reason);
    let size: usize = take!(table, "table_size", wrong);
    if size == 0 || size > 1 << 27 {
        let reason = format!("{size} must be from 1 to {}", 1 << 27);
        return Err(wrong("table_size", reason));
    }
    let mut values = vec![0.0; size];
    let given: Vec<(usize, f64)> = take!(table, "values", wrong);
    for (place, value) in given {
        let reason = || wrong("values", format!("{place} must be below {size}"));
        *values.get_mut(place).ok_or_else(reason)? = value;
    }
    let curve: Vec<Row> = take!(table, "curve", wrong);
    Ok(Held {
        seed: take!(table, "seed", wrong),
        values,
        curve: curve.into_iter().map(score).collect(),
        score: score(take!(table, "score", wrong)),
    })
}

fn row(score: &Score) -> Row {
    let it = &score.outcome;
    (
        score.total,
        score.steps,
        score.outside,
        it.time,
        it.angle,
        it.travel,
        it.arrived,
        it.gas,
        it.firings,
        it.broken,
    )
}

fn score(row: Row) -> Score {
    let (total, steps, outside, time, angle, travel, arrived, gas, firings, broken) = row;
    Score {
        total,
        steps,
        outside,
        outcome: Outcome {
            time,
            angle,
            travel,
            arrived,
            gas,
            firings,
            broken,
        },
    }
}
