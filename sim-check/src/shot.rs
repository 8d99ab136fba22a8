//! A firing from standing on a foot, row by row: what a log of a robot is made of, and where its
//! jump goes.

use crate::SimError;
use crate::rig::Rig;
use crate::sim::{Happening, Pause, Settings, Sim, Watch};
use saltus_robot::Launch;

/// Time (s) between the ticks at which a leg is commanded, and between rows.
pub const TICK: f64 = 1e-3;
/// Longest time (s) that a firing may take, and a foot may stand after its command.
const LONGEST: f64 = 4.0;
const LONGEST_STANCE: f64 = 0.6;
/// Least flight (s) and extension (m) of what counts as a jump: not every foot that leaves the
/// ground has jumped.
const LEAST_FLIGHT: f64 = 0.08;
const LEAST_EXTENSION: f64 = 0.02;
/// Gauge pressure (Pa) below which a chamber counts as exhausted.
const EXHAUSTED: f64 = 500.0;

/// One firing: a start (rad, rad/s), when the leg is commanded (s), and how long its valve is open
/// (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firing {
    /// Lean at the start (rad).
    pub lean: f64,
    /// Rate at the start (rad/s).
    pub rate: f64,
    /// Time of the command (s).
    pub on: f64,
    /// Valve opening time (s).
    pub opening: f64,
}

/// What the sensors of a robot would read, a row a tick: lean, pivot angle and radius angle (rad; without
/// a boom 0), what a gyro on the wheel says (rad/s), and how far and how high the axle is (m).
#[derive(Clone, Debug, PartialEq)]
pub struct Flown {
    /// When the foot left the ground (s).
    pub lift_off: f64,
    /// Rows of lean, pivot angle, radius angle, gyro, travel and height.
    pub rows: Vec<[f64; 6]>,
}

/// A motion of a rig from standing on a foot; in the air without touching anything.
pub struct Shot<'a> {
    rig: &'a Rig,
    settings: Settings,
    sim: Sim<'a>,
    /// When (s) `sim` began.
    began: f64,
    lift_off: Option<f64>,
}

impl<'a> Shot<'a> {
    /// The robot of `rig` on its retracted leg, which leans by `lean` (rad) and turns at `rate`
    /// (rad/s). Soft ground carries it from the start.
    ///
    /// # Errors
    /// [`SimError`] if it cannot stand so.
    pub fn new(
        rig: &'a Rig,
        [lean, rate]: [f64; 2],
        settings: Settings,
    ) -> Result<Shot<'a>, SimError> {
        let (mut q, v) = rig.stand(lean, rate)?;
        let mut settings = settings;
        if let Some((stiffness, _)) = rig.mechanism.material.compliance {
            let lighter = 1.0 - rate * rate * rig.radius * lean.cos() / -rig.mechanism.gravity.z;
            let sink = rig.resting_force() * lighter.max(0.1) / stiffness;
            settings.penetration = 1.01 * sink + 1e-9;
            q[1] -= sink / rig.boom.unwrap_or(1.0);
        }
        Ok(Shot {
            rig,
            settings,
            sim: Sim::new(&rig.mechanism, &q, &v, settings)?,
            began: 0.0,
            lift_off: None,
        })
    }

    /// Time (s) since the start.
    pub fn time(&self) -> f64 {
        self.began + self.sim.time()
    }

    /// When (s) the foot left the ground, if it has.
    pub fn lift_off(&self) -> Option<f64> {
        self.lift_off
    }

    /// The simulation as it is.
    pub fn sim(&self) -> &Sim<'a> {
        &self.sim
    }

    /// Lean of the leg (rad).
    pub fn lean(&self) -> f64 {
        self.sim.coordinates()[self.rig.lean_coordinate()]
    }

    /// Commands the leg now, for a valve opening time `opening` (s).
    ///
    /// # Errors
    /// [`SimError::Input`] for an opening time that is not a finite number ≥ 0.
    pub fn fire(&mut self, opening: f64) -> Result<(), SimError> {
        self.sim.fire(0, opening)
    }

    /// Goes on until `until` (s), or until a watch.
    ///
    /// # Errors
    /// [`SimError`] for a motion that cannot go on.
    pub fn go(&mut self, until: f64, watches: &[Watch<'_>]) -> Result<Pause, SimError> {
        loop {
            let pause = self.sim.run_eventwise(until - self.began, watches)?;
            if pause == Some(Pause::Time) {
                if self.flies_for(10.0 * TICK) {
                    self.sim.stop_touching();
                }
                self.forget_chamber();
            }
            if let Some(pause) = pause {
                return Ok(pause);
            }
            if self.lift_off.is_none() && self.has_left() {
                self.lift_off = Some(self.time());
                // Soft ground lets go of a foot that is still in it.
                if self.rig.mechanism.material.compliance.is_none() {
                    self.sim.stop_touching();
                }
            }
        }
    }

    fn has_left(&self) -> bool {
        let events = self.sim.events();
        events.iter().any(|e| e.what == Happening::LiftOff(0, 0))
    }

    /// Whether it has been in the air for longer than `time` (s).
    fn flies_for(&self, time: f64) -> bool {
        self.lift_off.is_some_and(|at| self.time() > at + time)
    }

    /// Once the leg is exhausted in the air, and held, its chamber is as it was before. One with an
    /// opening beside its valve, which has come to the pressure around it, costs thousands of
    /// events.
    fn forget_chamber(&mut self) {
        let leg = self.rig.mechanism.tree.velocity_of(self.rig.legs[0]);
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        // A tank would be full again.
        let part = &self.rig.mechanism.legs[0].leg;
        let chamber = part.chamber().filter(|_| part.feed.is_none());
        let is_exhausted = chamber.is_some_and(|chamber| {
            let gauge = self.sim.pressure(0) - chamber.ambient;
            chamber.has_openings() && gauge.abs() < EXHAUSTED
        });
        if self.began == 0.0
            && is_exhausted
            && v[leg] == 0.0
            && self.flies_for(5.0 * TICK)
            && let Ok(mut sim) = Sim::new(&self.rig.mechanism, q, v, self.settings)
        {
            sim.stop_touching();
            self.began = self.time();
            self.sim = sim;
        }
    }

    fn readings(&self) -> [f64; 6] {
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        let rate = v[self.rig.lean_velocity()];
        let [x, y] = self.rig.axle(q);
        match self.rig.boom {
            Some(_) => [self.lean(), q[1], q[0], rate + v[0] * q[1].sin(), x, y],
            None => [self.lean(), 0.0, 0.0, rate, x, y],
        }
    }
}

impl Rig {
    /// A firing through its flight, until the axle is back at its height or a foot touches; none
    /// where the robot does not jump, or cannot be simulated.
    pub fn flown(&self, firing: &Firing, settings: Settings) -> Option<Flown> {
        let mut shot = Shot::new(self, [firing.lean, firing.rate], settings).ok()?;
        let mut rows = vec![shot.readings()];
        let mut is_fired = false;
        // A spring may pull the leg back in before it lands.
        let mut reached = 0.0_f64;
        while shot.time() < LONGEST {
            let until = rows.len() as f64 * TICK;
            if !is_fired && until > firing.on + 0.5 * TICK {
                shot.fire(firing.opening).ok()?;
                is_fired = true;
            }
            shot.go(until, &[]).ok()?;
            let q = shot.sim.coordinates();
            let (lean, extension) = (shot.lean(), q[self.extension_coordinate(0)]);
            reached = reached.max(extension);
            if let Some(lift_off) = shot.lift_off {
                let height = self.axle(q)[1];
                // The foot left the ground as the axle rose; it comes back where the axle falls to
                // its height over it.
                let foot = height - (self.radius + extension) * lean.cos();
                if !is_fired {
                    return None;
                }
                if height < self.radius || (foot < 0.0 && until > lift_off + 0.03) {
                    let is_jump = until > lift_off + LEAST_FLIGHT && reached > LEAST_EXTENSION;
                    return is_jump.then_some(Flown { lift_off, rows });
                }
            } else if until > firing.on + LONGEST_STANCE || lean.abs() > 1.5 {
                return None;
            }
            rows.push(shot.readings());
        }
        None
    }

    /// Distance and apex (m) of a jump that is commanded at its start; none where it is no jump.
    pub fn landed(&self, launch: &Launch, settings: Settings) -> Option<[f64; 2]> {
        let mut shot = Shot::new(self, [launch.lean, launch.rate], settings).ok()?;
        shot.fire(launch.valve_open).ok()?;
        let rising = |_: f64, q: &[f64], v: &[f64]| self.axle_rates(q, v)[1];
        let above = |_: f64, q: &[f64], _: &[f64]| self.axle(q)[1] - self.radius;
        let mut apex = None;
        while shot.time() < LONGEST {
            let stood = shot.lift_off.is_none();
            let watches: &[Watch<'_>] = match apex {
                _ if stood => &[],
                None => &[&rising],
                Some(_) => &[&above],
            };
            let step = if stood { TICK } else { 4.0 * TICK };
            let pause = shot.go(shot.time() + step, watches).ok()?;
            let (q, v) = (shot.sim.coordinates(), shot.sim.velocities());
            match (pause, apex) {
                (Pause::Watch(_), None) => apex = Some(self.axle(q)[1]),
                (Pause::Watch(_), Some(apex)) => return Some([self.axle(q)[0], apex]),
                (Pause::Time, _) => {}
            }
            let leaves = stood && shot.lift_off.is_some();
            let falls =
                leaves && (rising(0.0, q, v) <= 0.0 || q[self.extension_coordinate(0)] <= 0.0);
            let stays = shot.lift_off.is_none() && (shot.time() > 1.0 || shot.lean().abs() > 1.5);
            if falls || stays {
                return None;
            }
        }
        None
    }

    /// What stands on the foot (N) of the robot at rest.
    fn resting_force(&self) -> f64 {
        let length = self.boom.unwrap_or(1.0);
        // Along the boom, from its base; what is on the axle is a boom away.
        let arm = |name: &str, center: f64| match name {
            "boom" | "boom turn" => center,
            "boom's outer half" => center + 0.5 * length,
            _ => length,
        };
        let bodies = self.mechanism.tree.bodies().iter();
        let moment: f64 = bodies.map(|b| b.mass * arm(&b.name, b.center.y)).sum();
        -self.mechanism.gravity.z * moment / length
    }
}
