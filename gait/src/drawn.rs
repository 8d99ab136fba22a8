//! Drawn robots: what is not known of a robot, and how much of a result hangs on it.

use rand_distr::{Distribution, Normal, Uniform};
use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_robot::{Drive, GaugePressure, ReturnSpring, Robot};

use crate::run::{Setup, Summary, run};
use crate::{GaitError, error::require};

/// How robots are drawn around one.
///
/// Source: thesis 4.3.3: the 9.7 N of table 4.2 were fitted on extensions, where
/// friction and spring act together, so that their shares are open.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Draw {
    /// Dry friction (N), from and to.
    pub friction: [f64; 2],
    /// Friction and spring together at mid stroke (N).
    pub total: f64,
    /// Stiffness of the return spring (N/m), from and to.
    pub stiffness: [f64; 2],
    /// Standard deviation of the supply pressure (Pa).
    pub supply: f64,
    /// Friction coefficient along the travel, from and to.
    pub along: [f64; 2],
    /// Friction coefficient across the travel.
    pub across: f64,
}

/// What is drawn around `rats-run`, whose friction and spring come to 9.7 N at mid stroke: dry
/// friction from 1 N to all of it, friction of the ground from 0.6 to 1.2 around 0.9.
const LEAST_FRICTION: f64 = 1.0 / 9.7;
const ALONG: [f64; 2] = [0.6 / 0.9, 1.2 / 0.9];

impl Draw {
    /// What is drawn around `robot`: its friction and spring at mid stroke, split anew; its supply;
    /// its friction along the travel. Other numbers stay.
    pub fn around(robot: &Robot) -> Draw {
        let leg = &robot.leg;
        let spring = leg.return_spring.map_or(0.0, |spring| {
            spring.preload + 0.5 * leg.stroke * spring.stiffness
        });
        // The last digits of a sum are no part of what is known.
        let round = |x: f64| {
            let rounded = (x * 1e9).round() / 1e9;
            if rounded.is_finite() { rounded } else { x }
        };
        let total = round(leg.coulomb_friction + spring);
        Draw {
            friction: [round(total * LEAST_FRICTION), total],
            total,
            along: ALONG.map(|part| round(part * robot.ground.static_friction)),
            ..Draw::default()
        }
    }
}

impl Default for Draw {
    /// Around `rats-run`.
    fn default() -> Draw {
        Draw {
            friction: [1.0, 9.7],
            total: 9.7,
            stiffness: [0.0, 160.0],
            supply: 3.0 * 6894.757293168,
            along: [0.6, 1.2],
            across: 0.0,
        }
    }
}

/// Many runs of drawn robots.
#[derive(Clone, Debug)]
pub struct Ensemble {
    /// How each is run; its robot is what the others are drawn around.
    pub setup: Setup,
    /// How robots are drawn.
    pub draw: Draw,
    /// How many.
    pub robots: usize,
    /// Seed: robot k is the same for any number of them.
    pub seed: u64,
}

/// Robot `k` of those drawn around `robot`.
///
/// # Errors
/// [`GaitError::Input`] for a robot without a cylinder, whose supply cannot be drawn.
pub fn drawn_robot(robot: &Robot, draw: &Draw, seed: u64, k: usize) -> Result<Robot, GaitError> {
    let mut random = Pcg64::new(u128::from(seed), 2 * k as u128 + 1);
    let mut drawn = robot.clone();
    let between = |random: &mut Pcg64, [from, to]: [f64; 2]| match Uniform::new_inclusive(from, to)
    {
        Ok(uniform) => uniform.sample(random),
        Err(_) => from,
    };
    let friction = between(&mut random, draw.friction);
    let stiffness = between(&mut random, draw.stiffness);
    let middle = 0.5 * robot.leg.stroke;
    // What is left for the spring at mid stroke; a stiffness too great for it is what just fits.
    let left = (draw.total - friction).max(0.0);
    let stiffness = stiffness.min(left / middle);
    drawn.leg.coulomb_friction = friction;
    drawn.leg.return_spring = Some(ReturnSpring {
        stiffness,
        preload: left - stiffness * middle,
    });
    let Drive::Pneumatic(cylinder) = &mut drawn.leg.drive else {
        require(false, "drawn robots", k as f64, "ones with pneumatic legs")?;
        return Ok(drawn);
    };
    if let Ok(normal) = Normal::new(cylinder.supply.0, draw.supply) {
        cylinder.supply = GaugePressure(normal.sample(&mut random).max(0.0));
    }
    let along = between(&mut random, draw.along);
    drawn.ground.static_friction = along;
    drawn.ground.kinetic_friction = along;
    drawn.ground.across_friction = draw.across;
    Ok(drawn)
}

impl Ensemble {
    /// What became of each robot, in order: the same for any number of `threads`. `ran` is told as
    /// each is done. One that cannot be simulated does not end the others.
    pub fn run(&self, threads: usize, ran: &(impl Fn() + Sync)) -> Vec<Result<Summary, GaitError>> {
        parallel::map_on(threads, self.robots, |k| {
            let setup = Setup {
                robot: drawn_robot(&self.setup.robot, &self.draw, self.seed, k)?,
                seed: self.setup.seed.wrapping_add(k as u64),
                ..self.setup.clone()
            };
            let summary = run(&setup, &mut ());
            ran();
            summary
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn robots_are_drawn_around_the_given_one() -> Result<(), Box<dyn std::error::Error>> {
        let robot = saltus_robot::resolve("rats-run", &[])?;
        assert_eq!(Draw::around(&robot), Draw::default());
        let set = ["leg.coulomb_friction_n=1", "ground.static_friction=0.3"];
        let robot = saltus_robot::resolve("rats-run", &set.map(String::from))?;
        let draw = Draw::around(&robot);
        assert!((draw.total - 7.7).abs() < 1e-9 && (draw.along[1] - 0.4).abs() < 1e-9);
        let drawn = drawn_robot(&robot, &draw, 3, 5)?;
        let spring = drawn.leg.return_spring.ok_or("a spring")?;
        let middle = drawn.leg.coulomb_friction + spring.preload + 0.03 * spring.stiffness;
        assert!((middle - 7.7).abs() < 1e-9, "{middle}");
        Ok(())
    }
}
