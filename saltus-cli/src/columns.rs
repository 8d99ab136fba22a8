//! Columns of numbers from CSV files.

use csv::ByteRecord;

use crate::error::{CliError, cut};
use crate::quantity::Quantity;

/// A column that is read.
pub(crate) struct Column {
    /// Its name in the header.
    pub(crate) name: &'static str,
    /// Other names under which it may stand there, where the first does not.
    pub(crate) others: &'static [&'static str],
    /// What it holds.
    pub(crate) quantity: Quantity,
    /// What has to be there.
    pub(crate) need: Need,
}

impl Column {
    pub(crate) const fn new(name: &'static str, quantity: Quantity, need: Need) -> Column {
        Column {
            name,
            others: &[],
            quantity,
            need,
        }
    }

    /// The same, which may have other names.
    pub(crate) const fn or(self, others: &'static [&'static str]) -> Column {
        Column { others, ..self }
    }
}

/// What has to be there of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Need {
    /// A value in every row.
    Value,
    /// The column, whose cells may be empty.
    Column,
    /// Nothing.
    Nothing,
}

/// A row's line, and its numbers; none where a cell is empty.
pub(crate) type Row<const N: usize> = (u64, [Option<f64>; N]);

/// The rows of `source` in these columns, each with its line; messages call it `file`.
///
/// The first row names the columns. Those that are read may stand anywhere; all others are ignored.
pub(crate) fn read<const N: usize>(
    source: &[u8],
    file: &str,
    columns: &[Column; N],
) -> Result<Vec<Row<N>>, CliError> {
    let (header, records) = records(source, file)?;
    let mut places = [None; N];
    for (place, column) in places.iter_mut().zip(columns) {
        *place = find(&header, column, columns, file)?;
    }
    let mut rows = Vec::new();
    for record in records {
        let (line, record) = record?;
        let mut row = [None; N];
        for ((cell, column), place) in row.iter_mut().zip(columns).zip(places) {
            let text = place
                .and_then(|i| record.get(i))
                .map(String::from_utf8_lossy)
                .unwrap_or_default();
            if column.need == Need::Value || !text.is_empty() {
                *cell = Some(number(&text, column, file, line)?);
            }
        }
        rows.push((line, row));
    }
    Ok(rows)
}

/// The words of the first row in these columns, with its line; none where one of the columns is not
/// there. Every row must have the same.
pub(crate) fn words<const N: usize>(
    source: &[u8],
    file: &str,
    names: [&str; N],
) -> Result<Option<(u64, [String; N])>, CliError> {
    let (header, records) = records(source, file)?;
    let places = names.map(|name| header.iter().position(|cell| bare(cell) == name.as_bytes()));
    if places.iter().any(Option::is_none) {
        return Ok(None);
    }
    let mut first: Option<(u64, [String; N])> = None;
    for record in records {
        let (here, record) = record?;
        let cell = |place: Option<usize>| {
            place
                .and_then(|i| record.get(i))
                .map(String::from_utf8_lossy)
        };
        let words = places.map(|place| cell(place).unwrap_or_default().into_owned());
        match &first {
            None => first = Some((here, words)),
            Some((line, before)) => {
                if let Some(k) = (0..N).find(|&k| words[k] != before[k]) {
                    return Err(CliError::Value {
                        file: file.into(),
                        line: here,
                        key: names[k].into(),
                        value: cut(&words[k]),
                        allowed: format!("{}, as in line {line}", cut(&before[k])),
                    });
                }
            }
        }
    }
    Ok(first)
}

/// A record and its line.
type Record = Result<(u64, ByteRecord), CliError>;

/// The header of `source`, and the records below.
fn records<'a>(
    source: &'a [u8],
    file: &'a str,
) -> Result<(ByteRecord, impl Iterator<Item = Record> + 'a), CliError> {
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .from_reader(source);
    let wrong = move |error: csv::Error| not_csv(&error, source, file);
    let header = reader.byte_headers().map_err(wrong)?.clone();
    let records = reader.into_byte_records().map(move |record| {
        let record = record.map_err(wrong)?;
        let line = record.position().map_or(0, |at| line(at, source));
        Ok((line, record))
    });
    Ok((header, records))
}

/// A byte order mark is no part of the first name.
fn bare(cell: &[u8]) -> &[u8] {
    cell.strip_prefix(b"\xef\xbb\xbf").unwrap_or(cell)
}

/// The line of a record. Where lines end with CR LF, its position is still before the LF.
fn line(position: &csv::Position, source: &[u8]) -> u64 {
    let start = usize::try_from(position.byte()).unwrap_or(usize::MAX);
    let breaks = source
        .get(start..)
        .unwrap_or_default()
        .iter()
        .take_while(|byte| byte.is_ascii_whitespace());
    position.line() + breaks.filter(|byte| **byte == b'\n').count() as u64
}

/// Where a column stands.
fn find(
    header: &ByteRecord,
    column: &Column,
    all: &[Column],
    file: &str,
) -> Result<Option<usize>, CliError> {
    // A file that has the first name may mean something else by another: simulated jumps have both.
    let is_there = |name: &&str| header.iter().any(|cell| bare(cell) == name.as_bytes());
    let name = column
        .others
        .iter()
        .copied()
        .find(is_there)
        .filter(|_| !is_there(&column.name));
    let name = name.unwrap_or(column.name);
    let mut found = (0..header.len()).filter(|&i| bare(&header[i]) == name.as_bytes());
    match (found.next(), found.next()) {
        (_, Some(_)) => Err(CliError::content(
            format!("{file}:1"),
            format!("column {name} is there twice"),
        )),
        (None, _) if column.need != Need::Nothing => {
            let needed: Vec<&str> = all
                .iter()
                .filter(|c| c.need != Need::Nothing)
                .map(|c| c.name)
                .collect();
            let reason = format!(
                "no column {name}: the header must name {}",
                needed.join(", ")
            );
            Err(CliError::content(format!("{file}:1"), reason))
        }
        (place, _) => Ok(place),
    }
}

fn number(text: &str, column: &Column, file: &str, line: u64) -> Result<f64, CliError> {
    column.quantity.parse(text).map_err(|_| CliError::Value {
        file: file.into(),
        line,
        key: column.name.into(),
        value: cut(text),
        allowed: column.quantity.allowed.into(),
    })
}

fn not_csv(error: &csv::Error, source: &[u8], file: &str) -> CliError {
    match error.kind() {
        csv::ErrorKind::UnequalLengths {
            pos,
            expected_len,
            len,
        } => CliError::content(
            pos.as_ref().map_or(file.to_owned(), |pos| {
                format!("{file}:{}", line(pos, source))
            }),
            format!("{len} fields where the header has {expected_len}"),
        ),
        _ => CliError::content(file, error),
    }
}
