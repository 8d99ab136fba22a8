//! A verification as a drawing: paths, forces and slip, landing errors.

use saltus::lagrangian::Sample as Planned;
use saltus::verify::Task;

use super::report::Context;
use super::trial::Outcome;
use crate::output::digits;
use crate::plot::Drawing;
use crate::plot::palette::{BLUE, GREY, INK, RED, viridis};
use crate::plot::sheet::{Line, Mark, Panel, Sheet};

/// Most paths that are drawn.
const PATHS: usize = 9;

/// Paths of the nominal jumps, forces and slip of the one that misses most, and all landing errors.
pub(super) fn sheet(outcomes: &[Outcome], context: &Context<'_>) -> Drawing {
    let nominal: Vec<&Outcome> = outcomes.iter().filter(|o| o.trial.disturbance.is_none()).collect();
    let miss = |o: &&&Outcome| o.land_error().map_or(f64::INFINITY, f64::abs);
    let worst = nominal.iter().max_by(|a, b| miss(a).total_cmp(&miss(b)));
    let mut panels = vec![paths(&nominal, context)];
    panels.extend(worst.into_iter().flat_map(|outcome| [forces(outcome), slip(outcome)]));
    panels.push(errors(outcomes));
    let title =
        format!("{}, in the multi-body simulation of {}", context.subject.title, context.plant.robot().name);
    Drawing::Sheet(Sheet { title, panels })
}

fn paths(nominal: &[&Outcome], context: &Context<'_>) -> Panel {
    let step = nominal.len().div_ceil(PATHS).max(1);
    let shown: Vec<&&Outcome> = nominal.iter().step_by(step).collect();
    let mut lines = Vec::new();
    for (i, outcome) in shown.iter().enumerate() {
        let color = viridis(0.88 * i as f64 / shown.len().saturating_sub(1).max(1) as f64);
        let launch = &outcome.trial.task.launch;
        lines.push(Line {
            label: None,
            points: planned(&outcome.trial.task, context),
            color: GREY,
            mark: Mark::Dashed,
        });
        let end = outcome.trial.task.landing_height;
        let samples = &outcome.flown.report.samples;
        let lift_off = outcome.flown.report.lift_off.map_or(f64::INFINITY, |l| l.time);
        let flying = samples.iter().take_while(|s| s.time <= lift_off || s.axle[1] >= end);
        lines.push(Line {
            label: Some(format!("{} rad/s", digits(launch.rate, 3))),
            points: flying.map(|s| s.axle.into()).collect(),
            color,
            mark: Mark::Solid,
        });
        for [front, back, top] in outcome.trial.task.obstacles.iter().filter(|_| i == 0) {
            lines.push(Line {
                label: None,
                points: vec![(*front, 0.0), (*front, *top), (*back, *top), (*back, 0.0)],
                color: INK,
                mark: Mark::Solid,
            });
        }
    }
    Panel {
        title: "axle without errors: planned dashed, simulated solid".into(),
        x: "travel from the foot (m)",
        y: "height (m)",
        lines,
    }
}

/// The planner's path of the axle.
pub(super) fn planned(task: &Task, context: &Context<'_>) -> Vec<(f64, f64)> {
    const POINTS: usize = 120;
    let radius = context.planner.robot().body.radius;
    let Ok(trace) = context.planner.stance().trace(&task.launch) else { return Vec::new() };
    let axle = |s: &Planned| {
        let (sin, cos) = s.lean.sin_cos();
        ((radius + s.extension) * sin, (radius + s.extension) * cos)
    };
    let mut points: Vec<(f64, f64)> = trace.samples.iter().map(axle).collect();
    let jump = context.planner.jump(&task.launch).ok();
    let flight = jump.and_then(|jump| jump.flight);
    if let Some((flight, time)) = flight.and_then(|f| Some((f, f.time_to_height(task.landing_height).ok()?)))
    {
        points.extend(flight.samples(0.0, time, POINTS).map(|(_, x, y)| (x, y)));
    }
    points
}

/// Which jump it is.
fn name(outcome: &Outcome) -> String {
    let on = outcome.trial.friction.map_or(String::new(), |mu| format!(", friction {}", digits(mu, 3)));
    format!("{} rad/s{on}", digits(outcome.trial.task.launch.rate, 3))
}

/// Samples while the foot is on the ground.
fn standing(outcome: &Outcome) -> impl Iterator<Item = &saltus::sim_check::Sample> {
    let report = &outcome.flown.report;
    let lift_off = report.lift_off.map_or(f64::INFINITY, |l| l.time);
    report.samples.iter().filter(move |s| s.time <= lift_off)
}

fn forces(outcome: &Outcome) -> Panel {
    let curve = |label: &str, k: usize, color| Line {
        label: Some(label.into()),
        points: standing(outcome).map(|s| (1e3 * s.time, s.force[k])).collect(),
        color,
        mark: Mark::Solid,
    };
    Panel {
        title: format!("force on the foot, the jump off its plan most: {}", name(outcome)),
        x: "time (ms)",
        y: "force (N)",
        lines: vec![curve("normal", 0, BLUE), curve("along the travel", 1, RED), curve("across", 2, GREY)],
    }
}

fn slip(outcome: &Outcome) -> Panel {
    let curve = |label: &str, k: usize, color| {
        let (mut way, mut before) = (0.0, None::<(f64, f64)>);
        let points = standing(outcome).map(|s| {
            if let Some((time, speed)) = before {
                way += 0.5 * (speed + s.slip[k]) * (s.time - time);
            }
            before = Some((s.time, s.slip[k]));
            (1e3 * s.time, 1e3 * way)
        });
        Line { label: Some(label.into()), points: points.collect(), color, mark: Mark::Solid }
    };
    Panel {
        title: format!("way that this foot slips: {}", name(outcome)),
        x: "time (ms)",
        y: "slip (mm)",
        lines: vec![curve("along the travel", 0, RED), curve("across", 1, GREY)],
    }
}

/// Landing errors over friction where there are several coefficients, else over the approach rate.
fn errors(outcomes: &[Outcome]) -> Panel {
    let several = outcomes.windows(2).any(|pair| pair[0].trial.friction != pair[1].trial.friction);
    let place = |o: &Outcome| if several { o.trial.friction } else { Some(o.task.launch.rate) };
    let dots = |errors: bool| -> Vec<(f64, f64)> {
        let these = outcomes.iter().filter(|o| o.trial.disturbance.is_some() == errors);
        these.filter_map(|o| Some((place(o)?, 1e3 * o.land_error()?))).collect()
    };
    let line =
        |label: &str, points, color| Line { label: Some(label.into()), points, color, mark: Mark::Dots };
    Panel {
        title: "landing, simulated less planned".into(),
        x: if several { "friction coefficient" } else { "approach rate ω (rad/s)" },
        y: "landing error (mm)",
        lines: vec![line("with errors", dots(true), GREY), line("without errors", dots(false), BLUE)],
    }
}
