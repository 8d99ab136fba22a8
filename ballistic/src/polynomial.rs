//! Polynomials of degree ≤ 4 and their roots in an interval.
//!
//! The roots come from those of the derivative, which cut the interval into pieces on which the
//! polynomial is monotonic: a sign change then brackets exactly one root, and Newton's method, kept
//! inside the bracket, ends on round-off. Closed formulas (those of the crate `roots`, say) lose
//! digits where the leading coefficient is small, as in low gravity; this does not, and a leading
//! coefficient of zero is no special case.

use std::ops::{Add, Mul, Sub};

/// Degree up to which polynomials go: a squared distance to a parabola.
const DEGREE: usize = 4;

/// A polynomial's coefficients, that of the lowest power first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Polynomial(pub(crate) [f64; DEGREE + 1]);

/// Roots in ascending order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Roots {
    at: [f64; DEGREE],
    count: usize,
}

impl Roots {
    fn push(&mut self, root: f64) {
        self.at[self.count] = root;
        self.count += 1;
    }

    pub(crate) fn as_slice(&self) -> &[f64] {
        &self.at[..self.count]
    }
}

impl Polynomial {
    /// c₀ + c₁ t + c₂ t².
    pub(crate) fn quadratic(c0: f64, c1: f64, c2: f64) -> Self {
        Polynomial([c0, c1, c2, 0.0, 0.0])
    }

    pub(crate) fn scaled(&self, factor: f64) -> Self {
        Polynomial(self.0.map(|c| c * factor))
    }

    pub(crate) fn at(&self, t: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, c| sum * t + c)
    }

    pub(crate) fn derivative(&self) -> Self {
        let [_, c1, c2, c3, c4] = self.0;
        Polynomial([c1, 2.0 * c2, 3.0 * c3, 4.0 * c4, 0.0])
    }

    /// Where the polynomial changes its sign in [`from`, `to`]; `to` may be infinite.
    ///
    /// Roots of even multiplicity are none of these. A zero counts as positive: one at `from` is a
    /// root if the polynomial falls below zero there.
    pub(crate) fn roots(&self, from: f64, to: f64) -> Roots {
        let mut roots = Roots::default();
        if self.0[1..].iter().all(|&c| c == 0.0) {
            return roots;
        }
        let to = if to.is_finite() {
            to
        } else {
            self.root_bound()
        };
        let slope = self.derivative();
        let mut left = from;
        for &right in slope.roots(from, to).as_slice().iter().chain([&to]) {
            if left <= right && (self.at(left) < 0.0) != (self.at(right) < 0.0) {
                roots.push(root_between(left, right, |t| [self.at(t), slope.at(t)]));
            }
            left = right;
        }
        roots
    }

    /// Magnitude that no root of a polynomial which is no constant exceeds.
    ///
    /// Source: Fujiwara, Tôhoku Mathematical Journal 10 (1916) 167–171.
    fn root_bound(&self) -> f64 {
        let degree = self.0.iter().rposition(|&c| c != 0.0).unwrap_or(0);
        let ratio = |k: usize| {
            (self.0[degree - k] / self.0[degree])
                .abs()
                .powf(1.0 / k as f64)
        };
        2.0 * (1..=degree).map(ratio).fold(0.0, f64::max)
    }
}

/// The root between `low` and `high` of a function, given as its value and its slope, with
/// different signs there.
///
/// Newton's method, with a bisection wherever it would leave what is left of the interval.
pub(crate) fn root_between(mut low: f64, mut high: f64, function: impl Fn(f64) -> [f64; 2]) -> f64 {
    /// Seldom more than ten are needed; bisection alone comes to round-off in a hundred.
    const MOST: usize = 200;
    let at_low = function(low)[0];
    if at_low == 0.0 {
        return low;
    }
    let negative_low = at_low < 0.0;
    let mut t = low.midpoint(high);
    for _ in 0..MOST {
        let [value, slope] = function(t);
        if (value < 0.0) == negative_low {
            low = t;
        } else {
            high = t;
        }
        let newton = t - value / slope;
        let next = if low <= newton && newton <= high {
            newton
        } else {
            low.midpoint(high)
        };
        if (next - t).abs() <= f64::EPSILON * t.abs() {
            return next;
        }
        t = next;
    }
    t
}

impl Add for Polynomial {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Polynomial(std::array::from_fn(|i| self.0[i] + other.0[i]))
    }
}

impl Sub for Polynomial {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        Polynomial(std::array::from_fn(|i| self.0[i] - other.0[i]))
    }
}

/// The product of two quadratics: higher coefficients do not enter.
impl Mul for Polynomial {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let ([a0, a1, a2, ..], [b0, b1, b2, ..]) = (self.0, other.0);
        Polynomial([
            a0 * b0,
            a0 * b1 + a1 * b0,
            a0 * b2 + a1 * b1 + a2 * b0,
            a1 * b2 + a2 * b1,
            a2 * b2,
        ])
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::check::config;

    /// The polynomial `scale` Π (t − root).
    fn with_roots(scale: f64, roots: &[f64]) -> Polynomial {
        roots
            .iter()
            .fold(Polynomial::quadratic(scale, 0.0, 0.0), |p, root| {
                let mut shifted = [0.0; DEGREE + 1];
                shifted[1..].copy_from_slice(&p.0[..DEGREE]);
                Polynomial(std::array::from_fn(|i| shifted[i] - root * p.0[i]))
            })
    }

    #[test]
    fn special_cases() {
        let check = |p: Polynomial, from: f64, to: f64, expected: &[f64]| {
            assert_eq!(p.roots(from, to).as_slice(), expected, "{p:?}");
        };
        check(Polynomial::quadratic(0.0, 0.0, 0.0), 0.0, 1.0, &[]);
        check(Polynomial::quadratic(1.0, 0.0, 0.0), 0.0, 1.0, &[]);
        check(Polynomial::quadratic(-1.0, 2.0, 0.0), 0.0, 1.0, &[0.5]);
        check(
            Polynomial::quadratic(-1.0, 0.0, 1.0),
            0.0,
            f64::INFINITY,
            &[1.0],
        );
        // Two roots meet: no change of sign.
        check(Polynomial::quadratic(1.0, -2.0, 1.0), 0.0, 4.0, &[]);
        // Falls from zero at the start.
        check(Polynomial::quadratic(0.0, -1.0, 0.0), 0.0, 4.0, &[0.0]);
    }

    #[test]
    fn a_small_leading_coefficient_costs_no_digits() {
        // The crate `roots`, in its own test, is off by 4e-3 on the least of these.
        let p = Polynomial([
            0.068_953_959_703_646_1,
            -0.100_896_606_408_756,
            0.012_629_831_028_060_6,
            -4.041_062_848_103_5e-17,
            0.0,
        ]);
        let roots = p.roots(0.0, 10.0);
        // The quadratic's: the cubic term moves them by 1e-15 only.
        let expected = [0.754_710_877_053_7, 7.234_042_589_61];
        for (root, expected) in roots.as_slice().iter().zip(expected) {
            assert!(
                (root - expected).abs() < 1e-10,
                "{root} instead of {expected}"
            );
        }
        assert_eq!(roots.as_slice().len(), 2);
    }

    proptest! {
        #![proptest_config(config())]

        #[test]
        fn finds_the_roots_it_was_made_of(
            mut made_of in prop::collection::vec(-10.0..10.0_f64, 1..=DEGREE),
            scale in 1e-3..1e3,
        ) {
            made_of.sort_by(f64::total_cmp);
            // Roots that nearly meet are ill-conditioned: no method finds them from the
            // coefficients.
            prop_assume!(made_of.windows(2).all(|pair| pair[1] - pair[0] > 0.1));
            let roots = with_roots(scale, &made_of).roots(-20.0, f64::INFINITY);
            prop_assert_eq!(roots.as_slice().len(), made_of.len());
            for (root, expected) in roots.as_slice().iter().zip(&made_of) {
                prop_assert!((root - expected).abs() < 1e-8);
            }
        }

        #[test]
        fn agrees_with_the_crate_roots(c in prop::array::uniform4(-5.0..5.0)) {
            let ours = Polynomial([c[0], c[1], c[2], c[3], 0.0]).roots(-1e9, 1e9);
            let theirs = roots::find_roots_cubic(c[3], c[2], c[1], c[0]);
            for &root in theirs.as_ref() {
                // Its closed formula has up to 1e-6 of error where roots nearly meet.
                prop_assert!(ours.as_slice().iter().any(|r| (r - root).abs() <= 1e-5 * root.abs().max(1.0)));
            }
        }
    }
}
