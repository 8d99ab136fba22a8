//! A run cut into strides, by its measured columns alone.
//!
//! Leg k leans by the wheel's angle less k − 1 pitches. The height of the axle and that lean say how
//! far a retracted leg is above the ground: a leg has touched down where that is 0.
//!
//! | file | content |
//! | --- | --- |
//! | `track.rs` | firings, and what is measured row by row |
//! | `out.rs`, `legs.rs` | how legs that were fired are believed to move: one, and all of a run |
//! | `cutter.rs` | where a stride begins and ends |
//! | `unfit.rs` | why it cannot be read |
//! | `start.rs` | whether it begins on its foot or in the air, and with what |

use std::collections::BTreeMap;
use std::sync::Arc;

use saltus_robot::Robot;

use super::cutter::Cutter;
use super::track::{MARGIN, firings, valves};
use super::unfit::Unfit;
use crate::experiment::{Experiment, Run};
use crate::fit::Fit;
use crate::rig::Others;
use crate::spec::Problem;

/// Most strides that are fitted: more take longer and hardly tell more.
const MOST: usize = 8;
/// Fewest strides from which a cause can be told from a single odd stride.
const LEAST: usize = 4;

/// What to do where most firings are left out as the robot ran too fast.
const SLOWER: &str = "the robot runs too fast for most firings: log slower running, where each leg is home again before \
                      its next touch-down";

/// The strides of an experiment.
pub(super) struct Cut {
    /// How many firings there are.
    firings: usize,
    /// Those that can be read as jumps.
    strides: Vec<Stride>,
    /// How many cannot, by reason.
    unfit: BTreeMap<Unfit, usize>,
    /// An experiment of kind jump without runs.
    empty: Experiment,
}

/// A stride with its run of kind jump.
#[derive(Clone, Debug)]
pub(super) struct Stride {
    pub(super) run: Run,
    /// Wheel angle less lean (rad).
    pub(super) base: f64,
    /// Where it begins in the air: lean and its rate, pivot (or height) and its rate, rate of the
    /// radius angle (or the travel).
    pub(super) guess: Option<[f64; 5]>,
    /// Its other legs, by what is believed of them.
    pub(super) others: Arc<Others>,
    /// Its unknowns as it is fitted alone.
    pub(super) found: Option<Vec<f64>>,
}

/// The strides of `experiment` with what is believed to be `robot`.
///
/// # Errors
/// [`Problem`] where there are too few, or columns do not go together with the robot.
pub(super) fn cut(experiment: &Experiment, robot: &Robot) -> Result<Cut, Problem> {
    let valves = valves(experiment, robot)?;
    let mut cutter = Cutter::new(experiment, robot)?;
    let mut found: Vec<Stride> = Vec::new();
    let mut unfit: BTreeMap<Unfit, usize> = BTreeMap::new();
    let mut all = 0;
    for run in &experiment.runs {
        let track = cutter.track(run)?;
        let firings = firings(run, &valves)?;
        let mut drift = 0.0;
        for k in 0..firings.len() {
            all += 1;
            match cutter.stride(&track, &firings, k, &mut drift) {
                Ok(window) => found.push(Stride {
                    run: track.run(run, firings[k], &window),
                    base: window.base,
                    guess: cutter.guess(&track, run, &window),
                    others: Arc::new(cutter.others(&track, &firings, k, &window)),
                    found: None,
                }),
                Err(why) => *unfit.entry(why).or_default() += 1,
            }
        }
    }
    let fit = found.len();
    let empty = cutter.experiment(Vec::new());
    let cut = Cut {
        firings: all,
        strides: evenly(found, 2 * MOST),
        unfit,
        empty,
    };
    cut.enough(fit)?;
    Ok(cut)
}

impl Cut {
    /// The strides that are tried: twice as many as are used, at most.
    pub(super) fn strides(&self) -> &[Stride] {
        &self.strides
    }

    /// Each stride starts from where it is fitted alone.
    pub(super) fn start_from(&mut self, alone: &[Option<Fit>]) {
        for (run, (stride, fit)) in self.strides.iter_mut().zip(alone).enumerate() {
            stride.found = fit.as_ref().map(|fit| fit.unknowns[run].clone());
        }
    }

    /// Takes out the rates that the gyro read about each landing (s, from the first row of its
    /// stride). The rate jumps there: a millisecond, by which heights in counts cannot tell when a
    /// foot comes down, makes of its reading an error of many standard deviations.
    pub(super) fn without_impacts(&mut self, landings: &[Option<f64>]) {
        let Some(rate) = self.empty.column("wheel_rate_rad_s") else {
            return;
        };
        for (stride, landing) in self.strides.iter_mut().zip(landings) {
            let Run { time, values, .. } = &mut stride.run;
            let Some((landing, first)) = landing.zip(time.first().copied()) else {
                continue;
            };
            for (time, value) in time.iter().zip(&mut values[rate]) {
                if (time - first - landing).abs() < MARGIN {
                    *value = f64::NAN;
                }
            }
        }
    }

    /// The strides as runs of kind jump.
    pub(super) fn experiment(&self) -> Experiment {
        Experiment {
            runs: self
                .strides
                .iter()
                .map(|stride| stride.run.clone())
                .collect(),
            ..self.empty.clone()
        }
    }

    /// Those of the strides that are fit, evenly spaced where they are more than are used; `why` says
    /// of each why it is not.
    ///
    /// # Errors
    /// [`Problem::FewStrides`]
    pub(super) fn fit(mut self, why: &[Option<Unfit>]) -> Result<Cut, Problem> {
        for why in why.iter().flatten() {
            *self.unfit.entry(*why).or_default() += 1;
        }
        let mut whys = why.iter();
        self.strides
            .retain(|_| whys.next().is_some_and(Option::is_none));
        self.strides = evenly(self.strides, MOST);
        let fit = self.strides.len();
        self.enough(fit)?;
        Ok(self)
    }

    fn enough(&self, fit: usize) -> Result<(), Problem> {
        if fit >= LEAST {
            return Ok(());
        }
        Err(Problem::FewStrides {
            firings: self.firings,
            fit,
            least: LEAST,
            reasons: self.left_out(),
        })
    }

    fn left_out(&self) -> String {
        let reason = |(why, count): (&Unfit, &usize)| format!("{count}: {}", why.reason());
        let mut reasons: Vec<String> = self.unfit.iter().map(reason).collect();
        let of_speed = self.unfit.iter().filter(|(why, _)| why.is_of_speed());
        let too_fast: usize = of_speed.map(|(_, count)| count).sum();
        if 2 * too_fast > self.firings {
            reasons.push(SLOWER.into());
        }
        reasons.join("; ")
    }

    /// How many firings there are, how many are used, and why the others are not.
    pub(super) fn notes(&self) -> Vec<String> {
        let left_out: usize = self.unfit.values().sum();
        let (all, used) = (self.firings, self.strides.len());
        let mut notes = vec![format!(
            "{used} strides of {all} firings are used, evenly chosen of {} that can be read",
            all - left_out
        )];
        if left_out > 0 {
            notes.push(format!("firings left out, {}", self.left_out()));
        }
        notes
    }
}

/// So many of `all` at most, evenly spaced.
fn evenly<T>(all: Vec<T>, most: usize) -> Vec<T> {
    let n = all.len();
    let takes = |i: usize| n <= most || (i + 1) * most / n > i * most / n;
    let numbered = all.into_iter().enumerate();
    numbered
        .filter(|(i, _)| takes(*i))
        .map(|(_, x)| x)
        .collect()
}
