//! Numbers as text.

/// `x` with 17 significant digits, as C's `%.17g` writes it: every f64 reads back as itself.
pub(crate) fn full(x: f64) -> String {
    const DIGITS: i32 = 17;
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let scientific = format!("{x:.16e}");
    let Some((mantissa, exponent)) = scientific.split_once('e') else {
        return scientific;
    };
    let exponent: i32 = exponent.parse().unwrap_or_default();
    if !(-4..DIGITS).contains(&exponent) {
        let mantissa = mantissa.trim_end_matches('0').trim_end_matches('.');
        let sign = if exponent < 0 { '-' } else { '+' };
        return format!("{mantissa}e{sign}{:02}", exponent.unsigned_abs());
    }
    let sign = if x < 0.0 { "-" } else { "" };
    let digits: String = mantissa.chars().filter(char::is_ascii_digit).collect();
    let digits = digits.trim_end_matches('0');
    // How many digits stand before the point.
    match usize::try_from(exponent + 1) {
        Ok(whole @ 1..) if digits.len() <= whole => format!("{sign}{digits:0<whole$}"),
        Ok(whole @ 1..) => format!("{sign}{}.{}", &digits[..whole], &digits[whole..]),
        _ => format!(
            "{sign}0.{}{digits}",
            "000"
                .get(..(-1 - exponent).unsigned_abs() as usize)
                .unwrap_or_default()
        ),
    }
}

/// Size of a sum that is 0 but for round-off, where its terms are of the size 1.
const ROUND_OFF: f64 = 1e-15;
/// Lengths (m), angles (rad), rates, times (s), energies (J) and masses (g) below this are 0: motions are
/// computed to a few 1e-9.
const NOTHING: f64 = 1e-9;

/// A length, an angle, a rate, a time or the like, `x`, with `count` significant digits at most, for people.
pub(crate) fn measured(x: f64, count: usize) -> String {
    digits(if x.abs() < NOTHING { 0.0 } else { x }, count)
}

/// `x` with `count` significant digits at most, for people.
pub(crate) fn digits(x: f64, count: usize) -> String {
    if x.abs() < ROUND_OFF {
        return "0".into();
    }
    if !x.is_finite() {
        return x.to_string();
    }
    let rounded: f64 = format!("{x:.*e}", count.saturating_sub(1))
        .parse()
        .unwrap_or(x);
    if (1e-4..1e7).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

/// So many of what `noun` names, as in 1 run, 2 runs.
pub(crate) fn counted(count: usize, noun: &str) -> String {
    let ending = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{ending}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_numbers_are_those_of_c() {
        let check = |x: f64, text: &str| {
            assert_eq!(full(x), text);
            assert_eq!(full(x).parse::<f64>().unwrap().to_bits(), x.to_bits());
        };
        check(3.0, "3");
        check(0.0, "0");
        check(-0.0, "-0");
        check(0.025, "0.025000000000000001");
        check(-0.25, "-0.25");
        check(0.3, "0.29999999999999999");
        check(101_325.0, "101325");
        check(1e-4, "0.0001");
        check(0.5, "0.5");
        check(-0.012_5, "-0.012500000000000001");
        check(100.0, "100");
        check(12.5, "12.5");
        check(1e-5, "1.0000000000000001e-05");
        check(1.5e17, "1.5e+17");
        check(1e16, "10000000000000000");
        check(-330_207.287_810_37, "-330207.28781036998");
        check(5e-324, "4.9406564584124654e-324");
    }

    #[test]
    fn short_numbers_are_short() {
        let check = |x: f64, text: &str| assert_eq!(digits(x, 4), text);
        check(0.123_456, "0.1235");
        check(12.0, "12");
        check(-0.0, "0");
        check(330_207.3, "330200");
        check(1e-9, "1e-9");
        check(-6.2e-20, "0");
        check(7.0 * 0.0254, "0.1778");
        check(f64::INFINITY, "inf");
    }

    #[test]
    fn a_length_below_what_is_computed_is_none() {
        assert_eq!(measured(-9.131e-11, 4), "0");
        assert_eq!(measured(-9.131e-7, 4), "-9.131e-7");
    }

    proptest::proptest! {
        #[test]
        fn full_numbers_read_back(bits in proptest::prelude::any::<u64>()) {
            let x = f64::from_bits(bits);
            proptest::prop_assume!(x.is_finite());
            proptest::prop_assert_eq!(full(x).parse::<f64>().unwrap().to_bits(), bits);
        }
    }
}
