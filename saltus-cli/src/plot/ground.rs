//! What a course is: the ground, obstacles on it, and where to land.

use plotters::element::{PathElement, Rectangle};
use plotters::prelude::{Color, DrawingBackend, RGBColor};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Chart, Pen, label};
use super::palette::{BLUE, GREEN, INK, RED};

/// Space (m) under the ground for zones and labels.
pub(super) const CELLAR: f64 = 0.12;
/// Thickness (m) of the strips that mark zones.
const STRIP: f64 = 0.02;
/// Depth (m) of the pits that mark where no jump may land.
const PIT: f64 = 0.06;
const DARK: RGBColor = RGBColor(95, 88, 80);
const STONE: RGBColor = RGBColor(190, 180, 165);

/// A course; lengths in m.
pub(crate) struct Ground {
    /// From front to back, and top.
    pub(crate) obstacles: Vec<((f64, f64), f64)>,
    /// Where no jump may land.
    pub(crate) avoid: Vec<(f64, f64)>,
    /// Where a jump has to land.
    pub(crate) land: Vec<(f64, f64)>,
    /// Where the last jump has to land; infinite where it has no end.
    pub(crate) goal: Option<(f64, f64)>,
    /// Where the last jump should land.
    pub(crate) target: Option<f64>,
    /// What that place is called.
    pub(crate) target_name: &'static str,
    /// What a jump misses; it is drawn in red.
    pub(crate) missed: Vec<Part>,
}

/// A part of a course, each counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Obstacle(usize),
    Avoid(usize),
    Land(usize),
    Goal,
}

impl Ground {
    /// Places that must be seen: the target and the ends of all that stands and lies there.
    pub(super) fn places(&self) -> impl Iterator<Item = f64> {
        let boxes = self.obstacles.iter().map(|(span, _)| *span);
        let spans = boxes
            .chain(self.avoid.iter().copied())
            .chain(self.land.iter().copied())
            .chain(self.goal);
        let ends = spans
            .flat_map(|(from, to)| [from, to])
            .filter(|x| x.is_finite());
        self.target.into_iter().chain(ends)
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
        let edge = |part: Part| {
            let is_missed = self.missed.contains(&part);
            if is_missed {
                pen.line(RED, 3)
            } else {
                pen.line(INK, 1)
            }
        };
        for (i, &((from, to), top)) in self.obstacles.iter().enumerate() {
            let corners = [(from, 0.0), (to, top)];
            chart.draw_series([Rectangle::new(corners, STONE.filled())])?;
            chart.draw_series([Rectangle::new(corners, edge(Part::Obstacle(i)))])?;
        }
        for (i, &(from, to)) in self.avoid.iter().enumerate() {
            let corners = [(from, -PIT), (to, 0.0)];
            chart.draw_series([Rectangle::new(corners, DARK.filled())])?;
            chart.draw_series([Rectangle::new(corners, edge(Part::Avoid(i)))])?;
        }
        chart.draw_series([PathElement::new(
            vec![(ends.0, 0.0), (ends.1, 0.0)],
            pen.line(INK, 2),
        )])?;
        let zones = self
            .land
            .iter()
            .enumerate()
            .map(|(i, span)| (Part::Land(i), *span));
        for (part, (from, to)) in zones.chain(self.goal.map(|goal| (Part::Goal, goal))) {
            let row = if part == Part::Goal { 1.0 } else { 0.0 };
            let corners = [
                (from.max(ends.0), -STRIP * (row + 1.0)),
                (to.min(ends.1), -STRIP * row),
            ];
            let color = if self.missed.contains(&part) {
                RED
            } else {
                GREEN
            };
            chart.draw_series([Rectangle::new(corners, color.mix(0.4 + 0.3 * row).filled())])?;
        }
        let Some(target) = self.target else {
            return Ok(());
        };
        let mark = vec![(target, 0.0), (target, -2.0 * STRIP)];
        chart.draw_series([PathElement::new(mark, pen.line(BLUE, 2))])?;
        let style = pen.text(12, BLUE, HPos::Center, VPos::Top);
        label(
            chart,
            self.target_name,
            &style,
            (target, -2.0 * STRIP),
            (0, pen.offset(2)),
        )
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
            words += "; pale green: where a jump must land";
        }
        if self.goal.is_some() {
            words += "; green: the goal";
        }
        if !self.avoid.is_empty() {
            words += "; dark: where none may land";
        }
        if !self.missed.is_empty() {
            words += "; red: what is missed";
        }
        let plain = chart.plotting_area().strip_coord_spec();
        let right = plain.dim_in_pixel().0.cast_signed() - pen.offset(10);
        plain.draw_text(
            &words,
            &pen.text(13, INK, HPos::Right, VPos::Top),
            (right, pen.offset(8)),
        )
    }
}
