//! Maps: one coloured cell for each approach rate and firing angle, contours over them, other
//! outcomes than a jump in grey.

use plotters::coord::Shift;
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::{Color, DrawingArea, DrawingBackend, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, notice, tick, titled};
use super::contour::{Field, levels};
use super::curves::span;
use super::palette::{INK, viridis};

const WIDTH: u32 = 760;
const HEIGHT: u32 = 470;
const TITLE: u32 = 34;
/// Height of the line over a panel.
const HEAD: u32 = 28;
/// Width of the scale beside a panel.
const SCALE: u32 = 96;

/// What is reachable, over approach rates and firing angles.
pub(crate) struct MapPlot {
    pub(crate) title: String,
    /// Approach rates (rad/s).
    pub(crate) rates: Vec<f64>,
    /// Firing angles (rad).
    pub(crate) angles: Vec<f64>,
    pub(crate) panels: Vec<Panel>,
    /// How each launch ends, angles within rates.
    pub(crate) outcomes: Vec<&'static str>,
}

/// One quantity, angles within rates; none where there is no such thing.
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) values: Vec<Option<f64>>,
}

impl MapPlot {
    pub(crate) fn size(&self) -> (u32, u32) {
        (
            WIDTH,
            TITLE + HEIGHT * u32::try_from(self.panels.len()).unwrap_or(1),
        )
    }

    pub(crate) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let mut rest = titled(area, pen, &self.title)?;
        for panel in &self.panels {
            let (here, below) = rest.split_vertically(pen.length(HEIGHT));
            self.draw_panel(&here, pen, panel)?;
            rest = below;
        }
        Ok(())
    }

    fn draw_panel<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
        panel: &Panel,
    ) -> Drawn<DB> {
        let (head, body) = area.split_vertically(pen.length(HEAD));
        self.draw_legend(&head, pen, panel)?;
        let (left, right) = body.split_horizontally(pen.length(WIDTH - SCALE));
        let (x, y) = (edges(&self.rates), edges(&self.angles));
        let (low, high) = span(panel.values.iter().flatten().copied());
        let share = |value: f64| {
            if high > low {
                (value - low) / (high - low)
            } else {
                0.5
            }
        };
        let axes = Axes {
            x: ("approach rate ω (rad/s)", span_of(&x)),
            y: ("firing angle α_f (rad)", span_of(&y)),
        };
        let mut chart = axes.build(&left, pen)?;
        let height = self.angles.len();
        chart.draw_series(panel.values.iter().enumerate().map(|(i, value)| {
            let (column, row) = (i / height, i % height);
            let color = value.map_or_else(|| grey(self.outcomes[i]), |value| viridis(share(value)));
            Rectangle::new(
                [(x[column], y[row]), (x[column + 1], y[row + 1])],
                color.filled(),
            )
        }))?;
        if panel.values.iter().all(Option::is_none) {
            return notice(
                &chart,
                pen,
                &format!("No launch has this value. How they end: {}", self.counts()),
            );
        }
        let levels = levels(low, high);
        self.draw_borders(&mut chart, pen, panel, (&x, &y))?;
        let names = self.named_regions(panel);
        self.draw_contours(&mut chart, pen, panel, &levels, &names)?;
        for (name, place) in names {
            tag(&chart, pen, name, place)?;
        }
        draw_scale(&right, pen, (low, high), &levels)
    }

    /// How many launches end in which way.
    fn counts(&self) -> String {
        let mut counts: Vec<(&str, usize)> = Vec::new();
        for outcome in &self.outcomes {
            match counts.iter_mut().find(|(known, _)| known == outcome) {
                Some((_, count)) => *count += 1,
                None => counts.push((outcome, 1)),
            }
        }
        counts
            .iter()
            .map(|(name, count)| format!("{count} {name}"))
            .collect::<Vec<_>>()
            .join(", ")
    }

    /// The regions with values, most cells first.
    fn regions(&self, panel: &Panel) -> Vec<(&'static str, Vec<usize>)> {
        let mut regions: Vec<(&'static str, Vec<usize>)> = Vec::new();
        for (i, outcome) in self
            .outcomes
            .iter()
            .enumerate()
            .filter(|(i, _)| panel.values[*i].is_some())
        {
            match regions.iter_mut().find(|(known, _)| known == outcome) {
                Some((_, cells)) => cells.push(i),
                None => regions.push((outcome, vec![i])),
            }
        }
        regions
    }

    /// Dark lines where one region with values ends at another.
    fn draw_borders<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
        panel: &Panel,
        (x, y): (&[f64], &[f64]),
    ) -> Drawn<DB> {
        let height = self.angles.len();
        let differ = |a: usize, b: usize| {
            self.outcomes[a] != self.outcomes[b]
                && panel.values[a].is_some()
                && panel.values[b].is_some()
        };
        let mut lines = Vec::new();
        for i in 0..self.outcomes.len() {
            let (column, row) = (i / height, i % height);
            if row + 1 < height && differ(i, i + 1) {
                lines.push(vec![(x[column], y[row + 1]), (x[column + 1], y[row + 1])]);
            }
            if column + 1 < self.rates.len() && differ(i, i + height) {
                lines.push(vec![(x[column + 1], y[row]), (x[column + 1], y[row + 1])]);
            }
        }
        chart.draw_series(
            lines
                .into_iter()
                .map(|line| PathElement::new(line, pen.line(INK, 2))),
        )?;
        Ok(())
    }

    /// The name of each region with values, and a cell of it by its middle, where there are
    /// several.
    fn named_regions(&self, panel: &Panel) -> Vec<(&'static str, (f64, f64))> {
        let height = self.angles.len();
        let place = |i: &usize| (self.rates[i / height], self.angles[i % height]);
        let (wide, high) = (extent(&self.rates), extent(&self.angles));
        let middle = |(name, cells): &(&'static str, Vec<usize>)| {
            let count = cells.len() as f64;
            let sum = cells
                .iter()
                .map(place)
                .fold((0.0, 0.0), |sum, at| (sum.0 + at.0, sum.1 + at.1));
            let off = |at: (f64, f64)| {
                ((at.0 - sum.0 / count) / wide).powi(2) + ((at.1 - sum.1 / count) / high).powi(2)
            };
            let nearest = cells
                .iter()
                .map(place)
                .min_by(|a, b| off(*a).total_cmp(&off(*b)))?;
            Some((*name, nearest))
        };
        let regions = self.regions(panel);
        if regions.len() > 1 {
            regions.iter().filter_map(middle).collect()
        } else {
            Vec::new()
        }
    }

    fn draw_contours<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
        panel: &Panel,
        levels: &[f64],
        names: &[(&'static str, (f64, f64))],
    ) -> Drawn<DB> {
        let field = Field {
            x: &self.rates,
            y: &self.angles,
            values: &panel.values,
            kinds: &self.outcomes,
        };
        let style = pen.line(RGBColor(255, 255, 255), 1);
        let mut taken: Vec<(i32, i32)> = names
            .iter()
            .map(|(_, place)| chart.plotting_area().map_coordinate(place))
            .collect();
        for &level in levels {
            let lines = field.segments(level);
            chart.draw_series(
                lines
                    .iter()
                    .map(|line| PathElement::new(line.to_vec(), style)),
            )?;
            // Its number stands where there is room, as near the middle of the line as may be.
            let middle = lines.len() / 2;
            let mut order: Vec<usize> = (0..lines.len()).collect();
            order.sort_by_key(|&i| i.abs_diff(middle));
            let place = |i: &usize| chart.plotting_area().map_coordinate(&lines[*i][0]);
            let is_free = |at: &(i32, i32)| {
                taken.iter().all(|t| {
                    (t.0 - at.0).abs() > pen.offset(56) || (t.1 - at.1).abs() > pen.offset(18)
                })
            };
            if let Some(i) = order.into_iter().find(|i| is_free(&place(i))) {
                taken.push(place(&i));
                tag(chart, pen, &tick(level), lines[i][0])?;
            }
        }
        Ok(())
    }

    /// What the colours and the grey cells are.
    fn draw_legend<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
        panel: &Panel,
    ) -> Drawn<DB> {
        let mut names: Vec<&str> = Vec::new();
        for (outcome, value) in self.outcomes.iter().zip(&panel.values) {
            if value.is_none() && !names.contains(outcome) {
                names.push(outcome);
            }
        }
        let middle = pen.offset(HEAD.cast_signed() * 2 / 3);
        let style = pen.text(13, INK, HPos::Left, VPos::Center);
        let mut left = pen.offset(78);
        area.draw_text(&panel.title, &style, (left, middle))?;
        left += width(&panel.title, pen);
        let regions = self.regions(panel);
        if regions.len() > 1 {
            let half = pen.offset(9);
            area.draw(&PathElement::new(
                vec![(left, middle), (left + 2 * half, middle)],
                pen.line(INK, 2),
            ))?;
            left += 2 * half + pen.offset(6);
            let kinds: Vec<&str> = regions.iter().map(|(name, _)| *name).collect();
            let words = format!("border of {}", kinds.join(" and "));
            area.draw_text(&words, &style, (left, middle))?;
            left += width(&words, pen);
        }
        for name in names {
            let half = pen.offset(6);
            let square = [(left, middle - half), (left + 2 * half, middle + half)];
            area.draw(&Rectangle::new(square, grey(name).filled()))?;
            area.draw(&Rectangle::new(square, pen.line(INK, 1)))?;
            left += 3 * half;
            area.draw_text(name, &style, (left, middle))?;
            left += width(name, pen);
        }
        Ok(())
    }
}

/// A small label on the map, on a light ground.
fn tag<DB: DrawingBackend>(
    chart: &Chart<'_, DB>,
    pen: Pen,
    text: &str,
    at: (f64, f64),
) -> Drawn<DB> {
    let area = chart.plotting_area();
    let ((x, y), (left, top)) = (area.map_coordinate(&at), area.get_base_pixel());
    let (x, y) = (x - left, y - top);
    let count = i32::try_from(text.chars().count()).unwrap_or(0);
    let (half, high) = (pen.offset(4 * count + 3), pen.offset(7));
    let plain = area.strip_coord_spec();
    plain.draw(&Rectangle::new(
        [(x - half, y - high), (x + half, y + high)],
        WHITE.mix(0.75).filled(),
    ))?;
    plain.draw_text(text, &pen.text(11, INK, HPos::Center, VPos::Center), (x, y))
}

/// How far numbers are apart at most; 1 for one.
fn extent(numbers: &[f64]) -> f64 {
    let (low, high) = span(numbers.iter().copied());
    if high > low { high - low } else { 1.0 }
}

/// Some more than the width of a text.
fn width(text: &str, pen: Pen) -> i32 {
    const CHARACTER: i32 = 7;
    let count = i32::try_from(text.chars().count()).unwrap_or(0);
    pen.offset(CHARACTER.saturating_mul(count) + 20)
}

/// The colours' meaning, with the levels of the contours.
fn draw_scale<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    pen: Pen,
    (low, high): (f64, f64),
    levels: &[f64],
) -> Drawn<DB> {
    const STEPS: i32 = 100;
    let (top, bottom) = (
        pen.offset(14),
        pen.offset((HEIGHT - HEAD).cast_signed() - 61),
    );
    let (left, right) = (pen.offset(2), pen.offset(18));
    let place = |share: f64| f64::from(bottom) - share * f64::from(bottom - top);
    for i in 0..STEPS {
        let share = |i: i32| f64::from(i) / f64::from(STEPS);
        let (from, to) = (rounded(place(share(i))), rounded(place(share(i + 1))));
        area.draw(&Rectangle::new(
            [(left, to), (right, from)],
            viridis(share(i)).filled(),
        ))?;
    }
    let style = pen.text(12, INK, HPos::Left, VPos::Center);
    for &level in levels {
        let row = rounded(place((level - low) / (high - low)));
        area.draw(&PathElement::new(
            vec![(left, row), (right, row)],
            pen.line(RGBColor(255, 255, 255), 1),
        ))?;
        area.draw_text(&tick(level), &style, (right + pen.offset(6), row))?;
    }
    Ok(())
}

/// A row of pixels; rows fit.
#[allow(clippy::cast_possible_truncation)]
fn rounded(x: f64) -> i32 {
    x.round() as i32
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
    let (Some(first), Some(last)) = (centres.first(), centres.last()) else {
        return vec![0.0, 1.0];
    };
    let [begin, end] = match centres {
        [.., a, b] => [(centres[1] - centres[0]) / 2.0, (b - a) / 2.0],
        _ => [0.5, 0.5],
    };
    let between = centres
        .windows(2)
        .map(|pair| f64::midpoint(pair[0], pair[1]));
    std::iter::once(first - begin)
        .chain(between)
        .chain(std::iter::once(last + end))
        .collect()
}

fn span_of(edges: &[f64]) -> std::ops::Range<f64> {
    edges[0]..edges[edges.len() - 1]
}
