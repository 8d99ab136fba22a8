//! Plans as rows, as JSON and in words.

use saltus::Robot;
use saltus::planner::course::Span;
use saltus::planner::{Check, CrossingAnswer, CrossingPlan, PlannedJump};
use serde_json::{Value, json};

use super::course::ANYWHERE;
use crate::cli::common::shown;
use crate::cli::limits;
use crate::output::{self, Cell, Table, digits};

const COLUMNS: &[&str] = &[
    "jump",
    "omega_rad_s",
    "phi0_rad",
    "alpha_f_rad",
    "valve_open_s",
    "foot_x_m",
    "foot_y_m",
    "apex_m",
    "land_x_m",
    "land_y_m",
    "land_sd_m",
    "friction_needed",
    "holds",
];

const SHOWN: &[(&str, &str, &str)] = &[
    ("jump", "jump", ""),
    ("omega_rad_s", "ω", "rad/s"),
    ("alpha_f_rad", "α_f", "rad"),
    ("valve_open_s", "valve open", "s"),
    ("foot_x_m", "foot", "m"),
    ("apex_m", "apex", "m"),
    ("land_x_m", "landing", "m"),
    ("land_y_m", "at height", "m"),
    ("land_sd_m", "± landing", "m"),
    ("friction_needed", "friction", "needed"),
    ("holds", "holds", ""),
];

/// One row for each jump; none without a plan.
pub(super) fn table(answer: &CrossingAnswer, robot: &Robot) -> Table {
    let mut table = Table::new(COLUMNS);
    if let CrossingAnswer::Plan(plan) = answer {
        for (i, jump) in plan.jumps.iter().enumerate() {
            table.push(row(i, jump, &plan.checks, robot));
        }
    }
    table
}

fn row(i: usize, planned: &PlannedJump, checks: &[Check], robot: &Robot) -> Vec<Cell> {
    let launch = &planned.jump.launch;
    let holds = checks.iter().filter(|check| check.jump == i).all(Check::holds);
    let mut row = vec![Cell::Count(i + 1)];
    row.extend([launch.rate, launch.lean, launch.firing_angle].map(Cell::from));
    row.push(robot.leg.drive.has_valve().then_some(launch.valve_open).into());
    row.extend(planned.foot.map(Cell::from));
    row.push(planned.jump.apex().map(|apex| planned.foot[1] + apex).into());
    row.extend(planned.landing.map(Cell::from));
    row.push(Some(planned.deviation).filter(|d| *d > 0.0).into());
    row.push(planned.friction_needed.into());
    row.push(Cell::Flag(holds));
    row
}

fn status(answer: &CrossingAnswer) -> &'static str {
    match answer {
        CrossingAnswer::Plan(plan) if plan.is_verified() => "verified",
        CrossingAnswer::Plan(_) => "not-verified",
        CrossingAnswer::Infeasible(_) => "infeasible",
        CrossingAnswer::Undecided { .. } => "undecided",
    }
}

/// The document.
pub(super) fn json(answer: &CrossingAnswer, robot: &Robot, file: &str) -> String {
    let (cost, checks) = match answer {
        CrossingAnswer::Plan(plan) => (Some(plan.search.cost), plan.checks.iter().map(check_json).collect()),
        _ => (None, Vec::new()),
    };
    let nearest = match answer {
        CrossingAnswer::Infeasible(relief) => limits::json(&relief.gives),
        _ => Vec::new(),
    };
    output::json(&json!({
        "command": "plan",
        "robot": robot.name,
        "course": file,
        "status": status(answer),
        "cost": cost,
        "jumps": table(answer, robot).json(),
        "checks": checks,
        "nearest": nearest,
    }))
}

/// Numbers that are not finite, no limit among them, are null.
fn check_json(check: &Check) -> Value {
    json!({
        "jump": check.jump + 1,
        "what": check.what,
        "value": check.value,
        "least": check.allowed.low,
        "greatest": check.allowed.high,
        "holds": check.holds(),
    })
}

/// The plan in words.
pub(super) fn text(answer: &CrossingAnswer, robot: &Robot, file: &str) -> String {
    let title = format!("{}: plan for {file}: {}\n", robot.name, status(answer));
    match answer {
        CrossingAnswer::Plan(plan) => {
            title + &table(answer, robot).text(&shown(SHOWN, robot)) + &checks_text(plan)
        }
        CrossingAnswer::Infeasible(relief) => title + &format!("  {}\n", limits::text(&relief.gives)),
        CrossingAnswer::Undecided { nodes } => title + &format!("  no plan was found within {nodes} nodes\n"),
    }
}

fn checks_text(plan: &CrossingPlan) -> String {
    let line = |check: &Check| {
        let sign = if check.holds() { "holds" } else { "FAILS" };
        let (value, allowed) = (digits(check.value, 4), allowed(check.allowed));
        format!("  {sign}  jump {}: {} {value}, {allowed}\n", check.jump + 1, check.what)
    };
    plan.checks.iter().map(line).collect()
}

fn allowed(span: Span) -> String {
    // What the course leaves open spans all that the planner takes.
    let limits = |x: f64| x.abs() < ANYWHERE.high;
    match (limits(span.low), limits(span.high)) {
        (true, true) => format!("allowed from {} to {}", digits(span.low, 4), digits(span.high, 4)),
        (true, false) => format!("allowed from {}", digits(span.low, 4)),
        (false, true) => format!("allowed up to {}", digits(span.high, 4)),
        (false, false) => "no limit".into(),
    }
}
