//! `saltus plan`: the rolling robot over a course of obstacles.

pub(super) mod course;
mod report;
mod scene;

use std::path::PathBuf;

use clap::Args;
use saltus::Planner;
use saltus::planner::CrossingAnswer;

use super::Status;
use super::common::{Common, PlotOption};
use crate::error::CliError;
use crate::output::Format;
use crate::plot::Drawing;
use crate::progress::Progress;

/// Plan firing angles and valve times for a course of obstacles
#[derive(Args, Debug)]
#[command(after_help = "`saltus plan --help` explains the files.", after_long_help = LONG_HELP)]
pub(crate) struct Plan {
    /// TOML file with the course
    #[arg(value_name = "COURSE.toml")]
    course: PathBuf,

    #[command(flatten)]
    plot: PlotOption,

    #[command(flatten)]
    common: Common,
}

const LONG_HELP: &str = "\
Examples:
  saltus plan box.toml
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
landing should be), goal_from_x_m and goal_to_x_m (where it must be; the target is their middle unless \
given), start_lean_rad [the firing angle], firing_angle_rad [[-0.6, 0.8]], valve_open_s [[0.02, 0.1]], \
roll_m (from a landing to the next foothold) [0], clearance_m of the wheel over obstacles [0], \
edge_margin_m of landings [0], leg_out_s (how long after lift-off the leg is out and must stay clear too) \
[0], friction_coefficient [the foot holds], margin_sigmas (standard deviations that landings keep from \
the ends of their ground) [0], deviation_weight (1/m²) [100] and effort_weight (1/s²) [1] of the cost. \
Tables: [[obstacle]] front_x_m, width_m, height_m; [[land]] from_x_m, to_x_m, jump (where that jump must \
land); [[avoid]] from_x_m, to_x_m (where none may). A landing is where the wheel's centre comes down to \
the wheel's radius above the surface.

CSV columns, one row for each jump: jump, omega_rad_s, phi0_rad, alpha_f_rad, valve_open_s, foot_x_m, \
foot_y_m, apex_m (above the ground), land_x_m, land_y_m (surface), land_sd_m (standard deviation from the \
robot's [errors]), friction_needed, holds (true or false: whether all limits of the jump hold in the full \
model).

JSON: {\"command\": \"plan\", \"robot\": NAME, \"course\": FILE, \"status\": verified, not-verified, \
infeasible or undecided, \"cost\": …, \"jumps\": [{the columns}], \"checks\": [{\"jump\", \"what\", \
\"value\", \"least\", \"greatest\" (null: no limit), \"holds\"}], \"nearest\": [{\"jump\", \"limit\", \
\"amount_m\"}]}: the limits by which the nearest course with a plan differs.

The exit code is 1 unless there is a plan that holds in the full model.";

impl Plan {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        let planner = Planner::new(self.common.planned_robot()?);
        let crossing = course::load(&self.course)?;
        let file = self.course.display().to_string();
        let answer = {
            let _progress = Progress::new("plan", 0);
            planner.cross(&crossing).map_err(|error| CliError::content(&file, error))?
        };
        let robot = planner.robot();
        let report = match self.common.format() {
            Format::Csv => report::table(&answer, robot).csv(),
            Format::Json => report::json(&answer, robot, &file),
            Format::Text => report::text(&answer, robot, &file),
        };
        let drawing = || Ok(Drawing::Scene(scene::scene(&answer, &crossing, &planner, &file)));
        self.common.write_with_plot(report, &self.plot, drawing)?;
        match answer {
            CrossingAnswer::Plan(plan) if plan.is_verified() => Ok(Status::Done),
            _ => Ok(Status::No),
        }
    }
}
