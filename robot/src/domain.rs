//! Domains of numbers, and how messages write them.

use std::f64::consts::PI;
use std::ops::{Bound, RangeBounds};

use saltus_numeric::plain;

use crate::units::{Quantity, Unit};

/// An interval of finite numbers (SI), perhaps with infinity.
#[derive(Clone, Copy, Debug)]
pub struct Domain {
    low: Bound<f64>,
    high: Bound<f64>,
    /// Whether infinity belongs to it.
    endless: bool,
    /// Whether only whole numbers belong to it.
    whole: bool,
    /// What its numbers are, for messages.
    name: &'static str,
    /// Why its bounds are where they are, for messages; mostly empty.
    reason: &'static str,
    /// Units that a number outside it may be in by mistake, for messages; mostly empty.
    others: &'static str,
}

impl Domain {
    /// Every finite number.
    pub const FINITE: Domain = Domain::from(Bound::Unbounded);
    /// x > 0.
    pub const POSITIVE: Domain = Domain::above(0.0);
    /// x ≥ 0.
    pub const NON_NEGATIVE: Domain = Domain::at_least(0.0);

    const fn from(low: Bound<f64>) -> Domain {
        Domain {
            low,
            high: Bound::Unbounded,
            endless: false,
            whole: false,
            name: "a finite number",
            reason: "",
            others: "",
        }
    }

    /// −`size` ≤ x ≤ `size`.
    pub const fn within(size: f64) -> Domain {
        Domain::at_least(-size).up_to(size)
    }

    /// x > `low`.
    pub const fn above(low: f64) -> Domain {
        Domain::from(Bound::Excluded(low))
    }

    /// x ≥ `low`.
    pub const fn at_least(low: f64) -> Domain {
        Domain::from(Bound::Included(low))
    }

    /// The same, and x < `high`.
    pub const fn below(self, high: f64) -> Domain {
        Domain {
            high: Bound::Excluded(high),
            ..self
        }
    }

    /// The same, and x ≤ `high`.
    pub const fn up_to(self, high: f64) -> Domain {
        Domain {
            high: Bound::Included(high),
            ..self
        }
    }

    /// The same, and infinity.
    pub const fn or_infinite(self) -> Domain {
        Domain {
            endless: true,
            ..self
        }
    }

    /// The whole numbers of the same, whose bounds are whole.
    pub const fn whole(self) -> Domain {
        Domain {
            whole: true,
            name: "a whole number",
            ..self
        }
    }

    /// The same, whose numbers are called `name` in messages: `a mass`.
    pub const fn called(self, name: &'static str) -> Domain {
        Domain { name, ..self }
    }

    /// The same with the reason for its bounds.
    pub const fn because(self, reason: &'static str) -> Domain {
        Domain { reason, ..self }
    }

    /// The same, outside of which a number in SI may be one in `others` by mistake: `mm, cm or inch`.
    pub const fn not(self, others: &'static str) -> Domain {
        Domain { others, ..self }
    }

    /// Whether `x` is inside; what is not finite mostly is not.
    pub fn contains(self, x: f64) -> bool {
        let is_fraction = self.whole && x.fract() != 0.0;
        (x.is_finite() && !is_fraction && (self.low, self.high).contains(&x))
            || (self.endless && x == f64::INFINITY)
    }

    /// Its least and greatest finite numbers, or those next to them where they are excluded.
    pub fn bounds(self) -> (f64, f64) {
        let low = match self.low {
            Bound::Unbounded => f64::MIN,
            Bound::Excluded(low) => low.next_up(),
            Bound::Included(low) => low,
        };
        let high = match self.high {
            Bound::Unbounded => f64::MAX,
            Bound::Excluded(high) => high.next_down(),
            Bound::Included(high) => high,
        };
        (low, high)
    }

    /// What is allowed, for messages, with bounds in the unit of the number that is refused.
    pub fn describe(self, quantity: Quantity, unit: Unit) -> String {
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
        let bounds: Vec<String> = [low, high]
            .into_iter()
            .flatten()
            .map(|(sign, bound)| written(sign, bound, quantity, unit))
            .collect();
        let number = format!("{} {}", self.name, bounds.join(" and "));
        let endless = if self.endless { ", or inf" } else { "" };
        let others = match self.others {
            others if others.is_empty() || unit != Unit::SI => String::new(),
            others => format!(", not {others}"),
        };
        format!("{}{endless}{}{others}", number.trim_end(), self.reason)
    }
}

/// A bound in a unit, and in SI where that is cut; 0 is 0 in any unit, and angles are parts of π where they are.
fn written(sign: &str, bound: f64, quantity: Quantity, unit: Unit) -> String {
    if unit != Unit::SI && bound != 0.0 {
        let (number, is_cut) = unit.written(bound);
        let shown = format!("{sign} {number} {}", quantity.symbol(unit));
        return if is_cut {
            format!("{shown} ({} {})", readable(bound), quantity.si)
        } else {
            shown
        };
    }
    let half_turns = bound / PI;
    let number = match half_turns.abs() {
        0.0 => return format!("{sign} 0"),
        0.25 => format!("{}pi/4", if bound < 0.0 { "-" } else { "" }),
        0.5 => format!("{}pi/2", if bound < 0.0 { "-" } else { "" }),
        1.0 => format!("{}pi", if bound < 0.0 { "-" } else { "" }),
        2.0 | 4.0 => format!("{half_turns} pi"),
        _ => readable(bound),
    };
    format!("{sign} {number} {}", quantity.si).trim_end().into()
}

/// A number without round-off, with an exponent where it is large.
fn readable(number: f64) -> String {
    let number = plain(number);
    if number.abs() >= 1e6 {
        format!("{number:e}")
    } else {
        number.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::{ANGLE, LENGTH, MOLAR_MASS, NUMBER, PRESSURE};

    /// A bound is in the unit in which the refused number was typed.
    #[test]
    fn bounds_are_in_the_unit_of_the_number() {
        let check = |domain: Domain, quantity: Quantity, suffix: &str, text: &str| {
            let unit = quantity.units.iter().find(|(own, _)| *own == suffix);
            assert_eq!(domain.describe(quantity, unit.expect("a unit").1), text);
        };
        let length = Domain::POSITIVE.up_to(0.06);
        check(length, LENGTH, "_mm", "a finite number > 0 and ≤ 60 mm");
        check(length, LENGTH, "_m", "a finite number > 0 and ≤ 0.06 m");
        let inches = "a finite number > 0 and ≤ 2.3622 in (0.06 m)";
        check(length, LENGTH, "_in", inches);
        let absolute = Domain::at_least(101_325.0).not("kPa, bar or psi");
        let psi = "a finite number ≥ 14.6959 psi (101325 Pa)";
        check(absolute, PRESSURE, "_psi", psi);
        check(absolute, PRESSURE, "_kpa", "a finite number ≥ 101.325 kPa");
        let pascals = "a finite number ≥ 101325 Pa, not kPa, bar or psi";
        check(absolute, PRESSURE, "_pa", pascals);
        let degrees = "a finite number ≥ -90 deg and ≤ 90 deg";
        check(Domain::within(PI / 2.0), ANGLE, "_deg", degrees);
        let mass = Domain::POSITIVE.up_to(1.0);
        let grams = "a finite number > 0 and ≤ 1000 g/mol";
        check(mass, MOLAR_MASS, "_g_mol", grams);
    }

    #[test]
    fn domains_hold_and_say_what_they_hold() {
        let check = |domain: Domain, text: &str, inside: &[f64], outside: &[f64]| {
            assert_eq!(domain.describe(LENGTH, Unit::SI), text);
            assert!(inside.iter().all(|&x| domain.contains(x)), "{text}");
            assert!(outside.iter().all(|&x| !domain.contains(x)), "{text}");
            assert!(
                [f64::NAN, f64::INFINITY, -f64::INFINITY]
                    .iter()
                    .all(|&x| !domain.contains(x)),
                "{text}"
            );
        };
        check(
            Domain::POSITIVE,
            "a finite number > 0",
            &[5e-324, f64::MAX],
            &[0.0, -0.0, -1.0],
        );
        check(
            Domain::NON_NEGATIVE,
            "a finite number ≥ 0",
            &[0.0, 1.0],
            &[-5e-324],
        );
        check(
            Domain::POSITIVE.below(0.06),
            "a finite number > 0 and < 0.06 m",
            &[0.059],
            &[0.0, 0.06],
        );
        check(
            Domain::at_least(1.0).up_to(1.4),
            "a finite number ≥ 1 m and ≤ 1.4 m",
            &[1.0, 1.4],
            &[0.9, 1.5],
        );
        check(Domain::above(1.0), "a finite number > 1 m", &[1.1], &[1.0]);
        check(Domain::FINITE, "a finite number", &[-1.0, 0.0], &[]);
        check(
            Domain::within(1e6).called("a force"),
            "a force ≥ -1e6 m and ≤ 1e6 m",
            &[-1e6, 1e6],
            &[1.1e6],
        );
        check(
            Domain::at_least(4.0).up_to(24.0).whole(),
            "a whole number ≥ 4 m and ≤ 24 m",
            &[4.0, 24.0],
            &[3.0, 16.5, 25.0],
        );
        check(
            Domain::within(PI / 2.0).up_to(4.0 * PI),
            "a finite number ≥ -pi/2 m and ≤ 4 pi m",
            &[12.0],
            &[-1.6],
        );
        // 7 inches.
        check(
            Domain::POSITIVE.up_to(7.0 * 0.0254),
            "a finite number > 0 and ≤ 0.1778 m",
            &[0.1],
            &[0.2],
        );
        check(
            Domain::POSITIVE.because(", or not at all"),
            "a finite number > 0, or not at all",
            &[1.0],
            &[0.0],
        );
    }

    #[test]
    fn infinity_is_inside_where_a_domain_says_so() {
        let domain = Domain::NON_NEGATIVE.or_infinite();
        assert_eq!(
            domain.describe(NUMBER, Unit::SI),
            "a finite number ≥ 0, or inf"
        );
        assert!([0.0, f64::INFINITY].iter().all(|&x| domain.contains(x)));
        assert!(
            [-1.0, f64::NEG_INFINITY, f64::NAN]
                .iter()
                .all(|&x| !domain.contains(x))
        );
    }
}
