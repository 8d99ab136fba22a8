//! Runs to simulate, with the errors that are drawn for them.

use std::sync::Arc;

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus_lagrangian::StanceError;
use saltus_numeric::{parallel, plain};
use saltus_planner::{Jump, JumpModel, Planner};
use saltus_robot::Errors;

use super::{
    Attempt, Demands, Disturbance, Plant, Route, Rule, Stage, Starts, Subject, Task, Verdict,
};

/// How a subject is verified: on which ground, with which errors, and what passes.
#[derive(Clone, Debug, PartialEq)]
pub struct Verification {
    /// Runs with errors drawn from the robot's own, beside those without.
    pub samples: usize,
    /// Size of the drawn errors, as a multiple of the robot's.
    pub scatter: f64,
    /// Seed of the drawn errors.
    pub seed: u64,
    /// Friction coefficients of the ground, at least one, which take turns; none: the robot's own.
    pub frictions: Vec<Option<f64>>,
    /// Where the jumps after the first start.
    pub starts: Starts,
    /// How far (m) from where it is wanted a landing may be; none: [`tolerance`](Verification::tolerance)
    /// by the size of the wheel.
    pub tolerance: Option<f64>,
    /// Least distance (m) in flight between wheel and boxes, in place of the course's.
    pub clearance: Option<f64>,
    /// Share of the runs with errors that have to pass.
    pub share: f64,
    /// Threads to work with, ≥ 1. The result does not depend on it.
    pub threads: usize,
}

/// A jump that is to be verified and that the planner does not take.
#[derive(Debug, thiserror::Error)]
#[error("jump at {} rad/s, fired at {} rad: {source}", plain(*rate), plain(*firing_angle))]
pub struct TrialError {
    /// Approach rate (rad/s).
    pub rate: f64,
    /// Firing angle (rad).
    pub firing_angle: f64,
    /// Why not.
    pub source: StanceError,
}

/// A run to simulate: all jumps of a course, or one of a law or a table.
#[derive(Clone, Debug)]
pub struct Trial {
    /// The jumps, as measured and commanded.
    pub route: Arc<Route>,
    /// Errors of each jump; none: without errors.
    pub errors: Option<Vec<Disturbance>>,
    /// Friction coefficient of the ground; none: the robot's own.
    pub friction: Option<f64>,
}

/// A run that was simulated.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// What was to be simulated.
    pub trial: Trial,
    /// Jump after jump.
    pub attempts: Vec<Attempt>,
}

/// One jump of a run.
#[derive(Clone, Copy, Debug)]
pub struct RunJump<'a> {
    /// The run.
    pub trial: &'a Trial,
    /// Its number in the run, from 0.
    pub number: usize,
    /// How it went.
    pub attempt: &'a Attempt,
}

impl Trial {
    /// Simulates it.
    pub fn fly(&self, plant: &Plant, starts: Starts) -> Outcome {
        let plant = self
            .friction
            .map_or_else(|| plant.clone(), |mu| plant.on_friction(mu));
        let errors = self.errors.as_deref().unwrap_or_default();
        Outcome {
            trial: self.clone(),
            attempts: plant.run(&self.route, errors, starts),
        }
    }

    /// Whether any errors were drawn for it.
    pub fn has_errors(&self) -> bool {
        self.errors.is_some()
    }
}

impl Outcome {
    /// Whether every jump meets every demand.
    pub fn passes(&self) -> bool {
        self.attempts.iter().all(Attempt::passes)
    }

    /// Jump after jump.
    pub fn jumps(&self) -> impl Iterator<Item = RunJump<'_>> {
        let jump = |(number, attempt)| RunJump {
            trial: &self.trial,
            number,
            attempt,
        };
        self.attempts.iter().enumerate().map(jump)
    }
}

impl RunJump<'_> {
    /// As it was planned.
    pub fn stage(&self) -> &Stage {
        &self.trial.route.stages[self.number]
    }

    /// Simulated less planned landing (m).
    pub fn land_error(&self) -> Option<f64> {
        self.attempt.landing().map(|x| x - self.stage().landing)
    }

    /// Simulated less planned apex (m).
    pub fn apex_error(&self) -> Option<f64> {
        self.attempt.apex().map(|y| y - self.stage().apex)
    }

    /// Simulated less wanted landing (m).
    pub fn miss(&self) -> Option<f64> {
        self.attempt.landing().map(|x| x - self.stage().wanted)
    }
}

impl Default for Verification {
    /// 100 runs with the robot's errors on its own ground, landings within a fifth of the wheel's radius,
    /// of which 90 % have to pass.
    fn default() -> Verification {
        Verification {
            samples: 100,
            scatter: 1.0,
            seed: 1,
            frictions: vec![None],
            starts: Starts::Chained,
            tolerance: None,
            clearance: None,
            share: 0.9,
            threads: parallel::available(),
        }
    }
}

impl Verification {
    /// How far a landing may be from where it is wanted, as part of the wheel's radius. A wheel that
    /// overhangs an edge by so much sinks below it by 2 % of its radius, 1 − √(1 − 0.2²): it still
    /// stands on the edge.
    pub const RELATIVE_TOLERANCE: f64 = 0.2;

    /// How far (m) a landing of a robot whose wheel has this `radius` (m) may be from where it is wanted.
    pub fn tolerance(&self, radius: f64) -> f64 {
        let usual = Verification::RELATIVE_TOLERANCE * radius;
        self.tolerance.unwrap_or(usual)
    }

    /// Verifies `subject`, which `planner` has planned, on `plant`.
    ///
    /// # Errors
    /// [`TrialError`] for a jump that the planner does not take.
    ///
    /// # Panics
    /// As [`trials`](Verification::trials).
    pub fn verdict(
        &self,
        subject: &Subject,
        planner: &Planner<dyn JumpModel>,
        plant: &Plant,
    ) -> Result<Verdict, TrialError> {
        let trials = self.trials(subject, planner, plant.robot().body.radius)?;
        Ok(Verdict::of(&self.fly(plant, &trials, &|| ()), self.share))
    }

    /// Simulates `trials` on `plant`; `progress` is called after each.
    pub fn fly(
        &self,
        plant: &Plant,
        trials: &[Trial],
        progress: &(dyn Fn() + Sync),
    ) -> Vec<Outcome> {
        let fly = |trial: &Trial| {
            let outcome = trial.fly(plant, self.starts);
            progress();
            outcome
        };
        parallel::map_on(self.threads, trials.len(), |k| fly(&trials[k]))
    }

    /// All runs, without errors, then with, of a robot whose wheel has this `radius` (m).
    ///
    /// # Errors
    /// [`TrialError`] for a jump that the planner does not take.
    ///
    /// # Panics
    /// If there are no `frictions`, or a rule is a table without rows.
    pub fn trials(
        &self,
        subject: &Subject,
        planner: &Planner<dyn JumpModel>,
        radius: f64,
    ) -> Result<Vec<Trial>, TrialError> {
        let mut random = Pcg64::seed_from_u64(self.seed);
        let nominal: Vec<Arc<Route>> = match subject {
            Subject::Plan { crossing, plan } => {
                let mut route = Route::of(crossing, plan, radius, self.tolerance(radius));
                route.demands.clearance = self.clearance.unwrap_or(crossing.clearance);
                vec![Arc::new(route)]
            }
            Subject::Rule(rule) => {
                let route = |&rate| self.single(planner, rule, rate, radius).map(Arc::new);
                rule.rates.iter().map(route).collect::<Result<_, _>>()?
            }
        };
        let without = |&friction: &Option<f64>| {
            nominal.iter().map(move |route| Trial {
                route: route.clone(),
                errors: None,
                friction,
            })
        };
        let mut trials: Vec<Trial> = self.frictions.iter().flat_map(without).collect();
        for i in 0..self.samples {
            let route = match subject {
                Subject::Plan { .. } => nominal[0].clone(),
                Subject::Rule(rule) => {
                    let rate = drawn_rate(&rule.rates, &mut random);
                    Arc::new(self.single(planner, rule, rate, radius)?)
                }
            };
            let sizes = &planner.robot().errors;
            let errors = errors(sizes, route.stages.len(), self.scatter, &mut random);
            trials.push(Trial {
                route,
                errors: Some(errors),
                friction: self.frictions[i % self.frictions.len()],
            });
        }
        Ok(trials)
    }

    /// The one jump of a law or a table at an approach rate (rad/s), of a wheel of this `radius` (m), with
    /// what the planner expects of it.
    fn single(
        &self,
        planner: &Planner<dyn JumpModel>,
        rule: &Rule,
        rate: f64,
        radius: f64,
    ) -> Result<Route, TrialError> {
        let Task {
            launch,
            landing_height,
            obstacles,
            leg_out,
        } = rule.task(rate);
        let planned = match planner.jump(&launch) {
            Ok(jump) => Some(jump),
            Err(source @ StanceError::Input { .. }) => {
                return Err(TrialError {
                    rate,
                    firing_angle: launch.firing_angle,
                    source,
                });
            }
            Err(_) => None,
        };
        let number = |of: Option<f64>| of.unwrap_or(f64::NAN);
        let planned = planned.as_ref();
        let landing = number(planned.and_then(|jump| jump.distance(landing_height)));
        let stage = Stage {
            launch,
            foot: [0.0; 2],
            landing_height,
            surface: None,
            apex: number(planned.and_then(Jump::apex)),
            landing,
            wanted: rule.distance.unwrap_or(landing),
        };
        let clearance = self.clearance.unwrap_or(0.0);
        let demands = Demands {
            obstacles,
            clearance,
            leg_out,
            ..Demands::within(self.tolerance(radius))
        };
        Ok(Route {
            stages: vec![stage],
            demands,
        })
    }
}

/// Errors of the jumps of one run. Rate, angle and valve time err anew in every jump, the supply
/// pressure is off by the same all along.
fn errors(sizes: &Errors, jumps: usize, factor: f64, random: &mut Pcg64) -> Vec<Disturbance> {
    let mut drawn = || {
        let normal = std::array::from_fn(|_| {
            let x: f64 = StandardNormal.sample(random);
            factor * x
        });
        Disturbance::drawn(sizes, normal)
    };
    let first = drawn();
    let rest = (1..jumps).map(|_| Disturbance {
        supply: first.supply,
        ..drawn()
    });
    std::iter::once(first).chain(rest).collect()
}

/// A rate between the least and the greatest.
fn drawn_rate(rates: &[f64], random: &mut Pcg64) -> f64 {
    let low = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let high = rates.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Uniform::new_inclusive(low, high).map_or(low, |range| range.sample(random))
}
