//! Integration of one smooth phase up to its first event.

use saltus_numeric::dop853::{self, Derivative};
use saltus_numeric::{Scalar, Single};

use crate::StanceError;

/// Numbers in a state: lean, rate, extension, speed, gas, time.
pub(crate) const WIDTH: usize = 6;

/// Components whose error is controlled: all but time.
pub(crate) const CHECKED: usize = 5;

/// A state of the stance: see [`index`].
pub(crate) type State<S> = [S; WIDTH];

/// A state with the gas of a tank: a [`State`], and what [`index`] has beyond it.
pub(crate) type Wide<S> = [S; WIDE];

/// Numbers in a [`Wide`] state.
pub(crate) const WIDE: usize = 13;

/// Its components whose error is controlled; time among them has none, in steps of time.
pub(crate) const WIDE_CHECKED: usize = 9;

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
    /// Mass in the chamber, in the feed's unit; [`GAS`] is then its pressure (MPa).
    pub(crate) const MASS: usize = 6;
    /// Pressure (MPa) of the tank.
    pub(crate) const TANK: usize = 7;
    /// Mass in the tank, in the feed's unit.
    pub(crate) const TANK_MASS: usize = 8;
    /// Mass (kg) gone to the atmosphere, and its enthalpy (J).
    pub(crate) const VENTED: usize = 9;
    pub(crate) const VENTED_HEAT: usize = 10;
    /// Heat (J) from walls, to chamber and tank.
    pub(crate) const HEAT: usize = 11;
    /// Work (J) of the gas.
    pub(crate) const WORK: usize = 12;
}
use index::TIME;

/// A phase of the stance: smooth dynamics in time, and the guards that end it.
pub(crate) trait Phase<S: Single, const W: usize, const M: usize>: Derivative<S, W> {
    /// How many of a state's components, the first ones, have their error controlled.
    const CHECKED: usize;
    /// Everything about a state, in one go.
    fn look(&self, y: &[S; W]) -> Look<S, W, M>;
}

/// What a phase tells of a state.
#[derive(Clone, Copy)]
pub(crate) struct Look<S, const W: usize, const M: usize> {
    /// Derivative of the state in time.
    pub rates: [S; W],
    /// Guards: an event happens where one rises through 0.
    pub guards: [S; M],
    /// Time derivatives of the guards.
    pub guard_rates: [S; M],
}

/// A phase with the value of a guard as independent variable.
struct AlongGuard<'a, P, const W: usize, const M: usize> {
    phase: &'a P,
    guard: usize,
}

impl<S: Single, P: Phase<S, W, M>, const W: usize, const M: usize> Derivative<S, W>
    for AlongGuard<'_, P, W, M>
{
    #[inline(always)]
    fn at(&self, y: &[S; W]) -> [S; W] {
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
pub(crate) const MOST_STEPS: u32 = 10_000;
/// Longest phase (s).
const LONGEST: f64 = 30.0;

/// Progress of an integration that all phases of a jump share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pace {
    /// Length of the next step to try (s).
    pub step: f64,
    /// Error tolerance.
    pub tolerance: f64,
    /// Steps tried so far, and how many may be.
    pub steps: u32,
    pub most: u32,
}

impl Pace {
    /// One step more, at the time `now` (s) of a phase that began at `begin` (s).
    fn begin_step(&mut self, begin: f64, now: f64) -> Result<(), StanceError> {
        if now - begin > LONGEST {
            return Err(StanceError::TooLong { time: now });
        }
        self.count(now)
    }

    /// One step or event more, at the time `now` (s).
    fn count(&mut self, now: f64) -> Result<(), StanceError> {
        self.steps += 1;
        if self.steps > self.most {
            return Err(StanceError::TooManySteps {
                time: now,
                steps: self.most,
            });
        }
        Ok(())
    }
}

/// What sees the state before and after each step.
pub(crate) type Observe<'a, S, const W: usize> = dyn FnMut(&[S; W], &[S; W]) + 'a;

/// Carries `y` through `phase` to its first event, whose number is returned, or to the time `end`
/// (none).
///
/// The step that meets an event takes the guard as independent variable (Hénon 1982), so that it
/// ends on the event to round-off without a search; where that fails, ordinary steps close in until
/// it works. `observe` sees the state before and after each step.
pub(crate) fn advance<S: Single, P: Phase<S, W, M>, const W: usize, const M: usize>(
    phase: &P,
    y: &mut [S; W],
    end: Option<S>,
    pace: &mut Pace,
    observe: &mut Observe<'_, S, W>,
) -> Result<Option<usize>, StanceError> {
    let begin = y[TIME].value();
    let mut here = phase.look(y);
    if let Some(i) = due(&here) {
        // Phases may hand an event of no time to each other.
        pace.count(begin)?;
        return Ok(Some(i));
    }
    let mut armed = armed_at_start(&here);
    loop {
        let left = end.map(|e| e - y[TIME]);
        let longest = left.map_or(f64::INFINITY, Scalar::value);
        if longest <= 0.0 {
            return Ok(None);
        }
        let now = y[TIME].value();
        pace.begin_step(begin, now)?;
        let trial = pace.step.min(longest);
        let foreseen = foresee(&here, &armed, 0.9 * trial);
        if let Some((i, wait)) = foreseen {
            let span = (now, now + longest);
            if let Some(event) = event_within(phase, (y, &here), i, &armed, span, pace) {
                go(y, event, observe);
                pace.step = pace.step.max(wait);
                return Ok(Some(i));
            }
        }
        let length = foreseen.map_or(trial, |(_, wait)| 0.5 * wait);
        check_length(now, length, longest)?;
        // The last step ends on `end` with its derivatives.
        let last = foreseen.is_none() && length >= longest;
        let h = left.filter(|_| last).unwrap_or(S::of(length));
        let (mut next, there, error) = match step(phase, (y, &here), h, &armed, pace) {
            Step::TooLong => continue,
            Step::Whole(next, there, error) => (next, there, error),
            Step::Onto(i, event) => {
                go(y, event, observe);
                return Ok(Some(i));
            }
        };
        if last {
            next[TIME] = end.unwrap_or(next[TIME]);
        }
        go(y, next, observe);
        if !last || length >= pace.step {
            pace.step = length * dop853::step_factor(error);
        }
        let passed = arm(&mut armed, &there);
        if last || passed.is_some() {
            return Ok(passed);
        }
        here = there;
    }
}

/// Goes on to `next`, which `observe` sees.
#[inline(always)]
fn go<S, const W: usize>(y: &mut [S; W], next: [S; W], observe: &mut Observe<'_, S, W>) {
    observe(y, &next);
    *y = next;
}

/// Whether a step of `length` (s) at the time `now` (s) is long enough to come to anything.
fn check_length(now: f64, length: f64, longest: f64) -> Result<(), StanceError> {
    if length < LEAST_STEP && longest > LEAST_STEP {
        return Err(StanceError::StepTooSmall {
            time: now,
            step: length,
        });
    }
    Ok(())
}

/// What came of a step.
enum Step<S, const W: usize, const M: usize> {
    /// No event: the state at its end, what the phase tells of it, and the error.
    Whole([S; W], Look<S, W, M>, f64),
    /// An event, and the state there.
    Onto(usize, [S; W]),
    /// It must be shorter.
    TooLong,
}

/// A step of `h` (s) from `from`, a state and what the phase tells of it. One that must be shorter
/// sets the pace.
#[inline(always)]
fn step<S: Single, P: Phase<S, W, M>, const W: usize, const M: usize>(
    phase: &P,
    (y, here): (&[S; W], &Look<S, W, M>),
    h: S,
    armed: &[bool; M],
    pace: &mut Pace,
) -> Step<S, W, M> {
    let step = dop853::step(phase, y, &here.rates, h, P::CHECKED, pace.tolerance);
    let (next, length) = (step.state, h.value());
    if step.error.is_nan() || step.error > 1.0 {
        pace.step = length * dop853::step_factor(step.error);
        return Step::TooLong;
    }
    let there = phase.look(&next);
    let Some((i, fraction)) = crossing(&here.guards, &there.guards, armed) else {
        return Step::Whole(next, there, step.error);
    };
    let span = (y[TIME].value(), next[TIME].value());
    if let Some(event) = event_within(phase, (&next, &there), i, armed, span, pace) {
        return Step::Onto(i, event);
    }
    pace.step = length * (0.9 * fraction).clamp(0.1, 0.5);
    Step::TooLong
}

/// The guard that is at 0 and rises at the start of a phase: of two events at once, the other one
/// is due now.
#[inline(always)]
fn due<S: Single, const W: usize, const M: usize>(look: &Look<S, W, M>) -> Option<usize> {
    (0..M).find(|&i| {
        let (guard, rate) = (look.guards[i].value(), look.guard_rates[i].value());
        (0.0..=-PASSED).contains(&guard) && rate > STANDING
    })
}

/// The guards that may end a phase from its start: all but the one that was just passed.
#[inline(always)]
fn armed_at_start<S: Single, const W: usize, const M: usize>(look: &Look<S, W, M>) -> [bool; M] {
    std::array::from_fn(|i| {
        let (guard, rate) = (look.guards[i].value(), look.guard_rates[i].value());
        guard < PASSED || (guard < 0.0 && rate > 0.0)
    })
}

/// Arms the guards after a step, up to one that should have been, as it is past 0: that one.
#[inline(always)]
fn arm<S: Single, const W: usize, const M: usize>(
    armed: &mut [bool; M],
    look: &Look<S, W, M>,
) -> Option<usize> {
    for i in 0..M {
        if !armed[i] && look.guards[i].value() >= 0.0 {
            return Some(i);
        }
        armed[i] = true;
    }
    None
}

/// The guard that straight extrapolation brings to 0 first, within `horizon` (s), and when.
#[inline(always)]
fn foresee<S: Single, const W: usize, const M: usize>(
    look: &Look<S, W, M>,
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

/// The state at which guard `i` vanishes, by one step from `from`, a state and what the phase tells
/// of it; none where the step is not accurate, ends before `earliest` or after `latest` (s), or is past
/// another guard.
#[inline(always)]
fn event_within<S: Single, P: Phase<S, W, M>, const W: usize, const M: usize>(
    phase: &P,
    (y, look): (&[S; W], &Look<S, W, M>),
    i: usize,
    armed: &[bool; M],
    (earliest, latest): (f64, f64),
    pace: &Pace,
) -> Option<[S; W]> {
    let event = event_step(phase, y, look, i, pace.tolerance)?;
    if !(earliest..=latest).contains(&event[TIME].value()) {
        return None;
    }
    let guards = phase.look(&event).guards;
    let mut others = (0..M).filter(|&k| k != i && armed[k]);
    (!others.any(|k| guards[k].value() > 0.0)).then_some(event)
}

/// The state at which guard `i` vanishes, by one step along it from `y`, forwards or back; none
/// where the step is not accurate.
fn event_step<S: Single, P: Phase<S, W, M>, const W: usize, const M: usize>(
    phase: &P,
    y: &[S; W],
    look: &Look<S, W, M>,
    i: usize,
    tolerance: f64,
) -> Option<[S; W]> {
    let inverse = S::of(1.0) / look.guard_rates[i];
    let k0 = look.rates.map(|d| d * inverse);
    let along = AlongGuard { phase, guard: i };
    let step = dop853::step(&along, y, &k0, -look.guards[i], P::CHECKED, tolerance);
    (step.error <= 1.0).then_some(step.state)
}
