//! `saltus simulate`: what becomes of one jump, or of many.

use std::path::PathBuf;

use clap::Args;
use saltus::lagrangian::Sample;
use saltus::{Flight, Launch, LiftOff, Outcome, Robot, Stance, StanceError, Trace, flight_of};
use serde_json::{Map, Value, json};

use super::Status;
use super::batch;
use super::common::{Common, PlotOption};
use crate::error::CliError;
use crate::output::{self, Cell, Format, Table, digits};
use crate::plot::{Drawing, tick};
use crate::plot::trajectories::{Trajectories, Trajectory};
use crate::progress::Progress;
use crate::quantity;
use crate::range::{Values, angles, rates, times};

/// Most jumps that one call without a batch makes.
const MOST_JUMPS: usize = 1_000_000;
/// Most jumps that a plot of trajectories shows.
const MOST_DRAWN: usize = 100;

/// Simulate one jump, or many
#[derive(Args, Debug)]
#[command(after_help = "`saltus simulate --help` explains the output.", after_long_help = LONG_HELP)]
pub(crate) struct Simulate {
    /// Approach rate(s) ω₀ (rad/s): how fast the robot leans forward at the start
    #[arg(long, value_name = "RATE", value_parser = rates, allow_hyphen_values = true)]
    omega: Option<Values>,

    /// Firing angle(s) α_f (rad): the lean at which the leg is fired; forward of the upright is positive
    #[arg(long, value_name = "ANGLE", value_parser = angles, allow_hyphen_values = true)]
    alpha_f: Option<Values>,

    /// Valve opening time(s) t_v (s) [default: 0.1]
    #[arg(long, value_name = "TIME", value_parser = times, allow_hyphen_values = true)]
    valve_open: Option<Values>,

    /// Lean φ₀ (rad) at which the stance starts [default: the firing angle]
    #[arg(long, value_name = "ANGLE", value_parser = quantity::angle, allow_hyphen_values = true)]
    start_lean: Option<f64>,

    /// Read the launches from this CSV file: columns omega0_rad_s, phi0_rad, alpha_f_rad, valve_open_s
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["omega", "alpha_f", "valve_open", "start_lean"])]
    batch: Option<PathBuf>,

    #[command(flatten)]
    plot: PlotOption,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus simulate --omega 5 --alpha-f -0.1
  saltus simulate --omega 5 --alpha-f -6deg --valve-open 25ms --set leg.stroke_m=0.05
  saltus simulate --omega 5 --alpha-f -0.25:0.05:7 --plot figure-5.9.svg
  saltus simulate --batch jumps.csv --out answers.csv

Values: a number, start:stop:count (both ends included), or several of these with commas; every combination is simulated.
Suffixes: rad/s, deg/s; rad, deg; s, ms.

Outcomes: stroke (lift-off at the end of the stroke), force (lift-off because the leg's force fell to 0); without a flight:
stall (came to rest before the firing angle), no-break-away (the valve closed before the leg moved), early-lift-off (left the
ground before the leg was fired), fall-back (the leg sank back).

CSV columns: omega0_rad_s, phi0_rad, alpha_f_rad, valve_open_s, outcome, t_fire_s, t_liftoff_s; at lift-off phi_rad (lean),
omega_rad_s (lean rate), d_m, d_dot_m_s (extension and its rate), pressure_pa (chamber, absolute), x_m, y_m, vx_m_s, vy_m_s
(wheel centre, from the foot); apex_m (greatest height of the centre), land_rs_m and land_0_m (where the centre comes down to
the wheel's radius and to 0). Numbers have 17 significant digits; a cell is empty where there is no such thing.

JSON: {\"command\": \"simulate\", \"robot\": NAME, \"jumps\": [{the columns, null where empty}]}. Without --batch, each jump also
has \"contact\" {least_normal_n, least_normal_time_s, friction_needed, friction_needed_time_s} (friction_needed is null where
the ground would have to pull) and \"energy\" {drive_j, losses_j, kinetic_j, potential_j}.

A jump that does not take off is an answer: the exit code is 0.";

/// The columns of the reference file.
const COLUMNS: &[&str] = &[
    "omega0_rad_s",
    "phi0_rad",
    "alpha_f_rad",
    "valve_open_s",
    "outcome",
    "t_fire_s",
    "t_liftoff_s",
    "phi_rad",
    "omega_rad_s",
    "d_m",
    "d_dot_m_s",
    "pressure_pa",
    "x_m",
    "y_m",
    "vx_m_s",
    "vy_m_s",
    "apex_m",
    "land_rs_m",
    "land_0_m",
];

/// What people see of many jumps: column, title, unit.
const SHOWN: &[(&str, &str, &str)] = &[
    ("omega0_rad_s", "ω₀", "rad/s"),
    ("phi0_rad", "φ₀", "rad"),
    ("alpha_f_rad", "α_f", "rad"),
    ("valve_open_s", "valve open", "s"),
    ("outcome", "outcome", ""),
    ("t_liftoff_s", "lift-off", "s"),
    ("apex_m", "apex", "m"),
    ("land_rs_m", "landing at r_s", "m"),
    ("land_0_m", "landing at 0", "m"),
];

/// A jump and how it went.
pub(crate) struct Answer {
    pub(crate) launch: Launch,
    pub(crate) lift_off: LiftOff,
    pub(crate) flight: Option<Flight<f64>>,
    pub(crate) trace: Option<Trace>,
}

impl Simulate {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        let robot = self.common.robot()?;
        let launches = self.launches()?;
        let drawn = self.plot.is_set();
        if drawn && launches.len() > MOST_DRAWN {
            let allowed = format!("used with {MOST_DRAWN} jumps at most, not {}", launches.len());
            return Err(CliError::flag("--plot", "", allowed));
        }
        let answers = simulate(&robot, &launches, drawn || self.batch.is_none())?;
        let report = match self.common.format() {
            Format::Csv => table(&answers, &robot).csv(),
            Format::Json => json(&answers, &robot, self.batch.is_none()),
            Format::Text => text(&answers, &robot),
        };
        let drawing = || Ok(Drawing::Trajectories(family(&answers, &robot)));
        self.common.write_with_plot(report, &self.plot, drawing)?;
        Ok(Status::Done)
    }

    /// The launches, each with what messages call it.
    fn launches(&self) -> Result<Vec<(String, Launch)>, CliError> {
        if let Some(path) = &self.batch {
            let named = |(line, launch)| (format!("{}:{line}", path.display()), launch);
            return Ok(batch::load(path)?.into_iter().map(named).collect());
        }
        let missing = |flag| CliError::Missing { flag, allowed: "a launch needs it, or give a --batch" };
        let rates = self.omega.as_ref().ok_or_else(|| missing("--omega"))?;
        let angles = self.alpha_f.as_ref().ok_or_else(|| missing("--alpha-f"))?;
        let times = self.valve_open.clone().unwrap_or_else(|| Values::from(0.1));
        let count = rates.len().saturating_mul(angles.len()).saturating_mul(times.len());
        if count > MOST_JUMPS {
            let allowed = format!("combined into {MOST_JUMPS} jumps at most");
            return Err(CliError::flag("--omega, --alpha-f and --valve-open", format!("({count} jumps)"), allowed));
        }
        let mut launches = Vec::with_capacity(count);
        for &rate in rates.iter() {
            for &firing_angle in angles.iter() {
                let lean = self.start_lean.unwrap_or(firing_angle);
                launches.extend(times.iter().map(|&valve_open| {
                    let name = format!("--omega {rate} --alpha-f {firing_angle} --valve-open {valve_open}");
                    (name, Launch { rate, lean, firing_angle, valve_open })
                }));
            }
        }
        Ok(launches)
    }
}

fn simulate(robot: &Robot, launches: &[(String, Launch)], traced: bool) -> Result<Vec<Answer>, CliError> {
    let stance = Stance::<f64>::new(robot, |_, x| x);
    let progress = Progress::new("jumps", launches.len());
    let answer = |(jump, launch): &(String, Launch)| {
        let failed = |source: StanceError| CliError::Jump { jump: jump.clone(), source };
        let lift_off = stance.jump(launch).map_err(failed)?;
        let trace = if traced { Some(stance.trace(launch).map_err(failed)?) } else { None };
        progress.advance(1);
        let flight = lift_off.outcome.is_jump().then(|| flight_of(&lift_off, robot));
        Ok(Answer { launch: *launch, lift_off, flight, trace })
    };
    launches.iter().map(answer).collect()
}

fn table(answers: &[Answer], robot: &Robot) -> Table {
    let mut table = Table::new(COLUMNS);
    answers.iter().for_each(|answer| table.push(row(answer, robot)));
    table
}

fn row(answer: &Answer, robot: &Robot) -> Vec<Cell> {
    let Answer { launch, lift_off, flight, .. } = answer;
    let flown = |x: f64| Cell::from(flight.is_some().then_some(x));
    let landing = |height: f64| Cell::from(flight.and_then(|flight| flight.range_to_height(height).ok()));
    let ((x, y), (vx, vy)) = (lift_off.position(), lift_off.velocity());
    let mut row: Vec<Cell> =
        [launch.rate, launch.lean, launch.firing_angle, launch.valve_open].map(Cell::from).into();
    row.extend([Cell::Word(lift_off.outcome.name()), Cell::from(lift_off.time_fire)]);
    let end = [lift_off.time, lift_off.lean, lift_off.rate, lift_off.extension, lift_off.extension_rate];
    row.extend(end.into_iter().chain([lift_off.pressure, x, y, vx, vy]).map(flown));
    row.push(Cell::from(flight.map(|flight| flight.apex_height())));
    row.extend([landing(robot.body.radius), landing(0.0)]);
    row
}

fn json(answers: &[Answer], robot: &Robot, in_full: bool) -> String {
    let mut jumps = table(answers, robot).json();
    if in_full {
        jumps.iter_mut().zip(answers).for_each(|(jump, answer)| add_stance(jump, answer));
    }
    output::json(&json!({ "command": "simulate", "robot": robot.name, "jumps": jumps }))
}

/// Adds what the ground bears and where the energy goes.
fn add_stance(jump: &mut Map<String, Value>, answer: &Answer) {
    let Some(Trace { contact, energy, .. }) = &answer.trace else { return };
    let contact = json!({
        "least_normal_n": contact.least_normal,
        "least_normal_time_s": contact.least_normal_time,
        "friction_needed": contact.friction_needed,
        "friction_needed_time_s": contact.friction_needed_time,
    });
    let energy = json!({
        "drive_j": energy.drive,
        "losses_j": energy.losses,
        "kinetic_j": energy.kinetic,
        "potential_j": energy.potential,
    });
    jump.extend([("contact".to_owned(), contact), ("energy".to_owned(), energy)]);
}

fn text(answers: &[Answer], robot: &Robot) -> String {
    match answers {
        [answer] => one(answer, robot),
        _ => format!("{}: {} jumps\n{}", robot.name, answers.len(), table(answers, robot).text(SHOWN)),
    }
}

/// One jump in words.
fn one(answer: &Answer, robot: &Robot) -> String {
    let Answer { launch, lift_off, flight, trace } = answer;
    let mut lines = vec![
        format!("{}: one jump", robot.name),
        line("approach rate", launch.rate, "rad/s"),
        line("start lean", launch.lean, "rad"),
        line("firing angle", launch.firing_angle, "rad"),
        line("valve open", launch.valve_open, "s"),
        format!("  {:<16} {}: {}", "outcome", lift_off.outcome.name(), meaning(lift_off.outcome)),
    ];
    if let Some(flight) = flight {
        let radius = robot.body.radius;
        lines.extend([
            line("lift-off", lift_off.time, "s after the start"),
            format!("  {:<16} {} m forward, {} m up", "  centre at", short(flight.x), short(flight.y)),
            format!("  {:<16} {} m/s forward, {} m/s up", "  speed", short(flight.vx), short(flight.vy)),
            format!("  {:<16} {} rad, {} rad/s", "  lean and rate", short(lift_off.lean), short(lift_off.rate)),
            line("apex", flight.apex_height(), "m"),
        ]);
        for (height, name) in [(radius, "landing at r_s"), (0.0, "landing at 0")] {
            lines.push(match flight.range_to_height(height) {
                Ok(x) => line(name, x, &format!("m ahead of the foot, centre at {height} m")),
                Err(error) => format!("  {name:<16} never: {error}"),
            });
        }
    }
    lines.extend(trace.as_ref().map(stance_lines).unwrap_or_default());
    lines.join("\n") + "\n"
}

fn stance_lines(trace: &Trace) -> [String; 3] {
    let (contact, energy) = (&trace.contact, &trace.energy);
    let friction = match contact.friction_needed {
        needed if needed.is_finite() => line("friction needed", needed, "at least, for the foot not to slip"),
        _ => format!("  {:<16} any: the ground would have to pull", "friction needed"),
    };
    let work = format!("{} J by the drive, {} J lost", short(energy.drive), short(energy.losses));
    [line("least normal", contact.least_normal, "N"), friction, format!("  {:<16} {work}", "work")]
}

fn line(name: &str, x: f64, unit: &str) -> String {
    format!("  {name:<16} {} {unit}", short(x))
}

fn short(x: f64) -> String {
    digits(x, 5)
}

fn meaning(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Stroke => "lift-off at the end of the stroke",
        Outcome::Force => "lift-off because the leg's force fell to 0",
        Outcome::Stall => "came to rest before the firing angle",
        Outcome::NoBreakAway => "the valve closed before the leg moved",
        Outcome::EarlyLiftOff => "left the ground before the leg was fired",
        Outcome::FallBack => "the leg came to a halt and sank back",
        _ => "ended without lift-off",
    }
}

/// The paths of the wheel's centre.
fn family(answers: &[Answer], robot: &Robot) -> Trajectories {
    let differs = |key: fn(&Launch) -> f64| answers.windows(2).any(|w| key(&w[0].launch) != key(&w[1].launch));
    let keys: [(&str, fn(&Launch) -> f64); 4] = [
        ("firing angle α_f (rad)", |launch| launch.firing_angle),
        ("approach rate ω₀ (rad/s)", |launch| launch.rate),
        ("valve opening time (s)", |launch| launch.valve_open),
        ("start lean φ₀ (rad)", |launch| launch.lean),
    ];
    let (labels, key) = keys.into_iter().find(|(_, key)| differs(*key)).unwrap_or(keys[0]);
    let path = |answer: &Answer| Trajectory {
        stance: stance_path(answer, robot),
        flight: flight_path(answer),
        label: tick(key(&answer.launch)),
    };
    let rate = answers.first().filter(|_| !differs(|launch| launch.rate)).map(|answer| answer.launch.rate);
    let title = match rate {
        Some(rate) => format!("{}: path of the wheel's centre at ω₀ = {} rad/s", robot.name, short(rate)),
        None => format!("{}: path of the wheel's centre", robot.name),
    };
    Trajectories { title, labels: labels.into(), paths: answers.iter().map(path).collect(), radius: robot.body.radius }
}

fn stance_path(answer: &Answer, robot: &Robot) -> Vec<(f64, f64)> {
    let samples = answer.trace.as_ref().map(|trace| trace.samples.as_slice()).unwrap_or_default();
    let place = |sample: &Sample| {
        let (reach, (sin, cos)) = (robot.body.radius + sample.extension, sample.lean.sin_cos());
        (reach * sin, reach * cos)
    };
    samples.iter().map(place).collect()
}

fn flight_path(answer: &Answer) -> Vec<(f64, f64)> {
    const POINTS: usize = 2000;
    let landing = answer.flight.and_then(|flight| Some((flight, flight.time_to_height(0.0).ok()?)));
    landing.map_or(Vec::new(), |(flight, end)| flight.samples(0.0, end, POINTS).map(|(_, x, y)| (x, y)).collect())
}
