//! One line of a chart.

use plotters::element::{Circle, DashedPathElement, PathElement};
use plotters::prelude::{Color, DrawingBackend};
use plotters::style::RGBColor;

use super::Drawn;
use super::axes::{Chart, Pen};

/// Width of a sheet.
pub(super) const WIDTH: u32 = 1000;

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
