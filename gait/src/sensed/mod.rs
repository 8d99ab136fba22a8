//! A box ahead that a range sensor sees while the robot runs: a table of what each leg does, made by
//! dynamic programming over strides that were simulated before.

mod faced;
mod profile;
mod solve;
mod strides;

use std::f64::consts::TAU;

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_controller::run::Stall;
use saltus_robot::Robot;

use crate::box_table::{BoxTable, ZONE, counted};
use crate::drawn::Draw;
use crate::error::ensure;
use crate::run::{Obstacle, Setup};
use crate::{GaitError, Smooth};

pub use faced::Faced;
use strides::Stride;

/// Boxes at any distance, for one robot and those drawn around it.
#[derive(Clone, Debug)]
pub struct Sensed {
    /// The robot.
    pub robot: Robot,
    /// How others are drawn.
    pub draw: Draw,
    /// Heights of boxes (m), each of which gets a table of its own.
    pub heights: Vec<f64>,
    /// Their length (m).
    pub length: f64,
    /// Least and greatest distance (m) of a box's front from the axle at rest.
    pub fronts: [f64; 2],
    /// Least distance (m) to run up: nearer than this, a robot first backs off. With 0 it never does.
    pub room: f64,
    /// The law that runs before the box is near and after it is behind.
    pub law: Smooth,
    /// Runs from which strides are learned, for each round.
    pub runs: usize,
    /// Rounds: the first has random firings, the others those of the tables so far, with errors.
    pub rounds: usize,
    /// Seed of the robots, the firings and the boxes of these runs.
    pub seed: u64,
}

impl Sensed {
    /// A table for each height; `told` hears of each round.
    ///
    /// # Errors
    /// [`GaitError`] for boxes or a robot that cannot be.
    pub fn plan(
        &self,
        threads: usize,
        mut told: impl FnMut(usize),
    ) -> Result<Vec<BoxTable>, GaitError> {
        self.check()?;
        let mut strides: Vec<Stride> = Vec::new();
        let mut tables = Vec::new();
        for round in 0..self.rounds {
            strides.extend(self.strides(&tables, round, threads)?);
            tables = self.solve(&strides, threads);
            told(round);
        }
        Ok(tables)
    }

    fn check(&self) -> Result<(), GaitError> {
        let length = self.robot.boom.map_or(0.0, |boom| boom.length);
        let ([from, to], room) = (self.fronts, self.room);
        ensure! {
            "length of the boom (m)", length, length > 0.0
                => "that of a boom, whose turn measures the way";
        }
        for (name, count) in [
            ("heights", self.heights.len()),
            ("runs", self.runs),
            ("rounds", self.rounds),
        ] {
            ensure! { name, count as f64, count >= 1 => "at least 1"; }
        }
        ensure! {
            "room to run up (m)", room, (0.0..=MOST_ROOM).contains(&room)
                => format!("from 0 to {MOST_ROOM} m");
            "farthest front of the obstacle (m)", to, from <= to
                => format!("from {from} m, the nearest front");
        }
        for height in &self.heights {
            self.box_at(*height, from).check(self.robot.body.radius)?;
        }
        self.box_at(self.heights[0], to)
            .check(self.robot.body.radius)
    }

    /// What all runs have in common.
    fn setup(&self, robot: Robot, seed: u64, seconds: f64) -> Setup {
        Setup {
            seed,
            zone: ZONE,
            stall: Stall {
                rate: 0.5,
                time: 0.5,
                restarts: true,
            },
            ..Setup::new(robot, self.law.program(), seconds)
        }
    }

    fn box_at(&self, height: f64, front: f64) -> Obstacle {
        Obstacle {
            front,
            length: self.length,
            height,
        }
    }

    /// A front (m), evenly drawn.
    fn front(&self, random: &mut Pcg64) -> f64 {
        let [from, to] = self.fronts;
        between(random, from, to)
    }

    /// Way and height (m) for a count of the encoders of the boom.
    fn per_count(&self) -> [f64; 2] {
        let length = self.robot.boom.map_or(0.0, |boom| boom.length);
        let sensors = self.robot.sensors.unwrap_or_default();
        [sensors.radius_counts, sensors.pivot_counts].map(|counts| length * TAU / counts.round())
    }
}

/// Most room to run up (m): half way round the boom, less a box.
const MOST_ROOM: f64 = 5.0;

/// A number evenly drawn.
fn between(random: &mut Pcg64, from: f64, to: f64) -> f64 {
    Uniform::new_inclusive(from, to).map_or(from, |uniform| uniform.sample(random))
}

/// A whole number from 0 to below `count`, evenly drawn.
fn below(random: &mut Pcg64, count: usize) -> usize {
    counted((between(random, 0.0, 1.0) * count as f64).floor()).min(count.saturating_sub(1))
}
