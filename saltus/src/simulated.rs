//! The multi-body simulation as a model to plan with: boom, masses of legs and slip included.
//!
//! ```
//! use saltus::planner::TableRequest;
//! use saltus::simulated::Simulated;
//! use saltus::{Planner, resolve};
//!
//! let planner = Planner::by(Simulated::new(resolve("rats-boom", &[])?)?);
//! let table = planner.table(&TableRequest {
//!     sensitivities: false,
//!     firing_angles: (-0.2, 0.2),
//!     ..TableRequest::distance(0.9).rates([5.0])
//! })?;
//! let fired = table.cells[0].entries[0].jump.launch.firing_angle;
//! // The planar model fires at -0.077 rad, and lands 1 cm short on the boom.
//! assert!((fired - -0.070).abs() < 1e-3, "{fired}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use saltus_ballistic::{FlightSample, SampledFlight};
use saltus_lagrangian::{Launch, LiftOff, Outcome, StanceError};
use saltus_numeric::Dual;
use saltus_planner::course::Slope;
use saltus_planner::{Instant, Jump, JumpFlight, JumpModel, Steered, Traced, spare_of, widen};
use saltus_robot::{Drive, Robot};
use saltus_sim_check::{End, Plan, Report, Rig, Sample, Settings, SimError};

/// Error of each step of the simulation.
const TOLERANCE: f64 = 1e-9;

/// What that comes to (m), with the trace of mass that a leg without mass has as a body.
const ACCURACY: f64 = 1e-6;

/// By how much a number is changed for its derivative: rate (rad/s), angles (rad), valve opening
/// time (s). Derivatives are then right to a thousandth or better.
const STEPS: [f64; 4] = [1e-3, 1e-3, 1e-3, 1e-4];

/// The same for the supply pressure, as a share of it.
const SUPPLY_STEP: f64 = 1e-3;

/// Times (s) between samples of a stance: of a path alone, and where the ground's force is looked
/// at.
const SAMPLES: [f64; 2] = [5e-3, 1e-3];

/// The same of a flight, of which cubics between samples are then off by less than a nanometre.
const FLIGHT_SAMPLES: f64 = 2e-2;

/// How far (m) a flight is followed below the lowest landing.
const BELOW: f64 = 0.02;

/// A robot as bodies in space that jump.
#[derive(Clone, Debug)]
pub struct Simulated {
    robot: Robot,
    rig: Rig,
    /// With a little less and a little more supply pressure, and the difference (Pa).
    supplied: Option<([Rig; 2], f64)>,
    lowest: f64,
}

/// What a simulation came to.
struct Run {
    stance: LiftOff,
    /// The way of the wheel's centre until the stance ends.
    way: Option<SampledFlight<f64>>,
    flight: Option<SampledFlight<f64>>,
    friction_needed: f64,
}

impl Simulated {
    /// `robot` as it stands on its ground, with its boom if it has one.
    ///
    /// # Errors
    /// [`SimError`] for a robot whose parts cannot be bodies.
    pub fn new(robot: Robot) -> Result<Simulated, SimError> {
        let with_supply = |by: f64| {
            let mut other = robot.clone();
            if let Drive::Pneumatic(cylinder) = &mut other.leg.drive {
                cylinder.supply.0 += by;
            }
            Rig::new(&other, &[])
        };
        let supplied = match &robot.leg.drive {
            Drive::Pneumatic(cylinder) if cylinder.supply.0 > 0.0 => {
                let step = SUPPLY_STEP * cylinder.supply.0;
                Some(([with_supply(-step)?, with_supply(step)?], 2.0 * step))
            }
            _ => None,
        };
        Ok(Simulated {
            rig: Rig::new(&robot, &[])?,
            supplied,
            robot,
            lowest: 0.0,
        })
    }

    /// Following flights down to where the wheel's centre is at `height` (m above the foothold), or
    /// to 0 where that is lower: for landings below the foothold.
    #[must_use]
    pub fn down_to(self, height: f64) -> Simulated {
        Simulated {
            lowest: height.min(0.0),
            ..self
        }
    }

    /// One jump of `rig`, seen `finely` where its way or the ground's force counts.
    fn run(&self, rig: &Rig, launch: &Launch, finely: bool) -> Result<Run, StanceError> {
        let settings = Settings {
            tolerance: TOLERANCE,
            ..Settings::default()
        };
        let plan = Plan {
            settings,
            landing_height: self.lowest - BELOW,
            sample: SAMPLES[usize::from(finely)],
            flight_sample: Some(FLIGHT_SAMPLES),
            ..Plan::default()
        };
        let report = rig
            .jump(launch, &plan)
            .map_err(|error| StanceError::Simulation {
                reason: error.to_string(),
            })?;
        let stance = lift_off(&report);
        let path = |is_in: &dyn Fn(&Sample) -> bool, start: f64| {
            let sample = |s: &Sample| FlightSample {
                time: s.time - start,
                position: s.axle,
                velocity: s.axle_rates,
            };
            let samples = report.samples.iter().filter(|s| is_in(s));
            SampledFlight::new(samples.map(sample).collect()).ok()
        };
        let flight = || path(&|s| s.time >= stance.time, stance.time);
        Ok(Run {
            way: path(&|s| s.time <= stance.time, 0.0),
            flight: stance.outcome.is_jump().then(flight).flatten(),
            friction_needed: report.friction_needed,
            stance,
        })
    }

    /// A run and, for each direction, two beside it with what lies between them; `supply` is the
    /// direction of the supply pressure.
    fn beside<const N: usize>(
        &self,
        launch: &Launch<Dual<N>>,
        supply: Option<usize>,
        finely: bool,
    ) -> Result<Beside<N>, StanceError> {
        let numbers = [
            launch.rate,
            launch.lean,
            launch.firing_angle,
            launch.valve_open,
        ];
        let here = launch_of(numbers.map(|x| x.value));
        let base = self.run(&self.rig, &here, finely)?;
        let pairs = std::array::from_fn(|k| {
            if supply == Some(k) {
                self.supplied(&here)
            } else {
                self.steered_by(&numbers, k, finely)
            }
        });
        Ok(Beside { base, pairs })
    }

    /// The runs with less and with more supply pressure.
    fn supplied(&self, launch: &Launch) -> Option<Pair> {
        let (rigs, apart) = self.supplied.as_ref()?;
        Some(Pair {
            runs: [0, 1].map(|side| self.run(&rigs[side], launch, false).ok()),
            apart: *apart,
        })
    }

    /// The runs on both sides in direction `k`; none where nothing changes along it.
    fn steered_by<const N: usize>(
        &self,
        numbers: &[Dual<N>; 4],
        k: usize,
        finely: bool,
    ) -> Option<Pair> {
        let steps = numbers.iter().zip(STEPS);
        let shares = steps.map(|(x, step)| x.slope[k].abs() / step);
        let share = shares.fold(0.0, f64::max);
        let run = |h: f64| {
            let launch = launch_of(numbers.map(|x| x.value + h * x.slope[k]));
            // Neither a rate nor a time is below 0.
            let is_legal = launch.rate >= 0.0 && launch.valve_open >= 0.0;
            let run = is_legal.then(|| self.run(&self.rig, &launch, finely).ok());
            run.flatten()
        };
        (share > 0.0).then(|| Pair {
            runs: [run(-1.0 / share), run(1.0 / share)],
            apart: 2.0 / share,
        })
    }
}

/// The runs on both sides, where there are such, and by how much the number differs that was changed
/// for them.
struct Pair {
    runs: [Option<Run>; 2],
    apart: f64,
}

/// A run, and those beside it in each direction that is not constant.
struct Beside<const N: usize> {
    base: Run,
    pairs: [Option<Pair>; N],
}

impl<const N: usize> Beside<N> {
    /// A number of the run with its derivatives, by the chord between the runs beside it; by that
    /// from one of them to the run itself where the other has no such number.
    fn number(&self, of: impl Fn(&Run) -> Option<f64>) -> Option<Dual<N>> {
        let value = of(&self.base)?;
        let slope = |pair: &Option<Pair>| {
            let Some(Pair { runs, apart }) = pair else {
                return Some(0.0);
            };
            match [0, 1].map(|side| runs[side].as_ref().and_then(&of)) {
                [Some(a), Some(b)] => Some((b - a) / apart),
                [Some(a), None] => Some((value - a) / (0.5 * apart)),
                [None, Some(b)] => Some((b - value) / (0.5 * apart)),
                [None, None] => None,
            }
        };
        let mut number = Dual {
            value,
            slope: [0.0; N],
        };
        for (to, pair) in number.slope.iter_mut().zip(&self.pairs) {
            *to = slope(pair)?;
        }
        Some(number)
    }

    fn numbers(&self, of: impl Fn(&Run) -> Option<[f64; 2]>) -> Option<[Dual<N>; 2]> {
        let number = |i: usize| self.number(|run| Some(of(run)?[i]));
        Some([number(0)?, number(1)?])
    }

    fn lift_off(&self) -> Option<LiftOff<Dual<N>>> {
        let flies = |run: &Run| run.stance.outcome.is_jump();
        let alike = |run: &Run| flies(run) == flies(&self.base);
        let number =
            |of: fn(&LiftOff) -> f64| self.number(|run| alike(run).then(|| of(&run.stance)));
        Some(LiftOff {
            outcome: self.base.stance.outcome,
            time_fire: number(|l| l.time_fire)?,
            time: number(|l| l.time)?,
            lean: number(|l| l.lean)?,
            rate: number(|l| l.rate)?,
            extension: number(|l| l.extension)?,
            extension_rate: number(|l| l.extension_rate)?,
            pressure: number(|l| l.pressure)?,
            axle: self.numbers(|run| Some(run.stance.axle))?,
            axle_rates: self.numbers(|run| Some(run.stance.axle_rates))?,
        })
    }

    /// The flight, with derivatives at equal times after the lift-off.
    fn flight(&self) -> Option<SampledFlight<Dual<N>>> {
        let sample = |time: f64| {
            let at = |run: &Run| Some(run.flight.as_ref()?.at(time));
            Some(FlightSample {
                time,
                position: self.numbers(|run| Some(at(run)?.position))?,
                velocity: self.numbers(|run| Some(at(run)?.velocity))?,
            })
        };
        let times = self.base.flight.as_ref()?.samples().iter().map(|s| s.time);
        SampledFlight::new(times.map(sample).collect::<Option<Vec<_>>>()?).ok()
    }
}

impl JumpModel for Simulated {
    fn robot(&self) -> &Robot {
        &self.robot
    }

    fn accuracy(&self) -> f64 {
        ACCURACY
    }

    /// From the time that the simulated robot takes from a lean of -0.5 rad to the upright.
    fn pendulum(&self) -> f64 {
        let plain = self.robot().pendulum();
        let launch = Launch {
            rate: (0.5 * plain).sqrt(),
            lean: -PIVOT,
            firing_angle: 0.0,
            valve_open: 0.1,
        };
        let time = self
            .jump(&launch)
            .map_or(f64::NAN, |jump| jump.stance.time_fire);
        let (mut low, mut high) = (0.8 * plain, 1.25 * plain);
        if !(pivot_time(launch.rate, low) < time && time < pivot_time(launch.rate, high)) {
            return plain;
        }
        for _ in 0..50 {
            let middle = f64::midpoint(low, high);
            if pivot_time(launch.rate, middle) < time {
                low = middle;
            } else {
                high = middle;
            }
        }
        f64::midpoint(low, high)
    }

    fn jump(&self, launch: &Launch) -> Result<Jump, StanceError> {
        let run = self.run(&self.rig, launch, false)?;
        Ok(Jump {
            launch: *launch,
            stance: run.stance,
            flight: run.flight.map(JumpFlight::Sampled),
        })
    }

    /// By differences.
    fn sensitive_jump(&self, launch: &Launch) -> Result<Jump<Dual<4>>, StanceError> {
        let launch = launch.variables();
        let beside = self.beside(&launch, Some(3), false)?;
        let stance = beside.lift_off().ok_or_else(|| StanceError::Simulation {
            reason: "the jump has no derivatives: no launch beside it ends as it does".into(),
        })?;
        Ok(Jump {
            launch,
            stance,
            flight: beside.flight().map(JumpFlight::Sampled),
        })
    }

    fn traced(&self, launch: &Launch) -> Result<Traced, StanceError> {
        let run = self.run(&self.rig, launch, true)?;
        Ok(Traced {
            jump: Jump {
                launch: *launch,
                stance: run.stance,
                flight: run.flight.map(JumpFlight::Sampled),
            },
            way: run
                .way
                .iter()
                .flat_map(SampledFlight::samples)
                .map(instant)
                .collect(),
            friction_needed: run.friction_needed,
        })
    }

    fn steered(&self, launch: &Launch<Dual<2>>, with_friction: bool) -> Option<Steered> {
        let beside = self.beside(launch, None, with_friction).ok()?;
        let samples = beside.flight()?.samples().to_vec();
        let wide = |s: FlightSample<Dual<2>>| FlightSample {
            time: s.time,
            position: s.position.map(widen),
            velocity: s.velocity.map(widen),
        };
        let friction = || beside.number(|run| Some(run.friction_needed)).map(widen);
        let stance = beside.lift_off()?;
        Some(Steered {
            axle: stance.axle.map(widen),
            extension: widen(stance.extension),
            flight: JumpFlight::Sampled(
                SampledFlight::new(samples.into_iter().map(wide).collect()).ok()?,
            ),
            friction_needed: with_friction.then(friction).flatten(),
            spare: widen(spare_of(&self.robot().leg, launch.valve_open, &stance)),
        })
    }

    /// With derivatives at equal shares of the stance.
    fn steered_way(&self, launch: &Launch<Dual<2>>) -> Option<Vec<Instant<Slope>>> {
        let beside = self.beside(launch, None, true).ok()?;
        let end = beside.base.stance.time;
        let at = |sample: &FlightSample<f64>| {
            let share = sample.time / end;
            let here = |run: &Run| Some(run.way.as_ref()?.at(share * run.stance.time));
            Some(Instant {
                time: widen(beside.number(|run| Some(share * run.stance.time))?),
                centre: beside.numbers(|run| Some(here(run)?.position))?.map(widen),
                velocity: beside.numbers(|run| Some(here(run)?.velocity))?.map(widen),
            })
        };
        beside.base.way.as_ref()?.samples().iter().map(at).collect()
    }
}

fn launch_of([rate, lean, firing_angle, valve_open]: [f64; 4]) -> Launch {
    Launch {
        rate,
        lean,
        firing_angle,
        valve_open,
    }
}

/// How the stance of a report ended.
fn lift_off(report: &Report) -> LiftOff {
    let extends = |s: &Sample| s.extension > 0.0;
    let outcome = match report.end {
        End::Landed => None,
        End::Stalled => Some(Outcome::Stall),
        End::EarlyLiftOff => Some(Outcome::EarlyLiftOff),
        End::NoLiftOff if report.samples.iter().any(extends) => Some(Outcome::FallBack),
        End::NoLiftOff => Some(Outcome::NoBreakAway),
    };
    match (report.lift_off, report.samples.last()) {
        (Some(stance), _) => LiftOff {
            outcome: outcome.unwrap_or(stance.outcome),
            ..stance
        },
        (None, last) => {
            let number = |of: fn(&Sample) -> f64| last.map_or(f64::NAN, of);
            LiftOff {
                outcome: outcome.unwrap_or(Outcome::FallBack),
                time_fire: f64::NAN,
                time: number(|s| s.time),
                lean: number(|s| s.lean),
                rate: f64::NAN,
                extension: number(|s| s.extension),
                extension_rate: f64::NAN,
                pressure: number(|s| s.pressure),
                axle: last.map_or([f64::NAN; 2], |s| s.axle),
                axle_rates: last.map_or([f64::NAN; 2], |s| s.axle_rates),
            }
        }
    }
}

fn instant(sample: &FlightSample<f64>) -> Instant<f64> {
    Instant {
        time: sample.time,
        centre: sample.position,
        velocity: sample.velocity,
    }
}
/// Lean (rad) backwards from which a robot pivots to show how fast it does.
const PIVOT: f64 = 0.5;

/// Time (s) from a lean of -`PIVOT` to the upright with `rate` (rad/s) at the start, where a lean φ accelerates by
/// `c` sin φ: ∫ dφ/√(ω² + 2 c (cos φ_0 − cos φ)), by Simpson's rule.
fn pivot_time(rate: f64, c: f64) -> f64 {
    const STEPS: u32 = 200;
    let h = PIVOT / f64::from(STEPS);
    let slowness = |k: u32| {
        let lean = h * f64::from(k) - PIVOT;
        1.0 / (rate * rate + 2.0 * c * (PIVOT.cos() - lean.cos())).sqrt()
    };
    let weight = |k: u32| match k {
        0 | STEPS => 1.0,
        k if k % 2 == 1 => 4.0,
        _ => 2.0,
    };
    h / 3.0 * (0..=STEPS).map(|k| weight(k) * slowness(k)).sum::<f64>()
}
