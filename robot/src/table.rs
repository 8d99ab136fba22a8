//! Measured forces of a leg, from a CSV file or from lists in the robot file.
//!
//! The CSV file has the columns `extension_m`, `speed_m_s` and `force_n` in any order, one row for
//! each extension at each speed in any order, and comments on lines that begin with `#`.

use std::sync::Arc;

use crate::document::{Node, Value, cut};
use crate::files::Files;
use crate::section::Section;
use crate::units::Unit;
use crate::{ForceTable, Place, RobotError};

/// The columns of the CSV file.
const COLUMNS: [&str; 3] = ["extension_m", "speed_m_s", "force_n"];

/// The force table of the leg `s`, which must cover `stroke` (m): the CSV file under `file`, or the
/// lists under `table`.
pub(crate) fn force_table(s: &mut Section, stroke: f64, files: Files) -> ForceTable {
    let spellings = ["file", "table"];
    let table = match s.given(&spellings) {
        None => {
            s.missing(&spellings, "");
            None
        }
        Some(0) => {
            let file = s.text("file");
            s.attempt(|| csv_table(&file, stroke, files))
        }
        Some(_) => s.optional_table("table", |s| listed_table(s, stroke)),
    };
    table.unwrap_or_default()
}

/// The force table of the lists in `s`.
fn listed_table(mut s: Section, stroke: f64) -> Result<ForceTable, RobotError> {
    let mut axis = |key: &str, axis: Axis| {
        let read = |value: &Value| numbers(value).filter(|numbers| axis.admits(numbers));
        s.value(key, &axis.allowed, read).unwrap_or_default()
    };
    let extensions = axis("extensions_m", Axis::extensions(stroke));
    let speeds = axis("speeds_m_s", Axis::speeds());
    let (rows, columns) = (extensions.len(), speeds.len());
    let allowed = format!(
        "a list of {rows} lists, one for each extension, of {columns} finite numbers, one for \
         each speed"
    );
    let forces = s
        .value("forces_n", &allowed, |value| grid(value, rows, columns))
        .unwrap_or_default();
    s.finish(ForceTable {
        extensions,
        speeds,
        forces,
    })
}

/// What the extensions or the speeds of a table must be.
struct Axis {
    /// Least last value (SI).
    reach: f64,
    /// The same in words.
    allowed: String,
}

impl Axis {
    fn extensions(stroke: f64) -> Axis {
        let speeds = Axis::speeds();
        Axis {
            reach: stroke,
            allowed: format!("{} to at least {stroke} m, the stroke", speeds.allowed),
        }
    }

    fn speeds() -> Axis {
        Axis {
            reach: 0.0,
            allowed: "at least 2 finite numbers, strictly increasing from 0".into(),
        }
    }

    fn admits(&self, numbers: &[f64]) -> bool {
        match numbers {
            [first, .., last] => {
                *first == 0.0 && *last >= self.reach && numbers.is_sorted_by(|a, b| a < b)
            }
            _ => false,
        }
    }
}

/// The finite numbers of a list.
pub(crate) fn numbers(value: &Value) -> Option<Vec<f64>> {
    let Value::Array(items) = value else {
        return None;
    };
    items
        .iter()
        .map(|Node { value, .. }| number(value))
        .collect()
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(literal) => finite(literal),
        _ => None,
    }
}

fn finite(literal: &str) -> Option<f64> {
    Some(Unit::SI.si(literal)).filter(|number| number.is_finite())
}

/// The finite numbers of a list of `rows` lists of `columns`, row after row.
fn grid(value: &Value, rows: usize, columns: usize) -> Option<Vec<f64>> {
    let Value::Array(lists) = value else {
        return None;
    };
    let lists: Vec<Vec<f64>> = lists
        .iter()
        .map(|list| numbers(&list.value))
        .collect::<Option<_>>()?;
    (lists.len() == rows && lists.iter().all(|list| list.len() == columns)).then(|| lists.concat())
}

/// The force table in the CSV file `file`.
fn csv_table(file: &str, stroke: f64, files: Files) -> Result<ForceTable, RobotError> {
    let (name, text) = files.read(file)?;
    parse_csv(&text, &name.into(), stroke)
}

/// The force table in `text`, which messages call `file`.
fn parse_csv(text: &str, file: &Arc<str>, stroke: f64) -> Result<ForceTable, RobotError> {
    let table = full_grid(rows(text, file)?, file)?;
    let axes = [
        (&table.extensions, Axis::extensions(stroke)),
        (&table.speeds, Axis::speeds()),
    ];
    for ((numbers, axis), column) in axes.into_iter().zip(COLUMNS) {
        if !axis.admits(numbers) {
            return Err(RobotError::NotAllowed {
                place: Place::File {
                    file: file.clone(),
                    line: None,
                },
                key: column.into(),
                value: cut(&format!("{numbers:?}")),
                allowed: axis.allowed,
            });
        }
    }
    Ok(table)
}

/// A row of the CSV file.
struct Row {
    extension: f64,
    speed: f64,
    force: f64,
    line: u64,
}

/// The rows of the CSV file.
fn rows(text: &str, file: &Arc<str>) -> Result<Vec<Row>, RobotError> {
    let place = |line| Place::File {
        file: file.clone(),
        line,
    };
    let not_csv = |source: csv::Error| RobotError::NotCsv {
        place: place(None),
        source,
    };
    // Flexible, as a row of another length is told here, with its line.
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .trim(csv::Trim::All)
        .flexible(true)
        .from_reader(text.as_bytes());
    let header = reader.headers().map_err(not_csv)?.clone();
    let order = COLUMNS.map(|column| header.iter().position(|cell| cell == column));
    let ([Some(extension), Some(speed), Some(force)], 3) = (order, header.len()) else {
        let place = place(Some(line(text, &header)));
        return Err(RobotError::WrongColumns {
            place,
            found: joined(&header),
            allowed: COLUMNS.join(","),
        });
    };
    reader
        .into_records()
        .map(|record| {
            let record = record.map_err(not_csv)?;
            let line = line(text, &record);
            let refuse = |key: &str, value: String, allowed: &str| RobotError::NotAllowed {
                place: place(Some(line)),
                key: key.into(),
                value,
                allowed: allowed.into(),
            };
            if record.len() != header.len() {
                return Err(refuse("row", joined(&record), "3 cells"));
            }
            let cell = |at: usize| {
                finite(&record[at])
                    .ok_or_else(|| refuse(&header[at], cut(&record[at]), "a finite number"))
            };
            Ok(Row {
                extension: cell(extension)?,
                speed: cell(speed)?,
                force: cell(force)?,
                line,
            })
        })
        .collect()
}

fn joined(record: &csv::StringRecord) -> String {
    cut(&record.iter().collect::<Vec<_>>().join(","))
}

/// The line of `record` in `text`.
fn line(text: &str, record: &csv::StringRecord) -> u64 {
    let position = record
        .position()
        .expect("a record that was read has a position");
    // The position is where the reader began to skip empty lines and comments.
    let rest = usize::try_from(position.byte())
        .ok()
        .and_then(|byte| text.get(byte..))
        .unwrap_or_default();
    let skipped = rest
        .lines()
        .take_while(|line| line.is_empty() || line.starts_with('#'))
        .count();
    position.line() + skipped as u64
}

/// The table of `rows`, if they hold each point of a grid once.
fn full_grid(mut rows: Vec<Row>, file: &Arc<str>) -> Result<ForceTable, RobotError> {
    rows.sort_by(|a, b| {
        a.extension
            .total_cmp(&b.extension)
            .then(a.speed.total_cmp(&b.speed))
    });
    let mut extensions: Vec<f64> = rows.iter().map(|row| row.extension).collect();
    extensions.dedup();
    let mut speeds: Vec<f64> = rows.iter().map(|row| row.speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();

    for (row, next) in rows.iter().zip(rows.iter().skip(1)) {
        if (row.extension, row.speed) == (next.extension, next.speed) {
            let (first, second) = (row.line.min(next.line), row.line.max(next.line));
            let place = Place::File {
                file: file.clone(),
                line: Some(second),
            };
            return Err(RobotError::GridPointTwice {
                place,
                extension: row.extension,
                speed: row.speed,
                first,
            });
        }
    }
    let mut found = rows.iter();
    for &extension in &extensions {
        for &speed in &speeds {
            if found
                .next()
                .is_none_or(|row| (row.extension, row.speed) != (extension, speed))
            {
                let place = Place::File {
                    file: file.clone(),
                    line: None,
                };
                return Err(RobotError::GridPointMissing {
                    place,
                    extension,
                    speed,
                });
            }
        }
    }
    Ok(ForceTable {
        extensions,
        speeds,
        forces: rows.iter().map(|row| row.force).collect(),
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    use super::*;

    const SOUND: &str = include_str!("../robots/table-hopper-force.csv");
    const STROKE: f64 = 0.05;

    fn read(text: &str) -> Result<ForceTable, RobotError> {
        parse_csv(text, &"force.csv".into(), STROKE)
    }

    /// Reading `text` does not panic and gives nothing outside its domain.
    fn check(text: &str) -> Result<(), TestCaseError> {
        match read(text) {
            Ok(ForceTable {
                extensions,
                speeds,
                forces,
            }) => {
                prop_assert!(
                    Axis::extensions(STROKE).admits(&extensions),
                    "{:?}",
                    extensions
                );
                prop_assert!(Axis::speeds().admits(&speeds), "{:?}", speeds);
                prop_assert_eq!(forces.len(), extensions.len() * speeds.len());
                prop_assert!(
                    [extensions, speeds, forces]
                        .concat()
                        .iter()
                        .all(|x| x.is_finite())
                );
            }
            Err(error) => prop_assert!(error.to_string().starts_with("force.csv")),
        }
        Ok(())
    }

    #[test]
    fn a_thin_table_is_not_blown_up() {
        // Each row at an extension and a speed of its own: a full grid would have 10^10 points.
        let rows: Vec<String> = (0..100_000).map(|i| format!("{i},{i},1")).collect();
        let error = read(&format!(
            "extension_m,speed_m_s,force_n\n{}",
            rows.join("\n")
        ))
        .expect_err("points are missing");
        assert!(
            error
                .to_string()
                .starts_with("force.csv: extension 0 m, speed 1 m/s: must be given"),
            "{error}"
        );
    }

    proptest! {
        #![proptest_config(ProptestConfig {
            rng_seed: RngSeed::Fixed(1),
            failure_persistence: None,
            ..ProptestConfig::with_cases(512)
        })]

        #[test]
        fn arbitrary_text(text in any::<String>(), cells in "([0-9.eE+-]{0,4},[0-9]{0,2},[0-9a-z\"]{0,3}\r?\n){0,9}") {
            check(&text)?;
            check(&format!("extension_m,speed_m_s,force_n\n{text}"))?;
            check(&format!("extension_m,speed_m_s,force_n\n{cells}"))?;
        }

        #[test]
        fn mutations_of_a_sound_file(
            flips in prop::collection::vec((any::<usize>(), any::<u8>()), 0..4),
            end in 0..=SOUND.len(),
            row in 0..36_usize,
            cell in 0..3_usize,
            odd in prop::sample::select(&["nan", "inf", "-inf", "1e400", "-0", "1e308", "-1", "", "0x1", "1_0"][..]),
        ) {
            let mut bytes = SOUND.as_bytes().to_vec();
            for (at, byte) in flips {
                let at = at % bytes.len();
                bytes[at] = byte;
            }
            check(&String::from_utf8_lossy(&bytes))?;
            check(&String::from_utf8_lossy(&bytes[..end]))?;

            let mut lines: Vec<String> = SOUND.lines().map(Into::into).collect();
            let mut cells: Vec<&str> = lines[3 + row].split(',').collect();
            cells[cell] = odd;
            lines[3 + row] = cells.join(",");
            check(&lines.join("\n"))?;
        }
    }
}
