//! Plans as rows, as JSON and in words.

use saltus::Robot;
use saltus::course::{ANYWHERE, demanded_target};
use saltus::planner::course::{MAX_JUMPS, Obstacle, Relief, Span};
use saltus::planner::{Check, Correction, Crossing, CrossingAnswer, CrossingPlan, PlannedJump};
use saltus::robust::Margins;
use saltus::verify::{Demand, Verification};
use serde_json::{Value, json};

use crate::cli::common::opening;
use crate::cli::limits;
use crate::output::{self, Column, Table, columns, counted, digits, measured};

/// A jump of a plan, and its number from 0.
struct Row<'a> {
    plan: &'a Plan,
    i: usize,
    planned: &'a PlannedJump,
    /// Where the last one is to land (m).
    target: Option<f64>,
    robot: &'a Robot,
}

fn columns<'a>() -> [Column<Row<'a>>; 15] {
    columns! {
        "jump", "jump", |row| row.i + 1;
        "omega_rad_s", "ω", |row| row.planned.jump.launch.rate;
        "phi0_rad", "", |row| row.planned.jump.launch.lean;
        "alpha_f_rad", "α_f", |row| row.planned.jump.launch.firing_angle;
        "valve_open_s", "valve open", |row| opening(row.robot, &row.planned.jump.launch);
        "foot_x_m", "foot", |row| row.planned.foot[0];
        "foot_y_m", "", |row| row.planned.foot[1];
        "apex_m", "apex", |row| row.planned.jump.apex().map(|apex| row.planned.foot[1] + apex);
        "land_x_m", "landing", |row| row.planned.landing[0];
        "land_y_m", "at height", |row| row.planned.landing[1];
        "land_sd_m", "± landing", |row| Some(row.planned.deviation).filter(|d| *d > 0.0);
        "target_x_m", "", |row| row.target;
        "off_target_m", "off target", |row| {
            let off = row.target.map(|target| row.planned.landing[0] - target);
            off.map(|off| if off.abs() < ROUND_OFF { 0.0 } else { off })
        };
        "friction_needed", "friction|needed", |row| row.planned.friction_needed;
        "holds", "holds", |row| {
            let mut checks = row.plan.checks.iter().filter(|check| check.jump == row.i);
            checks.all(Check::holds)
        };
    }
}

/// A distance (m) below this is round-off.
const ROUND_OFF: f64 = 1e-9;

/// In place of what is allowed where all is.
const NO_LIMIT: &str = "no limit";

/// What a course comes to.
pub(super) type Answer = CrossingAnswer;

/// A plan for it.
type Plan = CrossingPlan;

/// What is reported.
pub(super) struct Report<'a> {
    pub(super) answer: &'a Answer,
    pub(super) crossing: &'a Crossing,
    /// Whether the search was stopped by Ctrl-C.
    pub(super) interrupted: bool,
    /// The robot that jumps, if it is not the planar one, and how the planner was corrected for it.
    pub(super) plant: Option<(&'a Robot, Correction)>,
    /// How often a plan holds with errors drawn, where that was asked for.
    pub(super) hold: Option<Hold>,
}

/// How often a plan holds with errors drawn.
pub(super) struct Hold {
    /// The share asked for, and that of fresh runs.
    pub(super) asked: f64,
    pub(super) share: f64,
    /// How many.
    pub(super) runs: usize,
    pub(super) margins: Margins,
    /// The least that no plan was found with; infinite where none was refused.
    pub(super) refused: Margins,
    /// What is missed most often.
    pub(super) missed: Option<Demand>,
    /// Friction coefficients of the ground, and the last landing (m) there without errors.
    pub(super) grounds: Vec<(f64, Option<f64>)>,
    /// Whether the robot that jumps has errors to draw.
    pub(super) has_errors: bool,
    /// Where the share is not reached: what blocks a plan with the margins that it would take.
    pub(super) blocked: Option<Relief>,
}

impl Hold {
    /// Whether the runs do not speak against the share that is asked for: two binomial standard
    /// deviations.
    pub(super) fn is_enough(&self) -> bool {
        let deviation = (self.asked * (1.0 - self.asked) / self.runs as f64).sqrt();
        self.share >= self.asked - 2.0 * deviation
    }

    fn json(&self) -> Value {
        json!({
            "share_asked": self.asked,
            "share": self.share,
            "runs": self.runs,
            "is_enough": self.is_enough(),
            "clearance_margin_m": self.margins.clearance,
            "landing_margin_m": self.margins.landing,
            "friction_margin": self.margins.friction,
            "clearance_margin_refused_m": self.refused.clearance,
            "landing_margin_refused_m": self.refused.landing,
            "friction_margin_refused": self.refused.friction,
            "missed_most": self.missed.map(Demand::name),
            "landings": self.grounds.iter().map(|(friction, landing)| json!({
                "friction": friction,
                "land_x_m": landing,
            })).collect::<Vec<_>>(),
            "blocked_by": self.blocked.as_ref().map(|relief| limits::json(&relief.gives)),
        })
    }

    /// Where the last jump lands on each ground, if there are some.
    fn grounds_text(&self) -> Option<String> {
        let lands = |landing: Option<f64>| landing.map_or("nowhere".into(), |x| digits(x, 4));
        let on = |(friction, landing): &(f64, Option<f64>)| {
            format!("{} m ({})", lands(*landing), digits(*friction, 3))
        };
        let all: Vec<String> = self.grounds.iter().map(on).collect();
        (!all.is_empty()).then(|| {
            format!(
                "last landing without errors, by the friction coefficient of the ground: {}",
                all.join(", ")
            )
        })
    }

    fn text(&self, crossing: &Crossing) -> String {
        let verdict = if self.is_enough() {
            "holds"
        } else {
            "is the best that was found, and holds"
        };
        let share = |x: f64| digits(100.0 * x, 3);
        let mut lines = vec![
            format!(
                "the plan {verdict} for {} % of {} with errors drawn, {} % asked for",
                share(self.share),
                counted(self.runs, "run"),
                share(self.asked)
            ),
            format!(
                "margins for that: {} mm over obstacles, {} mm from the ends of the ground, {} of \
                 the friction coefficient",
                digits(1e3 * self.margins.clearance, 3),
                digits(1e3 * self.margins.landing, 3),
                digits(self.margins.friction, 2)
            ),
        ];
        if !self.has_errors {
            lines.push(
                "the robot's file has no [errors]: nothing was drawn, and every run is the same"
                    .into(),
            );
        }
        lines.extend(self.grounds_text());
        if !self.is_enough() {
            let refused = [
                (1e3 * self.refused.clearance, "mm over obstacles"),
                (1e3 * self.refused.landing, "mm from the ends of the ground"),
                (self.refused.friction, "of the friction coefficient"),
            ];
            let refused: Vec<String> = refused
                .iter()
                .filter(|(least, _)| least.is_finite())
                .map(|(least, what)| format!("{} {what}", digits(*least, 3)))
                .collect();
            if !refused.is_empty() {
                lines.push(format!("no plan was found with {}", refused.join(", or ")));
            }
            let missed = self.missed.iter();
            lines.extend(missed.map(|d| format!("what is missed most often: {}", d.name())));
            let blocked = self
                .blocked
                .iter()
                .filter(|relief| !relief.gives.is_empty());
            lines.extend(blocked.map(|relief| {
                let nearest = limits::text(&relief.gives, crossing);
                format!("with greater margins there is no plan: {nearest}")
            }));
        }
        lines
            .iter()
            .map(|line| format!("  {line}\n"))
            .collect::<Vec<_>>()
            .concat()
    }
}

impl Report<'_> {
    /// One row for each jump; none without a plan.
    pub(super) fn table(&self, robot: &Robot) -> Table {
        let plan = match self.answer {
            CrossingAnswer::Plan(plan) => Some(plan),
            _ => None,
        };
        let row = |plan, (i, planned)| Row {
            plan,
            i,
            planned,
            target: Some(self.crossing.target).filter(|_| i + 1 == plan.jumps.len()),
            robot,
        };
        let rows = plan.into_iter().flat_map(|plan: &Plan| {
            plan.jumps
                .iter()
                .enumerate()
                .map(move |jump| row(plan, jump))
        });
        Table::of(&columns(), rows)
    }

    /// Landing less target (m) of a plan, if the course demands the target and the plan is farther from it
    /// than `saltus verify` allows.
    pub(super) fn off_demanded(&self, robot: &Robot) -> Option<f64> {
        let CrossingAnswer::Plan(plan) = self.answer else {
            return None;
        };
        let target = demanded_target(self.crossing)?;
        let off = plan.jumps.last()?.landing[0] - target;
        let allowed = Verification::default().tolerance(robot.body.radius);
        (off.abs() > allowed).then_some(off)
    }

    fn status(&self, robot: &Robot) -> (&'static str, String) {
        let plant = self.plant.as_ref().map(|(plant, _)| &plant.name);
        match (self.answer, plant) {
            (CrossingAnswer::Plan(plan), _)
                if plan.holds() && self.off_demanded(robot).is_some() =>
            {
                ("misses-the-target", "misses the target".into())
            }
            (CrossingAnswer::Plan(plan), None) if plan.holds() => (
                "holds-in-the-planar-model",
                "holds in the planar model (`saltus verify` flies it)".into(),
            ),
            (CrossingAnswer::Plan(_), None) => (
                "fails-in-the-planar-model",
                "fails in the planar model: see the limits below".into(),
            ),
            (CrossingAnswer::Plan(plan), Some(plant)) if plan.holds() => (
                "holds-on-the-plant",
                format!("holds on {plant} (`saltus verify --plant … --correct` draws errors too)"),
            ),
            (CrossingAnswer::Plan(_), Some(plant)) => (
                "fails-on-the-plant",
                format!("fails on {plant}: see the limits below"),
            ),
            (CrossingAnswer::Infeasible { .. }, None) => ("infeasible", "infeasible".into()),
            (CrossingAnswer::Infeasible { .. }, Some(plant)) => {
                ("infeasible", format!("infeasible on {plant}"))
            }
            (CrossingAnswer::Undecided { .. }, _) => ("undecided", "undecided".into()),
        }
    }

    /// How the planner was corrected for the plant, in a line.
    fn correction_text(&self) -> String {
        let Some((plant, correction)) = &self.plant else {
            return String::new();
        };
        let plant = &plant.name;
        if correction.is_exact {
            // Without a plan nothing was flown there.
            return match self.answer {
                CrossingAnswer::Plan(_) => format!("  {plant} jumps as the planar model says\n"),
                _ => String::new(),
            };
        }
        format!(
            "  {} jumps of {plant} corrected the planar model; its last ones were {} mm off. \
             The numbers below are those of {plant} in the multi-body simulation\n",
            correction.jumps,
            digits(1e3 * correction.miss, 2)
        )
    }

    /// The document.
    pub(super) fn json(&self, robot: &Robot, file: &str) -> String {
        let plan = match self.answer {
            CrossingAnswer::Plan(plan) => Some(plan),
            _ => None,
        };
        let (nearest, jumps) = match self.answer {
            CrossingAnswer::Infeasible { relief, jumps } => (limits::json(&relief.gives), *jumps),
            _ => (Vec::new(), None),
        };
        let complete = match self.answer {
            CrossingAnswer::Plan(plan) => plan.search.complete,
            CrossingAnswer::Infeasible { .. } => !self.interrupted,
            CrossingAnswer::Undecided { .. } => false,
        };
        let checks: Vec<Value> = plan
            .iter()
            .flat_map(|plan| &plan.checks)
            .map(check_json)
            .collect();
        let mut document = json!({
            "command": "plan",
            "robot": robot.name,
            "course": file,
            "status": self.status(robot).0,
            "cost": plan.map(|plan| plan.search.cost),
            "bound": plan.map(|plan| plan.search.bound),
            "complete": complete,
            "interrupted": self.interrupted,
            "obstacles": self.obstacles_json(),
            "jumps": self.table(robot).json(),
            "checks": checks,
            "nearest": nearest,
            "try_jumps": jumps,
        });
        if let Some((plant, correction)) = &self.plant {
            document["plant"] = json!(plant.name);
            document["hold"] = self.hold.as_ref().map_or(Value::Null, Hold::json);
            document["correction"] = json!({
                "simulated_jumps": correction.jumps,
                "miss_m": correction.miss,
                "is_exact": correction.is_exact,
            });
        }
        output::json(&document)
    }

    fn obstacles_json(&self) -> Vec<Value> {
        let obstacles = self.crossing.course.obstacles.iter();
        let json = |it: &Obstacle| {
            json!({
                "front_x_m": it.span().low,
                "width_m": it.width,
                "height_m": it.height,
            })
        };
        obstacles.map(json).collect()
    }

    /// The plan in words.
    pub(super) fn text(&self, robot: &Robot, file: &str) -> String {
        let title = format!(
            "{}: plan for {file}: {}\n",
            robot.name,
            self.status(robot).1
        );
        let hold = self.hold.as_ref();
        let hold = hold.map_or_else(String::new, |hold| hold.text(self.crossing));
        let title = title + &self.correction_text() + &hold;
        let body = match self.answer {
            CrossingAnswer::Plan(plan) => {
                self.table(robot).text()
                    + &self.target_text(plan, robot)
                    + &self.search_text(plan)
                    + &checks_text(plan)
            }
            CrossingAnswer::Infeasible { relief, jumps } => self.infeasible_text(relief, *jumps),
            CrossingAnswer::Undecided { nodes, solves } => format!(
                "  no plan was found in {nodes} steps of the search, with {solves} programs \
                 solved, before {}; that there is none is not proven\n",
                if self.interrupted {
                    "Ctrl-C stopped it"
                } else {
                    "it came to its limit"
                }
            ),
        };
        title + &body
    }

    /// How far the last landing is from the target.
    fn target_text(&self, plan: &Plan, robot: &Robot) -> String {
        let Some(last) = plan.jumps.last() else {
            return String::new();
        };
        let (landing, target, goal) = (
            last.landing[0],
            self.crossing.target,
            self.crossing.course.goal,
        );
        let zone = match allowed(goal).as_str() {
            NO_LIMIT => "no goal zone is given".into(),
            limits => format!("goal: {limits} m"),
        };
        let line = format!(
            "  last landing {} m, {}; {zone}\n",
            measured(landing, 4),
            off_target(landing, target)
        );
        let advice = match self.off_demanded(robot) {
            Some(_) => self.missed_text(plan, robot),
            None => Vec::new(),
        };
        let slip = self.unit_text(landing);
        let advice = advice.into_iter().chain(slip);
        advice.fold(line, |text, sentence| text + &format!("  → {sentence}\n"))
    }

    /// Why a plan does not land on the target that the course demands, and what to do.
    fn missed_text(&self, plan: &Plan, robot: &Robot) -> Vec<String> {
        let (course, target) = (&self.crossing.course, self.crossing.target);
        let Some(last) = plan.jumps.last() else {
            return Vec::new();
        };
        let (low, high) = (last.landing[0].min(target), last.landing[0].max(target));
        let between = |span: &Span| span.low < high && span.high > low;
        let boxes = course.obstacles.iter().map(Obstacle::span);
        let boxes = boxes.zip(1..).filter(|(span, _)| between(span));
        let areas = course.no_landing.iter().zip(1..);
        let areas = areas.filter(|(span, _)| between(span));
        let names: Vec<String> = boxes
            .map(|(_, number)| format!("obstacle {number}"))
            .chain(areas.map(|(_, number)| format!("avoid area {number}")))
            .collect();
        let allowed = 1e3 * Verification::default().tolerance(robot.body.radius);
        let why = if names.is_empty() {
            "No plan lands nearer to the target".to_owned()
        } else {
            format!(
                "Between the landing and the target lies {}",
                names.join(", ")
            )
        };
        let mut all = vec![format!(
            "{why}; the landing must be within {} mm of it, a fifth of the wheel's radius.",
            digits(allowed, 3)
        )];
        let (jumps, start) = (course.jumps as f64, course.start);
        let reach = (last.landing[0] - start) / jumps;
        let more = ((target - start) / reach).ceil();
        if names.is_empty() && more > jumps && more <= MAX_JUMPS as f64 {
            all.push(format!("Try jumps = {more}."));
        }
        all.push(
            "If another place will do, give the goal: the last landing may be anywhere from goal_from_x_m \
             to goal_to_x_m."
                .into(),
        );
        all
    }

    /// Asks for the unit of a target that is ten times as far away as the plan goes, by which a centimetre
    /// differs from a metre.
    fn unit_text(&self, landing: f64) -> Option<String> {
        let way = |place: f64| (place - self.crossing.course.start).abs();
        (way(self.crossing.target) > 10.0 * way(landing)).then(|| {
            "The target is ten times as far away as all jumps go together. Is target_x_m in another unit \
             (target_x_cm, target_x_mm)?"
                .into()
        })
    }

    /// What is known of better plans.
    fn search_text(&self, plan: &Plan) -> String {
        let (cost, bound) = (plan.search.cost, plan.search.bound);
        let cost_text = format!("  cost {}", digits(cost, 4));
        if plan.search.complete {
            return cost_text + "; the search found no plan that is cheaper by more than 0.00005\n";
        }
        let why = if self.interrupted {
            "Ctrl-C stopped the search"
        } else {
            "the search came to its limit"
        };
        format!(
            "{cost_text}; {why}: a plan may be cheaper by up to {}\n",
            digits(cost - bound, 2)
        )
    }

    fn infeasible_text(&self, relief: &Relief, jumps: Option<usize>) -> String {
        let course = &self.crossing.course;
        let nearest = limits::text(&relief.gives, self.crossing);
        let answer = match jumps {
            Some(more) => {
                let few = match course.jumps {
                    1 => "one jump is not enough".into(),
                    count => format!("{count} jumps are not enough"),
                };
                format!("  {few}: {nearest}. Try jumps = {more}.\n")
            }
            None => format!("  the nearest course that has a plan: {nearest}\n"),
        };
        let stopped = if self.interrupted {
            "  Ctrl-C stopped the search: a nearer course may have a plan\n"
        } else {
            ""
        };
        answer + stopped + &self.margins_text()
    }

    /// What landings keep, where that may be why there is no plan.
    fn margins_text(&self) -> String {
        let (sigmas, margin) = (self.crossing.sigmas, self.crossing.edge_margin);
        if sigmas == 0.0 && margin == 0.0 {
            return String::new();
        }
        format!(
            "  each landing keeps {} standard deviations and {} mm from the ends of its ground; \
             margin_sigmas and edge_margin_m in the course can ask for less\n",
            digits(sigmas, 3),
            digits(1e3 * margin, 3)
        )
    }
}

/// How far a landing (m) is from the target (m), in words.
pub(super) fn off_target(landing: f64, target: f64) -> String {
    let off = landing - target;
    if off.abs() < 5e-5 {
        return format!("on the target at {} m", digits(target, 4));
    }
    let side = if off < 0.0 { "short of" } else { "beyond" };
    let off = match off.abs() {
        off @ 1.0.. => format!("{} m", digits(off, 3)),
        off => format!("{:.1} mm", 1e3 * off),
    };
    format!("{off} {side} the target at {} m", digits(target, 4))
}

/// Numbers that are not finite, no limit among them, are null.
fn check_json(check: &Check) -> Value {
    json!({
        "jump": check.jump + 1,
        "what": check.what,
        "value": check.value,
        "least": check.allowed.low,
        "greatest": check.allowed.high,
        "holds": check.holds(),
    })
}

fn checks_text(plan: &Plan) -> String {
    let line = |check: &Check| {
        let sign = if check.holds() { "holds" } else { "FAILS" };
        let (value, allowed) = (measured(check.value, 4), allowed(check.allowed));
        format!(
            "  {sign}  jump {}: {} {value}, {allowed}\n",
            check.jump + 1,
            check.what
        )
    };
    let (hold, fail): (Vec<&Check>, Vec<&Check>) =
        plan.checks.iter().partition(|check| check.holds());
    let mut text: String = fail.iter().copied().map(line).collect();
    if !fail.is_empty() {
        text += "  → Flown ten times finer than in the search, the plan misses this. More \
            clearance_m, edge_margin_m or margin_sigmas, or a smaller friction_coefficient, leaves \
            more room.\n";
    }
    let hold = hold
        .into_iter()
        .filter(|check| allowed(check.allowed) != NO_LIMIT);
    text + &hold.map(line).collect::<String>()
}

fn allowed(span: Span) -> String {
    // What the course leaves open spans all that the planner takes, less what landings keep.
    let limits = |x: f64| x.abs() < 0.99 * ANYWHERE.high;
    match (limits(span.low), limits(span.high)) {
        (true, true) => format!(
            "allowed from {} to {}",
            digits(span.low, 4),
            digits(span.high, 4)
        ),
        (true, false) => format!("allowed from {}", digits(span.low, 4)),
        (false, true) => format!("allowed up to {}", digits(span.high, 4)),
        (false, false) => NO_LIMIT.into(),
    }
}
