//! How near robots came to touching a box, in words.

use saltus::running::Share;
use serde_json::{Value, json};

use crate::output::{digits, measured};

/// What came of a robot before a box.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passage {
    /// Whether it came to the other side.
    pub(super) is_over: bool,
    /// Least distance (m) to the box where it is not solid.
    pub(super) clearance: f64,
}

/// Those of many robots.
#[derive(Clone, Debug)]
pub(super) struct Margin {
    robots: usize,
    /// Clearances (m) of those that came to the other side, rising.
    over: Vec<f64>,
}

impl Margin {
    pub(super) fn of(all: impl Iterator<Item = Passage>) -> Margin {
        let (mut robots, mut over) = (0, Vec::new());
        for passage in all {
            robots += 1;
            if passage.is_over && passage.clearance.is_finite() {
                over.push(passage.clearance);
            }
        }
        over.sort_by(f64::total_cmp);
        Margin { robots, over }
    }

    /// The clearance (m) that this part (%) of those that came over falls short of.
    fn part(&self, percent: usize) -> Option<f64> {
        let at = self.over.len() * percent / 100;
        self.over.get(at).or(self.over.last()).copied()
    }

    /// The lines of a report on a box `height` (m) high, and on what is nearer to being cleared by
    /// `enough` of the robots, if fewer clear it.
    pub(super) fn lines(&self, height: f64, share: Share, enough: f64) -> Vec<(String, String)> {
        let short = |x: f64| measured(x, 4);
        let (robots, over) = (self.robots, self.over.len());
        let mut lines = vec![(
            "over the box",
            format!("{over} of {robots}, touching it or not"),
        )];
        if let (Some(least), Some(middle)) = (self.part(5), self.part(50)) {
            let (least, middle) = (short(least), short(middle));
            let words = format!(
                "of these: {least} m or less for 5 %, {middle} m or less for half; below 0 they touch"
            );
            lines.push(("clearance", words));
        }
        if share.value() < enough {
            lines.push(("nearest feasible", self.advice(height, enough)));
        }
        lines
            .into_iter()
            .map(|(name, words)| (name.to_owned(), words))
            .collect()
    }

    /// Height (m) of a box that is nearer to being cleared by `enough` of the robots than one of
    /// `height` (m): lower by what 5 % lack. None where too few come to the other side, or nothing
    /// lacks.
    pub(super) fn nearer(&self, height: f64, enough: f64) -> Option<f64> {
        let is_enough = self.over.len() as f64 >= enough * self.robots as f64;
        let least = self.part(5).filter(|least| is_enough && *least < 0.0)?;
        (height + least > 0.0).then_some(height + least)
    }

    fn advice(&self, height: f64, enough: f64) -> String {
        match self.nearer(height, enough) {
            Some(nearer) => format!(
                "a box of about {} m, or a higher supply pressure, or a longer run-up",
                digits(nearer, 2)
            ),
            None => "a lower or shorter box, a higher supply pressure, or a longer run-up".into(),
        }
    }

    pub(super) fn json(&self) -> Value {
        json!({
            "over_the_box": self.over.len(),
            "5_percent": self.part(5),
            "median": self.part(50),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn margin(clearances: &[(bool, f64)]) -> Margin {
        let passage = |&(is_over, clearance): &(bool, f64)| Passage { is_over, clearance };
        Margin::of(clearances.iter().map(passage))
    }

    fn said(margin: &Margin, height: f64, share: Share) -> String {
        let lines = margin.lines(height, share, 0.95);
        lines.into_iter().map(|(_, words)| words + "\n").collect()
    }

    /// A robot that stops far before the box is no sign that a higher box can be cleared.
    #[test]
    fn only_robots_that_come_over_count() {
        let share = Share { count: 1, of: 4 };
        let stopped = margin(&[
            (true, 0.02),
            (false, 1.1),
            (false, f64::INFINITY),
            (false, 0.5),
        ]);
        let lines = said(&stopped, 0.03, share);
        assert!(lines.contains("1 of 4, touching"), "{lines}");
        assert!(lines.contains("a lower or shorter box"), "{lines}");
        let touched = margin(&[(true, -0.04), (true, -0.03), (true, 0.01), (true, 0.01)]);
        let lines = said(&touched, 0.21, share);
        assert!(lines.contains("a box of about 0.17 m"), "{lines}");
        let none = said(
            &margin(&[(false, f64::INFINITY)]),
            2.0,
            Share { count: 0, of: 1 },
        );
        assert!(!none.contains("inf") && !none.contains("NaN"), "{none}");
    }
}
