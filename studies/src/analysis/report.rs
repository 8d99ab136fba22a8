//! All that the analysis tells of a run, in one.

use saltus_gait::{Draw, GaitError, Program, Setup, Summary, run};

use super::basin::{Basin, Starts, refined};
use super::energy::Energy;
use super::frontier::{Choice, Choices, choices, frontier};
use super::periodic::{Periodic, settled};
use super::stride::{Firing, Strides};

/// How much is tried for a report.
#[derive(Clone, Debug)]
pub struct Effort {
    /// Threads, which change nothing but the time that it takes.
    pub threads: usize,
    /// Firing angle α_f (rad) of the periodic gait and of the starts, where the program of the run is
    /// not one of a fixed angle.
    pub angle: f64,
    /// Rates (rad/s) of the upright starts from which periodic gaits are looked for.
    pub rates: Vec<f64>,
    /// Legs that run before a periodic gait is looked for, and after how many it may repeat.
    pub settling: [usize; 2],
    /// Starts that lead to running or a stall.
    pub starts: Starts,
    /// Cells along either side of the grids of starts: one grid each.
    pub sizes: Vec<usize>,
    /// What the frontier is made of.
    pub choices: Choices,
    /// Share of the robots that must run in a choice on the frontier.
    pub share: f64,
}

impl Default for Effort {
    fn default() -> Effort {
        Effort {
            threads: 1,
            angle: 0.1,
            rates: vec![4.0, 12.0],
            settling: [60, 8],
            starts: Starts::default(),
            sizes: vec![6, 12, 24],
            choices: Choices {
                angles: vec![0.0, 0.1, 0.2, 0.3],
                openings: vec![0.015, 0.02, 0.025, 0.03, 0.04, 0.05],
                drawn: None,
                rate: 12.0,
                legs: [40, 60],
            },
            share: 0.5,
        }
    }
}

impl Effort {
    /// The same with a frontier over so many drawn `robots`.
    pub fn with_robots(mut self, draw: Draw, robots: usize, seed: u64) -> Effort {
        self.choices.drawn = Some((draw, robots, seed));
        self
    }
}

/// What the analysis tells.
#[derive(Clone, Debug)]
pub struct Report {
    /// How the run went.
    pub summary: Summary,
    /// Where its energy went (J).
    pub energy: Energy,
    /// How the ideal controller fires in what follows.
    pub firing: Firing,
    /// The periodic gaits to which it comes from upright starts.
    pub gaits: Vec<Periodic>,
    /// Which starts run: a grid for each of [`Effort::sizes`].
    pub basins: Vec<Basin>,
    /// Speed and gas of every choice in which a robot runs.
    pub choices: Vec<Choice>,
    /// Those of them that none is better than.
    pub frontier: Vec<Choice>,
}

/// Runs `setup` and analyses it with so much `effort`: periodic gaits by events, starts and choices
/// in the steps of `setup`.
///
/// # Errors
/// [`GaitError`] for a run that cannot be, a motion that cannot go on, or a boom on a slope.
pub fn report(setup: &Setup, effort: &Effort) -> Result<Report, GaitError> {
    let summary = run(setup, &mut ())?;
    let robot = &setup.robot;
    let angle = match setup.program {
        Program::Fixed { firing_angle } => firing_angle,
        _ => effort.angle,
    };
    let firing = Firing::new(angle, setup.valve_open);
    let strides = Strides::new(robot, firing)?.on(effort.threads);
    let gaits = settled(&strides, &effort.rates, effort.settling)?;
    let stepped = |strides: Strides| strides.by(setup.stepping);
    let threads = effort.threads;
    let basins = refined(&stepped(strides), &effort.starts, &effort.sizes, threads)?;
    let choices = choices(robot, &effort.choices, stepped, threads)?;
    Ok(Report {
        energy: Energy::of(robot, &summary),
        summary,
        firing,
        gaits,
        basins,
        frontier: frontier(&choices, effort.share),
        choices,
    })
}
