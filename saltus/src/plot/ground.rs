//! What a course is: the ground, obstacles on it, and where to land.

use plotters::element::{PathElement, Rectangle};
use plotters::prelude::{Color, DrawingBackend, RGBColor};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Chart, Pen, label};
use super::palette::{BLUE, INK, RED};

/// Space (m) under the ground for zones and labels.
pub(super) const CELLAR: f64 = 0.12;
/// Thickness (m) of the strips that mark zones.
const STRIP: f64 = 0.02;
const GREEN: RGBColor = RGBColor(60, 150, 80);
const STONE: RGBColor = RGBColor(190, 180, 165);

/// A course; lengths in m.
pub(crate) struct Ground {
    /// From front to back, and top.
    pub(crate) obstacles: Vec<((f64, f64), f64)>,
    /// Where no jump may land.
    pub(crate) avoid: Vec<(f64, f64)>,
    /// Where a jump has to land.
    pub(crate) land: Vec<(f64, f64)>,
    /// Where the last jump should land.
    pub(crate) target: f64,
    /// What that place is called.
    pub(crate) target_name: &'static str,
}

impl Ground {
    /// Places that must be seen: the target and the ends of the obstacles.
    pub(super) fn places(&self) -> impl Iterator<Item = f64> {
        let edges = self.obstacles.iter().flat_map(|((from, to), _)| [*from, *to]);
        std::iter::once(self.target).chain(edges)
    }

    /// Heights of the obstacles.
    pub(super) fn tops(&self) -> impl Iterator<Item = f64> {
        self.obstacles.iter().map(|(_, top)| *top)
    }

    /// Draws it from one end of the chart to the other.
    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
        ends: (f64, f64),
    ) -> Drawn<DB> {
        let corners = |((from, to), top): ((f64, f64), f64)| [(from, 0.0), (to, top)];
        for style in [STONE.filled(), pen.line(INK, 1)] {
            chart.draw_series(self.obstacles.iter().map(|it| Rectangle::new(corners(*it), style)))?;
        }
        let strip = |(from, to): (f64, f64), color: RGBColor| {
            Rectangle::new([(from, -STRIP), (to, 0.0)], color.mix(0.7).filled())
        };
        chart.draw_series(self.avoid.iter().map(|zone| strip(*zone, RED)))?;
        chart.draw_series(self.land.iter().map(|zone| strip(*zone, GREEN)))?;
        chart.draw_series([PathElement::new(vec![(ends.0, 0.0), (ends.1, 0.0)], pen.line(INK, 2))])?;
        let mark = vec![(self.target, 0.0), (self.target, -2.0 * STRIP)];
        chart.draw_series([PathElement::new(mark, pen.line(BLUE, 2))])?;
        let style = pen.text(12, BLUE, HPos::Center, VPos::Top);
        label(chart, self.target_name, &style, (self.target, -2.0 * STRIP), (0, pen.offset(2)))
    }

    /// Writes the key in the upper right corner: `words`, and what the zones' colours say.
    pub(super) fn draw_key<DB: DrawingBackend>(
        &self,
        chart: &Chart<'_, DB>,
        pen: Pen,
        words: &str,
    ) -> Drawn<DB> {
        let mut words = words.to_owned();
        if !self.land.is_empty() {
            words += "; green: where a jump must land";
        }
        if !self.avoid.is_empty() {
            words += "; red: where none may land";
        }
        let plain = chart.plotting_area().strip_coord_spec();
        let right = plain.dim_in_pixel().0.cast_signed() - pen.offset(10);
        plain.draw_text(&words, &pen.text(13, INK, HPos::Right, VPos::Top), (right, pen.offset(8)))
    }
}
