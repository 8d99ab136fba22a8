//! The ways in which a robot can roll from a rest.

use std::f64::consts::TAU;

use nalgebra::Vector3;
use saltus_controller::ball::{Plane, Station};
use saltus_robot::space::{Disc, Rest};

/// A disc, one of its two ways.
#[derive(Clone, Debug)]
pub struct Facing {
    disc: Disc,
    stations: Vec<Station<f64>>,
}

/// How far an axis may be from level (the sine) at a rest.
const LEVEL: f64 = 1e-9;

impl Facing {
    /// The ways that are open from `rest`: each disc that stands upright on it, forwards and backwards, in the order of
    /// `discs`.
    ///
    /// Source: thesis 7.2.1.
    pub fn all(rest: &Rest, discs: &[Disc]) -> Vec<Facing> {
        let down = Vector3::from(rest.down);
        let upright = |disc: &&Disc| Vector3::from(disc.axis).dot(&down).abs() < LEVEL;
        let both = |disc: &Disc| [disc.clone(), backwards(disc)];
        let all = discs.iter().filter(upright).flat_map(both);
        all.map(Facing::of).collect()
    }

    /// Every one of `discs`, forwards and backwards.
    pub fn every(discs: &[Disc]) -> Vec<Facing> {
        let both = |disc: &Disc| [disc.clone(), backwards(disc)];
        discs.iter().flat_map(both).map(Facing::of).collect()
    }

    /// `disc`, forwards.
    pub fn of(disc: Disc) -> Facing {
        // A disc has at most 64 legs.
        #[allow(clippy::cast_possible_truncation)]
        let legs = |legs: &[usize]| [legs[0] as u32, legs[legs.len() - 1] as u32];
        let station = |station: &saltus_robot::space::Station| Station {
            legs: legs(&station.legs),
            angle: station.angle.max(0.0),
        };
        let stations = disc.stations.iter().map(station).collect();
        Facing { disc, stations }
    }

    /// The disc.
    pub fn disc(&self) -> &Disc {
        &self.disc
    }

    /// The plane, as the controller follows it.
    pub fn plane(&self) -> Plane<'_, f64> {
        Plane {
            axis: self.disc.axis,
            first: self.disc.first,
            ahead: self.disc.ahead,
            stations: &self.stations,
        }
    }

    /// The direction (body axes) in which it sets out from `rest`.
    pub fn ahead(&self, rest: &Rest) -> [f64; 3] {
        let axis = Vector3::from(self.disc.axis);
        Vector3::from(rest.down).cross(&axis).into()
    }

    /// The greatest angle (rad) between two stations.
    pub(super) fn widest(&self) -> f64 {
        let stations = &self.disc.stations;
        let next = |k: usize| stations[(k + 1) % stations.len()].angle;
        let gap = |k: usize| (next(k) - stations[k].angle).rem_euclid(TAU);
        (0..stations.len()).map(gap).fold(0.0, f64::max)
    }
}

/// The same disc, the other way.
fn backwards(disc: &Disc) -> Disc {
    let flip = |v: [f64; 3]| v.map(|x| -x);
    let mut stations = disc.stations.clone();
    for station in &mut stations {
        station.angle = (TAU - station.angle).rem_euclid(TAU);
        station.legs.reverse();
    }
    stations.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    Disc {
        axis: flip(disc.axis),
        first: disc.first,
        ahead: flip(disc.ahead),
        stations,
    }
}
