//! Constraint rows: contacts, friction and joints that hold.

use super::{CONTACT_LOSS, Machine, Owner, Rows, STANDING, Touch};
use crate::complementarity::{Bounds, Element, Grip};
use crate::contact::Friction;
use crate::linear::forward;
use crate::mode::{JointMode, Mode, Stop};
use crate::spatial::{Motion, Vec3};

impl Machine<'_> {
    /// How contact `c` lies at the present place.
    pub(crate) fn lie(&self, c: usize) -> Touch {
        let (point, surface) = self.pairs[c];
        let body = self.points[point].0;
        let (center, _) = self.center(c, 0.0);
        let velocity = body.map_or_else(Motion::default, |b| self.pose.velocities[b]);
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
            speeds: Vec3::new(
                speed.dot(&near.normal),
                speed.dot(&along),
                speed.dot(&across),
            ),
            spring: None,
        }
    }

    /// Distance (m) between the point and the surface of contact `c` at the present place, and how
    /// it would be `ahead` (s) later.
    pub(crate) fn gap(&self, c: usize, ahead: f64) -> f64 {
        let (point, surface) = self.pairs[c];
        if self.points[point].0.is_none() {
            return f64::INFINITY;
        }
        let (moved, _) = self.center(c, ahead);
        self.mechanism.surfaces[surface].proximity(&moved).distance
            - self.mechanism.points[point].radius
    }

    /// The centre (m) of the point of contact `c`, `ahead` (s) later; of a bar, the place of its
    /// axis that is nearest to the surface, and whether that lies between its ends.
    fn center(&self, c: usize, ahead: f64) -> (Vec3, bool) {
        let (point, surface) = self.pairs[c];
        let (body, center) = &self.points[point];
        let later = |place: &Vec3| match body {
            Some(b) => {
                let place = self.pose.frames[*b].point(place);
                place + self.pose.velocities[*b].at(&place) * ahead
            }
            None => *place,
        };
        let first = later(center);
        let Some(end) = &self.bars[point] else {
            return (first, false);
        };
        let last = later(end);
        let part = self.mechanism.surfaces[surface].nearest_on_bar(&first, &last);
        (first + (last - first) * part, part > 0.0 && part < 1.0)
    }

    /// Geometry and springs of the closed contacts.
    pub(super) fn touch(&mut self, mode: &Mode) {
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

    pub(super) fn clear_rows(&mut self) {
        self.jacobian.clear();
        self.directions.clear();
        self.speeds.clear();
        self.owners.clear();
        self.problem.rows = 0;
        self.problem.b.clear();
        self.problem.elements.clear();
    }

    /// Adds the row of a direction at a contact; `bias` is its acceleration where all v̇ are 0.
    pub(super) fn push_row(
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
        let row = &self.jacobian[start..];
        self.directions.extend_from_slice(row);
        self.problem.b.push(bias);
        self.problem.rows += 1;
        self.owners.push(owner);
        self.speeds.push(speed);
    }

    pub(super) fn contact_rows(&mut self, mode: &Mode, rows: Rows) {
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
    pub(super) fn contact_bias(&self, touch: &Touch, body: Option<usize>) -> Vec3 {
        let Some(b) = body else { return Vec3::zeros() };
        let (point, surface) = self.pairs[touch.contact];
        let (center, is_side) = self.center(touch.contact, 0.0);
        let (velocity, bias) = (&self.pose.velocities[b], &self.pose.bias[b]);
        let mut acceleration = bias.acceleration_at(velocity, &center);
        let moving = velocity.at(&center);
        if is_side {
            // An edge slides along the bar's side, whose normal turns with the bar: ẅ = n·a + 2
            // (ω × n)·v at the place that stands still.
            let at = touch.place;
            let (moving, acceleration) = (velocity.at(&at), bias.acceleration_at(velocity, &at));
            let row = |n: &Vec3| acceleration.dot(n) + 2.0 * velocity.angular.cross(n).dot(&moving);
            return Vec3::new(row(&touch.normal), row(&touch.along), row(&touch.across));
        }
        let mut turning = Vec3::zeros();
        if self.mechanism.points[point].radius > 0.0 {
            // The place of contact moves along the sphere: only its centre is fixed in the body.
            acceleration += bias.angular.cross(&(touch.place - center));
            turning = self.mechanism.surfaces[surface]
                .proximity(&center)
                .normal_rate(&moving);
        }
        let [along, across] =
            self.mechanism
                .travel
                .direction_rates((&touch.place, &touch.normal), &moving, &turning);
        let slip = velocity.at(&touch.place);
        Vec3::new(
            acceleration.dot(&touch.normal) + moving.dot(&turning),
            acceleration.dot(&touch.along) + slip.dot(&along),
            acceleration.dot(&touch.across) + slip.dot(&across),
        )
    }

    /// Friction coefficients, standing and slipping, of a contact's axes, and how many rows each
    /// axis has.
    pub(crate) fn friction(&self) -> [(f64, f64, usize); 2] {
        match self.mechanism.material.friction {
            Friction::Cone { standing, slipping } => [(standing, slipping, 2), (0.0, 0.0, 0)],
            Friction::Axes { along, across } => [(along.0, along.1, 1), (across.0, across.1, 1)],
        }
    }

    /// Adds the row of a rigid contact's normal: its body, the acceleration of its place where all v̇
    /// are 0, and which row it is.
    pub(super) fn normal_row(&mut self, touch: &Touch) -> (Option<usize>, Vec3, usize) {
        let body = self.points[self.pairs[touch.contact].0].0;
        let bias = self.contact_bias(touch, body);
        let row = self.problem.rows;
        let (owner, speed) = (Owner::Normal(touch.contact), touch.speeds.x);
        self.push_row(owner, body, &touch.place, &touch.normal, bias.x, speed);
        self.problem.elements.push(Element {
            row,
            bounds: Bounds::Between(0.0, f64::INFINITY),
            grip: Grip::Held,
        });
        (body, bias, row)
    }

    /// Whether a contact has rows of friction along an axis; else it slips there.
    fn stands(&self, touch: &Touch, (axis, width): (usize, usize), grip: Grip, rows: Rows) -> bool {
        match rows {
            Rows::Holding => grip == Grip::Held,
            Rows::Candidates => touch.slip(axis, width) <= self.standing,
            Rows::Impact => true,
        }
    }

    fn rigid_rows(&mut self, touch: &Touch, mode: &Mode, rows: Rows) {
        let (body, bias, normal) = self.normal_row(touch);
        let grips = mode.contacts[touch.contact].grips;
        for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
            if standing == 0.0 {
                continue;
            }
            if self.stands(touch, (axis, width), grips[axis], rows) {
                let row = self.problem.rows;
                self.tangent_rows(touch, axis, width, body, &bias);
                self.problem.elements.push(Element {
                    row,
                    bounds: Bounds::Friction {
                        normal: Some(normal),
                        limit: standing,
                        rows: width,
                    },
                    grip: Grip::Held,
                });
            } else {
                let slide = slide(touch, axis, width, grips[axis]) * -slipping;
                let n = self.n();
                if let Some(b) = body {
                    for k in self.welded.tree.path(b) {
                        self.directions[normal * n + k] +=
                            self.pose.axes[k].at(&touch.place).dot(&slide);
                    }
                }
            }
        }
    }

    pub(super) fn tangent_rows(
        &mut self,
        touch: &Touch,
        axis: usize,
        width: usize,
        body: Option<usize>,
        bias: &Vec3,
    ) {
        let owner = Owner::Tangent(touch.contact, axis);
        for k in axis..axis + width {
            let direction = if k == 0 { touch.along } else { touch.across };
            self.push_row(
                owner,
                body,
                &touch.place,
                &direction,
                bias[1 + k],
                touch.speeds[1 + k],
            );
        }
    }

    pub(super) fn compliant_rows(&mut self, touch: &Touch, mode: &Mode, rows: Rows) {
        let c = touch.contact;
        let (point, _) = self.pairs[c];
        let body = self.points[point].0;
        let (Some(b), Some(spring)) = (body, touch.spring) else {
            return;
        };
        let normal = spring.max(0.0);
        let mut force = touch.normal * normal;
        if let Some((_, damping)) = self.mechanism.material.compliance {
            self.powers[CONTACT_LOSS] += damping * touch.speeds.x * touch.speeds.x;
        }
        let bias = self.contact_bias(touch, body);
        let grips = mode.contacts[c].grips;
        for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
            // A spring takes an impact in its own time: only what cannot slip has a part in one.
            if standing == 0.0 || (rows == Rows::Impact && standing.is_finite()) {
                continue;
            }
            if self.stands(touch, (axis, width), grips[axis], rows) {
                let row = self.problem.rows;
                self.tangent_rows(touch, axis, width, body, &bias);
                let limit = if standing.is_finite() {
                    standing * normal
                } else {
                    f64::INFINITY
                };
                self.problem.elements.push(Element {
                    row,
                    bounds: Bounds::Friction {
                        normal: None,
                        limit,
                        rows: width,
                    },
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
        for k in self.welded.tree.path(b) {
            self.free[k] += self.pose.axes[k].at(&touch.place).dot(&force);
        }
    }

    pub(super) fn joint_rows(&mut self, mode: &Mode, rows: Rows) {
        for body in 0..self.dof.len() {
            let (Some(k), joint) = (self.dof[body], mode.joints[body]) else {
                continue;
            };
            let dry = self.dry_friction(body);
            let bounds = match (rows, joint) {
                (_, JointMode::Latched)
                | (Rows::Holding, JointMode::Free | JointMode::Sliding(_)) => {
                    continue;
                }
                (Rows::Holding, JointMode::Held(_)) => {
                    Bounds::Between(f64::NEG_INFINITY, f64::INFINITY)
                }
                (Rows::Impact, JointMode::Held(Stop::Low)) => Bounds::Between(0.0, f64::INFINITY),
                (Rows::Impact, JointMode::Held(Stop::High)) => {
                    Bounds::Between(f64::NEG_INFINITY, 0.0)
                }
                (Rows::Impact, _) => continue,
                (Rows::Candidates, _) if self.v[k].abs() > self.standing => continue,
                (Rows::Candidates, JointMode::Free | JointMode::Sliding(_)) if dry == 0.0 => {
                    continue;
                }
                (Rows::Candidates, JointMode::Held(stop)) => at_stop(stop, dry),
                (Rows::Candidates, JointMode::Sliding(sign)) => {
                    // Its friction is decided anew.
                    self.free[k] += sign * dry;
                    Bounds::Between(-dry, dry)
                }
                (Rows::Candidates, JointMode::Free) => Bounds::Between(-dry, dry),
            };
            self.push_joint_row(body, k, bounds);
        }
    }

    /// Adds the row of the joint of `body`, whose velocity is `k`.
    pub(super) fn push_joint_row(&mut self, body: usize, k: usize, bounds: Bounds) {
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
        self.problem.elements.push(Element {
            row,
            bounds,
            grip: Grip::Held,
        });
    }

    /// A = J M⁻¹ Gᵀ and b of the problem.
    pub(super) fn couple(&mut self, rows: Rows) {
        let (n, m) = (self.n(), self.problem.rows);
        forward(&self.mass, n, &mut self.free);
        self.reduced.clear();
        self.reduced.extend_from_slice(&self.jacobian);
        self.reduced_directions.clear();
        self.reduced_directions.extend_from_slice(&self.directions);
        for r in 0..m {
            forward(&self.mass, n, &mut self.reduced[r * n..(r + 1) * n]);
            forward(
                &self.mass,
                n,
                &mut self.reduced_directions[r * n..(r + 1) * n],
            );
        }
        self.problem.a.clear();
        for r in 0..m {
            let row = &self.reduced[r * n..(r + 1) * n];
            for c in 0..m {
                let other = &self.reduced_directions[c * n..(c + 1) * n];
                self.problem
                    .a
                    .push(row.iter().zip(other).map(|(a, b)| a * b).sum());
            }
            let free: f64 = row.iter().zip(&self.free).map(|(a, b)| a * b).sum();
            match rows {
                Rows::Impact => self.problem.b[r] = self.speeds[r],
                _ => self.problem.b[r] += free,
            }
        }
    }
}

/// The unit vector along which a contact slips in an axis.
pub(super) fn slide(touch: &Touch, axis: usize, width: usize, grip: Grip) -> Vec3 {
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
            // Past the instant of rest friction goes on as it was, so that the instant can be
            // located.
            let ahead = match grip {
                Grip::Along(d) => touch.speeds.y * d[0] + touch.speeds.z * d[1],
                _ => speed,
            };
            (touch.along * touch.speeds.y + touch.across * touch.speeds.z) / speed.copysign(ahead)
        }
    }
}

/// What holds a joint at a stop with dry friction.
pub(super) fn at_stop(stop: Stop, dry: f64) -> Bounds {
    match stop {
        Stop::Low => Bounds::Between(-dry, f64::INFINITY),
        Stop::High => Bounds::Between(f64::NEG_INFINITY, dry),
        Stop::Between => Bounds::Between(-dry, dry),
    }
}
