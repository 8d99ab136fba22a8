//! Curves over one axis, each with a label: firing angles over approach rates.

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, key, label, notice, padded, titled};
use super::palette::{INK, viridis};
use crate::plot::axes::Pen;

/// Curves, with their axes.
pub(crate) struct Curves {
    pub(crate) title: String,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) lines: Vec<Curve>,
    /// What tells both branches of the curves apart, where there are two.
    pub(crate) late: &'static str,
    /// What is said where there is no curve.
    pub(crate) empty: String,
}

/// One curve; where there is no value it is interrupted.
pub(crate) struct Curve {
    pub(crate) label: String,
    pub(crate) points: Vec<(f64, Option<f64>)>,
    /// Its second branch, which is drawn thin.
    pub(crate) late: Vec<(f64, Option<f64>)>,
}

impl Curves {
    pub(crate) const SIZE: (u32, u32) = (900, 620);

    pub(crate) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let all = || {
            self.lines
                .iter()
                .flat_map(|curve| curve.points.iter().chain(&curve.late))
        };
        let x = span(all().map(|(x, _)| *x));
        let y = span(all().filter_map(|(_, y)| *y));
        // Room for the labels on the right.
        let x = padded(x.0, x.1 + 0.1 * (x.1 - x.0), 0.03);
        let axes = Axes {
            x: (self.x, x),
            y: (self.y, padded(y.0, y.1, 0.06)),
        };
        let mut chart = axes.build(&titled(area, pen, &self.title)?, pen)?;
        let last = self.lines.len().saturating_sub(1).max(1) as f64;
        let mut taken: Vec<i32> = Vec::new();
        for (i, curve) in self.lines.iter().enumerate() {
            let color = viridis(0.88 * i as f64 / last);
            for run in runs(&curve.late) {
                chart.draw_series([PathElement::new(run, pen.line(color, 1))])?;
            }
            for run in runs(&curve.points) {
                chart.draw_series([PathElement::new(run.clone(), pen.line(color, 3))])?;
                if curve.points.len() <= 30 {
                    let dots = run
                        .into_iter()
                        .map(|at| Circle::new(at, pen.length(3), color.filled()));
                    chart.draw_series(dots)?;
                }
            }
            let Some(end) = runs(&curve.points)
                .last()
                .and_then(|run| run.last().copied())
            else {
                continue;
            };
            let row = chart.plotting_area().map_coordinate(&end).1;
            if taken
                .iter()
                .all(|other| (row - other).abs() >= pen.offset(14))
            {
                let style = pen.text(12, color, HPos::Left, VPos::Center);
                label(&chart, &curve.label, &style, end, (pen.offset(7), 0))?;
                taken.push(row);
            }
        }
        if all().all(|(_, y)| y.is_none()) {
            notice(&chart, pen, &self.empty)?;
        } else if self
            .lines
            .iter()
            .any(|curve| curve.late.iter().any(|(_, y)| y.is_some()))
        {
            key(&chart, pen, [(self.late, INK)].into_iter())?;
        }
        Ok(())
    }
}

/// The parts of a curve without an interruption.
fn runs(points: &[(f64, Option<f64>)]) -> Vec<Vec<(f64, f64)>> {
    let mut runs = vec![Vec::new()];
    for &(x, y) in points {
        match (y, runs.last_mut()) {
            (Some(y), Some(run)) => run.push((x, y)),
            (None, Some(run)) if !run.is_empty() => runs.push(Vec::new()),
            _ => {}
        }
    }
    runs.retain(|run| !run.is_empty());
    runs
}

/// Least and greatest of some numbers; 0 and 1 without any.
pub(crate) fn span(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    if low <= high { (low, high) } else { (0.0, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_interrupt_a_curve() {
        let points = vec![
            (0.0, None),
            (1.0, Some(1.0)),
            (2.0, Some(2.0)),
            (3.0, None),
            (4.0, None),
            (5.0, Some(5.0)),
        ];
        assert_eq!(
            runs(&points),
            [vec![(1.0, 1.0), (2.0, 2.0)], vec![(5.0, 5.0)]]
        );
    }
}
