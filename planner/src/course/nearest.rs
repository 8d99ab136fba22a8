//! The nearest course that has a plan.
//!
//! For a choice of grounds the course is made elastic: its obstacles may sink, its grounds may grow,
//! its goal may move and its friction may rise, at a price of 1 per metre and per unit of the
//! coefficient, while the robot stays what it is. The choice
//! with the least sum is the answer.

use super::choices::landable;
use super::problem::{Choice, Problem};
use super::sqp::{self, Evaluation, Nlp};
use super::terrain::{Ground, Terrain, kept_goal};
use super::{Course, Jumper, Leap, Limit, Settings, Side, Span};

/// By how much one limit of a course has to give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Give {
    /// Index of the jump that it limits.
    pub jump: usize,
    /// What it is about. A landing's ends are those of the ground chosen for it; of an obstacle it
    /// is the limit that its height violates most.
    pub limit: Limit,
    /// By how much (m; a friction coefficient without unit). An obstacle is lower by it; the goal moves
    /// by it, positive forward; the ground holds better by it.
    pub amount: f64,
    /// Where the jump that it limits may land (m).
    pub ground: Span,
}

/// What a course without a plan would have to give.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Limits in the way, the greatest first: the nearest course is the given one with these moved.
    /// Empty if no such course was found either.
    pub gives: Vec<Give>,
    /// Sum of their magnitudes (m).
    pub total: f64,
    /// The decisions of each jump on the nearest course.
    pub decisions: Vec<[f64; 2]>,
}

impl Relief {
    /// No nearer course was found.
    fn none() -> Relief {
        Relief {
            gives: Vec::new(),
            total: f64::INFINITY,
            decisions: Vec::new(),
        }
    }
}

/// Most choices of grounds to look at for a course of one jump; a course of more jumps takes as
/// much longer a choice.
const CHOICES: usize = 200;

/// The limit of the ground's friction, which gives as well.
pub const FRICTION: Limit = Limit::Robot("friction");

/// Gives (m) below this are round-off.
const ROUND_OFF: f64 = 1e-7;

/// Finds the choice of grounds that needs the least relief; none where no nearer course was found.
pub(super) fn nearest(
    jumper: &dyn Jumper,
    course: &Course,
    settings: &Settings,
) -> (Relief, Option<Choice>) {
    // The goal may have to move forward by as much as the course is long.
    let longer = Span::new(
        course.goal.low,
        course.goal.high + (course.goal.high - course.start).abs() + 1.0,
    );
    let terrain = Terrain::new(
        &Course {
            goal: longer,
            ..course.clone()
        },
        jumper,
    );
    let goal = kept_goal(course.goal, jumper.zone_margin());
    let mut best = Relief::none();
    let mut chosen = None;
    for choice in choices(jumper, course, &terrain, CHOICES / course.jumps) {
        let mut is_better = false;
        for decisions in starts(jumper, course, &choice, goal, settings) {
            let pushed = choice.pushed(jumper, &decisions);
            let problem = Problem::new(jumper, course, &pushed, settings.sigmas);
            let elastic = Elastic::new(&problem, course, goal);
            let report = sqp::solve(&elastic, &elastic.first(decisions), &settings.solver);
            let relief = elastic.relief(&report, settings);
            if relief.total < best.total - ROUND_OFF {
                (best, is_better) = (relief, true);
            }
        }
        if is_better {
            chosen = Some(choice);
        }
    }
    (best, chosen)
}

/// What the jumps of a relief miss on the course as it is.
pub(super) fn missed(problem: &Problem<'_>, relief: &Relief) -> Relief {
    let decisions = relief.decisions.as_flattened();
    let mut at = Evaluation::default();
    problem.evaluate(decisions, &mut at);
    let give = |((jump, limit), value): ((usize, Limit), &f64)| Give {
        jump,
        limit,
        amount: -value,
        ground: problem.choice.windows[jump],
    };
    let rows = problem.rows(decisions).into_iter().zip(&at.values);
    let gives: Vec<Give> = rows.filter(|(_, value)| **value < 0.0).map(give).collect();
    Relief {
        total: gives.iter().map(|give| give.amount).sum(),
        gives,
        decisions: relief.decisions.clone(),
    }
}

/// The solver's starts. The last jump lands at the target; a single one at both ends of where it may
/// too, and with half the push as well.
fn starts(
    jumper: &dyn Jumper,
    course: &Course,
    choice: &Choice,
    goal: Span,
    settings: &Settings,
) -> Vec<Vec<f64>> {
    let problem = Problem::new(jumper, course, choice, settings.sigmas);
    let mut starts = vec![evenly(&problem, course)];
    if let [window] = choice.windows[..] {
        if course.goal.width() > 0.0 {
            let within = window.meet(goal);
            let window = if within.is_empty() { window } else { within };
            let ends = [window.low, window.high];
            starts.extend(ends.map(|place| evenly_to(&problem, course, Some(place))));
        }
        let half = jumper.decisions(0)[1].low;
        let halved: Vec<_> = starts
            .iter()
            .map(|x| vec![x[0], f64::midpoint(x[1], half)])
            .collect();
        starts.extend(halved);
        let short = |x: &[f64; 2]| short_by(&problem, course, goal, x);
        let spread = jumper.spread(&choice.leaps[0]).into_iter();
        let nearest = spread
            .map(|x| (short(&x), x))
            .filter(|(short, _)| short.is_finite())
            .min_by(|a, b| a.0.total_cmp(&b.0));
        starts.extend(nearest.map(|(_, x)| x.to_vec()));
    }
    starts
}

/// By how much a single jump misses all that gives, together; infinite where it does not land, or not
/// on the ground of its choice.
fn short_by(problem: &Problem<'_>, course: &Course, goal: Span, x: &[f64; 2]) -> f64 {
    let elastic = Elastic::new(problem, course, goal);
    let rows = elastic.rows_of(x, &vec![0.0; elastic.sinking.len()]).values;
    let is_hard = |row: usize| {
        let limit = elastic.rows.get(row).map(|(_, limit)| limit);
        limit.is_some_and(|limit| limit.obstacle().is_none()) && !elastic.soft.contains(&row)
    };
    let miss = |(row, value): (usize, &f64)| match *value {
        value if value >= 0.0 => 0.0,
        value if value.is_nan() || is_hard(row) => f64::INFINITY,
        value => -value,
    };
    rows.iter().enumerate().map(miss).sum()
}

/// At most `most` sequences of grounds, whatever the robot can do.
pub(super) fn choices(
    jumper: &dyn Jumper,
    course: &Course,
    terrain: &Terrain,
    most: usize,
) -> Vec<Choice> {
    let mut found = Vec::new();
    let mut open: Vec<(&Ground, usize, Choice)> = vec![(
        &terrain.start,
        0,
        Choice {
            leaps: vec![],
            windows: vec![],
            grounds: vec![],
        },
    )];
    while let Some((from, first, choice)) = open.pop() {
        let jump = choice.leaps.len();
        if jump == course.jumps {
            found.push(choice);
            if found.len() == most {
                break;
            }
            continue;
        }
        for (index, ground) in terrain.grounds.iter().enumerate().skip(first) {
            let window = landable(jumper, course, jump, ground);
            if window.is_empty() {
                continue;
            }
            let mut choice = choice.clone();
            choice.leaps.push(terrain.leap(jump, from, ground));
            choice.windows.push(window);
            choice.grounds.push(index);
            open.push((ground, index, choice));
        }
    }
    found
}

/// A problem whose course gives: two rows more for the goal, and a variable more for each row that
/// gives and for each obstacle.
struct Elastic<'a> {
    problem: &'a Problem<'a>,
    course: &'a Course,
    /// Where the last jump has to land (m).
    goal: Span,
    rows: Vec<(usize, Limit)>,
    /// Rows that give, the goal's two behind all others.
    soft: Vec<usize>,
    /// Obstacles in the jumps' way, which may sink.
    sinking: Vec<usize>,
    /// Decisions.
    decisions: usize,
}

/// Times that the depths of a start are mended.
const SINKINGS: usize = 6;

/// Step (m) by which an obstacle sinks for the difference that stands for a derivative.
const SINKING: f64 = 1e-7;

impl<'a> Elastic<'a> {
    fn new(problem: &'a Problem<'a>, course: &'a Course, goal: Span) -> Self {
        let start = evenly(problem, course);
        let rows = problem.rows(&start);
        let last = course.jumps - 1;
        let gives = |row: &usize| match rows[*row] {
            (jump, Limit::Landing(_)) => jump < last,
            (_, limit) => limit == FRICTION,
        };
        let soft = (0..rows.len())
            .filter(gives)
            .chain([rows.len(), rows.len() + 1])
            .collect();
        let in_the_way = |o: &usize| problem.choice.leaps.iter().any(|leap| concerns(leap, *o));
        let sinking = (0..course.obstacles.len()).filter(in_the_way).collect();
        Elastic {
            problem,
            course,
            goal,
            rows,
            soft,
            sinking,
            decisions: start.len(),
        }
    }

    /// Where the obstacles' depths begin among the variables.
    fn depths_from(&self) -> usize {
        self.decisions + self.soft.len()
    }

    /// The choice's leaps with the obstacles sunk by `depths` (m).
    fn sunk(&self, depths: &[f64]) -> Choice {
        let depth = |obstacle: usize| {
            self.sinking
                .iter()
                .position(|o| *o == obstacle)
                .map_or(0.0, |position| depths[position])
        };
        let mut choice = self.problem.choice.clone();
        for leap in &mut choice.leaps {
            leap.from -= leap.on[0].map_or(0.0, depth);
            leap.to -= leap.on[1].map_or(0.0, depth);
            for edge in leap.edges.iter_mut().chain(&mut leap.beside) {
                edge.top -= depth(edge.obstacle);
            }
        }
        choice
    }

    /// Cost and rows, with derivatives by the decisions, where the obstacles are sunk by `depths`
    /// (m).
    fn rows_of(&self, decisions: &[f64], depths: &[f64]) -> Evaluation {
        let mut at = Evaluation::default();
        self.problem
            .over(&self.sunk(depths))
            .evaluate(decisions, &mut at);
        // The last two rows are the landing's distances from the ends of its ground; the goal's
        // differ by constants.
        let (window, m) = (
            self.problem.choice.windows[self.course.jumps - 1],
            at.values.len(),
        );
        at.values.extend([
            at.values[m - 2] + window.low - self.goal.low,
            at.values[m - 1] + self.goal.high - window.high,
        ]);
        at.jacobian.extend_from_within((m - 2) * decisions.len()..);
        at
    }

    /// Where the solver starts from the decisions `x`: all gives as far as these jumps ask for.
    fn first(&self, mut x: Vec<f64>) -> Vec<f64> {
        let mut depths = vec![0.0; self.sinking.len()];
        // A box that is lower by what misses is nearly low enough.
        for _ in 0..SINKINGS {
            let values = self.rows_of(&x, &depths).values;
            for (depth, obstacle) in depths.iter_mut().zip(&self.sinking) {
                let its_own = self.rows.iter().zip(&values);
                let its_own = its_own.filter(|row| row.0.1.obstacle() == Some(*obstacle));
                let least = its_own.map(|row| *row.1).fold(0.0, f64::min);
                let most = self.course.obstacles[*obstacle].height;
                *depth = (*depth - least).min(most);
            }
        }
        let values = self.rows_of(&x, &depths).values;
        x.extend(self.soft.iter().map(|row| (-values[*row]).max(0.0)));
        x.extend(depths);
        x
    }

    fn relief(&self, report: &sqp::Report, settings: &Settings) -> Relief {
        let n = self.decisions;
        if report.violation > ROUND_OFF.max(settings.solver.feasibility) {
            return Relief::none();
        }
        let ground = |jump: usize| self.problem.choice.windows[jump];
        let give = |(&row, &amount): (&usize, &f64)| {
            let forward = if row == self.rows.len() { -1.0 } else { 1.0 };
            let goal = Give {
                jump: self.course.jumps - 1,
                limit: Limit::Goal,
                amount: forward * amount,
                ground: ground(self.course.jumps - 1),
            };
            self.rows.get(row).map_or(goal, |&(jump, limit)| Give {
                jump,
                limit,
                amount,
                ground: ground(jump),
            })
        };
        let (depths, level) = (
            &report.x[self.depths_from()..],
            vec![0.0; self.sinking.len()],
        );
        let blocked = self.rows_of(&report.x[..n], &level).values;
        let sink = |(&obstacle, &amount): (&usize, &f64)| {
            let is_its_own = |row: &(&(usize, Limit), &f64)| row.0.1.obstacle() == Some(obstacle);
            let rows = self.rows.iter().zip(&blocked).filter(is_its_own);
            let worst = rows.min_by(|a, b| a.1.total_cmp(b.1)).map(|(row, _)| *row);
            let (jump, limit) = worst.unwrap_or((
                0,
                Limit::Edge {
                    obstacle,
                    side: Side::Front,
                },
            ));
            Give {
                jump,
                limit,
                amount,
                ground: ground(jump),
            }
        };
        let sinks = self.sinking.iter().zip(depths).map(sink);
        let mut gives: Vec<Give> = self
            .soft
            .iter()
            .zip(&report.x[n..])
            .map(give)
            .chain(sinks)
            .collect();
        gives.retain(|g| g.amount.abs() > ROUND_OFF.max(settings.solver.feasibility));
        gives.sort_by(|a, b| b.amount.abs().total_cmp(&a.amount.abs()));
        let total = gives.iter().map(|g| g.amount.abs()).sum();
        let decisions = report.x[..n]
            .chunks_exact(2)
            .map(|d| [d[0], d[1]])
            .collect();
        Relief {
            gives,
            total,
            decisions,
        }
    }
}

/// Jumps over even distances to the target, as far as the windows allow.
pub(super) fn evenly(problem: &Problem<'_>, course: &Course) -> Vec<f64> {
    evenly_to(problem, course, None)
}

/// The same to a place (m); none: to the target.
fn evenly_to(problem: &Problem<'_>, course: &Course, place: Option<f64>) -> Vec<f64> {
    let goal = place.unwrap_or_else(|| problem.jumper.target(course.goal));
    let mut landing = course.start;
    let mut decisions = Vec::new();
    for (jump, leap) in problem.choice.leaps.iter().enumerate() {
        let part = (jump + 1) as f64 / course.jumps as f64;
        let foot = problem.foothold(jump, landing);
        landing = problem.choice.windows[jump].clamp(course.start + part * (goal - course.start));
        let bounds = problem.jumper.decisions(jump);
        let aim = problem.jumper.aim(leap, foot, landing);
        decisions.extend([bounds[0].clamp(aim[0]), bounds[1].clamp(aim[1])]);
    }
    decisions
}

impl Nlp for Elastic<'_> {
    fn bounds(&self) -> Vec<Span> {
        let mut bounds = self.problem.bounds();
        let most = 10.0 + (self.course.goal.high - self.course.start).abs();
        bounds.resize(self.depths_from(), Span::new(0.0, most));
        bounds.extend(
            self.sinking
                .iter()
                .map(|o| Span::new(0.0, self.course.obstacles[*o].height)),
        );
        bounds
    }

    fn equalities(&self) -> usize {
        0
    }

    fn evaluate(&self, x: &[f64], at: &mut Evaluation) {
        let (n, size, first) = (self.decisions, x.len(), self.depths_from());
        let depths = &x[first..];
        let hard = self.rows_of(&x[..n], depths);
        at.cost = if hard.cost.is_finite() {
            x[n..].iter().sum()
        } else {
            f64::NAN
        };
        at.gradient = (0..size).map(|i| if i < n { 0.0 } else { 1.0 }).collect();
        at.jacobian.clear();
        for row in hard.jacobian.chunks_exact(n) {
            at.jacobian.extend_from_slice(row);
            at.jacobian.resize(at.jacobian.len() + size - n, 0.0);
        }
        at.values = hard.values;
        for i in 0..depths.len() {
            let mut deeper = depths.to_vec();
            deeper[i] += SINKING;
            let there = self.rows_of(&x[..n], &deeper);
            for (row, (here, there)) in at.values.iter().zip(&there.values).enumerate() {
                at.jacobian[row * size + first + i] = (there - here) / SINKING;
            }
        }
        for (i, &row) in self.soft.iter().enumerate() {
            at.values[row] += x[n + i];
            at.jacobian[row * size + n + i] = 1.0;
        }
    }
}

/// Whether an obstacle is in the way of a jump, beside it or under it.
fn concerns(leap: &Leap, obstacle: usize) -> bool {
    leap.on.contains(&Some(obstacle))
        || leap
            .edges
            .iter()
            .chain(&leap.beside)
            .any(|e| e.obstacle == obstacle)
}
