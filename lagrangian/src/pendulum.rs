//! Closed forms while the leg is held: the robot is then a pendulum upside down on its foot.

use std::f64::consts::FRAC_PI_2;

use saltus_numeric::{Lanes, Scalar, Single};

/// The inverted pendulum that a robot with a held leg is: φ̈ = c sin φ.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pendulum<S> {
    /// c = m g r_s/(I + m r_s²) (1/s²).
    pub stiffness: S,
    /// m r_s²/(I + m r_s²).
    share: S,
    /// g (m/s²).
    gravity: S,
    /// r_s (m).
    radius: S,
}

/// Terms of the Taylor series in time: at the usual 11 ms from firing to break-away the last is
/// below 1e-17.
const TERMS: usize = 13;

/// Nodes (on [0, 1]) and weights of the Gauss–Legendre rule of 16 points, first half; the rule is
/// symmetric.
const GAUSS: [(f64, f64); 8] = [
    (0.005299532504175033, 0.013576229705877048),
    (0.02771248846338371, 0.031126761969323947),
    (0.06718439880608412, 0.04757925584124639),
    (0.12229779582249849, 0.06231448562776694),
    (0.19106187779867811, 0.07479799440828837),
    (0.2709916111713863, 0.08457825969750127),
    (0.35919822461037054, 0.09130170752246179),
    (0.4524937450811813, 0.09472530522753425),
];

impl<S: Scalar> Pendulum<S> {
    pub(crate) fn new(mass: S, inertia: S, radius: S, gravity: S) -> Pendulum<S> {
        let moment = mass * radius * radius;
        let about_foot = inertia + moment;
        Pendulum {
            stiffness: mass * gravity * radius / about_foot,
            share: moment / about_foot,
            gravity,
            radius,
        }
    }

    /// ω² + 2 c cos φ (1/s²), which stays constant.
    #[inline(always)]
    pub(crate) fn invariant(&self, lean: S, rate: S) -> S {
        let (_, cos) = lean.sin_cos();
        rate * rate + S::of(2.0) * self.stiffness * cos
    }

    /// ω² (1/s²) at `lean`; negative where the robot never comes.
    #[inline(always)]
    pub(crate) fn rate_squared(&self, invariant: S, lean: S) -> S {
        let (_, cos) = lean.sin_cos();
        invariant - S::of(2.0) * self.stiffness * cos
    }

    /// Time (s) from lean `from` to `to`, forwards and without coming to rest, by one
    /// Gauss–Legendre panel.
    #[inline(always)]
    pub(crate) fn panel_time(&self, invariant: S, from: S, to: S) -> S {
        let length = to - from;
        let mut sum = S::of(0.0);
        for (x, w) in GAUSS {
            for x in [x, 1.0 - x] {
                let rate = self
                    .rate_squared(invariant, length.mul_add(S::of(x), from))
                    .sqrt();
                sum = sum + S::of(w) / rate;
            }
        }
        sum * length
    }

    /// The motion from (`lean`, `rate`) as a power series in time.
    #[inline(always)]
    pub(crate) fn series(&self, lean: S, rate: S) -> Series<S> {
        let zero = S::of(0.0);
        let (mut a, mut s, mut c) = ([zero; TERMS], [zero; TERMS], [zero; TERMS]);
        (a[0], a[1]) = (lean, rate);
        (s[0], c[0]) = lean.sin_cos();
        for n in 1..TERMS {
            if n >= 2 {
                a[n] = self.stiffness * s[n - 2] * S::of(1.0 / ((n * (n - 1)) as f64));
            }
            // (sin φ)' = φ' cos φ and (cos φ)' = −φ' sin φ, power by power.
            let (mut x, mut y) = (zero, zero);
            for j in 1..=n {
                let slope = a[j] * S::of(j as f64);
                x = slope.mul_add(c[n - j], x);
                y = slope.mul_add(s[n - j], y);
            }
            s[n] = x * S::of(1.0 / n as f64);
            c[n] = y * S::of(-1.0 / n as f64);
        }
        Series { lean: a, cos: c }
    }
}

impl Pendulum<Lanes> {
    /// Where the ground never has to pull between the leans `low` and `high`: see
    /// [`Pendulum::lift_off_lean`].
    #[inline(always)]
    pub(crate) fn keeps_ground(&self, invariant: Lanes, low: Lanes, high: Lanes) -> Lanes {
        let of = Lanes::of;
        let (a, b, c) = (
            of(3.0) * self.gravity * self.share,
            self.radius * invariant,
            self.gravity * (of(1.0) - self.share),
        );
        let normal = |x: Lanes| c + x * (a * x - b);
        let zero = of(0.0);
        let (x, y) = (low.sin_cos().1, high.sin_cos().1);
        let around_top = low.lt(zero) & high.gt(zero);
        let most = around_top.choose(of(1.0), x.max(y));
        let least = x.min(y);
        // The quadratic is least at b/2a, or at the end nearest to it.
        let worst = (b / (of(2.0) * a)).max(least).min(most);
        normal(worst).gt(zero)
    }
}

impl<S: Single> Pendulum<S> {
    /// Time (s) from lean `from` to `to` > `from`, or none where the closed form does not reach:
    /// the robot comes to rest there, or has too little speed to pass the top.
    pub(crate) fn time(&self, invariant: S, from: S, to: S) -> Option<S> {
        // ω² = W + 2c(1 − cos φ) vanishes at φ = ±i b: panels must stay clear of these points.
        let at_top = (invariant - S::of(2.0) * self.stiffness).value();
        if at_top <= 0.0 {
            return None;
        }
        let clear = (1.0 + at_top / (2.0 * self.stiffness.value())).acosh();
        let mut total = S::of(0.0);
        let mut left = from;
        while left.value() < to.value() {
            let mut right = to;
            while {
                let (a, b) = (left.value(), right.value());
                let nearest = if a * b <= 0.0 {
                    0.0
                } else {
                    a.abs().min(b.abs())
                };
                // A ratio of 1.6 leaves an error of 3.5^−32.
                0.5 * (b - a) * 1.6 > nearest.hypot(clear)
            } {
                right = (left + right) * S::of(0.5);
            }
            total = total + self.panel_time(invariant, left, right);
            left = right;
        }
        Some(total)
    }

    /// The first lean (rad) at or after `lean` at which the ground would have to pull, the leg
    /// being held: none if it never does.
    ///
    /// With x = cos φ, E the invariant and k = m r_s²/(I + m r_s²), the normal force over the mass
    /// is g(1 − k) − r_s E x + 3 g k x².
    pub(crate) fn lift_off_lean(&self, invariant: S, lean: S) -> Option<f64> {
        let (g, k) = (self.gravity.value(), self.share.value());
        let (a, b, c) = (
            3.0 * g * k,
            self.radius.value() * invariant.value(),
            g * (1.0 - k),
        );
        let lean = lean.value();
        let normal = |x: f64| c + x * (a * x - b);
        if normal(lean.cos()) < 0.0 {
            return Some(lean);
        }
        let discriminant = b * b - 4.0 * a * c;
        if a <= 0.0 || discriminant <= 0.0 {
            return None;
        }
        // The normal force is negative between these two.
        let high = (b + discriminant.sqrt()) / (2.0 * a);
        let low = c / (a * high);
        let candidates = [(low, -1.0), (high, 1.0)];
        candidates
            .into_iter()
            .filter(|(x, _)| (0.0..=1.0).contains(x))
            .map(|(x, side)| side * x.acos())
            .find(|phi| *phi >= lean && *phi < FRAC_PI_2)
    }
}

/// A motion as a power series in time.
pub(crate) struct Series<S> {
    lean: [S; TERMS],
    cos: [S; TERMS],
}

impl<S: Scalar> Series<S> {
    /// Lean (rad), rate (rad/s) and cosine of the lean at time `t` (s).
    #[inline(always)]
    pub(crate) fn at(&self, t: S) -> (S, S, S) {
        let last = TERMS - 1;
        let (mut lean, mut cos) = (self.lean[last], self.cos[last]);
        let mut rate = self.lean[last] * S::of(last as f64);
        for n in (0..last).rev() {
            lean = lean.mul_add(t, self.lean[n]);
            cos = cos.mul_add(t, self.cos[n]);
            if n > 0 {
                rate = rate.mul_add(t, self.lean[n] * S::of(n as f64));
            }
        }
        (lean, rate, cos)
    }

    /// Size of the last term at time `t` (s): what the series leaves out is about as much.
    #[inline(always)]
    pub(crate) fn tail(&self, t: S) -> S {
        let mut power = S::of(1.0);
        for _ in 1..TERMS {
            power = power * t;
        }
        (self.lean[TERMS - 1].abs().max(self.cos[TERMS - 1].abs())) * power.abs()
    }
}
