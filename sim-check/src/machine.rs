//! The equations of motion of a mechanism in a given mode: accelerations, contact forces, and what guards need to know.

use saltus_pneumatics::Switches;

use crate::complementarity::{Bounds, Element, Grip, Problem};
use crate::contact::Friction;
use crate::linear::{backward, cholesky, forward};
use crate::mechanism::Mechanism;
use crate::mode::{JointMode, Mode, Stop};
use crate::spatial::{Motion, Vec3};
use crate::tree::{Pose, Welded};

/// Where things are in the continuous state: q | v | a chamber variable for each leg | works.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Layout {
    pub coordinates: usize,
    pub velocities: usize,
    pub legs: usize,
}

/// Works (J) that are integrated along: of the drives, lost in joints and legs, lost in contacts, of drag.
pub(crate) const WORKS: usize = 4;
pub(crate) const DRIVE: usize = 0;
pub(crate) const JOINT_LOSS: usize = 1;
pub(crate) const CONTACT_LOSS: usize = 2;
pub(crate) const DRAG_LOSS: usize = 3;

impl Layout {
    pub(crate) fn size(&self) -> usize {
        self.coordinates + self.velocities + self.legs + WORKS
    }
    pub(crate) fn q<'a>(&self, y: &'a [f64]) -> &'a [f64] {
        &y[..self.coordinates]
    }
    pub(crate) fn v<'a>(&self, y: &'a [f64]) -> &'a [f64] {
        &y[self.coordinates..self.coordinates + self.velocities]
    }
    pub(crate) fn gas(&self) -> usize {
        self.coordinates + self.velocities
    }
    pub(crate) fn works(&self) -> usize {
        self.gas() + self.legs
    }
}

/// Velocity (m/s or rad/s) below which something counts as standing: round-off of what an event or an impact leaves.
pub(crate) const STANDING: f64 = 1e-9;

/// What a constraint row belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Owner {
    Normal(usize),
    /// Contact, and 0 for along (or a cone's both), 1 for across.
    Tangent(usize, usize),
    /// Body.
    Joint(usize),
}

/// How a closed contact lies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Touch {
    pub contact: usize,
    /// Where it touches (m).
    pub place: Vec3,
    pub normal: Vec3,
    pub along: Vec3,
    pub across: Vec3,
    /// Distance between point and surface (m).
    pub gap: f64,
    /// Speeds along normal, along and across (m/s).
    pub speeds: Vec3,
    /// Spring and damper's force (N); none: rigid.
    pub spring: Option<f64>,
}

/// Which constraints take part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rows {
    /// Those that hold in the mode.
    Holding,
    /// All that touch and stand, to be decided.
    Candidates,
    /// All that touch, to take an impact.
    Impact,
}

/// A mechanism with its latched joints welded, and room to work.
pub(crate) struct Machine<'a> {
    pub mechanism: &'a Mechanism,
    pub layout: Layout,
    pub pairs: Vec<(usize, usize)>,
    welded: Welded,
    /// Each contact point: its body in the welded tree, and its centre there.
    points: Vec<(Option<usize>, Vec3)>,
    /// Velocity index in the welded tree of the joint of each body, if it moves.
    dof: Vec<Option<usize>>,
    q: Vec<f64>,
    v: Vec<f64>,
    pose: Pose,
    mass: Vec<f64>,
    /// Applied forces less h, then M⁻¹ of them.
    free: Vec<f64>,
    /// Constraint rows J, force directions G, and L⁻¹ of both.
    jacobian: Vec<f64>,
    directions: Vec<f64>,
    reduced: Vec<f64>,
    reduced_directions: Vec<f64>,
    rates: Vec<f64>,
    /// Speeds along the rows.
    pub speeds: Vec<f64>,
    pub owners: Vec<Owner>,
    pub problem: Problem,
    pub touches: Vec<Touch>,
    /// Accelerations (welded).
    pub acceleration: Vec<f64>,
    /// Whether the contact forces are one choice of many.
    pub redundant: bool,
    /// Pressure of each chamber (Pa).
    pub pressures: Vec<f64>,
    powers: [f64; WORKS],
    /// Chamber rates u̇.
    gas_rates: Vec<f64>,
    /// Mass matrix was positive definite, and all was finite.
    pub sound: bool,
}

impl<'a> Machine<'a> {
    pub(crate) fn new(mechanism: &'a Mechanism) -> Machine<'a> {
        let layout = Layout {
            coordinates: mechanism.tree.coordinates(),
            velocities: mechanism.tree.velocities(),
            legs: mechanism.legs.len(),
        };
        let welded = mechanism.tree.weld(&vec![false; mechanism.tree.bodies().len()], &[]);
        let mut machine = Machine {
            mechanism,
            layout,
            pairs: mechanism.pairs().collect(),
            welded,
            points: Vec::new(),
            dof: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            pose: Pose::default(),
            mass: Vec::new(),
            free: Vec::new(),
            jacobian: Vec::new(),
            directions: Vec::new(),
            reduced: Vec::new(),
            reduced_directions: Vec::new(),
            rates: vec![0.0; layout.coordinates],
            speeds: Vec::new(),
            owners: Vec::new(),
            problem: Problem::default(),
            touches: Vec::new(),
            acceleration: Vec::new(),
            redundant: false,
            pressures: vec![0.0; layout.legs],
            powers: [0.0; WORKS],
            gas_rates: vec![0.0; layout.legs],
            sound: true,
        };
        machine.resize();
        machine
    }

    /// Welds the joints that `mode` latches, as they are in `y`.
    pub(crate) fn weld(&mut self, mode: &Mode, y: &[f64]) {
        self.welded = self.mechanism.tree.weld(&mode.latched(), self.layout.q(y));
        self.resize();
    }

    fn resize(&mut self) {
        let home = |body: usize| &self.welded.home[body];
        self.points =
            self.mechanism.points.iter().map(|p| (home(p.body).0, home(p.body).1.point(&p.center))).collect();
        self.dof = (0..self.mechanism.tree.bodies().len())
            .map(|body| {
                let k = self.mechanism.tree.velocity_of(body);
                self.welded.velocities.iter().position(|&full| full == k)
            })
            .collect();
        let n = self.n();
        self.mass.resize(n * n, 0.0);
        self.free.resize(n, 0.0);
        self.acceleration.resize(n, 0.0);
    }

    /// Number of velocities that move.
    fn n(&self) -> usize {
        self.welded.tree.velocities()
    }

    /// The derivative of the state `y` in `mode`; NaN where the equations have no answer.
    pub(crate) fn derivative(&mut self, y: &[f64], mode: &Mode, dy: &mut [f64]) {
        self.look(y, mode);
        dy.fill(0.0);
        if !self.sound {
            dy.fill(f64::NAN);
            return;
        }
        let layout = self.layout;
        self.welded.tree.coordinate_rates(&self.q, &self.v, &mut self.rates);
        for (i, &full) in self.welded.coordinates.iter().enumerate() {
            dy[full] = self.rates[i];
        }
        for (k, &full) in self.welded.velocities.iter().enumerate() {
            dy[layout.coordinates + full] = self.acceleration[k];
        }
        dy[layout.gas()..layout.works()].copy_from_slice(&self.gas_rates);
        dy[layout.works()..].copy_from_slice(&self.powers);
    }

    /// Accelerations and constraint forces at `y` in `mode`.
    pub(crate) fn look(&mut self, y: &[f64], mode: &Mode) {
        self.assemble(y, mode, Rows::Holding);
        self.redundant = self.problem.solve();
        self.accelerate();
        self.account(mode);
    }

    /// Mass matrix, forces and constraint rows at `y`.
    pub(crate) fn assemble(&mut self, y: &[f64], mode: &Mode, rows: Rows) {
        self.place(y);
        let n = self.n();
        self.pose.equations(&self.welded.tree, &self.mechanism.gravity, &mut self.mass, &mut self.free);
        self.free.iter_mut().for_each(|x| *x = -*x);
        self.powers = [0.0; WORKS];
        self.apply_joints(y, mode);
        self.apply_drag();
        self.sound = cholesky(&mut self.mass, n);
        self.touch(mode);
        self.clear_rows();
        self.contact_rows(mode, rows);
        self.joint_rows(mode, rows, y);
        self.couple(rows);
    }

    /// Puts the welded tree where `y` says.
    pub(crate) fn place(&mut self, y: &[f64]) {
        let (q, v) = (self.layout.q(y), self.layout.v(y));
        self.q.clear();
        self.q.extend(self.welded.coordinates.iter().map(|&i| q[i]));
        self.v.clear();
        self.v.extend(self.welded.velocities.iter().map(|&i| v[i]));
        self.pose.set(&self.welded.tree, &self.q, &self.v);
    }

    /// Forces in joints and legs, and what they do.
    fn apply_joints(&mut self, y: &[f64], mode: &Mode) {
        for body in 0..self.dof.len() {
            let Some(k) = self.dof[body] else { continue };
            let parts = &self.mechanism.joints[body];
            if mode.joints[body] == JointMode::Latched {
                continue;
            }
            let speed = self.v[k];
            let mut force = -parts.damping * speed;
            if let JointMode::Sliding(sign) = mode.joints[body] {
                force -= sign * parts.friction;
            }
            self.powers[JOINT_LOSS] -= force * speed;
            if parts.spring.0 > 0.0 {
                // A spring keeps its energy: it is not a loss.
                let x = y[self.mechanism.tree.coordinate_of(body)];
                force -= parts.spring.0 * (x - parts.spring.1);
            }
            self.free[k] += force;
        }
        for i in 0..self.mechanism.legs.len() {
            self.apply_leg(i, y, mode);
        }
    }

    fn apply_leg(&mut self, i: usize, y: &[f64], mode: &Mode) {
        let part = &self.mechanism.legs[i];
        let (leg, state) = (&part.leg, &mode.legs[i]);
        let d = y[self.mechanism.tree.coordinate_of(part.body)];
        let speed = self.dof[part.body].map_or(0.0, |k| self.v[k]);
        let u = y[self.layout.gas() + i];
        (self.gas_rates[i], self.pressures[i]) = match (leg.chamber(), &state.piece) {
            (Some(chamber), Some(piece)) => {
                let (gas, rate) = piece.gas(chamber, u, d, speed);
                (rate, gas.pressure)
            }
            _ => (0.0, 0.0),
        };
        let (Some(k), false) = (self.dof[part.body], mode.joints[part.body] == JointMode::Latched) else {
            return;
        };
        let switches = Switches { energized: state.energized, cushioned: state.cushioned };
        let drive = leg.drive_force(switches, d, speed, self.pressures[i]).value;
        let dry = leg.dry_friction(self.pressures[i]);
        // The leg's own law is that of an extending one: dry friction is put right for the others.
        let without = leg.force(switches, d, speed, self.pressures[i]).value + dry;
        let force = match mode.joints[part.body] {
            JointMode::Sliding(sign) => without - sign * dry,
            _ => without,
        };
        self.powers[DRIVE] += drive * speed;
        self.powers[JOINT_LOSS] += (drive - force) * speed;
        self.free[k] += force;
    }

    fn apply_drag(&mut self) {
        let Some(drag) = self.mechanism.drag else { return };
        let (Some(body), placement) = self.welded.home[drag.body] else { return };
        let at = self.pose.frames[body].then(&placement).position;
        let velocity = self.pose.velocities[body].at(&at);
        let force = velocity * (-drag.coefficient * velocity.norm());
        self.powers[DRAG_LOSS] -= force.dot(&velocity);
        for k in self.welded.tree.path(body) {
            self.free[k] += self.pose.axes[k].at(&at).dot(&force);
        }
    }

    /// How contact `c` lies at the present place.
    pub(crate) fn lie(&self, c: usize) -> Touch {
        let (point, surface) = self.pairs[c];
        let (body, center) = &self.points[point];
        let (center, velocity) = match body {
            Some(b) => (self.pose.frames[*b].point(center), self.pose.velocities[*b]),
            None => (*center, Motion::default()),
        };
        let radius = self.mechanism.points[point].radius;
        let near = self.mechanism.surfaces[surface].proximity(&center);
        let place = center - near.normal * radius;
        let (along, across) = self.mechanism.travel.directions(&place, &near.normal);
        let speed = velocity.at(&place);
        Touch {
            contact: c,
            place,
            normal: near.normal,
            along,
            across,
            gap: near.distance - radius,
            speeds: Vec3::new(speed.dot(&near.normal), speed.dot(&along), speed.dot(&across)),
            spring: None,
        }
    }

    /// Geometry and springs of the closed contacts.
    fn touch(&mut self, mode: &Mode) {
        self.touches.clear();
        for c in 0..mode.contacts.len() {
            if mode.contacts[c].closed {
                let mut touch = self.lie(c);
                if let Some((stiffness, damping)) = self.mechanism.material.compliance {
                    touch.spring = Some(-stiffness * touch.gap - damping * touch.speeds.x);
                }
                self.touches.push(touch);
            }
        }
    }

    fn clear_rows(&mut self) {
        self.jacobian.clear();
        self.directions.clear();
        self.speeds.clear();
        self.owners.clear();
        self.problem.rows = 0;
        self.problem.b.clear();
        self.problem.elements.clear();
    }

    /// Adds the row of a direction at a contact; `bias` is its acceleration where all v̇ are 0.
    fn push_row(
        &mut self,
        owner: Owner,
        body: Option<usize>,
        place: &Vec3,
        direction: &Vec3,
        bias: f64,
        speed: f64,
    ) {
        let n = self.n();
        let start = self.jacobian.len();
        self.jacobian.resize(start + n, 0.0);
        if let Some(body) = body {
            for k in self.welded.tree.path(body) {
                self.jacobian[start + k] = self.pose.axes[k].at(place).dot(direction);
            }
        }
        self.directions.extend_from_within(..0);
        let row = &self.jacobian[start..];
        self.directions.extend_from_slice(row);
        self.problem.b.push(bias);
        self.problem.rows += 1;
        self.owners.push(owner);
        self.speeds.push(speed);
    }

    fn contact_rows(&mut self, mode: &Mode, rows: Rows) {
        for i in 0..self.touches.len() {
            let touch = self.touches[i];
            if touch.spring.is_some() {
                self.compliant_rows(&touch, mode, rows);
            } else {
                self.rigid_rows(&touch, mode, rows);
            }
        }
    }

    /// The acceleration of a contact's place along its axes where all v̇ are 0.
    fn contact_bias(&self, touch: &Touch, body: Option<usize>, center: &Vec3) -> Vec3 {
        let Some(b) = body else { return Vec3::zeros() };
        let (point, surface) = self.pairs[touch.contact];
        let center = self.pose.frames[b].point(center);
        let (velocity, bias) = (&self.pose.velocities[b], &self.pose.bias[b]);
        let mut acceleration = bias.acceleration_at(velocity, &center);
        let mut turning = Vec3::zeros();
        if self.mechanism.points[point].radius > 0.0 {
            // The place of contact moves along the sphere: only its centre is fixed in the body.
            acceleration += bias.angular.cross(&(touch.place - center));
            let moving = velocity.at(&center);
            turning = self.mechanism.surfaces[surface].proximity(&center).normal_rate(&moving);
            let normal = acceleration.dot(&touch.normal) + moving.dot(&turning);
            return Vec3::new(normal, acceleration.dot(&touch.along), acceleration.dot(&touch.across));
        }
        let _ = turning;
        Vec3::new(
            acceleration.dot(&touch.normal),
            acceleration.dot(&touch.along),
            acceleration.dot(&touch.across),
        )
    }

    /// Friction coefficients, standing and slipping, of a contact's axes, and how many rows each axis has.
    fn friction(&self) -> [(f64, f64, usize); 2] {
        match self.mechanism.material.friction {
            Friction::Cone { standing, slipping } => [(standing, slipping, 2), (0.0, 0.0, 0)],
            Friction::Axes { along, across } => [(along.0, along.1, 1), (across.0, across.1, 1)],
        }
    }

    fn rigid_rows(&mut self, touch: &Touch, mode: &Mode, rows: Rows) {
        let c = touch.contact;
        let (point, _) = self.pairs[c];
        let (body, center) = self.points[point];
        let bias = self.contact_bias(touch, body, &center);
        let normal = self.problem.rows;
        self.push_row(Owner::Normal(c), body, &touch.place, &touch.normal, bias.x, touch.speeds.x);
        self.problem.elements.push(Element {
            row: normal,
            bounds: Bounds::Between(0.0, f64::INFINITY),
            grip: Grip::Held,
        });
        let grips = mode.contacts[c].grips;
        for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
            if standing == 0.0 {
                continue;
            }
            let speed =
                if width == 2 { touch.speeds.y.hypot(touch.speeds.z) } else { touch.speeds[1 + axis].abs() };
            let stands = match rows {
                Rows::Holding => grips[axis] == Grip::Held,
                Rows::Candidates => speed <= STANDING,
                Rows::Impact => true,
            };
            if stands {
                let row = self.problem.rows;
                self.tangent_rows(touch, axis, width, body, &bias);
                self.problem.elements.push(Element {
                    row,
                    bounds: Bounds::Friction { normal: Some(normal), limit: standing, rows: width },
                    grip: Grip::Held,
                });
            } else {
                let slide = slide(touch, axis, width, grips[axis]) * -slipping;
                let n = self.n();
                if let Some(b) = body {
                    for k in self.welded.tree.path(b) {
                        self.directions[normal * n + k] += self.pose.axes[k].at(&touch.place).dot(&slide);
                    }
                }
            }
        }
    }

    fn tangent_rows(&mut self, touch: &Touch, axis: usize, width: usize, body: Option<usize>, bias: &Vec3) {
        let owner = Owner::Tangent(touch.contact, axis);
        for k in axis..axis + width {
            let direction = if k == 0 { touch.along } else { touch.across };
            self.push_row(owner, body, &touch.place, &direction, bias[1 + k], touch.speeds[1 + k]);
        }
    }

    fn compliant_rows(&mut self, touch: &Touch, mode: &Mode, rows: Rows) {
        let c = touch.contact;
        let (point, _) = self.pairs[c];
        let (body, center) = self.points[point];
        let (Some(b), Some(spring)) = (body, touch.spring) else { return };
        let normal = spring.max(0.0);
        let mut force = touch.normal * normal;
        if let Some((_, damping)) = self.mechanism.material.compliance {
            self.powers[CONTACT_LOSS] += damping * touch.speeds.x * touch.speeds.x;
        }
        let bias = self.contact_bias(touch, body, &center);
        let grips = mode.contacts[c].grips;
        for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
            // A spring takes an impact in its own time: the feet's rows have no part in one.
            if standing == 0.0 || rows == Rows::Impact {
                continue;
            }
            let speed =
                if width == 2 { touch.speeds.y.hypot(touch.speeds.z) } else { touch.speeds[1 + axis].abs() };
            let stands = match rows {
                Rows::Holding => grips[axis] == Grip::Held,
                _ => speed <= STANDING,
            };
            if stands {
                let row = self.problem.rows;
                self.tangent_rows(touch, axis, width, body, &bias);
                let limit = if standing.is_finite() { standing * normal } else { f64::INFINITY };
                self.problem.elements.push(Element {
                    row,
                    bounds: Bounds::Friction { normal: None, limit, rows: width },
                    grip: Grip::Held,
                });
            } else {
                let push = slide(touch, axis, width, grips[axis]) * (-slipping * normal);
                force += push;
            }
        }
        if rows == Rows::Impact {
            return;
        }
        let n = self.n();
        let mut work = vec![0.0; n];
        for k in self.welded.tree.path(b) {
            work[k] = self.pose.axes[k].at(&touch.place).dot(&force);
        }
        for k in 0..n {
            self.free[k] += work[k];
        }
    }

    fn joint_rows(&mut self, mode: &Mode, rows: Rows, y: &[f64]) {
        for body in 0..self.dof.len() {
            let (Some(k), joint) = (self.dof[body], mode.joints[body]) else { continue };
            let dry = self.dry_friction(body);
            let bounds = match (rows, joint) {
                (_, JointMode::Latched) | (Rows::Holding, JointMode::Free | JointMode::Sliding(_)) => {
                    continue;
                }
                (Rows::Holding, JointMode::Held(_)) => Bounds::Between(f64::NEG_INFINITY, f64::INFINITY),
                (Rows::Impact, JointMode::Held(Stop::Low)) => Bounds::Between(0.0, f64::INFINITY),
                (Rows::Impact, JointMode::Held(Stop::High)) => Bounds::Between(f64::NEG_INFINITY, 0.0),
                (Rows::Impact, _) => continue,
                (Rows::Candidates, _) if self.v[k].abs() > STANDING => continue,
                (Rows::Candidates, JointMode::Free | JointMode::Sliding(_)) if dry == 0.0 => continue,
                (Rows::Candidates, JointMode::Held(stop)) => match stop {
                    Stop::Low => Bounds::Between(-dry, f64::INFINITY),
                    Stop::High => Bounds::Between(f64::NEG_INFINITY, dry),
                    Stop::Between => Bounds::Between(-dry, dry),
                },
                (Rows::Candidates, JointMode::Sliding(sign)) => {
                    // Its friction is decided anew.
                    self.free[k] += sign * dry;
                    Bounds::Between(-dry, dry)
                }
                (Rows::Candidates, JointMode::Free) => Bounds::Between(-dry, dry),
            };
            let _ = y;
            let (n, row) = (self.n(), self.problem.rows);
            let start = self.jacobian.len();
            self.jacobian.resize(start + n, 0.0);
            self.jacobian[start + k] = 1.0;
            self.directions.resize(start + n, 0.0);
            self.directions[start + k] = 1.0;
            self.problem.b.push(0.0);
            self.problem.rows += 1;
            self.owners.push(Owner::Joint(body));
            self.speeds.push(self.v[k]);
            self.problem.elements.push(Element { row, bounds, grip: Grip::Held });
        }
    }

    /// Dry friction (N or N m) in the joint of `body`, at the present pressure.
    pub(crate) fn dry_friction(&self, body: usize) -> f64 {
        match self.mechanism.leg_of(body) {
            Some(i) => self.mechanism.legs[i].leg.dry_friction(self.pressures[i]),
            None => self.mechanism.joints[body].friction,
        }
    }

    /// A = J M⁻¹ Gᵀ and b of the problem.
    fn couple(&mut self, rows: Rows) {
        let (n, m) = (self.n(), self.problem.rows);
        forward(&self.mass, n, &mut self.free);
        self.reduced.clear();
        self.reduced.extend_from_slice(&self.jacobian);
        self.reduced_directions.clear();
        self.reduced_directions.extend_from_slice(&self.directions);
        for r in 0..m {
            forward(&self.mass, n, &mut self.reduced[r * n..(r + 1) * n]);
            forward(&self.mass, n, &mut self.reduced_directions[r * n..(r + 1) * n]);
        }
        self.problem.a.clear();
        for r in 0..m {
            let row = &self.reduced[r * n..(r + 1) * n];
            for c in 0..m {
                let other = &self.reduced_directions[c * n..(c + 1) * n];
                self.problem.a.push(row.iter().zip(other).map(|(a, b)| a * b).sum());
            }
            let free: f64 = row.iter().zip(&self.free).map(|(a, b)| a * b).sum();
            match rows {
                Rows::Impact => self.problem.b[r] = self.speeds[r],
                _ => self.problem.b[r] += free,
            }
        }
    }

    /// Accelerations under the problem's forces.
    pub(crate) fn accelerate(&mut self) {
        let n = self.n();
        self.acceleration.clone_from(&self.free);
        for r in 0..self.problem.rows {
            let force = self.problem.force[r];
            for k in 0..n {
                self.acceleration[k] += force * self.reduced_directions[r * n + k];
            }
        }
        backward(&self.mass, n, &mut self.acceleration);
        self.sound &= self.acceleration.iter().all(|a| a.is_finite());
    }

    /// Work lost where contacts slip.
    fn account(&mut self, mode: &Mode) {
        for touch in &self.touches {
            let normal = touch.spring.map_or_else(|| self.normal_force(touch.contact), |f| f.max(0.0));
            for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
                let grip = mode.contacts[touch.contact].grips[axis];
                if standing > 0.0 && grip != Grip::Held {
                    let speed = if width == 2 {
                        touch.speeds.y.hypot(touch.speeds.z)
                    } else {
                        touch.speeds[1 + axis].abs()
                    };
                    self.powers[CONTACT_LOSS] += slipping * normal * speed;
                }
            }
        }
    }

    /// The force (N) along the normal of contact `c`, 0 where it has none.
    pub(crate) fn normal_force(&self, c: usize) -> f64 {
        self.force_of(Owner::Normal(c)).first().copied().unwrap_or(0.0)
    }

    /// The forces of the rows of `owner`.
    pub(crate) fn force_of(&self, owner: Owner) -> &[f64] {
        let first = self.owners.iter().position(|o| *o == owner);
        first.map_or(&[], |i| {
            let count = self.owners[i..].iter().take_while(|o| **o == owner).count();
            &self.problem.force[i..i + count]
        })
    }

    /// Adds the velocity jumps that the problem's impulses make to `y`.
    pub(crate) fn jump(&self, y: &mut [f64]) {
        let n = self.n();
        let mut change = vec![0.0; n];
        for r in 0..self.problem.rows {
            for k in 0..n {
                change[k] += self.problem.force[r] * self.reduced[r * n + k];
            }
        }
        backward(&self.mass, n, &mut change);
        for (k, &full) in self.welded.velocities.iter().enumerate() {
            y[self.layout.coordinates + full] += change[k];
        }
    }

    /// Takes out of `y` what integration has put into the directions that do not move: speeds along the held rows, and
    /// penetration of the rigid contacts.
    pub(crate) fn project(&mut self, y: &mut [f64], mode: &Mode) {
        if self.problem.rows == 0 {
            return;
        }
        for e in &mut self.problem.elements {
            e.grip = Grip::Held;
        }
        let n = self.n();
        // Both corrections are least in kinetic energy, so they go along M⁻¹ Jᵀ.
        let m = self.problem.rows;
        self.problem.a.clear();
        for r in 0..m {
            for c in 0..m {
                let dot = (0..n).map(|k| self.reduced[r * n + k] * self.reduced[c * n + k]).sum();
                self.problem.a.push(dot);
            }
        }
        self.problem.b.clone_from(&self.speeds);
        self.problem.solve();
        self.jump(y);
        let gaps: Vec<f64> = self
            .owners
            .iter()
            .map(|owner| match owner {
                Owner::Normal(c) => self.touches.iter().find(|t| t.contact == *c).map_or(0.0, |t| t.gap),
                _ => 0.0,
            })
            .collect();
        self.problem.b = gaps;
        self.problem.solve();
        let mut change = vec![0.0; n];
        for r in 0..m {
            for k in 0..n {
                change[k] += self.problem.force[r] * self.reduced[r * n + k];
            }
        }
        backward(&self.mass, n, &mut change);
        self.welded.tree.coordinate_rates(&self.q, &change, &mut self.rates);
        for (i, &full) in self.welded.coordinates.iter().enumerate() {
            y[full] += self.rates[i];
        }
        for (body, joint) in mode.joints.iter().enumerate() {
            if let (JointMode::Held(stop), Some(_)) = (joint, self.dof[body]) {
                y[self.layout.coordinates + self.mechanism.tree.velocity_of(body)] = 0.0;
                let (low, high) = self.mechanism.stops(body);
                let x = &mut y[self.mechanism.tree.coordinate_of(body)];
                match stop {
                    Stop::Low => *x = low,
                    Stop::High => *x = high,
                    Stop::Between => {}
                }
            }
        }
    }

    /// Speed in the joint of `body`.
    pub(crate) fn joint_speed(&self, y: &[f64], body: usize) -> f64 {
        y[self.layout.coordinates + self.mechanism.tree.velocity_of(body)]
    }

    /// Friction coefficients, standing and slipping, and rows of each axis.
    pub(crate) fn axes(&self) -> [(f64, f64, usize); 2] {
        self.friction()
    }
}

/// The unit vector along which a contact slips in an axis.
fn slide(touch: &Touch, axis: usize, width: usize, grip: Grip) -> Vec3 {
    if width == 1 {
        let direction = if axis == 0 { touch.along } else { touch.across };
        return match grip {
            Grip::Low => direction,
            Grip::High => -direction,
            _ => direction * touch.speeds[1 + axis].signum(),
        };
    }
    let speed = touch.speeds.y.hypot(touch.speeds.z);
    match grip {
        // From rest, the direction is that in which it begins.
        Grip::Along(d) if speed <= 1e-3 * STANDING => touch.along * d[0] + touch.across * d[1],
        grip => {
            // Past the instant of rest friction goes on as it was, so that the instant can be located.
            let ahead = match grip {
                Grip::Along(d) => touch.speeds.y * d[0] + touch.speeds.z * d[1],
                _ => speed,
            };
            (touch.along * touch.speeds.y + touch.across * touch.speeds.z) / speed.copysign(ahead)
        }
    }
}
