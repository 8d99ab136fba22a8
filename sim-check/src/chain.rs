//! A mechanism that moves in the plane of travel and height, for models that are run very often: the
//! same bodies and joints as a [`Tree`], in two dimensions and without contacts.
//!
//! Source: as in `tree`; in a plane the products of rates are centripetal and Coriolis terms alone.

use crate::SimError;
use crate::error::require;
use crate::tree::{Joint, Tree};

/// Most bodies of a chain.
pub const MOST: usize = 12;

/// Bodies of a chain, one coordinate each.
#[derive(Clone, Debug)]
pub struct Chain {
    bodies: Vec<Flat>,
    /// Masses (kg) that are weighed and have no inertia: each with its body, and where it is there (m).
    weights: Vec<(usize, [f64; 2], f64)>,
    /// Acceleration of gravity (m/s²) along and up.
    gravity: [f64; 2],
}

/// How a body moves on its parent.
#[derive(Clone, Copy, Debug)]
enum Way {
    /// Turns, forward (1) or back (−1) as its coordinate grows.
    Turns(f64),
    /// Slides along a unit vector in the joint's frame.
    Slides([f64; 2]),
}

#[derive(Clone, Copy, Debug)]
struct Flat {
    parent: Option<usize>,
    way: Way,
    /// The joint in the parent's frame (m), and its angle there (rad).
    at: [f64; 2],
    angle: f64,
    mass: f64,
    center: [f64; 2],
    inertia: f64,
}

/// Where a chain is, with its equations of motion M q̈ = f.
#[derive(Clone, Debug)]
pub struct Moving {
    /// Angle (rad) of each body, and the joint's origin (m).
    angles: [f64; MOST],
    origins: [[f64; 2]; MOST],
    /// The sine and cosine of each angle.
    turns: [[f64; 2]; MOST],
    rates: [f64; MOST],
    /// Unit vector of each joint that slides.
    slides: [[f64; 2]; MOST],
    /// Velocity (m/s) of each joint's origin.
    speeds: [[f64; 2]; MOST],
    /// Its acceleration (m/s²) without those of the coordinates.
    bias: [[f64; 2]; MOST],
    /// M, of which the lower half counts, and its Cholesky factor.
    mass: [[f64; MOST]; MOST],
    /// f.
    force: [f64; MOST],
}

impl Default for Moving {
    fn default() -> Moving {
        Moving {
            angles: [0.0; MOST],
            origins: [[0.0; 2]; MOST],
            turns: [[0.0, 1.0]; MOST],
            rates: [0.0; MOST],
            slides: [[0.0; 2]; MOST],
            speeds: [[0.0; 2]; MOST],
            bias: [[0.0; 2]; MOST],
            mass: [[0.0; MOST]; MOST],
            force: [0.0; MOST],
        }
    }
}

/// A vector of a frame whose angle has this sine and cosine; angles count from up to forward.
fn turned([sin, cos]: [f64; 2], [x, z]: [f64; 2]) -> [f64; 2] {
    [cos * x + sin * z, cos * z - sin * x]
}

/// Velocity of the end of `arm` for each radian per second forward.
fn across([x, z]: [f64; 2]) -> [f64; 2] {
    [z, -x]
}

fn sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}

fn difference(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn times(s: f64, a: [f64; 2]) -> [f64; 2] {
    [s * a[0], s * a[1]]
}

fn product(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

impl Chain {
    /// The chain of `tree`, whose joints turn about the lateral axis or slide in its plane.
    ///
    /// # Errors
    /// [`SimError::Input`] for other joints, or more than [`MOST`] bodies.
    pub fn new(tree: &Tree, gravity: [f64; 2]) -> Result<Chain, SimError> {
        let count = tree.bodies().len();
        require(
            count <= MOST,
            "bodies of a chain",
            count as f64,
            "12 at most",
        )?;
        let mut bodies = Vec::new();
        for body in tree.bodies() {
            let rotation = &body.placement.rotation;
            let off = rotation[(1, 1)] - 1.0;
            let refused = |value: f64, allowed: &'static str| SimError::Input {
                name: format!("joint of body '{}', out of the plane by", body.name),
                value,
                allowed,
            };
            if off.abs() > 1e-9 {
                return Err(refused(off, "0"));
            }
            let way = match body.joint {
                Joint::Revolute(axis) if axis.y.abs() > 1.0 - 1e-12 => Way::Turns(axis.y.signum()),
                Joint::Prismatic(axis) if axis.y.abs() < 1e-12 => Way::Slides([axis.x, axis.z]),
                Joint::Revolute(axis) | Joint::Prismatic(axis) => {
                    return Err(refused(axis.y, "an axis across the plane, or along it"));
                }
                Joint::Free => return Err(refused(1.0, "a joint that turns or slides")),
            };
            bodies.push(Flat {
                parent: body.parent,
                way,
                at: [body.placement.position.x, body.placement.position.z],
                angle: rotation[(0, 2)].atan2(rotation[(0, 0)]),
                mass: body.mass,
                center: [body.center.x, body.center.z],
                inertia: body.inertia[(1, 1)],
            });
        }
        Ok(Chain {
            bodies,
            weights: Vec::new(),
            gravity,
        })
    }

    /// Adds `mass` (kg) at a place of a body (m, its frame) to what is weighed, and not to what is
    /// accelerated; below 0 it lifts, as a counterweight does.
    pub fn weigh(&mut self, body: usize, inner: [f64; 2], mass: f64) {
        self.weights.push((body, inner, mass));
    }

    /// Number of bodies, and of coordinates.
    pub fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Whether it has no bodies.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Puts it at the coordinates `q` with the rates `v`, and sets up M and f by weight and inertia.
    pub fn put(&self, q: &[f64], v: &[f64], moving: &mut Moving) {
        for (i, body) in self.bodies.iter().enumerate() {
            let (angle, turn, rate, origin, speed, bias) = match body.parent {
                Some(p) => (
                    moving.angles[p],
                    moving.turns[p],
                    moving.rates[p],
                    moving.origins[p],
                    moving.speeds[p],
                    moving.bias[p],
                ),
                None => (0.0, [0.0, 1.0], 0.0, [0.0; 2], [0.0; 2], [0.0; 2]),
            };
            let arm = turned(turn, body.at);
            let (mut angle, mut own_rate) = (angle + body.angle, rate);
            let mut arm_and_slide = arm;
            let (mut own, mut coriolis) = ([0.0; 2], [0.0; 2]);
            match body.way {
                Way::Turns(sign) => {
                    angle += sign * q[i];
                    own_rate += sign * v[i];
                }
                Way::Slides(axis) => {
                    let (sin, cos) = angle.sin_cos();
                    let slide = turned([sin, cos], axis);
                    moving.slides[i] = slide;
                    arm_and_slide = sum(arm, times(q[i], slide));
                    own = times(v[i], slide);
                    coriolis = times(2.0 * rate * v[i], across(slide));
                }
            }
            let (sin, cos) = angle.sin_cos();
            moving.angles[i] = angle;
            moving.turns[i] = [sin, cos];
            moving.rates[i] = own_rate;
            moving.origins[i] = sum(origin, arm_and_slide);
            moving.speeds[i] = sum(speed, sum(times(rate, across(arm_and_slide)), own));
            moving.bias[i] = sum(bias, sum(times(-rate * rate, arm_and_slide), coriolis));
        }
        self.assemble(moving);
    }

    fn assemble(&self, moving: &mut Moving) {
        let n = self.bodies.len();
        for row in &mut moving.mass[..n] {
            row[..n].fill(0.0);
        }
        moving.force[..n].fill(0.0);
        for (i, body) in self.bodies.iter().enumerate() {
            if body.mass == 0.0 && body.inertia == 0.0 {
                continue;
            }
            let arm = turned(moving.turns[i], body.center);
            let center = sum(moving.origins[i], arm);
            let centripetal = times(-moving.rates[i] * moving.rates[i], arm);
            let pull = difference(self.gravity, sum(moving.bias[i], centripetal));
            let mut k = Some(i);
            while let Some(row) = k {
                let (by, turn) = self.column(moving, row, center);
                moving.force[row] += body.mass * product(by, pull);
                let mut l = Some(row);
                while let Some(column) = l {
                    let (other, other_turn) = self.column(moving, column, center);
                    moving.mass[row][column] +=
                        body.mass * product(by, other) + body.inertia * turn * other_turn;
                    l = self.bodies[column].parent;
                }
                k = self.bodies[row].parent;
            }
        }
        for &(body, inner, mass) in &self.weights {
            let place = sum(moving.origins[body], turned(moving.turns[body], inner));
            self.push(moving, body, place, times(mass, self.gravity));
        }
    }

    /// How a place (m) moves with coordinate `k` of a body on its way to the world, and how far the
    /// body there turns.
    fn column(&self, moving: &Moving, k: usize, place: [f64; 2]) -> ([f64; 2], f64) {
        match self.bodies[k].way {
            Way::Turns(sign) => (
                times(sign, across(difference(place, moving.origins[k]))),
                sign,
            ),
            Way::Slides(_) => (moving.slides[k], 0.0),
        }
    }

    /// A place (m) of a body, given in its frame, and its velocity (m/s).
    pub fn place(&self, moving: &Moving, body: usize, inner: [f64; 2]) -> [[f64; 2]; 2] {
        let arm = turned(moving.turns[body], inner);
        [
            sum(moving.origins[body], arm),
            sum(moving.speeds[body], times(moving.rates[body], across(arm))),
        ]
    }

    /// Adds a force (N) at a place (m) of a body.
    pub fn push(&self, moving: &mut Moving, body: usize, place: [f64; 2], force: [f64; 2]) {
        let mut k = Some(body);
        while let Some(row) = k {
            moving.force[row] += product(self.column(moving, row, place).0, force);
            k = self.bodies[row].parent;
        }
    }

    /// Adds a force or torque (N or N m) to a coordinate.
    pub fn drive(&self, moving: &mut Moving, coordinate: usize, force: f64) {
        moving.force[coordinate] += force;
    }

    /// Forces (N or N m) on the coordinates so far.
    pub fn forces(&self, moving: &Moving) -> [f64; MOST] {
        moving.force
    }

    /// Adds to the inertia of a coordinate, as damping that is taken at the end of a step does.
    pub fn burden(&self, moving: &mut Moving, coordinate: usize, inertia: f64) {
        moving.mass[coordinate][coordinate] += inertia;
    }

    /// Takes a force along `direction` at a place (m) of a body implicitly: it falls by `weight`
    /// (N s²/m) times as much as the place's acceleration grows beyond that of the coordinates'
    /// accelerations `a`.
    pub fn brace(
        &self,
        moving: &mut Moving,
        (body, place): (usize, [f64; 2]),
        direction: [f64; 2],
        weight: f64,
        a: &[f64],
    ) {
        let (mut rows, mut along, mut count) = ([(0, 0.0); MOST], 0.0, 0);
        let mut k = Some(body);
        while let Some(row) = k {
            let by = product(self.column(moving, row, place).0, direction);
            rows[count] = (row, by);
            count += 1;
            along += by * a[row];
            k = self.bodies[row].parent;
        }
        for (i, (row, by)) in rows[..count].iter().enumerate() {
            moving.force[*row] += weight * along * by;
            // Parents come before what hangs on them.
            for (column, other) in &rows[i..count] {
                moving.mass[*row][*column] += weight * by * other;
            }
        }
    }

    /// The centre of mass (m) of all bodies.
    pub fn center(&self, moving: &Moving) -> [f64; 2] {
        let (mut whole, mut moment) = (0.0, [0.0; 2]);
        for (i, body) in self.bodies.iter().enumerate() {
            let place = self.place(moving, i, body.center)[0];
            whole += body.mass;
            moment = sum(moment, times(body.mass, place));
        }
        times(1.0 / whole, moment)
    }

    /// Factors M, in place; false where it is not positive.
    pub fn factor(&self, moving: &mut Moving) -> bool {
        let n = self.bodies.len();
        let mass = &mut moving.mass;
        for i in 0..n {
            for j in 0..=i {
                let mut left = mass[i][j];
                for k in 0..j {
                    left -= mass[i][k] * mass[j][k];
                }
                if i == j {
                    if left.is_nan() || left <= 0.0 {
                        return false;
                    }
                    mass[i][i] = left.sqrt();
                } else {
                    mass[i][j] = left / mass[j][j];
                }
            }
        }
        true
    }

    /// M⁻¹ x in place of x, once M is factored.
    pub fn solve(&self, moving: &Moving, x: &mut [f64]) {
        let (n, mass) = (self.bodies.len(), &moving.mass);
        for i in 0..n {
            let done: f64 = (0..i).map(|k| mass[i][k] * x[k]).sum();
            x[i] = (x[i] - done) / mass[i][i];
        }
        for i in (0..n).rev() {
            let done: f64 = (i + 1..n).map(|k| mass[k][i] * x[k]).sum();
            x[i] = (x[i] - done) / mass[i][i];
        }
    }

    /// Accelerations of the coordinates, once M is factored.
    pub fn accelerations(&self, moving: &Moving) -> [f64; MOST] {
        let mut x = moving.force;
        self.solve(moving, &mut x[..self.bodies.len()]);
        x
    }

    /// Kinetic and potential energy (J).
    pub fn energy(&self, moving: &Moving) -> [f64; 2] {
        let (mut kinetic, mut potential) = (0.0, 0.0);
        for (i, body) in self.bodies.iter().enumerate() {
            let [place, speed] = self.place(moving, i, body.center);
            kinetic += 0.5 * body.mass * product(speed, speed)
                + 0.5 * body.inertia * moving.rates[i] * moving.rates[i];
            potential -= body.mass * product(self.gravity, place);
        }
        for &(body, inner, mass) in &self.weights {
            potential -= mass * product(self.gravity, self.place(moving, body, inner)[0]);
        }
        [kinetic, potential]
    }
}
