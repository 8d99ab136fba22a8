//! Launches from a CSV file.

use std::path::Path;

use saltus::{Launch, Robot};

use crate::cli::terms::VALVE_OPEN;
use crate::cli::verify::check_robot;
use crate::columns::{self, Column, Need};
use crate::error::CliError;
use crate::input;
use crate::output::message;
use crate::quantity::Quantity;

/// Greatest size of a file (MiB): some millions of rows.
const LIMIT_MIB: u64 = 256;

/// The columns that are read, and what they hold.
const COLUMNS: [Column; 4] = [
    Column::new("omega0_rad_s", Quantity::RATE, Need::Value).or(&["omega_rad_s"]),
    Column::new("phi0_rad", Quantity::ANGLE, Need::Column).or(&["start_lean_rad"]),
    Column::new("alpha_f_rad", Quantity::ANGLE, Need::Column),
    Column::new("valve_open_s", Quantity::TIME, Need::Column),
];

/// The launches in the file at `path`, each with its line.
pub(super) fn load(path: &Path, robot: &Robot) -> Result<Vec<(u64, Launch)>, CliError> {
    let (source, file) = (input::bytes(path, LIMIT_MIB)?, path.display().to_string());
    // Whoever flies a table on another robot may mean it.
    if let Err(error) = check_robot(&source, &file, robot) {
        message(&format!("note: {error}"));
    }
    read(&source, &file)
}

/// The launches that `source` holds; messages call it `file`.
fn read(source: &[u8], file: &str) -> Result<Vec<(u64, Launch)>, CliError> {
    let rows = columns::read(source, file, &COLUMNS)?;
    if rows.is_empty() {
        return Err(CliError::content(
            file,
            "no rows: at least one jump is needed below the header",
        ));
    }
    let launches: Vec<_> = rows
        .iter()
        .map(|(line, row)| launch(file, *line, row))
        .collect::<Result<_, _>>()?;
    let launches: Vec<(u64, Launch)> = launches.into_iter().flatten().collect();
    if launches.is_empty() {
        return Err(CliError::content(file, "no row with a firing angle"));
    }
    Ok(launches)
}

/// The launch of a row; none for a row of a table that is out of reach, which has neither a firing
/// angle nor a start lean.
fn launch(
    file: &str,
    line: u64,
    row: &[Option<f64>; 4],
) -> Result<Option<(u64, Launch)>, CliError> {
    let empty = |column: &Column| CliError::Value {
        file: file.into(),
        line,
        key: column.name.into(),
        value: String::new(),
        allowed: column.quantity.allowed.into(),
    };
    let [Some(rate), lean, angle, valve_open] = *row else {
        return Err(empty(&COLUMNS[0]));
    };
    if lean.is_none() && angle.is_none() {
        return Ok(None);
    }
    let lean = lean.ok_or_else(|| empty(&COLUMNS[1]))?;
    let firing_angle = angle.ok_or_else(|| empty(&COLUMNS[2]))?;
    // A table of a leg without a valve leaves its time out.
    let valve_open = valve_open.unwrap_or(VALVE_OPEN);
    Ok(Some((
        line,
        Launch {
            rate,
            lean,
            firing_angle,
            valve_open,
        },
    )))
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
            parse("note,valve_open_s,alpha_f_rad,phi0_rad,omega0_rad_s\r\nx, 0.1 ,-0.1,-0.2,5\r\n")
                .unwrap();
        let launch = Launch {
            rate: 5.0,
            lean: -0.2,
            firing_angle: -0.1,
            valve_open: 0.1,
        };
        assert_eq!(launches, [(2, launch)]);
        assert_eq!(
            parse(&format!("\u{feff}{HEADER}\n5,0,0,0.1"))
                .unwrap()
                .len(),
            1
        );
        // As `saltus table` writes them: one out of reach, one of a leg without a valve.
        let table = "omega_rad_s,distance_m,alpha_f_rad,valve_open_s,start_lean_rad\n5,9,,0.1,\n5,1,-0.1,,-0.2\n";
        assert_eq!(parse(table).unwrap(), [(3, launch)]);
    }

    #[test]
    fn wrong_files_are_refused_with_their_place() {
        let check = |text: &str, message: &str| {
            let error = parse(text).unwrap_err();
            assert!(error.contains(message), "{text:?}: {error}");
        };
        check(
            "",
            "a.csv:1: no column omega0_rad_s: the header must name omega0_rad_s, phi0_rad, \
             alpha_f_rad, valve_open_s",
        );
        check(
            "omega0_rad_s,phi0_rad,alpha_f_rad\n",
            "no column valve_open_s",
        );
        check(
            &format!("{HEADER},phi0_rad\n"),
            "a.csv:1: column phi0_rad is there twice",
        );
        check(HEADER, "a.csv: no rows");
        check(
            &format!("{HEADER}\n5,0,,0.1\n"),
            "a.csv:2: alpha_f_rad = : must be an angle",
        );
        check(
            &format!("{HEADER}\n5,,,0.1\n"),
            "a.csv: no row with a firing angle",
        );
        check(
            &format!("{HEADER}\n5,0,0,0.1\n5,0\n"),
            "a.csv:3: 2 fields where the header has 4",
        );
        check(
            &format!("{HEADER}\n5,0,0,nan\n"),
            "a.csv:2: valve_open_s = nan: must be a time from 0 to 1000 s",
        );
        check(
            &format!("{HEADER}\n,0,0,0.1\n"),
            "a.csv:2: omega0_rad_s = : must be a number from 0 to 1000 rad/s",
        );
        check(
            &format!("{HEADER}\n5,2,0,0.1\n"),
            "a.csv:2: phi0_rad = 2: must be an angle strictly between",
        );
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
