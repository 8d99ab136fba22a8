//! The first line of a run: which cell of a row holds what.

use saltus_robot::units::Unit;

use super::error::{Error, cut};
use saltus_diagnosis::spec::{Column, Meaning, Spec};

/// Where the columns stand.
#[derive(Debug)]
pub(super) struct Header {
    /// Names of the cells of a row, as they are written.
    pub(super) names: Vec<String>,
    /// The column of the time, and the power of ten of its unit in s.
    pub(super) time: Option<(usize, i32)>,
    pub(super) valve: Option<usize>,
    /// The channels that are there, in the order of the kind, each with the unit of its cells.
    pub(super) channels: Vec<(usize, &'static Column, Unit)>,
    /// Names of the columns that the kind does not know, which are skipped.
    pub(super) strange: Vec<String>,
}

impl Header {
    /// What `line` says, which stands at `place`.
    pub(super) fn read(line: &[u8], place: &str, spec: &'static Spec) -> Result<Header, Error> {
        let names = names(line, place)?;
        let mut header = Header {
            names: names.iter().map(|name| (*name).to_owned()).collect(),
            time: None,
            valve: None,
            channels: Vec::new(),
            strange: Vec::new(),
        };
        for (i, name) in names.iter().enumerate() {
            if name.is_empty() {
                return Err(Error::content(
                    place,
                    format!("column {} has no name", i + 1),
                ));
            }
            if header.take(i, name, spec) {
                return Err(Error::content(
                    place,
                    format!("column {name} is there twice"),
                ));
            }
        }
        // Members of a family come last, in the order of the file.
        let order = |own: &Column| {
            let known = spec.channels.iter();
            let place = known.clone().position(|known| known.name == own.name);
            place.unwrap_or(known.len())
        };
        header.channels.sort_by_key(|(_, own, _)| order(own));
        for name in &header.strange {
            header.is_skipped(name, line, place, spec)?;
        }
        header.complete(place, spec)
    }

    /// Takes in the name of column `i`; whether what it holds is there already.
    fn take(&mut self, i: usize, name: &str, spec: &'static Spec) -> bool {
        match spec.meaning(name) {
            Some(Meaning::Time(power)) => self.time.replace((i, power)).is_some(),
            Some(Meaning::Valve) => self.valve.replace(i).is_some(),
            Some(Meaning::Column(own, unit)) => {
                let is_there = self
                    .channels
                    .iter()
                    .any(|(_, other, _)| other.name == own.name);
                self.channels.push((i, own, unit));
                is_there
            }
            None => {
                self.strange.push(name.into());
                false
            }
        }
    }

    /// Refuses a strange name that stands for a column that is not there, or is none.
    fn is_skipped(&self, name: &str, line: &[u8], place: &str, spec: &Spec) -> Result<(), Error> {
        for (separator, words) in [(b';', "semicolons"), (b'\t', "tabs")] {
            if line.contains(&separator) && !line.contains(&b',') {
                let reason = format!(
                    "cells are separated by {words}: must be commas, and points in numbers"
                );
                return Err(Error::content(place, reason));
            }
        }
        if name.parse::<f64>().is_ok() {
            let wanted = spec.columns().join(",");
            let reason = format!(
                "{} stands where the first line must name columns of {wanted}",
                cut(name)
            );
            return Err(Error::content(place, reason));
        }
        let absent: Vec<&str> = spec
            .columns()
            .into_iter()
            .filter(|known| !self.has(known))
            .collect();
        if absent.iter().any(|known| resembles(name, known)) {
            return Err(Error::unknown(place.into(), "column", name, &absent));
        }
        Ok(())
    }

    /// Whether the column of this name in SI is there.
    fn has(&self, name: &str) -> bool {
        match name {
            "time_s" => self.time.is_some(),
            "valve" => self.valve.is_some(),
            _ => self.channels.iter().any(|(_, own, _)| own.name == name),
        }
    }

    fn complete(self, place: &str, spec: &Spec) -> Result<Header, Error> {
        let optional = |name: &str| spec.channel(name).is_some_and(|own| own.optional);
        let mut absent = spec
            .columns()
            .into_iter()
            .filter(|name| !self.has(name) && !optional(name));
        let missing = match absent.next() {
            Some(name) => name.to_owned(),
            None if self.channels.is_empty() => spec
                .channels
                .iter()
                .map(|own| own.name)
                .collect::<Vec<_>>()
                .join(" or "),
            None => return Ok(self),
        };
        let strange = match &self.strange[..] {
            [] => String::new(),
            names => format!("; not known are {}", cut(&names.join(", "))),
        };
        Err(Error::missing(place.into(), "column", missing + &strange))
    }
}

/// Whether `name` is probably a slip for the column `known`: a letter or two, capitals, or a unit
/// that is not known.
fn resembles(name: &str, known: &str) -> bool {
    let (name, stem) = (
        name.to_lowercase(),
        known.rsplit_once('_').map_or(known, |(stem, _)| stem),
    );
    // Short names are near to anything.
    let is_long = stem.len() > 3;
    let other_unit = name
        .strip_prefix(stem)
        .is_some_and(|rest| rest.is_empty() || rest.starts_with(['_', ' ', '(']));
    name == known || (is_long && (other_unit || strsim::levenshtein(&name, known) <= 2))
}

pub(super) fn names<'a>(line: &'a [u8], place: &str) -> Result<Vec<&'a str>, Error> {
    // A byte order mark is no part of the first name.
    let line = line.strip_prefix(b"\xef\xbb\xbf").unwrap_or(line);
    match std::str::from_utf8(line) {
        Ok(text) if !text.contains('\0') => Ok(text.split(',').map(bare).collect()),
        _ => Err(Error::content(
            place,
            "not UTF-8 text: a run is a CSV file whose first line names the columns",
        )),
    }
}

/// A cell without blanks and quotes around it.
pub(super) fn bare(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"')
        .and_then(|cell| cell.strip_suffix('"'))
        .map_or(cell, str::trim)
}
