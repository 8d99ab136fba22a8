//! What an information matrix tells of parameters, and what not.

use nalgebra::{DMatrix, DVector};

/// Information of a direction, where each parameter alone has information 1, below which it is not
/// identifiable: the error of difference quotients.
pub(crate) const LEAST: f64 = 1e-6;

/// The information on some parameters, in directions that are known independently when each
/// parameter alone has information 1.
pub(crate) struct Identifiability {
    /// Square root of each parameter's own information.
    pub(crate) sizes: Vec<f64>,
    /// Information of each direction.
    pub(crate) information: DVector<f64>,
    /// Unit directions, in columns.
    directions: DMatrix<f64>,
}

impl Identifiability {
    /// Of an information matrix (symmetric, n × n, n ≥ 1).
    pub(crate) fn new(information: &DMatrix<f64>) -> Identifiability {
        let n = information.nrows();
        let sizes: Vec<f64> = (0..n)
            .map(|i| information[(i, i)].max(0.0).sqrt().max(1e-150))
            .collect();
        let scaled = DMatrix::from_fn(n, n, |i, j| information[(i, j)] / (sizes[i] * sizes[j]));
        let eigen = scaled.symmetric_eigen();
        Identifiability {
            sizes,
            information: eigen.eigenvalues,
            directions: eigen.eigenvectors,
        }
    }

    /// Unit direction `k`, in terms of `sizes`.
    pub(crate) fn direction(&self, k: usize) -> DVector<f64> {
        self.directions.column(k).into_owned()
    }

    /// The direction with the least information.
    pub(crate) fn least(&self) -> usize {
        self.information.imin()
    }

    /// Whether direction `k` has more information than the error of difference quotients.
    pub(crate) fn is_identifiable(&self, k: usize) -> bool {
        self.information[k] >= LEAST
    }

    /// Covariance from the directions that `counts`.
    pub(crate) fn covariance(&self, counts: impl Fn(usize) -> bool) -> DMatrix<f64> {
        let n = self.sizes.len();
        let mut inverse = DMatrix::zeros(n, n);
        for k in (0..n).filter(|k| counts(*k)) {
            let v = self.directions.column(k);
            inverse += v * v.transpose() / self.information[k].max(1e-12);
        }
        DMatrix::from_fn(n, n, |i, j| {
            inverse[(i, j)] / (self.sizes[i] * self.sizes[j])
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two readings of a + b, each with an error of 0.1, and one of c with an error of 2.
    #[test]
    fn a_sum_is_identifiable_and_its_terms_are_not() {
        let information = DMatrix::from_row_slice(
            3,
            3,
            &[200.0, 200.0, 0.0, 200.0, 200.0, 0.0, 0.0, 0.0, 0.25],
        );
        let found = Identifiability::new(&information);
        let least = found.least();
        assert!(!found.is_identifiable(least) && found.information[least].abs() < 1e-12);
        let v = found.direction(least);
        assert!((v[0] + v[1]).abs() < 1e-12 && v[2].abs() < 1e-12, "{v}");
        let covariance = found.covariance(|k| found.is_identifiable(k));
        // Variance of the mean of a and b, which is half of their sum, and of c.
        let sum = covariance[(0, 0)] + covariance[(1, 1)] + 2.0 * covariance[(0, 1)];
        assert!((sum - 0.005).abs() < 1e-12 && (covariance[(2, 2)] - 4.0).abs() < 1e-12);
    }

    #[test]
    fn of_what_is_identifiable_it_is_the_inverse() {
        let information = DMatrix::from_row_slice(2, 2, &[4.0, 1.0, 1.0, 9.0]);
        let covariance = Identifiability::new(&information).covariance(|_| true);
        let one = &information * covariance;
        assert!((one - DMatrix::identity(2, 2)).abs().max() < 1e-14);
    }
}
