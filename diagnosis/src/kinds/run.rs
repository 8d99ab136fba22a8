//! The robot runs: strides of every leg, each read as a jump.
//!
//! A stride begins just after the touch-down of a leg, or in the flight before it, and ends before the
//! next one. Its motion is one of [`super::jump`], of which lean and rate at its start are estimated,
//! and height, climb and speed where it begins in the air. `cut.rs` and the files that it names find
//! these strides in the measured columns and count the others. Each is fitted alone first, from several
//! starts.

mod cut;
mod cutter;
mod legs;
mod out;
mod start;
mod track;
mod unfit;

use std::sync::Arc;

use super::{Firings, unknown};
use crate::experiment::{Experiment, Sort};
use crate::fit::{self, DIFFERENCE, Fit, STEPS};
use crate::kind::{Asked, Data, Kind, Parameter};
use crate::layout::TICK;
use crate::plausible::{ANGLES, Check, LENGTHS, RATES, SUPPLY as SUPPLIED};
use crate::spec::{
    Column, INCLINE, LEAP_ON, LOGGED, OUTPUT, Problem, RATE, Rest, SUPPLY, Source, Spec, Still,
    Synthesis, TILT, TURN_ON, counting, lively, noisy, optional, required, without,
};
use cut::Cut;
use saltus_numeric::statistics::{median, quantile};
use saltus_robot::Robot;
use unfit::Unfit;

/// The kind.
pub(super) const SPEC: Spec = Spec {
    sort: Sort::Run,
    id: "run",
    description: "The robot runs: many strides, every leg",
    robot: Some("rats-run"),
    valve: false,
    rest: [Rest::Keep; 2],
    channels: &[
        output("valve_1"),
        output("valve_2"),
        output("valve_3"),
        output("valve_4"),
        output("valve_5"),
        output("valve_6"),
        output("valve_7"),
        output("valve_8"),
        output("valve_9"),
        output("valve_10"),
        output("valve_11"),
        output("valve_12"),
        lively("wheel_angle_rad", TURN_ON),
        without(lively("pivot_angle_rad", TILT)),
        without(lively("radius_angle_rad", TURN_ON)),
        without(lively("wheel_rate_rad_s", RATE)),
        without(lively("x_m", LEAP_ON)),
        without(lively("y_m", LEAP_ON)),
    ],
    settings: &[
        required("supply_pressure_gauge_pa", SUPPLY),
        optional("slope_rad", INCLINE),
    ],
    least: 100,
    longest: 1000.0,
    // The ticks of the valves are read off the rows.
    most_rows: 200_000,
    in_full: true,
    checks: &[
        SUPPLIED,
        Check {
            name: "wheel_rate_rad_s",
            sizes: |view| view.mean_rates(),
            what: "the slope of wheel_angle_rad",
            allowed: (0.5, 2.0),
            strict: false,
            units: RATES,
        },
        Check {
            name: "pivot_angle_rad",
            sizes: |view| view.highest_pivot(),
            what: "the pivot angle at which the robot hops as high as a leg is long",
            allowed: (-1.0, 4.0),
            strict: false,
            units: ANGLES,
        },
        Check {
            name: "y_m",
            sizes: |view| {
                let highest = quantile(view.column("y_m")?, 0.95)?;
                Some((highest, 2.0 * view.robot?.body.radius))
            },
            what: "the height of a hop as high as a leg is long",
            allowed: (-1.0, 4.0),
            strict: false,
            units: LENGTHS,
        },
        Check {
            name: "x_m",
            sizes: |view| {
                let rolled = view.span("wheel_angle_rad")? * view.robot?.body.radius;
                Some((view.span("x_m")?, rolled))
            },
            what: "the way that the wheel rolls",
            allowed: (0.0, 5.0),
            strict: false,
            units: LENGTHS,
        },
    ],
    model: |data, robot| {
        Ok(Box::new(Strides::new(
            data,
            robot.ok_or(Problem::NoRobot)?,
        )?))
    },
    synthesis: Synthesis {
        instruments: &[
            counting("wheel_angle_rad", std::f64::consts::TAU / 800.0),
            counting("pivot_angle_rad", std::f64::consts::TAU / 1600.0),
            counting("radius_angle_rad", std::f64::consts::TAU / 1600.0),
            noisy("wheel_rate_rad_s", 0.1),
        ],
        without_boom: None,
        runs: 1,
        // The simulation says how long they are.
        lay_out: |layout, runs, _| {
            (0..runs).for_each(|_| layout.add(&[], 3, TICK, Vec::new()));
        },
        source: Source::Robot,
    },
    ..LOGGED
};

/// The output of a valve.
const fn output(name: &'static str) -> Column {
    Column {
        still: Still::Usual,
        ..without(lively(name, OUTPUT))
    }
}

/// Logarithm of the rms of a stride's residuals, in terms of the median stride's, from which on it is
/// unlike the others; and the same in terms of the median of such differences.
const UNLIKE: f64 = 0.25;
const SPREADS: f64 = 6.0;

/// Indices of height and climb among the unknowns of a stride that begins in the air.
const ABOVE: usize = 2;
const CLIMB: usize = 3;
/// By how much other starts of its fit differ: of a height or lean (rad), and of a climb (rad/s).
const SHIFTS: [f64; 2] = [4e-3, 0.15];

/// Strides of a running robot.
#[derive(Clone, Debug)]
pub struct Strides {
    /// Each as a jump.
    firings: Firings,
    /// What was added to the lean of each to give the wheel's angle (rad).
    bases: Vec<f64>,
    /// What each that begins in the air is guessed to begin with.
    guesses: Vec<Option<[f64; 5]>>,
    /// The unknowns of each as it is fitted alone, once it is.
    found: Vec<Option<Vec<f64>>>,
    /// Channel of the wheel's angle, and of the radius angle or the travel.
    wheel: Option<usize>,
    place: Option<usize>,
}

impl Strides {
    /// The strides of an experiment with what the operator believes is `robot`.
    ///
    /// # Errors
    /// [`Problem`] where data and robot do not go together, or there are too few strides.
    pub fn new(experiment: &Experiment, robot: &Robot) -> Result<Strides, Problem> {
        if robot.tank.is_some_and(|tank| tank.volume.is_finite()) {
            return Err(Problem::Tank {
                robot: robot.name.clone(),
            });
        }
        let mut cut = cut::cut(experiment, robot)?;
        let first = Strides::of(&cut, robot)?;
        let alone = first.each_alone();
        cut.without_impacts(&first.landings(&alone));
        cut.start_from(&alone);
        let tried = Strides::of(&cut, robot)?;
        let alone = tried.each_alone();
        cut.start_from(&alone);
        Strides::of(&cut.fit(&tried.unfit(&alone))?, robot)
    }

    /// Each stride fitted alone and without a cause; none where the model has no such motion.
    fn each_alone(&self) -> Vec<Option<Fit>> {
        (0..self.logs().len()).map(|run| self.alone(run)).collect()
    }

    /// A stride fitted alone, from several starts: heights in counts hardly tell when its foot comes
    /// down, and a fit stays on the side of that on which it began.
    fn alone(&self, run: usize) -> Option<Fit> {
        let first = fit::fit_none(self, &[run]);
        let shifts: &[(usize, f64)] = match self.guesses[run] {
            Some(_) => &[(ABOVE, -1.0), (ABOVE, 1.0), (CLIMB, -1.0), (CLIMB, 1.0)],
            None => &[(0, -1.0), (0, 1.0)],
        };
        let from = |(k, way): &(usize, f64)| {
            let mut from = Fit::first(self);
            from.unknowns[run][*k] += way * SHIFTS[usize::from(*k == CLIMB)];
            fit::refit(self, from, &[run], &None, STEPS)
        };
        let others = shifts.iter().filter_map(from);
        first
            .into_iter()
            .chain(others)
            .min_by(|a, b| a.loss.total_cmp(&b.loss))
    }

    /// When (s, from its first row) the foot of each stride comes down.
    fn landings(&self, alone: &[Option<Fit>]) -> Vec<Option<f64>> {
        let of = |(run, fit): (usize, &Option<Fit>)| {
            let fit = fit.as_ref()?;
            self.firings.lands(run, &fit.terms, &fit.unknowns[run])
        };
        alone.iter().enumerate().map(of).collect()
    }

    fn of(cut: &Cut, robot: &Robot) -> Result<Strides, Problem> {
        let strides = cut.strides();
        let guesses: Vec<Option<[f64; 5]>> = strides.iter().map(|stride| stride.guess).collect();
        let others = strides.iter().map(|stride| Arc::clone(&stride.others));
        let aloft = guesses.iter().map(Option::is_some).zip(others).collect();
        let mut firings = Firings::of_strides(&cut.experiment(), aloft, robot)?;
        firings.data.notes = cut.notes();
        let channel = |names: &[&str]| {
            firings
                .channels()
                .iter()
                .position(|own| names.contains(&own.name.as_str()))
        };
        Ok(Strides {
            wheel: channel(&["wheel_angle_rad"]),
            place: channel(&["radius_angle_rad", "x_m"]),
            firings,
            bases: strides.iter().map(|stride| stride.base).collect(),
            guesses,
            found: strides.iter().map(|stride| stride.found.clone()).collect(),
        })
    }

    /// Why a stride is not fitted, if it is not: the model has no such motion, or leaves far more of
    /// it than of the others, as of one in which somebody pushed. Where more than a third of the strides
    /// are unlike the others, they are what is to be explained.
    fn unfit(&self, alone: &[Option<Fit>]) -> Vec<Option<Unfit>> {
        let left = |(run, fit): (usize, &Option<Fit>)| self.left(run, fit.as_ref()?);
        let left: Vec<Option<f64>> = alone.iter().enumerate().map(left).collect();
        let mut known: Vec<f64> = left.iter().flatten().map(|x| x.ln()).collect();
        if known.is_empty() {
            return vec![Some(Unfit::NoMotion); left.len()];
        }
        let middle = median(&mut known);
        let mut apart: Vec<f64> = known.iter().map(|x| (x - middle).abs()).collect();
        let most = middle + UNLIKE.max(SPREADS * median(&mut apart));
        let odd = known.iter().filter(|x| **x > most).count();
        let are_odd = 3 * odd <= known.len();
        let of = |left: Option<f64>| match left {
            None => Some(Unfit::NoMotion),
            Some(left) if are_odd && left.ln() > most => Some(Unfit::Unlike),
            Some(_) => None,
        };
        left.into_iter().map(of).collect()
    }

    /// The greatest rms of the residuals (σ) of a channel of a stride that is fitted alone; none
    /// where there is no motion beside that.
    fn left(&self, run: usize, fit: &Fit) -> Option<f64> {
        let own = &fit.unknowns[run];
        // Around it there is a motion, too.
        for (k, unknown) in self.unknowns(run).iter().enumerate() {
            for step in [-1.0, -DIFFERENCE, DIFFERENCE, 1.0] {
                let mut moved = own.clone();
                moved[k] += step * unknown.scale;
                self.predict(run, &fit.terms, &moved)?;
            }
        }
        let said = self.predict(run, &fit.terms, own)?;
        let mut sums = vec![(0.0, 0.0); self.channels().len()];
        for (reading, said) in self.logs()[run].readings.iter().zip(said) {
            let sum: &mut (f64, f64) = &mut sums[reading.channel];
            let left = (reading.value - said) / self.channels()[reading.channel].noise;
            sum.0 += reading.weight * left * left;
            sum.1 += reading.weight;
        }
        let rms = sums
            .iter()
            .filter(|sum| sum.1 > 0.0)
            .map(|sum| (sum.0 / sum.1).sqrt());
        Some(rms.fold(1e-3, f64::max))
    }

    /// The unknowns of a stride at what its columns tell of them.
    fn guessed(&self, run: usize) -> Vec<Parameter> {
        let Some([lean, rate, above, climb, turn_rate]) = self.guesses[run] else {
            let mut all = self.firings.unknowns(run);
            all.truncate(2);
            if self.place.is_some() {
                let foot = -self.firings.start_turn(all[0].neutral);
                all.push(unknown("start_place", foot, (foot - 3.0, foot + 3.0), 1e-3));
            }
            return all;
        };
        let free = |name: &str, x: f64, most: f64, scale: f64| {
            unknown(name, x, (x - most, x + most), scale)
        };
        let mut all = vec![
            free("start_lean_rad", lean, 1.0, 1e-3),
            free("start_rate_rad_s", rate, 20.0, 0.02),
            free("start_above", above, 0.3, 1e-3),
            free("start_climb", climb, 3.0, 1e-2),
            free("start_turn_rate", turn_rate, 10.0, 1e-2),
        ];
        if self.place.is_some() {
            all.push(free("start_place", 0.0, 3.0, 1e-3));
        }
        all
    }

    /// Index of the foot's place among the unknowns of a stride: the last one.
    fn foot(&self, unknowns: &[f64]) -> f64 {
        let last = unknowns.last().filter(|_| self.place.is_some());
        last.copied().unwrap_or(0.0)
    }
}

impl Kind for Strides {
    fn data(&self) -> &Data {
        self.firings.data()
    }

    fn inner(&self) -> Option<&dyn Kind> {
        Some(&self.firings)
    }

    /// Lean and rate of a stride that begins on its foot, and where that stands; of one that begins in
    /// the air lean, pivot and place with their rates.
    fn unknowns(&self, run: usize) -> Vec<Parameter> {
        let mut all = self.guessed(run);
        for (unknown, found) in all.iter_mut().zip(self.found[run].iter().flatten()) {
            unknown.neutral = *found;
        }
        all
    }

    fn truths(&self, asked: &Asked<'_>) -> Option<Vec<f64>> {
        let Asked { run, unknowns, .. } = *asked;
        let mut all = self.firings.truths(asked)?;
        // What the encoder's scale makes of the turns before this stride.
        let turned = self.wheel.map_or(0.0, |k| {
            let sensor = &asked.sensors[k];
            self.bases[run] * (1.0 - 1.0 / sensor.gain)
        });
        let foot = self.foot(unknowns);
        for (value, reading) in all.iter_mut().zip(&self.logs()[run].readings) {
            if Some(reading.channel) == self.wheel {
                *value += turned;
            } else if Some(reading.channel) == self.place {
                *value += foot;
            }
        }
        Some(all)
    }

    fn stronger(&self) -> String {
        "runs at several speeds, valve opening times and supply pressures".into()
    }
}
