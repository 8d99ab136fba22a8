//! A plan on its course: obstacles, and the wheel along its path.

use plotters::coord::Shift;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::prelude::{Color, DrawingArea, DrawingBackend, RGBColor};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, Pen, label, padded, titled};
use super::palette::{BLUE, GREY, INK, RED};
use super::trajectories::dots;

const WIDTH: u32 = 1100;
/// Space (m) under the ground for zones and labels.
const CELLAR: f64 = 0.12;
/// Thickness (m) of the strips that mark zones.
const STRIP: f64 = 0.02;
/// Wheels drawn along a flight.
const WHEELS: usize = 6;
const GREEN: RGBColor = RGBColor(60, 150, 80);
const STONE: RGBColor = RGBColor(190, 180, 165);

/// A course and the plan on it; lengths in m.
pub(crate) struct Scene {
    pub(crate) title: String,
    pub(crate) radius: f64,
    pub(crate) start: (f64, f64),
    /// From front to back, and top.
    pub(crate) obstacles: Vec<((f64, f64), f64)>,
    /// Where no jump may land.
    pub(crate) avoid: Vec<(f64, f64)>,
    /// Where a jump has to land.
    pub(crate) land: Vec<(f64, f64)>,
    /// Where the last jump should land.
    pub(crate) target: f64,
    pub(crate) leaps: Vec<Leap>,
}

/// One jump.
pub(crate) struct Leap {
    pub(crate) foot: (f64, f64),
    /// The wheel's centre while the foot stands, and from lift-off to landing.
    pub(crate) stance: Vec<(f64, f64)>,
    pub(crate) flight: Vec<(f64, f64)>,
    pub(crate) label: String,
}

impl Scene {
    fn axes(&self) -> Axes {
        let centres = || self.leaps.iter().flat_map(|leap| leap.stance.iter().chain(&leap.flight)).copied();
        let sides = centres().flat_map(|(x, _)| [x - self.radius, x + self.radius]);
        let places = [self.start.0 - self.radius, self.start.0 + self.radius, self.target];
        let edges = self.obstacles.iter().flat_map(|((from, to), _)| [*from, *to]);
        let all: Vec<f64> = sides.chain(places).chain(edges).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        let most = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let tops = self.obstacles.iter().map(|(_, top)| *top);
        let top = centres().map(|(_, y)| y + self.radius).chain(tops).fold(3.0 * self.radius, f64::max);
        Axes { x: ("x (m)", padded(least, most, 0.03)), y: ("y (m)", -CELLAR..1.05 * top) }
    }

    pub(crate) fn size(&self) -> (u32, u32) {
        (WIDTH, self.axes().equal_scale(WIDTH))
    }

    pub(crate) fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
        let mut axes = self.axes();
        axes.equal_scale(WIDTH);
        let mut chart = axes.build(&titled(area, pen, &self.title)?, pen)?;
        self.draw_ground(&mut chart, pen, (axes.x.1.start, axes.x.1.end))?;
        for leap in &self.leaps {
            self.draw_leap(&mut chart, pen, leap)?;
        }
        self.draw_key(&chart, pen)
    }

    fn draw_ground<DB: DrawingBackend>(
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
        label(chart, "target", &style, (self.target, -2.0 * STRIP), (0, pen.offset(2)))
    }

    fn draw_leap<DB: DrawingBackend>(&self, chart: &mut Chart<'_, DB>, pen: Pen, leap: &Leap) -> Drawn<DB> {
        let last = leap.flight.len().saturating_sub(1);
        for i in 0..=WHEELS {
            let Some(&centre) = leap.flight.get(i * last / WHEELS) else { continue };
            let end = i == 0 || i == WHEELS;
            let disc = disc(centre, self.radius);
            chart.draw_series([Polygon::new(
                disc.clone(),
                BLUE.mix(if end { 0.10 } else { 0.05 }).filled(),
            )])?;
            chart.draw_series([PathElement::new(disc, pen.line(if end { INK } else { GREY }, 1))])?;
        }
        if let Some(&lift_off) = leap.stance.last() {
            chart.draw_series([PathElement::new(vec![leap.foot, lift_off], pen.line(INK, 3))])?;
        }
        chart.draw_series([PathElement::new(leap.stance.clone(), pen.line(BLUE, 3))])?;
        let dots = dots(chart, &leap.flight, pen);
        chart.draw_series(dots.into_iter().map(|at| Circle::new(at, pen.length(1), BLUE.filled())))?;
        chart.draw_series([Circle::new(leap.foot, pen.length(4), INK.filled())])?;
        let apex = leap.flight.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1));
        let style = pen.text(12, INK, HPos::Center, VPos::Bottom);
        apex.map_or(Ok(()), |apex| {
            label(chart, &leap.label.replace('-', "−"), &style, apex, (0, pen.offset(-6)))
        })
    }

    fn draw_key<DB: DrawingBackend>(&self, chart: &Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        let mut words = "wheel's centre: stance solid, flight dotted".to_owned();
        if !self.land.is_empty() {
            words += "; green: where a jump must land";
        }
        if !self.avoid.is_empty() {
            words += "; red: where none may";
        }
        let plain = chart.plotting_area().strip_coord_spec();
        let right = plain.dim_in_pixel().0.cast_signed() - pen.offset(10);
        plain.draw_text(&words, &pen.text(13, INK, HPos::Right, VPos::Top), (right, pen.offset(8)))
    }
}

/// The rim of a wheel.
fn disc((x, y): (f64, f64), radius: f64) -> Vec<(f64, f64)> {
    const SIDES: u32 = 72;
    let turn = |i: u32| std::f64::consts::TAU * f64::from(i) / f64::from(SIDES);
    (0..=SIDES).map(turn).map(|angle| (x + radius * angle.cos(), y + radius * angle.sin())).collect()
}
