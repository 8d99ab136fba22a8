//! What is drawn on a chart.

use plotters::element::{Circle, Cross, DashedPathElement, PathElement, Polygon, Rectangle};
use plotters::prelude::{Color, DrawingBackend};
use plotters::style::RGBColor;

use super::Drawn;
use super::axes::{Chart, Pen};

/// Distance between two dots of a dotted line.
const DOTS: f64 = 5.0;

/// A line, or dots, or an area.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    /// What the key calls it, if it stands there.
    pub(crate) label: Option<String>,
    /// What is beyond the ends of the chart ends there.
    pub(crate) points: Vec<(f64, f64)>,
    pub(crate) color: RGBColor,
    pub(crate) mark: Mark,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Mark {
    Solid,
    /// Of another width.
    Stroke(u32),
    Dashed,
    /// Dots at equal distances on the drawing.
    Dotted,
    /// A pale dot at each point.
    Dots,
    /// A disc of this radius at each point.
    Disc(u32),
    Cross,
    /// The rectangle between two points, of this opacity.
    Area(f64),
    /// Its rim, of this width.
    Rim(u32),
    /// The shape with these corners, of this opacity.
    Shape(f64),
}

impl Line {
    /// One that is not in the key.
    pub(crate) fn new(
        mark: Mark,
        color: RGBColor,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Line {
        Line {
            label: None,
            points: points.into_iter().collect(),
            color,
            mark,
        }
    }

    /// Words in the key without a line.
    pub(crate) fn note(words: impl Into<String>, color: RGBColor) -> Line {
        Line::new(Mark::Solid, color, []).called(words)
    }

    /// The same with this name in the key.
    pub(crate) fn called(self, label: impl Into<String>) -> Line {
        Line {
            label: Some(label.into()),
            ..self
        }
    }

    /// What the key says of it.
    pub(super) fn entry(&self) -> Option<(&str, RGBColor)> {
        self.label.as_deref().map(|label| (label, self.color))
    }

    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
    ) -> Drawn<DB> {
        let ends = chart.x_range();
        let inside = |&(x, y): &(f64, f64)| (x.clamp(ends.start, ends.end), y);
        let points: Vec<(f64, f64)> = self.points.iter().map(inside).collect();
        let filled = |opacity: f64| self.color.mix(opacity).filled();
        let stroke = |width| pen.line(self.color, width);
        match self.mark {
            Mark::Solid => {
                chart.draw_series([PathElement::new(points, stroke(2))])?;
            }
            Mark::Stroke(width) => {
                chart.draw_series([PathElement::new(points, stroke(width))])?;
            }
            Mark::Dashed => {
                let (dash, gap, points) = (pen.length(6), pen.length(4), points.into_iter());
                chart.draw_series([DashedPathElement::new(points, dash, gap, stroke(2))])?;
            }
            Mark::Dots | Mark::Dotted | Mark::Disc(_) => {
                let (radius, opacity, points) = match self.mark {
                    Mark::Disc(radius) => (radius, 1.0, points),
                    Mark::Dotted => (1, 1.0, spaced(chart, &points, pen)),
                    _ => (3, 0.6, points),
                };
                let (radius, style) = (pen.length(radius), filled(opacity));
                chart.draw_series(points.into_iter().map(|at| Circle::new(at, radius, style)))?;
            }
            Mark::Cross => {
                let cross = |at| Cross::new(at, pen.length(5), stroke(2));
                chart.draw_series(points.into_iter().map(cross))?;
            }
            Mark::Area(opacity) => {
                let corners = [points[0], points[1]];
                chart.draw_series([Rectangle::new(corners, filled(opacity))])?;
            }
            Mark::Rim(width) => {
                let corners = [points[0], points[1]];
                chart.draw_series([Rectangle::new(corners, stroke(width))])?;
            }
            Mark::Shape(opacity) => {
                chart.draw_series([Polygon::new(points, filled(opacity))])?;
            }
        }
        Ok(())
    }
}

/// Points along `path` at equal distances on the drawing.
fn spaced<DB: DrawingBackend>(
    chart: &Chart<'_, DB>,
    path: &[(f64, f64)],
    pen: Pen,
) -> Vec<(f64, f64)> {
    let pixel = |at: &(f64, f64)| {
        let (x, y) = chart.plotting_area().map_coordinate(at);
        (f64::from(x), f64::from(y))
    };
    let spacing = DOTS * f64::from(pen.length(1));
    let mut dots: Vec<(f64, f64)> = Vec::new();
    for at in path {
        let is_far = dots.last().is_none_or(|last| {
            let ((ax, ay), (bx, by)) = (pixel(last), pixel(at));
            (ax - bx).hypot(ay - by) >= spacing
        });
        dots.extend(is_far.then_some(*at));
    }
    dots
}
