//! Quantiles and tests of the usual distributions.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Quantile of χ² with so many degrees of freedom.
pub(crate) fn chi_square(degrees: usize, probability: f64) -> f64 {
    ChiSquared::new(degrees as f64).map_or(f64::INFINITY, |d| d.inverse_cdf(probability))
}

/// Whether the losses `a` of folds are greater than the losses `b` of the same folds: paired test
/// by Student's t, one-sided, 2.5 %.
pub(crate) fn is_worse(a: &[f64], b: &[f64]) -> bool {
    let n = a.len() as f64;
    let mean = a.iter().zip(b).map(|(a, b)| a - b).sum::<f64>() / n;
    let square = a
        .iter()
        .zip(b)
        .map(|(a, b)| (a - b - mean).powi(2))
        .sum::<f64>()
        / (n - 1.0).max(1.0);
    mean > student(a.len().max(2) - 1) * (square / n).sqrt()
}

/// Quantile of Student's t with so many degrees of freedom, ≥ 1, that 2.5 % exceed.
pub(crate) fn student(degrees: usize) -> f64 {
    StudentsT::new(0.0, 1.0, degrees as f64).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of the distributions: χ² 0.95 of 1 and 3 degrees, t 0.975 of 3.
    #[test]
    fn quantiles_are_those_of_the_tables() {
        assert!((chi_square(1, 0.95) - 3.841_459).abs() < 1e-5);
        assert!((chi_square(3, 0.95) - 7.814_728).abs() < 1e-5);
        // Differences 1 ± s: t of four pairs is 3.1824, so they are worse where s is less than
        // 2 / 3.1824 · √3 / 2.
        let pairs = |s: f64| is_worse(&[1.0 + s, 1.0 - s, 1.0 + s, 1.0 - s], &[0.0; 4]);
        let limit = 2.0 / 3.182_446 * 3.0_f64.sqrt() / 2.0;
        assert!(pairs(0.999 * limit) && !pairs(1.001 * limit));
    }
}
