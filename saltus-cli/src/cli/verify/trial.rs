//! Runs to simulate, with the errors that are drawn for them.

use std::sync::Arc;

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus::verify::{Attempt, Demands, Disturbance, Plant, Route, Stage, Starts, Task};
use saltus::{Planner, StanceError};

use super::subject::{Kind, Rule, Subject};
use crate::error::CliError;

/// Which errors are drawn.
pub(super) struct Scatter {
    pub(super) samples: usize,
    pub(super) factor: f64,
    pub(super) seed: u64,
}

/// What is asked of the jumps beside what the course demands.
pub(super) struct Limits {
    /// How far (m) from where it is wanted a landing may be.
    pub(super) tolerance: f64,
    /// Clearance (m) in place of the course's.
    pub(super) clearance: Option<f64>,
}

/// A run to simulate: all jumps of a course, or one of a law or a table.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// The jumps, as measured and commanded.
    pub(super) route: Arc<Route>,
    /// Errors of each jump; none: without errors.
    pub(super) errors: Option<Vec<Disturbance>>,
    /// Friction coefficient of the ground; none: the robot's own.
    pub(super) friction: Option<f64>,
}

/// A run that was simulated.
pub(super) struct Outcome {
    pub(super) trial: Trial,
    /// Jump after jump.
    pub(super) attempts: Vec<Attempt>,
}

/// One jump of a run.
#[derive(Clone, Copy)]
pub(super) struct Jump<'a> {
    pub(super) trial: &'a Trial,
    /// Its number in the run, from 0.
    pub(super) number: usize,
    pub(super) attempt: &'a Attempt,
}

impl Trial {
    /// Simulates it.
    pub(super) fn fly(&self, plant: &Plant, starts: Starts) -> Outcome {
        let plant = self
            .friction
            .map_or_else(|| plant.clone(), |mu| plant.on_friction(mu));
        let errors = self.errors.as_deref().unwrap_or_default();
        Outcome {
            trial: self.clone(),
            attempts: plant.run(&self.route, errors, starts),
        }
    }

    pub(super) fn has_errors(&self) -> bool {
        self.errors.is_some()
    }
}

impl Outcome {
    /// Whether every jump meets every demand.
    pub(super) fn passes(&self) -> bool {
        self.attempts.iter().all(Attempt::passes)
    }

    pub(super) fn jumps(&self) -> impl Iterator<Item = Jump<'_>> {
        let jump = |(number, attempt)| Jump {
            trial: &self.trial,
            number,
            attempt,
        };
        self.attempts.iter().enumerate().map(jump)
    }
}

impl Jump<'_> {
    /// As it was planned.
    pub(super) fn stage(&self) -> &Stage {
        &self.trial.route.stages[self.number]
    }

    /// Simulated less planned landing (m).
    pub(super) fn land_error(&self) -> Option<f64> {
        self.attempt.landing().map(|x| x - self.stage().landing)
    }

    /// Simulated less planned apex (m).
    pub(super) fn apex_error(&self) -> Option<f64> {
        self.attempt.apex().map(|y| y - self.stage().apex)
    }

    /// Simulated less wanted landing (m).
    pub(super) fn miss(&self) -> Option<f64> {
        self.attempt.landing().map(|x| x - self.stage().wanted)
    }
}

/// All runs: without errors, then with.
pub(super) fn draw(
    subject: &Subject,
    planner: &Planner,
    radius: f64,
    frictions: &[Option<f64>],
    limits: &Limits,
    scatter: &Scatter,
) -> Result<Vec<Trial>, CliError> {
    let mut random = Pcg64::seed_from_u64(scatter.seed);
    let nominal: Vec<Arc<Route>> = match &subject.kind {
        Kind::Plan { crossing, plan } => {
            let mut route = Route::of(crossing, plan, radius, limits.tolerance);
            route.demands.clearance = limits.clearance.unwrap_or(crossing.clearance);
            vec![Arc::new(route)]
        }
        Kind::Rule(rule) => {
            let route = |&rate| single(planner, rule, rate, limits).map(Arc::new);
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
    let mut trials: Vec<Trial> = frictions.iter().flat_map(without).collect();
    for i in 0..scatter.samples {
        let route = match &subject.kind {
            Kind::Plan { .. } => nominal[0].clone(),
            Kind::Rule(rule) => {
                let rate = drawn_rate(&rule.rates, &mut random);
                Arc::new(single(planner, rule, rate, limits)?)
            }
        };
        let errors = errors(planner, route.stages.len(), scatter.factor, &mut random);
        trials.push(Trial {
            route,
            errors: Some(errors),
            friction: frictions[i % frictions.len()],
        });
    }
    Ok(trials)
}

/// Errors of the jumps of one run. Rate, angle and valve time err anew in every jump, the supply
/// pressure is off by the same all along.
fn errors(planner: &Planner, jumps: usize, factor: f64, random: &mut Pcg64) -> Vec<Disturbance> {
    let mut drawn = || {
        let normal = std::array::from_fn(|_| {
            let x: f64 = StandardNormal.sample(random);
            factor * x
        });
        Disturbance::drawn(&planner.robot().errors, normal)
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

/// The one jump of a law or a table at an approach rate (rad/s), with what the planner expects of
/// it.
fn single(planner: &Planner, rule: &Rule, rate: f64, limits: &Limits) -> Result<Route, CliError> {
    let Task {
        launch,
        landing_height,
        obstacles,
        leg_out,
    } = rule.task(rate);
    let planned = match planner.jump(&launch) {
        Ok(jump) => Some(jump),
        Err(source @ StanceError::Input { .. }) => {
            let jump = format!(
                "jump at {} rad/s, fired at {} rad",
                launch.rate, launch.firing_angle
            );
            return Err(CliError::Jump { jump, source });
        }
        Err(_) => None,
    };
    let number = |of: Option<f64>| of.unwrap_or(f64::NAN);
    let landing = number(planned.and_then(|jump| jump.distance(landing_height)));
    let stage = Stage {
        launch,
        foot: [0.0; 2],
        landing_height,
        surface: None,
        apex: number(planned.and_then(|jump| jump.apex())),
        landing,
        wanted: rule.distance.unwrap_or(landing),
    };
    let clearance = limits.clearance.unwrap_or(0.0);
    let demands = Demands {
        obstacles,
        leg_out,
        clearance,
        ..Demands::within(limits.tolerance)
    };
    Ok(Route {
        stages: vec![stage],
        demands,
    })
}
