//! What can touch what: points and small spheres of the robot, and the ground, slopes, boxes and
//! steps.

use crate::SimError;
use crate::error::{ensure, finite, not_negative, positive, require};
use crate::spatial::Vec3;
use nalgebra::Rotation3;
use saltus_numeric::root::bisect;

/// A point or a sphere of a body, which can touch surfaces.
#[derive(Clone, Debug)]
pub struct ContactPoint {
    /// What it is called.
    pub name: String,
    /// Index of its body.
    pub body: usize,
    /// Its centre (m), body frame.
    pub center: Vec3,
    /// Radius of the sphere (m), ≥ 0; 0 is a point.
    pub radius: f64,
    /// The other end (m), body frame, of a bar with round ends; none: a sphere. Bars touch blocks
    /// alone.
    pub bar: Option<Vec3>,
}

/// Something that stands still and can be touched.
#[derive(Clone, Debug)]
pub enum Surface {
    /// All that is below a plane: the ground, or a slope.
    Plane {
        /// A point of it (m).
        point: Vec3,
        /// Unit vector out of it.
        normal: Vec3,
    },
    /// A block with faces along the world's axes: an obstacle, or a step.
    Block {
        /// Least x, y, z (m).
        low: Vec3,
        /// Greatest x, y, z (m).
        high: Vec3,
    },
    /// A block that is turned about the vertical through a place, as one that lies across the way
    /// of a robot on a boom: x along its travel and y away from that place.
    TurnedBlock {
        /// Least x, y, z (m) before it is turned, from that place.
        low: Vec3,
        /// Greatest x, y, z (m).
        high: Vec3,
        /// The place (m).
        about: Vec3,
        /// By how much (rad): from y towards x.
        turn: f64,
    },
}

/// How a sphere's centre lies to a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Proximity {
    /// Distance from the surface (m), negative inside.
    pub distance: f64,
    /// Unit vector out of the surface.
    pub normal: Vec3,
    /// The part of the centre's velocity that turns the normal, over the distance: 0 on a face.
    turning: [Vec3; 2],
}

impl Proximity {
    /// How fast the normal turns (1/s) where the centre moves at `velocity` (m/s).
    pub(crate) fn normal_rate(&self, velocity: &Vec3) -> Vec3 {
        self.turning
            .iter()
            .map(|axis| axis * axis.dot(velocity))
            .sum::<Vec3>()
            / self.distance.max(1e-9)
    }
}

impl Surface {
    /// Flat ground at height 0 (m), or a slope through the origin that rises by `slope` (rad) along
    /// x.
    pub fn ground(slope: f64) -> Surface {
        Surface::Plane {
            point: Vec3::zeros(),
            normal: Vec3::new(-slope.sin(), 0.0, slope.cos()),
        }
    }

    /// What messages call it.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Surface::Plane { .. } => "the ground",
            Surface::Block { .. } | Surface::TurnedBlock { .. } => "a block",
        }
    }

    pub(crate) fn check(&self) -> Result<(), SimError> {
        match self {
            Surface::Plane { point, normal } => {
                finite("plane's point (m)", point.as_slice())?;
                let length = normal.norm();
                let is_unit = (length - 1.0).abs() < 1e-9;
                require(is_unit, "plane normal's length", length, "1")
            }
            Surface::Block { low, high } => positive("block's least side (m)", (high - low).min()),
            Surface::TurnedBlock {
                low,
                high,
                about,
                turn,
            } => {
                finite("place about which a block is turned (m)", about.as_slice())?;
                finite("turn of a block (rad)", &[*turn])?;
                positive("block's least side (m)", (high - low).min())
            }
        }
    }

    /// How `center` (m) lies to this surface.
    pub(crate) fn proximity(&self, center: &Vec3) -> Proximity {
        match self {
            Surface::Plane { point, normal } => Proximity {
                distance: normal.dot(&(center - point)),
                normal: *normal,
                turning: [Vec3::zeros(); 2],
            },
            Surface::Block { low, high } => block_proximity(low, high, center),
            Surface::TurnedBlock {
                low,
                high,
                about,
                turn,
            } => {
                let turned = Rotation3::from_axis_angle(&Vec3::z_axis(), -turn);
                let inside = turned.inverse() * (center - about);
                let near = block_proximity(low, high, &inside);
                Proximity {
                    distance: near.distance,
                    normal: turned * near.normal,
                    turning: near.turning.map(|axis| turned * axis),
                }
            }
        }
    }

    /// Whether bars touch it.
    pub(crate) fn meets_bars(&self) -> bool {
        !matches!(self, Surface::Plane { .. })
    }

    /// How far along the bar from `a` to `b` (m) it is nearest to this surface, from 0 to 1: the
    /// distance from what is convex is convex along a line.
    pub(crate) fn nearest_on_bar(&self, a: &Vec3, b: &Vec3) -> f64 {
        let along = b - a;
        let rises = |part: f64| self.proximity(&(a + along * part)).normal.dot(&along) > 0.0;
        if rises(0.0) {
            return 0.0;
        }
        if !rises(1.0) {
            return 1.0;
        }
        bisect(0.0, 1.0, 50, |part| !rises(part)).0
    }
}

fn block_proximity(low: &Vec3, high: &Vec3, center: &Vec3) -> Proximity {
    let nearest = center.sup(low).inf(high);
    let away = center - nearest;
    let distance = away.norm();
    if distance == 0.0 {
        // Inside: out through the nearest face.
        let mut best = Proximity {
            distance: f64::NEG_INFINITY,
            normal: Vec3::zeros(),
            turning: [Vec3::zeros(); 2],
        };
        for k in 0..3 {
            for (depth, sign) in [(low[k] - center[k], -1.0), (center[k] - high[k], 1.0)] {
                if depth > best.distance {
                    best.distance = depth;
                    best.normal = Vec3::zeros();
                    best.normal[k] = sign;
                }
            }
        }
        return best;
    }
    let normal = away / distance;
    // The directions in which the nearest point of the block stays where it is.
    let fixed = |k: usize| away[k] != 0.0;
    let mut turning = [Vec3::zeros(); 2];
    match (0..3).filter(|&k| fixed(k)).count() {
        2 => {
            let free = (0..3).find(|&k| !fixed(k)).unwrap_or(0);
            let mut edge = Vec3::zeros();
            edge[free] = 1.0;
            turning[0] = edge.cross(&normal);
        }
        3 => {
            let (a, b) = across(&normal);
            turning = [a, b];
        }
        _ => {}
    }
    Proximity {
        distance,
        normal,
        turning,
    }
}

/// Two unit vectors across `normal` and each other.
pub(crate) fn across(normal: &Vec3) -> (Vec3, Vec3) {
    let axis = if normal.x.abs() < 0.6 {
        Vec3::x()
    } else {
        Vec3::y()
    };
    let first = (axis - normal * normal.dot(&axis)).normalize();
    (first, normal.cross(&first))
}

/// Which way the robot travels: along it and across it, friction may differ.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Travel {
    /// Along x.
    Straight,
    /// Around the vertical through this point (m).
    Around(Vec3),
}

impl Travel {
    /// Unit vectors along and across the travel, both along a surface with this `normal` at `point`
    /// (m).
    pub(crate) fn directions(&self, point: &Vec3, normal: &Vec3) -> (Vec3, Vec3) {
        let ahead = match self {
            Travel::Straight => Vec3::x(),
            Travel::Around(base) => {
                let from = point - base;
                Vec3::new(-from.y, from.x, 0.0)
            }
        };
        let along = ahead - normal * normal.dot(&ahead);
        let length = along.norm();
        // Where a surface faces the travel, there is no along.
        if length > 1e-9 * ahead.norm() && length > 0.0 {
            let along = along / length;
            (along, normal.cross(&along))
        } else {
            across(normal)
        }
    }
}

impl Travel {
    /// How fast (1/s) the directions along and across the travel turn at `place` (m) on a surface of
    /// this `normal`, where the place of contact moves on at `moving` (m/s) and the normal turns at
    /// `turning` (1/s).
    pub(crate) fn direction_rates(
        &self,
        (place, normal): (&Vec3, &Vec3),
        moving: &Vec3,
        turning: &Vec3,
    ) -> [Vec3; 2] {
        let Travel::Around(base) = self else {
            return [Vec3::zeros(); 2];
        };
        let from = place - base;
        let (ahead, rate) = (
            Vec3::new(-from.y, from.x, 0.0),
            Vec3::new(-moving.y, moving.x, 0.0),
        );
        let flat = ahead - normal * normal.dot(&ahead);
        let length = flat.norm();
        if length <= 1e-9 * ahead.norm() {
            return [Vec3::zeros(); 2];
        }
        let now = flat / length;
        let change = rate
            - turning * normal.dot(&ahead)
            - normal * (turning.dot(&ahead) + normal.dot(&rate));
        let along = (change - now * now.dot(&change)) / length;
        [along, turning.cross(&now) + normal.cross(&along)]
    }
}

/// Coulomb's law at the feet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// The same in every direction: the force is in a cone.
    Cone {
        /// Coefficient while the point stands, ≥ 0; infinite: it never slips.
        standing: f64,
        /// Coefficient while it slips, ≥ 0, ≤ `standing`.
        slipping: f64,
    },
    /// Along the travel and across it, each by itself.
    Axes {
        /// Along the travel: standing and slipping.
        along: (f64, f64),
        /// Across it: standing and slipping; 0 is none.
        across: (f64, f64),
    },
}

impl Friction {
    pub(crate) fn check(&self) -> Result<(), SimError> {
        let pairs = match *self {
            Friction::Cone { standing, slipping } => vec![(standing, slipping)],
            Friction::Axes { along, across } => vec![along, across],
        };
        for (standing, slipping) in pairs {
            ensure! {
                "static friction coefficient", standing, standing >= 0.0 => "a number ≥ 0, or inf";
                "kinetic friction coefficient", slipping, (0.0..=standing).contains(&slipping)
                    => "a number from 0 to the static one";
            }
        }
        Ok(())
    }
}

/// How contacts answer to being pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Coulomb's law.
    pub friction: Friction,
    /// Restitution of rigid contacts e, in [0, 1): the speed of rebound over that of the impact.
    pub restitution: f64,
    /// Spring (N/m) and damper (N s/m) under each point; none: rigid.
    pub compliance: Option<(f64, f64)>,
}

impl Material {
    pub(crate) fn check(&self) -> Result<(), SimError> {
        self.friction.check()?;
        let e = self.restitution;
        require((0.0..=1.0).contains(&e), "restitution", e, "from 0 to 1")?;
        let Some((stiffness, damping)) = self.compliance else {
            return Ok(());
        };
        positive("contact stiffness (N/m)", stiffness)?;
        not_negative("contact damping (N s/m)", damping)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_is_as_far_as_its_nearest_point() {
        let block = Surface::Block {
            low: Vec3::new(0.0, -1.0, 0.0),
            high: Vec3::new(2.0, 1.0, 1.0),
        };
        let check = |center: [f64; 3], distance: f64, normal: [f64; 3]| {
            let found = block.proximity(&Vec3::from(center));
            assert!(
                (found.distance - distance).abs() < 1e-15,
                "{center:?}: {}",
                found.distance
            );
            assert!(
                (found.normal - Vec3::from(normal)).norm() < 1e-15,
                "{center:?}: {}",
                found.normal
            );
        };
        check([1.0, 0.0, 1.5], 0.5, [0.0, 0.0, 1.0]);
        check([-0.25, 0.0, 0.5], 0.25, [-1.0, 0.0, 0.0]);
        check([-3.0, 0.0, 5.0], 5.0, [-0.6, 0.0, 0.8]);
        check([1.0, 0.0, 0.9], -0.1_f64.mul_add(1.0, 0.0), [0.0, 0.0, 1.0]);
    }

    #[test]
    fn normals_turn_as_differences_say() {
        let block = Surface::Block {
            low: Vec3::zeros(),
            high: Vec3::new(2.0, 1.0, 1.0),
        };
        for center in [
            Vec3::new(-0.3, 0.5, 1.4),
            Vec3::new(-0.3, -0.2, 1.4),
            Vec3::new(0.3, 0.2, 1.4),
        ] {
            let velocity = Vec3::new(0.7, -0.4, 0.3);
            let normal = |t: f64| block.proximity(&(center + velocity * t)).normal;
            let difference = (normal(1e-6) - normal(-1e-6)) / 2e-6;
            assert!((block.proximity(&center).normal_rate(&velocity) - difference).norm() < 1e-8);
        }
    }
}
