//! Profile likelihood: how far a parameter may go before the data speak against it, whatever all
//! others do.

use nalgebra::DMatrix;

use crate::fit::{self, Fit, Slopes, parameters_of};
use crate::kind::{Kind, Terms};
use crate::tangent::Known;

/// Where the data do not speak against a parameter, at the 95 % level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Its lower end; none where nothing speaks against less, as far as physics lets it go.
    pub low: Option<f64>,
    /// Its upper end, in the same way.
    pub high: Option<f64>,
}

/// Half of a 95 % interval in standard deviations.
pub(crate) const NORMAL: f64 = 1.96;

/// By how much the loss rises to the end of an interval: χ² of one parameter that is exceeded in 5
/// % of cases.
const LEVEL: f64 = 3.841_458_8;
/// Fits that are made to find an end.
const MOST: usize = 16;
/// Most steps of each.
const STEPS: usize = 10;
/// Part of its distance to which an end is found.
const NEAR: f64 = 0.02;

/// A fit around which profiles are taken.
pub(crate) struct Profile<'a> {
    pub(crate) kind: &'a dyn Kind,
    pub(crate) fit: &'a Fit,
    /// How surely its parameters are known.
    pub(crate) known: &'a Known,
    /// Derivatives of all runs there.
    pub(crate) slopes: &'a Slopes,
}

impl Profile<'_> {
    /// The parameters where `parameter` of `cause` is as far up (or down) as the data allow; none
    /// where that is as far as physics does.
    pub(crate) fn end(&self, cause: usize, parameter: usize, is_upper: bool) -> Option<Terms> {
        let places = parameters_of(self.kind, &self.fit.causes);
        let index = places
            .iter()
            .position(|place| *place == (cause, parameter))?;
        let spec = &self.kind.causes()[cause].parameters[parameter];
        let variance = |of: &DMatrix<f64>| of[(index, index)];
        let (all, readings) = match (
            variance(&self.known.covariance),
            variance(&self.known.by_readings),
        ) {
            (all, readings) if readings > 0.0 && all.is_finite() => (all, readings),
            // One that does nothing where it is.
            _ => (1.0, 1.0),
        };
        // Noise of measured inputs lets the parameter go further than the loss of the readings
        // says.
        let inflation = self.known.inflation(index);
        let level = LEVEL * inflation * all / readings;
        let (from, side) = (
            self.fit.terms.get(cause, parameter),
            if is_upper { 1.0 } else { -1.0 },
        );
        let bound = if is_upper {
            spec.bounds.1
        } else {
            spec.bounds.0
        };
        let most = (bound - from) * side;
        let fitted = |distance: f64| {
            let mut moved = self.fit.clone();
            for (k, &(c, p)) in places.iter().enumerate() {
                // The others as they go with it where all is linear.
                let other = &self.kind.causes()[c].parameters[p];
                let slope =
                    self.known.by_readings[(k, index)] / readings * other.scale / spec.scale;
                let slope = if slope.is_finite() { slope } else { 0.0 };
                let x = moved.terms.get(c, p) + slope * side * distance;
                moved
                    .terms
                    .set(c, p, x.clamp(other.bounds.0, other.bounds.1));
            }
            moved.terms.set(cause, parameter, from + side * distance);
            fit::refit_but(self.kind, (cause, parameter), moved, self.slopes, STEPS)
        };
        let first = (LEVEL * inflation * all).sqrt() * spec.scale;
        crossing(fitted, first, most, (self.fit.loss, level))
    }
}

/// The parameters at the distance at which the loss of `fitted` rises from `loss` by `level`;
/// `first` is tried first. None where the loss does not rise so much up to `most`.
fn crossing(
    fitted: impl Fn(f64) -> Option<Fit>,
    first: f64,
    most: f64,
    (loss, level): (f64, f64),
) -> Option<Terms> {
    // The root of the rise of the loss is nearly straight.
    let (mut best, mut last) = (loss, None);
    let (mut below, mut above) = (0.0, f64::INFINITY);
    let mut distance = first;
    for _ in 0..MOST {
        distance = distance.min(most);
        if distance <= 0.0 {
            return None;
        }
        let Some(there) = fitted(distance) else {
            // What has no answer does not explain the data.
            above = distance;
            distance = 0.5 * (below + above);
            continue;
        };
        best = best.min(there.loss);
        let rise = ((there.loss - best).max(0.0) / level).sqrt();
        if (rise - 1.0).abs() < NEAR || (above - below) < NEAR * distance {
            return Some(there.terms);
        }
        if rise > 1.0 {
            above = distance;
        } else if distance < most {
            below = distance;
        } else {
            return None;
        }
        last = Some(there.terms);
        let straight = distance / rise.max(0.2);
        distance = if straight > below && straight < above {
            straight
        } else {
            0.5 * (below + above)
        };
    }
    last.filter(|_| above.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::finding::Candidate;
    use crate::kind::{Cause, Channel, Data, Log, Parameter, Reading};
    use crate::report::report;

    /// Readings of `law` at 0, 1, …, each with an error of 1.
    struct Toy {
        data: Data,
        law: fn(&[f64], f64) -> f64,
    }

    impl Toy {
        fn new(bounds: &[(f64, f64)], values: &[f64], law: fn(&[f64], f64) -> f64) -> Toy {
            let of = |b: &(f64, f64)| Parameter::new("x", 1.0, *b, 0.1);
            let reading = |(k, value): (usize, &f64)| Reading {
                channel: 0,
                time: k as f64,
                value: *value,
                weight: 1.0,
            };
            let data = Data {
                channels: vec![Channel {
                    name: "y".into(),
                    noise: 1.0,
                    step: 0.0,
                    is_given: true,
                }],
                logs: vec![Log {
                    name: "run".into(),
                    readings: values.iter().enumerate().map(reading).collect(),
                }],
                causes: vec![Cause::several("toy", bounds.iter().map(of).collect())],
                listed: 1,
                ..Data::default()
            };
            Toy { data, law }
        }

        fn intervals(&self) -> Vec<Interval> {
            let before = fit::fit_none(self, &[0]).expect("an answer");
            let fit = fit::fit_with(self, &before, 0, &[0]).expect("a fit");
            let mut candidate = Candidate::new(self, 0, &before, fit);
            report(self, &mut candidate, &[], true);
            candidate
                .reported
                .iter()
                .map(|r| r.interval.expect("an interval"))
                .collect()
        }
    }

    impl Kind for Toy {
        fn data(&self) -> &Data {
            &self.data
        }
        fn unknowns(&self, _: usize) -> Vec<Parameter> {
            Vec::new()
        }
        fn discrepancy(&self) -> f64 {
            0.0
        }
        fn predict(&self, _: usize, terms: &Terms, _: &[f64]) -> Option<Vec<f64>> {
            Some(
                self.data.logs[0]
                    .readings
                    .iter()
                    .map(|r| (self.law)(terms.of(0), r.time))
                    .collect(),
            )
        }
    }

    const HALF: f64 = 1.959_964;

    fn is_near(found: Option<f64>, known: f64) -> bool {
        found.is_some_and(|x| (x - known).abs() < 0.02 * HALF * known.abs().max(0.1))
    }

    /// The mean of 100 readings is known to 0.1, and x is its root.
    #[test]
    fn an_interval_is_as_crooked_as_its_law() {
        let root =
            |mean: f64| Toy::new(&[(0.0, 10.0)], &[mean; 100], |x, _| x[0] * x[0]).intervals()[0];
        let clear = root(0.3);
        let known = [0.3 - 0.1 * HALF, 0.3 + 0.1 * HALF].map(f64::sqrt);
        assert!(
            is_near(clear.low, known[0]) && is_near(clear.high, known[1]),
            "{clear:?} {known:?}"
        );
        let vague = root(0.1);
        assert_eq!(vague.low, None);
        assert!(is_near(vague.high, (0.1 + 0.1 * HALF).sqrt()), "{vague:?}");
    }

    /// A line through readings at 0 to 9: its ends are those of least squares, whatever the other
    /// parameter does.
    #[test]
    fn of_a_line_it_is_the_standard_error() {
        let values: Vec<f64> = (0..10).map(|k| 3.0 + 0.5 * f64::from(k)).collect();
        let free = (f64::NEG_INFINITY, f64::INFINITY);
        let found = Toy::new(&[free, free], &values, |x, t| x[0] + x[1] * t).intervals();
        let square = 82.5;
        let errors = [f64::sqrt(0.1 + 4.5 * 4.5 / square), (1.0 / square).sqrt()];
        for (interval, (value, error)) in found.iter().zip([3.0, 0.5].into_iter().zip(errors)) {
            assert!(
                (interval.low.expect("low") - (value - HALF * error)).abs() < 0.03 * error,
                "{interval:?}"
            );
            assert!(
                (interval.high.expect("high") - (value + HALF * error)).abs() < 0.03 * error,
                "{interval:?}"
            );
        }
    }

    /// Only the product of two factors shows: each goes as far as the bounds of the other let it.
    #[test]
    fn a_factor_of_a_product_has_no_ends_of_its_own() {
        let found = Toy::new(&[(0.1, 100.0), (0.1, 100.0)], &[6.0; 50], |x, _| {
            x[0] * x[1]
        })
        .intervals();
        let high = (6.0 + HALF / 50_f64.sqrt()) / 0.1;
        for interval in &found {
            assert_eq!(interval.low, None);
            assert!(
                interval
                    .high
                    .is_some_and(|x| (x - high).abs() < 0.03 * high),
                "{interval:?} {high}"
            );
        }
    }
}
