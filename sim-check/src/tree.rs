//! A tree of rigid bodies in reduced coordinates: where everything is, and the equations of motion
//! M(q) v̇ + h(q, v) = τ.
//!
//! Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapters 5 (Newton–Euler) and 6
//! (composite bodies), with every quantity in world axes about one origin.

use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion};
use saltus_robot::bodies::RigidBody;

use crate::SimError;
use crate::error::{ensure, finite, not_negative, require};
use crate::spatial::{Inertia, Motion, Vec3, Wrench};

/// Where a frame is in another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Its axes, as columns.
    pub rotation: Matrix3<f64>,
    /// Its origin (m).
    pub position: Vec3,
}

impl Placement {
    /// The frame itself.
    pub fn identity() -> Placement {
        Placement {
            rotation: Matrix3::identity(),
            position: Vec3::zeros(),
        }
    }

    /// A frame with the same axes, at `position` (m).
    pub fn at(position: Vec3) -> Placement {
        Placement {
            rotation: Matrix3::identity(),
            position,
        }
    }

    /// The frame `inner`, which is given in this one, in this one's own surroundings.
    #[inline]
    pub fn then(&self, inner: &Placement) -> Placement {
        Placement {
            rotation: self.rotation * inner.rotation,
            position: self.position + self.rotation * inner.position,
        }
    }

    /// Its axes as a unit quaternion x, y, z, w.
    pub fn quaternion(&self) -> [f64; 4] {
        let rotation = Rotation3::from_matrix_unchecked(self.rotation);
        UnitQuaternion::from_rotation_matrix(&rotation)
            .coords
            .into()
    }

    /// A point (m) of this frame in its surroundings.
    #[inline]
    pub fn point(&self, inner: &Vec3) -> Vec3 {
        self.position + self.rotation * inner
    }
}

/// How a body can move on its parent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Joint {
    /// Turns about a unit axis through the joint's origin: 1 coordinate (rad).
    Revolute(Vec3),
    /// Slides along a unit axis: 1 coordinate (m).
    Prismatic(Vec3),
    /// Moves freely, on the world only: 7 coordinates, the position (m) and a unit quaternion (w,
    /// x, y, z); 6 velocities, linear (m/s) and angular (rad/s), both in world axes.
    Free,
}

impl Joint {
    /// Numbers of coordinates and of velocities.
    pub fn sizes(&self) -> (usize, usize) {
        match self {
            Joint::Revolute(_) | Joint::Prismatic(_) => (1, 1),
            Joint::Free => (7, 6),
        }
    }
}

/// A rigid body and the joint that carries it.
#[derive(Clone, Debug)]
pub struct Body {
    /// What it is called.
    pub name: String,
    /// Index of the body that carries it; none: the world.
    pub parent: Option<usize>,
    /// The joint.
    pub joint: Joint,
    /// The joint's frame in its parent's; the body's frame is there where the joint's coordinate
    /// is 0.
    pub placement: Placement,
    /// Mass (kg), ≥ 0.
    pub mass: f64,
    /// Centre of mass (m), body frame.
    pub center: Vec3,
    /// Moments of inertia (kg m²) about the centre, body axes.
    pub inertia: Matrix3<f64>,
}

/// A tree of bodies, each after its parent.
#[derive(Clone, Debug, Default)]
pub struct Tree {
    bodies: Vec<Body>,
    /// First coordinate and first velocity of each body's joint.
    first: Vec<(usize, usize)>,
    /// Body that each velocity belongs to.
    carrier: Vec<usize>,
    /// The velocity before it on the way to the world.
    before: Vec<Option<usize>>,
    coordinates: usize,
    /// Whether each body's placement has its parent's axes.
    straight: Vec<bool>,
}

impl Tree {
    /// Adds `body` and gives its index.
    ///
    /// # Errors
    /// [`SimError::Input`] for numbers that no body has, or a parent that is not there yet.
    pub fn add(&mut self, body: Body) -> Result<usize, SimError> {
        self.check(&body)?;
        let index = self.bodies.len();
        let (coordinates, velocities) = body.joint.sizes();
        self.first.push((self.coordinates, self.carrier.len()));
        self.coordinates += coordinates;
        let mut before = body.parent.and_then(|p| self.last_velocity(p));
        for _ in 0..velocities {
            self.before.push(before);
            before = Some(self.carrier.len());
            self.carrier.push(index);
        }
        self.straight
            .push(body.placement.rotation == Matrix3::identity());
        self.bodies.push(body);
        Ok(index)
    }

    fn check(&self, body: &Body) -> Result<(), SimError> {
        let parent = body.parent.map_or(0.0, |parent| parent as f64);
        let is_known = body.parent.is_none_or(|parent| parent < self.bodies.len());
        body.check()
            .and_then(|()| require(is_known, "parent", parent, "a body that was added before"))
            .map_err(|error| match error {
                SimError::Input {
                    name,
                    value,
                    allowed,
                } => SimError::Input {
                    name: format!("body '{}': {name}", body.name),
                    value,
                    allowed,
                },
                other => other,
            })
    }

    /// The bodies, in the order in which they were added.
    pub fn bodies(&self) -> &[Body] {
        &self.bodies
    }

    /// Index of the body called `name`.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.bodies.iter().position(|b| b.name == name)
    }

    /// Number of coordinates q.
    pub fn coordinates(&self) -> usize {
        self.coordinates
    }

    /// Number of velocities v.
    pub fn velocities(&self) -> usize {
        self.carrier.len()
    }

    /// First coordinate of the joint that carries `body`.
    pub fn coordinate_of(&self, body: usize) -> usize {
        self.first[body].0
    }

    /// First velocity of the joint that carries `body`.
    pub fn velocity_of(&self, body: usize) -> usize {
        self.first[body].1
    }

    /// The last velocity that moves `body`.
    fn last_velocity(&self, body: usize) -> Option<usize> {
        let mut here = Some(body);
        while let Some(b) = here {
            let velocities = self.bodies[b].joint.sizes().1;
            if velocities > 0 {
                return Some(self.first[b].1 + velocities - 1);
            }
            here = self.bodies[b].parent;
        }
        None
    }

    /// The velocities that move `body`, last first.
    pub(crate) fn path(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(self.last_velocity(body), |&k| self.before[k])
    }

    /// q̇ at coordinates `q` and velocities `v`.
    pub(crate) fn coordinate_rates(&self, q: &[f64], v: &[f64], rates: &mut [f64]) {
        for (body, &(iq, iv)) in self.bodies.iter().zip(&self.first) {
            match body.joint {
                Joint::Revolute(_) | Joint::Prismatic(_) => rates[iq] = v[iv],
                Joint::Free => {
                    rates[iq..iq + 3].copy_from_slice(&v[iv..iv + 3]);
                    let (w, spin) = (&v[iv + 3..iv + 6], &q[iq + 3..iq + 7]);
                    let rate = Quaternion::new(0.0, w[0], w[1], w[2])
                        * Quaternion::new(spin[0], spin[1], spin[2], spin[3])
                        * 0.5;
                    rates[iq + 3..iq + 7].copy_from_slice(&[rate.w, rate.i, rate.j, rate.k]);
                }
            }
        }
    }

    /// Brings quaternions back to length 1.
    pub(crate) fn normalize(&self, q: &mut [f64]) {
        for (body, &(iq, _)) in self.bodies.iter().zip(&self.first) {
            if body.joint == Joint::Free {
                let spin = &mut q[iq + 3..iq + 7];
                let length = spin.iter().map(|x| x * x).sum::<f64>().sqrt();
                for x in spin {
                    *x /= length;
                }
            }
        }
    }

    /// The tree in which each of `held` (by body) stays on its parent as it is at the coordinates
    /// `q`.
    pub(crate) fn weld(&self, held: &[bool], q: &[f64]) -> Welded {
        let mut welded = Welded {
            tree: Tree::default(),
            home: Vec::new(),
            coordinates: Vec::new(),
            velocities: Vec::new(),
        };
        for (i, body) in self.bodies.iter().enumerate() {
            let carried = match body.parent {
                Some(p) => {
                    let (home, placement): (Option<usize>, Placement) = welded.home[p];
                    (home, placement.then(&body.placement))
                }
                None => (None, body.placement),
            };
            let (iq, iv) = self.first[i];
            if held[i] {
                let moved = joint_placement(&body.joint, &q[iq..]);
                let home = (carried.0, carried.1.then(&moved));
                if let Some(h) = home.0 {
                    welded.tree.bodies[h].merge(body, &home.1);
                }
                welded.home.push(home);
                continue;
            }
            let (coordinates, velocities) = body.joint.sizes();
            welded.coordinates.extend(iq..iq + coordinates);
            welded.velocities.extend(iv..iv + velocities);
            let body = Body {
                parent: carried.0,
                placement: carried.1,
                ..body.clone()
            };
            let index = welded.tree.push(&body);
            welded.home.push((Some(index), Placement::identity()));
        }
        welded
    }

    /// Adds a body that needs no check.
    fn push(&mut self, body: &Body) -> usize {
        let sound = self.add(body.clone());
        sound.unwrap_or_else(|_| {
            unreachable!("a body of a sound tree is sound: {}", body.name);
        })
    }
}

impl Body {
    /// Fixes a point of `mass` (kg) to the body at `place` (m, body frame).
    pub fn add_point_mass(&mut self, mass: f64, place: Vec3) {
        let point = Body {
            mass,
            center: Vec3::zeros(),
            inertia: Matrix3::zeros(),
            ..self.clone()
        };
        self.merge(&point, &Placement::at(place));
    }

    /// Checks mass, geometry and joint.
    fn check(&self) -> Result<(), SimError> {
        not_negative("mass (kg)", self.mass)?;
        let Placement { rotation, position } = &self.placement;
        for numbers in [
            self.center.as_slice(),
            self.inertia.as_slice(),
            position.as_slice(),
        ] {
            finite("geometry (m, kg m²)", numbers)?;
        }
        let turned = (rotation.transpose() * rotation - Matrix3::identity())
            .abs()
            .max();
        ensure! {
            "placement's rotation, deviation", turned, turned < 1e-9 && rotation.determinant() > 0.0
                => "a rotation matrix";
        }
        self.check_inertia()?;
        match self.joint {
            Joint::Revolute(axis) | Joint::Prismatic(axis) => require(
                (axis.norm() - 1.0).abs() <= 1e-12,
                "joint axis' length",
                axis.norm(),
                "1",
            ),
            Joint::Free => {
                let parent = self.parent.map_or(0.0, |parent| parent as f64);
                let is_first = self.parent.is_none();
                require(is_first, "free joint's parent", parent, "the world")
            }
        }
    }

    fn check_inertia(&self) -> Result<(), SimError> {
        let principal = self.inertia.symmetric_eigenvalues();
        let asymmetric = (self.inertia - self.inertia.transpose()).abs().max();
        let (sum, least, greatest) = (principal.sum(), principal.min(), principal.max());
        // Round-off of a rod, whose moment about its own axis is nearly 0.
        let slack = 1e-12 * greatest.max(f64::MIN_POSITIVE);
        require(
            !(least < -slack || 2.0 * greatest > sum + slack || asymmetric > slack),
            "principal moment (kg m²)",
            if least < 0.0 { least } else { greatest },
            "symmetric, none negative, none above the sum of the other two",
        )
    }

    /// This link with the mass of `body`, given in its axes.
    pub(crate) fn of(self, body: &RigidBody) -> Body {
        Body {
            mass: body.mass,
            center: body.center.into(),
            inertia: body.inertia.into(),
            ..self
        }
    }

    /// Takes in `other`, whose frame is at `placement` in this body's.
    fn merge(&mut self, other: &Body, placement: &Placement) {
        let center = placement.point(&other.center);
        let turned = placement.rotation * other.inertia * placement.rotation.transpose();
        let mass = self.mass + other.mass;
        if mass == 0.0 {
            return;
        }
        let about = |mass: f64, from: Vec3| {
            (Matrix3::identity() * from.norm_squared() - from * from.transpose()) * mass
        };
        let both = (self.center * self.mass + center * other.mass) / mass;
        self.inertia +=
            turned + about(self.mass, self.center - both) + about(other.mass, center - both);
        (self.center, self.mass) = (both, mass);
    }
}

/// A tree with some joints held.
#[derive(Clone, Debug)]
pub(crate) struct Welded {
    pub tree: Tree,
    /// Each body of the whole tree: the body that it is now part of (none: the world), and its
    /// frame there.
    pub home: Vec<(Option<usize>, Placement)>,
    /// Each coordinate and velocity in the whole tree.
    pub coordinates: Vec<usize>,
    pub velocities: Vec<usize>,
}

/// The body's frame in its joint's at the joint's coordinates, which `q` begins with.
fn joint_placement(joint: &Joint, q: &[f64]) -> Placement {
    match joint {
        Joint::Revolute(axis) => Placement {
            rotation: turn(axis, q[0]),
            position: Vec3::zeros(),
        },
        Joint::Prismatic(axis) => Placement::at(axis * q[0]),
        Joint::Free => Placement {
            rotation: UnitQuaternion::new_normalize(Quaternion::new(q[3], q[4], q[5], q[6]))
                .to_rotation_matrix()
                .into_inner(),
            position: Vec3::new(q[0], q[1], q[2]),
        },
    }
}

/// Rotation by `angle` (rad) about the unit vector `axis`.
#[inline]
fn turn(axis: &Vec3, angle: f64) -> Matrix3<f64> {
    let (s, c) = angle.sin_cos();
    let (x, y, z) = (axis.x, axis.y, axis.z);
    let k = 1.0 - c;
    Matrix3::new(
        c + x * x * k,
        x * y * k - z * s,
        x * z * k + y * s,
        y * x * k + z * s,
        c + y * y * k,
        y * z * k - x * s,
        z * x * k - y * s,
        z * y * k + x * s,
        c + z * z * k,
    )
}

/// `rotation` after a turn by `angle` (rad) about the unit vector `axis` of its own; about a base
/// axis only two columns change.
#[inline]
fn turned(rotation: &Matrix3<f64>, axis: &Vec3, angle: f64) -> Matrix3<f64> {
    let Some(k) = (0..3).find(|&k| axis[k].abs() == 1.0) else {
        return rotation * turn(axis, angle);
    };
    let (s, c) = angle.sin_cos();
    let s = s * axis[k];
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let mut turned = *rotation;
    for row in 0..3 {
        let (a, b) = (rotation[(row, i)], rotation[(row, j)]);
        turned[(row, i)] = c * a + s * b;
        turned[(row, j)] = c * b - s * a;
    }
    turned
}

/// R I Rᵀ of a symmetric I.
#[inline]
fn rotated(rotation: &Matrix3<f64>, inertia: &Matrix3<f64>) -> Matrix3<f64> {
    let half = rotation * inertia;
    let mut whole = Matrix3::zeros();
    for row in 0..3 {
        for column in 0..=row {
            let sum = half[(row, 0)] * rotation[(column, 0)]
                + half[(row, 1)] * rotation[(column, 1)]
                + half[(row, 2)] * rotation[(column, 2)];
            whole[(row, column)] = sum;
            whole[(column, row)] = sum;
        }
    }
    whole
}

/// Where a tree is and how it moves.
#[derive(Clone, Debug, Default)]
pub struct Pose {
    /// Each body's frame in the world.
    pub frames: Vec<Placement>,
    /// Each body's velocity.
    pub velocities: Vec<Motion>,
    /// What each velocity moves its body along.
    pub(crate) axes: Vec<Motion>,
    /// Each body's acceleration where all v̇ are 0.
    pub(crate) bias: Vec<Motion>,
    inertias: Vec<Inertia>,
    composites: Vec<Inertia>,
    wrenches: Vec<Wrench>,
}

impl Pose {
    /// Puts `tree` at coordinates `q` and velocities `v`.
    pub fn set(&mut self, tree: &Tree, q: &[f64], v: &[f64]) {
        self.frames.clear();
        self.velocities.clear();
        self.axes.clear();
        self.bias.clear();
        let world = (Placement::identity(), Motion::default(), Motion::default());
        for ((body, &(iq, iv)), straight) in tree.bodies.iter().zip(&tree.first).zip(&tree.straight)
        {
            let (parent, velocity, bias) = match body.parent {
                Some(p) => (self.frames[p], self.velocities[p], self.bias[p]),
                None => world,
            };
            let joint = if *straight {
                Placement {
                    rotation: parent.rotation,
                    position: parent.point(&body.placement.position),
                }
            } else {
                parent.then(&body.placement)
            };
            let (q, v) = (&q[iq..], &v[iv..]);
            let (frame, moved, extra) = match &body.joint {
                Joint::Revolute(axis) => {
                    let angular = joint.rotation * axis;
                    let linear = joint.position.cross(&angular);
                    let along = Motion { angular, linear };
                    let frame = Placement {
                        rotation: turned(&joint.rotation, axis, q[0]),
                        position: joint.position,
                    };
                    self.axes.push(along);
                    (frame, along * v[0], velocity.cross(&along) * v[0])
                }
                Joint::Prismatic(axis) => {
                    let linear = joint.rotation * axis;
                    let angular = Vec3::zeros();
                    let along = Motion { angular, linear };
                    let frame = Placement {
                        rotation: joint.rotation,
                        position: joint.position + linear * q[0],
                    };
                    self.axes.push(along);
                    (frame, along * v[0], velocity.cross(&along) * v[0])
                }
                Joint::Free => self.move_freely(&joint, q, v),
            };
            self.frames.push(frame);
            self.velocities.push(velocity + moved);
            self.bias.push(bias + extra);
        }
    }

    /// Frame and velocity of a body that moves freely from the frame `joint`, and its acceleration
    /// where all v̇ are 0.
    fn move_freely(
        &mut self,
        joint: &Placement,
        q: &[f64],
        v: &[f64],
    ) -> (Placement, Motion, Motion) {
        let frame = joint.then(&joint_placement(&Joint::Free, &q[..7]));
        let (turned, at) = (joint.rotation, frame.position);
        let column = |k: usize| turned.column(k).into_owned();
        let linear = (0..3).map(|k| Motion {
            angular: Vec3::zeros(),
            linear: column(k),
        });
        let angular = (0..3).map(|k| Motion {
            angular: column(k),
            linear: at.cross(&column(k)),
        });
        self.axes.extend(linear.chain(angular));
        let speed = turned * Vec3::new(v[0], v[1], v[2]);
        let spin = turned * Vec3::new(v[3], v[4], v[5]);
        let moved = Motion {
            angular: spin,
            linear: speed + at.cross(&spin),
        };
        // The axes of rotation keep their direction and move with the body's origin.
        let extra = Motion {
            angular: Vec3::zeros(),
            linear: speed.cross(&spin),
        };
        (frame, moved, extra)
    }

    /// M (row by row, `tree.velocities()` squared) and h, under gravity `gravity` (m/s²).
    pub(crate) fn equations(
        &mut self,
        tree: &Tree,
        gravity: &Vec3,
        mass: &mut [f64],
        bias: &mut [f64],
    ) {
        let n = tree.velocities();
        self.inertias.clear();
        self.wrenches.clear();
        for (i, body) in tree.bodies.iter().enumerate() {
            let frame = &self.frames[i];
            let inertia = if body.mass == 0.0 {
                Inertia::default()
            } else {
                Inertia::new(
                    body.mass,
                    &frame.point(&body.center),
                    &rotated(&frame.rotation, &body.inertia),
                )
            };
            let v = &self.velocities[i];
            let a = self.bias[i]
                + Motion {
                    angular: Vec3::zeros(),
                    linear: -gravity,
                };
            self.inertias.push(inertia);
            self.wrenches.push(if body.mass == 0.0 {
                Wrench::default()
            } else {
                inertia.times(&a) + v.cross_wrench(&inertia.times(v))
            });
        }
        self.composites.clone_from(&self.inertias);
        for (i, body) in tree.bodies.iter().enumerate().rev() {
            if let Some(p) = body.parent {
                let (composite, wrench) = (self.composites[i], self.wrenches[i]);
                self.composites[p] += composite;
                self.wrenches[p] += wrench;
            }
        }
        mass[..n * n].fill(0.0);
        for k in 0..n {
            let body = tree.carrier[k];
            let along = &self.axes[k];
            bias[k] = along.dot(&self.wrenches[body]);
            let momentum = self.composites[body].times(along);
            let mut other = Some(k);
            while let Some(l) = other {
                let coupling = self.axes[l].dot(&momentum);
                mass[k * n + l] = coupling;
                mass[l * n + k] = coupling;
                other = tree.before[l];
            }
        }
    }

    /// Kinetic energy (J) of `tree`.
    pub fn kinetic_energy(&self, tree: &Tree) -> f64 {
        self.parts(tree)
            .map(|(inertia, v)| 0.5 * v.dot(&inertia.times(&v)))
            .sum()
    }

    /// Potential energy (J) of the weight under `gravity` (m/s²), 0 at the world's origin.
    pub fn potential_energy(&self, tree: &Tree, gravity: &Vec3) -> f64 {
        self.parts(tree)
            .map(|(inertia, _)| -inertia.first.dot(gravity))
            .sum()
    }

    /// Momentum: the linear one (kg m/s), and the angular one about the centre of mass (kg m²/s).
    pub fn momentum(&self, tree: &Tree) -> (Vec3, Vec3) {
        let mut total = Wrench::default();
        let (mut mass, mut first) = (0.0, Vec3::zeros());
        for (inertia, v) in self.parts(tree) {
            total += inertia.times(&v);
            mass += inertia.mass;
            first += inertia.first;
        }
        let center = if mass > 0.0 { first / mass } else { first };
        (total.force, total.moment - center.cross(&total.force))
    }

    /// Each body's inertia and velocity.
    fn parts<'a>(&'a self, tree: &'a Tree) -> impl Iterator<Item = (Inertia, Motion)> + 'a {
        tree.bodies.iter().enumerate().map(|(i, body)| {
            let frame = &self.frames[i];
            let turned = frame.rotation * body.inertia * frame.rotation.transpose();
            (
                Inertia::new(body.mass, &frame.point(&body.center), &turned),
                self.velocities[i],
            )
        })
    }
}
