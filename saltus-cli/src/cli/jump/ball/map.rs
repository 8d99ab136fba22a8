//! The report of the map of places at which a robot can land.

use std::fmt::Write as _;

use saltus::gait::Obstacle;
use saltus::gait::space::jump::{Command, Spot};
use saltus::running::Share;
use serde_json::{Value, json};

use super::answer::{a_box, numbers};
use super::{ENOUGH, Nearby, short};
use crate::cli::run::{in_words, share};
use crate::output::{Cell, Table, digits};
use crate::plot::Drawing;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREEN, GREY, INK};
use crate::plot::sheet::{Panel, Sheet};

/// The map of places.
pub(super) struct Map<'a> {
    pub(super) name: &'a str,
    pub(super) spacing: f64,
    pub(super) spots: &'a [Spot],
    pub(super) shares: &'a [Option<Nearby>],
    pub(super) feet: Vec<(f64, f64)>,
    pub(super) obstacle: Option<Obstacle>,
}

impl Map<'_> {
    /// All jumps to places that are reached.
    pub(super) fn together(&self) -> Share {
        let all = || self.shares.iter().flatten().map(|it| &it.near);
        Share {
            count: all().map(|share| share.count).sum(),
            of: all().map(|share| share.of).sum(),
        }
    }

    fn reached(&self) -> impl Iterator<Item = (&Spot, &Share)> {
        let both = self.spots.iter().zip(self.shares);
        both.filter_map(|(spot, share)| Some((spot, &share.as_ref()?.near)))
    }

    pub(super) fn text(&self) -> String {
        let mut text = format!(
            "{}: landing places from rest, {} m apart\n",
            self.name,
            digits(self.spacing, 4)
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        if let Some(obstacle) = &self.obstacle {
            line("before", a_box(obstacle));
        }
        let count = self.reached().count();
        line(
            "in reach",
            format!("{count} of {} places", self.spots.len()),
        );
        let far = |spot: &Spot| spot.target[0].hypot(spot.target[1]);
        let farthest = self
            .reached()
            .map(|(spot, _)| far(spot))
            .fold(0.0, f64::max);
        line("farthest", format!("{} m", digits(farthest, 4)));
        line("jumps within 10 cm", in_words(&self.together()));
        let enough = self.reached().filter(|(_, share)| share.value() >= ENOUGH);
        line("places with 90 %", format!("{} of {count}", enough.count()));
        let least = self
            .reached()
            .min_by(|a, b| a.1.value().total_cmp(&b.1.value()));
        if let Some((spot, share)) = least {
            let [x, y] = spot.target.map(short);
            line("least", format!("{} at ({x}, {y}) m", in_words(share)));
        }
        text
    }

    pub(super) fn table(&self) -> Table {
        let mut table = Table::new(&[
            "x_m",
            "y_m",
            "is_reached",
            "mean_off_m",
            "miss_m",
            "within_10_cm",
            "of",
            "apex_m",
            "flight_s",
            "firings",
        ]);
        for (spot, share) in self.spots.iter().zip(self.shares) {
            let plan = &spot.plan;
            let firing = |command: &Command| {
                let at = digits(1e3 * command.at, 4);
                format!("{}@{at}ms:{}ms", command.leg, digits(1e3 * command.open, 4))
            };
            let firings: Vec<String> = plan.jump.commands.iter().map(firing).collect();
            let lift = plan.flown.lift.map(|lift| lift.time);
            let touch = plan.flown.touch;
            let flight = lift.zip(touch).map(|(lift, touch)| touch.time - lift);
            let count = |of: fn(&Share) -> usize| {
                let count = |it: &Nearby| Cell::Count(of(&it.near));
                share.as_ref().map_or(Cell::Empty, count)
            };
            table.push(vec![
                spot.target[0].into(),
                spot.target[1].into(),
                Cell::Flag(plan.is_reached()),
                plan.off.into(),
                plan.miss.into(),
                count(|share| share.count),
                count(|share| share.of),
                touch.map(|touch| touch.apex).into(),
                flight.into(),
                Cell::Text(firings.join(" ")),
            ]);
        }
        table
    }

    pub(super) fn json(&self, seed: u64) -> Value {
        json!({
            "command": "jump",
            "robot": self.name,
            "spacing_m": self.spacing,
            "obstacle": self.obstacle.as_ref().map(numbers),
            "reached": self.reached().count(),
            "within_10_cm": share(&self.together()),
            "places": self.table().json(),
            "seed": seed,
        })
    }

    pub(super) fn drawing(&self) -> Drawing {
        let of = |keeps: &dyn Fn(&Option<Nearby>) -> bool| {
            let both = self.spots.iter().zip(self.shares);
            let kept = both.filter(|(_, share)| keeps(share));
            kept.map(|(spot, _)| (spot.target[0], spot.target[1]))
                .collect::<Vec<_>>()
        };
        let enough = |share: &Nearby| share.near.value() >= ENOUGH;
        let dots = |label: &str, points, color| Line {
            label: Some(label.into()),
            points,
            color,
            mark: Mark::Dots,
        };
        let lines = vec![
            dots(
                "9 of 10 robots land within 10 cm",
                of(&|it| it.as_ref().is_some_and(enough)),
                GREEN,
            ),
            dots(
                "fewer do",
                of(&|it| it.as_ref().is_some_and(|it| !enough(it))),
                BLUE,
            ),
            dots("out of reach", of(&Option::is_none), GREY),
            dots("feet at rest", self.feet.clone(), INK),
        ];
        let high = |(spot, _): (&Spot, &Share)| {
            let apex = spot.plan.flown.touch.map(|touch| touch.apex)?;
            Some((spot.target[0].hypot(spot.target[1]), apex))
        };
        let heights = self.reached().filter_map(high).collect();
        let heights = vec![dots("jumps to places in reach", heights, BLUE)];
        Drawing::Sheet(Sheet {
            title: format!("{}: where it lands from rest", self.name),
            course: None,
            panels: vec![
                Panel {
                    title: "landing of the middle".into(),
                    x: "ahead (m)",
                    y: "to the left (m)",
                    lines,
                    least: None,
                },
                Panel {
                    title: "greatest height on the way".into(),
                    x: "distance (m)",
                    y: "height of the middle (m)",
                    lines: heights,
                    least: None,
                },
            ],
        })
    }
}
