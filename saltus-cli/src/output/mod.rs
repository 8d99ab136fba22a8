//! What a command hands back: a report in one of three formats, and files that appear whole or not
//! at all.

mod files;
mod number;
mod share;
mod table;
mod unit;

use std::path::Path;

use clap::ValueEnum;
use serde_json::Value;

pub(crate) use files::{Files, Stream, overwrites, print, reachable, reachable_folder};
pub(crate) use number::{counted, digits, full, measured};
pub(crate) use share::{in_words, share};
pub(crate) use table::{Cell, Column, Table, cells, columns, grid};
pub(crate) use unit::{split, unit, with_unit};

pub(crate) use crate::session::tell as message;

/// Format of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// For people: aligned, rounded, with units.
    Text,
    /// One object; every number in full.
    Json,
    /// A header with units and one line for each row; every number with 17 significant digits.
    Csv,
}

impl Format {
    /// Endings of files of each format, without the dot.
    pub(crate) const ENDINGS: [(&str, Format); 4] = [
        ("json", Format::Json),
        ("csv", Format::Csv),
        ("txt", Format::Text),
        ("md", Format::Text),
    ];

    /// The format that a file's name asks for, if it does.
    pub(crate) fn of_file(path: &Path) -> Option<Format> {
        let ending = path.extension()?.to_str()?.to_ascii_lowercase();
        Format::ENDINGS
            .iter()
            .find(|(known, _)| *known == ending)
            .map(|(_, format)| *format)
    }
}

/// The name of a file without its folder, for titles.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or(path.as_os_str());
    name.to_string_lossy().into_owned()
}

/// `head` with lines below: names, which take so many places, and what is said of them.
pub(crate) fn lines(head: &str, width: usize, lines: &[(impl AsRef<str>, String)]) -> String {
    let line = |(name, words): &(_, String)| {
        let name: &str = AsRef::as_ref(name);
        format!("  {name:<width$} {words}\n")
    };
    let lines: String = lines.iter().map(line).collect();
    format!("{head}\n{lines}")
}

/// One object with the entries of all.
pub(crate) fn joined(parts: impl IntoIterator<Item = Value>) -> Value {
    let maps = parts.into_iter().filter_map(|part| match part {
        Value::Object(map) => Some(map),
        _ => None,
    });
    Value::Object(maps.flatten().collect())
}

/// A JSON document as it is written.
pub(crate) fn json(document: &Value) -> String {
    format!("{document:#}\n")
}
