//! The plane in which a ball rolls, seen from its attitude.

use core::f64::consts::TAU;

use super::rotation::{Rotation, angle, dot};
use crate::Real;

/// A leg in a plane, or two of which each is the mirror image of the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station<R> {
    /// The legs: of twins first the left one, of a single leg twice itself.
    pub legs: [u32; 2],
    /// How far (rad) the disc turns from where the first station points down to where this one does, in [0, 2 π), rising
    /// from station to station.
    pub angle: R,
}

impl<R> Station<R> {
    /// Whether it is of two legs.
    #[inline]
    pub fn is_of_twins(&self) -> bool {
        self.legs[0] != self.legs[1]
    }
}

/// A plane through a ball's middle, with the legs near it: a disc.
///
/// Source: thesis 7.2.1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane<'a, R> {
    /// Unit vector, in the body's axes, across the plane: to the left of a ball that rolls forwards, right-handed about it.
    pub axis: [R; 3],
    /// Unit vector, in the body's axes, along the leg of the first station.
    pub first: [R; 3],
    /// Unit vector, in the body's axes, that points down after a quarter turn from where `first` does.
    pub ahead: [R; 3],
    /// What comes onto the ground, in its order; the first at angle 0.
    pub stations: &'a [Station<R>],
}

/// How a plane lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lying<R> {
    /// Lean (rad) of the station in the zone.
    pub lean: R,
    /// Rate (rad/s) of the turn about the disc's axis.
    pub rate: R,
    /// Roll (rad): how far the disc leans to the right.
    pub roll: R,
    /// Its rate (rad/s).
    pub roll_rate: R,
    /// Heading (rad), to the left of the x axis, in [−π, π].
    pub heading: R,
    /// Its rate (rad/s).
    pub heading_rate: R,
}

/// Follows a plane as it turns: which station is in the active zone, from where its lean is `zone` until the next one's is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tracker<'a, R> {
    plane: Plane<'a, R>,
    zone: R,
    /// Turn (rad) of the disc, in [0, 2 π) from where the first station enters the zone; none before the first look.
    turn: Option<R>,
    /// Whole turns, and the station in the zone.
    turns: i32,
    station: usize,
}

impl<'a, R: Real> Tracker<'a, R> {
    /// A ball that has not been looked at; its stations enter the active zone where they lean by `zone` (rad).
    pub fn new(plane: Plane<'a, R>, zone: R) -> Tracker<'a, R> {
        Tracker {
            plane,
            zone,
            turn: None,
            turns: 0,
            station: 0,
        }
    }

    /// The plane.
    pub fn plane(&self) -> &Plane<'a, R> {
        &self.plane
    }

    /// Looks at the ball's attitude (from its axes to the world's) and its spin (rad/s, the world's axes); also whether
    /// another station has entered the zone.
    #[inline]
    pub fn look(&mut self, attitude: &Rotation<R>, spin: &[R; 3]) -> (Lying<R>, bool) {
        let plane = self.plane;
        let down = attitude.back().turn(&[R::ZERO, R::ZERO, -R::ONE]);
        let entered = self.follow(angle(dot(&down, &plane.ahead), dot(&down, &plane.first)));
        let axis = attitude.turn(&plane.axis);
        // The heading is level, and across the axis.
        let length = (axis[0] * axis[0] + axis[1] * axis[1]).sqrt();
        let ahead = if length.is_positive() {
            [axis[1] / length, -axis[0] / length, R::ZERO]
        } else {
            [R::ONE, R::ZERO, R::ZERO]
        };
        let turn = self.turn.unwrap_or(R::ZERO) + self.zone;
        let station = self.station().map_or(R::ZERO, |station| station.angle);
        let lying = Lying {
            lean: turn - station,
            rate: dot(spin, &axis),
            roll: angle(axis[2], length),
            roll_rate: dot(spin, &ahead),
            heading: angle(ahead[1], ahead[0]),
            heading_rate: spin[2],
        };
        (lying, entered)
    }

    /// The disc has turned by `angle` (rad, whole turns left out) from where its first station points down; whether another
    /// station has entered the zone.
    #[inline]
    fn follow(&mut self, angle: R) -> bool {
        let whole = R::of(TAU);
        let mut turn = angle - self.zone;
        for _ in 0..3 {
            if turn < R::ZERO {
                turn = turn + whole;
            } else if turn >= whole {
                turn = turn - whole;
            }
        }
        let before = self.passed();
        let is_first = self.turn.is_none();
        if let Some(was) = self.turn {
            let half = R::of(0.5 * TAU);
            if turn - was > half {
                self.turns = self.turns.wrapping_sub(1);
            } else if was - turn > half {
                self.turns = self.turns.wrapping_add(1);
            }
        }
        self.turn = Some(turn);
        self.station = 0;
        for (k, station) in self.plane.stations.iter().enumerate() {
            if station.angle <= turn {
                self.station = k;
            }
        }
        is_first || self.passed() > before
    }

    /// Stations that have entered the zone, from the first one of turn 0 on.
    #[inline]
    #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
    pub fn passed(&self) -> i32 {
        let count = self.plane.stations.len() as i32;
        self.turns
            .wrapping_mul(count)
            .wrapping_add(self.station as i32)
    }

    /// The station in the zone; none in a plane without any.
    #[inline]
    pub fn station(&self) -> Option<&'a Station<R>> {
        self.plane.stations.get(self.station)
    }
}
