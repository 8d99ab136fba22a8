//! A robot as rigid bodies: the halves of its boom, its wheel, and the moving part of its leg.

use nalgebra::{Matrix3, Vector3};
use saltus_robot::{Boom, Robot};

pub(super) type V3 = Vector3<f64>;

/// Least mass of a leg relative to that of the robot.
const MASSLESS: f64 = 1e-6;
/// Least mass (kg) of a leg on soft ground. A lighter one would need too short steps.
const SOFT_LEAST: f64 = 0.02;

/// A rigid body: mass (kg), centre of mass (m) and inertia about it (kg m²) in its own axes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    pub(super) mass: f64,
    pub(super) center: V3,
    inertia: Matrix3<f64>,
}

impl Rigid {
    const NOTHING: Rigid = Rigid {
        mass: 0.0,
        center: V3::new(0.0, 0.0, 0.0),
        inertia: Matrix3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    };

    /// Inertia in the axes in which its own axes are the columns of `axes`.
    pub(super) fn turned(&self, axes: &Matrix3<f64>) -> Matrix3<f64> {
        // Most are round.
        let [x, y, z] = [0, 1, 2].map(|k| self.inertia[(k, k)]);
        let is_bare = [(0, 1), (0, 2), (1, 2)]
            .iter()
            .all(|at| self.inertia[*at] == 0.0);
        let round = |across: f64, along: f64, axis: usize| {
            let u = axes.column(axis);
            Matrix3::identity() * across + u * (u * (along - across)).transpose()
        };
        match is_bare {
            true if x == z => round(x, y, 1),
            true if x == y => round(x, z, 2),
            _ => axes * self.inertia * axes.transpose(),
        }
    }

    fn add(&mut self, other: &Rigid) {
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return;
        }
        let center = (self.center * self.mass + other.center * other.mass) / mass;
        let about = |b: &Rigid| {
            let r = b.center - center;
            b.inertia + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * b.mass
        };
        *self = Rigid {
            mass,
            center,
            inertia: about(self) + about(other),
        };
    }
}

/// The bodies of a robot. In the axes of the boom, y points along it. The axes of the wheel are
/// those at lean 0.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    /// The boom with its counterweight, up to its bend if it bends.
    pub(super) inner: Rigid,
    /// The boom beyond its bend.
    pub(super) outer: Rigid,
    /// The wheel with the legs that stay latched.
    pub(super) wheel: Rigid,
    /// The moving part of the leg that jumps, retracted.
    pub(super) leg: Rigid,
    /// Least mass (kg) of a leg in its own equation.
    pub(super) least: f64,
}

impl Bodies {
    pub(super) fn new(robot: &Robot) -> Bodies {
        let mut leg = rod(robot, 0);
        let lent = match robot.ground.stiffness {
            Some(_) => (SOFT_LEAST - leg.mass).max(0.0),
            None => 0.0,
        };
        leg.mass += lent;
        let (inner, outer) = match &robot.boom {
            Some(boom) => halves(boom),
            None => (Rigid::NOTHING, Rigid::NOTHING),
        };
        Bodies {
            inner,
            outer,
            wheel: wheel(robot, lent),
            leg,
            least: MASSLESS * robot.body.mass,
        }
    }
}

/// The moving part of leg `k`, counted forwards from the one that jumps.
fn rod(robot: &Robot, k: u32) -> Rigid {
    let part = &robot.leg.body;
    let angle = std::f64::consts::TAU * f64::from(k) / f64::from(robot.body.legs);
    let u = V3::new(angle.sin(), 0.0, -angle.cos());
    let along = 0.5 * part.mass * part.radius * part.radius;
    let inertia =
        Matrix3::identity() * part.inertia() + u * u.transpose() * (along - part.inertia());
    Rigid {
        mass: part.mass,
        center: u * part.center,
        inertia,
    }
}

/// The wheel with the other legs, less the mass `lent` (kg) that it lends to the leg.
fn wheel(robot: &Robot, lent: f64) -> Rigid {
    let body = &robot.body;
    let (offset, angle) = (body.imbalance, body.imbalance_angle);
    let mass = robot.wheel_mass() - lent;
    // A disc: about a diameter half of what it is about the axle.
    let axle = (robot.wheel_inertia() - mass * offset * offset).max(0.0);
    let mut wheel = Rigid {
        mass,
        center: V3::new(angle.sin(), 0.0, -angle.cos()) * offset,
        inertia: Matrix3::from_diagonal(&V3::new(axle / 2.0, axle, axle / 2.0)),
    };
    for k in 1..body.legs {
        wheel.add(&rod(robot, k));
    }
    wheel
}

/// The boom up to its bend, with its counterweight, and beyond. A rigid boom has nothing beyond.
fn halves(boom: &Boom) -> (Rigid, Rigid) {
    let cylinder = |length: f64| {
        let mass = boom.mass * length / boom.length;
        let across = mass * (3.0 * boom.radius * boom.radius + length * length) / 12.0;
        let along = 0.5 * mass * boom.radius * boom.radius;
        Rigid {
            mass,
            center: V3::y() * (length / 2.0),
            inertia: Matrix3::from_diagonal(&V3::new(across, along, across)),
        }
    };
    let (mut inner, outer) = match boom.flex {
        Some(_) => (cylinder(boom.length / 2.0), cylinder(boom.length / 2.0)),
        None => (cylinder(boom.length), Rigid::NOTHING),
    };
    if let Some(weight) = boom.counterweight {
        inner.add(&Rigid {
            mass: weight.mass,
            center: -V3::y() * weight.distance,
            inertia: Matrix3::zeros(),
        });
    }
    (inner, outer)
}
