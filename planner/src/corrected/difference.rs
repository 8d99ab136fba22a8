//! What two models make of one launch, as numbers that change smoothly with the launch.

use saltus_ballistic::{FlightSample, SampledFlight};
use saltus_lagrangian::LiftOff;
use saltus_numeric::Single;

use crate::flight::JumpFlight;
use crate::model::{Instant, Traced};

/// Parts into which a flight or a stance is divided, in time.
const PARTS: usize = 12;

/// Numbers of a lift-off, as [`lift_off`] lists them.
const STANCE: usize = 11;

/// Where the friction stands, the flight's duration, and the numbers of flight and stance.
const FRICTION: usize = STANCE;
const DURATION: usize = FRICTION + 1;
const FLIGHT: usize = DURATION + 1;
const WAY: usize = FLIGHT + KNOT * (PARTS + 1);
const ALL: usize = WAY + KNOT * (PARTS + 1);

/// Numbers of a knot: place (m) and change of place (m) over the whole duration at this velocity.
const KNOT: usize = 4;

/// Which of the numbers show what a jump is worth: all of the flight.
pub(super) const SHOWN: std::ops::Range<usize> = FLIGHT..WAY;

/// A jump in numbers: of two models these can be subtracted.
pub(super) type Account = Vec<f64>;

/// Of a traced jump that comes down to `lowest` (m); none of one that does not.
pub(super) fn account(traced: &Traced, lowest: f64) -> Option<Account> {
    let flight = traced.jump.flight.as_ref()?;
    let duration = flight.time_to_height(lowest).ok()?;
    let stance = &traced.jump.stance;
    let mut numbers = Vec::with_capacity(ALL);
    numbers.extend(lift_off(stance));
    numbers.extend([traced.friction_needed, duration]);
    knots(duration, |t| flight.motion(t), &mut numbers);
    let way = of_instants(&traced.way)?;
    knots(stance.time, |t| way.motion(t), &mut numbers);
    numbers.iter().all(|x| x.is_finite()).then_some(numbers)
}

fn of_instants(way: &[Instant<f64>]) -> Option<SampledFlight<f64>> {
    let sample = |at: &Instant<f64>| FlightSample {
        time: at.time,
        position: at.centre,
        velocity: at.velocity,
    };
    let mut samples: Vec<_> = way.iter().map(sample).collect();
    samples.dedup_by(|b, a| b.time <= a.time);
    SampledFlight::new(samples).ok()
}

fn knots(duration: f64, motion: impl Fn(f64) -> [[f64; 2]; 2], numbers: &mut Account) {
    for k in 0..=PARTS {
        let [place, velocity] = motion(duration * part_ends(k));
        numbers.extend(place);
        numbers.extend(velocity.map(|v| v * duration));
    }
}

fn part_ends(k: usize) -> f64 {
    k as f64 / PARTS as f64
}

fn lift_off<S: Copy>(end: &LiftOff<S>) -> [S; STANCE] {
    let ([x, y], [vx, vy]) = (end.axle, end.axle_rates);
    [
        end.time_fire,
        end.time,
        end.lean,
        end.rate,
        end.extension,
        end.extension_rate,
        end.pressure,
        x,
        y,
        vx,
        vy,
    ]
}

/// What is to be added to the numbers of a jump at one launch.
pub(super) struct Difference<S>(Vec<S>);

impl<S: Single> Difference<S> {
    pub(super) fn new(numbers: Vec<S>) -> Difference<S> {
        debug_assert_eq!(numbers.len(), ALL);
        Difference(numbers)
    }

    /// The same with other derivatives.
    pub(super) fn map<T: Single>(&self, of: impl Fn(S) -> T) -> Difference<T> {
        Difference(self.0.iter().map(|x| of(*x)).collect())
    }

    pub(super) fn extension(&self, extension: S) -> S {
        extension + self.0[4]
    }

    pub(super) fn axle(&self, [x, y]: [S; 2]) -> [S; 2] {
        [x + self.0[7], y + self.0[8]]
    }

    pub(super) fn friction(&self, needed: S) -> S {
        (needed + self.0[FRICTION]).max(S::of(0.0))
    }

    /// The end of a stance, corrected.
    pub(super) fn stance(&self, end: &LiftOff<S>) -> LiftOff<S> {
        self.added(end, S::of(1.0))
    }

    /// The end of a stance as it was before it was corrected.
    pub(super) fn without(&self, end: &LiftOff<S>) -> LiftOff<S> {
        self.added(end, S::of(-1.0))
    }

    fn added(&self, end: &LiftOff<S>, part: S) -> LiftOff<S> {
        let was = lift_off(end);
        let [
            time_fire,
            time,
            lean,
            rate,
            extension,
            extension_rate,
            pressure,
            x,
            y,
            vx,
            vy,
        ] = std::array::from_fn(|k| was[k] + part * self.0[k]);
        LiftOff {
            outcome: end.outcome,
            time_fire,
            time,
            lean,
            rate,
            extension,
            extension_rate,
            pressure,
            axle: [x, y],
            axle_rates: [vx, vy],
        }
    }

    /// `flight`, corrected down to `lowest` (m).
    pub(super) fn flight(&self, flight: &JumpFlight<S>, lowest: f64) -> Option<SampledFlight<S>> {
        let was = flight.time_to_height(S::of(lowest)).ok()?;
        let duration = was + self.0[DURATION];
        let knot = |k: usize| {
            let time = S::of(part_ends(k));
            let [place, velocity] = flight.motion(time * was);
            let add: [S; KNOT] = std::array::from_fn(|i| self.0[FLIGHT + KNOT * k + i]);
            Knot {
                time: time * duration,
                place: [0, 1].map(|i| place[i] + add[i]),
                velocity: [0, 1].map(|i| (velocity[i] * was + add[2 + i]) / duration),
            }
        };
        let knots: Vec<Knot<S>> = (0..=PARTS).map(knot).collect();
        let sample = |k: usize| {
            let (before, after) = (&knots[k.max(1) - 1], &knots[(k + 1).min(PARTS)]);
            let passed = after.time - before.time;
            let change = |i: usize| (after.velocity[i] - before.velocity[i]) / passed;
            knots[k].at_its_time([change(0), change(1)])
        };
        SampledFlight::new((0..=PARTS).map(sample).collect()).ok()
    }

    /// An instant of a stance that lasts for `duration` (s), corrected.
    pub(super) fn instant(&self, at: &Instant<S>, duration: S) -> Instant<S> {
        let share = at.time.value() / duration.value();
        let part = (1..PARTS).rfind(|k| share >= part_ends(*k)).unwrap_or(0);
        let s = S::of(share * PARTS as f64 - part as f64);
        let number = |k: usize, i: usize| self.0[WAY + KNOT * k + i];
        let longer = duration + self.0[1];
        // Hermite's cubic in the part, of value and slope over the whole.
        let add = |i: usize| {
            let (a, b) = (number(part, i), number(part + 1, i));
            let slope = |k: usize| number(k, 2 + i) * S::of(1.0 / PARTS as f64);
            let (da, db) = (slope(part), slope(part + 1));
            let rise = b - a;
            let c2 = S::of(3.0) * rise - S::of(2.0) * da - db;
            let c3 = da + db - S::of(2.0) * rise;
            let value = a + s * (da + s * (c2 + s * c3));
            let change = da + s * (S::of(2.0) * c2 + S::of(3.0) * s * c3);
            [value, change * S::of(PARTS as f64)]
        };
        let added = [add(0), add(1)];
        let velocity = |i: usize| (at.velocity[i] * duration + added[i][1]) / longer;
        Instant {
            time: at.time + S::of(share) * self.0[1],
            centre: [0, 1].map(|i| at.centre[i] + added[i][0]),
            velocity: [velocity(0), velocity(1)],
        }
    }
}

/// A state at a time that has derivatives.
struct Knot<S> {
    time: S,
    place: [S; 2],
    velocity: [S; 2],
}

impl<S: Single> Knot<S> {
    /// With derivatives at a time that stays: a state that comes `late` has not moved on so far.
    fn at_its_time(&self, acceleration: [S; 2]) -> FlightSample<S> {
        let late = self.time - S::of(self.time.value());
        FlightSample {
            time: self.time.value(),
            position: [0, 1].map(|i| self.place[i] - self.velocity[i] * late),
            velocity: [0, 1].map(|i| self.velocity[i] - acceleration[i] * late),
        }
    }
}
