//! A motion through its events: touch-down and lift-off, slip and stick, end stops, valves.

mod adaptive;
mod events;
mod fixed;
mod guards;
mod report;
mod settle;
mod start;

pub use report::{Account, Contact, Ledger};
pub use start::LegStart;

use self::fixed::Fixed;
use self::guards::Guard;
use self::start::{check_start, first_mode};
use crate::SimError;
use crate::error::{length, not_negative, require};
use crate::machine::{Layout, Machine, OUTSIDE, Owner};
use crate::mechanism::Mechanism;
use crate::mode::{JointMode, Mode};
use crate::step::Stages;

/// How a motion is computed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Error allowed in each step, relative to 1 + |y| for every coordinate, velocity and pressure
    /// variable; > 0.
    pub tolerance: f64,
    /// Longest step (s), > 0: an event that comes and goes within one step is not seen.
    pub longest_step: f64,
    /// Impact speed (m/s, ≥ 0) below which restitution is 0. Without it a ball at rest would bounce,
    /// and a box rock, for ever.
    pub rest_speed: f64,
    /// How deep a start may be inside a surface (m), ≥ 0; it then counts as touching.
    pub penetration: f64,
    /// Steps that an adaptive motion may take: one that is too stiff for the integrator ends in an
    /// error.
    pub most_steps: usize,
    /// How long steps are.
    pub stepping: Stepping,
    /// Whether an account of each leg is kept: its work and its gas.
    pub accounts: bool,
}

/// How long steps are, and where events lie in them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stepping {
    /// As long as the tolerance allows, each event to round-off: for answers.
    Adaptive,
    /// This long (s), above 0 and at most [`Stepping::LONGEST`]: for controllers and learning.
    ///
    /// Contacts, end stops and dry friction are laws of impulses and end velocities (Moreau–Jean).
    /// Smooth motion is of second order; touch-down, end stops and commands cut a step in parts,
    /// while slip, break-away and lift-off happen within one.
    Fixed(f64),
}

impl Stepping {
    /// The usual fixed step (s).
    pub const USUAL: Stepping = Stepping::Fixed(1e-3);
    /// The longest fixed step (s).
    pub const LONGEST: f64 = 0.1;
}

impl Default for Settings {
    fn default() -> Settings {
        Settings {
            tolerance: 1e-10,
            longest_step: 0.01,
            rest_speed: 1e-3,
            penetration: 1e-9,
            most_steps: 1_000_000,
            stepping: Stepping::Adaptive,
            accounts: false,
        }
    }
}

/// Why a motion paused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pause {
    /// The time was reached.
    Time,
    /// The watch of this number came to 0 from above.
    Watch(usize),
}

/// Something that happened.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When (s).
    pub time: f64,
    /// What.
    pub what: Happening,
}

/// What can happen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Happening {
    /// A point touches a surface (their numbers).
    TouchDown(usize, usize),
    /// A point leaves a surface.
    LiftOff(usize, usize),
    /// A standing point begins to slip, along the first direction of the ground's friction (0) or the second
    /// (1); where friction has no directions along the first.
    Slip(usize, usize, usize),
    /// A slipping point comes to stand.
    Stick(usize, usize),
    /// The joint of a body reaches an end stop.
    EndStop(usize),
    /// The joint of a body, held before, begins to move.
    BreakAway(usize),
    /// The joint of a body comes to rest.
    Halt(usize),
    /// The valve of a leg opens or its latch is let go (true), or it closes.
    Valve(usize, bool),
    /// A switch inside a leg: the orifice law's pieces, cushion, port.
    Switch(usize),
}

/// A function that pauses a motion where it comes to 0 from above, of time (s), coordinates and
/// velocities.
pub type Watch<'w> = &'w dyn Fn(f64, &[f64], &[f64]) -> f64;

/// A mechanism in motion. A clone goes on from the same state, to the bit.
#[derive(Clone)]
pub struct Sim<'a> {
    machine: Machine<'a>,
    settings: Settings,
    layout: Layout,
    time: f64,
    y: Vec<f64>,
    mode: Mode,
    stages: Stages,
    step: f64,
    /// Commands to come: time, leg, on or off; latest first.
    commands: Vec<(f64, usize, bool)>,
    events: Vec<Event>,
    impacts: f64,
    stops: f64,
    touching: bool,
    steps: usize,
    evaluations: usize,
    next: Vec<f64>,
    guards: Vec<(Guard, f64)>,
    /// u of each chamber that is at rest, with its leg and with the surroundings; else NaN.
    at_rest: Vec<f64>,
    /// Room for fixed steps, where they are fixed.
    fixed: Option<Fixed>,
    /// Each contact's gap (m) at the start of a step where it is below [`JUST_LEFT`], else 0: a
    /// point in the air touches from there.
    floors: Vec<f64>,
    /// Contacts that close at the same instant as the one that is closing.
    together: Vec<Owner>,
    /// Events since time moved on.
    burst: (f64, usize),
}

/// Events that may happen within [`BURST_SPAN`] seconds before a motion counts as stuck in them.
const BURST: usize = 2000;
const BURST_SPAN: f64 = 1e-3;
/// Of these, how many are more than what rocks or rattles to rest.
const BACK_AGAIN: usize = 1000;
/// Velocity (m/s or rad/s) below which something then counts as standing: what falls by [`HAIR`]
/// gets no faster.
const CHATTER: f64 = 1e-6;

/// A gap (m) below which round-off says whether a point that has just left its surface is above it.
const JUST_LEFT: f64 = 1e-12;
/// What round-off may take (m or rad) of the way of something that leaves where it stood.
const HAIR: f64 = 1e-14;

impl<'a> Sim<'a> {
    /// `mechanism` at coordinates `q` and velocities `v`, its legs' valves at rest and unfired legs
    /// latched where they are.
    ///
    /// Points within `settings.penetration` of a surface touch it. Velocities into what touches are
    /// taken as they are: an impact takes them out at once.
    ///
    /// # Errors
    /// [`SimError`] for a mechanism or a start that cannot be.
    pub fn new(
        mechanism: &'a Mechanism,
        q: &[f64],
        v: &[f64],
        settings: Settings,
    ) -> Result<Sim<'a>, SimError> {
        let mut sim = Sim::placed(mechanism, q, v, settings)?;
        sim.begin()?;
        Ok(sim)
    }

    /// `mechanism` in full motion at coordinates `q` and velocities `v`: its legs free, each as `legs`
    /// says. So a motion goes on from what another one was.
    ///
    /// A leg without mass is latched, as in [`new`](Self::new).
    ///
    /// # Errors
    /// [`SimError`] for a mechanism or a start that cannot be.
    pub fn in_motion(
        mechanism: &'a Mechanism,
        q: &[f64],
        v: &[f64],
        legs: &[LegStart],
        settings: Settings,
    ) -> Result<Sim<'a>, SimError> {
        let mut sim = Sim::placed(mechanism, q, v, settings)?;
        sim.start_legs(legs)?;
        sim.begin()?;
        Ok(sim)
    }

    /// `mechanism` where it starts, before anything is decided.
    fn placed(
        mechanism: &'a Mechanism,
        q: &[f64],
        v: &[f64],
        settings: Settings,
    ) -> Result<Sim<'a>, SimError> {
        check_start(mechanism, q, v, &settings)?;
        let mut machine = Machine::new(mechanism, settings.accounts);
        let layout = machine.layout;
        let mut y = vec![0.0; layout.size()];
        y[..layout.coordinates].copy_from_slice(q);
        y[layout.coordinates..layout.gas()].copy_from_slice(v);
        mechanism.tree.normalize(&mut y[..layout.coordinates]);
        let mode = first_mode(mechanism, &mut y, layout);
        machine.weld(&mode, &y);
        let stages = Stages::new(layout.size());
        Ok(Sim {
            next: y.clone(),
            machine,
            settings,
            layout,
            time: 0.0,
            y,
            mode,
            stages,
            step: 1e-4,
            commands: Vec::new(),
            events: Vec::new(),
            impacts: 0.0,
            stops: 0.0,
            touching: true,
            steps: 0,
            evaluations: 0,
            guards: Vec::new(),
            at_rest: vec![f64::NAN; layout.legs],
            fixed: match settings.stepping {
                Stepping::Adaptive => None,
                Stepping::Fixed(h) => Some(Fixed::new(h, layout)),
            },
            floors: Vec::new(),
            together: Vec::new(),
            burst: (0.0, 0),
        })
    }

    /// Time (s).
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Coordinates q.
    pub fn coordinates(&self) -> &[f64] {
        self.layout.q(&self.y)
    }

    /// Velocities v.
    pub fn velocities(&self) -> &[f64] {
        self.layout.v(&self.y)
    }

    /// What has happened so far.
    pub fn events(&self) -> &[Event] {
        &self.events
    }

    /// Takes what has happened since this was last called: a long motion keeps no more than that.
    pub fn drain_events(&mut self) -> std::vec::Drain<'_, Event> {
        self.events.drain(..)
    }

    /// Lets go of all legs, which are else held where they are until they are fired.
    ///
    /// # Errors
    /// [`SimError`] where no forces agree with the laws then.
    pub fn release_legs(&mut self) -> Result<(), SimError> {
        for part in &self.machine.mechanism.legs {
            if self.mode.joints[part.body] == JointMode::Latched && !part.massless {
                self.mode.joints[part.body] = JointMode::Held(self.stop_of(part.body));
            }
        }
        self.machine.weld(&self.mode, &self.y);
        self.settle(None)
    }

    /// From now on the same bodies in other surroundings: `mechanism` differs in gravity, supply,
    /// friction, or forces from outside. What the change itself does to energy counts as work from
    /// outside.
    ///
    /// # Errors
    /// [`SimError`] for other bodies, points, surfaces or legs.
    pub fn change(&mut self, mechanism: &'a Mechanism) -> Result<(), SimError> {
        let (new, now) = (mechanism, self.machine.mechanism);
        length("bodies", new.tree.bodies().len(), now.tree.bodies().len())?;
        length("legs", new.legs.len(), now.legs.len())?;
        length("points", new.points.len(), now.points.len())?;
        length("surfaces", new.surfaces.len(), now.surfaces.len())?;
        mechanism.check(self.layout.q(&self.y))?;
        let stored = |l: &Ledger| l.kinetic + l.potential + l.springs;
        let before = stored(&self.ledger());
        let pressures: Vec<f64> = (0..self.layout.legs)
            .map(|leg| self.pressure(leg))
            .collect();
        self.machine.mechanism = mechanism;
        self.y[self.layout.works() + OUTSIDE] += stored(&self.ledger()) - before;
        for (leg, pressure) in pressures.into_iter().enumerate() {
            self.put_on_piece(leg, pressure, 0.0);
        }
        if let Some(fixed) = &mut self.fixed {
            fixed.forget();
        }
        self.settle(None)
    }

    /// Steps taken and derivatives evaluated so far.
    pub fn effort(&self) -> (usize, usize) {
        (self.steps, self.evaluations)
    }

    /// Commands leg `leg` now, for `opening` seconds from when its drive answers, after its delay;
    /// a leg without a valve ([`Leg::has_valve`](saltus_pneumatics::Leg::has_valve)) for good. A valve
    /// that is open already stays open until the later of the two commands ends.
    ///
    /// # Errors
    /// [`SimError::Input`] for a leg that is not there, or an opening time that is not a finite
    /// number ≥ 0.
    pub fn fire(&mut self, leg: usize, opening: f64) -> Result<(), SimError> {
        self.require_leg(leg)?;
        not_negative("valve opening time (s)", opening)?;
        let drive = &self.machine.mechanism.legs[leg].leg;
        let (begins, ends) = drive.answers(self.time, opening);
        self.commands.push((begins, leg, true));
        if let Some(ends) = ends {
            let closes = |c: &(f64, usize, bool)| c.1 == leg && !c.2 && c.0 >= begins;
            let later = self.commands.iter().filter(|c| closes(c)).map(|c| c.0);
            let ends = later.fold(ends, f64::max);
            self.commands.retain(|c| !closes(c));
            self.commands.push((ends, leg, false));
        }
        self.sort_commands();
        Ok(())
    }

    /// Commands the valve of leg `leg` to open, or to close, now: its drive answers after its delay. For
    /// a controller that says in each cycle which valve is open. A valve's least pulse has no part here: how
    /// long the command will last is not known yet.
    ///
    /// # Errors
    /// [`SimError::Input`] for a leg that is not there.
    pub fn switch(&mut self, leg: usize, on: bool) -> Result<(), SimError> {
        self.require_leg(leg)?;
        let at = self.time + self.machine.mechanism.legs[leg].leg.delay(on);
        self.commands.push((at, leg, on));
        self.sort_commands();
        Ok(())
    }

    fn require_leg(&self, leg: usize) -> Result<(), SimError> {
        let is_there = leg < self.layout.legs;
        require(is_there, "leg", leg as f64, "the number of a leg")
    }

    fn sort_commands(&mut self) {
        self.commands
            .sort_by(|a, b| b.0.total_cmp(&a.0).then(a.2.cmp(&b.2)));
    }

    /// Goes on until `until` (s), or until a watch comes to 0 from above, whichever is first.
    ///
    /// # Errors
    /// [`SimError`] where the motion cannot go on.
    pub fn run(&mut self, until: f64, watches: &[Watch<'_>]) -> Result<Pause, SimError> {
        loop {
            if let Some(pause) = self.run_eventwise(until, watches)? {
                return Ok(pause);
            }
        }
    }

    /// As [`run`](Self::run), but comes back with none after each event of the mechanism's own.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_eventwise(
        &mut self,
        until: f64,
        watches: &[Watch<'_>],
    ) -> Result<Option<Pause>, SimError> {
        require(!until.is_nan(), "time to run until (s)", until, "a number")?;
        while self.time < until {
            let events = self.events.len();
            if let Some(&(at, leg, on)) = self.commands.last()
                && at <= self.time
            {
                self.commands.pop();
                self.switch_valve(leg, on)?;
            } else if let Some(watch) = self.go_on(until, watches)? {
                return Ok(Some(Pause::Watch(watch)));
            }
            if self.events.len() > events {
                return Ok(None);
            }
        }
        Ok(Some(Pause::Time))
    }

    /// One step, or the part of one that ends at an event; the watch that came to 0, if one did.
    fn go_on(&mut self, until: f64, watches: &[Watch<'_>]) -> Result<Option<usize>, SimError> {
        match self.fixed.take() {
            None => self.advance(until, watches),
            Some(mut fixed) => {
                let found = self.advance_fixed(&mut fixed, until, watches);
                self.fixed = Some(fixed);
                found
            }
        }
    }

    /// That no contact forces agree with the laws now.
    fn inconsistent(&self) -> SimError {
        let limits = self.machine.friction().map(|(standing, ..)| standing);
        SimError::Inconsistent {
            time: self.time,
            friction: limits[0].max(limits[1]),
        }
    }

    /// From now on nothing that is in the air touches anything: a flight goes on as if there were
    /// no ground.
    pub fn stop_touching(&mut self) {
        self.touching = false;
    }
}
