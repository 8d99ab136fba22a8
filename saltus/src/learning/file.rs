//! What was learnt, as a file: the settings, the table and the curve of each seed, and a checksum over all.

use std::path::Path;

use saltus_gait::learn::{Bin, Bins, Outcome, Rates, Reward, Score, Term, Traces};
use saltus_gait::{Disturbance, Draw, What, When};
use saltus_robot::Robot;
use serde_json::{Map, Value, json};

use super::{Learnt, Method, Settings, Task};
use crate::input::{self, InputError};

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
    /// It was changed after it was written, or cut short.
    #[error(
        "{file}: checksum = {found}: its contents give {made}; it was damaged or changed by hand"
    )]
    Damaged {
        /// The file.
        file: String,
        /// The checksum in it.
        found: String,
        /// That of its contents.
        made: String,
    },
    /// It was learnt otherwise.
    #[error("{file}: {key} = {theirs}: must be {ours}, as asked for")]
    Other {
        /// The file.
        file: String,
        /// What differs.
        key: String,
        /// Its value in the file.
        theirs: String,
        /// That of the command.
        ours: String,
    },
}

/// What one seed learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Its seed.
    pub seed: u64,
    /// Its table, by state and then action, or the six parameters of its law.
    pub values: Vec<f64>,
    /// The score of every episode.
    pub curve: Vec<Score>,
    /// What it came to without exploration.
    pub score: Score,
}

/// A file of what was learnt.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyFile {
    /// The settings.
    head: Map<String, Value>,
    /// What each seed learnt.
    pub tables: Vec<Held>,
}

impl Settings {
    /// The settings as they stand in a file.
    fn head(&self) -> Map<String, Value> {
        let bins = self.bins.axes().iter();
        let bins: Vec<Value> = bins
            .map(|bin| json!({ "from": bin.from, "to": bin.to, "steps": bin.count }))
            .collect();
        let reward: Vec<Value> = self
            .reward
            .0
            .iter()
            .map(|(term, by)| json!([term.to_string(), by]))
            .collect();
        let head = json!({
            "saltus_version": env!("CARGO_PKG_VERSION"),
            "task": self.task.name(),
            "robot": self.plant.robot.name,
            "robot_toml": self.plant.robot.to_toml(),
            "draws_robots": self.plant.draw.is_some(),
            "disturbances": self.plant.disturbances.iter().map(disturbance_json).collect::<Vec<_>>(),
            "algorithm": self.method.name(),
            "alpha": self.rates.alpha,
            "gamma": self.rates.gamma,
            "lambda": self.rates.lambda,
            "traces": match self.rates.traces {
                Traces::Accumulating => "accumulating",
                Traces::Replacing => "replacing",
            },
            "epsilon": self.schedule.epsilon,
            "decay": self.schedule.decay,
            "reward": reward,
            "steps": self.steps,
            "states": bins,
            "tilings": self.bins.tilings(),
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
            values: pupil.policy.values(),
            curve: pupil.curve.clone(),
            score: pupil.score,
        });
        PolicyFile {
            head: settings.head(),
            tables: tables.collect(),
        }
    }

    /// The document, with its checksum. Values of 0 are left out.
    pub fn json(&self) -> Value {
        let tables: Vec<Value> = self.tables.iter().map(table_json).collect();
        let mut document = self.head.clone();
        document.insert("tables".into(), Value::Array(tables));
        let sum = checksum(&document);
        document.insert("checksum".into(), json!(sum));
        Value::Object(document)
    }

    /// Reads the file at `path`.
    ///
    /// # Errors
    /// [`PolicyError`] for what is no such file, and for one that was damaged.
    pub fn load(path: &Path) -> Result<PolicyFile, PolicyError> {
        PolicyFile::parse(&input::text(path, LIMIT_MIB)?, &path.display().to_string())
    }

    /// Reads `text`; messages call it `file`.
    ///
    /// # Errors
    /// As [`load`](PolicyFile::load).
    pub fn parse(text: &str, file: &str) -> Result<PolicyFile, PolicyError> {
        let wrong = |key: &str, reason: String| PolicyError::Content {
            file: file.into(),
            key: key.into(),
            reason,
        };
        let document: Value =
            serde_json::from_str(text).map_err(|error| wrong("JSON", error.to_string()))?;
        // The report of the command has it beside what it says.
        let policy = document.get("policy").cloned().unwrap_or(document);
        let Value::Object(mut document) = policy else {
            return Err(wrong("JSON", "is no object".into()));
        };
        let found = document.remove("checksum");
        let missing = if document.contains_key("tables") {
            "checksum"
        } else {
            "policy"
        };
        let found = found.ok_or_else(|| wrong(missing, "is missing".into()))?;
        let made = checksum(&document);
        if found != json!(made) {
            return Err(PolicyError::Damaged {
                file: file.into(),
                found: found.to_string(),
                made,
            });
        }
        let tables = document.remove("tables");
        let Some(Value::Array(tables)) = tables else {
            return Err(wrong("tables", "is missing".into()));
        };
        let tables = tables.iter().enumerate().map(|(k, table)| {
            held(table).ok_or_else(|| wrong(&format!("tables[{k}]"), "cannot be read".into()))
        });
        Ok(PolicyFile {
            tables: tables.collect::<Result<_, _>>()?,
            head: document,
        })
    }

    /// The settings under which it was learnt.
    ///
    /// # Errors
    /// [`PolicyError::Content`] for what is missing or is not what this version writes; `file` is its name.
    pub fn settings(&self, file: &str) -> Result<Settings, PolicyError> {
        let wrong = |key: &str, reason: String| PolicyError::Content {
            file: file.into(),
            key: key.into(),
            reason,
        };
        let missing = |key: &str| wrong(key, "is missing, or is not what it must be".into());
        let text = |key: &str| {
            let value = self.head.get(key).and_then(Value::as_str);
            value.ok_or_else(|| missing(key))
        };
        let version = text("saltus_version")?;
        if version != env!("CARGO_PKG_VERSION") {
            let ours = env!("CARGO_PKG_VERSION");
            return Err(PolicyError::Other {
                file: file.into(),
                key: "saltus_version".into(),
                theirs: version.into(),
                ours: ours.into(),
            });
        }
        let name = text("task")?;
        let task = Task::ALL.into_iter().find(|it| it.name() == name);
        let task = task.ok_or_else(|| missing("task"))?;
        let name = text("algorithm")?;
        let method = Method::all().find(|it| it.name() == name);
        let method = method.ok_or_else(|| missing("algorithm"))?;
        let robot = Robot::parse(text("robot_toml")?, file, Path::new("."));
        let robot = robot.map_err(|error| wrong("robot_toml", error.to_string()))?;
        let mut settings = task.settings(robot, method);
        let states = self.states().ok_or_else(|| missing("states"))?;
        let tilings = self.head.get("tilings").and_then(Value::as_u64);
        let tilings = tilings.and_then(|it| usize::try_from(it).ok());
        let tilings = tilings.ok_or_else(|| missing("tilings"))?;
        let bins = Bins::new(states).and_then(|bins| bins.tiled(tilings));
        settings.bins = bins.map_err(|error| wrong("states", error.to_string()))?;
        settings.reward = self.reward().ok_or_else(|| missing("reward"))?;
        let steps = self.head.get("steps").and_then(Value::as_u64);
        let steps = steps.and_then(|it| usize::try_from(it).ok());
        settings.steps = steps.ok_or_else(|| missing("steps"))?;
        let number = |key: &str| {
            let value = self.head.get(key).and_then(Value::as_f64);
            value.ok_or_else(|| missing(key))
        };
        settings.rates = Rates {
            alpha: number("alpha")?,
            gamma: number("gamma")?,
            lambda: number("lambda")?,
            traces: match text("traces")? {
                "accumulating" => Traces::Accumulating,
                "replacing" => Traces::Replacing,
                _ => return Err(missing("traces")),
            },
        };
        settings.schedule.epsilon = number("epsilon")?;
        settings.schedule.decay = number("decay")?;
        let disturbances = self.head.get("disturbances").and_then(Value::as_array);
        let disturbances = disturbances.and_then(|all| all.iter().map(disturbance).collect());
        settings.plant.disturbances = disturbances.ok_or_else(|| missing("disturbances"))?;
        let draws = self.head.get("draws_robots").and_then(Value::as_bool);
        if draws.ok_or_else(|| missing("draws_robots"))? {
            settings.plant.draw = Some(Draw::around(&settings.plant.robot));
        }
        Ok(settings)
    }

    fn states(&self) -> Option<Vec<Bin>> {
        let bin = |it: &Value| {
            Some(Bin {
                from: it.get("from")?.as_f64()?,
                to: it.get("to")?.as_f64()?,
                count: usize::try_from(it.get("steps")?.as_u64()?).ok()?,
            })
        };
        self.head
            .get("states")?
            .as_array()?
            .iter()
            .map(bin)
            .collect()
    }

    fn reward(&self) -> Option<Reward> {
        let term = |it: &Value| Some((Term::written(it.get(0)?.as_str()?)?, it.get(1)?.as_f64()?));
        let terms = self.head.get("reward")?.as_array()?.iter().map(term);
        terms.collect::<Option<_>>().map(Reward)
    }

    /// What the seed that did best learnt.
    pub fn held(&self, settings: &Settings) -> Option<&Held> {
        let figure = |held: &Held| settings.figure(&held.score.outcome);
        let better = |best, held| {
            if figure(held) > figure(best) {
                held
            } else {
                best
            }
        };
        self.tables.iter().reduce(better)
    }

    /// Whether it was learnt under `settings`, from `seed` on, by so many `seeds`; only the number of episodes may differ.
    ///
    /// # Errors
    /// [`PolicyError::Other`] for what differs; `file` is its name.
    pub fn is_of(
        &self,
        settings: &Settings,
        (seed, seeds): (u64, usize),
        file: &str,
    ) -> Result<(), PolicyError> {
        let other = |key: &str, theirs: String, ours: String| PolicyError::Other {
            file: file.into(),
            key: key.into(),
            theirs: input::cut(&theirs),
            ours: input::cut(&ours),
        };
        for (key, ours) in settings.head() {
            let theirs = self.head.get(&key).unwrap_or(&Value::Null);
            if *theirs != ours {
                let [theirs, ours] = first_difference(theirs, &ours);
                return Err(other(&key, theirs, ours));
            }
        }
        let count = self.tables.len();
        if count != seeds {
            return Err(other("seeds", count.to_string(), seeds.to_string()));
        }
        match self.tables.first() {
            Some(first) if first.seed != seed => {
                Err(other("seed", first.seed.to_string(), seed.to_string()))
            }
            _ => Ok(()),
        }
    }
}

/// The first line of a text, or the first item of a list, in which two values differ; or the values.
fn first_difference(theirs: &Value, ours: &Value) -> [String; 2] {
    let parts = |value: &Value| match value {
        Value::String(text) => text.lines().map(str::to_owned).collect(),
        Value::Array(items) => items.iter().map(Value::to_string).collect(),
        other => vec![other.to_string()],
    };
    let (theirs, ours): (Vec<String>, Vec<String>) = (parts(theirs), parts(ours));
    let none = || "nothing".to_owned();
    let differs = (0..theirs.len().max(ours.len())).find(|k| theirs.get(*k) != ours.get(*k));
    let at = |parts: &[String]| {
        differs
            .and_then(|k| parts.get(k).cloned())
            .unwrap_or_else(none)
    };
    [at(&theirs), at(&ours)]
}

fn disturbance_json(it: &Disturbance) -> Value {
    let (what, value) = match it.what {
        What::Slope(x) => ("slope_rad", x),
        What::Force(x) => ("force_n", x),
        What::Torque(x) => ("torque_n_m", x),
        What::Supply(x) => ("supply_pa", x),
        What::Friction(x) => ("friction", x),
    };
    match it.when {
        When::Time(from, to) => json!({ "what": what, "value": value, "from_s": from, "to_s": to }),
        When::Place(from, to) => {
            json!({ "what": what, "value": value, "from_m": from, "to_m": to })
        }
    }
}

fn disturbance(value: &Value) -> Option<Disturbance> {
    let number = |key: &str| value.get(key).and_then(Value::as_f64);
    let make: fn(f64) -> What = match value.get("what")?.as_str()? {
        "slope_rad" => What::Slope,
        "force_n" => What::Force,
        "torque_n_m" => What::Torque,
        "supply_pa" => What::Supply,
        "friction" => What::Friction,
        _ => return None,
    };
    let when = match number("from_s") {
        Some(from) => When::Time(from, number("to_s")?),
        None => When::Place(number("from_m")?, number("to_m")?),
    };
    let what = make(number("value")?);
    Some(Disturbance { when, what })
}

fn checksum(document: &Map<String, Value>) -> String {
    let text = Value::Object(document.clone()).to_string();
    format!("{:08x}", crc32fast::hash(text.as_bytes()))
}

fn table_json(held: &Held) -> Value {
    let values = held.values.iter().enumerate();
    let values: Vec<Value> = values
        .filter(|(_, value)| **value != 0.0)
        .map(|(place, value)| json!([place, value]))
        .collect();
    let curve: Vec<Value> = held.curve.iter().map(score_json).collect();
    json!({ "seed": held.seed, "table_size": held.values.len(), "values": values, "curve": curve,
        "score": score_json(&held.score) })
}

fn score_json(score: &Score) -> Value {
    let Outcome {
        time,
        angle,
        travel,
        arrived,
        gas,
        firings,
        broken,
    } = score.outcome;
    json!([
        score.total,
        score.steps,
        score.outside,
        time,
        angle,
        travel,
        arrived,
        gas,
        firings,
        broken
    ])
}

fn held(table: &Value) -> Option<Held> {
    let size = table.get("table_size")?.as_u64()?;
    if size == 0 || size > 1 << 27 {
        return None;
    }
    let mut values = vec![0.0; usize::try_from(size).ok()?];
    for pair in table.get("values")?.as_array()? {
        let place = usize::try_from(pair.get(0)?.as_u64()?).ok()?;
        *values.get_mut(place)? = pair.get(1)?.as_f64()?;
    }
    let curve = table.get("curve")?.as_array()?.iter().map(score);
    Some(Held {
        seed: table.get("seed")?.as_u64()?,
        values,
        curve: curve.collect::<Option<_>>()?,
        score: score(table.get("score")?)?,
    })
}

fn score(row: &Value) -> Option<Score> {
    let number = |k: usize| row.get(k)?.as_f64();
    let count = |k: usize| usize::try_from(row.get(k)?.as_u64()?).ok();
    Some(Score {
        total: number(0)?,
        steps: count(1)?,
        outside: count(2)?,
        outcome: Outcome {
            time: number(3)?,
            angle: number(4)?,
            travel: number(5)?,
            arrived: number(6),
            gas: number(7)?,
            firings: count(8)?,
            broken: row.get(9)?.as_bool()?,
        },
    })
}
