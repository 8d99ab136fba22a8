//! The first line of a run: which cell of a row holds what.

use super::error::{Error, cut};
use super::spec::{Channel, Spec};

/// Where the columns stand.
#[derive(Debug)]
pub(super) struct Header {
    /// Cells of a row.
    pub(super) width: usize,
    /// The column of the time, and the power of ten of its unit in s.
    pub(super) time: Option<(usize, i32)>,
    pub(super) valve: Option<usize>,
    /// The channels that are there, in the order of the kind.
    pub(super) channels: Vec<(usize, &'static Channel)>,
}

impl Header {
    /// What `line` says, which stands at `place`.
    pub(super) fn read(line: &[u8], place: &str, spec: &'static Spec) -> Result<Header, Error> {
        let names = names(line, place)?;
        let known = spec.columns();
        for (i, name) in names.iter().enumerate() {
            if name.is_empty() {
                return Err(Error::content(place, format!("column {} has no name", i + 1)));
            }
            if !known.contains(name) {
                return Err(stranger(line, name, place, &known));
            }
            if names[..i].contains(name) {
                return Err(Error::content(place, format!("column {name} is there twice")));
            }
        }
        let find = |name: &str| names.iter().position(|there| *there == name);
        let channels = spec.channels.iter().filter_map(|channel| Some((find(channel.name)?, channel)));
        let header = Header {
            width: names.len(),
            time: find("time_s").map(|column| (column, 0)),
            valve: find("valve"),
            channels: channels.collect(),
        };
        header.complete(place, spec)
    }

    fn complete(self, place: &str, spec: &Spec) -> Result<Header, Error> {
        let missing = |name: &str| Err(Error::missing(place.into(), "column", name));
        let absent = |name: &str| !self.channels.iter().any(|(_, channel)| channel.name == name);
        let first_absent = spec.channels.iter().find(|channel| absent(channel.name));
        match first_absent {
            _ if spec.timed() && self.time.is_none() => missing("time_s"),
            _ if spec.valve && self.valve.is_none() => missing("valve"),
            Some(_) if spec.any_of && self.channels.is_empty() => {
                missing(&spec.channels.iter().map(|channel| channel.name).collect::<Vec<_>>().join(" or "))
            }
            Some(channel) if !spec.any_of => missing(channel.name),
            _ => Ok(self),
        }
    }
}

fn names<'a>(line: &'a [u8], place: &str) -> Result<Vec<&'a str>, Error> {
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

/// A header with a name that the kind does not know: why.
fn stranger(line: &[u8], name: &str, place: &str, known: &[&'static str]) -> Error {
    let wanted = || known.join(",");
    for (separator, words) in [(b';', "semicolons"), (b'\t', "tabs")] {
        if line.contains(&separator) && !line.contains(&b',') {
            let reason = format!("cells are separated by {words}: must be commas, and points in numbers");
            return Error::content(place, reason);
        }
    }
    if name.parse::<f64>().is_ok() {
        let reason = format!("{} stands where the first line must name columns of {}", cut(name), wanted());
        return Error::content(place, reason);
    }
    Error::unknown(place.into(), "column", name, known)
}

/// A cell without blanks and quotes around it.
pub(super) fn bare(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).map_or(cell, str::trim)
}
