//! A box ahead that a range sensor sees while the robot runs: a table of what each leg does, made by
//! dynamic programming over strides that were simulated before.

use std::f64::consts::TAU;

use rand_distr::{Distribution, Uniform};
use rand_pcg::Pcg64;
use saltus_controller::Axis;
use saltus_controller::run::{Ahead, Stall};
use saltus_numeric::parallel;
use saltus_robot::Robot;

use crate::drawn::{Draw, drawn_robot};
use crate::error::require;
use crate::run::{Footfall, Obstacle, Row, Run, Setup, run};
use crate::{GaitError, Program, Smooth};

/// What a leg does: it fires at a lean (rad), its valve opens for a time (s). With a time of 0 it does
/// not fire.
pub type Choice = [f64; 2];

/// What each leg does before a box, by the rate at which it enters the zone, the height of the axle
/// and the distance from the axle to the box then.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Way (m) for a count of the radius encoder.
    pub way: f64,
    /// Height (m) for a count of the pivot encoder.
    pub climb: f64,
    /// Index of the choice in each cell, all distances of a height one after the other, all heights
    /// of a rate.
    pub cells: Vec<u8>,
    /// Distance (m) below which the box is behind.
    pub behind: f64,
    /// Least distance (m) to run up.
    pub room: f64,
}

/// Firing angles (rad) and valve opening times (s) of legs that drive the robot.
const ANGLES: [f64; 6] = [-0.4, -0.1, 0.1, 0.2, 0.3, 0.45];
const TIMES: [f64; 3] = [0.025, 0.042, 0.06];
/// Firing angles (rad) of a jump, and its valve opening time (s): past the end of the stroke.
const LEAP_ANGLES: [f64; 7] = [-0.5, -0.42, -0.34, -0.26, -0.18, -0.1, 0.05];
const LEAP_OPEN: f64 = 0.1;
/// The first choice: the leg does not fire.
const IDLE: Choice = [0.6, 0.0];

/// All that a leg can do, jumps last.
const fn choices() -> [Choice; CHOICES] {
    let mut all = [IDLE; CHOICES];
    let mut k = 0;
    while k < ANGLES.len() * TIMES.len() {
        all[1 + k] = [ANGLES[k / TIMES.len()], TIMES[k % TIMES.len()]];
        k += 1;
    }
    let mut k = 0;
    while k < LEAP_ANGLES.len() {
        all[FIRST_LEAP + k] = [LEAP_ANGLES[k], LEAP_OPEN];
        k += 1;
    }
    all
}
const FIRST_LEAP: usize = 1 + ANGLES.len() * TIMES.len();
const CHOICES: usize = FIRST_LEAP + LEAP_ANGLES.len();
static ALL: [Choice; CHOICES] = choices();

/// Where the active zone begins (rad): a jump's leg fires well before it is upright.
const ZONE: f64 = -0.5;
/// Cells of the rate: from the first rate, so wide (rad/s), so many.
const RATES: (f64, f64, usize) = (-0.5, 1.0, 17);
/// Cells of the axle's height above that of a robot that stands: so wide (m), so many.
const HEIGHTS: (f64, usize) = (0.02, 5);
/// Cells of both.
const ROWS: usize = RATES.2 * HEIGHTS.1;
/// Width of a cell of the distance (m), and the farthest distance.
const WIDTH: f64 = 0.025;
const FARTHEST: f64 = 3.2;
/// Nearest distance (m) at which a leg may still fire.
const NEAREST: f64 = 0.2;
/// Way (m) beyond a box after which it is behind.
const BEYOND: f64 = 0.3;
/// Cells of the distances that count for a stride.
const COUNTED: usize = 120;
/// Cells of a profile (m), and the first, from where the leg enters the zone.
const FINE: f64 = 0.01;
const FROM: f64 = -0.3;
const PROFILE: usize = 230;

impl Table {
    fn distances(behind: f64) -> (f64, usize) {
        let cells = counted(((FARTHEST - behind) / WIDTH).ceil());
        (FARTHEST - cells as f64 * WIDTH, cells)
    }

    /// The controller's constants.
    pub fn ahead(&self) -> Ahead<'_, f64> {
        let (first, columns) = Table::distances(self.behind);
        let (slowest, wide, rows) = RATES;
        Ahead {
            way: self.way,
            climb: self.climb,
            least_weight: 0.05,
            same: 0.3,
            room: self.room,
            rates: Axis::new(slowest, slowest + wide * rows as f64, rows + 1),
            heights: Axis::new(0.0, HEIGHTS.0 * HEIGHTS.1 as f64, HEIGHTS.1 + 1),
            distances: Axis::new(first, FARTHEST, columns + 1),
            cells: &self.cells,
            choices: &ALL,
            first_leap: small(FIRST_LEAP),
        }
    }
}

#[allow(clippy::cast_possible_truncation)]
fn small(x: usize) -> u8 {
    x as u8
}

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
fn counted(x: f64) -> usize {
    x.round().max(0.0) as usize
}

/// Boxes at any distance, for one robot and those drawn around it.
#[derive(Clone, Debug)]
pub struct Sensed {
    /// The robot.
    pub robot: Robot,
    /// How others are drawn.
    pub draw: Draw,
    /// Height of the box (m).
    pub height: f64,
    /// Its length (m).
    pub length: f64,
    /// Least and greatest distance (m) of its front from the axle at rest.
    pub fronts: [f64; 2],
    /// Least distance (m) to run up: nearer than this, a robot first backs off.
    pub room: f64,
    /// The law that runs before the box is near and after it is behind.
    pub law: Smooth,
    /// Runs from which strides are learned, for each round.
    pub runs: usize,
    /// Rounds: the first has random firings, the others those of the table so far, with errors.
    pub rounds: usize,
    /// Seed of the robots, the firings and the boxes of these runs.
    pub seed: u64,
}

/// A stride: from one leg's entry into the zone to the next one's, or to the landing of a jump.
#[derive(Clone, Debug)]
struct Stride {
    /// Cell of rate and height.
    row: usize,
    choice: usize,
    /// For each distance: height (m) of the highest box that it clears.
    clears: Vec<f32>,
    /// Way (m) and rate of the next stride; none after a jump and where the run ends.
    next: Option<(f64, usize)>,
    /// Whether the robot then stood still.
    stalls: bool,
}

/// The cell of a rate (rad/s) and a height (m) above the stand.
fn row_of(rate: f64, height: f64) -> usize {
    let (first, wide, rows) = RATES;
    let row = counted(((rate - first) / wide).floor()).min(rows - 1);
    let level = counted((height / HEIGHTS.0).floor()).min(HEIGHTS.1 - 1);
    row * HEIGHTS.1 + level
}

/// Least height (m) of the robot over the places that it passes, from the entry of a leg on.
#[derive(Clone, Debug)]
struct Profile {
    from: f64,
    least: Vec<f64>,
}

impl Profile {
    fn new(travel: f64) -> Profile {
        Profile {
            from: travel + FROM,
            least: vec![f64::INFINITY; PROFILE],
        }
    }

    /// Lowers it by a bar from `a` to `b` of radius `radius` (m).
    fn lower(&mut self, a: [f64; 2], b: [f64; 2], radius: f64) {
        let (a, b) = if a[0] < b[0] { (a, b) } else { (b, a) };
        let low = counted(((a[0] - radius - self.from) / FINE).floor());
        let high = counted(((b[0] + radius - self.from) / FINE).ceil());
        for k in low..=high.min(PROFILE - 1) {
            let x = self.from + k as f64 * FINE;
            let part = ((x - a[0]) / (b[0] - a[0]).max(1e-9)).clamp(0.0, 1.0);
            let z = a[1] + part * (b[1] - a[1]) - radius;
            self.least[k] = self.least[k].min(z);
        }
    }

    /// For each distance, the height of the highest box of `length` (m) that is cleared by a robot
    /// that gets as far as `reach` (m) from where the leg entered.
    fn clears(&self, length: f64, reach: Option<f64>) -> Vec<f32> {
        let cell = |k: usize| {
            let distance = NEAREST + k as f64 * WIDTH;
            if reach.is_some_and(|reach| distance + WIDTH + length + 0.25 > reach) {
                return 0.0;
            }
            let from = counted(((distance - FROM) / FINE).floor());
            let to = counted(((distance + WIDTH + length - FROM) / FINE).ceil());
            let heights = (from..=to).map(|i| self.least.get(i).copied().unwrap_or(9.0));
            #[allow(clippy::cast_possible_truncation)]
            let least = heights.fold(9.0, f64::min) as f32;
            least
        };
        (0..COUNTED).map(cell).collect()
    }
}

/// What a run shows of strides.
struct Watch<'r> {
    robot: &'r Robot,
    length: f64,
    leg: Option<u32>,
    /// Entry: cell of rate and height, travel, what the leg has done.
    entry: (usize, f64, usize),
    /// Count of the pivot encoder at the start.
    stands_at: Option<i32>,
    /// Height (m) for a count of it.
    climb: f64,
    profile: Profile,
    strides: Vec<Stride>,
    /// When a jump was fired.
    leapt: Option<f64>,
    done: bool,
    stalled: bool,
    last: f64,
}

/// Time (s) after the firing of a jump for which it is watched.
const WATCHED: f64 = 1.0;

impl<'r> Watch<'r> {
    fn new(robot: &'r Robot, length: f64, climb: f64) -> Watch<'r> {
        Watch {
            robot,
            length,
            leg: None,
            entry: (0, 0.0, 0),
            stands_at: None,
            climb,
            profile: Profile::new(0.0),
            strides: Vec::new(),
            leapt: None,
            done: false,
            stalled: false,
            last: 0.0,
        }
    }

    fn finish_stride(&mut self, next: Option<(usize, f64)>) {
        let (row, travel, choice) = self.entry;
        let is_leap = choice >= FIRST_LEAP;
        let reach = is_leap.then_some(self.last - travel);
        self.strides.push(Stride {
            row,
            choice,
            clears: self.profile.clears(self.length, reach),
            next: next.map(|(row, at)| (at - travel, row)),
            stalls: self.stalled,
        });
    }
}

/// The legs, rods and struts of a robot in a cycle: ends and radius (m).
fn bars(robot: &Robot, row: &Row<'_>, mut take: impl FnMut([f64; 2], [f64; 2], f64)) {
    let legs = robot.body.legs as usize;
    let tip = robot.body.radius - robot.foot.radius;
    let from = robot.body.radius - robot.leg.body.length;
    let place = |leg: usize, out: f64| {
        let lean = row.lean - TAU * leg as f64 / legs as f64;
        [
            row.axle[0] - out * lean.sin(),
            row.axle[1] - out * lean.cos(),
        ]
    };
    for leg in 0..legs {
        let extension = row.extensions[leg];
        take(
            place(leg, from + extension),
            place(leg, tip + extension),
            robot.foot.radius.max(robot.leg.body.radius),
        );
        if let Some(struts) = &robot.struts {
            let next = (leg + 1) % legs;
            take(
                place(leg, struts.distance),
                place(next, struts.distance),
                struts.radius,
            );
        }
    }
}

impl Run for Watch<'_> {
    fn row(&mut self, row: &Row<'_>) {
        let (action, travel) = (&row.action, row.axle[0]);
        self.last = travel;
        if self.leapt.is_none() && self.leg != Some(action.in_zone) {
            let pivot = row.readings.pivot;
            let stands_at = *self.stands_at.get_or_insert(pivot);
            let cell = row_of(action.rate, f64::from(pivot - stands_at) * self.climb);
            if self.leg.is_some() {
                self.finish_stride(Some((cell, travel)));
            }
            self.leg = Some(action.in_zone);
            self.entry = (cell, travel, 0);
            self.profile = Profile::new(travel);
        }
        if action.leg.is_some() && self.leapt.is_none() {
            let fired = [action.firing_angle, action.valve_open];
            let choice = ALL.iter().position(|choice| *choice == fired);
            self.entry.2 = choice.unwrap_or(CHOICES);
            if (FIRST_LEAP..CHOICES).contains(&self.entry.2) {
                self.leapt = Some(row.time);
            }
        }
        let profile = &mut self.profile;
        bars(self.robot, row, |a, b, radius| profile.lower(a, b, radius));
        self.stalled = action.stalled;
        let over = self.entry.1 + 1.9;
        self.done = self
            .leapt
            .is_some_and(|at| row.time > at + WATCHED || travel > over)
            || action.stalled;
    }

    fn footfall(&mut self, _: &Footfall) {}

    fn goes_on(&mut self) -> bool {
        !self.done
    }
}

impl Sensed {
    fn setup(&self, robot: Robot, seed: u64, seconds: f64) -> Setup {
        Setup {
            seed,
            zone: ZONE,
            stall: Stall {
                rate: 0.5,
                time: 0.5,
                restarts: true,
            },
            ..Setup::new(robot, self.law.program(), seconds)
        }
    }

    /// Random firings: angles that fall from one that starts to one that runs, and a jump.
    fn random(&self, robot: Robot, seed: u64, random: &mut Pcg64) -> Setup {
        let mut between = |from: f64, to: f64| {
            Uniform::new(from, to).map_or(from, |uniform| uniform.sample(random))
        };
        let count = counted(between(0.5, 11.5));
        let (begin, end) = (between(0.1, 0.65), between(-0.45, 0.45));
        let (open, pace) = (between(0.0, 3.0), between(0.5, 4.0));
        let mut first: Vec<Choice> = (0..count)
            .map(|k| {
                let middle = end + (begin - end) * (-(k as f64) / pace).exp();
                let wanted = middle + between(-0.15, 0.15);
                let angle = ANGLES
                    .iter()
                    .copied()
                    .min_by(|a, b| (a - wanted).abs().total_cmp(&(b - wanted).abs()));
                let time = counted((open + between(-1.0, 1.0)).clamp(0.0, 2.49).floor());
                [angle.unwrap_or(0.0), TIMES[time]]
            })
            .collect();
        let leap = counted(between(0.0, LEAP_ANGLES.len() as f64 - 1e-9).floor());
        first.push([LEAP_ANGLES[leap], LEAP_OPEN]);
        Setup {
            first,
            program: Program::Fixed { firing_angle: 0.6 },
            valve_open: 0.0,
            ..self.setup(robot, seed, 6.0)
        }
    }

    /// Firings by `table`, some of whose cells err.
    fn erring(
        &self,
        table: &Table,
        robot: Robot,
        seed: u64,
        front: f64,
        random: &mut Pcg64,
    ) -> Setup {
        let mut table = table.clone();
        let Ok(uniform) = Uniform::new(0.0, 1.0) else {
            return self.setup(robot, seed, 1.0);
        };
        for cell in &mut table.cells {
            let (errs, leaps, which): (f64, f64, f64) = (
                uniform.sample(random),
                uniform.sample(random),
                uniform.sample(random),
            );
            if errs < 0.15 {
                *cell = if leaps < 0.6 {
                    small(FIRST_LEAP + counted((which * LEAP_ANGLES.len() as f64).floor()))
                } else {
                    small(1 + counted((which * (FIRST_LEAP - 1) as f64).floor()))
                };
            }
        }
        Setup {
            ahead: Some(table),
            obstacles: vec![self.box_at(front)],
            solid: false,
            ..self.setup(robot, seed, 10.0)
        }
    }

    fn box_at(&self, front: f64) -> Obstacle {
        Obstacle {
            front,
            length: self.length,
            height: self.height,
        }
    }

    fn front(&self, random: &mut Pcg64) -> f64 {
        let [from, to] = self.fronts;
        Uniform::new_inclusive(from, to).map_or(from, |uniform| uniform.sample(random))
    }

    /// Way and height (m) for a count of the encoders of the boom.
    fn per_count(&self) -> [f64; 2] {
        let length = self.robot.boom.map_or(0.0, |boom| boom.length);
        let sensors = self.robot.sensors.unwrap_or_default();
        [sensors.radius_counts, sensors.pivot_counts].map(|counts| length * TAU / counts.round())
    }

    /// Strides of `runs` runs: of random firings, or of those of a table with errors.
    fn strides(
        &self,
        table: Option<&Table>,
        round: usize,
        threads: usize,
    ) -> Result<Vec<Stride>, GaitError> {
        let one = |k: usize| {
            let k = round * self.runs + k;
            let seed = self.seed.wrapping_add(k as u64);
            let robot = drawn_robot(&self.robot, &self.draw, self.seed, k)?;
            let mut random = Pcg64::new(u128::from(seed), 0xb0c5);
            let setup = match table {
                None => self.random(robot.clone(), seed, &mut random),
                Some(table) => {
                    let front = self.front(&mut random).max(self.room);
                    self.erring(table, robot.clone(), seed, front, &mut random)
                }
            };
            let mut watch = Watch::new(&robot, self.length, self.per_count()[1]);
            // A motion that the simulation cannot follow to its end teaches what it showed until then.
            match run(&setup, &mut watch) {
                Ok(_) => watch.finish_stride(None),
                Err(GaitError::Sim(_)) => {}
                Err(error) => return Err(error),
            }
            Ok(watch.strides)
        };
        let all: Result<Vec<Vec<Stride>>, GaitError> =
            parallel::map_on(threads, self.runs, one).into_iter().collect();
        Ok(all?.into_iter().flatten().collect())
    }

    /// The table; `told` hears of each round's strides and of the share that it expects to clear.
    ///
    /// # Errors
    /// [`GaitError`] for a box or a robot that cannot be.
    pub fn plan(
        &self,
        threads: usize,
        mut told: impl FnMut(usize, f64),
    ) -> Result<Table, GaitError> {
        let length = self.robot.boom.map_or(0.0, |boom| boom.length);
        require(
            length > 0.0,
            "length of the boom (m)",
            length,
            "that of a boom, whose turn measures the way",
        )?;
        let mut strides = Vec::new();
        let mut table: Option<Table> = None;
        for round in 0..self.rounds.max(1) {
            strides.extend(self.strides(table.as_ref(), round, threads)?);
            let (made, share) = self.solve(&strides);
            told(strides.len(), share);
            table = Some(made);
        }
        table.ok_or(GaitError::Input {
            name: "rounds".into(),
            value: 0.0,
            allowed: "at least 1".into(),
        })
    }

    /// Dynamic programming over the strides: the choice of the greatest share that clears the box.
    fn solve(&self, strides: &[Stride]) -> (Table, f64) {
        let rows = ROWS;
        let mut value = vec![0.0; rows * COUNTED];
        let mut best = vec![0_usize; rows * COUNTED];
        for _ in 0..SWEEPS {
            let mut sums = vec![[0.0, 0.0]; rows * CHOICES * COUNTED];
            for stride in strides.iter().filter(|stride| stride.choice < CHOICES) {
                self.add(stride, &value, &mut sums);
            }
            for row in 0..rows {
                for d in 0..COUNTED {
                    let worth = |choice: usize| {
                        let [sum, count] = sums[(row * CHOICES + choice) * COUNTED + d];
                        sum / (count + DOUBT)
                    };
                    let mut most = (0, 0.0);
                    for choice in 0..CHOICES {
                        if worth(choice) > most.1 + 1e-9 {
                            most = (choice, worth(choice));
                        }
                    }
                    (best[row * COUNTED + d], value[row * COUNTED + d]) = most;
                }
            }
        }
        let behind = -(self.length + BEYOND);
        let (first, columns) = Table::distances(behind);
        let mut cells = vec![0; rows * columns];
        let shift = counted((NEAREST - first) / WIDTH);
        for row in 0..rows {
            for d in 0..COUNTED.min(columns - shift) {
                cells[row * columns + shift + d] = small(best[row * COUNTED + d]);
            }
        }
        let from_rest = &value[..COUNTED];
        let share = from_rest[32..].iter().sum::<f64>() / (COUNTED - 32) as f64;
        let [way, climb] = self.per_count();
        let table = Table {
            way,
            climb,
            cells,
            behind,
            room: self.room,
        };
        (table, share)
    }

    /// Adds what a stride comes to from each distance.
    fn add(&self, stride: &Stride, value: &[f64], sums: &mut [[f64; 2]]) {
        for (d, clears) in stride.clears.iter().enumerate() {
            let is_leap = stride.choice >= FIRST_LEAP;
            let worth = if f64::from(*clears) < self.height + MARGIN {
                0.0
            } else if is_leap {
                1.0
            } else if stride.stalls {
                0.0
            } else {
                let Some((way, rate)) = stride.next else {
                    continue;
                };
                let cell = d as f64 - way / WIDTH;
                if cell < -0.5 {
                    0.0
                } else {
                    KEPT * value[rate * COUNTED + counted(cell).min(COUNTED - 1)]
                }
            };
            let levels = HEIGHTS.1.cast_signed();
            for (by, weight) in [(0, 1.0), (levels, BESIDE), (-levels, BESIDE)] {
                let Some(row) = stride.row.checked_add_signed(by) else {
                    continue;
                };
                if row < ROWS {
                    let sum = &mut sums[(row * CHOICES + stride.choice) * COUNTED + d];
                    sum[0] += weight * worth;
                    sum[1] += weight;
                }
            }
        }
    }
}

/// Sweeps over all states; a run has fewer strides.
const SWEEPS: usize = 40;
/// What a choice that was never tried counts as: so many failures.
const DOUBT: f64 = 1.0;
/// Weight of strides of the next cells of the rate.
const BESIDE: f64 = 0.2;
/// By how much (m) a box must be cleared.
const MARGIN: f64 = 0.008;
/// Worth of the same a stride later.
const KEPT: f64 = 0.998;

/// How a robot fared before a sensed box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Faced {
    /// Front of its box (m).
    pub front: f64,
    /// Whether it came to the other side without touching the box.
    pub cleared: bool,
    /// Least distance (m) to the box.
    pub clearance: f64,
    /// Mean speed (m/s) from 2 to 3 s after the box was behind.
    pub speed_after: f64,
    /// When the box was behind (s).
    pub passed: Option<f64>,
}

impl Faced {
    /// A motion that the simulation cannot follow: not cleared.
    fn lost(front: f64) -> Faced {
        Faced {
            front,
            cleared: false,
            clearance: f64::NAN,
            speed_after: 0.0,
            passed: None,
        }
    }
}

/// Follows a robot until so long (s) after its box is behind.
struct Beyond {
    behind: f64,
    follow: f64,
    passed: Option<f64>,
    /// Travel (m) a second before the end.
    before: Option<f64>,
    speed: f64,
    done: bool,
}

impl Beyond {
    fn new(behind: f64, follow: f64) -> Beyond {
        Beyond {
            behind,
            follow,
            passed: None,
            before: None,
            speed: 0.0,
            done: false,
        }
    }
}

impl Run for Beyond {
    fn row(&mut self, row: &Row<'_>) {
        if row.axle[0] > self.behind {
            self.passed.get_or_insert(row.time);
        }
        let Some(at) = self.passed else { return };
        if row.time >= at + self.follow - 1.0 {
            self.before.get_or_insert(row.axle[0]);
        }
        if row.time >= at + self.follow {
            self.speed = row.axle[0] - self.before.unwrap_or(row.axle[0]);
            self.done = true;
        }
    }

    fn footfall(&mut self, _: &Footfall) {}

    fn goes_on(&mut self) -> bool {
        !self.done
    }
}

impl Sensed {
    /// The run of a robot before a box whose front is at `front` (m).
    pub fn before(&self, table: &Table, robot: Robot, seed: u64, front: f64) -> Setup {
        Setup {
            ahead: Some(table.clone()),
            obstacles: vec![self.box_at(front)],
            solid: false,
            ..self.setup(robot, seed, LONGEST)
        }
    }

    /// How `robots` robots drawn with `seed` fare, each before a solid box at a distance of its own.
    ///
    /// # Errors
    /// [`GaitError`] for a run that cannot go on.
    pub fn try_on(
        &self,
        table: &Table,
        robots: usize,
        seed: u64,
        threads: usize,
    ) -> Result<Vec<Faced>, GaitError> {
        let one = |k: usize| {
            let robot = drawn_robot(&self.robot, &self.draw, seed, k)?;
            let seed = seed.wrapping_add(k as u64);
            let front = self.front(&mut Pcg64::new(u128::from(seed), 0xf407));
            let behind = front + self.length + BEYOND;
            let free = self.before(table, robot.clone(), seed, front);
            let mut beyond = Beyond::new(behind, 3.0);
            let summary = match run(&free, &mut beyond) {
                Ok(summary) => summary,
                Err(GaitError::Sim(_)) => return Ok(Faced::lost(front)),
                Err(error) => return Err(error),
            };
            let mut faced = Faced {
                front,
                cleared: beyond.passed.is_some() && summary.clearances[0] > 0.0,
                clearance: summary.clearances[0],
                speed_after: beyond.speed,
                passed: beyond.passed,
            };
            // Until it would touch the box, the run is the same: only what clears it meets it. On a
            // boom it would come round to the box again.
            if faced.cleared {
                let solid = Setup { solid: true, ..free };
                let summary = run(&solid, &mut Beyond::new(behind, 0.0));
                faced.cleared = summary.is_ok_and(|summary| {
                    summary.bumps.iter().all(|(_, _, surface)| *surface == 0)
                });
            }
            Ok(faced)
        };
        parallel::map_on(threads, robots, one).into_iter().collect()
    }
}

/// Longest run before a box (s).
const LONGEST: f64 = 20.0;
