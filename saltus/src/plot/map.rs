//! Maps: one coloured cell for each approach rate and firing angle, contours over them, other outcomes than a jump in grey.

use plotters::coord::Shift;
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::{Color, DrawingArea, DrawingBackend, RGBColor};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, tick, titled};
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
        (WIDTH, TITLE + HEIGHT * u32::try_from(self.panels.len()).unwrap_or(1))
    }

    pub(crate) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
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
        let share = |value: f64| if high > low { (value - low) / (high - low) } else { 0.5 };
        let axes = Axes {
            x: ("approach rate ω (rad/s)", span_of(&x)),
            y: ("firing angle α_f (rad)", span_of(&y)),
        };
        let mut chart = axes.build(&left, pen)?;
        let height = self.angles.len();
        chart.draw_series(panel.values.iter().enumerate().map(|(i, value)| {
            let (column, row) = (i / height, i % height);
            let color = value.map_or_else(|| grey(self.outcomes[i]), |value| viridis(share(value)));
            Rectangle::new([(x[column], y[row]), (x[column + 1], y[row + 1])], color.filled())
        }))?;
        let levels = levels(low, high);
        self.draw_contours(&mut chart, pen, panel, &levels)?;
        draw_scale(&right, pen, (low, high), &levels)
    }

    fn draw_contours<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
        panel: &Panel,
        levels: &[f64],
    ) -> Drawn<DB> {
        let field = Field { x: &self.rates, y: &self.angles, values: &panel.values, kinds: &self.outcomes };
        let style = pen.line(RGBColor(255, 255, 255), 1);
        for &level in levels {
            let lines = field.segments(level).into_iter();
            chart.draw_series(lines.map(|line| PathElement::new(line.to_vec(), style)))?;
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
        for name in names {
            let half = pen.offset(6);
            let square = [(left, middle - half), (left + 2 * half, middle + half)];
            area.draw(&Rectangle::new(square, grey(name).filled()))?;
            area.draw(&Rectangle::new(square, pen.line(INK, 1)))?;
            let words = if matches!(name, "stroke" | "force") { "does not get there" } else { name };
            left += 3 * half;
            area.draw_text(words, &style, (left, middle))?;
            left += width(words, pen);
        }
        Ok(())
    }
}

/// Some more than the width of a text.
fn width(text: &str, pen: Pen) -> i32 {
    const CHARACTER: i32 = 8;
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
    let (top, bottom) = (pen.offset(14), pen.offset((HEIGHT - HEAD).cast_signed() - 61));
    let (left, right) = (pen.offset(2), pen.offset(18));
    let place = |share: f64| f64::from(bottom) - share * f64::from(bottom - top);
    for i in 0..STEPS {
        let share = |i: i32| f64::from(i) / f64::from(STEPS);
        let (from, to) = (rounded(place(share(i))), rounded(place(share(i + 1))));
        area.draw(&Rectangle::new([(left, to), (right, from)], viridis(share(i)).filled()))?;
    }
    let style = pen.text(12, INK, HPos::Left, VPos::Center);
    for &level in levels {
        let row = rounded(place((level - low) / (high - low)));
        area.draw(&PathElement::new(vec![(left, row), (right, row)], pen.line(RGBColor(255, 255, 255), 1)))?;
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
        "stroke" | "force" => 235,
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
    let (Some(first), Some(last)) = (centres.first(), centres.last()) else { return vec![0.0, 1.0] };
    let [begin, end] = match centres {
        [.., a, b] => [(centres[1] - centres[0]) / 2.0, (b - a) / 2.0],
        _ => [0.5, 0.5],
    };
    let between = centres.windows(2).map(|pair| f64::midpoint(pair[0], pair[1]));
    std::iter::once(first - begin).chain(between).chain(std::iter::once(last + end)).collect()
}

fn span_of(edges: &[f64]) -> std::ops::Range<f64> {
    edges[0]..edges[edges.len() - 1]
}
