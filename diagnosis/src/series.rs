//! Residuals of each run and channel as series in time: their smooth parts, and how they follow
//! each other.

use saltus_numeric::statistics::dot;

use crate::kind::Kind;

/// Smooth shapes over a run that residuals are compared with: Legendre's polynomials.
pub(crate) const SHAPES: usize = 8;

/// The readings of one channel in one run.
pub(crate) struct Series {
    pub(crate) channel: usize,
    pub(crate) run: usize,
    /// The place of each among all readings.
    pub(crate) places: Vec<usize>,
    /// Unit vectors of the smooth shapes over them.
    shapes: Vec<Vec<f64>>,
}

impl Series {
    /// Those of `residuals`, one number for each reading of the experiment.
    pub(crate) fn of(&self, residuals: &[f64]) -> Vec<f64> {
        self.places.iter().map(|&i| residuals[i]).collect()
    }

    /// Unit vectors of the smooth shapes over its readings.
    pub(crate) fn shapes(&self) -> &[Vec<f64>] {
        &self.shapes
    }

    /// Their part of each smooth shape; 0 where there are too few readings for it.
    pub(crate) fn smooth_parts(&self, residuals: &[f64]) -> [f64; SHAPES] {
        let values = self.of(residuals);
        let mut parts = [0.0; SHAPES];
        for (part, shape) in parts.iter_mut().zip(&self.shapes) {
            *part = dot(shape, &values);
        }
        parts
    }
}

/// Legendre's polynomials 0 to `SHAPES` − 1 at x in [−1, 1].
fn legendre(x: f64) -> [f64; SHAPES] {
    let mut p = [1.0; SHAPES];
    p[1] = x;
    for k in 2..SHAPES {
        let n = k as f64;
        p[k] = ((2.0 * n - 1.0) * x * p[k - 1] - (n - 1.0) * p[k - 2]) / n;
    }
    p
}

/// Unit vectors of the smooth shapes over `n` readings.
fn shapes(n: usize) -> Vec<Vec<f64>> {
    let mut shapes = vec![vec![0.0; n]; SHAPES.min(n / 2)];
    for i in 0..n {
        let at = legendre(2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
        for (shape, value) in shapes.iter_mut().zip(at) {
            shape[i] = value;
        }
    }
    for shape in &mut shapes {
        let size = dot(shape, shape).sqrt();
        for x in shape {
            *x /= size;
        }
    }
    shapes
}

/// Every series of an experiment that is not empty, run by run.
pub(crate) fn series(kind: &dyn Kind) -> Vec<Series> {
    let mut all = Vec::new();
    let mut start = 0;
    for (run, log) in kind.logs().iter().enumerate() {
        for channel in 0..kind.channels().len() {
            let places: Vec<usize> = (0..log.readings.len())
                .filter(|i| log.readings[*i].channel == channel)
                .map(|i| start + i)
                .collect();
            if !places.is_empty() {
                all.push(Series {
                    channel,
                    run,
                    shapes: shapes(places.len()),
                    places,
                });
            }
        }
        start += log.readings.len();
    }
    all
}

/// Number of runs.
pub(crate) fn runs_of(series: &[Series]) -> usize {
    series.iter().map(|s| s.run + 1).max().unwrap_or(0)
}

/// Correlation of each residual with the next of its run, of each channel.
pub(crate) fn lag_correlation(series: &[Series], channels: usize, residuals: &[f64]) -> Vec<f64> {
    let of = |c: usize| {
        let (mut above, mut below) = (0.0, 1e-300);
        for s in series.iter().filter(|s| s.channel == c) {
            for pair in s.places.windows(2) {
                above += residuals[pair[0]] * residuals[pair[1]];
            }
            let squares = s.places.iter().map(|&i| residuals[i] * residuals[i]);
            below += squares.sum::<f64>();
        }
        above / below
    };
    (0..channels).map(of).collect()
}

/// Variance times correlation time of a channel's residuals, run by run.
///
/// The correlation time is 1 + 2 Σ ρ of the lags up to the first whose ρ is within three standard
/// errors of 0.
pub(crate) fn inflation(runs: &[Vec<f64>]) -> f64 {
    let n: usize = runs.iter().map(Vec::len).sum();
    if n < 8 {
        return 1.0;
    }
    let covariance = |lag: usize| -> f64 {
        let pairs = runs.iter().flat_map(|s| s.iter().zip(s.iter().skip(lag)));
        pairs.map(|(a, b)| a * b).sum::<f64>() / n as f64
    };
    let variance = covariance(0);
    let mut time = 1.0;
    let longest = runs.iter().map(Vec::len).max().unwrap_or(0) / 3;
    for lag in 1..longest {
        let correlation = covariance(lag) / variance.max(1e-300);
        if correlation < 3.0 / (n as f64).sqrt() {
            break;
        }
        time += 2.0 * correlation;
    }
    variance.max(1.0) * time
}

#[cfg(test)]
mod tests {
    use rand_distr::{Distribution, StandardNormal};
    use rand_pcg::Pcg64;

    use super::*;

    /// Shapes are orthonormal as far as sums are integrals.
    #[test]
    fn shapes_are_orthonormal() {
        let shapes = shapes(2000);
        for (i, a) in shapes.iter().enumerate() {
            for (j, b) in shapes.iter().enumerate() {
                let one = f64::from(u8::from(i == j));
                assert!((dot(a, b) - one).abs() < 1e-4, "{i} {j}");
            }
        }
    }

    /// An autoregressive series with coefficient ρ has the correlation time (1 + ρ)/(1 − ρ).
    #[test]
    fn correlation_time_of_an_autoregression() {
        for (rho, seed) in [(0.0, 1), (0.5, 2), (0.8, 3)] {
            let mut random = Pcg64::new(seed, 5);
            let mut x = 0.0;
            let run: Vec<f64> = (0..200_000)
                .map(|_| {
                    let z: f64 = StandardNormal.sample(&mut random);
                    x = rho * x + f64::sqrt(1.0 - rho * rho) * z;
                    2.0 * x
                })
                .collect();
            let known = 4.0 * (1.0 + rho) / (1.0 - rho);
            let found = inflation(&[run]);
            assert!((found / known - 1.0).abs() < 0.05, "{rho}: {found} {known}");
        }
        assert_eq!(inflation(&[vec![9.0; 7]]), 1.0, "too few to tell");
    }
}
