//! `saltus filling`: how far a filling of a robot's tank carries.

use clap::Args;
use saltus::filling::{Filling, FillingError, Hop, Request, filling};
use saltus::robot::Robot;
use saltus::{Launch, Outcome};
use serde_json::json;

use super::Status;
use super::common::Common;
use super::terms::{TermFlags, Terms, VALVE_OPEN};
use crate::error::CliError;
use crate::output::{self, Column, Format, Table as Rows, columns, counted, digits};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREEN};
use crate::plot::sheet::{Panel, Sheet};
use crate::quantity;

/// Count the jumps, and metres, to a filling of a robot's tank
#[derive(Args, Debug)]
#[command(after_help = "`saltus filling --help` explains the output.", after_long_help = LONG_HELP)]
pub(crate) struct FillingOf {
    /// Approach rate ω₀ (rad/s) of each jump: how fast the robot leans forward at the start
    #[arg(long, value_name = "RATE", value_parser = quantity::rate, allow_hyphen_values = true)]
    omega: f64,

    /// Firing angle α_f (rad) of each jump; forward of the upright is positive
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    alpha_f: f64,

    /// Height (m) that the wheel's lowest point has to come to for a jump to count [default: any]
    #[arg(long, value_name = "HEIGHT", value_parser = quantity::extent, allow_hyphen_values = true)]
    clear: Option<f64>,

    /// Time (s) from the end of a valve opening to the next jump, in which the tank's wall warms its
    /// gas up again
    #[arg(long, value_name = "TIME", value_parser = quantity::time, allow_hyphen_values = true, default_value = "1")]
    pause: f64,

    #[command(flatten)]
    terms: TermFlags,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus filling --omega 4.5 --alpha-f -0.1 --set tank.volume_l=0.5
  saltus filling --omega 4.5 --alpha-f -0.1 --set tank.volume_l=0.5 --set leg.gas=co2
  saltus filling --omega 4.5 --alpha-f -0.1 --set tank.volume_l=0.5 --clear 20cm --valve-open 30ms --plot filling.svg

The robot file has the tank ([tank]: volume, thermal resistance of its wall) and the gas (leg.gas: \
a name of docs/robots.md, as co2, or constants). At first the tank has the leg's supply pressure and gas temperature; every \
jump starts with the gas that the last one left. A jump is one of the planar model: stance and flight. \
Where the robot lifts off before its valve closes, the chamber goes on filling. The count ends where the \
robot does not lift off, does not clear the height (or the ground), or does not land. Gas is perfect: a bottle of liquid \
CO2 behind a regulator is no such tank.

Suffixes: rad/s, deg/s; rad, deg; s, ms; m, cm, mm.

CSV columns, one row for each jump, and a last one for that which does not count: jump, tank_pressure_pa \
(absolute, before the jump), tank_temperature_k, gas_kg (that it takes), outcome (as for `saltus \
simulate`), apex_m, clear_m (of the wheel's lowest point), distance_m, total_m (of all jumps that count), \
counts. Then, as for `saltus table`: valve_open_s, start_lean_rad, landing_height_m, robot, robot_sha256, \
saltus_version. Numbers have 17 significant digits; a cell is empty where there is no such thing.

JSON: {\"command\": \"filling\", \"robot\": NAME, \"robot_sha256\", \"saltus_version\", \"landing_height_m\", \
\"start_lean_rad\" (or \"firing\"), \"valve_open_s\", \"omega_rad_s\", \"alpha_f_rad\", \"clear_m\", \"pause_s\", \
\"jumps\", \"distance_m\", \"end\" (no-lift-off, too-low, no-landing, most-jumps), \"gas_kg\" (in the full \
tank), \"gas_left_pa\", \"gas_left_k\" (the tank after the last jump), \"rows\": [{the columns}]}.

The exit code is 1 if no jump counts.";

/// A jump, its number from 1, the distance (m) of all that count, and the robot.
type Row<'a> = (&'a Hop, usize, f64, &'a Robot);

fn columns<'a>() -> [Column<Row<'a>>; 10] {
    columns! {
        "jump", "", |(_, number, ..)| *number;
        "tank_pressure_pa", "", |(hop, ..)| hop.tank.pressure;
        "tank_temperature_k", "", |(hop, ..)| hop.tank.temperature;
        "gas_kg", "", |(hop, ..)| hop.gas;
        "outcome", "", |(hop, ..)| hop.outcome.name();
        "apex_m", "", |(hop, ..)| hop.apex;
        "clear_m", "", |(hop, .., robot)| hop.apex.map(|apex| apex - robot.body.radius);
        "distance_m", "", |(hop, ..)| hop.distance;
        "total_m", "", |(_, _, total, _)| *total;
        "counts", "", |(hop, ..)| hop.counts;
    }
}

/// What people see.
fn shown<'a>() -> [Column<Row<'a>>; 8] {
    columns! {
        "jump", "jump", |(_, number, ..)| *number;
        "tank", "tank, gauge|bar", |(hop, .., robot)| 1e-5 * (hop.tank.pressure - robot.environment.ambient.0);
        "tank_temperature_k", "tank", |(hop, ..)| hop.tank.temperature;
        "gas", "gas|g", |(hop, ..)| 1e3 * hop.gas;
        "apex_m", "apex", |(hop, ..)| hop.apex;
        "distance_m", "distance", |(hop, ..)| hop.distance;
        "total_m", "total", |(_, _, total, _)| *total;
        "outcome", "outcome", |(hop, ..)| hop.outcome.name();
    }
}

/// Jumps after which the count ends.
const MOST: usize = 10_000;

/// Rows that the text shows: of many jumps the first and the last ones.
const SHOWN: usize = 24;

impl FillingOf {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        let robot = self.common.robot.emptying_robot()?;
        let terms = self.terms.of(&robot);
        let request = self.request(&terms);
        let found = filling(robot.clone(), &request).map_err(|error| self.failed(&robot, error))?;
        let report = match self.common.format() {
            Format::Csv => table(&found, &terms, &robot, &request).csv(),
            Format::Json => json(&found, &terms, &robot, &request),
            Format::Text => text(&found, &terms, &robot, &request),
        };
        let drawing = || Ok(sheet(&found, &robot));
        self.common.write(report, drawing)?;
        Ok(Status::of(found.jumps() > 0))
    }

    fn request(&self, terms: &Terms) -> Request {
        let lean = terms.start_lean.unwrap_or(self.alpha_f);
        Request {
            launch: Launch {
                rate: self.omega,
                lean,
                firing_angle: self.alpha_f,
                valve_open: self.terms.valve_open.unwrap_or(VALVE_OPEN),
            },
            landing_height: terms.landing_height,
            clear: self.clear.unwrap_or(0.0),
            pause: self.pause,
            most: MOST,
        }
    }

    fn failed(&self, robot: &Robot, error: FillingError) -> CliError {
        match error {
            FillingError::Jump { jump, source } => CliError::Jump {
                jump: format!(
                    "--omega {} --alpha-f {}, jump {jump}",
                    self.omega, self.alpha_f
                ),
                source,
            },
            other => CliError::content(&robot.name, other),
        }
    }
}

/// What the gas is called.
fn gas(robot: &Robot) -> &'static str {
    let gas = robot.leg.cylinder().and_then(|c| c.gas.name());
    gas.unwrap_or("gas")
}

fn rows<'a>(found: &'a Filling, robot: &'a Robot) -> impl Iterator<Item = Row<'a>> {
    let mut total = 0.0;
    found.hops.iter().enumerate().map(move |(i, hop)| {
        total += hop.distance.filter(|_| hop.counts).unwrap_or(0.0);
        (hop, i + 1, total, robot)
    })
}

fn table(found: &Filling, terms: &Terms, robot: &Robot, request: &Request) -> Rows {
    let angle = Some(request.launch.firing_angle);
    let table = Rows::of(&columns(), rows(found, robot));
    terms.told(table, std::iter::repeat(angle))
}

fn json(found: &Filling, terms: &Terms, robot: &Robot, request: &Request) -> String {
    let mut document = terms.json("filling");
    let rows = table(found, terms, robot, request).json();
    for (key, value) in [
        ("omega_rad_s", json!(request.launch.rate)),
        ("alpha_f_rad", json!(request.launch.firing_angle)),
        ("clear_m", json!(request.clear)),
        ("pause_s", json!(request.pause)),
        ("jumps", json!(found.jumps())),
        ("distance_m", json!(found.distance())),
        ("end", json!(found.end.name())),
        ("gas_kg", json!(found.filled)),
        ("gas_left_pa", json!(found.left.pressure)),
        ("gas_left_k", json!(found.left.temperature)),
        ("rows", json!(rows)),
    ] {
        document.insert(key.into(), value);
    }
    output::json(&document.into())
}

fn text(found: &Filling, terms: &Terms, robot: &Robot, request: &Request) -> String {
    use saltus::filling::End;
    let volume = robot.tank.map_or(0.0, |tank| tank.volume);
    let full = found.hops.first().map_or(found.left, |hop| hop.tank);
    let ambient = robot.environment.ambient.0;
    let head = format!(
        "{}: {} and {} m to a tank of {} l, {} g of {} at {} bar above ambient",
        robot.name,
        counted(found.jumps(), "jump"),
        digits(found.distance(), 4),
        digits(1e3 * volume, 4),
        digits(1e3 * found.filled, 4),
        gas(robot),
        digits(1e-5 * (full.pressure - ambient), 4),
    );
    let number = found.hops.len();
    let outcome = found
        .hops
        .last()
        .map_or(Outcome::Stall, |hop| hop.outcome)
        .name();
    let why = match found.end {
        End::NoLiftOff if outcome == Outcome::EarlyLiftOff.name() => {
            format!("in jump {number} the robot leaves the ground before the leg is fired")
        }
        End::NoLiftOff => format!("jump {number} does not lift off: {outcome}"),
        End::TooLow if request.clear == 0.0 => format!("jump {number} does not clear the ground"),
        End::TooLow => {
            let clear = digits(request.clear, 4);
            format!("jump {number} does not clear {clear} m")
        }
        End::NoLanding => format!("jump {number} does not come down to the landing height"),
        End::Most => format!("the count ends at {number}"),
    };
    let left = format!(
        "{} bar above ambient and {} K are left",
        digits(1e-5 * (found.left.pressure - ambient), 4),
        digits(found.left.temperature, 4),
    );
    // Of many jumps the first and the last ones.
    let is_shown =
        |(_, i, ..): &Row<'_>| number <= SHOWN || *i <= SHOWN / 2 || *i + SHOWN / 2 > number;
    let shortened = rows(found, robot).filter(is_shown);
    format!(
        "{head}\n  {}\n  {why}; {left}\n{}",
        terms.line(),
        Rows::of(&shown(), shortened).text()
    )
}

fn sheet(found: &Filling, robot: &Robot) -> Sheet {
    let mark = if found.hops.len() <= 60 {
        Mark::Dots
    } else {
        Mark::Solid
    };
    let panel = |title: &str, y, color, of: &dyn Fn(&Row<'_>) -> Option<f64>| {
        let points = rows(found, robot).filter_map(|row| Some((row.1 as f64, of(&row)?)));
        Panel {
            title: title.into(),
            x: "jump",
            y,
            lines: vec![Line::new(mark, color, points)],
            least: Some([[0.0, 1.0], [0.0, 0.0]]),
            ..Panel::default()
        }
    };
    let ambient = robot.environment.ambient.0;
    let before = "tank before each jump";
    let warmth = panel(before, "temperature (K)", GREEN, &|(hop, ..)| {
        Some(hop.tank.temperature)
    });
    Sheet {
        title: format!(
            "{}: {} and {} m to a filling",
            robot.name,
            counted(found.jumps(), "jump"),
            digits(found.distance(), 4)
        ),
        panels: vec![
            panel(
                before,
                "pressure above ambient (bar)",
                BLUE,
                &|(hop, ..)| Some(1e-5 * (hop.tank.pressure - ambient)),
            ),
            Panel {
                least: None,
                ..warmth
            },
            panel("apex of the wheel's centre", "height (m)", BLUE, &|row| {
                row.0.apex
            }),
            panel("distance of each jump", "distance (m)", BLUE, &|row| {
                row.0.distance
            }),
            panel("distance of all jumps", "distance (m)", GREEN, &|row| {
                Some(row.2)
            }),
        ],
        ..Sheet::default()
    }
}
