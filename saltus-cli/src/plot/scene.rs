//! A plan on its course: obstacles, and the wheel along its path.

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Polygon};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, label, padded, titled};
use super::ground::{CELLAR, Ground};
use super::palette::{BLUE, GREY, INK, RED};
use super::trajectories::dots;

const WIDTH: u32 = 1100;
/// Wheels drawn along a flight.
const WHEELS: usize = 6;

/// A course and the plan on it; lengths in m.
pub(crate) struct Scene {
    pub(crate) title: String,
    /// What the plan misses, line by line.
    pub(crate) missed: Vec<String>,
    pub(crate) radius: f64,
    pub(crate) start: (f64, f64),
    pub(crate) ground: Ground,
    pub(crate) leaps: Vec<Leap>,
}

/// One jump.
pub(crate) struct Leap {
    pub(crate) foot: (f64, f64),
    /// The wheel's centre while the foot stands, and from lift-off to landing.
    pub(crate) stance: Vec<(f64, f64)>,
    pub(crate) flight: Vec<(f64, f64)>,
    /// Whether it misses a limit.
    pub(crate) fails: bool,
    pub(crate) label: String,
}

impl Scene {
    fn axes(&self) -> Axes {
        let centres = || {
            self.leaps
                .iter()
                .flat_map(|leap| leap.stance.iter().chain(&leap.flight))
                .copied()
        };
        let sides = centres().flat_map(|(x, _)| [x - self.radius, x + self.radius]);
        let places = [self.start.0 - self.radius, self.start.0 + self.radius];
        let all: Vec<f64> = sides.chain(places).chain(self.ground.places()).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let tops = centres()
            .map(|(_, y)| y + self.radius)
            .chain(self.ground.tops());
        let top = tops.fold(3.0 * self.radius, f64::max);
        Axes {
            x: ("x (m)", padded(least, most, 0.03)),
            y: ("y (m)", -CELLAR..1.05 * top),
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
        self.ground
            .draw(&mut chart, pen, (axes.x.1.start, axes.x.1.end))?;
        for leap in &self.leaps {
            self.draw_leap(&mut chart, pen, leap)?;
        }
        let style = pen.text(13, RED, HPos::Left, VPos::Top);
        for (line, row) in self.missed.iter().zip(0..) {
            let place = (pen.offset(8), pen.offset(26 + 16 * row));
            chart
                .plotting_area()
                .strip_coord_spec()
                .draw_text(line, &style, place)?;
        }
        self.ground
            .draw_key(&chart, pen, "wheel's centre: stance solid, flight dotted")
    }

    fn draw_leap<DB: DrawingBackend>(
        &self,
        chart: &mut Chart<'_, DB>,
        pen: Pen,
        leap: &Leap,
    ) -> Drawn<DB> {
        let color = if leap.fails { RED } else { BLUE };
        let last = leap.flight.len().saturating_sub(1);
        for i in 0..=WHEELS {
            let Some(&centre) = leap.flight.get(i * last / WHEELS) else {
                continue;
            };
            let end = i == 0 || i == WHEELS;
            let disc = disc(centre, self.radius);
            chart.draw_series([Polygon::new(
                disc.clone(),
                color.mix(if end { 0.10 } else { 0.05 }).filled(),
            )])?;
            chart.draw_series([PathElement::new(
                disc,
                pen.line(if end { INK } else { GREY }, 1),
            )])?;
        }
        if let Some(&lift_off) = leap.stance.last() {
            chart.draw_series([PathElement::new(
                vec![leap.foot, lift_off],
                pen.line(INK, 3),
            )])?;
        }
        chart.draw_series([PathElement::new(leap.stance.clone(), pen.line(color, 3))])?;
        let dots = dots(chart, &leap.flight, pen);
        chart.draw_series(
            dots.into_iter()
                .map(|at| Circle::new(at, pen.length(1), color.filled())),
        )?;
        chart.draw_series([Circle::new(leap.foot, pen.length(4), INK.filled())])?;
        let apex = leap
            .flight
            .iter()
            .copied()
            .max_by(|a, b| a.1.total_cmp(&b.1));
        let style = pen.text(12, INK, HPos::Center, VPos::Bottom);
        apex.map_or(Ok(()), |apex| {
            label(
                chart,
                &leap.label.replace('-', "−"),
                &style,
                apex,
                (0, pen.offset(-6)),
            )
        })
    }
}

/// The rim of a wheel.
fn disc((x, y): (f64, f64), radius: f64) -> Vec<(f64, f64)> {
    const SIDES: u32 = 72;
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(SIDES);
    (0..=SIDES)
        .map(turn)
        .map(|angle| (x + radius * angle.cos(), y + radius * angle.sin()))
        .collect()
}
