//! What is flashed on a ball: the constants of its estimator and of its balancer.

use saltus_controller::Real;
use saltus_controller::ball::{
    Balance, Estimator, Feet, Filter, Lead, Rotation, Scales, Station, Steer,
};
use saltus_robot::Robot;
use saltus_robot::space::discs;

use super::balance::Stable;
use super::disc::Facing;
use super::sensing::{feet, filter, scales};
use super::steer::Steered;
use crate::GaitError;
use crate::error::ensure;

/// The constants of a ball's controller, in numbers `R`.
#[derive(Clone, Debug, PartialEq)]
pub struct Flashed<R> {
    /// How its sensors are weighed.
    pub filter: Filter<R>,
    /// What a count of them is.
    pub scales: Scales<R>,
    /// Where its legs point: unit vectors in the body's axes.
    pub directions: Vec<[R; 3]>,
    /// From where the legs meet to the middle of a retracted foot (m).
    pub reach: R,
    /// Radius of a foot (m).
    pub radius: R,
    /// How it rolls, and is kept in its plane.
    pub balance: Balance<R>,
    /// How it is led along a path, if it is: the same balance is part of it.
    pub lead: Option<Lead<R>>,
    /// The planes in which it can roll, each forwards and then backwards.
    pub planes: Vec<FlashedPlane<R>>,
}

/// A plane in which a ball can roll.
#[derive(Clone, Debug, PartialEq)]
pub struct FlashedPlane<R> {
    /// Across it, along the leg of its first station, and down a quarter turn later, as in [`Plane`](saltus_controller::ball::Plane).
    pub axes: [[R; 3]; 3],
    /// What comes onto the ground, in its order.
    pub stations: Vec<Station<R>>,
}

/// Angles of stations are told to so many of these a radian. An arc tangent is not the same to the last bit on every
/// machine; what is flashed is.
const PER_RADIAN: f64 = 1e12;

impl Flashed<f64> {
    /// What keeps `robot` in its plane by `stable`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space or has no plane to roll in, and for numbers that cannot be.
    pub fn new(robot: &Robot, stable: &Stable) -> Result<Flashed<f64>, GaitError> {
        let legs = f64::from(robot.body.legs);
        let directions = robot.space.as_ref().map(|space| space.directions.vectors());
        let allowed = "of a robot in space: body.shape = \"sphere\"";
        ensure! { "legs", legs, directions.is_some() => allowed; }
        let directions = directions.unwrap_or_default();
        let planes = Facing::every(&discs(&directions));
        let planes: Vec<FlashedPlane<f64>> = planes.iter().map(FlashedPlane::of).collect();
        let allowed = "such that the robot can roll: a plane has to hold four legs or more, and to be the mirror of the other legs";
        ensure! { "legs.directions", planes.len() as f64, !planes.is_empty() => allowed; }
        let Feet { reach, radius, .. } = feet(robot, &directions);
        Ok(Flashed {
            filter: filter(robot),
            scales: scales(&robot.sensors.unwrap_or_default()),
            reach,
            radius,
            balance: stable.balance(robot)?,
            lead: None,
            planes,
            directions,
        })
    }

    /// What leads `robot` along a path as `steered`, whose own path counts only in that it has to be one.
    ///
    /// # Errors
    /// As [`Flashed::new`], and for a path that is none.
    pub fn steered(robot: &Robot, steered: &Steered) -> Result<Flashed<f64>, GaitError> {
        let flashed = Flashed::new(robot, &steered.stable)?;
        let lead = Some(steered.lead(robot)?);
        Ok(Flashed { lead, ..flashed })
    }

    /// The same in other numbers, each rounded once.
    pub fn rounded<R: Real>(&self) -> Flashed<R> {
        let plane = |plane: &FlashedPlane<f64>| FlashedPlane {
            axes: plane.axes.map(all),
            stations: plane.stations.iter().map(station).collect(),
        };
        Flashed {
            filter: weighed(&self.filter),
            scales: counted(&self.scales),
            directions: self.directions.iter().map(|leg| all(*leg)).collect(),
            reach: R::of(self.reach),
            radius: R::of(self.radius),
            balance: balanced(&self.balance),
            lead: self.lead.as_ref().map(led),
            planes: self.planes.iter().map(plane).collect(),
        }
    }
}

impl<R: Real> Flashed<R> {
    /// What a ball at rest at `start`, attitude and place (m), knows of its motion.
    pub fn estimator(&self, start: (Rotation<R>, [R; 3])) -> Estimator<'_, R> {
        let feet = Feet {
            directions: &self.directions,
            reach: self.reach,
            radius: self.radius,
        };
        Estimator::new(self.filter, self.scales, feet, start)
    }
}

impl FlashedPlane<f64> {
    fn of(facing: &Facing) -> FlashedPlane<f64> {
        let plane = facing.plane();
        let rounded = |station: &Station<f64>| Station {
            angle: (station.angle * PER_RADIAN).round() / PER_RADIAN,
            ..*station
        };
        FlashedPlane {
            axes: [plane.axis, plane.first, plane.ahead],
            stations: plane.stations.iter().map(rounded).collect(),
        }
    }
}

fn all<R: Real, const N: usize>(numbers: [f64; N]) -> [R; N] {
    numbers.map(R::of)
}

fn station<R: Real>(station: &Station<f64>) -> Station<R> {
    Station {
        legs: station.legs,
        angle: R::of(station.angle),
    }
}

/// A struct of numbers, then of arrays, in other numbers; what is given by name comes last.
macro_rules! rounded {
    ($of:ident $from:expr; $($number:ident)*; $($array:ident)*; $($name:ident: $value:expr)*) => {
        $of {
            $($number: R::of($from.$number),)*
            $($array: all($from.$array),)*
            $($name: $value,)*
        }
    };
}

fn weighed<R: Real>(f: &Filter<f64>) -> Filter<R> {
    rounded! { Filter f; period gravity by_foot tilt settles returns; bias; }
}

fn counted<R: Real>(s: &Scales<f64>) -> Scales<R> {
    rounded! {
        Scales s; fine_gyro coarse_gyro fine_accelerometer coarse_accelerometer;; limit: s.limit
    }
}

fn balanced<R: Real>(b: &Balance<f64>) -> Balance<R> {
    let s = &b.steer;
    let steer = rounded! {
        Steer s; roll roll_rate heading heading_rate aside aside_rate sum most from rest;;
    };
    rounded! {
        Balance b; period zone rate slow stall lead least; angles opens by_rate first; steer: steer
    }
}

fn led<R: Real>(l: &Lead<f64>) -> Lead<R> {
    rounded! {
        Lead l; ahead slew tips astray turn near still rests patience;;
        balance: balanced(&l.balance)
    }
}
