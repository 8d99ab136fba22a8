//! Rows of named columns, which is what every format prints.

use std::fmt::Write;

use serde_json::{Map, Value, json};

use super::number::{digits, full};

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

impl From<Option<f64>> for Cell {
    fn from(x: Option<f64>) -> Cell {
        x.map_or(Cell::Empty, Cell::from)
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

    fn text(&self) -> String {
        match self {
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

/// Rows under a header.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table without rows; the names of the columns end with their units.
    pub(crate) fn new(columns: &[&'static str]) -> Table {
        Table {
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    /// Adds a row with one cell for each column.
    pub(crate) fn push(&mut self, row: Vec<Cell>) {
        debug_assert_eq!(row.len(), self.columns.len());
        self.rows.push(row);
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

    /// The named columns, aligned and rounded, each unit on a line under the name.
    pub(crate) fn text(&self, columns: &[(&str, &str, &str)]) -> String {
        let chosen: Vec<usize> = columns
            .iter()
            .filter_map(|(key, ..)| self.columns.iter().position(|name| name == key))
            .collect();
        let mut lines: Vec<Vec<String>> = vec![
            columns
                .iter()
                .map(|(_, title, _)| (*title).to_owned())
                .collect(),
            columns
                .iter()
                .map(|(.., unit)| (*unit).to_owned())
                .collect(),
        ];
        lines.extend(
            self.rows
                .iter()
                .map(|row| chosen.iter().map(|&i| row[i].text()).collect()),
        );
        aligned(&lines)
    }
}

/// Lines with their cells right-aligned under each other.
fn aligned(lines: &[Vec<String>]) -> String {
    let width = |i: usize| {
        lines
            .iter()
            .map(|line| line[i].chars().count())
            .max()
            .unwrap_or_default()
    };
    let widths: Vec<usize> = (0..lines.first().map_or(0, Vec::len)).map(width).collect();
    let mut text = String::new();
    for line in lines {
        for (cell, width) in line.iter().zip(&widths) {
            // Writing to a string does not fail.
            let _ = write!(text, "  {cell:>width$}");
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
        let mut table = Table::new(&["rate_rad_s", "outcome", "apex_m"]);
        table.push(vec![0.1.into(), Cell::Word("stroke"), 0.5.into()]);
        table.push(vec![5.0.into(), Cell::Word("stall"), f64::NAN.into()]);
        table
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
            table().text(&[("rate_rad_s", "ω", "rad/s"), ("apex_m", "apex", "m")]),
            "      ω  apex\n  rad/s     m\n    0.1   0.5\n      5     –\n"
        );
    }
}
