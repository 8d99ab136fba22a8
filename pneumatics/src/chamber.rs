//! The chamber of a pneumatic leg: how its pressure changes.

use std::f64::consts::PI;

use saltus_numeric::{Scalar, Single};
use saltus_robot::{Cylinder, Robot, Term};

use crate::orifice::OrificeLaw;

/// The chamber between the valve and the piston, with everything that fills or empties it.
///
/// Ṗ = n R T ṁ/V − n P A ḋ/V, with V = V_0 + A d and n = κ unless the exponent is given.
///
/// Source: thesis §4.3.1, docs/model.md, "Pneumatic drive".
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
    /// e where sonic flow turns subsonic: 2/(κ+1).
    critical_temperature_ratio: S,
}

/// What the valve does to the chamber while nothing switches: one smooth piece of the orifice law.
///
/// Each piece carries the pressure as the variable u in which it is smoothest: the pressure itself
/// (MPa) where the flow is sonic, the temperature ratio e = (P_d/P_u)^((κ−1)/κ) where it is
/// subsonic. All obey V u̇ = `constant` + u (`flow` X + `expansion` ḋ), with X = 1 (sonic),
/// √(1−e)/e (filling), r √(1−e)/e (exhausting), where r = e^(κ/(κ−1)) is the pressure ratio.
#[derive(Clone, Copy, Debug)]
pub struct Valve<S: Scalar> {
    /// The coefficients of the law, one for each lane.
    pub law: ValveLaw<S>,
    /// The flow is sonic, or nothing flows.
    pub sonic: S::Mask,
    /// The flow is subsonic and out of the chamber.
    pub outward: S::Mask,
}

/// Coefficients of a [`Valve`]'s law.
#[derive(Clone, Copy, Debug)]
pub struct ValveLaw<S> {
    /// m³ MPa/s.
    pub constant: S,
    /// m³/s.
    pub flow: S,
    /// m².
    pub expansion: S,
    /// d ln P/d ln u: 1 where u is the pressure, ±κ/(κ−1) where it is the temperature ratio.
    pub stiffness: S,
}

/// What the gas does at an instant.
#[derive(Clone, Copy, Debug)]
pub struct GasState<S> {
    /// Pressure P (Pa).
    pub pressure: S,
    /// u̇ (MPa/s or 1/s).
    pub rate: S,
    /// Ṗ (Pa/s) over u̇.
    pub pressure_per_variable: S,
    /// 1/`about_foot` as given, and 1/V (1/m³).
    pub inverses: (S, S),
}

/// Pascals in the unit of pressure that u has.
pub const MEGA: f64 = 1e6;

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

impl Flow {
    /// Whether the pressure is carried as the temperature ratio.
    pub fn is_subsonic(self) -> bool {
        matches!(self, Flow::FillSubsonic | Flow::ExhaustSubsonic)
    }
}

impl<S: Scalar> Chamber<S> {
    /// The chamber of `cylinder` in `robot`; `lift` turns the value of a term into a number of the
    /// wanted kind. Derivatives by the ratio of specific heats are not carried.
    pub(crate) fn new(
        robot: &Robot,
        cylinder: &Cylinder,
        lift: impl Fn(Term, f64) -> S,
    ) -> Chamber<S> {
        let gas = cylinder.gas;
        let ambient = lift(Term::Ambient, robot.environment.ambient.0);
        let temperature = lift(Term::Temperature, cylinder.temperature);
        let bore = lift(Term::Bore, cylinder.bore);
        let orifice = lift(Term::OrificeRadius, cylinder.orifice_radius);
        let discharge = lift(Term::DischargeCoefficient, cylinder.discharge_coefficient);
        let exponent = cylinder.polytropic_exponent.unwrap_or(gas.heat_ratio);
        let exponent = lift(Term::PolytropicExponent, exponent);
        let of_area = |term: Term, area: f64| lift(term, area) / temperature.sqrt();
        Chamber {
            area: S::of(PI) * bore * bore / S::of(4.0),
            dead_volume: lift(Term::DeadVolume, cylinder.dead_volume),
            supply: lift(Term::Supply, cylinder.supply.0) + ambient,
            ambient,
            law: OrificeLaw::new(gas),
            conductance: discharge
                * S::of(PI)
                * orifice
                * orifice
                * (S::of(1.0) / temperature.sqrt()),
            leak: of_area(Term::LeakArea, cylinder.leak_area),
            port: cylinder.exhaust_port.map(|port| {
                (
                    lift(Term::PortPosition, port.position),
                    of_area(Term::PortArea, port.area),
                )
            }),
            droop: lift(Term::SupplyDroop, cylinder.supply_droop),
            heating: exponent * S::of(gas.constant) * temperature,
            exponent,
            critical_temperature_ratio: S::of(2.0 / (gas.heat_ratio + 1.0)),
        }
    }

    /// Volume (m³) at extension `d` (m).
    #[inline(always)]
    pub fn volume(&self, d: S) -> S {
        self.area.mul_add(d, self.dead_volume)
    }

    /// Pressure change (Pa/s) with the leg held, when sonic flow fills the chamber; none of the
    /// other effects.
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

    /// Pressure (Pa) from which filling counts as over: just short of the supply's, which it
    /// reaches at rate 0.
    pub fn balance_above(&self) -> S {
        self.supply * S::of(1.0 - 1e-12)
    }

    /// Pressure (Pa) from which exhausting counts as over: just above ambient, which it reaches at
    /// rate 0.
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

    /// The coefficients of the piece `flow` of the valve's law.
    #[inline(always)]
    pub fn valve_law(&self, flow: Flow) -> ValveLaw<S> {
        let zero = S::of(0.0);
        let heat = self.heating * self.conductance;
        let (sonic, subsonic) = (
            heat * S::of(self.law.choked),
            heat * S::of(self.law.subsonic),
        );
        let growth = self.exponent * self.area;
        let k = S::of(self.law.temperature_exponent);
        let one = S::of(1.0);
        let (constant, flow, expansion, stiffness) = match flow {
            Flow::FillChoked => (
                sonic * self.sonic_supply() * S::of(1.0 / MEGA),
                zero,
                -growth,
                one,
            ),
            Flow::FillSubsonic => (zero, k * subsonic, -(k * growth), one / k),
            Flow::ExhaustChoked => (zero, -sonic, -growth, one),
            Flow::ExhaustSubsonic => (zero, k * subsonic, k * growth, -(one / k)),
            Flow::FillBalanced | Flow::ExhaustBalanced => (zero, zero, -growth, one),
        };
        ValveLaw {
            constant,
            flow,
            expansion,
            stiffness,
        }
    }

    /// The gas at `u` while the leg at extension `d` (m) extends at `speed` (m/s).
    ///
    /// `about_foot` is any number that the caller divides by too: its inverse comes with that of the
    /// volume, at the cost of one division for both.
    #[inline(always)]
    pub fn gas(&self, valve: &Valve<S>, u: S, d: S, speed: S, about_foot: S) -> GasState<S> {
        let one = S::of(1.0);
        let volume = self.volume(d);
        let inverse = one / (about_foot * volume);
        let (inverse_about_foot, inverse_volume) = (inverse * volume, inverse * about_foot);
        let inverse_u = one / u;
        let ratio = S::select(valve.sonic, || one, || self.law.pressure_ratio(u));
        let pressure = S::select(
            valve.sonic,
            || u * S::of(MEGA),
            || {
                S::select(
                    valve.outward,
                    || self.ambient / ratio,
                    || self.supply * ratio,
                )
            },
        );
        let x = S::select(
            valve.sonic,
            || one,
            || {
                // Not 0: where the flow ends, its slopes are infinite, and a dual would not be a
                // number.
                let root = (one - u).max(S::of(f64::MIN_POSITIVE)).sqrt() * inverse_u;
                S::select(valve.outward, || root * ratio, || root)
            },
        );
        let law = &valve.law;
        let relative = law.flow.mul_add(x, law.expansion * speed);
        GasState {
            pressure,
            rate: u.mul_add(relative, law.constant) * inverse_volume,
            pressure_per_variable: law.stiffness * pressure * inverse_u,
            inverses: (inverse_about_foot, inverse_volume),
        }
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
    pub fn valve(&self, flow: Flow) -> Valve<S> {
        let mut law = self.valve_law(flow);
        if self.droops(flow) {
            // The whole of this flow is among the extra ones: near balance the plain one is all
            // cancellation.
            law.flow = S::of(0.0);
        }
        Valve {
            law,
            sonic: !flow.is_subsonic(),
            outward: flow == Flow::ExhaustSubsonic,
        }
    }

    /// u at pressure `p` (Pa) on the piece `flow`.
    pub fn variable(&self, flow: Flow, p: S) -> S {
        match flow {
            Flow::FillSubsonic => self.law.temperature_ratio(p, self.supply),
            Flow::ExhaustSubsonic => self.law.temperature_ratio(self.ambient, p),
            _ => p * S::of(1.0 / MEGA),
        }
    }

    /// Where the piece `flow` of the plain valve's law ends, in u: with the pressure falling, and
    /// rising.
    pub fn edges(&self, flow: Flow) -> (S, S) {
        let (micro, never) = (S::of(1.0 / MEGA), S::of(1e6));
        let balance = S::of(1.0 - 1e-12 * self.law.temperature_exponent);
        match flow {
            Flow::FillChoked => (S::of(0.0), self.fill_edge() * micro),
            Flow::FillSubsonic => (self.critical_temperature_ratio, balance),
            Flow::FillBalanced => (self.balance_above() * micro, never),
            Flow::ExhaustChoked => (self.exhaust_edge() * micro, never),
            Flow::ExhaustSubsonic => (balance, self.critical_temperature_ratio),
            Flow::ExhaustBalanced => (S::of(0.0), self.balance_below() * micro),
        }
    }

    /// Pressure (Pa) at `u` on the piece `flow`.
    pub fn pressure(&self, flow: Flow, u: S) -> S {
        match flow {
            Flow::FillSubsonic => self.supply * self.law.pressure_ratio(u),
            Flow::ExhaustSubsonic => self.ambient / self.law.pressure_ratio(u),
            _ => u * S::of(MEGA),
        }
    }

    /// Whether the supply droops on the piece `flow` in a way that the plain law does not know.
    fn droops(&self, flow: Flow) -> bool {
        self.droop.value() > 0.0 && flow == Flow::FillSubsonic
    }

    /// Mass flow (kg/s) into the chamber besides that of [`valve`](Chamber::valve): leak, exhaust
    /// port, and all that a drooping supply gives below sonic speed.
    pub fn extra_inflow(&self, flow: Flow, p: S, port_open: bool) -> S {
        let mut out = self.leak;
        if let (true, Some((_, conductance))) = (port_open, self.port) {
            out = out + conductance;
        }
        let mut inflow = S::of(0.0);
        if out.value() > 0.0 {
            inflow = inflow - out * self.law.flow(p, self.ambient);
        }
        inflow + self.drooping_inflow(flow, p)
    }

    /// Mass flow (kg/s) that a drooping supply gives below sonic speed: on other pieces, and without
    /// droop, it is a part of the plain law.
    pub(crate) fn drooping_inflow(&self, flow: Flow, p: S) -> S {
        if self.droops(flow) {
            self.drooping_flow(p)
        } else {
            S::of(0.0)
        }
    }

    /// n of the chamber's equation.
    pub fn exponent(&self) -> S {
        self.exponent
    }

    /// n R T (J/kg): a mass flow (kg/s) into the volume V raises the pressure by n R T/V times as
    /// much (Pa/s).
    pub fn pressure_per_mass(&self) -> S {
        self.heating
    }

    /// Whether anything but the valve's plain law acts on the pressure.
    pub fn has_extras(&self) -> bool {
        self.has_openings() || self.droop.value() > 0.0
    }

    /// Whether it opens to the atmosphere otherwise than through its valve.
    pub fn has_openings(&self) -> bool {
        self.leak.value() > 0.0 || self.port.is_some()
    }

    /// Mass flow (kg/s) from a supply that falls by `droop` × the flow: ṁ = q(P_s − k ṁ, P), below
    /// sonic speed.
    ///
    /// With w = √(1 − e) of the temperature ratio e across the valve, ṁ = C C_2 P w/(1 − w²), and
    /// the supply's balance P (1 − w²)^(−κ/(κ−1)) + k ṁ = P_s is smooth, rising and convex in w:
    /// Newton's steps from the flow without droop come down to its root, and never past it.
    fn drooping_flow(&self, p: S) -> S {
        let (one, two) = (S::of(1.0), S::of(2.0));
        let valve = self.conductance * S::of(self.law.subsonic) * p;
        let power = 1.0 / self.law.temperature_exponent;
        let cold = self.law.temperature_ratio(p, self.supply).value();
        if cold >= 1.0 {
            // A step may look a little past the balance, where nothing flows.
            return S::of(0.0);
        }
        let mut w = S::of((1.0 - cold).sqrt());
        let newton = |w: S| {
            let e = one - w * w;
            let upstream = p * e.pow(S::of(-power));
            let flow = valve * w / e;
            let slope =
                (S::of(power) * upstream * two * w + self.droop * valve * (one + w * w) / e) / e;
            w - (upstream + self.droop * flow - self.supply) / slope
        };
        // It takes four to ten; one more carries the derivatives.
        for _ in 0..50 {
            let next = newton(w);
            let is_last = (next - w).value().abs() <= 1e-14 * w.value();
            w = next;
            if is_last {
                break;
            }
        }
        w = newton(w);
        valve * w / (one - w * w)
    }
}
