//! Plans of the hopper on their courses, one under the other.

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, label, padded, titled};
use super::ground::{CELLAR, Ground};
use super::palette::{BLUE, GREY, INK};
use super::trajectories::dots;

const WIDTH: u32 = 1100;
/// Share of a panel's height above the highest arc: for labels and the key.
const HEADROOM: f64 = 0.25;

/// Courses with their plans.
pub(crate) struct Hops {
    pub(crate) panels: Vec<Panel>,
}

/// One course and the plan on it; lengths in m.
pub(crate) struct Panel {
    pub(crate) title: String,
    /// The first foothold.
    pub(crate) start: (f64, f64),
    pub(crate) ground: Ground,
    pub(crate) hops: Vec<Hop>,
}

/// One jump.
pub(crate) struct Hop {
    pub(crate) foot: (f64, f64),
    /// The hip at take-off.
    pub(crate) hip: (f64, f64),
    /// The foot from take-off to landing, and the knee.
    pub(crate) arc: Vec<(f64, f64)>,
    pub(crate) knee: Vec<(f64, f64)>,
    /// Two lines over the arc.
    pub(crate) label: [String; 2],
}

impl Hops {
    /// Most panels of a drawing.
    pub(crate) const MOST: usize = 12;

    pub(crate) fn size(&self) -> (u32, u32) {
        (WIDTH, self.panels.iter().map(Panel::height).sum())
    }

    pub(crate) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let mut rest = area.clone();
        for panel in &self.panels {
            let (here, below) = rest.split_vertically(pen.length(panel.height()));
            panel.draw(&here, pen)?;
            rest = below;
        }
        Ok(())
    }
}

impl Panel {
    fn axes(&self) -> Axes {
        let points = || {
            self.hops
                .iter()
                .flat_map(|hop| hop.arc.iter().chain(&hop.knee))
                .copied()
        };
        let places = || points().map(|(x, _)| x).chain(self.ground.places());
        let least = places().fold(self.start.0, f64::min);
        let most = places().fold(self.start.0, f64::max);
        let top = points()
            .map(|(_, y)| y)
            .chain(self.ground.tops())
            .fold(0.2, f64::max);
        Axes {
            x: ("x (m)", padded(least, most, 0.05)),
            y: ("y (m)", -CELLAR..(1.0 + HEADROOM) * top),
        }
    }

    fn height(&self) -> u32 {
        self.axes().equal_scale(WIDTH)
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
        let mut axes = self.axes();
        axes.equal_scale(WIDTH);
        let mut chart = axes.build(&titled(area, pen, &self.title)?, pen)?;
        self.ground
            .draw(&mut chart, pen, (axes.x.1.start, axes.x.1.end))?;
        for hop in &self.hops {
            hop.draw(&mut chart, pen)?;
        }
        chart.draw_series([Circle::new(self.start, pen.length(4), INK.filled())])?;
        let style = pen.text(12, INK, HPos::Center, VPos::Top);
        label(
            &chart,
            "start",
            &style,
            (self.start.0, 0.0),
            (0, pen.offset(9)),
        )?;
        self.ground.draw_key(
            &chart,
            pen,
            "leg at take-off black, foot in flight dotted, knee grey",
        )
    }
}

impl Hop {
    fn draw<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        chart.draw_series([PathElement::new(self.knee.clone(), pen.line(GREY, 1))])?;
        chart.draw_series([PathElement::new(
            vec![self.foot, self.hip],
            pen.line(INK, 3),
        )])?;
        let dots = dots(chart, &self.arc, pen);
        chart.draw_series(
            dots.into_iter()
                .map(|at| Circle::new(at, pen.length(1), BLUE.filled())),
        )?;
        let ends = [Some(&self.foot), self.arc.last()].into_iter().flatten();
        chart.draw_series(ends.map(|at| Circle::new(*at, pen.length(3), BLUE.filled())))?;
        let highest = |path: &[(f64, f64)]| path.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let (Some(foot), Some(knee)) = (highest(&self.arc), highest(&self.knee)) else {
            return Ok(());
        };
        let above = (f64::midpoint(foot.0, knee.0), foot.1.max(knee.1));
        let style = pen.text(12, INK, HPos::Center, VPos::Bottom);
        for (line, rise) in self.label.iter().rev().zip([-5, -20]) {
            label(chart, line, &style, above, (0, pen.offset(rise)))?;
        }
        Ok(())
    }
}
