//! Spatial vectors: motions, wrenches and inertias, all in world axes and about the world's origin.
//!
//! Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 2, with one frame for all
//! bodies.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use nalgebra::{Matrix3, Vector3};

/// A vector in space (m, m/s, N …), world axes, z up.
pub type Vec3 = Vector3<f64>;

/// A spatial velocity or acceleration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// Angular part (rad/s).
    pub angular: Vec3,
    /// Velocity (m/s) of the body's point that is at the origin.
    pub linear: Vec3,
}

/// A spatial force or momentum.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wrench {
    /// Moment about the origin (N m).
    pub moment: Vec3,
    /// Force (N).
    pub force: Vec3,
}

impl Motion {
    /// Velocity (m/s) of the body's point at `point` (m).
    #[inline]
    pub fn at(&self, point: &Vec3) -> Vec3 {
        self.linear + self.angular.cross(point)
    }

    /// Classical acceleration (m/s²) of the body's point at `point`, where `self` is the body's
    /// spatial acceleration and `velocity` its velocity.
    #[inline]
    pub fn acceleration_at(&self, velocity: &Motion, point: &Vec3) -> Vec3 {
        self.at(point) + velocity.angular.cross(&velocity.at(point))
    }

    /// Rate of change of `other` as it moves along with `self`.
    #[inline]
    pub fn cross(&self, other: &Motion) -> Motion {
        Motion {
            angular: self.angular.cross(&other.angular),
            linear: self.angular.cross(&other.linear) + self.linear.cross(&other.angular),
        }
    }

    /// Rate of change of a wrench as it moves along with `self`.
    #[inline]
    pub fn cross_wrench(&self, other: &Wrench) -> Wrench {
        Wrench {
            moment: self.angular.cross(&other.moment) + self.linear.cross(&other.force),
            force: self.angular.cross(&other.force),
        }
    }

    /// Power (W) of a wrench, or what part of it does work along this motion.
    #[inline]
    pub fn dot(&self, wrench: &Wrench) -> f64 {
        self.angular.dot(&wrench.moment) + self.linear.dot(&wrench.force)
    }
}

impl Add for Motion {
    type Output = Motion;
    #[inline]
    fn add(self, other: Motion) -> Motion {
        Motion {
            angular: self.angular + other.angular,
            linear: self.linear + other.linear,
        }
    }
}

impl Mul<f64> for Motion {
    type Output = Motion;
    #[inline]
    fn mul(self, scale: f64) -> Motion {
        Motion {
            angular: self.angular * scale,
            linear: self.linear * scale,
        }
    }
}

impl AddAssign for Wrench {
    #[inline]
    fn add_assign(&mut self, other: Wrench) {
        self.moment += other.moment;
        self.force += other.force;
    }
}

impl Sub for Wrench {
    type Output = Wrench;
    #[inline]
    fn sub(self, other: Wrench) -> Wrench {
        Wrench {
            moment: self.moment - other.moment,
            force: self.force - other.force,
        }
    }
}

impl Add for Wrench {
    type Output = Wrench;
    #[inline]
    fn add(mut self, other: Wrench) -> Wrench {
        self += other;
        self
    }
}

impl Neg for Wrench {
    type Output = Wrench;
    fn neg(self) -> Wrench {
        Wrench {
            moment: -self.moment,
            force: -self.force,
        }
    }
}

/// Inertia of one or several bodies that move as one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inertia {
    /// Mass (kg).
    pub mass: f64,
    /// Mass times centre (kg m).
    pub first: Vec3,
    /// Moments of inertia about the origin (kg m²): xx, yy, zz, xy, xz, yz.
    second: [f64; 6],
}

impl Inertia {
    /// A body of `mass` (kg) with its centre at `center` (m) and the moments `about_center` (kg
    /// m²).
    #[inline]
    pub fn new(mass: f64, center: &Vec3, about_center: &Matrix3<f64>) -> Inertia {
        let (c, i) = (center, about_center);
        let square = c.norm_squared();
        let product = |a: usize, b: usize| i[(a, b)] - mass * c[a] * c[b];
        Inertia {
            mass,
            first: c * mass,
            second: [
                product(0, 0) + mass * square,
                product(1, 1) + mass * square,
                product(2, 2) + mass * square,
                product(0, 1),
                product(0, 2),
                product(1, 2),
            ],
        }
    }

    /// Momentum at velocity `v`, or the wrench that gives the acceleration `v` to a body at rest.
    #[inline]
    pub fn times(&self, v: &Motion) -> Wrench {
        let [xx, yy, zz, xy, xz, yz] = self.second;
        let w = &v.angular;
        let rotated = Vec3::new(
            xx * w.x + xy * w.y + xz * w.z,
            xy * w.x + yy * w.y + yz * w.z,
            xz * w.x + yz * w.y + zz * w.z,
        );
        Wrench {
            moment: rotated + self.first.cross(&v.linear),
            force: v.linear * self.mass + w.cross(&self.first),
        }
    }
}

impl AddAssign for Inertia {
    #[inline]
    fn add_assign(&mut self, other: Inertia) {
        self.mass += other.mass;
        self.first += other.first;
        for (a, b) in self.second.iter_mut().zip(other.second) {
            *a += b;
        }
    }
}
