//! Which starts lead to running, and which to a stall.

use saltus_gait::GaitError;
use saltus_numeric::parallel;

use super::stride::Strides;
use crate::require;

/// A plane of starts on the foot of leg 0, retracted and not slipping: its lean and the wheel's rate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Starts {
    /// Lean of leg 0 (rad), from and to.
    pub leans: [f64; 2],
    /// Rate (rad/s), from and to.
    pub rates: [f64; 2],
    /// Legs after which a run that has not stalled counts as running.
    pub legs: usize,
}

impl Default for Starts {
    fn default() -> Starts {
        Starts {
            leans: [-0.5, 0.5],
            rates: [0.0, 20.0],
            legs: 25,
        }
    }
}

/// What a start leads to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// It runs.
    Runs,
    /// It stalls.
    Stalls,
    /// The simulation could not go on.
    Fails,
}

/// A grid of starts, each in the middle of its cell.
#[derive(Clone, Debug, PartialEq)]
pub struct Basin {
    /// Cells along the lean, and along the rate.
    pub size: usize,
    /// What each leads to: those of the first lean first.
    pub fates: Vec<Fate>,
    /// Share of the plane that runs.
    pub share: f64,
    /// Length of the boundary of what runs, with either side of the plane as 1.
    pub boundary: f64,
}

impl Basin {
    /// The fate of the cell `lean`, `rate` (0 to size − 1).
    ///
    /// # Panics
    /// For a cell beyond the grid.
    pub fn fate(&self, lean: usize, rate: usize) -> Fate {
        self.fates[lean * self.size + rate]
    }

    /// Starts from which the simulation could not go on.
    pub fn fails(&self) -> usize {
        self.fates.iter().filter(|f| **f == Fate::Fails).count()
    }
}

/// The grid of `size` × `size` `starts` of a robot, on so many `threads`: the same for any number.
///
/// # Errors
/// [`GaitError::Input`] for a grid without cells.
pub fn basin(
    strides: &Strides,
    starts: &Starts,
    size: usize,
    threads: usize,
) -> Result<Basin, GaitError> {
    let sound = (1..=2000).contains(&size);
    require(
        sound,
        "cells of a grid along a side",
        size as f64,
        "from 1 to 2000",
    )?;
    let middle =
        |[from, to]: [f64; 2], k: usize| from + (to - from) * (k as f64 + 0.5) / size as f64;
    let fate = |cell: usize| {
        let lean = middle(starts.leans, cell / size);
        let rate = middle(starts.rates, cell % size);
        let runs = strides
            .standing(lean, rate)
            .and_then(|start| strides.strides(&start, starts.legs))
            .map(|done| done.len() == starts.legs);
        match runs {
            Ok(true) => Fate::Runs,
            Ok(false) => Fate::Stalls,
            Err(_) => Fate::Fails,
        }
    };
    let fates = parallel::map_on(threads, size * size, fate);
    let runs = |lean: usize, rate: usize| fates[lean * size + rate] == Fate::Runs;
    let (mut inside, mut edges) = (0, 0);
    for lean in 0..size {
        for rate in 0..size {
            let here = runs(lean, rate);
            inside += usize::from(here);
            edges += usize::from(lean + 1 < size && here != runs(lean + 1, rate));
            edges += usize::from(rate + 1 < size && here != runs(lean, rate + 1));
        }
    }
    Ok(Basin {
        size,
        share: inside as f64 / (size * size) as f64,
        boundary: edges as f64 / size as f64,
        fates,
    })
}

/// The same plane by finer and finer grids of these `sizes`: whether its share settles, and whether
/// its boundary is a line, whose length settles, or goes on growing.
///
/// # Errors
/// As [`basin`].
pub fn refined(
    strides: &Strides,
    starts: &Starts,
    sizes: &[usize],
    threads: usize,
) -> Result<Vec<Basin>, GaitError> {
    let one = |&size: &usize| basin(strides, starts, size, threads);
    sizes.iter().map(one).collect()
}
