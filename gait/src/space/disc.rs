//! The plane in which a robot rolls, seen from its attitude.

use std::f64::consts::TAU;

use nalgebra::{UnitQuaternion, Vector3};
use saltus_robot::space::{Disc, Rest};

/// A disc, one of its two ways.
#[derive(Clone, Debug)]
pub struct Facing {
    disc: Disc,
    /// Lean (rad) at which a station enters the active zone.
    zone: f64,
    /// Turn (rad), counted on; none before the first look.
    turn: Option<f64>,
    /// Stations that have entered the zone, from the first one of turn 0 on.
    passed: i64,
}

/// How a robot lies to its plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rolling {
    /// Turn of the disc (rad) since its first station pointed down, counted on.
    pub turn: f64,
    /// Its rate (rad/s) about the disc's axis.
    pub rate: f64,
    /// Lean (rad) of the station in the zone.
    pub lean: f64,
    /// Roll (rad): how far the disc leans to the right.
    pub roll: f64,
    /// Its rate (rad/s).
    pub roll_rate: f64,
    /// Heading (rad), to the left of the x axis, and its rate (rad/s).
    pub heading: f64,
    /// Rate of the heading (rad/s).
    pub heading_rate: f64,
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
        all.map(|disc| Facing {
            disc,
            zone: 0.0,
            turn: None,
            passed: 0,
        })
        .collect()
    }

    /// The same with the active zone beginning at `zone` (rad).
    pub(super) fn at(mut self, zone: f64) -> Facing {
        self.zone = zone;
        self
    }

    /// The disc.
    pub fn disc(&self) -> &Disc {
        &self.disc
    }

    /// The direction (body axes) in which it sets out from `rest`.
    pub(super) fn ahead(&self, rest: &Rest) -> [f64; 3] {
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

    /// Looks at the robot's attitude (from its axes to the world's) and angular velocity (rad/s, the world's axes); also
    /// whether another station has entered the zone.
    pub(super) fn look(
        &mut self,
        attitude: &UnitQuaternion<f64>,
        spin: &Vector3<f64>,
    ) -> (Rolling, bool) {
        let disc = &self.disc;
        let down = attitude.inverse() * -Vector3::z();
        let (x, y) = (
            down.dot(&Vector3::from(disc.first)),
            down.dot(&Vector3::from(disc.ahead)),
        );
        let angle = y.atan2(x);
        let before = self.turn.unwrap_or(angle);
        let turn = before + wrapped(angle - before);
        let is_first = self.turn.is_none();
        self.turn = Some(turn);
        let axis = attitude * Vector3::from(disc.axis);
        let level = Vector3::new(axis.y, -axis.x, 0.0);
        let ahead = level.try_normalize(LEVEL).unwrap_or(Vector3::x());
        let passed = self.passed_at(turn);
        let entered = is_first || passed > self.passed;
        self.passed = passed;
        let rolling = Rolling {
            turn,
            rate: spin.dot(&axis),
            lean: turn - self.angle(passed),
            roll: axis.z.clamp(-1.0, 1.0).asin(),
            roll_rate: spin.dot(&ahead),
            heading: ahead.y.atan2(ahead.x),
            heading_rate: spin.z,
        };
        (rolling, entered)
    }

    /// The last station that has entered the zone at `turn` (rad).
    fn passed_at(&self, turn: f64) -> i64 {
        let count = self.disc.stations.len();
        let whole = (turn - self.zone).div_euclid(TAU);
        let rest = (turn - self.zone).rem_euclid(TAU);
        let inside = self.disc.stations.iter().filter(|it| it.angle <= rest);
        // A disc has at most 64 legs, and no run so many turns.
        #[allow(clippy::cast_possible_truncation, clippy::cast_possible_wrap)]
        let passed = whole as i64 * count as i64 + inside.count() as i64 - 1;
        passed
    }

    /// Turn (rad) at which a station points down.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss
    )]
    fn angle(&self, station: i64) -> f64 {
        let count = self.disc.stations.len() as i64;
        let within = &self.disc.stations[station.rem_euclid(count) as usize];
        station.div_euclid(count) as f64 * TAU + within.angle
    }

    /// Stations that have come into the zone.
    pub(super) fn passed(&self) -> i64 {
        self.passed
    }

    /// The legs of the station in the zone.
    #[allow(
        clippy::cast_possible_truncation,
        clippy::cast_possible_wrap,
        clippy::cast_sign_loss
    )]
    pub(super) fn station(&self) -> &[usize] {
        let count = self.disc.stations.len() as i64;
        &self.disc.stations[self.passed.rem_euclid(count) as usize].legs
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

/// An angle (rad) from −π to π.
fn wrapped(angle: f64) -> f64 {
    angle - TAU * (angle / TAU).round()
}
