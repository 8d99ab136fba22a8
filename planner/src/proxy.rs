//! A function of one variable, sampled where it costs and then known everywhere: piecewise
//! Chebyshev interpolants.
//!
//! Source: Boyd, Solving Transcendental Equations (SIAM 2014), ch. 2–3: adaptive interpolation,
//! roots from the interpolant.

use std::f64::consts::PI;

use saltus_numeric::root::bisect;

/// Points at which each piece is sampled.
pub(crate) const NODES: usize = 20;

/// A polynomial interpolant on one interval.
#[derive(Clone, Debug)]
pub(crate) struct Piece {
    pub low: f64,
    pub high: f64,
    coefficients: [f64; NODES],
}

/// A stretch on which an interpolant is monotonic.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Branch {
    /// Index of its piece.
    pub piece: usize,
    pub low: f64,
    pub high: f64,
    /// Values at the two ends.
    pub at_low: f64,
    pub at_high: f64,
}

/// The sample points in [low, high], ascending.
pub(crate) fn nodes(low: f64, high: f64) -> [f64; NODES] {
    std::array::from_fn(|k| {
        let angle = PI * (k as f64 + 0.5) / NODES as f64;
        0.5 * (low + high) - 0.5 * (high - low) * angle.cos()
    })
}

/// cos(π j (k + ½)/n) for all j and k.
fn cosines() -> &'static [[f64; NODES]; NODES] {
    static TABLE: std::sync::OnceLock<[[f64; NODES]; NODES]> = std::sync::OnceLock::new();
    TABLE.get_or_init(|| {
        std::array::from_fn(|j| {
            std::array::from_fn(|k| (PI * j as f64 * (k as f64 + 0.5) / NODES as f64).cos())
        })
    })
}

impl Piece {
    /// The interpolant through `values` at [`nodes`].
    pub(crate) fn new(low: f64, high: f64, values: &[f64; NODES]) -> Piece {
        let mut coefficients = [0.0; NODES];
        for (j, (c, row)) in coefficients.iter_mut().zip(cosines()).enumerate() {
            // The nodes ascend where the cosine's argument does, so x runs against it.
            let sum: f64 = row.iter().zip(values).map(|(cos, v)| cos * v).sum();
            let sign = if j % 2 == 0 { 1.0 } else { -1.0 };
            *c = sign * sum * if j == 0 { 1.0 } else { 2.0 } / NODES as f64;
        }
        Piece {
            low,
            high,
            coefficients,
        }
    }

    /// Size of the last coefficients: about what the interpolant is off by.
    pub(crate) fn tail(&self) -> f64 {
        self.coefficients[NODES - 3..]
            .iter()
            .fold(0.0, |m, c| m.max(c.abs()))
    }

    /// Value and slope at `x`, by Clenshaw's recurrence.
    pub(crate) fn at(&self, x: f64) -> (f64, f64) {
        let scale = 2.0 / (self.high - self.low);
        let t = (x - self.low) * scale - 1.0;
        let (mut b1, mut b2, mut d1, mut d2) = (0.0, 0.0, 0.0, 0.0);
        for c in self.coefficients[1..].iter().rev() {
            (d1, d2) = (2.0 * t * d1 - d2 + 2.0 * b1, d1);
            (b1, b2) = (2.0 * t * b1 - b2 + c, b1);
        }
        (
            self.coefficients[0] + t * b1 - b2,
            (b1 + t * d1 - d2) * scale,
        )
    }

    /// Adds the stretches on which this piece, number `index`, is monotonic.
    ///
    /// A turn is seen if the slope's sign differs between two of four samples a node.
    pub(crate) fn branches(&self, index: usize, into: &mut Vec<Branch>) {
        const SAMPLES: usize = 4 * NODES;
        let x = |i: usize| self.low + (self.high - self.low) * i as f64 / SAMPLES as f64;
        let mut start = (self.low, self.at(self.low).0);
        let mut slope = self.at(self.low).1;
        for i in 1..=SAMPLES {
            let next = self.at(x(i)).1;
            if slope * next < 0.0 {
                let turn = self.turn(x(i - 1), x(i), slope);
                let value = self.at(turn).0;
                into.push(Branch {
                    piece: index,
                    low: start.0,
                    high: turn,
                    at_low: start.1,
                    at_high: value,
                });
                start = (turn, value);
            }
            slope = next;
        }
        let value = self.at(self.high).0;
        into.push(Branch {
            piece: index,
            low: start.0,
            high: self.high,
            at_low: start.1,
            at_high: value,
        });
    }

    /// Where the slope, whose sign at `a` is that of `slope`, vanishes between `a` and `b`: by
    /// bisection to round-off.
    fn turn(&self, a: f64, b: f64, slope: f64) -> f64 {
        let (a, b) = bisect(a, b, 60, |x| self.at(x).1 * slope > 0.0);
        0.5 * (a + b)
    }

    /// Where the interpolant takes `value` on `branch`: Newton's method, held inside the bracket by
    /// bisection.
    pub(crate) fn solve(&self, branch: &Branch, value: f64) -> Option<f64> {
        let (mut a, mut b) = (branch.low, branch.high);
        let (fa, fb) = (branch.at_low - value, branch.at_high - value);
        if fa * fb > 0.0 {
            return None;
        }
        let rising = fb > fa;
        let mut x = if fb == fa {
            a
        } else {
            a - fa * (b - a) / (fb - fa)
        };
        for _ in 0..60 {
            let (f, slope) = self.at(x);
            let f = f - value;
            if (f > 0.0) == rising {
                b = x;
            } else {
                a = x;
            }
            let newton = x - f / slope;
            let next = if newton > a && newton < b {
                newton
            } else {
                0.5 * (a + b)
            };
            if (next - x).abs() <= 1e-15 {
                return Some(next);
            }
            x = next;
        }
        Some(x)
    }
}
