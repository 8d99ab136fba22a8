//! Tables of TOML files, key by key: each value checked, and named with its place where it is wrong.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::error::{CliError, cut};
use crate::quantity::Quantity;

/// The file that a table is from.
#[derive(Clone, Copy)]
struct Source<'a> {
    file: &'a str,
    text: &'a str,
}

impl Source<'_> {
    /// The line (from 1) of a place.
    fn line(&self, place: usize) -> u64 {
        self.text.get(..place).map_or(1, |before| before.split('\n').count() as u64)
    }

    fn refused(&self, key: String, place: Range<usize>, allowed: &str) -> CliError {
        CliError::Value {
            file: self.file.into(),
            line: self.line(place.start),
            key,
            value: cut(self.text.get(place).unwrap_or_default()),
            allowed: allowed.into(),
        }
    }
}

/// A table of which keys are taken one by one.
pub(crate) struct Section<'a> {
    source: Source<'a>,
    /// Its name, with a dot behind it; empty for the file itself.
    path: String,
    line: u64,
    table: DeTable<'a>,
    known: Vec<&'static str>,
}

impl<'a> Section<'a> {
    /// The file `text`, which messages call `file`.
    pub(crate) fn file(text: &'a str, file: &'a str) -> Result<Section<'a>, CliError> {
        let source = Source { file, text };
        let table = DeTable::parse(text).map_err(|error| {
            let line = source.line(error.span().map_or(0, |span| span.start));
            let words = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
            CliError::content(format!("{file}:{line}"), format!("not TOML: {words}"))
        })?;
        Ok(Section { source, path: String::new(), line: 1, table: table.into_inner(), known: Vec::new() })
    }

    fn take(&mut self, key: &'static str) -> Option<Spanned<DeValue<'a>>> {
        self.known.push(key);
        self.table.remove(key)
    }

    fn name(&self, key: &str) -> String {
        format!("{}{key}", self.path)
    }

    fn missing(&self, key: &str) -> CliError {
        CliError::content(
            format!("{}:{}", self.source.file, self.line),
            format!("missing key {}", self.name(key)),
        )
    }

    /// A number, if it is given.
    pub(crate) fn number(&mut self, key: &'static str, quantity: &Quantity) -> Result<Option<f64>, CliError> {
        let value = self.take(key);
        value.map(|value| number(self.source, self.name(key), &value, quantity)).transpose()
    }

    /// A number that must be given.
    pub(crate) fn required(&mut self, key: &'static str, quantity: &Quantity) -> Result<f64, CliError> {
        self.number(key, quantity)?.ok_or_else(|| self.missing(key))
    }

    /// A list of numbers, or a single one, that must be given.
    pub(crate) fn numbers(&mut self, key: &'static str, quantity: &Quantity) -> Result<Vec<f64>, CliError> {
        let value = self.take(key).ok_or_else(|| self.missing(key))?;
        let DeValue::Array(items) = value.get_ref() else {
            return Ok(vec![number(self.source, self.name(key), &value, quantity)?]);
        };
        if items.is_empty() {
            return Err(self.source.refused(self.name(key), value.span(), "at least one number"));
        }
        let item = |(i, item): (usize, &Spanned<DeValue<'_>>)| {
            number(self.source, format!("{}[{i}]", self.name(key)), item, quantity)
        };
        items.iter().enumerate().map(item).collect()
    }

    /// Two numbers, the lower first, if they are given.
    pub(crate) fn span(
        &mut self,
        key: &'static str,
        quantity: &Quantity,
    ) -> Result<Option<(f64, f64)>, CliError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        if let DeValue::Array(items) = value.get_ref()
            && let [low, high] = items.iter().collect::<Vec<_>>()[..]
        {
            let low = number(self.source, format!("{}[0]", self.name(key)), low, quantity)?;
            let high = number(self.source, format!("{}[1]", self.name(key)), high, quantity)?;
            if low < high {
                return Ok(Some((low, high)));
            }
        }
        Err(self.source.refused(self.name(key), value.span(), "a list of two numbers, the lower first"))
    }

    /// A whole number from 1 to `most`, if it is given.
    pub(crate) fn count(&mut self, key: &'static str, most: usize) -> Result<Option<usize>, CliError> {
        let Some(value) = self.take(key) else { return Ok(None) };
        let count = match value.get_ref() {
            DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
            _ => None,
        };
        let legal = count.filter(|count| (1..=most).contains(count));
        let refused =
            || self.source.refused(self.name(key), value.span(), &format!("a whole number from 1 to {most}"));
        legal.map(Some).ok_or_else(refused)
    }

    /// The tables of a list, `[[key]]`; none where there is no such key.
    pub(crate) fn tables(&mut self, key: &'static str) -> Result<Vec<Section<'a>>, CliError> {
        let Some(value) = self.take(key) else { return Ok(Vec::new()) };
        let (source, name, place) = (self.source, self.name(key), value.span());
        let refused = || source.refused(name.clone(), place.clone(), &format!("tables, as in [[{key}]]"));
        let DeValue::Array(items) = value.into_inner() else { return Err(refused()) };
        let table = |(i, item): (usize, Spanned<DeValue<'a>>)| {
            let line = source.line(item.span().start);
            match item.into_inner() {
                DeValue::Table(table) => {
                    Ok(Section { source, path: format!("{name}[{i}]."), line, table, known: Vec::new() })
                }
                _ => Err(refused()),
            }
        };
        items.into_iter().enumerate().map(table).collect()
    }

    /// An error at this table.
    pub(crate) fn wrong(&self, reason: &str) -> CliError {
        CliError::content(format!("{}:{}", self.source.file, self.line), reason)
    }

    /// Refuses keys that nobody took.
    pub(crate) fn finish(self) -> Result<(), CliError> {
        match self.table.iter().next() {
            None => Ok(()),
            Some((key, _)) => Err(CliError::content(
                format!("{}:{}", self.source.file, self.source.line(key.span().start)),
                format!(
                    "unknown key {}: known are {}",
                    self.name(&cut(key.get_ref())),
                    self.known.join(", ")
                ),
            )),
        }
    }
}

fn number(
    source: Source<'_>,
    name: String,
    value: &Spanned<DeValue<'_>>,
    quantity: &Quantity,
) -> Result<f64, CliError> {
    let literal = match value.get_ref() {
        DeValue::Float(float) => Some(float.as_str()),
        DeValue::Integer(integer) if integer.radix() == 10 => Some(integer.as_str()),
        _ => None,
    };
    let number = literal.and_then(|literal| quantity.parse(literal).ok());
    number.ok_or_else(|| source.refused(name, value.span(), quantity.allowed))
}
