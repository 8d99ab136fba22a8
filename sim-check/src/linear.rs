//! Small dense linear algebra in place: n is the number of velocities, rarely above twenty.

use nalgebra::{DMatrix, DVector};

/// Factors the symmetric positive definite `m` (n × n, row by row) into L Lᵀ, L in the lower
/// triangle; false where it is not positive definite.
pub(crate) fn cholesky(m: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let (above, rest) = m.split_at_mut(j * n);
        let row = &mut rest[..n];
        for k in 0..j {
            let other = &above[k * n..=k * n + k];
            let dot: f64 = (0..k).map(|i| row[i] * other[i]).sum();
            row[k] = (row[k] - dot) / other[k];
        }
        let pivot = row[j] - row[..j].iter().map(|x| x * x).sum::<f64>();
        if pivot <= 0.0 || pivot.is_nan() {
            return false;
        }
        row[j] = pivot.sqrt();
    }
    true
}

/// L⁻¹ b, in place.
pub(crate) fn forward(l: &[f64], n: usize, b: &mut [f64]) {
    for i in 0..n {
        let row = &l[i * n..=i * n + i];
        let dot: f64 = (0..i).map(|k| row[k] * b[k]).sum();
        b[i] = (b[i] - dot) / row[i];
    }
}

/// L⁻ᵀ b, in place.
pub(crate) fn backward(l: &[f64], n: usize, b: &mut [f64]) {
    for i in (0..n).rev() {
        b[i] /= l[i * n + i];
        let x = b[i];
        for k in 0..i {
            b[k] -= l[i * n + k] * x;
        }
    }
}

/// Pivots below this part of the greatest are rows that say what others have said.
const REDUNDANT: f64 = 1e-12;

/// Solves the m × m system `a` x = `b` (row by row); x is left in `b`. Where rows are redundant,
/// the x of least norm, and true; of numbers that are none, NaN.
pub(crate) fn solve(a: &mut [f64], m: usize, b: &mut [f64]) -> bool {
    let scale = a[..m * m].iter().fold(0.0_f64, |s, x| s.max(x.abs()));
    let whole = Small::of(&a[..m * m], &b[..m]);
    if eliminate(a, m, b, REDUNDANT * scale) {
        return false;
    }
    let (a, right) = whole.get();
    match least_norm(a, right, m) {
        Some(x) => b[..m].copy_from_slice(&x),
        None => b[..m].fill(f64::NAN),
    }
    true
}

/// The x of least norm that solves the equations of `a` x = `b` which pivots above [`REDUNDANT`] of
/// the greatest lead; none where there is a number that is not finite.
///
/// Elimination with full pivoting gives a solution and the null space, onto which that solution
/// must have no part.
fn least_norm(a: &[f64], b: &[f64], m: usize) -> Option<Vec<f64>> {
    let mut a = DMatrix::from_row_slice(m, m, a);
    let mut b = DVector::from_row_slice(b);
    let least = REDUNDANT * a.amax();
    let mut order: Vec<usize> = (0..m).collect();
    let mut rank = 0;
    while rank < m {
        let (i, j) = a.view_range(rank.., rank..).icamax_full();
        let (i, j) = (i + rank, j + rank);
        if a[(i, j)].is_nan() || a[(i, j)].abs() <= least {
            break;
        }
        a.swap_rows(rank, i);
        b.swap_rows(rank, i);
        a.swap_columns(rank, j);
        order.swap(rank, j);
        // Gauss–Jordan: what leads here is nowhere else.
        let pivot = a[(rank, rank)];
        for row in (0..m).filter(|&row| row != rank) {
            let factor = a[(row, rank)] / pivot;
            for k in rank..m {
                let part = factor * a[(rank, k)];
                a[(row, k)] -= part;
            }
            let part = factor * b[rank];
            b[row] -= part;
        }
        rank += 1;
    }
    let pivots = a.diagonal();
    let mut x = DVector::from_fn(m, |i, _| if i < rank { b[i] / pivots[i] } else { 0.0 });
    let null = DMatrix::from_fn(m, m - rank, |i, k| match i {
        i if i < rank => -a[(i, rank + k)] / pivots[i],
        i => f64::from(i == rank + k),
    });
    if null.ncols() > 0 {
        let part = (null.transpose() * &null)
            .cholesky()?
            .solve(&(null.transpose() * &x));
        x -= null * part;
    }
    let mut found = vec![0.0; m];
    order.iter().zip(x.iter()).for_each(|(&k, x)| found[k] = *x);
    found.iter().all(|x| x.is_finite()).then_some(found)
}

/// A copy of a system, which for the usual three rows or fewer needs no heap.
enum Small {
    Here([f64; 9], [f64; 3], usize),
    Heap(Vec<f64>, Vec<f64>),
}

impl Small {
    fn of(a: &[f64], b: &[f64]) -> Small {
        if b.len() > 3 {
            return Small::Heap(a.to_vec(), b.to_vec());
        }
        let (mut x, mut y) = ([0.0; 9], [0.0; 3]);
        x[..a.len()].copy_from_slice(a);
        y[..b.len()].copy_from_slice(b);
        Small::Here(x, y, b.len())
    }

    fn get(&self) -> (&[f64], &[f64]) {
        match self {
            Small::Here(a, b, m) => (&a[..m * m], &b[..*m]),
            Small::Heap(a, b) => (a, b),
        }
    }
}

/// Gaussian elimination with partial pivoting; false at a pivot below `least`.
fn eliminate(a: &mut [f64], m: usize, b: &mut [f64], least: f64) -> bool {
    for j in 0..m {
        let mut pivot = j;
        for i in j + 1..m {
            if a[i * m + j].abs() > a[pivot * m + j].abs() {
                pivot = i;
            }
        }
        let size = a[pivot * m + j].abs();
        if size <= least || size.is_nan() {
            return false;
        }
        if pivot != j {
            for k in 0..m {
                a.swap(j * m + k, pivot * m + k);
            }
            b.swap(j, pivot);
        }
        let inverse = 1.0 / a[j * m + j];
        for i in j + 1..m {
            let factor = a[i * m + j] * inverse;
            if factor != 0.0 {
                for k in j + 1..m {
                    a[i * m + k] -= factor * a[j * m + k];
                }
                b[i] -= factor * b[j];
            }
        }
    }
    for i in (0..m).rev() {
        let dot: f64 = (i + 1..m).map(|k| a[i * m + k] * b[k]).sum();
        b[i] = (b[i] - dot) / a[i * m + i];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn systems_are_solved_and_redundant_ones_by_least_norm() {
        let mut a = [4.0, 1.0, 1.0, 3.0];
        let mut b = [1.0, 2.0];
        assert!(!solve(&mut a, 2, &mut b));
        assert!((4.0 * b[0] + b[1] - 1.0).abs() < 1e-15 && (b[0] + 3.0 * b[1] - 2.0).abs() < 1e-15);
        let mut a = [1.0, 1.0, 1.0, 1.0];
        let mut b = [2.0, 2.0];
        assert!(solve(&mut a, 2, &mut b));
        assert!((b[0] - 1.0).abs() < 1e-14 && (b[1] - 1.0).abs() < 1e-14);
    }

    #[test]
    fn redundant_systems_are_solved_to_round_off() {
        // The normals of four corners that slide: rank 3, not symmetric.
        let left = [
            [1.0, 0.3, -0.2],
            [0.9, -1.1, 0.4],
            [1.2, 0.7, 1.5],
            [1.1, -0.7, 2.1],
        ];
        let right = [
            [1.0, 0.4, 0.6, 0.0],
            [0.2, 1.3, -0.7, 0.4],
            [0.5, -0.6, 1.7, 0.6],
        ];
        let mut a = [0.0; 16];
        for (i, j) in (0..16).map(|k| (k / 4, k % 4)) {
            a[i * 4 + j] = (0..3).map(|k| left[i][k] * right[k][j]).sum();
        }
        let whole = a;
        let null = null_of(&right);
        let some = [0.3, 1.0, -0.4, 2.0];
        let mut b: Vec<f64> = (0..4)
            .map(|i| (0..4).map(|k| a[i * 4 + k] * some[k]).sum())
            .collect();
        let wanted = b.clone();
        assert!(solve(&mut a, 4, &mut b));
        for i in 0..4 {
            let got: f64 = (0..4).map(|k| whole[i * 4 + k] * b[k]).sum();
            assert!(
                (got - wanted[i]).abs() < 1e-14,
                "row {i}: {got} for {}",
                wanted[i]
            );
        }
        let part: f64 = (0..4).map(|k| null[k] * b[k]).sum();
        assert!(part.abs() < 1e-14, "{part} along the null space");
    }

    /// The vector across three rows of four: their signed minors.
    fn null_of(rows: &[[f64; 4]; 3]) -> [f64; 4] {
        std::array::from_fn(|skipped| {
            let columns: Vec<usize> = (0..4).filter(|&k| k != skipped).collect();
            let minor = nalgebra::Matrix3::from_fn(|i, j| rows[i][columns[j]]).determinant();
            if skipped % 2 == 0 { minor } else { -minor }
        })
    }

    #[test]
    fn cholesky_factors() {
        let mut m = [4.0, 2.0, 0.6, 2.0, 5.0, 1.0, 0.6, 1.0, 3.0];
        let whole = m;
        assert!(cholesky(&mut m, 3));
        let mut b = [1.0, -2.0, 0.5];
        forward(&m, 3, &mut b);
        backward(&m, 3, &mut b);
        for (i, wanted) in [1.0, -2.0, 0.5].into_iter().enumerate() {
            let got: f64 = (0..3).map(|k| whole[i * 3 + k] * b[k]).sum();
            assert!((got - wanted).abs() < 1e-14);
        }
        assert!(!cholesky(&mut [1.0, 2.0, 2.0, 1.0], 2));
    }
}
