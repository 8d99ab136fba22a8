//! Which jump lands where: best-first branch and bound.
//!
//! A node is a choice of grounds with, for each jump, a window for its landing and a span for its distance. Its bound is
//! the least sum of the jumps' envelopes, which ignores what envelopes cannot see. Where the footholds of that bound,
//! with the jumps that reach them best, already cost no more than the bound, the node is done; otherwise the jump that
//! costs most above its envelope has its window or its distance split in two. The node with the least bound is always
//! next, so what is left when the search ends cannot be better than its answer by more than the gap.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::choices::{choices, roll};
use super::envelope::CostToCome;
use super::nearest::{Relief, nearest};
use super::problem::{Choice, Problem};
use super::terrain::Terrain;
use super::{Course, CourseError, Envelope, Jumper, Leap, Span, sqp};

/// How a course is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Standard deviations that each landing keeps from the ends of its ground; 0 is none.
    pub sigmas: f64,
    /// By how much the cost may exceed the least one.
    pub gap: f64,
    /// Width (m) of windows and distances below which they are not split but left to the solver. Infinite: one solution
    /// for each choice of grounds, right where the program of a choice has one local optimum.
    pub resolution: f64,
    /// Most nodes to look at.
    pub nodes: usize,
    /// How each program is solved.
    pub solver: sqp::Settings,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings { sigmas: 0.0, gap: 5e-5, resolution: 1e-7, nodes: 500, solver: sqp::Settings::default() }
    }
}

/// One jump of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// Between which grounds, over which edges.
    pub leap: Leap,
    /// Foothold (m).
    pub foot: f64,
    /// Landing (m).
    pub landing: f64,
    /// The jumper's decisions.
    pub decisions: [f64; 2],
    /// Standard deviation of the landing (m).
    pub deviation: f64,
}

/// Jumps that cross the course.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// In their order.
    pub jumps: Vec<Jump>,
    /// Sum of the jumps' costs.
    pub cost: f64,
    /// No plan costs less than this; infinite resolution: no choice's relaxation does.
    pub bound: f64,
    /// Nodes looked at.
    pub nodes: usize,
    /// Programs solved by SQP, beside the last.
    pub solves: usize,
    /// Whether the search ran to its end, so that `bound` is within the gap of `cost`, and not into its limit of nodes.
    pub complete: bool,
    /// The solver's last word on the choice.
    pub report: sqp::Report,
}

/// What planning a course comes to.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer {
    /// A plan.
    Plan(Plan),
    /// There is none: what blocks, and how the nearest course that has one differs.
    Infeasible(Relief),
    /// None was found within the limit of nodes.
    Undecided {
        /// Nodes looked at.
        nodes: usize,
    },
}

/// Plans a course.
///
/// # Errors
/// [`CourseError`] if the course holds a value that is not allowed.
pub fn plan<J: Jumper>(jumper: &J, course: &Course, settings: &Settings) -> Result<Answer, CourseError> {
    course.check()?;
    let terrain = Terrain::new(course, jumper.edge_margin());
    let choices = choices(jumper, course, &terrain);
    let mut search = Search {
        jumper,
        course,
        settings,
        choices: &choices,
        best: None,
        nodes: 0,
        solves: 0,
        serial: 0,
        tries: 0,
        open: BinaryHeap::new(),
    };
    let bound = search.run();
    let (nodes, complete) = (search.nodes, search.open.is_empty() || search.nodes < settings.nodes);
    if search.best.is_none() && complete {
        let relief = nearest(jumper, course, settings);
        if relief.total > 0.0 || relief.decisions.is_empty() {
            return Ok(Answer::Infeasible(relief));
        }
        // Nothing has to give: the solver did not find its way from where it started, but does from there.
        for choice in 0..choices.len() {
            search.solve(choice, relief.decisions.as_flattened(), &settings.solver);
        }
        if search.best.is_none() {
            return Ok(Answer::Infeasible(relief));
        }
    }
    Ok(match &search.best {
        Some(best) => Answer::Plan(search.finish(best, bound.min(best.cost), complete)),
        None => Answer::Undecided { nodes },
    })
}

/// The solver looks for better footholds after this many nodes, this many squared, and so on.
const SOLVE_BASE: usize = 16;

/// Quadratic programs that are spent on one such attempt.
const SEARCH_ITERATIONS: usize = 8;

/// First trust region of such an attempt: the relaxed footholds are near, and few rows matter within it.
const SEARCH_RADIUS: f64 = 0.03;

/// What a jump that cannot be made counts for above its envelope (in units of the cost), to weigh it against others.
const INFEASIBLE_EXCESS: f64 = 0.1;

/// Part of a choice.
struct Node {
    choice: usize,
    /// Where each jump lands (m).
    windows: Vec<Span>,
    /// How far each jump goes (m).
    reach: Vec<Span>,
    /// No plan in this node costs less.
    bound: f64,
    /// The jumps' envelopes.
    bounded: Vec<Bounded>,
    /// Landings (m) of the bound, and what each jump costs in it.
    relaxed: Vec<[f64; 2]>,
    /// Order of creation, so that equal bounds are looked at in a fixed order.
    serial: usize,
}

/// A jump's envelope and what it holds for.
#[derive(Clone, Copy)]
struct Bounded {
    feet: Span,
    window: Span,
    envelope: Envelope,
}

impl PartialEq for Node {
    fn eq(&self, other: &Node) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Node {}
impl PartialOrd for Node {
    fn partial_cmp(&self, other: &Node) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Node {
    /// The greatest is the next one to look at.
    fn cmp(&self, other: &Node) -> Ordering {
        other.bound.total_cmp(&self.bound).then(other.serial.cmp(&self.serial))
    }
}

/// The best decisions so far.
#[derive(Clone)]
struct Best {
    choice: usize,
    decisions: Vec<f64>,
    cost: f64,
    /// The solver's, where it has already had the last word on these.
    report: Option<sqp::Report>,
}

struct Search<'a, J> {
    jumper: &'a J,
    course: &'a Course,
    settings: &'a Settings,
    choices: &'a [Choice],
    best: Option<Best>,
    nodes: usize,
    solves: usize,
    serial: usize,
    /// Nodes that had to be split.
    tries: usize,
    open: BinaryHeap<Node>,
}

impl<J: Jumper> Search<'_, J> {
    /// Looks at nodes until none can be better; the bound on what is left.
    fn run(&mut self) -> f64 {
        for (choice, Choice { windows, .. }) in self.choices.iter().enumerate() {
            self.add(choice, windows.clone(), vec![Span::ALL; windows.len()], &[]);
        }
        while let Some(node) = self.open.pop() {
            if self.nodes >= self.settings.nodes || node.bound >= self.worth() {
                let bound = node.bound;
                if node.bound < self.worth() {
                    self.open.push(node);
                }
                return bound;
            }
            self.nodes += 1;
            self.look_at(&node);
        }
        f64::INFINITY
    }

    /// A cost that is worth finding is below this.
    fn worth(&self) -> f64 {
        self.best.as_ref().map_or(f64::INFINITY, |b| b.cost - self.settings.gap)
    }

    fn problem(&self, choice: usize) -> Problem<'_, J> {
        let (start, sigmas) = (self.course.start, self.settings.sigmas);
        Problem { jumper: self.jumper, start, choice: &self.choices[choice], sigmas }
    }

    /// Tries the node's relaxed footholds, then splits it, or solves it where it is too small to be split.
    fn look_at(&mut self, node: &Node) {
        let trial = self.aim(node);
        if trial.cost.is_finite() {
            let decisions = trial.decisions.clone();
            self.offer(Best { choice: node.choice, decisions, cost: trial.cost, report: None });
        }
        if node.bound >= self.worth() {
            return;
        }
        self.tries += 1;
        if !self.split(node, &trial) {
            self.solve(node.choice, &trial.decisions, &self.settings.solver);
        } else if is_power(self.tries, SOLVE_BASE) {
            let quick = sqp::Settings {
                iterations: SEARCH_ITERATIONS,
                radius: SEARCH_RADIUS,
                ..self.settings.solver
            };
            self.solve(node.choice, &trial.decisions, &quick);
        }
    }

    /// Looks for a local optimum of a choice.
    fn solve(&mut self, choice: usize, decisions: &[f64], solver: &sqp::Settings) {
        self.solves += 1;
        let report = sqp::solve(&self.problem(choice), decisions, solver);
        if report.violation <= self.settings.solver.feasibility {
            let is_final = report.status == sqp::Status::Converged && *solver == self.settings.solver;
            let (decisions, cost) = (report.x.clone(), report.cost);
            self.offer(Best { choice, decisions, cost, report: is_final.then_some(report) });
        }
    }

    fn offer(&mut self, candidate: Best) {
        if self.best.as_ref().is_none_or(|b| candidate.cost < b.cost) {
            self.best = Some(candidate);
        }
    }

    /// The best jumps between the relaxed footholds.
    fn aim(&self, node: &Node) -> Trial {
        let problem = self.problem(node.choice);
        let mut trial = Trial { decisions: Vec::new(), excess: Vec::new(), cost: 0.0 };
        let (mut margins, mut landing) = (Vec::with_capacity(16), self.course.start);
        for (jump, [target, floor]) in node.relaxed.iter().enumerate() {
            let foot = problem.foothold(jump, landing);
            let decisions = self.jumper.aim(&self.choices[node.choice].leaps[jump], foot, *target);
            let flight = problem.fly(jump, foot, decisions, &mut margins);
            let tolerance = self.settings.solver.feasibility;
            let bounds = self.jumper.decisions(jump);
            let allowed = (0..2).all(|i| bounds[i].clamp(decisions[i]) == decisions[i])
                && (flight.landing.value - target).abs() <= tolerance
                && margins.iter().all(|m| m.value.value >= -tolerance);
            let cost = if allowed { flight.cost.value } else { f64::INFINITY };
            trial.excess.push(cost - floor);
            trial.cost += cost;
            trial.decisions.extend(decisions);
            landing = *target;
        }
        trial
    }

    /// Halves a window or a distance, the one with the greatest width times excess of a jump that depends on it; false if
    /// all of that is narrow.
    fn split(&mut self, node: &Node, trial: &Trial) -> bool {
        let choice = &self.choices[node.choice];
        let mut widest = (0.0, None);
        let mut consider = |span: Span, weight: f64, part: Part| {
            let weight = span.width() * weight;
            if span.width() > self.settings.resolution && weight > widest.0 {
                widest = (weight, Some((span, part)));
            }
        };
        let mut before = Span::point(self.course.start);
        for (jump, leap) in choice.leaps.iter().enumerate() {
            // An infeasible jump counts as a dear one.
            let excess = trial.excess[jump].min(INFEASIBLE_EXCESS);
            if excess > 0.1 * self.settings.gap {
                consider(node.reach[jump], 0.5 * excess, Part::Distance(jump));
                if !leap.edges.is_empty() {
                    consider(node.windows[jump], excess, Part::Landing(jump));
                    consider(before, excess, Part::Landing(jump.wrapping_sub(1)));
                }
            }
            before = node.windows[jump];
        }
        let Some((span, part)) = widest.1 else { return false };
        let at = f64::midpoint(span.low, span.high);
        for half in [Span::new(span.low, at), Span::new(at, span.high)] {
            let (mut windows, mut reach) = (node.windows.clone(), node.reach.clone());
            match part {
                Part::Distance(jump) => reach[jump] = half,
                Part::Landing(jump) => windows[jump] = half,
            }
            self.add(node.choice, windows, reach, &node.bounded);
        }
        true
    }

    /// Adds the part of a choice within windows and distances, unless its bound says that it is not worth it. What is
    /// `known` of the jumps' envelopes is used again where it holds.
    fn add(&mut self, choice: usize, mut windows: Vec<Span>, mut reach: Vec<Span>, known: &[Bounded]) {
        let Some(bounded) = self.bound(&self.choices[choice], &mut windows, &mut reach, known) else {
            return;
        };
        let Some((bound, relaxed)) = self.relax(&bounded) else { return };
        if bound < self.worth() {
            let serial = self.serial;
            self.serial += 1;
            self.open.push(Node { choice, windows, reach, bound, bounded, relaxed, serial });
        }
    }

    /// Narrows windows and distances to what the jumps can do, and bounds each jump's cost.
    fn bound(
        &self,
        choice: &Choice,
        windows: &mut [Span],
        reach: &mut [Span],
        known: &[Bounded],
    ) -> Option<Vec<Bounded>> {
        for jump in (1..windows.len()).rev() {
            let shift = Span::point(roll(self.jumper, jump));
            windows[jump - 1] = windows[jump - 1].meet(windows[jump] - reach[jump] - shift);
        }
        let mut bounded = Vec::with_capacity(windows.len());
        let mut landing = Span::point(self.course.start);
        for (jump, leap) in choice.leaps.iter().enumerate() {
            let feet = landing + Span::point(roll(self.jumper, jump));
            let holds = |b: &&Bounded| {
                b.feet == feet && b.window == windows[jump] && b.envelope.reach() == reach[jump]
            };
            let envelope = match known.get(jump).filter(holds) {
                Some(known) => known.envelope,
                None => self.jumper.envelope(leap, feet, windows[jump], reach[jump])?,
            };
            reach[jump] = envelope.reach();
            windows[jump] = windows[jump].meet(feet + reach[jump]);
            landing = windows[jump];
            bounded.push(Bounded { feet, window: landing, envelope });
        }
        Some(bounded)
    }

    /// The least sum of the envelopes, with the landings where it is and each jump's part of it.
    fn relax(&self, bounded: &[Bounded]) -> Option<(f64, Vec<[f64; 2]>)> {
        let mut chain = Vec::with_capacity(bounded.len());
        let mut come = CostToCome::start(self.course.start);
        for (jump, b) in bounded.iter().enumerate() {
            let next = come.jump(roll(self.jumper, jump), &b.envelope, b.window)?;
            chain.push(std::mem::replace(&mut come, next));
        }
        let [mut landing, bound] = come.least();
        let mut relaxed = vec![[0.0; 2]; bounded.len()];
        for (jump, come) in chain.iter().enumerate().rev() {
            let (shift, envelope) = (roll(self.jumper, jump), &bounded[jump].envelope);
            let from = come.origin(shift, envelope, landing);
            relaxed[jump] = [landing, envelope.at(landing - from - shift)];
            landing = from;
        }
        Some((bound, relaxed))
    }

    /// Lets the solver have the last word on the best decisions.
    fn finish(&self, best: &Best, bound: f64, complete: bool) -> Plan {
        let problem = self.problem(best.choice);
        let solve = || sqp::solve(&problem, &best.decisions, &self.settings.solver);
        let mut report = best.report.clone().unwrap_or_else(solve);
        if report.violation > self.settings.solver.feasibility || report.cost > best.cost {
            report.x.clone_from(&best.decisions);
            report.cost = best.cost;
        }
        let (mut jumps, mut margins, mut landing) = (Vec::new(), Vec::new(), self.course.start);
        for (jump, leap) in self.choices[best.choice].leaps.iter().enumerate() {
            let foot = problem.foothold(jump, landing);
            let decisions = [report.x[2 * jump], report.x[2 * jump + 1]];
            let flight = problem.fly(jump, foot, decisions, &mut margins);
            landing = flight.landing.value;
            jumps.push(Jump {
                leap: leap.clone(),
                foot,
                landing,
                decisions,
                deviation: flight.deviation.value,
            });
        }
        Plan {
            jumps,
            cost: report.cost,
            bound: bound.min(report.cost),
            nodes: self.nodes,
            solves: self.solves,
            complete,
            report,
        }
    }
}

/// Whether `n` is a power of `base`, the first one or higher.
fn is_power(mut n: usize, base: usize) -> bool {
    while n > base && n.is_multiple_of(base) {
        n /= base;
    }
    n == base
}

/// What a split halves.
#[derive(Clone, Copy)]
enum Part {
    /// How far a jump goes.
    Distance(usize),
    /// Where it lands.
    Landing(usize),
}

/// Jumps between given footholds.
struct Trial {
    decisions: Vec<f64>,
    /// What each jump costs above its envelope; infinite where it is not allowed.
    excess: Vec<f64>,
    /// Of all of them; infinite where one is not allowed.
    cost: f64,
}
