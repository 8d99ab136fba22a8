//! Equations of motion of a wheel with legs on a boom, or free in its plane, with the foot of one
//! leg on the ground.
//!
//! Coordinates q: radius angle ψ (rad, forward) and pivot angle θ (rad, up), or travel x and height
//! z (m) without a boom; the bend of the boom (rad); the lean φ of the leg (rad); its extension d
//! (m). What a robot has not is held. All vectors are written in axes that turn with ψ: x forward,
//! y outward along the level boom, z up, from the boom's base.

use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use saltus_robot::Robot;

pub(super) const N: usize = 5;
pub(super) type Coordinates = SVector<f64, N>;
type Square = SMatrix<f64, N, N>;
type V3 = Vector3<f64>;

pub(super) const TURN: usize = 0;
pub(super) const PIVOT: usize = 1;
pub(super) const BEND: usize = 2;
pub(super) const LEAN: usize = 3;
pub(super) const LEG: usize = 4;

/// A rigid body: mass (kg), centre of mass (m) and inertia about it (kg m²) in its own axes.
#[derive(Clone, Copy, Debug)]
struct Rigid {
    mass: f64,
    center: V3,
    inertia: Matrix3<f64>,
}

impl Rigid {
    /// Inertia in axes that its own are `axes` in.
    fn turned(&self, axes: &Matrix3<f64>) -> Matrix3<f64> {
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

/// The ground under the foot.
#[derive(Clone, Copy, Debug)]
pub(super) struct Floor {
    pub(super) slope: f64,
    /// Stiffness (N/m) and damping (N s/m) where it is soft.
    pub(super) soft: Option<(f64, f64)>,
    /// Coefficients of friction along the travel, standing and slipping.
    pub(super) friction: (f64, f64),
    /// Coefficient of friction across the travel.
    across: f64,
}

impl Floor {
    /// Whether the foot of a leg that is stopped in its stroke stays on the ground: soft ground goes
    /// on pushing until its spring is slack. Friction without a limit would meanwhile hold the foot
    /// and turn the robot about it, so that the foot then leaves at once.
    pub(super) fn pushes_on(&self) -> bool {
        self.soft.is_some() && self.friction.0.is_finite()
    }
}

/// A robot, as far as its motion goes; the force of its leg is given.
#[derive(Clone, Debug)]
pub(super) struct Machine {
    boom: Option<f64>,
    /// Stiffness of the bend (N m/rad).
    flex: Option<f64>,
    inner: Rigid,
    outer: Rigid,
    wheel: Rigid,
    leg: Rigid,
    /// Mass (kg) that a leg has in its own equation at least.
    least: f64,
    gravity: f64,
    /// Drag (kg/m): −`drag` |v| v at the axle.
    drag: f64,
    axle_friction: f64,
    pub(super) radius: f64,
    foot: f64,
    pub(super) floor: Floor,
    /// Terms that no listed cause has.
    extra: super::Extra,
    /// Mass (kg) that the leg of a cylinder on the bench lifts; the robot is then not there.
    load: Option<f64>,
}

/// What the foot does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Foot {
    /// It stands still along the travel.
    Stands,
    /// It slips along the travel, this way.
    Slips(f64),
    /// It is in the air.
    Flies,
}

/// Accelerations and what causes them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Answer {
    pub(super) acceleration: Coordinates,
    /// Force (N) of the ground, normal and along the travel.
    pub(super) ground: [f64; 2],
    /// Force (N) that holds the leg at its extension, if it is held: positive keeps it from
    /// extending.
    pub(super) hold: f64,
    /// Force (N) of the leg on the wheel, outwards, less what holds it.
    pub(super) push: f64,
}

/// Geometry and velocities at an instant.
struct Frame {
    /// Directions of the boom's halves, and from the axle to the foot.
    outward: [V3; 2],
    down: V3,
    hinge: V3,
    axle: V3,
    /// Rotation of the wheel.
    wheel: Matrix3<f64>,
    /// Angular velocity and its rate where all accelerations are 0: of the boom's halves and of the
    /// wheel.
    spin: [V3; 3],
    spin_rate: [V3; 3],
    /// Velocity of the axle; acceleration of hinge and axle where all accelerations are 0.
    axle_rate: V3,
    bias: [V3; 2],
}

const MASSLESS: f64 = 1e-6;
/// Least mass (kg) of a leg on soft ground, where its spring would else be too fast for any step.
const SOFT_LEAST: f64 = 0.02;
/// Rate (rad/s) over which dry friction of the axle turns over.
const DRY_RATE: f64 = 5e-3;
/// Speed (m/s) over which friction across the travel turns over.
const ACROSS_SPEED: f64 = 1e-4;

impl Machine {
    pub(super) fn new(robot: &Robot) -> Machine {
        let (body, part) = (&robot.body, &robot.leg.body);
        let floor = Floor {
            slope: robot.ground.slope,
            soft: robot.ground.stiffness.map(|k| (k, robot.ground.damping)),
            friction: (robot.ground.static_friction, robot.ground.kinetic_friction),
            across: robot.ground.across_friction,
        };
        let n = body.legs;
        let way = |k: u32| {
            let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n);
            V3::new(angle.sin(), 0.0, -angle.cos())
        };
        let rod = |k: u32| {
            let u = way(k);
            let along = 0.5 * part.mass * part.radius * part.radius;
            let inertia =
                Matrix3::identity() * part.inertia() + u * u.transpose() * (along - part.inertia());
            Rigid {
                mass: part.mass,
                center: u * part.center,
                inertia,
            }
        };
        let mut leg = rod(0);
        let least = MASSLESS * body.mass;
        let lent = if floor.soft.is_some() {
            (SOFT_LEAST - leg.mass).max(0.0)
        } else {
            0.0
        };
        leg.mass += lent;
        let (offset, angle) = (body.imbalance, body.imbalance_angle);
        let center = V3::new(angle.sin(), 0.0, -angle.cos()) * offset;
        let mass = robot.wheel_mass() - lent;
        let axle = (robot.wheel_inertia() - mass * offset * offset).max(0.0);
        let inertia = Matrix3::from_diagonal(&V3::new(axle / 2.0, axle, axle / 2.0));
        let mut wheel = Rigid {
            mass,
            center,
            inertia,
        };
        for k in 1..n {
            wheel.add(&rod(k));
        }
        let nothing = Rigid {
            mass: 0.0,
            center: V3::zeros(),
            inertia: Matrix3::zeros(),
        };
        let (mut inner, mut outer) = (nothing, nothing);
        let flex = robot.boom.and_then(|b| b.flex);
        if let Some(boom) = &robot.boom {
            let half = |length: f64| {
                let mass = boom.mass * length / boom.length;
                let across = mass * (3.0 * boom.radius * boom.radius + length * length) / 12.0;
                let along = 0.5 * mass * boom.radius * boom.radius;
                let inertia = Matrix3::from_diagonal(&V3::new(across, along, across));
                Rigid {
                    mass,
                    center: V3::y() * (length / 2.0),
                    inertia,
                }
            };
            inner = half(if flex.is_some() {
                boom.length / 2.0
            } else {
                boom.length
            });
            if flex.is_some() {
                outer = half(boom.length / 2.0);
            }
            if let Some(weight) = boom.counterweight {
                inner.add(&Rigid {
                    mass: weight.mass,
                    center: -V3::y() * weight.distance,
                    inertia: Matrix3::zeros(),
                });
            }
        }
        Machine {
            boom: robot.boom.map(|b| b.length),
            flex,
            inner,
            outer,
            wheel,
            leg,
            least,
            gravity: robot.environment.gravity,
            drag: robot.environment.drag * robot.axle_mass(),
            axle_friction: body.axle_friction,
            radius: body.radius,
            foot: robot.foot.radius,
            floor,
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
            let stiff = (k / self.leg.mass).sqrt().max(c / self.leg.mass);
            (1.2 / stiff).max(2e-5)
        })
    }

    /// Longest step (s) that follows what bends; none where nothing does.
    pub(super) fn longest_step(&self) -> f64 {
        let (Some(stiffness), Some(length)) = (self.flex, self.boom) else {
            return f64::INFINITY;
        };
        // One half of the boom alone, turning about its end against the spring.
        let inertia = self.inner.mass.max(0.01) * (length / 2.0).powi(2) / 3.0;
        (0.25 / (4.0 * stiffness / inertia).sqrt()).max(1e-4)
    }

    /// Whether it is a cylinder on the bench.
    pub(super) fn is_bench(&self) -> bool {
        self.load.is_some()
    }

    /// Length of the boom (m).
    pub(super) fn boom(&self) -> Option<f64> {
        self.boom
    }

    /// The same robot on ground that does not give.
    pub(super) fn on_rigid_ground(&self) -> Machine {
        Machine {
            floor: Floor {
                soft: None,
                ..self.floor
            },
            ..self.clone()
        }
    }

    fn frame(&self, q: &Coordinates, v: &Coordinates) -> Frame {
        let x = V3::x();
        let (spin, spin_rate, outward, hinge, axle, bias, axle_rate);
        if let Some(length) = self.boom {
            let (sin, cos) = q[PIVOT].sin_cos();
            let first = V3::new(0.0, cos, sin);
            let second = match self.flex {
                Some(_) => {
                    let (sin, cos) = (q[PIVOT] + q[BEND]).sin_cos();
                    V3::new(0.0, cos, sin)
                }
                None => first,
            };
            let turn = V3::new(0.0, 0.0, -v[TURN]);
            let (a, b) = (turn + x * v[PIVOT], turn + x * (v[PIVOT] + v[BEND]));
            let across = turn.cross(&x);
            let (ra, rb) = (across * v[PIVOT], across * (v[PIVOT] + v[BEND]));
            spin = [a, b, b + second * v[LEAN]];
            spin_rate = [ra, rb, rb + b.cross(&second) * v[LEAN]];
            outward = [first, second];
            let (one, two) = (first * (0.5 * length), second * (0.5 * length));
            (hinge, axle) = (one, one + two);
            let of = |w: &V3, r: &V3, arm: &V3| r.cross(arm) + w.cross(&w.cross(arm));
            let at_hinge = of(&a, &ra, &one);
            bias = [at_hinge, at_hinge + of(&b, &rb, &two)];
            axle_rate = a.cross(&one) + b.cross(&two);
        } else {
            outward = [V3::y(); 2];
            spin = [V3::zeros(), V3::zeros(), V3::y() * v[LEAN]];
            spin_rate = [V3::zeros(); 3];
            hinge = V3::zeros();
            axle = V3::new(q[TURN], 0.0, q[PIVOT] - self.radius);
            bias = [V3::zeros(); 2];
            axle_rate = V3::new(v[TURN], 0.0, v[PIVOT]);
        }
        // The wheel's axes: x' forward and z' up in its plane, turned by the lean about the boom's
        // direction.
        let up = x.cross(&outward[1]);
        let (sin, cos) = q[LEAN].sin_cos();
        let forward = x * cos - up * sin;
        let upward = up * cos + x * sin;
        let wheel = Matrix3::from_columns(&[forward, outward[1], upward]);
        Frame {
            outward,
            down: -upward,
            hinge,
            axle,
            wheel,
            spin,
            spin_rate,
            axle_rate,
            bias,
        }
    }

    /// Column k: velocity of a point `at` of the wheel or the leg (`with_leg`) for a unit velocity
    /// k.
    fn columns(&self, f: &Frame, at: &V3, with_leg: bool) -> [V3; N] {
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

    /// Mass matrix, and the forces on the coordinates without the leg's drive and the ground.
    fn assemble(&self, f: &Frame, q: &Coordinates, v: &Coordinates) -> (Square, Coordinates) {
        let (mut mass, mut force) = (Square::zeros(), Coordinates::zeros());
        let weight = V3::new(0.0, 0.0, -self.gravity);
        let mut add = |body: &Rigid,
                       axes: &Matrix3<f64>,
                       k: usize,
                       joints: &[usize],
                       from: &V3,
                       bias: &V3,
                       slide: Option<(f64, f64)>| {
            if body.mass == 0.0 {
                return;
            }
            let mut arm = axes * body.center;
            let mut acceleration = *bias;
            if let Some((d, speed)) = slide {
                arm += f.down * d;
                acceleration += 2.0 * f.spin[k].cross(&f.down) * speed;
            }
            let (w, r) = (&f.spin[k], &f.spin_rate[k]);
            acceleration += r.cross(&arm) + w.cross(&w.cross(&arm));
            let lin = self.columns(f, &(from + arm), slide.is_some());
            let inertia = body.turned(axes);
            let push = (weight - acceleration) * body.mass;
            let torque = -(inertia * r + w.cross(&(inertia * w)));
            for (n, &j) in joints.iter().enumerate() {
                force[j] += lin[j].dot(&push) + self.about(f, j, &torque);
                let along = lin[j] * body.mass;
                let turned = match j {
                    LEAN => inertia * f.outward[1],
                    TURN => -inertia.column(2),
                    PIVOT | BEND => inertia.column(0).into_owned(),
                    _ => V3::zeros(),
                };
                for &i in &joints[..=n] {
                    mass[(i, j)] += lin[i].dot(&along) + self.about(f, i, &turned);
                }
            }
        };
        let zero = V3::zeros();
        if self.boom.is_some() {
            let axes = |y: &V3| Matrix3::from_columns(&[V3::x(), *y, V3::x().cross(y)]);
            add(
                &self.inner,
                &axes(&f.outward[0]),
                0,
                &[TURN, PIVOT],
                &zero,
                &zero,
                None,
            );
            add(
                &self.outer,
                &axes(&f.outward[1]),
                1,
                &[TURN, PIVOT, BEND],
                &f.hinge,
                &f.bias[0],
                None,
            );
        }
        // Joints that a body moves with; the bend only where there is one.
        let (wheel, leg): (&[usize], &[usize]) = if self.flex.is_some() {
            (&[TURN, PIVOT, BEND, LEAN], &[TURN, PIVOT, BEND, LEAN, LEG])
        } else {
            (&[TURN, PIVOT, LEAN], &[TURN, PIVOT, LEAN, LEG])
        };
        add(&self.wheel, &f.wheel, 2, wheel, &f.axle, &f.bias[1], None);
        if self.leg.mass <= self.least {
            // What keeps its coordinate in the equations moves nothing else.
            mass[(LEG, LEG)] = self.least;
        } else {
            add(
                &self.leg,
                &f.wheel,
                2,
                leg,
                &f.axle,
                &f.bias[1],
                Some((q[LEG], v[LEG])),
            );
        }
        for j in 0..N {
            for i in 0..j {
                mass[(j, i)] = mass[(i, j)];
            }
        }
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
        if self.axle_friction > 0.0 {
            force[LEAN] -= self.axle_friction * (v[LEAN] / DRY_RATE).clamp(-1.0, 1.0);
        }
        (mass, force)
    }

    /// Gap (m) between foot and ground, and the foot's directions: normal and along the travel,
    /// with the place of contact and the centre.
    fn foot(&self, f: &Frame, q: &Coordinates) -> (f64, V3, V3, V3, V3) {
        let center = f.axle + f.down * (self.radius - self.foot + q[LEG]);
        // The ground's normal in axes that turn with ψ; its point below the start.
        let below = V3::new(0.0, 0.0, -self.radius);
        let (normal, start) = if self.floor.slope == 0.0 {
            (V3::z(), below)
        } else {
            let (sin, cos) = self.floor.slope.sin_cos();
            let (turn, length) = self.boom.map_or((0.0, 0.0), |length| (q[TURN], length));
            let (across, ahead) = turn.sin_cos();
            let start = below + V3::new(-across, ahead, 0.0) * length;
            (V3::new(-sin * ahead, -sin * across, cos), start)
        };
        let gap = normal.dot(&(center - start)) - self.foot;
        let place = center - normal * self.foot;
        let ahead = match self.boom {
            Some(_) => V3::new(place.y, -place.x, 0.0),
            None => V3::x(),
        };
        let along = (ahead - normal * normal.dot(&ahead)).normalize();
        (gap, normal, along, place, center)
    }

    /// Gap (m) of the foot, its speed along normal and travel (m/s), and its travel angle (rad) or
    /// travel (m).
    pub(super) fn contact(&self, q: &Coordinates, v: &Coordinates) -> (f64, [f64; 2], f64) {
        let f = self.frame(q, v);
        let (gap, normal, along, place, _) = self.foot(&f, q);
        let columns = self.columns(&f, &place, true);
        let speed = (0..N).fold(V3::zeros(), |sum, k| sum + columns[k] * v[k]);
        let travel = match self.boom {
            Some(_) => q[TURN] + place.x.atan2(place.y),
            None => place.x,
        };
        (gap, [speed.dot(&normal), speed.dot(&along)], travel)
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

    /// The robot on its retracted foot at travel 0, at lean `lean` (rad) and turning at `rate`
    /// (rad/s); soft ground gives as much as `sag` (m).
    pub(super) fn stand(
        &self,
        lean: f64,
        rate: f64,
        sag: f64,
    ) -> Option<(Coordinates, Coordinates)> {
        let (mut q, mut v) = (Coordinates::zeros(), Coordinates::zeros());
        q[LEAN] = lean;
        if self.boom.is_none() {
            q[PIVOT] = self.radius;
        }
        let arm = self.boom.unwrap_or(1.0);
        for _ in 0..30 {
            let (gap, _, travel) = self.contact(&q, &v);
            q[PIVOT] -= (gap + sag) / arm;
            q[TURN] -= travel;
            if (gap + sag).abs() < 1e-14 && travel.abs() < 1e-14 {
                break;
            }
        }
        let speeds = |k: usize, size: f64| {
            let mut v = Coordinates::zeros();
            v[k] = size;
            self.contact(&q, &v).1
        };
        let (spin, a, b) = (speeds(LEAN, rate), speeds(TURN, 1.0), speeds(PIVOT, 1.0));
        let determinant = a[0] * b[1] - a[1] * b[0];
        v[LEAN] = rate;
        v[TURN] = -(spin[0] * b[1] - spin[1] * b[0]) / determinant;
        v[PIVOT] = -(a[0] * spin[1] - a[1] * spin[0]) / determinant;
        (q.iter().chain(v.iter()).all(|x| x.is_finite())).then_some((q, v))
    }

    /// Accelerations under the leg's force `push` (N, positive extends), with the foot as it is and
    /// the leg held or not.
    pub(super) fn solve(
        &self,
        q: &Coordinates,
        v: &Coordinates,
        push: f64,
        held: bool,
        foot: Foot,
    ) -> Option<Answer> {
        if let Some(load) = self.load {
            let hold = push - load * self.gravity;
            let mut acceleration = Coordinates::zeros();
            acceleration[LEG] = if held { 0.0 } else { hold / load };
            return Some(Answer {
                acceleration,
                ground: [0.0; 2],
                hold,
                push,
            });
        }
        let f = self.frame(q, v);
        let (mut mass, mut force) = self.assemble(&f, q, v);
        force[LEG] += push;
        // A held coordinate is taken out: its own row is kept to tell what holds it.
        let (leg_row, leg_force) = (mass.row(LEG).into_owned(), force[LEG]);
        let mut hold_coordinate = |k: usize| {
            mass.row_mut(k).fill(0.0);
            mass.column_mut(k).fill(0.0);
            mass[(k, k)] = 1.0;
            force[k] = 0.0;
        };
        if self.flex.is_none() {
            hold_coordinate(BEND);
        }
        if held {
            hold_coordinate(LEG);
        }
        let factor = mass.cholesky()?;
        let free = factor.solve(&force);
        if foot == Foot::Flies {
            let hold = leg_force - (leg_row * free)[0];
            return Some(Answer {
                acceleration: free,
                ground: [0.0; 2],
                hold,
                push,
            });
        }
        let (gap, normal, along, place, center) = self.foot(&f, q);
        let columns = self.columns(&f, &place, true);
        let row = |way: &V3| {
            let mut row = Coordinates::from_fn(|k, _| columns[k].dot(way));
            let whole = row[LEG];
            if self.flex.is_none() {
                row[BEND] = 0.0;
            }
            if held {
                row[LEG] = 0.0;
            }
            (row, whole)
        };
        let ((jn, wn), (jt, wt)) = (row(&normal), row(&along));
        // The normal force brings the friction across the travel with it.
        let (mut pn, mut hn) = (jn, wn);
        if self.floor.across > 0.0 && self.boom.is_some() {
            let across = normal.cross(&along);
            let speed = (0..N).map(|k| columns[k].dot(&across) * v[k]).sum::<f64>();
            let share = -self.floor.across * (speed / ACROSS_SPEED).clamp(-1.0, 1.0);
            let (ja, wa) = row(&across);
            (pn, hn) = (jn + ja * share, wn + wa * share);
        }
        let (w, r) = (&f.spin[2], &f.spin_rate[2]);
        let arm = center - f.axle;
        let at_center =
            f.bias[1] + r.cross(&arm) + w.cross(&w.cross(&arm)) + 2.0 * w.cross(&f.down) * v[LEG];
        let on_sphere = r.cross(&(place - center));
        let (bn, mut bt) = (normal.dot(&at_center), along.dot(&(at_center + on_sphere)));
        if self.boom.is_some() {
            // The travel's direction turns as a rolling foot goes along it, while the boom drags it
            // across.
            let moving = f.axle_rate + w.cross(&arm) + f.down * v[LEG];
            let level = V3::new(place.x, place.y, 0.0);
            let rate = moving.dot(&along) / level.norm();
            let at_place = (0..N).fold(V3::zeros(), |sum, k| sum + columns[k] * v[k]);
            bt -= rate * at_place.dot(&level.normalize());
        }
        let (mn, mt) = (factor.solve(&pn), factor.solve(&jt));
        let (an, at) = (jn.dot(&free) + bn, jt.dot(&free) + bt);
        let ground = match (self.floor.soft, foot) {
            (Some((k, c)), _) => {
                let speed = (0..N).map(|j| columns[j].dot(&normal) * v[j]).sum::<f64>();
                let n = -k * gap - c * speed;
                match foot {
                    Foot::Slips(way) => [n, -way * self.floor.friction.1 * n],
                    _ => [n, -(at + jt.dot(&mn) * n) / jt.dot(&mt)],
                }
            }
            (None, Foot::Slips(way)) => {
                let t = -way * self.floor.friction.1;
                let n = -an / (jn.dot(&mn) + t * jn.dot(&mt));
                [n, t * n]
            }
            (None, _) => {
                let (nn, nt, tn, tt) = (jn.dot(&mn), jn.dot(&mt), jt.dot(&mn), jt.dot(&mt));
                let determinant = nn * tt - nt * tn;
                [
                    (-an * tt + at * nt) / determinant,
                    (-at * nn + an * tn) / determinant,
                ]
            }
        };
        let acceleration = free + mn * ground[0] + mt * ground[1];
        let hold = leg_force + hn * ground[0] + wt * ground[1] - (leg_row * acceleration)[0];
        Some(Answer {
            acceleration,
            ground,
            hold,
            push,
        })
    }

    /// Velocities after the leg has been stopped in its stroke, the foot free to leave: it is
    /// picked up.
    pub(super) fn stop_leg(&self, q: &Coordinates, v: &Coordinates) -> Option<Coordinates> {
        if self.is_bench() {
            return Some(Coordinates::zeros());
        }
        let f = self.frame(q, v);
        let (mut mass, _) = self.assemble(&f, q, v);
        if self.flex.is_none() {
            mass.row_mut(BEND).fill(0.0);
            mass.column_mut(BEND).fill(0.0);
            mass[(BEND, BEND)] = 1.0;
        }
        let factor = mass.cholesky()?;
        let mut unit = Coordinates::zeros();
        unit[LEG] = 1.0;
        let answer = factor.solve(&unit);
        Some(v - answer * (v[LEG] / answer[LEG]))
    }
}
