//! Bars under each other as SVG, for a page.

use std::fmt::Write;

use saltus::chart::escaped;

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
