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

impl Default for Draw {
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
    /// Runs robot after robot, on so many `threads`: the same answers for any number of them.
    /// `ran` is told as each is done.
    ///
    /// # Errors
    /// [`GaitError`] of the first robot that cannot run.
    pub fn run(&self, threads: usize, ran: &(impl Fn() + Sync)) -> Result<Vec<Summary>, GaitError> {
        let one = |k: usize| {
            let setup = Setup {
                robot: drawn_robot(&self.setup.robot, &self.draw, self.seed, k)?,
                seed: self.setup.seed.wrapping_add(k as u64),
                ..self.setup.clone()
            };
            let summary = run(&setup, &mut ());
            ran();
            summary
        };
        parallel::map_on(threads, self.robots, one)
            .into_iter()
            .collect()
    }
}
