//! The hopper of the problem set, with its parameters by key.

use saltus::planner::parkour::Hopper;

use crate::error::{CliError, cut};

/// What the hopper is called.
pub(super) const NAME: &str = "mppc-hopper";

/// A parameter: its key, where it is, what is allowed.
struct Parameter {
    key: &'static str,
    place: fn(&mut Hopper) -> &mut f64,
    allowed: &'static str,
    legal: fn(f64) -> bool,
}

const POSITIVE: (&str, fn(f64) -> bool) =
    ("a number above 0 and up to 1000", |x| x > 0.0 && x <= 1e3);
const LENGTH: (&str, fn(f64) -> bool) = ("a length from 0 to 10 m", |x| (0.0..=10.0).contains(&x));
const ANGLE: (&str, fn(f64) -> bool) = ("an angle above pi/4 and below pi/2 rad", |x| {
    x > std::f64::consts::FRAC_PI_4 && x < std::f64::consts::FRAC_PI_2
});

const PARAMETERS: [Parameter; 9] = [
    parameter("gravity_m_s2", |h| &mut h.gravity, POSITIVE),
    parameter("least_speed_m_s", |h| &mut h.speed.low, POSITIVE),
    parameter("greatest_speed_m_s", |h| &mut h.speed.high, POSITIVE),
    parameter("least_angle_rad", |h| &mut h.angle.low, ANGLE),
    parameter("greatest_angle_rad", |h| &mut h.angle.high, ANGLE),
    parameter("least_time_s", |h| &mut h.time.low, POSITIVE),
    parameter("greatest_time_s", |h| &mut h.time.high, POSITIVE),
    parameter("clearance_m", |h| &mut h.clearance, LENGTH),
    parameter("edge_margin_m", |h| &mut h.edge_margin, LENGTH),
];

const fn parameter(
    key: &'static str,
    place: fn(&mut Hopper) -> &mut f64,
    (allowed, legal): (&'static str, fn(f64) -> bool),
) -> Parameter {
    Parameter {
        key,
        place,
        allowed,
        legal,
    }
}

/// The hopper with its overrides.
pub(super) fn resolve(name: &str, overrides: &[String]) -> Result<Hopper, CliError> {
    if name != NAME {
        return Err(CliError::flag(
            "--robot",
            cut(name),
            format!("{NAME}: these courses are the hopper's"),
        ));
    }
    let mut hopper = Hopper::default();
    for text in overrides {
        set(&mut hopper, text)?;
    }
    let spans = [
        ("speed", hopper.speed),
        ("angle", hopper.angle),
        ("time", hopper.time),
    ];
    match spans.into_iter().find(|(_, span)| span.low >= span.high) {
        Some((what, span)) => Err(CliError::flag(
            "--set",
            format!("least {what} {}, greatest {}", span.low, span.high),
            "the least below the greatest",
        )),
        None => Ok(hopper),
    }
}

fn set(hopper: &mut Hopper, text: &str) -> Result<(), CliError> {
    let refused = |allowed: String| CliError::flag("--set", cut(text), allowed);
    let (key, value) = text
        .split_once('=')
        .ok_or_else(|| refused("KEY=VALUE".into()))?;
    let Some(parameter) = PARAMETERS
        .iter()
        .find(|parameter| parameter.key == key.trim())
    else {
        return Err(refused(format!(
            "one of {}",
            PARAMETERS.map(|parameter| parameter.key).join(", ")
        )));
    };
    match value.trim().parse() {
        Ok(number) if (parameter.legal)(number) => *(parameter.place)(hopper) = number,
        _ => return Err(refused(parameter.allowed.into())),
    }
    Ok(())
}
