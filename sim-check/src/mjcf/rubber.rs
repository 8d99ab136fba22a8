//! Feet of rubber in MuJoCo: a spring and a damper, written as its softest constraint.
//!
//! A constraint of MuJoCo pushes with f = (a_ref − a)/R, where a is how the contact accelerates, a_ref = −(s r + c v)/d for a
//! gap r and a speed v, and R = (1 − d)/d w for a mobility w that its compiler works out. At the least impedance d that it takes,
//! R is so great that a hardly counts. What is left is a spring and a damper, s = k (1 − d) w and c = C (1 − d) w. The cone of
//! friction stays stiff: its R is that of the normal over the model's `impratio`.

use crate::linear::{cholesky, forward};
use crate::rig::Rig;
use crate::spatial::Vec3;
use crate::tree::{Joint, Pose};
use crate::xml::{number, numbers};

/// Least impedance of a constraint.
///
/// Source: MuJoCo, mjMINIMP.
const SOFTEST: f64 = 1e-4;

/// How much stiffer than the normal friction is: its impedance is 0.9999, as that of other constraints.
pub(super) const FRICTION_STIFFER: f64 = 1e8;

/// How fast (1/s) friction takes a slip away, over one over the time step: twice that would ring.
const GRIP: f64 = 0.5;

/// The attributes, each after a space, of a pair of a foot and the ground for a spring of `stiffness` (N/m) and a damper of `damping` (N s/m), in time steps of
/// `step` (s); `mobility` (1/kg) is [`mobility`].
pub(super) fn pair((stiffness, damping): (f64, f64), mobility: f64, step: f64) -> String {
    let scale = -(1.0 - SOFTEST) * mobility;
    // Friction has no spring, so that the first number has no meaning; 0 would be taken for the usual form.
    let grip = -GRIP / step * SOFTEST;
    let normal = numbers(&[stiffness * scale, damping * scale]);
    let (friction, softest) = (numbers(&[grip, grip]), number(SOFTEST));
    format!(
        r#" solref="{normal}" solreffriction="{friction}" solimp="{softest} {softest} 0.001 0.5 2""#
    )
}

/// The mobility w (1/kg) of `body` as MuJoCo's compiler works it out: how much a force on its centre of mass moves that, the mean
/// of three axes, where all coordinates are 0 and attitudes the identity.
///
/// Source: MuJoCo, body_invweight0.
pub(super) fn mobility(rig: &Rig, body: usize) -> f64 {
    let tree = &rig.mechanism.tree;
    let (n, mut q) = (tree.velocities(), vec![0.0; tree.coordinates()]);
    for (i, part) in tree.bodies().iter().enumerate() {
        if part.joint == Joint::Free {
            q[tree.coordinate_of(i) + 3] = 1.0;
        }
    }
    let (mut pose, mut mass, mut bias) = (Pose::default(), vec![0.0; n * n], vec![0.0; n]);
    pose.set(tree, &q, &vec![0.0; n]);
    pose.equations(tree, &Vec3::zeros(), &mut mass, &mut bias);
    if !cholesky(&mut mass, n) {
        return 0.0;
    }
    let center = pose.frames[body].point(&tree.bodies()[body].center);
    let along = |axis: usize| {
        let mut row = vec![0.0; n];
        for k in tree.path(body) {
            row[k] = pose.axes[k].at(&center)[axis];
        }
        forward(&mass, n, &mut row);
        row.iter().map(|x| x * x).sum::<f64>()
    };
    (0..3).map(along).sum::<f64>() / 3.0
}
