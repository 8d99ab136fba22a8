//! The robot in its surroundings, a cycle of the controller at a time.

use rand_pcg::Pcg64;
use saltus_controller::run::Readings;
use saltus_robot::Sensors;
use saltus_sim_check::{Event, Ledger, Rig, Settings, Sim, Stepping};

use crate::GaitError;
use crate::sensors::Sensing;
use crate::surroundings::Surroundings;

/// What a cycle begins with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cycle {
    /// Time (s).
    pub time: f64,
    /// What the sensors say.
    pub readings: Readings,
}

/// Where a robot is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Motion {
    pub(crate) time: f64,
    /// Lean of leg 0 (rad), counted on through every turn.
    pub(crate) lean: f64,
    pub(crate) rate: f64,
    /// Angle and rate of the boom's pivot; height and its rate of a robot without a boom.
    pub(crate) pivot: [f64; 2],
    /// Travel and height of the axle (m) and their rates.
    pub(crate) axle: [f64; 2],
    pub(crate) axle_rates: [f64; 2],
}

/// A command to the valves, of which there is one a cycle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Command {
    /// Valves go on as they were commanded.
    #[default]
    Nothing,
    /// The valve of this leg opens for so long (s).
    Fire(usize, f64),
    /// The valve of this leg is open, and the one that was held before is closed, until another is held.
    Hold(Option<usize>),
}

impl From<Option<(usize, f64)>> for Command {
    /// Fires a leg for a valve opening time (s), if any.
    fn from(fire: Option<(usize, f64)>) -> Command {
        fire.map_or(Command::Nothing, |(leg, opening)| {
            Command::Fire(leg, opening)
        })
    }
}

/// The output to a valve: what is commanded, before the valve's own delays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Output {
    /// When (s) it was last switched on; infinite before the first time.
    pub on: f64,
    /// When (s) it is switched off; infinite as long as no command says.
    pub off: f64,
}

/// Times (s) that are the same but for round-off.
pub(crate) const NEAR: f64 = 1e-9;

impl Output {
    const NEVER: Output = Output {
        on: f64::INFINITY,
        off: f64::INFINITY,
    };

    /// Whether it is on just after `time` (s).
    pub fn is_on(&self, time: f64) -> bool {
        self.on <= time + NEAR && time + NEAR < self.off
    }

    /// For how long (s) it is on in the cycle of `period` (s) that begins at `time` (s).
    pub fn within(&self, time: f64, period: f64) -> f64 {
        if !self.is_on(time) {
            return 0.0;
        }
        let open = self.off - time;
        if open < period - NEAR { open } else { period }
    }

    /// Switches it on now for so long (s); an output that is on already stays so.
    fn fire(&mut self, now: f64, opening: f64) {
        let off = now + opening;
        if self.is_on(now) {
            self.off = self.off.max(off);
        } else {
            *self = Output { on: now, off };
        }
    }
}

/// A robot in motion, whose legs are all free to move. A clone goes on from the same state, to the bit.
#[derive(Clone)]
pub struct World<'a> {
    surroundings: &'a Surroundings,
    sim: Sim<'a>,
    present: usize,
    /// All disturbances that have been there so far: a bit for each.
    met: usize,
    sensing: Sensing,
    sensors: Sensors,
    cycles: u64,
    /// A command that waits for the next cycle.
    waiting: Command,
    /// The leg whose valve is held open.
    held: Option<usize>,
    outputs: Vec<Output>,
    start: Ledger,
}

impl<'a> World<'a> {
    /// The robot of `surroundings` at coordinates `q` and velocities `v`, its legs free.
    ///
    /// # Errors
    /// [`GaitError`] for a start that cannot be.
    pub fn new(
        surroundings: &'a Surroundings,
        sensors: Sensors,
        stepping: Stepping,
        (q, v): (&[f64], &[f64]),
        random: Pcg64,
    ) -> Result<World<'a>, GaitError> {
        let travel = surroundings.rig.axle(q)[0];
        let present = surroundings.present(0.0, travel);
        let settings = Settings {
            stepping,
            accounts: true,
            most_steps: usize::MAX,
            ..Settings::default()
        };
        let mut sim = Sim::new(surroundings.mechanism(present)?, q, v, settings)?;
        sim.release_legs()?;
        let start = sim.ledger();
        Ok(World {
            surroundings,
            sim,
            present,
            met: present,
            sensing: Sensing::new(sensors, random),
            sensors,
            cycles: 0,
            waiting: Command::Nothing,
            held: None,
            outputs: vec![Output::NEVER; surroundings.rig.legs.len()],
            start,
        })
    }

    /// The rig, without disturbances.
    pub fn rig(&self) -> &'a Rig {
        &self.surroundings.rig
    }

    /// The simulation.
    pub fn sim(&mut self) -> &mut Sim<'a> {
        &mut self.sim
    }

    /// The simulation, to look at.
    pub fn looked_at(&self) -> &Sim<'a> {
        &self.sim
    }

    /// Where it is.
    pub(crate) fn motion(&self) -> Motion {
        let (rig, sim) = (self.rig(), &self.sim);
        let (q, v) = (sim.coordinates(), sim.velocities());
        let (axle, axle_rates) = (rig.axle(q), rig.axle_rates(q, v));
        let pivot = match rig.boom {
            Some(_) => [q[1], v[1]],
            None => [axle[1], axle_rates[1]],
        };
        Motion {
            time: sim.time(),
            lean: q[rig.lean_coordinate()],
            rate: v[rig.lean_velocity()],
            pivot,
            axle,
            axle_rates,
        }
    }

    /// Energy (J) that no entry of the ledger explains since the start.
    pub fn residual(&self) -> f64 {
        self.sim.ledger().residual(&self.start)
    }

    /// What the sensors say now.
    pub fn read(&mut self) -> Cycle {
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        Cycle {
            time: self.sim.time(),
            readings: self.sensing.read(&self.surroundings.rig, q, v),
        }
    }

    /// Whether each disturbance has been there so far.
    pub fn disturbed(&self) -> Vec<bool> {
        let count = self.surroundings.disturbances().len();
        (0..count).map(|k| self.met >> k & 1 == 1).collect()
    }

    /// The outputs to the valves, leg by leg, in the cycle that has been [commanded](Self::command).
    pub fn outputs(&self) -> &[Output] {
        &self.outputs
    }

    /// Takes the command of this cycle, once before it [goes on](Self::go_on). The outputs follow now, or in
    /// the next cycle, as the robot's sensors say.
    ///
    /// # Errors
    /// [`GaitError::Sim`] for a leg that is not there.
    pub fn command(&mut self, command: Command) -> Result<(), GaitError> {
        let command = if self.sensors.output_delay_cycles > 0.5 {
            std::mem::replace(&mut self.waiting, command)
        } else {
            command
        };
        let now = self.sim.time();
        match command {
            Command::Nothing => {}
            Command::Fire(leg, opening) => {
                self.sim.fire(leg, opening)?;
                self.outputs[leg].fire(now, opening);
            }
            Command::Hold(leg) if leg == self.held => {}
            Command::Hold(leg) => {
                if let Some(before) = std::mem::replace(&mut self.held, leg) {
                    self.sim.switch(before, false)?;
                    self.outputs[before].off = now;
                }
                if let Some(leg) = leg {
                    self.sim.switch(leg, true)?;
                    self.outputs[leg].fire(now, f64::INFINITY);
                }
            }
        }
        Ok(())
    }

    /// Goes on to the next cycle. Each event is given to `heard`.
    ///
    /// # Errors
    /// [`GaitError::Sim`] where the motion cannot go on.
    pub fn go_on(&mut self, mut heard: impl FnMut(&Event)) -> Result<(), GaitError> {
        let travel = self.surroundings.rig.axle(self.sim.coordinates())[0];
        let present = self.surroundings.present(self.sim.time(), travel);
        if present != self.present {
            self.sim.change(self.surroundings.mechanism(present)?)?;
            self.present = present;
            self.met |= present;
        }
        self.cycles += 1;
        self.sim
            .run(self.cycles as f64 * self.sensors.period, &[])?;
        self.sim.drain_events().for_each(|event| heard(&event));
        Ok(())
    }
}
