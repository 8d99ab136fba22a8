//! The state machine of a run.

use super::law::NEVER;
use super::{Instruments, Law, Readings, Signals};
use crate::Real;

/// How a robot runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gait<'a, R> {
    /// At which lean a leg fires, and how long its valve opens.
    pub law: Law<'a, R>,
    /// Where the active zone begins, z₀ (rad).
    pub zone: R,
    /// Legs n, 3 to 12.
    pub legs: u32,
    /// Cycle (s).
    pub period: R,
    /// What a count is.
    pub instruments: Instruments<R>,
    /// Weights of the rate's filter: of the newest reading, and of those before it.
    pub taps: &'a [R],
    /// A speed to hold, in place of what the law gives by itself.
    pub hold: Option<Hold<R>>,
    /// When a robot that stands still is started anew.
    pub stall: Stall<R>,
    /// Firing angle (rad) and valve opening time (s) of the first firings, before the law.
    pub first: &'a [[R; 2]],
    /// A jump out of the run.
    pub leap: Option<Leap<R>>,
}

/// A jump out of a run: a firing whose angle follows from the rate at the touch-down of its leg,
/// α_f = A ω + B.
///
/// Source: thesis 5.2.3.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leap<R> {
    /// Firings before it.
    pub after: u32,
    /// A (s).
    pub slope: R,
    /// B (rad).
    pub level: R,
    /// Least and greatest firing angle (rad).
    pub least: R,
    /// The greatest.
    pub most: R,
    /// Valve opening time (s).
    pub valve_open: R,
    /// Length of the coarse accelerometer's reading (counts) from which a foot has come down.
    pub shock: i32,
}

/// How a demanded speed is held: the law is then one over the demanded speed (m/s), and its firing
/// angle is trimmed by what is lacking. A leg that fires sooner drives faster.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold<R> {
    /// Way (m) for a count of the radius encoder.
    pub way: R,
    /// Part of the measured speed that a cycle renews: the period over the time of its mean.
    pub renewed: R,
    /// By how much sooner (rad) a leg fires for each m/s that is lacking now.
    pub by_error: R,
    /// The same for each metre (m/s over a second) that has been lacking.
    pub by_sum: R,
    /// Most that counts as having been lacking (m), either way.
    pub most_sum: R,
}

/// What counts as standing still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stall<R> {
    /// Rate (rad/s) below which it does.
    pub rate: R,
    /// For how long (s), after which a stall is reported.
    pub time: R,
    /// Whether the leg in the zone may then fire once more.
    pub restarts: bool,
}

/// What a cycle decides, and from what.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Action<R> {
    /// The leg to fire now, if any.
    pub leg: Option<u32>,
    /// For how long (s).
    pub valve_open: R,
    /// The leg in the zone.
    pub in_zone: u32,
    /// Its lean (rad), in the direction of the run.
    pub lean: R,
    /// Filtered rate (rad/s), in the direction of the run.
    pub rate: R,
    /// Firing angle (rad) that held.
    pub firing_angle: R,
    /// Whether the robot stands still.
    pub stalled: bool,
}

/// A robot that runs: one [`step`](Runner::step) a cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Runner<'a, R> {
    gait: Gait<'a, R>,
    signals: Signals<'a, R>,
    /// Cycles since the start.
    cycles: u32,
    /// The leg in the zone, counted in the direction of the run, 0 to n − 1.
    leg: u32,
    /// Wheel counts at which leg 0, counted so, leaned by `offset`.
    base: i32,
    offset: R,
    /// 1, or −1 backwards.
    direction: i32,
    has_fired: bool,
    /// Rate (rad/s) at which the leg in the zone entered it.
    entry: R,
    /// Cycles for which it has stood still.
    still: u32,
    /// Demanded speed (m/s), negative for the other way.
    demand: R,
    /// What has been lacking (m), the measured speed (m/s), and the last count of the radius.
    sum: R,
    speed: R,
    last_radius: Option<i32>,
    /// Firings so far, since the start or since it stood still.
    firings: u32,
    /// Cycles since the last shock, and the rate (rad/s) that was measured after it.
    since_shock: u32,
    touched: Option<R>,
}

impl<'a, R: Real> Runner<'a, R> {
    /// A robot at rest on two legs, of which `rear` is the rear one (0 to n − 1), with its wheel's
    /// encoder at `wheel`. It runs forwards, or with `forwards` false, backwards.
    pub fn new(gait: Gait<'a, R>, rear: u32, wheel: i32, forwards: bool) -> Runner<'a, R> {
        let half = R::of(3.141592653589793) / R::of_count(gait.legs.min(12) as i32);
        let mut runner = Runner {
            signals: Signals::new(gait.instruments, gait.taps),
            gait,
            cycles: 0,
            leg: 0,
            base: wheel,
            offset: half,
            direction: 1,
            has_fired: false,
            entry: R::ZERO,
            still: 0,
            demand: R::ZERO,
            sum: R::ZERO,
            speed: R::ZERO,
            last_radius: None,
            firings: 0,
            since_shock: 0,
            touched: None,
        };
        runner.leg = rear;
        // Leg `rear` leans by half a pitch, so that leg 0 leans by `rear` pitches more.
        runner.offset = half + (half + half) * R::of_count((rear.min(12)) as i32);
        if !forwards {
            runner.turn_round(wheel);
        }
        runner
    }

    /// The speed to hold (m/s), negative for the way opposite to that of the start. To turn, the
    /// robot first comes to stand.
    pub fn demand(&mut self, speed: R) {
        self.demand = speed;
    }

    /// Runs the other way from now on: legs and leans are mirrored.
    pub fn turn_round(&mut self, wheel: i32) {
        let (legs, turned) = (self.gait.legs, self.turned(wheel));
        // Leg k of now is leg n − k then, and leans by as much the other way.
        self.offset = -(self.offset + turned);
        self.base = wheel;
        self.direction = self.direction.wrapping_neg();
        self.leg = if self.leg == 0 {
            0
        } else {
            legs.wrapping_sub(self.leg)
        };
        self.has_fired = false;
        self.firings = 0;
        (self.sum, self.speed) = (R::ZERO, R::ZERO);
    }

    /// By how much the wheel has turned (rad) since `base`, in the direction of the run.
    #[inline]
    fn turned(&self, wheel: i32) -> R {
        let counts = wheel.wrapping_sub(self.base).wrapping_mul(self.direction);
        R::of_count(counts) * self.gait.instruments.wheel
    }

    /// The leg in the zone and its lean (rad).
    #[inline]
    fn find_leg(&mut self, wheel: i32) -> R {
        let legs = self.gait.legs;
        let pitch = R::of(6.283185307179586) / R::of_count(legs.min(12) as i32);
        let high = self.gait.zone + pitch;
        let turn = self
            .gait
            .instruments
            .wheel_turn
            .wrapping_mul(self.direction);
        let mut lean = self.lean_of(self.leg, wheel, pitch);
        // A cycle is too short for more than a turn; whatever the counter says, this ends.
        for _ in 0..13 {
            if lean >= high {
                self.leg = self.leg.wrapping_add(1);
                if self.leg >= legs {
                    (self.leg, self.base) = (0, self.base.wrapping_add(turn));
                }
            } else if lean < self.gait.zone {
                if self.leg == 0 {
                    (self.leg, self.base) = (legs.wrapping_sub(1), self.base.wrapping_sub(turn));
                } else {
                    self.leg = self.leg.wrapping_sub(1);
                }
            } else {
                break;
            }
            self.has_fired = false;
            lean = self.lean_of(self.leg, wheel, pitch);
        }
        lean
    }

    #[inline]
    fn lean_of(&self, leg: u32, wheel: i32, pitch: R) -> R {
        self.turned(wheel) + self.offset - R::of_count(leg.min(12) as i32) * pitch
    }

    /// The name of leg `leg` on the robot.
    #[inline]
    fn name(&self, leg: u32) -> u32 {
        if self.direction > 0 || leg == 0 {
            leg
        } else {
            self.gait.legs.wrapping_sub(leg)
        }
    }

    /// A cycle: whether a leg fires now.
    #[inline]
    pub fn step(&mut self, readings: &Readings) -> Action<R> {
        let before = self.leg;
        let lean = self.find_leg(readings.wheel);
        let rate = self.signals.rate(readings) * R::of_count(self.direction);
        if self.leg != before || self.cycles == 0 {
            self.entry = rate;
        }
        let time = R::of_count((self.cycles.min(0x7FFF_FFFF)) as i32) * self.gait.period;
        self.cycles = self.cycles.saturating_add(1);
        self.feel(readings, rate);
        let [firing_angle, valve_open] = match self.gait.hold {
            None => self.next_firing(time, rate),
            Some(hold) => match self.held(&hold, readings.radius) {
                Some([demand, later]) => {
                    let [angle, open] = self.next_firing(time, demand);
                    [(angle + later).greater(self.gait.zone), open]
                }
                None => [R::of(NEVER), R::ZERO],
            },
        };
        let stalled = self.stands_still(readings.wheel, rate);
        let fires = !self.has_fired && lean >= firing_angle && valve_open.is_positive();
        if fires {
            self.has_fired = true;
            self.firings = self.firings.saturating_add(1);
            self.touched = None;
        }
        Action {
            leg: fires.then_some(self.name(self.leg)),
            valve_open: if fires { valve_open } else { R::ZERO },
            in_zone: self.name(self.leg),
            lean,
            rate,
            firing_angle,
            stalled,
        }
    }

    /// Notes the rate a few cycles after a foot has come down, when the filter has forgotten the
    /// impact.
    #[inline]
    fn feel(&mut self, readings: &Readings, rate: R) {
        let Some(leap) = &self.gait.leap else { return };
        let [forward, up] = readings.coarse_accelerometer;
        let is_shock = forward.unsigned_abs().max(up.unsigned_abs()) >= leap.shock.unsigned_abs();
        if is_shock {
            self.since_shock = 0;
        } else {
            self.since_shock = self.since_shock.saturating_add(1);
        }
        if self.since_shock as usize == self.gait.taps.len() {
            self.touched = Some(rate);
        }
    }

    /// Firing angle (rad) and valve opening time (s) of the next firing.
    #[inline]
    fn next_firing(&self, time: R, rate: R) -> [R; 2] {
        if let Some(first) = self.gait.first.get(self.firings as usize) {
            return *first;
        }
        match &self.gait.leap {
            Some(leap) if leap.after == self.firings => {
                let rate = self.touched.unwrap_or(rate);
                let angle = leap.slope * rate + leap.level;
                [angle.greater(leap.least).lesser(leap.most), leap.valve_open]
            }
            _ => self.gait.law.at(time, rate, self.entry),
        }
    }

    /// By how much (rad) later the demanded speed lets a leg fire than the law says, and what that
    /// speed is (m/s), in the direction of the run; none where it is to stand.
    #[inline]
    fn held(&mut self, hold: &Hold<R>, radius: i32) -> Option<[R; 2]> {
        let counts = radius.wrapping_sub(self.last_radius.unwrap_or(radius));
        self.last_radius = Some(radius);
        let way = R::of_count(counts.wrapping_mul(self.direction)) * hold.way;
        self.speed = self.speed + hold.renewed * (way / self.gait.period - self.speed);
        let demand = self.demand * R::of_count(self.direction);
        if !demand.is_positive() {
            self.sum = R::ZERO;
            return None;
        }
        let lacking = demand - self.speed;
        let sum = self.sum + lacking * self.gait.period;
        self.sum = sum.greater(-hold.most_sum).lesser(hold.most_sum);
        Some([demand, -(hold.by_error * lacking + hold.by_sum * self.sum)])
    }

    /// Counts the time for which it stands still.
    #[inline]
    fn stands_still(&mut self, wheel: i32, rate: R) -> bool {
        let stall = self.gait.stall;
        if rate.magnitude() >= stall.rate {
            self.still = 0;
            return false;
        }
        self.still = self.still.saturating_add(1);
        let time = R::of_count((self.still.min(0x7FFF_FFFF)) as i32) * self.gait.period;
        let stalled = time >= stall.time;
        if stalled && stall.restarts {
            (self.has_fired, self.still, self.firings) = (false, 0, 0);
        }
        if stalled
            && self.gait.hold.is_some()
            && self.demand * R::of_count(self.direction) < R::ZERO
        {
            self.turn_round(wheel);
        }
        stalled
    }
}
