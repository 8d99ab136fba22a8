//! The strides of a robot as a finite decision process: cells of states, each with a real state in it.

use std::collections::BTreeMap;

use super::walker::{After, Choices, Walker, Way};
use crate::GaitError;

/// Widths of a cell of size 1: rate (rad/s), travel and height (m), their rates (m/s), legs out (m).
const WIDTHS: [f64; 6] = [0.4, 0.04, 0.02, 0.2, 0.4, 0.04];
/// Most cells.
const MOST: usize = 5000;
/// A speed (m/s) that no robot exceeds on the way, for the least time that is left.
const FASTEST: f64 = 8.0;

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

/// The earliest state that waits in a cell.
struct Waiting<'a> {
    walker: Walker<'a>,
    parent: Option<(usize, Pick)>,
    arrival: f64,
}

fn key(walker: &mut Walker<'_>, size: f64) -> Key {
    let measures = walker.measures();
    let mut key = [walker.passed(); 7];
    for (k, (measure, width)) in key[1..].iter_mut().zip(measures.iter().zip(WIDTHS)) {
        *k = crate::cast::whole((measure / (size * width)).floor());
    }
    key
}

/// Cells of the size `size` that `choices` lead to in at most `limit` (s). Each holds the earliest
/// state that came into it, in full, from the earliest state of another cell.
pub(super) fn explore(
    way: &Way,
    (size, choices): (f64, &Choices),
    limit: f64,
    threads: usize,
    told: &mut impl FnMut(usize),
) -> Result<Graph, GaitError> {
    let mut graph = Graph {
        cells: Vec::new(),
        openings: choices.openings.len(),
        angles: choices.angles.len(),
        reached: None,
        farthest: 0.0,
    };
    let mut start = way.begin()?;
    let (mut waiting, mut found) = (BTreeMap::new(), BTreeMap::new());
    let first = key(&mut start, size);
    waiting.insert(
        first,
        Waiting {
            walker: start,
            parent: None,
            arrival: 0.0,
        },
    );
    let mut links: Vec<Vec<Option<(f64, Option<Key>)>>> = Vec::new();
    while graph.cells.len() < MOST
        && let Some((at, mut next)) = earliest(&mut waiting)
    {
        let limit = graph
            .reached
            .map_or(limit, |(time, ..)| limit.min(SLACK * time));
        if next.walker.time + next.walker.left() / FASTEST > limit {
            continue;
        }
        let me = graph.cells.len();
        found.insert(at, me);
        let fan = next.walker.fan(choices, threads)?;
        graph.cells.push(Cell {
            passed: next.walker.passed(),
            rate: next.walker.action.rate,
            edges: Vec::new(),
            groups: fan.groups,
            parent: next.parent,
            value: f64::INFINITY,
        });
        let mut out = Vec::new();
        for (k, after) in fan.after.into_iter().enumerate() {
            let pick = graph.pick(me, k);
            out.push(match after {
                After::Stall => None,
                After::Goal(time) => {
                    if graph.reached.is_none_or(|(best, ..)| time < best) {
                        graph.reached = Some((time, me, pick));
                    }
                    Some((time - next.walker.time, None))
                }
                After::Entry(mut child) => {
                    graph.farthest = graph.farthest.max(child.travel());
                    let (to, time) = (key(&mut child, size), child.time - next.walker.time);
                    let arrival = child.time + child.left() / child.measures()[3].max(0.5);
                    let later = |other: &Waiting<'_>| arrival < other.arrival;
                    if !found.contains_key(&to) && waiting.get(&to).is_none_or(later) {
                        let parent = Some((me, pick));
                        waiting.insert(
                            to,
                            Waiting {
                                walker: *child,
                                parent,
                                arrival,
                            },
                        );
                    }
                    Some((time, Some(to)))
                }
            });
        }
        links.push(out);
        told(graph.cells.len());
    }
    for (cell, links) in graph.cells.iter_mut().zip(links) {
        let edge = |link: Option<(f64, Option<Key>)>| match link? {
            (time, None) => Some(Edge { time, to: None }),
            (time, Some(to)) => found.get(&to).map(|to| Edge {
                time,
                to: Some(*to),
            }),
        };
        cell.edges = links.into_iter().map(edge).collect();
    }
    Ok(graph)
}

/// Time over the best one known up to which states are followed.
const SLACK: f64 = 1.1;

fn earliest<'a>(waiting: &mut BTreeMap<Key, Waiting<'a>>) -> Option<(Key, Waiting<'a>)> {
    let time = |entry: &(&Key, &Waiting<'a>)| entry.1.walker.time;
    let first = waiting.iter().min_by(|a, b| time(a).total_cmp(&time(b)));
    let key = *first?.0;
    waiting.remove(&key).map(|next| (key, next))
}

impl Graph {
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
