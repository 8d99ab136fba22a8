//! Launches from a CSV file.

use std::path::Path;

use csv::ByteRecord;
use saltus::Launch;

use crate::error::{CliError, cut};
use crate::input;
use crate::quantity::Quantity;

/// Greatest size of a file (MiB): some millions of rows.
const LIMIT_MIB: u64 = 256;

/// The columns that are read, and what they hold.
const COLUMNS: [(&str, Quantity); 4] = [
    ("omega0_rad_s", Quantity::RATE),
    ("phi0_rad", Quantity::ANGLE),
    ("alpha_f_rad", Quantity::ANGLE),
    ("valve_open_s", Quantity::TIME),
];

/// The launches in the file at `path`, each with its line.
pub(super) fn load(path: &Path) -> Result<Vec<(u64, Launch)>, CliError> {
    read(&input::bytes(path, LIMIT_MIB)?, &path.display().to_string())
}

/// The launches that `source` holds; messages call it `file`.
///
/// The first row names the columns. The four of a launch may stand anywhere; all others are ignored.
fn read(source: &[u8], file: &str) -> Result<Vec<(u64, Launch)>, CliError> {
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(source);
    let header = reader.byte_headers().map_err(|error| not_csv(&error, source, file))?;
    let places = places(header, file)?;
    let mut launches = Vec::new();
    let mut record = ByteRecord::new();
    while reader.read_byte_record(&mut record).map_err(|error| not_csv(&error, source, file))? {
        let line = record.position().map_or(0, |position| line(position, source));
        launches.push((line, launch(&record, places, file, line)?));
    }
    if launches.is_empty() {
        return Err(CliError::content(file, "no rows: at least one jump is needed below the header"));
    }
    Ok(launches)
}

/// The line of a record. Where lines end with CR LF, its position is still before the LF.
fn line(position: &csv::Position, source: &[u8]) -> u64 {
    let start = usize::try_from(position.byte()).unwrap_or(usize::MAX);
    let breaks = source.get(start..).unwrap_or_default().iter().take_while(|byte| byte.is_ascii_whitespace());
    position.line() + breaks.filter(|byte| **byte == b'\n').count() as u64
}

/// Where each of [`COLUMNS`] stands.
fn places(header: &ByteRecord, file: &str) -> Result<[usize; 4], CliError> {
    let place = |name: &str| {
        // A byte order mark is no part of the first name.
        let named = |cell: &[u8]| cell.strip_prefix(b"\xef\xbb\xbf").unwrap_or(cell) == name.as_bytes();
        let mut found = (0..header.len()).filter(|&i| named(&header[i]));
        match (found.next(), found.next()) {
            (Some(place), None) => Ok(place),
            (None, _) => Err(CliError::content(
                format!("{file}:1"),
                format!(
                    "no column {name}: the header must name {}",
                    COLUMNS.map(|(name, _)| name).join(", ")
                ),
            )),
            (Some(_), Some(_)) => {
                Err(CliError::content(format!("{file}:1"), format!("column {name} is there twice")))
            }
        }
    };
    let [rate, lean, angle, time] = COLUMNS.map(|(name, _)| place(name));
    Ok([rate?, lean?, angle?, time?])
}

fn launch(record: &ByteRecord, places: [usize; 4], file: &str, line: u64) -> Result<Launch, CliError> {
    let number = |i: usize| {
        let (key, quantity) = &COLUMNS[i];
        let text = String::from_utf8_lossy(record.get(places[i]).unwrap_or_default());
        quantity.parse(&text).map_err(|_| CliError::Value {
            file: file.into(),
            line,
            key: (*key).into(),
            value: cut(&text),
            allowed: quantity.allowed.into(),
        })
    };
    Ok(Launch { rate: number(0)?, lean: number(1)?, firing_angle: number(2)?, valve_open: number(3)? })
}

fn not_csv(error: &csv::Error, source: &[u8], file: &str) -> CliError {
    match error.kind() {
        csv::ErrorKind::UnequalLengths { pos, expected_len, len } => CliError::content(
            pos.as_ref().map_or(file.to_owned(), |pos| format!("{file}:{}", line(pos, source))),
            format!("{len} fields where the header has {expected_len}"),
        ),
        _ => CliError::content(file, error),
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const HEADER: &str = "omega0_rad_s,phi0_rad,alpha_f_rad,valve_open_s";

    fn parse(text: &str) -> Result<Vec<(u64, Launch)>, String> {
        read(text.as_bytes(), "a.csv").map_err(|error| error.to_string())
    }

    #[test]
    fn other_columns_are_ignored() {
        let launches =
            parse("note,valve_open_s,alpha_f_rad,phi0_rad,omega0_rad_s\r\nx, 0.1 ,-0.1,-0.2,5\r\n").unwrap();
        let launch = Launch { rate: 5.0, lean: -0.2, firing_angle: -0.1, valve_open: 0.1 };
        assert_eq!(launches, [(2, launch)]);
        assert_eq!(parse(&format!("\u{feff}{HEADER}\n5,0,0,0.1")).unwrap().len(), 1);
    }

    #[test]
    fn wrong_files_are_refused_with_their_place() {
        let check = |text: &str, message: &str| {
            let error = parse(text).unwrap_err();
            assert!(error.contains(message), "{text:?}: {error}");
        };
        check(
            "",
            "a.csv:1: no column omega0_rad_s: the header must name omega0_rad_s, phi0_rad, alpha_f_rad, valve_open_s",
        );
        check("omega0_rad_s,phi0_rad,alpha_f_rad\n", "no column valve_open_s");
        check(&format!("{HEADER},phi0_rad\n"), "a.csv:1: column phi0_rad is there twice");
        check(HEADER, "a.csv: no rows");
        check(&format!("{HEADER}\n5,0,0,0.1\n5,0\n"), "a.csv:3: 2 fields where the header has 4");
        check(
            &format!("{HEADER}\n5,0,0,nan\n"),
            "a.csv:2: valve_open_s = nan: must be a time from 0 to 1000 s",
        );
        check(
            &format!("{HEADER}\n,0,0,0.1\n"),
            "a.csv:2: omega0_rad_s = : must be a number from 0 to 1000 rad/s",
        );
        check(&format!("{HEADER}\n5,2,0,0.1\n"), "a.csv:2: phi0_rad = 2: must be an angle strictly between");
        check(
            &format!("{HEADER}\n5,0,{},0.1\n", "9".repeat(100)),
            &format!("alpha_f_rad = {}…", "9".repeat(40)),
        );
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = read(&bytes, "a.csv");
            let mut file = format!("{HEADER}\n").into_bytes();
            file.extend(bytes);
            for (_, launch) in read(&file, "a.csv").unwrap_or_default() {
                prop_assert!(launch.rate >= 0.0 && launch.lean.abs() < 1.6 && launch.valve_open.is_finite());
            }
        }

        #[test]
        fn near_misses_are_read_or_refused(text in r#"[-+.0-9eE, \r\n"nainf]{0,200}"#) {
            for (_, launch) in parse(&format!("{HEADER}\n{text}")).unwrap_or_default() {
                prop_assert!(launch.rate.is_finite() && launch.firing_angle.is_finite());
            }
        }

        #[test]
        fn launches_read_back(rate in 0.0..1e3, lean in -1.5..1.5, angle in -1.5..1.5, time in 0.0..1e3) {
            let text = format!("{HEADER}\n{rate},{lean},{angle},{time}\n");
            let launch = Launch { rate, lean, firing_angle: angle, valve_open: time };
            prop_assert_eq!(parse(&text).unwrap(), [(2, launch)]);
        }
    }
}
