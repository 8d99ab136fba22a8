//! Slips of unit: factors and offsets that a wrong unit makes, and what to say where an estimate
//! equals one.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// What a number is about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Estimated<'a> {
    /// SI unit of the quantity.
    pub(crate) unit: &'a str,
    /// What was believed, in that unit; 1 of a factor.
    pub(crate) believed: f64,
    /// What was found.
    pub(crate) value: f64,
    /// Its standard error.
    pub(crate) error: f64,
    /// Whether it is the factor of a sensor, whose reading is so many times the truth; a factor
    /// elsewhere is truth over belief.
    pub(crate) is_gain: bool,
}

/// Units that are taken for each other: one of the first is so many of the second (whose SI unit
/// comes first).
const UNITS: [(&str, &str, f64, &str); 30] = [
    ("kg", "lb", 0.453_592_37, "kg"),
    ("kg", "oz", 0.028_349_523_125, "kg"),
    ("kg", "g", 1e-3, "kg"),
    ("m", "inch", 0.0254, "m"),
    ("m", "ft", 0.3048, "m"),
    ("m", "mm", 1e-3, "m"),
    ("m", "cm", 1e-2, "m"),
    ("m", "mm", 0.1, "cm"),
    ("m", "inch", 2.54, "cm"),
    ("m", "inch", 25.4, "mm"),
    ("m", "the radius", 0.5, "the diameter"),
    ("Pa", "psi", 6_894.757_293_168, "Pa"),
    ("Pa", "kPa", 1e3, "Pa"),
    ("Pa", "bar", 1e5, "Pa"),
    ("Pa", "MPa", 1e6, "Pa"),
    ("Pa", "bar", 0.1, "MPa"),
    ("Pa", "psi", 6.894_757_293_168, "kPa"),
    ("Pa", "mmHg", 133.322_387_415, "Pa"),
    ("rad", "degrees", PI / 180.0, "rad"),
    ("rad", "turns", TAU, "rad"),
    ("rad", "one count", 0.5, "two (of an encoder)"),
    ("rad", "one count", 0.25, "four (of an encoder)"),
    ("rad/s", "degrees/s", PI / 180.0, "rad/s"),
    ("rad/s", "rpm", TAU / 60.0, "rad/s"),
    ("N", "kgf", 9.806_65, "N"),
    ("N", "lbf", 4.448_221_615_260_5, "N"),
    ("s", "ms", 1e-3, "s"),
    ("m³", "cm³", 1e-6, "m³"),
    ("m³", "l", 1e-3, "m³"),
    ("m²", "mm²", 1e-6, "m²"),
];

/// Offsets that a wrong zero makes: unit, size, and what it means if it is added and if it is
/// missing.
const ZEROS: [(&str, f64, [&str; 2]); 5] = [
    (
        "Pa",
        101_325.0,
        [
            "one atmosphere: is the pressure gauge instead of absolute?",
            "one atmosphere: is the pressure absolute instead of gauge?",
        ],
    ),
    ("K", 273.15, ["0 °C in K: is the temperature in °C?"; 2]),
    (
        "rad",
        FRAC_PI_2,
        ["a quarter turn: is the zero at the horizontal?"; 2],
    ),
    (
        "rad",
        PI,
        ["half a turn: does the angle count from the other side?"; 2],
    ),
    (
        "rad",
        TAU,
        ["a whole turn: did the counter start one turn off?"; 2],
    ),
];

/// Standard errors within which an estimate equals a slip.
const ERRORS: f64 = 3.0;
/// The same in terms of the slip, where the standard error is smaller than what models are true to.
const TRUE: f64 = 2e-3;
/// Standard error, in terms of the value, above which an estimate equals too many numbers.
const VAGUE: f64 = 0.01;

/// What to say of an estimate that equals a slip of unit.
pub(crate) fn slip(of: &Estimated<'_>) -> Option<String> {
    factor(of).or_else(|| zero(of))
}

fn factor(of: &Estimated<'_>) -> Option<String> {
    let (ratio, error) = (of.value / of.believed, (of.error / of.value).abs());
    let is_clear = error < VAGUE;
    if !ratio.is_finite() || ratio <= 0.0 || !is_clear {
        return None;
    }
    let ratio = if of.is_gain { 1.0 / ratio } else { ratio };
    let is = |known: f64| (ratio / known - 1.0).abs() <= (ERRORS * error).max(TRUE);
    UNITS
        .iter()
        .filter(|(unit, ..)| *unit == of.unit)
        .find_map(|(_, one, size, other)| {
            let said = |one: &str, other: &str| format!("that is {one} for {other}");
            if is(*size) {
                Some(said(one, other))
            } else if is(1.0 / size) {
                Some(said(other, one))
            } else {
                None
            }
        })
}

fn zero(of: &Estimated<'_>) -> Option<String> {
    let off = of.value - of.believed;
    ZEROS
        .iter()
        .filter(|(unit, ..)| *unit == of.unit && !of.is_gain)
        .find_map(|(_, size, [added, missing])| {
            let is_clear = of.error < VAGUE * size;
            let is_near = (off.abs() - size).abs() <= (ERRORS * of.error).max(TRUE * size);
            (is_clear && is_near)
                .then(|| format!("that is {}", if off > 0.0 { added } else { missing }))
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(unit: &str, believed: f64, value: f64, error: f64, is_gain: bool) -> Option<String> {
        slip(&Estimated {
            unit,
            believed,
            value,
            error,
            is_gain,
        })
    }

    #[test]
    fn estimates_that_equal_a_slip_say_so() {
        let check = |unit: &str, believed: f64, value: f64, error: f64, words: &str| {
            assert_eq!(
                told(unit, believed, value, error, false).as_deref(),
                Some(words),
                "{value}"
            );
        };
        check(
            "Pa",
            0.0,
            -101_365.0,
            54.0,
            "that is one atmosphere: is the pressure absolute instead of gauge?",
        );
        check("kg", 1.0, 0.4537, 2e-4, "that is lb for kg");
        check("kg", 1.0, 2.204, 2e-3, "that is kg for lb");
        check("m", 0.3, 0.3 * 0.0254, 1e-6, "that is inch for m");
        check("m", 0.06, 6e-5, 1e-8, "that is mm for m");
        check("m³", 5.4, 5.4e-6, 1e-9, "that is cm³ for m³");
        check("Pa", 120.0, 827_370.0, 100.0, "that is psi for Pa");
        check("rad", 1.0, 57.296, 0.01, "that is rad for degrees");
        check(
            "rad",
            0.0,
            1.571,
            1e-3,
            "that is a quarter turn: is the zero at the horizontal?",
        );
    }

    #[test]
    fn a_reading_counts_the_other_way_round() {
        assert_eq!(
            told("m", 1.0, 3.281, 1e-3, true).as_deref(),
            Some("that is ft for m")
        );
        assert_eq!(
            told("N", 1.0, 0.2248, 1e-4, true).as_deref(),
            Some("that is lbf for N")
        );
    }

    #[test]
    fn others_do_not() {
        assert_eq!(told("kg", 1.0, 0.47, 2e-3, false), None);
        assert_eq!(told("kg", 1.0, 0.46, 0.02, false), None, "too vague");
        assert_eq!(told("Pa", 0.0, -90_000.0, 500.0, false), None);
        assert_eq!(told("N s/m", 1.0, 1e-3, 1e-6, false), None);
        assert_eq!(told("kg", 1.0, 0.4536, f64::NAN, false), None);
    }
}
