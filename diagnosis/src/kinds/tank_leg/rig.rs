//! The machine that `[rig]` describes.

use std::collections::BTreeMap;

use nalgebra::{Matrix3, Vector3};
use saltus_pneumatics::Muscle;
use saltus_robot::Gas;
use saltus_sim_check::chain::{Chain, MOST};
use saltus_sim_check::{Body, Joint, Placement, Tree};

use crate::machine::{Machine, Part, Point};
use crate::spec::{Problem, listed, named};

/// Acceleration of gravity (m/s²).
pub(super) const GRAVITY: f64 = 9.80665;
/// How far (m) the ground gives way under the machine's weight, and damping of its contacts in
/// terms of √(stiffness × mass).
const GIVES_WAY: f64 = 1.25e-3;
const CONTACT_DAMPING: f64 = 0.2;
/// Friction coefficient under a foot.
const FRICTION: f64 = 0.9;
/// Greatest pressure (Pa, gauge) at which a muscle's polynomial is looked at.
const MOST_PRESSURE: f64 = 1e6;

/// A muscle with its joint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Actuator {
    /// The coordinate of its joint.
    pub(super) coordinate: usize,
    pub(super) is_knee: bool,
    /// Radius of its pulley (m).
    pub(super) pulley: f64,
    /// The spring against it (N m/rad), and from where on that acts (rad).
    spring: [f64; 2],
}

impl Actuator {
    /// A muscle pulls its joint towards 0: a knee from above, a hip from below.
    pub(super) fn side(&self) -> f64 {
        if self.is_knee { -1.0 } else { 1.0 }
    }
}

/// A link of the chain.
#[derive(Clone, Copy, Debug)]
struct Link {
    mass: f64,
    length: f64,
}

/// What `[rig]` says.
#[derive(Clone, Debug)]
pub(super) struct Rig {
    /// Names of the actuators, and each with its joint.
    pub(super) actuators: Vec<String>,
    pub(super) joints: Vec<Actuator>,
    links: Vec<Link>,
    /// The link that the others hang on.
    base: usize,
    radius: f64,
    pub(super) damping: f64,
    pub(super) gas: Gas,
    pub(super) temperature: f64,
    pub(super) tank: f64,
    /// Length, diameter and roughness of a tube (m).
    pub(super) tube: [f64; 3],
    /// Time constant of a valve (s), and when all muscles are vented.
    pub(super) spool: f64,
    pub(super) exhaust: Option<f64>,
    /// Compliance of a tendon (m/N).
    pub(super) tendon: f64,
    pub(super) muscle: Muscle,
}

fn refused<T>(what: String) -> Result<T, Problem> {
    Err(Problem::NoMachine { what })
}

/// `values` for each of `count` links; one stands for all.
fn for_each(key: &str, values: Vec<f64>, count: usize) -> Result<Vec<f64>, Problem> {
    match values[..] {
        [one] => Ok(vec![one; count]),
        _ if values.len() == count => Ok(values),
        _ => refused(format!(
            "rig.{key} has {} numbers: must be one, or {count}, one for each of link_names",
            values.len()
        )),
    }
}

impl Rig {
    /// The machine of a run's settings.
    ///
    /// # Errors
    /// [`Problem::NoMachine`] for a chain that is none, or a muscle that is none.
    pub(super) fn of(settings: &BTreeMap<String, f64>) -> Result<Rig, Problem> {
        let number = |key: &str| settings.get(key).copied().unwrap_or(f64::NAN);
        let names = named(settings, "link_names");
        let actuators = named(settings, "actuators");
        if names.len() != actuators.len() + 1 || names.len() + 2 > MOST {
            return refused(format!(
                "rig.link_names has {} links and rig.actuators {}: a chain of links has an actuator \
                 at each joint, one less than links, and {} links at most",
                names.len(),
                actuators.len(),
                MOST - 2
            ));
        }
        let masses = for_each(
            "link_mass_kg",
            listed(settings, "link_mass_kg"),
            names.len(),
        )?;
        let lengths = for_each(
            "link_length_m",
            listed(settings, "link_length_m"),
            names.len(),
        )?;
        let links: Vec<Link> = masses
            .into_iter()
            .zip(lengths)
            .map(|(mass, length)| Link { mass, length })
            .collect();
        let middle = names.len() / 2;
        let base = names.iter().position(|n| n == "torso").unwrap_or(middle);
        let mut joints = Vec::new();
        for (j, name) in actuators.iter().enumerate() {
            let part = ["knee", "hip"]
                .into_iter()
                .find(|part| name.starts_with(part));
            let Some(part) = part else {
                return refused(format!(
                    "rig.actuators: {name} must begin with knee or hip, whose pulley and spring it has"
                ));
            };
            joints.push(Actuator {
                coordinate: coordinate(base, j),
                is_knee: part == "knee",
                pulley: number(&format!("{part}_pulley_radius_m")),
                spring: ["nm_rad", "from_rad"].map(|of| number(&format!("{part}_spring_{of}"))),
            });
        }
        let gas = |key: &str, of_air| settings.get(key).copied().unwrap_or(of_air);
        Ok(Rig {
            actuators,
            joints,
            links,
            base,
            radius: number("link_radius_m"),
            damping: number("joint_damping_nm_s_rad"),
            gas: Gas {
                heat_ratio: gas("heat_ratio", Gas::AIR.heat_ratio),
                constant: gas("gas_constant_j_kg_k", Gas::AIR.constant),
            },
            temperature: number("gas_temperature_k"),
            tank: number("tank_volume_m3"),
            tube: ["length", "diameter", "roughness"].map(|of| number(&format!("tube_{of}_m"))),
            spool: number("valve_time_constant_s"),
            exhaust: settings.get("valve_exhaust_s").copied(),
            tendon: 1.0 / number("tendon_stiffness_n_m"),
            muscle: muscle(settings)?,
        })
    }

    /// The chain of links: the base moves freely, the others hang on it at both ends. Coordinates
    /// are the base's centre (m), its angle, and the joints' angles from the base outwards, first
    /// towards the first link (rad).
    pub(super) fn machine(&self, changed: &Changed) -> Option<Machine> {
        let mut tree = Tree::default();
        let slider = |axis: Vector3<f64>, parent| Body {
            name: "slider".into(),
            parent,
            joint: Joint::Prismatic(axis),
            placement: Placement::identity(),
            mass: 0.0,
            center: Vector3::zeros(),
            inertia: Matrix3::zeros(),
        };
        tree.add(slider(Vector3::x(), None)).ok()?;
        tree.add(slider(Vector3::z(), Some(0))).ok()?;
        let (base, half) = (self.base, 0.5 * self.links[self.base].length);
        let rod = |link: usize, parent, (turn, at): (f64, Vector3<f64>), center| {
            let Link { mass, length } = self.links[link];
            let mass = changed.mass * mass;
            let inertia = mass / 12.0 * (3.0 * self.radius.powi(2) + length * length);
            Body {
                name: format!("link {link}"),
                parent: Some(parent),
                joint: Joint::Revolute(turn * Vector3::y()),
                placement: Placement::at(at),
                mass,
                center,
                inertia: Matrix3::identity() * inertia,
            }
        };
        let hang = |link: usize| Vector3::new(0.0, 0.0, -0.5 * self.links[link].length);
        // Angles count forward in the tree, and from the first axis to the second here.
        let trunk = tree
            .add(rod(base, 1, (-1.0, Vector3::zeros()), Vector3::zeros()))
            .ok()?;
        let mut ends = vec![(trunk, [half, 0.0], 0.0), (trunk, [-half, 0.0], 0.0)];
        let sides: [(f64, Vec<usize>); 2] = [
            (1.0, (0..base).rev().collect()),
            (-1.0, (base + 1..self.links.len()).collect()),
        ];
        for (side, links) in sides {
            let mut parent = (trunk, Vector3::new(side * half, 0.0, 0.0));
            for link in links {
                let body = tree
                    .add(rod(link, parent.0, (side, parent.1), hang(link)))
                    .ok()?;
                parent = (body, 2.0 * hang(link));
            }
            ends.push((parent.0, [parent.1.x, parent.1.z], FRICTION));
        }
        let whole: f64 = changed.mass * self.links.iter().map(|link| link.mass).sum::<f64>();
        let stiffness = whole * GRAVITY / GIVES_WAY;
        let point = |(body, inner, friction): (usize, [f64; 2], f64)| Point {
            body,
            inner,
            ground: 0.0,
            stiffness,
            damping: CONTACT_DAMPING * (stiffness * whole).sqrt(),
            friction,
        };
        Some(Machine {
            chain: Chain::new(&tree, [0.0, -GRAVITY]).ok()?,
            parts: self.parts(changed),
            points: ends.into_iter().map(point).collect(),
        })
    }

    /// What is in the joints.
    fn parts(&self, changed: &Changed) -> Vec<Part> {
        let mut parts = vec![Part::default(); self.links.len() + 2];
        for joint in &self.joints {
            parts[joint.coordinate] = Part {
                spring: changed.spring * joint.spring[0],
                from: joint.spring[1],
                side: joint.side(),
                damping: changed.damping,
                friction: changed.friction,
            };
        }
        parts
    }
}

/// The coordinate of joint `j`, between links j and j + 1, of a chain that hangs on link `base`.
fn coordinate(base: usize, j: usize) -> usize {
    if j < base { 3 + (base - 1 - j) } else { 3 + j }
}

/// The muscle of `[rig]`, whose numbers are in cm and kPa.
fn muscle(settings: &BTreeMap<String, f64>) -> Result<Muscle, Problem> {
    let number = |key: &str| settings.get(key).copied().unwrap_or(f64::NAN);
    let volume = listed(settings, "muscle_volume_coefficients");
    let given = listed(settings, "muscle_x0_coefficients_cm");
    if given.len() > 5 {
        return refused(format!(
            "rig.muscle_x0_coefficients_cm has {} numbers: must be 5 at most",
            given.len()
        ));
    }
    let mut reach = [0.0; 5];
    for (k, (to, c)) in reach.iter_mut().zip(&given).enumerate() {
        *to = 0.01 * c / 1000_f64.powi(i32::try_from(k).unwrap_or(0));
    }
    let most = Muscle::rising_to(reach, MOST_PRESSURE);
    let muscle = Muscle {
        volume: volume.first().copied().unwrap_or(f64::NAN),
        force: number("muscle_force_per_kpa_n") / 1000.0,
        slope: number("muscle_slope_per_kpa_n_cm") / 10.0,
        reach,
        most,
    };
    if muscle.volume.is_nan() || muscle.volume <= 0.0 {
        return refused(format!(
            "rig.muscle_volume_coefficients begins with {}: must be a volume above 0 m3",
            muscle.volume
        ));
    }
    if muscle.free_contraction(0.0) <= 0.0 {
        return refused(
            "rig.muscle_x0_coefficients_cm: the free contraction at 0 kPa must be above 0".into(),
        );
    }
    let widest = muscle.free_contraction(muscle.most);
    if muscle.slope * widest > 3.0 * muscle.force {
        return refused(format!(
            "rig.muscle_slope_per_kpa_n_cm = {}: times the widest free contraction, {:.3} cm, it must \
             be at most 3 muscle_force_per_kpa_n, or the muscle would push near its end",
            number("muscle_slope_per_kpa_n_cm"),
            100.0 * widest
        ));
    }
    Ok(muscle)
}

/// The parameters of a machine with effects at work.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Changed {
    /// Lags (s) of the valves on opening, closing and venting.
    pub(super) lags: [f64; 3],
    /// Volume (m³) of a tube.
    pub(super) tube: f64,
    /// How much more a tube and a valve let through.
    pub(super) flow: f64,
    pub(super) valve: f64,
    /// What the way to the air lets through in terms of a tube.
    pub(super) vent: f64,
    /// Thermal resistance (K/W) of the walls of the tank and of a muscle.
    pub(super) walls: [f64; 2],
    /// Volume of the tank in terms of what is believed.
    pub(super) tank: f64,
    /// Fall of the square of the pressure in the tank's outlet in terms of that in a tube at the
    /// same flow.
    pub(super) outlet: f64,
    /// Compliance (m/N) of the tendons of knees and hips.
    pub(super) tendons: [f64; 2],
    pub(super) friction: f64,
    pub(super) damping: f64,
    pub(super) mass: f64,
    pub(super) spring: f64,
    /// Effective area (m²) of a leak of each muscle.
    pub(super) leak: f64,
    /// Force of the muscles in terms of what is believed.
    pub(super) force: f64,
}
