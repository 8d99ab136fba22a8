//! How robots fare before a box.

use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_robot::Robot;

use super::Sensed;
use crate::GaitError;
use crate::box_table::{BEYOND, BoxTable};
use crate::drawn::drawn_robot;
use crate::run::{Footfall, Row, Run, Setup, run};

/// How a robot fared before a sensed box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faced {
    /// Front of its box (m).
    pub front: f64,
    /// Whether it came to the other side without touching the box.
    pub cleared: bool,
    /// Least distance (m) to the box where it is not solid; not a number where the simulation could
    /// not follow the motion.
    pub clearance: f64,
    /// When the box was behind (s).
    pub passed: Option<f64>,
    /// Mean speed (m/s) from 2 to 3 s after that.
    pub speed_after: f64,
}

/// Longest run before a box (s), a run-up included.
const LONGEST: f64 = 20.0;
/// How long (s) a robot is followed beyond its box.
const FOLLOWED: f64 = 3.0;

/// Follows a robot until so long (s) after its box is behind.
struct Beyond {
    behind: f64,
    follow: f64,
    passed: Option<f64>,
    /// Travel (m) a second before the end.
    before: Option<f64>,
    speed: f64,
    done: bool,
}

impl Beyond {
    fn new(behind: f64, follow: f64) -> Beyond {
        Beyond {
            behind,
            follow,
            passed: None,
            before: None,
            speed: 0.0,
            done: false,
        }
    }
}

impl Run for Beyond {
    fn row(&mut self, row: &Row<'_>) {
        let travel = row.axle[0];
        if travel > self.behind {
            self.passed.get_or_insert(row.time);
        }
        let Some(at) = self.passed else { return };
        if row.time >= at + self.follow - 1.0 {
            self.before.get_or_insert(travel);
        }
        if row.time >= at + self.follow {
            self.speed = travel - self.before.unwrap_or(travel);
            self.done = true;
        }
    }

    fn footfall(&mut self, _: &Footfall) {}

    fn goes_on(&mut self) -> bool {
        !self.done
    }
}

impl Sensed {
    /// The run of `robot` before a box whose front is at `front` (m), and which can be gone through.
    pub fn before(&self, table: &BoxTable, robot: Robot, seed: u64, front: f64) -> Setup {
        Setup {
            ahead: Some(table.clone()),
            obstacles: vec![self.box_at(table.height, front)],
            solid: false,
            ..self.setup(robot, seed, LONGEST)
        }
    }

    /// How `robots` robots drawn with `seed` fare, each before a solid box at a distance of its own.
    ///
    /// # Errors
    /// [`GaitError`] for a run that cannot be. A motion that the simulation cannot follow counts as
    /// not cleared.
    pub fn try_on(
        &self,
        table: &BoxTable,
        robots: usize,
        seed: u64,
        threads: usize,
    ) -> Result<Vec<Faced>, GaitError> {
        let one = |k: usize| {
            let robot = drawn_robot(&self.robot, &self.draw, seed, k)?;
            let seed = seed.wrapping_add(k as u64);
            let front = self.front(&mut Pcg64::new(u128::from(seed), 0xf407));
            self.face(table, robot, seed, front)
        };
        parallel::map_on(threads, robots, one).into_iter().collect()
    }

    /// How one robot fares.
    fn face(
        &self,
        table: &BoxTable,
        robot: Robot,
        seed: u64,
        front: f64,
    ) -> Result<Faced, GaitError> {
        let behind = front + self.length + BEYOND;
        let free = self.before(table, robot, seed, front);
        let mut beyond = Beyond::new(behind, FOLLOWED);
        let clearance = match run(&free, &mut beyond) {
            Ok(summary) => summary.clearances[0],
            Err(GaitError::Sim(_)) => f64::NAN,
            Err(error) => return Err(error),
        };
        let mut cleared = beyond.passed.is_some() && clearance > 0.0;
        // Until it would touch the box, the run is the same: only what clears it meets it. It ends
        // there, as on its boom the robot comes round to the box again.
        if cleared {
            let solid = Setup {
                solid: true,
                ..free
            };
            let touched = |summary: crate::Summary| {
                let boxes = |(_, _, surface): &(f64, String, usize)| *surface > 0;
                summary.bumps.iter().any(boxes)
            };
            cleared = run(&solid, &mut Beyond::new(behind, 0.0)).is_ok_and(|s| !touched(s));
        }
        Ok(Faced {
            front,
            cleared,
            clearance,
            passed: beyond.passed,
            speed_after: beyond.speed,
        })
    }
}
