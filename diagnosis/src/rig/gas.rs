//! The gas behind the leg. Behind a held leg it is integrated apart, because it may be stiff.

use saltus_numeric::dop853;
use saltus_numeric::root::bisect;
use saltus_pneumatics::{Feed, GasState, Piece, Place};

use super::Extra;
use super::fed::{self, Command, Flowing, Gas};
use super::machine::LEG;
use super::run::{Run, Slide, State};

/// Error allowed in a step of the gas behind a held leg, of its variable, which is of order 1.
const GAS: f64 = 1e-10;
/// Distance from balance, relative to the gas, below which inflow and outflow count as balanced.
const BALANCE: f64 = 1e-9;
/// Most steps of the gas within one step of the motion: with more it counts as stuck.
const MOST: usize = 10_000;

impl Run<'_> {
    /// Selects the piece of the gas law at the present pressure, or just above (`side` > 0) or
    /// below (`side` < 0) it.
    pub(super) fn renew(&mut self, side: f64) {
        self.mode.fed = false;
        if let (Some(chamber), Some(piece)) = (self.rig.leg.chamber(), &self.mode.piece) {
            let pressure = chamber.pressure(piece.flow, self.state.gas[0]);
            let piece = Piece::new(
                chamber,
                self.mode.switches.energized,
                pressure,
                side,
                self.mode.port_open,
            );
            self.state.gas[0] = chamber.variable(piece.flow, pressure);
            self.mode.piece = Some(piece);
        }
    }

    /// The gas; none without a chamber.
    pub(super) fn gas(&self, s: &State) -> Option<Flowing> {
        let speed = if matches!(self.mode.leg, Slide::Moves(_)) {
            s.v[LEG]
        } else {
            0.0
        };
        if let Some(feed) = &self.rig.leg.feed {
            let place = self.place(feed, s.time, (s.q[LEG], speed));
            return Some(fed::flowing(feed, &s.gas, &place));
        }
        let (gas, rate) = self.gas_at(s.time, s.gas[0], s.q[LEG], speed)?;
        Some(Flowing {
            pressure: (gas.pressure, rate * gas.pressure_per_variable),
            rate: Gas::new(rate, 0.0, 0.0, 0.0),
        })
    }

    /// What the valve of a leg that is fed is asked for.
    pub(super) fn command(&self) -> Command {
        Command {
            is_open: self.mode.switches.energized,
            since: self.mode.opens,
            from: self.mode.opening,
        }
    }

    /// How the leg stands at `time` (s), for its gas, at an extension (m) and a speed (m/s).
    fn place(&self, feed: &Feed<f64>, time: f64, leg: (f64, f64)) -> Place<f64> {
        Place {
            extension: leg.0,
            speed: leg.1,
            opening: self.command().opening(feed, time),
            port_open: self.mode.port_open,
        }
    }

    /// The gas of a plain chamber and the rate of its variable `u`, where the leg at `d` (m) extends
    /// at `speed` (m/s).
    fn gas_at(&self, time: f64, u: f64, d: f64, speed: f64) -> Option<(GasState<f64>, f64)> {
        let (chamber, piece) = (self.rig.leg.chamber()?, self.mode.piece.as_ref()?);
        let (gas, mut rate) = piece.gas(chamber, u, d, speed);
        if self.mode.fed {
            return Some((gas, 0.0));
        }
        let Extra {
            leak_along,
            opening,
            ..
        } = self.rig.extra;
        let open = (time - self.mode.opens) / opening;
        if self.mode.switches.energized && open < 1.0 {
            // What flows through the valve, and not what the leg's motion does.
            rate -= (1.0 - open.max(0.0)) * piece.gas(chamber, u, d, 0.0).0.rate;
        }
        if leak_along != 0.0 {
            let conductance = leak_along * d * self.rig.per_root;
            let lost = conductance * chamber.law.flow(gas.pressure, chamber.ambient);
            rate -= chamber.pressure_per_mass() * gas.inverses.1 * lost / gas.pressure_per_variable;
        }
        Some((gas, rate))
    }

    /// The gas behind a held leg after `h` (s).
    pub(super) fn held_gas(&self, h: f64) -> Option<Gas> {
        match &self.rig.leg.feed {
            Some(feed) => {
                let State { time, gas, q, .. } = self.state;
                let place = self.place(feed, time, (q[LEG], 0.0));
                fed::held(feed, gas, place, &self.command(), (time, h))
            }
            None => Some(Gas::new(self.held_variable(h)?, 0.0, 0.0, 0.0)),
        }
    }

    /// The variable of a plain chamber, by DOP853 with error control. Where inflow and outflow
    /// balance, it stays.
    fn held_variable(&self, h: f64) -> Option<f64> {
        let State { time, gas, .. } = self.state;
        let mut u = gas[0];
        if self.mode.piece.is_none() {
            return Some(u);
        }
        let d = self.state.q[LEG];
        let rate = |u: f64, t: f64| {
            let gas = self.gas_at(time + t, u, d, 0.0);
            gas.map_or(f64::NAN, |(_, rate)| rate)
        };
        let slopes = |y: &[f64; 2]| [rate(y[0], y[1]), 1.0];
        let (mut t, mut tau) = (0.0, h);
        for _ in 0..MOST {
            let left = h - t;
            let slope = rate(u, t);
            if left <= 0.0 || slope == 0.0 {
                return Some(u);
            }
            if !slope.is_finite() {
                return None;
            }
            // A valve that still opens moves the balance.
            let beyond = u + BALANCE * u.copysign(slope);
            if rate(beyond, h) * slope <= 0.0 && self.is_open(time + t) {
                return Some(bisect(u, beyond, 40, |u| rate(u, h) * slope > 0.0).0);
            }
            tau = tau.min(left);
            let step = dop853::step(&slopes, &[u, t], &[slope, 1.0], tau, 1, GAS);
            if step.error <= 1.0 {
                u = step.state[0];
                t = if tau < left { t + tau } else { h };
            }
            tau *= dop853::step_factor(step.error);
        }
        None
    }

    /// Whether the rod rests on the bench, where nothing moves but the gas.
    pub(super) fn rests(&self) -> bool {
        self.rig.machine.is_bench() && self.mode.leg == Slide::Held
    }

    /// Whether the valve is not in the middle of opening.
    pub(super) fn is_open(&self, time: f64) -> bool {
        !self.mode.switches.energized || time >= self.mode.opens + self.rig.extra.opening
    }

    /// Error of the cubic from here to `next` in its middle, relative to the pressure.
    pub(super) fn bend(&self, next: &State) -> Option<f64> {
        let h = next.time - self.state.time;
        let of = |s: &State| self.gas(s).map(|gas| gas.pressure);
        let Some((a, b)) = of(&self.state).zip(of(next)) else {
            return Some(0.0);
        };
        let middle = State {
            time: self.state.time + 0.5 * h,
            gas: self.held_gas(0.5 * h)?,
            ..self.state
        };
        let there = of(&middle)?.0;
        let cubic = 0.5 * (a.0 + b.0) + 0.125 * h * (a.1 - b.1);
        Some((cubic - there).abs() / there)
    }
}
