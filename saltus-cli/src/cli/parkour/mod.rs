//! `saltus parkour`: plans for courses of the one-leg hopper on a boom.

mod hopper;
mod scene;

use std::path::PathBuf;

use clap::Args;
use saltus::planner::course::{Answer, Course, Plan, Settings, plan};
use saltus::planner::parkour::{Hopper, Takeoff};
use serde_json::{Value, json};

use super::common::{OutputFlags, PlotOption};
use super::{Status, limits};
use crate::error::{CliError, cut};
use crate::input;
use crate::output::{self, Cell, Format, Table};
use crate::plot::Drawing;
use crate::plot::hops::Hops;
use crate::progress::Progress;

/// Plan the jumps of a one-leg hopper over courses of obstacles
#[derive(Args, Debug)]
#[command(after_help = "`saltus parkour --help` explains the files.", after_long_help = LONG_HELP)]
pub(crate) struct Parkour {
    /// JSON file with the courses
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Plan this course alone; may be repeated
    #[arg(long = "course", value_name = "ID")]
    chosen: Vec<String>,

    /// Robot: the hopper of the problem set, of which --set overrides parameters
    #[arg(long, value_name = "NAME", default_value = hopper::NAME, help_heading = "Robot and output")]
    robot: String,

    /// Override a parameter of the hopper, as in gravity_m_s2=8.0665; may be repeated
    #[arg(
        long = "set",
        value_name = "KEY=VALUE",
        help_heading = "Robot and output"
    )]
    overrides: Vec<String>,

    #[command(flatten)]
    plot: PlotOption,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus parkour instances.json --out plans.json
  saltus parkour instances.json --set greatest_speed_m_s=3 --format text
  saltus parkour instances.json --course static-08 --plot course.svg

For each course, the jumps' launch angle, launch speed and flight time are chosen so that the total \
flight time is least.

FILE: {\"instances\": [{\"id\": NAME, \"start_x_m\": …, \"start_height_m\": …, \"jumps\": COUNT, \
\"goal_x_m\": …, \"obstacles\": [{\"center_x_m\": …, \"width_m\": …, \"height_m\": …}], \"no_landing\": \
[{\"center_x_m\": …, \"width_m\": …}]}]}. Other keys are ignored.

JSON: {\"plans\": [{\"id\": NAME, \"flight_time_s\": […], \"launch_speed_m_s\": […], \
\"launch_angle_rad\": […], \"total_flight_time_s\": …, \"foot_x_m\": […], \"landing_x_m\": […], \
\"proven\": whether no plan is faster}], \"without_plan\": [{\"id\": NAME, \"status\": infeasible or \
undecided, \"nearest\": [{\"jump\": …, \"limit\": …, \"amount_m\": …}]}]}: the limits by which the \
nearest course with a plan differs, and by how much. Jumps and obstacles are counted from 1.

CSV columns, one row for each jump: course and jump (counted from 1), flight_time_s, launch_speed_m_s, \
launch_angle_rad, foot_x_m, landing_x_m.

Parameters for --set: gravity_m_s2, least_speed_m_s, greatest_speed_m_s, least_angle_rad, \
greatest_angle_rad, least_time_s, greatest_time_s, clearance_m, edge_margin_m.

The exit code is 1 if a course has no plan.";

const COLUMNS: &[&str] = &[
    "course",
    "jump",
    "flight_time_s",
    "launch_speed_m_s",
    "launch_angle_rad",
    "foot_x_m",
    "landing_x_m",
];

impl Parkour {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.output.ready(&self.plot)?;
        let hopper = hopper::resolve(&self.robot, &self.overrides)?;
        let courses = self.courses()?;
        let progress = Progress::new("courses", courses.len());
        let mut answers = Vec::with_capacity(courses.len());
        for course in &courses {
            let answer = plan(&hopper, course, &Settings::default());
            answers.push(answer.map_err(|error| CliError::content(self.file.display(), error))?);
            progress.advance(1);
        }
        drop(progress);
        let answers: Vec<(&Course, Answer)> = courses.iter().zip(answers).collect();
        let report = match self.output.format() {
            Format::Json => json(&answers, &hopper),
            Format::Csv => table(&answers, &hopper).csv(),
            Format::Text => text(&answers, &hopper),
        };
        let drawing = || Ok(Drawing::Hops(scene::hops(&answers, &hopper)));
        self.output.write_with_plot(report, &self.plot, drawing)?;
        let all = answers
            .iter()
            .all(|(_, answer)| matches!(answer, Answer::Plan(_)));
        Ok(if all { Status::Done } else { Status::No })
    }
}

impl Parkour {
    /// The courses to plan.
    fn courses(&self) -> Result<Vec<Course>, CliError> {
        input::note(&self.file);
        input::spared()?;
        let mut courses = saltus::parkour::load(&self.file)?;
        if let Some(id) = self
            .chosen
            .iter()
            .find(|id| courses.iter().all(|course| course.id != **id))
        {
            let file = self.file.display();
            return Err(CliError::flag(
                "--course",
                cut(id),
                format!("the id of a course in {file}"),
            ));
        }
        courses.retain(|course| self.chosen.is_empty() || self.chosen.contains(&course.id));
        if self.plot.is_set() && courses.len() > Hops::MOST {
            let allowed = format!(
                "used with {} courses at most, not {}: choose some with --course",
                Hops::MOST,
                courses.len()
            );
            return Err(CliError::flag("--plot", "", allowed));
        }
        Ok(courses)
    }
}

fn launches(plan: &Plan, hopper: &Hopper) -> Vec<Takeoff> {
    plan.jumps.iter().map(|jump| hopper.launch(jump)).collect()
}

/// A number of jumps in words.
fn jumps(count: usize) -> String {
    format!("{count} {}", if count == 1 { "jump" } else { "jumps" })
}

fn total_time(launches: &[Takeoff]) -> f64 {
    launches.iter().map(|launch| launch.flight_time).sum()
}

fn json(answers: &[(&Course, Answer)], hopper: &Hopper) -> String {
    let plans: Vec<Value> = answers
        .iter()
        .filter_map(|(course, answer)| plan_json(course, answer, hopper))
        .collect();
    let without: Vec<Value> = answers
        .iter()
        .filter_map(|(course, answer)| nearest_json(course, answer))
        .collect();
    output::json(&json!({ "plans": plans, "without_plan": without }))
}

fn plan_json(course: &Course, answer: &Answer, hopper: &Hopper) -> Option<Value> {
    let Answer::Plan(plan) = answer else {
        return None;
    };
    let launches = launches(plan, hopper);
    let column = |key: fn(&Takeoff) -> f64| launches.iter().map(key).collect::<Vec<f64>>();
    Some(json!({
        "id": course.id,
        "flight_time_s": column(|launch| launch.flight_time),
        "launch_speed_m_s": column(|launch| launch.speed),
        "launch_angle_rad": column(|launch| launch.angle),
        "total_flight_time_s": total_time(&launches),
        "foot_x_m": plan.jumps.iter().map(|jump| jump.foot).collect::<Vec<f64>>(),
        "landing_x_m": plan.jumps.iter().map(|jump| jump.landing).collect::<Vec<f64>>(),
        "proven": plan.complete,
    }))
}

fn nearest_json(course: &Course, answer: &Answer) -> Option<Value> {
    let (status, gives) = match answer {
        Answer::Plan(_) => return None,
        Answer::Infeasible(relief) => ("infeasible", relief.gives.as_slice()),
        Answer::Undecided { .. } => ("undecided", &[][..]),
    };
    Some(json!({ "id": course.id, "status": status, "nearest": limits::json(gives) }))
}

fn table(answers: &[(&Course, Answer)], hopper: &Hopper) -> Table {
    let mut table = Table::new(COLUMNS);
    for (i, (_, answer)) in answers.iter().enumerate() {
        let Answer::Plan(plan) = answer else { continue };
        for (k, (jump, launch)) in plan.jumps.iter().zip(launches(plan, hopper)).enumerate() {
            let mut row = vec![Cell::Count(i + 1), Cell::Count(k + 1)];
            let numbers = [
                launch.flight_time,
                launch.speed,
                launch.angle,
                jump.foot,
                jump.landing,
            ];
            row.extend(numbers.map(Cell::from));
            table.push(row);
        }
    }
    table
}

fn text(answers: &[(&Course, Answer)], hopper: &Hopper) -> String {
    let count = answers.len();
    let mut lines = vec![format!(
        "{}: {count} {}",
        hopper::NAME,
        if count == 1 { "course" } else { "courses" }
    )];
    for (course, answer) in answers {
        lines.push(match answer {
            Answer::Plan(plan) => {
                let total = total_time(&launches(plan, hopper));
                format!(
                    "  {:<16} {}, {total:.4} s in flight",
                    course.id,
                    jumps(plan.jumps.len())
                )
            }
            Answer::Infeasible(relief) => {
                format!(
                    "  {:<16} infeasible; {}",
                    course.id,
                    limits::text(&relief.gives, course)
                )
            }
            Answer::Undecided { nodes, .. } => {
                format!("  {:<16} undecided after {nodes} nodes", course.id)
            }
        });
    }
    lines.join("\n") + "\n"
}
