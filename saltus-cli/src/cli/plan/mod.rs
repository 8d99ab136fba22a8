//! `saltus plan`: the rolling robot over a course of obstacles.

mod report;
pub(crate) mod scene;

use std::ops::ControlFlow;
use std::path::PathBuf;

use clap::Args;
use saltus::Robot;
use saltus::on_plant::{Crossed, OnPlant, for_crossing};
use saltus::planner::CrossingAnswer;
use saltus::planner::course::Standing;
use saltus::robot::Errors;
use saltus::robust::{self, Robust};
use saltus::verify::Verification;

use super::Status;
use super::common::{Common, ErrorFlags, PlantFlags};
use crate::error::CliError;
use crate::input;
use crate::interrupt::Interrupt;
use crate::output::{self, Format, digits};
use crate::progress::Progress;

use report::{Hold, Report};

/// Plan firing angles and valve times for a course of obstacles
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus plan --help` explains the files.",
    after_long_help = LONG_HELP,
    mut_arg("share", |share| share.help("Plan with margins by which this share of jumps with errors drawn holds in the multi-body simulation, as in 0.95")),
    mut_arg("samples", |samples| {
        samples
            .requires("share")
            .value_parser(clap::value_parser!(u32).range(20..=100_000))
            .help("Runs with errors drawn from the robot's [errors], three times: to find margins, to choose them, and to count [default: 200]")
    }),
    mut_arg("seed", |seed| seed.requires("share")),
    mut_arg("friction", |friction| friction.requires("share"))
)]
pub(crate) struct Plan {
    /// TOML file with the course
    #[arg(value_name = "COURSE.toml")]
    course: PathBuf,

    #[command(flatten)]
    plant: PlantFlags,

    #[command(flatten)]
    errors: ErrorFlags,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus plan box.toml
  saltus plan box.toml --plant rats-boom --share 0.95 --friction 0.5:1:6
  saltus plan box.toml --set leg.supply_pressure_gauge_psi=140 --out plan.json --plot plan.svg

A course, here one jump over a low box:
  approach_rate_rad_s = 5.0    # or a list, one for each jump
  target_x_m = 0.9
  clearance_m = 0.02
  [[obstacle]]
  front_x_m = 0.4
  width_m = 0.05
  height_m = 0.1

Keys: jumps [1], start_x_m [0], start_height_m [0], approach_rate_rad_s, target_x_m (where the last \
landing must be, to a fifth of the wheel's radius), goal_from_x_m and goal_to_x_m (where it must be; target_x_m is then \
where it should be, their middle unless given), start_lean_rad [the firing angle], firing_angle_rad [[-0.6, 0.8]], valve_open_s [[0.02, 0.1]], \
roll_m (from a landing to the next foothold) [0], clearance_m of the wheel over obstacles [0], \
edge_margin_m (least distance of a landing from the ends of its ground: obstacles, areas to avoid, its \
zone, the goal; the wheel's rim stays clear of an obstacle beside it too) [0.005], margin_sigmas (standard \
deviations of the landing that are kept besides) [2], leg_out_s (how long after lift-off the leg is out and \
must stay clear too) [0], friction_coefficient [the foot holds], deviation_weight (1/m², of the last landing less the target; 0: anywhere will do) [100] and effort_weight (1/s²) [1] of the cost. \
Tables: [[obstacle]] front_x_m, width_m, height_m; [[land]] from_x_m, to_x_m, jump (where that jump must \
land); [[avoid]] from_x_m, to_x_m (where none may). Units are those of robot files: height_mm, front_x_cm, \
start_lean_deg. approach_rate_rad_s holds one number, or a list with one for each jump. A landing is where \
the wheel's centre comes down to the wheel's radius above the surface; every x counts from the course's \
origin. Jumps go forward: none lands behind the first foothold. After a landing the robot rolls roll_m on the same \
ground to its next foothold.

The search ends when no plan can be cheaper by more than 5e-5, or at its limits, or at Ctrl-C with the best \
plan so far; the answer says by how much its cost may be above the least one.

With --plant the plan holds on that robot, with its boom, the masses of its legs and its ground: the \
multi-body simulation flies the plan, corrects the planar model, and the plan is made again, until the two \
agree to a micrometre. The report is then of the plan as simulated. `saltus verify --correct` flies it with \
errors drawn.

With --share the plan holds for that share of runs with errors drawn from the robot's [errors], in the \
multi-body simulation of --plant (or of the robot itself), on the friction coefficients of --friction in \
turn. With one coefficient the plan is made for that ground, with several for the robot's own; the answer \
says where it lands on each. margin_sigmas counts no more: the simulated scatter says what clearance_m, edge_margin_m and \
friction_coefficient need beside their limits. Draws that made neither margins nor choice then tell how \
often the plan holds; it is enough if that is at most two binomial standard deviations below the share. \
Each demand has a margin of its own: of the demands that block a plan the margin is halved back, and a \
margin that is more than enough gives way to the others. Where the share cannot be had, the answer is the plan \
that holds most often, the least margins that no plan was found with, and what blocks greater ones. A foot may slip where --friction lets it; with friction_coefficient in the course no stance may need more.

CSV columns, one row for each jump: jump, omega_rad_s, phi0_rad, alpha_f_rad, valve_open_s, foot_x_m, \
foot_y_m, apex_m (above the ground), land_x_m, land_y_m (surface), land_sd_m (standard deviation from the \
robot's [errors]), target_x_m and off_target_m (landing less target; last jump), friction_needed, holds \
(true or false: whether all limits of the jump hold in the planar model).

JSON: {\"command\": \"plan\", \"robot\": NAME, \"course\": FILE, \"status\": \
holds-in-the-planar-model, fails-in-the-planar-model (with --plant: holds-on-the-plant, fails-on-the-plant), misses-the-target, infeasible or undecided, \"cost\": …, \"bound\" (no plan \
costs less), \"complete\" (whether the search ran to its end), \"interrupted\", \"obstacles\": [{\"front_x_m\", \"width_m\", \"height_m\"}], \"jumps\": [{the columns}], \"checks\": [{\"jump\", \"what\", \
\"value\", \"least\", \"greatest\" (null: no limit), \"holds\"}], \"nearest\": [{\"jump\", \"limit\", \
\"amount_m\" (of friction: \"amount\")}], \"try_jumps\"}: the limits by which the nearest course with a plan differs (an obstacle is lower \
by the amount, a ground is longer, the goal moves, forward if positive, friction is more), and with how many jumps there is a plan. fails-in-the-planar-model: flown ten times finer \
than in the search, the plan misses a limit.

With --plant: \"plant\": NAME, \"correction\": {\"simulated_jumps\", \"miss_m\" (of the last ones), \"is_exact\" (the \
plant jumps as the planar model says)}, and \"hold\" (null without --share): {\"share_asked\", \"share\", \"runs\", \
\"is_enough\", \"clearance_margin_m\", \"landing_margin_m\", \"friction_margin\", \"clearance_margin_refused_m\", \"landing_margin_refused_m\", \"friction_margin_refused\" \
(null: none was), \"missed_most\", \
\"landings\" (without errors, on each ground: {\"friction\", \"land_x_m\"}), \"blocked_by\"}.

The exit code is 1 unless there is a plan that lands on the target or in the goal and holds in the planar model (with --plant: on that robot; with --share: that often) and the search was not interrupted.";

impl Plan {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.common.ready()?;
        let (robot, plant) = match self.errors.share {
            Some(_) => {
                let (robot, plant) = self.plant.always(&self.common.robot)?;
                (robot, Some(plant))
            }
            None => self.plant.on_plant(&self.common.robot)?,
        };
        let crossing = input::course(&self.course)?;
        let file = self.course.display().to_string();
        let runs = self.errors.share.map(|share| Verification {
            tolerance: Some(f64::INFINITY),
            ..self.errors.verification(200, share)
        });
        let interrupt = Interrupt::listen()?;
        let crossed = {
            let progress = Progress::new("plan", 0);
            let watch = |standing: &Standing| {
                progress.note(&note(standing));
                if interrupt.came() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            };
            match plant.as_ref().zip(runs.as_ref()) {
                Some((plant, runs)) => robust::plan(&robot, plant, &crossing, runs, &watch)
                    .map_err(|error| CliError::content(&file, error))
                    .map(|robust| held(robust, runs, plant.robot()))?,
                None => for_crossing(robot, plant.as_ref(), &crossing, &watch)
                    .map_err(|error| CliError::content(&file, error))
                    .map(|crossed| (crossed, None))?,
            }
        };
        let (crossed, hold) = crossed;
        let Crossed {
            planner,
            answer,
            correction,
        } = crossed;
        let is_enough = hold.as_ref().is_none_or(Hold::is_enough);
        let robot = planner.robot();
        let report = Report {
            answer: &answer,
            crossing: &crossing,
            interrupted: interrupt.came(),
            plant: plant.as_ref().map(OnPlant::robot).zip(correction),
            hold,
        };
        let is_missed = report.off_demanded(robot).is_some();
        let has_plan = matches!(answer, CrossingAnswer::Plan(_)) && !is_missed;
        if !has_plan && self.common.format() == Format::Csv {
            // A table says nothing of why.
            output::message(report.text(robot, &file).trim_end());
        }
        let report = match self.common.format() {
            Format::Csv => report.table(robot).csv(),
            Format::Json => report.json(robot, &file),
            Format::Text => report.text(robot, &file),
        };
        let drawing = || Ok(scene::scene(&answer, &crossing, &planner, &file));
        self.common.write(report, drawing)?;
        match answer {
            CrossingAnswer::Plan(plan)
                if plan.holds() && is_enough && !is_missed && !interrupt.came() =>
            {
                Ok(Status::Done)
            }
            _ => Ok(Status::No),
        }
    }
}

/// The best plan, and how often it holds; without a plan the answer that says why.
fn held(robust: Robust, runs: &Verification, plant: &Robot) -> (Crossed, Option<Hold>) {
    match robust {
        Robust::Plan { held, blocked } => {
            let hold = Hold {
                asked: runs.share,
                share: held.share,
                runs: runs.samples,
                margins: held.margins,
                refused: held.refused,
                missed: held.missed,
                grounds: held.grounds,
                has_errors: plant.errors != Errors::default(),
                blocked,
            };
            (held.crossed, Some(hold))
        }
        Robust::None(crossed) => (crossed, None),
    }
}

/// How far the search is, for the line of progress.
fn note(standing: &Standing) -> String {
    let share = format!("{:.0} % of the search's limit", 100.0 * standing.share);
    if standing.gap.is_finite() {
        format!(
            "{share}, best plan at most {} above the least cost",
            digits(standing.gap, 2)
        )
    } else {
        format!("{share}, no plan yet")
    }
}
