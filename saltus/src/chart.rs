//! Small charts as SVG text: the same bytes for the same numbers. In a page, the page's style sheet
//! colours them by class; as a file of their own they bring one.

use std::fmt::Write;

/// Space (px) beside, above and below the axes.
const LEFT: f64 = 74.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 44.0;
/// Space (px) between ticks, about.
const BETWEEN: (f64, f64) = (65.0, 46.0);
/// Looks of a chart that is a file of its own.
const STYLE: &str = "text{fill:#282828;font:12px DejaVu Sans,Verdana,sans-serif}\
    .grid{stroke:#e2e2e2}.axis{fill:none;stroke:#282828}polyline{fill:none;stroke-width:2}\
    .dots{fill:none;stroke-linecap:round;stroke-width:7}";

/// Colours of lines, in their order.
pub const COLORS: [&str; 7] = [
    "#1f63a8", "#c83228", "#3c9650", "#8a4fa3", "#c77c11", "#1a9c9c", "#555555",
];

/// An axis: its name with the unit, and what it spans.
pub type Axis<'a> = (&'a str, (f64, f64));

/// How a mark looks.
#[derive(Clone, Copy, Debug)]
pub enum Ink<'a> {
    /// As the page's style sheet says of this class.
    Class(&'a str),
    /// In this colour.
    Solid(&'a str),
    /// The same, a line dotted.
    Dotted(&'a str),
    /// The same, hardly to be seen.
    Faint(&'a str),
}

impl Ink<'_> {
    /// The attribute that colours `what`: `stroke` or `fill`.
    fn of(self, what: &str) -> String {
        match self {
            Ink::Class(class) => format!("class=\"{class}\""),
            Ink::Solid(color) => format!("style=\"{what}:{color}\""),
            Ink::Dotted(color) => format!("style=\"{what}:{color};stroke-dasharray:2 4\""),
            Ink::Faint(color) => format!("style=\"{what}:{color};opacity:.25\""),
        }
    }
}

/// A chart with two linear axes.
///
/// ```
/// use saltus::chart::{COLORS, Chart, Ink};
///
/// let mut chart = Chart::new((460.0, 290.0), ("x (m)", (0.0, 1.0)), ("y (m)", (0.0, 0.5)));
/// chart.line(Ink::Solid(COLORS[0]), &[(0.0, 0.1), (1.0, 0.4)]);
/// assert!(chart.file().starts_with("<svg"));
/// ```
#[derive(Clone, Debug)]
pub struct Chart {
    size: (f64, f64),
    x: (f64, f64),
    y: (f64, f64),
    body: String,
    keys: usize,
}

impl Chart {
    /// A chart of `size` (px) with its grid.
    pub fn new(size: (f64, f64), x: Axis<'_>, y: Axis<'_>) -> Chart {
        let mut chart = Chart {
            size,
            x: x.1,
            y: y.1,
            body: String::new(),
            keys: 0,
        };
        let (right, bottom) = (size.0 - RIGHT, size.1 - BOTTOM);
        chart.put(format_args!(
            "<text class=\"name\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\
             <text class=\"name\" transform=\"translate(13 {:.1}) rotate(-90)\" \
             text-anchor=\"middle\">{}</text>",
            LEFT.midpoint(right),
            size.1 - 8.0,
            escaped(x.0),
            TOP.midpoint(bottom),
            escaped(y.0)
        ));
        for at in ticks(x.1, (right - LEFT) / BETWEEN.0) {
            let px = chart.px(at);
            chart.put(format_args!(
                "<path class=\"grid\" d=\"M{px:.1} {TOP}V{bottom:.1}\"/>\
                 <text class=\"tick\" x=\"{px:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 15.0,
                tick(at)
            ));
        }
        for at in ticks(y.1, (bottom - TOP) / BETWEEN.1) {
            let py = chart.py(at);
            chart.put(format_args!(
                "<path class=\"grid\" d=\"M{LEFT} {py:.1}H{right:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                LEFT - 6.0,
                py + 4.0,
                tick(at)
            ));
        }
        chart
    }

    /// A chart `width` (px) wide with one scale on both axes.
    pub fn to_scale(width: f64, x: Axis<'_>, y: Axis<'_>) -> Chart {
        let ratio = (y.1.1 - y.1.0) / (x.1.1 - x.1.0);
        let height = (width - LEFT - RIGHT) * ratio + TOP + BOTTOM;
        Chart::new((width, height.round()), x, y)
    }

    fn px(&self, x: f64) -> f64 {
        LEFT + (x - self.x.0) / (self.x.1 - self.x.0) * (self.size.0 - LEFT - RIGHT)
    }

    fn py(&self, y: f64) -> f64 {
        let share = (y - self.y.0) / (self.y.1 - self.y.0);
        self.size.1 - BOTTOM - share * (self.size.1 - TOP - BOTTOM)
    }

    fn put(&mut self, mark: std::fmt::Arguments<'_>) {
        // Writing to a string does not fail.
        let _ = self.body.write_fmt(mark);
    }

    /// The title, above the axes.
    pub fn title(&mut self, text: &str) {
        let text = escaped(text);
        self.put(format_args!(
            "<text class=\"title\" x=\"{LEFT}\" y=\"16\">{text}</text>"
        ));
    }

    /// A filled block between two corners, of which what is inside the axes is drawn.
    pub fn block(&mut self, ink: Ink<'_>, low: (f64, f64), high: (f64, f64)) {
        let (x, width) = (self.px(low.0.max(self.x.0)), self.px(high.0.min(self.x.1)));
        let (y, height) = (self.py(high.1.min(self.y.1)), self.py(low.1.max(self.y.0)));
        let (width, height, ink) = (width - x, height - y, ink.of("fill"));
        self.put(format_args!(
            "<rect {ink} x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\" height=\"{height:.1}\"/>"
        ));
    }

    /// A line across at a place, with what begins there; the `row` of its name keeps it clear of
    /// the one before.
    pub fn begin(&mut self, x: f64, name: &str, row: usize) {
        let (px, bottom) = (self.px(x.max(self.x.0)), self.size.1 - BOTTOM);
        let (right, under) = (px + 3.0, TOP + 10.0 + 11.0 * row as f64);
        let name = escaped(name);
        self.put(format_args!(
            "<path class=\"phase\" d=\"M{px:.1} {TOP}V{bottom:.1}\"/>\
             <text class=\"phase\" x=\"{right:.1}\" y=\"{under:.1}\">{name}</text>"
        ));
    }

    /// A line through points.
    pub fn line(&mut self, ink: Ink<'_>, points: &[(f64, f64)]) {
        let places = points
            .iter()
            .map(|&(x, y)| format!("{:.1},{:.1}", self.px(x), self.py(y)));
        let (places, ink) = (places.collect::<Vec<_>>().join(" "), ink.of("stroke"));
        self.put(format_args!("<polyline {ink} points=\"{places}\"/>"));
    }

    /// Dots at points: strokes of no length, with round ends.
    pub fn dots(&mut self, ink: Ink<'_>, points: &[(f64, f64)]) {
        let places = points
            .iter()
            .map(|&(x, y)| format!("M{:.1} {:.1}h0", self.px(x), self.py(y)));
        let places = places.collect::<String>();
        let look = match ink {
            Ink::Class(class) => format!("class=\"dots {class}\""),
            color => format!("class=\"dots\" {}", color.of("stroke")),
        };
        self.put(format_args!("<path {look} d=\"{places}\"/>"));
    }

    /// Text with its middle at a place.
    pub fn text(&mut self, ink: Ink<'_>, at: (f64, f64), text: &str) {
        let (x, y, ink, text) = (self.px(at.0), self.py(at.1), ink.of("fill"), escaped(text));
        self.put(format_args!(
            "<text {ink} x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{text}</text>"
        ));
    }

    /// A line of the key, in the upper right corner.
    pub fn key(&mut self, ink: Ink<'_>, text: &str) {
        let (x, y) = (
            self.size.0 - RIGHT - 8.0,
            TOP + 18.0 + 17.0 * self.keys as f64,
        );
        let (ink, text) = (ink.of("fill"), escaped(text));
        self.keys += 1;
        self.put(format_args!(
            "<text {ink} x=\"{x}\" y=\"{y}\" text-anchor=\"end\">{text}</text>"
        ));
    }

    /// The drawing, for a page.
    pub fn svg(&self) -> String {
        self.framed("role=\"img\"", "")
    }

    /// The drawing as a file of its own, with the looks that it needs.
    pub fn file(&self) -> String {
        let size = format!("width=\"{}\" height=\"{}\"", self.size.0, self.size.1);
        let looks = format!(
            "<style>{STYLE}</style><rect width=\"100%\" height=\"100%\" style=\"fill:#fff\"/>"
        );
        self.framed(&size, &looks).replace("><", ">\n<") + "\n"
    }

    fn framed(&self, attributes: &str, looks: &str) -> String {
        let (width, height) = self.size;
        let (right, bottom) = (width - RIGHT, height - BOTTOM);
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
             {attributes}>{looks}{}<path class=\"axis\" d=\"M{LEFT} {TOP}V{bottom}H{right}\"/></svg>",
            self.body
        )
    }
}

/// Text as it stands in a page.
pub fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

/// Round numbers in a range, `count` at most, or a few more.
fn ticks((low, high): (f64, f64), count: f64) -> impl Iterator<Item = f64> {
    let rough = (high - low) / count;
    let power = 10_f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|m| m * power)
        .find(|step| *step >= rough)
        .unwrap_or(10.0 * power);
    let first = (low / step - 1e-9).ceil();
    (0..100)
        .map(move |i| (first + f64::from(i)) * step)
        .take_while(move |x| *x <= high + 1e-9 * step)
}

/// A number at an axis, to six digits and with a real minus sign.
fn tick(x: f64) -> String {
    let x = if x.abs() < 1e-12 { 0.0 } else { x };
    let rounded: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    rounded.to_string().replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        let of = |span, count| ticks(span, count).map(tick).collect::<Vec<_>>();
        assert_eq!(of((-0.3, 10.2), 5.0), ["0", "5", "10"]);
        assert_eq!(of((0.1, 0.9), 4.0), ["0.2", "0.4", "0.6", "0.8"]);
        assert_eq!(of((-0.2, 0.0), 2.0), ["−0.2", "−0.1", "0"]);
    }

    #[test]
    fn what_a_file_is_called_is_not_markup() {
        assert_eq!(escaped("<a & \"b\">"), "&lt;a &amp; &quot;b&quot;&gt;");
    }

    #[test]
    fn marks_stand_where_their_numbers_are() {
        let mut chart = Chart::new((186.0, 170.0), ("x", (0.0, 1.0)), ("y", (0.0, 1.0)));
        let before = chart.body.len();
        chart.line(Ink::Class("a"), &[(0.0, 0.0), (1.0, 1.0)]);
        chart.block(Ink::Solid("red"), (-9.0, 0.5), (9.0, 9.0));
        assert_eq!(
            &chart.body[before..],
            "<polyline class=\"a\" points=\"74.0,126.0 174.0,26.0\"/>\
             <rect style=\"fill:red\" x=\"74.0\" y=\"26.0\" width=\"100.0\" height=\"50.0\"/>"
        );
    }
}
