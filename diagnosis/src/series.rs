//! Residuals of each run and channel as series in time: their smooth parts, and how they follow
//! each other.

use saltus_numeric::statistics::percentile;

use crate::fit::{self, Fit};
use crate::kind::Kind;
use crate::likelihood::{WAVES, cosines};

/// Smooth shapes over a run that residuals are compared with: cosines.
pub(crate) const SHAPES: usize = WAVES;

/// The readings of one channel in one run.
pub(crate) struct Series {
    pub(crate) channel: usize,
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
}

/// Every series of an experiment that is not empty, run by run.
pub(crate) fn series(kind: &dyn Kind) -> Vec<Series> {
    let mut all = Vec::new();
    let mut start = 0;
    for log in kind.logs() {
        for channel in 0..kind.channels().len() {
            let places: Vec<usize> = (0..log.readings.len())
                .filter(|i| log.readings[*i].channel == channel)
                .map(|i| start + i)
                .collect();
            if !places.is_empty() {
                all.push(Series {
                    channel,
                    shapes: cosines(places.len()),
                    places,
                });
            }
        }
        start += log.readings.len();
    }
    all
}

/// Variance inflation of what `model` leaves: variance times correlation time, at least 1; the greatest
/// over channels.
pub(crate) fn inflation(kind: &dyn Kind, model: &Fit) -> f64 {
    let residuals = |run: usize| {
        fit::residuals(kind, run, &model.terms, &model.unknowns[run]).unwrap_or_default()
    };
    let raw: Vec<f64> = (0..kind.logs().len()).flat_map(residuals).collect();
    // Outliers are cut; what is off by less than that everywhere is not made of outliers.
    let mut sizes: Vec<f64> = raw.iter().map(|r| r.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let cut = (2.0 * percentile(&sizes, 0.95)).max(3.0);
    let residuals: Vec<f64> = raw.iter().map(|r| r.clamp(-cut, cut)).collect();
    let all = series(kind);
    let of = |channel: usize| {
        let these = all.iter().filter(|s| s.channel == channel);
        inflation_of(&these.map(|s| s.of(&residuals)).collect::<Vec<_>>())
    };
    (0..kind.channels().len()).map(of).fold(1.0, f64::max)
}

/// Variance times correlation time of a channel's residuals, run by run.
///
/// The correlation time is 1 + 2 Σ ρ of the lags up to the first whose ρ is within three standard
/// errors of 0.
fn inflation_of(runs: &[Vec<f64>]) -> f64 {
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
    use saltus_numeric::statistics::dot;

    use super::*;

    #[test]
    fn shapes_are_orthonormal() {
        let shapes = cosines(2000);
        for (i, a) in shapes.iter().enumerate() {
            for (j, b) in shapes.iter().enumerate() {
                let one = f64::from(u8::from(i == j));
                assert!((dot(a, b) - one).abs() < 1e-9, "{i} {j}");
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
            let found = inflation_of(&[run]);
            assert!((found / known - 1.0).abs() < 0.05, "{rho}: {found} {known}");
        }
        assert_eq!(inflation_of(&[vec![9.0; 7]]), 1.0, "too few to tell");
    }
}
