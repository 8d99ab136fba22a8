//! What the solved rows do: accelerations, impulses, and corrections of what integration has put
//! where nothing moves.

use super::{CONTACT_LOSS, Machine, Owner};
use crate::complementarity::Grip;
use crate::linear::backward;
use crate::mode::{JointMode, Mode, Stop};

impl Machine<'_> {
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
    pub(super) fn account(&mut self, mode: &Mode) {
        for touch in &self.touches {
            let normal = touch
                .spring
                .map_or_else(|| self.normal_force(touch.contact), |f| f.max(0.0));
            for (axis, (standing, slipping, width)) in self.friction().into_iter().enumerate() {
                let grip = mode.contacts[touch.contact].grips[axis];
                if standing > 0.0 && grip != Grip::Held {
                    self.powers[CONTACT_LOSS] += slipping * normal * touch.slip(axis, width);
                }
            }
        }
    }

    /// The force (N) along the normal of contact `c`, 0 where it has none.
    pub(crate) fn normal_force(&self, c: usize) -> f64 {
        self.first_force_of(Owner::Normal(c))
    }

    /// The force of the first row of `owner`, 0 where it has none.
    pub(crate) fn first_force_of(&self, owner: Owner) -> f64 {
        self.force_of(owner).first().copied().unwrap_or(0.0)
    }

    /// The forces of the rows of `owner`.
    pub(crate) fn force_of(&self, owner: Owner) -> &[f64] {
        let first = self.owners.iter().position(|o| *o == owner);
        first.map_or(&[], |i| {
            let count = self.owners[i..].iter().take_while(|o| **o == owner).count();
            &self.problem.force[i..i + count]
        })
    }

    /// Sets `change` to what the problem's impulses change the velocities by.
    fn change_by_impulses(&mut self) {
        let n = self.n();
        self.change.clear();
        self.change.resize(n, 0.0);
        for r in 0..self.problem.rows {
            for k in 0..n {
                self.change[k] += self.problem.force[r] * self.reduced[r * n + k];
            }
        }
        backward(&self.mass, n, &mut self.change);
    }

    /// Adds the velocity jumps that the problem's impulses make to `y`.
    pub(crate) fn jump(&mut self, y: &mut [f64]) {
        self.change_by_impulses();
        for (k, &full) in self.welded.velocities.iter().enumerate() {
            y[self.layout.coordinates + full] += self.change[k];
        }
    }

    /// Takes out of `y` what integration has put into the directions that do not move: speeds along
    /// the held rows, and penetration of the rigid contacts.
    pub(crate) fn project(&mut self, y: &mut [f64], mode: &Mode) {
        if self.problem.rows == 0 {
            return;
        }
        self.hold_rows();
        self.problem.b.clone_from(&self.speeds);
        self.problem.solve();
        self.jump(y);
        self.seek_way_out();
        self.take_way_out(y);
        for (body, joint) in mode.joints.iter().enumerate() {
            if let (JointMode::Held(stop), Some(_)) = (joint, self.dof[body]) {
                self.put_at_stop(y, body, *stop);
            }
        }
    }

    /// Makes the problem that of moving by least kinetic energy, along M⁻¹ Jᵀ, with every row held.
    pub(super) fn hold_rows(&mut self) {
        for e in &mut self.problem.elements {
            e.grip = Grip::Held;
        }
        let (n, m) = (self.n(), self.problem.rows);
        self.problem.a.clear();
        for r in 0..m {
            for c in 0..m {
                let dot = (0..n)
                    .map(|k| self.reduced[r * n + k] * self.reduced[c * n + k])
                    .sum();
                self.problem.a.push(dot);
            }
        }
    }

    /// Seeks what moves the rigid contacts out of their penetration, and says how many times the greatest of these
    /// (m) the greatest coordinate (m or rad) moves.
    pub(super) fn seek_way_out(&mut self) -> f64 {
        for (r, owner) in self.owners.iter().enumerate() {
            self.problem.b[r] = match owner {
                Owner::Normal(c) => self
                    .touches
                    .iter()
                    .find(|t| t.contact == *c)
                    .map_or(0.0, |t| t.gap),
                _ => 0.0,
            };
        }
        self.problem.solve();
        self.change_by_impulses();
        let greatest = |of: &[f64]| of.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        greatest(&self.change) / greatest(&self.problem.b).max(f64::MIN_POSITIVE)
    }

    /// Moves `y` by the way out that was sought.
    pub(super) fn take_way_out(&mut self, y: &mut [f64]) {
        self.welded
            .tree
            .coordinate_rates(&self.q, &self.change, &mut self.rates);
        for (i, &full) in self.welded.coordinates.iter().enumerate() {
            y[full] += self.rates[i];
        }
    }

    /// Puts the joint of `body` to rest where it is held.
    pub(crate) fn put_at_stop(&self, y: &mut [f64], body: usize, stop: Stop) {
        y[self.layout.coordinates + self.mechanism.tree.velocity_of(body)] = 0.0;
        let (low, high) = self.stops[body];
        let x = &mut y[self.mechanism.tree.coordinate_of(body)];
        match stop {
            Stop::Low => *x = low,
            Stop::High => *x = high,
            Stop::Between => {}
        }
    }
}
