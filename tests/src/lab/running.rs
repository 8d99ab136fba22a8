//! Logs of running robots: the multi-body simulation under the controller, with an effect in the
//! robot or in a sensor that the operator knows nothing of.
//!
//! A run is no jump that could be repeated from the same start: under an effect it takes another
//! course after a few strides. So effects have fixed sizes here, written down before any was
//! diagnosed, and no strength in σ.

use std::sync::OnceLock;

use saltus::gait::{
    Disturbance, Draw, Footfall, Lines, Program, Row, Run, Setup, Smooth, What, When, drawn_robot,
    run, speed_law,
};
use saltus_diagnosis::{Experiment, Run as Measured, Sort};
use saltus_robot::{Robot, resolve};

use super::draw::Draw as Random;

/// A log, what its operator believes, and what is true.
#[derive(Clone, Debug)]
pub struct Trial {
    /// What was measured.
    pub experiment: Experiment,
    /// The robot that the operator believes in.
    pub believed: Robot,
    /// How it ran, in words.
    pub gait: String,
    /// What is hidden, in words.
    pub hidden: String,
}

/// How an effect is hidden.
#[derive(Clone, Copy, Debug)]
enum Change {
    /// Numbers of the robot file.
    Robot(&'static [&'static str]),
    /// Gain, offset and delay (s) of a column.
    Sensor(&'static str, [f64; 3]),
}

use Change::{Robot as Of, Sensor};

/// Effects that are clear to an operator who knows of them, each in two sizes.
const EFFECTS: &[(&str, [Change; 2])] = &[
    (
        "supply-pressure",
        [
            Of(&["leg.supply_pressure_gauge_psi=105"]),
            Of(&["leg.supply_pressure_gauge_psi=132"]),
        ],
    ),
    (
        "valve-delay",
        [
            Of(&["leg.valve_delay_ms=16"]),
            Of(&["leg.valve_delay_ms=13"]),
        ],
    ),
    (
        "viscous-friction",
        [
            Of(&["leg.viscous_friction_n_s_per_m=20"]),
            Of(&["leg.viscous_friction_n_s_per_m=12"]),
        ],
    ),
    (
        "coulomb-friction",
        [
            Of(&["leg.coulomb_friction_n=15"]),
            Of(&["leg.coulomb_friction_n=9"]),
        ],
    ),
    (
        "return-spring",
        [
            Of(&["leg.return_spring.preload_n=12"]),
            Of(&["leg.return_spring.stiffness_n_per_m=250"]),
        ],
    ),
    (
        "valve-discharge",
        [
            Of(&["leg.discharge_coefficient=0.42"]),
            Of(&["leg.discharge_coefficient=0.66"]),
        ],
    ),
    (
        "dead-volume",
        [
            Of(&["leg.dead_volume_m3=12e-6"]),
            Of(&["leg.dead_volume_m3=9e-6"]),
        ],
    ),
    (
        "chamber-leak",
        [
            Of(&["leg.leak_area_m2=6e-7"]),
            Of(&["leg.leak_area_m2=3e-7"]),
        ],
    ),
    (
        "mass",
        [Of(&["body.mass_kg=3.1"]), Of(&["body.mass_kg=2.5"])],
    ),
    (
        "inertia",
        [
            Of(&["body.inertia_kg_m2=0.1"]),
            Of(&["body.inertia_kg_m2=0.07"]),
        ],
    ),
    (
        "gravity",
        [
            Of(&["environment.gravity_m_s2=9.3"]),
            Of(&["environment.gravity_m_s2=10.3"]),
        ],
    ),
    (
        "counterweight",
        [
            Of(&[
                "boom.counterweight.mass_kg=1",
                "boom.counterweight.distance_m=0.5",
            ]),
            Of(&[
                "boom.counterweight.mass_kg=2",
                "boom.counterweight.distance_m=0.6",
            ]),
        ],
    ),
    (
        "foot-slip",
        [
            Of(&["ground.static_friction=0.3", "ground.kinetic_friction=0.3"]),
            Of(&[
                "ground.static_friction=0.45",
                "ground.kinetic_friction=0.45",
            ]),
        ],
    ),
    (
        "encoder-scale",
        [
            Sensor("pivot_angle_rad", [1.08, 0.0, 0.0]),
            Sensor("radius_angle_rad", [0.94, 0.0, 0.0]),
        ],
    ),
    (
        "sensor-offset",
        [
            Sensor("pivot_angle_rad", [1.0, 0.008, 0.0]),
            Sensor("wheel_rate_rad_s", [1.0, 0.15, 0.0]),
        ],
    ),
    (
        "sensor-delay",
        [
            Sensor("wheel_rate_rad_s", [1.0, 0.0, 0.008]),
            Sensor("pivot_angle_rad", [1.0, 0.0, 0.012]),
        ],
    ),
];

/// How many gaits there are: each two seeds the next one.
const GAITS: u64 = 5;

/// Ids of the effects that can be hidden.
pub fn causes() -> impl Iterator<Item = &'static str> {
    EFFECTS.iter().map(|(id, _)| *id)
}

/// A log of `seconds` (s) in which `hidden` is hidden, if anything; all of it follows from `seed`.
/// None where the robot with the effect does not run.
///
/// Without an effect the robot is drawn around `rats-run`, with dry friction from 1 to 4 N, and the
/// operator knows it.
pub fn make(hidden: Option<&str>, seconds: f64, seed: u64) -> Option<Trial> {
    let rats = Robot::builtin("rats-run")?;
    let mut draw = Random::new(seed, 5);
    let known = Draw {
        across: rats.ground.across_friction,
        // With more friction legs stay out until they are pushed in, and hardly a stride is read.
        friction: [1.0, 4.0],
        ..Draw::default()
    };
    let usize_of = |x: u64| usize::try_from(x).ok();
    let change = match hidden {
        Some(id) => {
            let (_, sizes) = EFFECTS.iter().find(|(own, _)| *own == id)?;
            Some(sizes[usize_of(seed % 2)?])
        }
        None => None,
    };
    let (believed, overrides) = match change {
        None => (drawn_robot(&rats, &known, seed, 0).ok()?, &[][..]),
        Some(Of(overrides)) => (rats, overrides),
        Some(Sensor(..)) => (rats, &[][..]),
    };
    let robot = if overrides.is_empty() {
        believed.clone()
    } else {
        let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
        resolve("rats-run", &overrides).ok()?
    };
    let (setup, gait) = setup(robot, seconds, seed, &mut draw)?;
    let mut log = Log::new(&setup.robot);
    run(&setup, &mut log).ok()?;
    let sensor = match change {
        Some(Sensor(column, what)) => Some((column, what)),
        _ => None,
    };
    let supply = believed.leg.cylinder()?.supply.0;
    Some(Trial {
        experiment: log.experiment(supply, sensor, &mut draw),
        believed,
        gait,
        hidden: change.map_or("none".into(), |change| format!("{change:?}")),
    })
}

/// How the robot runs: by a smooth law, at a speed, under one firing angle after a push, or by a
/// closed loop.
fn setup(robot: Robot, seconds: f64, seed: u64, draw: &mut Random) -> Option<(Setup, String)> {
    static LAW: OnceLock<Option<Vec<[f64; 3]>>> = OnceLock::new();
    let law = || {
        LAW.get_or_init(|| speed_law(&Robot::builtin("rats-run")?, 1).ok())
            .clone()
    };
    let (mut setup, words) = match (seed / 2) % GAITS {
        0 => {
            let setup = Setup::new(robot, Smooth::QUICK.program(), seconds);
            (setup, "smooth".to_owned())
        }
        1 => {
            let setup = Setup::new(robot, Smooth::SPARING.program(), seconds);
            (setup, "sparing".to_owned())
        }
        2 => {
            let speed = draw.between(1.8, 3.0);
            let setup = Setup::holding(&robot, law()?, &[[0.0, speed]], seconds).ok()?;
            (setup, format!("{speed:.2} m/s"))
        }
        4 => {
            let lines = Lines::One {
                first: draw.between(0.3, 0.4),
                last: draw.between(-0.15, -0.05),
                at: draw.between(9.0, 12.0),
            };
            let setup = Setup::new(robot, Program::ClosedLoop(lines), seconds);
            (setup, "closed loop".to_owned())
        }
        _ => {
            let firing_angle = draw.between(0.0, 0.2);
            let mut setup = Setup::new(robot, Program::Fixed { firing_angle }, seconds);
            setup.disturbances = vec![Disturbance {
                when: When::Time(0.5, 0.7),
                what: What::Torque(5.0),
            }];
            (setup, format!("fixed {firing_angle:.2} rad"))
        }
    };
    if matches!((seed / 2) % GAITS, 0 | 1 | 4) {
        // As the command has it for a law over the rate.
        setup.zone = -0.3;
    }
    setup.seed = seed;
    Some((setup, words))
}

/// What exact instruments log.
struct Log {
    time: Vec<f64>,
    valves: Vec<Vec<f64>>,
    /// Wheel angle, pivot angle, radius angle, rate of the wheel.
    values: [Vec<f64>; 4],
    openings: Vec<[f64; 2]>,
}

const COLUMNS: [&str; 4] = [
    "wheel_angle_rad",
    "pivot_angle_rad",
    "radius_angle_rad",
    "wheel_rate_rad_s",
];
/// Steps of the encoders (rad), and noise of the gyro (rad/s).
const STEPS: [f64; 3] = [
    std::f64::consts::TAU / 800.0,
    std::f64::consts::TAU / 1600.0,
    std::f64::consts::TAU / 1600.0,
];
const NOISE: f64 = 0.1;

impl Log {
    fn new(robot: &Robot) -> Log {
        let legs = robot.body.legs as usize;
        Log {
            time: Vec::new(),
            valves: vec![Vec::new(); legs],
            values: std::array::from_fn(|_| Vec::new()),
            openings: vec![[f64::INFINITY; 2]; legs],
        }
    }

    fn push(&mut self, time: f64, values: [f64; 4]) {
        self.time.push(time);
        for (valve, [open, shut]) in self.valves.iter_mut().zip(&self.openings) {
            let is_open = *open <= time + 1e-9 && time + 1e-9 < *shut;
            valve.push(f64::from(u8::from(is_open)));
        }
        for (column, value) in self.values.iter_mut().zip(values) {
            column.push(value);
        }
    }

    fn experiment(
        mut self,
        supply: f64,
        sensor: Option<(&str, [f64; 3])>,
        draw: &mut Random,
    ) -> Experiment {
        for (k, name) in COLUMNS.iter().enumerate() {
            let is_wrong = sensor.filter(|(column, _)| column == name);
            let [gain, offset, delay] = is_wrong.map_or([1.0, 0.0, 0.0], |(_, what)| what);
            let exact = &self.values[k];
            let late = |row: usize| {
                let then = self.time[row] - delay;
                let at = self.time.partition_point(|t| *t <= then).max(1) - 1;
                // A row in which it was measured.
                let at = (0..=at)
                    .rev()
                    .find(|i| exact[*i].is_finite())
                    .unwrap_or(row);
                exact[at]
            };
            let value = |row: usize| {
                let exact = if delay > 0.0 && exact[row].is_finite() {
                    late(row)
                } else {
                    exact[row]
                };
                gain * exact + offset
            };
            let mut read: Vec<f64> = (0..exact.len()).map(value).collect();
            match STEPS.get(k) {
                Some(step) => read
                    .iter_mut()
                    .for_each(|x| *x = (*x / step).round() * step),
                None => read.iter_mut().for_each(|x| *x += draw.normal(NOISE)),
            }
            self.values[k] = read;
        }
        let valves = 1..=self.valves.len();
        let none = vec![None; self.valves.len()];
        let columns = valves.map(|leg| format!("valve_{leg}"));
        Experiment {
            kind: Sort::Run,
            mechanism: None,
            columns: columns.chain(COLUMNS.map(str::to_owned)).collect(),
            noise: none
                .iter()
                .copied()
                .chain([None, None, None, Some(NOISE)])
                .collect(),
            resolution: none
                .iter()
                .copied()
                .chain(STEPS.map(Some))
                .chain([None])
                .collect(),
            runs: vec![Measured {
                name: "run.csv".into(),
                settings: [("supply_pressure_gauge_pa".to_owned(), supply)].into(),
                valve: None,
                time: self.time,
                values: self.valves.into_iter().chain(self.values).collect(),
            }],
        }
    }
}

impl Run for Log {
    fn row(&mut self, row: &Row<'_>) {
        let last = self.time.last().copied().unwrap_or(f64::NEG_INFINITY);
        let mut shut: Vec<f64> = self.openings.iter().map(|o| o[1]).collect();
        shut.retain(|t| *t > last + 1e-9 && *t < row.time - 1e-9);
        shut.sort_by(f64::total_cmp);
        for time in shut {
            self.push(time, [f64::NAN; 4]);
        }
        if let Some(leg) = row.action.leg {
            self.openings[leg as usize] = [row.time, row.time + row.action.valve_open];
        }
        let (q, v) = (row.coordinates, row.velocities);
        // A gyro on the wheel feels the turn of a boom that is tilted.
        let rate = row.rate - v[0] * q[1].sin();
        self.push(row.time, [row.lean, q[1], q[0], rate]);
    }

    fn footfall(&mut self, _: &Footfall) {}
}
