//! Several charts of lines under one title.

use plotters::coord::Shift;
use plotters::prelude::{DrawingArea, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Pen, key, padded, titled};
use super::curves::span;
use super::flown::Flown;
use super::line::{Line, WIDTH};
use super::palette::INK;

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
    /// What the axes span at least: from and to along, from and to up.
    pub(crate) least: Option<[[f64; 2]; 2]>,
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
        let [along, up] = self.least.map_or([None; 2], |least| least.map(Some));
        let x = span(points().map(|p| p.0).chain(along.into_iter().flatten()));
        let y = span(points().map(|p| p.1).chain(up.into_iter().flatten()));
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
