//! `saltus run`: a robot that runs, under the controller that is flashed.

mod ball;
mod described;
mod ensemble;
mod figure;
mod follow;
mod gait;
mod held;
mod page;
mod recorder;
mod report;
mod rows;
mod telemetry;
mod values;

use std::ffi::{OsStr, OsString};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};
use saltus::Robot;
use saltus::gait::{Ending, Logger, Program, Setup, run};
use saltus::recording::Running;
use saltus::robot::resolve_text;
use saltus::sim_check::Stepping;

use super::Status;
use super::common::{OutputFlags, PlotOption, Threads, any_robot, page_file, robot, seed};
use super::disturb::{self, Typed};
use super::film::Film;
use super::recorded::McapOption;
use super::refused::refused;
use super::with::With;
use crate::error::CliError;
use crate::interrupt::Interrupt;
use crate::output::{Files, Format, digits, message, reachable, reachable_folder};
use crate::progress::Progress;
use crate::quantity::{self, Quantity, QuantityError};
use ball::{Ball, InSpace};
use follow::{Follower, OnTheWay, Thinned};
use gait::{Chosen, Plane};
pub(crate) use gait::{Law, Senses};
use held::Held;
use recorder::Recorder;
use report::Disturbed;
use rows::{Columns, Rows};
use telemetry::{MANIFEST, SETTINGS, Telemetry};

/// Longest run with a page to watch (s).
const LONGEST_FILM: f64 = 60.0;

/// Run a robot: legs fired in turn by the controller, in the multi-body simulation
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus run --help` explains the output, `saltus run closed-loop --help` the flags of a gait.",
    after_long_help = LONG_HELP,
    subcommand_value_name = "GAIT",
    subcommand_help_heading = "Gaits"
)]
pub(crate) struct Run {
    #[command(subcommand)]
    gait: With<Gait, RunFlags>,
}

/// How the firing angle is found.
#[derive(Debug, Subcommand)]
enum Gait {
    #[command(flatten)]
    Plane(With<Plane, PlaneFlags>),
    #[command(flatten)]
    Ball(Ball),
}

/// Flags that only a robot in its plane has.
#[derive(Args, Debug)]
#[command(next_help_heading = "Run")]
struct PlaneFlags {
    /// What changes on the way, WHAT=VALUE@FROM:TO in s or m, as in torque=5@0.5:0.7s: slope (deg),
    /// force (N), torque (N m), supply (psi) or friction; may be repeated
    #[arg(long, value_name = "WHAT=VALUE@FROM:TO", value_parser = disturb::disturb, allow_hyphen_values = true)]
    disturb: Vec<Typed>,

    /// Compute the motion with error control, every event located
    #[arg(long, conflicts_with = "step")]
    exact: bool,

    /// Friction coefficient across the travel of the robots that are drawn
    #[arg(long, value_name = "MU", value_parser = quantity::factor, default_value = "0", requires = "robots", allow_hyphen_values = true)]
    drawn_across: f64,

    /// Robot that the telemetry names, where it is another than the one that runs: a built-in one or
    /// a TOML file
    #[arg(long, value_name = "NAME|FILE", requires = "telemetry")]
    believed: Option<String>,
}

/// Flags of every run.
#[derive(Args, Debug)]
#[command(
    next_help_heading = "Run",
    after_help = "`saltus run --help` explains the output."
)]
struct RunFlags {
    /// How long (s)
    #[arg(long, value_name = "TIME", value_parser = seconds, default_value = "10", allow_hyphen_values = true)]
    seconds: f64,

    /// Compute the motion in fixed steps of this length (s) [default: 1ms]
    #[arg(long, value_name = "TIME", value_parser = step, allow_hyphen_values = true)]
    step: Option<f64>,

    /// Seed of the sensors' noise, and of the robots that are drawn: a whole number from 0
    #[arg(
        long,
        value_name = "SEED",
        default_value_t = 1,
        value_parser = seed,
        allow_hyphen_values = true
    )]
    seed: u64,

    /// Draw so many robots around this one and run each: legs' friction and spring, supply and
    /// ground friction vary
    #[arg(long, value_name = "COUNT", value_parser = robots, allow_hyphen_values = true, conflicts_with_all = ["plot", "animate", "telemetry", "mcap"])]
    robots: Option<NonZeroUsize>,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    plot: PlotOption,

    /// Write a page that plays the run, of 60 s at most, in a browser
    #[arg(long, value_name = "FILE.html", value_parser = page_file, help_heading = "Robot and output")]
    animate: Option<PathBuf>,

    #[command(flatten)]
    mcap: McapOption,

    /// Write every cycle's readings, outputs and truths into this folder, which is made if it is not there and has to be empty
    #[arg(long, value_name = "FOLDER", help_heading = "Robot and output")]
    telemetry: Option<PathBuf>,

    /// Robot: a built-in one (rats-planar, rats-boom, rats-run, rats-twelve, spring-hopper, table-hopper) or a TOML file
    /// [default: rats-run; rats-twelve where the gait is one in space; with `policy` the one that learnt it]
    #[arg(long, value_name = "NAME|FILE", help_heading = "Robot and output")]
    robot: Option<String>,

    /// Override a parameter of the robot by its dotted key, as in leg.stroke_m=0.05; may be
    /// repeated
    #[arg(
        long = "set",
        value_name = "KEY=VALUE",
        help_heading = "Robot and output"
    )]
    overrides: Vec<String>,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus run closed-loop --seconds 5
  saltus run fixed --firing-angle 0.1 --valve-open 40ms --seconds 15 --disturb torque=5@5:5.2s --plot figure-5.3.svg
  saltus run open-loop --from 0.35 --to 0 --centre printed --seconds 5 --format csv --out run.csv
  saltus run closed-loop --lines jump --seconds 5 --animate run.html
  saltus run smooth --seconds 5 --plot smooth.svg
  saltus run speed --speed 0:1.5,4:3,8:-1 --seconds 12
  saltus run closed-loop --seconds 9 --robots 40 --seed 7
  saltus run disc --seconds 5
  saltus run disc-stable --heading 30deg --seconds 20 --robots 100
  saltus run steer --path points.csv --seconds 60 --plot track.svg --animate run.html
  saltus run recover --seconds 10 --seed 3

The robot stands on two feet, finds out by its accelerometer which ones, and runs: the leg whose lean lies in the \
active zone fires, once an entry, as soon as it leans by the firing angle. docs/running.md describes gaits, sensors and \
the simulation.

Suffixes: rad/s, deg/s; rad, deg; s, ms, min; in --disturb deg, rad, N, Nm, psi, kPa, bar.

A stall is an answer: standing still for 0.5 s at the end of the run, unless --speed demands it; the report says since \
when, where and why, and the exit code is 1. With --robots the exit code does not depend on stalls. Ctrl-C ends a \
run early: the report and the rows are of the time up to then, and the exit code is 130.

--disturb: slope tilts the ground (deg), uphill towards where the robot runs from its start; on a boom the robot runs in a circle, \
so that a tilt is uphill, across and downhill in turn. For a floor that rises all the way round, set ground.slope_deg. force (N) pushes the end of the \
boom, or the axle without one, and torque (N m) turns the wheel, both towards positive travel. supply is a gauge pressure (psi).

CSV: a row a cycle, written as it comes: time_s, x_m, height_m, vx_m_s, vz_m_s (axle), wheel_angle_rad, \
wheel_rate_rad_s, leg_in_zone, lean_rad (of that leg, in the direction of the run), filtered_rate_rad_s, \
firing_angle_rad (empty while no leg is to fire), fired_leg, valve_open_s (empty where none fires, and where a policy opens a valve and decides later when it closes), stalled (by the controller, \
from the gyro alone), and for each leg extension_N_m, pressure_N_pa (absolute) and valve_open_N_s (for how long of this cycle, from its begin, the output to its valve is on). Numbers have 17 significant digits. A run that fails leaves no file.

JSON: {\"command\": \"run\", \"robot\", \"gait\", \"ending\", ...}: what the text says, in SI units, without rows. Energies \
are in J: \"ledger_j\" has the work of the drives and from outside, and what was lost in legs, by slip, to the air, in impacts \
at the ground and at end stops; what motion, height and springs gained; \"residual\" is work less losses and gains: what these do not explain. \
\"gas_residual\" is n R T times the gas that flowed, less what became of it.

Travels and speeds are positive forwards, also with --direction backwards. Top speed and the times to 3.2 m/s and 1.6 m are those in the direction of the run. \
A leg touches down where its foot was more than 1 mm above the ground before: a smaller rebound is none.

Keys of a run (null: not reached, not asked for): \"gait_in_words\", \"direction\", \"seconds\" (asked for), \"ran_for_s\", \"step_s\", \"seed\", \"zone_rad\", \"taps\", \
\"disturbances\", \"disturbances_not_met\" (the run does not come to their time or place), \"rear_leg_at_start\", \"travel_m\", \"way_m\", \"mean_speed_m_s\", \"mean_speed_last_4_s_m_s\", \"speed_at_end_m_s\", \"top_speed_m_s\" and \"time_to_1_6_m_s\" (both of the first 1.6 m), \
\"speed_at_1_6_s_m_s\", \"reached_3_2_m_s_s\", \"firings\", \"touch_downs\", \"touch_downs_of_legs_out\", \"other_contacts\", \"first_other_contacts\", \
\"legs_out_at_end\": [{\"leg\", \"extension_m\"}], \"leg_work_j\", \"gas_kg\", \"gas_kg_per_m\", \"exergy_j_per_m\", \"stalls\", \"demanded\": [{\"from_s\", \"speed_m_s\", \"mean_of_second_half_m_s\"}], \"boxes\", \"ending\": {\"how\"}, \
\"ledger_j\": {\"drives\", \"outside\", \"legs\", \"slip\", \"air\", \"impacts_at_ground\", \"impacts_at_stops\", \"kinetic_gained\", \"potential_gained\", \"springs_gained\", \
\"residual\", \"gas_residual\"}, \"approximate_contacts\" (fixed steps whose contact forces obey the laws only to 1 mm/s and 1e-4 of the greatest force).

Keys with --robots: \"robots\", \"drawn\": {\"coulomb_friction_n\", \"spring_stiffness_n_per_m\", \"friction_and_spring_at_mid_stroke_n\", \
\"supply_standard_deviation_pa\", \"friction_along\", \"friction_across\"}; shares {\"count\", \"of\", \"share\", \"interval_95\"}: \"running\" (with \"from_m_s\", the least speed), \
\"reached_3_2_m_s\", \"reached_3_2_m_s_within_3_s\", \"stalled\"; of the robots \"not_simulated\", \"first_not_simulated\", \"speed_of_runners_m_s\", \
\"speed_at_1_6_s_m_s\", \"time_to_3_2_m_s_s\", \"gas_of_runners_kg_per_m\"; and \"runs\", whose keys are the columns of CSV: robot, supply_pressure_gauge_pa, \
coulomb_friction_n, spring_stiffness_n_per_m, spring_preload_n, friction_along, ending, stalled_at_m, stalled_since_s, error, drives_j, residual_j and those of a run.

Keys of a robot in space: \"command\", \"robot\", \"gait\", \"ending\" (in a word), \"seconds\", \"seed\", \"by_sensors\", \"heading_rad\", \"line_rad\", \"most_aside_m\", \
\"travel_m\", \"time_s\", \"firings\", \"fell\" and \"left_its_plane\" (null or {\"time_s\", \"travel_m\", \"aside_m\", \"roll_rad\", \"roll_rate_rad_s\"}), \"stands_since_s\", \"work_j\", \
\"residual_j\", \"approximate_contacts\"; of steer also \"way_m\", \"place_m\", \"points\", \"points_reached\", \"set_out\" and \"rolled_a_turn_s\"; with --robots \
\"drawn\": {\"force_factor_standard_deviation\", \"center_of_mass_within_m\", \"friction\"}, the shares \"came_30_m_within_1_m\" and \"rolled_to_the_end\", \"not_simulated\", and \
\"runs\", also the columns of CSV: robot, ending, error, fell_s, fell_roll_rad, firings, most_aside_m, points_reached, rolled_a_turn_s, set_out, time_s, travel_m and way_m.

--robots draws around the given robot: its friction and spring at mid stroke, split anew, friction from a tenth to all of it; \
supply with a standard deviation of 3 psi; friction along the travel from 2/3 to 4/3 of its own; friction across it is --drawn-across. The answer is the share that \
runs with its 95 % interval (Wilson); CSV has a row a robot. It does not depend on --threads.

A robot in space, such as rats-twelve, rolls as a disc on the legs near one plane: docs/space.md. By `disc-stable` it goes \
by its sensors unless --truth is given, and ends where it has fallen or stands, with exit code 1. By `steer` it follows --path, or \
the line with --heading: it gets up where it fell, and the run ends at the last point; before that, the exit code is 1. By `recover` it \
is first thrown down, at any attitude with up to 5 rad/s, by --seed. With --robots forces of legs, centre \
of mass and friction (0.6 to 1.2 times the ground's) are drawn. The CSV of a run has a row a cycle: time_s, x_m, y_m, z_m (where its legs meet), quaternion_w to quaternion_z \
(from the body's axes to the world's), vx_m_s to vz_m_s, spin_x_rad_s to spin_z_rad_s, lean_rad (of the leg or twins in the zone), \
rate_rad_s, roll_rad, roll_rate_rad_s, heading_rad, stations_passed, feet_on_ground (how many), fired_leg, valve_open_s, fired_twin, \
twin_valve_open_s (empty where none fires), what its sensors make of place and attitude, estimated_x_m to estimated_z_m and estimated_quaternion_w to estimated_quaternion_z \
(empty without sensors), and extension_N_m of each leg. Its page (--animate) shows the ball in space, by WebGL, with the estimate of \
its sensors beside it. Its telemetry is run.csv, with the columns of /measured (rates and specific force along the body's axes, contact \
and valve of each leg), cycles.csv with the columns of CSV and robot.toml; `saltus diagnose` does not read it.

--mcap writes the motion every cycle as it is computed, and in /measured the columns of --telemetry; docs/viewers.md lists the topics.

--telemetry writes a folder of data of kind `run` that `saltus diagnose` reads: experiment.toml, the robot, and run.csv with \
what is measured (docs/logs.md). Beside it are cycles.csv, the columns of CSV and the counts of encoders, gyros and \
accelerometers, and settings.toml. With --believed the folder names another robot than the one that ran.";

/// A robot that runs in its plane.
struct InPlane {
    flags: RunFlags,
    plane: PlaneFlags,
    /// The name of the gait, and the gait in words.
    gait: String,
    words: String,
    /// The flags that say its firing angles.
    angles: &'static str,
}

impl Run {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        let With {
            name: gait,
            of,
            flags,
        } = self.gait;
        flags.ready()?;
        match of {
            Gait::Plane(With {
                of, flags: plane, ..
            }) => {
                let robot = |learnt: Option<&Robot>| flags.robot(&gait, false, learnt);
                let Chosen {
                    setup,
                    words,
                    angles,
                } = of.chosen(robot, flags.seconds)?;
                let run = InPlane {
                    flags,
                    plane,
                    gait,
                    words,
                    angles,
                };
                run.run(setup)
            }
            Gait::Ball(ball) => {
                let robot = flags.robot(&gait, true, None)?;
                InSpace { flags, gait, ball }.run(&robot)
            }
        }
    }
}

/// That the words of a line name no gait where one comes first.
pub(crate) fn without_gait(words: &[OsString]) -> Option<CliError> {
    if words.first()? != "run" {
        return None;
    }
    let all = Gait::augment_subcommands(clap::Command::new("run"));
    refused_gait(("run", &all), words.get(1)?, "run closed-loop --seconds 5")
}

/// That `word` is none of the gaits of `all`, which come first as in `example`.
pub(crate) fn refused_gait(
    (flag, all): (&'static str, &clap::Command),
    word: &OsStr,
    example: &str,
) -> Option<CliError> {
    let names: Vec<&str> = all.get_subcommands().map(clap::Command::get_name).collect();
    let word = word.to_string_lossy();
    if names.contains(&word.as_ref()) || word == "help" {
        return None;
    }
    let names = names.join(", ");
    let allowed = format!("a gait, which comes first, as in saltus {example}: {names}");
    Some(CliError::flag(flag, word, allowed))
}

impl InPlane {
    fn run(&self, mut setup: Setup) -> Result<Status, CliError> {
        let disturb = &self.plane.disturb;
        disturb::check(disturb, &setup.robot)?;
        Self::note_what_never_comes(&setup);
        setup.disturbances = disturb.iter().map(|typed| typed.disturbance).collect();
        setup.seed = self.flags.seed;
        setup.stepping = if self.plane.exact {
            Stepping::Adaptive
        } else {
            self.flags.stepping()
        };
        if self.flags.robots.is_some() {
            return self.many(&setup);
        }
        self.one(&setup)
    }

    /// Says which speeds the schedule has after the end, and which are above those that the robot was measured to run at.
    /// Below them it holds a speed as well, by later firings, and at last by standing at times: the report says how.
    fn note_what_never_comes(setup: &Setup) {
        let seconds = setup.seconds;
        let Program::Curve(law) = &setup.program else {
            return;
        };
        let fastest = law.last().map_or(0.0, |knot| knot[0]);
        for &[time, speed] in &setup.speeds {
            if time >= seconds {
                message(&format!(
                    "--speed {time}:{speed} begins after the end of the run, {seconds} s"
                ));
            } else if speed.abs() > fastest {
                message(&format!(
                    "--speed {time}:{speed}: the robot was measured to run at {} m/s at most; it comes as near as it can",
                    digits(fastest, 4)
                ));
            }
        }
    }

    /// One run.
    fn one(&self, setup: &Setup) -> Result<Status, CliError> {
        self.flags.places()?;
        let interrupt = Interrupt::listen()?;
        // A length is at most 100,000 s.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let progress = Progress::new("simulated seconds", self.flags.seconds.ceil() as usize);
        let mut follower = Follower::new(setup.sensors().period, &interrupt, &progress);
        follower.held = Held::all(&setup.speeds, setup.seconds);
        follower.boxes = OnTheWay::all(setup);
        let believed = self.believed(setup)?;
        self.open(&mut follower, setup)?;
        let summary =
            run(setup, &mut follower).map_err(|error| refused(error, &setup.robot, self.angles))?;
        progress.end();
        let kept = follower.kept();
        let report = report::Report {
            run: self,
            setup,
            summary: &summary,
            follower: &follower,
            interrupted: interrupt.came(),
        };
        let mut files = self.files(&report, kept.rows, kept.film)?;
        if let Some(recorder) = kept.recorder {
            files.written(recorder.finish(Running::finish)?)?;
            files.check()?;
        }
        if let Some((folder, _)) = kept.telemetry {
            let settings = (SETTINGS, described::settings(&report));
            let manifest = (MANIFEST, described::manifest(&report, &believed));
            folder.publish(&believed, [settings, manifest])?;
        }
        note_interrupt(&interrupt, summary.time);
        report.note_unexplained();
        files.write()?;
        if interrupt.came() {
            return Ok(Status::Interrupted);
        }
        Ok(match summary.ending {
            Ending::Ran => Status::Done,
            Ending::Stalled { .. } => Status::No,
        })
    }

    /// The robot that the telemetry says has run.
    fn believed(&self, setup: &Setup) -> Result<Robot, CliError> {
        let Some(name) = &self.plane.believed else {
            return Ok(setup.robot.clone());
        };
        let believed = robot(name, &[])?;
        if believed.body.legs == setup.robot.body.legs {
            return Ok(believed);
        }
        let allowed = format!(
            "a robot with {} legs, as many as run",
            setup.robot.body.legs
        );
        Err(CliError::flag("--believed", name, allowed))
    }

    /// Opens what `follower` writes and keeps.
    fn open(&self, follower: &mut Follower<'_>, setup: &Setup) -> Result<(), CliError> {
        let (robot, legs) = (&setup.robot, setup.robot.body.legs as usize);
        if self.flags.output.format() == Format::Csv {
            let header = Columns::Motion.header(legs);
            follower.kept.rows = Some(Rows::open("--out", self.flags.output.out(), header)?);
        }
        if let Some(folder) = &self.flags.telemetry {
            let (cycles, logger) = (Columns::Telemetry.header(legs), Logger::new(robot));
            let measured = format!("time_s,{}", logger.columns().join(","));
            let telemetry = Telemetry::open(folder, cycles, measured)?;
            follower.kept.telemetry = Some((telemetry, logger));
        }
        if let Some(path) = self.flags.mcap.path() {
            let begin = |recording| Running::new(recording, setup);
            let recorder = Recorder::open(path, (robot, setup.seed), begin)?;
            follower.kept.recorder = Some(recorder);
        }
        follower.line = self.flags.plot.is_set().then(Thinned::new);
        follower.kept.film = (self.flags.animate.is_some()).then(|| Film::new(setup));
        Ok(())
    }

    /// The report, the page and the plot.
    fn files(
        &self,
        report: &report::Report<'_>,
        rows: Option<Rows>,
        film: Option<Film>,
    ) -> Result<Files, CliError> {
        let mut files = Files::default();
        match (rows, self.flags.output.format()) {
            (Some(rows), _) => {
                if let Some(stream) = rows.finish()? {
                    files.written(stream)?;
                }
                if report.summary.ending != Ending::Ran && !report.interrupted {
                    message(&format!("the robot {}", report.ending()));
                }
                let disturbed = Disturbed::of(&self.plane.disturb, &report.summary.disturbed);
                for reason in disturbed.reasons(report.summary.time) {
                    message(&format!("not disturbed by {reason}"));
                }
            }
            (None, Format::Json) => files.report(self.flags.output.out(), report.json()),
            (None, _) => files.report(self.flags.output.out(), report.text()),
        }
        if let (Some(path), Some(film)) = (&self.flags.animate, film) {
            let html = page::html(report, film);
            files.add("--animate", path, html.into_bytes());
        }
        if let Some(line) = &report.follower.line {
            let drawing = || Ok(figure::drawing(report, line));
            self.flags.plot.add_to(&mut files, drawing)?;
        }
        files.check()?;
        Ok(files)
    }
}

impl RunFlags {
    /// The robot that runs by `gait`: in space or in its plane, and the one that has `learnt` where none is named.
    fn robot(&self, gait: &str, in_space: bool, learnt: Option<&Robot>) -> Result<Robot, CliError> {
        let (usual, shape, other) = if in_space {
            ("rats-twelve", "sphere", "wheel")
        } else {
            ("rats-run", "wheel", "sphere")
        };
        let robot = match (&self.robot, learnt) {
            (None, Some(own)) => resolve_text(&own.to_toml(), &own.name, &self.overrides)?,
            (name, _) => any_robot(name.as_deref().unwrap_or(usual), &self.overrides)?,
        };
        if robot.space.is_some() == in_space {
            return Ok(robot);
        }
        let reason = format!("body.shape = {other}: must be {shape} for the gait {gait}");
        Err(CliError::content(&robot.name, reason))
    }

    /// The steps in which the motion is computed.
    fn stepping(&self) -> Stepping {
        self.step.map_or(Stepping::USUAL, Stepping::Fixed)
    }

    /// Refuses files and a folder that cannot be written, before long work.
    fn ready(&self) -> Result<(), CliError> {
        self.output.ready(&self.plot)?;
        reachable("--animate", self.animate.as_deref())?;
        self.mcap.ready()?;
        self.telemetry.as_deref().map_or(Ok(()), reachable_folder)
    }

    /// Refuses a page of a long run and files that two flags name, before long work.
    fn places(&self) -> Result<(), CliError> {
        if self.animate.is_some() && self.seconds > LONGEST_FILM {
            let allowed = format!(
                "used with --seconds {LONGEST_FILM} at most, not {}",
                self.seconds
            );
            return Err(CliError::flag("--animate", "", allowed));
        }
        let out = self.output.out().filter(|out| *out != Path::new("-"));
        let mut files = Files::default();
        files.extend(out.map(|out| ("--out", out)));
        files.extend(self.animate.as_deref().map(|page| ("--animate", page)));
        files.extend(self.mcap.path().map(|file| ("--mcap", file)));
        files.extend(self.plot.path().map(|plot| ("--plot", plot)));
        files.check()
    }
}

/// Says so where Ctrl-C ended a run after so long (s).
fn note_interrupt(interrupt: &Interrupt, time: f64) {
    if interrupt.came() {
        let at = digits(time, 6);
        message(&format!(
            "interrupted at {at} s: the answer is of the run up to there"
        ));
    }
}

/// Parser of a flag.
fn seconds(text: &str) -> Result<f64, QuantityError> {
    Quantity::RUN.parse(text)
}

/// Parser of a flag.
fn step(text: &str) -> Result<f64, QuantityError> {
    Quantity::STEP.parse(text)
}

/// Parser of a flag.
fn robots(text: &str) -> Result<NonZeroUsize, String> {
    const MOST: usize = 100_000;
    text.trim()
        .parse::<NonZeroUsize>()
        .ok()
        .filter(|count| count.get() <= MOST)
        .ok_or_else(|| format!("must be a whole number from 1 to {MOST}"))
}
