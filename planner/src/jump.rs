//! One jump, from the approach to the landing: stance and flight together.

use saltus_ballistic::{DragFlight, FlightError};
use saltus_lagrangian::{Launch, LiftOff};
use saltus_numeric::{Dual, Single};

use crate::flight::JumpFlight;

/// A jump: the end of its stance, and the flight that follows a lift-off.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump<S = f64> {
    /// What it was given.
    pub launch: Launch<S>,
    /// How the stance ended.
    pub stance: LiftOff<S>,
    /// The flight of the wheel's centre, from the foot at (0, 0); none where the robot does not
    /// lift off.
    pub flight: Option<JumpFlight<S>>,
}

impl<S: Single> Jump<S> {
    /// The flight's formula; none without a flight, or of one through samples.
    pub fn exact_flight(&self) -> Option<&DragFlight<S>> {
        match self.flight.as_ref()? {
            JumpFlight::Exact(flight) => Some(flight),
            JumpFlight::Sampled(_) => None,
        }
    }

    /// Greatest height (m) of the wheel's centre above the ground; none without a flight.
    pub fn apex(&self) -> Option<S> {
        self.flight.as_ref().map(JumpFlight::apex_height)
    }

    /// Distance (m) from the foot to where the wheel's centre comes down to `height` (m); none
    /// where it never does.
    pub fn distance(&self, height: f64) -> Option<S> {
        self.landing(height)?.ok()
    }

    /// As [`distance`](Self::distance), with the reason where there is none.
    ///
    /// # Errors
    /// As [`JumpFlight::range_to_height`]; none where there is no flight.
    pub fn landing(&self, height: f64) -> Option<Result<S, FlightError>> {
        let flight = self.flight.as_ref()?;
        Some(flight.range_to_height(S::of(height)))
    }
}

/// How a jump's result changes with what is measured and commanded.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sensitivity {
    /// The result (m).
    pub value: f64,
    /// By the approach rate ω (m s/rad).
    pub by_rate: f64,
    /// By the firing angle α_f (m/rad).
    pub by_firing_angle: f64,
    /// By the valve opening time t_v (m/s).
    pub by_valve_open: f64,
    /// By the supply pressure P_s (m/Pa).
    pub by_supply: f64,
}

impl Sensitivity {
    /// From a number with its derivatives.
    pub fn new(x: Dual<4>) -> Sensitivity {
        let [by_rate, by_firing_angle, by_valve_open, by_supply] = x.slope;
        Sensitivity {
            value: x.value,
            by_rate,
            by_firing_angle,
            by_valve_open,
            by_supply,
        }
    }

    /// What each of the `errors` changes, with the sign of its derivative, to first order.
    pub fn parts(&self, errors: &saltus_robot::Errors) -> [f64; 4] {
        [
            self.by_rate * errors.rate,
            self.by_firing_angle * errors.firing_angle,
            self.by_valve_open * errors.valve_open,
            self.by_supply * errors.supply,
        ]
    }

    /// Standard deviation of the result for independent `errors`, to first order.
    pub fn standard_deviation(&self, errors: &saltus_robot::Errors) -> f64 {
        norm(&self.parts(errors))
    }
}

/// √Σ x²
pub(crate) fn norm(parts: &[f64]) -> f64 {
    parts.iter().map(|part| part * part).sum::<f64>().sqrt()
}
