//! Quantiles and tests of the usual distributions.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Quantile of χ² with so many degrees of freedom.
pub(crate) fn chi_square(degrees: usize, probability: f64) -> f64 {
    ChiSquared::new(degrees as f64).map_or(f64::INFINITY, |d| d.inverse_cdf(probability))
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
        assert!((student(3) - 3.182_446).abs() < 1e-5);
    }
}
