//! How large what matters in a joint is, by what hangs on it.

use crate::mechanism::{Inertia, Mechanism};

/// Sizes of each joint.
#[derive(Clone, Debug)]
pub(super) struct Sizes {
    /// Torque or force (N m or N): what weight does to it at most, or its drive.
    pub(super) torque: Vec<f64>,
    /// Inertia (kg m² or kg) of what hangs on it, stretched.
    pub(super) inertia: Vec<f64>,
    /// Greatest magnitude of each drive.
    pub(super) driven: Vec<f64>,
}

/// Least lever (m) of a weight that matters.
const LEAST_LEVER: f64 = 0.01;
/// A tenth of what drives a joint is much to it.
const OF_DRIVE: f64 = 0.1;

impl Sizes {
    /// Those of a mechanism whose drives reach `driven`.
    pub(super) fn of(mechanism: &Mechanism, driven: &[f64]) -> Sizes {
        let mut sizes = Sizes {
            torque: Vec::new(),
            inertia: Vec::new(),
            driven: driven.to_vec(),
        };
        for (j, link) in mechanism.links.iter().enumerate() {
            let (mut moment, mut inertia) = (0.0, 0.0);
            for (k, outer) in mechanism.links.iter().enumerate() {
                if !mechanism.carries(j, k) {
                    continue;
                }
                let own = if let Inertia::Center(own) = outer.inertia {
                    own
                } else {
                    0.0
                };
                let carried = outer.counterweight.as_ref();
                let carried = carried.map_or((0.0, 0.0), |c| (c.mass, length(c.at)));
                for (mass, reach, own) in [
                    (outer.mass, length(outer.center), own),
                    (carried.0, carried.1, 0.0),
                ] {
                    let lever = (along(mechanism, j, k) + reach).max(LEAST_LEVER);
                    let [lever, own] = if link.joint.turns() {
                        [lever, own]
                    } else {
                        [1.0, 0.0]
                    };
                    moment += mass * lever;
                    inertia += mass * lever * lever + own;
                }
            }
            let drives = mechanism.drives.iter().zip(driven);
            let drive: f64 = drives.filter(|(d, _)| d.joint == j).map(|(_, x)| x).sum();
            let torque = (mechanism.gravity * moment).max(OF_DRIVE * drive);
            sizes.torque.push(torque.max(1e-6));
            sizes.inertia.push(inertia.max(1e-9));
        }
        sizes
    }

    /// Rate (rad/s or 1/s) at which a joint moves by itself.
    pub(super) fn rate(&self, joint: usize) -> f64 {
        (self.torque[joint] / self.inertia[joint]).sqrt()
    }
}

/// How far (m) the joint of link `outer` is from that of `joint`, stretched.
fn along(mechanism: &Mechanism, joint: usize, outer: usize) -> f64 {
    let between = mechanism.to_ground(outer).take_while(|k| *k != joint);
    between.map(|k| length(mechanism.links[k].joint.at)).sum()
}

fn length([x, y]: [f64; 2]) -> f64 {
    x.hypot(y)
}
