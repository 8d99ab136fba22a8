//! What to do about a verification that fails.

use saltus::verify::{Demand, Outcome, Subject, Verdict};

use super::context::Context;

/// Standard deviations that the landings of a plan should keep from the ends of their ground.
const SIGMAS: f64 = 2.0;
/// A foothold (m) that is farther from its plan is worth a word.
const OFF: f64 = 1e-3;

/// What to do, in sentences, the likeliest first; nothing where nothing is missed.
pub(super) fn advice(
    outcomes: &[Outcome],
    verdict: &Verdict,
    context: &Context<'_>,
) -> Vec<String> {
    if verdict.failures.is_empty() {
        return Vec::new();
    }
    // Whatever a plan for another robot misses, the remedy is a plan for this one.
    if let Some(sentence) = other_robot(context) {
        return vec![sentence];
    }
    let advice = [
        slipping(outcomes, context),
        adding_up(outcomes, verdict),
        no_room(verdict, context),
        too_near(verdict),
    ];
    advice.into_iter().flatten().collect()
}

/// The plan was made for a robot that is not the one that jumps.
fn other_robot(context: &Context<'_>) -> Option<String> {
    let (planned, plant) = (context.planner.robot(), context.plant.robot());
    if planned == plant || context.for_plant {
        return None;
    }
    let what = if context.subject.is_plan() {
        "plan"
    } else {
        "law or table"
    };
    if planned.name == plant.name {
        return Some(format!(
            "The {what} was made for {} without the changes of --plant-set. Make it with the same \
             changes: --set.",
            planned.name
        ));
    }
    let boom = match (planned.boom, plant.boom) {
        (None, Some(_)) => format!(", which has a boom that {} has not", planned.name),
        _ => String::new(),
    };
    let remedy = if context.subject.is_plan() {
        "verify --correct plans for the robot that jumps, as `saltus plan --plant` does."
    } else {
        "`saltus table --plant` and `saltus law --plant` make it for the robot that jumps."
    };
    Some(format!(
        "The {what} was made for {}, and {} jumps{boom}: {remedy}",
        planned.name, plant.name
    ))
}

/// Feet slip in the runs that fail.
fn slipping(outcomes: &[Outcome], context: &Context<'_>) -> Option<String> {
    let failed = outcomes
        .iter()
        .filter(|o| !o.passes())
        .flat_map(|o| &o.attempts);
    let slips = failed
        .filter(|attempt| attempt.flown().is_some_and(|f| f.report.slips_at.is_some()))
        .count();
    let remedy = match context.subject {
        Subject::Plan { .. } => " Set friction_coefficient in the course to the ground's.",
        Subject::Rule(_) => "",
    };
    (slips > 0).then(|| {
        format!(
            "The foot slips in {slips} jumps of the runs that fail: they need more friction than \
             the ground has.{remedy}"
        )
    })
}

/// Later jumps fail because they start off their footholds.
fn adding_up(outcomes: &[Outcome], verdict: &Verdict) -> Option<String> {
    let jump = verdict
        .failures
        .iter()
        .find(|failure| failure.jump > 0)?
        .jump;
    let starts = outcomes.iter().filter(|o| o.attempts[jump].was_started());
    let off = starts.map(|o| (o.attempts[jump].foot[0] - o.trial.route.stages[jump].foot[0]).abs());
    let most = off.fold(0.0, f64::max);
    (most > OFF).then(|| {
        format!(
            "Errors add up from jump to jump: jump {} starts up to {:.0} mm off its planned \
             foothold. --restart flies each jump from its planned foothold.",
            jump + 1,
            1e3 * most
        )
    })
}

/// Only the drawn errors make landings fail: the plan leaves no room for them.
fn no_room(verdict: &Verdict, context: &Context<'_>) -> Option<String> {
    let Subject::Plan { crossing, .. } = context.subject else {
        return None;
    };
    let is_of_place = |demand: Demand| demand.is_of_landing() && demand != Demand::Tolerance;
    if !is_of_errors(verdict, is_of_place) {
        return None;
    }
    let remedy = if crossing.sigmas < SIGMAS {
        format!(
            "Set margin_sigmas in the course to {SIGMAS} (it is {}).",
            crossing.sigmas
        )
    } else {
        "Make the errors less, or the places to land longer.".into()
    };
    Some(format!(
        "The plan leaves too little room for the robot's [errors] where it lands. {remedy}"
    ))
}

/// Only the drawn errors bring it too near to boxes: the planner keeps the clearance of a jump
/// without errors.
fn too_near(verdict: &Verdict) -> Option<String> {
    is_of_errors(verdict, |demand| demand == Demand::Clearance).then(|| {
        "The plan keeps clearance_m in a jump without errors; the robot's [errors] use it up. \
         Plan with more clearance_m than you need, and demand what you need: --clearance."
            .into()
    })
}

/// Whether such demands are missed in runs with errors, and in none without.
fn is_of_errors(verdict: &Verdict, concerns: impl Fn(Demand) -> bool) -> bool {
    let missed = |errors| {
        let mut these = verdict
            .failures
            .iter()
            .filter(|failure| failure.errors == errors);
        these.any(|failure| concerns(failure.demand))
    };
    missed(true) && !missed(false)
}
