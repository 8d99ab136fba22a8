//! What a planned experiment can tell of a robot, and which jumps tell most.

use saltus_diagnosis::kinds::{self, Problem};
use saltus_diagnosis::{
    Experiment, Kind, Power, Settings, Shown, Sort, power, shown, visible, visible_by_each,
};
use saltus_numeric::parallel;
use saltus_robot::Robot;

use crate::experiment::Plan;
use crate::inject::{self, Asked, Effect, effect_of};

/// By how many standard deviations of noise and of the model's own error all readings together show
/// an effect whose size is not given.
pub const SEEN: [f64; 2] = [6.0, 12.0];

/// What a plan can tell.
#[derive(Clone, Debug)]
pub struct Told {
    /// Runs of the plan, or jumps of outcomes.
    pub runs: usize,
    /// What it can tell of each effect.
    pub effects: Vec<Power>,
    /// Ids of causes that no size which physics allows makes visible by the first of [`SEEN`]; empty
    /// where sizes were given.
    pub hidden: Vec<&'static str>,
}

/// Jumps that tell most, and what.
#[derive(Clone, Debug)]
pub struct Proposed {
    /// What to ask of each jump.
    pub jumps: Vec<Asked>,
    /// What they tell of the effects of the plan.
    pub told: Told,
}

/// Why a plan says nothing.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PowerError {
    /// Kind and robot do not go together, there is no motion, or no such effect.
    #[error(transparent)]
    Data(#[from] inject::Error),
    /// The same of the model.
    #[error(transparent)]
    Model(#[from] Problem),
    /// Jumps are proposed where there are jumps.
    #[error("kind = \"{kind}\": must be jump or outcomes for jumps to be proposed")]
    NoJumps {
        /// The kind.
        kind: &'static str,
    },
    /// None of the jumps that could be proposed is one.
    #[error("robot {robot} does not jump at any of the settings that could be proposed")]
    NoJump {
        /// The robot.
        robot: String,
    },
}

/// An effect: the index of its cause, and the values of its parameters.
type Sized = (usize, Vec<f64>);

/// What `plan` can tell of `effects` of `robot`; without any, of every cause at sizes that all
/// readings together show by [`SEEN`]. `progress` is told what is being done.
///
/// # Errors
/// [`PowerError`] where plan, robot and effects do not go together.
pub fn told(
    plan: &Plan,
    robot: Option<&Robot>,
    effects: &[Effect],
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Told, PowerError> {
    let experiment = plan.experiment(robot, settings.seed)?;
    let kind = kinds::build(&experiment, robot)?;
    let sized = sized(kind.as_ref(), plan.kind, robot, effects, settings)?;
    Ok(of(
        &experiment,
        kind.as_ref(),
        &sized,
        effects,
        settings,
        progress,
    ))
}

/// The effects that are asked for, or every cause at the sizes of [`SEEN`].
fn sized(
    kind: &dyn Kind,
    sort: Sort,
    robot: Option<&Robot>,
    effects: &[Effect],
    settings: &Settings,
) -> Result<Vec<Sized>, PowerError> {
    if effects.is_empty() {
        return Ok(visible(kind, &SEEN, settings));
    }
    let each = effects
        .iter()
        .map(|asked| effect_of(kind, asked, sort, robot));
    Ok(each.collect::<Result<_, _>>()?)
}

fn of(
    experiment: &Experiment,
    kind: &dyn Kind,
    sized: &[Sized],
    effects: &[Effect],
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Told {
    let ids = kind.causes()[kind.common()..kind.listed()]
        .iter()
        .map(|cause| cause.id);
    let is_sized = |id: &str| sized.iter().any(|(c, _)| kind.causes()[*c].id == id);
    let mut hidden: Vec<&'static str> = ids.filter(|id| !is_sized(id)).collect();
    hidden.dedup();
    let jumps = experiment.runs.iter().map(|run| run.time.len());
    Told {
        runs: match experiment.kind {
            Sort::Outcomes => jumps.sum(),
            _ => experiment.runs.len(),
        },
        effects: power(kind, sized, settings, progress),
        hidden: if effects.is_empty() {
            hidden
        } else {
            Vec::new()
        },
    }
}

/// The `count` jumps that tell the effects of `plan` apart best, of a grid of launches.
///
/// Each jump of the grid shows each effect as a vector in standard deviations of its readings, and
/// products of these vectors add up over jumps. By them, the distance between what one effect does and
/// the nearest that another cause does, with all of its parameters, is known for every set of jumps. Jumps are added, and then
/// exchanged, while the mean over all effects of the distance to the nearest other one grows, where
/// five standard deviations of a reading are enough.
///
/// # Errors
/// As [`told`], and where the kind has no jumps.
pub fn propose(
    plan: &Plan,
    robot: Option<&Robot>,
    effects: &[Effect],
    count: usize,
    settings: &Settings,
    progress: &(dyn Fn(&str) + Sync),
) -> Result<Proposed, PowerError> {
    let jumps = matches!(plan.kind, Sort::Jump | Sort::Outcomes);
    let Some(robot) = robot.filter(|_| jumps) else {
        let kind = plan.kind.spec().id;
        return Err(PowerError::NoJumps { kind });
    };
    let experiment = plan.experiment(Some(robot), settings.seed)?;
    let kind = kinds::build(&experiment, Some(robot))?;
    let sized = sized(kind.as_ref(), plan.kind, Some(robot), effects, settings)?;
    // They are to be told from every cause, not only from each other.
    let mut all = sized.clone();
    all.extend(visible_by_each(kind.as_ref(), SEEN[0], settings));
    let grid = grid(plan.kind, robot);
    let shown = parallel::map(grid.len(), |k| {
        progress("a launch");
        let experiment = plan.asking(&grid[k..=k], Some(robot), settings.seed).ok()?;
        let there = kinds::build(&experiment, Some(robot)).ok()?;
        shown(there.as_ref(), &all, settings)
    });
    let shows: Vec<(Asked, Shown)> = grid
        .into_iter()
        .zip(shown)
        .filter_map(|(asked, shown)| Some((asked, shown?)))
        .collect();
    if shows.is_empty() {
        let robot = robot.name.clone();
        return Err(PowerError::NoJump { robot });
    }
    // An effect that is asked for is one of its own, those of each parameter are what a cause can do.
    let source = |k: usize| {
        if k < sized.len() {
            k
        } else {
            sized.len() + all[k].0
        }
    };
    let causes = (0..all.len()).map(|k| (source(k), kind.causes()[all[k].0].id));
    let causes: Vec<(usize, &str)> = causes.collect();
    let jumps = chosen(&shows, &causes, sized.len(), count);
    let experiment = plan.asking(&jumps, Some(robot), settings.seed)?;
    let there = kinds::build(&experiment, Some(robot))?;
    let told = of(
        &experiment,
        there.as_ref(),
        &sized,
        effects,
        settings,
        progress,
    );
    Ok(Proposed { jumps, told })
}

/// Launches of which jumps are proposed.
fn grid(kind: Sort, robot: &Robot) -> Vec<Asked> {
    let own = robot.leg.cylinder().map(|cylinder| cylinder.supply.0);
    let supplies: &[Option<f64>] = match (kind, own) {
        (Sort::Jump, Some(own)) => &[Some(own), Some(0.8 * own)],
        _ => &[None],
    };
    let mut all = Vec::new();
    for rate in [3.0, 4.0, 5.0, 6.0] {
        for firing_angle in [-0.25, -0.1, 0.05, 0.2, 0.3] {
            for valve_open in [0.03, 0.05, 0.1] {
                all.extend(supplies.iter().map(|&supply| Asked {
                    rate,
                    firing_angle,
                    valve_open,
                    supply,
                }));
            }
        }
    }
    all
}

/// Of the jumps that show effects, of these sources (number and id), so many that tell the first `asked` of
/// them from all others best.
fn chosen(
    shows: &[(Asked, Shown)],
    causes: &[(usize, &str)],
    asked: usize,
    count: usize,
) -> Vec<Asked> {
    let mut set: Vec<usize> = Vec::new();
    let total = |set: &[usize]| Shown::sum(set.iter().map(|k| &shows[*k].1));
    let best = |sum: &Shown| {
        let scores = parallel::map(shows.len(), |k| sum.with(&shows[k].1).apart(causes, asked));
        (0..shows.len()).max_by(|a, b| scores[*a].total_cmp(&scores[*b]))
    };
    while set.len() < count {
        set.extend(best(&total(&set)));
    }
    // Each in turn gives way to a better one.
    for _ in 0..2 {
        for place in 0..set.len() {
            let rest: Vec<usize> = (0..set.len())
                .filter(|k| *k != place)
                .map(|k| set[k])
                .collect();
            if let Some(k) = best(&total(&rest)) {
                set[place] = k;
            }
        }
    }
    set.sort_unstable();
    set.into_iter().map(|k| shows[k].0).collect()
}
