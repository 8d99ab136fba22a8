//! How a stance ends, where its parts lead, and what watches its steps.

use saltus_numeric::{Scalar, Single};
use saltus_pneumatics::MEGA;

use crate::advance::index::{EXTENSION, GAS, LEAN, RATE, SPEED, TIME};
use crate::advance::{State, WIDE, WIDTH, Wide};
use crate::phase::{Drives, Extension, Held};
use crate::{LiftOff, Outcome, Stance};

/// The end of a stance in the state `y`.
///
/// The wheel's centre is at R (sin φ, cos φ) from the foot, R = r_s + d.
pub(crate) fn ended<S: Scalar, const N: usize>(
    stance: &Stance<S>,
    outcome: Outcome,
    time_fire: S,
    y: &[S; N],
) -> LiftOff<S> {
    let reach = stance.radius + y[EXTENSION];
    let (sin, cos) = y[LEAN].sin_cos();
    let (along, across) = (y[SPEED], reach * y[RATE]);
    LiftOff {
        outcome,
        time_fire,
        time: y[TIME],
        lean: y[LEAN],
        rate: y[RATE],
        extension: y[EXTENSION],
        extension_rate: along,
        pressure: y[GAS] * S::of(MEGA),
        axle: [reach * sin, reach * cos],
        axle_rates: [along * sin + across * cos, along * cos - across * sin],
    }
}

/// Where a part of the stance leads.
pub(crate) enum Next<S, const N: usize = WIDTH> {
    /// On to the next part, from this state.
    On([S; N]),
    /// To an end.
    End(Outcome, [S; N]),
}

/// First step (s) tried in a stance.
pub(crate) const FIRST_STEP: f64 = 3e-3;

/// Pieces after which an extension is given up: a leg has a few switches, a measured table as many
/// as it has rows.
pub(crate) const MOST_PIECES: usize = 100_000;

/// What watches the steps of a stance.
pub(crate) trait Observer<S: Single> {
    /// A step in a held phase.
    fn held(&mut self, phase: &Held<'_, S>, from: &State<S>, to: &State<S>);
    /// A step in the extension.
    fn extension(&mut self, phase: &Extension<'_, S>, from: &State<S>, to: &State<S>);
    /// A step of a stance with the gas of a tank.
    fn fed(&mut self, phase: &dyn Drives<S, WIDE>, from: &Wide<S>, to: &Wide<S>);
    /// Whether every part must be stepped through, closed forms left aside.
    fn is_stepwise(&self) -> bool {
        true
    }
}

/// Watches nothing.
pub(crate) struct Unobserved;

impl<S: Single> Observer<S> for Unobserved {
    fn held(&mut self, _: &Held<'_, S>, _: &State<S>, _: &State<S>) {}
    fn extension(&mut self, _: &Extension<'_, S>, _: &State<S>, _: &State<S>) {}
    fn fed(&mut self, _: &dyn Drives<S, WIDE>, _: &Wide<S>, _: &Wide<S>) {}
    fn is_stepwise(&self) -> bool {
        false
    }
}
