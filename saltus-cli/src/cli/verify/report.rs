//! What a verification found, as text, JSON and CSV.

use std::fmt::Write;

use saltus::Robot;
use saltus::verify::{
    Demand, Failure, Flown, Group, Outcome, Plant, RunJump, Spread, Starts, Verdict, Verification,
};
use serde_json::{Value, json};

use super::advice::advice;
use super::context::Context;
use crate::cli::common::opening;
use crate::output::{self, Column, Table, columns, digits, measured};

/// A jump of a run, and the run's number from 0.
struct Row<'a> {
    run: usize,
    jump: RunJump<'a>,
    robot: &'a Robot,
}

fn columns<'a>() -> [Column<Row<'a>>; 47] {
    columns! {
        "run", "", |row| row.run + 1;
        "errors", "", |row| row.jump.trial.has_errors();
        "jump", "jump", |row| row.jump.stage().surface.map(|_| row.jump.number + 1);
        "omega_rad_s", "ω", |row| row.jump.stage().launch.rate;
        "omega_true_rad_s", "", |row| row.jump.attempt.launch.rate;
        "alpha_f_rad", "α_f", |row| row.jump.stage().launch.firing_angle;
        "valve_open_s", "", |row| opening(row.robot, &row.jump.stage().launch);
        "friction_coefficient", "friction", |row| row.jump.trial.friction;
        "outcome", "outcome", |row| row.jump.attempt.outcome();
        "foot_x_m", "foot", |row| {
            let attempt = row.jump.attempt;
            attempt.was_started().then_some(attempt.foot[0])
        };
        "foot_planned_x_m", "", |row| row.jump.stage().foot[0];
        "apex_m", "apex", |row| row.jump.attempt.apex();
        "apex_planned_m", "planned", |row| row.jump.stage().apex;
        "apex_error_m", "", |row| row.jump.apex_error();
        "land_x_m", "landing", |row| row.jump.attempt.landing();
        "land_planned_x_m", "planned", |row| row.jump.stage().landing;
        "land_error_m", "", |row| row.jump.land_error();
        "land_wanted_x_m", "wanted", |row| row.jump.stage().wanted;
        "miss_m", "", |row| row.jump.miss();
        "clearance_m", "clearance", |row| row.jump.attempt.clearance;
        "slip_start_s", "", |row| row.flown().and_then(|flown| flown.report.slips_at);
        "slip_m", "slip", |row| row.flown().map(|flown| slip(flown.slip()));
        "slip_across_m", "", |row| row.flown().map(|flown| slip(flown.report.slipped[1]));
        "friction_needed", "", |row| row.flown().map(|flown| flown.report.friction_needed);
        "normal_least_n", "", |row| row.flown().map(|flown| flown.report.least_normal);
        "energy_residual_j", "", |row| row.flown().map(|flown| flown.report.residual);
        "touchdown_holds", "", |row| row.holds(Demand::Touchdown);
        "ground_holds", "", |row| row.holds(Demand::Ground);
        "ground_margin_m", "", |row| row.margin(Demand::Ground);
        "edge_holds", "", |row| row.holds(Demand::Edge);
        "edge_margin_m", "", |row| row.margin(Demand::Edge);
        "avoid_holds", "", |row| row.holds(Demand::Avoid);
        "avoid_margin_m", "", |row| row.margin(Demand::Avoid);
        "zone_holds", "", |row| row.holds(Demand::Zone);
        "zone_margin_m", "", |row| row.margin(Demand::Zone);
        "goal_holds", "", |row| row.holds(Demand::Goal);
        "goal_margin_m", "", |row| row.margin(Demand::Goal);
        "tolerance_holds", "", |row| row.holds(Demand::Tolerance);
        "tolerance_margin_m", "", |row| row.margin(Demand::Tolerance);
        "clearance_holds", "", |row| row.holds(Demand::Clearance);
        "clearance_margin_m", "", |row| row.margin(Demand::Clearance);
        "stance_holds", "", |row| row.holds(Demand::Stance);
        "stance_margin_m", "", |row| row.margin(Demand::Stance);
        "friction_holds", "", |row| row.holds(Demand::Friction);
        "friction_margin", "", |row| row.margin(Demand::Friction);
        "passes", "passes", |row| row.jump.attempt.passes();
        "reason", "", |row| row.jump.attempt.reasons().join("; ");
    }
}

/// A row for each jump of each run.
pub(super) fn rows(outcomes: &[Outcome], robot: &Robot) -> Table {
    let row = |(run, outcome)| {
        let jumps = Outcome::jumps(outcome);
        jumps.map(move |jump| Row { run, jump, robot })
    };
    Table::of(&columns(), outcomes.iter().enumerate().flat_map(row))
}

/// A length (m) below which the simulation knows none.
pub(super) const NOTHING: f64 = 1e-9;

fn slip(x: f64) -> f64 {
    if x.abs() < NOTHING { 0.0 } else { x }
}

impl Row<'_> {
    fn flown(&self) -> Option<&Flown> {
        self.jump.attempt.flown()
    }

    fn holds(&self, demand: Demand) -> Option<bool> {
        let judgement = self.jump.attempt.judgement(demand);
        judgement.map(saltus::verify::Judgement::holds)
    }

    fn margin(&self, demand: Demand) -> Option<f64> {
        let judgement = self.jump.attempt.judgement(demand);
        judgement.map(|judgement| judgement.margin)
    }
}

/// What there is to say of a course without a plan.
pub(super) const NO_PLAN: &str = "no plan crosses this course: `saltus plan` says what blocks it, \
    and the nearest that has one\n";

/// A document with the keys of [`json`], for a course without a plan.
pub(super) fn no_plan_json(robot: &Robot, plant: &Plant, file: &str, how: &Verification) -> String {
    output::json(&json!({
        "command": "verify",
        "robot": robot.name,
        "plant": plant.robot().name,
        "subject": file,
        "seed": how.seed,
        "starts": starts(how.starts),
        "tolerance_m": how.tolerance(plant.robot().body.radius),
        "share": how.share,
        "passes": false,
        "failures": [],
        "advice": [NO_PLAN.trim()],
        "groups": [],
        "rows": [],
    }))
}

/// The document.
pub(super) fn json(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> String {
    let is_course = context.subject.is_plan();
    output::json(&json!({
        "command": "verify",
        "robot": context.planner.robot().name,
        "plant": context.plant.robot().name,
        "subject": context.title,
        "seed": context.how.seed,
        "starts": is_course.then(|| starts(context.how.starts)),
        "tolerance_m": context.tolerance(),
        "share": context.how.share,
        "passes": verdict.passes,
        "failures": verdict.failures.iter().map(failure_json).collect::<Vec<_>>(),
        "advice": advice(outcomes, verdict, context),
        "groups": verdict.groups.iter().map(group_json).collect::<Vec<_>>(),
        "rows": rows(outcomes, context.planner.robot()).json(),
    }))
}

fn group_json(group: &Group) -> Value {
    json!({
        "errors": group.errors,
        "friction_coefficient": group.friction,
        "runs": group.runs,
        "runs_passed": group.runs_passed,
        "jumps": group.jumps,
        "passed": group.passed,
        "landed": group.landed,
        "slipped": group.slipped,
        "simulation_failed": group.simulation_failed,
        "not_started": group.not_started,
        "land_error_mean_m": group.land_error.mean,
        "land_error_sd_m": group.land_error.deviation,
        "land_error_greatest_m": group.land_error.greatest,
        "miss_mean_m": group.miss.mean,
        "miss_sd_m": group.miss.deviation,
        "miss_rms_m": group.miss.rms,
        "miss_greatest_m": group.miss.greatest,
        "apex_error_mean_m": group.apex_error.mean,
        "apex_error_greatest_m": group.apex_error.greatest,
        "clearance_least_m": group.clearance,
        "slip_greatest_m": group.slip,
        "friction_needed_greatest": group.friction_needed,
        "normal_least_n": group.least_normal,
        "energy_residual_greatest_j": group.residual,
    })
}

fn failure_json(failure: &Failure) -> Value {
    json!({
        "errors": failure.errors,
        "jump": failure.jump + 1,
        "demand": failure.demand.name(),
        "jumps": failure.count,
        "of": failure.of,
        "margin_least": Some(failure.margin).filter(|margin| margin.is_finite()),
        "worst": failure.worst,
    })
}

/// How the jumps of a course start.
fn starts(starts: Starts) -> &'static str {
    match starts {
        Starts::Chained => "where the jump before lands",
        Starts::Planned => "at the planned footholds",
    }
}

/// The jumps of a plan and of a short table are few enough to be told one by one.
const FEW: usize = 12;

/// For people.
pub(super) fn text(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> String {
    let mut text = format!(
        "{} of {}, in the multi-body simulation of {}\n",
        context.title,
        context.planner.robot().name,
        context.plant.robot().name
    );
    let jumps = context.subject.jumps();
    if jumps > 1 {
        let starts = starts(context.how.starts);
        // Writing to a string does not fail.
        let _ = writeln!(text, "a run is {jumps} jumps; each starts {starts}");
    }
    for errors in [false, true] {
        if let Some(group) = verdict.all(errors) {
            text.push_str(&group_text(group, context));
            text.push_str(&grounds_text(verdict, errors));
        }
    }
    text.push_str(&jumps_text(outcomes, context));
    text + &verdict_text(outcomes, verdict, context)
}

/// The jumps without errors one by one, where they are few.
fn jumps_text(outcomes: &[Outcome], context: &Context<'_>) -> String {
    let robot = context.planner.robot();
    let nominal = outcomes.iter().filter(|o| !o.trial.has_errors());
    let rows = nominal.flat_map(Outcome::jumps);
    let rows: Vec<Row<'_>> = rows
        .map(|jump| Row {
            run: 0,
            jump,
            robot,
        })
        .collect();
    if rows.len() > FEW {
        return String::new();
    }
    let place = if context.subject.is_plan() {
        "jump foot_x_m "
    } else {
        ""
    };
    let table = Table::of(&columns(), rows).text_of(&format!(
        "{place}omega_rad_s alpha_f_rad friction_coefficient outcome apex_m apex_planned_m land_x_m \
         land_planned_x_m land_wanted_x_m clearance_m slip_m passes"
    ));
    format!("\nwithout errors, jump by jump\n{table}")
}

/// Pass or fail, what is missed, and what to do.
fn verdict_text(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> String {
    let run = if context.subject.jumps() > 1 {
        "run"
    } else {
        "jump"
    };
    let counts = [false, true].into_iter().filter_map(|errors| {
        let group = verdict.all(errors)?;
        let with = if errors { "with" } else { "without" };
        let needed = if errors {
            format!(
                " ({} % have to: --share)",
                digits(100.0 * context.how.share, 4)
            )
        } else {
            " (all have to)".into()
        };
        Some(format!(
            "{} of {} {run}s {with} errors pass{needed}",
            group.runs_passed, group.runs
        ))
    });
    let word = if verdict.passes { "PASS" } else { "FAIL" };
    let mut text = format!("\n{word}: {}\n", counts.collect::<Vec<_>>().join(", "));
    for failure in &verdict.failures {
        let _ = writeln!(text, "  {}", failure_text(failure, context));
    }
    if !verdict.passes {
        for sentence in advice(outcomes, verdict, context) {
            let _ = writeln!(text, "  → {sentence}");
        }
    }
    let _ = writeln!(text, "  demanded: {}", demands_text(outcomes, context));
    text
}

/// What is missed, by whom, how often and by how much at worst.
pub(super) fn failure_text(failure: &Failure, context: &Context<'_>) -> String {
    let with = if failure.errors {
        "with errors"
    } else {
        "without errors"
    };
    let jump = match context.subject.jumps() {
        1 => String::new(),
        _ => format!("jump {}, ", failure.jump + 1),
    };
    let worst = if failure.count > 1 { ", at worst" } else { "" };
    let set_by = set_by(failure.demand);
    let set_by = set_by.map_or_else(String::new, |name| format!(" ({name})"));
    format!(
        "{}: {jump}{with}, {} of {}{worst}: {}{set_by}",
        failure.demand.name(),
        failure.count,
        failure.of,
        failure.worst
    )
}

/// The flag, or the key or table of the course, that sets the limit of a demand.
fn set_by(demand: Demand) -> Option<&'static str> {
    match demand {
        Demand::Tolerance => Some("--tolerance"),
        Demand::Clearance => Some("--clearance"),
        Demand::Edge => Some("edge_margin_m"),
        Demand::Avoid => Some("[[avoid]]"),
        Demand::Zone => Some("[[land]]"),
        Demand::Goal => Some("goal_from_x_m, goal_to_x_m"),
        Demand::Friction => Some("friction_coefficient"),
        Demand::Touchdown | Demand::Ground | Demand::Stance => None,
    }
}

/// What the jumps have to meet.
fn demands_text(outcomes: &[Outcome], context: &Context<'_>) -> String {
    let Some(Outcome { trial, .. }) = outcomes.first() else {
        return String::new();
    };
    let demands = &trial.route.demands;
    let metres = |x: f64| format!("{} m", digits(x, 4));
    let span = |span: &saltus::planner::course::Span| match (
        span.low.is_finite(),
        span.high.is_finite(),
    ) {
        (true, true) => format!("from {} to {}", metres(span.low), metres(span.high)),
        (true, false) => format!("from {}", metres(span.low)),
        _ => format!("up to {}", metres(span.high)),
    };
    let by_wheel = match context.how.tolerance {
        None => " (a fifth of the wheel's radius)",
        Some(_) => "",
    };
    let mut all = vec![format!(
        "landings within {} of where they are wanted{by_wheel}",
        metres(demands.tolerance)
    )];
    all.extend(
        demands
            .goal
            .iter()
            .map(|goal| format!("the goal {}", span(goal))),
    );
    let zones = demands
        .zones
        .iter()
        .enumerate()
        .filter_map(|(i, zone)| Some((i, zone.as_ref()?)));
    all.extend(zones.map(|(i, zone)| format!("jump {} landing {}", i + 1, span(zone))));
    all.extend(
        demands
            .avoid
            .iter()
            .map(|area| format!("no landing {}", span(area))),
    );
    if !demands.obstacles.is_empty() {
        let least = demands.clearance;
        all.push(if least > 0.0 {
            format!("{} clear of boxes", metres(least))
        } else {
            "no touching of boxes".into()
        });
    }
    if demands.edge_margin > 0.0 {
        all.push(format!(
            "landings {} from edges",
            metres(demands.edge_margin)
        ));
    }
    all.extend(
        demands
            .friction
            .map(|mu| format!("friction up to {}", digits(mu, 4))),
    );
    all.join("; ")
}

fn group_text(group: &Group, context: &Context<'_>) -> String {
    let mut lines = vec![counts(group, context)];
    lines.extend(errors_text(group));
    lines.extend(group.clearance.map(|gap| {
        let gap = digits(gap, 3);
        format!("  clearance                        {gap} m at least")
    }));
    lines.push(match group.slipped {
        0 => "  slip                             none".to_owned(),
        n => {
            let way = digits(group.slip, 3);
            format!("  slip                             {n} feet slip, {way} m at most")
        }
    });
    let number = |x: Option<f64>, count: usize| x.map_or("–".to_owned(), |x| digits(x, count));
    let (needed, normal) = (
        number(group.friction_needed, 3),
        number(group.least_normal, 3),
    );
    lines.push(format!(
        "  ground                           friction/normal force {needed} at most, normal force \
         {normal} N at least"
    ));
    let residual = number(group.residual.map(f64::abs), 2);
    lines.push(format!(
        "  energy ledger                    closes within {residual} J"
    ));
    lines.join("\n") + "\n"
}

/// How many runs and jumps of a group pass, land, and are not simulated.
fn counts(group: &Group, context: &Context<'_>) -> String {
    let title = if group.errors {
        format!("with errors drawn, seed {}", context.how.seed)
    } else {
        "without errors".to_owned()
    };
    let runs = match context.subject.jumps() {
        1 => String::new(),
        _ => format!("{} of {} runs pass; ", group.runs_passed, group.runs),
    };
    let (passed, jumps, landed) = (group.passed, group.jumps, group.landed);
    let mut counts = vec![format!(
        "\n{title}: {runs}{passed} of {jumps} jumps pass, {landed} land"
    )];
    let others = [
        (group.simulation_failed, "cannot be simulated"),
        (group.not_started, "are not started"),
    ];
    let others = others.into_iter().filter(|(count, _)| *count > 0);
    counts.extend(others.map(|(n, what)| format!("{n} {what}")));
    counts.join(", ")
}

/// What landings and apexes miss, a line each.
fn errors_text(group: &Group) -> [String; 3] {
    let (land, miss, apex) = (&group.land_error, &group.miss, &group.apex_error);
    let deviation = "standard deviation";
    let spread = |name: &str, of: &Spread, last: (Option<f64>, &str)| {
        let all = [(of.mean, "in the mean"), (of.greatest, "at most"), last];
        let known = all
            .into_iter()
            .filter_map(|(x, what)| Some(format!("{} m {what}", measured(x?, 3))));
        let known: Vec<String> = known.collect();
        let all = if known.is_empty() {
            "–".to_owned()
        } else {
            known.join(", ")
        };
        format!("  {name:<32} {all}")
    };
    [
        spread(
            "landing, simulated less planned",
            land,
            (land.deviation, deviation),
        ),
        spread("landing, simulated less wanted", miss, (miss.rms, "RMS")),
        spread(
            "apex, simulated less planned",
            apex,
            (apex.deviation, deviation),
        ),
    ]
}

/// One line for each of several grounds.
fn grounds_text(verdict: &Verdict, errors: bool) -> String {
    let columns: [Column<&Group>; 10] = columns! {
        "mu", "friction", |group| group.friction;
        "jumps", "jumps", |group| group.jumps;
        "passed", "pass", |group| group.passed;
        "slipped", "slip", |group| group.slipped;
        "mean_m", "Δ landing", |group| group.land_error.mean;
        "sd_m", "±", |group| group.land_error.deviation;
        "rms_m", "RMS miss", |group| group.miss.rms;
        "greatest_m", "worst miss", |group| group.miss.greatest;
        "apex_m", "Δ apex", |group| group.apex_error.mean;
        "slip_m", "worst slip", |group| group.slip;
    };
    let mut groups = verdict.grounds(errors).peekable();
    if groups.peek().is_none() {
        return String::new();
    }
    Table::of(&columns, groups).text()
}
