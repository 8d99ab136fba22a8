//! Speed against gas: which firing angles and opening times none is better than in both.

use saltus_gait::{Draw, GaitError, drawn_robot};
use saltus_numeric::parallel;
use saltus_robot::Robot;

use super::stride::{Firing, Stride, Strides};

/// What is tried.
#[derive(Clone, Debug)]
pub struct Choices {
    /// Firing angles α_f (rad).
    pub angles: Vec<f64>,
    /// Valve opening times t_v (s).
    pub openings: Vec<f64>,
    /// How robots are drawn, how many, and their seed; none: the robot itself.
    pub drawn: Option<(Draw, usize, u64)>,
    /// Rate (rad/s) of the start, upright on a foot.
    pub rate: f64,
    /// Legs that are not counted, and those that are.
    pub legs: [usize; 2],
}

/// How a choice runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Firing angle α_f (rad).
    pub angle: f64,
    /// Valve opening time t_v (s).
    pub opening: f64,
    /// Mean speed (m/s) of the robots that run.
    pub speed: f64,
    /// Gas over the way (kg/m) of the robots that run.
    pub gas: f64,
    /// Robots that run.
    pub running: usize,
    /// Robots tried.
    pub robots: usize,
}

impl Choice {
    /// Whether `self` is better than `other` in speed or gas and not worse in the other.
    fn dominates(&self, other: &Choice) -> bool {
        let not_worse = self.speed >= other.speed && self.gas <= other.gas;
        not_worse && (self.speed > other.speed || self.gas < other.gas)
    }
}

/// How each of `choices` runs, those in which no robot does left out; on so many `threads`, the same
/// for any number. Strides are those of the ideal controller, `by` the strides' steps.
///
/// # Errors
/// [`GaitError`] for a robot or a choice that cannot be.
pub fn choices(
    robot: &Robot,
    choices: &Choices,
    by: impl Fn(Strides) -> Strides + Sync,
    threads: usize,
) -> Result<Vec<Choice>, GaitError> {
    let robots: Vec<Robot> = match &choices.drawn {
        None => vec![robot.clone()],
        Some((draw, count, seed)) => (0..*count)
            .map(|k| drawn_robot(robot, draw, *seed, k))
            .collect::<Result<_, _>>()?,
    };
    let pairs: Vec<[f64; 2]> = choices
        .angles
        .iter()
        .flat_map(|&angle| {
            choices
                .openings
                .iter()
                .map(move |&opening| [angle, opening])
        })
        .collect();
    let one = |k: usize| -> Result<Option<[f64; 2]>, GaitError> {
        let [angle, opening] = pairs[k / robots.len()];
        let robot = &robots[k % robots.len()];
        let strides = by(Strides::new(robot, Firing::new(angle, opening))?);
        Ok(steady(&strides, choices))
    };
    let all = parallel::map_on(threads, pairs.len() * robots.len(), one);
    let all: Vec<Option<[f64; 2]>> = all.into_iter().collect::<Result<_, _>>()?;
    let of_pair = pairs.iter().zip(all.chunks(robots.len().max(1)));
    Ok(of_pair
        .filter_map(|(pair, runs)| mean(*pair, runs))
        .collect())
}

/// Speed (m/s) and gas (kg/m) of a run that goes on; none where it stalls, or where the simulation
/// cannot go on.
fn steady(strides: &Strides, choices: &Choices) -> Option<[f64; 2]> {
    let [skipped, counted] = choices.legs;
    let start = strides
        .standing(strides.firing().section, choices.rate)
        .ok()?;
    let done = strides.strides(&start, skipped + counted).ok()?;
    let late = done.get(skipped..skipped + counted)?;
    let sum = |what: fn(&Stride) -> f64| late.iter().map(what).sum::<f64>();
    let travel = sum(|s| s.travel);
    Some([travel / sum(|s| s.time), sum(|s| s.gas) / travel])
}

fn mean([angle, opening]: [f64; 2], runs: &[Option<[f64; 2]>]) -> Option<Choice> {
    let running: Vec<[f64; 2]> = runs.iter().copied().flatten().collect();
    let count = running.len() as f64;
    let of = |k: usize| running.iter().map(|run| run[k]).sum::<f64>() / count;
    (!running.is_empty()).then(|| Choice {
        angle,
        opening,
        speed: of(0),
        gas: of(1),
        running: running.len(),
        robots: runs.len(),
    })
}

/// Those of `choices` in which at least this `share` of the robots run and that none of these is
/// better than, by rising speed.
pub fn frontier(choices: &[Choice], share: f64) -> Vec<Choice> {
    let enough = |c: &&Choice| c.running as f64 >= share * c.robots as f64;
    let good: Vec<Choice> = choices.iter().filter(enough).copied().collect();
    let mut best: Vec<Choice> = good
        .iter()
        .filter(|c| !good.iter().any(|other| other.dominates(c)))
        .copied()
        .collect();
    best.sort_by(|a, b| a.speed.total_cmp(&b.speed));
    best
}
