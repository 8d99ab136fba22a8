//! Smooth functions of a launch, known at some launches: kriging.
//!
//! Source: Sacks, Welch, Mitchell and Wynn, Design and analysis of computer experiments (Stat. Sci.
//! 4, 1989), with the kernel 1/(1 + r²), which is smooth and needs no exponential.

use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};
use saltus_numeric::Single;

/// Numbers of a launch that its results depend on.
pub(super) const DIRECTIONS: usize = 4;

/// A launch as a place: in each direction in units of what its range is there.
pub(super) type Place<S = f64> = [S; DIRECTIONS];

/// Added to the kernel's diagonal: functions pass their values by this share at most.
const NUGGET: f64 = 1e-12;

/// Lengths over which a function may change, in units of the range.
const LENGTHS: [f64; 4] = [0.35, 0.7, 1.4, 2.8];

/// With fewer places than this there is nothing to choose a length by.
const FEW: usize = 8;

/// Several functions of a launch, each a constant plus a sum of kernels around the known places.
#[derive(Clone, Debug)]
pub(super) struct Kriging {
    places: Vec<Place>,
    /// 1/length² of the kernel.
    sharpness: f64,
    constants: Vec<f64>,
    /// For each place, its kernel's factor in each function.
    factors: Vec<Vec<f64>>,
}

impl Kriging {
    /// Through `values`, those of all functions at each place. The length of the kernel is the one
    /// with which the functions that are `counted` are predicted best at each place from the others.
    pub(super) fn through(
        places: &[Place],
        values: &[&[f64]],
        counted: &Range<usize>,
    ) -> Option<Kriging> {
        let fits = LENGTHS.iter().filter_map(|length| {
            let few = places.len() < FEW;
            if few && *length != 1.4 {
                return None;
            }
            Kriging::with_length(*length, places, values, counted)
        });
        let best = fits.min_by(|a, b| a.1.total_cmp(&b.1));
        best.map(|(fit, _)| fit)
    }

    /// With a kernel of this length, and the mean square of what each place is predicted wrong from
    /// the others.
    fn with_length(
        length: f64,
        places: &[Place],
        values: &[&[f64]],
        counted: &Range<usize>,
    ) -> Option<(Kriging, f64)> {
        let (n, functions) = (places.len(), values.first()?.len());
        let sharpness = 1.0 / (length * length);
        let mut kernels = DMatrix::from_fn(n, n, |i, j| kernel(&places[i], &places[j], sharpness));
        for i in 0..n {
            kernels[(i, i)] += NUGGET * n as f64;
        }
        let solver = Cholesky::new(kernels)?;
        let ones = DVector::from_element(n, 1.0);
        let weights = solver.solve(&ones);
        let inverse = solver.inverse();
        let mut fit = Kriging {
            places: places.to_vec(),
            sharpness,
            constants: Vec::with_capacity(functions),
            factors: vec![Vec::with_capacity(functions); n],
        };
        let mut error = 0.0;
        for k in 0..functions {
            let column = DVector::from_fn(n, |i, _| values[i][k]);
            let constant = weights.dot(&column) / weights.sum();
            let factors = solver.solve(&column.add_scalar(-constant));
            for i in 0..n {
                fit.factors[i].push(factors[i]);
                if counted.contains(&k) {
                    error += (factors[i] / inverse[(i, i)]).powi(2);
                }
            }
            fit.constants.push(constant);
        }
        Some((fit, error))
    }

    /// All functions at `place`.
    pub(super) fn at<S: Single>(&self, place: &Place<S>) -> Vec<S> {
        let mut values: Vec<S> = self.constants.iter().map(|x| S::of(*x)).collect();
        for (known, factors) in self.places.iter().zip(&self.factors) {
            let weight = kernel(&known.map(S::of), place, self.sharpness);
            for (value, factor) in values.iter_mut().zip(factors) {
                *value = weight.mul_add(S::of(*factor), *value);
            }
        }
        values
    }
}

/// Squared distance between two places.
pub(super) fn apart<S: Single>(a: &Place<S>, b: &Place<S>) -> S {
    let squares = a.iter().zip(b).map(|(x, y)| (*x - *y) * (*x - *y));
    squares.fold(S::of(0.0), |sum, square| sum + square)
}

fn kernel<S: Single>(a: &Place<S>, b: &Place<S>, sharpness: f64) -> S {
    S::of(1.0) / apart(a, b).mul_add(S::of(sharpness), S::of(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use saltus_numeric::Dual;

    /// A smooth function of two of the directions.
    fn hill(place: &Place) -> f64 {
        1.0 + 0.3 * place[0] - (0.7 * place[1]).sin() * place[0]
    }

    fn spread(n: usize) -> Vec<Place> {
        // Kronecker's sequence of the golden ratio's cousins.
        let part = |x: f64| x - x.floor();
        let place = |i: usize| {
            let i = i as f64 + 0.5;
            [part(0.754_877_666 * i), part(0.569_840_291 * i), 0.0, 0.0]
        };
        (0..n).map(place).collect()
    }

    fn fitted(n: usize) -> Kriging {
        let places = spread(n);
        let values: Vec<[f64; 1]> = places.iter().map(|p| [hill(p)]).collect();
        let values: Vec<&[f64]> = values.iter().map(<[f64; 1]>::as_slice).collect();
        Kriging::through(&places, &values, &(0..1)).expect("a fit")
    }

    #[test]
    fn it_passes_through_what_is_known_and_is_near_it_between() {
        for (n, between) in [(1, 1.0), (6, 0.3), (12, 3e-2), (25, 1e-3), (60, 3e-4)] {
            let fit = fitted(n);
            for place in &spread(n) {
                let off = fit.at(place)[0] - hill(place);
                assert!(off.abs() < 1e-5, "{n}: {off}");
            }
            for place in &spread(500)[n..] {
                let off = fit.at(place)[0] - hill(place);
                assert!(off.abs() < between, "{n}: {off}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_what_it_returns() {
        let fit = fitted(25);
        let place = [0.4, 0.6, 0.0, 0.0];
        let dual: [Dual<2>; 4] = std::array::from_fn(|k| {
            if k < 2 {
                Dual::variable(place[k], k)
            } else {
                Dual {
                    value: 0.0,
                    slope: [0.0; 2],
                }
            }
        });
        let slope = fit.at(&dual)[0].slope;
        for k in 0..2 {
            let side = |h: f64| {
                let mut beside = place;
                beside[k] += h;
                fit.at(&beside)[0]
            };
            let chord = (side(1e-5) - side(-1e-5)) / 2e-5;
            assert!((slope[k] - chord).abs() < 1e-6, "{k}: {slope:?} {chord}");
        }
    }
}
