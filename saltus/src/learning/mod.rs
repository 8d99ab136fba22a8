//! Robots that learn to run: the experiments of chapter 6 of the thesis, over many seeds.
//!
//! [`Task::settings`] has what the thesis says of each. [`learn`] lets each seed learn alone; [`Learnt`] has their
//! curves, scores and tables, and [`PolicyFile`] is the file of them.

mod file;
mod policy;
mod pupil;
mod summary;

pub use file::{Held, PolicyError, PolicyFile};
pub use pupil::{Learnt, Pupil, learn};
pub use summary::{Interval, interquartile};

use saltus_gait::learn::{
    Algorithm, Bin, Bins, Environment, Gridded, Legs, Outcome, Plant, Rates, Reward, Schedule,
    Score, Stride, Task as Course, Term, Training, Zone,
};
use saltus_gait::{GaitError, Obstacle};
use saltus_robot::Robot;

/// What is to be learnt.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Task {
    /// Which valve to open, each millisecond: thesis 6.3.1.
    RunLegs,
    /// The same before a box: thesis 6.3.1.
    Climb,
    /// Whether the leg in the active zone fires, by what the robot measures: thesis 6.3.2.
    RunZone,
    /// At which lean the next leg fires and for how long: thesis 8.3.2.
    RunStride,
    /// The same, with a box on the way.
    JumpStride,
}

/// The box of the thesis (m).
const BOX: Obstacle = Obstacle {
    front: 0.5,
    length: 0.21,
    height: 0.21,
};
/// The box of `jump-stride`.
const LOWER: Obstacle = Obstacle {
    front: 1.0,
    length: 0.21,
    height: 0.1,
};

/// Firing angles and valve opening times among which a table chooses in a stride.
const GRID: [usize; 2] = [6, 3];
/// Longest time (s) of a run by strides.
const LONGEST: f64 = 3.0;

impl Task {
    /// Every task.
    pub const ALL: [Task; 5] = [
        Task::RunLegs,
        Task::Climb,
        Task::RunZone,
        Task::RunStride,
        Task::JumpStride,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Task::RunLegs => "run-legs",
            Task::Climb => "climb",
            Task::RunZone => "run-zone",
            Task::RunStride => "run-stride",
            Task::JumpStride => "jump-stride",
        }
    }

    /// What learns it where nothing else is asked for.
    pub fn algorithm(self) -> Algorithm {
        match self {
            Task::RunZone => Algorithm::SarsaLambda,
            _ => Algorithm::Q,
        }
    }

    /// Whether a decision is a firing angle and a valve opening time.
    pub fn is_by_stride(self) -> bool {
        matches!(self, Task::RunStride | Task::JumpStride)
    }

    /// Terms of the reward, episodes, and steps of an episode.
    fn usual(self, traces: bool) -> (Vec<(Term, f64)>, usize, usize) {
        match self {
            Task::RunLegs => {
                let episodes = if traces { 100 } else { 1000 };
                (vec![(Term::Threshold(2.0), 1.0)], episodes, 1000)
            }
            Task::Climb => (vec![(Term::Travel, 1.0), (Term::Arrival, 10.0)], 500, 2000),
            Task::RunZone => (vec![(Term::Rate, 1.0)], 40, 360),
            Task::RunStride => {
                let reward = vec![(Term::Travel, 1.0), (Term::Time, 1.0), (Term::Stall, 3.0)];
                (reward, 500, 60)
            }
            Task::JumpStride => (vec![(Term::Travel, 1.0), (Term::Arrival, 3.0)], 2000, 60),
        }
    }

    fn rates(self, traces: bool) -> Rates {
        // A stride is long: what comes of it is in the next ones, and tables are small.
        let [alpha, gamma] = match (self.is_by_stride(), traces) {
            (true, _) => [0.2, 1.0],
            (false, true) => [0.8, 0.3],
            (false, false) => [1.0, 0.3],
        };
        Rates {
            alpha,
            gamma,
            lambda: 0.9,
        }
    }

    fn bins(self) -> Bins {
        let bin = |from, to, count| Bin { from, to, count };
        // Of strides rate, lean, speed, height; distance of the box.
        let mut axes = vec![
            bin(-5.0, 20.0, 20),
            bin(-0.3, 1.0, 2),
            bin(0.0, 4.0, 1),
            bin(-0.2, 0.2, 1),
        ];
        if self == Task::JumpStride {
            axes.push(bin(-0.2, 2.0, 11));
        }
        match self {
            Task::RunLegs | Task::Climb => Bins::of_table_6_1(),
            Task::RunZone => Bins::of_table_6_3(),
            // Few steps within their limits.
            _ => Bins::new(axes).unwrap_or_else(|_| Bins::of_table_6_3()),
        }
    }

    /// The settings of the thesis for `robot`, tables 6.1 to 6.4 as printed; of its own, where it has none.
    pub fn settings(self, robot: Robot, algorithm: Algorithm) -> Settings {
        let mut plant = Plant::new(robot);
        let traces = algorithm.has_traces();
        let (reward, episodes, steps) = self.usual(traces);
        match self {
            Task::RunLegs | Task::RunZone | Task::RunStride => {}
            Task::Climb => plant.obstacles = vec![BOX],
            Task::JumpStride => plant.obstacles = vec![LOWER],
        }
        Settings {
            task: self,
            plant,
            algorithm,
            rates: self.rates(traces),
            schedule: Schedule {
                epsilon: if self == Task::RunZone { 0.95 } else { 1.0 },
                decay: if traces && !self.is_by_stride() {
                    0.95
                } else {
                    0.99
                },
                episodes,
            },
            bins: self.bins(),
            reward: Reward(reward),
            steps,
        }
    }
}

/// Episodes over which a score is a mean.
const SMOOTH: usize = 10;
/// Share of the final score that counts as learnt.
const LEARNT: f64 = 0.9;
/// Angle (rad) or travel (m) above which a robot has moved at all.
const MOVES: f64 = 0.1;

/// What learns what, and how.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The task.
    pub task: Task,
    /// The robot and what is around it.
    pub plant: Plant,
    /// What learns.
    pub algorithm: Algorithm,
    /// Its numbers.
    pub rates: Rates,
    /// How it explores, and how long.
    pub schedule: Schedule,
    /// The states.
    pub bins: Bins,
    /// What is rewarded.
    pub reward: Reward,
    /// Steps of an episode at most.
    pub steps: usize,
}

impl Settings {
    /// Its robot with its task; a stride's decision is numbers.
    ///
    /// # Errors
    /// [`GaitError`] for a robot that cannot run.
    pub fn environment(&self) -> Result<Box<dyn Environment>, GaitError> {
        let (plant, reward) = (self.plant.clone(), self.reward.clone());
        let usual = Course::default();
        Ok(match self.task {
            Task::RunLegs | Task::Climb => Box::new(Legs::new(plant, reward, self.steps)?),
            Task::RunZone => {
                let seconds = self.steps as f64 * usual.period;
                Box::new(Zone::new(plant, reward, Course { seconds, ..usual })?)
            }
            Task::RunStride | Task::JumpStride => {
                let radius = plant.robot.body.radius;
                let past = plant.obstacles.first();
                let past = past.map(|it| it.front + it.length + radius);
                let course = Course {
                    seconds: LONGEST,
                    goal: past.unwrap_or(usual.goal),
                    ..usual
                };
                Box::new(Stride::new(plant, reward, course, self.steps)?)
            }
        })
    }

    /// The same for a table, which chooses: a stride's decision is one on a grid.
    fn chosen(&self) -> Result<Box<dyn Environment>, GaitError> {
        Ok(if self.task.is_by_stride() {
            Box::new(self.grid()?)
        } else {
            self.environment()?
        })
    }

    /// The firings among which a table chooses.
    fn grid(&self) -> Result<Gridded, GaitError> {
        Gridded::new(self.environment()?, &GRID)
    }

    fn training<'e>(&self, environment: &'e dyn Environment) -> Training<'e> {
        Training {
            environment,
            bins: self.bins.clone(),
            algorithm: self.algorithm,
            rates: self.rates,
            schedule: self.schedule,
        }
    }

    /// How far an episode came: the angle (rad) for `run-legs`, the travel (m) for the others.
    pub fn way(&self, outcome: &Outcome) -> f64 {
        match self.task {
            Task::RunLegs => outcome.angle,
            _ => outcome.travel,
        }
    }

    /// Episodes until the mean [`way`](Settings::way) of ten has 90 % of that of the last tenth of `curve`; none for a
    /// robot that did not learn to run, and for less than twenty episodes.
    pub fn episodes_to_90_percent(&self, curve: &[Score]) -> Option<usize> {
        let ways: Vec<f64> = curve.iter().map(|it| self.way(&it.outcome)).collect();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
        let last = mean(&ways[ways.len() - ways.len().div_ceil(10)..]);
        if last < MOVES || ways.len() < 2 * SMOOTH {
            return None;
        }
        let width = SMOOTH.min(ways.len().max(1));
        let mut means = ways.windows(width).map(mean);
        means
            .position(|level| level >= LEARNT * last)
            .map(|first| first + width)
    }

    /// What an episode is judged by, the more the better: the angle (rad) for `run-legs`, the time left (s) for
    /// the others, with the travel (m) where the goal was not reached.
    pub fn figure(&self, outcome: &Outcome) -> f64 {
        match self.task {
            Task::RunLegs => outcome.angle,
            _ => match outcome.arrived {
                Some(time) => 100.0 - time,
                None => outcome.travel,
            },
        }
    }
}
