//! A run cut into strides, by its measured columns alone.
//!
//! Leg k leans by the wheel's angle less k − 1 pitches. The height of the axle and that lean say how
//! far a retracted leg is above the ground: a leg has touched down where that is 0.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

use saltus_robot::Robot;

use crate::experiment::{Experiment, Run, Sort};
use crate::fit::Fit;
use crate::noise;
use crate::rig::{Flight, Others, Rig, Start};
use crate::spec::Problem;

/// Most strides that are fitted: more take longer and hardly tell more.
const MOST: usize = 8;
/// Fewest strides from which a cause can be told from a single odd stride.
const LEAST: usize = 4;
/// Time (s) after a touch-down in which its impact is over, and before the next one.
const MARGIN: f64 = 4e-3;
/// Least time (s) of a stride after its command: the valve's delay, and some extension.
const SEEN: f64 = 0.04;
/// Longest stride (s) after its command, and before it.
const LONGEST: f64 = 0.6;
const BEFORE: f64 = 0.3;
/// Longest flight (s) with which a stride begins, and the shortest, of so many rows at least.
const FLIES: f64 = 0.05;
const LEAST_FLIGHT: f64 = 0.01;
const LEAST_ROWS: usize = 3;
/// Time (s) about a firing that says which way the wheel turns.
const AROUND: f64 = 0.01;
/// Least time (s) for which a foot stands before its leg is fired, in a stride that begins on it.
const STANDS: f64 = 0.03;
/// Greatest centripetal acceleration of the axle, in terms of gravity along the leg, at which a foot
/// surely stays on the ground: it leaves at 1.
const STAYS: f64 = 0.8;
/// Height (m) that counts as none, whatever the instruments.
const NEAR: f64 = 2e-3;
/// A leg that is home by the model may be late by this factor.
const LATE: f64 = 1.2;

/// The strides of an experiment.
pub(super) struct Cut {
    /// How many firings there are.
    firings: usize,
    /// Those that can be read as jumps.
    strides: Vec<Stride>,
    /// How many cannot, by reason.
    unfit: BTreeMap<Unfit, usize>,
    /// An experiment of kind jump without runs.
    empty: Experiment,
}

/// A stride within a run.
#[derive(Clone, Copy, Debug)]
struct Window {
    /// Its first and its last row.
    from: usize,
    to: usize,
    /// Wheel angle less lean (rad).
    base: f64,
    /// Where it begins in the air, the last row there.
    air: Option<usize>,
}

/// A stride with its run of kind jump.
#[derive(Clone, Debug)]
pub(super) struct Stride {
    pub(super) run: Run,
    /// Wheel angle less lean (rad).
    pub(super) base: f64,
    /// Where it begins in the air: lean and its rate, pivot (or height) and its rate, rate of the
    /// radius angle (or the travel).
    pub(super) guess: Option<[f64; 5]>,
    /// Its other legs, by what is believed of them.
    pub(super) others: Arc<Others>,
    /// Its unknowns as it is fitted alone.
    pub(super) found: Option<Vec<f64>>,
}

/// Why a stride is no jump.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Unfit {
    Cut,
    Backwards,
    NotHome,
    InTheAir,
    Hops,
    TwoFeet,
    OtherOut,
    Short,
    Misses,
    NoMotion,
    Unlike,
}

impl Unfit {
    fn reason(self) -> &'static str {
        match self {
            Unfit::Cut => "the log begins or ends within it",
            Unfit::Backwards => "the robot rolls backwards",
            Unfit::NotHome => "its leg may not be home again at its touch-down",
            Unfit::InTheAir => "its leg is not seen to stand or to fly as it is fired",
            Unfit::Hops => "it rolls so fast that its foot may not stay on the ground",
            Unfit::TwoFeet => "two feet are down",
            Unfit::OtherOut => "another leg may be out and on the ground",
            Unfit::Short => "the next touch-down comes too soon",
            Unfit::Misses => "its foot does not reach the ground, or hardly",
            Unfit::NoMotion => "the model has no such motion",
            Unfit::Unlike => "it is unlike the others, as if pushed",
        }
    }
}

/// A firing.
#[derive(Clone, Copy, Debug)]
struct Firing {
    leg: usize,
    open: f64,
    shut: f64,
}

/// The strides of `experiment` with what is believed to be `robot`.
///
/// # Errors
/// [`Problem`] where there are too few, or columns do not go together with the robot.
pub(super) fn cut(experiment: &Experiment, robot: &Robot) -> Result<Cut, Problem> {
    let valves = valves(experiment, robot)?;
    let mut cutter = Cutter::new(experiment, robot)?;
    let mut found: Vec<Stride> = Vec::new();
    let mut unfit: BTreeMap<Unfit, usize> = BTreeMap::new();
    let mut all = 0;
    for run in &experiment.runs {
        let track = Track::new(experiment, run, &cutter)?;
        let firings = firings(run, &valves)?;
        let mut drift = 0.0;
        for k in 0..firings.len() {
            all += 1;
            match cutter.stride(&track, &firings, k, &mut drift) {
                Ok(window) => found.push(Stride {
                    run: track.run(run, firings[k], &window),
                    base: window.base,
                    guess: cutter.guess(&track, run, &window),
                    others: Arc::new(cutter.others(&track, &firings, k, &window)),
                    found: None,
                }),
                Err(why) => *unfit.entry(why).or_default() += 1,
            }
        }
    }
    let fit = found.len();
    let empty = cutter.experiment(Vec::new());
    let cut = Cut {
        firings: all,
        strides: evenly(found, 2 * MOST),
        unfit,
        empty,
    };
    cut.enough(fit)?;
    Ok(cut)
}

impl Cut {
    /// The strides that are tried: twice as many as are used, at most.
    pub(super) fn strides(&self) -> &[Stride] {
        &self.strides
    }

    /// Each stride starts from where it is fitted alone.
    pub(super) fn start_from(&mut self, alone: &[Option<Fit>]) {
        for (run, (stride, fit)) in self.strides.iter_mut().zip(alone).enumerate() {
            stride.found = fit.as_ref().map(|fit| fit.unknowns[run].clone());
        }
    }

    /// Takes out the rates that the gyro read about each landing (s, from the first row of its
    /// stride). The rate jumps there: a millisecond, by which heights in counts cannot tell when a
    /// foot comes down, makes of its reading an error of many standard deviations.
    pub(super) fn without_impacts(&mut self, landings: &[Option<f64>]) {
        let column = |name: &String| name == "wheel_rate_rad_s";
        let Some(rate) = self.empty.columns.iter().position(column) else {
            return;
        };
        for (stride, landing) in self.strides.iter_mut().zip(landings) {
            let Run { time, values, .. } = &mut stride.run;
            let Some((landing, first)) = landing.zip(time.first().copied()) else {
                continue;
            };
            for (time, value) in time.iter().zip(&mut values[rate]) {
                if (time - first - landing).abs() < MARGIN {
                    *value = f64::NAN;
                }
            }
        }
    }

    /// The strides as runs of kind jump.
    pub(super) fn experiment(&self) -> Experiment {
        Experiment {
            runs: self
                .strides
                .iter()
                .map(|stride| stride.run.clone())
                .collect(),
            ..self.empty.clone()
        }
    }

    /// Those of the strides that are fit, evenly spaced where they are more than are used; `why` says
    /// of each why it is not.
    ///
    /// # Errors
    /// [`Problem::FewStrides`]
    pub(super) fn fit(mut self, why: &[Option<Unfit>]) -> Result<Cut, Problem> {
        for why in why.iter().flatten() {
            *self.unfit.entry(*why).or_default() += 1;
        }
        let mut whys = why.iter();
        self.strides
            .retain(|_| whys.next().is_some_and(Option::is_none));
        self.strides = evenly(self.strides, MOST);
        let fit = self.strides.len();
        self.enough(fit)?;
        Ok(self)
    }

    fn enough(&self, fit: usize) -> Result<(), Problem> {
        if fit >= LEAST {
            return Ok(());
        }
        Err(Problem::FewStrides {
            firings: self.firings,
            fit,
            least: LEAST,
            reasons: self.left_out(),
        })
    }

    fn left_out(&self) -> String {
        let reason = |(why, count): (&Unfit, &usize)| format!("{count}: {}", why.reason());
        self.unfit.iter().map(reason).collect::<Vec<_>>().join("; ")
    }

    /// How many firings there are, how many are used, and why the others are not.
    pub(super) fn notes(&self) -> Vec<String> {
        let left_out: usize = self.unfit.values().sum();
        let (all, used) = (self.firings, self.strides.len());
        let mut notes = vec![format!(
            "{used} strides of {all} firings are used, evenly chosen of {} that can be read",
            all - left_out
        )];
        if left_out > 0 {
            notes.push(format!("firings left out, {}", self.left_out()));
        }
        notes
    }
}

/// So many of `all` at most, evenly spaced.
fn evenly<T>(all: Vec<T>, most: usize) -> Vec<T> {
    let n = all.len();
    let takes = |i: usize| n <= most || (i + 1) * most / n > i * most / n;
    let numbered = all.into_iter().enumerate();
    numbered
        .filter(|(i, _)| takes(*i))
        .map(|(_, x)| x)
        .collect()
}

/// The columns of the valves, leg by leg.
fn valves(experiment: &Experiment, robot: &Robot) -> Result<Vec<usize>, Problem> {
    let legs = robot.body.legs as usize;
    let of = |leg: usize| {
        let name = format!("valve_{leg}");
        experiment.columns.iter().position(|own| *own == name)
    };
    let refused = |leg: usize, is_missing| Problem::Valves {
        robot: robot.name.clone(),
        legs,
        column: format!("valve_{leg}"),
        is: if is_missing {
            "missing"
        } else {
            "one too many"
        },
    };
    if let Some(leg) = (legs + 1..=12).find(|leg| of(*leg).is_some()) {
        return Err(refused(leg, false));
    }
    (1..=legs)
        .map(|leg| of(leg).ok_or_else(|| refused(leg, true)))
        .collect()
}

/// The firings of a run in the order of time.
fn firings(run: &Run, valves: &[usize]) -> Result<Vec<Firing>, Problem> {
    let mut all = Vec::new();
    for (leg, &column) in valves.iter().enumerate() {
        let mut before: Option<f64> = None;
        let mut open = None;
        for (time, &output) in run.time.iter().zip(&run.values[column]) {
            if output.is_nan() {
                continue;
            }
            if output != 0.0 && output != 1.0 {
                return Err(Problem::Output {
                    run: run.name.clone(),
                    column: format!("valve_{}", leg + 1),
                    value: output,
                    time: *time,
                });
            }
            if output == 1.0 && before == Some(0.0) {
                open = Some(*time);
            }
            if output == 0.0
                && let Some(open) = open.take()
            {
                all.push(Firing {
                    leg,
                    open,
                    shut: *time,
                });
            }
            before = Some(output);
        }
    }
    if all.is_empty() {
        return Err(Problem::NeverFires {
            run: run.name.clone(),
            last: valves.len(),
        });
    }
    all.sort_by(|a, b| a.open.total_cmp(&b.open));
    Ok(all)
}

/// What is measured in a run, row by row where both wheel and height are.
struct Track<'a> {
    experiment: &'a Experiment,
    time: Vec<f64>,
    wheel: Vec<f64>,
    height: Vec<f64>,
}

impl Track<'_> {
    fn new<'a>(
        experiment: &'a Experiment,
        run: &Run,
        cutter: &Cutter<'_>,
    ) -> Result<Track<'a>, Problem> {
        let mut track = Track {
            experiment,
            time: Vec::new(),
            wheel: Vec::new(),
            height: Vec::new(),
        };
        let mut last: Option<(f64, f64)> = None;
        for (row, &time) in run.time.iter().enumerate() {
            let wheel = run.values[cutter.wheel][row];
            if wheel.is_nan() {
                continue;
            }
            // Faster than any wheel turns.
            let most = PI.max(100.0 * last.map_or(0.0, |(before, _)| time - before));
            if let Some((_, before)) = last.filter(|(_, w)| (wheel - w).abs() > most) {
                return Err(Problem::Wraps {
                    run: run.name.clone(),
                    time,
                    before,
                    after: wheel,
                });
            }
            last = Some((time, wheel));
            let height = cutter.height(run.values[cutter.above][row]);
            if height.is_finite() {
                track.time.push(time);
                track.wheel.push(wheel);
                track.height.push(height);
            }
        }
        Ok(track)
    }

    /// The row at `time`, or the next one.
    fn row(&self, time: f64) -> usize {
        self.time.partition_point(|t| *t < time - 1e-9)
    }

    /// The readings of a stride from and to a time (s), as a run of kind jump.
    fn run(&self, run: &Run, firing: Firing, window: &Window) -> Run {
        let (from, to) = (self.time[window.from], self.time[window.to]);
        let rows: Vec<usize> = (0..run.time.len())
            .filter(|&row| (from..=to).contains(&run.time[row]))
            .collect();
        let value = |column: usize| {
            let name = self.experiment.columns[column].as_str();
            let measured = || rows.iter().map(|&row| run.values[column][row]);
            let zero = match name {
                "wheel_angle_rad" => window.base,
                "radius_angle_rad" | "x_m" => measured().find(|x| x.is_finite()).unwrap_or(0.0),
                _ => 0.0,
            };
            measured().map(|x| x - zero).collect()
        };
        Run {
            name: format!(
                "{} leg {} at {:.3} s",
                run.name,
                firing.leg + 1,
                firing.open
            ),
            settings: run.settings.clone(),
            valve: Some((firing.open, Some(firing.shut))),
            time: rows.iter().map(|&row| run.time[row]).collect(),
            values: measured(self.experiment).map(value).collect(),
        }
    }
}

/// The columns that a stride keeps.
fn measured(experiment: &Experiment) -> impl Iterator<Item = usize> + '_ {
    let is_kept = |name: &String| !name.starts_with("valve_");
    (0..experiment.columns.len()).filter(move |k| is_kept(&experiment.columns[*k]))
}

/// A leg that is fired once, as it is believed to move.
#[derive(Clone, Debug)]
struct Out {
    /// How long (s) it is out after its valve shut; infinite where nothing pulls it in.
    after: f64,
    /// Its extension (m) from the command on, a step from each to the next.
    extensions: Vec<f64>,
}

/// Time (s) between extensions, and their number.
const STEP: f64 = 2e-3;
const STEPS: u32 = 300;

/// The state in which a leg is fired.
#[derive(Clone, Copy, Debug)]
struct Fired {
    /// Lean (rad) of the leg, and its rate (rad/s).
    lean: f64,
    rate: f64,
    /// Height (m) of its foot above the ground.
    above: f64,
}

impl Fired {
    /// In whole steps, with the valve's opening time (0.5 ms).
    fn key(&self, firing: Firing) -> [i64; 4] {
        let opening = firing.shut - firing.open;
        // Whole numbers.
        #[allow(clippy::cast_possible_truncation)]
        let whole = |x: f64, step: f64| (x / step).round() as i64;
        [
            whole(self.lean, 0.05),
            whole(self.rate, 0.5),
            whole(self.above, 2e-3),
            whole(opening.max(0.0), 5e-4),
        ]
    }

    /// The start of the motion of `robot`.
    fn start(&self, robot: &Robot) -> Start {
        let foot = robot.foot.radius;
        let height = foot + (robot.body.radius - foot) * self.lean.cos() + self.above;
        let (pivot, turn_rate) = match robot.boom {
            Some(boom) => (
                ((height - robot.body.radius) / boom.length).asin(),
                self.rate * robot.body.radius / boom.length,
            ),
            None => (height, self.rate * robot.body.radius),
        };
        Start::Flying(Flight {
            lean: (self.lean, self.rate),
            pivot: (pivot, 0.0),
            turn_rate,
        })
    }
}

impl Out {
    fn new(robot: &Robot, state: &Fired, opening: f64) -> Out {
        let times = (0..STEPS).map(|n| STEP * f64::from(n));
        let until = STEP * f64::from(STEPS);
        // With gravity it would fall back onto the one foot that there is.
        let mut floats = robot.clone();
        floats.environment.gravity = 0.0;
        let course = Rig::new(&floats).jump(state.start(robot), 0.0, opening, Some(until));
        let extensions: Vec<f64> = course.map_or_else(Vec::new, |course| {
            let mut place = 0;
            times
                .map(|time| course.at(time, &mut place).extension.0)
                .collect()
        });
        let last_out = extensions
            .iter()
            .rposition(|d| *d > 1e-4 * robot.leg.stroke);
        let after = match last_out {
            Some(last) if last + 1 < extensions.len() => {
                LATE * (STEP * last as f64 - opening).max(0.0)
            }
            None if !extensions.is_empty() => 0.0,
            _ => f64::INFINITY,
        };
        Out { after, extensions }
    }
}

/// What is believed of the robot, and what its instruments can tell.
struct Cutter<'a> {
    experiment: &'a Experiment,
    robot: &'a Robot,
    /// The columns of the wheel's angle, and of the pivot or the height.
    wheel: usize,
    above: usize,
    /// Length of the boom (m), where it is the pivot.
    arm: Option<f64>,
    /// Height (m) that counts as none.
    near: f64,
    /// For each state in which a leg is fired how it goes out and comes home.
    out: BTreeMap<[i64; 4], Out>,
}

impl<'a> Cutter<'a> {
    fn new(experiment: &'a Experiment, robot: &'a Robot) -> Result<Cutter<'a>, Problem> {
        let column = |name: &str| experiment.columns.iter().position(|own| own == name);
        let none = || Problem::NoHeight;
        let wheel = column("wheel_angle_rad").ok_or_else(none)?;
        let pivot = column("pivot_angle_rad");
        if let (Some(_), None) = (pivot, robot.boom) {
            return Err(Problem::NoBoom {
                robot: robot.name.clone(),
                column: "pivot_angle_rad".into(),
            });
        }
        let above = pivot.or(column("y_m")).ok_or_else(none)?;
        let arm = robot
            .boom
            .filter(|_| pivot.is_some())
            .map(|boom| boom.length);
        let noise = noise::channels(experiment, &[above])[0].noise * arm.unwrap_or(1.0);
        Ok(Cutter {
            experiment,
            robot,
            wheel,
            above,
            arm,
            near: NEAR + 2.0 * noise,
            out: BTreeMap::new(),
        })
    }

    /// The strides of all runs as an experiment of kind jump.
    fn experiment(&self, runs: Vec<Run>) -> Experiment {
        let own = self.experiment;
        let of = |all: &[Option<f64>]| measured(own).map(|k| all[k]).collect();
        Experiment {
            kind: Sort::Jump,
            columns: measured(own).map(|k| own.columns[k].clone()).collect(),
            noise: of(&own.noise),
            resolution: of(&own.resolution),
            runs,
        }
    }

    /// Height (m) of the axle.
    fn height(&self, measured: f64) -> f64 {
        match self.arm {
            Some(arm) => self.robot.body.radius + arm * measured.sin(),
            None => measured,
        }
    }

    fn pitch(&self) -> f64 {
        TAU / f64::from(self.robot.body.legs)
    }

    /// Lean (rad) of `leg` in a row, within half a turn.
    fn lean(&self, track: &Track<'_>, row: usize, leg: usize) -> f64 {
        let lean = track.wheel[row] - leg as f64 * self.pitch();
        lean - TAU * (lean / TAU).round()
    }

    /// Height (m) of the foot of `leg` above the ground in a row, the leg out by `d` (m).
    fn clearance(&self, track: &Track<'_>, row: usize, leg: usize, d: f64) -> f64 {
        let foot = self.robot.foot.radius;
        let length = self.robot.body.radius - foot + d;
        track.height[row] - length * self.lean(track, row, leg).cos() - foot
    }

    /// How the leg of `firing` moves: as it is believed to from the state that the robot has as its
    /// valve opens. The faster the wheel turns, the later a leg comes home; the spin may hold it out.
    fn out(&mut self, track: &Track<'_>, firing: Firing) -> &Out {
        let state = self.state(track, firing);
        let key = state.key(firing);
        let robot = self.robot;
        self.out
            .entry(key)
            .or_insert_with(|| Out::new(robot, &state, firing.shut - firing.open))
    }

    /// The state (rounded) in which a leg is fired.
    fn state(&self, track: &Track<'_>, firing: Firing) -> Fired {
        let at = track.row(firing.open).min(track.time.len() - 1);
        let early = track.row(firing.open - AROUND);
        let late = track.row(firing.open + AROUND).min(track.time.len() - 1);
        let over = (track.time[late] - track.time[early]).max(1e-9);
        let slope = |column: &[f64]| (column[late] - column[early]) / over;
        let round = |x: f64, step: f64| (x / step).round() * step;
        let lean = self.lean(track, at, firing.leg);
        let lowest =
            self.robot.foot.radius + (self.robot.body.radius - self.robot.foot.radius) * lean.cos();
        Fired {
            lean: round(lean, 0.05),
            rate: round(slope(&track.wheel), 0.5),
            above: round((track.height[at] - lowest).clamp(0.0, 0.5), 2e-3),
        }
    }

    /// What the legs but that of firing `k` add to the wheel's moment of inertia in a stride.
    fn others(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        k: usize,
        window: &Window,
    ) -> Others {
        let (start, end) = (track.time[window.from], track.time[window.to]);
        let body = self.robot.leg.body;
        let mut inertia = Vec::new();
        let mut time = start;
        while time < end + STEP {
            let mut latest: BTreeMap<usize, Firing> = BTreeMap::new();
            let earlier = firings
                .iter()
                .filter(|f| f.open <= time && f.leg != firings[k].leg);
            latest.extend(earlier.map(|f| (f.leg, *f)));
            let mut sum = 0.0;
            for firing in latest.values() {
                let out = &self.out(track, *firing).extensions;
                // An index.
                #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
                let place = ((time - firing.open) / STEP) as usize;
                let d = out.get(place).or(out.last()).copied().unwrap_or(0.0);
                sum += body.mass * ((body.center + d).powi(2) - body.center.powi(2));
            }
            inertia.push(sum);
            time += STEP;
        }
        Others {
            step: STEP,
            inertia,
        }
    }

    /// How far (m) each leg may be out at `time`.
    fn extensions(&mut self, track: &Track<'_>, firings: &[Firing], time: f64) -> Vec<f64> {
        let mut all = vec![0.0; self.robot.body.legs as usize];
        for firing in firings.iter().filter(|f| f.open <= time) {
            let is_out = time < firing.shut + self.out(track, *firing).after;
            if is_out {
                all[firing.leg] = self.robot.leg.stroke;
            }
        }
        all
    }

    /// The stride of firing `k`. `drift` is the lean at which legs fire, as the wheel's encoder has
    /// it: it may drift by more than half a turn where its scale is wrong.
    fn stride(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        k: usize,
        drift: &mut f64,
    ) -> Result<Window, Unfit> {
        let firing = firings[k];
        let at = track.row(firing.open);
        let (early, late) = (
            track.row(firing.open - AROUND),
            track.row(firing.open + AROUND),
        );
        if early == 0 || late + 1 >= track.time.len() {
            return Err(Unfit::Cut);
        }
        let leg = firing.leg;
        let turned = track.wheel[at] - leg as f64 * self.pitch() - *drift;
        let base = leg as f64 * self.pitch() + TAU * (turned / TAU).round();
        *drift = track.wheel[at] - base;
        if track.wheel[late] <= track.wheel[early] {
            return Err(Unfit::Backwards);
        }
        if self.extensions(track, &firings[..k], firing.open)[leg] > 0.0 {
            return Err(Unfit::NotHome);
        }
        let clear = self.clear(track, &firings[..k], leg, (at, firing))?;
        let (from, air) = self.begin(track, leg, clear, (at, firing))?;
        let to = self.end(track, firings, leg, (at, firing))?;
        Ok(Window {
            from,
            to,
            base,
            air,
        })
    }

    /// The first row before the firing from which on no other foot can be on the ground, and the leg
    /// itself is home.
    fn clear(
        &mut self,
        track: &Track<'_>,
        before: &[Firing],
        leg: usize,
        (at, firing): (usize, Firing),
    ) -> Result<usize, Unfit> {
        let mut first = at;
        if let Some(why) = self.other(track, before, leg, at) {
            return Err(why);
        }
        while first > 0 && track.time[first - 1] > firing.open - BEFORE {
            let row = first - 1;
            let is_home = self.extensions(track, before, track.time[row])[leg] == 0.0;
            if !is_home || self.other(track, before, leg, row).is_some() {
                return Ok(track.row(track.time[first] + MARGIN).min(at));
            }
            first = row;
        }
        if first == 0 {
            Err(Unfit::Cut)
        } else {
            Ok(first)
        }
    }

    /// The row in which a stride begins, and the row up to which the robot is in the air where it
    /// begins there; else it stands.
    fn begin(
        &self,
        track: &Track<'_>,
        leg: usize,
        clear: usize,
        (at, firing): (usize, Firing),
    ) -> Result<(usize, Option<usize>), Unfit> {
        let above = |row: usize| self.clearance(track, row, leg, 0.0);
        let flies = |row: usize| above(row) > self.near;
        // The last row in the air before the leg comes down, or before it moves.
        let mut last = at;
        while last > clear && !flies(last) {
            last -= 1;
        }
        let mut first = last;
        while first > clear && flies(first - 1) && track.time[last] - track.time[first] < FLIES {
            first -= 1;
        }
        let is_long = |first: usize| {
            last >= first + LEAST_ROWS && track.time[last] - track.time[first] > LEAST_FLIGHT
        };
        if flies(last) && is_long(first) {
            // Not just after it has left the ground.
            let left = first > clear && !flies(first - 1);
            let first = if left {
                track.row(track.time[first] + MARGIN)
            } else {
                first
            };
            if is_long(first) {
                return Ok((first, Some(last)));
            }
        }
        if flies(at) {
            return Err(Unfit::InTheAir);
        }
        let (touch, down) = if flies(last) {
            let first = last + 1;
            let crossing = self.crossing(track, leg, first);
            (first, crossing.unwrap_or(track.time[first]) + MARGIN)
        } else {
            (clear, track.time[clear])
        };
        let row = track.row(down).max(touch);
        if above(row.min(at)).abs() > self.near || self.lean(track, at, leg).abs() > 1.2 {
            return Err(Unfit::InTheAir);
        }
        if track.time[row] > firing.open - STANDS {
            return Err(Unfit::InTheAir);
        }
        if !self.stays(track, leg, row) {
            return Err(Unfit::Hops);
        }
        Ok((row, None))
    }

    /// Whether the foot of `leg` stays on the ground as the axle rolls over it from a row on: whether
    /// gravity holds the axle on its circle.
    fn stays(&self, track: &Track<'_>, leg: usize, row: usize) -> bool {
        let later = track.row(track.time[row] + STANDS).min(track.time.len() - 1);
        let rate = (track.wheel[later] - track.wheel[row]) / (track.time[later] - track.time[row]);
        let held = self.robot.axle_gravity() * self.lean(track, row, leg).cos();
        rate.powi(2) * self.robot.body.radius < STAYS * held
    }

    /// What a window that begins in the air is guessed to begin with: lean and its rate, pivot (or
    /// height) and its rate, rate of the radius angle (or the travel).
    fn guess(&self, track: &Track<'_>, run: &Run, window: &Window) -> Option<[f64; 5]> {
        let last = window.air?;
        let start = track.time[window.from];
        let times = start..=track.time[last];
        let column = |name: &str| {
            let k = self.experiment.columns.iter().position(|own| own == name)?;
            let rows = run.time.iter().zip(&run.values[k]);
            let all: Vec<(f64, f64)> = rows
                .filter(|(t, x)| times.contains(*t) && x.is_finite())
                .map(|(t, x)| (t - start, *x))
                .collect();
            Some(all)
        };
        let line = |points: &[(f64, f64)]| saltus_numeric::statistics::line(points);
        let (rate, wheel) = line(&column("wheel_angle_rad")?)?;
        let name = self.experiment.columns[self.above].as_str();
        // Without the fall, it is a line.
        let fall = 0.5 * self.robot.axle_gravity() / self.arm.unwrap_or(1.0);
        let mut pivot = column(name)?;
        pivot.iter_mut().for_each(|(t, x)| *x += fall * *t * *t);
        let (climb, above) = line(&pivot)?;
        let reach = self.robot.boom.map_or(1.0, |boom| boom.length);
        let turn = column("radius_angle_rad").or_else(|| column("x_m"));
        let turn = turn.and_then(|points| Some(line(&points)?.0));
        let turn = turn.unwrap_or(rate * self.robot.body.radius / reach);
        Some([wheel - window.base, rate, above, climb, turn])
    }

    /// When (s) a leg that comes down, and is near the ground from row `first` on, is there: where
    /// a line through its last heights comes to 0.
    fn crossing(&self, track: &Track<'_>, leg: usize, first: usize) -> Option<f64> {
        let above: Vec<(f64, f64)> = (0..first)
            .rev()
            .map(|row| (track.time[row], self.clearance(track, row, leg, 0.0)))
            .take_while(|(_, height)| *height > 0.0 && *height < 10.0 * self.near)
            .take(40)
            .collect();
        if above.len() < 3 {
            return None;
        }
        let (slope, level) = saltus_numeric::statistics::line(&above)?;
        let crossing = -level / slope;
        let late = crossing - track.time[first];
        (slope < 0.0 && (-0.01..0.03).contains(&late)).then_some(crossing)
    }

    /// Why a leg other than `leg` may be on the ground in a row.
    fn other(
        &mut self,
        track: &Track<'_>,
        before: &[Firing],
        leg: usize,
        row: usize,
    ) -> Option<Unfit> {
        let extensions = self.extensions(track, before, track.time[row]);
        let legs = 0..extensions.len();
        let mut others = legs.filter(|other| *other != leg);
        let touches = |other: usize, d: f64| {
            self.lean(track, row, other).abs() < 0.5 * PI
                && self.clearance(track, row, other, d) < self.near
        };
        others.find_map(|other| {
            if touches(other, 0.0) {
                Some(Unfit::TwoFeet)
            } else if extensions[other] > 0.0 && touches(other, extensions[other]) {
                Some(Unfit::OtherOut)
            } else {
                None
            }
        })
    }

    /// The last row before another foot comes down.
    fn end(
        &mut self,
        track: &Track<'_>,
        firings: &[Firing],
        leg: usize,
        (at, firing): (usize, Firing),
    ) -> Result<usize, Unfit> {
        let again = firings
            .iter()
            .find(|f| f.leg == leg && f.open > firing.open);
        let latest = again
            .map_or(f64::INFINITY, |f| f.open)
            .min(firing.open + LONGEST);
        let mut end = at;
        loop {
            end += 1;
            if end >= track.time.len() {
                return Err(Unfit::Cut);
            }
            let falls = self.clearance(track, end, leg, 0.0) < -2.0 * self.near;
            if track.time[end] >= latest || falls || self.other(track, firings, leg, end).is_some()
            {
                break;
            }
        }
        let last = track.row(track.time[end] - MARGIN);
        if track.time[last] < firing.open + SEEN {
            return Err(Unfit::Short);
        }
        // A leg that pushes in the air tells little of what drives it.
        let stroke = self.robot.leg.stroke;
        let moves = track.row(firing.open + self.robot.leg.delay);
        let deepest = (moves..=last).map(|row| self.clearance(track, row, leg, stroke));
        if deepest.fold(f64::INFINITY, f64::min) > -self.near {
            return Err(Unfit::Misses);
        }
        Ok(last)
    }
}
