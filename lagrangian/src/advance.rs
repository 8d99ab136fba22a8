//! Integration of one smooth phase up to its first event.

use saltus_numeric::dop853::{self, Derivative};
use saltus_numeric::{Scalar, Single};

use crate::StanceError;

/// Numbers in a state: lean, rate, extension, speed, gas, time, and two that round the state up to
/// a SIMD register.
pub(crate) const WIDTH: usize = 8;

/// Components whose error is controlled: all but time.
pub(crate) const CHECKED: usize = 5;

/// A state of the stance: see [`index`].
pub(crate) type State<S> = [S; WIDTH];

/// Where each quantity is in a [`State`].
pub(crate) mod index {
    /// Lean φ (rad).
    pub(crate) const LEAN: usize = 0;
    /// Lean rate ω (rad/s).
    pub(crate) const RATE: usize = 1;
    /// Extension d (m).
    pub(crate) const EXTENSION: usize = 2;
    /// Extension rate ḋ (m/s).
    pub(crate) const SPEED: usize = 3;
    /// The gas, as the variable u of the valve's law: pressure (MPa) or temperature ratio, about 1
    /// both.
    pub(crate) const GAS: usize = 4;
    /// Time (s).
    pub(crate) const TIME: usize = 5;
}
use index::TIME;

/// A phase of the stance: smooth dynamics in time, and the guards that end it.
pub(crate) trait Phase<S: Single, const M: usize>: Derivative<S, WIDTH> {
    /// Everything about a state, in one go.
    fn look(&self, y: &State<S>) -> Look<S, M>;
}

/// What a phase tells of a state.
#[derive(Clone, Copy)]
pub(crate) struct Look<S, const M: usize> {
    /// Derivative of the state in time.
    pub rates: State<S>,
    /// Guards: an event happens where one rises through 0.
    pub guards: [S; M],
    /// Time derivatives of the guards.
    pub guard_rates: [S; M],
}

/// A phase with the value of a guard as independent variable.
struct AlongGuard<'a, P, const M: usize> {
    phase: &'a P,
    guard: usize,
}

impl<S: Single, P: Phase<S, M>, const M: usize> Derivative<S, WIDTH> for AlongGuard<'_, P, M> {
    #[inline(always)]
    fn at(&self, y: &State<S>) -> State<S> {
        let look = self.phase.look(y);
        let inverse = S::of(1.0) / look.guard_rates[self.guard];
        look.rates.map(|d| d * inverse)
    }
}

/// A guard nearer to 0 than this at the start of a phase, and falling, is the one that was just
/// passed.
const PASSED: f64 = -1e-9;
/// A guard that changes by less (1/s) stands still but for round-off.
const STANDING: f64 = 1e-6;
/// Shortest step (s).
const LEAST_STEP: f64 = 1e-13;
/// Most steps of one jump: an ordinary one takes ten to a hundred.
const MOST_STEPS: u32 = 10_000;
/// Longest phase (s).
const LONGEST: f64 = 30.0;

/// Progress of an integration that all phases of a jump share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Length of the next step to try (s).
    pub step: f64,
    /// Error tolerance.
    pub tolerance: f64,
    /// Steps tried so far.
    pub steps: u32,
}

impl Pace {
    /// One step or event more, at the time `now` (s).
    fn count(&mut self, now: f64) -> Result<(), StanceError> {
        self.steps += 1;
        if self.steps > MOST_STEPS {
            return Err(StanceError::TooManySteps {
                time: now,
                steps: MOST_STEPS,
            });
        }
        Ok(())
    }
}

/// Carries `y` through `phase` to its first event, whose number is returned, or to the time `end`
/// (none).
///
/// The step that meets an event takes the guard as independent variable (Hénon 1982), so that it
/// ends on the event to round-off without a search; where that fails, ordinary steps close in until
/// it works. `observe` sees the state before and after each step.
pub(crate) fn advance<S: Single, P: Phase<S, M>, const M: usize>(
    phase: &P,
    y: &mut State<S>,
    end: Option<S>,
    pace: &mut Pace,
    observe: &mut impl FnMut(&State<S>, &State<S>),
) -> Result<Option<usize>, StanceError> {
    let begin = y[TIME].value();
    let mut here = phase.look(y);
    let mut armed: [bool; M] = std::array::from_fn(|i| {
        let (guard, rate) = (here.guards[i].value(), here.guard_rates[i].value());
        guard < PASSED || (guard < 0.0 && rate > 0.0)
    });
    // Two events at once: the other one is due now.
    let due = |i: &usize| {
        let (guard, rate) = (here.guards[*i].value(), here.guard_rates[*i].value());
        (0.0..=-PASSED).contains(&guard) && rate > STANDING
    };
    if let Some(i) = (0..M).find(due) {
        // Phases may hand an event of no time to each other.
        pace.count(begin)?;
        return Ok(Some(i));
    }
    loop {
        let left = end.map(|e| e - y[TIME]);
        let longest = left.map_or(f64::INFINITY, Scalar::value);
        if longest <= 0.0 {
            return Ok(None);
        }
        let now = y[TIME].value();
        if now - begin > LONGEST {
            return Err(StanceError::TooLong { time: now });
        }
        pace.count(now)?;
        let trial = pace.step.min(longest);
        let foreseen = foresee(&here, &armed, 0.9 * trial);
        let mut length = trial;
        if let Some((i, wait)) = foreseen {
            let reached = event_step(phase, y, &here, i, pace.tolerance);
            if let Some(next) = reached.filter(|next| {
                let time = next[TIME].value();
                time >= now
                    && time <= now + longest
                    && first_passed(phase, next, &armed, i).is_none()
            }) {
                observe(y, &next);
                *y = next;
                pace.step = pace.step.max(wait);
                return Ok(Some(i));
            }
            length = 0.5 * wait;
        }
        if length < LEAST_STEP && longest > LEAST_STEP {
            return Err(StanceError::StepTooSmall {
                time: now,
                step: length,
            });
        }
        // The last step ends on `end` with its derivatives.
        let last = foreseen.is_none() && length >= longest;
        let h = if last {
            left.unwrap_or(S::of(length))
        } else {
            S::of(length)
        };
        let step = dop853::step(phase, y, &here.rates, h, CHECKED, pace.tolerance);
        if step.error.is_nan() || step.error > 1.0 {
            pace.step = length * dop853::step_factor(step.error);
            continue;
        }
        let mut next = step.state;
        let there = phase.look(&next);
        let crossed = crossing(&here.guards, &there.guards, &armed);
        if let Some((i, fraction)) = crossed {
            if let Some(event) =
                event_step(phase, &next, &there, i, pace.tolerance).filter(|event| {
                    let time = event[TIME].value();
                    time >= now
                        && time <= next[TIME].value()
                        && first_passed(phase, event, &armed, i).is_none()
                })
            {
                observe(y, &event);
                *y = event;
                return Ok(Some(i));
            }
            pace.step = length * (0.9 * fraction).clamp(0.1, 0.5);
            continue;
        }
        if last {
            next[TIME] = end.unwrap_or(next[TIME]);
        }
        observe(y, &next);
        *y = next;
        if !last || length >= pace.step {
            pace.step = length * dop853::step_factor(step.error);
        }
        for i in 0..M {
            if !armed[i] && there.guards[i].value() >= 0.0 {
                return Ok(Some(i));
            }
            armed[i] = true;
        }
        if last {
            return Ok(None);
        }
        here = there;
    }
}

/// The guard that straight extrapolation brings to 0 first, within `horizon` (s), and when.
#[inline(always)]
fn foresee<S: Single, const M: usize>(
    look: &Look<S, M>,
    armed: &[bool; M],
    horizon: f64,
) -> Option<(usize, f64)> {
    let mut first = None;
    let mut soonest = horizon;
    for i in 0..M {
        let (g, rate) = (look.guards[i].value(), look.guard_rates[i].value());
        if armed[i] && g < 0.0 && -g < rate * soonest {
            soonest = -g / rate;
            first = Some((i, soonest));
        }
    }
    first
}

/// The guard that rose through 0 between two states, the earliest by straight interpolation, and at
/// which fraction.
#[inline(always)]
fn crossing<S: Single, const M: usize>(
    before: &[S; M],
    after: &[S; M],
    armed: &[bool; M],
) -> Option<(usize, f64)> {
    let mut first: Option<(usize, f64)> = None;
    for i in 0..M {
        let (a, b) = (before[i].value(), after[i].value());
        if armed[i] && a < 0.0 && b >= 0.0 {
            let fraction = a / (a - b);
            if first.is_none_or(|(_, f)| fraction < f) {
                first = Some((i, fraction));
            }
        }
    }
    first
}

/// Another guard than `event` that is positive at `y`.
#[inline(always)]
fn first_passed<S: Single, P: Phase<S, M>, const M: usize>(
    phase: &P,
    y: &State<S>,
    armed: &[bool; M],
    event: usize,
) -> Option<usize> {
    let guards = phase.look(y).guards;
    (0..M).find(|&i| i != event && armed[i] && guards[i].value() > 0.0)
}

/// The state at which guard `i` vanishes, by one step along it from `y`, forwards or back; none
/// where the step is not accurate.
fn event_step<S: Single, P: Phase<S, M>, const M: usize>(
    phase: &P,
    y: &State<S>,
    look: &Look<S, M>,
    i: usize,
    tolerance: f64,
) -> Option<State<S>> {
    let inverse = S::of(1.0) / look.guard_rates[i];
    let k0 = look.rates.map(|d| d * inverse);
    let along = AlongGuard { phase, guard: i };
    let step = dop853::step(&along, y, &k0, -look.guards[i], CHECKED, tolerance);
    (step.error <= 1.0).then_some(step.state)
}
