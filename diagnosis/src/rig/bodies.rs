//! A robot as rigid bodies: the halves of its boom, its wheel, and the moving part of its leg.

use nalgebra::{Matrix3, Vector3};
use saltus_robot::bodies::{MASSLESS, RigidBody};
use saltus_robot::{Boom, Robot};

pub(super) type V3 = Vector3<f64>;

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

impl From<RigidBody> for Rigid {
    fn from(body: RigidBody) -> Rigid {
        Rigid {
            mass: body.mass,
            center: body.center.into(),
            inertia: body.inertia.into(),
        }
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
        let mut leg = Rigid::from(robot.leg_rod(0));
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

/// The wheel with the other legs, less the mass `lent` (kg) that it lends to the leg.
fn wheel(robot: &Robot, lent: f64) -> Rigid {
    let mut wheel = Rigid::from(robot.wheel_disc(lent));
    for k in 1..robot.body.legs {
        wheel.add(&robot.leg_rod(k).into());
    }
    wheel
}

/// The boom up to its bend, with its counterweight, and beyond.
fn halves(boom: &Boom) -> (Rigid, Rigid) {
    let (inner, outer) = boom.rods();
    let mut inner = Rigid::from(inner);
    if let Some(weight) = boom.counterweight {
        inner.add(&Rigid {
            mass: weight.mass,
            center: -V3::y() * weight.distance,
            ..Rigid::NOTHING
        });
    }
    (inner, outer.map_or(Rigid::NOTHING, Rigid::from))
}
