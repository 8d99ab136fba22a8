//! Plans that hold for a share of the jumps with errors drawn, in the multi-body simulation.
//!
//! The scatter of the simulated jumps says what each demand of the course needs beside its limit,
//! and the plan is made with that margin.

use saltus_planner::course::{FRICTION, Limit, Relief, Watch};
use saltus_planner::{Crossing, CrossingAnswer, CrossingError, CrossingPlan};
use saltus_robot::Robot;

use crate::on_plant::{Crossed, OnPlant, PlantError, for_crossing};
use crate::verify::{Demand, Outcome, Plant, Subject, TrialError, Verification};

/// Error that the simulation of drawn jumps makes in each step, relative to 1 + |y|.
pub(crate) const ACCURACY: f64 = 1e-9;

/// Rounds of planning and drawing.
const ROUNDS: usize = 12;

/// Part of what a demand has beside its limit and its margin that the next round takes off the
/// margin: another demand may need it.
const GIVEN_BACK: f64 = 0.5;

/// Margins are made a little greater than the draws ask for, so that the next round is not short by
/// a hair.
const GROWTH: f64 = 1.05;

/// What runs with errors drawn are for; each has draws of its own.
#[derive(Clone, Copy)]
enum Draws {
    /// To find margins, and to end the rounds.
    Rounds,
    /// To tell how often the plan holds: these made neither the margins nor the choice.
    Count,
}

/// Most runs that margins are found by; those that count are as many as are asked for.
const RUNS: usize = 100;

impl Draws {
    fn seed(self, seed: u64) -> u64 {
        match self {
            Draws::Rounds => seed,
            Draws::Count => seed ^ 0xc0de,
        }
    }
}

/// What a plan keeps beside the limits of its course.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Margins {
    /// Of the wheel over boxes (m).
    pub clearance: f64,
    /// Of landings from the ends of their ground (m).
    pub landing: f64,
    /// Of the friction coefficient.
    pub friction: f64,
}

/// A plan, and how well it holds.
#[derive(Debug)]
pub struct Held {
    /// The plan, and the planner that made it.
    pub crossed: Crossed,
    /// What it keeps.
    pub margins: Margins,
    /// Share of runs that pass, of those that the margins were not made by.
    pub share: f64,
    /// What is missed most often in the others, if anything.
    pub missed: Option<Demand>,
    /// The least margins that no plan was found with, each beside those of the other demands;
    /// infinite where none was refused.
    pub refused: Margins,
    /// Each friction coefficient asked for, and the last landing (m along the course) there without
    /// errors, if the robot gets there.
    pub grounds: Vec<(f64, Option<f64>)>,
}

/// What a course comes to where errors are drawn.
#[derive(Debug)]
pub enum Robust {
    /// The plan that holds most often.
    Plan {
        /// The plan.
        held: Held,
        /// Where it holds less often than asked: what blocks a plan with the margins that it would
        /// take.
        blocked: Option<Relief>,
    },
    /// There is no plan, whatever it keeps; the answer says why.
    None(Crossed),
}

/// A course that cannot be planned for a share of jumps.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RobustError {
    /// The course.
    #[error(transparent)]
    Crossing(#[from] CrossingError),
    /// A jump.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// The ground of the plant.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

/// A plan for `crossing` on `plant` that holds for the share of `how` of its runs with drawn errors,
/// on its grounds. The course's standard deviations count no more: what scatters is simulated.
///
/// # Errors
/// [`RobustError`] for a value outside its domain.
pub fn plan(
    robot: &Robot,
    plant: &OnPlant,
    crossing: &Crossing,
    how: &Verification,
    watch: &Watch<'_>,
) -> Result<Robust, RobustError> {
    // On one ground the plan is made for that ground; on several for the plant's own.
    let ground = match how.frictions[..] {
        [Some(friction)] => {
            let ground = Plant::new(plant.robot().clone(), ACCURACY).on_friction(friction);
            Some(OnPlant::new(robot, ground.robot())?)
        }
        _ => None,
    };
    let plant = ground.as_ref().unwrap_or(plant);
    let search = Search {
        robot,
        plant,
        crossing,
        how,
        watch,
        ground: Plant::new(plant.robot().clone(), ACCURACY),
    };
    search.run()
}

struct Search<'a> {
    robot: &'a Robot,
    plant: &'a OnPlant,
    crossing: &'a Crossing,
    how: &'a Verification,
    watch: &'a Watch<'a>,
    ground: Plant,
}

type Plan = CrossingPlan;

impl Search<'_> {
    fn run(&self) -> Result<Robust, RobustError> {
        let mut margins = Margins::default();
        let mut best: Option<Held> = None;
        let mut explored = Explored::default();
        let mut blocked: Option<Relief> = None;
        for _ in 0..ROUNDS {
            let crossed = self.cross(margins)?;
            let plan = match &crossed.answer {
                CrossingAnswer::Plan(plan) => plan,
                other => {
                    if best.is_none() {
                        return Ok(Robust::None(crossed));
                    }
                    let relief = match other {
                        CrossingAnswer::Infeasible { relief, .. } => Some(relief.clone()),
                        _ => None,
                    };
                    margins = explored.refuse(margins, relief.as_ref());
                    blocked = relief.or(blocked);
                    continue;
                }
            };
            let outcomes = self.runs(plan, &crossed, Draws::Rounds)?;
            let needed = self.needed(&outcomes, margins);
            let (share, missed) = share(&outcomes);
            explored.had = margins;
            if best.as_ref().is_none_or(|held| share > held.share) {
                best = Some(Held {
                    crossed,
                    margins,
                    share,
                    missed,
                    grounds: Vec::new(),
                    refused: Margins::default(),
                });
            }
            if share >= self.aim() {
                blocked = None;
                break;
            }
            let next = explored.allowed(needed);
            if next.is_near(margins) {
                break;
            }
            margins = next;
        }
        match best {
            Some(mut held) => {
                if let CrossingAnswer::Plan(plan) = &held.crossed.answer {
                    let outcomes = self.runs(plan, &held.crossed, Draws::Count)?;
                    (held.share, held.missed) = share(&outcomes);
                    held.grounds = grounds(&outcomes);
                    held.refused = explored.refused;
                    // Margins are no limits of the course.
                    let own = Crossing {
                        sigmas: 0.0,
                        ..self.crossing.clone()
                    };
                    held.crossed.answer = CrossingAnswer::Plan(self.plant.flown(&own, plan)?);
                }
                Ok(Robust::Plan { held, blocked })
            }
            None => Ok(Robust::None(self.cross(Margins::default())?)),
        }
    }

    /// The share at which the rounds end: above the one that is asked for, by one binomial standard
    /// deviation of the runs, for other draws to reach that one.
    fn aim(&self) -> f64 {
        let asked = self.how.share;
        let deviation = (asked * (1.0 - asked) / self.how.samples.max(1) as f64).sqrt();
        (asked + deviation).min(1.0 - 0.5 * (1.0 - asked))
    }

    fn cross(&self, margins: Margins) -> Result<Crossed, CrossingError> {
        let crossing = Crossing {
            sigmas: 0.0,
            clearance: self.crossing.clearance + margins.clearance,
            edge_margin: self.crossing.edge_margin + margins.landing,
            friction: self
                .crossing
                .friction
                .map(|mu| (mu - margins.friction).max(0.0)),
            ..self.crossing.clone()
        };
        let crossed = for_crossing(self.robot.clone(), Some(self.plant), &crossing, self.watch);
        match crossed {
            // Margins that leave no room between the ends of a zone leave no plan.
            Err(CrossingError::Input { .. }) if margins != Margins::default() => {
                let answer = CrossingAnswer::Infeasible {
                    relief: Relief {
                        gives: Vec::new(),
                        total: 0.0,
                        decisions: Vec::new(),
                    },
                    jumps: None,
                };
                let plain = for_crossing(self.robot.clone(), None, self.crossing, self.watch)?;
                Ok(Crossed { answer, ..plain })
            }
            crossed => crossed,
        }
    }

    /// Runs of a plan with errors drawn.
    fn runs(
        &self,
        plan: &Plan,
        crossed: &Crossed,
        draws: Draws,
    ) -> Result<Vec<Outcome>, TrialError> {
        let samples = match draws {
            Draws::Rounds => self.how.samples.min(RUNS),
            Draws::Count => self.how.samples,
        };
        let how = Verification {
            samples,
            seed: draws.seed(self.how.seed),
            ..self.how.clone()
        };
        let subject = Subject::plan(self.crossing.clone(), plan.clone());
        let radius = self.robot.body.radius;
        let trials = how.trials(&subject, &crossed.planner, radius)?;
        Ok(how.fly(&self.ground, &trials, &|| ()))
    }

    /// Margins with which the share asked for would have passed `outcomes`, which had `margins`, had
    /// all else stayed: less where there was more than enough.
    fn needed(&self, outcomes: &[Outcome], margins: Margins) -> Margins {
        let drawn: Vec<&Outcome> = outcomes.iter().filter(|o| o.trial.has_errors()).collect();
        let by = |had: f64, kinds: &dyn Fn(Demand) -> bool| {
            let worst = |outcome: &&Outcome| {
                let judgements = outcome.attempts.iter().flat_map(|a| &a.judgements);
                let of_kind = judgements.filter(|j| kinds(j.demand) && j.margin.is_finite());
                of_kind.map(|j| j.margin).fold(f64::INFINITY, f64::min)
            };
            let mut worst: Vec<f64> = drawn.iter().map(worst).collect();
            worst.sort_by(f64::total_cmp);
            // Each of three kinds may take its part of the runs that fail.
            let may_fail = (1.0 - self.aim()) / 3.0 * worst.len() as f64;
            let at = worst
                .iter()
                .zip(0_u32..)
                .find(|(_, k)| f64::from(*k) >= may_fail.floor());
            at.filter(|(spare, _)| spare.is_finite())
                .map_or(had, |(spare, _)| {
                    let part = if *spare < 0.0 { GROWTH } else { GIVEN_BACK };
                    (had - part * spare).max(0.0)
                })
        };
        Margins {
            clearance: by(margins.clearance, &|d| {
                matches!(d, Demand::Clearance | Demand::Stance)
            }),
            landing: by(margins.landing, &|d| {
                d.is_of_landing() && d != Demand::Tolerance
            }),
            friction: by(margins.friction, &|d| d == Demand::Friction),
        }
    }
}

/// Share of runs that pass, and what the others miss most often. The runs without errors have to
/// pass all.
fn share(outcomes: &[Outcome]) -> (f64, Option<Demand>) {
    let (drawn, exact): (Vec<_>, Vec<_>) = outcomes.iter().partition(|o| o.trial.has_errors());
    let passed = drawn.iter().filter(|o| o.passes()).count();
    let missed = |demand: &Demand| {
        let misses = |o: &&&Outcome| {
            let mut judgements = o.attempts.iter().flat_map(|a| &a.judgements);
            judgements.any(|j| j.demand == *demand && !j.holds())
        };
        drawn.iter().filter(misses).count()
    };
    let most = Demand::ALL.into_iter().max_by_key(missed);
    let share = if exact.iter().all(|o| o.passes()) {
        passed as f64 / drawn.len().max(1) as f64
    } else {
        0.0
    };
    (share, most.filter(|demand| missed(demand) > 0))
}

/// Where the last jump lands without errors, on each ground.
fn grounds(outcomes: &[Outcome]) -> Vec<(f64, Option<f64>)> {
    let exact = outcomes.iter().filter(|o| !o.trial.has_errors());
    exact
        .filter_map(|o| Some((o.trial.friction?, o.attempts.last()?.landing())))
        .collect()
}

/// Margins that were tried.
struct Explored {
    /// The last ones with which there was a plan.
    had: Margins,
    /// The least of each demand with which there was none.
    refused: Margins,
}

impl Default for Explored {
    fn default() -> Explored {
        let none = f64::INFINITY;
        Explored {
            had: Margins::default(),
            refused: Margins {
                clearance: none,
                landing: none,
                friction: none,
            },
        }
    }
}

impl Explored {
    /// Half way back to what was had, with the demands that block; with all of them where none is
    /// named.
    fn refuse(&mut self, margins: Margins, relief: Option<&Relief>) -> Margins {
        let blocks = |blocks: &dyn Fn(Limit) -> bool| {
            relief.is_some_and(|relief| relief.gives.iter().any(|give| blocks(give.limit)))
        };
        let named = [
            blocks(&|limit| limit.obstacle().is_some()),
            blocks(&|limit| matches!(limit, Limit::Landing(_) | Limit::Goal)),
            blocks(&|limit| limit == FRICTION),
        ];
        let (had, mut next) = (self.had.each(), margins.each());
        let moves = |k: usize| named[k] && next[k] > had[k];
        let all = !(0..3).any(moves);
        let mut refused = self.refused.each();
        for k in 0..3 {
            if all || (named[k] && next[k] > had[k]) {
                if next[k] > had[k] {
                    refused[k] = refused[k].min(next[k]);
                }
                next[k] = f64::midpoint(had[k], next[k]);
            }
        }
        self.refused = Margins::of(refused);
        Margins::of(next)
    }

    /// `needed`, but half way to what was refused of a demand that would need as much.
    fn allowed(&self, needed: Margins) -> Margins {
        let (had, refused, mut next) = (self.had.each(), self.refused.each(), needed.each());
        for k in 0..3 {
            if next[k] >= refused[k] {
                next[k] = f64::midpoint(had[k], refused[k]);
            }
        }
        Margins::of(next)
    }
}

impl Margins {
    fn each(self) -> [f64; 3] {
        [self.clearance, self.landing, self.friction]
    }

    fn of([clearance, landing, friction]: [f64; 3]) -> Margins {
        Margins {
            clearance,
            landing,
            friction,
        }
    }

    /// Whether each is the other's but for a tenth of a millimetre, or 1e-4.
    fn is_near(self, other: Margins) -> bool {
        let pairs = self.each().into_iter().zip(other.each());
        pairs.into_iter().all(|(a, b)| (a - b).abs() < 1e-4)
    }
}
