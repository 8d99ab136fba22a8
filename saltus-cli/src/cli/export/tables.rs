//! `saltus export c` and `saltus export rust`: firing tables for a controller.

use clap::Args;
use saltus::export::{self, ExportError, Number, Request, Tables};
use saltus::on_plant::OnPlant;
use saltus::{Planner, Robot};

use super::{Real, Written};
use crate::cli::Status;
use crate::cli::common::{OutFile, OutFolder, PlantFlags, RobotFlags, Threads, note_valve};
use crate::cli::terms::{TermFlags, Terms};
use crate::error::{CliError, cut};
use crate::output::print;
use crate::quantity::{self, Quantity};
use crate::range::{Values, angles, distances, rates};

/// Write what decides on a robot that jumps as C99, a header and a source
#[derive(Args, Debug)]
#[command(after_help = "`saltus export c --help` explains the files.", after_long_help = C_HELP)]
pub(super) struct C {
    #[command(flatten)]
    flags: TableFlags,

    #[command(flatten)]
    out: OutFolder,
}

/// Write firing tables as a constant for the Rust crate saltus-controller
#[derive(Args, Debug)]
#[command(after_help = "`saltus export rust --help` explains the file.", after_long_help = RUST_HELP)]
pub(super) struct Rust {
    #[command(flatten)]
    flags: TableFlags,

    /// Name of the constant
    #[arg(long, value_name = "NAME", value_parser = identifier, default_value = "CONTROLLER")]
    name: String,

    #[command(flatten)]
    out: OutFile,
}

const C_HELP: &str = "\
Examples:
  saltus export c --distance 0.3:0.8:11 --out firmware/src
  saltus export c --distance 0.6 --newton 2 --out firmware/src
  saltus export c --distance 0.3:0.8:11 --plant rats-boom --out firmware/src
  saltus export c --distance 0.4:0.7:7 --valve-open 60ms --valve-range 30ms:60ms --real double --out firmware/src

The files are saltus_controller.h and saltus_controller.c; `saltus export gait` writes those of a robot that runs.

One distance gives a curve over the approach rate, several, evenly spaced, a table. Beside it stands a map from approach rate and firing \
angle to the lift-off, for Newton steps, obstacles and take-offs. Every cell is held against the planner's own jumps; \
one that misses by more than --tolerance is closed, as is one that cannot be reached. Answers there are reasons, never clamped values.

With --plant the tables hold on that robot, with its boom, the masses of its legs and its ground: a few jumps of the multi-body \
simulation correct the planar model, and cells that miss there are closed. Of a flight that is no parabola, the map has the lift-off \
of the parabola with its apex and its landing. The head of the files says how far the simulated robot lands from what they fire.

A distance and an approach rate are those of `saltus table`: for the same options, saltus_firing_angle gives the angle that it prints. \
saltus_decide takes a lean and its rate at any instant of the stance; it needs no approach rate.

The header declares saltus_decide (whether, when and how long to open the valve), saltus_choose_take_off (from which touch-down to \
jump over an obstacle ahead, or to ask later), saltus_firing_angle, saltus_rate_at, saltus_observe, two small QPs, and saltus_self_test, which returns 0 if \
tables and answers are, to the bit, those of the Rust code. C99, IEEE 754, no allocation; compile with -ffp-contract=off (or -std=c99), \
link with -lm. -DSALTUS_NO_SELF_TEST leaves the test and its vectors out. What is printed also heads both files.

The exit code is 1 if no cell can be used.";

const RUST_HELP: &str = "\
Examples:
  saltus export rust --distance 0.3:0.8:11 --out src/rats.rs
  saltus export rust --distance 0.6 --name SIXTY_CENTIMETRES --out src/sixty.rs

The file has one public constant, a saltus_controller::Controller<'static, f32> (or f64), whose decide and take_off are those of \
`saltus export c`, to the bit; `saltus export c --help` says what the tables hold.

The exit code is 1 if no cell can be used.";

/// What tables hold.
#[derive(Args, Debug)]
struct TableFlags {
    /// Distances (m), evenly spaced, from the foot to the landing
    #[arg(long, value_name = "LENGTHS", value_parser = distances, allow_hyphen_values = true)]
    distance: Values,

    /// Approach rates ω (rad/s), evenly spaced; --start-lean says where they count
    #[arg(long, value_name = "RATES", value_parser = rates, allow_hyphen_values = true, default_value = "3:6:13")]
    omega: Values,

    /// Firing angles α_f (rad) of the lift-off map, evenly spaced [default: 11 about those of the
    /// table]
    #[arg(long, value_name = "ANGLES", value_parser = angles, allow_hyphen_values = true)]
    alpha_f: Option<Values>,

    #[command(flatten)]
    terms: TermFlags,

    /// Valve opening times (s) to choose from over an obstacle [default: that of --valve-open]
    #[arg(long, value_name = "LOW:HIGH", value_parser = ends, allow_hyphen_values = true)]
    valve_range: Option<(f64, f64)>,

    /// Newton steps on the lift-off map that refine a firing angle, 0 to 3; other landing heights
    /// need at least 1
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(0..=3), default_value = "0")]
    newton: u8,

    /// By how much the valve answers later than the robot file's delay (s)
    #[arg(long, value_name = "TIME", value_parser = quantity::time, allow_hyphen_values = true, default_value = "0")]
    extra_delay: f64,

    /// Greatest error of a landing (m); a cell that misses by more is closed
    #[arg(long, value_name = "LENGTH", value_parser = quantity::extent, allow_hyphen_values = true, default_value = "2mm")]
    tolerance: f64,

    #[command(flatten)]
    real: Real,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    plant: PlantFlags,

    #[command(flatten)]
    robot: RobotFlags,
}

impl C {
    pub(super) fn run(self) -> Result<Status, CliError> {
        self.out.ready()?;
        self.flags.real.write(&self)
    }
}

impl Written for C {
    fn write<R: Number>(&self) -> Result<Status, CliError> {
        let Some(tables) = self.flags.tables::<R>()? else {
            return Ok(Status::No);
        };
        let [header, source] = tables.c();
        let texts = [
            ("saltus_controller.h", header),
            ("saltus_controller.c", source),
        ];
        self.out.write(texts, &tables.about())?;
        Ok(Status::Done)
    }
}

impl Rust {
    pub(super) fn run(self) -> Result<Status, CliError> {
        self.out.ready()?;
        self.flags.real.write(&self)
    }
}

impl Written for Rust {
    fn write<R: Number>(&self) -> Result<Status, CliError> {
        let Some(tables) = self.flags.tables::<R>()? else {
            return Ok(Status::No);
        };
        self.out.write(tables.rust(&self.name))?;
        Ok(Status::Done)
    }
}

impl TableFlags {
    /// The tables; none, with the reason on standard output, where no cell can be used.
    fn tables<R: Number>(&self) -> Result<Option<Tables<R>>, CliError> {
        let (robot, plant) = self.plant.on_plant(&self.robot)?;
        self.terms.note_valve(&robot);
        note_valve(&robot, self.valve_range.map(|_| "--valve-range"));
        let request = self.request(&robot)?;
        let made = match plant {
            None => Tables::new(&Planner::new(robot), &request),
            Some(plant) => on_plant(robot, &plant, &request),
        };
        match made {
            Ok(tables) => Ok(Some(tables)),
            Err(no @ ExportError::Empty { .. }) => print(&format!("{no}\n")).map(|()| None),
            Err(error) => Err(error.into()),
        }
    }

    fn request(&self, robot: &Robot) -> Result<Request, CliError> {
        let Terms {
            landing_height,
            valve_open,
            start_lean,
            ..
        } = self.terms.of(robot);
        if valve_open <= 0.0 {
            return Err(CliError::flag(
                "--valve-open",
                valve_open,
                Quantity::OPEN.allowed,
            ));
        }
        let angles = self
            .alpha_f
            .as_ref()
            .map(|a| spaced("--alpha-f", a, 2))
            .transpose()?;
        let default = Request::default();
        if let Some((low, high)) = self.valve_range
            && !(low <= valve_open && valve_open <= high)
        {
            let allowed = format!("a range that holds --valve-open {valve_open}");
            return Err(CliError::flag(
                "--valve-range",
                format!("{low}:{high}"),
                allowed,
            ));
        }
        Ok(Request {
            rates: spaced("--omega", &self.omega, 2)?,
            distances: spaced("--distance", &self.distance, 1)?,
            firing_angles: angles.map(|(low, high, _)| (low, high)),
            angles: angles.map_or(default.angles, |(.., count)| count),
            landing_height: Some(landing_height),
            valve_open,
            valve_range: self.valve_range.filter(|_| robot.leg.drive.has_valve()),
            start_lean,
            period: robot.sensors.unwrap_or_default().period,
            extra_delay: self.extra_delay,
            newton_steps: self.newton,
            effort: default.effort,
            tolerance: self.tolerance,
            threads: self.threads.count().get(),
        })
    }
}

/// Tables that hold on a plant.
fn on_plant<R: Number>(
    robot: Robot,
    plant: &OnPlant,
    request: &Request,
) -> Result<Tables<R>, ExportError> {
    let (planner, _) = export::planner(robot, plant, request)?;
    let mut tables = Tables::new(&planner, request)?;
    tables.confirm(plant, request)?;
    Ok(tables)
}

/// Most nodes along an axis of a table.
const MOST: usize = 1000;

/// First, last and number of `values`, which rise in even steps.
fn spaced(
    flag: &'static str,
    values: &Values,
    least: usize,
) -> Result<(f64, f64, usize), CliError> {
    let (first, last, count) = (values[0], values[values.len() - 1], values.len());
    let shown = || {
        if count > 3 {
            format!("{first},{},…", values[1])
        } else {
            format!("{:?}", &values[..])
        }
    };
    if !(least..=MOST).contains(&count) {
        return Err(CliError::flag(
            flag,
            shown(),
            format!("{least} to {MOST} values, as in 3:6:13"),
        ));
    }
    let step = (last - first) / (count.max(2) - 1) as f64;
    let even = values
        .iter()
        .enumerate()
        .all(|(i, x)| (x - (first + step * i as f64)).abs() <= 1e-9 * step);
    if count > 1 && !(step > 0.0 && even) {
        return Err(CliError::flag(
            flag,
            shown(),
            "rising in even steps, as in 3:6:13",
        ));
    }
    Ok((first, last, count))
}

/// Parser of a flag.
fn ends(text: &str) -> Result<(f64, f64), String> {
    let allowed = "two times, the lower first, as in 30ms:60ms";
    quantity::span(text, &Quantity::OPEN, allowed)
}

/// Parser of a flag.
pub(super) fn identifier(text: &str) -> Result<String, String> {
    let mut letters = text.chars();
    let starts = letters.next().is_some_and(|c| c.is_ascii_uppercase());
    let goes_on = letters.all(|c| c.is_ascii_uppercase() || c.is_ascii_digit() || c == '_');
    if starts && goes_on {
        Ok(text.into())
    } else {
        Err(format!(
            "{:?} must be a name of capitals, digits and underscores, as in RATS_60",
            cut(text)
        ))
    }
}
