//! Over a box out of a run.

use saltus_controller::ball::{Balancer, Estimate, Firing, Rotation, Sight, Tracker};
use saltus_numeric::parallel;
use saltus_robot::Robot;
use saltus_sim_check::{Rig, Settings, Sim, Stepping, Surface, Vec3};

use super::super::balance::{Course, Stable};
use super::super::{Ball, DrawnBalls, FALLS, Gait, Knows, Roll, Sensed, drawn_ball, look, placed};
use super::hull::{Flat, gap, hull};
use crate::GaitError;
use crate::error::require;
use crate::run::Obstacle;
use crate::search::{Search, search};

/// When a robot that rolls jumps. Of two numbers the first is of single legs, the second of twins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leap {
    /// Distance (m) to the box's front, from where the legs meet, from which on a station jumps, at a speed of [`SPEED`].
    pub from: [f64; 2],
    /// Lean (rad) at which it fires at that distance and speed.
    pub lean: [f64; 2],
    /// How much more it leans (rad) for each metre nearer to the box.
    pub nearer: [f64; 2],
    /// Valve opening times (s).
    pub open: [f64; 2],
    /// How much farther (m) from the box it jumps, and how much more it leans (rad), for each m/s faster.
    pub by_speed: [f64; 2],
    /// Rate (rad/s) at which it runs up.
    pub rate: f64,
}

/// The speed (m/s) for which [`Leap::from`] and [`Leap::lean`] stand.
pub const SPEED: f64 = 1.1;

/// A run over a box.
#[derive(Clone, Debug)]
pub struct Over {
    /// The robot, around which others are drawn.
    pub robot: Robot,
    /// How they are drawn.
    pub draw: DrawnBalls,
    /// How they run.
    pub stable: Stable,
    /// Whether they know their motion by their sensors.
    pub by_sensors: bool,
    /// The box: its height and length (m). It is wider than the robot's way.
    pub height: f64,
    /// Length (m).
    pub length: f64,
    /// Where its front is (m), from where the legs meet at rest: each robot has one of its own between these.
    pub fronts: [f64; 2],
    /// Seed of the robots and of the search.
    pub seed: u64,
}

/// What became of a robot.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passed {
    /// Where the box's front was (m).
    pub front: f64,
    /// Distance (m) to it at the jump, if it jumped.
    pub jumped: Option<f64>,
    /// Whether twins jumped.
    pub by_twins: bool,
    /// Least distance (m) between the box and the hull of the feet; 0 or less: it touched it.
    pub clearance: f64,
    /// Whether all of it came to the other side without touching the box.
    pub cleared: bool,
    /// Whether it rolled on by [`ON`] after that.
    pub ran_on: bool,
    /// Speed (m/s) along its way at the jump.
    pub speed: f64,
    /// Greatest height (m) of where its legs meet.
    pub apex: f64,
}

/// Way (m) behind the box after which a robot has run on.
pub const ON: f64 = 2.0;
/// Longest run (s), and for how long (s) no station may come before it stands.
const LONGEST: f64 = 25.0;
const STANDS: f64 = 2.0;
/// Half the width (m) of the box.
const WIDE: f64 = 10.0;
/// Clearance (m) beyond which more is worth nothing, and what being clear at all is worth (m).
const ENOUGH: f64 = 0.05;
const CLEAR: f64 = 0.1;
/// What a robot is worth (m) that goes through the box, or does not come to it.
const LOST: f64 = -0.25;

impl Over {
    /// A box `height` high and `length` long (m) with its front between `fronts` (m), for robots around `robot` with sensors.
    ///
    /// # Errors
    /// [`GaitError::Input`] for a robot that is not in space, and a box that cannot be, or would be in the robot's place.
    pub fn new(robot: &Robot, obstacle: Obstacle, farthest: f64) -> Result<Over, GaitError> {
        let over = Over {
            robot: robot.clone(),
            draw: DrawnBalls::default(),
            stable: Stable::default(),
            by_sensors: true,
            height: obstacle.height,
            length: obstacle.length,
            fronts: [obstacle.front, farthest],
            seed: 1,
        };
        over.check()?;
        Ok(over)
    }

    fn check(&self) -> Result<(), GaitError> {
        let sound = |x: f64| x > 0.0 && x <= 10.0;
        let allowed = "above 0, at most 10 m";
        require(
            sound(self.height),
            "obstacle's height (m)",
            self.height,
            allowed,
        )?;
        require(
            sound(self.length),
            "obstacle's length (m)",
            self.length,
            allowed,
        )?;
        let [from, to] = self.fronts;
        let least = self.robot.body.radius;
        let name = "obstacle's front (m)";
        let allowed =
            format!("from {least}, a leg's length, to 100 m: nearer it is around the robot");
        require((least..=100.0).contains(&from), name, from, allowed)?;
        let allowed = format!("from {from} to 100 m");
        require(
            (from..=100.0).contains(&to),
            "obstacle's farthest front (m)",
            to,
            allowed,
        )?;
        Roll::new(self.robot.clone(), 1.0).facing()?;
        Ok(())
    }

    /// Where robot `k`'s box is (m).
    fn front(&self, seed: u64, k: usize) -> f64 {
        let [from, to] = self.fronts;
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
        row: impl FnMut(&Ball, f64) -> bool,
    ) -> Result<Passed, GaitError> {
        self.passed(leap, (seed, k), true, row)
    }

    /// The same, with a box that is solid or one that is only looked at.
    fn passed(
        &self,
        leap: &Leap,
        (seed, k): (u64, usize),
        is_solid: bool,
        mut row: impl FnMut(&Ball, f64) -> bool,
    ) -> Result<Passed, GaitError> {
        self.check()?;
        let mut setup = Roll::new(drawn_ball(&self.robot, &self.draw, seed, k)?, LONGEST);
        setup.gait = Gait::Stable(self.stable.clone());
        if self.by_sensors {
            setup.knows = Knows::Sensors(seed.wrapping_add(k as u64));
        }
        let front = self.front(seed, k);
        let (rest, facing) = setup.facing()?;
        let solid = is_solid.then(|| self.surface(front));
        let rig = Rig::new(&setup.robot, solid.as_slice())?;
        let (q, v) = placed(
            &rig,
            setup.start,
            rig.stand_on(&rest, &facing.ahead(&rest))?,
        );
        let settings = Settings {
            stepping: Stepping::USUAL,
            most_steps: usize::MAX,
            ..Settings::default()
        };
        let mut sim = Sim::new(&rig.mechanism, &q, &v, settings)?;
        sim.release_legs()?;
        let directions = setup.robot.space.as_ref().map(|it| it.directions.vectors());
        let directions = directions.unwrap_or_default();
        let mut sensed = Sensed::new(&setup, &directions, &q);
        let run_up = Stable {
            rate: leap.rate,
            ..self.stable.clone()
        };
        let balance = run_up.balance(&setup.robot)?;
        let mut jumper = Jumper {
            leap: *leap,
            front,
            course: Course::new(self.stable.line),
            phase: Phase::Runs,
            by_twins: false,
            jumped: None,
            decided: None,
        };
        let mut tracker = Tracker::new(facing.plane(), balance.zone);
        let mut balancer = Balancer::new(balance, facing.plane());
        let mut passed = Passed {
            front,
            clearance: f64::INFINITY,
            ..Passed::default()
        };
        let (mut last, mut cycles) = ((i32::MIN, 0.0), 0_u64);
        loop {
            let (mut ball, _) = look(&rig, &sim, &mut tracker);
            ball.estimate = sensed.as_mut().map(|sensed| sensed.take(&ball).1);
            ball.fired = jumper.fire(&ball, &mut balancer, balance.period);
            for Firing { leg, open } in &ball.fired {
                sim.fire(*leg as usize, *open)?;
                if let Some(sensed) = &mut sensed {
                    sensed.estimator.fired(*leg);
                }
            }
            let clearance = self.clearance(&rig, &sim, front);
            let goes_on = row(&ball, clearance);
            passed.note(&ball, clearance, &jumper);
            if ball.passed > last.0 {
                last = (ball.passed, ball.time);
            }
            let beyond = front + self.length + self.robot.body.radius;
            passed.cleared = passed.clearance > 0.0 && ball.place[0] > beyond;
            passed.ran_on = passed.cleared && ball.place[0] > beyond + ON;
            let fell = ball.rolling.roll.abs() > FALLS && ball.touching != 0;
            let touched = is_solid && passed.clearance <= 0.0;
            let over = passed.ran_on || touched || fell && passed.cleared;
            if over || !goes_on || ball.time > (last.1 + STANDS).min(LONGEST) {
                return Ok(passed);
            }
            cycles += 1;
            sim.run(cycles as f64 * balance.period, &[])?;
            sim.drain_events();
        }
    }

    fn surface(&self, front: f64) -> Surface {
        Surface::Block {
            low: Vec3::new(front, -WIDE, 0.0),
            high: Vec3::new(front + self.length, WIDE, self.height),
        }
    }

    /// Distance (m) between the box and the hull of the feet, seen along the box.
    fn clearance(&self, rig: &Rig, sim: &Sim<'_>, front: f64) -> f64 {
        let (x, reach) = (sim.coordinates()[0], 2.0 * self.robot.body.radius);
        if x < front - reach || x > front + self.length + reach {
            return f64::INFINITY;
        }
        let pose = sim.pose();
        let points = rig.mechanism.points.iter();
        let feet: Vec<Flat> = points
            .map(|point| {
                let center = pose.frames[point.body].point(&point.center);
                [center.x, center.z]
            })
            .collect();
        let back = front + self.length;
        let block = [
            [front, 0.0],
            [back, 0.0],
            [back, self.height],
            [front, self.height],
        ];
        gap(&hull(&feet), &block) - self.robot.foot.radius
    }

    /// Seeks the jump on `count` robots; `told` hears of each generation's score.
    ///
    /// # Errors
    /// [`GaitError`] for a robot or a box that cannot be.
    pub fn plan(
        &self,
        (count, generations): (usize, usize),
        threads: usize,
        told: impl FnMut(usize, f64, &[f64]),
    ) -> Result<Leap, GaitError> {
        self.check()?;
        let bounds = vec![
            [0.1, 0.9],
            [0.1, 0.9],
            [-0.25, 0.46],
            [-0.25, 0.31],
            [-1.0, 1.0],
            [-1.0, 1.0],
            [0.02, 0.06],
            [0.02, 0.06],
            [-0.3, 0.6],
            [-0.5, 0.5],
            [4.8, 8.0],
        ];
        let sought = Search {
            bounds,
            start: vec![
                0.47, 0.5, 0.15, 0.1, -0.3, -0.5, 0.054, 0.046, 0.1, -0.2, 5.6,
            ],
            spread: 0.12,
            candidates: 40,
            best: 8,
            generations,
            seed: self.seed,
        };
        // What cannot be run at all is told before it is sought.
        self.pass(&Leap::of(&sought.start), self.seed, 0, |_, _| false)?;
        let score = |x: &[f64]| {
            let leap = Leap::of(x);
            let worth = |k: usize| {
                let back = self.front(self.seed, k) + self.length + 2.0 * self.robot.body.radius;
                let goes_on = |ball: &Ball, _| ball.place[0] < back;
                let passed = self.passed(&leap, (self.seed, k), false, goes_on);
                passed.map_or(LOST, |it| it.worth())
            };
            (0..count).map(worth).sum::<f64>() / count as f64
        };
        let (best, _) = search(&sought, threads, score, told);
        Ok(Leap::of(&best))
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
        let pair = |k: usize| [x[k], x[k + 1]];
        Leap {
            from: pair(0),
            lean: pair(2),
            nearer: pair(4),
            open: pair(6),
            by_speed: pair(8),
            rate: x[10],
        }
    }
}

impl Passed {
    fn note(&mut self, ball: &Ball, clearance: f64, jumper: &Jumper) {
        self.clearance = self.clearance.min(clearance);
        self.apex = self.apex.max(ball.place[2]);
        if self.jumped.is_none() && jumper.jumped.is_some() {
            (self.jumped, self.by_twins) = (jumper.jumped, jumper.by_twins);
            self.speed = ball.velocity[0];
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

/// What a robot does: run, jump, run on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Runs,
    /// Its legs push; it is still on the ground.
    Pushes,
    Flies,
    Landed,
}

struct Jumper {
    leap: Leap,
    front: f64,
    course: Course,
    phase: Phase,
    by_twins: bool,
    jumped: Option<f64>,
    /// The last station that was left to the gait.
    decided: Option<i32>,
}

impl Jumper {
    fn fire(
        &mut self,
        ball: &Ball,
        balancer: &mut Balancer<'_, f64>,
        period: f64,
    ) -> Vec<Firing<f64>> {
        let truth = Estimate {
            attitude: Rotation(ball.attitude),
            spin: ball.spin,
            velocity: ball.velocity,
            place: ball.place,
        };
        let known = ball.estimate.unwrap_or(truth);
        let heading = self.course.turn(period, &known.place);
        let [aside, aside_rate] = self.course.aside(&known.place, &known.velocity);
        let sight = Sight {
            attitude: known.attitude,
            spin: known.spin,
            aside,
            aside_rate,
            course: heading,
            touching: ball.touching,
        };
        let (lying, fired) = balancer.step(&sight);
        self.phase = match self.phase {
            Phase::Pushes if ball.touching == 0 => Phase::Flies,
            Phase::Flies if ball.touching != 0 => Phase::Landed,
            phase => phase,
        };
        match self.phase {
            Phase::Pushes | Phase::Flies => return Vec::new(),
            Phase::Landed => return fired.into_iter().flatten().collect(),
            Phase::Runs => {}
        }
        let gait = || fired.into_iter().flatten().collect();
        let here = balancer.tracker().passed();
        let Some(station) = balancer.tracker().station() else {
            return Vec::new();
        };
        let kind = usize::from(station.is_of_twins());
        let faster = known.velocity[0] - SPEED;
        let leap = &self.leap;
        let from = leap.from[kind] + leap.by_speed[0] * faster;
        let far = self.front - known.place[0];
        let lean = leap.lean[kind] + leap.nearer[kind] * (from - far) + leap.by_speed[1] * faster;
        let touches = |leg: &u32| ball.touching >> *leg & 1 == 1;
        let stands = station.legs.iter().any(touches);
        let fires = fired.iter().any(Option::is_some);
        // A station decides once, where it comes to its lean; one that has pushed has no stroke left.
        let is_due = stands && self.decided != Some(here) && (lying.lean >= lean || fires);
        if is_due && !(far <= from && far > 0.0) {
            self.decided = Some(here);
        }
        if !is_due || self.decided == Some(here) {
            return gait();
        }
        self.phase = Phase::Pushes;
        (self.jumped, self.by_twins) = (Some(far), kind == 1);
        let open = self.leap.open[kind];
        let [left, right] = station.legs;
        let legs = if kind == 1 {
            vec![left, right]
        } else {
            vec![left]
        };
        legs.into_iter().map(|leg| Firing { leg, open }).collect()
    }
}
