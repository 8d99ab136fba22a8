//! A stance whose gas comes from a tank, through a tube, or by a valve that moves in time: the
//! phases of [`jump`](crate::Stance::jump) with the gas of chamber and tank in the state.
//!
//! There are no closed forms and no lanes for it; derivatives are carried.

use std::f64::consts::FRAC_PI_2;

use saltus_numeric::Single;
use saltus_numeric::dop853::Derivative;
use saltus_pneumatics::{Feed, Force, Held as Gas, MEGA, Place, Switches};

use crate::advance::index::{
    EXTENSION, GAS, HEAT, LEAN, MASS, RATE, SPEED, TANK, TANK_MASS, TIME, VENTED, VENTED_HEAT, WORK,
};
use crate::advance::{Look, Pace, Phase, WIDE, WIDE_CHECKED, Wide, advance};
use crate::observer::{FIRST_STEP, MOST_PIECES, Next, Observer, Unobserved, ended};
use crate::phase::{Drives, FORCE_SCALE, NEVER};
use crate::stance;
use crate::{Launch, LiftOff, Outcome, Stance, StanceError};

/// The gas in a tank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TankState {
    /// Pressure (Pa, absolute), > 0.
    pub pressure: f64,
    /// Temperature (K), > 0.
    pub temperature: f64,
}

/// What a jump took from the tank, until its valve was shut.
#[derive(Clone, Copy, Debug)]
pub struct Drawn {
    /// The tank after it.
    pub tank: TankState,
    /// Gas (kg) that left the tank.
    pub mass: f64,
    /// What mass (kg) and energy (J) do not add up to, over tank, tube, chamber and atmosphere, in
    /// parts of all that was in them: round-off, and the errors of the steps.
    pub residuals: [f64; 2],
}

/// How a stance ended, and what it took from the tank.
pub type FromTank = (LiftOff, Drawn);

/// Most steps of one jump, each of which takes longer than one of a plain leg: an ordinary jump takes a
/// hundred, one that ends at ambient pressure a thousand.
const MOST_STEPS: u32 = 4000;
/// Time constants of a spool after which it counts as shut.
const SHUT: f64 = 40.0;

impl Stance<f64> {
    /// Gas (kg) in the tank; none for a robot that does not carry its gas.
    pub fn tank_mass(&self, tank: &TankState) -> Option<f64> {
        let feed = self.leg.feed.as_ref().filter(|feed| feed.tank.is_some())?;
        Some(feed.tank_at(tank.pressure, tank.temperature).mass)
    }

    /// The tank `time` (s) later, with all valves shut: its wall warms it up, or cools it. None for a
    /// robot that does not carry its gas.
    pub fn tank_later(&self, tank: &TankState, time: f64) -> Option<TankState> {
        let feed = self.leg.feed.as_ref().filter(|feed| feed.tank.is_some())?;
        let gas = feed.tank_at(tank.pressure, tank.temperature);
        let later = feed.tank_after(gas, [0.0; 2], time);
        Some(TankState {
            pressure: later.pressure,
            temperature: feed.tank_temperature(later),
        })
    }

    /// The full tank of a robot that carries its gas; none for one that does not.
    pub fn full_tank(&self) -> Option<TankState> {
        let feed = self.leg.feed.as_ref()?;
        feed.tank?;
        let full = feed.full();
        Some(TankState {
            pressure: full.pressure,
            temperature: feed.tank_temperature(full),
        })
    }

    /// One stance with the tank as it is, and what it takes from it; none for a robot that does not
    /// carry its gas.
    ///
    /// Where the robot lifts off with its valve open, the chamber goes on filling until the valve
    /// is shut, with the leg as it is.
    ///
    /// # Errors
    /// As [`Stance::jump`], and [`StanceError::Input`] for a tank without gas.
    pub fn jump_from(
        &self,
        launch: &Launch,
        tank: &TankState,
    ) -> Result<Option<FromTank>, StanceError> {
        let feed = self.leg.feed.as_ref().filter(|feed| feed.tank.is_some());
        feed.map(|feed| self.draw(feed, launch, tank)).transpose()
    }

    fn draw(
        &self,
        feed: &Feed<f64>,
        launch: &Launch,
        tank: &TankState,
    ) -> Result<FromTank, StanceError> {
        stance::check(launch)?;
        for (name, value) in [
            ("pressure of the tank (Pa)", tank.pressure),
            ("temperature of the tank (K)", tank.temperature),
        ] {
            if !(value > 0.0 && value.is_finite()) {
                let allowed = "a finite number > 0";
                return Err(StanceError::Input {
                    name,
                    value,
                    allowed,
                });
            }
        }
        let start = feed.tank_at(tank.pressure, tank.temperature);
        let (end, mut course) = self.run_fed(feed, launch, start, &mut Unobserved)?;
        let before = Self::start_fed(feed, launch, start);
        self.shut(feed, &mut course)?;
        let y = &course.y;
        let after = tank_of(feed, y);
        let (held, vented) = (gas_of(feed, y), [y[VENTED], y[VENTED_HEAT]]);
        let first = gas_of(feed, &before);
        let energy = |gas: Gas<f64>, d: f64, tank: Gas<f64>| {
            let volume = feed.tank.map_or(1.0, |tank| tank.volume);
            feed.energy(gas.pressure, feed.volume_at(d, gas.pressure))
                + feed.energy(tank.pressure, volume)
        };
        let stored = energy(first, before[EXTENSION], start);
        let left = energy(held, y[EXTENSION], after) + vented[1] + y[WORK] - y[HEAT];
        let mass = first.mass + start.mass;
        Ok((
            end,
            Drawn {
                tank: TankState {
                    pressure: after.pressure,
                    temperature: feed.tank_temperature(after),
                },
                mass: start.mass - after.mass,
                residuals: [
                    (held.mass + after.mass + vented[0] - mass) / mass,
                    (left - stored) / stored,
                ],
            },
        ))
    }

    /// The gas after the end of a stance until the valve is shut, with the leg as it is.
    fn shut(&self, feed: &Feed<f64>, course: &mut Course<f64>) -> Result<(), StanceError> {
        let Some(close) = course.close else {
            return Ok(());
        };
        let mut pace = Pace {
            step: FIRST_STEP,
            tolerance: self.tolerance,
            steps: 0,
            most: MOST_STEPS,
        };
        let slow = SHUT * feed.spool_time();
        let mut go = |course: &mut Course<f64>, until: f64| {
            let aloft = Fed {
                part: Part::Aloft,
                spool: course.spool,
                flows: true,
                port_open: self.port().is_some_and(|port| port <= course.y[EXTENSION]),
                ..Fed::at_rest(self, feed, None)
            };
            let event = advance(
                &aloft,
                &mut course.y,
                Some(until),
                &mut pace,
                &mut |_, _| (),
            );
            event.map_err(|error| match error {
                StanceError::StepTooSmall { .. } | StanceError::TooManySteps { .. } => {
                    StanceError::Input {
                        name: "time (s) after touch-down at which the valve is shut",
                        value: until,
                        allowed: "earlier: tank and chamber are even long before, and what flows to \
                                  and fro then is too stiff to integrate",
                    }
                }
                other => other,
            })
        };
        if course.spool.open {
            go(course, close)?;
            course.spool = course.spool.closing(feed, close);
        }
        if slow > 0.0 && course.spool.from > 0.0 {
            let until = course.spool.since + slow;
            go(course, until)?;
        }
        Ok(())
    }
}

impl<S: Single> Stance<S> {
    fn start_fed(feed: &Feed<S>, launch: &Launch<S>, tank: Gas<S>) -> Wide<S> {
        let mut y = [S::of(0.0); WIDE];
        let ([line, store], mega) = (feed.mass_units(), S::of(1.0 / MEGA));
        let held = feed.at_rest(S::of(0.0));
        (y[LEAN], y[RATE]) = (launch.lean, launch.rate);
        (y[GAS], y[MASS]) = (held.pressure * mega, held.mass * S::of(1.0 / line));
        (y[TANK], y[TANK_MASS]) = (tank.pressure * mega, tank.mass * S::of(1.0 / store));
        y
    }

    /// One stance with the tank as it is, from `launch` to its end; and how the gas stands there.
    pub(crate) fn run_fed(
        &self,
        feed: &Feed<S>,
        launch: &Launch<S>,
        tank: Gas<S>,
        observer: &mut dyn Observer<S>,
    ) -> Result<(LiftOff<S>, Course<S>), StanceError> {
        let start = Self::start_fed(feed, launch, tank);
        let mut pace = Pace {
            step: FIRST_STEP,
            tolerance: self.tolerance,
            steps: 0,
            most: MOST_STEPS,
        };
        let idle = Spool {
            since: S::of(0.0),
            from: S::of(0.0),
            open: false,
        };
        let end = |outcome, time_fire, course: Course<S>| {
            Ok((ended(self, outcome, time_fire, &course.y), course))
        };
        let course = |y, spool, close| Course { y, spool, close };
        let invariant = self.pendulum.invariant(launch.lean, launch.rate);
        let early = self.pendulum.lift_off_lean(invariant, launch.lean);
        let fired = match self.pivot_fed(feed, launch, (start, early), &mut pace, observer)? {
            Next::On(y) => y,
            Next::End(outcome, y) => {
                return end(outcome, S::of(f64::NAN), course(y, idle, None));
            }
        };
        let time_fire = fired[TIME];
        let (open, close) = self.leg.answers(time_fire, launch.valve_open);
        let close = close.unwrap_or(open);
        let filled = self.fill_fed(feed, (fired, early), [open, close], &mut pace, observer)?;
        let (freed, spool) = match filled {
            (Next::On(y), spool) => (y, spool),
            (Next::End(outcome, y), spool) => {
                return end(outcome, time_fire, course(y, spool, Some(close)));
            }
        };
        let mut at = course(freed, spool, Some(close));
        let outcome = self.extend_fed(feed, &mut at, &mut pace, observer)?;
        end(outcome, time_fire, at)
    }

    /// Phase 1, as that of a plain leg: [`Stance::jump`].
    fn pivot_fed(
        &self,
        feed: &Feed<S>,
        launch: &Launch<S>,
        (mut y, early): (Wide<S>, Option<f64>),
        pace: &mut Pace,
        observer: &mut dyn Observer<S>,
    ) -> Result<Next<S, WIDE>, StanceError> {
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
        let pivoting = Fed {
            target: Some(to),
            ..Fed::at_rest(self, feed, early)
        };
        let event = advance(&pivoting, &mut y, None, pace, &mut |a, b| {
            observer.fed(&pivoting, a, b);
        })?;
        Ok(match event {
            Some(Fed::<S>::TARGET) => Next::On(y),
            Some(Fed::<S>::EARLY) => Next::End(Outcome::EarlyLiftOff, y),
            _ => Next::End(Outcome::Stall, y),
        })
    }

    /// Phases 2 and 3: the delay, then filling until the leg breaks away. A spool that closes slowly
    /// goes on letting gas in.
    fn fill_fed(
        &self,
        feed: &Feed<S>,
        (mut y, early): (Wide<S>, Option<f64>),
        [open, close]: [S; 2],
        pace: &mut Pace,
        observer: &mut dyn Observer<S>,
    ) -> Result<(Next<S, WIDE>, Spool<S>), StanceError> {
        let waiting = Fed::at_rest(self, feed, early);
        let event = advance(&waiting, &mut y, Some(open), pace, &mut |a, b| {
            observer.fed(&waiting, a, b);
        })?;
        match event {
            Some(Fed::<S>::EARLY) => {
                return Ok((Next::End(Outcome::EarlyLiftOff, y), waiting.spool));
            }
            Some(_) => return Ok((Next::End(Outcome::NoBreakAway, y), waiting.spool)),
            None => {}
        }
        let mut spool = Spool {
            since: open,
            from: S::of(0.0),
            open: true,
        };
        if close.value() <= open.value() {
            return Ok((Next::End(Outcome::NoBreakAway, y), waiting.spool));
        }
        let mut until = close;
        loop {
            let filling = Fed {
                spool,
                flows: true,
                ..Fed::at_rest(self, feed, early)
            };
            if filling.excess(&y).value() > 0.0 {
                return Ok((Next::On(y), spool));
            }
            let event = advance(&filling, &mut y, Some(until), pace, &mut |a, b| {
                observer.fed(&filling, a, b);
            })?;
            match event {
                Some(Fed::<S>::BREAK_AWAY) => return Ok((Next::On(y), spool)),
                Some(Fed::<S>::EARLY) => {
                    return Ok((Next::End(Outcome::EarlyLiftOff, y), spool));
                }
                None if spool.open && feed.spool_time().value() > 0.0 => {
                    spool = spool.closing(feed, close);
                    until = close + S::of(SHUT) * feed.spool_time();
                }
                _ => return Ok((Next::End(Outcome::NoBreakAway, y), spool)),
            }
        }
    }

    /// Phase 4: the leg extends until lift-off.
    fn extend_fed(
        &self,
        feed: &Feed<S>,
        course: &mut Course<S>,
        pace: &mut Pace,
        observer: &mut dyn Observer<S>,
    ) -> Result<Outcome, StanceError> {
        let mut passed = S::of(0.0);
        for _ in 0..MOST_PIECES {
            let is_past = |x: Option<S>| x.is_some_and(|x| x.value() <= passed.value());
            let phase = Fed {
                part: Part::Extending,
                spool: course.spool,
                flows: true,
                cushioned: is_past(self.leg.cushion_start()),
                port_open: is_past(self.port()),
                next: self.next_switch(passed),
                ..Fed::at_rest(self, feed, None)
            };
            let y = &mut course.y;
            if phase.force(y).value.value() <= 0.0 {
                return Ok(Outcome::Force.unless_fallen(y[LEAN].value()));
            }
            let end = course.close.filter(|_| course.spool.open);
            let event = advance(&phase, y, end, pace, &mut |a, b| {
                observer.fed(&phase, a, b);
            })?;
            match event {
                None => {
                    let now = end.unwrap_or(y[TIME]);
                    course.spool = course.spool.closing(feed, now);
                    pace.step = pace.step.min(FIRST_STEP);
                }
                Some(Fed::<S>::REACHED) if phase.next.value() < self.leg.stroke.value() => {
                    passed = phase.next;
                }
                Some(Fed::<S>::REACHED) => {
                    return Ok(Outcome::Stroke.unless_fallen(y[LEAN].value()));
                }
                Some(Fed::<S>::FORCE) => {
                    return Ok(Outcome::Force.unless_fallen(y[LEAN].value()));
                }
                Some(_) => return Ok(Outcome::FallBack),
            }
        }
        Err(StanceError::TooLong {
            time: course.y[TIME].value(),
        })
    }
}

/// How the gas stands at the end of a stance.
pub(crate) struct Course<S> {
    y: Wide<S>,
    spool: Spool<S>,
    /// When the valve closes (s), once it is commanded.
    close: Option<S>,
}

/// The valve's spool: since when (s) it goes where it goes, and from which opening.
#[derive(Clone, Copy)]
struct Spool<S> {
    since: S,
    from: S,
    open: bool,
}

impl<S: Single> Spool<S> {
    fn opening(&self, feed: &Feed<S>, time: S) -> S {
        feed.opening(self.from, self.open, time - self.since)
    }

    /// Sent shut at `time` (s).
    fn closing(&self, feed: &Feed<S>, time: S) -> Spool<S> {
        Spool {
            since: time,
            from: self.opening(feed, time),
            open: false,
        }
    }
}

/// The gas of the chamber in a state.
fn gas_of<S: Single>(feed: &Feed<S>, y: &Wide<S>) -> Gas<S> {
    Gas {
        pressure: y[GAS] * S::of(MEGA),
        mass: y[MASS] * S::of(feed.mass_units()[0]),
    }
}

/// The gas of the tank in a state.
fn tank_of<S: Single>(feed: &Feed<S>, y: &Wide<S>) -> Gas<S> {
    Gas {
        pressure: y[TANK] * S::of(MEGA),
        mass: y[TANK_MASS] * S::of(feed.mass_units()[1]),
    }
}

/// Puts the rates of the gas into `dy`, where the valve lets gas through or not.
fn flow<S: Single>(feed: &Feed<S>, y: &Wide<S>, at: Option<&Place<S>>, dy: &mut Wide<S>) {
    let ([line, store], mega, zero) = (feed.mass_units(), S::of(1.0 / MEGA), S::of(0.0));
    let tank = tank_of(feed, y);
    let mut drawn = [zero; 2];
    if let Some(at) = at {
        let rates = feed.rates(tank, gas_of(feed, y), at);
        dy[GAS] = rates.held.pressure * mega;
        dy[MASS] = rates.held.mass * S::of(1.0 / line);
        [dy[VENTED], dy[VENTED_HEAT]] = rates.vented;
        (dy[HEAT], dy[WORK]) = (rates.heat, rates.work);
        drawn = rates.drawn;
    }
    let (rates, heat) = feed.tank_rates(tank, drawn);
    dy[TANK] = rates.pressure * mega;
    dy[TANK_MASS] = rates.mass * S::of(1.0 / store);
    dy[HEAT] = dy[HEAT] + heat;
}

/// What the leg does.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    /// It is held at d = 0: the robot pivots, and the chamber may fill.
    Held,
    /// It extends.
    Extending,
    /// It is off the ground, and stays as it is.
    Aloft,
}

/// A phase. One type for all: derivatives of so many numbers take long to compile.
#[derive(Clone, Copy)]
struct Fed<'a, S: Single> {
    stance: &'a Stance<S>,
    feed: &'a Feed<S>,
    part: Part,
    spool: Spool<S>,
    /// Whether gas flows, and a held leg may break away: before that the chamber is at ambient
    /// pressure.
    flows: bool,
    cushioned: bool,
    port_open: bool,
    /// Lean (rad) at which pivoting ends.
    target: Option<S>,
    /// As in a plain leg's phase.
    early: Option<f64>,
    /// The next extension (m) at which something switches.
    next: S,
}

impl<'a, S: Single> Fed<'a, S> {
    /// Numbers of the guards of a held leg; 1 and 4 are its coming to rest, and its falling over.
    const TARGET: usize = 0;
    const BREAK_AWAY: usize = 2;
    const EARLY: usize = 3;
    /// Numbers of those of an extending one; 2 is its coming to a halt.
    const REACHED: usize = 0;
    const FORCE: usize = 1;

    /// A held leg with its valve at rest.
    fn at_rest(stance: &'a Stance<S>, feed: &'a Feed<S>, early: Option<f64>) -> Fed<'a, S> {
        let zero = S::of(0.0);
        Fed {
            stance,
            feed,
            part: Part::Held,
            spool: Spool {
                since: zero,
                from: zero,
                open: false,
            },
            flows: false,
            cushioned: false,
            port_open: false,
            target: None,
            early,
            next: stance.leg.stroke,
        }
    }

    /// The force of a leg that pushes.
    fn force(&self, y: &Wide<S>) -> Force<S> {
        let switches = Switches {
            energized: self.spool.open,
            cushioned: self.cushioned,
        };
        let p = y[GAS] * S::of(MEGA);
        self.stance.leg.force(switches, y[EXTENSION], y[SPEED], p)
    }

    /// As in a plain leg's phase: the force (N) beyond what holds the leg.
    fn excess(&self, y: &Wide<S>) -> S {
        let stance = self.stance;
        let (_, cos) = y[LEAN].sin_cos();
        self.force(y).value
            + stance.mass * (y[RATE] * y[RATE] * stance.radius - stance.gravity * cos)
    }

    /// d(excess)/dt (N/s).
    fn excess_rate(&self, y: &Wide<S>, dy: &Wide<S>) -> S {
        let stance = self.stance;
        let (sin, _) = y[LEAN].sin_cos();
        self.force(y).wrt_pressure * dy[GAS] * S::of(MEGA)
            + stance.mass * y[RATE] * (S::of(2.0) * dy[RATE] * stance.radius + stance.gravity * sin)
    }

    /// Derivative of a state in time.
    fn rates(&self, y: &Wide<S>) -> Wide<S> {
        let stance = self.stance;
        let mut dy = [S::of(0.0); WIDE];
        match self.part {
            Part::Held => {
                let (sin, _) = y[LEAN].sin_cos();
                dy[LEAN] = y[RATE];
                dy[RATE] = stance.pendulum.stiffness * sin;
            }
            Part::Extending => {
                let about = stance.about_foot(y).inverse();
                dy = stance.motion(y, self.force(y).value, about);
            }
            Part::Aloft => {}
        }
        dy[TIME] = S::of(1.0);
        let place = Place {
            extension: y[EXTENSION],
            speed: dy[EXTENSION],
            opening: self.spool.opening(self.feed, y[TIME]),
            port_open: self.port_open,
        };
        flow(self.feed, y, self.flows.then_some(&place), &mut dy);
        dy
    }

    /// Guards of a held leg, and their rates.
    fn held_guards(&self, y: &Wide<S>, dy: &Wide<S>) -> [(S, S); 5] {
        let scale = S::of(FORCE_SCALE);
        let idle = (S::of(NEVER), S::of(0.0));
        let aside = if y[LEAN].value() < 0.0 {
            -dy[LEAN]
        } else {
            dy[LEAN]
        };
        [
            self.target
                .map_or(idle, |target| (y[LEAN] - target, dy[LEAN])),
            self.target.map_or(idle, |_| (-y[RATE], -dy[RATE])),
            if self.flows {
                (self.excess(y) * scale, self.excess_rate(y, dy) * scale)
            } else {
                idle
            },
            self.early.map_or(idle, |early| match early {
                early if early > 0.0 => (y[LEAN].abs() - S::of(early), aside),
                early => (y[LEAN] - S::of(early), dy[LEAN]),
            }),
            (y[LEAN].abs() - S::of(FRAC_PI_2), aside),
        ]
    }

    /// The same of an extending one.
    fn extending_guards(&self, y: &Wide<S>, dy: &Wide<S>) -> [(S, S); 5] {
        let (force, scale) = (self.force(y), S::of(-FORCE_SCALE));
        let change = force.wrt_pressure * dy[GAS] * S::of(MEGA)
            + force.wrt_speed * dy[SPEED]
            + force.wrt_extension * dy[EXTENSION];
        let idle = (S::of(NEVER), S::of(0.0));
        [
            (y[EXTENSION] - self.next, dy[EXTENSION]),
            (force.value * scale, change * scale),
            (-y[SPEED], -dy[SPEED]),
            idle,
            idle,
        ]
    }
}

impl<S: Single> Derivative<S, WIDE> for Fed<'_, S> {
    fn at(&self, y: &Wide<S>) -> Wide<S> {
        S::apart(|| self.rates(y))
    }
}

impl<S: Single> Phase<S, WIDE, 5> for Fed<'_, S> {
    const CHECKED: usize = WIDE_CHECKED;
    fn look(&self, y: &Wide<S>) -> Look<S, WIDE, 5> {
        S::apart(|| {
            let rates = self.rates(y);
            let guards = match self.part {
                Part::Held => self.held_guards(y, &rates),
                Part::Extending => self.extending_guards(y, &rates),
                Part::Aloft => [(S::of(NEVER), S::of(0.0)); 5],
            };
            Look {
                rates,
                guards: guards.map(|g| g.0),
                guard_rates: guards.map(|g| g.1),
            }
        })
    }
}

impl<S: Single> Drives<S, WIDE> for Fed<'_, S> {
    fn gas_pressure(&self, y: &Wide<S>) -> S {
        y[GAS] * S::of(MEGA)
    }
    fn forces(&self, y: &Wide<S>) -> (S, S) {
        if self.part != Part::Extending {
            return (S::of(0.0), S::of(0.0));
        }
        let switches = Switches {
            energized: self.spool.open,
            cushioned: self.cushioned,
        };
        let leg = &self.stance.leg;
        let drive = leg.drive_force(switches, y[EXTENSION], y[SPEED], self.gas_pressure(y));
        (drive.value, self.force(y).value)
    }
}
