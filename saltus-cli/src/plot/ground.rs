//! What a course is: the ground, obstacles on it, and where to land.

use plotters::prelude::RGBColor;

use super::line::{Line, Mark};
use super::palette::{BLUE, GREEN, INK, RED};
use super::sheet::{Label, Panel, Side};

/// Space (m) under the ground for zones and labels.
pub(crate) const CELLAR: f64 = 0.12;
/// Thickness (m) of the strips that mark zones.
const STRIP: f64 = 0.02;
/// Depth (m) of the pits that mark where no jump may land.
const PIT: f64 = 0.06;
const DARK: RGBColor = RGBColor(95, 88, 80);
const STONE: RGBColor = RGBColor(190, 180, 165);

/// A course; lengths in m.
#[derive(Clone, Debug)]
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
    /// A chart of it over the whole width.
    pub(crate) fn panel(&self) -> Panel {
        let box_of = |part: Part, fill, [from, to]: [(f64, f64); 2]| {
            let is_missed = self.missed.contains(&part);
            let (color, width) = if is_missed { (RED, 3) } else { (INK, 1) };
            [
                Line::new(Mark::Area(1.0), fill, [from, to]),
                Line::new(Mark::Rim(width), color, [from, to]),
            ]
        };
        let obstacles = self.obstacles.iter().enumerate();
        let obstacles = obstacles.flat_map(|(i, &((from, to), top))| {
            box_of(Part::Obstacle(i), STONE, [(from, 0.0), (to, top)])
        });
        let pits = self.avoid.iter().enumerate();
        let pits = pits
            .flat_map(|(i, &(from, to))| box_of(Part::Avoid(i), DARK, [(from, -PIT), (to, 0.0)]));
        let mut lines: Vec<Line> = obstacles.chain(pits).collect();
        let level = [(f64::NEG_INFINITY, 0.0), (f64::INFINITY, 0.0)];
        lines.push(Line::new(Mark::Stroke(2), INK, level));
        let zones = self.land.iter().enumerate();
        let zones = zones.map(|(i, span)| (Part::Land(i), *span));
        for (part, (from, to)) in zones.chain(self.goal.map(|goal| (Part::Goal, goal))) {
            let row = if part == Part::Goal { 1.0 } else { 0.0 };
            let is_missed = self.missed.contains(&part);
            let color = if is_missed { RED } else { GREEN };
            let corners = [(from, -STRIP * (row + 1.0)), (to, -STRIP * row)];
            lines.push(Line::new(Mark::Area(0.4 + 0.3 * row), color, corners));
        }
        let (top, bottom) = (0.0, -2.0 * STRIP);
        let mark = |x| Line::new(Mark::Stroke(2), BLUE, [(x, top), (x, bottom)]);
        lines.extend(self.target.map(mark));
        let label = |x| Label {
            words: "target".into(),
            places: vec![(x, bottom)],
            side: Side::Below,
            color: BLUE,
        };
        lines.extend(self.notes());
        Panel {
            x: "x (m)",
            y: "y (m)",
            lines,
            least: Some([[f64::NAN; 2], [-CELLAR, 0.0]]),
            is_to_scale: true,
            labels: self.target.map(label).into_iter().collect(),
            ..Panel::default()
        }
    }

    /// What the key says of the marks.
    fn notes(&self) -> impl Iterator<Item = Line> {
        [
            (self.goal.is_some(), "strip: the goal", GREEN),
            (
                !self.land.is_empty(),
                "pale strip: landing zone of a jump",
                GREEN,
            ),
            (!self.avoid.is_empty(), "pit: where no jump may land", INK),
            (!self.missed.is_empty(), "red: what a jump misses", RED),
        ]
        .into_iter()
        .filter(|(is_there, ..)| *is_there)
        .map(|(_, words, color)| Line::note(words, color))
    }
}
