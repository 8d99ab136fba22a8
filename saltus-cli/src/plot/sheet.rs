//! Charts under one title.

use plotters::coord::Shift;
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::{Color, DrawingArea, DrawingBackend, RGBColor, WHITE};
use plotters::style::text_anchor::{HPos, VPos};

use super::Drawn;
use super::axes::{Axes, Chart, EDGE, LEFT, Pen, padded, span, tick};
use super::line::Line;
use super::palette::{INK, viridis};

/// Width of a sheet.
const WIDTH: u32 = 1000;
const TITLE: u32 = 34;
/// Height of a chart over the whole width, and of one of two side by side, each with its title.
const WIDE: u32 = 520;
const PANEL: u32 = 330;
/// Height of a chart's title.
const HEAD: u32 = 26;
/// Width of the scale beside a chart.
const SCALE: u32 = 96;
/// Width and height of a character.
const CHARACTER: [i32; 2] = [7, 14];

/// Charts over the whole width, and below them others, two in a row.
#[derive(Clone, Debug, Default)]
pub(crate) struct Sheet {
    pub(crate) title: String,
    pub(crate) wide: Vec<Panel>,
    pub(crate) panels: Vec<Panel>,
}

/// One chart.
#[derive(Clone, Debug, Default)]
pub(crate) struct Panel {
    pub(crate) title: String,
    /// Names of colours, which follow the title.
    pub(crate) swatches: Vec<(&'static str, RGBColor)>,
    pub(crate) x: &'static str,
    pub(crate) y: &'static str,
    pub(crate) lines: Vec<Line>,
    /// What the axes span at least: from and to along, from and to up.
    pub(crate) least: Option<[[f64; 2]; 2]>,
    /// Whether a metre is as long along both axes; for a chart over the whole width.
    pub(crate) is_to_scale: bool,
    /// Labels, the most important one first.
    pub(crate) labels: Vec<Label>,
    /// Lines in the upper left corner.
    pub(crate) notes: Vec<(String, RGBColor)>,
    /// What stands in the middle, as it is empty.
    pub(crate) empty: String,
    /// Least and greatest number of what the colours show, and its levels.
    pub(crate) scale: Option<(f64, f64, Vec<f64>)>,
}

/// Words at the first of some places where no label is yet; nowhere where there is none.
#[derive(Clone, Debug)]
pub(crate) struct Label {
    pub(crate) words: String,
    pub(crate) places: Vec<(f64, f64)>,
    pub(crate) side: Side,
    pub(crate) color: RGBColor,
}

/// Where a label is, seen from its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Side {
    Above,
    Below,
    Right,
    /// On it, on a light ground.
    On,
}

impl Sheet {
    pub(super) fn size(&self) -> (u32, u32) {
        let rows = u32::try_from(self.panels.len().div_ceil(2)).unwrap_or(1);
        let wide: u32 = self.wide.iter().map(Panel::height).sum();
        (WIDTH, TITLE + wide + rows * PANEL)
    }

    pub(super) fn draw<DB: DrawingBackend>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Drawn<DB> {
        area.fill(&WHITE)?;
        let (title, mut rest) = area.split_vertically(pen.length(TITLE));
        let style = pen.text(16, INK, HPos::Left, VPos::Center);
        let left = pen.offset((LEFT + EDGE).cast_signed());
        title.draw_text(&self.title, &style, (left, pen.offset(20)))?;
        for panel in &self.wide {
            let (here, below) = rest.split_vertically(pen.length(panel.height()));
            panel.draw(&here, pen)?;
            rest = below;
        }
        let parts = rest.split_evenly((self.panels.len().div_ceil(2), 2));
        for (panel, part) in self.panels.iter().zip(&parts) {
            panel.draw(part, pen)?;
        }
        area.present()
    }
}

impl Panel {
    /// Names and ranges of the axes, and the height over the whole width.
    fn axes(&self) -> (Axes, u32) {
        let points = || self.lines.iter().flat_map(|line| &line.points);
        let [along, up] = self.least.map_or([None; 2], |least| least.map(Some));
        let x = span(points().map(|p| p.0).chain(along.into_iter().flatten()));
        let y = span(points().map(|p| p.1).chain(up.into_iter().flatten()));
        // Words in the corners have room above. The colours of a map reach the axes.
        let rows = self.lines.iter().filter_map(Line::entry).count();
        let rows = rows.max(self.notes.len()).min(5);
        let top = y.1 + (y.1 - y.0) * 0.08 * rows as f64;
        let around = if self.scale.is_some() { 0.0 } else { 0.03 };
        let mut axes = Axes {
            x: (self.x, padded(x.0, x.1, around)),
            y: (self.y, padded(y.0, top, 2.0 * around)),
        };
        let height = if self.is_to_scale {
            axes.equal_scale(WIDTH)
        } else {
            WIDE
        };
        (axes, height)
    }

    fn height(&self) -> u32 {
        let head = if self.title.is_empty() { 0 } else { HEAD };
        head + self.axes().1
    }

    fn draw<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
        let mut body = area.clone();
        if !self.title.is_empty() {
            let (head, below) = body.split_vertically(pen.length(HEAD));
            self.draw_head(&head, pen)?;
            body = below;
        }
        if let Some((low, high, levels)) = &self.scale {
            let (left, right) = body.split_horizontally(pen.length(WIDTH - SCALE));
            draw_scale(&right, pen, (*low, *high), levels)?;
            body = left;
        }
        let mut chart = self.axes().0.build(&body, pen)?;
        for line in &self.lines {
            line.draw(&mut chart, pen)?;
        }
        self.draw_labels(&chart, pen)?;
        let notes = self.notes.iter();
        column(
            &chart,
            pen,
            HPos::Left,
            notes.map(|(words, color)| (words.as_str(), *color)),
        )?;
        let key = self.lines.iter().filter_map(Line::entry);
        column(&chart, pen, HPos::Right, key)?;
        if !self.empty.is_empty() {
            let plain = chart.plotting_area().strip_coord_spec();
            let (width, height) = plain.dim_in_pixel();
            let middle = (width.cast_signed() / 2, height.cast_signed() / 2);
            let style = pen.text(14, INK, HPos::Center, VPos::Center);
            plain.draw_text(&self.empty, &style, middle)?;
        }
        Ok(())
    }

    /// The title, and the names of colours.
    fn draw_head<DB: DrawingBackend>(&self, area: &DrawingArea<DB, Shift>, pen: Pen) -> Drawn<DB> {
        let (middle, half) = (pen.offset(15), pen.offset(6));
        let style = pen.text(13, INK, HPos::Left, VPos::Center);
        let mut left = pen.offset(16);
        area.draw_text(&self.title, &style, (left, middle))?;
        left += width(&self.title, pen);
        for (name, color) in &self.swatches {
            let square = [(left, middle - half), (left + 2 * half, middle + half)];
            area.draw(&Rectangle::new(square, color.filled()))?;
            area.draw(&Rectangle::new(square, pen.line(INK, 1)))?;
            left += 3 * half;
            area.draw_text(name, &style, (left, middle))?;
            left += width(name, pen);
        }
        Ok(())
    }

    fn draw_labels<DB: DrawingBackend>(&self, chart: &Chart<'_, DB>, pen: Pen) -> Drawn<DB> {
        let area = chart.plotting_area();
        let (left, top) = area.get_base_pixel();
        let plain = area.strip_coord_spec();
        let mut taken: Vec<[i32; 4]> = Vec::new();
        for label in &self.labels {
            let half = [width(&label.words, pen) / 2, pen.offset(CHARACTER[1] / 2)];
            let by = match label.side {
                Side::Above => (0, -half[1] - pen.offset(5)),
                Side::Below => (0, half[1] + pen.offset(5)),
                Side::Right => (half[0], 0),
                Side::On => (0, 0),
            };
            let middle = |at: &(f64, f64)| {
                let (x, y) = area.map_coordinate(at);
                (x - left + by.0, y - top + by.1)
            };
            let is_free = |(x, y): &(i32, i32)| {
                let is_beside = |[a, b, w, h]: &[i32; 4]| {
                    (x - a).abs() >= half[0] + w || (y - b).abs() >= half[1] + h
                };
                taken.iter().all(is_beside)
            };
            let Some((x, y)) = label.places.iter().map(middle).find(is_free) else {
                continue;
            };
            taken.push([x, y, half[0], half[1]]);
            if label.side == Side::On {
                let ground = [(x - half[0], y - half[1]), (x + half[0], y + half[1])];
                plain.draw(&Rectangle::new(ground, WHITE.mix(0.75).filled()))?;
            }
            let style = pen.text(12, label.color, HPos::Center, VPos::Center);
            plain.draw_text(&label.words, &style, (x, y))?;
        }
        Ok(())
    }
}

/// Some more than the width of a text.
fn width(text: &str, pen: Pen) -> i32 {
    let count = i32::try_from(text.chars().count()).unwrap_or(0);
    pen.offset(CHARACTER[0] * (count + 1))
}

/// Words in their colours, one under the other, in an upper corner.
fn column<'a, DB: DrawingBackend>(
    chart: &Chart<'_, DB>,
    pen: Pen,
    side: HPos,
    rows: impl Iterator<Item = (&'a str, RGBColor)>,
) -> Drawn<DB> {
    let plain = chart.plotting_area().strip_coord_spec();
    let x = match side {
        HPos::Left => pen.offset(8),
        _ => plain.dim_in_pixel().0.cast_signed() - pen.offset(8),
    };
    for ((words, color), row) in rows.zip(0..) {
        let style = pen.text(12, color, side, VPos::Top);
        plain.draw_text(words, &style, (x, pen.offset(5 + 15 * row)))?;
    }
    Ok(())
}

/// The colours' meaning, with levels.
fn draw_scale<DB: DrawingBackend>(
    area: &DrawingArea<DB, Shift>,
    pen: Pen,
    (low, high): (f64, f64),
    levels: &[f64],
) -> Drawn<DB> {
    const STEPS: i32 = 100;
    let (top, bottom) = (
        pen.offset(14),
        area.dim_in_pixel().1.cast_signed() - pen.offset(61),
    );
    let (left, right) = (pen.offset(2), pen.offset(18));
    // Rows fit.
    #[allow(clippy::cast_possible_truncation)]
    let row = |share: f64| (f64::from(bottom) - share * f64::from(bottom - top)).round() as i32;
    let share = |i: i32| f64::from(i) / f64::from(STEPS);
    for i in 0..STEPS {
        let corners = [(left, row(share(i + 1))), (right, row(share(i)))];
        area.draw(&Rectangle::new(corners, viridis(share(i)).filled()))?;
    }
    let style = pen.text(12, INK, HPos::Left, VPos::Center);
    for level in levels {
        let row = row((level - low) / (high - low));
        let line = vec![(left, row), (right, row)];
        area.draw(&PathElement::new(line, pen.line(WHITE, 1)))?;
        area.draw_text(&tick(*level), &style, (right + pen.offset(6), row))?;
    }
    Ok(())
}
