//! Many stances at once: several jumps side by side in SIMD lanes, each on its own phase, step and
//! event.
//!
//! A lane that finishes takes the next jump, so that none idles. What a plain pneumatic leg does in
//! all but rare cases is done here; a jump that is anything else is handed to [`Stance::jump`],
//! whose results these equal within the tolerance.

use saltus_numeric::dop853::{self, Derivative, Step};
use saltus_numeric::{LANES, Lanes, Scalar, Width};
use saltus_pneumatics::{Chamber, Flow, MEGA, Piece, Valve, ValveLaw};
use saltus_robot::Robot;

use crate::advance::index::{EXTENSION, GAS, LEAN, RATE, SPEED, TIME};
use crate::advance::{CHECKED, State, WIDTH};
use crate::observer::{FIRST_STEP, ended};
use crate::phase::FORCE_SCALE;
use crate::stance;
use crate::{Launch, LiftOff, Outcome, Stance, StanceError};

/// Guards of the extension: end of the stroke, force, the edges of the valve's piece above and
/// below.
const GUARDS: usize = 4;
const STROKE: usize = 0;
const FORCE: usize = 1;
const ABOVE: usize = 2;
const BELOW: usize = 3;
/// Steps after which a lane gives its jump away.
const PATIENCE: f64 = 500.0;
/// A guard nearer to 0 than this is the one that was just passed.
const PASSED: f64 = -1e-9;

/// The model of a robot for many jumps.
#[derive(Clone, Debug)]
pub struct Batch {
    one: Stance<f64>,
    many: Stance<Lanes>,
    width: Width,
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
        Batch {
            one: Stance::new(robot, |_, x| x).with_tolerance(tolerance),
            many,
            width: Width::best(),
        }
    }

    /// The same in registers of `width`, or of the base where the processor has it not. The results
    /// are the same bits for all that fuse.
    pub fn with_width(self, width: Width) -> Batch {
        Batch {
            width: if width.is_here() { width } else { Width::Base },
            ..self
        }
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
        if let (Some(chamber), Some(lane_chamber)) =
            (self.one.leg.chamber(), self.many.leg.chamber())
            && self.one.plain
        {
            // All of it is inlined here: what is not is compiled for the base, and forty times
            // slower. Without fused multiply-add every jump goes one by one.
            self.width.run_fused(
                #[inline(always)]
                || {
                    let ready = self.prepare(launches, lane_chamber);
                    Crew::new(&self.one, chamber, &self.many, lane_chamber).work(&ready, &mut ends);
                },
            );
        }
        ends.into_iter()
            .zip(launches)
            .map(|(end, launch)| end.map_or_else(|| self.one.jump(launch), Ok))
            .collect()
    }

    /// Pivoting and filling by their closed forms, several at a time; leaves out every jump for
    /// which these do not hold to round-off.
    #[inline(always)]
    fn prepare(&self, launches: &[Launch], chamber: &Chamber<Lanes>) -> Vec<Ready> {
        let mut ready = Vec::with_capacity(launches.len());
        for (block, chunk) in launches.chunks(LANES).enumerate() {
            let column = |f: fn(&Launch) -> f64| {
                Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| {
                    f(&chunk[i.min(chunk.len() - 1)])
                }))
            };
            let (lean, angle, open) = (
                column(|l| l.lean),
                column(|l| l.firing_angle),
                column(|l| l.valve_open),
            );
            let start = self
                .many
                .closed_start(column(|l| l.rate), lean, angle, open, chamber);
            let rows = start.columns.map(Lanes::to_array);
            let sound = start.sound.to_array();
            for (i, launch) in chunk.iter().enumerate() {
                // A mask's lanes are all ones (which is a NaN) or all zeros.
                if sound[i] != 0.0 && stance::check(launch).is_ok() {
                    let row = rows.map(|column| column[i]);
                    let [lean, rate, gas, time, time_fire] = row;
                    let mut state = [0.0; WIDTH];
                    (state[LEAN], state[RATE], state[GAS], state[TIME]) = (lean, rate, gas, time);
                    // Where the robot's own swing pulls the leg out, there may be no force left to
                    // push with.
                    let pushes = self.one.leg.chamber().is_some_and(|chamber| {
                        self.one.leg.plain_force(chamber, 0.0, gas * MEGA).value > 0.0
                    });
                    if !pushes {
                        continue;
                    }
                    let (_, close) = self.one.leg.answers(time_fire, launch.valve_open);
                    ready.push(Ready {
                        job: block * LANES + i,
                        state,
                        time_fire,
                        close: close.unwrap_or(f64::INFINITY),
                    });
                }
            }
        }
        ready
    }
}

/// The start of several extensions: lean, rate, pressure (MPa), time, time of firing; and in which
/// lanes this is exact.
struct ClosedStart {
    columns: [Lanes; 5],
    sound: Lanes,
}

impl Stance<Lanes> {
    #[inline(always)]
    fn closed_start(
        &self,
        rate: Lanes,
        lean: Lanes,
        angle: Lanes,
        opening: Lanes,
        chamber: &Chamber<Lanes>,
    ) -> ClosedStart {
        let of = Lanes::of;
        let pendulum = &self.pendulum;
        let invariant = pendulum.invariant(lean, rate);
        let pivots = lean.lt(angle);
        let fire_lean = pivots.choose(angle, lean);
        let at_top = invariant - of(2.0) * pendulum.stiffness;
        // One panel is exact where it stays clear of the zeros of the rate, φ = ±i acosh(1 + q): at
        // least 1.28 min(√q, 1) away.
        let q = at_top / (of(2.0) * pendulum.stiffness);
        let clear = of(1.28) * q.max(of(0.0)).sqrt().min(of(1.0));
        let near = (fire_lean - lean) * of(0.8);
        let mut sound = (!pivots) | (at_top.gt(of(0.0)) & near.le(clear));
        let fire_rate = pivots.choose(
            pendulum
                .rate_squared(invariant, fire_lean)
                .max(of(0.0))
                .sqrt(),
            rate,
        );
        let time_fire = pivots.choose(pendulum.panel_time(invariant, lean, fire_lean), of(0.0));

        let mut fired = [of(0.0); WIDTH];
        (fired[LEAN], fired[RATE]) = (fire_lean, fire_rate);
        let freed = self.series_break_away(chamber, &fired);
        let time = time_fire + freed.time;
        let (open, close) = self.leg.answers(time_fire, opening);
        let on_ground =
            pendulum.keeps_ground(invariant, lean.min(freed.lean), lean.max(freed.lean));
        for holds in [
            freed.residual.abs().lt(of(1e-6)),
            freed.tail.lt(of(1e-16)),
            time.ge(open),
            time.le(close.unwrap_or(time)),
            freed.pressure.le(chamber.fill_edge()),
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

/// The jump in a lane.
#[derive(Clone, Copy)]
struct Job {
    ready: Ready,
    /// The piece of the valve's law that it is on.
    flow: Flow,
}

/// The lanes at work. Masks are all ones (which is a NaN) where they hold, and 0 elsewhere.
struct Crew<'a> {
    one: &'a Stance<f64>,
    chamber: &'a Chamber<f64>,
    field: Field<'a>,
    jobs: [Option<Job>; LANES],
    states: [Lanes; WIDTH],
    /// When the valve closes; infinite once it has.
    end: Lanes,
    /// Length (s) of the next ordinary step.
    step: Lanes,
    /// Where not infinite, the next step is an ordinary one, no longer than this (s).
    limit: Lanes,
    /// Steps left before the jump is given away.
    patience: Lanes,
    /// Guards that may act: all, once a step has been taken on the piece.
    armed: [Lanes; GUARDS],
}

/// What each lane does next.
struct Plan {
    /// Length of the step, in time or along a guard.
    length: Lanes,
    /// The guard whose event the step goes onto; negative where it is an ordinary step.
    event: Lanes,
    /// When straight extrapolation expects that event (s from now).
    wait: Lanes,
    /// Where the step is the last one before the valve closes, if it is an ordinary one.
    last: Lanes,
    /// Guards that were just passed.
    fresh: [Lanes; GUARDS],
}

/// A step of all lanes and how it was planned, lane by lane.
struct Taken {
    length: [f64; LANES],
    event: [f64; LANES],
    wait: [f64; LANES],
    fresh: [[f64; LANES]; GUARDS],
    error: [f64; LANES],
    next: [[f64; LANES]; WIDTH],
    before: [[f64; LANES]; GUARDS],
    after: [[f64; LANES]; GUARDS],
}

/// The equations of motion in all lanes, each with its piece of the valve's law and its independent
/// variable.
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
    fn look(&self, y: &[Lanes; WIDTH]) -> ([Lanes; WIDTH], [Lanes; GUARDS], [Lanes; GUARDS]) {
        let (gas, about) = self.stance.gas(y, self.chamber, &self.valve);
        let force = self
            .stance
            .leg
            .plain_force(self.chamber, y[SPEED], gas.pressure);
        let mut dy = self.stance.motion(y, force.value, about);
        dy[GAS] = gas.rate;
        let change = force.wrt_pressure.mul_add(
            gas.rate * gas.pressure_per_variable,
            force.wrt_speed * dy[SPEED],
        );
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
    fn scaled(&self, dy: &[Lanes; WIDTH], guards: &[Lanes; GUARDS]) -> [Lanes; WIDTH] {
        if !self.any_event {
            return *dy;
        }
        let mut pace = self.in_time;
        for (along, rate) in self.along.iter().zip(guards) {
            pace = along.mul_add(*rate, pace);
        }
        let inverse = Lanes::of(1.0) / pace;
        dy.map(|d| d * inverse)
    }
}

impl Derivative<Lanes, WIDTH> for Field<'_> {
    #[inline(always)]
    fn at(&self, y: &[Lanes; WIDTH]) -> [Lanes; WIDTH] {
        let (dy, _, guard_rates) = self.look(y);
        self.scaled(&dy, &guard_rates)
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
        let law = ValveLaw {
            constant: zero,
            flow: zero,
            expansion: zero,
            stiffness: unit,
        };
        let field = Field {
            stance: many,
            chamber: lane_chamber,
            // An idle lane rests: sonic, nothing flows, half a megapascal.
            valve: Valve {
                law,
                sonic: unit.gt(zero),
                outward: unit.lt(zero),
            },
            sign: unit,
            low: zero,
            high: unit,
            in_time: unit,
            along: [zero; GUARDS],
            any_event: false,
        };
        let mut crew = Crew {
            one,
            chamber,
            field,
            jobs: [None; LANES],
            states: [zero; WIDTH],
            end: zero,
            step: zero,
            limit: zero,
            patience: zero,
            armed: [zero; GUARDS],
        };
        crew.states[GAS] = Lanes::of(0.5);
        crew
    }

    #[inline(always)]
    fn work(&mut self, ready: &[Ready], ends: &mut [Option<LiftOff>]) {
        let mut queue = ready.iter();
        for lane in 0..LANES {
            self.take(lane, queue.next());
        }
        // What the field tells of the states, where the last step has told it.
        let mut known = None;
        while self.jobs.iter().any(Option::is_some) {
            let (dy, before, rates) = known
                .take()
                .unwrap_or_else(|| self.field.look(&self.states));
            let plan = self.plan(&before, &rates);
            let k0 = self.field.scaled(&dy, &rates);
            let step = dop853::step(
                &self.field,
                &self.states,
                &k0,
                plan.length,
                CHECKED,
                self.one.tolerance,
            );
            let there = self.field.look(&step.state);
            let after = there.1;
            let (usual, moved) = self.go_on(&plan, &step, &before, &after);
            if moved.all() {
                known = Some(there);
            }
            if usual.all() {
                continue;
            }
            let taken = Taken {
                length: plan.length.to_array(),
                event: plan.event.to_array(),
                wait: plan.wait.to_array(),
                fresh: plan.fresh.map(Lanes::to_array),
                error: step.error.to_array(),
                next: step.state.map(Lanes::to_array),
                before: before.map(Lanes::to_array),
                after: after.map(Lanes::to_array),
            };
            let usual = usual.to_array();
            for i in (0..LANES).filter(|&i| usual[i] == 0.0) {
                let Some(job) = self.jobs[i] else { continue };
                if let Some(Given(end)) = self.judge(i, &taken) {
                    ends[job.ready.job] = end;
                    self.take(i, queue.next());
                }
            }
        }
    }

    /// Gives lane `i` its next jump, or rest: steps of no length.
    fn take(&mut self, i: usize, ready: Option<&Ready>) {
        let Some(ready) = ready else {
            self.jobs[i] = None;
            for (k, column) in self.states.iter_mut().enumerate() {
                set(column, i, if k == GAS { 0.5 } else { 0.0 });
            }
            set(&mut self.end, i, 0.0);
            return;
        };
        let p = ready.state[GAS] * MEGA;
        let piece = Piece::new(self.chamber, true, p, 0.0, false);
        self.jobs[i] = Some(Job {
            ready: *ready,
            flow: piece.flow,
        });
        set(&mut self.end, i, ready.close);
        set(&mut self.step, i, FIRST_STEP);
        set(&mut self.limit, i, f64::INFINITY);
        set(&mut self.patience, i, PATIENCE);
        let mut state = ready.state;
        state[GAS] = self.chamber.variable(piece.flow, p);
        self.move_to(i, &state);
        self.enter(i, piece);
    }

    /// Puts lane `i` at `state`.
    fn move_to(&mut self, i: usize, state: &[f64]) {
        for (column, value) in self.states.iter_mut().zip(state) {
            set(column, i, *value);
        }
    }

    /// Puts lane `i` on `piece` of the valve's law.
    fn enter(&mut self, i: usize, piece: Piece<f64>) {
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
        for armed in &mut self.armed {
            set(armed, i, 0.0);
        }
    }

    /// Decides what each lane does next.
    #[inline(always)]
    fn plan(&mut self, guards: &[Lanes; GUARDS], rates: &[Lanes; GUARDS]) -> Plan {
        let of = Lanes::of;
        let left = self.end - self.states[TIME];
        let trial = self.step.min(left);
        let length = trial.min(self.limit);
        let is_free = self.limit.equal(of(f64::INFINITY));
        let mut plan = Plan {
            length,
            event: of(-1.0),
            wait: is_free.choose(of(0.9) * trial, of(0.0)),
            last: length.ge(left),
            fresh: [of(0.0); GUARDS],
        };
        for g in 0..GUARDS {
            let (value, rate) = (guards[g], rates[g]);
            let fresh = !self.armed[g] & value.gt(of(PASSED));
            let due = !fresh & value.lt(of(0.0)) & (-value).lt(rate * plan.wait);
            plan.wait = due.choose(-value / rate, plan.wait);
            plan.length = due.choose(-value, plan.length);
            plan.event = due.choose(of(g as f64), plan.event);
            plan.fresh[g] = fresh;
        }
        let in_time = plan.event.lt(of(0.0));
        self.field.any_event = !in_time.all();
        self.field.in_time = in_time & of(1.0);
        self.field.along = std::array::from_fn(|g| plan.event.equal(of(g as f64)) & of(1.0));
        plan
    }

    /// Accepts or refuses the ordinary steps without an event; says in which lanes, and which of these
    /// were accepted. The other lanes need a closer look.
    #[inline(always)]
    fn go_on(
        &mut self,
        plan: &Plan,
        step: &Step<Lanes, WIDTH>,
        before: &[Lanes; GUARDS],
        after: &[Lanes; GUARDS],
    ) -> (Lanes, Lanes) {
        let of = Lanes::of;
        let good = step.error.le(of(1.0));
        let mut eventful = plan.last;
        for g in 0..GUARDS {
            eventful |= (plan.fresh[g] | before[g].lt(of(0.0))) & after[g].ge(of(0.0));
        }
        self.patience -= of(1.0);
        let unusual = self.field.in_time.equal(of(0.0))
            | self.patience.le(of(0.0))
            | step.state[SPEED].le(of(0.0))
            | (good & eventful);
        let usual = !unusual;
        let moved = usual & good;
        for (state, next) in self.states.iter_mut().zip(&step.state) {
            *state = moved.choose(*next, *state);
        }
        for armed in &mut self.armed {
            *armed |= moved;
        }
        self.step = usual.choose(plan.length * dop853::step_factor(step.error), self.step);
        self.limit = usual.choose(of(f64::INFINITY), self.limit);
        (usual, moved)
    }

    /// Accepts or refuses the unusual step of lane `i`; `Some` where the lane is done with its
    /// jump.
    fn judge(&mut self, i: usize, taken: &Taken) -> Option<Given> {
        let next: [f64; WIDTH] = std::array::from_fn(|k| taken.next[k][i]);
        // A leg that comes to a halt, or too many steps, are for the careful one.
        if self.patience.as_array()[i] <= 0.0 || next[SPEED] <= 0.0 {
            return Some(Given(None));
        }
        let is_fresh = |g: usize| taken.fresh[g][i] != 0.0;
        let good = taken.error[i] <= 1.0;
        let (length, wait) = (taken.length[i], taken.wait[i]);
        let (now, end) = (self.states[TIME].as_array()[i], self.end.as_array()[i]);
        if let Some(g) = (0..GUARDS).find(|&g| taken.event[i] == g as f64) {
            let others = (0..GUARDS).all(|o| o == g || is_fresh(o) || taken.after[o][i] <= 0.0);
            if good && others && next[TIME] > now && next[TIME] <= end {
                let step = self.step.as_array()[i].max(wait);
                set(&mut self.step, i, step);
                return self.event(i, g, &next);
            }
            set(&mut self.limit, i, 0.5 * wait);
            return None;
        }
        let crossed = (0..GUARDS)
            .map(|g| (g, taken.before[g][i], taken.after[g][i]))
            .filter(|&(g, before, after)| !is_fresh(g) && before < 0.0 && after >= 0.0)
            .map(|(_, before, after)| before / (before - after))
            .fold(f64::INFINITY, f64::min);
        if crossed < f64::INFINITY {
            // Close in on the event, so that it is foreseen.
            set(&mut self.step, i, length);
            set(&mut self.limit, i, length * (0.9 * crossed).max(0.1));
            return None;
        }
        if (0..GUARDS).any(|g| is_fresh(g) && taken.after[g][i] >= 0.0) {
            return Some(Given(None));
        }
        // The valve closes.
        self.move_to(i, &next);
        set(&mut self.states[TIME], i, end);
        set(&mut self.limit, i, f64::INFINITY);
        set(&mut self.end, i, f64::INFINITY);
        let mut step = self.step.as_array()[i];
        if length >= step {
            step = length * dop853::step_factor(taken.error[i]);
        }
        set(&mut self.step, i, step.min(FIRST_STEP));
        self.switch(i, false, 0.0)
    }

    /// The event of guard `g` at the state `next` of lane `i`.
    fn event(&mut self, i: usize, g: usize, next: &[f64; WIDTH]) -> Option<Given> {
        self.move_to(i, next);
        let energized = self.end.as_array()[i] < f64::INFINITY;
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
        let job = self.jobs[i].as_mut()?;
        let p = self
            .chamber
            .pressure(job.flow, self.states[GAS].as_array()[i]);
        let piece = Piece::new(self.chamber, energized, p, side, false);
        job.flow = piece.flow;
        set(
            &mut self.states[GAS],
            i,
            self.chamber.variable(piece.flow, p),
        );
        self.enter(i, piece);
        // With the valve closed the leg may have no force left: that is for the careful one.
        let push = self
            .one
            .leg
            .plain_force(self.chamber, self.states[SPEED].as_array()[i], p)
            .value;
        (push <= 0.0).then_some(Given(None))
    }

    fn end(&self, i: usize, outcome: Outcome) -> Option<LiftOff> {
        let job = self.jobs[i]?;
        let mut y = [0.0; WIDTH];
        for (y, column) in y.iter_mut().zip(&self.states) {
            *y = column.as_array()[i];
        }
        y[GAS] = self.chamber.pressure(job.flow, y[GAS]) / MEGA;
        let outcome = outcome.unless_fallen(y[LEAN]);
        Some(ended(self.one, outcome, job.ready.time_fire, &y))
    }
}

/// A jump that leaves its lane: with its end, or given away.
struct Given(Option<LiftOff>);
