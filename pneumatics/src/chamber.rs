//! The chamber of a pneumatic leg: how its pressure changes.

use saltus_numeric::{Scalar, Single};
use saltus_robot::{Cylinder, Parameter, Robot};

use crate::orifice::OrificeLaw;

/// The chamber between the valve and the piston, with everything that fills or empties it.
///
/// Ṗ = n R T ṁ/V − n P A ḋ/V, with V = V_0 + A d and n = κ unless the exponent is given.
///
/// Source: thesis §4.3.1, MODEL "Leg force".
#[derive(Clone, Copy, Debug)]
pub struct Chamber<S> {
    /// Piston area A (m²).
    pub area: S,
    /// Volume at d = 0, V_0 (m³).
    pub dead_volume: S,
    /// Supply pressure P_s (Pa).
    pub supply: S,
    /// Ambient pressure P_a (Pa).
    pub ambient: S,
    /// The orifice law of the gas.
    pub law: OrificeLaw,
    /// Conductance of the valve C_f A_v/√T (m²/√K).
    conductance: S,
    /// Conductance of the leak (m²/√K).
    leak: S,
    /// Extension (m) from which the exhaust port is open, and its conductance (m²/√K).
    port: Option<(S, S)>,
    /// Fall of the supply pressure with the mass flow (Pa s/kg).
    droop: S,
    /// n R T (J/kg).
    heating: S,
    /// Exponent n.
    exponent: S,
}

/// What the valve does to the chamber while nothing switches: one smooth piece of the orifice law.
///
/// Carries the piece as ṁ = (`constant` + `proportional` P) w, with w = 1 where choked and w = √(z(z−1)) elsewhere,
/// where z = (P_u/P_d)^((κ−1)/κ) is carried along as a state: no power is left in the equations.
#[derive(Clone, Copy, Debug)]
pub struct Valve<S: Scalar> {
    constant: S,
    proportional: S,
    choked: S::Mask,
    /// ż = `exponent` z Ṗ/P: −(κ−1)/κ while filling, (κ−1)/κ while exhausting, 0 where z is not needed.
    exponent: S,
}

/// Which piece of the orifice law a valve is on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// Energized, sonic.
    FillChoked,
    /// Energized, subsonic.
    FillSubsonic,
    /// Energized, at the supply pressure, where nothing flows.
    FillBalanced,
    /// At rest, sonic.
    ExhaustChoked,
    /// At rest, subsonic.
    ExhaustSubsonic,
    /// At rest, at ambient pressure, where nothing flows.
    ExhaustBalanced,
}

impl<S: Scalar> Valve<S> {
    /// ż of a relative pressure change Ṗ/P (1/s).
    #[inline(always)]
    pub fn ratio_rate(&self, z: S, relative: S) -> S {
        self.exponent * z * relative
    }
}

impl Flow {
    /// Whether the valve is energized.
    pub fn is_fill(self) -> bool {
        matches!(self, Flow::FillChoked | Flow::FillSubsonic | Flow::FillBalanced)
    }
}

impl<S: Scalar> Chamber<S> {
    /// The chamber of `cylinder` in `robot`; `lift` turns a parameter into a number of the wanted kind.
    pub(crate) fn new(robot: &Robot, cylinder: &Cylinder, lift: impl Fn(Parameter, f64) -> S) -> Chamber<S> {
        let gas = cylinder.gas;
        let exponent = cylinder.polytropic_exponent.unwrap_or(gas.heat_ratio);
        let of_area = |area: f64| area / cylinder.temperature.sqrt();
        let ambient = robot.environment.ambient;
        Chamber {
            area: S::of(std::f64::consts::PI * cylinder.bore * cylinder.bore / 4.0),
            dead_volume: lift(Parameter::DeadVolume, cylinder.dead_volume),
            supply: lift(Parameter::Supply, cylinder.supply.absolute(ambient).0),
            ambient: S::of(ambient.0),
            law: OrificeLaw::new(gas),
            conductance: lift(Parameter::ValveArea, cylinder.valve_area())
                * S::of(1.0 / cylinder.temperature.sqrt()),
            leak: S::of(of_area(cylinder.leak_area)),
            port: cylinder.exhaust_port.map(|p| (S::of(p.position), S::of(of_area(p.area)))),
            droop: S::of(cylinder.supply_droop),
            heating: S::of(exponent * gas.constant * cylinder.temperature),
            exponent: S::of(exponent),
        }
    }

    /// Volume (m³) at extension `d` (m).
    #[inline(always)]
    pub fn volume(&self, d: S) -> S {
        self.area.mul_add(d, self.dead_volume)
    }

    /// Pressure change (Pa/s) with the leg held, when sonic flow fills the chamber; none of the other effects.
    pub fn sonic_filling_rate(&self) -> S {
        self.heating * self.conductance * S::of(self.law.choked) * self.supply / self.dead_volume
    }

    /// Pressure (Pa) at which filling turns from sonic to subsonic.
    #[inline(always)]
    pub fn fill_edge(&self) -> S {
        self.sonic_supply() * S::of(self.law.critical_ratio)
    }

    /// Pressure (Pa) at which exhausting turns from sonic to subsonic.
    #[inline(always)]
    pub fn exhaust_edge(&self) -> S {
        self.ambient * S::of(1.0 / self.law.critical_ratio)
    }

    /// Pressure (Pa) from which filling counts as over: just short of the supply's, which it reaches at rate 0.
    pub fn balance_above(&self) -> S {
        self.supply * S::of(1.0 - 1e-12)
    }

    /// Pressure (Pa) from which exhausting counts as over: just above ambient, which it reaches at rate 0.
    pub fn balance_below(&self) -> S {
        self.ambient * S::of(1.0 + 1e-12)
    }

    /// Supply pressure (Pa) while sonic flow draws on it.
    #[inline(always)]
    fn sonic_supply(&self) -> S {
        let drawn = self.conductance * S::of(self.law.choked) * self.droop;
        self.supply / (S::of(1.0) + drawn)
    }

    /// The extension (m) at which the exhaust port opens.
    pub fn port(&self) -> Option<S> {
        self.port.map(|(position, _)| position)
    }

    /// The coefficients of a piece of the valve's law: (constant, proportional, exponent of z).
    #[inline(always)]
    pub fn coefficients(&self, flow: Flow) -> (S, S, S) {
        let zero = S::of(0.0);
        let (choked, subsonic) =
            (self.conductance * S::of(self.law.choked), self.conductance * S::of(self.law.subsonic));
        let k = S::of(self.law.temperature_exponent);
        match flow {
            Flow::FillChoked => (choked * self.sonic_supply(), zero, zero),
            Flow::FillSubsonic => (zero, subsonic, -k),
            Flow::ExhaustChoked => (zero, -choked, zero),
            Flow::ExhaustSubsonic => (-(subsonic * self.ambient), zero, k),
            Flow::FillBalanced | Flow::ExhaustBalanced => (zero, zero, zero),
        }
    }

    /// A valve from its coefficients; `choked` where z is not needed.
    #[inline(always)]
    pub fn valve(&self, (constant, proportional, exponent): (S, S, S), choked: S::Mask) -> Valve<S> {
        Valve { constant, proportional, choked, exponent }
    }

    /// Rates of pressure `p` (Pa/s) and of z through the valve alone, while the volume `v` (m³) grows by A `speed`.
    ///
    /// `inverse` is 1/(V P), which the caller has at hand.
    #[inline(always)]
    pub fn rates(&self, valve: &Valve<S>, p: S, z: S, speed: S, inverse: S) -> (S, S) {
        let w = S::select(valve.choked, || S::of(1.0), || z.mul_add(z, -z).max(S::of(0.0)).sqrt());
        let inflow = valve.proportional.mul_add(p, valve.constant) * w;
        // V Ṗ
        let growth = self.heating * inflow - self.exponent * p * self.area * speed;
        let relative = growth * inverse;
        (relative * p, valve.ratio_rate(z, relative))
    }
}

impl<S: Single> Chamber<S> {
    /// The piece of the valve's law at pressure `p` (Pa), just after it was energized or released.
    pub fn flow(&self, energized: bool, p: S) -> Flow {
        let p = p.value();
        if energized {
            let edge = self.fill_edge().value();
            match p {
                p if p < edge => Flow::FillChoked,
                p if p < self.balance_above().value() => Flow::FillSubsonic,
                _ => Flow::FillBalanced,
            }
        } else {
            match p {
                p if p > self.exhaust_edge().value() => Flow::ExhaustChoked,
                p if p > self.balance_below().value() => Flow::ExhaustSubsonic,
                _ => Flow::ExhaustBalanced,
            }
        }
    }

    /// The valve on the piece `flow`.
    pub fn on(&self, flow: Flow) -> Valve<S> {
        self.valve(self.coefficients(flow), !matches!(flow, Flow::FillSubsonic | Flow::ExhaustSubsonic))
    }

    /// z at pressure `p` (Pa) on the piece `flow`; 1 where it is not needed.
    pub fn temperature_ratio(&self, flow: Flow, p: S) -> S {
        match flow {
            Flow::FillSubsonic => self.law.temperature_ratio(self.supply, p),
            Flow::ExhaustSubsonic => self.law.temperature_ratio(p, self.ambient),
            _ => S::of(1.0),
        }
    }

    /// Mass flow (kg/s) into the chamber besides the valve's plain law: leak, exhaust port, and what a drooping
    /// supply takes back.
    pub fn extra_inflow(&self, flow: Flow, p: S, port_open: bool) -> S {
        let mut out = self.leak;
        if let (true, Some((_, conductance))) = (port_open, self.port) {
            out = out + conductance;
        }
        let mut inflow = S::of(0.0);
        if out.value() > 0.0 {
            inflow = inflow - out * self.law.flow(p, self.ambient);
        }
        if self.droop.value() > 0.0 && flow == Flow::FillSubsonic {
            inflow = inflow + self.drooping_flow(p) - self.conductance * self.law.flow(self.supply, p);
        }
        inflow
    }

    /// n R T/V, by which a mass flow (kg/s) raises the pressure (Pa/s).
    pub fn pressure_per_mass(&self, volume: S) -> S {
        self.heating / volume
    }

    /// Whether anything but the valve's plain law acts on the pressure.
    pub fn has_extras(&self) -> bool {
        self.leak.value() > 0.0 || self.port.is_some() || self.droop.value() > 0.0
    }

    /// Mass flow (kg/s) from a supply that falls by `droop` × the flow: ṁ = q(P_s − k ṁ, P), by bisection-guarded
    /// Newton steps (the right side falls with ṁ, so the root is the only one).
    fn drooping_flow(&self, p: S) -> S {
        let law = |m: S| self.conductance * self.law.flow(self.supply - self.droop * m, p);
        let (mut low, mut high) = (0.0, law(S::of(0.0)).value());
        let mut m = S::of(high / (1.0 + high * self.droop.value() / self.supply.value()));
        // Fifty halvings reach round-off where Newton does not; one further Newton step carries the derivatives.
        for _ in 0..50 {
            let residual = law(m) - m;
            if residual.value() > 0.0 { low = m.value() } else { high = m.value() }
            let width = 1e-7 * high.max(1e-12);
            let slope = (law(m + S::of(width)) - law(m - S::of(width))).value() / (2.0 * width) - 1.0;
            let next = m - residual * S::of(1.0 / slope);
            if !(low..=high).contains(&next.value()) {
                m = S::of(0.5 * (low + high));
            } else if (next - m).value().abs() <= 1e-15 * high {
                return next;
            } else {
                m = next;
            }
        }
        m
    }
}
