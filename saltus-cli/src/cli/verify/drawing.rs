//! A verification as a drawing: the course with paths and landings, forces and slip, landing
//! errors.

use saltus::Launch;
use saltus::planner::JumpModel;
use saltus::verify::{Attempt, Demand, Flown as Simulated, Outcome, RunJump, Subject, Verdict};

use super::context::Context;
use super::report::{NOTHING, failure_text};
use crate::output::digits;
use crate::plot::Drawing;
use crate::plot::flown::Flown;
use crate::plot::ground::{Ground, Part};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREY, RED, viridis};
use crate::plot::sheet::{Panel, Sheet};

/// Most runs whose paths are drawn.
const PATHS: usize = 9;
/// Most lines of the verdict.
const LINES: usize = 4;

/// The course, forces and slip of the jump without errors that misses most, and all landing errors.
pub(super) fn sheet(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> Drawing {
    let nominal: Vec<&Outcome> = outcomes.iter().filter(|o| !o.trial.has_errors()).collect();
    let miss = |jump: &RunJump<'_>| jump.miss().map_or(f64::INFINITY, f64::abs);
    let flown = nominal
        .iter()
        .flat_map(|o| o.jumps())
        .filter_map(|jump| Some((jump, jump.attempt.flown()?)));
    let worst = flown.max_by(|a, b| miss(&a.0).total_cmp(&miss(&b.0)));
    let mut panels = Vec::new();
    panels.extend(worst.into_iter().flat_map(|(jump, flown)| {
        let name = name(&jump, context);
        std::iter::once(forces(&name, flown)).chain(slip(&name, flown))
    }));
    panels.push(errors(outcomes, context));
    let title = format!(
        "{}, in the multi-body simulation of {}",
        context.title,
        context.plant.robot().name
    );
    Drawing::Sheet(Sheet {
        title,
        course: Some(course(&nominal, outcomes, verdict, context)),
        panels,
    })
}

fn course(
    nominal: &[&Outcome],
    outcomes: &[Outcome],
    verdict: &Verdict,
    context: &Context<'_>,
) -> Flown {
    let shown: Vec<&&Outcome> = nominal
        .iter()
        .step_by(nominal.len().div_ceil(PATHS).max(1))
        .collect();
    let mut paths = Vec::new();
    let mut dashed = Some("planned".to_owned());
    for (i, outcome) in shown.iter().enumerate() {
        let color = viridis(0.88 * i as f64 / shown.len().saturating_sub(1).max(1) as f64);
        let mut label = Some(label(outcome, context));
        for jump in outcome.jumps() {
            let plan = planned(&jump, context);
            paths.push(Line {
                label: dashed.take(),
                points: plan,
                color: GREY,
                mark: Mark::Dashed,
            });
            let color = if jump.attempt.passes() { color } else { RED };
            let points = simulated(&jump);
            paths.push(Line {
                label: label.take(),
                points,
                color,
                mark: Mark::Solid,
            });
        }
    }
    let stages = shown.iter().flat_map(|outcome| &outcome.trial.route.stages);
    let surface = |jump: &RunJump<'_>| jump.stage().surface.unwrap_or(0.0);
    let landing = |jump: RunJump<'_>| {
        Some((
            (jump.attempt.landing()?, surface(&jump)),
            jump.attempt.passes(),
        ))
    };
    let tolerance = context.how.tolerance;
    let failures = verdict
        .failures
        .iter()
        .take(LINES - 1)
        .map(|f| failure_text(f, context));
    let word = if verdict.passes { "PASS" } else { "FAIL" };
    Flown {
        ground: ground(outcomes, context),
        paths,
        feet: stages.clone().map(|stage| stage.foot.into()).collect(),
        wanted: stages
            .filter(|stage| stage.wanted.is_finite())
            .map(|stage| ((stage.wanted, stage.surface.unwrap_or(0.0)), tolerance))
            .collect(),
        landings: outcomes
            .iter()
            .flat_map(Outcome::jumps)
            .filter_map(landing)
            .collect(),
        passes: verdict.passes,
        verdict: std::iter::once(word.to_owned()).chain(failures).collect(),
    }
}

/// What stands and lies on the course; what any run misses is marked.
fn ground(outcomes: &[Outcome], context: &Context<'_>) -> Ground {
    let demands = &outcomes[0].trial.route.demands;
    let ends = |span: &saltus::planner::course::Span| (span.low, span.high);
    Ground {
        obstacles: demands
            .obstacles
            .iter()
            .map(|[front, back, top]| ((*front, *back), *top))
            .collect(),
        avoid: demands.avoid.iter().map(ends).collect(),
        land: demands.zones.iter().flatten().map(ends).collect(),
        goal: demands.goal.as_ref().map(ends),
        target: match context.subject {
            Subject::Plan { crossing, .. } => Some(crossing.target),
            Subject::Rule(rule) => rule.distance,
        },
        target_name: "target",
        missed: outcomes
            .iter()
            .flat_map(Outcome::jumps)
            .flat_map(|jump| missed(&jump))
            .collect(),
    }
}

/// The parts of the course that a jump misses or touches.
pub(super) fn missed(jump: &RunJump<'_>) -> Vec<Part> {
    let zones = &jump.trial.route.demands.zones;
    let zone = || {
        zones[..=jump.number.min(zones.len().saturating_sub(1))]
            .iter()
            .flatten()
            .count()
            - 1
    };
    let part = |(demand, item): (Demand, Option<usize>)| match (demand, item) {
        (Demand::Avoid, Some(item)) => Some(Part::Avoid(item)),
        (Demand::Zone, _) => Some(Part::Land(zone())),
        (Demand::Goal, _) => Some(Part::Goal),
        (_, Some(item)) => Some(Part::Obstacle(item)),
        _ => None,
    };
    jump.attempt
        .misses()
        .filter_map(|miss| part((miss.demand, miss.item)))
        .collect()
}

/// What the key calls a run without errors: no two alike.
fn label(outcome: &Outcome, context: &Context<'_>) -> String {
    let on = outcome
        .trial
        .friction
        .map(|mu| format!("friction {}", digits(mu, 3)));
    let rate = format!(
        "{} rad/s",
        digits(outcome.trial.route.stages[0].launch.rate, 3)
    );
    let run = (!context.subject.is_plan()).then_some(rate);
    let parts: Vec<String> = run.into_iter().chain(on).collect();
    if parts.is_empty() {
        "simulated, without errors".into()
    } else {
        format!("simulated, {}", parts.join(", "))
    }
}

/// Which jump it is.
fn name(jump: &RunJump<'_>, context: &Context<'_>) -> String {
    let number = (context.subject.jumps() > 1).then(|| format!("jump {}", jump.number + 1));
    let rate = format!("{} rad/s", digits(jump.stage().launch.rate, 3));
    let on = jump
        .trial
        .friction
        .map(|mu| format!("friction {}", digits(mu, 3)));
    number
        .into_iter()
        .chain([rate])
        .chain(on)
        .collect::<Vec<_>>()
        .join(", ")
}

/// The simulated path of the axle (m along the course, and up), to the landing.
fn simulated(jump: &RunJump<'_>) -> Vec<(f64, f64)> {
    let Some(flown) = jump.attempt.flown() else {
        return Vec::new();
    };
    path(jump.attempt, flown, jump.stage().landing_height).collect()
}

/// The path of the axle (m along the course, and up) of a simulated jump that lands at a height (m
/// above its foothold).
pub(super) fn path<'a>(
    attempt: &'a Attempt,
    flown: &'a Simulated,
    height: f64,
) -> impl Iterator<Item = (f64, f64)> + 'a {
    let samples = &flown.report.samples;
    let lift_off = flown.report.lift_off.map_or(f64::INFINITY, |l| l.time);
    let is_higher = |a: &usize, b: &usize| samples[*a].axle[1].total_cmp(&samples[*b].axle[1]);
    let top = (0..samples.len())
        .filter(|i| samples[*i].time >= lift_off)
        .max_by(is_higher);
    let down = top.map_or(samples.len(), |top| {
        top + samples[top..]
            .iter()
            .take_while(|sample| sample.axle[1] >= height)
            .count()
    });
    let [x, y] = attempt.foot;
    let landing = flown.landing.map(|landing| (x + landing, y + height));
    samples[..down]
        .iter()
        .map(move |s| (x + s.axle[0], y + s.axle[1]))
        .chain(landing)
}

/// The planner's path of the axle (m along the course, and up).
pub(super) fn planned(jump: &RunJump<'_>, context: &Context<'_>) -> Vec<(f64, f64)> {
    let stage = jump.stage();
    let [x, y] = stage.foot;
    let path = planned_path(&stage.launch, stage.landing_height, context);
    path.into_iter().map(|(dx, dy)| (x + dx, y + dy)).collect()
}

/// The same from the foothold.
fn planned_path(launch: &Launch, landing_height: f64, context: &Context<'_>) -> Vec<(f64, f64)> {
    const POINTS: usize = 120;
    let Ok(traced) = context.planner.model().traced(launch) else {
        return Vec::new();
    };
    let way = traced.way.iter();
    let mut points: Vec<(f64, f64)> = way.map(|at| (at.centre[0], at.centre[1])).collect();
    if let Some((flight, time)) = traced
        .jump
        .flight
        .and_then(|f| Some((f.clone(), f.time_to_height(landing_height).ok()?)))
    {
        let at = |k: usize| {
            let [[x, y], _] = flight.motion(time * k as f64 / POINTS as f64);
            (x, y)
        };
        points.extend((0..=POINTS).map(at));
    }
    points
}

/// Samples while the foot is on the ground.
fn standing(flown: &Simulated) -> impl Iterator<Item = &saltus::sim_check::Sample> {
    let lift_off = flown.report.lift_off.map_or(f64::INFINITY, |l| l.time);
    flown
        .report
        .samples
        .iter()
        .filter(move |s| s.time <= lift_off)
}

fn forces(name: &str, flown: &Simulated) -> Panel {
    let curve = |label: &str, k: usize, color| Line {
        label: Some(label.into()),
        points: standing(flown)
            .map(|s| (1e3 * s.time, s.force[k]))
            .collect(),
        color,
        mark: Mark::Solid,
    };
    Panel {
        title: format!("force on the foot, the jump off its plan most: {name}"),
        x: "time (ms)",
        y: "force (N)",
        lines: vec![
            curve("normal", 0, BLUE),
            curve("along the travel", 1, RED),
            curve("across", 2, GREY),
        ],
        least: None,
    }
}

/// The way that the foot slips; none if it never does.
fn slip(name: &str, flown: &Simulated) -> Option<Panel> {
    let curve = |label: &str, k: usize, color| {
        let (mut way, mut before) = (0.0, None::<(f64, f64)>);
        let points = standing(flown).map(|s| {
            if let Some((time, speed)) = before {
                way += 0.5 * (speed + s.slip[k]) * (s.time - time);
            }
            before = Some((s.time, s.slip[k]));
            (1e3 * s.time, 1e3 * way)
        });
        Line {
            label: Some(label.into()),
            points: points.collect(),
            color,
            mark: Mark::Solid,
        }
    };
    let lines = vec![curve("along the travel", 0, RED), curve("across", 1, GREY)];
    let slips = lines
        .iter()
        .flat_map(|line| &line.points)
        .any(|(_, way)| way.abs() > 1e3 * NOTHING);
    let title = format!("way that this foot slips: {name}");
    slips.then_some(Panel {
        title,
        x: "time (ms)",
        y: "slip (mm)",
        lines,
        least: None,
    })
}

/// Landing errors and the tolerance, over friction where there are several coefficients, else over
/// the wanted landings of a course, else over the approach rate.
fn errors(outcomes: &[Outcome], context: &Context<'_>) -> Panel {
    let several = outcomes
        .windows(2)
        .any(|pair| pair[0].trial.friction != pair[1].trial.friction);
    let jumps = context.subject.jumps() > 1;
    let place = |jump: &RunJump<'_>| match (several, jumps) {
        (true, _) => jump.trial.friction,
        (false, true) => Some(jump.stage().wanted),
        (false, false) => Some(jump.attempt.launch.rate),
    };
    let dots = |errors: bool, passes: bool| -> Vec<(f64, f64)> {
        let these = outcomes
            .iter()
            .filter(|o| o.trial.has_errors() == errors)
            .flat_map(Outcome::jumps);
        let these = these.filter(|jump| jump.attempt.passes() == passes);
        these
            .filter_map(|jump| Some((place(&jump)?, 1e3 * jump.miss()?)))
            .collect()
    };
    let failed = [dots(true, false), dots(false, false)].concat();
    let (with, without) = (dots(true, true), dots(false, true));
    let all = || with.iter().chain(&without).chain(&failed).map(|(x, _)| *x);
    let ends = [
        all().fold(f64::INFINITY, f64::min),
        all().fold(f64::NEG_INFINITY, f64::max),
    ];
    let bound = |label: Option<String>, side: f64| Line {
        label,
        points: ends
            .map(|x| (x, side * 1e3 * context.how.tolerance))
            .to_vec(),
        color: BLUE,
        mark: Mark::Dashed,
    };
    let line = |label: &str, points, color| Line {
        label: Some(label.into()),
        points,
        color,
        mark: Mark::Dots,
    };
    let mut lines = vec![
        line("with errors", with, GREY),
        line("without errors", without, BLUE),
    ];
    lines.push(line("fails", failed, RED));
    lines.retain(|line| !line.points.is_empty());
    if ends[0] <= ends[1] {
        lines.extend([bound(Some("tolerance".into()), 1.0), bound(None, -1.0)]);
    }
    Panel {
        title: "landing, simulated less wanted".into(),
        x: match (several, jumps) {
            (true, _) => "friction coefficient",
            (false, true) => "wanted landing x (m)",
            (false, false) => "approach rate ω (rad/s)",
        },
        y: "landing error (mm)",
        lines,
        least: None,
    }
}
