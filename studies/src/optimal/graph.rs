//! The strides of a robot as a finite decision process: cells of states, each with a real state in it.

use std::collections::BTreeMap;

use saltus_gait::GaitError;

use super::walker::{After, Choices, Walker, Way};
use crate::whole;

/// Widths of a cell of size 1: rate (rad/s), travel and height (m), their rates (m/s), legs out (m).
const WIDTHS: [f64; 6] = [0.4, 0.04, 0.02, 0.2, 0.4, 0.04];
/// Most cells.
const MOST: usize = 400;
/// Time over the best one known up to which states are followed.
const SLACK: f64 = 1.1;

/// Legs that have passed, and in which cell each measure lies.
type Key = [i32; 7];

/// What a choice in a cell comes to: how long it takes (s), and the cell then; none where the distance
/// is reached.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    time: f64,
    to: Option<usize>,
}

/// A cell.
#[derive(Clone, Debug)]
pub(super) struct Cell {
    /// Legs that have passed.
    pub(super) passed: i32,
    /// Rate (rad/s) of its state.
    pub(super) rate: f64,
    /// When its state came (s), and how far it has to go (m).
    pub(super) time: f64,
    pub(super) left: f64,
    /// How long that takes at the speed it has then (s).
    to_go: f64,
    /// What each choice comes to, as [`Fan`](super::walker::Fan) has them; none: nowhere.
    edges: Vec<Option<Edge>>,
    /// Group of each firing angle.
    groups: Vec<Option<usize>>,
    /// From which cell its state came, by which choice.
    parent: Option<(usize, Pick)>,
    /// Least time (s) from here.
    pub(super) value: f64,
}

/// A choice: firing angle and opening time by their numbers; none fires none.
pub(super) type Pick = Option<[usize; 2]>;

/// A finite decision process.
pub(super) struct Graph {
    pub(super) cells: Vec<Cell>,
    openings: usize,
    angles: usize,
    /// Least time (s) in which a real sequence of firings reached the distance, and its last cell and
    /// choice.
    pub(super) reached: Option<(f64, usize, Pick)>,
    /// Farthest that any stride came (m).
    pub(super) farthest: f64,
}

/// How long a choice takes (s), in which cell it ends, and the time (s) from there to the goal at the
/// speed it then has; none of a cell where the goal is reached.
type Link = Option<(f64, Option<(Key, f64)>)>;

/// A state that waits to be the one of its cell.
#[derive(Clone, Copy, Debug)]
struct Waiting {
    /// From which cell, by which choice; none at rest.
    parent: Option<(usize, Pick)>,
    /// When (s), and how far it then has to go (m).
    time: f64,
    left: f64,
    /// When it would be there at its present speed (s).
    arrival: f64,
}

/// What a level goes by.
pub(super) struct Level<'g> {
    /// Size of the cells.
    pub(super) size: f64,
    pub(super) choices: &'g Choices,
    /// Longest time from rest (s).
    pub(super) limit: f64,
    /// A mean speed (m/s) over the rest of the way that no state exceeds.
    pub(super) fastest: f64,
}

fn key(walker: &mut Walker<'_>, size: f64) -> Key {
    let measures = walker.measures();
    let mut key = [walker.passed; 7];
    for (k, (measure, width)) in key[1..].iter_mut().zip(measures.iter().zip(WIDTHS)) {
        *k = whole((measure / (size * width)).floor());
    }
    key
}

/// Cells that the choices of `level` lead to. Each holds a state in full, which came from that of
/// another cell: of those that came before it was that state's turn, the one that would be there first
/// at its present speed.
pub(super) fn explore(
    way: &Way,
    level: &Level<'_>,
    threads: usize,
    told: &mut impl FnMut(usize),
) -> Result<Graph, GaitError> {
    let mut explorer = Explorer {
        level,
        graph: Graph {
            cells: Vec::new(),
            openings: level.choices.openings.len(),
            angles: level.choices.angles.len(),
            reached: None,
            farthest: 0.0,
        },
        walkers: Vec::new(),
        waiting: BTreeMap::new(),
        found: BTreeMap::new(),
        links: Vec::new(),
    };
    let mut start = way.begin()?;
    explorer.wait(&mut start, None);
    while explorer.graph.cells.len() < MOST
        && let Some((at, next)) = explorer.earliest()
    {
        let walker = match next.parent {
            None => start.clone(),
            Some((cell, pick)) => {
                let firing = level.choices.firing(pick);
                match explorer.walkers[cell].follow(firing)? {
                    After::Entry(walker) => *walker,
                    _ => continue,
                }
            }
        };
        explorer.expand(at, next, walker, threads)?;
        told(explorer.graph.cells.len());
    }
    Ok(explorer.linked())
}

/// A graph as it grows.
struct Explorer<'a, 'g> {
    level: &'g Level<'g>,
    graph: Graph,
    /// The state of each cell.
    walkers: Vec<Walker<'a>>,
    waiting: BTreeMap<Key, Waiting>,
    found: BTreeMap<Key, usize>,
    /// For each cell and choice the time (s) and the cell where it ends.
    links: Vec<Vec<Link>>,
}

impl<'a> Explorer<'a, '_> {
    /// The state that may be there first; those that are too late are dropped.
    fn earliest(&mut self) -> Option<(Key, Waiting)> {
        loop {
            let fastest = self.level.fastest;
            let least = |next: &Waiting| next.time + next.left / fastest;
            let by = |a: &(&Key, &Waiting), b: &(&Key, &Waiting)| least(a.1).total_cmp(&least(b.1));
            let key = *self.waiting.iter().min_by(by)?.0;
            let next = self.waiting.remove(&key)?;
            let limit = self.level.limit;
            let limit = self
                .graph
                .reached
                .map_or(limit, |(time, ..)| limit.min(SLACK * time));
            if least(&next) <= limit {
                return Some((key, next));
            }
        }
    }

    /// Lets the state of `walker` wait for its cell, unless a better one does.
    fn wait(&mut self, walker: &mut Walker<'a>, parent: Option<(usize, Pick)>) -> Key {
        let key = key(walker, self.level.size);
        let (time, left) = (walker.time, walker.left());
        let arrival = time + walker.time_left();
        let better = self
            .waiting
            .get(&key)
            .is_none_or(|other| arrival < other.arrival);
        if better && !self.found.contains_key(&key) {
            let next = Waiting {
                parent,
                time,
                left,
                arrival,
            };
            self.waiting.insert(key, next);
        }
        key
    }

    /// Makes a cell of the state of `walker`, and follows each choice.
    fn expand(
        &mut self,
        at: Key,
        next: Waiting,
        mut walker: Walker<'a>,
        threads: usize,
    ) -> Result<(), GaitError> {
        let me = self.graph.cells.len();
        self.found.insert(at, me);
        self.graph.farthest = self.graph.farthest.max(walker.travel());
        let fan = walker.fan(self.level.choices, threads)?;
        self.graph.cells.push(Cell {
            passed: walker.passed,
            rate: walker.action.rate,
            time: next.time,
            left: next.left,
            to_go: next.arrival - next.time,
            edges: Vec::new(),
            groups: fan.groups,
            parent: next.parent,
            value: f64::INFINITY,
        });
        let mut links = Vec::new();
        for (k, after) in fan.after.into_iter().enumerate() {
            let pick = self.graph.pick(me, k);
            links.push(match after {
                After::Stall => None,
                After::Goal(time) => {
                    if self.graph.reached.is_none_or(|(best, ..)| time < best) {
                        self.graph.reached = Some((time, me, pick));
                    }
                    Some((time - next.time, None))
                }
                After::Entry(mut child) => {
                    let to = self.wait(&mut child, Some((me, pick)));
                    Some((child.time - next.time, Some((to, child.time_left()))))
                }
            });
        }
        self.links.push(links);
        self.walkers.push(walker);
        Ok(())
    }

    /// The graph. A state that is slower than the one of its cell is charged with what that costs at
    /// the speeds that both have.
    fn linked(self) -> Graph {
        let (mut graph, found) = (self.graph, self.found);
        let to_go: Vec<f64> = graph.cells.iter().map(|cell| cell.to_go).collect();
        for (cell, links) in graph.cells.iter_mut().zip(self.links) {
            let edge = |link: Link| match link? {
                (time, None) => Some(Edge { time, to: None }),
                (time, Some((to, slow))) => found.get(&to).map(|to| Edge {
                    time: time + (slow - to_go[*to]).max(0.0),
                    to: Some(*to),
                }),
            };
            cell.edges = links.into_iter().map(edge).collect();
        }
        graph
    }
}

impl Graph {
    /// The greatest mean speed (m/s) over the rest of the way from any cell; none where no cell leads
    /// there.
    pub(super) fn fastest(&self) -> Option<f64> {
        let speeds = self.cells.iter().map(|cell| cell.left / cell.value);
        speeds.filter(|speed| *speed > 0.0).reduce(f64::max)
    }

    /// The choice that edge `k` of cell `cell` stands for: the least angle of its group.
    fn pick(&self, cell: usize, k: usize) -> Pick {
        let k = k.checked_sub(1)?;
        let groups = &self.cells[cell].groups;
        let angle = groups
            .iter()
            .position(|group| *group == Some(k / self.openings))?;
        Some([angle, k % self.openings])
    }

    /// Time (s) from cell `cell` by edge `k`.
    fn by_edge(&self, cell: usize, k: usize) -> f64 {
        self.cells[cell].edges[k].map_or(f64::INFINITY, |edge| {
            edge.time + edge.to.map_or(0.0, |to| self.cells[to].value)
        })
    }

    /// Time (s) from cell `cell` if `pick` is chosen there.
    pub(super) fn by(&self, cell: usize, pick: Pick) -> f64 {
        let group = pick.and_then(|[angle, opening]| {
            let group = self.cells[cell].groups[angle]?;
            Some(1 + group * self.openings + opening)
        });
        self.by_edge(cell, group.unwrap_or(0))
    }

    /// All choices.
    pub(super) fn picks(&self) -> impl Iterator<Item = Pick> {
        let (angles, openings) = (self.angles, self.openings);
        let fired = (0..angles).flat_map(move |a| (0..openings).map(move |o| Some([a, o])));
        std::iter::once(None).chain(fired)
    }

    fn best(&self, cell: usize) -> f64 {
        let edges = 0..self.cells[cell].edges.len();
        edges
            .map(|k| self.by_edge(cell, k))
            .fold(f64::INFINITY, f64::min)
    }

    /// Value iteration: from the last cells to the first until nothing changes. Sweeps, and the
    /// residual of Bellman's equation (s) that is left.
    pub(super) fn iterate(&mut self) -> (usize, f64) {
        let mut sweeps = 0;
        loop {
            for cell in (0..self.cells.len()).rev() {
                self.cells[cell].value = self.best(cell);
            }
            sweeps += 1;
            let residual = self.residual();
            if residual <= 1e-9 || sweeps > self.cells.len() {
                return (sweeps, residual);
            }
        }
    }

    fn residual(&self) -> f64 {
        let off = |cell: usize| {
            let (is, best) = (self.cells[cell].value, self.best(cell));
            if is == best { 0.0 } else { (is - best).abs() }
        };
        (0..self.cells.len()).map(off).fold(0.0, f64::max)
    }

    /// The choices of the real sequence of firings that reached the distance first.
    pub(super) fn sequence(&self) -> Vec<Pick> {
        let Some((_, mut at, last)) = self.reached else {
            return Vec::new();
        };
        let mut picks = vec![last];
        while let Some((before, pick)) = self.cells[at].parent {
            picks.push(pick);
            at = before;
        }
        picks.reverse();
        picks
    }
}
