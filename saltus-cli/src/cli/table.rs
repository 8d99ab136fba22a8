//! `saltus table`: firing angles over approach rates.

use clap::Args;
use saltus::on_plant::{Confirmed, OnPlant, for_table};
use saltus::planner::{self, Corrected, Entry, Measure, Nearest, Roots, Sensitivity, TableRequest};
use saltus::{Planner, Robot};
use serde_json::json;

use super::Status;
use super::common::{Common, PlantFlags, PlotOption};
use super::proof::Proof;
use super::target::{Kind, TargetFlags};
use super::terms::Terms;
use crate::error::CliError;
use crate::output::{self, Cell, Format, Table as Rows, digits};
use crate::plot::Drawing;
use crate::plot::curves::{Curve, Curves};
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
    plot: PlotOption,

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

/// Columns of a table of distances.
const DISTANCES: &[&str] = &[
    "omega_rad_s",
    "distance_m",
    "alpha_f_rad",
    "apex_m",
    "land_m",
    "t_liftoff_s",
    "status",
    "alpha_f_late_rad",
    "distance_sd_m",
    "apex_sd_m",
    "distance_by_omega_m_s_per_rad",
    "distance_by_alpha_f_m_per_rad",
    "distance_by_valve_open_m_per_s",
    "distance_by_supply_m_per_pa",
    "apex_by_omega_m_s_per_rad",
    "apex_by_alpha_f_m_per_rad",
    "apex_by_valve_open_m_per_s",
    "apex_by_supply_m_per_pa",
    "nearest_distance_m",
    "nearest_alpha_f_rad",
];

/// Columns of a table of clearances.
const CLEARANCES: &[&str] = &[
    "omega_rad_s",
    "clearance_m",
    "alpha_f_rad",
    "apex_m",
    "land_m",
    "t_liftoff_s",
    "status",
    "alpha_f_late_rad",
    "nearest_clearance_m",
    "nearest_alpha_f_rad",
];

/// What is tabulated.
type Cells = planner::Table;

/// Rates for each thread to compute before progress is shown.
const BLOCK: usize = 64;

impl Table {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready(&self.plot)?;
        let (robot, plant) = self.plant.on_plant(self.common.robot_flags())?;
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
        self.common.write_with_plot(report, &self.plot, drawing)?;
        let all_feasible = table.cells.iter().all(|cell| !cell.entries.is_empty());
        Ok(if all_feasible {
            Status::Done
        } else {
            Status::No
        })
    }

    fn rows(&self, table: &Cells, terms: &Terms, robot: &Robot) -> Rows {
        let kind = self.target.kind();
        let columns = if kind == Kind::Distance {
            DISTANCES
        } else {
            CLEARANCES
        };
        let mut rows = Rows::new(&terms.columns(columns));
        for cell in &table.cells {
            rows.push(row(cell, kind, terms, robot));
        }
        rows
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
        let columns: &[(&str, &str, &str)] = match kind {
            Kind::Distance => &[
                ("omega_rad_s", "ω", "rad/s"),
                ("distance_m", "distance", "m"),
                ("alpha_f_rad", "α_f early", "rad"),
                ("alpha_f_late_rad", "α_f late", "rad"),
                ("distance_sd_m", "distance ±1σ", "m"),
                ("apex_m", "apex", "m"),
                ("apex_sd_m", "apex ±1σ", "m"),
                ("status", "status", ""),
                ("nearest_distance_m", "nearest reached", "m"),
                ("nearest_alpha_f_rad", "with α_f", "rad"),
            ],
            Kind::Clearance => &[
                ("omega_rad_s", "ω", "rad/s"),
                ("clearance_m", "clearance", "m"),
                ("alpha_f_rad", "α_f early", "rad"),
                ("alpha_f_late_rad", "α_f late", "rad"),
                ("apex_m", "apex", "m"),
                ("land_m", "landing", "m"),
                ("status", "status", ""),
                ("nearest_clearance_m", "nearest reached", "m"),
                ("nearest_alpha_f_rad", "with α_f", "rad"),
            ],
        };
        let head = format!("{}: firing angles α_f for a {}", robot.name, kind.name());
        format!(
            "{head}\n  {}\n{}  {BRANCHES}\n{}",
            terms.line(),
            proof.map_or_else(String::new, Proof::line),
            rows.text(columns)
        )
    }

    fn curves(
        &self,
        table: &Cells,
        request: &TableRequest,
        terms: &Terms,
        robot: &Robot,
    ) -> Result<Drawing, CliError> {
        const MOST: usize = 40;
        let width = request.targets.len();
        if width > MOST {
            let allowed = format!("used with {MOST} targets at most, not {width}");
            return Err(CliError::flag("--plot", "", allowed));
        }
        let kind = self.target.kind().name();
        let curve = |(i, target): (usize, &f64)| {
            let column = || table.cells.iter().skip(i).step_by(width);
            Curve {
                label: format!("{} m", digits(*target, 4)),
                points: column().map(|cell| point(cell, 0)).collect(),
                late: column().map(|cell| point(cell, 1)).collect(),
            }
        };
        let what = match request.measure {
            Measure::Distance { .. } => format!("{kind}, {}", terms.landing_title()),
            Measure::Clearance { .. } => format!("{kind} over the obstacle"),
        };
        Ok(Drawing::Curves(Curves {
            title: format!("{}: firing angle for a {what}", robot.name),
            x: "approach rate ω (rad/s)",
            y: "firing angle α_f (rad)",
            lines: request.targets.iter().enumerate().map(curve).collect(),
            late: "thick: the early angle, thin: the late one",
            empty: nothing(table, kind),
        }))
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

/// Rate and the firing angle `k` of a cell, none where there is none.
fn point(cell: &planner::Cell, k: usize) -> (f64, Option<f64>) {
    (
        cell.rate,
        cell.entries
            .get(k)
            .map(|entry| entry.jump.launch.firing_angle),
    )
}

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

fn row(cell: &planner::Cell, kind: Kind, terms: &Terms, robot: &Robot) -> Vec<Cell> {
    let first = cell.entries.first();
    let angle = |entry: &Entry| entry.jump.launch.firing_angle;
    let mut row = vec![
        cell.rate.into(),
        cell.target.into(),
        first.map(angle).into(),
    ];
    row.push(first.and_then(|entry| entry.jump.apex()).into());
    row.push(
        first
            .and_then(|entry| entry.jump.distance(terms.landing_height))
            .into(),
    );
    row.push(first.map(|entry| entry.jump.stance.time).into());
    row.extend([
        Cell::Word(status(cell)),
        cell.entries.get(1).map(angle).into(),
    ]);
    if kind == Kind::Distance {
        row.extend(sensitivities(
            first.and_then(|entry| entry.sensitivity),
            robot,
        ));
    }
    let nearest = |key: fn(&Nearest) -> f64| Cell::from(cell.nearest.as_ref().map(key));
    row.extend([nearest(|n| n.value), nearest(|n| n.firing_angle)]);
    row.extend(terms.cells(first.map(angle)));
    row
}

/// Standard deviations and sensitivities of distance and apex.
fn sensitivities(both: Option<[Sensitivity; 2]>, robot: &Robot) -> Vec<Cell> {
    let Some(both) = both else {
        return vec![Cell::Empty; 10];
    };
    // A robot file that states no errors has no bands.
    let deviations = both
        .iter()
        .map(|one| Some(one.standard_deviation(&robot.errors)).filter(|d| *d > 0.0));
    let has_valve = robot.leg.drive.has_valve();
    let slopes = both.iter().flat_map(|one| {
        let by_valve_open = has_valve.then_some(one.by_valve_open);
        [
            Some(one.by_rate),
            Some(one.by_firing_angle),
            by_valve_open,
            Some(one.by_supply),
        ]
    });
    deviations
        .map(Cell::from)
        .chain(slopes.map(Cell::from))
        .collect()
}
