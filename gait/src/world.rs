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

/// A robot in motion, whose legs are all free to move. A clone goes on from the same state, to the bit.
#[derive(Clone)]
pub struct World<'a> {
    surroundings: &'a Surroundings,
    sim: Sim<'a>,
    present: usize,
    sensing: Sensing,
    sensors: Sensors,
    cycles: u64,
    /// A command that waits for the next cycle: leg and opening time (s).
    waiting: Option<(usize, f64)>,
    /// The leg whose valve is commanded to be open until another command.
    open: Option<usize>,
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
            sensing: Sensing::new(sensors, random),
            sensors,
            cycles: 0,
            waiting: None,
            open: None,
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

    /// Has the valve of `leg` open, and every other one closed, until told otherwise.
    ///
    /// # Errors
    /// [`GaitError::Sim`] for a leg that is not there.
    pub fn open(&mut self, leg: Option<usize>) -> Result<(), GaitError> {
        if self.open == leg {
            return Ok(());
        }
        if let Some(before) = std::mem::replace(&mut self.open, leg) {
            self.sim.switch(before, false)?;
        }
        leg.map_or(Ok(()), |leg| self.sim.switch(leg, true))?;
        Ok(())
    }

    /// Fires `fire`, a leg and its valve opening time (s), if any, in this cycle or the next, as the
    /// robot's sensors say, and goes on to the next cycle. Each event is given to `heard`.
    ///
    /// # Errors
    /// [`GaitError::Sim`] where the motion cannot go on.
    pub fn go_on(
        &mut self,
        fire: Option<(usize, f64)>,
        mut heard: impl FnMut(&Event),
    ) -> Result<(), GaitError> {
        let now = if self.sensors.output_delay_cycles > 0.5 {
            std::mem::replace(&mut self.waiting, fire)
        } else {
            fire
        };
        if let Some((leg, opening)) = now {
            self.sim.fire(leg, opening)?;
        }
        let travel = self.surroundings.rig.axle(self.sim.coordinates())[0];
        let present = self.surroundings.present(self.sim.time(), travel);
        if present != self.present {
            self.sim.change(self.surroundings.mechanism(present)?)?;
            self.present = present;
        }
        self.cycles += 1;
        self.sim
            .run(self.cycles as f64 * self.sensors.period, &[])?;
        self.sim.drain_events().for_each(|event| heard(&event));
        Ok(())
    }
}
