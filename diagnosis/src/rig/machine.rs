//! Equations of motion of a wheel with legs on a boom, or free in its plane: kinematics, mass
//! matrix and forces.
//!
//! Coordinates q: radius angle ψ (rad, forward) and pivot angle θ (rad, up), or travel x and height
//! z (m) without a boom; the bend of the boom (rad); the lean φ of the leg (rad); its extension d
//! (m). What a robot has not is held. All vectors are written in axes that turn with ψ: x forward,
//! y outward along the level boom, z up, from the boom's base.

use nalgebra::{Matrix3, SMatrix, SVector};
use saltus_robot::Robot;

use super::bodies::{Bodies, Rigid, V3};
use super::floor::Floor;

pub(super) const N: usize = 5;
pub(super) type Coordinates = SVector<f64, N>;
pub(super) type Square = SMatrix<f64, N, N>;

pub(super) const TURN: usize = 0;
pub(super) const PIVOT: usize = 1;
pub(super) const BEND: usize = 2;
pub(super) const LEAN: usize = 3;
pub(super) const LEG: usize = 4;

/// The mechanics of a robot. The force of its leg is given from outside.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    pub(super) boom: Option<f64>,
    /// Stiffness (N m/rad) and damping (N m s/rad) of the bend.
    flex: Option<(f64, f64)>,
    bodies: Bodies,
    pub(super) gravity: f64,
    /// Direction of gravity at the start.
    fall: V3,
    /// Drag (kg/m): −`drag` |v| v at the axle.
    drag: f64,
    /// Dry friction of the axle (N m).
    pub(super) axle_friction: f64,
    pub(super) radius: f64,
    pub(super) foot: f64,
    pub(super) floor: Floor,
    /// Terms that belong to no listed cause.
    extra: super::Extra,
    /// Load (kg) of a cylinder on the bench, without the robot.
    pub(super) load: Option<f64>,
}

/// A part that bodies are fixed to: a half of the boom, or the wheel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Part {
    axes: Matrix3<f64>,
    /// The joint that it turns about (m).
    pub(super) joint: V3,
    /// Acceleration of the joint where all q̈ are 0.
    pub(super) bias: V3,
    /// Angular velocity, and its rate where all q̈ are 0.
    pub(super) spin: V3,
    pub(super) spin_rate: V3,
}

impl Part {
    /// Acceleration, relative to the joint, of the point at `arm` (m) from it, where all q̈ are 0.
    pub(super) fn bias_at(&self, arm: &V3) -> V3 {
        self.spin_rate.cross(arm) + self.spin.cross(&self.spin.cross(arm))
    }
}

/// Geometry and velocities at an instant.
#[derive(Clone, Debug, Default)]
pub(super) struct Frame {
    /// The boom up to its bend, and beyond, which joins the wheel at the axle.
    inner: Part,
    outer: Part,
    pub(super) wheel: Part,
    /// Directions of the axle, and from there to the foot.
    outward: V3,
    pub(super) down: V3,
    /// Velocity of the axle.
    pub(super) axle_rate: V3,
    /// Direction of gravity.
    fall: V3,
}

/// Mass matrix M and forces Q of M q̈ = Q.
pub(super) struct Equations {
    pub(super) mass: Square,
    pub(super) force: Coordinates,
}

impl Machine {
    pub(super) fn new(robot: &Robot) -> Machine {
        Machine {
            boom: robot.boom.map(|b| b.length),
            flex: robot
                .boom
                .and_then(|b| Some((b.flex?, b.flex? * b.flex_time))),
            bodies: Bodies::new(robot),
            gravity: robot.environment.gravity,
            fall: V3::new(-robot.ground.tilt.sin(), 0.0, -robot.ground.tilt.cos()),
            drag: robot.environment.drag * robot.axle_mass(),
            axle_friction: robot.body.axle_friction,
            radius: robot.body.radius,
            foot: robot.foot.radius,
            floor: Floor::new(&robot.ground),
            extra: super::Extra::default(),
            load: None,
        }
    }

    /// One upright cylinder of `robot` on the bench, which moves nothing but a dead load (kg).
    pub(super) fn bench(robot: &Robot, load: f64) -> Machine {
        Machine {
            load: Some(load),
            ..Machine::new(robot)
        }
    }

    /// The same with terms that belong to no listed cause.
    pub(super) fn with(self, extra: super::Extra) -> Machine {
        Machine { extra, ..self }
    }

    /// Longest step (s) for the mass of the leg on the spring and the damper of soft ground.
    pub(super) fn soft_step(&self) -> f64 {
        self.floor.soft.map_or(f64::INFINITY, |(k, c)| {
            let stiff = (k / self.bodies.leg.mass)
                .sqrt()
                .max(c / self.bodies.leg.mass);
            (1.2 / stiff).max(2e-5)
        })
    }

    /// Longest step (s) for the swing of a boom that bends; infinite for others.
    pub(super) fn longest_step(&self) -> f64 {
        let (Some((stiffness, damping)), Some(length)) = (self.flex, self.boom) else {
            return f64::INFINITY;
        };
        // One half of the boom alone, turning about its end against the spring.
        let inertia = self.bodies.inner.mass.max(0.01) * (length / 2.0).powi(2) / 3.0;
        let swing = (4.0 * stiffness / inertia).sqrt();
        (0.25 / swing.max(4.0 * damping / inertia)).max(1e-4)
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
            Some(length) => boom_frame(length, q, v),
            None => self.plane_frame(q, v),
        };
        let along = f.outward;
        f.wheel.spin = f.outer.spin + along * v[LEAN];
        f.wheel.spin_rate = f.outer.spin_rate + f.outer.spin.cross(&along) * v[LEAN];
        // The wheel's axes: x' forward and z' up in its plane, turned by the lean about the boom's
        // direction.
        let up = x.cross(&along);
        let (sin, cos) = q[LEAN].sin_cos();
        let upward = up * cos + x * sin;
        f.wheel.axes = Matrix3::from_columns(&[x * cos - up * sin, along, upward]);
        f.down = -upward;
        f.fall = self.fall;
        if self.boom.is_some() && self.fall.x != 0.0 {
            let (across, ahead) = q[TURN].sin_cos();
            (f.fall.x, f.fall.y) = (self.fall.x * ahead, self.fall.x * across);
        }
        f
    }

    /// The frame of a robot without a boom, without the turn of the wheel.
    fn plane_frame(&self, q: &Coordinates, v: &Coordinates) -> Frame {
        Frame {
            wheel: Part {
                joint: V3::new(q[TURN], 0.0, q[PIVOT] - self.radius),
                ..Part::default()
            },
            outward: V3::y(),
            axle_rate: V3::new(v[TURN], 0.0, v[PIVOT]),
            ..Frame::default()
        }
    }

    /// Column k: velocity of a point `at` of the wheel or the leg (`with_leg`) for a unit velocity
    /// k.
    pub(super) fn columns(&self, f: &Frame, at: &V3, with_leg: bool) -> [V3; N] {
        let from_axle = f.outward.cross(&(at - f.wheel.joint));
        let leg = if with_leg { f.down } else { V3::zeros() };
        if self.boom.is_some() {
            // −z × r and x × r.
            let from_bend = at - f.outer.joint;
            let bend = V3::new(0.0, -from_bend.z, from_bend.y);
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

    /// Component of `x` along the angular velocity for a unit velocity of `joint`.
    fn about(&self, f: &Frame, joint: usize, x: &V3) -> f64 {
        match joint {
            LEAN => f.outward.dot(x),
            TURN if self.boom.is_some() => -x.z,
            PIVOT | BEND if self.boom.is_some() => x.x,
            _ => 0.0,
        }
    }

    /// The equations without the leg's drive, the ground and dry friction of the axle.
    pub(super) fn assemble(&self, f: &Frame, q: &Coordinates, v: &Coordinates) -> Equations {
        let mut equations = Equations {
            mass: Square::zeros(),
            force: Coordinates::zeros(),
        };
        // Those that the foot moves with; the bend only where there is one.
        let joints: &[usize] = if self.bends() {
            &[TURN, PIVOT, BEND, LEAN, LEG]
        } else {
            &[TURN, PIVOT, LEAN, LEG]
        };
        let bodies = &self.bodies;
        if self.boom.is_some() {
            self.add(
                f,
                (&bodies.inner, &f.inner),
                &joints[..2],
                None,
                &mut equations,
            );
            self.add(
                f,
                (&bodies.outer, &f.outer),
                &joints[..3],
                None,
                &mut equations,
            );
        }
        let of_wheel = &joints[..joints.len() - 1];
        self.add(f, (&bodies.wheel, &f.wheel), of_wheel, None, &mut equations);
        if bodies.leg.mass <= bodies.least {
            // What keeps its coordinate in the equations moves nothing else.
            equations.mass[(LEG, LEG)] = bodies.least;
        } else {
            let slide = Some((q[LEG], v[LEG]));
            self.add(f, (&bodies.leg, &f.wheel), joints, slide, &mut equations);
        }
        equations.mass.fill_lower_triangle_with_upper_triangle();
        self.apply(f, q, v, &mut equations.force);
        equations
    }

    /// Adds a body of a part to the equations. It moves with `joints`, and `slide` is its extension
    /// (m) and rate (m/s) along the leg. Only the upper half of the mass matrix is filled.
    fn add(
        &self,
        f: &Frame,
        (body, part): (&Rigid, &Part),
        joints: &[usize],
        slide: Option<(f64, f64)>,
        to: &mut Equations,
    ) {
        if body.mass == 0.0 {
            return;
        }
        let (w, r) = (&part.spin, &part.spin_rate);
        let mut arm = part.axes * body.center;
        let mut acceleration = part.bias;
        if let Some((d, speed)) = slide {
            arm += f.down * d;
            acceleration += 2.0 * w.cross(&f.down) * speed;
        }
        acceleration += part.bias_at(&arm);
        let lin = self.columns(f, &(part.joint + arm), slide.is_some());
        let inertia = body.turned(&part.axes);
        let push = (f.fall * self.gravity - acceleration) * body.mass;
        let torque = -(inertia * r + w.cross(&(inertia * w)));
        for (n, &j) in joints.iter().enumerate() {
            to.force[j] += lin[j].dot(&push) + self.about(f, j, &torque);
            let along = lin[j] * body.mass;
            let turned = match j {
                LEAN => inertia * f.outward,
                TURN => -inertia.column(2),
                PIVOT | BEND => inertia.column(0).into_owned(),
                _ => V3::zeros(),
            };
            for &i in &joints[..=n] {
                to.mass[(i, j)] += lin[i].dot(&along) + self.about(f, i, &turned);
            }
        }
    }

    /// Adds the forces of the bend and the air, and those in the joints.
    fn apply(&self, f: &Frame, q: &Coordinates, v: &Coordinates, force: &mut Coordinates) {
        if let Some((stiffness, damping)) = self.flex {
            force[BEND] -= stiffness * q[BEND] + damping * v[BEND];
        }
        if self.drag > 0.0 {
            let push = f.axle_rate * (-self.drag * f.axle_rate.norm());
            let lin = self.columns(f, &f.wheel.joint, false);
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

/// The frame of a boom of `length` (m), without the turn of the wheel.
fn boom_frame(length: f64, q: &Coordinates, v: &Coordinates) -> Frame {
    let x = V3::x();
    let turn = V3::new(0.0, 0.0, -v[TURN]);
    let across = turn.cross(&x);
    let half = |angle: f64, rate: f64| {
        let (sin, cos) = angle.sin_cos();
        let along = V3::new(0.0, cos, sin);
        let part = Part {
            axes: Matrix3::from_columns(&[x, along, x.cross(&along)]),
            spin: turn + x * rate,
            spin_rate: across * rate,
            ..Part::default()
        };
        (part, along)
    };
    let (inner, first) = half(q[PIVOT], v[PIVOT]);
    let (mut outer, second) = half(q[PIVOT] + q[BEND], v[PIVOT] + v[BEND]);
    let (one, two) = (first * (0.5 * length), second * (0.5 * length));
    (outer.joint, outer.bias) = (one, inner.bias_at(&one));
    Frame {
        inner,
        outer,
        wheel: Part {
            joint: one + two,
            bias: outer.bias + outer.bias_at(&two),
            ..Part::default()
        },
        outward: second,
        axle_rate: inner.spin.cross(&one) + outer.spin.cross(&two),
        ..Frame::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CASES: &[(&str, &[&str])] = &[
        ("rats-planar", &[]),
        ("rats-boom", &[]),
        ("rats-boom", &["boom.bending_stiffness_n_m_per_rad=400"]),
        ("rats-boom", &["ground.tilt_deg=8"]),
        (
            "rats-boom",
            &[
                "leg.mass_kg=0.2",
                "leg.center_m=0.15",
                "body.imbalance_mm=30",
            ],
        ),
        (
            "rats-boom",
            &[
                "boom.counterweight.mass_kg=1",
                "boom.counterweight.distance_m=0.7",
            ],
        ),
    ];

    fn robot(name: &str, terms: &[&str]) -> Robot {
        let overrides: Vec<String> = terms.iter().map(ToString::to_string).collect();
        saltus_robot::resolve(name, &overrides).expect("sound")
    }

    fn equations(machine: &Machine, q: &Coordinates, v: &Coordinates) -> Equations {
        machine.assemble(&machine.frame(q, v), q, v)
    }

    /// In free motion only gravity and the bend do work on the robot. The forces that depend on
    /// velocity do none beyond what the mass matrix needs as it changes.
    #[test]
    fn without_friction_power_is_that_of_forces_at_rest() {
        let q = Coordinates::from([0.4, 0.1, 0.03, -0.5, 0.02]);
        for (name, terms) in CASES {
            let machine = Machine::new(&robot(name, terms));
            let mut v = Coordinates::from([0.8, -0.6, 0.0, 5.0, 1.5]);
            if machine.bends() {
                v[BEND] = 0.7;
            }
            let Equations { mass, force } = equations(&machine, &q, &v);
            let held = Square::from_fn(|i, j| {
                let is_held = i == BEND && j == BEND && !machine.bends();
                f64::from(u8::from(is_held))
            });
            let acceleration = (mass + held).cholesky().expect("masses").solve(&force);
            let energy = |h: f64| {
                let (q, v) = (
                    q + v * h + acceleration * (0.5 * h * h),
                    v + acceleration * h,
                );
                0.5 * v.dot(&(equations(&machine, &q, &v).mass * v))
            };
            let h = 1e-4;
            let power = (energy(h) - energy(-h)) / (2.0 * h);
            let at_rest = equations(&machine, &q, &Coordinates::zeros()).force;
            let expected = v.dot(&at_rest);
            // The quotient is off by a part of h² times squared rates (1/s).
            assert!(
                (power - expected).abs() < 1e-4 * expected.abs().max(1.0),
                "{name} {terms:?}: {power} W, {expected} W"
            );
        }
    }

    #[test]
    fn a_free_wheel_has_the_mass_and_the_inertia_of_its_file() {
        let legs = &[
            "leg.mass_kg=0.05",
            "leg.center_m=0.19",
            "leg.rod_length_m=0.1",
        ];
        let robot = robot("rats-planar", legs);
        let machine = Machine::new(&robot);
        let q = Coordinates::from([0.3, 0.24, 0.0, 0.7, 0.0]);
        let mass = equations(&machine, &q, &Coordinates::zeros()).mass;
        let body = &robot.body;
        for (k, expected) in [(TURN, body.mass), (PIVOT, body.mass), (LEAN, body.inertia)] {
            assert!(
                (mass[(k, k)] - expected).abs() < 1e-12,
                "{k}: {} and {expected}",
                mass[(k, k)]
            );
        }
        // The legs balance each other.
        assert!(mass[(TURN, LEAN)].abs() < 1e-12 && mass[(PIVOT, LEAN)].abs() < 1e-12);
        assert!((mass[(LEG, LEG)] - robot.leg.body.mass).abs() < 1e-12);
    }
}
