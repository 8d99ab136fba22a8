//! How far a filling of a robot's tank carries: one jump after another, by the planar model, each with
//! the gas that those before have left.
//!
//! ```
//! use saltus::filling::{Request, filling};
//! use saltus::{Launch, resolve};
//!
//! let robot = resolve("rats-planar", &["tank.volume_l=0.5".into()])?;
//! let request = Request {
//!     landing_height: robot.body.radius,
//!     ..Request::of(Launch::at_firing(4.5, -0.1, 0.1))
//! };
//! let found = filling(robot, &request)?;
//! assert!(found.jumps() > 3 && found.distance() > 1.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use saltus_lagrangian::{Launch, StanceError, TankState};
use saltus_planner::Planner;
use saltus_robot::{Outcome, Robot};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Each jump.
    pub launch: Launch,
    /// Height (m) of the wheel's centre where a distance ends.
    pub landing_height: f64,
    /// Height (m) that the wheel's lowest point has to come to, ≥ 0.
    pub clear: f64,
    /// Time (s) from the end of a valve opening to the next jump, in which the tank's wall warms it
    /// up; ≥ 0.
    pub pause: f64,
    /// Jumps after which the count ends.
    pub most: usize,
}

impl Request {
    /// Of this jump: a height of 0 to clear, landings at the foothold's height, a second between
    /// jumps, and 10 000 jumps at most.
    pub fn of(launch: Launch) -> Request {
        Request {
            launch,
            landing_height: 0.0,
            clear: 0.0,
            pause: 1.0,
            most: 10_000,
        }
    }
}

/// A jump from a filling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hop {
    /// The tank before it.
    pub tank: TankState,
    /// Gas (kg) that it takes.
    pub gas: f64,
    /// How its stance ended.
    pub outcome: Outcome,
    /// Greatest height (m) of the wheel's centre; none without a flight.
    pub apex: Option<f64>,
    /// Distance (m) from the foot to the landing; none where it does not land.
    pub distance: Option<f64>,
    /// Whether it counts: it lifts off, clears the height and lands.
    pub counts: bool,
}

/// Why the count of jumps ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// The robot does not lift off any more.
    NoLiftOff,
    /// It does not clear the height any more.
    TooLow,
    /// It does not come down to the landing height: it starts or turns back above or below it.
    NoLanding,
    /// As many jumps as were asked for.
    Most,
}

impl End {
    /// A word for it.
    pub fn name(self) -> &'static str {
        match self {
            End::NoLiftOff => "no-lift-off",
            End::TooLow => "too-low",
            End::NoLanding => "no-landing",
            End::Most => "most-jumps",
        }
    }
}

/// How far a filling carries.
#[derive(Clone, Debug, PartialEq)]
pub struct Filling {
    /// The jumps, and as the last one that which does not count, unless the count ended before.
    pub hops: Vec<Hop>,
    /// Why there are no more.
    pub end: End,
    /// Gas (kg) in the full tank.
    pub filled: f64,
    /// The tank after the last jump.
    pub left: TankState,
}

impl Filling {
    /// Jumps that count.
    pub fn jumps(&self) -> usize {
        self.hops.iter().filter(|hop| hop.counts).count()
    }

    /// How far they go together (m).
    pub fn distance(&self) -> f64 {
        let counting = self.hops.iter().filter(|hop| hop.counts);
        counting.filter_map(|hop| hop.distance).sum()
    }
}

/// Why a filling cannot be counted.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum FillingError {
    /// A robot without a tank, or with one that does not empty.
    #[error(
        "tank.volume: must be given, and finite: a supply that does not empty has no filling, as in \
         tank.volume_l=0.5"
    )]
    NoTank,
    /// A robot whose legs use no gas.
    #[error(
        "leg.kind: must be \"pneumatic\" or \"muscle\": other legs use no gas, and have no filling"
    )]
    NoGas,
    /// A number of the request.
    #[error("{name} = {value}: must be a finite number ≥ 0")]
    Request {
        /// What it is, with its unit.
        name: &'static str,
        /// Its value.
        value: f64,
    },
    /// A jump that cannot be computed.
    #[error("jump {jump}: {source}")]
    Jump {
        /// Its number, from 1.
        jump: usize,
        /// Why not.
        source: StanceError,
    },
}

/// How far a filling of the tank of `robot` carries.
///
/// # Errors
/// [`FillingError`] for a robot that does not carry its gas or uses none, and a request that is none.
pub fn filling(robot: Robot, request: &Request) -> Result<Filling, FillingError> {
    for (name, value) in [
        ("height to clear (m)", request.clear),
        ("pause (s)", request.pause),
    ] {
        if !(value >= 0.0 && value.is_finite()) {
            return Err(FillingError::Request { name, value });
        }
    }
    if robot.leg.cylinder().is_none() {
        return Err(FillingError::NoGas);
    }
    let radius = robot.body.radius;
    let planner = Planner::new(robot);
    let mut tank = planner.stance().full_tank().ok_or(FillingError::NoTank)?;
    let filled = planner
        .stance()
        .tank_mass(&tank)
        .ok_or(FillingError::NoTank)?;
    let mut hops: Vec<Hop> = Vec::new();
    let mut end = End::Most;
    while hops.len() < request.most {
        let jump = planner.jump_from(&request.launch, &tank);
        let number = hops.len() + 1;
        let jump = jump.map_err(|source| FillingError::Jump {
            jump: number,
            source,
        })?;
        let (jump, drawn) = jump.ok_or(FillingError::NoTank)?;
        let (apex, distance) = (jump.apex(), jump.distance(request.landing_height));
        let why_not = match (apex, distance) {
            (None, _) => Some(End::NoLiftOff),
            (Some(apex), _) if apex - radius < request.clear => Some(End::TooLow),
            (_, None) => Some(End::NoLanding),
            _ => None,
        };
        hops.push(Hop {
            tank,
            gas: drawn.mass,
            outcome: jump.stance.outcome,
            apex,
            distance,
            counts: why_not.is_none(),
        });
        tank = drawn.tank;
        if let Some(why) = why_not {
            end = why;
            break;
        }
        let later = planner.stance().tank_later(&tank, request.pause);
        tank = later.unwrap_or(tank);
    }
    Ok(Filling {
        hops,
        end,
        filled,
        left: tank,
    })
}
