//! Jumps of a robot with pneumatic muscles, fed from a tank of its own.

mod gas;
mod jumper;
mod muscle;
mod plant;

use std::collections::BTreeMap;

use self::gas::Tube;
use self::jumper::{Joint, Jumper, Link};
use self::muscle::{Muscle, rising_to};
use self::plant::Plant;
use super::dial::{Dial, Hidden};
use super::draw::Draw;
use super::motion::AIR;
use super::sensing::Column;
use super::{Exact, World};

pub(super) const CAUSES: &[&str] = &[
    "tank",
    "tube",
    "series-spring",
    "valve-delay",
    "valve-discharge",
    "heat-transfer",
    "chamber-leak",
    "coulomb-friction",
    "viscous-friction",
    "mass",
    "return-spring",
    "encoder-scale",
    "sensor-offset",
    "sensor-delay",
];

pub(super) const OUTSIDE: &[&str] = &[
    "muscle-shape",
    "smooth-floor",
    "valve-ramp",
    "compressor",
    "ripple",
    "gear-ripple",
    "saturation",
];

/// Muscles from right to left, and whether each is a knee's.
const MUSCLES: [(&str, bool); 4] = [
    ("knee_right", true),
    ("hip_right", false),
    ("hip_left", false),
    ("knee_left", true),
];
/// Time (s) between rows, and how many there are.
const ROW: f64 = 2e-3;
const ROWS: u32 = 250;
/// The first rows (s), in which the operator notes how the robot stands.
const NOTED: f64 = 0.018;
/// Steps between rows.
const STEPS: u32 = 20;
/// When (s) all muscles are vented.
const EXHAUST: f64 = 0.3;

/// What the operator measured of the robot.
#[derive(Clone, Debug)]
struct Belief {
    tank: f64,
    temperature: f64,
    /// Length, diameter and roughness (m).
    tube: [f64; 3],
    spool: f64,
    /// Torso, thigh, shank: kg and m.
    links: [Link; 3],
    radius: f64,
    /// Of hips and knees: radius (m) of the pulley; spring (N m/rad) and from where (rad).
    pulleys: [f64; 2],
    springs: [[f64; 2]; 2],
    /// N/m.
    tendon: f64,
    /// N m s/rad.
    damping: f64,
    /// m³, N/kPa, N/(kPa cm), and cm over kPa.
    volume: f64,
    force: f64,
    slope: f64,
    reach: [f64; 5],
}

impl Belief {
    /// A jumper about as large as the one of `GTDynamics`.
    fn new(draw: &mut Draw) -> Belief {
        let mut about = |x: f64, by: f64| {
            let digits = 10_f64.powf(3.0 - x.log10().ceil());
            (x * draw.scale(1.0 / by, by) * digits).round() / digits
        };
        let link = |mass: f64, length: f64| Link { mass, length };
        Belief {
            tank: about(1.5e-3, 1.4),
            temperature: about(293.0, 1.01),
            tube: [about(1.5, 1.4), about(4e-3, 1.15), about(1e-5, 2.0)],
            spool: about(1e-3, 1.4),
            links: [
                link(about(1.0, 1.3), about(0.55, 1.1)),
                link(about(0.5, 1.2), about(0.55, 1.1)),
                link(about(0.3, 1.2), about(0.55, 1.1)),
            ],
            radius: about(0.02, 1.2),
            pulleys: [about(0.045, 1.1), about(0.045, 1.1)],
            // Straight on is 0: they act before joints are straight.
            springs: [
                [about(2.5, 1.4), -about(1.4, 1.2)],
                [about(2.0, 1.4), -about(1.5, 1.2)],
            ],
            tendon: about(12e3, 1.5),
            damping: about(0.03, 1.5),
            volume: about(4.2e-5, 1.2),
            force: about(1.95, 1.1),
            slope: about(0.35, 1.1),
            reach: [3.0, 0.075, -4.9e-4, 1.4e-6, -1.5e-9],
        }
    }

    /// The table `[rig]` among the settings of a run.
    fn settings(&self) -> BTreeMap<String, f64> {
        let [length, diameter, roughness] = self.tube;
        let [torso, thigh, shank] = self.links;
        let numbers = [
            ("tank_volume_m3", self.tank),
            ("gas_temperature_k", self.temperature),
            ("gas_constant_j_kg_k", AIR.1),
            ("tube_length_m", length),
            ("tube_diameter_m", diameter),
            ("tube_roughness_m", roughness),
            ("valve_time_constant_s", self.spool),
            ("valve_exhaust_s", EXHAUST),
            ("link_radius_m", self.radius),
            ("hip_pulley_radius_m", self.pulleys[0]),
            ("knee_pulley_radius_m", self.pulleys[1]),
            ("tendon_stiffness_n_m", self.tendon),
            ("hip_spring_nm_rad", self.springs[0][0]),
            ("hip_spring_from_rad", self.springs[0][1]),
            ("knee_spring_nm_rad", self.springs[1][0]),
            ("knee_spring_from_rad", self.springs[1][1]),
            ("joint_damping_nm_s_rad", self.damping),
            ("muscle_force_per_kpa_n", self.force),
            ("muscle_slope_per_kpa_n_cm", self.slope),
            ("muscle_volume_coefficients.1", self.volume),
        ];
        let mut all: BTreeMap<String, f64> =
            numbers.map(|(key, value)| (key.to_owned(), value)).into();
        for (k, c) in self.reach.iter().enumerate() {
            all.insert(format!("muscle_x0_coefficients_cm.{}", k + 1), *c);
        }
        for (k, (name, _)) in MUSCLES.iter().enumerate() {
            all.insert(format!("actuators.{name}"), (k + 1) as f64);
        }
        let links = [
            ("shank_right", shank),
            ("thigh_right", thigh),
            ("torso", torso),
            ("thigh_left", thigh),
            ("shank_left", shank),
        ];
        for (k, (name, Link { mass, length })) in links.iter().enumerate() {
            all.insert(format!("link_names.{name}"), (k + 1) as f64);
            all.insert(format!("link_mass_kg.{}", k + 1), *mass);
            all.insert(format!("link_length_m.{}", k + 1), *length);
        }
        all
    }
}

/// What was set of a jump: gauge pressure (Pa) of the tank, when (s) the valves close, and angles
/// (rad) of hips and knees.
#[derive(Clone, Copy, Debug)]
struct Setting {
    tank: f64,
    until: f64,
    angles: [f64; 2],
}

/// Jumps of one robot.
pub(super) struct TankLegs {
    columns: Vec<Column>,
    belief: Belief,
    /// What the way to the air lets through in terms of a tube, which the operator does not know.
    vent: f64,
    settings: Vec<Setting>,
}

impl TankLegs {
    pub(super) fn new(draw: &mut Draw) -> TankLegs {
        let belief = Belief::new(draw);
        let stepped = |x: f64, step: f64| (x / step).round() * step;
        let settings = (0..4).map(|_| Setting {
            tank: stepped(draw.between(350e3, 550e3), 5e3),
            until: stepped(draw.between(0.05, 0.12), 0.01),
            angles: [
                stepped(draw.between(-2.55, -2.4), 1e-3),
                stepped(draw.between(2.6, 2.8), 1e-3),
            ],
        });
        let settings = settings.collect();
        let exact = |name| Column::noisy(name, 0.0);
        let pressure = |name| Column::noisy(name, 1e3);
        let columns = vec![
            exact("valve_knee_right"),
            exact("valve_hip_right"),
            exact("valve_hip_left"),
            exact("valve_knee_left"),
            exact("knee_right_angle_rad"),
            exact("hip_right_angle_rad"),
            exact("hip_left_angle_rad"),
            exact("knee_left_angle_rad"),
            exact("torso_y_m"),
            exact("torso_angle_rad"),
            pressure("tank_pressure_gauge_pa"),
            pressure("knee_right_pressure_gauge_pa"),
            pressure("hip_right_pressure_gauge_pa"),
            pressure("hip_left_pressure_gauge_pa"),
            pressure("knee_left_pressure_gauge_pa"),
            Column::noisy("com_y_m", 2e-3),
        ];
        TankLegs {
            columns,
            belief,
            vent: draw.scale(0.5, 1.5),
            settings,
        }
    }

    /// The robot as it is.
    fn plant(&self, setting: &Setting, h: &Hidden) -> Plant {
        let belief = &self.belief;
        let mass = h.get("mass_share", 1.0);
        let [length, diameter, roughness] = belief.tube;
        let tube = Tube {
            length,
            diameter,
            roughness,
            energy: AIR.1 * belief.temperature,
        };
        let joint = |spring: [f64; 2]| Joint {
            spring: [h.get("spring_share", 1.0) * spring[0], spring[1]],
            damping: h.get("viscous_friction_n_m_s_per_rad", belief.damping),
            friction: h.or_zero("coulomb_friction_n_m"),
        };
        let links = belief.links.map(|link| Link {
            mass: mass * link.mass,
            ..link
        });
        // Of cm and kPa.
        let mut unit = 1e-2;
        let reach: Vec<f64> = belief
            .reach
            .iter()
            .map(|c| {
                unit *= 1e-3;
                c * unit * 1e3
            })
            .collect();
        let muscle = Muscle {
            volume: belief.volume,
            pull: 1e-3 * belief.force,
            slope: 0.1 * belief.slope,
            rises_to: rising_to(&reach),
            reach,
            bulge: h.or_zero("muscle_bulge"),
        };
        let compliance = 1.0 / belief.tendon;
        Plant {
            jumper: Jumper {
                links,
                radius: belief.radius,
                joints: belief.springs.map(joint),
                grip: h.get("grip", 0.9),
            },
            muscle,
            gas: AIR,
            warm: belief.temperature,
            tank: belief.tank * h.get("tank_volume_share", 1.0),
            walls: [
                h.or_zero("tank_wall_k_per_w"),
                h.or_zero("muscle_wall_k_per_w"),
            ],
            dead: h.get("tube_volume_m3", tube.volume()),
            tube,
            shares: [
                h.get("tube_flow_share", 1.0) * h.get("valve_flow_share", 1.0),
                self.vent,
            ],
            outlet: h.or_zero("outlet_drop_share"),
            leak: h.or_zero("leak_area_m2"),
            feed: h.or_zero("feed_kg_per_s"),
            pulleys: belief.pulleys,
            tendons: [
                h.get("hip_tendon_m_per_n", compliance),
                h.get("knee_tendon_m_per_n", compliance),
            ],
            spool: belief.spool,
            lags: ["opening_delay_s", "closing_delay_s", "venting_delay_s"]
                .map(|key| h.or_zero(key)),
            ramp: h.or_zero("valve_ramp_s"),
            until: setting.until,
            exhaust: EXHAUST,
            start: setting.angles,
        }
    }

    fn run(&self, setting: &Setting, hidden: &Hidden) -> Exact {
        let plant = self.plant(setting, hidden);
        let [hip, knee] = setting.angles;
        let place = [0.0, hip, hip + knee];
        let mut state = plant.at_rest(place, setting.tank);
        let mut ground = plant.jumper.stand(place);
        plant.jumper.settle(place, [0.0; 3], &mut ground);
        let mut exact = Exact {
            values: vec![Vec::new(); self.columns.len()],
            ..Exact::default()
        };
        exact.settings = self.belief.settings();
        exact
            .settings
            .insert("supply_pressure_gauge_pa".into(), setting.tank);
        for row in 0..=ROWS {
            let t = f64::from(row) * ROW;
            exact.time.push(t);
            let [tank, hips, knees, centre] = plant.shown(t, &state, &ground);
            let noted = |x: f64| if t < NOTED { x } else { f64::NAN };
            let commands = [f64::from(u8::from(t < setting.until)); 4];
            let of_each =
                |values: [f64; 2]| MUSCLES.map(|(_, is_knee)| values[usize::from(is_knee)]);
            let all = commands
                .into_iter()
                .chain(of_each(setting.angles).map(noted))
                .chain([noted(0.0), noted(0.0), tank])
                .chain(of_each([hips, knees]))
                .chain([centre]);
            for (values, value) in exact.values.iter_mut().zip(all) {
                values.push(value);
            }
            let h = ROW / f64::from(STEPS);
            for step in 0..STEPS {
                plant.go(t + f64::from(step) * h, &mut state, &mut ground, h);
            }
        }
        exact
    }
}

impl World for TankLegs {
    fn columns(&self) -> &[Column] {
        &self.columns
    }

    fn runs(&self) -> usize {
        self.settings.len()
    }

    fn logs(&self, runs: &[usize], hidden: &Hidden) -> Vec<Option<Exact>> {
        runs.iter()
            .map(|run| Some(self.run(&self.settings[*run], hidden)))
            .collect()
    }

    fn dials(&self, id: &str, draw: &mut Draw) -> Option<Vec<Dial>> {
        let belief = &self.belief;
        let [length, diameter, _] = belief.tube;
        let volume = 0.25 * std::f64::consts::PI * diameter * diameter * length;
        let compliance = 1.0 / belief.tendon;
        let either = |draw: &mut Draw| draw.one(&[0.6, 1.6]);
        Some(match id {
            "tank" => vec![match draw.one(&[0, 1, 2]) {
                0 => Dial::up_to("tank_wall_k_per_w", 20.0),
                1 => Dial::up_to("outlet_drop_share", 0.3),
                _ => Dial::linear("tank_volume_share", 1.0, 0.6),
            }],
            "tube" => {
                let of_volume = Dial::linear("tube_volume_m3", volume, 5.0 * volume);
                let of_flow = Dial::linear("tube_flow_share", 1.0, either(draw));
                match draw.one(&[0, 1, 2]) {
                    0 => vec![of_volume],
                    1 => vec![of_flow],
                    _ => vec![of_volume, of_flow],
                }
            }
            "series-spring" => {
                let most = compliance * draw.one(&[0.1, 4.0]);
                ["hip_tendon_m_per_n", "knee_tendon_m_per_n"]
                    .map(|key| Dial::linear(key, compliance, most))
                    .into()
            }
            "valve-delay" => vec![
                Dial::up_to("opening_delay_s", 0.03 * draw.scale(0.5, 2.0)),
                Dial::up_to("closing_delay_s", 0.03 * draw.scale(0.5, 2.0)),
                Dial::up_to("venting_delay_s", 0.03 * draw.scale(0.5, 2.0)),
            ],
            "valve-discharge" => vec![Dial::linear("valve_flow_share", 1.0, either(draw))],
            "heat-transfer" => vec![Dial::up_to("muscle_wall_k_per_w", 10.0)],
            "chamber-leak" => vec![Dial::up_to("leak_area_m2", 2e-6)],
            "coulomb-friction" => vec![Dial::up_to("coulomb_friction_n_m", 2.0)],
            "viscous-friction" => vec![Dial::linear(
                "viscous_friction_n_m_s_per_rad",
                belief.damping,
                0.5,
            )],
            "mass" => vec![Dial::linear("mass_share", 1.0, either(draw))],
            "return-spring" => vec![Dial::linear("spring_share", 1.0, draw.one(&[0.1, 4.0]))],
            "muscle-shape" => vec![Dial::up_to("muscle_bulge", draw.one(&[-0.5, 0.5]))],
            "smooth-floor" => vec![Dial::linear("grip", 0.9, 0.02)],
            "valve-ramp" => vec![Dial::up_to("valve_ramp_s", 0.06)],
            "compressor" => vec![Dial::up_to("feed_kg_per_s", 5e-3)],
            _ => return None,
        })
    }

    /// What was noted by hand has no sensor; where the track of the centre begins, nobody knows.
    fn sensed(&self, id: &str) -> Vec<&'static str> {
        let measured = self.columns.iter().filter(|column| column.noise > 0.0);
        measured
            .map(|column| column.name)
            .filter(|name| id != "sensor-offset" || *name != "com_y_m")
            .collect()
    }
}
