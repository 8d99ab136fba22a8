//! Jumps of a robot in space: from rest to a place, the map of such places, and out of a run, over a box or onto it.

mod answer;
mod crossings;
mod map;

use clap::Args;
use saltus::Robot;
use saltus::gait::GaitError;
use saltus::gait::space::DrawnBalls;
use saltus::gait::space::jump::{Flown, JumpPlan, Over, Planner, Spot, Standing, fly, landed};
use saltus::numeric::parallel;
use saltus::running::Share;

use super::super::Status;
use super::{Course, Jump};
use crate::error::{CliError, cut};
use crate::output::{self, Format, digits};
use crate::progress::Progress;
use crate::quantity::{self, Quantity};
use answer::{Answer, rows};
use crossings::Crossings;
use map::Map;

/// What a robot in space does.
#[derive(Args, Debug)]
#[command(next_help_heading = "Robot in space")]
pub(super) struct Ball {
    /// Jump from rest to here (m): ahead and to the left of where the robot's legs meet
    #[arg(long, value_name = "X,Y", value_parser = place, allow_hyphen_values = true)]
    target: Option<[f64; 2]>,

    /// Jump from rest into this direction (rad), to the left of ahead, by --distance
    #[arg(long, value_name = "ANGLE", value_parser = quantity::heading, allow_hyphen_values = true, requires = "distance", conflicts_with = "target")]
    heading: Option<f64>,

    /// How far (m) to jump with --heading
    #[arg(long, value_name = "M", value_parser = extent, requires = "heading", allow_hyphen_values = true)]
    distance: Option<f64>,

    /// Feet on which the robot stands at first, by their number among all that it can stand on [default: 0]
    #[arg(long, value_name = "NUMBER")]
    rest: Option<u16>,

    /// Jump out of a run onto the box of --obstacle, and go on upon it
    #[arg(long, requires = "obstacle", conflicts_with_all = ["target", "heading", "map"])]
    onto: bool,

    /// Where the robot can land from rest: jumps to places this far apart (m)
    #[arg(long, value_name = "SPACING", value_parser = extent, allow_hyphen_values = true)]
    map: Option<f64>,
}

/// Robots on which a jump is sought, where no flag says otherwise.
const SOUGHT_ON: u16 = 16;
/// Robots, and generations, of the search for a jump out of a run.
const FROM_RUN: (u16, u16) = (16, 3);
/// How near (m) a robot has to land.
const NEAR: f64 = 0.1;
/// How much lower (m) than it stands a robot on a box may be that is still moving on it.
const LOWER: f64 = 0.01;
/// Shares that are enough: of robots that land near, and of those that clear a box.
const ENOUGH: f64 = 0.9;
const ENOUGH_OVER: f64 = 0.8;
/// For how long (s) a robot is followed after it has landed.
const AFTER: f64 = 3.0;

impl Ball {
    /// Refuses what only a robot in space does.
    pub(super) fn refuse(&self) -> Result<(), CliError> {
        let given = [
            ("--target", self.target.is_some()),
            ("--heading", self.heading.is_some()),
            ("--rest", self.rest.is_some()),
            ("--map", self.map.is_some()),
            ("--onto", self.onto),
        ];
        match given.into_iter().find(|(_, is_given)| *is_given) {
            Some((flag, _)) => {
                let allowed = "used with a robot in space, whose body.shape is sphere";
                Err(CliError::flag(flag, "", allowed))
            }
            None => Ok(()),
        }
    }

    /// Where to jump (m), if a place is given.
    fn place(&self) -> Option<[f64; 2]> {
        let (Some(angle), Some(far)) = (self.heading, self.distance) else {
            return self.target;
        };
        let (sine, cosine) = angle.sin_cos();
        Some([far * cosine, far * sine])
    }
}

impl Jump {
    /// The jump of the robot in space that the flags name.
    pub(super) fn in_space(&self, robot: &Robot) -> Result<Status, CliError> {
        self.learning.refuse()?;
        if self.legs.is_some() {
            return Err(CliError::flag(
                "--legs",
                "",
                "used with a robot in its plane",
            ));
        }
        if self.plot.is_set() && self.ball.map.is_none() {
            let allowed = "used with --map for a robot in space";
            return Err(CliError::flag("--plot", "", allowed));
        }
        let from_rest = self.ball.place().is_some() || self.ball.map.is_some();
        if self.generations.is_some() && (from_rest || self.obstacle.is_none()) {
            let allowed = "used with --obstacle alone for a robot in space";
            return Err(CliError::flag("--generations", "", allowed));
        }
        match (self.obstacle, self.ball.place(), self.ball.map) {
            (Some(course), None, None) => self.over(robot, course),
            (_, Some(target), None) => self.to(robot, target),
            (_, None, Some(spacing)) => self.map(robot, spacing),
            (None, None, None) => Err(CliError::Missing {
                flag: "--target",
                allowed: "X,Y in m; or --heading with --distance, --map, or --obstacle",
            }),
            (_, Some(_), Some(_)) => {
                let allowed = "used without --target and --heading";
                Err(CliError::flag("--map", "", allowed))
            }
        }
    }

    fn planner(&self, robot: &Robot) -> Result<Planner, CliError> {
        let refused = |error| refused(error, robot);
        let rest = usize::from(self.ball.rest.unwrap_or(0));
        let mut standing = Standing::on(robot, rest).map_err(refused)?;
        if let Some(course) = self.obstacle {
            if course.fronts().is_some() {
                let allowed = "HEIGHTxLENGTH@FRONT with one FRONT for a jump from rest";
                return Err(CliError::flag("--obstacle", "", allowed));
            }
            let obstacle = course.at(course.front);
            standing = standing.before(obstacle, robot).map_err(refused)?;
        }
        let sought = (
            usize::from(self.sought_on.unwrap_or(SOUGHT_ON)),
            self.seed.seed,
        );
        let draw = DrawnBalls::around(robot);
        let planner = Planner::new(robot, standing, &draw, sought, self.threads.count().get());
        planner.map_err(refused)
    }

    /// Seed of other robots than those of the search.
    fn others(&self) -> u64 {
        self.seed.seed.wrapping_add(1 << 32)
    }

    fn to(&self, robot: &Robot, target: [f64; 2]) -> Result<Status, CliError> {
        let threads = self.threads.count().get();
        let planner = self.planner(robot)?;
        let refused = |error| refused(error, robot);
        let plan = planner.to(target, threads).map_err(refused)?;
        let robots = usize::from(self.robots);
        let near = nearby(&planner, &plan, target, (robots, self.others()), threads);
        let near = near.map_err(refused)?;
        let is_yes = plan.is_reached() && near.is_enough();
        let mut cycles = Vec::new();
        let jump = &plan.jump;
        let whole = fly(robot, planner.standing(), jump, AFTER, |cycle| {
            cycles.push(cycle.clone());
        });
        let answer = Answer {
            name: &robot.name,
            rest: usize::from(self.ball.rest.unwrap_or(0)),
            standing: planner.standing(),
            target,
            plan: &plan,
            whole: whole.map_err(refused)?,
            near,
        };
        let report = match self.output.format() {
            Format::Csv => rows(&cycles).csv(),
            Format::Json => output::json(&answer.json(self.seed.seed)),
            Format::Text => answer.text(),
        };
        self.output.write_report(report)?;
        Ok(if is_yes { Status::Done } else { Status::No })
    }

    fn map(&self, robot: &Robot, spacing: f64) -> Result<Status, CliError> {
        let threads = self.threads.count().get();
        let planner = self.planner(robot)?;
        let refused = |error| refused(error, robot);
        let count = planner.grid(spacing).map_err(refused)?.len();
        let progress = Progress::new("places", count);
        let spots = planner.reach(spacing, threads, &|| progress.advance(1));
        drop(progress);
        let spots = spots.map_err(refused)?;
        let progress = Progress::new("places that are reached", count);
        let robots = usize::from(self.robots);
        let shares = parallel::map_on(threads, spots.len(), |k| {
            let Spot { target, plan } = &spots[k];
            let near = || nearby(&planner, plan, *target, (robots, self.others()), 1);
            let share = plan.is_reached().then(near);
            progress.advance(1);
            share.transpose()
        });
        drop(progress);
        let shares: Vec<Option<Nearby>> = shares
            .into_iter()
            .collect::<Result<_, _>>()
            .map_err(refused)?;
        let map = Map {
            name: &robot.name,
            spacing,
            spots: &spots,
            shares: &shares,
            feet: feet(&planner),
            obstacle: planner.standing().obstacle,
        };
        let report = match self.output.format() {
            Format::Csv => map.table().csv(),
            Format::Json => output::json(&map.json(self.seed.seed)),
            Format::Text => map.text(),
        };
        self.output
            .write_with_plot(report, &self.plot, || Ok(map.drawing()))?;
        let is_yes = map.together().value() >= ENOUGH;
        Ok(if is_yes { Status::Done } else { Status::No })
    }

    fn over(&self, robot: &Robot, course: Course) -> Result<Status, CliError> {
        if self.ball.rest.is_some() {
            return Err(CliError::flag("--rest", "", "used without --obstacle"));
        }
        let threads = self.threads.count().get();
        let refused = |error| refused(error, robot);
        let farthest = course.fronts().map_or(course.front, |fronts| fronts[1]);
        let obstacle = course.at(course.front);
        let over = if self.ball.onto {
            Over::onto(robot, obstacle, farthest, threads)
        } else {
            Over::new(robot, obstacle, farthest, threads)
        };
        let mut over = over.map_err(refused)?;
        over.seed = self.seed.seed;
        let generations = usize::from(self.generations.unwrap_or(FROM_RUN.1));
        let sought_on = usize::from(self.sought_on.unwrap_or(FROM_RUN.0));
        let progress = Progress::new("generations", generations);
        let leap = over.plan((sought_on, generations), threads, |_, _, _| {
            progress.advance(1);
        });
        drop(progress);
        let leap = leap.map_err(refused)?;
        let robots = usize::from(self.robots);
        let tried = over.try_on(&leap, (robots, self.others()), threads);
        let tried = tried.map_err(refused)?;
        let crossed = Crossings {
            name: &robot.name,
            obstacle,
            is_onto: self.ball.onto,
            farthest,
            leap: &leap,
            tried: &tried,
        };
        let report = match self.output.format() {
            Format::Csv => crossed.table().csv(),
            Format::Json => output::json(&crossed.json(self.seed.seed)),
            Format::Text => crossed.text(),
        };
        self.output.write_report(report)?;
        let is_yes = crossed.share(|it| it.cleared).value() >= ENOUGH_OVER;
        Ok(if is_yes { Status::Done } else { Status::No })
    }
}

/// How other robots land.
struct Nearby {
    /// Near the target, without having run against a box on the way.
    near: Share,
    /// So, and still on the box in the end: if the target is on one.
    stay: Option<Share>,
}

impl Nearby {
    fn is_enough(&self) -> bool {
        let stay = self.stay.as_ref().map_or(1.0, Share::value);
        self.near.value() >= ENOUGH && stay >= ENOUGH
    }
}

/// How other robots land that jump to `target`.
fn nearby(
    planner: &Planner,
    plan: &JumpPlan,
    target: [f64; 2],
    (robots, seed): (usize, u64),
    threads: usize,
) -> Result<Nearby, GaitError> {
    let floor = planner.standing().floor(target[0]);
    let after = if floor > 0.0 { AFTER } else { 0.0 };
    let all = parallel::map_on(threads, robots, |k| planner.other(plan, (seed, k), after));
    let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
    let is_near = |flown: &Flown| {
        let off = |[x, y]: [f64; 2]| (x - target[0]).hypot(y - target[1]);
        flown.clearance > 0.0 && landed(flown).is_some_and(|at| off(at) <= NEAR)
    };
    let share = |did: &dyn Fn(&Flown) -> bool| Share {
        count: all.iter().filter(|flown| did(flown)).count(),
        of: robots,
    };
    let least = floor + planner.standing().place[2] - LOWER;
    let stays = |flown: &Flown| is_near(flown) && flown.rests[2] > least;
    Ok(Nearby {
        near: share(&is_near),
        stay: (floor > 0.0).then(|| share(&stays)),
    })
}

/// Where the feet stand (m).
fn feet(planner: &Planner) -> Vec<(f64, f64)> {
    let feet = planner.feet_places();
    feet.into_iter().map(|[x, y]| (x, y)).collect()
}

/// A refusal of the library, in the words of the command.
fn refused(error: GaitError, robot: &Robot) -> CliError {
    match error {
        GaitError::Input {
            name,
            value,
            allowed,
        } if name.starts_with("target") => {
            CliError::flag("--target", format!("({name} = {value})"), allowed)
        }
        GaitError::Input {
            name,
            value,
            allowed,
        } if name == "rest" => CliError::flag("--rest", value, allowed),
        GaitError::Input {
            name,
            value,
            allowed,
        } if name.starts_with("spacing") => CliError::flag("--map", value, allowed),
        error => super::refused(error, robot),
    }
}

/// Parser of a flag.
fn place(text: &str) -> Result<[f64; 2], String> {
    let Some((x, y)) = text.split_once(',') else {
        return Err(format!("{:?} must be X,Y in m, as in 0.3,-0.2", cut(text)));
    };
    let metres = |part| {
        Quantity::PLACE
            .parse(part)
            .map_err(|error| error.to_string())
    };
    Ok([metres(x)?, metres(y)?])
}

/// Parser of a flag.
fn extent(text: &str) -> Result<f64, String> {
    let metres = quantity::distance(text).map_err(|error| error.to_string())?;
    if metres > 0.0 && metres <= 100.0 {
        Ok(metres)
    } else {
        Err(format!("{metres} m must be above 0, at most 100 m"))
    }
}

/// A place or speed in words: what is only round-off is 0.
fn short(x: f64) -> String {
    digits(if x.abs() < 1e-9 { 0.0 } else { x }, 4)
}
