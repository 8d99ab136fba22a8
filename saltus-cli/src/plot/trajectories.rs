//! Paths of the wheel's centre: stance solid, flight dotted.
//!
//! Source: thesis, figure 5.9.

use plotters::coord::Shift;
use plotters::element::{Circle, Cross, PathElement};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, label, padded, titled};
use super::palette::{GREY, INK, RED, viridis};

const WIDTH: u32 = 960;
/// Space (m) under the ground for the labels.
const CELLAR: f64 = 0.06;
/// Width of a label's character, and least distance between two labels.
const CHARACTER: usize = 8;
const GAP: usize = 6;
/// Distance between two dots of a flight.
const DOTS: f64 = 5.0;

/// A family of paths.
pub(crate) struct Trajectories {
    /// What they are of.
    pub(crate) title: String,
    /// What the labels under the paths are.
    pub(crate) labels: String,
    /// One for each jump.
    pub(crate) paths: Vec<Trajectory>,
    /// The wheel's radius (m).
    pub(crate) radius: f64,
}

/// One path; places (m) from the foot.
pub(crate) struct Trajectory {
    /// While the foot stands.
    pub(crate) stance: Vec<(f64, f64)>,
    /// From lift-off until the centre comes down to 0; empty without lift-off.
    pub(crate) flight: Vec<(f64, f64)>,
    /// The label.
    pub(crate) label: String,
}

impl Trajectories {
    fn axes(&self) -> Axes {
        let points = || {
            self.paths
                .iter()
                .flat_map(|path| path.stance.iter().chain(&path.flight))
                .copied()
        };
        let least = points().map(|(x, _)| x).fold(0.0, f64::min);
        let most = points().map(|(x, _)| x).fold(0.0, f64::max);
        let top = points().map(|(_, y)| y).fold(self.radius, f64::max);
        Axes {
            x: ("x (m)", padded(least, most, 0.05)),
            y: ("y (m)", -CELLAR..padded(0.0, top, 0.06).end),
        }
    }

    pub(crate) fn size(&self) -> (u32, u32) {
        (WIDTH, self.axes().equal_scale(WIDTH))
    }

    pub(crate) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let mut axes = self.axes();
        axes.equal_scale(WIDTH);
        let mut chart = axes.build(&titled(area, pen, &self.title)?, pen)?;
        let ends = [axes.x.1.start, axes.x.1.end];
        chart.draw_series([PathElement::new(
            ends.map(|x| (x, 0.0)).to_vec(),
            pen.line(INK, 2),
        )])?;
        chart.draw_series([PathElement::new(
            ends.map(|x| (x, self.radius)).to_vec(),
            pen.line(GREY, 1),
        )])?;
        let note = pen.text(12, GREY, HPos::Right, VPos::Bottom);
        label(
            &chart,
            "wheel's radius",
            &note,
            (ends[1], self.radius),
            (pen.offset(-6), pen.offset(-3)),
        )?;
        let last = self.paths.len().saturating_sub(1).max(1) as f64;
        for (i, path) in self.paths.iter().enumerate() {
            path.draw(&mut chart, pen, 0.88 * i as f64 / last)?;
        }
        chart.draw_series([Circle::new((0.0, 0.0), pen.length(4), INK.filled())])?;
        self.draw_labels(&chart, pen)
    }

    /// The labels, leaving out those that would overlap.
    fn draw_labels<DB: DrawingBackend>(&self, chart: &Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        let place =
            |path: &Trajectory| chart.plotting_area().map_coordinate(&(path.end().0, 0.0)).0;
        let mut taken: Vec<(i32, i32)> = Vec::new();
        let style = pen.text(13, INK, HPos::Center, VPos::Top);
        for path in self.paths.iter().filter(|path| !path.flight.is_empty()) {
            let x = place(path);
            let width = path.label.chars().count().saturating_mul(CHARACTER) + GAP;
            let half = pen.offset(i32::try_from(width / 2).unwrap_or(i32::MAX / 4));
            if taken
                .iter()
                .all(|(other, reach)| (x - other).abs() >= half + reach)
            {
                label(
                    chart,
                    &path.label,
                    &style,
                    (path.end().0, 0.0),
                    (0, pen.offset(7)),
                )?;
                taken.push((x, half));
            }
        }
        let words = format!(
            "stance solid, flight dotted; under each path {}",
            self.labels
        );
        let corner = chart.plotting_area().get_pixel_range();
        let at = (
            corner.0.end - pen.offset(10),
            corner.1.start + pen.offset(10),
        );
        let style = pen.text(13, INK, HPos::Right, VPos::Top);
        let (left, top) = chart.plotting_area().get_base_pixel();
        chart.plotting_area().strip_coord_spec().draw_text(
            &words,
            &style,
            (at.0 - left, at.1 - top),
        )
    }
}

impl Trajectory {
    fn end(&self) -> (f64, f64) {
        self.flight
            .last()
            .or(self.stance.last())
            .copied()
            .unwrap_or_default()
    }

    fn draw<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
        shade: f64,
    ) -> Drawn<DB> {
        let color = viridis(shade);
        chart.draw_series([PathElement::new(self.stance.clone(), pen.line(color, 3))])?;
        let dots = dots(chart, &self.flight, pen);
        chart.draw_series(
            dots.into_iter()
                .map(|at| Circle::new(at, pen.length(1), color.filled())),
        )?;
        if self.flight.is_empty() {
            chart.draw_series([Cross::new(self.end(), pen.length(5), pen.line(RED, 2))])?;
        }
        Ok(())
    }
}

/// Points along `path` at equal distances on the drawing.
pub(super) fn dots<DB: DrawingBackend>(
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
        let far = dots.last().is_none_or(|last| {
            let ((ax, ay), (bx, by)) = (pixel(last), pixel(at));
            (ax - bx).hypot(ay - by) >= spacing
        });
        if far {
            dots.push(*at);
        }
    }
    dots
}
