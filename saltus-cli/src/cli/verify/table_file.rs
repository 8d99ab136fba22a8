//! A firing table in a CSV file, as `saltus table` writes it: what it says, what it was made for,
//! and whether its jumps land where it says.

use std::path::Path;

use saltus::on_plant::{for_launches, planar};
use saltus::planner::{Corrected, Planner};
use saltus::verify::{Plant, Steering, Subject};
use saltus::{Launch, Robot};

use super::subject::{self, Loaded, SubjectFlags, on_plant};
use crate::cli::terms::{LandingHeight, StartLean, Terms, VALVE_OPEN};
use crate::columns::{self, Column, Need};
use crate::error::CliError;
use crate::input;
use crate::output::digits;
use crate::quantity::Quantity;
use crate::range::Values;

/// Greatest size of a table (MiB).
const LIMIT_MIB: u64 = 64;

/// How far (m) the planner's jump may land from where a row says: what angles with four decimals
/// cost.
const REPLAY: f64 = 1e-3;

/// The columns that are read.
const COLUMNS: [Column; 7] = [
    Column::new("omega_rad_s", Quantity::RATE, Need::Value),
    Column::new("alpha_f_rad", Quantity::ANGLE, Need::Column),
    Column::new("distance_m", Quantity::DISTANCE, Need::Nothing),
    Column::new("land_m", Quantity::LANDING, Need::Nothing),
    Column::new("landing_height_m", Quantity::HEIGHT, Need::Column),
    Column::new("start_lean_rad", Quantity::ANGLE, Need::Column),
    Column::new("valve_open_s", Quantity::TIME, Need::Nothing),
];

/// A table that was read.
struct TableFile {
    file: String,
    /// Rows with a firing angle.
    rows: Vec<Row>,
    /// Distances (m) of all rows, ascending.
    distances: Vec<f64>,
    /// Whether it holds on a plant, which is then the robot that jumps.
    for_plant: bool,
}

/// A row with a firing angle.
struct Row {
    line: u64,
    rate: f64,
    angle: f64,
    distance: Option<f64>,
    land: Option<f64>,
    landing_height: Option<f64>,
    start_lean: Option<f64>,
    valve_open: Option<f64>,
}

/// The table at `path`, held against the flags and the planner.
pub(super) fn load(
    flags: &SubjectFlags,
    path: &Path,
    robot: Robot,
    plant: &Plant,
) -> Result<Loaded, CliError> {
    let table = TableFile::read(path, &robot, plant)?;
    let distance = table.distance(flags.distance)?;
    let points = table.points(distance)?;
    let rates = match &flags.omega {
        Some(rates) => within(rates, &points)?,
        None => points.iter().map(|(rate, _)| *rate).collect(),
    };
    let terms = table.terms(flags, &robot)?;
    let planner = table.planner(&terms, robot, plant)?;
    table.replay(&terms, &planner)?;
    let title = format!("the table {}, {}", table.file, terms.landing_title());
    let rule = subject::rule(flags, &terms, Steering::Table(points), rates, distance);
    Ok(Loaded {
        title,
        subject: Subject::Rule(rule),
        planner,
        for_plant: table.for_plant,
    })
}

impl Row {
    fn launch(&self, terms: &Terms) -> Launch {
        Launch {
            rate: self.rate,
            lean: terms.start_lean.unwrap_or(self.angle),
            firing_angle: self.angle,
            valve_open: terms.valve_open,
        }
    }
}

impl TableFile {
    fn read(path: &Path, robot: &Robot, plant: &Plant) -> Result<TableFile, CliError> {
        let file = path.display().to_string();
        let source = input::bytes(path, LIMIT_MIB)?;
        let cells = columns::read(&source, &file, &COLUMNS)?;
        check_robot(&source, &file, robot)?;
        let for_plant = check_plant(&source, &file, plant.robot())?;
        let row = |(line, cells): &(u64, [Option<f64>; 7])| {
            let [rate, angle, ..] = *cells;
            Some(Row {
                line: *line,
                rate: rate?,
                angle: angle?,
                distance: cells[2],
                land: cells[3],
                landing_height: cells[4],
                start_lean: cells[5],
                valve_open: cells[6],
            })
        };
        let rows: Vec<Row> = cells.iter().filter_map(row).collect();
        if rows.is_empty() {
            return Err(CliError::content(file, "no row with a firing angle"));
        }
        let mut distances: Vec<f64> = cells.iter().filter_map(|(_, row)| row[2]).collect();
        distances.sort_by(f64::total_cmp);
        distances.dedup();
        Ok(TableFile {
            file,
            rows,
            distances,
            for_plant,
        })
    }

    /// What the table was made for, which no flag says again.
    fn terms(&self, flags: &SubjectFlags, robot: &Robot) -> Result<Terms, CliError> {
        let given = [
            ("--landing-height", flags.terms.landing_height.is_some()),
            ("--start-lean", flags.terms.start_lean.is_some()),
            ("--valve-open", flags.terms.valve_open.is_some()),
        ];
        if let Some((flag, _)) = given.into_iter().find(|(_, is_given)| *is_given) {
            let allowed = format!("left out: {} says what it was made for", self.file);
            return Err(CliError::flag(flag, "", allowed));
        }
        let is_at_firing = |row: &Row| row.start_lean == Some(row.angle);
        let start = if self.rows.iter().all(is_at_firing) {
            StartLean::Firing
        } else {
            StartLean::At(self.value("start_lean_rad", |row| row.start_lean)?)
        };
        let height = self.value("landing_height_m", |row| row.landing_height)?;
        let valve = if robot.leg.drive.has_valve() {
            self.value("valve_open_s", |row| row.valve_open)?
        } else {
            VALVE_OPEN
        };
        Ok(Terms::new(robot, LandingHeight::At(height), valve, start))
    }

    /// The one value that all rows have in a column.
    fn value(&self, key: &'static str, of: fn(&Row) -> Option<f64>) -> Result<f64, CliError> {
        let first = of(&self.rows[0]);
        let is_other = |row: &&Row| of(row).is_none() || of(row) != first;
        match (first, self.rows.iter().find(is_other)) {
            (Some(value), None) => Ok(value),
            (_, other) => {
                let value = other.and_then(of).map_or(String::new(), |x| x.to_string());
                let row = other.unwrap_or(&self.rows[0]);
                let allowed = match first {
                    Some(first) => format!("{first}, as in line {}", self.rows[0].line),
                    None => "a number, which says what the table was made for".into(),
                };
                Err(self.wrong(row, key, value, allowed))
            }
        }
    }

    /// What says where the rows' jumps land.
    fn planner(
        &self,
        terms: &Terms,
        robot: Robot,
        plant: &Plant,
    ) -> Result<Planner<Corrected>, CliError> {
        if !self.for_plant {
            return Ok(planar(robot));
        }
        let launches: Vec<Launch> = self.rows.iter().map(|row| row.launch(terms)).collect();
        let on_plant = on_plant(&robot, plant)?;
        for_launches(robot, &on_plant, &launches, terms.landing_height)
            .map(|(planner, _)| planner)
            .map_err(|error| CliError::content(&self.file, error))
    }

    /// Flies each row with the planner: it has to land where the row says.
    fn replay(&self, terms: &Terms, planner: &Planner<Corrected>) -> Result<(), CliError> {
        for row in &self.rows {
            let landing = planner
                .jump(&row.launch(terms))
                .ok()
                .and_then(|jump| jump.distance(terms.landing_height));
            let said = [("land_m", row.land), ("distance_m", row.distance)];
            let wrong = said.into_iter().find_map(|(key, said)| {
                let said = said?;
                let lands_there = landing.is_some_and(|landing| (landing - said).abs() <= REPLAY);
                (!lands_there).then_some((key, said))
            });
            if let Some((key, said)) = wrong {
                let lands = landing.map_or("nowhere".into(), |x| format!("at {} m", digits(x, 6)));
                let allowed = format!(
                    "where the planner's jump of this row lands, which is {lands} ({}; {}; valve \
                     open {} s)",
                    planner.robot().name,
                    terms.line(),
                    terms.valve_open
                );
                return Err(self.wrong(row, key, said.to_string(), allowed));
            }
        }
        Ok(())
    }

    fn wrong(&self, row: &Row, key: &str, value: String, allowed: String) -> CliError {
        CliError::Value {
            file: self.file.clone(),
            line: row.line,
            key: key.into(),
            value,
            allowed,
        }
    }

    /// The distance (m) that is verified.
    fn distance(&self, wanted: Option<f64>) -> Result<Option<f64>, CliError> {
        let listed = || {
            self.distances
                .iter()
                .take(12)
                .map(|x| digits(*x, 9))
                .collect::<Vec<_>>()
                .join(", ")
        };
        match (wanted, self.distances.as_slice()) {
            (wanted, []) => Ok(wanted),
            (None, [only]) => Ok(Some(*only)),
            (None, _) => {
                let (count, listed) = (self.distances.len(), listed());
                let reason = format!(
                    "holds {count} distances (m): {listed}; --distance says which one to verify"
                );
                Err(CliError::content(&self.file, reason))
            }
            (Some(wanted), all) => {
                let found = all.iter().copied().find(|d| (d - wanted).abs() <= 1e-9);
                let allowed = || format!("one of those in {} (m): {}", self.file, listed());
                found
                    .map(Some)
                    .ok_or_else(|| CliError::flag("--distance", wanted, allowed()))
            }
        }
    }

    /// Rates and angles for `distance`, rates ascending.
    fn points(&self, distance: Option<f64>) -> Result<Vec<(f64, f64)>, CliError> {
        let mut points: Vec<(f64, f64)> = Vec::new();
        let here =
            |row: &&Row| distance.is_none() || row.distance.is_none() || row.distance == distance;
        for row in self.rows.iter().filter(here) {
            if points.last().is_some_and(|(before, _)| *before >= row.rate) {
                let allowed = "above the one before: rates ascend, with one row for each".into();
                return Err(self.wrong(row, "omega_rad_s", row.rate.to_string(), allowed));
            }
            points.push((row.rate, row.angle));
        }
        if points.is_empty() {
            return Err(CliError::content(
                &self.file,
                "no row of this distance has a firing angle",
            ));
        }
        Ok(points)
    }
}

/// That the table was made for the planner's robot, where it says for which.
pub(crate) fn check_robot(source: &[u8], file: &str, robot: &Robot) -> Result<(), CliError> {
    let Some((line, [name, hash])) = columns::words(source, file, ["robot", "robot_sha256"])?
    else {
        return Ok(());
    };
    let here = saltus::export::fingerprint(robot);
    if hash == here {
        return Ok(());
    }
    let remedy = if name == robot.name {
        "with other parameters: give the --robot and --set that it was made with".to_owned()
    } else {
        format!(
            "but the robot here is {}: give --robot {name}, or its file",
            robot.name
        )
    };
    let reason = format!("made for the robot {name} (SHA-256 {hash}), {remedy} (here {here})");
    Err(CliError::content(format!("{file}:{line}"), reason))
}

/// Whether the table holds on a plant, which has to be the robot that jumps.
fn check_plant(source: &[u8], file: &str, plant: &Robot) -> Result<bool, CliError> {
    let Some((line, [name, hash])) = columns::words(source, file, ["plant", "plant_sha256"])?
    else {
        return Ok(false);
    };
    if hash == saltus::export::fingerprint(plant) {
        return Ok(true);
    }
    let reason = format!(
        "made to hold on the robot {name} (SHA-256 {hash}), and the robot that jumps here is {}: \
         give the --plant and --plant-set that it was made with",
        plant.name
    );
    Err(CliError::content(format!("{file}:{line}"), reason))
}

/// The rates, none of which a table leaves out.
fn within(rates: &Values, points: &[(f64, f64)]) -> Result<Vec<f64>, CliError> {
    let (low, high) = (points[0].0, points[points.len() - 1].0);
    match rates.iter().find(|rate| !(low..=high).contains(*rate)) {
        Some(rate) => Err(CliError::flag(
            "--omega",
            rate,
            format!("within the table: from {low} to {high} rad/s"),
        )),
        None => Ok(rates.to_vec()),
    }
}
