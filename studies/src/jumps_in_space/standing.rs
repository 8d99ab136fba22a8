//! How a robot stands before it jumps.

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use saltus_gait::space::Facing;
use saltus_gait::{GaitError, Obstacle};
use saltus_robot::Robot;
use saltus_robot::space::{Rest, discs, rests};
use saltus_sim_check::Rig;

use super::block;
use crate::{refused, require};

/// On which feet a robot stands, which way it faces, and what is in front of it.
#[derive(Clone, Debug)]
pub struct Standing {
    /// The feet.
    pub rest: Rest,
    /// Where its legs meet (m); the world's x axis is the first way in which it can roll from there.
    pub place: [f64; 3],
    /// Attitude: a unit quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// A box on the ground across the x axis, wider than the robot.
    pub obstacle: Option<Obstacle>,
}

impl Standing {
    /// `robot` on the feet of the rest number `rest`, in the order of [`rests`].
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, and a rest that is not there.
    pub fn on(robot: &Robot, rest: usize) -> Result<Standing, GaitError> {
        let Some(space) = &robot.space else {
            let allowed = "of a robot in space: body.shape = \"sphere\"";
            return Err(refused("legs", f64::from(robot.body.legs), allowed));
        };
        let directions = space.directions.vectors();
        let all = rests(&directions);
        let allowed = format!("below {}", all.len());
        require(rest < all.len(), "rest", rest as f64, allowed)?;
        let rest = all[rest].clone();
        let ways = Facing::all(&rest, &discs(&directions));
        // Without a plane to roll in: away from the first foot.
        let behind = Vector3::from(directions[rest.legs[0]]);
        let ahead = ways
            .first()
            .map_or((-behind).into(), |way| way.ahead(&rest));
        let rig = Rig::new(robot, &[])?;
        let q = rig.stand_on(&rest, &ahead)?;
        Ok(Standing {
            rest,
            place: [q[0], q[1], q[2]],
            attitude: [q[3], q[4], q[5], q[6]],
            obstacle: None,
        })
    }

    /// The same `robot` before `obstacle`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a box that cannot be, or would be where the robot stands.
    pub fn before(self, obstacle: Obstacle, robot: &Robot) -> Result<Standing, GaitError> {
        block::check(&obstacle, robot)?;
        Ok(Standing {
            obstacle: Some(obstacle),
            ..self
        })
    }

    /// Height (m) of the ground, or of the box, at a place `x` (m) ahead.
    pub fn floor(&self, x: f64) -> f64 {
        let under = self.obstacle.filter(|it| block::is_on(it, x));
        under.map_or(0.0, |it| it.height)
    }

    /// Its attitude.
    pub(super) fn turned(&self) -> UnitQuaternion<f64> {
        quaternion(self.attitude)
    }
}

/// A unit quaternion of its parts w, x, y, z.
pub(super) fn quaternion([w, x, y, z]: [f64; 4]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(w, x, y, z))
}
