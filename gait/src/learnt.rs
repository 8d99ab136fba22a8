//! A table that was learnt, as what decides in a run.

use saltus_controller::run::{Action, Choices, Steps};

use crate::error::ensure;
use crate::senses::{Senses, truth};
use crate::world::Cycle;
use crate::{Command, GaitError, World};

/// A table of choices, and what they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Learnt {
    /// Steps of each number that is observed.
    pub axes: Vec<Steps<f64>>,
    /// The choice in each state.
    pub choices: Vec<u8>,
    /// What is chosen.
    pub decides: Decides,
}

/// What a table chooses.
#[derive(Clone, Debug, PartialEq)]
pub enum Decides {
    /// In each cycle which leg's valve is open: 0 none, k leg k - 1. It knows what only a simulation does.
    Legs,
    /// In each period whether the valve of the leg in the zone is open.
    Zone {
        /// The period (s).
        period: f64,
    },
    /// As a leg enters the zone, which of these firing angles (rad) and valve opening times (s) it has.
    Stride {
        /// The firings to choose from.
        firings: Vec<[f64; 2]>,
        /// Where the box begins (m) whose distance is known.
        front: Option<f64>,
    },
}

impl Learnt {
    /// The choice where `observed` is.
    pub fn choice(&self, observed: &[f64]) -> u8 {
        let table = Choices {
            axes: &self.axes,
            choices: &self.choices,
        };
        table.at(observed).unwrap_or(0)
    }

    pub(crate) fn check(&self) -> Result<(), GaitError> {
        let states: usize = self.axes.iter().map(|it| usize::from(it.count)).product();
        let given = self.choices.len();
        ensure! { "choices", given as f64, given == states => format!("{states}, the states"); }
        if let Decides::Zone { period } = self.decides {
            let sound = period > 0.0 && period <= 1.0;
            ensure! { "period of decisions (s)", period, sound => "above 0 to 1 s"; }
        }
        Ok(())
    }
}

/// A table that decides, cycle after cycle.
#[derive(Clone, Debug)]
pub(crate) struct Deciding<'l> {
    learnt: &'l Learnt,
    senses: Senses,
    period: f64,
    cycles: usize,
    /// Legs that had entered the zone at the last decision of a stride, and its firing until it has been.
    stride: Option<f64>,
    firing: Option<[f64; 2]>,
    /// When the valve of each leg last opened (s).
    fired: Vec<f64>,
    /// The leg whose valve is to be open.
    open: Option<usize>,
    /// Cycles for which the robot has stood still, and the rate (rad/s) and the time (s) of a stall.
    still: usize,
    stall: [f64; 2],
    observed: Vec<f64>,
}

impl<'l> Deciding<'l> {
    /// `learnt`, with the `senses` of a robot with so many `legs` and a cycle of `period` (s); standing below a rate
    /// (rad/s) for a time (s) is a `stall`.
    pub(crate) fn new(
        learnt: &'l Learnt,
        senses: Senses,
        (legs, period): (usize, f64),
        stall: [f64; 2],
    ) -> Deciding<'l> {
        Deciding {
            learnt,
            senses,
            period,
            cycles: 0,
            stride: None,
            firing: None,
            fired: vec![f64::NEG_INFINITY; legs],
            open: None,
            still: 0,
            stall,
            observed: Vec::new(),
        }
    }

    /// A cycle: what is decided, and what is commanded. A valve that is held open has an infinite opening time in the
    /// cycle in which it opens: nobody knows yet when it closes.
    pub(crate) fn step(&mut self, now: &Cycle, world: &World<'_>) -> (Action<f64>, Command) {
        self.senses.take(&now.readings);
        let (fire, command) = match &self.learnt.decides {
            Decides::Legs => {
                let seen = truth(world, &self.fired);
                let leg = usize::from(self.learnt.choice(&seen)).checked_sub(1);
                let leg = leg.filter(|leg| *leg < self.fired.len());
                (self.holds(leg, now.time), Command::Hold(leg))
            }
            Decides::Zone { period } => {
                let opened = self.by_zone(*period, now.time);
                (opened, Command::Hold(self.open))
            }
            Decides::Stride { firings, front } => {
                let fire = self.by_stride(firings, *front);
                (fire, fire.into())
            }
        };
        self.cycles += 1;
        let rate = self.senses.rate();
        let stands = rate.abs() < self.stall[0];
        self.still = if stands { self.still + 1 } else { 0 };
        let name = |leg: usize| u32::try_from(leg).unwrap_or(u32::MAX);
        let action = Action {
            leg: fire.map(|(leg, _)| name(leg)),
            valve_open: fire.map_or(0.0, |(_, open)| open),
            in_zone: name(self.senses.leg()),
            lean: self.senses.lean(),
            rate,
            firing_angle: self.firing.map_or(std::f64::consts::PI, |[angle, _]| angle),
            stalled: self.still as f64 * self.period >= self.stall[1],
        };
        (action, command)
    }

    /// Has the valve of `leg` open from now on; the leg with its opening time, where it was not.
    fn holds(&mut self, leg: Option<usize>, now: f64) -> Option<(usize, f64)> {
        let before = std::mem::replace(&mut self.open, leg);
        let leg = leg.filter(|_| leg != before)?;
        self.fired[leg] = now;
        Some((leg, f64::INFINITY))
    }

    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    fn by_zone(&mut self, period: f64, now: f64) -> Option<(usize, f64)> {
        let every = ((period / self.period).round() as usize).max(1);
        if !self.cycles.is_multiple_of(every) {
            return None;
        }
        let opens = self.learnt.choice(&self.senses.in_zone()) == 1;
        let leg = opens.then(|| self.senses.leg());
        self.holds(leg, now)
    }

    fn by_stride(&mut self, firings: &[[f64; 2]], front: Option<f64>) -> Option<(usize, f64)> {
        let passed = self.senses.passed();
        if self.stride != Some(passed) {
            self.stride = Some(passed);
            let mut observed = std::mem::take(&mut self.observed);
            self.senses.in_stride(front, &mut observed);
            let choice = usize::from(self.learnt.choice(&observed));
            self.observed = observed;
            self.firing = firings.get(choice).copied().filter(|[_, open]| *open > 0.0);
        }
        let [angle, open] = self.firing?;
        if self.senses.lean() < angle {
            return None;
        }
        self.firing = None;
        Some((self.senses.leg(), open))
    }
}
