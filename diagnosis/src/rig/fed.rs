//! The gas behind a leg that is fed from a tank, through a tube, or by a valve that moves in time.
//!
//! Chamber with tube, and tank, hold a pressure and a mass each: docs/model.md, "Gas from a tank".
//! Here pressures are in megapascals, and masses in units that make them about as large.

use nalgebra::Vector4;
use saltus_numeric::dop853;
use saltus_pneumatics::{Feed, Held, MEGA, Place};

/// The gas behind a leg: pressure and mass in the chamber with its tube, and in the tank. Of a leg
/// that is not fed the first number is the variable of its piece of the gas law.
pub(super) type Gas = Vector4<f64>;

/// The gas behind a leg at an instant.
pub(super) struct Flowing {
    /// Pressure (Pa) in the chamber, and its rate.
    pub(super) pressure: (f64, f64),
    /// Rate of the gas.
    pub(super) rate: Gas,
}

/// Error allowed in a step of the gas behind a held leg, of numbers of order 1.
const ERROR: f64 = 1e-8;
/// Part of the gas that may still flow until the end of a step where it counts as at rest.
const REST: f64 = 1e-9;
/// Distance of the valve's opening, of 1, from where it goes, within which it is there.
const SETTLED: f64 = 1e-11;
/// Most steps of the gas within one step of the motion: with more it counts as stuck.
const MOST: usize = 20_000;

/// A chamber at ambient pressure, its leg retracted, and a full tank.
pub(super) fn at_rest(feed: &Feed<f64>) -> Gas {
    let (held, tank) = (feed.at_rest(0.0), feed.full());
    let [of_chamber, of_tank] = feed.mass_units();
    Gas::new(
        held.pressure / MEGA,
        held.mass / of_chamber,
        tank.pressure / MEGA,
        tank.mass / of_tank,
    )
}

/// What the valve is asked for, and since when.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Command {
    /// Whether it is to be open.
    pub(super) is_open: bool,
    /// When (s) it was asked.
    pub(super) since: f64,
    /// How far it was open then, of 1.
    pub(super) from: f64,
}

impl Command {
    /// How far the valve is open at `time` (s), of 1.
    pub(super) fn opening(&self, feed: &Feed<f64>, time: f64) -> f64 {
        let opening = feed.opening(self.from, self.is_open, time - self.since);
        if (opening - self.target()).abs() < SETTLED {
            self.target()
        } else {
            opening
        }
    }

    fn target(&self) -> f64 {
        f64::from(u8::from(self.is_open))
    }
}

/// The gas where the leg is at `place`.
pub(super) fn flowing(feed: &Feed<f64>, gas: &Gas, place: &Place<f64>) -> Flowing {
    let [of_chamber, of_tank] = feed.mass_units();
    let held = |pressure: f64, mass: f64, unit: f64| Held {
        pressure: pressure * MEGA,
        mass: mass * unit,
    };
    let tank = held(gas[2], gas[3], of_tank);
    let rates = feed.rates(tank, held(gas[0], gas[1], of_chamber), place);
    let of_the_tank = feed.tank_rates(tank, rates.drawn).0;
    Flowing {
        pressure: (gas[0] * MEGA, rates.held.pressure),
        rate: Gas::new(
            rates.held.pressure / MEGA,
            rates.held.mass / of_chamber,
            of_the_tank.pressure / MEGA,
            of_the_tank.mass / of_tank,
        ),
    }
}

/// The gas behind a leg that is held at `place`, `h` (s) after `time` (s), by DOP853 with error
/// control, until it is at rest.
pub(super) fn held(
    feed: &Feed<f64>,
    mut gas: Gas,
    place: Place<f64>,
    command: &Command,
    (time, h): (f64, f64),
) -> Option<Gas> {
    let slopes = |y: &[f64; 5]| {
        let place = Place {
            opening: command.opening(feed, time + y[4]),
            ..place
        };
        let rate = flowing(feed, &Gas::new(y[0], y[1], y[2], y[3]), &place).rate;
        [rate[0], rate[1], rate[2], rate[3], 1.0]
    };
    let (mut t, mut tau) = (0.0, h);
    for _ in 0..MOST {
        let left = h - t;
        let y = [gas[0], gas[1], gas[2], gas[3], t];
        let slope = slopes(&y);
        if !slope.iter().all(|x| x.is_finite()) {
            return None;
        }
        let is_settled = command.opening(feed, time + t) == command.target();
        // A tank that is shut off does nothing to the leg.
        let counts = if command.is_open { 4 } else { 2 };
        let rests = |i: usize| (slope[i] * left).abs() <= REST * y[i].abs();
        if left <= 0.0 || (is_settled && (0..counts).all(rests)) {
            return Some(gas);
        }
        tau = tau.min(left);
        let step = dop853::step(&slopes, &y, &slope, tau, 4, ERROR);
        if step.error <= 1.0 {
            let [a, b, c, d, _] = step.state;
            gas = Gas::new(a, b, c, d);
            t = if tau < left { t + tau } else { h };
        }
        tau *= dop853::step_factor(step.error);
    }
    None
}
