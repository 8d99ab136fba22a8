//! Jumps of a robot in space: from rest to a place, the map of such places, and out of a run over a box.

use std::fmt::Write as _;

use clap::Args;
use saltus::Robot;
use saltus::gait::space::DrawnBalls;
use saltus::gait::space::jump::{
    Cycle, Flown, JumpPlan, Leap, ON, Over, Passed, Planner, SPEED, Spot, fly, landed,
};
use saltus::gait::{GaitError, Obstacle};
use saltus::numeric::parallel;
use saltus::running::Share;
use serde_json::{Value, json};

use super::super::Status;
use super::super::run::in_words;
use super::{Course, Jump};
use crate::error::{CliError, cut};
use crate::output::{self, Cell, Format, Table, digits};
use crate::plot::Drawing;
use crate::plot::line::{Line, Mark};
use crate::plot::palette::{BLUE, GREEN, GREY, INK};
use crate::plot::sheet::{Panel, Sheet};
use crate::progress::Progress;
use crate::quantity::{self, Quantity};

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
/// Shares that are enough: of robots that land near, and of those that clear a box.
const ENOUGH: f64 = 0.9;
const ENOUGH_OVER: f64 = 0.8;
/// For how long (s) a robot is followed after it has landed, and the speed (m/s) below which it rests.
const AFTER: f64 = 3.0;
const RESTS: f64 = 0.01;

impl Ball {
    /// Refuses what only a robot in space does.
    pub(super) fn refuse(&self) -> Result<(), CliError> {
        let given = [
            ("--target", self.target.is_some()),
            ("--heading", self.heading.is_some()),
            ("--rest", self.rest.is_some()),
            ("--map", self.map.is_some()),
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
        for (flag, is_given) in [
            ("--legs", self.legs.is_some()),
            ("--constant", self.constant),
        ] {
            if is_given {
                return Err(CliError::flag(flag, "", "used with a robot in its plane"));
            }
        }
        if self.plot.is_set() && self.ball.map.is_none() {
            let allowed = "used with --map for a robot in space";
            return Err(CliError::flag("--plot", "", allowed));
        }
        if self.generations.is_some() && self.obstacle.is_none() {
            let allowed = "used with --obstacle for a robot in space";
            return Err(CliError::flag("--generations", "", allowed));
        }
        match (self.obstacle, self.ball.place(), self.ball.map) {
            (Some(course), None, None) => self.over(robot, course),
            (None, Some(target), None) => self.to(robot, target),
            (None, None, Some(spacing)) => self.map(robot, spacing),
            (None, None, None) => Err(CliError::Missing {
                flag: "--target",
                allowed: "X,Y in m; or --heading with --distance, --map, or --obstacle",
            }),
            (Some(_), ..) => {
                let allowed = "used without --target, --heading and --map for a robot in space";
                Err(CliError::flag("--obstacle", "", allowed))
            }
            _ => {
                let allowed = "used without --target and --heading";
                Err(CliError::flag("--map", "", allowed))
            }
        }
    }

    fn planner(&self, robot: &Robot) -> Result<Planner, CliError> {
        let rest = usize::from(self.ball.rest.unwrap_or(0));
        let sought = (usize::from(self.sought_on.unwrap_or(SOUGHT_ON)), self.seed);
        let draw = DrawnBalls::default();
        let planner = Planner::new(robot, rest, &draw, sought, self.threads.count().get());
        planner.map_err(|error| refused(error, robot))
    }

    /// Seed of other robots than those of the search.
    fn others(&self) -> u64 {
        self.seed.wrapping_add(1 << 32)
    }

    fn to(&self, robot: &Robot, target: [f64; 2]) -> Result<Status, CliError> {
        let threads = self.threads.count().get();
        let planner = self.planner(robot)?;
        let refused = |error| refused(error, robot);
        let plan = planner.to(target, threads).map_err(refused)?;
        let robots = usize::from(self.robots);
        let near = nearby(&planner, &plan, target, (robots, self.others()), threads);
        let near = near.map_err(refused)?;
        let mut cycles = Vec::new();
        let jump = &plan.jump;
        let whole = fly(robot, planner.standing(), jump, AFTER, |cycle| {
            cycles.push(cycle.clone());
        });
        let answer = Answer {
            name: &robot.name,
            rest: usize::from(self.ball.rest.unwrap_or(0)),
            feet: &planner.standing().rest.legs,
            target,
            plan: &plan,
            whole: whole.map_err(refused)?,
            near,
        };
        let report = match self.output.format() {
            Format::Csv => rows(&cycles).csv(),
            Format::Json => output::json(&answer.json(self.seed)),
            Format::Text => answer.text(),
        };
        self.output.write_report(report)?;
        let is_yes = plan.is_reached() && near.value() >= ENOUGH;
        Ok(if is_yes { Status::Done } else { Status::No })
    }

    fn map(&self, robot: &Robot, spacing: f64) -> Result<Status, CliError> {
        self.output.ready(&self.plot)?;
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
            let share = plan
                .is_reached()
                .then(|| nearby(&planner, plan, *target, (robots, self.others()), 1));
            progress.advance(1);
            share.transpose()
        });
        drop(progress);
        let shares: Vec<Option<Share>> = shares
            .into_iter()
            .collect::<Result<_, _>>()
            .map_err(refused)?;
        let map = Map {
            name: &robot.name,
            spacing,
            spots: &spots,
            shares: &shares,
            feet: feet(&planner),
        };
        let report = match self.output.format() {
            Format::Csv => map.table().csv(),
            Format::Json => output::json(&map.json(self.seed)),
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
        let mut over = Over::new(robot, obstacle, farthest, threads).map_err(refused)?;
        over.seed = self.seed;
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
            farthest,
            leap: &leap,
            tried: &tried,
        };
        let report = match self.output.format() {
            Format::Csv => crossed.table().csv(),
            Format::Json => output::json(&crossed.json(self.seed)),
            Format::Text => crossed.text(),
        };
        self.output.write_report(report)?;
        let is_yes = crossed.share(|it| it.cleared).value() >= ENOUGH_OVER;
        Ok(if is_yes { Status::Done } else { Status::No })
    }
}

/// How many other robots land near `target`.
fn nearby(
    planner: &Planner,
    plan: &JumpPlan,
    target: [f64; 2],
    (robots, seed): (usize, u64),
    threads: usize,
) -> Result<Share, GaitError> {
    let all = parallel::map_on(threads, robots, |k| planner.other(plan, seed, k));
    let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
    let is_near = |flown: &&Flown| {
        landed(flown).is_some_and(|[x, y]| (x - target[0]).hypot(y - target[1]) <= NEAR)
    };
    Ok(Share {
        count: all.iter().filter(is_near).count(),
        of: robots,
    })
}

/// Where the feet stand (m).
fn feet(planner: &Planner) -> Vec<(f64, f64)> {
    let feet = planner.feet_places();
    feet.into_iter().map(|[x, y]| (x, y)).collect()
}

/// A jump to a place.
struct Answer<'a> {
    name: &'a str,
    rest: usize,
    feet: &'a [usize],
    target: [f64; 2],
    plan: &'a JumpPlan,
    whole: Flown,
    near: Share,
}

impl Answer<'_> {
    fn text(&self) -> String {
        let [x, y] = self.target.map(short);
        let feet: Vec<String> = self.feet.iter().map(ToString::to_string).collect();
        let feet = feet.join(", ");
        let mut text = format!(
            "{}: a jump from rest {} on feet {feet} to ({x}, {y}) m\n",
            self.name, self.rest
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        for (k, command) in self.plan.jump.commands.iter().enumerate() {
            let name = format!("firing {}", k + 1);
            let at = digits(1e3 * command.at, 4);
            let open = digits(1e3 * command.open, 4);
            line(
                &name,
                format!(
                    "leg {} at {at} ms, valve open for at most {open} ms",
                    command.leg
                ),
            );
        }
        for (name, touch) in [
            ("lands by the model", self.plan.modelled),
            ("lands in the simulation", self.plan.flown.touch),
        ] {
            let what = touch.map_or_else(
                || "it does not come off the ground".into(),
                |touch| {
                    let [x, y, _] = touch.place.map(short);
                    let time = digits(touch.time, 4);
                    let apex = digits(touch.apex, 4);
                    format!("({x}, {y}) m after {time} s, at most {apex} m high")
                },
            );
            line(name, what);
        }
        line("then", self.after());
        let reach = if self.plan.is_reached() {
            "yes".into()
        } else {
            let nearest = match landed(&self.plan.flown) {
                Some([x, y]) => format!("({}, {}) m", short(x), short(y)),
                None => "where it stands".into(),
            };
            format!("no; the nearest landing that was found is {nearest}")
        };
        line("in reach", reach);
        let near = format!("within {} cm", digits(100.0 * NEAR, 3));
        line(&near, format!("{}, other robots", in_words(&self.near)));
        text
    }

    /// What it does after the landing, in words.
    fn after(&self) -> String {
        let [x, y, _] = self.whole.rests.map(short);
        if self.whole.speed < RESTS {
            format!("it comes to rest at ({x}, {y}) m")
        } else {
            let speed = digits(self.whole.speed, 3);
            format!("after {AFTER} s it is at ({x}, {y}) m and moves at {speed} m/s")
        }
    }

    fn json(&self, seed: u64) -> Value {
        json!({
            "command": "jump",
            "robot": self.name,
            "rest": self.rest,
            "feet": self.feet,
            "target_m": self.target,
            "firings": self.plan.jump.commands.iter().map(|command| json!({
                "leg": command.leg, "at_s": command.at, "valve_open_s": command.open,
            })).collect::<Vec<_>>(),
            "aim_m": self.plan.jump.guide.as_ref().map(|guide| guide.aim),
            "modelled_m": self.plan.modelled.map(|touch| touch.place),
            "landed_m": self.plan.flown.touch.map(|touch| touch.place),
            "landed_s": self.plan.flown.touch.map(|touch| touch.time),
            "apex_m": self.plan.flown.touch.map(|touch| touch.apex),
            "miss_m": finite(self.plan.miss),
            "is_reached": self.plan.is_reached(),
            "mean_off_m": self.plan.off,
            "in_the_end_m": self.whole.rests,
            "speed_in_the_end_m_s": self.whole.speed,
            "within_10_cm": share(&self.near),
            "seed": seed,
        })
    }
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn share(share: &Share) -> Value {
    json!({ "count": share.count, "of": share.of, "share": share.value(), "interval_95": share.interval() })
}

/// The cycles of a jump.
fn rows(cycles: &[Cycle]) -> Table {
    let mut table = Table::new(&[
        "time_s",
        "x_m",
        "y_m",
        "z_m",
        "quaternion_w",
        "quaternion_x",
        "quaternion_y",
        "quaternion_z",
        "vx_m_s",
        "vy_m_s",
        "vz_m_s",
        "spin_x_rad_s",
        "spin_y_rad_s",
        "spin_z_rad_s",
        "feet_on_ground",
    ]);
    for cycle in cycles {
        let moves = cycle.velocity.iter().chain(&cycle.spin);
        let numbers = cycle.place.iter().chain(&cycle.attitude).chain(moves);
        let mut row: Vec<Cell> = vec![cycle.time.into()];
        row.extend(numbers.map(|x| Cell::from(*x)));
        row.push(Cell::Count(cycle.touching.count_ones() as usize));
        table.push(row);
    }
    table
}

/// The map of places.
struct Map<'a> {
    name: &'a str,
    spacing: f64,
    spots: &'a [Spot],
    shares: &'a [Option<Share>],
    feet: Vec<(f64, f64)>,
}

impl Map<'_> {
    /// All jumps to places that are reached.
    fn together(&self) -> Share {
        let all = || self.shares.iter().flatten();
        Share {
            count: all().map(|share| share.count).sum(),
            of: all().map(|share| share.of).sum(),
        }
    }

    fn reached(&self) -> impl Iterator<Item = (&Spot, &Share)> {
        let both = self.spots.iter().zip(self.shares);
        both.filter_map(|(spot, share)| Some((spot, share.as_ref()?)))
    }

    fn text(&self) -> String {
        let mut text = format!(
            "{}: landing places from rest, {} m apart\n",
            self.name,
            digits(self.spacing, 4)
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        let count = self.reached().count();
        line(
            "in reach",
            format!("{count} of {} places", self.spots.len()),
        );
        let far = |spot: &Spot| spot.target[0].hypot(spot.target[1]);
        let farthest = self
            .reached()
            .map(|(spot, _)| far(spot))
            .fold(0.0, f64::max);
        line("farthest", format!("{} m", digits(farthest, 4)));
        line("jumps within 10 cm", in_words(&self.together()));
        let enough = self.reached().filter(|(_, share)| share.value() >= ENOUGH);
        line("places with 90 %", format!("{} of {count}", enough.count()));
        let least = self
            .reached()
            .min_by(|a, b| a.1.value().total_cmp(&b.1.value()));
        if let Some((spot, share)) = least {
            let [x, y] = spot.target.map(short);
            line("least", format!("{} at ({x}, {y}) m", in_words(share)));
        }
        text
    }

    fn table(&self) -> Table {
        let mut table = Table::new(&[
            "x_m",
            "y_m",
            "is_reached",
            "mean_off_m",
            "miss_m",
            "within_10_cm",
            "of",
            "apex_m",
            "flight_s",
            "firings",
        ]);
        for (spot, share) in self.spots.iter().zip(self.shares) {
            let plan = &spot.plan;
            let firing = |command: &saltus::gait::space::jump::Command| {
                let at = digits(1e3 * command.at, 4);
                format!("{}@{at}ms:{}ms", command.leg, digits(1e3 * command.open, 4))
            };
            let firings: Vec<String> = plan.jump.commands.iter().map(firing).collect();
            let lift = plan.flown.lift.map(|lift| lift.time);
            let touch = plan.flown.touch;
            let flight = lift.zip(touch).map(|(lift, touch)| touch.time - lift);
            let count = |of: fn(&Share) -> usize| {
                share.as_ref().map_or(Cell::Empty, |it| Cell::Count(of(it)))
            };
            table.push(vec![
                spot.target[0].into(),
                spot.target[1].into(),
                Cell::Flag(plan.is_reached()),
                plan.off.into(),
                plan.miss.into(),
                count(|share| share.count),
                count(|share| share.of),
                touch.map(|touch| touch.apex).into(),
                flight.into(),
                Cell::Text(firings.join(" ")),
            ]);
        }
        table
    }

    fn json(&self, seed: u64) -> Value {
        json!({
            "command": "jump",
            "robot": self.name,
            "spacing_m": self.spacing,
            "reached": self.reached().count(),
            "within_10_cm": share(&self.together()),
            "places": self.table().json(),
            "seed": seed,
        })
    }

    fn drawing(&self) -> Drawing {
        let of = |keeps: &dyn Fn(&Option<Share>) -> bool| {
            let both = self.spots.iter().zip(self.shares);
            let kept = both.filter(|(_, share)| keeps(share));
            kept.map(|(spot, _)| (spot.target[0], spot.target[1]))
                .collect::<Vec<_>>()
        };
        let enough = |share: &Share| share.value() >= ENOUGH;
        let dots = |label: &str, points, color| Line {
            label: Some(label.into()),
            points,
            color,
            mark: Mark::Dots,
        };
        let lines = vec![
            dots(
                "90 of 100 robots land within 10 cm",
                of(&|it| it.as_ref().is_some_and(enough)),
                GREEN,
            ),
            dots(
                "fewer do",
                of(&|it| it.as_ref().is_some_and(|it| !enough(it))),
                BLUE,
            ),
            dots("out of reach", of(&Option::is_none), GREY),
            dots("feet at rest", self.feet.clone(), INK),
        ];
        let high = |(spot, _): (&Spot, &Share)| {
            let apex = spot.plan.flown.touch.map(|touch| touch.apex)?;
            Some((spot.target[0].hypot(spot.target[1]), apex))
        };
        let heights = self.reached().filter_map(high).collect();
        let heights = vec![dots("jumps to places in reach", heights, BLUE)];
        Drawing::Sheet(Sheet {
            title: format!("{}: where it lands from rest", self.name),
            course: None,
            panels: vec![
                Panel {
                    title: "landing of the middle".into(),
                    x: "ahead (m)",
                    y: "to the left (m)",
                    lines,
                    least: None,
                },
                Panel {
                    title: "greatest height on the way".into(),
                    x: "distance (m)",
                    y: "height of the middle (m)",
                    lines: heights,
                    least: None,
                },
            ],
        })
    }
}

/// Robots that ran up to a box.
struct Crossings<'a> {
    name: &'a str,
    obstacle: Obstacle,
    farthest: f64,
    leap: &'a Leap,
    tried: &'a [Passed],
}

impl Crossings<'_> {
    fn share(&self, did: impl Fn(&Passed) -> bool) -> Share {
        Share {
            count: self.tried.iter().filter(|it| did(it)).count(),
            of: self.tried.len(),
        }
    }

    fn text(&self) -> String {
        let Obstacle {
            front,
            length,
            height,
        } = self.obstacle;
        let mut text = format!(
            "{}: out of a run over a box {} m high and {} m long, its front {} to {} m from the middle at rest\n",
            self.name,
            digits(height, 4),
            digits(length, 4),
            digits(front, 4),
            digits(self.farthest, 4)
        );
        let mut line = |name: &str, what: String| {
            let _ = writeln!(text, "  {name:<24} {what}");
        };
        let leap = self.leap;
        let short = |x: f64| digits(x, 3);
        line(
            "first push",
            format!("so that twins come down {} m before it", short(leap.aim)),
        );
        line("rate of the run-up", format!("{} rad/s", short(leap.rate)));
        let [earlier, later] = leap.by_speed.map(short);
        line(
            "twins jump",
            format!(
                "from {} m before it on, for {} ms",
                short(leap.from),
                short(1e3 * leap.open)
            ),
        );
        line(
            "at a lean of",
            format!(
                "{} rad, and {} rad more for each m nearer",
                short(leap.lean),
                short(leap.nearer)
            ),
        );
        line(
            &format!("for each m/s above {SPEED}"),
            format!("{earlier} m earlier, {later} rad more"),
        );
        line("cleared", in_words(&self.share(|it| it.cleared)));
        line(
            "did not jump",
            in_words(&self.share(|it| it.jumped.is_none())),
        );
        let on = digits(ON, 3);
        line(
            &format!("went on for {on} m"),
            in_words(&self.share(|it| it.ran_on)),
        );
        let mut apexes: Vec<f64> = self.tried.iter().map(|it| it.apex).collect();
        let apex = saltus::numeric::statistics::median(&mut apexes);
        line("median of the height", format!("{} m", digits(apex, 3)));
        text
    }

    fn table(&self) -> Table {
        let mut table = Table::new(&[
            "robot",
            "front_m",
            "first_valve_open_s",
            "jumped_at_m",
            "speed_m_s",
            "clearance_m",
            "apex_m",
            "cleared",
            "ran_on",
        ]);
        for (k, it) in self.tried.iter().enumerate() {
            table.push(vec![
                Cell::Count(k),
                it.front.into(),
                it.first.into(),
                it.jumped.into(),
                it.speed.into(),
                it.clearance.into(),
                it.apex.into(),
                Cell::Flag(it.cleared),
                Cell::Flag(it.ran_on),
            ]);
        }
        table
    }

    fn json(&self, seed: u64) -> Value {
        let Obstacle {
            front,
            length,
            height,
        } = self.obstacle;
        let leap = self.leap;
        json!({
            "command": "jump",
            "robot": self.name,
            "obstacle": {"height_m": height, "length_m": length, "fronts_m": [front, self.farthest]},
            "aim_m": leap.aim,
            "from_m": leap.from,
            "lean_rad": leap.lean,
            "lean_by_distance_rad_m": leap.nearer,
            "valve_open_s": leap.open,
            "from_by_speed_s": leap.by_speed[0],
            "lean_by_speed_rad_s_m": leap.by_speed[1],
            "rate_rad_s": leap.rate,
            "cleared": share(&self.share(|it| it.cleared)),
            "ran_on": share(&self.share(|it| it.ran_on)),
            "robots": self.table().json(),
            "seed": seed,
        })
    }
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
