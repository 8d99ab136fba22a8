//! Jumps to simulate, with the errors that are drawn for them.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;
use saltus::Planner;
use saltus::verify::{Disturbance, Flown, Plant, Task};

use super::subject::{Kind, Subject};
use crate::error::CliError;

/// Which errors are drawn, and what is asked of the jumps.
pub(super) struct Scatter {
    pub(super) samples: usize,
    pub(super) factor: f64,
    pub(super) seed: u64,
    /// How far (m) from where it is wanted a landing may be.
    pub(super) tolerance: f64,
}

/// A jump to simulate.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// Number of the jump in its plan, from 0.
    pub(super) jump: usize,
    /// As measured and commanded.
    pub(super) task: Task,
    /// Foothold along the course, and height of its surface (m).
    pub(super) foot: [f64; 2],
    /// None: without errors.
    pub(super) disturbance: Option<Disturbance>,
    /// Friction coefficient of the ground; none: the robot's own.
    pub(super) friction: Option<f64>,
    /// Apex and landing (m) as planned.
    pub(super) apex: f64,
    pub(super) landing: f64,
    /// Where it should land (m).
    pub(super) wanted: f64,
    tolerance: f64,
}

/// A jump that was simulated.
pub(super) struct Outcome {
    pub(super) trial: Trial,
    pub(super) flown: Flown,
    /// As it really was.
    pub(super) task: Task,
    pub(super) passes: bool,
}

impl Trial {
    /// Simulates it.
    pub(super) fn fly(&self, plant: &Plant) -> Result<Outcome, CliError> {
        let plant = self.friction.map_or_else(|| plant.clone(), |mu| plant.on_friction(mu));
        let (plant, task) = match &self.disturbance {
            Some(disturbance) => plant.disturbed(&self.task, disturbance),
            None => (plant, self.task.clone()),
        };
        let flown = plant.fly(&task).map_err(|error| {
            let launch = &task.launch;
            let jump = format!("jump at {} rad/s, fired at {} rad", launch.rate, launch.firing_angle);
            CliError::content(jump, error)
        })?;
        let lands = flown.landing.is_some_and(|x| (x - self.wanted).abs() <= self.tolerance);
        let passes = lands && flown.clearance.is_none_or(|gap| gap >= 0.0);
        Ok(Outcome { trial: self.clone(), flown, task, passes })
    }
}

/// All jumps: without errors, then with.
pub(super) fn draw(
    subject: &Subject,
    planner: &Planner,
    frictions: &[Option<f64>],
    scatter: &Scatter,
) -> Result<Vec<Trial>, CliError> {
    let mut random = Pcg64::seed_from_u64(scatter.seed);
    let disturbance = |random: &mut Pcg64| {
        let normal = std::array::from_fn(|_| {
            let x: f64 = StandardNormal.sample(random);
            scatter.factor * x
        });
        Disturbance::drawn(&planner.robot().errors, normal)
    };
    let make = |jump, task: Task, [apex, landing, wanted]: [f64; 3]| Trial {
        jump,
        task,
        foot: [0.0; 2],
        disturbance: None,
        friction: None,
        apex,
        landing,
        wanted,
        tolerance: scatter.tolerance,
    };
    let nominal: Vec<Trial> = match &subject.kind {
        Kind::Plan { stages, .. } => stages
            .iter()
            .enumerate()
            .map(|(i, stage)| Trial {
                foot: stage.foot,
                ..make(i, stage.task.clone(), [stage.apex, stage.landing, stage.landing])
            })
            .collect(),
        Kind::Rule(rule) => rule
            .rates
            .iter()
            .map(|&rate| {
                let task = rule.task(rate);
                Ok(make(0, task.clone(), planned(planner, &task, rule.distance)?))
            })
            .collect::<Result<_, CliError>>()?,
    };
    let on = |trial: &Trial, friction| Trial { friction, ..trial.clone() };
    let mut trials: Vec<Trial> =
        frictions.iter().flat_map(|&mu| nominal.iter().map(move |trial| on(trial, mu))).collect();
    for i in 0..scatter.samples {
        let mut trial = match &subject.kind {
            Kind::Plan { .. } => nominal[i % nominal.len()].clone(),
            Kind::Rule(rule) => {
                let task = rule.task(drawn_rate(&rule.rates, &mut random));
                make(0, task.clone(), planned(planner, &task, rule.distance)?)
            }
        };
        trial.disturbance = Some(disturbance(&mut random));
        trial.friction = frictions[(i / nominal_turn(subject)) % frictions.len()];
        trials.push(trial);
    }
    Ok(trials)
}

/// Samples in a row on one friction coefficient: one for each jump of a plan.
fn nominal_turn(subject: &Subject) -> usize {
    match &subject.kind {
        Kind::Plan { stages, .. } => stages.len().max(1),
        Kind::Rule(_) => 1,
    }
}

/// A rate between the least and the greatest.
fn drawn_rate(rates: &[f64], random: &mut Pcg64) -> f64 {
    let low = rates.iter().copied().fold(f64::INFINITY, f64::min);
    let high = rates.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Uniform::new_inclusive(low, high).map_or(low, |range| range.sample(random))
}

/// Apex and landing (m) that the planner expects, and where the landing is wanted.
fn planned(planner: &Planner, task: &Task, distance: Option<f64>) -> Result<[f64; 3], CliError> {
    let launch = &task.launch;
    let jump = planner.jump(launch).map_err(|source| CliError::Jump {
        jump: format!("jump at {} rad/s, fired at {} rad", launch.rate, launch.firing_angle),
        source,
    })?;
    let landing = jump.distance(task.landing_height).unwrap_or(f64::NAN);
    Ok([jump.apex().unwrap_or(f64::NAN), landing, distance.unwrap_or(landing)])
}
