//! `saltus verify`: plans, laws and tables in the multi-body simulation.

mod advice;
mod animation;
mod context;
mod drawing;
mod load;
mod report;
mod subject;
mod table_file;

pub(crate) use table_file::check_robot;

use std::path::PathBuf;

use clap::Args;
use saltus::on_plant::PlantError;
use saltus::verify::{Outcome, Plant, Starts, Verdict, Verification};

use self::subject::SubjectFlags;
use super::Status;
use super::common::{Common, ErrorFlags, PlantFlags, page_file};
use super::recorded::{Beside, McapOption};
use crate::error::CliError;
use crate::output::{Format, reachable};
use crate::progress::Progress;
use crate::quantity;

/// Verify a plan, a law or a table in the multi-body simulation, with foot slip
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus verify --help` explains the output.",
    after_long_help = LONG_HELP,
    mut_arg("share", |share| share.help("Share of the runs with drawn errors that have to pass; with --correct the plan has margins for it [default: 0.9, without margins]")),
    mut_arg("samples", |samples| samples.help("Runs with errors drawn from the robot's [errors], beside those without: a run is all jumps of a course, or one jump of a law or a table [default: 100]"))
)]
pub(crate) struct Verify {
    #[command(flatten)]
    subject: SubjectFlags,

    #[command(flatten)]
    plant: PlantFlags,

    /// Start each jump of a course at its planned foothold, in place of where the jump before it
    /// landed
    #[arg(long, help_heading = "What is verified")]
    restart: bool,

    /// How far (m) a landing may be from where it is wanted [default: a fifth of the wheel's radius]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = quantity::extent, help_heading = "What passes")]
    tolerance: Option<f64>,

    /// Least distance (m) in flight between wheel and boxes [default: clearance_m of the course; a
    /// law or a table touches no box]
    #[arg(long, value_name = "LENGTH", allow_negative_numbers = true, value_parser = quantity::height, help_heading = "What passes")]
    clearance: Option<f64>,

    #[command(flatten)]
    errors: ErrorFlags,

    /// Size of the drawn errors, as a multiple of the robot's [errors]
    #[arg(long, value_name = "FACTOR", allow_negative_numbers = true, value_parser = quantity::factor, default_value = "1")]
    scatter: f64,

    /// Write a page that plays the jumps in a browser: those without errors, and the worst of the
    /// others
    #[arg(long, value_name = "FILE.html", value_parser = page_file, help_heading = "Robot and output")]
    animate: Option<PathBuf>,

    #[command(flatten)]
    mcap: McapOption,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus verify box.toml --friction 0.3:1:8 --plot verify.svg --animate verify.html
  saltus verify box.toml --plant rats-boom --correct
  saltus verify box.toml --plant rats-boom --correct --share 0.95 --friction 0.3:1:8
  saltus verify --law=-0.146,0.704 --distance 1 --omega 3:6:7 --plant rats-boom
  saltus table --omega 3:6:31 --distance 0.8 --out table.csv
  saltus verify table.csv --plant rats-boom --samples 200 --out verified.csv

What is verified: a course (its plan is made first, as `saltus plan` does), a table that `saltus table` \
wrote as CSV (between its rates it is linear; its columns say the landing height, start lean and valve \
time, the robot must be the one that it was made for, and every row must land where it says), or a law α_f = A ω + B.

Each jump is simulated with the whole robot in space: mass of the legs, boom, end stops, contact and slip \
of the foot, all as the robot file says. A run is all jumps of a course, or one jump of a law or a table. \
A jump of a course starts where the jump before it really landed, so that errors add up; with --restart it \
starts at its planned foothold. First come the runs without errors: the course, every row of the table or \
every rate of --omega, on every friction coefficient. Then come --samples runs with errors: the true \
approach rate, firing angle and valve time of each jump and the supply pressure of each run differ from \
what is measured and commanded, with the standard deviations of the robot's [errors]. The approach rate of \
a law or a table is drawn evenly from its range. The friction coefficients take turns.

A jump passes if it meets each demand:
  touchdown  the wheel comes down to its landing height
  ground     landing and next foothold are on a surface of the planned height
  edge       the landing keeps edge_margin_m from the edges of boxes
  avoid      the landing is in no [[avoid]]
  zone       the landing is in the [[land]] zone of its jump
  goal       the last landing is from goal_from_x_m to goal_to_x_m
  tolerance  the landing is within --tolerance of where it is wanted: the plan's landing, or target_x_m of a course \
without a goal; the table's or --distance
  clearance  in flight wheel and fired leg (while it is out, leg_out_s) keep clearance_m, or --clearance, from boxes
  stance     until lift-off the wheel touches no box
  friction   the foot needs no more than friction_coefficient
A law and a table demand touchdown, tolerance and no touching of the --obstacle. A run passes if all its \
jumps do. It ends at a jump that leaves no foothold (no touchdown, no ground, in an [[avoid]]); the jumps \
after that are `not-started`. The verification passes if every run without errors passes, and of the \
others --share do. If it fails, the report says which demand is missed, by how much, in which jumps and \
how often, and what to do.

A plan for rats-planar, the default robot, fails on --plant rats-boom by about 60 mm: --correct plans for \
the robot that jumps. A table that was made with --plant is verified on that robot.

CSV columns, one row for each jump of each run: run, errors (true or false: whether any were drawn), jump \
(its number in the plan; empty without a course), omega_rad_s (measured), omega_true_rad_s, alpha_f_rad (commanded), \
valve_open_s, friction_coefficient (empty: the robot's own), outcome (landed, early-lift-off, no-lift-off, stalled, \
simulation-failed or not-started), foot_x_m, foot_planned_x_m, apex_m (above the course's ground), \
apex_planned_m, apex_error_m, land_x_m, land_planned_x_m, land_error_m (simulated less planned), \
land_wanted_x_m, miss_m (simulated less wanted), clearance_m (least distance between wheel and boxes), \
slip_start_s (time at which the foot first slips along the travel), slip_m and slip_across_m (net until \
lift-off), friction_needed (greatest |force along the travel|/normal force), normal_least_n, \
energy_residual_j (what the energy ledger leaves unexplained); for each demand DEMAND_holds (true or \
false; empty: not demanded) and DEMAND_margin_m (how far inside its limit, negative: outside; of friction friction_margin, without unit); passes, \
reason (what is missed). Places x are along the course; for a law or a table they are distances from the foot.

JSON: {\"command\": \"verify\", \"robot\": NAME, \"plant\": NAME, \"subject\": …, \"seed\": …, \
\"starts\": …, \"tolerance_m\": …, \"share\": …, \"passes\": true or false, \"failures\": [{\"errors\", \
\"jump\", \"demand\", \"jumps\" (that miss it), \"of\" (that were started), \"margin_least\", \"worst\" (in \
words)}], \"advice\": [what to do], \"groups\": [{\"errors\", \"friction_coefficient\", \"runs\", \
\"runs_passed\", \"jumps\", \"passed\", \"landed\", \"slipped\", \"simulation_failed\", \"not_started\", \
\"land_error_mean_m\", \"land_error_sd_m\", \"land_error_greatest_m\", \"miss_mean_m\", \"miss_sd_m\", \"miss_rms_m\", \"miss_greatest_m\", \
\"apex_error_mean_m\", \"apex_error_greatest_m\", \"slip_greatest_m\", \"friction_needed_greatest\", \"normal_least_n\", \
\"energy_residual_greatest_j\", \"clearance_least_m\"}], \"rows\": [{the columns}]}.

--mcap writes the jumps that --animate shows, one after the other, each from a whole second on; docs/viewers.md lists the topics.

The exit code is 1 if the verification fails, and if no plan crosses the course: then nothing is drawn. A jump that cannot be simulated \
fails like any other.";

/// Share that has to pass, unless another is given.
const SHARE: f64 = 0.9;
/// Error that the simulation makes in each step, relative to 1 + |y|.
const ACCURACY: f64 = 1e-9;
/// Fewest runs by which margins are made.
const LEAST_DRAWN: usize = 200;

impl Verify {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        self.mcap.ready()?;
        reachable("--animate", self.animate.as_deref())?;
        let robot = self.common.robot.robot()?;
        let plant = Plant::new(self.plant()?, ACCURACY);
        plant
            .rig()
            .map_err(|error| CliError::content(&plant.robot().name, error))?;
        let (planned, jumps) = (robot.body.radius, plant.robot().body.radius);
        if planned != jumps {
            let error = PlantError::Radius {
                plant: jumps,
                planned,
                robot: robot.name.clone(),
            };
            return Err(CliError::content(&plant.robot().name, error));
        }
        let how = self.verification();
        let margins = self.errors.share.map(|_| Verification {
            // Other draws than those that the plan is verified by.
            seed: !how.seed,
            samples: how.samples.max(LEAST_DRAWN),
            ..how.clone()
        });
        let loaded = load::load(&self.subject, robot.clone(), &plant, margins.as_ref())?;
        let Some(loaded) = loaded else {
            let report = match self.common.format() {
                Format::Csv => report::rows(&[], &robot).csv(),
                Format::Json => report::no_plan_json(&robot, &plant, &self.subject.file(), &how),
                Format::Text => report::NO_PLAN.to_owned(),
            };
            self.common.write_report(report)?;
            return Ok(Status::No);
        };
        let (subject, planner) = (&loaded.subject, &loaded.planner);
        if self.restart && !subject.is_plan() {
            return Err(CliError::flag(
                "--restart",
                "",
                "left out where there is no course",
            ));
        }
        let trials = how.trials(subject, planner, plant.robot().body.radius)?;
        let progress = Progress::new("runs", trials.len());
        let outcomes = how.fly(&plant, &trials, &|| progress.advance(1));
        drop(progress);
        let verdict = Verdict::of(&outcomes, how.share);
        let scene = context::Context {
            planner,
            plant: &plant,
            title: &loaded.title,
            short_title: self.subject.short(&loaded.title),
            subject,
            for_plant: loaded.for_plant,
            how: &how,
        };
        let report = match self.common.format() {
            Format::Csv => report::rows(&outcomes, &robot).csv(),
            Format::Json => report::json(&outcomes, &verdict, &scene),
            Format::Text => report::text(&outcomes, &verdict, &scene),
        };
        let more = self.beside(&outcomes, &scene)?;
        let drawing = || Ok(drawing::sheet(&outcomes, &verdict, &scene));
        self.common.write_with(report, drawing, more)?;
        Ok(Status::of(verdict.passes))
    }

    /// The page and the recording, where they are asked for.
    fn beside(
        &self,
        outcomes: &[Outcome],
        scene: &context::Context<'_>,
    ) -> Result<Vec<Beside<'_>>, CliError> {
        let mut files = Vec::new();
        if let Some(file) = self.animate.as_deref() {
            let html = animation::html(outcomes, scene)
                .map_err(|error| CliError::content(file.display(), error))?;
            files.push(("--animate", file, html.into_bytes()));
        }
        let (robot, seed) = (scene.plant.robot(), Some(self.errors.seed()));
        let record = |recording: &mut _| animation::record(recording, outcomes, scene);
        files.extend(self.mcap.recorded(robot, seed, record)?);
        Ok(files)
    }

    /// The robot that jumps.
    fn plant(&self) -> Result<saltus::Robot, CliError> {
        match self.plant.robot(&self.common.robot)? {
            Some(plant) => Ok(plant),
            None => self.common.robot.robot(),
        }
    }

    /// How it is verified.
    fn verification(&self) -> Verification {
        Verification {
            starts: if self.restart {
                Starts::Planned
            } else {
                Starts::Chained
            },
            tolerance: self.tolerance,
            clearance: self.clearance,
            scatter: self.scatter,
            ..self.errors.verification(100, SHARE)
        }
    }
}
