//! A pneumatic muscle with a tendon: its pull and its volume over contraction and pressure.
//!
//! Pull per pascal is the cubic of Hermite between the full length, where it and its slope are
//! given, and the free contraction e, where both are 0. The gas does the work of the pull:
//! ∂V/∂x = f/p.

/// Greatest gauge pressure (Pa) at which a polynomial of the free contraction is looked at.
const MOST: f64 = 1e6;

/// A muscle.
#[derive(Clone, Debug)]
pub(super) struct Muscle {
    /// Volume (m³) at the full length.
    pub volume: f64,
    /// Pull per pascal (N/Pa) at the full length.
    pub pull: f64,
    /// By how much that falls with the contraction (N/(Pa m)).
    pub slope: f64,
    /// Free contraction (m): coefficients of a polynomial in the gauge pressure (Pa).
    pub reach: Vec<f64>,
    /// Gauge pressure (Pa) up to which that polynomial rises; above it the contraction stays.
    pub rises_to: f64,
    /// Pull in terms of the cubic's at half of the free contraction, less 1: a muscle of another
    /// shape.
    pub bulge: f64,
}

/// A muscle at a contraction and a pressure, with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// N.
    pub pull: f64,
    /// N/m and N/Pa.
    pub pull_by: [f64; 2],
    /// m³.
    pub volume: f64,
    /// m² and m³/Pa.
    pub volume_by: [f64; 2],
}

/// The pressure (Pa) of the first maximum of a polynomial.
pub(super) fn rising_to(reach: &[f64]) -> f64 {
    const POINTS: u32 = 20_000;
    let at = |k: u32| MOST * f64::from(k) / f64::from(POINTS);
    let falls = |k: &u32| polynomial(reach, at(*k))[1] <= 0.0;
    at((0..=POINTS).find(falls).unwrap_or(POINTS))
}

impl Muscle {
    /// Free contraction (m), and how it changes with the pressure (m/Pa).
    fn end(&self, gauge: f64) -> [f64; 2] {
        let [end, by] = polynomial(&self.reach, gauge.clamp(0.0, self.rises_to));
        [
            end,
            if (0.0..self.rises_to).contains(&gauge) {
                by
            } else {
                0.0
            },
        ]
    }

    /// The muscle at a contraction (m) and a gauge pressure (Pa).
    pub(super) fn at(&self, x: f64, gauge: f64) -> Shape {
        let p = gauge.max(0.0);
        let [end, end_by] = self.end(gauge);
        let (a, b) = (self.pull, self.slope);
        if x < 0.0 {
            // Stretched: it goes on along its line.
            let each = a - b * x;
            return Shape {
                pull: p * each,
                pull_by: [-b * p, if gauge > 0.0 { each } else { 0.0 }],
                volume: self.volume + a * x - 0.5 * b * x * x,
                volume_by: [each, 0.0],
            };
        }
        let (z, c) = ((x / end).min(1.0), self.bulge);
        let left = 1.0 - z;
        // The cubic, and a hump z² (1 − z)² beside it.
        let hump = 16.0 * c * a * z * z * left * left;
        let each = left * left * (a * (1.0 + 2.0 * z) - b * end * z) + 0.5 * hump;
        let each_by_z = -6.0 * a * z * left - b * end * left * (1.0 - 3.0 * z)
            + 16.0 * c * a * z * left * (1.0 - 2.0 * z);
        let each_by_end = (6.0 * a / end - 2.0 * b) * z * z * left
            - 16.0 * c * a * z * z * left * (1.0 - 2.0 * z) / end;
        let grown = |z: f64| {
            let cubic = z * (1.0 - z * z * (1.0 - 0.5 * z));
            let fall = z * z * (0.5 - z * (2.0 / 3.0 - 0.25 * z));
            let humped = 8.0 * c * z.powi(3) * (1.0 / 3.0 - z * (0.5 - 0.2 * z));
            [a * (cubic + humped), b * fall]
        };
        let [rise, fall] = grown(z);
        // ∂/∂e of e g(x/e) − e² k(x/e) at the same x.
        let by_end = rise - 2.0 * end * fall - z * each;
        Shape {
            pull: p * each,
            pull_by: [
                p * each_by_z / end,
                if gauge > 0.0 {
                    each + p * each_by_end * end_by
                } else {
                    0.0
                },
            ],
            volume: self.volume + end * rise - end * end * fall,
            volume_by: [each, by_end * end_by],
        }
    }

    /// Contraction (m) where the joint lets the muscle come in by `travel` (m), and a tendon of
    /// `compliance` (m/N) lets it come in further: x = travel + C f(x).
    pub(super) fn through(&self, compliance: f64, travel: f64, gauge: f64) -> f64 {
        let (mut low, mut high) = (travel, travel + compliance * self.at(travel, gauge).pull);
        let mut x = high;
        for _ in 0..60 {
            let shape = self.at(x, gauge);
            let off = x - travel - compliance * shape.pull;
            if off > 0.0 {
                high = x;
            } else {
                low = x;
            }
            let newton = x - off / (1.0 - compliance * shape.pull_by[0]);
            let next = if (low..=high).contains(&newton) {
                newton
            } else {
                low.midpoint(high)
            };
            if (next - x).abs() < 1e-13 {
                return next;
            }
            x = next;
        }
        x
    }
}

/// A polynomial and its slope.
fn polynomial(coefficients: &[f64], x: f64) -> [f64; 2] {
    let add = |[sum, slope]: [f64; 2], c: &f64| [sum * x + c, slope * x + sum];
    coefficients.iter().rev().fold([0.0; 2], add)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn muscle(bulge: f64) -> Muscle {
        let reach = vec![0.03, 7.5e-7, -4.9e-12, 1.4e-17, -1.5e-23];
        Muscle {
            volume: 4.2e-5,
            pull: 1.95e-3,
            slope: 0.035,
            rises_to: rising_to(&reach),
            reach,
            bulge,
        }
    }

    /// Derivatives are those of the pull and the volume; ∂V/∂x is the pull per pascal.
    #[test]
    fn a_muscle_does_the_work_of_its_gas() {
        for bulge in [0.0, 0.2] {
            let muscle = muscle(bulge);
            for (x, p) in [
                (0.013, 2e5),
                (0.013, 8e4),
                (0.03, 1.1e5),
                (-4e-3, 1e5),
                (0.2, 3e5),
            ] {
                let shape = muscle.at(x, p);
                let [dx, dp] = [1e-6, 1.0];
                let by = |pick: fn(&Shape) -> f64| {
                    let along = |a: Shape, b: Shape, d: f64| (pick(&a) - pick(&b)) / (2.0 * d);
                    [
                        along(muscle.at(x + dx, p), muscle.at(x - dx, p), dx),
                        along(muscle.at(x, p + dp), muscle.at(x, p - dp), dp),
                    ]
                };
                let pairs = [
                    (shape.pull_by, by(|s| s.pull)),
                    (shape.volume_by, by(|s| s.volume)),
                ];
                for ([a, b], [c, d]) in pairs {
                    // Differences of numbers with 16 digits.
                    assert!((a - c).abs() < 1e-6 * (1.0 + a.abs()), "{x} {p}: {a} {c}");
                    assert!((b - d).abs() < 1e-6 * b.abs() + 1e-12, "{x} {p}: {b} {d}");
                }
                assert!(
                    (shape.volume_by[0] * p - shape.pull).abs() < 1e-9,
                    "{x} {p}"
                );
            }
        }
    }

    /// What the tendon gives is its compliance times the pull.
    #[test]
    fn a_tendon_gives_way() {
        let muscle = muscle(0.0);
        for (travel, p) in [(0.0, 3e5), (0.02, 4e5), (-5e-3, 1e5), (0.08, 2e5)] {
            let x = muscle.through(1.0 / 4e3, travel, p);
            let off = x - travel - muscle.at(x, p).pull / 4e3;
            assert!(off.abs() < 1e-12, "{travel} {p}: {off}");
        }
    }
}
