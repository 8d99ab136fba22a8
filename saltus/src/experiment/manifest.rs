//! `experiment.toml`: what was done, and how each run was set.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use saltus_diagnosis::mechanism::Mechanism;
use saltus_diagnosis::spec::{Column, Form, Meaning, Setting, Spec, power, stem};
use saltus_diagnosis::{Known, Sort};
use saltus_robot::RobotError;
use saltus_robot::domain::Domain;
use saltus_robot::section::Section;
use saltus_robot::units::TIME;

use super::error::{Error, one_line, shown};
use super::instant::{self, Instant};
use super::mechanism;

/// Where the numbers of a column are: a topic and fields of its messages.
#[cfg(feature = "telemetry")]
pub(super) use saltus_telemetry::Path as LogPath;
/// Where they would be; not looked at.
#[cfg(not(feature = "telemetry"))]
pub(super) type LogPath = String;

/// Its name in the folder.
pub(super) const NAME: &str = "experiment.toml";
/// What a file may be.
const FILE: &str = "the name of a file in this folder, without .. and not absolute";
/// Most runs of a folder.
const MOST_RUNS: usize = 10_000;
/// Most bytes of the file.
const MOST_BYTES: u64 = 8 << 20;

/// What the file says.
#[derive(Debug)]
pub(super) struct Manifest {
    pub(super) spec: &'static Spec,
    /// Whether a robot was measured.
    pub(super) needs_robot: bool,
    /// What the operator believes of the machine.
    pub(super) rig: BTreeMap<String, f64>,
    /// The machine that the file in `[rig]` describes, and the file with its text.
    pub(super) mechanism: Option<Described>,
    pub(super) robot: Option<String>,
    /// Standard deviations, by column.
    pub(super) noise: BTreeMap<String, f64>,
    /// Steps, by column.
    pub(super) resolution: BTreeMap<String, f64>,
    /// What is known apart from the data.
    pub(super) known: Vec<Known>,
    pub(super) runs: Vec<Listed>,
}

/// A machine, and the file that describes it.
#[derive(Debug)]
pub(super) struct Described {
    pub(super) mechanism: Mechanism,
    /// The file's name, within the folder.
    pub(super) file: String,
    pub(super) text: String,
}

/// A run as it is listed.
#[derive(Debug)]
pub(super) struct Listed {
    /// Its file, within the folder.
    pub(super) file: String,
    /// The part of it that counts, from and to these instants; none: from its first row, to its
    /// last.
    pub(super) window: [Option<Instant>; 2],
    /// Of an MCAP file that is not ours: where each column is.
    pub(super) columns: BTreeMap<String, LogPath>,
    /// Its clock, where the operator says which one.
    pub(super) clock: Option<LogClock>,
    pub(super) settings: BTreeMap<String, f64>,
    /// When what happened, by its key.
    pub(super) instants: Vec<(&'static str, Instant)>,
}

/// Which times of an MCAP file count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum LogClock {
    /// Those in the headers of the messages: when they were measured.
    Header,
    /// Those of the log: when they were written down.
    Log,
}

/// The bytes of the file in `folder`.
pub(super) fn bytes(folder: &Path) -> Result<Vec<u8>, Error> {
    let path = folder.join(NAME);
    let failed = |source| Error::read(&path, source);
    match std::fs::metadata(folder) {
        Err(error) => return Err(Error::read(folder, error)),
        Ok(it) if !it.is_dir() => {
            let reason = format!("is not a folder; data are a folder with {NAME} and its runs");
            return Err(Error::content(shown(folder), reason));
        }
        Ok(_) if !path.exists() => {
            return Err(Error::content(
                shown(folder),
                format!("has no {NAME}, which says what was measured"),
            ));
        }
        Ok(_) => {}
    }
    let file = File::open(&path).map_err(failed)?;
    if !file.metadata().map_err(failed)?.is_file() {
        return Err(Error::content(shown(&path), "is not a file"));
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES + 1)
        .read_to_end(&mut bytes)
        .map_err(failed)?;
    if bytes.len() as u64 > MOST_BYTES {
        let reason = format!("larger than {} MiB, the most it may have", MOST_BYTES >> 20);
        return Err(Error::content(shown(&path), reason));
    }
    Ok(bytes)
}

/// What `bytes` say, the contents of the file in `folder`.
pub(super) fn parse(bytes: &[u8], folder: &Path) -> Result<Manifest, Error> {
    let file = shown(&folder.join(NAME));
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = bytes[..error.valid_up_to()]
            .split(|byte| *byte == b'\n')
            .count();
        Error::content(format!("{file}:{line}"), "not UTF-8 text")
    })?;
    let mut root = Section::file(text, &file)?;
    // A misspelt key is reported before the one that it leaves missing.
    root.check_keys(&[
        "kind",
        "robot",
        "noise",
        "resolution",
        "known",
        "rig",
        "columns",
        "clock",
        "run",
    ])?;
    let spec = kind(&mut root)?;
    if spec.rig.is_empty() && !spec.mechanism {
        root.refuse_key("rig", &format!("left out: the kind {} has none", spec.id));
    }
    let mut chain = None;
    let rig = root.optional_table("rig", |mut s| {
        let believed = set(&mut s, spec.rig);
        if spec.mechanism {
            chain = s.text_as("chain", FILE, within);
        }
        s.finish(believed)
    });
    if spec.mechanism && rig.is_none() {
        root.missing(
            &["rig"],
            "a table [rig] with chain, the file that describes the machine",
        );
    }
    root.stop_at_problem()?;
    let described = |file: String| {
        let (mechanism, text) = mechanism::read(folder, &file)?;
        Ok::<_, Error>(Described {
            mechanism,
            file,
            text,
        })
    };
    let mechanism = chain.map(described).transpose()?;
    let needs_robot = spec.robot.is_some() || (rig.is_none() && !spec.rig.is_empty());
    let manifest = Manifest {
        spec,
        needs_robot,
        rig: rig.unwrap_or_default(),
        mechanism,
        robot: robot(&mut root, needs_robot, spec),
        noise: sizes(&mut root, "noise", spec),
        resolution: sizes(&mut root, "resolution", spec),
        known: known(&mut root),
        runs: {
            let mapping = mapping(&mut root, spec)?;
            runs(&mut root, spec, &mapping)?
        },
    };
    Ok(root.finish(manifest)?)
}

pub(super) fn kind(root: &mut Section) -> Result<&'static Spec, Error> {
    if root.word("kind", &[("toss", ())]).is_some() {
        let reason = "kind = \"toss\": tosses are read by the multi-body simulation's example \
            tosses, not here";
        return Err(Error::content(root.place().to_string(), reason));
    }
    let names = Sort::ALL.map(|sort| sort.spec().id).join(", ");
    let sort = root.text_as("kind", &format!("one of {names}, in quotes"), Sort::named);
    root.stop_at_problem()?;
    Ok(sort.unwrap_or(Sort::Bench).spec())
}

fn robot(root: &mut Section, is_needed: bool, spec: &Spec) -> Option<String> {
    const ALLOWED: &str = "a robot's name or the path of its file, in quotes";
    if !is_needed && !root.has("robot") {
        return None;
    }
    if !root.has("robot") && !spec.rig.is_empty() {
        let required = spec.rig.iter().filter(|setting| setting.required);
        let keys: Vec<&str> = required.map(|setting| setting.key).collect();
        let keys = keys.join(", ");
        root.missing(
            &["rig"],
            &format!("a table with {keys}; or robot: {ALLOWED}"),
        );
        return None;
    }
    let name = |text: &str| Some(text.to_owned()).filter(|name| !name.is_empty());
    root.text_as("robot", ALLOWED, name)
}

/// The table `[key]`: a size above 0 for some of the channels.
pub(super) fn sizes(root: &mut Section, key: &str, spec: &Spec) -> BTreeMap<String, f64> {
    const SIZE: Domain = Domain::POSITIVE.because(", in the column's unit");
    let sizes = root.optional_table(key, |mut s| {
        let mut sizes = BTreeMap::new();
        let (families, plain): (Vec<&Column>, Vec<&Column>) =
            spec.channels.iter().partition(|own| own.is_family());
        // Members of a family are known by their names alone.
        let members = s.keys().into_iter().filter_map(|key| spec.channel(&key));
        let members: Vec<&Column> = members
            .filter(|own| !families.is_empty() && plain.iter().all(|known| known.name != own.name))
            .collect();
        for own in plain.into_iter().chain(members) {
            let size = s.optional(stem(own.name, own.quantity), own.quantity, SIZE);
            sizes.extend(size.map(|size| (own.name.to_owned(), size)));
        }
        s.finish(sizes)
    });
    sizes.unwrap_or_default()
}

/// The table `[known]`.
pub(super) fn known(root: &mut Section) -> Vec<Known> {
    let read = root.optional_table("known", |mut s| {
        let known = s.known();
        s.finish(known)
    });
    let known = |(name, [value, error]): (String, [f64; 2])| Known { name, value, error };
    read.into_iter().flatten().map(known).collect()
}

/// Where the columns of MCAP files are, and which clock counts.
type Mapping = (BTreeMap<String, LogPath>, Option<LogClock>);

/// The table `columns` and the key `clock`, of a run or of all that have none of their own.
fn mapping(s: &mut Section, spec: &Spec) -> Result<Mapping, Error> {
    const PATH: &str = "a topic and fields in quotes, as in \"/imu.angular_velocity.y\" or \
        \"/joint_states.position[leg_1]\"";
    const CLOCK: [(&str, LogClock); 2] = [("header", LogClock::Header), ("log", LogClock::Log)];
    let place = s.place().to_string();
    let columns = s.optional_table("columns", |mut table| {
        let columns = table.texts(PATH, |text| text.parse::<LogPath>().ok());
        table.finish(columns)
    });
    let named = |text: &str| {
        CLOCK
            .iter()
            .find(|(name, _)| *name == text)
            .map(|(_, c)| *c)
    };
    let clock = if s.has("clock") {
        s.text_as("clock", "\"header\" or \"log\"", named)
    } else {
        None
    };
    let columns: BTreeMap<String, LogPath> = columns.into_iter().flatten().collect();
    for name in columns.keys() {
        match spec.meaning(name) {
            Some(Meaning::Time(_)) => {
                let reason =
                    format!("columns.{name}: the times are those of the messages: see clock");
                return Err(Error::content(place, reason));
            }
            Some(_) => {}
            None => {
                let known: Vec<&str> = spec.columns();
                return Err(Error::unknown(place, "column", name, &known));
            }
        }
    }
    Ok((columns, clock))
}

fn runs(root: &mut Section, spec: &Spec, of_all: &Mapping) -> Result<Vec<Listed>, Error> {
    let tables = root.tables("run", MOST_RUNS);
    if tables.is_empty() {
        root.missing(&["run"], "a table [[run]] for each file");
    }
    root.stop_at_problem()?;
    let mut seen = BTreeSet::new();
    let mut runs = Vec::new();
    for mut table in tables {
        let place = table.place().to_string();
        let (columns, clock) = mapping(&mut table, spec)?;
        let mut run = listed(table, spec)?;
        run.columns = if columns.is_empty() {
            of_all.0.clone()
        } else {
            columns
        };
        run.clock = clock.or(of_all.1);
        if run.clock.is_some() && run.columns.is_empty() {
            let reason = "clock: must stand beside columns; other files have a column of times";
            return Err(Error::content(place, reason));
        }
        if !seen.insert(run.file.clone()) {
            let reason = format!("{} is listed twice", one_line(&run.file));
            return Err(Error::Duplicate { place, reason });
        }
        runs.push(run);
    }
    Ok(runs)
}

/// One run.
fn listed(mut s: Section, spec: &Spec) -> Result<Listed, RobotError> {
    let run = Listed {
        file: s.text_as("file", FILE, within).unwrap_or_default(),
        window: if spec.timed { valid(&mut s) } else { [None; 2] },
        columns: BTreeMap::new(),
        clock: None,
        settings: set(&mut s, spec.settings),
        instants: spec
            .instants
            .iter()
            .filter_map(|&key| Some((key, instant(&mut s, key, None)?)))
            .collect(),
    };
    s.finish(run)
}

/// `name` as a path that stays where it starts.
pub(super) fn within(name: &str) -> Option<String> {
    let mut path = PathBuf::new();
    for part in Path::new(name).components() {
        match part {
            Component::Normal(part) => path.push(part),
            Component::CurDir => {}
            _ => return None,
        }
    }
    path.to_str()
        .filter(|path| !path.is_empty())
        .map(str::to_owned)
}

/// The part of a run that the operator calls valid.
fn valid(s: &mut Section) -> [Option<Instant>; 2] {
    let from = instant(s, "valid_from_s", None);
    [from, instant(s, "valid_to_s", from)]
}

/// The instant `key` on the clock of a run, which is after `from`, the key `valid_from_s`.
fn instant(s: &mut Section, key: &'static str, from: Option<Instant>) -> Option<Instant> {
    let allowed = from.map_or(instant::ALLOWED.into(), |from| {
        format!("{}, after valid_from_s = {from}", instant::ALLOWED)
    });
    s.literal(stem(key, TIME), TIME, &allowed, |literal, unit| {
        Instant::parse(literal, power(unit))
            .filter(|instant| from.is_none_or(|from| *instant > from))
    })
}

/// The number of the word that stands under a setting, if it is there.
fn named(s: &mut Section, setting: &Setting) -> Option<f64> {
    let words: Vec<String> = setting
        .words
        .iter()
        .map(|(word, _)| format!("{word:?}"))
        .collect();
    let allowed = format!("one of {}", words.join(", "));
    let number = |text: &str| {
        setting
            .words
            .iter()
            .find(|(word, _)| *word == text)
            .map(|(_, x)| *x)
    };
    if s.has(setting.key) {
        s.text_as(setting.key, &allowed, number)
    } else {
        None
    }
}

fn set(s: &mut Section, known: &[Setting]) -> BTreeMap<String, f64> {
    let mut settings = BTreeMap::new();
    for setting in known {
        let stem = stem(setting.key, setting.quantity);
        match setting.form {
            Form::One => {}
            Form::Word => {
                settings.extend(named(s, setting).map(|word| (setting.key.to_owned(), word)));
                continue;
            }
            Form::List => {
                let items = (1..).zip(s.list(stem, setting.quantity, setting.domain));
                settings.extend(items.map(|(k, x)| (format!("{}.{k}", setting.key), x)));
                continue;
            }
            Form::Names => {
                let items = (1..).zip(s.names(setting.key));
                settings.extend(
                    items.map(|(k, name)| (format!("{}.{name}", setting.key), f64::from(k))),
                );
                continue;
            }
        }
        let number = match s.word(setting.key, setting.words) {
            None if setting.required => Some(s.number(stem, setting.quantity, setting.domain)),
            None => s.optional(stem, setting.quantity, setting.domain),
            word => word,
        };
        settings.extend(number.map(|number| (setting.key.to_owned(), number)));
    }
    settings
}
