//! The strides from which a table is made.

use rand_pcg::Pcg64;
use saltus_numeric::parallel;
use saltus_robot::Robot;

use super::profile::Profile;
use super::{Sensed, below, between};
use crate::box_table::{
    ALL, ANGLES, BoxTable, CHOICES, Choice, FIRST_LEAP, LEAP_ANGLES, LEAP_OPEN, TIMES, floor,
    row_of,
};
use crate::drawn::drawn_robot;
use crate::run::{Footfall, Row, Run, Setup, run};
use crate::{GaitError, Program};

/// From one leg's entry into the zone to the next one's, or to the end of a jump.
#[derive(Clone, Debug)]
pub(super) struct Stride {
    /// Cell of rate and height.
    pub(super) row: usize,
    /// What the leg did; [`CHOICES`] for what the table does not have.
    pub(super) choice: usize,
    /// For each distance: height (m) of the highest box that it clears.
    pub(super) clears: Vec<f32>,
    /// Way (m) to the next stride, and its row; none after a jump and where the run ends.
    pub(super) next: Option<(f64, usize)>,
    /// Whether the robot then stood still.
    pub(super) stalls: bool,
}

/// Makes strides of a run.
struct Watch<'r> {
    sensed: &'r Sensed,
    robot: &'r Robot,
    /// Count of the pivot encoder at the start.
    stands_at: i32,
    /// The leg in the zone; the row, the travel at its entry, and what it has done.
    leg: Option<u32>,
    entry: (usize, f64, usize),
    profile: Profile,
    strides: Vec<Stride>,
    /// When a jump was fired (s).
    leapt: Option<f64>,
    stalled: bool,
    done: bool,
    travel: f64,
}

/// Time (s) and way (m) for which a jump is watched.
const WATCHED: f64 = 1.0;
const FOLLOWED: f64 = 1.9;

impl<'r> Watch<'r> {
    fn new(sensed: &'r Sensed, robot: &'r Robot) -> Watch<'r> {
        Watch {
            sensed,
            robot,
            stands_at: 0,
            leg: None,
            entry: (0, 0.0, 0),
            profile: Profile::new(0.0),
            strides: Vec::new(),
            leapt: None,
            stalled: false,
            done: false,
            travel: 0.0,
        }
    }

    /// Ends the stride, and begins the next one in row `next`, if there is one.
    fn end(&mut self, next: Option<usize>) {
        let (row, from, choice) = self.entry;
        let way = self.travel - from;
        let reach = (choice >= FIRST_LEAP).then_some(way);
        self.strides.push(Stride {
            row,
            choice,
            clears: self.profile.clears(self.sensed.length, reach),
            next: next.map(|row| (way, row)),
            stalls: self.stalled,
        });
    }

    fn enter(&mut self, row: &Row<'_>) {
        let pivot = row.readings.pivot;
        if self.leg.is_none() {
            self.stands_at = pivot;
        }
        let [_, climb] = self.sensed.per_count();
        let cell = row_of(row.action.rate, f64::from(pivot - self.stands_at) * climb);
        if self.leg.is_some() {
            self.end(Some(cell));
        }
        self.leg = Some(row.action.in_zone);
        self.entry = (cell, row.axle[0], 0);
        self.profile = Profile::new(row.axle[0]);
    }
}

impl Run for Watch<'_> {
    fn row(&mut self, row: &Row<'_>) {
        let action = &row.action;
        self.travel = row.axle[0];
        if self.leapt.is_none() {
            if self.leg != Some(action.in_zone) {
                self.enter(row);
            }
            if action.leg.is_some() {
                let fired = [action.firing_angle, action.valve_open];
                let known = ALL.iter().position(|choice| *choice == fired);
                self.entry.2 = known.unwrap_or(CHOICES);
                let leaps = (FIRST_LEAP..CHOICES).contains(&self.entry.2);
                self.leapt = leaps.then_some(row.time);
            }
        }
        self.profile.take(self.robot, row);
        self.stalled = action.stalled;
        let far = self.entry.1 + FOLLOWED;
        let over = |at: f64| row.time > at + WATCHED || self.travel > far;
        self.done = self.leapt.is_some_and(over) || action.stalled;
    }

    fn footfall(&mut self, _: &Footfall) {}

    fn goes_on(&mut self) -> bool {
        !self.done
    }
}

/// Longest run (s) of random firings, and by tables.
const RANDOM: f64 = 6.0;
const BY_TABLE: f64 = 10.0;
/// Share of a table's cells that err, and of these, that jump.
const ERRING: f64 = 0.15;
const LEAPING: f64 = 0.6;

impl Sensed {
    /// Strides of so many runs: of random firings, or with `tables`, of theirs with errors.
    pub(super) fn strides(
        &self,
        tables: &[BoxTable],
        round: usize,
        threads: usize,
    ) -> Result<Vec<Stride>, GaitError> {
        let one = |k: usize| {
            let k = round * self.runs + k;
            let seed = self.seed.wrapping_add(k as u64);
            let robot = drawn_robot(&self.robot, &self.draw, self.seed, k)?;
            let mut random = Pcg64::new(u128::from(seed), 0xb0c5);
            let setup = match tables.get(k % tables.len().max(1)) {
                None => self.random(robot.clone(), seed, &mut random),
                Some(table) => self.erring(table, robot.clone(), seed, &mut random),
            };
            let mut watch = Watch::new(self, &robot);
            // A motion that the simulation cannot follow to its end teaches what came before.
            match run(&setup, &mut watch) {
                Ok(_) => watch.end(None),
                Err(GaitError::Sim(_)) => {}
                Err(error) => return Err(error),
            }
            Ok(watch.strides)
        };
        let all: Vec<Vec<Stride>> = parallel::map_on(threads, self.runs, one)
            .into_iter()
            .collect::<Result<_, GaitError>>()?;
        Ok(all.into_iter().flatten().collect())
    }

    /// Random firings: angles that go from one that starts to one that runs, and a jump.
    fn random(&self, robot: Robot, seed: u64, random: &mut Pcg64) -> Setup {
        let count = below(random, 12);
        let (begin, end) = (between(random, 0.1, 0.65), between(random, -0.45, 0.45));
        let (open, pace) = (between(random, 0.0, 3.0), between(random, 0.5, 4.0));
        let mut first: Vec<Choice> = Vec::new();
        for k in 0..count {
            let middle = end + (begin - end) * (-(k as f64) / pace).exp();
            let wanted = middle + between(random, -0.15, 0.15);
            let off = |angle: &f64| (angle - wanted).abs();
            let nearest = ANGLES.iter().min_by(|a, b| off(a).total_cmp(&off(b)));
            let time = floor(open + between(random, -1.0, 1.0), 1.0).min(TIMES.len() - 1);
            first.extend(nearest.map(|angle| [*angle, TIMES[time]]));
        }
        first.push([LEAP_ANGLES[below(random, LEAP_ANGLES.len())], LEAP_OPEN]);
        Setup {
            first,
            // Then none fires.
            program: Program::Fixed { firing_angle: 0.1 },
            valve_open: 0.0,
            ..self.setup(robot, seed, RANDOM)
        }
    }

    /// Firings by `table`, some of whose cells err, before a box that can be gone through.
    fn erring(&self, table: &BoxTable, robot: Robot, seed: u64, random: &mut Pcg64) -> Setup {
        let front = self.front(random).max(self.room);
        let mut table = table.clone();
        for cell in &mut table.cells {
            if between(random, 0.0, 1.0) < ERRING {
                let choice = if between(random, 0.0, 1.0) < LEAPING {
                    FIRST_LEAP + below(random, LEAP_ANGLES.len())
                } else {
                    1 + below(random, FIRST_LEAP - 1)
                };
                *cell = u8::try_from(choice).unwrap_or(0);
            }
        }
        Setup {
            obstacles: vec![self.box_at(table.height, front)],
            ahead: Some(table),
            solid: false,
            ..self.setup(robot, seed, BY_TABLE)
        }
    }
}
