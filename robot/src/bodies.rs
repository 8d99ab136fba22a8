//! A robot as rigid bodies: the rods of its boom, its wheel, and the moving part of each leg.
//!
//! The axes of a boom have y along it, away from its base. Those of the wheel are x forward, y
//! along the axle and z up at lean 0; its legs share them.

use crate::Space;
use crate::model::{Boom, Robot};
use crate::space::dot;

/// Mass of a leg without mass relative to that of the robot, where equations of motion need one:
/// what it does is below 1e-6 of anything.
pub const MASSLESS: f64 = 1e-6;

/// A rigid body in given axes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RigidBody {
    /// Mass (kg), ≥ 0.
    pub mass: f64,
    /// Centre of mass (m).
    pub center: [f64; 3],
    /// Moments of inertia (kg m²) about the centre of mass: a symmetric matrix.
    pub inertia: [[f64; 3]; 3],
}

impl RigidBody {
    /// A body of `mass` (kg) around its `center` (m), with the principal moments of inertia (kg m²)
    /// about the axes: `along` that of y, `across` those of x and z.
    fn around_y(mass: f64, center: [f64; 3], along: f64, across: f64) -> RigidBody {
        RigidBody {
            mass,
            center,
            inertia: [[across, 0.0, 0.0], [0.0, along, 0.0], [0.0, 0.0, across]],
        }
    }
}

impl Boom {
    /// Length (m) up to its bend; of a rigid boom, all of it.
    pub fn inner_length(&self) -> f64 {
        if self.flex.is_some() {
            self.length / 2.0
        } else {
            self.length
        }
    }

    /// The boom up to its bend without its counterweight, from the base; and the same rod beyond,
    /// from the bend. A rigid boom is all in the first, and has none beyond.
    pub fn rods(&self) -> (RigidBody, Option<RigidBody>) {
        let length = self.inner_length();
        let mass = self.mass * length / self.length;
        let across = mass * (3.0 * self.radius * self.radius + length * length) / 12.0;
        let along = 0.5 * mass * self.radius * self.radius;
        let rod = RigidBody::around_y(mass, [0.0, length / 2.0, 0.0], along, across);
        (rod, self.flex.map(|_| rod))
    }
}

impl Robot {
    /// The direction from the axle to the foot of leg `k`: down at lean 0, and on forwards; in space that of
    /// [`Space::directions`](crate::Space::directions).
    ///
    /// # Panics
    /// In space for a leg that is not there.
    pub fn leg_direction(&self, k: u32) -> [f64; 3] {
        if let Some(space) = &self.space {
            return space.directions.vectors()[k as usize];
        }
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(self.body.legs);
        [angle.sin(), 0.0, -angle.cos()]
    }

    /// The moving part of leg `k`, retracted, as a solid cylinder.
    pub fn leg_rod(&self, k: u32) -> RigidBody {
        let (part, u) = (&self.leg.body, self.leg_direction(k));
        let across = part.inertia();
        let along = 0.5 * part.mass * part.radius * part.radius;
        let moment = |i: usize, j: usize| {
            let round = if i == j { across } else { 0.0 };
            round + u[i] * u[j] * (along - across)
        };
        RigidBody {
            mass: part.mass,
            center: u.map(|x| x * part.center),
            inertia: std::array::from_fn(|i| std::array::from_fn(|j| moment(i, j))),
        }
    }

    /// The body of a robot in space without its legs and without the mass `lent` (kg) to them, which is taken from its centre
    /// of mass.
    pub fn core(&self, space: &Space, lent: f64) -> RigidBody {
        let mass = self.wheel_mass() - lent;
        let [xx, yy, zz, xy, xz, yz] = space.inertia;
        let mut inertia = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]];
        // About where the legs meet, less the legs; and about the centre of mass.
        let mut take = |mass: f64, at: [f64; 3]| {
            let square = dot(&at, &at);
            for (i, row) in inertia.iter_mut().enumerate() {
                for (j, x) in row.iter_mut().enumerate() {
                    let round = if i == j { square } else { 0.0 };
                    *x -= mass * (round - at[i] * at[j]);
                }
            }
        };
        take(mass, space.center);
        let rods: Vec<RigidBody> = (0..self.body.legs).map(|k| self.leg_rod(k)).collect();
        for rod in &rods {
            take(rod.mass, rod.center);
        }
        for rod in &rods {
            for (row, of_rod) in inertia.iter_mut().zip(&rod.inertia) {
                for (x, part) in row.iter_mut().zip(of_rod) {
                    *x -= part;
                }
            }
        }
        RigidBody {
            mass,
            center: space.center,
            inertia,
        }
    }

    /// The wheel without its legs and without the mass `lent` (kg) to them, as a disc.
    pub fn wheel_disc(&self, lent: f64) -> RigidBody {
        let (offset, angle) = (self.body.imbalance, self.body.imbalance_angle);
        let mass = self.wheel_mass() - lent;
        let center = [angle.sin() * offset, 0.0, -angle.cos() * offset];
        let axle = (self.wheel_inertia() - mass * offset * offset).max(0.0);
        // About a diameter half of what it is about the axle.
        RigidBody::around_y(mass, center, axle, axle / 2.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn robot(overrides: &[&str]) -> Robot {
        let overrides: Vec<String> = overrides.iter().map(ToString::to_string).collect();
        crate::resolve("rats-boom", &overrides).expect("sound")
    }

    /// Moment of inertia (kg m²) about y through the origin.
    fn about_y(body: &RigidBody) -> f64 {
        let [x, _, z] = body.center;
        body.inertia[1][1] + body.mass * (x * x + z * z)
    }

    #[test]
    fn wheel_and_legs_have_the_mass_and_the_inertia_of_the_robot() {
        let robot = robot(&[
            "leg.mass_kg=0.05",
            "leg.center_m=0.19",
            "leg.rod_length_m=0.1",
            "body.imbalance_mm=30",
        ]);
        let mut bodies: Vec<RigidBody> = (0..robot.body.legs).map(|k| robot.leg_rod(k)).collect();
        bodies.push(robot.wheel_disc(0.0));
        let mass: f64 = bodies.iter().map(|body| body.mass).sum();
        let inertia: f64 = bodies.iter().map(about_y).sum();
        // Round-off of six bodies.
        assert!((mass - robot.body.mass).abs() < 1e-14);
        assert!((inertia - robot.body.inertia).abs() < 1e-14);
    }

    #[test]
    fn the_halves_of_a_boom_are_the_boom() {
        let (whole, none) = robot(&[]).boom.expect("a boom").rods();
        let bending = robot(&["boom.bending_stiffness_n_m_per_rad=400"]);
        let boom = bending.boom.expect("a boom");
        let (inner, outer) = boom.rods();
        let outer = outer.expect("a half beyond the bend");
        let about_base = |body: &RigidBody, from: f64| {
            body.inertia[0][0] + body.mass * (from + body.center[1]).powi(2)
        };
        let halves = about_base(&inner, 0.0) + about_base(&outer, boom.inner_length());
        assert_eq!(none, None);
        assert!((inner.mass + outer.mass - whole.mass).abs() < 1e-15);
        assert!((halves - about_base(&whole, 0.0)).abs() < 1e-13);
    }
}
