//! Rows of named columns, which is what every format prints.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::number::{digits, full, measured};
use super::unit::unit;

/// One value of a row.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Cell {
    /// A number in the unit that its column's name ends with; one that is not finite is
    /// [`Cell::Empty`].
    Number(f64),
    /// A word.
    Word(&'static str),
    /// Words.
    Text(String),
    /// Yes or no.
    Flag(bool),
    /// A whole number.
    Count(usize),
    /// There is no such value.
    Empty,
}

impl From<f64> for Cell {
    fn from(x: f64) -> Cell {
        if x.is_finite() {
            Cell::Number(x)
        } else {
            Cell::Empty
        }
    }
}

macro_rules! from {
    ($($of:ty => $cell:ident),+) => {
        $(impl From<$of> for Cell {
            fn from(of: $of) -> Cell {
                Cell::$cell(of)
            }
        })+
    };
}
from!(&'static str => Word, String => Text, bool => Flag, usize => Count);

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Cell {
        value.map_or(Cell::Empty, T::into)
    }
}

impl Cell {
    fn csv(&self) -> String {
        match self {
            Cell::Number(x) => full(*x),
            Cell::Word(word) => (*word).into(),
            Cell::Text(text) => quoted(text),
            Cell::Flag(flag) => flag.to_string(),
            Cell::Count(n) => n.to_string(),
            Cell::Empty => String::new(),
        }
    }

    fn json(&self) -> Value {
        match self {
            Cell::Number(x) => json!(x),
            Cell::Word(word) => json!(word),
            Cell::Text(text) => json!(text),
            Cell::Flag(flag) => json!(flag),
            Cell::Count(n) => json!(n),
            Cell::Empty => Value::Null,
        }
    }

    /// For people, in a column of this unit.
    fn text(&self, unit: &str) -> String {
        match self {
            Cell::Number(x) if ["m", "rad", "rad/s", "m/s", "s"].contains(&unit) => measured(*x, 4),
            Cell::Number(x) => digits(*x, 4),
            Cell::Empty => "–".into(),
            Cell::Text(text) => text.clone(),
            Cell::Flag(flag) => if *flag { "yes" } else { "no" }.into(),
            other => other.csv(),
        }
    }
}

/// A field of a CSV file: in quotes where it holds what ends a field.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

/// A column of rows `R`: its name, which ends with its unit, its title for people (empty: not shown),
/// and its cell of a row.
pub(crate) type Column<R> = (&'static str, &'static str, fn(&R) -> Cell);

/// Columns of a table, a line each: name, title, and what is in it of a row.
macro_rules! columns {
    ($($name:expr, $title:expr, |$row:pat_param| $cell:expr;)+) => {
        [$(($name, $title, |$row| $crate::output::Cell::from($cell))),+]
    };
}
pub(crate) use columns;

/// Rows under a header.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    columns: Vec<&'static str>,
    titles: Vec<&'static str>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// The table of `rows`.
    pub(crate) fn of<R>(columns: &[Column<R>], rows: impl IntoIterator<Item = R>) -> Table {
        let row = |row: R| columns.iter().map(|(.., cell)| cell(&row)).collect();
        Table {
            columns: columns.iter().map(|(name, ..)| *name).collect(),
            titles: columns.iter().map(|(_, title, _)| *title).collect(),
            rows: rows.into_iter().map(row).collect(),
        }
    }

    /// With more columns without a title, and their cells of each row.
    pub(crate) fn with(
        mut self,
        columns: &[&'static str],
        cells: impl IntoIterator<Item = Vec<Cell>>,
    ) -> Table {
        self.columns.extend(columns);
        self.titles.resize(self.columns.len(), "");
        for (row, cells) in self.rows.iter_mut().zip(cells) {
            row.extend(cells);
        }
        self
    }

    /// Header and rows, numbers with 17 significant digits; lines end with a line feed.
    pub(crate) fn csv(&self) -> String {
        let mut text = self.columns.join(",");
        text.push('\n');
        for row in &self.rows {
            for (i, cell) in row.iter().enumerate() {
                if i > 0 {
                    text.push(',');
                }
                text.push_str(&cell.csv());
            }
            text.push('\n');
        }
        text
    }

    /// The rows as objects with the columns as keys; an empty cell is null.
    pub(crate) fn json(&self) -> Vec<Map<String, Value>> {
        let object = |row: &Vec<Cell>| {
            self.columns
                .iter()
                .zip(row)
                .map(|(name, cell)| ((*name).to_owned(), cell.json()))
                .collect()
        };
        self.rows.iter().map(object).collect()
    }

    /// The columns with a title, aligned and rounded, each unit on a line under the title; without the
    /// opening time where nothing has a valve.
    pub(crate) fn text(&self) -> String {
        let titled = |i: &usize| !self.titles[*i].is_empty();
        let shown: Vec<usize> = (0..self.columns.len()).filter(titled).collect();
        self.chosen(&shown)
    }

    /// As [`text`](Table::text), of the columns in `keys`, in that order.
    pub(crate) fn text_of(&self, keys: &str) -> String {
        let place = |key| self.columns.iter().position(|name| *name == key);
        let shown: Vec<usize> = keys.split_whitespace().filter_map(place).collect();
        self.chosen(&shown)
    }

    fn chosen(&self, columns: &[usize]) -> String {
        let is_empty = |i: usize| self.rows.iter().all(|row| row[i] == Cell::Empty);
        let is_shown = |i: &&usize| !(self.columns[**i] == "valve_open_s" && is_empty(**i));
        let columns: Vec<usize> = columns.iter().filter(is_shown).copied().collect();
        // A title may name another unit than the key.
        let head = |i: &usize| {
            let (title, key) = (self.titles[*i], self.columns[*i]);
            title.split_once('|').unwrap_or((title, unit(key)))
        };
        let mut lines: Vec<Vec<String>> = vec![
            columns.iter().map(|i| head(i).0.to_owned()).collect(),
            columns.iter().map(|i| head(i).1.to_owned()).collect(),
        ];
        let cell = |row: &Vec<Cell>, i: usize| row[i].text(unit(self.columns[i]));
        let line = |row: &Vec<Cell>| columns.iter().map(|&i| cell(row, i)).collect();
        lines.extend(self.rows.iter().map(line));
        aligned(&lines, |_| false)
    }
}

/// The words between the bars of `line`.
pub(crate) fn cells(line: &str) -> Vec<String> {
    line.split('|').map(str::to_owned).collect()
}

/// Lines with their cells under each other: the first `left` columns and the last begin in line,
/// the others end in line.
pub(crate) fn grid(lines: &[Vec<String>], left: usize) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    aligned(lines, |i| i < left || i + 1 == columns)
}

/// Lines with their cells under each other, those of the columns `is_left` beginning in line.
fn aligned(lines: &[Vec<String>], is_left: impl Fn(usize) -> bool) -> String {
    let width = |i: usize| {
        let cells = lines.iter().filter_map(|line| line.get(i));
        cells.map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let mut text = String::new();
    for line in lines {
        for (i, cell) in line.iter().enumerate() {
            let width = width(i);
            // Writing to a string does not fail.
            let _ = if is_left(i) {
                write!(text, "  {cell:<width$}")
            } else {
                write!(text, "  {cell:>width$}")
            };
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let columns: [Column<(f64, &'static str, f64)>; 3] = columns! {
            "rate_rad_s", "ω", |(rate, ..)| *rate;
            "outcome", "", |(_, outcome, _)| *outcome;
            "apex_m", "apex", |(.., apex)| *apex;
        };
        Table::of(&columns, [(0.1, "stroke", 0.5), (5.0, "stall", f64::NAN)])
    }

    #[test]
    fn one_table_in_three_formats() {
        assert_eq!(
            table().csv(),
            "rate_rad_s,outcome,apex_m\n0.10000000000000001,stroke,0.5\n5,stall,\n"
        );
        assert_eq!(
            Value::from(table().json()),
            json!([
                { "rate_rad_s": 0.1, "outcome": "stroke", "apex_m": 0.5 },
                { "rate_rad_s": 5.0, "outcome": "stall", "apex_m": null },
            ])
        );
        assert_eq!(
            table().text(),
            "      ω  apex\n  rad/s     m\n    0.1   0.5\n      5     –\n"
        );
    }
}
