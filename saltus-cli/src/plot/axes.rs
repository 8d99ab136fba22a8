//! What all drawings share: sizes, fonts, axes.

use std::ops::Range;

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{Cartesian2d, DrawingArea, DrawingBackend, FontStyle, IntoFont, TextStyle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, RGBColor, ShapeStyle, register_font as register};

use super::palette::{FAINT, INK};
use crate::output::digits;

/// DejaVu Sans, cut down; its licence lies beside it.
const FONT: &[u8] = include_bytes!("../../assets/DejaVuSans-subset.ttf");
/// The names under which an SVG asks for it; it is measured with the one built in.
const FAMILY: &str = "DejaVu Sans, Verdana, sans-serif";

/// Space around the axes.
pub(super) const LEFT: u32 = 70;
const BOTTOM: u32 = 52;
const RIGHT: u32 = 24;
const TOP: u32 = 14;
pub(super) const EDGE: u32 = 8;

/// A chart with two linear axes.
pub(crate) type Chart<'a, DB> = ChartContext<'a, DB, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Makes the built-in font known.
pub(crate) fn register_font() -> Result<(), String> {
    register(FAMILY, FontStyle::Normal, FONT).map_err(|_| "the built-in font is damaged".into())
}

/// Sizes on a backend whose pixels are finer than the drawing's units.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    scale: u32,
}

impl Pen {
    pub(crate) fn new(scale: u32) -> Pen {
        Pen { scale }
    }

    /// A length.
    pub(crate) fn length(self, units: u32) -> u32 {
        units * self.scale
    }

    /// An offset.
    pub(crate) fn offset(self, units: i32) -> i32 {
        units * self.scale.cast_signed()
    }

    /// A line.
    pub(crate) fn line(self, color: RGBColor, width: u32) -> ShapeStyle {
        color.stroke_width(width * self.scale)
    }

    /// Text, of which `horizontal` and `vertical` is where it is put.
    pub(crate) fn text(
        self,
        size: u32,
        color: RGBColor,
        horizontal: HPos,
        vertical: VPos,
    ) -> TextStyle<'static> {
        let font = (FAMILY, f64::from(size * self.scale)).into_font();
        TextStyle {
            font,
            color: color.to_backend_color(),
            pos: Pos::new(horizontal, vertical),
        }
    }
}

/// Names of the axes, with units, and what they span.
pub(crate) struct Axes {
    pub(crate) x: (&'static str, Range<f64>),
    pub(crate) y: (&'static str, Range<f64>),
}

impl Axes {
    /// The axes on all of `area`, with their grid.
    pub(crate) fn build<'a, DB: DrawingBackend + 'a>(
        &self,
        area: &DrawingArea<DB, Shift>,
        pen: Pen,
    ) -> Result<Chart<'a, DB>, plotters::drawing::DrawingAreaErrorKind<DB::ErrorType>> {
        let mut chart = ChartBuilder::on(area)
            .x_label_area_size(pen.length(BOTTOM))
            .y_label_area_size(pen.length(LEFT))
            .margin_top(pen.length(TOP))
            .margin_left(pen.length(EDGE))
            .margin_bottom(pen.length(EDGE))
            .margin_right(pen.length(RIGHT))
            .build_cartesian_2d(self.x.1.clone(), self.y.1.clone())?;
        let label = |size| pen.text(size, INK, HPos::Center, VPos::Center);
        chart
            .configure_mesh()
            .x_desc(self.x.0)
            .y_desc(self.y.0)
            .x_labels(9)
            .y_labels(9)
            .axis_desc_style(label(15))
            .label_style(label(13))
            .x_label_formatter(&|x| tick(*x))
            .y_label_formatter(&|y| tick(*y))
            .light_line_style(plotters::style::TRANSPARENT)
            .bold_line_style(pen.line(FAINT, 1))
            .axis_style(pen.line(INK, 1))
            .set_all_tick_mark_size(pen.length(4))
            .draw()?;
        Ok(chart)
    }

    /// Height of an area of `width` on which both axes have one scale; what they span
    /// grows where the area would be too flat or too tall.
    pub(crate) fn equal_scale(&mut self, width: u32) -> u32 {
        const FLATTEST: f64 = 0.3;
        const TALLEST: f64 = 0.9;
        let (x, y) = (&mut self.x.1, &mut self.y.1);
        let ratio = (y.end - y.start) / (x.end - x.start);
        if ratio < FLATTEST {
            y.end = y.start + FLATTEST * (x.end - x.start);
        } else if ratio > TALLEST {
            let missing = 0.5 * ((y.end - y.start) / TALLEST - (x.end - x.start));
            *x = x.start - missing..x.end + missing;
        }
        let across = f64::from(width - LEFT - EDGE - RIGHT);
        // Between the flattest and the tallest of a drawing's width.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let up = (across * (y.end - y.start) / (x.end - x.start)).round() as u32;
        up + TOP + BOTTOM + EDGE
    }
}

/// A number at an axis, with a real minus sign.
pub(crate) fn tick(x: f64) -> String {
    let x = if x.abs() < 1e-12 { 0.0 } else { x };
    digits(x, 6).replace('-', "−")
}

/// `low..high` grown by `share` of its width on both sides; never empty.
pub(crate) fn padded(low: f64, high: f64, share: f64) -> Range<f64> {
    let width = (high - low).max(1e-9 * high.abs().max(low.abs())).max(1e-9);
    low - share * width..high + share * width
}

/// Least and greatest of some numbers that are finite; 0 and 1 without any.
pub(crate) fn span(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    let finite = numbers.filter(|x| x.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| {
        (a.min(x), b.max(x))
    });
    if low <= high { (low, high) } else { (0.0, 1.0) }
}
