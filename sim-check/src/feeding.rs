//! The gas of legs that are fed from a tank, over a stretch of time in which they move along
//! parabolas.

use saltus_pneumatics::{Feed, FeedRates, Held, MEGA, Place};

use crate::gas::Path;
use crate::machine::Layout;

/// The gas in the chamber of leg `leg`.
pub(crate) fn gas_of(layout: Layout, feed: &Feed<f64>, leg: usize, y: &[f64]) -> Held<f64> {
    Held {
        pressure: y[layout.gas() + leg] * MEGA,
        mass: y[layout.masses() + leg] * feed.mass_units()[0],
    }
}

/// Puts gas into the chamber of leg `leg`.
pub(crate) fn put_gas(
    layout: Layout,
    feed: &Feed<f64>,
    leg: usize,
    held: Held<f64>,
    y: &mut [f64],
) {
    y[layout.gas() + leg] = held.pressure / MEGA;
    y[layout.masses() + leg] = held.mass / feed.mass_units()[0];
}

/// The gas in the tank.
pub(crate) fn tank_of(layout: Layout, feed: &Feed<f64>, y: &[f64]) -> Held<f64> {
    let at = layout.tank();
    Held {
        pressure: y[at] * MEGA,
        mass: y[at + 1] * feed.mass_units()[1],
    }
}

/// Puts gas into the tank.
pub(crate) fn put_tank(layout: Layout, feed: &Feed<f64>, tank: Held<f64>, y: &mut [f64]) {
    let at = layout.tank();
    y[at] = tank.pressure / MEGA;
    y[at + 1] = tank.mass / feed.mass_units()[1];
}

/// A fed leg in a stretch of time.
pub(crate) struct Line<'a> {
    pub feed: &'a Feed<f64>,
    pub held: Held<f64>,
    pub path: Path,
    /// How far its valve is open after a time (s).
    pub opening: &'a dyn Fn(f64) -> f64,
    pub port_open: bool,
    /// So far: gas from the tank and to the atmosphere (kg), and the work of the gas (J).
    pub moved: [f64; 3],
}

/// Longest sub-step (s).
const LONGEST: f64 = 1e-4;
/// Part of a pressure by which its rate is differentiated: below what rounds off the orifice law.
const SMALL: f64 = 1e-7;
/// A sub-step that is longer than this part of the time in which a pressure levels out is taken
/// implicitly.
const STIFF: f64 = 0.5;

/// The lines and their tank after `h` (s): sub-steps of the midpoint rule, and of implicit Euler where a
/// pressure levels out within one. No mass is lost in any of them.
pub(crate) fn advance(lines: &mut [Line<'_>], tank: &mut Held<f64>, h: f64) {
    let Some(feed) = lines.first().map(|line| line.feed) else {
        return;
    };
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "few"
    )]
    let steps = (h / LONGEST).ceil().max(1.0) as usize;
    let tau = h / steps as f64;
    for k in 0..steps {
        let t = k as f64 * tau;
        let first: Vec<FeedRates<f64>> = lines
            .iter()
            .map(|line| line.rates(*tank, line.held, t))
            .collect();
        let middle = feed.tank_after(*tank, drawn(&first), 0.5 * tau);
        let second: Vec<FeedRates<f64>> = lines
            .iter_mut()
            .zip(&first)
            .map(|(line, first)| line.step(middle, first, t, tau))
            .collect();
        *tank = feed.tank_after(*tank, drawn(&second), tau);
        for (line, rates) in lines.iter_mut().zip(&second) {
            let rates = [rates.drawn[0], rates.vented[0], rates.work];
            for (moved, rate) in line.moved.iter_mut().zip(rates) {
                *moved += tau * rate;
            }
        }
    }
}

/// Mass (kg/s) and enthalpy (W) that lines draw together.
fn drawn(rates: &[FeedRates<f64>]) -> [f64; 2] {
    rates.iter().fold([0.0; 2], |[mass, heat], rates| {
        [mass + rates.drawn[0], heat + rates.drawn[1]]
    })
}

impl Line<'_> {
    fn rates(&self, tank: Held<f64>, held: Held<f64>, t: f64) -> FeedRates<f64> {
        let path = self.path.from(t);
        let place = Place {
            extension: path.extension,
            speed: path.speed,
            opening: (self.opening)(t),
            port_open: self.port_open,
        };
        self.feed.rates(tank, held, &place)
    }

    /// Goes on from `t` by `tau` (s), where `first` are its rates; the rates that it goes by.
    fn step(
        &mut self,
        tank: Held<f64>,
        first: &FeedRates<f64>,
        t: f64,
        tau: f64,
    ) -> FeedRates<f64> {
        let held = self.held;
        let near = Held {
            pressure: held.pressure * (1.0 + SMALL),
            ..held
        };
        let change = self.rates(tank, near, t).held.pressure - first.held.pressure;
        let levelling = -change / (SMALL * held.pressure);
        if levelling * tau > STIFF {
            return self.implicit(tank, t, tau);
        }
        let middle = Held {
            pressure: held.pressure + 0.5 * tau * first.held.pressure,
            mass: held.mass + 0.5 * tau * first.held.mass,
        };
        let rates = self.rates(tank, middle, t + 0.5 * tau);
        self.held.pressure += tau * rates.held.pressure;
        self.held.mass += tau * rates.held.mass;
        rates
    }

    /// An implicit Euler step for the pressure.
    fn implicit(&mut self, tank: Held<f64>, t: f64, tau: f64) -> FeedRates<f64> {
        /// Secants, each ten times nearer.
        const ROUNDS: usize = 60;
        let (start, mass) = (self.held.pressure, self.held.mass);
        let rates = |line: &Self, pressure: f64| line.rates(tank, Held { pressure, mass }, t + tau);
        let left = |line: &Self, p: f64| p - start - tau * rates(line, p).held.pressure;
        // Between vacuum and what no source exceeds.
        let (mut low, mut high) = (1e-3 * start, 4.0 * start.max(tank.pressure));
        let (mut last, mut at) = (start, start * (1.0 + SMALL));
        let mut before = left(self, last);
        for _ in 0..ROUNDS {
            let here = left(self, at);
            if here < 0.0 {
                low = at;
            } else {
                high = at;
            }
            let mut next = at - here * (at - last) / (here - before);
            if !(low..=high).contains(&next) {
                next = low.midpoint(high);
            }
            if (next - at).abs() <= 1e-13 * start {
                break;
            }
            (last, before, at) = (at, here, next);
        }
        let rates = rates(self, at);
        self.held.pressure = at;
        self.held.mass += tau * rates.held.mass;
        rates
    }
}
