//! Which jump lands where: best-first branch and bound.
//!
//! Sequences of grounds are grown jump by jump, always the one with the least bound (see
//! [`choices`](super::choices)); one that is taken up is grown to its end along its best links, so
//! that there is soon a plan to be better than. Once every jump has its ground, it is a node.
//!
//! Of a jumper that makes sketches the first plan is the cheapest way over a lattice of footholds
//! (see [`lattice`](super::lattice)), and so is the solver's start in each node. A node is given up
//! where its lattice has no way, or one that is far dearer than the cheapest: as the jumper's
//! bounds, the lattice sees what is sampled.
//!
//! A node is a choice of grounds with, for each jump, a window for its landing and a span for its
//! distance. Its bound is the least sum of the jumps' envelopes, which ignores what envelopes
//! cannot see. Where the footholds of that bound, with the jumps that reach them best, already cost
//! no more than the bound, the node is done; otherwise the jump that costs most above its envelope
//! has its window or its distance split in two. The node with the least bound is always next, so
//! what is left when the search ends cannot be better than its answer by more than the gap. A
//! search that stops at a limit, or is told to, says what bound is left.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::ops::ControlFlow;

use super::choices::Place;
use super::choices::{Choices, Prefix, roll};
use super::envelope::CostToCome;
use super::lattice::{self, Way};
use super::nearest::{Relief, evenly, missed, nearest};
use super::problem::{Choice, Problem};
use super::terrain::Terrain;
use super::{Course, CourseError, Envelope, Jumper, Leap, Push, Span, sqp};

/// What watches a search: it is told how far the search is, and may stop it.
pub type Watch<'a> = dyn Fn(&Standing) -> ControlFlow<()> + 'a;

/// How a course is planned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Standard deviations that each landing keeps from the ends of its ground; 0 is none.
    pub sigmas: f64,
    /// By how much the cost may exceed the least one.
    pub gap: f64,
    /// Width (m) of windows and distances below which they are not split but left to the solver.
    /// Infinite: one solution for each choice of grounds, right where the program of a choice has
    /// one local optimum.
    pub resolution: f64,
    /// Most nodes to look at.
    pub nodes: usize,
    /// Most programs to solve, in jumps: one of 12 jumps counts for 12.
    pub work: usize,
    /// How each program is solved.
    pub solver: sqp::Settings,
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            sigmas: 0.0,
            gap: 5e-5,
            resolution: 1e-7,
            nodes: 1000,
            work: 10_000,
            solver: sqp::Settings::default(),
        }
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
    /// No plan costs less than this, as far as the jumper's envelopes and sketches see; infinite
    /// resolution: no choice's relaxation does.
    pub bound: f64,
    /// Nodes looked at.
    pub nodes: usize,
    /// Programs solved by SQP, beside the last.
    pub solves: usize,
    /// Whether the search ran to its end, so that `bound` is within the gap of `cost`, and not into
    /// its limit of nodes.
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
    /// None was found before the search came to a limit or was stopped.
    Undecided {
        /// Nodes looked at.
        nodes: usize,
        /// Programs solved.
        solves: usize,
    },
}

/// How far a search is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Standing {
    /// Share of the search's limits that is used up, 0 to 1; most searches end long before 1.
    pub share: f64,
    /// By how much the best plan so far may exceed the least cost; infinite without a plan.
    pub gap: f64,
}

/// Plans a course.
///
/// # Errors
/// [`CourseError`] if the course holds a value that is not allowed.
pub fn plan(
    jumper: &dyn Jumper,
    course: &Course,
    settings: &Settings,
) -> Result<Answer, CourseError> {
    plan_watched(jumper, course, settings, &|_| ControlFlow::Continue(()))
}

/// As [`plan`], with `watch` told how far the search is; it may stop it, and gets the best answer
/// so far.
///
/// # Errors
/// As [`plan`].
pub fn plan_watched(
    jumper: &dyn Jumper,
    course: &Course,
    settings: &Settings,
    watch: &Watch<'_>,
) -> Result<Answer, CourseError> {
    course.check()?;
    let terrain = Terrain::new(course, jumper);
    let choices = Choices::new(jumper, course, &terrain);
    let mut search = Search {
        jumper,
        course,
        settings,
        watch,
        sequences: &choices,
        choices: Vec::new(),
        best: None,
        nodes: 0,
        solves: 0,
        serial: 0,
        tries: 0,
        open: BinaryHeap::new(),
        cheapest_way: None,
        first: None,
    };
    let End { bound, complete } = search.run();
    if complete {
        search.look_closer();
    }
    if search.best.is_none() && complete {
        let (relief, choice) = nearest(jumper, course, settings);
        let Some(mut choice) = choice.filter(|_| relief.total <= 0.0) else {
            return Ok(Answer::Infeasible(relief));
        };
        // Nothing has to give: the solver did not find its way from where it started, but is there
        // already.
        if let Some(last) = choice.windows.last_mut() {
            *last = last.meet(terrain.goal);
        }
        search.choices.push(choice);
        let (choice, decisions) = (search.choices.len() - 1, relief.decisions.as_flattened());
        let as_it_is = sqp::Settings {
            iterations: 0,
            ..settings.solver
        };
        let found = search.solve(choice, decisions, &settings.solver)
            || search.solve(choice, decisions, &as_it_is);
        return Ok(match &search.best {
            Some(best) if found => {
                let bound = choices
                    .start()
                    .map_or(best.cost, |start| start.bound.min(best.cost));
                Answer::Plan(search.finish(best, bound, false))
            }
            _ => {
                let choice = search.choices[choice].pushed(jumper, decisions);
                Answer::Infeasible(missed(&search.problem(&choice), &relief))
            }
        });
    }
    Ok(match &search.best {
        Some(best) => Answer::Plan(search.finish(best, bound.min(best.cost), complete)),
        None => search.undecided(),
    })
}

/// The solver looks for better footholds after this many nodes, this many squared, and so on.
const SOLVE_BASE: usize = 16;

/// Quadratic programs that are spent on one such attempt.
const SEARCH_ITERATIONS: usize = 8;

/// First trust region of such an attempt: the relaxed footholds are near, and few rows matter
/// within it.
const SEARCH_RADIUS: f64 = 0.03;

/// Around the landings (m) of the best plan, and how far apart (m), a fine lattice is laid in the end.
const NEAR: f64 = 0.1;
const FINE: f64 = 0.005;

/// Most times that this is done, as each may find a better plan.
const CLOSER_LOOKS: usize = 4;

/// Up to so many jumps each choice is solved from several ways over the lattice, as it may have several
/// local optima.
const THOROUGH: usize = 4;

/// Choices whose cheapest way over the lattice costs more than so many times the cheapest one of
/// all are not solved; a lattice misses the cost of its best plan by about [`LATTICE_ERROR`] and by
/// a small part of it.
const DEAR: f64 = 2.0;
const LATTICE_ERROR: f64 = 1e-3;

/// What a jump that cannot be made counts for above its envelope (in units of the cost), to weigh
/// it against others.
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
}

/// A jump's envelope and what it holds for.
#[derive(Clone, Copy)]
struct Bounded {
    feet: Span,
    window: Span,
    envelope: Envelope,
}

/// What the search has still to look at.
struct Open {
    /// Nothing in it costs less.
    bound: f64,
    /// Order of creation.
    serial: usize,
    part: Part,
}

enum Part {
    /// The first jumps of a sequence of grounds.
    Prefix(Prefix),
    /// A part of a choice.
    Node(Node),
}

impl PartialEq for Open {
    fn eq(&self, other: &Open) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Open {}
impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Open) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Open {
    /// The greatest is the next one to look at; of equal ones the first made, so that the order is
    /// fixed.
    fn cmp(&self, other: &Open) -> Ordering {
        other
            .bound
            .total_cmp(&self.bound)
            .then(other.serial.cmp(&self.serial))
    }
}

/// How a search ended.
struct End {
    /// No plan costs less, unless it is the best one.
    bound: f64,
    /// Whether nothing is left that could be better by more than the gap.
    complete: bool,
}

/// The best decisions so far.
#[derive(Clone)]
struct Best {
    choice: Choice,
    decisions: Vec<f64>,
    cost: f64,
    /// The solver's, where it has already had the last word on these.
    report: Option<sqp::Report>,
}

struct Search<'a> {
    jumper: &'a dyn Jumper,
    course: &'a Course,
    settings: &'a Settings,
    watch: &'a Watch<'a>,
    sequences: &'a Choices<'a>,
    /// Those that were grown to their end.
    choices: Vec<Choice>,
    best: Option<Best>,
    nodes: usize,
    solves: usize,
    serial: usize,
    /// Nodes that had to be split.
    tries: usize,
    open: BinaryHeap<Open>,
    /// Cost of the cheapest way over the whole lattice; none if there is none.
    cheapest_way: Option<f64>,
    /// What was solved first of all, from that way.
    first: Option<First>,
}

/// A program that is solved before the search begins: a node with the same grounds mostly starts from
/// the same decisions.
struct First {
    choice: usize,
    decisions: Vec<f64>,
    /// Whether a plan was found.
    found: bool,
}

impl Search<'_> {
    fn undecided(&self) -> Answer {
        Answer::Undecided {
            nodes: self.nodes,
            solves: self.solves,
        }
    }

    /// Looks at what is open until none of it can be better.
    fn run(&mut self) -> End {
        if let Some(start) = self.sequences.start() {
            if let Some(way) = self.way(&self.sequences.places(), lattice::STEP, Push::Any) {
                self.cheapest_way = Some(way.cost);
                self.choices.push(self.sequences.choice(&way.grounds));
                let choice = self.choices.len() - 1;
                let found = self.solve(choice, &way.decisions, &self.settings.solver);
                self.first = Some(First {
                    choice,
                    decisions: way.decisions,
                    found,
                });
            }
            self.push(start.bound, Part::Prefix(start));
        }
        while let Some(open) = self.open.pop() {
            let bound = open.bound;
            if bound >= self.worth() {
                return End {
                    bound,
                    complete: true,
                };
            }
            let standing = self.standing(bound);
            if standing.share >= 1.0 || (self.watch)(&standing).is_break() {
                return End {
                    bound,
                    complete: false,
                };
            }
            self.nodes += 1;
            match open.part {
                Part::Prefix(prefix) => self.dive(prefix),
                Part::Node(node) => self.look_at(&node),
            }
        }
        End {
            bound: f64::INFINITY,
            complete: true,
        }
    }

    /// How far the search is, if what is open costs no less than `bound`.
    fn standing(&self, bound: f64) -> Standing {
        let work = self.solves * self.course.jumps;
        let share = |done: usize, most: usize| done as f64 / most as f64;
        let share = share(self.nodes, self.settings.nodes).max(share(work, self.settings.work));
        Standing {
            share,
            gap: self.best.as_ref().map_or(f64::INFINITY, |b| b.cost - bound),
        }
    }

    fn push(&mut self, bound: f64, part: Part) {
        self.open.push(Open {
            bound,
            serial: self.serial,
            part,
        });
        self.serial += 1;
    }

    /// The cheapest way over a lattice of footholds.
    fn way(&self, places: &[Vec<Place>], step: f64, push: Push) -> Option<Way> {
        lattice::way(
            self.jumper,
            self.course,
            self.sequences.terrain,
            places,
            step,
            self.settings.sigmas,
            push,
        )
    }

    /// Tries the cheapest way over a fine lattice around the best plan, and the plan anew, until that
    /// finds nothing cheaper: what a jump costs has several optima, and the solver finds the one that
    /// is next to its start.
    fn look_closer(&mut self) {
        for _ in 0..CLOSER_LOOKS {
            let Some(best) = self.best.clone() else {
                return;
            };
            let near = self
                .flown(&best)
                .into_iter()
                .map(|[_, landing]| Span::point(landing).widened(NEAR));
            let places: Vec<Vec<Place>> = self
                .sequences
                .places()
                .into_iter()
                .zip(near)
                .map(|(places, near)| {
                    let places = places.into_iter();
                    let places = places.map(|(ground, span)| (ground, span.meet(near)));
                    places.filter(|(_, span)| !span.is_empty()).collect()
                })
                .collect();
            self.choices.push(best.choice.clone());
            let choice = self.choices.len() - 1;
            self.solve(choice, &best.decisions, &self.settings.solver);
            if self.course.jumps <= THOROUGH {
                // A jump that pushes to its end may do with less.
                for jump in 0..self.course.jumps {
                    let mut decisions = best.decisions.clone();
                    let least = self.jumper.decisions(jump)[1].low;
                    decisions[2 * jump + 1] = f64::midpoint(least, decisions[2 * jump + 1]);
                    self.solve(choice, &decisions, &self.settings.solver);
                }
            }
            if let Some(way) = self.way(&places, FINE, Push::Any) {
                self.choices.push(self.sequences.choice(&way.grounds));
                let choice = self.choices.len() - 1;
                self.solve(choice, &way.decisions, &self.settings.solver);
            }
            if self.worth() + 2.0 * self.settings.gap > best.cost {
                return;
            }
        }
    }

    /// Foothold and landing (m) of each jump.
    fn flown(&self, best: &Best) -> Vec<[f64; 2]> {
        let problem = self.problem(&best.choice);
        let (mut margins, mut landing) = (Vec::new(), self.course.start);
        let jumps = best.decisions.chunks_exact(2).enumerate();
        let each = jumps.map(|(jump, x)| {
            let foot = problem.foothold(jump, landing);
            landing = problem
                .fly(jump, foot, [x[0], x[1]], &mut margins)
                .landing
                .value;
            [foot, landing]
        });
        each.collect()
    }

    /// Where the solver starts for a node that is not split: the cheapest ways over the node's
    /// lattice, and what there is without one. A node without one, where other nodes have one, is given up
    /// once there is a plan.
    fn starts(&self, node: &Node, trial: Trial) -> [Vec<Vec<f64>>; 2] {
        let choice = &self.choices[node.choice];
        let places: Vec<Vec<Place>> = choice
            .grounds
            .iter()
            .zip(&node.windows)
            .map(|(ground, window)| vec![(*ground, *window)])
            .collect();
        // The last jump is solved for each push, as each has an optimum of its own.
        let pushes: &[Push] = if self.course.jumps > THOROUGH {
            &[Push::Any]
        } else {
            &[Push::Any, Push::Whole, Push::Part, Push::Short]
        };
        let ways: Vec<Way> = pushes
            .iter()
            .filter_map(|push| self.way(&places, lattice::STEP, *push))
            .collect();
        let way = ways.first();
        let is_dear = |way: &Way| {
            self.cheapest_way
                .is_some_and(|cheapest| way.cost > DEAR * (cheapest + LATTICE_ERROR))
        };
        // The lattice does not see what a few jumps alone can do, such as to land on a millimetre.
        let is_given_up = match way {
            Some(way) => is_dear(way),
            None => self.cheapest_way.is_some() && self.course.jumps > THOROUGH,
        };
        if is_given_up && self.best.is_some() {
            return [Vec::new(), Vec::new()];
        }
        // Relaxed footholds are often extreme, as many cost the same; even distances are far from
        // every limit.
        let evenly = evenly(&self.problem(&self.choices[node.choice]), self.course);
        let ways = ways.into_iter().map(|way| way.decisions).collect();
        [ways, vec![evenly, trial.decisions]]
    }

    /// Grows a sequence of grounds to its end along its best links; the other links are left open.
    fn dive(&mut self, mut prefix: Prefix) {
        loop {
            if let Some(choice) = self.sequences.finished(&prefix) {
                let (windows, reach) = (
                    choice.windows.clone(),
                    vec![Span::ALL; choice.windows.len()],
                );
                self.choices.push(choice);
                match self.node(self.choices.len() - 1, windows, reach, &[]) {
                    // Without a plan, everything is worth looking at.
                    Some(node) if self.best.is_none() => self.look_at(&node),
                    Some(node) => self.push(node.bound, Part::Node(node)),
                    None => {}
                }
                return;
            }
            let mut grown = self.sequences.grow(&prefix);
            let Some(best) = grown.pop() else { return };
            let worth = self.worth();
            for other in grown.into_iter().filter(|other| other.bound < worth) {
                self.push(other.bound, Part::Prefix(other));
            }
            prefix = best;
        }
    }

    /// A cost that is worth finding is below this.
    fn worth(&self) -> f64 {
        self.best
            .as_ref()
            .map_or(f64::INFINITY, |b| b.cost - self.settings.gap)
    }

    fn problem<'a>(&'a self, choice: &'a Choice) -> Problem<'a> {
        Problem::new(self.jumper, self.course, choice, self.settings.sigmas)
    }

    /// Tries the node's relaxed footholds, then splits it, or solves it where it is too small to be
    /// split.
    fn look_at(&mut self, node: &Node) {
        let trial = self.aim(node);
        if trial.cost.is_finite() {
            let decisions = trial.decisions.clone();
            self.offer(Best {
                choice: self.choices[node.choice].pushed(self.jumper, &decisions),
                decisions,
                cost: trial.cost,
                report: None,
            });
        }
        if node.bound >= self.worth() {
            return;
        }
        self.tries += 1;
        if self.split(node, &trial) {
            if is_power(self.tries, SOLVE_BASE) {
                let quick = sqp::Settings {
                    iterations: SEARCH_ITERATIONS,
                    radius: SEARCH_RADIUS,
                    ..self.settings.solver
                };
                self.solve(node.choice, &trial.decisions, &quick);
            }
        } else {
            let [ways, others] = self.starts(node, trial);
            let several = self.course.jumps > 1;
            let mut found = false;
            for (is_way, starts) in [(true, ways), (false, others)] {
                for start in starts {
                    if found && (several && !is_way || self.course.jumps > THOROUGH) {
                        return;
                    }
                    found |= self
                        .solved_first(node.choice, &start)
                        .unwrap_or_else(|| self.solve(node.choice, &start, &self.settings.solver));
                }
            }
        }
    }

    /// Whether the program of a choice gave a plan from `decisions`, if that is what was solved first.
    fn solved_first(&self, choice: usize, decisions: &[f64]) -> Option<bool> {
        let first = self.first.as_ref()?;
        (first.decisions == decisions && self.choices[first.choice] == self.choices[choice])
            .then_some(first.found)
    }

    /// Looks for a local optimum of a choice; whether it finds a plan.
    fn solve(&mut self, choice: usize, decisions: &[f64], solver: &sqp::Settings) -> bool {
        self.solves += 1;
        let choice = self.choices[choice].pushed(self.jumper, decisions);
        let report = sqp::solve(&self.problem(&choice), decisions, solver);
        let is_plan = report.violation <= self.settings.solver.feasibility;
        if is_plan {
            let is_final =
                report.status == sqp::Status::Converged && *solver == self.settings.solver;
            let (decisions, cost) = (report.x.clone(), report.cost);
            self.offer(Best {
                choice,
                decisions,
                cost,
                report: is_final.then_some(report),
            });
        }
        is_plan
    }

    fn offer(&mut self, candidate: Best) {
        if self.best.as_ref().is_none_or(|b| candidate.cost < b.cost) {
            self.best = Some(candidate);
        }
    }

    /// The best jumps between the relaxed footholds.
    fn aim(&self, node: &Node) -> Trial {
        let choice = &self.choices[node.choice];
        let mut trial = Trial {
            decisions: Vec::new(),
            excess: Vec::new(),
            cost: 0.0,
        };
        let mut landing = self.course.start;
        for (leap, [target, _]) in choice.leaps.iter().zip(&node.relaxed) {
            let foot = landing + roll(self.jumper, leap.jump);
            trial.decisions.extend(self.jumper.aim(leap, foot, *target));
            landing = *target;
        }
        let choice = choice.pushed(self.jumper, &trial.decisions);
        let problem = self.problem(&choice);
        let (mut margins, mut landing) = (Vec::with_capacity(16), self.course.start);
        for (jump, [target, floor]) in node.relaxed.iter().enumerate() {
            let foot = problem.foothold(jump, landing);
            let decisions = [trial.decisions[2 * jump], trial.decisions[2 * jump + 1]];
            let flight = problem.fly(jump, foot, decisions, &mut margins);
            let tolerance = self.settings.solver.feasibility;
            let bounds = self.jumper.decisions(jump);
            let allowed = (0..2).all(|i| bounds[i].clamp(decisions[i]) == decisions[i])
                && (flight.landing.value - target).abs() <= tolerance
                && margins.iter().all(|m| m.value.value >= -tolerance);
            let cost = if allowed {
                flight.cost.value
            } else {
                f64::INFINITY
            };
            trial.excess.push(cost - floor);
            trial.cost += cost;
            landing = *target;
        }
        trial
    }

    /// Halves a window or a distance, the one with the greatest width times excess of a jump that
    /// depends on it; false if all of that is narrow.
    fn split(&mut self, node: &Node, trial: &Trial) -> bool {
        let choice = &self.choices[node.choice];
        let mut widest = (0.0, None);
        let mut consider = |span: Span, weight: f64, part: Cut| {
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
                consider(node.reach[jump], 0.5 * excess, Cut::Distance(jump));
                if !leap.edges.is_empty() {
                    consider(node.windows[jump], excess, Cut::Landing(jump));
                    consider(before, excess, Cut::Landing(jump.wrapping_sub(1)));
                }
            }
            before = node.windows[jump];
        }
        let Some((span, part)) = widest.1 else {
            return false;
        };
        let at = f64::midpoint(span.low, span.high);
        for half in [Span::new(span.low, at), Span::new(at, span.high)] {
            let (mut windows, mut reach) = (node.windows.clone(), node.reach.clone());
            match part {
                Cut::Distance(jump) => reach[jump] = half,
                Cut::Landing(jump) => windows[jump] = half,
            }
            if let Some(part) = self.node(node.choice, windows, reach, &node.bounded) {
                self.push(part.bound, Part::Node(part));
            }
        }
        true
    }

    /// The part of a choice within windows and distances, unless its bound says that it is not
    /// worth it. What is `known` of the jumps' envelopes is used again where it holds.
    fn node(
        &self,
        choice: usize,
        mut windows: Vec<Span>,
        mut reach: Vec<Span>,
        known: &[Bounded],
    ) -> Option<Node> {
        let bounded = self.bound(&self.choices[choice], &mut windows, &mut reach, known)?;
        let (bound, relaxed) = self.relax(&bounded)?;
        (bound < self.worth()).then_some(Node {
            choice,
            windows,
            reach,
            bound,
            bounded,
            relaxed,
        })
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
                None => self
                    .jumper
                    .envelope(leap, feet, windows[jump], reach[jump])?,
            };
            reach[jump] = envelope.reach();
            windows[jump] = windows[jump].meet(feet + reach[jump]);
            landing = windows[jump];
            bounded.push(Bounded {
                feet,
                window: landing,
                envelope,
            });
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
        let problem = self.problem(&best.choice);
        let solver = &self.settings.solver;
        let solve = || sqp::solve(&problem, &best.decisions, solver);
        let mut report = best.report.clone().unwrap_or_else(solve);
        if report.violation > self.settings.solver.feasibility || report.cost > best.cost {
            report.x.clone_from(&best.decisions);
            report.cost = best.cost;
        }
        let (mut jumps, mut margins, mut landing) = (Vec::new(), Vec::new(), self.course.start);
        for (jump, leap) in best.choice.leaps.iter().enumerate() {
            let foot = problem.foothold(jump, landing);
            let decisions = [report.x[2 * jump], report.x[2 * jump + 1]];
            let flight = problem.fly(jump, foot, decisions, &mut margins);
            landing = flight.landing.value;
            jumps.push(Jump {
                leap: leap.clone(),
                foot,
                landing,
                decisions,
                deviation: self.jumper.deviation(leap, decisions),
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
enum Cut {
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
