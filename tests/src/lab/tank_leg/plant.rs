//! A jumper with its gas: a tank feeds the muscles of hips and knees through valves and tubes.
//!
//! Both sides do the same, so that one of each pair of muscles stands for both.

use super::super::motion::{AMBIENT, nozzle, rk4};
use super::gas::{Flow, Gas, Room, Tube, Wall};
use super::jumper::{Ground, Jumper};
use super::muscle::{Muscle, Shape};

/// Time (s) in which a muscle takes the shape of its pressure.
const SHAPE: f64 = 1e-3;
/// Opening of a valve below which it is shut.
const SHUT: f64 = 1e-6;

/// Place and rate of the robot; pressure and temperature (Pa, K) of the tank, of the hips' and of
/// the knees' rooms, each with the pressure (Pa, gauge) that its muscle has the shape of; what went
/// to the atmosphere: mass (kg) and enthalpy (J).
pub(super) type State = [f64; 16];

/// A robot with its gas.
#[derive(Clone, Debug)]
pub(super) struct Plant {
    pub jumper: Jumper,
    pub muscle: Muscle,
    pub gas: Gas,
    /// Temperature (K) of all walls and of the atmosphere.
    pub warm: f64,
    pub tank: f64,
    /// Thermal resistance (K/W) of the walls of the tank and of a muscle with its tube.
    pub walls: [f64; 2],
    pub tube: Tube,
    /// Volume (m³) of a tube with what is beside it.
    pub dead: f64,
    /// How much more than a smooth tube a line lets through, inwards and to the air.
    pub shares: [f64; 2],
    /// Fall of the square of the pressure behind the tank in terms of that along a tube.
    pub outlet: f64,
    /// Effective area (m²) of a leak of each muscle.
    pub leak: f64,
    /// What a compressor feeds into the tank (kg/s).
    pub feed: f64,
    /// Radius (m) of the pulleys of hips and knees, and compliance (m/N) of their tendons.
    pub pulleys: [f64; 2],
    pub tendons: [f64; 2],
    /// Time constant (s) of the valves, and lags (s) of opening, closing and venting.
    pub spool: f64,
    pub lags: [f64; 3],
    /// Time (s) in which the valves open wide.
    pub ramp: f64,
    /// When (s) the valves close, and when all muscles are vented.
    pub until: f64,
    pub exhaust: f64,
    /// Angles at the start.
    pub start: [f64; 2],
}

/// A pair of muscles in motion.
struct Pair {
    room: Room,
    pull: f64,
    /// How fast its shape follows (Pa/s).
    follows: f64,
}

/// What all of the plant does.
struct Doing {
    rates: State,
    manifold: f64,
}

impl Plant {
    /// At rest, with the tank at a gauge pressure (Pa).
    pub(super) fn at_rest(&self, place: [f64; 3], tank: f64) -> State {
        let [y, thigh, shank] = place;
        let (air, warm) = (AMBIENT, self.warm);
        let line = [air, warm, 0.0];
        let mut state = [0.0; 16];
        state[..3].copy_from_slice(&[y, thigh, shank]);
        state[6..8].copy_from_slice(&[tank + AMBIENT, warm]);
        state[8..11].copy_from_slice(&line);
        state[11..14].copy_from_slice(&line);
        state
    }

    /// How far a valve lets gas in and out at `t`.
    fn valves(&self, t: f64) -> [f64; 2] {
        let turned = |at: f64| 1.0 / (1.0 + (-(t - at) / self.spool).exp());
        let [opens, closes, vents] = self.lags;
        let wide = if self.ramp > 0.0 {
            ((t - opens) / self.ramp).clamp(0.0, 1.0)
        } else {
            turned(opens)
        };
        let out = turned(self.exhaust + vents);
        let into = (wide - turned(self.until + closes)) * (1.0 - out);
        [into, out].map(|x| if x < SHUT { 0.0 } else { x })
    }

    /// Muscle `k` of hips (0) or knees (1), before gas flows.
    fn pair(&self, k: usize, state: &State) -> Pair {
        let ([pressure, temperature, felt], side) = (
            [state[8 + 3 * k], state[9 + 3 * k], state[10 + 3 * k]],
            [1.0, -1.0][k],
        );
        let angles = [state[1], state[2] - state[1]];
        let turns = [state[4], state[5] - state[4]];
        let reach = side * self.pulleys[k];
        let travel = [reach * (angles[k] - self.start[k]), reach * turns[k]];
        let compliance = self.tendons[k];
        let x = self.muscle.through(compliance, travel[0], felt);
        let Shape {
            pull,
            pull_by,
            volume,
            volume_by,
        } = self.muscle.at(x, felt);
        let follows = (pressure - AMBIENT - felt) / SHAPE;
        let comes_in =
            (travel[1] + compliance * pull_by[1] * follows) / (1.0 - compliance * pull_by[0]);
        let grows = volume_by[0] * comes_in + volume_by[1] * follows;
        Pair {
            room: Room {
                pressure,
                temperature,
                volume: [self.dead + volume, grows],
            },
            pull,
            follows,
        }
    }

    /// Pressure (Pa) behind the tank's outlet, at which as much comes from the tank as goes to the
    /// lines, which are open by `open`.
    fn manifold(&self, tank: f64, lines: [f64; 2], open: f64) -> f64 {
        if self.outlet == 0.0 || open == 0.0 {
            return tank;
        }
        let surplus = |p: f64| {
            let drawn: f64 = lines.iter().map(|line| self.into(p, *line, open)).sum();
            self.tube.flow((tank * tank - p * p) / self.outlet) - 2.0 * drawn
        };
        let (mut low, mut high) = (
            lines[0].min(lines[1]).min(tank),
            lines[0].max(lines[1]).max(tank),
        );
        // The false position of Illinois.
        let (mut at_low, mut at_high) = (surplus(low), surplus(high));
        let mut p = high;
        for _ in 0..60 {
            if at_low <= at_high || high - low < 1e-4 {
                break;
            }
            p = ((low * at_high - high * at_low) / (at_high - at_low)).clamp(low, high);
            let here = surplus(p);
            if here > 0.0 {
                (low, at_low, at_high) = (p, here, 0.5 * at_high);
            } else {
                (high, at_high, at_low) = (p, here, 0.5 * at_low);
            }
            if here.abs() < 1e-12 {
                break;
            }
        }
        p
    }

    /// Mass flow (kg/s) into a line from a pressure (Pa).
    fn into(&self, from: f64, line: f64, open: f64) -> f64 {
        open * self.shares[0] * self.tube.flow(from * from - line * line)
    }

    fn doing(&self, t: f64, state: &State, ground: &Ground) -> Doing {
        let [open, vent] = self.valves(t);
        let pairs = [0, 1].map(|k| self.pair(k, state));
        let tank = Room {
            pressure: state[6],
            temperature: state[7],
            volume: [self.tank, 0.0],
        };
        let pressures = [0, 1].map(|k| pairs[k].room.pressure);
        let manifold = self.manifold(tank.pressure, pressures, open);
        let drawn = pressures.map(|p| self.into(manifold, p, open));
        // Lines that give gas back and the tank mix in the manifold.
        let from_tank = 2.0 * (drawn[0] + drawn[1]);
        let given = |k: usize| (2.0 * (-drawn[k]).max(0.0), pairs[k].room.temperature);
        let sources = [(from_tank.max(0.0), tank.temperature), given(0), given(1)];
        let all: f64 = sources.iter().map(|s| s.0).sum();
        let mixed = if all > 0.0 {
            sources.iter().map(|s| s.0 * s.1).sum::<f64>() / all
        } else {
            tank.temperature
        };
        let mut rates = [0.0; 16];
        for (k, pair) in pairs.iter().enumerate() {
            let Room {
                pressure,
                temperature,
                ..
            } = pair.room;
            let of = |flow: f64, other: f64| (flow, if flow > 0.0 { other } else { temperature });
            let fall = AMBIENT * AMBIENT - pressure * pressure;
            let aired = vent * self.shares[1] * self.tube.flow(fall)
                - nozzle(self.leak, self.gas, temperature, pressure, AMBIENT);
            let flows: [Flow; 2] = [of(drawn[k], mixed), of(aired, self.warm)];
            let [p, t] = pair
                .room
                .rates(self.gas, &flows, Wall(self.warm, self.walls[1]));
            rates[8 + 3 * k..11 + 3 * k].copy_from_slice(&[p, t, pair.follows]);
            rates[14] -= 2.0 * aired;
            rates[15] -= 2.0 * aired * flows[1].1 * self.heat_capacity();
        }
        let leaves = if from_tank > 0.0 {
            tank.temperature
        } else {
            mixed
        };
        let flows = [(-from_tank, leaves), (self.feed, self.warm)];
        let of_tank = tank.rates(self.gas, &flows, Wall(self.warm, self.walls[0]));
        rates[6..8].copy_from_slice(&of_tank);
        let pulls = [0, 1].map(|k| self.pulleys[k] * pairs[k].pull);
        let (place, rate) = robot(state);
        rates[..3].copy_from_slice(&rate);
        rates[3..6].copy_from_slice(&self.jumper.accelerations(place, rate, pulls, ground));
        Doing { rates, manifold }
    }

    /// At constant pressure (J/(kg K)).
    fn heat_capacity(&self) -> f64 {
        self.gas.0 * self.gas.1 / (self.gas.0 - 1.0)
    }

    /// Goes on by `h` (s).
    pub(super) fn go(&self, t: f64, state: &mut State, ground: &mut Ground, h: f64) {
        let held = *ground;
        *state = rk4(|t, y| self.doing(t, y, &held).rates, t, state, h);
        let (place, rate) = robot(state);
        self.jumper.settle(place, rate, ground);
    }

    /// What gauges show at `t`: the tank behind its outlet, hips, knees (Pa), and the height of the
    /// centre of mass (m).
    pub(super) fn shown(&self, t: f64, state: &State, ground: &Ground) -> [f64; 4] {
        let manifold = self.doing(t, state, ground).manifold;
        let (place, _) = robot(state);
        [
            manifold - AMBIENT,
            state[8] - AMBIENT,
            state[11] - AMBIENT,
            self.jumper.centre(place),
        ]
    }
}

/// Place and rate of the robot.
pub(super) fn robot(state: &State) -> ([f64; 3], [f64; 3]) {
    (
        [state[0], state[1], state[2]],
        [state[3], state[4], state[5]],
    )
}

#[cfg(test)]
mod tests {
    use super::super::jumper::{Joint, Link};
    use super::super::muscle::rising_to;
    use super::*;

    fn plant() -> Plant {
        let joint = Joint {
            spring: [2.0, -1.5],
            damping: 0.03,
            friction: 0.1,
        };
        let link = |mass| Link { mass, length: 0.55 };
        let reach = vec![0.03, 7.5e-7, -4.9e-12, 1.4e-17, -1.5e-23];
        let tube = Tube {
            length: 1.5,
            diameter: 4e-3,
            roughness: 1e-5,
            energy: 287.05 * 293.0,
        };
        Plant {
            jumper: Jumper {
                links: [link(1.0), link(0.5), link(0.3)],
                radius: 0.02,
                joints: [joint; 2],
                grip: 0.9,
            },
            muscle: Muscle {
                volume: 4.2e-5,
                pull: 1.95e-3,
                slope: 0.035,
                rises_to: rising_to(&reach),
                reach,
                bulge: 0.0,
            },
            gas: (1.4, 287.05),
            warm: 293.0,
            tank: 1.5e-3,
            walls: [f64::INFINITY; 2],
            dead: tube.volume(),
            tube,
            shares: [1.0, 0.8],
            outlet: 0.02,
            leak: 1e-7,
            feed: 0.0,
            pulleys: [0.045; 2],
            tendons: [1.0 / 12e3; 2],
            spool: 1e-3,
            lags: [2e-3, 3e-3, 4e-3],
            ramp: 0.0,
            until: 0.08,
            exhaust: 0.3,
            start: [-2.5, 2.7],
        }
    }

    /// The states every 0.1 s of 0.5 s, in steps of `h` (s).
    fn course(plant: &Plant, h: f64) -> Vec<State> {
        let place = [0.0, -2.5, 0.2];
        let mut state = plant.at_rest(place, 450e3);
        let mut ground = plant.jumper.stand(place);
        plant.jumper.settle(place, [0.0; 3], &mut ground);
        let mut all = vec![state];
        let mut t = 0.0;
        for part in 1..=5 {
            while t < 0.1 * f64::from(part) - 0.5 * h {
                plant.go(t, &mut state, &mut ground, h);
                t += h;
            }
            all.push(state);
        }
        all
    }

    /// Mass (kg) and inner energy (J) of all gas, with what went to the air.
    fn stock(plant: &Plant, state: &State) -> [f64; 2] {
        let pairs = [0, 1].map(|k| plant.pair(k, state).room);
        let tank = Room {
            pressure: state[6],
            temperature: state[7],
            volume: [plant.tank, 0.0],
        };
        let rooms = [(tank, 1.0), (pairs[0], 2.0), (pairs[1], 2.0)];
        let sum = |of: &dyn Fn(&Room) -> f64| -> f64 {
            rooms.iter().map(|(room, count)| count * of(room)).sum()
        };
        [
            sum(&|room| room.pressure * room.volume[0] / (plant.gas.1 * room.temperature))
                + state[14],
            sum(&|room| room.pressure * room.volume[0] / (plant.gas.0 - 1.0)) + state[15],
        ]
    }

    /// Gas goes from the tank to muscles that move, and to the air, and none is lost.
    #[test]
    fn the_mass_of_the_gas_stays() {
        for walls in [[f64::INFINITY; 2], [0.01, 0.05]] {
            let plant = Plant { walls, ..plant() };
            let all = course(&plant, 1e-4);
            let [whole, _] = stock(&plant, &all[0]);
            for state in &all {
                let [mass, _] = stock(&plant, state);
                // What steps leave out.
                assert!(
                    (mass / whole - 1.0).abs() < 1e-6,
                    "{walls:?}: {mass} {whole}"
                );
            }
            assert!(all[5][14] > 0.05 * whole, "much of it goes: {}", all[5][14]);
        }
    }

    /// Muscles that cannot move do no work, and without heat all energy is in the gas.
    #[test]
    fn the_energy_of_the_gas_stays() {
        let plant = Plant {
            pulleys: [0.0; 2],
            tendons: [0.0; 2],
            ..plant()
        };
        let all = course(&plant, 1e-4);
        let [_, whole] = stock(&plant, &all[0]);
        for state in &all {
            let [_, energy] = stock(&plant, state);
            assert!((energy / whole - 1.0).abs() < 1e-6, "{energy} {whole}");
        }
        // It is cold in the tank, and was warm in muscles.
        assert!(all[2][7] < 285.0 && all[2][9] > 320.0, "{:?}", all[2]);
    }

    /// Steps that are half as long tell nearly the same; so nearly that noise is 1000 times as large.
    #[test]
    fn steps_are_short_enough() {
        let plant = plant();
        let [coarse, fine] = [1e-4, 5e-5].map(|h| course(&plant, h));
        for (a, b) in coarse.iter().zip(&fine) {
            for k in [6, 8, 11] {
                assert!((a[k] - b[k]).abs() < 1.0, "{k}: {} {}", a[k], b[k]);
            }
            let centre = |state: &State| plant.jumper.centre(robot(state).0);
            assert!(
                (centre(a) - centre(b)).abs() < 2e-6,
                "{} {}",
                centre(a),
                centre(b)
            );
        }
        assert!(fine[2][0] > 0.3, "it jumps: {}", fine[2][0]);
    }
}
