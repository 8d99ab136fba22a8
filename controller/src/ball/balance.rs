//! Which leg fires when, and how twins keep a ball in its plane.

use super::plane::{Lying, Plane, Tracker};
use super::rotation::Rotation;
use crate::Real;

/// How a ball rolls, and how it is kept in its plane. Of two numbers the first is of single legs, the second of twins.
///
/// Source: thesis 7.2.2 and 7.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balance<R> {
    /// Cycle (s).
    pub period: R,
    /// Lean (rad) at which a station enters the active zone.
    pub zone: R,
    /// Lean α_f (rad) from which on the station in the zone fires, once, when it touches the ground.
    pub angles: [R; 2],
    /// Valve opening times t_v (s) at `rate`.
    pub opens: [R; 2],
    /// By how much longer (s) a valve opens for each rad/s below `rate`.
    pub by_rate: [R; 2],
    /// Rate (rad/s) to hold.
    pub rate: R,
    /// Valve opening times (s) where it turns more slowly than `slow`: to set out.
    pub first: [R; 2],
    /// That rate (rad/s).
    pub slow: R,
    /// For how long (s) it may turn more slowly than half of that before the station in the zone may fire again.
    pub stall: R,
    /// How long (s) a leg takes from its command until it pushes.
    pub lead: R,
    /// Shortest opening time (s); what would open for less does not fire.
    pub least: R,
    /// What the twins do.
    pub steer: Steer<R>,
}

/// By how much longer (s) the valve of the right twin opens, and that of the left one less long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Steer<R> {
    /// For each rad of roll, as it will be when the leg pushes.
    pub roll: R,
    /// For each rad/s of it.
    pub roll_rate: R,
    /// For each rad off the course, to the left.
    pub heading: R,
    /// For each rad/s of it.
    pub heading_rate: R,
    /// For each metre to the left of the line.
    pub aside: R,
    /// For each m/s to the left, across the line.
    pub aside_rate: R,
    /// For each rad that earlier twins were off it, half a metre aside counted as a quarter; at most 1 of them.
    pub sum: R,
    /// Most (s), either way.
    pub most: R,
    /// Lean (rad) of the twins from which on each that is on the ground fires for what it lacks, again and again.
    pub from: R,
    /// Shortest time (s) from one of these firings to the next of the same twin.
    pub rest: R,
}

/// What a cycle sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sight<R> {
    /// Attitude, from the body's axes to the world's.
    pub attitude: Rotation<R>,
    /// Spin (rad/s), the world's axes.
    pub spin: [R; 3],
    /// Way (m) to the left of the line.
    pub aside: R,
    /// Its rate (m/s).
    pub aside_rate: R,
    /// Course (rad): the heading of the line, to the left of the x axis.
    pub course: R,
    /// Feet on the ground: bit k is leg k's.
    pub touching: u64,
}

/// A leg to fire now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firing<R> {
    /// Which.
    pub leg: u32,
    /// For how long (s).
    pub open: R,
}

/// Rolls a ball, a cycle at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Balancer<'a, R> {
    balance: Balance<R>,
    tracker: Tracker<'a, R>,
    /// Whether the station in the zone may fire.
    waits: bool,
    /// Cycles for which it has hardly turned.
    still: u32,
    sum: R,
    /// Cycles since the left and the right twin were fired.
    since: [u16; 2],
}

/// Most that the twins' errors sum up to (rad).
const MOST_SUM: f64 = 1.0;
/// What a metre aside counts in that sum (rad).
const BY_ASIDE: f64 = 0.5;

impl<'a, R: Real> Balancer<'a, R> {
    /// A ball that has not yet been seen, to roll in `plane`.
    pub fn new(balance: Balance<R>, plane: Plane<'a, R>) -> Balancer<'a, R> {
        Balancer {
            tracker: Tracker::new(plane, balance.zone),
            balance,
            waits: true,
            still: 0,
            sum: R::ZERO,
            since: [u16::MAX; 2],
        }
    }

    /// What follows its plane.
    pub fn tracker(&self) -> &Tracker<'a, R> {
        &self.tracker
    }

    /// A cycle: how the plane lies, and the legs that fire now.
    #[inline]
    pub fn step(&mut self, sight: &Sight<R>) -> (Lying<R>, [Option<Firing<R>>; 2]) {
        let (lying, entered) = self.tracker.look(&sight.attitude, &sight.spin);
        let b = self.balance;
        let is_still = lying.rate.magnitude() < b.slow * R::of(0.5);
        self.still = if is_still {
            self.still.saturating_add(1)
        } else {
            0
        };
        let cycles = i32::try_from(self.still).unwrap_or(i32::MAX);
        if entered || R::of_count(cycles) * b.period > b.stall {
            (self.waits, self.still) = (true, 0);
        }
        self.since = self.since.map(|cycles| cycles.saturating_add(1));
        let Some(station) = self.tracker.station() else {
            return (lying, [None; 2]);
        };
        let kind = usize::from(station.is_of_twins());
        let bit = |leg: u32| sight.touching.checked_shr(leg).unwrap_or(0) & 1 == 1;
        let touch = station.legs.map(bit);
        let is_due = self.waits && (lying.lean - b.angles[kind]).is_at_least_zero();
        let more = if kind == 1 {
            self.difference(&lying, sight)
        } else {
            R::ZERO
        };
        if !is_due || !(touch[0] || touch[1]) {
            let fired = if kind == 1 && (lying.lean - b.steer.from).is_at_least_zero() {
                self.correct(station.legs, touch, more)
            } else {
                [None; 2]
            };
            return (lying, fired);
        }
        self.waits = false;
        let open = if lying.rate < b.slow {
            b.first[kind]
        } else {
            b.opens[kind] + b.by_rate[kind] * (b.rate - lying.rate)
        };
        let fires = |leg: u32, open: R| (open >= b.least).then_some(Firing { leg, open });
        let [left, right] = station.legs;
        if kind == 0 {
            return (lying, [fires(left, open.greater(b.least)), None]);
        }
        self.since = [0; 2];
        self.sum_up(&lying, sight);
        (lying, [fires(left, open - more), fires(right, open + more)])
    }

    /// Fires each of the twins `legs` that is on the ground for what it lacks, if it is ready.
    #[inline]
    fn correct(&mut self, legs: [u32; 2], touch: [bool; 2], more: R) -> [Option<Firing<R>>; 2] {
        let b = self.balance;
        let mut fired = [None; 2];
        for (side, open) in [-more, more].into_iter().enumerate() {
            let rested = R::of_count(i32::from(self.since[side])) * b.period > b.steer.rest;
            if touch[side] && rested && open >= b.least {
                self.since[side] = 0;
                fired[side] = Some(Firing {
                    leg: legs[side],
                    open,
                });
            }
        }
        fired
    }

    /// By how much longer (s) the right twin's valve opens.
    #[inline]
    fn difference(&self, lying: &Lying<R>, sight: &Sight<R>) -> R {
        let s = &self.balance.steer;
        let more = s.roll * (lying.roll + self.balance.lead * lying.roll_rate)
            + s.roll_rate * lying.roll_rate
            + s.heading * wrapped(lying.heading - sight.course)
            + s.heading_rate * lying.heading_rate
            + s.aside * sight.aside
            + s.aside_rate * sight.aside_rate
            + s.sum * self.sum;
        more.lesser(s.most).greater(-s.most)
    }

    /// Adds up how far off the line the twins were.
    #[inline]
    fn sum_up(&mut self, lying: &Lying<R>, sight: &Sight<R>) {
        let most = R::of(MOST_SUM);
        let off = wrapped(lying.heading - sight.course) + R::of(BY_ASIDE) * sight.aside;
        if off.is_finite() {
            self.sum = (self.sum + off).lesser(most).greater(-most);
        }
    }
}

/// An angle (rad) of at most a turn and a half, from −π to π.
pub(super) fn wrapped<R: Real>(angle: R) -> R {
    let half = R::of(core::f64::consts::PI);
    if angle > half {
        angle - (half + half)
    } else if angle < -half {
        angle + (half + half)
    } else {
        angle
    }
}
