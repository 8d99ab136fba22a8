//! Numbers with units as flags and files give them: `5`, `-15deg`, `25ms`.

use crate::error::cut;

/// A kind of number: its unit, others that it may be given in, and what is allowed.
#[derive(Debug)]
pub(crate) struct Quantity {
    /// The unit of a number without a suffix, and whether that number is `divided` or multiplied to
    /// get there.
    suffixes: &'static [(&'static str, Scale)],
    /// What is allowed, for messages.
    pub(crate) allowed: &'static str,
    legal: fn(f64) -> bool,
}

/// How a unit becomes the SI one. Division by a power of ten rounds to what the user typed.
#[derive(Clone, Copy, Debug)]
enum Scale {
    Times(f64),
    Over(f64),
}

impl Quantity {
    /// Approach rate (rad/s).
    pub(crate) const RATE: Quantity = Quantity {
        suffixes: &[
            ("rad/s", Scale::Times(1.0)),
            ("deg/s", DEGREES),
            ("rpm", Scale::Times(std::f64::consts::TAU / 60.0)),
        ],
        allowed: "a number from 0 to 1000 rad/s",
        legal: |x| (0.0..=1e3).contains(&x),
    };
    /// Lean (rad).
    pub(crate) const ANGLE: Quantity = Quantity {
        suffixes: &[("rad", Scale::Times(1.0)), ("deg", DEGREES)],
        allowed: "an angle strictly between -pi/2 and pi/2 rad",
        legal: |x| x.abs() < std::f64::consts::FRAC_PI_2,
    };
    /// Heading (rad).
    pub(crate) const HEADING: Quantity = Quantity {
        allowed: "an angle from -pi to pi rad",
        legal: |x| x.abs() <= std::f64::consts::PI,
        ..Quantity::ANGLE
    };
    /// Place on the ground (m), along one axis.
    pub(crate) const PLACE: Quantity = Quantity {
        suffixes: METRES,
        allowed: "a number from -100 to 100 m",
        legal: |x| x.abs() <= 100.0,
    };
    /// Time (s).
    pub(crate) const TIME: Quantity = Quantity {
        suffixes: &[("ms", Scale::Over(1e3)), ("s", Scale::Times(1.0))],
        allowed: "a time from 0 to 1000 s",
        legal: |x| (0.0..=1e3).contains(&x),
    };
    /// Distance (m).
    pub(crate) const DISTANCE: Quantity = Quantity {
        suffixes: METRES,
        allowed: "a distance from 0 to 1000 m",
        legal: |x| (0.0..=1e3).contains(&x),
    };
    /// Time that a valve is open (s).
    pub(crate) const OPEN: Quantity = Quantity {
        suffixes: &[("ms", Scale::Over(1e3)), ("s", Scale::Times(1.0))],
        allowed: "a time above 0 and up to 1000 s",
        legal: |x| x > 0.0 && x <= 1e3,
    };
    /// Length of a run (s).
    pub(crate) const RUN: Quantity = Quantity {
        suffixes: &[
            ("min", Scale::Times(60.0)),
            ("ms", Scale::Over(1e3)),
            ("s", Scale::Times(1.0)),
        ],
        allowed: "a time above 0 and up to 100000 s",
        legal: |x| x > 0.0 && x <= 1e5,
    };
    /// An instant of a run (s).
    pub(crate) const INSTANT: Quantity = Quantity {
        allowed: "a time from 0 to 100000 s",
        legal: |x| (0.0..=1e5).contains(&x),
        ..Quantity::RUN
    };
    /// Step of the simulation (s).
    pub(crate) const STEP: Quantity = Quantity {
        suffixes: &[
            ("us", Scale::Over(1e6)),
            ("ms", Scale::Over(1e3)),
            ("s", Scale::Times(1.0)),
        ],
        allowed: "a time from 0.000001 to 0.1 s",
        legal: |x| (1e-6..=0.1).contains(&x),
    };
    /// Number without a unit.
    pub(crate) const FACTOR: Quantity = Quantity {
        suffixes: &[],
        allowed: "a number from 0 to 10000",
        legal: |x| (0.0..=1e4).contains(&x),
    };
    /// Extent of an obstacle (m).
    pub(crate) const EXTENT: Quantity = Quantity {
        suffixes: METRES,
        allowed: "a length above 0 and up to 1000 m",
        legal: |x| x > 0.0 && x <= 1e3,
    };
    /// Where a jump lands (m), which may be behind the foot.
    pub(crate) const LANDING: Quantity = Quantity {
        suffixes: METRES,
        allowed: "a place from -1000 to 1000 m",
        legal: |x| x.abs() <= 1e3,
    };
    /// Height (m), which may be below the foot.
    pub(crate) const HEIGHT: Quantity = Quantity {
        suffixes: METRES,
        allowed: "a height from -1000 to 1000 m",
        legal: |x| x.abs() <= 1e3,
    };

    /// The number that `text` gives, in the SI unit.
    pub(crate) fn parse(&self, text: &str) -> Result<f64, QuantityError> {
        let refused = || QuantityError {
            value: cut(text),
            allowed: self.allowed,
            units: self.suffixes.iter().map(|(suffix, _)| *suffix).collect(),
        };
        let text = text.trim();
        let split = self
            .suffixes
            .iter()
            .find_map(|(suffix, scale)| Some((text.strip_suffix(suffix)?, *scale)));
        let (digits, scale) = split.unwrap_or((text, Scale::Times(1.0)));
        let number: f64 = digits.trim_end().parse().map_err(|_| refused())?;
        let number = match scale {
            Scale::Times(factor) => number * factor,
            Scale::Over(divisor) => number / divisor,
        };
        if number.is_finite() && (self.legal)(number) {
            Ok(number)
        } else {
            Err(refused())
        }
    }
}

const DEGREES: Scale = Scale::Times(std::f64::consts::PI / 180.0);

/// `m` is the end of the others, so it stands last.
const METRES: &[(&str, Scale)] = &[
    ("mm", Scale::Over(1e3)),
    ("cm", Scale::Over(1e2)),
    ("in", Scale::Times(0.0254)),
    ("ft", Scale::Times(0.3048)),
    ("m", Scale::Times(1.0)),
];

/// A text that is not an allowed number.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{value:?} must be {allowed}{}", self.known())]
pub(crate) struct QuantityError {
    value: String,
    allowed: &'static str,
    /// Suffixes that numbers may have.
    units: Vec<&'static str>,
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
        if has_unit && !self.units.is_empty() {
            format!(
                ", with one of the units {} or without a unit",
                self.units.join(", ")
            )
        } else {
            String::new()
        }
    }
}

macro_rules! parsers {
    ($($name:ident $quantity:ident;)+) => {$(
        /// Parser of a flag.
        pub(crate) fn $name(text: &str) -> Result<f64, QuantityError> {
            Quantity::$quantity.parse(text)
        }
    )+};
}

parsers! {
    rate RATE;
    angle ANGLE;
    heading HEADING;
    distance DISTANCE;
    factor FACTOR;
    time TIME;
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
            "\"3yd\" must be a distance from 0 to 1000 m, with one of the units mm, cm, in, ft, m \
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
