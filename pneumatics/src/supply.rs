//! A robot that carries its gas: a tank, and a line to each chamber.
//!
//! Gas is perfect. Every volume has a mass m and an internal energy U of its own, P = (κ − 1) U/V,
//! so that mass and energy are conserved to round-off over tank, lines, chambers and atmosphere.
//!
//! Source: the first law for open systems, dU = h dm + Q − P dV; the flow through a tube by
//! Darcy and Weisbach for an isothermal gas (e.g. Çengel and Cimbala, Fluid Mechanics, chapters 8
//! and 12), its friction factor by Haaland (1983).

use std::f64::consts::PI;

use saltus_robot::Gas;

use crate::orifice::OrificeLaw;

/// Dynamic viscosity (Pa s) of air at room temperature; that of carbon dioxide is a fifth lower.
const VISCOSITY: f64 = 1.82e-5;

/// What a volume holds; both are above 0 there.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Store {
    /// Mass (kg).
    pub mass: f64,
    /// Internal energy (J).
    pub energy: f64,
}

/// The wall of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Its temperature (K).
    pub temperature: f64,
    /// Thermal resistance between gas and wall (K/W): 0, the gas is always as warm as the wall;
    /// infinite, no heat passes.
    pub resistance: f64,
}

/// What gas flows through.
#[derive(Clone, Copy, Debug)]
pub enum Passage {
    /// An orifice: its law, and its effective area (m²).
    Orifice(OrificeLaw, f64),
    /// A tube in which P₁² − P₂² = a ṁ + b ṁ²: a (Pa² s/kg) is all of a laminar flow, b (Pa² s²/kg²)
    /// of the ends and of a fully rough tube; one of them is above 0. The gas has the temperature that both
    /// were computed for, whatever flows in.
    Tube(f64, f64),
    /// The same with a third part of the law: P₁² − P₂² = a ṁ + b ṁ² + c ṁ^(7/4), as that of Blasius
    /// for smooth tubes.
    LongTube([f64; 3]),
}

impl Passage {
    /// A tube of this length, diameter and roughness (m), in which `gas` at `temperature` (K) flows
    /// from `high` to `low` (Pa) at most: its law is that of Darcy and Weisbach at this flow and at a
    /// third of it. The friction factor is Haaland's, or that of laminar flow where it is greater.
    /// `ends` is the loss of its ends and bends, in dynamic pressures. Length and diameter are above
    /// 0, roughness and `ends` not below, and `high` is above `low`.
    pub fn tube(size: [f64; 3], ends: f64, gas: (Gas, f64), [high, low]: [f64; 2]) -> Passage {
        const PART: f64 = 1.0 / 3.0;
        let each = resistance(size, ends, gas);
        let flow = greatest(&each, (high - low) * (high + low));
        let [fast, slow] = [each(flow), each(PART * flow)];
        let a = (slow - fast) * flow / (1.0 / PART - 1.0);
        Passage::Tube(a, (fast - a / flow).max(0.0))
    }

    /// The same tube by a law that is that of Darcy and Weisbach at a tenth of the greatest flow as
    /// well, and within 1 % of it between: for gas that flows ever slower.
    pub fn long_tube(size: [f64; 3], ends: f64, gas: (Gas, f64), [high, low]: [f64; 2]) -> Passage {
        /// Flows in terms of the greatest.
        const AT: [f64; 3] = [1.0, 0.4, 0.1];
        let each = resistance(size, ends, gas);
        let flow = greatest(&each, (high - low) * (high + low));
        // a/ṁ + b + c ṁ^(−1/4) at these flows: differences rid it of b.
        let of = |part: f64| {
            [
                each(part * flow),
                1.0 / (part * flow),
                (part * flow).powf(-0.25),
            ]
        };
        let [fast, middle, slow] = AT.map(of);
        let less = |x: [f64; 3], y: [f64; 3]| [x[0] - y[0], x[1] - y[1], x[2] - y[2]];
        let (m, n) = (less(middle, fast), less(slow, fast));
        let whole = m[1] * n[2] - m[2] * n[1];
        let a = (m[0] * n[2] - m[2] * n[0]) / whole;
        let c = (m[1] * n[0] - m[0] * n[1]) / whole;
        let b = fast[0] - a * fast[1] - c * fast[2];
        if a >= 0.0 && b >= 0.0 && c >= 0.0 {
            Passage::LongTube([a, b, c])
        } else {
            Passage::tube(size, ends, gas, [high, low])
        }
    }

    /// The passage that lets `share` times as much through.
    #[must_use]
    pub fn times(self, share: f64) -> Passage {
        match self {
            Passage::Orifice(law, area) => Passage::Orifice(law, share * area),
            Passage::Tube(a, b) => Passage::Tube(a / share, b / (share * share)),
            Passage::LongTube([a, b, c]) => {
                Passage::LongTube([a / share, b / (share * share), c / share.powf(1.75)])
            }
        }
    }

    /// Mass flow (kg/s) of gas from a pressure (Pa) and temperature (K) to a pressure `down` (Pa) not
    /// above it.
    pub fn flow(&self, [up, temperature]: [f64; 2], down: f64) -> f64 {
        match self {
            Passage::Orifice(law, area) => area / temperature.sqrt() * law.flow(up, down),
            Passage::Tube(a, b) => {
                let fall = (up - down) * (up + down);
                if fall == 0.0 {
                    return 0.0;
                }
                2.0 * fall / (a + (a * a + 4.0 * b * fall).sqrt())
            }
            Passage::LongTube(law) => through(law, (up - down) * (up + down)),
        }
    }
}

/// Mass flow (kg/s) at which a law a ṁ + b ṁ² + c ṁ^(7/4) comes to `fall` (Pa²), ≥ 0.
fn through([a, b, c]: &[f64; 3], fall: f64) -> f64 {
    /// Far more than a search takes.
    const ROUNDS: usize = 50;
    if fall == 0.0 {
        return 0.0;
    }
    let quadratic = |b: f64| 2.0 * fall / (a + (a * a + 4.0 * b * fall).sqrt());
    let root = |flow: f64| c / flow.sqrt().sqrt();
    // Without the third part too much flows, by which that part is too small; so often enough.
    let most = if *a > 0.0 || *b > 0.0 {
        quadratic(*b)
    } else {
        (fall / c).powf(4.0 / 7.0)
    };
    let mut flow = quadratic(b + root(most));
    for _ in 0..ROUNDS {
        let root = root(flow);
        let told = flow * (a + flow * (b + root));
        // The law is nearly a power n of the flow; of the n-th root of fall/told, Padé's first.
        let n = flow * (a + flow * (2.0 * b + 1.75 * root)) / told;
        let (more, less) = ((n + 1.0) * fall, (n - 1.0) * told);
        let to = (more + less) / ((n - 1.0) * fall + (n + 1.0) * told);
        flow *= to;
        // What is left falls with the cube of it.
        if (to - 1.0).abs() <= 1e-5 {
            break;
        }
    }
    flow
}

/// (P₁² − P₂²)/ṁ² (Pa² s²/kg²) of a tube over the mass flow (kg/s), by Darcy and Weisbach.
fn resistance(
    [length, diameter, roughness]: [f64; 3],
    ends: f64,
    (gas, temperature): (Gas, f64),
) -> impl Fn(f64) -> f64 {
    /// Reynolds number below which laminar flow has the greater factor: Haaland's has a pole at
    /// 6.9.
    const LAMINAR: f64 = 500.0;
    let area = 0.25 * PI * diameter * diameter;
    let rough = (roughness / diameter / 3.7).powf(1.11);
    move |flow| {
        let reynolds = 4.0 * flow / (PI * diameter * VISCOSITY);
        let haaland = (-1.8 * (6.9 / reynolds.max(LAMINAR) + rough).log10()).powi(-2);
        let factor = haaland.max(64.0 / reynolds);
        (factor * length / diameter + ends) * gas.constant * temperature / (area * area)
    }
}

/// The mass flow (kg/s) of such a tube at a `fall` (Pa²).
fn greatest(resistance: impl Fn(f64) -> f64, fall: f64) -> f64 {
    /// From the friction factor to the flow and back; each round at least halves what is left.
    const ROUNDS: usize = 60;
    (0..ROUNDS).fold(1e-3, |flow, _| (fall / resistance(flow)).sqrt())
}

/// The line from the tank to a chamber, through a valve of its own.
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// From the tank, where the valve is energized.
    pub fill: Passage,
    /// To the atmosphere, where it is at rest or vented.
    pub vent: Passage,
    /// To the atmosphere, always open.
    pub leak: Option<Passage>,
    /// The wall of tube and chamber.
    pub wall: Wall,
}

/// How far the valve of a line is open, each from 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening {
    /// To the tank.
    pub fill: f64,
    /// To the atmosphere.
    pub vent: f64,
}

/// A tank with its lines.
#[derive(Clone, Debug)]
pub struct Supply {
    /// The gas.
    pub gas: Gas,
    /// Pressure (Pa) and temperature (K) of the atmosphere.
    pub ambient: [f64; 2],
    /// Volume of the tank (m³); infinite: a regulated supply, whose pressure and temperature stay.
    pub tank: f64,
    /// Its wall.
    pub wall: Wall,
    /// Between the tank and the manifold that all lines begin at; none: no resistance.
    pub outlet: Option<Passage>,
    /// The lines.
    pub lines: Vec<Line>,
}

/// The gas of a tank with its lines, and what went in and out.
#[derive(Clone, Debug, PartialEq)]
pub struct Stock {
    /// Of the tank.
    pub tank: Store,
    /// Of each line with its chamber.
    pub lines: Vec<Store>,
    /// Pressure (Pa) of the manifold.
    pub manifold: f64,
    /// Gone to the atmosphere: mass (kg), and enthalpy (J) as its energy; below 0 where more came in.
    pub vented: Store,
    /// Heat (J) from the walls.
    pub heat: f64,
    /// Work (J) of the chambers, ∫ P dV.
    pub work: f64,
}

/// Rates of a stock: mass (kg/s) and energy (W).
struct Rates {
    tank: Store,
    lines: Vec<LineRates>,
    vented: Store,
    manifold: f64,
}

/// Rates of a line, and the pressure (Pa) and temperature (K) that they hold at.
struct LineRates {
    state: [f64; 2],
    store: Store,
}

/// `store` after `h` (s) at `rates`.
fn after(store: Store, rates: Store, h: f64) -> Store {
    Store {
        mass: store.mass + h * rates.mass,
        energy: store.energy + h * rates.energy,
    }
}

impl Store {
    fn add(&mut self, flow: f64, enthalpy: f64) {
        self.mass += flow;
        self.energy += flow * enthalpy;
    }
}

impl Supply {
    /// Heat capacity at constant volume (J/(kg K)).
    fn capacity(&self) -> f64 {
        self.gas.constant / (self.gas.heat_ratio - 1.0)
    }

    /// Volume (m³) that the store of the tank is of.
    fn tank_size(&self) -> f64 {
        if self.tank.is_finite() {
            self.tank
        } else {
            1.0
        }
    }

    /// What a volume (m³) holds at a pressure (Pa) and temperature (K).
    pub fn store(&self, volume: f64, [pressure, temperature]: [f64; 2]) -> Store {
        Store {
            mass: pressure * volume / (self.gas.constant * temperature),
            energy: pressure * volume / (self.gas.heat_ratio - 1.0),
        }
    }

    /// Pressure (Pa) and temperature (K) of gas in a volume (m³).
    pub fn state(&self, store: Store, volume: f64) -> [f64; 2] {
        [
            (self.gas.heat_ratio - 1.0) * store.energy / volume,
            store.energy / (store.mass * self.capacity()),
        ]
    }

    /// The tank at a pressure and temperature (Pa, K), and lines of these volumes (m³) at each of
    /// theirs. Of an infinite tank the store is what one cubic metre of it holds.
    pub fn stock(&self, tank: [f64; 2], lines: &[(f64, [f64; 2])]) -> Stock {
        Stock {
            tank: self.store(self.tank_size(), tank),
            lines: lines
                .iter()
                .map(|(volume, state)| self.store(*volume, *state))
                .collect(),
            manifold: tank[0],
            vented: Store::default(),
            heat: 0.0,
            work: 0.0,
        }
    }

    /// Pressure (Pa) and temperature (K) in the tank.
    pub fn tank_state(&self, stock: &Stock) -> [f64; 2] {
        self.state(stock.tank, self.tank_size())
    }

    /// Goes on by `h` (s) with the volumes (m³) of the lines at the start, in the middle and at the
    /// end, and the valves as they are in the middle: the midpoint rule, and heat from the walls
    /// implicitly, so that a wall without resistance is no special case. Errors fall with the
    /// square of `h`. In a step no volume may lose or gain more than a small part of its gas: far
    /// longer steps give numbers below 0 or NaN.
    pub fn advance(&self, stock: &mut Stock, h: f64, volumes: [&[f64]; 3], valves: &[Opening]) {
        let first = self.rates(stock, volumes[0], valves);
        let mut middle = stock.clone();
        self.take(&mut middle, &first, 0.5 * h, [volumes[0], volumes[1]]);
        let second = self.rates(&middle, volumes[1], valves);
        // The pressure in the middle does the work of the whole step.
        self.take(stock, &second, h, [volumes[0], volumes[2]]);
    }

    /// Takes `h` (s) of `rates`, the work of the chambers at their pressures, and the heat.
    fn take(&self, stock: &mut Stock, rates: &Rates, h: f64, [from, to]: [&[f64]; 2]) {
        stock.manifold = rates.manifold;
        stock.vented = after(stock.vented, rates.vented, h);
        if self.tank.is_finite() {
            let now = after(stock.tank, rates.tank, h);
            let heat = self.heat([stock.tank, now], self.wall, h);
            stock.tank = now;
            stock.tank.energy += heat;
            stock.heat += heat;
        }
        for (i, line) in self.lines.iter().enumerate() {
            let work = rates.lines[i].state[0] * (to[i] - from[i]);
            let mut now = after(stock.lines[i], rates.lines[i].store, h);
            now.energy -= work;
            let heat = self.heat([stock.lines[i], now], line.wall, h);
            now.energy += heat;
            stock.lines[i] = now;
            stock.work += work;
            stock.heat += heat;
        }
    }

    /// Heat (J) from a wall in `h` (s), in which a store would go `from` one `to` another without.
    ///
    /// The energy above that of gas as warm as the wall, W = U − m c T, obeys
    /// W' = S − W/(R m c) with S and m as they are on average, and 1/(1 + x + x²/2) for exp(−x):
    /// as accurate as the midpoint rule, and 0 where the wall has no resistance.
    fn heat(&self, [from, to]: [Store; 2], wall: Wall, h: f64) -> f64 {
        if wall.resistance == f64::INFINITY || h == 0.0 {
            return 0.0;
        }
        let capacity = self.capacity();
        let above = |store: Store| store.energy - store.mass * capacity * wall.temperature;
        let (start, gain) = (above(from), above(to) - above(from));
        // The time constant over h, 1/x.
        let slow = wall.resistance * capacity * 0.5 * (from.mass + to.mass) / h;
        -((slow + 0.5) * start + 0.5 * (slow + 1.0) * gain) / (slow * slow + slow + 0.5)
    }

    fn rates(&self, stock: &Stock, volumes: &[f64], valves: &[Opening]) -> Rates {
        let enthalpy = self.gas.heat_ratio * self.capacity();
        let tank = self.tank_state(stock);
        let mut lines: Vec<LineRates> = (0..self.lines.len())
            .map(|i| LineRates {
                state: self.state(stock.lines[i], volumes[i]),
                store: Store::default(),
            })
            .collect();
        let manifold = self.manifold(stock.manifold, tank, &lines, valves);
        // What flows from the lines into the manifold mixes there with what the tank gives.
        let (mut drawn, mut inflow, mut heat) = (0.0, 0.0, 0.0);
        for (i, line) in lines.iter_mut().enumerate() {
            let flow = self.drawn(i, [manifold, tank[1]], line.state, valves);
            line.store.mass = flow;
            drawn += flow;
            inflow += (-flow).max(0.0);
            heat += (-flow).max(0.0) * line.state[1];
        }
        if drawn > 0.0 {
            inflow += drawn;
            heat += drawn * tank[1];
        }
        let mixed = if inflow > 0.0 { heat / inflow } else { tank[1] };
        let mut rates = Rates {
            tank: Store::default(),
            lines,
            vented: Store::default(),
            manifold,
        };
        let leaving = if drawn > 0.0 { tank[1] } else { mixed };
        rates.tank.add(-drawn, enthalpy * leaving);
        for (i, LineRates { state, store }) in rates.lines.iter_mut().enumerate() {
            let at = if store.mass > 0.0 { mixed } else { state[1] };
            store.energy = store.mass * enthalpy * at;
            let line = &self.lines[i];
            let openings = [(Some(line.vent), valves[i].vent), (line.leak, 1.0)];
            for (passage, open) in openings {
                let Some(passage) = passage.filter(|_| open > 0.0) else {
                    continue;
                };
                let out = open * signed(&passage, *state, self.ambient);
                let at = enthalpy * if out > 0.0 { state[1] } else { self.ambient[1] };
                store.add(-out, at);
                rates.vented.add(out, at);
            }
        }
        rates
    }

    /// Mass flow (kg/s) from the manifold to the line `i` at these pressures and temperatures
    /// (Pa, K).
    fn drawn(&self, i: usize, manifold: [f64; 2], line: [f64; 2], valves: &[Opening]) -> f64 {
        if valves[i].fill > 0.0 {
            valves[i].fill * signed(&self.lines[i].fill, manifold, line)
        } else {
            0.0
        }
    }

    /// Pressure (Pa) of the manifold, at which as much flows in from the tank as out to the lines;
    /// `near` is where the search starts.
    fn manifold(&self, near: f64, tank: [f64; 2], lines: &[LineRates], valves: &[Opening]) -> f64 {
        /// Far more than a search takes.
        const ROUNDS: usize = 100;
        let Some(outlet) = self.outlet else {
            return tank[0];
        };
        let open = lines
            .iter()
            .zip(valves)
            .filter(|(_, valve)| valve.fill > 0.0);
        let (mut low, mut high) = open.fold((tank[0], tank[0]), |(low, high), (line, _)| {
            (low.min(line.state[0]), high.max(line.state[0]))
        });
        if low == high {
            return low;
        }
        // What flows in, less what flows out, falls with the pressure; and all that flows.
        let surplus = |pressure: f64| {
            let inflow = signed(&outlet, tank, [pressure, tank[1]]);
            let (mut left, mut all) = (inflow, inflow.abs());
            for (i, line) in lines.iter().enumerate() {
                let flow = self.drawn(i, [pressure, tank[1]], line.state, valves);
                left -= flow;
                all += flow.abs();
            }
            (left, all)
        };
        // Secants, and a bisection where they leave the bracket. Newton's steps would go to and fro
        // where two pressures are almost one: flow goes by the root of their difference.
        let mut at = near.max(low).min(high);
        let mut last = at + 1e-6 * (high - low);
        let mut before = surplus(last).0;
        for _ in 0..ROUNDS {
            let (here, all) = surplus(at);
            if here.is_nan() || here.abs() <= 1e-9 * all {
                break;
            }
            if here > 0.0 {
                low = at;
            } else {
                high = at;
            }
            let mut next = at - here * (at - last) / (here - before);
            if !(low..=high).contains(&next) {
                next = low.midpoint(high);
            }
            if next == at || high - low <= f64::EPSILON * high {
                break;
            }
            (last, before, at) = (at, here, next);
        }
        at
    }
}

/// Mass flow (kg/s) from `a` to `b` (Pa, K); negative backwards.
fn signed(passage: &Passage, a: [f64; 2], b: [f64; 2]) -> f64 {
    if a[0] >= b[0] {
        passage.flow(a, b[0])
    } else {
        -passage.flow(b, a[0])
    }
}
