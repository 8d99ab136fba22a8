//! A jump in the multi-body simulation.

use nalgebra::Vector3;
use saltus_controller::ball::{Estimator, Rotation};
use saltus_gait::GaitError;
use saltus_gait::space::{Flashed, Hearing, Knows, Stable};
use saltus_robot::Robot;
use saltus_sim_check::{Rig, Settings, Sim, Stepping};

use super::block;
use super::guide::{Guide, Known};
use super::standing::{Standing, quaternion};
use super::{Command, Lift, Touch};
use crate::require;

/// What became of a jump.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flown {
    /// How it left the ground, if it did.
    pub lift: Option<Lift>,
    /// How it came down.
    pub touch: Option<Touch>,
    /// Least distance (m) between the box and the hull of the feet before that; 0 or less: it ran against it. Infinite without
    /// a box.
    pub clearance: f64,
    /// Where its legs meet in the end (m).
    pub rests: [f64; 3],
}

impl Flown {
    /// Takes in how far (m) it is from the box.
    fn pass(&mut self, clearance: f64) {
        self.clearance = self.clearance.min(clearance);
    }

    /// That of a robot that has not moved.
    fn none() -> Flown {
        Flown {
            lift: None,
            touch: None,
            clearance: f64::INFINITY,
            rests: [0.0; 3],
        }
    }
}

/// A cycle of a jump.
#[derive(Clone, Debug, PartialEq)]
pub struct Cycle {
    /// Time (s).
    pub time: f64,
    /// Where the legs meet (m).
    pub place: [f64; 3],
    /// Attitude: a unit quaternion w, x, y, z.
    pub attitude: [f64; 4],
    /// Velocity (m/s).
    pub velocity: [f64; 3],
    /// Spin (rad/s), the world's axes.
    pub spin: [f64; 3],
    /// Feet on the ground: bit k is leg k's.
    pub touching: u64,
}

/// Longest time (s) from the last command to the landing.
const LONGEST: f64 = 3.0;

/// Firings, and what closes their valves.
#[derive(Clone, Debug, PartialEq)]
pub struct Jump {
    /// The firings, with the longest opening times.
    pub commands: Vec<Command>,
    /// What closes valves before that; none: nothing.
    pub guide: Option<Guide>,
    /// What it goes by.
    pub knows: Knows,
}

impl Jump {
    /// The same jump of a robot whose sensors' noise is drawn from `seed`.
    pub fn by_sensors(&self, seed: u64) -> Jump {
        Jump {
            knows: Knows::Sensors(seed),
            ..self.clone()
        }
    }
}

/// `robot` jumps from `standing` as `jump` says, and is followed until it has landed and `after` (s) more.
///
/// # Errors
/// [`GaitError`] for commands that cannot be, and a motion that cannot go on.
pub fn fly(
    robot: &Robot,
    standing: &Standing,
    jump: &Jump,
    after: f64,
) -> Result<Flown, GaitError> {
    let commands = &jump.commands;
    check(commands)?;
    let solid = standing.obstacle.as_ref().map(block::surface);
    let rig = Rig::new(robot, solid.as_slice())?;
    let mut q = vec![0.0; rig.mechanism.tree.coordinates()];
    q[..3].copy_from_slice(&standing.place);
    q[3..7].copy_from_slice(&standing.attitude);
    let v = vec![0.0; rig.mechanism.tree.velocities()];
    let settings = Settings {
        stepping: Stepping::USUAL,
        most_steps: usize::MAX,
        ..Settings::default()
    };
    let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
    sim.release_legs()?;
    let mut orders: Vec<Command> = commands.clone();
    orders.sort_by(|a, b| b.at.total_cmp(&a.at));
    let last = |it: &Command| it.at + it.open + robot.own_leg(it.leg).delay;
    let pushed = commands.iter().map(last).fold(0.0, f64::max);
    let period = robot.sensors.unwrap_or_default().period;
    let flashed = Flashed::new(robot, &Stable::default())?;
    let mut valves = Valves::new(robot, standing, jump, &flashed);
    let (mut flown, mut cycles) = (Flown::none(), 0_u64);
    let mut apex = 0.0_f64;
    loop {
        let next = orders.last().map_or(f64::INFINITY, |order| order.at);
        let tick = cycles as f64 * period;
        if next <= tick {
            sim.run(next, &[])?;
            while let Some(order) = orders.pop_if(|order| order.at <= sim.time()) {
                sim.fire(order.leg, order.open)?;
                valves.fired(order.leg);
            }
            continue;
        }
        sim.run(tick, &[])?;
        sim.drain_events();
        cycles += 1;
        let now = seen(&rig, &sim);
        for leg in valves.close(&now) {
            sim.switch(leg, false)?;
        }
        flown.rests = now.place;
        let is_up = now.touching == 0 && orders.is_empty();
        match (flown.lift, flown.touch) {
            (None, _) if is_up && now.velocity[2] > 0.0 => {
                flown.lift = Some(Lift {
                    time: now.time,
                    place: now.place,
                    velocity: now.velocity,
                    spin: now.spin,
                });
            }
            (Some(_), None) if now.touching != 0 && now.velocity[2] < 0.0 => {
                flown.touch = Some(Touch {
                    time: now.time,
                    place: now.place,
                    velocity: now.velocity,
                    spin: now.spin,
                    apex,
                });
            }
            (Some(_), None) if now.touching != 0 => flown.lift = None,
            _ => {}
        }
        if let (Some(obstacle), None) = (&standing.obstacle, flown.touch) {
            flown.pass(block::clearance(obstacle, &rig, &sim));
        }
        apex = apex.max(now.place[2]);
        let end = flown
            .touch
            .map_or(pushed + LONGEST, |touch| touch.time + after);
        let stays = flown.lift.is_none() && now.time > pushed + 0.2;
        if now.time >= end || stays {
            return Ok(flown);
        }
    }
}

fn check(commands: &[Command]) -> Result<(), GaitError> {
    let allowed = "from 0 to 1 s";
    for command in commands {
        let sound = |x: f64| (0.0..=1.0).contains(&x);
        require(
            sound(command.open),
            "valve opening time (s)",
            command.open,
            allowed,
        )?;
        require(
            sound(command.at),
            "time of a command (s)",
            command.at,
            allowed,
        )?;
    }
    Ok(())
}

/// What closes valves, by what is known of the motion.
struct Valves<'a> {
    guide: Option<Guide>,
    /// What fires: leg and time (s), and whether it is still to be closed.
    legs: Vec<(usize, f64)>,
    open: Vec<bool>,
    sensed: Option<(Hearing, Estimator<'a, f64>)>,
}

impl<'a> Valves<'a> {
    fn new(
        robot: &Robot,
        standing: &Standing,
        jump: &Jump,
        flashed: &'a Flashed<f64>,
    ) -> Valves<'a> {
        let start = (Rotation(standing.attitude), standing.place);
        let sensed = match jump.knows {
            Knows::Truth => None,
            Knows::Sensors(seed) => Some((
                Hearing::new(robot, standing.attitude, seed),
                flashed.estimator(start),
            )),
        };
        Valves {
            guide: jump.guide.clone(),
            legs: jump.commands.iter().map(|it| (it.leg, it.at)).collect(),
            open: vec![true; jump.commands.len()],
            sensed,
        }
    }

    fn fired(&mut self, leg: usize) {
        if let (Some((_, estimator)), Ok(leg)) = (&mut self.sensed, u32::try_from(leg)) {
            estimator.fired(leg);
        }
    }

    /// The legs whose valves close in the cycle of `now`.
    fn close(&mut self, now: &Cycle) -> Vec<usize> {
        let mut known = Known {
            attitude: quaternion(now.attitude),
            place: Vector3::from(now.place),
            velocity: Vector3::from(now.velocity),
        };
        if let Some((senses, estimator)) = &mut self.sensed {
            estimator.take(&senses.read(now.attitude, now.velocity, now.touching));
            let estimate = estimator.estimate();
            known = Known {
                attitude: quaternion(estimate.attitude.0),
                place: Vector3::from(estimate.place),
                velocity: Vector3::from(estimate.velocity),
            };
        }
        let Some(guide) = &mut self.guide else {
            return Vec::new();
        };
        let closes = guide.closes(now.time, &known, &self.legs);
        let mut closed = Vec::new();
        for ((is_open, closes), (leg, _)) in self.open.iter_mut().zip(closes).zip(&self.legs) {
            if *is_open && closes {
                *is_open = false;
                closed.push(*leg);
            }
        }
        closed
    }
}

/// The cycle that `sim` has come to.
pub(super) fn seen(rig: &Rig, sim: &Sim<'_>) -> Cycle {
    let (q, v) = (sim.coordinates(), sim.velocities());
    let gaps = rig.foot_gaps(q);
    let touching = (0..gaps.len()).filter(|leg| gaps[*leg] <= 0.0);
    Cycle {
        time: sim.time(),
        place: [q[0], q[1], q[2]],
        attitude: [q[3], q[4], q[5], q[6]],
        velocity: [v[0], v[1], v[2]],
        spin: [v[3], v[4], v[5]],
        touching: touching.fold(0, |bits, leg| bits | 1 << leg),
    }
}
