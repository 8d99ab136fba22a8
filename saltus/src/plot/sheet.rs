//! Several charts of lines under one title.

use plotters::coord::Shift;
use plotters::element::{Circle, DashedPathElement, PathElement};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Pen, padded, titled};
use super::curves::span;
use super::palette::INK;

const WIDTH: u32 = 1000;
/// Height of a chart with its title.
const PANEL: u32 = 330;
const TITLE: u32 = 40;

/// Charts, two in a row.
pub(crate) struct Sheet {
    pub(crate) title: String,
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
        (WIDTH, rows * PANEL + TITLE)
    }

    pub(crate) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
        let rest = titled(area, pen, &self.title)?;
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
        let rows = self.lines.iter().filter(|line| line.label.is_some()).count();
        let top = y.1 + (y.1 - y.0) * 0.08 * rows.min(5) as f64;
        let axes = Axes { x: (self.x, padded(x.0, x.1, 0.03)), y: (self.y, padded(y.0, top, 0.06)) };
        let mut chart = axes.build(&rest, pen)?;
        for line in &self.lines {
            let stroke = pen.line(line.color, 2);
            let points = line.points.iter().copied();
            match line.mark {
                Mark::Solid => {
                    chart.draw_series([PathElement::new(line.points.clone(), stroke)])?;
                }
                Mark::Dashed => {
                    let (dash, gap) = (pen.length(6), pen.length(4));
                    chart.draw_series([DashedPathElement::new(points, dash, gap, stroke)])?;
                }
                Mark::Dots => {
                    let dots = points.map(|at| Circle::new(at, pen.length(3), line.color.mix(0.6).filled()));
                    chart.draw_series(dots)?;
                }
            }
        }
        // The key, top right, inside.
        let (right, top) = (chart.plotting_area().get_x_range(), chart.plotting_area().get_y_range());
        let corner = chart.plotting_area().map_coordinate(&(right.end, top.end));
        let base = chart.plotting_area().get_base_pixel();
        let plain = chart.plotting_area().strip_coord_spec();
        for (row, line) in self.lines.iter().filter(|line| line.label.is_some()).enumerate() {
            let Some(label) = &line.label else { continue };
            let style = pen.text(12, line.color, HPos::Right, VPos::Top);
            let place = (
                corner.0 - base.0 - pen.offset(6),
                corner.1 - base.1 + pen.offset(4 + 15 * i32::try_from(row).unwrap_or(0)),
            );
            plain.draw_text(label, &style, place)?;
        }
        Ok(())
    }
}
