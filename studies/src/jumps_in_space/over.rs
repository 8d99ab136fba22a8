//! Over a box out of a run, or onto it.

use saltus_controller::ball::{Firing, Plane, Rotation, Tracker};
use saltus_gait::space::{
    DrawnBalls, Facing, Flashed, Hearing, Roll, Stable, Steered, drawn_ball,
};
use saltus_gait::{GaitError, Obstacle, Search, search};
use saltus_numeric::parallel;
use saltus_robot::Robot;
use saltus_robot::space::discs;
use saltus_sim_check::{Rig, Settings, Sim, Stepping};

use super::fly::seen;
use super::leaper::{Leap, Leaper};
use super::run_up::RunUp;
use super::{Cycle, block};
use crate::require;

/// A run over a box, or up to it and on upon it.
///
/// The robot rolls by its sensors. It knows where the box is, and chooses its first push so that twins come onto the ground in
/// front of the box where they jump best.
#[derive(Clone, Debug)]
pub struct Over {
    /// How robots are drawn.
    pub draw: DrawnBalls,
    /// Seed of the search.
    pub seed: u64,
    robot: Robot,
    stable: Stable,
    obstacle: Obstacle,
    /// Whether it jumps onto the box.
    is_onto: bool,
    /// Farthest front (m).
    farthest: f64,
    ups: Vec<RunUp>,
}

/// What became of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passed {
    /// Where the box's front was (m).
    pub front: f64,
    /// Valve opening time (s) of its first push.
    pub first: f64,
    /// Distance (m) to the box at the jump, if it jumped.
    pub jumped: Option<f64>,
    /// Least distance (m) between the box and the hull of the feet; 0 or less: it touched it. Of a jump onto the box, 1 cm
    /// more on top of it, where it may land.
    pub clearance: f64,
    /// Whether all of it came to the other side without touching the box; or onto it, without touching its front.
    pub cleared: bool,
    /// Whether it went on by [`ON`] after that, by itself.
    pub ran_on: bool,
    /// Speed (m/s) along its way at the jump.
    pub speed: f64,
    /// Greatest height (m) of where its legs meet.
    pub apex: f64,
}

/// Way (m) behind the box after which a robot has run on.
pub const ON: f64 = 2.0;
/// Where twins jump best (m), before a box.
const JUMPS: f64 = 0.42;
/// Longest run (s), for how long (s) no station may come before it stands, and how long (s) it may take from its jump on.
const LONGEST: f64 = 60.0;
const STANDS: f64 = 2.0;
const GOES_ON: f64 = 15.0;
/// How deep (m) into the top of a box a robot may come that lands on it: its feet are of rubber.
const SINKS: f64 = 0.01;
/// Clearance (m) beyond which more is worth nothing, and what being clear at all is worth (m).
const ENOUGH: f64 = 0.05;
const CLEAR: f64 = 0.4;
/// How many times as many robots choose among the best as seek them.
const JUDGES: usize = 6;
/// What a robot is worth (m) that goes through the box, or does not come to it.
const LOST: f64 = -0.25;

impl Over {
    /// A box with its front between its own and `farthest` (m), for robots around `robot` with sensors. Their run-ups are
    /// measured.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, or has no twins in its plane, and a box that cannot be, or would
    /// be in the robot's place.
    pub fn new(
        robot: &Robot,
        obstacle: Obstacle,
        farthest: f64,
        threads: usize,
    ) -> Result<Over, GaitError> {
        Over::measured((robot, obstacle, false), farthest, threads)
    }

    /// The same onto the box, where the robots go on.
    ///
    /// # Errors
    /// Those, and [`GaitError::Input`] for a box that is too short for that.
    pub fn onto(
        robot: &Robot,
        obstacle: Obstacle,
        farthest: f64,
        threads: usize,
    ) -> Result<Over, GaitError> {
        let least = 2.0 * robot.body.radius + ON;
        let (length, allowed) = (
            obstacle.length,
            format!("from {least} m for a robot that goes on upon it"),
        );
        require(length >= least, "obstacle's length (m)", length, allowed)?;
        Over::measured((robot, obstacle, true), farthest, threads)
    }

    fn measured(
        (robot, obstacle, is_onto): (&Robot, Obstacle, bool),
        farthest: f64,
        threads: usize,
    ) -> Result<Over, GaitError> {
        let mut over = Over {
            draw: DrawnBalls::around(robot),
            seed: 1,
            robot: robot.clone(),
            // From any station, as after a landing.
            stable: Steered::new(Vec::new()).stable,
            obstacle,
            is_onto,
            farthest,
            ups: Vec::new(),
        };
        over.check()?;
        over.ups = RunUp::measured(robot, &over.stable, &over.draw, farthest, threads)?;
        let front = obstacle.front;
        let allowed = "farther: no first push brings twins onto the ground where they can jump, 0.25 to 0.6 m before it";
        let serves = RunUp::serve(&over.ups, front - JUMPS);
        require(serves, "obstacle's front (m)", front, allowed)?;
        Ok(over)
    }

    fn check(&self) -> Result<(), GaitError> {
        block::check(&self.obstacle, &self.robot)?;
        let (from, to) = (self.obstacle.front, self.farthest);
        let sound = (from..=100.0).contains(&to);
        let allowed = format!("from {from} to 100 m");
        require(sound, "obstacle's farthest front (m)", to, allowed)
    }

    /// Where robot `k`'s box is (m).
    fn front(&self, seed: u64, k: usize) -> f64 {
        let [from, to] = [self.obstacle.front, self.farthest];
        // Evenly in any number of them: the golden section's multiples, shifted by the seed.
        let shift = (seed % 1000) as f64 * 0.0127;
        from + (to - from) * (0.6180339887498949 * k as f64 + shift).fract()
    }

    /// Robot `k` of those drawn from `seed` jumps as `leap` says; `row` hears of each cycle and of its distance (m) to the box,
    /// and says whether it goes on.
    ///
    /// # Errors
    /// [`GaitError`] for numbers that cannot be, and a motion that cannot go on.
    pub fn pass(
        &self,
        leap: &Leap,
        seed: u64,
        k: usize,
        row: impl FnMut(&Cycle, f64) -> bool,
    ) -> Result<Passed, GaitError> {
        self.passed(leap, (seed, k), true, row)
    }

    /// The same, with a box that is solid or one that is only looked at.
    fn passed(
        &self,
        leap: &Leap,
        (seed, k): (u64, usize),
        is_solid: bool,
        mut row: impl FnMut(&Cycle, f64) -> bool,
    ) -> Result<Passed, GaitError> {
        let front = self.front(seed, k);
        let obstacle = Obstacle {
            front,
            ..self.obstacle
        };
        let mut stable = self.stable.clone();
        stable.rate = leap.rate;
        stable.first[0] = RunUp::to(&self.ups, front - leap.aim);
        let robot = drawn_ball(&self.robot, &self.draw, seed, k)?;
        let (rest, facing) = Roll::new(robot.clone(), LONGEST).facing()?;
        let beyond = self.beyond(front);
        let after = Steered::new(vec![[beyond + 2.0 * ON, 0.0]]);
        let lead = after.lead(&robot)?;
        let flashed = Flashed::new(&robot, &stable)?;
        let facings = Facing::every(&discs(&flashed.directions));
        let planes: Vec<Plane<'_, f64>> = facings.iter().map(Facing::plane).collect();
        let solid = is_solid.then(|| block::surface(&obstacle));
        let rig = Rig::new(&robot, solid.as_slice())?;
        let mut q = rig.stand_on(&rest, &facing.ahead(&rest))?;
        q[2] -= rig.foot_gaps(&q).into_iter().fold(f64::INFINITY, f64::min);
        let v = vec![0.0; rig.mechanism.tree.velocities()];
        let settings = Settings {
            stepping: Stepping::USUAL,
            most_steps: usize::MAX,
            ..Settings::default()
        };
        let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
        sim.release_legs()?;
        let (place, attitude) = ([q[0], q[1], q[2]], [q[3], q[4], q[5], q[6]]);
        let mut hearing = Hearing::new(&robot, attitude, seed.wrapping_add(k as u64));
        let mut estimator = flashed.estimator((Rotation(attitude), place));
        let balance = flashed.balance;
        let mut tracker = Tracker::new(facing.plane(), balance.zone);
        let mut leaper = Leaper::new(
            *leap,
            front,
            (balance, facing.plane()),
            (lead, &planes, &after.path),
        );
        let mut passed = Passed {
            front,
            first: stable.first[0],
            clearance: f64::INFINITY,
            ..Passed::default()
        };
        let (mut last, mut cycles) = ((i32::MIN, 0.0), 0_u64);
        loop {
            let now = seen(&rig, &sim);
            tracker.look(&Rotation(now.attitude), &now.spin);
            estimator.take(&hearing.read(now.attitude, now.velocity, now.touching));
            for Firing { leg, open } in leaper.fire(&now, estimator.estimate()) {
                sim.fire(leg as usize, open)?;
                estimator.fired(leg);
            }
            let clearance = self.clearance(&obstacle, &rig, &sim);
            let goes_on = row(&now, clearance);
            passed.note(&now, clearance, leaper.jumped());
            if tracker.passed() > last.0 {
                last = (tracker.passed(), now.time);
            }
            let is_there =
                now.place[0] > beyond && (!self.is_onto || now.place[2] > obstacle.height);
            passed.cleared = passed.clearance > 0.0 && is_there;
            passed.ran_on = passed.cleared && is_there && now.place[0] > beyond + ON;
            let until = leaper
                .jumped()
                .map_or(last.1 + STANDS, |(_, time)| time + GOES_ON);
            let touched = is_solid && passed.clearance <= 0.0;
            if passed.ran_on || touched || !goes_on || now.time > until.min(LONGEST) {
                return Ok(passed);
            }
            cycles += 1;
            sim.run(cycles as f64 * balance.period, &[])?;
            sim.drain_events();
        }
    }

    /// Where (m) all of a robot is on the other side of a box, or has come onto it, whose front is at `front` (m).
    fn beyond(&self, front: f64) -> f64 {
        let edge = if self.is_onto {
            front
        } else {
            front + self.obstacle.length
        };
        edge + self.robot.body.radius
    }

    /// Distance (m) between `obstacle` and the hull of the feet; see [`Passed::clearance`].
    fn clearance(&self, obstacle: &Obstacle, rig: &Rig, sim: &Sim<'_>) -> f64 {
        let sinks = if self.is_onto { SINKS } else { 0.0 };
        let lower = Obstacle {
            height: obstacle.height - sinks,
            ..*obstacle
        };
        block::clearance(&lower, rig, sim)
    }

    /// Seeks the jump on `count` robots, and chooses among the best of all generations by others; `told` hears of each
    /// generation's score.
    ///
    /// # Errors
    /// [`GaitError`] for a robot or a box that cannot be.
    pub fn plan(
        &self,
        (count, generations): (usize, usize),
        threads: usize,
        mut told: impl FnMut(usize, f64, &[f64]),
    ) -> Result<Leap, GaitError> {
        let sought = Search {
            bounds: vec![
                [0.25, 0.6],
                [0.3, 0.9],
                [-0.25, 0.31],
                [-1.0, 1.0],
                [0.02, 0.06],
                [-0.3, 0.6],
                [-0.5, 0.5],
                [4.8, 7.0],
            ],
            // Found for a box of 21 cm, 2.2 m ahead.
            start: vec![0.417, 0.668, 0.156, -0.613, 0.044, 0.182, -0.085, 5.58],
            spread: 0.12,
            candidates: 40,
            best: 8,
            generations,
            seed: self.seed,
        };
        // What cannot be run at all is told before it is sought.
        self.pass(&Leap::of(&sought.start), self.seed, 0, |_, _| false)?;
        let score = |x: &[f64]| {
            let worth = (0..count).map(|k| self.worth(x, (self.seed, k)));
            worth.sum::<f64>() / count as f64
        };
        let mut finalists = vec![sought.start.clone()];
        search(&sought, threads, score, |k, best, x| {
            if finalists.iter().all(|it| it != x) {
                finalists.push(x.to_vec());
            }
            told(k, best, x);
        });
        // What is best on a few robots is so by luck, too: others decide.
        let judged = |x: &Vec<f64>| {
            let seed = self.seed.wrapping_add(1);
            let all = parallel::map_on(threads, JUDGES * count, |k| self.worth(x, (seed, k)));
            all.iter().sum::<f64>()
        };
        let worths: Vec<f64> = finalists.iter().map(judged).collect();
        let both = finalists.iter().zip(&worths);
        let best = both.max_by(|a, b| a.1.total_cmp(b.1));
        Ok(Leap::of(best.map_or(&sought.start, |(x, _)| x)))
    }

    /// What robot `k` of those drawn from `seed` is worth (m) that jumps as the numbers `x` say.
    fn worth(&self, x: &[f64], (seed, k): (u64, usize)) -> f64 {
        let back = self.beyond(self.front(seed, k)) + self.robot.body.radius;
        let goes_on = |now: &Cycle, _| now.place[0] < back;
        // A box over which they fly need not be there, and tells how near they come.
        let passed = self.passed(&Leap::of(x), (seed, k), self.is_onto, goes_on);
        passed.map_or(LOST, |it| it.worth())
    }

    /// `count` other robots, drawn from `seed`, jump as `leap` says.
    ///
    /// # Errors
    /// [`GaitError`] for a robot or a box that cannot be.
    pub fn try_on(
        &self,
        leap: &Leap,
        (count, seed): (usize, u64),
        threads: usize,
    ) -> Result<Vec<Passed>, GaitError> {
        let all = parallel::map_on(threads, count, |k| self.pass(leap, seed, k, |_, _| true));
        all.into_iter().collect()
    }
}

impl Leap {
    /// That of the numbers of the search.
    fn of(x: &[f64]) -> Leap {
        Leap {
            aim: x[0],
            from: x[1],
            lean: x[2],
            nearer: x[3],
            open: x[4],
            by_speed: [x[5], x[6]],
            rate: x[7],
        }
    }
}

impl Passed {
    fn note(&mut self, now: &Cycle, clearance: f64, jumped: Option<(f64, f64)>) {
        self.clearance = self.clearance.min(clearance);
        self.apex = self.apex.max(now.place[2]);
        if let (None, Some((far, _))) = (self.jumped, jumped) {
            (self.jumped, self.speed) = (Some(far), now.velocity[0]);
        }
    }

    fn worth(&self) -> f64 {
        let clear = if self.cleared { CLEAR } else { 0.0 };
        // A robot that does not come to the box has no clearance.
        let near = if self.clearance.is_finite() && self.jumped.is_some() {
            self.clearance.clamp(LOST, ENOUGH)
        } else {
            LOST
        };
        clear + near
    }
}
