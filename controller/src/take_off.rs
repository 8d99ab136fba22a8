//! Where to take off while running.

use crate::{Controller, Linear, Real, Reason};

/// Touch-downs that are looked at; where all of them are too far from the obstacle, the answer is
/// [`Reason::AskLater`].
pub const MOST_TOUCH_DOWNS: u32 = 4;

/// A running robot before an obstacle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach<R> {
    /// From the next touch-down's foot to the obstacle's front (m), as sensed.
    pub distance: R,
    /// The obstacle's height (m), as sensed, ≥ 0.
    pub height: R,
    /// Its length along the travel (m), > 0.
    pub length: R,
    /// Running speed of the axle (m/s).
    pub speed: R,
    /// Least distance to keep (m) between the wheel and the obstacle, ≥ 0, and from its back to the
    /// landing.
    pub clearance: R,
}

/// Where and how to take off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TakeOff<R> {
    /// From which touch-down: 0 is the next.
    pub touch_down: u32,
    /// Approach rate (rad/s): v/r_s, counted where [`Rates`](crate::Rates) says.
    pub approach_rate: R,
    /// Firing angle α_f (rad).
    pub firing_angle: R,
    /// From that touch-down's foot to the landing (m).
    pub distance: R,
    /// What the jump keeps (m) of the obstacle, at least what was asked for.
    pub clearance: R,
}

impl<R: Real> Approach<R> {
    /// The first input that is no measurement.
    fn wrong(&self) -> Option<Input> {
        let Approach {
            distance,
            height,
            length,
            speed,
            clearance,
        } = *self;
        let sound = [
            (Input::Distance, distance.is_finite()),
            (
                Input::Height,
                height.is_finite() && height.is_at_least_zero(),
            ),
            (Input::Length, length.is_finite() && length.is_positive()),
            (Input::Speed, speed.is_finite()),
            (
                Input::Clearance,
                clearance.is_finite() && clearance.is_at_least_zero(),
            ),
        ];
        sound
            .into_iter()
            .find(|(_, holds)| !holds)
            .map(|(input, _)| input)
    }
}

/// Why there is no take-off, and which input is to blame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoTakeOff {
    /// Why.
    pub reason: Reason,
    /// Which input: the one that is no measurement or lies outside, the distance where the obstacle
    /// is too near or too far yet; none where no jump from any touch-down clears the obstacle.
    pub input: Option<Input>,
}

/// A number of an [`Approach`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Input {
    /// [`Approach::distance`].
    Distance = 1,
    /// [`Approach::height`].
    Height = 2,
    /// [`Approach::length`].
    Length = 3,
    /// [`Approach::speed`].
    Speed = 4,
    /// [`Approach::clearance`].
    Clearance = 5,
}

impl NoTakeOff {
    const fn by(reason: Reason, input: Input) -> NoTakeOff {
        NoTakeOff {
            reason,
            input: Some(input),
        }
    }
}

/// Angles looked at over the map's range, and then by golden section about the best of them.
const LOOKS: usize = 9;
const SECTIONS: usize = 9;

impl<R: Real> Controller<'_, R> {
    /// From which of the coming touch-downs to jump over what is ahead, and at which angle: the one
    /// that keeps most clear.
    ///
    /// A jump's margin is the least of its clearances over both corners and of its landing's
    /// distance beyond the back. For one touch-down it first rises and then falls with the firing
    /// angle, so that it is looked at on 9 angles and by golden section about the best: 20 jumps
    /// for each of 4 touch-downs at most.
    ///
    /// # Errors
    /// [`NoTakeOff`]: [`Reason::SensorInvalid`] for an input that is no measurement; [`Reason::OutOfTable`] for a speed that the tables do not
    /// hold; [`Reason::AskLater`] if the obstacle is farther than the coming touch-downs reach, so
    /// that the next touch-down is the time to ask again; [`Reason::Infeasible`] if no jump clears
    /// it, or, with the input [`Input::Distance`], if it is so near that the wheel would stand
    /// against it.
    pub fn take_off(&self, approach: &Approach<R>) -> Result<TakeOff<R>, NoTakeOff> {
        let Approach {
            distance,
            clearance,
            ..
        } = *approach;
        if let Some(input) = approach.wrong() {
            return Err(NoTakeOff::by(Reason::SensorInvalid, input));
        }
        let rate = approach.speed / self.robot.radius;
        if !rate.within(self.rates.least, self.rates.greatest) {
            return Err(NoTakeOff::by(Reason::OutOfTable, Input::Speed));
        }
        // Nearer, the wheel would stand against it.
        let nearest = self.robot.radius + clearance;
        let stands_clear = |front: R| front >= nearest;
        if !stands_clear(distance) {
            return Err(NoTakeOff::by(Reason::Infeasible, Input::Distance));
        }
        let mut best: Option<TakeOff<R>> = None;
        let mut front = distance;
        for touch_down in 0..MOST_TOUCH_DOWNS {
            if !stands_clear(front) {
                break;
            }
            if let Some(found) = self.best_over(rate, front, approach)
                && best.is_none_or(|b| found.clearance > b.clearance)
            {
                best = Some(TakeOff {
                    touch_down,
                    ..found
                });
            }
            front = front - self.robot.stride;
        }
        match best {
            Some(best) if best.clearance >= clearance => Ok(best),
            // A touch-down to come is nearer than all these.
            _ if stands_clear(front) => Err(NoTakeOff::by(Reason::AskLater, Input::Distance)),
            _ => Err(NoTakeOff {
                reason: Reason::Infeasible,
                input: None,
            }),
        }
    }

    /// The jump that keeps most clear of an obstacle whose front is `front` (m) from the foot; none
    /// where no angle jumps.
    fn best_over(&self, rate: R, front: R, approach: &Approach<R>) -> Option<TakeOff<R>> {
        let axis = &self.map.angles;
        let step = (axis.last - axis.first) / R::of_index(LOOKS - 1);
        let mut best: Option<TakeOff<R>> = None;
        for k in 0..LOOKS {
            let angle = if k + 1 == LOOKS {
                axis.last
            } else {
                axis.first + R::of_index(k) * step
            };
            best = better(best, self.jump_over(rate, angle, front, approach));
        }
        let middle = best?.firing_angle;
        let (mut a, mut b) = (
            (middle - step).greater(axis.first),
            (middle + step).lesser(axis.last),
        );
        let part = R::of(0.38196602);
        let (mut p, mut q) = (a + part * (b - a), b - part * (b - a));
        let mut at_p = self.jump_over(rate, p, front, approach);
        let mut at_q = self.jump_over(rate, q, front, approach);
        for _ in 0..SECTIONS {
            best = better(best, at_p);
            best = better(best, at_q);
            if margin(at_p) > margin(at_q) {
                b = q;
                (q, at_q) = (p, at_p);
                p = a + part * (b - a);
                at_p = self.jump_over(rate, p, front, approach);
            } else {
                a = p;
                (p, at_p) = (q, at_q);
                q = b - part * (b - a);
                at_q = self.jump_over(rate, q, front, approach);
            }
        }
        better(better(best, at_p), at_q)
    }

    /// The jump at one angle.
    #[inline]
    fn jump_over(&self, rate: R, angle: R, front: R, approach: &Approach<R>) -> Option<TakeOff<R>> {
        let (g, back) = (self.robot.gravity, front + approach.length);
        let lift_off = self.map.at(self.reference_rate(rate, angle), angle).ok()?;
        let landing = lift_off.landing(g, self.robot.radius).ok()?.value;
        let [over_front, over_back] = lift_off
            .distances_to(g, [front, back], approach.height)
            .map(|Linear { value, .. }| value - self.robot.radius);
        let clearance = (landing - back).lesser(over_front).lesser(over_back);
        Some(TakeOff {
            touch_down: 0,
            approach_rate: rate,
            firing_angle: angle,
            distance: landing,
            clearance,
        })
    }
}

/// What a jump keeps clear; less than any for none.
#[inline]
fn margin<R: Real>(jump: Option<TakeOff<R>>) -> R {
    match jump {
        Some(jump) if jump.clearance.is_finite() => jump.clearance,
        _ => R::of(-1e30),
    }
}

/// The jump that keeps more clear, the first where they are equal.
#[inline]
fn better<R: Real>(first: Option<TakeOff<R>>, second: Option<TakeOff<R>>) -> Option<TakeOff<R>> {
    if margin(second) > margin(first) {
        second
    } else {
        first
    }
}
