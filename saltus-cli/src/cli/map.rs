//! `saltus map`: what is reachable over approach rate and firing angle.

use clap::Args;
use saltus::planner::{self, JumpModel, MapRequest, Spot, SpotResult};
use saltus::{Outcome, Planner, Robot};
use serde_json::json;

use super::Status;
use super::common::{Common, PlantFlags, Threads};
use super::terms::{TermFlags, Terms};
use crate::error::CliError;
use crate::output::{self, Cell, Column, Format, Table as Rows, columns, digits};
use crate::plot::map::{Map as Grid, counts};
use crate::plot::sheet::Sheet;
use crate::progress::Progress;
use crate::range::{Values, angles, rates};

/// Most launches of a map, and most that its plot shows.
const MOST: usize = 1_000_000;
const MOST_DRAWN: usize = 40_000;
/// Most launches that the text lists one by one.
const MOST_LISTED: usize = 60;

/// Map what is reachable: distance and apex over approach rates and firing angles
#[derive(Args, Debug)]
#[command(after_help = "`saltus map --help` explains the output.", after_long_help = LONG_HELP)]
pub(crate) struct Map {
    /// Approach rates ω (rad/s)
    #[arg(long, value_name = "RATES", value_parser = rates, allow_hyphen_values = true)]
    omega: Values,

    /// Firing angles α_f (rad)
    #[arg(long, value_name = "ANGLES", value_parser = angles, allow_hyphen_values = true)]
    alpha_f: Values,

    #[command(flatten)]
    terms: TermFlags,

    /// Give the friction that each stance needs too, which takes some ten times as long
    #[arg(long)]
    friction: bool,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    plant: PlantFlags,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus map --omega 2:7:51 --alpha-f -0.5:0.5:41 --plot map.png
  saltus map --omega 2:7:11 --alpha-f -0.5:0.5:11 --plant rats-boom
  saltus map --omega 2:7:51 --alpha-f -30deg:30deg:61 --friction --out map.csv

Values: a number, start:stop:count (both ends included), or several of these with commas.
Suffixes: rad/s, deg/s; rad, deg; s, ms; m, cm, mm.

With --plant the map is that robot's, in the multi-body simulation: some 2 ms a launch. not-computed is \
then also where a foot would start inside the ground.

CSV columns, one row for each approach rate and firing angle, angles within rates: omega_rad_s, \
alpha_f_rad, outcome (as for `saltus simulate`; no-landing where the robot takes off but never comes down to the landing \
height; not-computed where the model cannot be integrated), \
distance_m (where the centre comes down to the landing height), apex_m, friction_needed (the coefficient \
that keeps the foot still; empty without --friction, and inf where the ground would have to pull). \
Numbers have 17 significant digits; a cell is empty where there is no such thing.

JSON: {\"command\": \"map\", \"robot\": NAME, \"robot_sha256\", \"saltus_version\", \"landing_height_m\", \"start_lean_rad\" (or \"firing\"), \"valve_open_s\", \"spots\": [{the columns, null \
where empty}]}; a friction that is infinite is the text \"inf\".

The exit code is 1 if none of the launches lands.";

fn columns<'a>() -> [Column<&'a Spot>; 6] {
    columns! {
        "omega_rad_s", "ω", |spot| spot.launch.rate;
        "alpha_f_rad", "α_f", |spot| spot.launch.firing_angle;
        "outcome", "outcome", |spot| outcome(spot);
        "distance_m", "distance", |spot| number(spot, |result| result.distance);
        "apex_m", "apex", |spot| number(spot, |result| result.apex);
        "friction_needed", "friction|needed", |spot| {
            match number(spot, |result| result.friction_needed) {
                Some(f64::INFINITY) => Cell::Word("inf"),
                needed => needed.into(),
            }
        };
    }
}

/// A number of a launch that was computed.
fn number(spot: &Spot, of: fn(&SpotResult) -> Option<f64>) -> Option<f64> {
    spot.result.as_ref().ok().and_then(of)
}

/// Launches for each thread to compute before progress is shown.
const BLOCK: usize = 4096;

impl Map {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        let count = self.omega.len().saturating_mul(self.alpha_f.len());
        if count > MOST {
            return Err(CliError::flag(
                "--omega, --alpha-f",
                "",
                format!("{MOST} combinations at most, not {count}"),
            ));
        }
        if self.common.plot.is_set() && count > MOST_DRAWN {
            let allowed = format!("used with {MOST_DRAWN} combinations at most, not {count}");
            return Err(CliError::flag("--plot", "", allowed));
        }
        let (robot, plant) = self.plant.on_plant(&self.common.robot)?;
        self.terms.note_valve(&robot);
        let map = match &plant {
            Some(plant) => {
                let height = self.terms.of(&robot).landing_height;
                self.compute(&Planner::by(plant.simulated().clone().down_to(height)))?
            }
            None => self.compute(&Planner::new(robot.clone()))?,
        };
        // What a map of the plant says is the plant's.
        let robot = plant.map_or(robot, |plant| plant.robot().clone());
        let rows = Rows::of(&columns(), map.spots.iter());
        let report = match self.common.format() {
            Format::Csv => rows.csv(),
            Format::Json => {
                let mut document = self.terms.of(&robot).json("map");
                document.insert("spots".into(), json!(rows.json()));
                output::json(&document.into())
            }
            Format::Text => self.text(&map, &rows, &robot),
        };
        let drawing = || Ok(self.drawing(&map, &robot));
        self.common.write(report, drawing)?;
        let lands = |spot: &Spot| number(spot, |result| result.distance).is_some();
        Ok(Status::of(map.spots.iter().any(lands)))
    }

    /// The map, some rates after the others, so that one sees how far it is.
    fn compute(&self, planner: &Planner<dyn JumpModel>) -> Result<planner::Map, CliError> {
        let rates = self.omega.to_vec();
        let progress = Progress::new("approach rates", rates.len());
        let threads = self.threads.count().get();
        let size = (BLOCK * threads).div_ceil(self.alpha_f.len()).max(threads);
        let mut spots = Vec::with_capacity(rates.len() * self.alpha_f.len());
        for rates in rates.chunks(size) {
            spots.extend(planner.map(&self.request(rates, planner.robot()))?.spots);
            progress.advance(rates.len());
        }
        Ok(planner::Map { spots })
    }

    fn request(&self, rates: &[f64], robot: &Robot) -> MapRequest {
        let Terms {
            landing_height,
            valve_open,
            start_lean,
            ..
        } = self.terms.of(robot);
        MapRequest {
            rates: rates.to_vec(),
            firing_angles: self.alpha_f.to_vec(),
            valve_open,
            start_lean,
            landing_height,
            friction: self.friction,
            threads: self.threads.count().get(),
        }
    }

    fn text(&self, map: &planner::Map, rows: &Rows, robot: &Robot) -> String {
        let count = map.spots.len();
        let terms = self.terms.of(robot).line();
        let head = format!("{}: {count} launches\n  {terms}", robot.name);
        let counts = counts(map.spots.iter().map(outcome)).into_iter();
        let mut lines: Vec<_> = counts.map(|(name, n)| (name, n.to_string())).collect();
        lines.push(("distance", extremes(map, |spot| spot.distance)));
        lines.push(("apex", extremes(map, |spot| spot.apex)));
        let text = output::lines(&head, 16, &lines);
        if count > MOST_LISTED {
            return text + "  each of them: --format csv, --format json or --plot\n";
        }
        text + &rows.text()
    }

    fn drawing(&self, map: &planner::Map, robot: &Robot) -> Sheet {
        let outcomes: Vec<&str> = map.spots.iter().map(outcome).collect();
        let grid = Grid {
            rates: &self.omega,
            angles: &self.alpha_f,
            outcomes: &outcomes,
        };
        let panel = |title: &str, key: fn(&SpotResult) -> Option<f64>| {
            let values: Vec<_> = map.spots.iter().map(|spot| number(spot, key)).collect();
            grid.panel(title, &values)
        };
        let landing = format!("distance (m), {}", self.terms.of(robot).landing_title());
        Sheet {
            title: format!("{}: what is reachable", robot.name),
            wide: vec![
                panel(&landing, |r| r.distance),
                panel("apex (m)", |r| r.apex),
            ],
            ..Sheet::default()
        }
    }
}

/// How the launch ends: its stance, and of a jump the landing.
fn outcome(spot: &Spot) -> &'static str {
    match &spot.result {
        Ok(result) if result.outcome.is_jump() && result.distance.is_none() => "no-landing",
        Ok(result) => Outcome::name(result.outcome),
        Err(_) => "not-computed",
    }
}

/// Least and greatest value, and where they are.
fn extremes(map: &planner::Map, key: fn(&SpotResult) -> Option<f64>) -> String {
    let spots = map.spots.iter();
    let values = || {
        spots
            .clone()
            .filter_map(|spot| Some((number(spot, key)?, spot.launch)))
    };
    let least = values().min_by(|a, b| a.0.total_cmp(&b.0));
    let most = values().max_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(least), Some(most)) = (least, most) else {
        return "none".into();
    };
    let at = |(value, launch): (f64, saltus::Launch)| {
        format!(
            "{} m at ω = {}, α_f = {}",
            digits(value, 4),
            digits(launch.rate, 4),
            digits(launch.firing_angle, 4)
        )
    };
    format!("from {} to {}", at(least), at(most))
}
