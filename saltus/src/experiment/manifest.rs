//! `experiment.toml`: what was done, and how each run was set.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read;
use std::ops::Range;
use std::path::{Component, Path, PathBuf};

use saltus_robot::units::{Quantity, TIME, Unit};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::{Error, cut, one_line, shown};
use super::instant::{self, Instant};
use saltus_diagnosis::Sort;
use saltus_diagnosis::spec::{Domain, Setting, Spec, power, spellings};

/// Its name in the folder.
pub(super) const NAME: &str = "experiment.toml";
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
    pub(super) robot: Option<String>,
    /// Standard deviations, by column.
    pub(super) noise: BTreeMap<String, f64>,
    /// Steps, by column.
    pub(super) resolution: BTreeMap<String, f64>,
    pub(super) runs: Vec<Listed>,
}

/// A run as it is listed.
#[derive(Debug)]
pub(super) struct Listed {
    /// Its file, within the folder.
    pub(super) file: String,
    /// The part of it that counts, from and to these instants; none: from its first row, to its
    /// last.
    pub(super) window: [Option<Instant>; 2],
    pub(super) settings: BTreeMap<String, f64>,
    /// When what happened, by its key.
    pub(super) instants: Vec<(&'static str, Instant)>,
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
    let source = Source { file: &file, text };
    let document = DeTable::parse(text).map_err(|error| source.not_toml(&error))?;
    let mut table = Table {
        source,
        path: String::new(),
        start: 0,
        entries: document.into_inner(),
    };
    table.know(
        "key",
        ["kind", "robot", "noise", "resolution", "rig", "run"].map(|key| (key, None)),
    )?;
    let spec = kind(&mut table)?;
    let rig = rig(&mut table, spec)?;
    let needs_robot = spec.robot.is_some() || (rig.is_none() && !spec.rig.is_empty());
    Ok(Manifest {
        spec,
        needs_robot,
        rig: rig.unwrap_or_default(),
        robot: robot(&mut table, needs_robot, spec)?,
        noise: sizes(&mut table, "noise", spec)?,
        resolution: sizes(&mut table, "resolution", spec)?,
        runs: runs(&mut table, spec)?,
    })
}

fn kind(table: &mut Table<'_>) -> Result<&'static Spec, Error> {
    let names = Sort::ALL.map(|sort| sort.spec().id).join(", ");
    let Some(value) = table.take("kind") else {
        return Err(table.missing(&format!("kind: one of {names}")));
    };
    match value.get_ref() {
        DeValue::String(id) if id == "toss" => {
            let reason = "kind = \"toss\": tosses are read by the multi-body simulation's example \
                tosses, not here";
            Err(Error::content(
                table.source.place(value.span().start),
                reason,
            ))
        }
        DeValue::String(id) => Sort::named(id)
            .map(Sort::spec)
            .ok_or_else(|| table.refused("kind", value.span(), &format!("one of {names}"))),
        _ => Err(table.refused("kind", value.span(), &format!("one of {names}, in quotes"))),
    }
}

/// The table `[rig]`; none where there is none.
fn rig(table: &mut Table<'_>, spec: &Spec) -> Result<Option<BTreeMap<String, f64>>, Error> {
    let Some(value) = table.take("rig") else {
        return Ok(None);
    };
    if spec.rig.is_empty() {
        let allowed = format!("left out: the kind {} has none", spec.id);
        return Err(table.refused("rig", value.span(), &allowed));
    }
    let mut inner = table.inner("rig", value)?;
    let known = spec.rig.iter();
    inner.know(
        "key",
        known.map(|setting| (setting.key, Some(setting.quantity))),
    )?;
    set(&mut inner, spec.rig).map(Some)
}

fn robot(table: &mut Table<'_>, is_needed: bool, spec: &Spec) -> Result<Option<String>, Error> {
    const ALLOWED: &str = "a robot's name or the path of its file, in quotes";
    match table.take("robot") {
        None if is_needed && spec.rig.is_empty() => {
            Err(table.missing(&format!("robot: {ALLOWED}")))
        }
        None if is_needed => {
            let required = spec.rig.iter().filter(|setting| setting.required);
            let keys: Vec<&str> = required.map(|setting| setting.key).collect();
            let keys = keys.join(", ");
            Err(table.missing(&format!("rig: a table with {keys}; or robot: {ALLOWED}")))
        }
        None => Ok(None),
        Some(value) => match value.get_ref() {
            DeValue::String(name) if !name.is_empty() => Ok(Some(name.clone().into_owned())),
            _ => Err(table.refused("robot", value.span(), ALLOWED)),
        },
    }
}

/// The table `[key]`: a size above 0 for some of the channels.
fn sizes(
    table: &mut Table<'_>,
    key: &'static str,
    spec: &Spec,
) -> Result<BTreeMap<String, f64>, Error> {
    const SIZE: Domain = Domain {
        legal: |x| x > 0.0,
        allowed: "a number above 0 in the column's unit",
    };
    let Some(value) = table.take(key) else {
        return Ok(BTreeMap::new());
    };
    let mut table = table.inner(key, value)?;
    table.know(
        "column",
        spec.channels
            .iter()
            .map(|own| (own.name, Some(own.quantity))),
    )?;
    let mut sizes = BTreeMap::new();
    for own in spec.channels {
        let size = table.number(own.name, (own.quantity, SIZE))?;
        sizes.extend(size.map(|size| (own.name.to_owned(), size)));
    }
    Ok(sizes)
}

fn runs(table: &mut Table<'_>, spec: &Spec) -> Result<Vec<Listed>, Error> {
    let Some(value) = table.take("run") else {
        return Err(table.missing("run: a table [[run]] for each file"));
    };
    let span = value.span();
    let DeValue::Array(items) = value.into_inner() else {
        return Err(table.refused("run", span, "tables, as in [[run]]"));
    };
    if items.is_empty() || items.len() > MOST_RUNS {
        let reason = format!("{} runs: must be from 1 to {MOST_RUNS}", items.len());
        return Err(Error::content(table.source.place(span.start), reason));
    }
    let mut seen = BTreeSet::new();
    let mut runs = Vec::new();
    for (i, item) in items.into_iter().enumerate() {
        let mut inner = table.inner(&format!("run[{i}]"), item)?;
        let (run, start) = listed(&mut inner, spec)?;
        if !seen.insert(run.file.clone()) {
            let place = table.source.place(start);
            return Err(Error::Duplicate {
                place,
                reason: format!("{} is listed twice", one_line(&run.file)),
            });
        }
        runs.push(run);
    }
    Ok(runs)
}

/// One run, and where its file is named.
fn listed(table: &mut Table<'_>, spec: &Spec) -> Result<(Listed, usize), Error> {
    let window: &[&str] = if spec.timed {
        &["valid_from_s", "valid_to_s"]
    } else {
        &[]
    };
    let settings = spec
        .settings
        .iter()
        .map(|setting| (setting.key, Some(setting.quantity)));
    let times = window
        .iter()
        .chain(spec.instants)
        .map(|key| (*key, Some(TIME)));
    table.know(
        "key",
        [("file", None)].into_iter().chain(settings).chain(times),
    )?;
    let Some(value) = table.take("file") else {
        return Err(table.missing("file"));
    };
    let file = match value.get_ref() {
        DeValue::String(name) => within(name),
        _ => None,
    };
    let file = file.ok_or_else(|| {
        table.refused(
            "file",
            value.span(),
            "the name of a file in this folder, without .. and not absolute",
        )
    })?;
    let window = valid(table)?;
    let settings = set(table, spec.settings)?;
    let mut instants = Vec::new();
    for &key in spec.instants {
        instants.extend(table.instant(key)?.map(|(_, instant)| (key, instant)));
    }
    Ok((
        Listed {
            file,
            window,
            settings,
            instants,
        },
        value.span().start,
    ))
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
fn valid(table: &mut Table<'_>) -> Result<[Option<Instant>; 2], Error> {
    let from = table.instant("valid_from_s")?;
    let to = table.instant("valid_to_s")?;
    if let (Some((_, from)), Some((place, to))) = (&from, &to)
        && from >= to
    {
        return Err(table.refused(
            "valid_to_s",
            place.clone(),
            &format!("after valid_from_s = {from}"),
        ));
    }
    Ok([from, to].map(|instant| instant.map(|(_, instant)| instant)))
}

fn set(table: &mut Table<'_>, known: &[Setting]) -> Result<BTreeMap<String, f64>, Error> {
    let mut settings = BTreeMap::new();
    for setting in known {
        let word = match table.entries.get(setting.key).map(Spanned::get_ref) {
            Some(DeValue::String(word)) => setting.word(word),
            _ => None,
        };
        let number = match word {
            Some(number) => table.take(setting.key).map(|_| number),
            None => table.number(setting.key, (setting.quantity, setting.domain))?,
        };
        match number {
            Some(number) => settings.extend([(setting.key.to_owned(), number)]),
            None if setting.required => return Err(table.missing(setting.key)),
            None => {}
        }
    }
    Ok(settings)
}

/// A number as it is written, without underscores.
fn literal<'v>(value: &'v Spanned<DeValue<'_>>) -> Option<&'v str> {
    match value.get_ref() {
        DeValue::Float(float) => Some(float.as_str()),
        DeValue::Integer(integer) if integer.radix() == 10 => Some(integer.as_str()),
        _ => None,
    }
}

/// The file that a table is from.
#[derive(Clone, Copy)]
struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl Source<'_> {
    fn place(&self, offset: usize) -> String {
        let line = self
            .text
            .get(..offset)
            .map_or(1, |before| before.split('\n').count());
        format!("{}:{line}", self.file)
    }

    fn not_toml(&self, error: &toml::de::Error) -> Error {
        let words = error
            .message()
            .split_whitespace()
            .collect::<Vec<_>>()
            .join(" ");
        let start = error.span().map_or(0, |span| span.start);
        Error::content(self.place(start), format!("not TOML: {}", one_line(&words)))
    }
}

/// A table whose keys are taken one by one.
struct Table<'a> {
    source: Source<'a>,
    /// Its name, with a dot behind it; empty for the file itself.
    path: String,
    /// Where it begins. Lines are counted only for a message: a file may have many tables.
    start: usize,
    entries: DeTable<'a>,
}

impl<'a> Table<'a> {
    fn inner(&self, key: &str, value: Spanned<DeValue<'a>>) -> Result<Table<'a>, Error> {
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(entries) => Ok(Table {
                source: self.source,
                path: format!("{}{key}.", self.path),
                start: span.start,
                entries,
            }),
            _ => Err(self.refused(key, span, "a table")),
        }
    }

    fn take(&mut self, key: &str) -> Option<Spanned<DeValue<'a>>> {
        self.entries.remove(key)
    }

    /// Refuses every key but these. This comes before what is missing, which mostly is a key
    /// misspelt.
    fn know(
        &self,
        what: &'static str,
        known: impl IntoIterator<Item = (&'static str, Option<Quantity>)>,
    ) -> Result<(), Error> {
        let mut spelled: Vec<String> = Vec::new();
        for (key, quantity) in known {
            match quantity {
                Some(quantity) => {
                    spelled.extend(spellings(key, quantity).map(|(spelling, _)| spelling));
                }
                None => spelled.push(key.into()),
            }
        }
        let strange = self
            .entries
            .iter()
            .filter(|(key, _)| !spelled.iter().any(|known| known == key.get_ref()));
        strange
            .min_by_key(|(key, _)| key.span().start)
            .map_or(Ok(()), |(key, _)| {
                let known: Vec<&str> = spelled.iter().map(String::as_str).collect();
                Err(Error::unknown(
                    self.source.place(key.span().start),
                    what,
                    key.get_ref(),
                    &known,
                ))
            })
    }

    /// How `key`, which is named in SI, is spelled and what it says, in whichever of its units; it
    /// must be given once.
    fn spelled(
        &mut self,
        key: &'static str,
        quantity: Quantity,
    ) -> Result<Option<(String, Unit, Spanned<DeValue<'a>>)>, Error> {
        let mut given: Option<(String, Unit, Spanned<DeValue<'a>>)> = None;
        for (spelling, unit) in spellings(key, quantity) {
            let Some(value) = self.take(&spelling) else {
                continue;
            };
            if let Some((other, ..)) = &given {
                let allowed = format!("left out: {}{other} says the same", self.path);
                return Err(self.refused(&spelling, value.span(), &allowed));
            }
            given = Some((spelling, unit, value));
        }
        Ok(given)
    }

    /// A number in SI.
    fn number(
        &mut self,
        key: &'static str,
        (quantity, domain): (Quantity, Domain),
    ) -> Result<Option<f64>, Error> {
        let Some((spelling, unit, value)) = self.spelled(key, quantity)? else {
            return Ok(None);
        };
        let number = literal(&value).map(|literal| unit.si(literal));
        let legal = number.filter(|number| number.is_finite() && (domain.legal)(*number));
        legal
            .map(Some)
            .ok_or_else(|| self.refused(&spelling, value.span(), domain.allowed))
    }

    /// An instant on the clock of a run, and where it stands.
    fn instant(&mut self, key: &'static str) -> Result<Option<(Range<usize>, Instant)>, Error> {
        let Some((spelling, unit, value)) = self.spelled(key, TIME)? else {
            return Ok(None);
        };
        let instant = literal(&value).and_then(|literal| Instant::parse(literal, power(unit)));
        let found = instant.map(|instant| Some((value.span(), instant)));
        found.ok_or_else(|| self.refused(&spelling, value.span(), instant::ALLOWED))
    }

    fn refused(&self, key: &str, span: Range<usize>, allowed: &str) -> Error {
        let name = format!("{}{key}", self.path);
        let value = cut(self.source.text.get(span.clone()).unwrap_or_default());
        Error::value(self.source.place(span.start), &name, &value, allowed)
    }

    fn missing(&self, what: &str) -> Error {
        Error::missing(
            self.source.place(self.start),
            "key",
            format!("{}{what}", self.path),
        )
    }
}
