//! A chamber that is fed from a tank, through a tube, or by a valve that moves in time: mass and
//! energy balances of its gas.
//!
//! The plain chamber ([`Chamber`](crate::Chamber)) carries its pressure alone, which a supply that
//! never changes allows. Here the gas of the chamber with its tube, and that of the tank, have a
//! pressure and a mass each, so that mass and energy are conserved over tank, tubes, chambers and
//! atmosphere. Everything is generic over [`Single`], so that derivatives are carried; the resistance of
//! a tube is a constant in them, but for its temperature.
//!
//! Source: docs/model.md, "Gas from a tank".

use saltus_numeric::{Dual, Scalar, Single};
use saltus_robot::{Cylinder, Gas, Robot, Term};

use crate::contractor::{Contractor, tube_volume};
use crate::orifice::OrificeLaw;
use crate::supply::Passage;

/// The gas of a volume: pressure (Pa) and mass (kg).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Held<S> {
    /// Pressure (Pa), > 0.
    pub pressure: S,
    /// Mass (kg), > 0.
    pub mass: S,
}

/// How a leg stands, for its gas.
#[derive(Clone, Copy, Debug)]
pub struct Place<S> {
    /// Extension d (m).
    pub extension: S,
    /// Its rate ḋ (m/s).
    pub speed: S,
    /// How far the valve is open towards the tank, from 0 to 1; the rest is open to the atmosphere.
    pub opening: S,
    /// Whether the exhaust port is passed.
    pub port_open: bool,
}

/// What the gas of a leg does.
#[derive(Clone, Copy, Debug)]
pub struct FeedRates<S> {
    /// Of the pressure (Pa/s) and the mass (kg/s) in the chamber with its tube.
    pub held: Held<S>,
    /// Out of the tank: mass (kg/s) and enthalpy (W).
    pub drawn: [S; 2],
    /// To the atmosphere: mass (kg/s) and enthalpy (W).
    pub vented: [S; 2],
    /// Heat (W) from the walls of the chamber.
    pub heat: S,
    /// Work (W) of the gas on the leg and on the air behind its piston, P V̇.
    pub work: S,
}

/// A tank.
#[derive(Clone, Copy, Debug)]
pub struct TankModel<S> {
    /// Volume (m³).
    pub volume: S,
    /// Thermal resistance to its wall (K/W).
    resistance: f64,
}

/// The way of the gas to the chamber of a leg.
#[derive(Clone, Copy, Debug)]
pub struct Feed<S> {
    law: OrificeLaw,
    gas: Gas,
    /// Effective area of the valve, C_f A_v (m²).
    valve: S,
    /// Resistance of the tube: see [`Passage::Tube`].
    tube: Option<[S; 2]>,
    /// Fall of the pressure before the valve with the mass flow (Pa s/kg).
    droop: S,
    /// Effective areas of leak and exhaust port (m²).
    leak: S,
    port: S,
    /// Volume of chamber and tube at d = 0 (m³), and piston area (m²), of a cylinder.
    volume: S,
    area: S,
    /// The muscle, where it is none.
    muscle: Option<Contractor<S>>,
    /// Pressure (Pa) of the full tank, and of the atmosphere.
    supply: S,
    ambient: S,
    /// Temperature (K) of the full tank, its wall and the atmosphere.
    temperature: S,
    /// Exponent n.
    exponent: S,
    /// Time constant of the valve's spool (s).
    spool: S,
    /// The tank; none: a supply that never changes.
    pub tank: Option<TankModel<S>>,
}

/// By how much of the temperature ratio across an orifice its law is rounded off: the square root of
/// a pressure difference has an infinite slope at 0. It is 4 Pa at ambient pressure, and changes
/// flows at a tenth of the pressure by a part in 10⁷.
const ROUNDING: f64 = 1e-5;
/// Loss of the ends of a tube, in dynamic pressures: half a one where it begins, one where it ends.
const ENDS: f64 = 1.5;

impl<S: Scalar> Feed<S> {
    /// The feed of `cylinder` in `robot`, where it has anything that a plain chamber has not.
    pub(crate) fn new(
        robot: &Robot,
        cylinder: &Cylinder,
        lift: impl Fn(Term, f64) -> S,
    ) -> Option<Feed<S>> {
        let tank = robot.tank.filter(|tank| tank.volume.is_finite());
        let tube = cylinder.tube.filter(|tube| tube.length > 0.0);
        let muscle = Contractor::new(robot, cylinder, &lift);
        if tank.is_none() && tube.is_none() && cylinder.spool_time == 0.0 && muscle.is_none() {
            return None;
        }
        let (gas, pi) = (cylinder.gas, S::of(std::f64::consts::PI));
        let ambient = lift(Term::Ambient, robot.environment.ambient.0);
        let temperature = lift(Term::Temperature, cylinder.temperature);
        let supply = lift(Term::Supply, cylinder.supply.0) + ambient;
        let bore = lift(Term::Bore, cylinder.bore);
        let orifice = lift(Term::OrificeRadius, cylinder.orifice_radius);
        let discharge = lift(Term::DischargeCoefficient, cylinder.discharge_coefficient);
        let exponent = cylinder.polytropic_exponent.unwrap_or(gas.heat_ratio);
        let dead = lift(Term::DeadVolume, cylinder.dead_volume);
        let low = robot.environment.ambient.0;
        // Between equal pressures nothing flows, and there is no Reynolds number.
        let high = (low + cylinder.supply.0).max(1.01 * low);
        Some(Feed {
            law: OrificeLaw::new(gas),
            gas,
            valve: discharge * pi * orifice * orifice,
            tube: tube.map(|tube| {
                let size = [tube.length, tube.diameter, tube.roughness];
                let tube = Passage::tube(size, ENDS, (gas, cylinder.temperature), [high, low]);
                let both = match tube {
                    Passage::Tube(a, b) => [a, b],
                    Passage::Orifice(..) | Passage::LongTube(_) => [0.0; 2],
                };
                // Both are in proportion to the temperature.
                both.map(|x| S::of(x / cylinder.temperature) * temperature)
            }),
            droop: lift(Term::SupplyDroop, cylinder.supply_droop),
            leak: lift(Term::LeakArea, cylinder.leak_area),
            port: cylinder
                .exhaust_port
                .map_or(S::of(0.0), |port| lift(Term::PortArea, port.area)),
            volume: dead + tube_volume(robot, &lift),
            muscle,
            area: pi * bore * bore / S::of(4.0),
            supply,
            ambient,
            temperature,
            exponent: lift(Term::PolytropicExponent, exponent),
            spool: lift(Term::SpoolTime, cylinder.spool_time),
            tank: tank.map(|tank| TankModel {
                volume: lift(Term::TankVolume, tank.volume),
                resistance: tank.wall_resistance,
            }),
        })
    }
}

impl<S: Single> Feed<S> {
    /// The gas at pressure `pressure` (Pa) and `temperature` (K) in `volume` (m³).
    fn filled(&self, pressure: S, temperature: S, volume: S) -> Held<S> {
        Held {
            pressure,
            mass: pressure * volume / (S::of(self.gas.constant) * temperature),
        }
    }

    /// The chamber of a leg at rest at extension `d` (m): at ambient pressure.
    pub fn at_rest(&self, d: S) -> Held<S> {
        self.at_pressure(self.ambient, d)
    }

    /// The same at a pressure (Pa), as warm as the gas that fills it.
    pub fn at_pressure(&self, pressure: S, d: S) -> Held<S> {
        self.filled(pressure, self.temperature, self.volume_at(d, pressure))
    }

    /// The full tank; of a supply that never changes, a cubic metre of it.
    pub fn full(&self) -> Held<S> {
        self.tank_at(self.supply, self.temperature)
    }

    /// The tank at a pressure (Pa) and temperature (K).
    pub fn tank_at(&self, pressure: S, temperature: S) -> Held<S> {
        let volume = self.tank.map_or(S::of(1.0), |tank| tank.volume);
        self.filled(pressure, temperature, volume)
    }

    /// Temperature (K) of the gas in the tank.
    pub fn tank_temperature(&self, tank: Held<S>) -> S {
        let volume = self.tank.map_or(S::of(1.0), |tank| tank.volume);
        tank.pressure * volume / (tank.mass * S::of(self.gas.constant))
    }

    /// Volume of chamber and tube (m³) at extension `d` (m); that of a muscle depends on its pressure
    /// (Pa), too.
    pub fn volume_at(&self, d: S, pressure: S) -> S {
        self.space(d, pressure)[0]
    }

    /// The same, with its derivatives by extension (m²) and by pressure (m³/Pa).
    fn space(&self, d: S, pressure: S) -> [S; 3] {
        match &self.muscle {
            None => [self.area.mul_add(d, self.volume), self.area, S::of(0.0)],
            Some(muscle) => muscle.at(d, pressure - self.ambient).volume,
        }
    }

    /// Internal energy (J) of gas at a pressure (Pa) in a volume (m³).
    pub fn energy(&self, pressure: S, volume: S) -> S {
        pressure * volume / S::of(self.gas.heat_ratio - 1.0)
    }

    /// Enthalpy (J/kg) of gas at a temperature (K).
    pub fn enthalpy(&self, temperature: S) -> S {
        let ratio = self.gas.heat_ratio;
        S::of(ratio * self.gas.constant / (ratio - 1.0)) * temperature
    }

    /// Masses (kg) of the gas that a megapascal presses into the chamber at d = 0, and into the
    /// tank: with them as units, masses are about as large as pressures in megapascals.
    pub fn mass_units(&self) -> [f64; 2] {
        let heat = self.gas.constant * self.temperature.value();
        let tank = self.tank.map_or(1.0, |tank| tank.volume.value());
        [self.volume.value(), tank].map(|volume| volume * crate::MEGA / heat)
    }

    /// How far the valve is open `time` (s) after its spool was sent `open` or shut, from the
    /// opening `from`.
    pub fn opening(&self, from: S, open: bool, time: S) -> S {
        let target = S::of(if open { 1.0 } else { 0.0 });
        if self.spool.value() <= 0.0 {
            return target;
        }
        let left = S::of(std::f64::consts::E).pow(-(time.max(S::of(0.0)) / self.spool));
        target + (from - target) * left
    }

    /// Time constant of the valve's spool (s).
    pub fn spool_time(&self) -> S {
        self.spool
    }

    /// What the gas of a leg does, with the tank as it is.
    ///
    /// Of the first law, V Ṗ = n (Σ R T ṁ − P V̇) with the temperature T where each flow comes
    /// from; n other than κ is heat from the wall.
    pub fn rates(&self, tank: Held<S>, held: Held<S>, at: &Place<S>) -> FeedRates<S> {
        let zero = S::of(0.0);
        let [volume, grows, swells] = self.space(at.extension, held.pressure);
        let constant = S::of(self.gas.constant);
        let own = held.pressure * volume / (held.mass * constant);
        let air = (self.ambient, self.temperature);
        let source = match self.tank {
            Some(_) => (tank.pressure, self.tank_temperature(tank)),
            None => (self.supply, self.temperature),
        };
        let (mut inflow, mut heating) = (zero, zero);
        let mut take = |flow: S, from: (S, S)| {
            let at = if flow.value() > 0.0 { from.1 } else { own };
            inflow = inflow + flow;
            heating = heating + flow * at;
            [flow, flow * self.enthalpy(at)]
        };
        let mut drawn = [zero; 2];
        if at.opening.value() > 0.0 {
            let area = self.valve * at.opening;
            drawn = take(
                self.through(area, self.droop, source, (held.pressure, own)),
                source,
            );
        }
        let mut vented = [zero; 2];
        let shut = S::of(1.0) - at.opening;
        if shut.value() > 0.0 {
            let flow = self.through(self.valve * shut, zero, air, (held.pressure, own));
            vented = take(flow, air).map(|x| -x);
        }
        let mut opened = self.leak;
        if at.port_open {
            opened = opened + self.port;
        }
        if opened.value() > 0.0 {
            let flow = self.orifice(opened, air, (held.pressure, own));
            for (all, one) in vented.iter_mut().zip(take(flow, air)) {
                *all = *all - one;
            }
        }
        // V̇ = V_d ḋ + V_P Ṗ.
        let pushed = constant * heating - held.pressure * grows * at.speed;
        let room = volume + self.exponent * held.pressure * swells;
        let rate = self.exponent * pushed / room;
        let work = held.pressure * (grows * at.speed + swells * rate);
        let pushed = constant * heating - work;
        let exchange =
            (self.exponent - S::of(self.gas.heat_ratio)) / S::of(self.gas.heat_ratio - 1.0);
        FeedRates {
            held: Held {
                pressure: rate,
                mass: inflow,
            },
            drawn,
            vented,
            heat: exchange * pushed,
            work,
        }
    }

    /// What the tank does while the legs draw mass (kg/s) and enthalpy (W): its rates, and the heat
    /// (W) from its wall.
    pub fn tank_rates(&self, tank: Held<S>, drawn: [S; 2]) -> (Held<S>, S) {
        let zero = S::of(0.0);
        let Some(model) = self.tank else {
            let pressure = zero;
            return (
                Held {
                    pressure,
                    mass: zero,
                },
                zero,
            );
        };
        let [mass, enthalpy] = drawn;
        let capacity = S::of(self.gas.constant / (self.gas.heat_ratio - 1.0));
        let heat = if model.resistance == 0.0 {
            // As warm as the wall, whatever leaves: U = m c T.
            enthalpy - mass * capacity * self.temperature
        } else if model.resistance.is_finite() {
            (self.temperature - self.tank_temperature(tank)) / S::of(model.resistance)
        } else {
            zero
        };
        let rates = Held {
            pressure: S::of(self.gas.heat_ratio - 1.0) * (heat - enthalpy) / model.volume,
            mass: -mass,
        };
        (rates, heat)
    }
}

impl Feed<f64> {
    /// The tank after `h` (s) in which the legs draw mass (kg/s) and enthalpy (W); heat from its wall
    /// is taken after that, exactly for the gas that is left.
    pub fn tank_after(&self, tank: Held<f64>, [mass, enthalpy]: [f64; 2], h: f64) -> Held<f64> {
        let Some(model) = self.tank else {
            return tank;
        };
        let ratio = self.gas.heat_ratio - 1.0;
        let mut after = Held {
            pressure: tank.pressure - h * ratio * enthalpy / model.volume,
            mass: tank.mass - h * mass,
        };
        if model.resistance < f64::INFINITY {
            let settled = after.mass * self.gas.constant * self.temperature / model.volume;
            let slow = model.resistance * after.mass * self.gas.constant / ratio;
            after.pressure = settled + (after.pressure - settled) * (-h / slow).exp();
        }
        after
    }
}

impl<S: Single> Feed<S> {
    /// Flow (kg/s) into the chamber through the valve, of the effective area `area` (m²), and the
    /// tube, between a source and the chamber's end, each a pressure (Pa) and a temperature (K).
    ///
    /// Inwards the valve comes first, outwards the tube; the root of what the valve would let
    /// through less what flows is sought in plain numbers, and one more step carries derivatives.
    fn through(&self, area: S, droop: S, source: (S, S), chamber: (S, S)) -> S {
        let inwards = source.0.value() >= chamber.0.value();
        let droop = if inwards { droop } else { S::of(0.0) };
        if self.tube.is_none() && droop.value() == 0.0 {
            return self.orifice(area, source, chamber);
        }
        let (up, down) = if inwards {
            (source, chamber)
        } else {
            (chamber, source)
        };
        let series = Series {
            law: self.law,
            tube: self.tube.unwrap_or([S::of(0.0); 2]),
            valve_first: inwards,
            area,
            droop,
            up,
            down: down.0,
        };
        let flow = series.flow();
        if inwards { flow } else { -flow }
    }

    /// Flow (kg/s) from `a` to `b`, each a pressure (Pa) and a temperature (K), through an orifice of
    /// the effective area `area` (m²).
    fn orifice(&self, area: S, a: (S, S), b: (S, S)) -> S {
        if a.0.value() >= b.0.value() {
            area / a.1.sqrt() * rounded_flow(&self.law, a.0, b.0)
        } else {
            -(area / b.1.sqrt() * rounded_flow(&self.law, b.0, a.0))
        }
    }
}

/// A valve and a tube one after the other.
#[derive(Clone, Copy)]
struct Series<S> {
    law: OrificeLaw,
    tube: [S; 2],
    valve_first: bool,
    area: S,
    droop: S,
    up: (S, S),
    down: S,
}

impl<S: Single> Series<S> {
    /// What the valve lets through where `flow` (kg/s) flows, less that flow.
    fn surplus(&self, flow: S) -> S {
        let [a, b] = self.tube;
        let fall = flow * (a + b * flow);
        let (mut up, mut down) = (self.up.0 - self.droop * flow, self.down);
        if self.valve_first {
            down = (down * down + fall).sqrt();
        } else {
            let square = up * up - fall;
            let least = S::of(1e-6) * down * down;
            up = if square.value() > least.value() {
                square.sqrt()
            } else {
                least.sqrt()
            };
        }
        let area = self.area / self.up.1.sqrt();
        let through = if up.value() >= down.value() {
            area * rounded_flow(&self.law, up, down)
        } else {
            -(area * rounded_flow(&self.law, down, up))
        };
        through - flow
    }

    /// The flow (kg/s), ≥ 0: safeguarded Newton steps from where it is if the square of the valve's
    /// flow, too, is in proportion to a difference of squared pressures.
    fn flow(&self) -> S {
        /// Length of a step, of the flow through the valve alone, after which the next is nothing.
        const CLOSE: f64 = 1e-10;
        /// It takes three to six.
        const ROUNDS: usize = 100;
        let plain = Series::<Dual<1>> {
            law: self.law,
            tube: self.tube.map(|x| Dual::of(x.value())),
            valve_first: self.valve_first,
            area: Dual::of(self.area.value()),
            droop: Dual::of(self.droop.value()),
            up: (Dual::of(self.up.0.value()), Dual::of(self.up.1.value())),
            down: Dual::of(self.down.value()),
        };
        let alone = plain.surplus(Dual::of(0.0)).value.max(0.0);
        let (mut low, mut high) = (0.0, alone);
        let squares = plain.up.0.value * plain.up.0.value - plain.down.value * plain.down.value;
        let [a, b] = plain.tube.map(|x| x.value);
        let all = b + squares / (alone * alone);
        let mut at = 2.0 * squares / (a + (a * a + 4.0 * all * squares).sqrt());
        if !(low..=high).contains(&at) {
            at = 0.5 * alone;
        }
        let mut slope = -1.0;
        for _ in 0..ROUNDS {
            let here = plain.surplus(Dual::variable(at, 0));
            slope = here.slope[0];
            if here.value > 0.0 {
                low = at;
            } else {
                high = at;
            }
            let mut next = at - here.value / slope;
            if !(low..=high).contains(&next) {
                next = low.midpoint(high);
            }
            let step = (next - at).abs();
            at = next;
            if step <= CLOSE * alone || here.value == 0.0 {
                break;
            }
        }
        // The slope is that of the last step but one: exact enough, as the root is to round-off.
        let surplus = self.surplus(S::of(at));
        S::of(at) - surplus / S::of(slope)
    }
}

/// Flow over conductance (Pa √(kg K/J)) from `up` to `down` (Pa), not above it, with its infinite slope
/// between equal pressures rounded off: √h becomes h/(h² + ε²)^¼, h = 1 − e.
fn rounded_flow<S: Single>(law: &OrificeLaw, up: S, down: S) -> S {
    let of = S::of;
    let rounded = |h: S| h / (h * h + of(ROUNDING * ROUNDING)).sqrt().sqrt();
    let ratio = down / up;
    if ratio.value() <= law.critical_ratio {
        let h = 1.0 - 2.0 / (law.heat_ratio + 1.0);
        // So that both laws meet.
        let meets = h.sqrt() / (h * h + ROUNDING * ROUNDING).sqrt().sqrt();
        return up * of(law.choked * meets);
    }
    let cooling = ratio.pow(of(law.temperature_exponent));
    let headroom = of(1.0) - cooling;
    up * of(law.subsonic) * (ratio / cooling) * rounded(headroom)
}

#[cfg(test)]
mod tests {
    use saltus_robot::resolve;

    use super::*;
    use crate::Leg;
    use crate::supply::{Line, Opening, Supply, Wall};

    fn feed(set: &[&str]) -> Feed<f64> {
        let set: Vec<String> = set.iter().map(ToString::to_string).collect();
        let robot = resolve("rats-planar", &set).expect("a legal robot");
        Leg::<f64>::new(&robot, |_, x| x).feed.expect("it is fed")
    }

    /// Chamber and tank after `time` (s) in `steps` midpoint steps, with the leg held.
    fn filled(feed: &Feed<f64>, opening: f64, time: f64, steps: u32) -> (Held<f64>, Held<f64>) {
        let h = time / f64::from(steps);
        let place = Place {
            extension: 0.0,
            speed: 0.0,
            opening,
            port_open: false,
        };
        let after = |at: Held<f64>, rates: Held<f64>, h: f64| Held {
            pressure: at.pressure + h * rates.pressure,
            mass: at.mass + h * rates.mass,
        };
        let (mut held, mut tank) = (feed.at_rest(0.0), feed.full());
        for _ in 0..steps {
            let first = feed.rates(tank, held, &place);
            let middle = feed.tank_after(tank, first.drawn, 0.5 * h);
            let second = feed.rates(middle, after(held, first.held, 0.5 * h), &place);
            held = after(held, second.held, h);
            tank = feed.tank_after(tank, second.drawn, h);
        }
        (held, tank)
    }

    /// By [`Supply`], which carries masses and energies, and does not round the orifice law off.
    #[test]
    fn a_chamber_fills_as_from_a_supply() {
        for wall in ["inf", "2", "0"] {
            let wall_key = format!("tank.wall_resistance_k_per_w={wall}");
            let own = feed(&["tank.volume_l=0.05", &wall_key]);
            let gas = own.gas;
            let ambient = [own.ambient, own.temperature];
            let fill = Passage::Orifice(own.law, own.valve);
            let insulated = Wall {
                temperature: own.temperature,
                resistance: f64::INFINITY,
            };
            let supply = Supply {
                gas,
                ambient,
                tank: 0.05e-3,
                wall: Wall {
                    resistance: wall.parse().expect("a number"),
                    ..insulated
                },
                outlet: None,
                lines: vec![Line {
                    fill,
                    vent: fill,
                    leak: None,
                    wall: insulated,
                }],
            };
            let full = own.full();
            let mut stock =
                supply.stock([full.pressure, own.temperature], &[(own.volume, ambient)]);
            let open = [Opening {
                fill: 1.0,
                vent: 0.0,
            }];
            let (time, steps) = (0.004, 20_000_u32);
            for _ in 0..steps {
                let volume = [own.volume];
                supply.advance(&mut stock, time / f64::from(steps), [&volume; 3], &open);
            }
            let (held, tank) = filled(&own, 1.0, time, steps);
            let [pressure, _] = supply.state(stock.lines[0], own.volume);
            let [tank_pressure, temperature] = supply.tank_state(&stock);
            for (what, a, b) in [
                ("pressure", held.pressure, pressure),
                ("mass", held.mass, stock.lines[0].mass),
                ("tank", tank.pressure, tank_pressure),
                ("temperature", own.tank_temperature(tank), temperature),
            ] {
                // What the rounding of the law leaves.
                assert!((a - b).abs() < 2e-6 * b, "{wall} {what}: {a} {b}");
            }
            assert!(held.pressure > 1.5 * own.ambient, "{held:?}");
        }
    }

    /// A valve and a tube in series let through what both would, each with the pressure between them
    /// on its side.
    #[test]
    fn valve_and_tube_carry_one_flow() {
        let own = feed(&["leg.tube.length_m=0.7", "leg.tube.diameter_mm=3"]);
        let [a, b] = own.tube.expect("a tube");
        let tube = Passage::Tube(a, b);
        let cold = own.temperature;
        for (from, to) in [(9e5, 1e5), (9e5, 8.9e5), (4e5, 1e5), (1.02e5, 1e5)] {
            for inwards in [true, false] {
                let (source, chamber) = if inwards { (from, to) } else { (to, from) };
                let flow = own.through(own.valve, 0.0, (source, cold), (chamber, cold));
                assert_eq!(flow > 0.0, inwards);
                let flow = flow.abs();
                let fall = flow * (a + b * flow);
                // The pressure between them, by the tube; then the valve.
                let (up, down) = if inwards {
                    (from, (to * to + fall).sqrt())
                } else {
                    ((from * from - fall).sqrt(), to)
                };
                let by_valve = own.valve / cold.sqrt() * rounded_flow(&own.law, up, down);
                assert!(
                    (by_valve - flow).abs() < 1e-12 * flow,
                    "{from} {to}: {by_valve} {flow}"
                );
                let by_tube = if inwards {
                    tube.flow([down, cold], to)
                } else {
                    tube.flow([from, cold], up)
                };
                assert!(
                    (by_tube - flow).abs() < 1e-9 * flow,
                    "{from} {to}: {by_tube} {flow}"
                );
            }
        }
        // Nothing flows between equal pressures.
        assert_eq!(own.through(own.valve, 0.0, (2e5, cold), (2e5, cold)), 0.0);
    }

    #[test]
    fn a_spool_opens_and_shuts_exponentially() {
        let own = feed(&["leg.valve_time_constant_ms=2"]);
        let open = own.opening(0.0, true, 3e-3);
        assert!((open - (1.0 - (-1.5_f64).exp())).abs() < 1e-15);
        let shut = own.opening(open, false, 1e-3);
        assert!((shut - open * (-0.5_f64).exp()).abs() < 1e-15);
        let quick = feed(&["tank.volume_l=1"]);
        assert_eq!(
            [
                quick.opening(0.0, true, 0.0),
                quick.opening(1.0, false, 0.0)
            ],
            [1.0, 0.0]
        );
    }
}
