//! A verification as a page to watch.

use saltus::recording::{self, Block, Recording};
use saltus::sim_check::SimError;
use saltus::verify::{Demand, Flown, Judgement, Outcome, RunJump};

use super::context::Context;
use super::drawing::{missed, path, planned};
use crate::animation::{Jump, Obstacle, Scene, Zone, page};
use crate::output::digits;
use crate::plot::ground::Part;

/// Most jumps of a page, each of some hundred kilobytes.
const MOST: usize = 12;

/// The runs to show: those without errors, evenly chosen where they are many, and of the others the
/// worst.
fn chosen<'o>(outcomes: &'o [Outcome], context: &Context<'_>) -> Vec<&'o Outcome> {
    let nominal: Vec<&Outcome> = outcomes.iter().filter(|o| !o.trial.has_errors()).collect();
    let most = (MOST / context.subject.jumps().max(1)).max(2);
    let step = nominal.len().div_ceil(most - 1).max(1);
    let drawn = outcomes.iter().filter(|o| o.trial.has_errors());
    let worst = drawn.max_by(|a, b| {
        (!a.passes())
            .cmp(&!b.passes())
            .then(miss(a).total_cmp(&miss(b)))
    });
    nominal.into_iter().step_by(step).chain(worst).collect()
}

/// Puts the same runs into a recording, jump after jump, each from a whole second on.
pub(super) fn record(
    recording: &mut Recording<Vec<u8>>,
    outcomes: &[Outcome],
    context: &Context<'_>,
) -> Result<(), recording::Error> {
    let obstacles = outcomes[0].trial.route.demands.obstacles.iter();
    let block = |[front, back, top]: &[f64; 3]| Block {
        front: *front,
        back: *back,
        top: *top,
    };
    recording.course(&obstacles.map(block).collect::<Vec<_>>())?;
    let mut start = 0.0;
    for outcome in chosen(outcomes, context) {
        for one in outcome.jumps() {
            let Some(flown) = one.attempt.flown() else {
                continue;
            };
            let verdict = verdict(&one, flown);
            recording.event(start, &format!("{}: {verdict}", name(&one, context)))?;
            let how = recording::Flown {
                start,
                foot: one.attempt.foot,
                valve_open: one.attempt.launch.valve_open,
                landing_height: one.stage().landing_height,
            };
            start = recording.jump(&flown.report, &how)?.floor() + 1.0;
        }
    }
    Ok(())
}

/// The page. What could not be simulated is not shown.
pub(super) fn html(outcomes: &[Outcome], context: &Context<'_>) -> Result<String, SimError> {
    let mut jumps = Vec::new();
    for outcome in chosen(outcomes, context) {
        run(outcome, context, &mut jumps)?;
    }
    let demands = &outcomes[0].trial.route.demands;
    let obstacle = |[from_x_m, to_x_m, top_m]: [f64; 3]| Obstacle {
        from_x_m,
        to_x_m,
        top_m,
    };
    let obstacles = demands.obstacles.iter().copied().map(obstacle).collect();
    let title = format!(
        "{} of {}",
        context.short_title,
        context.planner.robot().name
    );
    let mut scene = Scene::of(context.plant.robot(), title, obstacles, jumps);
    scene.avoid = demands
        .avoid
        .iter()
        .map(|area| [area.low, area.high])
        .collect();
    let zone = |name: String, span: &saltus::planner::course::Span| Zone {
        name,
        span_m: [span.low, span.high],
    };
    let zones = demands.zones.iter().enumerate();
    scene.zones = zones
        .filter_map(|(i, span)| Some(zone(format!("land {}", i + 1), span.as_ref()?)))
        .collect();
    scene
        .zones
        .extend(demands.goal.iter().map(|goal| zone("goal".into(), goal)));
    Ok(page(&scene))
}

/// The greatest landing error (m) of a run.
fn miss(outcome: &Outcome) -> f64 {
    outcome
        .jumps()
        .map(|jump| jump.miss().map_or(f64::INFINITY, f64::abs))
        .fold(0.0, f64::max)
}

/// Adds the jumps of a run that were simulated, each among the paths of the others.
fn run(outcome: &Outcome, context: &Context<'_>, jumps: &mut Vec<Jump>) -> Result<(), SimError> {
    let flown: Vec<(RunJump<'_>, &Flown)> = outcome
        .jumps()
        .filter_map(|jump| Some((jump, jump.attempt.flown()?)))
        .collect();
    let path = |(jump, flown): &(RunJump<'_>, &Flown)| -> Vec<[f64; 2]> {
        path(jump.attempt, flown, jump.stage().landing_height)
            .step_by(4)
            .map(|(x, y)| [x, y])
            .collect()
    };
    let paths: Vec<Vec<[f64; 2]>> = flown.iter().map(path).collect();
    for (i, (one, flown_one)) in flown.iter().enumerate() {
        let mut shown = jump(one, flown_one, context)?;
        let others = paths.iter().enumerate().filter(|(k, _)| *k != i);
        shown.others = others.map(|(_, path)| path.clone()).collect();
        shown.next = (i + 1 < flown.len()).then_some(jumps.len() + 1);
        jumps.push(shown);
    }
    Ok(())
}

/// What a jump is called.
fn name(one: &RunJump<'_>, context: &Context<'_>) -> String {
    let RunJump {
        trial,
        number,
        attempt,
    } = one;
    let stage = one.stage();
    let (rate, angle) = (
        digits(attempt.launch.rate, 3),
        digits(stage.launch.firing_angle, 3),
    );
    let mut name = format!("{rate} rad/s, fired at {angle} rad");
    if context.subject.jumps() > 1 {
        name = format!("jump {}: {name}", number + 1);
    }
    if let Some(friction) = trial.friction {
        name = format!("{name}, friction {}", digits(friction, 3));
    }
    if trial.has_errors() {
        name += ", with errors: the worst run";
    }
    name.replace('-', "−")
}

fn jump(one: &RunJump<'_>, flown: &Flown, context: &Context<'_>) -> Result<Jump, SimError> {
    let RunJump { trial, attempt, .. } = one;
    let stage = one.stage();
    // The path is drawn from where the foot stands, the plan from where it should.
    let rig = context.plant.rig()?;
    let asked = Jump {
        name: name(one, context),
        verdict: verdict(one, flown),
        passed: attempt.passes(),
        planned: planned(one, context)
            .into_iter()
            .map(|(x, y)| [x - attempt.foot[0], y - attempt.foot[1]])
            .collect(),
        planned_apex_m: stage.apex - attempt.foot[1],
        planned_land_m: stage.landing - attempt.foot[0],
        ..Jump::default()
    };
    let mut shown = Jump::of(&rig, &flown.report, stage.landing_height, asked);
    shown.stand_at(
        attempt.foot,
        context.plant.robot().boom.map(|boom| boom.length),
    );
    let zones = trial.route.demands.zones.iter().flatten().count();
    let part = |part: Part| match part {
        Part::Obstacle(item) => ("obstacle", item),
        Part::Avoid(item) => ("avoid", item),
        Part::Land(item) => ("zone", item),
        Part::Goal => ("zone", zones),
    };
    shown.missed = missed(one).into_iter().map(part).collect();
    Ok(shown)
}

/// What a jump misses, or where it lands if it misses nothing, and how far its foot slips.
fn verdict(one: &RunJump<'_>, flown: &Flown) -> String {
    let mut words = one.attempt.reasons();
    if words.is_empty() {
        words.extend(
            one.attempt
                .judgement(Demand::Tolerance)
                .map(Judgement::place),
        );
        let gap = one.attempt.clearance.filter(|gap| *gap > 0.0);
        words.extend(gap.map(|gap| format!("keeps {} mm from boxes", digits(1e3 * gap, 3))));
    }
    if flown.report.slips_at.is_some() {
        words.push(format!(
            "the foot slips {} mm",
            digits(1e3 * flown.slip(), 2)
        ));
    }
    words.join("; ").replace(" -", " −")
}
