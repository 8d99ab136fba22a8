//! A measured force over extension and speed, made smooth.

use saltus_numeric::Single;
use saltus_robot::ForceTable;

/// A force table with the slopes that make its interpolant once continuously differentiable.
///
/// Bicubic Hermite patches with slopes by central differences (one-sided at the borders). Beyond
/// the table's last speed the force stays that of the last speed; extensions are within the table,
/// as the robot's checks require.
#[derive(Clone, Debug)]
pub struct ForceSurface {
    table: ForceTable,
}

impl ForceSurface {
    pub(crate) fn new(table: &ForceTable) -> ForceSurface {
        ForceSurface {
            table: table.clone(),
        }
    }

    /// Extensions (m) between which the interpolant is one polynomial in d.
    pub fn knots(&self) -> &[f64] {
        &self.table.extensions
    }

    /// Force (N), ∂F/∂d (N/m) and ∂F/∂ḋ (N s/m) at extension `d` (m) and `speed` (m/s).
    pub fn force<S: Single>(&self, d: S, speed: S) -> (S, S, S) {
        let t = &self.table;
        let (i, (wd, wd_slope)) = weights(&t.extensions, d);
        let (j, (wv, wv_slope)) = weights(&t.speeds, speed);
        let sum = |a: &[S; 4], b: &[S; 4]| {
            let mut total = S::of(0.0);
            for (k, wk) in a.iter().enumerate() {
                for (l, wl) in b.iter().enumerate() {
                    total = total + *wk * *wl * S::of(t.forces[i[k] * t.speeds.len() + j[l]]);
                }
            }
            total
        };
        (sum(&wd, &wv), sum(&wd_slope, &wv), sum(&wd, &wv_slope))
    }
}

/// Four grid points and their weights.
type Stencil<S> = ([usize; 4], ([S; 4], [S; 4]));

/// The grid points around `x` with their weights in the value and in the slope.
///
/// Outside the grid the value is the border's and the slope 0.
fn weights<S: Single>(grid: &[f64], x: S) -> Stencil<S> {
    let last = grid.len() - 1;
    let (zero, one) = (S::of(0.0), S::of(1.0));
    let border = |k: usize| ([k; 4], ([one, zero, zero, zero], [zero; 4]));
    if x.value() < grid[0] {
        return border(0);
    }
    if x.value() > grid[last] {
        return border(last);
    }
    let k = grid.partition_point(|g| *g <= x.value()).clamp(1, last) - 1;
    let h = grid[k + 1] - grid[k];
    let t = (x - S::of(grid[k])) * S::of(1.0 / h);
    let (t2, t3) = (t * t, t * t * t);
    // Hermite basis: value and slope at both ends, and their derivatives.
    let c = S::of;
    let basis = [
        c(2.0) * t3 - c(3.0) * t2 + one,
        t3 - c(2.0) * t2 + t,
        c(3.0) * t2 - c(2.0) * t3,
        t3 - t2,
    ];
    let slopes = [
        c(6.0) * (t2 - t),
        c(3.0) * t2 - c(4.0) * t + one,
        c(6.0) * (t - t2),
        c(3.0) * t2 - c(2.0) * t,
    ];
    let points = [k.saturating_sub(1), k, k + 1, (k + 2).min(last)];
    let combine = |b: [S; 4]| {
        // Slope at a grid point by the difference of its neighbours.
        let left = b[1] * c(h / (grid[k + 1] - grid[points[0]]));
        let right = b[3] * c(h / (grid[points[3]] - grid[k]));
        [-left, b[0] - right, b[2] + left, right]
    };
    let inverse = S::of(1.0 / h);
    (
        points,
        (combine(basis), combine(slopes).map(|w| w * inverse)),
    )
}
