//! `saltus table`: firing angles over approach rates.

use clap::Args;
use saltus::on_plant::{Confirmed, OnPlant, for_table};
use saltus::planner::{self, Corrected, Measure, Nearest, Roots, Sensitivity, TableRequest};
use saltus::{Planner, Robot};
use serde_json::json;

use super::Status;
use super::common::{Common, PlantFlags};
use super::proof::Proof;
use super::target::{Kind, TargetFlags};
use super::terms::Terms;
use crate::error::CliError;
use crate::output::{self, Column, Format, Table as Rows, columns, digits};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{INK, shade};
use crate::plot::sheet::{Label, Panel, Sheet, Side};
use crate::plot::span;
use crate::progress::Progress;

/// Tabulate the firing angles that reach distances or clearances, over approach rates
#[derive(Args, Debug)]
#[command(after_help = "`saltus table --help` explains the output.", after_long_help = LONG_HELP)]
pub(crate) struct Table {
    #[command(flatten)]
    target: TargetFlags,

    #[command(flatten)]
    plant: PlantFlags,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus table --omega 3:6:61 --distance 0.6
  saltus table --omega 3:6:61 --distance 0.3:1.0:36 --out table.csv
  saltus table --omega 5 --distance 0.8 --landing-height 0 --start-lean -0.5
  saltus table --omega 3:6:31 --distance 0.6 --plant rats-boom
  saltus table --omega 4:6:5 --clearance 2cm --obstacle 0.4,0.05,0.1 --plot angles.svg

With --plant the answers hold on that robot, with its boom, the masses of its legs and its ground: the \
multi-body simulation corrects the planar model, and flies every angle. A line of the report (JSON: \
\"correction\": {\"simulated_jumps\", \"is_exact\", \"confirmed\", \"dropped\", \"miss_greatest_m\"}) says how many jumps that took, and by how much the angles miss; an angle that misses by \
more than 1 mm is left out. apex_m, land_m and t_liftoff_s are then the simulation's, and the columns \
plant and plant_sha256 follow.

Values: a number, start:stop:count (both ends included), or several of these with commas.
Suffixes: rad/s, deg/s; rad, deg; s, ms; m, cm, mm.

CSV columns, one row for each approach rate and target, targets within rates: omega_rad_s, distance_m (or \
clearance_m; as asked for), alpha_f_rad (the least angle that serves), apex_m, land_m (distance at which the \
centre comes down to the landing height), t_liftoff_s (from the start of the stance), status (feasible; \
infeasible: other values are reached; no-landing: the robot takes off but never comes down to the landing \
height; no-jump: no angle takes off), alpha_f_late_rad (the next angle that serves, if there \
is one), distance_sd_m and apex_sd_m (standard deviations from the robot's [errors]), their sensitivities \
distance_by_omega_m_s_per_rad, distance_by_alpha_f_m_per_rad, distance_by_valve_open_m_per_s, \
distance_by_supply_m_per_pa and apex_by_… (for distances only), nearest_distance_m (or \
nearest_clearance_m) and nearest_alpha_f_rad (where infeasible: the nearest that is reached; a negative \
clearance is a hit, or a landing before the obstacle's end); and in every row what the table was made for: valve_open_s (empty: a leg without a valve), start_lean_rad (the firing \
angle, unless --start-lean is given), landing_height_m, robot, robot_sha256, saltus_version. `saltus verify` and `saltus simulate --batch` read them. Numbers have 17 significant digits; a cell is empty where there is no such thing.

JSON: {\"command\": \"table\", \"robot\": NAME, \"robot_sha256\", \"saltus_version\", \"landing_height_m\", \"start_lean_rad\" (or \"firing\"), \"valve_open_s\", \"measure\": \"distance\" or \"clearance\", \
\"rows\": [{the columns, null where empty}]}.

The exit code is 1 unless every row is feasible.";

/// A cell of the table, the height (m) at which its jumps land, and the robot.
type Row<'a> = (&'a planner::Cell, f64, &'a Robot);

/// The columns of a kind of target.
fn columns<'a>(kind: Kind) -> Vec<Column<Row<'a>>> {
    let [target, nearest] = match kind {
        Kind::Distance => ["distance_m", "nearest_distance_m"],
        Kind::Clearance => ["clearance_m", "nearest_clearance_m"],
    };
    let first: [Column<Row<'a>>; 8] = columns! {
        "omega_rad_s", "ω", |(cell, ..)| cell.rate;
        target, kind.name(), |(cell, ..)| cell.target;
        "alpha_f_rad", "α_f early", |(cell, ..)| angle(cell, 0);
        "apex_m", "apex", |(cell, ..)| cell.entries.first().and_then(|it| it.jump.apex());
        "land_m", "landing", |(cell, height, _)| cell.entries.first().and_then(|it| it.jump.distance(*height));
        "t_liftoff_s", "", |(cell, ..)| cell.entries.first().map(|it| it.jump.stance.time);
        "status", "status", |(cell, ..)| status(cell);
        "alpha_f_late_rad", "α_f late", |(cell, ..)| angle(cell, 1);
    };
    let spread: [Column<Row<'a>>; 10] = columns! {
        "distance_sd_m", "distance ±1σ", |row| deviation(row, 0);
        "apex_sd_m", "apex ±1σ", |row| deviation(row, 1);
        "distance_by_omega_m_s_per_rad", "", |row| slope(row, 0, |by| by.by_rate);
        "distance_by_alpha_f_m_per_rad", "", |row| slope(row, 0, |by| by.by_firing_angle);
        "distance_by_valve_open_m_per_s", "", |row| by_valve(row, 0);
        "distance_by_supply_m_per_pa", "", |row| slope(row, 0, |by| by.by_supply);
        "apex_by_omega_m_s_per_rad", "", |row| slope(row, 1, |by| by.by_rate);
        "apex_by_alpha_f_m_per_rad", "", |row| slope(row, 1, |by| by.by_firing_angle);
        "apex_by_valve_open_m_per_s", "", |row| by_valve(row, 1);
        "apex_by_supply_m_per_pa", "", |row| slope(row, 1, |by| by.by_supply);
    };
    let last: [Column<Row<'a>>; 2] = columns! {
        nearest, "nearest reached", |(cell, ..)| cell.nearest.map(|near| near.value);
        "nearest_alpha_f_rad", "with α_f", |(cell, ..)| cell.nearest.map(|near| near.firing_angle);
    };
    let spread = spread.into_iter().filter(|_| kind == Kind::Distance);
    first.into_iter().chain(spread).chain(last).collect()
}

/// The firing angle `k` of a cell (rad).
fn angle(cell: &planner::Cell, k: usize) -> Option<f64> {
    cell.entries
        .get(k)
        .map(|entry| entry.jump.launch.firing_angle)
}

/// The sensitivity of the distance or of the apex of the first jump.
fn sensitivity((cell, ..): &Row<'_>, k: usize) -> Option<Sensitivity> {
    Some(cell.entries.first()?.sensitivity?[k])
}

fn slope(row: &Row<'_>, k: usize, by: fn(&Sensitivity) -> f64) -> Option<f64> {
    sensitivity(row, k).as_ref().map(by)
}

/// None of a leg without a valve.
fn by_valve(row: &Row<'_>, k: usize) -> Option<f64> {
    slope(row, k, |by| by.by_valve_open).filter(|_| row.2.leg.drive.has_valve())
}

/// By the robot's errors; a robot file that states none has no bands.
fn deviation(row: &Row<'_>, k: usize) -> Option<f64> {
    let deviation = sensitivity(row, k)?.standard_deviation(&row.2.errors);
    Some(deviation).filter(|d| *d > 0.0)
}

/// What is tabulated.
type Cells = planner::Table;

/// Rates for each thread to compute before progress is shown.
const BLOCK: usize = 64;

impl Table {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        let (robot, plant) = self.plant.on_plant(&self.common.robot)?;
        let request = self.target.request(Roots::All, &robot)?;
        let (planner, correction) = for_table(robot, plant.as_ref(), &request)?;
        let mut table = compute(&planner, &request)?;
        let proof = plant.as_ref().zip(correction).map(|(plant, correction)| {
            let confirmed = confirm(plant, &request, &mut table);
            Proof::new(plant, correction, confirmed)
        });
        let terms = self.target.terms(planner.robot());
        let terms = terms.on(plant.as_ref().map(OnPlant::robot));
        let rows = self.rows(&table, &terms, planner.robot());
        let report = match self.common.format() {
            Format::Csv => rows.csv(),
            Format::Json => self.json(&rows, &terms, proof.as_ref()),
            Format::Text => self.text(&rows, &terms, proof.as_ref(), planner.robot()),
        };
        let drawing = || self.curves(&table, &request, &terms, planner.robot());
        self.common.write(report, drawing)?;
        let all_feasible = table.cells.iter().all(|cell| !cell.entries.is_empty());
        Ok(Status::of(all_feasible))
    }

    fn rows(&self, table: &Cells, terms: &Terms, robot: &Robot) -> Rows {
        let cells = table.cells.iter();
        let rows = cells
            .clone()
            .map(|cell| (cell, terms.landing_height, robot));
        let rows = Rows::of(&columns(self.target.kind()), rows);
        terms.told(rows, cells.map(|cell| angle(cell, 0)))
    }

    fn json(&self, rows: &Rows, terms: &Terms, proof: Option<&Proof>) -> String {
        let mut document = terms.json("table");
        if let Some(proof) = proof {
            document.insert("correction".into(), proof.json());
        }
        document.insert("measure".into(), json!(self.target.kind().name()));
        document.insert("rows".into(), json!(rows.json()));
        output::json(&document.into())
    }

    fn text(&self, rows: &Rows, terms: &Terms, proof: Option<&Proof>, robot: &Robot) -> String {
        let kind = self.target.kind();
        let columns = match kind {
            Kind::Distance => {
                "omega_rad_s distance_m alpha_f_rad alpha_f_late_rad distance_sd_m apex_m apex_sd_m status \
                 nearest_distance_m nearest_alpha_f_rad"
            }
            Kind::Clearance => {
                "omega_rad_s clearance_m alpha_f_rad alpha_f_late_rad apex_m land_m status \
                 nearest_clearance_m nearest_alpha_f_rad"
            }
        };
        let head = format!("{}: firing angles α_f for a {}", robot.name, kind.name());
        format!(
            "{head}\n  {}\n{}  {BRANCHES}\n{}",
            terms.line(),
            proof.map_or_else(String::new, Proof::line),
            rows.text_of(columns)
        )
    }

    fn curves(
        &self,
        table: &Cells,
        request: &TableRequest,
        terms: &Terms,
        robot: &Robot,
    ) -> Result<Sheet, CliError> {
        const MOST: usize = 40;
        let width = request.targets.len();
        if width > MOST {
            let allowed = format!("used with {MOST} targets at most, not {width}");
            return Err(CliError::flag("--plot", "", allowed));
        }
        let kind = self.target.kind().name();
        let (mut lines, mut labels) = (Vec::new(), Vec::new());
        for (i, target) in request.targets.iter().enumerate() {
            let color = shade(i, width);
            let cells: Vec<&planner::Cell> = table.cells.iter().skip(i).step_by(width).collect();
            let points = |cells: &[&planner::Cell], k: usize| -> Vec<(f64, f64)> {
                let points = cells
                    .iter()
                    .filter_map(|cell| Some((cell.rate, angle(cell, k)?)));
                points.collect()
            };
            for (k, mark) in [(1, Mark::Stroke(1)), (0, Mark::Stroke(3))] {
                // Where no angle serves, a curve is interrupted.
                let runs = cells.split(|cell| angle(cell, k).is_none());
                lines.extend(runs.map(|run| Line::new(mark, color, points(run, k))));
            }
            let early = points(&cells, 0);
            labels.extend(early.last().map(|end| Label {
                words: format!("{} m", digits(*target, 4)),
                places: vec![*end],
                side: Side::Right,
                color,
            }));
            if cells.len() <= 30 {
                lines.push(Line::new(Mark::Disc(3), color, early));
            }
        }
        let is_empty = lines.iter().all(|line| line.points.is_empty());
        if table.cells.iter().any(|cell| angle(cell, 1).is_some()) {
            lines.push(Line::note(
                "thick: the early angle, thin: the late one",
                INK,
            ));
        }
        let what = match request.measure {
            Measure::Distance { .. } => format!("{kind}, {}", terms.landing_title()),
            Measure::Clearance { .. } => format!("{kind} over the obstacle"),
        };
        // Room for the labels on the right.
        let (first, last) = span(request.rates.iter().copied());
        let room = [first, last + 0.1 * (last - first)];
        let panel = Panel {
            x: "approach rate ω (rad/s)",
            y: "firing angle α_f (rad)",
            lines,
            labels,
            least: Some([room, [f64::NAN; 2]]),
            empty: if is_empty {
                nothing(table, kind)
            } else {
                String::new()
            },
            ..Panel::default()
        };
        Ok(Sheet {
            title: format!("{}: firing angle for a {what}", robot.name),
            wide: vec![panel],
            ..Sheet::default()
        })
    }
}

/// The table, some rates after the others, so that one sees how far it is.
fn compute(planner: &Planner<Corrected>, request: &TableRequest) -> Result<Cells, CliError> {
    let progress = Progress::new("approach rates", request.rates.len());
    let mut part = request.clone();
    let mut cells = Vec::with_capacity(request.rates.len() * request.targets.len());
    for rates in request.rates.chunks(BLOCK * request.threads) {
        part.rates = rates.to_vec();
        cells.extend(planner.table(&part)?.cells);
        progress.advance(rates.len());
    }
    Ok(planner::Table { cells })
}

/// Flies every angle of the table, and shows how far it is.
fn confirm(plant: &OnPlant, request: &TableRequest, table: &mut Cells) -> Confirmed {
    let progress = Progress::new("jumps of the plant", table.cells.len());
    let mut all = Confirmed::default();
    for cells in table.cells.chunks_mut(BLOCK * request.threads) {
        all = all.and(plant.confirm(request, cells));
        progress.advance(cells.len());
    }
    all
}

/// What the columns of the text mean.
const BRANCHES: &str = "α_f early, α_f late: the angles that serve; the early one jumps higher. \
    ±1σ: standard deviation, by the robot's [errors].";

/// How a cell ends.
fn status(cell: &planner::Cell) -> &'static str {
    match (cell.entries.first(), &cell.nearest) {
        (Some(_), _) => "feasible",
        (None, Some(_)) => "infeasible",
        (None, None) if cell.takes_off => "no-landing",
        (None, None) => "no-jump",
    }
}

/// Why a table has no angle at all, for a plot of it.
fn nothing(table: &Cells, kind: &str) -> String {
    let nearest = table
        .cells
        .iter()
        .filter_map(|cell| cell.nearest.map(|n| (cell, n)));
    let gap = |cell: &planner::Cell, n: &Nearest| (n.value - cell.target).abs();
    match nearest.min_by(|a, b| gap(a.0, &a.1).total_cmp(&gap(b.0, &b.1))) {
        Some((cell, nearest)) => format!(
            "No angle reaches any {kind} asked for; the nearest is {} m at {} rad/s",
            digits(nearest.value, 4),
            digits(cell.rate, 4)
        ),
        None if table.cells.iter().any(|cell| cell.takes_off) => {
            "The robot takes off, but never comes down to the landing height".into()
        }
        None => "No angle takes off".into(),
    }
}
