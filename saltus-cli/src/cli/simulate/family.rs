//! Jumps as a family of paths of the wheel's centre: stance solid, flight dotted.
//!
//! Source: thesis, figure 5.9.

use saltus::{Launch, Robot};

use super::compute::Answer;
use super::text::short;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{GREY, INK, RED, shade};
use crate::plot::sheet::{Label, Panel, Sheet, Side};
use crate::plot::tick;

/// Space (m) under the ground for the labels.
const CELLAR: f64 = 0.06;

/// What may tell two launches apart.
type Key = fn(&Launch) -> f64;

/// The paths of the wheel's centre.
pub(super) fn family(answers: &[Answer], robot: &Robot) -> Sheet {
    let differs = |key: Key| {
        answers
            .windows(2)
            .any(|w| key(&w[0].jump.launch) != key(&w[1].jump.launch))
    };
    let keys: [(&str, Key); 4] = [
        ("firing angle α_f (rad)", |launch| launch.firing_angle),
        ("approach rate ω₀ (rad/s)", |launch| launch.rate),
        ("valve opening time (s)", |launch| launch.valve_open),
        ("start lean φ₀ (rad)", |launch| launch.lean),
    ];
    let (names, key) = keys
        .into_iter()
        .find(|(_, key)| differs(*key))
        .unwrap_or(keys[0]);
    let level = |height| [(f64::NEG_INFINITY, height), (f64::INFINITY, height)];
    let words = format!("stance solid, flight dotted; under each path {names}");
    let mut lines = vec![
        Line::new(Mark::Stroke(2), INK, level(0.0)).called(words),
        Line::new(Mark::Stroke(1), GREY, level(robot.body.radius)).called("wheel's radius"),
    ];
    let mut labels = Vec::new();
    for (i, answer) in answers.iter().enumerate() {
        let (color, flight) = (shade(i, answers.len()), flight_path(answer));
        let stance = answer.path.iter().copied();
        lines.push(Line::new(Mark::Stroke(3), color, stance.clone()));
        if let Some((x, _)) = flight.last() {
            labels.push(Label {
                words: tick(key(&answer.jump.launch)),
                places: vec![(*x, 0.0)],
                side: Side::Below,
                color: INK,
            });
        } else {
            lines.push(Line::new(Mark::Cross, RED, stance.last()));
        }
        lines.push(Line::new(Mark::Dotted, color, flight));
    }
    lines.push(Line::new(Mark::Disc(4), INK, [(0.0, 0.0)]));
    let rate = answers
        .first()
        .filter(|_| !differs(|launch| launch.rate))
        .map(|answer| answer.jump.launch.rate);
    let title = match rate {
        Some(rate) => format!(
            "{}: path of the wheel's centre at ω₀ = {} rad/s",
            robot.name,
            short(rate)
        ),
        None => format!("{}: path of the wheel's centre", robot.name),
    };
    let panel = Panel {
        x: "x (m)",
        y: "y (m)",
        lines,
        labels,
        least: Some([[0.0; 2], [-CELLAR, 0.0]]),
        is_to_scale: true,
        ..Panel::default()
    };
    Sheet {
        title,
        wide: vec![panel],
        ..Sheet::default()
    }
}

fn flight_path(answer: &Answer) -> Vec<(f64, f64)> {
    const POINTS: usize = 2000;
    let landing = answer
        .jump
        .exact_flight()
        .and_then(|flight| Some((flight, flight.time_to_height(0.0).ok()?)));
    landing.map_or(Vec::new(), |(flight, end)| {
        flight
            .samples(0.0, end, POINTS)
            .map(|(_, x, y)| (x, y))
            .collect()
    })
}
