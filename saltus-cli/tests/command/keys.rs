//! Keys of JSON and columns of CSV, over all transcripts of `tests/golden`: each stands in the help
//! of its command, and one that ends in a unit has that unit.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::Value;

use crate::common::{Folder, rows};
use crate::golden::{self, Case};

/// Keys of objects whose keys are names of data, not of the answer: of parameters, channels, causes;
/// and of what a file holds that another command reads.
const OF_NAMES: &[&str] = &[
    "parameters",
    "standard_errors",
    "intervals_95",
    "slips",
    "estimated",
    "gain",
    "noise",
    "held_out_rms",
    "correlation_with",
    "others",
    "together",
    "exponents",
    "policy",
];

/// Units at the end of a key, the longer ones first, and how texts write them: each with the factor
/// to the unit of the key.
const UNITS: &[(&str, &[(&str, f64)])] = &[
    ("_m_s_per_rad", &[("m s/rad", 1.0)]),
    ("_m_per_rad", &[("m/rad", 1.0)]),
    ("_m_per_s", &[("m/s", 1.0)]),
    ("_m_per_pa", &[("m/Pa", 1.0)]),
    ("_j_per_m", &[("J/m", 1.0)]),
    ("_kg_per_m", &[("kg/m", 1.0), ("g/m", 1e-3)]),
    ("_rad_s", &[("rad/s", 1.0)]),
    ("_m_s", &[("m/s", 1.0)]),
    ("_n_s", &[("N s", 1.0)]),
    ("_rad", &[("rad", 1.0)]),
    ("_deg", &[("deg", 1.0), ("°", 1.0)]),
    ("_m", &[("m", 1.0), ("cm", 1e-2), ("mm", 1e-3)]),
    ("_s", &[("s", 1.0), ("ms", 1e-3)]),
    ("_pa", &[("Pa", 1.0), ("kPa", 1e3), ("bar", 1e5)]),
    ("_psi", &[("psi", 1.0)]),
    ("_n", &[("N", 1.0)]),
    ("_j", &[("J", 1.0)]),
    ("_k", &[("K", 1.0)]),
    ("_kg", &[("kg", 1.0), ("g", 1e-3)]),
];

/// Answers with the commands that gave them.
type Answers<T> = Vec<(String, T)>;

/// The JSON documents and the CSV tables of the transcript `name`, each with its command.
fn documents(name: &str) -> (Answers<Value>, Answers<String>) {
    let mut documents = Vec::new();
    let mut tables = Vec::new();
    for Case { line, out } in golden::cases(name) {
        let is = |format: &str| {
            line.ends_with(&format!("--format {format}"))
                // Folders of data have columns of their own: docs/logs.md.
                || line.starts_with("cat ")
                    && !line.contains('/')
                    && line.ends_with(&format!(".{format}"))
        };
        // A number that was round-off.
        let out = out.replace("~0", "0");
        if is("json") && !out.trim().is_empty() {
            documents.push((line, serde_json::from_str(&out).unwrap()));
        } else if is("csv") && !out.trim().is_empty() {
            tables.push((line, out.trim().to_owned()));
        }
    }
    (documents, tables)
}

/// All keys of `value` but names of data.
fn keys(value: &Value, found: &mut BTreeSet<String>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                found.insert(key.clone());
                if !(OF_NAMES.contains(&key.as_str()) && value.is_object()) {
                    keys(value, found);
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| keys(value, found)),
        _ => {}
    }
}

/// Answers in JSON that are in no transcript, because their last digits are not the same on every
/// processor.
const MORE: &[&str] = &["run speed --speed 0:3 --seconds 0.3 --format json"];

/// Keys and columns of the transcript `name`.
fn written(name: &str) -> BTreeSet<String> {
    let (documents, tables) = documents(name);
    let mut found = BTreeSet::new();
    for line in MORE {
        if line.split_whitespace().next() == Some(name) {
            let out = Folder::new("keys-more").done(line, 0);
            keys(&serde_json::from_str(&out).unwrap(), &mut found);
        }
    }
    for (_, document) in &documents {
        keys(document, &mut found);
    }
    for (_, table) in &tables {
        found.extend(rows(table).0);
    }
    found
}

/// The words of a help that can be keys. `vx_m_s to vz_m_s` stands for three of them, `apex_by_…` for
/// all that begin so.
struct Help {
    words: BTreeSet<String>,
}

impl Help {
    fn of(command: &str) -> Help {
        let text =
            Folder::new(&format!("keys-help-{command}")).done(&format!("{command} --help"), 0);
        let is_part = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '…';
        let parts: Vec<&str> = text
            .split(|c: char| !is_part(c))
            .filter(|word| !word.is_empty())
            .collect();
        let mut words: BTreeSet<String> = parts.iter().map(|&word| word.to_owned()).collect();
        for ends in parts.windows(3).filter(|ends| ends[1] == "to") {
            words.extend(between(ends[0], ends[2]));
        }
        Help { words }
    }

    /// Whether `key` stands in it: `extension_N_m` for the number of a leg, `DEMAND_holds` for the
    /// name of a demand.
    fn has(&self, key: &str) -> bool {
        let numbered: Vec<&str> = key
            .split('_')
            .map(|part| {
                if part.parse::<u32>().is_ok() {
                    "N"
                } else {
                    part
                }
            })
            .collect();
        let named = key
            .split_once('_')
            .map(|(_, rest)| format!("DEMAND_{rest}"));
        let begins = |word: &String| {
            let start = word.strip_suffix('…').filter(|start| start.len() > 3);
            start.is_some_and(|start| key.starts_with(start))
        };
        self.words.contains(key)
            || self.words.contains(&numbered.join("_"))
            || named.is_some_and(|named| self.words.contains(&named))
            || self.words.iter().any(begins)
    }
}

/// The words from `first` to `last`, which differ in one letter of w, x, y, z.
fn between(first: &str, last: &str) -> Vec<String> {
    let differ = |(a, b): &(char, char)| a != b;
    let place = first
        .chars()
        .zip(last.chars())
        .position(|pair| differ(&pair));
    let Some(place) = place.filter(|_| first.len() == last.len() && first.is_ascii()) else {
        return Vec::new();
    };
    let with = |letter: char| format!("{}{letter}{}", &first[..place], &first[place + 1..]);
    let letter = |word: &str| word[place..].chars().next().unwrap_or_default();
    ('w'..='z')
        .filter(|it| (letter(first)..=letter(last)).contains(it))
        .map(with)
        .collect()
}

#[test]
fn every_key_and_column_stands_in_the_help() {
    let mut missing = BTreeMap::new();
    let mut count = 0;
    for name in golden::names() {
        let help = Help::of(&name);
        let keys = written(&name);
        count += keys.len();
        let absent: Vec<String> = keys.into_iter().filter(|key| !help.has(key)).collect();
        if !absent.is_empty() {
            missing.insert(name, absent);
        }
    }
    assert!(missing.is_empty(), "not in the help: {missing:#?}");
    assert!(
        count > 200,
        "{count} keys are too few: has a transcript lost its JSON?"
    );
}

/// The unit with which `key` ends, and how texts write it.
fn unit(key: &str) -> Option<&'static [(&'static str, f64)]> {
    let found = UNITS.iter().find(|(suffix, _)| key.ends_with(suffix));
    found.map(|(_, written)| *written)
}

/// All numbers of `value` with their keys, but those of objects whose keys are names of data.
fn leaves(key: &str, value: &Value, found: &mut Vec<(String, f64)>) {
    match value {
        Value::Object(object) => {
            for (key, value) in object {
                if !(OF_NAMES.contains(&key.as_str()) && value.is_object()) {
                    leaves(key, value, found);
                }
            }
        }
        Value::Array(values) => values.iter().for_each(|value| leaves(key, value, found)),
        Value::Number(number) => found.push((key.to_owned(), number.as_f64().unwrap())),
        _ => {}
    }
}

/// The numbers of a text that a known unit follows, as printed, with that unit; those of a table are
/// under its line of units.
fn quantities(text: &str) -> Vec<(String, &'static str)> {
    let known: Vec<&str> = UNITS
        .iter()
        .flat_map(|(_, written)| written.iter().map(|(unit, _)| *unit))
        .collect();
    let mut found = Vec::new();
    let mut columns: Vec<(usize, &'static str)> = Vec::new();
    for line in text.lines() {
        let words = words_of(line);
        let named = |word: &str| known.iter().copied().find(|unit| *unit == word);
        if !words.is_empty() && words.iter().all(|(_, word)| named(word).is_some()) {
            columns = words
                .iter()
                .filter_map(|(end, word)| Some((*end, named(word)?)))
                .collect();
            continue;
        }
        for (k, (end, word)) in words.iter().enumerate() {
            let number = word
                .trim_end_matches([',', ';', ':', ')'])
                .trim_start_matches('(');
            if number.parse::<f64>().is_err() {
                continue;
            }
            let next = words.get(k + 1).map_or("", |(_, next)| {
                next.trim_end_matches([',', ';', ')', ':', '.'])
            });
            let column = columns
                .iter()
                .find(|(at, _)| at == end)
                .map(|(_, unit)| *unit);
            if let Some(unit) = named(next).or(column) {
                found.push((number.to_owned(), unit));
            }
        }
    }
    found
}

/// The words of a line, each with the column where it ends.
fn words_of(line: &str) -> Vec<(usize, &str)> {
    let mut words = Vec::new();
    for word in line.split_whitespace() {
        let start = word.as_ptr() as usize - line.as_ptr() as usize;
        words.push((line[..start + word.len()].chars().count(), word));
    }
    words
}

/// Significant digits of a number as printed.
fn significant(number: &str) -> usize {
    let mantissa = number.split('e').next().unwrap_or_default();
    let digits = mantissa.trim_start_matches(['-', '0', '.']);
    digits.chars().filter(char::is_ascii_digit).count()
}

/// Whether `value` prints as `number` in a unit of this size.
fn prints(value: f64, number: &str, size: f64) -> bool {
    let printed: f64 = number.parse().unwrap();
    let step = printed.abs() * 10f64.powi(1 - i32::try_from(significant(number)).unwrap());
    // Half a step of the last digit, and the rounding of the transcript.
    (value / size - printed).abs() <= 0.51 * step + 1e-5 * printed.abs()
}

/// Of each command the text and the JSON of the same case are compared: a number that stands in both
/// has, in the text, the unit with which its key ends.
#[test]
fn a_key_that_ends_in_a_unit_has_that_unit() {
    let mut wrong = BTreeSet::new();
    let mut right = BTreeSet::new();
    for name in golden::names() {
        let cases = golden::cases(&name);
        for (line, document) in documents(&name).0 {
            let Some(line) = line.strip_suffix(" --format json") else {
                continue;
            };
            let Some(text) = cases.iter().find(|case| case.line == line) else {
                continue;
            };
            let quantities = quantities(&text.out);
            let mut numbers = Vec::new();
            leaves("", &document, &mut numbers);
            for (key, value) in numbers.into_iter().filter(|(_, value)| *value != 0.0) {
                let Some(written) = unit(&key) else { continue };
                let size = |unit: &str| written.iter().find(|(it, _)| *it == unit).map(|it| it.1);
                // Two digits are the same by chance too often.
                let told: Vec<_> = quantities
                    .iter()
                    .filter(|(it, _)| significant(it) > 3)
                    .collect();
                let is_right = |(number, unit): &&&(String, &str)| {
                    size(unit).is_some_and(|size| prints(value, number, size))
                };
                let is_wrong = |(number, unit): &&&(String, &str)| {
                    let sizes = [1e-3, 1e-2, 1.0, std::f64::consts::PI / 180.0, 1e3, 1e5];
                    let own = size(unit);
                    sizes
                        .iter()
                        .any(|size| own != Some(*size) && prints(value, number, *size))
                };
                if told.iter().any(|it| is_right(&it)) {
                    right.insert(format!("{name} {key}"));
                } else if let Some((number, unit)) = told.iter().find(is_wrong) {
                    wrong.insert(format!(
                        "{name} {key} = {value}: {number} {unit} in the text"
                    ));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(
        right.len() >= 40,
        "{} keys are compared: {right:#?}",
        right.len()
    );
}
