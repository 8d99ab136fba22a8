//! The robot on its boom, by the multi-body simulation: hops, jumps, and where jumps went.
//!
//! Effects are changes of the robot file `rats-boom`, in which the operator goes on to believe. A
//! leg is commanded at the tick at which the robot without effects would be commanded: what is
//! hidden shows in the motion, not in the command.

use std::collections::BTreeMap;

use saltus_robot::{Drive, GaugePressure, Robot, resolve};
use saltus_sim_check::{Firing, JointParts, Launch, Rig, Settings, Shot, TICK};

use super::bench::leg;
use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::PSI;
use super::sensing::Column;
use super::{Exact, World};

pub(super) const HOP_CAUSES: &[&str] = &[
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
    "boom-inertia",
    "boom-flex",
    "ground-compliance",
    "air-drag",
    "gravity",
    "counterweight",
    "encoder-scale",
    "sensor-offset",
    "sensor-delay",
];

/// Of a slope, all that is bolted to the floor is tilted with it: a point that does not slip does
/// not know how the floor alone lies about it.
pub(super) const JUMP_CAUSES: &[&str] = &[
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
    "inertia",
    "imbalance",
    "boom-inertia",
    "boom-flex",
    "axle-friction",
    "foot-slip",
    "across-friction",
    "ground-compliance",
    "foot-rolling",
    "ground-slope",
    "air-drag",
    "gravity",
    "counterweight",
    "encoder-scale",
    "sensor-offset",
    "sensor-delay",
];

/// A boom that bends moves the axle by millimetres, which does not show there.
pub(super) const OUTCOMES_CAUSES: &[&str] = &[
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
    "inertia",
    "imbalance",
    "boom-inertia",
    "axle-friction",
    "foot-slip",
    "ground-compliance",
    "foot-rolling",
    "ground-slope",
    "air-drag",
    "gravity",
    "counterweight",
    "encoder-scale",
    "sensor-offset",
];

pub(super) const HOP_OUTSIDE: &[&str] = &[
    "pivot-damping",
    "boom-tether",
    "ripple",
    "gear-ripple",
    "saturation",
];
pub(super) const JUMP_OUTSIDE: &[&str] = &[
    "axle-damping",
    "pivot-damping",
    "turn-damping",
    "boom-tether",
    "ripple",
    "gear-ripple",
    "saturation",
];
pub(super) const OUTCOMES_OUTSIDE: &[&str] = &[
    "axle-damping",
    "pivot-damping",
    "turn-damping",
    "ripple",
    "gear-ripple",
    "saturation",
];

/// A firing at a gauge pressure (Pa) that the operator set.
type Supplied = (f64, Firing);

/// The robot with what is hidden in it.
fn robot(hidden: &Hidden) -> Robot {
    let gas = [("heat_ratio", 1.4), ("constant_j_per_kg_k", 287.05)].map(|(key, air)| {
        let value = hidden.get(&format!("leg.gas.{key}"), air);
        format!("{key} = {value:?}")
    });
    let mut overrides = vec![format!("leg.gas={{ {} }}", gas.join(", "))];
    let kappa = hidden.get("leg.gas.heat_ratio", 1.4);
    let sections = ["leg.", "body.", "boom.", "foot.", "ground.", "environment."];
    for (key, value) in hidden.all() {
        if !sections.iter().any(|section| key.starts_with(section)) || key.starts_with("leg.gas.") {
            continue;
        }
        let value = if *key == "leg.polytropic_exponent" {
            value.min(kappa)
        } else {
            *value
        };
        overrides.push(format!("{key}={value:?}"));
    }
    resolve("rats-boom", &overrides).unwrap_or_else(|error| panic!("{overrides:?}: {error}"))
}

/// The rig, at the supply that the operator set.
fn rig(robot: &Robot, supply: f64, hidden: &Hidden) -> Option<Rig> {
    let mut robot = robot.clone();
    if let Drive::Pneumatic(cylinder) = &mut robot.leg.drive {
        cylinder.supply =
            GaugePressure((supply + hidden.or_zero("supply_pressure_offset_pa")).max(0.0));
    }
    let mut rig = Rig::new(&robot, &[]).ok()?;
    let damping = |key: &str| JointParts {
        damping: hidden.or_zero(key),
        ..JointParts::default()
    };
    // The boom turns about its base, then pivots.
    let (turn, pivot, wheel) = (0, 1, rig.wheel);
    let joints = &mut rig.mechanism.joints;
    joints[wheel].damping = hidden.or_zero("axle damping_n_m_s");
    joints[pivot] = damping("boom pivot damping_n_m_s");
    joints[pivot].spring = (hidden.or_zero("boom pivot spring_n_m_per_rad"), 0.0);
    joints[turn] = damping("boom turn damping_n_m_s");
    Some(rig)
}

/// The numbers of robot and rig that the effect `id` changes.
fn dials(id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
    let turn = std::f64::consts::TAU;
    Some(match id {
        "imbalance" => vec![
            Dial::up_to("body.imbalance_m", 0.04),
            Dial::fixed("body.imbalance_angle_rad", draw.between(0.0, turn)),
        ],
        "boom-flex" => vec![
            Dial::inverse("boom.bending_stiffness_n_m_per_rad", 400.0),
            Dial::fixed("boom.bending_damping_time_s", draw.between(0.0, 2e-3)),
        ],
        "ground-slope" => vec![Dial::up_to("ground.tilt_rad", 0.1)],
        "foot-slip" => {
            // Dry friction is at most a little less once a foot slips.
            let coefficient = draw.between(0.03, 0.1);
            let kinetic = coefficient * draw.between(0.8, 1.0);
            vec![
                Dial::inverse("ground.static_friction", coefficient),
                Dial::inverse("ground.kinetic_friction", kinetic),
            ]
        }
        "ground-compliance" => {
            let (stiffness, ratio) = (1.2e4, draw.between(0.05, 0.25));
            // A foot that could not slip at all would take an impulse along soft ground as its leg
            // meets its stop.
            vec![
                Dial::fixed("ground.static_friction", 3.0),
                Dial::fixed("ground.kinetic_friction", 3.0),
                Dial::inverse("ground.stiffness_n_per_m", stiffness),
                Dial::root(
                    "ground.damping_n_s_per_m",
                    2.0 * ratio * (stiffness * 2.9_f64).sqrt(),
                ),
            ]
        }
        "counterweight" => vec![
            Dial::up_to("boom.counterweight.mass_kg", 3.0),
            Dial::fixed("boom.counterweight.distance_m", draw.between(0.3, 0.8)),
        ],
        "axle-damping" => vec![Dial::up_to("axle damping_n_m_s", 0.3)],
        "pivot-damping" => vec![Dial::up_to("boom pivot damping_n_m_s", 8.0)],
        "turn-damping" => vec![Dial::up_to("boom turn damping_n_m_s", 8.0)],
        "boom-tether" => vec![Dial::up_to("boom pivot spring_n_m_per_rad", 200.0)],
        _ => return leg(id, draw),
    })
}

/// Encoders as they are on the rig: their steps, some noise in their place, or both.
fn encoder(name: &'static str, count: f64, way: usize) -> Column {
    match way {
        0 => Column {
            name,
            noise: 0.0,
            resolution: count,
        },
        1 => Column {
            name,
            noise: count / 3.0,
            resolution: 0.0,
        },
        _ => Column {
            name,
            noise: count / 3.0,
            resolution: count,
        },
    }
}

const WHEEL_COUNT: f64 = 7.854e-3;
const BOOM_COUNT: f64 = 3.927e-3;

/// The usual ones; a jump that takes so many steps is not worth the wait.
fn settings() -> Settings {
    Settings {
        most_steps: 4_000,
        ..Settings::default()
    }
}

/// Opening (s), to a tick.
fn ticks(time: f64) -> f64 {
    (time / TICK).round() * TICK
}

fn exact((supply, firing): &Supplied, rows: &[[f64; 6]], columns: &[usize]) -> Exact {
    let settings = BTreeMap::from([("supply_pressure_gauge_pa".to_owned(), *supply)]);
    Exact {
        settings,
        valve: Some((firing.on, Some(firing.on + firing.opening))),
        time: (0..rows.len()).map(|i| i as f64 * TICK).collect(),
        values: columns
            .iter()
            .map(|k| rows.iter().map(|row| row[*k]).collect())
            .collect(),
    }
}

/// The logs of these firings: of lean, pivot angle, radius angle and gyro, those `columns`.
fn fire(
    firings: &[Supplied],
    runs: &[usize],
    columns: &[usize],
    hidden: &Hidden,
) -> Vec<Option<Exact>> {
    let robot = robot(hidden);
    runs.iter()
        .map(|run| {
            let supplied = &firings[*run];
            let flown = rig(&robot, supplied.0, hidden)?.flown(&supplied.1, settings())?;
            Some(exact(supplied, &flown.rows, columns))
        })
        .collect()
}

/// Hops from rest on one upright leg.
pub(super) struct Hops {
    columns: [Column; 1],
    firings: Vec<Supplied>,
}

impl Hops {
    pub(super) fn new(draw: &mut Draw) -> Hops {
        let way = draw.one(&[0, 1, 2]);
        let firings = (0..draw.one(&[10, 11, 12]))
            .map(|_| {
                let supply = draw.one(&[80.0, 90.0, 100.0, 110.0, 120.0]) * PSI;
                let firing = Firing {
                    lean: 0.0,
                    rate: 0.0,
                    on: 0.005,
                    opening: ticks(draw.between(0.02, 0.08)),
                };
                (supply, firing)
            })
            .collect();
        Hops {
            columns: [encoder("pivot_angle_rad", BOOM_COUNT, way)],
            firings,
        }
    }
}

impl World for Hops {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.firings.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        fire(&self.firings, runs, &[1], hidden)
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        dials(id, draw)
    }

    fn robot(&self) -> Option<&'static str> {
        Some("rats-boom")
    }

    fn enough(&self) -> usize {
        3
    }
}

/// Jumps from just after touch-down.
pub(super) struct Jumps {
    columns: [Column; 4],
    firings: Vec<Supplied>,
}

impl Jumps {
    pub(super) fn new(draw: &mut Draw) -> Jumps {
        let way = draw.one(&[0, 1, 2]);
        let columns = [
            encoder("wheel_angle_rad", WHEEL_COUNT, way),
            encoder("pivot_angle_rad", BOOM_COUNT, way),
            encoder("radius_angle_rad", BOOM_COUNT, way),
            Column::noisy("wheel_rate_rad_s", 0.03),
        ];
        let robot = robot(&Hidden::default());
        let mut firings = Vec::new();
        while firings.len() < 12 {
            firings.extend(jump(&robot, draw));
        }
        Jumps { columns, firings }
    }
}

/// A jump of the robot without effects, if what is drawn is one.
fn jump(robot: &Robot, draw: &mut Draw) -> Option<Supplied> {
    let (lean, rate) = (draw.between(-0.45, -0.15), draw.between(3.0, 6.0));
    let (angle, opening) = (draw.between(-0.1, 0.25), ticks(draw.between(0.04, 0.1)));
    let supply = draw.one(&[100.0, 110.0, 120.0]) * PSI;
    let rig = rig(robot, supply, &Hidden::default())?;
    let mut shot = Shot::new(&rig, [lean, rate], settings()).ok()?;
    let reached = |_: f64, q: &[f64], _: &[f64]| angle - q[rig.lean_coordinate()];
    shot.go(0.6, &[&reached]).ok()?;
    let on = (shot.time() / TICK).ceil() * TICK;
    let firing = Firing {
        lean,
        rate,
        on,
        opening,
    };
    let flown = rig.flown(&firing, settings())?;
    // With some flight to see.
    let has_flight = flown.rows.len() as f64 * TICK > flown.lift_off + 0.15;
    (on < 0.55 && has_flight).then_some((supply, firing))
}

impl World for Jumps {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.firings.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        fire(&self.firings, runs, &[0, 1, 2, 3], hidden)
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        dials(id, draw)
    }

    /// Waves of a gear are those of the wheel's encoder.
    fn sensed(&self, id: &str) -> Vec<&'static str> {
        let names = self.columns.iter().map(|column| column.name);
        names
            .filter(|name| id != "gear-ripple" || *name == "wheel_angle_rad")
            .collect()
    }

    fn robot(&self) -> Option<&'static str> {
        Some("rats-boom")
    }

    fn enough(&self) -> usize {
        3
    }
}

/// Where jumps went: a row a jump.
pub(super) struct Outcomes {
    columns: [Column; 5],
    launches: Vec<Launch>,
}

impl Outcomes {
    pub(super) fn new(draw: &mut Draw) -> Outcomes {
        let asked = |name| Column {
            name,
            noise: 0.0,
            resolution: 0.0,
        };
        let columns = [
            asked("omega_rad_s"),
            asked("alpha_f_rad"),
            asked("valve_open_s"),
            Column::noisy("distance_m", 3e-3),
            Column::noisy("apex_m", 2e-3),
        ];
        let rows = draw.one(&[40, 50, 60]);
        let rig = rig(&robot(&Hidden::default()), 120.0 * PSI, &Hidden::default());
        let mut launches = Vec::new();
        while launches.len() < rows {
            let round = |x: f64, step: f64| (x / step).round() * step;
            let angle = round(draw.between(-0.25, 0.3), 1e-3);
            let launch = Launch {
                rate: round(draw.between(3.0, 6.0), 0.01),
                lean: angle,
                firing_angle: angle,
                valve_open: ticks(draw.between(0.03, 0.1)),
            };
            if rig
                .as_ref()
                .is_some_and(|rig| rig.landed(&launch, settings()).is_some())
            {
                launches.push(launch);
            }
        }
        Outcomes { columns, launches }
    }
}

impl World for Outcomes {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.launches.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        let Some(rig) = rig(&robot(hidden), 120.0 * PSI, hidden) else {
            return vec![None; runs.len()];
        };
        runs.iter()
            .map(|run| {
                let launch = &self.launches[*run];
                let [distance, apex] = rig.landed(launch, settings())?;
                let row = [
                    launch.rate,
                    launch.firing_angle,
                    launch.valve_open,
                    distance,
                    apex,
                ];
                Some(Exact {
                    time: vec![*run as f64],
                    values: row.iter().map(|x| vec![*x]).collect(),
                    ..Exact::default()
                })
            })
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        dials(id, draw)
    }

    fn sensed(&self, _: &str) -> Vec<&'static str> {
        vec!["distance_m", "apex_m"]
    }

    fn robot(&self) -> Option<&'static str> {
        Some("rats-boom")
    }

    fn enough(&self) -> usize {
        8
    }
}
