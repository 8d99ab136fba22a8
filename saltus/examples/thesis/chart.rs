//! Small line charts as SVG text: the same bytes for the same numbers.

use std::fmt::Write;

/// Space (px) left, right, above and below the axes.
const LEFT: f64 = 62.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 14.0;
const BOTTOM: f64 = 48.0;
const WIDTH: f64 = 760.0;

/// Colours of lines, in their order.
pub(crate) const COLORS: [&str; 7] = [
    "#1f63a8", "#c83228", "#3c9650", "#8a4fa3", "#c77c11", "#1a9c9c", "#555555",
];

/// An axis: its name with the unit, and what it spans.
pub(crate) type Axis = (&'static str, f64, f64);

/// How a line is drawn.
#[derive(Clone, Copy)]
pub(crate) enum Stroke {
    Solid,
    Dotted,
    Faint,
}

/// A chart in the making.
pub(crate) struct Chart {
    x: Axis,
    y: Axis,
    height: f64,
    marks: String,
    keys: usize,
}

impl Chart {
    /// A chart whose axes are `height` px tall.
    pub(crate) fn new(x: Axis, y: Axis, height: f64) -> Chart {
        Chart {
            x,
            y,
            height,
            marks: String::new(),
            keys: 0,
        }
    }

    /// A chart with the same scale on both axes.
    pub(crate) fn equal(x: Axis, y: Axis) -> Chart {
        let height = (WIDTH - LEFT - RIGHT) * (y.2 - y.1) / (x.2 - x.1);
        Chart::new(x, y, height)
    }

    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let across = (x - self.x.1) / (self.x.2 - self.x.1);
        let up = (y - self.y.1) / (self.y.2 - self.y.1);
        (
            LEFT + across * (WIDTH - LEFT - RIGHT),
            TOP + (1.0 - up) * self.height,
        )
    }

    fn mark(&mut self, mark: std::fmt::Arguments<'_>) {
        writeln!(self.marks, "{mark}").expect("a string takes all");
    }

    pub(crate) fn line(&mut self, points: &[(f64, f64)], color: &str, stroke: Stroke) {
        let points: Vec<String> = points
            .iter()
            .map(|p| self.place(*p))
            .map(|(x, y)| format!("{x:.1},{y:.1}"))
            .collect();
        let dashes = match stroke {
            Stroke::Solid => "",
            Stroke::Faint => " opacity=\"0.25\"",
            Stroke::Dotted => " stroke-dasharray=\"2 4\"",
        };
        let points = points.join(" ");
        self.mark(format_args!(
            "<polyline points=\"{points}\" fill=\"none\" stroke=\"{color}\" \
             stroke-width=\"2\"{dashes}/>"
        ));
    }

    pub(crate) fn dots(&mut self, points: &[(f64, f64)], color: &str) {
        for point in points {
            let (x, y) = self.place(*point);
            self.mark(format_args!(
                "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3.5\" fill=\"{color}\"/>"
            ));
        }
    }

    pub(crate) fn block(&mut self, low: (f64, f64), high: (f64, f64), color: &str) {
        let ((x0, y1), (x1, y0)) = (self.place(low), self.place(high));
        let (width, height) = (x1 - x0, y1 - y0);
        self.mark(format_args!(
            "<rect x=\"{x0:.1}\" y=\"{y0:.1}\" width=\"{width:.1}\" height=\"{height:.1}\" \
             fill=\"{color}\"/>"
        ));
    }

    pub(crate) fn text(&mut self, at: (f64, f64), text: &str, color: &str) {
        let (x, y) = self.place(at);
        let text = text.replace('-', "−");
        self.mark(format_args!(
            "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\" \
             style=\"fill:{color}\">{text}</text>"
        ));
    }

    /// A line of the key, in the upper right corner.
    pub(crate) fn key(&mut self, text: &str, color: &str) {
        let y = TOP + 18.0 + 17.0 * self.keys as f64;
        let x = WIDTH - RIGHT - 8.0;
        self.keys += 1;
        let text = text.replace('-', "−");
        self.mark(format_args!(
            "<text x=\"{x}\" y=\"{y}\" text-anchor=\"end\" style=\"fill:{color}\">{text}</text>"
        ));
    }

    /// The whole as SVG.
    pub(crate) fn svg(&self) -> String {
        let height = TOP + self.height + BOTTOM;
        let mut out = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{height:.0}\" \
             viewBox=\"0 0 {WIDTH} {height:.0}\" font-family=\"DejaVu Sans, Verdana, sans-serif\" \
             font-size=\"12\">\n<style>text {{ fill: #282828 }}</style>\n\
             <rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
        );
        let mut put = |text: String| {
            out.push_str(&text);
            out.push('\n');
        };
        let (bottom, right) = (TOP + self.height, WIDTH - RIGHT);
        for tick in ticks(self.x.1, self.x.2) {
            let (x, _) = self.place((tick, self.y.1));
            put(format!(
                "<path d=\"M{x:.1} {TOP}V{bottom:.1}\" stroke=\"#e2e2e2\"/>"
            ));
            let y = bottom + 17.0;
            put(format!(
                "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>",
                number(tick)
            ));
        }
        for tick in ticks(self.y.1, self.y.2) {
            let (_, y) = self.place((self.x.1, tick));
            put(format!(
                "<path d=\"M{LEFT} {y:.1}H{right}\" stroke=\"#e2e2e2\"/>"
            ));
            let (x, y) = (LEFT - 7.0, y + 4.0);
            put(format!(
                "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{}</text>",
                number(tick)
            ));
        }
        put(format!(
            "<path d=\"M{LEFT} {TOP}V{bottom:.1}H{right}\" fill=\"none\" stroke=\"#282828\"/>"
        ));
        let (x, y) = (f64::midpoint(LEFT, right), height - 10.0);
        put(format!(
            "<text x=\"{x}\" y=\"{y:.1}\" text-anchor=\"middle\">{}</text>",
            self.x.0
        ));
        let y = TOP + self.height / 2.0;
        let turned = format!("transform=\"translate(15 {y:.1}) rotate(-90)\"");
        put(format!(
            "<text {turned} text-anchor=\"middle\">{}</text>",
            self.y.0
        ));
        put(self.marks.trim_end().into());
        put("</svg>".into());
        out
    }
}

/// Some six to twelve round numbers from `low` to `high`.
fn ticks(low: f64, high: f64) -> impl Iterator<Item = f64> {
    let power = 10_f64.powf(((high - low) / 6.0).log10().floor());
    let step = [5.0, 2.0, 1.0]
        .into_iter()
        .map(|m| m * power)
        .find(|s| (high - low) / s >= 5.0)
        .unwrap_or(power);
    let first = (low / step - 1e-9).ceil();
    (0..40)
        .map(move |i| (first + f64::from(i)) * step)
        .take_while(move |x| *x <= high + 1e-9 * step)
}

fn number(x: f64) -> String {
    let text = format!("{x:.3}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" {
        "0".into()
    } else {
        short.replace('-', "−")
    }
}
