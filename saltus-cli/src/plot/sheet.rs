//! Several charts of lines under one title.

use plotters::coord::Shift;
use plotters::element::{Circle, DashedPathElement, PathElement};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, key, padded, titled};
use super::curves::span;
use super::flown::Flown;
use super::palette::INK;

pub(super) const WIDTH: u32 = 1000;
/// Height of a chart with its title.
const PANEL: u32 = 330;
const TITLE: u32 = 40;

/// A course over the whole width, if there is one, and charts below, two in a row.
pub(crate) struct Sheet {
    pub(crate) title: String,
    pub(crate) course: Option<Flown>,
    pub(crate) panels: Vec<Panel>,
}

/// One chart.
pub(crate) struct Panel {
    pub(crate) title: String,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) lines: Vec<Line>,
}

/// One line, or dots.
pub(crate) struct Line {
    /// What the key calls it, if it stands there.
    pub(crate) label: Option<String>,
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) color: RGBColor,
    pub(crate) mark: Mark,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Mark {
    Solid,
    Dashed,
    Dots,
}

impl Sheet {
    pub(crate) fn size(&self) -> (u32, u32) {
        let rows = u32::try_from(self.panels.len().div_ceil(2)).unwrap_or(1);
        (
            WIDTH,
            rows * PANEL + TITLE + self.course.as_ref().map_or(0, Flown::height),
        )
    }

    pub(crate) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let mut rest = titled(area, pen, &self.title)?;
        if let Some(course) = &self.course {
            let (top, below) = rest.split_vertically(pen.length(course.height()));
            course.draw(&top, pen)?;
            rest = below;
        }
        let parts = rest.split_evenly((self.panels.len().div_ceil(2), 2));
        for (panel, part) in self.panels.iter().zip(&parts) {
            panel.draw(part, pen)?;
        }
        Ok(())
    }
}

impl Panel {
    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
        const SIZE: u32 = 13;
        let (line, rest) = area.split_vertically(pen.length(24));
        let style = pen.text(SIZE, INK, HPos::Left, VPos::Center);
        line.draw_text(&self.title, &style, (pen.offset(16), pen.offset(14)))?;
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let (x, y) = (span(points().map(|p| p.0)), span(points().map(|p| p.1)));
        // The key has room above.
        let rows = self
            .lines
            .iter()
            .filter(|line| line.label.is_some())
            .count();
        let top = y.1 + (y.1 - y.0) * 0.08 * rows.min(5) as f64;
        let axes = Axes {
            x: (self.x, padded(x.0, x.1, 0.03)),
            y: (self.y, padded(y.0, top, 0.06)),
        };
        let mut chart = axes.build(&rest, pen)?;
        for line in &self.lines {
            line.draw(&mut chart, pen)?;
        }
        key(&chart, pen, self.lines.iter().filter_map(Line::entry))
    }
}

impl Line {
    /// What the key says of it.
    pub(super) fn entry(&self) -> Option<(&str, RGBColor)> {
        self.label.as_deref().map(|label| (label, self.color))
    }

    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
    ) -> Drawn<DB> {
        let stroke = pen.line(self.color, 2);
        let points = self.points.iter().copied();
        match self.mark {
            Mark::Solid => {
                chart.draw_series([PathElement::new(self.points.clone(), stroke)])?;
            }
            Mark::Dashed => {
                let (dash, gap) = (pen.length(6), pen.length(4));
                chart.draw_series([DashedPathElement::new(points, dash, gap, stroke)])?;
            }
            Mark::Dots => {
                let dots =
                    points.map(|at| Circle::new(at, pen.length(3), self.color.mix(0.6).filled()));
                chart.draw_series(dots)?;
            }
        }
        Ok(())
    }
}
