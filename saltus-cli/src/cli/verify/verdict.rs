//! Whether a verification holds: the runs counted, and what they miss.

use saltus::verify::{Demand, Flight, Flown};
use serde_json::{Map, Value, json};

use super::trial::{Jump, Outcome};

/// Whether all is well.
pub(super) struct Verdict {
    pub(super) passes: bool,
    /// Runs with and without errors, on each ground and on all.
    pub(super) groups: Vec<Group>,
    /// What is missed, the most frequent first.
    pub(super) failures: Vec<Failure>,
}

/// Some of the runs, together.
pub(super) struct Group {
    pub(super) errors: bool,
    /// None: the robot's own, or all of several.
    pub(super) friction: Option<f64>,
    pub(super) runs: usize,
    pub(super) runs_passed: usize,
    pub(super) jumps: usize,
    pub(super) passed: usize,
    pub(super) landed: usize,
    pub(super) slipped: usize,
    pub(super) simulation_failed: usize,
    pub(super) not_started: usize,
    pub(super) land_error: Spread,
    pub(super) miss: Spread,
    pub(super) apex_error: Spread,
    pub(super) clearance: Option<f64>,
    pub(super) slip: f64,
    pub(super) friction_needed: Option<f64>,
    pub(super) least_normal: Option<f64>,
    pub(super) residual: Option<f64>,
}

/// A demand that one jump of the course misses, in some of the runs with or without errors.
pub(super) struct Failure {
    pub(super) errors: bool,
    /// Number of the jump in its run, from 0.
    pub(super) jump: usize,
    pub(super) demand: Demand,
    /// How these jumps ended.
    outcome: &'static str,
    pub(super) count: usize,
    /// Jumps that were started, of which `count` miss it.
    pub(super) of: usize,
    /// The least margin (m; of friction 1), and what happens there in words.
    pub(super) margin: f64,
    pub(super) worst: String,
}

/// Mean, standard deviation, root mean square and the greatest size of some numbers; none without
/// any.
#[derive(Clone, Copy, Default)]
pub(super) struct Spread {
    pub(super) mean: Option<f64>,
    pub(super) deviation: Option<f64>,
    pub(super) rms: Option<f64>,
    pub(super) greatest: Option<f64>,
}

impl Spread {
    fn of(numbers: impl Iterator<Item = f64>) -> Spread {
        let all: Vec<f64> = numbers.filter(|x| x.is_finite()).collect();
        if all.is_empty() {
            return Spread::default();
        }
        let n = all.len() as f64;
        let mean = all.iter().sum::<f64>() / n;
        let squares = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        Spread {
            mean: Some(mean),
            deviation: (all.len() > 1).then(|| (squares / (n - 1.0)).sqrt()),
            rms: Some((all.iter().map(|x| x * x).sum::<f64>() / n).sqrt()),
            greatest: all.iter().map(|x| x.abs()).reduce(f64::max),
        }
    }
}

impl Group {
    fn of(outcomes: &[&Outcome], friction: Option<f64>) -> Group {
        let jumps = || outcomes.iter().flat_map(|outcome| outcome.jumps());
        let flown = || jumps().filter_map(|jump| jump.attempt.flown());
        let count = |holds: &dyn Fn(&Jump<'_>) -> bool| jumps().filter(|jump| holds(jump)).count();
        let greatest =
            |of: &dyn Fn(&Flown) -> f64| flown().map(of).filter(|x| x.is_finite()).reduce(greater);
        Group {
            errors: outcomes.iter().any(|o| o.trial.has_errors()),
            friction,
            runs: outcomes.len(),
            runs_passed: outcomes.iter().filter(|o| o.passes()).count(),
            jumps: jumps().count(),
            passed: count(&|j| j.attempt.passes()),
            landed: count(&|j| j.attempt.landing().is_some()),
            slipped: flown().filter(|f| f.report.slips_at.is_some()).count(),
            simulation_failed: count(&|j| matches!(j.attempt.flight, Flight::Failed(_))),
            not_started: count(&|j| matches!(j.attempt.flight, Flight::NotStarted)),
            land_error: Spread::of(jumps().filter_map(|j| j.land_error())),
            miss: Spread::of(jumps().filter_map(|j| j.miss())),
            apex_error: Spread::of(jumps().filter_map(|j| j.apex_error())),
            clearance: jumps().filter_map(|j| j.attempt.clearance).reduce(f64::min),
            slip: flown().map(Flown::slip).fold(0.0, greater),
            friction_needed: greatest(&|f| f.report.friction_needed),
            least_normal: flown()
                .map(|f| f.report.least_normal)
                .filter(|x| x.is_finite())
                .reduce(f64::min),
            residual: greatest(&|f| f.report.residual),
        }
    }

    pub(super) fn json(&self) -> Map<String, Value> {
        let value = json!({
            "errors": self.errors,
            "friction_coefficient": self.friction,
            "runs": self.runs,
            "runs_passed": self.runs_passed,
            "jumps": self.jumps,
            "passed": self.passed,
            "landed": self.landed,
            "slipped": self.slipped,
            "simulation_failed": self.simulation_failed,
            "not_started": self.not_started,
            "land_error_mean_m": self.land_error.mean,
            "land_error_sd_m": self.land_error.deviation,
            "land_error_greatest_m": self.land_error.greatest,
            "miss_mean_m": self.miss.mean,
            "miss_sd_m": self.miss.deviation,
            "miss_rms_m": self.miss.rms,
            "miss_greatest_m": self.miss.greatest,
            "apex_error_mean_m": self.apex_error.mean,
            "apex_error_greatest_m": self.apex_error.greatest,
            "clearance_least_m": self.clearance,
            "slip_greatest_m": self.slip,
            "friction_needed_greatest": self.friction_needed,
            "normal_least_n": self.least_normal,
            "energy_residual_greatest_j": self.residual,
        });
        match value {
            Value::Object(object) => object,
            _ => Map::new(),
        }
    }
}

/// The one that is greater in size.
fn greater(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}

impl Failure {
    /// What all runs miss.
    fn all(outcomes: &[Outcome]) -> Vec<Failure> {
        let mut failures: Vec<Failure> = Vec::new();
        for outcome in outcomes {
            for jump in outcome.jumps() {
                note(&mut failures, &jump);
            }
        }
        let started = |failure: &Failure| {
            let jumps = outcomes
                .iter()
                .filter(|o| o.trial.has_errors() == failure.errors);
            jumps
                .filter(|o| o.attempts[failure.jump].was_started())
                .count()
        };
        for failure in &mut failures {
            failure.of = started(failure);
        }
        failures.sort_by_key(|failure| {
            (
                failure.errors,
                std::cmp::Reverse(failure.count),
                failure.jump,
            )
        });
        failures
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "errors": self.errors,
            "jump": self.jump + 1,
            "demand": self.demand.name(),
            "jumps": self.count,
            "of": self.of,
            "margin_least": Some(self.margin).filter(|margin| margin.is_finite()),
            "worst": self.worst,
        })
    }
}

/// Adds what a jump misses. One that was not started misses nothing of its own.
fn note(failures: &mut Vec<Failure>, jump: &Jump<'_>) {
    let attempt = jump.attempt;
    for miss in attempt.misses().filter(|_| attempt.was_started()) {
        // Jumps that do not land are told apart by how they end.
        let outcome = if miss.demand == Demand::Touchdown {
            attempt.outcome()
        } else {
            ""
        };
        let errors = jump.trial.has_errors();
        let same = |f: &&mut Failure| {
            (f.errors, f.jump, f.demand, f.outcome) == (errors, jump.number, miss.demand, outcome)
        };
        match failures.iter_mut().find(same) {
            Some(failure) => {
                failure.count += 1;
                if miss.margin < failure.margin {
                    (failure.margin, failure.worst) = (miss.margin, attempt.reason(miss));
                }
            }
            None => failures.push(Failure {
                errors,
                jump: jump.number,
                demand: miss.demand,
                outcome,
                count: 1,
                of: 0,
                margin: miss.margin,
                worst: attempt.reason(miss),
            }),
        }
    }
}

impl Verdict {
    /// Of these runs, where `share` of those with errors have to pass.
    pub(super) fn of(outcomes: &[Outcome], share: f64) -> Verdict {
        let mut grounds: Vec<Option<f64>> = Vec::new();
        for outcome in outcomes {
            if !grounds.contains(&outcome.trial.friction) {
                grounds.push(outcome.trial.friction);
            }
        }
        let mut groups = Vec::new();
        let mut passes = true;
        for errors in [false, true] {
            let these: Vec<&Outcome> = outcomes
                .iter()
                .filter(|o| o.trial.has_errors() == errors)
                .collect();
            if these.is_empty() {
                continue;
            }
            let all = Group::of(&these, grounds[0].filter(|_| grounds.len() == 1));
            let needed = if errors { share } else { 1.0 };
            passes &= all.runs_passed as f64 >= needed * all.runs as f64;
            groups.push(all);
            for ground in grounds.iter().filter(|_| grounds.len() > 1) {
                let on: Vec<&Outcome> = these
                    .iter()
                    .copied()
                    .filter(|o| o.trial.friction == *ground)
                    .collect();
                if !on.is_empty() {
                    groups.push(Group::of(&on, *ground));
                }
            }
        }
        Verdict {
            passes,
            groups,
            failures: Failure::all(outcomes),
        }
    }

    /// The group of all runs with or without errors.
    pub(super) fn all(&self, errors: bool) -> Option<&Group> {
        self.groups.iter().find(|group| group.errors == errors)
    }

    /// The groups on each of several grounds.
    pub(super) fn grounds(&self, errors: bool) -> impl Iterator<Item = &Group> {
        self.groups
            .iter()
            .filter(move |group| group.errors == errors)
            .skip(1)
    }
}
