//! A robot with legs all around, which rolls as a disc on those near one plane through its middle.
//!
//! It knows its attitude and rates exactly. Source: thesis 7.2 and 7.3.

mod disc;

pub use disc::{Facing, Rolling};

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use saltus_robot::Robot;
use saltus_robot::space::{Rest, discs, rests};
use saltus_sim_check::{Rig, Settings, Sim, Stepping, Vec3};

use crate::error::require;
use crate::{GaitError, Program};

/// How a robot rolls from rest.
#[derive(Clone, Debug)]
pub struct Roll {
    /// The robot, in space.
    pub robot: Robot,
    /// Firing angle of the station in the active zone; twins fire as one leg.
    pub program: Program,
    /// Valve opening time t_v (s), where the program says none.
    pub valve_open: f64,
    /// Lean (rad) at which a station enters the active zone. It stays there until the next one does.
    pub zone: f64,
    /// Where it begins.
    pub start: Start,
    /// How long (s).
    pub seconds: f64,
    /// Steps of the simulation.
    pub stepping: Stepping,
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
    pub rolling: Rolling,
    /// Stations that have come into the zone.
    pub passed: i64,
    /// Legs that fire now.
    pub fired: Vec<usize>,
    /// Extension of each leg (m).
    pub extensions: Vec<f64>,
}

/// Where a robot left its plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Left {
    /// When (s).
    pub time: f64,
    /// Travel (m).
    pub travel: f64,
    /// Way to the left (m).
    pub aside: f64,
    /// Rate of roll (rad/s), to the right.
    pub roll_rate: f64,
}

/// What became of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rolled {
    /// How long it ran (s).
    pub time: f64,
    /// Travel (m) along the first heading.
    pub travel: f64,
    /// Greatest way (m) to a side until it left its plane.
    pub aside: f64,
    /// Where it left its plane, if it did.
    pub left: Option<Left>,
    /// Firings, of twins one.
    pub firings: usize,
    /// Energy (J) that no entry of the ledger explains.
    pub residual: f64,
}

/// Rate of roll (rad/s), and way to a side (m), from which on a robot has left its plane.
const LEAVES: (f64, f64) = (6.0, 0.25);

impl Roll {
    /// `robot` from its first rest, with the firing angle of 5.1.3 over time, for so many `seconds`.
    ///
    /// Source: thesis 7.2.2, which runs "from rest" by the α_f of 5.1.
    pub fn new(robot: Robot, seconds: f64) -> Roll {
        Roll {
            robot,
            program: Program::OpenLoop {
                first: 0.5,
                last: 0.0,
                slope: 2.1,
                centre: crate::Centre::Printed(3.0),
            },
            valve_open: 0.05,
            zone: -0.3,
            start: Start::default(),
            seconds,
            stepping: Stepping::USUAL,
        }
    }

    /// The rest and the disc of its start.
    fn facing(&self) -> Result<(Rest, Facing), GaitError> {
        let space = self.robot.space.as_ref();
        let is_in_space = space.is_some();
        let legs = f64::from(self.robot.body.legs);
        let allowed = "of a robot in space: body.shape = \"sphere\"";
        require(is_in_space, "legs", legs, allowed)?;
        let directions = space.map(|space| space.directions.vectors());
        let directions = directions.unwrap_or_default();
        let (rests, discs) = (rests(&directions), discs(&directions));
        let Start { rest, way, .. } = self.start;
        let allowed = format!("below {}", rests.len());
        require(rest < rests.len(), "rest", rest as f64, allowed)?;
        let rest = rests[rest].clone();
        let ways = Facing::all(&rest, &discs);
        let allowed = format!("below {}, the ways open from this rest", ways.len());
        require(way < ways.len(), "way", way as f64, allowed)?;
        Ok((rest, ways[way].clone()))
    }

    fn check(&self) -> Result<(), GaitError> {
        let sound = self.seconds > 0.0 && self.seconds <= 1e5;
        require(sound, "time (s)", self.seconds, "above 0, at most 100000")?;
        let Start { roll, yaw, .. } = self.start;
        for (name, x) in [("roll (rad)", roll), ("yaw (rad)", yaw)] {
            require(x.abs() <= 1.0, name, x, "from -1 to 1")?;
        }
        Ok(())
    }
}

/// Runs `roll`, and gives each cycle to `row`, which says whether it goes on.
///
/// # Errors
/// [`GaitError`] for a robot that is not in space, numbers that cannot be, and a motion that cannot go on.
pub fn roll(roll: &Roll, mut row: impl FnMut(&Ball) -> bool) -> Result<Rolled, GaitError> {
    roll.check()?;
    let (rest, facing) = roll.facing()?;
    let compiled = roll
        .program
        .compile(roll.valve_open, (roll.zone, facing.widest()))?;
    let law = compiled.law();
    let rig = Rig::new(&roll.robot, &[])?;
    let (q, v) = placed(&rig, roll.start, rig.stand_on(&rest, &facing.ahead(&rest))?);
    let settings = Settings {
        stepping: roll.stepping,
        accounts: true,
        most_steps: usize::MAX,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    sim.release_legs()?;
    let start = sim.ledger();
    let period = roll.robot.sensors.unwrap_or_default().period;
    let mut facing = facing.at(roll.zone);
    let mut rolled = Rolled::default();
    let mut waits = true;
    let mut cycles = 0_u64;
    loop {
        let (mut ball, entered) = look(&rig, &sim, &mut facing);
        waits |= entered;
        let [angle, open] = law.at(ball.time, ball.rolling.rate, ball.rolling.rate, 0);
        if waits && ball.rolling.lean >= angle && open > 0.0 {
            waits = false;
            ball.fired = facing.station().to_vec();
        }
        rolled.note(&ball);
        for leg in &ball.fired {
            sim.fire(*leg, open)?;
        }
        if !row(&ball) || ball.time >= roll.seconds - 1e-9 {
            rolled.residual = sim.ledger().residual(&start);
            return Ok(rolled);
        }
        cycles += 1;
        sim.run(cycles as f64 * period, &[])?;
        sim.drain_events();
    }
}

/// Where the robot of `sim` is; and whether another station has entered the zone.
fn look(rig: &Rig, sim: &Sim<'_>, facing: &mut Facing) -> (Ball, bool) {
    let (q, v) = (sim.coordinates(), sim.velocities());
    let spin = Vector3::new(v[3], v[4], v[5]);
    let (rolling, entered) = facing.look(&attitude(q), &spin);
    let extension = |leg: usize| q[rig.extension_coordinate(leg)];
    let ball = Ball {
        time: sim.time(),
        place: [q[0], q[1], q[2]],
        attitude: [q[3], q[4], q[5], q[6]],
        velocity: [v[0], v[1], v[2]],
        spin: spin.into(),
        rolling,
        passed: facing.passed(),
        fired: Vec::new(),
        extensions: (0..rig.legs.len()).map(extension).collect(),
    };
    (ball, entered)
}

impl Rolled {
    /// Takes a cycle into account.
    fn note(&mut self, ball: &Ball) {
        let [travel, side, _] = ball.place;
        (self.time, self.travel) = (ball.time, travel);
        self.firings += usize::from(!ball.fired.is_empty());
        if self.left.is_some() {
            return;
        }
        self.aside = self.aside.max(side.abs());
        let roll_rate = ball.rolling.roll_rate;
        if roll_rate.abs() > LEAVES.0 || side.abs() > LEAVES.1 {
            self.left = Some(Left {
                time: ball.time,
                travel,
                aside: side,
                roll_rate,
            });
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
    let v = vec![0.0; rig.mechanism.tree.velocities()];
    let gaps = (0..rig.legs.len()).map(|leg| rig.foot_motion(leg, &q, &v).0);
    q[2] -= gaps.fold(f64::INFINITY, f64::min);
    (q, v)
}
