//! The policy as a table.

use super::graph::{Graph, Pick};
use super::walker::Choices;
use crate::whole;

/// A table of firings: lines between its nodes over the rate at which a leg enters the zone, level
/// beyond; a row for each number of legs that have come into the zone since the start, the last one
/// from then on.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Rates (rad/s) of the first and the last node of each row, evenly spaced.
    pub rates: [f64; 2],
    /// Nodes of a row, ≥ 2.
    pub count: usize,
    /// α_f (rad) and t_v (s), row after row.
    pub nodes: Vec<[f64; 2]>,
}

impl Table {
    /// α_f (rad) and t_v (s) of a leg that enters the zone at `rate` (rad/s) after so many others.
    pub fn at(&self, rate: f64, passed: i32) -> [f64; 2] {
        let [first, last] = self.rates;
        let along = (rate.clamp(first, last) - first) * (self.count - 1) as f64 / (last - first);
        let before = (whole(along.floor()).unsigned_abs() as usize).min(self.count - 2);
        let row = (passed.max(0).unsigned_abs() as usize).min(self.nodes.len() / self.count - 1);
        let (cell, part) = (row * self.count + before, along - before as f64);
        let (from, to) = (self.nodes[cell], self.nodes[cell + 1]);
        std::array::from_fn(|k| from[k] + part * (to[k] - from[k]))
    }
}

/// Time (s) over the least one by which a cell counts e times less.
const FAR: f64 = 0.01;
/// What a choice that leads nowhere costs (s) beside the best one there: about a start anew.
const NOWHERE: f64 = 1.0;

/// The table sees how many legs have come and the rate of entry, less than a cell is told apart
/// by. Each node has the choice of least mean time of the cells around it, weighted as the lines to
/// the node are, and the more the nearer a cell is to the fastest way.
pub(super) fn of(graph: &Graph, choices: &Choices, spacing: f64) -> Table {
    let all = 0..graph.cells.len();
    let live: Vec<usize> = all.filter(|k| graph.cells[*k].value.is_finite()).collect();
    let rates = live.iter().map(|k| graph.cells[*k].rate / spacing);
    let low = rates.clone().fold(f64::INFINITY, f64::min).floor();
    let high = rates
        .fold(f64::NEG_INFINITY, f64::max)
        .ceil()
        .max(low + 1.0);
    let count = whole(high - low).unsigned_abs() as usize + 1;
    let rows = live.iter().map(|k| graph.cells[*k].passed).max();
    let mut nodes = Vec::new();
    for row in 0..=rows.unwrap_or(0).max(0) {
        let of_row = live.iter().copied();
        let mut here: Vec<usize> = of_row.filter(|k| graph.cells[*k].passed == row).collect();
        if here.is_empty() {
            here.clone_from(&live);
        }
        for node in 0..count {
            let off = |k: usize| (graph.cells[k].rate / spacing - low - node as f64).abs();
            nodes.push(common(graph, choices, &around(graph, &here, off)));
        }
    }
    Table {
        rates: [low * spacing, high * spacing],
        count,
        nodes,
    }
}

/// The cells of `here` less than a node `off`, with their weights; else the nearest one.
fn around(graph: &Graph, here: &[usize], off: impl Fn(usize) -> f64) -> Vec<(usize, f64)> {
    let start = graph.cells[0].value;
    let weight = |k: usize| {
        let late = graph.cells[k].time + graph.cells[k].value - start;
        (1.0 - off(k)) * (-late / FAR).exp()
    };
    let near: Vec<_> = here
        .iter()
        .filter(|k| off(**k) < 1.0)
        .map(|k| (*k, weight(*k)))
        .collect();
    if !near.is_empty() {
        return near;
    }
    let nearest = here.iter().min_by(|a, b| off(**a).total_cmp(&off(**b)));
    nearest.map(|k| (*k, 1.0)).into_iter().collect()
}

/// The choice of least mean time from `cells` with their weights.
fn common(graph: &Graph, choices: &Choices, cells: &[(usize, f64)]) -> [f64; 2] {
    let worth = |pick: Pick| -> f64 {
        let times = cells
            .iter()
            .map(|(k, weight)| weight * graph.by(*k, pick).min(graph.cells[*k].value + NOWHERE));
        times.sum()
    };
    let mut best = (f64::INFINITY, None);
    for pick in graph.picks() {
        let worth = worth(pick);
        if worth < best.0 {
            best = (worth, pick);
        }
    }
    choices.firing(best.1).unwrap_or([choices.angles[0], 0.0])
}
