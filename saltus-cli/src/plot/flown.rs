//! A course as it was jumped: planned and simulated paths, landings, and what is missed.

use plotters::coord::Shift;
use plotters::element::{Circle, Rectangle};
use plotters::prelude::{Color, DrawingArea, DrawingBackend};
use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Pen, key, padded};
use super::ground::{CELLAR, Ground};
use super::line::{Line, WIDTH};
use super::palette::{BLUE, GREEN, INK, RED};

/// Where the bands of the tolerance lie (m under the surface landed on).
const BAND: [f64; 2] = [-0.06, -0.04];
/// Share of the height above the highest path: for the verdict and the key.
const HEADROOM: f64 = 0.35;

/// A course; lengths in m along it, and up.
pub(crate) struct Flown {
    pub(crate) ground: Ground,
    /// Paths of the axle.
    pub(crate) paths: Vec<Line>,
    /// Planned footholds.
    pub(crate) feet: Vec<(f64, f64)>,
    /// Where landings are wanted, and by how much they may miss.
    pub(crate) wanted: Vec<((f64, f64), f64)>,
    /// Where jumps landed, and whether they met every demand.
    pub(crate) landings: Vec<((f64, f64), bool)>,
    pub(crate) passes: bool,
    /// The verdict, line by line.
    pub(crate) verdict: Vec<String>,
}

impl Flown {
    fn axes(&self) -> Axes {
        let points = || {
            self.paths
                .iter()
                .flat_map(|line| &line.points)
                .chain(&self.feet)
                .copied()
        };
        let band = self
            .wanted
            .iter()
            .flat_map(|((x, _), off)| [x - off, x + off]);
        let places = || points().map(|(x, _)| x).chain(self.ground.places());
        let all: Vec<f64> = places().chain(band).filter(|x| x.is_finite()).collect();
        let least = all.iter().copied().fold(0.0, f64::min);
        let most = all.iter().copied().fold(0.0, f64::max);
        let top = points()
            .map(|(_, y)| y)
            .chain(self.ground.tops())
            .fold(0.2, f64::max);
        let low = points().map(|(_, y)| y).fold(-CELLAR, f64::min);
        Axes {
            x: ("x (m)", padded(least, most, 0.04)),
            y: ("height of the axle (m)", low..(1.0 + HEADROOM) * top),
        }
    }

    pub(super) fn height(&self) -> u32 {
        self.axes().equal_scale(WIDTH)
    }

    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        let mut axes = self.axes();
        axes.equal_scale(WIDTH);
        let mut chart = axes.build(area, pen)?;
        self.ground
            .draw(&mut chart, pen, (axes.x.1.start, axes.x.1.end))?;
        let band = |((x, y), off): &((f64, f64), f64)| {
            let corners = [(x - off, y + BAND[0]), (x + off, y + BAND[1])];
            Rectangle::new(corners, BLUE.mix(0.35).filled())
        };
        chart.draw_series(self.wanted.iter().map(band))?;
        for line in &self.paths {
            line.draw(&mut chart, pen)?;
        }
        let landing = |(at, passes): &((f64, f64), bool)| {
            let color = if *passes { GREEN } else { RED };
            Circle::new(*at, pen.length(3), color.mix(0.7).filled())
        };
        chart.draw_series(self.landings.iter().map(landing))?;
        chart.draw_series(
            self.feet
                .iter()
                .map(|at| Circle::new(*at, pen.length(4), INK.filled())),
        )?;
        let plain = chart.plotting_area().strip_coord_spec();
        for (line, row) in self.verdict.iter().zip(0..) {
            let color = match (self.passes, row) {
                (false, _) => RED,
                (true, 0) => GREEN,
                (true, _) => INK,
            };
            let style = pen.text(13, color, HPos::Left, VPos::Top);
            plain.draw_text(line, &style, (pen.offset(8), pen.offset(6 + 16 * row)))?;
        }
        key(
            &chart,
            pen,
            self.paths
                .iter()
                .filter_map(Line::entry)
                .chain(self.notes()),
        )
    }

    /// What the key says of the marks on the ground.
    fn notes(&self) -> impl Iterator<Item = (&str, RGBColor)> {
        let ground = &self.ground;
        [
            (
                !self.wanted.is_empty(),
                "band: tolerance of the landing",
                BLUE,
            ),
            (
                !self.landings.is_empty(),
                "dots: landings that meet every demand, red: that do not",
                INK,
            ),
            (ground.goal.is_some(), "strip: the goal", GREEN),
            (
                !ground.land.is_empty(),
                "pale strip: landing zone of a jump",
                GREEN,
            ),
            (!ground.avoid.is_empty(), "pit: where no jump may land", INK),
            (!ground.missed.is_empty(), "red: what a jump misses", RED),
        ]
        .into_iter()
        .filter_map(|(is_there, words, color)| is_there.then_some((words, color)))
    }
}
