//! Answers that hold on another robot than the planar one: on its boom, with the masses of its
//! legs, on its ground.
//!
//! The planar model answers, the multi-body simulation of the *plant* flies a few of the answers,
//! and the difference corrects the planar model, until the answers hold
//! ([`planner::Corrected`](crate::planner::Corrected)). Without a plant, or with one that is the
//! planar robot, the answers are the planar model's, bit for bit.
//!
//! ```
//! use saltus::on_plant::{OnPlant, for_table};
//! use saltus::planner::TableRequest;
//! use saltus::{Robot, resolve};
//!
//! let robot = Robot::rats_planar();
//! let plant = OnPlant::new(&robot, &resolve("rats-boom", &[])?)?;
//! let request = TableRequest::distance(0.9).rates([4.0, 4.5, 5.0]);
//! let (planner, correction) = for_table(robot, Some(&plant), &request)?;
//! let mut table = planner.table(&request)?;
//! let confirmed = plant.confirm(&request, &mut table.cells);
//! // The planar model alone lands 5 cm short.
//! assert!(confirmed.jumps == 3 && confirmed.miss < 3e-4);
//! assert!(correction.expect("a plant").jumps <= 20);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::cell::RefCell;

use saltus_lagrangian::{Launch, StanceError};
use saltus_numeric::{parallel::in_chunks, plain};
use saltus_planner::course::{Span, Watch};
use saltus_planner::{
    Cell, Corrected, Correction, Crossing, CrossingAnswer, CrossingError, CrossingPlan, Effort,
    Entry, Jump, JumpModel, LaunchRange, Law, LawPoint, Measure, Nearest, Planar, PlannedJump,
    Planner, TableError, TableRequest,
};
use saltus_robot::Robot;
use saltus_sim_check::SimError;

use crate::simulated::Simulated;

/// Error (m) that the flights of a table may have before its cells are flown. Bounds are on new
/// launches as far as can be from those that were learnt from; between them it is less.
pub const TABLE_BOUND: f64 = 3e-4;

/// The same of a plan.
pub const PLAN_BOUND: f64 = 1e-6;

/// By how much (m) an entry of a table may miss on the plant.
pub const CONFIRMED: f64 = 1e-3;

/// How hard to look for a table.
const TABLE_EFFORT: Effort = Effort {
    bound: TABLE_BOUND,
    round: 10,
    jumps: 100,
    every: false,
};

/// Rounds of the simulation for a plan.
const PLAN_ROUNDS: usize = 12;

/// Cells that are flown together.
const TOGETHER: usize = 4;

/// A robot on which answers have to hold, as the multi-body simulation has it.
#[derive(Clone, Debug)]
pub struct OnPlant {
    simulated: Simulated,
}

/// A jump of a plant.
pub type PlantJump = Jump;

/// A plant that answers for this robot cannot hold on.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PlantError {
    /// A course, and a landing, are laid out for one wheel.
    #[error(
        "body.wheel_radius_m = {}: must be that of robot {robot}, {}: footholds and landing heights \
         count from it",
        plain(*plant),
        plain(*planned)
    )]
    Radius {
        /// Of the plant (m).
        plant: f64,
        /// Of the robot that is planned for (m).
        planned: f64,
        /// Its name.
        robot: String,
    },
    /// Valve opening times mean nothing to a leg without a valve.
    #[error("leg.kind: must have a valve as robot {robot} has, or neither may have one")]
    Valve {
        /// Name of the robot that is planned for.
        robot: String,
    },
    /// No bodies.
    #[error(transparent)]
    Simulation(#[from] SimError),
}

impl OnPlant {
    /// Answers for `robot` that hold on `plant`.
    ///
    /// # Errors
    /// [`PlantError`] where the two have not the same wheel, or a valve each, or the plant cannot
    /// be simulated.
    pub fn new(robot: &Robot, plant: &Robot) -> Result<OnPlant, PlantError> {
        let name = || robot.name.clone();
        if plant.body.radius != robot.body.radius {
            return Err(PlantError::Radius {
                plant: plant.body.radius,
                planned: robot.body.radius,
                robot: name(),
            });
        }
        if plant.leg.drive.has_valve() != robot.leg.drive.has_valve() {
            return Err(PlantError::Valve { robot: name() });
        }
        Ok(OnPlant {
            simulated: Simulated::new(plant.clone())?,
        })
    }

    /// The plant.
    pub fn robot(&self) -> &Robot {
        self.simulated.robot()
    }

    /// The plant as a model to plan with.
    pub fn simulated(&self) -> &Simulated {
        &self.simulated
    }

    /// The jumps of the plant at `launches`; none where it does not fly, or cannot be simulated.
    pub fn jumps(&self, request: &TableRequest, launches: &[Launch]) -> Vec<Option<PlantJump>> {
        let simulated = self.simulated.clone().down_to(lowest(request));
        let jump = |launch: &Launch| simulated.jump(launch).ok();
        let jumps = |some: &[Launch]| some.iter().map(jump).collect();
        let parts: Vec<Vec<_>> = in_chunks(launches, TOGETHER, request.threads, jumps);
        parts.into_iter().flatten().collect()
    }

    /// Flies every entry of `cells`: their jumps and values become the plant's. Entries that miss
    /// by more than [`CONFIRMED`] are dropped; the plant's value is the nearest then.
    pub fn confirm(&self, request: &TableRequest, cells: &mut [Cell]) -> Confirmed {
        let entries = cells.iter().flat_map(|cell| &cell.entries);
        let launches: Vec<Launch> = entries.map(|entry| entry.jump.launch).collect();
        let mut jumps = self.jumps(request, &launches).into_iter();
        let mut confirmed = Confirmed::default();
        for cell in cells.iter_mut() {
            let (target, mut nearest) = (cell.target, cell.nearest);
            cell.entries.retain_mut(|entry| {
                let jump = jumps.next().flatten();
                let value = jump
                    .as_ref()
                    .and_then(|j| request.measure.of(self.robot(), j));
                let Some((jump, value)) = jump.zip(value) else {
                    confirmed.dropped += 1;
                    return false;
                };
                let miss = (value - target).abs();
                if miss > CONFIRMED {
                    confirmed.dropped += 1;
                    nearest = Some(Nearest {
                        value,
                        firing_angle: entry.jump.launch.firing_angle,
                    });
                    return false;
                }
                confirmed.jumps += 1;
                confirmed.miss = confirmed.miss.max(miss);
                (entry.jump, entry.value) = (jump, value);
                true
            });
            if cell.entries.is_empty() {
                cell.nearest = nearest;
            }
        }
        self.confirm_nearest(request, cells);
        confirmed
    }

    /// Flies the nearest of each cell without an entry: its value becomes the plant's. Where it does
    /// not land, the nearest is that of the other cells of its rate.
    fn confirm_nearest(&self, request: &TableRequest, cells: &mut [Cell]) {
        let launch = |cell: &Cell| {
            let nearest = cell.nearest.filter(|_| cell.entries.is_empty())?;
            Some(request.launch(cell.rate, nearest.firing_angle))
        };
        let launches: Vec<Launch> = cells.iter().filter_map(launch).collect();
        let mut jumps = self.jumps(request, &launches).into_iter();
        for cell in cells.iter_mut().filter(|cell| launch(cell).is_some()) {
            let jump = jumps.next().flatten();
            let value = jump.and_then(|jump| request.measure.of(self.robot(), &jump));
            cell.nearest = cell
                .nearest
                .zip(value)
                .map(|(nearest, value)| Nearest { value, ..nearest });
        }
        let reached = |cell: &Cell| {
            let entry = cell.entries.first().map(|entry: &Entry| Nearest {
                value: entry.value,
                firing_angle: entry.jump.launch.firing_angle,
            });
            Some((cell.rate, entry.or(cell.nearest)?))
        };
        let reached: Vec<(f64, Nearest)> = cells.iter().filter_map(reached).collect();
        let lost = |cell: &&mut Cell| cell.entries.is_empty() && cell.nearest.is_none();
        for cell in cells.iter_mut().filter(lost) {
            let off = |nearest: &Nearest| (nearest.value - cell.target).abs();
            let there = reached.iter().filter(|(rate, _)| *rate == cell.rate);
            let there = there.map(|(_, nearest)| *nearest);
            cell.nearest = there.min_by(|a, b| off(a).total_cmp(&off(b)));
        }
    }

    /// Flies the angles that a law was fitted to, and those that it fires: their values become the
    /// plant's. Counted are the former.
    pub fn confirm_law(&self, request: &TableRequest, law: &mut Law) -> Confirmed {
        let values = |angle: fn(&LawPoint) -> f64| {
            let launches = law.points.iter().map(|p| request.launch(p.rate, angle(p)));
            let jumps = self.jumps(request, &launches.collect::<Vec<_>>());
            let value = |jump: Option<PlantJump>| request.measure.of(self.robot(), &jump?);
            jumps.into_iter().map(value).collect::<Vec<_>>()
        };
        let (exact, fitted) = (values(|p| p.exact), values(|p| p.fitted));
        let mut confirmed = Confirmed::default();
        for ((point, exact), fitted) in law.points.iter_mut().zip(exact).zip(fitted) {
            point.value = fitted;
            match exact.map(|value| (value - point.target).abs()) {
                Some(miss) if miss <= CONFIRMED => {
                    confirmed.jumps += 1;
                    confirmed.miss = confirmed.miss.max(miss);
                }
                _ => confirmed.dropped += 1,
            }
        }
        confirmed
    }

    /// A planner by the simulation alone, whose flights end at `lowest` (m above the foothold) at
    /// the latest.
    pub fn planner(&self, lowest: f64) -> Planner<Simulated> {
        Planner::by(self.simulated.clone().down_to(lowest.min(0.0)))
    }

    /// A plan for `crossing` as the plant jumps it, with every limit held against that.
    ///
    /// # Errors
    /// [`CrossingError`] where a jump cannot be simulated.
    pub fn flown(
        &self,
        crossing: &Crossing,
        plan: &CrossingPlan,
    ) -> Result<CrossingPlan, CrossingError> {
        let simulated = self
            .simulated
            .clone()
            .down_to(lowest_of(self.robot(), crossing));
        Ok(Planner::by(simulated).flown(crossing, plan)?)
    }
}

/// A planner by the planar model alone.
pub fn planar(robot: Robot) -> Planner<Corrected> {
    let range = LaunchRange {
        rates: Span::NONE,
        firing_angles: Span::NONE,
        valve_open: Span::NONE,
    };
    Planner::by(Corrected::new(Planar::new(robot), range, 0.0))
}

/// A planner whose jumps at `launches`, and between them, are those of the plant down to
/// `landing_height` (m above the foothold); and how it was corrected.
///
/// # Errors
/// As [`JumpModel::jump`].
pub fn for_launches(
    robot: Robot,
    plant: &OnPlant,
    launches: &[Launch],
    landing_height: f64,
) -> Result<(Planner<Corrected>, Correction), StanceError> {
    let hull = |number: fn(&Launch) -> f64| {
        Span::hull_of(&launches.iter().map(number).collect::<Vec<_>>())
    };
    let range = LaunchRange {
        rates: hull(|l| l.rate),
        firing_angles: hull(|l| l.firing_angle),
        valve_open: hull(|l| l.valve_open),
    };
    let lowest = landing_height.min(0.0);
    let mut planner = Planner::by(Corrected::new(Planar::new(robot), range, lowest));
    let truth = plant.simulated.clone().down_to(lowest);
    let correction = planner.correct(&truth, &TABLE_EFFORT, |_| {
        Ok::<_, StanceError>(launches.to_vec())
    })?;
    Ok((planner, correction))
}

/// A planner for `request` (its table, or its laws), and how it was corrected for the plant, if
/// there is one.
///
/// # Errors
/// [`TableError`] for a request outside its domain.
pub fn for_table(
    robot: Robot,
    plant: Option<&OnPlant>,
    request: &TableRequest,
) -> Result<(Planner<Corrected>, Option<Correction>), TableError> {
    let (low, high) = request.firing_angles;
    let range = LaunchRange {
        rates: Span::hull_of(&request.rates),
        firing_angles: Span::new(low, high),
        valve_open: Span::point(request.valve_open),
    };
    let lowest = lowest(request);
    let mut planner = Planner::by(Corrected::new(Planar::new(robot), range, lowest));
    let Some(plant) = plant else {
        return Ok((planner, None));
    };
    let plain = TableRequest {
        sensitivities: false,
        ..request.clone()
    };
    let truth = plant.simulated.clone().down_to(lowest);
    let correction = planner.correct(&truth, &TABLE_EFFORT, |planner| {
        let cells = planner.table(&plain)?.cells;
        let entries = cells.iter().flat_map(|cell| {
            let nearest = cell.nearest.as_ref().map(|n| n.firing_angle);
            let angles = cell.entries.iter().map(|e| e.jump.launch.firing_angle);
            angles
                .chain(nearest)
                .map(|angle| plain.launch(cell.rate, angle))
        });
        Ok::<_, TableError>(entries.collect())
    })?;
    Ok((planner, Some(correction)))
}

/// A planner for `crossing`, what it answers, and how it was corrected for the plant, if there is
/// one; `watch` is told how far each search is.
///
/// # Errors
/// [`CrossingError`] for a value outside its domain.
pub fn for_crossing(
    robot: Robot,
    plant: Option<&OnPlant>,
    crossing: &Crossing,
    watch: &Watch<'_>,
) -> Result<Crossed, CrossingError> {
    let range = LaunchRange {
        rates: Span::hull_of(&crossing.rates),
        firing_angles: crossing.firing_angles,
        valve_open: if robot.leg.drive.has_valve() {
            crossing.valve_open
        } else {
            Span::point(crossing.valve_open.low)
        },
    };
    let lowest = lowest_of(&robot, crossing);
    let mut planner = Planner::by(Corrected::new(Planar::new(robot), range, lowest));
    let Some(plant) = plant else {
        let answer = planner.cross_watched(crossing, watch)?;
        return Ok(Crossed {
            planner,
            answer,
            correction: None,
        });
    };
    let round = crossing.course.jumps;
    let effort = Effort {
        bound: PLAN_BOUND,
        round,
        jumps: PLAN_ROUNDS * round,
        every: true,
    };
    let truth = plant.simulated.clone().down_to(lowest);
    let last = RefCell::new(None);
    let correction = planner.correct(&truth, &effort, |planner| {
        let answer = planner.cross_watched(crossing, watch)?;
        let launches = crossing.launches(&answer);
        last.replace(Some(answer));
        Ok::<_, CrossingError>(launches)
    })?;
    let answer = match last.into_inner() {
        Some(CrossingAnswer::Plan(plan)) => {
            let flown = plant.flown(crossing, &plan)?;
            if correction.miss.is_infinite() {
                flies(plant.robot(), &flown)?;
            }
            CrossingAnswer::Plan(flown)
        }
        Some(answer) => answer,
        None => planner.cross_watched(crossing, watch)?,
    };
    Ok(Crossed {
        planner,
        answer,
        correction: Some(correction),
    })
}

/// # Errors
/// [`CrossingError::NeverFlies`] for a jump without a landing.
fn flies(robot: &Robot, plan: &CrossingPlan) -> Result<(), CrossingError> {
    let lost = |planned: &PlannedJump| !planned.landing[0].is_finite();
    let Some(index) = plan.jumps.iter().position(lost) else {
        return Ok(());
    };
    Err(CrossingError::NeverFlies {
        jump: index + 1,
        robot: robot.name.clone(),
        outcome: plan.jumps[index].jump.stance.outcome,
    })
}

/// What flying the answers of a table came to.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Confirmed {
    /// Entries that hold.
    pub jumps: usize,
    /// By how much (m) they miss, at most.
    pub miss: f64,
    /// Entries that were dropped.
    pub dropped: usize,
}

impl Confirmed {
    /// Of both.
    #[must_use]
    pub fn and(self, other: Confirmed) -> Confirmed {
        Confirmed {
            jumps: self.jumps + other.jumps,
            miss: self.miss.max(other.miss),
            dropped: self.dropped + other.dropped,
        }
    }
}

/// What crossing a course comes to on a plant.
#[derive(Debug)]
pub struct Crossed {
    /// The planner, corrected.
    pub planner: Planner<Corrected>,
    /// Its answer; a plan is as the plant jumps it.
    pub answer: CrossingAnswer,
    /// How it was corrected; none without a plant.
    pub correction: Option<Correction>,
}

/// Where flights of a request end (m above the foothold).
fn lowest(request: &TableRequest) -> f64 {
    match request.measure {
        Measure::Distance { landing_height } => landing_height.min(0.0),
        Measure::Clearance { .. } => 0.0,
    }
}

/// Where flights of a course may end (m above the foothold): on the ground, from its highest top.
fn lowest_of(robot: &Robot, crossing: &Crossing) -> f64 {
    let tops = crossing.course.obstacles.iter().map(|o| o.height);
    let highest = tops.fold(crossing.course.start_height, f64::max);
    (robot.body.radius - highest).min(0.0)
}
