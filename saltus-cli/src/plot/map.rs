//! Maps: one coloured cell for each approach rate and firing angle, contours over them, other
//! outcomes than a jump in grey.

use plotters::prelude::{RGBColor, WHITE};

use super::contour::{Field, levels};
use super::line::{Line, Mark};
use super::palette::{INK, viridis};
use super::sheet::{Label, Panel, Side};
use super::{span, tick};

/// What launches give, angles within rates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Map<'a> {
    /// Approach rates (rad/s).
    pub(crate) rates: &'a [f64],
    /// Firing angles (rad).
    pub(crate) angles: &'a [f64],
    /// How each launch ends.
    pub(crate) outcomes: &'a [&'static str],
}

impl Map<'_> {
    /// One quantity; none where there is no such thing.
    pub(crate) fn panel(&self, title: &str, values: &[Option<f64>]) -> Panel {
        let (low, high) = span(values.iter().flatten().copied());
        let levels = levels(low, high);
        let of = |has_value: bool| {
            let all = self.outcomes.iter().zip(values);
            counts(
                all.filter(|(_, v)| v.is_some() == has_value)
                    .map(|(name, _)| *name),
            )
        };
        let (regions, others) = (of(true), of(false));
        let mut title = title.to_owned();
        let mut lines = self.cells(values, (low, high));
        let mut labels = Vec::new();
        if regions.len() > 1 {
            let names: Vec<&str> = regions.iter().map(|(name, _)| *name).collect();
            title = format!("{title}; dark line: border of {}", names.join(" and "));
            labels.extend(names.iter().map(|name| self.name(name, values)));
        }
        lines.extend(self.borders(values));
        let field = Field {
            x: self.rates,
            y: self.angles,
            values,
            kinds: self.outcomes,
        };
        for &level in &levels {
            let pieces = field.segments(level);
            lines.extend(
                pieces
                    .iter()
                    .map(|piece| Line::new(Mark::Stroke(1), WHITE, *piece)),
            );
            // Its number stands as near the middle of the line as may be.
            let middle = pieces.len() / 2;
            let mut order: Vec<usize> = (0..pieces.len()).collect();
            order.sort_by_key(|&i| i.abs_diff(middle));
            labels.push(label(tick(level), order.iter().map(|&i| pieces[i][0])));
        }
        let all = counts(self.outcomes.iter().copied());
        let all: Vec<String> = all.iter().map(|(name, n)| format!("{n} {name}")).collect();
        let is_empty = values.iter().all(Option::is_none);
        let empty = format!("No launch has this value. How they end: {}", all.join(", "));
        Panel {
            title,
            swatches: others
                .into_iter()
                .map(|(name, _)| (name, grey(name)))
                .collect(),
            x: "approach rate ω (rad/s)",
            y: "firing angle α_f (rad)",
            lines,
            labels,
            empty: if is_empty { empty } else { String::new() },
            scale: (!is_empty).then_some((low, high, levels)),
            ..Panel::default()
        }
    }

    /// Column and row of launch `i`.
    fn place(&self, i: usize) -> [usize; 2] {
        [i / self.angles.len(), i % self.angles.len()]
    }

    /// A coloured rectangle for each launch.
    fn cells(&self, values: &[Option<f64>], (low, high): (f64, f64)) -> Vec<Line> {
        let (x, y) = (edges(self.rates), edges(self.angles));
        let share = |value: f64| {
            if high > low {
                (value - low) / (high - low)
            } else {
                0.5
            }
        };
        let cell = |(i, value): (usize, &Option<f64>)| {
            let color = value.map_or_else(|| grey(self.outcomes[i]), |value| viridis(share(value)));
            let [column, row] = self.place(i);
            let corners = [(x[column], y[row]), (x[column + 1], y[row + 1])];
            Line::new(Mark::Area(1.0), color, corners)
        };
        values.iter().enumerate().map(cell).collect()
    }

    /// Dark lines where one region with values ends at another.
    fn borders(&self, values: &[Option<f64>]) -> Vec<Line> {
        let (x, y) = (edges(self.rates), edges(self.angles));
        let height = self.angles.len();
        let differ = |a: usize, b: usize| {
            self.outcomes[a] != self.outcomes[b] && values[a].is_some() && values[b].is_some()
        };
        let line = |points: [(f64, f64); 2]| Line::new(Mark::Stroke(2), INK, points);
        let mut lines = Vec::new();
        for i in 0..values.len() {
            let [column, row] = self.place(i);
            let (right, above) = (x[column + 1], y[row + 1]);
            if row + 1 < height && differ(i, i + 1) {
                lines.push(line([(x[column], above), (right, above)]));
            }
            if column + 1 < self.rates.len() && differ(i, i + height) {
                lines.push(line([(right, y[row]), (right, above)]));
            }
        }
        lines
    }

    /// The name of a region, at its cell that is nearest to its middle.
    fn name(&self, name: &str, values: &[Option<f64>]) -> Label {
        let cells = (0..values.len()).filter(|&i| values[i].is_some() && self.outcomes[i] == name);
        let cells: Vec<[usize; 2]> = cells.map(|i| self.place(i)).collect();
        let mean =
            |k: usize| cells.iter().map(|at| at[k]).sum::<usize>() as f64 / cells.len() as f64;
        let size = [self.rates.len(), self.angles.len()];
        let off = |at: &[usize; 2]| {
            let part = |k: usize| ((at[k] as f64 - mean(k)) / size[k] as f64).powi(2);
            part(0) + part(1)
        };
        let nearest = cells.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        label(
            name.into(),
            nearest.map(|at| (self.rates[at[0]], self.angles[at[1]])),
        )
    }
}

fn label(words: String, places: impl IntoIterator<Item = (f64, f64)>) -> Label {
    Label {
        words,
        places: places.into_iter().collect(),
        side: Side::On,
        color: INK,
    }
}

/// How many launches end in which way, in the order of their first.
pub(crate) fn counts(outcomes: impl Iterator<Item = &'static str>) -> Vec<(&'static str, usize)> {
    let mut counts: Vec<(&str, usize)> = Vec::new();
    for outcome in outcomes {
        match counts.iter_mut().find(|(known, _)| *known == outcome) {
            Some((_, count)) => *count += 1,
            None => counts.push((outcome, 1)),
        }
    }
    counts
}

/// A shade for each outcome without a value.
fn grey(outcome: &str) -> RGBColor {
    let shade = match outcome {
        "no-landing" => 235,
        "stall" => 205,
        "no-break-away" => 170,
        "early-lift-off" => 130,
        "fall-back" => 100,
        _ => 70,
    };
    RGBColor(shade, shade, shade)
}

/// Where the cells around `centres` end: half-way between neighbours.
fn edges(centres: &[f64]) -> Vec<f64> {
    let [begin, end] = match centres {
        [.., a, b] => [(centres[1] - centres[0]) / 2.0, (b - a) / 2.0],
        _ => [0.5, 0.5],
    };
    let between = centres
        .windows(2)
        .map(|pair| f64::midpoint(pair[0], pair[1]));
    let (first, last) = (centres[0], centres[centres.len() - 1]);
    std::iter::once(first - begin)
        .chain(between)
        .chain(std::iter::once(last + end))
        .collect()
}
