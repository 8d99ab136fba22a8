//! One jump of a robot, fast enough to be fitted: phases, guards and resets, in fixed steps that
//! end on every event.
//!
//! The model is that of the multi-body simulation (docs/model.md), in the five coordinates that one
//! leg on the ground needs. It shares with it the force of the leg and nothing else; tests hold the
//! two together for every term of a robot file.

mod bodies;
mod contact;
mod course;
mod machine;

use contact::{Answer, Foot};
use course::Knot;
pub use course::{Course, Pose};
use machine::{Coordinates, LEAN, LEG, Machine};
use saltus_numeric::dop853;
use saltus_pneumatics::{Flow, GasState, Leg, Piece, Switches};
use saltus_robot::{Drive, Robot};

/// Terms of the motion that no listed cause has, to describe what none explains; all 0 is none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Extra {
    /// Force −c |ḋ| ḋ on the leg (N s²/m²).
    pub quadratic: f64,
    /// Dry friction of the leg for each metre of its extension (N/m).
    pub tightening: f64,
    /// Leak from the chamber for each metre of the leg's extension, as an area (m²/m).
    pub leak_along: f64,
    /// Time (s) over which the valve opens, instead of at once.
    pub opening: f64,
    /// Torque −c φ̇ against the wheel's spin (N m s/rad).
    pub spin_damping: f64,
    /// Torque −c θ̇ against the boom's pivot (N m s/rad).
    pub pivot_damping: f64,
    /// Torque −k θ against the boom's pivot (N m/rad).
    pub pivot_spring: f64,
    /// Torque −c ψ̇ against the boom's turn (N m s/rad).
    pub turn_damping: f64,
}

/// How a jump begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// On the retracted foot at a lean (rad), turning forward at a rate (rad/s).
    Rolling {
        /// Lean (rad), forward positive.
        lean: f64,
        /// Its rate (rad/s).
        rate: f64,
    },
    /// Upright, at rest; on the bench the rod retracted under its load.
    Rest,
}

/// A robot that jumps.
#[derive(Clone, Debug)]
pub struct Rig {
    machine: Machine,
    leg: Leg<f64>,
    massless: bool,
    /// One over the root of the gas' temperature (1/√K).
    per_root: f64,
    extra: Extra,
}

/// What is left of a flight when nobody asks.
const PATIENCE: f64 = 3.0;
/// Steps (s): on soft ground, while the leg fills, while it works, before it is fired, and in
/// flight. With them a jump is off by less than 1e-6 rad.
const SOFT: f64 = 2.5e-4;
const FILLING: f64 = 3e-3;
const FINE: f64 = 1e-3;
const COARSE: f64 = 6e-3;
const FLIGHT: f64 = 1.2e-2;
/// Difference of the stages of a step, as a part of the gas, above which the step is halved while
/// the leg moves.
const GAS_ERROR: f64 = 3e-4;
/// Part of the pressure by which the cubic between the ends of a step may be off while the rod
/// rests on the bench.
const CUBIC: f64 = 1e-7;
/// Longest and shortest step (s) there.
const LONG: f64 = 1.0;
const BRIEF: f64 = 1e-6;
/// Error of a step of the gas behind a held leg: of its variable, which is of the size of 1.
const GAS: f64 = 1e-10;
/// Part of the gas by which it may be away from balance, and counts as balanced.
const BALANCE: f64 = 1e-9;
/// Such steps within one of the motion, beyond which it is taken as stuck.
const MOST: usize = 10_000;
/// Events of one jump, beyond which it is taken as stuck.
const EVENTS: usize = 300;
/// A force (N) or a room that counts as none.
const TINY: f64 = 1e-7;

/// Where a function that is above 0 at `from` is 0, up to `to`.
fn root(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut inside, mut outside) = (from, to);
    for _ in 0..40 {
        let middle = 0.5 * (inside + outside);
        if f(middle) > 0.0 {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    inside
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Slide {
    /// Until it is fired.
    Latched,
    Held,
    Moves(f64),
}

#[derive(Clone, Copy, Debug)]
struct State {
    time: f64,
    q: Coordinates,
    v: Coordinates,
    gas: f64,
}

#[derive(Clone, Copy, Debug)]
struct Mode {
    foot: Foot,
    leg: Slide,
    /// Whether the drive pushes, and the leg is in its cushion.
    switches: Switches,
    /// When (s) the valve began to open.
    opens: f64,
    port_open: bool,
    piece: Option<Piece<f64>>,
    /// A leak takes less from a full chamber than the valve gives before the pressure has fallen at
    /// all.
    fed: bool,
}

/// What ends a smooth phase.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Guard {
    Lift,
    /// A leg without mass has nothing left to push with: its foot leaves the ground.
    Slack,
    Slip,
    Grip,
    Extend,
    Retract,
    Halt,
    Stroke,
    Stop,
    Above,
    Below,
    Cushion,
    Port,
}

impl Guard {
    /// Whether it may be broken at the start of a step, by a jump in a force.
    fn is_of_forces(self) -> bool {
        matches!(
            self,
            Guard::Lift | Guard::Slack | Guard::Slip | Guard::Extend | Guard::Retract
        )
    }
}

impl Rig {
    /// The rig of `robot`.
    pub fn new(robot: &Robot) -> Rig {
        let per_root = match &robot.leg.drive {
            Drive::Pneumatic(cylinder) => 1.0 / cylinder.temperature.sqrt(),
            _ => 0.0,
        };
        Rig {
            per_root,
            machine: Machine::new(robot),
            leg: Leg::new(robot, |_, x| x),
            massless: robot.leg.body.mass == 0.0,
            extra: Extra::default(),
        }
    }

    /// One leg of `robot` upright on the bench under a dead load (kg), which is all that it moves;
    /// at the end of its stroke it stays.
    pub fn bench(robot: &Robot, load: f64) -> Rig {
        Rig {
            machine: Machine::bench(robot, load),
            ..Rig::new(robot)
        }
    }

    /// The rig with terms that no listed cause has.
    #[must_use]
    pub fn with(self, extra: Extra) -> Rig {
        Rig {
            machine: self.machine.with(extra),
            extra,
            ..self
        }
    }

    /// What happens from `start` at time 0, when the valve is commanded open and shut at `open` and
    /// `shut` (s), up to `until` (s), or until the axle is back at its height on a retracted,
    /// upright leg; none where the motion cannot go on.
    pub fn jump(&self, start: Start, open: f64, shut: f64, until: Option<f64>) -> Option<Course> {
        self.jump_in_steps(start, open, shut, until, LONG)
    }

    /// The same with steps of at most `rests` (s) while the rod rests on the bench.
    fn jump_in_steps(
        &self,
        start: Start,
        open: f64,
        shut: f64,
        until: Option<f64>,
        rests: f64,
    ) -> Option<Course> {
        let mut run = Run {
            rests,
            ..Run::new(self, start)?
        };
        let (fire, release) = self.leg.answers(open, shut - open);
        let release = release.unwrap_or(f64::INFINITY);
        let end = until.unwrap_or(PATIENCE);
        let mut marks = [(open, 0), (fire, 1), (release, 2)];
        marks.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (time, what) in marks {
            run.go(time.min(end), until.is_none())?;
            if time >= end || run.landed {
                break;
            }
            match what {
                0 => run.unlatch(),
                1 => run.switch(release > fire),
                _ => run.switch(false),
            }
        }
        run.go(end, until.is_none())?;
        Some(run.course)
    }

    /// The greatest height of the axle (m) and its travel (m) from the foot when it is back at its
    /// height on the retracted leg, of a jump that begins where it fires.
    pub fn outcome(&self, lean: f64, rate: f64, valve_open: f64) -> Option<(f64, f64)> {
        let course = self.jump(Start::Rolling { lean, rate }, 0.0, valve_open, None)?;
        course.leaves?;
        course.apex_and_landing()
    }
}

struct Run<'a> {
    rig: &'a Rig,
    /// Longest step (s) while the rod rests on the bench.
    rests: f64,
    /// What the next step (s) would be there.
    stride: f64,
    time: f64,
    state: State,
    mode: Mode,
    course: Course,
    events: usize,
    landed: bool,
}

impl<'a> Run<'a> {
    fn new(rig: &'a Rig, start: Start) -> Option<Run<'a>> {
        let machine = &rig.machine;
        let (lean, rate) = match start {
            Start::Rolling { lean, rate } => (lean, rate),
            Start::Rest => (0.0, 0.0),
        };
        let (q, v) = machine.stand(lean, rate)?;
        let (piece, gas) = match rig.leg.chamber() {
            Some(chamber) => {
                let piece = Piece::new(chamber, false, chamber.ambient, 0.0, false);
                (Some(piece), chamber.variable(piece.flow, chamber.ambient))
            }
            None => (None, 0.0),
        };
        let foot = if machine.is_bench() {
            Foot::Flies
        } else {
            Foot::Stands
        };
        let mode = Mode {
            foot,
            leg: Slide::Latched,
            switches: Switches {
                energized: false,
                cushioned: false,
            },
            opens: 0.0,
            port_open: false,
            piece,
            fed: false,
        };
        let course = Course {
            boom: machine.boom,
            radius: machine.radius,
            ..Course::default()
        };
        let mut run = Run {
            rig,
            rests: LONG,
            stride: FINE,
            time: 0.0,
            state: State {
                time: 0.0,
                q,
                v,
                gas,
            },
            mode,
            course,
            events: 0,
            landed: false,
        };
        run.record();
        Some(run)
    }

    fn record(&mut self) {
        let State { q, v, .. } = self.state;
        let height = self.rig.machine.height(&q, &v);
        let pressure = self.gas(&self.state).map_or((0.0, 0.0), |(gas, rate)| {
            (gas.pressure, rate * gas.pressure_per_variable)
        });
        self.course.knots.push(Knot {
            time: self.time,
            q,
            v,
            height,
            pressure,
        });
    }

    fn unlatch(&mut self) {
        self.mode.leg = Slide::Held;
    }

    fn switch(&mut self, energized: bool) {
        self.mode.switches.energized = energized;
        self.mode.opens = self.time;
        self.renew(0.0);
        self.record();
    }

    /// The piece of the gas law at the present pressure, or just above or below it.
    fn renew(&mut self, side: f64) {
        self.mode.fed = false;
        if let (Some(chamber), Some(piece)) = (self.rig.leg.chamber(), &self.mode.piece) {
            let pressure = chamber.pressure(piece.flow, self.state.gas);
            let piece = Piece::new(
                chamber,
                self.mode.switches.energized,
                pressure,
                side,
                self.mode.port_open,
            );
            self.state.gas = chamber.variable(piece.flow, pressure);
            self.mode.piece = Some(piece);
        }
    }

    /// The gas, and how its variable changes; none without a chamber.
    fn gas(&self, s: &State) -> Option<(GasState<f64>, f64)> {
        let (chamber, piece) = (self.rig.leg.chamber()?, self.mode.piece.as_ref()?);
        let speed = if matches!(self.mode.leg, Slide::Moves(_)) {
            s.v[LEG]
        } else {
            0.0
        };
        let (gas, mut rate) = piece.gas(chamber, s.gas, s.q[LEG], speed);
        if self.mode.fed {
            return Some((gas, 0.0));
        }
        let Extra {
            leak_along,
            opening,
            ..
        } = self.rig.extra;
        let open = (s.time - self.mode.opens) / opening;
        if self.mode.switches.energized && open < 1.0 {
            // What flows through the valve, and not what the leg's motion does.
            rate -= (1.0 - open.max(0.0)) * piece.gas(chamber, s.gas, s.q[LEG], 0.0).0.rate;
        }
        if leak_along != 0.0 {
            let conductance = leak_along * s.q[LEG] * self.rig.per_root;
            let lost = conductance * chamber.law.flow(gas.pressure, chamber.ambient);
            rate -= chamber.pressure_per_mass() * gas.inverses.1 * lost / gas.pressure_per_variable;
        }
        Some((gas, rate))
    }

    /// Force (N) along the leg without dry friction, and that friction.
    fn push(&self, s: &State, pressure: f64) -> (f64, f64) {
        let leg = &self.rig.leg;
        let d = s.q[LEG];
        let switches = self.mode.switches;
        let extra = &self.rig.extra;
        let dry = leg.dry_friction(pressure);
        let speed = s.v[LEG];
        let force = leg.force(switches, d, speed, pressure).value - leg.slack_pull(switches, d);
        let push = force + dry - extra.quadratic * speed.abs() * speed;
        (push, (dry + extra.tightening * d).max(0.0))
    }

    /// Accelerations, what the ground does, how the gas changes; and dry friction of the leg.
    fn look(&self, s: &State) -> Option<(Answer, f64, f64)> {
        let (pressure, rate) = match self.mode.leg {
            Slide::Latched => (0.0, 0.0),
            _ => self
                .gas(s)
                .map_or((0.0, 0.0), |(gas, rate)| (gas.pressure, rate)),
        };
        let (push, dry) = match self.mode.leg {
            Slide::Latched => (0.0, 0.0),
            _ => self.push(s, pressure),
        };
        let (force, held) = match self.mode.leg {
            Slide::Moves(way) => (push - way * dry, false),
            _ => (push, true),
        };
        let answer = self
            .rig
            .machine
            .solve(&s.q, &s.v, force, held, self.mode.foot)?;
        Some((answer, rate, dry))
    }

    /// A Runge–Kutta step of `h`, whose first stage is given; and by what part of the gas its inner
    /// stages differ.
    fn step(&self, first: &(Answer, f64, f64), h: f64) -> Option<(State, f64)> {
        let s = &self.state;
        if self.rests() {
            let next = State {
                time: s.time + h,
                gas: self.held_gas(h)?,
                ..*s
            };
            return Some((next, 0.0));
        }
        let at = |v: &Coordinates, k: &(Answer, f64, f64), h: f64| State {
            time: s.time + h,
            q: s.q + v * h,
            v: s.v + k.0.acceleration * h,
            gas: s.gas + h * k.1,
        };
        let a = first;
        let s2 = at(&s.v, a, 0.5 * h);
        let b = self.look(&s2)?;
        let s3 = at(&s2.v, &b, 0.5 * h);
        let c = self.look(&s3)?;
        let s4 = at(&s3.v, &c, h);
        let d = self.look(&s4)?;
        let w = h / 6.0;
        let gas = match self.mode.leg {
            // Held, it does not move what is around it, and may be as stiff as it likes.
            Slide::Held => self.held_gas(h)?,
            _ => s.gas + w * (a.1 + 2.0 * (b.1 + c.1) + d.1),
        };
        let next = State {
            time: s.time + h,
            q: s.q + (s.v + (s2.v + s3.v) * 2.0 + s4.v) * w,
            v: s.v
                + (a.0.acceleration
                    + (b.0.acceleration + c.0.acceleration) * 2.0
                    + d.0.acceleration)
                    * w,
            gas,
        };
        let is_finite = next.q.iter().chain(next.v.iter()).all(|x| x.is_finite());
        let error = h * (c.1 - b.1).abs() / next.gas.abs().max(f64::MIN_POSITIVE);
        (is_finite && (next.gas > 0.0 || self.mode.piece.is_none())).then_some((next, error))
    }

    /// The gas behind a leg that is held, after `h`: in steps as short as accuracy asks, up to the
    /// balance of inflow and outflow, where it stays.
    fn held_gas(&self, h: f64) -> Option<f64> {
        let State {
            time, gas: mut u, ..
        } = self.state;
        if self.mode.piece.is_none() {
            return Some(u);
        }
        let rate = |u: f64, t: f64| {
            let there = State {
                time: time + t,
                gas: u,
                ..self.state
            };
            self.gas(&there).map_or(f64::NAN, |(_, rate)| rate)
        };
        let slopes = |y: &[f64; 2]| [rate(y[0], y[1]), 1.0];
        let (mut t, mut tau) = (0.0, h);
        for _ in 0..MOST {
            let left = h - t;
            let slope = rate(u, t);
            if left <= 0.0 || slope == 0.0 {
                return Some(u);
            }
            if !slope.is_finite() {
                return None;
            }
            // A valve that still opens moves the balance.
            let beyond = u + BALANCE * u.copysign(slope);
            if rate(beyond, h) * slope <= 0.0 && self.is_open(time + t) {
                return Some(root(u, beyond, |u| rate(u, h) * slope));
            }
            tau = tau.min(left);
            let step = dop853::step(&slopes, &[u, t], &[slope, 1.0], tau, 1, GAS);
            if step.error <= 1.0 {
                u = step.state[0];
                t = if tau < left { t + tau } else { h };
            }
            tau *= dop853::step_factor(step.error);
        }
        None
    }

    /// Whether the rod rests on the bench, where nothing moves but the gas.
    fn rests(&self) -> bool {
        self.rig.machine.is_bench() && self.mode.leg == Slide::Held
    }

    /// Whether the valve has come to where it stays.
    fn is_open(&self, time: f64) -> bool {
        !self.mode.switches.energized || time >= self.mode.opens + self.rig.extra.opening
    }

    /// By what part of the pressure the cubic from here to `next` is off in its middle.
    fn bend(&self, next: &State) -> Option<f64> {
        let h = next.time - self.state.time;
        let of = |s: &State| {
            self.gas(s)
                .map(|(gas, rate)| (gas.pressure, rate * gas.pressure_per_variable))
        };
        let Some((a, b)) = of(&self.state).zip(of(next)) else {
            return Some(0.0);
        };
        let middle = State {
            time: self.state.time + 0.5 * h,
            gas: self.held_gas(0.5 * h)?,
            ..self.state
        };
        let there = of(&middle)?.0;
        let cubic = 0.5 * (a.0 + b.0) + 0.125 * h * (a.1 - b.1);
        Some((cubic - there).abs() / there)
    }

    /// Values that are above 0 while the mode lasts.
    fn guards(
        &self,
        s: &State,
        (answer, _, dry): &(Answer, f64, f64),
        out: &mut Vec<(Guard, f64)>,
    ) {
        out.clear();
        let machine = &self.rig.machine;
        if self.mode.foot != Foot::Flies {
            out.push((Guard::Lift, answer.ground[0]));
            let moves = matches!(self.mode.leg, Slide::Moves(_));
            if self.rig.massless && moves && machine.floor.soft.is_none() {
                // A drive that is off gives 0, which is none.
                out.push((Guard::Slack, answer.push - 2.0 * TINY));
            }
            let standing = machine.floor.friction.0;
            match self.mode.foot {
                Foot::Stands if standing.is_finite() => {
                    out.push((
                        Guard::Slip,
                        standing * answer.ground[0] - answer.ground[1].abs(),
                    ));
                }
                Foot::Slips(way) => {
                    let (_, [_, along], _) = machine.contact(&s.q, &s.v);
                    out.push((Guard::Grip, way * along));
                }
                _ => {}
            }
        }
        let (d, stroke) = (s.q[LEG], self.rig.leg.stroke);
        match self.mode.leg {
            Slide::Latched => return,
            Slide::Held => {
                if d < stroke {
                    out.push((Guard::Extend, dry - answer.hold));
                }
                if d > 0.0 && !(machine.is_bench() && d >= stroke) {
                    out.push((Guard::Retract, dry + answer.hold));
                }
            }
            Slide::Moves(way) => {
                if way > 0.0 {
                    out.push((Guard::Stroke, stroke - d));
                } else {
                    out.push((Guard::Stop, d));
                }
                out.push((Guard::Halt, way * s.v[LEG]));
            }
        }
        let side = |is_past: bool, at: f64| if is_past { d - at } else { at - d };
        if let (Some(chamber), Some(piece)) = (self.rig.leg.chamber(), &self.mode.piece) {
            let (above, below) = piece.guards(s.gas);
            out.push((Guard::Above, -above));
            out.push((Guard::Below, -below));
            if let Some(port) = chamber.port() {
                out.push((Guard::Port, side(self.mode.port_open, port)));
            }
        }
        if let Some(start) = self.rig.leg.cushion_start() {
            out.push((Guard::Cushion, side(self.mode.switches.cushioned, start)));
        }
    }

    fn longest(&self) -> f64 {
        self.usual_step().min(self.rig.machine.longest_step())
    }

    fn usual_step(&self) -> f64 {
        let opening = self.rig.extra.opening;
        if self.mode.switches.energized && self.time < self.mode.opens + opening {
            return (0.25 * opening).clamp(FINE / 16.0, FINE);
        }
        if self.mode.foot != Foot::Flies && self.rig.machine.floor.soft.is_some() {
            return SOFT.min(self.rig.machine.soft_step());
        }
        match self.mode.leg {
            Slide::Latched => COARSE,
            Slide::Held if self.mode.foot == Foot::Flies && !self.rig.machine.is_bench() => {
                let is_empty = self
                    .mode
                    .piece
                    .is_none_or(|p| p.flow == Flow::ExhaustBalanced);
                if is_empty { FLIGHT } else { FLIGHT / 3.0 }
            }
            Slide::Held if !self.rig.machine.is_bench() => FILLING,
            Slide::Held => self.stride.min(self.rests),
            Slide::Moves(_) => FINE,
        }
    }

    /// Goes on to the time `end`, or if `lands`, to the landing.
    fn go(&mut self, end: f64, lands: bool) -> Option<()> {
        let (mut before, mut after) = (Vec::new(), Vec::new());
        let mut known = None;
        while self.time < end - 1e-12 && !self.landed {
            let first = match known.take() {
                Some(answer) => answer,
                None => self.look(&self.state)?,
            };
            self.guards(&self.state, &first, &mut before);
            if let Some(&(guard, _)) = before.iter().find(|(g, x)| g.is_of_forces() && *x < -TINY) {
                self.happen(guard, &first.0)?;
                continue;
            }
            let mut h = self.longest().min(end - self.time);
            let mut next = self.step(&first, h)?;
            if self.rests() {
                loop {
                    let part = self.bend(&next.0)? / CUBIC;
                    let longer = 0.8 / part.powf(0.25);
                    self.stride = (h * longer.clamp(0.02, 5.0)).clamp(BRIEF, LONG);
                    if part <= 1.0 || h <= BRIEF {
                        break;
                    }
                    h = self.stride;
                    next = self.step(&first, h)?;
                }
            }
            // A small chamber that is nearly in balance follows faster than the usual step does.
            while matches!(self.mode.leg, Slide::Moves(_)) && next.1 > GAS_ERROR && h > FINE / 16.0
            {
                h *= 0.5;
                next = self.step(&first, h)?;
            }
            let mut next = next.0;
            let mut last = self.look(&next)?;
            self.guards(&next, &last, &mut after);
            let mut hit = None;
            // The earliest of what is broken at the end of the step.
            while let Some(k) =
                (0..after.len()).find(|&k| after[k].1 < 0.0 && Some(after[k].0) != hit)
            {
                let guard = after[k].0;
                if before[k].1 < 0.0 && !guard.is_of_forces() && after[k].1 >= before[k].1 {
                    after[k].1 = 0.0;
                    continue;
                }
                let earlier = self.locate(&first, k, (before[k].1.max(0.0), after[k].1), h)?;
                if hit.is_some() && earlier >= h * (1.0 - 1e-9) {
                    // At the same instant: one after the other.
                    after[k].1 = 0.0;
                    continue;
                }
                h = earlier;
                hit = Some(guard);
                next = self.step(&first, h)?.0;
                last = self.look(&next)?;
                self.guards(&next, &last, &mut after);
            }
            self.time += h;
            self.state = next;
            self.state.time = self.time;
            if h > 0.0 {
                self.record();
            }
            match hit {
                Some(guard) => {
                    self.happen(guard, &last.0)?;
                    // Rates may be others from here on.
                    self.record();
                }
                None => known = Some(last),
            }
            if lands && self.mode.foot == Foot::Flies {
                let (height, rate) = self.rig.machine.height(&self.state.q, &self.state.v);
                self.landed = height < self.rig.machine.radius && rate < 0.0;
            }
            if self.state.q[LEAN].abs() > 3.0 && self.mode.foot != Foot::Flies {
                // Fallen over.
                return None;
            }
        }
        Some(())
    }

    /// Length of the step at whose end guard number `k` is 0, just past it: regula falsi
    /// (Illinois).
    fn locate(
        &self,
        first: &(Answer, f64, f64),
        k: usize,
        ends: (f64, f64),
        h: f64,
    ) -> Option<f64> {
        let (mut a, mut b, mut fa, mut fb) = (0.0, h, ends.0, ends.1);
        if fa == 0.0 {
            return Some(0.0);
        }
        let size = fa.abs().max(fb.abs());
        let mut guards = Vec::new();
        for _ in 0..40 {
            let c = (a * fb - b * fa) / (fb - fa);
            let state = self.step(first, c)?.0;
            let there = self.look(&state)?;
            self.guards(&state, &there, &mut guards);
            let fc = guards.get(k)?.1;
            if fc.abs() <= 1e-10 * size || b - a < 1e-13 {
                return Some(c);
            }
            if fc * fb < 0.0 {
                (a, fa) = (b, fb);
            } else {
                fa *= 0.5;
            }
            (b, fb) = (c, fc);
            if a > b {
                std::mem::swap(&mut a, &mut b);
                std::mem::swap(&mut fa, &mut fb);
            }
        }
        Some(b)
    }

    fn happen(&mut self, guard: Guard, answer: &Answer) -> Option<()> {
        self.events += 1;
        if self.events > EVENTS {
            return None;
        }
        match guard {
            Guard::Lift | Guard::Slack => self.leave(),
            Guard::Slip => self.mode.foot = Foot::Slips(-answer.ground[1].signum()),
            Guard::Grip => self.mode.foot = Foot::Stands,
            Guard::Extend => {
                self.mode.leg = Slide::Moves(1.0);
                self.mode.fed = false;
                self.course.breaks_away.get_or_insert(self.time);
            }
            Guard::Retract => {
                self.mode.leg = Slide::Moves(-1.0);
                self.mode.fed = false;
            }
            Guard::Halt => {
                self.state.v[LEG] = 0.0;
                self.mode.leg = Slide::Held;
            }
            Guard::Stroke => {
                self.state.q[LEG] = self.rig.leg.stroke;
                self.stop()?;
                if self.mode.foot != Foot::Flies && !self.rig.machine.floor.pushes_on() {
                    self.leave();
                }
            }
            Guard::Stop => {
                self.state.q[LEG] = 0.0;
                self.stop()?;
            }
            Guard::Above => self.renew(1.0),
            Guard::Below => {
                let is_full = self
                    .mode
                    .piece
                    .is_some_and(|p| p.flow == Flow::FillBalanced);
                self.renew(-1.0);
                let returns = self.gas(&self.state).is_some_and(|(_, rate)| rate > 0.0);
                self.mode.fed = is_full && returns && self.mode.leg == Slide::Held;
            }
            Guard::Cushion => self.mode.switches.cushioned ^= true,
            Guard::Port => {
                self.mode.port_open = !self.mode.port_open;
                self.renew(0.0);
            }
        }
        Some(())
    }

    /// The foot leaves the ground; a leg without mass then stays as it is.
    fn leave(&mut self) {
        self.mode.foot = Foot::Flies;
        self.course.leaves = Some(self.time);
        if self.rig.massless && !self.rig.machine.is_bench() {
            self.mode.leg = Slide::Latched;
            self.state.v[LEG] = 0.0;
            self.record();
        }
    }

    /// The leg meets an end of its stroke.
    fn stop(&mut self) -> Option<()> {
        self.state.v = self.rig.machine.stop_leg(&self.state.q, &self.state.v)?;
        self.state.v[LEG] = 0.0;
        self.mode.leg = Slide::Held;
        Some(())
    }
}

#[cfg(test)]
mod tests;
