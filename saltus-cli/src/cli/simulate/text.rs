//! Jumps in words.

use saltus::{Flight, FlightError, Jump, Outcome, Robot};

use super::compute::{Answer, Bearing};
use super::report::table;
use crate::output::{self, digits};

/// Few jumps in full, many as a table.
pub(super) fn text(answers: &[Answer], robot: &Robot) -> String {
    if let [answer] = answers {
        return one(answer, robot);
    }
    format!(
        "{}: {} jumps\n{}",
        robot.name,
        answers.len(),
        table(answers, robot).text()
    )
}

/// One jump in words.
fn one(answer: &Answer, robot: &Robot) -> String {
    let Jump {
        launch,
        stance: end,
        ..
    } = &answer.jump;
    let mut lines = vec![
        ("approach rate", said(launch.rate, "rad/s")),
        ("start lean", said(launch.lean, "rad")),
        ("firing angle", said(launch.firing_angle, "rad")),
    ];
    if robot.leg.drive.has_valve() {
        lines.push(("valve open", said(launch.valve_open, "s")));
    }
    let (name, meaning) = (end.outcome.name(), meaning(end.outcome));
    lines.push(("outcome", format!("{name}: {meaning}")));
    if let Some(flight) = answer.jump.exact_flight() {
        let Flight { x, y, vx, vy, .. } = flight.vacuum;
        let [x, y, vx, vy, lean, rate] = [x, y, vx, vy, end.lean, end.rate].map(short);
        lines.extend([
            ("lift-off", said(end.time, "s after the start")),
            ("  centre at", format!("{x} m forward, {y} m up")),
            ("  speed", format!("{vx} m/s forward, {vy} m/s up")),
            ("  lean and rate", format!("{lean} rad, {rate} rad/s")),
            ("apex", said(flight.apex_height(), "m")),
        ]);
        for (height, name) in [(robot.body.radius, "landing at r_s"), (0.0, "landing at 0")] {
            let words = match flight.range_to_height(height) {
                Ok(x) => said(x, &format!("m ahead of the foot, centre at {height} m")),
                Err(FlightError::AboveApex { .. }) => {
                    format!("never: the apex is below {height} m")
                }
                Err(error) => format!("never: {error}"),
            };
            lines.push((name, words));
        }
    }
    lines.extend(answer.bearing.as_ref().map(bearing).into_iter().flatten());
    output::lines(&format!("{}: one jump", robot.name), 16, &lines)
}

fn bearing(Bearing { contact, energy }: &Bearing) -> [(&'static str, String); 3] {
    const NEVER: &str = "–: the foot never stood";
    let friction = match contact.friction_needed {
        needed if needed.is_finite() => said(needed, "at least, for the foot not to slip"),
        needed if needed.is_nan() => NEVER.into(),
        _ => "any: the ground would have to pull".into(),
    };
    let normal = match contact.least_normal {
        normal if normal.is_finite() => said(normal, "N"),
        _ => NEVER.into(),
    };
    let (drive, losses) = (short(energy.drive), short(energy.losses));
    let work = format!("{drive} J by the drive, {losses} J lost");
    [
        ("least normal", normal),
        ("friction needed", friction),
        ("work", work),
    ]
}

fn said(x: f64, unit: &str) -> String {
    format!("{} {unit}", short(x))
}

/// A number for people.
pub(super) fn short(x: f64) -> String {
    digits(x, 5)
}

fn meaning(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Stroke => "lift-off at the end of the stroke",
        Outcome::Force => "lift-off because the leg's force fell to 0",
        Outcome::Stall => "came to rest before the firing angle",
        Outcome::NoBreakAway => "the drive could not move the leg",
        Outcome::EarlyLiftOff => "left the ground before the leg was fired",
        Outcome::FallBack => "the leg came to a halt and sank back",
        _ => "ended without lift-off",
    }
}
