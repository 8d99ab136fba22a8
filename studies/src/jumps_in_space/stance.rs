//! A model of a jump in space: a rigid body, legs without mass that push on rubber, and flight.
//!
//! It shares no equations with the multi-body simulation. A leg that pushes is a force along it between the body and a foot
//! on the ground; the mass of the leg is counted once, where it starts to move with the body. Legs that are not fired stand
//! as rigid rods on rubber feet.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};
use saltus_gait::{GaitError, Obstacle};
use saltus_robot::{Drive, Robot, Term};

use super::block;
use super::guide::{Guide, Known};
use super::standing::Standing;
use super::{Command, Lift, Touch};
use crate::{refused, require};

type Vec3 = Vector3<f64>;

/// Step (s) on the ground, and in flight.
const STEP: f64 = 5e-4;
const FLIGHT_STEP: f64 = 1e-2;
/// Speed (m/s) of a foot from which on nearly all of the friction acts.
const CREEP: f64 = 0.05;
/// Rubber of feet that the robot's file calls rigid (N/m, N s/m).
const STIFF: (f64, f64) = (2e5, 1700.0);
/// Least part of an axial force that the ground's normal takes, where friction would wedge the leg.
const WEDGE: f64 = 0.1;
/// How long (s) a stance may last after the last command has ended, and a flight.
const LINGERS: f64 = 0.1;
const LONGEST_FLIGHT: f64 = 3.0;

/// A robot as the model sees it.
#[derive(Clone, Debug)]
pub struct Stance {
    mass: f64,
    leg_mass: f64,
    /// About the centre of mass, body axes (kg m²), and its inverse.
    inertia: Matrix3<f64>,
    inverse: Matrix3<f64>,
    /// From where the legs meet to the centre of mass (m), body axes.
    center: Vec3,
    legs: Vec<Leg>,
    /// From where the legs meet to the middle of a retracted foot (m), and that foot's radius (m).
    reach: f64,
    foot: f64,
    gravity: f64,
    friction: f64,
    rubber: (f64, f64),
}

/// A leg.
#[derive(Clone, Copy, Debug)]
struct Leg {
    direction: Vec3,
    stroke: f64,
    delay: f64,
    force: f64,
    dry: f64,
    viscous: f64,
    spring: (f64, f64),
}

/// What the ground does to a foot, and how fast its rubber gives way (m/s).
#[derive(Clone, Copy, Debug, Default)]
struct Push {
    force: Vec3,
    at: Vec3,
    sinks: f64,
}

/// A command in the course of a stance.
#[derive(Clone, Copy, Debug)]
struct Active {
    leg: usize,
    at: f64,
    begins: f64,
    ends: f64,
    /// Whether it pushes now; and whether it has been.
    pushes: bool,
    is_over: bool,
    /// How far the ground gives way under the foot (m).
    sunk: f64,
}

/// Place of the centre of mass, attitude, and their rates in the world's axes.
#[derive(Clone, Copy, Debug)]
struct State {
    place: Vec3,
    attitude: UnitQuaternion<f64>,
    velocity: Vec3,
    spin: Vec3,
}

/// Rates of a state.
#[derive(Clone, Copy, Debug, Default)]
struct Rates {
    velocity: Vec3,
    spin: Vec3,
    pull: Vec3,
    turn: Vec3,
}

impl Stance {
    /// The model of `robot`.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, or whose legs' force is not constant.
    pub fn new(robot: &Robot) -> Result<Stance, GaitError> {
        let Some(space) = &robot.space else {
            let allowed = "of a robot in space: body.shape = \"sphere\"";
            return Err(refused("legs", f64::from(robot.body.legs), allowed));
        };
        let mass = robot.body.mass;
        let leg_mass = robot.leg.body.mass;
        let core = mass - leg_mass * f64::from(robot.body.legs);
        let center = Vec3::from(space.center) * (core / mass);
        let [xx, yy, zz, xy, xz, yz] = space.inertia;
        let about = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let round = Matrix3::identity() * center.norm_squared() - center * center.transpose();
        let inertia = about - round * mass;
        let inverse = inertia.try_inverse();
        let inverse = inverse.ok_or_else(|| refused("inertia", xx, "that of a body"))?;
        let directions = space.directions.vectors();
        has_only_known_terms(robot)?;
        let legs = directions.iter().enumerate();
        let legs = legs
            .map(|(k, direction)| Leg::new(robot, k, direction))
            .collect::<Result<_, _>>()?;
        let ground = &robot.ground;
        let allowed = "0, level ground, for a jump in space";
        require(
            ground.slope == 0.0,
            "ground.slope (rad)",
            ground.slope,
            allowed,
        )?;
        Ok(Stance {
            mass,
            leg_mass,
            inertia,
            inverse,
            center,
            legs,
            reach: robot.body.radius - robot.foot.radius,
            foot: robot.foot.radius,
            gravity: robot.environment.gravity,
            friction: ground.kinetic_friction.min(1e3),
            // Rubber that gives way within less than a step is as good as rigid.
            rubber: match ground.stiffness {
                Some(stiffness) if stiffness * STEP < 2.0 * ground.damping.max(1.0) => {
                    (stiffness, ground.damping.max(1.0))
                }
                _ => STIFF,
            },
        })
    }

    /// The robot's legs fire by `commands`, from rest as it is `standing`, and their valves close as `guide` says, or as
    /// commanded if that is sooner; none: it does not come off the ground.
    pub fn jump(
        &self,
        standing: &Standing,
        commands: &[Command],
        mut guide: Option<Guide>,
    ) -> Option<(Lift, Touch)> {
        let attitude = standing.turned();
        let mut state = State {
            place: Vec3::from(standing.place) + attitude * self.center,
            attitude,
            velocity: Vec3::zeros(),
            spin: Vec3::zeros(),
        };
        let (mut now, mut active) = (0.0, self.active(commands));
        let last = active.iter().map(|it| it.ends).fold(0.0, f64::max);
        let mut cycles = 0_u32;
        while active.iter().any(|it| !it.is_over) || self.lowest(&state) <= 0.0 {
            if now > last + LINGERS || !state.place.iter().all(|x| x.is_finite()) {
                return None;
            }
            let mut tick = f64::INFINITY;
            if let Some(guide) = &mut guide {
                if now >= f64::from(cycles) * guide.period() - 1e-12 {
                    self.guided(&state, now, guide, &mut active);
                    cycles += 1;
                }
                tick = f64::from(cycles) * guide.period();
            }
            self.switch(&state, now, &mut active);
            let edges = active.iter().flat_map(|it| [it.begins, it.ends]);
            let edges = edges.chain([tick]);
            let next = edges.filter(|edge| *edge > now + 1e-12);
            let span = next.fold(now + STEP, f64::min) - now;
            now += self.advance(&mut state, span, &mut active);
        }
        let lift = Lift {
            time: now,
            place: self.middle(&state).into(),
            velocity: state.velocity.into(),
            spin: state.spin.into(),
        };
        let touch = self.fly(state, now, standing.obstacle.as_ref())?;
        Some((lift, touch))
    }

    /// Closes valves at the time `now` (s).
    fn guided(&self, state: &State, now: f64, guide: &mut Guide, active: &mut [Active]) {
        let known = Known {
            attitude: state.attitude,
            place: self.middle(state),
            velocity: state.velocity - state.spin.cross(&(state.attitude * self.center)),
        };
        let legs: Vec<(usize, f64)> = active.iter().map(|it| (it.leg, it.at)).collect();
        let closed = guide.closes(now, &known, &legs);
        for (it, _) in active.iter_mut().zip(closed).filter(|(_, closes)| *closes) {
            it.ends = it.ends.min(now + self.legs[it.leg].delay);
        }
    }

    fn active(&self, commands: &[Command]) -> Vec<Active> {
        let one = |command: &Command| {
            let begins = command.at + self.legs[command.leg].delay;
            Active {
                leg: command.leg,
                at: command.at,
                begins,
                ends: begins + command.open,
                pushes: false,
                is_over: command.open <= 0.0,
                sunk: 0.0,
            }
        };
        commands.iter().map(one).collect()
    }

    /// Where the legs meet (m).
    fn middle(&self, state: &State) -> Vec3 {
        state.place - state.attitude * self.center
    }

    /// Gap (m) below the lowest retracted foot.
    fn lowest(&self, state: &State) -> f64 {
        let middle = self.middle(state).z;
        let height = |leg: &Leg| middle + (state.attitude * leg.direction).z * self.reach;
        let least = self.legs.iter().map(height).fold(f64::INFINITY, f64::min);
        least - self.foot
    }

    /// Gap (m) between the feet, retracted, and the ground, or the hull of the feet and `obstacle`.
    fn gap(&self, state: &State, obstacle: Option<&Obstacle>) -> f64 {
        let Some(obstacle) = obstacle else {
            return self.lowest(state);
        };
        let middle = self.middle(state);
        let foot = |leg: &Leg| {
            let foot = middle + state.attitude * leg.direction * self.reach;
            [foot.x, foot.z]
        };
        let feet: Vec<_> = self.legs.iter().map(foot).collect();
        let near = block::gap(obstacle, &feet) - self.foot;
        self.lowest(state).min(near)
    }

    /// Extension (m) with which the foot of leg `leg` reaches the ground, which gives way by `sunk` (m); infinite for a leg
    /// that does not point down.
    fn extension(&self, state: &State, leg: usize, sunk: f64) -> f64 {
        let down = -(state.attitude * self.legs[leg].direction).z;
        if down < WEDGE {
            return f64::INFINITY;
        }
        (self.middle(state).z - self.foot + sunk) / down - self.reach
    }

    /// Begins and ends pushes.
    fn switch(&self, state: &State, now: f64, active: &mut [Active]) {
        for it in active.iter_mut().filter(|it| !it.is_over) {
            let is_open = now >= it.begins - 1e-12 && now < it.ends - 1e-12;
            let is_past = now >= it.ends - 1e-12;
            if is_open && !it.pushes {
                // A leg that has stood has pressed its foot into the ground already.
                let gap = self.extension(state, it.leg, 0.0);
                it.sunk = (-gap).max(0.0);
                it.pushes = gap < self.legs[it.leg].stroke;
                it.is_over = !it.pushes;
            } else if is_past {
                it.is_over = true;
            }
        }
    }

    /// Goes on by up to `span` (s), less if a leg reaches its stop before; how long it was.
    fn advance(&self, state: &mut State, span: f64, active: &mut [Active]) -> f64 {
        let were: Vec<bool> = active.iter().map(|it| it.is_over).collect();
        let before = (*state, active.iter().map(|it| it.sunk).collect::<Vec<_>>());
        self.step(state, span, active);
        // How much of the step is left when a leg comes to its stop.
        let mut part = 1.0_f64;
        for (it, sunk) in active.iter().zip(&before.1) {
            if it.pushes && !it.is_over {
                let stroke = self.legs[it.leg].stroke;
                let (from, to) = (
                    self.extension(&before.0, it.leg, *sunk),
                    self.extension(state, it.leg, it.sunk),
                );
                if to > stroke {
                    part = part.min(((stroke - from) / (to - from)).clamp(1e-3, 1.0));
                }
            }
        }
        if part < 1.0 {
            *state = before.0;
            for (it, sunk) in active.iter_mut().zip(&before.1) {
                it.sunk = *sunk;
            }
            self.step(state, part * span, active);
        }
        for it in active.iter_mut().filter(|it| it.pushes && !it.is_over) {
            let stroke = self.legs[it.leg].stroke;
            it.is_over = self.extension(state, it.leg, it.sunk) > stroke - 1e-6;
        }
        // A leg whose push has ended takes its share of the momentum.
        for (it, was) in active.iter().zip(were) {
            if it.is_over && !was && it.pushes {
                self.pick_up(state, it.leg);
            }
        }
        part * span
    }

    fn pick_up(&self, state: &mut State, leg: usize) {
        let up = -(state.attitude * self.legs[leg].direction);
        let speed = up.dot(&state.velocity).max(0.0);
        state.velocity -= up * (speed * self.leg_mass / self.mass);
    }

    /// A step of Runge's and Kutta's method of fourth order.
    fn step(&self, state: &mut State, span: f64, active: &mut [Active]) {
        let mut sinks = [[0.0; MOST]; 4];
        let (first, mut moved) = (*state, active.to_vec());
        let mut all = [Rates::default(); 4];
        for (k, part) in [0.0, 0.5, 0.5, 1.0].into_iter().enumerate() {
            let mut there = first;
            if k > 0 {
                there = first.after(&all[k - 1], part * span);
                for (j, it) in moved.iter_mut().enumerate() {
                    it.sunk = active[j].sunk + part * span * sinks[k - 1][j];
                }
            }
            all[k] = self.rates(&there, &moved, &mut sinks[k]);
        }
        let mean = |of: &dyn Fn(&Rates) -> Vec3| {
            (of(&all[0]) + 2.0 * of(&all[1]) + 2.0 * of(&all[2]) + of(&all[3])) / 6.0
        };
        let rates = Rates {
            velocity: mean(&|r| r.velocity),
            spin: mean(&|r| r.spin),
            pull: mean(&|r| r.pull),
            turn: mean(&|r| r.turn),
        };
        *state = first.after(&rates, span);
        for (j, it) in active.iter_mut().enumerate() {
            let sink = (sinks[0][j] + 2.0 * sinks[1][j] + 2.0 * sinks[2][j] + sinks[3][j]) / 6.0;
            it.sunk = (it.sunk + span * sink).max(0.0);
        }
    }

    fn rates(&self, state: &State, active: &[Active], sinks: &mut [f64; MOST]) -> Rates {
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        let mut add = |push: &Push| {
            force += push.force;
            torque += (push.at - state.place).cross(&push.force);
        };
        let mut free = self.mass;
        let mut pushing = 0_u64;
        for (it, sink) in active.iter().zip(sinks.iter_mut()) {
            *sink = 0.0;
            if it.pushes && !it.is_over {
                let push = self.pushed(state, it);
                *sink = push.sinks;
                pushing |= 1 << it.leg;
                free -= self.leg_mass;
                add(&push);
            }
        }
        for leg in 0..self.legs.len() {
            if pushing >> leg & 1 == 0
                && let Some(push) = self.stood(state, leg)
            {
                add(&push);
            }
        }
        let [inertia, inverse] = self.inertias(state);
        Rates {
            velocity: state.velocity,
            spin: state.spin,
            pull: force / free - Vec3::z() * self.gravity,
            turn: inverse * (torque - state.spin.cross(&(inertia * state.spin))),
        }
    }

    /// What the ground does to the foot of a leg that pushes: its part along the leg is the leg's force.
    fn pushed(&self, state: &State, it: &Active) -> Push {
        let leg = &self.legs[it.leg];
        let along = state.attitude * leg.direction;
        let extension = self.extension(state, it.leg, it.sunk);
        let foot = self.middle(state) + along * (self.reach + extension);
        let body = Stance::velocity_at(state, &foot);
        let speed = -body.z / along.z;
        let at = foot - Vec3::z() * self.foot;
        let slip = body + along * speed - Vec3::z().cross(&state.spin) * -self.foot;
        let axial = leg.force
            - leg.dry
            - leg.viscous * speed
            - leg.spring.0 * extension.max(0.0)
            - leg.spring.1;
        let way = direction(&slip);
        let normal = axial.max(0.0) / (-along.z + self.friction * way.dot(&along)).max(WEDGE);
        let (stiffness, damping) = self.rubber;
        Push {
            force: (Vec3::z() - way * self.friction) * normal,
            at,
            sinks: (normal - stiffness * it.sunk) / damping,
        }
    }

    /// What the ground does to the foot of a leg that stands, retracted.
    fn stood(&self, state: &State, leg: usize) -> Option<Push> {
        let along = state.attitude * self.legs[leg].direction;
        let foot = self.middle(state) + along * self.reach;
        let depth = self.foot - foot.z;
        if depth <= 0.0 {
            return None;
        }
        let at = foot - Vec3::z() * self.foot;
        let speed = Stance::velocity_at(state, &at);
        let (stiffness, damping) = self.rubber;
        let normal = (stiffness * depth - damping * speed.z).max(0.0);
        Some(Push {
            force: (Vec3::z() - direction(&speed) * self.friction) * normal,
            at,
            sinks: 0.0,
        })
    }

    fn velocity_at(state: &State, place: &Vec3) -> Vec3 {
        state.velocity + state.spin.cross(&(place - state.place))
    }

    /// Flies from `state` at the time `now` (s) until a foot touches the ground or `obstacle`.
    fn fly(&self, mut state: State, mut now: f64, obstacle: Option<&Obstacle>) -> Option<Touch> {
        let rise = state.velocity.z.max(0.0).powi(2) / (2.0 * self.gravity);
        let apex = self.middle(&state).z + rise;
        let end = now + LONGEST_FLIGHT;
        let mut step = FLIGHT_STEP;
        while now < end {
            let next = self.coast(&state, step);
            if self.gap(&next, obstacle) > 0.0 {
                state = next;
                now += step;
            } else if step > 1e-6 {
                step *= 0.5;
            } else {
                return Some(Touch {
                    time: now,
                    place: self.middle(&state).into(),
                    velocity: state.velocity.into(),
                    spin: state.spin.into(),
                    apex,
                });
            }
        }
        None
    }

    /// `state` a time `span` (s) later in flight: a parabola, and Euler's equations by the rule of the midpoint.
    fn coast(&self, state: &State, span: f64) -> State {
        let turn = |state: &State| {
            let [inertia, inverse] = self.inertias(state);
            -inverse * state.spin.cross(&(inertia * state.spin))
        };
        let half = 0.5 * span;
        let middle = State {
            attitude: UnitQuaternion::from_scaled_axis(state.spin * half) * state.attitude,
            spin: state.spin + turn(state) * half,
            ..*state
        };
        let fall = Vec3::z() * self.gravity;
        State {
            place: state.place + state.velocity * span - fall * (half * span),
            attitude: UnitQuaternion::from_scaled_axis(middle.spin * span) * state.attitude,
            velocity: state.velocity - fall * span,
            spin: state.spin + turn(&middle) * span,
        }
    }

    /// The inertia (kg m²) in the world's axes, and its inverse.
    fn inertias(&self, state: &State) -> [Matrix3<f64>; 2] {
        let rotation = *state.attitude.to_rotation_matrix().matrix();
        [self.inertia, self.inverse].map(|it| rotation * it * rotation.transpose())
    }
}

/// Most commands of a jump.
const MOST: usize = 8;

/// Terms of a leg that this model of a stance has, or that a stance does not contain.
const KNOWN: [Term; 11] = [
    Term::Stroke,
    Term::Delay,
    Term::Force,
    Term::CoulombFriction,
    Term::ViscousFriction,
    Term::ReturnStiffness,
    Term::ReturnPreload,
    Term::RodLength,
    Term::RodRadius,
    Term::LegCenter,
    Term::LegMass,
];

/// Refuses a leg with a term that this model lacks.
fn has_only_known_terms(robot: &Robot) -> Result<(), GaitError> {
    let of_the_leg = |term: &&Term| term.spec().section().starts_with("leg");
    let others = Term::ALL
        .iter()
        .filter(of_the_leg)
        .filter(|term| !KNOWN.contains(term));
    for term in others {
        if let Some(value) = term.of(robot)
            && term.off(robot) != Some(value)
        {
            let allowed = "left out for a jump from rest: the model of its stance lacks it";
            return Err(refused(term.spec().key, value, allowed));
        }
    }
    Ok(())
}

impl Leg {
    fn new(robot: &Robot, k: usize, direction: &[f64; 3]) -> Result<Leg, GaitError> {
        let leg = robot.own_leg(k);
        let Drive::Constant { force } = leg.drive else {
            let allowed =
                "\"constant\" for a jump from rest: no other drive is in the model of the stance";
            return Err(refused("leg.kind, of leg", k as f64, allowed));
        };
        let spring = leg.return_spring;
        Ok(Leg {
            direction: Vec3::from(*direction),
            stroke: leg.stroke,
            delay: leg.delay,
            force,
            dry: leg.coulomb_friction,
            viscous: leg.viscous_friction,
            spring: spring.map_or((0.0, 0.0), |spring| (spring.stiffness, spring.preload)),
        })
    }
}

/// The way of `slip` along the ground, whose length is nearly 1 where it is fast.
fn direction(slip: &Vec3) -> Vec3 {
    let level = Vec3::new(slip.x, slip.y, 0.0);
    level / (level.norm_squared() + CREEP * CREEP).sqrt()
}

impl State {
    fn after(&self, rates: &Rates, span: f64) -> State {
        let turned = UnitQuaternion::from_scaled_axis(rates.spin * span) * self.attitude;
        State {
            place: self.place + rates.velocity * span,
            attitude: turned,
            velocity: self.velocity + rates.pull * span,
            spin: self.spin + rates.turn * span,
        }
    }
}
