//! The state machine of a run.

use core::ops::RangeInclusive;

use super::{Instruments, Law, Readings, Signals};
use crate::Real;

/// How a robot runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gait<'a, R> {
    /// At which lean a leg fires, and how long its valve opens.
    pub law: Law<'a, R>,
    /// Where the active zone begins, z₀ (rad).
    pub zone: R,
    /// Legs n, 3 to 12. With any other number no leg ever fires.
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
}

/// Legs of a robot that runs.
pub(super) const LEGS: RangeInclusive<u32> = 3..=12;

/// How far (rad) behind its zone a leg leaves it: more than round-off, so that a count on the border
/// of two zones is in one of them alone, and less than a count.
const BACK: f64 = 1e-5;

/// How a demanded rate is held: a firing angle that falls with the demand, and a valve opening time
/// that grows with it and with what is lacking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold<R> {
    /// Change of the opening time (s) for each rad/s that is lacking now.
    pub by_error: R,
    /// The same for each rad (rad/s over a second) that has been lacking.
    pub by_sum: R,
    /// Most that the sum may be (rad).
    pub most_sum: R,
    /// Least opening time (s): a shorter one is none.
    pub least_open: R,
    /// Greatest opening time (s).
    pub most_open: R,
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
    /// From leg to leg, 2π/n (rad).
    pitch: R,
    /// 1, or −1 backwards.
    direction: i32,
    has_fired: bool,
    /// Whether the leg in the zone has just entered it.
    enters: bool,
    /// Rate (rad/s) at which the leg in the zone entered it.
    entry: R,
    /// Cycles for which it has stood still.
    still: u32,
    demand: R,
    sum: R,
}

impl<'a, R: Real> Runner<'a, R> {
    /// A robot at rest on two legs, of which `rear` is the rear one (0 to n − 1), with its wheel's
    /// encoder at `wheel`. It runs forwards, or with `forwards` false, backwards.
    ///
    /// If the robot has no leg `rear`, no leg ever fires.
    pub fn new(gait: Gait<'a, R>, rear: u32, wheel: i32, forwards: bool) -> Runner<'a, R> {
        let is_sound = LEGS.contains(&gait.legs) && rear < gait.legs;
        // Without legs the pitch is infinite, and no lean is a number.
        let legs = if is_sound { gait.legs } else { 0 };
        let leg = if is_sound { rear } else { 0 };
        let half = R::of(core::f64::consts::PI) / count(legs);
        let mut runner = Runner {
            signals: Signals::new(gait.instruments, gait.taps),
            gait: Gait { legs, ..gait },
            cycles: 0,
            leg,
            base: wheel,
            // Leg `rear` leans by half a pitch, so that leg 0 leans by `rear` pitches more.
            offset: half + (half + half) * count(leg),
            pitch: half + half,
            direction: 1,
            has_fired: false,
            enters: true,
            entry: R::ZERO,
            still: 0,
            demand: R::ZERO,
            sum: R::ZERO,
        };
        if !forwards {
            runner.turn_round(wheel);
        }
        runner
    }

    /// The rate to hold (rad/s), in the direction of the run.
    pub fn demand(&mut self, rate: R) {
        if rate != self.demand {
            self.sum = R::ZERO;
        }
        self.demand = rate;
    }

    /// Runs the other way from now on, the wheel's encoder being at `wheel`: legs and leans are
    /// mirrored.
    ///
    /// Counts and angles only change their signs, so that nothing is lost however often it turns.
    pub fn turn_round(&mut self, wheel: i32) {
        self.offset = -self.offset;
        self.direction = self.direction.wrapping_neg();
        // Leg k of now is leg n − k then; as legs are counted from 0 to n − 1, a turn lies between.
        if self.leg != 0 {
            self.leg = self.gait.legs.wrapping_sub(self.leg);
            self.base = self.base.wrapping_sub(self.turn());
        }
        self.has_fired = false;
        self.enters = true;
        self.sum = R::ZERO;
        self.find_leg(wheel);
    }

    /// Counts of a turn in the direction of the run.
    #[inline]
    fn turn(&self) -> i32 {
        self.gait
            .instruments
            .wheel_turn
            .wrapping_mul(self.direction)
    }

    /// By how much the wheel has turned (rad) since `base`, in the direction of the run.
    #[inline]
    fn turned(&self, wheel: i32) -> R {
        let counts = wheel.wrapping_sub(self.base).wrapping_mul(self.direction);
        R::of_count(counts) * self.gait.instruments.wheel
    }

    /// Finds the leg in the zone; its lean (rad).
    #[inline]
    fn find_leg(&mut self, wheel: i32) -> R {
        let (legs, low) = (self.gait.legs, self.gait.zone);
        let (high, turn) = (low + self.pitch, self.turn());
        let back = low - R::of(BACK);
        let mut lean = self.lean(wheel);
        // A cycle is too short for more than a turn; whatever the counter says, this ends.
        for _ in 0..13 {
            if lean >= high {
                self.leg = self.leg.wrapping_add(1);
                if self.leg >= legs {
                    (self.leg, self.base) = (0, self.base.wrapping_add(turn));
                }
            } else if lean < back {
                if self.leg == 0 {
                    (self.leg, self.base) = (legs, self.base.wrapping_sub(turn));
                }
                self.leg = self.leg.wrapping_sub(1);
            } else {
                break;
            }
            (self.has_fired, self.enters) = (false, true);
            lean = self.lean(wheel);
        }
        lean
    }

    /// Lean (rad) of the leg that was last in the zone.
    #[inline]
    fn lean(&self, wheel: i32) -> R {
        self.turned(wheel) + self.offset - count::<R>(self.leg) * self.pitch
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
        let lean = self.find_leg(readings.wheel);
        let rate = self.signals.rate(readings) * R::of_count(self.direction);
        if self.enters {
            (self.entry, self.enters) = (rate, false);
        }
        let time = count::<R>(self.cycles) * self.gait.period;
        self.cycles = self.cycles.saturating_add(1);
        let [firing_angle, law_open] = self.gait.law.at(time, rate, self.entry);
        let valve_open = match self.gait.hold {
            None => law_open,
            Some(hold) => self.held(&hold, rate, law_open),
        };
        let stalled = self.stands_still(rate);
        let fires = !self.has_fired && lean >= firing_angle && valve_open.is_positive();
        if fires {
            self.has_fired = true;
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

    /// The opening time (s) that holds the demanded rate.
    #[inline]
    fn held(&mut self, hold: &Hold<R>, rate: R, law_open: R) -> R {
        if !self.demand.is_positive() {
            self.sum = R::ZERO;
            return R::ZERO;
        }
        let lacking = self.demand - rate;
        let sum = self.sum + lacking * self.gait.period;
        self.sum = sum.greater(-hold.most_sum).lesser(hold.most_sum);
        let open = law_open + hold.by_error * lacking + hold.by_sum * self.sum;
        if open < hold.least_open {
            R::ZERO
        } else {
            open.lesser(hold.most_open)
        }
    }

    /// Counts the time for which it stands still.
    #[inline]
    fn stands_still(&mut self, rate: R) -> bool {
        let stall = self.gait.stall;
        if rate.magnitude() >= stall.rate {
            self.still = 0;
            return false;
        }
        self.still = self.still.saturating_add(1);
        let time = count::<R>(self.still) * self.gait.period;
        let stalled = time >= stall.time;
        if stalled && stall.restarts {
            (self.has_fired, self.still) = (false, 0);
        }
        stalled
    }
}

/// `number`, at most 2³¹ − 1, as a number.
#[inline]
#[allow(clippy::cast_possible_wrap)]
pub(super) fn count<R: Real>(number: u32) -> R {
    R::of_count(number.min(0x7FFF_FFFF) as i32)
}
