//! Domains of numbers, and how messages write them.

use std::ops::{Bound, RangeBounds};

/// An interval of finite numbers (SI).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Domain {
    low: Bound<f64>,
    high: Bound<f64>,
}

impl Domain {
    pub(crate) const POSITIVE: Domain = Domain { low: Bound::Excluded(0.0), high: Bound::Unbounded };
    pub(crate) const NON_NEGATIVE: Domain = Domain::at_least(0.0);

    /// x > `low`.
    pub(crate) const fn above(low: f64) -> Domain {
        Domain { low: Bound::Excluded(low), high: Bound::Unbounded }
    }

    /// x ≥ `low`.
    pub(crate) const fn at_least(low: f64) -> Domain {
        Domain { low: Bound::Included(low), high: Bound::Unbounded }
    }

    /// The same, and x < `high`.
    pub(crate) const fn below(self, high: f64) -> Domain {
        Domain { low: self.low, high: Bound::Excluded(high) }
    }

    /// The same, and x ≤ `high`.
    pub(crate) const fn up_to(self, high: f64) -> Domain {
        Domain { low: self.low, high: Bound::Included(high) }
    }

    /// Whether `x` is finite and inside.
    pub(crate) fn contains(self, x: f64) -> bool {
        x.is_finite() && (self.low, self.high).contains(&x)
    }

    /// What is allowed, for messages, with bounds in `unit`.
    pub(crate) fn describe(self, unit: &str) -> String {
        let low = match self.low {
            Bound::Unbounded => None,
            Bound::Excluded(low) => Some((">", low)),
            Bound::Included(low) => Some(("≥", low)),
        };
        let high = match self.high {
            Bound::Unbounded => None,
            Bound::Excluded(high) => Some(("<", high)),
            Bound::Included(high) => Some(("≤", high)),
        };
        let bounds: Vec<String> =
            [low, high].into_iter().flatten().map(|(sign, bound)| written(sign, bound, unit)).collect();
        format!("a finite number {}", bounds.join(" and ")).trim_end().into()
    }
}

/// A bound with its unit; 0 is 0 in any unit.
fn written(sign: &str, bound: f64, unit: &str) -> String {
    let unit = if bound == 0.0 { "" } else { unit };
    format!("{sign} {bound} {unit}").trim_end().into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn domains_hold_and_say_what_they_hold() {
        let check = |domain: Domain, text: &str, inside: &[f64], outside: &[f64]| {
            assert_eq!(domain.describe("m"), text);
            assert!(inside.iter().all(|&x| domain.contains(x)), "{text}");
            assert!(outside.iter().all(|&x| !domain.contains(x)), "{text}");
            assert!([f64::NAN, f64::INFINITY, -f64::INFINITY].iter().all(|&x| !domain.contains(x)), "{text}");
        };
        check(Domain::POSITIVE, "a finite number > 0", &[5e-324, f64::MAX], &[0.0, -0.0, -1.0]);
        check(Domain::NON_NEGATIVE, "a finite number ≥ 0", &[0.0, 1.0], &[-5e-324]);
        check(Domain::POSITIVE.below(0.06), "a finite number > 0 and < 0.06 m", &[0.059], &[0.0, 0.06]);
        check(
            Domain::at_least(1.0).up_to(1.4),
            "a finite number ≥ 1 m and ≤ 1.4 m",
            &[1.0, 1.4],
            &[0.9, 1.5],
        );
        check(Domain::above(1.0), "a finite number > 1 m", &[1.1], &[1.0]);
    }
}
