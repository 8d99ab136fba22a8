//! Linear complementarity by Lemke's method: w = M z + q, with w ≥ 0, z ≥ 0 and w·z = 0.
//!
//! For a step's contact impulses in the form of Stewart and Trinkle, M is copositive, so that the
//! method ends at a solution.
//!
//! Source: Cottle, Pang & Stone, The Linear Complementarity Problem (1992), section 4.4; Stewart &
//! Trinkle, Int. J. Numer. Methods Eng. 39 (1996).

/// Room for a problem.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lemke {
    /// Number of variables n.
    n: usize,
    /// M, row by row.
    pub m: Vec<f64>,
    pub q: Vec<f64>,
    /// The solution z.
    pub z: Vec<f64>,
    /// Rows of [I | −M | −1 | q]: w, z, the artificial variable, the right side.
    tableau: Vec<f64>,
    basis: Vec<usize>,
}

/// Pivots after which it gives up.
const MOST_PIVOTS: usize = 400;
/// Entries of a column below this part of its greatest are none.
const NOTHING: f64 = 1e-11;

impl Lemke {
    /// A problem of `n` variables, all 0.
    pub(crate) fn clear(&mut self, n: usize) {
        self.n = n;
        self.m.clear();
        self.m.resize(n * n, 0.0);
        self.q.clear();
        self.q.resize(n, 0.0);
    }

    /// Finds z; false where there is none, or the pivots run out.
    pub(crate) fn solve(&mut self) -> bool {
        let n = self.n;
        self.z.clear();
        self.z.resize(n, 0.0);
        let Some(worst) = (0..n).min_by(|&a, &b| self.q[a].total_cmp(&self.q[b])) else {
            return true;
        };
        if self.q[worst] >= 0.0 {
            return true;
        }
        self.begin();
        let (mut row, mut entering) = (worst, 2 * n);
        for _ in 0..MOST_PIVOTS {
            let leaving = self.basis[row];
            self.pivot(row, entering);
            if leaving == 2 * n {
                return self.finish();
            }
            // The complement of what left comes in.
            entering = if leaving < n {
                leaving + n
            } else {
                leaving - n
            };
            let Some(next) = self.leaving_row(entering) else {
                return false;
            };
            row = next;
        }
        false
    }

    fn width(&self) -> usize {
        2 * self.n + 2
    }

    fn begin(&mut self) {
        let (n, width) = (self.n, self.width());
        self.tableau.clear();
        self.tableau.resize(n * width, 0.0);
        self.basis.clear();
        self.basis.extend(0..n);
        let scale = self.q.iter().fold(0.0_f64, |s, x| s.max(x.abs()));
        for i in 0..n {
            let row = &mut self.tableau[i * width..(i + 1) * width];
            row[i] = 1.0;
            for j in 0..n {
                row[n + j] = -self.m[i * n + j];
            }
            row[2 * n] = -1.0;
            // Small and unequal: ties, at which the method could go round in circles, do not come.
            row[2 * n + 1] = self.q[i] + scale * 1e-13 * (i as f64 + 1.0);
        }
    }

    fn pivot(&mut self, row: usize, column: usize) {
        let width = self.width();
        let inverse = 1.0 / self.tableau[row * width + column];
        for x in &mut self.tableau[row * width..(row + 1) * width] {
            *x *= inverse;
        }
        let (above, rest) = self.tableau.split_at_mut(row * width);
        let (pivot, below) = rest.split_at_mut(width);
        for other in above
            .chunks_exact_mut(width)
            .chain(below.chunks_exact_mut(width))
        {
            let factor = other[column];
            if factor != 0.0 {
                for (x, p) in other.iter_mut().zip(&*pivot) {
                    *x -= factor * p;
                }
            }
        }
        self.basis[row] = column;
    }

    /// The row whose variable comes to 0 first as `column` grows: of equals, the artificial one's,
    /// or that with the greatest entry.
    fn leaving_row(&self, column: usize) -> Option<usize> {
        let (n, width) = (self.n, self.width());
        let entry = |i: usize| self.tableau[i * width + column];
        let greatest = (0..n).fold(0.0_f64, |s, i| s.max(entry(i).abs()));
        let mut best: Option<(usize, f64)> = None;
        for i in 0..n {
            if entry(i) <= NOTHING * greatest {
                continue;
            }
            let ratio = self.tableau[i * width + width - 1] / entry(i);
            let is_better = best.is_none_or(|(b, least)| {
                let slack = 1e-14 * least.abs();
                ratio < least - slack
                    || (ratio <= least + slack
                        && (self.basis[i] == 2 * n
                            || (self.basis[b] != 2 * n && entry(i) > entry(b))))
            });
            if is_better {
                best = Some((i, ratio));
            }
        }
        best.map(|(i, _)| i)
    }

    fn finish(&mut self) -> bool {
        let (n, width) = (self.n, self.width());
        for (i, &variable) in self.basis.iter().enumerate() {
            if (n..2 * n).contains(&variable) {
                self.z[variable - n] = self.tableau[i * width + width - 1].max(0.0);
            }
        }
        self.z.iter().all(|z| z.is_finite())
    }
}
