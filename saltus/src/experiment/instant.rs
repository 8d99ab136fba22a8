//! Instants on a logger's clock, as integers.
//!
//! A clock counts from anywhere: from the start of a program, from a trigger, from 1970. Only
//! differences of its times mean something, and near 1.7e9 s an `f64` is good to 1e-7 s alone. So
//! the digits of a file are read as an integer, and a time is the difference of two.

use std::fmt;

/// Decimal places of a second that count: to the picosecond. Finer digits are what floating-point
/// arithmetic leaves behind.
const PLACES: i64 = 12;
/// Picoseconds in a second.
const SECOND: i128 = 1_000_000_000_000;
/// Farthest instant (s) from a clock's zero: 3 million years, far from where an `i128` overflows.
const FARTHEST: f64 = 1e14;
/// What a time must be, in words.
pub(super) const ALLOWED: &str = "a time from -1e14 to 1e14 s";

/// An instant, in picoseconds from the zero of its clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Instant(i128);

impl Instant {
    /// The instant that the decimal `text` says in units of 10^`power` s, to the nearest
    /// picosecond; none where it is not [`ALLOWED`].
    pub(super) fn parse(text: &str, power: i32) -> Option<Instant> {
        let number: f64 = text.parse().ok()?;
        let is_near = number.abs() * 10f64.powi(power) <= FARTHEST;
        match (number == 0.0, is_near) {
            (true, _) => Some(Instant(0)),
            (false, true) => picoseconds(text, i64::from(power)).map(Instant),
            _ => None,
        }
    }

    /// The row of this number, where rows have no times.
    pub(super) fn of_row(number: usize) -> Instant {
        Instant(number as i128 * SECOND)
    }

    /// Picoseconds from `origin` to here.
    pub(super) fn picoseconds_since(self, origin: Instant) -> i128 {
        self.0 - origin.0
    }

    /// So many picoseconds later.
    pub(super) fn moved(self, picoseconds: i128) -> Instant {
        Instant(self.0 + picoseconds)
    }

    /// Time (s) from `origin` to here, the nearest `f64`.
    pub(super) fn since(self, origin: Instant) -> f64 {
        // Text is rounded once; a quotient of two rounded numbers would be rounded three times.
        format!("{}e-{PLACES}", self.picoseconds_since(origin))
            .parse()
            .unwrap_or(f64::NAN)
    }
}

/// The whole number of picoseconds nearest to a decimal that is a finite number, halves up: moving
/// a clock by whole picoseconds moves it as far.
fn picoseconds(text: &str, power: i64) -> Option<i128> {
    let is_negative = text.starts_with('-');
    let size = text.trim_start_matches(['+', '-']);
    let (mantissa, exponent) = size.split_once(['e', 'E']).unwrap_or((size, "0"));
    let (whole, part) = mantissa.split_once('.').unwrap_or((mantissa, ""));
    let digits = format!("{whole}{part}");
    // So many digits stand before the point of a number in picoseconds.
    let before = i64::try_from(whole.len()).ok()? + exponent.parse::<i64>().ok()? + power + PLACES;
    let Ok(before) = usize::try_from(before) else {
        return Some(0);
    };
    let (kept, cut) = digits.split_at(before.min(digits.len()));
    let kept: i128 = format!("0{kept}{}", "0".repeat(before - kept.len()))
        .parse()
        .ok()?;
    let half = if is_negative {
        cut > "5" && cut.trim_end_matches('0') != "5"
    } else {
        cut >= "5"
    };
    let size = kept + i128::from(half);
    Some(if is_negative { -size } else { size })
}

impl fmt::Display for Instant {
    /// In seconds, without needless digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let sign = if self.0 < 0 { "-" } else { "" };
        let (whole, part) = (self.0.abs() / SECOND, self.0.abs() % SECOND);
        let text = format!("{sign}{whole}.{part:012}");
        f.write_str(text.trim_end_matches('0').trim_end_matches('.'))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_read_to_the_picosecond() {
        let check = |text: &str, power: i32, picoseconds: Option<i128>| {
            assert_eq!(
                Instant::parse(text, power),
                picoseconds.map(Instant),
                "{text} e{power} s"
            );
        };
        check("0", 0, Some(0));
        check("-0.0e5", 0, Some(0));
        check("1.5", 0, Some(1_500_000_000_000));
        check("+.25E-3", 0, Some(250_000_000));
        check("-3.", 0, Some(-3_000_000_000_000));
        check(
            "1700000000.000000000001",
            0,
            Some(1_700_000_000_000_000_000_001),
        );
        check("1700000000123.4", -3, Some(1_700_000_000_123_400_000_000));
        check(
            "1700000000123456789",
            -9,
            Some(1_700_000_000_123_456_789_000),
        );
        check("0.30000000000000004", 0, Some(300_000_000_000));
        check("1e-12", 0, Some(1));
        check("5e-13", 0, Some(1));
        check("-5e-13", 0, Some(0));
        check("-5.1e-13", 0, Some(-1));
        check("4.999e-13", 0, Some(0));
        check("5e-14", 0, Some(0));
        check("1e-400", 0, Some(0));
        check(
            "000000000000000000000000000000000000000000000002e0",
            0,
            Some(2_000_000_000_000),
        );
        check("1e14", 0, Some(100_000_000_000_000_000_000_000_000));
        check("1e15", 0, None);
        for text in ["", "inf", "nan", "1e400", "1,5", "0x10", "e5", "."] {
            check(text, 0, None);
        }
    }

    #[test]
    fn a_constant_drops_out() {
        let at = |text: &str| Instant::parse(text, 0).unwrap();
        for offset in ["-1000", "-0.05", "0.2", "5", "1700000000"] {
            for k in 0..200 {
                let time = Instant(1_234_567_891 * k - 7);
                let moved = at(&Instant(time.0 + at(offset).0).to_string());
                let first = at(&Instant(-7 + at(offset).0).to_string());
                assert_eq!(moved.since(first), time.since(Instant(-7)), "{offset} {k}");
            }
        }
    }

    #[test]
    fn a_time_is_the_nearest_number() {
        for text in [
            "0",
            "0.1",
            "0.007",
            "-0.3",
            "12.345678901234",
            "99999.999999999999",
        ] {
            let nearest: f64 = text.parse().unwrap();
            assert_eq!(
                Instant::parse(text, 0).unwrap().since(Instant(0)),
                nearest,
                "{text}"
            );
        }
        assert_eq!(Instant::of_row(3).since(Instant(0)), 3.0);
    }
}
