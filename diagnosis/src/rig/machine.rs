//! Equations of motion of a wheel with legs on a boom, or free in its plane: kinematics, mass matrix
//! and forces.
//!
//! Coordinates q: radius angle ψ (rad, forward) and pivot angle θ (rad, up), or travel x and height
//! z (m) without a boom; the bend of the boom (rad); the lean φ of the leg (rad); its extension d
//! (m). What a robot has not is held. All vectors are written in axes that turn with ψ: x forward,
//! y outward along the level boom, z up, from the boom's base.

use nalgebra::{Matrix3, SMatrix, SVector};
use saltus_robot::Robot;

use super::bodies::{Bodies, Rigid, V3};
use super::contact::Floor;

pub(super) const N: usize = 5;
pub(super) type Coordinates = SVector<f64, N>;
pub(super) type Square = SMatrix<f64, N, N>;

pub(super) const TURN: usize = 0;
pub(super) const PIVOT: usize = 1;
pub(super) const BEND: usize = 2;
pub(super) const LEAN: usize = 3;
pub(super) const LEG: usize = 4;

/// A robot, as far as its motion goes; the force of its leg is given.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    pub(super) boom: Option<f64>,
    /// Stiffness of the bend (N m/rad).
    flex: Option<f64>,
    bodies: Bodies,
    pub(super) gravity: f64,
    /// Drag (kg/m): −`drag` |v| v at the axle.
    drag: f64,
    /// Dry friction of the axle (N m).
    pub(super) axle_friction: f64,
    pub(super) radius: f64,
    pub(super) foot: f64,
    pub(super) floor: Floor,
    /// Terms that no listed cause has.
    extra: super::Extra,
    /// Mass (kg) that the leg of a cylinder on the bench lifts; the robot is then not there.
    pub(super) load: Option<f64>,
}

/// Geometry and velocities at an instant.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// Directions of the boom's halves, and from the axle to the foot.
    outward: [V3; 2],
    pub(super) down: V3,
    hinge: V3,
    pub(super) axle: V3,
    /// Rotation of the wheel.
    wheel: Matrix3<f64>,
    /// Angular velocity and its rate where all accelerations are 0: of the boom's halves and of the
    /// wheel.
    pub(super) spin: [V3; 3],
    pub(super) spin_rate: [V3; 3],
    /// Velocity of the axle; acceleration of hinge and axle where all accelerations are 0.
    pub(super) axle_rate: V3,
    pub(super) bias: [V3; 2],
}

/// A body in its place.
struct Link<'a> {
    body: &'a Rigid,
    /// Its axes, and which angular velocity of the frame is its own.
    axes: Matrix3<f64>,
    spin: usize,
    /// Joints that it moves with.
    joints: &'static [usize],
    /// Its joint (m), and the acceleration of that where all accelerations are 0.
    from: V3,
    bias: V3,
    /// How far (m) it is slid along the leg, and its rate.
    slide: Option<(f64, f64)>,
}

impl Machine {
    pub(super) fn new(robot: &Robot) -> Machine {
        Machine {
            boom: robot.boom.map(|b| b.length),
            flex: robot.boom.and_then(|b| b.flex),
            bodies: Bodies::new(robot),
            gravity: robot.environment.gravity,
            drag: robot.environment.drag * robot.axle_mass(),
            axle_friction: robot.body.axle_friction,
            radius: robot.body.radius,
            foot: robot.foot.radius,
            floor: Floor::new(&robot.ground),
            extra: super::Extra::default(),
            load: None,
        }
    }

    /// One cylinder of `robot` upright on the bench under a dead load (kg), which is all that it
    /// moves.
    pub(super) fn bench(robot: &Robot, load: f64) -> Machine {
        Machine {
            load: Some(load),
            ..Machine::new(robot)
        }
    }

    /// With terms that no listed cause has.
    pub(super) fn with(self, extra: super::Extra) -> Machine {
        Machine { extra, ..self }
    }

    /// Longest step (s) that follows soft ground under the mass of the leg.
    pub(super) fn soft_step(&self) -> f64 {
        self.floor.soft.map_or(f64::INFINITY, |(k, c)| {
            let stiff = (k / self.bodies.leg.mass)
                .sqrt()
                .max(c / self.bodies.leg.mass);
            (1.2 / stiff).max(2e-5)
        })
    }

    /// Longest step (s) that follows what bends; none where nothing does.
    pub(super) fn longest_step(&self) -> f64 {
        let (Some(stiffness), Some(length)) = (self.flex, self.boom) else {
            return f64::INFINITY;
        };
        // One half of the boom alone, turning about its end against the spring.
        let inertia = self.bodies.inner.mass.max(0.01) * (length / 2.0).powi(2) / 3.0;
        (0.25 / (4.0 * stiffness / inertia).sqrt()).max(1e-4)
    }

    /// Whether its boom bends.
    pub(super) fn bends(&self) -> bool {
        self.flex.is_some()
    }

    /// Whether it is a cylinder on the bench.
    pub(super) fn is_bench(&self) -> bool {
        self.load.is_some()
    }

    pub(super) fn frame(&self, q: &Coordinates, v: &Coordinates) -> Frame {
        let x = V3::x();
        let mut f = match self.boom {
            Some(length) => self.boom_frame(length, q, v),
            None => self.plane_frame(q, v),
        };
        let [_, second] = f.outward;
        f.spin[2] = f.spin[1] + second * v[LEAN];
        f.spin_rate[2] = f.spin_rate[1] + f.spin[1].cross(&second) * v[LEAN];
        // The wheel's axes: x' forward and z' up in its plane, turned by the lean about the boom's
        // direction.
        let up = x.cross(&second);
        let (sin, cos) = q[LEAN].sin_cos();
        let upward = up * cos + x * sin;
        f.wheel = Matrix3::from_columns(&[x * cos - up * sin, second, upward]);
        f.down = -upward;
        f
    }

    /// The frame of a boom of `length` (m), without the wheel.
    fn boom_frame(&self, length: f64, q: &Coordinates, v: &Coordinates) -> Frame {
        let x = V3::x();
        let direction = |angle: f64| {
            let (sin, cos) = angle.sin_cos();
            V3::new(0.0, cos, sin)
        };
        let first = direction(q[PIVOT]);
        let second = match self.flex {
            Some(_) => direction(q[PIVOT] + q[BEND]),
            None => first,
        };
        let turn = V3::new(0.0, 0.0, -v[TURN]);
        let (a, b) = (turn + x * v[PIVOT], turn + x * (v[PIVOT] + v[BEND]));
        let across = turn.cross(&x);
        let (ra, rb) = (across * v[PIVOT], across * (v[PIVOT] + v[BEND]));
        let (one, two) = (first * (0.5 * length), second * (0.5 * length));
        let of = |w: &V3, r: &V3, arm: &V3| r.cross(arm) + w.cross(&w.cross(arm));
        let at_hinge = of(&a, &ra, &one);
        Frame {
            outward: [first, second],
            hinge: one,
            axle: one + two,
            spin: [a, b, b],
            spin_rate: [ra, rb, rb],
            axle_rate: a.cross(&one) + b.cross(&two),
            bias: [at_hinge, at_hinge + of(&b, &rb, &two)],
            ..Frame::default()
        }
    }

    /// The frame of a robot without a boom, without the wheel.
    fn plane_frame(&self, q: &Coordinates, v: &Coordinates) -> Frame {
        Frame {
            outward: [V3::y(); 2],
            axle: V3::new(q[TURN], 0.0, q[PIVOT] - self.radius),
            axle_rate: V3::new(v[TURN], 0.0, v[PIVOT]),
            ..Frame::default()
        }
    }

    /// Column k: velocity of a point `at` of the wheel or the leg (`with_leg`) for a unit velocity
    /// k.
    pub(super) fn columns(&self, f: &Frame, at: &V3, with_leg: bool) -> [V3; N] {
        let from_axle = f.outward[1].cross(&(at - f.axle));
        let leg = if with_leg { f.down } else { V3::zeros() };
        if self.boom.is_some() {
            // −z × r and x × r.
            let bend = V3::new(0.0, f.hinge.z - at.z, at.y - f.hinge.y);
            [
                V3::new(at.y, -at.x, 0.0),
                V3::new(0.0, -at.z, at.y),
                bend,
                from_axle,
                leg,
            ]
        } else {
            [V3::x(), V3::z(), V3::zeros(), from_axle, leg]
        }
    }

    /// What `x` has along the angular velocity for a unit velocity `joint`.
    fn about(&self, f: &Frame, joint: usize, x: &V3) -> f64 {
        match joint {
            LEAN => f.outward[1].dot(x),
            TURN if self.boom.is_some() => -x.z,
            PIVOT | BEND if self.boom.is_some() => x.x,
            _ => 0.0,
        }
    }

    /// Mass matrix, and the forces on the coordinates without the leg's drive, the ground and dry
    /// friction of the axle.
    pub(super) fn assemble(
        &self,
        f: &Frame,
        q: &Coordinates,
        v: &Coordinates,
    ) -> (Square, Coordinates) {
        let (mut mass, mut force) = (Square::zeros(), Coordinates::zeros());
        if self.boom.is_some() {
            for half in &self.halves(f) {
                self.add(f, half, &mut mass, &mut force);
            }
        }
        // The bend moves only where there is one.
        let (of_wheel, of_leg): (&[usize], &[usize]) = if self.bends() {
            (&[TURN, PIVOT, BEND, LEAN], &[TURN, PIVOT, BEND, LEAN, LEG])
        } else {
            (&[TURN, PIVOT, LEAN], &[TURN, PIVOT, LEAN, LEG])
        };
        let wheel = Link {
            body: &self.bodies.wheel,
            axes: f.wheel,
            spin: 2,
            joints: of_wheel,
            from: f.axle,
            bias: f.bias[1],
            slide: None,
        };
        self.add(f, &wheel, &mut mass, &mut force);
        if self.bodies.leg.mass <= self.bodies.least {
            // What keeps its coordinate in the equations moves nothing else.
            mass[(LEG, LEG)] = self.bodies.least;
        } else {
            let leg = Link {
                body: &self.bodies.leg,
                joints: of_leg,
                slide: Some((q[LEG], v[LEG])),
                ..wheel
            };
            self.add(f, &leg, &mut mass, &mut force);
        }
        for j in 0..N {
            for i in 0..j {
                mass[(j, i)] = mass[(i, j)];
            }
        }
        self.apply(f, q, v, &mut force);
        (mass, force)
    }

    fn halves(&self, f: &Frame) -> [Link<'_>; 2] {
        let along = |y: &V3| Matrix3::from_columns(&[V3::x(), *y, V3::x().cross(y)]);
        let inner = Link {
            body: &self.bodies.inner,
            axes: along(&f.outward[0]),
            spin: 0,
            joints: &[TURN, PIVOT],
            from: V3::zeros(),
            bias: V3::zeros(),
            slide: None,
        };
        let outer = Link {
            body: &self.bodies.outer,
            axes: along(&f.outward[1]),
            spin: 1,
            joints: &[TURN, PIVOT, BEND],
            from: f.hinge,
            bias: f.bias[0],
            slide: None,
        };
        [inner, outer]
    }

    /// Adds a body to the mass matrix, of which it fills the upper half, and to the forces.
    fn add(&self, f: &Frame, link: &Link<'_>, mass: &mut Square, force: &mut Coordinates) {
        let body = link.body;
        if body.mass == 0.0 {
            return;
        }
        let (w, r) = (&f.spin[link.spin], &f.spin_rate[link.spin]);
        let mut arm = link.axes * body.center;
        let mut acceleration = link.bias;
        if let Some((d, speed)) = link.slide {
            arm += f.down * d;
            acceleration += 2.0 * w.cross(&f.down) * speed;
        }
        acceleration += r.cross(&arm) + w.cross(&w.cross(&arm));
        let lin = self.columns(f, &(link.from + arm), link.slide.is_some());
        let inertia = body.turned(&link.axes);
        let push = (V3::new(0.0, 0.0, -self.gravity) - acceleration) * body.mass;
        let torque = -(inertia * r + w.cross(&(inertia * w)));
        for (n, &j) in link.joints.iter().enumerate() {
            force[j] += lin[j].dot(&push) + self.about(f, j, &torque);
            let along = lin[j] * body.mass;
            let turned = match j {
                LEAN => inertia * f.outward[1],
                TURN => -inertia.column(2),
                PIVOT | BEND => inertia.column(0).into_owned(),
                _ => V3::zeros(),
            };
            for &i in &link.joints[..=n] {
                mass[(i, j)] += lin[i].dot(&along) + self.about(f, i, &turned);
            }
        }
    }

    /// Adds the forces of the bend, of the air and in the joints.
    fn apply(&self, f: &Frame, q: &Coordinates, v: &Coordinates, force: &mut Coordinates) {
        if let Some(stiffness) = self.flex {
            force[BEND] -= stiffness * q[BEND];
        }
        if self.drag > 0.0 {
            let push = f.axle_rate * (-self.drag * f.axle_rate.norm());
            let lin = self.columns(f, &f.axle, false);
            for j in 0..N {
                force[j] += lin[j].dot(&push);
            }
        }
        force[LEAN] -= self.extra.spin_damping * v[LEAN];
        if self.boom.is_some() {
            force[PIVOT] -=
                self.extra.pivot_damping * v[PIVOT] + self.extra.pivot_spring * q[PIVOT];
            force[TURN] -= self.extra.turn_damping * v[TURN];
        }
    }

    /// Height (m) of the axle above level ground at the start, and its rate (m/s).
    pub(super) fn height(&self, q: &Coordinates, v: &Coordinates) -> (f64, f64) {
        match self.boom {
            Some(length) => {
                let half = 0.5 * length;
                let (inner, outer) = (q[PIVOT], q[PIVOT] + q[BEND]);
                let rate = half * (v[PIVOT] * inner.cos() + (v[PIVOT] + v[BEND]) * outer.cos());
                (self.radius + half * (inner.sin() + outer.sin()), rate)
            }
            None => (q[PIVOT], v[PIVOT]),
        }
    }
}
