//! One cylinder upright, fired once from rest under a dead load.
//!
//! State: extension d (m), its rate (m/s), pressure P (Pa). The rod is held by dry friction, moves,
//! or is at its end stop, where it stays. Steps are short and of one length; break-away, reversals
//! and the stop are found by halving the step that meets them.

use std::f64::consts::PI;

use saltus_robot::{Robot, Term};

use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::{AIR, AMBIENT, CARBON_DIOXIDE, GRAVITY, PSI, first, nozzle, rk4};
use super::sensing::Column;
use super::{Exact, World};

pub(super) const CAUSES: &[&str] = &[
    "supply-pressure",
    "supply-droop",
    "valve-delay",
    "valve-discharge",
    "chamber-leak",
    "dead-volume",
    "viscous-friction",
    "coulomb-friction",
    "seal-friction",
    "return-spring",
    "gas-type",
    "exhaust-port",
    "heat-transfer",
    "mass",
    "encoder-scale",
    "sensor-offset",
    "sensor-delay",
];

pub(super) const OUTSIDE: &[&str] = &[
    "quadratic-friction",
    "position-friction",
    "stroke-leak",
    "valve-ramp",
    "ripple",
    "gear-ripple",
    "saturation",
];

const STROKE: f64 = 0.06;
const BORE: f64 = 0.01905;
const ORIFICE: f64 = PI * 1.0215e-3 * 1.0215e-3;
const TEMPERATURE: f64 = 293.15;
const STEP: f64 = 5e-5;

/// What the operator set.
#[derive(Clone, Copy, Debug)]
struct Setting {
    load: f64,
    supply: f64,
    on: f64,
    off: Option<f64>,
}

/// Some firings of one cylinder.
pub(super) struct Bench {
    columns: [Column; 2],
    settings: Vec<Setting>,
    /// Rows a second.
    rate: f64,
    length: f64,
}

impl Bench {
    pub(super) fn new(draw: &mut Draw) -> Bench {
        let mut position = Column::noisy("position_m", 1e-4);
        if draw.chance(0.4) {
            position.resolution = draw.one(&[1e-4, 2e-4]);
            position.noise = if draw.chance(0.5) { 0.0 } else { 3e-5 };
        }
        let runs = draw.one(&[10, 12, 14]);
        let settings = (0..runs).map(|_| {
            let off = draw
                .chance(0.3)
                .then(|| (draw.between(0.125, 0.135) * 1e3).round() * 1e-3);
            Setting {
                load: (draw.between(1.2, 4.0) * 1e3).round() * 1e-3,
                supply: draw.one(&[60.0, 70.0, 80.0, 90.0, 100.0, 110.0, 120.0]) * PSI,
                on: draw.one(&[0.005, 0.01]),
                off,
            }
        });
        let settings = settings.collect();
        Bench {
            columns: [position, Column::noisy("pressure_pa", 2e3)],
            settings,
            rate: draw.one(&[1000.0, 2000.0]),
            length: 0.15,
        }
    }
}

impl World for Bench {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.settings.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        runs.iter()
            .map(|run| Some(self.fire(&self.settings[*run], hidden)))
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        match id {
            "mass" => Some(vec![Dial::up_to(
                "load_mass_added_kg",
                draw.one(&[-0.6, 1.0]),
            )]),
            "quadratic-friction" => Some(vec![Dial::up_to("quadratic_friction_n_s2_per_m2", 40.0)]),
            "position-friction" => Some(vec![
                Dial::up_to("tight_spot_n", 60.0),
                Dial::fixed("tight_spot_m", draw.between(0.02, 0.045)),
            ]),
            "stroke-leak" => Some(vec![Dial::up_to("stroke_leak_m", 5e-5)]),
            "valve-ramp" => Some(vec![Dial::up_to("valve_ramp_s", 0.03)]),
            _ => leg(id, draw),
        }
    }

    fn robot(&self) -> Option<&'static str> {
        Some("rats-boom")
    }
}

/// The number of the robot that the effect `id` changes, from the table of terms: from what it is
/// on `rats-boom` to one of the values that the table has for it.
pub(super) fn of_table(id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
    let is_meant = |term: &&Term| {
        let spec = term.spec();
        !spec.hidden.is_empty() && spec.cause.is_some_and(|cause| cause.id == id)
    };
    let term = Term::ALL.iter().find(is_meant)?;
    let robot = Robot::builtin("rats-boom").expect("built in");
    let now = term.of(&robot).or(term.off(&robot)).unwrap_or(0.0);
    let most = match term.spec().hidden {
        [most] => *most,
        several => draw.one(several),
    };
    Some(vec![Dial::linear(term.key(&robot), now, most)])
}

/// The numbers of the leg that the effect `id` changes: keys of the robot file.
pub(super) fn leg(id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
    Some(match id {
        // An offset of every set value.
        "supply-pressure" => vec![Dial::up_to(
            "supply_pressure_offset_pa",
            draw.one(&[-2e5, 2e5]),
        )],
        "return-spring" => {
            // Up to what friction holds in the air at the end of the stroke.
            let preload = draw.between(1.0, 8.0);
            vec![
                Dial::up_to(
                    "leg.return_spring.stiffness_n_per_m",
                    (9.2 - preload) / STROKE,
                ),
                Dial::up_to("leg.return_spring.preload_n", preload),
            ]
        }
        "gas-type" => vec![
            Dial::fixed("leg.gas.heat_ratio", CARBON_DIOXIDE.0),
            Dial::fixed("leg.gas.constant_j_per_kg_k", CARBON_DIOXIDE.1),
        ],
        "exhaust-port" => vec![
            Dial::fixed("leg.exhaust_port.position_m", draw.between(0.025, 0.042)),
            Dial::up_to("leg.exhaust_port.area_m2", 6e-6),
        ],
        _ => return of_table(id, draw),
    })
}

/// What the rod does.
#[derive(Clone, Copy, PartialEq)]
enum Rod {
    Held,
    /// Upwards (1) or downwards (−1).
    Moving(f64),
    AtStop,
}

/// Every number of a firing.
struct Plant {
    load: f64,
    supply: f64,
    open: (f64, f64),
    ramp: f64,
    valve: f64,
    dead_volume: f64,
    viscous: f64,
    quadratic: f64,
    coulomb: f64,
    tight: (f64, f64),
    seal: f64,
    spring: (f64, f64),
    gas: (f64, f64),
    exponent: f64,
    droop: f64,
    leak: f64,
    leak_along: f64,
    port: Option<(f64, f64)>,
}

const AREA: f64 = PI / 4.0 * BORE * BORE;

impl Plant {
    fn new(setting: &Setting, h: &Hidden) -> Plant {
        let gas = (
            h.get("leg.gas.heat_ratio", AIR.0),
            h.get("leg.gas.constant_j_per_kg_k", AIR.1),
        );
        let delay = h.get("leg.valve_delay_s", 0.01);
        let port = h.or_zero("leg.exhaust_port.area_m2");
        Plant {
            load: setting.load + h.or_zero("load_mass_added_kg"),
            supply: setting.supply + AMBIENT + h.or_zero("supply_pressure_offset_pa"),
            open: (
                setting.on + delay,
                setting.off.map_or(f64::INFINITY, |off| off + delay),
            ),
            ramp: h.or_zero("valve_ramp_s"),
            valve: h.get("leg.discharge_coefficient", 0.5378) * ORIFICE,
            dead_volume: h.get("leg.dead_volume_m3", 5.4e-6),
            viscous: h.get("leg.viscous_friction_n_s_per_m", 5.2843),
            quadratic: h.or_zero("quadratic_friction_n_s2_per_m2"),
            coulomb: h.get("leg.coulomb_friction_n", 9.7003),
            tight: (h.or_zero("tight_spot_n"), h.or_zero("tight_spot_m")),
            seal: h.or_zero("leg.seal_friction_n_per_pa"),
            spring: (
                h.or_zero("leg.return_spring.stiffness_n_per_m"),
                h.or_zero("leg.return_spring.preload_n"),
            ),
            gas,
            exponent: h.get("leg.polytropic_exponent", gas.0).min(gas.0),
            droop: h.or_zero("leg.supply_droop_pa_s_per_kg"),
            leak: h.or_zero("leg.leak_area_m2"),
            leak_along: h.or_zero("stroke_leak_m"),
            port: (port > 0.0).then(|| (h.or_zero("leg.exhaust_port.position_m"), port)),
        }
    }

    /// Force (N) on the load without dry friction, and the dry friction that there is.
    fn forces(&self, [d, v, p]: &[f64; 3]) -> (f64, f64) {
        let gauge = p - AMBIENT;
        let tight = self.tight.0 * (-((d - self.tight.1) / 0.004).powi(2)).exp();
        let dry = self.coulomb + self.seal * gauge.abs() + tight;
        let spring = self.spring.0 * d + self.spring.1;
        let free = gauge * AREA
            - spring
            - (self.viscous + self.quadratic * v.abs()) * v
            - self.load * GRAVITY;
        (free, dry)
    }

    fn rates(&self, rod: Rod, energized: bool, t: f64, y: &[f64; 3]) -> [f64; 3] {
        let (speed, acceleration) = match rod {
            Rod::Moving(way) => {
                let (free, dry) = self.forces(y);
                (y[1], (free - way * dry) / self.load)
            }
            _ => (0.0, 0.0),
        };
        [
            speed,
            acceleration,
            self.pressure_rate(energized, t, y[0], speed, y[2]),
        ]
    }

    fn pressure_rate(&self, energized: bool, t: f64, d: f64, speed: f64, p: f64) -> f64 {
        let volume = self.dead_volume + AREA * d;
        let flow = |area: f64, up: f64, down: f64| nozzle(area, self.gas, TEMPERATURE, up, down);
        let mut inflow = if energized {
            let part = if self.ramp > 0.0 {
                ((t - self.open.0) / self.ramp).clamp(0.0, 1.0)
            } else {
                1.0
            };
            self.supplied(|supply| flow(part * self.valve, supply, p))
        } else {
            flow(self.valve, AMBIENT, p)
        };
        inflow -= flow(self.leak + self.leak_along * d, p, AMBIENT);
        if let Some((position, area)) = self.port
            && d > position
        {
            inflow -= flow(area, p, AMBIENT);
        }
        self.exponent * (self.gas.1 * TEMPERATURE * inflow - p * AREA * speed) / volume
    }

    /// The flow that a supply gives whose pressure falls with it.
    fn supplied(&self, flow: impl Fn(f64) -> f64) -> f64 {
        let most = flow(self.supply);
        if self.droop == 0.0 || most <= 0.0 {
            return most;
        }
        let (mut low, mut high) = (0.0, most);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if flow(self.supply - self.droop * middle) > middle {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    }

    /// What a rod at rest does next.
    fn released(&self, y: &[f64; 3]) -> Rod {
        let (free, dry) = self.forces(y);
        if free > dry {
            Rod::Moving(1.0)
        } else if free < -dry && y[0] > 0.0 {
            Rod::Moving(-1.0)
        } else {
            Rod::Held
        }
    }

    /// Goes on by `h` seconds without a switch of the valve.
    fn go(&self, rod: &mut Rod, mut t: f64, y: &mut [f64; 3], mut h: f64) {
        // No switch is within.
        let energized = (self.open.0..self.open.1).contains(&(t + 0.5 * h));
        // Each part ends where the rod breaks away, stops or turns.
        for _ in 0..8 {
            if *rod == Rod::Held {
                *rod = self.released(y);
            }
            let after = |h: f64| rk4(|t, y| self.rates(*rod, energized, t, y), t, y, h);
            let changed = |y: &[f64; 3]| match *rod {
                Rod::Held => self.released(y) != Rod::Held,
                Rod::Moving(way) => y[0] >= STROKE || y[0] < 0.0 || way * y[1] < 0.0,
                Rod::AtStop => false,
            };
            let next = after(h);
            if !changed(&next) {
                *y = next;
                return;
            }
            let part = first(h, |h| changed(&after(h)));
            *y = after(part);
            *rod = match *rod {
                Rod::Moving(_) if y[0] >= STROKE => Rod::AtStop,
                Rod::Moving(_) => Rod::Held,
                rod => rod,
            };
            if *rod == Rod::AtStop {
                y[0] = STROKE;
            }
            (y[0], y[1]) = (
                y[0].max(0.0),
                if matches!(*rod, Rod::Moving(_)) {
                    y[1]
                } else {
                    0.0
                },
            );
            t += part;
            h -= part;
        }
        *y = rk4(|t, y| self.rates(*rod, energized, t, y), t, y, h);
    }
}

impl Bench {
    fn fire(&self, setting: &Setting, hidden: &Hidden) -> Exact {
        let plant = Plant::new(setting, hidden);
        let (mut rod, mut y, mut now) = (Rod::Held, [0.0, 0.0, AMBIENT], 0.0);
        #[allow(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "a few hundred"
        )]
        let rows = (self.length * self.rate).round() as usize + 1;
        let time: Vec<f64> = (0..rows).map(|i| i as f64 / self.rate).collect();
        let mut values = vec![Vec::new(); 2];
        for &at in &time {
            while now < at {
                let switches = [plant.open.0, plant.open.1]
                    .into_iter()
                    .filter(|t| *t > now);
                let next = switches.fold(at.min(now + STEP), f64::min);
                plant.go(&mut rod, now, &mut y, next - now);
                now = next;
            }
            values[0].push(y[0]);
            values[1].push(y[2]);
        }
        let settings = [
            ("load_mass_kg", setting.load),
            ("supply_pressure_gauge_pa", setting.supply),
        ];
        let settings = settings.map(|(key, value)| (key.to_owned(), value)).into();
        Exact {
            settings,
            valve: Some((setting.on, setting.off)),
            time,
            values,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bench() -> (Bench, Setting) {
        let bench = Bench::new(&mut Draw::new(3, 0));
        (
            bench,
            Setting {
                load: 2.0,
                supply: 100.0 * PSI,
                on: 0.01,
                off: None,
            },
        )
    }

    fn hidden(values: &[(&'static str, f64)]) -> Hidden {
        let dials: Vec<Dial> = values
            .iter()
            .map(|(key, value)| Dial::fixed(*key, *value))
            .collect();
        Hidden::of(&dials, 1.0)
    }

    /// Without friction, through a hole that holds the supply's pressure, the rod is uniformly
    /// accelerated.
    #[test]
    fn a_wide_valve_pushes_with_the_supply() {
        let (bench, setting) = bench();
        let wide = hidden(&[
            ("leg.discharge_coefficient", 60.0),
            ("leg.coulomb_friction_n", 0.0),
            ("leg.viscous_friction_n_s_per_m", 0.0),
            ("leg.valve_delay_s", 0.0),
        ]);
        let run = bench.fire(&setting, &wide);
        let a = setting.supply * AREA / setting.load - GRAVITY;
        for (t, d) in run.time.iter().zip(&run.values[0]) {
            let moved = (0.5 * a * (t - 0.01).max(0.0).powi(2)).min(STROKE);
            // Filling takes a tenth of a millisecond, at up to 3 m/s.
            assert!((d - moved).abs() < 4e-4, "{t}: {d} {moved}");
        }
    }

    /// A chamber whose rod is held fills through a choked hole at a constant rate: κ R T ṁ/V.
    #[test]
    fn a_held_chamber_fills_at_a_constant_rate() {
        let (bench, setting) = bench();
        let run = bench.fire(
            &Setting {
                load: 100.0,
                ..setting
            },
            &Hidden::default(),
        );
        let supply = setting.supply + AMBIENT;
        let flow = 0.5378
            * ORIFICE
            * supply
            * (1.4_f64 / (287.05 * TEMPERATURE)).sqrt()
            * (1.0_f64 / 1.2).powi(3);
        let rate = 1.4 * 287.05 * TEMPERATURE * flow / 5.4e-6;
        // 10 ms of delay, and less than half of the supply's pressure 4 ms on.
        for (t, p) in run
            .time
            .iter()
            .zip(&run.values[1])
            .filter(|(t, _)| **t < 0.024)
        {
            let filled = AMBIENT + rate * (t - 0.02).max(0.0);
            if filled < 0.5 * supply {
                assert!((p / filled - 1.0).abs() < 1e-9, "{t}: {p} {filled}");
            }
        }
        assert!(run.values[0].iter().all(|d| *d == 0.0));
    }

    /// The energy that no friction takes is in the gas: a closed chamber under a moving rod stays
    /// on its adiabat, P V^κ.
    #[test]
    fn a_closed_chamber_stays_on_its_adiabat() {
        let plant = Plant {
            valve: 0.0,
            ..Plant::new(&bench().1, &Hidden::default())
        };
        let (mut rod, mut y) = (Rod::Held, [0.01, 0.0, 5e5]);
        let constant = |y: &[f64; 3]| y[2] * (plant.dead_volume + AREA * y[0]).powf(1.4);
        let before = constant(&y);
        for i in 0..400 {
            plant.go(&mut rod, 1e-4 * f64::from(i), &mut y, 1e-4);
        }
        assert!(y[0] > 0.011, "{y:?}");
        assert!((constant(&y) / before - 1.0).abs() < 1e-8);
    }

    /// An upright stance of the reference model is this bench: end of the stroke and pressure
    /// there, every optional term on.
    #[test]
    fn an_upright_stance_is_a_firing() {
        let overrides = [
            "body.mass_kg=2.0",
            "leg.supply_pressure_gauge_psi=100",
            "leg.supply_droop_pa_s_per_kg=2e7",
            "leg.leak_area_m2=2e-7",
            "leg.polytropic_exponent=1.3",
            "leg.seal_friction_n_per_pa=1e-5",
            "leg.return_spring.stiffness_n_per_m=200",
            "leg.return_spring.preload_n=5",
            "leg.exhaust_port.position_m=0.04",
            "leg.exhaust_port.area_m2=1e-6",
        ];
        let robot =
            saltus_robot::resolve("rats-planar", &overrides.map(str::to_owned)).expect("a robot");
        let end = crate::oracle::solve(
            &robot,
            &saltus_lagrangian::Launch::at_firing(0.0, 0.0, 1.0),
            1e-5,
        );
        let effects = hidden(&[
            ("leg.supply_droop_pa_s_per_kg", 2e7),
            ("leg.leak_area_m2", 2e-7),
            ("leg.polytropic_exponent", 1.3),
            ("leg.seal_friction_n_per_pa", 1e-5),
            ("leg.return_spring.stiffness_n_per_m", 200.0),
            ("leg.return_spring.preload_n", 5.0),
            ("leg.exhaust_port.position_m", 0.04),
            ("leg.exhaust_port.area_m2", 1e-6),
        ]);
        let plant = Plant::new(
            &Setting {
                on: 0.0,
                ..bench().1
            },
            &effects,
        );
        let (mut rod, mut y, mut steps) = (Rod::Held, [0.0, 0.0, AMBIENT], 0_u32);
        while rod != Rod::AtStop && steps < 20_000 {
            plant.go(&mut rod, 1e-5 * f64::from(steps), &mut y, 1e-5);
            steps += 1;
        }
        // To a step in time, in which the pressure changes by a few hundred pascals.
        assert_eq!(end.outcome, "stroke");
        assert!(
            (1e-5 * f64::from(steps) - end.time).abs() < 2e-5,
            "{steps} {}",
            end.time
        );
        assert!(
            (y[2] / end.pressure - 1.0).abs() < 1e-3,
            "{} {}",
            y[2],
            end.pressure
        );
    }
}
