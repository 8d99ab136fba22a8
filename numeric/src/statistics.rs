//! Small statistics of plain numbers.

/// Scalar product; of the shorter length.
#[inline]
pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Mean; 0 of nothing.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Root mean square; 0 of nothing.
pub fn rms(values: &[f64]) -> f64 {
    (dot(values, values) / values.len().max(1) as f64).sqrt()
}

/// Median, of an even number the upper one; 0 of nothing. Reorders the values.
pub fn median(values: &mut [f64]) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// The finite value that a `share` (0 to 1) of the finite values is below; none of nothing.
pub fn quantile(values: &[f64], share: f64) -> Option<f64> {
    let mut finite: Vec<f64> = values.iter().copied().filter(|x| x.is_finite()).collect();
    finite.sort_by(f64::total_cmp);
    // A row.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let row = (share * finite.len().saturating_sub(1) as f64).round() as usize;
    finite.get(row).copied()
}

/// The value that a `share` (0 to 1) of the sorted values does not exceed; infinite of nothing.
pub fn percentile(sorted: &[f64], share: f64) -> f64 {
    if sorted.is_empty() {
        return f64::INFINITY;
    }
    // An index.
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    let k = (share * sorted.len() as f64).ceil() as usize;
    sorted[k.clamp(1, sorted.len()) - 1]
}

/// Slope and intercept of the least-squares line through `points`; none if they do not have two
/// abscissae.
pub fn line(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let n = points.len() as f64;
    let (mx, my) = (
        points.iter().map(|p| p.0).sum::<f64>() / n,
        points.iter().map(|p| p.1).sum::<f64>() / n,
    );
    let spread: f64 = points.iter().map(|p| (p.0 - mx) * (p.0 - mx)).sum();
    if points.len() < 2 || spread <= 0.0 {
        return None;
    }
    let slope = points.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / spread;
    Some((slope, my - slope * mx))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_of_few() {
        assert_eq!(mean(&[1.0, 2.0, 6.0]), 3.0);
        assert_eq!(mean(&[]), 0.0);
        assert_eq!(rms(&[3.0, -3.0, 3.0]), 3.0);
        assert_eq!(rms(&[]), 0.0);
        assert_eq!(dot(&[1.0, 2.0], &[3.0, 4.0]), 11.0);
    }

    #[test]
    fn the_median_of_few() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(&mut [3.0, 1.0]), 3.0);
        assert_eq!(median(&mut []), 0.0);
    }

    #[test]
    fn quantiles_leave_out_what_is_not_finite() {
        let values = [f64::NAN, 4.0, 1.0, f64::INFINITY, 3.0, 2.0, 5.0];
        let found = [0.0, 0.5, 1.0].map(|share| quantile(&values, share));
        assert_eq!(found, [Some(1.0), Some(3.0), Some(5.0)]);
        assert_eq!(quantile(&[f64::NAN], 0.5), None);
    }

    #[test]
    fn percentiles_of_a_hundred() {
        let values: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(percentile(&values, 0.95), 95.0);
        assert_eq!(percentile(&values, 0.0), 1.0);
        assert_eq!(percentile(&values, 1.0), 100.0);
        assert_eq!(percentile(&[], 0.5), f64::INFINITY);
    }

    #[test]
    fn a_line_is_found() {
        let points = [1.0, 2.0, 4.0].map(|x| (x, 3.0 - 0.5 * x));
        let (slope, intercept) = line(&points).expect("two abscissae");
        // Round-off of three terms.
        assert!((slope + 0.5).abs() < 1e-14 && (intercept - 3.0).abs() < 1e-14);
        assert_eq!(line(&points[..1]), None);
        assert_eq!(line(&[(1.0, 2.0), (1.0, 3.0)]), None);
    }
}
