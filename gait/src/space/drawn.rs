//! Drawn balls: none is as its file says.

use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use saltus_robot::Robot;
use saltus_robot::space::Factors;

use crate::GaitError;
use crate::error::{ensure, require};

/// How balls are drawn around one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DrawnBalls {
    /// Standard deviation of a leg's force, as a part of it.
    pub force: f64,
    /// Radius (m) of the sphere within which the centre of mass is drawn, around where it is.
    pub center: f64,
    /// Friction of the ground, from and to.
    pub friction: [f64; 2],
}

impl Default for DrawnBalls {
    /// 5 % of force, 1 mm, friction from 0.6 to 1.2.
    fn default() -> DrawnBalls {
        DrawnBalls {
            force: 0.05,
            center: 1e-3,
            friction: [0.6, 1.2],
        }
    }
}

impl DrawnBalls {
    /// The same with friction from 0.6 to 1.2 times that of the ground of `robot`.
    pub fn around(robot: &Robot) -> DrawnBalls {
        let usual = DrawnBalls::default();
        DrawnBalls {
            friction: usual
                .friction
                .map(|part| part * robot.ground.kinetic_friction),
            ..usual
        }
    }
}

/// Least factor of a force, however it is drawn.
const LEAST: f64 = 0.05;

/// Ball `k` of those drawn around `robot` from `seed`: the same for any number of them.
///
/// # Errors
/// [`GaitError::Input`] for a robot that is not in space, and numbers that cannot be drawn by.
pub fn drawn_ball(
    robot: &Robot,
    draw: &DrawnBalls,
    seed: u64,
    k: usize,
) -> Result<Robot, GaitError> {
    let ([from, to], DrawnBalls { force, center, .. }) = (draw.friction, *draw);
    ensure! {
        "scatter of forces", force, (0.0..=0.5).contains(&force) => "from 0 to 0.5";
        "scatter of the centre of mass (m)", center, (0.0..=0.1).contains(&center)
            => "from 0 to 0.1 m";
        "friction, from", from, (0.0..=to).contains(&from) => format!("from 0 to {to}");
    }
    let mut drawn = robot.clone();
    let mut random = Pcg64::new(u128::from(seed), 2 * k as u128 + 1);
    let legs = robot.body.legs as usize;
    let Some(space) = &mut drawn.space else {
        let allowed = "of a robot in space: body.shape = \"sphere\"";
        require(false, "legs", legs as f64, allowed)?;
        return Ok(drawn);
    };
    space.legs.resize(legs, Factors::default());
    for leg in &mut space.legs {
        let normal: f64 = StandardNormal.sample(&mut random);
        leg.force *= (1.0 + draw.force * normal).max(LEAST);
    }
    let direction: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(&mut random));
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let unit: f64 = Uniform::new(0.0, 1.0).map_or(0.5, |uniform| uniform.sample(&mut random));
    let far = draw.center * unit.cbrt() / length.max(f64::MIN_POSITIVE);
    for (center, x) in space.center.iter_mut().zip(direction) {
        *center += far * x;
    }
    let friction = Uniform::new_inclusive(from, to).map_or(from, |it| it.sample(&mut random));
    drawn.ground.static_friction = friction;
    drawn.ground.kinetic_friction = friction;
    Ok(drawn)
}
