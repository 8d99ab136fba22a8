//! Numbers with units as flags and files give them: `5`, `-15deg`, `25ms`.

use std::f64::consts::{FRAC_PI_2, PI};

use saltus::robot::units::{self, Unit};

use crate::error::cut;

/// A kind of number: its units, and what is allowed.
#[derive(Debug)]
pub(crate) struct Quantity {
    units: &'static units::Quantity,
    /// What is allowed, for messages.
    pub(crate) allowed: &'static str,
    legal: fn(f64) -> bool,
}

/// Kinds of numbers, a line each: units, what is allowed, and whether a number is.
macro_rules! quantities {
    ($($name:ident $units:ident $allowed:literal $legal:expr;)+) => {
        $(pub(crate) const $name: Quantity = Quantity {
            units: &units::$units,
            allowed: $allowed,
            legal: $legal,
        };)+
    };
}

impl Quantity {
    quantities! {
        RATE ANGULAR_RATE "a number from 0 to 1000 rad/s" |x| (0.0..=1e3).contains(&x);
        ANGLE ANGLE "an angle strictly between -pi/2 and pi/2 rad" |x| x.abs() < FRAC_PI_2;
        HEADING ANGLE "an angle from -pi to pi rad" |x| x.abs() <= PI;
        TIME TIME "a time from 0 to 1000 s" |x| (0.0..=1e3).contains(&x);
        OPEN TIME "a time above 0 and up to 1000 s" |x| x > 0.0 && x <= 1e3;
        RUN TIME "a time above 0 and up to 100000 s" |x| x > 0.0 && x <= 1e5;
        INSTANT TIME "a time from 0 to 100000 s" |x| (0.0..=1e5).contains(&x);
        STEP TIME "a time from 0.000001 to 0.1 s" |x| (1e-6..=0.1).contains(&x);
        FACTOR NUMBER "a number from 0 to 10000" |x| (0.0..=1e4).contains(&x);
        DISTANCE LENGTH "a distance from 0 to 1000 m" |x| (0.0..=1e3).contains(&x);
        EXTENT LENGTH "a length above 0 and up to 1000 m" |x| x > 0.0 && x <= 1e3;
        LANDING LENGTH "a place from -1000 to 1000 m" |x| x.abs() <= 1e3;
        HEIGHT LENGTH "a height from -1000 to 1000 m" |x| x.abs() <= 1e3;
    }

    /// The number that `text` gives, in the SI unit.
    pub(crate) fn parse(&self, text: &str) -> Result<f64, QuantityError> {
        if let Some(number) = value(text, self.units).filter(|x| (self.legal)(*x)) {
            return Ok(number);
        }
        Err(QuantityError {
            value: cut(text),
            allowed: self.allowed,
            units: written(self.units).map(|(unit, _)| unit).collect(),
        })
    }
}

/// The units of a quantity, each with how flags write it: `_rad_s` of a key is `rad/s`.
fn written(of: &units::Quantity) -> impl Iterator<Item = (String, Unit)> {
    let written = |key: &str| key.trim_start_matches('_').replace('_', "/");
    of.units
        .iter()
        .map(move |(key, unit)| (written(key), *unit))
}

/// The finite number (SI) that `text` gives, in one of the quantity's units.
pub(crate) fn value(text: &str, of: &units::Quantity) -> Option<f64> {
    let trimmed = text.trim();
    let ends = written(of).filter(|(unit, _)| trimmed.ends_with(unit));
    // `m` is the end of others.
    let (unit, scale) = ends
        .max_by_key(|(unit, _)| unit.len())
        .unwrap_or_else(|| (String::new(), Unit::SI));
    let number = scale.si(trimmed.strip_suffix(&*unit).unwrap_or_default().trim_end());
    Some(number).filter(|x| x.is_finite())
}

/// A text that is not an allowed number.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{value:?} must be {allowed}{}", self.known())]
pub(crate) struct QuantityError {
    value: String,
    allowed: &'static str,
    /// Suffixes that numbers may have.
    units: Vec<String>,
}

impl QuantityError {
    /// The units that are known, where the text is a number with another one.
    fn known(&self) -> String {
        let is_number = |end: &usize| {
            self.value
                .get(..*end)
                .is_some_and(|text| text.trim().parse::<f64>().is_ok())
        };
        let has_unit =
            !is_number(&self.value.len()) && (1..self.value.len()).any(|end| is_number(&end));
        if has_unit && self.units.len() > 1 {
            format!(
                ", with one of the units {} or without a unit",
                self.units.join(", ")
            )
        } else {
            String::new()
        }
    }
}

/// Two numbers, the lower first, with a colon between them; else `allowed` says what is.
pub(crate) fn span(text: &str, quantity: &Quantity, allowed: &str) -> Result<(f64, f64), String> {
    let refused = || format!("{:?} must be {allowed}", cut(text));
    let (low, high) = text.split_once(':').ok_or_else(refused)?;
    let number = |text| quantity.parse(text).map_err(|error| error.to_string());
    let (low, high) = (number(low)?, number(high)?);
    (low < high).then_some((low, high)).ok_or_else(refused)
}

/// Parsers of flags.
macro_rules! parsers {
    ($($name:ident $quantity:ident;)+) => {
        $(
            pub(crate) fn $name(text: &str) -> Result<f64, QuantityError> {
                Quantity::$quantity.parse(text)
            }
        )+
    };
}

parsers! {
    rate RATE;
    angle ANGLE;
    heading HEADING;
    distance DISTANCE;
    time TIME;
    factor FACTOR;
    height HEIGHT;
    extent EXTENT;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_converted_and_domains_kept() {
        let check = |quantity: &Quantity, text: &str, expected: Option<f64>| {
            assert_eq!(quantity.parse(text).ok(), expected, "{text}");
        };
        check(&Quantity::RATE, "5", Some(5.0));
        check(&Quantity::RATE, "5 rad/s", Some(5.0));
        check(&Quantity::RATE, "180deg/s", Some(std::f64::consts::PI));
        check(&Quantity::RATE, "-1", None);
        check(&Quantity::ANGLE, "-90deg", None);
        check(&Quantity::ANGLE, "-0.25rad", Some(-0.25));
        check(&Quantity::TIME, "25ms", Some(0.025));
        check(&Quantity::TIME, "0.1s", Some(0.1));
        check(&Quantity::DISTANCE, "21cm", Some(0.21));
        check(&Quantity::DISTANCE, "600 mm", Some(0.6));
        check(&Quantity::DISTANCE, "24in", Some(24.0 * 0.0254));
        check(&Quantity::HEIGHT, "-2 ft", Some(-0.6096));
        check(&Quantity::RATE, "30rpm", Some(std::f64::consts::PI));
        for text in [
            "", " ", "nan", "inf", "-inf", "1e999", "5m", "0x5", "5 5", "1e-", "m",
        ] {
            check(&Quantity::RATE, text, None);
        }
    }

    #[test]
    fn an_unknown_unit_is_answered_with_those_that_are_known() {
        let told = |quantity: &Quantity, text: &str| quantity.parse(text).unwrap_err().to_string();
        assert_eq!(
            told(&Quantity::DISTANCE, "3yd"),
            "\"3yd\" must be a distance from 0 to 1000 m, with one of the units m, mm, cm, in, ft \
             or without a unit"
        );
        assert!(told(&Quantity::RATE, "3Hz").contains("rad/s, deg/s, rpm"));
        assert_eq!(
            told(&Quantity::DISTANCE, "far"),
            "\"far\" must be a distance from 0 to 1000 m"
        );
        assert_eq!(
            told(&Quantity::DISTANCE, "1e9"),
            "\"1e9\" must be a distance from 0 to 1000 m"
        );
    }
}
