//! What the foot asks of the ground along a stance, at the price of little more than the stance.

use saltus_numeric::Single;
use saltus_numeric::dop853::{self, Derivative};

use crate::advance::index::TIME;
use crate::advance::{CHECKED, State, WIDE, Wide};
use crate::observer::Observer;
use crate::phase::{Drives, Extension, Held};
use crate::{Launch, LiftOff, Reaction, Stance, StanceError};

/// What the foot asks of the ground along a stance.
#[derive(Clone, Copy, Debug)]
pub struct Contact<S = f64> {
    /// Least normal force (N); where it is negative the foot would have left the ground.
    pub least_normal: S,
    /// When it occurs (s).
    pub least_normal_time: f64,
    /// Greatest |friction/normal|: the friction coefficient that the stance needs; infinite where
    /// the normal force reaches 0.
    pub friction_needed: S,
    /// When it occurs (s).
    pub friction_needed_time: f64,
}

/// Time (s) over which the slope of a measure is taken.
const MOMENT: f64 = 1e-7;

/// Looks at an extreme within a step: the value is then right to about 1e-9.
const LOOKS: usize = 4;

impl<S: Single> Stance<S> {
    /// As [`Stance::contact`], which stands for each kind of number.
    pub(crate) fn with_contact(
        &self,
        launch: &Launch<S>,
    ) -> Result<(LiftOff<S>, Contact<S>), StanceError> {
        let mut watch = Watch {
            stance: self,
            contact: Contact::none(),
        };
        let lift_off = self.run(launch, &mut watch)?;
        Ok((lift_off, watch.contact))
    }
}

/// Keeps the extremes of the contact.
struct Watch<'a, S: Single> {
    stance: &'a Stance<S>,
    contact: Contact<S>,
}

impl<S: Single> Observer<S> for Watch<'_, S> {
    fn held(&mut self, phase: &Held<'_, S>, from: &State<S>, to: &State<S>) {
        self.step(phase, from, to);
    }
    fn extension(&mut self, phase: &Extension<'_, S>, from: &State<S>, to: &State<S>) {
        self.step(phase, from, to);
    }
    fn fed(&mut self, phase: &dyn Drives<S, WIDE>, from: &Wide<S>, to: &Wide<S>) {
        self.step(phase, from, to);
    }
}

impl<S: Single> Watch<'_, S> {
    /// Takes in the step of `phase` between two states. A state inside a step is a shorter step.
    fn step<const W: usize>(&mut self, phase: &dyn Derivative<S, W>, from: &[S; W], to: &[S; W]) {
        let rates = phase.at(from);
        let length = to[TIME] - from[TIME];
        let (first, last) = (
            self.around(phase, from, MOMENT),
            self.around(phase, to, -MOMENT),
        );
        self.keep(from, &first);
        self.keep(to, &last);
        for measure in [|r: &Reaction<S>| -r.normal.value(), Reaction::demand] {
            let slope = |around: &Around<S>| around.slope(measure);
            let (mut a, mut b) = ((0.0, slope(&first)), (1.0, slope(&last)));
            if !(a.1 > 0.0 && b.1 < 0.0) {
                continue;
            }
            for _ in 0..LOOKS {
                let fraction = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
                let h = length * S::of(fraction);
                let y = dop853::step(phase, from, &rates, h, CHECKED, self.stance.tolerance).state;
                let here = self.around(phase, &y, MOMENT);
                self.keep(&y, &here);
                // An end that stays counts half, so that it does not stay for long (the Illinois
                // rule).
                if slope(&here) > 0.0 {
                    (a, b) = ((fraction, slope(&here)), (b.0, 0.5 * b.1));
                } else {
                    (a, b) = ((a.0, 0.5 * a.1), (fraction, slope(&here)));
                }
            }
        }
    }

    fn keep<const W: usize>(&mut self, y: &[S; W], around: &Around<S>) {
        self.contact.extend(y[TIME].value(), &around.here);
    }

    /// The reaction at `y` and a `moment` (s) later.
    fn around<const W: usize>(
        &self,
        phase: &dyn Derivative<S, W>,
        y: &[S; W],
        moment: f64,
    ) -> Around<S> {
        let rates = phase.at(y);
        let mut near = *y;
        for (near, rate) in near.iter_mut().zip(&rates) {
            *near = S::of(moment).mul_add(*rate, *near);
        }
        let reaction = |y, rates| self.stance.reaction(y, rates);
        Around {
            here: reaction(y, &rates),
            near: reaction(&near, &phase.at(&near)),
            moment,
        }
    }
}

/// The reaction at an instant and a moment (s) later.
struct Around<S> {
    here: Reaction<S>,
    near: Reaction<S>,
    moment: f64,
}

impl<S> Around<S> {
    fn slope(&self, measure: fn(&Reaction<S>) -> f64) -> f64 {
        (measure(&self.near) - measure(&self.here)) / self.moment
    }
}

impl<S: Single> Contact<S> {
    /// Of nothing yet.
    pub(crate) fn none() -> Self {
        Contact {
            least_normal: S::of(f64::NAN),
            least_normal_time: f64::NAN,
            friction_needed: S::of(f64::NAN),
            friction_needed_time: f64::NAN,
        }
    }

    /// Takes in the reaction at `time` (s).
    pub(crate) fn extend(&mut self, time: f64, reaction: &Reaction<S>) {
        let is_first = self.least_normal_time.is_nan();
        if is_first || reaction.normal.value() < self.least_normal.value() {
            (self.least_normal, self.least_normal_time) = (reaction.normal, time);
        }
        if is_first || reaction.demand() > self.friction_needed.value() {
            (self.friction_needed, self.friction_needed_time) =
                (reaction.friction_coefficient(), time);
        }
    }
}

impl<S: Single> Reaction<S> {
    /// |friction/normal|: the friction coefficient that keeps the foot still; infinite where the ground would have to
    /// pull.
    pub fn demand(&self) -> f64 {
        let (n, t) = (self.normal.value(), self.friction.value());
        if n > 0.0 {
            (t / n).abs()
        } else {
            f64::INFINITY
        }
    }

    /// [`demand`](Self::demand) with its derivatives.
    fn friction_coefficient(&self) -> S {
        if self.normal.value() > 0.0 {
            (self.friction / self.normal).abs()
        } else {
            S::of(f64::INFINITY)
        }
    }
}

#[cfg(test)]
mod tests {
    use saltus_numeric::{Dual, Scalar};
    use saltus_robot::Robot;

    use super::*;

    const CASES: [[f64; 4]; 6] = [
        [5.0, -0.1, -0.1, 0.1],
        [5.0, 0.02, 0.02, 0.048],
        [5.0, -0.35, -0.1, 0.03],
        [3.0, -0.2, -0.2, 0.05],
        [6.0, 0.1, 0.1, 0.02],
        [4.0, -0.35, 0.05, 0.08],
    ];

    fn launch<S: Scalar>([rate, lean, firing_angle, valve_open]: [S; 4]) -> Launch<S> {
        Launch {
            rate,
            lean,
            firing_angle,
            valve_open,
        }
    }

    #[test]
    fn the_contact_is_that_of_the_trace() {
        let stance = Stance::new(&Robot::rats_planar(), |_, x| x);
        for case in CASES {
            let (_, contact) = stance.contact(&launch(case)).expect("a legal launch");
            let fine = stance.trace(&launch(case)).expect("a legal launch").contact;
            // The error goes as the square of the last look's distance from the extreme.
            assert!(
                (contact.least_normal - fine.least_normal).abs() < 1e-5,
                "{case:?}: {contact:?} {fine:?}"
            );
            assert!(
                (contact.friction_needed - fine.friction_needed).abs() < 1e-8
                    || contact.friction_needed == fine.friction_needed,
                "{case:?}: {contact:?} {fine:?}"
            );
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        let (plain, dual) = (
            Stance::new(&Robot::rats_planar(), |_, x| x),
            Stance::<Dual<2>>::new(&Robot::rats_planar(), |_, x| Dual::of(x)),
        );
        let mut tried = 0;
        for [rate, _, angle, open] in CASES {
            let (x, y) = (Dual::variable(angle, 0), Dual::variable(open, 1));
            let (_, contact) = dual
                .contact(&launch([Dual::of(rate), x, x, y]))
                .expect("a legal launch");
            if contact.friction_needed.value.is_infinite() {
                continue;
            }
            tried += 1;
            let needed = |angle: f64, open: f64| {
                let trace = plain
                    .trace(&launch([rate, angle, angle, open]))
                    .expect("a legal launch");
                trace.contact.friction_needed
            };
            // Central differences: half the digits of a stance, and the curvature of the extreme.
            let h = 1e-5;
            let by_angle = (needed(angle + h, open) - needed(angle - h, open)) / (2.0 * h);
            let by_open = (needed(angle, open + h) - needed(angle, open - h)) / (2.0 * h);
            for (got, wanted) in contact
                .friction_needed
                .slope
                .into_iter()
                .zip([by_angle, by_open])
            {
                assert!(
                    (got - wanted).abs() < 1e-4 * (1.0 + wanted.abs()),
                    "{angle} {open}: {got} {wanted}"
                );
            }
        }
        assert!(tried >= 4, "{tried}");
    }
}
