//! What a verification found, as text, JSON and CSV.

use std::fmt::Write;

use saltus::Robot;
use saltus::verify::{Demand, Failure, Group, Outcome, Plant, RunJump, Spread, Starts, Verdict};
use serde_json::{Value, json};

use super::advice::advice;
use super::context::Context;
use crate::output::{self, Cell, Table, digits};

const COLUMNS: &[&str] = &[
    "run",
    "errors",
    "jump",
    "omega_rad_s",
    "omega_true_rad_s",
    "alpha_f_rad",
    "valve_open_s",
    "friction_coefficient",
    "outcome",
    "foot_x_m",
    "foot_planned_x_m",
    "apex_m",
    "apex_planned_m",
    "apex_error_m",
    "land_x_m",
    "land_planned_x_m",
    "land_error_m",
    "land_wanted_x_m",
    "miss_m",
    "clearance_m",
    "slip_start_s",
    "slip_m",
    "slip_across_m",
    "friction_needed",
    "normal_least_n",
    "energy_residual_j",
    "touchdown_holds",
    "ground_holds",
    "ground_margin_m",
    "edge_holds",
    "edge_margin_m",
    "avoid_holds",
    "avoid_margin_m",
    "zone_holds",
    "zone_margin_m",
    "goal_holds",
    "goal_margin_m",
    "tolerance_holds",
    "tolerance_margin_m",
    "clearance_holds",
    "clearance_margin_m",
    "stance_holds",
    "stance_margin_m",
    "friction_holds",
    "friction_margin",
    "passes",
    "reason",
];

/// A row for each jump of each run.
pub(super) fn rows(outcomes: &[Outcome], robot: &Robot) -> Table {
    let mut table = Table::new(COLUMNS);
    for (run, outcome) in outcomes.iter().enumerate() {
        for jump in outcome.jumps() {
            table.push(row(run, &jump, robot));
        }
    }
    table
}

/// A length (m) below which the simulation knows none.
pub(super) const NOTHING: f64 = 1e-9;

fn row(run: usize, jump: &RunJump<'_>, robot: &Robot) -> Vec<Cell> {
    let RunJump {
        trial,
        number,
        attempt,
    } = jump;
    let (stage, flown) = (jump.stage(), attempt.flown());
    let report = flown.map(|flown| &flown.report);
    let slip = |x: f64| if x.abs() < NOTHING { 0.0 } else { x };
    let mut row = vec![
        Cell::Count(run + 1),
        Cell::Flag(trial.has_errors()),
        if stage.surface.is_some() {
            Cell::Count(number + 1)
        } else {
            Cell::Empty
        },
        stage.launch.rate.into(),
        attempt.launch.rate.into(),
        stage.launch.firing_angle.into(),
        robot
            .leg
            .drive
            .has_valve()
            .then_some(stage.launch.valve_open)
            .into(),
        trial.friction.into(),
        Cell::Word(attempt.outcome()),
        attempt.was_started().then_some(attempt.foot[0]).into(),
        stage.foot[0].into(),
        attempt.apex().into(),
        stage.apex.into(),
        jump.apex_error().into(),
        attempt.landing().into(),
        stage.landing.into(),
        jump.land_error().into(),
        stage.wanted.into(),
        jump.miss().into(),
        attempt.clearance.into(),
        report.and_then(|report| report.slips_at).into(),
        flown.map(|flown| slip(flown.slip())).into(),
        report.map(|report| slip(report.slipped[1])).into(),
        report.map(|report| report.friction_needed).into(),
        report.map(|report| report.least_normal).into(),
        report.map(|report| report.residual).into(),
    ];
    for demand in Demand::ALL {
        let judgement = attempt.judgement(demand);
        row.push(judgement.map_or(Cell::Empty, |judgement| Cell::Flag(judgement.holds())));
        // Landing or not has no margin.
        if demand != Demand::Touchdown {
            row.push(judgement.map(|judgement| judgement.margin).into());
        }
    }
    row.extend([
        Cell::Flag(attempt.passes()),
        Cell::Text(attempt.reasons().join("; ")),
    ]);
    row
}

/// What there is to say of a course without a plan.
pub(super) const NO_PLAN: &str = "no plan crosses this course: `saltus plan` says what blocks it, \
    and the nearest that has one\n";

/// The same as a document.
pub(super) fn no_plan_json(robot: &Robot, plant: &Plant) -> String {
    output::json(&json!({
        "command": "verify",
        "robot": robot.name,
        "plant": plant.robot().name,
        "passes": false,
        "reason": NO_PLAN.trim(),
        "groups": [],
        "rows": [],
    }))
}

/// The document.
pub(super) fn json(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> String {
    output::json(&json!({
        "command": "verify",
        "robot": context.planner.robot().name,
        "plant": context.plant.robot().name,
        "subject": context.title,
        "seed": context.how.seed,
        "starts": starts(context),
        "tolerance_m": context.how.tolerance,
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

/// How the jumps of a course start; none for what has no course.
fn starts(context: &Context<'_>) -> Option<&'static str> {
    context
        .subject
        .is_plan()
        .then_some(match context.how.starts {
            Starts::Chained => "where the jump before lands",
            Starts::Planned => "at the planned footholds",
        })
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
    if let Some(starts) = starts(context).filter(|_| context.subject.jumps() > 1) {
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "a run is {} jumps; each starts {starts}",
            context.subject.jumps()
        );
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
    let nominal = || {
        outcomes
            .iter()
            .filter(|o| !o.trial.has_errors())
            .flat_map(Outcome::jumps)
    };
    if nominal().count() > FEW {
        return String::new();
    }
    let mut table = Table::new(COLUMNS);
    nominal().for_each(|jump| table.push(row(0, &jump, context.planner.robot())));
    let (jump, foot) = (("jump", "jump", ""), ("foot_x_m", "foot", "m"));
    let mut columns = if context.subject.is_plan() {
        vec![jump, foot]
    } else {
        Vec::new()
    };
    columns.extend([
        ("omega_rad_s", "ω", "rad/s"),
        ("alpha_f_rad", "α_f", "rad"),
        ("friction_coefficient", "friction", ""),
        ("outcome", "outcome", ""),
        ("apex_m", "apex", "m"),
        ("apex_planned_m", "planned", "m"),
        ("land_x_m", "landing", "m"),
        ("land_planned_x_m", "planned", "m"),
        ("land_wanted_x_m", "wanted", "m"),
        ("clearance_m", "clearance", "m"),
        ("slip_m", "slip", "m"),
        ("passes", "passes", ""),
    ]);
    format!("\nwithout errors, jump by jump\n{}", table.text(&columns))
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
            format!(" ({} % have to)", digits(100.0 * context.how.share, 4))
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
    let _ = writeln!(text, "  demanded: {}", demands_text(outcomes));
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
    format!(
        "{}: {jump}{with}, {} of {}{worst}: {}",
        failure.demand.name(),
        failure.count,
        failure.of,
        failure.worst
    )
}

/// What the jumps have to meet.
fn demands_text(outcomes: &[Outcome]) -> String {
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
    let mut all = vec![format!(
        "landings within {} of where they are wanted",
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
            .filter_map(|(x, what)| Some(format!("{} m {what}", digits(x?, 3))));
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
    const NAMES: &[&str] = &[
        "mu", "jumps", "passed", "slipped", "mean", "sd", "rms", "greatest", "apex", "slip",
    ];
    let mut table = Table::new(NAMES);
    let mut groups = verdict.grounds(errors).peekable();
    if groups.peek().is_none() {
        return String::new();
    }
    for group in groups {
        table.push(vec![
            group.friction.into(),
            Cell::Count(group.jumps),
            Cell::Count(group.passed),
            Cell::Count(group.slipped),
            group.land_error.mean.into(),
            group.land_error.deviation.into(),
            group.miss.rms.into(),
            group.miss.greatest.into(),
            group.apex_error.mean.into(),
            group.slip.into(),
        ]);
    }
    table.text(&[
        ("mu", "friction", ""),
        ("jumps", "jumps", ""),
        ("passed", "pass", ""),
        ("slipped", "slip", ""),
        ("mean", "Δ landing", "m"),
        ("sd", "±", "m"),
        ("rms", "RMS miss", "m"),
        ("greatest", "worst miss", "m"),
        ("apex", "Δ apex", "m"),
        ("slip", "worst slip", "m"),
    ])
}
