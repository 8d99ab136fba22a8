//! Causes and quantities in words.

use saltus::diagnosis::{Candidate, Interval, Kind, Misstated, Reported};

use crate::output::{digits, split, unit, with_unit};
use crate::slip::{Estimated, slip};

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

/// What slip of unit the `k`-th reported parameter equals.
pub(super) fn slip_of(kind: &dyn Kind, candidate: &Candidate, k: usize) -> Option<String> {
    let cause = &kind.causes()[candidate.cause];
    let neutral: Vec<f64> = cause.parameters.iter().map(|p| p.neutral).collect();
    let believed = cause.report(&neutral).get(k)?.1;
    let Reported {
        name, value, error, ..
    } = candidate.reported.get(k)?;
    let is_gain = cause.id == "encoder-scale";
    let unit = match name.as_str() {
        "load_factor" | "mass_share" => "kg",
        "supply_pressure_factor" => "Pa",
        "gain" => unit(cause.column.as_deref().unwrap_or_default()),
        name => unit(name),
    };
    slip(&Estimated {
        unit,
        believed,
        value: *value,
        error: *error,
        is_gain,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
