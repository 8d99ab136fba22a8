//! Causes and quantities in words.

use saltus::diagnosis::{Interval, Misstated};

use crate::output::digits;

/// Endings of names, and the units that they stand for; a longer one before its own end.
const UNITS: [(&str, &str); 30] = [
    ("_pa_s_per_kg", "Pa s/kg"),
    ("_n_m_s2_per_rad2", "N m s²/rad²"),
    ("_n_m_s_per_rad", "N m s/rad"),
    ("_n_m_per_rad", "N m/rad"),
    ("_n_s2_per_m2", "N s²/m²"),
    ("_rad_per_n_m", "rad/(N m)"),
    ("_n_s_per_m", "N s/m"),
    ("_n_per_pa", "N/Pa"),
    ("_n_per_m", "N/m"),
    ("_m_per_n", "m/N"),
    ("_kg_m2", "kg m²"),
    ("_per_m", "1/m"),
    ("_rad_s", "rad/s"),
    ("_m_s2", "m/s²"),
    ("_m_s", "m/s"),
    ("_m2_per_m", "m²/m"),
    ("_per_s", "1/s"),
    ("_n_m", "N m"),
    ("_nm", "N m"),
    ("_rad", "rad"),
    ("_m2", "m²"),
    ("_m3", "m³"),
    ("_pa", "Pa"),
    ("_kg", "kg"),
    ("_k", "K"),
    ("_n", "N"),
    ("_s", "s"),
    ("_m", "m"),
    ("_psi", "psi"),
    ("_deg", "°"),
];

/// Unit that a name ends with; empty where it has none.
pub(in crate::cli) fn unit(name: &str) -> &'static str {
    UNITS
        .iter()
        .find(|(end, _)| name.ends_with(end))
        .map_or("", |(_, unit)| unit)
}

/// A name without its unit, and the unit.
pub(in crate::cli) fn split(name: &str) -> (&str, &'static str) {
    UNITS
        .iter()
        .find_map(|(end, unit)| Some((name.strip_suffix(end)?, *unit)))
        .unwrap_or((name, ""))
}

/// A number with so many digits and its unit.
pub(in crate::cli) fn with_unit(x: f64, count: usize, unit: &str) -> String {
    format!("{} {unit}", digits(x, count)).trim_end().to_owned()
}

/// A stated noise that is far from what the data scatter, in a sentence.
pub(in crate::cli) fn misstated(wrong: &Misstated) -> String {
    let (_, unit) = split(&wrong.column);
    let [stated, seen] = [wrong.stated, wrong.seen].map(|x| with_unit(x, 2, unit));
    let (ratio, question) = if wrong.stated > wrong.seen {
        let question = match unit {
            "m" => "is it in mm?",
            "rad" => "is it in degrees?",
            _ => "is it in the unit of the column?",
        };
        (digits(wrong.stated / wrong.seen, 2), question)
    } else {
        (
            format!("1/{}", digits(wrong.seen / wrong.stated, 2)),
            "is it in the unit of the column?",
        )
    };
    format!(
        "The stated noise of {}, {stated}, is {ratio} times what the data scatter ({seen}): \
         {question} The answer goes by what the data scatter.",
        wrong.column
    )
}

/// A value and its standard error, each with the digits that the error allows, and the unit.
pub(super) fn estimate(value: f64, error: f64, unit: &str) -> String {
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    if !error.is_finite() || error <= 0.0 || value == 0.0 {
        return format!("{}{unit} (error not known)", digits(value, 4));
    }
    let behind = (value.abs().log10().floor() - error.log10().floor()).clamp(0.0, 6.0);
    // From 0 to 6 by the clamp.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let count = behind as usize + 2;
    format!("{} ± {}{unit}", digits(value, count), digits(error, 2))
}

/// An interval with as many digits as the standard error asks for.
pub(super) fn interval(interval: Interval, error: f64, unit: &str) -> String {
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    let round = |x: f64| {
        estimate(x, error, "")
            .split(" ±")
            .next()
            .unwrap_or_default()
            .replace(" (error not known)", "")
    };
    match (interval.low.map(round), interval.high.map(round)) {
        (Some(low), Some(high)) => format!("{low} to {high}{unit}"),
        (Some(low), None) => format!("at least {low}{unit}"),
        (None, Some(high)) => format!("at most {high}{unit}"),
        (None, None) => "not bounded by these data".into(),
    }
}

/// Lines with their cells under each other: the first `left` columns and the last begin in line,
/// the others end in line.
pub(in crate::cli) fn grid(lines: &[Vec<String>], left: usize) -> String {
    let columns = lines.iter().map(Vec::len).max().unwrap_or(0);
    let width = |i: usize| {
        lines
            .iter()
            .filter_map(|l| l.get(i))
            .map(|c| c.chars().count())
            .max()
            .unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for line in lines {
        let mut row = String::new();
        for (i, (cell, width)) in line.iter().zip(&widths).enumerate() {
            let cell = if i < left || i + 1 == columns {
                format!("  {cell:<width$}")
            } else {
                format!("  {cell:>width$}")
            };
            row.push_str(&cell);
        }
        text += row.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_end_with_their_units() {
        assert_eq!(split("leg.valve_delay_s"), ("leg.valve_delay", "s"));
        assert_eq!(split("stiffness_n_per_m"), ("stiffness", "N/m"));
        assert_eq!(split("environment.drag_per_m"), ("environment.drag", "1/m"));
        assert_eq!(
            split("body.axle_friction_n_m"),
            ("body.axle_friction", "N m")
        );
        assert_eq!(split("gain"), ("gain", ""));
        assert_eq!(unit("wheel_rate_rad_s"), "rad/s");
    }

    #[test]
    fn an_estimate_has_the_digits_that_its_error_allows() {
        assert_eq!(
            estimate(0.012_345_6, 0.000_43, "1/m"),
            "0.01235 ± 0.00043 1/m"
        );
        assert_eq!(estimate(1234.567, 0.0123, ""), "1234.567 ± 0.012");
        assert_eq!(estimate(2.0, f64::NAN, "s"), "2 s (error not known)");
    }

    #[test]
    fn an_interval_may_have_one_end() {
        let of = |low, high| interval(Interval { low, high }, 0.021, "N m");
        assert_eq!(of(Some(0.312_34), Some(0.4)), "0.312 to 0.4 N m");
        assert_eq!(of(Some(0.312_34), None), "at least 0.312 N m");
        assert_eq!(of(None, Some(0.0)), "at most 0 N m");
        assert_eq!(of(None, None), "not bounded by these data");
    }
}
