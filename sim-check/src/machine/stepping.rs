//! A step of fixed length: the laws of contact and dry friction for the velocities at its end and
//! the impulses during it.
//!
//! Moreau–Jean time stepping, with everything evaluated in the middle of the step: w = J v⁺ + ½ h
//! J̇ v is the speed along a row at the end, as J is that of the middle. Dampers and springs act on
//! the mean of both ends, so that they may be as stiff as they like.
//!
//! Source: Jean & Moreau, Unilaterality and dry friction in the dynamics of rigid body collections
//! (1992); Acary & Brogliato, Numerical Methods for Nonsmooth Dynamical Systems (2008), chapter 10.

use super::rows::at_stop;
use super::{CONTACT_LOSS, JOINT_LOSS, Machine, Owner, STANDING, Touch};
use crate::complementarity::{Bounds, Element, Grip};
use crate::contact::Friction;
use crate::linear::{backward, cholesky, forward};
use crate::mode::{JointMode, Mode, Stop};
use crate::spatial::Vec3;

/// Part of a row's own mobility by which it gives way.
const SHARING: f64 = 1e-9;
/// The same of friction in a cone: three feet that squeeze the ground between them are not held by round-off. A foot that
/// is pushed by 100 N creeps by 10 nm/s.
const CREEPING: f64 = 1e-8;
/// Ways out of the ground (m or rad) so many times the greatest penetration (m) are none.
const FAR: f64 = 100.0;
/// Square of the angle (rad) by which a foot on compliant ground swings in a step that resolves it.
const RESOLVED: f64 = 0.1;

impl Machine<'_> {
    /// The problem of a step of `h` (s) that starts at the velocities of `start`; `middle` is the
    /// state half way, and `acceleration` the one that led there (all velocities). With `folds`,
    /// joints at rest are taken to stay so: [`stay`](Self::stay) says whether they do.
    pub(crate) fn assemble_step(
        &mut self,
        start: &[f64],
        (middle, acceleration): (&[f64], &[f64]),
        mode: &Mode,
        h: f64,
        folds: bool,
    ) {
        self.start.clear();
        let v = self.layout.v(start);
        self.start
            .extend(self.welded.velocities.iter().map(|&full| v[full]));
        self.apply_all(middle, mode);
        self.soften(acceleration, h);
        self.fold(mode, folds);
        self.sound = cholesky(&mut self.mass, self.welded.tree.velocities());
        self.touch(mode);
        self.clear_rows();
        for i in 0..self.touches.len() {
            let touch = self.touches[i];
            self.contact_step_rows(&touch, mode);
        }
        self.fold_rows();
        self.joint_step_rows(mode, h);
        self.couple_step(h);
    }

    /// Takes joints at rest out of the equations, if `folds`: most legs of a running robot are home.
    fn fold(&mut self, mode: &Mode, folds: bool) {
        let n = self.n();
        self.folded.joints.clear();
        self.folded.mass.clear();
        self.folded.pulls.clear();
        if !folds {
            return;
        }
        for body in 0..self.dof.len() {
            let (Some(k), JointMode::Held(_)) = (self.dof[body], mode.joints[body]) else {
                continue;
            };
            if self.start[k].abs() > STANDING {
                continue;
            }
            self.folded.joints.push((body, k));
            self.folded.mass.extend(&self.mass[k * n..(k + 1) * n]);
            self.folded.pulls.push(std::mem::take(&mut self.free[k]));
        }
        for &(_, k) in &self.folded.joints {
            for l in 0..n {
                self.mass[k * n + l] = 0.0;
                self.mass[l * n + k] = 0.0;
            }
            self.mass[k * n + k] = 1.0;
        }
    }

    /// Takes joints at rest out of the contacts' rows.
    fn fold_rows(&mut self) {
        let n = self.n();
        self.folded.jacobian.clear();
        for &(_, k) in &self.folded.joints {
            for r in 0..self.problem.rows {
                let entry = std::mem::take(&mut self.jacobian[r * n + k]);
                self.folded.jacobian.push(entry);
            }
        }
    }

    /// Whether the joints that the step of `h` has left out stay at rest: what holds each is within
    /// its bounds.
    pub(crate) fn stay(&self, mode: &Mode, h: f64) -> bool {
        let n = self.n();
        let rows = self.folded.jacobian.len() / self.folded.joints.len().max(1);
        self.folded
            .joints
            .iter()
            .enumerate()
            .all(|(i, &(body, _))| {
                let JointMode::Held(stop) = mode.joints[body] else {
                    return false;
                };
                let product =
                    |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
                let carried = product(&self.folded.mass[i * n..(i + 1) * n], &self.change);
                let entries = &self.folded.jacobian[i * rows..(i + 1) * rows];
                let pushed = product(entries, &self.problem.force);
                let hold = carried - h * self.folded.pulls[i] - pushed;
                let dry = self.dry_friction(body) * h;
                match stop {
                    Stop::Low => hold >= -dry,
                    Stop::High => hold <= dry,
                    Stop::Between => hold.abs() <= dry,
                }
            })
    }

    /// Makes springs and dampers act on the mean of both ends of the step: forces k (h²/8 v̇ − h/4
    /// Δv) and c (h/2 v̇ − Δv/2).
    fn soften(&mut self, acceleration: &[f64], h: f64) {
        let n = self.n();
        for (k, &full) in self.welded.velocities.iter().enumerate() {
            let (stiffness, damping) = (self.stiffness[k], self.damping[k]);
            self.free[k] += (0.125 * h * h * stiffness + 0.5 * h * damping) * acceleration[full];
            self.mass[k * n + k] += 0.25 * h * h * stiffness + 0.5 * h * damping;
        }
    }

    fn contact_step_rows(&mut self, touch: &Touch, mode: &Mode) {
        let c = touch.contact;
        let (body, bias, normal) = self.normal_row(touch);
        for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
            if standing == 0.0 {
                continue;
            }
            let grip = mode.contacts[c].grips[axis];
            let limit = if grip == Grip::Held {
                standing
            } else {
                slipping
            };
            let row = self.problem.rows;
            self.tangent_rows(touch, axis, width, body, &bias);
            let bounds = Bounds::Friction {
                normal: Some(normal),
                limit,
                rows: width,
            };
            self.problem.elements.push(Element { row, bounds, grip });
        }
    }

    fn joint_step_rows(&mut self, mode: &Mode, h: f64) {
        for body in 0..self.dof.len() {
            let (Some(k), JointMode::Held(stop)) = (self.dof[body], mode.joints[body]) else {
                continue;
            };
            if self.folded.joints.iter().any(|joint| joint.0 == body) {
                continue;
            }
            let dry = self.dry_friction(body) * h;
            self.push_joint_row(body, k, at_stop(stop, dry));
        }
    }

    /// A = J M⁻¹ Jᵀ, and b: the speeds at the end without impulses. A compliant contact gives way
    /// by its force.
    fn couple_step(&mut self, h: f64) {
        let (n, m) = (self.n(), self.problem.rows);
        forward(&self.mass, n, &mut self.free);
        self.reduced.clear();
        self.reduced.extend_from_slice(&self.jacobian);
        for r in 0..m {
            forward(&self.mass, n, &mut self.reduced[r * n..(r + 1) * n]);
        }
        self.problem.a.clear();
        self.problem.a.resize(m * m, 0.0);
        let in_cones = matches!(self.mechanism.material.friction, Friction::Cone { .. });
        for r in 0..m {
            let row = &self.reduced[r * n..(r + 1) * n];
            for c in 0..=r {
                let other = &self.reduced[c * n..(c + 1) * n];
                let dot: f64 = row.iter().zip(other).map(|(a, b)| a * b).sum();
                self.problem.a[r * m + c] = dot;
                self.problem.a[c * m + r] = dot;
            }
            // Rows that say the same, as two feet and two legs that hold do, would else share their
            // impulse by round-off.
            let sharing = match self.owners[r] {
                Owner::Tangent(..) if in_cones => CREEPING,
                _ => SHARING,
            };
            self.problem.a[r * m + r] *= 1.0 + sharing;
            let free: f64 = row.iter().zip(&self.free).map(|(a, b)| a * b).sum();
            let jacobian = &self.jacobian[r * n..(r + 1) * n];
            let before: f64 = jacobian.iter().zip(&self.start).map(|(a, b)| a * b).sum();
            self.problem.b[r] = before + h * free + 0.5 * h * self.problem.b[r];
            self.speeds[r] = before;
        }
        let Some((stiffness, damping)) = self.mechanism.material.compliance else {
            return;
        };
        for r in 0..m {
            if let Owner::Normal(c) = self.owners[r]
                && let Some(touch) = self.touches.iter().find(|t| t.contact == c)
            {
                let gap = touch.gap - 0.5 * h * touch.speeds.x;
                let before = self.speeds[r];
                // Where the step resolves the bounce, the mean of both ends; else the end, which
                // does not ring.
                let is_resolved = h * h * stiffness * self.problem.a[r * m + r] < RESOLVED;
                let (give, speed) = if is_resolved {
                    (0.25 * h * h * stiffness + 0.5 * h * damping, before)
                } else {
                    (h * h * stiffness + h * damping, 0.0)
                };
                self.problem.a[r * m + r] += 1.0 / give;
                self.problem.b[r] += speed + h * stiffness * gap / give;
            }
        }
    }

    /// Changes of velocity (all velocities) over the step of `h` under the problem's impulses, as
    /// an acceleration.
    pub(crate) fn step_acceleration(&mut self, h: f64, acceleration: &mut [f64]) {
        let n = self.n();
        self.change.clear();
        self.change.extend(self.free.iter().map(|x| x * h));
        for r in 0..self.problem.rows {
            let impulse = self.problem.force[r];
            for k in 0..n {
                self.change[k] += impulse * self.reduced[r * n + k];
            }
        }
        backward(&self.mass, n, &mut self.change);
        acceleration.fill(0.0);
        let inverse = 1.0 / h;
        for (k, &full) in self.welded.velocities.iter().enumerate() {
            acceleration[full] = self.change[k] * inverse;
        }
    }

    /// Adds the step's works to `works`.
    pub(crate) fn step_works(&self, h: f64, works: &mut [f64]) {
        for (work, power) in works.iter_mut().zip(&self.powers) {
            *work += h * power;
        }
        let n = self.n();
        for r in 0..self.problem.rows {
            let jacobian = &self.jacobian[r * n..(r + 1) * n];
            let change: f64 = jacobian.iter().zip(&self.change).map(|(a, b)| a * b).sum();
            let speed = self.speeds[r] + 0.5 * change;
            let lost = -self.problem.force[r] * speed;
            match (self.owners[r], self.mechanism.material.compliance) {
                (Owner::Joint(body), _) => {
                    works[JOINT_LOSS] += lost;
                    let account = self.leg_of[body].and_then(|leg| self.layout.account(leg));
                    if let Some(at) = account {
                        works[at + 1] += lost;
                    }
                }
                (Owner::Normal(c), Some((stiffness, _))) => {
                    // The spring keeps its part, as long as it touches.
                    let touch = self.touches.iter().find(|touch| touch.contact == c);
                    let before = touch.map_or(0.0, |t| t.gap - 0.5 * h * t.speeds.x);
                    let depths = [before, before + h * speed].map(|gap| gap.min(0.0));
                    let kept = 0.5 * stiffness * (depths[1] * depths[1] - depths[0] * depths[0]);
                    works[CONTACT_LOSS] += lost - kept;
                }
                _ => works[CONTACT_LOSS] += lost,
            }
        }
    }

    /// Adds the ground's impulses (N s, world axes) of the step to `impulses`, each with its point.
    pub(crate) fn tell_impulses(&self, impulses: &mut Vec<(usize, Vec3)>) {
        for touch in &self.touches {
            let c = touch.contact;
            let mut impulse = touch.normal * self.normal_force(c);
            for axis in 0..2 {
                let parts = self.force_of(Owner::Tangent(c, axis));
                for (part, direction) in parts.iter().zip(&[touch.along, touch.across][axis..]) {
                    impulse += direction * *part;
                }
            }
            let point = self.pairs[c].0;
            match impulses.iter_mut().find(|(of, _)| *of == point) {
                Some((_, sum)) => *sum += impulse,
                None => impulses.push((point, impulse)),
            }
        }
    }

    /// Elements that slip or slide.
    fn moving_elements(&self) -> impl Iterator<Item = usize> {
        let elements = self.problem.elements.iter().enumerate();
        elements
            .filter(|(_, e)| e.grip != Grip::Held)
            .map(|(i, _)| i)
    }

    /// Takes away what an element can hold by.
    fn free_element(&mut self, i: usize) {
        let e = &mut self.problem.elements[i];
        e.grip = Grip::High;
        match &mut e.bounds {
            Bounds::Between(low, high) => (*low, *high) = (0.0, 0.0),
            Bounds::Friction { normal, limit, .. } => (*normal, *limit) = (None, 0.0),
        }
    }

    /// Corrects the positions of `y`, at the end of the step, by what the rigid contacts that hold
    /// were off by in its middle, where that is more than `slack` (m). The problem is used up.
    pub(crate) fn correct_step(&mut self, y: &mut [f64], slack: f64) {
        let lets_go = self
            .problem
            .elements
            .iter()
            .any(|e| matches!(self.owners[e.row], Owner::Normal(_)) && e.grip != Grip::Held);
        let is_near = self.touches.iter().all(|t| t.gap.abs() <= slack);
        if self.mechanism.material.compliance.is_some() || is_near || lets_go {
            return;
        }
        let moving: Vec<usize> = self.moving_elements().collect();
        self.hold_rows();
        let mut far = self.seek_way_out();
        if far > FAR {
            // With feet and legs held that slip and slide, there can be no way out but a far one.
            for i in moving {
                self.free_element(i);
            }
            far = self.seek_way_out();
        }
        // What is jammed stays where it is.
        if far <= FAR {
            self.take_way_out(y);
        }
    }
}
