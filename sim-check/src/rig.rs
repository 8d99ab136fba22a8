//! A robot file as a mechanism: the wheel with its legs, on its boom or free in its plane.

use nalgebra::Matrix3;
use saltus_pneumatics::Leg;
use saltus_robot::Robot;

use crate::SimError;
use crate::contact::{ContactPoint, Friction, Material, Surface, Travel};
use crate::mechanism::{Drag, JointParts, LegPart, Mechanism};
use crate::spatial::Vec3;
use crate::tree::{Body, Joint, Placement, Pose, Tree};

/// Mass of a leg without mass as a part of the robot's, and least moment of inertia of the wheel as
/// a part of that of its mass at the rim: what they do is below 1e-6 of anything.
const MASSLESS: f64 = 1e-6;

/// A robot as bodies in space: x along the travel, z up, the boom's base at y = −L.
///
/// Coordinates: travel x (m) and height z (m) of the axle, or with a boom its radius angle ψ (rad,
/// forward) and pivot angle θ (rad, up; and the bend of a flexible one); then the lean φ of the
/// first leg (rad), then each leg's extension (m).
#[derive(Clone, Debug)]
pub struct Rig {
    /// The mechanism.
    pub mechanism: Mechanism,
    /// Index of the wheel's body.
    pub wheel: usize,
    /// Indices of the legs' bodies; the first is the one that jumps, the next is 1/n turn forward.
    pub legs: Vec<usize>,
    /// Foot to wheel centre with the leg retracted (m).
    pub radius: f64,
    /// Length of the boom (m), if there is one.
    pub boom: Option<f64>,
}

impl Rig {
    /// The rig of `robot` on its ground, with `obstacles` upon it.
    ///
    /// # Errors
    /// [`SimError`] for a robot whose parts cannot be bodies.
    pub fn new(robot: &Robot, obstacles: &[Surface]) -> Result<Rig, SimError> {
        let mut tree = Tree::default();
        let mut joints = Vec::new();
        let carrier = match &robot.boom {
            Some(boom) => add_boom(&mut tree, &mut joints, boom, robot.body.radius)?,
            None => add_plane(&mut tree, &mut joints)?,
        };
        let wheel = add_wheel(
            &mut tree,
            robot,
            carrier,
            robot.boom.map_or(0.0, |b| b.length),
        )?;
        joints.push(JointParts {
            friction: robot.body.axle_friction,
            ..JointParts::default()
        });
        let legs = add_legs(&mut tree, robot, wheel)?;
        joints.resize(tree.bodies().len(), JointParts::default());

        let leg = Leg::new(robot, |_, x| x);
        let massless = robot.leg.body.mass == 0.0;
        let mut mechanism = Mechanism::new(tree, Vec3::new(0.0, 0.0, -robot.environment.gravity));
        mechanism.joints = joints;
        mechanism.legs = legs
            .iter()
            .map(|&body| LegPart {
                body,
                leg: leg.clone(),
                massless,
            })
            .collect();
        let foot = robot.foot.radius;
        mechanism.points = legs
            .iter()
            .enumerate()
            .map(|(k, &body)| ContactPoint {
                name: format!("foot {k}"),
                body,
                center: direction(k, legs.len()) * (robot.body.radius - foot),
                radius: foot,
            })
            .collect();
        mechanism.surfaces = vec![Surface::ground(robot.ground.slope)];
        mechanism.surfaces.extend_from_slice(obstacles);
        mechanism.material = material(robot);
        if let Some(boom) = &robot.boom {
            mechanism.travel = Travel::Around(Vec3::new(0.0, -boom.length, 0.0));
        }
        if robot.environment.drag > 0.0 {
            mechanism.drag = Some(Drag {
                body: wheel,
                coefficient: robot.environment.drag * robot.axle_mass(),
            });
        }
        Ok(Rig {
            mechanism,
            wheel,
            legs,
            radius: robot.body.radius,
            boom: robot.boom.map(|b| b.length),
        })
    }

    /// Coordinate of the wheel's lean (rad).
    pub fn lean_coordinate(&self) -> usize {
        self.mechanism.tree.coordinate_of(self.wheel)
    }

    /// Velocity of the wheel's lean (rad/s), relative to what carries the axle.
    pub fn lean_velocity(&self) -> usize {
        self.mechanism.tree.velocity_of(self.wheel)
    }

    /// Coordinate of the extension of leg `leg` (m).
    pub fn extension_coordinate(&self, leg: usize) -> usize {
        self.mechanism.tree.coordinate_of(self.legs[leg])
    }

    /// Travel x (m, along the arc L ψ with a boom) and height z (m) of the axle.
    pub fn axle(&self, q: &[f64]) -> [f64; 2] {
        match self.boom {
            Some(length) => {
                let (pivot, bend, part) = self.boom_angles(q, length);
                [
                    length * q[0],
                    self.radius + part * (pivot.sin() + (pivot + bend).sin()),
                ]
            }
            None => [q[0], q[1]],
        }
    }

    /// Their rates (m/s).
    pub fn axle_rates(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        match self.boom {
            Some(length) => {
                let (pivot, bend, part) = self.boom_angles(q, length);
                let (_, bending, _) = self.boom_angles(v, length);
                let rate = v[1] * pivot.cos() + (v[1] + bending) * (pivot + bend).cos();
                [length * v[0], part * rate]
            }
            None => [v[0], v[1]],
        }
    }

    /// A boom's pivot angle and bend among `x`, coordinates or velocities, and the length of each
    /// half (m).
    fn boom_angles(&self, x: &[f64], length: f64) -> (f64, f64, f64) {
        let bend = if self.lean_coordinate() == 3 {
            x[2]
        } else {
            0.0
        };
        (x[1], bend, 0.5 * length)
    }

    fn pose_at(&self, q: &[f64]) -> Pose {
        let mut pose = Pose::default();
        pose.set(
            &self.mechanism.tree,
            q,
            &vec![0.0; self.mechanism.tree.velocities()],
        );
        pose
    }

    /// Travel (m) of a place in space, as [`axle`](Self::axle) measures it.
    pub fn travel_of(&self, place: &Vec3) -> f64 {
        match self.boom {
            Some(length) => length * place.x.atan2(place.y + length),
            None => place.x,
        }
    }

    /// The robot on the foot of leg 0, retracted, at the lean `lean` (rad) and turning forward at
    /// `rate` (rad/s) about the foot, which is at travel 0 and does not slip along it: coordinates
    /// and velocities.
    ///
    /// # Errors
    /// [`SimError::Input`] for a lean or a rate that is not a number, or a lean at which the wheel
    /// would be below the ground.
    pub fn stand(&self, lean: f64, rate: f64) -> Result<(Vec<f64>, Vec<f64>), SimError> {
        let wrong = |name: &str, value, allowed| {
            Err(SimError::Input {
                name: name.into(),
                value,
                allowed,
            })
        };
        if lean.is_nan() || lean.abs() >= std::f64::consts::FRAC_PI_2 {
            return wrong("start lean (rad)", lean, "between -pi/2 and pi/2");
        }
        if rate.is_nan() || rate.abs() >= 1e3 {
            return wrong("approach rate (rad/s)", rate, "a finite number below 1000");
        }
        let tree = &self.mechanism.tree;
        let (mut q, mut v) = (vec![0.0; tree.coordinates()], vec![0.0; tree.velocities()]);
        q[self.lean_coordinate()] = lean;
        if self.boom.is_none() {
            q[1] = self.radius;
        }
        // The foot's gap is nearly linear in the height, or in the pivot angle; so is its travel in
        // the other.
        for _ in 0..30 {
            let (gap, place) = self.foot(&q);
            let travel = self.travel_of(&place);
            let slope = self.slope_of_gap(&q);
            q[1] -= gap / slope;
            q[0] -= travel / self.boom.unwrap_or(1.0);
            if gap.abs() < 1e-15 && travel.abs() < 1e-15 {
                break;
            }
        }
        v[self.lean_velocity()] = rate;
        let speeds = |v: &[f64]| self.foot_speeds(&q, v);
        let unit = |k: usize| {
            let mut e = vec![0.0; tree.velocities()];
            e[k] = 1.0;
            speeds(&e)
        };
        let (from_spin, first, second) = (speeds(&v), unit(0), unit(1));
        let determinant = first[0] * second[1] - first[1] * second[0];
        v[0] = -(from_spin[0] * second[1] - from_spin[1] * second[0]) / determinant;
        v[1] = -(first[0] * from_spin[1] - first[1] * from_spin[0]) / determinant;
        if v.iter().chain(&q).all(|x| x.is_finite()) {
            Ok((q, v))
        } else {
            wrong("start lean (rad)", lean, "one at which the robot stands")
        }
    }

    /// Gap (m) between foot 0 and the ground, and where it is nearest.
    fn foot(&self, q: &[f64]) -> (f64, Vec3) {
        let pose = self.pose_at(q);
        let point = &self.mechanism.points[0];
        let center = pose.frames[point.body].point(&point.center);
        let near = self.mechanism.surfaces[0].proximity(&center);
        (
            near.distance - point.radius,
            center - near.normal * point.radius,
        )
    }

    fn slope_of_gap(&self, q: &[f64]) -> f64 {
        let mut moved = q.to_vec();
        moved[1] += 1e-6;
        (self.foot(&moved).0 - self.foot(q).0) / 1e-6
    }

    /// Speeds (m/s) of foot 0 along the normal and along the travel.
    fn foot_speeds(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        let mut pose = Pose::default();
        pose.set(&self.mechanism.tree, q, v);
        let point = &self.mechanism.points[0];
        let center = pose.frames[point.body].point(&point.center);
        let near = self.mechanism.surfaces[0].proximity(&center);
        let place = center - near.normal * point.radius;
        let (along, _) = self.mechanism.travel.directions(&place, &near.normal);
        let speed = pose.velocities[point.body].at(&place);
        [speed.dot(&near.normal), speed.dot(&along)]
    }
}

/// From the axle to the foot of leg `k` of `n`, in the wheel: down at lean 0, and on forwards.
fn direction(k: usize, n: usize) -> Vec3 {
    let angle = std::f64::consts::TAU * k as f64 / n as f64;
    Vec3::new(angle.sin(), 0.0, -angle.cos())
}

fn link(name: &str, parent: Option<usize>, joint: Joint, at: Vec3) -> Body {
    Body {
        name: name.into(),
        parent,
        joint,
        placement: Placement::at(at),
        mass: 0.0,
        center: Vec3::zeros(),
        inertia: Matrix3::zeros(),
    }
}

fn add_plane(tree: &mut Tree, joints: &mut Vec<JointParts>) -> Result<usize, SimError> {
    let travel = tree.add(link(
        "travel",
        None,
        Joint::Prismatic(Vec3::x()),
        Vec3::zeros(),
    ))?;
    let height = tree.add(link(
        "height",
        Some(travel),
        Joint::Prismatic(Vec3::z()),
        Vec3::zeros(),
    ))?;
    joints.resize(2, JointParts::default());
    Ok(height)
}

/// A boom of length L along y from its base, in two halves with a spring between where it bends.
fn add_boom(
    tree: &mut Tree,
    joints: &mut Vec<JointParts>,
    boom: &saltus_robot::Boom,
    height: f64,
) -> Result<usize, SimError> {
    let base = Vec3::new(0.0, -boom.length, height);
    let turn = tree.add(link("boom turn", None, Joint::Revolute(-Vec3::z()), base))?;
    joints.push(JointParts::default());
    let rod = |name: &str, parent: usize, at: Vec3, length: f64| {
        let mass = boom.mass * length / boom.length;
        let across = mass * (3.0 * boom.radius * boom.radius + length * length) / 12.0;
        Body {
            mass,
            center: Vec3::y() * (length / 2.0),
            inertia: Matrix3::from_diagonal(&Vec3::new(
                across,
                0.5 * mass * boom.radius * boom.radius,
                across,
            )),
            ..link(name, Some(parent), Joint::Revolute(Vec3::x()), at)
        }
    };
    let parts = if boom.flex.is_some() { 2 } else { 1 };
    let length = boom.length / f64::from(parts);
    let mut inner = rod("boom", turn, Vec3::zeros(), length);
    if let Some(weight) = boom.counterweight {
        inner.add_point_mass(weight.mass, -Vec3::y() * weight.distance);
    }
    let inner = tree.add(inner)?;
    joints.push(JointParts::default());
    let Some(stiffness) = boom.flex else {
        return Ok(inner);
    };
    joints.push(JointParts {
        spring: (stiffness, 0.0),
        ..JointParts::default()
    });
    tree.add(rod("boom's outer half", inner, Vec3::y() * length, length))
}

fn add_wheel(tree: &mut Tree, robot: &Robot, carrier: usize, boom: f64) -> Result<usize, SimError> {
    let massless = robot.leg.body.mass == 0.0;
    let mass = robot.wheel_mass()
        - if massless {
            f64::from(robot.body.legs) * MASSLESS * robot.body.mass
        } else {
            0.0
        };
    let (offset, angle) = (robot.body.imbalance, robot.body.imbalance_angle);
    let center = Vec3::new(angle.sin(), 0.0, -angle.cos()) * offset;
    // A disc: about a diameter half of what it is about the axle.
    let least = MASSLESS * robot.body.mass * robot.body.radius * robot.body.radius;
    let axle = (robot.wheel_inertia() - mass * offset * offset).max(least);
    let inertia = Matrix3::from_diagonal(&Vec3::new(axle / 2.0, axle, axle / 2.0));
    let at = match (robot.boom, tree.bodies().len()) {
        (None, _) => Vec3::zeros(),
        (Some(_), 3) => Vec3::y() * (boom / 2.0),
        (Some(_), _) => Vec3::y() * boom,
    };
    tree.add(Body {
        mass,
        center,
        inertia,
        ..link("wheel", Some(carrier), Joint::Revolute(Vec3::y()), at)
    })
}

fn add_legs(tree: &mut Tree, robot: &Robot, wheel: usize) -> Result<Vec<usize>, SimError> {
    let part = &robot.leg.body;
    let n = robot.body.legs as usize;
    (0..n)
        .map(|k| {
            let way = direction(k, n);
            let mut body = link(
                &format!("leg {k}"),
                Some(wheel),
                Joint::Prismatic(way),
                Vec3::zeros(),
            );
            if part.mass == 0.0 {
                // At the axle, where it adds nothing to the wheel's moment of inertia.
                body.mass = MASSLESS * robot.body.mass;
            } else {
                body.mass = part.mass;
                body.center = way * part.center;
                let along = 0.5 * part.mass * part.radius * part.radius;
                let across = part.inertia();
                body.inertia =
                    Matrix3::identity() * across + way * way.transpose() * (along - across);
            }
            tree.add(body)
        })
        .collect()
}

fn material(robot: &Robot) -> Material {
    let ground = &robot.ground;
    Material {
        friction: Friction::Axes {
            along: (ground.static_friction, ground.kinetic_friction),
            across: (ground.across_friction, ground.across_friction),
        },
        restitution: ground.restitution,
        compliance: ground
            .stiffness
            .map(|stiffness| (stiffness, ground.damping)),
    }
}
