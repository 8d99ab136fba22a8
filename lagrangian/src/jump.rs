//! One stance from its start to lift-off: the phases in their order.

use saltus_numeric::{Scalar, Single};
use saltus_pneumatics::{Chamber, Drive, Flow, MEGA, Piece, Switches};

use crate::advance::index::{GAS, LEAN, RATE, SPEED, TIME};
use crate::advance::{MOST_STEPS, Pace, State, WIDTH, advance};
use crate::observer::{FIRST_STEP, MOST_PIECES, Next, Observer, ended};
use crate::phase::{Extension, Held};
use crate::stance;
use crate::{Launch, LiftOff, Outcome, Stance, StanceError};

impl<S: Single> Stance<S> {
    pub(crate) fn run(
        &self,
        launch: &Launch<S>,
        observer: &mut dyn Observer<S>,
    ) -> Result<LiftOff<S>, StanceError> {
        stance::check(launch)?;
        if let Some(feed) = &self.leg.feed {
            let (end, _) = self.run_fed(feed, launch, feed.full(), observer)?;
            return Ok(end);
        }
        let start = self.start(launch);
        let invariant = self.pendulum.invariant(launch.lean, launch.rate);
        let early = self.pendulum.lift_off_lean(invariant, launch.lean);
        let mut pace = Pace {
            step: FIRST_STEP,
            tolerance: self.tolerance,
            steps: 0,
            most: MOST_STEPS,
        };
        let end = |outcome, time_fire, y: &State<S>| Ok(ended(self, outcome, time_fire, y));

        let fired = match self.pivot(launch, start, early, &mut pace, observer)? {
            Next::On(y) => y,
            Next::End(outcome, y) => return end(outcome, S::of(f64::NAN), &y),
        };
        let time_fire = fired[TIME];
        let (open, close) = self.leg.answers(time_fire, launch.valve_open);
        let freed = match self.fill(fired, open, close, early, &mut pace, observer)? {
            Next::On(y) => y,
            Next::End(outcome, y) => return end(outcome, time_fire, &y),
        };
        let (outcome, y) = self.extend(freed, close, &mut pace, observer)?;
        end(outcome, time_fire, &y)
    }

    fn start(&self, launch: &Launch<S>) -> State<S> {
        let mut y = [S::of(0.0); WIDTH];
        (y[LEAN], y[RATE]) = (launch.lean, launch.rate);
        y[GAS] = self.ambient * S::of(1.0 / MEGA);
        y
    }

    /// Phase 1: the robot pivots on the retracted leg until it reaches the firing angle.
    fn pivot(
        &self,
        launch: &Launch<S>,
        mut y: State<S>,
        early: Option<f64>,
        pace: &mut Pace,
        observer: &mut dyn Observer<S>,
    ) -> Result<Next<S>, StanceError> {
        let (from, to) = (launch.lean, launch.firing_angle);
        if early.is_some_and(|early| early <= from.value()) {
            return Ok(Next::End(Outcome::EarlyLiftOff, y));
        }
        if from.value() >= to.value() {
            return Ok(Next::On(y));
        }
        if launch.rate.value() <= 0.0 && from.value() <= 0.0 {
            return Ok(Next::End(Outcome::Stall, y));
        }
        let invariant = self.pendulum.invariant(from, launch.rate);
        if !observer.is_stepwise()
            && early.is_none_or(|early| early > to.value())
            && let Some(time) = self.pendulum.time(invariant, from, to)
        {
            (y[LEAN], y[RATE], y[TIME]) =
                (to, self.pendulum.rate_squared(invariant, to).sqrt(), time);
            return Ok(Next::On(y));
        }
        let held = Held {
            stance: self,
            piece: None,
            energized: false,
            target: Some(to),
            early,
        };
        let event = advance(&held, &mut y, None, pace, &mut |a, b| {
            observer.held(&held, a, b);
        })?;
        Ok(match event {
            Some(Held::<S>::TARGET) => Next::On(y),
            Some(Held::<S>::EARLY) => Next::End(Outcome::EarlyLiftOff, y),
            _ => Next::End(Outcome::Stall, y),
        })
    }

    /// Phases 2 and 3: the valve's delay, then filling until the leg breaks away.
    fn fill(
        &self,
        mut y: State<S>,
        open: S,
        close: Option<S>,
        early: Option<f64>,
        pace: &mut Pace,
        observer: &mut dyn Observer<S>,
    ) -> Result<Next<S>, StanceError> {
        if !observer.is_stepwise()
            && let Some(freed) = self.break_away_by_series(&y, close, early)
        {
            return Ok(Next::On(freed));
        }
        let waiting = Held {
            stance: self,
            piece: None,
            energized: false,
            target: None,
            early,
        };
        let event = advance(&waiting, &mut y, Some(open), pace, &mut |a, b| {
            observer.held(&waiting, a, b);
        })?;
        match event {
            Some(Held::<S>::EARLY) => return Ok(Next::End(Outcome::EarlyLiftOff, y)),
            Some(_) => return Ok(Next::End(Outcome::NoBreakAway, y)),
            None => {}
        }
        let mut side = 0.0;
        loop {
            let piece = self.enter(&mut y, true, side, false);
            let filling = Held {
                stance: self,
                piece,
                energized: true,
                target: None,
                early,
            };
            let opens = close.is_none_or(|close| close.value() > open.value());
            if opens && filling.excess(&y).value() > 0.0 {
                self.leave(&mut y, piece.as_ref());
                return Ok(Next::On(y));
            }
            let event = advance(&filling, &mut y, close, pace, &mut |a, b| {
                observer.held(&filling, a, b);
            })?;
            self.leave(&mut y, piece.as_ref());
            match event {
                Some(Held::<S>::BREAK_AWAY) => return Ok(Next::On(y)),
                Some(Held::<S>::EDGE) => side = 1.0,
                Some(Held::<S>::EARLY) => return Ok(Next::End(Outcome::EarlyLiftOff, y)),
                _ => return Ok(Next::End(Outcome::NoBreakAway, y)),
            }
        }
    }

    /// Break-away of a plain pneumatic leg while sonic flow fills its chamber: the pressure then
    /// rises linearly, and a power series carries the pivoting. None where that does not hold to
    /// round-off.
    fn break_away_by_series(
        &self,
        fired: &State<S>,
        close: Option<S>,
        early: Option<f64>,
    ) -> Option<State<S>> {
        let chamber = self.leg.chamber().filter(|_| self.plain)?;
        let freed = self.series_break_away(chamber, fired);
        let time = fired[TIME] + freed.time;
        let is_valid = freed.residual.value().abs() < 1e-6
            && freed.tail.value() < 1e-16
            && freed.time.value() >= self.leg.delay.value()
            && close.is_none_or(|close| time.value() <= close.value())
            && freed.pressure.value() <= chamber.fill_edge().value()
            && early.is_none_or(|early| freed.lean.value().abs() < early);
        if !is_valid {
            return None;
        }
        let mut y = *fired;
        (y[LEAN], y[RATE], y[TIME]) = (freed.lean, freed.rate, time);
        y[GAS] = freed.pressure * S::of(1.0 / MEGA);
        Some(y)
    }

    /// The chamber's piece at `y`, where the gas is given by its pressure (MPa) and becomes the
    /// piece's own variable.
    fn enter(
        &self,
        y: &mut State<S>,
        energized: bool,
        side: f64,
        port_open: bool,
    ) -> Option<Piece<S>> {
        let chamber = self.leg.chamber()?;
        let p = y[GAS] * S::of(MEGA);
        let mut piece = Piece::new(chamber, energized, p, side, port_open);
        if piece.flow == Flow::FillBalanced && y[SPEED].value() > 0.0 {
            // The growing volume takes the pressure below the supply's at once.
            piece = Piece::new(chamber, energized, p, -1.0, port_open);
        }
        y[GAS] = chamber.variable(piece.flow, p);
        Some(piece)
    }

    /// Back from the piece's own variable to the pressure (MPa).
    fn leave(&self, y: &mut State<S>, piece: Option<&Piece<S>>) {
        if let (Some(chamber), Some(piece)) = (self.leg.chamber(), piece) {
            y[GAS] = chamber.pressure(piece.flow, y[GAS]) * S::of(1.0 / MEGA);
        }
    }

    /// Phase 4: the leg extends until lift-off.
    fn extend(
        &self,
        mut y: State<S>,
        close: Option<S>,
        pace: &mut Pace,
        observer: &mut dyn Observer<S>,
    ) -> Result<(Outcome, State<S>), StanceError> {
        let mut energized = true;
        let mut passed = S::of(0.0);
        let mut side = 0.0;
        for _ in 0..MOST_PIECES {
            let phase = self.extension(&mut y, energized, side, passed);
            if phase.force(&y).value() <= 0.0 {
                self.leave(&mut y, phase.piece.as_ref());
                return Ok((Outcome::Force.unless_fallen(y[LEAN].value()), y));
            }
            let end = close.filter(|_| energized);
            let event = advance(&phase, &mut y, end, pace, &mut |a, b| {
                observer.extension(&phase, a, b);
            })?;
            self.leave(&mut y, phase.piece.as_ref());
            side = 0.0;
            match event {
                None => {
                    energized = false;
                    pace.step = pace.step.min(FIRST_STEP);
                }
                Some(Extension::<S>::REACHED) if phase.next.value() < self.leg.stroke.value() => {
                    passed = phase.next;
                }
                Some(Extension::<S>::REACHED) => {
                    return Ok((Outcome::Stroke.unless_fallen(y[LEAN].value()), y));
                }
                Some(Extension::<S>::FORCE) => {
                    return Ok((Outcome::Force.unless_fallen(y[LEAN].value()), y));
                }
                Some(Extension::<S>::EDGE_ABOVE) => side = 1.0,
                Some(Extension::<S>::EDGE_BELOW) => side = -1.0,
                Some(_) => return Ok((Outcome::FallBack, y)),
            }
        }
        Err(StanceError::TooLong {
            time: y[TIME].value(),
        })
    }

    /// The extension from `passed` (m) to what switches next, on the piece of the valve's law at the
    /// present pressure, or just above or below it where `side` is ±1.
    fn extension(
        &self,
        y: &mut State<S>,
        energized: bool,
        side: f64,
        passed: S,
    ) -> Extension<'_, S> {
        let is_past = |x: Option<S>| x.is_some_and(|x| x.value() <= passed.value());
        let port_open = is_past(self.port());
        Extension {
            stance: self,
            piece: self.enter(y, energized, side, port_open),
            switches: Switches {
                energized,
                cushioned: is_past(self.leg.cushion_start()),
            },
            next: self.next_switch(passed),
        }
    }

    pub(crate) fn port(&self) -> Option<S> {
        self.leg.chamber().and_then(Chamber::port)
    }

    /// The first extension (m) past `d` at which something switches; the end of the stroke at the
    /// latest.
    pub(crate) fn next_switch(&self, d: S) -> S {
        let mut next = self.leg.stroke;
        let mut consider = |x: S| {
            if x.value() > d.value() && x.value() < next.value() {
                next = x;
            }
        };
        self.port().into_iter().for_each(&mut consider);
        self.leg.cushion_start().into_iter().for_each(&mut consider);
        if let Drive::Table(surface) = &self.leg.drive {
            surface.knots().iter().for_each(|&x| consider(S::of(x)));
        }
        next
    }
}

/// Where the series says that the leg breaks away.
pub(crate) struct SeriesBreakAway<S> {
    /// Time (s) from firing.
    pub time: S,
    pub lean: S,
    pub rate: S,
    /// Chamber pressure (Pa).
    pub pressure: S,
    /// What is left of the break-away condition (N).
    pub residual: S,
    /// Size of the series' last term.
    pub tail: S,
}

impl<S: Scalar> Stance<S> {
    /// Solves (P − P_a) A − F_f + m ω² r_s − m g cos φ = 0 with P = P_a + Ṗ (t − t_d), by Newton's
    /// method from the typical solution; the caller checks the result.
    #[inline(always)]
    pub(crate) fn series_break_away(
        &self,
        chamber: &Chamber<S>,
        fired: &[S; WIDTH],
    ) -> SeriesBreakAway<S> {
        let series = self.pendulum.series(fired[LEAN], fired[RATE]);
        let growth = chamber.sonic_filling_rate();
        let zero = S::of(0.0);
        let mut time = self.leg.delay + S::of(1e-3);
        let mut residual = zero;
        // Quadratic convergence from a millisecond away: four steps reach round-off, derivatives
        // included.
        for _ in 0..5 {
            let (lean, rate, cos) = series.at(time);
            let pressure = growth.mul_add(time - self.leg.delay, chamber.ambient);
            let push = self.leg.plain_force(chamber, zero, pressure).value;
            residual = push + self.mass * (rate * rate * self.radius - self.gravity * cos);
            let (sin, _) = lean.sin_cos();
            let swing = S::of(2.0) * self.radius * self.pendulum.stiffness + self.gravity;
            time = time - residual / (growth * chamber.area + self.mass * rate * sin * swing);
        }
        let (lean, rate, _) = series.at(time);
        let pressure = growth.mul_add(time - self.leg.delay, chamber.ambient);
        SeriesBreakAway {
            time,
            lean,
            rate,
            pressure,
            residual,
            tail: series.tail(time),
        }
    }
}
