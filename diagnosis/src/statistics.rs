//! Small statistics that several files need.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

/// Scalar product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Mean; 0 of nothing.
pub(crate) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Median; 0 of nothing.
pub(crate) fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The value that a `part` of the sorted values does not exceed; infinite of nothing.
pub(crate) fn percentile(sorted: &[f64], part: f64) -> f64 {
    if sorted.is_empty() {
        return f64::INFINITY;
    }
    // An index.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let k = (part * sorted.len() as f64).ceil() as usize;
    sorted[k.clamp(1, sorted.len()) - 1]
}

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
    let limit = StudentsT::new(0.0, 1.0, (n - 1.0).max(1.0))
        .map_or(f64::INFINITY, |t| t.inverse_cdf(0.975));
    mean > limit * (square / n).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_hundred() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(percentile(&values, 0.95), 95.0);
        assert_eq!(percentile(&values, 0.0), 1.0);
        assert_eq!(percentile(&values, 1.0), 100.0);
        assert_eq!(percentile(&[], 0.5), f64::INFINITY);
    }

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

    #[test]
    fn the_median_of_few() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut []), 0.0);
        assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
        assert_eq!(mean(&[]), 0.0);
    }
}
