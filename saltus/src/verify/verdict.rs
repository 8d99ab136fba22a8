//! Whether a verification holds: the runs counted, and what they miss.

use saltus_numeric::statistics::{mean, rms};

use super::{Demand, Flight, Flown, Outcome, RunJump};

/// Whether all is well.
#[derive(Clone, Debug)]
pub struct Verdict {
    /// Whether every run without errors passes, and of the others the share that has to.
    pub passes: bool,
    /// Runs with and without errors, on each ground and on all.
    pub groups: Vec<Group>,
    /// What is missed, the most frequent first.
    pub failures: Vec<Failure>,
}

/// Some of the runs, together.
#[derive(Clone, Debug)]
pub struct Group {
    /// Whether errors were drawn for them.
    pub errors: bool,
    /// None: the robot's own, or all of several.
    pub friction: Option<f64>,
    /// Runs.
    pub runs: usize,
    /// Runs of which every jump passes.
    pub runs_passed: usize,
    /// Jumps of these runs.
    pub jumps: usize,
    /// Jumps that meet every demand.
    pub passed: usize,
    /// Jumps that land.
    pub landed: usize,
    /// Jumps whose foot slips.
    pub slipped: usize,
    /// Jumps at which the simulation cannot go on.
    pub simulation_failed: usize,
    /// Jumps that were not started.
    pub not_started: usize,
    /// Simulated less planned landings (m).
    pub land_error: Spread,
    /// Simulated less wanted landings (m).
    pub miss: Spread,
    /// Simulated less planned apexes (m).
    pub apex_error: Spread,
    /// Least distance (m) between wheel and boxes.
    pub clearance: Option<f64>,
    /// Greatest way (m) that a foot slips.
    pub slip: f64,
    /// Greatest force along the travel over normal force.
    pub friction_needed: Option<f64>,
    /// Least normal force (N).
    pub least_normal: Option<f64>,
    /// Energy (J) that the ledger leaves unexplained, at most.
    pub residual: Option<f64>,
}

/// A demand that one jump of the course misses, in some of the runs with or without errors.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Whether errors were drawn for these runs.
    pub errors: bool,
    /// Number of the jump in its run, from 0.
    pub jump: usize,
    /// What is missed.
    pub demand: Demand,
    /// How these jumps ended.
    outcome: &'static str,
    /// Jumps that miss it.
    pub count: usize,
    /// Jumps that were started, of which `count` miss it.
    pub of: usize,
    /// The least margin (m; of friction 1).
    pub margin: f64,
    /// What happens there, in words.
    pub worst: String,
}

/// Mean, standard deviation, root mean square and the greatest size of some numbers; none without
/// any.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: Option<f64>,
    /// Standard deviation; none of one number.
    pub deviation: Option<f64>,
    /// Root mean square.
    pub rms: Option<f64>,
    /// Greatest size.
    pub greatest: Option<f64>,
}

impl Spread {
    fn of(numbers: impl Iterator<Item = f64>) -> Spread {
        let all: Vec<f64> = numbers.filter(|x| x.is_finite()).collect();
        if all.is_empty() {
            return Spread::default();
        }
        let n = all.len() as f64;
        let mean = mean(&all);
        let squares = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>();
        Spread {
            mean: Some(mean),
            deviation: (all.len() > 1).then(|| (squares / (n - 1.0)).sqrt()),
            rms: Some(rms(&all)),
            greatest: all.iter().map(|x| x.abs()).reduce(f64::max),
        }
    }
}

impl Group {
    fn of(outcomes: &[&Outcome], friction: Option<f64>) -> Group {
        let jumps = || outcomes.iter().flat_map(|outcome| outcome.jumps());
        let flown = || jumps().filter_map(|jump| jump.attempt.flown());
        let count =
            |holds: &dyn Fn(&RunJump<'_>) -> bool| jumps().filter(|jump| holds(jump)).count();
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
}

/// Adds what a jump misses. One that was not started misses nothing of its own.
fn note(failures: &mut Vec<Failure>, jump: &RunJump<'_>) {
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
    pub fn of(outcomes: &[Outcome], share: f64) -> Verdict {
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
    pub fn all(&self, errors: bool) -> Option<&Group> {
        self.groups.iter().find(|group| group.errors == errors)
    }

    /// The groups on each of several grounds.
    pub fn grounds(&self, errors: bool) -> impl Iterator<Item = &Group> {
        self.groups
            .iter()
            .filter(move |group| group.errors == errors)
            .skip(1)
    }
}
