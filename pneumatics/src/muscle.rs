//! A pneumatic muscle, which contracts under pressure.
//!
//! Its force is known as a function of contraction and pressure; its volume follows from that by
//! virtual work, as gas that expands at constant pressure does the work of the force:
//! f dx = p dV, so that V(x) = V₀ + ∫ f/p dx.
//!
//! Source: the force law is that of the jumping robot of `GTDynamics` (its `SmoothActuatorFactor`); virtual
//! work as in Chou and Hannaford, IEEE Trans. Robotics and Automation 12 (1996), p. 90.

/// A muscle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Muscle {
    /// Volume at its full length (m³), > 0.
    pub volume: f64,
    /// Force at its full length for each pascal (N/Pa), > 0.
    pub force: f64,
    /// By how much the force falls there with the contraction, for each pascal (N/(Pa m)), ≥ 0; times
    /// the free contraction it is at most 3 times `force`, or the muscle would push near its end.
    pub slope: f64,
    /// Contraction (m) at which the force is 0: coefficients of a polynomial in the pressure (Pa).
    pub reach: [f64; 5],
    /// Pressure (Pa, gauge) above which the free contraction stays as it is: polynomials fall there.
    pub most: f64,
}

/// Least pressure (Pa, gauge) that the volume is computed at: it hardly depends on it there.
const LEAST: f64 = 1.0;

impl Muscle {
    /// The pressure (Pa) up to which the polynomial `reach` (m) rises, to a thousandth of `most`, which
    /// it is at most.
    pub fn rising_to(reach: [f64; 5], most: f64) -> f64 {
        const POINTS: u32 = 1000;
        let at = |k: u32| most * f64::from(k) / f64::from(POINTS);
        let rises = |k: &u32| polynomial(&reach, at(*k)) > polynomial(&reach, at(k - 1));
        at((1..=POINTS).take_while(rises).last().unwrap_or(0))
    }

    /// Contraction (m) at which the force is 0, at a gauge pressure (Pa).
    pub fn free_contraction(&self, pressure: f64) -> f64 {
        polynomial(&self.reach, pressure.clamp(0.0, self.most))
    }

    /// The muscle at a gauge pressure (Pa).
    pub fn at(&self, pressure: f64) -> Inflated {
        let end = self.free_contraction(pressure.max(LEAST));
        let (a, b) = (self.force, self.slope);
        let inverse = 1.0 / end;
        Inflated {
            volume: self.volume,
            pressure: pressure.max(0.0),
            end,
            law: [
                a,
                -b,
                (2.0 * b * end - 3.0 * a) * inverse * inverse,
                (2.0 * a - b * end) * inverse * inverse * inverse,
            ],
        }
    }

    /// Pull (N) at a gauge pressure (Pa), where the joint has let the muscle come in by `travel` (m)
    /// and a spring of `compliance` (m/N) in series lets it come in further.
    pub fn pull_through(&self, compliance: f64, travel: f64, pressure: f64) -> f64 {
        self.at(pressure).pull_through(compliance, travel)
    }
}

/// A muscle at one pressure.
#[derive(Clone, Copy, Debug)]
pub struct Inflated {
    volume: f64,
    /// Gauge pressure (Pa), ≥ 0.
    pressure: f64,
    /// Contraction (m) where the pull ends.
    end: f64,
    /// Coefficients of f/p = a − b x + c x² + d x³, which is 0 with slope 0 at `end`.
    law: [f64; 4],
}

impl Inflated {
    /// Pull (N), ≥ 0, at the contraction `x` (m).
    pub fn pull(&self, x: f64) -> f64 {
        if x >= self.end {
            return 0.0;
        }
        let [a, b, c, d] = self.law;
        let each = if x < 0.0 {
            a + b * x
        } else {
            a + x * (b + x * (c + x * d))
        };
        self.pressure * each
    }

    /// How the pull changes with the contraction (N/m).
    pub fn stiffness(&self, x: f64) -> f64 {
        if x >= self.end {
            return 0.0;
        }
        let [_, b, c, d] = self.law;
        let x = x.max(0.0);
        self.pressure * (b + x * (2.0 * c + x * 3.0 * d))
    }

    /// Volume (m³) at the contraction `x` (m).
    pub fn volume(&self, x: f64) -> f64 {
        let x = x.min(self.end);
        let [a, b, c, d] = self.law;
        let grown = if x < 0.0 {
            x * (a + 0.5 * b * x)
        } else {
            x * (a + x * (b / 2.0 + x * (c / 3.0 + x * d / 4.0)))
        };
        self.volume + grown
    }

    /// Pull (N) where the joint has let the muscle come in by `travel` (m) and a spring of
    /// `compliance` (m/N) in series lets it come in further.
    pub fn pull_through(&self, compliance: f64, travel: f64) -> f64 {
        /// Each round halves the bracket, or what the equation is off by.
        const ROUNDS: usize = 100;
        let (mut low, mut high) = (0.0, self.pull(travel));
        if compliance <= 0.0 || high == 0.0 {
            return high;
        }
        // Newton's steps; a bisection where they leave the bracket, or step to and fro.
        let (mut pull, mut before) = (high, f64::INFINITY);
        for _ in 0..ROUNDS {
            let x = travel + compliance * pull;
            let left = self.pull(x) - pull;
            if left > 0.0 {
                low = pull;
            } else {
                high = pull;
            }
            let mut next = pull + left / (1.0 - compliance * self.stiffness(x));
            if left.abs() > 0.5 * before || !(low..=high).contains(&next) {
                next = 0.5 * (low + high);
            }
            let step = next - pull;
            pull = next;
            before = left.abs();
            if step.abs() < 1e-9 * (1.0 + pull) {
                break;
            }
        }
        pull
    }
}

fn polynomial(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}
