//! What a jump is given.

/// What a jump is given: how the robot comes, and what is commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Launch<S = f64> {
    /// Lean rate at the start, ω_0 (rad/s), ≥ 0 forwards.
    pub rate: S,
    /// Lean at the start, φ_0 (rad), in (−π/2, π/2).
    pub lean: S,
    /// Firing angle α_f (rad), in (−π/2, π/2): the lean at which the leg is fired; at once where it
    /// is not past `lean`.
    pub firing_angle: S,
    /// Valve opening time t_v (s), ≥ 0.
    pub valve_open: S,
}

impl Launch<f64> {
    /// A stance that starts at its firing angle.
    pub fn at_firing(rate: f64, firing_angle: f64, valve_open: f64) -> Launch<f64> {
        Launch {
            rate,
            lean: firing_angle,
            firing_angle,
            valve_open,
        }
    }
}
