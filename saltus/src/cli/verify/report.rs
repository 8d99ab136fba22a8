//! What a verification found, as text, JSON and CSV.

use std::fmt::Write;

use saltus::Planner;
use saltus::verify::{Flown, Plant};
use serde_json::{Map, Value, json};

use super::subject::Subject;
use super::trial::Outcome;
use crate::output::{self, Cell, Table, digits};

/// What was verified, and how.
pub(super) struct Context<'a> {
    pub(super) planner: &'a Planner,
    pub(super) plant: &'a Plant,
    pub(super) subject: &'a Subject,
    pub(super) tolerance: f64,
    pub(super) share: f64,
    pub(super) seed: u64,
    pub(super) step_cost: Option<&'a StepCost>,
}

/// What fixed steps cost: greatest differences from the jumps with error control.
pub(super) struct StepCost {
    step: f64,
    landing: f64,
    apex: f64,
    /// Jumps that end otherwise.
    other_ends: usize,
}

impl StepCost {
    /// Of jumps with steps of `step` (s), and the same with error control.
    pub(super) fn of(step: Option<f64>, fixed: &[Outcome], exact: &[Outcome]) -> StepCost {
        let pairs = || fixed.iter().zip(exact).map(|(a, b)| (&a.flown, &b.flown));
        let most = |of: fn(&Flown) -> Option<f64>| {
            let gaps = pairs().filter_map(|(a, b)| Some((of(a)? - of(b)?).abs()));
            gaps.fold(0.0, f64::max)
        };
        StepCost {
            step: step.unwrap_or(f64::NAN),
            landing: most(|f| f.landing),
            apex: most(|f| f.apex),
            other_ends: pairs().filter(|(a, b)| a.report.end != b.report.end).count(),
        }
    }
}

/// Whether all is well.
pub(super) struct Verdict {
    pub(super) passes: bool,
    /// Jumps with and without errors, on each ground and on all.
    groups: Vec<Group>,
}

/// Some of the jumps, together.
struct Group {
    errors: bool,
    /// None: the robot's own, or all of several.
    friction: Option<f64>,
    jumps: usize,
    passed: usize,
    landed: usize,
    slipped: usize,
    land_error: Spread,
    miss: Spread,
    apex_error: Spread,
    clearance: Option<f64>,
    slip: f64,
    friction_needed: f64,
    least_normal: f64,
    residual: f64,
}

/// Mean, standard deviation, root mean square and the greatest size of some numbers; none without any.
#[derive(Clone, Copy, Default)]
struct Spread {
    mean: Option<f64>,
    deviation: Option<f64>,
    rms: Option<f64>,
    greatest: Option<f64>,
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

impl Outcome {
    /// Simulated less planned landing (m).
    pub(super) fn land_error(&self) -> Option<f64> {
        self.flown.landing.map(|x| x - self.trial.landing)
    }

    fn apex_error(&self) -> Option<f64> {
        self.flown.apex.map(|y| y - self.trial.apex)
    }

    /// Simulated less wanted landing (m).
    pub(super) fn miss(&self) -> Option<f64> {
        self.flown.landing.map(|x| x - self.trial.wanted)
    }
}

impl Group {
    fn of(outcomes: &[&Outcome], friction: Option<f64>) -> Group {
        let count = |holds: &dyn Fn(&Outcome) -> bool| outcomes.iter().filter(|o| holds(o)).count();
        let reports = || outcomes.iter().map(|o| &o.flown.report);
        Group {
            errors: outcomes.iter().any(|o| o.trial.disturbance.is_some()),
            friction,
            jumps: outcomes.len(),
            passed: count(&|o| o.passes),
            landed: count(&|o| o.flown.landing.is_some()),
            slipped: count(&|o| o.flown.report.slips_at.is_some()),
            land_error: Spread::of(outcomes.iter().filter_map(|o| o.land_error())),
            miss: Spread::of(outcomes.iter().filter_map(|o| o.miss())),
            apex_error: Spread::of(outcomes.iter().filter_map(|o| o.apex_error())),
            clearance: outcomes.iter().filter_map(|o| o.flown.clearance).reduce(f64::min),
            slip: outcomes.iter().map(|o| o.flown.slip()).fold(0.0, greater),
            friction_needed: reports().map(|r| r.friction_needed).fold(0.0, f64::max),
            least_normal: reports().map(|r| r.least_normal).fold(f64::INFINITY, f64::min),
            residual: reports().map(|r| r.residual).fold(0.0, greater),
        }
    }

    fn json(&self) -> Map<String, Value> {
        let value = json!({
            "errors": self.errors,
            "friction_coefficient": self.friction,
            "jumps": self.jumps,
            "passed": self.passed,
            "landed": self.landed,
            "slipped": self.slipped,
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
            "normal_least_n": finite(self.least_normal),
            "energy_residual_greatest_j": self.residual,
        });
        match value {
            Value::Object(object) => object,
            _ => Map::new(),
        }
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// The one that is greater in size.
fn greater(a: f64, b: f64) -> f64 {
    if b.abs() > a.abs() { b } else { a }
}

impl Verdict {
    /// Of these jumps, where `share` of those with errors have to pass.
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
            let these: Vec<&Outcome> =
                outcomes.iter().filter(|o| o.trial.disturbance.is_some() == errors).collect();
            if these.is_empty() {
                continue;
            }
            let all = Group::of(&these, grounds[0].filter(|_| grounds.len() == 1));
            let needed = if errors { share } else { 1.0 };
            passes &= all.passed as f64 >= needed * all.jumps as f64;
            groups.push(all);
            if grounds.len() > 1 {
                for ground in &grounds {
                    let on: Vec<&Outcome> =
                        these.iter().copied().filter(|o| o.trial.friction == *ground).collect();
                    if !on.is_empty() {
                        groups.push(Group::of(&on, *ground));
                    }
                }
            }
        }
        Verdict { passes, groups }
    }

    /// The group of all jumps with or without errors.
    fn all(&self, errors: bool) -> Option<&Group> {
        self.groups.iter().find(|group| group.errors == errors)
    }

    /// The groups on each of several grounds.
    fn grounds(&self, errors: bool) -> impl Iterator<Item = &Group> {
        self.groups.iter().filter(move |group| group.errors == errors).skip(1)
    }
}

const COLUMNS: &[&str] = &[
    "trial",
    "errors",
    "jump",
    "omega_rad_s",
    "omega_true_rad_s",
    "alpha_f_rad",
    "valve_open_s",
    "friction_coefficient",
    "outcome",
    "apex_m",
    "apex_planned_m",
    "apex_error_m",
    "land_m",
    "land_planned_m",
    "land_error_m",
    "land_wanted_m",
    "miss_m",
    "clearance_m",
    "slip_start_s",
    "slip_m",
    "slip_across_m",
    "friction_needed",
    "normal_least_n",
    "energy_residual_j",
    "passes",
];

/// A row for each jump.
pub(super) fn rows(outcomes: &[Outcome]) -> Table {
    let mut table = Table::new(COLUMNS);
    for (i, outcome) in outcomes.iter().enumerate() {
        table.push(row(i, outcome));
    }
    table
}

fn row(i: usize, outcome: &Outcome) -> Vec<Cell> {
    let Outcome { trial, flown, task, passes } = outcome;
    let (launch, report) = (&trial.task.launch, &flown.report);
    vec![
        Cell::Count(i + 1),
        Cell::Flag(trial.disturbance.is_some()),
        Cell::Count(trial.jump + 1),
        launch.rate.into(),
        task.launch.rate.into(),
        launch.firing_angle.into(),
        launch.valve_open.into(),
        trial.friction.into(),
        Cell::Word(flown.outcome()),
        flown.apex.into(),
        trial.apex.into(),
        outcome.apex_error().into(),
        flown.landing.into(),
        trial.landing.into(),
        outcome.land_error().into(),
        trial.wanted.into(),
        outcome.miss().into(),
        flown.clearance.into(),
        report.slips_at.into(),
        report.slipped[0].into(),
        report.slipped[1].into(),
        report.friction_needed.into(),
        report.least_normal.into(),
        report.residual.into(),
        Cell::Flag(*passes),
    ]
}

/// What there is to say of a course without a plan.
pub(super) const NO_PLAN: &str =
    "no plan crosses this course: `saltus plan` says what blocks it, and the nearest that has one\n";

/// The same as a document.
pub(super) fn no_plan_json(planner: &Planner, plant: &Plant) -> String {
    output::json(&json!({
        "command": "verify",
        "robot": planner.robot().name,
        "plant": plant.robot().name,
        "passes": false,
        "reason": NO_PLAN.trim(),
        "groups": [],
        "rows": [],
    }))
}

/// The document.
pub(super) fn json(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> String {
    output::json(&json!({
        "command": "verify",
        "robot": context.planner.robot().name,
        "plant": context.plant.robot().name,
        "subject": context.subject.title,
        "seed": context.seed,
        "tolerance_m": context.tolerance,
        "share": context.share,
        "passes": verdict.passes,
        "step_cost": context.step_cost.map(|cost| json!({
            "step_s": cost.step,
            "landing_greatest_m": cost.landing,
            "apex_greatest_m": cost.apex,
            "other_ends": cost.other_ends,
        })),
        "groups": verdict.groups.iter().map(Group::json).collect::<Vec<_>>(),
        "rows": rows(outcomes).json(),
    }))
}

/// The jumps of a plan and of a short table are few enough to be told one by one.
const FEW: usize = 12;

/// For people.
pub(super) fn text(outcomes: &[Outcome], verdict: &Verdict, context: &Context<'_>) -> String {
    let mut text = format!(
        "{} of {}, in the multi-body simulation of {}\n",
        context.subject.title,
        context.planner.robot().name,
        context.plant.robot().name
    );
    for errors in [false, true] {
        if let Some(group) = verdict.all(errors) {
            text.push_str(&group_text(group, context));
            text.push_str(&grounds_text(verdict, errors));
        }
    }
    let nominal: Vec<&Outcome> = outcomes.iter().filter(|o| o.trial.disturbance.is_none()).collect();
    if nominal.len() <= FEW {
        let mut table = Table::new(COLUMNS);
        for (i, outcome) in nominal.iter().enumerate() {
            table.push(row(i, outcome));
        }
        text.push_str("\nwithout errors, jump by jump\n");
        text.push_str(&table.text(&[
            ("jump", "jump", ""),
            ("omega_rad_s", "ω", "rad/s"),
            ("alpha_f_rad", "α_f", "rad"),
            ("friction_coefficient", "friction", ""),
            ("outcome", "outcome", ""),
            ("apex_m", "apex", "m"),
            ("apex_planned_m", "planned", "m"),
            ("land_m", "landing", "m"),
            ("land_planned_m", "planned", "m"),
            ("land_wanted_m", "wanted", "m"),
            ("clearance_m", "clearance", "m"),
            ("slip_m", "slip", "m"),
            ("passes", "passes", ""),
        ]));
    }
    if let Some(cost) = context.step_cost {
        // Writing to a string does not fail.
        let _ = writeln!(
            text,
            "\nsteps of {} s: landings off by {} m at most, apexes by {} m, {} jumps end otherwise than with error control",
            digits(cost.step, 4),
            digits(cost.landing, 2),
            digits(cost.apex, 2),
            cost.other_ends
        );
    }
    text.push_str(if verdict.passes { "\nPASS" } else { "\nFAIL" });
    let share = digits(100.0 * context.share, 4);
    let _ = writeln!(
        text,
        ": every jump without errors and {share} % of the others have to land within {} m and clear what is in their way",
        digits(context.tolerance, 4)
    );
    text
}

fn group_text(group: &Group, context: &Context<'_>) -> String {
    let number = |x: Option<f64>| x.map_or("–".to_owned(), |x| digits(x, 3));
    let title = if group.errors {
        format!("with errors drawn, seed {}", context.seed)
    } else {
        "without errors".to_owned()
    };
    let mut lines =
        vec![format!("\n{title}: {} of {} jumps pass, {} land", group.passed, group.jumps, group.landed)];
    let landing = &group.land_error;
    lines.push(format!(
        "  landing, simulated less planned  {} m in the mean, {} m at most, {} m standard deviation",
        number(landing.mean),
        number(landing.greatest),
        number(landing.deviation)
    ));
    lines.push(format!(
        "  landing, simulated less wanted   {} m in the mean, {} m at most, {} m RMS",
        number(group.miss.mean),
        number(group.miss.greatest),
        number(group.miss.rms)
    ));
    lines.push(format!(
        "  apex, simulated less planned     {} m in the mean, {} m at most",
        number(group.apex_error.mean),
        number(group.apex_error.greatest)
    ));
    if let Some(gap) = group.clearance {
        lines.push(format!("  clearance                        {} m at least", digits(gap, 3)));
    }
    lines.push(match group.slipped {
        0 => "  slip                             none".to_owned(),
        n => format!("  slip                             {n} feet slip, {} m at most", digits(group.slip, 3)),
    });
    lines.push(format!(
        "  ground                           friction/normal force {} at most, normal force {} N at least",
        digits(group.friction_needed, 3),
        number(finite(group.least_normal))
    ));
    lines.push(format!(
        "  energy ledger                    closes within {} J",
        digits(group.residual.abs(), 2)
    ));
    lines.join("\n") + "\n"
}

/// One line for each of several grounds.
fn grounds_text(verdict: &Verdict, errors: bool) -> String {
    const NAMES: &[&str] =
        &["mu", "jumps", "passed", "slipped", "mean", "sd", "rms", "greatest", "apex", "slip"];
    let mut table = Table::new(NAMES);
    let mut groups = verdict.grounds(errors).peekable();
    if groups.peek().is_none() {
        return String::new();
    }
    for group in groups {
        table.push(vec![
            group.friction.into(),
            Cell::Count(group.jumps),
            Cell::Count(group.passed),
            Cell::Count(group.slipped),
            group.land_error.mean.into(),
            group.land_error.deviation.into(),
            group.miss.rms.into(),
            group.miss.greatest.into(),
            group.apex_error.mean.into(),
            group.slip.into(),
        ]);
    }
    table.text(&[
        ("mu", "friction", ""),
        ("jumps", "jumps", ""),
        ("passed", "pass", ""),
        ("slipped", "slip", ""),
        ("mean", "Δ landing", "m"),
        ("sd", "±", "m"),
        ("rms", "RMS miss", "m"),
        ("greatest", "worst miss", "m"),
        ("apex", "Δ apex", "m"),
        ("slip", "worst slip", "m"),
    ])
}
