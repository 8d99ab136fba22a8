//! A run: from rest, or rolling, for so long.

use std::collections::VecDeque;
use std::f64::consts::TAU;

use rand_pcg::Pcg64;
use saltus_controller::run::{
    Action, Gait, Hold, Leap, MOST_TAPS, Readings, Runner, Signals, Stall, Standing,
};
use saltus_robot::{Robot, Sensors};
use saltus_sim_check::{Contact, Happening, Ledger, Rig, Stepping, Surface};

use crate::box_table::BoxTable;
use crate::cast::instruments;
use crate::error::ensure;
use crate::law::Compiled;
use crate::learnt::Deciding;
use crate::senses::Senses;
use crate::sensors::Ranging;
use crate::surroundings::{Disturbance, Surroundings};
use crate::world::{Output, World};
use crate::{GaitError, Program};

/// A run to be run.
#[derive(Clone, Debug)]
pub struct Setup {
    /// The robot.
    pub robot: Robot,
    /// At which lean a leg fires.
    pub program: Program,
    /// Valve opening time t_v (s), where the program does not say one.
    pub valve_open: f64,
    /// Where the active zone begins, z₀ (rad).
    pub zone: f64,
    /// Whether it runs forwards.
    pub forwards: bool,
    /// Weights of the rate's filter: of the newest reading, and of those before it.
    pub taps: Vec<f64>,
    /// How long (s).
    pub seconds: f64,
    /// Speeds to hold: from each time (s) on, a speed (m/s), negative backwards.
    pub speeds: Vec<[f64; 2]>,
    /// How a speed is held.
    pub hold: Option<Hold<f64>>,
    /// Rate (rad/s) and time (s) that make a stall, and whether the run then begins anew.
    pub stall: Stall<f64>,
    /// Firing angle (rad) and valve opening time (s) of the first firings, before the program.
    pub first: Vec<[f64; 2]>,
    /// A jump out of the run.
    pub leap: Option<Leap<f64>>,
    /// What is done about the next of the obstacles, as the range sensor sees it.
    pub ahead: Option<BoxTable>,
    /// What disturbs.
    pub disturbances: Vec<Disturbance>,
    /// Boxes on the ground.
    pub obstacles: Vec<Obstacle>,
    /// Whether the boxes can be touched; else the robot goes through them, and [`Summary`] says how
    /// near it came.
    pub solid: bool,
    /// How the motion is computed.
    pub stepping: Stepping,
    /// Seed of the sensors' noise.
    pub seed: u64,
}

impl Setup {
    /// `robot` from rest under `program`, for `seconds` (s).
    pub fn new(robot: Robot, program: Program, seconds: f64) -> Setup {
        Setup {
            robot,
            program,
            valve_open: 0.04,
            zone: 0.0,
            forwards: true,
            taps: vec![0.2; 5],
            seconds,
            speeds: Vec::new(),
            hold: None,
            stall: Stall {
                rate: 0.5,
                time: 0.5,
                restarts: false,
            },
            first: Vec::new(),
            leap: None,
            ahead: None,
            disturbances: Vec::new(),
            obstacles: Vec::new(),
            solid: true,
            stepping: Stepping::USUAL,
            seed: 1,
        }
    }

    /// The sensors of its robot.
    pub fn sensors(&self) -> Sensors {
        self.robot.sensors.unwrap_or_default()
    }

    /// Gives the constants of the robot's controller to `take`.
    ///
    /// # Errors
    /// [`GaitError`] for a run that cannot be.
    pub fn flashed<T>(&self, take: impl FnOnce(&Gait<'_, f64>) -> T) -> Result<T, GaitError> {
        let compiled = self.compiled()?;
        Ok(take(&gait(self, &compiled)))
    }

    fn compiled(&self) -> Result<Compiled, GaitError> {
        self.check()?;
        let pitch = TAU / f64::from(self.robot.body.legs);
        self.program.compile(self.valve_open, (self.zone, pitch))
    }

    fn check(&self) -> Result<(), GaitError> {
        let legs = self.robot.body.legs;
        let pitch = TAU / f64::from(legs);
        let (half, seconds) = (0.5 * pitch, self.seconds);
        let (count, sum) = (self.taps.len(), self.taps.iter().sum::<f64>());
        ensure! {
            "legs", f64::from(legs), (3..=12).contains(&legs) => "from 3 to 12, for a robot that runs";
            "start of the active zone (rad)", self.zone, (-half..=half).contains(&self.zone)
                => format!("from {:.4} to {half:.4} rad, half a pitch", -half);
            "length of the run (s)", seconds, seconds > 0.0 && seconds <= LONGEST
                => format!("above 0, at most {LONGEST} s");
            "taps of the filter", count as f64, (1..=MOST_TAPS).contains(&count)
                => format!("from 1 to {MOST_TAPS}");
            "sum of the filter's taps", sum, sum.is_finite() && sum.abs() > 1e-9
                => "a number other than 0";
        }
        let radius = self.robot.body.radius;
        self.obstacles.iter().try_for_each(|o| o.check(radius))?;
        let mut before = f64::NEG_INFINITY;
        for [time, speed] in &self.speeds {
            ensure! {
                "time of a speed (s)", *time, *time > before && time.is_finite()
                    => format!("a time after the one before it, {before} s");
                "speed (m/s)", *speed, speed.abs() <= 10.0 => "from -10 to 10 m/s";
            }
            before = *time;
        }
        Ok(())
    }
}

/// A box on the ground, across the robot's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Obstacle {
    /// From the axle at the start to its front (m), along the travel.
    pub front: f64,
    /// Its length along the travel (m).
    pub length: f64,
    /// Its height (m).
    pub height: f64,
}

impl Obstacle {
    pub(crate) fn check(&self, radius: f64) -> Result<(), GaitError> {
        let Obstacle {
            front,
            length,
            height,
        } = *self;
        let sound = |x: f64| x > 0.0 && x <= 10.0;
        let short = "above 0, at most 10 m";
        ensure! {
            "front of the obstacle (m)", front, front >= radius && front <= 1e4
                => format!("from {radius} m, the robot's radius, to 10000 m");
            "length of the obstacle (m)", length, sound(length) => short;
            "height of the obstacle (m)", height, sound(height) => short;
        }
        Ok(())
    }
}

/// Farthest from an obstacle (m) at which the distance to it is measured.
const BESIDE: f64 = 0.8;
/// Longest run (s).
const LONGEST: f64 = 1e5;
/// Time (s) over which speeds are means: about one stride at running speed.
const MEAN: f64 = 0.15;
/// Time (s) at the end over which the last speed is a mean.
const LAST: f64 = 4.0;
/// Height (m) above which a foot has left what it stood on. A foot that bears rattles by tenths of a millimetre, while a leg
/// that is swung clears some centimetres.
const LEFT: f64 = 1e-3;
/// Speed (m/s) below which a robot whose wheel does not turn stands still: above it, it flies.
const STANDS: f64 = 0.1;

/// The robot at the begin of a cycle, and what was decided.
#[derive(Clone, Debug)]
pub struct Row<'r> {
    /// Time (s).
    pub time: f64,
    /// Time (s) to the next cycle.
    pub period: f64,
    /// Travel and height of the axle (m).
    pub axle: [f64; 2],
    /// Their rates (m/s).
    pub axle_rates: [f64; 2],
    /// Lean of leg 0 (rad), counted on through every turn.
    pub lean: f64,
    /// Rate of the wheel (rad/s).
    pub rate: f64,
    /// All coordinates.
    pub coordinates: &'r [f64],
    /// All velocities.
    pub velocities: &'r [f64],
    /// Extension of each leg (m).
    pub extensions: &'r [f64],
    /// Chamber pressure of each leg (Pa, absolute).
    pub pressures: &'r [f64],
    /// What the sensors said.
    pub readings: Readings,
    /// What the controller decided. The opening time of a valve that a policy holds open is infinite.
    pub action: Action<f64>,
    /// The output to each valve in this cycle.
    pub outputs: &'r [Output],
    /// Whether it has stood still for the time that makes a stall, though it was to run.
    pub stands: bool,
    /// The contacts that are closed, with their forces, where the follower
    /// [asks](Run::asks_contacts) for them.
    pub contacts: &'r [Contact],
}

/// A leg that touches down: its foot, which was more than 1 mm above what it may stand on, touches the ground. A foot that
/// rebounds by less has not ended its stance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footfall {
    /// When (s).
    pub time: f64,
    /// Its leg.
    pub leg: usize,
    /// Travel of the axle (m) then.
    pub travel: f64,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Ending {
    /// It ran, or rolled, to the end of its time.
    #[default]
    Ran,
    /// It stood still at the end, since a time (s), at a travel (m).
    Stalled {
        /// Since when (s).
        since: f64,
        /// Where (m).
        at: f64,
    },
}

/// What a run came to. Travels and speeds are positive forwards, also where the robot runs backwards.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    /// How it ended.
    pub ending: Ending,
    /// How long it ran (s).
    pub time: f64,
    /// Travel (m).
    pub travel: f64,
    /// Way (m): travel without sign, summed over the stretches between turns of the demanded speed.
    pub way: f64,
    /// Mean speed (m/s).
    pub mean_speed: f64,
    /// Mean speed over the last 4 s (m/s); none for a shorter run.
    pub mean_speed_last_4_s: Option<f64>,
    /// Speed at the end (m/s), as a mean over 0.15 s.
    pub speed_at_end: f64,
    /// Greatest speed in the direction of the run (m/s), as a mean over 0.15 s.
    pub top_speed: f64,
    /// Speed (m/s) as a mean over the 0.15 s before 1.6 s; none for a shorter run.
    pub speed_at_1_6: Option<f64>,
    /// When it reached 3.2 m/s in the direction of the run (s), as a mean over 0.15 s.
    pub reached_3_2: Option<f64>,
    /// When it had travelled 1.6 m in the direction of the run (s).
    pub time_to_1_6_m: Option<f64>,
    /// Firings.
    pub firings: usize,
    /// Touch-downs of legs on the ground: [`Footfall`].
    pub touch_downs: usize,
    /// Whether each disturbance of the setup was there.
    pub disturbed: Vec<bool>,
    /// Contacts of other parts, or with obstacles: when (s), the part, the surface.
    pub bumps: Vec<(f64, String, usize)>,
    /// How many bumps there were in all, of which the first hundred are listed.
    pub bump_count: usize,
    /// Least distance (m) to each obstacle.
    pub clearances: Vec<f64>,
    /// Gas from the supply (kg).
    pub gas: f64,
    /// Work of each leg's drive (J).
    pub leg_work: Vec<f64>,
    /// What each leg lost (J): in friction and dampers.
    pub leg_loss: Vec<f64>,
    /// Energy at the start.
    pub start: Ledger,
    /// Energy at the end.
    pub ledger: Ledger,
    /// Energy (J) that no entry of the ledger explains.
    pub residual: f64,
    /// The same of the gas (J): n R T times what flowed, less what it became.
    pub gas_residual: f64,
    /// The rear leg of the two on which the controller found itself at the start.
    pub rear: u32,
}

impl Summary {
    /// Mean speed over the last 4 s (m/s), over all of a shorter run.
    pub fn late_speed(&self) -> f64 {
        self.mean_speed_last_4_s.unwrap_or(self.mean_speed)
    }
}

impl Row<'_> {
    /// The firing angle (rad) that held; none where no leg was to fire.
    pub fn firing_angle(&self) -> Option<f64> {
        let angle = self.action.firing_angle;
        (angle < std::f64::consts::PI).then_some(angle)
    }
}

/// What follows a run as it goes.
pub trait Run {
    /// A cycle.
    fn row(&mut self, row: &Row<'_>);
    /// A foot that comes down on the ground.
    fn footfall(&mut self, footfall: &Footfall);
    /// Whether the row of `time` (s) is to have its contacts, which cost about a step.
    fn asks_contacts(&mut self, time: f64) -> bool {
        let _ = time;
        false
    }
    /// Whether the run goes on; it ends early, with what it came to so far, where not.
    fn goes_on(&mut self) -> bool {
        true
    }
}

/// Nothing follows.
impl Run for () {
    fn row(&mut self, _: &Row<'_>) {}
    fn footfall(&mut self, _: &Footfall) {}
}

/// Runs `setup`; `follower` sees every cycle.
///
/// # Errors
/// [`GaitError`] for a run that cannot be, or a motion that cannot go on.
pub fn run(setup: &Setup, follower: &mut impl Run) -> Result<Summary, GaitError> {
    let compiled = setup.compiled()?;
    let plain = Rig::new(&setup.robot, &[])?;
    let across = |o: &Obstacle| plain.box_across(o.front, o.length, o.height);
    let boxes: Vec<Surface> = setup.obstacles.iter().map(across).collect();
    let solid: &[Surface] = if setup.solid { &boxes } else { &[] };
    let surroundings = Surroundings::new(&setup.robot, solid, &setup.disturbances)?;
    let q = surroundings.rig.rest(0)?;
    let v = vec![0.0; surroundings.rig.mechanism.tree.velocities()];
    let sensors = setup.sensors();
    let random = Pcg64::new(u128::from(setup.seed), 0x5a17);
    let world = World::new(&surroundings, sensors, setup.stepping, (&q, &v), random)?;
    let gait = gait(setup, &compiled);
    Loop::new(setup, world, &gait, (boxes, follower))?.go()
}

/// The count nearest to `x`, ≥ 0.
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn counted(x: f64) -> usize {
    x.round() as usize
}

/// The controller's constants.
fn gait<'s>(setup: &'s Setup, compiled: &'s Compiled) -> Gait<'s, f64> {
    let sensors = setup.sensors();
    Gait {
        law: compiled.law(),
        zone: setup.zone,
        legs: setup.robot.body.legs,
        period: sensors.period,
        instruments: instruments(&sensors),
        taps: &setup.taps,
        hold: setup.hold,
        stall: setup.stall,
        first: &setup.first,
        leap: setup.leap,
        ahead: setup.ahead.as_ref().map(BoxTable::ahead),
    }
}

/// The rear leg on which the robot finds itself, and its wheel's count there.
fn find_stand(
    setup: &Setup,
    world: &mut World<'_>,
    gait: &Gait<'_, f64>,
) -> Result<(u32, i32), GaitError> {
    let signals = Signals::new(gait.instruments, gait.taps);
    let mut standing = Standing::new();
    let mut wheel = 0;
    for _ in 0..200 {
        let readings = world.read().readings;
        standing.take(&signals, &readings);
        wheel = readings.wheel;
    }
    let gravity = setup.robot.environment.gravity;
    match standing.rear_leg(&signals, gait.legs, gravity) {
        Ok(rear) => Ok((rear, wheel)),
        Err(unsure) => Err(GaitError::Unsure(unsure)),
    }
}

struct Loop<'a, 's, F> {
    setup: &'s Setup,
    world: World<'a>,
    runner: Runner<'s, f64>,
    /// What decides in place of the runner.
    learnt: Option<Deciding<'s>>,
    follower: &'s mut F,
    boxes: Vec<Surface>,
    ranging: Ranging,
    /// Travels (m) of the last 0.15 s.
    recent: VecDeque<f64>,
    /// Cycles in 0.15 s.
    window: usize,
    /// Since when (s) and where (m) it stands still.
    still: Option<(f64, f64)>,
    /// Demanded speed (m/s), and the travel (m) at its last turn.
    demand: Option<f64>,
    turned_at: f64,
    /// Whether it is to stand.
    is_to_stand: bool,
    extensions: Vec<f64>,
    pressures: Vec<f64>,
    summary: Summary,
    stored: f64,
    /// Gas (kg) at the start in the tank and in all chambers, where they are fed from one.
    carried: Option<f64>,
    /// Travels (m) of the last 4 s.
    late: VecDeque<f64>,
    /// Whether the foot of each leg has left what it stood on.
    aloft: Vec<bool>,
}

impl<'a, 's, F: Run> Loop<'a, 's, F> {
    fn new(
        setup: &'s Setup,
        mut world: World<'a>,
        gait: &Gait<'s, f64>,
        (boxes, follower): (Vec<Surface>, &'s mut F),
    ) -> Result<Loop<'a, 's, F>, GaitError> {
        let legs = setup.robot.body.legs as usize;
        let (rear, wheel) = find_stand(setup, &mut world, gait)?;
        let period = gait.period;
        let runner = Runner::new(*gait, rear, wheel, setup.forwards);
        let learnt = match &setup.program {
            Program::Learnt(learnt) => {
                let senses = Senses::new(&setup.robot, setup.zone);
                let Stall { rate, time, .. } = setup.stall;
                Some(Deciding::new(learnt, senses, (legs, period), [rate, time]))
            }
            _ => None,
        };
        let ledger = world.sim().ledger();
        let stored = (0..legs).map(|leg| world.sim().stored_gas(leg)).sum();
        let carried = world.sim().gas();
        Ok(Loop {
            setup,
            world,
            runner,
            learnt,
            follower,
            boxes,
            ranging: Ranging::new(setup.sensors(), setup.seed),
            recent: VecDeque::new(),
            window: counted(MEAN / period).max(1),
            still: None,
            demand: None,
            turned_at: 0.0,
            is_to_stand: false,
            extensions: vec![0.0; legs],
            pressures: vec![0.0; legs],
            summary: Summary {
                clearances: vec![f64::INFINITY; setup.obstacles.len()],
                leg_work: vec![0.0; legs],
                leg_loss: vec![0.0; legs],
                start: ledger,
                ledger,
                rear,
                ..Summary::default()
            },
            stored,
            carried,
            late: VecDeque::new(),
            aloft: vec![false; legs],
        })
    }

    fn go(mut self) -> Result<Summary, GaitError> {
        let period = self.setup.sensors().period;
        let cycles = counted((self.setup.seconds / period - 1e-9).ceil());
        let lately = counted(LAST / period).max(1);
        let mut ran = cycles;
        for cycle in 0..cycles {
            if !self.follower.goes_on() {
                ran = cycle;
                break;
            }
            let now = self.world.read();
            let later = |speed: &&[f64; 2]| speed[0] <= now.time + 1e-9;
            if let Some([_, speed]) = self.setup.speeds.iter().rev().find(later) {
                self.turn(*speed);
                self.runner.demand(*speed);
            }
            if self.setup.ahead.is_some() {
                let travel = self.travel();
                let fronts = self.setup.obstacles.iter().map(|o| o.front);
                let seen = self.ranging.read(now.time, travel, fronts);
                if let Some(distance) = seen {
                    self.runner.sense(distance);
                }
            }
            let (action, command) = if let Some(learnt) = &mut self.learnt {
                learnt.step(&now, &self.world)
            } else {
                let action = self.runner.step(&now.readings);
                let fire = action.leg.map(|leg| (leg as usize, action.valve_open));
                (action, fire.into())
            };
            self.world.command(command)?;
            self.tell(now.time, now.readings, action);
            if self.late.len() == lately {
                self.late.pop_front();
            }
            let travel = self.travel();
            self.late.push_back(travel);
            self.summary.firings += usize::from(action.leg.is_some());
            let rig = self.world.rig();
            let gaps = rig.foot_gaps(self.world.looked_at().coordinates());
            for (aloft, gap) in self.aloft.iter_mut().zip(gaps) {
                *aloft |= gap > LEFT;
            }
            let (summary, aloft) = (&mut self.summary, &mut self.aloft);
            let mut fell = Vec::new();
            self.world.go_on(|event| {
                if let Happening::TouchDown(point, surface) = event.what {
                    if surface == 0 && point < rig.legs.len() {
                        if std::mem::take(&mut aloft[point]) {
                            summary.touch_downs += 1;
                            fell.push((event.time, point));
                        }
                    } else {
                        summary.bump_count += 1;
                        if summary.bumps.len() < 100 {
                            let name = rig.mechanism.points[point].name.clone();
                            summary.bumps.push((event.time, name, surface));
                        }
                    }
                }
            })?;
            let travel = self.travel();
            for (time, leg) in fell {
                self.follower.footfall(&Footfall { time, leg, travel });
            }
        }
        Ok(self.finish(ran as f64 * period))
    }

    /// Takes up the demanded speed `speed` (m/s).
    fn turn(&mut self, speed: f64) {
        if self.demand.is_some_and(|before| before * speed < 0.0) {
            let travel = self.travel();
            self.summary.way += (travel - self.turned_at).abs();
            self.turned_at = travel;
        }
        if speed != 0.0 || self.demand.is_none() {
            self.demand = Some(speed);
        }
        self.is_to_stand = speed == 0.0;
    }

    fn travel(&mut self) -> f64 {
        let rig = self.world.rig();
        rig.axle(self.world.sim().coordinates())[0]
    }

    /// Tells the follower of a cycle, and keeps count of it.
    fn tell(&mut self, time: f64, readings: Readings, action: Action<f64>) {
        let rig = self.world.rig();
        let asked = self.follower.asks_contacts(time);
        let contacts = if asked {
            self.world.sim().contacts()
        } else {
            Vec::new()
        };
        let sim = self.world.looked_at();
        for leg in 0..self.extensions.len() {
            self.extensions[leg] = sim.coordinates()[rig.extension_coordinate(leg)];
            self.pressures[leg] = sim.pressure(leg);
        }
        let (q, v) = (sim.coordinates(), sim.velocities());
        let axle = rig.axle(q);
        let travel = axle[0];
        if self.recent.len() > self.window {
            self.recent.pop_front();
        }
        self.recent.push_back(travel);
        let period = self.setup.sensors().period;
        let oldest = self.recent.front().copied().unwrap_or(travel);
        let speed = (travel - oldest) / (self.window as f64 * period);
        let ahead = if self.setup.forwards { 1.0 } else { -1.0 };
        let stall = self.setup.stall;
        if speed.abs() >= STANDS || action.rate.abs() >= stall.rate {
            self.still = None;
        } else if action.stalled {
            self.still.get_or_insert((time - stall.time, travel));
        }
        self.follower.row(&Row {
            time,
            period,
            axle,
            axle_rates: rig.axle_rates(q, v),
            lean: q[rig.lean_coordinate()],
            rate: v[rig.lean_velocity()],
            coordinates: q,
            velocities: v,
            extensions: &self.extensions,
            pressures: &self.pressures,
            readings,
            action,
            outputs: self.world.outputs(),
            stands: self.still.is_some() && !self.is_to_stand,
            contacts: &contacts,
        });
        let obstacles = self.setup.obstacles.iter().zip(&self.boxes);
        for ((obstacle, surface), least) in obstacles.zip(&mut self.summary.clearances) {
            let (front, back) = (obstacle.front, obstacle.front + obstacle.length);
            if (front - BESIDE..back + BESIDE).contains(&travel) {
                *least = least.min(rig.clearance(q, surface));
            }
        }
        let s = &mut self.summary;
        if ahead * speed > ahead * s.top_speed {
            s.top_speed = speed;
        }
        s.speed_at_end = speed;
        if s.reached_3_2.is_none() && ahead * speed >= 3.2 {
            s.reached_3_2 = Some(time);
        }
        if s.speed_at_1_6.is_none() && time >= 1.6 - 1e-9 {
            s.speed_at_1_6 = Some(speed);
        }
        if s.time_to_1_6_m.is_none() && ahead * travel >= 1.6 {
            s.time_to_1_6_m = Some(time);
        }
    }

    fn finish(mut self, end: f64) -> Summary {
        let travel = self.travel();
        let legs = self.extensions.len();
        let travel_then = self.late.front().copied().unwrap_or(travel);
        let period = self.setup.sensors().period;
        let lately = self.late.len() as f64 * period;
        let is_to_stand = self.is_to_stand;
        let turned_at = self.turned_at;
        let (stored, carried) = (self.stored, self.carried);
        let gas = self.setup.robot.leg.cylinder().copied();
        let still = self.still;
        let residual = self.world.residual();
        let rig = self.world.rig();
        let sim = self.world.looked_at();
        let mut s = self.summary;
        let mut gas_now = 0.0;
        let mut explained = 0.0;
        for leg in 0..legs {
            let account = sim.account(leg);
            s.gas += account.supplied;
            s.leg_work[leg] = account.drive;
            s.leg_loss[leg] = account.lost;
            gas_now += sim.stored_gas(leg);
            if let Some(chamber) = rig.mechanism.legs[leg].leg.chamber() {
                explained += chamber.pressure_per_mass() * (account.supplied - account.released)
                    - (chamber.exponent() - 1.0) * account.pushed;
            }
        }
        s.gas_residual = gas_now - stored - explained;
        if let Some((before, now)) = carried.zip(sim.gas()) {
            // Of gas with a temperature of its own, what is missing is told as a mass, by the work
            // n R T that it does at the gas temperature.
            let released: f64 = (0..legs).map(|leg| sim.account(leg).released).sum();
            let worth = gas.map_or(0.0, |c| c.gas.heat_ratio * c.gas.constant * c.temperature);
            s.gas_residual = worth * (now + released - before);
        }
        s.time = end;
        s.travel = travel;
        s.way += (travel - turned_at).abs();
        s.mean_speed = travel / end;
        let is_long = self.late.len() >= counted(LAST / period).max(1);
        s.mean_speed_last_4_s = is_long.then_some((travel - travel_then) / lately);
        s.disturbed = self.world.disturbed();
        s.ledger = sim.ledger();
        s.residual = residual;
        if let (Some((since, at)), false) = (still, is_to_stand) {
            s.ending = Ending::Stalled { since, at };
        }
        s
    }
}
