//! The state machine of a run.

use core::ops::RangeInclusive;

use super::ahead::{Ahead, Choice, Sight};
use super::law::NEVER;
use super::{Instruments, Law, MOST_TAPS, Readings, Signals};
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
    /// How a demanded speed is held, in place of what the law gives by itself.
    pub hold: Option<Hold<R>>,
    /// When a robot that stands still is started anew.
    pub stall: Stall<R>,
    /// Firing angle (rad) and valve opening time (s) of the first firings, before the law; again
    /// after a turn, and after a stall if that restarts.
    pub first: &'a [[R; 2]],
    /// A jump out of the run; none where `first` says that firing.
    pub leap: Option<Leap<R>>,
    /// What is done about an obstacle that is sensed.
    pub ahead: Option<Ahead<'a, R>>,
}

/// Legs of a robot that runs.
pub(super) const LEGS: RangeInclusive<u32> = 3..=12;

/// How far (rad) behind its zone a leg leaves it: more than round-off, so that a count on the border
/// of two zones is in one of them alone, and less than a count.
const BACK: f64 = 1e-5;

/// A jump out of a run: a firing whose angle follows from the rate at the touch-down of its leg,
/// α_f = A ω + B. It is measured once the filter has forgotten the shock; until then it is the rate
/// now. No [`Hold`] changes that angle.
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
    /// Least firing angle (rad).
    pub least: R,
    /// The greatest (rad).
    pub most: R,
    /// Valve opening time (s).
    pub valve_open: R,
    /// Greater component of the coarse accelerometer's reading (counts) from which a foot has come
    /// down; with 0 or less, none is ever felt.
    pub shock: i32,
}

/// How a demanded speed is held: a law of lines is then one over the demanded speed (m/s), and the
/// firing angle is trimmed by what is lacking, down to the beginning of the zone. A leg that fires
/// sooner drives faster. Where no speed is demanded, no leg fires.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hold<R> {
    /// Way forwards (m) for a count of the radius encoder; negative if it counts backwards.
    pub way: R,
    /// Part of the measured speed that a cycle renews: the period over the time of its mean.
    pub renewed: R,
    /// Most (m/s) by which the speed that is asked of the law is above the measured one: from rest the
    /// law is gone through.
    pub ahead: R,
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

/// What a robot does about the obstacle ahead.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// It runs towards it.
    Approaches,
    /// It jumps over it.
    Leaps,
    /// It runs away from it, to have room to run up.
    BacksOff,
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
    /// Cycles for which it has stood still.
    still: u32,
    /// Demanded speed (m/s), positive forwards, negative backwards.
    demand: R,
    /// What has been lacking (m), and the measured speed (m/s), in the direction of the run; the last
    /// count of the radius.
    sum: R,
    speed: R,
    last_radius: Option<i32>,
    /// Firings since the start, the last turn or the last restart.
    firings: u32,
    /// Cycles since the last shock, `u32::MAX` without one, and the rate (rad/s) measured after it, in
    /// the direction of the run.
    since_shock: u32,
    touched: Option<R>,
    /// How far the obstacle ahead is, what the leg in the zone does about it, and what the robot does.
    sight: Sight<R>,
    choice: Option<Choice<R>>,
    stage: Stage,
    /// Count of the pivot encoder in the first cycle.
    stands_at: Option<i32>,
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
            still: 0,
            demand: R::ZERO,
            sum: R::ZERO,
            speed: R::ZERO,
            last_radius: None,
            firings: 0,
            since_shock: u32::MAX,
            touched: None,
            sight: Sight::NOTHING,
            choice: None,
            stage: Stage::Approaches,
            stands_at: None,
        };
        if !forwards {
            runner.turn_round(wheel);
        }
        runner
    }

    /// The speed to hold (m/s), positive forwards and negative backwards, however the robot was
    /// started; 0, or what is not a number, lets no leg fire. With a speed opposite to that of the run
    /// no leg fires until the robot stands still, which turns it round. Without [`Gait::hold`] a
    /// demand means nothing.
    pub fn demand(&mut self, speed: R) {
        self.demand = speed;
    }

    /// What the range sensor says before the next [`step`](Runner::step): the distance (m) from the axle
    /// to the front of the next obstacle, in the direction of the run. What is not a positive number
    /// is no reading. Without [`Gait::ahead`] it means nothing.
    pub fn sense(&mut self, distance: R) {
        self.sight.sense(distance);
    }

    /// Runs the other way from now on, the wheel's encoder being at `wheel`: legs and leans are
    /// mirrored.
    ///
    /// Counts and angles only change their signs, so that nothing is lost however often it turns.
    pub fn turn_round(&mut self, wheel: i32) {
        (self.sight, self.stage) = (Sight::NOTHING, Stage::Approaches);
        self.mirror(wheel);
    }

    /// Legs and leans are mirrored from now on.
    fn mirror(&mut self, wheel: i32) {
        self.offset = -self.offset;
        self.direction = self.direction.wrapping_neg();
        // Leg k of now is leg n − k then; as legs are counted from 0 to n − 1, a turn lies between.
        if self.leg != 0 {
            self.leg = self.gait.legs.wrapping_sub(self.leg);
            self.base = self.base.wrapping_sub(self.turn());
        }
        self.has_fired = false;
        (self.sum, self.speed) = (R::ZERO, R::ZERO);
        self.begin_anew();
        self.choice = None;
        self.enters = true;
        self.find_leg(wheel);
    }

    /// Firings count from 0 again, no foot has come down since, and no jump is under way.
    #[inline]
    fn begin_anew(&mut self) {
        self.firings = 0;
        (self.since_shock, self.touched) = (u32::MAX, None);
        self.end_leap();
    }

    /// No jump is under way.
    #[inline]
    fn end_leap(&mut self) {
        if self.stage == Stage::Leaps {
            self.stage = Stage::Approaches;
        }
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
        let distance = self.look(readings);
        let lean = self.find_leg(readings.wheel);
        let rate = self.signals.rate(readings) * R::of_count(self.direction);
        if self.enters {
            self.enters = false;
            self.choice = self.choose(rate, distance, readings.pivot);
        }
        let time = count::<R>(self.cycles) * self.gait.period;
        self.cycles = self.cycles.saturating_add(1);
        self.feel(readings, rate);
        // First, so that a restart begins with the first firings.
        let stalled = self.stands_still(rate);
        let has_room = self.has_room(distance);
        let held = self.gait.hold.map(|hold| self.held(&hold, readings.radius));
        let [firing_angle, valve_open] = match (held, self.leaps(rate)) {
            (Some(None), _) => [R::of(NEVER), R::ZERO],
            (_, Some(firing)) => firing,
            (_, None) if self.stage == Stage::Leaps || has_room => [R::of(NEVER), R::ZERO],
            (None, None) => self.next_firing(time, rate),
            (Some(Some(_)), None) if self.choice.is_some() => self.next_firing(time, rate),
            (Some(Some([demand, later])), None) => {
                let [angle, open] = self.next_firing(time, demand);
                [(angle + later).greater(self.gait.zone), open]
            }
        };
        let in_zone = self.name(self.leg);
        let fires = !self.has_fired && lean >= firing_angle && valve_open.is_positive();
        if fires {
            self.has_fired = true;
            self.firings = self.firings.saturating_add(1);
            self.touched = None;
            if self.choice.is_some_and(|choice| choice.leaps) {
                self.stage = Stage::Leaps;
            }
        }
        let is_opposite = self.demand * R::of_count(self.direction) < R::ZERO;
        if stalled && held.is_some() && is_opposite {
            self.turn_round(readings.wheel);
        } else if stalled && has_room {
            self.stage = Stage::Approaches;
            self.mirror(readings.wheel);
        }
        Action {
            leg: fires.then_some(in_zone),
            valve_open: if fires { valve_open } else { R::ZERO },
            in_zone,
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
        let length = forward.unsigned_abs().max(up.unsigned_abs());
        if leap.shock > 0 && length >= leap.shock.unsigned_abs() {
            self.since_shock = 0;
        } else {
            self.since_shock = self.since_shock.saturating_add(1);
        }
        if self.since_shock as usize == self.gait.taps.len().min(MOST_TAPS) {
            self.touched = Some(rate);
        }
    }

    /// Firing angle (rad) and valve opening time (s) of the leap, if the next firing is it.
    #[inline]
    fn leaps(&self, rate: R) -> Option<[R; 2]> {
        let leap = self.gait.leap.as_ref()?;
        if leap.after != self.firings || self.gait.first.len() > self.firings as usize {
            return None;
        }
        let angle = leap.slope * self.touched.unwrap_or(rate) + leap.level;
        Some([angle.greater(leap.least).lesser(leap.most), leap.valve_open])
    }

    /// Firing angle (rad) and valve opening time (s) of the next firing, unless it is the leap: for the
    /// obstacle ahead, one of the first, or by the law at `rate`.
    #[inline]
    fn next_firing(&self, time: R, rate: R) -> [R; 2] {
        match (self.choice, self.gait.first.get(self.firings as usize)) {
            (Some(choice), _) => choice.firing,
            (None, Some(first)) => *first,
            (None, None) => self.gait.law.at(time, rate),
        }
    }

    /// The distance (m) to the obstacle ahead in this cycle. A jump over it ends once it is behind; a
    /// robot at rest that has too little room turns away from it.
    #[inline]
    fn look(&mut self, readings: &Readings) -> Option<R> {
        let ahead = self.gait.ahead.as_ref()?;
        self.stands_at.get_or_insert(readings.pivot);
        let towards = if self.stage == Stage::BacksOff {
            self.direction.wrapping_neg()
        } else {
            self.direction
        };
        let distance = self.sight.look(ahead, readings.radius, towards);
        let is_near = distance.is_some_and(|distance| distance < ahead.room);
        if distance.is_none() {
            self.end_leap();
        }
        let is_at_rest = self.firings == 0 && self.gait.hold.is_none();
        if is_near && is_at_rest && self.stage != Stage::BacksOff {
            self.stage = Stage::BacksOff;
            self.mirror(readings.wheel);
        }
        distance
    }

    /// Whether it has run far enough away from the obstacle at `distance` (m).
    #[inline]
    fn has_room(&self, distance: Option<R>) -> bool {
        let is_far = |ahead: &Ahead<'_, R>| distance.is_none_or(|d| d >= ahead.room);
        self.stage == Stage::BacksOff && self.gait.ahead.as_ref().is_some_and(is_far)
    }

    /// What the leg that enters the zone at `rate` (rad/s) does about the obstacle at `distance` (m).
    #[inline]
    fn choose(&self, rate: R, distance: Option<R>, pivot: i32) -> Option<Choice<R>> {
        if self.stage == Stage::BacksOff {
            return None;
        }
        let ahead = self.gait.ahead.as_ref()?;
        let counts = pivot.wrapping_sub(self.stands_at.unwrap_or(pivot));
        ahead.choice(rate, R::of_count(counts) * ahead.climb, distance?)
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
        if lacking > hold.ahead {
            self.sum = R::ZERO;
            return Some([self.speed + hold.ahead, R::ZERO]);
        }
        let sum = self.sum + lacking * self.gait.period;
        self.sum = sum.greater(-hold.most_sum).lesser(hold.most_sum);
        Some([demand, -(hold.by_error * lacking + hold.by_sum * self.sum)])
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
            self.begin_anew();
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
