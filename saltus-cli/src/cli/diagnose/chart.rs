//! Small charts as SVG, for a page.

use std::fmt::Write;

use crate::plot::tick;

const LEFT: f64 = 74.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 44.0;

/// A chart with two linear axes.
pub(super) struct Chart {
    size: (f64, f64),
    x: (f64, f64),
    y: (f64, f64),
    body: String,
}

impl Chart {
    /// An empty one; `x` and `y` are the names of the axes with what they span.
    pub(super) fn new(
        title: &str,
        size: (f64, f64),
        x: (&str, (f64, f64)),
        y: (&str, (f64, f64)),
    ) -> Chart {
        let mut chart = Chart {
            size,
            x: padded(x.1, 0.02),
            y: padded(y.1, 0.06),
            body: String::new(),
        };
        let (right, bottom) = (size.0 - RIGHT, size.1 - BOTTOM);
        let out = &mut chart.body;
        // Writing to a string does not fail.
        let _ = write!(
            out,
            "<text class=\"title\" x=\"{LEFT}\" y=\"16\">{}</text><text class=\"name\" \
             x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text><text class=\"name\" \
             transform=\"translate(13 {:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            escaped(title),
            LEFT.midpoint(right),
            size.1 - 8.0,
            escaped(x.0),
            TOP.midpoint(bottom),
            escaped(y.0)
        );
        for at in ticks(chart.x, 6) {
            let px = chart.px(at);
            let _ = write!(
                chart.body,
                "<path class=\"grid\" d=\"M{px:.1} {TOP}V{bottom:.1}\"/>\
                 <text class=\"tick\" x=\"{px:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 15.0,
                tick(at)
            );
        }
        for at in ticks(chart.y, 5) {
            let py = chart.py(at);
            let _ = write!(
                chart.body,
                "<path class=\"grid\" d=\"M{LEFT} {py:.1}H{right:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                py + 4.0,
                tick(at)
            );
        }
        chart
    }

    fn px(&self, x: f64) -> f64 {
        LEFT + (x - self.x.0) / (self.x.1 - self.x.0) * (self.size.0 - LEFT - RIGHT)
    }

    fn py(&self, y: f64) -> f64 {
        let share = (y - self.y.0) / (self.y.1 - self.y.0);
        self.size.1 - BOTTOM - share * (self.size.1 - TOP - BOTTOM)
    }

    /// A band between two heights.
    pub(super) fn band(&mut self, low: f64, high: f64) {
        let (top, bottom) = (self.py(high.min(self.y.1)), self.py(low.max(self.y.0)));
        let width = self.size.0 - LEFT - RIGHT;
        let height = bottom - top;
        let _ = write!(
            self.body,
            "<rect class=\"band\" x=\"{LEFT}\" y=\"{top:.1}\" width=\"{width:.1}\" \
             height=\"{height:.1}\"/>"
        );
    }

    /// A line across at a place, with what begins there; the `row` of its name keeps it clear of
    /// the one before.
    pub(super) fn begin(&mut self, x: f64, name: &str, row: usize) {
        let (px, bottom) = (self.px(x.max(self.x.0)), self.size.1 - BOTTOM);
        let _ = write!(
            self.body,
            "<path class=\"phase\" d=\"M{px:.1} {TOP}V{bottom:.1}\"/>\
             <text class=\"phase\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            px + 3.0,
            TOP + 10.0 + 11.0 * row as f64,
            escaped(name)
        );
    }

    /// A line through points.
    pub(super) fn line(&mut self, class: &str, points: &[(f64, f64)]) {
        let places: Vec<String> = points
            .iter()
            .map(|&(x, y)| format!("{:.1},{:.1}", self.px(x), self.py(y)))
            .collect();
        let _ = write!(
            self.body,
            "<polyline class=\"{class}\" points=\"{}\"/>",
            places.join(" ")
        );
    }

    /// Dots at points: strokes of no length, with round ends.
    pub(super) fn dots(&mut self, class: &str, points: &[(f64, f64)]) {
        let places: Vec<String> = points
            .iter()
            .map(|&(x, y)| format!("M{:.1} {:.1}h0", self.px(x), self.py(y)))
            .collect();
        let places = places.concat();
        let _ = write!(self.body, "<path class=\"dots {class}\" d=\"{places}\"/>");
    }

    /// The drawing.
    pub(super) fn svg(&self) -> String {
        let (width, height) = self.size;
        let (right, bottom) = (width - RIGHT, height - BOTTOM);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             role=\"img\">{}<path class=\"axis\" d=\"M{LEFT} {TOP}V{bottom}H{right}\"/></svg>",
            self.body
        )
    }
}

/// One bar: its class, its length, and what is said of it.
pub(super) type Bar = (&'static str, f64, String);

/// A row of bars under each other.
pub(super) struct Bars {
    /// Names, and under each its bars: class, length, what is said of it.
    pub(super) rows: Vec<(String, Vec<Bar>)>,
}

impl Bars {
    /// The drawing; the longest bar of each row is as long as the row where `each` is set, else
    /// that of all rows.
    pub(super) fn svg(&self, each: bool) -> String {
        const WIDTH: f64 = 760.0;
        const NAME: f64 = 230.0;
        const LENGTH: f64 = 300.0;
        const BAR: f64 = 15.0;
        const GAP: f64 = 9.0;
        let longest = |bars: &[Bar]| bars.iter().map(|b| b.1).fold(f64::MIN_POSITIVE, f64::max);
        let of_all = self
            .rows
            .iter()
            .map(|(_, bars)| longest(bars))
            .fold(f64::MIN_POSITIVE, f64::max);
        let (mut body, mut y) = (String::new(), 4.0);
        for (name, bars) in &self.rows {
            let most = if each { longest(bars) } else { of_all };
            let middle = y + BAR * bars.len() as f64 / 2.0 + 4.0;
            let x = NAME - 10.0;
            let name = escaped(name);
            let _ = write!(
                body,
                "<text class=\"name\" x=\"{x}\" y=\"{middle:.1}\" text-anchor=\"end\">{name}</text>"
            );
            for (class, length, said) in bars {
                let long = if length.is_finite() {
                    (length / most * LENGTH).max(1.0)
                } else {
                    1.0
                };
                let _ = write!(
                    body,
                    "<rect class=\"bar {class}\" x=\"{NAME}\" y=\"{:.1}\" width=\"{long:.1}\" \
                     height=\"{:.1}\"/><text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
                    y + 1.0,
                    BAR - 2.0,
                    NAME + long + 7.0,
                    y + BAR - 3.5,
                    escaped(said)
                );
                y += BAR;
            }
            y += GAP;
        }
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {y}\" \
             role=\"img\">{body}</svg>"
        )
    }
}

/// Text as it stands in a page.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

fn padded((low, high): (f64, f64), share: f64) -> (f64, f64) {
    let width = (high - low)
        .max(1e-9 * high.abs().max(low.abs()))
        .max(1e-12);
    (low - share * width, high + share * width)
}

/// Round numbers in a range, about so many.
fn ticks((low, high): (f64, f64), count: usize) -> Vec<f64> {
    let rough = (high - low) / count as f64;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .find(|m| m * power >= rough)
        .unwrap_or(10.0)
        * power;
    let first = (low / step).ceil();
    (0..=2 * count)
        .map(|i| (first + i as f64) * step)
        .take_while(|x| *x <= high)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((-0.3, 10.2), 5), [0.0, 5.0, 10.0]);
        assert_eq!(ticks((0.1, 0.9), 4), [0.2, 0.4, 0.6000000000000001, 0.8]);
    }

    #[test]
    fn what_a_file_is_called_is_not_markup() {
        assert_eq!(escaped("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }
}
