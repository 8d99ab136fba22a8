//! The best policy: the least time from rest to a distance, by dynamic programming over the strides of
//! a robot, as a table of firings.
//!
//! A stride begins where a leg enters the active zone, and the choice there is at which lean that leg
//! fires and for how long. Strides are those of the controller's loop in the simulation, a cycle at a
//! time, without noise. Their states fall in cells; a cell holds the state in full that came into it
//! first. Value iteration on this finite decision process gives the time from each cell.
//!
//! Source: R. Bellman, Dynamic Programming (1957); the state within each cell as in D. Dolgov,
//! S. Thrun, M. Montemerlo and J. Diebel, Path planning for autonomous vehicles in unknown
//! semi-structured environments (2010).

mod graph;
mod table;
mod walker;

use std::f64::consts::TAU;

use saltus_gait::{GaitError, Setup};

use self::graph::Pick;
pub use self::table::Table;
use self::walker::{Choices, Way};
use crate::require;

/// What is sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quest {
    /// To travel from rest (m).
    pub distance: f64,
    /// Levels of refinement, 1 to 4: each halves the cells and the steps of the choices.
    pub levels: usize,
}

impl Default for Quest {
    fn default() -> Quest {
        Quest {
            distance: 1.6,
            levels: 3,
        }
    }
}

/// A level of refinement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// Cells that were reached.
    pub cells: usize,
    /// Choices in each.
    pub choices: usize,
    /// Least time from rest (s); infinite where no choice leads there.
    pub value: f64,
    /// Residual of Bellman's equation (s).
    pub residual: f64,
    /// Sweeps of value iteration.
    pub sweeps: usize,
}

/// Why there is no policy.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum OptimalError {
    /// The quest or the run cannot be.
    #[error(transparent)]
    Gait(#[from] GaitError),
    /// No sequence of firings that was tried goes so far.
    #[error(
        "no firings that were tried reach {distance} m within {within:.3} s: they come to {farthest:.3} m"
    )]
    Unreached {
        /// Distance (m).
        distance: f64,
        /// How far they came (m).
        farthest: f64,
        /// How long they were followed (s).
        within: f64,
    },
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Optimal {
    /// Level by level.
    pub levels: Vec<Level>,
    /// The policy of the last level that leads there.
    pub table: Table,
    /// Least time from rest (s) that it predicts.
    pub time: f64,
    /// The firings of the fastest real run that was met: α_f (rad), t_v (s).
    pub sequence: Vec<[f64; 2]>,
    /// Its time (s).
    pub sequence_time: f64,
}

/// Opening times (s) from and to, and their step at the first level; the step of angles (rad).
const OPENINGS: [f64; 3] = [0.02, 0.07, 0.025];
const ANGLE_STEP: f64 = 0.4;
/// A speed (m/s) that no robot exceeds; then by how much the fastest cell of a level may be exceeded.
const FASTEST: f64 = 8.0;
const AHEAD: f64 = 1.2;
/// Between a table's nodes (rad/s): four times what five taps leave of the gyro's noise.
const SPACING: f64 = 0.2;
/// Size of the cells at the first level.
const COARSEST: f64 = 4.0;
/// Greatest firing angle, as a part of the zone: beyond, a leg pushes for nothing.
const LATEST: f64 = 0.9;
/// Longest time (s) from rest, and for each metre.
const LONGEST: [f64; 2] = [1.0, 1.5];

impl Choices {
    fn at_level(level: i32, zone: f64, pitch: f64) -> Choices {
        let finer = 0.5f64.powi(level);
        let upto = |from: f64, to: f64, step: f64| {
            let mut all = Vec::new();
            while from + step * (all.len() as f64) < to + 1e-9 {
                all.push(from + step * (all.len() as f64));
            }
            all
        };
        let [from, to, step] = OPENINGS;
        Choices {
            angles: upto(zone, zone + LATEST * pitch, ANGLE_STEP * finer),
            openings: upto(from, to, step * finer),
        }
    }

    fn firing(&self, pick: Pick) -> Option<[f64; 2]> {
        pick.map(|[angle, opening]| [self.angles[angle], self.openings[opening]])
    }
}

/// The best policy for `setup`, whose program, disturbances and noise do not count. `told` hears the
/// level and its cells so far. The same on any number of `threads`.
///
/// # Errors
/// [`OptimalError::Unreached`] where no choice leads there; [`OptimalError::Gait`] for a quest that
/// cannot be, and as [`run`](saltus_gait::run).
pub fn optimal(
    setup: &Setup,
    quest: Quest,
    threads: usize,
    mut told: impl FnMut(usize, usize),
) -> Result<Optimal, OptimalError> {
    let Quest { distance, levels } = quest;
    let sound = distance > 0.0 && distance <= 10.0;
    require(sound, "distance (m)", distance, "above 0, at most 10 m")?;
    let allowed = "from 1 to 4";
    require(
        (1..=4).contains(&levels),
        "levels of refinement",
        levels as f64,
        allowed,
    )?;
    let way = Way::quiet(setup, distance)?;
    let pitch = TAU / f64::from(setup.robot.body.legs);
    let [fixed, by_way] = LONGEST;
    let mut limit = fixed + by_way * distance;
    let (mut found, mut fastest) = (Vec::new(), FASTEST);
    let (mut best, mut farthest): (Option<Optimal>, f64) = (None, 0.0);
    for level in 0..levels {
        let finer = i32::try_from(level).unwrap_or(0);
        let choices = Choices::at_level(finer, setup.zone, pitch);
        let size = COARSEST * 0.5f64.powi(finer);
        let mut tell = |cells: usize| told(level, cells);
        let goes_by = graph::Level {
            size,
            choices: &choices,
            limit,
            fastest,
        };
        let mut graph = graph::explore(&way, &goes_by, threads, &mut tell)?;
        let (sweeps, residual) = graph.iterate();
        let value = graph.cells[0].value;
        found.push(Level {
            cells: graph.cells.len(),
            choices: 1 + choices.angles.len() * choices.openings.len(),
            value,
            residual,
            sweeps,
        });
        farthest = farthest.max(graph.farthest);
        fastest = graph.fastest().map_or(fastest, |speed| AHEAD * speed);
        if let Some((time, ..)) = graph.reached {
            limit = limit.min(1.05 * time);
            best = Some(Optimal {
                levels: Vec::new(),
                table: table::of(&graph, &choices, SPACING),
                time: value,
                sequence: graph
                    .sequence()
                    .into_iter()
                    .filter_map(|pick| choices.firing(pick))
                    .collect(),
                sequence_time: time,
            });
        }
    }
    let unreached = OptimalError::Unreached {
        distance,
        farthest,
        within: limit,
    };
    best.map(|best| Optimal {
        levels: found,
        ..best
    })
    .ok_or(unreached)
}

/// Time (s) from rest to `distance` (m) of the robot of `setup`, with the noise of its sensors, if
/// `table` says what fires in place of its program; none where it is not there within the run.
///
/// # Errors
/// As [`run`](saltus_gait::run).
pub fn flown(setup: &Setup, table: &Table, distance: f64) -> Result<Option<f64>, GaitError> {
    let way = Way::noisy(setup, distance)?;
    let mut walker = way.begin()?;
    let (mut entry, mut has_fired) = (walker.action.rate, false);
    while walker.time < setup.seconds {
        if walker.left() <= 0.0 {
            return Ok(Some(walker.time));
        }
        let [angle, opening] = table.at(entry, walker.passed);
        let fires = !has_fired && opening > 0.0 && walker.action.lean >= angle;
        has_fired |= fires;
        if walker.cycle(fires.then_some(opening))? {
            (entry, has_fired) = (walker.action.rate, false);
        }
    }
    Ok(None)
}
