//! A robot with legs all around, which rolls as a disc on those near one plane through its middle.
//!
//! Source: thesis 7.2 and 7.3.

mod balance;
mod disc;
mod drawn;
mod flashed;
mod measured;
mod sensing;
mod steer;

use balance::Course;
pub use balance::Stable;
pub use disc::Facing;
pub use drawn::{DrawnBalls, drawn_ball};
pub use flashed::{Flashed, FlashedPlane};
pub use measured::Measured;
pub use sensing::Hearing;
pub use steer::Steered;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use saltus_controller::ball::{
    Balancer, Estimate, Estimator, Firing, Lying, Pilot, Plane, Rotation, Scales, Sight, Tracker,
    View,
};
use saltus_robot::Robot;
use saltus_robot::space::{Rest, discs, rests};
use saltus_sim_check::{Event, Happening, Ledger, Rig, Settings, Sim, Stepping, Vec3};

use crate::error::ensure;
use crate::law::Compiled;
use crate::{GaitError, Program};
use sensing::{estimator, scales};

/// How a robot rolls from rest.
#[derive(Clone, Debug)]
pub struct Roll {
    /// The robot, in space.
    pub robot: Robot,
    /// Which leg fires when.
    pub gait: Gait,
    /// What it knows of its motion.
    pub knows: Knows,
    /// Where it begins.
    pub start: Start,
    /// How long (s).
    pub seconds: f64,
    /// Steps of the simulation.
    pub stepping: Stepping,
    /// Every how many cycles the forces on the feet are told; 0: never.
    pub forces_every: u64,
}

/// Which leg fires when.
#[derive(Clone, Debug)]
pub enum Gait {
    /// The thesis' rolling disc: twins fire as one leg, and nothing keeps it in its plane.
    ///
    /// Source: thesis 7.2.2.
    Disc(Fires),
    /// What the station on the ground does, and twins that keep the disc upright and its course.
    ///
    /// Source: thesis 7.3.
    Stable(Stable),
    /// The same along a path: it chooses its plane wherever it lies, and goes on from there after a fall.
    ///
    /// Source: thesis 7.2.1 and 8.3.2.
    Steered(Steered),
}

/// Firing angles of the station in the active zone.
#[derive(Clone, Debug)]
pub struct Fires {
    /// The firing angle.
    pub program: Program,
    /// Valve opening time t_v (s), where the program says none.
    pub valve_open: f64,
    /// Lean (rad) at which a station enters the active zone. It stays there until the next one does.
    pub zone: f64,
}

/// What a robot knows of its motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Knows {
    /// All of it.
    Truth,
    /// What its sensors say, whose noise is drawn from this seed.
    Sensors(u64),
}

/// On which feet a robot stands at first, which way it goes, and how far it is off.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Start {
    /// The rest, in the order of [`rests`].
    pub rest: usize,
    /// Which of the ways that are open there: in the order of [`Facing::all`].
    pub way: usize,
    /// Roll (rad) about the heading, right-handed: to the right.
    pub roll: f64,
    /// Turn (rad) of the robot with its disc about the vertical, to the left.
    pub yaw: f64,
    /// How it was thrown down instead, its lowest foot on the ground.
    pub thrown: Option<Thrown>,
}

/// How a robot comes onto the ground that fell, or was thrown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thrown {
    /// Attitude: a unit quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// Angular velocity (rad/s), the world's axes.
    pub spin: [f64; 3],
}

impl Thrown {
    /// Number `k` of those drawn from `seed`: any attitude as likely as any other, and spins of up to `most` (rad/s) about
    /// any axis, uniform in their ball.
    pub fn drawn(seed: u64, k: usize, most: f64) -> Thrown {
        let mut random = Pcg64::new(u128::from(seed), 0x7ba1 + k as u128);
        let mut normal = || StandardNormal.sample(&mut random);
        let attitude = Quaternion::new(normal(), normal(), normal(), normal()).normalize();
        let axis = Vector3::new(normal(), normal(), normal()).normalize();
        let part: f64 = rand_distr::OpenClosed01.sample(&mut random);
        Thrown {
            attitude: [attitude.w, attitude.i, attitude.j, attitude.k],
            spin: (most * part.cbrt() * axis).into(),
        }
    }
}

/// A cycle of a robot that rolls.
#[derive(Clone, Debug, PartialEq)]
pub struct Ball {
    /// Time (s).
    pub time: f64,
    /// Where its legs meet (m): along the first heading, to its left, up.
    pub place: [f64; 3],
    /// Attitude: a unit quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// Velocity of that place (m/s).
    pub velocity: [f64; 3],
    /// Angular velocity (rad/s), the world's axes.
    pub spin: [f64; 3],
    /// How it lies to its plane.
    pub rolling: Lying<f64>,
    /// Stations that have come into the zone.
    pub passed: i32,
    /// Way (m) to the left of the line that it follows; 0 while it turns to it, and where it follows none. Of a path, how far
    /// off it is.
    pub aside: f64,
    /// How it is led along its path.
    pub led: Led,
    /// Legs that fire now.
    pub fired: Vec<Firing<f64>>,
    /// Feet that came onto the ground since the cycle before: each leg, and when (s).
    pub touched: Vec<(usize, f64)>,
    /// Feet on the ground: bit k is leg k's.
    pub touching: u64,
    /// Extension of each leg (m).
    pub extensions: Vec<f64>,
    /// Its rate (m/s).
    pub extension_rates: Vec<f64>,
    /// Force of the ground (N, the world's axes) on feet, each with its leg, where [`Roll::forces_every`] asks for them: its
    /// mean since they were told before, in [adaptive](Stepping::Adaptive) steps what it is now.
    pub forces: Vec<(usize, [f64; 3])>,
    /// Axis of its disc, a unit vector in the body's axes: to the left of the way it rolls.
    pub axis: [f64; 3],
    /// What its sensors say, if it goes by them: rates (rad/s) about the body's axes, specific force (m/s²) along them.
    pub sensed: Option<[[f64; 3]; 2]>,
    /// What it takes its motion for, by its sensors.
    pub estimate: Option<Estimate<f64>>,
}

impl Ball {
    /// What it takes its motion for: by its sensors, or the truth where it goes by that.
    fn known(&self) -> Estimate<f64> {
        self.estimate.unwrap_or(Estimate {
            attitude: Rotation(self.attitude),
            spin: self.spin,
            velocity: self.velocity,
            place: self.place,
        })
    }
}

/// How a robot is led along a path.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Led {
    /// The plane in which it rolls, by its number; none while it comes to rest.
    pub plane: Option<usize>,
    /// How many times it has set out.
    pub starts: u32,
    /// How many points of the path it has come to.
    pub reached: usize,
}

/// How a robot was when it left its plane, or fell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// When (s).
    pub time: f64,
    /// Travel (m).
    pub travel: f64,
    /// Way to the left (m).
    pub aside: f64,
    /// Roll (rad), to the right.
    pub roll: f64,
    /// Its rate (rad/s).
    pub roll_rate: f64,
}

/// What became of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rolled {
    /// How long it ran (s).
    pub time: f64,
    /// Travel (m) along the heading with which it set out.
    pub travel: f64,
    /// Greatest way (m) across it until it left its plane.
    pub aside: f64,
    /// Where it left its plane, if it did.
    pub left: Option<Left>,
    /// Where it fell, if it did: its disc leaned by more than [`FALLS`].
    pub fell: Option<Left>,
    /// Firings, of twins one.
    pub firings: usize,
    /// Energy (J) that no entry of the ledger explains.
    pub residual: f64,
    /// Work (J) of the legs.
    pub work: f64,
    /// Steps whose contact forces obey the laws only nearly, as in [`Ledger`].
    pub approximate: usize,
}

/// Rate of roll (rad/s), and way to a side (m), from which on a robot has left its plane.
const LEAVES: (f64, f64) = (6.0, 0.25);
/// Roll (rad) from which on a robot has fallen: no leg of its disc holds it any more.
pub const FALLS: f64 = 0.8;

impl Roll {
    /// `robot` from its first rest, with the firing angle of 5.1.3 over time, for so many `seconds`.
    ///
    /// Source: thesis 7.2.2, which runs "from rest" by the α_f of 5.1.
    pub fn new(robot: Robot, seconds: f64) -> Roll {
        let program = Program::OpenLoop {
            first: 0.5,
            last: 0.0,
            slope: 2.1,
            centre: crate::Centre::Printed(3.0),
        };
        Roll {
            robot,
            gait: Gait::Disc(Fires {
                program,
                valve_open: 0.05,
                zone: -0.3,
            }),
            knows: Knows::Truth,
            start: Start::default(),
            seconds,
            stepping: Stepping::USUAL,
            forces_every: 0,
        }
    }

    /// The rest and the disc of its start.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, and a rest or a way that it does not have.
    pub fn facing(&self) -> Result<(Rest, Facing), GaitError> {
        let space = self.robot.space.as_ref();
        let allowed = "of a robot in space: body.shape = \"sphere\"";
        ensure! { "legs", f64::from(self.robot.body.legs), space.is_some() => allowed; }
        let directions = space.map(|space| space.directions.vectors());
        let directions = directions.unwrap_or_default();
        let (rests, discs) = (rests(&directions), discs(&directions));
        let Start { rest, way, .. } = self.start;
        let count = rests.len();
        ensure! { "rest", rest as f64, rest < count => format!("below {count}"); }
        let rest = rests[rest].clone();
        let ways = Facing::all(&rest, &discs);
        let allowed = "such that the robot can roll: as it stands, a plane that holds four legs or more has to be upright, and to \
                       be the mirror of the other legs, as those of a dodecahedron are";
        ensure! { "legs.directions", ways.len() as f64, !ways.is_empty() => allowed; }
        let allowed = format!("below {}, the ways open from this rest", ways.len());
        ensure! { "way", way as f64, way < ways.len() => allowed; }
        Ok((rest, ways[way].clone()))
    }

    fn check(&self) -> Result<(), GaitError> {
        let seconds = self.seconds;
        ensure! { "time (s)", seconds, seconds > 0.0 && seconds <= 1e5 => "above 0, at most 100000"; }
        let Start {
            roll, yaw, thrown, ..
        } = self.start;
        if let Some(Thrown { attitude, spin }) = thrown {
            let length = attitude.iter().map(|x| x * x).sum::<f64>().sqrt();
            ensure! { "length of a quaternion", length, (length - 1.0).abs() < 1e-9 => "1"; }
            for x in spin {
                ensure! { "spin (rad/s)", x, x.abs() <= 100.0 => "from -100 to 100 rad/s"; }
            }
        }
        for (name, x) in [("roll (rad)", roll), ("yaw (rad)", yaw)] {
            ensure! { name, x, x.abs() <= 1.0 => "from -1 to 1"; }
        }
        Ok(())
    }
}

/// What decides.
enum Decides<'a> {
    /// A law, with whether the station in the zone waits for its angle.
    Disc(Compiled, bool),
    Stable(Box<Balancer<'a, f64>>, Course),
    Steered(Box<Pilot<'a, f64>>, &'a Steered),
}

/// Runs `roll`, and gives each cycle to `row`, which says whether it goes on.
///
/// # Errors
/// [`GaitError`] for a robot that is not in space, numbers that cannot be, and a motion that cannot go on.
pub fn roll(roll: &Roll, mut row: impl FnMut(&Ball) -> bool) -> Result<Rolled, GaitError> {
    roll.check()?;
    let (rest, facing) = roll.facing()?;
    let directions = roll.robot.space.as_ref().map(|it| it.directions.vectors());
    let directions = directions.unwrap_or_default();
    let facings = Facing::every(&discs(&directions));
    let planes: Vec<Plane<'_, f64>> = facings.iter().map(Facing::plane).collect();
    let (zone, mut decides) = match &roll.gait {
        Gait::Disc(fires) => {
            let span = (fires.zone, facing.widest());
            let law = fires.program.compile(fires.valve_open, span)?;
            (fires.zone, Decides::Disc(law, true))
        }
        Gait::Stable(stable) => {
            let balance = stable.balance(&roll.robot)?;
            let balancer = Box::new(Balancer::new(balance, facing.plane()));
            let course = Course::new(stable.line);
            (balance.zone, Decides::Stable(balancer, course))
        }
        Gait::Steered(steered) => {
            let lead = steered.lead(&roll.robot)?;
            let pilot = Box::new(Pilot::new(lead, &planes, &steered.path));
            (lead.balance.zone, Decides::Steered(pilot, steered))
        }
    };
    let rig = Rig::new(&roll.robot, &[])?;
    let (q, v) = placed(&rig, roll.start, rig.stand_on(&rest, &facing.ahead(&rest))?);
    let settings = Settings {
        stepping: roll.stepping,
        most_steps: usize::MAX,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    sim.release_legs()?;
    if roll.forces_every > 0 {
        sim.keep_impulses();
    }
    let start = sim.ledger();
    let mut sensed = Sensed::new(roll, &directions, &q);
    let period = roll.robot.sensors.unwrap_or_default().period;
    let mut tracker = Tracker::new(facing.plane(), zone);
    let mut rolled = Rolled::default();
    let mut cycles = 0_u64;
    let (mut before, mut led) = (0, Led::default());
    let mut touched = Vec::new();
    loop {
        let (mut ball, entered) = look(&rig, &sim, &mut tracker);
        ball.passed += before;
        ball.led = led;
        touched.retain(|(point, _)| *point < rig.legs.len());
        ball.touched = std::mem::take(&mut touched);
        if roll.forces_every > 0 && cycles.is_multiple_of(roll.forces_every) {
            let span = roll.forces_every as f64 * period;
            ball.forces = on_feet(&mut sim, ball.extensions.len(), span);
        }
        if let Some(sensed) = &mut sensed {
            let (readings, estimate) = sensed.take(&ball);
            (ball.sensed, ball.estimate) = (Some(readings), Some(estimate));
        }
        ball.fired = decides.fire(&mut ball, entered, &tracker, period);
        if let Some(plane) = decides.leads(&mut ball.led) {
            before += tracker.passed().max(0);
            tracker = Tracker::new(planes[plane], zone);
            ball.axis = planes[plane].axis;
        }
        led = ball.led;
        rolled.note(&ball, roll.start.yaw);
        for Firing { leg, open } in &ball.fired {
            sim.fire(*leg as usize, *open)?;
            if let Some(sensed) = &mut sensed {
                sensed.estimator.fired(*leg);
            }
        }
        if !row(&ball) || ball.time >= roll.seconds - 1e-9 {
            rolled.close(&start, &sim.ledger());
            return Ok(rolled);
        }
        cycles += 1;
        sim.run(cycles as f64 * period, &[])?;
        touched.extend(sim.drain_events().filter_map(touch_down));
    }
}

impl Decides<'_> {
    /// Notes how it is led; the plane, by its number, in which it has set out in this cycle.
    fn leads(&self, led: &mut Led) -> Option<usize> {
        let Decides::Steered(pilot, _) = self else {
            return None;
        };
        let sets_out = led.starts != pilot.starts();
        *led = Led {
            plane: pilot.plane(),
            starts: pilot.starts(),
            reached: pilot.reached(),
        };
        led.plane.filter(|_| sets_out)
    }

    /// The legs that fire in the cycle of `ball`, of `period` (s), whose station in the zone `entered` it now.
    fn fire(
        &mut self,
        ball: &mut Ball,
        entered: bool,
        tracker: &Tracker<'_, f64>,
        period: f64,
    ) -> Vec<Firing<f64>> {
        match self {
            Decides::Disc(compiled, waits) => {
                *waits |= entered;
                let rate = ball.rolling.rate;
                let [angle, open] = compiled.law().at(ball.time, rate);
                let fires = *waits && ball.rolling.lean >= angle && open > 0.0;
                let Some(station) = tracker.station().filter(|_| fires) else {
                    return Vec::new();
                };
                *waits = false;
                let [left, right] = station.legs;
                let legs = if left == right {
                    vec![left]
                } else {
                    vec![left, right]
                };
                legs.into_iter().map(|leg| Firing { leg, open }).collect()
            }
            Decides::Steered(pilot, steered) => {
                let fired = pilot.step(&View::of(&ball.known(), ball.touching));
                ball.aside = steered.off(ball.place, pilot.reached());
                fired.into_iter().flatten().collect()
            }
            Decides::Stable(balancer, course) => {
                let known = ball.known();
                let heading = course.turn(period, &known.place);
                let [aside, aside_rate] = course.aside(&known.place, &known.velocity);
                ball.aside = course.aside(&ball.place, &ball.velocity)[0];
                let sight = Sight {
                    attitude: known.attitude,
                    spin: known.spin,
                    aside,
                    aside_rate,
                    course: heading,
                    touching: ball.touching,
                };
                let (_, fired) = balancer.step(&sight);
                fired.into_iter().flatten().collect()
            }
        }
    }
}

/// What a robot with sensors makes of them.
struct Sensed<'a> {
    hearing: Hearing,
    scales: Scales<f64>,
    estimator: Estimator<'a, f64>,
}

impl<'a> Sensed<'a> {
    /// That of `roll`, if it has to go by its sensors. At rest at coordinates `q` it knows how and where it is.
    fn new(roll: &Roll, directions: &'a [[f64; 3]], q: &[f64]) -> Option<Sensed<'a>> {
        let Knows::Sensors(seed) = roll.knows else {
            return None;
        };
        let start = (Rotation([q[3], q[4], q[5], q[6]]), [q[0], q[1], q[2]]);
        Some(Sensed {
            hearing: Hearing::new(&roll.robot, start.0.0, seed),
            scales: scales(&roll.robot.sensors.unwrap_or_default()),
            estimator: estimator(&roll.robot, directions, start),
        })
    }

    fn take(&mut self, ball: &Ball) -> ([[f64; 3]; 2], Estimate<f64>) {
        let readings = (self.hearing).read(ball.attitude, ball.velocity, ball.touching);
        self.estimator.take(&readings);
        let said = [self.scales.rate(&readings), self.scales.force(&readings)];
        (said, *self.estimator.estimate())
    }
}

/// The point that came onto the ground in `event` and when (s), if one did; the first points are the feet, leg by leg.
fn touch_down(event: Event) -> Option<(usize, f64)> {
    match event.what {
        Happening::TouchDown(point, _) => Some((point, event.time)),
        _ => None,
    }
}

/// Where the robot of `sim` is; and whether another station has entered the zone.
fn look(rig: &Rig, sim: &Sim<'_>, tracker: &mut Tracker<'_, f64>) -> (Ball, bool) {
    let (q, v) = (sim.coordinates(), sim.velocities());
    let spin = [v[3], v[4], v[5]];
    let attitude = [q[3], q[4], q[5], q[6]];
    let (rolling, entered) = tracker.look(&Rotation(attitude), &spin);
    let tree = &rig.mechanism.tree;
    let extension = |leg: usize| q[rig.extension_coordinate(leg)];
    let extension_rate = |leg: usize| v[tree.velocity_of(rig.legs[leg])];
    let gaps = rig.foot_gaps(q);
    let touching = (0..gaps.len()).filter(|leg| gaps[*leg] <= 0.0);
    let ball = Ball {
        time: sim.time(),
        place: [q[0], q[1], q[2]],
        attitude,
        velocity: [v[0], v[1], v[2]],
        spin,
        rolling,
        passed: tracker.passed(),
        aside: 0.0,
        led: Led::default(),
        fired: Vec::new(),
        touched: Vec::new(),
        touching: touching.fold(0, |bits, leg| bits | 1 << leg),
        extensions: (0..rig.legs.len()).map(extension).collect(),
        extension_rates: (0..rig.legs.len()).map(extension_rate).collect(),
        forces: Vec::new(),
        axis: tracker.plane().axis,
        sensed: None,
        estimate: None,
    };
    (ball, entered)
}

/// Force of the ground (N, the world's axes) on the feet of `legs` legs, each with its leg: its mean over the last `span` (s),
/// or what it is now where steps have no fixed length.
fn on_feet(sim: &mut Sim<'_>, legs: usize, span: f64) -> Vec<(usize, [f64; 3])> {
    let forces: Vec<(usize, Vec3)> = match sim.impulses() {
        Some(impulses) => impulses.into_iter().map(|(p, x)| (p, x / span)).collect(),
        None => sim.contacts().iter().map(|c| (c.point, c.force)).collect(),
    };
    let on_feet = forces.into_iter().filter(|(point, _)| *point < legs);
    on_feet.map(|(leg, force)| (leg, force.into())).collect()
}

impl Rolled {
    /// Takes what the legs did and what is not explained from the ledgers of its start and its end.
    fn close(&mut self, start: &Ledger, end: &Ledger) {
        self.residual = end.residual(start);
        self.work = end.drive - start.drive;
        self.approximate = end.approximate - start.approximate;
    }

    /// Takes a cycle into account of a robot that set out along `heading` (rad).
    fn note(&mut self, ball: &Ball, heading: f64) {
        let ([x, y, _], (sine, cosine)) = (ball.place, heading.sin_cos());
        let (travel, side) = (cosine * x + sine * y, cosine * y - sine * x);
        (self.time, self.travel) = (ball.time, travel);
        self.firings += usize::from(!ball.fired.is_empty());
        let Lying {
            roll, roll_rate, ..
        } = ball.rolling;
        let here = Left {
            time: ball.time,
            travel,
            aside: side,
            roll,
            roll_rate,
        };
        if roll.abs() > FALLS {
            self.fell.get_or_insert(here);
        }
        if self.left.is_some() {
            return;
        }
        self.aside = self.aside.max(side.abs());
        if roll_rate.abs() > LEAVES.0 || side.abs() > LEAVES.1 {
            self.left = Some(here);
        }
    }
}

/// The attitude at coordinates `q`.
fn attitude(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(q[3], q[4], q[5], q[6]))
}

/// A robot at rest at coordinates `q`, turned about its middle as `start` says, and put on the ground; it stands on another
/// foot then, or on fewer. Coordinates and velocities.
fn placed(rig: &Rig, start: Start, mut q: Vec<f64>) -> (Vec<f64>, Vec<f64>) {
    let roll = UnitQuaternion::from_axis_angle(&Vec3::x_axis(), start.roll);
    let yaw = UnitQuaternion::from_axis_angle(&Vec3::z_axis(), start.yaw);
    let turned = yaw * roll * attitude(&q);
    q[3..7].copy_from_slice(&[turned.w, turned.i, turned.j, turned.k]);
    let mut v = vec![0.0; rig.mechanism.tree.velocities()];
    if let Some(thrown) = start.thrown {
        q[3..7].copy_from_slice(&thrown.attitude);
        v[3..6].copy_from_slice(&thrown.spin);
    }
    q[2] -= rig.foot_gaps(&q).into_iter().fold(f64::INFINITY, f64::min);
    (q, v)
}
