//! The smooth piece of its laws that a chamber is on, and where it ends.

use saltus_numeric::Single;

use crate::{Chamber, Flow, GasState, Valve};

/// The valve's law between two switches, with everything else that fills or empties the chamber.
#[derive(Clone, Copy, Debug)]
pub struct Piece<S: Single> {
    /// Which piece of the orifice law it is.
    pub flow: Flow,
    /// The valve on that piece.
    pub valve: Valve<S>,
    /// u at which the law switches with the pressure falling.
    pub low: S,
    /// u at which the law switches with the pressure rising.
    pub high: S,
    /// 1 where u rises with the pressure, −1 where it falls.
    pub sign: S,
    port_open: bool,
    extras: bool,
}

/// Speed (m/s) of a leg up to which the gas of an exhausted chamber follows it.
const FOLLOWED: f64 = 0.05;

impl<S: Single> Piece<S> {
    /// The piece at pressure `p` (Pa), or just above or below it where `side` is ±1.
    pub fn new(
        chamber: &Chamber<S>,
        energized: bool,
        p: S,
        side: f64,
        port_open: bool,
    ) -> Piece<S> {
        let nudged = p * S::of(1.0 + 1e-9 * side);
        let flow = chamber.flow(energized, nudged);
        let extras = chamber.has_extras();
        let (low, high) = if extras {
            edges_with_extras(chamber, energized, flow, nudged)
        } else {
            chamber.edges(flow)
        };
        Piece {
            flow,
            valve: chamber.valve(flow),
            low,
            high,
            sign: S::of(if flow == Flow::ExhaustSubsonic {
                -1.0
            } else {
                1.0
            }),
            port_open,
            extras,
        }
    }

    /// How far the pressure is past the upper and the lower edge, in u.
    #[inline(always)]
    pub fn guards(&self, u: S) -> (S, S) {
        (self.sign * (u - self.high), self.sign * (self.low - u))
    }

    /// The gas at `u` in the chamber of a retracted leg.
    pub fn gas_at_rest(&self, chamber: &Chamber<S>, u: S) -> GasState<S> {
        let zero = S::of(0.0);
        chamber.gas(&self.valve, u, zero, zero, S::of(1.0))
    }

    /// The gas at `u` in the chamber of a leg at extension `d` (m) that extends at `speed` (m/s),
    /// and u̇ with every term.
    ///
    /// In an exhausted chamber the gas follows a slow leg at ambient pressure: what it would take
    /// to drive it through the valve is below 50 Pa, and the orifice law, infinitely stiff there,
    /// would switch at every step.
    pub fn gas(&self, chamber: &Chamber<S>, u: S, d: S, speed: S) -> (GasState<S>, S) {
        let gas = chamber.gas(&self.valve, u, d, speed, S::of(1.0));
        if self.flow == Flow::ExhaustBalanced && speed.value().abs() < FOLLOWED {
            return (gas, S::of(0.0));
        }
        (gas, self.rate(chamber, &gas))
    }

    /// Mass flows (kg/s) at `u` in the chamber of a leg at extension `d` (m) that extends at `speed`
    /// (m/s): from the supply, and to the surroundings, from which gas may also come back.
    ///
    /// Their difference is what the chamber's equation takes for its inflow: n R T ṁ = V Ṗ + n P V̇.
    pub fn mass_flows(&self, chamber: &Chamber<S>, u: S, d: S, speed: S) -> [S; 2] {
        let (gas, rate) = self.gas(chamber, u, d, speed);
        let per_mass = chamber.pressure_per_mass();
        let of_rate = |rate: S| {
            let volume = chamber.volume(d);
            let growth = chamber.exponent() * gas.pressure * chamber.area * speed;
            (rate * gas.pressure_per_variable * volume + growth) / per_mass
        };
        let net = of_rate(rate);
        let supplied = match self.flow {
            Flow::FillChoked | Flow::FillSubsonic | Flow::FillBalanced => {
                of_rate(gas.rate) + chamber.drooping_inflow(self.flow, gas.pressure)
            }
            _ => S::of(0.0),
        };
        [supplied, supplied - net]
    }

    /// u̇ with the terms that the valve's plain law leaves out.
    #[inline(always)]
    pub fn rate(&self, chamber: &Chamber<S>, gas: &GasState<S>) -> S {
        if !self.extras {
            return gas.rate;
        }
        let inflow = chamber.extra_inflow(self.flow, gas.pressure, self.port_open);
        let change = chamber.pressure_per_mass() * gas.inverses.1 * inflow;
        gas.rate + change / gas.pressure_per_variable
    }
}

/// The edges (in u) around pressure `p` (Pa) of a chamber that also leaks: those of the valve, and
/// of the leak's own flow.
fn edges_with_extras<S: Single>(chamber: &Chamber<S>, energized: bool, flow: Flow, p: S) -> (S, S) {
    let exhaust = chamber.exhaust_edge();
    let edges = if energized {
        [chamber.fill_edge(), chamber.balance_above(), exhaust]
    } else {
        [chamber.balance_below(), exhaust, exhaust]
    };
    let (mut low, mut high) = (S::of(1.0), S::of(1e12));
    for edge in edges {
        if edge.value() < p.value() && edge.value() > low.value() {
            low = edge;
        }
        if edge.value() >= p.value() && edge.value() < high.value() {
            high = edge;
        }
    }
    (chamber.variable(flow, low), chamber.variable(flow, high))
}
