//! Which legs fire when, and for how long, to come down at a place.

use saltus_gait::space::{DrawnBalls, Knows, drawn_ball};
use saltus_gait::{GaitError, Search, search};
use saltus_numeric::parallel;
use saltus_robot::Robot;

use super::fly::{Flown, Jump, fly};
use super::guide::Guide;
use super::stance::Stance;
use super::standing::Standing;
use super::{Command, Touch};
use crate::require;

/// Plans jumps of a robot from rest.
///
/// Firings are sought in the stance model for a few drawn robots at once, so that the place of landing depends little on the
/// forces of the legs and on friction; a [`Guide`] closes their valves. Then the same robots jump in the simulation by their
/// sensors, and the plan aims aside of the target by as much as they came down aside of it.
#[derive(Clone, Debug)]
pub struct Planner {
    robot: Robot,
    draw: DrawnBalls,
    standing: Standing,
    /// The model of the robot as its file says, and its legs that stand.
    model: Stance,
    drawn: Vec<(Robot, Stance)>,
    /// Firings from which to begin, and where they land in the model (m).
    known: Vec<(Vec<f64>, [f64; 2])>,
    seed: u64,
}

/// A jump to a place.
#[derive(Clone, Debug, PartialEq)]
pub struct JumpPlan {
    /// The firings, and what closes their valves.
    pub jump: Jump,
    /// How the robot of the file comes down in the stance model, and in the simulation.
    pub modelled: Option<Touch>,
    /// The jump in the simulation.
    pub flown: Flown,
    /// Fourth root of the mean fourth power of the misses (m) in the simulation of the robots that it was sought on: the
    /// greatest of them count most.
    pub scatter: f64,
    /// How far (m) the mean of where they come down is from the target.
    pub off: f64,
    /// Miss (m) of the robot of the file in the simulation.
    pub miss: f64,
}

/// How far (m) from its target the mean of where robots land may be for it to be reached.
pub const REACHED: f64 = 0.02;

impl JumpPlan {
    /// Whether the target is in reach: robots land around it, and not to one side of it.
    pub fn is_reached(&self) -> bool {
        self.off <= REACHED
    }
}

/// Opening times (s) and moments (s) from which the search begins.
const OPENS: [f64; 6] = [0.0, 0.01, 0.015, 0.022, 0.032, 0.05];
const MOMENTS: [f64; 3] = [0.0, 0.01, 0.02];
/// By how much (m) a robot that turns lands higher than it stands.
const HIGHER: f64 = 0.02;
/// Greatest of both (s).
const MOST_OPEN: f64 = 0.06;
const LATEST: f64 = 0.03;
/// A shorter opening (s) does not fire.
const SHORTEST: f64 = 0.004;
/// Farthest target (m) that is sought at all.
const FARTHEST: f64 = 100.0;
/// From how far (m) of all known landings on a target is out of reach: the search moves a landing by some centimetres.
const BEYOND: f64 = 0.3;
/// What a robot counts as missing (m) that does not jump.
const STAYS: f64 = 1.0;
/// How many known firings are tried on all drawn robots, and from how many of them the search begins.
const TRIED: usize = 200;
const BEGUN: usize = 3;
/// Generations of the first search, and of one that begins with what was found before.
const GENERATIONS: [usize; 2] = [12, 6];
/// How often the plan is corrected by where the simulation lands, and when (m) that is enough.
const CORRECTIONS: usize = 3;
const NEAR: f64 = 5e-3;

impl Planner {
    /// For `robot`, `standing` at rest; plans are sought on so many robots `sought_on`, drawn by `draw` from `seed`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, legs that are not of constant force, and numbers that cannot be.
    pub fn new(
        robot: &Robot,
        standing: Standing,
        draw: &DrawnBalls,
        (sought_on, seed): (usize, u64),
        threads: usize,
    ) -> Result<Planner, GaitError> {
        let allowed = "from 1 to 100";
        let sound = (1..=100).contains(&sought_on);
        require(sound, "robots to seek on", sought_on as f64, allowed)?;
        let model = Stance::new(robot)?;
        let drawn = (0..sought_on).map(|k| {
            let mut own = drawn_ball(robot, draw, seed, k)?;
            // Spread evenly, as they are few.
            let part = (k as f64 + 0.5) / sought_on as f64;
            let friction = draw.friction[0] + part * (draw.friction[1] - draw.friction[0]);
            own.ground.static_friction = friction;
            own.ground.kinetic_friction = friction;
            let model = Stance::new(&own)?;
            Ok((own, model))
        });
        let drawn = drawn.collect::<Result<_, GaitError>>()?;
        let mut planner = Planner {
            robot: robot.clone(),
            draw: *draw,
            standing,
            model,
            drawn,
            known: Vec::new(),
            seed,
        };
        let all = planner.beginnings();
        let lands = parallel::map_on(threads, all.len(), |k| planner.lands(&all[k]));
        let both = all.into_iter().zip(lands);
        planner.known = both.filter_map(|(x, at)| Some((x, at?))).collect();
        Ok(planner)
    }

    /// How it stands.
    pub fn standing(&self) -> &Standing {
        &self.standing
    }

    /// Every leg that stands with each opening time and moment of the tables.
    fn beginnings(&self) -> Vec<Vec<f64>> {
        let feet = self.feet().len();
        let mut all: Vec<Vec<f64>> = vec![Vec::new()];
        for _ in 0..feet {
            all = all
                .iter()
                .flat_map(|x| {
                    let with = |open: f64, at: f64| [x.as_slice(), &[open, at]].concat();
                    let fired = OPENS[1..]
                        .iter()
                        .flat_map(move |open| MOMENTS.iter().map(move |at| with(*open, *at)));
                    std::iter::once(with(0.0, 0.0))
                        .chain(fired)
                        .collect::<Vec<_>>()
                })
                .collect();
        }
        let begins_at_once = |x: &Vec<f64>| {
            let pairs = x.chunks(2).filter(|pair| pair[0] > 0.0);
            pairs.map(|pair| pair[1]).fold(f64::INFINITY, f64::min) == 0.0
        };
        all.retain(begins_at_once);
        all
    }

    /// The feet that it fires: at most three of those on which it stands.
    fn feet(&self) -> &[usize] {
        let legs = &self.standing.rest.legs;
        &legs[..legs.len().min(3)]
    }

    /// The firings of the numbers `x`: opening time and moment of each foot.
    fn commands(&self, x: &[f64]) -> Vec<Command> {
        let period = self.robot.sensors.unwrap_or_default().period;
        let fires = |open: f64| open >= SHORTEST;
        let pairs = || x.chunks(2).filter(|pair| fires(pair[0]));
        let first = pairs().map(|pair| pair[1]).fold(f64::INFINITY, f64::min);
        let legs = self.feet().iter().zip(x.chunks(2));
        let fired = legs.filter(|(_, pair)| fires(pair[0]));
        fired
            .map(|(leg, pair)| Command {
                leg: *leg,
                // A controller fires at the beginning of a cycle.
                at: ((pair[1] - first) / period).round() * period,
                open: pair[0],
            })
            .collect()
    }

    fn lands(&self, x: &[f64]) -> Option<[f64; 2]> {
        lands(&self.model, &self.standing, &self.commands(x), None)
    }

    /// What closes valves on the way to `aim` (m): for a landing as high as the robot stands there.
    fn guide(&self, aim: [f64; 2]) -> Guide {
        let height = self.standing.place[2] + self.standing.floor(aim[0]);
        Guide::new(&self.robot, aim, height + HIGHER)
    }

    /// Misses of the drawn robots in the model, as one number (m).
    fn misses(&self, x: &[f64], aim: [f64; 2]) -> f64 {
        let commands = self.commands(x);
        let guide = self.guide(aim);
        together(self.drawn.iter().map(|(_, model)| {
            let at = lands(model, &self.standing, &commands, Some(guide.clone()));
            at.map_or(STAYS, |at| far(at, aim))
        }))
    }

    /// The known firings that land nearest to `aim` (m), and where.
    fn nearest(&self, aim: [f64; 2]) -> Option<&(Vec<f64>, [f64; 2])> {
        let miss = |known: &&(Vec<f64>, [f64; 2])| far(known.1, aim);
        let known = self.known.iter();
        known.min_by(|a, b| miss(a).total_cmp(&miss(b)))
    }

    /// Firings from which to begin to seek those that land at `aim` (m): of the known ones that land near it, those that miss
    /// it least on all drawn robots.
    fn starts(&self, aim: [f64; 2], threads: usize) -> Vec<Vec<f64>> {
        let by_second =
            |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0));
        let mut order: Vec<(usize, f64)> = (self.known.iter())
            .map(|(_, at)| far(*at, aim))
            .enumerate()
            .collect();
        order.sort_by(by_second);
        order.truncate(TRIED);
        let tried = parallel::map_on(threads, order.len(), |k| {
            self.misses(&self.known[order[k].0].0, aim)
        });
        for (entry, miss) in order.iter_mut().zip(tried) {
            entry.1 = miss;
        }
        order.sort_by(by_second);
        let best = order.iter().take(BEGUN);
        best.map(|(place, _)| self.known[*place].0.clone())
            .collect()
    }

    /// Firings that land at `aim` (m) in the model, sought from each of `starts`.
    fn seek(
        &self,
        aim: [f64; 2],
        starts: &[Vec<f64>],
        generations: usize,
        threads: usize,
    ) -> Vec<f64> {
        let bounds: Vec<[f64; 2]> = (0..self.feet().len())
            .flat_map(|_| [[0.0, MOST_OPEN], [0.0, LATEST]])
            .collect();
        let mut best: (Vec<f64>, f64) = (Vec::new(), f64::NEG_INFINITY);
        for start in starts {
            let sought = Search {
                bounds: bounds.clone(),
                start: start.clone(),
                spread: 0.08,
                candidates: 32,
                best: 6,
                generations,
                seed: self.seed,
            };
            let score = |x: &[f64]| -self.misses(x, aim);
            let found = search(&sought, threads, score, |_, _, _| {});
            if found.1 > best.1 {
                best = found;
            }
        }
        best.0
    }

    /// The jump to `target` (m), from the middle of the feet on which the robot stands.
    ///
    /// It is the nearest that was found where the target is out of reach: [`JumpPlan::miss`] says how near. Far beyond all known
    /// landings nothing is sought.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a target that is not finite, [`GaitError::Sim`] for a motion that cannot go on.
    pub fn to(&self, target: [f64; 2], threads: usize) -> Result<JumpPlan, GaitError> {
        for (name, x) in [("target x (m)", target[0]), ("target y (m)", target[1])] {
            require(
                x.abs() <= FARTHEST,
                name,
                x,
                "a finite number from -100 to 100 m",
            )?;
        }
        if let Some((x, at)) = self.nearest(target)
            && far(*at, target) > BEYOND
        {
            let off = far(*at, target);
            return self.flown(self.jump(x, *at), (off, off), target);
        }
        let mut aim = target;
        let mut best: Option<JumpPlan> = None;
        let mut starts = self.starts(target, threads);
        let mut generations = GENERATIONS[0];
        for _ in 0..CORRECTIONS {
            let x = self.seek(aim, &starts, generations, threads);
            (starts, generations) = (vec![x.clone()], GENERATIONS[1]);
            let jump = self.jump(&x, aim);
            let flown = parallel::map_on(threads, self.drawn.len(), |k| {
                let jump = jump.by_sensors(self.seed.wrapping_add(k as u64));
                fly(&self.drawn[k].0, &self.standing, &jump, 0.0)
            });
            let flown = flown.into_iter().collect::<Result<Vec<_>, _>>()?;
            let places: Vec<[f64; 2]> = flown.iter().filter_map(clear).collect();
            let miss = |flown: &Flown| clear(flown).map_or(STAYS, |at| far(at, target));
            let scatter = together(flown.iter().map(miss));
            let middle = |k: usize| mean(places.iter().map(|at| at[k]));
            let off = [target[0] - middle(0), target[1] - middle(1)];
            let length = off[0].hypot(off[1]);
            if best.as_ref().is_none_or(|best| scatter < best.scatter) {
                best = Some(self.flown(jump, (scatter, length), target)?);
            }
            if places.is_empty() || length < NEAR {
                break;
            }
            aim = [aim[0] + off[0], aim[1] + off[1]];
        }
        match best {
            Some(best) => Ok(best),
            None => self.flown(self.jump(&[], target), (STAYS, STAYS), target),
        }
    }

    fn jump(&self, x: &[f64], aim: [f64; 2]) -> Jump {
        Jump {
            commands: self.commands(x),
            guide: Some(self.guide(aim)),
            knows: Knows::Sensors(self.seed),
        }
    }

    /// The robot of the file jumps as `jump` says.
    fn flown(
        &self,
        jump: Jump,
        (scatter, off): (f64, f64),
        target: [f64; 2],
    ) -> Result<JumpPlan, GaitError> {
        let guide = jump.guide.clone();
        let modelled = self.model.jump(&self.standing, &jump.commands, guide);
        let flown = fly(&self.robot, &self.standing, &jump, 0.0)?;
        let miss = landed(&flown).map_or(f64::INFINITY, |at| far(at, target));
        Ok(JumpPlan {
            jump,
            modelled: modelled.map(|(_, touch)| touch),
            flown,
            scatter,
            off,
            miss,
        })
    }

    /// Robot `k` of others, drawn from `seed`, jumps as `plan` says, by its sensors, and is followed `after` (s) its landing.
    ///
    /// # Errors
    /// [`GaitError`] for a motion that cannot go on.
    pub fn other(
        &self,
        plan: &JumpPlan,
        (seed, k): (u64, usize),
        after: f64,
    ) -> Result<Flown, GaitError> {
        let robot = drawn_ball(&self.robot, &self.draw, seed, k)?;
        let jump = plan.jump.by_sensors(seed.wrapping_add(k as u64));
        fly(&robot, &self.standing, &jump, after)
    }

    /// Where the first firings land in the model (m): the extent of what can be reached.
    pub fn known(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.known.iter().map(|(_, at)| *at)
    }
}

/// Where a jump comes down (m) that has not run against a box.
fn clear(flown: &Flown) -> Option<[f64; 2]> {
    landed(flown).filter(|_| flown.clearance > 0.0)
}

/// Where a jump comes down (m).
pub fn landed(flown: &Flown) -> Option<[f64; 2]> {
    flown.touch.map(|touch| [touch.place[0], touch.place[1]])
}

fn lands(
    model: &Stance,
    standing: &Standing,
    commands: &[Command],
    guide: Option<Guide>,
) -> Option<[f64; 2]> {
    let (_, touch) = model.jump(standing, commands, guide)?;
    Some([touch.place[0], touch.place[1]])
}

/// Distance (m) between two places.
pub(super) fn far(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

/// Misses (m) as one number, of which the greatest count most.
fn together(misses: impl Iterator<Item = f64>) -> f64 {
    mean(misses.map(|miss| miss.powi(4))).sqrt().sqrt()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0_f64);
    for value in values {
        sum += value;
        count += 1.0;
    }
    sum / count.max(1.0)
}
