//! Bodies that several tests use.
#![allow(dead_code, unreachable_pub, reason = "no test uses them all")]

use nalgebra::Matrix3;
use saltus_sim_check::{Body, Joint, JointParts, Mechanism, Placement, SimError, Tree, Vec3};

/// Acceleration of gravity (m/s²).
pub const G: f64 = 9.80665;

/// Gravity.
pub fn down() -> Vec3 {
    Vec3::new(0.0, 0.0, -G)
}

/// A body at `at` in its parent.
pub fn body(
    name: &str,
    parent: Option<usize>,
    joint: Joint,
    at: Vec3,
    mass: f64,
    center: Vec3,
    inertia: Matrix3<f64>,
) -> Body {
    Body {
        name: name.into(),
        parent,
        joint,
        placement: Placement::at(at),
        mass,
        center,
        inertia,
    }
}

/// Moments of inertia about three axes.
pub fn diagonal(x: f64, y: f64, z: f64) -> Matrix3<f64> {
    Matrix3::from_diagonal(&Vec3::new(x, y, z))
}

/// A free body with `legs` more bodies on springs, so that something moves inside.
pub fn free_body(legs: usize) -> Result<Mechanism, SimError> {
    let mut tree = Tree::default();
    let hub = tree.add(body(
        "hub",
        None,
        Joint::Free,
        Vec3::zeros(),
        2.5,
        Vec3::new(0.01, -0.02, 0.03),
        diagonal(0.05, 0.06, 0.08),
    ))?;
    for k in 0..legs {
        // Directions spread over a sphere by the golden angle.
        let z = 1.0 - 2.0 * (k as f64 + 0.5) / legs as f64;
        let turn = 2.399_963_229_728_653 * k as f64;
        let way = Vec3::new(
            (1.0 - z * z).sqrt() * turn.cos(),
            (1.0 - z * z).sqrt() * turn.sin(),
            z,
        );
        tree.add(body(
            &format!("leg {k}"),
            Some(hub),
            Joint::Prismatic(way),
            way * 0.2,
            0.05,
            Vec3::zeros(),
            diagonal(1e-5, 1e-5, 1e-5),
        ))?;
    }
    let mut mechanism = Mechanism::new(tree, down());
    for parts in &mut mechanism.joints[1..] {
        *parts = JointParts {
            spring: (80.0, 0.0),
            ..JointParts::default()
        };
    }
    Ok(mechanism)
}

/// A start of [`free_body`]: thrown up, spinning, every leg moving.
pub fn spinning(legs: usize) -> (Vec<f64>, Vec<f64>) {
    let mut q = vec![0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0];
    q.resize(7 + legs, 0.01);
    let mut v = vec![0.3, -0.2, 4.0, 3.0, 7.0, -2.0];
    v.resize(6 + legs, 0.1);
    (q, v)
}
