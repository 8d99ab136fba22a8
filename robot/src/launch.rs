//! What a jump is given, and how its stance ends: the seam between a robot and what makes it jump.

use saltus_numeric::{Dual, Scalar};

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

    /// The same with rate, firing angle and valve opening time as the directions 0, 1 and 2 of its
    /// derivatives; a stance that starts at its firing angle keeps doing so when that angle changes.
    pub fn variables<const N: usize>(&self) -> Launch<Dual<N>> {
        let firing_angle = Dual::variable(self.firing_angle, 1);
        let starts_at_firing = self.lean == self.firing_angle;
        Launch {
            rate: Dual::variable(self.rate, 0),
            lean: if starts_at_firing {
                firing_angle
            } else {
                Dual::of(self.lean)
            },
            firing_angle,
            valve_open: Dual::variable(self.valve_open, 2),
        }
    }
}

/// How a stance ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Outcome {
    /// Lift-off at the end of the stroke.
    Stroke,
    /// Lift-off because the leg's force fell to 0.
    Force,
    /// The robot came to rest before it reached the firing angle.
    Stall,
    /// The valve closed (or the robot fell over) before the leg could move.
    NoBreakAway,
    /// The ground would have had to pull while the leg was still held: the robot came too fast.
    EarlyLiftOff,
    /// The leg extended, came to a halt and sank back.
    FallBack,
}

impl Outcome {
    /// Its name in files: `stroke`, `force`, `stall`, `no-break-away`, `early-lift-off`,
    /// `fall-back`.
    pub fn name(self) -> &'static str {
        match self {
            Outcome::Stroke => "stroke",
            Outcome::Force => "force",
            Outcome::Stall => "stall",
            Outcome::NoBreakAway => "no-break-away",
            Outcome::EarlyLiftOff => "early-lift-off",
            Outcome::FallBack => "fall-back",
        }
    }

    /// A wheel at or below the ground, whose leg leans by a right angle, has not lifted off,
    /// whatever its leg did; `lean` in rad.
    #[must_use]
    pub fn unless_fallen(self, lean: f64) -> Outcome {
        if lean.abs() < std::f64::consts::FRAC_PI_2 {
            self
        } else {
            Outcome::FallBack
        }
    }

    /// Whether the robot flies.
    pub fn is_jump(self) -> bool {
        matches!(self, Outcome::Stroke | Outcome::Force)
    }
}

/// The end of a stance. Only where [`Outcome::is_jump`] holds is it a lift-off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiftOff<S = f64> {
    /// How the stance ended.
    pub outcome: Outcome,
    /// When the leg was fired (s from the start); NaN where it was not.
    pub time_fire: S,
    /// When the stance ended (s from the start).
    pub time: S,
    /// Lean φ (rad).
    pub lean: S,
    /// Lean rate ω (rad/s).
    pub rate: S,
    /// Extension d (m).
    pub extension: S,
    /// Extension rate ḋ (m/s).
    pub extension_rate: S,
    /// Chamber pressure (Pa, absolute); the ambient one for a leg without a chamber.
    pub pressure: S,
    /// Where the wheel's centre is (m): forwards of the foot, and above it.
    pub axle: [S; 2],
    /// Its velocity (m/s) as it flies off, after the foot was picked up: forwards and upwards.
    pub axle_rates: [S; 2],
}
