//! States of a robot in space, and where Saltus' simulation has the next foot come down from each: the one side of
//! `tests/mujoco/run.py ball`.
//!
//! ```text
//! cd studies && cargo run --release --bin ball_touch_downs -- ROBOT STATES.csv OURS.csv COUNT SEED STEP
//! ```
//!
//! ROBOT is a built-in robot or a file, STEP the simulation's step from the state on (s). Two of five states are of the rolling
//! disc, two of `disc-stable`, each of a run of its own that starts off its plane, and off its course again when the state is
//! taken. One is in free flight, or at rest with legs about to fire. All hang on SEED alone.
//!
//! Rows of STATES.csv: coordinates, velocities (the spin in the world's axes), and when each leg's drive pushes, in seconds from the
//! state on; of OURS.csv: time and foot of the touch-down, velocity of the centre of mass, attitude, and the switches of
//! contact on the way, named as in `tests/mujoco/touchdown.py`. Where nothing is given, ten of these are printed.

use std::fmt::Write as _;
use std::path::Path;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rand_distr::{Distribution, StandardNormal, Uniform};
use rand_pcg::Pcg64;
use saltus_gait::space::{Ball, Gait, Roll, Stable, Start, roll};
use saltus_robot::Robot;
use saltus_robot::space::rests;
use saltus_sim_check::{LegStart, Rig, Settings, Sim, SimError, Stepping};

/// Time (s) between looks.
const LOOK: f64 = 1e-4;
/// Time (s) of a state before what counts as the next touch-down.
const LEAST: f64 = 5e-3;
/// How high (m) a foot has been since the state when it comes down: not every foot that leaves the ground by a hair has left it.
const HIGH: f64 = 0.02;
/// A foot that was less high (m) did not leave the ground.
const LEFT: f64 = 1e-5;
/// A standing foot slips from this speed (m/s) on, and stands below the other.
const SLIPS: [f64; 2] = [5e-3, 1e-3];
/// A leg is at a stop from this distance (m) on, and off it beyond the other.
const STOPS: [f64; 2] = [1e-5, 2e-5];
/// How long (s) after a state its run still says which legs are fired.
const AHEAD: f64 = 0.5;
/// Without a touch-down until here (s) there is none, and another state is drawn.
const LIMIT: f64 = 2.0;

type Error = Box<dyn std::error::Error>;

struct State {
    q: Vec<f64>,
    v: Vec<f64>,
    /// From when until when (s) each leg's drive pushes.
    valves: Vec<Option<[f64; 2]>>,
}

/// Numbers that hang on a seed and a row.
struct Random(Pcg64);

impl Random {
    fn between(&mut self, from: f64, to: f64) -> f64 {
        Uniform::new(from, to).map_or(from, |uniform| uniform.sample(&mut self.0))
    }

    fn below(&mut self, count: usize) -> usize {
        (0..count)
            .rev()
            .find(|k| self.between(0.0, 1.0) < 1.0 / (k + 1) as f64)
            .unwrap_or(0)
    }

    /// Three normal numbers of this deviation.
    fn vector(&mut self, deviation: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| {
            let normal: f64 = StandardNormal.sample(&mut self.0);
            deviation * normal
        })
    }

    fn attitude(&mut self) -> UnitQuaternion<f64> {
        let mut numbers = || StandardNormal.sample(&mut self.0);
        UnitQuaternion::from_quaternion(Quaternion::new(numbers(), numbers(), numbers(), numbers()))
    }
}

fn attitude(q: &[f64]) -> UnitQuaternion<f64> {
    UnitQuaternion::new_unchecked(Quaternion::new(q[3], q[4], q[5], q[6]))
}

fn set_attitude(q: &mut [f64], attitude: &UnitQuaternion<f64>) {
    q[3..7].copy_from_slice(&[attitude.w, attitude.i, attitude.j, attitude.k]);
}

/// How far (m) the lowest foot is above the ground.
fn lowest(rig: &Rig, q: &[f64]) -> f64 {
    rig.foot_gaps(q).into_iter().fold(f64::INFINITY, f64::min)
}

/// A state of a run of its own, moved off its plane and its course.
fn rolling(robot: &Robot, rig: &Rig, stable: bool, random: &mut Random) -> Result<State, Error> {
    let taken = random.between(0.3, 3.0);
    let mut setup = Roll::new(robot.clone(), taken + AHEAD);
    if stable {
        setup.gait = Gait::Stable(Stable::default());
    }
    setup.start = Start {
        rest: random.below(20),
        way: random.below(6),
        roll: random.between(-0.03, 0.03),
        yaw: random.between(-0.5, 0.5),
        thrown: None,
    };
    let legs = robot.body.legs as usize;
    // Of each leg: its latest opening until the state is taken, if that is not over then, or its next one.
    let mut valves: Vec<Option<[f64; 2]>> = vec![None; legs];
    let mut seen: Vec<Ball> = Vec::new();
    roll(&setup, |ball| {
        let is_before = ball.time <= taken;
        for firing in &ball.fired {
            let leg = firing.leg as usize;
            let from = ball.time + robot.own_leg(leg).delay;
            let is_over = valves[leg].is_none_or(|[_, until]| until <= taken);
            if is_before || is_over {
                valves[leg] = Some([from, from + firing.open]);
            }
        }
        if is_before {
            seen.push(ball.clone());
        }
        true
    })?;
    let [.., before, ball] = &seen[..] else {
        return Err("a run of two cycles".into());
    };
    let mut q = [&ball.place[..], &ball.attitude, &ball.extensions].concat();
    // Rates of the legs are those of the last cycle; what is at a stop rests.
    let stroke = robot.leg.stroke;
    let rate = |leg: usize| {
        let (was, is) = (before.extensions[leg], ball.extensions[leg]);
        let rests = is <= 0.0 || is >= stroke;
        if rests {
            0.0
        } else {
            (is - was) / (ball.time - before.time)
        }
    };
    let mut v = [&ball.velocity[..], &ball.spin].concat();
    v.extend((0..legs).map(rate));
    let depth = lowest(rig, &q);
    let turned = UnitQuaternion::new(random.vector(0.02)) * attitude(&q);
    set_attitude(&mut q, &turned);
    // As deep in the rubber as before, or somewhat higher in the air.
    let aloft = if depth > 1e-3 {
        random.between(0.0, 0.02)
    } else {
        0.0
    };
    q[2] += depth + aloft - lowest(rig, &q);
    let (push, spin) = (random.vector(0.05), random.vector(0.3));
    for k in 0..3 {
        v[k] += push[k];
        v[3 + k] += spin[k];
    }
    for valve in &mut valves {
        let left = valve.map(|opening| opening.map(|at| at - ball.time));
        *valve = left.filter(|[_, until]| *until > 0.0);
    }
    Ok(State { q, v, valves })
}

/// In the air with any attitude, spinning, some legs out, and one about to fire.
fn flying(robot: &Robot, rig: &Rig, random: &mut Random) -> State {
    let tree = &rig.mechanism.tree;
    let (mut q, mut v) = (vec![0.0; tree.coordinates()], vec![0.0; tree.velocities()]);
    set_attitude(&mut q, &random.attitude());
    let legs = robot.body.legs as usize;
    for leg in 0..legs {
        let out = random.between(-0.06, 0.06).max(0.0);
        q[rig.extension_coordinate(leg)] = out.min(robot.leg.stroke);
    }
    q[2] = random.between(0.05, 0.4) - lowest(rig, &q);
    v[..3].copy_from_slice((random.vector(1.0) + Vector3::x()).as_slice());
    v[3..6].copy_from_slice(random.vector(4.0).as_slice());
    let mut valves = vec![None; legs];
    let from = random.between(0.0, 0.1);
    valves[random.below(legs)] = Some([from, from + random.between(0.01, 0.05)]);
    State { q, v, valves }
}

/// At rest on its feet, of which one or more are about to fire.
fn standing(robot: &Robot, rig: &Rig, random: &mut Random) -> Result<State, Error> {
    let space = robot.space.as_ref().ok_or("a robot in space")?;
    let directions = space.directions.vectors();
    let rests = rests(&directions);
    let rest = &rests[random.below(rests.len())];
    let mut q = rig.stand_on(rest, &directions[rest.legs[0]])?;
    let turn = UnitQuaternion::new(Vector3::z() * random.between(-3.0, 3.0));
    let turned = turn * attitude(&q);
    set_attitude(&mut q, &turned);
    let mut valves = vec![None; directions.len()];
    let first = random.below(rest.legs.len());
    for k in 0..=random.below(rest.legs.len()) {
        let (from, open) = (random.between(0.0, 0.02), random.between(0.01, 0.05));
        valves[rest.legs[(first + k) % rest.legs.len()]] = Some([from, from + open]);
    }
    let v = vec![0.0; rig.mechanism.tree.velocities()];
    Ok(State { q, v, valves })
}

/// What is seen at a look.
struct Look {
    time: f64,
    gaps: Vec<f64>,
    velocity: Vector3<f64>,
    attitude: UnitQuaternion<f64>,
}

/// Follows a state until the next touch-down, look by look.
struct Watch<'a> {
    rig: &'a Rig,
    stroke: f64,
    before: Option<Look>,
    on_ground: Vec<bool>,
    aloft: Vec<bool>,
    sliding: Vec<bool>,
    stops: Vec<&'static str>,
    left: Vec<f64>,
    switches: String,
}

impl Watch<'_> {
    fn note(&mut self, time: f64, what: &str, leg: usize) {
        let separator = if self.switches.is_empty() { "" } else { ";" };
        let _ = write!(self.switches, "{separator}{time:.6}:{what}{leg}");
    }

    /// The foot that has come down since the last look, and for how much of the time between.
    fn look(&mut self, sim: &Sim<'_>, now: Look) -> Option<(usize, f64, Look, Look)> {
        let found = self.feet(&now);
        self.legs(sim, now.time);
        if let (Some((leg, part)), Some(before)) = (found, self.before.take()) {
            return Some((leg, part, before, now));
        }
        self.slips(sim, now.time);
        self.before = Some(now);
        None
    }

    fn feet(&mut self, now: &Look) -> Option<(usize, f64)> {
        let Some(before) = self.before.take() else {
            self.on_ground = now.gaps.iter().map(|gap| *gap <= 1e-6).collect();
            return None;
        };
        let mut found = None;
        for (leg, (&was, &is)) in before.gaps.iter().zip(&now.gaps).enumerate() {
            let part = was / (was - is);
            let at = before.time + part * (now.time - before.time);
            if was <= 0.0 && is > 0.0 {
                self.left[leg] = at;
            }
            if self.on_ground[leg] && is > LEFT {
                self.on_ground[leg] = false;
                self.note(self.left[leg], "lift", leg);
            } else if !self.on_ground[leg] && is <= 0.0 {
                if self.aloft[leg] {
                    found = found.or(Some((leg, part)));
                    continue;
                }
                self.on_ground[leg] = true;
                self.note(at, "land", leg);
            }
            let is_high = now.time >= LEAST && is > HIGH;
            self.aloft[leg] = !self.on_ground[leg] && (self.aloft[leg] || is_high);
        }
        self.before = Some(before);
        found
    }

    /// Which legs are at their stops.
    fn legs(&mut self, sim: &Sim<'_>, time: f64) {
        let q = sim.coordinates();
        let first = self.stops.is_empty();
        for leg in 0..self.rig.legs.len() {
            let d = q[self.rig.extension_coordinate(leg)];
            let was = self.stops.get(leg).copied().unwrap_or("off");
            let near = if was == "off" { STOPS[0] } else { STOPS[1] };
            let is = if d < near {
                "in"
            } else if d > self.stroke - near {
                "out"
            } else {
                "off"
            };
            if first {
                self.stops.push(is);
            } else if is != was {
                self.stops[leg] = is;
                self.note(time, is, leg);
            }
        }
    }

    fn slips(&mut self, sim: &Sim<'_>, time: f64) {
        let first = self.sliding.is_empty();
        for leg in 0..self.rig.legs.len() {
            let was = !first && self.sliding[leg];
            let (_, [_, along, across]) =
                self.rig
                    .foot_motion(leg, sim.coordinates(), sim.velocities());
            let least = if was { SLIPS[1] } else { SLIPS[0] };
            let slides = self.on_ground[leg] && along.hypot(across) > least;
            if first {
                self.sliding.push(slides);
                continue;
            }
            self.sliding[leg] = slides;
            if self.on_ground[leg] && slides != was {
                self.note(time, if slides { "slip" } else { "stand" }, leg);
            }
        }
    }
}

/// The answer to one state; none without a touch-down.
fn touch_down(
    rig: &Rig,
    state: &State,
    stroke: f64,
    step: f64,
) -> Result<Option<String>, SimError> {
    let start = |valve: &Option<[f64; 2]>| LegStart {
        pressure: 101_325.0,
        valve: *valve,
    };
    let legs: Vec<LegStart> = state.valves.iter().map(start).collect();
    let settings = Settings {
        stepping: Stepping::Fixed(step),
        most_steps: usize::MAX,
        ..Settings::default()
    };
    let mut sim = Sim::in_motion(&rig.mechanism, &state.q, &state.v, &legs, settings)?;
    let tree = &rig.mechanism.tree;
    let mass: f64 = tree.bodies().iter().map(|body| body.mass).sum();
    let mut watch = Watch {
        rig,
        stroke,
        before: None,
        on_ground: Vec::new(),
        aloft: vec![false; legs.len()],
        sliding: Vec::new(),
        stops: Vec::new(),
        left: vec![0.0; legs.len()],
        switches: String::new(),
    };
    for look in 0.. {
        let time = LOOK * f64::from(look);
        if time > LIMIT {
            break;
        }
        sim.run(time, &[])?;
        sim.drain_events();
        let now = Look {
            time,
            gaps: rig.foot_gaps(sim.coordinates()),
            velocity: sim.pose().momentum(tree).0 / mass,
            attitude: attitude(sim.coordinates()),
        };
        if let Some((leg, part, before, now)) = watch.look(&sim, now) {
            let at = before.time + part * (now.time - before.time);
            let v = before.velocity + (now.velocity - before.velocity) * part;
            let a = before.attitude.slerp(&now.attitude, part);
            return Ok(Some(format!(
                "{at:e},{leg},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{}",
                v.x, v.y, v.z, a.w, a.i, a.j, a.k, watch.switches
            )));
        }
    }
    Ok(None)
}

fn header(legs: usize) -> String {
    let mut text = String::from("x,y,z,qw,qx,qy,qz");
    let mut each = |name: &str| {
        for k in 0..legs {
            let _ = write!(text, ",{}", name.replace('#', &k.to_string()));
        }
    };
    each("d#");
    let mut rates = String::from(",vx,vy,vz,wx,wy,wz");
    for k in 0..legs {
        let _ = write!(rates, ",d{k}_rate");
    }
    for k in 0..legs {
        let _ = write!(rates, ",from{k},until{k}");
    }
    format!("kind,{text}{rates}\n")
}

fn row(kind: &str, state: &State) -> String {
    let mut text = kind.to_owned();
    for x in state.q.iter().chain(&state.v) {
        let _ = write!(text, ",{x:e}");
    }
    for valve in &state.valves {
        let _ = match valve {
            Some([from, until]) => write!(text, ",{from:e},{until:e}"),
            None => write!(text, ",,"),
        };
    }
    text
}

/// The state of row `k` at attempt `attempt`, and of what kind it is.
fn state(
    robot: &Robot,
    rig: &Rig,
    seed: u64,
    (k, attempt): (usize, usize),
) -> Result<(&'static str, State), Error> {
    let stream = 2 * (k as u128 + 1_000_000 * attempt as u128) + 1;
    let mut random = Random(Pcg64::new(u128::from(seed), stream));
    Ok(match k % 10 {
        4 => ("flight", flying(robot, rig, &mut random)),
        9 => ("standing", standing(robot, rig, &mut random)?),
        n if n % 5 < 2 => ("disc", rolling(robot, rig, false, &mut random)?),
        _ => ("disc-stable", rolling(robot, rig, true, &mut random)?),
    })
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usual = ["rats-twelve", "", "", "10", "1", "2.5e-5"].map(String::from);
    let given = match arguments.len() {
        0 => &usual[..],
        6 => &arguments[..],
        _ => return Err("give ROBOT, STATES.csv, OURS.csv, COUNT, SEED and STEP".into()),
    };
    let (count, seed, step): (usize, u64, f64) =
        (given[3].parse()?, given[4].parse()?, given[5].parse()?);
    let robot = match Robot::builtin(&given[0]) {
        Some(robot) => robot,
        None => Robot::load(Path::new(&given[0]))?,
    };
    let rig = Rig::new(&robot, &[])?;
    let mut states = header(rig.legs.len());
    let mut ours = String::from("touch_down_s,leg,vx,vy,vz,qw,qx,qy,qz,switches\n");
    for k in 0..count {
        for attempt in 0.. {
            let (kind, state) = state(&robot, &rig, seed, (k, attempt))?;
            let answer = touch_down(&rig, &state, robot.leg.stroke, step)?;
            if let Some(answer) = answer {
                let _ = writeln!(states, "{}", row(kind, &state));
                let _ = writeln!(ours, "{answer}");
                break;
            }
        }
    }
    if given[1].is_empty() {
        print!("{ours}");
        return Ok(());
    }
    std::fs::write(&given[1], states)?;
    std::fs::write(&given[2], ours)?;
    Ok(())
}
