//! A machine in a plane, as fast as fits need it: a chain of bodies with what is in its joints and
//! what stands on the ground.
//!
//! Steps are fixed: forces in the middle of a step, dampers at its end, and dry friction as an
//! impulse that takes what is left of a joint's rate and no more.

use nalgebra::{DMatrix, DVector};
use saltus_sim_check::chain::{Chain, MOST, Moving};

/// What is in the joint of a coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Part {
    /// A spring that pulls back from `from` (rad) on, as far as `side` times the coordinate is
    /// beyond it (N m/rad).
    pub(crate) spring: f64,
    pub(crate) from: f64,
    pub(crate) side: f64,
    /// Damping (N m s/rad).
    pub(crate) damping: f64,
    /// Dry friction (N m).
    pub(crate) friction: f64,
}

/// A point that may stand on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Point {
    pub(crate) body: usize,
    /// Where it is in the body's frame (m).
    pub(crate) inner: [f64; 2],
    /// Height of the ground under it (m).
    pub(crate) ground: f64,
    /// Stiffness (N/m) and damping (N s/m) of the ground.
    pub(crate) stiffness: f64,
    pub(crate) damping: f64,
    /// Friction coefficient.
    pub(crate) friction: f64,
}

/// A machine.
#[derive(Clone, Debug)]
pub(crate) struct Machine {
    pub(crate) chain: Chain,
    pub(crate) parts: Vec<Part>,
    pub(crate) points: Vec<Point>,
}

/// A machine in motion.
#[derive(Clone, Debug)]
pub(crate) struct State {
    pub(crate) q: [f64; MOST],
    pub(crate) v: [f64; MOST],
    /// Accelerations of the step before.
    a: [f64; MOST],
    /// Where each point's friction holds it (m); none: in the air.
    anchors: Vec<Option<f64>>,
    moving: Moving,
}

impl State {
    /// At these coordinates and rates.
    pub(crate) fn new(machine: &Machine, q: &[f64], v: &[f64]) -> State {
        let mut all = [[0.0; MOST]; 2];
        all[0][..q.len()].copy_from_slice(q);
        all[1][..v.len()].copy_from_slice(v);
        State {
            q: all[0],
            v: all[1],
            a: [0.0; MOST],
            anchors: vec![None; machine.points.len()],
            moving: Moving::default(),
        }
    }

    /// A coordinate after `h` (s), as far as the present rates tell.
    pub(crate) fn ahead(&self, coordinate: usize, h: f64) -> f64 {
        self.q[coordinate] + h * (self.v[coordinate] + 0.5 * h * self.a[coordinate])
    }
}

impl Machine {
    /// Goes on by `h` (s) with a torque (N m) on each coordinate; false where it cannot.
    pub(crate) fn step(&self, state: &mut State, h: f64, torques: &[f64]) -> bool {
        let n = self.chain.len();
        let (mut q, mut v) = ([0.0; MOST], [0.0; MOST]);
        for i in 0..n {
            q[i] = state.ahead(i, 0.5 * h);
            v[i] = state.v[i] + 0.5 * h * state.a[i];
        }
        let moving = &mut state.moving;
        self.chain.put(&q[..n], &v[..n], moving);
        for (i, part) in self.parts.iter().enumerate() {
            let beyond = (part.side * q[i] - part.from).max(0.0);
            let force = torques[i] - part.side * part.spring * beyond - part.damping * state.v[i];
            self.chain.drive(moving, i, force);
            self.chain.burden(moving, i, 0.5 * h * part.damping);
        }
        for (point, anchor) in self.points.iter().zip(&mut state.anchors) {
            stand(&self.chain, moving, (point, anchor), (h, &state.a[..n]));
        }
        if !self.chain.factor(moving) {
            return false;
        }
        let mut after = self.chain.accelerations(moving);
        for i in 0..n {
            after[i] = state.v[i] + h * after[i];
        }
        self.rub(moving, &mut after, h);
        for i in 0..n {
            state.q[i] += 0.5 * h * (state.v[i] + after[i]);
            state.a[i] = (after[i] - state.v[i]) / h;
            state.v[i] = after[i];
        }
        after[..n].iter().all(|x| x.is_finite())
    }

    /// Takes dry friction's impulses from the rates `v` at the end of a step.
    fn rub(&self, moving: &Moving, v: &mut [f64; MOST], h: f64) {
        /// Rounds over all joints, each of which takes what the others left.
        const ROUNDS: usize = 20;
        let n = self.chain.len();
        // What a unit impulse in each joint that rubs does to all rates.
        let (mut dry, mut columns, mut count) = ([0; MOST], [[0.0; MOST]; MOST], 0);
        for i in (0..n).filter(|i| self.parts[*i].friction > 0.0) {
            dry[count] = i;
            columns[count][i] = 1.0;
            self.chain.solve(moving, &mut columns[count][..n]);
            count += 1;
        }
        let mut impulses = [0.0; MOST];
        for _ in 0..if count > 1 { ROUNDS } else { 1 } {
            let mut most: f64 = 0.0;
            for (k, &i) in dry.iter().enumerate().take(count) {
                let limit = h * self.parts[i].friction;
                let wanted: f64 = impulses[k] - v[i] / columns[k][i];
                let change = wanted.clamp(-limit, limit) - impulses[k];
                impulses[k] += change;
                for (x, c) in v.iter_mut().zip(&columns[k]).take(n) {
                    *x += change * c;
                }
                most = most.max(change.abs() / limit);
            }
            if most < 1e-9 {
                break;
            }
        }
    }

    /// The centre of mass (m) in the middle of the last step.
    pub(crate) fn center_of_step(&self, state: &State) -> [f64; 2] {
        self.chain.center(&state.moving)
    }

    /// The centre of mass (m).
    pub(crate) fn center(&self, state: &State) -> [f64; 2] {
        let mut moving = Moving::default();
        let n = self.chain.len();
        self.chain.put(&state.q[..n], &state.v[..n], &mut moving);
        self.chain.center(&moving)
    }

    /// Puts the ground under each point so that it carries its part of the weight at these
    /// coordinates, as far as forces there can hold all joints still.
    pub(crate) fn set_down(&mut self, q: &[f64]) {
        let n = self.chain.len();
        let mut moving = Moving::default();
        let still = vec![0.0; n];
        self.chain.put(q, &still, &mut moving);
        let forces = self.chain.forces(&moving);
        let pulls = DVector::from_fn(n, |i, _| -forces[i]);
        let columns: Vec<[f64; MOST]> = self
            .points
            .iter()
            .map(|point| {
                let mut alone = Moving::default();
                self.chain.put(q, &still, &mut alone);
                let [place, _] = self.chain.place(&alone, point.body, point.inner);
                self.chain.push(&mut alone, point.body, place, [0.0, 1.0]);
                let mut with = self.chain.forces(&alone);
                for (w, f) in with.iter_mut().zip(&forces) {
                    *w -= f;
                }
                with
            })
            .collect();
        let by = DMatrix::from_fn(n, self.points.len(), |i, k| columns[k][i]);
        let normal = by.transpose() * &by + DMatrix::identity(columns.len(), columns.len()) * 1e-9;
        let loads = normal
            .cholesky()
            .map(|c| c.solve(&(by.transpose() * pulls)));
        for (k, point) in self.points.iter_mut().enumerate() {
            let load = loads.as_ref().map_or(0.0, |loads| loads[k].max(0.0));
            let [place, _] = self.chain.place(&moving, point.body, point.inner);
            point.ground = place[1] + load / point.stiffness;
        }
    }
}

/// Adds what the ground does to a point in a step of `h` (s), whose middle was foreseen by the
/// accelerations `a`: implicitly, as light links on stiff ground are.
fn stand(
    chain: &Chain,
    moving: &mut Moving,
    (point, anchor): (&Point, &mut Option<f64>),
    (h, a): (f64, &[f64]),
) {
    let [place, speed] = chain.place(moving, point.body, point.inner);
    let depth = point.ground - place[1];
    let normal = point.stiffness * depth - point.damping * speed[1];
    if depth <= 0.0 || normal <= 0.0 {
        *anchor = None;
        return;
    }
    let weight = 0.5 * h * point.damping + 0.125 * h * h * point.stiffness;
    let at = (point.body, place);
    chain.brace(moving, at, [0.0, 1.0], weight, a);
    let limit = point.friction * normal;
    let held = anchor.get_or_insert(place[0]);
    let wanted = -point.stiffness * (place[0] - *held) - point.damping * speed[0];
    let along = wanted.clamp(-limit, limit);
    if along == wanted {
        chain.brace(moving, at, [1.0, 0.0], weight, a);
    } else {
        // It slips, and the spring that is left is the one that holds it now.
        *held = place[0] + (along + point.damping * speed[0]) / point.stiffness;
    }
    chain.push(moving, point.body, place, [along, normal]);
}
