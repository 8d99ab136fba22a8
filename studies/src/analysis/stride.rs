//! A stride as a map: from "the leg in the zone reaches a lean" to the next leg's doing so.

use std::f64::consts::{PI, TAU};

use saltus_gait::GaitError;
use saltus_numeric::parallel;
use saltus_robot::Robot;
use saltus_sim_check::{Happening, LegStart, Pause, Rig, Settings, Sim, SimError, Stepping, Watch};

use crate::require;

/// How a robot runs, for a map of its strides: an ideal controller, without sensors and cycles, fires
/// the leg in the zone at the instant at which its lean reaches the firing angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Firing {
    /// Firing angle α_f (rad).
    pub angle: f64,
    /// Valve opening time t_v (s), ≥ 0; with 0 nothing is fired.
    pub valve_open: f64,
    /// Lean (rad) of the leg in the zone at which a stride begins and ends.
    pub section: f64,
}

impl Firing {
    /// Fires at `angle` (rad) for `valve_open` (s). A stride begins where the leg in the zone is
    /// upright, or where it fires, if that is earlier: there the valves are at rest, as a rule.
    pub fn new(angle: f64, valve_open: f64) -> Firing {
        Firing {
            angle,
            valve_open,
            section: angle.min(0.0),
        }
    }
}

/// A robot on the section, with the leg in the zone as leg 0 and its axle at travel 0.
#[derive(Clone, Debug, PartialEq)]
pub struct StrideState {
    /// Coordinates, as [`Rig`] has them.
    pub coordinates: Vec<f64>,
    /// Velocities.
    pub velocities: Vec<f64>,
    /// What each leg's chamber and valve do, at times from now on.
    pub legs: Vec<LegStart>,
    /// Whether leg 0 has been fired since it is in the zone.
    pub has_fired: bool,
}

/// A stride: one leg.
#[derive(Clone, Debug, PartialEq)]
pub struct Stride {
    /// The state at its end.
    pub state: StrideState,
    /// How long it took (s).
    pub time: f64,
    /// How far the axle went (m).
    pub travel: f64,
    /// Gas from the supply (kg).
    pub gas: f64,
    /// Work of the drives (J).
    pub work: f64,
    /// Firings: none or one.
    pub firings: usize,
    /// What touched and left in it, by the leg's number at its start and whether it touched: which
    /// strides are alike.
    pub contacts: Vec<(usize, bool)>,
    /// Contacts of other parts than feet.
    pub bumps: usize,
}

/// The strides of a robot.
#[derive(Clone, Debug)]
pub struct Strides {
    rig: Rig,
    firing: Firing,
    settings: Settings,
    patience: f64,
    pitch: f64,
    ambient: f64,
    threads: usize,
}

/// Time (s) after which a stride that has not ended counts as a stall: that of ten at walking speed.
const PATIENCE: f64 = 1.5;

impl Strides {
    /// Those of `robot` under `firing`, computed by events.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a firing that cannot be, or a boom on a slope, where no stride is
    /// like another; [`GaitError::Sim`] for a robot that is no rig.
    pub fn new(robot: &Robot, firing: Firing) -> Result<Strides, GaitError> {
        let legs = robot.body.legs;
        let allowed = "from 3 to 12, for a robot that runs";
        require((3..=12).contains(&legs), "legs", f64::from(legs), allowed)?;
        let pitch = TAU / f64::from(legs);
        let level = robot.boom.is_none() || robot.ground.tilt == 0.0;
        let tilt = robot.ground.tilt;
        require(
            level,
            "slope (rad)",
            tilt,
            "0 for a robot on a boom, which runs in a circle",
        )?;
        // The axle comes back to travel 0, not to another height.
        let floor = robot.ground.slope;
        require(
            floor == 0.0,
            "slope of the floor (rad)",
            floor,
            "0: every stride begins at the same height; a tilt of the whole ground may differ",
        )?;
        let inside = |x: f64| x.abs() < pitch;
        let allowed = format!("within {pitch:.4} rad");
        require(
            inside(firing.angle),
            "firing angle (rad)",
            firing.angle,
            &*allowed,
        )?;
        let behind = firing.angle - firing.section;
        let allowed = "less than a pitch from the firing angle";
        require(
            inside(behind),
            "lean of the section (rad)",
            firing.section,
            allowed,
        )?;
        let opens = (0.0..=1.0).contains(&firing.valve_open);
        require(
            opens,
            "valve opening time (s)",
            firing.valve_open,
            "from 0 to 1 s",
        )?;
        Ok(Strides {
            rig: Rig::new(robot, &[])?,
            firing,
            settings: Settings {
                accounts: true,
                ..Settings::default()
            },
            patience: PATIENCE,
            pitch,
            ambient: robot.environment.ambient.0,
            threads: parallel::available(),
        })
    }

    /// The same, computed by other steps.
    pub fn by(mut self, stepping: Stepping) -> Strides {
        self.settings.stepping = stepping;
        self
    }

    /// The same, with another tolerance of the steps by events.
    pub fn within(mut self, tolerance: f64) -> Strides {
        self.settings.tolerance = tolerance;
        self
    }

    /// The same, whose differences are taken on so many threads: they change no number.
    pub fn on(mut self, threads: usize) -> Strides {
        self.threads = threads;
        self
    }

    /// Threads on which differences are taken.
    pub(crate) fn threads(&self) -> usize {
        self.threads
    }

    /// The rig.
    pub fn rig(&self) -> &Rig {
        &self.rig
    }

    /// How it fires.
    pub fn firing(&self) -> Firing {
        self.firing
    }

    /// The robot on the foot of leg 0 at the lean `lean` (rad), retracted, turning at `rate` (rad/s)
    /// without slipping, nothing fired yet.
    ///
    /// # Errors
    /// As [`Rig::stand`].
    pub fn standing(&self, lean: f64, rate: f64) -> Result<StrideState, GaitError> {
        let (coordinates, velocities) = self.rig.stand(lean, rate)?;
        let at_rest = LegStart {
            pressure: self.ambient,
            valve: None,
        };
        Ok(StrideState {
            coordinates,
            velocities,
            legs: vec![at_rest; self.rig.legs.len()],
            has_fired: lean > self.firing.angle,
        })
    }

    /// The stride from `state`; none where it stalls: the next leg does not come to the section.
    ///
    /// # Errors
    /// [`GaitError::Sim`] for a state that cannot be, or where the motion cannot go on.
    pub fn stride(&self, state: &StrideState) -> Result<Option<Stride>, GaitError> {
        Walk::new(self, state)?.stride()
    }

    /// At most so many strides in one go; fewer where it stalls.
    ///
    /// # Errors
    /// As [`stride`](Self::stride).
    pub fn strides(&self, state: &StrideState, count: usize) -> Result<Vec<Stride>, GaitError> {
        let mut walk = Walk::new(self, state)?;
        let mut done = Vec::new();
        while done.len() < count
            && let Some(stride) = walk.stride()?
        {
            done.push(stride);
        }
        Ok(done)
    }
}

/// A run from section to section.
pub struct Walk<'a> {
    of: &'a Strides,
    sim: Sim<'a>,
    /// The leg in the zone, its turns counted in: its lean is φ − `leg` · pitch.
    leg: i64,
    has_fired: bool,
    /// When each leg's valve was last told to open and to close (s).
    valves: Vec<Option<[f64; 2]>>,
    /// Time (s), travel (m), gas (kg) and work (J) at the start of the stride.
    before: [f64; 4],
}

impl<'a> Walk<'a> {
    /// From `state` on.
    ///
    /// # Errors
    /// [`GaitError::Sim`] for a state that cannot be.
    pub fn new(of: &'a Strides, state: &StrideState) -> Result<Walk<'a>, GaitError> {
        let mechanism = &of.rig.mechanism;
        let (q, v) = (&state.coordinates, &state.velocities);
        let sim = Sim::in_motion(mechanism, q, v, &state.legs, of.settings)?;
        let mut walk = Walk {
            of,
            sim,
            leg: 0,
            has_fired: state.has_fired,
            valves: state.legs.iter().map(|leg| leg.valve).collect(),
            before: [0.0; 4],
        };
        walk.before = walk.counts();
        Ok(walk)
    }

    /// The simulation.
    pub fn sim(&self) -> &Sim<'a> {
        &self.sim
    }

    /// Goes on to the next leg's section; none where it stalls.
    ///
    /// # Errors
    /// [`GaitError::Sim`] where the motion cannot go on.
    pub fn stride(&mut self) -> Result<Option<Stride>, GaitError> {
        let until = self.sim.time() + self.of.patience;
        let Firing { angle, section, .. } = self.of.firing;
        let mut firings = 0;
        self.sim.drain_events();
        // The leg in the zone fires, or the next one before it is at the section.
        for (leg, fired) in [(self.leg, self.has_fired), (self.leg + 1, angle >= section)] {
            if fired || self.of.firing.valve_open == 0.0 {
                continue;
            }
            if leg > self.leg && angle > section {
                break;
            }
            if !self.reach(leg, angle, until)? {
                return Ok(None);
            }
            self.fire(leg)?;
            firings += 1;
        }
        if !self.reach(self.leg + 1, section, until)? {
            return Ok(None);
        }
        self.has_fired = angle < section;
        self.leg += 1;
        Ok(Some(self.stride_done(firings)))
    }

    /// Goes on until `leg` leans by `lean` (rad), at once where it does already; whether it came to
    /// do so before `until` (s).
    fn reach(&mut self, leg: i64, lean: f64, until: f64) -> Result<bool, SimError> {
        let at = self.of.rig.lean_coordinate();
        let target = lean + leg as f64 * self.of.pitch;
        let to_go = |_: f64, q: &[f64], _: &[f64]| target - q[at];
        if to_go(0.0, self.sim.coordinates(), &[]) <= 1e-12 {
            return Ok(true);
        }
        // Rocking back by half a turn is no running.
        let back = target - PI;
        let fell = move |_: f64, q: &[f64], _: &[f64]| q[at] - back;
        let watches: [Watch<'_>; 2] = [&to_go, &fell];
        Ok(self.sim.run(until, &watches)? == Pause::Watch(0))
    }

    /// The robot's leg that is `leg`, its turns counted in.
    fn on_robot(&self, leg: i64) -> usize {
        let legs = i64::try_from(self.valves.len()).unwrap_or(1);
        usize::try_from(leg.rem_euclid(legs)).unwrap_or(0)
    }

    fn fire(&mut self, leg: i64) -> Result<(), SimError> {
        let leg = self.on_robot(leg);
        let opening = self.of.firing.valve_open;
        let drive = &self.of.rig.mechanism.legs[leg].leg;
        let (from, until) = drive.answers(self.sim.time(), opening);
        self.valves[leg] = until.map(|until| [from, until]);
        self.sim.fire(leg, opening)
    }

    fn counts(&self) -> [f64; 4] {
        let (mut gas, mut work) = (0.0, 0.0);
        for leg in 0..self.valves.len() {
            let account = self.sim.account(leg);
            gas += account.supplied;
            work += account.drive;
        }
        let travel = self.of.rig.axle(self.sim.coordinates())[0];
        [self.sim.time(), travel, gas, work]
    }

    fn stride_done(&mut self, firings: usize) -> Stride {
        let counts = self.counts();
        let [time, travel, gas, work] = std::array::from_fn(|k| counts[k] - self.before[k]);
        self.before = counts;
        let legs = self.valves.len();
        let shift = self.on_robot(self.leg - 1);
        let (mut contacts, mut bumps) = (Vec::new(), 0);
        for event in self.sim.drain_events() {
            let (point, touched) = match event.what {
                Happening::TouchDown(point, _) => (point, true),
                Happening::LiftOff(point, _) => (point, false),
                _ => continue,
            };
            if point < legs {
                contacts.push(((point + legs - shift) % legs, touched));
            } else {
                bumps += usize::from(touched);
            }
        }
        Stride {
            state: self.state(),
            time,
            travel,
            gas,
            work,
            firings,
            contacts,
            bumps,
        }
    }

    /// The present state, with the leg in the zone as leg 0.
    fn state(&self) -> StrideState {
        let rig = &self.of.rig;
        let legs = rig.legs.len();
        let shift = self.on_robot(self.leg);
        let (q, v) = (self.sim.coordinates(), self.sim.velocities());
        let (mut coordinates, mut velocities) = (q.to_vec(), v.to_vec());
        coordinates[0] = 0.0;
        coordinates[rig.lean_coordinate()] -= self.leg as f64 * self.of.pitch;
        let mut starts = Vec::new();
        for leg in 0..legs {
            let old = (leg + shift) % legs;
            let (to, from) = (rig.legs[leg], rig.legs[old]);
            let tree = &rig.mechanism.tree;
            coordinates[tree.coordinate_of(to)] = q[tree.coordinate_of(from)];
            velocities[tree.velocity_of(to)] = v[tree.velocity_of(from)];
            let now = self.sim.time();
            let left = self.valves[old].map(|valve| valve.map(|t| t - now));
            starts.push(LegStart {
                pressure: self.sim.pressure(old),
                valve: left.filter(|[_, until]| *until > 0.0),
            });
        }
        StrideState {
            coordinates,
            velocities,
            legs: starts,
            has_fired: self.has_fired,
        }
    }
}
