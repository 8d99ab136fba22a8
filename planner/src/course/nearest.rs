//! The nearest course that has a plan.
//!
//! For a choice of grounds the course is made elastic: its edges may sink, its grounds may grow and its goal may move, at
//! a price of 1 per metre, while the robot stays what it is. The choice with the least sum is the answer.

use super::choices::landable;
use super::problem::{Choice, Problem};
use super::sqp::{self, Evaluation, Nlp};
use super::terrain::{Ground, Terrain, kept_goal};
use super::{Course, Jumper, Limit, Settings, Span};

/// By how much one limit of a course has to give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Give {
    /// Index of the jump that it limits.
    pub jump: usize,
    /// What it is about. A landing's ends are those of the ground chosen for it.
    pub limit: Limit,
    /// By how much (m); the goal's is signed, positive forward.
    pub amount: f64,
}

/// What a course without a plan would have to give.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Limits in the way, the greatest first: the nearest course is the given one with these moved. Empty if no such
    /// course was found either.
    pub gives: Vec<Give>,
    /// Sum of their magnitudes (m).
    pub total: f64,
    /// The decisions of each jump on the nearest course.
    pub decisions: Vec<[f64; 2]>,
}

/// Most choices of grounds to look at for a course of one jump; a course of more jumps takes as much longer a choice.
const CHOICES: usize = 200;

/// Gives (m) below this are round-off.
const ROUND_OFF: f64 = 1e-7;

/// Finds the choice of grounds that needs the least relief; none where no nearer course was found.
pub(super) fn nearest<J: Jumper>(
    jumper: &J,
    course: &Course,
    settings: &Settings,
) -> (Relief, Option<Choice>) {
    // The goal may have to move forward by as much as the course is long.
    let longer = Span::new(course.goal.low, course.goal.high + (course.goal.high - course.start).abs() + 1.0);
    let terrain = Terrain::new(&Course { goal: longer, ..course.clone() }, jumper);
    let goal = kept_goal(course.goal, jumper.zone_margin());
    let mut best = Relief { gives: Vec::new(), total: f64::INFINITY, decisions: Vec::new() };
    let mut chosen = None;
    for choice in choices(jumper, course, &terrain, CHOICES / course.jumps) {
        let mut problem = Problem::new(jumper, course.start, &choice, settings.sigmas);
        problem.ends_exactly |= course.goal.width() == 0.0;
        let start = Elastic::new(&problem, course, goal).first();
        let solve = |problem: &Problem<'_, J>, x: &[f64]| {
            sqp::solve(&Elastic::new(problem, course, goal), x, &settings.solver)
        };
        let report = problem.settle(&start, &settings.solver, solve);
        let relief = Elastic::new(&problem, course, goal).relief(&report, settings);
        if relief.total < best.total - ROUND_OFF {
            (best, chosen) = (relief, Some(choice));
        }
    }
    (best, chosen)
}

/// At most `most` sequences of grounds, whatever the robot can do.
pub(super) fn choices<J: Jumper>(jumper: &J, course: &Course, terrain: &Terrain, most: usize) -> Vec<Choice> {
    let mut found = Vec::new();
    let mut open: Vec<(&Ground, usize, Choice)> =
        vec![(&terrain.start, 0, Choice { leaps: vec![], windows: vec![], grounds: vec![] })];
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

/// A problem whose course gives: a variable more for each row of the course, and two rows more for the goal.
struct Elastic<'a, J> {
    problem: &'a Problem<'a, J>,
    course: &'a Course,
    /// Where the last jump has to land (m).
    goal: Span,
    rows: Vec<(usize, Limit)>,
    /// Rows that give, the goal's two behind all others.
    soft: Vec<usize>,
    start: Vec<f64>,
}

impl<'a, J: Jumper> Elastic<'a, J> {
    fn new(problem: &'a Problem<'a, J>, course: &'a Course, goal: Span) -> Self {
        let start = evenly(problem, course);
        let rows = problem.rows(&start);
        let last = course.jumps - 1;
        let gives = |row: &usize| match rows[*row] {
            (_, Limit::Edge { .. } | Limit::Stance { .. }) => true,
            (jump, Limit::Landing(_)) => jump < last,
            _ => false,
        };
        let soft = (0..rows.len()).filter(gives).chain([rows.len(), rows.len() + 1]).collect();
        Elastic { problem, course, goal, rows, soft, start }
    }

    /// Where the solver starts: nothing gives.
    fn first(&self) -> Vec<f64> {
        let mut x = self.start.clone();
        x.resize(x.len() + self.soft.len(), 0.0);
        x
    }

    fn relief(&self, report: &sqp::Report, settings: &Settings) -> Relief {
        let n = self.start.len();
        if report.violation > ROUND_OFF.max(settings.solver.feasibility) {
            return Relief { gives: Vec::new(), total: f64::INFINITY, decisions: Vec::new() };
        }
        let give = |(&row, &amount): (&usize, &f64)| {
            let forward = if row == self.rows.len() { -1.0 } else { 1.0 };
            let goal = Give { jump: self.course.jumps - 1, limit: Limit::Goal, amount: forward * amount };
            self.rows.get(row).map_or(goal, |&(jump, limit)| Give { jump, limit, amount })
        };
        let mut gives: Vec<Give> = self.soft.iter().zip(&report.x[n..]).map(give).collect();
        gives.retain(|g| g.amount.abs() > ROUND_OFF.max(settings.solver.feasibility));
        gives.sort_by(|a, b| b.amount.abs().total_cmp(&a.amount.abs()));
        let total = gives.iter().map(|g| g.amount.abs()).sum();
        let decisions = report.x[..n].chunks_exact(2).map(|d| [d[0], d[1]]).collect();
        Relief { gives, total, decisions }
    }
}

/// Jumps over even distances, as far as the windows allow.
pub(super) fn evenly<J: Jumper>(problem: &Problem<'_, J>, course: &Course) -> Vec<f64> {
    let goal = problem.jumper.target(course.goal);
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

impl<J: Jumper> Nlp for Elastic<'_, J> {
    fn bounds(&self) -> Vec<Span> {
        let mut bounds = self.problem.bounds();
        let most = 10.0 + (self.course.goal.high - self.course.start).abs();
        bounds.resize(self.start.len() + self.soft.len(), Span::new(0.0, most));
        bounds
    }

    fn equalities(&self) -> usize {
        0
    }

    fn evaluate(&self, x: &[f64], at: &mut Evaluation) {
        let n = self.start.len();
        let mut hard = Evaluation::default();
        self.problem.evaluate(&x[..n], &mut hard);
        // The last two rows are the landing's distances from the ends of its ground; the goal's differ by constants.
        let (window, goal, m) =
            (self.problem.choice.windows[self.course.jumps - 1], self.goal, hard.values.len());
        hard.values.extend([
            hard.values[m - 2] + window.low - goal.low,
            hard.values[m - 1] + goal.high - window.high,
        ]);
        hard.jacobian.extend_from_within((m - 2) * n..);
        let size = x.len();
        at.cost = if hard.cost.is_finite() { x[n..].iter().sum() } else { f64::NAN };
        at.gradient = (0..size).map(|i| if i < n { 0.0 } else { 1.0 }).collect();
        at.values = hard.values;
        at.jacobian.clear();
        for row in hard.jacobian.chunks_exact(n) {
            at.jacobian.extend_from_slice(row);
            at.jacobian.resize(at.jacobian.len() + size - n, 0.0);
        }
        for (i, &row) in self.soft.iter().enumerate() {
            at.values[row] += x[n + i];
            at.jacobian[row * size + n + i] = 1.0;
        }
    }
}
