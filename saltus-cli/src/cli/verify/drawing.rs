//! A verification as a drawing: the course with paths and landings, forces and slip, landing
//! errors.

use saltus::verify::{Attempt, Demand, Flown, Outcome, RunJump, Subject, Verdict};

use super::context::Context;
use super::report::{NOTHING, failure_text};
use crate::cli::plan::scene;
use crate::output::digits;
use crate::plot::ground::{Ground, Part};
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREEN, GREY, INK, RED, shade};
use crate::plot::sheet::{Panel, Sheet};

/// Most runs whose paths are drawn.
const PATHS: usize = 9;
/// Where the bands of the tolerance lie (m under the surface landed on).
const BAND: [f64; 2] = [-0.06, -0.04];
/// Most lines of the verdict.
const LINES: usize = 4;

/// The course, forces and slip of the jump without errors that misses most, and all landing errors.
pub(super) fn sheet(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> Sheet {
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
        context.short_title,
        context.plant.robot().name
    );
    Sheet {
        title,
        wide: vec![course(&nominal, outcomes, verdict, context)],
        panels,
    }
}

/// The course as it was jumped: planned and simulated paths, landings, what is missed, and the verdict.
fn course(
    nominal: &[&Outcome],
    outcomes: &[Outcome],
    verdict: &Verdict,
    context: &Context<'_>,
) -> Panel {
    let mut panel = ground(outcomes, context).panel();
    panel.y = "height of the axle (m)";
    let lines = &mut panel.lines;
    let shown: Vec<&&Outcome> = nominal
        .iter()
        .step_by(nominal.len().div_ceil(PATHS).max(1))
        .collect();
    let stages = || shown.iter().flat_map(|outcome| &outcome.trial.route.stages);
    let tolerance = context.tolerance();
    let mut band = Some("band: tolerance of the landing".to_owned());
    for stage in stages().filter(|stage| stage.wanted.is_finite()) {
        let (x, y) = (stage.wanted, stage.surface.unwrap_or(0.0));
        let corners = [(x - tolerance, y + BAND[0]), (x + tolerance, y + BAND[1])];
        lines.push(Line {
            label: band.take(),
            ..Line::new(Mark::Area(0.35), BLUE, corners)
        });
    }
    let mut dashed = Some("planned".to_owned());
    for (i, outcome) in shown.iter().enumerate() {
        let color = shade(i, shown.len());
        let mut label = Some(label(outcome, context));
        for jump in outcome.jumps() {
            lines.push(Line {
                label: dashed.take(),
                ..Line::new(Mark::Dashed, GREY, planned(&jump, context))
            });
            let color = if jump.attempt.passes() { color } else { RED };
            lines.push(Line {
                label: label.take(),
                ..Line::new(Mark::Solid, color, simulated(&jump))
            });
        }
    }
    let all = || outcomes.iter().flat_map(Outcome::jumps);
    for (passes, color, words) in [
        (true, GREEN, "dots: landings that meet every demand"),
        (false, RED, "dots: landings that miss one"),
    ] {
        let these = all().filter(|jump| jump.attempt.passes() == passes);
        let places = these.filter_map(|jump| {
            let landing = jump.attempt.landing()?;
            Some((landing, jump.stage().surface.unwrap_or(0.0)))
        });
        let dots = Line::new(Mark::Dots, color, places);
        if !dots.points.is_empty() {
            lines.push(dots.called(words));
        }
    }
    let feet = stages().map(|stage| stage.foot.into());
    lines.push(Line::new(Mark::Disc(4), INK, feet));
    let word = if verdict.passes {
        ("PASS".into(), GREEN)
    } else {
        ("FAIL".into(), RED)
    };
    let failures = verdict.failures.iter().take(LINES - 1);
    let failures = failures.map(|f| (failure_text(f, context), RED));
    panel.notes = std::iter::once(word).chain(failures).collect();
    panel
}

/// What stands and lies on the course; what any run misses is marked.
fn ground(outcomes: &[Outcome], context: &Context<'_>) -> Ground {
    let demands = &outcomes[0].trial.route.demands;
    let ends = |span: &saltus::planner::course::Span| (span.low, span.high);
    let boxes = demands.obstacles.iter();
    Ground {
        obstacles: boxes
            .map(|[front, back, top]| ((*front, *back), *top))
            .collect(),
        avoid: demands.avoid.iter().map(ends).collect(),
        land: demands.zones.iter().flatten().map(ends).collect(),
        goal: demands.goal.as_ref().map(ends),
        target: match context.subject {
            Subject::Plan { crossing, .. } => Some(crossing.target),
            Subject::Rule(rule) => rule.distance,
        },
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
    flown: &'a Flown,
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
    let (stage, planner) = (jump.stage(), context.planner);
    let Ok(jump) = planner.jump(&stage.launch) else {
        return Vec::new();
    };
    let path = scene::path(&jump, stage.landing_height, planner);
    let [x, y] = stage.foot;
    let path = path.into_iter().flatten();
    path.map(|(dx, dy)| (x + dx, y + dy)).collect()
}

/// Samples while the foot is on the ground.
fn standing(flown: &Flown) -> impl Iterator<Item = &saltus::sim_check::Sample> {
    let lift_off = flown.report.lift_off.map_or(f64::INFINITY, |l| l.time);
    flown
        .report
        .samples
        .iter()
        .filter(move |s| s.time <= lift_off)
}

fn forces(name: &str, flown: &Flown) -> Panel {
    let curve = |label: &str, k: usize, color| {
        let points = standing(flown).map(|s| (1e3 * s.time, s.force[k]));
        Line::new(Mark::Solid, color, points).called(label)
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
        ..Panel::default()
    }
}

/// The way that the foot slips; none if it never does.
fn slip(name: &str, flown: &Flown) -> Option<Panel> {
    let curve = |label: &str, k: usize, color| {
        let (mut way, mut before) = (0.0, None::<(f64, f64)>);
        let points = standing(flown).map(|s| {
            if let Some((time, speed)) = before {
                way += 0.5 * (speed + s.slip[k]) * (s.time - time);
            }
            before = Some((s.time, s.slip[k]));
            (1e3 * s.time, 1e3 * way)
        });
        Line::new(Mark::Solid, color, points).called(label)
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
        ..Panel::default()
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
    let bound = |side: f64| {
        let points = ends.map(|x| (x, side * 1e3 * context.tolerance()));
        Line::new(Mark::Dashed, BLUE, points)
    };
    let line = |label: &str, points, color| Line::new(Mark::Dots, color, points).called(label);
    let mut lines = vec![
        line("with errors", with, GREY),
        line("without errors", without, BLUE),
    ];
    lines.push(line("fails", failed, RED));
    lines.retain(|line| !line.points.is_empty());
    if ends[0] <= ends[1] {
        lines.extend([bound(1.0).called("tolerance"), bound(-1.0)]);
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
        ..Panel::default()
    }
}
