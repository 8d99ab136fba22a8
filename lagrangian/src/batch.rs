//! Many stances at once: several jumps side by side in SIMD lanes, each on its own phase, step and event.
//!
//! A lane that finishes takes the next jump, so that none idles. What a plain pneumatic leg does in all but rare cases is
//! done here; a jump that is anything else is handed to [`Stance::jump`], whose results these equal within the tolerance.

use saltus_numeric::dop853::{self, Derivative};
use saltus_numeric::{LANES, Lanes, Scalar};
use saltus_pneumatics::{Chamber, MEGA, Valve, ValveLaw};
use saltus_robot::Robot;

use crate::advance::index::{EXTENSION, GAS, LEAN, RATE, SPEED, TIME};
use crate::advance::{CHECKED, State, WIDTH};
use crate::jump::FIRST_STEP;
use crate::phase::{FORCE_SCALE, Piece};
use crate::{Launch, LiftOff, Outcome, Stance, StanceError};

/// Numbers in a state that move.
const MOVING: usize = 6;
/// Guards of the extension: end of the stroke, force, the edges of the valve's piece above and below.
const GUARDS: usize = 4;
const STROKE: usize = 0;
const FORCE: usize = 1;
const ABOVE: usize = 2;
const BELOW: usize = 3;
/// Steps after which a lane gives its jump away.
const PATIENCE: u32 = 500;
/// A guard nearer to 0 than this is the one that was just passed.
const PASSED: f64 = -1e-9;

/// The model of a robot for many jumps.
#[derive(Clone, Debug)]
pub struct Batch {
    one: Stance<f64>,
    many: Stance<Lanes>,
}

/// A jump at the start of its extension.
#[derive(Clone, Copy)]
struct Ready {
    job: usize,
    state: State<f64>,
    time_fire: f64,
    close: f64,
}

impl Batch {
    /// The model of `robot` with an error `tolerance` as in [`Stance`].
    pub fn new(robot: &Robot, tolerance: f64) -> Batch {
        let many = Stance::<Lanes>::assemble(robot, |_, x| Lanes::of(x)).with_tolerance(tolerance);
        Batch { one: Stance::new(robot, |_, x| x).with_tolerance(tolerance), many }
    }

    /// The model of a single jump.
    pub fn stance(&self) -> &Stance<f64> {
        &self.one
    }

    /// The end of each of `launches`, in their order.
    ///
    /// # Errors
    /// Each as [`Stance::jump`].
    pub fn jumps(&self, launches: &[Launch]) -> Vec<Result<LiftOff, StanceError>> {
        let mut ends = vec![None; launches.len()];
        if let (Some(chamber), Some(lane_chamber)) = (self.one.leg.chamber(), self.many.leg.chamber())
            && self.one.plain
        {
            let ready = self.prepare(launches, lane_chamber);
            let mut crew = Crew::new(&self.one, chamber, &self.many, lane_chamber);
            crew.work(&ready, &mut ends);
        }
        ends.into_iter()
            .zip(launches)
            .map(|(end, launch)| end.map_or_else(|| self.one.jump(launch), Ok))
            .collect()
    }

    /// Pivoting and filling by their closed forms, several at a time; leaves out every jump for which these do not hold to
    /// round-off.
    fn prepare(&self, launches: &[Launch], chamber: &Chamber<Lanes>) -> Vec<Ready> {
        let mut ready = Vec::with_capacity(launches.len());
        for (block, chunk) in launches.chunks(LANES).enumerate() {
            let column = |f: fn(&Launch) -> f64| {
                Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| f(&chunk[i.min(chunk.len() - 1)])))
            };
            let (lean, angle, open) =
                (column(|l| l.lean), column(|l| l.firing_angle), column(|l| l.valve_open));
            let start = self.many.closed_start(column(|l| l.rate), lean, angle, open, chamber);
            let rows = start.columns.map(Lanes::to_array);
            let sound = start.sound.to_array();
            for (i, launch) in chunk.iter().enumerate() {
                // A mask's lanes are all ones (which is a NaN) or all zeros.
                if sound[i] != 0.0 && launch.check().is_ok() {
                    let row = rows.map(|column| column[i]);
                    let [lean, rate, gas, time, time_fire] = row;
                    let mut state = [0.0; WIDTH];
                    (state[LEAN], state[RATE], state[GAS], state[TIME]) = (lean, rate, gas, time);
                    // Where the robot's own swing pulls the leg out, there may be no force left to push with.
                    let pushes = self.one.leg.chamber().is_some_and(|chamber| {
                        self.one.leg.plain_force(chamber, 0.0, gas * MEGA).value > 0.0
                    });
                    if !pushes {
                        continue;
                    }
                    let close = time_fire + self.one.leg.delay + launch.valve_open;
                    ready.push(Ready { job: block * LANES + i, state, time_fire, close });
                }
            }
        }
        ready
    }
}

/// The start of several extensions: lean, rate, pressure (MPa), time, time of firing; and in which lanes this is exact.
struct ClosedStart {
    columns: [Lanes; 5],
    sound: Lanes,
}

impl Stance<Lanes> {
    fn closed_start(
        &self,
        rate: Lanes,
        lean: Lanes,
        angle: Lanes,
        open: Lanes,
        chamber: &Chamber<Lanes>,
    ) -> ClosedStart {
        let of = Lanes::of;
        let pendulum = &self.pendulum;
        let invariant = pendulum.invariant(lean, rate);
        let pivots = lean.simd_lt(angle);
        let fire_lean = pivots.select(angle, lean);
        let at_top = invariant - of(2.0) * pendulum.stiffness;
        // One panel is exact where it stays clear of the zeros of the rate, φ = ±i acosh(1 + q): at least
        // 1.28 min(√q, 1) away.
        let q = at_top / (of(2.0) * pendulum.stiffness);
        let clear = of(1.28) * q.fast_max(of(0.0)).sqrt().fast_min(of(1.0));
        let near = (fire_lean - lean) * of(0.8);
        let mut sound = (!pivots) | (at_top.simd_gt(of(0.0)) & near.simd_le(clear));
        let fire_rate =
            pivots.select(pendulum.rate_squared(invariant, fire_lean).fast_max(of(0.0)).sqrt(), rate);
        let time_fire = pivots.select(pendulum.panel_time(invariant, lean, fire_lean), of(0.0));

        let mut fired = [of(0.0); WIDTH];
        (fired[LEAN], fired[RATE]) = (fire_lean, fire_rate);
        let freed = self.series_break_away(chamber, &fired);
        let wait = freed.time - self.leg.delay;
        let on_ground =
            pendulum.keeps_ground(invariant, lean.fast_min(freed.lean), lean.fast_max(freed.lean));
        for holds in [
            freed.residual.abs().simd_lt(of(1e-6)),
            freed.tail.simd_lt(of(1e-16)),
            wait.simd_ge(of(0.0)),
            wait.simd_le(open),
            freed.pressure.simd_le(chamber.fill_edge()),
            on_ground,
        ] {
            sound &= holds;
        }
        ClosedStart {
            columns: [
                freed.lean,
                freed.rate,
                freed.pressure * of(1.0 / MEGA),
                time_fire + freed.time,
                time_fire,
            ],
            sound,
        }
    }
}

/// What a lane does next.
#[derive(Clone, Copy, PartialEq)]
enum Plan {
    /// An ordinary step, the last one before the valve closes if `bool` holds.
    Step(bool),
    /// A step onto a guard, which straight extrapolation expects after so many seconds.
    Event(usize, f64),
}

/// A jump in its lane.
#[derive(Clone, Copy)]
struct Lane {
    ready: Ready,
    piece: Piece<f64>,
    /// When the valve closes; infinite once it has.
    end: f64,
    step: f64,
    armed: [bool; GUARDS],
    /// The next step is an ordinary one, no longer than this.
    cautious: Option<f64>,
    plan: Plan,
    length: f64,
    patience: u32,
}

/// The lanes at work.
struct Crew<'a> {
    one: &'a Stance<f64>,
    chamber: &'a Chamber<f64>,
    field: Field<'a>,
    lanes: [Option<Lane>; LANES],
    states: [[f64; LANES]; MOVING],
}

/// The equations of motion in all lanes, each with its piece of the valve's law and its independent variable.
struct Field<'a> {
    stance: &'a Stance<Lanes>,
    chamber: &'a Chamber<Lanes>,
    valve: Valve<Lanes>,
    /// 1 or −1: how the pressure moves with u.
    sign: Lanes,
    low: Lanes,
    high: Lanes,
    /// Where the independent variable is time, and where each guard.
    in_time: Lanes,
    along: [Lanes; GUARDS],
    /// Whether any lane goes along a guard.
    any_event: bool,
}

impl Field<'_> {
    /// Rates in time, the guards, and their rates.
    #[inline(always)]
    fn look(&self, y: &[Lanes; MOVING]) -> ([Lanes; MOVING], [Lanes; GUARDS], [Lanes; GUARDS]) {
        let (gas, about) = self.stance.gas(y, self.chamber, &self.valve);
        let force = self.stance.leg.plain_force(self.chamber, y[SPEED], gas.pressure);
        let mut dy = self.stance.motion(y, force.value, about);
        dy[GAS] = gas.rate;
        let change =
            force.wrt_pressure.mul_add(gas.rate * gas.pressure_per_variable, force.wrt_speed * dy[SPEED]);
        let rise = self.sign * gas.rate;
        let scale = Lanes::of(-FORCE_SCALE);
        let guards = [
            y[EXTENSION] - self.stance.leg.stroke,
            force.value * scale,
            self.sign * (y[GAS] - self.high),
            self.sign * (self.low - y[GAS]),
        ];
        (dy, guards, [y[SPEED], change * scale, rise, -rise])
    }

    /// Derivative with respect to each lane's independent variable.
    #[inline(always)]
    fn scaled(&self, dy: [Lanes; MOVING], guards: &[Lanes; GUARDS]) -> [Lanes; MOVING] {
        if !self.any_event {
            return dy;
        }
        let mut pace = self.in_time;
        for (along, rate) in self.along.iter().zip(guards) {
            pace = along.mul_add(*rate, pace);
        }
        let inverse = Lanes::of(1.0) / pace;
        dy.map(|d| d * inverse)
    }
}

impl Derivative<Lanes, MOVING> for Field<'_> {
    #[inline(always)]
    fn at(&self, y: &[Lanes; MOVING]) -> [Lanes; MOVING] {
        let (dy, _, guard_rates) = self.look(y);
        self.scaled(dy, &guard_rates)
    }
}

/// Sets one lane of a register.
fn set(register: &mut Lanes, lane: usize, value: f64) {
    register.as_mut_array()[lane] = value;
}

impl<'a> Crew<'a> {
    fn new(
        one: &'a Stance<f64>,
        chamber: &'a Chamber<f64>,
        many: &'a Stance<Lanes>,
        lane_chamber: &'a Chamber<Lanes>,
    ) -> Self {
        let (zero, unit) = (Lanes::of(0.0), Lanes::of(1.0));
        let law = ValveLaw { constant: zero, flow: zero, expansion: zero, stiffness: unit };
        let field = Field {
            stance: many,
            chamber: lane_chamber,
            // An idle lane rests: sonic, nothing flows, half a megapascal.
            valve: Valve { law, sonic: unit.simd_gt(zero), outward: unit.simd_lt(zero) },
            sign: unit,
            low: zero,
            high: unit,
            in_time: unit,
            along: [zero; GUARDS],
            any_event: false,
        };
        let mut states = [[0.0; LANES]; MOVING];
        states[GAS] = [0.5; LANES];
        Crew { one, chamber, field, lanes: [None; LANES], states }
    }

    fn work(&mut self, ready: &[Ready], ends: &mut [Option<LiftOff>]) {
        let mut queue = ready.iter();
        for lane in 0..LANES {
            self.take(lane, queue.next());
        }
        while self.lanes.iter().any(Option::is_some) {
            let y = self.states.map(Lanes::from);
            let (dy, guards, guard_rates) = self.field.look(&y);
            let guards = guards.map(Lanes::to_array);
            self.plan(&guards, &guard_rates.map(Lanes::to_array));
            let lengths: [f64; LANES] = std::array::from_fn(|i| self.lanes[i].map_or(0.0, |l| l.length));
            let k0 = self.field.scaled(dy, &guard_rates);
            let step = dop853::step(&self.field, &y, &k0, Lanes::from(lengths), CHECKED, self.one.tolerance);
            let next = step.state.map(Lanes::to_array);
            let next_guards = self.field.look(&step.state).1.map(Lanes::to_array);
            let error = step.error.to_array();
            for i in 0..LANES {
                let state = std::array::from_fn(|k| next[k][i]);
                if let Some(end) = self.judge(
                    i,
                    error[i],
                    &state,
                    &std::array::from_fn(|g| guards[g][i]),
                    &std::array::from_fn(|g| next_guards[g][i]),
                ) {
                    if let (Some(end), Some(lane)) = (end.0, self.lanes[i]) {
                        ends[lane.ready.job] = Some(end);
                    }
                    self.take(i, queue.next());
                }
            }
        }
    }

    /// Gives lane `i` its next jump, or rest.
    fn take(&mut self, i: usize, ready: Option<&Ready>) {
        let Some(ready) = ready else {
            self.lanes[i] = None;
            for (k, column) in self.states.iter_mut().enumerate() {
                column[i] = if k == GAS { 0.5 } else { 0.0 };
            }
            return;
        };
        let p = ready.state[GAS] * MEGA;
        let piece = Piece::new(self.chamber, true, p, 0.0, false);
        self.lanes[i] = Some(Lane {
            ready: *ready,
            piece,
            end: ready.close,
            step: FIRST_STEP,
            armed: [false; GUARDS],
            cautious: None,
            plan: Plan::Step(false),
            length: 0.0,
            patience: PATIENCE,
        });
        let mut state = ready.state;
        state[GAS] = self.chamber.variable(piece.flow, p);
        self.enter(i, piece, &state);
    }

    /// Puts lane `i` on `piece` of the valve's law at `state`.
    fn enter(&mut self, i: usize, piece: Piece<f64>, state: &[f64]) {
        for (column, value) in self.states.iter_mut().zip(state) {
            column[i] = *value;
        }
        let field = &mut self.field;
        let law = piece.valve.law;
        set(&mut field.valve.law.constant, i, law.constant);
        set(&mut field.valve.law.flow, i, law.flow);
        set(&mut field.valve.law.expansion, i, law.expansion);
        set(&mut field.valve.law.stiffness, i, law.stiffness);
        let mask = |yes: bool| if yes { f64::from_bits(u64::MAX) } else { 0.0 };
        set(&mut field.valve.sonic, i, mask(piece.valve.sonic));
        set(&mut field.valve.outward, i, mask(piece.valve.outward));
        set(&mut field.sign, i, piece.sign);
        set(&mut field.low, i, piece.low);
        set(&mut field.high, i, piece.high);
        if let Some(lane) = &mut self.lanes[i] {
            lane.piece = piece;
            lane.armed = [false; GUARDS];
        }
    }

    /// Decides what each lane does next.
    fn plan(&mut self, guards: &[[f64; LANES]; GUARDS], rates: &[[f64; LANES]; GUARDS]) {
        self.field.any_event = false;
        for i in 0..LANES {
            let mut along = [0.0; GUARDS];
            if let Some(lane) = &mut self.lanes[i] {
                let left = lane.end - self.states[TIME][i];
                let trial = lane.step.min(left);
                lane.plan = Plan::Step(lane.step >= left);
                lane.length = trial;
                if let Some(limit) = lane.cautious {
                    lane.length = trial.min(limit);
                    lane.plan = Plan::Step(lane.length >= left);
                } else {
                    let mut soonest = 0.9 * trial;
                    for g in 0..GUARDS {
                        let (value, rate) = (guards[g][i], rates[g][i]);
                        let fresh = !lane.armed[g] && value > PASSED;
                        if !fresh && value < 0.0 && -value < rate * soonest {
                            soonest = -value / rate;
                            lane.plan = Plan::Event(g, soonest);
                            lane.length = -value;
                        }
                    }
                }
                if let Plan::Event(g, _) = lane.plan {
                    along[g] = 1.0;
                    self.field.any_event = true;
                }
            }
            let in_time = if along == [0.0; GUARDS] { 1.0 } else { 0.0 };
            set(&mut self.field.in_time, i, in_time);
            for (register, value) in self.field.along.iter_mut().zip(along) {
                set(register, i, value);
            }
        }
    }

    /// Accepts or refuses the step of lane `i`; `Some` where the lane is done with its jump: with its end, or (inner
    /// none) giving it away.
    fn judge(
        &mut self,
        i: usize,
        error: f64,
        next: &[f64; MOVING],
        before: &[f64; GUARDS],
        after: &[f64; GUARDS],
    ) -> Option<Given> {
        let mut lane = self.lanes[i]?;
        lane.patience -= 1;
        // A leg that comes to a halt, or too many steps, are for the careful one.
        if lane.patience == 0 || next[SPEED] <= 0.0 {
            return Some(Given(None));
        }
        let now = self.states[TIME][i];
        let was_fresh: [bool; GUARDS] = std::array::from_fn(|g| !lane.armed[g] && before[g] > PASSED);
        let good = error <= 1.0;
        match lane.plan {
            Plan::Event(g, wait) => {
                let others = (0..GUARDS).all(|o| o == g || was_fresh[o] || after[o] <= 0.0);
                if good && others && next[TIME] > now && next[TIME] <= lane.end {
                    lane.step = lane.step.max(wait);
                    self.lanes[i] = Some(lane);
                    return self.event(i, g, next);
                }
                lane.cautious = Some(0.5 * wait);
            }
            Plan::Step(last) => {
                lane.cautious = None;
                let crossed = (0..GUARDS)
                    .filter(|&g| !was_fresh[g] && before[g] < 0.0 && after[g] >= 0.0)
                    .map(|g| before[g] / (before[g] - after[g]))
                    .fold(f64::INFINITY, f64::min);
                if !good {
                    lane.step = lane.length * dop853::step_factor(error);
                } else if crossed < f64::INFINITY {
                    // Close in on the event, so that it is foreseen.
                    lane.step = lane.length;
                    lane.cautious = Some(lane.length * (0.9 * crossed).max(0.1));
                } else if (0..GUARDS).any(|g| was_fresh[g] && after[g] >= 0.0) {
                    return Some(Given(None));
                } else {
                    lane.armed = [true; GUARDS];
                    for (column, value) in self.states.iter_mut().zip(next) {
                        column[i] = *value;
                    }
                    if !last || lane.length >= lane.step {
                        lane.step = lane.length * dop853::step_factor(error);
                    }
                    if last {
                        self.states[TIME][i] = lane.end;
                        lane.end = f64::INFINITY;
                        lane.step = lane.step.min(FIRST_STEP);
                        self.lanes[i] = Some(lane);
                        return self.switch(i, false, 0.0);
                    }
                }
            }
        }
        self.lanes[i] = Some(lane);
        None
    }

    /// The event of guard `g` at the state `next` of lane `i`.
    fn event(&mut self, i: usize, g: usize, next: &[f64; MOVING]) -> Option<Given> {
        for (column, value) in self.states.iter_mut().zip(next) {
            column[i] = *value;
        }
        let lane = self.lanes[i]?;
        let energized = lane.end < f64::INFINITY;
        match g {
            ABOVE => self.switch(i, energized, 1.0),
            BELOW => self.switch(i, energized, -1.0),
            STROKE => Some(Given(self.end(i, Outcome::Stroke))),
            FORCE => Some(Given(self.end(i, Outcome::Force))),
            _ => Some(Given(None)),
        }
    }

    /// Puts lane `i` on the piece of the valve's law that its pressure calls for.
    fn switch(&mut self, i: usize, energized: bool, side: f64) -> Option<Given> {
        let lane = self.lanes[i]?;
        let mut state: [f64; MOVING] = std::array::from_fn(|k| self.states[k][i]);
        let p = self.chamber.pressure(lane.piece.flow, state[GAS]);
        let piece = Piece::new(self.chamber, energized, p, side, false);
        state[GAS] = self.chamber.variable(piece.flow, p);
        self.enter(i, piece, &state);
        // With the valve closed the leg may have no force left: that is for the careful one.
        let push = self.one.leg.plain_force(self.chamber, state[SPEED], p).value;
        (push <= 0.0).then_some(Given(None))
    }

    fn end(&self, i: usize, outcome: Outcome) -> Option<LiftOff> {
        let lane = self.lanes[i]?;
        let mut y = [0.0; WIDTH];
        for (k, column) in self.states.iter().enumerate() {
            y[k] = column[i];
        }
        y[GAS] = self.chamber.pressure(lane.piece.flow, y[GAS]) / MEGA;
        let outcome = outcome.unless_fallen(y[LEAN]);
        Some(LiftOff::new(self.one, outcome, lane.ready.time_fire, &y))
    }
}

/// A jump that leaves its lane: with its end, or given away.
struct Given(Option<LiftOff>);
