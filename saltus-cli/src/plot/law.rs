//! Linear laws: exact and fitted firing angles over the approach rate, and what is left between
//! them.

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement};
use plotters::prelude::{Color, DrawingArea, DrawingBackend, RGBColor};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, notice, padded, titled};
use super::curves::span;
use super::palette::{BLUE, GREY, INK, viridis};

const WIDTH: u32 = 900;
const ANGLES: u32 = 460;
const RESIDUALS: u32 = 240;

/// Laws of some targets.
pub(crate) struct LawPlot {
    pub(crate) title: String,
    pub(crate) lines: Vec<Line>,
    /// What is said where there is no law.
    pub(crate) empty: String,
}

/// One law: rate (rad/s), exact and fitted angle (rad) of each point.
pub(crate) struct Line {
    pub(crate) label: String,
    pub(crate) points: Vec<(f64, f64, f64)>,
}

impl LawPlot {
    pub(crate) const SIZE: (u32, u32) = (WIDTH, ANGLES + RESIDUALS);

    pub(crate) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let (upper, lower) = area.split_vertically(pen.length(ANGLES));
        let all = || self.lines.iter().flat_map(|line| &line.points);
        let (low, high) = span(all().map(|p| p.0));
        let rates = padded(low, high, 0.04);
        let (low, high) = span(all().flat_map(|p| [p.1, p.2]));
        // Room for a label of each line on top.
        let angles = padded(
            low,
            high + 0.07 * self.lines.len() as f64 * (high - low).max(1e-3),
            0.08,
        );
        let axes = Axes {
            x: ("approach rate ω (rad/s)", rates.clone()),
            y: ("firing angle α_f (rad)", angles),
        };
        let mut chart = axes.build(&titled(&upper, pen, &self.title)?, pen)?;
        self.draw_angles(&mut chart, pen)?;
        if self.lines.is_empty() {
            return notice(&chart, pen, &self.empty);
        }
        self.draw_labels(&chart, pen)?;

        let most = all().map(|p| 1e3 * (p.2 - p.1).abs()).fold(1e-6, f64::max);
        let axes = Axes {
            x: ("approach rate ω (rad/s)", rates.clone()),
            y: ("residual (mrad)", padded(-most, most, 0.15)),
        };
        let mut chart = axes.build(&lower, pen)?;
        chart.draw_series([PathElement::new(
            vec![(rates.start, 0.0), (rates.end, 0.0)],
            pen.line(GREY, 1),
        )])?;
        self.draw_residuals(&mut chart, pen)
    }

    fn color(&self, i: usize) -> RGBColor {
        match self.lines.len() {
            1 => BLUE,
            count => viridis(0.85 * i as f64 / (count - 1) as f64),
        }
    }

    fn draw_angles<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        for (i, line) in self.lines.iter().enumerate() {
            let color = self.color(i);
            let fitted = line.points.iter().map(|p| (p.0, p.2)).collect::<Vec<_>>();
            chart.draw_series([PathElement::new(fitted, pen.line(color, 2))])?;
            chart.draw_series(
                line.points
                    .iter()
                    .map(|p| Circle::new((p.0, p.1), pen.length(4), color.filled())),
            )?;
        }
        Ok(())
    }

    fn draw_residuals<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        for (i, line) in self.lines.iter().enumerate() {
            let color = self.color(i);
            let residual = |p: &(f64, f64, f64)| (p.0, 1e3 * (p.2 - p.1));
            let stem =
                |p| PathElement::new(vec![(residual(p).0, 0.0), residual(p)], pen.line(color, 1));
            chart.draw_series(line.points.iter().map(stem))?;
            chart.draw_series(
                line.points
                    .iter()
                    .map(|p| Circle::new(residual(p), pen.length(3), color.filled())),
            )?;
        }
        Ok(())
    }

    /// A key in the upper right corner.
    fn draw_labels<DB: DrawingBackend>(&self, chart: &Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        let plain = chart.plotting_area().strip_coord_spec();
        let right = plain.dim_in_pixel().0.cast_signed() - pen.offset(12);
        let note = |text: &str, color: RGBColor, row: i32| {
            let style = pen.text(13, color, HPos::Right, VPos::Top);
            plain.draw_text(text, &style, (right, pen.offset(8 + 18 * row)))
        };
        note("dots exact, lines fitted", INK, 0)?;
        for ((i, line), row) in self.lines.iter().enumerate().zip(1..) {
            note(&line.label, self.color(i), row)?;
        }
        Ok(())
    }
}
