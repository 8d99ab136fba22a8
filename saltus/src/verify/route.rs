//! Jumps one after the other over a course, and what becomes of them.

use saltus_lagrangian::Launch;
use saltus_planner::course::Span;
use saltus_planner::{Crossing, CrossingPlan, PlannedJump};
use saltus_sim_check::SimError;

use crate::course::demanded_target;

use super::demand::{Demand, Demands, Judgement, Landing, length};
use super::{Disturbance, Flown, Plant, Task};

/// Places (m) at and beyond which a course has no limit: the planner takes none farther away.
const OPEN: f64 = 1e4;

/// A jump as it is planned. Places are along the course, heights above its ground (m).
#[derive(Clone, Debug, PartialEq)]
pub struct Stage {
    /// How it starts, and what it is commanded.
    pub launch: Launch,
    /// Foothold, and the height of its surface.
    pub foot: [f64; 2],
    /// Height of the axle above the foothold at which it lands.
    pub landing_height: f64,
    /// Height of the surface that it lands on; none: nothing is asked of the ground there.
    pub surface: Option<f64>,
    /// Greatest height of the axle, as planned; NaN where the planner has none.
    pub apex: f64,
    /// Landing, as planned; NaN where the planner has none.
    pub landing: f64,
    /// Landing, as wanted.
    pub wanted: f64,
}

/// Jumps that follow each other, and what is demanded of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// Jump after jump.
    pub stages: Vec<Stage>,
    /// What each has to meet.
    pub demands: Demands,
}

/// Where the jumps after the first start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Starts {
    /// Where the jump before really landed, after the course's roll: errors add up.
    Chained,
    /// At their planned footholds.
    Planned,
}

/// What became of a jump.
#[derive(Clone, Debug)]
pub enum Flight {
    /// It was simulated.
    Flown(Box<Flown>),
    /// The simulation could not go on.
    Failed(SimError),
    /// It was not made: the jump before left no foothold.
    NotStarted,
}

/// One jump of a run, judged.
#[derive(Clone, Debug)]
pub struct Attempt {
    /// Foothold (m along the course), and the height of its surface (m).
    pub foot: [f64; 2],
    /// Launch as it really was.
    pub launch: Launch,
    /// What became of it.
    pub flight: Flight,
    /// Least distance (m) between the wheel and an obstacle, negative where they overlap; none
    /// without obstacles. What the robot stands or lands on does not count, unless the wheel
    /// touches it before it lands there.
    pub clearance: Option<f64>,
    /// How it fares with each demand that applies to it.
    pub judgements: Vec<Judgement>,
}

impl Route {
    /// The plan `plan` for `crossing`, flown by a robot whose wheel has this `radius` (m), with
    /// landings within `tolerance` (m) of the plan, the last one of the target where the course demands it.
    ///
    /// A goal without width is a place: how near the landing has to be says the tolerance.
    pub fn of(crossing: &Crossing, plan: &CrossingPlan, radius: f64, tolerance: f64) -> Route {
        let stage = |planned: &PlannedJump| Stage {
            launch: planned.jump.launch,
            foot: planned.foot,
            landing_height: radius + planned.landing[1] - planned.foot[1],
            surface: Some(planned.landing[1]),
            apex: planned.foot[1] + planned.jump.apex().unwrap_or(f64::NAN),
            landing: planned.landing[0],
            wanted: planned.landing[0],
        };
        let course = &crossing.course;
        let obstacles = course
            .obstacles
            .iter()
            .map(|o| [o.span().low, o.span().high, o.height]);
        let goal = open(course.goal).filter(|goal| goal.width() > 0.0);
        let demands = Demands {
            obstacles: obstacles.collect(),
            clearance: crossing.clearance,
            leg_out: crossing.leg_out,
            edge_margin: crossing.edge_margin,
            avoid: course.no_landing.clone(),
            zones: crossing.zones.clone(),
            goal,
            roll: crossing.roll,
            friction: crossing.friction,
            ..Demands::within(tolerance)
        };
        let mut stages: Vec<Stage> = plan.jumps.iter().map(stage).collect();
        if let (Some(last), Some(target)) = (stages.last_mut(), demanded_target(crossing)) {
            last.wanted = target;
        }
        Route { stages, demands }
    }

    /// All judgements of a jump from `foot`, and its clearance (m).
    fn judge(&self, jump: usize, foot: [f64; 2], flown: &Flown) -> (Vec<Judgement>, Option<f64>) {
        let stage = &self.stages[jump];
        let place = flown.landing.map(|distance| foot[0] + distance);
        let mut judgements = vec![touchdown(place.is_some())];
        if let Some(place) = place {
            let is_last = jump + 1 == self.stages.len();
            let landing = Landing {
                jump,
                is_last,
                place,
                wanted: stage.wanted,
                surface: stage.surface,
            };
            judgements.extend(self.demands.of_landing(&landing));
        }
        let landing = place.zip(stage.surface);
        judgements.extend(self.demands.of_way(flown, foot, landing));
        (judgements, self.demands.clearance(flown, foot, landing))
    }
}

/// A span without the limits that are none; none if both are.
fn open(span: Span) -> Option<Span> {
    let low = if span.low <= -OPEN {
        f64::NEG_INFINITY
    } else {
        span.low
    };
    let high = if span.high >= OPEN {
        f64::INFINITY
    } else {
        span.high
    };
    (low.is_finite() || high.is_finite()).then_some(Span::new(low, high))
}

fn touchdown(lands: bool) -> Judgement {
    let margin = if lands {
        f64::INFINITY
    } else {
        f64::NEG_INFINITY
    };
    Judgement::new(Demand::Touchdown, margin, margin, None)
}

impl Plant {
    /// Flies the jumps of `route`, jump number i with `errors[i]`, or without errors where there is
    /// none.
    ///
    /// The run ends where there is nothing to stand on: at a jump that does not land, that lands
    /// off its surface or in an area to be avoided. The jumps after it are not started. With
    /// [`Starts::Planned`] every jump is made.
    pub fn run(&self, route: &Route, errors: &[Disturbance], starts: Starts) -> Vec<Attempt> {
        let mut attempts: Vec<Attempt> = Vec::with_capacity(route.stages.len());
        for (jump, stage) in route.stages.iter().enumerate() {
            let foot = match (starts, attempts.last()) {
                (Starts::Chained, Some(before)) => before
                    .landing()
                    .filter(|_| before.leaves_a_foothold())
                    .map(|x| x + route.demands.roll),
                _ => Some(stage.foot[0]),
            };
            let errors = errors.get(jump).copied().unwrap_or_default();
            attempts.push(match foot {
                Some(x) => self.attempt(route, jump, [x, stage.foot[1]], &errors),
                None => Attempt::not_started(stage),
            });
        }
        attempts
    }

    fn attempt(&self, route: &Route, jump: usize, foot: [f64; 2], errors: &Disturbance) -> Attempt {
        let stage = &route.stages[jump];
        let from_foot =
            |[front, back, top]: &[f64; 3]| [front - foot[0], back - foot[0], top - foot[1]];
        let task = Task {
            launch: stage.launch,
            landing_height: stage.landing_height,
            obstacles: route.demands.obstacles.iter().map(from_foot).collect(),
            leg_out: route.demands.leg_out,
        };
        let (plant, task) = self.disturbed(&task, errors);
        let (flight, (judgements, clearance)) = match plant.fly(&task) {
            Ok(flown) => {
                let judged = route.judge(jump, foot, &flown);
                (Flight::Flown(Box::new(flown)), judged)
            }
            Err(error) => (Flight::Failed(error), (vec![touchdown(false)], None)),
        };
        Attempt {
            foot,
            launch: task.launch,
            flight,
            clearance,
            judgements,
        }
    }
}

impl Attempt {
    fn not_started(stage: &Stage) -> Attempt {
        Attempt {
            foot: stage.foot,
            launch: stage.launch,
            flight: Flight::NotStarted,
            clearance: None,
            judgements: vec![touchdown(false)],
        }
    }

    /// The jump, if it was simulated.
    pub fn flown(&self) -> Option<&Flown> {
        match &self.flight {
            Flight::Flown(flown) => Some(flown),
            _ => None,
        }
    }

    /// Where it landed (m along the course), if it did.
    pub fn landing(&self) -> Option<f64> {
        Some(self.foot[0] + self.flown()?.landing?)
    }

    /// Greatest height of the axle above the course's ground (m), if it took off.
    pub fn apex(&self) -> Option<f64> {
        Some(self.foot[1] + self.flown()?.apex?)
    }

    /// Whether the run came to it.
    pub fn was_started(&self) -> bool {
        !matches!(self.flight, Flight::NotStarted)
    }

    /// How it ended, in a word.
    pub fn outcome(&self) -> &'static str {
        match &self.flight {
            Flight::Flown(flown) => flown.outcome(),
            Flight::Failed(_) => "simulation-failed",
            Flight::NotStarted => "not-started",
        }
    }

    /// Whether every demand is met.
    pub fn passes(&self) -> bool {
        self.judgements.iter().all(Judgement::holds)
    }

    /// How it fares with `demand`; none where that does not apply.
    pub fn judgement(&self, demand: Demand) -> Option<&Judgement> {
        self.judgements
            .iter()
            .find(|judgement| judgement.demand == demand)
    }

    /// The demands that are missed.
    pub fn misses(&self) -> impl Iterator<Item = &Judgement> {
        self.judgements
            .iter()
            .filter(|judgement| !judgement.holds())
    }

    /// Why it fails, in words: a reason for each demand that is missed; of one that holds none.
    pub fn reasons(&self) -> Vec<String> {
        self.misses().map(|miss| self.reason(miss)).collect()
    }

    /// One of its misses, in words.
    pub fn reason(&self, miss: &Judgement) -> String {
        match (miss.demand, &self.flight) {
            (Demand::Touchdown, Flight::Failed(error)) => format!("the simulation stops: {error}"),
            (Demand::Touchdown, Flight::NotStarted) => {
                "is not started: the jump before leaves no foothold".into()
            }
            (Demand::Touchdown, Flight::Flown(flown)) => match (flown.outcome(), flown.apex) {
                ("landed", Some(apex)) => {
                    format!("rises to {}, below its landing height", length(apex))
                }
                (outcome, _) => format!("does not land: {}", outcome.replace('-', " ")),
            },
            _ => miss.miss(),
        }
    }

    /// Whether a jump can start where this one landed.
    fn leaves_a_foothold(&self) -> bool {
        let stands = |demand| self.judgement(demand).is_none_or(Judgement::holds);
        [Demand::Touchdown, Demand::Ground, Demand::Avoid]
            .into_iter()
            .all(stands)
    }
}
