//! A verification as a page to watch.

use saltus::sim_check::SimError;

use super::drawing::planned;
use super::report::Context;
use super::subject::Kind;
use super::trial::Outcome;
use crate::animation::{Asked, Jump, Obstacle, Scene, page};
use crate::output::digits;

/// Most jumps of a page, each of some hundred kilobytes.
const MOST: usize = 12;

/// The page: jumps without errors, evenly chosen where they are many, and of the others the one that lands farthest from where it is wanted.
pub(super) fn html(outcomes: &[Outcome], context: &Context<'_>) -> Result<String, SimError> {
    let nominal: Vec<&Outcome> = outcomes.iter().filter(|o| o.trial.disturbance.is_none()).collect();
    let step = nominal.len().div_ceil(MOST - 1).max(1);
    let drawn = outcomes.iter().filter(|o| o.trial.disturbance.is_some());
    let worst = drawn.max_by(|a, b| miss(a).total_cmp(&miss(b)));
    let shown = nominal.into_iter().step_by(step).chain(worst);
    let jumps = shown.map(|outcome| jump(outcome, context)).collect::<Result<_, _>>()?;
    let solids = match &context.subject.kind {
        Kind::Plan { solids, .. } => solids.clone(),
        Kind::Rule(_) => outcomes.first().map_or(Vec::new(), |o| o.trial.task.obstacles.clone()),
    };
    let obstacles = solids.iter().map(|&[from_x_m, to_x_m, top_m]| Obstacle { from_x_m, to_x_m, top_m });
    let title = format!("{} of {}", context.subject.title, context.planner.robot().name);
    Ok(page(&Scene::of(context.plant.robot(), title, obstacles.collect(), jumps)))
}

fn miss(outcome: &Outcome) -> f64 {
    outcome.miss().map_or(f64::INFINITY, f64::abs)
}

fn jump(outcome: &Outcome, context: &Context<'_>) -> Result<Jump, SimError> {
    let trial = &outcome.trial;
    let mut name = format!(
        "{} rad/s, fired at {} rad",
        digits(outcome.task.launch.rate, 3),
        digits(trial.task.launch.firing_angle, 3)
    );
    if let Kind::Plan { stages, .. } = &context.subject.kind
        && stages.len() > 1
    {
        name = format!("jump {}: {name}", trial.jump + 1);
    }
    if let Some(friction) = trial.friction {
        name = format!("{name}, friction {}", digits(friction, 3));
    }
    if trial.disturbance.is_some() {
        name += ", with errors: the worst";
    }
    let slips = match outcome.flown.report.slips_at {
        Some(_) => format!(", the foot slips {} mm", digits(1e3 * outcome.flown.slip(), 2)),
        None => String::new(),
    };
    let verdict = match outcome.miss() {
        Some(miss) => format!("lands {} mm from where it is wanted{slips}", digits(1e3 * miss, 3)),
        None => format!("{}{slips}", outcome.flown.outcome()),
    };
    let asked = Asked {
        name: name.replace('-', "−"),
        verdict: verdict.replace(" -", " −"),
        passed: outcome.passes,
        planned: planned(&trial.task, context).into_iter().map(|(x, y)| [x, y]).collect(),
        planned_apex_m: trial.apex,
        planned_land_m: trial.landing,
        landing_height_m: trial.task.landing_height,
    };
    let mut jump = Jump::of(&context.plant.rig()?, &outcome.flown.report, asked);
    jump.stand_at(trial.foot, context.plant.robot().boom.map(|boom| boom.length));
    Ok(jump)
}
