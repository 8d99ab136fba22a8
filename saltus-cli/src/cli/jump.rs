//! `saltus jump`: over a box from rest, or one that is sensed on the way.

mod margin;
mod sensed;

use clap::Args;
use saltus::Robot;
use saltus::gait::{Crossed, Crossing, CrossingPlan, Draw, GaitError, Obstacle};
use saltus::running::Share;
use serde_json::{Value, json};

use self::margin::{Margin, Passage};
use self::sensed::Learning;
use super::common::{OutputFlags, RobotFlags, Seed, Threads};
use super::{Place, Status};
use crate::error::{CliError, cut};
use crate::output::{self, Files, Format, in_words, measured};
use crate::progress::Progress;
use crate::quantity;

/// Jump over a box: from rest, some legs accelerate and the next one jumps; or out of a run, over a box
/// that a range sensor sees
#[derive(Args, Debug)]
#[command(
    after_help = "`saltus jump --help` explains the output.",
    after_long_help = LONG_HELP,
    mut_arg("robot", |robot| robot.help("Robot: a built-in one with a boom or without (rats-boom, rats-run) or a TOML file [default: rats-run]"))
)]
pub(crate) struct Jump {
    /// The box: HEIGHTxLENGTH@FRONT (m), its front counted from the axle at rest; with FRONT as FROM:TO
    /// it is anywhere between, and the robot senses it
    #[arg(long, value_name = "HEIGHTxLENGTH@FRONT", value_parser = course, allow_hyphen_values = true)]
    obstacle: Option<Course>,

    /// Legs that accelerate before the one that jumps [default: 3]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u8).range(1..=6))]
    legs: Option<u8>,

    /// Drawn robots on which the firings are sought [default: 8]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1000))]
    sought_on: Option<u16>,

    /// Generations of the search [default: 14]
    #[arg(long, value_name = "COUNT", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1000))]
    generations: Option<u16>,

    #[command(flatten)]
    learning: Learning,

    /// Other drawn robots on which they are tried
    #[arg(long, value_name = "COUNT", default_value = "100", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=10000))]
    robots: u16,

    #[command(flatten)]
    seed: Seed,

    #[command(flatten)]
    threads: Threads,

    #[command(flatten)]
    robot: RobotFlags,

    #[command(flatten)]
    output: OutputFlags,
}

const LONG_HELP: &str = "\
Examples:
  saltus jump --obstacle 0.1x0.21@1:6
  saltus jump --obstacle 0.21x0.21@1.3 --set leg.supply_pressure_gauge_psi=160
  saltus jump --obstacle 0.16x0.21@1.3 --format json --out box.json

FRONT as FROM:TO is a box that the robot senses. At each leg's entry into the active zone a table says whether the leg drives, \
brakes or jumps, and at which firing angle: by the rate, the height of the axle and the distance to the box, which the range \
sensor gives (keys range_ of [sensors]) and the encoder of the boom carries on. The table is made by dynamic programming over \
strides of drawn robots, --rounds of --runs runs. A robot with less than --room to run up backs off first. The answer is the share of other robots \
that clears the solid box, each at a front of its own, and the share of these that still runs at over 1 m/s 3 s later. It takes some minutes.

With one FRONT, the robot stands on two feet. Each leg that accelerates has a firing angle and a valve opening time; the next one jumps at \
α_f = A ω + B, where ω is the rate that its gyro has after its touch-down, with its valve open past the end of the stroke. \
These numbers are sought by the cross-entropy method on robots that are drawn as `saltus run fixed --robots` draws them, for their \
clearance: the least distance between the box and feet, rods and struts. Then other robots try them on the solid box.

The answer is the share that comes to the other side without touching the box, with its 95 % interval (Wilson), and the \
least clearance that 5 % and half of those that come to the other side have. Exit code 1 if less than 95 % clear it. The search takes \
about a minute.

JSON: {\"command\": \"jump\", \"robot\", \"seed\", \"robots\", \"obstacle\": {\"height_m\", \"length_m\", \"front_m\" or \"fronts_m\"}, \"cleared\" (robots), \"cleared_share\", \
\"cleared_share_95\" (interval), \"clearance_m\": {\"5_percent\", \"median\", \"over_the_box\"}}. With one FRONT also \"first\": [{\"firing_angle_rad\", \"valve_open_s\"}] of \
the legs that accelerate, and \"jump\": {\"slope_s\" (A), \"level_rad\" (B), \"valve_open_s\"}; with FROM:TO \"room_m\", \"runs\", \"nearer_height_m\" and \"run_on\" (robots).

The answer does not depend on --threads.";

/// What is sought without flags.
const LEGS: u8 = 3;
const SOUGHT_ON: u16 = 8;
const GENERATIONS: u16 = 14;
/// Share of robots that must clear the box.
const ENOUGH: f64 = 0.95;

struct Answer<'a> {
    jump: &'a Jump,
    name: &'a str,
    obstacle: Obstacle,
    plan: &'a CrossingPlan,
    tried: &'a [Crossed],
}

impl Jump {
    pub(crate) fn run(self) -> Result<Status, CliError> {
        self.output.report_ready()?;
        let mut files = Files::default();
        files.extend(self.output.out().map(|out| ("--out", out)));
        files.check()?;
        let robot = self.robot.any_robot_or("rats-run")?;
        if robot.space.is_some() {
            return Err(CliError::Moved {
                asked: format!("jump --robot {}", robot.name),
                place: Place::Study("over_box 0.21 2.2 2.2 16 3 100").to_string(),
            });
        }
        let Some(course) = self.obstacle else {
            return Err(CliError::Missing {
                flag: "--obstacle",
                allowed: "HEIGHTxLENGTH@FRONT in m, as in 0.21x0.21@1.3, or with FROM:TO as FRONT",
            });
        };
        if self.output.format() == Format::Csv {
            let allowed = "text or json";
            return Err(CliError::flag("--format", "csv", allowed));
        }
        if robot.leg.cylinder().is_none() {
            let allowed = "a robot with pneumatic legs, whose supply is drawn";
            return Err(CliError::flag("--robot", &robot.name, allowed));
        }
        match course.fronts() {
            Some(fronts) => self.sensed(&robot, course, fronts),
            None => self.at_one_distance(&robot, course),
        }
    }

    /// Over a box at a known distance.
    fn at_one_distance(&self, robot: &Robot, course: Course) -> Result<Status, CliError> {
        self.learning.refuse()?;
        let obstacle = course.at(course.front);
        let generations = usize::from(self.generations.unwrap_or(GENERATIONS));
        let crossing = Crossing {
            robot: robot.clone(),
            draw: Draw::around(robot),
            obstacle,
            firings: usize::from(self.legs.unwrap_or(LEGS)),
            by_rate: true,
            sought_on: usize::from(self.sought_on.unwrap_or(SOUGHT_ON)),
            generations,
            seed: self.seed.seed,
        };
        let threads = self.threads.count().get();
        let refused = |error| refused(error, robot);
        let progress = Progress::new("generations", generations);
        let plan = crossing
            .plan(threads, |_, _| progress.advance(1))
            .map_err(refused)?;
        drop(progress);
        // Other robots than those of the search.
        let seed = self.seed.seed.wrapping_add(1 << 32);
        let tried = crossing
            .try_on(&plan, usize::from(self.robots), seed, threads)
            .map_err(refused)?;
        let answer = Answer {
            jump: self,
            name: &robot.name,
            obstacle,
            plan: &plan,
            tried: &tried,
        };
        let report = match self.output.format() {
            Format::Json => format!("{:#}\n", answer.json()),
            _ => answer.text(),
        };
        self.output.write_report(report)?;
        Ok(Status::of(answer.share().value() >= ENOUGH))
    }
}

/// A refusal of the library, in the words of the command.
fn refused(error: GaitError, robot: &Robot) -> CliError {
    match error {
        GaitError::Input {
            name,
            value,
            allowed,
        } if name.contains("obstacle") => {
            CliError::flag("--obstacle", format!("({name} = {value})"), allowed)
        }
        error => CliError::content(&robot.name, error),
    }
}

impl Answer<'_> {
    fn share(&self) -> Share {
        Share {
            count: self.tried.iter().filter(|c| c.cleared).count(),
            of: self.tried.len(),
        }
    }

    fn margin(&self) -> Margin {
        let beyond = self.obstacle.front + self.obstacle.length;
        Margin::of(self.tried.iter().map(|crossed| Passage {
            is_over: crossed.travel > beyond,
            clearance: crossed.clearance,
        }))
    }

    fn text(&self) -> String {
        let short = |x: f64| measured(x, 4);
        let Obstacle {
            front,
            length,
            height,
        } = self.obstacle;
        let head = format!(
            "{}: a box {} m high and {} m long, its front {} m from the axle at rest",
            self.name,
            short(height),
            short(length),
            short(front)
        );
        let firing = |(k, [angle, open]): (usize, &[f64; 2])| {
            let how = format!(
                "α_f {} rad, valve open {} ms",
                short(*angle),
                short(open * 1e3)
            );
            (format!("firing {}", k + 1), how)
        };
        let mut lines: Vec<_> = self.plan.first.iter().enumerate().map(firing).collect();
        let leap = &self.plan.leap;
        let how = format!(
            "α_f = {} s · ω + {} rad, valve open {} ms",
            short(leap.slope),
            short(leap.level),
            short(leap.valve_open * 1e3)
        );
        lines.push((format!("firing {}, the jump", lines.len() + 1), how));
        let share = self.share();
        lines.push(("cleared".into(), in_words(&share)));
        lines.extend(self.margin().lines(height, share, ENOUGH));
        output::lines(&head, 18, &lines)
    }

    fn json(&self) -> Value {
        let share = self.share();
        let [low, high] = share.interval();
        let Obstacle {
            front,
            length,
            height,
        } = self.obstacle;
        let first: Vec<Value> = self
            .plan
            .first
            .iter()
            .map(|[angle, open]| json!({"firing_angle_rad": angle, "valve_open_s": open}))
            .collect();
        let leap = &self.plan.leap;
        json!({
            "command": "jump",
            "robot": self.name,
            "obstacle": {"height_m": height, "length_m": length, "front_m": front},
            "first": first,
            "jump": {
                "slope_s": leap.slope,
                "level_rad": leap.level,
                "valve_open_s": leap.valve_open,
            },
            "robots": share.of,
            "cleared": share.count,
            "cleared_share": share.value(),
            "cleared_share_95": [low, high],
            "clearance_m": self.margin().json(),
            "seed": self.jump.seed.seed,
        })
    }
}

/// A box, and where its front may be.
#[derive(Clone, Copy, Debug)]
struct Course {
    height: f64,
    length: f64,
    front: f64,
    /// The farthest front, where the robot is to sense it.
    farthest: Option<f64>,
}

impl Course {
    fn fronts(&self) -> Option<[f64; 2]> {
        self.farthest.map(|farthest| [self.front, farthest])
    }

    fn at(&self, front: f64) -> Obstacle {
        Obstacle {
            front,
            length: self.length,
            height: self.height,
        }
    }
}

/// Parser of a flag.
fn course(text: &str) -> Result<Course, String> {
    let shape = || {
        format!(
            "{:?} must be HEIGHTxLENGTH@FRONT in m, as in 0.21x0.21@1.3, or with FROM:TO as FRONT",
            cut(text)
        )
    };
    let (size, front) = text.split_once('@').ok_or_else(shape)?;
    let (height, length) = size.split_once('x').ok_or_else(shape)?;
    let metres = |part: &str, what: &str, most: f64| {
        let number = quantity::distance(part.trim()).ok();
        number
            .filter(|x| *x > 0.0 && *x <= most)
            .ok_or_else(|| format!("{what} {:?} must be above 0, at most {most} m", cut(part)))
    };
    let (front, farthest) = match front.split_once(':') {
        Some((from, to)) => (from, Some(metres(to, "farthest front", 100.0)?)),
        None => (front, None),
    };
    let front = metres(front, "front", 100.0)?;
    if let Some(to) = farthest.filter(|to| *to < front) {
        return Err(format!(
            "farthest front {to} must be at least the nearest, {front} m"
        ));
    }
    Ok(Course {
        height: metres(height, "height", 10.0)?,
        length: metres(length, "length", 10.0)?,
        front,
        farthest,
    })
}
