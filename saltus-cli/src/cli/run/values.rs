//! Values of the flags of a gait.

use crate::error::cut;
use crate::quantity::{Quantity, QuantityError};

/// Knots of a curve: rate (rad/s), angle (rad), time (s).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Knots(pub(crate) Vec<[f64; 3]>);

/// Commanded speeds: from each time (s) on, a speed (m/s).
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Speeds(pub(super) Vec<[f64; 2]>);

/// Weights of a filter.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Taps(pub(crate) Vec<f64>);

/// A number as it is, with what is allowed.
fn plain(text: &str, allowed: &'static str, legal: impl Fn(f64) -> bool) -> Result<f64, String> {
    let number = text.trim().parse::<f64>().ok();
    number
        .filter(|x| x.is_finite() && legal(*x))
        .ok_or_else(|| format!("{:?} must be {allowed}", cut(text)))
}

/// Parser of a flag.
pub(super) fn steepness(text: &str) -> Result<f64, String> {
    plain(text, "a number above 0 and up to 1000 (1/s)", |x| {
        x > 0.0 && x <= 1e3
    })
}

/// Parser of a flag.
pub(super) fn shift(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('s');
    plain(
        number,
        "a number from -1000 to 1000, or so many seconds",
        |x| x.abs() <= 1e3,
    )
}

/// Parser of a flag.
pub(super) fn slope(text: &str) -> Result<f64, String> {
    let number = text.trim().trim_end_matches('s');
    plain(number, "a slope from -10 to 10 s", |x| x.abs() <= 10.0)
}

/// Parser of a flag.
pub(super) fn rate(text: &str) -> Result<f64, QuantityError> {
    Quantity::RATE.parse(text)
}

/// Parser of a flag.
pub(super) fn top_rate(text: &str) -> Result<f64, String> {
    match rate(text) {
        Ok(rate) if rate > 0.0 => Ok(rate),
        Ok(_) => Err(format!("{:?} must be above 0 rad/s", cut(text))),
        Err(error) => Err(error.to_string()),
    }
}

/// Parser of a flag.
pub(crate) fn knots(text: &str) -> Result<Knots, String> {
    let shape = || {
        format!(
            "{:?} must be RATE:ANGLE:TIME with commas between knots, as in 0:0.35:40ms,13.3:-0.1:40ms",
            cut(text)
        )
    };
    let mut all: Vec<[f64; 3]> = Vec::new();
    for knot in text.split(',') {
        let parts: Vec<&str> = knot.split(':').collect();
        let [rate, angle, time] = parts[..] else {
            return Err(shape());
        };
        let said = |error: QuantityError| error.to_string();
        let knot = [
            Quantity::RATE.parse(rate).map_err(said)?,
            Quantity::ANGLE.parse(angle).map_err(said)?,
            Quantity::TIME.parse(time).map_err(said)?,
        ];
        if knot[2] > 1.0 {
            return Err(format!(
                "valve opening time {} s must be from 0 to 1 s",
                knot[2]
            ));
        }
        if let Some([before, ..]) = all.last().filter(|[before, ..]| knot[0] < *before) {
            return Err(format!(
                "rate {} rad/s must not be below the one before it, {} rad/s",
                knot[0], before
            ));
        }
        all.push(knot);
    }
    if all.len() > 1000 {
        return Err(format!("{} knots are too many: at most 1000", all.len()));
    }
    Ok(Knots(all))
}

/// Parser of a flag.
pub(super) fn speeds(text: &str) -> Result<Speeds, String> {
    let shape = || {
        format!(
            "{:?} must be TIME:SPEED in s and m/s with commas between, as in 0:1.5,4:3,8:-1",
            cut(text)
        )
    };
    let mut all: Vec<[f64; 2]> = Vec::new();
    for part in text.split(',') {
        let (time, speed) = part.split_once(':').ok_or_else(shape)?;
        let time = Quantity::INSTANT
            .parse(time)
            .map_err(|error| error.to_string())?;
        let speed = speed.trim().trim_end_matches("m/s");
        let speed = plain(speed, "a speed from -10 to 10 m/s", |x| x.abs() <= 10.0)?;
        if let Some([before, _]) = all.last().filter(|[before, _]| time <= *before) {
            return Err(format!(
                "time {time} s must be after the one before it, {before} s"
            ));
        }
        all.push([time, speed]);
    }
    Ok(Speeds(all))
}

/// Parser of a flag.
pub(crate) fn taps(text: &str) -> Result<Taps, String> {
    let number = |part: &str| plain(part, "a number", |_| true);
    let taps = text.split(',').map(number).collect::<Result<Vec<_>, _>>()?;
    if taps.len() > 16 {
        return Err(format!("{} weights are too many: at most 16", taps.len()));
    }
    let sum: f64 = taps.iter().sum();
    if sum.abs() <= 1e-9 {
        return Err(format!(
            "the weights' sum {sum} must be a number other than 0"
        ));
    }
    // Weights say how readings share in the mean, not how long the mean is.
    Ok(Taps(taps.iter().map(|weight| weight / sum).collect()))
}
