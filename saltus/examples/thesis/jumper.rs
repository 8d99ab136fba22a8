//! The robots and requests that the sections share.

use saltus::planner::{FIRING_ANGLES, Jump, Law, Measure, Roots, TableRequest};
use saltus::{Launch, Planner, resolve};

use crate::{Outcome, VALVE_OPEN};

/// Length (m) of the boom, table 4.1.
pub(crate) const BOOM_LENGTH: f64 = 2.12;
/// The boom, table 4.1, as a robot file has it.
pub(crate) const BOOM: [&str; 3] = [
    "boom.mass_kg=0.5",
    "boom.length_m=2.12",
    "boom.radius_m=0.015",
];

/// A planner for `rats-planar` with these overrides.
pub(crate) fn planner(overrides: &[&str]) -> Outcome<Planner> {
    let overrides: Vec<String> = overrides.iter().map(|text| (*text).to_owned()).collect();
    Ok(Planner::new(resolve("rats-planar", &overrides)?))
}

/// One way to understand "a jump of a distance".
#[derive(Clone, Copy)]
pub(crate) struct Reading {
    /// Lean (rad) at which the stance starts; none: at the firing angle.
    pub(crate) start_lean: Option<f64>,
    /// Height (m) of the wheel's centre at the landing.
    pub(crate) landing_height: f64,
}

impl Reading {
    /// The stance starts at the firing angle, the jump ends at y = 0.
    pub(crate) const PLAIN: Reading = Reading {
        start_lean: None,
        landing_height: 0.0,
    };

    pub(crate) fn launch(self, rate: f64, firing_angle: f64) -> Launch {
        Launch {
            rate,
            lean: self.start_lean.unwrap_or(firing_angle),
            firing_angle,
            valve_open: VALVE_OPEN,
        }
    }

    pub(crate) fn request(self, rates: &[f64], distance: f64, roots: Roots) -> TableRequest {
        TableRequest {
            rates: rates.to_vec(),
            measure: Measure::Distance {
                landing_height: self.landing_height,
            },
            targets: vec![distance],
            valve_open: VALVE_OPEN,
            start_lean: self.start_lean,
            // A leg cannot fire before it stands.
            firing_angles: (self.start_lean.unwrap_or(FIRING_ANGLES.0), FIRING_ANGLES.1),
            roots,
            sensitivities: false,
            threads: 1,
        }
    }

    /// The law for `distance` (m); none where fewer than two of the rates reach it.
    pub(crate) fn law(
        self,
        planner: &Planner,
        rates: &[f64],
        distance: f64,
    ) -> Outcome<Option<Law>> {
        let laws = planner.laws(&self.request(rates, distance, Roots::Least))?;
        Ok(laws.into_iter().next().flatten())
    }

    /// The greatest distance (m) that any of the rates reaches.
    pub(crate) fn farthest(self, planner: &Planner, rates: &[f64]) -> Outcome<f64> {
        // It is the nearest to a distance that nobody reaches.
        let table = planner.table(&self.request(rates, 100.0, Roots::Least))?;
        let all = table
            .cells
            .iter()
            .filter_map(|cell| cell.nearest)
            .map(|nearest| nearest.value);
        Ok(all.fold(f64::NEG_INFINITY, f64::max))
    }
}

/// Stance (from the firing on) and flight (down to `height`) of a jump as points.
pub(crate) fn path(planner: &Planner, jump: &Jump, height: f64) -> Outcome<[Vec<(f64, f64)>; 2]> {
    let trace = planner.stance().trace(&jump.launch)?;
    let radius = planner.robot().body.radius;
    let stance = trace.samples.iter().map(|s| {
        let reach = radius + s.extension;
        (reach * s.lean.sin(), reach * s.lean.cos())
    });
    let flight = jump.exact_flight().ok_or("a jump without a flight")?;
    let points = flight
        .samples(0.0, flight.time_to_height(height)?, 121)
        .map(|(_, x, y)| (x, y));
    Ok([stance.collect(), points.collect()])
}

/// `count` numbers from `low` to `high`.
pub(crate) fn range(low: f64, high: f64, count: u32) -> Vec<f64> {
    let last = f64::from(count - 1);
    (0..count)
        .map(|i| low + (high - low) * f64::from(i) / last)
        .collect()
}
