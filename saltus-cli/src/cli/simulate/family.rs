//! Jumps as a family of paths.

use saltus::{Launch, Robot};

use super::compute::Answer;
use super::text::short;
use crate::plot::tick;
use crate::plot::trajectories::{Trajectories, Trajectory};

/// What may tell two launches apart.
type Key = fn(&Launch) -> f64;

/// The paths of the wheel's centre.
pub(super) fn family(answers: &[Answer], robot: &Robot) -> Trajectories {
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
    let (labels, key) = keys
        .into_iter()
        .find(|(_, key)| differs(*key))
        .unwrap_or(keys[0]);
    let path = |answer: &Answer| Trajectory {
        stance: answer.path.clone(),
        flight: flight_path(answer),
        label: tick(key(&answer.jump.launch)),
    };
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
    Trajectories {
        title,
        labels: labels.into(),
        paths: answers.iter().map(path).collect(),
        radius: robot.body.radius,
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
