//! A jump over a box from rest: some legs accelerate, the next one jumps.

use saltus_controller::run::Leap;
use saltus_numeric::parallel;
use saltus_robot::Robot;

use crate::cast::{most_counts, whole};
use crate::drawn::{Draw, drawn_robot};
use crate::error::ensure;
use crate::run::{Obstacle, Setup, run};
use crate::search::{Search, search};
use crate::{GaitError, Program};

/// A box to be crossed, from rest on two legs.
///
/// Source: thesis 5.2.3 and figures 5.10, 5.11.
#[derive(Clone, Debug)]
pub struct Crossing {
    /// The robot, around which others are drawn.
    pub robot: Robot,
    /// How they are drawn.
    pub draw: Draw,
    /// The box.
    pub obstacle: Obstacle,
    /// Legs that accelerate before the one that jumps; the thesis has 3.
    pub firings: usize,
    /// Whether the jump's firing angle follows from the rate at touch-down; else it is constant.
    pub by_rate: bool,
    /// Robots on which the plan is sought, generations of the search, and its seed.
    pub sought_on: usize,
    /// Generations of the search.
    pub generations: usize,
    /// Seed of the search and of the robots that it draws.
    pub seed: u64,
}

/// Firings that take a robot over a box.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossingPlan {
    /// Firing angle (rad) and valve opening time (s) of each leg that accelerates.
    pub first: Vec<[f64; 2]>,
    /// The jump.
    pub leap: Leap<f64>,
}

/// How a robot fared.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossed {
    /// Least distance (m) to the box where it is not solid: below 0, it would have touched it.
    pub clearance: f64,
    /// Whether it came to the other side without touching the box.
    pub cleared: bool,
    /// Travel (m) in the end.
    pub travel: f64,
    /// Mean speed (m/s) over the run.
    pub speed: f64,
}

/// Time (s) that a crossing may take, landing included.
const LONGEST: f64 = 2.0;
/// Specific force (m/s²) from which a foot has come down.
const SHOCK: f64 = 150.0;
/// Valve opening time (s) of the jump: past the end of the stroke.
const PAST_THE_STROKE: f64 = 0.1;
/// Clearance (m) beyond which more is worth nothing, and what being clear at all is worth (m).
const ENOUGH: f64 = 0.03;
const CLEAR: f64 = 0.05;

impl Crossing {
    /// Seeks the firings; `told` hears of each generation's score: the mean over the robots of their
    /// clearance (m), cut off at 3 cm, and 5 cm more for each that is clear.
    ///
    /// # Errors
    /// [`GaitError`] for a box or a robot that cannot be.
    pub fn plan(
        &self,
        threads: usize,
        told: impl FnMut(usize, f64),
    ) -> Result<CrossingPlan, GaitError> {
        ensure! {
            "legs that accelerate", self.firings as f64, (1..=6).contains(&self.firings)
                => "from 1 to 6";
            "robots to seek on", self.sought_on as f64, self.sought_on >= 1 => "at least 1";
        }
        let robots: Vec<Robot> = (0..self.sought_on)
            .map(|k| drawn_robot(&self.robot, &self.draw, self.seed, k))
            .collect::<Result<_, _>>()?;
        let slope = if self.by_rate {
            [-0.15, 0.05]
        } else {
            [0.0, 0.0]
        };
        let each = [[-0.1, 0.62], [0.012, 0.07]];
        let bounds: Vec<[f64; 2]> = (0..self.firings)
            .flat_map(|_| each)
            .chain([slope, [-0.2, 1.0]])
            .collect();
        let start = (0..self.firings)
            .flat_map(|_| [0.3, 0.045])
            .chain(if self.by_rate {
                [-0.1, 0.46]
            } else {
                [0.0, 0.1]
            })
            .collect();
        // What cannot be run at all is told before it is sought.
        self.fare(
            &self.read(&bounds_middle(&bounds)),
            robots[0].clone(),
            0,
            false,
        )?;
        let score = |x: &[f64]| {
            let plan = self.read(x);
            let worth = |(k, robot): (usize, &Robot)| {
                let fare = self.fare(
                    &plan,
                    robot.clone(),
                    self.seed.wrapping_add(k as u64),
                    false,
                );
                fare.map_or(-1.0, |fare| self.worth(&fare))
            };
            robots.iter().enumerate().map(worth).sum::<f64>() / robots.len() as f64
        };
        let settings = Search {
            bounds,
            start,
            spread: 0.3,
            candidates: 64,
            best: 10,
            generations: self.generations,
            seed: self.seed,
        };
        let mut told = told;
        let (x, _) = search(&settings, threads, score, |k, best, _| told(k, best));
        Ok(self.read(&x))
    }

    fn worth(&self, fare: &Crossed) -> f64 {
        let beyond = self.obstacle.front + self.obstacle.length + self.robot.body.radius;
        if fare.travel < beyond {
            return -0.3 + 0.1 * (fare.travel - self.obstacle.front).min(0.0);
        }
        let clear = if fare.clearance > 0.0 { CLEAR } else { 0.0 };
        fare.clearance.clamp(-0.25, ENOUGH) + clear
    }

    fn read(&self, x: &[f64]) -> CrossingPlan {
        let first = x[..2 * self.firings]
            .chunks_exact(2)
            .map(|pair| [pair[0], pair[1]]);
        let sensors = self.robot.sensors.unwrap_or_default();
        let counts = most_counts(sensors.converter_bits) / sensors.coarse_accelerometer_range;
        CrossingPlan {
            first: first.collect(),
            leap: Leap {
                after: u32::try_from(self.firings).unwrap_or(u32::MAX),
                slope: x[2 * self.firings],
                level: x[2 * self.firings + 1],
                least: -0.3,
                most: 0.6,
                valve_open: PAST_THE_STROKE,
                shock: whole(SHOCK * counts),
            },
        }
    }

    /// The run of `plan` by `robot`, whose box is solid or not.
    pub fn setup(&self, plan: &CrossingPlan, robot: Robot, seed: u64, solid: bool) -> Setup {
        Setup {
            seed,
            zone: -0.3,
            first: plan.first.clone(),
            leap: Some(plan.leap),
            obstacles: vec![self.obstacle],
            solid,
            ..Setup::new(robot, Program::Fixed { firing_angle: 0.1 }, LONGEST)
        }
    }

    fn fare(
        &self,
        plan: &CrossingPlan,
        robot: Robot,
        seed: u64,
        solid: bool,
    ) -> Result<Crossed, GaitError> {
        let summary = run(&self.setup(plan, robot, seed, solid), &mut ())?;
        let beyond = self.obstacle.front + self.obstacle.length;
        let touched = summary.bumps.iter().any(|(_, _, surface)| *surface > 0);
        Ok(Crossed {
            clearance: summary.clearances[0],
            cleared: summary.travel > beyond && !touched && summary.clearances[0] > 0.0,
            travel: summary.travel,
            speed: summary.mean_speed,
        })
    }

    /// How `robots` robots drawn with `seed` fare against the solid box.
    ///
    /// # Errors
    /// [`GaitError`] for a run that cannot go on.
    pub fn try_on(
        &self,
        plan: &CrossingPlan,
        robots: usize,
        seed: u64,
        threads: usize,
    ) -> Result<Vec<Crossed>, GaitError> {
        let one = |k: usize| {
            let robot = drawn_robot(&self.robot, &self.draw, seed, k)?;
            let seed = seed.wrapping_add(k as u64);
            let free = self.fare(plan, robot.clone(), seed, false)?;
            // Until it would touch the box, the run is the same: only what clears it meets it.
            if free.cleared {
                self.fare(plan, robot, seed, true)
            } else {
                Ok(free)
            }
        };
        parallel::map_on(threads, robots, one).into_iter().collect()
    }
}

fn bounds_middle(bounds: &[[f64; 2]]) -> Vec<f64> {
    bounds
        .iter()
        .map(|[low, high]| 0.5 * (low + high))
        .collect()
}
