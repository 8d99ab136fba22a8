//! Jumps in words.

use saltus::{Flight, FlightError, Jump, Outcome, Robot};

use super::compute::{Answer, Bearing};
use super::report::table;
use crate::output::digits;

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
        stance: lift_off,
        ..
    } = &answer.jump;
    let mut lines = vec![
        format!("{}: one jump", robot.name),
        line("approach rate", launch.rate, "rad/s"),
        line("start lean", launch.lean, "rad"),
        line("firing angle", launch.firing_angle, "rad"),
    ];
    if robot.leg.drive.has_valve() {
        lines.push(line("valve open", launch.valve_open, "s"));
    }
    lines.push(format!(
        "  {:<16} {}: {}",
        "outcome",
        lift_off.outcome.name(),
        meaning(lift_off.outcome)
    ));
    if let Some(flight) = answer.jump.exact_flight() {
        let Flight { x, y, vx, vy, .. } = flight.vacuum;
        lines.extend([
            line("lift-off", lift_off.time, "s after the start"),
            format!(
                "  {:<16} {} m forward, {} m up",
                "  centre at",
                short(x),
                short(y)
            ),
            format!(
                "  {:<16} {} m/s forward, {} m/s up",
                "  speed",
                short(vx),
                short(vy)
            ),
            format!(
                "  {:<16} {} rad, {} rad/s",
                "  lean and rate",
                short(lift_off.lean),
                short(lift_off.rate)
            ),
            line("apex", flight.apex_height(), "m"),
        ]);
        for (height, name) in [(robot.body.radius, "landing at r_s"), (0.0, "landing at 0")] {
            lines.push(match flight.range_to_height(height) {
                Ok(x) => line(
                    name,
                    x,
                    &format!("m ahead of the foot, centre at {height} m"),
                ),
                Err(FlightError::AboveApex { .. }) => {
                    format!("  {name:<16} never: the apex is below {height} m")
                }
                Err(error) => format!("  {name:<16} never: {error}"),
            });
        }
    }
    lines.extend(answer.bearing.as_ref().map(bearing).unwrap_or_default());
    lines.join("\n") + "\n"
}

fn bearing(Bearing { contact, energy }: &Bearing) -> [String; 3] {
    let friction = match contact.friction_needed {
        needed if needed.is_finite() => line(
            "friction needed",
            needed,
            "at least, for the foot not to slip",
        ),
        needed if needed.is_nan() => format!("  {:<16} –: the foot never stood", "friction needed"),
        _ => format!(
            "  {:<16} any: the ground would have to pull",
            "friction needed"
        ),
    };
    let work = format!(
        "{} J by the drive, {} J lost",
        short(energy.drive),
        short(energy.losses)
    );
    let normal = match contact.least_normal {
        normal if normal.is_finite() => line("least normal", normal, "N"),
        _ => format!("  {:<16} –: the foot never stood", "least normal"),
    };
    [normal, friction, format!("  {:<16} {work}", "work")]
}

fn line(name: &str, x: f64, unit: &str) -> String {
    format!("  {name:<16} {} {unit}", short(x))
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
