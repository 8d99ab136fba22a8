//! From flight back to the ground: the impact of a landing leg.

use saltus_numeric::Scalar;

use crate::Stance;

/// How a robot comes down on a retracted leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TouchDown<S = f64> {
    /// Velocity (m/s) of the wheel's centre, forwards.
    pub vx: S,
    /// Velocity (m/s) of the wheel's centre, upwards.
    pub vy: S,
    /// Spin (rad/s) of the wheel, forwards.
    pub spin: S,
    /// Lean (rad) of the leg that lands.
    pub lean: S,
}

impl<S: Scalar> Stance<S> {
    /// Lean rate ω_0 (rad/s) right after a plastic impact, and the kinetic energy (J) that it
    /// takes.
    ///
    /// The foot stops dead and neither slips nor bounces, so the angular momentum about it is kept:
    /// (I + m r_s²) ω_0 = I spin + m r_s (vx cos φ − vy sin φ).
    pub fn touch_down(&self, impact: &TouchDown<S>) -> (S, S) {
        let (sin, cos) = impact.lean.sin_cos();
        let moment = self.mass * self.radius;
        let about_foot = self.inertia + moment * self.radius;
        let across = impact.vx * cos - impact.vy * sin;
        let rate = (self.inertia * impact.spin + moment * across) / about_foot;
        let half = S::of(0.5);
        let before = half * self.mass * (impact.vx * impact.vx + impact.vy * impact.vy)
            + half * self.inertia * impact.spin * impact.spin;
        (rate, before - half * about_foot * rate * rate)
    }
}
