//! A robot file as a mechanism: the wheel with its legs, on its boom or free in its plane.

use nalgebra::Matrix3;
use saltus_pneumatics::Leg;
use saltus_robot::bodies::{MASSLESS, RigidBody};
use saltus_robot::space::Rest;
use saltus_robot::{Robot, Space, Struts};

use crate::SimError;
use crate::contact::{ContactPoint, Friction, Material, Surface, Travel};
use crate::error::{ensure, require};
use crate::mechanism::{Drag, JointParts, LegPart, Mechanism};
use crate::spatial::Vec3;
use crate::tree::{Body, Joint, Placement, Pose, Tree};

/// A robot as bodies in space: x along the travel, z up, the boom's base at y = −L.
///
/// Coordinates: travel x (m) and height z (m) of the axle, or with a boom its radius angle ψ (rad,
/// forward) and pivot angle θ (rad, up; and the bend of a flexible one); then the lean φ of the
/// first leg (rad), then each leg's extension (m). Of a robot that moves freely in space: where its legs meet (m), its
/// attitude as a unit quaternion w, x, y, z, then each leg's extension; what is said of a lean or an axle is not of it.
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
        let wheel = match (&robot.space, &robot.boom) {
            (Some(space), _) => add_core(&mut tree, robot, space)?,
            (None, Some(boom)) => {
                let carrier = add_boom(&mut tree, &mut joints, boom, robot.body.radius)?;
                add_wheel(&mut tree, robot, carrier)?
            }
            (None, None) => {
                let carrier = add_plane(&mut tree, &mut joints)?;
                add_wheel(&mut tree, robot, carrier)?
            }
        };
        joints.push(JointParts {
            friction: robot.body.axle_friction,
            ..JointParts::default()
        });
        let legs = add_legs(&mut tree, robot, wheel)?;
        joints.resize(tree.bodies().len(), JointParts::default());

        let massless = robot.leg.body.mass == 0.0;
        // Heights are above the ground, tilted or not.
        let (across, along) = robot.ground.tilt.sin_cos();
        let gravity = Vec3::new(-across, 0.0, -along) * robot.environment.gravity;
        let mut mechanism = Mechanism::new(tree, gravity);
        mechanism.joints = joints;
        mechanism.legs = legs
            .iter()
            .enumerate()
            .map(|(k, &body)| LegPart {
                body,
                leg: own_leg(robot, k),
                massless,
            })
            .collect();
        let foot = robot.foot.radius;
        mechanism.points = (0..)
            .zip(&legs)
            .map(|(k, &body)| ContactPoint {
                name: format!("foot {k}"),
                body,
                center: Vec3::from(robot.leg_direction(k)) * (robot.body.radius - foot),
                radius: foot,
                bar: None,
            })
            .collect();
        if let Some(struts) = robot.struts {
            mechanism.points.extend(bars(robot, &struts, wheel, &legs));
        }
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

    /// Rate (rad/s) of the wheel about its axle, in space: what a gyro on it says. On a boom that is
    /// raised, the turn about the base is a part of it.
    pub fn spin(&self, q: &[f64], v: &[f64]) -> f64 {
        let turn = self.boom.map_or(0.0, |length| {
            let (pivot, bend, _) = self.boom_angles(q, length);
            v[0] * (pivot + bend).sin()
        });
        v[self.lean_velocity()] - turn
    }

    /// Distance (m) between `surface` and what can touch it of the robot at coordinates `q`; negative
    /// where they overlap.
    pub fn clearance(&self, q: &[f64], surface: &Surface) -> f64 {
        let pose = self.pose_at(q);
        let gap = |point: &ContactPoint| {
            let frame = &pose.frames[point.body];
            let first = frame.point(&point.center);
            let nearest = match &point.bar {
                None => first,
                Some(end) => {
                    let along = frame.point(end) - first;
                    first + along * surface.nearest_on_bar(&first, &(first + along))
                }
            };
            surface.proximity(&nearest).distance - point.radius
        };
        let gaps = self.mechanism.points.iter().map(gap);
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// A block on the ground across the robot's way: from the travel `front` (m) on, `length` long
    /// and `height` high (m), and far wider than the robot.
    pub fn box_across(&self, front: f64, length: f64, height: f64) -> Surface {
        const WIDE: f64 = 0.5;
        let half = 0.5 * length;
        match self.boom {
            Some(boom) => Surface::TurnedBlock {
                low: Vec3::new(-half, boom - WIDE, 0.0),
                high: Vec3::new(half, boom + WIDE, height),
                about: Vec3::new(0.0, -boom, 0.0),
                turn: (front + half) / boom,
            },
            None => Surface::Block {
                low: Vec3::new(front, -WIDE, 0.0),
                high: Vec3::new(front + length, WIDE, height),
            },
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
        let (lean_key, rate_key) = ("start lean (rad)", "approach rate (rad/s)");
        let is_up = lean.abs() < std::f64::consts::FRAC_PI_2;
        require(is_up, lean_key, lean, "between -pi/2 and pi/2")?;
        ensure! { rate_key, rate, rate.abs() < 1e3 => "a finite number below 1000"; }
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
        let stands = v.iter().chain(&q).all(|x| x.is_finite());
        require(stands, lean_key, lean, "one at which the robot stands")?;
        Ok((q, v))
    }

    /// The robot at rest on the feet of leg `rear` and of the next, both retracted, with its axle at
    /// travel 0: coordinates.
    ///
    /// # Errors
    /// [`SimError::Input`] for a leg that is not there, or a robot of fewer than three legs, which
    /// does not stand on two.
    pub fn rest(&self, rear: usize) -> Result<Vec<f64>, SimError> {
        let legs = self.legs.len();
        ensure! { "legs of a robot that stands on two", legs as f64, legs >= 3 => "at least 3"; }
        require(rear < legs, "leg", rear as f64, "the number of a leg")?;
        let front = (rear + 1) % legs;
        let pitch = std::f64::consts::TAU / legs as f64;
        let mut q = vec![0.0; self.mechanism.tree.coordinates()];
        q[self.lean_coordinate()] = pitch * (rear as f64 + 0.5);
        if self.boom.is_none() {
            q[1] = self.radius;
        }
        // Both gaps are nearly linear in the height, or in the pivot angle, and in the lean.
        let unknowns = [1, self.lean_coordinate()];
        let gaps = |q: &[f64]| [self.foot_of(rear, q).0, self.foot_of(front, q).0];
        for _ in 0..30 {
            let now = gaps(&q);
            if now.iter().all(|gap| gap.abs() < 1e-15) {
                break;
            }
            let slopes = unknowns.map(|k| {
                let mut moved = q.clone();
                moved[k] += 1e-6;
                let then = gaps(&moved);
                [(then[0] - now[0]) / 1e-6, (then[1] - now[1]) / 1e-6]
            });
            let determinant = slopes[0][0] * slopes[1][1] - slopes[1][0] * slopes[0][1];
            q[unknowns[0]] -= (now[0] * slopes[1][1] - now[1] * slopes[1][0]) / determinant;
            q[unknowns[1]] -= (slopes[0][0] * now[1] - slopes[0][1] * now[0]) / determinant;
        }
        let stands = q.iter().all(|x| x.is_finite());
        ensure! { "slope of the ground", f64::NAN, stands => "one on which the robot stands"; }
        Ok(q)
    }

    /// A robot in space at rest on the feet of `legs`, three or more that make a face of the hull of all, retracted, on
    /// level ground, with the direction `ahead` (body axes) of it along the travel: coordinates.
    ///
    /// # Errors
    /// [`SimError::Input`] for a robot that is not in space, and for legs on which it does not stand.
    pub fn stand_on(&self, rest: &Rest, ahead: &[f64; 3]) -> Result<Vec<f64>, SimError> {
        let tree = &self.mechanism.tree;
        let is_free = matches!(tree.bodies()[self.wheel].joint, Joint::Free);
        let joint = self.wheel as f64;
        ensure! { "body of a robot in space", joint, is_free => "one that moves freely"; }
        let (down, ahead) = (Vec3::from(rest.down), Vec3::from(*ahead));
        let level = ahead - down * ahead.dot(&down);
        let length = level.norm();
        require(length > 1e-9, "heading's level part", length, "above 0")?;
        let (forward, up) = (level / length, -down);
        let left = up.cross(&forward);
        // Its rows are the world's axes in the body's.
        let rotation = Matrix3::from_rows(&[forward.transpose(), left.transpose(), up.transpose()]);
        let [x, y, z, w] = Placement {
            rotation,
            position: Vec3::zeros(),
        }
        .quaternion();
        let mut q = vec![0.0; tree.coordinates()];
        let first = tree.coordinate_of(self.wheel);
        let foot = self.mechanism.points[0].radius;
        q[first + 2] = rest.height * (self.radius - foot) + foot;
        q[first + 3..first + 7].copy_from_slice(&[w, x, y, z]);
        Ok(q)
    }

    /// Gap (m) between each leg's foot and what is nearest to it, the ground or an obstacle, at coordinates `q`.
    ///
    /// # Panics
    /// For coordinates that are not the rig's.
    pub fn foot_gaps(&self, q: &[f64]) -> Vec<f64> {
        let pose = self.pose_at(q);
        let gap = |leg: usize| {
            let point = &self.mechanism.points[leg];
            let center = pose.frames[point.body].point(&point.center);
            let surfaces = self.mechanism.surfaces.iter();
            let distances = surfaces.map(|surface| surface.proximity(&center).distance);
            distances.fold(f64::INFINITY, f64::min) - point.radius
        };
        (0..self.legs.len()).map(gap).collect()
    }

    /// Gap (m) between the foot of leg `leg` and the ground, and the speeds (m/s) of the foot along
    /// the ground's normal, along the travel and across it, where it is nearest.
    ///
    /// # Panics
    /// For a leg that is not there, and coordinates or velocities that are not the rig's.
    pub fn foot_motion(&self, leg: usize, q: &[f64], v: &[f64]) -> (f64, [f64; 3]) {
        let mut pose = Pose::default();
        pose.set(&self.mechanism.tree, q, v);
        let (gap, place, ways) = self.foot_in(&pose, leg);
        let speed = pose.velocities[self.mechanism.points[leg].body].at(&place);
        (gap, ways.map(|way| speed.dot(&way)))
    }

    /// A force (N) on the foot of leg `leg` in world axes, of its `parts` along the ground's normal,
    /// along the travel and across it.
    ///
    /// # Panics
    /// For a leg that is not there, and coordinates that are not the rig's.
    pub fn force_on_foot(&self, leg: usize, q: &[f64], parts: [f64; 3]) -> Vec3 {
        let (_, _, [normal, along, across]) = self.foot_in(&self.pose_at(q), leg);
        normal * parts[0] + along * parts[1] + across * parts[2]
    }

    /// Gap (m) between the foot of leg `leg` and the ground, where it is nearest, and the directions
    /// there: along the ground's normal, along the travel and across it.
    fn foot_in(&self, pose: &Pose, leg: usize) -> (f64, Vec3, [Vec3; 3]) {
        let point = &self.mechanism.points[leg];
        let center = pose.frames[point.body].point(&point.center);
        let near = self.mechanism.surfaces[0].proximity(&center);
        let place = center - near.normal * point.radius;
        let (along, across) = self.mechanism.travel.directions(&place, &near.normal);
        (
            near.distance - point.radius,
            place,
            [near.normal, along, across],
        )
    }

    /// Gap (m) between foot 0 and the ground, and where it is nearest.
    fn foot(&self, q: &[f64]) -> (f64, Vec3) {
        self.foot_of(0, q)
    }

    /// The same for the foot of leg `leg`.
    fn foot_of(&self, leg: usize, q: &[f64]) -> (f64, Vec3) {
        let (gap, place, _) = self.foot_in(&self.pose_at(q), leg);
        (gap, place)
    }

    fn slope_of_gap(&self, q: &[f64]) -> f64 {
        let mut moved = q.to_vec();
        moved[1] += 1e-6;
        (self.foot(&moved).0 - self.foot(q).0) / 1e-6
    }

    /// Speeds (m/s) of foot 0 along the normal and along the travel.
    fn foot_speeds(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        let (_, [normal, along, _]) = self.foot_motion(0, q, v);
        [normal, along]
    }
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

/// Leg `k` of `robot`.
fn own_leg(robot: &Robot, k: usize) -> Leg<f64> {
    if robot
        .space
        .as_ref()
        .is_none_or(|space| space.legs.is_empty())
    {
        return Leg::new(robot, |_, x| x);
    }
    let mut own = robot.clone();
    own.leg = robot.own_leg(k);
    Leg::new(&own, |_, x| x)
}

/// The body of a robot in space, which moves freely.
fn add_core(tree: &mut Tree, robot: &Robot, space: &Space) -> Result<usize, SimError> {
    let lent = if robot.leg.body.mass == 0.0 {
        f64::from(robot.body.legs) * MASSLESS * robot.body.mass
    } else {
        0.0
    };
    let core = robot.core(space, lent);
    tree.add(link("body", None, Joint::Free, Vec3::zeros()).of(&core))
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
    let pivot = Joint::Revolute(Vec3::x());
    let (inner, outer) = boom.rods();
    let mut inner = link("boom", Some(turn), pivot, Vec3::zeros()).of(&inner);
    if let Some(weight) = boom.counterweight {
        inner.add_point_mass(weight.mass, -Vec3::y() * weight.distance);
    }
    let inner = tree.add(inner)?;
    joints.push(JointParts::default());
    let (Some(stiffness), Some(outer)) = (boom.flex, outer) else {
        return Ok(inner);
    };
    joints.push(JointParts {
        spring: (stiffness, 0.0),
        damping: stiffness * boom.flex_time,
        ..JointParts::default()
    });
    let bend = Vec3::y() * boom.inner_length();
    tree.add(link("boom's outer half", Some(inner), pivot, bend).of(&outer))
}

fn add_wheel(tree: &mut Tree, robot: &Robot, carrier: usize) -> Result<usize, SimError> {
    let lent = if robot.leg.body.mass == 0.0 {
        f64::from(robot.body.legs) * MASSLESS * robot.body.mass
    } else {
        0.0
    };
    let mut disc = robot.wheel_disc(lent);
    let least = MASSLESS * robot.body.mass * robot.body.radius * robot.body.radius;
    let lacking = (least - disc.inertia[1][1]).max(0.0);
    for (k, share) in [0.5, 1.0, 0.5].into_iter().enumerate() {
        disc.inertia[k][k] += share * lacking;
    }
    // From the bend of a boom, or its base.
    let at = Vec3::y() * robot.boom.map_or(0.0, |boom| boom.inner_length());
    tree.add(link("wheel", Some(carrier), Joint::Revolute(Vec3::y()), at).of(&disc))
}

fn add_legs(tree: &mut Tree, robot: &Robot, wheel: usize) -> Result<Vec<usize>, SimError> {
    (0..robot.body.legs)
        .map(|k| {
            let mut rod = robot.leg_rod(k);
            if rod.mass == 0.0 {
                // At the axle, where it adds nothing to the wheel's moment of inertia.
                rod = RigidBody {
                    mass: MASSLESS * robot.body.mass,
                    ..RigidBody::default()
                };
            }
            let slide = Joint::Prismatic(robot.leg_direction(k).into());
            tree.add(link(&format!("leg {k}"), Some(wheel), slide, Vec3::zeros()).of(&rod))
        })
        .collect()
}

/// What else of a robot can touch an obstacle: its rods, which move with their legs, and the struts
/// between the legs' tubes.
///
/// The ground, which is flat, touches feet alone: all else lies between them.
fn bars(robot: &Robot, struts: &Struts, wheel: usize, legs: &[usize]) -> Vec<ContactPoint> {
    let direction = |k: u32| Vec3::from(robot.leg_direction(k));
    let mut bars = Vec::new();
    let rod = &robot.leg.body;
    for (k, &body) in (0..).zip(legs) {
        let (tip, end) = (
            robot.body.radius - rod.radius,
            robot.body.radius - rod.length,
        );
        if tip > end {
            bars.push(ContactPoint {
                name: format!("rod {k}"),
                body,
                center: direction(k) * tip,
                radius: rod.radius,
                bar: Some(direction(k) * end),
            });
        }
        let next = (k + 1) % robot.body.legs;
        bars.push(ContactPoint {
            name: format!("strut {k}"),
            body: wheel,
            center: direction(k) * struts.distance,
            radius: struts.radius,
            bar: Some(direction(next) * struts.distance),
        });
    }
    bars
}

fn material(robot: &Robot) -> Material {
    let ground = &robot.ground;
    let along = (ground.static_friction, ground.kinetic_friction);
    let friction = match robot.space {
        Some(_) => Friction::Cone {
            standing: along.0,
            slipping: along.1,
        },
        None => Friction::Axes {
            along,
            across: (ground.across_friction, ground.across_friction),
        },
    };
    Material {
        friction,
        restitution: ground.restitution,
        compliance: ground
            .stiffness
            .map(|stiffness| (stiffness, ground.damping)),
    }
}
